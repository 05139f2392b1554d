"""Best setup, comparison and simulation of an operation."""

from __future__ import annotations

import os
import tempfile
from typing import Any, Callable

from . import checking, operation, shapes
from .engine import engine
from .problem import Problem, words
from .translate import translated

Progress = Callable[[str, int, int], None]


def best_setup(found: operation.Inputs, progress: Progress | None = None) -> dict[str, Any]:
    """Searches the rotation of the workpiece; returns what `trunnion setup --json` prints."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return operation.write_job(found, folder).setups(progress=progress)
        except engine().TrunnionError as error:
            raise Problem(words(error).replace(folder + os.sep, "")) from None


def use_setup(machine: Any, summary: dict[str, Any]) -> None:
    """Puts the best setup of a search into the machine of a job."""
    import FreeCAD

    best = summary.get("after")
    if not best:
        raise Problem(translated("no rotation within the bounds fits"), translated("allow more tilt, or take a shorter tool"))
    machine.Origin = FreeCAD.Vector(*best["origin"])
    machine.Rotation = FreeCAD.Vector(*best["rotation"])


def compare(
    found: operation.Inputs, over: dict[str, list[Any]], progress: Progress | None = None
) -> list[dict[str, Any]]:
    """Runs the job of an operation with other values, such as `{"tool.diameter": [6, 10]}`; returns a row for each value."""
    trunnion = engine()
    with tempfile.TemporaryDirectory() as folder:
        try:
            job = operation.write_job(found, folder)
            # In this process: a worker process would be another FreeCAD. The engine uses every core for one run.
            return trunnion.fleet.compare(job, over, workers=0, progress=progress).rows
        except trunnion.TrunnionError as error:
            raise Problem(words(error).replace(folder + os.sep, "")) from None


def simulate(found: operation.Inputs, folder: str, progress: Progress | None = None) -> str:
    """Runs the job of an operation, and returns its report page, which plays the program."""
    operation.compute(found, progress, output=folder)
    return os.path.join(folder, "report.html")


def usual_origin(job: Any, machine: str) -> list[float]:
    """Returns an origin of the document on a machine that `trunnion init` would propose for the model of a job [mm]."""
    return origin_of(shapes.step_bytes(checking.model(job)), machine)


def quick_origin(job: Any, machine: str) -> list[float]:
    """Returns what `usual_origin` does for the box around the model of a job [mm]: at once, however many faces there are.

    Both are equal unless a rotary axis is oblique: then the exact one knows which way the faces look.
    """
    import FreeCAD
    import Part

    box = checking.model(job).BoundBox
    solid = Part.makeBox(box.XLength, box.YLength, box.ZLength, FreeCAD.Vector(box.XMin, box.YMin, box.ZMin))
    return origin_of(shapes.step_bytes(solid), machine)


def origin_of(step: bytes, machine: str, progress: Progress | None = None) -> list[float]:
    """Returns an origin that `trunnion init` would propose for a part [mm]; runs beside the window."""
    trunnion = engine()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "part.step")
        with open(path, "wb") as file:
            file.write(step)
        try:
            # The workpiece of the document lies as it is drawn.
            proposed = trunnion.Job.propose(path, machine, rotation=[0.0, 0.0, 0.0], progress=progress)
        except trunnion.TrunnionError as error:
            raise Problem(words(error).replace(folder + os.sep, "")) from None
    return [float(value) for value in proposed.data["setup"]["origin"]]
