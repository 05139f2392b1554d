"""The add-on as the Addon Manager leaves it, and a part that becomes a program, click by click.

Run under Xvfb with the add-on in `Mod/trunnion` of a fresh user folder: freecad tests/installed.py
TRUNNION_SHOTS names a folder for screenshots.
"""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import FreeCAD  # noqa: E402
import FreeCADGui  # noqa: E402
import Part  # noqa: E402
from PySide import QtCore, QtGui  # noqa: E402
from screen import run_in_window, serve, shot  # noqa: E402

#: What the user did with the mouse.
clicks: list[str] = []


def click(what: str) -> None:
    """Counts a click."""
    clicks.append(what)
    serve(0.2)


def choose_workbench(name: str) -> None:
    """Two clicks: the list of workbenches, and one of them."""
    click("list of workbenches")
    FreeCADGui.activateWorkbench(name)
    click(name)


def button(title: str) -> None:
    """Clicks a button of the task panel."""
    boxes = FreeCADGui.getMainWindow().findChildren(QtGui.QDialogButtonBox)
    found = [one for box in boxes if box.isVisible() for one in box.buttons() if one.text().replace("&", "") == title]
    assert len(found) == 1, [one.text() for one in found]
    click(title)
    found[0].click()
    serve(0.5)


def accept_dialog() -> None:
    """Clicks OK in the dialog that is open."""
    dialog = QtGui.QApplication.activeModalWidget()
    if dialog is None:
        QtCore.QTimer.singleShot(100, accept_dialog)
        return
    clicks.append("OK of the dialog")
    dialog.accept()


def main() -> None:
    window = FreeCADGui.getMainWindow()
    window.resize(1280, 800)
    window.show()
    assert "TrunnionWorkbench" in FreeCADGui.listWorkbenches()
    # "Metric, small parts & CNC": the CAM workbench warns of schemas with velocities per second.
    FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Units").SetInt("UserSchema", 6)
    FreeCAD.Units.setSchema(6)
    document = FreeCAD.newDocument("part")
    body = document.addObject("Part::Feature", "Body")
    body.Shape = Part.makeBox(40.0, 30.0, 8.0)
    document.recompute()
    FreeCADGui.ActiveDocument.ActiveView.viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    # A job of the CAM workbench.
    workbenches = FreeCADGui.listWorkbenches()
    choose_workbench("CAMWorkbench" if "CAMWorkbench" in workbenches else "PathWorkbench")
    QtCore.QTimer.singleShot(300, accept_dialog)
    click("Job")
    FreeCADGui.runCommand("CAM_Job" if "CAM_Job" in FreeCADGui.listCommands() else "Path_Job")
    serve(1.0)
    button("OK")
    # The face, the command.
    choose_workbench("TrunnionWorkbench")
    import trunnion_cam

    folder = os.path.join(FreeCAD.getUserAppDataDir(), "Mod", "trunnion")
    assert os.path.normpath(trunnion_cam.__file__).startswith(os.path.normpath(folder) + os.sep), trunnion_cam.__file__

    def bars() -> list:
        return [one for one in window.findChildren(QtGui.QToolBar) if one.windowTitle() == "trunnion"]

    # 1.1 makes toolbars when it comes to it.
    serve(10.0, lambda: bool(bars()))
    actions = [one for one in bars()[0].actions() if not one.isSeparator()]
    assert len(actions) == 8 and all(not one.icon().isNull() for one in actions), len(actions)
    shot("workbench")
    click("face")
    # What a click selects replaces what FreeCAD itself has left selected.
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(body, "Face6")
    click("Five-axis finish")
    # As a window manager would have it, which Xvfb lacks.
    QtGui.QApplication.setActiveWindow(window)
    FreeCADGui.runCommand("Trunnion_Finish")
    serve(0.5)
    # What the tool controller lacks is typed; the field has the keyboard already.
    field = QtGui.QApplication.focusWidget()
    assert isinstance(field, QtGui.QLineEdit), field
    fields = [one for one in window.findChildren(QtGui.QLineEdit) if one.isVisible() and one.text().endswith("mm/min")]
    assert fields == [field], (fields, field)
    field.setText("1200 mm/min")
    box = next(one for one in window.findChildren(QtGui.QDoubleSpinBox) if one.isVisible())
    box.setValue(8000.0)
    shot("panel")
    from trunnion_cam import checking, compat, machines
    from trunnion_cam.gui import running

    begun = time.monotonic()
    button("OK")
    serve(300.0, lambda: running.previewed() > 0 or not running.busy())
    print(f"from the last click to passes on screen {time.monotonic() - begun:.1f} s")
    serve(300.0, lambda: not running.busy())
    print(f"from the last click to the program {time.monotonic() - begun:.1f} s")
    job = next(one for one in document.Objects if compat.is_job(one))
    obj = compat.operations(job)[0]
    assert obj.Kept, obj.Verdict
    assert len(clicks) <= 10, clicks
    print(f"{len(clicks)} clicks: {', '.join(clicks)}")
    shot("program")
    assert machines.machine_of(job).Machine == "bc-trunnion"
    assert obj.Programs["program.linuxcnc.ngc"].count("\n") > 20
    found = checking.check(job)
    assert found.passed, found.problems
    test_post_processor(job, obj)
    print("ALL PASSED")


def choose_post_processor(job, path: str) -> None:
    """Chooses the post processor and its file in the panel of the job."""
    window = FreeCADGui.getMainWindow()
    FreeCADGui.ActiveDocument.setEdit(job.Name)
    serve(0.5)
    box = window.findChild(QtGui.QComboBox, "postProcessor")
    assert "trunnion" in [box.itemText(index) for index in range(box.count())]
    box.setCurrentIndex(box.findText("trunnion"))
    field = window.findChild(QtGui.QLineEdit, "postProcessorOutputFile")
    field.setText(path)
    field.editingFinished.emit()
    button("OK")
    assert (job.PostProcessor, job.PostProcessorOutputFile) == ("trunnion", path)


def test_post_processor(job, obj) -> None:
    """FreeCAD itself finds the post processor, once it is installed, and writes what was checked; a problem leaves the file as it is."""
    from trunnion_cam.gui import commands

    FreeCADGui.runCommand("Trunnion_InstallPost")
    program = obj.Programs["program.linuxcnc.ngc"]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "part.ngc")
        choose_post_processor(job, path)
        FreeCADGui.Selection.clearSelection()
        FreeCADGui.Selection.addSelection(job)
        post = "CAM_Post" if "CAM_Post" in FreeCADGui.listCommands() else "Path_Post"
        FreeCADGui.runCommand(post)
        with open(path, encoding="utf-8") as file:
            assert file.read() == program
        told = []
        tell, commands.tell = commands.tell, lambda problem: told.append(str(problem))
        job.PostProcessorArgs = "--dialect=nothing"
        FreeCADGui.runCommand(post)
        commands.tell = tell
        assert len(told) == 1 and "there is no dialect" in told[0], told
        assert os.listdir(folder) == ["part.ngc"]
        with open(path, encoding="utf-8") as file:
            assert file.read() == program
        assert not job.Document.HasPendingTransaction
    space = runpy.run_path(os.path.join(FreeCAD.getUserMacroDir(True), "trunnion_post.py"))
    assert space["export"]([obj], "-", "") == program
    assert "linuxcnc" in space["TOOLTIP_ARGS"]


run_in_window(main)
