"""`trunnion_post`: what FreeCAD's own Post Process calls."""

from __future__ import annotations

import shlex
from typing import Any

from . import compat, posting
from .problem import Problem
from .translate import translated


def export(objects: list[Any], filename: str, arguments: str = "") -> str | None:
    """Posts these operations of a job, writes the file unless its name is "-", and returns the text.

    In a window a problem is shown, and None returned: no file is written then. FreeCAD 0.20 closes its transaction;
    for 1.0 `compat.post_processor_class` sees to both.
    """
    import FreeCAD

    try:
        return _export(objects, filename, arguments)
    except Problem as problem:
        if not FreeCAD.GuiUp:
            raise
        from .gui import commands

        commands.tell(problem)
        return None


def _export(objects: list[Any], filename: str, arguments: str) -> str:
    dialect = "linuxcnc"
    for word in shlex.split(arguments or ""):
        name, _, value = word.partition("=")
        if name != "--dialect":
            raise Problem(translated("the post processor does not know '{word}'", word=word), translated("write --dialect=NAME"))
        dialect = value
    job, operations = _operations(objects)
    text = posting.post(job, dialect, operations)
    if filename and filename != "-":
        posting.write(filename, text)
    return text


def _operations(objects: list[Any]) -> tuple[Any, list[Any]]:
    """Returns a job, and its operations among objects; FreeCAD adds helpers of its own to the list."""
    names = [found.Name for found in map(compat.document_object, objects) if found is not None]
    document = next((found.Document for found in map(compat.document_object, objects) if found is not None), None)
    for job in document.Objects if document else []:
        chosen = [one for one in compat.operations(job) if one.Name in names] if compat.is_job(job) else []
        if chosen:
            return job, chosen
    raise Problem(translated("none of the objects is an operation of a job"), translated("post a job of the CAM workbench"))
