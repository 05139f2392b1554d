"""The window: task panel, planning beside it, check and pictures. Run under Xvfb: freecad tests/window.py

TRUNNION_SHOTS names a folder for screenshots.
"""

from __future__ import annotations

import math
import os
import re
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
os.environ["TRUNNION_QUIET"] = "1"
import models  # noqa: E402

import FreeCAD  # noqa: E402
import FreeCADGui  # noqa: E402
from PySide import QtCore, QtGui  # noqa: E402
from screen import run_in_window, serve, shot  # noqa: E402

from trunnion_cam import checking, colours, compat, operation, postprocessor  # noqa: E402
from trunnion_cam.engine import engine  # noqa: E402
from trunnion_cam.gui import commands, panels, running, views  # noqa: E402
from trunnion_cam.translate import translated  # noqa: E402

longest = [0.0, time.monotonic()]


def beat() -> None:
    """Notes how long the window was not served."""
    now = time.monotonic()
    longest[0], longest[1] = max(longest[0], now - longest[1]), now


def wait(until, seconds: float = 300.0) -> None:
    """Serves the window until something holds, which has to happen."""
    serve(seconds, until)
    assert until()


def planned(obj) -> None:
    """Waits for the planning of an operation."""
    wait(lambda: not running.busy())
    serve(0.2)


def names(document) -> list[str]:
    """Names of all objects of a document."""
    return sorted(one.Name for one in document.Objects)


class Watch:
    """Measures how long the window is not served."""

    def __init__(self) -> None:
        self.timer = QtCore.QTimer()
        self.timer.timeout.connect(beat)
        self.timer.start(10)
        longest[0], longest[1] = 0.0, time.monotonic()

    def longest(self) -> float:
        """Returns the longest time since the last question [ms], and begins anew."""
        found, longest[0], longest[1] = 1000.0 * longest[0], 0.0, time.monotonic()
        return found


def click_finish(body, faces) -> tuple[object, object]:
    """Two clicks: the faces, the command; returns the operation and its panel."""
    shown = []
    show = panels.show_operation
    panels.show_operation = lambda obj: shown.append(show(obj)) or shown[-1]
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(body, faces)
    FreeCADGui.runCommand("Trunnion_Finish")
    panels.show_operation = show
    return shown[0].obj, shown[0]


def test_refusals(job) -> None:
    """Nothing selected, a mesh, a sketch, two bodies: words, and nothing is added."""
    document = job.Document
    mesh, sketch = document.addObject("Mesh::Feature", "M"), document.addObject("Sketcher::SketchObject", "S")
    other = document.addObject("Part::Box", "Other")
    document.recompute()
    before = names(document)
    told = []
    tell, commands.tell = commands.tell, lambda problem: told.append(str(problem))
    body = document.getObject("Body")
    for chosen in ([], [(mesh, "")], [(sketch, "")], [(body, "Face1"), (other, "Face1")]):
        FreeCADGui.Selection.clearSelection()
        for thing, face in chosen:
            FreeCADGui.Selection.addSelection(thing, face)
        FreeCADGui.runCommand("Trunnion_Finish")
    commands.tell = tell
    for text, word in zip(told, ("nothing is selected", "is a mesh", "is a sketch", "2 bodies"), strict=True):
        assert word in text, text
    assert names(document) == before
    assert not document.HasPendingTransaction
    for thing in (mesh, sketch, other):
        document.removeObject(thing.Name)


def test_finish(job, body, faces) -> object:
    """Preview, cancel, OK, undo; returns the operation."""
    document = job.Document
    document.recompute()
    before = names(document)
    watch = Watch()
    obj, panel = click_finish(body, faces)
    shot("1-panel")
    panel.along.choose("v")
    watch.longest()
    panel.preview.click()
    planned(obj)
    assert obj.Kept, obj.Verdict
    assert "kept" in panel.message.text(), panel.message.text()
    assert "gouge" in panel.legend.text()
    assert len(obj.Pictures) == 2
    # Cancel takes a new operation away, whatever was previewed.
    panel.reject()
    serve(0.2)
    assert names(document) == before, set(names(document)) ^ set(before)
    assert [one.Name for one in compat.operations(job)] == []
    watch.longest()
    obj, panel = click_finish(body, faces)
    panel.along.choose("v")
    panel.preview.click()
    wait(lambda: not running.busy())
    serve(0.5)
    blocked = watch.longest()
    shot("2-preview")
    watch.longest()
    assert panel.accept()
    planned(obj)
    print(f"the window was never left alone for more than {max(blocked, watch.longest()):.0f} ms")
    # One step of undo takes it away, one of redo brings it back with everything.
    document.undo()
    assert names(document) == before, set(names(document)) ^ set(before)
    document.redo()
    obj = compat.operations(job)[0]
    assert obj.Kept and len(obj.Path.Commands) > 10 and len(obj.Pictures) == 2
    # Nothing has changed: a recompute plans nothing.
    obj.touch()
    document.recompute()
    assert not running.busy()
    return obj


def test_legend(obj) -> None:
    """The legend has a plate of its own, and can be read over any background."""
    deviation = obj.Pictures[1]
    plate = views.legend_plate(deviation.Label, 0.02, 0.002)
    shades = {plate.pixelColor(2 * x, 2 * y).name() for x in range(plate.width() // 2) for y in range(plate.height() // 2)}
    wanted = {colours.hexadecimal(shade) for shade, _ in views.entries(0.02, 0.002)}
    assert wanted < shades, wanted - shades
    with tempfile.TemporaryDirectory() as folder:
        for background in ("Black", "White"):
            path = os.path.join(folder, background + ".png")
            FreeCADGui.ActiveDocument.ActiveView.saveImage(path, 900, 650, background)
            picture = QtGui.QImage(path)
            # Within the corner of the plate; its upper left corner is 13 pixels from those of the picture.
            assert picture.pixelColor(16, 16).name() == plate.pixelColor(3, 3).name(), picture.pixelColor(16, 16).name()
            found = {picture.pixelColor(2 * x, 2 * y).name() for x in range(8, 120) for y in range(8, 95)}
            assert wanted < found, (background, wanted - found)


def test_settings(obj) -> None:
    """Cancel of a changed operation brings the old result back; a length without sense is refused."""
    key, text = obj.InputKey, obj.Path.toGCode()
    panel = panels.show_operation(obj)
    panel.excess.setText("much")
    assert not panel.accept()
    assert "is no length" in panel.message.text()
    panel.excess.setText("0.05 mm")
    panel.feed.setText("fast")
    assert not panel.accept()
    assert "is no feed" in panel.message.text()
    panel.feed.setText("2400 mm/min")
    panel.preview.click()
    planned(obj)
    assert abs(float(obj.Excess.Value) - 0.05) < 1e-9 and obj.InputKey != key
    assert abs(float(obj.ToolController.HorizFeed) - 40.0) < 1e-9
    panel.reject()
    serve(0.2)
    assert not running.busy()
    assert (obj.InputKey, obj.Path.toGCode()) == (key, text)
    assert abs(float(obj.Excess.Value) - 0.02) < 1e-9
    assert abs(float(obj.ToolController.HorizFeed) - 50.0) < 1e-9


def test_check(job, obj) -> None:
    """A lowered block is found, and a click shows its line, its place and its move."""
    import Path

    document = job.Document
    found = []
    show, panels.show_check = panels.show_check, lambda *args: found.append(show(*args)) or found[-1]
    moves = obj.Path.Commands
    cuts = [index for index, one in enumerate(moves) if one.Name == "G1" and "Z" in one.Parameters]
    middle = cuts[len(cuts) // 2]
    moves[middle] = Path.Command("G1", {**moves[middle].Parameters, "Z": moves[middle].Parameters["Z"] - 0.4})
    obj.Path = Path.Path(moves)
    FreeCADGui.Selection.clearSelection()
    watch = Watch()
    FreeCADGui.runCommand("Trunnion_Check")
    wait(lambda: bool(found))
    panels.show_check = show
    check = found[0]
    print(f"the window was never left alone for more than {watch.longest():.0f} ms while a job was checked")
    assert not check.found.passed
    assert "gouge" in check.legend.text()
    meshes = [one for one in document.Objects if one.Name.startswith(f"{job.Name}CheckedDeviation")]
    assert len(meshes) == 1
    # One end of a block is 0.4 mm too deep: on the way there the top is deeper and deeper.
    corners = zip(meshes[0].Height, meshes[0].Mesh.Topology[0])
    top = [height for height, at in corners if at.z > 7.999 and abs(at.x) < 18 and abs(at.y) < 13 and math.isfinite(height)]
    assert -0.45 < min(top) < -0.25, min(top)
    assert meshes[0].ViewObject.Coloring and meshes[0].ViewObject.Proxy.legend.whichChild.getValue() == 0
    check.list.setCurrentRow(0)
    serve(0.3)
    line = check.program.textCursor().selectedText()
    assert line.startswith("G1"), line
    assert [one.Name for one in FreeCADGui.Selection.getSelection()] == [obj.Name]
    mark = document.getObject("TrunnionMark")
    assert len(mark.Shape.Solids) == 1 and len(mark.Shape.Edges) > len(mark.Shape.Solids[0].Edges)
    shot("3-problems")
    check.reject()
    assert document.getObject("TrunnionMark") is None
    # The mesh goes with its eye, and so does the legend.
    meshes[0].ViewObject.Visibility = False
    assert meshes[0].ViewObject.Proxy.legend.whichChild.getValue() == -1
    obj.InputKey = ""
    obj.touch()
    document.recompute()
    planned(obj)
    assert obj.Kept, obj.Verdict


def test_machine(job, obj) -> None:
    """Dynamics by class, a file of FreeCAD, an origin, fixtures; operations are planned anew."""
    document = job.Document
    panel = panels.show_machine(job)
    panel.kind.choose("hobby")
    assert [box.value() for box in panel.dynamics] == [500.0, 5000.0, 200.0, 2000.0]
    panel.dynamics[0].setValue(750.0)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "trunnion.fcm")
        with open(path, "w", encoding="utf-8") as file:
            file.write(models.fcm())
        panel.use_file(path)
        assert "wrote" in panel.message.text(), panel.message.text()
        with open(path.replace(".fcm", ".toml"), encoding="utf-8") as file:
            assert "acc = 750" in file.read()
        shot("4-machine")
        with open(path, "w", encoding="utf-8") as file:
            file.write("{}")
        panel.use_file(path)
        assert "has no axes" in panel.message.text()
    panel.machine.setCurrentText("no-such-machine")
    assert not panel.accept()
    assert "no-such-machine" in panel.message.text()
    panel.machine.setCurrentText("ac-trunnion")
    panel.propose()
    wait(lambda: not running.busy())
    assert [field.text() for field in panel.origin[:2]] == ["0 mm", "0 mm"], [field.text() for field in panel.origin]
    panel.machine.setCurrentText("bc-trunnion")
    for field, value in zip(panel.origin, ("-381 mm", "-254 mm", "-515 mm")):
        field.setText(value)
    clamp = document.addObject("Part::Box", "Clamp")
    clamp.Length, clamp.Width, clamp.Height = 4.0, 4.0, 3.0
    clamp.Placement.Base = FreeCAD.Vector(-40, -2, 0)
    document.recompute()
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(clamp)
    panel.take_fixtures()
    key = obj.InputKey
    assert panel.accept()
    wait(lambda: running.busy(), 10.0)
    planned(obj)
    assert obj.Kept and obj.InputKey != key, obj.Verdict
    # A fixture that moves plans anew, too.
    key = obj.InputKey
    clamp.Placement.Base = FreeCAD.Vector(-42, -2, 0)
    document.recompute()
    planned(obj)
    assert obj.Kept and obj.InputKey != key, obj.Verdict


def test_searches(job, obj) -> None:
    """Best setup, comparison and simulation open what they found, and change nothing."""
    key = obj.InputKey
    panel = panels.show_comparison(obj)
    panel.values.setText("0.02, 0.04, x")
    panel.name.choose("tolerance")
    panel.values.setText("0.02, x")
    panel.start.click()
    assert "commas" in panel.message.text()
    panel.values.setText("0.02, 0.04")
    panel.start.click()
    wait(lambda: not running.busy())
    assert panel.table.rowCount() == 2, panel.message.text()
    assert panel.table.item(0, 1).text() == "yes"
    shot("5-compare")
    panel.reject()
    found = []
    show, panels.show_setups = panels.show_setups, lambda *args: found.append(show(*args)) or found[-1]
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.runCommand("Trunnion_Setup")
    wait(lambda: bool(found))
    panels.show_setups = show
    shot("6-setup")
    found[0].reject()
    pages = []
    open_page, QtGui.QDesktopServices.openUrl = QtGui.QDesktopServices.openUrl, lambda page: pages.append(page.toLocalFile())
    FreeCADGui.runCommand("Trunnion_Simulate")
    wait(lambda: bool(pages))
    QtGui.QDesktopServices.openUrl = open_page
    assert os.path.getsize(pages[0]) > 500_000
    obj.touch()
    job.Document.recompute()
    assert not running.busy() and obj.InputKey == key


def visible(widget) -> list[str]:
    """Returns all texts of a widget and of what is in it."""
    found = []
    for one in [widget, *widget.findChildren(QtGui.QWidget)]:
        found += [one.windowTitle(), one.toolTip()]
        if isinstance(one, (QtGui.QLabel, QtGui.QAbstractButton)):
            found.append(one.text())
        if isinstance(one, QtGui.QComboBox):
            found += [one.itemText(index) for index in range(one.count())]
        if isinstance(one, QtGui.QTabBar):
            found += [one.tabText(index) for index in range(one.count())]
        if isinstance(one, QtGui.QTableWidget):
            found += [one.horizontalHeaderItem(column).text() for column in range(one.columnCount())]
            found += [one.item(row, column).text() for row in range(one.rowCount()) for column in range(one.columnCount())]
    return [text for text in found if re.search("[A-Za-z]{2}", text)]


def test_texts(job, obj) -> None:
    """Every text of every panel and command goes through the translation."""
    translate, FreeCAD.Qt.translate = FreeCAD.Qt.translate, lambda context, text, *more: f"\u27e6{text}\u27e7"
    asked = checking.question(job)
    summary = {"rotation": [1.0, 2.0, 3.0], "least_angle": 4.0, "fits": True}
    shown = []
    try:
        table = panels.ComparisonPanel(obj)
        table.show_table("machine", [{"machine": "bc-trunnion", "passed": False, "duration": 1.0, "passes": 3, "message": ""}])
        setups = panels.SetupPanel(obj.Machine, {"before": summary, "after": None})
        forms = [panels.OperationPanel(obj), panels.MachinePanel(job), panels.CheckPanel(job, checking.answer(asked)), table, setups]
        forms[0].show_preview()
        forms[0]._shown("")
        forms[1].take_fixtures()
        for panel in forms:
            shown += visible(panel.form)
        for name, *_ in commands.COMMANDS:
            resources = commands._Command(*next(one[1:] for one in commands.COMMANDS if one[0] == name)).GetResources()
            shown += [resources["MenuText"], resources["ToolTip"]]
        shown += [text for _, text in views.entries(0.02, 0.002)]
    finally:
        FreeCAD.Qt.translate = translate
    # Names of the document and of machines, and what the engine says, stay as they are.
    same = {f"{obj.Base[0].Label}: {', '.join(obj.Base[1])}", *(one.Label for one in compat.controllers(job)), "Clamp", obj.Verdict}
    same |= {*engine().built_in(), obj.Machine.Machine}
    left = [text for text in shown if "\u27e6" not in text and text not in same]
    assert not left, left
    assert len(shown) > 80, len(shown)


def test_german(job, obj) -> None:
    """The window speaks German, and so do the panels and the descriptions of properties."""
    FreeCADGui.addLanguagePath(os.path.join(models.FOLDER, "translations"))
    FreeCADGui.setLocale("German")
    try:
        assert translated("Five-axis finish") == "F\u00fcnfachsig schlichten"
        assert FreeCAD.Qt.translate("App::Property", "Setup sheet") == "Einrichteblatt"
        panel = panels.show_operation(obj)
        assert "Verfahren" in visible(panel.form)
        shot("7-german")
        panel.reject()
    finally:
        FreeCADGui.setLocale("English")
    assert translated("Five-axis finish") == "Five-axis finish"


def test_first_passes() -> None:
    """Passes of the example patch are on screen while it is planned; at the end, or stopped, nothing of them stays."""
    shape, faces = models.patch()
    job, body = models.document(shape, "ballend", 16.0)
    scene = FreeCADGui.ActiveDocument.ActiveView.getSceneGraph()
    FreeCADGui.ActiveDocument.ActiveView.viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    obj, panel = click_finish(body, faces)
    before, watch = scene.getNumChildren(), Watch()
    begun = time.monotonic()
    panel.preview.click()
    wait(lambda: running.previewed() > 0)
    print(f"first passes of the example patch on screen {time.monotonic() - begun:.1f} s after the click")
    first = running.previewed()
    wait(lambda: running.previewed() > first)
    shot("9-first-passes")
    assert running.busy() and scene.getNumChildren() == before + 1
    running.stop_all()
    planned(obj)
    assert scene.getNumChildren() == before
    print(f"while they came the window was never left alone for more than {watch.longest():.0f} ms")
    panel.reject()
    FreeCAD.closeDocument(job.Document.Name)


def test_stop(job, obj) -> None:
    """Work that is stopped leaves no program of another model, and is planned with the next recompute."""
    key = obj.InputKey
    obj.Excess = 0.04
    running.plan(obj, operation.inputs(obj))
    running.stop_all()
    planned(obj)
    assert "stopped" in obj.Verdict and not obj.Path.Commands, obj.Verdict
    obj.Excess = 0.02
    job.Document.recompute()
    planned(obj)
    assert obj.Kept and obj.InputKey == key


def test_post(job) -> None:
    """The post processor of FreeCAD shows problems in words, and returns nothing."""
    told = []
    tell, commands.tell = commands.tell, lambda problem: told.append(str(problem))
    assert postprocessor.export(compat.operations(job), "-", "--dialect=nothing") is None
    commands.tell = tell
    assert "there is no dialect" in told[0]
    assert postprocessor.export(compat.operations(job), "-", "--dialect=linuxcnc")


def test_reload(job, obj) -> None:
    """Saved and opened again: views, legend, panel and result are there, and nothing is planned."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "job.FCStd")
        job.Document.saveAs(path)
        name, key = obj.Name, obj.InputKey
        FreeCAD.closeDocument(job.Document.Name)
        document = FreeCAD.openDocument(path)
        obj = document.getObject(name)
        assert obj.ViewObject.Proxy.claimChildren() == obj.Pictures
        picture = obj.Pictures[1]
        assert picture.ViewObject.Coloring and picture.ViewObject.Proxy.legend.whichChild.getValue() == 0
        obj.touch()
        document.recompute()
        assert not running.busy() and obj.InputKey == key
        obj.ViewObject.Proxy.doubleClicked(obj.ViewObject)
        assert FreeCADGui.Control.activeDialog()
        FreeCADGui.Control.closeDialog()
        # Deleted, it takes its pictures with it.
        pictures = [one.Name for one in obj.Pictures]
        FreeCADGui.Selection.clearSelection()
        FreeCADGui.Selection.addSelection(obj)
        obj.ViewObject.Proxy.onDelete(obj.ViewObject, ())
        document.removeObject(name)
        assert not any(document.getObject(one) for one in pictures)
        FreeCAD.closeDocument(document.Name)


def main() -> None:
    window = FreeCADGui.getMainWindow()
    window.resize(1280, 800)
    window.show()
    for name in commands.register():
        assert FreeCADGui.Command.get(name) is not None, name
    shape, faces = models.plate()
    job, body = models.document(shape, "endmill", 12.0)
    job.Document.UndoMode = 1
    FreeCADGui.ActiveDocument.ActiveView.viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    test_refusals(job)
    obj = test_finish(job, body, faces)
    test_legend(obj)
    test_settings(obj)
    test_check(job, obj)
    test_machine(job, obj)
    test_searches(job, obj)
    test_texts(job, obj)
    test_german(job, obj)
    test_stop(job, obj)
    test_post(job)
    test_reload(job, obj)
    test_first_passes()
    print("ALL PASSED")


run_in_window(main)
