"""A result survives saving bit for bit, and what ParaView reads follows the VTKHDF specification."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from fake_result import fake_result
from hypothesis import given
from hypothesis import strategies as st

import directrix as dx
from directrix.errors import InputError
from directrix.result import Result
from directrix.storage import load, save, vtkhdf
from directrix.storage.fields import FORCES, STRAINS

CASES = [
    dict(kind="static", order=1),
    dict(kind="dynamic", order=2, fails=True),
    dict(kind="dynamic", order=3, elements=2, instants=2),
    dict(kind="static", instants=1),
]


@pytest.fixture(params=CASES, ids=str)
def result(request: pytest.FixtureRequest) -> Result:
    return fake_result(**request.param)


@pytest.fixture(params=[2**18, 2**10], ids=["whole arrays", "chunks"])
def chunk(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vtkhdf, "CHUNK", request.param)


def same(a: Any, b: Any, where: str = "result") -> None:
    """Assert that two values are equal to the last bit, in type, shape and sign of zero."""
    assert type(a) is type(b), where
    if isinstance(a, np.ndarray):
        assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes()), where
    elif is_dataclass(a):
        for key in fields(a):
            same(getattr(a, key.name), getattr(b, key.name), f"{where}.{key.name}")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), where
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            same(x, y, f"{where}[{k}]")
    elif isinstance(a, Mapping):
        assert list(a) == list(b), where
        for key in a:
            same(a[key], b[key], f"{where}[{key!r}]")
    else:
        assert repr(a) == repr(b), where


# ---- the result comes back ----


def test_loads_what_was_saved(result: Result, chunk: None, tmp_path: Path) -> None:
    path = tmp_path / "a.vtkhdf"
    assert save(result, path) == str(path)
    same(result, load(path))
    assert [p.name for p in tmp_path.iterdir()] == ["a.vtkhdf"]


def test_big_arrays_are_chunked_checked_and_compressed_where_it_pays(tmp_path: Path) -> None:
    result = fake_result(instants=500, order=2)
    result = replace(result, v=np.zeros_like(result.v))
    path = save(result, tmp_path / "a.vtkhdf")
    same(result, load(path))
    with h5py.File(path) as file:
        still, moving = file["directrix/v"], file["directrix/r"]
        assert still.chunks[1:] == still.shape[1:] and still.fletcher32 and moving.fletcher32
        assert (still.compression, still.shuffle, moving.compression) == ("gzip", True, None)
        assert still.id.get_storage_size() < 0.01 * still.nbytes


texts = st.text(max_size=8)
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)


@given(
    names=st.lists(texts, min_size=7, max_size=7, unique=True),
    info=st.dictionaries(texts, values, max_size=4),
    bits=st.lists(st.integers(0, 2**64 - 1), min_size=3, max_size=3),
)
def test_any_name_info_and_bit_pattern_survives(
    tmp_path_factory: pytest.TempPathFactory, names: list[str], info: dict[str, Any], bits: list[int]
) -> None:
    base = fake_result(instants=2, elements=1, names=tuple(names[:3]), title=names[0])
    odd = base.r.copy()
    odd[0, 0] = np.array(bits, np.uint64).view(float)
    mesh = replace(base.mesh, node_names=dict(zip(names[3:], (3, 1, 0, 2), strict=True)), notes=tuple(names))
    result = replace(base, r=odd, mesh=mesh, info=info)
    path = tmp_path_factory.mktemp("any") / "a.vtkhdf"
    with np.errstate(all="ignore"):
        save(result, path)
    same(result, load(path))


def test_info_of_numpy_values_comes_back_as_plain_ones(tmp_path: Path) -> None:
    info = {"n": np.int64(3), "x": np.float32(0.5), "a": np.eye(2), "p": Path("x"), "t": (1,)}
    loaded = load(save(replace(fake_result(instants=2), info=info), tmp_path / "a.vtkhdf")).info
    same(loaded, {"n": 3, "x": 0.5, "a": [[1.0, 0.0], [0.0, 1.0]], "p": "x", "t": [1]})


# ---- what ParaView reads ----


def vtk_steps(path: str) -> tuple[h5py.Group, int]:
    group = h5py.File(path)["VTKHDF"]
    return group, int(group["Steps"].attrs["NSteps"])


def test_structure_follows_the_vtkhdf_specification(result: Result, chunk: None, tmp_path: Path) -> None:
    """Every group, type, shape and offset that version 2.0 asks of temporal PolyData."""
    root, steps = vtk_steps(save(result, tmp_path / "a.vtkhdf"))
    kind = root.attrs.get_id("Type").get_type()
    assert not kind.is_variable_str() and kind.get_cset() == h5py.h5t.CSET_ASCII
    assert root.attrs["Type"] == b"PolyData"
    assert root.attrs["Version"].dtype.kind == "i" and root.attrs["Version"].tolist() == [2, 0]
    assert set(root) == {
        "NumberOfPoints", "Points", "Vertices", "Lines", "Polygons", "Strips",
        "Steps", "PointData", "CellData", "FieldData",
    }  # fmt: skip

    points = int(root["NumberOfPoints"][0])
    assert root["NumberOfPoints"].shape == (1,)
    assert root["Points"].dtype == np.float64 and root["Points"].shape == (steps * points, 3)
    cells = 0
    for category in ("Vertices", "Lines", "Polygons", "Strips"):
        part = {name: data[()] for name, data in root[category].items()}
        assert set(part) == {"NumberOfConnectivityIds", "NumberOfCells", "Connectivity", "Offsets"}
        assert all(data.dtype == np.int64 and data.ndim == 1 for data in part.values())
        ids, starts = part["Connectivity"], part["Offsets"]
        assert part["NumberOfConnectivityIds"].tolist() == [len(ids)] == [starts[-1]]
        assert part["NumberOfCells"].tolist() == [len(starts) - 1]
        assert starts[0] == 0 and np.all(np.diff(starts) >= 2)
        assert np.all((ids >= 0) & (ids < points))
        cells += len(starts) - 1
    assert cells == root["Lines/NumberOfCells"][0] > 0

    group = root["Steps"]
    assert isinstance(group.attrs["NSteps"], np.integer) and steps == len(result.t)
    assert group["Values"].dtype == np.float64 and group["Values"].shape == (steps,)
    assert np.all(np.diff(group["Values"]) > 0.0)
    assert group["NumberOfParts"][()].tolist() == [1] * steps
    assert group["PartOffsets"][()].tolist() == [0] * steps
    assert group["PointOffsets"][()].tolist() == [points * k for k in range(steps)]
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        assert group[name].dtype == np.int64 and group[name].shape == (steps, 4) and not group[name][()].any()
    for kind, rows in (("PointData", points), ("CellData", cells), ("FieldData", 1)):
        assert set(root[kind]) == set(group[f"{kind}Offsets"]) and len(root[kind]) > 0
        for name, data in root[kind].items():
            starts = group[f"{kind}Offsets"][name]
            assert "/" not in name and "." not in name
            assert starts.dtype == np.int64 and starts.shape == (steps,)
            assert data.dtype in (np.float64, np.int64) and data.ndim == (1 if data.shape[1:] == () else 2)
            assert len(data) == starts[-1] + rows and starts[0] == 0
            assert np.all(np.diff(starts) == (rows if len(data) == steps * rows and steps > 1 else 0))


def frames(path: str) -> list[dict[str, Any]]:
    """Points, lines and data of every instant, read as the specification says."""
    root, steps = vtk_steps(path)
    points, cells = int(root["NumberOfPoints"][0]), int(root["Lines/NumberOfCells"][0])
    out: list[dict[str, Any]] = []
    for k in range(steps):
        start = int(root["Steps/PointOffsets"][k])
        frame: dict[str, Any] = {"t": root["Steps/Values"][k]}
        frame["points"] = root["Points"][start : start + points]
        frame["lines"] = np.split(root["Lines/Connectivity"][()], root["Lines/Offsets"][1:-1])
        for kind, rows in (("PointData", points), ("CellData", cells), ("FieldData", 1)):
            for name, data in root[kind].items():
                start = int(root[f"Steps/{kind}Offsets/{name}"][k])
                frame[f"{kind}/{name}"] = data[start : start + rows]
        out.append(frame)
    return out


def vtk_frames(path: str) -> list[dict[str, Any]]:
    """The same, read by VTK itself."""
    pytest.importorskip("vtk", reason="pip install vtk to check with VTK's own reader")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    assert reader.CanReadFile(path)
    reader.SetFileName(path)
    reader.UpdateInformation()
    about, key = reader.GetOutputInformation(0), Pipeline.TIME_STEPS()
    times = [about.Get(key, k) for k in range(about.Length(key))]
    out: list[dict[str, Any]] = []
    for t in times or [0.0]:  # VTK has no clock for a single instant
        reader.UpdateTimeStep(t)
        data = reader.GetOutputDataObject(0)
        assert data.GetClassName() == "vtkPolyData"
        frame: dict[str, Any] = {"t": t, "points": vtk_to_numpy(data.GetPoints().GetData()).copy()}
        lines = data.GetLines()
        ids = vtk_to_numpy(lines.GetConnectivityArray()).copy()
        frame["lines"] = np.split(ids, vtk_to_numpy(lines.GetOffsetsArray())[1:-1])
        for kind in ("PointData", "CellData", "FieldData"):
            arrays = getattr(data, f"Get{kind}")()
            for a in range(arrays.GetNumberOfArrays()):
                frame[f"{kind}/{arrays.GetArrayName(a)}"] = vtk_to_numpy(arrays.GetArray(a)).copy()
        out.append(frame)
    return out


@pytest.mark.parametrize("read", [frames, vtk_frames])
def test_paraview_sees_the_motion(read: Any, result: Result, chunk: None, tmp_path: Path) -> None:
    read_frames = read(save(result, tmp_path / "a.vtkhdf"))
    assert len(read_frames) == len(result.t)
    for k, frame in enumerate(read_frames):
        assert frame["t"] == result.t[k]
        first = cell = 0
        for i, rod in enumerate(result.mesh.rods):
            here = slice(first, first + len(rod.nodes))
            data = {name.removeprefix("PointData/"): v[here] for name, v in frame.items() if "Point" in name}
            np.testing.assert_array_equal(frame["points"][here], result.r[k, rod.nodes])
            np.testing.assert_array_equal(data["displacement"], (result.r[k] - result.mesh.r0)[rod.nodes])
            np.testing.assert_array_equal(data["velocity"], result.v[k, rod.nodes])
            directors = np.stack([data["d1"], data["d2"], data["d3"]], axis=-1)
            np.testing.assert_allclose(directors, result.directors(rod.name)[k], rtol=0, atol=1e-15)
            np.testing.assert_array_equal(data["arclength"], rod.s)
            assert np.all(data["rod"] == i)
            for start in range(first, first + len(rod.nodes) - 1, rod.order):
                assert frame["lines"][cell].tolist() == list(range(start, start + rod.order + 1))
                assert frame["CellData/rod"][cell] == i
                cell += 1
            first += len(rod.nodes)
        assert (first, cell) == (len(frame["points"]), len(frame["lines"]))
        assert frame["FieldData/load_factor"] == result.load_factor[k]
        for name in ("kinetic", "stored", "total", "work"):
            assert frame[f"FieldData/energy_{name}"] == getattr(result.energy, name)[k]


@pytest.mark.parametrize("read", [frames, vtk_frames])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_cell_data_are_the_means_of_forces_and_strains(order: int, read: Any, tmp_path: Path) -> None:
    """What varies as the Gauss points can integrate exactly has the mean of its integral."""
    base = fake_result(order=order, instants=3)
    degree, force = 2 * order - 1, np.empty_like(base.force)
    factors = (1.0 + np.arange(3))[:, None] * np.arange(1, 7)  # of instant and component
    expected: list[Any] = []
    for i, rod in enumerate(base.mesh.rods):
        part = slice(rod.first_station, rod.first_station + len(rod.stations))
        force[:, part] = (i + 1) * factors[:, None] * rod.stations[:, None] ** degree
        ends = rod.s[:: rod.order] ** (degree + 1) / (degree + 1)
        mean = (i + 1) * np.diff(ends) / np.diff(rod.s[:: rod.order])
        expected.append(factors[:, None] * mean[:, None])
    means = np.concatenate(expected, axis=1)
    for k, frame in enumerate(read(save(replace(base, force=force, strain=-force), tmp_path / "a.vtkhdf"))):
        for c, (pull, strain) in enumerate(zip(FORCES, STRAINS, strict=True)):
            np.testing.assert_allclose(frame[f"CellData/{pull}"], means[k, :, c], rtol=1e-13)
            np.testing.assert_allclose(frame[f"CellData/{strain}"], -means[k, :, c], rtol=1e-13)


@pytest.mark.parametrize("last", [0.5, 1.0], ids=["turns back", "stands still"])
def test_a_load_factor_that_does_not_rise_is_shown_by_number(last: float, tmp_path: Path) -> None:
    t = np.array([0.0, 1.0, last])
    result = replace(fake_result("static", instants=3), t=t, load_factor=t)
    shown = frames(save(result, tmp_path / "a.vtkhdf"))
    assert [frame["t"] for frame in shown] == [0.0, 1.0, 2.0]
    assert [frame["FieldData/load_factor"][0] for frame in shown] == t.tolist()


# ---- files that cannot be read ----


def refused(path: Path, says: str) -> None:
    with pytest.raises(InputError) as caught:
        load(path)
    assert caught.value.where == str(path) and caught.value.fix
    assert re.search(says, caught.value.what)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    return Path(save(fake_result(instants=3), tmp_path / "a.vtkhdf"))


def test_refuses_what_is_no_result_file(tmp_path: Path) -> None:
    refused(tmp_path / "none.vtkhdf", "no such file")
    refused(tmp_path, "folder")
    refused(tmp_path / ("x" * 300), "cannot be read: File name too long")
    for content in (b"", b"t,x\n0,1\n" * 500):
        (tmp_path / "text").write_bytes(content)
        refused(tmp_path / "text", "not an HDF5 file")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    refused(tmp_path / "other.h5", "holds no directrix result")
    with h5py.File(tmp_path / "dataset.h5", "w") as file:
        file["directrix"] = 1
    refused(tmp_path / "dataset.h5", "holds no directrix result")


def test_refuses_a_newer_format(saved: Path) -> None:
    with h5py.File(saved, "r+") as file:
        file["directrix"].attrs["format"] = vtkhdf.FORMAT + 1
        del file["directrix/mesh"]  # what a newer format may do
    refused(saved, f"format {vtkhdf.FORMAT + 1}.*reads up to {vtkhdf.FORMAT}")


@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_refuses_a_truncated_file(tmp_path_factory: pytest.TempPathFactory, share: float) -> None:
    path = tmp_path_factory.mktemp("cut") / "a.vtkhdf"
    whole = Path(save(fake_result(instants=2, elements=1), path)).read_bytes()
    for size in (int(share * len(whole)), len(whole) - 1):
        path.write_bytes(whole[:size])
        refused(path, "damaged|not an HDF5 file")


@pytest.mark.parametrize("name", ["r", "mesh/sizes", "audit", "energy/work"])
def test_refuses_a_file_that_lacks_a_part(name: str, saved: Path) -> None:
    with h5py.File(saved, "r+") as file:
        del file["directrix"][name]
    refused(saved, "damaged")


@pytest.mark.parametrize("text", ["", "{", "3", '{"no_field": 1}'])
@pytest.mark.parametrize("name", ["status", "audit", "rod_names"])
def test_refuses_text_that_is_not_what_was_written(name: str, text: str, saved: Path) -> None:
    with h5py.File(saved, "r+") as file:
        del file["directrix"][name]
        file["directrix"][name] = text
    refused(saved, "damaged")


def test_refuses_a_flipped_bit_in_a_big_array(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(vtkhdf, "CHUNK", 2**10)
    path = Path(save(fake_result(), tmp_path / "a.vtkhdf"))
    with h5py.File(path) as file:
        place = file["directrix/r"].id.get_chunk_info(1).byte_offset + 77
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)
    refused(path, "damaged")


# ---- files that cannot be written ----


def test_refuses_places_that_cannot_hold_a_file(tmp_path: Path) -> None:
    for path, says in (
        (tmp_path, "folder, not a file"),
        (tmp_path / "none" / "a.vtkhdf", "there is no folder .*none"),
        (tmp_path / ("x" * 300), "cannot be written: File name too long"),
    ):
        with pytest.raises(InputError) as caught:
            save(fake_result(instants=2), path)
        assert caught.value.where == str(path) and re.search(says, caught.value.what) and caught.value.fix
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_save_keeps_the_older_file(saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = saved.read_bytes()

    def interrupt(descriptor: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.fsync", interrupt)  # everything is written, but not yet in its place
    with pytest.raises(KeyboardInterrupt):
        save(fake_result("static"), saved)
    assert saved.read_bytes() == before and list(saved.parent.iterdir()) == [saved]


FULL = """
import resource, sys
from fake_result import fake_result
from directrix.errors import InputError
from directrix.storage import save
for limit in (0, 3000, 100_000):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        save(fake_result(), sys.argv[1])
    except InputError as error:
        assert "cannot be written: File too large" in error.what, error
    else:
        raise AssertionError("saved all the same")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limits on the size of files")
def test_a_full_disk_is_an_error_and_keeps_the_older_file(saved: Path) -> None:
    """In a process of its own: HDF5 itself may end the process when a write fails."""
    before = saved.read_bytes()
    run = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {sys.path!r}{FULL}", str(saved)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (0, "")
    assert saved.read_bytes() == before and list(saved.parent.iterdir()) == [saved]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "scratch").mkdir()
    link, target = tmp_path / "a.vtkhdf", tmp_path / "scratch" / "b.vtkhdf"
    link.symlink_to(target)
    assert save(fake_result(instants=2), link) == str(link)
    assert link.is_symlink() and target.is_file() and load(link).name == "three-rod frame"


def test_joints_keep_their_places(tmp_path: Path) -> None:
    """A body on an arm of a rod, and the rod on the ground: where joints are is in the file, and is where they hold."""
    section = dx.Section.circle(radius=0.01, E=1e7, nu=0.3, rho=1000.0)
    model = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), section, ends=("a", "b"), elements=2)
    model = model.rigid_body("b", 0.1, 1e-4 * np.eye(3), offset=(0, 0.2, 0)).spherical("a", name="ball")
    result = dx.simulate(model.gravity((0, 0, -9.81)), 0.05, 0.01)
    again = dx.load(result.save(tmp_path / "run.vtkhdf"))
    assert again.mesh.joints == ("b.body", "ball")
    arm, body, pinned = (again.mesh.node(name) for name in ("b", "b.body", "a"))
    np.testing.assert_array_equal(again.mesh.joint_nodes, [[arm, body], [-1, pinned]])
    np.testing.assert_array_equal(again.mesh.joint_arms, result.mesh.joint_arms)
    ends = again.joint_ends(-1)
    np.testing.assert_allclose(ends[:, 0, 1], ends[:, 1, 1], rtol=0, atol=1e-12)  # base and what moves are together
    np.testing.assert_array_equal(ends[0, :, 0], again.r[-1, [arm, body]])
    assert again.mesh.loose.tolist() == [body] and abs(ends[0, 1, 1, 2]) > 1e-3
