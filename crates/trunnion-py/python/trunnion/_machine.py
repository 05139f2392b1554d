"""Machines from controls, and calibrations."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Mapping

from . import _options, _picture
from ._errors import ArgumentError, InputError
from ._result import Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ._trunnion import Machine


class ImportedMachine:
    """Machine that a control or another program describes.

    Attributes:
        machine: the Machine.
        text: its machine file; comments say where each value comes from.
        format: name of the format that was read.
        values: what became what: dicts of `line`, `key`, `value`, `became`.
        open: statements that the description or its manual leaves open, mostly signs to compare with the machine.
        summary: everything as `trunnion machine import --json` prints it.
    """

    def __init__(self, found: Mapping[str, Any], machine: "Machine") -> None:
        self.summary: dict[str, Any] = found["summary"]
        self.machine = machine
        self.text: str = found["text"]
        self._table: str = found["table"]

    @property
    def format(self) -> str:
        """Name of the format that was read."""
        return str(self.summary["format"])

    @property
    def values(self) -> list[dict[str, Any]]:
        """What became what."""
        return list(self.summary["values"])

    @property
    def open(self) -> list[str]:
        """Statements that are left open, in words."""
        return list(self.summary["open"])

    def save(self, path: Any) -> None:
        """Writes the machine file."""
        _write(path, self.text)

    def to_dict(self) -> dict[str, Any]:
        """Returns the summary."""
        return dict(self.summary)

    def to_pandas(self) -> Any:
        """Returns what became what as a DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.values)

    def __str__(self) -> str:
        return self._table

    def __repr__(self) -> str:
        return f"ImportedMachine({self.machine.name!r}, {self.format}, {len(self.values)} values, {len(self.open)} open)"

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [("name", self.machine.name), ("format", self.format)]
        rows += [("open", one) for one in self.open]
        return _picture.table(rows) + self.machine.picture()


class Calibration(Table):
    """Errors of a real machine, found from measured spheres.

    Attributes:
        machine: the calibrated Machine, with the setup of the one that was calibrated.
        text: its machine file.
        complete: True if the readings determine every deviation, and none contradicts the others.
        name, unit, meaning: of each deviation, lists.
        value, uncertainty: deviations and their uncertainties for 95 %, NaN where one is not found by itself, (n,) [mm, degrees].
        confounded: changes that no reading notices, lists of dicts of `name`, `unit`, `change`.
        further: readings that would separate them: dicts of `words`, `fixes`, `positions`.
        contradicting: readings that are off what the others say: dicts of `file`, `line`, `residual`.
        rms_before, rms: root mean square of the residuals of a number, before and after [mm].
        summary: everything as `trunnion machine calibrate --json` prints it.
    """

    _columns = ("name", "value", "uncertainty", "unit", "meaning")

    def __init__(self, found: Mapping[str, Any], machine: "Machine") -> None:
        self.summary: dict[str, Any] = found["summary"]
        self.machine = machine
        self.text: str = found["text"]
        self.complete: bool = found["complete"]
        self._table: str = found["table"]

    def _each(self, key: str) -> list[Any]:
        return [one[key] for one in self.summary["errors"]]

    @property
    def name(self) -> list[str]:
        """Names of the deviations."""
        return self._each("name")

    @property
    def unit(self) -> list[str]:
        """Their units: mm or deg."""
        return self._each("unit")

    @property
    def meaning(self) -> list[str]:
        """Their meanings, in words."""
        return self._each("meaning")

    @property
    def value(self) -> "NDArray[np.float64]":
        """Deviations, (n,) [mm, degrees]."""
        import numpy as np

        return np.array(self._each("value"), dtype=float)

    @property
    def uncertainty(self) -> "NDArray[np.float64]":
        """Uncertainties for 95 %, (n,) [mm, degrees]; NaN: not found by itself."""
        import numpy as np

        return np.array(self._each("uncertainty"), dtype=float)

    def __getattr__(self, name: str) -> Any:
        if name in ("confounded", "further", "contradicting", "rms_before", "rms", "noise", "spheres"):
            return self.summary[name]
        raise AttributeError(f"a calibration has no {name}")

    def save(self, path: Any) -> None:
        """Writes the calibrated machine file."""
        _write(path, self.text)

    def __str__(self) -> str:
        return self._table

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        return f"Calibration({state}, off by {self.rms_before:.4f} mm before, {self.rms:.4f} mm after)"

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [
            ("off the readings", f"{self.rms_before:.4f} mm before, {self.rms:.4f} mm after"),
        ]
        for name, value, by, unit, meaning in zip(self.name, self.value, self.uncertainty, self.unit, self.meaning):
            shown = "open" if by != by else f"{value:+.5f} +- {by:.5f} {unit}"
            rows.append((name, f"{shown}, {meaning}"))
        rows += [("would help", one["words"]) for one in self.further]
        return _picture.table(rows)


def _write(path: Any, text: str) -> None:
    _options.write(_options.path("path", path), text)


@_options.pythonic
def import_machine(source: Any, format: str | None = None, given: Mapping[str, Any] | None = None) -> ImportedMachine:
    """Turns the parameters of a control, or a machine of FreeCAD, into a machine.

    Args:
        source: file of the description, beside which files that it names are read; or its content as bytes.
        format: "linuxcnc", "siemens", "heidenhain", "fanuc", "haas" or "freecad"; else by its text.
        given: values that the description does not state, by key: `{"axis.C.limits": "endless", "linear.jerk": 50000}`; mm,
            degrees, s. They win over the description.

    Raises:
        InputError: the description cannot be read, or values are missing; `messages` has all of them with line and key.

    Example:
        >>> import trunnion
        >>> trunnion.import_machine(b"[KINS]", "linuxcnc")  # doctest: +IGNORE_EXCEPTION_DETAIL
        Traceback (most recent call last):
        trunnion.InputError: ...
    """
    from . import _trunnion

    if given is not None and not isinstance(given, Mapping):
        kind = type(given).__name__
        raise ArgumentError(f"given = {kind} is no dict of values by key", "given", None, kind)
    with _options.Scratch() as folder:
        file = _options.as_file("source", source, ".txt", folder)
        words = [file]
        if format is not None:
            words.append("--from=" + _options.word("format", format))
        words += [f"--set={_options.stated('given', key)}={_value(value)}" for key, value in (given or {}).items()]
        inside = folder.holds(file)
        shown = "description" if inside else file
        try:
            found = _trunnion.import_machine(words)
        except InputError as error:
            raise type(error)(*[one.replace(file, shown) for one in error.messages]) from None
    for key in ("text", "table"):
        found[key] = found[key].replace(file, shown)
    found["summary"]["file"] = shown
    return ImportedMachine(found, _trunnion.Machine.from_toml(found["text"], shown))


def _value(value: Any) -> str:
    """Returns a value of a machine as the command line has it: numbers, or several of them."""
    several = isinstance(value, (list, tuple)) or getattr(value, "ndim", 0) == 1
    return ",".join(_options.stated("given", one) for one in (value if several else [value]))


@_options.pythonic
def calibrate(machine: "Machine", measurements: Any, tool_length: Any = None, noise: Any = None) -> Calibration:
    """Finds the errors of a machine; see `Machine.calibrate`."""
    from . import _trunnion

    tables = list(measurements) if isinstance(measurements, (list, tuple)) else [measurements]
    with _options.Scratch() as folder:
        names = [_readings(table, index, folder) for index, table in enumerate(tables, 1)]
        words = [*names, "--machine", _options.machine_file(machine, folder)]
        if tool_length is not None:
            words.append("--tool-length=" + _options.number("tool_length", tool_length))
        elif machine.tool_length:
            words.append("--tool-length=" + _options.number("tool_length", machine.tool_length))
        if noise is not None:
            words.append("--noise=" + _options.number("noise", noise))

        def shown(text: str) -> str:
            return text.replace(os.path.join(folder, ""), "")

        try:
            found = _trunnion.calibrate_machine(words)
        except InputError as error:
            raise type(error)(*map(shown, error.messages)) from None
    for key in ("text", "table"):
        found[key] = shown(found[key])
    summary = found["summary"]
    summary["machine"] = shown(summary["machine"])
    summary["measurements"] = [shown(one) for one in summary["measurements"]]
    for one in summary["contradicting"]:
        one["file"] = shown(one["file"])
    # Solids of its bodies count from the folder of the machine that was calibrated.
    calibrated = _trunnion.Machine.from_toml(found["text"], machine.source).with_setup(
        origin=machine.origin, rotation=machine.rotation(), tool_length=machine.tool_length
    )
    return Calibration(found, calibrated)


def _readings(table: Any, index: int, folder: _options.Scratch) -> str:
    """Returns the file of a table of readings; columns in memory are written into the folder."""
    import numpy as np

    if not isinstance(table, (bytes, bytearray, memoryview, Mapping)) and not hasattr(table, "columns"):
        return _options.path("measurements", table)
    file = os.path.join(folder, f"measurements{index}.csv")
    if isinstance(table, (bytes, bytearray, memoryview)):
        with open(file, "wb") as raw:
            raw.write(table)
        return file
    given = list(table.columns if hasattr(table, "columns") else table)
    names = [_options.stated("measurements", name) for name in given]
    columns = [np.asarray(table[name]) for name in given]
    for name, column in zip(names, columns):
        if column.dtype.kind not in "fiu" or column.ndim != 1 or len(column) != len(columns[0]):
            value = f"dtype {column.dtype}, shape {column.shape}"
            message = f"measurements[{name!r}] = {value} is not a column of numbers like the first"
            raise ArgumentError(message, "measurements", None, value)
    with open(file, "w", encoding="utf-8") as out:
        out.write(",".join(names) + "\n")
        for row in zip(*(column.tolist() for column in columns)):
            out.write(",".join(map(repr, row)) + "\n")
    return file
