"""Forward map, inverse and derivatives."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trunnion

MACHINES = trunnion.built_in()
SETUP = dict(origin=(-10.0, 4.0, -30.0), rotation=(0.1, -0.2, 0.3), tool_length=120.0)


WHERE = dict(origin=(-381.0, -254.0, -505.0), tool_length=120.0)


def random_axes(machine, count, seed=1):
    travel = machine.travel()
    low, high = np.maximum(travel[:, 0], -500.0), np.minimum(travel[:, 1], 500.0)
    low[3:], high[3:] = np.maximum(low[3:], -3.0), np.minimum(high[3:], 3.0)
    return np.random.default_rng(seed).uniform(low, high, (count, 5))


@pytest.mark.parametrize("name", MACHINES)
def test_inverse_of_forward_is_the_pose(name):
    machine = trunnion.Machine(name, **SETUP)
    tip, axis = machine.forward(random_axes(machine, 200))
    assert tip.shape == axis.shape == (200, 3) and tip.flags.c_contiguous
    both = machine.inverse(tip, axis, all=True)
    assert both.shape == (200, 2, 5)
    for branch in range(2):
        q = both[:, branch]
        known = np.isfinite(q).all(axis=1)
        again, direction = machine.forward(q[known])
        np.testing.assert_allclose(again, tip[known], atol=1e-8)
        np.testing.assert_allclose(direction, axis[known], atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.sampled_from(MACHINES))
@settings(max_examples=60, deadline=None)
def test_inverse_continues_from_near(seed, name):
    machine = trunnion.Machine(name)
    q = random_axes(machine, 1, seed)[0]
    tip, axis = machine.forward(q)
    found = machine.inverse(tip, axis, near=q)
    again, direction = machine.forward(found)
    np.testing.assert_allclose(again, tip, atol=1e-8)
    np.testing.assert_allclose(direction, axis, atol=1e-9)


def test_degrees_and_radians_agree():
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    q = random_axes(machine, 20)
    degrees = q.copy()
    degrees[:, 3:] = np.degrees(q[:, 3:])
    for a, b in zip(machine.forward(q), machine.forward(degrees, deg=True)):
        np.testing.assert_allclose(a, b, atol=1e-12)
    turned = trunnion.Machine("bc-trunnion", rotation=(0, 20, 0), deg=True)
    np.testing.assert_allclose(turned.rotation(deg=True), [0, 20, 0], atol=1e-12)


def test_one_pose_is_a_row_of_many():
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    tip, axis = machine.forward(random_axes(machine, 5))
    one = machine.inverse(tip[0], axis[0])
    assert one.shape == (5,)
    np.testing.assert_array_equal(machine.inverse(tip, axis)[0], one)
    assert machine.inverse(tip[0], axis[0], all=True).shape == (2, 5)
    assert machine.inverse(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 5)


def test_lists_and_whole_numbers_are_taken():
    machine = trunnion.Machine("bc-trunnion", **WHERE)
    q = machine.inverse([[10, 0, 0]], [[0, 0, 1]])
    np.testing.assert_array_equal(machine.inverse(np.array([[10, 0, 0]]), np.array([[0, 0, 1]])), q)


def test_poses_out_of_reach_are_nan_and_named():
    machine = trunnion.Machine("bc-trunnion", **WHERE)
    with pytest.warns(trunnion.UnreachableWarning, match="pose 1: .*outside|pose 1: .*misses"):
        q = machine.inverse([[0, 0, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, -1]])
    assert np.isfinite(q[0]).all() and np.isnan(q[1]).all()


def test_jets_are_derivatives():
    machine = trunnion.Machine("bc-trunnion", **WHERE)
    h, t = 1e-4, 0.3

    def pose(t):
        axis = np.array([0.3 + 0.2 * t, 0.1 * t, 1.0])
        return np.array([10 * t, t * t, -t]), axis / np.linalg.norm(axis)

    tips = np.array([[3.0, 0.09, -0.3], [10, 0.6, -1], [0, 2, 0], [0, 0, 0]])
    axes = np.array([[0.36, 0.03, 1.0], [0.2, 0.1, 0], [0, 0, 0], [0, 0, 0]])
    q = machine.jets(tips, axes)
    assert q.shape == (4, 5)
    before, here, after = (machine.inverse(*pose(x), near=q[0]) for x in (t - h, t, t + h))
    np.testing.assert_allclose(q[0], here, atol=1e-10)
    np.testing.assert_allclose(q[1], (after - before) / (2 * h), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(q[2], (after - 2 * here + before) / h**2, rtol=1e-3, atol=1e-3)
    assert machine.jets(tips[None], axes[None], arc_length=True).shape == (1, 4, 5)


def test_figures_of_the_machine():
    machine = trunnion.Machine("bc-trunnion")
    assert machine.axes == ["X", "Y", "Z", "C", "B"]
    assert machine.travel(deg=True).shape == (5, 2)
    for figure in (machine.velocity, machine.acceleration, machine.jerk, machine.home):
        assert figure().shape == (5,)
        np.testing.assert_allclose(np.degrees(figure()[3:]), figure(deg=True)[3:])
    directions = machine.singular_directions()
    assert machine.singular_angle(directions).max() < 1e-12
    assert machine.singular_angle([1.0, 0, 0], deg=True) == pytest.approx(90)
    assert machine._repr_html_().lstrip().startswith("<svg")


def test_machines_come_from_files_and_dicts(tmp_path):
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    file = tmp_path / "own.toml"
    file.write_text(machine.to_toml())
    data = trunnion._trunnion.toml_data(machine.to_toml())
    q = random_axes(machine, 3)
    for same in (trunnion.Machine(file, **SETUP), trunnion.Machine(data, **SETUP), pickle.loads(pickle.dumps(machine))):
        np.testing.assert_allclose(same.forward(q)[0], machine.forward(q)[0], atol=1e-12)


def test_a_faulty_machine_file_has_places(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(trunnion.Machine("bc-trunnion").to_toml().replace("chain", "chian"))
    with pytest.raises(trunnion.InputError) as found:
        trunnion.Machine(file)
    error = found.value
    assert isinstance(error, ValueError) and error.line >= 1 and error.column >= 1
    assert error.file == str(file) and "chain" in error.remedy + str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (again.message, again.line, again.remedy) == (error.message, error.line, error.remedy)
    with pytest.raises(trunnion.InputError, match="did you mean the built-in machine"):
        trunnion.Machine("bc-trunion")


@pytest.mark.parametrize(
    "tip, axis, argument, index",
    [
        ([[0, 0]], [[0, 0, 1]], "tip", None),
        ([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]], "axis", None),
        ([[0, 0, np.nan]], [[0, 0, 1]], "tip", (0, 2)),
        ([[0, 0, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 2]], "axis", (1,)),
        ("tip", [[0, 0, 1]], "tip", None),
        (None, [[0, 0, 1]], "tip", None),
        (np.zeros((1, 3), dtype=np.float32), [[0, 0, 1]], "tip", None),
        (np.zeros((1, 3), dtype=complex), [[0, 0, 1]], "tip", None),
        (np.zeros((1, 3), dtype=object), [[0, 0, 1]], "tip", None),
        (np.zeros((3, 1)).T[:, ::-1], [[0, 0, 1]], "tip", None),
        (np.zeros((2, 6))[:, ::2], [[0, 0, 1]] * 2, "tip", None),
        ([[0, 0, "a"]], [[0, 0, 1]], "tip", None),
        ([[0, 0, 0], [0, 0]], [[0, 0, 1]] * 2, "tip", None),
    ],
)
def test_wrong_arguments_are_named(tip, axis, argument, index):
    with pytest.raises(ValueError) as found:
        trunnion.Machine("bc-trunnion").inverse(tip, axis)
    assert found.value.argument == argument and found.value.index == index
    assert argument in str(found.value)


def test_remedies_name_what_a_wheel_brings():
    with pytest.raises(trunnion.InputError) as found:
        trunnion.Machine("no-such")
    assert found.value.remedy == "`trunnion.built_in()` has the built-in ones"
