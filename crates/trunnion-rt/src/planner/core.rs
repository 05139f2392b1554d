//! The planning side, turn by turn: takes blocks, plans, offers pieces.

use super::block::MotionBlock;
use super::pieces;
use super::shared::{PlanOffer, PlannerFault, Shared};
use crate::kinematics::MachineKinematics;
use crate::refusal::{Refusal, RefusalCode};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use trunnion::feed::{Limits, SpeedOverrides, StreamStep};
use trunnion::nc::read::AxisWords;
use trunnion::nc::write::WordsError;
use trunnion::program_motion::{
    PlanLimit, ProgramRun, RunFault, WordJoints, WordsFault, planned_limits,
};
use trunnion::types::AXES;

/// Plan time that is committed ahead of the servo thread \[s\]: a change of override, hold or abort is felt after it.
const HORIZON: f64 = 0.03;

/// Plan time that stays committed when the plan is made anew: a multiple of the time that planning took of late, and at most this \[s\].
const MARGIN: f64 = 1.6;
const LONGEST_HORIZON: f64 = 0.4;
/// A plan takes this long until it is known better \[s\].
const FIRST_PLANNING: f64 = 0.06;

/// Plans that the ring of pieces holds at least: none is longer than its share.
const PLANS_IN_RING: usize = 4;

/// Share of the longest time that is kept from plan to plan.
const FORGET: f64 = 0.95;

/// Plan time before the tool slows down for the end of the plan from which the plan is made anew, besides the time that this
/// takes \[s\]. Until then more of the path may come: few long plans cost less than many short ones.
const CALM: f64 = 0.1;

/// Share of the largest speed of a plan below which the tool slows down for its end.
const FAST: f64 = 0.9;

/// Time without a new block after which the blocks at hand are run to their end \[s\].
const PATIENCE: f64 = 0.02;

/// Plan time left at which a path without further blocks is ended \[s\].
const SHORT: f64 = 0.12;

/// Blocks taken in a turn.
const MOST_BLOCKS: usize = 64;

/// Smallest override beside a hold.
const SMALLEST_OVERRIDE: f64 = 1e-3;

/// Time between two changes of the override \[s\]: a plan for each would cost more than it brings.
const OVERRIDE_PERIOD: f64 = 0.02;

/// Options of a planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannerOptions {
    /// Number of blocks that fit into the queue.
    pub blocks: usize,
    /// Number of pieces that fit into the ring.
    pub pieces: usize,
    /// Largest deviation of the rotaries where a corner is rounded \[rad\].
    pub axis_tolerance: f64,
}

impl PlannerOptions {
    /// A queue as long as that of `LinuxCNC`, and 0.1 degrees.
    pub const STANDARD: Self =
        Self { blocks: 2048, pieces: 32768, axis_tolerance: 0.1 * std::f64::consts::PI / 180.0 };
}

/// Step of the plan that the servo thread has, not committed yet.
#[derive(Debug, Clone, Copy)]
struct ExpectedStep {
    /// End and duration, bit by bit: a plan that was not made again has the same.
    key: [u64; 2],
    end: f64,
    pieces: usize,
    duration: f64,
    /// The speed does not come near to the largest one of the plan any more.
    slows: bool,
}

/// The plan as the servo thread has it.
#[derive(Debug, Default)]
struct PlayedPlan {
    /// Next free slot, and the end of the plan.
    free: usize,
    end: usize,
    /// Piece at which the committed plan ends, and plan time there \[s\].
    committed: usize,
    time: f64,
    /// Steps behind it, down to rest.
    expected: VecDeque<ExpectedStep>,
    /// Path parameter at which it rests.
    rest: f64,
    offer: Option<WaitingOffer>,
    offers: u32,
}

/// Offer without an answer.
#[derive(Debug)]
struct WaitingOffer {
    offer: PlanOffer,
    steps: VecDeque<ExpectedStep>,
}

/// Planner of a machine. [`PlannerCore::turn`] does a bit of work, and may be called from any one thread.
#[derive(Debug)]
pub struct PlannerCore {
    shared: Arc<Shared>,
    joints: WordJoints,
    limits: Limits<AXES>,
    run: Option<ProgramRun>,
    /// Block that begins the next run.
    waiting: Option<MotionBlock>,
    plan: PlayedPlan,
    round: u32,
    aborts: u32,
    /// Blocks taken in this round.
    taken: u32,
    /// A block was refused: what follows is not run.
    faulted: bool,
    /// The run goes on from where the servo thread rests.
    recovering: bool,
    /// Another override waits for its plan.
    overridden: bool,
    last_block: f64,
    overrides: Option<[f64; 2]>,
    last_override: f64,
    /// Time that a plan takes \[s\].
    planning: f64,
}

impl PlannerCore {
    pub(super) fn new(
        shared: Arc<Shared>,
        kinematics: &MachineKinematics,
    ) -> Result<Self, WordsError> {
        let machine = kinematics.machine();
        let letters = AxisWords::of(machine)?.0.map(|word| word.letter);
        Ok(Self {
            shared,
            joints: WordJoints::new(kinematics.bare().clone(), letters),
            limits: planned_limits(machine),
            run: None,
            waiting: None,
            plan: PlayedPlan::default(),
            round: 0,
            aborts: 0,
            taken: 0,
            faulted: false,
            recovering: false,
            overridden: false,
            last_block: f64::NEG_INFINITY,
            overrides: None,
            last_override: f64::NEG_INFINITY,
            planning: FIRST_PLANNING,
        })
    }

    /// Does what is due now. The caller's clock \[s\] also measures how long planning takes.
    pub fn turn(&mut self, clock: &mut dyn FnMut() -> f64) {
        let now = clock();
        if self.shared.round.load(Ordering::Acquire) != self.round {
            self.reset();
        }
        if self.settle_offer() && self.recover() {
            self.take_blocks(now);
            self.follow_overrides(now);
            self.plan(now, clock);
        }
        let ahead = self.plan.time + self.tail() - self.shared.played.get();
        self.shared.ahead.set(ahead.max(0.0));
        if ahead <= 0.0 {
            self.shared.limit.store(PlanLimit::None.number(), Ordering::Relaxed);
        }
    }

    /// Notes the time that a turn took \[s\].
    pub fn note(&self, duration: f64) {
        self.shared.worked.set(self.shared.worked.get() + duration);
        self.shared.longest_turn.set(self.shared.longest_turn.get().max(duration));
    }

    /// Begins a round at rest.
    fn reset(&mut self) {
        self.round = self.shared.round.load(Ordering::Acquire);
        let offers = self.plan.offers;
        self.plan = PlayedPlan { offers, ..PlayedPlan::default() };
        (self.run, self.waiting, self.taken) = (None, None, 0);
        (self.faulted, self.recovering) = (false, false);
        self.aborts = self.shared.aborts.load(Ordering::Acquire);
        self.shared.planned_aborts.store(self.aborts, Ordering::Release);
        self.shared.finished.store(0, Ordering::Release);
        self.shared.planned_round.store(self.round, Ordering::Release);
    }

    /// Plan time behind what is committed \[s\].
    fn tail(&self) -> f64 {
        self.plan.expected.iter().map(|step| step.duration).sum()
    }

    /// Reads the answer to an offer; false while there is none.
    fn settle_offer(&mut self) -> bool {
        let Some(waiting) = self.plan.offer.take() else { return true };
        let answer = self.shared.answer.load(Ordering::Acquire);
        if answer / 2 != u64::from(waiting.offer.number) {
            self.plan.offer = Some(waiting);
            return false;
        }
        if answer % 2 == 1 {
            let WaitingOffer { offer, steps } = waiting;
            self.plan.committed = offer.first;
            self.plan.end = offer.end;
            self.plan.rest = steps.back().map_or(self.plan.rest, |step| step.end);
            self.plan.expected = steps;
        } else {
            // The servo thread was past that place: it runs the old plan to its rest.
            self.shared.late.fetch_add(1, Ordering::Relaxed);
            self.recovering = true;
        }
        true
    }

    /// Commits the step that the stream has taken.
    fn commit_first(&mut self) {
        if let Some(step) = self.plan.expected.pop_front() {
            self.plan.committed += step.pieces;
            self.plan.time += step.duration;
        }
    }

    /// Begins again where the servo thread rests; false while it does not.
    fn recover(&mut self) -> bool {
        if !self.recovering {
            return true;
        }
        if self.shared.cursor.load(Ordering::Acquire) != self.plan.end {
            return false;
        }
        self.recovering = false;
        self.plan.expected.clear();
        self.plan.committed = self.plan.end;
        self.plan.time = self.shared.played.get();
        self.overrides = None;
        let rest = self.plan.rest;
        if let Some(run) = &mut self.run
            && run.restart(rest).is_err()
        {
            self.refuse(0, RefusalCode::Internal);
        }
        true
    }

    fn is_aborting(&self) -> bool {
        self.shared.aborts.load(Ordering::Acquire) != self.aborts
    }

    /// Takes blocks from the queue.
    fn take_blocks(&mut self, now: f64) {
        for _ in 0..MOST_BLOCKS {
            if self.run.as_ref().is_some_and(ProgramRun::is_full) {
                return;
            }
            let Some(block) = self.next_block(now) else { return };
            if self.faulted || self.is_aborting() {
                continue;
            }
            if let Some(block) = self.take(block) {
                self.waiting = Some(block);
                return;
            }
        }
    }

    fn next_block(&mut self, now: f64) -> Option<MotionBlock> {
        if let Some(block) = self.waiting.take() {
            return Some(block);
        }
        loop {
            let (block, round): (MotionBlock, u32) = self.shared.blocks.take()?;
            if round == self.round {
                self.taken += 1;
                self.last_block = now;
                return Some(block);
            }
            // A block of a round that was not seen yet begins it; older ones are forgotten.
            if round == self.shared.round.load(Ordering::Acquire) {
                self.reset();
                (self.taken, self.last_block) = (1, now);
                return Some(block);
            }
        }
    }

    /// Hands a block to the run; returns it if the run has to end first.
    fn take(&mut self, block: MotionBlock) -> Option<MotionBlock> {
        if self.run.is_none() && !self.begin_run(&block) {
            return None;
        }
        let run = self.run.as_mut()?;
        match run.take(&block) {
            Ok(true) => None,
            Ok(false) => {
                run.end();
                Some(block)
            }
            Err(fault) => {
                run.end();
                self.report(block.number, fault);
                None
            }
        }
    }

    /// Begins a run with the kinematics of a block.
    fn begin_run(&mut self, block: &MotionBlock) -> bool {
        let tolerance = self.shared.axis_tolerance.get();
        let begun = self.joints.set(block.coordinates, block.tool_length).is_ok();
        let run = ProgramRun::new(self.joints.clone(), &self.limits, tolerance);
        match run {
            Ok(run) if begun => {
                self.run = Some(run);
                self.overrides = None;
                self.plan.rest = 0.0;
                true
            }
            _ => {
                self.refuse(block.number, RefusalCode::Internal);
                false
            }
        }
    }

    fn report(&mut self, block: u32, fault: WordsFault) {
        let fault = match fault {
            WordsFault::Refused(refusal) => Refusal::from(refusal),
            WordsFault::NoAxis { letter } => {
                Refusal { axis: Some(letter), ..Refusal::new(RefusalCode::NoAxis) }
            }
            _ => Refusal::new(RefusalCode::Internal),
        };
        self.send(PlannerFault {
            block,
            code: fault.code as i32,
            axis: fault.axis.and_then(|axis| i32::try_from(axis).ok()).unwrap_or(-1),
            excess: fault.excess,
        });
    }

    fn refuse(&mut self, block: u32, code: RefusalCode) {
        self.send(PlannerFault { block, code: code as i32, axis: -1, excess: 0.0 });
    }

    fn send(&mut self, fault: PlannerFault) {
        if !self.faulted {
            self.faulted = true;
            // With a queue of faults that nobody reads nothing is left to say.
            let _ = self.shared.faults.send(&(fault, self.round));
        }
    }

    /// Hands overrides and aborts to the plan.
    fn follow_overrides(&mut self, now: f64) {
        let Some(run) = &mut self.run else { return };
        let aborting = self.shared.aborts.load(Ordering::Acquire) != self.aborts;
        let [feed, rapid] = [self.shared.feed.get(), self.shared.rapid.get()];
        let holds = aborting || !(feed > 0.0 && rapid > 0.0);
        let wanted = if holds { [0.0; 2] } else { [feed.min(2.0), rapid.min(1.0)] };
        let wanted = if holds { wanted } else { wanted.map(|one| one.max(SMALLEST_OVERRIDE)) };
        let bits = |values: [f64; 2]| values.map(f64::to_bits);
        let same = self.overrides.is_some_and(|now| bits(now) == bits(wanted));
        let soon = !holds && self.overrides.is_some() && now - self.last_override < OVERRIDE_PERIOD;
        if same || soon {
            return;
        }
        (self.overrides, self.last_override) = (Some(wanted), now);
        let [feed, tip] = wanted;
        let stream = run.stream();
        let set = if holds {
            stream.set_override(0.0)
        } else {
            stream.set_speed_overrides(SpeedOverrides { feed, tip })
        };
        self.overridden = true;
        if set.is_err() {
            self.refuse(0, RefusalCode::Internal);
        }
    }

    /// Plans what is due, and commits what the servo thread needs.
    fn plan(&mut self, now: f64, clock: &mut dyn FnMut() -> f64) {
        let aborting = self.is_aborting();
        if self.run.is_some() && self.feed(now) {
            self.commit(HORIZON);
            self.plan_due(now, clock);
            if self.plan.offer.is_none() {
                if aborting {
                    self.commit(f64::INFINITY);
                }
                self.finish_run(aborting);
                self.give_up();
            }
        }
        if self.run.is_none() && self.waiting.is_none() {
            self.finish(aborting);
        }
    }

    /// Plans if it is time to. As long as that takes the servo thread lives on what is committed.
    fn plan_due(&mut self, now: f64, clock: &mut dyn FnMut() -> f64) {
        let is_due = self.run.as_mut().is_some_and(|run| run.stream().is_due());
        if !is_due || !self.has_room() || self.may_wait(now) {
            return;
        }
        self.overridden = false;
        self.commit((MARGIN * self.planning).clamp(HORIZON, LONGEST_HORIZON));
        let Some(run) = &mut self.run else { return };
        let begin = clock();
        run.stream().plan_ahead();
        // The longest of late, which is forgotten slowly.
        self.planning = (clock() - begin).max(FORGET * self.planning);
        let steps = run.stream().uncommitted();
        let expected = &self.plan.expected;
        let known = steps.iter().zip(expected).all(|(step, next)| key_of(step) == next.key);
        if steps.len() != expected.len() || !known {
            self.offer(&steps);
        }
    }

    /// True if more of the path comes before the plan has to be made anew.
    fn may_wait(&self, now: f64) -> bool {
        let idle = now - self.last_block > PATIENCE;
        let known = self.run.as_ref().is_none_or(|run| run.is_finished() || run.is_full());
        if idle || known || self.overridden || self.plan.expected.is_empty() {
            return false;
        }
        let steady = self.plan.expected.iter().take_while(|step| !step.slows);
        let left = self.plan.time - self.shared.played.get();
        left + steady.map(|step| step.duration).sum::<f64>() > CALM + MARGIN * self.planning
    }

    /// True if a plan fits into the ring without touching a piece that the servo thread may still play: it is at `cursor`
    /// or behind, in one of the plans that it has taken.
    fn has_room(&self) -> bool {
        let all = self.shared.pieces.len();
        let used = self.plan.free.saturating_sub(self.shared.cursor.load(Ordering::Acquire));
        used + all / PLANS_IN_RING <= all
    }

    /// Gives a run up that has path left and no plan for it. A plan that only waits for room is still to come.
    fn give_up(&mut self) {
        if !self.has_room() {
            return;
        }
        let Some(run) = &mut self.run else { return };
        let stuck = self.plan.offer.is_none() && self.plan.expected.is_empty();
        if stuck && run.stream().is_due() {
            let block = run.block();
            self.run = None;
            self.refuse(block, RefusalCode::Internal);
        }
    }

    /// Commits so much of the plan that it reaches `horizon` \[s\] ahead of the servo thread.
    fn commit(&mut self, horizon: f64) {
        while self.plan.time - self.shared.played.get() < horizon {
            let Some(run) = &mut self.run else { return };
            let Some(step) = run.stream().next_planned() else { return };
            run.forget(step.s.low);
            let limit = run.binding(&step, self.overrides.unwrap_or([1.0; 2])).number();
            self.shared.limit.store(limit, Ordering::Relaxed);
            self.commit_first();
        }
    }

    /// Ends a run that rests with nothing left to plan.
    fn finish_run(&mut self, aborting: bool) {
        let Some(run) = &mut self.run else { return };
        let rests = self.plan.expected.is_empty() && !run.stream().is_due();
        if rests {
            self.finish(aborting);
        }
    }

    /// Hands the path to the stream as far as it is known; false where it is better to wait for more of it.
    fn feed(&mut self, now: f64) -> bool {
        let idle = now - self.last_block > PATIENCE && self.waiting.is_none();
        let left = self.plan.time + self.tail() - self.shared.played.get();
        let aborting = self.is_aborting();
        let Some(run) = &mut self.run else { return false };
        match run.feed() {
            Ok(true) if idle && left < SHORT => {
                run.end();
                self.feed(now)
            }
            Ok(true) => run.may_begin() || run.stream().speed() > 0.0 || left > 0.0 || aborting,
            Ok(false) => true,
            Err(RunFault { block, .. }) => {
                self.refuse(block, RefusalCode::Internal);
                self.run = None;
                false
            }
        }
    }

    /// Offers the plan from what is committed on.
    fn offer(&mut self, steps: &[StreamStep]) {
        let Some(run) = &mut self.run else { return };
        let mut pieces = Vec::new();
        let mut expected = VecDeque::with_capacity(steps.len());
        // The ring holds several plans: the servo thread may still be in one before.
        let most = self.shared.pieces.len() / (PLANS_IN_RING * steps.len().max(1));
        let fastest = steps.iter().map(|step| step.speed.start).fold(0.0, f64::max);
        let is_fast = |step: &StreamStep| step.speed.start >= FAST * fastest;
        let falls = steps.iter().rposition(is_fast).map_or(0, |last| last + 1);
        for (index, step) in steps.iter().enumerate() {
            let before = pieces.len();
            if let Some(nodes) = run.nodes_of(step) {
                pieces::append(step, nodes, most, &mut pieces);
            }
            let duration = pieces[before..].iter().map(|piece| piece.duration).sum();
            let pieces = pieces.len() - before;
            let (key, end) = (key_of(step), step.s.high);
            let slows = index >= falls;
            expected.push_back(ExpectedStep { key, end, pieces, duration, slows });
        }
        let first = self.plan.free;
        for (index, piece) in pieces.iter().enumerate() {
            self.shared.pieces.store(first + index, piece);
        }
        self.plan.free += pieces.len();
        self.plan.offers = self.plan.offers.wrapping_add(1);
        let offer = PlanOffer {
            number: self.plan.offers,
            round: self.round,
            replaces: self.plan.committed,
            first,
            end: self.plan.free,
        };
        // The queue of offers has room: the servo thread has answered all that came before.
        let _ = self.shared.offers.send(&offer);
        self.plan.offer = Some(WaitingOffer { offer, steps: expected });
    }

    /// Notes what rests: a run at its end, an abort.
    fn finish(&mut self, aborting: bool) {
        let ended = self.run.as_mut().is_none_or(|run| {
            let rests = !run.stream().held();
            run.is_finished() && rests
        });
        if aborting {
            self.run = None;
            self.waiting = None;
            while self.next_block(f64::NEG_INFINITY).is_some() {}
            self.faulted = false;
            self.aborts = self.shared.aborts.load(Ordering::Acquire);
        } else if ended {
            self.run = None;
        } else {
            return;
        }
        if self.waiting.is_none() {
            self.shared.finished.store(self.taken, Ordering::Release);
        }
        if aborting {
            self.shared.planned_aborts.store(self.aborts, Ordering::Release);
        }
    }
}

fn key_of(step: &StreamStep) -> [u64; 2] {
    [step.s.high.to_bits(), step.duration.to_bits()]
}
