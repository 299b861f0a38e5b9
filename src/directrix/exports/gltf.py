"""A moving picture that any viewer of three-dimensional scenes opens: glTF 2.0, in one binary file.

Every rod is a tube with the outline of its section, and every ring of it hangs on a node of its own (a skin), which
moves and turns in time. So sections stay rigid, as those of the theory, and a ring takes seven numbers a frame.

After "glTF 2.0 Specification" (Khronos Group, version 2.0.1): 3.6.1 accessors, 3.7.3 skins, 3.11 animations, 4.4 GLB.
"""

from __future__ import annotations

import json
import struct
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from directrix import checks
from directrix.basis import lagrange
from directrix.errors import ModelError
from directrix.exports.files import written
from directrix.result import Result, RodMesh

Array = NDArray[np.float64]

__all__ = ["to_gltf"]

FLOAT, SHORT, INT = 5126, 5123, 5125  # component types
VERTICES, FACES = 34962, 34963  # what a buffer view is for
CUTS = 4  # rings an element of higher order
SHARP = np.radians(40.0)  # a corner of an outline that is not rounded off
THICK = 0.005  # radius of a rod without outline, of the size of the model
SIDES = 12
COLOURS = ((0.12, 0.44, 0.71), (0.82, 0.38, 0.10), (0.17, 0.54, 0.29), (0.49, 0.53, 0.57))
UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # turns z up into the y up of glTF


def to_gltf(
    result: Result, path: str | PathLike[str], *, frames: int = 240, duration: float | None = None, up: str = "z"
) -> str:
    """Write an animation of the rods as a ``.glb``; returns the path.

    Parameters
    ----------
    path
        The file. It is a binary glTF whatever its ending; ``.glb`` is what viewers look for.
    frames
        Saved instants at most, evenly spread; between them viewers interpolate.
    duration
        Seconds the animation takes; unless given those of the run, and five for statics.
    up
        The axis that points up in the model, "z" or "y"; in glTF it is y.

    Raises
    ------
    ModelError
        A model without rods, numbers that are not finite, a duration that is not positive.
    InputError
        The file cannot be written.
    """
    out = checks.file(path, "path")
    frames = checks.whole(frames, "frames", 1)
    checks.choice(up, "axis that points up,", ("z", "y"))
    if not result.mesh.rods:
        raise ModelError("there is no rod to show", "export to csv or npz")
    if not (np.isfinite(result.r).all() and np.isfinite(result.R).all()):
        raise ModelError(
            "some positions are not finite, so there is nothing to show", "export a run that stopped before that"
        )
    count = len(result.t)
    picked = np.unique(np.rint(np.linspace(0, count - 1, min(frames, count))).astype(np.int64))
    build = _Build()
    times = _times(result, picked, duration)
    clock = build.add(times[:, None], FLOAT, "SCALAR", bounds=True)
    size = float(np.linalg.norm(np.ptp(result.mesh.r0, axis=0))) or 1.0
    turn = UP if up == "z" else np.eye(3)
    for k, rod in enumerate(result.mesh.rods):
        centres, frame = _rings(rod, result.r[picked], result.R[picked])
        outline = rod.outline if len(rod.outline) else THICK * size * _circle()
        build.rod(rod.name, outline, centres @ turn.T, turn @ frame, clock, len(times) > 1, k % len(COLOURS))
    said = f"{result.name}: {result.status.sentence}"
    return written(out, lambda: out.write_bytes(build.file(said)))


def _times(result: Result, picked: NDArray[np.int64], duration: float | None) -> Array:
    """Seconds (frames,) from 0 on, rising."""
    if duration is not None:
        duration = checks.number(duration, "duration", above=0.0)
    elif result.kind == "static":
        duration = 5.0
    rises = bool(np.all(np.diff(result.t) > 0.0))
    t = result.t[picked] if rises else picked.astype(float)
    t = t - t[0]
    return t if duration is None or not t[-1] else t * (duration / t[-1])


def _circle() -> Array:
    angle = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def _rings(rod: RodMesh, r: Array, R: Array) -> tuple[Array, Array]:
    """Centres (frames, rings, 3) and frames (frames, rings, 3, 3) along a rod, as its elements interpolate them.

    Between nodes the interpolated directors are not quite orthonormal; a section is drawn in the rotation nearest to
    them (polar decomposition).
    """
    order, cuts = rod.order, 1 if rod.order == 1 else CUTS
    shape = lagrange(order, np.linspace(-1.0, 1.0, cuts + 1)[:-1])[0]
    local = np.arange(0, len(rod.nodes) - 1, order)[:, None] + np.arange(order + 1)
    x, d = r[:, rod.nodes], R[:, rod.nodes] @ rod.directors
    centres = np.einsum("ca,teai->teci", shape, x[:, local]).reshape(len(r), -1, 3)
    directors = np.einsum("ca,teaij->tecij", shape, d[:, local]).reshape(len(r), -1, 3, 3)
    centres, directors = np.append(centres, x[:, -1:], axis=1), np.append(directors, d[:, -1:], axis=1)
    u, _, vt = np.linalg.svd(directors)
    return centres, u @ vt


class _Build:
    """Grows the document and its one buffer."""

    def __init__(self) -> None:
        self.bytes = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.nodes: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.skins: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self.roots: list[int] = []

    def add(self, values: NDArray[Any], component: int, kind: str, *, use: int = 0, bounds: bool = False) -> int:
        """Put values (count, …) into the buffer; the number of their accessor."""
        data = np.ascontiguousarray(values, {FLOAT: "<f4", SHORT: "<u2", INT: "<u4"}[component])
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": data.nbytes}
        self.views.append(view | ({"target": use} if use else {}))
        self.bytes += data.tobytes() + bytes(-data.nbytes % 4)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(data), "type": kind}
        if bounds:
            flat = data.reshape(len(data), -1)
            accessor |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def rod(
        self, name: str, outline: Array, centres: Array, frames: Array, clock: int, moves: bool, paint: int
    ) -> None:
        """A tube, its rings and how they go."""
        local, across, ring, faces = _tube(outline, centres.shape[1])
        first, turn = centres[0], frames[0]
        vertices = first[ring] + np.einsum("vij,vj->vi", turn[ring], local)
        slots = np.zeros((len(ring), 4), np.uint16)
        slots[:, 0] = ring
        attributes = {
            "POSITION": self.add(vertices, FLOAT, "VEC3", use=VERTICES, bounds=True),
            "NORMAL": self.add(np.einsum("vij,vj->vi", turn[ring], across), FLOAT, "VEC3", use=VERTICES),
            "JOINTS_0": self.add(slots, SHORT, "VEC4", use=VERTICES),
            "WEIGHTS_0": self.add(np.tile((1.0, 0.0, 0.0, 0.0), (len(ring), 1)), FLOAT, "VEC4", use=VERTICES),
        }
        indices = self.add(faces.reshape(-1, 1), INT, "SCALAR", use=FACES)
        self.meshes.append(
            {"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": paint}]}
        )
        quaternions = _quaternions(frames)
        start = len(self.nodes)
        for j in range(centres.shape[1]):
            self.nodes.append(
                {"translation": first[j].astype("f4").tolist(), "rotation": quaternions[0, j].astype("f4").tolist()}
            )
            if moves:
                for path, values in (("translation", centres[:, j]), ("rotation", quaternions[:, j])):
                    kind = "VEC3" if path == "translation" else "VEC4"
                    self.samplers.append({"input": clock, "output": self.add(values, FLOAT, kind)})
                    target = {"node": start + j, "path": path}
                    self.channels.append({"sampler": len(self.samplers) - 1, "target": target})
        joints = list(range(start, len(self.nodes)))
        back = np.zeros((len(joints), 4, 4))
        back[:, :3, :3] = np.swapaxes(turn, 1, 2)
        back[:, :3, 3] = -np.einsum("jki,jk->ji", turn, first)
        back[:, 3, 3] = 1.0
        matrices = self.add(np.swapaxes(back, 1, 2).reshape(-1, 16), FLOAT, "MAT4")  # column by column
        rings = {"name": f"{name}, rings", "children": joints}
        tube = {"name": name, "mesh": len(self.meshes) - 1, "skin": len(self.skins)}
        self.nodes += [rings, tube]
        self.roots += [len(self.nodes) - 2, len(self.nodes) - 1]
        self.skins.append({"joints": joints, "skeleton": len(self.nodes) - 2, "inverseBindMatrices": matrices})

    def file(self, said: str) -> bytes:
        """The GLB."""
        paints = [
            {
                "pbrMetallicRoughness": {"baseColorFactor": [*c, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.6},
                "doubleSided": True,
            }
            for c in COLOURS
        ]
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "directrix"},
            "scene": 0,
            "scenes": [{"name": said, "nodes": self.roots}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "skins": self.skins,
            "materials": paints,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.bytes)}],
        }
        if self.channels:
            document["animations"] = [{"name": "run", "samplers": self.samplers, "channels": self.channels}]
        text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        whole = 12 + 8 + len(text) + 8 + len(self.bytes)
        head = struct.pack("<4sII", b"glTF", 2, whole) + struct.pack("<I4s", len(text), b"JSON")
        return head + text + struct.pack("<I4s", len(self.bytes), b"BIN\0") + bytes(self.bytes)


def _tube(outline: Array, rings: int) -> tuple[Array, Array, NDArray[np.int64], NDArray[np.int64]]:
    """Places and outer normals (v, 3) in the frame of a ring, the ring (v,) of each, and triangles (f, 3).

    Two vertices a side of the outline, so that corners stay sharp where they are; ends of convex outlines are closed.
    """
    after = np.roll(outline, -1, axis=0)
    side = after - outline
    if float(np.sum(outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0])) < 0.0:
        return _tube(outline[::-1], rings)
    normal = _unit(np.stack([side[:, 1], -side[:, 0]], -1))
    before, next_side = np.roll(normal, 1, axis=0), np.roll(side, -1, axis=0)
    soft = np.sum(normal * before, axis=1) > np.cos(SHARP)
    both = _unit(normal + before)
    start = np.where(soft[:, None], both, normal)
    end = np.where(np.roll(soft, -1)[:, None], np.roll(both, -1, axis=0), normal)
    place, shade = (np.stack(pair, 1).reshape(-1, 2) for pair in ((outline, after), (start, end)))
    k, many = len(outline), 2 * len(outline)
    a = (np.arange(rings - 1)[:, None] * many + 2 * np.arange(k)).ravel()
    faces = [np.stack([a, a + 1, a + many + 1], -1), np.stack([a, a + many + 1, a + many], -1)]
    places, shades, ring = (
        [np.tile(place, (rings, 1))],
        [np.tile(shade, (rings, 1))],
        [np.repeat(np.arange(rings), many)],
    )
    ahead = [np.zeros(rings * many)]
    if np.all(side[:, 0] * next_side[:, 1] - side[:, 1] * next_side[:, 0] >= 0.0):
        fan = np.arange(1, k - 1)
        for first, at, sign in ((rings * many, 0, -1.0), (rings * many + k, rings - 1, 1.0)):
            round_it = (fan + 1, fan) if sign < 0.0 else (fan, fan + 1)
            faces.append(first + np.stack([np.zeros_like(fan), *round_it], -1))
            places.append(outline)
            shades.append(np.zeros((k, 2)))
            ring.append(np.full(k, at))
            ahead.append(np.full(k, sign))
    flat, shaded = np.concatenate(places), np.concatenate(shades)
    return (
        np.column_stack([flat, np.zeros(len(flat))]), np.column_stack([shaded, np.concatenate(ahead)]),
        np.concatenate(ring), np.concatenate(faces),
    )  # fmt: skip


def _unit(v: Array) -> Array:
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)


def _quaternions(frames: Array) -> Array:
    """(frames, rings, 4) as glTF orders them, x, y, z, w; each on the side of the one before."""
    q = Rotation.from_matrix(frames.reshape(-1, 3, 3)).as_quat().reshape(*frames.shape[:2], 4)
    flips = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
    sign = np.cumprod(np.where(flips, -1.0, 1.0), axis=0)
    q[1:] *= sign[..., None]
    return q
