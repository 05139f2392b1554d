#!/usr/bin/env python3
"""Plans the same paths with trunnion and with its peers, side by side in one run.

  cargo build --release && python3 run.py [--rows 1000,10000,100000] [--families walk,raster,...] [--jerk]

Peers that are not installed are left out: toppra (pip install toppra), COPP (pip install copp-py), Ruckig (pip
install ruckig). Times are thread CPU time a point; --jerk also plans with jerk limits: COPP's TOPP3, whose passes go
on until one gains less than a thousandth, with 1000 rows only; Ruckig from state to state on the family `line`.
"""
import argparse
import json
import logging
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import workloads

VELOCITY = np.array([500.0, 500.0, 500.0, 6.0, 10.0])
ACCELERATION = np.array([5000.0, 5000.0, 5000.0, 60.0, 100.0])
JERK = np.array([1e5, 1e5, 1e5, 1200.0, 2000.0])
# toppra fails on some of the paths with s as it is.
SCALE = 0.01
# Passes of TOPP3 at most, and what one has to gain for another.
PASSES, CONVERGED = 8, 1e-3
PROGRAM = pathlib.Path(__file__).parent / "target/release/trunnion-feed-peers"


def duration(s, x):
    root = np.sqrt(np.maximum(x, 0))
    return float(np.sum(2 * np.diff(s) / (root[:-1] + root[1:])))


def timed(plan, repeats=3):
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        found = plan()
        times.append(time.thread_time() - start)
    return found, sorted(times)[repeats // 2]


def trunnion(name, method, repeats):
    found = subprocess.run([PROGRAM, f"{name}.bin", method, str(repeats)], capture_output=True, text=True, check=True)
    return [json.loads(line) for line in found.stdout.splitlines()]


def toppra(name):
    import toppra as ta
    from toppra.interpolator import AbstractGeometricPath
    from scipy.interpolate import BSpline

    logging.disable(logging.CRITICAL)
    saved = np.load(f"{name}.npz")
    spline = BSpline(saved["t"] * SCALE, saved["c"], int(saved["k"]))
    orders = [spline, spline.derivative(1), spline.derivative(2)]
    s = saved["s"] * SCALE

    class Path(AbstractGeometricPath):
        dof = 5
        path_interval = np.array([s[0], s[-1]])

        def __call__(self, at, order=0):
            return orders[order](at)

    velocity = ta.constraint.JointVelocityConstraint(np.column_stack([-VELOCITY, VELOCITY]))
    interpolation = ta.constraint.DiscretizationType.Interpolation
    acceleration = ta.constraint.JointAccelerationConstraint(
        np.column_stack([-ACCELERATION, ACCELERATION]), discretization_scheme=interpolation)
    solver = ta.algorithm.TOPPRA([velocity, acceleration], Path(), gridpoints=s, solver_wrapper="seidel",
                                 parametrizer="ParametrizeConstAccel")
    found, seconds = timed(lambda: solver.compute_parameterization(0, 0, return_data=True), 1)
    if found[1] is None:
        return {"name": "toppra", "duration": float("nan"), "ns": seconds / len(s) * 1e9}
    return {"name": "toppra", "duration": duration(s, found[1] ** 2), "ns": seconds / len(s) * 1e9}


def copp(name, jerk):
    import copp_py

    rows = np.fromfile(f"{name}.bin")[2:].reshape(-1, 21)
    count, s = len(rows), rows[:, 0] * SCALE
    axes = [np.ascontiguousarray(rows[:, 1 + 5 * k:6 + 5 * k]) / SCALE**k for k in range(4)]
    robot = copp_py.Robot(5, capacity=count)
    robot.append_s(np.ascontiguousarray(s))
    robot.set_q(*axes[:3], 0, dddq=axes[3])
    robot.add_velocity_limits(VELOCITY, -VELOCITY, start_idx_s=0, length=count)
    robot.add_acceleration_limits(ACCELERATION, -ACCELERATION, start_idx_s=0, length=count)
    second = copp_py.solver.topp2_ra
    problem = lambda: second.Problem(robot.constraints, idx_s_interval=(0, count - 1), a_boundary=(0.0, 0.0))
    x, seconds = timed(lambda: np.asarray(second.solve(problem())))
    if not jerk:
        return {"name": "COPP TOPP2-RA", "duration": duration(s, x), "ns": seconds / count * 1e9}
    robot.add_jerk_limits(JERK, -JERK, start_idx_s=0, length=count)
    robot.constraints.amax_substitute(x, 0)
    third = copp_py.solver.topp3_socp

    def passes():
        around, line, before = {}, x, np.inf
        for count in range(1, PASSES + 1):
            found = third.solve(third.Problem(robot.constraints, line, **around), third.Options(allow_almost_solved=True))
            total = float(copp_py.interpolation.s_to_t_topp3(s, found)[0])
            if total > (1 - CONVERGED) * before:
                break
            line, around, before = np.asarray(found.a), {"b_linearization": np.asarray(found.b)}, total
        return min(total, before), count

    (total, needed), seconds = timed(passes, 1)
    return {"name": f"COPP TOPP3, {needed} passes", "duration": total, "ns": seconds / count * 1e9}


def ruckig(rows):
    from ruckig import InputParameter, Result, Ruckig, Synchronization, Trajectory

    move = InputParameter(5)
    move.max_velocity, move.max_acceleration, move.max_jerk = list(VELOCITY), list(ACCELERATION), list(JERK)
    move.current_position, move.target_position = map(list, workloads.LINE)
    move.synchronization = Synchronization.Phase
    planner, found = Ruckig(5, 0.001), Trajectory(5)
    result, seconds = timed(lambda: planner.calculate(move, found))
    if result != Result.Working:
        raise RuntimeError(result)
    return {"name": "Ruckig, the whole move", "duration": found.duration, "ns": seconds / rows * 1e9}


def peers(name, family, jerk, rows):
    if jerk and rows > 1000:
        return
    plans = [lambda: copp(name, jerk)] if jerk else [lambda: toppra(name), lambda: copp(name, False)]
    if jerk and family == "line":
        plans.append(lambda: ruckig(rows))
    for plan in plans:
        try:
            yield plan()
        except ImportError as missing:
            print(f"    ({missing}: left out)")
        except Exception as error:  # a peer that fails is a result
            print(f"    ({type(error).__name__}: {str(error)[:90]})")


def show(name, family, method, rows):
    found = trunnion(name, method, 5 if method == "jerk" else max(5, 2_000_000 // rows))
    base = found[0]
    for plan in found + list(peers(name, family, method == "jerk", rows)):
        checked = "".join(f"  {key[0]} {plan[key]:.6f}" for key in ("velocity", "acceleration", "jerk") if key in plan)
        print(f"    {plan['name']:<22}{plan['duration']:>13.6f} s{plan['ns']:>12.0f} ns/pt"
              f"{plan['ns'] / base['ns']:>9.2f} x{plan['duration'] / base['duration'] - 1:>+11.1e}{checked}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", default="1000,10000,100000")
    parser.add_argument("--families", default=",".join(workloads.FAMILIES))
    parser.add_argument("--jerk", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for rows in map(int, arguments.rows.split(",")):
            for family in arguments.families.split(","):
                name = workloads.write(pathlib.Path(folder), family, rows)
                for method in ["optimal"] + ["jerk"] * arguments.jerk:
                    print(f"{family} {rows}, {method}", flush=True)
                    show(name, family, method, rows)


if __name__ == "__main__":
    main()
