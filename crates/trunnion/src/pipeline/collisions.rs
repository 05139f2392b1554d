//! Collisions of a program, as numbers and in words.

use super::bodies::bodies_too_near;
use super::fixtures::{self, lines};
use super::program::CheckedProgram;
use super::solids::Solids;
use crate::files::summary::{
    BodiesSummary, CollisionSummary, FixturesSummary, KindSummary, StockSummary, UndecidedSummary,
};
use crate::verify::{Collision, CollisionKind, Stock, StockReport, UndecidedCollision};

/// Most collisions of a program that are listed one by one.
const MOST_LISTED: usize = 10;

/// Returns the summary of a stock that was cut; `left` is the stock that remains.
pub fn stock_summary(carving: &StockReport, left: &Stock) -> StockSummary {
    let collision = |collision: &Collision| CollisionSummary {
        kind: word(collision.kind),
        line: collision.line,
        depth: collision.depth,
        point: collision.point.coords.into(),
    };
    StockSummary {
        cell: left.cell(),
        removed: carving.removed,
        left: carving.left,
        collisions: carving.collisions.iter().map(collision).collect(),
        collision_lines: carving
            .lines
            .iter()
            .map(|(kind, all)| KindSummary { kind: word(*kind), lines: lines(*all) })
            .collect(),
        undecided: carving.undecided.map(|UndecidedCollision { kind, line, depth }| {
            UndecidedSummary { kind: word(kind), line, depth }
        }),
    }
}

fn word(kind: CollisionKind) -> String {
    match kind {
        CollisionKind::Rapid => "rapid",
        CollisionKind::Holder => "holder",
        CollisionKind::Fixture => "fixture",
    }
    .to_owned()
}

/// Describes collisions, with the names of the fixtures: the first of those kept, and the number of the others.
///
/// `count` is the number of all lines in collision.
pub fn describe_collisions(
    kept: &[Collision],
    count: usize,
    fixtures: Option<&FixturesSummary>,
) -> Vec<String> {
    let one = |hit: &Collision| fixtures::describe_collision(hit, fixtures);
    let mut reported: Vec<String> = kept.iter().take(MOST_LISTED).map(one).collect();
    if count > reported.len() {
        reported.push(format!("and {} more lines that run into something", count - reported.len()));
    }
    reported
}

/// Reports the collisions of a program, and the lines too near a fixture.
pub(super) fn failures(program: &CheckedProgram, solids: &Solids) -> Vec<String> {
    let carving = program.carving.as_ref().map(|stock| &stock.report);
    let (kept, count) = fixtures::collisions(carving, program.clearance.as_ref());
    let summary = fixtures_summary(program, solids);
    let near = summary.iter().flat_map(fixtures::too_near);
    let bodies = bodies_summary(program, solids);
    let bodies = bodies.iter().flat_map(bodies_too_near);
    let reported = describe_collisions(&kept, count, summary.as_ref()).into_iter();
    let reported = reported.chain(near).chain(bodies);
    reported.map(|what| format!("{}: {what}", program.file)).collect()
}

/// Returns the clearance of a program from the fixtures.
pub(super) fn fixtures_summary(
    program: &CheckedProgram,
    solids: &Solids,
) -> Option<FixturesSummary> {
    Some(solids.fixtures.as_ref()?.summary(program.clearance.as_ref()?))
}

/// Returns the distances of the machine's bodies over a program.
pub(super) fn bodies_summary(program: &CheckedProgram, solids: &Solids) -> Option<BodiesSummary> {
    Some(solids.machine.as_ref()?.summary(program.bodies.as_ref()?))
}
