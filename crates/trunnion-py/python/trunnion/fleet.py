"""Many programs, jobs and machines at once: tables of results that can be resumed.

Every item has a key, the hash of everything that its result depends on, the build of trunnion included. With
`results=` a finished item is kept as `KEY.json` in a folder (or any fsspec URL), and is not run again. An item that is
refused is finished too: its message stands beside the results. One that took its worker with it has a message as well,
and is tried again the next time.

Work runs in processes of this machine, or on a Dask cluster when a client is given. Ctrl-C, or leaving the loop over the
rows, ends it: what has finished is kept.
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Mapping

from . import _options
from ._errors import ArgumentError, InputError, TrunnionError
from ._progress import Progress, adapted
from ._verbs import check

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Generator, Iterable, Iterator, Sequence

    import pandas as pd

__all__ = ["Fleet", "audit", "compare", "which_machine"]

#: Workers that may end in the middle of an item before it counts as failed, and times that Dask runs an item again.
_DEATHS = 3

#: Programs that a thread reads at once.
_AT_ONCE = 8

#: Figures of a run that stand in the table; the whole summary is in the result.
_RUN = {
    "duration": ("motion", "duration"),
    "cutting": ("motion", "cutting"),
    "lower_bound": ("motion", "lower_bound"),
    "passes": ("cover", "passes"),
    "cutting_length": ("cover", "cutting_length"),
}


class Fleet:
    """Items of work with their results. Lazy: nothing runs before the results are asked for.

    Iterating yields rows as they finish; `rows` runs everything and returns them in order. A row is a dict with the
    columns of the item (`program`, `machine`, ..), `status` ("done" or "failed"), `passed`, figures, and `message`.

    Example:
        >>> import trunnion
        >>> fleet = trunnion.fleet.compare({"name": "a"}, {"tolerance": [0.01]}, workers=0)
        >>> len(fleet), fleet.failed[0]["status"]
        (1, 'failed')
    """

    def __init__(self, items: Sequence[dict[str, Any]], plan: "_Plan") -> None:
        self._items = items
        self._plan = plan
        self._found: dict[str, dict[str, Any]] = {}

    def __len__(self) -> int:
        return len(self._items)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        import contextlib

        waiting = {item["key"]: item for item in self._items if item["key"] not in self._found}
        yield from (self._row(item) for item in self._items if item["key"] in self._found)
        store = self._plan.store
        for key in [key for key in waiting if store is not None]:
            kept = store.read(key)  # type: ignore[union-attr]
            if kept is not None:
                self._found[key] = kept
                yield self._row(waiting.pop(key))
        done = len(self._items) - len(waiting)
        self._plan.report(done, len(self._items))
        work = self._plan.run(list(waiting.values()))
        # Closed at once when the loop is left: workers do not go on until the garbage is collected.
        with contextlib.closing(work):
            for key, result in work:
                if store is not None and not result.get("lost"):
                    store.write(key, result)
                self._found[key] = result
                done += 1
                self._plan.report(done, len(self._items))
                yield self._row(waiting[key])

    def _row(self, item: dict[str, Any]) -> dict[str, Any]:
        return {**item["columns"], **self._found[item["key"]]["row"]}

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Rows of all items in order; what has not run yet is run."""
        for _ in self:
            pass
        return [self._row(item) for item in self._items]

    @property
    def summaries(self) -> list[dict[str, Any] | None]:
        """Whole summaries of all items in order, None for failed ones."""
        _ = self.rows
        return [self._found[item["key"]]["summary"] for item in self._items]

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Rows of items that could not be run, with their message."""
        return [row for row in self.rows if row["status"] == "failed"]

    def to_dict(self) -> dict[str, list[Any]]:
        """Returns the columns."""
        rows = self.rows
        names = list(dict.fromkeys(name for row in rows for name in row))
        return {name: [row.get(name) for row in rows] for name in names}

    def to_pandas(self) -> "pd.DataFrame":
        """Returns the rows as a DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.rows)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Hands the rows to Arrow; needs pandas with pyarrow."""
        return self.to_pandas().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"Fleet({len(self._items)} items, {len(self._found)} finished)"

    def _repr_html_(self) -> str:
        import html

        rows = [self._row(item) for item in self._items if item["key"] in self._found]
        names = list(dict.fromkeys(name for row in rows for name in row))
        head = "".join(f"<th>{html.escape(name)}</th>" for name in names)

        def cell(value: Any) -> str:
            # A table is for the eye: `rows` have every digit.
            shown = f"{value:.5g}" if isinstance(value, float) else str(value)
            return f"<td>{html.escape(shown)}</td>"

        body = "".join("<tr>" + "".join(cell(row.get(name, "")) for name in names) + "</tr>" for row in rows)
        return f"<p>{html.escape(repr(self))}</p><table><tr>{head}</tr>{body}</table>"


class _Store:
    """Results by key in a folder, or under an fsspec URL."""

    def __init__(self, place: Any) -> None:
        self._folder = _options.path("results", place)
        self._url = self._folder if "://" in self._folder else ""
        if self._url:
            try:
                import fsspec

                self._system, self._root = fsspec.core.url_to_fs(self._url)
            except (ImportError, ValueError) as error:
                # A protocol of its own may need a library of its own.
                remedy = "pip install 'trunnion[fsspec]', and the library of the protocol"
                message = f"results = {self._url!r} cannot be opened: {error}\n  help: {remedy}"
                raise ArgumentError(message, "results", None, self._url) from error
            self._system.makedirs(self._root, exist_ok=True)
        else:
            try:
                os.makedirs(self._folder, exist_ok=True)
            except OSError as error:
                message = f"results = {self._folder!r} is no folder, and none can be made: {error.strerror}"
                raise ArgumentError(message, "results", None, self._folder) from None

    def read(self, key: str) -> dict[str, Any] | None:
        try:
            if self._url:
                text = self._system.cat_file(f"{self._root}/{key}.json").decode()
            else:
                with open(os.path.join(self._folder, key + ".json"), encoding="utf-8") as file:
                    text = file.read()
            found: dict[str, Any] = json.loads(text)
        except (FileNotFoundError, ValueError):
            # A file that was cut off counts as absent: the item is run again.
            return None
        return found

    def write(self, key: str, result: Mapping[str, Any]) -> None:
        text = json.dumps(result)
        if self._url:
            self._system.pipe_file(f"{self._root}/{key}.json", text.encode())
            return
        whole = os.path.join(self._folder, key + ".json")
        part = f"{whole}.{os.getpid()}"
        with open(part, "w", encoding="utf-8") as out:
            out.write(text)
        # A result is there as a whole or not at all.
        os.replace(part, whole)


class _Plan:
    """Where items are worked on, and where results are kept."""

    def __init__(self, results: Any, client: Any, workers: int | None, progress: Progress) -> None:
        self.store = None if results is None else _Store(results)
        if client is not None and not hasattr(client, "submit"):
            kind, remedy = type(client).__name__, "give a distributed.Client, or leave it out for processes of this machine"
            raise ArgumentError(f"client = {kind} is no Dask client\n  help: {remedy}", "client", None, kind)
        self._client = client
        self._workers = None if workers is None else _options.whole("workers", workers)
        self._progress = adapted(progress)

    def report(self, done: int, total: int) -> None:
        if self._progress is not None:
            self._progress("running items", done, total)

    def run(self, items: list[dict[str, Any]]) -> Generator[tuple[str, dict[str, Any]], None, None]:
        if not items:
            return
        if self._client is not None:
            yield from self._on_dask(items)
        elif self._workers == 0:
            # Beside the items, the stages of each are reported: whoever watches this process can stop it between them.
            yield from ((item["key"], _worked(item, self._progress)) for item in items)
        else:
            yield from self._in_processes(items)

    def _on_dask(self, items: list[dict[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
        from distributed import as_completed

        # The key of the task is that of the item: a scheduler never holds the same work twice.
        tasks = [
            self._client.submit(
                _worked_by, _build(), _worked, item, key=f"trunnion-{item['key']}", retries=_DEATHS, pure=True
            )
            for item in items
        ]
        keys = {task.key: item["key"] for task, item in zip(tasks, items)}
        try:
            for task in as_completed(tasks):
                error = task.exception() if task.status == "error" else None
                yield keys[task.key], _lost(error) if error is not None else task.result()
        finally:
            # The scheduler forgets what nobody waits for.
            for task in tasks:
                task.release()

    def _in_processes(self, items: list[dict[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
        import contextlib

        from . import _workers

        with contextlib.closing(_workers.each(_worked, items, self._workers, _DEATHS)) as found:
            for item, result, error in found:
                yield item["key"], result if error is None else _lost(error)


def _lost(error: BaseException) -> dict[str, Any]:
    """Returns the result of an item that ended with its worker: not kept, for it says nothing of the item."""
    return {**_failed(error), "lost": True}


def _failed(error: BaseException) -> dict[str, Any]:
    messages = error.messages if isinstance(error, TrunnionError) else (f"{type(error).__name__}: {error}",)
    row = {"status": "failed", "passed": None, "message": "\n".join(messages)}
    return {"row": row, "summary": None, "messages": list(messages)}


def _worked(item: dict[str, Any], progress: Progress = None) -> dict[str, Any]:
    """Runs an item; runs in a worker."""
    try:
        return _WORK[item["kind"]](item["work"], progress)
    except TrunnionError as error:
        return _failed(error)


def _worked_by(build: str, work: Callable[[dict[str, Any]], dict[str, Any]], item: dict[str, Any]) -> dict[str, Any]:
    """Runs an item on another machine, if that has the same build: the key of the result depends on it."""
    if build == _build():
        return work(item)
    from . import __version__

    message = f"this worker has another build of trunnion ({__version__})\n  help: install the same wheel on all workers"
    return _lost(TrunnionError(message))


def _audited(work: dict[str, Any], progress: Progress = None) -> dict[str, Any]:
    found = check(work["program"], machine=work["machine"], progress=progress, **work["options"])
    summary = found.summary
    axes = summary.get("axes") or []
    row = {
        "status": "done",
        "passed": found.passed,
        "duration": summary.get("duration"),
        "velocity": max((_ratio(axis.get("velocity")) for axis in axes), default=None),
        "acceleration": max((_ratio(axis.get("acceleration")) for axis in axes), default=None),
        "message": "\n".join(found.failures),
    }
    return {"row": row, "summary": summary, "messages": found.failures}


def _ratio(value: Any) -> float:
    if isinstance(value, Mapping):
        value = value.get("ratio")
    return float(value) if isinstance(value, (int, float)) else 0.0


def _ran(work: dict[str, Any], progress: Progress = None) -> dict[str, Any]:
    import tempfile

    from ._job import Job, run

    job = Job(work["data"], work["folder"])
    with tempfile.TemporaryDirectory() as folder:
        if work["machine"] is not None:
            job = job.replace({"machine.file": _options.machine_file(work["machine"], folder)})
        found = run(job, progress=progress)
    row: dict[str, Any] = {"status": "done", "passed": found.passed}
    for name, (section, key) in _RUN.items():
        row[name] = found.summary[section].get(key)
    row["message"] = "\n".join(found.failures)
    return {"row": row, "summary": found.summary, "messages": found.failures}


_WORK: dict[str, Callable[[dict[str, Any], Progress], dict[str, Any]]] = {"audit": _audited, "run": _ran}


def _stated(value: Any) -> Any:
    """Returns all that a value states: short forms of cutters and arrays leave things out."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return value.to_dict() if hasattr(value, "to_dict") else repr(value)


@functools.cache
def _build() -> str:
    """Returns the hash of the engine and of the package around it: two builds of one version may differ."""
    import glob
    import hashlib

    from . import _trunnion

    package = os.path.dirname(os.path.abspath(__file__))
    found = hashlib.sha256()
    for name in [*sorted(glob.glob(os.path.join(glob.escape(package), "*.py"))), _trunnion.__file__]:
        with open(name, "rb") as file:
            found.update(hashlib.sha256(file.read()).digest())
    return found.hexdigest()


class _Hash:
    """Hash of everything that a result depends on."""

    def __init__(self, kind: str) -> None:
        import hashlib

        self._hash = hashlib.sha256(f"trunnion {_build()} {kind}".encode())

    def text(self, value: Any) -> "_Hash":
        try:
            part = json.dumps(value, sort_keys=True, default=_stated).encode()
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(f"a value cannot be written down, and so not be kept: {error}") from None
        self._hash.update(len(part).to_bytes(8, "little") + part)
        return self

    def file(self, name: str) -> "_Hash":
        """Adds the content of a file: a copy elsewhere is the same, an edited one is not."""
        import hashlib

        try:
            with open(name, "rb") as file:
                content = file.read()
        except OSError:
            # The item itself reports what is wrong with its file.
            return self.text(name)
        self._hash.update(hashlib.sha256(content).digest())
        return self

    def files_in(self, value: Any, folder: str) -> "_Hash":
        """Adds the content of all files that stand in nested values, of a machine file also the solids of its bodies."""
        if isinstance(value, Mapping):
            for key in sorted(value, key=str):
                self.files_in(value[key], folder)
        elif isinstance(value, (list, tuple)):
            for one in value:
                self.files_in(one, folder)
        elif isinstance(value, (str, os.PathLike)):
            # A solid may have a placement: vise.stl@10,0,0.
            name = os.path.join(folder, os.fsdecode(value).split("@")[0])
            if os.path.isfile(name):
                self.file(name)._bodies(name)
        return self

    def machine(self, machine: Any) -> "_Hash":
        """Adds a Machine with its setup, or the name or file of one."""
        from ._trunnion import Machine, toml_data

        if isinstance(machine, Machine):
            text = machine.to_toml()
            return self.text([text, machine._setup()]).files_in(toml_data(text).get("body"), os.path.dirname(machine.source))
        return self.files_in(machine, "") if os.path.isfile(machine) else self.text(machine)

    def subprograms(self, program: str, options: Mapping[str, Any]) -> "_Hash":
        """Adds the subprograms that a program runs."""
        from ._trunnion import subprograms

        folders = {name: options[name] for name in ("ini", "sub_dir") if name in options}
        try:
            return self.text(subprograms([program, *_options.others("check", folders, folders)]))
        except TrunnionError:
            # The item itself reports what is wrong with its files.
            return self

    def _bodies(self, file: str) -> "_Hash":
        from ._trunnion import toml_data

        if not file.lower().endswith(".toml"):
            return self
        try:
            with open(file, encoding="utf-8") as text:
                bodies = toml_data(text.read()).get("body")
        except (OSError, ValueError):
            return self
        return self.files_in(bodies, os.path.dirname(file))

    @property
    def key(self) -> str:
        return self._hash.hexdigest()[:40]


def _paths(name: str, value: Any) -> list[str]:
    if isinstance(value, (str, os.PathLike)):
        return [_options.path(name, value)]
    return [_options.path(name, one) for one in _options.sequence(name, value, "paths")]


def audit(
    programs: Any,
    machines: Any,
    *,
    results: Any = None,
    client: Any = None,
    workers: int | None = None,
    progress: Progress = None,
    **options: Any,
) -> Fleet:
    """Checks every program on every machine.

    Args:
        programs: paths of programs.
        machines: machines, one or several: a name, a file, a Machine with its setup, or a dict as a machine file has it.
            Those of the same name are numbered.
        results: folder or fsspec URL that keeps finished items; without one nothing is kept.
        client: dask.distributed.Client to work on; else processes of this machine.
        workers: number of processes [default: one for each core]; 0 works in this one.
        progress: callable of (stage, done, total), or tqdm.
        **options: keywords of `trunnion.check` for all items: tool_length, origin, part, cutter, ...

    Returns:
        A Fleet with the columns `program`, `machine`, `status`, `passed`, `duration` [s], `velocity` and
        `acceleration` (largest ratio to a limit), `message`.

    Example:
        >>> import os, tempfile, trunnion
        >>> folder = tempfile.mkdtemp()
        >>> program = os.path.join(folder, "a.ngc")
        >>> _ = open(program, "w").write("G21 G90 G94\\nT1 M6\\nM3 S1000\\nG43 H1\\nG0 X0 Y0 Z50 B0 C0\\nG1 X10 F600\\nM2\\n")
        >>> setup = dict(tool_length=120, origin=(-381, -254, -505))
        >>> [row["passed"] for row in trunnion.fleet.audit(program, "bc-trunnion", workers=0, **setup)]
        [True]
    """
    # What all items share is read and hashed once.
    shared = _Hash("options").text(sorted(options.items(), key=lambda one: one[0])).files_in(options, ".").key
    settings = _anywhere(options)
    named = [
        (name, _placed(machine), _Hash("machine").machine(machine).key)
        for name, machine in _machines("machines", machines)
    ]
    items = []
    paths = _paths("programs", programs)
    # Where nothing is kept, the content of programs does not matter: workers would wait until all are read.
    is_kept = results is not None or client is not None
    owns = _programs(paths, options) if is_kept else [os.path.abspath(program) for program in paths]
    for program, own in zip(paths, owns):
        for name, machine, of_machine in named:
            work = {"program": os.path.abspath(program), "machine": machine, "options": settings}
            columns = {"program": program, "machine": name}
            key = _Hash("audit").text([own, of_machine, shared]).key
            items.append({"key": key, "kind": "audit", "columns": columns, "work": work})
    return Fleet(_distinct(items), _Plan(results, client, workers, progress))


def _programs(paths: Sequence[str], options: Mapping[str, Any]) -> list[str]:
    """Returns the keys of programs, on all cores: workers wait for them."""
    from concurrent.futures import ThreadPoolExecutor

    def keys(programs: Sequence[str]) -> list[str]:
        return [
            _Hash("program").file(program).text(os.path.basename(program)).subprograms(program, options).key
            for program in programs
        ]

    # Several at once: most programs are read in less time than a thread needs to take the next.
    parts = [paths[start : start + _AT_ONCE] for start in range(0, len(paths), _AT_ONCE)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return [key for part in pool.map(keys, parts) for key in part]


def _machines(argument: str, value: Any) -> list[tuple[str, Any]]:
    """Returns names of machines for the table, and each machine: a Machine, or the name or file of one."""
    from ._trunnion import Machine

    one = isinstance(value, (str, os.PathLike, Mapping, Machine))
    named = []
    for machine in [value] if one else _options.sequence(argument, value, "machines"):
        machine = _options.as_machine(machine)
        if not isinstance(machine, Machine):
            machine = _options.path(argument, machine)
        named.append((machine.name if isinstance(machine, Machine) else machine, machine))
    names = [name for name, _ in named]
    counts = [names[:index].count(name) for index, name in enumerate(names)]
    return [(f"{name} ({count + 1})" if count else name, machine) for (name, machine), count in zip(named, counts)]


def _placed(machine: Any) -> Any:
    """Returns a machine for workers that stand in another folder."""
    from ._trunnion import Machine

    if not isinstance(machine, Machine):
        return _anywhere(machine)
    origin, rotation, tool_length = machine._setup()
    placed = Machine.from_toml(_options.machine_text(machine), machine.name)
    return placed.with_setup(origin=origin, rotation=rotation, tool_length=tool_length)


def _anywhere(value: Any) -> Any:
    """Returns nested values with the files in them named by their whole path."""
    if isinstance(value, Mapping):
        return {key: _anywhere(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_anywhere(one) for one in value]
    return os.path.abspath(value) if isinstance(value, (str, os.PathLike)) and os.path.isfile(value) else value


def _distinct(items: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Keeps the first of items with the same key: their results are the same."""
    return list({item["key"]: item for item in reversed(items)}.values())[::-1]


#: Short names of `compare`, as keys of a job.
_KEYS = {"tilt": "strategy.tilt_angle", "lead": "strategy.lead_angle", "direction": "strategy.along",
         "tolerance": "tolerance.total", "machine": "machine.file"}


def compare(
    job: Any,
    over: Mapping[str, Iterable[Any]],
    *,
    results: Any = None,
    client: Any = None,
    workers: int | None = None,
    progress: Progress = None,
) -> Fleet:
    """Runs a job with every combination of values.

    Args:
        job: a Job, a job file, or a dict with its content.
        over: values by name: `cutter` (Cutters), `tilt` and `lead` [degrees, for the method fixed-tilt], `direction`,
            `tolerance` [mm], `machine` (names, files that count from the folder of the job, Machines or dicts; a Machine
            brings its origin and rotation where it has some), or any key of the job such as "strategy.method".
        results, client, workers, progress: as in `audit`.

    Returns:
        A Fleet with a column for each name, `status`, `passed`, `duration` [s], `cutting` [s], `lower_bound` [s],
        `passes`, `cutting_length` [mm], `message`.

    Example:
        >>> import trunnion
        >>> fleet = trunnion.fleet.compare({"name": "a"}, {"tolerance": [0.01, 0.02]}, workers=0)
        >>> [row["status"] for row in fleet]
        ['failed', 'failed']
    """
    import itertools

    from ._job import Job
    from ._trunnion import Machine

    if isinstance(job, Mapping):
        job = Job(job)
    elif not isinstance(job, Job):
        job = Job.read(job)
    over = _options.mapping("over", over, "values by name")
    values = {str(name): _values(str(name), each) for name, each in over.items()}
    if not values or not all(values.values()):
        raise InputError("over has no values\n  help: give values by name: {\"tolerance\": [0.01, 0.02]}")
    folder = os.path.abspath(job.folder)
    items = []
    for combination in itertools.product(*values.values()):
        changes: dict[str, Any] = {}
        columns: dict[str, Any] = {}
        machine = None
        for name, (word, value) in zip(values, combination):
            changes.update(_changes(name, value))
            columns[name] = word
            machine = value if isinstance(value, Machine) else machine
        data = json.loads(_json(job.replace(changes).data))
        key = _Hash("run").text(data).files_in(data, folder)
        key = key if machine is None else key.machine(machine)
        placed = None if machine is None else _placed(machine)
        work = {"data": data, "folder": folder, "machine": placed}
        items.append({"key": key.key, "kind": "run", "columns": columns, "work": work})
    return Fleet(_distinct(items), _Plan(results, client, workers, progress))


def _json(data: Any) -> str:
    from ._rebuild import json_text

    return json_text(data)


def _values(name: str, values: Any) -> list[tuple[Any, Any]]:
    """Returns words for the table, and the values of a name."""
    if _KEYS.get(name, name) == _KEYS["machine"]:
        return _machines(name, values)
    plain = (str, int, float, bool, type(None))
    values = _options.sequence(f"over[{name!r}]", values, "values")
    return [(value if isinstance(value, plain) else str(value), value) for value in values]


def _changes(name: str, value: Any) -> dict[str, Any]:
    from ._trunnion import Cutter, Machine

    if isinstance(value, Cutter):
        return {"tool": value}
    if not isinstance(value, Machine):
        return {_KEYS.get(name, name): value}
    changes: dict[str, Any] = {_KEYS["machine"]: value.name}
    setup = {"setup.origin": value.origin.tolist(), "setup.rotation": value.rotation(deg=True).tolist()}
    return {**changes, **setup} if any(map(any, setup.values())) else changes


def which_machine(
    job: Any,
    machines: Any,
    *,
    results: Any = None,
    client: Any = None,
    workers: int | None = None,
    progress: Progress = None,
) -> list[dict[str, Any]]:
    """Runs a job on several machines, and returns their rows, the best first.

    A machine on which every tolerance and limit is kept comes before one on which it is not, a quicker one before a
    slower one, and a machine on which the job cannot run last, with the reason in `message`.

    Args:
        job, results, client, workers, progress: as in `compare`.
        machines: machines, one or several, as `machine` in `compare`.

    Example:
        >>> import trunnion
        >>> [row["machine"] for row in trunnion.fleet.which_machine({"name": "a"}, ["bc-trunnion"], workers=0)]
        ['bc-trunnion']
    """
    found = compare(job, {"machine": machines}, results=results, client=client, workers=workers, progress=progress)
    worst = float("inf")

    def rank(row: dict[str, Any]) -> tuple[bool, bool, float]:
        duration = row.get("duration")
        return row["status"] != "done", not row["passed"], worst if duration is None else float(duration)

    return sorted(found.rows, key=rank)
