//! A conical barrel beside a ball of the same diameter at the same tolerance, on three faces.
//!
//! Across the feed a strip is as wide as `sqrt(8 e / (1 / R - k))`: `e` the band, `R` the radius of the arc, `k` the
//! curvature of the face towards the tool. So an arc of 85 mm needs faces whose hollows have more than that across the
//! feed. The saddle has, the first of the bumpy faces has not: its barrel is the largest that fits. The second is as
//! bumpy as an arc of 85 mm allows.
//!
//! Programs are checked by the engine's own check: excess and gouges at points, and proven bounds between them.
//!
//! ```text
//! cargo run --release --example barrel_and_ball
//! ```

#![expect(clippy::print_stdout, reason = "the figures are what it is for")]

use nalgebra::{DMatrix, Point3};
use std::error::Error;
use std::f64::consts::TAU;
use trunnion::files::{job, machine};
use trunnion::pipeline::{Job, Outcome, run};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::Silent;

/// Sides of the faces along x and y \[mm\]: those of `fixtures/corpus/generate.py`.
const SIZE: [f64; 2] = [60.0, 40.0];

/// Points that a face is laid through, along either side.
const POINTS: usize = 9;

/// Diameter of all cutters \[mm\].
const DIAMETER: f64 = 8.0;

/// Height of a face over the shares of its sides \[mm\].
type Height = fn(f64, f64) -> f64;

/// Face, with the barrel that fits it.
struct Case {
    name: &'static str,
    height: Height,
    /// Radius of the large arc \[mm\].
    barrel: f64,
    /// Feed direction of the job.
    along: &'static str,
}

fn bumps(s: f64, t: f64, rise: f64) -> f64 {
    12.0 + rise * (TAU * s).sin() * (TAU * t).cos()
}

const CASES: [Case; 3] = [
    Case {
        name: "saddle",
        height: |s, t| 15.0 + 14.0 * ((s - 0.5).powi(2) - (t - 0.5).powi(2)),
        barrel: 85.0,
        along: "v",
    },
    Case { name: "bumpy", height: |s, t| bumps(s, t, 2.5), barrel: 30.0, along: "v" },
    Case { name: "gently bumpy", height: |s, t| bumps(s, t, 0.9), barrel: 85.0, along: "v" },
];

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:<14}{:>7}  {:<24}{:>8}{:>11}{:>9}{:>12}{:>12}",
        "face", "hollow", "cutter", "passes", "length", "time", "excess", "gouge"
    );
    for case in &CASES {
        let face = face(case.height)?;
        let ball = format!("kind = \"ball\"\ndiameter = {DIAMETER}");
        let barrel = format!(
            "kind = \"conical-barrel\"\ntip_radius = 1\nbarrel_radius = {}\ntaper_angle = 20\ndiameter = {DIAMETER}",
            case.barrel
        );
        let hollow = FaceIndex::new(face.clone())?.smallest_concave_radius();
        let ball = planned(case, &face, &ball)?;
        println!("{:<14}{hollow:>7.1}  {}", case.name, row("ball", &ball));
        let name = format!("barrel of {} mm", case.barrel);
        let barrel = planned(case, &face, &barrel)?;
        println!("{:<21}  {}", "", row(&name, &barrel));
        let less = |of: fn(&Outcome) -> f64| 100.0 * (1.0 - of(&barrel) / of(&ball));
        let (length, time) = (less(length), less(time));
        println!("{:<21}  {:<32}{length:>9.0} %{time:>7.0} %", "", "less");
    }
    Ok(())
}

fn length(outcome: &Outcome) -> f64 {
    outcome.summary.cover.cutting_length
}

fn time(outcome: &Outcome) -> f64 {
    outcome.summary.motion.duration
}

/// Describes a result: passes, length, time, and what was measured and is proven of excess and gouges in micrometres.
fn row(cutter: &str, outcome: &Outcome) -> String {
    let checked = outcome.summary.programs.first().and_then(|program| program.check);
    let micro = |measured: f64, bound: Option<f64>| {
        let bound = bound.map_or("none".to_owned(), |bound| format!("{:.1}", 1e3 * bound));
        format!("{:.1} <= {bound}", 1e3 * measured)
    };
    let [excess, gouge] = checked.map_or_else(
        || [String::new(), String::new()],
        |check| [micro(check.excess, check.excess_bound), micro(check.gouge, check.gouge_bound)],
    );
    let kept = if outcome.summary.passed { "" } else { "  broken" };
    format!(
        "{cutter:<24}{:>8}{:>8.0} mm{:>7.1} s{excess:>12}{gouge:>12}{kept}",
        outcome.summary.cover.passes,
        length(outcome),
        time(outcome),
    )
}

fn planned(case: &Case, face: &Face, tool: &str) -> Result<Outcome, Box<dyn Error>> {
    let text = format!(
        "schema = \"trunnion-job/1\"\nname = \"{}\"\n[part]\nfile = \"part.json\"\n[setup]\norigin = [0, 0, -545]\n\
         clearance = 10\n[tool]\nnumber = 1\n{tool}\nlength = 120\n[tolerance]\ntotal = 0.02\ngouge = 0.002\n[strategy]\n\
         along = \"{}\"\n[cutting]\nfeed = 3000\nspindle = 8000\n[machine]\nfile = \"machine.toml\"\n[output]\n\
         dialects = [\"linuxcnc\"]\n",
        case.name, case.along
    );
    let machine = machine::parse(include_str!("../../../machines/ac-trunnion.toml"))?.machine;
    let job = Job::new(job::parse(&text)?, std::slice::from_ref(face), &machine)?;
    Ok(run(&job, &Silent)?)
}

/// Lays a bicubic face through [`POINTS`] by [`POINTS`] heights, as the corpus does.
fn face(height: Height) -> Result<Face, Box<dyn Error>> {
    let share = |i: usize| i as f64 / (POINTS - 1) as f64;
    let heights = DMatrix::from_fn(POINTS, POINTS, |i, j| height(share(i), share(j)));
    let knots = knots();
    // Splines through the heights: B Z B^T = H, and positions likewise.
    let basis = DMatrix::from_fn(POINTS, POINTS, |i, j| basis(&knots, j, 3, share(i)));
    let inverse = basis.try_inverse().ok_or("the points lie on the knots")?;
    let control = &inverse * heights * inverse.transpose();
    let along = |k: usize| {
        let positions = DMatrix::from_fn(POINTS, 1, |i, _| SIZE[k] * (share(i) - 0.5));
        &inverse * positions
    };
    let [x, y] = [along(0), along(1)];
    let point = |i: usize, j: usize| Point3::new(x[i], y[j], control[(i, j)]);
    let points = (0..POINTS).map(|i| (0..POINTS).map(|j| point(i, j)).collect()).collect();
    let surface = NurbsSurface::new([3, 3], [knots.clone(), knots], points, None)?;
    Ok(Face::new(1, Surface::Nurbs(surface), Vec::new())?)
}

/// Clamped cubic knots, without knots at the points next to the ends.
fn knots() -> Vec<f64> {
    let inner = (2..POINTS - 2).map(|i| i as f64 / (POINTS - 1) as f64);
    [0.0; 4].into_iter().chain(inner).chain([1.0; 4]).collect()
}

/// Basis function by Cox and de Boor.
fn basis(knots: &[f64], j: usize, degree: usize, at: f64) -> f64 {
    if degree == 0 {
        // The last interval holds its end.
        let last = at >= 1.0 && knots[j + 1] >= 1.0 && knots[j] < 1.0;
        return f64::from(u8::from((knots[j] <= at && at < knots[j + 1]) || last));
    }
    let part =
        |from: f64, to: f64, other: f64| if to > from { (at - other) / (to - from) } else { 0.0 };
    let rising = part(knots[j], knots[j + degree], knots[j]);
    let falling = -part(knots[j + 1], knots[j + degree + 1], knots[j + degree + 1]);
    rising * basis(knots, j, degree - 1, at) + falling * basis(knots, j + 1, degree - 1, at)
}
