"""Passes and deviation as objects of the document."""

from __future__ import annotations

from typing import Any

#: Most points of one pass that are drawn.
_MOST_POINTS = 2000


def draw(obj: Any, result: Any) -> None:
    """Draws the passes and the measured points of a result; pictures of an earlier one are replaced."""
    document = obj.Document
    for old in list(obj.Pictures):
        document.removeObject(old.Name)
    obj.Pictures = [one for one in (_passes(obj, result), _deviation(obj, result)) if one is not None]
    for one in obj.Pictures:
        # They are made within a recompute, which does not come to them any more.
        one.purgeTouched()


def _passes(obj: Any, result: Any) -> Any:
    import FreeCAD
    import Part

    wires = []
    for one in result.passes:
        tips = one["tip"][:: max(1, len(one["tip"]) // _MOST_POINTS)]
        points = [FreeCAD.Vector(*tip) for tip in tips]
        points = [point for index, point in enumerate(points) if index == 0 or point.distanceToPoint(points[index - 1]) > 1e-6]
        if len(points) > 1:
            wires.append(Part.makePolygon(points))
    if not wires:
        return None
    drawn = obj.Document.addObject("Part::Feature", "Passes")
    drawn.Shape = Part.Compound(wires)
    drawn.Label = f"Passes of {obj.Label}"
    if FreeCAD.GuiUp:
        drawn.ViewObject.LineColor = (0.12, 0.47, 0.71)
        # The path itself would be drawn as if the rotaries stood still.
        obj.ViewObject.Visibility = False
    return drawn


def _deviation(obj: Any, result: Any) -> Any:
    import FreeCAD
    import numpy as np
    import Points

    maps = [one for one in result.maps if len(one["point"])]
    if not maps:
        return None
    points = np.concatenate([one["point"] for one in maps])
    heights = np.concatenate([one["height"] for one in maps])
    drawn = obj.Document.addObject("Points::FeaturePython", "Deviation")
    drawn.Points = Points.Points([FreeCAD.Vector(*point) for point in points.tolist()])
    drawn.Label = f"Deviation of {obj.Label}"
    drawn.addProperty("App::PropertyFloatList", "Height", "Deviation", "Height over the face, mm; negative is a gouge")
    drawn.Height = np.where(np.isfinite(heights), heights, 1e3).tolist()
    if FreeCAD.GuiUp:
        from .gui import colours

        colours.show(drawn, heights, float(obj.Excess.Value), float(obj.Gouge.Value))
    return drawn
