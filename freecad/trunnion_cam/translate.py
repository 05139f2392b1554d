"""Texts that a user sees, in the language of the window.

`translations/update.py` collects what stands in calls of these functions; a test refuses texts that pass them by.
"""

from __future__ import annotations

import FreeCAD

CONTEXT = "trunnion"
#: Context in which FreeCAD looks for the descriptions of properties.
PROPERTIES = "App::Property"


def translated(text: str, /, **values: object) -> str:
    """Returns a text in the language of the window, with values in place of its `{name}`."""
    found = FreeCAD.Qt.translate(CONTEXT, text)
    return found.format(**values) if values else found


def marked(text: str) -> str:
    """Returns a text that is translated where it is shown."""
    return text


def described(text: str) -> str:
    """Returns the description of a property, which FreeCAD translates itself."""
    return text
