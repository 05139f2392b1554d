"""Checks and posts: the verbs of the command line as functions."""

from __future__ import annotations

import functools
import os

from . import _options, _picture
from ._errors import InputError, TrunnionError, warn
from ._program import Program, quietly
from ._progress import Progress, adapted
from ._result import Table

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Mapping, Sequence

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

_CHECK = (
    "set", "block_delete", "tool_table", "ini", "sub_dir", "passive", "offset", "grid", "stock", "fixture",
    "clearance", "chord", "stock_cell", "what_if", "accept", "period", "no_jerk", "shank", "holder",
    "reversed_rotaries", "flip",
)
_POST = (
    "set", "block_delete", "tool_table", "ini", "sub_dir", "passive", "from_machine", "from_origin",
    "from_rotation", "from_tool_length", "from_reversed_rotaries", "tool", "reduce", "unwind", "max_feed", "feed",
    "motion", "period", "reversed_rotaries", "spindle", "coolant", "template",
)

#: Dialects that are read under another name than the first word of the one they are written under.
_READ_AS = {"g93": "linuxcnc", "iso": "linuxcnc"}


class CheckResult(Table):
    """Verdict of a check.

    Attributes:
        passed: True if every tolerance and limit is kept.
        summary: everything as `trunnion check --json` prints it; mm, degrees, s.
        failures: what is broken, in words.
        warnings: remarks, in words.
        face, point, height, line: measured points, one row each: number of the face, position (n, 3) [mm], height over
            the face (negative is a gouge, NaN where nothing cuts) [mm], line of the program that cuts last there.
    """

    _columns = ("face", "point", "height", "line")

    def __init__(self, found: Mapping[str, Any]) -> None:
        self.summary: dict[str, Any] = found["summary"]
        self.passed: bool = found["passed"]
        self._table: str = found["table"]
        self._maps: Sequence[Mapping[str, Any]] = found["maps"]

    @property
    def failures(self) -> list[str]:
        """Broken tolerances and limits, in words."""
        return list(self.summary["failures"])

    @property
    def warnings(self) -> list[str]:
        """Remarks about program, part and machine, in words."""
        return list(self.summary.get("warnings", []))

    @property
    def face(self) -> "NDArray[np.int64]":
        """Number of the face of each measured point, (n,)."""
        import numpy as np

        return np.concatenate([np.full(len(one["height"]), one["face"]) for one in self._maps] or [np.zeros(0, int)])

    @property
    def point(self) -> "NDArray[np.float64]":
        """Measured points, (n, 3) [mm]."""
        return _joined(self._maps, "point", (0, 3))

    @property
    def height(self) -> "NDArray[np.float64]":
        """Height of the cut surface over the face at each point, (n,) [mm]."""
        return _joined(self._maps, "height", (0,))

    @property
    def line(self) -> "NDArray[np.int64]":
        """Line of the program that cuts last at each point, 0 for none, (n,)."""
        return _joined(self._maps, "line", (0,)).astype("int64")

    def to_dict(self) -> dict[str, Any]:
        """Returns the summary."""
        return dict(self.summary)

    def to_pandas(self) -> Any:
        """Returns the measured points as a DataFrame."""
        import pandas as pd

        x, y, z = self.point.T
        columns = {"face": self.face, "x": x, "y": y, "z": z, "height": self.height, "line": self.line}
        return pd.DataFrame(columns)

    def __str__(self) -> str:
        return self._table

    def __repr__(self) -> str:
        return f"CheckResult(passed={self.passed}, failures={len(self.failures)})"

    def _repr_html_(self) -> str:
        import numpy as np

        rows: list[tuple[str, object]] = [("verdict", "kept" if self.passed else "NOT KEPT")]
        rows += [("broken", failure) for failure in self.failures]
        heights = self.height[np.isfinite(self.height)]
        if not heights.size:
            return _picture.table(rows)
        counts, edges = np.histogram(heights, bins=60)
        picture = _picture.chart("points by deviation, mm", 0.5 * (edges[1:] + edges[:-1]), {"points": counts})
        return _picture.table(rows) + picture


def _joined(maps: Sequence[Mapping[str, Any]], name: str, empty: tuple[int, ...]) -> Any:
    import numpy as np

    return np.concatenate([one[name] for one in maps]) if maps else np.zeros(empty)


def _machine(machine: Any, folder: _options.Scratch) -> tuple[str, list[str]]:
    """Returns the machine as an option, and the options of its setup if it is a Machine."""
    from ._trunnion import Machine

    machine = _options.as_machine(machine)
    name = _options.machine_file(machine, folder)
    if not isinstance(machine, Machine):
        return name, []
    origin, rotation, tool_length = machine._setup()
    setup = [
        "--origin=" + _options.numbers("origin", origin, 3),
        "--rotation=" + _options.angles("rotation", rotation, 3, False),
    ]
    if tool_length:
        setup.append(f"--tool-length={tool_length!r}")
    return name, setup


@_options.pythonic
def check(
    program: Any,
    *,
    job: Any = None,
    machine: Any = None,
    part: Any = None,
    part_rotation: "ArrayLike | None" = None,
    faces: Sequence[int] = (),
    cutter: Any = None,
    tolerance: "ArrayLike | None" = None,
    dialect: str | None = None,
    tool_length: Any = None,
    origin: "ArrayLike | None" = None,
    rotation: "ArrayLike | None" = None,
    deg: bool = False,
    output: Any = None,
    progress: Progress = None,
    **more: Any,
) -> CheckResult:
    """Simulates a program and measures it against part and machine, as `trunnion check` does.

    Args:
        program: NC program, CL file or table of setpoints; a path, or the content as bytes.
        job: job file from which everything else is taken.
        machine: name, file or dict of the machine, or a Machine with its setup.
        part: surface JSON or STEP file; without one only the machine is audited.
        part_rotation: rotation by which the part becomes the workpiece, about its x, then y, then z, (3,) [rad, or degrees
            with deg].
        faces: numbers of the faces that are cut; all if empty.
        cutter: Cutter, words as "R=10,r=6", or a dict of them by tool number.
        tolerance: largest excess and deepest gouge, (2,) [mm].
        dialect: dialect of the program; else its text decides.
        tool_length: gauge point to tip [mm], or a dict by tool number; else the length of the cutter.
        origin: workpiece origin in machine coordinates with all axes at zero, (3,) [mm].
        rotation: rotation of the workpiece about x, then y, then z, (3,) [rad, or degrees with deg].
        output: folder for summary.json, report.html, deviation.vtp, stock.stl.
        progress: callable of (stage, done, total), or tqdm.
        **more: the other options of `trunnion check`: stock, fixture, clearance, grid, what_if, accept, ...

    Raises:
        InputError: options or files cannot be used. A broken tolerance is a result, not an exception.

    Example:
        >>> import trunnion
        >>> program = b"G21 G90 G94\\nT1 M6\\nM3 S1000\\nG43 H1\\nG0 X0 Y0 Z50 B0 C0\\nG1 X10 F600\\nM2\\n"
        >>> machine = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120)
        >>> trunnion.check(program, machine=machine).passed
        True
    """
    from . import _trunnion

    deg = _options.truth("deg", deg)
    with _options.Scratch() as folder:
        file = _options.as_file("program", program, ".nc", folder)
        words = [file]
        if job is not None:
            words += ["--job", _options.path("job", job)]
        if machine is not None:
            name, setup = _machine(machine, folder)
            words += ["--machine", name]
            # What is given takes the place of what the machine has, each by itself.
            given = {"--origin": origin, "--rotation": rotation, "--tool-length": tool_length}
            words += [one for one in setup if given[one.partition("=")[0]] is None]
        if part is not None:
            words += ["--part", _options.path("part", part)]
        if part_rotation is not None:
            words.append("--part-rotation=" + _options.angles("part_rotation", part_rotation, 3, deg))
        words += _options.faces_option(faces)
        if cutter is not None:
            words += _cutters(cutter)
        if tolerance is not None:
            words.append("--tolerance=" + _options.numbers("tolerance", tolerance, 2))
        if dialect is not None:
            words.append("--dialect=" + _options.word("dialect", dialect))
        if tool_length is not None:
            words += _options.per_tool("tool_length", tool_length, _options.number)
        if origin is not None:
            words.append("--origin=" + _options.numbers("origin", origin, 3))
        if rotation is not None:
            words.append("--rotation=" + _options.angles("rotation", rotation, 3, deg))
        if output is not None:
            words += ["--output", _options.path("output", output)]
        words += _options.others("check", _CHECK, more, check)
        return CheckResult(_named(lambda: _trunnion.check(words, adapted(progress)), file, folder))


def _cutters(cutter: Any) -> list[str]:
    def shank(_: str, one: Any) -> str:
        return _options.shank_words(one)

    words = _options.per_tool("cutter", cutter, lambda _, one: _options.cutter_words(one))
    return words + [one for one in _options.per_tool("shank", cutter, shank) if not one.endswith("=")]


def _named(call: Any, file: str, folder: _options.Scratch) -> Any:
    """Calls; messages about content in a temporary file name it `program`."""
    if not folder.holds(file):
        return call()
    try:
        found = call()
    except InputError as error:
        raise type(error)(*[one.replace(file, "program") for one in error.messages]) from None
    found["table"] = found["table"].replace(file, "program")
    found["summary"]["program"] = "program"
    for name in ("failures", "warnings"):
        found["summary"][name] = [one.replace(file, "program") for one in found["summary"].get(name, [])]
    return found


class PostResult:
    """Program that was posted.

    Attributes:
        text: the program.
        setup: its setup sheet.
        kept: True if every limit is kept.
        summary: everything as `trunnion post --json` prints it; mm, degrees, s.
        warnings: remarks, in words.
        program: the moves of the text, read back as a Program.
    """

    def __init__(self, found: Mapping[str, Any], text: str, setup: str, reading: Mapping[str, Any]) -> None:
        self.summary: dict[str, Any] = found["summary"]
        self.kept: bool = found["kept"]
        self.warnings: list[str] = found["warnings"]
        self.text = text
        self.setup = setup
        self._reading = reading
        self._table: str = found["table"]

    @property
    def seconds(self) -> tuple[float, float]:
        """Time with feed: as programmed, and with the limits of the axes kept [s]."""
        before, after = self.summary["seconds"]
        return before, after

    @functools.cached_property
    def program(self) -> Program:
        """The moves of the text, read back: tips, tool axes, axis positions, lines.

        Raises:
            InputError: the text cannot be read, as it may be with a template of one's own.
        """
        # Remarks about the input were made when it was posted; this text is our own.
        return quietly(self.text.encode(), **self._reading)

    def to_dict(self) -> dict[str, Any]:
        """Returns the summary."""
        return dict(self.summary)

    def to_pandas(self) -> Any:
        """Returns the moves of the text as a DataFrame."""
        return self.program.to_pandas()

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Hands the moves of the text to Arrow; needs pandas with pyarrow."""
        return self.program.__arrow_c_stream__(requested_schema)

    def __str__(self) -> str:
        return self._table

    def __repr__(self) -> str:
        return f"PostResult(kept={self.kept}, {len(self.text.splitlines())} lines)"

    def _repr_html_(self) -> str:
        before, after = self.seconds
        rows: list[tuple[str, object]] = [
            ("limits", "kept" if self.kept else "NOT KEPT"),
            ("time with feed", f"{before:.2f} s as programmed, {after:.2f} s within the limits"),
            ("lines", len(self.text.splitlines())),
        ]
        shown = _picture.table(rows + [("warning", one) for one in self.warnings])
        try:
            return shown + _picture.path("moves of the program", self.program.tip, self.program.axis)
        except TrunnionError:
            # A template of one's own may write what no reader knows.
            return shown


@_options.pythonic
def post(
    program: Any,
    machine: Any,
    *,
    output: Any = None,
    dialect: str | None = None,
    tolerance: "ArrayLike" = (0.01, 0.05),
    smooth: bool = False,
    source_dialect: str | None = None,
    origin: "ArrayLike | None" = None,
    rotation: "ArrayLike | None" = None,
    tool_length: Any = None,
    deg: bool = False,
    suffix: str | None = None,
    progress: Progress = None,
    **more: Any,
) -> PostResult:
    """Writes a program for a machine from a CL file or another program, as `trunnion post` does.

    Args:
        program: the input; a path, or its content as bytes.
        machine: name, file or dict of the machine, or a Machine with its setup.
        output: file to write; without one the text is only returned.
        dialect: dialect to write [default: that of the machine].
        tolerance: largest deviation from the input: mm at the tip, degrees of the tool axis.
        smooth: fit smooth paths through the moves where that is quicker.
        source_dialect: dialect of the input; else its text decides.
        origin, rotation, tool_length, deg: the setup, as in `check`.
        suffix: ending of the file that bytes would stand in; ".cls" marks a CL file.
        progress: callable of (stage, done, total), or tqdm.
        **more: the other options of `trunnion post`: max_feed, unwind, feed, from_machine, tool, ...

    Raises:
        InputError: options or files cannot be used, or a pose is out of reach.

    Warns:
        TrunnionWarning: something of the input was left out, or a move became much slower; `warnings` has it as well.

    Example:
        >>> import trunnion
        >>> cl = b"UNITS/MM\\nFEDRAT/600,MMPM\\nGOTO/0,0,0,0,0,1\\nGOTO/10,0,0,0,0.6,0.8\\nFINI\\n"
        >>> posted = trunnion.post(cl, "bc-trunnion", dialect="fanuc", suffix=".cls", tool_length=120,
        ...     origin=(-381, -254, -505))
        >>> posted.kept
        True
    """
    from . import _trunnion

    deg = _options.truth("deg", deg)
    with _options.Scratch() as folder:
        file = _options.as_file("program", program, ".nc" if suffix is None else suffix, folder)
        target = _options.path("output", output) if output is not None else os.path.join(folder, "out", "program.nc")
        if output is None:
            os.mkdir(os.path.dirname(target))
        name, setup = _machine(machine, folder)
        words = [file, "--machine", name, "--output", target]
        words.append("--tolerance=" + _options.numbers("tolerance", tolerance, 2))
        if dialect is not None:
            words.append("--dialect=" + _options.word("dialect", dialect))
        if source_dialect is not None:
            words.append("--from=" + _options.word("source_dialect", source_dialect))
        if _options.truth("smooth", smooth):
            words.append("--smooth")
        words += [f"--origin={_options.numbers('origin', origin, 3)}"] if origin is not None else setup[:1]
        words += (
            [f"--rotation={_options.angles('rotation', rotation, 3, deg)}"] if rotation is not None else setup[1:2]
        )
        if tool_length is not None:
            words += _options.per_tool("tool_length", tool_length, _options.number)
        else:
            words += setup[2:]
        reading = {
            "machine": _options.as_machine(machine), "dialect": _read_as(dialect), "origin": origin,
            "rotation": rotation, "deg": deg, "tool_length": tool_length,
            "reversed_rotaries": more.get("reversed_rotaries") is True,
        }
        words += _options.others("post", _POST, more, post)
        try:
            found = _trunnion.post(words, adapted(progress))
        except InputError as error:
            shown = [_shown(one, file, target, folder) for one in error.messages]
            raise type(error)(*shown) from None
        found["table"] = _shown(found["table"], file, target, folder)
        found["warnings"] = [_options.worded(_shown(one, file, target, folder)) for one in found["warnings"]]
        with open(target, encoding="utf-8", errors="replace") as text:
            result = PostResult(found, text.read(), _sheet(target), reading)
    if output is None:
        result.summary["output"] = None
    warn(result.warnings)
    return result


def _shown(message: str, file: str, target: str, folder: _options.Scratch) -> str:
    """Returns a message with temporary files named as what they are."""
    for name, meaning in ((file, "program"), (target, "output")):
        message = message.replace(name, meaning) if folder.holds(name) else message
    return message


def _read_as(dialect: str | None) -> str | None:
    """Returns the dialect in which a written program is read."""
    return None if dialect is None else _READ_AS.get(str(dialect), str(dialect).partition("-")[0])


def _sheet(target: str) -> str:
    stem, _ = os.path.splitext(target)
    try:
        with open(stem + ".setup.txt", encoding="utf-8") as text:
            return text.read()
    except OSError:
        return ""
