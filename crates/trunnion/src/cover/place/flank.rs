//! Flank passes: the side of the tool lies along the straight lines of a face.
//!
//! On planes, cylinders, cones and extrusions the tool touches the whole line: one pass finishes the face over the height of
//! the tool's straight side, without any scallop. Where other faces are in its way it is run in pieces. On other ruled faces the side follows the line within the tolerance, as
//! far as the face does not twist too much.

use crate::cover::flank_refusal::FlankRefusal;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::options::{CoverOptions, lever};
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::flank_pieces::{FlankPiece, TipHeights, WallRun};
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::rulings::{FlankAxis, RuledFace};
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Interval, Pass, Station, ToolPose, Uv};
use rayon::prelude::*;

/// Run of the tip beyond the lower end of the rulings where nothing is in its way, as a share of the radius, and at
/// most \[mm\].
const OVERRUN: [f64; 2] = [0.5, 2.0];

/// Share of the straight side that stays above the upper end of the rulings.
const SPARE: f64 = 0.02;

/// Halvings of the range in which the lowest tip is sought at each place of a wall: from millimetres to a tenth.
const COARSE: u32 = 8;

/// Halvings of one of these steps: to a tenth of a micrometre.
const FINE: u32 = 10;

/// Poses at which the tip is kept off the other faces in that search.
const TIP_POSES: usize = 48;

/// Highest tip, as a share of the rulings' length: above it there would be little left to finish.
const HIGHEST: f64 = 0.9;

/// Halvings of a piece that gouges somewhere.
const PIECES: u32 = 3;

/// Parameters for checks that do not report them.
const NOWHERE: Uv = Uv { u: 0.0, v: 0.0 };

/// Returns the straight side of the tool above its corner \[mm\].
fn straight_side(cutter: &Cutter) -> [f64; 2] {
    let top = cutter.spec().shank.first().map_or(cutter.length(), |&[height, _]| height);
    [cutter.minor(), top]
}

/// Wall with the tool whose side lies along its rulings.
struct FlankWall<'a> {
    ruled: RuledFace<'a>,
    run: Interval,
    cutter: &'a Cutter,
    options: &'a CoverOptions,
}

/// Axes along a wall, with their places.
struct FlankAxes {
    places: Vec<f64>,
    axes: Vec<FlankAxis>,
}

impl FlankAxes {
    /// Returns every so many axes, the last one too: [`TIP_POSES`] at most, and one.
    fn sampled(&self) -> impl Iterator<Item = &FlankAxis> {
        let stride = self.axes.len().div_ceil(TIP_POSES).max(1);
        self.axes.iter().step_by(stride).chain(self.axes.last())
    }
}

impl<'a> FlankWall<'a> {
    fn new(
        face: &'a FaceIndex,
        cutter: &'a Cutter,
        options: &'a CoverOptions,
    ) -> Result<Self, FlankRefusal> {
        let ruled = RuledFace::new(face).ok_or(FlankRefusal::NoRulings)?;
        Self::along(ruled, face, cutter, options)
    }

    /// Lays the side of the tool along the rulings of a face.
    fn along(
        ruled: RuledFace<'a>,
        face: &FaceIndex,
        cutter: &'a Cutter,
        options: &'a CoverOptions,
    ) -> Result<Self, FlankRefusal> {
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
        let run = ruled.run(radius, options.band).ok_or(FlankRefusal::Twisted { radius })?;
        Ok(Self { ruled, run, cutter, options })
    }

    /// Returns the axes over a range; `None` where the face twists too much for the tool.
    fn axes(&self, range: Interval) -> Option<FlankAxes> {
        let places = self.ruled.stations(range, self.options.spacing.high, self.cutter.radius())?;
        let axes: Option<Vec<FlankAxis>> = places.par_iter().map(|at| self.axis(*at)).collect();
        Some(FlankAxes { axes: axes?, places })
    }

    fn axis(&self, at: f64) -> Option<FlankAxis> {
        self.ruled.axis(at, self.cutter.radius(), self.options.band)
    }

    /// Returns the stations with the tip at a height above the lower ends of the rulings, touching in their middle.
    fn stations(&self, axes: &FlankAxes, tip: f64) -> Option<Vec<Station>> {
        let station = |(at, axis): (&f64, &FlankAxis)| {
            Some(Station { pose: axis.pose(tip), contact: self.ruled.ruling(*at)?.middle() })
        };
        axes.places.iter().zip(&axes.axes).map(station).collect()
    }

    /// Returns the heights between which the tip is to be.
    fn heights(&self) -> TipHeights {
        let (wall, corner) = (self.ruled.height, self.cutter.minor());
        let over = (OVERRUN[0] * self.cutter.radius()).min(OVERRUN[1]);
        TipHeights { range: Interval::new(-corner - over, HIGHEST * wall), corner, wall }
    }

    /// Returns the pieces in which the tool keeps off all other faces.
    fn pieces(
        &self,
        axes: &FlankAxes,
        clear: impl Fn(&ToolPose) -> bool + Sync,
    ) -> Vec<FlankPiece> {
        let (heights, whole) = (self.heights(), self.run);
        // Nothing in the way: the common case, soon found.
        let tip = heights.range.low;
        if axes.sampled().all(|axis| clear(&axis.pose(tip))) {
            return vec![FlankPiece { range: whole, tip }];
        }
        let lowest = |at: f64| {
            let axis = self.axis(at)?;
            heights.lowest(COARSE, |tip| clear(&axis.pose(tip)))
        };
        let is_clear = |at: f64, tip: f64| self.axis(at).is_some_and(|axis| clear(&axis.pose(tip)));
        WallRun { whole, round: self.ruled.round() }.pieces(heights, lowest, is_clear)
    }

    /// Plans the passes over a piece: one, or several where it gouges in between.
    fn passes<Inside: Fn(ChartPoint) -> bool + Sync>(
        &self,
        context: &FaceContext<'_, Inside>,
        piece: FlankPiece,
        halvings: u32,
    ) -> Vec<(Pass, PassSweep)> {
        let whole = self.pass(context, piece);
        if whole.is_some() || halvings == 0 {
            return whole.into_iter().collect();
        }
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|share| piece.range.at(share));
        let halves = [Interval::new(low, middle), Interval::new(middle, high)];
        let of = |range| self.passes(context, FlankPiece { range, ..piece }, halvings - 1);
        halves.into_iter().flat_map(of).collect()
    }

    /// Plans one pass over a piece, as low as the tool gets; `None` where it gouges.
    fn pass<Inside: Fn(ChartPoint) -> bool + Sync>(
        &self,
        context: &FaceContext<'_, Inside>,
        piece: FlankPiece,
    ) -> Option<(Pass, PassSweep)> {
        // Step 1: the lowest tip that keeps off the other faces.
        let (axes, keep_off) = (self.axes(piece.range)?, context.keep_off());
        let clear = |tip: f64| {
            let is_clear = |axis| keep_off.check(&FlankAxis::pose(axis, tip), NOWHERE).is_ok();
            axes.sampled().all(is_clear)
        };
        let heights = self.heights();
        let within = |low: f64| TipHeights { range: Interval::new(low, piece.tip), ..heights };
        // Where the places of the wall were tried it is a step lower at most; places in between may allow less.
        let low = heights.range.low.max(piece.tip - heights.range.width() / f64::from(1 << COARSE));
        let mut tip = within(low).lowest(FINE, clear)?;
        if tip <= low && low > heights.range.low {
            tip = within(heights.range.low).lowest(COARSE + FINE, clear)?;
        }
        // Step 2: the curve between the stations keeps off this face and all others.
        let stations = self.stations(&axes, tip)?;
        let sweep = PassSweep::through(&stations, lever(self.cutter));
        let pass = || context.whole_pass(stations, heights.wall);
        context.keeps_off(&sweep).then(pass).map(|pass| (pass, sweep))
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
    let wall = FlankWall::new(face, cutter, options)?;
    let radius = cutter.radius();
    wall.axes(wall.run).map(|_| ()).ok_or(FlankRefusal::Twisted { radius })
}

/// Plans the flank pass over a face, in pieces where other faces are in its way. What the passes leave is in their report.
///
/// If passes along the steepest lines of a plane leave material, passes along its edges are tried.
///
/// # Errors
///
/// The face has no rulings for it, the tool is too short, the face twists, or the tool would gouge all along.
pub(crate) fn flank_passes(request: FaceRequest<'_>) -> Result<PlacedPasses, FlankRefusal> {
    let FaceRequest { face, setup, options, .. } = request;
    let steepest =
        FlankWall::new(face, setup.cutter, options).and_then(|wall| wall_passes(request, &wall));
    if steepest.as_ref().is_ok_and(|placed| placed.report.rest.is_empty()) {
        return steepest;
    }
    let along_edges = || -> Option<PlacedPasses> {
        let ruled = RuledFace::along_edges(face)?;
        let wall = FlankWall::along(ruled, face, setup.cutter, options).ok()?;
        wall_passes(request, &wall).ok()
    };
    match (steepest, along_edges()) {
        (Ok(steepest), Some(other)) if !steepest.leaves_more(&other) => Ok(steepest),
        (_, Some(other)) => Ok(other),
        (steepest, None) => steepest,
    }
}

/// Plans the passes over a wall.
fn wall_passes(
    request: FaceRequest<'_>,
    wall: &FlankWall<'_>,
) -> Result<PlacedPasses, FlankRefusal> {
    let FaceRequest { face, setup, options, .. } = request;
    // Step 1: axes along the rulings.
    let radius = setup.cutter.radius();
    let axes = wall.axes(wall.run).ok_or(FlankRefusal::Twisted { radius })?;
    let chart = Chart::straight(FeedDirection::U);
    let region = crate::cover::layout::trims::region(face, &chart);
    let context = FaceContext::new(request, chart.clone(), &region);
    // Step 2: pieces that keep off the other faces, and passes over them.
    let keep_off = context.keep_off();
    let pieces = wall.pieces(&axes, |pose| keep_off.check(pose, NOWHERE).is_ok());
    let planned: Vec<(Pass, PassSweep)> =
        pieces.par_iter().flat_map_iter(|piece| wall.passes(&context, *piece, PIECES)).collect();
    if planned.is_empty() {
        return Err(FlankRefusal::Gouges);
    }
    let mut placed = PlacedPasses::new();
    let source = PassSource { face: face.face().number, chart: &chart, options, cost: setup.cost };
    for (pass, sweep) in planned {
        placed.add_whole(pass, sweep, source);
    }
    // Step 3: what they leave of the whole face.
    context.measure_whole(&mut placed);
    Ok(placed)
}
