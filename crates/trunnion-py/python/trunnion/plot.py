"""Pictures with matplotlib, and with pyvista in space. Both are optional: `pip install trunnion[plot]`, `[view]`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._errors import TrunnionError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["axes", "deviation", "error_curve", "strip_width", "view"]


def _figure(rows: int, title: str) -> Any:
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise TrunnionError("pictures need matplotlib\n  help: pip install 'trunnion[plot]'") from error
    # A figure of its own: scripts and notebooks decide how to show it, and none stays open.
    figure = Figure(figsize=(9, 2.2 * rows + 0.8), layout="constrained")
    figure.suptitle(title)
    return figure, figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]


def axes(result: Any, period: float = 0.002) -> "Figure":
    """Draws velocity, acceleration and jerk of every axis over its limit.

    Args:
        result: a Plan, or the result of a run.
        period: time between two points [s].

    Example:
        >>> import trunnion
        >>> table = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}
        >>> figure = trunnion.plot.axes(trunnion.plan(table, {"X": (100, 1000, 20000)}))
        >>> len(figure.axes)
        3
    """
    import numpy as np

    motion = result.sample(period)
    if callable(getattr(result, "limits", None)):
        of = result.limits()
        names, limits = of["axes"], [of["velocity"], of["acceleration"], of["jerk"]]
    else:
        names = result.axes
        limits = [
            np.array([result.limits.axes.get(name, {}).get(key, np.nan) for name in names])
            for key in ("vel", "acc", "jerk")
        ]
    figure, rows = _figure(3, f"axes over their limits, {result.duration:.2f} s")
    parts = zip(rows, ("velocity", "acceleration", "jerk"), limits)
    for row, part, limit in parts:
        for index, name in enumerate(names):
            row.plot(motion.t, getattr(motion, part)[:, index] / limit[index], label=name, linewidth=0.8)
        for bound in (-1.0, 1.0):
            row.axhline(bound, color="0.4", linestyle="--", linewidth=0.8)
        row.set_ylabel(part)
    rows[0].legend(loc="upper right", ncols=len(names))
    rows[-1].set_xlabel("time, s")
    return figure  # type: ignore[no-any-return]


def strip_width(result: Any) -> "Figure":
    """Draws the strip width along every pass of a covering or of a run [mm].

    Example:
        >>> import trunnion
        >>> plane = trunnion.Part.from_net([[[0, 0, 0], [0, 20, 0]], [[20, 0, 0], [20, 20, 0]]], degree=(1, 1))
        >>> ball = trunnion.Cutter.ball(10, length=60)
        >>> found = trunnion.cover(plane, ball, excess=0.1, gouge=0.01, along="u", method="inclined")
        >>> len(trunnion.plot.strip_width(found).axes)
        1
    """
    import numpy as np

    figure, (row,) = _figure(1, "strip width, mm")
    start = 0.0
    for one in result.passes:
        steps = np.linalg.norm(np.diff(one["tip"], axis=0), axis=1)
        along = start + np.concatenate([[0.0], np.cumsum(steps)])
        count = min(len(along), len(one["width"]))
        row.plot(along[:count], one["width"][:count], linewidth=0.9)
        start = along[-1]
    row.set_xlabel("travel of the tip, mm")
    return figure  # type: ignore[no-any-return]


def error_curve(location: Any, tolerance: float | None = None) -> "Figure":
    """Draws the error of a cutter location across the feed [mm], with the tolerance if it is given.

    Example:
        >>> import trunnion
        >>> net = [[[x, y, 0.002 * (x * x + y * y)] for y in (-40, -15, 15, 40)] for x in (-40, -15, 15, 40)]
        >>> face = trunnion.Part.from_net(net).faces[0]
        >>> found = trunnion.position(face, trunnion.Cutter.bull(10, 6), at=(0.5, 0.5), feed=(0, 1))
        >>> len(trunnion.plot.error_curve(found, 0.01).axes)
        1
    """
    figure, (row,) = _figure(1, f"error of one cutter location, strip {location.strip_width:.3f} mm")
    curve = location.error_curve
    row.plot(curve[:, 1], curve[:, 2])
    row.axhline(0.0, color="0.4", linewidth=0.8)
    if tolerance is not None:
        row.axhline(tolerance, color="0.4", linestyle="--", linewidth=0.8)
        row.set_ylim(-0.5 * tolerance, 3.0 * tolerance)
    row.set_xlabel("across the feed, mm")
    row.set_ylabel("error, mm")
    return figure  # type: ignore[no-any-return]


def deviation(result: Any, bins: int = 80) -> "Figure":
    """Draws the histogram of the deviation of a check or of a run [mm].

    Example:
        >>> import trunnion
        >>> result = trunnion.run("job.toml")  # doctest: +SKIP
        >>> figure = trunnion.plot.deviation(result)  # doctest: +SKIP
    """
    import numpy as np

    maps = result.maps if hasattr(result, "maps") else [{"height": result.height}]
    heights = np.concatenate([np.asarray(one["height"]) for one in maps]) if maps else np.zeros(0)
    heights = heights[np.isfinite(heights)]
    figure, (row,) = _figure(1, f"deviation of {heights.size} points, mm")
    row.hist(heights, bins=bins)
    row.set_xlabel("gouge < 0 < excess, mm")
    return figure  # type: ignore[no-any-return]


def view(part: Any = None, result: Any = None, chord: float = 0.05) -> Any:
    """Returns a pyvista Plotter with faces, passes and measured points.

    Args:
        part: a Part whose faces are drawn.
        result: a run or covering whose passes are drawn, coloured by deviation where it was measured.
        chord: chord tolerance of the drawing [mm].

    Example:
        >>> import trunnion
        >>> plane = trunnion.Part.from_net([[[0, 0, 0], [0, 20, 0]], [[20, 0, 0], [20, 20, 0]]], degree=(1, 1))
        >>> trunnion.plot.view(plane).show()  # doctest: +SKIP
    """
    try:
        import pyvista
    except ImportError as error:
        raise TrunnionError("pictures in space need pyvista\n  help: pip install 'trunnion[view]'") from error
    import numpy as np

    plotter = pyvista.Plotter()
    for face in part.faces if part is not None else []:
        vertices, triangles = face.mesh(chord)
        plotter.add_mesh(pyvista.PolyData.from_regular_faces(vertices, triangles), color="lightgrey")
    for one in getattr(result, "passes", []):
        plotter.add_lines(np.asarray(one["tip"]), color="steelblue", width=2, connected=True)
    for one in getattr(result, "maps", []):
        cloud = pyvista.PolyData(np.asarray(one["point"]))
        cloud["deviation, mm"] = one["height"]
        plotter.add_mesh(cloud, scalars="deviation, mm", point_size=4)
    return plotter
