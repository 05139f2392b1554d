"""The window served and pictured, and a test in it, for tests under Xvfb. TRUNNION_SHOTS names a folder for screenshots."""

from __future__ import annotations

import os
import sys
import tempfile
import time
import traceback

import FreeCADGui
from PySide import QtCore, QtGui

_SHOTS = os.environ.get("TRUNNION_SHOTS")


def serve(seconds: float, until=lambda: False) -> None:
    """Serves the window for a time, or until something holds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end and not until():
        QtGui.QApplication.processEvents()
        time.sleep(0.005)


def shot(name: str) -> None:
    """Keeps a screenshot; a picture of the window leaves the view in space blank, so it is painted in."""
    if not _SHOTS:
        return
    serve(0.5)
    window = FreeCADGui.getMainWindow()
    picture = window.grab()
    area = [one for one in window.centralWidget().subWindowList() if one.isVisible()][-1]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "view.png")
        FreeCADGui.ActiveDocument.ActiveView.saveImage(path, area.width(), area.height(), "Current")
        painter = QtGui.QPainter(picture)
        painter.drawPixmap(area.mapTo(window, QtCore.QPoint(0, 0)), QtGui.QPixmap(path))
        # Since 1.1 panels lie over the view.
        for dock in window.findChildren(QtGui.QDockWidget):
            if dock.isVisible():
                painter.drawPixmap(dock.mapTo(window, QtCore.QPoint(0, 0)), dock.grab())
        painter.end()
    picture.save(os.path.join(_SHOTS, name + ".png"))


def run_in_window(test) -> None:
    """Runs a test once the window stands, and ends FreeCAD with its verdict."""

    def guarded() -> None:
        status = 0
        # FreeCAD 1.x sends what is printed to its report view alone.
        sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
        try:
            test()
        except BaseException:  # The verdict has to reach the shell.
            traceback.print_exc()
            print("FAILED")
            status = 1
        sys.stdout.flush()
        os._exit(status)

    QtCore.QTimer.singleShot(500, guarded)
