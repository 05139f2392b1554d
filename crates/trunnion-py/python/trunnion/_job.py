"""Jobs: from surface to checked programs."""

from __future__ import annotations

import copy
import os
from typing import TYPE_CHECKING, Any, Mapping, Sequence

from . import _options, _picture
from ._errors import ArgumentError, InputError, TrunnionError, warn
from ._plan import Motion
from ._progress import OnPasses, Progress, adapted, receiver

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray


class Job:
    """A job: part, setup, tool, tolerance, strategy, machine, as a job file has them.

    Args:
        data: content of the job, nested dicts with the keys of job.toml (see `trunnion schema job`); a Cutter may stand for
            the table `tool`.
        folder: folder from which the files in it count.

    Example:
        >>> import trunnion
        >>> job = trunnion.Job({"schema": "trunnion-job/1", "name": "patch"})
        >>> job.replace({"tool.minor_radius": 4.0}).data["tool"]
        {'minor_radius': 4.0}
    """

    def __init__(self, data: Mapping[str, Any], folder: Any = ".") -> None:
        given = _options.mapping("data", data, "what a job file has")
        try:
            self.data: dict[str, Any] = copy.deepcopy(dict(given))
        except RecursionError:
            raise ArgumentError("data = dict is nested too deep for a file", "data", None, "dict") from None
        self.data.setdefault("schema", "trunnion-job/1")
        if "tool" in self.data:
            self.data["tool"] = _tool({}, self.data["tool"])
        self.folder = _options.path("folder", folder)
        self._file: str | None = None
        self._text: str | None = None

    @classmethod
    def read(cls, path: Any) -> "Job":
        """Reads a job file.

        Raises:
            InputError: the file cannot be read as TOML. Its content is checked by `check` and `run`.

        Example:
            >>> import os, tempfile, trunnion
            >>> file = os.path.join(tempfile.mkdtemp(), "job.toml")
            >>> trunnion.Job({"name": "patch"}).save(file)
            >>> trunnion.Job.read(file).data["name"]
            'patch'
        """
        from . import _trunnion

        name = _options.path("path", path)
        try:
            with open(name, encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{name}: {error}") from None
        try:
            data = _trunnion.toml_data(text)
        except InputError as error:
            raise InputError(*(f"{name}:{one}" for one in error.messages)) from None
        job = cls(data, os.path.dirname(name) or ".")
        job._file, job._text = name, text
        return job

    @classmethod
    def propose(
        cls,
        part: Any,
        machine: Any = "bc-trunnion",
        faces: Sequence[int] = (),
        *,
        rotation: "ArrayLike | None" = None,
        deg: bool = False,
        progress: Progress = None,
    ) -> "Job":
        """Returns a job that runs as it is: faces that can be reached, cutters by the concave radius, an origin that fits.

        Args:
            part: STEP or surface JSON file.
            machine: name of a built-in machine, or a machine file.
            faces: numbers of the faces to choose from; all if empty.
            rotation: rotation of the part about its x, then y, then z, (3,) [rad, or degrees with deg]; None: as drawn, or
                by a quarter or half turn where a tool then reaches much more from above.
            deg: the rotation is in degrees.
            progress: callable of (stage, done, total), or tqdm.

        Returns:
            the job as `trunnion init` writes it; `to_toml()` has comments that say what to check.

        Raises:
            InputError: the part or the machine cannot be read, or no cutter of the library finishes a face.

        Example:
            >>> import trunnion
            >>> trunnion.Job.propose("missing.step")  # doctest: +IGNORE_EXCEPTION_DETAIL
            Traceback (most recent call last):
            trunnion.InputError: ...
        """
        from . import _trunnion

        words = [_options.path("part", part), "--machine", _options.path("machine", machine)]
        words += _options.faces_option(faces)
        if rotation is not None:
            words.append("--rotation=" + _options.angles("rotation", rotation, 3, deg))
        text, remarks = _trunnion.propose(words, adapted(progress))
        warn(map(_options.worded, remarks))
        job = cls(_trunnion.toml_data(text), os.path.dirname(words[0]) or ".")
        # The part is named from where the caller stands.
        job.data["part"]["file"] = os.path.abspath(words[0])
        return job

    def setups(self, *, tilt: Any = None, towards: Any = None, turn: Any = None, progress: Progress = None) -> dict[str, Any]:
        """Searches the rotation of the workpiece that keeps the tool farthest from the singular direction.

        Args:
            tilt, towards, turn: bounds of the search, pairs of degrees, as in `trunnion setup`.
            progress: callable of (stage, done, total), or tqdm.

        Returns:
            everything as `trunnion setup --json` prints it, in mm and degrees: `before`, `after` (None if nothing fits), `others`.

        Raises:
            InputError: faults of the job, or bounds that are none.

        Example:
            >>> import trunnion
            >>> job = trunnion.Job({"name": "patch", "tool": trunnion.Cutter.ball(10)})
            >>> job.setups(tilt=(0, 20))  # doctest: +IGNORE_EXCEPTION_DETAIL
            Traceback (most recent call last):
            trunnion.InputError: ...
        """
        import tempfile

        from . import _trunnion

        with tempfile.TemporaryDirectory() as folder:
            file = self.path
            if self._file is None or self._text != self.to_toml():
                file = os.path.join(folder, "job.toml")
                self.moved(folder).save(file)
            words = [file]
            for name, bounds in (("tilt", tilt), ("towards", towards), ("turn", turn)):
                if bounds is not None:
                    low, high = _options.numbers(name, bounds, 2).split(",")
                    words.append(f"--{name}={low}..{high}")
            summary, _ = _trunnion.setup(words, adapted(progress))
        return dict(summary)

    def moved(self, folder: Any) -> "Job":
        """Returns the job for another folder: files that it names from its own folder are named by their whole path.

        Example:
            >>> import trunnion
            >>> job = trunnion.Job({"name": "patch", "tool": trunnion.Cutter.ball(10)})
            >>> job.moved("elsewhere").folder
            'elsewhere'
        """
        job = Job(self.data, folder)
        tables = [job.data.get(name) for name in ("part", "machine", "stock")] + list(job.data.get("fixture", []))
        for table in tables:
            name = table.get("file") if isinstance(table, dict) else None
            here = os.path.join(self.folder, name) if isinstance(name, str) else ""
            # Names of built-in machines are no files.
            if here and os.path.exists(here):
                table["file"] = os.path.abspath(here)
        return job

    @property
    def path(self) -> str:
        """File of the job, or the one that it would be."""
        return self._file or os.path.join(self.folder, "job.toml")

    def replace(self, changes: Mapping[str, Any]) -> "Job":
        """Returns the job with other values, named as in the file: `{"tool.minor_radius": 4.0}`.

        A Cutter takes the place of the whole `tool`, whose number and holder stay: `{"tool": Cutter.barrel(2, 85, 12)}`.

        Example:
            >>> import trunnion
            >>> job = trunnion.Job({"name": "patch", "tool": trunnion.Cutter.ball(10)})
            >>> job.replace({"tolerance.total": 0.02}).data["tolerance"]
            {'total': 0.02}
        """
        job = Job(self.data, self.folder)
        for name, value in _options.mapping("changes", changes, "values by key").items():
            *sections, key = str(name).split(".")
            table = job.data
            for section in sections:
                table = table.setdefault(section, {})
                if not isinstance(table, dict):
                    message = f"changes[{name!r}]: {section} is no table of the job, but {table!r}"
                    raise ArgumentError(message, "changes", None, name)
            table[key] = _tool(table.get(key, {}), value)
        return job

    def to_toml(self) -> str:
        """Returns the text of the job file.

        Example:
            >>> import trunnion
            >>> job = trunnion.Job({"name": "patch", "tool": trunnion.Cutter.ball(10)})
            >>> "[tool]" in job.to_toml()
            True
        """
        from . import _trunnion

        if self._text is not None and _trunnion.toml_data(self._text) == self.data:
            return self._text
        return str(_trunnion.toml_text(self.data))

    def save(self, path: Any) -> None:
        """Writes the job file; files in it count from the folder of that file."""
        _options.write(_options.path("path", path), self.to_toml())

    def _native(self) -> Any:
        from . import _trunnion

        return _trunnion.NativeJob(self.path, self.to_toml())

    def check(self) -> list[str]:
        """Checks the job and its files without running it, and returns warnings about the part.

        Raises:
            InputError: every fault of the job, with line and column.

        Example:
            >>> import trunnion
            >>> job = trunnion.Job({"name": "patch", "tool": trunnion.Cutter.ball(10)})
            >>> job.check()  # doctest: +IGNORE_EXCEPTION_DETAIL
            Traceback (most recent call last):
            trunnion.InputError: ...
        """
        warnings: list[str] = self._native().warnings
        return warnings

    def run(self, *, output: Any = None, progress: Progress = None, on_passes: OnPasses = None) -> "RunResult":
        """Runs the job; see `trunnion.run`.

        Example:
            >>> import trunnion
            >>> trunnion.Job({"name": "patch"}).run()  # doctest: +IGNORE_EXCEPTION_DETAIL
            Traceback (most recent call last):
            trunnion.InputError: ...
        """
        return run(self, output=output, progress=progress, on_passes=on_passes)

    def __repr__(self) -> str:
        return f"Job({self.data.get('name', '')!r}, {self.path!r})"

    def _repr_html_(self) -> str:
        from ._trunnion import Part

        def words(name: str) -> str:
            table = self.data.get(name)
            stated = table.items() if isinstance(table, Mapping) else []
            return ", ".join(f"{key} {value}" for key, value in stated)

        names = ("part", "setup", "tool", "tolerance", "strategy", "cutting", "machine")
        shown = _picture.table([("job", self.data.get("name", "")), *((name, words(name)) for name in names)])
        part = self.data.get("part")
        file = part.get("file") if isinstance(part, Mapping) else None
        try:
            return shown + Part.read(os.path.join(self.folder, str(file))).picture()
        except TrunnionError:
            # The check of the job says what is wrong with its part.
            return shown


def _tool(before: Any, value: Any) -> Any:
    """Returns a Cutter as the table of a tool, with number and holder of the one before; other values as they are."""
    from ._trunnion import Cutter

    if not isinstance(value, Cutter):
        return value
    before = before if isinstance(before, Mapping) else {}
    stays = {name: before[name] for name in ("number", "holder") if name in before}
    return {"number": 1, **stays, **value.to_dict()}


class RunResult:
    """Result of a run.

    Attributes:
        passed: True if every tolerance and limit is kept.
        summary: everything as `summary.json` has it; mm, degrees, s.
        programs: text of each program by file name.
        passes: dicts of `tip`, `axis`, `contact` (n, 3), `width` (n,), `track` (n, 2), `face` for each pass.
        tip, axis: all cutter locations with leads and links, (n, 3) [mm, unit vectors].
        cutting: True for cutter locations of cuts, (n,).
        cl, setup: cutter locations as APT/CL text, and the setup sheet.
        files: files that were written.
    """

    def __init__(self, native: Any) -> None:
        self._native = native
        self.passed: bool = native.passed
        self.summary: dict[str, Any] = native.summary()
        self.programs: dict[str, str] = native.programs
        self.files: list[Any] = native.files
        self.warnings: list[str] = [*self.summary["warnings"], *native.warnings]

    @property
    def failures(self) -> list[str]:
        """Broken tolerances and limits, in words."""
        return list(self.summary["failures"])

    @property
    def passes(self) -> list[dict[str, Any]]:
        """The passes as arrays."""
        found: list[dict[str, Any]] = self._native.passes
        return found

    @property
    def tip(self) -> "NDArray[np.float64]":
        """Tips of all cutter locations, (n, 3) [mm]."""
        return self._native.locations["tip"]

    @property
    def axis(self) -> "NDArray[np.float64]":
        """Tool axes of all cutter locations, (n, 3)."""
        return self._native.locations["axis"]

    @property
    def cutting(self) -> "NDArray[np.bool_]":
        """True for cutter locations of cuts, (n,)."""
        return self._native.locations["cutting"].astype(bool)

    @property
    def cl(self) -> str:
        """Cutter locations as APT/CL text."""
        return str(self._native.cl)

    @property
    def setup(self) -> str:
        """The setup sheet."""
        return str(self._native.setup)

    @property
    def maps(self) -> list[dict[str, Any]]:
        """Measured points of the first program: `face`, `point` (n, 3), `height` (n,), `line` (n,) for each face."""
        found: list[dict[str, Any]] = self._native.maps
        return found

    @property
    def duration(self) -> float:
        """Planned time [s]."""
        return float(self.summary["motion"]["duration"])

    def sample(self, period: float, *, deg: bool = False) -> Motion:
        """Returns the machine axes at every servo period [mm, rad or degrees, s]."""
        found = self._native.sample(float(_options.number("period", period)), deg)
        return Motion(*(found[name] for name in Motion._fields))

    def limits(self, *, deg: bool = False) -> dict[str, Any]:
        """Returns `axes`, and `velocity`, `acceleration`, `jerk` of each."""
        found: dict[str, Any] = self._native.limits(deg)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Returns the summary."""
        return dict(self.summary)

    def to_pandas(self) -> Any:
        """Returns the cutter locations as a DataFrame."""
        import pandas as pd

        (x, y, z), (i, j, k) = self.tip.T, self.axis.T
        return pd.DataFrame({"x": x, "y": y, "z": z, "i": i, "j": j, "k": k, "cutting": self.cutting})

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Hands the cutter locations to Arrow; needs pandas with pyarrow."""
        return self.to_pandas().__arrow_c_stream__(requested_schema)

    def __str__(self) -> str:
        return str(self._native.table)

    def __repr__(self) -> str:
        return f"RunResult(passed={self.passed}, {len(self.programs)} programs, {self.duration:.1f} s)"

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [
            ("verdict", "kept" if self.passed else "NOT KEPT"),
            ("time", f"{self.duration:.1f} s"),
            ("programs", ", ".join(self.programs)),
        ]
        rows += [("broken", failure) for failure in self.failures]
        return _picture.table(rows) + _picture.path("cutter locations", self.tip, self.axis)


@_options.pythonic
def run(job: Any, *, output: Any = None, progress: Progress = None, on_passes: OnPasses = None) -> RunResult:
    """Runs a job: passes, axis motion, speeds, programs and their check, as `trunnion run` does.

    Args:
        job: a Job, a job file, or a dict with its content.
        output: folder for the files of the run; without one nothing is written.
        progress: callable of (stage, done, total), or tqdm.
        on_passes: callable of (face, passes), called while passes are placed: the number of a face, and its passes so far
            as in `RunResult.passes`. They may still give way to better ones: each call replaces what those before have
            said about the face.

    Raises:
        InputError: faults of the job or its files; or no pass is possible.
        UnfinishedError: the passes could not become a program; they are kept in `output`.

    Example:
        >>> import trunnion
        >>> trunnion.run({"schema": "trunnion-job/1"})  # doctest: +IGNORE_EXCEPTION_DETAIL
        Traceback (most recent call last):
        trunnion.InputError: ...
    """
    if isinstance(job, Mapping):
        job = Job(job)
    elif not isinstance(job, Job):
        job = Job.read(job)
    folder = _options.path("output", output) if output is not None else None
    return RunResult(job._native().run(folder, adapted(progress), receiver(on_passes)))
