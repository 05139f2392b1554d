//! The planner, both sides in one thread: limits, contour, overrides, holds and aborts.

use crate::walk::Dice;
use trunnion::files::machine::{built_in, parse};
use trunnion::types::AxisVector;
use trunnion_rt::planner::{
    BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerCore, PlannerOptions,
    PlannerServo, ServoSpeeds, planner,
};
use trunnion_rt::{KinematicsMode, MachineKinematics, machine_from_text, machine_named};

const PERIOD: f64 = 0.001;
const FULL: ServoSpeeds = ServoSpeeds { feed: 1.0, rapid: 1.0 };

/// Position of all letters.
type Letters = [f64; 9];

/// Both sides of a planner, with what a run of theirs leaves.
struct Bench {
    servo: PlannerServo,
    core: PlannerCore,
    kinematics: MachineKinematics,
    mode: KinematicsMode,
    length: f64,
    cycle: u32,
    positions: Vec<Letters>,
    blocks: Vec<u32>,
}

impl Bench {
    fn new(machine: &str, mode: KinematicsMode, length: f64) -> Self {
        Self::with(machine_named(machine).unwrap(), mode, length)
    }

    fn with(kinematics: MachineKinematics, mode: KinematicsMode, length: f64) -> Self {
        let (servo, core) = planner(kinematics.clone(), PlannerOptions::STANDARD, PERIOD).unwrap();
        let (positions, blocks) = (Vec::new(), Vec::new());
        Self { servo, core, kinematics, mode, length, cycle: 0, positions, blocks }
    }

    /// One servo cycle, and a turn of the planner if it is not late.
    fn cycle(&mut self, speeds: ServoSpeeds, plans: Plans) {
        self.cycle += 1;
        if plans == Plans::InTime {
            self.core.turn(f64::from(self.cycle) * PERIOD);
        }
        let sample = self.servo.cycle(speeds);
        self.positions.push(sample.position);
        self.blocks.push(sample.block);
    }

    fn joints(&self, letters: &Letters) -> AxisVector {
        let machine = self.kinematics.machine();
        let words = AxisVector::from_fn(|axis, _| {
            let named = &machine.axes[axis];
            let letter = named.output.letter.as_deref().unwrap_or(&named.name);
            letters["XYZABCUVW".find(letter).unwrap()]
        });
        match self.mode {
            KinematicsMode::Axes => words,
            KinematicsMode::ToolCenterPoint => {
                self.kinematics.joints(self.length, &words).unwrap().joints
            }
        }
    }

    /// Largest velocity, acceleration and jerk of the joints over their limits, from differences of cycles.
    fn ratios(&self) -> [f64; 3] {
        let machine = self.kinematics.machine();
        let limits = [
            machine.vector(|axis| axis.vel),
            machine.vector(|axis| axis.acc),
            machine.vector(|axis| axis.jerk),
        ];
        let mut orders: Vec<AxisVector> =
            self.positions.iter().map(|letters| self.joints(letters)).collect();
        limits.map(|limit| {
            orders = orders.windows(2).map(|two| (two[1] - two[0]) / PERIOD).collect();
            orders.iter().map(|order| order.component_div(&limit).amax()).fold(0.0, f64::max)
        })
    }
}

/// The machine on which `LinuxCNC`'s own planner was timed: a table that turns about X and Z through the origin, with
/// 500 mm/s, 5000 mm/s2, 100 deg/s, 1000 deg/s2; and jerk limits, which that planner has not.
fn timed_machine() -> MachineKinematics {
    let mut text = built_in("ac-trunnion").unwrap().to_owned();
    let jerks: f64 = std::env::var("JERKS").map_or(1.0, |v| v.parse().unwrap());
    for (from, to) in [
        ("point  = [0.0, 0.0, -600.0]", "point  = [0, 0, 0]"),
        ("point  = [0.0, 0.02, -560.0]", "point  = [0, 0, 0]"),
        ("[-400.0, 400.0]", "[-2000, 2000]"),
        ("[-550.0, 0.0]", "[-2000, 2000]"),
        ("vel    = 1000.0", "vel    = 500"),
        ("acc    = 6000.0", "acc    = 5000"),
        ("vel    = 390.0", "vel    = 100"),
        ("acc    = 1500.0", "acc    = 1000"),
        ("jerk   = 30000.0", &format!("jerk = {}", 25000.0*jerks)),
        ("vel    = 150.0", "vel    = 100"),
        ("acc    = 600.0", "acc    = 1000"),
        ("jerk   = 15000.0", &format!("jerk = {}", 25000.0*jerks)),
        ("jerk   = 100000.0", &format!("jerk = {}", 100000.0*jerks)),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    machine_from_text(&text).unwrap()
}

/// The planning thread is there, or the system keeps it off.
#[derive(Clone, Copy, PartialEq)]
enum Plans {
    InTime,
    Late,
}

fn line(start: Letters, end: Letters, speed: f64) -> MotionBlock {
    MotionBlock {
        number: 0,
        start,
        end,
        shape: BlockShape::Line,
        kind: BlockKind::Feed,
        speed,
        begins: BlockStart::Flow,
        ending: BlockEnding::Blend,
        tolerance: 0.01,
        mode: KinematicsMode::ToolCenterPoint,
        tool_length: 120.0,
    }
}

/// Blocks through points, in the letters of the kinematics of a bench.
fn blocks(points: &[Letters], speed: f64, bench: &Bench) -> Vec<MotionBlock> {
    let pairs = points.windows(2).enumerate();
    let block = |(index, two): (usize, &[Letters])| MotionBlock {
        number: u32::try_from(index).unwrap() + 1,
        mode: bench.mode,
        tool_length: bench.length,
        ..line(two[0], two[1], speed)
    };
    pairs.map(block).collect()
}

/// A pass over a waved surface, the tool leaning ahead of the normal: X Y Z A C about a place of the machine.
fn pass(step: f64) -> Vec<Letters> {
    let mut points = Vec::new();
    let mut x = 0.0_f64;
    loop {
        let at = x.min(250.0);
        let k = std::f64::consts::TAU / 80.0;
        let slope = 3.0 * k * (k * at).cos();
        let [c, s] = [20f64.to_radians().cos(), 20f64.to_radians().sin()];
        let n = slope.hypot(1.0);
        let normal = [-slope / n, 0.0, 1.0 / n];
        let axis = [c * normal[0] + s * normal[2], normal[1], -s * normal[0] + c * normal[2]];
        let mut point = [0.0; 9];
        point[0] = at;
        point[2] = 3.0 * (k * at).sin();
        // Four decimals, as programs have.
        let rounded = |value: f64| (value * 1e4).round() / 1e4;
        let tilt = axis[2].acos().to_degrees();
        let turn = axis[0].atan2(axis[1]).to_degrees();
        point[3] = rounded(tilt).to_radians();
        point[5] = rounded(turn).to_radians();
        point[0] = rounded(point[0]);
        point[2] = rounded(point[2]);
        points.push(point);
        if at >= 250.0 {
            return points;
        }
        x += step / slope.hypot(1.0);
    }
}

/// Largest distance of the positions from the polyline through the points, in X Y Z.
fn contour(positions: &[Letters], points: &[Letters]) -> f64 {
    let tip = |letters: &Letters| [letters[0], letters[1], letters[2]];
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut worst = 0.0_f64;
    let mut near = 0;
    for position in positions {
        let distance = |leg: usize| {
            let (from, to) = (tip(&points[leg]), tip(&points[leg + 1]));
            let (d, e) = (minus(to, from), minus(tip(position), from));
            let u = (dot(e, d) / dot(d, d).max(1e-30)).clamp(0.0, 1.0);
            let miss = minus(e, [d[0] * u, d[1] * u, d[2] * u]);
            dot(miss, miss).sqrt()
        };
        let legs = near_legs(near, points.len() - 1);
        let best = legs.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
        near = best;
        worst = worst.max(distance(best));
    }
    worst
}

fn near_legs(near: usize, legs: usize) -> std::ops::Range<usize> {
    near.saturating_sub(40)..(near + 41).min(legs)
}

/// Runs blocks that arrive one a cycle.
fn run(bench: &mut Bench, blocks: &[MotionBlock], mut each: impl FnMut(u32) -> (ServoSpeeds, Plans)) {
    bench.servo.reset(blocks[0].start);
    let mut waiting = blocks.iter().peekable();
    for cycle in 0..200_000 {
        if let Some(block) = waiting.peek()
            && bench.servo.push(block).is_some()
        {
            waiting.next();
        }
        let (speeds, plans) = each(cycle);
        bench.cycle(speeds, plans);
        if waiting.peek().is_none() && bench.servo.is_done() {
            return;
        }
    }
    panic!("the program does not end");
}

/// Cycles in motion, in seconds.
fn moving(bench: &Bench) -> f64 {
    let moves = |two: &[Letters]| two[0] != two[1];
    bench.positions.windows(2).filter(|two| moves(two)).count() as f64 * PERIOD
}

#[test]
fn a_pass_of_short_blocks_runs_at_its_feed() {
    for step in [0.5, 0.125] {
        let mut bench = Bench::with(timed_machine(), KinematicsMode::ToolCenterPoint, 0.0);
        let points = pass(step);
        let program = blocks(&points, 50.0, &bench);
        run(&mut bench, &program, |_| (FULL, Plans::InTime));
        let [velocity, acceleration, jerk] = bench.ratios();
        let (seconds, miss) = (moving(&bench), contour(&bench.positions, &points));
        let state = bench.servo.state();
        eprintln!(
            "{step} mm: {seconds} s, ratios {velocity:.4} {acceleration:.4} {jerk:.4}, contour {miss:.5}, {state:?}"
        );
        if std::env::var("LOOK").is_ok() { let mut f=String::new(); for p in &bench.positions { f+=&format!("{} {} {} {} {}\n",p[0],p[1],p[2],p[3],p[5]); } std::fs::write(format!("/tmp/look-{step}.txt"),f).unwrap(); continue; }
        assert!(seconds < 5.6, "{seconds}");
        assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001);
        assert!(miss <= 0.01, "{miss}");
        assert_eq!(bench.servo.position(), *points.last().unwrap());
    }
}
