//! Axis paths against the exact kinematics, another discretisation, and brute force.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::chains;
use crate::every_choice;
use crate::property;

use chains::{V3, axis, cases, curve, knots, layout, number, slides, spec};
use every_choice::{
    assert_complete, brute_force, brute_force_retracts, cut, fixed_cuts, link, straight,
};
use nalgebra::{Point3, UnitVector3};
use proptest::prelude::*;
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::ControlFlow;
use trunnion::axes::{
    AxesError, AxesOptions, FollowedPath, RetractOptions, SingularOptions, follow, origins,
};
use trunnion::feed::{FeedOptions, Limits, jerk, optimal};
use trunnion::inverse::{Inverse, InverseError};
use trunnion::machine::{
    Kinematics, Machine, MachineSpec, PreferredSign, RetractFrame, RetractPolicy, Setup,
};
use trunnion::math::angle::{angle_between, wrap};
use trunnion::math::jet::{Jet, Real};
use trunnion::types::{
    AxisPiece, AxisVector, Interval, Motion, PieceGeometry, PoseTolerance, Progress, Silent, Stage,
    ToolPath, ToolPiece, ToolPose,
};

const OPTIONS: AxesOptions = AxesOptions {
    max_rotary_step: 0.2,
    ..AxesOptions::within(PoseTolerance::new(1e-3, 1e-4), AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0))
};

/// C-A head on a gantry, pivots above the tip.
fn head(c_limits: Option<[f64; 2]>) -> Kinematics {
    kinematics(head_spec(c_limits))
}

fn head_spec(c_limits: Option<[f64; 2]>) -> MachineSpec {
    let mut axes = slides();
    axes.push(axis("C", V3::z(), Some(V3::new(0.0, 0.0, 300.0))));
    axes.push(axis("A", V3::x(), Some(V3::new(0.0, 10.0, 250.0))));
    if let Some(limits) = c_limits {
        axes[3].limits = Some(limits.into());
        axes[3].cyclic = None;
    }
    axes[4].limits = Some(Interval::new(-2.0, 2.0));
    axes[4].cyclic = None;
    spec(&["b", "X", "Y", "Z", "C", "A"], axes, V3::zeros(), V3::z())
}

fn kinematics(spec: trunnion::machine::MachineSpec) -> Kinematics {
    Kinematics::new(&Machine::new(spec).unwrap(), &Setup::new(V3::zeros(), [0.0; 3], 0.0))
}

/// Rotary travel inside the pieces.
fn travel(pieces: &[AxisPiece]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for pair in pieces.iter().flat_map(|piece| piece.nodes.windows(2)) {
        sum[0] += (pair[1].q[0][3] - pair[0].q[0][3]).abs();
        sum[1] += (pair[1].q[0][4] - pair[0].q[0][4]).abs();
    }
    sum
}

/// Worst distance of the axis path from the tool path, at 23 points between any two nodes.
fn recheck(kinematics: &Kinematics, path: &ToolPath, followed: &FollowedPath) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for piece in &followed.path.pieces {
        let PieceGeometry::Curve(curve) = &path.pieces[piece.source].geometry else { continue };
        for pair in piece.nodes.windows(2) {
            for i in 0..=23 {
                let s = pair[0].s + (pair[1].s - pair[0].s) * f64::from(i) / 23.0;
                let is = kinematics.forward(&piece.axes_at(s).unwrap()[0]);
                let wanted = curve.pose(s).unwrap();
                worst[0] = worst[0].max((is.tip - wanted.tip).norm());
                worst[1] = worst[1].max(angle_between(&is.axis, &wanted.axis));
            }
        }
    }
    worst
}

/// Pieces meet, and derivatives at nodes are those of the quintics.
fn assert_continuous(followed: &FollowedPath) {
    for pair in followed.path.pieces.windows(2) {
        let [end, start] = [pair[0].nodes.last().unwrap(), pair[1].nodes.first().unwrap()];
        let gap = (end.q[0] - start.q[0]).amax();
        assert!(gap < 1e-9, "gap of {gap:e} between {} and {}", pair[0].source, pair[1].source);
    }
    for piece in &followed.path.pieces {
        assert!(piece.nodes.len() >= 2);
        assert!(piece.nodes.windows(2).all(|pair| pair[0].s < pair[1].s));
        assert!(
            piece.nodes.iter().all(|node| node.q.iter().all(|q| q.iter().all(|x| x.is_finite())))
        );
    }
}

fn run(kinematics: &Kinematics, path: &ToolPath) -> FollowedPath {
    let followed = follow(kinematics, path, &OPTIONS, &Silent).unwrap();
    assert_continuous(&followed);
    let [tip, axis] = recheck(kinematics, path, &followed);
    assert!(tip <= OPTIONS.tolerance.tip && axis <= OPTIONS.tolerance.axis, "{tip:e} {axis:e}");
    followed
}

fn cone(half_angle: f64) -> impl Fn(Jet) -> ([Jet; 3], [Jet; 3]) {
    move |u| {
        let (sin, cos) = u.sin_cos();
        let (s, c) = half_angle.sin_cos();
        ([cos * 50.0, sin * 50.0, u * 2.0], [cos * s, sin * s, Jet::constant(c)])
    }
}

#[test]
fn reference_paths_choose_their_branch() {
    for case in cases("branch_selection.json") {
        let machine = layout(&json!({"layout": case["layout"], "table_sign": 1})).0;
        // A machine without ends of travel; a case with some must not pass for one without.
        assert!(case.as_object().unwrap().contains_key("limits") && case["limits"].is_null());
        assert!(machine.machine().axes[3..].iter().all(|axis| axis.limits.high.is_infinite()));
        let path = if case["id"] == "cone3turns-CA" {
            let [half, turns] = ["half_angle", "turns"].map(|key| number(&case[key]));
            let points = u32::try_from(case["points"].as_u64().unwrap()).unwrap();
            cut(curve(knots(0.0, TAU * turns, points - 1), cone(half)))
        } else {
            assert!(case["arc"].as_str().unwrap().starts_with("in the xz plane, s=-0.6..0.6"));
            // An even count puts a knot on the pole itself.
            cut(curve(knots(-0.6, 0.6, 24), arc(0.0)))
        };
        let followed = run(&machine, &ToolPath { pieces: vec![path] });
        let [first, second] = travel(&followed.path.pieces);
        let tol = number(&case["tol"]).max(1e-8);
        assert!((first - number(&case["expect_total_travel_first"])).abs() <= tol, "{first}");
        assert!((second - number(&case["expect_total_travel_second"])).abs() <= tol, "{second}");
    }
}

/// Great circle in the x-z plane, moved `off` to the side of the pole.
fn arc(off: f64) -> impl Fn(Jet) -> ([Jet; 3], [Jet; 3]) {
    move |u| {
        let (sin, cos) = u.sin_cos();
        let (s, c) = f64::sin_cos(off);
        ([u * 100.0, u * u * 20.0, Jet::constant(5.0)], [sin, cos * s, cos * c])
    }
}

#[test]
fn through_the_pole_wherever_the_nodes_fall() {
    let machine = head(None);
    for (from, to, count) in
        [(-0.6, 0.6, 1), (-0.6, 0.6, 7), (-0.3, 0.9, 3), (0.0, 0.5, 2), (-0.5, 0.0, 2)]
    {
        let path = ToolPath { pieces: vec![cut(curve(knots(from, to, count), arc(0.0)))] };
        let followed = run(&machine, &path);
        let [first, second] = travel(&followed.path.pieces);
        // The quintic spans of the tool path are themselves 1e-4 off a great circle's speed.
        assert!(first < 1e-4 && (second - (to - from)).abs() < 1e-3, "{count}: {first} {second}");
        assert!(
            followed.path.pieces[0].nodes.len() < 80,
            "{}",
            followed.path.pieces[0].nodes.len()
        );
    }
}

/// Nearer than the tolerance: straight through. Farther: the first rotary swings half a turn.
#[test]
fn beside_the_pole() {
    let machine = head(None);
    for (off, swings) in [(1e-12, false), (1e-8, false), (1e-6, false), (1e-3, true), (0.02, true)]
    {
        let path = ToolPath { pieces: vec![cut(curve(knots(-0.6, 0.6, 8), arc(off)))] };
        let followed = run(&machine, &path);
        let [first, _] = travel(&followed.path.pieces);
        assert_eq!(first > 3.0, swings, "{off}: {first}");
        assert!(first < 3.2);
    }
    // In between either is right, as long as it stays within tolerance.
    for off in [3e-6, 9e-6, 1.1e-5, 2e-5, 5e-5, 1e-4, 2e-4] {
        for (from, count) in [(-0.6, 8), (-0.5, 1), (-0.55, 3)] {
            let path = ToolPath { pieces: vec![cut(curve(knots(from, 0.6, count), arc(off)))] };
            let [first, _] = travel(&run(&machine, &path).path.pieces);
            assert!(first < 3.2, "{off}: {first}");
        }
    }
}

/// Beside the pole C whips half round within a few millimetres: nodes follow its angle, limits hold everywhere, and a
/// grid four times as fine finds the same time.
#[test]
fn beside_the_pole_the_grid_goes_by_angle() {
    /// Two degrees, as jobs are followed.
    const STEP: f64 = PI / 90.0;
    let machine = head(None);
    let velocity = AxisVector::new(500.0, 500.0, 500.0, 6.0, 6.0);
    let acceleration = velocity * 10.0;
    let limits = Limits {
        velocity,
        rapid: velocity,
        acceleration,
        jerk: Some(velocity * 200.0),
        minus: None,
    };
    let options = FeedOptions::fastest().with_feed(100.0);
    for off in [2e-3, 0.01, 0.05] {
        let path = ToolPath { pieces: vec![cut(curve(knots(-0.6, 0.6, 8), arc(off)))] };
        let times = [STEP, 0.25 * STEP].map(|step| {
            let fine = AxesOptions { max_rotary_step: step, ..OPTIONS };
            let followed = follow(&machine, &path, &fine, &Silent).unwrap();
            let nodes = &followed.path.pieces[0].nodes;
            let turns = nodes.windows(2).map(|pair| (pair[1].q[0][3] - pair[0].q[0][3]).abs());
            // Stretches of a ten-thousandth of the path may turn by any angle; nearest to the pole they do.
            let turned = turns.fold(0.0, f64::max);
            assert!(turned <= if off < 5e-3 { 0.04 } else { step }, "{off} {step}: {turned}");
            let plans =
                [optimal, jerk].map(|plan| plan(&followed.path, &limits, &options, &Silent));
            plans.map(|plan| {
                let plan = plan.unwrap();
                assert!(plan.bounds.velocity <= 1.0 + 1e-9, "{off}: {:?}", plan.bounds);
                assert!(plan.bounds.acceleration <= 1.0 + 1e-9, "{off}: {:?}", plan.bounds);
                assert!(plan.ratios.velocity > 0.9, "{off}: {:?}", plan.ratios);
                plan.schedule.duration()
            })
        });
        for (coarse, fine) in times[0].iter().zip(times[1]) {
            assert!((coarse / fine - 1.0).abs() < 0.01, "{off}: {coarse} {fine}");
        }
    }
}

#[test]
fn at_the_pole_the_free_axis_is_held() {
    let machine = head(None);
    let [a, b, c] = [V3::new(0.0, 0.0, 50.0), V3::zeros(), V3::new(40.0, 0.0, 0.0)];
    // All vertical: nothing turns at all.
    let up = V3::z();
    let vertical = [straight(a, b, up), straight(b, c, up), straight(c, a, up)].map(cut).to_vec();
    let followed = run(&machine, &ToolPath { pieces: vertical });
    assert!(followed.rotary_travel.abs() < 1e-15);
    assert!(travel(&followed.path.pieces).iter().all(|travel| *travel < 1e-15));
    // Down vertically, then a cut that leaves the pole towards +y: C waits where the cut needs it.
    let leave = curve(knots(0.0, 0.4, 2), |u| {
        let (sin, cos) = u.sin_cos();
        ([u * 30.0, Jet::constant(0.0), Jet::constant(0.0)], [Jet::constant(0.0), sin, cos])
    });
    let path = ToolPath { pieces: vec![cut(straight(a, b, up)), cut(leave)] };
    let followed = run(&machine, &path);
    let [lead, cutting] = &followed.path.pieces[..] else { panic!() };
    let c_axis =
        |piece: &AxisPiece| piece.nodes.iter().map(|node| node.q[0][3]).collect::<Vec<_>>();
    assert!(c_axis(lead).iter().chain(&c_axis(cutting)).all(|c| wrap(*c).abs() < 1e-9));
    assert!((travel(&followed.path.pieces)[1] - 0.4).abs() < 1e-3);
}

/// Two curves that leave the pole different ways cannot be joined without a link.
#[test]
fn a_turn_at_rest_is_refused_or_done_out_of_the_part() {
    let leave = |way: f64| {
        curve(knots(0.0, 0.4, 2), move |u| {
            let (sin, cos) = u.sin_cos();
            (
                [u * 30.0, Jet::constant(0.0), Jet::constant(0.0)],
                [sin * way.cos(), sin * way.sin(), cos],
            )
        })
    };
    let arrive = curve(knots(-0.4, 0.0, 2), |u| {
        let (sin, cos) = u.sin_cos();
        ([u * 30.0, Jet::constant(0.0), Jet::constant(0.0)], [sin, Jet::constant(0.0), cos])
    });
    let path = ToolPath { pieces: vec![cut(arrive), cut(leave(1.0))] };
    let error = follow(&head(None), &path, &OPTIONS, &Silent).unwrap_err();
    assert!(matches!(error, AxesError::TurnAtRest { piece: 1, before: 0, .. }), "{error}");

    // Out of the part it can turn: by 1 rad, on the branch that has it there.
    let retract = AxesOptions { retract: Some(RETRACT), ..OPTIONS };
    let followed = follow(&head(None), &path, &retract, &Silent).unwrap();
    assert_continuous(&followed);
    assert_complete(&path, &followed);
    let [there] = &followed.retracts[..] else { panic!("{:?}", followed.retracts) };
    assert!(!there.in_cut && there.source == 1 && there.u.abs() < 1e-12, "{there:?}");
    let [before, after]: [[f64; 2]; 2] = [there.before.into(), there.after.into()];
    assert!(((after[0] - before[0]).abs() - 1.0).abs() < 1e-6, "{there:?}");
    assert!((after[1] - before[1]).abs() < 1e-6, "{there:?}");
    let whole = 0.8 + 1.0 + RETRACT.price;
    let start = followed.path.pieces[0].nodes[0].q[0];
    let to_start = start[3].abs() + start[4].abs();
    assert!((followed.rotary_travel - whole - to_start).abs() < 1e-6, "{}", followed.rotary_travel);
}

proptest! {
    #![proptest_config(property::cases(60))]

    #[test]
    fn the_choice_is_the_best_of_all(
        tilts in prop::array::uniform4((0.1..1.4f64, -PI..PI)),
        reach in prop::array::uniform2(1.0..7.0f64),
        weight in 0.2..5.0f64,
    ) {
        let machine = head(Some([-reach[0], reach[1]]));
        let axes = tilts.map(|(tilt, turn)| {
            V3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos())
        });
        let weights = [1.0, weight];
        let options = AxesOptions { rotary_weights: weights.into(), ..OPTIONS };
        let found = follow(&machine, &fixed_cuts(&axes), &options, &Silent);
        if let Some(best) = brute_force(&machine, &axes, weights) {
            let followed = found.unwrap();
            assert_continuous(&followed);
            let travel = followed.rotary_travel;
            prop_assert!((travel - best).abs() < 1e-9, "{travel} {best}");
            for node in followed.path.pieces.iter().flat_map(|piece| &piece.nodes) {
                prop_assert!(machine.machine().out_of_travel(&node.q[0]).is_none());
            }
        } else {
            let refused = matches!(found, Err(AxesError::OutOfTravel { .. }));
            prop_assert!(refused);
        }
    }

    /// Any smooth path, on the three kinds of machine, checked at other points than the nodes'.
    #[test]
    fn any_smooth_path_is_followed(
        which in 0..60usize,
        tip in prop::array::uniform9(-40.0..40.0f64),
        bend in prop::array::uniform9(-0.5..0.5f64),
    ) {
        let machine = layout(&cases("layouts.json")[which]).0;
        let inverse = Inverse::new(&machine).unwrap();
        let geometry = curve(knots(0.0, 1.0, 3), |u| {
            let poly = |c: &[f64], start: f64| (u * c[0] + c[1]) * u * u + u * c[2] + start;
            (
                [poly(&tip[0..3], 0.0), poly(&tip[3..6], 10.0), poly(&tip[6..9], 0.0)],
                [poly(&bend[0..3], 0.55), poly(&bend[3..6], 0.6), poly(&bend[6..9], 0.6)],
            )
        });
        let PieceGeometry::Curve(pose_curve) = &geometry else { panic!() };
        let clear = (0..=50).all(|i| {
            let pose = pose_curve.pose(f64::from(i) / 50.0).unwrap();
            inverse.pole_distance(&pose.axis) > 0.05
        });
        prop_assume!(clear);
        let path = ToolPath { pieces: vec![cut(geometry.clone())] };
        let followed = run(&machine, &path);
        prop_assert!(followed.path.pieces[0].nodes.len() < 200);
        // Derivatives at the nodes against differences of the exact inverse.
        for node in &followed.path.pieces[0].nodes {
            let h = 1e-4;
            if node.s < 2.0 * h || node.s > 1.0 - 2.0 * h || (node.s * 3.0).fract().min(1.0 - (node.s * 3.0).fract()) < 1e-3 {
                continue;
            }
            let at = |s: f64| inverse.near(&pose_curve.pose(s).unwrap(), &node.q[0]).unwrap();
            let [back, here, forth] = [at(node.s - h), at(node.s), at(node.s + h)];
            let scale = 1.0 + node.q[1].amax() + node.q[2].amax() + node.q[3].amax();
            prop_assert!((here - node.q[0]).amax() < 1e-9);
            prop_assert!(((forth - back) / (2.0 * h) - node.q[1]).amax() < 1e-5 * scale);
            prop_assert!(((forth - here * 2.0 + back) / (h * h) - node.q[2]).amax() < 1e-3 * scale);
        }
    }
}

/// A cable-bound C must unwind on links: three turns of a cone in three cuts.
#[test]
fn turns_are_unwound_on_links() {
    let limit = 370.0_f64.to_radians();
    let machine = head(Some([-limit, limit]));
    let turn = |index: f64| curve(knots(TAU * index, TAU * (index + 1.0), 40), cone(0.35));
    let ends = |geometry: &PieceGeometry| {
        let PieceGeometry::Curve(curve) = geometry else { panic!() };
        curve.range().ends().map(|u| curve.pose(u).unwrap())
    };
    let turns = [0.0, 1.0, 2.0].map(turn);
    let all = ToolPath { pieces: turns.iter().cloned().map(cut).collect() };
    let error = follow(&machine, &all, &OPTIONS, &Silent).unwrap_err();
    let AxesError::OutOfTravel { axis, excess, .. } = &error else { panic!("{error}") };
    assert_eq!(axis, "C");
    assert!(*excess > 1.0, "{error}");
    let reported = format!("by {:.4} deg on", excess.to_degrees());
    assert!(error.to_string().contains(&reported), "{error}");
    let mut pieces = Vec::new();
    for geometry in &turns {
        if let Some(ToolPiece { geometry: last, .. }) = pieces.last() {
            pieces.push(link(ends(last)[1], ends(geometry)[0]));
        }
        pieces.push(cut(geometry.clone()));
    }
    let followed = run(&machine, &ToolPath { pieces });
    for node in followed.path.pieces.iter().flat_map(|piece| &piece.nodes) {
        assert!(node.q[0][3].abs() <= limit + 1e-9);
    }
    assert_eq!(followed.path.pieces.len(), 5);
}

/// A link turns its rotaries in proportion while the tip goes straight.
#[test]
fn a_link_is_straight_at_the_tip() {
    let machine = head(None);
    let axes = [V3::new(0.3, 0.1, 1.0), V3::new(-0.5, 0.4, 0.8)].map(|v| v.normalize());
    let path = fixed_cuts(&axes);
    let followed = run(&machine, &path);
    let piece = &followed.path.pieces[1];
    let PieceGeometry::Reorient { from, to } = &path.pieces[1].geometry else { panic!() };
    let [first, last] = [piece.nodes.first().unwrap(), piece.nodes.last().unwrap()];
    for i in 0..=100 {
        let share = f64::from(i) / 100.0;
        let q = piece.axes_at(last.s * share).unwrap()[0];
        let tip = machine.forward(&q).tip;
        let wanted: Point3<f64> = from.tip + (to.tip - from.tip) * share;
        assert!((tip - wanted).norm() < OPTIONS.tolerance.tip);
        let rotaries = first.q[0] + (last.q[0] - first.q[0]) * share;
        assert!((q - rotaries).fixed_rows::<2>(3).amax() < 1e-12);
    }
    assert!((first.tip_rate - 1.0).abs() < 1e-12);
}

/// Where two branches cost the same, an axis decides.
#[test]
fn preference_breaks_ties() {
    for prefer in [PreferredSign::Positive, PreferredSign::Negative] {
        let mut spec_of = {
            let mut axes = slides();
            axes.push(axis("C", V3::z(), Some(V3::zeros())));
            axes.push(axis("A", V3::x(), Some(V3::zeros())));
            spec(&["b", "X", "Y", "Z", "C", "A"], axes, V3::zeros(), V3::z())
        };
        spec_of.axes[4].prefer = Some(prefer);
        let machine = kinematics(spec_of);
        // Tilted about y: C = +-90 deg either way.
        let axis = V3::new(0.5, 0.0, 0.75_f64.sqrt());
        let followed = run(&machine, &fixed_cuts(&[axis]));
        let a = followed.path.pieces[0].nodes[0].q[0][4];
        assert!((a.abs() - 0.5_f64.asin()).abs() < 1e-12);
        assert_eq!(a > 0.0, prefer == PreferredSign::Positive);
        assert!((followed.rotary_travel - FRAC_PI_2 - a.abs()).abs() < 1e-9);
    }
}

#[test]
fn what_cannot_be_run_says_where_and_why() {
    let machine = head(None);
    let axis = V3::new(0.0, 0.6, 0.8);
    let far = straight(V3::zeros(), V3::new(3e5, 0.0, 0.0), axis);
    let error =
        follow(&machine, &ToolPath { pieces: vec![cut(far)] }, &OPTIONS, &Silent).unwrap_err();
    let AxesError::OutOfTravel { piece: 0, axis: name, excess, value, limit, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(name, "X");
    assert!((excess - (value - limit)).abs() < 1e-6 && (*excess - 2e5).abs() < 500.0, "{error}");
    assert!(error.to_string().contains("mm or more beyond the ends of X; turn"), "{error}");
    assert!(error.to_string().contains(&format!("by {excess:.4} mm on")), "{error}");

    let gap =
        vec![cut(straight(V3::zeros(), V3::x(), axis)), cut(straight(V3::y(), V3::x(), axis))];
    let error = follow(&machine, &ToolPath { pieces: gap }, &OPTIONS, &Silent).unwrap_err();
    assert!(matches!(error, AxesError::Gap { piece: 1, before: 0, .. }));

    let options =
        AxesOptions { tolerance: PoseTolerance { tip: 0.0, ..OPTIONS.tolerance }, ..OPTIONS };
    let error = follow(&machine, &ToolPath::default(), &options, &Silent).unwrap_err();
    assert!(matches!(error, AxesError::BadOption { option: "tolerance.tip", .. }));
    let empty = follow(&machine, &ToolPath::default(), &OPTIONS, &Silent).unwrap();
    assert!(empty.path.pieces.is_empty());
}

#[test]
fn an_unreachable_direction_is_named() {
    let mut axes = slides();
    axes.push(axis("C", V3::z(), Some(V3::zeros())));
    axes.push(axis("B", V3::new(0.0, 1.0, 1.0), Some(V3::zeros())));
    let machine = kinematics(spec(&["C", "b", "X", "Y", "Z", "B"], axes, V3::zeros(), V3::z()));
    let down = straight(V3::zeros(), V3::x(), V3::new(0.8, 0.0, -0.6));
    let error =
        follow(&machine, &ToolPath { pieces: vec![cut(down)] }, &OPTIONS, &Silent).unwrap_err();
    let AxesError::Inverse { piece: 0, source: InverseError::Unreachable { miss, .. }, .. } = error
    else {
        panic!("{error}")
    };
    assert!((miss - 0.6_f64.asin()).abs() < 1e-12);
}

#[test]
fn a_stop_is_a_stop() {
    struct Stopping;
    impl Progress for Stopping {
        fn report(&self, _: Stage, _: u64, _: u64) -> ControlFlow<()> {
            ControlFlow::Break(())
        }
    }
    let path = fixed_cuts(&[V3::new(0.0, 0.6, 0.8)]);
    let error = follow(&head(None), &path, &OPTIONS, &Stopping).unwrap_err();
    assert!(matches!(error, AxesError::Cancelled(_)));
}

/// Same bytes on any number of threads.
#[test]
fn threads_do_not_matter() {
    let axes: Vec<V3> = (0..20)
        .map(|i| V3::new(f64::from(i).sin() * 0.5, f64::from(i).cos() * 0.4, 1.0).normalize())
        .collect();
    let path = fixed_cuts(&axes);
    let machine = head(Some([-6.5, 6.5]));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| follow(&machine, &path, &OPTIONS, &Silent).unwrap())
    };
    assert_eq!(on(1), on(3));
}

const RETRACT: RetractOptions = RetractOptions {
    least: 10.0,
    approach: 20.0,
    margin: 1.0,
    price: 50.0,
    price_in_cut: 500.0,
    ..RetractOptions::to_plane(UnitVector3::new_unchecked(V3::new(0.0, 0.0, 1.0)), 400.0)
};

fn retract_options() -> AxesOptions {
    AxesOptions { retract: Some(RETRACT), ..OPTIONS }
}

/// Three turns of a cone in one cut, and C ends after half a turn either way.
#[test]
fn where_travel_ends_in_a_cut_the_tool_retracts_and_unwinds() {
    let machine = head(Some([-PI, PI]));
    let path = ToolPath { pieces: vec![cut(curve(knots(0.0, 3.0 * TAU, 120), cone(0.35)))] };
    let refused = follow(&machine, &path, &OPTIONS, &Silent).unwrap_err();
    assert!(matches!(refused, AxesError::OutOfTravel { .. }));
    let followed = follow(&machine, &path, &retract_options(), &Silent).unwrap();
    assert_continuous(&followed);
    assert_complete(&path, &followed);
    // Starting anywhere, 18.85 rad of winding need three times more than one turn of travel.
    assert_eq!(followed.retracts.len(), 3);
    for node in followed.path.pieces.iter().flat_map(|piece| &piece.nodes) {
        assert!(machine.machine().out_of_travel(&node.q[0]).is_none(), "{}", node.q[0]);
    }
    for retract in &followed.retracts {
        assert!(retract.in_cut && retract.source == 0);
        let [before, after]: [[f64; 2]; 2] = [retract.before.into(), retract.after.into()];
        // Round by a turn, or half a turn to the other branch.
        let moved = [after[0] - before[0], after[1] - before[1]];
        let [turn, flip] = [[-TAU, 0.0], [-PI, -2.0 * before[1]]];
        let is = |way: [f64; 2]| (moved[0] - way[0]).hypot(moved[1] - way[1]) < 1e-9;
        assert!(is(turn) || is(flip), "{moved:?}");
        let pieces = &followed.path.pieces[retract.pieces.clone()];
        let ends = [&pieces[0].nodes[0], pieces.last().unwrap().nodes.last().unwrap()];
        for node in ends {
            let pose = machine.forward(&node.q[0]);
            assert!((pose.tip - retract.pose.tip).norm() < 1e-9);
            assert!(angle_between(&pose.axis, &retract.pose.axis) < 1e-12);
        }
        // Along the tool axis first, at the feed for 20 mm, and only above the part do rotaries turn.
        assert_eq!(pieces[0].motion, Motion::LeadOut);
        assert_eq!(pieces.last().unwrap().motion, Motion::LeadIn);
        let lead = machine.forward(&pieces[0].nodes.last().unwrap().q[0]).tip - retract.pose.tip;
        assert!((lead - retract.pose.axis.scale(20.0)).norm() < 1e-6);
        for piece in pieces {
            let turn = piece.nodes.last().unwrap().q[0][3] - piece.nodes[0].q[0][3];
            if turn.abs() > 1e-9 {
                for i in 0..=200 {
                    let s = piece.nodes.last().unwrap().s * f64::from(i) / 200.0;
                    let tip = machine.forward(&piece.axes_at(s).unwrap()[0]).tip;
                    assert!(tip.z > RETRACT.plane - 1e-6, "{tip}");
                }
            }
        }
    }
}

/// Retracts go between passes where they can.
#[test]
fn a_retract_between_pieces_is_better_than_in_a_cut() {
    let machine = head(Some([-1.5 * PI, 1.5 * PI]));
    let turns = |from: f64, to: f64| cut(curve(knots(TAU * from, TAU * to, 40), cone(0.35)));
    let path = ToolPath { pieces: vec![turns(0.0, 1.0), turns(1.0, 2.0)] };
    let followed = follow(&machine, &path, &retract_options(), &Silent).unwrap();
    assert_complete(&path, &followed);
    let [retract] = &followed.retracts[..] else { panic!("{}", followed.retracts.len()) };
    assert!(!retract.in_cut && retract.source == 1 && retract.u.abs() > 1.0);
    assert!((retract.u - TAU).abs() < 1e-12);
}

/// The retracting axis of the machine file, and what it may not do.
#[test]
fn the_machine_says_how_to_retract() {
    let path = ToolPath { pieces: vec![cut(curve(knots(0.0, 3.0 * TAU, 120), cone(0.35)))] };
    let with = |retract: RetractPolicy, low: f64| {
        let mut spec = head_spec(Some([-PI, PI]));
        spec.retract = retract;
        let z = spec.axes.iter_mut().find(|axis| axis.name == "Z").unwrap();
        z.limits = Some(Interval::new(-1000.0, low));
        kinematics(spec)
    };
    let machine = RetractPolicy { to: 700.0, ..RetractPolicy::standard() };
    let highest = |kinematics: &Kinematics, retract: &RetractOptions| {
        let options = AxesOptions { retract: Some(*retract), ..OPTIONS };
        let followed = follow(kinematics, &path, &options, &Silent).unwrap();
        let nodes = followed.path.pieces.iter().flat_map(|piece| &piece.nodes);
        nodes.map(|node| node.q[0][2]).fold(f64::NEG_INFINITY, f64::max)
    };
    assert!((highest(&with(machine.clone(), 1000.0), &RETRACT) - 700.0).abs() < 1e-9);
    // Not to the very end of travel.
    assert!((highest(&with(machine.clone(), 700.0), &RETRACT) - 699.0).abs() < 1e-9);
    // A position below the part is no retract: the tool stays where it is clear.
    let below = RetractPolicy { to: -500.0, ..RetractPolicy::standard() };
    assert!((highest(&with(below, 1000.0), &RETRACT) - 400.0).abs() < 60.0);
    // Along the tool by a distance.
    let tool = RetractPolicy { frame: RetractFrame::Tool, to: 900.0, ..RetractPolicy::standard() };
    let z = highest(&with(tool, 1000.0), &RETRACT);
    assert!((z - 900.0 * 0.35_f64.cos()).abs() < 60.0, "{z}");
    // No room above the part.
    let options = AxesOptions { retract: Some(RETRACT), ..OPTIONS };
    let error = follow(&with(machine.clone(), 300.0), &path, &options, &Silent).unwrap_err();
    assert!(matches!(error, AxesError::NoRetract { piece: 0, .. }), "{error}");
    let sideways = RetractOptions { up: -V3::z_axis(), ..RETRACT };
    let options = AxesOptions { retract: Some(sideways), ..OPTIONS };
    let error = follow(&with(machine, 1000.0), &path, &options, &Silent).unwrap_err();
    assert!(error.to_string().contains("leads to the side"), "{error}");
}

proptest! {
    #![proptest_config(property::cases(128))]

    /// Branch, whole turns, travel and retracts: as cheap as the cheapest of all sequences.
    #[test]
    fn retracts_are_the_best_of_all(
        half in 0.2..1.2f64,
        wind in 0.6..2.2f64,
        reach in prop::array::uniform2(1.8..4.5f64),
        tilt in 0.5..1.9f64,
        weight in 0.2..3.0f64,
        way in prop::bool::ANY,
    ) {
        let mut spec = head_spec(Some([-reach[0], reach[1]]));
        spec.axes[4].limits = Some(Interval::new(-tilt, 1.9));
        let machine = kinematics(spec);
        let turn = TAU * if way { wind } else { -wind };
        let geometry = curve(knots(0.0, 1.0, 7), |u| cone(half)(u * turn));
        let PieceGeometry::Curve(of) = &geometry else { panic!() };
        // So loose that nodes hardly stand but at the knots.
        let options = AxesOptions {
            tolerance: PoseTolerance::new(1e4, 0.3),
            max_rotary_step: 10.0,
            rotary_weights: [1.0, weight].into(),
            ..retract_options()
        };
        let path = ToolPath { pieces: vec![cut(geometry.clone())] };
        let free = follow(&head(None), &path, &options, &Silent).unwrap();
        let nodes = &free.path.pieces[0].nodes;
        prop_assume!(nodes.len() < 12);
        let nodes: Vec<ToolPose> = nodes.iter().map(|node| of.pose(node.s).unwrap()).collect();
        let found = follow(&machine, &path, &options, &Silent);
        if let Some(best) = brute_force_retracts(&machine, &nodes, options.rotary_weights.into(), RETRACT.price_in_cut) {
            let followed = found.unwrap();
            assert_complete(&path, &followed);
            prop_assert!((followed.rotary_travel - best).abs() < 1e-6,
                "{} {best}", followed.rotary_travel);
        } else {
            let refused = matches!(
                found,
                Err(AxesError::OutOfTravel { .. } | AxesError::NoRetract { .. })
            );
            prop_assert!(refused, "{:?}", found.map(|found| found.rotary_travel));
        }
    }
}

/// One branch has a rotary 16 degrees beyond its end, the other a slide 33 mm beyond: another origin mends the latter only.
#[test]
fn a_slide_beyond_its_end_is_named_where_the_other_branch_lacks_a_rotary() {
    let text = include_str!("../../../../machines/layout-33-ca-table-head.toml");
    let machine = trunnion::files::machine::parse(text).unwrap().machine;
    let setup = Setup::new(V3::new(80.4, 8.0, -567.6), [0.0; 3], 120.0);
    let tip = V3::new(58.848_827, 0.230_625, 53.650_635);
    let axis = V3::new(0.7154, -0.0028, 0.6987);
    let path = ToolPath { pieces: vec![cut(straight(tip, tip + V3::x(), axis))] };
    let error = follow(&Kinematics::new(&machine, &setup), &path, &OPTIONS, &Silent).unwrap_err();
    let AxesError::OutOfTravel { axis, excess, limit, remedy, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(axis, "Y", "{error}");
    assert!((excess - 33.4).abs() < 0.1 && (limit - 300.0).abs() < 1e-9, "{error}");
    assert!(remedy.contains("origin"), "{error}");
}

/// The refusal of a bad origin names good ones, and they are good: on a tilting table, where each pose
/// moves the slides another way.
#[test]
fn an_origin_out_of_travel_is_put_right() {
    let text = include_str!("../../../../machines/bc-trunnion.toml");
    let machine = trunnion::files::machine::parse(text).unwrap().machine;
    let at = |origin: V3| Kinematics::new(&machine, &Setup::new(origin, [0.0, 0.3, 0.0], 120.0));
    let path = ToolPath { pieces: vec![cut(curve(knots(0.0, TAU, 40), cone(0.6)))] };
    let runs = |origin: V3| follow(&at(origin), &path, &OPTIONS, &Silent);
    let error = runs(V3::new(0.0, 0.0, -300.0)).unwrap_err();
    let AxesError::OutOfTravel { remedy, .. } = &error else { panic!("{error}") };
    assert!(remedy.contains("origin = [") && remedy.contains("does not fit"), "{error}");
    let good = V3::new(-381.0, -254.0, -505.0);
    let followed = runs(good).unwrap();
    let origins = origins(&at(good), &followed).unwrap();
    assert!(origins.room > 0.0 && !origins.tight.is_empty());
    assert!(remedy.contains(&format!("{:.1}", origins.best.z)), "{remedy} {:?}", origins.best);
    runs(origins.best).unwrap();
    for axis in 0..3 {
        let [low, high] = origins.along[axis].unwrap().ends();
        assert!(low < good[axis] && good[axis] < high);
        for (end, way) in [(low, 1.0), (high, -1.0)] {
            let mut origin = good;
            origin[axis] = end;
            runs(origin).unwrap();
            // A millimetre is kept as room at both ends; farther out it does not fit.
            origin[axis] = end - way * 3.0;
            assert!(runs(origin).is_err(), "{origin}");
        }
    }
    // A part that no origin fits, and one that only another origin does.
    for (length, fits) in [(900.0, true), (2000.0, false)] {
        let axis = V3::new(0.0, 0.5, 1.0).normalize();
        let long = cut(straight(V3::zeros(), V3::new(0.0, length, 0.0), axis));
        let long = ToolPath { pieces: vec![long] };
        let error = follow(&at(good), &long, &OPTIONS, &Silent).unwrap_err().to_string();
        assert_eq!(error.contains("no other does"), !fits, "{error}");
        if fits {
            let list = error.rsplit("origin = [").next().unwrap().split(']').next().unwrap();
            let origin: Vec<f64> = list.split(", ").map(|x| x.parse().unwrap()).collect();
            follow(&at(V3::from_row_slice(&origin)), &long, &OPTIONS, &Silent).unwrap();
        }
    }
}

const SINGULAR: SingularOptions = SingularOptions { cone: 0.1, min_rotary: 0.3, tilt: 2e-3 };

/// Largest turn of the first rotary per radian of tool turn, and its travel.
fn swing(
    machine: &Kinematics,
    path: &ToolPath,
    singular: Option<SingularOptions>,
) -> (f64, f64, FollowedPath) {
    let options = AxesOptions { singular, ..OPTIONS };
    let followed = follow(machine, path, &options, &Silent).unwrap();
    assert_continuous(&followed);
    let nodes = followed.path.pieces.iter().flat_map(|piece| &piece.nodes);
    let fastest = nodes.map(|node| node.q[1][3].abs()).fold(0.0, f64::max);
    (fastest, travel(&followed.path.pieces)[0], followed)
}

/// The rate of the first rotary at a pole is that of the reference (the great circle passes at
/// `delta`); moved away, that of a passage farther off; moved onto the pole, none.
#[test]
fn singular_directions_are_passed_through_or_farther_off() {
    let machine = head(None);
    let pass =
        |delta: f64| ToolPath { pieces: vec![cut(curve(knots(-0.6, 0.6, 200), arc(delta)))] };
    for case in cases("singular_pass.json") {
        let delta = number(&case["delta_deg"]).to_radians();
        let (rate, _, _) = swing(&machine, &pass(delta), None);
        let expected = number(&case["max_dtheta"]);
        assert!((rate - expected).abs() < 1e-3 * expected, "{rate} {expected}");
        let (rate, turn, followed) = swing(&machine, &pass(delta), Some(SINGULAR));
        let farther = 1.0 / (delta + SINGULAR.tilt).sin();
        assert!(rate < 1.02 * farther && rate > 0.95 * farther, "{rate} {farther}");
        let [passage] = &followed.passages[..] else { panic!("{:?}", followed.passages) };
        assert!((passage.distance_before - delta).abs() < 1e-6);
        assert!((passage.distance_after - delta - passage.tilt).abs() < 1e-9);
        assert!(passage.tilt <= SINGULAR.tilt && passage.tilt > 0.98 * SINGULAR.tilt);
        assert!(turn > 2.5);
    }
    // Within the tolerance: straight through, and the swing of half a turn is gone.
    let near = pass(1.5e-3);
    let (_, turn, _) = swing(&machine, &near, None);
    assert!(turn > 3.0);
    let (rate, turn, followed) = swing(&machine, &near, Some(SINGULAR));
    assert!(turn < 0.1 && rate < 1.0, "{turn} {rate}");
    let [passage] = &followed.passages[..] else { panic!("{:?}", followed.passages) };
    assert!((passage.u.abs()) < 1e-3 && passage.distance_after < 1e-12, "{passage:?}");
    assert!(passage.turn_before > 3.0 && passage.turn_after < 0.1);
    // Nowhere is the tool farther from its path than it may be, and the tip not at all.
    let [tip, axis] = recheck(&machine, &near, &followed);
    assert!(tip < OPTIONS.tolerance.tip && axis < SINGULAR.tilt + OPTIONS.tolerance.axis, "{axis}");
}

/// Each of the three knobs decides.
#[test]
fn singular_knobs_are_obeyed() {
    let machine = head(None);
    let near = ToolPath { pieces: vec![cut(curve(knots(-0.6, 0.6, 100), arc(1.5e-3)))] };
    let changed = |singular| swing(&machine, &near, Some(singular)).2.passages.len();
    assert_eq!(changed(SINGULAR), 1);
    assert_eq!(changed(SingularOptions { cone: 1e-3, ..SINGULAR }), 0);
    assert_eq!(changed(SingularOptions { min_rotary: 3.13, ..SINGULAR }), 0);
    let small = SingularOptions { tilt: 5e-4, ..SINGULAR };
    let passage = swing(&machine, &near, Some(small)).2.passages[0];
    assert!(passage.distance_after > 1.9e-3, "away, where through would be too far: {passage:?}");
    // A cut that begins inside the cone is left alone.
    let starts = ToolPath { pieces: vec![cut(curve(knots(-0.01, 0.6, 100), arc(1.5e-3)))] };
    assert!(swing(&machine, &starts, Some(SINGULAR)).2.passages.is_empty());
    let error = follow(
        &machine,
        &near,
        &AxesOptions { singular: Some(SingularOptions { tilt: 0.0, ..SINGULAR }), ..OPTIONS },
        &Silent,
    )
    .unwrap_err();
    assert!(matches!(error, AxesError::BadOption { option: "singular.tilt", .. }));
}
