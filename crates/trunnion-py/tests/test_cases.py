"""Reference cases from outside the repository, through Python."""

import json

import numpy as np
import pytest

import trunnion

LIMIT = dict(vel=100.0, acc=1000.0, jerk=1e4)


@pytest.fixture(scope="module")
def cases(shared):
    return json.loads((shared / "cases" / "nc.json").read_text())["cases"]


def machine_of(case):
    """A machine file from joints that are listed from the base outwards."""
    joints = case["machine"]
    work, tool = joints["work"], joints["tool"]
    names = [joint["name"] for joint in reversed(work)], [joint["name"] for joint in tool]
    axes = {}
    for joint in [*work, *tool]:
        axis = {"dir": joint["axis"], **LIMIT, "limits": [-1e5, 1e5]}
        # ISO 841 counts the tool against the workpiece: joints under the workpiece move it the other way.
        sense = joint.get("sign", 1) * (-1 if joint in work else 1)
        axis["sense"] = sense
        if joint["kind"] == "R":
            axis |= {"kind": "rotary", "point": [float(x) for x in joint["point"]], "limits": [-1e4, 1e4]}
        else:
            axis["kind"] = "linear"
        axes[joint["name"]] = axis
    data = {
        "schema": "trunnion-machine/1",
        "name": case["machine_name"],
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "chain": ["w", *names[0], "b", *names[1], "t"],
        "tool_axis": joints["o0"],
        "gauge": [float(x) for x in joints["tip0"]],
        "axis": axes,
    }
    if "Z" not in axes:
        data["retract"] = {"axis": "W"}
    return trunnion.Machine(data, origin=joints["work_origin"])


def test_general_chains(cases):
    joints = {}
    for case in cases["kinematics_general"]:
        # Later cases name the machine of the first.
        if isinstance(case["machine"], str):
            case = {**case, "machine": joints[case["machine"]]}
        joints[case["machine_name"]] = case["machine"]
        if len(case["joint_values"]) != 5:
            continue
        machine = machine_of(case)
        values = case["joint_values"]
        q = np.array([values[name] for name in machine.axes])
        tip, axis = machine.forward(q)
        np.testing.assert_allclose(tip, case["tip"], atol=1e-8, err_msg=case["id"])
        np.testing.assert_allclose(axis, case["axis"], atol=1e-10, err_msg=case["id"])
        found = machine.inverse(tip, axis, all=True)
        found = found[np.isfinite(found).all(axis=1)]
        for solution in case["solutions"]:
            expected = np.array([solution[name] for name in machine.axes])
            gap = found - expected
            gap[:, 3:] = (gap[:, 3:] + np.pi) % (2 * np.pi) - np.pi
            assert np.abs(gap).max(axis=1).min() < 1e-7, case["id"]


def test_great_circles(cases):
    for case in cases["slerp"]:
        a, b = (np.array(case[name]) / np.linalg.norm(case[name]) for name in "ab")
        if case["t"] != 0.5:
            continue
        if isinstance(case["expect"], str):
            with pytest.raises(trunnion.InputError, match="plane of the turn"):
                trunnion.Path([[0, 0, 0], [1, 0, 0]], [a, b])
            continue
        path = trunnion.Path([[0, 0, 0], [1, 0, 0]], [a, b]).interpolate(0.5, 10.0)
        np.testing.assert_allclose(path.axis[1], case["expect"], atol=1e-13, err_msg=case["id"])


def test_positioning(shared, patch):
    cases = json.loads((shared / "cases" / "positioning.json").read_text())
    face = trunnion.Part.read(patch).faces[0]
    for case in cases["cases"]:
        if case.get("surface", 1) != 1:
            continue
        cutter = trunnion.Cutter.bull(case["R"], case["r"])
        found = trunnion.position(
            face, cutter, at=case["uv"], feed=case["feed_uv"], tolerance=case["e"], side="either",
            offset_range=case["alpha_range_deg"],
        )
        assert found.strip_width >= case["best_l"] - case["tol_l_mm"] - 0.01, case["id"]


def test_published_feed(shared):
    case = json.loads((shared / "cases" / "published-feed.json").read_text())["jcde2022"]
    assert case["published_s"]["the paper's optimum"] == 9.44
    interpolate = pytest.importorskip("scipy.interpolate")
    knots, degree = np.array(case["knots"], dtype=float), case["degree"]
    tip = interpolate.BSpline(knots, np.array(case["tip"], dtype=float), degree)
    upper = interpolate.BSpline(knots, np.array(case["upper"], dtype=float), degree)
    u = np.linspace(knots[degree], knots[-degree - 1], 2001)[:-1]
    # Axes by finite differences of the closed formulas would be a test of numpy: the path goes through waypoints.
    axis = upper(u) - tip(u)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    path = trunnion.Path(np.ascontiguousarray(tip(u)), np.ascontiguousarray(axis))
    assert path.smooth(0.001, 1e-4).tip_deviation <= 0.001
