"""Programs of a job in the engine's dialects."""

from __future__ import annotations

import os
from typing import Any

from . import checking, compat, machines
from .engine import engine
from .problem import Problem, words

DIALECTS = {
    "linuxcnc": ".ngc", "g93": ".g93.nc", "fanuc": ".nc", "fanuc-vector": ".nc", "haas": ".nc", "siemens": ".mpf",
    "siemens-axes": ".mpf", "heidenhain": ".h", "heidenhain-axes": ".h", "apt": ".cls",
}


def own_program(job: Any, dialect: str) -> str | None:
    """Returns the checked program of a job whose only active operation is a five-axis finish; else None."""
    active = [one for one in map(compat.base_operation, compat.operations(job)) if getattr(one, "Active", True)]
    if len(active) != 1 or not hasattr(active[0], "InputKey"):
        return None
    operation = active[0]
    if not operation.Programs:
        raise Problem(f"{operation.Label} has no program: {operation.Verdict}", "recompute it first")
    wanted = f"program.{dialect}."
    return next((text for name, text in operation.Programs.items() if name.startswith(wanted)), None)


def post(job: Any, dialect: str, tolerance: tuple[float, float] = (0.005, 0.02)) -> str:
    """Returns the program of a job in a dialect.

    A single five-axis finish comes with the program that its own check has seen. Everything else is posted: the program
    of all operations, with feeds that the axes can follow.
    """
    if dialect not in DIALECTS:
        raise Problem(f"there is no dialect {dialect!r}", "choose one of: " + ", ".join(DIALECTS))
    own = own_program(job, dialect)
    if own is not None:
        return own
    asked = checking.question(job)
    machine = machines.needed_machine(job)
    options: dict[str, Any] = {"origin": asked.options["origin"], "rotation": asked.options["rotation"], "deg": True}
    trunnion = engine()
    if len(asked.program.tools) > 1:
        raise Problem(
            f"the job has {len(asked.program.tools)} tools, and programs of several tools are not posted yet",
            "post the operations of each tool by themselves: switch the others off with Active",
        )
    options["tool_length"] = next(iter(asked.options["tool_length"].values()))
    try:
        found = trunnion.post(
            asked.program.text.encode(), machine.Machine, dialect=dialect, source_dialect="linuxcnc", tolerance=tolerance, **options
        )
    except trunnion.TrunnionError as error:
        raise Problem(words(error)) from None
    return found.text


def write(path: str, text: str) -> None:
    """Writes a program whole, or not at all."""
    beside = path + ".new"
    with open(beside, "w", encoding="utf-8", newline="") as file:
        file.write(text)
    os.replace(beside, path)


POST_PROCESSOR = '''"""Post processor of FreeCAD that calls trunnion; the arguments are the dialect, such as --dialect=heidenhain."""

TOOLTIP = "Posts with trunnion: ten dialects for five-axis machines"


def export(objects, filename, arguments=""):
    from trunnion_cam import postprocessor

    return postprocessor.export(objects, filename, arguments)
'''


def install_post_processor(folder: str) -> str:
    """Writes the post processor `trunnion` into a folder of macros, where FreeCAD looks for them."""
    path = os.path.join(folder, "trunnion_post.py")
    write(path, POST_PROCESSOR)
    return path
