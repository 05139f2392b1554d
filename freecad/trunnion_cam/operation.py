"""Five-axis finish: an operation of a CAM job."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from typing import Any, Callable, NamedTuple

from . import compat, deviation, machines, pictures, programs, shapes, tools
from .engine import engine
from .problem import Problem, words
from .translate import described, marked, translated

Progress = Callable[[str, int, int], None]
OnPasses = Callable[[int, list[dict[str, Any]]], None]

#: Values of a job file, and what the panel calls them.
METHODS = {
    "auto": marked("automatic"),
    "widest": marked("widest strips"),
    "fixed-tilt": marked("fixed inclination"),
    "ball": marked("ball end"),
    "flank": marked("flank"),
}
ALONG = {
    "adaptive": marked("as the face asks"),
    "u": marked("u of the face"),
    "v": marked("v of the face"),
    "curvature": marked("least curvature"),
}
DIRECTIONS = {"zigzag": marked("zigzag"), "one-way": marked("one way")}
#: Program from which the path is made.
_DIALECT = "linuxcnc"


class Inputs(NamedTuple):
    """Everything that decides a result."""

    job: dict[str, Any]
    step: bytes
    key: str
    faces: list[shapes.FaceMark]
    #: Diagonal of the part [mm].
    size: float
    #: A copy of the faces, which are triangulated beside the window.
    shape: Any


class Prepared(NamedTuple):
    """A result as the document takes it; everything that takes time was done beside the window."""

    result: Any
    path: Any
    drawn: pictures.Drawn


class FiveAxisFinish:
    """Proxy of the operation: faces, tool, tolerance and strategy in; path, programs and verdict out."""

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        self.add_properties(obj)

    def add_properties(self, obj: Any) -> None:
        """Adds what is missing; operations of older versions get new properties."""
        for kind, name, group, text, value in _PROPERTIES:
            if hasattr(obj, name):
                continue
            obj.addProperty(kind, name, group, text)
            if value is not None:
                setattr(obj, name, value)
        for name in ("Verdict", "Kept", "Duration", "Stale", "InputKey", "Programs", "SetupSheet"):
            obj.setEditorMode(name, 1)
        obj.setEditorMode("InputKey", 2)

    def onDocumentRestored(self, obj: Any) -> None:
        """Called by FreeCAD when a document was read."""
        self.add_properties(obj)
        if obj.Machine is None and obj.Job is not None:
            obj.Machine = machines.machine_of(obj.Job)
        pictures.show_view(obj, "finish")

    def execute(self, obj: Any) -> None:
        """Recomputes if the model or a setting has changed, and only then. The document stays whole whatever happens."""
        import FreeCAD

        try:
            if key(obj) == obj.InputKey:
                obj.Stale = False
                return
            found = inputs(obj)
        except Problem as problem:
            refuse(obj, problem)
            return
        obj.Stale = True
        if FreeCAD.GuiUp:
            # Planning takes seconds: it runs beside the window.
            from .gui import running

            running.plan(obj, found)
            return
        try:
            apply(obj, found, prepare(found, compute(found)))
        except Problem as problem:
            refuse(obj, problem)

    def dumps(self) -> None:
        """Nothing of the proxy is saved."""

    def loads(self, state: Any) -> None:
        """Nothing of the proxy was saved."""

    __getstate__, __setstate__ = dumps, loads


_PROPERTIES = [
    ("App::PropertyLinkSub", "Base", "Faces", described("Faces to finish, of one body"), None),
    ("App::PropertyBool", "Flip", "Faces", described("The cutter works on the other side of the faces"), False),
    ("App::PropertyLinkHidden", "Job", "Base", described("Job of this operation"), None),
    ("App::PropertyLink", "Machine", "Base", described("Machine of the job: a change of it, or of a fixture, plans anew"), None),
    ("App::PropertyLink", "ToolController", "Tool", described("Tool controller of the job"), None),
    ("App::PropertyLength", "ToolLength", "Tool", described("From gauge point to tip"), 100.0),
    ("App::PropertyLength", "Excess", "Tolerance", described("Largest excess after everything"), 0.02),
    ("App::PropertyLength", "Gouge", "Tolerance", described("Deepest gouge after everything"), 0.002),
    ("App::PropertyEnumeration", "Method", "Strategy", described("How the tool is placed"), list(METHODS)),
    ("App::PropertyEnumeration", "Along", "Strategy", described("Direction of the passes"), list(ALONG)),
    ("App::PropertyEnumeration", "Direction", "Strategy", described("Order of the passes"), list(DIRECTIONS)),
    ("App::PropertyAngle", "LeadAngle", "Strategy", described("Inclination along the feed, for fixed-tilt and ball"), 10.0),
    ("App::PropertyAngle", "TiltAngle", "Strategy", described("Inclination sideways, for fixed-tilt and ball"), 0.0),
    ("App::PropertyLength", "ClearanceHeight", "Strategy", described("Links travel this far above the part"), 10.0),
    ("App::PropertyBool", "Coolant", "Strategy", described("Coolant is on in cuts"), True),
    ("App::PropertyStringList", "Dialects", "Output", described("Dialects that are written besides LinuxCNC"), None),
    ("App::PropertyBool", "Active", "Output", described("Take part in checks and programs"), True),
    ("App::PropertyString", "Comment", "Output", described("Comment"), None),
    ("App::PropertyString", "Verdict", "Result", described("What the check of the program says"), None),
    ("App::PropertyBool", "Kept", "Result", described("Every tolerance and limit is kept"), False),
    ("App::PropertyFloat", "Duration", "Result", described("Planned time, s"), None),
    ("App::PropertyBool", "Stale", "Result", described("Model or settings have changed since"), False),
    ("App::PropertyMap", "Programs", "Result", described("Programs by file name"), None),
    ("App::PropertyString", "SetupSheet", "Result", described("Setup sheet"), None),
    ("App::PropertyString", "InputKey", "Result", described("Fingerprint of everything that decided the result"), None),
    ("App::PropertyLinkList", "Pictures", "Result", described("Passes and deviation"), None),
]


def create(job: Any, thing: Any, faces: list[str], controller: Any = None) -> Any:
    """Adds a five-axis finish of these faces to a job, without computing it."""
    if not compat.is_job(job):
        raise Problem(
            translated("{label} is no job of the CAM workbench", label=getattr(job, "Label", job)), translated("create a job first")
        )
    compat.need_proxy(job)
    controllers = compat.controllers(job)
    if controller is None and not controllers:
        raise Problem(
            translated("{label} has no tool controller", label=job.Label), translated("add one with a flat, ball or bull-nose end mill")
        )
    operation = job.Document.addObject("Path::FeaturePython", "FiveAxisFinish")
    FiveAxisFinish(operation)
    operation.Label = translated("Five-axis finish")
    operation.Job = job
    operation.Machine = machines.machine_of(job)
    operation.Base = (thing, faces)
    operation.ToolController = controller or controllers[0]
    operation.ToolLength = tools.usual_length(operation.ToolController)
    operation.Verdict = translated("not computed")
    compat.add_operation(job, operation)
    pictures.show_view(operation, "finish")
    return operation


def key(obj: Any) -> str:
    """Returns the fingerprint of everything that decides the result; raises Problem with what is missing."""
    return _key(obj, _parts(obj))


class _Parts(NamedTuple):
    """What an operation works with: shape, names of faces, machine, shapes of fixtures, content of the job."""

    shape: Any
    names: list[str]
    machine: Any
    solids: list[Any]
    data: dict[str, Any]


def _parts(obj: Any) -> _Parts:
    if obj.Job is None:
        raise Problem(translated("{label} belongs to no job", label=obj.Label), translated("create it again in a job"))
    if not obj.Base or not obj.Base[1]:
        raise Problem(translated("no face is chosen"), translated("select the faces to finish, of one body"))
    if obj.ToolController is None:
        raise Problem(translated("no tool controller is chosen"), translated("choose one of the job"))
    thing, names = obj.Base
    shape = shapes.placed_shape(thing)
    machine = machines.needed_machine(obj.Job)
    solids = [shapes.placed_shape(one) for one in machine.Fixtures]
    return _Parts(shape, list(names), machine, solids, job_data(obj, machine))


def _key(obj: Any, parts: _Parts) -> str:
    settings = json.dumps([parts.data, parts.names, machine_text(parts.machine.Machine)], sort_keys=True)
    texts = [settings, shapes.fingerprint(parts.shape), *map(shapes.fingerprint, parts.solids)]
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def inputs(obj: Any) -> Inputs:
    """Returns the job of an operation, with its part and its key; raises Problem with what is missing."""
    import Part

    parts = _parts(obj)
    found = _key(obj, parts)
    marks = shapes.face_marks(parts.shape, parts.names)
    fixtures = [
        {"name": one.Label, "kind": "step", "file": f"fixture{index}.step", "bytes": shapes.step_bytes(solid).decode("latin-1")}
        for index, (one, solid) in enumerate(zip(parts.machine.Fixtures, parts.solids), 1)
    ]
    data = parts.data | ({"fixture": fixtures} if fixtures else {})
    faces = Part.Compound([parts.shape.Faces[mark.index - 1].copy() for mark in marks])
    return Inputs(data, shapes.step_bytes(parts.shape), found, marks, parts.shape.BoundBox.DiagonalLength, faces)


def machine_text(source: str) -> str:
    """Returns the content of a machine file, so that a change of it is seen."""
    if not os.path.isfile(source):
        return source
    with open(source, encoding="utf-8", errors="replace") as file:
        return file.read()


def job_data(obj: Any, machine: Any) -> dict[str, Any]:
    """Returns an operation as the content of a job file."""
    controller = obj.ToolController
    strategy: dict[str, Any] = {"method": str(obj.Method), "along": str(obj.Along), "direction": str(obj.Direction)}
    if obj.Method in ("fixed-tilt", "ball"):
        strategy |= {"lead_angle": float(obj.LeadAngle.Value), "tilt_angle": float(obj.TiltAngle.Value)}
    data: dict[str, Any] = {
        "schema": "trunnion-job/1",
        "name": f"{obj.Base[0].Label} {obj.Label}",
        "part": {"file": "part.step", "faces": []},
        "setup": {
            "origin": [*machine.Origin],
            "rotation": [*machine.Rotation],
            "clearance": float(obj.ClearanceHeight.Value),
        },
        "tool": tools.tool_table(controller, float(obj.ToolLength.Value)),
        "tolerance": {"total": float(obj.Excess.Value), "gouge": float(obj.Gouge.Value)},
        "strategy": strategy,
        "cutting": {"feed": tools.feed(controller), "spindle": tools.spindle(controller), "coolant": bool(obj.Coolant)},
        "machine": {"file": machine.Machine},
        "output": {"dialects": [_DIALECT, *(one for one in obj.Dialects if one != _DIALECT)]},
    }
    if obj.Flip:
        data["part"]["flip"] = True
    if machine.Fixtures:
        data["verify"] = {"fixture_clearance": float(machine.Clearance.Value)}
    return data


def write_job(found: Inputs, folder: str) -> Any:
    """Writes job.toml and its parts into a folder, and returns the engine's job: `trunnion run` takes it from there."""
    data = json.loads(json.dumps(found.job))
    data["part"]["faces"] = shapes.face_numbers(found.step, found.faces, found.size)
    with open(os.path.join(folder, "part.step"), "wb") as file:
        file.write(found.step)
    for fixture in data.get("fixture", []):
        with open(os.path.join(folder, fixture["file"]), "wb") as file:
            file.write(fixture.pop("bytes").encode("latin-1"))
    if os.path.isfile(data["machine"]["file"]):
        data["machine"]["file"] = os.path.abspath(data["machine"]["file"])
    path = os.path.join(folder, "job.toml")
    engine().Job(data, folder).save(path)
    return engine().Job.read(path)


def compute(
    found: Inputs, progress: Progress | None = None, output: str | None = None, on_passes: OnPasses | None = None
) -> Any:
    """Runs the job of an operation and returns the engine's result; with `output` the files of the run are written there.

    `on_passes` gets the number of a face and its passes while they are placed.
    """
    with tempfile.TemporaryDirectory() as folder:
        try:
            return write_job(found, folder).run(output=output, progress=progress, on_passes=on_passes)
        except engine().TrunnionError as error:
            raise Problem(words(error).replace(folder + os.sep, "")) from None


def prepare(found: Inputs, result: Any) -> Prepared:
    """Makes path, passes and mesh of a result; runs beside the window."""
    import Path

    text = next((text for name, text in result.programs.items() if name.endswith(".ngc")), "")
    tolerances = found.job["tolerance"]
    measured = deviation.joined(result.maps)
    mesh = deviation.of_shape(found.shape, measured, tolerances["total"], tolerances["gouge"])
    return Prepared(result, Path.Path(programs.commands(text)), pictures.drawn(result.passes, mesh))


def apply(obj: Any, found: Inputs, prepared: Prepared) -> None:
    """Puts a result into the operation: path, programs, verdict, pictures."""
    for step in steps(obj, found, prepared):
        step()


def steps(obj: Any, found: Inputs, prepared: Prepared) -> list[Callable[[], None]]:
    """Returns what `apply` does, in pieces between which the window is served."""
    result = prepared.result

    def texts() -> None:
        obj.Programs = dict(result.programs)
        obj.SetupSheet = result.setup
        obj.Kept = bool(result.passed)
        obj.Duration = float(result.duration)
        problems = "; ".join(result.failures)
        kept = translated("every tolerance and limit is kept")
        obj.Verdict = kept if result.passed else translated("NOT KEPT: {problems}", problems=problems)

    def path() -> None:
        obj.Path = prepared.path

    def last() -> None:
        obj.InputKey, obj.Stale = found.key, False

    return [texts, path, *pictures.steps(obj, prepared.drawn), last]


def refuse(obj: Any, problem: Problem) -> None:
    """Says why there is no result. An old path and its pictures are taken away: they are those of another model."""
    import FreeCAD
    import Path

    obj.Path = Path.Path()
    obj.Kept, obj.InputKey, obj.Programs, obj.SetupSheet, obj.Duration = False, "", {}, "", 0.0
    obj.Verdict = str(problem)
    pictures.remove(obj)
    FreeCAD.Console.PrintError(f"{obj.Label}: {problem}\n")
