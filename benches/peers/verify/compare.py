#!/usr/bin/env python3
"""Removed volume and speed of stock cutting beside manifold3d; see README.md."""

import math
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import manifold3d
import numpy as np

MAJOR, MINOR, LENGTH = 10.0, 6.0, 60.0
BLOCK = [100.0, 60.0, 20.0]
ROOT = pathlib.Path(__file__).resolve().parents[3]
FACETS = [0.077, 0.019, 0.005]


def moves(seed, count=40):
    """Tip and axis at the end of each move: 1 mm apart, turning by about 0.2 degrees a move."""
    dice = random.Random(seed)
    heading, lean, swing = dice.uniform(-0.3, 0.3), dice.uniform(0.05, 0.25), dice.uniform(-1, 1)
    poses = []
    x, y, z = -20.0, dice.uniform(-5, 5), -3.0
    for step in range(count + 1):
        tilt = lean + 0.0035 * step
        turn = 0.2 * swing + 0.002 * step
        axis = np.array([math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)])
        poses.append((np.array([x, y, z]), axis))
        x += math.cos(heading + 0.01 * step)
        y += math.sin(heading + 0.01 * step)
        z += 0.05 * math.sin(0.3 * step)
    return poses


def outline(facet):
    """Points (rho, z) of the tool's outline, chords at most `facet` off."""
    steps = max(2, math.ceil(0.5 * math.pi / (2 * math.acos(1 - facet / MINOR))))
    arc = [(MAJOR + MINOR * math.sin(a), MINOR - MINOR * math.cos(a)) for a in np.linspace(0, math.pi / 2, steps + 1)]
    return [(0.0, 0.0)] + arc + [(MAJOR + MINOR, LENGTH)]


def tool(pose, facet):
    tip, axis = pose
    round_ = max(12, math.ceil(math.pi / math.acos(1 - facet / (MAJOR + MINOR))))
    side = np.cross(axis, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    points = []
    for rho, z in outline(facet):
        for k in range(round_ if rho > 0 else 1):
            a = 2 * math.pi * k / round_
            points.append(tip + axis * z + rho * (side * math.cos(a) + other * math.sin(a)))
    return points


def booleans(poses, facet):
    block = manifold3d.Manifold.cube(BLOCK, True).translate([0.0, 0.0, -0.5 * BLOCK[2]])
    whole = block.volume()
    start = time.perf_counter()
    for before, after in zip(poses, poses[1:]):
        hull = manifold3d.Manifold.hull_points(np.array(tool(before, facet) + tool(after, facet)))
        block = block - hull
        block.num_tri()  # booleans are lazy
    return whole - block.volume(), (len(poses) - 1) / (time.perf_counter() - start)


def rays(poses, cell, folder):
    lines = ["UNITS/MM", "MULTAX/ON", "FEDRAT/1000,MMPM"]
    lines += ["GOTO/" + ",".join(f"{value:.9f}" for value in [*tip, *axis]) for tip, axis in poses]
    (folder / "moves.cls").write_text("\n".join(lines) + "\nFINI\n")
    command = [
        ROOT / "target/release/examples/cut_stock", folder / "moves.cls", f"{MAJOR},{MINOR},{LENGTH}",
        "-50,-30,-20,50,30,0", str(cell),
    ]
    best = None
    for _ in range(3):
        answer = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        volume, seconds = float(answer[0]), float(answer[1])
        best = seconds if best is None else min(best, seconds)
    return volume, (len(poses) - 1) / best


def main():
    for seed in map(int, sys.argv[1:] or ["1", "2", "3"]):
        poses = moves(seed)
        meshes = [(facet, *booleans(poses, facet)) for facet in FACETS]
        (coarse, a, _), (fine, b, _) = meshes[1], meshes[2]
        limit = b + (b - a) * fine / (coarse - fine)
        for facet, volume, speed in meshes:
            print(f"seed {seed}  manifold3d {1e3 * facet:3.0f} um: {volume:10.3f} mm3, {speed:7.1f} moves/s")
        print(f"seed {seed}  manifold3d extrapolated: {limit:10.3f} mm3")
        with tempfile.TemporaryDirectory() as folder:
            for cell in [0.5, 0.2, 0.1]:
                volume, speed = rays(poses, cell, pathlib.Path(folder))
                share, ratio = 100 * (volume / limit - 1), speed / meshes[0][2]
                print(
                    f"seed {seed}  trunnion {cell} mm:      {volume:10.3f} mm3 ({share:+.4f} %), {speed:7.1f} moves/s,"
                    f" {ratio:.1f} x manifold3d at {1e3 * FACETS[0]:.0f} um",
                    flush=True,
                )


if __name__ == "__main__":
    main()
