"""Reference cases from outside the repository, through Python."""

import json
import re

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


def layout(case, first, second):
    """A machine of paper 002: L, R and T are the offsets of its transformations."""
    left, middle, right = (np.array(case[name], dtype=float) for name in "LRT")
    kind = case["layout"] // 10
    # Table-table: the second rotary is next to the workpiece, and R counts from the other side.
    shift = -middle if kind == 2 else middle
    points = {first: left + shift if kind == 2 else left, second: left if kind == 2 else left + middle}
    work, tool = {1: ([], [first, second]), 2: ([second, first], []), 3: ([first], [second])}[kind]
    axes = {}
    for index, name in enumerate("XYZ"):
        axes[name] = {"kind": "linear", "dir": np.eye(3)[index].tolist(), **LIMIT, "limits": [-1e5, 1e5]}
    for name in (first, second):
        axes[name] = {
            "kind": "rotary", "dir": np.eye(3)["ABC".index(name)].tolist(), **LIMIT, "limits": [-1e4, 1e4],
            "point": points[name].tolist(), "sense": -case["table_sign"] if name in work else 1,
        }
    return trunnion.Machine({
        "schema": "trunnion-machine/1",
        "name": f"layout-{case['layout']}",
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "chain": ["w", *work, "b", "X", "Y", "Z", *tool, "t"],
        "tool_axis": [0, 0, 1],
        "gauge": (left + shift + right).tolist(),
        "axis": axes,
    })


ROTARIES = {
    11: "AB", 12: "BA", 13: "CA", 14: "CB", 21: "AB", 22: "BA", 23: "AC", 24: "BC", 31: "AB", 32: "BA", 33: "CA", 34: "CB",
}


def in_order(machine, xyz, rotaries):
    values = dict(zip("XYZ", xyz)) | rotaries
    return np.array([values[name] for name in machine.axes])


def apart(found, expected):
    """Distance of axis positions, whole turns ignored."""
    gap = np.asarray(found) - expected
    gap[..., 3:] = (gap[..., 3:] + np.pi) % (2 * np.pi) - np.pi
    return np.abs(gap).max(axis=-1)


def test_layouts(cases):
    for case in cases["kinematics_layouts"]:
        first, second = case["first_axis"], case["second_axis"]
        machine = layout(case, first, second)
        tip, axis = np.array(case["tip"]), np.array(case["axis"])
        expected = [
            in_order(machine, one["xyz"], {first: one["first"], second: one["second"]}) for one in case["solutions"]
        ]
        for q in expected:
            there, along = machine.forward(q)
            np.testing.assert_allclose(there, tip, atol=case["tol"]["fk_mm"], err_msg=case["id"])
            np.testing.assert_allclose(along, axis, atol=case["tol"]["fk_axis"], err_msg=case["id"])
        assert abs(machine.singular_angle(axis) - case["angle_to_singular_axis"]) < 1e-12, case["id"]
        if case["singular"]:
            # The free axis stays where it stood.
            near = np.zeros(5)
            near[3] = case["hold_work_side_axis"]
            assert apart(machine.inverse(tip, axis, near), expected[0]) < 1e-9, case["id"]
        else:
            found = machine.inverse(tip, axis, all=True)
            for q in expected:
                assert apart(found, q).min() < 1e-9, case["id"]


@pytest.mark.filterwarnings("ignore::trunnion.UnreachableWarning")
def test_reach(cases):
    """Tool axes inside the band of angles about the first rotary are reached, and those outside are not."""
    machines = {case["machine_name"]: case for case in cases["kinematics_general"] if not isinstance(case["machine"], str)}
    for case in cases["reachability"]:
        of = machines[case["machine_name"]]
        if len(of["joint_values"]) != 5:
            continue
        machine = machine_of(of)
        pole = machine.singular_directions()[0]
        aside = np.cross(pole, [0.3, 0.5, 0.7])
        aside /= np.linalg.norm(aside)
        edges = [case["polar_min"], case["polar_max"]]
        for angle in np.linspace(0.02, np.pi - 0.02, 40):
            # The band may be about the pole or about its opposite.
            along = [np.cos(a) * pole + np.sin(a) * aside for a in (angle, np.pi - angle)]
            inside = edges[0] < angle < edges[1]
            if min(abs(angle - edge) for edge in edges) < 0.01:
                continue
            reached = [np.isfinite(machine.inverse([0, 0, 0], axis, all=True)).any() for axis in along]
            assert (reached[0] or reached[1]) if inside else not all(reached), (case["id"], angle, reached)
        count = sum(
            np.isfinite(machine.inverse([0, 0, 0], np.cos(a) * pole + np.sin(a) * aside, all=True)).any()
            for a in np.linspace(0.005, np.pi - 0.005, 400)
        )
        assert abs(count / 400 - (edges[1] - edges[0]) / np.pi) < 0.01, case["id"]


def derivatives(coefficients, u):
    """Value and three derivatives of a polynomial with ascending coefficients, (4, 3)."""
    rows = []
    ascending = np.array(coefficients, dtype=float)
    for _ in range(4):
        rows.append(np.polynomial.polynomial.polyval(u, ascending.T))
        ascending = np.polynomial.polynomial.polyder(ascending, axis=1) if ascending.shape[1] > 1 else 0 * ascending
    return np.array(rows)


def test_coordinated_motion(cases):
    for case in cases["coordinated_motion"]:
        first, second = ROTARIES[case["layout"]]
        machine = layout(case, first, second)
        tip, axis = (derivatives(case[name], case["u"]) for name in ("P_poly", "D_poly"))
        near = in_order(machine, case["q"][:3], {first: case["q"][3], second: case["q"][4]})
        jets = machine.jets(tip, axis, near, arc_length=True)
        order = [machine.axes.index(name) for name in ("X", "Y", "Z", first, second)]
        assert apart(jets[0], near) < case["tol"]["pos"], case["id"]
        for row, name, tolerance in ((1, "t", "rel_vel"), (2, "K", "rel_acc"), (3, "L3", "rel_jerk")):
            expected = np.array(case[name])
            off = np.abs(jets[row][order] - expected).max() / np.abs(expected).max()
            assert off < 10 * case["tol"][tolerance], (case["id"], name, off)


def test_head_of_paper_000(cases):
    """Head-head machine of paper 000: O = (sin t2 sin t1, -sin t2 cos t1, cos t2), both rotaries through one point."""
    for case in cases["seed000_head_fixed_bed"]:
        zero = [0.0, 0.0, 0.0]
        machine = layout({"layout": 13, "table_sign": 1, "L": zero, "R": zero, "T": [0, 0, -case["d2"]]}, "C", "A")
        u = case["u"]
        theta = derivatives(case["theta"], u)
        q = np.array([*case["q"][:3], theta[0][0], theta[0][1]])
        tip, axis = machine.forward(q)
        expected = [np.sin(q[4]) * np.sin(q[3]), -np.sin(q[4]) * np.cos(q[3]), np.cos(q[4])]
        np.testing.assert_allclose(axis, expected, atol=1e-12, err_msg=case["id"])
        np.testing.assert_allclose(machine.inverse(tip, axis, q), q, atol=1e-9, err_msg=case["id"])


def test_time_law(cases):
    """Constant acceleration along a cubic: the time from speeds that are given at rows."""
    for case in cases["time_law"]:
        u = np.linspace(0.0, 1.0, 4001)
        jets = [derivatives(case["P_poly"], at) for at in u]
        rate = np.array([np.linalg.norm(jet[1]) for jet in jets])
        middle = np.array([np.linalg.norm(derivatives(case["P_poly"], 0.5 * (a + b))[1]) for a, b in zip(u, u[1:])])
        # Simpson's rule: exact to 1e-12 here.
        s = np.concatenate([[0.0], np.cumsum((rate[:-1] + 4 * middle + rate[1:]) * np.diff(u) / 6)])
        assert abs(s[-1] - case["S"]) < 1e-9 * case["S"], case["id"]
        table = {"s": s}
        for index, name in enumerate("XYZ"):
            first = np.array([jet[1][index] for jet in jets]) / rate
            along = np.array([jet[1] @ jet[2] for jet in jets]) / rate**2
            second = (np.array([jet[2][index] for jet in jets]) / rate - first * along) / rate
            table |= {name: np.array([jet[0][index] for jet in jets]), f"{name}1": first, f"{name}2": second}
        table["speed"] = np.sqrt(np.maximum(case["V0"] ** 2 + 2 * case["A_const"] * s, 0.0))
        limits = {name: (1e3, 1e5, 1e9) for name in "XYZ"}
        plan = trunnion.plan(table, limits, "given")
        assert abs(plan.duration - case["t_end"]) < 1e-8 * case["t_end"], (case["id"], plan.duration)
        half = np.interp(case["S_half"], plan.s, np.arange(len(plan.s)))
        assert abs(plan.t[int(round(half))] - case["t_half"]) < 1e-2 * case["t_half"], case["id"]


def test_single_blocks(cases):
    """Blocks of the look-ahead whose end speeds can be reached."""
    planned = 0
    for case in cases["lookahead"]:
        if case["kind"] != "single_block" or case["expect"]["ve"] != case["ve"] or case["expect"]["vs"] != case["vs"]:
            continue
        length = float(case["L"])
        table = {"s": [0.0, length], "X": [0.0, length], "X1": [1.0, 1.0], "X2": [0.0, 0.0]}
        axis = {"vel": case["F"], "acc": case["A"], "acc_minus": case["D"]}
        limits = trunnion.Limits({"X": axis}, {"start": case["vs"], "end": case["ve"]})
        plan = trunnion.plan(table, limits, "optimal", time_tolerance=1e-6)
        assert abs(plan.duration - case["total"]) < 2e-6 * case["total"], (case["id"], plan.duration)
        planned += 1
    assert planned >= 5


def test_blocks_whose_ends_cannot_be_reached(cases):
    """A control lowers the speed at an end without a word; here it is refused with the speed that can be reached."""
    refused = 0
    for case in cases["lookahead"]:
        if case["kind"] != "single_block" or (case["expect"]["ve"] == case["ve"] and case["expect"]["vs"] == case["vs"]):
            continue
        length = float(case["L"])
        table = {"s": [0.0, length], "X": [0.0, length], "X1": [1.0, 1.0], "X2": [0.0, 0.0]}
        axis = {"vel": case["F"], "acc": case["A"], "acc_minus": case["D"]}
        limits = trunnion.Limits({"X": axis}, {"start": case["vs"], "end": case["ve"]})
        with pytest.raises(trunnion.InputError) as error:
            trunnion.plan(table, limits, "optimal")
        (reached,) = map(float, re.findall(r", ([0-9.]+)", str(error.value)))
        assert reached == pytest.approx(case["expect"]["vp"], rel=1e-9), (case["id"], error.value)
        # With the speed that the message names it takes the time of the case.
        name, slower = ("end", "ve") if case["expect"]["ve"] != case["ve"] else ("start", "vs")
        limits.path[name] = case["expect"][slower] * (1 - 1e-9)
        plan = trunnion.plan(table, limits, "optimal", time_tolerance=1e-6)
        assert plan.duration == pytest.approx(case["total"], rel=2e-6), case["id"]
        refused += 1
    assert refused == 2


def test_sequences_of_blocks(cases):
    """Straight moves of five axes, planned as a control with look-ahead plans them."""
    planned = 0
    for case in cases["lookahead"]:
        if case["kind"] != "sequence":
            continue
        names, weights = "XYZAC", np.array([1.0, 1.0, 1.0, case["kw_mm_per_deg"], case["kw_mm_per_deg"]])
        moves = np.array(case["moves"])
        lengths = np.linalg.norm(moves * weights, axis=1)
        # Blocks of no length are dropped before planning.
        moves, lengths = moves[lengths > 0], lengths[lengths > 0]
        s = np.concatenate([[0.0], np.cumsum(lengths)])
        at = np.concatenate([np.zeros((1, 5)), np.cumsum(moves, axis=0)])
        table = {"s": s}
        for index, name in enumerate(names):
            table |= {name: at[:, index], f"{name}1": np.gradient(at[:, index], s), f"{name}2": np.zeros(len(s))}
        limits = {name: (vel, acc) for name, vel, acc in zip(names, case["vmax"], case["amax"])}
        limits = trunnion.Limits(limits, {"feed": case["F"], "start": case["v_start"], "end": case["v_end"]})
        plan = trunnion.plan(table, limits, "blocks", period=case["T"])
        expected, near = case["expect"], case["tol"]
        np.testing.assert_allclose(lengths, expected["L"], rtol=near, err_msg=case["id"])
        rows = np.searchsorted(plan.s, s - 1e-9 * s[-1])
        np.testing.assert_allclose(plan.s[rows], s, atol=1e-9 * s[-1], err_msg=case["id"])
        np.testing.assert_allclose(plan.speed[rows], expected["v"], rtol=near, atol=near, err_msg=case["id"])
        np.testing.assert_allclose(np.diff(plan.t[rows]), expected["t"], rtol=near, err_msg=case["id"])
        assert plan.duration == pytest.approx(expected["total"], rel=near), case["id"]
        planned += 1
    assert planned == 10


def test_listing_of_paper_003(cases):
    """The axis halfway on the great circle, as angles of a machine with table A and head B."""
    zero = [0.0, 0.0, 0.0]
    machine = layout({"layout": 31, "table_sign": -1, "L": zero, "R": zero, "T": zero}, "A", "B")
    for case in cases["seed003_listing"]:
        ends = np.array([case["from_XYZAB"], case["to_XYZAB"]], dtype=float)
        ends[:, 3:] = np.radians(ends[:, 3:])
        tip, axis = machine.forward(ends)
        halved = trunnion.Path(tip, axis).interpolate(1e6, 0.51 * np.arccos(np.clip(axis[0] @ axis[1], -1, 1)))
        assert len(halved) == 3, case["id"]
        found = machine.inverse(halved.tip[1], halved.axis[1], ends[0])
        found[3:] = np.degrees(found[3:])
        np.testing.assert_allclose(found, case["mid_XYZAB"], atol=1e-8, err_msg=case["id"])


def test_passing_the_pole(cases):
    """Rotary velocity where a great circle passes the pole, and the angle through which C swings."""
    zero = [0.0, 0.0, 0.0]
    machine = layout({"layout": 13, "table_sign": 1, "L": zero, "R": zero, "T": zero}, "C", "A")
    c = machine.axes.index("C")
    for case in cases["singular_pass"]:
        delta = np.radians(case["delta_deg"])

        def axis(s, delta=delta):
            sin, cos = np.sin(s), np.cos(s)
            across, up = np.sin(delta), np.cos(delta)
            value = np.array([cos * across, sin, cos * up])
            rate = np.array([-sin * across, cos, -sin * up])
            return np.array([value, rate, -value, -rate])

        tip = np.array([zero, [1.0, 0.0, 0.0], zero, zero])
        jets = machine.jets(tip, axis(0.0))
        assert abs(abs(jets[1][c]) / case["max_dtheta"] - 1) < 1e-9, case["id"]
        assert abs(machine.singular_angle(axis(0.0)[0]) - delta) < 1e-12, case["id"]
        steps = np.linspace(-0.5, 0.5, 2001)
        turned = machine.inverse(np.zeros((2001, 3)), np.array([axis(s)[0] for s in steps]))
        swept = abs(turned[-1, c] - turned[0, c])
        assert abs(swept / case["azimuth_sweep_rad_for_s_pm_0p5"] - 1) < 1e-9, case["id"]


def test_choice_of_branch(cases):
    """Continuing from pose to pose: round a cone C turns on, and through the pole it stands."""
    zero = [0.0, 0.0, 0.0]
    machine = layout({"layout": 13, "table_sign": 1, "L": zero, "R": zero, "T": zero}, "C", "A")
    cone, pole = cases["branch_selection"]
    turn = np.linspace(0.0, 2 * np.pi * cone["turns"], cone["points"])
    half = cone["half_angle"]
    round_cone = np.stack([np.sin(half) * np.cos(turn), np.sin(half) * np.sin(turn), np.full_like(turn, np.cos(half))], axis=1)
    s = np.linspace(-0.6, 0.6, 25)
    s = s[np.abs(s) > 1e-9]
    through = np.stack([np.sin(s), np.zeros_like(s), np.cos(s)], axis=1)
    for case, axes in ((cone, round_cone), (pole, through)):
        q = machine.inverse(np.zeros_like(axes), axes)
        travel = np.abs(np.diff(q, axis=0)).sum(axis=0)
        for name, expected in (("C", "expect_total_travel_first"), ("A", "expect_total_travel_second")):
            assert abs(travel[machine.axes.index(name)] - case[expected]) < 1e-6, (case["id"], name, travel)


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


def test_baselines_of_positioning(shared, patch):
    """Strips of other methods at the point of the paper, within the tolerance that the cases state."""
    cases = json.loads((shared / "cases" / "positioning.json").read_text())
    face = trunnion.Part.read(patch).faces[0]
    curvature = cases["curvature_at_0_4_0_5"]
    np.testing.assert_allclose(face.curvature([0.4, 0.5]), [curvature["kmin"], curvature["kmax"]], atol=curvature["tol"])
    bull = trunnion.Cutter.bull(10, 6)

    def width(feed, cutter=bull, **options):
        return trunnion.position(face, cutter, at=(0.4, 0.5), feed=feed, tolerance=0.01, **options).strip_width

    groups, near = cases["baselines_at_0_4_0_5"], cases["baselines_at_0_4_0_5"]["tol_rel"]
    for name, feed in (("feed_v", (0, 1)), ("feed_u", (1, 0))):
        group, back = groups[name], (-feed[0], -feed[1])
        for radius in (16, 6):
            found = width(feed, trunnion.Cutter.ball(2 * radius), method="ball")
            assert found == pytest.approx(group[f"ball{radius}"], rel=near), (name, radius)
        for way, sign in ((feed, "plus"), (back, "minus")):
            assert width(way, method="sturz", lead=5) == pytest.approx(group[f"sturz5_{sign}"], rel=near), (name, sign)
            best = width(way, offset_range=(-75, 75), side="either")
            assert best >= group[f"optimum_{sign}"] * (1 - near), (name, sign)
        # The swept envelope is never wider than the strip that the location claims, within a hundredth.
        swept = cases["swept_envelope"]
    assert width((0, 1)) == pytest.approx(swept["feed_v_plus"]["l"], abs=0.003)
    assert width((0, 1)) >= swept["feed_v_plus"]["swept_width"] - swept["feed_v_plus"]["tol"]


def test_passes_of_the_paper(shared, patch):
    """The whole patch along v: no more passes, and no longer ones, than the cases have."""
    case = json.loads((shared / "cases" / "positioning.json").read_text())["passes"]
    part = trunnion.Part.read(patch)
    found = trunnion.cover(part, trunnion.Cutter.bull(10, 6, length=100), excess=0.01, gouge=0.002, along="v")
    assert len(found.passes) <= case["full_v"]["passes"] + case["tol_passes"] and not found.unfinished
    assert found.length <= case["full_v"]["length"] < found.length * case["ball16"]["full_v"][1] / found.length
    assert found.worst_gouge <= 0.002


def de_boor(knots, points, degree, u):
    """Points of a B-spline, (n, 3)."""
    span = np.clip(np.searchsorted(knots, u, side="right") - 1, degree, len(knots) - degree - 2)
    rows = [points[span - degree + j] for j in range(degree + 1)]
    for level in range(1, degree + 1):
        for j in range(degree, level - 1, -1):
            low, high = knots[span - degree + j], knots[span + 1 + j - level]
            share = ((u - low) / (high - low))[:, None]
            rows[j] = (1 - share) * rows[j - 1] + share * rows[j]
    return rows[degree]


def spline_jets(knots, points, degree, u):
    """Points of a B-spline and their derivatives up to the third, (n, 4, 3)."""
    rows = [de_boor(knots, points, degree, u)]
    for _ in range(3):
        points = degree * np.diff(points, axis=0) / (knots[degree + 1 : -1] - knots[1 : -degree - 1])[:, None]
        knots, degree = knots[1:-1], degree - 1
        rows.append(de_boor(knots, points, degree, u))
    return np.stack(rows, axis=1)


def test_published_feed(shared):
    case = json.loads((shared / "cases" / "published-feed.json").read_text())["jcde2022"]
    assert case["published_s"]["the paper's optimum"] == 9.44
    knots, degree = np.array(case["knots"], dtype=float), case["degree"]
    u = np.linspace(0.0, 1.0, 1000)
    tip, upper = (spline_jets(knots, np.array(case[name], dtype=float), degree, u) for name in ("tip", "upper"))
    # A about x carries C about z, both through the origin.
    zero = [0.0, 0.0, 0.0]
    machine = layout({"layout": 23, "table_sign": 1, "L": zero, "R": zero, "T": zero}, "A", "C")
    jets = machine.jets(tip, upper - tip)
    table = {"s": u}
    for index, name in enumerate(machine.axes):
        table |= {f"{name}{order or ''}": np.ascontiguousarray(jets[:, order, index]) for order in range(4)}
    # The speed that the chord error allows within a servo period.
    rate = np.linalg.norm(tip[:, 1], axis=1)
    bend = np.linalg.norm(np.cross(tip[:, 1], tip[:, 2]), axis=1) / rate**3
    table["feed"] = np.sqrt(8 * 1.25e-4 / (np.maximum(bend, 1e-12) * 0.002**2)) / rate
    limits = trunnion.Limits({name: tuple(limit) for name, limit in case["limits"].items()}, {"feed": 1.0})
    plan = trunnion.plan(table, limits, "jerk")
    assert plan.within_limits and plan.lower_bound == pytest.approx(case["bound_4a99923_s"], abs=0.002)
    # As fast as what an interior-point method found with its limits at nodes alone, and faster than any published.
    assert plan.duration <= case["ipopt_node_limits_s"][1] * 1.002 < min(case["published_s"].values())
    path = trunnion.Path(tip[:, 0].copy(), (upper - tip)[:, 0] / np.linalg.norm((upper - tip)[:, 0], axis=1)[:, None])
    assert path.smooth(0.001, 1e-4).tip_deviation <= 0.001
