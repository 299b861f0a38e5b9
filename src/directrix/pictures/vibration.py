"""Shapes of vibration, one axes each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from directrix import drawing as draw
from directrix.checks import shown, whole
from directrix.errors import ModelError

if TYPE_CHECKING:
    from directrix.modal import Modes

__all__ = ["shapes"]


def shapes(modes: Modes, count: int, amplitude: float | None, axes: Sequence[Any] | None) -> tuple[Any, ...]:
    """See :meth:`directrix.Modes.plot`."""
    count = whole(count, "count", 1)
    count = min(count, len(modes.frequencies))
    motions = [modes.motion(k + 1, amplitude, 3) for k in range(count)]
    if axes is None:
        flat = all(draw.plane(one) is not None for one in motions)
        figure: Any = draw.pyplot().figure(figsize=(3.3 * min(count, 4), 2.8 * -(-count // 4)), layout="constrained")
        keys: dict[str, Any] = {} if flat else {"subplot_kw": {"projection": "3d"}}
        axes = list(figure.subplots(-(-count // 4), min(count, 4), squeeze=False, **keys).ravel())
        for unused in axes[count:]:
            unused.set_axis_off()
        for pen in axes[:count]:
            if flat:
                draw.dress(pen)
    elif len(axes) < count:
        raise ModelError(f"{count} modes do not fit {len(axes)} axes {shown(axes)}", "give one axes a mode", "axes=")
    for k, (pen, motion) in enumerate(zip(axes, motions, strict=False)):
        stage = draw.stage(motion, pen)
        # the first instant is where the mode moves most, the middle one the other side
        for at, style in ((1, {"color": draw.GHOST, "lw": 1.4}), (0, {"color": draw.BLUE, "lw": 2.2})):
            for rod in motion.mesh.rods:
                stage.line(draw.axis_line(rod, motion.r[at]), **style)
        for rod in motion.mesh.rods:
            stage.line(draw.axis_line(rod, modes.state[0]), color=draw.INK, lw=0.9, ls=":")
        stage.finish("", zoom=1.25)
        f, ratio = modes.frequencies[k], modes.damping_ratios[k]
        said = f"{f:.5g} per unit of time" if f > 0.0 else "does not swing"
        damped = f"\ndamping ratio {ratio:.3g}" if ratio else ""
        pen.set_title(f"mode {k + 1}: {said}{damped}", fontsize=10)
        for axis in (pen.xaxis, pen.yaxis, *((pen.zaxis,) if pen.name == "3d" else ())):
            axis.set_ticklabels([])  # the size of a mode is free
    return tuple(axes[:count])
