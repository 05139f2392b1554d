//! Fixtures of a job, and how near its programs come to them.
//!
//! Programs are checked against fixtures; planning does not avoid them.

use super::job::Job;
use super::material::{MOST_COLLISIONS, lines, plain};
use super::programs::Program;
use crate::cover;
use crate::files::job;
use crate::files::summary::{ApproachSummary, FixturesSummary};
use crate::verify::{
    ClearanceOptions, ClearanceReport, Collision, CollisionKind, DEPTH_SHARE, Fixture,
    FixtureApproach, Solid, StockReport, VerifyError,
};

/// Share of the total tolerance within which distances from fixtures are found, and the largest such tolerance \[mm\].
const SHARE: f64 = 0.05;
const LARGEST: f64 = 1e-3;
/// Share of it by which the triangles of a cylinder may be off.
const CHORD_SHARE: f64 = 0.1;
/// Lines too near a fixture that are told one by one.
const TOLD: usize = 10;

/// A solid that the tool must not touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// What findings call it.
    pub name: String,
    /// What it is; `None` for one in a file that was not read: [`Job::with_fixture`].
    pub solid: Option<Solid>,
    /// By how much it may be larger than that \[mm\].
    pub allowance: f64,
}

impl Held {
    pub(super) fn of(fixture: &job::Fixture) -> Self {
        Self {
            name: fixture.name.clone(),
            solid: plain(&fixture.solid),
            allowance: fixture.solid.chord().unwrap_or(0.0),
        }
    }
}

/// Fixtures with their names, and what is asked of the moves.
#[derive(Debug)]
pub struct Fixtures {
    all: Vec<Fixture>,
    names: Vec<String>,
    watch: ClearanceOptions,
}

impl Fixtures {
    /// None yet. `total` \[mm\]: tolerance of the part; lines nearer than `clearance` \[mm\] are told.
    pub fn new(total: f64, clearance: f64) -> Self {
        let tolerance = LARGEST.min(SHARE * total);
        let watch = ClearanceOptions { tolerance, clearance, worst: MOST_COLLISIONS };
        Self { all: Vec::new(), names: Vec::new(), watch }
    }

    /// One more.
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

    /// The fixtures.
    pub fn all(&self) -> &[Fixture] {
        &self.all
    }

    /// What is asked of the moves.
    pub fn watch(&self) -> &ClearanceOptions {
        &self.watch
    }

    /// How near a program comes to them, in numbers.
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

/// What a program runs into, with how many lines there are: in stock, where there is any, and in fixtures.
pub fn collisions(
    carving: Option<&StockReport>,
    clearance: Option<&ClearanceReport>,
) -> (Vec<Collision>, usize) {
    match (carving, clearance) {
        (Some(carving), _) => (carving.collisions.clone(), carving.count()),
        (None, Some(clearance)) => {
            let hits = clearance.near.iter().filter_map(FixtureApproach::collision);
            (hits.collect(), clearance.hits.map_or(0, |hits| hits.count))
        }
        (None, None) => (Vec::new(), 0),
    }
}

/// Lines that run into no fixture, but come too near: in words, the first of them.
pub fn too_near(fixtures: &FixturesSummary) -> Vec<String> {
    let outside: Vec<_> = fixtures.near.iter().filter(|near| near.distance >= 0.0).collect();
    let line = |near: &&ApproachSummary| {
        format!("{}, nearer than {} mm", approach(near), fixtures.clearance)
    };
    let mut told: Vec<String> = outside.iter().take(TOLD).map(line).collect();
    let hits = fixtures.hits.map_or(0, |hits| hits.count);
    let count = fixtures.lines.map_or(0, |lines| lines.count.saturating_sub(hits));
    if count > told.len() {
        told.push(format!("and {} more lines too near a fixture", count - told.len()));
    }
    told
}

/// The least distance, its line, and how certain it is.
pub fn nearest_fixture(fixtures: &FixturesSummary) -> String {
    fixtures.least.as_ref().map_or_else(String::new, |least| {
        let exact = if -DEPTH_SHARE * least.distance > fixtures.tolerance {
            format!("{} % of the depth", 100.0 * DEPTH_SHARE)
        } else {
            format!("{} mm", fixtures.tolerance)
        };
        format!("{}, line {}; to within {exact}", words(least), least.line)
    })
}

/// How near a line comes to a fixture, in words.
pub fn approach(near: &ApproachSummary) -> String {
    format!("line {}: {}", near.line, words(near))
}

fn words(ApproachSummary { fixture, distance, point: [x, y, z], .. }: &ApproachSummary) -> String {
    let side = if *distance < 0.0 { "deep in" } else { "from" };
    format!("{:.4} mm {side} {fixture} at X {x:.3} Y {y:.3} Z {z:.3}", distance.abs())
}

/// A collision in words, with the name of the fixture.
pub(super) fn told(hit: &Collision, fixtures: Option<&FixturesSummary>) -> String {
    let off = |near: &ApproachSummary| (near.distance + hit.depth).abs();
    let all = fixtures.iter().flat_map(|fixtures| &fixtures.near);
    let on_line = all.filter(|near| near.line == hit.line && near.distance < 0.0);
    let nearest = on_line.min_by(|a, b| off(a).total_cmp(&off(b)));
    match nearest.filter(|_| hit.kind == CollisionKind::Fixture) {
        Some(ApproachSummary { line, fixture, distance, point: [x, y, z] }) => format!(
            "line {line}: runs into {fixture}, {:.4} mm deep at X {x:.3} Y {y:.3} Z {z:.3}",
            -distance
        ),
        None => hit.to_string(),
    }
}

/// What to do where programs of the job come too near fixtures.
pub(super) fn remedy(job: &Job, programs: &[Program]) -> Option<String> {
    let [links, cuts] = [0, 1].map(|of| programs.iter().any(|program| program.too_near[of]));
    let links = links.then(|| over(job));
    let cuts = cuts.then(|| {
        "cuts or their leads come too near: move the fixture or the part, or take a longer tool or a slimmer holder"
            .to_owned()
    });
    let what: Vec<String> = [links, cuts].into_iter().flatten().collect();
    (!what.is_empty()).then(|| format!("fixtures are checked, not avoided; {}", what.join("; ")))
}

/// How links get over fixtures.
fn over(job: &Job) -> String {
    let (up, file) = (job.up(), &job.file);
    let clearance = file.setup.clearance;
    let links = job.highest(&up) + clearance;
    let tops = job.fixtures.iter().filter_map(|held| {
        let bounds = held.solid.as_ref()?.bounds()?;
        Some((cover::height(&[bounds], &up) + held.allowance, &held.name))
    });
    let tallest = tops.max_by(|a, b| a.0.total_cmp(&b.0));
    let higher = tallest.map(|(top, name)| (top - links, name)).filter(|(above, _)| *above > 0.0);
    if let Some((above, name)) = higher {
        let least = clearance + above + file.fixture_clearance;
        return format!(
            "links come too near: {name} stands {above:.3} mm higher than they travel; setup.clearance, {clearance} mm now, \
             above {least:.3} mm passes over it"
        );
    }
    match file.strategy.links {
        job::Links::Hop => {
            "links come too near below the height at which they travel: strategy.links = \"retract\" keeps them up from pass \
             to pass; where they come down to one, move the fixture or the part"
        }
        job::Links::Retract => {
            "links come too near where they come down to a pass: move the fixture or the part"
        }
    }
    .to_owned()
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
        let fixture = told(&hit(CollisionKind::Fixture), Some(&summary));
        assert_eq!(fixture, "line 7: runs into clamp, 0.2500 mm deep at X 1.000 Y 2.000 Z 3.000");
        let holder = told(&hit(CollisionKind::Holder), Some(&summary));
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
