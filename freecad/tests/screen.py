"""The window served and pictured, for tests under Xvfb. TRUNNION_SHOTS names a folder for screenshots."""

from __future__ import annotations

import os
import tempfile
import time

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
        FreeCADGui.ActiveDocument.ActiveView.saveImage(path, area.width(), area.height(), "White")
        painter = QtGui.QPainter(picture)
        painter.drawPixmap(area.mapTo(window, QtCore.QPoint(0, 0)), QtGui.QPixmap(path))
        painter.end()
    picture.save(os.path.join(_SHOTS, name + ".png"))
