"""Helpers of the native module: pickled objects, and dictionaries as text."""

from __future__ import annotations

import json
from typing import Any, Mapping


def json_text(value: Mapping[str, Any]) -> str:
    """Returns a dictionary of plain values and arrays as JSON."""

    def plain(other: Any) -> Any:
        if hasattr(other, "tolist"):
            return other.tolist()
        if hasattr(other, "__fspath__"):
            return other.__fspath__()
        raise TypeError(f"{type(other).__name__} has no place in a file: {other!r}")

    return json.dumps(_without_none(value), default=plain)


def _without_none(value: Any) -> Any:
    # TOML has no null: a key that is absent says the same.
    if isinstance(value, Mapping):
        return {key: _without_none(one) for key, one in value.items() if one is not None}
    if isinstance(value, (list, tuple)):
        return [_without_none(one) for one in value]
    return value


def machine(text: str, state: dict[str, Any]) -> Any:
    """Rebuilds a machine."""
    from ._trunnion import Machine

    found = Machine.from_toml(text, state["source"])
    return found.with_setup(
        origin=list(state["origin"]),
        rotation=list(state["rotation"]),
        tool_length=state["tool_length"],
    )


def cutter(
    kind: str,
    radii: tuple[float, float],
    side: tuple[float | None, float, float],
    length: float,
    shank: Any,
    inner: float | None,
) -> Any:
    """Rebuilds a cutter."""
    from ._trunnion import Cutter

    (major, minor), (arc, angle, diameter) = radii, side
    more: dict[str, Any] = {"length": length, "shank": shank if len(shank) else None, "inner": inner}
    if kind == "taper":
        return Cutter.taper(minor, angle, diameter, **more)
    if arc is None:
        return Cutter.bull(major, minor, **more)
    if kind == "conical-barrel":
        return Cutter.conical_barrel(minor, arc, angle, diameter, **more)
    return (Cutter.lens if kind == "lens" else Cutter.barrel)(minor, arc, diameter, **more)
