//! A program of arcs, round a cylinder: it is run as it is written, and faults planted in it are reported at their line.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;

use nalgebra::{Point3, Vector3};
use shop::Layout;
use std::f64::consts::PI;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions};
use trunnion::surface::{CylinderSurface, Face, Surface, SurfaceFrame, TrimCurve, TrimLoop};
use trunnion::types::Silent;
use trunnion::verify::{
    self, CheckInput, CheckOptions, DeviationTolerance, Finding, Report, Track, VerifyError,
};

/// Of the part, and of the tool \[mm\].
const RADII: [f64; 2] = [30.0, 5.0];

const OPTIONS: CheckOptions = CheckOptions {
    reach: 1.0,
    ray_tolerance: 1e-4,
    most_points: 100_000,
    bounds: None,
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 2e-3, gouge: 1e-3 }, 1.0)
};

/// Lines of the program, which is right as it stands.
const LINES: [&str; 9] = [
    "G21 G90 G17 G94 G54",
    "G43 H1",
    "G0 X60. Y0.",
    "G0 Z-10.",
    "G1 X35. F3000.",
    "G2 X-35. I-35. J0.",
    "G2 X35. I35. J0.",
    "G1 X60.",
    "M2",
];

/// The program with other lines, counted from 1.
fn with(lines: &[(usize, &str)]) -> String {
    let mut text = LINES.map(str::to_owned);
    for (number, line) in lines {
        (*line).clone_into(&mut text[number - 1]);
    }
    text.join("\n")
}

fn face() -> Face {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let surface = Surface::Cylinder(CylinderSurface::new(frame, RADII[0]).unwrap());
    let corners = [[0.05, -8.0], [6.2, -8.0], [6.2, -2.0], [0.05, -2.0], [0.05, -8.0]];
    let curve = TrimCurve::polyline(&corners).unwrap();
    Face::new(1, surface, vec![TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap()]).unwrap()
}

fn run<T>(text: &str, work: impl Fn(&CheckInput<'_>) -> T) -> T {
    let machine = shop::machine(Layout::TableTable);
    let words = AxisWords::of(&machine).unwrap();
    let program = read::read(text, &ReadOptions::new(Dialect::LinuxCnc, words, 5)).unwrap();
    let setup = Setup::new(Vector3::new(-381.0, -254.0, -500.0), [0.0; 3], 60.0);
    let kinematics = Kinematics::new(&machine, &setup);
    let spec = CutterSpec { length: 60.0, ..CutterSpec::of_radii(RADII[1], 0.0) };
    let cutter = Cutter::new(spec).unwrap();
    let (believed, real) = (&kinematics, &kinematics);
    let faces = &[face()];
    work(&CheckInput::program(&program, believed, &cutter).machine(real).faces(faces))
}

fn check(text: &str) -> Report {
    run(text, |input| verify::check(input, &OPTIONS, &Silent)).unwrap()
}

/// The feed moves.
fn cut(text: &str) -> Vec<Track> {
    let tracks = run(text, |input| verify::track(input, 1e-3)).unwrap();
    tracks.into_iter().filter(|track| !track.rapid).collect()
}

#[test]
fn the_contour_is_finished_and_its_axes_are_audited_as_one_block_each() {
    let report = check(&with(&[]));
    assert!(report.passed(), "{:?}", report.findings);
    let [low, high] =
        [report.deviation.lowest, report.deviation.highest].map(|of| of.unwrap().height);
    assert!(low > -1e-4 && high < 2e-4, "{low} {high}");
    let audit = report.audit.unwrap();
    assert_eq!((audit.moves, audit.brief), (6, None));
    // v² / r: X and Y in turn carry all of it.
    let radius = RADII[0] + RADII[1];
    let expected = 50f64.powi(2) / radius / 2500.0;
    let raw = audit.axes[1].acceleration.raw;
    assert!((raw / expected - 1.0).abs() < 1e-3, "{raw} {expected}");
    let time = (2.0 * PI * radius + 50.0) / 50.0;
    let feed = audit.duration - audit.rapid;
    assert!((feed - time).abs() < 1e-5, "{feed} {time}");
}

/// Planes, senses, helices and turns: the formulas of a circle, by hand.
#[test]
fn arcs_run_in_their_plane_and_sense() {
    let quarter = |head: &str, arc: &str| {
        let text = format!("G21 G90 G94 G54\nG43 H1\n{head}\n{arc}\nM2");
        let poses = cut(&text).remove(0).poses;
        let [first, last] = [poses[0], poses[poses.len() - 1]];
        let middle = 0.5 * (first.time + last.time);
        let half = poses.iter().find(|at| at.time >= middle).unwrap();
        ([first, *half, last].map(|at| at.pose.tip), last.time - first.time)
    };
    let near = |a: Point3<f64>, b: [f64; 3]| (a - Point3::from(b)).norm() < 2e-3;
    let side = 10.0 * 0.5f64.sqrt();
    let ([from, half, to], time) = quarter("G17 G0 X10 Y0 Z5", "G3 X0 Y10 Z3 I-10 J0 F600");
    assert!(near(from, [10.0, 0.0, 5.0]) && near(to, [0.0, 10.0, 3.0]), "{from} {to}");
    assert!(near(half, [side, side, 4.0]), "{half}");
    assert!((time - (5.0 * PI).hypot(2.0) / 10.0).abs() < 1e-4, "{time}");
    let ([_, half, _], _) = quarter("G18 G0 X10 Y0 Z0", "G2 X0 Z10 I-10 K0 F600");
    assert!(near(half, [side, 0.0, side]), "{half}");
    let ([_, half, _], _) = quarter("G19 G0 X1 Y10 Z0", "G3 Y0 Z10 J-10 K0 F600");
    assert!(near(half, [1.0, side, side]), "{half}");
    // Three quarters the other way round, and a whole turn.
    let ([_, half, _], _) = quarter("G17 G0 X10 Y0 Z0", "G2 X0 Y10 I-10 J0 F600");
    assert!(near(half, [-side, -side, 0.0]), "{half}");
    let ([_, half, to], _) = quarter("G17 G0 X10 Y0 Z0", "G2 X10 Y0 I-10 J0 F600");
    assert!(near(half, [-10.0, 0.0, 0.0]) && near(to, [10.0, 0.0, 0.0]), "{half} {to}");
}

#[test]
fn faults_planted_in_arcs_are_reported() {
    let gouge = |text: &str| {
        check(text).findings.into_iter().find_map(|finding| match finding {
            Finding::Gouge(worst) => Some(worst.line),
            _ => None,
        })
    };
    // An arc in the wrong plane runs through the part.
    let wrong = with(&[(6, "G18 G2 X-35. I-35. K0."), (7, "G17 G2 X35. I35. J0.")]);
    assert_eq!(gouge(&wrong), Some(6));
    // A radius for an arc that is two tenths too small.
    let wrong = with(&[(6, "G2 X-34.8 I-34.9 J0."), (7, "G2 X34.8 I34.8 J0.")]);
    assert!(matches!(gouge(&wrong), Some(6 | 7)));
    // The wrong way round: one half is cut twice, the other never.
    let report = check(&with(&[(6, "G3 X-35. I-35. J0.")]));
    let uncut = report.findings.iter().any(|finding| {
        matches!(finding, Finding::Uncut { area, .. } if *area > 0.4 * PI * RADII[0] * 6.0)
    });
    assert!(uncut, "{:?}", report.findings);
    // G91 left on: no arc fits any more.
    let machine = shop::machine(Layout::TableTable);
    let options = ReadOptions::new(Dialect::LinuxCnc, AxisWords::of(&machine).unwrap(), 5);
    let faults = read::read(&with(&[(5, "G91 G1 X-25. F3000.")]), &options).unwrap_err();
    assert_eq!(faults[0].line, 6);
    // G91 left on where moves are straight: they lie elsewhere.
    let report = check(&with(&[(3, "G91 G0 X60. Y0."), (4, "Z-10."), (5, "G90 G1 X35. F3000.")]));
    assert!(!report.passed());
    // A chord for an arc.
    assert_eq!(gouge(&with(&[(6, "G1 X-35.")])), Some(6));
    // Another work offset than the one that is known.
    let wrong = with(&[(1, "G21 G90 G17 G94 G55")]);
    let error = run(&wrong, |input| verify::check(input, &OPTIONS, &Silent)).unwrap_err();
    assert!(matches!(error, VerifyError::WorkOffset { number: 1, .. }), "{error}");
    // Feed in inches: 25.4 times as quick.
    let report = check(&with(&[(5, "G1 X35. F76200.")]));
    let quick =
        |finding: &Finding| matches!(finding, Finding::Velocity { worst, .. } if worst.raw > 2.0);
    assert!(report.findings.iter().any(quick), "{:?}", report.findings);
}
