"""Every public callable with hostile arguments: found by walking the module, so that a function added later is tried too.

An argument gets its proper value by its name. A callable with an argument of an unknown name fails
`test_every_argument_has_a_proper_value` until its value is added here.
"""

import inspect
import itertools
import sys
import threading
import types

import numpy as np
import pytest
from conftest import LOCATIONS, PROGRAM, ROOT

import trunnion
from trunnion import _plan, _program, _verbs

MACHINE = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120.0)
PART = trunnion.Part.from_net([[[x, y, 0.01 * x * y] for y in (0, 10, 20, 30)] for x in (0, 10, 20, 30)])
BULL = trunnion.Cutter.bull(4, 2, length=60)
TIP, AXIS = np.array([[0.0, 0, 0], [5, 0, 0]]), np.array([[0.0, 0, 1], [0, 0.6, 0.8]])
LIMITS = {"X": (100, 1000, 20000)}
TABLE = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}
PATH = trunnion.Path(TIP, AXIS)
JOB = {"name": "a", "part": {"file": "missing.json"}}
LOCATION = trunnion.position(PART.faces[0], BULL, at=(0.5, 0.5), feed=(0, 1))
PLAN = trunnion.plan(TABLE, LIMITS)
COVERING = trunnion.cover(PART, BULL, excess=0.5, gouge=0.05, along="u", method="inclined")
CHECK = trunnion.check(PROGRAM, machine=MACHINE)

#: Proper values by name of the argument; "function.argument" comes first.
PROPER = {
    "source": "bc-trunnion", "origin": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0], "tool_length": 100.0, "deg": False,
    "format": "linuxcnc", "given": {"name": "a"}, "text": "a = 1", "measurements": {"X_mm": [0.0], "Y_mm": [0.0]},
    "noise": 0.001, "axis": AXIS, "q": np.zeros((2, 5)), "tip": TIP, "near": np.zeros(5), "all": False,
    "jets.tip": np.ones((1, 4, 3)), "jets.axis": np.ones((1, 4, 3)), "arc_length": False, "path": "missing.toml",
    "progress": None, "on_passes": None, "points": [[1.0, 1.0, 1.0]], "from_net.points": np.random.default_rng(1).random((4, 4, 3)),
    "degree": (3, 3), "knots": None, "weights": np.ones((4, 4)), "flip": False, "chord": 0.1, "uv": [[0.5, 0.5]],
    "d": 10.0, "length": 50.0, "shank": [[55.0, 8.0]], "inner": 0.5, "R": 10.0, "r": 2.0, "tip_radius": 2.0, "taper_angle": 0.1,
    "barrel_radius": 85.0, "corner_radius": 1.0, "lens.tip_radius": 40.0, "steps": 8,
    "shape": ([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]]),
    "drop_cutter.points": [[1.0, 1.0]], "bounds": False, "cutter": BULL, "face": PART.faces[0], "part": PART,
    "at": (0.5, 0.5), "feed": (0.0, 1.0),
    "to_cl.feed": 500.0, "tolerance": (0.05, 0.01), "position.tolerance": 0.01, "error_curve.tolerance": 0.01,
    "side": "ahead", "method": "inclined",
    "position.method": "sturz", "lead": 0.0, "tilt": 0.0, "faces": [0], "excess": 0.5, "gouge": 0.05, "along": "u",
    "pattern": "zigzag",
    "max_step": 1.0, "max_turn": 1.0, "smooth.tip": 0.01, "smooth.axis": 0.01, "linearise.tip": 0.01, "linearise.axis": 0.01,
    "SmoothPath.ranges": [[0.0, 1.0]], "SmoothPath.coefficients": np.ones((1, 6, 9)), "SmoothPath.starts": [0],
    "SmoothPath.deviation": [0.0, 0.0],
    "axes": {"X": (1, 2, 3)}, "plan.axes": None, "limits": LIMITS, "table": TABLE, "plan.method": "optimal",
    "Stream.method": "jerk", "window": 16, "step": 0.5,
    "Limits.path": {"feed": 1.0}, "rows": [[0, 0, 1, 0], [1, 1, 1, 0]], "period": 0.01, "program": PROGRAM, "machine": MACHINE,
    "propose.machine": "bc-trunnion", "dialect": None, "source_dialect": None, "post.dialect": "g93", "smooth": False,
    "suffix": ".ngc", "job": JOB,
    "check.job": None, "check.part": None, "part_rotation": [0.0, 0.0, 0.0], "output": None, "read.path": PROGRAM,
    "reversed_rotaries": False,
    "from_cl.text": LOCATIONS.decode(), "from_toml.text": MACHINE.to_toml(), "from_toml.source": "own",
    "from_control.source": b"[KINS]",
    "import_machine.source": b"[KINS]", "data": JOB, "folder": ".", "changes": {"tool.length": 1.0}, "towards": None,
    "turn": None,
    "setups.tilt": (0.0, 1.0), "Job.path": "job.toml", "Part.path": b'{"degree": [1, 1]}', "check.faces": (),
    "check.cutter": None,
    "programs": [], "machines": "bc-trunnion", "results": None, "client": None, "workers": 0, "over": {"tolerance": [1]},
    "axes.result": PLAN, "strip_width.result": COVERING, "deviation.result": CHECK, "strip": None, "offset_range": (0.0, 5.0), "result": None, "location": LOCATION, "bins": 10,
    "view.part": PART, "view.cutter": BULL,
    "view.result": PATH, "view.at": 0, "tangent": None, "off_screen": True, "tool": None,
}


class Own(Exception):
    """Raised by an argument itself."""


class Evil:
    """Answers every question with an exception."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        raise Own

    def refuse(self, *args):
        raise Own

    __float__ = __index__ = __int__ = __fspath__ = __len__ = __iter__ = __getitem__ = __bool__ = __str__ = refuse


def nested(depth, kind):
    value = 1
    for _ in range(depth):
        value = [value] if kind is list else {"a": value}
    return value


def unaligned(shape):
    raw = np.zeros(8 * int(np.prod(shape)) + 1, dtype=np.uint8)
    array = np.frombuffer(raw.data, dtype=np.float64, offset=1, count=int(np.prod(shape))).reshape(shape)
    assert not array.flags.aligned or not array.size
    return array


def endless():
    own = []
    own.append(own)
    return own


#: Makers of values that are proper nowhere, or hardly anywhere.
HOSTILE = {
    "None": lambda: None, "object": object, "class": lambda: Evil, "function": lambda: Evil().refuse, "evil": Evil,
    "module": lambda: np,
    "true": lambda: True, "zero": lambda: 0, "minus": lambda: -3, "huge": lambda: 10**400, "large": lambda: 2**63,
    "tiny": lambda: 5e-324,
    "big": lambda: 1e308, "nan": lambda: float("nan"), "inf": lambda: float("-inf"), "complex": lambda: 1j,
    "numpy": lambda: np.float32(1.5),
    "date": lambda: np.datetime64("2020-01-01"), "empty": lambda: "", "text": lambda: "x" * 10_000, "lone": lambda: "\ud800",
    "null": lambda: "a\0b",
    "dash": lambda: "--help", "spaces": lambda: " \n\t", "bytes": lambda: b"\xff\xfe\x00" * 50,
    "bytearray": lambda: bytearray(b"G0 X1"), "list": list,
    "dict": dict, "set": lambda: {1, 2}, "range": lambda: range(3), "generator": lambda: (one for one in (1, 2)),
    "ragged": lambda: [[1, 2], [3]],
    "texts": lambda: ["1", "2", "3"], "nones": lambda: [None] * 3, "own": endless, "deep list": lambda: nested(50_000, list),
    "deep dict": lambda: nested(50_000, dict), "keys": lambda: {1: 2, None: 3}, "surrogate key": lambda: {"\ud800": "\udfff"},
    "nan dict": lambda: {"X": float("nan")},
    "0-d": lambda: np.array(1.0), "0 rows": lambda: np.zeros((0, 3)), "0 columns": lambda: np.zeros((3, 0)),
    "many axes": lambda: np.zeros((1,) * 20),
    "nan rows": lambda: np.full((2, 3), np.nan), "big rows": lambda: np.full((2, 3), 1e308),
    "reversed": lambda: np.ones((2, 3))[::-1], "fortran": lambda: np.asfortranarray(np.ones((2, 3))),
    "big-endian": lambda: np.ones((2, 3), dtype=">f8"), "unaligned": lambda: unaligned((2, 3)),
    "unaligned pairs": lambda: unaligned((2, 2)),
    "unaligned q": lambda: unaligned((2, 5)), "read-only": lambda: np.broadcast_to(1.0, (2, 3)),
    "masked": lambda: np.ma.masked_array(np.ones((2, 3)), mask=True),
    "float16": lambda: np.ones((2, 3), dtype=np.float16), "complex rows": lambda: np.ones((2, 3), dtype=complex),
    "bools": lambda: np.ones((2, 3), dtype=bool),
    "objects": lambda: np.array([[1, None, 2]], dtype=object), "records": lambda: np.zeros(2, dtype=[("s", "f8"), ("X",
    "f8")]), "uint64": lambda: np.full((2, 3), 2**64 - 1, dtype=np.uint64),
    "machine": lambda: MACHINE, "part": lambda: PART, "cutter": lambda: BULL, "path": lambda: PATH, "plan": lambda: PLAN,
    "lock": threading.Lock,
}

#: Objects whose public methods are called.
OBJECTS = {
    "Machine": MACHINE, "Part": PART, "Face": PART.faces[0], "Cutter": BULL, "Path": PATH,
    "SmoothPath": PATH.smooth(0.01, 0.01), "Plan": PLAN, "Limits": trunnion.Limits(LIMITS),
    "Job": trunnion.Job(JOB), "CutterLocation": LOCATION, "Program": trunnion.read(PROGRAM, machine=MACHINE),
    "DropResult": trunnion.drop_cutter(([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]]), BULL, [[1, 1]]),
    "Covering": COVERING,
    "CheckResult": CHECK, "PostResult": trunnion.post(PROGRAM, MACHINE, dialect="g93"),
    "ImportedMachine": trunnion.import_machine(
        ROOT / "fixtures/machine-descriptions/fanuc-table.prm", given={"linear.jerk": 40000, "rotary.jerk": 6000}
    ),
}
#: Classes that only calls of this package make: their results are above, or take a job of seconds.
MADE = {
    "Calibration", "CheckResult", "Covering", "Cutter", "CutterLocation", "DropResult", "Face", "ImportedMachine", "Motion",
    "Part", "Plan", "PostResult", "Program", "RunResult", "SmoothPath",
}
#: Names of keywords of verbs that go through to the engine.
MORE = {
    "check": _verbs._CHECK, "post": _verbs._POST, "read": _program._KNOWN, "Path.read": _program._KNOWN, "plan": _plan._KNOWN,
    "fleet.audit": _verbs._CHECK,
}


def callables():
    """Yields name and callable of everything public."""
    for name in trunnion.__all__:
        thing = getattr(trunnion, name)
        if inspect.ismodule(thing):
            inner = [(f"{name}.{one}", getattr(thing, one)) for one in thing.__all__]
            yield from ((one, function) for one, function in inner if not inspect.isclass(function))
        elif not inspect.isclass(thing):
            yield from [(name, thing)] if callable(thing) else []
        elif not issubclass(thing, (Exception, Warning)):
            yield from [] if name in MADE else [(name, thing)]
            yield from methods(name, thing)


def methods(name, kind):
    """Yields name and callable of every public method of a class."""
    for inner, raw in vars(kind).items():
        if inner.startswith("_") or not callable(getattr(kind, inner)):
            continue
        if isinstance(raw, (staticmethod, classmethod, types.ClassMethodDescriptorType)):
            yield f"{name}.{inner}", getattr(kind, inner)
        elif name == "Stream":
            yield f"{name}.{inner}", Stream(inner)
        elif name in OBJECTS:
            yield f"{name}.{inner}", getattr(OBJECTS[name], inner)


class Stream:
    """A method of a new stream each time: rows that it has taken would stand in the way of the next."""

    def __init__(self, name):
        self._name = name
        self.__signature__ = inspect.signature(getattr(trunnion.Stream(LIMITS), name))

    def __call__(self, *args, **words):
        return getattr(trunnion.Stream(LIMITS, window=16), self._name)(*args, **words)


CALLS = dict(callables())


def parameters(name):
    """Names of the arguments of a callable, in order."""
    found = inspect.signature(CALLS[name]).parameters.values()
    return [one.name for one in found if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]


def proper(name, argument):
    last, _, first = name.rpartition(".")[2], None, name.partition(".")[0]
    for key in (f"{last}.{argument}", f"{first}.{argument}", argument):
        if key in PROPER:
            return PROPER[key]
    raise KeyError(argument)


def test_every_argument_has_a_proper_value():
    known = {key.rpartition(".")[2] for key in PROPER}
    unknown = [(name, one) for name in CALLS for one in parameters(name) if one not in known]
    assert not unknown, "add a proper value for each"
    # The walk finds what it is for.
    expected = {"plan", "check", "drop_cutter", "Machine", "Machine.inverse", "Cutter.bull", "Path.smooth", "Stream.push"}
    assert expected | {"Part.from_net", "Job.replace", "fleet.audit", "plot.view"} <= set(CALLS)


def attempt(name, words):
    """Calls with named arguments; returns what escapes, or None."""
    try:
        CALLS[name](**words)
    except trunnion.TrunnionError as error:
        # A message, and one that can be sent on.
        text = str(error)
        if not text.strip() or not isinstance(error, (ValueError, RuntimeError)) and "pip install" not in text:
            return f"{type(error).__name__}: {text[:200]}"
        # The system may refuse to write an output.
        if isinstance(error, trunnion.InternalError) and not text.startswith("writing"):
            return f"InternalError: {text[:200]}"
        return None
    except Own:
        # What the methods of an argument raise goes through.
        return None
    except BaseException as error:  # whatever else escapes is what is looked for
        return f"{type(error).__module__}.{type(error).__name__}: {str(error)[:200]}"
    return None


def hostile_words(name):
    """Yields keywords of a call with one hostile value, and its label."""
    names = parameters(name)
    words = {one: proper(name, one) for one in names}
    more = MORE.get(name, ())
    for place in [*names, *more]:
        for label, make in HOSTILE.items():
            if place in ("progress", "on_passes") and label == "class":
                # It is called, and what it raises goes through.
                continue
            yield f"{place}={label}", {**words, place: make()}
    # What holds in one argument may not in two.
    rng = np.random.default_rng(7)
    pairs = list(itertools.combinations([*names, *more], 2))
    labels = list(HOSTILE)
    for index in rng.permutation(len(pairs))[:12]:
        for a, b in rng.choice(labels, (6, 2)):
            first, second = pairs[index]
            yield f"{first}={a}, {second}={b}", {**words, first: HOSTILE[a](), second: HOSTILE[b]()}


@pytest.mark.parametrize("name", [name for name in sorted(CALLS) if name.startswith("plot.")])
def test_a_wrong_argument_is_refused_whatever_extras_are_installed(name, monkeypatch):
    for extra in ("matplotlib", "matplotlib.figure", "pyvista"):
        monkeypatch.setitem(sys.modules, extra, None)
    words = {one: proper(name, one) for one in parameters(name)}
    for argument in words:
        with pytest.raises(trunnion.ArgumentError) as found:
            CALLS[name](**{**words, argument: object()})
        assert found.value.argument == argument and "object" in str(found.value)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", sorted(CALLS))
def test_hostile_arguments_are_refused_or_answered(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    escaped = {}
    for label, words in hostile_words(name):
        found = attempt(name, words)
        if found is not None:
            escaped[label] = found
    assert not escaped, "\n".join(f"{label}: {found}" for label, found in escaped.items())
