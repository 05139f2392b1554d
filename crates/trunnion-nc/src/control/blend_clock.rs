//! Time of blocks on `LinuxCNC` 2.9, cycle by cycle of its trajectory planner.
//!
//! Where a rotary axis moves in one of two blocks, the planner joins them by a parabolic blend: it begins to accelerate along
//! the second block when it begins to decelerate along the first, each with half of the acceleration that the axes allow,
//! and every block is planned to end at rest. It knows of no further block, so that short blocks are slow. Measured on
//! the real control; see `docs/sources.md`, control model.

use crate::math;
use nalgebra::UnitVector3;

/// One block as the trajectory planner takes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockedBlock {
    /// Length along X, Y and Z \[mm\], or along the rotaries where these stand \[rad\].
    pub length: f64,
    /// Largest velocity by the feed and the axes, along that length \[1/s\].
    pub velocity: f64,
    /// Largest acceleration by the axes, along that length \[1/s²\].
    pub acceleration: f64,
    /// Directions of X, Y and Z at the start and at the end; `None` where they stand.
    pub directions: Option<[UnitVector3<f64>; 2]>,
    /// Axes that move.
    pub kind: ClockedKind,
}

/// Axes that move in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockedKind {
    /// X, Y and Z alone: the planner looks ahead over such blocks.
    Linear,
    /// Rotary axes as well.
    Rotary,
}

/// Distance from the path that the planner may keep at corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BlendTolerance {
    /// `G64 P` \[mm\].
    Within(f64),
    /// `G64`: none.
    Unbounded,
    /// `G61`: it stops after every block.
    Stop,
}

/// Clock of a program on `LinuxCNC` 2.9.
///
/// # Example
///
/// Blocks of 1 mm in which a rotary moves, at 5000 mm/s²: one every `sqrt(2 L / a)` = 20 ms, whatever the feed.
///
/// ```
/// use trunnion_nc::control::{BlendClock, BlendTolerance, ClockedBlock, ClockedKind};
///
/// let mut clock = BlendClock::new(0.001);
/// let block = ClockedBlock {
///     length: 1.0,
///     velocity: 500.0,
///     acceleration: 5000.0,
///     directions: None,
///     kind: ClockedKind::Rotary,
/// };
/// for _ in 0..100 {
///     clock.push(block, BlendTolerance::Unbounded);
/// }
/// clock.stop();
/// assert!((clock.seconds() - 2.02).abs() < 0.01);
/// ```
#[derive(Debug, Clone)]
pub struct BlendClock {
    /// Servo period \[s\].
    period: f64,
    /// Cycles so far, and time that belongs to no cycle \[s\].
    cycles: u64,
    rest: f64,
    /// The block that runs; it waits for the next one, which decides how it ends.
    current: Option<RunningBlock>,
}

/// Cosine below which two blocks without rotaries meet at a corner; above it the planner passes without slowing down:
/// 15 degrees.
const STRAIGHT_ON: f64 = 0.966;
/// Distance from the end at which a block is complete, over its length.
const COMPLETE: f64 = 1e-9;
/// Cosine below which a path turns back: no arc fits into such a corner, of 175 degrees and more.
const TURNS_BACK: f64 = -0.996;
/// Share of the acceleration that is left for the direction on an arc: sqrt(3) / 2, as measured.
const ARC_SHARE: f64 = 0.866;
/// Share of a block that the arc at one of its ends may replace.
const ARC_REACH: f64 = 0.5;
/// Least cosine in the velocity of a blend, so that a straight line has no infinite one.
const LEAST_COSINE: f64 = 1e-6;

/// A block that runs or waits to run.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RunningBlock {
    block: ClockedBlock,
    tolerance: BlendTolerance,
    /// Acceleration that it may take: half where it blends on either side.
    acceleration: f64,
    velocity: f64,
    travelled: f64,
    /// It decelerates to its end.
    slows_down: bool,
    /// Velocity at its end: zero, or that on the arc behind it.
    leaves: f64,
    /// Length of the last block, where several are joined \[mm\].
    last: f64,
}

impl RunningBlock {
    fn new(block: ClockedBlock, tolerance: BlendTolerance) -> Self {
        let acceleration = block.acceleration;
        Self {
            block,
            tolerance,
            acceleration,
            velocity: 0.0,
            travelled: 0.0,
            slows_down: false,
            leaves: 0.0,
            last: block.length,
        }
    }

    fn left(&self) -> f64 {
        self.block.length - self.travelled
    }

    /// Largest velocity between two stops: half of the length to speed up, half to slow down.
    fn reached(&self) -> f64 {
        self.block.velocity.min((self.acceleration * self.block.length).sqrt())
    }

    /// Runs one cycle towards a velocity, so that the block still can end at rest.
    fn step(&mut self, target: f64, period: f64) {
        let gain = self.acceleration * period;
        // v: after this cycle at mean velocity (v + v0) / 2, the rest of the way suffices to stop:
        // (v² - v1²) / (2 a) = left - (v + v0) T / 2, with v1 at the end.
        let half = 0.5 * gain;
        let end = self.leaves * self.leaves;
        let way = 2.0 * self.left() - self.velocity * period;
        let square = self.acceleration * way + half * half + end;
        let most = if square > half * half { square.sqrt() - half } else { 0.0 };
        let before = self.velocity;
        if before <= 0.0 && most <= 0.0 {
            // Less is left than the ramp of a cycle resolves: no further cycle would move.
            self.travelled = self.block.length;
        }
        let change = (most.min(target) - before).clamp(-gain, gain);
        self.slows_down = most <= target && change < 0.0;
        self.velocity = (before + change).max(0.0);
        let way = 0.5 * (before + self.velocity) * period;
        self.travelled = (self.travelled + way).min(self.block.length);
    }

    /// Cycles that it runs on at an unchanged velocity before it has to slow down.
    fn cruise(&self, period: f64) -> f64 {
        if (self.velocity - self.block.velocity).abs() > 0.0 || self.velocity <= 0.0 {
            return 0.0;
        }
        let way = self.velocity * period;
        // Two cycles remain for the transition.
        let free = self.left() - 0.5 * self.velocity * self.velocity / self.acceleration;
        (free / way - 2.0).floor().max(0.0)
    }

    /// Returns true if it ends within the next cycle at the deceleration that leads to rest.
    fn ends_within(&self, period: f64) -> bool {
        let left = self.left();
        // The mean velocity of that cycle: from the present one to that at the end.
        let mean = 0.5 * (self.velocity + self.leaves.min(self.velocity));
        left <= COMPLETE * self.block.length || left < mean * period
    }
}

impl BlendClock {
    /// Starts at a standstill; `period` is that of the servo thread \[s\].
    pub fn new(period: f64) -> Self {
        Self { period, cycles: 0, rest: 0.0, current: None }
    }

    /// Takes in the next block; one without length or limits takes no time.
    pub fn push(&mut self, block: ClockedBlock, tolerance: BlendTolerance) {
        let usable = |value: f64| value > 0.0 && value.is_finite();
        let cycle = block.velocity * self.period / block.length;
        if ![block.length, block.velocity, block.acceleration, cycle].into_iter().all(usable) {
            return;
        }
        let mut next = RunningBlock::new(block, tolerance);
        let Some(mut current) = self.current.take() else {
            self.current = Some(next);
            return;
        };
        if current.tolerance == BlendTolerance::Stop {
            self.run_to_rest(current);
        } else if goes_straight_on(&current.block, &block) {
            self.current = Some(joined(current, &block));
            return;
        } else if let Some(arc) = CornerArc::between(&current, &next) {
            self.round(&mut current, &mut next, &arc);
        } else {
            self.blend(&mut current, &mut next);
        }
        self.current = Some(next);
    }

    /// Takes the next block into two clocks of one period. Where both run alike, it is run once.
    pub fn push_to_both(clocks: [&mut Self; 2], block: ClockedBlock, tolerance: BlendTolerance) {
        let [one, other] = clocks;
        // The time of a block depends on the one that runs and on nothing before it.
        let is_alike = one.current == other.current;
        let before = one.cycles;
        one.push(block, tolerance);
        if is_alike {
            other.cycles = other.cycles.saturating_add(one.cycles - before);
            other.current = one.current;
        } else {
            other.push(block, tolerance);
        }
    }

    /// Runs the last block into a standstill.
    pub fn stop(&mut self) {
        if let Some(current) = self.current.take() {
            self.run_to_rest(current);
        }
    }

    /// Takes in a time in which nothing moves \[s\].
    pub fn wait(&mut self, seconds: f64) {
        self.stop();
        self.rest += seconds;
    }

    /// Returns the time so far \[s\]; [`Self::stop`] completes it.
    pub fn seconds(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "2^53 cycles are 285 000 years")]
        let cycles = self.cycles as f64;
        cycles * self.period + self.rest
    }

    fn run_to_rest(&mut self, mut current: RunningBlock) {
        let target = current.block.velocity;
        while !current.ends_within(self.period) {
            self.skip(&mut current);
            current.step(target, self.period);
            self.cycles = self.cycles.saturating_add(1);
        }
        self.cycles = self.cycles.saturating_add(1);
    }

    /// Runs a block to its end, and the next one along with it from where this one slows down.
    fn blend(&mut self, current: &mut RunningBlock, next: &mut RunningBlock) {
        // Step 1: both have half of their acceleration, so that the sum of both keeps the limits.
        current.acceleration = 0.5 * current.block.acceleration;
        next.acceleration = 0.5 * next.block.acceleration;
        let [from, to] = blend_velocities(current, next);
        let mut is_blending = false;
        // Step 2: cycle by cycle to the end of this block.
        while !current.ends_within(self.period) {
            if !is_blending {
                self.skip(current);
            }
            current.step(current.block.velocity, self.period);
            is_blending |= current.slows_down && current.velocity < from;
            if is_blending {
                next.step(to, self.period);
            }
            self.cycles = self.cycles.saturating_add(1);
        }
        // Step 3: the cycle in which it ends is a whole one of the next.
        current.travelled = current.block.length;
        next.step(next.block.velocity, self.period);
        self.cycles = self.cycles.saturating_add(1);
    }

    /// Runs a block to the arc at its end, and along the arc to the next block.
    fn round(&mut self, current: &mut RunningBlock, next: &mut RunningBlock, arc: &CornerArc) {
        // Step 1: the arc replaces a length of both, and is as long as its own.
        current.block.length = (current.block.length - arc.reach).max(current.travelled);
        next.block.length -= arc.reach;
        current.leaves = arc.velocity;
        // Step 2: cycle by cycle to the arc.
        let target = current.block.velocity;
        while !current.ends_within(self.period) {
            self.skip(current);
            current.step(target, self.period);
            self.cycles = self.cycles.saturating_add(1);
        }
        // Step 3: what is left of the block and the arc, at the velocity of the arc.
        let cycles = ((current.left() + arc.length) / (arc.velocity * self.period)).round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let cycles = cycles as u64;
        self.cycles = self.cycles.saturating_add(cycles);
        next.velocity = arc.velocity;
    }

    /// Skips cycles that change nothing but the way.
    fn skip(&mut self, current: &mut RunningBlock) {
        let cycles = current.cruise(self.period);
        // A feed near zero takes more cycles than can be counted, but its way has to end.
        current.travelled += cycles * current.velocity * self.period;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let cycles = cycles as u64;
        self.cycles = self.cycles.saturating_add(cycles);
    }
}

/// Arc that rounds the corner between two blocks without rotaries.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CornerArc {
    /// Length of either block that it replaces \[mm\].
    reach: f64,
    /// Its own length \[mm\].
    length: f64,
    /// Velocity along it \[mm/s\].
    velocity: f64,
}

impl CornerArc {
    /// Returns the arc, or `None` where a rotary moves, the path turns back, or nothing moves along it.
    ///
    /// With the angle `t` by which the path turns, the tolerance `P` allows the radius `P / (1 / cos(t / 2) - 1)`, and half of
    /// the shorter length `L` allows `L / (2 tan(t / 2))`. `v = sqrt(0.866 a R)` passes it.
    fn between(current: &RunningBlock, next: &RunningBlock) -> Option<Self> {
        let [a, b] = [&current.block, &next.block];
        let is_linear = a.kind == ClockedKind::Linear && b.kind == ClockedKind::Linear;
        let cosine = turn_cosine(a, b).filter(|cosine| is_linear && *cosine > TURNS_BACK)?;
        let half = 0.5 * math::acos(cosine.clamp(-1.0, 1.0));
        // An arc at the other end of the block has already taken its half.
        let most = (ARC_REACH * current.last.min(b.length)).min(current.left());
        let reach = match current.tolerance {
            BlendTolerance::Within(tolerance) if tolerance > 0.0 => {
                most.min(tolerance / (math::cos(half).recip() - 1.0) * math::tan(half))
            }
            _ => most,
        };
        let radius = reach / math::tan(half);
        let acceleration = ARC_SHARE * a.acceleration.min(b.acceleration);
        let velocity = (acceleration * radius).sqrt().min(a.velocity).min(b.velocity);
        let length = 2.0 * half * radius;
        let usable = |value: f64| value > 0.0 && value.is_finite();
        [reach, length, velocity].into_iter().all(usable).then_some(Self {
            reach,
            length,
            velocity,
        })
    }
}

/// Velocities below which the next block begins, and up to which it runs while both move.
///
/// The blend lasts as long as the slower of both needs from its velocity to rest, but not longer than either block
/// at that velocity. At a corner of half angle `theta` the tolerance `P` allows `2 sqrt(a P / cos(theta))`.
fn blend_velocities(current: &RunningBlock, next: &RunningBlock) -> [f64; 2] {
    let pair = [current, next];
    let reached = pair.map(RunningBlock::reached);
    let times = [0, 1].map(|k| pair[k].block.length / reached[k]);
    let ramps = [0, 1].map(|k| reached[k] / pair[k].acceleration);
    let time = times[0].min(times[1]).min(ramps[0].max(ramps[1]));
    let mut velocities = [0, 1].map(|k| reached[k].min(time * pair[k].acceleration));
    let turn = turn_cosine(&current.block, &next.block);
    if let (BlendTolerance::Within(tolerance), Some(turn)) = (current.tolerance, turn)
        && tolerance > 0.0
    {
        // Half of the angle between the reversed first and the second direction: 90 degrees straight on.
        let half_angle = 0.5 * math::acos((-turn).clamp(-1.0, 1.0));
        let cosine = math::cos(half_angle).max(LEAST_COSINE);
        for (velocity, running) in velocities.iter_mut().zip(pair) {
            let most = 2.0 * (running.acceleration * tolerance / cosine).sqrt();
            *velocity = velocity.min(most);
        }
    }
    velocities
}

/// Two blocks without rotaries, and without a corner between them.
fn goes_straight_on(a: &ClockedBlock, b: &ClockedBlock) -> bool {
    let linear = a.kind == ClockedKind::Linear && b.kind == ClockedKind::Linear;
    linear && turn_cosine(a, b).is_some_and(|cosine| cosine > STRAIGHT_ON)
}

/// Cosine of the angle by which X, Y and Z turn from one block to the next; `None` where they stand in either.
fn turn_cosine(a: &ClockedBlock, b: &ClockedBlock) -> Option<f64> {
    let ([_, from], [to, _]) = (a.directions?, b.directions?);
    Some(from.dot(&to))
}

/// Adds a block to one that waits: the planner looks ahead, so both take the time at their own velocities.
fn joined(current: RunningBlock, next: &ClockedBlock) -> RunningBlock {
    let before = current.block;
    let length = before.length + next.length;
    let seconds = before.length / before.velocity + next.length / next.velocity;
    let block = ClockedBlock {
        length,
        velocity: length / seconds,
        acceleration: before.acceleration.min(next.acceleration),
        directions: before.directions.zip(next.directions).map(|([from, _], [_, to])| [from, to]),
        kind: ClockedKind::Linear,
    };
    RunningBlock { block, last: next.length, ..current }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feed_near_zero_ends_in_a_number() {
        for velocity in [1e-17, 1e-40, 1e-310] {
            let mut clock = BlendClock::new(0.001);
            let kind = ClockedKind::Linear;
            let block = ClockedBlock {
                length: 10.0,
                velocity,
                acceleration: 500.0,
                directions: None,
                kind,
            };
            for _ in 0..2 {
                clock.push(block, BlendTolerance::Within(0.01));
            }
            clock.stop();
            assert!(clock.seconds().is_finite() && clock.seconds() >= 0.0, "{velocity}");
        }
    }

    #[test]
    fn a_length_below_the_ramp_of_a_cycle_is_passed() {
        let mut clock = BlendClock::new(0.001);
        for length in [10.0, 1e-20, 1e-300, 1e-20, 10.0] {
            let kind = ClockedKind::Rotary;
            let block = ClockedBlock {
                length,
                velocity: 100.0,
                acceleration: 500.0,
                directions: None,
                kind,
            };
            clock.push(block, BlendTolerance::Within(0.01));
        }
        clock.stop();
        assert!(clock.seconds() < 2.0, "{}", clock.seconds());
    }

    /// Both clocks are where each would be alone, also behind a stop of one of them.
    #[test]
    fn two_clocks_run_together_as_each_alone() {
        let block = |k: u32| ClockedBlock {
            length: 0.3 + 0.1 * f64::from(k % 7),
            velocity: 20.0 + f64::from(k % 5),
            acceleration: 800.0,
            directions: None,
            kind: ClockedKind::Rotary,
        };
        let mut together = [BlendClock::new(0.001), BlendClock::new(0.001)];
        let mut alone = together.clone();
        for k in 0..200 {
            if k % 50 == 30 {
                together[1].stop();
                alone[1].stop();
            }
            let [one, other] = &mut together;
            BlendClock::push_to_both([one, other], block(k), BlendTolerance::Unbounded);
            for clock in &mut alone {
                clock.push(block(k), BlendTolerance::Unbounded);
            }
        }
        for (one, other) in together.iter_mut().zip(&mut alone) {
            one.stop();
            other.stop();
            assert_eq!(one.seconds().to_bits(), other.seconds().to_bits());
        }
    }
}
