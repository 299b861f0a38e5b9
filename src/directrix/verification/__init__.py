"""Published and computed reference values, and what this installation makes of them: ``directrix verify``.

One file a problem. A case is a plain function that yields rows (:class:`~directrix.verification.record.Check`);
a number stands here once, with its source and how it came here.
"""
