"""Programs of a job in the engine's dialects."""

from __future__ import annotations

import os
from typing import Any, Callable, NamedTuple

from . import checking, compat, operation
from .engine import engine
from .problem import Problem, words
from .translate import translated

Progress = Callable[[str, int, int], None]

_POST_PROCESSOR = os.path.join(os.path.dirname(__file__), "..", "posts", "trunnion_post.py")

DIALECTS = {
    "linuxcnc": ".ngc", "g93": ".g93.nc", "fanuc": ".nc", "fanuc-vector": ".nc", "haas": ".nc", "siemens": ".mpf",
    "siemens-axes": ".mpf", "heidenhain": ".h", "heidenhain-axes": ".h", "apt": ".cls",
}


def own_program(operations: list[Any], dialect: str) -> str | None:
    """Returns the checked program of operations of which the only active one is a five-axis finish; else None."""
    active = [one for one in map(compat.base_operation, operations) if getattr(one, "Active", True)]
    if len(active) != 1 or not hasattr(active[0], "InputKey"):
        return None
    wanted = f"program.{dialect}."
    return next((text for name, text in active[0].Programs.items() if name.startswith(wanted)), None)


def post(job: Any, dialect: str, operations: list[Any] | None = None, tolerance: tuple[float, float] = (0.005, 0.02)) -> str:
    """Returns the program of a job, or of some of its operations, in a dialect.

    A single five-axis finish comes with the program that its own check has seen. Everything else is posted: one program
    of all operations with their tool changes, and with feeds that the axes can follow.

    Args:
        tolerance: largest deviation at the tip [mm] and of the tool axis [degrees].
    """
    asked = question(job, dialect, operations)
    return asked if isinstance(asked, str) else answer(asked, tolerance)


class Question(NamedTuple):
    """What is posted, taken from the document: posting itself runs beside the window."""

    setup: checking.Setup
    dialect: str


def question(job: Any, dialect: str, operations: list[Any] | None = None) -> str | Question:
    """Returns the program where it is there already, else what has to be posted."""
    if dialect not in DIALECTS:
        raise Problem(
            translated("there is no dialect '{dialect}'", dialect=dialect), translated("choose one of: {names}", names=", ".join(DIALECTS))
        )
    chosen = compat.operations(job) if operations is None else operations
    for one in checking.own_operations(chosen):
        if one.Programs and operation.key(one) != one.InputKey:
            # What has changed beside the document, a machine file or FreeCAD itself, marks nothing for a recompute.
            one.touch()
            raise Problem(
                translated("{label} is older than the model or its settings", label=one.Label), translated("recompute the document first")
            )
    own = own_program(chosen, dialect)
    return own if own is not None else Question(checking.setup(job, chosen), dialect)


def answer(asked: Question, tolerance: tuple[float, float] = (0.005, 0.02), progress: Progress | None = None) -> str:
    """Posts, and returns the program."""
    stands = asked.setup
    trunnion = engine()
    try:
        found = trunnion.post(
            stands.program.text.encode(),
            stands.machine,
            dialect=asked.dialect,
            source_dialect="linuxcnc",
            tolerance=tolerance,
            origin=stands.origin,
            rotation=stands.rotation,
            deg=True,
            tool_length=stands.lengths,
            progress=progress,
        )
    except trunnion.TrunnionError as error:
        raise Problem(words(error)) from None
    return str(found.text)


def write(path: str, text: str) -> None:
    """Writes a program whole, or not at all."""
    beside = path + ".new"
    with open(beside, "w", encoding="utf-8", newline="") as file:
        file.write(text)
    os.replace(beside, path)


def install_post_processor(folder: str) -> str:
    """Writes the post processor `trunnion` into a folder of macros, where FreeCAD looks for them."""
    path = os.path.join(folder, "trunnion_post.py")
    with open(_POST_PROCESSOR, encoding="utf-8") as file:
        write(path, file.read())
    return path
