"""A result in other programs: tables, arrays, labelled arrays, moving pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from directrix.exports.files import to_csv, to_mat, to_npz, to_xlsx
from directrix.exports.gltf import to_gltf
from directrix.exports.labelled import to_pandas, to_xarray
from directrix.exports.scene import to_pyvista
from directrix.exports.tables import TABLES, table
from directrix.result import Result

__all__ = [
    "FORMATS", "TABLES", "table", "to_csv", "to_gltf", "to_mat", "to_npz", "to_pandas", "to_pyvista", "to_xarray",
    "to_xlsx",
]  # fmt: skip

FORMATS: Mapping[str, tuple[Callable[[Result, Path], str], str]] = {
    "csv": (to_csv, "-csv"),
    "npz": (to_npz, ".npz"),
    "mat": (to_mat, ".mat"),
    "gltf": (to_gltf, ".glb"),
    "xlsx": (to_xlsx, ".xlsx"),
}
"""What ``directrix export`` can write, by what, and what it puts behind the name of the result."""
