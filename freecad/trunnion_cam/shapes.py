"""Shapes of FreeCAD as STEP, and their faces by the engine's numbers."""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from typing import Any, Iterable, NamedTuple

from .engine import engine
from .problem import Problem
from .translate import translated

#: Chord of the triangles by which faces are recognized, over the diagonal of the part.
_CHORD = 2e-4
#: Share by which areas of a face may differ between both kernels, and its centre, which is that of triangles, over the size.
_ALIKE_AREA, _ALIKE_CENTRE = 5e-3, 3e-2
#: Line of a BREP text with the flags of a shape.
_FLAGS = re.compile(r"^[01]{7}\s*$", re.MULTILINE)


def step_bytes(shape: Any) -> bytes:
    """Returns a shape as a STEP file."""
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, "part.step")
        shape.exportStep(name)
        with open(name, "rb") as file:
            return file.read()


def fingerprint(shape: Any) -> str:
    """Returns a text that changes when the shape does."""
    # Triangles that FreeCAD has drawn meanwhile are no change, nor are the seven flags of what it has looked at.
    plain = _FLAGS.sub("", shape.copy(True, False).exportBrepToString())
    return hashlib.sha256(plain.encode()).hexdigest()


def placed_shape(thing: Any) -> Any:
    """Returns the shape of an object where the document shows it."""
    import Part

    found = Part.getShape(thing)
    if found.isNull():
        raise Problem(
            translated("{label} has no shape", label=thing.Label), translated("recompute the document, or choose another object")
        )
    return found


def selected_faces(selection: Iterable[tuple[Any, Iterable[str]]]) -> tuple[Any, list[str]]:
    """Returns the object and the names of its selected faces.

    Args:
        selection: objects with the names of their selected elements, as `Gui.Selection.getSelectionEx` has them.
    """
    chosen = [(thing, list(names)) for thing, names in selection]
    if not chosen:
        raise Problem(translated("nothing is selected"), translated("select the faces to finish, of one body"))
    for thing, _ in chosen:
        if thing.isDerivedFrom("Mesh::Feature"):
            raise Problem(
                translated("{label} is a mesh, which has no surfaces", label=thing.Label),
                translated("select faces of a solid, or convert the mesh to one"),
            )
        if thing.isDerivedFrom("Sketcher::SketchObject") or thing.isDerivedFrom("Part::Part2DObject"):
            raise Problem(
                translated("{label} is a sketch, which has no faces to cut", label=thing.Label), translated("select faces of a solid")
            )
        if not hasattr(thing, "Shape"):
            raise Problem(translated("{label} has no shape", label=thing.Label), translated("select faces of a solid"))
    if len(chosen) > 1:
        labels = ", ".join(thing.Label for thing, _ in chosen)
        raise Problem(
            translated("faces of {count} bodies are selected: {labels}", count=len(chosen), labels=labels),
            translated("select faces of one body; give each body an operation of its own"),
        )
    thing, names = chosen[0]
    faces = [name for name in names if name.startswith("Face")]
    if not faces:
        other = ", ".join(names) or translated("the whole body")
        raise Problem(
            translated("no face is selected, but {other} of {label}", other=other, label=thing.Label), translated("select faces of the body")
        )
    return thing, faces


class FaceMark(NamedTuple):
    """What a face of FreeCAD is recognized by: its place in the part, its area [mm2] and its centre [mm]."""

    name: str
    index: int
    area: float
    centre: tuple[float, float, float]


def face_marks(shape: Any, names: Iterable[str]) -> list[FaceMark]:
    """Returns the marks of faces that FreeCAD names `Face1`, `Face2`, .."""
    marks = []
    for name in names:
        index = int(name.removeprefix("Face"))
        if not 1 <= index <= len(shape.Faces):
            raise Problem(
                translated("{name} is no face of the part, which has {count}", name=name, count=len(shape.Faces)),
                translated("select the faces anew: the model has changed"),
            )
        face = shape.Faces[index - 1]
        marks.append(FaceMark(name, index, float(face.Area), tuple(face.CenterOfMass)))
    return marks


def face_numbers(step: bytes, marks: list[FaceMark], size: float) -> list[int]:
    """Returns the engine's numbers of faces in a STEP file; `size` is the diagonal of the part [mm].

    Both kernels read the same file, but may count differently: a face is recognized by its area and its centre.
    """
    import numpy as np

    part = engine().Part.read(step)
    chord = max(_CHORD * size, 1e-6)
    known = [(face.number, float(face.area), _centre(*face.mesh(chord))) for face in part.faces]
    numbers = []
    for mark in marks:

        def unlike(one: tuple[int, float, Any], mark: FaceMark = mark) -> tuple[float, float, int]:
            number, area, middle = one
            aside = abs(area - mark.area) / max(mark.area, 1e-12)
            off = float(np.linalg.norm(middle - np.array(mark.centre))) / size
            # Of equals, the face at the same place in the file.
            return (float(aside > _ALIKE_AREA), round(off, 5), abs(number - mark.index))

        best = min(known, key=unlike, default=None)
        if best is None or unlike(best)[0] or unlike(best)[1] > _ALIKE_CENTRE:
            raise Problem(
                translated("{name} is not among the {count} faces that the engine reads of the part", name=mark.name, count=len(known)),
                translated("check the part with Part > Check geometry"),
            )
        numbers.append(best[0])
    return sorted(set(numbers))


def _centre(vertices: Any, triangles: Any) -> Any:
    import numpy as np

    if not len(triangles):
        return np.full(3, np.inf)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return ((a + b + c) / 3 * areas[:, None]).sum(axis=0) / max(float(areas.sum()), 1e-300)
