//! Time of a posted program with the planner, beside the time that its inverse-time blocks ask for.
//!
//! ```text
//! cargo run --release -p trunnion-rt --example program_time -- bc-trunnion out/program.linuxcnc.ngc 120
//! ```
//!
//! Both sides of the planner run in one thread, a turn of planning to a servo cycle. Blocks come as `LinuxCNC` sends them,
//! with the speeds that its axes allow. Only what trunnion writes is read: `G0`, `G1`, `G53`, `G64 P`, `G93`, `G94`, `M428`, `M429`.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a script that measures")]

use std::collections::BTreeMap;
use std::time::Instant;
use trunnion::types::AxisVector;
use trunnion_rt::planner::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerOptions,
    ServoSpeeds, planner,
};
use trunnion_rt::{MachineKinematics, machine_from_text, machine_named};

const PERIOD: f64 = 0.001;
const LETTERS: &str = "XYZABCUVW";

/// A block, the comment before it, and the time that it asks for \[s\].
struct TimedBlock {
    motion: MotionBlock,
    part: String,
    wanted: Option<f64>,
}

/// Modes that hold from block to block.
struct Modes {
    at: [f64; 9],
    offset: [f64; 9],
    rapid: bool,
    inverse: bool,
    feed: f64,
    tolerance: f64,
    coordinates: BlockCoordinates,
    part: String,
}

/// Largest velocities of the letters \[mm/s, rad/s\].
fn velocities(kinematics: &MachineKinematics) -> [f64; 9] {
    let mut most = [f64::INFINITY; 9];
    for axis in &kinematics.machine().axes {
        let letter = axis.output.letter.as_deref().unwrap_or(&axis.name);
        most[LETTERS.find(letter).unwrap()] = axis.vel;
    }
    most
}

fn blocks(text: &str, kinematics: &MachineKinematics, length: f64) -> Vec<TimedBlock> {
    let velocities = velocities(kinematics);
    let mut modes = Modes {
        at: [0.0; 9],
        offset: [0.0; 9],
        rapid: true,
        inverse: false,
        feed: 0.0,
        tolerance: 0.01,
        coordinates: BlockCoordinates::Axes,
        part: "head".to_owned(),
    };
    let mut all = Vec::new();
    for line in text.lines() {
        if let Some(comment) = line.strip_prefix('(') {
            if let Some(offset) = comment.strip_prefix("G54 must hold ") {
                for word in offset
                    .split(';')
                    .next()
                    .unwrap()
                    .split_whitespace()
                    .collect::<Vec<_>>()
                    .chunks(2)
                {
                    modes.offset[LETTERS.find(word[0]).unwrap()] = word[1].parse().unwrap();
                }
            }
            comment.split([' ', ')']).next().unwrap().clone_into(&mut modes.part);
            continue;
        }
        if let Some(block) = block(line, &mut modes, &velocities, length, all.len()) {
            all.push(block);
        }
    }
    all
}

fn block(
    line: &str,
    modes: &mut Modes,
    velocities: &[f64; 9],
    length: f64,
    index: usize,
) -> Option<TimedBlock> {
    let mut end = modes.at;
    let (mut moves, mut absolute) = (false, false);
    for word in line.split_whitespace() {
        let (letter, value) = word.split_at(1);
        let value: f64 = value.parse().ok()?;
        match (letter, value.to_string().as_str()) {
            ("G", "0") => modes.rapid = true,
            ("G", "1") => modes.rapid = false,
            ("G", "53") => absolute = true,
            ("G", "43") => modes.offset[2] += length,
            ("G", "93") => modes.inverse = true,
            ("G", "94") => modes.inverse = false,
            ("M", "428") => modes.coordinates = BlockCoordinates::Tip,
            ("M", "429") => modes.coordinates = BlockCoordinates::Axes,
            ("F", _) => modes.feed = value,
            ("P", _) => modes.tolerance = value,
            _ => {}
        }
        if let Some(letter) = LETTERS.find(letter) {
            let rotary = (3..6).contains(&letter);
            let offset = if absolute { 0.0 } else { modes.offset[letter] };
            end[letter] = if rotary { value.to_radians() } else { value + offset };
            moves = true;
        }
    }
    moves.then_some(())?;
    let step: Vec<f64> = end.iter().zip(&modes.at).map(|(end, at)| end - at).collect();
    let norm = |from: usize| step[from..from + 3].iter().map(|d| d * d).sum::<f64>().sqrt();
    let leading = if norm(0) > 1e-7 { norm(0) } else { norm(3) };
    let least = step.iter().zip(velocities).map(|(d, v)| d.abs() / v).fold(0.0, f64::max);
    let wanted = (!modes.rapid && modes.inverse).then(|| 60.0 / modes.feed);
    let seconds = wanted.unwrap_or(if modes.rapid { 0.0 } else { leading / (modes.feed / 60.0) });
    let kind = match (modes.rapid, modes.inverse) {
        (true, _) => BlockKind::Rapid,
        (false, true) => BlockKind::Timed,
        (false, false) => BlockKind::Feed,
    };
    let motion = MotionBlock {
        number: u32::try_from(index + 1).unwrap(),
        start: modes.at,
        end,
        shape: BlockShape::Line,
        kind,
        speed: leading / seconds.max(least),
        begins: BlockStart::Flow,
        ending: BlockEnding::Blend,
        tolerance: modes.tolerance,
        coordinates: modes.coordinates,
        tool_length: length,
    };
    modes.at = end;
    Some(TimedBlock { motion, part: modes.part.clone(), wanted })
}

/// Joints of a position in a kind of kinematics.
fn joints(kinematics: &MachineKinematics, of: &TimedBlock, position: &[f64; 9]) -> AxisVector {
    let machine = kinematics.machine();
    let words = AxisVector::from_fn(|axis, _| {
        let named = &machine.axes[axis];
        let letter = named.output.letter.as_deref().unwrap_or(&named.name);
        position[LETTERS.find(letter).unwrap()]
    });
    match of.motion.coordinates {
        BlockCoordinates::Axes => words,
        BlockCoordinates::Tip => kinematics.joints(of.motion.tool_length, &words).unwrap().joints,
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, machine, program, length, ..] = &arguments[..] else {
        println!("program_time MACHINE PROGRAM TOOL-LENGTH [blocks]");
        return;
    };
    let kinematics = std::fs::read_to_string(machine)
        .map_or_else(|_| machine_named(machine).unwrap(), |text| machine_from_text(&text).unwrap());
    let text = std::fs::read_to_string(program).unwrap();
    let all = blocks(&text, &kinematics, length.parse().unwrap());
    let (mut servo, mut core) = planner(&kinematics, PlannerOptions::STANDARD, PERIOD).unwrap();
    servo.reset(all[0].motion.start);
    let mut seconds = vec![0.0; all.len()];
    let mut waiting = all.iter().peekable();
    let (mut cycle, mut worked, mut longest) = (0_u32, 0.0, 0.0_f64);
    let mut places: Vec<(usize, AxisVector)> = Vec::new();
    while waiting.peek().is_some() || !servo.is_done() {
        for _ in 0..10 {
            if waiting.peek().is_some_and(|block| servo.push(&block.motion).is_some()) {
                waiting.next();
            }
        }
        cycle += 1;
        let mut now = f64::from(cycle) * PERIOD - 0.002;
        let begin = Instant::now();
        core.turn(&mut || {
            now += 0.002;
            now
        });
        let took = begin.elapsed().as_secs_f64();
        worked += took;
        longest = longest.max(took);
        let sample = servo.cycle(ServoSpeeds { feed: 1.0, rapid: 1.0 });
        let index = (sample.block as usize).max(1) - 1;
        if !sample.rests {
            seconds[index] += PERIOD;
        }
        places.push((index, joints(&kinematics, &all[index], &sample.position)));
    }
    report(&all, &seconds, arguments.len() > 4);
    let moving: f64 = seconds.iter().sum();
    println!(
        "planning {worked:.2} s, {:.1} % of the motion, {:.1} ms at most",
        100.0 * worked / moving,
        1e3 * longest
    );
    println!(
        "velocity, acceleration, jerk over their limits: {:.4?}",
        ratios(&kinematics, &all, &places)
    );
    println!("{:?}", servo.state());
}

fn report(all: &[TimedBlock], seconds: &[f64], each: bool) {
    let mut parts: BTreeMap<String, [f64; 4]> = BTreeMap::new();
    for (block, took) in all.iter().zip(seconds) {
        let wanted = block.wanted.unwrap_or(0.0);
        let class = match block.wanted {
            None => "not timed".to_owned(),
            Some(wanted) if wanted > 0.06 => format!("{} longer than 0.06 s", block.part),
            Some(_) => block.part.clone(),
        };
        let sum = parts.entry(class).or_default();
        for (sum, one) in sum.iter_mut().zip([1.0, wanted, *took, (took - wanted).max(0.0)]) {
            *sum += one;
        }
        if each {
            let motion = &block.motion;
            let tip: f64 =
                (0..3).map(|k| (motion.end[k] - motion.start[k]).powi(2)).sum::<f64>().sqrt();
            println!(
                "{:6} {:8} {tip:9.4} mm  wanted {wanted:.4}  took {took:.3}",
                motion.number, block.part
            );
        }
    }
    for (part, [count, wanted, took, lost]) in parts {
        println!(
            "{part:28} {count:6} blocks, wanted {wanted:7.3} s, took {took:7.3} s, blocks over by {lost:6.3} s"
        );
    }
    let timed = all.iter().zip(seconds).filter(|(block, _)| block.wanted.is_some());
    let [wanted, took] = timed.fold([0.0; 2], |[wanted, took], (block, seconds)| {
        [wanted + block.wanted.unwrap_or(0.0), took + seconds]
    });
    println!(
        "inverse-time blocks: wanted {wanted:.3} s, took {took:.3} s ({:+.1} %)",
        100.0 * (took / wanted - 1.0)
    );
}

/// Largest velocity, acceleration and jerk of the joints over their limits, where the kind of kinematics does not change.
fn ratios(
    kinematics: &MachineKinematics,
    all: &[TimedBlock],
    places: &[(usize, AxisVector)],
) -> [f64; 3] {
    let machine = kinematics.machine();
    let limits = [
        machine.vector(|axis| axis.vel),
        machine.vector(|axis| axis.acc),
        machine.vector(|axis| axis.jerk),
    ];
    let mut worst = [0.0; 3];
    for four in places.windows(4) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| four[k].1);
        if all[four[0].0].motion.coordinates != all[four[3].0].motion.coordinates {
            continue;
        }
        let orders = [
            (b - a) / PERIOD,
            (c - b * 2.0 + a) / PERIOD.powi(2),
            (d - c * 3.0 + b * 3.0 - a) / PERIOD.powi(3),
        ];
        for ((worst, order), limit) in worst.iter_mut().zip(&orders).zip(&limits) {
            *worst = f64::max(*worst, order.component_div(limit).amax());
        }
    }
    worst
}
