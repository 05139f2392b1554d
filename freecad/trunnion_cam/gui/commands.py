"""Commands of menu and toolbar."""

from __future__ import annotations

import os
import tempfile
from typing import Any, Callable

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .. import checking, compat, machines, operation, posting, searching, shapes
from ..problem import Problem
from ..translate import marked, translated
from . import panels, running, views


def tell(problem: Exception) -> None:
    """Shows a problem in the report view and in a message."""
    FreeCAD.Console.PrintError(f"trunnion: {problem}\n")
    if not os.environ.get("TRUNNION_QUIET"):
        QtGui.QMessageBox.warning(FreeCADGui.getMainWindow(), "trunnion", str(problem))


class _Command:
    """A command that shows problems in words and leaves the document as it was."""

    def __init__(self, title: str, text: str, icon: str, action: Callable[[], None]) -> None:
        self.title, self.text, self.icon, self.action = title, text, icon, action

    def GetResources(self) -> dict[str, str]:
        return {"MenuText": translated(self.title), "ToolTip": translated(self.text), "Pixmap": views.icon(self.icon)}

    def IsActive(self) -> bool:
        return FreeCAD.ActiveDocument is not None

    def Activated(self) -> None:
        try:
            self.action()
        except Problem as problem:
            tell(problem)


def chosen_job(body: Any = None) -> Any:
    """Returns the selected job, that of a selected operation, the only one of the document, or the only one with a body."""
    document = FreeCAD.ActiveDocument
    for thing in FreeCADGui.Selection.getSelection():
        if compat.is_job(thing):
            return thing
    jobs = [thing for thing in document.Objects if compat.is_job(thing)]
    for thing in FreeCADGui.Selection.getSelection():
        owners = [job for job in jobs if any(one.Name == thing.Name for one in compat.operations(job))]
        if owners:
            return owners[0]
    if len(jobs) > 1 and body is not None:
        jobs = [job for job in jobs if body in compat.models(job)] or jobs
    if len(jobs) == 1:
        return jobs[0]
    if not jobs:
        raise Problem(translated("the document has no job"), translated("create one with the CAM workbench: Job"))
    labels = ", ".join(job.Label for job in jobs)
    raise Problem(translated("the document has {count} jobs: {labels}", count=len(jobs), labels=labels), translated("select one of them"))


def chosen_operation() -> Any:
    """Returns the selected five-axis finish, or the only one of the document."""
    for thing in FreeCADGui.Selection.getSelection():
        if hasattr(thing, "InputKey"):
            return thing
    found = [thing for thing in FreeCAD.ActiveDocument.Objects if hasattr(thing, "InputKey")]
    if not found:
        raise Problem(translated("the document has no five-axis finish"), translated("select faces, and make one with Five-axis finish"))
    if len(found) > 1:
        labels = ", ".join(one.Label for one in found)
        raise Problem(
            translated("the document has {count} five-axis operations: {labels}", count=len(found), labels=labels), translated("select one of them")
        )
    return found[0]


def finish() -> None:
    """Five-axis finish of the selected faces."""
    selection = [(one.Object, one.SubElementNames) for one in FreeCADGui.Selection.getSelectionEx()]
    body, faces = shapes.selected_faces([(thing, names) for thing, names in selection if not compat.is_job(thing)])
    job = chosen_job(body)
    panels.need_room()
    document = job.Document
    document.openTransaction(translated("Five-axis finish"))
    try:
        if machines.machine_of(job) is None:
            machines.create(job).Origin = FreeCAD.Vector(*searching.quick_origin(job, "bc-trunnion"))
        created = operation.create(job, body, faces)
    except Problem:
        document.abortTransaction()
        raise
    panels.show_operation(created)


def check_job() -> None:
    """Checks the program of the whole job."""
    job = chosen_job()
    asked = checking.question(job)

    def done(found: checking.JobCheck) -> None:
        panels.show_check(job, found)

    title = translated("check of {label}", label=job.Label)
    running.Running(title, lambda report: checking.answer(asked, report), done, lambda text: tell(Problem(text)))


def machine() -> None:
    """Chooses the machine of a job."""
    panels.show_machine(chosen_job())


def post() -> None:
    """Writes the program of a job."""
    job = chosen_job()
    names = list(posting.DIALECTS)
    window = FreeCADGui.getMainWindow()
    dialect, accepted = QtGui.QInputDialog.getItem(window, "trunnion", translated("Dialect"), names, 0, False)
    if not accepted:
        return
    asked = posting.question(job, dialect)

    def done(text: str) -> None:
        path, _ = QtGui.QFileDialog.getSaveFileName(window, translated("Program"), job.Label + posting.DIALECTS[dialect])
        if not path:
            return
        try:
            posting.write(path, text)
        except OSError as error:
            tell(Problem(translated("{path} cannot be written: {error}", path=path, error=error)))
            return
        FreeCAD.Console.PrintMessage(translated("wrote {path}", path=path) + "\n")

    if isinstance(asked, str):
        done(asked)
        return
    title = translated("post of {label}", label=job.Label)
    running.Running(title, lambda report: posting.answer(asked, progress=report), done, lambda text: tell(Problem(text)))


def simulate() -> None:
    """Opens the report page of an operation."""
    obj = chosen_operation()
    found = operation.inputs(obj)
    folder = tempfile.mkdtemp(prefix="trunnion-")

    def done(page: str) -> None:
        QtGui.QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(page))

    running.Running(obj.Label, lambda report: searching.simulate(found, folder, report), done, lambda text: tell(Problem(text)))


def best_setup() -> None:
    """Searches the rotation of the workpiece."""
    obj = chosen_operation()
    found = operation.inputs(obj)
    target = machines.needed_machine(obj.Job)

    def done(summary: dict[str, Any]) -> None:
        panels.show_setups(target, summary)

    running.Running(translated("best setup"), lambda report: searching.best_setup(found, report), done, lambda text: tell(Problem(text)))


def compare() -> None:
    """Compares an operation over other tools, tolerances or machines."""
    panels.show_comparison(chosen_operation())


def install_post() -> None:
    """Lets FreeCAD's own Post Process find the post processor `trunnion`."""
    path = posting.install_post_processor(FreeCAD.getUserMacroDir(True))
    FreeCAD.Console.PrintMessage(translated("wrote {path}: the job's post processor may now be `trunnion`", path=path) + "\n")


COMMANDS = [
    ("Trunnion_Finish", marked("Five-axis finish"), marked("Finish the selected faces with five axes"), "finish", finish),
    ("Trunnion_Check", marked("Check this job"), marked("Check the program of the job against part, machine, stock and fixtures"), "check", check_job),
    ("Trunnion_Machine", marked("Machine"), marked("Choose the machine of the job, and where the part stands on it"), "machine", machine),
    ("Trunnion_Post", marked("Post with trunnion"), marked("Write the program of the job in one of ten dialects"), "post", post),
    ("Trunnion_Simulate", marked("Simulate"), marked("Play the program of the operation in the browser"), "simulate", simulate),
    ("Trunnion_Setup", marked("Best setup"), marked("Search the rotation of the part that suits the machine best"), "setup", best_setup),
    ("Trunnion_Compare", marked("Compare"), marked("Compare tools, tolerances or machines"), "compare", compare),
    ("Trunnion_InstallPost", marked("Install post processor"), marked("Make trunnion a post processor of FreeCAD's own Post Process"), "post", install_post),
]


def register() -> list[str]:
    """Adds the commands to FreeCAD, and returns their names."""
    for name, title, text, icon, action in COMMANDS:
        FreeCADGui.addCommand(name, _Command(title, text, icon, action))
    return [name for name, *_ in COMMANDS]
