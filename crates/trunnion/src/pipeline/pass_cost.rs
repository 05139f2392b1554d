//! Time of passes on the machine, estimated from axis speeds alone.

use super::estimate::rest_to_rest;
use super::job::Job;
use crate::cover::PassCost;
use crate::files::job::FeedReference;
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::types::{AXES, AxisVector, Interval, Station, ToolPose};

/// Margin of poses from the ends of rotary travel \[rad\]: the curve between stations exceeds them by less.
const MARGIN: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// Margin of poses from the ends of linear travel \[mm\], for the same reason.
const LINEAR_MARGIN: f64 = 0.5;

/// Largest margin, as a share of the travel.
const SHARE: f64 = 0.01;

/// Times of passes and links: feed and axis velocities, without accelerations along a pass.
#[derive(Debug)]
pub(super) struct JobPassCost {
    /// `None` for a setup without numbers, which is refused where the axes are solved.
    inverse: Option<Inverse>,
    /// Inverse with less travel.
    inside: Option<Inverse>,
    home: AxisVector,
    /// Feed of the contact or the tip \[mm/s\].
    feed: f64,
    at_contact: bool,
    tip: f64,
    velocity: AxisVector,
    /// Time of a link without its rotary travel \[s\].
    link: f64,
}

impl JobPassCost {
    /// Creates the cost model of a job; `link` is the length cut while the tool goes up, over and down \[mm\].
    pub(super) fn new(job: &Job, link: f64) -> Self {
        let machine = job.kinematics.machine();
        let feed = job.file.cutting.feed;
        Self {
            inverse: Inverse::new(&job.kinematics).ok(),
            inside: Inverse::new(&inset(&job.kinematics, LinearTravel::Inset)).ok(),
            home: machine.home(),
            feed,
            at_contact: job.file.cutting.reference == FeedReference::Contact,
            tip: machine.cycle.tip_speed_max.unwrap_or(f64::INFINITY),
            velocity: machine.vector(|axis| axis.vel),
            link: link / feed,
        }
    }

    /// Returns the axes at a station, near those before; `None` if it is out of reach, which is reported later.
    fn axes(&self, station: &Station, near: &AxisVector) -> Option<AxisVector> {
        self.inverse.as_ref()?.near(&station.pose, near).ok()
    }

    /// Returns the time between two stations of a pass, with the axes at both where they are known \[s\].
    fn step(&self, [a, b]: [&Station; 2], axes: [Option<AxisVector>; 2]) -> f64 {
        let contact = (b.contact - a.contact).norm();
        let tip = (b.pose.tip - a.pose.tip).norm();
        let cut = if self.at_contact { contact } else { tip } / self.feed;
        // The feed holds at the contact or the tip; the control caps the speed of the tip as well.
        let least = cut.max(tip / self.tip);
        let [Some(p), Some(q)] = axes else { return least };
        // Every axis at its own limit: a lower bound on the step, which compares candidates fairly.
        (0..AXES).map(|axis| (q[axis] - p[axis]).abs() / self.velocity[axis]).fold(least, f64::max)
    }
}

/// Linear travel of an inset machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LinearTravel {
    /// A little less than the machine has.
    Inset,
    /// No ends: the direction of the tool alone decides.
    Unbounded,
}

/// Returns the machine with a little less rotary travel, and less or no bounds of linear travel.
pub(super) fn inset(kinematics: &Kinematics, linear: LinearTravel) -> Kinematics {
    let mut machine = kinematics.machine().clone();
    let (lines, turns) = machine.axes.split_at_mut(FIRST_ROTARY);
    let less = |limits: Interval, most: f64| {
        let [low, high] = limits.ends();
        // A cyclic axis has infinite ends, which the margin leaves infinite.
        let margin = most.min(SHARE * (high - low));
        Interval::new(low + margin, high - margin)
    };
    for axis in lines {
        axis.limits = match linear {
            LinearTravel::Inset => less(axis.limits, LINEAR_MARGIN),
            LinearTravel::Unbounded => Interval::UNBOUNDED,
        };
    }
    for axis in turns {
        axis.limits = less(axis.limits, MARGIN);
    }
    Kinematics::new(&machine, kinematics.setup())
}

impl PassCost for JobPassCost {
    fn feed(&self) -> f64 {
        self.feed
    }

    fn pass(&self, stations: &[Station]) -> f64 {
        let mut near = self.home;
        let mut before: Option<(&Station, Option<AxisVector>)> = None;
        let mut sum = 0.0;
        for station in stations {
            let axes = self.axes(station, &near);
            if let Some((last, at)) = before {
                sum += self.step([last, station], [at, axes]);
            }
            // Past a station out of reach, the branch goes on from the last position known.
            near = axes.unwrap_or(near);
            before = Some((station, axes));
        }
        sum
    }

    fn reaches(&self, pose: &ToolPose) -> bool {
        self.inside.as_ref().is_none_or(|inverse| inverse.continued(pose, &self.home).is_ok())
    }

    /// Returns the time of a link; the rotaries turn from rest to rest while the tool travels over.
    fn link(&self, from: &Station, to: &Station) -> f64 {
        let turn = self.axes(from, &self.home).and_then(|start| {
            let end = self.axes(to, &start)?;
            let axes = &self.inverse.as_ref()?.kinematics().machine().axes;
            let time = |axis: usize| rest_to_rest(&axes[axis], (end[axis] - start[axis]).abs());
            Some((FIRST_ROTARY..AXES).map(time).fold(0.0, f64::max))
        });
        // Of the three parts of a link, the middle one may take longer because of the turn.
        let over = self.link / 3.0;
        self.link - over + turn.unwrap_or(0.0).max(over)
    }
}
