"""Task panels: operation, machine, problems, setups, comparison."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .. import checking, compat, machines, operation, searching
from ..engine import engine
from ..problem import Problem
from . import running
from .translate import translated


def _length(value: float) -> Any:
    """A field for a length in the user's units."""
    field = FreeCADGui.UiLoader().createWidget("Gui::InputField")
    field.setText(FreeCAD.Units.Quantity(value, FreeCAD.Units.Length).UserString)
    return field


def _millimetres(field: Any) -> float:
    try:
        return float(FreeCAD.Units.Quantity(field.text()).getValueAs("mm"))
    except Exception:
        raise Problem(f"{field.text()!r} is no length", "write a number with a unit, such as 0.02 mm") from None


def _choice(values: list[str], chosen: str) -> Any:
    box = QtGui.QComboBox()
    box.addItems(values)
    box.setCurrentText(chosen)
    return box


class OperationPanel:
    """Settings of a five-axis finish, with a preview of its passes."""

    def __init__(self, obj: Any, new: bool) -> None:
        self.obj, self.new = obj, new
        self.controllers = compat.controllers(obj.Job)
        machine = machines.needed_machine(obj.Job)
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translated("Five-axis finish"))
        rows = QtGui.QFormLayout(self.form)
        thing, faces = obj.Base
        rows.addRow(translated("Faces"), QtGui.QLabel(f"{thing.Label}: {', '.join(faces)}"))
        self.machine = _choice(_machine_names(machine.Machine), machine.Machine)
        self.tool = _choice([one.Label for one in self.controllers], obj.ToolController.Label)
        self.length = _length(float(obj.ToolLength.Value))
        self.excess, self.gouge = _length(float(obj.Excess.Value)), _length(float(obj.Gouge.Value))
        self.method = _choice(operation.METHODS, str(obj.Method))
        self.along = _choice(operation.ALONG, str(obj.Along))
        self.flip = QtGui.QCheckBox(translated("cut the other side"))
        self.flip.setChecked(bool(obj.Flip))
        self.preview = QtGui.QPushButton(translated("Preview"))
        self.message = QtGui.QLabel(obj.Verdict)
        self.message.setWordWrap(True)
        self.message.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        for title, widget in (
            ("Machine", self.machine), ("Tool", self.tool), ("Length of the tool", self.length), ("Largest excess", self.excess),
            ("Deepest gouge", self.gouge), ("Method", self.method), ("Passes along", self.along), ("Side", self.flip),
        ):
            rows.addRow(translated(title), widget)
        rows.addRow(self.preview)
        rows.addRow(self.message)
        self.preview.clicked.connect(self.show_preview)

    def take(self) -> None:
        """Puts the settings into the operation."""
        obj = self.obj
        obj.ToolController = self.controllers[self.tool.currentIndex()]
        obj.ToolLength, obj.Excess, obj.Gouge = (_millimetres(field) for field in (self.length, self.excess, self.gouge))
        obj.Method, obj.Along = self.method.currentText(), self.along.currentText()
        obj.Flip = self.flip.isChecked()
        machines.create(obj.Job, self.machine.currentText())

    def show_preview(self) -> None:
        """Plans with the settings as they are; the panel stays open."""
        try:
            self.take()
            found = operation.inputs(self.obj)
        except Problem as problem:
            self.message.setText(str(problem))
            return
        if found.key == self.obj.InputKey:
            self.message.setText(self.obj.Verdict)
            return
        self.message.setText(translated("planning .."))
        running.plan(self.obj, found, lambda text: self._shown(text))

    def _shown(self, text: str) -> None:
        try:
            self.message.setText(text or f"{self.obj.Verdict}; {float(self.obj.Duration):.1f} s")
        except RuntimeError:
            # The panel was closed meanwhile.
            return

    def accept(self) -> bool:
        """OK: the settings stay, and the operation is computed if they have changed."""
        try:
            self.take()
        except Problem as problem:
            self.message.setText(str(problem))
            return False
        document = self.obj.Document
        document.commitTransaction()
        FreeCADGui.Control.closeDialog()
        self.obj.touch()
        document.recompute()
        return True

    def reject(self) -> bool:
        """Cancel: a new operation goes away again."""
        running.stop_all()
        self.obj.Document.abortTransaction()
        FreeCADGui.Control.closeDialog()
        return True

    def getStandardButtons(self) -> int:
        return int(QtGui.QDialogButtonBox.Ok | QtGui.QDialogButtonBox.Cancel)


def _machine_names(chosen: str) -> list[str]:
    names = list(engine().built_in())
    return names if chosen in names else [chosen, *names]


def show_operation(obj: Any, new: bool = False) -> OperationPanel:
    """Opens the panel of an operation."""
    panel = OperationPanel(obj, new)
    FreeCADGui.Control.showDialog(panel)
    return panel


class MachinePanel:
    """Machine and setup of a job."""

    def __init__(self, job: Any) -> None:
        self.job = job
        found = machines.machine_of(job)
        chosen = found.Machine if found else "bc-trunnion"
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translated("Machine"))
        rows = QtGui.QFormLayout(self.form)
        self.machine = _choice(_machine_names(chosen), chosen)
        self.machine.setEditable(True)
        self.kind = _choice(list(machines.CLASSES), "machining centre")
        self.origin = [_length(value) for value in (found.Origin if found else (0, 0, 0))]
        angles = found.Rotation if found else (0, 0, 0)
        self.rotation = [QtGui.QDoubleSpinBox() for _ in range(3)]
        for box, angle in zip(self.rotation, angles):
            box.setRange(-360.0, 360.0)
            box.setDecimals(4)
            box.setValue(angle)
        load = QtGui.QPushButton(translated("From a .fcm file of FreeCAD .."))
        usual = QtGui.QPushButton(translated("Propose the origin"))
        self.message = QtGui.QLabel("")
        self.message.setWordWrap(True)
        rows.addRow(translated("Machine"), self.machine)
        rows.addRow(load)
        rows.addRow(translated("Class, for .fcm files"), self.kind)
        for name, field in zip("XYZ", self.origin):
            rows.addRow(translated("Zero of the document at") + f" {name}", field)
        rows.addRow(usual)
        for name, box in zip("xyz", self.rotation):
            rows.addRow(translated("Rotation about") + f" {name}", box)
        rows.addRow(self.message)
        load.clicked.connect(self.convert)
        usual.clicked.connect(self.propose)

    def convert(self) -> None:
        """Converts a machine of FreeCAD, and writes it beside as a machine file."""
        path, _ = QtGui.QFileDialog.getOpenFileName(self.form, "trunnion", "", "FreeCAD machine (*.fcm)")
        if path:
            self.use_fcm(path)

    def use_fcm(self, path: str) -> None:
        """Takes the machine of a `.fcm` file."""
        try:
            with open(path, encoding="utf-8") as file:
                data, remarks = machines.convert_fcm(file.read(), machines.CLASSES[self.kind.currentText()])
            target = path.removesuffix(".fcm") + ".toml"
            with open(target, "w", encoding="utf-8") as file:
                file.write(engine().Machine(data).to_toml())
        except (Problem, OSError, engine().TrunnionError) as problem:
            self.message.setText(str(problem))
            return
        self.machine.setCurrentText(target)
        self.message.setText("\n".join([f"wrote {target}", *remarks]))

    def propose(self) -> None:
        """Fills in an origin that fits the machine's travel."""
        try:
            origin = searching.usual_origin(self.job, self.machine.currentText())
        except Problem as problem:
            self.message.setText(str(problem))
            return
        for field, value in zip(self.origin, origin):
            field.setText(FreeCAD.Units.Quantity(value, FreeCAD.Units.Length).UserString)

    def accept(self) -> bool:
        """OK: the machine goes into the document."""
        try:
            origin = FreeCAD.Vector(*(_millimetres(field) for field in self.origin))
            self.job.Document.openTransaction("Machine")
            found = machines.create(self.job, self.machine.currentText())
        except Problem as problem:
            self.message.setText(str(problem))
            self.job.Document.abortTransaction()
            return False
        found.Origin = origin
        found.Rotation = FreeCAD.Vector(*(box.value() for box in self.rotation))
        self.job.Document.commitTransaction()
        FreeCADGui.Control.closeDialog()
        self.job.Document.recompute()
        return True

    def reject(self) -> bool:
        """Cancel: nothing changes."""
        FreeCADGui.Control.closeDialog()
        return True


def show_machine(job: Any) -> MachinePanel:
    """Opens the panel of the machine of a job."""
    panel = MachinePanel(job)
    FreeCADGui.Control.showDialog(panel)
    return panel


class CheckPanel:
    """Problems of a job: a click shows line, place and move."""

    def __init__(self, job: Any, found: checking.JobCheck) -> None:
        self.job, self.found = job, found
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translated("Check this job"))
        column = QtGui.QVBoxLayout(self.form)
        verdict = translated("every tolerance and limit is kept") if found.passed else translated("NOT KEPT")
        self.verdict = QtGui.QLabel(f"<b>{verdict}</b>")
        self.list = QtGui.QListWidget()
        self.list.setWordWrap(True)
        self.findings = [*found.problems, *found.remarks]
        for index, one in enumerate(self.findings):
            mark = "\u2716 " if index < len(found.problems) else "\u26a0 "
            self.list.addItem(mark + one.text)
        self.program = QtGui.QPlainTextEdit(found.program.text)
        self.program.setReadOnly(True)
        self.program.setFont(QtGui.QFont("monospace"))
        self.table = QtGui.QPlainTextEdit(found.table)
        self.table.setReadOnly(True)
        tabs = QtGui.QTabWidget()
        tabs.addTab(self.program, translated("Program"))
        tabs.addTab(self.table, translated("Summary"))
        for widget in (self.verdict, self.list, tabs):
            column.addWidget(widget)
        self.list.currentRowChanged.connect(self.show_finding)

    def show_finding(self, row: int) -> None:
        """Selects the line of the program, the operation, and marks the place."""
        if not 0 <= row < len(self.findings):
            return
        one = self.findings[row]
        if one.line:
            block = self.program.document().findBlockByLineNumber(one.line - 1)
            cursor = QtGui.QTextCursor(block)
            cursor.select(QtGui.QTextCursor.LineUnderCursor)
            self.program.setTextCursor(cursor)
            self.program.centerCursor()
        if one.place is not None:
            FreeCADGui.Selection.clearSelection()
            target = self.job.Document.getObject(one.place.operation)
            if target is not None:
                FreeCADGui.Selection.addSelection(target)
            mark(self.job.Document, one.place.tip)

    def reject(self) -> bool:
        """Close: the mark goes away."""
        unmark(self.job.Document)
        FreeCADGui.Control.closeDialog()
        return True

    def getStandardButtons(self) -> int:
        return int(QtGui.QDialogButtonBox.Close)


_MARK = "TrunnionMark"


def mark(document: Any, tip: tuple[float, float, float]) -> None:
    """Marks a place with a small ball."""
    import Part

    ball = document.getObject(_MARK) or document.addObject("Part::Feature", _MARK)
    ball.Label = "Place of the problem"
    ball.Shape = Part.makeSphere(1.0, FreeCAD.Vector(*tip))
    ball.ViewObject.ShapeColor = (0.90, 0.45, 0.00)


def unmark(document: Any) -> None:
    """Takes the mark away."""
    if document.getObject(_MARK) is not None:
        document.removeObject(_MARK)


def show_check(job: Any, found: checking.JobCheck) -> CheckPanel:
    """Opens the panel of problems."""
    panel = CheckPanel(job, found)
    FreeCADGui.Control.closeDialog()
    FreeCADGui.Control.showDialog(panel)
    return panel


class SetupPanel:
    """Best setup beside the present one."""

    def __init__(self, machine: Any, summary: dict[str, Any]) -> None:
        self.machine, self.summary = machine, summary
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translated("Best setup"))
        rows = QtGui.QFormLayout(self.form)
        for title, key in (("now", "before"), ("best", "after")):
            entry = summary.get(key)
            text = translated("nothing within the bounds fits")
            if entry:
                angles = ", ".join(f"{angle:.2f}" for angle in entry["rotation"])
                text = f"{angles} deg; {entry['least_angle']:.1f} deg from the pole"
                text += "" if entry["fits"] else f"; {entry['why_not']}"
            rows.addRow(translated(title), QtGui.QLabel(text))

    def accept(self) -> bool:
        """OK: the best setup is used."""
        document = self.machine.Document
        document.openTransaction("Best setup")
        try:
            searching.use_setup(self.machine, self.summary)
        except Problem as problem:
            document.abortTransaction()
            FreeCAD.Console.PrintError(f"trunnion: {problem}\n")
            return False
        document.commitTransaction()
        FreeCADGui.Control.closeDialog()
        document.recompute()
        return True

    def reject(self) -> bool:
        """Cancel: the setup stays."""
        FreeCADGui.Control.closeDialog()
        return True


def show_setups(machine: Any, summary: dict[str, Any]) -> SetupPanel:
    """Opens the panel of setups."""
    panel = SetupPanel(machine, summary)
    FreeCADGui.Control.showDialog(panel)
    return panel


class ComparisonPanel:
    """Results of an operation over several values."""

    QUESTIONS = {"tool.diameter": "6, 8, 10, 12", "tolerance": "0.01, 0.02, 0.05", "machine": "bc-trunnion, ac-trunnion"}

    def __init__(self, obj: Any) -> None:
        self.obj = obj
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translated("Compare"))
        rows = QtGui.QFormLayout(self.form)
        self.name = _choice(list(self.QUESTIONS), "tool.diameter")
        self.values = QtGui.QLineEdit(self.QUESTIONS["tool.diameter"])
        self.start = QtGui.QPushButton(translated("Compare"))
        self.table = QtGui.QTableWidget()
        self.message = QtGui.QLabel("")
        self.message.setWordWrap(True)
        for title, widget in (("Over", self.name), ("Values", self.values)):
            rows.addRow(translated(title), widget)
        for widget in (self.start, self.table, self.message):
            rows.addRow(widget)
        self.name.currentTextChanged.connect(lambda name: self.values.setText(self.QUESTIONS[name]))
        self.start.clicked.connect(self.compare)

    def compare(self) -> None:
        """Runs the operation with every value."""
        values: list[Any] = [word.strip() for word in self.values.text().split(",") if word.strip()]
        try:
            values = values if self.name.currentText() == "machine" else [float(value) for value in values]
            self.obj.InputKey = ""
            found = operation.inputs(self.obj)
        except (Problem, ValueError) as problem:
            self.message.setText(str(problem))
            return
        over = {self.name.currentText(): values}
        self.message.setText(translated("comparing .."))
        running.Running("compare", lambda report: searching.compare(found, over, report), self.show_table, self.message.setText)

    def show_table(self, rows: list[dict[str, Any]]) -> None:
        """Shows a row for each value."""
        names = [name for name in (self.name.currentText(), "passed", "duration", "passes", "message") if rows and name in rows[0]]
        self.table.setColumnCount(len(names))
        self.table.setRowCount(len(rows))
        self.table.setHorizontalHeaderLabels(names)
        for i, row in enumerate(rows):
            for j, name in enumerate(names):
                value = row[name]
                text = f"{value:.1f}" if isinstance(value, float) else str(value)
                self.table.setItem(i, j, QtGui.QTableWidgetItem(text))
        self.message.setText("")

    def getStandardButtons(self) -> int:
        return int(QtGui.QDialogButtonBox.Close)

    def reject(self) -> bool:
        """Close."""
        running.stop_all()
        FreeCADGui.Control.closeDialog()
        return True


def show_comparison(obj: Any) -> ComparisonPanel:
    """Opens the panel of comparisons."""
    panel = ComparisonPanel(obj)
    FreeCADGui.Control.showDialog(panel)
    return panel
