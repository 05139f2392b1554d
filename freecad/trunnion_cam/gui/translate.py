"""Texts that translations may replace."""

from __future__ import annotations

import FreeCAD


def translated(text: str) -> str:
    """Returns a text in the language of the window."""
    return FreeCAD.Qt.translate("trunnion", text) if hasattr(FreeCAD, "Qt") else text
