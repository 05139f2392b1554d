"""Programs and CL files as arrays."""

from __future__ import annotations

from . import _options, _picture
from ._errors import InputError, warn
from ._progress import Progress, adapted
from ._result import Table

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Mapping

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

#: Machine of programs without rotary words: its rotaries stay at 0, and the tool along +z.
_UPRIGHT = "bc-trunnion"

#: Keywords of the command line that a program may need.
_KNOWN = (
    "set", "block_delete", "tool_table", "ini", "sub_dir", "passive", "tool",
)


class Program(Table):
    """Moves of a program or CL file, one row each.

    Attributes:
        tip: tip of the tool, workpiece frame, (n, 3) [mm].
        axis: unit vector from tip to holder, workpiece frame, (n, 3).
        line: line of the file, counted from 1, (n,) int.
        feed: programmed tip speed, NaN for rapid moves and moves with a time, (n,) [mm/s].
        seconds: programmed time of the move, NaN without one, (n,) [s].
        q: axis positions as programmed, NaN for CL files, (n, 5) [mm, rad].
        warnings: remarks about the file, in words.

    Example:
        >>> import trunnion
        >>> program = trunnion.read(b"UNITS/MM\\nRAPID\\nGOTO/0,0,0,0,0,1\\nFEDRAT/600,MMPM\\nGOTO/30,40,0,0,0,1\\nFINI\\n", suffix=".cls")
        >>> program.length
        50.0
    """

    _columns = ("line", "tip", "axis", "feed", "seconds", "q")

    def __init__(self, name: str, file: str, found: Mapping[str, Any]) -> None:
        self.name = name
        self.tip: NDArray[np.float64] = found["tip"]
        self.axis: NDArray[np.float64] = found["axis"]
        self.line: NDArray[np.int64] = found["line"]
        self.feed: NDArray[np.float64] = found["feed"]
        self.seconds: NDArray[np.float64] = found["seconds"]
        self.q: NDArray[np.float64] = found["q"]
        self.warnings: list[str] = [_worded(one.replace(file, name)) for one in found["warnings"]]

    @property
    def rapid(self) -> "NDArray[np.bool_]":
        """True for rapid moves, (n,)."""
        import numpy as np

        return np.isnan(self.feed) & np.isnan(self.seconds)

    @property
    def steps(self) -> "NDArray[np.float64]":
        """Travel of the tip to each location from the one before, 0 for the first, (n,) [mm]."""
        import numpy as np

        travel = np.linalg.norm(np.diff(self.tip, axis=0), axis=1)
        return np.concatenate([np.zeros(min(1, len(self.tip))), travel])

    @property
    def length(self) -> float:
        """Travel of the tip through all locations [mm]."""
        return float(self.steps.sum())

    @property
    def cutting_length(self) -> float:
        """Travel of the tip with feed [mm]."""
        return float(self.steps[~self.rapid].sum())

    def __len__(self) -> int:
        return len(self.tip)

    def __repr__(self) -> str:
        return f"Program({self.name!r}, {len(self)} moves, {self.length:.3f} mm)"

    def _repr_html_(self) -> str:
        return _picture.path(f"{self.name}: {len(self)} moves, {self.length:.1f} mm", self.tip, self.axis)


@_options.pythonic
def read(
    path: Any,
    *,
    machine: Any = None,
    dialect: str | None = None,
    origin: "ArrayLike | None" = None,
    rotation: "ArrayLike | None" = None,
    tool_length: Any = None,
    reversed_rotaries: bool = False,
    deg: bool = False,
    suffix: str | None = None,
    progress: Progress = None,
    **more: Any,
) -> Program:
    """Reads a CL file or NC program.

    Args:
        path: the file, or its content as bytes.
        machine: the machine that a program is for: name, file, dict, or Machine, whose setup holds where none is given. CL files
            and programs without rotary words need none.
        dialect: "apt", "linuxcnc", "fanuc", "haas", "siemens" or "heidenhain"; else the text decides.
        origin: workpiece origin in machine coordinates with all axes at zero, (3,) [mm].
        rotation: rotation of the workpiece about the fixed x, then y, then z, (3,) [rad, or degrees with deg].
        tool_length: gauge point to tip [mm], or a dict of them by tool number.
        reversed_rotaries: rotaries of the program count against ISO 841.
        suffix: ending of the file that the bytes would stand in; ".cls" marks a CL file.
        progress: callable of (stage, done, total), or tqdm.
        **more: set, block_delete, tool_table, ini, sub_dir, passive, tool as in `trunnion post`.

    Raises:
        InputError: the file cannot be read; `messages` has every fault with line and column.

    Warns:
        TrunnionWarning: something in the file was left out, or may mean something else; `warnings` has it as well.

    Example:
        >>> import trunnion
        >>> trunnion.read(b"G21 G90\\nG0 X0 Y0 Z5\\nG1 Z0 F600\\nG1 X20\\nM2\\n").line.tolist()
        [2, 3, 4]
    """
    program = quietly(
        path, machine, dialect, origin, rotation, tool_length, reversed_rotaries, deg, suffix, progress, **more
    )
    warn(program.warnings)
    return program


@_options.pythonic
def quietly(
    path: Any,
    machine: Any = None,
    dialect: str | None = None,
    origin: "ArrayLike | None" = None,
    rotation: "ArrayLike | None" = None,
    tool_length: Any = None,
    reversed_rotaries: bool = False,
    deg: bool = False,
    suffix: str | None = None,
    progress: Progress = None,
    **more: Any,
) -> Program:
    """Reads as `read` does; its remarks are left to `warnings` of the result."""
    from . import _trunnion

    deg = _options.truth("deg", deg)
    with _options.Scratch() as folder:
        file = _options.as_file("path", path, ".nc" if suffix is None else suffix, folder)
        name = "program" if folder.holds(file) else file
        needs = _options.machine_file(machine, folder) if machine is not None else _UPRIGHT
        words = [file, "--machine", needs, "--output", "unused"]
        if isinstance(machine, _trunnion.Machine):
            own, turned, length = machine._setup()
            origin = own if origin is None else origin
            if rotation is None:
                rotation, deg = turned, False
            tool_length = length or None if tool_length is None else tool_length
        if dialect is not None:
            words.append("--from=" + _options.word("dialect", dialect))
        if origin is not None:
            words.append("--origin=" + _options.numbers("origin", origin, 3))
        if rotation is not None:
            words.append("--rotation=" + _options.angles("rotation", rotation, 3, deg))
        if tool_length is not None:
            words += _options.per_tool("tool_length", tool_length, _options.number)
        if _options.truth("reversed_rotaries", reversed_rotaries):
            words.append("--from-reversed-rotaries")
        words += _options.others("read", _KNOWN, more, read)
        try:
            found = _trunnion.moves(words, adapted(progress))
        except InputError as error:
            raise type(error)(*(_worded(one.replace(file, name)) for one in error.messages)) from None
    program = Program(name, file, found)
    # The file of a machine is needed as soon as a rotary moves: tips depend on its pivots.
    if machine is None and (program.axis[:, :2] != 0.0).any() and not _is_cl(found):
        raise InputError(
            f"{name}: the program moves rotary axes, and positions of the tool depend on the machine"
            "\n  help: name it: machine=\"bc-trunnion\", or a machine file"
        )
    return program


def _worded(message: str) -> str:
    """Words a message of `trunnion post` about its input: that is what is read here, and no program is written."""
    return _options.worded(message.replace("--from-", "--").removesuffix(": the template has its own"))


def _is_cl(found: Mapping[str, Any]) -> bool:
    import numpy as np

    return bool(np.isnan(found["q"]).all())
