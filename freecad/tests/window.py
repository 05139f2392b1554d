"""The window: task panel, planning beside it, check and pictures. Run under Xvfb: freecad tests/window.py

TRUNNION_SHOTS names a folder for screenshots.
"""

from __future__ import annotations

import os
import sys
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
os.environ["TRUNNION_QUIET"] = "1"
import models  # noqa: E402

import FreeCAD  # noqa: E402
import FreeCADGui  # noqa: E402
from PySide import QtCore, QtGui  # noqa: E402

from trunnion_cam import operation  # noqa: E402
from trunnion_cam.gui import commands, panels, running  # noqa: E402

SHOTS = os.environ.get("TRUNNION_SHOTS")
longest = [0.0, time.monotonic()]


def beat() -> None:
    """Notes how long the window was not served."""
    now = time.monotonic()
    longest[0], longest[1] = max(longest[0], now - longest[1]), now


def serve(seconds: float, until=lambda: False) -> None:
    """Serves the window for a time, or until something holds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end and not until():
        QtGui.QApplication.processEvents()
        time.sleep(0.005)


def shot(name: str) -> None:
    """Keeps a screenshot."""
    if SHOTS:
        serve(0.3)
        FreeCADGui.getMainWindow().grab().save(os.path.join(SHOTS, name + ".png"))
        # A picture of the window leaves the view in space blank.
        FreeCADGui.ActiveDocument.ActiveView.saveImage(os.path.join(SHOTS, name + "-view.png"), 900, 600, "White")


def main() -> None:
    window = FreeCADGui.getMainWindow()
    window.resize(1280, 800)
    window.show()
    for name in commands.register():
        assert FreeCADGui.Command.get(name) is not None, name
    shape, faces = models.plate()
    job, body = models.document(shape, "endmill", 12.0)
    FreeCADGui.ActiveDocument.ActiveView.viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    # Nothing selected: words, and nothing is added.
    count = len(job.Document.Objects)
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.runCommand("Trunnion_Finish")
    assert len(job.Document.Objects) == count
    # Two clicks: the face, the command.
    FreeCADGui.Selection.addSelection(body, faces)
    FreeCADGui.runCommand("Trunnion_Finish")
    obj = next(one for one in job.Document.Objects if hasattr(one, "InputKey"))
    shot("1-panel")
    FreeCADGui.Control.closeDialog()
    panel = panels.OperationPanel(obj, True)
    FreeCADGui.Control.showDialog(panel)
    panel.along.setCurrentText("v")
    timer = QtCore.QTimer()
    timer.timeout.connect(beat)
    timer.start(10)
    beat()
    longest[0] = 0.0
    begun = time.monotonic()
    panel.preview.click()
    serve(300, lambda: not running.busy())
    assert obj.Kept, obj.Verdict
    print(f"passes on screen {time.monotonic() - begun:.1f} s after the click")
    serve(0.5)
    assert "kept" in panel.message.text(), panel.message.text()
    shot("2-preview")
    assert panel.accept()
    serve(0.5)
    print(f"the window was never left alone for more than {1000 * longest[0]:.0f} ms")
    key = obj.InputKey
    # A lowered block is found, and a click shows its line.
    found = []
    shown = panels.show_check
    panels.show_check = lambda *args: found.append(shown(*args)) or found[-1]
    commands.panels.show_check = panels.show_check
    import Path

    moves = obj.Path.Commands
    cuts = [index for index, one in enumerate(moves) if one.Name == "G1" and "Z" in one.Parameters]
    middle = cuts[len(cuts) // 2]
    moves[middle] = Path.Command("G1", {**moves[middle].Parameters, "Z": moves[middle].Parameters["Z"] - 0.4})
    obj.Path = Path.Path(moves)
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.runCommand("Trunnion_Check")
    serve(300, lambda: bool(found))
    check = found[0]
    assert not check.found.passed
    check.list.setCurrentRow(0)
    serve(0.3)
    line = check.program.textCursor().selectedText()
    assert line.startswith("G1"), line
    assert [one.Name for one in FreeCADGui.Selection.getSelection()] == [obj.Name]
    shot("3-problems")
    check.reject()
    assert job.Document.getObject("TrunnionMark") is None
    # Work that is stopped changes nothing.
    obj.Excess = 0.04
    assert obj.InputKey == key
    running.plan(obj, operation.inputs(obj))
    running.stop_all()
    serve(120, lambda: not running.busy())
    assert "stopped" in obj.Verdict or obj.Kept, obj.Verdict
    print("ALL PASSED")


def guarded() -> None:
    status = 0
    try:
        main()
    except BaseException:  # The verdict has to reach the shell.
        traceback.print_exc()
        print("FAILED")
        status = 1
    sys.stdout.flush()
    os._exit(status)


QtCore.QTimer.singleShot(500, guarded)
