"""Long calls let signals and other threads in: a call that is interrupted ends long before it would have ended."""

import signal
import threading
import time

import numpy as np
import pytest

import trunnion

MACHINE = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505), tool_length=120)
U = np.linspace(-1, 1, 8)
PART = trunnion.Part.from_net(np.stack([*np.meshgrid(40 * U, 30 * U, indexing="ij"), 8 * np.outer(np.cos(2 * U), np.sin(U))], -1))
FACE, BULL = PART.faces[0], trunnion.Cutter.bull(5, 3)
RANDOM = np.random.default_rng(1)


def poses(count):
    t = np.linspace(0, 1000, count)
    tip = np.stack([60 * np.cos(t), 60 * np.sin(t), 5 * np.sin(t)], 1)
    axis = np.stack([0.4 + 0.2 * np.sin(t), 0.2 * np.cos(t), np.ones_like(t)], 1)
    return tip, axis / np.linalg.norm(axis, axis=1)[:, None]


def rates(count):
    tip, axis = (np.zeros((count, 4, 3)) for _ in range(2))
    (tip[:, 0], axis[:, 0]), tip[:, 1, 0] = poses(count), 1.0
    return tip, axis


def inverse():
    arrays = poses(4_000_000)
    return lambda: MACHINE.inverse(*arrays)


def jets():
    arrays = rates(400_000)
    return lambda: MACHINE.jets(*arrays)


def evaluation(name):
    uv = RANDOM.random((1_500_000, 2))
    return lambda: getattr(FACE, name)(uv)


def closest():
    points = FACE.point(RANDOM.random((33_000, 2))) + 0.1
    return lambda: FACE.closest(points)


def drop():
    places = RANDOM.uniform(-30, 30, (60_000, 2))
    return lambda: trunnion.drop_cutter(PART, BULL, places, chord=0.05)


def sample():
    plan = trunnion.plan({"s": [0, 1], "X": [0, 10], "X1": [10, 10], "X2": [0, 0]}, {"X": (100, 1000, 20000)})
    return lambda: plan.sample(1e-7)


def window():
    s = np.linspace(0, 15, 150)
    table = {"s": s, "X": 50 * np.sin(s / 20), "X1": 2.5 * np.cos(s / 20), "X2": -0.125 * np.sin(s / 20)}
    return lambda: trunnion.plan(table, {"X": (100, 1000, 20000)}, window=64)


CALLS = {
    "inverse": inverse, "jets": jets, "curvature": lambda: evaluation("curvature"), "closest": closest, "drop": drop,
    "sample": sample, "window": window,
}


class Heard(Exception):
    pass


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers")
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_a_signal_ends_a_call(name):
    call = CALLS[name]()

    def raised(*_):
        raise Heard

    start = time.perf_counter()
    call()
    whole = time.perf_counter() - start
    before = signal.signal(signal.SIGALRM, raised)
    try:
        start = time.perf_counter()
        with pytest.raises(Heard):
            signal.setitimer(signal.ITIMER_REAL, 0.1 * whole)
            call()
        assert time.perf_counter() - start < 0.6 * whole
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CALLS)
def test_a_call_leaves_the_interpreter_to_others(name):
    call, ended, turns = CALLS[name](), threading.Event(), []

    def others():
        while not ended.is_set():
            turns.append(time.perf_counter())
            time.sleep(0.005)

    thread = threading.Thread(target=others)
    thread.start()
    try:
        start = time.perf_counter()
        call()
        end = time.perf_counter()
    finally:
        ended.set()
        thread.join()
    within = [start, *(one for one in turns if start < one < end), end]
    assert max(np.diff(within)) < 0.6 * (end - start)
