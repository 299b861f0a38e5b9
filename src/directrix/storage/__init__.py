"""Results on disk: one HDF5 file, exact for :func:`load` and readable by ParaView."""

from directrix.storage.vtkhdf import load, save

__all__ = ["load", "save"]
