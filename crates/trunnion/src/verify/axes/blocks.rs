//! What a control has to get by with, block by block: short blocks, singular directions, time.

use crate::machine::Kinematics;
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::Segment;
use crate::verify::report::{Brief, Singular};
use std::f64::consts::PI;

/// What is summed up over the blocks of a program.
pub(crate) struct Blocks<'a> {
    kinematics: &'a Kinematics,
    /// Whether the tool axis was within the singular cone last.
    within: bool,
    /// Time with no axis above its velocity \[s\].
    pub(crate) held: f64,
    pub(crate) brief: Option<Brief>,
    pub(crate) singular: Option<Singular>,
}

impl<'a> Blocks<'a> {
    pub(crate) fn new(control: &'a Control) -> Self {
        Self { kinematics: control.real(), within: false, held: 0.0, brief: None, singular: None }
    }

    /// Takes in a feed move and its largest velocities.
    pub(crate) fn take(
        &mut self,
        control: &Control,
        segment: &Segment,
        fastest: &AxisVector,
    ) -> Result<(), VerifyError> {
        let limits = self.kinematics.machine().vector(|axis| axis.vel);
        let over = fastest.component_div(&limits).max().max(1.0);
        self.held += segment.duration * over;
        self.short(segment);
        self.near(control, segment)
    }

    fn short(&mut self, segment: &Segment) {
        let Some(period) = self.kinematics.machine().cycle.servo_period else { return };
        // A time that is the period but for the feed word's rounding is not shorter.
        let duration = segment.block.duration;
        if !segment.block.begins || duration >= period * (1.0 - PERIOD_ROUNDING) {
            return;
        }
        let (line, shortest) = (segment.line, duration);
        let brief = self.brief.get_or_insert(Brief { count: 0, line, shortest, period });
        brief.count += 1;
        if shortest < brief.shortest {
            (brief.line, brief.shortest) = (line, shortest);
        }
    }

    /// Notes where the tool axis comes near the direction of the rotary axis that is nearest to the workpiece,
    /// about which it does not turn, then. Half a turn about it moves the tool axis by twice the sine of the
    /// angle between both. That angle changes no faster than the other rotary turns, so that looks a quarter of
    /// the cone apart miss its least value by an eighth of the cone.
    fn near(&mut self, control: &Control, segment: &Segment) -> Result<(), VerifyError> {
        let cone = self.kinematics.machine().singular.cone;
        let [from, to] = segment.joints;
        let turn = (to - from).fixed_rows::<2>(3).amax();
        let looks = (4.0 * (to[4] - from[4]).abs() / cone).ceil().clamp(1.0, MOST_LOOKS);
        let mut look = 0.0;
        while look <= looks {
            let q = control.joints(segment, look / looks)?;
            let mut turned = q;
            turned[3] += PI;
            let axis = |q: &AxisVector| self.kinematics.forward(q).axis.into_inner();
            let angle = (0.5 * (axis(&turned) - axis(&q)).norm()).min(1.0).asin();
            let within = angle <= cone;
            if within {
                let line = segment.line;
                let all = self.singular.get_or_insert(Singular { passages: 0, line, angle, turn });
                all.passages += usize::from(!self.within);
                if angle < all.angle {
                    (all.line, all.angle) = (line, angle);
                }
                all.turn = all.turn.max(turn);
            }
            self.within = within;
            look += 1.0;
        }
        Ok(())
    }
}

/// Looks for a singular direction inside one block at most.
const MOST_LOOKS: f64 = 256.0;
/// Feed words in inverse time have five digits.
const PERIOD_ROUNDING: f64 = 1e-4;
