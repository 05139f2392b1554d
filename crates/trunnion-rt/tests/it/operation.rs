//! Random programs under random operators, over many cycles in virtual time: no limit of a joint is ever broken, and the
//! tip stays within P of the program.
//!
//! A million cycles, and ten times as many with `TRUNNION_TORTURE`. Both sides of the planner run in one thread, so that a
//! seed always gives the same motion.

use crate::observer::{Findings, Observer};
use crate::random_programs::{program, stand};
use crate::walk::Dice;
use std::time::Instant;
use trunnion::types::AxisVector;
use trunnion_rt::planner::{
    MotionBlock, PlannerCore, PlannerOptions, PlannerServo, ServoSample, ServoSpeeds, planner,
};
use trunnion_rt::{MachineKinematics, machine_named};

const PERIOD: f64 = 0.001;

/// Cycles of all tests of this file together.
const CYCLES: u64 = 1_000_000;

/// Cycles of one seed.
const LIFE: u64 = 25_000;

/// Ratio to a limit that counts as kept: the sampled third difference of the cycles around a step of the jerk.
const KEPT: f64 = 1.001;

/// Cycles in which a program that nobody disturbs must have come further.
const PATIENCE: u64 = 300_000;

/// State of the operator and of all that is late.
#[derive(Debug)]
struct Operator {
    speeds: ServoSpeeds,
    /// Cycles until a hold ends; single steps end at the next block.
    hold: u64,
    steps: u32,
    seen: u32,
    /// Cycles for which the interpreter sends nothing, and the planning thread does not run.
    starved: u64,
    late: u64,
    /// Time that a plan takes \[s\].
    planning: f64,
}

impl Operator {
    fn new() -> Self {
        let speeds = ServoSpeeds { feed: 1.0, rapid: 1.0 };
        Self { speeds, hold: 0, steps: 0, seen: 0, starved: 0, late: 0, planning: 0.002 }
    }

    /// Does something now and then. Returns true for an abort.
    fn act(&mut self, dice: &mut Dice, block: u32) -> bool {
        for time in [&mut self.hold, &mut self.starved, &mut self.late] {
            *time = time.saturating_sub(1);
        }
        if self.steps > 0 && block != self.seen {
            self.steps -= 1;
            self.hold = 200;
        }
        self.seen = block;
        if dice.unit() > 0.004 {
            return false;
        }
        let length = |dice: &mut Dice, most: usize| 1 + dice.below(most) as u64;
        match dice.below(16) {
            0 => self.hold = length(dice, 700),
            1 => (self.steps, self.hold) = (1 + u32::try_from(dice.below(4)).unwrap(), 150),
            2 => self.starved = length(dice, 500),
            3 => self.late = length(dice, 400),
            4 => self.planning = 10.0_f64.powf(dice.between(-3.5, -0.6)),
            5 => return dice.unit() < 0.3,
            6..=9 => self.speeds.feed = [0.05, 0.3, 0.8, 1.3, 2.0][dice.below(5)],
            10 => self.speeds.rapid = [0.1, 0.5, 1.0][dice.below(3)],
            _ => self.speeds = ServoSpeeds { feed: 1.0, rapid: 1.0 },
        }
        false
    }

    fn speeds(&self) -> ServoSpeeds {
        if self.hold > 0 { ServoSpeeds { feed: 0.0, rapid: 0.0 } } else { self.speeds }
    }
}

/// Both sides of a planner under an operator, watched.
struct Shop {
    servo: PlannerServo,
    core: PlannerCore,
    kinematics: MachineKinematics,
    observer: Observer,
    operator: Operator,
    dice: Dice,
    cycle: u64,
    joints: AxisVector,
    /// Programs that were run to their end, aborted and refused.
    outcomes: [u32; 3],
}

impl Shop {
    fn new(machine: &str, seed: u64) -> Self {
        let kinematics = machine_named(machine).unwrap();
        let options = PlannerOptions { pieces: 4096, ..PlannerOptions::STANDARD };
        let (servo, core) = planner(&kinematics, options, PERIOD).unwrap();
        let joints = kinematics.machine().vector(|axis| {
            let [low, high] = axis.limits.ends();
            if axis.cyclic { 0.3 } else { low + 0.45 * (high - low) }
        });
        Self {
            servo,
            core,
            observer: Observer::new(&kinematics, PERIOD),
            kinematics,
            operator: Operator::new(),
            dice: Dice::new(seed),
            cycle: 0,
            joints,
            outcomes: [0; 3],
        }
    }

    /// One servo cycle, and a turn of the planner unless the system keeps it off.
    fn cycle(&mut self) -> ServoSample {
        self.cycle += 1;
        if self.operator.late == 0 {
            let planning = self.operator.planning;
            let mut now = self.cycle as f64 * PERIOD - planning;
            self.core.turn(&mut || {
                now += planning;
                now
            });
        }
        let sample = self.servo.cycle(self.operator.speeds());
        self.observer.watch(&sample);
        sample
    }

    /// Runs one program to its end, to an abort, or to a block that is refused.
    fn run(&mut self) {
        let stand = stand(&mut self.dice, &self.kinematics, &self.joints);
        let blocks = program(&mut self.dice, &self.kinematics, stand);
        self.observer.begin(&blocks);
        self.servo.reset(stand.letters);
        let (mut sent, mut last, begin) = (0, 0, self.cycle);
        while sent < blocks.len() || !self.servo.is_done() {
            assert!(self.cycle - begin < PATIENCE, "the program does not end: {:?}", self.operator);
            for _ in 0..=self.dice.below(3) {
                let starved = self.operator.starved > 0;
                if !starved && sent < blocks.len() && self.servo.push(&blocks[sent]).is_some() {
                    sent += 1;
                }
            }
            last = self.cycle().block.max(last);
            if self.operator.act(&mut self.dice, last) && sent > 0 {
                self.servo.abort();
                break;
            }
        }
        self.end(&blocks);
    }

    /// Waits for the end of an abort, and notes where the machine stands.
    fn end(&mut self, blocks: &[MotionBlock]) {
        let aborted = self.servo.is_aborting();
        let begin = self.cycle;
        while self.servo.is_aborting() {
            assert!(self.cycle - begin < 5000, "the abort does not end: {:?}", self.operator);
            self.operator.late = self.operator.late.saturating_sub(1);
            self.cycle();
        }
        let refused = self.servo.fault();
        let here = self.servo.position();
        if aborted {
            self.outcomes[1] += 1;
        } else if let Some(fault) = refused {
            assert_eq!(fault.code, 1, "only travel is refused: {fault:?}");
            self.outcomes[2] += 1;
        } else {
            self.outcomes[0] += 1;
            let end = blocks.last().unwrap().end;
            let close = here.iter().zip(&end).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(close, "{here:?} {end:?}");
        }
        self.joints = self.observer.joints(&here);
    }
}

/// Runs programs on a machine for so many cycles.
fn operate(machine: &str, seed: u64, cycles: u64) -> Findings {
    let begin = Instant::now();
    let mut shop = Shop::new(machine, seed);
    while shop.cycle < cycles {
        shop.run();
    }
    let (findings, outcomes) = (shop.observer.findings, shop.outcomes);
    eprintln!(
        "{machine} {seed}: {outcomes:?} programs ended, aborted, refused; {findings:.4?}; {:.1} s",
        begin.elapsed().as_secs_f64()
    );
    findings
}

/// Share of the cycles that each of the tests below has.
fn share() -> u64 {
    let torture = std::env::var_os("TRUNNION_TORTURE").is_some();
    (if torture { 10 * CYCLES } else { CYCLES }) / 4
}

fn keeps_limits(machine: &str, number: u64) {
    let seed = std::env::var("TRUNNION_TORTURE_SEED").ok().and_then(|seed| seed.parse().ok());
    let mut seed = seed.unwrap_or(0) + 1000 * number;
    let mut all = Findings::default();
    // Each seed is a life of its own: what goes wrong does so soon after its start again.
    while all.cycles < share() {
        all = all.max(operate(machine, seed, LIFE.min(share() - all.cycles)));
        seed += 1;
    }
    eprintln!("{machine}: {all:.4?}");
    assert!(all.moving > all.cycles / 3, "{all:?}");
    assert!(all.rates.iter().all(|ratio| *ratio <= KEPT), "{all:?}");
    assert!(all.contour <= 1.0, "{all:?}");
}

#[test]
fn a_table_with_two_rotaries_keeps_limits_and_contour() {
    keeps_limits("ac-trunnion", 1);
}

#[test]
fn a_table_that_tilts_about_y_keeps_limits_and_contour() {
    keeps_limits("bc-trunnion", 2);
}

#[test]
fn a_fork_head_keeps_limits_and_contour() {
    keeps_limits("gantry-ca-fork", 3);
}

#[test]
fn a_table_and_a_head_keep_limits_and_contour() {
    keeps_limits("layout-33-ca-table-head", 4);
}
