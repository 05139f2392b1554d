"""Figures of the Python package beside its peers, as ratios of CPU time in one run.

Needs the package; toppra, copp-py and opencamlib where their rows are wanted; and for the first row the example of the library:

    cargo build --release -p trunnion --example inverse_rate
    python benches/peers/python/figures.py target/release/examples/inverse_rate
"""

from __future__ import annotations

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
import warnings

import numpy as np

import trunnion

ROOT = pathlib.Path(__file__).resolve().parents[3]
#: Pairs of audits with one and with two workers.
PAIRS = 10
SETUP = dict(origin=(-381.0, -254.0, -505.0), tool_length=120.0)
#: Time of opencamlib for one location of a bull-nose cutter on 5000 triangles, measured before [s].
OPENCAMLIB = 3.1e-3


def least(function, repeats=5):
    """Returns the least CPU time over all repeats, of all threads [s]."""
    cpu = []
    for _ in range(repeats):
        start = time.process_time()
        function()
        cpu.append(time.process_time() - start)
    return min(cpu)


def row(work, figure, least, aim):
    print(f"{work:<58} {figure:<26} at least {least:<10} aim {aim}", flush=True)


def inverse(example):
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    t = np.linspace(0, 2000, 1_000_000)
    tip = np.stack([60 * np.cos(t / 100), 60 * np.sin(t / 100), 5 * np.sin(t)], axis=1)
    axis = np.stack([0.4 + 0.2 * np.sin(t), 0.2 * np.cos(t), np.ones_like(t)], axis=1)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    ours = least(lambda: machine.inverse(tip, axis), 7)
    if example:
        with tempfile.NamedTemporaryFile(suffix=".f64") as file:
            file.write(np.concatenate([tip, axis], axis=1).tobytes())
            file.flush()
            theirs = float(subprocess.run([example, file.name, "7"], capture_output=True, check=True).stdout)
        figure = f"{ours / theirs:.2f} ({1e9 * ours / len(t):.0f} / {1e9 * theirs / len(t):.0f} ns)"
        row("inverse of 10^6 poses, Python / Rust", figure, "1.3", "1.1")
    one, direction = tip[0].copy(), axis[0].copy()

    def calls():
        for _ in range(20000):
            machine.inverse(one, direction)

    each = least(calls)
    row("one pose per call", f"{1e6 * each / 20000:.2f} us", "5 us", "2 us")


def plan():
    rows, velocity, acceleration = 10_000, np.full(5, 200.0), np.full(5, 2000.0)
    # s in units of 100 mm, as in benches/peers/feed: toppra fails on some paths with s in mm.
    s = np.linspace(0, 20, rows)
    k, size = np.array([5.0, 7.0, 9.0, 11.0, 13.0]), np.array([20.0, 14.0, 11.0, 9.0, 7.0])
    orders = [
        size * np.sin(np.outer(s, k)),
        size * k * np.cos(np.outer(s, k)),
        -size * k**2 * np.sin(np.outer(s, k)),
        -size * k**3 * np.cos(np.outer(s, k)),
    ]
    table, limits = {"s": s}, {}
    for axis, name in enumerate("XYZCB"):
        table |= {f"{name}{order or ''}": np.ascontiguousarray(orders[order][:, axis]) for order in range(3)}
        limits[name] = (200.0, 2000.0)
    found = trunnion.plan(table, limits, "optimal", no_guarantee=True)
    # What every peer gives as well: from arrays of the path to an array of speeds, limits at rows.
    at_rows = least(lambda: trunnion.plan(table, limits, "optimal", no_guarantee=True).speed, 15)
    everywhere = least(lambda: trunnion.plan(table, limits, "optimal").speed)
    words = f"{1e3 * at_rows:.1f} ms at rows, {1e3 * everywhere:.1f} ms everywhere, {found.duration:.4f} s"
    row("plan of 10^4 rows, optimal", words, "", "")
    for name, peer in (("toppra", _toppra), ("copp-py", _copp)):
        try:
            whole, solver, duration = peer(s, orders, velocity, acceleration, (size, k))
        except ImportError as error:
            print(f"  {error}: no row")
            continue
        except Exception as error:  # a peer that fails is a result
            print(f"  {name} fails: {type(error).__name__}: {error}")
            continue
        words = f"{whole / at_rows:.1f} x ({1e3 * whole:.1f} ms, {duration:.4f} s)"
        row(f"  beside {name}, from arrays to speeds", words, *(("50 x", "150 x") if name == "toppra" else ("5 x", "8 x")))
        words = f"{solver / at_rows:.1f} x ({1e3 * solver:.1f} ms)"
        row(f"  our whole call beside the solver of {name} alone", words, "", "")


def _seconds(s, x):
    root = np.sqrt(np.maximum(x, 0))
    return float(np.sum(2 * np.diff(s) / (root[:-1] + root[1:])))


def _toppra(s, orders, velocity, acceleration, path):
    import toppra
    from toppra.interpolator import AbstractGeometricPath

    toppra.setup_logging("CRITICAL")
    size, k = path

    class Path(AbstractGeometricPath):
        dof = 5
        path_interval = np.array([s[0], s[-1]])

        def __call__(self, at, order=0):
            x = np.multiply.outer(np.asarray(at), k)
            return (size * np.sin(x), size * k * np.cos(x), -size * k**2 * np.sin(x))[order]

    bounds = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-velocity, velocity])),
        toppra.constraint.JointAccelerationConstraint(
            np.column_stack([-acceleration, acceleration]),
            discretization_scheme=toppra.constraint.DiscretizationType.Interpolation,
        ),
    ]
    def built():
        return toppra.algorithm.TOPPRA(
            bounds, Path(), gridpoints=s, solver_wrapper="seidel", parametrizer="ParametrizeConstAccel"
        )

    found = []

    def solved(solver):
        found.append(solver.compute_parameterization(0, 0, return_data=True))

    whole, ready = least(lambda: solved(built()), 3), built()
    alone = least(lambda: solved(ready), 3)
    speeds = found[-1][1]
    return whole, alone, float("nan") if speeds is None else _seconds(s, speeds**2)


def _copp(s, orders, velocity, acceleration, path):
    import copp_py

    s, orders = np.ascontiguousarray(s), [np.ascontiguousarray(one) for one in orders]
    solver = copp_py.solver.topp2_ra

    def built():
        robot = copp_py.Robot(5, capacity=len(s))
        robot.append_s(s)
        robot.set_q(*orders[:3], 0)
        robot.add_velocity_limits(velocity, -velocity, start_idx_s=0, length=len(s))
        robot.add_acceleration_limits(acceleration, -acceleration, start_idx_s=0, length=len(s))
        return robot

    def solve(robot):
        problem = solver.Problem(robot.constraints, idx_s_interval=(0, len(s) - 1), a_boundary=(0.0, 0.0))
        return np.asarray(solver.solve(problem))

    whole, ready = least(lambda: solve(built()), 15), built()
    return whole, least(lambda: solve(ready), 15), _seconds(s, solve(ready))


def drop():
    part = trunnion.Part.read(ROOT / "fixtures" / "bezier-patch" / "patch.json")
    face = part.faces[0]
    u, v = np.meshgrid(np.linspace(0, 1, 51), np.linspace(0, 1, 51), indexing="ij")
    vertices = face.point(np.stack([u.ravel(), v.ravel()], axis=1))
    at = np.arange(51 * 51).reshape(51, 51)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    cutter = trunnion.Cutter.bull(10, 6)
    places = np.random.default_rng(1).uniform(-45, 45, (20000, 2))
    each = least(lambda: trunnion.drop_cutter((vertices, triangles), cutter, places)) / len(places)
    words = f"{1e6 * each:.2f} us a location on one core, index included"
    row(f"drop cutter, bull-nose d32 r6, {len(triangles)} triangles", words, "", "")
    try:
        from opencamlib import ocl
    except ImportError:
        row("  beside the 3.1 ms of opencamlib (not installed)", f"{OPENCAMLIB / each:.0f} x", "10 x", "50 x")
        return
    surface = ocl.STLSurf()
    for triangle in triangles:
        surface.addTriangle(ocl.Triangle(*(ocl.Point(*map(float, vertices[corner])) for corner in triangle)))
    operation = ocl.BatchDropCutter()
    operation.setSTL(surface)
    # It is not kept by the operation: without a name here it is gone before the run, which then ends the interpreter.
    bull = ocl.BullCutter(32, 6, 100)
    operation.setCutter(bull)
    operation.setThreads(1)
    few = places[:400]
    for place in few:
        operation.appendPoint(ocl.CLPoint(float(place[0]), float(place[1]), -1000.0))
    peer = least(operation.run, 1) / len(few)
    theirs = np.array([point.z for point in operation.getCLPoints()])
    gap = np.abs(theirs - trunnion.drop_cutter((vertices, triangles), cutter, few).z).max()
    words = f"{peer / each:.0f} x ({1e6 * peer:.0f} us, heights {gap:.1e} mm apart)"
    row("  beside opencamlib, one thread each", words, "10 x", "50 x")


def package():
    code = "import time; a = time.perf_counter(); import trunnion; print(time.perf_counter() - a)"
    times = [float(subprocess.run([sys.executable, "-c", code], capture_output=True).stdout) for _ in range(7)]
    row("import", f"{1e3 * min(times):.0f} ms", "100 ms", "30 ms")
    import zlib

    native = pathlib.Path(trunnion._trunnion.__file__).read_bytes()
    row("module, deflated as in a wheel", f"{len(zlib.compress(native, 6)) / 1e6:.1f} MB", "12 MB", "6 MB")


def fleet():
    machine = trunnion.Machine("bc-trunnion", **SETUP)
    path = trunnion.Path.read(ROOT / "examples" / "wave" / "wave.cls")
    # Moves of a tenth of a millimetre, as CAM systems write them; and those of the file, where the start of a worker counts.
    for moves in (path.interpolate(0.1, 0.01), path):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", trunnion.TrunnionWarning)
            text = trunnion.post(moves.to_cl().encode(), machine, suffix=".cls", dialect="g93").text
        with tempfile.TemporaryDirectory() as folder:
            names = []
            for index in range(200):
                name = os.path.join(folder, f"part{index}.ngc")
                with open(name, "w") as out:
                    out.write(text.replace("M2", f"(copy {index})\nM2"))
                names.append(name)
            # In turn, so that a disturbance meets all.
            pairs, plain = [], []
            for _ in range(PAIRS):
                pairs.append([_audited(names, machine, workers) for workers in (1, 2)])
                plain.append([_apart(names, processes) for processes in (1, 2)])
        count = len(text.splitlines())
        _ratios(f"fleet of 200 checks of {count} lines, 2 workers / 1", pairs, ("1.8", "1.95"))
        # The same work without a fleet: the part that the machine takes, whose cores share memory and caches.
        _ratios("  plain processes with a half each / one with all", plain, ("", ""))


def _ratios(words, pairs, wanted):
    """Prints the ratio of one to two workers by both clocks: median, worst and best, and the median times."""
    for clock in ("CPU", "wall"):
        ratios = sorted(one[clock] / two[clock] for one, two in pairs)
        one, two = (statistics.median(pair[index][clock] for pair in pairs) for index in (0, 1))
        figure = f"{statistics.median(ratios):.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f} ({one:.2f} / {two:.2f} s {clock})"
        row(words, figure, *wanted)


#: Checks the programs that it is given, and prints its CPU time.
_PLAIN = f"""
import sys, time, trunnion
machine = trunnion.Machine("bc-trunnion", **{SETUP!r})
for name in sys.argv[1:]:
    trunnion.check(name, machine=machine)
print(time.process_time())
"""


def _apart(names, processes):
    """Returns how long plain processes take that know nothing of each other: on the wall, and the busiest by its clock."""
    surroundings, start = {**os.environ, "RAYON_NUM_THREADS": "1"}, time.perf_counter()
    words = [[sys.executable, "-c", _PLAIN, *names[index::processes]] for index in range(processes)]
    running = [subprocess.Popen(one, stdout=subprocess.PIPE, env=surroundings) for one in words]
    busy = [float(process.communicate()[0]) for process in running]
    return {"wall": time.perf_counter() - start, "CPU": max(busy)}


def _audited(names, machine, workers):
    """Returns how long an audit takes: on the wall, and by the clocks of the busiest worker and of this process."""
    from trunnion import _workers

    busy, stop = [], _workers._Worker.stop

    def timed(worker):
        if worker._process.poll() is None:
            # After the name: the 12th and 13th fields are user and system time of all threads.
            fields = pathlib.Path(f"/proc/{worker._process.pid}/stat").read_text().rpartition(")")[2].split()
            busy.append((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
        stop(worker)

    _workers._Worker.stop = timed
    try:
        start, cpu = time.perf_counter(), time.process_time()
        rows = trunnion.fleet.audit(names, machine, workers=workers).rows
        wall, own = time.perf_counter() - start, time.process_time() - cpu
    finally:
        _workers._Worker.stop = stop
    assert len(busy) == workers and all(one["status"] == "done" for one in rows)
    return {"wall": wall, "CPU": own + max(busy)}


SECTIONS = {"inverse": inverse, "plan": plan, "drop": drop, "package": package, "fleet": fleet}


if __name__ == "__main__":
    if sys.argv[1:2] == ["--section"]:
        SECTIONS[sys.argv[2]](*sys.argv[3:])
    else:
        load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
        print(f"trunnion {trunnion.__version__}, {os.cpu_count()} cores, load before {load:.1f}", flush=True)
        # Each in a process of its own: memory that one has grown would spare the next its page faults, and halves the time
        # of copp-py after a million poses.
        for section in SECTIONS:
            example = sys.argv[1:2] or [""]
            words = [sys.executable, __file__, "--section", section, *(example if section == "inverse" else [])]
            subprocess.run(words, check=True)
