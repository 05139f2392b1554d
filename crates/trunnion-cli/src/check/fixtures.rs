//! Fixtures as arguments, and how near the tool came to them.

use super::stock;
use crate::outcome::Failure;
use trunnion::files::summary::LinesSummary;
use trunnion::pipeline;
use trunnion::verify::{Approach, Clearance, DEPTH_SHARE, Fixture, Watch};

/// Share of the total tolerance within which distances from fixtures are found, and the largest such tolerance \[mm\].
const SHARE: f64 = 0.05;
const LARGEST: f64 = 1e-3;
/// Share of it by which the triangles of a cylinder may be off.
const CHORD_SHARE: f64 = 0.1;
/// Lines too near a fixture that are told one by one.
const TOLD: usize = 10;

/// Fixtures with the words that name them.
pub(super) struct Fixtures {
    pub(super) all: Vec<Fixture>,
    names: Vec<String>,
    pub(super) watch: Watch,
}

impl Fixtures {
    /// `total` \[mm\]: tolerance of the part; `chord` \[mm\]: how far triangles of STEP solids may be off their faces,
    /// by which these are taken to be larger.
    pub(super) fn read(
        said: &[String],
        clearance: f64,
        [total, chord]: [f64; 2],
    ) -> Result<Self, Failure> {
        let tolerance = LARGEST.min(SHARE * total);
        let one = |said: &String| {
            let fixture = Fixture::new(&stock::read(said, chord)?, CHORD_SHARE * tolerance)
                .map_err(|error| Failure::input(format!("{said}: {error}")))?;
            Ok(fixture.grown(if stock::is_step(said) { chord } else { 0.0 }))
        };
        let all: Result<Vec<Fixture>, Failure> = said.iter().map(one).collect();
        let watch = Watch { tolerance, clearance, worst: pipeline::MOST_COLLISIONS };
        Ok(Self { all: all?, names: said.to_vec(), watch })
    }

    pub(super) fn told(&self, found: &Clearance) -> FixturesTold {
        FixturesTold {
            tolerance: self.watch.tolerance,
            clearance: self.watch.clearance,
            least: found.least.as_ref().map(|least| self.place(least)),
            near: found.near.iter().map(|near| self.place(near)).collect(),
            lines: found.lines.map(pipeline::lines),
            hits: found.hits.map(pipeline::lines),
        }
    }

    fn place(&self, approach: &Approach) -> ApproachTold {
        let &Approach { line, fixture, distance, point } = approach;
        let fixture = self.names.get(fixture).cloned().unwrap_or_default();
        ApproachTold { line, fixture, distance, point: point.coords.into() }
    }
}

/// How near the tool comes to fixtures.
#[derive(Debug, serde::Serialize)]
pub(super) struct FixturesTold {
    /// Nowhere is it nearer than told by more than this.
    tolerance: f64,
    /// Lines nearer than this are told.
    clearance: f64,
    /// Where it is nearest in the whole program.
    pub(super) least: Option<ApproachTold>,
    /// The nearest of them, and how many there are.
    pub(super) near: Vec<ApproachTold>,
    lines: Option<LinesSummary>,
    /// Of them, those that run into a fixture.
    hits: Option<LinesSummary>,
}

#[derive(Debug, serde::Serialize)]
pub(super) struct ApproachTold {
    pub(super) line: u32,
    fixture: String,
    /// Below 0 the tool runs into the fixture.
    pub(super) distance: f64,
    point: [f64; 3],
}

impl FixturesTold {
    /// Lines that run into none, but come too near.
    pub(super) fn failures(&self) -> Vec<String> {
        let outside: Vec<_> = self.near.iter().filter(|near| near.distance >= 0.0).collect();
        let line = |near: &&ApproachTold| {
            format!("line {}: {}, nearer than {} mm", near.line, near.words(), self.clearance)
        };
        let mut told: Vec<String> = outside.iter().take(TOLD).map(line).collect();
        let hits = self.hits.map_or(0, |hits| hits.count);
        let count = self.lines.map_or(0, |lines| lines.count.saturating_sub(hits));
        if count > told.len() {
            told.push(format!("and {} more lines too near a fixture", count - told.len()));
        }
        told
    }

    pub(super) fn words(&self) -> String {
        self.least.as_ref().map_or_else(String::new, |least| {
            let exact = if least.distance < 0.0 {
                format!("{} % of the depth", 100.0 * DEPTH_SHARE)
            } else {
                format!("{} mm", self.tolerance)
            };
            format!("{}, line {}; to within {exact}", least.words(), least.line)
        })
    }
}

impl ApproachTold {
    fn words(&self) -> String {
        let Self { fixture, distance, point: [x, y, z], .. } = self;
        format!("{distance:.4} mm from {fixture} at X {x:.3} Y {y:.3} Z {z:.3}")
    }
}
