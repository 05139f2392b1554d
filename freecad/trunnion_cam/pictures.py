"""Passes and deviation as objects of the document."""

from __future__ import annotations

from typing import Any, Callable, NamedTuple

from . import colours
from .deviation import Deviation
from .translate import described, translated

#: Most points of one pass that are drawn.
_MOST_POINTS = 2000
PASSES = (0.12, 0.47, 0.71)
#: Passes are drawn this much above where they are, along the tool, over their extent: they would sink into the mesh.
LIFT = 2e-3


class Drawn(NamedTuple):
    """Pictures that are not in the document yet: wires of the passes, the mesh and the colours of its corners; or None."""

    passes: Any
    mesh: Any
    colours: list[tuple[float, float, float]]
    deviation: Deviation | None


def drawn(passes: list[dict[str, Any]], deviation: Deviation | None) -> Drawn:
    """Makes the pictures of a result; runs beside the window."""
    import FreeCAD
    import Mesh
    import Part

    import numpy as np

    wires = []
    tips = np.concatenate([one["tip"] for one in passes]) if passes else np.zeros((1, 3))
    lift = LIFT * float(np.linalg.norm(np.ptp(tips, axis=0)))
    for one in passes:
        points = [FreeCAD.Vector(*tip) for tip in points_of(one, lift)]
        points = [point for index, point in enumerate(points) if index == 0 or point.distanceToPoint(points[index - 1]) > 1e-6]
        if len(points) > 1:
            wires.append(Part.makePolygon(points))
    mesh, shades = None, []
    if deviation is not None:
        corners = [FreeCAD.Vector(*corner) for corner in deviation.corners.tolist()]
        mesh = Mesh.Mesh((corners, [tuple(one) for one in deviation.triangles.tolist()]))
        shades = colours.of_heights(deviation.heights, deviation.excess, deviation.gouge)
    return Drawn(Part.Compound(wires) if wires else None, mesh, shades, deviation)


def points_of(one: dict[str, Any], lift: float) -> Any:
    """Returns the points of a pass that are drawn, (n, 3): each `lift` mm along the tool above its tip."""
    step = max(1, len(one["tip"]) // _MOST_POINTS)
    return one["tip"][::step] + lift * one["axis"][::step]


def steps(obj: Any, found: Drawn) -> list[Callable[[], None]]:
    """Returns what puts the pictures of an operation into the document, in pieces; those of an earlier result are replaced."""

    def keep(picture: Any) -> None:
        obj.Pictures = [*obj.Pictures, picture]
        # It is made within a recompute, which does not come to it any more.
        picture.purgeTouched()

    def passes() -> None:
        remove(obj)
        if obj.ViewObject is not None:
            # The path itself would be drawn as if the rotaries stood still.
            obj.ViewObject.Visibility = False
        if found.passes is not None:
            keep(_passes(obj, found.passes))

    def mesh() -> None:
        if found.mesh is not None:
            keep(add_deviation(obj.Document, found, translated("Deviation of {label}", label=obj.Label)))

    return [passes, mesh]


def remove(obj: Any) -> None:
    """Takes the pictures of an operation away."""
    for old in list(obj.Pictures):
        obj.Document.removeObject(old.Name)


def _passes(obj: Any, wires: Any) -> Any:
    picture = obj.Document.addObject("Part::Feature", "Passes")
    picture.Shape = wires
    picture.Label = translated("Passes of {label}", label=obj.Label)
    if picture.ViewObject is not None:
        picture.ViewObject.LineColor = PASSES
    return picture


class DeviationMesh:
    """Proxy of a coloured mesh; its heights are its own, for scripts."""

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        group = "Deviation"
        obj.addProperty("App::PropertyFloatList", "Height", group, described("Height over the face at each corner, mm; negative is a gouge"))
        obj.addProperty("App::PropertyLength", "Excess", group, described("Largest excess after everything"))
        obj.addProperty("App::PropertyLength", "Gouge", group, described("Deepest gouge after everything"))
        obj.addProperty("App::PropertyColorList", "Colours", group, described("Colour of each corner"))

    def execute(self, obj: Any) -> None:
        """Nothing is computed here."""

    def onDocumentRestored(self, obj: Any) -> None:
        """Called by FreeCAD when a document was read."""
        show_view(obj, "deviation")

    def dumps(self) -> None:
        """Nothing of the proxy is saved."""

    def loads(self, state: Any) -> None:
        """Nothing of the proxy was saved."""

    __getstate__, __setstate__ = dumps, loads


def add_deviation(document: Any, found: Drawn, label: str, name: str = "Deviation") -> Any:
    """Adds a coloured mesh to a document, and returns it."""
    picture = document.addObject("Mesh::FeaturePython", name)
    DeviationMesh(picture)
    picture.Label = label
    picture.Excess, picture.Gouge = found.deviation.excess, found.deviation.gouge
    picture.Height = found.deviation.heights.tolist()
    picture.Mesh = found.mesh
    picture.Colours = found.colours
    show_view(picture, "deviation")
    return picture


def show_view(obj: Any, kind: str) -> None:
    """Gives an object its view, where there is a window: "deviation", "finish" or "machine"."""
    if obj.ViewObject is None:
        return
    from .gui import views

    if not isinstance(obj.ViewObject.Proxy, views.KINDS[kind]):
        views.KINDS[kind](obj.ViewObject)
