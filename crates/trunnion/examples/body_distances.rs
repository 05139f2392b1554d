//! Least distances between the bodies of a machine over a long program: 20 bodies of 10 000 triangles, 10^5 moves.
//!
//! ```text
//! cargo run --release -p trunnion --example body_distances [MOVES] [CLEARANCE_MM]
//! ```
//!
//! The machine is `bc-trunnion` with castings, covers and clamps of our own making, all of them finely meshed and rippled by
//! a tenth of a millimetre, so that no body is a box in disguise. One program is a finishing path over a dome with all axes
//! moving; the other jumps over the travel.

#![expect(clippy::print_stdout, reason = "the example prints its figures")]

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::time::Instant;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine::{built_in, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{BodyShape, Kinematics, Machine, MachineBody, Setup};
use trunnion::nalgebra::{Isometry3, Point3, Vector3};
use trunnion::nc::read::{self, Dialect, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::types::{AxisVector, Mesh, Silent, ToolPose};
use trunnion::verify::{
    CheckInput, CheckOptions, ClearanceOptions, DeviationTolerance, Inspection, MachineBodies,
};

type Failure = Box<dyn std::error::Error>;

/// Quads along each edge of a box: 12 n^2 triangles.
const ALONG: u32 = 29;

/// Heights and turns of a round body: 2 n m triangles.
const ROUND: [u32; 2] = [50, 100];

/// Height of the ripples \[mm\].
const RIPPLE: f64 = 0.1;

/// Bodies: name, link, corners of a box.
const BOXES: [(&str, &str, [[f64; 3]; 2]); 15] = [
    ("cradle", "B", [[-521.0, -384.0, -640.0], [-241.0, -124.0, -590.0]]),
    ("front arm", "B", [[-431.0, -454.0, -640.0], [-331.0, -394.0, -495.0]]),
    ("rear arm", "B", [[-431.0, -114.0, -640.0], [-331.0, -54.0, -495.0]]),
    ("motor of C", "B", [[-441.0, -314.0, -760.0], [-321.0, -194.0, -641.0]]),
    ("front support", "b", [[-461.0, -530.0, -900.0], [-301.0, -464.0, -480.0]]),
    ("rear support", "b", [[-461.0, -44.0, -900.0], [-301.0, 22.0, -480.0]]),
    ("bed", "b", [[-900.0, -700.0, -1000.0], [140.0, 400.0, -902.0]]),
    ("left cover", "b", [[-1250.0, -700.0, -900.0], [-1230.0, 400.0, 300.0]]),
    ("right cover", "b", [[380.0, -700.0, -900.0], [400.0, 400.0, 300.0]]),
    ("door", "b", [[-1200.0, -1240.0, -900.0], [380.0, -1220.0, 300.0]]),
    ("magazine", "b", [[200.0, 640.0, -200.0], [370.0, 900.0, 200.0]]),
    ("ram", "Y", [[-140.0, 205.0, 0.0], [140.0, 900.0, 900.0]]),
    ("head", "Z", [[-110.0, -110.0, 120.5], [110.0, 200.0, 600.0]]),
    ("nozzle", "Z", [[52.0, -8.0, -20.0], [68.0, 8.0, 118.0]]),
    ("clamp", "C", [[-491.0, -264.0, -559.5], [-461.0, -244.0, -520.0]]),
];

/// Round bodies along z: name, link, base, radius, height.
const CYLINDERS: [(&str, &str, [f64; 3], [f64; 2]); 5] = [
    ("table", "C", [-381.0, -254.0, -585.0], [125.0, 25.0]),
    ("chuck", "C", [-381.0, -254.0, -559.5], [60.0, 35.0]),
    ("spindle", "Z", [0.0, 0.0, 0.0], [50.0, 120.0]),
    ("spindle motor", "Z", [0.0, 40.0, 600.5], [90.0, 200.0]),
    ("hose reel", "Y", [0.0, 550.0, 900.5], [120.0, 150.0]),
];

fn main() -> Result<(), Failure> {
    let mut words = std::env::args().skip(1);
    let moves = words.next().map_or(Ok(100_000), |word| word.parse())?;
    let clearance = words.next().map_or(Ok(2.0), |word| word.parse())?;
    let mut machine = parse(built_in("bc-trunnion").map_err(|_| "no such machine")?)?.machine;
    machine.bodies = BOXES.iter().map(rippled_box).chain(CYLINDERS.iter().map(turned)).collect();
    let start = Instant::now();
    let bodies = MachineBodies::new(&machine, 0.01)?.ok_or("the machine has no bodies")?;
    let triangles: usize = machine.bodies.iter().map(triangles).sum();
    println!(
        "{} bodies, {triangles} triangles, {} pairs without the tool; prepared in {:.1} s",
        machine.bodies.len(),
        bodies.pairs(),
        start.elapsed().as_secs_f64()
    );
    for meeting in bodies.left_out() {
        println!("  left out: {}, {}", meeting.bodies.join(" and "), meeting.why);
    }
    measure("finishing a dome", &machine, &bodies, &finishing(&machine, moves)?, clearance)?;
    measure("jumps over the travel", &machine, &bodies, &jumps(&machine, moves), clearance)?;
    Ok(())
}

/// Times the check of a program with bodies, and without.
fn measure(
    name: &str,
    machine: &Machine,
    bodies: &MachineBodies,
    positions: &[AxisVector],
    clearance: f64,
) -> Result<(), Failure> {
    let kinematics = Kinematics::new(machine, &setup());
    let words = AxisWords::of(machine)?;
    let text = program(&words, positions);
    let program = read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, words, 20))?;
    let cutter = Cutter::new(CutterSpec { length: 120.0, ..CutterSpec::ball(10.0) })?;
    let input = CheckInput::program(&program, &kinematics, &cutter);
    let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
    let inspection = Inspection::new(input, CheckOptions::of_tolerance(tolerance, 0.5));
    let start = Instant::now();
    inspection.run(&Silent)?;
    let without = start.elapsed().as_secs_f64();
    let watch = ClearanceOptions { clearance, ..ClearanceOptions::within(0.01) };
    let start = Instant::now();
    let found = inspection.bodies(bodies, &watch).run(&Silent)?;
    let seconds = start.elapsed().as_secs_f64() - without;
    let report = found.bodies.ok_or("no bodies were compared")?;
    println!("{name}: {} moves, {} pairs, {seconds:.1} s", positions.len() - 1, report.pairs);
    let lines = |count: Option<usize>| count.unwrap_or(0);
    println!(
        "  {} lines below {clearance} mm, {} that touch",
        lines(report.lines.map(|count| count.count)),
        lines(report.hits.map(|count| count.count))
    );
    if let Some(least) = report.least {
        println!(
            "  least {:.3} mm between {}, line {}",
            least.distance,
            least.bodies.join(" and "),
            least.line
        );
    }
    Ok(())
}

fn setup() -> Setup {
    Setup::new(Vector3::new(-381.0, -254.0, -520.0), [0.0; 3], 120.0)
}

fn triangles(body: &MachineBody) -> usize {
    match &body.shape {
        BodyShape::Mesh { mesh, .. } => mesh.triangles.len(),
        _ => 0,
    }
}

fn program(words: &AxisWords, positions: &[AxisVector]) -> String {
    let mut text = String::from("G21 G90 G17 G54 G94 F3000\n");
    for q in positions {
        text.push_str("G53 G1");
        for (word, value) in words.0.iter().zip(q.iter()) {
            // Writing to a string cannot fail.
            let _ = write!(text, " {}{:.6}", word.letter, word.written(*value));
        }
        text.push('\n');
    }
    text + "M2\n"
}

/// Moves of a pass over the dome.
const PASS: usize = 500;

/// Returns zigzag passes over a dome of 80 mm, the tool tilted with its normal.
fn finishing(machine: &Machine, moves: usize) -> Result<Vec<AxisVector>, Failure> {
    let inverse = Inverse::new(&Kinematics::new(machine, &setup()))?;
    let mut positions = vec![machine.home()];
    let mut near = machine.home();
    for index in 0..moves {
        let share = (index % PASS) as f64 / PASS as f64;
        let share = if (index / PASS).is_multiple_of(2) { share } else { 1.0 - share };
        let pass = (index / PASS) as f64 / (moves as f64 / PASS as f64);
        let [lean, turn] = [0.1 + 0.9 * share, TAU * pass];
        let out = Vector3::new(lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos());
        let tip = Vector3::z() * -20.0 + out * 80.0;
        let pose = ToolPose::new(tip.into(), out.into()).ok_or("a direction without length")?;
        near = inverse.near_inside(&pose, &near)?;
        positions.push(near);
    }
    Ok(positions)
}

/// Returns jumps that stay off the table: each to anywhere in the upper half of the travel.
fn jumps(machine: &Machine, moves: usize) -> Vec<AxisVector> {
    let mut seed = 1_u64;
    let mut share = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut positions = vec![machine.home()];
    for _ in 0..moves {
        let [x, y, z, c, b] = [share(), share(), share(), share(), share()];
        positions.push(AxisVector::from([
            -762.0 * x,
            -508.0 * y,
            -150.0 * z,
            TAU * (c - 0.5),
            (-30.0 + 120.0 * b).to_radians(),
        ]));
    }
    positions
}

fn body(name: &str, link: &str, mesh: Mesh) -> MachineBody {
    let shape = BodyShape::Mesh { mesh: mesh.into(), place: Isometry3::identity(), allowance: 0.0 };
    MachineBody { name: name.to_owned(), link: link.to_owned(), shape, touches: Vec::new() }
}

/// Returns a point moved by the ripples, the same for the same point.
fn rippled(p: Point3<f64>, inwards: Vector3<f64>) -> Point3<f64> {
    let wave = (0.31 * p.x).sin() * (0.27 * p.y).cos() + (0.23 * p.z + 0.1 * p.x).sin();
    p + inwards * (RIPPLE * (1.0 + 0.5 * wave))
}

/// Returns a box of quads, rippled inwards.
fn rippled_box((name, link, [low, high]): &(&str, &str, [[f64; 3]; 2])) -> MachineBody {
    let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    let (low, high) = (Point3::from(*low), Point3::from(*high));
    let mut corner = |at: [u32; 3], mesh: &mut Mesh| {
        *numbers.entry(at).or_insert_with(|| {
            let share = Vector3::from(at).map(|k| f64::from(k) / f64::from(ALONG));
            let point = low + (high - low).component_mul(&share);
            mesh.vertices.push(rippled(point, share.map(|s| 1.0 - 2.0 * s)));
            u32::try_from(mesh.vertices.len() - 1).unwrap_or_default()
        })
    };
    for axis in 0..3 {
        for top in [false, true] {
            for i in 0..ALONG {
                for j in 0..ALONG {
                    let mut at = |i: u32, j: u32| {
                        let mut index = [0; 3];
                        index[axis] = if top { ALONG } else { 0 };
                        index[(axis + 1) % 3] = i;
                        index[(axis + 2) % 3] = j;
                        corner(index, &mut mesh)
                    };
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let both = if top { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    mesh.triangles.extend(both);
                }
            }
        }
    }
    body(name, link, mesh)
}

/// Returns a round body with flat ends, rippled.
fn turned((name, link, base, [radius, height]): &(&str, &str, [f64; 3], [f64; 2])) -> MachineBody {
    let [rows, turns] = ROUND;
    let base = Point3::from(*base);
    let mut vertices = vec![base, base + Vector3::z() * *height];
    // Rows go from the middle of the lower end over the flank to that of the upper end.
    let third = f64::from(rows) / 3.0;
    for row in 1..rows {
        let at = f64::from(row) / third;
        let [out, up] = match at {
            at if at < 1.0 => [at, 0.0],
            at if at < 2.0 => [1.0, at - 1.0],
            at => [3.0 - at, 1.0],
        };
        for turn in 0..turns {
            let (sin, cos) = (TAU * f64::from(turn) / f64::from(turns)).sin_cos();
            let p = base + Vector3::new(radius * out * cos, radius * out * sin, height * up);
            let bow = RIPPLE * out * (PI * up).sin();
            vertices.push(rippled(p, Vector3::new(-bow * cos, -bow * sin, 0.0)));
        }
    }
    let at = |row: u32, turn: u32| 2 + (row - 1) * turns + turn % turns;
    let mut triangles = Vec::new();
    for turn in 0..turns {
        triangles.push([0, at(1, turn + 1), at(1, turn)]);
        triangles.push([1, at(rows - 1, turn), at(rows - 1, turn + 1)]);
        for row in 1..rows - 1 {
            let [a, b] = [at(row, turn), at(row, turn + 1)];
            let [c, d] = [at(row + 1, turn), at(row + 1, turn + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    body(name, link, Mesh { vertices, triangles })
}
