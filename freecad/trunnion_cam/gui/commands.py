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
from . import panels, running
from .translate import translated

_ICONS = os.path.join(os.path.dirname(__file__), "..", "..", "resources", "icons")


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
        icon = os.path.abspath(os.path.join(_ICONS, f"{self.icon}.svg"))
        return {"MenuText": translated(self.title), "ToolTip": translated(self.text), "Pixmap": icon}

    def IsActive(self) -> bool:
        return FreeCAD.ActiveDocument is not None

    def Activated(self) -> None:
        try:
            self.action()
        except Problem as problem:
            tell(problem)


def chosen_job() -> Any:
    """Returns the selected job, or that of a selected operation, or the only one of the document."""
    document = FreeCAD.ActiveDocument
    for thing in FreeCADGui.Selection.getSelection():
        if compat.is_job(thing):
            return thing
        if hasattr(thing, "InputKey") and thing.Job is not None:
            return thing.Job
    jobs = [thing for thing in document.Objects if compat.is_job(thing)]
    if len(jobs) == 1:
        return jobs[0]
    if not jobs:
        raise Problem("the document has no job", "create one with the CAM workbench: Job")
    labels = ", ".join(job.Label for job in jobs)
    raise Problem(f"the document has {len(jobs)} jobs: {labels}", "select one of them")


def chosen_operation() -> Any:
    """Returns the selected five-axis finish, or the only one of the document."""
    for thing in FreeCADGui.Selection.getSelection():
        if hasattr(thing, "InputKey"):
            return thing
    found = [thing for thing in FreeCAD.ActiveDocument.Objects if hasattr(thing, "InputKey")]
    if len(found) != 1:
        raise Problem(f"the document has {len(found)} five-axis operations", "select one of them")
    return found[0]


def finish() -> None:
    """Five-axis finish of the selected faces."""
    selection = [(one.Object, one.SubElementNames) for one in FreeCADGui.Selection.getSelectionEx()]
    body, faces = shapes.selected_faces([(thing, names) for thing, names in selection if not compat.is_job(thing)])
    job = chosen_job()
    document = job.Document
    document.openTransaction("Five-axis finish")
    if machines.machine_of(job) is None:
        machines.create(job)
    created = operation.create(job, body, faces)
    panels.show_operation(created, new=True)


def check_job() -> None:
    """Checks the program of the whole job."""
    job = chosen_job()
    asked = checking.question(job)

    def done(found: checking.JobCheck) -> None:
        panels.show_check(job, found)

    running.Running(f"check of {job.Label}", lambda report: checking.answer(asked, report), done, lambda text: tell(Problem(text)))


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
    text = posting.post(job, dialect)
    path, _ = QtGui.QFileDialog.getSaveFileName(window, translated("Program"), job.Label + posting.DIALECTS[dialect])
    if path:
        posting.write(path, text)
        FreeCAD.Console.PrintMessage(f"wrote {path}\n")


def simulate() -> None:
    """Opens the report page of an operation."""
    obj = chosen_operation()
    found = operation.inputs(_fresh(obj))
    folder = tempfile.mkdtemp(prefix="trunnion-")

    def done(page: str) -> None:
        QtGui.QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(page))

    running.Running(obj.Label, lambda report: searching.simulate(found, folder, report), done, lambda text: tell(Problem(text)))


def best_setup() -> None:
    """Searches the rotation of the workpiece."""
    obj = chosen_operation()
    found = operation.inputs(_fresh(obj))
    target = machines.needed_machine(obj.Job)

    def done(summary: dict[str, Any]) -> None:
        panels.show_setups(target, summary)

    running.Running("best setup", lambda report: searching.best_setup(found, report), done, lambda text: tell(Problem(text)))


def compare() -> None:
    """Compares an operation over other tools, tolerances or machines."""
    panels.show_comparison(chosen_operation())


def _fresh(obj: Any) -> Any:
    # The key of a computed operation would leave the part out.
    obj.InputKey = ""
    return obj


def install_post() -> None:
    """Lets FreeCAD's own Post Process find the post processor `trunnion`."""
    path = posting.install_post_processor(FreeCAD.getUserMacroDir(True))
    FreeCAD.Console.PrintMessage(f"wrote {path}: the job's post processor may now be `trunnion`\n")


COMMANDS = [
    ("Trunnion_Finish", "Five-axis finish", "Finish the selected faces with five axes", "finish", finish),
    ("Trunnion_Check", "Check this job", "Check the program of the job against part, machine, stock and fixtures", "check", check_job),
    ("Trunnion_Machine", "Machine", "Choose the machine of the job, and where the part stands on it", "machine", machine),
    ("Trunnion_Post", "Post with trunnion", "Write the program of the job in one of ten dialects", "post", post),
    ("Trunnion_Simulate", "Simulate", "Play the program of the operation in the browser", "simulate", simulate),
    ("Trunnion_Setup", "Best setup", "Search the rotation of the part that suits the machine best", "setup", best_setup),
    ("Trunnion_Compare", "Compare", "Compare tools, tolerances or machines", "compare", compare),
    ("Trunnion_InstallPost", "Install post processor", "Make trunnion a post processor of FreeCAD's own Post Process", "post", install_post),
]


def register() -> list[str]:
    """Adds the commands to FreeCAD, and returns their names."""
    for name, title, text, icon, action in COMMANDS:
        FreeCADGui.addCommand(name, _Command(title, text, icon, action))
    return [name for name, *_ in COMMANDS]
