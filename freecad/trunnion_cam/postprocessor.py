"""`trunnion_post`: what FreeCAD's own Post Process calls."""

from __future__ import annotations

import shlex
from typing import Any

from . import compat, posting
from .problem import Problem


def export(objects: list[Any], filename: str, arguments: str = "") -> str:
    """Posts the job of these operations, writes the file unless its name is "-", and returns the text."""
    dialect = "linuxcnc"
    for word in shlex.split(arguments or ""):
        name, _, value = word.partition("=")
        if name != "--dialect":
            raise Problem(f"the post processor does not know {word!r}", "write --dialect=NAME")
        dialect = value
    job = _job_of(objects)
    text = posting.post(job, dialect)
    if filename and filename != "-":
        posting.write(filename, text)
    return text


def _job_of(objects: list[Any]) -> Any:
    """Returns the job that all operations belong to; FreeCAD adds helpers of its own to the list."""
    for thing in objects:
        document = getattr(thing, "Document", None)
        for job in document.Objects if document else []:
            if compat.is_job(job) and any(one.Name == thing.Name for one in compat.operations(job)):
                return job
    raise Problem("none of the objects is an operation of a job", "post a job of the CAM workbench")
