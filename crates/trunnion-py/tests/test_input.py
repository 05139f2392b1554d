"""Mutated input: no call ends the interpreter or raises anything but what is documented."""

import inspect
import random

import numpy as np
import pytest
from conftest import LOCATIONS, PROGRAM

import trunnion

ODD = [
    None, 0, -1, 1e300, float("nan"), float("inf"), True, "", "x", "\0", b"", b"\xff" * 40, [], [[]], [None], {}, {"a": 1},
    [1, 2], [[1, 2, 3]], np.zeros(0), np.zeros((0, 3)), np.zeros((2, 3)), np.full((2, 3), np.nan), np.zeros((3, 3, 3)),
    np.zeros((2, 5), dtype=np.float32), np.zeros((2, 3), dtype=object), np.zeros((4, 6))[::2, ::2], np.array("x"), object(),
]
MACHINE = trunnion.Machine("bc-trunnion", tool_length=120.0)
PART = trunnion.Part.from_net([[[x, y, 0.01 * x * y] for y in (0, 10, 20, 30)] for x in (0, 10, 20, 30)])
FACE = PART.faces[0]
BULL = trunnion.Cutter.bull(4, 2, length=60)
TIP, AXIS = np.array([[0.0, 0, 0], [5, 0, 0]]), np.array([[0.0, 0, 1], [0, 0.6, 0.8]])
TABLE = {"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}
MESH = ([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])

CALLS = {
    "Machine": (trunnion.Machine, ["bc-trunnion"], dict(origin=[0, 0, 0], rotation=[0, 0, 0], tool_length=1.0)),
    "with_setup": (MACHINE.with_setup, [], dict(origin=[0, 0, 0], rotation=[0, 0, 0], tool_length=1.0)),
    "forward": (MACHINE.forward, [np.zeros((2, 5))], dict(deg=True)),
    "inverse": (MACHINE.inverse, [TIP, AXIS], dict(near=np.zeros(5), all=False, deg=False)),
    "jets": (MACHINE.jets, [np.ones((1, 4, 3)), np.ones((1, 4, 3))], dict(near=np.zeros(5), arc_length=False, deg=False)),
    "singular_angle": (MACHINE.singular_angle, [AXIS], dict(deg=False)),
    "Part.read": (trunnion.Part.read, [b'{"degree": [1, 1]}'], {}),
    "from_net": (trunnion.Part.from_net, [np.random.default_rng(0).random((4, 4, 3))], dict(degree=(3, 3), weights=np.ones((4, 4)), flip=False)),
    "point": (FACE.point, [[0.5, 0.5]], {}),
    "normal": (FACE.normal, [[0.5, 0.5]], {}),
    "derivatives": (FACE.derivatives, [[[0.5, 0.5]]], {}),
    "curvature": (FACE.curvature, [[0.5, 0.5]], {}),
    "closest": (FACE.closest, [[5, 5, 5]], {}),
    "mesh": (FACE.mesh, [0.1], {}),
    "ball": (trunnion.Cutter.ball, [10.0], dict(length=50.0, shank=[[20.0, 8.0]], inner=1.0)),
    "bull": (trunnion.Cutter.bull, [10.0, 2.0], dict(length=50.0)),
    "flat": (trunnion.Cutter.flat, [10.0], dict(length=50.0)),
    "taper": (trunnion.Cutter.taper, [1.0, 0.1, 10.0], dict(length=50.0, deg=False)),
    "barrel": (trunnion.Cutter.barrel, [2.0, 85.0, 12.0], dict(length=60.0, shank=[[50.0, 8.0]], inner=1.0)),
    "conical_barrel": (trunnion.Cutter.conical_barrel, [3.0, 250.0, 0.3, 12.0], dict(length=60.0)),
    "lens": (trunnion.Cutter.lens, [40.0, 1.0, 12.0], dict(length=60.0)),
    "outline": (BULL.outline, [8], {}),
    "position": (trunnion.position, [FACE, BULL], dict(at=(0.5, 0.5), feed=(0, 1), tolerance=0.01, side="ahead", method="sturz", lead=5.0)),
    "cover": (trunnion.cover, [PART, BULL], dict(excess=0.5, gouge=0.05, along="u", pattern="zigzag", method="inclined", lead=0.0, tilt=0.0)),
    "drop_cutter": (trunnion.drop_cutter, [MESH, BULL, [[1, 1]]], dict(bounds=False)),
    "drop_cutter on a part": (trunnion.drop_cutter, [PART, BULL, [[1, 1]]], dict(chord=0.1)),
    "Path": (trunnion.Path, [TIP, AXIS], {}),
    "interpolate": (trunnion.Path(TIP, AXIS).interpolate, [1.0, 1.0], dict(deg=True)),
    "smooth": (trunnion.Path(TIP, AXIS).smooth, [0.01, 0.01], dict(deg=True)),
    "from_cl": (trunnion.Path.from_cl, ["GOTO/0,0,0"], {}),
    "Limits": (trunnion.Limits, [{"X": (1, 2, 3)}], dict(path={"feed": 1.0})),
    "plan": (trunnion.plan, [TABLE, {"X": (100, 1000, 20000)}], dict(method="optimal", window=16)),
    "Stream": (trunnion.Stream, [{"X": (100, 1000, 20000)}], dict(method="jerk", window=16, step=0.5)),
    "push": (lambda rows: trunnion.Stream({"X": (100, 1000, 20000)}).push(rows), [[[0, 0, 1, 0], [1, 1, 1, 0]]], {}),
    "sample": (trunnion.plan(TABLE, {"X": (100, 1000, 20000)}).sample, [0.01], {}),
    "read": (trunnion.read, [PROGRAM], dict(machine="bc-trunnion", dialect="linuxcnc", origin=[0, 0, 0], tool_length=1, deg=True, suffix=".ngc")),
    "check": (trunnion.check, [PROGRAM], dict(machine="bc-trunnion", tool_length=120, origin=[0, 0, 0], dialect="fanuc", deg=True)),
    "post": (trunnion.post, [LOCATIONS, "bc-trunnion"], dict(suffix=".cls", dialect="g93", tolerance=(0.1, 0.1), smooth=False, deg=True)),
    "Limits.of": (trunnion.Limits.of, [MACHINE], dict(deg=True)),
    "Limits.read": (trunnion.Limits.read, ["missing.toml"], {}),
    "from_toml": (trunnion.Machine.from_toml, [MACHINE.to_toml(), "own"], {}),
    "from_control": (trunnion.Machine.from_control, [b"[KINS]"], dict(format="linuxcnc", given={"name": "a"})),
    "import_machine": (trunnion.import_machine, [b"[KINS]"], dict(format="linuxcnc", given={"name": "a"})),
    "calibrate": (MACHINE.calibrate, [{"X_mm": [0.0], "Y_mm": [0.0]}], dict(tool_length=100.0, noise=0.001)),
    "rotation": (MACHINE.rotation, [], dict(deg=True)),
    "travel": (MACHINE.travel, [], dict(deg=True)),
    "velocity": (MACHINE.velocity, [], dict(deg=True)),
    "acceleration": (MACHINE.acceleration, [], dict(deg=True)),
    "jerk": (MACHINE.jerk, [], dict(deg=True)),
    "home": (MACHINE.home, [], dict(deg=True)),
    "taper_angle": (BULL.taper_angle, [], dict(deg=True)),
    "linearise": (trunnion.Path(TIP, AXIS).smooth(0.01, 0.01).linearise, [0.01, 0.01], dict(deg=True)),
    "to_cl": (trunnion.Path(TIP, AXIS).to_cl, [500.0], {}),
    "Job.read": (trunnion.Job.read, ["missing.toml"], {}),
    "propose": (trunnion.Job.propose, ["missing.step"], dict(machine="bc-trunnion", faces=[0])),
    "replace": (trunnion.Job({"name": "a"}).replace, [{"tool.length": 1.0}], {}),
    "save": (trunnion.Job({"name": "a"}).save, ["job.toml"], {}),
    "moved": (trunnion.Job({"name": "a", "part": {"file": "b"}}).moved, ["."], {}),
    "setups": (trunnion.Job({"name": "a"}).setups, [], dict(tilt=(0, 1), towards=(0, 1), turn=(0, 1))),
    "which_machine": (lambda *a: trunnion.fleet.which_machine(*a, workers=0), [{"name": "a"}, ["bc-trunnion"]], {}),
    "Job": (trunnion.Job, [{"name": "a"}], dict(folder=".")),
    "run": (trunnion.run, [{"name": "a"}], {}),
    "toml_text": (trunnion._trunnion.toml_text, [{"a": 1}], {}),
    "toml_data": (trunnion._trunnion.toml_data, ["a = 1"], {}),
    "audit": (lambda *a, **k: trunnion.fleet.audit(*a, workers=0, **k).rows, [[], "bc-trunnion"], {}),
    "workers": (trunnion.fleet.audit, [[], "bc-trunnion"], dict(workers=0)),
    "compare": (lambda *a: trunnion.fleet.compare(*a, workers=0).rows, [{"name": "a"}, {"tolerance": [1]}], {}),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_are_refused_or_answered(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, arguments, keywords = CALLS[name]
    places = [*range(len(arguments)), *keywords]
    for place in places:
        for odd in ODD:
            args, words = list(arguments), dict(keywords)
            if isinstance(place, int):
                args[place] = odd
            else:
                words[place] = odd
            try:
                function(*args, **words)
            except trunnion.TrunnionError as error:
                assert str(error).strip() and isinstance(error, (ValueError, RuntimeError))


def named(function):
    """Names of the arguments that a function takes one by one."""
    parameters = inspect.signature(function).parameters.values()
    return [one.name for one in parameters if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)]


def single_values():
    """Each argument of each call that is a number, a truth value or a text."""
    for name, (function, arguments, keywords) in CALLS.items():
        for place, value in [*zip(named(function), arguments), *keywords.items()]:
            if isinstance(value, (int, float, str)):
                yield name, place


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name, place", list(single_values()))
def test_a_single_value_of_a_wrong_type_is_named(name, place, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, arguments, keywords = CALLS[name]
    names = named(function)
    args, words = list(arguments), dict(keywords)
    for wrong in (object(), 1j):
        if place in words:
            words[place] = wrong
        else:
            args[names.index(place)] = wrong
        with pytest.raises(trunnion.ArgumentError) as found:
            function(*args, **words)
        error = found.value
        assert error.argument == place and str(error).startswith(place), str(error)
        assert type(wrong).__name__ in str(error) and error.value in (wrong, type(wrong).__name__), str(error)


def test_an_array_that_is_not_aligned_is_refused():
    # It was taken for an array without numbers: an answer without rows, or an exception of numpy.
    machine = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120.0)
    tip, axis = np.zeros((2, 3)), np.tile([0.0, 0, 1], (2, 1))
    records = np.zeros(2, dtype=np.dtype([("flag", "i1"), ("tip", "f8", 3)]))
    raw = np.frombuffer(np.zeros(49, np.uint8).data, np.float64, offset=1).reshape(2, 3)
    for wrong in (raw, records[:1]["tip"]):
        assert wrong.flags.c_contiguous and not wrong.flags.aligned
        with pytest.raises(trunnion.ArgumentError, match="tip = array is not aligned") as found:
            machine.inverse(wrong, axis[: len(wrong)])
        assert "copy" in found.value.remedy
        assert machine.inverse(np.array(wrong), axis[: len(wrong)]).shape == (len(wrong), 5)
    found = machine.inverse(np.array(raw), axis)
    assert np.isfinite(found).all() and np.array_equal(found, machine.inverse(tip, axis))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("content, suffix", [(PROGRAM, ".ngc"), (LOCATIONS, ".cls")])
def test_mutated_files_are_refused_or_read(content, suffix):
    rng = random.Random(7)
    for _ in range(300):
        text = bytearray(content)
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(text))
            kind = rng.randrange(3)
            if kind == 0:
                text[at] = rng.randrange(256)
            elif kind == 1:
                del text[at : at + rng.randint(1, 9)]
            else:
                text[at:at] = text[rng.randrange(len(text)) :][: rng.randint(1, 20)]
            if not text:
                text = bytearray(content)
        try:
            trunnion.read(bytes(text), suffix=suffix, machine="bc-trunnion")
        except trunnion.TrunnionError as error:
            assert str(error)


@pytest.mark.parametrize("period", [1e-300, 1e-12, 1e-9])
def test_a_period_whose_rows_do_not_fit_in_memory_is_refused(period):
    plan = trunnion.plan(TABLE, {"X": (100, 1000, 20000)})
    with pytest.raises(trunnion.ArgumentError, match="period = .* do not fit in memory") as found:
        plan.sample(period)
    assert float(found.value.remedy.split()[-2]) < plan.duration


@pytest.mark.parametrize("step, turn, name", [(1e-12, 1.0, "max_step"), (1.0, 1e-13, "max_turn")])
def test_a_path_that_does_not_fit_in_memory_is_refused(step, turn, name):
    with pytest.raises(trunnion.ArgumentError, match=f"{name} = .* do not fit in memory") as found:
        trunnion.Path(TIP, AXIS).interpolate(step, turn)
    assert found.value.argument == name


def public_functions():
    """Public functions and methods that take arguments, by name."""
    kinds = [trunnion.Machine, trunnion.Part, trunnion.Face, trunnion.Cutter, trunnion.Path, trunnion.SmoothPath]
    kinds += [trunnion.Limits, trunnion.Plan, trunnion.Stream, trunnion.Job]
    spaces = [(vars(trunnion), trunnion.__all__), (vars(trunnion.fleet), ["audit", "compare", "which_machine"])]
    spaces += [(vars(kind), [name for name in vars(kind) if not name.startswith("_")]) for kind in kinds]
    for space, names in spaces:
        for name in names:
            thing = space[name] if name in space else getattr(trunnion, name)
            thing = getattr(thing, "__func__", thing)
            if inspect.isclass(thing) or not callable(thing):
                continue
            if set(inspect.signature(thing).parameters) - {"self", "cls", "slf"}:
                yield name


def test_no_function_is_left_out():
    tried = {name.rpartition(".")[2] for name in CALLS} | {"run"}
    assert not sorted(set(public_functions()) - tried)


def test_a_signature_names_what_is_missing():
    with pytest.raises(TypeError, match="axis"):
        MACHINE.inverse(TIP)


@pytest.mark.parametrize(
    "message, place, text",
    [
        ("a b/c.ngc:3:4: bad\n  help: x", ("a b/c.ngc", 3, 4), "bad"),
        ("missing.toml: no such file", ("missing.toml", None, None), "no such file"),
        ("./folder: is a folder", ("./folder", None, None), "is a folder"),
        ("C:\\a b\\c.toml:1:2: bad", ("C:\\a b\\c.toml", 1, 2), "bad"),
        ("limits:4:7: bad", ("limits", 4, 7), "bad"),
        ("table: end speed 50 is too high", (None, None, None), "table: end speed 50 is too high"),
        ("at (u, v) = (0.5, 0.5) no pose: flat", (None, None, None), "at (u, v) = (0.5, 0.5) no pose: flat"),
        ("0.5 mm off: too far", (None, None, None), "0.5 mm off: too far"),
    ],
)
def test_the_place_of_a_message_is_a_file(message, place, text):
    error = trunnion.InputError(message)
    assert (error.file, error.line, error.column) == place and error.message == text
