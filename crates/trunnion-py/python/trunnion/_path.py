"""Paths of cutter locations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _options, _picture
from ._errors import ArgumentError
from ._progress import Progress, adapted
from ._result import Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


class Path(Table):
    """Cutter locations, joined by straight moves of the tip and great circles of the tool axis.

    Args:
        tip: tips, (n, 3) [mm].
        axis: unit vectors from tip to holder, (n, 3), or one (3,) for all.

    Example:
        >>> import trunnion
        >>> path = trunnion.Path([[0, 0, 0], [10, 0, 0]], [[0, 0, 1], [0, 0.6, 0.8]])
        >>> len(path.interpolate(max_step=4.0, max_turn=0.1))
        8
    """

    _columns = ("tip", "axis")

    def __init__(self, tip: "ArrayLike", axis: "ArrayLike" = (0.0, 0.0, 1.0)) -> None:
        import numpy as np

        from . import _trunnion

        self.tip: NDArray[np.float64] = floats("tip", tip)
        self.axis: NDArray[np.float64] = floats("axis", axis)
        if self.axis.shape == (3,) and self.tip.ndim == 2:
            self.axis = np.ascontiguousarray(np.broadcast_to(self.axis, self.tip.shape))
        # Refused here rather than at the first use.
        _trunnion.interpolate(self.tip, self.axis, 1e300, 1e300)

    @classmethod
    def read(cls, path: Any, *, progress: Progress = None, **more: Any) -> "Path":
        """Reads the locations of a CL file or program; see `trunnion.read`.

        Example:
            >>> import trunnion
            >>> len(trunnion.Path.read(b"UNITS/MM\\nFEDRAT/600,MMPM\\nGOTO/0,0,0,0,0,1\\nGOTO/9,0,0,0,0,1\\nFINI\\n", suffix=".cls"))
            2
        """
        from ._program import read

        program = read(path, progress=progress, **more)
        return cls(program.tip, program.axis)

    @classmethod
    def from_cl(cls, text: str) -> "Path":
        """Reads the locations of APT/CL text.

        Example:
            >>> import trunnion
            >>> trunnion.Path.from_cl("UNITS/MM\\nFEDRAT/600,MMPM\\nGOTO/0,0,0,0,0,1\\nGOTO/9,0,0,0,0,1\\nFINI\\n").length
            9.0
        """
        _options.instance("text", text, str, "a file is read by trunnion.Path.read")
        try:
            content = text.encode(errors="surrogateescape")
        except UnicodeEncodeError as error:
            raise ArgumentError(f"text[{error.start}] = {text[error.start]!r} is no character", "text", (error.start,), text[error.start]) from None
        return cls.read(content, suffix=".cls")

    @property
    def length(self) -> float:
        """Travel of the tip [mm]."""
        import numpy as np

        return float(np.linalg.norm(np.diff(self.tip, axis=0), axis=1).sum())

    def interpolate(
        self, max_step: float, max_turn: float, *, deg: bool = False, progress: Progress = None
    ) -> "Path":
        """Inserts locations so that neither steps nor turns are longer; given ones are kept.

        Args:
            max_step: largest distance of neighbouring tips [mm].
            max_turn: largest angle of neighbouring tool axes [rad, or degrees with deg].
            progress: callable of (stage, done, total), or tqdm.

        Example:
            >>> import trunnion
            >>> path = trunnion.Path([[0, 0, 0], [10, 0, 0], [20, 5, 0]])
            >>> len(path.interpolate(max_step=5, max_turn=10, deg=True))
            6
        """
        from . import _trunnion

        step, turn = float(_options.number("max_step", max_step)), _options.radians("max_turn", max_turn, deg)
        return Path(*_trunnion.interpolate(self.tip, self.axis, step, turn, adapted(progress)))

    def smooth(
        self, tip: float = 0.005, axis: float = 1e-3, *, deg: bool = False, progress: Progress = None
    ) -> "SmoothPath":
        """Lays a C3 path within tolerance of the straight moves; corners are rounded within it, or kept.

        Args:
            tip: largest distance of the tip [mm].
            axis: largest angle of the tool axis [rad, or degrees with deg].
            progress: callable of (stage, done, total), or tqdm.

        Raises:
            InputError: two locations are the same, or their axes opposite.

        Example:
            >>> import trunnion
            >>> path = trunnion.Path([[0, 0, 0], [10, 0, 0], [20, 5, 0]])
            >>> path.smooth(tip=0.01, axis=0.1, deg=True).tip_deviation <= 0.01
            True
        """
        from . import _trunnion

        distance, angle = float(_options.number("tip", tip)), _options.radians("axis", axis, deg)
        return SmoothPath(*_trunnion.smooth(self.tip, self.axis, distance, angle, adapted(progress)))

    def to_cl(self, feed: float = 1000.0) -> str:
        """Returns the locations as APT/CL text with one feed [mm/min].

        Example:
            >>> import trunnion
            >>> path = trunnion.Path([[0, 0, 0], [10, 0, 0], [20, 5, 0]])
            >>> path.to_cl(feed=800).splitlines()[2]
            'FEDRAT/800,MMPM'
        """
        speed = float(_options.number("feed", feed))
        if speed <= 0.0:
            raise ArgumentError(f"feed = {speed} is not a number above 0", "feed", None, feed)
        lines = ["UNITS/MM", "MULTAX/ON", f"FEDRAT/{speed:.9g},MMPM"]
        for row, axis in zip(self.tip.tolist(), self.axis.tolist()):
            lines.append("GOTO/" + ",".join(f"{value:.9f}" for value in [*row, *axis]))
        return "\n".join([*lines, "FINI", ""])

    def __len__(self) -> int:
        return len(self.tip)

    def __repr__(self) -> str:
        return f"Path({len(self)} locations, {self.length:.3f} mm)"

    def _repr_html_(self) -> str:
        return _picture.path(f"{len(self)} cutter locations, {self.length:.1f} mm", self.tip, self.axis)


def floats(name: str, value: Any) -> Any:
    """Returns lists and whole numbers as an array; arrays of other types stay, and are refused where they are used."""
    import numpy as np

    if isinstance(value, np.ndarray) and value.dtype.kind not in "iu":
        return value
    try:
        return np.ascontiguousarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        kind = type(value).__name__
        raise ArgumentError(f"{name} = {kind} is no array of numbers: {error}", name, None, kind) from None


class SmoothPath:
    """C3 curves of tip and tool axis.

    Attributes:
        ranges: parameter at both ends of each span, (k, 2).
        coefficients: ascending coefficients of each span from its start: tip, axis vector (not unit), contact, (k, 6, 9).
        starts: index of the first span of each curve; the tool rests where two curves meet.
        tip_deviation: upper bound on the distance from the straight moves [mm].
        axis_deviation: upper bound on the angle from them [rad].
    """

    def __init__(self, ranges: Any, coefficients: Any, starts: list[int], deviation: list[float]) -> None:
        self.ranges: NDArray[np.float64] = ranges
        self.coefficients: NDArray[np.float64] = coefficients
        self.starts = starts
        self.tip_deviation, self.axis_deviation = deviation

    def linearise(
        self, tip: float = 0.005, axis: float = 1e-3, *, deg: bool = False, progress: Progress = None
    ) -> Path:
        """Divides the curves into straight moves of the tip.

        Args:
            tip: largest distance of a move from the curve, bounded by its second derivative [mm].
            axis: largest angle of the tool axis from the curve [rad, or degrees with deg].
            progress: callable of (stage, done, total), or tqdm.

        Example:
            >>> import trunnion
            >>> path = trunnion.Path([[0, 0, 0], [10, 0, 0], [20, 5, 0]])
            >>> len(path.smooth(tip=0.01).linearise(tip=0.01)) > len(path)
            True
        """
        from . import _trunnion

        distance, angle = float(_options.number("tip", tip)), _options.radians("axis", axis, deg)
        found = _trunnion.linearise(self.ranges, self.coefficients, distance, angle, adapted(progress))
        return Path(*found)

    def __repr__(self) -> str:
        return f"SmoothPath({len(self.starts)} curves, {len(self.ranges)} spans)"

    def _repr_html_(self) -> str:
        return self.linearise(0.01, 0.01)._repr_html_()
