//! Arcs and drilling cycles of an APT/CL file, and the straight moves that stand for them.

use super::{ClMotion, ClRecord};
use crate::math::angle::great_circle;
use crate::types::ToolPose;
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};

/// What the tool does on its way to a location.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClWay {
    /// The tip moves straight, the tool axis on a great circle.
    Straight,
    /// The tip moves on an arc or a helix.
    Arc(ClArc),
    /// The location is a hole: the tool comes, drills and goes.
    Hole(ClHole),
}

/// An arc, or one turn at most of a helix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClArc {
    /// Where the tip starts \[mm\].
    pub start: Point3<f64>,
    /// A point of the axis of the arc \[mm\].
    pub center: Point3<f64>,
    /// Axis about which the tip turns, by the right-hand rule.
    pub normal: UnitVector3<f64>,
    /// Angle of the turn, in (0, 2π] \[rad\].
    pub sweep: f64,
}

/// One hole of a drilling cycle; distances along the tool axis from its location \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClHole {
    /// Down to where the tool comes with rapid speed, above the location.
    pub clear: f64,
    /// Bottom, below the location.
    pub depth: f64,
    /// Up to where the tool goes afterwards, above the location.
    pub retract: f64,
    /// First and further steps after which it goes up to `clear`; one step if there is none.
    pub steps: Option<[f64; 2]>,
    /// Time at the bottom \[s\].
    pub dwell: f64,
    /// The tool comes out with the feed (taps, reamers, boring bars), not with rapid speed.
    pub feed_out: bool,
}

/// Most straight moves for an arc, most steps of a hole: a tolerance or a step that asks for more is a slip.
const MOST: f64 = 65_535.0;

impl ClArc {
    /// Distance from the axis at start and end, and travel along the axis \[mm\].
    fn shape(&self, end: &Point3<f64>) -> ([f64; 2], f64) {
        let [from, to] = [self.start, *end].map(|point| point - self.center);
        let [low, high] = [from, to].map(|way| way.dot(&self.normal));
        let across = |way: Vector3<f64>, height: f64| (way - self.normal.scale(height)).norm();
        ([across(from, low), across(to, high)], high - low)
    }

    /// Length up to `end` \[mm\].
    pub fn length(&self, end: &Point3<f64>) -> f64 {
        let ([start, stop], rise) = self.shape(end);
        (0.5 * (start + stop) * self.sweep).hypot(rise)
    }

    /// Tip at a share of the way to `end`: the distances from the axis, if not equal, change evenly.
    pub fn at(&self, end: &Point3<f64>, share: f64) -> Point3<f64> {
        let ([start, stop], rise) = self.shape(end);
        let from = self.start - self.center;
        let low = from.dot(&self.normal);
        let across = from - self.normal.scale(low);
        let stretch = if start > 0.0 { 1.0 + share * (stop - start) / start } else { 1.0 };
        let turned = Rotation3::from_axis_angle(&self.normal, share * self.sweep) * across;
        self.center + turned * stretch + self.normal.scale(low + share * rise)
    }

    /// Straight moves that stay within `tolerance` of the arc: an eighth of the largest second
    /// derivative by the share, `r θ² + 2 r' θ`.
    fn parts(&self, end: &Point3<f64>, tolerance: f64) -> u32 {
        let ([start, stop], _) = self.shape(end);
        let bend = start.max(stop) * self.sweep.powi(2) + 2.0 * (stop - start).abs() * self.sweep;
        let parts = (0.125 * bend / tolerance).sqrt().ceil();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts.clamp(1.0, MOST) as u32;
        parts
    }
}

impl ClHole {
    /// Depths down to which it is drilled, one after the other.
    fn depths(&self) -> Vec<f64> {
        let Some([first, further]) = self.steps else { return vec![self.depth] };
        let mut depths = Vec::new();
        let mut depth = first;
        while depth < self.depth && further > 0.0 && (depths.len() as f64) < MOST {
            depths.push(depth);
            depth += further;
        }
        depths.push(self.depth);
        depths
    }
}

impl ClRecord {
    /// The same as straight moves, the last of which ends where the record does: an arc in as many
    /// that the tip stays within `tolerance` \[mm\], a hole as rapid moves and moves down and up. The
    /// tool starts from `before`; without it the record is a place to start from.
    ///
    /// Between the steps of a deep hole the tool goes up to the clearance and comes back with rapid
    /// speed to the same distance from where it was.
    pub fn straight(&self, before: Option<&ToolPose>, tolerance: f64) -> Vec<Self> {
        match (self.way, before) {
            (ClWay::Straight, _) => vec![*self],
            (ClWay::Arc(arc), before) => self.arc(&arc, before.unwrap_or(&self.pose), tolerance),
            (ClWay::Hole(hole), before) => self.hole(&hole, before.is_some()),
        }
    }

    fn with(&self, tip: Point3<f64>, axis: UnitVector3<f64>, motion: ClMotion) -> Self {
        Self { line: self.line, pose: ToolPose { tip, axis }, motion, way: ClWay::Straight }
    }

    fn arc(&self, arc: &ClArc, before: &ToolPose, tolerance: f64) -> Vec<Self> {
        let parts = arc.parts(&self.pose.tip, tolerance);
        let mut moves: Vec<Self> = (1..parts)
            .map(|part| {
                let share = f64::from(part) / f64::from(parts);
                let axis = great_circle(&before.axis, &self.pose.axis, share);
                let tip = arc.at(&self.pose.tip, share);
                self.with(tip, axis.unwrap_or(self.pose.axis), self.motion)
            })
            .collect();
        moves.push(Self { way: ClWay::Straight, ..*self });
        moves
    }

    fn hole(&self, hole: &ClHole, over: bool) -> Vec<Self> {
        let ToolPose { tip, axis } = self.pose;
        let at = |height: f64, motion| self.with(tip + axis.scale(height), axis, motion);
        let mut moves = Vec::new();
        // From the hole before, whose retract may be lower than this one's clearance or the other way round.
        if over && hole.retract > hole.clear {
            moves.push(at(hole.retract, ClMotion::Rapid));
        }
        moves.push(at(hole.clear, ClMotion::Rapid));
        let out = if hole.feed_out { self.motion } else { ClMotion::Rapid };
        let depths = hole.depths();
        let last = depths.len() - 1;
        for (step, depth) in depths.iter().enumerate() {
            moves.push(at(-depth, self.motion));
            if step < last {
                moves.push(at(hole.clear, out));
                moves.push(at(hole.clear - depth, ClMotion::Rapid));
            }
        }
        moves.push(at(hole.retract, out));
        moves
    }

    /// Where the tool is afterwards.
    pub fn end(&self) -> ToolPose {
        match self.way {
            ClWay::Hole(hole) => {
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

    const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

    fn record(tip: [f64; 3], way: ClWay) -> ClRecord {
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
        let moves = record([0.0, 5.0, 3.0], ClWay::Arc(arc)).straight(None, 0.01);
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
        let record = record([1.0, 1.0, 0.0], ClWay::Hole(hole));
        let moves = record.straight(None, 0.01);
        let heights: Vec<f64> = moves.iter().map(|one| one.pose.tip.z).collect();
        assert_eq!(heights, [2.0, -4.0, 2.0, -2.0, -6.0, 2.0, -4.0, -7.0, 10.0]);
        let rapid = moves.iter().filter(|one| one.motion == ClMotion::Rapid).count();
        assert_eq!(rapid, 6);
        assert_eq!(record.end().tip, Point3::new(1.0, 1.0, 10.0));
        assert_eq!(record.straight(Some(&record.pose), 0.01).len(), 10);
    }
}
