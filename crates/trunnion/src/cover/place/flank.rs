//! Flank passes: the side of the tool lies along the straight lines of a face.
//!
//! On planes, cylinders, cones and extrusions the tool touches the whole line: one pass finishes the face over the height of
//! the tool's straight side, without any scallop. On other ruled faces the side follows the line within the tolerance, as
//! far as the face does not twist too much.

use crate::cover::flank_refusal::FlankRefusal;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::options::{CoverOptions, lever};
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::rulings::{FlankAxis, RuledFace};
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Station, Uv};
use rayon::prelude::*;

/// Run of the tip beyond the lower end of the rulings where nothing is in its way, as a share of the radius, and at
/// most \[mm\].
const OVERRUN: [f64; 2] = [0.5, 2.0];

/// Share of the straight side that stays above the upper end of the rulings.
const SPARE: f64 = 0.02;

/// Halvings of the range in which the lowest tip is sought: from millimetres to nanometres.
const HALVINGS: u32 = 22;

/// Poses at which the tip is kept off the other faces in that search.
const TIP_POSES: usize = 48;

/// Returns the straight side of the tool above its corner \[mm\].
fn straight_side(cutter: &Cutter) -> [f64; 2] {
    let top = cutter.spec().shank.first().map_or(cutter.length(), |&[height, _]| height);
    [cutter.minor(), top]
}

/// Axes of a tool whose side lies along the rulings of a face.
struct FlankAxes<'a> {
    ruled: RuledFace<'a>,
    places: Vec<f64>,
    axes: Vec<FlankAxis>,
}

impl<'a> FlankAxes<'a> {
    fn new(
        face: &'a FaceIndex,
        cutter: &Cutter,
        options: &CoverOptions,
    ) -> Result<Self, FlankRefusal> {
        let ruled = RuledFace::new(face).ok_or(FlankRefusal::NoRulings)?;
        // The tool has to be as long as the rulings, and on a concave face narrower than it.
        let [corner, top] = straight_side(cutter);
        let side = top * (1.0 - SPARE) - corner;
        if side < ruled.height {
            return Err(FlankRefusal::Short { ruling: ruled.height, side });
        }
        let (concave, radius) = (face.smallest_concave_radius(), cutter.radius());
        if concave <= radius {
            return Err(FlankRefusal::Concave { concave, radius });
        }
        let places = ruled.stations(options.spacing.high, radius, options.band);
        let places = places.ok_or(FlankRefusal::Twisted { radius })?;
        let axes: Option<Vec<FlankAxis>> =
            places.par_iter().map(|at| ruled.axis(*at, radius, options.band)).collect();
        Ok(Self { ruled, axes: axes.ok_or(FlankRefusal::Twisted { radius })?, places })
    }

    /// Returns the stations with the tip at a height above the lower ends of the rulings, touching in their middle.
    fn stations(&self, tip: f64) -> Option<Vec<Station>> {
        let station = |(at, axis): (&f64, &FlankAxis)| {
            Some(Station { pose: axis.pose(tip), contact: self.ruled.ruling(*at)?.middle() })
        };
        self.places.iter().zip(&self.axes).map(station).collect()
    }
}

/// Checks whether the flank of a tool can lie along the straight lines of a face, other faces apart.
///
/// # Errors
///
/// The first reason why not.
pub fn flank_fits(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
) -> Result<(), FlankRefusal> {
    FlankAxes::new(face, cutter, options).map(|_| ())
}

/// Plans one flank pass over a face. What the pass leaves is in its report.
///
/// # Errors
///
/// The face has no rulings for it, the tool is too short, the face twists, or the tool would gouge.
pub(crate) fn flank_pass(request: FaceRequest<'_>) -> Result<PlacedPasses, FlankRefusal> {
    let FaceRequest { face, setup, options } = request;
    let cutter = setup.cutter;
    // Step 1: axes along the rulings.
    let axes = FlankAxes::new(face, cutter, options)?;
    let chart = Chart::straight(FeedDirection::U);
    let region = crate::cover::layout::trims::region(face, &chart);
    let silent = |_: f64| Ok(());
    let context = FaceContext::new(request, chart.clone(), &region, &silent);
    // Step 2: the lowest tip that keeps off the other faces.
    let height = axes.ruled.height;
    let tip = lowest_tip(&context, height, &axes.axes).ok_or(FlankRefusal::Gouges)?;
    let stations = axes.stations(tip).ok_or(FlankRefusal::NoRulings)?;
    // Step 3: the curve between the stations keeps off this face and all others.
    let sweep = PassSweep::through(&stations, lever(cutter));
    if !context.keeps_off(&sweep) {
        return Err(FlankRefusal::Gouges);
    }
    let pass = context.whole_pass(stations, height);
    let mut placed = PlacedPasses::new();
    let source = PassSource { face: face.face().number, chart: &chart, options, cost: setup.cost };
    placed.add_whole(pass, sweep, source);
    // Step 4: what the pass leaves of the whole face.
    context.measure_whole(&mut placed);
    Ok(placed)
}

/// Finds the lowest tip at which the tool keeps off all other faces, all along the pass: its height above the lower ends of
/// rulings up to `height` mm long.
fn lowest_tip<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    height: f64,
    axes: &[FlankAxis],
) -> Option<f64> {
    let (cutter, keep_off) = (context.setup.cutter, context.keep_off());
    let stride = axes.len().div_ceil(TIP_POSES).max(1);
    let clear = |tip: f64| {
        let mut tried = axes.iter().step_by(stride).chain(axes.last());
        tried.all(|axis| keep_off.check(&axis.pose(tip), Uv::new(0.0, 0.0)).is_ok())
    };
    let over = (OVERRUN[0] * cutter.radius()).min(OVERRUN[1]);
    let mut below = -cutter.minor() - over;
    if clear(below) {
        return Some(below);
    }
    // Above the lower end by half the height there would be little left to finish.
    let mut above = 0.5 * height;
    if !clear(above) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + above);
        if clear(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    Some(above)
}
