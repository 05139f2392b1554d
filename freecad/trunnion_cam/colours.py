"""Colours of deviations, which colour-blind eyes tell apart: blue is too low, orange too high."""

from __future__ import annotations

from typing import Any

GOUGE = (0.00, 0.26, 0.62)
KEPT = (0.84, 0.86, 0.84)
EXCESS = (0.90, 0.45, 0.00)
UNCUT = (0.35, 0.35, 0.38)
#: Places where nothing was measured.
UNKNOWN = (0.62, 0.62, 0.66)

#: A colour is that of its limit from this share of a tolerance on: what is out of tolerance stands out.
_FADE = 0.85


def of_heights(heights: Any, excess: float, gouge: float) -> list[tuple[float, float, float]]:
    """Returns the colours of heights over the face [mm]; NaN where nothing cuts, infinite where nothing was measured."""
    import numpy as np

    heights = np.asarray(heights, dtype=float)
    limit = np.where(heights < 0, max(gouge, 1e-9), max(excess, 1e-9))
    use = np.abs(np.where(np.isfinite(heights), heights, 0.0)) / limit
    share = np.where(use > 1.0, 1.0, _FADE * use)[:, None]
    end = np.where((heights < 0)[:, None], GOUGE, EXCESS)
    found = np.array(KEPT) * (1.0 - share) + end * share
    found[np.isnan(heights)] = UNCUT
    found[np.isinf(heights)] = UNKNOWN
    return [tuple(one) for one in found.tolist()]


def hexadecimal(colour: tuple[float, float, float]) -> str:
    """Returns a colour as pages write it: #rrggbb."""
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour)
