"""Five-axis finish: an operation of a CAM job."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from typing import Any, Callable, NamedTuple

from . import compat, machines, programs, shapes, tools
from .engine import engine
from .problem import Problem, words

Progress = Callable[[str, int, int], None]

METHODS = ["auto", "widest", "fixed-tilt", "ball", "flank"]
ALONG = ["adaptive", "u", "v", "curvature"]
DIRECTIONS = ["zigzag", "one-way"]
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

    def execute(self, obj: Any) -> None:
        """Recomputes if the model or a setting has changed, and only then. The document stays whole whatever happens."""
        import FreeCAD

        try:
            found = inputs(obj)
        except Problem as problem:
            refuse(obj, problem)
            return
        if found.key == obj.InputKey:
            obj.Stale = False
            return
        obj.Stale = True
        if FreeCAD.GuiUp:
            # Planning takes seconds: it runs beside the window.
            from .gui import running

            running.plan(obj, found)
            return
        try:
            apply(obj, found, compute(found))
        except Problem as problem:
            refuse(obj, problem)

    def dumps(self) -> None:
        """Nothing of the proxy is saved."""

    def loads(self, state: Any) -> None:
        """Nothing of the proxy was saved."""

    __getstate__, __setstate__ = dumps, loads


_PROPERTIES = [
    ("App::PropertyLinkSub", "Base", "Faces", "Faces to finish, of one body", None),
    ("App::PropertyBool", "Flip", "Faces", "The cutter works on the other side of the faces", False),
    ("App::PropertyLinkHidden", "Job", "Base", "Job of this operation", None),
    ("App::PropertyLink", "ToolController", "Tool", "Tool controller of the job", None),
    ("App::PropertyLength", "ToolLength", "Tool", "From gauge point to tip", 100.0),
    ("App::PropertyLength", "Excess", "Tolerance", "Largest excess after everything", 0.02),
    ("App::PropertyLength", "Gouge", "Tolerance", "Deepest gouge after everything", 0.002),
    ("App::PropertyEnumeration", "Method", "Strategy", "How the tool is placed", METHODS),
    ("App::PropertyEnumeration", "Along", "Strategy", "Direction of the passes", ALONG),
    ("App::PropertyEnumeration", "Direction", "Strategy", "Order of the passes", DIRECTIONS),
    ("App::PropertyAngle", "LeadAngle", "Strategy", "Inclination along the feed, for fixed-tilt and ball", 10.0),
    ("App::PropertyAngle", "TiltAngle", "Strategy", "Inclination sideways, for fixed-tilt and ball", 0.0),
    ("App::PropertyLength", "ClearanceHeight", "Strategy", "Links travel this far above the part", 10.0),
    ("App::PropertyBool", "Coolant", "Strategy", "Coolant is on in cuts", True),
    ("App::PropertyStringList", "Dialects", "Output", "Dialects that are written besides LinuxCNC", None),
    ("App::PropertyBool", "Active", "Output", "Take part in checks and programs", True),
    ("App::PropertyString", "Comment", "Output", "Comment", None),
    ("App::PropertyString", "Verdict", "Result", "What the check of the program says", "not computed"),
    ("App::PropertyBool", "Kept", "Result", "Every tolerance and limit is kept", False),
    ("App::PropertyFloat", "Duration", "Result", "Planned time, s", None),
    ("App::PropertyBool", "Stale", "Result", "Model or settings have changed since", False),
    ("App::PropertyMap", "Programs", "Result", "Programs by file name", None),
    ("App::PropertyString", "SetupSheet", "Result", "Setup sheet", None),
    ("App::PropertyString", "InputKey", "Result", "Fingerprint of everything that decided the result", None),
    ("App::PropertyLinkList", "Pictures", "Result", "Passes and deviation", None),
]


def create(job: Any, thing: Any, faces: list[str], controller: Any = None) -> Any:
    """Adds a five-axis finish of these faces to a job, without computing it."""
    if not compat.is_job(job):
        raise Problem(f"{getattr(job, 'Label', job)} is no job of the CAM workbench", "create a job first")
    controllers = compat.controllers(job)
    if controller is None and not controllers:
        raise Problem(f"{job.Label} has no tool controller", "add one with a flat, ball or bull-nose end mill")
    operation = job.Document.addObject("Path::FeaturePython", "FiveAxisFinish")
    FiveAxisFinish(operation)
    operation.Label = "Five-axis finish"
    operation.Job = job
    operation.Base = (thing, faces)
    operation.ToolController = controller or controllers[0]
    operation.ToolLength = tools.usual_length(operation.ToolController)
    compat.add_operation(job, operation)
    return operation


def inputs(obj: Any) -> Inputs:
    """Returns the job of an operation, with its part and its key; raises Problem with what is missing."""
    if obj.Job is None:
        raise Problem(f"{obj.Label} belongs to no job", "create it again in a job")
    if not obj.Base or not obj.Base[1]:
        raise Problem("no face is chosen", "select the faces to finish, of one body")
    if obj.ToolController is None:
        raise Problem("no tool controller is chosen", "choose one of the job")
    thing, names = obj.Base
    shape = shapes.placed_shape(thing)
    machine = machines.needed_machine(obj.Job)
    data = job_data(obj, machine)
    solids = [shapes.placed_shape(one) for one in machine.Fixtures]
    settings = json.dumps([data, list(names), machine_text(machine.Machine)], sort_keys=True)
    parts = [settings, shapes.fingerprint(shape), *map(shapes.fingerprint, solids)]
    key = hashlib.sha256("\n".join(parts).encode()).hexdigest()
    if key == obj.InputKey:
        # Nothing has changed: STEP and numbers are not needed.
        return Inputs(data, b"", key, [], 0.0)
    marks = shapes.face_marks(shape, names)
    data["fixture"] = [
        {"name": one.Label, "kind": "step", "file": f"fixture{index}.step", "bytes": shapes.step_bytes(solid).decode("latin-1")}
        for index, (one, solid) in enumerate(zip(machine.Fixtures, solids), 1)
    ]
    if not data["fixture"]:
        del data["fixture"]
    return Inputs(data, shapes.step_bytes(shape), key, marks, shape.BoundBox.DiagonalLength)


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


def compute(found: Inputs, progress: Progress | None = None, output: str | None = None) -> Any:
    """Runs the job of an operation and returns the engine's result; with `output` the files of the run are written there."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return write_job(found, folder).run(output=output, progress=progress)
        except engine().TrunnionError as error:
            raise Problem(words(error).replace(folder + os.sep, "")) from None


def apply(obj: Any, found: Inputs, result: Any) -> None:
    """Puts a result into the operation: path, programs, verdict, pictures."""
    import Path

    text = next((text for name, text in result.programs.items() if name.endswith(".ngc")), "")
    obj.Path = Path.Path(programs.commands(text))
    obj.Programs = dict(result.programs)
    obj.SetupSheet = result.setup
    obj.Kept = bool(result.passed)
    obj.Duration = float(result.duration)
    problems = "; ".join(result.failures)
    obj.Verdict = "every tolerance and limit is kept" if result.passed else f"NOT KEPT: {problems}"
    obj.InputKey, obj.Stale = found.key, False
    from . import pictures

    pictures.draw(obj, result)


def refuse(obj: Any, problem: Problem) -> None:
    """Says why there is no result. An old path is taken away: it is that of another model."""
    import FreeCAD
    import Path

    obj.Path = Path.Path()
    obj.Kept, obj.InputKey, obj.Programs = False, "", {}
    obj.Verdict = str(problem)
    FreeCAD.Console.PrintError(f"{obj.Label}: {problem}\n")
