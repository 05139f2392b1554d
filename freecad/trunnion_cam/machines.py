"""The machine of a job, with the setup of the workpiece on it."""

from __future__ import annotations

import json
import os
from typing import Any, NamedTuple

from . import compat, pictures
from .engine import engine
from .problem import Problem
from .translate import described, marked, translated


class AxisDynamics(NamedTuple):
    """Acceleration and jerk: mm/s2 and mm/s3 of linear axes, deg/s2 and deg/s3 of rotaries."""

    linear: tuple[float, float]
    rotary: tuple[float, float]


#: Usual dynamics by class of machine, for files that lack them. Typical values, no data sheet.
CLASSES = {
    "hobby": AxisDynamics((500.0, 5_000.0), (200.0, 2_000.0)),
    "machining centre": AxisDynamics((3_000.0, 30_000.0), (600.0, 6_000.0)),
    "high-speed": AxisDynamics((8_000.0, 160_000.0), (1_500.0, 30_000.0)),
}
#: What the panel calls them.
CLASS_NAMES = {"hobby": marked("hobby"), "machining centre": marked("machining centre"), "high-speed": marked("high-speed machine")}


class MachineSetup:
    """Proxy of the object that says on which machine a job runs, and where the part stands."""

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        add = obj.addProperty
        add("App::PropertyLinkHidden", "Job", "Machine", described("Job of the CAM workbench"))
        add("App::PropertyString", "Machine", "Machine", described("Name of a built-in machine, or machine file (TOML)"))
        add("App::PropertyVector", "Origin", "Setup", described("Zero of the document in machine coordinates, all axes at zero, mm"))
        add("App::PropertyVector", "Rotation", "Setup", described("Rotation about the machine's x, then y, then z, degrees"))
        add("App::PropertyLinkList", "Fixtures", "Setup", described("Solids that no part of the tool may touch"))
        add("App::PropertyLength", "Clearance", "Setup", described("Least distance from fixtures"))
        obj.Machine = "bc-trunnion"
        obj.Clearance = 1.0

    def execute(self, obj: Any) -> None:
        """Nothing is computed here; operations look when they are."""

    def onDocumentRestored(self, obj: Any) -> None:
        """Called by FreeCAD when a document was read."""
        pictures.show_view(obj, "machine")

    def dumps(self) -> None:
        """Nothing of the proxy is saved."""

    def loads(self, state: Any) -> None:
        """Nothing of the proxy was saved."""

    __getstate__, __setstate__ = dumps, loads


def create(job: Any, machine: str = "bc-trunnion") -> Any:
    """Adds a machine to a job, or changes the one that it has."""
    load(machine)
    found = machine_of(job)
    if found is None:
        found = job.Document.addObject("App::FeaturePython", "Machine")
        MachineSetup(found)
        found.Job = job
        found.Label = translated("Machine of {label}", label=job.Label)
        pictures.show_view(found, "machine")
    if found.Machine != machine:
        found.Machine = machine
    for operation in compat.operations(job):
        # They depend on it: a change of the machine plans them anew.
        if hasattr(operation, "InputKey") and operation.Machine is None:
            operation.Machine = found
    return found


def machine_of(job: Any) -> Any:
    """Returns the machine object of a job, or None."""
    for thing in job.Document.Objects:
        if isinstance(getattr(thing, "Proxy", None), MachineSetup) and thing.Job is not None and thing.Job.Name == job.Name:
            return thing
    return None


def needed_machine(job: Any) -> Any:
    """Returns the machine object of a job, and says what to do without one."""
    found = machine_of(job)
    if found is None:
        raise Problem(translated("{label} has no machine", label=job.Label), translated("choose one with the command Machine"))
    return found


def load(source: str) -> Any:
    """Returns the engine's machine of a name or file."""
    trunnion = engine()
    if source not in trunnion.built_in() and not os.path.isfile(source):
        names = ", ".join(trunnion.built_in())
        raise Problem(
            translated("there is no machine '{source}'", source=source),
            translated("give a machine file, or one of the built-in machines: {names}", names=names),
        )
    return trunnion.Machine(source)


def convert_fcm(text: str, dynamics: AxisDynamics) -> tuple[dict[str, Any], list[str]]:
    """Converts a machine of FreeCAD (`.fcm`) to the engine's machine file.

    Returns:
        the machine as a dict, and remarks about what the file does not say.
    """
    try:
        found = json.loads(text)
    except ValueError as error:
        raise Problem(
            translated("the file is no machine of FreeCAD: {error}", error=error),
            translated("choose a .fcm file that the machine editor of FreeCAD wrote"),
        ) from None
    machine = found.get("machine", found) if isinstance(found, dict) else {}
    axes = machine.get("axes")
    if not isinstance(axes, dict) or not axes:
        raise Problem(translated("the file has no axes"), translated("choose a .fcm file that the machine editor of FreeCAD wrote"))
    rotaries = [name for name, axis in axes.items() if axis.get("type") in ("rotary", "angular")]
    if len(rotaries) != 2 or set("XYZ") - set(axes):
        names = ", ".join(axes)
        raise Problem(
            translated("the machine has the axes {names}; five-axis work needs X, Y, Z and two rotaries", names=names),
            translated("add the missing axes in the machine editor"),
        )
    remarks = [
        translated("acceleration and jerk are those that were entered: compare them with the parameters of the control"),
        translated(
            "directions of rotation are taken as ISO 841 has them: jog each rotary by +30 degrees, "
            "and add `sense = -1` where it turns the other way"
        ),
        translated("the gauge point is taken at the zero of all axes: enter where the spindle nose stands"),
    ]
    table = {name: _axis(name, axis, dynamics) for name, axis in axes.items() if name in (*"XYZ", *rotaries)}
    under, over = ([name for name in table if _carries(axes[name]) == side] for side in ("table", "head"))
    # From the workpiece to the base: what carries comes later.
    chain = ["w", *reversed(_from_base(under, axes)), "b", *_from_base(over, axes), "t"]
    return {
        "schema": "trunnion-machine/1",
        "name": str(machine.get("name") or "machine"),
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "chain": chain,
        "tool_axis": [0, 0, 1],
        "gauge": [0, 0, 0],
        "axis": table,
    }, remarks


def _carries(axis: dict[str, Any]) -> str:
    return "head" if str(axis.get("role", "")).startswith("head") else "table"


def _from_base(names: list[str], axes: dict[str, Any]) -> list[str]:
    """Returns axes so that each stands behind the one that carries it; linear axes carry rotaries."""

    def depth(name: str) -> int:
        parent, steps = axes[name].get("parent"), 0
        while parent in axes and steps < len(axes):
            parent, steps = axes[parent].get("parent"), steps + 1
        return steps

    def order(name: str) -> tuple[int, int, int]:
        axis = axes[name]
        return (axis.get("type") != "linear", depth(name), int(axis.get("sequence") or 0))

    return sorted(names, key=order)


def _axis(name: str, axis: dict[str, Any], dynamics: AxisDynamics) -> dict[str, Any]:
    joint = axis.get("joint") or {}
    joint = joint if isinstance(joint, dict) else {"origin": joint[0], "axis": joint[1]}
    limits = axis.get("limits") or {}
    linear = axis.get("type") == "linear"
    acceleration, jerk = dynamics.linear if linear else dynamics.rotary
    direction = [float(value) for value in joint.get("axis", [])]
    if len(direction) != 3 or not any(direction):
        raise Problem(translated("axis {name} has no direction", name=name), translated("enter it in the machine editor"))
    table: dict[str, Any] = {
        "kind": "linear" if linear else "rotary",
        "dir": direction,
        "limits": [float(limits.get("min", 0.0)), float(limits.get("max", 1000.0 if linear else 360.0))],
        # Files have mm/min and deg/min.
        "vel": float(axis.get("max_velocity", 10_000.0)) / 60.0,
        "acc": acceleration,
        "jerk": jerk,
    }
    if not linear:
        table["point"] = [float(value) for value in joint.get("origin", [0, 0, 0])]
    return table
