//! Block timing: blocks shorter than the servo period, passages of singular directions, least time.

use crate::machine::Kinematics;
use crate::math;
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::Segment;
use crate::verify::report::{ShortBlocks, SingularPassages};
use std::f64::consts::PI;

/// Sums over the blocks of a program.
pub(crate) struct BlockTiming<'a> {
    kinematics: &'a Kinematics,
    /// The tool axis was in the singular cone at the last sample.
    in_cone: bool,
    /// Time with no axis above its velocity \[s\].
    pub(crate) held: f64,
    pub(crate) short: Option<ShortBlocks>,
    pub(crate) singular: Option<SingularPassages>,
}

impl<'a> BlockTiming<'a> {
    pub(crate) fn new(control: &'a Control) -> Self {
        Self { kinematics: control.real(), in_cone: false, held: 0.0, short: None, singular: None }
    }

    /// Takes in a feed move and its largest velocities.
    pub(crate) fn take(
        &mut self,
        control: &Control,
        segment: &Segment,
        fastest: &AxisVector,
    ) -> Result<(), VerifyError> {
        let limits = self.kinematics.machine().vector(|axis| axis.vel);
        // At k times the time every velocity is a k-th: the axis farthest above its limit sets the least time.
        let over = fastest.component_div(&limits).max().max(1.0);
        self.held += segment.duration * over;
        self.note_short(segment);
        self.note_singular(control, segment)
    }

    /// Notes a block that is shorter than the servo period.
    fn note_short(&mut self, segment: &Segment) {
        let Some(period) = self.kinematics.machine().cycle.servo_period else { return };
        // A time that is the period but for the feed word's rounding is not shorter.
        let duration = segment.block.duration;
        if !segment.block.begins || duration >= period * (1.0 - PERIOD_ROUNDING) {
            return;
        }
        let (line, shortest) = (segment.line, duration);
        let short = self.short.get_or_insert(ShortBlocks { count: 0, line, shortest, period });
        short.count += 1;
        if shortest < short.shortest {
            (short.line, short.shortest) = (line, shortest);
        }
    }

    /// Notes passages of the singular cone: the tool axis close to the rotary axis next to the workpiece.
    ///
    /// Half a turn about that rotary moves the tool axis by twice the sine of the angle between both. The angle changes
    /// no faster than the other rotary turns, so samples a quarter of the cone apart miss its least value by an eighth
    /// of the cone.
    fn note_singular(&mut self, control: &Control, segment: &Segment) -> Result<(), VerifyError> {
        let cone = self.kinematics.machine().singular.cone;
        let [from, to] = segment.joints;
        let turn = (to - from).fixed_rows::<2>(3).amax();
        let samples = (4.0 * (to[4] - from[4]).abs() / cone).ceil().clamp(1.0, MOST_SAMPLES);
        let mut sample = 0.0;
        while sample <= samples {
            let q = control.joints(segment, sample / samples)?;
            let mut turned = q;
            turned[3] += PI;
            // |a(q3 + pi) - a(q3)| = 2 sin(angle), since only the part of `a` across the rotary axis is turned over.
            let axis = |q: &AxisVector| self.kinematics.forward(q).axis.into_inner();
            let angle = math::asin((0.5 * (axis(&turned) - axis(&q)).norm()).min(1.0));
            let in_cone = angle <= cone;
            if in_cone {
                let line = segment.line;
                let all = self.singular.get_or_insert(SingularPassages {
                    passages: 0,
                    line,
                    angle,
                    turn,
                });
                // The cone is entered once, however many samples and blocks lie in it.
                all.passages += usize::from(!self.in_cone);
                if angle < all.angle {
                    (all.line, all.angle) = (line, angle);
                }
                all.turn = all.turn.max(turn);
            }
            self.in_cone = in_cone;
            sample += 1.0;
        }
        Ok(())
    }
}

/// Most samples for a singular direction inside one block.
const MOST_SAMPLES: f64 = 256.0;
/// Feed words in inverse time have five digits.
const PERIOD_ROUNDING: f64 = 1e-4;
