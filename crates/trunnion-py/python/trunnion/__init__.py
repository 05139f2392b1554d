"""Five-axis machining, from surface to servo, with proof.

Arrays are float64 in C order; units are mm, rad and s, and `deg=True` where people have degrees.
Tool axes are unit vectors from tip to holder, in the workpiece frame.

    >>> import trunnion
    >>> machine = trunnion.Machine("bc-trunnion", tool_length=120, origin=(-381, -254, -505))
    >>> q = machine.inverse([[40, 10, 5]], [[0.6, 0, 0.8]])
    >>> tip, axis = machine.forward(q)
    >>> tip.round(9).tolist()
    [[40.0, 10.0, 5.0]]
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._drop import DropResult, drop_cutter
from ._errors import (
    ArgumentError,
    InputError,
    InternalError,
    StoppedError,
    TrunnionError,
    TrunnionWarning,
    UnfinishedError,
    UnreachableWarning,
)
from ._job import Job, RunResult, run
from ._locate import Covering, CutterLocation, cover, position
from ._machine import Calibration, ImportedMachine, import_machine
from ._path import Path, SmoothPath
from ._plan import Limits, Motion, Plan, Stream, plan
from ._program import Program, read
from ._trunnion import Cutter, Face, Machine, Part, __version__, built_in
from ._verbs import CheckResult, PostResult, check, post

if TYPE_CHECKING:
    from . import fleet, plot

__all__ = [
    "ArgumentError",
    "Calibration",
    "CheckResult",
    "Covering",
    "Cutter",
    "CutterLocation",
    "DropResult",
    "Face",
    "ImportedMachine",
    "InputError",
    "InternalError",
    "Job",
    "Limits",
    "Machine",
    "Motion",
    "Part",
    "Path",
    "Plan",
    "PostResult",
    "Program",
    "RunResult",
    "SmoothPath",
    "StoppedError",
    "Stream",
    "TrunnionError",
    "TrunnionWarning",
    "UnfinishedError",
    "UnreachableWarning",
    "__version__",
    "built_in",
    "check",
    "cover",
    "drop_cutter",
    "fleet",
    "import_machine",
    "plan",
    "plot",
    "position",
    "post",
    "read",
    "run",
]


def __getattr__(name: str) -> Any:
    # Both bring libraries of their own, which most scripts do not need.
    if name in ("fleet", "plot"):
        import importlib

        return importlib.import_module(f"trunnion.{name}")
    raise AttributeError(f"module 'trunnion' has no attribute {name!r}")
