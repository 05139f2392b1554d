"""Task panels: operation, machine, problems, setups, comparison."""

from __future__ import annotations

import os
from typing import Any, Callable

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .. import checking, compat, machines, operation, searching, shapes, tools
from ..engine import engine
from ..problem import Problem
from ..translate import marked, translated
from ..units import feed_text, length_text
from . import running, views


def need_room() -> None:
    """Raises Problem while the panel of another command is open."""
    if FreeCADGui.Control.activeDialog():
        raise Problem(translated("another task panel is open"), translated("close it first"))


def _open(panel: Any) -> Any:
    need_room()
    FreeCADGui.Control.showDialog(panel)
    return panel


#: Width of the fields of a panel [pixels].
_LEAST_WIDTH = 70


def _narrow(box: Any) -> None:
    box.setMinimumWidth(_LEAST_WIDTH)
    box.setSizeAdjustPolicy(QtGui.QComboBox.AdjustToMinimumContentsLengthWithIcon)


def _length(value: float) -> Any:
    """A field for a length in the user's units; FreeCAD's own fields round 0.002 mm to 0.00 mm."""
    field = QtGui.QLineEdit()
    field.setMinimumWidth(_LEAST_WIDTH)
    _set_length(field, value)
    return field


def _set_length(field: Any, value: float) -> None:
    field.setText(length_text(value))


def _millimetres(field: Any) -> float:
    try:
        return float(FreeCAD.Units.Quantity(field.text()).getValueAs("mm"))
    except Exception:
        raise Problem(
            translated("'{text}' is no length", text=field.text()), translated("write a number with a unit, such as 0.02 mm")
        ) from None


def _feed(value: float) -> Any:
    """A field for a feed in the user's units; the value in mm/s."""
    field = QtGui.QLineEdit()
    field.setMinimumWidth(_LEAST_WIDTH)
    _set_feed(field, value)
    return field


def _set_feed(field: Any, value: float) -> None:
    field.setText(feed_text(60.0 * value))


def _feed_of(field: Any) -> float:
    """Returns a feed [mm/min]."""
    try:
        return float(FreeCAD.Units.Quantity(field.text()).getValueAs("mm/min"))
    except Exception:
        raise Problem(
            translated("'{text}' is no feed", text=field.text()), translated("write a number with a unit, such as 1200 mm/min")
        ) from None


class _Choice(QtGui.QComboBox):
    """A choice between values that have names in the language of the window."""

    def __init__(self, names: dict[str, str], chosen: str) -> None:
        super().__init__()
        _narrow(self)
        for value, name in names.items():
            self.addItem(translated(name), value)
        self.setCurrentIndex(max(self.findData(chosen), 0))

    def value(self) -> str:
        """Returns the chosen value."""
        return str(self.itemData(self.currentIndex()))

    def choose(self, value: str) -> None:
        """Chooses a value."""
        self.setCurrentIndex(self.findData(value))


def _list(values: list[str], chosen: str) -> Any:
    """A choice between names that are the same in all languages."""
    box = QtGui.QComboBox()
    _narrow(box)
    box.addItems(values)
    box.setCurrentText(chosen)
    return box


def _words(text: str = "") -> Any:
    """A label for messages."""
    label = QtGui.QLabel(text)
    label.setWordWrap(True)
    label.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
    return label


def _guarded(call: Callable[[], None]) -> None:
    """Calls, unless the panel was closed meanwhile."""
    try:
        call()
    except RuntimeError:
        return


def _form(title: str) -> Any:
    form = QtGui.QWidget()
    form.setWindowTitle(title)
    return form


def _rows(form: Any) -> Any:
    """Rows of a panel, which is as narrow as FreeCAD's own: long labels stand above their fields."""
    rows = QtGui.QFormLayout(form)
    rows.setRowWrapPolicy(QtGui.QFormLayout.WrapLongRows)
    rows.setFieldGrowthPolicy(QtGui.QFormLayout.AllNonFixedFieldsGrow)
    return rows


class OperationPanel:
    """Settings of a five-axis finish, with a preview of its passes."""

    def __init__(self, obj: Any) -> None:
        self.obj = obj
        self.controllers = compat.controllers(obj.Job)
        machine = machines.needed_machine(obj.Job)
        self.form = _form(translated("Five-axis finish"))
        rows = _rows(self.form)
        thing, faces = obj.Base
        rows.addRow(translated("Faces"), QtGui.QLabel(f"{thing.Label}: {', '.join(faces)}"))
        self.machine = _list(_machine_names(machine.Machine), machine.Machine)
        self.tool = _list([one.Label for one in self.controllers], obj.ToolController.Label)
        self.feed, self.spindle = _feed(0.0), _number(0.0, 1e6)
        self.length = _length(float(obj.ToolLength.Value))
        self.excess, self.gouge = _length(float(obj.Excess.Value)), _length(float(obj.Gouge.Value))
        self.method = _Choice(operation.METHODS, str(obj.Method))
        self.along = _Choice(operation.ALONG, str(obj.Along))
        self.order = _Choice(operation.DIRECTIONS, str(obj.Direction))
        self.flip = QtGui.QCheckBox(translated("cut the other side"))
        self.flip.setChecked(bool(obj.Flip))
        self.preview = QtGui.QPushButton(translated("Preview"))
        self.message = _words(obj.Verdict)
        self.legend = QtGui.QLabel()
        for title, widget in (
            (translated("Machine"), self.machine),
            (translated("Tool"), self.tool),
            (translated("Feed"), self.feed),
            (translated("Speed, 1/min"), self.spindle),
            (translated("Tool length"), self.length),
            (translated("Largest excess"), self.excess),
            (translated("Deepest gouge"), self.gouge),
            (translated("Method"), self.method),
            (translated("Passes along"), self.along),
            (translated("Order"), self.order),
            (translated("Side"), self.flip),
        ):
            rows.addRow(title, widget)
        for widget in (self.preview, self.message, self.legend):
            rows.addRow(widget)
        self.preview.clicked.connect(self.show_preview)
        self.tool.currentIndexChanged.connect(self.show_tool)
        self.show_tool(self.tool.currentIndex())
        self._show_legend()

    def show_tool(self, index: int) -> None:
        """Shows feed, speed and length of a tool; what is missing can be typed at once."""
        controller = self.controllers[index]
        _set_feed(self.feed, float(getattr(controller.HorizFeed, "Value", controller.HorizFeed)))
        self.spindle.setValue(float(controller.SpindleSpeed))
        own = controller.Name == self.obj.ToolController.Name
        _set_length(self.length, float(self.obj.ToolLength.Value) if own else tools.usual_length(controller))
        self.focus_missing()

    def open(self) -> None:
        """Called by FreeCAD when the panel is shown."""
        QtCore.QTimer.singleShot(0, lambda: _guarded(self.focus_missing))

    def focus_missing(self) -> None:
        """Gives the keyboard to the first field that has to be filled in."""
        controller = self.controllers[self.tool.currentIndex()]
        for field, value in ((self.feed, controller.HorizFeed), (self.spindle, controller.SpindleSpeed)):
            if float(getattr(value, "Value", value)) <= 0:
                field.setFocus()
                field.selectAll()
                return

    def take(self) -> None:
        """Puts the settings into the operation; nothing is changed unless all of them can be read."""
        obj = self.obj
        lengths = [_millimetres(field) for field in (self.length, self.excess, self.gouge)]
        feed = _feed_of(self.feed)
        chosen_machine = self.machine.currentText()
        if machines.needed_machine(obj.Job).Machine != chosen_machine:
            # The origin of one machine means nothing on another.
            origin = searching.quick_origin(obj.Job, chosen_machine)
            machines.create(obj.Job, chosen_machine).Origin = FreeCAD.Vector(*origin)
        tools.set_cutting(self.controllers[self.tool.currentIndex()], feed, self.spindle.value())
        chosen = {
            "ToolController": self.controllers[self.tool.currentIndex()],
            "Method": self.method.value(),
            "Along": self.along.value(),
            "Direction": self.order.value(),
            "Flip": self.flip.isChecked(),
        }
        for name, value in chosen.items():
            if getattr(obj, name) != value:
                setattr(obj, name, value)
        for name, value in zip(("ToolLength", "Excess", "Gouge"), lengths):
            # What is shown has fewer digits than what is kept.
            if abs(float(getattr(obj, name).Value) - value) > 1e-6:
                setattr(obj, name, value)

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
        running.plan(self.obj, found, self._shown)

    def _shown(self, text: str) -> None:
        try:
            planned = translated("{verdict}; {duration} s", verdict=self.obj.Verdict, duration=f"{float(self.obj.Duration):.1f}")
            self.message.setText(text or planned)
            self._show_legend()
        except RuntimeError:
            # The panel was closed meanwhile.
            return

    def _show_legend(self) -> None:
        shown = any(hasattr(one, "Height") for one in self.obj.Pictures)
        self.legend.setText(views.legend_page(float(self.obj.Excess.Value), float(self.obj.Gouge.Value)) if shown else "")

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
        """Cancel: everything is as before, and a new operation goes away again."""
        running.stop(self.obj)
        document = self.obj.Document
        document.abortTransaction()
        FreeCADGui.Control.closeDialog()
        document.recompute()
        return True

    def getStandardButtons(self) -> Any:
        """Buttons of the panel."""
        return compat.standard_buttons("Ok", "Cancel")


def _machine_names(chosen: str) -> list[str]:
    names = list(engine().built_in())
    return names if chosen in names else [chosen, *names]


def show_operation(obj: Any) -> OperationPanel:
    """Opens the panel of an operation; what it changes is one step of undo."""
    need_room()
    panel = OperationPanel(obj)
    if not obj.Document.HasPendingTransaction:
        obj.Document.openTransaction(translated("Five-axis finish"))
    return _open(panel)


class MachinePanel:
    """Machine and setup of a job."""

    def __init__(self, job: Any) -> None:
        self.job = job
        found = machines.machine_of(job)
        chosen = found.Machine if found else "bc-trunnion"
        self.fixtures = list(found.Fixtures) if found else []
        self.form = _form(translated("Machine"))
        rows = _rows(self.form)
        self.machine = _list(_machine_names(chosen), chosen)
        self.machine.setEditable(True)
        self.kind = _Choice(machines.CLASS_NAMES, "machining centre")
        self.dynamics = [_number(0.0, 1e7) for _ in range(4)]
        self.origin = [_length(value) for value in (found.Origin if found else (0, 0, 0))]
        self.rotation = [_number(-360.0, 360.0) for _ in range(3)]
        for box, angle in zip(self.rotation, found.Rotation if found else (0, 0, 0)):
            box.setValue(angle)
        self.clearance = _length(float(found.Clearance.Value) if found else 1.0)
        load = QtGui.QPushButton(translated("From a file .."))
        usual = QtGui.QPushButton(translated("Propose the origin"))
        take = QtGui.QPushButton(translated("Take selected solids"))
        self.listed = _words()
        self.message = _words()
        rows.addRow(translated("Machine"), self.machine)
        rows.addRow(load)
        rows.addRow(translated("Class (.fcm)"), self.kind)
        for title, box in zip(
            (
                translated("Linear, mm/s2"), translated("Linear, mm/s3"), translated("Rotary, deg/s2"), translated("Rotary, deg/s3"),
            ),
            self.dynamics,
        ):
            box.setToolTip(translated("Acceleration and jerk, which .fcm files lack: enter those of your machine"))
            rows.addRow(title, box)
        for name, field in zip("XYZ", self.origin):
            field.setToolTip(translated("Where the zero of the document stands in machine coordinates, with all axes at zero"))
            rows.addRow(translated("Zero at {axis}", axis=name), field)
        rows.addRow(usual)
        for name, box in zip("xyz", self.rotation):
            box.setToolTip(translated("Rotation of the workpiece about the machine's x, then y, then z"))
            rows.addRow(translated("About {axis}, deg", axis=name), box)
        rows.addRow(translated("Fixtures"), self.listed)
        rows.addRow(take)
        rows.addRow(translated("Clearance"), self.clearance)
        rows.addRow(self.message)
        load.clicked.connect(self.choose_file)
        usual.clicked.connect(self.propose)
        take.clicked.connect(self.take_fixtures)
        self.kind.currentIndexChanged.connect(lambda _: self.show_class())
        self.show_class()
        self._list_fixtures()

    def show_class(self) -> None:
        """Fills in the usual dynamics of a class."""
        usual = machines.CLASSES[self.kind.value()]
        for box, value in zip(self.dynamics, (*usual.linear, *usual.rotary)):
            box.setValue(value)

    def choose_file(self) -> None:
        """Takes a machine file, or converts a machine of FreeCAD and writes it beside as a machine file."""
        kinds = translated("Machines") + " (*.toml *.fcm)"
        path, _ = QtGui.QFileDialog.getOpenFileName(self.form, "trunnion", "", kinds)
        if path:
            self.use_file(path)

    def use_file(self, path: str) -> None:
        """Takes the machine of a file."""
        try:
            if path.endswith(".fcm"):
                path, remarks = self._converted(path)
                remarks = [translated("wrote {path}", path=path), *remarks]
            else:
                machines.load(path)
                remarks = []
        except (Problem, OSError, ValueError, engine().TrunnionError) as problem:
            self.message.setText(str(problem))
            return
        self.machine.setCurrentText(path)
        self.message.setText("\n".join(remarks))

    def _converted(self, path: str) -> tuple[str, list[str]]:
        values = [box.value() for box in self.dynamics]
        dynamics = machines.AxisDynamics((values[0], values[1]), (values[2], values[3]))
        with open(path, encoding="utf-8") as file:
            data, remarks = machines.convert_fcm(file.read(), dynamics)
        text = engine().Machine(data).to_toml()
        target = os.path.splitext(path)[0] + ".toml"
        with open(target, "w", encoding="utf-8") as file:
            file.write(text)
        return target, remarks

    def propose(self) -> None:
        """Fills in an origin that fits the machine's travel."""
        machine = self.machine.currentText()
        try:
            machines.load(machine)
            step = shapes.step_bytes(checking.model(self.job))
        except (Problem, engine().TrunnionError) as problem:
            self.message.setText(str(problem))
            return

        def done(origin: list[float]) -> None:
            for field, value in zip(self.origin, origin):
                _guarded(lambda field=field, value=value: _set_length(field, value))

        def failed(text: str) -> None:
            _guarded(lambda: self.message.setText(text))

        # A part of many faces takes its time.
        running.Running(translated("origin"), lambda report: searching.origin_of(step, machine, report), done, failed)

    def take_fixtures(self) -> None:
        """The selected solids become the fixtures; with nothing selected there are none."""
        chosen = [one for one in FreeCADGui.Selection.getSelection() if not compat.is_job(one)]
        without = [one.Label for one in chosen if not getattr(getattr(one, "Shape", None), "Solids", [])]
        if without:
            self.message.setText(translated("no solids: {labels}", labels=", ".join(without)))
            return
        self.fixtures = chosen
        self._list_fixtures()

    def _list_fixtures(self) -> None:
        self.listed.setText(", ".join(one.Label for one in self.fixtures) or translated("none"))

    def accept(self) -> bool:
        """OK: the machine goes into the document."""
        document = self.job.Document
        try:
            origin = FreeCAD.Vector(*(_millimetres(field) for field in self.origin))
            clearance = _millimetres(self.clearance)
            document.openTransaction(translated("Machine"))
            found = machines.create(self.job, self.machine.currentText())
        except (Problem, engine().TrunnionError) as problem:
            self.message.setText(str(problem))
            document.abortTransaction()
            return False
        if (found.Origin - origin).Length > 1e-6:
            found.Origin = origin
        found.Rotation = FreeCAD.Vector(*(box.value() for box in self.rotation))
        found.Fixtures, found.Clearance = self.fixtures, clearance
        document.commitTransaction()
        FreeCADGui.Control.closeDialog()
        document.recompute()
        return True

    def reject(self) -> bool:
        """Cancel: nothing changes."""
        FreeCADGui.Control.closeDialog()
        return True

    def getStandardButtons(self) -> Any:
        """Buttons of the panel."""
        return compat.standard_buttons("Ok", "Cancel")


def _number(least: float, most: float) -> Any:
    box = QtGui.QDoubleSpinBox()
    box.setMinimumWidth(_LEAST_WIDTH)
    box.setRange(least, most)
    box.setDecimals(4 if most < 1000 else 0)
    return box


def show_machine(job: Any) -> MachinePanel:
    """Opens the panel of the machine of a job."""
    return _open(MachinePanel(job))


class CheckPanel:
    """Problems of a job: a click shows line, place and move."""

    def __init__(self, job: Any, found: checking.JobCheck) -> None:
        self.job, self.found = job, found
        self.form = _form(translated("Check this job"))
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
        self.table = QtGui.QPlainTextEdit(found.table)
        for text in (self.program, self.table):
            text.setReadOnly(True)
            text.setFont(QtGui.QFont("monospace"))
            text.setLineWrapMode(QtGui.QPlainTextEdit.NoWrap)
        tabs = QtGui.QTabWidget()
        tabs.addTab(self.program, translated("Program"))
        tabs.addTab(self.table, translated("Summary"))
        self.legend = QtGui.QLabel()
        if found.drawn.deviation is not None:
            self.legend.setText(views.legend_page(found.drawn.deviation.excess, found.drawn.deviation.gouge))
        for widget in (self.verdict, self.list, tabs, self.legend):
            column.addWidget(widget)
        self.list.currentRowChanged.connect(self.show_finding)

    def show_finding(self, row: int) -> None:
        """Selects the line of the program and the operation, and marks place and move."""
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
            mark(self.job.Document, one.place)

    def reject(self) -> bool:
        """Close: the mark goes away; the coloured mesh stays."""
        unmark(self.job.Document)
        FreeCADGui.Control.closeDialog()
        return True

    def getStandardButtons(self) -> Any:
        """Buttons of the panel."""
        return compat.standard_buttons("Close")


_MARK = "TrunnionMark"


def mark(document: Any, place: Any) -> None:
    """Marks a place with a small ball, and the move that leads to it with a line."""
    import Part

    start, tip = FreeCAD.Vector(*place.start), FreeCAD.Vector(*place.tip)
    shapes = [Part.makeSphere(1.0, tip)]
    if start.distanceToPoint(tip) > 1e-6:
        shapes.append(Part.makeLine(start, tip))
    ball = document.getObject(_MARK) or document.addObject("Part::Feature", _MARK)
    ball.Label = translated("Place of the problem")
    ball.Shape = Part.Compound(shapes)
    ball.ViewObject.ShapeColor = (0.90, 0.45, 0.00)
    ball.ViewObject.LineColor = (0.80, 0.00, 0.20)
    ball.ViewObject.LineWidth = 5.0
    ball.purgeTouched()


def unmark(document: Any) -> None:
    """Takes the mark away."""
    if document.getObject(_MARK) is not None:
        document.removeObject(_MARK)


def show_check(job: Any, found: checking.JobCheck) -> CheckPanel | None:
    """Opens the panel of problems, and shows the deviation of the part; None if the job is gone."""
    if job.Document is None:
        return None
    panel = CheckPanel(job, found)
    document = job.Document
    own = not document.HasPendingTransaction
    if own:
        document.openTransaction(translated("Check this job"))
    checking.show(job, found)
    if own:
        document.commitTransaction()
    return _open(panel)


class SetupPanel:
    """Best setup beside the present one."""

    def __init__(self, machine: Any, summary: dict[str, Any]) -> None:
        self.machine, self.summary = machine, summary
        self.form = _form(translated("Best setup"))
        rows = _rows(self.form)
        for title, key in ((translated("now"), "before"), (translated("best"), "after")):
            rows.addRow(title, _words(self.words(summary.get(key))))

    @staticmethod
    def words(entry: dict[str, Any] | None) -> str:
        """Returns what a setup is like."""
        if not entry:
            return translated("nothing within the bounds fits")
        angles = ", ".join(f"{angle:.2f}" for angle in entry["rotation"])
        least = f"{entry['least_angle']:.1f}"
        text = translated("rotation {angles} degrees; {least} degrees from the pole", angles=angles, least=least)
        return text if entry["fits"] else f"{text}; {entry['why_not']}"

    def accept(self) -> bool:
        """OK: the best setup is used."""
        document = self.machine.Document
        document.openTransaction(translated("Best setup"))
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

    def getStandardButtons(self) -> Any:
        """Buttons of the panel; there is nothing to accept where nothing fits."""
        return compat.standard_buttons("Ok", "Cancel") if self.summary.get("after") else compat.standard_buttons("Cancel")


def show_setups(machine: Any, summary: dict[str, Any]) -> SetupPanel:
    """Opens the panel of setups."""
    return _open(SetupPanel(machine, summary))


class Question:
    """What a comparison may be over: its name in a job file, its words, and values to start with."""

    def __init__(self, words: str, values: Callable[[Any], str]) -> None:
        self.words, self.values = words, values


def _diameters(obj: Any) -> str:
    own = float(obj.ToolController.Tool.Diameter)
    return ", ".join(f"{factor * own:g}" for factor in (0.75, 1.0, 1.25))


def _tolerances(obj: Any) -> str:
    own = float(obj.Excess.Value)
    return ", ".join(f"{factor * own:g}" for factor in (0.5, 1.0, 2.0))


def _machines(obj: Any) -> str:
    own = machines.needed_machine(obj.Job).Machine
    return ", ".join(dict.fromkeys([own, *engine().built_in()][:3]))


class ComparisonPanel:
    """Results of an operation over several values."""

    QUESTIONS = {
        "tool.diameter": Question(marked("diameter of the tool, mm"), _diameters),
        "tolerance": Question(marked("largest excess, mm"), _tolerances),
        "machine": Question(marked("machine"), _machines),
    }
    COLUMNS = {
        "passed": marked("kept"), "duration": marked("time, s"), "passes": marked("passes"), "message": marked("remark"),
    }

    def __init__(self, obj: Any) -> None:
        self.obj = obj
        self.form = _form(translated("Compare"))
        rows = _rows(self.form)
        self.name = _Choice({name: one.words for name, one in self.QUESTIONS.items()}, "tool.diameter")
        self.values = QtGui.QLineEdit()
        self.start = QtGui.QPushButton(translated("Compare"))
        self.table = QtGui.QTableWidget()
        self.message = _words()
        for title, widget in ((translated("Over"), self.name), (translated("Values"), self.values)):
            rows.addRow(title, widget)
        for widget in (self.start, self.table, self.message):
            rows.addRow(widget)
        self.running: Any = None
        self.name.currentIndexChanged.connect(lambda _: self.propose())
        self.start.clicked.connect(self.compare)
        self.propose()

    def propose(self) -> None:
        """Fills in values around the present one."""
        self.values.setText(self.QUESTIONS[self.name.value()].values(self.obj))

    def compare(self) -> None:
        """Runs the operation with every value."""
        values: list[Any] = [word.strip() for word in self.values.text().split(",") if word.strip()]
        try:
            values = values if self.name.value() == "machine" else [float(value) for value in values]
            found = operation.inputs(self.obj)
        except ValueError:
            self.message.setText(translated("write numbers with commas between them"))
            return
        except Problem as problem:
            self.message.setText(str(problem))
            return
        name = self.name.value()
        self.message.setText(translated("comparing .."))

        def done(table: list[dict[str, Any]]) -> None:
            _guarded(lambda: self.show_table(name, table))

        def failed(text: str) -> None:
            _guarded(lambda: self.message.setText(text))

        title = translated("comparison of {label}", label=self.obj.Label)
        self.running = running.Running(title, lambda report: searching.compare(found, {name: values}, report), done, failed)

    def show_table(self, name: str, rows: list[dict[str, Any]]) -> None:
        """Shows a row for each value."""
        columns = {name: self.QUESTIONS[name].words, **self.COLUMNS}
        columns = {key: words for key, words in columns.items() if rows and key in rows[0]}
        self.table.setColumnCount(len(columns))
        self.table.setRowCount(len(rows))
        self.table.setHorizontalHeaderLabels([translated(words) for words in columns.values()])
        for i, row in enumerate(rows):
            for j, key in enumerate(columns):
                self.table.setItem(i, j, QtGui.QTableWidgetItem(_cell(row[key])))
        self.table.resizeColumnsToContents()
        self.message.setText("")

    def getStandardButtons(self) -> Any:
        """Buttons of the panel."""
        return compat.standard_buttons("Close")

    def reject(self) -> bool:
        """Close: a comparison that still runs is stopped."""
        if self.running is not None:
            self.running.work.cancel()
        FreeCADGui.Control.closeDialog()
        return True


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return translated("yes") if value else translated("no")
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def show_comparison(obj: Any) -> ComparisonPanel:
    """Opens the panel of comparisons."""
    return _open(ComparisonPanel(obj))
