"""What differs between FreeCAD 0.20 (modules PathScripts) and 1.x (modules Path.Main and Path.Tool)."""

from __future__ import annotations

import importlib
from typing import Any

from .problem import Problem


def _first(*names: str) -> Any:
    for name in names:
        try:
            return importlib.import_module(name)
        except ImportError:
            continue
    raise Problem(
        f"none of the modules {', '.join(names)} can be loaded",
        "install FreeCAD with its CAM (Path) workbench, 0.20.2 or later",
    )


def create_job(name: str, models: list[Any]) -> Any:
    """Creates a job of the CAM workbench for these models."""
    return _first("Path.Main.Job", "PathScripts.PathJob").Create(name, models, None)


def create_controller(name: str, number: int) -> Any:
    """Creates a tool controller with the usual end mill."""
    module = _first("Path.Tool.Controller", "PathScripts.PathToolController")
    return module.Create(name, toolNumber=number)


def create_bit(shape: str) -> Any:
    """Creates a tool bit of a shape: endmill, ballend, bullnose."""
    try:
        toolbit = importlib.import_module("PathScripts.PathToolBit")
    except ImportError:
        toolbit = None
    if toolbit is not None:
        return toolbit.Factory.Create(shape, toolbit.findToolShape(f"{shape}.fcstd"))
    bits = _first("Path.Tool.toolbit.models.base", "Path.Tool.Bit")
    if hasattr(bits, "ToolBit"):
        bit = bits.ToolBit.from_shape_id(shape)
        return bit.attach_to_doc(importlib.import_module("FreeCAD").ActiveDocument)
    return bits.Factory.Create(shape, bits.findToolShape(f"{shape}.fcstd"))


def bit_shape(bit: Any) -> str:
    """Returns the name of a tool bit's shape in lower case, without the ending of its file."""
    for name in ("ShapeType", "ShapeID", "ShapeName"):
        value = getattr(bit, name, "")
        if value:
            break
    else:
        value = getattr(bit, "BitShape", "") or ""
    stem = str(value).replace("\\", "/").rsplit("/", 1)[-1]
    return stem.lower().removesuffix(".fcstd").replace("_", "").replace(" ", "")


def corner_radius(bit: Any, diameter: float) -> float | None:
    """Returns the corner radius of a bull-nose [mm]; None if its shape does not say it."""
    if hasattr(bit, "CornerRadius"):
        return float(bit.CornerRadius)
    # 0.20 states the radius of the flat part.
    if hasattr(bit, "FlatRadius"):
        return 0.5 * diameter - float(bit.FlatRadius)
    return None


def is_job(thing: Any) -> bool:
    """Returns True for a job of the CAM workbench."""
    return all(hasattr(thing, name) for name in ("Operations", "Tools", "Model", "Stock"))


def controllers(job: Any) -> list[Any]:
    """Returns the tool controllers of a job."""
    return list(job.Tools.Group)


def operations(job: Any) -> list[Any]:
    """Returns the operations of a job, in their order."""
    return list(job.Operations.Group)


def add_operation(job: Any, operation: Any) -> None:
    """Adds an operation behind the others."""
    job.Proxy.addOperation(operation)


def base_operation(operation: Any) -> Any:
    """Returns the operation under dress-ups."""
    while not hasattr(operation, "ToolController") and hasattr(operation, "Base"):
        base = operation.Base
        operation = base[0] if isinstance(base, (list, tuple)) else base
    return operation
