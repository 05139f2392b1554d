//! How far a control strays from the path between two block ends.

use super::Control;
use crate::machine::Kinematics;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{AxisPiece, AxisVector, Block, SchedulePiece, ToolPose};
use nalgebra::{UnitVector3, Vector3, Vector6};

/// Samples inside a block: at least so many, one per node interval, at most so many.
const SAMPLES: [usize; 2] = [7, 63];

/// Share of `max |second difference| / 8` added for what lies between two samples. For a residual
/// with constant second derivative 1 is exact; the rest covers its change from sample to sample.
const BETWEEN: f64 = 1.5;

/// One piece of path under one control.
pub(super) struct Course<'a> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) control: Control,
    pub(super) piece: &'a AxisPiece,
    pub(super) lever: f64,
}

/// Which pose of the control a place of the path is compared with.
#[derive(Debug, Clone, Copy)]
enum Match {
    /// About the nearest.
    Nearest,
    /// The one at the same share of the block.
    EqualShare,
}

/// A place on the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) s: f64,
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
}

impl Course<'_> {
    pub(super) fn at(&self, s: f64) -> Place {
        let q = self.piece.position_at(s).unwrap_or_else(AxisVector::zeros);
        Place { s, q, pose: self.kinematics.forward(&q) }
    }

    /// Upper estimate of the deviation between two places; exact only where it is at most `enough`.
    ///
    /// Any matching of places on the path with places of the control gives an upper bound: first
    /// about the nearest, then equal shares of `s`, which is exact for moves that are straight in
    /// the axes or straight by construction, however far they turn.
    pub(super) fn deviation(&self, from: &Place, to: &Place, enough: f64) -> f64 {
        let nearest = self.matched(from, to, enough, Match::Nearest);
        if nearest <= enough {
            return nearest;
        }
        nearest.min(self.matched(from, to, enough, Match::EqualShare))
    }

    /// The largest distance of the samples, and an allowance for what lies between them. Stops early
    /// once a sample exceeds `enough`.
    fn matched(&self, from: &Place, to: &Place, enough: f64, by: Match) -> f64 {
        let intervals = self.piece.interval_at(to.s) - self.piece.interval_at(from.s);
        let samples = intervals.clamp(SAMPLES[0], SAMPLES[1]);
        let [mut before, mut last] = [Vector6::zeros(); 2];
        let [mut largest, mut bend] = [0.0_f64; 2];
        for sample in 1..=samples + 1 {
            let mut here = Vector6::zeros();
            if sample <= samples {
                let s = from.s + (to.s - from.s) * sample as f64 / (samples + 1) as f64;
                let place = self.at(s);
                let Some(moved) = self.partner(from, to, &place, by) else { return f64::INFINITY };
                here = self.weighted(&place.pose) - self.weighted(&moved);
                let tip = (place.pose.tip - moved.tip).norm();
                let turn = self.lever * angle_between(&place.pose.axis, &moved.axis);
                largest = largest.max(tip + turn);
                if largest > enough {
                    return largest;
                }
            }
            if sample > 1 {
                bend = bend.max((here - last * 2.0 + before).norm());
            }
            (before, last) = (last, here);
        }
        // Tip and axis part of a six-vector add up to at most sqrt 2 times its length.
        largest + BETWEEN * std::f64::consts::SQRT_2 * bend / 8.0
    }

    /// Pose of the control that a place of the path is compared with. For the nearest one, one
    /// projection and one correction are enough in blocks that are nearly straight.
    fn partner(&self, from: &Place, to: &Place, place: &Place, by: Match) -> Option<ToolPose> {
        let share = (place.s - from.s) / (to.s - from.s);
        let [start, end] = [self.weighted(&from.pose), self.weighted(&to.pose)];
        let chord = end - start;
        let square = chord.norm_squared();
        if matches!(by, Match::EqualShare) || square <= 0.0 {
            return self.moved(from, to, share);
        }
        let target = self.weighted(&place.pose);
        let first = ((target - start).dot(&chord) / square).clamp(0.0, 1.0);
        let rest = target - self.weighted(&self.moved(from, to, first)?);
        self.moved(from, to, (first + rest.dot(&chord) / square).clamp(0.0, 1.0))
    }

    /// Where the control is at a share of the block.
    fn moved(&self, from: &Place, to: &Place, share: f64) -> Option<ToolPose> {
        let axes = || self.kinematics.forward(&from.q.lerp(&to.q, share));
        let tip = from.pose.tip + (to.pose.tip - from.pose.tip) * share;
        let axis = match self.control {
            Control::Axes => return Some(axes()),
            Control::RotaryLinear => axes().axis,
            Control::GreatCircle => great_circle(&from.pose.axis, &to.pose.axis, share)?,
        };
        Some(ToolPose { tip, axis })
    }

    /// Tip and tool axis as one vector, the axis with the lever \[mm\].
    fn weighted(&self, pose: &ToolPose) -> Vector6<f64> {
        let axis: &UnitVector3<f64> = &pose.axis;
        let [tip, axis]: [Vector3<f64>; 2] = [pose.tip.coords, axis.scale(self.lever)];
        Vector6::new(tip.x, tip.y, tip.z, axis.x, axis.y, axis.z)
    }

    /// Blocks between ends in order of `s`, the first being where the piece starts.
    pub(super) fn blocks(&self, ends: &[f64], rows: &SchedulePiece) -> Vec<Block> {
        ends.windows(2)
            .map(|pair| {
                let place = self.at(pair[1]);
                let duration = rows.time_at(pair[1]) - rows.time_at(pair[0]);
                Block { motion: self.piece.motion, q: place.q, pose: place.pose, duration }
            })
            .collect()
    }
}
