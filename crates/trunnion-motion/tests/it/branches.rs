//! Branch, whole turns and retracts on random machines and paths with ends of travel, against every
//! choice tried one by one. A small count by default; `just torture` sets `TRUNNION_TORTURE=1`. The
//! seed is printed; `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the counts say what was tried")]

use crate::chains;
use crate::dice;
use crate::every_choice;

use chains::{V3, axis, curve, knots, spec};
use dice::{Random, full, seed};
use every_choice::{
    assert_complete, brute_force, brute_force_retracts, cut, every_interval, fixed_cuts,
};
use nalgebra::{Rotation3, UnitVector3};
use std::f64::consts::{PI, TAU};
use trunnion::axes::{AxesError, AxesOptions, FollowedPath, RetractOptions, follow};
use trunnion::inverse::{Inverse, InverseSolutions};
use trunnion::machine::{Kinematics, Machine, MachineSpec, RotaryPair, Setup};
use trunnion::math::angle::{angle_between, wrap};
use trunnion::math::jet::{Jet, Real};
use trunnion::types::{
    AxisVector, Interval, PieceGeometry, PoseTolerance, Silent, ToolPath, ToolPose,
};

const RETRACT_IN_CUT: f64 = 500.0;

/// So tight that no branch is left for the other \[rad\].
const TIGHT: f64 = 0.06;

/// So loose that nodes hardly stand but at the knots, and so tight that no branch is left for the other.
fn options(random: &mut Random, retract: Option<RetractOptions>) -> AxesOptions {
    AxesOptions {
        max_rotary_step: 10.0,
        rotary_weights: RotaryPair::new(1.0, random.within(0.2, 5.0)),
        retract,
        ..AxesOptions::within(PoseTolerance::new(1e5, TIGHT), AxisVector::zeros())
    }
}

/// Slides before, between or after two rotaries in random directions with ends of travel, and the bed
/// anywhere: the same with ends of travel far off, and as it is.
fn machines(random: &mut Random) -> [Kinematics; 2] {
    const ORDERS: [[&str; 5]; 3] =
        [["X", "Y", "Z", "P", "S"], ["P", "X", "Y", "Z", "S"], ["P", "S", "X", "Y", "Z"]];
    let mut order = ORDERS[random.below(3)].to_vec();
    order.insert(random.below(6), "b");
    let [p, s, tool] = loop {
        let all = [0; 3].map(|_| random.direction());
        if [(0, 1), (1, 2)].iter().all(|&(i, j)| all[i].cross(&all[j]).norm() > 0.3) {
            break all.map(UnitVector3::into_inner);
        }
    };
    let mut axes = chains::slides();
    axes.extend([axis("P", p, Some(random.point(200.0))), axis("S", s, Some(random.point(200.0)))]);
    for axis in &mut axes {
        axis.sense = if random.below(2) == 0 { 1.0 } else { -1.0 };
    }
    let free = spec(&order, axes, random.point(200.0), tool);
    let mut bound = free.clone();
    for axis in &mut bound.axes[3..] {
        axis.limits = Some(Interval::new(-random.within(0.8, 4.5), random.within(0.8, 4.5)));
        axis.cyclic = None;
    }
    let turn: [f64; 3] = random.point(PI).into();
    let setup = Setup::new(random.point(200.0), turn, random.within(0.0, 200.0));
    let of = |spec: MachineSpec| Kinematics::new(&Machine::new(spec).unwrap(), &setup);
    [of(free), of(bound)]
}

/// What the search found is what is best of all, or that there is nothing.
fn compare(found: Result<&FollowedPath, &AxesError>, best: Option<f64>, reported: &str) {
    match (found, best) {
        (Ok(followed), Some(best)) => {
            let cost = followed.rotary_travel;
            assert!((cost - best).abs() < 1e-6, "{reported}: {cost} found, {best} is best");
        }
        (Err(AxesError::OutOfTravel { .. } | AxesError::NoRetract { .. }), None) => {}
        (found, best) => {
            panic!("{reported}: {:?}, best {best:?}", found.map(|followed| followed.rotary_travel))
        }
    }
}

/// Stops no axis leaves its travel at, and no derivative is lost.
fn assert_inside(machine: &Kinematics, followed: &FollowedPath) {
    for node in followed.path.pieces.iter().flat_map(|piece| &piece.nodes) {
        let beyond = machine.machine().out_of_travel(&node.q[0]);
        assert!(beyond.is_none_or(|beyond| beyond.excess < 1e-8));
    }
}

#[test]
fn cuts_and_links_on_random_machines() {
    let mut random = Random(seed());
    let count = if full() { 20_000 } else { 150 };
    let [mut ran, mut refused] = [0, 0];
    for case in 0..count {
        let [free, machine] = machines(&mut random);
        let inverse = Inverse::new(&free).unwrap();
        let number = 2 + random.below(3);
        let axes: Vec<V3> = std::iter::repeat_with(|| {
            let mut q = AxisVector::zeros();
            (q[3], q[4]) = (random.within(-PI, PI), random.within(-PI, PI));
            free.forward(&q).axis
        })
        .filter(|axis| inverse.pole_distance(axis) > 0.05)
        .take(number)
        .map(UnitVector3::into_inner)
        .collect();
        let options = options(&mut random, None);
        let found = follow(&machine, &fixed_cuts(&axes), &options, &Silent);
        let best = brute_force(&machine, &axes, options.rotary_weights.into());
        compare(found.as_ref(), best, &format!("case {case}"));
        match &found {
            Ok(followed) => {
                assert_inside(&machine, followed);
                ran += 1;
            }
            Err(_) => refused += 1,
        }
    }
    println!("{count} paths of cuts and links: {ran} run, {refused} refused");
    assert!(ran > count / 10 && refused > count / 50, "{ran} {refused}");
}

/// A cut round the workpiece-side rotary, by up to two turns, that comes nearer to it or goes farther
/// off. Both rotaries then turn one way, so that what they reach they reach at nodes; and both branches
/// stay apart.
fn round(
    random: &mut Random,
    free: &Kinematics,
    spans: u32,
) -> Option<(PieceGeometry, UnitVector3<f64>)> {
    let inverse = Inverse::new(free).unwrap();
    let w1 = free.chain().rotary[0].dir;
    let mut q = AxisVector::zeros();
    (q[3], q[4]) = (random.within(-PI, PI), random.within(-PI, PI));
    let start = free.forward(&q).axis;
    let distance = inverse.pole_distance(&start);
    if !(0.3..1.1).contains(&distance) {
        return None;
    }
    let up = if w1.dot(&start) > 0.0 { w1 } else { -w1 };
    let side = UnitVector3::new_normalize(start.into_inner() - up.scale(up.dot(&start)));
    let across = up.cross(&side);
    let turn = random.within(0.6, 2.2) * TAU * if random.below(2) == 0 { 1.0 } else { -1.0 };
    let drift = random.within(-0.15, 0.15);
    let geometry = curve(knots(0.0, 1.0, spans), |u: Jet| {
        let (sin, cos) = (u * drift + distance).sin_cos();
        let (s, c) = (u * turn).sin_cos();
        let axis = [0, 1, 2].map(|row| cos * up[row] + sin * (c * side[row] + s * across[row]));
        ([u * 50.0, s * 20.0, c * 20.0], axis)
    });
    let PieceGeometry::Curve(of) = &geometry else { return None };
    let apart = (0..=40).all(|i| {
        let pose = of.pose(f64::from(i) / 40.0).unwrap();
        let both = inverse.solutions(&pose);
        matches!(both, Ok(InverseSolutions::Regular([a, b])) if wrap(a[4] - b[4]).abs() > 0.8)
    });
    apart.then_some((geometry, up))
}

/// A cut on a machine with ends of travel, how to retract, and the poses where one way may be left for
/// another.
struct Left {
    machine: Kinematics,
    path: ToolPath,
    options: AxesOptions,
    nodes: Vec<ToolPose>,
}

fn left(random: &mut Random, spans: u32, axis_tolerance: f64) -> Option<Left> {
    let [free, machine] = machines(random);
    let turned = random.point(1.0);
    let (geometry, up) = round(random, &free, spans)?;
    // Not exactly along the axis of the cone.
    let up = Rotation3::from_scaled_axis(turned * 0.1) * up;
    let retract = RetractOptions {
        least: 10.0,
        approach: 20.0,
        margin: 1.0,
        price: 50.0,
        price_in_cut: RETRACT_IN_CUT,
        ..RetractOptions::to_plane(up, 400.0)
    };
    let options = AxesOptions {
        tolerance: PoseTolerance::new(1e5, axis_tolerance),
        ..options(random, Some(retract))
    };
    let path = ToolPath { pieces: vec![cut(geometry)] };
    let all = follow(&free, &path, &options, &Silent).ok()?;
    let poses = all.path.pieces[0].nodes.iter().map(|node| pose_at(&path, node.s));
    let nodes = poses.collect();
    Some(Left { machine, path, options, nodes })
}

fn pose_at(path: &ToolPath, u: f64) -> ToolPose {
    let PieceGeometry::Curve(of) = &path.pieces[0].geometry else { panic!() };
    of.pose(u).unwrap()
}

/// How random cuts ended.
#[derive(Default)]
struct Tally {
    ran: usize,
    refused: usize,
    retracts: usize,
}

impl Tally {
    fn cuts(&self) -> usize {
        self.ran + self.refused
    }

    /// One more, that must be whole and inside travel if it runs.
    fn add(&mut self, machine: &Kinematics, path: &ToolPath, found: Option<&FollowedPath>) {
        let Some(followed) = found else {
            self.refused += 1;
            return;
        };
        assert_complete(path, followed);
        assert_inside(machine, followed);
        self.retracts += followed.retracts.len();
        self.ran += 1;
    }

    /// Enough of them ran, and enough had to retract, to mean something.
    fn has_both(&self, what: &str) {
        let Self { ran, refused, retracts } = *self;
        let count = self.cuts();
        println!("{count} {what}: {ran} run with {retracts} retracts, {refused} refused");
        assert!(ran > count / 10 && retracts > count / 10, "{ran} {refused} {retracts}");
    }
}

#[test]
fn cuts_that_have_to_be_left_on_random_machines() {
    let mut random = Random(seed());
    let count = if full() { 20_000 } else { 150 };
    let mut tally = Tally::default();
    while tally.cuts() < count {
        let Some(Left { machine, path, options, nodes }) = left(&mut random, 7, TIGHT) else {
            continue;
        };
        if nodes.len() > 11 {
            continue;
        }
        let found = follow(&machine, &path, &options, &Silent);
        let best =
            brute_force_retracts(&machine, &nodes, options.rotary_weights.into(), RETRACT_IN_CUT);
        let reported = format!("case {}", tally.cuts());
        compare(found.as_ref(), best, &reported);
        let again = every_interval(&machine, &nodes, options.rotary_weights.into(), RETRACT_IN_CUT);
        let same = best.zip(again).is_none_or(|(a, b)| (a - b).abs() < 1e-9);
        assert!(same && best.is_some() == again.is_some(), "{reported}: {best:?} {again:?}");
        tally.add(&machine, &path, found.ok().as_ref());
    }
    tally.has_both("cuts");
}

/// Hundreds of poses, so that much of the way is chosen many intervals at once.
#[test]
fn long_cuts_that_have_to_be_left_on_random_machines() {
    let mut random = Random(seed());
    let count = if full() { 1_000 } else { 15 };
    let mut tally = Tally::default();
    while tally.cuts() < count {
        let spans = 150 + u32::try_from(random.below(300)).unwrap();
        let Some(Left { machine, path, options, nodes }) = left(&mut random, spans, TIGHT) else {
            continue;
        };
        let found = follow(&machine, &path, &options, &Silent);
        let best = every_interval(&machine, &nodes, options.rotary_weights.into(), RETRACT_IN_CUT);
        compare(found.as_ref(), best, &format!("case {}", tally.cuts()));
        tally.add(&machine, &path, found.ok().as_ref());
    }
    tally.has_both("long cuts");
}

/// With loose tolerances a way may pass from one branch to the other: what is found must be within
/// tolerance, and never worse than the best that keeps its branch.
#[test]
fn loose_tolerances_are_used_and_nothing_is_lost_by_them() {
    let mut random = Random(seed());
    let count = if full() { 20_000 } else { 150 };
    let [mut ran, mut refused, mut better] = [0, 0, 0];
    while ran + refused < count {
        let tolerance = random.within(0.05, 0.5);
        let Some(Left { machine, path, options, nodes }) = left(&mut random, 7, tolerance) else {
            continue;
        };
        if nodes.len() > 11 {
            continue;
        }
        let reported = format!("case {}, {tolerance} rad", ran + refused);
        let found = follow(&machine, &path, &options, &Silent);
        let best = every_interval(&machine, &nodes, options.rotary_weights.into(), RETRACT_IN_CUT);
        let Ok(followed) = &found else {
            assert!(best.is_none(), "{reported}: {best:?} is possible, but {found:?}");
            refused += 1;
            continue;
        };
        ran += 1;
        assert_complete(&path, followed);
        assert_inside(&machine, followed);
        if best.is_none_or(|best| followed.rotary_travel < best - 1e-6) {
            better += 1;
        } else if let Some(best) = best {
            assert!(followed.rotary_travel < best + 1e-6, "{reported}: {best}");
        }
        let off = farthest_off(&machine, &path, followed);
        assert!(off <= tolerance, "{reported}: {off} rad off");
    }
    println!(
        "{count} loose cuts: {ran} run, {better} better than on one branch, {refused} refused"
    );
    assert!(ran > count / 10 && refused > count / 10, "{ran} {refused}");
}

/// Largest angle between the tool axes of the axis path and of the tool path, at 40 points between
/// nodes \[rad\].
fn farthest_off(machine: &Kinematics, path: &ToolPath, followed: &FollowedPath) -> f64 {
    let mut worst = 0.0_f64;
    for (index, piece) in followed.path.pieces.iter().enumerate() {
        if followed.retracts.iter().any(|retract| retract.pieces.contains(&index)) {
            continue;
        }
        for pair in piece.nodes.windows(2) {
            for i in 0..=40 {
                let s = pair[0].s + (pair[1].s - pair[0].s) * f64::from(i) / 40.0;
                let is = machine.forward(&piece.axes_at(s).unwrap()[0]);
                worst = worst.max(angle_between(&is.axis, &pose_at(path, s).axis));
            }
        }
    }
    worst
}
