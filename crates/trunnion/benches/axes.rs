//! Tool path to axis path: 10^6 poses on one core, branch and whole turns chosen over all of them.
//!
//! `one pass` is one cut without a link, `passes` a hundred cuts joined by links, `travel ends` a
//! cut whose rotary has to unwind. Goal: 1 s for 10^6 poses. Other poses, or some rows only: `cargo
//! bench --bench axes -- 100000 "travel ends"`.

#![expect(clippy::unwrap_used, reason = "a bench stops on surprise")]
#![expect(clippy::print_stdout, reason = "the figures are what it is for")]

#[path = "../../trunnion-motion/tests/it/chains/mod.rs"]
mod chains;

use chains::{V3, curve, knots};
use nalgebra::Vector3;
use std::time::Instant;
use trunnion::axes::{AxesOptions, RetractOptions, follow};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::math::jet::Real;
use trunnion::types::{
    AxisPath, AxisVector, Motion, PieceGeometry, PoseTolerance, Silent, ToolPath, ToolPiece,
};

/// Distance of two poses along a pass \[mm\].
const STEP: f64 = 0.05;
const RUNS: usize = 3;

fn main() {
    let poses = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(1_000_000);
    // What a core does, not what a machine does.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    for machine in ["bc-trunnion", "layout-13-ca-head-head", "layout-33-ca-table-head"] {
        measure(machine, "one pass", &passes(1, poses, 0.0), None);
        measure(machine, "passes", &passes(100, poses / 100, 0.0), None);
    }
    let retract = RetractOptions {
        least: 50.0,
        approach: 20.0,
        margin: 1.0,
        price: 100.0,
        price_in_cut: 1000.0,
        ..RetractOptions::to_plane(Vector3::z_axis(), 200.0)
    };
    measure("bc-trunnion", "one pass, may retract", &passes(1, poses, 0.0), Some(retract));
    // Twenty turns about the workpiece-side rotary, which has less than one on this machine.
    let turns = 20.0 * std::f64::consts::TAU;
    measure("gantry-ca-fork", "travel ends", &passes(1, poses, turns), Some(retract));
}

/// Cuts to and fro over a wavy face, the tool leaning on a wandering side; `turns` \[rad\] about the
/// vertical on the way.
fn passes(count: u32, poses: u32, turns: f64) -> ToolPath {
    let length = STEP * f64::from(poses);
    let mut pieces: Vec<ToolPiece> = Vec::new();
    for pass in 0..count {
        let row = f64::from(pass);
        let geometry = curve(knots(0.0, length, poses), |u| {
            // To and fro over 120 mm, so that long passes stay inside travel.
            let (sin, cos) = (u * (1.0 / 60.0) + row).sin_cos();
            let (wave, _) = (u * 0.05 + row * 0.3).sin_cos();
            let lean = wave * 0.1 + 0.4;
            let side = (wave * 0.5) + u * (turns / length);
            let ([s, c], [t, d]) =
                ([lean.sin_cos().0, lean.sin_cos().1], [side.sin_cos().0, side.sin_cos().1]);
            ([cos * 60.0, sin * 60.0 + row * 0.5, wave * 5.0], [s * d, s * t, c])
        });
        let PieceGeometry::Curve(this) = &geometry else { continue };
        if let Some(ToolPiece { geometry: PieceGeometry::Curve(before), .. }) = pieces.last() {
            let [from, to] = [before.pose(length).unwrap(), this.pose(0.0).unwrap()];
            let geometry = PieceGeometry::Reorient { from, to };
            pieces.push(ToolPiece { motion: Motion::Link, geometry });
        }
        pieces.push(ToolPiece { motion: Motion::Cut, geometry });
    }
    ToolPath { pieces }
}

/// Seconds of processor time so far, own and the system's for it (memory), where the system tells (in
/// hundredths): on a busy machine the clock on the wall counts what others do.
fn processor() -> Option<[f64; 2]> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
    let [own, system]: [f64; 2] = [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?];
    Some([own / 100.0, system / 100.0])
}

/// Every bit of the axes, so that two runs can be compared.
fn sum(path: &AxisPath) -> u64 {
    let nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
    let all = nodes.flat_map(|node| {
        [node.s, node.tip_rate, node.feed_rate].into_iter().chain(node.q.iter().flatten().copied())
    });
    all.fold(0, |sum: u64, value| sum.rotate_left(5) ^ value.to_bits().wrapping_mul(0x9e37_79b9))
}

fn measure(name: &str, what: &str, path: &ToolPath, retract: Option<RetractOptions>) {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let mut rows =
        words.iter().filter(|word| word.parse::<u32>().is_err() && !word.starts_with('-'));
    if rows.clone().next().is_some() && !rows.any(|row| format!("{name}, {what}").contains(row)) {
        return;
    }
    let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) else {
        println!("no machine {name}");
        return;
    };
    let machine = parse(text).unwrap().machine;
    let middle = |axis: usize| {
        let [low, high] = machine.axes[axis].limits.ends();
        0.5 * (low + high)
    };
    let rest = AxisVector::from([middle(0), middle(1), middle(2), 0.0, 0.3]);
    let at_zero = Kinematics::new(&machine, &Setup::new(V3::zeros(), [0.0; 3], 120.0));
    // The part stands where the tool is in the middle of travel.
    let origin = at_zero.forward(&rest).tip.coords;
    let kinematics = Kinematics::new(&machine, &Setup::new(origin, [0.0; 3], 120.0));
    let options = AxesOptions {
        max_rotary_step: 0.05,
        retract,
        ..AxesOptions::within(PoseTolerance::new(1e-3, 1e-4), machine.home())
    };
    let mut best = f64::INFINITY;
    let mut cpu = [f64::INFINITY, 0.0];
    let mut reported = String::new();
    for _ in 0..RUNS {
        let (start, before) = (Instant::now(), processor());
        let followed = follow(&kinematics, path, &options, &Silent);
        best = best.min(start.elapsed().as_secs_f64());
        if let (Some(end), Some(start)) = (processor(), before) {
            let used = [0, 1].map(|part| end[part] - start[part]);
            if used.iter().sum::<f64>() < cpu.iter().sum() {
                cpu = used;
            }
        }
        reported = match followed {
            Ok(found) => format!(
                "{} nodes, {} retracts, travel {:.9} rad, off by {:.3e} mm {:.3e} rad, bits {:016x}",
                found.path.pieces.iter().map(|piece| piece.nodes.len()).sum::<usize>(),
                found.retracts.len(),
                found.rotary_travel,
                found.deviation.tip,
                found.deviation.axis,
                sum(&found.path)
            ),
            Err(error) => error.to_string(),
        };
    }
    let [own, system] = cpu;
    println!(
        "{name}, {what}: {best:.3} s, processor {:.2} s (system {system:.2} s), of {RUNS} runs the best; {reported}",
        own + system
    );
}
