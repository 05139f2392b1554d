"""Tools of a job as the engine's tool tables."""

from __future__ import annotations

from typing import Any

from . import compat
from .problem import Problem
from .translate import translated

#: Shapes of tool bits that can be placed, and the engine's names of them.
KINDS = {"endmill": "flat", "ballend": "ball", "ballnose": "ball", "bullnose": "bull", "torus": "bull"}


def tool_table(controller: Any, length: float) -> dict[str, Any]:
    """Returns the tool of a controller as `[tool]` of a job.

    Args:
        controller: a tool controller.
        length: gauge point to tip [mm].
    """
    bit = getattr(controller, "Tool", None)
    if bit is None:
        raise Problem(translated("{label} has no tool", label=controller.Label), translated("choose a tool bit for the controller"))
    shape = compat.bit_shape(bit)
    kind = KINDS.get(shape)
    if kind is None:
        known = ", ".join(sorted(set(KINDS)))
        raise Problem(
            translated("{label}: tools of the shape {shape} are not placed", label=bit.Label, shape=shape or translated("unknown")),
            translated("take a tool of a shape that is: {known}", known=known),
        )
    diameter = float(bit.Diameter)
    table: dict[str, Any] = {"number": int(controller.ToolNumber), "kind": kind, "diameter": diameter, "length": length}
    if kind == "bull":
        corner = compat.corner_radius(bit, diameter)
        if corner is None or not 0 < corner < 0.5 * diameter:
            raise Problem(
                translated("{label}: the corner radius of the bull-nose is {corner} mm", label=bit.Label, corner=corner),
                translated("it has to be between 0 and {most} mm", most=0.5 * diameter),
            )
        table["corner_radius"] = corner
    return table


def usual_length(controller: Any) -> float:
    """Returns the length of a tool from gauge point to tip [mm]: that of its bit, since FreeCAD knows no holder."""
    bit = getattr(controller, "Tool", None)
    return float(getattr(bit, "Length", 0.0) or 0.0) or 100.0


def set_cutting(controller: Any, feed: float, spindle: float) -> None:
    """Sets horizontal feed [mm/min] and spindle speed [1/min] of a controller, where they differ."""
    if abs(float(getattr(controller.HorizFeed, "Value", controller.HorizFeed)) * 60.0 - feed) > 1e-6:
        controller.HorizFeed = feed / 60.0
    if abs(float(controller.SpindleSpeed) - spindle) > 1e-6:
        controller.SpindleSpeed = spindle


def feed(controller: Any) -> float:
    """Returns the horizontal feed [mm/min]."""
    value = float(getattr(controller.HorizFeed, "Value", controller.HorizFeed)) * 60.0
    if value <= 0:
        raise Problem(translated("{label} has no horizontal feed", label=controller.Label), translated("set it in the tool controller"))
    return value


def spindle(controller: Any) -> float:
    """Returns the spindle speed [1/min]."""
    value = float(controller.SpindleSpeed)
    if value <= 0:
        raise Problem(translated("{label} has no spindle speed", label=controller.Label), translated("set it in the tool controller"))
    return value


def cutter_words(controller: Any, length: float) -> str:
    """Returns a tool as the option `--cutter` of a check: R=..,r=..,L=.. in mm."""
    table = tool_table(controller, length)
    radius = 0.5 * table["diameter"]
    corner = {"flat": 0.0, "ball": radius, "bull": table.get("corner_radius", 0.0)}[table["kind"]]
    return f"R={radius - corner!r},r={corner!r},L={length!r}"
