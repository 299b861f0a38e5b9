"""Settings of all tests: hypothesis repeats the same cases everywhere and has no deadline (kernels compile once)."""

from hypothesis import settings

settings.register_profile("directrix", deadline=None, derandomize=True)
settings.load_profile("directrix")
