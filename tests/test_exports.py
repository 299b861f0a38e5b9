"""What leaves for other programs comes back the same: tables, arrays, labelled arrays, scenes, records of points."""

from __future__ import annotations

import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_result import fake_result
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

import directrix as dx
from directrix.basis import gauss
from directrix.errors import InputError, ModelError
from directrix.exports import TABLES, gltf, table
from directrix.points import place
from directrix.quantities import series, unit
from directrix.result import Result
from directrix.schema import load_case


@pytest.fixture(scope="module")
def run() -> Result:
    """A swinging rod with a body on a ball joint, a damped link and a floor: something in every table."""
    section = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100)
    model = dx.Model(name="swing").rod(
        dx.line((0, 0, 0), (1, 0, 0)), section, name="arm", ends=("pin", "tip"), elements=4
    )
    model = model.pin("pin").gravity((0, 0, -9.81)).spring("tip", (1.0, 0.0, 1.0), name="band", stiffness=5, damping=1)
    model = model.contact(dx.Plane((0, 0, -0.1), (0, 0, 1)), name="floor", stiffness=1e4)
    model = model.rigid_body("tip", 0.1, 1e-4 * np.eye(3), offset=(0.1, 0, 0))
    record = (dx.Recorder("arm", 0.3), dx.Recorder("arm", 1.0, ("v", "displacement", "strain")))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(FOLDER)
        return dx.simulate(model, 0.2, 0.01, save_every=2, record=record)


@pytest.fixture(scope="module", autouse=True)
def _folder(tmp_path_factory: pytest.TempPathFactory) -> None:
    global FOLDER
    FOLDER = tmp_path_factory.mktemp("run")


FOLDER = Path()
BAND = "link 'band'"


def read_csv(path: Path) -> dict[str, list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))


# ---- tables ----


def test_csv_brings_every_number_back(run: Result, tmp_path: Path) -> None:
    out = Path(run.to_csv(tmp_path / "new" / "csv"))
    assert {p.stem for p in out.iterdir()} == set(TABLES) - {"path"}  # a motion follows no path
    nt, n = run.r.shape[:2]
    nodes = {k: np.array(v) for k, v in read_csv(out / "nodes.csv").items()}
    for name, values in (
        ("r", run.r), ("displacement", run.r - run.mesh.r0), ("v", run.v),
    ):  # fmt: skip
        read = np.stack([nodes[f"{name}_{c}"].astype(float) for c in "xyz"], -1)
        np.testing.assert_array_equal(read.reshape(nt, n, 3), values)
    turned = np.stack([nodes[f"rotation_{c}"].astype(float) for c in "xyz"], -1)
    np.testing.assert_allclose(Rotation.from_rotvec(turned).as_matrix().reshape(run.R.shape), run.R, atol=1e-12)
    np.testing.assert_array_equal(nodes["reaction_Fz"].astype(float).reshape(nt, n), run.reaction[..., 2])
    assert nodes["name"].reshape(nt, n)[3, run.mesh.node("tip")] == "tip"
    np.testing.assert_array_equal(nodes["t"].astype(float).reshape(nt, n)[:, 1], run.t)
    rods = {k: np.array(v) for k, v in read_csv(out / "rods.csv").items()}
    for names, values in (
        (("V1", "V2", "N", "M1", "M2", "T"), run.force),
        (("Gamma1", "Gamma2", "Gamma3", "Omega1", "Omega2", "Omega3"), run.strain),
    ):
        read = np.stack([rods[c].astype(float) for c in names], -1)
        np.testing.assert_array_equal(read.reshape(values.shape), values)
    energy = {k: np.array(v, float) for k, v in read_csv(out / "energy.csv").items()}
    for name in ("kinetic", "stored", "total", "work", "dissipated", "residual"):
        np.testing.assert_array_equal(energy[name], getattr(run.energy, name))
    np.testing.assert_array_equal(energy[f"dissipated by {BAND}"], run.energy.by_source[BAND])
    assert energy[f"dissipated by {BAND}"][-1] > 0.0
    np.testing.assert_array_equal(energy["work by loads"], run.energy.work_by_source["loads"])
    joint = run.joint(run.mesh.joints[0])
    read = {k: np.array(v) for k, v in read_csv(out / "joints.csv").items()}
    np.testing.assert_array_equal(read["joint_force_z"].astype(float), joint.force[:, 2])
    assert np.any(joint.force[:, 2])
    read = {k: np.array(v) for k, v in read_csv(out / "links.csv").items()}
    np.testing.assert_array_equal(read["tension"].astype(float), run.link("band").tension)
    read = {k: np.array(v) for k, v in read_csv(out / "contacts.csv").items()}
    np.testing.assert_array_equal(read["gap"].astype(float), run.contact("floor").gap)
    assert read_csv(out / "steps.csv")["iterations"] == [str(k) for k in run.iterations]


def test_pandas_has_the_same_tables(run: Result) -> None:
    frame = run.to_pandas("rods")
    assert list(frame) == list(table(run, "rods")) and len(frame) == run.force[..., 0].size
    np.testing.assert_array_equal(frame["M2"], run.force[..., 4].ravel())
    assert set(frame["rod"]) == {"arm"}
    tip = run.to_pandas().query("name == 'tip'")
    np.testing.assert_array_equal(tip[["v_x", "v_y", "v_z"]], run.node("tip").v)
    with pytest.raises(ModelError, match=r"no table 'rod'.*\n.*did you mean 'rods'"):
        run.to_pandas("rod")
    with pytest.raises(ModelError, match=r"this result has no joints\n.*nodes, rods"):
        fake_result().to_pandas("joints")
    path = fake_result("static").to_pandas("path")
    assert list(path) == ["load_factor", "arc_length"] and path["arc_length"].is_monotonic_increasing


def test_xarray_has_names_and_units(run: Result) -> None:
    data = run.to_xarray()
    assert {"time", "node", "component", "station", "axis"} <= set(data.sizes)
    np.testing.assert_array_equal(data.r.sel(axis="z"), run.r[..., 2])
    np.testing.assert_array_equal(data.force.sel(component="bending 1"), run.force[..., 3])
    np.testing.assert_array_equal(data.s, run.rod("arm").s)
    np.testing.assert_array_equal(data.dissipated_by_source.sel(loss_source=BAND), run.energy.by_source[BAND])
    np.testing.assert_array_equal(data.joint_force.isel(joint=0), run.joint(run.mesh.joints[0]).force)
    np.testing.assert_array_equal(data.link_tension.sel(link="band"), run.link("band").tension)
    assert str(data.node_name[run.mesh.node("tip")].values) == "tip"
    for name, variable in data.data_vars.items():
        assert variable.attrs["long_name"] and "units" in variable.attrs, name
    assert data.v.attrs["units"] == "length/time" and data.time.attrs["units"] == "time"
    assert list(data.force_units.values) == ["force"] * 3 + ["force·length"] * 3
    named = replace(run, info={"units": {"length": "mm", "force": "N", "time": "s"}}).to_xarray()
    assert (named.v.attrs["units"], named.total.attrs["units"]) == ("mm/s", "N·mm")
    assert unit(run, "force·length·time") == "force·length·time"


@pytest.mark.parametrize("result", [fake_result(order=2), fake_result("static", instants=3)], ids=["dynamic", "static"])
def test_arrays_come_back_from_numpy_and_matlab(result: Result, tmp_path: Path) -> None:
    with np.load(result.to_npz(tmp_path / "a.npz")) as data:
        for name in ("t", "r", "R", "v", "Rdot", "reaction", "strain", "force", "load_factor", "iterations"):
            np.testing.assert_array_equal(data[name], getattr(result, name))
        np.testing.assert_array_equal(data["rod.mid.force"], result.rod("mid").force)
        np.testing.assert_array_equal(data["energy.residual"], result.energy.residual)
        assert dict(zip(data["node_names"], data["node_indices"], strict=True)) == result.mesh.node_names
    read: Any = loadmat(result.to_mat(tmp_path / "a.mat"), simplify_cells=True)["result"]
    for name in ("t", "r", "R", "v", "strain", "force"):
        np.testing.assert_array_equal(read[name], getattr(result, name))
    assert [rod["name"] for rod in read["rod"]] == ["left", "mid", "right"]
    np.testing.assert_array_equal(read["rod"][1]["strain"], result.rod("mid").strain)
    np.testing.assert_array_equal(read["rod"][1]["nodes"], result.mesh.rods[1].nodes + 1)
    assert {n["name"]: n["index"] - 1 for n in read["node"]} == result.mesh.node_names
    np.testing.assert_array_equal(read["energy"]["stored"], result.energy.stored)
    assert (read["kind"], read["title"]) == (result.kind, result.name)


def test_names_that_matlab_could_not_have_as_fields(run: Result, tmp_path: Path) -> None:
    read: Any = loadmat(run.to_mat(tmp_path / "a.mat"), simplify_cells=True)["result"]
    losses = np.atleast_1d(read["energy"]["dissipated_by"])
    assert [one["name"] for one in losses] == list(run.energy.by_source)
    np.testing.assert_array_equal(losses[0]["value"], next(iter(run.energy.by_source.values())))
    np.testing.assert_array_equal(read["joint"]["moment"], run.joint(run.mesh.joints[0]).moment)


def test_excel_has_a_sheet_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from openpyxl import load_workbook

    result = fake_result(instants=3, elements=2)
    book = load_workbook(result.to_xlsx(tmp_path / "a.xlsx"), read_only=True)
    assert book.sheetnames == ["nodes", "rods", "energy", "momentum", "steps"]
    head, *rows = book["nodes"].iter_rows(values_only=True)
    read = [row[head.index("r_x")] for row in rows]  # Excel has fewer digits than a float
    np.testing.assert_allclose(read, result.r[..., 0].ravel(), rtol=1e-15, atol=1e-15)
    monkeypatch.setattr("directrix.exports.files.ROWS", 20)
    with pytest.raises(ModelError, match="the table of nodes has 21 rows"):
        result.to_xlsx(tmp_path / "b.xlsx")


@pytest.mark.parametrize(
    ("module", "write"),
    [
        ("pandas", lambda r, _: r.to_pandas()),
        ("xarray", lambda r, _: r.to_xarray()),
        ("pyvista", lambda r, _: r.to_pyvista()),
        ("openpyxl", lambda r, d: r.to_xlsx(d / "a.xlsx")),
    ],
)
def test_a_missing_extra_is_named(module: str, write: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ModelError, match=r'needs .*not installed\n.*pip install "directrix\['):
        write(fake_result(instants=2), tmp_path)


@pytest.mark.parametrize("write", ["to_csv", "to_npz", "to_mat", "to_xlsx", "to_gltf"])
def test_places_that_cannot_be_written(write: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        getattr(fake_result(instants=2), write)(tmp_path / "file" / "x")
    with pytest.raises(ModelError, match="not the path of a file"):
        getattr(fake_result(instants=2), write)("")


# ---- scenes ----


def test_pyvista_sees_what_paraview_sees(run: Result) -> None:
    pytest.importorskip("pyvista", reason="pip install pyvista to check the scene")
    scene: Any = run.to_pyvista()
    assert scene.n_blocks == len(run.t) and scene.keys()[1] == "t = 0.02"
    rod, last = run.mesh.rods[0], scene[-1]
    np.testing.assert_array_equal(last.points, run.r[-1, rod.nodes])
    np.testing.assert_array_equal(last.point_data["velocity"], run.v[-1, rod.nodes])
    np.testing.assert_array_equal(last.point_data["d3"], run.directors("arm")[-1, ..., 2])
    assert last.n_cells == 4 and last.n_lines == 4
    mean = run.rod("arm").force[-1, :, 2].reshape(4, 2).mean(axis=1)
    np.testing.assert_allclose(last.cell_data["axial_force"], mean)
    one: Any = run.to_pyvista(-1)
    assert one.field_data["time"][0] == run.t[-1]
    np.testing.assert_array_equal(one.points, last.points)
    with pytest.raises(ModelError, match="at = 99"):
        run.to_pyvista(99)


def skinned(path: str, name: str, frame: int) -> np.ndarray:
    """Vertices of a rod at a frame, as the specification poses a skin (3.7.3.3)."""
    from pygltflib import GLTF2

    file: Any = GLTF2().load(path)
    blob = file.binary_blob()

    def read(k: int) -> np.ndarray:
        accessor = file.accessors[k]
        view = file.bufferViews[accessor.bufferView]
        kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[accessor.componentType]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor.type]
        raw = np.frombuffer(blob, kind, accessor.count * width, view.byteOffset)
        return raw.reshape(accessor.count, width)

    node = next(n for n in file.nodes if n.name == name and n.mesh is not None)
    skin, primitive = file.skins[node.skin], file.meshes[node.mesh].primitives[0]
    vertices, slot = read(primitive.attributes.POSITION), read(primitive.attributes.JOINTS_0)[:, 0]
    back = read(skin.inverseBindMatrices).reshape(-1, 4, 4).swapaxes(1, 2)
    moves = file.animations[0]
    where = {(c.target.node, c.target.path): moves.samplers[c.sampler] for c in moves.channels}
    out = np.zeros((len(vertices), 3))
    for k, joint in enumerate(skin.joints):
        turn = Rotation.from_quat(read(where[joint, "rotation"].output)[frame]).as_matrix()
        here = slot == k
        local = vertices[here] @ back[k, :3, :3].T + back[k, :3, 3]
        out[here] = local @ turn.T + read(where[joint, "translation"].output)[frame]
    return out


def quaternions(path: str) -> list[np.ndarray]:
    """The rotations of every ring, (frames, 4) each."""
    from pygltflib import GLTF2

    file: Any = GLTF2().load(path)
    moves, out = file.animations[0], []
    for channel in moves.channels:
        accessor = file.accessors[moves.samplers[channel.sampler].output]
        if channel.target.path == "rotation":
            start = file.bufferViews[accessor.bufferView].byteOffset
            out.append(np.frombuffer(file.binary_blob(), "<f4", 4 * accessor.count, start).reshape(-1, 4))
    return out


@pytest.mark.parametrize("order", [1, 2])
def test_gltf_moves_as_the_rods_do(order: int, tmp_path: Path) -> None:
    result = fake_result(order=order, instants=7, elements=2)
    path = result.to_gltf(tmp_path / "a.glb", up="y")
    rod, cuts = result.mesh.rods[1], 1 if order == 1 else gltf.CUTS
    rings = cuts * ((len(rod.nodes) - 1) // order) + 1
    for frame in (0, 3, 6):
        tube = skinned(path, "mid", frame)[: 8 * rings].reshape(rings, 8, 3)[::cuts, ::2]  # a rectangle: two a side
        d = result.directors("mid")[frame, ::order]
        r = result.r[frame, rod.nodes[::order]]
        expected = r[:, None] + np.einsum("nij,kj->nki", d[:, :, :2], rod.outline)
        np.testing.assert_allclose(tube, expected, atol=2e-6)
    for turns in quaternions(path):  # a viewer goes the short way from one to the next
        assert np.all(np.sum(turns[1:] * turns[:-1], axis=-1) > 0.5)
    up = skinned(result.to_gltf(tmp_path / "b.glb"), "mid", 6)
    np.testing.assert_allclose(up[:, [0, 2, 1]] * (1, -1, 1), skinned(path, "mid", 6), atol=2e-6)


def test_gltf_tubes_are_closed_and_face_outwards(tmp_path: Path) -> None:
    """The volume that the triangles enclose is area × length, in the reference a prism."""
    trimesh = pytest.importorskip("trimesh", reason="pip install trimesh to check the tubes")
    result = fake_result("static", instants=3)
    scene = trimesh.load(result.to_gltf(tmp_path / "a.glb"))
    volumes = {name: mesh.volume for name, mesh in scene.geometry.items()}
    assert volumes["mid"] == pytest.approx(0.12 * 0.24 * 3.0, rel=1e-5)
    assert volumes["left"] == pytest.approx(12.0 * 0.08**2 * np.sin(np.pi / 12) * 3.0, rel=1e-5)


def test_gltf_refuses_and_clocks(tmp_path: Path) -> None:
    from pygltflib import GLTF2

    def ends(result: Result, **options: Any) -> Any:
        file: Any = GLTF2().load(result.to_gltf(tmp_path / "a.glb", **options))
        clock = file.accessors[file.animations[0].samplers[0].input]
        return clock.min[0], clock.max[0], clock.count

    assert ends(fake_result(t_end=7.75)) == (0.0, 7.75, 40)
    assert ends(fake_result(), duration=3, frames=5) == (0.0, 3.0, 5)
    assert ends(fake_result("static")) == (0.0, 5.0, 40)
    assert not GLTF2().load(fake_result(instants=1).to_gltf(tmp_path / "a.glb")).animations
    broken = fake_result()
    broken.r[3, 2] = np.nan
    for result, options, says in (
        (broken, {}, "not finite"),
        (fake_result(), {"duration": 0.0}, "duration = 0"),
        (fake_result(), {"up": "x"}, "no axis that points up"),
        (fake_result(), {"frames": 0}, "frames = 0"),
    ):
        with pytest.raises(ModelError, match=says):
            result.to_gltf(tmp_path / "a.glb", **options)


# ---- points of rods ----


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_point_interpolates_what_elements_can_hold(order: int) -> None:
    """Polynomials of the order of the elements at nodes, and of their number at stress points, are exact anywhere."""
    result = fake_result(order=order)
    rod = result.mesh.rods[1]
    values = np.zeros((len(result.mesh.r0), 1))
    values[rod.nodes, 0] = rod.s**order
    forces = np.zeros((result.force.shape[1], 1))
    forces[rod.first_station : rod.first_station + len(rod.stations), 0] = rod.stations ** (len(gauss(order)[0]) - 1)
    for s in (0.0, 0.31, 0.6, 1.0, 2.99, 3.0):
        point = place(result.mesh, "mid", s)
        np.testing.assert_allclose(point.of_nodes(values), s**order, atol=1e-12)
        np.testing.assert_allclose(point.of_stations(forces), s ** (order - 1), atol=1e-12)
    for s in rod.stations:
        point = place(result.mesh, "mid", float(s))
        k = rod.first_station + int(np.flatnonzero(rod.stations == s)[0])
        np.testing.assert_allclose(point.of_stations(result.force), result.force[:, k], atol=1e-12)
    for s in (-0.1, 3.1, float("nan")):
        with pytest.raises(ModelError):
            place(result.mesh, "mid", s)


def test_records_hold_what_the_result_holds(run: Result) -> None:
    first, second = (FOLDER / f"record-arm-{s}.csv" for s in ("0.3", "1"))
    read = {k: np.array(v, float) for k, v in read_csv(first).items()}
    assert list(read) == ["t", "r_x", "r_y", "r_z", "V1", "V2", "N", "M1", "M2", "T"]
    np.testing.assert_array_equal(read["t"], run.t)
    for quantity, names in (("r", ("r_x", "r_y", "r_z")), ("force", ("V1", "V2", "N", "M1", "M2", "T"))):
        written = np.stack([read[name] for name in names], -1)
        np.testing.assert_allclose(written, series(run, quantity, ("arm", 0.3)).values, rtol=1e-12, atol=1e-14)
    assert np.abs(read["M2"]).max() > 0.0 or np.abs(read["M1"]).max() > 0.0
    read = {k: np.array(v, float) for k, v in read_csv(second).items()}
    np.testing.assert_allclose(read["v_z"], run.node("tip").v[:, 2], rtol=1e-12)
    np.testing.assert_allclose(read["displacement_x"], run.node("tip").displacement[:, 0], atol=1e-14)


def test_records_are_on_disk_while_the_run_goes_on(run: Result, tmp_path: Path) -> None:
    """What progress reads after a step has the row of that step already; actuation is not stressed."""
    section = dx.Section.circle(radius=0.02, E=5e6, nu=0.5, rho=1100)
    model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, name="arm", ends=("a", "b"), elements=2)
    model = model.clamp("a").actuate("arm", curvature=(0.0, 1.0))
    file, seen = tmp_path / "a.csv", []
    record = dx.Recorder("arm", 0.5, "force", path=file)
    result = dx.solve_static(
        model,
        3,
        record=record,
        progress=lambda *_: seen.append(len(file.read_text().splitlines())),  # pyright: ignore
    )
    assert seen == [3, 4, 5]
    read = {k: np.array(v, float) for k, v in read_csv(file).items()}
    np.testing.assert_array_equal(read["load_factor"], result.load_factor)
    np.testing.assert_allclose(read["M2"], 0.0, atol=1e-9)
    assert np.abs(result.strain[-1, :, 4]).max() == pytest.approx(1.0)


def test_recorders_that_cannot_be(tmp_path: Path) -> None:
    for make, says in (
        (lambda: dx.Recorder("arm", -1.0), "s = -1"),
        (lambda: dx.Recorder("arm", 1.0, ()), "names nothing"),
        (lambda: dx.Recorder("arm", 1.0, ("r", "r")), "twice"),
        (lambda: dx.Recorder("arm", 1.0, ("force", "energy")), "no quantity to record 'energy'"),
        (lambda: dx.Recorder("", 1.0), "not a name"),
    ):
        with pytest.raises(ModelError, match=says):
            make()
    model = dx.Model().rod(
        dx.line((0, 0, 0), (1, 0, 0)), dx.Section.circle(radius=0.02, E=5e6, nu=0.5), name="arm", elements=2
    ).clamp("arm.start")  # fmt: skip
    one = dx.Recorder("arm", 1.0, path=tmp_path / "a.csv")
    for record, says in (
        (dx.Recorder("leg", 1.0), "no rod 'leg'"),
        (dx.Recorder("arm", 1.5), "no arclength s = 1.5"),
        ((one, one), "two recorders write to one file"),
        (("arm",), "'arm' is no recorder"),
        (dx.Recorder("arm", 1.0, path=tmp_path / "none" / "a.csv"), "cannot be written"),
    ):
        with pytest.raises(ModelError, match=says):
            dx.solve_static(model, 1, record=record)  # type: ignore[arg-type]


CASE = """
[section.a]
kind = "circle"
radius = 0.02
E = 5e6
nu = 0.5
[[rod]]
name = "arm"
section = "a"
line = [[0, 0, 0], [1, 0, 0]]
ends = ["a", "b"]
elements = 2
[[support]]
node = "a"
type = "clamp"
[[force]]
node = "b"
value = [0, 0, 1]
[statics]
steps = 2
"""


def test_case_files_record(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from directrix.cli import app

    file = tmp_path / "a.toml"
    file.write_text(CASE + '[[record]]\nrod = "arm"\ns = 0.2\n[[record]]\nrod = "arm"\ns = 1\nname = "tip"\n')
    for _ in range(2):  # the second run takes the folder over
        done = CliRunner().invoke(app, ["run", str(file), "--no-view"])
        assert done.exit_code == 0 and "record-arm-0.2.csv" in done.stdout
    tip = {k: np.array(v, float) for k, v in read_csv(tmp_path / "a.run" / "record-tip.csv").items()}
    result = dx.load(tmp_path / "a.run" / "result.vtkhdf")
    np.testing.assert_allclose(tip["r_z"], result.node("b").r[:, 2], rtol=1e-12)
    for more, says in (
        ('rod = "arm"\ns = 2\n', r"a.toml:23:1: record\[arm\].s: rod 'arm' has no arclength s = 2"),
        ('rod = "leg"\ns = 0\n', "there is no rod 'leg'"),
        ('rod = "arm"\ns = 1\n[[record]]\nrod = "arm"\ns = 1\n', "another record writes record-arm-1.csv"),
        ('rod = "arm"\ns = 1\nquantities = ["M1"]\n', "quantities"),
        ('rod = "arm"\ns = 1\nname = "../a"\n', "name"),
    ):
        file.write_text(CASE + "[[record]]\n" + more)
        with pytest.raises(InputError, match=says):
            load_case(file)


@pytest.mark.parametrize(("to", "name"), [("csv", "a-csv"), ("npz", "a.npz"), ("mat", "a.mat"), ("gltf", "a.glb")])
def test_the_command_exports(to: str, name: str, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from directrix.cli import app

    saved = fake_result(instants=3).save(tmp_path / "a.vtkhdf")
    done = CliRunner().invoke(app, ["export", saved, "--to", to])
    assert done.exit_code == 0 and done.stdout.strip() == f"wrote {tmp_path / name}"
    assert (tmp_path / name).exists()
    assert CliRunner().invoke(app, ["export", saved, "--to", "word"]).exit_code == 2


SHOT = """
import sys
import pyvista
import directrix as dx
scene = pyvista.Plotter(off_screen=True, window_size=(200, 150))
scene.add_mesh(dx.load(sys.argv[1]).to_pyvista(-1).tube(radius=0.05), scalars="torque", show_scalar_bar=False)
scene.screenshot(sys.argv[2])
"""


@pytest.mark.slow
def test_pyvista_draws_without_a_screen(tmp_path: Path) -> None:
    """In a process of its own: without a way to draw VTK may end it."""
    pytest.importorskip("pyvista", reason="pip install pyvista to check the scene")
    saved, picture = fake_result(order=2).save(tmp_path / "a.vtkhdf"), tmp_path / "a.png"
    run = subprocess.run([sys.executable, "-c", SHOT, saved, str(picture)], capture_output=True, text=True, check=False)
    if run.returncode < 0 or not picture.exists():
        pytest.skip(f"VTK cannot draw here: {run.stderr[-200:]}")
    from matplotlib.image import imread

    image = imread(picture)[..., :3]
    assert image.shape[:2] == (150, 200) and np.ptp(image.reshape(-1, 3), axis=0).max() > 0.3
