"""Heights of a cut over a part as a mesh: triangles of its faces with what was measured at their corners."""

from __future__ import annotations

from typing import Any, NamedTuple

#: Most corners of a mesh that is drawn.
_MOST_CORNERS = 12_000
#: Chord of the triangles over the diagonal of the part.
_CHORD = 1e-4
#: Measured points this many edges away still belong to a corner.
_REACH = 0.75


class Deviation(NamedTuple):
    """A mesh with heights over the faces.

    Attributes:
        corners, triangles: positions [mm] and their indices, three for each triangle.
        heights: height of the cut over the face at each corner [mm]; NaN where nothing cuts, infinite where nothing
            was measured. Of the points around a corner, the one counts that uses most of its tolerance.
        excess, gouge: tolerances [mm].
    """

    corners: Any
    triangles: Any
    heights: Any
    excess: float
    gouge: float


class Measured(NamedTuple):
    """Measured points [mm] of a run or a check, and their heights [mm]."""

    points: Any
    heights: Any


def joined(maps: Any) -> Measured:
    """Returns the measured points of the maps of a run, one map for each face."""
    import numpy as np

    found = [one for one in maps if len(one["height"])]
    if not found:
        return Measured(np.zeros((0, 3)), np.zeros(0))
    return Measured(*(np.concatenate([one[name] for one in found]) for name in ("point", "height")))


def of_shape(shape: Any, measured: Measured, excess: float, gouge: float) -> Deviation | None:
    """Returns the deviation of a shape, or of some of its faces; None if nothing was measured.

    The shape is triangulated, which changes it: hand over a copy.
    """
    import numpy as np

    if not len(measured.points):
        return None
    vertices, triangles = shape.tessellate(max(_CHORD * shape.BoundBox.DiagonalLength, 1e-4))
    corners = np.array([[one.x, one.y, one.z] for one in vertices], dtype=float)
    spacing = max(float(np.sqrt(shape.Area / len(measured.points))), 1e-6)
    # Halved edges are on average three quarters as long.
    edge = max(2.0 * spacing, float(np.sqrt(6.0 * shape.Area / _MOST_CORNERS)))
    corners, triangles = refined(corners, np.array(triangles, dtype=np.int64), edge)
    heights = _heights(corners, measured, _REACH * max(edge, spacing), (excess, gouge))
    return Deviation(corners, triangles, heights, excess, gouge)


def refined(corners: Any, triangles: Any, edge: float) -> tuple[Any, Any]:
    """Returns the triangles cut until no edge is longer; neighbours cut the edge they share at the same place."""
    import numpy as np

    while True:
        sides = np.sort(np.stack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]], axis=1), axis=2)
        # One number for each pair of corners: rows are sorted ten times more slowly.
        keys, number = np.unique(sides[:, :, 0] * len(corners) + sides[:, :, 1], return_inverse=True)
        pairs = np.stack(np.divmod(keys, len(corners)), axis=1)
        long = np.linalg.norm(corners[pairs[:, 0]] - corners[pairs[:, 1]], axis=1) > edge
        if not long.any():
            return corners, triangles
        middle = np.where(long, len(corners) + np.cumsum(long) - 1, -1)
        corners = np.concatenate([corners, 0.5 * (corners[pairs[long, 0]] + corners[pairs[long, 1]])])
        triangles = _cut(triangles, middle[number.reshape(-1, 3)])


def _cut(triangles: Any, middle: Any) -> Any:
    """Cuts triangles at the middles of their sides, -1 for none."""
    import numpy as np

    pieces = []
    counts = (middle >= 0).sum(axis=1)
    pieces.append(triangles[counts == 0])
    for turn in range(3):
        # Every triangle is turned until its first side is the one that decides the case.
        a, b, c = (triangles[:, (turn + k) % 3] for k in range(3))
        ab, bc, ca = (middle[:, (turn + k) % 3] for k in range(3))

        def add(chosen: Any, *corners: Any) -> None:
            pieces.append(np.stack([corner[chosen] for corner in corners], axis=1))

        one = (counts == 1) & (ab >= 0)
        add(one, a, ab, c)
        add(one, ab, b, c)
        two = (counts == 2) & (ab < 0)
        add(two, c, ca, bc)
        add(two, ca, a, bc)
        add(two, a, b, bc)
        if turn == 0:
            three = counts == 3
            for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
                add(three, *corners)
    return np.concatenate(pieces)


def _heights(corners: Any, measured: Measured, reach: float, tolerances: tuple[float, float]) -> Any:
    import numpy as np

    heights = np.full(len(corners), np.inf)
    near = nearest(corners, measured.points, reach)
    heights[near >= 0] = measured.heights[near[near >= 0]]
    # No measured point is lost between corners: the worst of those around a corner is shown.
    owner = nearest(measured.points, corners, reach)
    kept = (owner >= 0) & np.isfinite(measured.heights)
    owner, found = owner[kept], measured.heights[kept]
    use = np.abs(found) / np.where(found >= 0, *(max(value, 1e-9) for value in tolerances))
    order = np.argsort(use, kind="stable")
    heights[owner[order]] = found[order]
    return heights


def nearest(points: Any, others: Any, reach: float) -> Any:
    """Returns the index of the nearest of the others for each point; -1 where none is in the 27 cubes of `reach` around."""
    import numpy as np

    least = np.minimum(points.min(axis=0), others.min(axis=0)) - reach
    size = np.floor((np.maximum(points.max(axis=0), others.max(axis=0)) - least) / reach).astype(np.int64) + 3

    def key(cells: Any) -> Any:
        return (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2]

    cells = np.floor((points - least) / reach).astype(np.int64)
    keys = key(np.floor((others - least) / reach).astype(np.int64))
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    best = np.full(len(points), np.inf)
    found = np.full(len(points), -1, dtype=np.int64)
    for offset in np.ndindex(3, 3, 3):
        wanted = key(cells + np.array(offset) - 1)
        first, last = np.searchsorted(keys, wanted, "left"), np.searchsorted(keys, wanted, "right")
        open_ones = np.flatnonzero(first < last)
        step = 0
        while open_ones.size:
            candidates = order[first[open_ones] + step]
            distance = np.linalg.norm(points[open_ones] - others[candidates], axis=1)
            closer = distance < best[open_ones]
            best[open_ones[closer]] = distance[closer]
            found[open_ones[closer]] = candidates[closer]
            step += 1
            open_ones = open_ones[first[open_ones] + step < last[open_ones]]
    return found
