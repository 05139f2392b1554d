"""Time per location: opencamlib's drop cutter on triangles, trunnion's widest strip on the surface."""

import argparse
import pathlib
import re
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PLACES = [-60.0, -30.0, 30.0, 60.0]
# Paper 004, table 1: rows are y, columns x.
HEIGHTS = [
    [0.0, -20.0, -20.0, 5.0],
    [-5.0, -15.0, -25.0, -5.0],
    [-5.0, -25.0, -20.0, -5.0],
    [5.0, -15.0, -15.0, 0.0],
]
DIAMETER, CORNER, LENGTH = 32.0, 6.0, 120.0
# Squares a side: two triangles each.
GRIDS = [50, 150]
LOCATIONS, ROUNDS = 200, 5
UNITS = {"ns": 1e-9, "µs": 1e-6, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def bernstein(t):
    s = 1.0 - t
    return [s**3, 3.0 * s * s * t, 3.0 * s * t * t, t**3]


def point(u, v):
    a, b = bernstein(u), bernstein(v)
    pairs = [(i, j, a[i] * b[j]) for i in range(4) for j in range(4)]
    x = sum(weight * PLACES[i] for i, _, weight in pairs)
    y = sum(weight * PLACES[j] for _, j, weight in pairs)
    return x, y, sum(weight * HEIGHTS[j][i] for i, j, weight in pairs)


def mesh(ocl, count):
    net = [[ocl.Point(*point(i / count, j / count)) for j in range(count + 1)] for i in range(count + 1)]
    surface = ocl.STLSurf()
    for i in range(count):
        for j in range(count):
            a, b, c, d = net[i][j], net[i + 1][j], net[i + 1][j + 1], net[i][j + 1]
            surface.addTriangle(ocl.Triangle(a, b, c))
            surface.addTriangle(ocl.Triangle(a, c, d))
    return surface


def drop(ocl, surface):
    """Seconds per location, the median of several rounds over locations inside the patch."""
    cutter = ocl.BullCutter(DIAMETER, CORNER, LENGTH)
    times = []
    for _ in range(ROUNDS):
        batch = ocl.BatchDropCutter()
        batch.setSTL(surface)
        batch.setCutter(cutter)
        batch.setThreads(1)
        for k in range(LOCATIONS):
            x, y, _ = point(0.2 + 0.6 * (k % 20) / 19.0, 0.2 + 0.6 * (k // 20) / 9.0)
            batch.appendPoint(ocl.CLPoint(x, y, -100.0))
        start = time.perf_counter()
        batch.run()
        times.append((time.perf_counter() - start) / LOCATIONS)
    return statistics.median(times)


def widest(text):
    """Medians of the benches `cold` and `warm`: seconds, per case."""
    times, name = {}, None
    for line in text.splitlines():
        plain = re.sub(r"[│├╰─]", " ", line)
        words = plain.split()
        if words and words[0] in ("cold", "warm", "look"):
            name = words[0]
        row = re.match(r"\s+([01])\s", plain)
        values = re.findall(r"([\d.]+) (ns|µs|us|ms|s)\b", plain)
        # fastest, slowest, median, mean
        if row and name and len(values) >= 3:
            number, unit = values[2]
            times[name, int(row.group(1))] = float(number) * UNITS[unit]
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trunnion-output", type=pathlib.Path, help="output of the bench, from a file")
    arguments = parser.parse_args()
    try:
        import opencamlib as ocl
    except ImportError:
        sys.exit("opencamlib is missing; see the README beside this script")

    rows = []
    for count in GRIDS:
        seconds = drop(ocl, mesh(ocl, count))
        rows.append((f"opencamlib drop cutter, {2 * count * count} triangles", seconds))
    reference = rows[0][1]
    if arguments.trunnion_output:
        text = arguments.trunnion_output.read_text(encoding="utf-8")
    else:
        command = ["cargo", "bench", "-p", "trunnion", "--bench", "positioning"]
        text = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    times = widest(text)
    if not times:
        sys.exit("the bench of trunnion printed no times")
    feeds = ["feed along v (17.2 mm strip)", "feed against u (4.8 mm strip)"]
    for (name, case), seconds in sorted(times.items()):
        rows.append((f"trunnion widest strip, {name}, {feeds[case]}", seconds))
    print(f"{'one location':<62}{'us':>10}{'ratio':>9}")
    for name, seconds in rows:
        print(f"{name:<62}{seconds * 1e6:>10.1f}{seconds / reference:>9.3f}")
    print(f"ratio: to the drop cutter on {2 * GRIDS[0] ** 2} triangles; one thread each")


if __name__ == "__main__":
    main()
