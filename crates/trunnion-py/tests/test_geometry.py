"""Parts, cutters, locations, passes, paths, lowered cutters."""

import json
import os
import pickle
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trunnion


def saddle():
    x = np.linspace(-60, 60, 6)
    xx, yy = np.meshgrid(x, x, indexing="ij")
    return trunnion.Part.from_net(np.stack([xx, yy, 0.002 * (xx**2 - yy**2)], axis=-1))


def test_faces_are_evaluated(patch):
    face = trunnion.Part.read(patch).faces[0]
    np.testing.assert_allclose(face.point([0.4, 0.5]), [-13.44, 0, -15.365], atol=1e-3)
    # fixtures/bezier-patch/README.md; positive is hollow for the cutter.
    np.testing.assert_allclose(face.curvature([0.4, 0.5]), [0.0015098, 0.0057387], atol=1e-7)
    uv = np.random.default_rng(3).uniform(0.1, 0.9, (50, 2))
    table = face.derivatives(uv)
    assert table.shape == (50, 6, 3)
    np.testing.assert_array_equal(table[:, 0], face.point(uv))
    normal = np.cross(table[:, 1], table[:, 2])
    np.testing.assert_allclose(face.normal(uv), normal / np.linalg.norm(normal, axis=1)[:, None], atol=1e-12)
    h = 1e-5
    step = (face.point(uv + [h, 0]) - face.point(uv - [h, 0])) / (2 * h)
    np.testing.assert_allclose(step, table[:, 1], rtol=1e-6, atol=1e-4)
    np.testing.assert_allclose(face.flipped().normal(uv), -face.normal(uv))
    assert face.bounds.tolist() == [[0, 1], [0, 1]] and face.kind and face.area > 10000


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_the_closest_point_of_an_offset_is_where_it_started(seed):
    face = saddle().faces[0]
    rng = np.random.default_rng(seed)
    uv, height = rng.uniform(0.2, 0.8, (8, 2)), rng.uniform(-20, 20, 8)
    points = face.point(uv) + height[:, None] * face.normal(uv)
    found, foot, distance = face.closest(points)
    np.testing.assert_allclose(found, uv, atol=1e-6)
    np.testing.assert_allclose(distance, height, atol=1e-6)
    np.testing.assert_allclose(foot, face.point(uv), atol=1e-5)


def test_bytes_and_files_are_the_same(patch):
    a, b = trunnion.Part.read(patch), trunnion.Part.read(patch.read_bytes())
    np.testing.assert_array_equal(a.faces[0].point([0.3, 0.3]), b.faces[0].point([0.3, 0.3]))
    net = json.loads(patch.read_text())
    c = trunnion.Part.from_net(net["points"], net["degree"], tuple(net["knots"]))
    np.testing.assert_array_equal(a.faces[0].point([0.3, 0.3]), c.faces[0].point([0.3, 0.3]))
    with pytest.raises(trunnion.InputError):
        trunnion.Part.read(b"{")


def test_cutters(tmp_path):
    cutter = trunnion.Cutter.bull(10, 6, length=120, shank=[[30, 12], [60, 20]])
    assert (cutter.radius, cutter.kind, cutter.length) == (16, "bull", 120)
    assert pickle.loads(pickle.dumps(cutter)) == cutter
    for wrong in (lambda: trunnion.Cutter.ball(-1), lambda: trunnion.Cutter.bull(10, 6, length=float("nan"))):
        with pytest.raises(trunnion.InputError):
            wrong()


#: A cutter of each kind.
CUTTERS = [
    trunnion.Cutter.ball(12),
    trunnion.Cutter.flat(10),
    trunnion.Cutter.bull(4, 2),
    trunnion.Cutter.taper(1, 20, 8, deg=True),
    trunnion.Cutter.barrel(2, 60, 10),
    trunnion.Cutter.conical_barrel(1.5, 80, 25, 10, deg=True),
    trunnion.Cutter.lens(20, 1, 10),
]


@pytest.mark.parametrize("cutter", CUTTERS, ids=lambda one: one.kind)
def test_every_kind_of_cutter_goes_through_pickles_jobs_and_options(cutter, job_folder):
    assert pickle.loads(pickle.dumps(cutter)) == cutter and cutter.kind in repr(cutter)
    outline = cutter.outline(steps=200)
    assert outline[0].tolist() == [0, 0] and outline[-1].tolist() == [cutter.radius, cutter.length]
    # Convex, and going out and up.
    steps = np.diff(outline, axis=0)
    assert (steps >= -1e-12).all() and (np.diff(np.arctan2(*steps.T[::-1])) >= -1e-9).all()
    job = trunnion.Job.read(job_folder / "job.toml").replace({"tool": cutter})
    assert job.data["tool"]["kind"] == cutter.kind and job.data["tool"]["number"] == 1
    job.check()
    assert trunnion.Job({"tool": cutter}).data["tool"]["length"] == cutter.length
    moves = b"G21 G90\nT1 M6\nS1000 M3\nG0 X0 Y0 Z50 B0 C0\nG1 Z40 F500\nM2\n"
    where = trunnion.Machine("bc-trunnion", origin=(-381, -254, -505))
    assert trunnion.check(moves, machine=where, cutter=cutter).summary["duration"] > 0


def test_cutters_of_contradicting_dimensions_are_refused():
    with pytest.raises(trunnion.ArgumentError, match="degrees with deg=True") as found:
        trunnion.Cutter.taper(1, 20, 8)
    assert found.value.argument == "taper_angle" and found.value.value == 20
    for wrong in (
        lambda: trunnion.Cutter.taper(5, 0.1, 8),
        lambda: trunnion.Cutter.barrel(2, 3, 80),
        lambda: trunnion.Cutter.lens(1, 20, 10),
        lambda: trunnion.Cutter.conical_barrel(2, float("nan"), 0.2, 10),
    ):
        with pytest.raises(trunnion.InputError):
            wrong()
    assert trunnion.Cutter.barrel(2, 60, 10).barrel_radius == 60 and trunnion.Cutter.ball(6).barrel_radius is None
    assert trunnion.Cutter.lens(20, 1, 10).corner_radius == 1
    assert trunnion.Cutter.taper(1, 20, 8, deg=True).taper_angle() == pytest.approx(np.radians(20))


def test_the_widest_strip_of_the_paper(patch):
    face, cutter = trunnion.Part.read(patch).faces[0], trunnion.Cutter.bull(10, 6)
    found = trunnion.position(face, cutter, at=(0.4, 0.5), feed=(0, 1), tolerance=0.01, offset_range=(-15, 15))
    assert found.strip_width == pytest.approx(17.1725, abs=0.01)
    assert np.linalg.norm(found.axis) == pytest.approx(1) and found.rear_min >= -1e-9
    assert found.error_curve.shape[1] == 3 and "<svg" in found._repr_html_()
    ball = trunnion.position(face, cutter, at=(0.4, 0.5), feed=(0, 1), method="ball")
    assert ball.strip_width < found.strip_width
    with pytest.raises(trunnion.InputError, match="not one of"):
        trunnion.position(face, cutter, at=(0.4, 0.5), feed=(0, 1), method="best")


def test_passes_cover_a_plane():
    plane = trunnion.Part.from_net([[[0, 0, 0], [0, 20, 0]], [[20, 0, 0], [20, 20, 0]]], degree=(1, 1))
    stages = []
    found = trunnion.cover(
        plane, trunnion.Cutter.ball(10, length=60), excess=0.1, gouge=0.01, along="u", method="inclined",
        progress=lambda *state: stages.append(state),
    )
    assert 10 <= len(found.passes) <= 13 and not found.unfinished
    assert found.passes[0]["tip"].shape[1] == 3 and "<svg" in found._repr_html_()


def wave(count):
    x = np.linspace(0, 0.05 * count, count)
    axis = np.stack([0.2 * np.sin(x / 7), 0.1 * np.cos(x / 5), np.ones(count)], axis=1)
    return trunnion.Path(np.stack([x, 5 * np.sin(x / 9), np.cos(x / 3)], axis=1), axis / np.linalg.norm(axis, axis=1)[:, None])


#: Long calls on paths, each with an argument that makes it take more than a second.
LONG_CALLS = {
    "interpolate": (wave(100_000).interpolate, (0.0005, 1.0)),
    "smooth": (wave(200_000).smooth, (0.005, 1e-4)),
    "linearise": (lambda *args, **words: wave(4000).smooth(0.005, 1e-4).linearise(*args, **words), (2e-11, 1.0)),
}


@pytest.mark.parametrize("name", LONG_CALLS)
def test_long_calls_on_paths_report_and_are_stopped(name):
    call, arguments = LONG_CALLS[name]

    class Enough(Exception):
        pass

    seen, threads = [], threading.active_count()

    def stop(stage, done, total):
        seen.append((stage, done, total))
        raise Enough

    with pytest.raises(Enough):
        call(*arguments, progress=stop)
    # Stopped in the middle: what has reported is gone, and its report was not the last one.
    (stage, done, total), = seen
    assert stage == "laying the path" and 0 <= done < total and threading.active_count() == threads
    tqdm = pytest.importorskip("tqdm").tqdm
    with tqdm(total=1, disable=False) as bar:
        wave(200).smooth(progress=bar).linearise(progress=bar).interpolate(0.1, 0.1, progress=bar)
        assert bar.n == bar.total > 1


@pytest.mark.parametrize("name", LONG_CALLS)
def test_long_calls_on_paths_leave_the_interpreter_to_others(name):
    call, arguments = LONG_CALLS[name]
    ticks, ended = [], threading.Event()

    def tick():
        while not ended.wait(0.01):
            ticks.append(time.monotonic())

    other = threading.Thread(target=tick)
    other.start()
    start = time.monotonic()
    try:
        call(*arguments)
    finally:
        ended.set()
        other.join()
    took = time.monotonic() - start
    gaps = np.diff([start, *ticks, start + took])
    # Arrays are made with the lock; the work itself takes longer.
    assert took > 0.1 and gaps.max() < 0.6 * took, (took, gaps.max())


@pytest.mark.parametrize("name", LONG_CALLS)
def test_ctrl_c_ends_long_calls_on_paths(name):
    # A signal in the middle of the call: where it were not heard, the call would return its result first.
    script = (
        "import os, signal, sys, threading, time\n"
        f"sys.path.insert(0, {os.path.dirname(__file__)!r})\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import test_geometry\n"
        f"call, arguments = test_geometry.LONG_CALLS[{name!r}]\n"
        "running = threading.Event()\n"
        "def kill():\n"
        "    running.wait()\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "threading.Thread(target=kill, daemon=True).start()\n"
        "call(*arguments, progress=lambda *report: running.set())\n"
        "print('returned', flush=True)\n"
        "time.sleep(5)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.stderr.rstrip().endswith("KeyboardInterrupt") and not done.stdout, done.stdout + done.stderr


def test_more_moves_than_fit_in_memory_are_refused():
    with pytest.raises(trunnion.ArgumentError, match="more moves than fit") as found:
        wave(4000).smooth(0.005, 1e-4).linearise(1e-14, 1.0)
    assert found.value.argument == "tip_tolerance" and "allow more" in found.value.remedy


def test_a_path_is_interpolated_smoothed_and_divided():
    t = np.linspace(0, 2, 101)
    tip = np.stack([20 * np.cos(t), 20 * np.sin(t), t], axis=1)
    axis = np.stack([0.2 * np.sin(t), 0 * t, np.ones_like(t)], axis=1)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    path = trunnion.Path(tip, axis)
    fine = path.interpolate(0.1, 1.0, deg=True)
    assert np.linalg.norm(np.diff(fine.tip, axis=0), axis=1).max() <= 0.1 + 1e-12
    smooth = path.smooth(0.005, 1e-4)
    assert smooth.tip_deviation <= 0.005 and smooth.axis_deviation <= 1e-4 and len(smooth.starts) == 1
    dense, coarse = smooth.linearise(1e-6, 1e-6), smooth.linearise(0.005, 1e-3)
    assert len(coarse) < len(dense)
    gap = np.abs(dense.tip[:, None] - coarse.tip[None]).sum(axis=2).min(axis=1)
    assert np.isfinite(gap).all()
    # No point of the curve is farther from the straight moves than asked for.
    ends = coarse.tip
    a, b = ends[:-1], ends[1:]
    along = b - a
    share = np.clip(((dense.tip[:, None] - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    distance = np.linalg.norm(dense.tip[:, None] - (a + share[..., None] * along), axis=-1).min(axis=1)
    assert distance.max() <= 0.005
    again = trunnion.Path.from_cl(path.to_cl())
    np.testing.assert_allclose(again.tip, path.tip, atol=1e-8)
    assert "<svg" in smooth._repr_html_()


def lowered(vertices, triangles, outline, place, samples=60):
    """Height of the tip on a dense grid of points of all triangles."""
    s = np.arange(samples + 1) / samples
    s, t = np.meshgrid(s, s)
    inside = s + t <= 1 + 1e-12
    weights = np.stack([1 - s[inside] - t[inside], s[inside], t[inside]], axis=1)
    points = np.einsum("ki,tij->tkj", weights, np.asarray(vertices)[triangles]).reshape(-1, 3)
    distance = np.hypot(points[:, 0] - place[0], points[:, 1] - place[1])
    # The underside, up to where the outline is as wide as the cutter.
    rim = np.argmax(outline[:, 0] >= outline[:, 0].max() - 1e-12)
    points, distance = points[distance <= outline[rim, 0]], distance[distance <= outline[rim, 0]]
    return (points[:, 2] - np.interp(distance, *outline[: rim + 1].T)).max() if len(points) else np.nan


@pytest.mark.parametrize("cutter", CUTTERS, ids=lambda one: one.kind)
def test_lowered_cutters_touch_what_samples_touch(cutter):
    rng = np.random.default_rng(11)
    x, y = np.meshgrid(np.linspace(0, 40, 9), np.linspace(0, 40, 9), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), rng.uniform(-3, 3, x.size)], axis=1)
    quad = lambda i, j: 9 * i + j
    triangles = np.array(
        [[quad(i, j), quad(i + a, j + 1 - a), quad(i + 1, j + 1)] for i in range(8) for j in range(8) for a in (0, 1)]
    )
    places = rng.uniform(-2, 42, (12, 2))
    found = trunnion.drop_cutter((vertices, triangles), cutter, places)
    sampled = np.array([lowered(vertices, triangles, cutter.outline(2000), place) for place in places])
    np.testing.assert_array_equal(np.isnan(found.z), np.isnan(sampled))
    # Lines between points of the outline lie a hair inside it.
    assert (found.z >= sampled - 1e-6)[~np.isnan(sampled)].all()
    assert np.nanmax(found.z - sampled) < 0.15
    assert found.deviation == 0 and np.asarray(found) is not None and found.tip.shape == (12, 3)


@pytest.mark.parametrize(
    "cutter", [trunnion.Cutter.bull(10, 6), *CUTTERS[3:]], ids=lambda one: one.kind
)
def test_the_height_on_a_face_is_bounded(cutter):
    part = saddle()
    places = np.random.default_rng(5).uniform(-40, 40, (50, 2))
    found = trunnion.drop_cutter(part, cutter, places, chord=0.01, bounds=True)
    assert found.deviation <= 0.01
    finer = trunnion.drop_cutter(part, cutter, places, chord=0.0007)
    low, high = found.bounds.T
    assert (low <= finer.z + 2e-4).all() and (finer.z - 2e-4 <= high).all()
    assert (high - low).max() < 0.06


def test_meshes_come_from_stl(tmp_path):
    text = "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 9 0 0\n vertex 0 9 0\n endloop\n endfacet\nendsolid a\n"
    file = tmp_path / "a.stl"
    file.write_text(text)
    assert trunnion.drop_cutter(file, trunnion.Cutter.ball(2), [[2, 2]]).z.tolist() == [0]
    part = trunnion.Part.read(file)
    assert len(part) == 0 and repr(part) == "Part(1 triangles, no faces)" and "1 triangles" in part._repr_html_()
    assert trunnion.drop_cutter(part, trunnion.Cutter.ball(2), [[2, 2]]).z.tolist() == [0]
    assert part.mesh()[1].shape == (1, 3) and part.mesh()[0].max() == 9
    with pytest.raises(trunnion.ArgumentError, match="has no faces"):
        trunnion.cover(part, trunnion.Cutter.ball(2))
    with pytest.raises(trunnion.ArgumentError) as found:
        trunnion.drop_cutter(([[0, 0, 0]], [[0, 1, -2]]), trunnion.Cutter.ball(2), [[2, 2]])
    assert found.value.argument == "triangles" and found.value.index == (0, 2)
    with pytest.raises(trunnion.InputError, match="corner 1"):
        trunnion.drop_cutter(([[0, 0, 0]], [[0, 1, 2]]), trunnion.Cutter.ball(2), [[2, 2]])


def test_lowering_reports_and_stops():
    square = ([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    places = np.random.default_rng(1).uniform(0, 9, (20000, 2))
    seen = []
    trunnion.drop_cutter(square, trunnion.Cutter.ball(2), places, progress=lambda *report: seen.append(report))
    assert seen[0][0] == "lowering the cutter" and seen[-1][1:] == (20000, 20000) and len(seen) == 3

    def stop(stage, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        trunnion.drop_cutter(square, trunnion.Cutter.ball(2), places, progress=stop)


def test_passes_become_a_table(plane):
    found = trunnion.cover(plane, trunnion.Cutter.ball(10, length=60), excess=0.1, gouge=0.01, along="u", method="inclined")
    frame = found.to_pandas()
    assert len(frame) == sum(len(one["tip"]) for one in found.passes)
    assert frame["pass"].nunique() == len(found.passes) and (frame["face"] == 1).all()
    np.testing.assert_array_equal(frame[["tip_x", "tip_y", "tip_z"]], np.concatenate([one["tip"] for one in found.passes]))


@given(st.integers(0, 10**6), st.integers(1, 30))
@settings(max_examples=40, deadline=None)
def test_locations_go_through_cl_text(seed, count):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    path = trunnion.Path(rng.uniform(-500, 500, (count, 3)), axis)
    again = trunnion.Path.from_cl(path.to_cl(feed=700))
    np.testing.assert_allclose(again.tip, path.tip, atol=1e-9)
    np.testing.assert_allclose(again.axis, path.axis, atol=2e-9)


_KEYS = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), min_size=1, max_size=8)
_PLAIN = st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | st.text(max_size=12)


@given(st.dictionaries(_KEYS, st.recursive(_PLAIN, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_KEYS, inner, max_size=3))))
@settings(max_examples=60, deadline=None)
def test_data_go_through_toml(data):
    native = trunnion._trunnion
    assert native.toml_data(native.toml_text(data)) == data


@pytest.mark.parametrize("method", ["mpm", "hermite", "three-axis"])
def test_a_refused_location_has_its_remedy_apart(method):
    """On a saddle, along the feed that is hollow across: no second contact, and no room behind the cutter."""
    net = [[[x, y, 0.01 * x * x - 0.005 * y * y] for y in (-30, -10, 10, 30)] for x in (-30, -10, 10, 30)]
    face = trunnion.Part.from_net(net).faces[0]
    with pytest.raises(trunnion.InputError) as found:
        trunnion.position(face, trunnion.Cutter.bull(5, 3), at=(0.5, 0.5), feed=(1, 0), method=method)
    error = found.value
    assert "end-point method" in error.remedy and "end-point" not in error.message
    assert error.message.startswith("at (u, v) = (0.500000, 0.500000)")
