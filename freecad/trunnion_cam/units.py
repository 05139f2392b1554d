"""Lengths and feeds as the user's unit schema writes them, with the digits that they have."""

from __future__ import annotations

import FreeCAD


def length_text(value: float) -> str:
    """Returns a length [mm] in the units of the user; FreeCAD's own text has too few digits for tolerances."""
    _, factor, unit = FreeCAD.Units.Quantity(value, FreeCAD.Units.Length).getUserPreferred()
    text = f"{value / factor:.6g} {unit}" if factor and unit else ""
    try:
        back = float(FreeCAD.Units.Quantity(text).getValueAs("mm"))
    except Exception:
        back = float("nan")
    # Schemas with feet and fractions of inches have no such text.
    return text if abs(back - value) <= 1e-5 * abs(value) else f"{value:.6g} mm"


def feed_text(value: float) -> str:
    """Returns a feed [mm/min] per minute, in mm or inches as the user has them."""
    schema = FreeCAD.Units.Quantity(value / 60.0, FreeCAD.Units.Velocity).UserString
    inches = "in" in schema.replace("min", "") or "ft" in schema or '"' in schema
    return f"{value / 25.4:.6g} in/min" if inches else f"{value:.6g} mm/min"
