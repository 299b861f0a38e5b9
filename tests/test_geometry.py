"""Geometry from files, graphs and rules: what is read, what is snapped and said, what is refused."""

from __future__ import annotations

import json
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

import directrix as dx
from directrix import generate
from directrix.curves import Arc, lines
from directrix.geometry.pieces import NearMissWarning

SECTION = dx.Section.circle(radius=0.01, E=1e9, nu=0.3, rho=1000.0)
OTHER = dx.Section.circle(radius=0.02, E=1e9, nu=0.3, rho=1000.0)


def helix(t: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(t), np.sin(t), 0.3 * t], -1)


def places(model: dx.Model) -> dict[str, np.ndarray]:
    return {
        name: rod.curve.position(f * rod.curve.length)
        for rod in model.rods
        for name, f in zip(rod.ends, (0.0, 1.0), strict=True)
    }


def said(model: dx.Model) -> str:
    return "\n".join(model.imported)


# --- centrelines


def test_a_centreline_goes_through_its_points_by_header_and_by_position(tmp_path: Path) -> None:
    points = helix(np.linspace(0.0, 6.0, 40))
    path = tmp_path / "line.csv"
    rows = "\n".join(f"{k};{z};{x};{y}" for k, (x, y, z) in enumerate(points * 1e3))
    path.write_text(f"# measured\nstation;Z [mm];X [mm];Y [mm]\n{rows}\n")
    named = dx.centreline(path)
    path.write_text("\n".join(" ".join(map(str, p)) for p in points))
    bare = dx.centreline(str(path), columns=(0, 1, 2))
    for curve in (named, bare):
        np.testing.assert_allclose(np.array(curve.points), points, atol=1e-12)
        assert curve.length == pytest.approx(6.0 * np.hypot(1.0, 0.3), rel=1e-5)
        assert curve.deviation == 0.0 and curve.count == 40


def test_smoothing_keeps_the_distance_that_it_is_given_and_says_it() -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 6.0, 120)
    noisy = helix(t) + 0.004 * rng.uniform(-1.0, 1.0, (120, 3))
    rough, smooth = dx.centreline(noisy), dx.centreline(noisy, smoothing=0.008)
    s = np.linspace(0.0, smooth.length, 40001)
    gaps = KDTree(smooth.position(s)).query(noisy)[0]
    assert gaps.max() <= 0.008 * (1.0 + 1e-4) and smooth.deviation == pytest.approx(gaps.max(), rel=1e-4)
    bends = [np.abs(np.diff(c.frames(u, u)[:, :, 2], axis=0)).sum() for c in (rough, smooth) for u in [s[::400]]]
    assert bends[1] < 0.7 * bends[0] and len(smooth.points) < 60


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("x,y,z\n0,0,0\n1,0,0\n1,0,0\n2,0,0\n", 4, "same as the one before"),
        ("x,y,z\n0,0,0\n1,0,nan\n2,0,0\n", 3, "not finite"),
        ("x,y,z\n0,0,0\n1,0,zero\n2,0,0\n", 3, "is not a number"),
        ("x,y,z\n0,0,0\n2,0,0\n1,0.1,0\n3,0,0\n", 3, "turns back"),
        ("x,y,z,s\n0,0,0,0\n1,0,0,2\n2,0,0,1\n", 4, "does not rise"),
        ("x,y,z\n0,0,0\n1,0\n2,0,0\n", 3, "2 columns"),
        ("x,y,w\n0,0,0\n1,0,0\n2,0,0\n", 1, "lacks one of"),
    ],
)
def test_rows_that_cannot_be_are_refused_with_file_and_line(tmp_path: Path, text: str, line: int, words: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(dx.InputError, match=words) as error:
        dx.centreline(path)
    assert error.value.where == f"{path}:{line}"


# --- graphs


def test_a_graph_becomes_rods_with_its_attributes() -> None:
    nx = pytest.importorskip("networkx")
    graph = nx.Graph()
    for k, at in enumerate([(0, 0), (1, 0), (1, 1, 0.5)]):
        graph.add_node(k, pos=at)
    graph.add_edge(0, 1, section="thick", elements=3)
    graph.add_edge(1, 2, name="bent", curve=[(1.2, 0.5, 0.2)])
    graph.add_edge(2, 0)
    model = dx.from_graph(graph, section={"thick": OTHER, None: SECTION}, elements=2, order=1)
    rods = {rod.name: rod for rod in model.rods}
    assert list(rods) == ["0-1", "0-2", "bent"]
    assert rods["0-1"].section == OTHER and rods["0-1"].elements == 3 and rods["0-2"].elements == 2
    assert rods["bent"].section == SECTION and rods["bent"].order == 1
    assert rods["bent"].curve.length > np.linalg.norm([0, 1, 0.5])
    np.testing.assert_allclose(places(model)["2"], [1, 1, 0.5])
    more = dx.Model().rod(dx.line((0, 0, 0), (0, 0, 1)), SECTION, name="post", ends=("0", "top"))
    assert len(more.graph(graph, {"thick": OTHER, None: SECTION}).rods) == 4
    for change, words in (
        ({"pos": "where"}, "has no 'where'"),
        ({"section": None}, "has no section"),
        ({"section": {"thin": SECTION}}, "there is no section"),
    ):
        with pytest.raises(dx.ModelError, match=words):
            dx.from_graph(graph, **{"section": {"thick": OTHER, None: SECTION}, **change})
    graph.add_edge(0, 1, elemets=3)
    with pytest.raises(dx.ModelError, match="elemets"):
        dx.from_graph(graph, section={"thick": OTHER, None: SECTION})


@pytest.mark.parametrize("ending", ["graphml", "gml", "json"])
def test_a_file_of_a_graph_is_the_graph(ending: str, tmp_path: Path) -> None:
    nx = pytest.importorskip("networkx")
    from directrix.schema.load import load_case

    graph = nx.Graph()
    for name, at in {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0), "c": (1.0, 2.0, 0.5)}.items():
        graph.add_node(name, **dict(zip("xyz", at, strict=True)))
    graph.add_edge("a", "b", section="thick", elements=3)
    graph.add_edge("b", "c")
    path = tmp_path / f"frame.{ending}"
    match ending:
        case "graphml":
            nx.write_graphml(graph, path)
        case "gml":
            nx.write_gml(graph, path)
        case _:
            path.write_text(json.dumps(nx.node_link_data(graph)))
    model = dx.from_graph(path, section={"thick": OTHER, None: SECTION}, scale=0.5, elements=2)
    assert [(rod.name, rod.section, rod.elements) for rod in model.rods] == [("a-b", OTHER, 3), ("b-c", SECTION, 2)]
    np.testing.assert_allclose(places(model)["c"], [0.5, 1.0, 0.25])
    (tmp_path / "case.toml").write_text(
        f"""
        section.thick = {{ kind = "circle", radius = 0.02, E = 1e9, nu = 0.3 }}
        section.thin = {{ kind = "circle", radius = 0.01, E = 1e9, nu = 0.3 }}
        geometry = [{{ kind = "graph", file = "{path.name}", section = "thin", elements = 2 }}]
        support = [{{ node = "a", type = "clamp" }}]
        statics = {{}}
        """
    )
    said = load_case(tmp_path / "case.toml").model.rods
    thick, thin = (dx.Section.circle(radius=r, E=1e9, nu=0.3) for r in (0.02, 0.01))
    assert [(rod.name, rod.section, rod.elements) for rod in said] == [("a-b", thick, 3), ("b-c", thin, 2)]
    path.write_text("{")
    with pytest.raises(dx.InputError, match="no graph that networkx reads"):
        dx.from_graph(path, section=SECTION)
    with pytest.raises(dx.InputError, match="by its ending"):
        dx.from_graph(tmp_path / "frame.txt", section=SECTION)
    with pytest.raises(dx.InputError, match="cannot be read"):
        dx.from_graph(tmp_path / f"none.{ending}", section=SECTION)


# --- meshes


def test_chains_of_line_cells_become_rods_and_groups_their_sections(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    # a T: along x in four cells, up from its middle in two, and a closed triangle apart
    points = [[x, 0, 0] for x in range(5)] + [[2, 0, 1], [2, 0, 2]] + [[9, 0, 0], [10, 0, 0], [9, 1, 0]]
    cells = [("line", np.array([[0, 1], [2, 1], [2, 3], [3, 4], [2, 5], [5, 6], [7, 8], [8, 9], [9, 7]]))]
    tags = [np.array([1, 1, 1, 1, 2, 2, 1, 1, 1])]
    path = tmp_path / "tee.vtk"
    meshio.Mesh(np.array(points, float), cells, cell_data={"region": tags}).write(path)
    model = dx.from_mesh(path, {1: SECTION, 2: OTHER}, scale=0.5)
    rods = {rod.name: rod for rod in model.rods}
    assert sorted(rods) == ["1.1", "1.2", "1.3", "1.4", "2.1"]
    assert rods["2.1"].section == OTHER and set(rods["2.1"].ends) == {"p2", "p6"}
    assert {frozenset(rods[f"1.{k}"].ends) for k in (1, 2)} == {frozenset(("p0", "p2")), frozenset(("p2", "p4"))}
    assert sum(rod.curve.length for rod in rods.values()) == pytest.approx(0.5 * (4 + 2 + 2 + 2**0.5))
    assert rods["1.1"].elements == 2 and not model.imported
    with pytest.raises(dx.ModelError, match="is of 2, for which there is no section"):
        dx.from_mesh(path, {1: SECTION})


def test_quadratic_cells_are_curved_and_physical_groups_name_rods_and_nodes(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    angle = np.linspace(0.0, np.pi / 2, 5)
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    mesh = meshio.Mesh(
        points, [("vertex", np.array([[0]])), ("line3", np.array([[0, 2, 1], [4, 2, 3]]))],
        cell_data={"gmsh:physical": [np.array([7]), np.array([3, 3])], "gmsh:geometrical": [np.array([1]),
        np.array([1, 1])]}, field_data={"root": np.array([7, 0]), "bow": np.array([3, 1])},
    )  # fmt: skip
    path = tmp_path / "bow.msh"
    mesh.write(path, file_format="gmsh22", binary=False)
    (rod,) = dx.from_mesh(path, {"bow": SECTION}).rods
    assert rod.name == "bow.1" and rod.ends == ("root", "p4") and rod.elements == 2
    assert rod.curve.length == pytest.approx(np.pi / 2, rel=2e-3)


# --- drawings


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new()
    space = document.modelspace()
    document.header["$INSUNITS"] = 4
    space.add_line((0, 0, 0), (100, 0, 0), dxfattribs={"layer": "frame"})
    space.add_line((100.0004, 0, 0), (100, 50, 0), dxfattribs={"layer": "frame"})  # snapped
    space.add_line((100.02, 50, 0), (200, 50, 0), dxfattribs={"layer": "frame"})  # nearly
    space.add_arc((0, 50, 0), 50, -90, 90, dxfattribs={"layer": "bows"})
    space.add_circle((300, 0, 0), 10, dxfattribs={"layer": "bows"})
    space.add_lwpolyline([(0, 200, 1.0), (20, 200, 0), (20, 240, 0), (50, 240, 0)], format="xyb",
                         dxfattribs={"layer": "bows"})  # fmt: skip
    space.add_spline([(0, 300, 0), (30, 320, 5), (60, 290, 0), (90, 300, 0)], dxfattribs={"layer": "bows"})
    space.add_text("not a rod", dxfattribs={"layer": "frame"})
    path = tmp_path / "drawing.dxf"
    document.saveas(path)
    return path


def test_a_drawing_is_read_and_all_snapping_is_said(drawing: Path) -> None:
    with pytest.warns(NearMissWarning, match=r"nodes 'n3' and 'n4' are 2e-05 apart and were not joined"):
        model = dx.from_dxf(drawing, {"frame": SECTION, "bows": OTHER}, scale=1e-3, snap=5e-6)
    rods = {rod.name: rod for rod in model.rods}
    assert sorted(rods) == [f"bows.{k}" for k in range(1, 7)] + [f"frame.{k}" for k in (1, 2, 3)]
    assert rods["frame.1"].ends[1] == rods["frame.2"].ends[0] == "n2"
    assert rods["frame.2"].ends[1] != rods["frame.3"].ends[0]
    assert "rod 'frame.2': its first end moved by 4e-07 onto node 'n2'" in said(model)
    assert "millimetres" in said(model) and "left out: 1 TEXT on layer 'frame'" in said(model)
    assert "not joined" in "\n".join(model.notes())
    assert rods["bows.1"].curve.length == pytest.approx(0.05 * np.pi) and rods["bows.1"].ends[0] == "n1"
    ring = [rods["bows.2"], rods["bows.3"]]
    assert all(isinstance(rod.curve, Arc) for rod in ring) and set(ring[0].ends) == set(ring[1].ends)
    assert rods["bows.4"].curve.length == pytest.approx(0.01 * np.pi)  # a bulge of 1 is half a circle
    assert rods["bows.5"].curve.length == pytest.approx(0.07)
    assert rods["bows.4"].ends[1] == rods["bows.5"].ends[0]
    assert "rod 'bows.6': a spline within" in said(model)
    np.testing.assert_allclose(places(model)[rods["bows.6"].ends[1]], [0.09, 0.3, 0.0], atol=1e-12)


def test_ends_on_corners_split_and_ends_on_straight_parts_are_warned_of() -> None:
    from directrix.geometry import Piece, assemble

    bent = Piece(dx.polyline([(0, 0, 0), (1, 0, 0), (1, 1, 0)]), SECTION, "bent", options={"elements": 8})
    corner = Piece(dx.line((1, 0, 0), (2, 0, 0)), SECTION, "corner")
    touching = Piece(dx.line((0.5, 0, 0), (0.5, 0, 1)), SECTION, "touching")
    with pytest.warns(NearMissWarning, match=r"lies on rod 'bent.1' between its ends"):
        model = assemble([bent, corner, touching])
    rods = {rod.name: rod for rod in model.rods}
    assert rods["bent.1"].ends[1] == rods["bent.2"].ends[0] == rods["corner"].ends[0]
    assert rods["bent.1"].elements == rods["bent.2"].elements == 4
    assert "split at 1 of its corners" in said(model)
    with pytest.raises(dx.ModelError, match="both ends of rod"):
        assemble([corner], snap=2.0)


def test_what_is_no_file_or_not_installed_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    junk = tmp_path / "junk.dxf"
    junk.write_text("nothing")
    with pytest.raises(dx.ModelError, match="is not a DXF file"):
        dx.from_dxf(junk, SECTION)
    with pytest.raises(dx.ModelError, match="cannot be read"):
        dx.from_mesh(tmp_path / "none.msh", SECTION)
    import builtins

    real = builtins.__import__

    def absent(name: str, *rest: object, **options: object) -> object:
        if name.split(".")[0] in ("ezdxf", "meshio"):
            raise ImportError(name)
        return real(name, *rest, **options)

    import importlib

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(dx.ModelError, match=r"pip install 'directrix\[geometry\]'"):
        dx.from_dxf(junk, SECTION)


# --- by rule


def test_many_lines_at_once_are_each_the_line_of_its_points() -> None:
    a, b = np.random.default_rng(0).standard_normal((2, 30, 3))
    a[:3], b[:3] = 0.0, np.eye(3)
    for many, p, q in zip(lines(a, b), a, b, strict=True):
        one = dx.line(p, q)
        assert many == one and np.array_equal(many.frames(0.0, 0.0), one.frames(0.0, 0.0))
        assert many.length == one.length
    with pytest.raises(dx.ModelError, match="of line 1 are the same"):
        lines([[0, 0, 0], [1, 1, 1]], [[1, 0, 0], [1, 1, 1]])


def test_lattices_have_the_nodes_and_struts_that_they_should() -> None:
    cubic = generate.cubic((2, 3, 1), 0.5, SECTION, elements=2, order=1)
    assert len(cubic.rods) == 2 * 4 * 2 + 3 * 3 * 2 + 3 * 4 * 1 and len(places(cubic)) == 3 * 4 * 2
    np.testing.assert_allclose(places(cubic)["2.3.1"], [1.0, 1.5, 0.5])
    octet = generate.octet((2, 2, 2), 1.0, SECTION)
    assert len(octet.rods) == 24 * 8 + 4 * 24 // 2  # a strut on the outside belongs to one cell, not to two
    degree: dict[str, int] = {}
    for rod in octet.rods:
        assert rod.curve.length == pytest.approx(0.5**0.5)
        for end in rod.ends:
            degree[end] = degree.get(end, 0) + 1
    assert degree["2.2.2"] == 12 and degree["0.0.0"] == 3 and len(degree) == 63
    flat = generate.grid((3, 2), (1.0, 2.0), SECTION)
    assert len(flat.rods) == 3 * 3 + 4 * 2 and "1.1-2.1" in [rod.name for rod in flat.rods]
    assert generate.cubic((2, 3, 1), 0.5, SECTION, elements=2, order=1) == cubic


def test_a_ring_closes_and_a_spring_has_its_coils() -> None:
    circle = generate.ring(2.0, SECTION, parts=3, normal=(0, 1, 0), centre=(1, 0, 0))
    assert sum(rod.curve.length for rod in circle.rods) == pytest.approx(4.0 * np.pi)
    assert [rod.ends for rod in circle.rods] == [("0", "1"), ("1", "2"), ("2", "0")]
    circle.check(meshed=False)
    wound = generate.spring(0.1, 0.06, 4.0, SECTION, end_coils=1.0, seats=True)
    (wire,) = wound.rods
    top = wire.curve.position(wire.curve.length)
    assert top[2] == pytest.approx(4 * 0.06 + 2 * 0.02, rel=1e-6) and wire.elements == 72
    named = dict(wire.nodes)
    start, end = (wire.curve.position(named[k] * wire.curve.length)[2] for k in ("active.start", "active.end"))
    assert end - start == pytest.approx(4 * 0.06, rel=0.02)
    left = generate.spring(0.1, 0.06, -1.25, SECTION)
    np.testing.assert_allclose(left.rods[0].curve.position(left.rods[0].curve.length), [0, -0.1, 0.075], atol=1e-5)
    with pytest.raises(dx.ModelError, match="need the diameter"):
        generate.spring(0.1, 0.06, 4.0, dx.Section.rectangle(0.01, 0.02, E=1, nu=0), end_coils=1.0)


def test_yarns_of_a_weave_pass_over_and_under() -> None:
    cloth = generate.weave((2, 2), 1.0, SECTION, amplitude=0.05)
    rods = {rod.name: rod for rod in cloth.rods}
    for i in range(2):
        for j in range(2):
            warp, weft = (
                rods[kind].curve.position(dict(rods[kind].nodes)[node] * rods[kind].curve.length)
                for kind, node in ((f"warp{i}", f"warp{i}.{j}"), (f"weft{j}", f"weft{j}.{i}"))
            )
            np.testing.assert_allclose(warp[:2], [i + 0.5, j + 0.5], atol=2e-3)
            np.testing.assert_allclose(warp[:2], weft[:2], atol=2e-3)
            assert (-1) ** (i + j) * (warp - weft)[2] == pytest.approx(0.1, rel=1e-2)


def test_a_catenary_is_the_curve_of_its_equation() -> None:
    curve = dx.catenary((1, 0, 2), (4, 4, 3), length=7.0)
    s = np.linspace(0.0, 7.0, 2001)
    r = curve.position(s)
    np.testing.assert_allclose(r[[0, -1]], [[1, 0, 2], [4, 4, 3]], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(np.diff(r, axis=0), axis=1), 7.0 / 2000, rtol=1e-6)
    x, c = np.linalg.norm(r[:, :2] - r[0, :2], axis=1), curve.parameter
    low = x[np.argmin(r[:, 2])]
    lowest = low - c * np.arcsinh((curve._lowest + s[np.argmin(r[:, 2])]) / c)
    np.testing.assert_allclose(np.diff(r[:, 2]), np.diff(c * np.cosh((x - lowest) / c)), atol=1e-9)
    F = curve.frames(s, s)
    np.testing.assert_allclose(F.transpose(0, 2, 1) @ F, np.broadcast_to(np.eye(3), F.shape), atol=1e-12)
    middle = np.diff(r, axis=0) / np.diff(s)[:, None]
    np.testing.assert_allclose(curve.frames(s[:-1] + 7.0 / 4000, s[:-1])[:, :, 2], middle, atol=1e-5)
    for a, b in pairwise(F[::200]):  # never turns about the tangent
        assert abs(np.cross(a[:, 2], b[:, 2]) @ (a[:, 0] - b[:, 0])) <= 0.5
    for given, words in (
        ({"start": (0, 0, 0), "end": (1, 0, 0), "length": 0.9}, "does not hang"),
        ({"start": (0, 0, 0), "end": (0, 0, 1), "length": 2.0}, "above the other"),
    ):
        with pytest.raises(dx.ModelError, match=words):
            dx.catenary(**given)


# --- case files


def test_a_case_says_all_of_it(tmp_path: Path, drawing: Path) -> None:
    from directrix.schema.load import load_case

    (tmp_path / "line.csv").write_text("x,y,z\n0,0,5\n1,0,5\n2,0.5,5\n")
    (tmp_path / "case.toml").write_text(
        """
        [section.root]
        kind = "rectangle"
        width = 0.02
        height = 0.04
        E = 1e9
        nu = 0.3
        rho = 1000
        offset = [0.01, 0.0]
        turn = 0.1
        [section.tip]
        kind = "profile"
        name = "IPE80"
        E = 1e9
        nu = 0.3
        rho = 1000
        [section.blade]
        kind = "taper"
        at = [0, 1]
        sections = ["root", "tip"]
        [[rod]]
        name = "arm"
        section = "blade"
        centreline = { file = "line.csv" }
        twist = [[0, 0], [1, 0.4]]
        elements = 4
        ends = ["a", "b"]
        [[rod]]
        name = "chain"
        section = "tip"
        catenary = { start = [0, 0, 9], end = [3, 0, 9], length = 4 }
        elements = 4
        [[geometry]]
        kind = "dxf"
        file = "drawing.dxf"
        section = { frame = "tip" }
        scale = 1e-3
        snap = 1e-4
        [[geometry]]
        kind = "cubic"
        counts = [1, 1, 1]
        cell = 1.0
        section = "tip"
        origin = [0, 0, 20]
        [dynamics]
        t_end = 1.0
        dt = 0.1
        """
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        case = load_case(tmp_path / "case.toml")
    rods = {rod.name: rod for rod in case.model.rods}
    assert {"arm", "chain", "frame.1", "0.0.0-1.0.0"} <= set(rods) and len(rods) == 2 + 3 + 12
    plain = dx.Section.rectangle(0.02, 0.04, E=1e9, nu=0.3, rho=1000)
    assert rods["arm"].section.at(0.0) == plain.turned(0.1).offset(0.01, 0.0)
    assert rods["chain"].curve == dx.catenary((0, 0, 9), (3, 0, 9), length=4)
    turned = rods["arm"].curve.frames(rods["arm"].curve.length, 0.0)
    straight = dx.centreline(tmp_path / "line.csv").frames(rods["arm"].curve.length, 0.0)
    assert turned[:, 0] @ straight[:, 0] == pytest.approx(np.cos(0.4))
    assert "frame.2" in "\n".join(case.model.notes())
    (tmp_path / "line.csv").write_text("x,y,z\n0,0,5\n0,0,5\n2,0.5,5\n")
    with pytest.raises(dx.InputError, match="same as the one before"):
        load_case(tmp_path / "case.toml")


ROUND = 'kind = "circle"\nradius = 0.01\nE = 1e9\nnu = 0.3\nrho = 1000'


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("grid", {"counts": (2, 1), "cell": (0.5, 0.25), "origin": (1.0, 2.0, 3.0), "order": 1}),
        ("octet", {"counts": (1, 2, 1), "cell": 2.0, "origin": (0.0, 0.0, 1.0), "elements": 2}),
        ("ring", {"radius": 2.0, "parts": 3, "centre": (1.0, 0.0, 0.0), "normal": (0.0, 1.0, 0.0)}),
        ("spring", {"radius": 0.1, "pitch": 0.06, "turns": -2.5, "end_coils": 1.0, "seats": True, "wire": 0.015}),
        ("weave", {"counts": (2, 2), "spacing": 1.0, "amplitude": 0.05, "weft": "thick", "elements_per_crossing": 5}),
        ("mesh", {"scale": 0.5}),
    ],
)  # fmt: skip
def test_every_kind_of_geometry_is_the_same_from_a_case(tmp_path: Path, kind: str, given: dict[str, object]) -> None:
    from directrix.schema.load import load_case

    keys = [f"{key} = {str(list(v) if isinstance(v, tuple) else v).lower()}" for key, v in given.items()]
    keys = [key.replace("thick", '"thick"') for key in keys]
    sections = f"[section.thin]\n{ROUND}\n[section.thick]\n{ROUND.replace('0.01', '0.02')}\n"
    if kind == "mesh":
        meshio = pytest.importorskip("meshio")
        points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 0, 0]], float)
        lines_of = [("line", np.array([[0, 1], [1, 2], [1, 3]]))]
        meshio.Mesh(points, lines_of, cell_data={"region": [np.array([1, 2, 1])]}).write(tmp_path / "a.vtk")
        made = dx.from_mesh(tmp_path / "a.vtk", {1: SECTION, 2: OTHER}, **given)  # type: ignore[arg-type]
        keys += ['file = "a.vtk"', 'section = { 1 = "thin", 2 = "thick" }']
    else:
        made = getattr(generate, kind)(section=SECTION, **given | ({"weft": OTHER} if "weft" in given else {}))
        keys += ['section = "thin"']
    case = tmp_path / "case.toml"
    run = "[dynamics]\nt_end = 1.0\ndt = 0.1\n"
    case.write_text(f'{sections}[[geometry]]\nkind = "{kind}"\n' + "\n".join(keys) + "\n" + run)
    model = load_case(case).model
    assert (model.rods, model.nodes, model.joints) == (made.rods, made.nodes, made.joints) and model.rods
