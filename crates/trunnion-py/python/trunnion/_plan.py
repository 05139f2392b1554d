"""Speed plans for tables of axis positions."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Mapping, NamedTuple, Sequence

from . import _options, _picture
from ._errors import ArgumentError, InputError
from ._progress import Progress, adapted
from ._result import Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_KNOWN = ("no_guarantee", "time_tolerance", "third_tolerance", "period")


class Limits:
    """Limits of axes: velocity, acceleration, jerk per axis, in the units of the table per second.

    Args:
        axes: for each axis a dict of `vel`, `acc`, `jerk`, optionally `vel_minus`, `acc_minus`, `chord`; or a sequence of
            velocity, acceleration and jerk.
        path: optionally `feed`, `acc`, `jerk`, `start`, `end` along s.

    Example:
        >>> import trunnion
        >>> limits = trunnion.Limits({"X": (500, 5000, 1e5), "B": {"vel": 2.6, "acc": 5.2, "jerk": 105}})
        >>> limits.axes["X"]["acc"]
        5000.0
    """

    def __init__(self, axes: Mapping[str, Any], path: Mapping[str, float] | None = None) -> None:
        axes = _options.mapping("axes", axes, "limits by axis")
        path = _options.mapping("path", {} if path is None else path, "limits along s")
        self.axes: dict[str, dict[str, float]] = {str(name): _axis(str(name), one) for name, one in axes.items()}
        self.path: dict[str, float] = {str(name): _finite(f"path.{name}", value) for name, value in path.items()}

    @classmethod
    def of(cls, machine: Any, *, deg: bool = False) -> "Limits":
        """Returns the limits of a machine: a Machine, or what makes one [mm, rad or degrees, s].

        Example:
            >>> import trunnion
            >>> sorted(trunnion.Limits.of("bc-trunnion").axes)
            ['B', 'C', 'X', 'Y', 'Z']
        """
        from ._trunnion import Machine

        if not isinstance(machine, Machine):
            machine = Machine(machine)
        figures = zip(machine.velocity(deg=deg), machine.acceleration(deg=deg), machine.jerk(deg=deg))
        return cls({name: tuple(map(float, row)) for name, row in zip(machine.axes, figures)})

    @classmethod
    def read(cls, path: Any) -> "Limits":
        """Reads a limits file (TOML).

        Example:
            >>> import trunnion
            >>> import os, tempfile
            >>> file = os.path.join(tempfile.mkdtemp(), "limits.toml")
            >>> _ = open(file, "w").write(trunnion.Limits({"X": (1, 2, 3)}).to_toml())
            >>> trunnion.Limits.read(file).axes["X"]["vel"]
            1.0
        """
        from . import _trunnion

        name = _options.path("path", path)
        try:
            with open(name, encoding="utf-8") as text:
                found = _trunnion.toml_data(text.read())
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{name}: {error}") from None
        return cls(found.get("axis", {}), found.get("path"))

    def to_toml(self) -> str:
        """Returns the limits as a limits file.

        Example:
            >>> import trunnion
            >>> "[axis.X]" in trunnion.Limits({"X": (1, 2, 3)}).to_toml()
            True
        """
        from . import _trunnion

        return _trunnion.toml_text({"axis": self.axes, "path": self.path})

    def __repr__(self) -> str:
        return f"Limits({self.axes!r}, path={self.path!r})"


def _axis(name: str, value: Any) -> dict[str, float]:
    if isinstance(value, Mapping):
        return {key: _finite(f"{name}.{key}", one) for key, one in value.items()}
    try:
        entries = list(value)
    except TypeError:
        entries = []
    if len(entries) not in (2, 3):
        message = f"limits[{name!r}] = {value!r} is not velocity, acceleration and jerk"
        raise ArgumentError(message + "\n  help: write (vel, acc, jerk), or a dict of them", "limits", None, value)
    return {key: _finite(f"{name}.{key}", one) for key, one in zip(("vel", "acc", "jerk"), entries)}


def _finite(name: str, value: Any) -> float:
    return float(_options.number(f"limits.{name}", value))


class Motion(NamedTuple):
    """Axes at servo ticks; the columns of arrays are the axes.

    Attributes:
        t: time, (n,) [s].
        position: (n, axes).
        velocity: (n, axes), per second.
        acceleration: (n, axes), per second squared.
        jerk: (n, axes), per second cubed.
    """

    t: "NDArray[np.float64]"
    position: "NDArray[np.float64]"
    velocity: "NDArray[np.float64]"
    acceleration: "NDArray[np.float64]"
    jerk: "NDArray[np.float64]"


class Plan(Table):
    """Schedule of a path within limits.

    Attributes:
        axes: names of the axes.
        duration: time of the whole path [s].
        lower_bound: no schedule within the velocity and acceleration limits is faster [s].
        within_limits: True if every limit is kept everywhere.
        summary: everything as `trunnion feed --json` prints it. With `no_guarantee` these three are measured when they are
            first asked for, which takes longer than the plan.
        s, t, speed, acceleration: rows of the schedule, (n,) each.
    """

    _columns = ("s", "t", "speed", "acceleration")

    def __init__(self, native: Any, limits: Limits) -> None:
        self._native = native
        self.limits = limits
        self.axes: list[str] = native.axes
        self.duration: float = native.duration
        self._rows: Any = None

    @property
    def lower_bound(self) -> float:
        """Time that no schedule within the velocity and acceleration limits undercuts [s]."""
        return float(self._native.lower_bound)

    @property
    def within_limits(self) -> bool:
        """True if every limit is kept everywhere."""
        return bool(self._native.within_limits)

    @property
    def summary(self) -> dict[str, Any]:
        """Figures of the plan."""
        found: dict[str, Any] = self._native.summary()
        return found

    def _schedule(self, column: int) -> Any:
        if self._rows is None:
            self._rows = self._native.schedule()
        return self._rows[:, column]

    @property
    def s(self) -> "NDArray[np.float64]":
        """Path parameter of each row, (n,)."""
        return self._schedule(0)

    @property
    def t(self) -> "NDArray[np.float64]":
        """Time at each row, (n,) [s]."""
        return self._schedule(1)

    @property
    def speed(self) -> "NDArray[np.float64]":
        """ds/dt at each row, (n,)."""
        return self._schedule(2)

    @property
    def acceleration(self) -> "NDArray[np.float64]":
        """d2s/dt2: from each row to the next (optimal), or at the row (jerk), (n,)."""
        return self._schedule(3)

    def sample(self, period: float) -> Motion:
        """Returns the axes at every servo period, from the start to the end of the path.

        Args:
            period: time between two rows [s].

        Raises:
            InputError: the period is not above 0, or too short for the memory.

        Example:
            >>> import trunnion
            >>> table = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}
            >>> plan = trunnion.plan(table, {"X": (100, 1000, 20000)})
            >>> motion = plan.sample(0.001)
            >>> float(motion.position[-1, 0])
            10.0
        """
        rows = self._native.sample(float(_options.number("period", period)))
        width = len(self.axes)
        parts = [rows[:, 1 + order * width : 1 + (order + 1) * width] for order in range(4)]
        return Motion(rows[:, 0], *parts)

    def __repr__(self) -> str:
        return f"Plan({self.duration:.6f} s, lower bound {self.lower_bound:.6f} s, axes={' '.join(self.axes)})"

    def _repr_html_(self) -> str:
        motion = self.sample(max(self.duration / 1000.0, 1e-6))
        title = f"velocity over limit: {self.duration:.3f} s, lower bound {self.lower_bound:.3f} s"
        lines = {}
        for index, name in enumerate(self.axes):
            limit = self.limits.axes.get(name, {}).get("vel", float("nan"))
            lines[name] = motion.velocity[:, index] / limit
        return _picture.chart(title, motion.t, lines, 1.0)


def _table(table: Any, axes: Sequence[str] | None) -> tuple[list[str], Any]:
    """Returns names of columns, and a list of them or an array of rows."""
    if isinstance(table, (str, os.PathLike)):
        return _csv(_options.path("table", table))
    if axes is not None:
        known = [_options.word(f"axes[{index}]", axis) for index, axis in enumerate(_options.sequence("axes", axes, "names of axes"))]
        names = ["s", *(f"{axis}{order}" for axis in known for order in ("", "1", "2"))]
        return names, table
    if isinstance(table, Mapping) or hasattr(table, "columns"):
        found = list(table.columns if hasattr(table, "columns") else table)
        return [str(name) for name in found], _columns({str(name): table[name] for name in found})
    if isinstance(getattr(getattr(table, "dtype", None), "names", None), tuple):
        return list(table.dtype.names), _columns({name: table[name] for name in table.dtype.names})
    kind = type(table).__name__
    remedy = "give a dict of columns, a DataFrame, a CSV file, or an array with axes=[..]"
    raise ArgumentError(f"table = {kind} has no names of columns\n  help: {remedy}", "table", None, kind)


def _columns(table: Mapping[str, Any]) -> list[Any]:
    """Returns columns of numbers of one length; those that are float64 as they are."""
    import numpy as np

    columns: list[Any] = []
    for name, given in table.items():
        column = np.asarray(given)
        if column.dtype.kind not in "fiu" or column.ndim != 1:
            value = f"dtype {column.dtype}, shape {column.shape}"
            raise ArgumentError(f"table[{name!r}] = {value} is not a column of numbers", "table", None, value)
        if columns and len(column) != len(columns[0]):
            shape = (len(column),)
            message = f"table[{name!r}] = shape {shape} is not {(len(columns[0]),)} as the first column"
            raise ArgumentError(message, "table", None, shape)
        columns.append(np.ascontiguousarray(column, dtype=float))
    return columns


def _gap(names: Sequence[str], columns: Sequence[Any]) -> ArgumentError | None:
    """Returns the error of the first number in columns that is none."""
    import numpy as np

    for name, column in zip(names, columns):
        wrong = np.flatnonzero(~np.isfinite(column))
        if len(wrong):
            index, value = int(wrong[0]), float(column[wrong[0]])
            message = f"table[{name!r}][{index}] = {value} is not a finite number"
            return ArgumentError(message, "table", (index,), value)
    return None


def _csv(name: str) -> tuple[list[str], Any]:
    import numpy as np

    try:
        with open(name, encoding="utf-8") as text:
            lines = [(number, line.strip()) for number, line in enumerate(text, 1)]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{name}: {error}") from None
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    if not lines:
        raise InputError(f"{name}: the table is empty")
    names = [field.strip() for field in lines[0][1].split(",")]
    rows, faults = [], []
    for number, line in lines[1:]:
        fields = line.split(",")
        try:
            rows.append([float(field) for field in fields])
        except ValueError as error:
            faults.append(f"{name}:{number}: {error}")
        if len(fields) != len(names):
            faults.append(f"{name}:{number}: {len(fields)} fields, and {len(names)} columns")
    if faults:
        raise InputError(*faults)
    return names, np.array(rows, dtype=float).reshape(len(rows), len(names))


@_options.pythonic
def plan(
    table: Any,
    limits: Any,
    method: str = "jerk",
    window: int | None = None,
    *,
    axes: Sequence[str] | None = None,
    progress: Progress = None,
    **more: Any,
) -> Plan:
    """Plans the speed along a path of axis positions, as fast as the axes allow.

    Args:
        table: columns `s`, and for each axis NAME, NAME1, NAME2 (value and derivatives by s), optionally NAME3, `feed`,
            `speed`: a dict, DataFrame, structured array or CSV file; or an array (n, 1 + 3 k) with `axes`. Between rows
            the path is the quintic through value and derivatives.
        limits: Limits, a dict for them, a Machine (mm, rad), or a limits file.
        method: "jerk", "optimal" (no jerk limits), "blocks" (classical look-ahead) or "given" (speeds of the table).
        window: rows to look ahead, for a plan as a control makes it row by row.
        axes: names of the axes of an array without names.
        progress: callable of (stage, done, total), or tqdm.
        **more: no_guarantee, time_tolerance, third_tolerance, period as in `trunnion feed`.

    Raises:
        InputError: the table or the limits cannot be used; `messages` has every fault with its row.

    Example:
        >>> import trunnion
        >>> table = {"s": [0, 1, 2], "X": [0, 10, 20], "X1": [10, 10, 10], "X2": [0, 0, 0]}
        >>> plan = trunnion.plan(table, {"X": (100, 1000, 20000)}, method="optimal")
        >>> round(plan.duration, 6), plan.lower_bound <= plan.duration
        (0.3, True)
    """
    from . import _trunnion

    names, values = _table(table, axes)
    found = _limits(limits)
    words = ["table", "--limits=limits", "--method=" + _options.word("method", method)]
    if window is not None:
        words.append(f"--window={_options.whole('window', window)}")
    words += _options.others("plan", _KNOWN, more, plan)
    arguments = (names, values, found.to_toml(), words, adapted(progress))
    if not isinstance(values, list) or axes is not None:
        return Plan(_trunnion.plan(*arguments), found)
    try:
        return Plan(_trunnion.plan_columns(*arguments), found)
    except ArgumentError as error:
        # The message says in which column the number is that is none.
        raise _gap(names, values) or error from None


def _limits(limits: Any) -> Limits:
    from ._trunnion import Machine

    if isinstance(limits, Limits):
        return limits
    if isinstance(limits, Machine):
        return Limits.of(limits)
    if isinstance(limits, Mapping):
        if "axis" in limits and isinstance(limits["axis"], Mapping):
            return Limits(limits["axis"], limits.get("path"))
        return Limits(limits)
    return Limits.read(limits)


class Stream:
    """Plans a path that arrives bit by bit, as a control does: the axes can always stop within the window.

    Args:
        limits: Limits, a dict for them, a Machine, or a limits file; six axes at most.
        method: "jerk" or "optimal".
        window: rows to look ahead, at least 4.
        step: largest distance of two planned rows in s; longer stretches are divided.

    Example:
        >>> import numpy as np, trunnion
        >>> stream = trunnion.Stream({"X": (100, 1000, 20000)}, window=64, step=1.0)
        >>> s = np.linspace(0, 50, 101)
        >>> rows = np.stack([s, s, np.ones(101), np.zeros(101)], axis=1)
        >>> first, rest = stream.push(rows), stream.finish()
        >>> bool(stream.time > 0.5)
        True
    """

    def __init__(self, limits: Any, method: str = "jerk", *, window: int = 512, step: float = 1.0) -> None:
        from . import _trunnion

        _options.choice("method", method, ("jerk", "optimal"))
        length = float(_options.number("step", step))
        found = _limits(limits)
        self.axes = list(found.axes)
        rows = [[one.get("vel", 0.0), one.get("acc", 0.0), one.get("jerk", 0.0)] for one in found.axes.values()]
        if method == "optimal":
            # Jerk limits are not looked at, but have to be numbers above 0.
            rows = [[vel, acc, jerk or acc] for vel, acc, jerk in rows]
        ahead = _options.whole("window", window)
        self._native = _trunnion.NativeStream(self.axes, rows, method == "jerk", ahead, length)

    def push(self, rows: Any) -> "NDArray[np.float64]":
        """Takes rows of the path, and returns the steps that are decided by them. After Ctrl-C the stream cannot go on.

        Args:
            rows: s, then value and two derivatives by s of each axis, (n, 1 + 3 k).

        Returns:
            (m, 8): s at start and end of the step, its time and duration [s], ds/dt at both ends, d2s/dt2 at both ends.

        Example:
            >>> import trunnion
            >>> stream = trunnion.Stream({"X": (100, 1000, 20000)}, window=16)
            >>> stream.push([[0, 0, 1, 0], [1, 1, 1, 0]]).shape[1]
            8
        """
        return self._native.push(rows)

    def finish(self) -> "NDArray[np.float64]":
        """Ends the path at rest, and returns the remaining steps as `push` does.

        Example:
            >>> import trunnion
            >>> stream = trunnion.Stream({"X": (100, 1000, 20000)}, window=16)
            >>> _ = stream.push([[0, 0, 1, 0], [1, 1, 1, 0]])
            >>> float(stream.finish()[-1, 5])
            0.0
        """
        return self._native.finish()

    @property
    def time(self) -> float:
        """Time at the end of the steps returned so far [s]."""
        return float(self._native.time)

    @property
    def bounds(self) -> dict[str, float] | None:
        """Guaranteed upper bounds of the ratios to the limits so far; None for "optimal", which keeps them."""
        found: dict[str, float] | None = self._native.bounds
        return found
