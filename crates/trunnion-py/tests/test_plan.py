"""Speed plans."""

import signal
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trunnion

LIMITS = {"X": (500, 5000, 1e5), "Y": (400, 4000, 8e4)}


def circle(rows=200, radius=20.0):
    s = np.linspace(0, 2 * np.pi * radius, rows)
    a = s / radius
    return {
        "s": s,
        "X": radius * np.cos(a), "X1": -np.sin(a), "X2": -np.cos(a) / radius,
        "Y": radius * np.sin(a), "Y1": np.cos(a), "Y2": -np.sin(a) / radius,
    }


@pytest.mark.parametrize("method", ["jerk", "optimal"])
def test_limits_are_kept_at_every_sample(method):
    plan = trunnion.plan(circle(), LIMITS, method)
    assert plan.within_limits and plan.axes == ["X", "Y"]
    assert plan.lower_bound <= plan.duration
    motion = plan.sample(0.0005)
    vel, acc, jerk = np.array([LIMITS[name] for name in plan.axes]).T
    assert (np.abs(motion.velocity) <= vel * (1 + 1e-6)).all()
    assert (np.abs(motion.acceleration) <= acc * (1 + 1e-6)).all()
    if method == "jerk":
        assert (np.abs(motion.jerk) <= jerk * (1 + 1e-6)).all()
    t, position, *_ = motion
    assert t[-1] == pytest.approx(plan.duration, abs=5e-4) and position.shape == (len(t), 2)
    np.testing.assert_allclose(np.hypot(*position.T), 20, atol=1e-4)
    assert plan.s[0] == 0 and (np.diff(plan.t) > 0).all()
    assert "<svg" in plan._repr_html_() and len(plan.to_pandas()) == len(plan.s)


def test_a_straight_line_takes_the_time_of_the_textbook():
    table = {"s": [0, 1, 2], "X": [0, 10, 20], "X1": [10] * 3, "X2": [0] * 3}
    # 20 mm with 1000 mm/s2: half of them up, half down.
    assert trunnion.plan(table, {"X": (1e4, 1000)}, "optimal").duration == pytest.approx(2 * np.sqrt(0.02), rel=1e-6)


def test_all_forms_of_a_table_are_the_same(tmp_path):
    pandas = pytest.importorskip("pandas")
    table = circle()
    first = trunnion.plan(table, LIMITS).duration
    frame = pandas.DataFrame(table)
    frame.to_csv(tmp_path / "path.csv", index=False)
    assert trunnion.plan(frame, LIMITS).duration == first
    assert trunnion.plan(tmp_path / "path.csv", LIMITS).duration == first
    assert trunnion.plan(frame.to_records(index=False), LIMITS).duration == first
    array = np.stack([table[name] for name in table], axis=1)
    assert trunnion.plan(array, LIMITS, axes=["X", "Y"]).duration == first
    (tmp_path / "limits.toml").write_text(trunnion.Limits(LIMITS).to_toml())
    assert trunnion.plan(table, tmp_path / "limits.toml").duration == first


def test_a_window_is_no_faster_than_the_whole():
    whole = trunnion.plan(circle(), LIMITS, "optimal")
    streamed = trunnion.plan(circle(), LIMITS, "optimal", window=64)
    assert whole.duration <= streamed.duration * 1.01 and streamed.within_limits


@given(st.integers(0, 10**6), st.integers(4, 40))
@settings(max_examples=25, deadline=None)
def test_random_paths_are_planned_within_their_limits(seed, rows):
    rng = np.random.default_rng(seed)
    s = np.concatenate([[0], np.cumsum(rng.uniform(0.5, 2, rows))])
    k, p = rng.uniform(0.01, 0.3, 2), rng.uniform(0, 6, 2)
    table = {"s": s}
    for name, k, p in zip("XY", k, p):
        table |= {name: np.sin(k * s + p) / k, f"{name}1": np.cos(k * s + p), f"{name}2": -k * np.sin(k * s + p)}
    plan = trunnion.plan(table, LIMITS, "optimal")
    assert plan.within_limits and plan.lower_bound <= plan.duration * (1 + 1e-9)


def test_faults_name_row_and_column():
    table = circle()
    wrong = dict(table, s=table["s"][::-1].copy())
    with pytest.raises(trunnion.InputError, match="below") as found:
        trunnion.plan(wrong, LIMITS)
    assert found.value.line == 2 and found.value.file == "table"
    with pytest.raises(trunnion.InputError, match="axis Y has no limits"):
        trunnion.plan(table, {"X": LIMITS["X"]})
    with pytest.raises(trunnion.InputError, match="no jerk limit"):
        trunnion.plan(table, {"X": (500, 5000), "Y": (400, 4000)})
    table["X"][3] = np.nan
    with pytest.raises(trunnion.ArgumentError) as found:
        trunnion.plan(table, LIMITS)
    assert found.value.argument == "table" and found.value.index == (3,)


@pytest.mark.parametrize("method", ["jerk", "optimal"])
def test_a_stream_ends_where_the_path_does(method):
    table = circle()
    rows = np.stack([table[name] for name in table], axis=1)
    stream = trunnion.Stream(LIMITS, method, window=128, step=1.0)
    steps = np.concatenate([stream.push(rows[:100]), stream.push(rows[100:]), stream.finish()])
    assert steps[0, 0] == 0 and steps[-1, 1] == pytest.approx(table["s"][-1])
    np.testing.assert_allclose(steps[1:, 0], steps[:-1, 1], atol=1e-9)
    assert steps[-1, 5] == pytest.approx(0, abs=1e-6)
    assert steps[-1, 2] + steps[-1, 3] == pytest.approx(stream.time)
    assert stream.time >= trunnion.plan(table, LIMITS, "optimal").lower_bound * (1 - 1e-9)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer signals")
def test_ctrl_c_ends_a_push():
    s = np.linspace(0, 4000, 40_000)
    rows = np.stack([s, 40 * np.sin(s / 40), np.cos(s / 40), -np.sin(s / 40) / 40], axis=1)

    class Enough(Exception):
        pass

    def stop(*_):
        raise Enough

    start = time.process_time()
    trunnion.Stream({"X": LIMITS["X"]}).push(rows[:1000])
    part = time.process_time() - start
    before = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        start = time.process_time()
        with pytest.raises(Enough):
            trunnion.Stream({"X": LIMITS["X"]}).push(rows)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    # The whole would take more than forty times as long as the part.
    assert time.process_time() - start < 2 * part


def edited(**columns):
    return {**circle(), **columns}


@pytest.mark.parametrize(
    "call, message, remedy",
    [
        (lambda: trunnion.plan(circle(), trunnion.Limits(LIMITS, path={"start": 1e4, "feed": 1e6}), "optimal"), "start speed", "start slower"),
        (lambda: trunnion.plan(circle(), trunnion.Limits(LIMITS, path={"end": 1e4, "feed": 1e6}), "optimal"), "end speed", "end slower"),
        (lambda: trunnion.plan(circle(), {"X": (500, 5000), "Y": (400, 4000)}), "no jerk limit", "add `jerk"),
        (lambda: trunnion.plan(circle(), {"X": (500, 5000, 1e5)}), "has no limits", "add [axis.Y]"),
        (lambda: trunnion.plan(edited(s=circle()["s"][::-1].copy()), LIMITS), "is below", "sort the rows"),
        (lambda: trunnion.plan(circle(rows=1), LIMITS), "at least two rows", "add its other rows"),
        (lambda: trunnion.plan(circle(), {**LIMITS, "X": (0, 5000, 1e5)}), "must be above 0", "Largest velocity"),
        (lambda: trunnion.plan(edited(X=circle()["X"] * 1e30), LIMITS, "optimal"), "at most 1e24", "larger units"),
        (lambda: trunnion.plan(edited(speed=np.zeros(200)), LIMITS, "given"), "given speed is zero", "give a speed"),
        (lambda: trunnion.plan(circle(), LIMITS, "blocks", window=64), "window goes with", "leave window out"),
        (lambda: trunnion.plan(circle(), LIMITS, "jerk", no_guarantee=True), "no_guarantee goes with", "leave it out"),
        (lambda: trunnion.plan(circle(), trunnion.Limits(LIMITS, path={"start": 1.0}), window=64), "at rest", "leave window out"),
        (lambda: trunnion.Stream(LIMITS, window=2), "the window is 2 rows", "take 512 rows"),
        (lambda: trunnion.Stream({"X": (-1, 2, 3)}), "velocity limit", "state the limit"),
        (lambda: trunnion.Stream({"X": (1, 2)}), "jerk limit of axis", "state the limit"),
        (lambda: trunnion.Stream(LIMITS).push([[0, 0, 1, 0, 0, 1, 0], [0, 1, 1, 0, 1, 1, 0]]), "does not increase", "remove repeated nodes"),
    ],
)
def test_errors_of_planning_have_a_remedy(call, message, remedy):
    with pytest.raises(trunnion.InputError) as found:
        call()
    error = found.value
    assert message in error.message and remedy in error.remedy, (error.message, error.remedy)
    # Each says it once.
    assert error.remedy not in error.message
