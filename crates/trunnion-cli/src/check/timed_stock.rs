//! Stock of a program as it is cut, for pictures.

use super::args::CheckArgs;
use super::subject::Subject;
use crate::outcome::Failure;
use nalgebra::{Point3, Vector3};
use trunnion::import::inspect;
use trunnion::types::Progress;
use trunnion::verify::{Solid, Stock, TimedStock};

/// Origin of the stock that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StockSource {
    /// The job or the options name it.
    Stated,
    /// Nobody names one: it is the box around the part.
    PartBox,
}

/// Stock of a program for callers that draw it as it is cut.
#[derive(Debug)]
#[non_exhaustive]
pub struct TimedStockAnswer {
    /// The stock, not yet cut.
    pub stock: TimedStock,
    /// Distance of its rays along x, y and z \[mm\].
    pub cell: [f64; 3],
    /// Its origin.
    pub source: StockSource,
}

/// Most rays of a stock that is drawn: enough for 200 x 200 x 100 mm at 0.5 mm, and cut in a fraction of a second.
const MOST_DRAWN_RAYS: f64 = 400_000.0;
/// Fewest rays along its longest side: a small part would have no shape at the usual distance.
const FEWEST_RAYS: f64 = 120.0;

/// Prepares the stock of a program to be cut in a picture, with rays about `cell` \[mm\] apart: closer on small stock, farther
/// on large. Returns nothing without stock and part. Nothing is written.
pub(crate) fn timed_stock(
    args: &CheckArgs,
    cell: f64,
    progress: &dyn Progress,
) -> Result<Option<TimedStockAnswer>, Failure> {
    let subject = Subject::load(args, progress)?;
    let Some((solid, source)) = drawn_solid(&subject, cell) else { return Ok(None) };
    let cell = drawn_cell(&solid, cell);
    // Every side has a ray more at most than its length has cells.
    let stock = Stock::new(&solid, cell, usize::MAX);
    let stock = stock.map_err(|error| Failure::input(format!("the stock: {error}")))?;
    let timed = subject.timed_stock(&stock)?;
    Ok(Some(TimedStockAnswer { stock: timed, cell: stock.cell(), source }))
}

/// Returns the origin of the stock that a picture of a program shows; `None` without stock and part.
pub(super) fn stock_source(subject: &Subject) -> Option<StockSource> {
    if subject.stock().is_some() {
        return Some(StockSource::Stated);
    }
    let mut faces = subject.faces.iter().chain(&subject.others);
    faces.next().map(|_| StockSource::PartBox)
}

fn drawn_solid(subject: &Subject, cell: f64) -> Option<(Solid, StockSource)> {
    let source = stock_source(subject)?;
    let solid = match source {
        StockSource::Stated => subject.stock()?.solid()?.clone(),
        StockSource::PartBox => part_box(subject, cell)?,
    };
    Some((solid, source))
}

/// Returns the box around the part; flat sides are one cell thick.
fn part_box(subject: &Subject, cell: f64) -> Option<Solid> {
    let corners = subject.faces.iter().chain(&subject.others);
    let mut corners = corners.flat_map(|face| inspect::summary(face).bounds);
    let first = corners.next()?;
    let [low, high]: [Point3<f64>; 2] =
        corners.fold([first; 2], |[low, high], corner| [low.inf(&corner), high.sup(&corner)]);
    let more = (high - low).map(|side| 0.5 * (cell - side).max(0.0));
    Some(Solid::Box { low: low - more, high: high + more })
}

/// Returns the distance of rays \[mm\] at which a solid is drawn where `wanted` is usual.
fn drawn_cell(solid: &Solid, wanted: f64) -> f64 {
    let size = solid.bounds().map_or_else(Vector3::zeros, |[low, high]| high - low);
    let across = size.x * size.y + size.y * size.z + size.z * size.x;
    let least = (across / MOST_DRAWN_RAYS).sqrt();
    wanted.min(size.amax() / FEWEST_RAYS).max(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_as_far_apart_as_the_size_of_the_stock_allows() {
        let block = |x: f64, y: f64, z: f64| Solid::Box {
            low: Point3::origin(),
            high: Point3::new(x, y, z),
        };
        assert!((drawn_cell(&block(200.0, 200.0, 100.0), 0.5) - 0.5).abs() < 1e-12);
        assert!((drawn_cell(&block(30.0, 20.0, 10.0), 0.5) - 0.25).abs() < 1e-12);
        let large = block(800.0, 600.0, 300.0);
        let cell = drawn_cell(&large, 0.5);
        assert!(cell > 1.0, "{cell}");
        let rays = Stock::new(&large, cell, usize::MAX).unwrap().rays();
        assert!((rays as f64) < 1.02 * MOST_DRAWN_RAYS, "{rays}");
    }
}
