"""Work beside the window, with FreeCAD's own progress bar, until it is done or given up."""

from __future__ import annotations

from typing import Any, Callable

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .. import operation
from ..engine import Work
from ..problem import Problem
from ..translate import translated
from .preview import Preview

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
        self.target: tuple[str, str] | None = None
        #: Passes while they are placed.
        self.preview: Preview | None = None
        self.work = Work(call).start()
        self.bar = _Bar(title, self.work.cancel)
        self.timer = QtCore.QTimer(self)
        self.timer.timeout.connect(self.look)
        self.timer.start(_PERIOD)
        _current.append(self)

    def look(self) -> None:
        """Moves the bar, and ends with the work."""
        self.bar.move(self.work.stage, self.work.done, self.work.total)
        if self.preview:
            self.preview.look()
        if not self.work.finished:
            return
        self.timer.stop()
        self.bar.close()
        if self.preview:
            self.preview.end()
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
        self.stop = QtGui.QPushButton(translated("Stop"))
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


class _Steps(QtCore.QObject):
    """Calls one after the other, with the window served between them."""

    def __init__(self, calls: list[Callable[[], None]]) -> None:
        super().__init__()
        self.calls = list(calls)
        _stepping.append(self)
        self.next()

    def next(self) -> None:
        """Makes the first call that is left."""
        if not self.calls:
            _stepping.remove(self)
            return
        try:
            self.calls.pop(0)()
        except Exception:
            _stepping.remove(self)
            raise
        QtCore.QTimer.singleShot(0, self.next)


_stepping: list[_Steps] = []


def previewed() -> int:
    """Returns the number of passes on screen of operations that are being planned."""
    return sum(one.preview.count for one in _current if one.preview)


def busy() -> bool:
    """Returns True while something runs."""
    return bool(_current or _stepping)


def stop_all() -> None:
    """Asks everything that runs to stop."""
    for one in list(_current):
        one.work.cancel()


def stop(obj: Any) -> None:
    """Asks the planning of an operation to stop; nothing of it reaches the operation any more."""
    for one in _current:
        if one.target == (obj.Document.Name, obj.Name):
            one.target = None
            one.work.cancel()


def plan(obj: Any, found: operation.Inputs, after: Callable[[str], None] | None = None) -> None:
    """Plans an operation; when it is done, its result goes into the document in one step of undo."""
    document, name = obj.Document.Name, obj.Name
    # The newest state of the model counts.
    stop(obj)

    def target() -> Any:
        return _still_there(document, name) if running.target else None

    def done(prepared: operation.Prepared) -> None:
        if target() is None:
            return
        # An open panel has a transaction of its own, to which the result belongs.
        own = not target().Document.HasPendingTransaction
        if own:
            target().Document.openTransaction(translated("Five-axis finish"))

        def guarded(step: Callable[[], None]) -> Callable[[], None]:
            return lambda: step() if target() is not None else None

        def last() -> None:
            if own and document in FreeCAD.listDocuments():
                FreeCAD.getDocument(document).commitTransaction()
            if after:
                after("")

        _Steps([*map(guarded, operation.steps(target(), found, prepared)), last])

    def failed(text: str) -> None:
        if target() is None:
            return
        if running.work.cancelled:
            # It keeps nothing of another model, and is planned with the next recompute.
            problem = Problem(translated("planning was stopped"), translated("recompute the document to plan the operation"))
            operation.refuse(target(), problem)
            target().touch()
        else:
            operation.refuse(target(), Problem(text))
        if after:
            after(target().Verdict)

    def call(report: Callable[[str, int, int], None]) -> operation.Prepared:
        result = operation.compute(found, report, on_passes=shown.take)
        report(translated("drawing"), 0, 0)
        return operation.prepare(found, result)

    shown = Preview(document, found.size)
    for old in obj.Pictures:
        # Those of the state before; every end of the work takes them away.
        old.ViewObject.Visibility = False
    running = Running(obj.Label, call, done, failed)
    running.target, running.preview = (document, name), shown


def _still_there(document: str, name: str) -> Any:
    """Returns an object that may have been deleted meanwhile, or None."""
    if document not in FreeCAD.listDocuments():
        return None
    return FreeCAD.getDocument(document).getObject(name)
