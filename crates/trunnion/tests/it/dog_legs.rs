//! Rapid moves over a face, on controls that run each axis at its own speed and on those that do not.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;

use nalgebra::{Point3, Vector3};
use shop::Layout;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Machine};
use trunnion::nc::read::{self, Dialect, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{AxisVector, Silent, ToolPose};
use trunnion::verify::{
    self, BoundMargins, BoundOptions, CheckInput, CheckOptions, DeviationTolerance, ExtremeHeight,
    Finding, Report,
};

const RADIUS: f64 = 5.0;
const OPTIONS: CheckOptions = CheckOptions {
    reach: 4.0,
    ray_tolerance: 1e-4,
    most_points: 100_000,
    bounds: Some(BoundOptions::within(BoundMargins::both(1e-3))),
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 0.5)
};

/// A machine whose slides but Z are ten times as fast as Z.
fn machine() -> Machine {
    let mut machine = shop::machine(Layout::TableTable);
    machine.axes[2].rapid = 0.1 * machine.axes[0].rapid;
    machine
}

/// Square, 8 mm wide, and a little hollow.
fn face() -> Face {
    let row = |i: u8| {
        let place = |j: u8| [f64::from(i) - 1.0, f64::from(j) - 1.0];
        (0..3).map(place).map(|[x, y]| Point3::new(4.0 * x, 4.0 * y, 0.1 * x * x - 0.1)).collect()
    };
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let net = (0..3).map(row).collect();
    let surface = NurbsSurface::new([2, 2], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

struct Job {
    kinematics: Kinematics,
    face: Face,
    cutter: Cutter,
    /// Axes where the tool is 6 mm below the middle of the face, upright.
    low: AxisVector,
}

impl Job {
    fn new() -> Self {
        let kinematics = Kinematics::new(&machine(), &shop::setup(Layout::TableTable));
        let (major, minor, length) = (0.0, RADIUS, 120.0);
        let spec = CutterSpec { length, ..CutterSpec::of_radii(major, minor) };
        let pose = ToolPose { tip: Point3::new(0.0, 0.0, -6.0), axis: Vector3::z_axis() };
        let inverse = Inverse::new(&kinematics).unwrap();
        let low = inverse.near(&pose, &kinematics.machine().home()).unwrap();
        Self { kinematics, face: face(), cutter: Cutter::new(spec).unwrap(), low }
    }

    /// A program of machine coordinates: where it goes from the low place \[mm, rad\], each in a rapid move or not.
    fn check(&self, stops: &[(bool, [f64; 5])]) -> Report {
        self.check_with(stops, &OPTIONS)
    }

    fn check_with(&self, stops: &[(bool, [f64; 5])], options: &CheckOptions) -> Report {
        let words = AxisWords::of(self.kinematics.machine()).unwrap();
        let mut text = "G21 G90 G17 G54 G94 F3000\n".to_owned();
        for &(rapid, by) in stops {
            let q = self.low + AxisVector::from(by);
            let code = if rapid { "G53 G0" } else { "G53 G1" };
            let values = (0..5).map(|slot| {
                let word = words.0[slot];
                format!(" {}{:.9}", word.letter, word.written(q[slot]))
            });
            text.extend([code, &values.collect::<String>(), "\n"]);
        }
        text += "M2\n";
        let program = read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, words, 5)).unwrap();
        let (believed, real, cutter) = (&self.kinematics, &self.kinematics, &self.cutter);
        let (faces, tables) = (std::slice::from_ref(&self.face), verify::Tables::NONE);
        let input = CheckInput::program(&program, believed, cutter)
            .machine(real)
            .faces(faces)
            .tables(tables);
        verify::check(&input, options, &Silent).unwrap()
    }

    /// How deep a rapid move gouges at the samples, by many poses: all axes together, and each at its own speed.
    fn depths(&self, from: [f64; 5], to: [f64; 5], report: &Report) -> [f64; 2] {
        const STEPS: u32 = 8_000;
        let machine = self.kinematics.machine();
        let speeds = machine.vector(|axis| axis.rapid);
        let [from, change] = [from, [0, 1, 2, 3, 4].map(|k| to[k] - from[k])].map(AxisVector::from);
        let whole = change.abs().component_div(&speeds).amax();
        let mut worst = [0.0_f64; 2];
        for step in 0..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let run = (speeds * whole * share).zip_map(&change, |far, by| far.min(by.abs()));
            let own = run.component_mul(&change.map(f64::signum));
            for (worst, by) in worst.iter_mut().zip([change * share, own]) {
                let pose = self.kinematics.forward(&(self.low + from + by));
                let centre = pose.tip + pose.axis.into_inner() * RADIUS;
                for sample in report.maps[0].samples.iter().flatten() {
                    *worst = worst.max(self.depth(sample.uv.into(), centre));
                }
            }
        }
        worst
    }

    /// How deep a ball about `centre` is in the face at a point, along its normal.
    fn depth(&self, [u, v]: [f64; 2], centre: Point3<f64>) -> f64 {
        let normal = self.face.normal(u, v).unwrap().into_inner();
        let to = centre - self.face.point(u, v);
        let (along, aside) = (to.dot(&normal), to.norm_squared() - to.dot(&normal).powi(2));
        let half = (RADIUS * RADIUS - aside).max(0.0).sqrt();
        // The tool counts where it comes out above.
        if along + half >= 0.0 { half - along } else { 0.0 }
    }
}

fn gouge(report: &Report) -> Option<ExtremeHeight> {
    report.findings.iter().find_map(|finding| match finding {
        Finding::Gouge(worst) => Some(*worst),
        _ => None,
    })
}

const BESIDE: [f64; 5] = [-15.0, 0.0, 2.5, 0.0, 0.0];
const ABOVE: [f64; 5] = [0.0, 0.0, 20.0, 0.0, 0.0];

#[test]
fn a_rapid_that_is_clear_if_all_axes_arrive_together_gouges_if_they_do_not() {
    let job = Job::new();
    let high = [-15.0, 0.0, 40.0, 0.0, 0.0];
    let report = job.check(&[(false, high), (false, BESIDE), (true, ABOVE)]);
    let [together, own] = job.depths(BESIDE, ABOVE, &report);
    assert!(together == 0.0 && own > 1.0 && own < OPTIONS.reach, "{together} {own}");
    let found = gouge(&report).unwrap();
    assert!(found.dog_leg && found.line == 4 && !found.or_deeper, "{found:?}");
    assert!((-found.height - own).abs() < 1e-3, "{} {own}", found.height);
    assert!(found.to_string().contains("line 4 if its axes run each at its own speed"), "{found}");
    let bounds = report.deviation.bounds.unwrap();
    // A tenth of what a broken tolerance is exceeded by is margin.
    assert!(bounds.gouge >= own && bounds.gouge < 1.11 * own, "{bounds:?} {own}");
    assert!(bounds.open == 0.0);
    // What such a rapid cuts is not counted on: what else is left stays reported.
    assert!(report.findings.iter().any(|finding| matches!(finding, Finding::Uncut { .. })));
}

/// Rotary axes arrive at their own times, too.
#[test]
fn the_deeper_of_both_ways_is_reported() {
    let job = Job::new();
    let high = [-15.0, 3.0, 40.0, 0.1, 0.3];
    for (from, to) in [
        ([-9.0, 1.0, 8.0, 0.0, 0.2], [9.0, -2.0, 3.0, 0.3, -0.1]),
        ([-3.0, 8.0, 6.5, 0.1, 0.0], [5.0, -9.0, 3.5, 0.0, 0.1]),
    ] {
        let report = job.check(&[(false, high), (false, from), (true, to)]);
        let [together, own] = job.depths(from, to, &report);
        let worst = together.max(own);
        assert!(worst > 0.01 && worst < OPTIONS.reach, "{together} {own}");
        let found = gouge(&report).unwrap();
        assert!((-found.height - worst).abs() < 2e-3, "{found:?} {together} {own}");
        assert_eq!(found.dog_leg, own > together, "{found:?} {together} {own}");
    }
}

/// What a rapid move cuts is not counted on: where no feed move gets as low, it is reported by its line.
#[test]
fn a_face_that_a_rapid_finishes_is_reported() {
    let job = Job::new();
    let away = |x: f64, y: f64, z: f64| [x, y, z, 0.0, 0.0];
    let rows = |rapid: usize| {
        let row = |k: usize| {
            let y = k as f64 - 5.0;
            let x = if k.is_multiple_of(2) { 8.0 } else { -8.0 };
            [(false, away(-x, y, 6.0)), (k == rapid, away(x, y, 6.0))]
        };
        let mut stops = vec![(false, away(-8.0, -5.0, 40.0))];
        stops.extend((0..11).flat_map(row));
        stops
    };
    // The face lies up to 0.05 mm lower, and rows 1 mm apart leave 0.025 mm more, those 2 mm apart 0.1 mm.
    let options = CheckOptions { total: 0.12, ..OPTIONS };
    let findings = |rapid: usize| job.check_with(&rows(rapid), &options).findings;
    assert_eq!(findings(usize::MAX), []);
    let found = findings(5);
    // The row in the middle: two stops a row, behind the header and the way down.
    assert!(found.contains(&Finding::Rapid { line: 2 + 2 * 6 }), "{found:?}");
    assert!(!found.iter().any(|finding| matches!(finding, Finding::Gouge(_))), "{found:?}");
}

/// One axis alone, or a feed move, has one way only.
#[test]
fn what_is_no_rapid_of_several_axes_is_run_once() {
    let job = Job::new();
    let up = [-15.0, 0.0, 40.0, 0.0, 0.0];
    for stops in [
        [(false, BESIDE), (false, ABOVE)],
        [(true, [-15.0, 0.0, 6.1, 0.0, 0.0]), (true, [15.0, 0.0, 6.1, 0.0, 0.0])],
    ] {
        let report = job.check(&[&[(false, up)][..], &stops].concat());
        assert_eq!(gouge(&report), None);
    }
}
