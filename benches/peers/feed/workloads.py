"""Five-axis paths to plan for: NAME.bin (rows, axes, then s and the axes with three derivatives, f64) and
NAME.npz (the same path as a spline of degree 5).

  walk    a random walk of X, Y, Z and both rotaries, twenty rows a span
  raster  a waved surface, tool tilted 30 degrees, on a table-table machine; rounded turns at the ends
  whip    straight lines whose tool axis passes the pole of C at 1.5 degrees: C whips half round

Families that no planner was developed on:

  dome    a spiral up a dome, the tool leaning to and fro across it
  corners straight lines in all five axes, 5 to 80 mm long, with corners rounded over 1 mm
  scales  sines of wavelengths from 0.5 to 200 mm over one another in all axes
  line    one straight move of all axes, for planners from state to state
"""
import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

FAMILIES = ("walk", "raster", "whip", "dome", "corners", "scales", "line")


def walk(rows, random):
    count = rows // 20 + 6
    heading = np.cumsum(random.normal(0, 0.35, count))
    climb = 0.5 * np.sin(np.cumsum(random.normal(0, 0.2, count)))
    steps = [np.cos(climb) * np.cos(heading), np.cos(climb) * np.sin(heading), np.sin(climb)]
    columns = [2 * np.cumsum(step) for step in steps]
    for size in (0.006, 0.012):
        drift = np.zeros(count)
        speed = 0.0
        for row in range(1, count):
            speed = 0.8 * speed + random.normal(0, size)
            drift[row] = 0.99 * drift[row - 1] + speed
        columns.append(drift)
    knots = np.arange(count + 6, dtype=float)
    return BSpline(knots, np.column_stack(columns), 5), (knots[5], knots[count])


def machine(tip, axis):
    """X, Y, Z, A, C of a table-table machine whose axes meet in the origin."""
    tilt = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    turn = np.unwrap(np.arctan2(axis[:, 0], axis[:, 1]))
    x = np.cos(turn) * tip[:, 0] - np.sin(turn) * tip[:, 1]
    y = np.sin(turn) * tip[:, 0] + np.cos(turn) * tip[:, 1]
    y, z = np.cos(tilt) * y - np.sin(tilt) * tip[:, 2], np.sin(tilt) * y + np.cos(tilt) * tip[:, 2]
    return through(np.column_stack([x, y, z, tilt, turn]))


def through(axes):
    steps = np.diff(axes, axis=0) * [1, 1, 1, 30, 30]
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(steps, axis=1))])
    return make_interp_spline(s, axes, k=5), (s[0], s[-1])


def turn_round(x_end, side, y_from, y_to, count):
    angle = np.linspace(0, np.pi, count)[1:-1]
    middle, half = 0.5 * (y_from + y_to), 0.5 * (y_to - y_from)
    return np.column_stack([side * (x_end + max(half, 1) * np.sin(angle)), middle - half * np.cos(angle)])


def raster(rows, _):
    passes = max(1, rows // 640)
    lines = np.linspace(-30, 30, max(passes, 2))[:passes]
    parts = []
    for index, y in enumerate(lines):
        side = 1 if index % 2 == 0 else -1
        x = side * np.linspace(-30, 30, 75)
        parts.append(np.column_stack([x, np.full_like(x, y)]))
        if index + 1 < passes:
            parts.append(turn_round(30, side, y, lines[index + 1], 9))
    x, y = np.vstack(parts).T
    z = 4 * np.sin(x / 9) * np.cos(y / 11)
    slopes = [-4 / 9 * np.cos(x / 9) * np.cos(y / 11), 4 / 11 * np.sin(x / 9) * np.sin(y / 11)]
    normal = np.column_stack([*slopes, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    lean = np.deg2rad(30)
    axis = normal.copy()
    axis[:, 0] = np.cos(lean) * normal[:, 0] + np.sin(lean) * normal[:, 2]
    axis[:, 2] = np.cos(lean) * normal[:, 2] - np.sin(lean) * normal[:, 0]
    return machine(np.column_stack([x, y, z]), axis)


def whip(rows, _):
    lines = max(1, rows // 2000)
    tips, axes = [], []
    for index in range(lines):
        side = 1 if index % 2 == 0 else -1
        t = side * np.linspace(-1, 1, 160)
        off = np.deg2rad(1.5) * (1 + 0.5 * np.sin(index))
        tips.append(np.column_stack([40 * t, np.full_like(t, 2.0 * index), 0 * t]))
        axes.append(np.column_stack([np.sin(np.deg2rad(15) * t), np.full_like(t, np.sin(off))]))
        if index + 1 < lines:
            angle = np.linspace(0, np.pi, 14)[1:-1]
            share = 0.5 * (1 - np.cos(angle))
            after = np.deg2rad(1.5) * (1 + 0.5 * np.sin(index + 1))
            y = 2 * index + 2 * share
            tips.append(np.column_stack([side * (40 + np.sin(angle)), y, 0 * angle]))
            lean = np.full_like(angle, side * np.sin(np.deg2rad(15)))
            axes.append(np.column_stack([lean, np.sin(off) * (1 - share) + np.sin(after) * share]))
    two = np.vstack(axes)
    three = np.column_stack([two, np.sqrt(1 - (two**2).sum(axis=1))])
    return machine(np.vstack(tips), three)


def dome(rows, random):
    turns = max(2.0, rows / 2500)
    t = np.linspace(0, 1, max(400, rows // 12))
    radius, around = 40 * (1 - 0.9 * t), 2 * np.pi * turns * t
    out = np.column_stack([np.cos(around), np.sin(around)])
    tip = np.column_stack([radius[:, None] * out, -(radius**2) / 80])
    lean = radius / 40 * 0.6 + 0.15 * np.sin(7.3 * around + random.uniform(0, 6))
    across = 0.1 * np.sin(3.1 * around)
    side = np.column_stack([-out[:, 1], out[:, 0]])
    flat = np.sin(lean)[:, None] * out + across[:, None] * side
    axis = np.column_stack([flat, np.cos(lean)])
    return machine(tip, axis / np.linalg.norm(axis, axis=1)[:, None])


def corners(rows, random):
    places = [np.zeros(5)]
    for _ in range(max(2, rows // 400)):
        way = random.normal(0, 1, 5) * [1, 1, 0.3, 0.01, 0.02]
        length = np.exp(random.uniform(np.log(5), np.log(80)))
        places.append(places[-1] + way * length / np.linalg.norm(way[:3]))
    points = [places[0]]
    for before, here, after in zip(places, places[1:], places[2:]):
        back, on = ((to - here) / np.linalg.norm((to - here)[:3]) for to in (before, after))
        # Quadratic curves over 1 mm on either side, and the straight lines between them.
        points.extend(straight(points[-1], here + back))
        points.extend(here + back * (1 - t) ** 2 + on * t**2 for t in np.linspace(0, 1, 9))
    points.extend(straight(points[-1], places[-1]))
    return through(np.array(points + [places[-1]]))


def straight(start, end):
    count = max(3, int(np.linalg.norm((end - start)[:3]) / 0.5))
    return [start + (end - start) * k / count for k in range(1, count)]


def scales(rows, random):
    length = 0.05 * rows
    s = np.linspace(0, length, 3 * rows)
    axes = [0.7 * s] + [0 * s for _ in range(4)]
    for wave in np.exp(np.linspace(np.log(0.5), np.log(200), 9)):
        for axis in range(5):
            size = random.uniform(0, 0.03 if axis < 3 else 0.001) * wave
            axes[axis] = axes[axis] + size * np.sin(2 * np.pi * s / wave + random.uniform(0, 6))
    return through(np.column_stack(axes))


# From and to, for planners that go from state to state.
LINE = np.array([[0.0, 0, 0, 0, 0], [80.0, 30, -10, 0.3, 0.7]])


def line(_, __):
    return through(LINE[0] + np.linspace(0, 1, 40)[:, None] * (LINE[1] - LINE[0]))


def write(folder, family, rows):
    spline, (first, last) = globals()[family](rows, np.random.default_rng(1))
    s = np.linspace(first, last, rows)
    jets = [spline(s)] + [spline.derivative(order)(s) for order in (1, 2, 3)]
    name = folder / f"{family}_{rows}"
    with open(f"{name}.bin", "wb") as file:
        np.array([rows, 5], dtype="<f8").tofile(file)
        np.column_stack([s, *jets]).astype("<f8").tofile(file)
    np.savez(f"{name}.npz", t=spline.t, c=spline.c, k=spline.k, s=s)
    return name
