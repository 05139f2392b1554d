"""Cutters lowered along z on triangles."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _options, _picture
from ._locate import faces_of
from ._path import floats
from ._progress import Progress, adapted
from ._result import Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._trunnion import Cutter


class DropResult(Table):
    """Cutters lowered at many places.

    Attributes:
        z: height of the tip, NaN where nothing lies below, (n,) [mm].
        tip: tips, (n, 3) [mm].
        contact: points that are touched, (n, 3) [mm].
        triangle: index of the triangle that is touched, -1 for none, (n,).
        deviation: upper bound on the distance between triangles and shape [mm]: 0 for triangles, None if there is none.
        bounds: heights between which the tip on the shape itself lies, (n, 2) [mm]; None unless they were asked for.

    `numpy.asarray(result)` is `z`.
    """

    _columns = ("tip", "contact", "triangle")

    def __init__(self, places: Any, found: dict[str, Any]) -> None:
        self._places = places
        self.z: NDArray[np.float64] = found["z"]
        self.contact: NDArray[np.float64] = found["contact"]
        self.triangle: NDArray[np.int64] = found["triangle"]
        self.deviation: float | None = found["deviation"]
        self.bounds: NDArray[np.float64] | None = found.get("bounds")

    @property
    def tip(self) -> "NDArray[np.float64]":
        """Tips of the cutter, (n, 3) [mm]."""
        import numpy as np

        return np.column_stack([self._places, self.z])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        import numpy as np

        return np.array(self.z, dtype=dtype) if copy else np.asarray(self.z, dtype=dtype)

    def __len__(self) -> int:
        return len(self.z)

    def __repr__(self) -> str:
        return f"DropResult({len(self)} places, deviation={self.deviation})"

    def _repr_html_(self) -> str:
        import numpy as np

        touched = self.z[np.isfinite(self.z)]
        span = f"tip from {touched.min():.4f} to {touched.max():.4f} mm" if touched.size else "nothing below"
        return _picture.heights(f"{len(self)} places, {span}", self._places, self.z)


@_options.pythonic
def drop_cutter(
    shape: Any,
    cutter: "Cutter",
    points: "ArrayLike",
    *,
    chord: float = 0.01,
    bounds: bool = False,
    progress: Progress = None,
) -> DropResult:
    """Lowers a cutter along z at many places until it touches a shape.

    The contact is found in closed form on facets, and on edges to rounding. Only the cutting end counts: above it the
    cutter is a cylinder.

    Args:
        shape: triangles as (vertices (v, 3), corners (t, 3)), an STL or STEP file, a Part, a Face or several.
        cutter: the cutter, of any kind.
        points: places, (n, 2) or (n, 3) of which z is ignored [mm].
        chord: largest distance of the triangles from faces [mm]; what is reached stands in `deviation`.
        bounds: also return guaranteed bounds of the height on the faces themselves, at three times the cost.
        progress: callable of (stage, done, total), or tqdm.

    Raises:
        InputError: the shape cannot be read or used.

    Example:
        >>> import trunnion
        >>> square = ([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], [[0, 1, 2], [0, 2, 3]])
        >>> trunnion.drop_cutter(square, trunnion.Cutter.ball(6), [[4, 4], [-1, 4], [-9, 4]]).z.round(6).tolist()
        [0.0, -0.171573, nan]
    """
    from . import _trunnion
    from ._trunnion import Face, Part

    bound = 0.0
    if isinstance(shape, (str, os.PathLike)):
        shape = Part.read(_options.path("shape", shape))
    if isinstance(shape, Part) and not len(shape):
        # The triangles of an STL file.
        shape = shape.mesh()
    many = isinstance(shape, (tuple, list))
    if isinstance(shape, (Part, Face)) or (many and len(shape) and isinstance(shape[0], Face)):
        shape, bound = faces_of(shape), float(_options.number("chord", chord))
    elif many and len(shape) == 2:
        shape = tuple(shape)
    else:
        from ._errors import ArgumentError

        kind = type(shape).__name__
        raise ArgumentError(
            f"shape = {kind} is no shape\n  help: give (vertices, triangles), a Part, or a file", "shape", None, kind
        )
    places = floats("points", points)
    found = _trunnion.drop_cutter(shape, _options.as_cutter(cutter), places, bound, bounds, adapted(progress))
    return DropResult(places[:, :2], found)
