//! Cost of the planner: of a servo cycle with the kinematics, and of planning as a share of the motion.
//!
//! Both sides run in one thread, in virtual time. The motion is run several times, always the same, and of a cycle the least
//! time counts: what the system takes away meanwhile is no part of it. The planning is a share of one processor.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a script that measures")]

use std::hint::black_box;
use std::time::Instant;
use trunnion::types::AxisVector;
use trunnion_rt::planner::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerOptions,
    ServoSpeeds, planner,
};
use trunnion_rt::{MachineKinematics, machine_from_text};

const PERIOD: f64 = 0.001;
const RUNS: usize = 7;

/// X Y Z A C of a pass over a waved surface in blocks of `step` \[mm\], the tool leaning 20 degrees ahead.
fn pass(step: f64) -> Vec<[f64; 9]> {
    let wave = std::f64::consts::TAU / 80.0;
    // Four decimals, as programs have.
    let rounded = |value: f64| (value * 1e4).round() / 1e4;
    let mut points = Vec::new();
    let mut x = 0.0_f64;
    loop {
        let at = x.min(250.0);
        let slope = 3.0 * wave * (wave * at).cos();
        let tilt = rounded(20.0 - slope.atan().to_degrees()).to_radians();
        let turn = 90f64.to_radians();
        points.push([
            rounded(at),
            0.0,
            rounded(3.0 * (wave * at).sin()),
            tilt,
            0.0,
            turn,
            0.0,
            0.0,
            0.0,
        ]);
        if at >= 250.0 {
            return points;
        }
        x += step / slope.hypot(1.0);
    }
}

fn blocks(points: &[[f64; 9]], speed: f64) -> Vec<MotionBlock> {
    let block = |(index, two): (usize, &[[f64; 9]])| MotionBlock {
        number: u32::try_from(index).unwrap() + 1,
        start: two[0],
        end: two[1],
        shape: BlockShape::Line,
        kind: BlockKind::Feed,
        speed,
        begins: BlockStart::Flow,
        ending: BlockEnding::Blend,
        tolerance: 0.01,
        coordinates: BlockCoordinates::Tip,
        tool_length: 0.0,
    };
    points.windows(2).enumerate().map(block).collect()
}

/// Figures of one run.
struct Costs {
    /// Time of each servo cycle \[s\].
    cycles: Vec<f64>,
    /// Time of all planning, and the longest turn \[s\].
    planning: f64,
    longest: f64,
}

/// Runs a program. Two blocks come in a cycle, about as many as from the task of `LinuxCNC`.
fn run(kinematics: &MachineKinematics, program: &[MotionBlock]) -> Costs {
    let (mut servo, mut core) = planner(kinematics, PlannerOptions::STANDARD, PERIOD).unwrap();
    servo.reset(program[0].start);
    let mut waiting = program.iter().peekable();
    let mut costs = Costs { cycles: Vec::new(), planning: 0.0, longest: 0.0 };
    let mut now = 0.0;
    while waiting.peek().is_some() || !servo.is_done() {
        for _ in 0..2 {
            if waiting.peek().is_some_and(|block| servo.push(block).is_some()) {
                waiting.next();
            }
        }
        let begin = Instant::now();
        core.turn(&mut || now);
        let took = begin.elapsed().as_secs_f64();
        costs.planning += took;
        costs.longest = costs.longest.max(took);
        now += PERIOD;
        let begin = Instant::now();
        let sample = servo.cycle(ServoSpeeds { feed: 1.0, rapid: 1.0 });
        let [x, _, z, tilt, _, turn, ..] = sample.position;
        let words = AxisVector::from([x, 0.0, z, turn, tilt]);
        let joints = black_box(kinematics.joints(0.0, &words)).is_ok();
        let took = begin.elapsed().as_secs_f64();
        if joints && !sample.rests {
            costs.cycles.push(took);
        }
    }
    costs
}

fn main() {
    let kinematics =
        machine_from_text(include_str!("../../../fixtures/linuxcnc/timed-table.toml")).unwrap();
    for (step, speed) in [(0.1, 100.0), (0.125, 50.0), (0.5, 50.0)] {
        let program = blocks(&pass(step), speed);
        let runs: Vec<Costs> = (0..RUNS).map(|_| run(&kinematics, &program)).collect();
        let least = |of: &dyn Fn(&Costs) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
        let count = runs.iter().map(|run| run.cycles.len()).min().unwrap_or(0);
        let mut cycles: Vec<f64> =
            (0..count).map(|cycle| least(&|run: &Costs| run.cycles[cycle])).collect();
        let motion = count as f64 * PERIOD;
        cycles.sort_by(f64::total_cmp);
        println!(
            "blocks of {step} mm at {speed} mm/s: {motion:.3} s; a servo cycle with kinematics {:.2} us in the median, {:.2} us \
             at most; planning {:.1} % of a processor, {:.1} ms at most",
            1e6 * cycles[count / 2],
            1e6 * cycles[count - 1],
            100.0 * least(&|run: &Costs| run.planning) / motion,
            1e3 * least(&|run: &Costs| run.longest)
        );
    }
}
