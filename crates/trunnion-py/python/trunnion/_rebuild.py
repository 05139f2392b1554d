"""Helpers of the native module: pickled objects, and dictionaries as text."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping

from ._errors import InputError

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def plain(value: Any) -> Any:
    """Returns dictionaries of values and arrays as dicts and lists of truth values, numbers and texts.

    TOML has no null: a key whose value is None is left out, which says the same.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items() if one is not None}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, (bool, int, float, str)):
        return value
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if hasattr(value, "__fspath__"):
        return os.fsdecode(value)
    raise TypeError(f"{type(value).__name__} has no place in a file: {value!r}")


def json_text(value: Mapping[str, Any]) -> str:
    """Returns a dictionary of values and arrays as JSON."""
    try:
        return json.dumps(plain(value))
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(str(error)) from None


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
