//! The setup search against brute force, and against the machine as it is.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use crate::chains;
use crate::dice;

use chains::{V3, axis, slides, spec};
use dice::Random;
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::ops::ControlFlow;
use trunnion::axes::{
    AxesError, AxesOptions, SearchAssurance, SetupOptions, SetupSearch, SetupVerdict, TiltBounds,
    WorkpieceTilt, follow, setup,
};
use trunnion::inverse::{Inverse, InverseSolutions};
use trunnion::machine::{AxisSpec, Kinematics, Machine, MachineSpec, Setup};
use trunnion::math::angle::unwrap_near;
use trunnion::types::{
    AxisVector, Interval, Motion, PieceGeometry, PoseCurve, PoseTolerance, Progress, Silent, Stage,
    Station, ToolPath, ToolPiece, ToolPose,
};

const DEGREE: f64 = PI / 180.0;

const OPTIONS: AxesOptions = AxesOptions {
    max_rotary_step: 0.3,
    ..AxesOptions::within(PoseTolerance::new(0.01, 1e-3), AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0))
};

fn search(bounds: TiltBounds) -> SetupOptions {
    SetupOptions {
        grid: 8.0 * DEGREE,
        tolerance: 0.1 * DEGREE,
        alike: 1e-9,
        within: 0.2 * DEGREE,
        most_planned: 400,
        ..SetupOptions::within_bounds(bounds)
    }
}

/// A cut of some length whose tool axis runs round a cone about `lean`.
fn path(lean: V3, half: f64, wind: f64, length: f64) -> ToolPath {
    let about = Rotation3::rotation_between(&V3::z(), &lean).unwrap();
    let stations: Vec<Station> = (0..=40)
        .map(|index| {
            let share = f64::from(index) / 40.0;
            let angle = TAU * wind * share;
            let axis = V3::new(half.sin() * angle.cos(), half.sin() * angle.sin(), half.cos());
            let tip = Point3::new(length * (share - 0.5), 5.0 * angle.sin(), 0.0);
            let pose = ToolPose { tip, axis: UnitVector3::new_normalize(about * axis) };
            Station { pose, contact: tip }
        })
        .collect();
    let geometry = PieceGeometry::Curve(PoseCurve::through(&stations, 10.0));
    ToolPath { pieces: vec![ToolPiece { motion: Motion::Cut, geometry }] }
}

fn rotary(name: &str, dir: V3, limits: Option<[f64; 2]>) -> AxisSpec {
    let mut axis = axis(name, dir, Some(V3::zeros()));
    if let Some(limits) = limits {
        (axis.limits, axis.cyclic) = (Some(limits.into()), None);
    }
    axis
}

/// Tables, heads and both; upright, lying and nutating workpiece-side rotaries, one with ends.
fn machine(which: usize, tilt: f64) -> MachineSpec {
    let limits = Some([-tilt, 1.9]);
    let nutating = V3::new(0.0, 1.0, 1.0);
    let (chain, rotaries) = match which {
        0 => (
            ["C", "B", "b", "X", "Y", "Z"],
            [rotary("C", V3::z(), None), rotary("B", V3::y(), limits)],
        ),
        1 => (
            ["b", "X", "Y", "Z", "A", "B"],
            [rotary("A", V3::x(), None), rotary("B", V3::y(), limits)],
        ),
        2 => (
            ["C", "b", "X", "Y", "Z", "A"],
            [rotary("C", V3::z(), Some([-3.5, 3.5])), rotary("A", V3::x(), limits)],
        ),
        _ => (
            ["C", "B", "b", "X", "Y", "Z"],
            [rotary("C", V3::z(), None), rotary("B", nutating, None)],
        ),
    };
    let mut axes = slides();
    axes.extend(rotaries);
    spec(&chain, axes, V3::new(0.0, 0.0, 100.0), V3::z())
}

fn on(spec: MachineSpec, rotation: [f64; 3]) -> Kinematics {
    Kinematics::new(&Machine::new(spec).unwrap(), &Setup::new(V3::zeros(), rotation, 0.0))
}

fn find(
    kinematics: &Kinematics,
    path: &ToolPath,
    search: &SetupOptions,
) -> Result<SetupSearch, AxesError> {
    setup(kinematics, path, &OPTIONS, search, &Silent)
}

fn poses(path: &ToolPath, count: u32) -> Vec<ToolPose> {
    let mut poses = Vec::new();
    for piece in &path.pieces {
        let PieceGeometry::Curve(curve) = &piece.geometry else { panic!() };
        let Interval { low: from, high: to } = curve.range();
        let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(count);
        poses.extend((0..=count).map(|i| curve.pose(at(i)).unwrap()));
    }
    poses
}

/// Least angle to the singular directions by the inverse itself; `None` where a pose needs the
/// tool-side rotary beyond its travel on both branches.
fn least(kinematics: &Kinematics, poses: &[ToolPose]) -> Option<f64> {
    let inverse = Inverse::new(kinematics).unwrap();
    let [low, high] = kinematics.machine().axes[4].limits.ends();
    let poles = inverse.singular_directions();
    let mut least = PI;
    for pose in poses {
        let fits = |q: &AxisVector| {
            let value = if low.is_finite() { unwrap_near(q[4], 0.5 * (low + high)) } else { q[4] };
            low <= value && value <= high
        };
        let Ok(InverseSolutions::Regular(both)) = inverse.solutions(pose) else { return None };
        if !both.iter().any(fits) {
            return None;
        }
        for pole in &poles {
            least = least.min(pole.angle(&pose.axis));
        }
    }
    Some(least)
}

/// Many rotations within bounds with their least angles, the best first.
fn brute_force(
    spec: &MachineSpec,
    path: &ToolPath,
    bounds: &TiltBounds,
    step: f64,
) -> Vec<(f64, WorkpieceTilt)> {
    let poses = poses(path, 40);
    let machine = Machine::new(spec.clone()).unwrap();
    let places = |Interval { low, high }: Interval| {
        let count = ((high - low) / step).ceil().max(1.0);
        std::iter::successors(Some(0.0), move |i| (*i < count).then_some(i + 1.0))
            .map(move |i| low + (high - low) * i / count)
    };
    let mut found = Vec::new();
    for tilt in places(bounds.tilt) {
        for towards in places(bounds.towards) {
            for turn in places(bounds.turn) {
                let lean = WorkpieceTilt { tilt, towards, turn };
                let rotation = lean.rotation();
                let setup = Setup { origin: Vector3::zeros(), rotation, tool_length: 0.0 };
                let least = least(&Kinematics::new(&machine, &setup), &poses);
                found.extend(least.map(|least| (least, lean)));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

/// The least angle of the first that the axes can really follow: a rotary with ends may run out on the
/// way, and branches may not be changed inside a cut, which angles alone do not tell.
fn first_followed(
    spec: &MachineSpec,
    path: &ToolPath,
    found: &[(f64, WorkpieceTilt)],
) -> Option<f64> {
    let machine = Machine::new(spec.clone()).unwrap();
    let poses = poses(path, 400);
    let followed = |(_, lean): &(f64, WorkpieceTilt)| {
        let rotation = lean.rotation();
        let setup = Setup { origin: Vector3::zeros(), rotation, tool_length: 0.0 };
        let kinematics = Kinematics::new(&machine, &setup);
        follow(&kinematics, path, &OPTIONS, &Silent).ok()?;
        least(&kinematics, &poses)
    };
    found.iter().find_map(followed)
}

/// A machine, a path and bounds.
#[derive(Debug, Clone, Copy)]
struct Case {
    which: usize,
    lean: [f64; 2],
    half: f64,
    wind: f64,
    tilt: f64,
    towards: f64,
    wide: f64,
    ends: f64,
}

impl Case {
    fn any(dice: &mut Random) -> Self {
        Self {
            which: dice.below(4),
            lean: [dice.within(-0.6, 0.6), dice.within(-0.6, 0.6)],
            half: dice.within(0.0, 0.6),
            wind: dice.within(0.2, 1.0),
            tilt: dice.within(0.1, 0.9),
            towards: dice.within(-3.0, 3.0),
            wide: dice.within(0.2, 2.0),
            ends: dice.within(0.3, 1.9),
        }
    }

    /// No rotation within the bounds is better, on any kind of machine; the one found is as good as it says and
    /// can be run; what is said of all others is true. Otherwise what is wrong.
    fn check(&self) -> Result<(), String> {
        let spec = machine(self.which, self.ends);
        let path = path(V3::new(self.lean[0], self.lean[1], 1.0), self.half, self.wind, 80.0);
        let turn = if self.which == 0 || self.which == 3 { [0.2; 2] } else { [-0.5, 0.5] };
        let bounds = TiltBounds {
            tilt: Interval::new(0.0, self.tilt),
            towards: Interval::new(self.towards, self.towards + self.wide),
            turn: turn.into(),
        };
        let kinematics = on(spec.clone(), [0.0; 3]);
        let search = search(bounds);
        let found = find(&kinematics, &path, &search).unwrap();
        let angles = brute_force(&spec, &path, &bounds, 3.0 * DEGREE);
        let brute = first_followed(&spec, &path, &angles);
        let SearchAssurance { bound, except, .. } = found.assurance;
        let deg = |least: Option<f64>| least.map(f64::to_degrees);
        let Some((best, followed)) = &found.best else {
            // That there is none is not always shown.
            let reported = format!("nothing found, brute force {:?}", deg(brute));
            return if brute.is_none() { Ok(()) } else { Err(reported) };
        };
        let again = Kinematics::new(kinematics.machine(), &best.setup);
        let measured = least(&again, &poses(&path, 400)).unwrap();
        let reported = format!(
            "{:.3} deg, measured {:.3}, brute force {:?}, bound {:?}, except {:.3}",
            best.least / DEGREE,
            measured / DEGREE,
            deg(brute),
            deg(bound),
            except / DEGREE
        );
        // Tool axes are looked at every 0.1 deg, those of the brute force less closely.
        let fault = |what: &str| Err(format!("{what}: {reported}"));
        if (best.least - measured).abs() > 0.2 * DEGREE {
            return fault("not what it says");
        }
        if best.least < brute.unwrap_or(0.0) - search.within - 0.1 * DEGREE {
            return fault("there is a better one");
        }
        if except <= 0.0 && bound.unwrap_or(0.0) < brute.unwrap_or(0.0) - 0.1 * DEGREE {
            return fault("bound too low");
        }
        if bound.unwrap_or(PI) > best.least + search.within + 0.05 * DEGREE {
            return fault("not shown");
        }
        if Ok(followed) != follow(&again, &path, &OPTIONS, &Silent).as_ref() {
            return fault("other axes");
        }
        if best.workpiece.tilt > self.tilt + 0.02 * DEGREE {
            return fault("out of bounds");
        }
        Ok(())
    }
}

/// Random machines, paths and bounds; `TRUNNION_TORTURE=1` tries 3000.
#[test]
fn nothing_within_the_bounds_is_better() {
    let count = if dice::full() { 3000 } else { 20 };
    let mut dice = Random(dice::seed());
    let cases: Vec<Case> = (0..count).map(|_| Case::any(&mut dice)).collect();
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|case| case.check().err().map(|why| format!("{case:?}: {why}")))
        .collect();
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Cases that a search from a grid got wrong: a lower height climbed, a window between ends of travel missed.
#[test]
fn what_a_grid_gets_wrong_is_found() {
    let lower = Case {
        which: 3,
        lean: [0.2359, 0.5209],
        half: 0.3694,
        wind: 0.6529,
        tilt: 0.8589,
        towards: -2.8441,
        wide: 1.1259,
        ends: 0.3,
    };
    assert_eq!(lower.check(), Ok(()));
}

fn wide() -> TiltBounds {
    TiltBounds {
        tilt: Interval::new(0.0, FRAC_PI_4),
        towards: Interval::new(-PI, PI),
        turn: Interval::point(0.0),
    }
}

/// A cone of 10 degrees, upright on the pole, can be tilted 45 degrees off: 35 are left.
#[test]
fn a_cone_on_the_pole_is_tilted_as_far_as_it_may_be() {
    let kinematics = on(machine(0, 1.0), [0.0; 3]);
    let cone = path(V3::z(), 10.0 * DEGREE, 1.0, 80.0);
    let found = find(&kinematics, &cone, &search(wide())).unwrap();
    let (best, _) = found.best.unwrap();
    assert!((found.before.least - 10.0 * DEGREE).abs() < 1e-3);
    assert!((best.least - 35.0 * DEGREE).abs() < 0.1 * DEGREE, "{}", best.least / DEGREE);
    let travel = |verdict: &SetupVerdict| verdict.fits().unwrap().rotary.first;
    assert!(travel(&best.verdict) < 0.5 * travel(&found.before.verdict));
    assert_eq!(best.setup.origin, V3::zeros(), "there is no need to move it");
    assert!(found.others.iter().all(|other| other.least <= best.least + 1e-9));
}

/// The same on any number of threads.
#[test]
fn a_search_does_not_depend_on_threads() {
    let kinematics = on(machine(2, 1.2), [0.0, 0.0, 0.3]);
    let path = path(V3::new(0.2, 0.1, 1.0), 0.2, 0.8, 50.0);
    let bounds = TiltBounds { turn: Interval::new(-0.3, 0.3), ..wide() };
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        pool.install(|| find(&kinematics, &path, &search(bounds)).unwrap())
    };
    assert_eq!(on_threads(1), on_threads(3));
}

/// Short slides: the origin is moved where that helps; where nothing does, what is short is reported.
#[test]
fn linear_travel_decides_with_the_origin() {
    let cone = path(V3::z(), 0.2, 1.0, 200.0);
    let with = |half: f64| {
        let mut spec = machine(0, 1.0);
        for axis in spec.axes.iter_mut().take(3) {
            axis.limits = Some(Interval::new(50.0 - half, 50.0 + half));
        }
        on(spec, [0.0; 3])
    };
    let found = find(&with(140.0), &cone, &search(wide())).unwrap();
    assert!(found.before.verdict.fits().is_none(), "the origin is 100 mm off");
    assert!(found.before_axes.is_none());
    let (best, followed) = found.best.unwrap();
    assert!(best.setup.origin != V3::zeros());
    assert!(best.least > 30.0 * DEGREE, "{}", best.least / DEGREE);
    for node in followed.path.pieces.iter().flat_map(|piece| &piece.nodes) {
        assert!(node.q[0].iter().take(3).all(|value| (value - 50.0).abs() <= 140.0));
    }
    let found = find(&with(30.0), &cone, &search(wide())).unwrap();
    assert!(found.best.is_none());
    let SetupVerdict::Short { by, axes } = &found.others[0].verdict else { panic!("{found:?}") };
    assert!(*by > 10.0 && !axes.is_empty(), "{by} {axes:?}");
    assert!(found.others.iter().all(|other| other.verdict.fits().is_none()));
}

/// Where every rotation leans the tool too far, the one that does by least is reported.
#[test]
fn what_leans_too_far_is_reported() {
    let mut spec = machine(0, 1.0);
    spec.axes[4].limits = Some(Interval::new(-0.1, 0.1));
    let cone = path(V3::new(1.0, 0.0, 1.0), 0.3, 1.0, 50.0);
    let found = find(&on(spec, [0.0; 3]), &cone, &search(wide())).unwrap();
    assert!(found.best.is_none() && found.evaluated == found.beyond_tilt);
    let SetupVerdict::BeyondTilt(by) = found.others[0].verdict else { panic!("{found:?}") };
    // Tilted back by 45 degrees the cone of 0.3 rad is 0.2 too wide.
    assert!((by - 0.2).abs() < 0.07, "{by}");
}

/// Bounds of one rotation are that rotation; the setup of the job stays where nothing is better.
#[test]
fn fixed_bounds_are_kept_and_the_best_is_not_left() {
    let kinematics = on(machine(0, 1.0), [0.0, FRAC_PI_4, 0.0]);
    let cone = path(V3::z(), 0.2, 1.0, 80.0);
    let one = TiltBounds {
        tilt: Interval::point(0.3),
        towards: Interval::point(FRAC_PI_2),
        turn: Interval::point(0.0),
    };
    let (best, _) = find(&kinematics, &cone, &search(one)).unwrap().best.unwrap();
    assert!((best.workpiece.tilt - 0.3).abs() < 0.01 * DEGREE);
    assert!((best.angles[0] + 0.3).abs() < 0.01 * DEGREE && best.angles[1].abs() < 1e-12);
    let alike = SetupOptions { alike: DEGREE, ..search(wide()) };
    let found = find(&kinematics, &cone, &alike).unwrap();
    let (best, _) = found.best.unwrap();
    assert!(best.least > found.before.least - DEGREE);
}

struct Stop;

impl Progress for Stop {
    fn report(&self, _: Stage, _: u64, _: u64) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

#[test]
fn nonsense_is_refused_and_a_stop_obeyed() {
    let kinematics = on(machine(0, 1.0), [0.0; 3]);
    let cone = path(V3::z(), 0.2, 1.0, 80.0);
    let bad = TiltBounds { tilt: Interval::new(0.5, 0.2), ..wide() };
    let error = find(&kinematics, &cone, &search(bad)).unwrap_err();
    assert!(error.to_string().starts_with("tilt from 28.648 to 11.459 deg"), "{error}");
    let bad = SetupOptions { grid: 0.0, ..search(wide()) };
    assert!(matches!(find(&kinematics, &cone, &bad), Err(AxesError::BadOption { .. })));
    let stopped = setup(&kinematics, &cone, &OPTIONS, &search(wide()), &Stop);
    assert!(matches!(stopped, Err(AxesError::Cancelled(_))));
}
