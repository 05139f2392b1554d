//! Bodies of the machine of a job, and their distances over its programs.

use super::fixtures::{MOST_COLLISIONS, lines};
use crate::files::summary::{BodiesSummary, BodyApproachSummary, BodyMeetingSummary};
use crate::machine::Machine;
use crate::verify::{
    BodyApproach, BodyReport, ClearanceOptions, MachineBodies, Solid, VerifyError,
};

/// Tolerance of the distances between bodies \[mm\].
const TOLERANCE: f64 = 0.01;

/// Most lines on which bodies come too near that are listed one by one.
const MOST_LISTED: usize = 10;

/// Bodies of a machine, and the clearance that they must keep.
#[derive(Debug)]
pub struct WatchedMachine {
    bodies: MachineBodies,
    watch: ClearanceOptions,
}

impl WatchedMachine {
    /// Builds the bodies of a machine; `None` if it has none. Lines nearer than `clearance` \[mm\] are reported.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Bodies`] for a body that cannot be used, or that runs into another one at home.
    pub fn new(machine: &Machine, clearance: f64) -> Result<Option<Self>, VerifyError> {
        let watch = ClearanceOptions { tolerance: TOLERANCE, clearance, worst: MOST_COLLISIONS };
        Ok(MachineBodies::new(machine, TOLERANCE)?.map(|bodies| Self { bodies, watch }))
    }

    /// Adds a fixture, which may stand out beyond the solid by `allowance` \[mm\].
    pub fn hold(&mut self, name: &str, solid: &Solid, allowance: f64) {
        self.bodies.hold(name, solid, allowance);
    }

    /// Adds the uncut stock.
    pub fn hold_stock(&mut self, solid: &Solid) {
        self.bodies.hold_stock(solid);
    }

    /// Returns the bodies.
    pub fn bodies(&self) -> &MachineBodies {
        &self.bodies
    }

    /// Returns the clearance that they must keep.
    pub fn watch(&self) -> &ClearanceOptions {
        &self.watch
    }

    /// Returns the summary of their distances over a program.
    pub fn summary(&self, found: &BodyReport) -> BodiesSummary {
        let meeting = |one: &crate::verify::BodyMeeting| BodyMeetingSummary {
            bodies: one.bodies.clone(),
            why: one.why.to_owned(),
        };
        BodiesSummary {
            tolerance: self.watch.tolerance,
            clearance: self.watch.clearance,
            pairs: found.pairs,
            left_out: self.bodies.left_out().iter().map(meeting).collect(),
            least: found.least.as_ref().map(approach),
            near: found.near.iter().map(approach).collect(),
            lines: found.lines.map(lines),
            hits: found.hits.map(lines),
        }
    }
}

fn approach(found: &BodyApproach) -> BodyApproachSummary {
    let BodyApproach { line, bodies, distance, point, .. } = found;
    let point = point.coords.into();
    BodyApproachSummary { line: *line, bodies: bodies.clone(), distance: *distance, point }
}

/// Describes the lines on which bodies touch or come too near: the first of them, and the number of the others.
pub fn bodies_too_near(bodies: &BodiesSummary) -> Vec<String> {
    let line = |near: &BodyApproachSummary| {
        let BodyApproachSummary { line, bodies: [one, other], distance, point: [x, y, z] } = near;
        let place = format!("at X {x:.3} Y {y:.3} Z {z:.3}");
        if *distance < 0.0 {
            format!("line {line}: {one} and {other} run into each other {place}")
        } else {
            let least = bodies.clearance;
            format!(
                "line {line}: {distance:.3} mm between {one} and {other} {place}, nearer than {least} mm"
            )
        }
    };
    let mut reported: Vec<String> = bodies.near.iter().take(MOST_LISTED).map(line).collect();
    let count = bodies.lines.map_or(0, |lines| lines.count);
    if count > reported.len() {
        reported.push(format!(
            "and {} more lines on which bodies of the machine come too near",
            count - reported.len()
        ));
    }
    reported
}

/// Describes the least distance, its line, and its tolerance.
pub fn nearest_bodies(bodies: &BodiesSummary) -> String {
    let pairs = format!("{} pairs compared", bodies.pairs);
    match &bodies.least {
        Some(BodyApproachSummary { line, bodies: [one, other], distance, .. })
            if *distance < 0.0 =>
        {
            format!("{one} and {other} run into each other, line {line}; {pairs}")
        }
        Some(BodyApproachSummary { line, bodies: [one, other], distance, .. }) => {
            let within = bodies.tolerance;
            format!(
                "{distance:.3} mm between {one} and {other}, line {line}; to within {within} mm or 1 %; {pairs}"
            )
        }
        None => pairs,
    }
}
