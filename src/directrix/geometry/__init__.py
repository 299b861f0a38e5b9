"""Geometry from elsewhere: centrelines, graphs, line meshes and drawings, each with a report of what was snapped."""

from directrix.geometry.drawing import from_dxf
from directrix.geometry.graph import from_graph
from directrix.geometry.lines import from_mesh
from directrix.geometry.pieces import Piece, assemble
from directrix.geometry.tables import Centreline, centreline

__all__ = ["Centreline", "Piece", "assemble", "centreline", "from_dxf", "from_graph", "from_mesh"]
