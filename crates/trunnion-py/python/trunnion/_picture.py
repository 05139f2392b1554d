"""Small SVG pictures for notebooks, without a plotting library."""

from __future__ import annotations

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Mapping, Sequence

_COLOURS = ("#2f6f9f", "#c0562f", "#4b8b3b", "#7a5195", "#b08a1e", "#555555")
_WIDTH, _HEIGHT, _EDGE = 640.0, 220.0, 34.0
#: Points of a line: more are below a pixel.
_POINTS = 1200


def chart(title: str, x: Any, lines: Mapping[str, Any], level: float | None = None) -> str:
    """Returns a line chart; `level` is drawn across it."""
    import numpy as np

    x = np.asarray(x, dtype=float)
    values = {name: np.asarray(line, dtype=float) for name, line in lines.items()}
    finite = [line[np.isfinite(line)] for line in values.values()]
    every = np.concatenate([*finite, [0.0 if level is None else level]])
    low, high = float(every.min()), float(every.max())
    low, high = (low - 1.0, high + 1.0) if high <= low else (low, high)
    left, right = (float(x.min()), float(x.max())) if x.size else (0.0, 1.0)
    right = right if right > left else left + 1.0
    step = max(1, -(-x.size // _POINTS))

    def across(values: Any) -> Any:
        return _EDGE + (values - left) / (right - left) * (_WIDTH - 2 * _EDGE)

    def up(values: Any) -> Any:
        return _HEIGHT - _EDGE - (values - low) / (high - low) * (_HEIGHT - 2 * _EDGE)

    parts = [_open(_HEIGHT), _text(_EDGE, 18, title, "bold")]
    for value in (low, high):
        parts.append(_text(2, float(up(value)) + 4, f"{value:.4g}"))
    for value in (left, right):
        parts.append(_text(float(across(value)) - 8, _HEIGHT - 14, f"{value:.4g}"))
    if level is not None:
        y = float(up(level))
        parts.append(
            f'<line x1="{_EDGE}" x2="{_WIDTH - _EDGE}" y1="{y:.1f}" y2="{y:.1f}" stroke="#999" stroke-dasharray="4 3"/>'
        )
    for index, (name, line) in enumerate(values.items()):
        colour = _COLOURS[index % len(_COLOURS)]
        px, py = across(x[::step]), up(line[::step])
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(px, py) if np.isfinite(b))
        parts.append(f'<polyline fill="none" stroke="{colour}" points="{points}"/>')
        parts.append(_text(_WIDTH - _EDGE - 70, 18 + 14 * index, name, "normal", colour))
    return "".join(parts) + "</svg>"


def path(title: str, tip: Any, axis: Any) -> str:
    """Returns tips seen along -y, +x and -z from above: the plan view, with tool axes as short strokes."""
    import numpy as np

    tip, axis = np.asarray(tip, dtype=float), np.asarray(axis, dtype=float)
    if not tip.size:
        return _open(40) + _text(4, 24, f"{title}: no cutter locations") + "</svg>"
    step = max(1, -(-len(tip) // _POINTS))
    tip, axis = tip[::step], axis[::step]
    low, high = tip[:, :2].min(axis=0), tip[:, :2].max(axis=0)
    size = float(max(high - low)) or 1.0
    height = 320.0
    scale = (height - 2 * _EDGE) / size

    def at(points: Any) -> Any:
        x = _EDGE + (points[:, 0] - low[0]) * scale
        y = height - _EDGE - (points[:, 1] - low[1]) * scale
        return np.stack([x, y], axis=1)

    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at(tip))
    parts = [_open(height), _text(_EDGE, 18, title, "bold")]
    parts.append(f'<polyline fill="none" stroke="{_COLOURS[0]}" points="{line}"/>')
    few = slice(None, None, max(1, len(tip) // 80))
    for (x, y), (u, v) in zip(at(tip[few]), at(tip[few] + axis[few] * 0.1 * size)):
        parts.append(
            f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="{_COLOURS[1]}"/>'
        )
    return "".join(parts) + "</svg>"


def heights(title: str, points: Any, z: Any) -> str:
    """Returns places seen from above, the lowest blue and the highest orange; those without a height as small crosses."""
    import numpy as np

    points, z = np.asarray(points, dtype=float), np.asarray(z, dtype=float)
    step = max(1, -(-len(points) // _POINTS))
    points, z = points[::step], z[::step]
    if not len(points):
        return _open(40) + _text(4, 24, f"{title}: no places") + "</svg>"
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(max(high - low)) or 1.0
    height = 320.0
    x, y = ((points - low) * ((height - 2 * _EDGE) / size)).T
    x, y = _EDGE + x, height - _EDGE - y
    cut = np.isfinite(z)
    least, most = (float(z[cut].min()), float(z[cut].max())) if cut.any() else (0.0, 0.0)
    share = (z - least) / ((most - least) or 1.0)
    parts = [_open(height), _text(_EDGE, 18, title, "bold")]
    for across, up, part in zip(x.tolist(), y.tolist(), share.tolist()):
        if part == part:
            red, green, blue = (round(a + part * (b - a)) for a, b in zip((47, 111, 159), (224, 122, 47)))
            parts.append(f'<circle cx="{across:.1f}" cy="{up:.1f}" r="3" fill="#{red:02x}{green:02x}{blue:02x}"/>')
        else:
            parts.append(_text(across - 2, up + 3, "x", colour="#999"))
    return "".join(parts) + "</svg>"


def table(rows: Sequence[tuple[str, object]]) -> str:
    """Returns rows of a name and a value."""
    body = "".join(
        f"<tr><th style='text-align:left'>{_escaped(name)}</th><td>{_escaped(str(value))}</td></tr>"
        for name, value in rows
    )
    return f"<table>{body}</table>"


def _escaped(words: str) -> str:
    # Imported with the first picture: it takes a tenth of the time of the whole package.
    import html

    return html.escape(words)


def _open(height: float) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH:.0f}" height="{height:.0f}" '
        'font-family="sans-serif" font-size="11">'
    )


def _text(x: float, y: float, words: str, weight: str = "normal", colour: str = "#333") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" font-weight="{weight}" fill="{colour}">{_escaped(words)}</text>'
