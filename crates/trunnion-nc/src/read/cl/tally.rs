//! Totals of a CL file: counts, lengths, ranges.

use super::file::{ClMotion, ClRecord};
use super::path::ClPath;
use crate::math::angle::angle_between;
use crate::types::ToolPose;
use nalgebra::Vector3;

/// Counts, lengths and ranges of cutter locations, taken in one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct ClTally {
    /// Locations, those of arcs and holes among them.
    pub locations: usize,
    /// Those reached on an arc.
    pub arcs: usize,
    /// Holes.
    pub holes: usize,
    /// Travel of the tip at rapid speed \[mm\].
    pub rapid_length: f64,
    /// Travel of the tip with feed \[mm\].
    pub cut_length: f64,
    /// Time of the ways with feed at the feed written, and at the bottom of holes \[s\].
    pub seconds: f64,
    /// Least and largest tip coordinates \[mm\].
    pub tip: [Vector3<f64>; 2],
    /// Least and largest components of the tool axis.
    pub axis: [Vector3<f64>; 2],
    /// Turns of the tool axis, added up \[rad\].
    pub turn: f64,
    tolerance: f64,
    place: Option<ToolPose>,
}

impl ClTally {
    /// Starts a tally; ranges of arcs are right to `tolerance` \[mm\].
    pub fn new(tolerance: f64) -> Self {
        let range = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
        Self {
            locations: 0,
            arcs: 0,
            holes: 0,
            rapid_length: 0.0,
            cut_length: 0.0,
            seconds: 0.0,
            tip: range,
            axis: range,
            turn: 0.0,
            tolerance,
            place: None,
        }
    }

    /// Takes in a location.
    pub fn push(&mut self, record: &ClRecord) {
        self.locations += 1;
        let before = self.place;
        match (record.way, before) {
            (ClPath::Straight, _) => self.step(record),
            (ClPath::Arc(arc), before) => {
                self.arcs += 1;
                // The chords serve the ranges and the turns of the axis only.
                let sums = (self.rapid_length, self.cut_length, self.seconds);
                record
                    .straight(before.as_ref(), self.tolerance)
                    .iter()
                    .for_each(|one| self.step(one));
                // The arc itself is longer than its chords.
                (self.rapid_length, self.cut_length, self.seconds) = sums;
                self.travel(arc.length(&record.pose.tip), record.motion);
            }
            (ClPath::Hole(hole), before) => {
                self.holes += 1;
                self.seconds += hole.dwell;
                record
                    .straight(before.as_ref(), self.tolerance)
                    .iter()
                    .for_each(|one| self.step(one));
            }
        }
    }

    fn step(&mut self, to: &ClRecord) {
        // The first location is where the count begins.
        if let Some(from) = self.place {
            self.travel((to.pose.tip - from.tip).norm(), to.motion);
            self.turn += angle_between(&from.axis, &to.pose.axis);
        }
        let [tip, axis] = [to.pose.tip.coords, to.pose.axis.into_inner()];
        self.tip = [self.tip[0].inf(&tip), self.tip[1].sup(&tip)];
        self.axis = [self.axis[0].inf(&axis), self.axis[1].sup(&axis)];
        self.place = Some(to.pose);
    }

    fn travel(&mut self, length: f64, motion: ClMotion) {
        match motion {
            ClMotion::Rapid => self.rapid_length += length,
            ClMotion::Feed(feed) => {
                self.cut_length += length;
                self.seconds += length / feed;
            }
        }
    }
}
