//! Velocities of the axes inside blocks, whose mean velocities alone the schedule limits.

use crate::blocks::{BlockEnd, BlockInterpolation, moved};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, RotaryPair, SECOND_ROTARY};
use crate::types::{AxisVector, Block};

/// Largest turn of both rotaries together over three samples \[rad\].
const TURN: f64 = 0.02;

/// Turn of a block up to which its axes run evenly \[rad\].
const LITTLE: f64 = 1e-3;

/// Most halvings of a block: where a great circle passes a pole, a rotary jumps, and nothing is short enough.
const HALVINGS: u32 = 12;

/// Error of the velocity at the end of a parabola through three samples, as a share: a lever that turns by `h` from one to
/// the next has it off by `h²/3`.
const OFF: f64 = TURN * TURN / 12.0;

/// Axes inside blocks of a control.
#[derive(Clone, Copy)]
pub(super) struct InnerVelocity<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) control: BlockInterpolation,
}

impl InnerVelocity<'_> {
    /// Slows the blocks inside which an axis would be faster than it can, and returns the time that takes \[s\]. The first
    /// is where the program starts.
    ///
    /// With tool centre point control the linear axes follow the rotaries, and are not even inside a block: long blocks of
    /// links turn by tens of degrees.
    pub(super) fn slow(&self, blocks: &mut [Block]) -> f64 {
        let mut added = 0.0;
        for index in 1..blocks.len() {
            let ends = [index - 1, index].map(|at| BlockEnd::new(&blocks[at].q, &blocks[at].pose));
            let least = self.least_duration(ends);
            let slowed = blocks[index].duration.max(least);
            added += slowed - blocks[index].duration;
            blocks[index].duration = slowed;
        }
        added
    }

    /// Returns the time that a block takes at least, so that each axis keeps its velocity all the way \[s\]. 0 where the
    /// axes run evenly, as the schedule knows.
    fn least_duration(&self, ends: [BlockEnd<'_>; 2]) -> f64 {
        let [from, to] = ends.map(|end| end.q);
        if self.control == BlockInterpolation::Axes || turn(from, to) <= LITTLE {
            return 0.0;
        }
        let stretch = BlockStretch { shares: [0.0, 1.0], ends: [*from, *to] };
        self.steepest(ends, &stretch, HALVINGS) * (1.0 + OFF)
    }

    /// Returns the largest velocity of any axis by the share of a block, over its limit \[s\].
    fn steepest(&self, ends: [BlockEnd<'_>; 2], stretch: &BlockStretch, halvings: u32) -> f64 {
        let BlockStretch { shares: [start, end], ends: [from, to] } = *stretch;
        let share = 0.5 * (start + end);
        let Some(middle) = self.axes(ends, share, &from) else { return 0.0 };
        if turn(&from, &middle) + turn(&middle, &to) > TURN {
            // A jump has no velocity that time would lower.
            let Some(halvings) = halvings.checked_sub(1) else { return 0.0 };
            let halves = [
                BlockStretch { shares: [start, share], ends: [from, middle] },
                BlockStretch { shares: [share, end], ends: [middle, to] },
            ];
            return halves
                .iter()
                .map(|half| self.steepest(ends, half, halvings))
                .fold(0.0, f64::max);
        }
        // The parabola is steepest at one of its ends: by first differences a and b, at (3 a - b)/2 or (3 b - a)/2.
        let [first, second] = [middle - from, to - middle];
        let steepest = (3.0 * first - second).abs().sup(&(3.0 * second - first).abs());
        let limits = self.inverse.kinematics().machine().vector(|axis| axis.vel);
        steepest.component_div(&limits).amax() / (end - start)
    }

    /// Returns the axes at a share of a block, near others.
    fn axes(&self, ends: [BlockEnd<'_>; 2], share: f64, near: &AxisVector) -> Option<AxisVector> {
        let pose = moved(self.inverse.kinematics(), self.control, ends, share)?;
        if self.control == BlockInterpolation::GreatCircle {
            return self.inverse.near(&pose, near).ok();
        }
        // The rotaries are known, also where they pass a pole.
        let turned = ends[0].q.lerp(ends[1].q, share);
        let rotaries = RotaryPair::new(turned[FIRST_ROTARY], turned[SECOND_ROTARY]);
        self.inverse.at_rotaries(&pose.tip, rotaries).ok()
    }
}

/// Part of a block: shares of it, and the axes there.
struct BlockStretch {
    shares: [f64; 2],
    ends: [AxisVector; 2],
}

/// Returns the turn of both rotaries together \[rad\].
fn turn(from: &AxisVector, to: &AxisVector) -> f64 {
    (to - from).fixed_rows::<2>(FIRST_ROTARY).lp_norm(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Kinematics, Machine, Setup};
    use crate::sample_machine::ac_trunnion;
    use crate::types::Motion;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// Differences of the axes from one to the next of as many moments.
    const MOMENTS: u32 = 4000;

    fn inverse() -> Inverse {
        let setup = Setup::new(Vector3::new(40.0, -30.0, 20.0), [0.1, 0.2, 0.3], 120.0);
        Inverse::new(&Kinematics::new(&Machine::new(ac_trunnion()).unwrap(), &setup)).unwrap()
    }

    /// Largest velocity of any axis inside a block, over its limit.
    fn ratio(inverse: &Inverse, control: BlockInterpolation, [from, to]: [&Block; 2]) -> f64 {
        let ends = [from, to].map(|end| BlockEnd::new(&end.q, &end.pose));
        let limits = inverse.kinematics().machine().vector(|axis| axis.vel);
        let mut before = from.q;
        let mut most = 0.0_f64;
        for k in 1..=MOMENTS {
            let share = f64::from(k) / f64::from(MOMENTS);
            let pose = moved(inverse.kinematics(), control, ends, share).unwrap();
            let q = inverse.near(&pose, &before).unwrap();
            let velocity = (q - before).abs() * (f64::from(MOMENTS) / to.duration);
            most = most.max(velocity.component_div(&limits).amax());
            before = q;
        }
        most
    }

    proptest! {
        #[test]
        fn no_axis_is_too_fast_inside_a_block_and_none_waits_for_nothing(
            turn in [-0.8_f64..0.8, -0.2..0.8],
            way in [-30.0_f64..30.0, -30.0..30.0, -30.0..30.0],
            quick in 0.01_f64..0.5,
            control in prop::sample::select(vec![
                BlockInterpolation::RotaryLinear,
                BlockInterpolation::GreatCircle,
            ]),
        ) {
            let inverse = inverse();
            let block = |q: AxisVector, duration| {
                let pose = inverse.kinematics().forward(&q);
                Block { motion: Motion::Link, q, pose, duration }
            };
            // Away from the pole: there a great circle turns the table by any amount.
            let q = AxisVector::from([10.0, 20.0, -40.0, -0.9, 0.6]);
            let start = block(q, 0.0);
            let to = q + AxisVector::from([way[0], way[1], way[2], 0.5 * turn[0], turn[1]]);
            let mut blocks = [start, block(to, quick)];
            let added = InnerVelocity { inverse: &inverse, control }.slow(&mut blocks);
            prop_assert!((added - (blocks[1].duration - quick)).abs() <= 1e-12, "{added}");
            let ratio = ratio(&inverse, control, [&blocks[0], &blocks[1]]);
            prop_assert!(ratio <= 1.0 + 1e-6, "{ratio}");
            // Slowed for an axis that is uneven inside, or one that is even, and by no more than it needs.
            let slowed = blocks[1].duration > quick;
            prop_assert!(!slowed || ratio > 0.999, "{ratio} after {quick} s became {}", blocks[1].duration);
        }
    }
    #[test]
    fn a_jump_of_the_table_slows_nothing() {
        let inverse = inverse();
        let at = |tilt: f64| {
            let q = AxisVector::from([0.0, 0.0, 0.0, tilt, 0.0]);
            let pose = inverse.kinematics().forward(&q);
            Block { motion: Motion::Link, q, pose, duration: 1e-3 }
        };
        // From one side of the pole to the other, the great circle takes C by half a turn.
        let mut blocks = [-0.3, 0.3].map(at);
        let control = BlockInterpolation::GreatCircle;
        InnerVelocity { inverse: &inverse, control }.slow(&mut blocks);
        assert!(blocks[1].duration < 1.0, "{}", blocks[1].duration);
    }
}
