"""Views of the objects in the document: icons, what a double click opens, and the legend of a deviation."""

from __future__ import annotations

import os
from typing import Any

from .. import colours
from ..translate import translated
from ..units import length_text

_ICONS = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "resources", "icons"))


def icon(name: str) -> str:
    """Returns the file of an icon."""
    return os.path.join(_ICONS, f"{name}.svg")


class View:
    """What all views have in common."""

    ICON = ""

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def attach(self, view: Any) -> None:
        """Called by FreeCAD when the view is made or read."""
        self.Object = view.Object

    def getIcon(self) -> str:
        """Icon in the tree."""
        return icon(self.ICON)

    def dumps(self) -> None:
        """Nothing of the view is saved."""

    def loads(self, state: Any) -> None:
        """Nothing of the view was saved."""

    __getstate__, __setstate__ = dumps, loads


class FinishView(View):
    """View of a five-axis finish: pictures stand under it and go with it; a double click opens its panel."""

    ICON = "finish"

    def claimChildren(self) -> list[Any]:
        """Objects under the operation in the tree."""
        return list(self.Object.Pictures)

    def doubleClicked(self, view: Any) -> bool:
        """Opens the panel."""
        from . import panels

        panels.show_operation(view.Object)
        return True

    def onDelete(self, view: Any, names: Any) -> bool:
        """Takes the pictures away with the operation."""
        from .. import pictures

        pictures.remove(view.Object)
        return True


class MachineView(View):
    """View of the machine of a job; a double click opens its panel."""

    ICON = "machine"

    def doubleClicked(self, view: Any) -> bool:
        """Opens the panel."""
        from . import panels

        panels.show_machine(view.Object.Job)
        return True


class DeviationView(View):
    """View of a coloured mesh, with its legend in the corner of the window while it is shown."""

    ICON = "check"

    def __init__(self, view: Any) -> None:
        super().__init__(view)
        view.Lighting = "Two side"
        view.Coloring = True
        self.onChanged(view, "Visibility")

    def attach(self, view: Any) -> None:
        """Called by FreeCAD when the view is made or read."""
        from pivy import coin

        super().attach(view)
        # The faces of the part lie in the same place: the mesh is drawn in front of them.
        offset = coin.SoPolygonOffset()
        offset.factor.setValue(-1.0)
        offset.units.setValue(-1.0)
        view.RootNode.insertChild(offset, 0)
        # The colours are those of the legend, whatever side the light comes from.
        light = coin.SoLightModel()
        light.model.setValue(coin.SoLightModel.BASE_COLOR)
        view.RootNode.insertChild(light, 0)
        self.legend = coin.SoSwitch()
        self.legend.addChild(legend(view.Object.Label, float(view.Object.Excess.Value), float(view.Object.Gouge.Value)))
        view.RootNode.addChild(self.legend)
        self.onChanged(view, "Visibility")

    def onChanged(self, view: Any, name: str) -> None:
        """Shows the legend with the mesh; of several meshes, that of the last one."""
        if name != "Visibility" or not hasattr(self, "legend"):
            return
        views = [one.ViewObject for one in view.Object.Document.Objects if isinstance(getattr(one.ViewObject, "Proxy", None), DeviationView)]
        shown = [one for one in views if one.Visibility and hasattr(one.Proxy, "legend")]
        for one in views:
            if hasattr(one.Proxy, "legend"):
                one.Proxy.legend.whichChild.setValue(0 if shown and one == shown[-1] else -1)


def entries(excess: float, gouge: float) -> list[tuple[tuple[float, float, float], str]]:
    """Returns colours and words of a legend, from high to low; tolerances in mm, words in the user's units."""
    high, low = length_text(excess), length_text(-gouge)
    return [
        (colours.EXCESS, translated("excess, more than {limit}", limit=high)),
        (colours.of_heights([0.999 * excess], excess, gouge)[0], translated("up to {limit}", limit=high)),
        (colours.KEPT, translated("on the face")),
        (colours.of_heights([-0.999 * gouge], excess, gouge)[0], translated("down to {limit}", limit=low)),
        (colours.GOUGE, translated("gouge, below {limit}", limit=low)),
        (colours.UNCUT, translated("not cut")),
        (colours.UNKNOWN, translated("not measured")),
    ]


def legend_page(excess: float, gouge: float) -> str:
    """Returns the legend for a label of a panel."""
    lines = [
        f'<span style="background-color:{colours.hexadecimal(shade)}">&nbsp;&nbsp;&nbsp;&nbsp;</span>&nbsp;{text}'
        for shade, text in entries(excess, gouge)
    ]
    return "<br>".join(lines)


def legend(title: str, excess: float, gouge: float) -> Any:
    """Returns the legend as a scene in front of everything else: a plate with words, which can be read over every background."""
    from pivy import coin

    # Nodes of this type count neither for the size of the scene nor for its light.
    kind = coin.SoType.fromName("SoSkipBoundingGroup")
    root = kind.createInstance() if not kind.isBad() else coin.SoSeparator()
    scene = coin.SoSeparator()
    root.addChild(scene)
    camera = coin.SoOrthographicCamera()
    camera.viewportMapping.setValue(coin.SoCamera.LEAVE_ALONE)
    camera.aspectRatio.setValue(1.0)
    camera.height.setValue(2.0)
    camera.position.setValue(0.0, 0.0, 1.0)
    camera.nearDistance.setValue(0.1)
    camera.farDistance.setValue(2.0)
    depth = coin.SoDepthBuffer()
    depth.test.setValue(False)
    unpicked = coin.SoPickStyle()
    unpicked.style.setValue(coin.SoPickStyle.UNPICKABLE)
    place = coin.SoTranslation()
    place.translation.setValue(-0.97, 0.96, 0.0)
    image = coin.SoImage()
    image.vertAlignment.setValue(coin.SoImage.TOP)
    plate = legend_plate(title, excess, gouge)
    image.image.setValue(coin.SbVec2s(plate.width(), plate.height()), _CHANNELS, bytes(plate.constBits()))
    for node in (coin.SoResetTransform(), camera, depth, unpicked, place, image):
        scene.addChild(node)
    return root


#: Bytes of a pixel.
_CHANNELS = 4
_INK = "#0d0d0d"
_PLATE = "#f5f5f5"
_EDGE = 8


def legend_plate(title: str, excess: float, gouge: float) -> Any:
    """Returns the plate of the legend as an image of Qt: red, green, blue and opacity of each pixel, row by row from below."""
    from PySide import QtCore, QtGui

    font = QtGui.QFont()
    font.setPixelSize(13)
    rows = entries(excess, gouge)
    metrics = QtGui.QFontMetrics(font)
    row, swatch = metrics.height() + 4, 2 * metrics.height()
    widths = [metrics.boundingRect(title).width(), *(swatch + _EDGE + metrics.boundingRect(text).width() for _, text in rows)]
    image = QtGui.QImage(max(widths) + 3 * _EDGE, row * (len(rows) + 1) + 2 * _EDGE, QtGui.QImage.Format_RGBA8888)
    image.fill(QtGui.QColor(_PLATE))
    painter = QtGui.QPainter(image)
    painter.setFont(font)
    painter.setPen(QtGui.QColor(_INK))
    left = QtCore.Qt.AlignLeft | QtCore.Qt.AlignVCenter
    painter.drawText(QtCore.QRect(_EDGE, _EDGE, image.width(), row), left, title)
    for index, (shade, text) in enumerate(rows, 1):
        top = _EDGE + index * row
        painter.fillRect(_EDGE, top + 2, swatch, row - 4, QtGui.QColor(colours.hexadecimal(shade)))
        painter.drawText(QtCore.QRect(2 * _EDGE + swatch, top, image.width(), row), left, text)
    painter.end()
    # Rows of Qt begin at the top.
    return image.mirrored()


KINDS = {"finish": FinishView, "machine": MachineView, "deviation": DeviationView}
