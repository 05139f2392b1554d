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

from ._trunnion import Cutter, Face, Machine, Part, __version__, built_in

# The name alone tells type checkers; the module `typing` would take longer than the rest.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from . import fleet, plot
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
    from ._verbs import CheckResult, PostResult, check, post

#: Modules that are loaded with the first use of one of their names: most scripts use few of them.
_PLACES = {
    "_drop": ("DropResult", "drop_cutter"),
    "_errors": (
        "ArgumentError",
        "InputError",
        "InternalError",
        "StoppedError",
        "TrunnionError",
        "TrunnionWarning",
        "UnfinishedError",
        "UnreachableWarning",
    ),
    "_job": ("Job", "RunResult", "run"),
    "_locate": ("Covering", "CutterLocation", "cover", "position"),
    "_machine": ("Calibration", "ImportedMachine", "import_machine"),
    "_path": ("Path", "SmoothPath"),
    "_plan": ("Limits", "Motion", "Plan", "Stream", "plan"),
    "_program": ("Program", "read"),
    "_verbs": ("CheckResult", "PostResult", "check", "post"),
}

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
    from importlib import import_module

    if name in ("fleet", "plot"):
        return import_module(f"trunnion.{name}")
    for place, names in _PLACES.items():
        if name in names:
            found = globals()[name] = getattr(import_module(f"trunnion.{place}"), name)
            return found
    raise AttributeError(f"module 'trunnion' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
