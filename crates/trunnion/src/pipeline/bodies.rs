//! Bodies of the machine of a job, and their distances over its programs.

use super::fixtures::{MOST_COLLISIONS, lines};
use crate::files::summary::{BodiesSummary, BodyApproachSummary, BodyMeetingSummary};
use crate::machine::Machine;
use crate::verify::{
    BodyApproach, BodyReport, ClearanceOptions, MachineBodies, Solid, VerifyError,
};

/// Tolerance of the distances between bodies \[mm\].
const TOLERANCE: f64 = 0.01;

/// Most pairs of bodies that come too near which are listed one by one.
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

/// Describes the pairs of bodies that touch or come too near: the nearest line of each, and the number of its others.
pub fn bodies_too_near(bodies: &BodiesSummary) -> Vec<String> {
    let mut pairs: Vec<Vec<&BodyApproachSummary>> = Vec::new();
    for near in &bodies.near {
        match pairs.iter_mut().find(|pair| pair.iter().any(|known| known.bodies == near.bodies)) {
            Some(pair) => pair.push(near),
            None => pairs.push(vec![near]),
        }
    }
    let listed = pairs.iter().take(MOST_LISTED);
    let mut reported: Vec<String> =
        listed.clone().filter_map(|pair| describe_pair(pair, bodies.clearance)).collect();
    let described: usize = listed.map(Vec::len).sum();
    let count = bodies.lines.map_or(0, |lines| lines.count);
    if count > described {
        reported.push(format!(
            "and {} more lines on which bodies of the machine come too near",
            count - described
        ));
    }
    reported
}

/// Describes the nearest of the lines on which two bodies are nearer than `clearance` \[mm\], and the range of the others.
fn describe_pair(lines: &[&BodyApproachSummary], clearance: f64) -> Option<String> {
    let nearest = lines.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
    let BodyApproachSummary { line, bodies: [one, other], distance, point: [x, y, z] } = nearest;
    let place = format!("at X {x:.3} Y {y:.3} Z {z:.3}");
    let what = if *distance < 0.0 {
        format!("line {line}: {one} and {other} run into each other {place}")
    } else {
        format!(
            "line {line}: {distance:.3} mm between {one} and {other} {place}, nearer than {clearance} mm"
        )
    };
    let others = || lines.iter().map(|near| near.line).filter(|other| other != line);
    let (Some(first), Some(last)) = (others().min(), others().max()) else { return Some(what) };
    Some(match others().count() {
        1 => format!("{what}; too near on line {first} as well"),
        count => format!("{what}; too near on {count} other lines as well, {first} to {last}"),
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::summary::LinesSummary;

    #[test]
    fn a_pair_is_one_entry() {
        let near = |line: u32, other: &str, distance: f64| BodyApproachSummary {
            line,
            bodies: ["arm".to_owned(), other.to_owned()],
            distance,
            point: [0.0; 3],
        };
        let bodies = BodiesSummary {
            tolerance: TOLERANCE,
            clearance: 2.0,
            pairs: 3,
            left_out: Vec::new(),
            least: None,
            near: vec![
                near(7, "post", 0.5),
                near(9, "bed", -0.1),
                near(5, "post", 0.7),
                near(12, "post", 1.0),
            ],
            lines: Some(LinesSummary { count: 6, first: 3, last: 20 }),
            hits: None,
        };
        let at = "at X 0.000 Y 0.000 Z 0.000";
        assert_eq!(
            bodies_too_near(&bodies),
            [
                format!(
                    "line 7: 0.500 mm between arm and post {at}, nearer than 2 mm; too near on 2 other lines as well, 5 to 12"
                ),
                format!("line 9: arm and bed run into each other {at}"),
                "and 2 more lines on which bodies of the machine come too near".to_owned(),
            ]
        );
    }
}
