"""Parts that the tests build, and jobs on them."""

from __future__ import annotations

import importlib
import json
import math
import os
import sys
from typing import Any

FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
for place in (FOLDER, *filter(None, os.environ.get("TRUNNION_SITE", "").split(os.pathsep))):
    if place not in sys.path:
        sys.path.append(place)

import FreeCAD  # noqa: E402
import Part  # noqa: E402

from trunnion_cam import compat, machines  # noqa: E402


def bump() -> tuple[Any, list[str]]:
    """A block of 40 x 30 mm with a bump on top; returns its shape and the names of the faces to finish."""
    poles = [
        [FreeCAD.Vector(20.0 * (i - 1.5) / 1.5, 15.0 * (j - 1.5) / 1.5, 13.0 if 0 < i < 3 and 0 < j < 3 else 10.0) for j in range(4)]
        for i in range(4)
    ]
    return _block_below(poles, 0.0)


def patch() -> tuple[Any, list[str]]:
    """The Bezier patch of the examples, 120 x 120 mm, on a block."""
    with open(os.path.join(os.path.dirname(FOLDER), "fixtures", "bezier-patch", "patch.json"), encoding="utf-8") as file:
        net = json.load(file)["points"]
    return _block_below([[FreeCAD.Vector(*point) for point in row] for row in net], -50.0)


def _block_below(poles: list[list[Any]], floor: float) -> tuple[Any, list[str]]:
    """A block from a bicubic patch of 4 x 4 poles, whose edges lie in the planes of a box, down to z = floor."""
    surface = Part.BSplineSurface()
    surface.buildFromPolesMultsKnots(poles, [4, 4], [4, 4], [0, 1], [0, 1], False, False, 3, 3)
    top = surface.toShape()
    faces = [top]
    for edge in top.Edges:
        ends = [vertex.Point for vertex in edge.Vertexes]
        down = [FreeCAD.Vector(end.x, end.y, floor) for end in ends]
        wire = Part.Wire(Part.__sortEdges__([edge, Part.makeLine(ends[0], down[0]), Part.makeLine(down[0], down[1]), Part.makeLine(down[1], ends[1])]))
        faces.append(Part.Face(wire))
    corners = [FreeCAD.Vector(pole.x, pole.y, floor) for pole in (poles[0][0], poles[3][0], poles[3][3], poles[0][3], poles[0][0])]
    faces.append(Part.Face(Part.makePolygon(corners)))
    shell = Part.Shell(faces)
    shell.sewShape()
    solid = Part.Solid(shell)
    return solid, [name_of(solid, lambda face: type(face.Surface).__name__ == "BSplineSurface")]


def dome() -> tuple[Any, list[str]]:
    """A cylinder of 30 mm with a spherical cap of 40 mm radius."""
    cap = Part.makeSphere(40.0, FreeCAD.Vector(0, 0, -20)).common(Part.makeCylinder(15.0, 60.0, FreeCAD.Vector(0, 0, -5)))
    return cap, [name_of(cap, lambda face: type(face.Surface).__name__ == "Sphere")]


def plate() -> tuple[Any, list[str]]:
    """A plate of 40 x 30 x 8 mm."""
    box = Part.makeBox(40.0, 30.0, 8.0, FreeCAD.Vector(-20, -15, 0))
    return box, [name_of(box, lambda face: face.CenterOfMass.z > 7.9)]


def pocketed() -> tuple[Any, list[str]]:
    """A block of 60 x 40 x 20 mm with a pocket and a hole through it; returns its shape, and the names of floor and hole."""
    block = Part.makeBox(60.0, 40.0, 20.0, FreeCAD.Vector(-30, -20, 0))
    block = block.cut(Part.makeBox(30.0, 16.0, 8.0, FreeCAD.Vector(-20, -8, 12))).cut(Part.makeCylinder(5.0, 30.0, FreeCAD.Vector(20, 0, -1)))
    floor = name_of(block, lambda face: abs(face.CenterOfMass.z - 12.0) < 1e-6)
    return block, [floor, name_of(block, lambda face: type(face.Surface).__name__ == "Cylinder")]


def ordinary(job: Any, kind: str, faces: list[str]) -> Any:
    """Adds an operation of FreeCAD's own to a job, computed: Profile, PocketShape, Drilling; without faces of the whole model."""
    try:
        module = importlib.import_module(f"Path.Op.{kind}")
    except ImportError:
        module = importlib.import_module(f"PathScripts.Path{kind}")
    operation = module.Create(kind)
    if faces:
        operation.Base = [(job.Model.Group[0], faces)]
    operation.ToolController = compat.controllers(job)[0]
    job.Document.recompute()
    return operation


def wedge() -> tuple[Any, list[str]]:
    """A block of 40 x 30 mm with a level top and a slope of 15 degrees; returns its shape, and the names of top and slope."""
    drop = 20.0 * math.tan(math.radians(15.0))
    profile = [(-20, 0), (20, 0), (20, 10 - drop), (0, 10), (-20, 10), (-20, 0)]
    outline = Part.Face(Part.makePolygon([FreeCAD.Vector(x, -15, z) for x, z in profile]))
    block = outline.extrude(FreeCAD.Vector(0, 30, 0))
    top = name_of(block, lambda face: face.CenterOfMass.z > 9.99)
    slope = name_of(block, lambda face: 5.5 < face.CenterOfMass.z < 9.9 and face.normalAt(0, 0).z > 0.5)
    return block, [top, slope]


def fcm() -> str:
    """A machine of FreeCAD with a tilting table, as its machine editor writes it: without acceleration and jerk."""
    axes = {
        name: {"type": "linear", "role": "head_linear", "joint": {"origin": [0, 0, 0], "axis": axis}, "limits": {"min": -500, "max": 500}, "max_velocity": 18000}
        for name, axis in (("X", [1, 0, 0]), ("Y", [0, 1, 0]), ("Z", [0, 0, 1]))
    }
    axes["A"] = {"type": "rotary", "role": "table_rotary", "parent": None, "joint": {"origin": [0, 0, 50], "axis": [1, 0, 0]}, "limits": {"min": -120, "max": 30}, "max_velocity": 3600}
    axes["C"] = {"type": "rotary", "role": "table_rotary", "parent": "A", "joint": {"origin": [0, 0, 0], "axis": [0, 0, 1]}, "limits": {"min": -360, "max": 360}, "max_velocity": 7200}
    return json.dumps({"machine": {"name": "T", "axes": axes}})


def name_of(shape: Any, wanted: Any) -> str:
    """Returns the name of the face that a condition holds for."""
    found = [index for index, face in enumerate(shape.Faces, 1) if wanted(face)]
    assert len(found) == 1, found
    return f"Face{found[0]}"


def document(shape: Any, tool: str = "ballend", diameter: float = 8.0) -> tuple[Any, Any]:
    """A document with a body, a job, a tool and a machine; returns the job and the body."""
    doc = FreeCAD.newDocument("trunnion")
    body = doc.addObject("Part::Feature", "Body")
    body.Shape = shape
    doc.recompute()
    job = compat.create_job("Job", [body])
    bit = compat.create_bit(tool)
    bit.Diameter = diameter
    controller = compat.controllers(job)[0]
    controller.Tool = bit
    controller.HorizFeed = 50.0
    controller.VertFeed = 10.0
    controller.SpindleSpeed = 6000.0
    machine = machines.create(job, "bc-trunnion")
    machine.Origin = FreeCAD.Vector(-381, -254, -515)
    doc.recompute()
    return job, body
