"""Colours of deviations, which colour-blind eyes tell apart: blue is too low, orange too high."""

from __future__ import annotations

from typing import Any

GOUGE = (0.00, 0.26, 0.62)
KEPT = (0.78, 0.80, 0.78)
EXCESS = (0.90, 0.45, 0.00)
UNCUT = (0.20, 0.20, 0.20)


def colour(height: float, excess: float, gouge: float) -> tuple[float, float, float]:
    """Returns the colour of a height over the face [mm]."""
    if height != height or abs(height) > 1e2:
        return UNCUT
    limit, end = (excess, EXCESS) if height >= 0 else (gouge, GOUGE)
    share = min(abs(height) / max(limit, 1e-9), 1.0)
    return tuple(a + (b - a) * share for a, b in zip(KEPT, end))  # type: ignore[return-value]


def show(drawn: Any, heights: Any, excess: float, gouge: float) -> None:
    """Gives every point of a cloud its colour."""
    view = drawn.ViewObject
    view.PointSize = 3
    colours = [colour(float(height), excess, gouge) for height in heights]
    try:
        drawn.addProperty("App::PropertyColorList", "Color", "Deviation", "Colour of each point")
        drawn.Color = colours
        view.DisplayMode = "Color"
    except Exception:  # Without colours the points are still there.
        view.ShapeColor = KEPT
