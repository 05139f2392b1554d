"""Check of a whole CAM job: its program against machine, part, stock and fixtures."""

from __future__ import annotations

import os
import re
import tempfile
from typing import Any, Callable, NamedTuple

from . import compat, deviation, machines, pictures, programs, shapes, tools
from .engine import engine
from .problem import Problem, words
from .translate import translated

_LINE = re.compile(r"\bline (\d+)\b")


class Finding(NamedTuple):
    """One problem: its words, its line in the program, and where that line comes from (None for the job as a whole)."""

    text: str
    line: int
    place: programs.Place | None


class JobCheck(NamedTuple):
    """Verdict of a check.

    Attributes:
        passed: True if nothing is broken.
        problems, remarks: broken limits, and what does not fail the check.
        program: the program that was checked.
        table: the summary as the command line prints it.
        drawn: the part as a coloured mesh, which `show` puts into the document.
    """

    passed: bool
    problems: list[Finding]
    remarks: list[Finding]
    program: programs.Program
    table: str
    drawn: pictures.Drawn


class Question(NamedTuple):
    """Everything that a check needs, taken from the document: the check itself runs beside the window."""

    program: programs.Program
    options: dict[str, Any]
    files: dict[str, bytes]
    #: A copy of the part, which is triangulated beside the window; None if the part is not measured.
    shape: Any


class Setup(NamedTuple):
    """The program of a job as it stands on its machine: where, and with which tools [mm, degrees]."""

    program: programs.Program
    machine: str
    origin: list[float]
    rotation: list[float]
    lengths: dict[int, float]


def setup(job: Any, operations: list[Any]) -> Setup:
    """Gathers the program of some operations of a job, with machine and tool lengths."""
    machine = machines.needed_machine(job)
    machines.load(machine.Machine)
    for one in own_operations(operations):
        if not one.Path.Commands or one.Stale:
            # Else the operation would be left out without a word.
            raise Problem(
                translated("{label} has no program: {verdict}", label=one.Label, verdict=one.Verdict),
                translated("wait until it is planned, recompute it, or switch it off with Active"),
            )
    program = programs.program_of(operations)
    lengths: dict[int, float] = {}
    for one in own_operations(operations):
        number, length = int(one.ToolController.ToolNumber), float(one.ToolLength.Value)
        if abs(lengths.setdefault(number, length) - length) > 1e-9:
            raise Problem(
                translated("tool {number} has the lengths {first} and {second} mm", number=number, first=lengths[number], second=length),
                translated("enter the same length in all operations of the tool"),
            )
    for number, controller in program.tools.items():
        lengths.setdefault(number, tools.usual_length(controller))
    return Setup(program, machine.Machine, [*machine.Origin], [*machine.Rotation], lengths)


def own_operations(operations: list[Any]) -> list[Any]:
    """Returns the active five-axis finishes among operations."""
    return [one for one in map(compat.base_operation, operations) if hasattr(one, "InputKey") and one.Active]


def question(job: Any) -> Question:
    """Gathers the program of a job, its part, stock and fixtures."""
    stands = setup(job, compat.operations(job))
    machine = machines.needed_machine(job)
    program, lengths = stands.program, stands.lengths
    files: dict[str, bytes] = {}
    own = own_operations(compat.operations(job))
    options: dict[str, Any] = {
        "machine": stands.machine,
        "dialect": "linuxcnc",
        "origin": stands.origin,
        "rotation": stands.rotation,
        "deg": True,
        "tool_length": lengths,
    }
    part = None
    cutters = _cutters(program.tools, lengths)
    if cutters is not None:
        options["cutter"] = cutters
        part = model(job).copy()
        files["part.step"] = shapes.step_bytes(part)
        tolerances = [(float(one.Excess.Value), float(one.Gouge.Value)) for one in own]
        excess, gouge = max(tolerances) if tolerances else (1.0, 0.01)
        options["tolerance"] = (excess, gouge)
        # Only gouges count: other operations and other setups cut the rest.
        options["accept"] = ["uncut", "excess", "rapid-finish", "unmeasured"]
    stock = getattr(job.Stock, "Shape", None) if job.Stock is not None else None
    if stock is not None and stock.Solids:
        files["stock.step"] = shapes.step_bytes(stock)
    for index, one in enumerate(machine.Fixtures, 1):
        files[f"fixture{index}.step"] = shapes.step_bytes(shapes.placed_shape(one))
    if machine.Fixtures:
        options["clearance"] = float(machine.Clearance.Value)
    return Question(program, options, files, part)


def _cutters(controllers: dict[int, Any], lengths: dict[int, float]) -> str | dict[int, str] | None:
    """Returns the cutters by tool number; None if the shape of one is not known."""
    try:
        found = {number: tools.cutter_words(one, lengths[number]) for number, one in controllers.items()}
    except Problem:
        # Drills and the like: axes, state, stock and fixtures are checked without the part.
        return None
    return found if len(found) > 1 else next(iter(found.values()))


def model(job: Any) -> Any:
    """Returns the shape of the model of a job."""
    import Part

    found = [shapes.placed_shape(one) for one in job.Model.Group]
    if not found:
        raise Problem(translated("{label} has no model", label=job.Label), translated("add one to the job"))
    return found[0] if len(found) == 1 else Part.Compound(found)


def answer(asked: Question, progress: Callable[[str, int, int], None] | None = None) -> JobCheck:
    """Runs the check."""
    trunnion = engine()
    with tempfile.TemporaryDirectory() as folder:
        paths = {}
        for name, content in asked.files.items():
            paths[name] = os.path.join(folder, name)
            with open(paths[name], "wb") as file:
                file.write(content)
        options = dict(asked.options)
        if "part.step" in paths:
            options["part"] = paths["part.step"]
        if "stock.step" in paths:
            options["stock"] = paths["stock.step"]
        fixtures = [path for name, path in paths.items() if name.startswith("fixture")]
        if fixtures:
            options["fixture"] = fixtures
        try:
            found = trunnion.check(asked.program.text.encode(), progress=progress, **options)
        except trunnion.TrunnionError as error:
            text = words(error).replace(folder + os.sep, "")
            lines = _LINE.findall(text) or re.findall(r"program:(\d+)", text)
            if not lines:
                raise Problem(text) from None
            problems = [_finding(text, int(lines[0]), asked.program)]
            return JobCheck(False, problems, [], asked.program, text, pictures.drawn([], None))
    mesh = None
    if asked.shape is not None:
        mesh = deviation.of_shape(asked.shape, deviation.Measured(found.point, found.height), *asked.options["tolerance"])
    listed = [[_finding(text, _line_of(text), asked.program) for text in texts] for texts in (found.failures, found.warnings)]
    return JobCheck(found.passed, listed[0], listed[1], asked.program, str(found), pictures.drawn([], mesh))


def _line_of(text: str) -> int:
    match = _LINE.search(text) or re.search(r"program:(\d+)", text)
    return int(match[1]) if match else 0


def _finding(text: str, line: int, program: programs.Program) -> Finding:
    return Finding(text, line, program.place(line) if line else None)


def check(job: Any, progress: Callable[[str, int, int], None] | None = None) -> JobCheck:
    """Checks a job, in scripts."""
    return answer(question(job), progress)


_MESH = "CheckedDeviation"


def show(job: Any, found: JobCheck) -> Any:
    """Puts the coloured mesh of a check into the document, in place of that of an earlier one, and returns it; None if nothing was measured."""
    name = f"{job.Name}{_MESH}"
    for old in [one for one in job.Document.Objects if one.Name.startswith(name)]:
        job.Document.removeObject(old.Name)
    if found.drawn.mesh is None:
        return None
    for other in job.Document.Objects:
        # Meshes of operations lie in the same place.
        if isinstance(getattr(other, "Proxy", None), pictures.DeviationMesh) and other.ViewObject is not None:
            other.ViewObject.Visibility = False
    return pictures.add_deviation(job.Document, found.drawn, translated("Deviation of {label}", label=job.Label), name)
