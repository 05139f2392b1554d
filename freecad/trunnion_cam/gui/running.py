"""Work beside the window, with FreeCAD's own progress bar, until it is done or given up."""

from __future__ import annotations

from typing import Any, Callable

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .. import operation
from ..engine import Work
from ..problem import Problem

#: Time between two looks at the work [ms]: the window never waits longer.
_PERIOD = 100

_current: list["Running"] = []


class Running(QtCore.QObject):
    """One piece of work; `done` gets the result, `failed` the words of an error."""

    def __init__(
        self, title: str, call: Callable[..., Any], done: Callable[[Any], None], failed: Callable[[str], None]
    ) -> None:
        super().__init__()
        self.title, self.done, self.failed = title, done, failed
        self.work = Work(call).start()
        self.bar = _Bar(title, self.work.cancel)
        self.timer = QtCore.QTimer(self)
        self.timer.timeout.connect(self.look)
        self.timer.start(_PERIOD)
        _current.append(self)

    def look(self) -> None:
        """Moves the bar, and ends with the work."""
        self.bar.move(self.work.stage, self.work.done, self.work.total)
        if not self.work.finished:
            return
        self.timer.stop()
        self.bar.close()
        _current.remove(self)
        if self.work.error:
            self.failed(self.work.error)
        else:
            self.done(self.work.result)


class _Bar:
    """Progress in the status bar, with a button that stops the work."""

    def __init__(self, title: str, stop: Callable[[], None]) -> None:
        self.status = FreeCADGui.getMainWindow().statusBar()
        self.label = QtGui.QLabel(title)
        self.bar = QtGui.QProgressBar()
        self.bar.setMaximumWidth(220)
        self.bar.setRange(0, 0)
        self.stop = QtGui.QPushButton("Stop")
        self.stop.clicked.connect(stop)
        self.title = title
        for widget in (self.label, self.bar, self.stop):
            self.status.addPermanentWidget(widget)

    def move(self, stage: str, done: int, total: int) -> None:
        self.label.setText(f"{self.title}: {stage}" if stage else self.title)
        self.bar.setRange(0, max(total, 0))
        self.bar.setValue(done)

    def close(self) -> None:
        for widget in (self.label, self.bar, self.stop):
            self.status.removeWidget(widget)
            widget.deleteLater()


def busy() -> bool:
    """Returns True while something runs."""
    return bool(_current)


def stop_all() -> None:
    """Asks everything that runs to stop."""
    for one in list(_current):
        one.work.cancel()


def plan(obj: Any, found: operation.Inputs, after: Callable[[str], None] | None = None) -> None:
    """Plans an operation; when it is done, its result goes into the document in one step of undo."""
    document, name = obj.Document.Name, obj.Name
    for one in list(_current):
        # The newest state of the model counts.
        if getattr(one, "target", None) == (document, name):
            one.work.cancel()

    def done(result: Any) -> None:
        target = _still_there(document, name)
        if target is None:
            return
        target.Document.openTransaction("Five-axis finish")
        operation.apply(target, found, result)
        target.Document.commitTransaction()
        if after:
            after("")

    def failed(text: str) -> None:
        target = _still_there(document, name)
        if target is not None:
            operation.refuse(target, Problem(text))
        if after:
            after(text)

    running = Running(obj.Label, lambda report: operation.compute(found, report), done, failed)
    running.target = (document, name)


def _still_there(document: str, name: str) -> Any:
    """Returns an object that may have been deleted meanwhile, or None."""
    if document not in FreeCAD.listDocuments():
        return None
    return FreeCAD.getDocument(document).getObject(name)
