//! The planner, both sides in one thread: limits, contour, overrides, holds and aborts.

use crate::walk::Dice;
use std::time::{Duration, Instant};
use trunnion::types::AxisVector;
use trunnion_rt::planner::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerCore,
    PlannerOptions, PlannerServo, PlannerThread, ServoSpeeds, planner,
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
    /// Duration of a plan by the clock of this bench \[s\].
    planning: f64,
    positions: Vec<Letters>,
    blocks: Vec<u32>,
}

impl Bench {
    fn new(machine: &str, mode: KinematicsMode, length: f64) -> Self {
        Self::with(machine_named(machine).unwrap(), mode, length)
    }

    fn with(kinematics: MachineKinematics, mode: KinematicsMode, length: f64) -> Self {
        Self::with_options(kinematics, mode, length, PlannerOptions::STANDARD)
    }

    fn with_options(
        kinematics: MachineKinematics,
        mode: KinematicsMode,
        length: f64,
        options: PlannerOptions,
    ) -> Self {
        let (servo, core) = planner(&kinematics, options, PERIOD).unwrap();
        let (positions, blocks) = (Vec::new(), Vec::new());
        let (cycle, planning) = (0, 0.002);
        Self { servo, core, kinematics, mode, length, cycle, planning, positions, blocks }
    }

    /// One servo cycle, and a turn of the planner if it is not late.
    fn cycle(&mut self, speeds: ServoSpeeds, plans: Plans) {
        self.cycle += 1;
        if plans == Plans::InTime {
            let mut now = f64::from(self.cycle) * PERIOD - self.planning;
            self.core.turn(&mut || {
                now += self.planning;
                now
            });
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

/// The table on which `LinuxCNC`'s own planner was timed, with room for random paths.
fn timed_machine() -> MachineKinematics {
    let text = include_str!("../../../../fixtures/linuxcnc/timed-table.toml");
    assert!(text.contains("[-500, 500]"));
    machine_from_text(&text.replace("[-500, 500]", "[-2000, 2000]")).unwrap()
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
        coordinates: BlockCoordinates::Tip,
        tool_length: 120.0,
    }
}

/// Blocks through points, in the letters of the kinematics of a bench.
fn blocks(points: &[Letters], speed: f64, bench: &Bench) -> Vec<MotionBlock> {
    let pairs = points.windows(2).enumerate();
    let block = |(index, two): (usize, &[Letters])| MotionBlock {
        number: u32::try_from(index).unwrap() + 1,
        coordinates: bench.mode.into(),
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
fn run(
    bench: &mut Bench,
    blocks: &[MotionBlock],
    mut each: impl FnMut(u32) -> (ServoSpeeds, Plans),
) {
    bench.servo.reset(blocks[0].start);
    let mut waiting = blocks.iter().peekable();
    let mut cycle = 0;
    while waiting.peek().is_some() || !bench.servo.is_done() {
        assert!(cycle < 200_000, "the program does not end");
        if let Some(block) = waiting.peek()
            && bench.servo.push(block).is_some()
        {
            waiting.next();
        }
        let (speeds, plans) = each(cycle);
        bench.cycle(speeds, plans);
        cycle += 1;
    }
}

fn assert_at(bench: &Bench, place: &Letters) {
    let position = bench.servo.position();
    let close = position.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(close, "{position:?} {place:?}");
}

/// Cycles in motion, in seconds.
fn moving(bench: &Bench) -> f64 {
    let moves = |two: &[Letters]| two[0].map(f64::to_bits) != two[1].map(f64::to_bits);
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
        assert!(seconds < 5.6, "{seconds}");
        assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001);
        assert!(miss <= 0.01, "{miss}");
        assert_at(&bench, points.last().unwrap());
    }
}

/// Points at random distances and directions about a place that every letter can reach.
fn wild(dice: &mut Dice, count: usize) -> Vec<Letters> {
    let mut at = [-20.0, 15.0, -300.0, 0.2, 0.0, 0.4, 0.0, 0.0, 0.0];
    let mut points = vec![at];
    for _ in 0..count {
        // Between a hundredth of a millimetre and thirty.
        let size = 10.0_f64.powf(dice.between(-2.0, 1.5));
        for letter in 0..3 {
            let middle = [0.0, 0.0, -300.0][letter];
            at[letter] += dice.between(-size, size) + 0.05 * (middle - at[letter]);
        }
        if dice.unit() < 0.5 {
            for letter in [3, 5] {
                at[letter] = 0.95 * at[letter] + 0.02 * dice.between(-size, size);
            }
        }
        points.push(at);
    }
    points
}

/// Checks limits and contour of a run.
fn check(bench: &Bench, points: &[Letters], tolerance: f64, case: &str) {
    let [velocity, acceleration, jerk] = bench.ratios();
    let miss = contour(&bench.positions, points);
    eprintln!(
        "{case}: {} s, ratios {velocity:.4} {acceleration:.4} {jerk:.4}, contour {miss:.5} of {tolerance}, {:?}",
        bench.positions.len() as f64 * PERIOD,
        bench.servo.state()
    );
    assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001, "{case}");
    assert!(miss <= tolerance, "{case}: {miss}");
}

#[test]
fn wild_programs_keep_limits_and_contour() {
    for seed in 0..6 {
        let mut dice = Dice::new(100 + seed);
        let mode = [KinematicsMode::Axes, KinematicsMode::ToolCenterPoint][dice.below(2)];
        let mut bench = Bench::new("ac-trunnion", mode, 120.0);
        let points = wild(&mut dice, 60);
        let tolerance = 10.0_f64.powf(dice.between(-2.5, -0.5));
        let speed = 10.0_f64.powf(dice.between(0.5, 2.5));
        let mut program = blocks(&points, speed, &bench);
        for block in &mut program {
            block.tolerance = tolerance;
            if dice.unit() < 0.2 {
                block.kind = BlockKind::Rapid;
                block.speed = 400.0;
            }
        }
        run(&mut bench, &program, |_| (FULL, Plans::InTime));
        check(&bench, &points, tolerance, &format!("seed {seed}"));
        assert_at(&bench, points.last().unwrap());
        assert_eq!(bench.servo.state().late, 0);
        assert!(bench.blocks.windows(2).all(|two| two[0] <= two[1]));
    }
}

#[test]
fn holds_overrides_and_a_late_planner_keep_limits_and_contour() {
    for seed in 0..6 {
        let mut dice = Dice::new(200 + seed);
        let mut bench = Bench::new("ac-trunnion", KinematicsMode::ToolCenterPoint, 120.0);
        let points = if seed % 2 == 0 { wild(&mut dice, 50) } else { pass_beside_the_axis() };
        let tolerance = 0.02;
        let mut program = blocks(&points, 60.0, &bench);
        for block in &mut program {
            block.tolerance = tolerance;
        }
        let (mut speeds, mut late_until) = (FULL, 0);
        run(&mut bench, &program, |cycle| {
            if dice.unit() < 0.01 {
                let feed = [0.0, 0.05, 0.5, 1.0, 1.7][dice.below(5)];
                speeds = ServoSpeeds { feed, rapid: if feed > 0.0 { 1.0 } else { 0.0 } };
            }
            if cycle >= late_until && dice.unit() < 0.002 {
                late_until = cycle + 20 + u32::try_from(dice.below(300)).unwrap();
            }
            (speeds, if cycle < late_until { Plans::Late } else { Plans::InTime })
        });
        check(&bench, &points, tolerance, &format!("seed {seed}"));
        assert_at(&bench, points.last().unwrap());
    }
}

/// Plans that take long now and then are committed far ahead, and others follow them closely: none may overwrite what
/// the servo thread still plays.
#[test]
fn plans_that_follow_each_other_closely_leave_what_is_played_alone() {
    for seed in 0..6 {
        let mut dice = Dice::new(900 + seed);
        let mode = KinematicsMode::ToolCenterPoint;
        let options = PlannerOptions { pieces: 4096, ..PlannerOptions::STANDARD };
        let mut bench = Bench::with_options(timed_machine(), mode, 0.0, options);
        let points = pass(0.5);
        let program = blocks(&points, 50.0, &bench);
        bench.servo.reset(points[0]);
        let mut waiting = program.iter().peekable();
        while waiting.peek().is_some() || !bench.servo.is_done() {
            if waiting.peek().is_some_and(|block| bench.servo.push(block).is_some()) {
                waiting.next();
            }
            bench.planning = if dice.unit() < 0.3 { dice.between(0.0, 0.4) } else { 0.005 };
            bench.cycle(FULL, Plans::InTime);
        }
        check(&bench, &points, 0.01, &format!("seed {seed}"));
        assert_at(&bench, points.last().unwrap());
        assert_eq!(bench.servo.state().late, 0);
        assert!(bench.servo.fault().is_none());
    }
}

/// The waved pass, at a place that the machine reaches.
fn pass_beside_the_axis() -> Vec<Letters> {
    let mut points = pass(0.4);
    points.truncate(250);
    for point in &mut points {
        point[0] -= 60.0;
        point[2] -= 350.0;
    }
    points
}

#[test]
fn an_abort_stops_on_the_path_and_another_program_begins_there() {
    for seed in 0..4 {
        let mut dice = Dice::new(300 + seed);
        let mut bench = Bench::new("ac-trunnion", KinematicsMode::ToolCenterPoint, 120.0);
        let points = pass_beside_the_axis();
        let program = blocks(&points, 50.0, &bench);
        bench.servo.reset(points[0]);
        let mut sent = 0;
        for cycle in 0..200 + 300 * dice.below(4) {
            while cycle >= sent
                && sent < program.len()
                && bench.servo.push(&program[sent]).is_some()
            {
                sent += 1;
            }
            bench.cycle(FULL, Plans::InTime);
        }
        bench.servo.abort();
        let begin = bench.positions.len();
        while bench.servo.is_aborting() {
            assert!(bench.servo.push(&program[0]).is_none(), "no block during an abort");
            bench.cycle(FULL, Plans::InTime);
            assert!(bench.positions.len() - begin < 2000, "the abort does not end");
        }
        let stop = bench.positions.len() - begin;
        assert!(bench.servo.is_done());
        let here = bench.servo.position();
        let mut away = here;
        away[2] += 20.0;
        let mut after = line(here, away, 100.0);
        after.number = 1000;
        bench.servo.push(&after).unwrap();
        while !bench.servo.is_done() {
            bench.cycle(FULL, Plans::InTime);
        }
        assert_at(&bench, &away);
        eprintln!("seed {seed}: stopped after {stop} cycles");
        let all: Vec<Letters> = bench.positions[..begin + stop].to_vec();
        assert!(contour(&all, &points) <= 0.01);
        let [velocity, acceleration, jerk] = bench.ratios();
        assert!(
            velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001,
            "{velocity} {acceleration} {jerk}"
        );
    }
}

#[test]
fn exact_stops_meet_every_point_and_exact_paths_go_through() {
    let corner = |x: f64, y: f64| [x, y, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let points = [corner(0.0, 0.0), corner(10.0, 0.0), corner(20.0, 0.0), corner(20.0, 5.0)];
    for (ending, stops) in [(BlockEnding::Stop, 3), (BlockEnding::Exact, 2)] {
        let mut bench = Bench::new("ac-trunnion", KinematicsMode::Axes, 0.0);
        let mut program = blocks(&points, 50.0, &bench);
        for block in &mut program {
            block.ending = ending;
        }
        run(&mut bench, &program, |_| (FULL, Plans::InTime));
        check(&bench, &points, 1e-6, "exact");
        let rests = |two: &[Letters]| two[0].map(f64::to_bits) == two[1].map(f64::to_bits);
        let starts = bench.positions.windows(2).collect::<Vec<_>>();
        let begins = starts.windows(2).filter(|two| rests(two[0]) && !rests(two[1])).count();
        assert!(begins <= stops, "{begins}");
        for point in &points[if stops == 3 { 0 } else { 2 }..] {
            let near = |at: &Letters| (at[0] - point[0]).hypot(at[1] - point[1]) < 1e-4;
            assert!(bench.positions.iter().any(near), "{point:?}");
        }
    }
}

#[test]
fn arcs_are_round() {
    let start = [30.0, 0.0, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut end = start;
    end[2] = -305.0;
    for (turns, sign) in [(0, 1.0), (1, 1.0), (-1, 1.0), (0, -1.0)] {
        let shape =
            BlockShape::Arc { center: [10.0, 0.0, -300.0], normal: [0.0, 0.0, sign], turns };
        let mut bench = Bench::new("ac-trunnion", KinematicsMode::Axes, 0.0);
        let block = MotionBlock {
            shape,
            number: 1,
            coordinates: bench.mode.into(),
            tool_length: 0.0,
            ending: BlockEnding::Exact,
            ..line(start, end, 80.0)
        };
        run(&mut bench, &[block], |_| (FULL, Plans::InTime));
        let off = |at: &Letters| ((at[0] - 10.0).hypot(at[1]) - 20.0).abs();
        let worst = bench.positions.iter().map(off).fold(0.0, f64::max);
        let [velocity, acceleration, jerk] = bench.ratios();
        eprintln!(
            "{turns}: {} s, off by {worst}, {velocity} {acceleration} {jerk}",
            moving(&bench)
        );
        assert!(worst < 0.001, "{worst}");
        assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001);
        let length = std::f64::consts::TAU * 20.0 * f64::from(turns.max(0) + 1);
        assert!(moving(&bench) > length / 80.0 && moving(&bench) < length / 80.0 + 0.4);
        // Half way it is on the side to which it turns.
        let early = bench.positions.iter().find(|at| at[1].abs() > 1.0).unwrap();
        assert!(early[1] * sign * if turns < 0 { -1.0 } else { 1.0 } > 0.0);
    }
}

#[test]
fn a_block_out_of_travel_is_refused_and_the_tool_stops_before_it() {
    let mut bench = Bench::new("ac-trunnion", KinematicsMode::ToolCenterPoint, 120.0);
    let mut points = vec![[0.0, 0.0, -300.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0]];
    for x in [50.0, 100.0, 5000.0, 20.0] {
        let mut point = points[0];
        point[0] = x;
        points.push(point);
    }
    let program = blocks(&points, 100.0, &bench);
    run(&mut bench, &program, |_| (FULL, Plans::InTime));
    let fault = bench.servo.fault().unwrap();
    assert_eq!((fault.block, fault.code, fault.axis), (3, 1, 0));
    assert_at(&bench, &points[2]);
    assert!(bench.servo.fault().is_none());
}

#[test]
fn a_letter_without_an_axis_is_refused() {
    let mut bench = Bench::new("ac-trunnion", KinematicsMode::Axes, 0.0);
    let start = [0.0, 0.0, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut end = start;
    end[7] = 1.0;
    let program = blocks(&[start, end], 50.0, &bench);
    run(&mut bench, &program, |_| (FULL, Plans::InTime));
    let fault = bench.servo.fault().unwrap();
    assert_eq!((fault.code, fault.axis), (8, 7));
}

/// Beside a servo loop of a millisecond the thread plans 0.1 mm blocks at 100 mm/s. Prints what both cost.
#[test]
fn the_thread_plans_short_blocks_in_time() {
    let bench = Bench::with(timed_machine(), KinematicsMode::ToolCenterPoint, 0.0);
    let Bench { mut servo, core, .. } = bench;
    let bench = Bench::with(timed_machine(), KinematicsMode::ToolCenterPoint, 0.0);
    let points = pass(0.1);
    let program = blocks(&points, 100.0, &bench);
    let thread = PlannerThread::start(core).unwrap();
    servo.reset(points[0]);
    let mut waiting = program.iter().peekable();
    let begin = Instant::now();
    let mut costs = Vec::new();
    let mut moving = 0_u32;
    for cycle in 1..20_000_u32 {
        let start = Instant::now();
        // Blocks come a little faster than they are run.
        for _ in 0..2 {
            if let Some(block) = waiting.peek()
                && servo.push(block).is_some()
            {
                waiting.next();
            }
        }
        let sample = servo.cycle(FULL);
        costs.push(start.elapsed());
        moving += u32::from(!sample.rests);
        if waiting.peek().is_none() && servo.is_done() {
            break;
        }
        std::thread::sleep((Duration::from_millis(1) * cycle).saturating_sub(begin.elapsed()));
    }
    let seconds = begin.elapsed().as_secs_f64();
    let state = servo.state();
    drop(thread);
    costs.sort();
    eprintln!(
        "moved for {} s of {seconds:.2} s; a cycle costs {:?} in the median, {:?} at most; {state:?}",
        f64::from(moving) * PERIOD,
        costs[costs.len() / 2],
        costs[costs.len() - 1]
    );
    let end = points.last().unwrap();
    assert!(servo.is_done() && (servo.position()[0] - end[0]).abs() < 1e-9);
    assert!(costs[costs.len() / 2] < Duration::from_micros(10));
    // The feed alone takes 2.6 s. Beside other work, or without optimisation, plans come later.
    assert!(f64::from(moving) * PERIOD < 20.0, "{moving}");
}

/// Blocks with a time of their own: the speed may follow the blocks beside it.
#[test]
fn timed_blocks_follow_their_neighbours() {
    let mut seconds = [0.0; 2];
    for (kind, seconds) in [BlockKind::Feed, BlockKind::Timed].into_iter().zip(&mut seconds) {
        let mut bench = Bench::new("ac-trunnion", KinematicsMode::Axes, 0.0);
        let at = |k: u32| [0.5 * f64::from(k), 0.0, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let points: Vec<Letters> = (0..=120).map(at).collect();
        let mut program = blocks(&points, 50.0, &bench);
        // A speed that rises and falls along the blocks.
        for (index, block) in program.iter_mut().enumerate() {
            block.kind = kind;
            block.speed = 30.0 + 20.0 * (0.3 * index as f64).sin();
        }
        run(&mut bench, &program, |_| (FULL, Plans::InTime));
        check(&bench, &points, 1e-6, "timed");
        *seconds = moving(&bench);
        let nominal: f64 = program.iter().map(|block| 0.5 / block.speed).sum();
        assert!(*seconds > 0.9 * nominal && *seconds < 1.15 * nominal, "{seconds} {nominal}");
    }
    assert!(seconds[1] < seconds[0], "{seconds:?}");
}

/// A descent from rest onto slow blocks, as in a posted program: it takes its time only where it is faster than its mean
/// speed between both.
#[test]
fn a_timed_block_from_rest_takes_its_time() {
    const SECONDS: f64 = 0.4457;
    let mut bench = Bench::new("bc-trunnion", KinematicsMode::ToolCenterPoint, 120.0);
    let at = |z: f64| [-400.0, -254.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let slow = (0..=40).map(|k| at(-260.5 - 0.5 * f64::from(k)));
    let points: Vec<Letters> = std::iter::once(at(-200.0)).chain(slow).collect();
    let mut program = blocks(&points, 10.0, &bench);
    for block in &mut program {
        block.kind = BlockKind::Timed;
    }
    program[0].speed = 60.5 / SECONDS;
    run(&mut bench, &program, |_| (FULL, Plans::InTime));
    check(&bench, &points, 1e-6, "descent");
    let (seconds, nominal) = (moving(&bench), SECONDS + 40.0 * 0.05);
    // Half of a ramp at the end is lost, where it is known late that nothing follows.
    assert!(seconds > nominal && seconds < 1.06 * nominal, "{seconds} {nominal}");
}

/// A block between two stops that is slow enough for its ramps takes its time, no less.
#[test]
fn a_timed_block_is_not_quicker_than_its_time() {
    for (length, seconds) in [(10.0, 0.5), (30.0, 0.6), (2.0, 3.0)] {
        let mut bench = Bench::new("bc-trunnion", KinematicsMode::Axes, 0.0);
        let at = |x: f64| [x, -254.0, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let points = [at(-400.0), at(-400.0 + length)];
        let mut program = blocks(&points, length / seconds, &bench);
        program[0].kind = BlockKind::Timed;
        run(&mut bench, &program, |_| (FULL, Plans::InTime));
        check(&bench, &points, 1e-6, "timed");
        let took = moving(&bench);
        // That nothing comes behind it is known only late: of the stop's ramp half may be lost.
        assert!(took > 0.999 * seconds && took < 1.1 * seconds, "{took} {seconds}");
    }
}
