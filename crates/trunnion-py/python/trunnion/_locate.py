"""Single cutter locations, and passes over faces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Sequence

from . import _options, _picture
from ._errors import ArgumentError
from ._progress import Progress, adapted

if TYPE_CHECKING:
    import pandas as pd

    from ._trunnion import Cutter, Face, Part


#: Methods of `position`.
_METHODS = ("end-point", "mpm", "hermite", "lead-swivel", "curvature", "sturz", "three-axis", "ball")


class CutterLocation:
    """One cutter location with the strip that it leaves.

    Attributes:
        tip, axis, center, contact: (3,) arrays [mm, unit vector, mm, mm].
        strip_width, chord_width, offset: [mm].
        offset_direction, rotation: [rad].
        front_max, front_max_bound, rear_min, rear_min_bound: errors found and their bounds [mm].
        error_curve: angle on the circle [rad], distance across the feed [mm], error [mm], (n, 3).
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self._found = found

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._found[name]
        except KeyError:
            raise AttributeError(f"a cutter location has no {name}; it has {', '.join(self._found)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._found]

    def to_dict(self) -> dict[str, Any]:
        """Returns all figures by name."""
        return dict(self._found)

    def __repr__(self) -> str:
        return f"CutterLocation(strip_width={self.strip_width:.4f}, tip={self.tip.tolist()}, axis={self.axis.tolist()})"

    def _repr_html_(self) -> str:
        curve = self._found.get("error_curve")
        if curve is None:
            return _picture.table([("strip width", f"{self.strip_width:.4f} mm")])
        title = f"error, mm, across the feed, mm: strip {self.strip_width:.4f} mm"
        return _picture.chart(title, curve[:, 1], {"error": curve[:, 2]})


@_options.pythonic
def position(
    face: "Face",
    cutter: "Cutter",
    *,
    at: Sequence[float],
    feed: Sequence[float],
    tolerance: float = 0.01,
    strip: str = "right",
    side: str = "ahead",
    offset_range: Sequence[float] = (-30.0, 30.0),
    method: str = "end-point",
    lead: float = 5.0,
) -> CutterLocation:
    """Places a cutter at one point of a face, by default for the widest strip.

    Args:
        face: face of a Part.
        cutter: the cutter.
        at: parameters (u, v) of the first end point.
        feed: direction (du, dv) of the feed; its sign counts.
        tolerance: largest error of the strip [mm].
        strip: "right" or "left" of the feed.
        side: "ahead", "behind" or "either": side of the cutter that cuts.
        offset_range: offset directions that are searched [degrees].
        method: "end-point", "mpm", "hermite", "lead-swivel", "curvature", "sturz", "three-axis" or "ball".
        lead: angle of the methods that take one [degrees].

    Raises:
        InputError: the request is wrong, or no location exists there; the message has the reason.

    Example:
        >>> import trunnion
        >>> net = [[[x, y, 0.002 * (x * x + y * y)] for y in (-40, -15, 15, 40)] for x in (-40, -15, 15, 40)]
        >>> face = trunnion.Part.from_net(net).faces[0]
        >>> found = trunnion.position(face, trunnion.Cutter.bull(10, 6), at=(0.5, 0.5), feed=(0, 1))
        >>> bool(found.strip_width > 5)
        True
    """
    from . import _trunnion

    def two(name: str, value: Sequence[float]) -> list[float]:
        return [float(one) for one in _options.numbers(name, value, 2).split(",")]

    for name, value, known in (
        ("strip", strip, ("right", "left")),
        ("side", side, ("ahead", "behind", "either")),
        ("method", method, _METHODS),
    ):
        _options.choice(name, value, known)
    options = {
        "at": two("at", at),
        "feed": two("feed", feed),
        "tolerance": float(_options.number("tolerance", tolerance)),
        "strip": strip,
        "side": side,
        "offset_range": [math.radians(one) for one in two("offset_range", offset_range)],
        "method": method,
        "lead": math.radians(float(_options.number("lead", lead))),
    }
    face = _options.instance("face", face, _trunnion.Face, "take one of a Part: part.faces[0]")
    return CutterLocation(_trunnion.position(face, _options.as_cutter(cutter), options))


class Covering:
    """Passes over faces.

    Attributes:
        passes: dicts of `tip`, `axis`, `contact` (n, 3), `width` (n,), `track` (n, 2) and `face` for each pass.
        length: length of all passes [mm].
        area: area of the faces [mm2].
        unfinished: regions that no pass finishes: dicts of `face`, `area` [mm2], `depth` [mm].
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.passes: list[dict[str, Any]] = found["passes"]
        self.length: float = found["length"]
        self.area: float = found["area"]
        self.stations: int = found["stations"]
        self.worst_gouge: float = found["worst_gouge"]
        self.unfinished: list[dict[str, Any]] = found["unfinished"]

    def to_dict(self) -> dict[str, Any]:
        """Returns all figures and passes by name."""
        return dict(vars(self))

    def to_pandas(self) -> "pd.DataFrame":
        """Returns the stations of all passes as a DataFrame: number of the pass, face, tip, axis, contact, width."""
        return stations(self.passes)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Hands the stations to Arrow; needs pandas with pyarrow."""
        return self.to_pandas().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"Covering({len(self.passes)} passes, {self.length:.1f} mm, {len(self.unfinished)} unfinished regions)"

    def _repr_html_(self) -> str:
        import numpy as np

        if not self.passes:
            return _picture.table([("passes", 0)])
        tip = np.concatenate([one["tip"] for one in self.passes])
        axis = np.concatenate([one["axis"] for one in self.passes])
        return _picture.path(repr(self), tip, axis)


def stations(passes: Sequence[dict[str, Any]]) -> "pd.DataFrame":
    """Returns the stations of passes as rows."""
    import numpy as np
    import pandas as pd

    counts = [len(one["tip"]) for one in passes]
    columns: dict[str, Any] = {
        "pass": np.repeat(np.arange(len(passes)), counts),
        "face": np.repeat(np.array([one["face"] for one in passes], dtype=int), counts),
    }
    for name, letters in (("tip", "xyz"), ("axis", "ijk"), ("contact", "xyz")):
        rows = np.concatenate([np.zeros((0, 3)), *(one[name] for one in passes)])
        columns |= {f"{name}_{letter}": rows[:, index] for index, letter in enumerate(letters)}
    # A strip has its width from one station to the next.
    widths = [np.resize(np.append(one["width"], np.nan), count) for one, count in zip(passes, counts)]
    columns["width"] = np.concatenate([np.zeros(0), *widths])
    return pd.DataFrame(columns)


@_options.pythonic
def cover(
    part: "Part | Face | Sequence[Face]",
    cutter: "Cutter",
    *,
    excess: float = 0.02,
    gouge: float = 0.002,
    along: str = "adaptive",
    pattern: str = "zigzag",
    method: str = "widest",
    lead: float = 0.0,
    tilt: float = 0.0,
    progress: Progress = None,
) -> Covering:
    """Covers faces with passes, by default of the widest strips.

    Args:
        part: a Part, a Face, or several.
        cutter: the cutter.
        excess: largest excess that is left [mm].
        gouge: deepest gouge that is allowed [mm].
        along: "u", "v", "curvature" or "adaptive".
        pattern: "zigzag" or "one-way".
        method: "widest", or "inclined" at lead and tilt everywhere.
        lead, tilt: inclination of the tool [degrees].
        progress: callable of (stage, done, total), or tqdm.

    Raises:
        InputError: the request is wrong.

    Example:
        >>> import trunnion
        >>> plane = trunnion.Part.from_net([[[0, 0, 0], [0, 20, 0]], [[20, 0, 0], [20, 20, 0]]], degree=(1, 1))
        >>> ball = trunnion.Cutter.ball(10, length=60)
        >>> passes = trunnion.cover(plane, ball, excess=0.1, gouge=0.01, along="u", method="inclined").passes
        >>> 10 <= len(passes) <= 13
        True
    """
    from . import _trunnion

    for name, value, known in (
        ("along", along, ("u", "v", "curvature", "adaptive")),
        ("pattern", pattern, ("zigzag", "one-way")),
        ("method", method, ("widest", "inclined")),
    ):
        _options.choice(name, value, known)
    options = {
        "excess": float(_options.number("excess", excess)),
        "gouge": float(_options.number("gouge", gouge)),
        "along": along,
        "pattern": pattern,
        "method": method,
        "lead": math.radians(float(_options.number("lead", lead))),
        "tilt": math.radians(float(_options.number("tilt", tilt))),
    }
    return Covering(_trunnion.cover(faces_of(part), _options.as_cutter(cutter), options, adapted(progress)))


def faces_of(part: Any) -> list[Any]:
    """Returns the faces of a part, of one face, or of several."""
    from ._trunnion import Face, Part

    if isinstance(part, Part) and not len(part):
        remedy = "passes and cutter locations need the faces of a STEP or surface JSON file; drop_cutter takes triangles"
        raise ArgumentError(f"part = {part!r} has no faces\n  help: {remedy}", "part", None, repr(part))
    if isinstance(part, Part):
        return list(part.faces)
    faces = [part] if isinstance(part, Face) else _options.sequence("part", part, "faces")
    remedy = "give a Part, one of its faces, or a list of them"
    return [_options.instance(f"part[{index}]", face, Face, remedy) for index, face in enumerate(faces)]
