//! Fixtures of a job, and the clearance of its programs from them.
//!
//! Passes and links are planned round fixtures (see [`super::guards`]), and programs are checked against them.

use super::stock_solid::plain_solid;
use crate::files::job;
use crate::files::summary::{ApproachSummary, FixturesSummary, LinesSummary};
use crate::verify::{
    ClearanceOptions, ClearanceReport, Collision, CollisionKind, DEPTH_SHARE, Fixture,
    FixtureApproach, LineCount, Solid, StockReport, VerifyError,
};

/// Tolerance of the distances from fixtures, as a share of the total tolerance.
const SHARE: f64 = 0.05;

/// Largest tolerance of the distances from fixtures \[mm\].
const LARGEST: f64 = 1e-3;

/// Chord tolerance of a cylinder, as a share of the distance tolerance.
const CHORD_SHARE: f64 = 0.1;

/// Most lines too near a fixture that are listed one by one.
const MOST_LISTED: usize = 10;

/// Lines in collision of each kind that are kept: some hundreds of kilobytes.
pub const MOST_COLLISIONS: usize = 1000;

/// Solid that the tool must not touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Name in findings.
    pub name: String,
    /// The solid; `None` if its file was not read: [`Job::with_fixture`](super::Job::with_fixture).
    pub solid: Option<Solid>,
    /// Upper bound on the real fixture beyond the solid \[mm\].
    pub allowance: f64,
}

/// Returns lines as the summary has them.
pub(super) fn lines(LineCount { count, first, last }: LineCount) -> LinesSummary {
    LinesSummary { count, first, last }
}

impl Held {
    pub(super) fn of(fixture: &job::JobFixture) -> Self {
        Self {
            name: fixture.name.clone(),
            solid: plain_solid(&fixture.solid),
            allowance: fixture.solid.chord().unwrap_or(0.0),
        }
    }
}

/// Fixtures with their names, and the clearance that moves must keep.
#[derive(Debug)]
pub struct Fixtures {
    all: Vec<Fixture>,
    names: Vec<String>,
    watch: ClearanceOptions,
}

impl Fixtures {
    /// Creates an empty set. `total` \[mm\] is the tolerance of the part; lines nearer than `clearance` \[mm\] are
    /// reported.
    pub fn new(total: f64, clearance: f64) -> Self {
        // Distances are found more accurately than the part is made.
        let tolerance = LARGEST.min(SHARE * total);
        let watch = ClearanceOptions { tolerance, clearance, worst: MOST_COLLISIONS };
        Self { all: Vec::new(), names: Vec::new(), watch }
    }

    /// Adds a fixture.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Stock`] for a solid without volume, one that is not closed, or a file that was not read.
    pub fn add(&mut self, held: &Held) -> Result<(), VerifyError> {
        let unread = || VerifyError::Stock { what: "is in a file that was not read".to_owned() };
        let solid = held.solid.as_ref().ok_or_else(unread)?;
        let fixture = Fixture::new(solid, CHORD_SHARE * self.watch.tolerance)?;
        self.all.push(fixture.grown(held.allowance));
        self.names.push(held.name.clone());
        Ok(())
    }

    /// Returns the fixtures.
    pub fn all(&self) -> &[Fixture] {
        &self.all
    }

    /// Returns the clearance that moves must keep.
    pub fn watch(&self) -> &ClearanceOptions {
        &self.watch
    }

    /// Returns the summary of the clearance of a program.
    pub fn summary(&self, found: &ClearanceReport) -> FixturesSummary {
        FixturesSummary {
            tolerance: self.watch.tolerance,
            clearance: self.watch.clearance,
            least: found.least.as_ref().map(|least| self.place(least)),
            near: found.near.iter().map(|near| self.place(near)).collect(),
            lines: found.lines.map(lines),
            hits: found.hits.map(lines),
        }
    }

    fn place(&self, approach: &FixtureApproach) -> ApproachSummary {
        let &FixtureApproach { line, fixture, distance, point } = approach;
        let fixture = self.names.get(fixture).cloned().unwrap_or_default();
        ApproachSummary { line, fixture, distance, point: point.coords.into() }
    }
}

/// Returns the collisions of a program with stock and fixtures, and the number of all lines in collision.
pub fn collisions(
    carving: Option<&StockReport>,
    clearance: Option<&ClearanceReport>,
) -> (Vec<Collision>, usize) {
    match (carving, clearance) {
        // With stock, its report has the fixtures' collisions as well.
        (Some(carving), _) => (carving.collisions.clone(), carving.count()),
        (None, Some(clearance)) => {
            let hits = clearance.near.iter().filter_map(FixtureApproach::collision);
            (hits.collect(), clearance.hits.map_or(0, |hits| hits.count))
        }
        (None, None) => (Vec::new(), 0),
    }
}

/// Describes the first lines that come too near a fixture without touching it.
pub fn too_near(fixtures: &FixturesSummary) -> Vec<String> {
    // Contacts are collisions, which are reported as such.
    let outside: Vec<_> = fixtures.near.iter().filter(|near| near.distance >= 0.0).collect();
    let line = |near: &&ApproachSummary| {
        format!("{}, nearer than {} mm", approach(near), fixtures.clearance)
    };
    let mut reported: Vec<String> = outside.iter().take(MOST_LISTED).map(line).collect();
    let hits = fixtures.hits.map_or(0, |hits| hits.count);
    let count = fixtures.lines.map_or(0, |lines| lines.count.saturating_sub(hits));
    if count > reported.len() {
        reported.push(format!("and {} more lines too near a fixture", count - reported.len()));
    }
    reported
}

/// Describes the least distance, its line, and its tolerance.
pub fn nearest_fixture(fixtures: &FixturesSummary) -> String {
    fixtures.least.as_ref().map_or_else(String::new, |least| {
        // Depths are known to a share of themselves, distances to a length: the larger is stated.
        let exact = if -DEPTH_SHARE * least.distance > fixtures.tolerance {
            format!("{} % of the depth", 100.0 * DEPTH_SHARE)
        } else {
            format!("{} mm", fixtures.tolerance)
        };
        format!("{}, line {}; to within {exact}", describe(least), least.line)
    })
}

/// Describes the distance of a line from a fixture.
pub fn approach(near: &ApproachSummary) -> String {
    format!("line {}: {}", near.line, describe(near))
}

fn describe(
    ApproachSummary { fixture, distance, point: [x, y, z], .. }: &ApproachSummary,
) -> String {
    let side = if *distance < 0.0 { "deep in" } else { "from" };
    format!("{:.4} mm {side} {fixture} at X {x:.3} Y {y:.3} Z {z:.3}", distance.abs())
}

/// Describes a collision, with the name of the fixture.
pub(super) fn describe_collision(hit: &Collision, fixtures: Option<&FixturesSummary>) -> String {
    let off = |near: &ApproachSummary| (near.distance + hit.depth).abs();
    let all = fixtures.iter().flat_map(|fixtures| &fixtures.near);
    let on_line = all.filter(|near| near.line == hit.line && near.distance < 0.0);
    // A line that runs twice has several approaches: the one with this depth is meant.
    let nearest = on_line.min_by(|a, b| off(a).total_cmp(&off(b)));
    match nearest.filter(|_| hit.kind == CollisionKind::Fixture) {
        Some(ApproachSummary { line, fixture, distance, point: [x, y, z] }) => format!(
            "line {line}: runs into {fixture}, {:.4} mm deep at X {x:.3} Y {y:.3} Z {z:.3}",
            -distance
        ),
        None => hit.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn hits_name_their_fixture() {
        let near = |fixture: &str, distance: f64| ApproachSummary {
            line: 7,
            fixture: fixture.to_owned(),
            distance,
            point: [1.0, 2.0, 3.0],
        };
        let mut summary = Fixtures::new(0.02, 0.5).summary(&ClearanceReport {
            least: None,
            near: Vec::new(),
            lines: None,
            hits: None,
        });
        // The program came to line 7 twice.
        summary.near = vec![near("vise", -0.5), near("clamp", -0.25), near("pin", 0.125)];
        let point = Point3::new(1.0, 2.0, 3.0);
        let hit = |kind| Collision { kind, line: 7, depth: 0.25, point };
        let fixture = describe_collision(&hit(CollisionKind::Fixture), Some(&summary));
        assert_eq!(fixture, "line 7: runs into clamp, 0.2500 mm deep at X 1.000 Y 2.000 Z 3.000");
        let holder = describe_collision(&hit(CollisionKind::Holder), Some(&summary));
        assert!(holder.starts_with("line 7: shank or holder run into the stock"), "{holder}");
        let near = too_near(&summary);
        assert_eq!(
            near,
            ["line 7: 0.1250 mm from pin at X 1.000 Y 2.000 Z 3.000, nearer than 0.5 mm"]
        );
        assert!(nearest_fixture(&summary).is_empty());
        let unread = Held { name: "vise".to_owned(), solid: None, allowance: 0.0 };
        let refused = Fixtures::new(0.02, 0.0).add(&unread).unwrap_err().to_string();
        assert!(refused.contains("was not read"), "{refused}");
    }
}
