"""Runs that can be gone on with: a folder with the input, segments of the result and checkpoints."""

from directrix.keeping.folder import Folder, RunFolder, Source
from directrix.keeping.keeper import Keeper, fingerprint
from directrix.keeping.many import Many
from directrix.keeping.memory import recall, remember

__all__ = ["Folder", "Keeper", "Many", "RunFolder", "Source", "fingerprint", "recall", "remember"]
