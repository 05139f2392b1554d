//! Passes over a small face, with the proof that they finish it and gouge nowhere; and what passes over the
//! whole patch of paper 004 come to.
//!
//! The small face is the 36 x 30 mm patch of `tests/cover.rs`, hollow across and waved along. The figures are
//! printed before the benches, all from one run: lengths of cutting, strips not held back by the turn of the
//! axis, and planned times on four machines, links included, against a ball of the same radius at the same
//! tolerance. Some minutes; `TRUNNION_FIGURES=0` leaves them out.

#![expect(clippy::unwrap_used, reason = "a bench stops on surprise")]
#![expect(clippy::print_stdout, reason = "it prints figures")]

use divan::{Bencher, black_box};
use nalgebra::Point3;
use std::f64::consts::FRAC_PI_6;
use std::path::{Path, PathBuf};
use trunnion::cover::{
    CoverOptions, CoverRequest, Covering, FeedDirection, FinishTolerance, PlacementMethod, cover,
};
use trunnion::cutter::{Cutter, CutterKind, CutterSpec};
use trunnion::pipeline::{Job, run};
use trunnion::positioning::{ToleranceBand, ToolInclination};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::{Interval, Silent};

fn main() {
    if std::env::var("TRUNNION_FIGURES").as_deref() != Ok("0") {
        lengths();
        times();
    }
    divan::main();
}

/// The patch of paper 004, 120 x 120 mm.
fn patch() -> FaceIndex {
    let bytes = std::fs::read(root().join("fixtures/bezier-patch/patch.json")).unwrap();
    let surface = trunnion::import::surface_json::read(&bytes).unwrap();
    FaceIndex::new(Face::new(1, surface, Vec::new()).unwrap()).unwrap()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn cutter(kind: CutterKind, [major, minor]: [f64; 2], length: f64) -> Cutter {
    Cutter::new(CutterSpec { kind, length, ..CutterSpec::of_radii(major, minor) }).unwrap()
}

/// Length of cutting over the whole patch within [0, 0.01] mm; 3000 mm at most. The share of the curves is
/// taken from the band, so that all of the curve keeps 0.01 mm.
fn lengths() {
    const SHARE: f64 = 0.0005;
    let run = |name: &str, cutter: &Cutter, along: FeedDirection| {
        let radius = cutter.radius();
        let options = CoverOptions {
            feed_direction: along,
            band: ToleranceBand { lower: 0.0, upper: 0.01 - SHARE },
            link: 80.0,
            path_share: SHARE,
            spacing: Interval::new(0.003 * radius, 0.125 * radius),
            max_axis_turn: 10.0,
            offset_range: Interval::new(-FRAC_PI_6, FRAC_PI_6),
            lean: ToolInclination { angle: 0.087, towards: None },
            ..CoverOptions::finishing(cutter, FinishTolerance { excess: 0.01, gouge: 0.0 })
        };
        let Covering { passes, report, .. } =
            cover(&CoverRequest::new(&[patch()], cutter, &options), &Silent).unwrap();
        assert!(report.rest.is_empty());
        println!("  {name:<24} {:>3} passes {:>7.0} mm", passes.len(), report.length);
        report.length
    };
    println!(
        "length of cutting, whole patch within 0.01 mm, axis turn free (paper's style 5062 mm):"
    );
    let ball = run("ball r 16", &cutter(CutterKind::Ball, [0.0, 16.0], 120.0), FeedDirection::V);
    let bull = cutter(CutterKind::Bull, [10.0, 6.0], 120.0);
    for along in [FeedDirection::V, FeedDirection::Curvature, FeedDirection::Adaptive] {
        let length = run(&format!("R 10 r 6 along {along:?}"), &bull, along);
        println!("    ball / this {:.2}", ball / length);
    }
}

/// Planned time of the same patch on a machine, links included \[s\]; `turn` is the bound on the turn of the
/// axis \[deg/mm\].
fn time([machine, setup]: [&str; 2], tool: &str, along: &str, turn: f64) -> f64 {
    let text = format!(
        r#"schema = "trunnion-job/1"
name = "figures"
[part]
file = "patch.json"
faces = "all"
[setup]
{setup}
clearance = 30
[tool]
number = 1
length = 120
construction = "solid"
{tool}
[tolerance]
total = 0.02
gouge = 0.002
[strategy]
method = "widest"
along = "{along}"
max_axis_turn = {turn}
[cutting]
feed = 3000
reference = "contact"
spindle = 8000
coolant = true
[machine]
file = "machine.toml"
[motion]
method = "jerk"
servo_period = 0.004
[output]
dialects = ["g93"]
[verify]
grid = 1.0
"#
    );
    let file = trunnion::files::job::parse(&text).unwrap();
    let name = root().join(format!("machines/{machine}.toml"));
    let machine = trunnion::files::machine::parse(&std::fs::read_to_string(name).unwrap()).unwrap();
    let job = Job::new(file, &[patch().face().clone()], &machine.machine).unwrap();
    let outcome = run(&job, &Silent).unwrap();
    assert!(outcome.summary.passed, "{:?}", outcome.summary.failures);
    outcome.summary.motion.duration
}

/// Ours against a ball of the same radius, and against ours without the bound on axis turn.
fn times() {
    let machines = [
        ["bc-trunnion", "origin = [-381, -254, -505]\nrotation = [0, 20, 0]"],
        ["ac-trunnion", "origin = [0, 0, -540]\nrotation = [20, 0, 0]"],
        ["dmu-nutating45", "origin = [0, 0, -840]\nrotation = [20, 0, 0]"],
        ["gantry-ca-fork", "origin = [3000, 1500, -1000]\nrotation = [20, 0, 0]"],
    ];
    let ball = "kind = \"ball\"\ndiameter = 32";
    let bull = "kind = \"bull\"\nmajor_radius = 10\nminor_radius = 6";
    println!("planned time at a tolerance of 0.02 mm, 3 deg/mm, links included:");
    for machine in machines {
        let [ball, v, adaptive, free] = [
            (ball, "v", 3.0),
            (bull, "v", 3.0),
            (bull, "adaptive", 3.0),
            (bull, "adaptive", 500.0),
        ]
        .map(|(tool, along, turn)| time(machine, tool, along, turn));
        println!(
            "  {:<16} ball r 16 {ball:6.1} s, along v {v:5.1} s ({:.2}), adaptive {adaptive:5.1} s ({:.2}); axis \
             turn free {free:5.1} s: the bound costs {:+.1} %",
            machine[0],
            ball / v,
            ball / adaptive,
            100.0 * (adaptive / free - 1.0)
        );
    }
}

fn face() -> FaceIndex {
    let heights = [
        [0.0, -1.5, -1.0, 0.5],
        [-1.0, -2.5, -2.0, -0.5],
        [-1.2, -2.0, -2.2, -0.8],
        [0.4, -1.0, -1.4, 0.2],
    ];
    let points = (0..4)
        .map(|i| {
            (0..4).map(|j| Point3::new(12.0 * i as f64, 10.0 * j as f64, heights[i][j])).collect()
        })
        .collect();
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], points, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
}

/// Budget: seconds a face, so that a user waits for the machine and not for the planner.
#[divan::bench(args = [PlacementMethod::Widest, PlacementMethod::Inclined], sample_count = 5)]
fn small_face(bencher: Bencher<'_, '_>, method: PlacementMethod) {
    let cutter = Cutter::new(CutterSpec { length: 60.0, ..CutterSpec::bull(4.0, 3.0) }).unwrap();
    let options = CoverOptions {
        feed_direction: FeedDirection::V,
        method,
        band: ToleranceBand { lower: 0.0, upper: 0.02 },
        link: 80.0,
        path_share: 0.002,
        spacing: Interval::new(0.021, 0.875),
        max_axis_turn: 0.05,
        offset_range: Interval::new(-0.5, 0.5),
        lean: ToolInclination { angle: 0.087, towards: None },
        ..CoverOptions::finishing(&cutter, FinishTolerance { excess: 0.02, gouge: 0.0 })
    };
    let faces = [face()];
    bencher.bench(|| {
        cover(&CoverRequest::new(black_box(&faces), &cutter, &options), &Silent)
            .unwrap()
            .report
            .length
    });
}
