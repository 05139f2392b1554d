"""Stand-ins with the names and signatures of FreeCAD's CAM workbench, one family for each generation.

They hold `trunnion_cam/compat.py` against what each generation offers; they compute nothing.
"""

from __future__ import annotations

import contextlib
import importlib
import sys
import types
from typing import Any, Callable, Iterator


class Document:
    """A document that counts what is added to it."""

    def __init__(self) -> None:
        self.added: list[tuple[str, str]] = []

    def addObject(self, kind: str, name: str) -> Any:
        """Adds an object of a type."""
        self.added.append((kind, name))
        return types.SimpleNamespace(Name=name, TypeId=kind, Document=self)


class Group:
    """A group of a job."""

    def __init__(self) -> None:
        self.Group: list[Any] = []


class JobProxy:
    """What all generations have of a job: operations, controllers and the bodies behind the models."""

    def __init__(self, obj: Any) -> None:
        self.obj = obj

    def addOperation(self, op: Any, before: Any = None, removeBefore: bool = False) -> None:
        """Adds an operation."""
        self.obj.Operations.Group = [*self.obj.Operations.Group, op]

    def addToolController(self, tc: Any) -> None:
        """Adds a tool controller."""
        self.obj.Tools.Group = [*self.obj.Tools.Group, tc]

    def baseObjects(self, obj: Any) -> list[Any]:
        """Returns the bodies behind the models."""
        return [one.Objects[0] for one in obj.Model.Group]


def job_module(name: str) -> types.ModuleType:
    """PathScripts.PathJob and Path.Main.Job."""
    module = types.ModuleType(name)

    def Create(name: str, base: list[Any], templateFile: Any = None) -> Any:
        job = types.SimpleNamespace(Name=name, Operations=Group(), Tools=Group(), Model=Group(), Stock=None, made=module.__name__)
        job.Proxy = JobProxy(job)
        job.Model.Group = [types.SimpleNamespace(Name=f"Model-{one}", Objects=[one]) for one in base]
        return job

    module.Create = Create
    return module


def controller_module(name: str) -> types.ModuleType:
    """PathScripts.PathToolController and Path.Tool.Controller."""
    module = types.ModuleType(name)

    def Create(name: str = "TC: 5mm Endmill", tool: Any = None, toolNumber: int = 1, assignViewProvider: bool = True, assignTool: bool = True) -> Any:
        return types.SimpleNamespace(Name=name, Label=name, ToolNumber=toolNumber, Tool=tool, made=module.__name__)

    module.Create = Create
    return module


def bit_module(name: str) -> types.ModuleType:
    """PathScripts.PathToolBit of 0.20 and Path.Tool.Bit of 1.0: a factory, and a search for files of shapes."""
    module = types.ModuleType(name)

    class ToolBit:
        def __init__(self, obj: Any, shapeFile: str, path: Any = None) -> None:
            obj.BitShape, obj.ShapeName = shapeFile, shapeFile.rsplit("/", 1)[-1].split(".")[0]

    class ToolBitFactory:
        def Create(self, name: str = "ToolBit", shapeFile: Any = None, path: Any = None) -> Any:
            obj = sys.modules["FreeCAD"].ActiveDocument.addObject("Part::FeaturePython", name)
            obj.Proxy = ToolBit(obj, shapeFile, path)
            return obj

    module.ToolBit, module.Factory = ToolBit, ToolBitFactory()
    module.findToolShape = lambda name, path=None: f"/usr/share/Shape/{name}"
    return module


def processor_module(name: str, names_module: bool) -> types.ModuleType:
    """Path.Post.Processor: the wrapper of scripts, which is told the name of its module after 1.0; a script with "broken" has no text."""
    module = types.ModuleType(name)

    class WrapperPost:
        def __init__(self, job: Any, script_path: str, *more: Any) -> None:
            self.job, self.script_path = job, script_path

        def export(self) -> list[tuple[str, Any]]:
            return [(part, None if part == "broken" else "G0") for part in self.job]

    class LaterWrapperPost(WrapperPost):
        def __init__(self, job: Any, script_path: str, module_name: str) -> None:
            super().__init__(job, script_path)

    module.WrapperPost = LaterWrapperPost if names_module else WrapperPost
    return module


def toolbit_package(name: str) -> types.ModuleType:
    """Path.Tool.toolbit of 1.1: bits are made from the identifier of a shape, and attached to a document."""
    module = types.ModuleType(name)
    module.__path__ = []

    class ToolBit:
        def __init__(self, shape: str) -> None:
            self.shape = shape

        @classmethod
        def from_shape_id(cls, shape_id: str, label: Any = None) -> Any:
            return cls(shape_id.removesuffix(".fcstd"))

        def attach_to_doc(self, doc: Any, label: Any = None) -> Any:
            obj = doc.addObject("Part::FeaturePython", label or self.shape)
            obj.ShapeID, obj.ShapeType = self.shape, self.shape.capitalize()
            return obj

    module.ToolBit = ToolBit
    return module


def _v020() -> dict[str, types.ModuleType]:
    return {
        "PathScripts.PathJob": job_module("PathScripts.PathJob"),
        "PathScripts.PathToolController": controller_module("PathScripts.PathToolController"),
        "PathScripts.PathToolBit": bit_module("PathScripts.PathToolBit"),
    }


def _v10() -> dict[str, types.ModuleType]:
    return {
        "Path.Main.Job": job_module("Path.Main.Job"),
        "Path.Tool.Controller": controller_module("Path.Tool.Controller"),
        "Path.Tool.Bit": bit_module("Path.Tool.Bit"),
        "Path.Post.Processor": processor_module("Path.Post.Processor", names_module=False),
    }


def _v11() -> dict[str, types.ModuleType]:
    package = toolbit_package("Path.Tool.toolbit")
    # The old name leads to the base of the new package, which has neither a factory nor a search.
    alias = types.ModuleType("Path.Tool.toolbit.models.base")
    alias.ToolBit = package.ToolBit
    return {
        "Path.Main.Job": job_module("Path.Main.Job"),
        "Path.Tool.Controller": controller_module("Path.Tool.Controller"),
        "Path.Tool.toolbit": package,
        "Path.Tool.Bit": alias,
        "Path.Post.Processor": processor_module("Path.Post.Processor", names_module=True),
    }


GENERATIONS: dict[str, Callable[[], dict[str, types.ModuleType]]] = {"0.20": _v020, "1.0": _v10, "1.1": _v11}

#: Modules that a generation has, or has not.
_FAMILIES = ("PathScripts", "Path.Main", "Path.Tool", "Path.Op", "Path.Post")


@contextlib.contextmanager
def generation(version: str) -> Iterator[Document]:
    """Gives way to the modules of a generation, and to nothing else of the CAM workbench; yields the active document."""
    modules = GENERATIONS[version]()

    def load(name: str) -> Any:
        if name in modules:
            return modules[name]
        if name.startswith(_FAMILIES):
            raise ModuleNotFoundError(f"No module named {name!r}")
        if name == "FreeCAD":
            return freecad
        return real(name)

    real, document = importlib.import_module, Document()
    freecad = types.SimpleNamespace(ActiveDocument=document)
    known = sys.modules["FreeCAD"]
    importlib.import_module = load
    # The factories look for the active document themselves.
    sys.modules["FreeCAD"] = freecad
    try:
        yield document
    finally:
        importlib.import_module = real
        sys.modules["FreeCAD"] = known


class Postable:
    """What versions after 1.1 hand to a post processor: a wrapper that leads to the object where it has nothing itself."""

    def __init__(self, item_type: str, label: str, source: Any) -> None:
        self.item_type, self.label, self.source = item_type, label, source

    def __getattr__(self, name: str) -> Any:
        if self.source is None:
            raise AttributeError(name)
        return getattr(self.source, name)
