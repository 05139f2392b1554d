"""Passes on screen while they are placed, beside the document: nothing of them is saved."""

from __future__ import annotations

from typing import Any

import FreeCADGui

from .. import pictures

#: Most points that are drawn in one look at the work: the window never waits longer for them than a few milliseconds.
_MOST_POINTS = 20_000
_WIDTH = 2.0

#: Passes of a face, as the engine has them.
Passes = list[dict[str, Any]]


class Preview:
    """Passes in the views of a document. `take` may be called from any thread, everything else from that of the window."""

    def __init__(self, document: str, size: float) -> None:
        from pivy import coin

        self._lift = pictures.LIFT * size
        self._newest: dict[int, Passes] = {}
        self._drawn: dict[int, list[tuple[dict[str, Any], Any]]] = {}
        self._root = coin.SoSeparator()
        colour, style, unpicked = coin.SoBaseColor(), coin.SoDrawStyle(), coin.SoPickStyle()
        colour.rgb.setValue(*pictures.PASSES)
        style.lineWidth.setValue(_WIDTH)
        unpicked.style.setValue(coin.SoPickStyle.UNPICKABLE)
        light = coin.SoLightModel()
        light.model.setValue(coin.SoLightModel.BASE_COLOR)
        for node in (light, colour, style, unpicked):
            self._root.addChild(node)
        views = FreeCADGui.getDocument(document).mdiViewsOfType("Gui::View3DInventor")
        self._scenes = [view.getSceneGraph() for view in views]
        for scene in self._scenes:
            scene.addChild(self._root)

    @property
    def count(self) -> int:
        """Number of passes on screen."""
        return sum(map(len, self._drawn.values()))

    def take(self, face: int, passes: Passes) -> None:
        """Takes the passes of a face as far as they are placed."""
        self._newest[face] = passes

    def look(self) -> None:
        """Draws what is new."""
        left = _MOST_POINTS
        for face, passes in list(self._newest.items()):
            drawn = self._drawn.setdefault(face, [])
            # The engine hands over the same pass as long as it stays.
            stay = next((at for at, (old, new) in enumerate(zip(drawn, passes)) if old[0] is not new), min(len(drawn), len(passes)))
            for _, node in drawn[stay:]:
                self._root.removeChild(node)
            del drawn[stay:]
            for one in passes[stay:]:
                if left <= 0:
                    return
                points = pictures.points_of(one, self._lift)
                left -= len(points)
                node = _polyline(points)
                self._root.addChild(node)
                drawn.append((one, node))

    def end(self) -> None:
        """Takes everything away."""
        for scene in self._scenes:
            scene.removeChild(self._root)
        self._scenes, self._drawn = [], {}


def _polyline(points: Any) -> Any:
    from pivy import coin

    node, places, line = coin.SoSeparator(), coin.SoCoordinate3(), coin.SoLineSet()
    places.point.setValues(0, len(points), points.tolist())
    line.numVertices.setValue(len(points))
    node.addChild(places)
    node.addChild(line)
    return node
