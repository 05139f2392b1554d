//! Arcs and drilling cycles of an APT/CL file, and the straight moves that stand for them.

use super::file::{ClMotion, ClRecord};
use super::path::{ClArc, ClHole, ClPath};
use crate::math::angle::great_circle;
use crate::types::ToolPose;
use nalgebra::{Point3, UnitVector3};

impl ClRecord {
    /// Divides a record into straight moves, the last of which ends where the record does: an arc
    /// in as many
    /// that the tip stays within `tolerance` \[mm\], a hole as rapid moves and moves down and up. The
    /// tool starts from `before`; without it the record is a place to start from.
    ///
    /// Between the steps of a deep hole the tool goes up to the clearance and comes back with rapid
    /// speed to the same distance from where it was.
    pub fn straight(&self, before: Option<&ToolPose>, tolerance: f64) -> Vec<Self> {
        match (self.way, before) {
            (ClPath::Straight, _) => vec![*self],
            (ClPath::Arc(arc), before) => self.arc(&arc, before.unwrap_or(&self.pose), tolerance),
            (ClPath::Hole(hole), before) => self.hole(&hole, before),
        }
    }

    fn with(&self, tip: Point3<f64>, axis: UnitVector3<f64>, motion: ClMotion) -> Self {
        Self { line: self.line, pose: ToolPose { tip, axis }, motion, way: ClPath::Straight }
    }

    fn arc(&self, arc: &ClArc, before: &ToolPose, tolerance: f64) -> Vec<Self> {
        let parts = arc.parts(&self.pose.tip, tolerance);
        let mut moves: Vec<Self> = (1..parts)
            .map(|part| {
                let share = f64::from(part) / f64::from(parts);
                // The tool axis turns evenly while the tip runs on the arc.
                let axis = great_circle(&before.axis, &self.pose.axis, share);
                let tip = arc.at(&self.pose.tip, share);
                self.with(tip, axis.unwrap_or(self.pose.axis), self.motion)
            })
            .collect();
        moves.push(Self { way: ClPath::Straight, ..*self });
        moves
    }

    fn hole(&self, hole: &ClHole, before: Option<&ToolPose>) -> Vec<Self> {
        let ToolPose { tip, axis } = self.pose;
        let at = |height: f64, motion| self.with(tip + axis.scale(height), axis, motion);
        let mut moves = Vec::new();
        // From the hole before, whose retract may be lower than this one's clearance or the other way round.
        if before.is_some() && hole.retract > hole.clear {
            moves.push(at(hole.retract, ClMotion::Rapid));
        }
        moves.push(at(hole.clear, ClMotion::Rapid));
        // Taps and boring bars must not be pulled out in rapid.
        let out = if hole.feed_out { self.motion } else { ClMotion::Rapid };
        let depths = hole.depths();
        let last = depths.len() - 1;
        for (step, depth) in depths.iter().enumerate() {
            moves.push(at(-depth, self.motion));
            if step < last {
                moves.push(at(hole.clear, out));
                // In rapid to within the clearance of the bottom, then on with the feed.
                moves.push(at(hole.clear - depth, ClMotion::Rapid));
            }
        }
        moves.push(at(hole.retract, out));
        moves
    }

    /// Returns the pose of the tool afterwards.
    pub fn end(&self) -> ToolPose {
        match self.way {
            ClPath::Hole(hole) => {
                let lift = self.pose.axis.scale(hole.retract);
                ToolPose { tip: self.pose.tip + lift, ..self.pose }
            }
            _ => self.pose,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

    fn record(tip: [f64; 3], way: ClPath) -> ClRecord {
        let pose = ToolPose { tip: Point3::from(tip), axis: Vector3::z_axis() };
        ClRecord { line: 1, pose, motion: ClMotion::Feed(10.0), way }
    }

    #[test]
    fn a_quarter_of_a_helix_keeps_its_radius_and_rises_evenly() {
        let arc = ClArc {
            start: Point3::new(5.0, 0.0, 1.0),
            center: Point3::new(0.0, 0.0, 7.0),
            normal: Vector3::z_axis(),
            sweep: QUARTER,
        };
        let end = Point3::new(0.0, 5.0, 3.0);
        let middle = arc.at(&end, 0.5);
        let side = 5.0 * 0.5f64.sqrt();
        assert!((middle - Point3::new(side, side, 2.0)).norm() < 1e-14);
        assert!((arc.length(&end) - (5.0 * QUARTER).hypot(2.0)).abs() < 1e-13);
        let moves = record([0.0, 5.0, 3.0], ClPath::Arc(arc)).straight(None, 0.01);
        // Arc height of equal parts of a quarter: 5 (1 - cos(45 deg / n)) <= 0.01 from n = 13 on.
        assert!(moves.len() == 13 || moves.len() == 14, "{}", moves.len());
        assert_eq!(moves[moves.len() - 1].pose.tip, end);
    }

    #[test]
    fn a_deep_hole_goes_up_between_its_steps() {
        let hole = ClHole {
            clear: 2.0,
            depth: 7.0,
            retract: 10.0,
            steps: Some([4.0, 2.0]),
            dwell: 0.0,
            feed_out: false,
        };
        let record = record([1.0, 1.0, 0.0], ClPath::Hole(hole));
        let moves = record.straight(None, 0.01);
        let heights: Vec<f64> = moves.iter().map(|one| one.pose.tip.z).collect();
        assert_eq!(heights, [2.0, -4.0, 2.0, -2.0, -6.0, 2.0, -4.0, -7.0, 10.0]);
        let rapid = moves.iter().filter(|one| one.motion == ClMotion::Rapid).count();
        assert_eq!(rapid, 6);
        assert_eq!(record.end().tip, Point3::new(1.0, 1.0, 10.0));
        assert_eq!(record.straight(Some(&record.pose), 0.01).len(), 10);
    }
}
