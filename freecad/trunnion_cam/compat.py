"""What differs between FreeCAD 0.20 (modules PathScripts), 1.0 (Path.Main, Path.Tool.Bit) and 1.1 (Path.Tool.toolbit)."""

from __future__ import annotations

import importlib
import inspect
from typing import Any, NamedTuple

from .problem import Problem
from .translate import translated


class BitMakers(NamedTuple):
    """Where tool bits are made: the class of 1.1, or the module of earlier versions; the other is None."""

    tool_bit: Any
    module: Any


def _first(*names: str) -> Any:
    for name in names:
        try:
            return importlib.import_module(name)
        except ImportError:
            continue
    raise Problem(
        translated("none of the modules {names} can be loaded", names=", ".join(names)),
        translated("install FreeCAD with its CAM (Path) workbench, 0.20.2 or later"),
    )


def create_job(name: str, models: list[Any]) -> Any:
    """Creates a job of the CAM workbench for these models."""
    return _first("Path.Main.Job", "PathScripts.PathJob").Create(name, models, None)


def create_controller(name: str, number: int) -> Any:
    """Creates a tool controller with the usual end mill; `add_controller` puts it into a job."""
    module = _first("Path.Tool.Controller", "PathScripts.PathToolController")
    return module.Create(name, toolNumber=number)


def add_controller(job: Any, controller: Any) -> None:
    """Adds a tool controller to a job."""
    need_proxy(job).addToolController(controller)


def _bit_makers() -> BitMakers:
    # 1.1 keeps no `Path.Tool.Bit`; the package has to be loaded whole, since its shapes register themselves.
    module = _first("Path.Tool.toolbit", "Path.Tool.Bit", "PathScripts.PathToolBit")
    tool_bit = getattr(module, "ToolBit", None)
    return BitMakers(tool_bit, None) if hasattr(tool_bit, "from_shape_id") else BitMakers(None, module)


def create_bit(shape: str) -> Any:
    """Creates a tool bit of a shape in the active document: endmill, ballend, bullnose."""
    makers = _bit_makers()
    if makers.tool_bit is not None:
        document = importlib.import_module("FreeCAD").ActiveDocument
        return makers.tool_bit.from_shape_id(f"{shape}.fcstd").attach_to_doc(doc=document)
    return makers.module.Factory.Create(shape, makers.module.findToolShape(f"{shape}.fcstd"))


def bit_shape(bit: Any) -> str:
    """Returns the name of a tool bit's shape in lower case, without the ending of its file."""
    for name in ("ShapeType", "ShapeID", "BitShape", "ShapeName"):
        # "Custom" is what 1.1 calls shapes of the user's own; their file has the name.
        value = str(getattr(bit, name, "") or "")
        if value and value != "Custom":
            break
    stem = value.replace("\\", "/").rsplit("/", 1)[-1]
    return stem.lower().removesuffix(".fcstd").replace("_", "").replace("-", "").replace(" ", "")


def bit_size(bit: Any) -> tuple[str, float]:
    """Returns shape and diameter [mm] of a tool bit: equal for bits that cut alike."""
    return bit_shape(bit), float(getattr(bit, "Diameter", 0.0) or 0.0)


def corner_radius(bit: Any, diameter: float) -> float | None:
    """Returns the corner radius of a bull-nose [mm]; None if its shape does not say it."""
    # 1.1 has CornerRadius, made from TorusRadius of 1.0 where there was one.
    for name in ("CornerRadius", "TorusRadius"):
        if hasattr(bit, name):
            return float(getattr(bit, name))
    # 0.20 and 1.0 state the radius of the flat part.
    if hasattr(bit, "FlatRadius"):
        return 0.5 * diameter - float(bit.FlatRadius)
    return None


def is_job(thing: Any) -> bool:
    """Returns True for a job of the CAM workbench."""
    return all(hasattr(thing, name) for name in ("Operations", "Tools", "Model", "Stock"))


def need_proxy(job: Any) -> Any:
    """Returns the proxy of a job; raises Problem where it is lost, as in documents of another generation of FreeCAD."""
    if getattr(job, "Proxy", None) is None:
        raise Problem(
            translated("{label} comes from another version of FreeCAD, which keeps jobs elsewhere", label=job.Label),
            translated("create a new job; this one can still be checked and posted"),
        )
    return job.Proxy


def controllers(job: Any) -> list[Any]:
    """Returns the tool controllers of a job."""
    return list(job.Tools.Group)


def models(job: Any) -> list[Any]:
    """Returns the models of a job, and the bodies that they were made from, as far as its proxy is there to say them."""
    bases = job.Proxy.baseObjects(job) if getattr(job, "Proxy", None) is not None else []
    return [*job.Model.Group, *bases]


def operations(job: Any) -> list[Any]:
    """Returns the operations of a job, in their order."""
    return list(job.Operations.Group)


def add_operation(job: Any, operation: Any) -> None:
    """Adds an operation behind the others."""
    need_proxy(job).addOperation(operation)


def base_operation(operation: Any) -> Any:
    """Returns the operation under dress-ups."""
    while not hasattr(operation, "ToolController") and hasattr(operation, "Base"):
        base = operation.Base
        operation = base[0] if isinstance(base, (list, tuple)) else base
    return operation


def document_object(posted: Any) -> Any:
    """Returns the object of the document behind what FreeCAD hands to a post processor; None for helpers of its own."""
    # Versions after 1.1 wrap what they hand over, and keep the object as `source`.
    found = getattr(posted, "source", posted) if hasattr(posted, "item_type") else posted
    return found if getattr(found, "Document", None) is not None else None


def post_processor_class(path: str) -> Any:
    """Returns the class that 1.0 takes for the post processor of a script; None for versions that take the script as it is."""
    try:
        wrapper = importlib.import_module("Path.Post.Processor").WrapperPost
    except (ImportError, AttributeError):
        return None
    if "module_name" in inspect.signature(wrapper).parameters:
        return None

    class Script(wrapper):
        """The script, whose problems leave the file of an earlier program as it is: 1.0 would empty it."""

        def __init__(self, job: Any) -> None:
            super().__init__(job, path)

        def export(self) -> list[Any]:
            """Returns names and texts of all programs; none if one of them could not be made."""
            programs = super().export()
            return programs if all(text is not None for _, text in programs) else []

    return Script


def standard_buttons(*names: str) -> Any:
    """Returns buttons of a task panel, such as "Ok" and "Cancel", as the window wants them."""
    box = importlib.import_module("PySide.QtGui").QDialogButtonBox
    found = getattr(box, names[0])
    for name in names[1:]:
        found = found | getattr(box, name)
    try:
        return int(found)
    except TypeError:
        # PySide6, which comes with 1.1, has flags that are no numbers; FreeCAD takes them as they are.
        return found
