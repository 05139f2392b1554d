"""Pictures with matplotlib, and with pyvista in space. Both are optional: `pip install trunnion[plot]`, `[view]`."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

from . import _options
from ._errors import ArgumentError, TrunnionError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Tolerances that an axis of a picture can show [mm].
_LEAST, _MOST = 1e-12, 1e12
#: Bars of a histogram: more are below a pixel.
_MOST_BINS = 10_000

__all__ = ["axes", "deviation", "error_curve", "strip_width", "view"]


def _figure(rows: int, title: str) -> Any:
    try:
        from ._figure import NotebookFigure
    except ImportError as error:
        raise TrunnionError("pictures need matplotlib\n  help: pip install 'trunnion[plot]'") from error
    # A figure of its own: scripts and notebooks decide how to show it, and none stays open.
    figure = NotebookFigure(figsize=(9, 2.2 * rows + 0.8), layout="constrained")
    figure.suptitle(title)
    return figure, figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]


def _one_of(name: str, value: Any, kinds: tuple[type, ...]) -> Any:
    """Returns a result of one of the kinds that can be drawn."""
    if isinstance(value, kinds):
        return value
    given, known = type(value).__name__, " or ".join(kind.__name__ for kind in kinds)
    raise ArgumentError(f"{name} = {given} is no {known}", name, None, given)


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

    from ._job import RunResult
    from ._plan import Plan

    motion = _one_of("result", result, (Plan, RunResult)).sample(period)
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

    from ._job import RunResult
    from ._locate import Covering

    result = _one_of("result", result, (Covering, RunResult))
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
    from ._locate import CutterLocation

    location = _one_of("location", location, (CutterLocation,))
    height = None if tolerance is None else float(_options.number("tolerance", tolerance))
    if height is not None and not _LEAST <= height <= _MOST:
        raise ArgumentError(f"tolerance = {height} mm cannot be drawn", "tolerance", None, height)
    figure, (row,) = _figure(1, f"error of one cutter location, strip {location.strip_width:.3f} mm")
    curve = location.error_curve
    row.plot(curve[:, 1], curve[:, 2])
    row.axhline(0.0, color="0.4", linewidth=0.8)
    if height is not None:
        row.axhline(height, color="0.4", linestyle="--", linewidth=0.8)
        row.set_ylim(-0.5 * height, 3.0 * height)
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

    from ._job import RunResult
    from ._verbs import CheckResult

    result = _one_of("result", result, (CheckResult, RunResult))
    count = _options.whole("bins", bins, 1)
    if count > _MOST_BINS:
        raise ArgumentError(f"bins = {count} is more than {_MOST_BINS}", "bins", None, count)
    maps = result.maps if hasattr(result, "maps") else [{"height": result.height}]
    heights = np.concatenate([np.asarray(one["height"]) for one in maps]) if maps else np.zeros(0)
    heights = heights[np.isfinite(heights)]
    figure, (row,) = _figure(1, f"deviation of {heights.size} points, mm")
    row.hist(heights, bins=count)
    row.set_xlabel("gouge < 0 < excess, mm")
    return figure  # type: ignore[no-any-return]


def view(
    part: Any = None, result: Any = None, chord: float = 0.05, *, cutter: Any = None, at: int = 0, **plotter: Any
) -> Any:
    """Returns a pyvista Plotter with faces, measured points, passes and the tool.

    Args:
        part: a Part or a Face that is drawn.
        result: a run or covering whose passes are drawn, with points coloured by deviation where it was measured; or a
            check with its measured points; or a Path, a Program, the result of `post` or one cutter location.
        chord: chord tolerance of the drawing [mm].
        cutter: Cutter that is drawn at one cutter location of the result.
        at: index of that location; negative ones count from the end.
        **plotter: keywords of `pyvista.Plotter`; `off_screen=True` draws without a window, for `.screenshot("view.png")`.

    Raises:
        InputError: an argument cannot be drawn.

    Example:
        >>> import trunnion
        >>> plane = trunnion.Part.from_net([[[0, 0, 0], [0, 20, 0]], [[20, 0, 0], [20, 20, 0]]], degree=(1, 1))
        >>> ball = trunnion.Cutter.ball(10, length=60)
        >>> found = trunnion.cover(plane, ball, excess=0.1, gouge=0.01, along="u", method="inclined")
        >>> trunnion.plot.view(plane, found, cutter=ball, at=-1).show()  # doctest: +SKIP
    """
    # Arguments come before the library: what is wrong does not depend on what is installed.
    meshes = _meshes(part, chord)
    result = _placed(result)
    tips, axes = _locations(result)
    outline = None if cutter is None else _outline(cutter, at, len(tips))
    try:
        import pyvista
    except ImportError as error:
        raise TrunnionError("pictures in space need pyvista\n  help: pip install 'trunnion[view]'") from error

    scene = pyvista.Plotter(**plotter)
    maps = _maps(result)
    for vertices, triangles in meshes:
        mesh = pyvista.PolyData.from_regular_faces(vertices, triangles)
        # Measured points lie on the faces, and would be half hidden by them.
        scene.add_mesh(mesh, color="lightgrey", opacity=0.4 if maps else 1.0)
    _add_deviation(scene, maps)
    for tip in _runs(result, tips):
        scene.add_lines(tip, color="steelblue", width=2, connected=True)
    if outline is not None:
        _add_tool(scene, outline, tips[at], axes[at])
    scene.add_axes()
    return scene


def _meshes(part: Any, chord: Any) -> list[Any]:
    """Returns vertices and triangles of each face."""
    from ._trunnion import Face, Part

    height = float(_options.number("chord", chord))
    if not height > 0.0:
        raise ArgumentError(f"chord = {height} is not above 0", "chord", None, height)
    if part is None:
        return []
    if isinstance(_one_of("part", part, (Part, Face)), Face):
        return [part.mesh(height)]
    return [face.mesh(height) for face in part.faces] or [part.mesh()]


def _placed(result: Any) -> Any:
    """Returns a result that has cutter locations or measured points; for that of a post its program."""
    from ._job import RunResult
    from ._locate import Covering, CutterLocation
    from ._path import Path
    from ._program import Program
    from ._verbs import CheckResult, PostResult

    if result is None:
        return None
    kinds = (RunResult, Covering, CheckResult, Path, Program, PostResult, CutterLocation)
    found = _one_of("result", result, kinds)
    return found.program if isinstance(found, PostResult) else found


def _maps(result: Any) -> list[Any]:
    """Returns measured points with their heights, one dict for each face."""
    from ._verbs import CheckResult

    maps = [{"point": result.point, "height": result.height}] if isinstance(result, CheckResult) else getattr(result, "maps", [])
    return [one for one in maps if len(one["height"])]


def _add_deviation(scene: Any, maps: Any) -> None:
    """Adds measured points, one scale of colours for all of them."""
    import numpy as np
    import pyvista

    if not maps:
        return
    heights = np.concatenate([one["height"] for one in maps])
    cut = np.isfinite(heights)
    cloud = pyvista.PolyData(np.concatenate([one["point"] for one in maps])[cut])
    cloud["deviation, mm"] = heights[cut]
    # A gouge and an excess of the same size look equally strong.
    most = max(float(np.abs(heights[cut]).max(initial=0.0)), 1e-9)
    scale = {"vertical": True, "n_labels": 3, "fmt": "%+.4f", "label_font_size": 14, "title_font_size": 14}
    scene.add_mesh(
        cloud, scalars="deviation, mm", cmap="coolwarm", clim=(-most, most), point_size=6, scalar_bar_args=scale
    )


def _locations(result: Any) -> tuple[Any, Any]:
    """Returns tips and tool axes of all cutter locations, (n, 3) each."""
    import numpy as np

    if hasattr(result, "tip"):
        return np.atleast_2d(result.tip), np.atleast_2d(result.axis)
    passes = getattr(result, "passes", [])
    tips, axes = ([np.zeros((0, 3)), *(one[name] for one in passes)] for name in ("tip", "axis"))
    return np.concatenate(tips), np.concatenate(axes)


def _runs(result: Any, tips: Any) -> list[Any]:
    """Returns the tips of each pass; of a path without passes those of the whole."""
    runs = [one["tip"] for one in result.passes] if hasattr(result, "passes") else [tips]
    return [tip for tip in runs if len(tip) > 1]


def _outline(cutter: Any, at: Any, locations: int) -> Any:
    """Returns the outline of a cutter with its shank, (n, 2); refuses the index of a location that there is not."""
    outline = _options.as_cutter(cutter).outline()
    try:
        index = locations if isinstance(at, bool) else operator.index(at)
    except TypeError:
        index = locations
    if not -locations <= index < locations:
        shown = repr(at) if isinstance(at, str) or abs(index) < _MOST and isinstance(at, int) else type(at).__name__
        message = f"at = {shown} is not the index of one of {locations} cutter locations"
        raise ArgumentError(message + "\n  help: give a result that has them", "at", None, at)
    return outline


def _add_tool(scene: Any, outline: Any, tip: Any, axis: Any) -> None:
    """Adds a cutter, its outline turned about the tool axis of a location."""
    import numpy as np
    import pyvista

    # Closed above.
    outline = np.concatenate([outline, [[0.0, outline[-1, 1]]]])
    profile = pyvista.lines_from_points(np.column_stack([outline[:, 0], np.zeros(len(outline)), outline[:, 1]]))
    tool = profile.extrude_rotate(resolution=48, capping=False)
    up = axis / np.linalg.norm(axis)
    # Any direction across the axis will do: the tool is round.
    side = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    placed = np.eye(4)
    placed[:3, :] = np.column_stack([side, np.cross(up, side), up, tip])
    tool = tool.transform(placed, inplace=False).compute_normals(feature_angle=30, split_vertices=True, auto_orient_normals=True)
    scene.add_mesh(tool, color="goldenrod", opacity=0.8, smooth_shading=True)
