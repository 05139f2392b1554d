//! Everything that stays the same while passes are placed over a face.

use crate::cover::cost::PassCost;
use crate::cover::layout::advance::ball_strip_width;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::effort::WorkCounter;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::options::{CoverOptions, lever};
use crate::cover::pattern::PlacementMethod;
use crate::cover::place::progress::FaceProgress;
use crate::cover::place::trim::PassSegment;
use crate::cover::prove::clearance::ClearanceProof;
use crate::cover::prove::coverage::{CellGrain, CoverageProof};
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::FaceTree;
use crate::cover::prove::part_faces::{KeepOff, PartFaces};
use crate::cover::prove::sweep::PassSweep;
use crate::cover::prove::time_slab::SpanTimes;
use crate::cover::report::{FallbackReason, PassFallback};
use crate::cutter::Cutter;
use crate::cutter::ToolBody;
use crate::surface::{FaceIndex, FootPoint};
use crate::types::{Interval, Pass, Station, Uv};
use nalgebra::Point3;
use rayon::prelude::*;

/// Size of the cells into which a face is divided beforehand, as a share of the cutter's radius. Proofs halve them where they
/// have to; smaller ones to begin with took longer.
const TREE_SHARE: f64 = 1.0 / 8.0;

/// Precision to which breaches of the band between stations are found, as a share of the path share.
const PRECISION: f64 = 0.05;

/// Least width of a useful pass, as a share of the strip on a plane of a ball as wide as the cutter: on an edge rounded
/// with a hundredth of that ball's radius, a ball's strip is still a tenth as wide.
const WORTH: f64 = 1.0 / 16.0;

/// Size of the cells with which strips of the usual width are measured, as a share of the strip on a plane of a ball
/// as wide as the cutter.
const USUAL: f64 = 1.0 / 32.0;

/// Length of these cells along a pass, over their width across it: the edge of such a strip runs along the pass.
const LONG: f64 = 4.0;

/// Cutter, part and cost model: the same for all charts of a face.
#[derive(Clone, Copy)]
pub(crate) struct PartSetup<'a> {
    pub(crate) cutter: &'a Cutter,
    /// All faces of the part.
    pub(crate) part_faces: &'a PartFaces<'a>,
    /// Index of the face that is cut.
    pub(crate) own: usize,
    pub(crate) cost: &'a dyn PassCost,
}

/// Face to cover, with setup, options and progress.
#[derive(Clone, Copy)]
pub(crate) struct FaceRequest<'a> {
    pub(crate) face: &'a FaceIndex,
    pub(crate) setup: PartSetup<'a>,
    pub(crate) options: &'a CoverOptions,
    pub(crate) progress: FaceProgress<'a>,
}

/// Face on one chart, ready for passes.
pub(crate) struct FaceContext<'a, Inside> {
    pub(crate) face: &'a FaceIndex,
    pub(crate) setup: PartSetup<'a>,
    pub(crate) options: &'a CoverOptions,
    pub(crate) chart: Chart,
    /// Region to be finished.
    pub(crate) whole: &'a TrimmedRegion<Inside>,
    pub(crate) progress: FaceProgress<'a>,
    pub(crate) tool: ToolBody,
    tree: FaceTree,
}

impl<'a, Inside: Fn(ChartPoint) -> bool + Sync> FaceContext<'a, Inside> {
    /// Prepares a face for passes on `chart`.
    pub(crate) fn new(
        request: FaceRequest<'a>,
        chart: Chart,
        whole: &'a TrimmedRegion<Inside>,
    ) -> Self {
        let FaceRequest { face, setup, options, progress } = request;
        // The tool may go in where no pass runs, so the tree holds the excluded area as well.
        let size = TREE_SHARE * setup.cutter.radius();
        let tree = FaceTree::new(face, &chart, &whole.complete(), size);
        let tool = ToolBody::new(setup.cutter);
        Self { face, setup, options, chart, whole, progress, tool, tree }
    }

    /// Returns the request that this context was made for.
    pub(crate) fn request(&self) -> FaceRequest<'a> {
        let Self { face, setup, options, progress, .. } = *self;
        FaceRequest { face, setup, options, progress }
    }

    /// Returns the note that wide strips are given up on all of the face.
    pub(crate) fn fallback_everywhere(&self) -> PassFallback {
        let [u, v] = self.uv_range(self.whole.bounds).map(Interval::from);
        let at = self.chart.uv(self.whole.bounds.map(|range| range[0])).into();
        let reason = FallbackReason::Effort;
        PassFallback { face: self.face.face().number, at, u, v, reason }
    }

    /// Estimates the work of passes at the fixed lead: as many stations as strips as narrow as a ball's need.
    pub(crate) fn usual_work(&self) -> f64 {
        let narrow = self.narrow().max(self.options.spacing.low);
        WorkCounter::of_stations(self.tree.area() / (narrow * self.options.spacing.high))
    }

    /// Returns the extent of the face by local parameter `k` \[mm\].
    pub(crate) fn extent(&self, k: usize) -> f64 {
        let (face, chart) = (self.face, &self.chart);
        let at = |local: ChartPoint| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        };
        FaceCell::new(self.whole.bounds, &at).extent(k)
    }

    /// Returns the width of a strip of a ball as wide as the cutter, on a plane \[mm\].
    pub(crate) fn narrow(&self) -> f64 {
        ball_strip_width(self.setup.cutter, self.options)
    }

    /// Returns the least width that a pass has to finish \[mm\].
    pub(crate) fn least(&self) -> f64 {
        self.options.spacing.low.max(WORTH * self.narrow())
    }

    /// Returns the area of the face, as the sum of its cells \[mm²\].
    pub(crate) fn area(&self) -> f64 {
        self.tree.area()
    }

    /// Returns the curve through the stations of a segment.
    pub(crate) fn sweep(&self, segment: &PassSegment) -> PassSweep {
        let stations: Vec<Station> = segment.placed.iter().map(|p| p.station).collect();
        PassSweep::through(&stations, lever(self.setup.cutter))
    }

    /// Returns the check of cutter locations against the other faces and the reach of the machine.
    pub(crate) fn keep_off(&self) -> KeepOff<'_> {
        let CoverOptions { band, path_share, .. } = *self.options;
        let PartSetup { part_faces, own, cost, .. } = self.setup;
        let precision = PRECISION * path_share;
        KeepOff { cost, part_faces, own, tool: &self.tool, least: band.lower, precision }
    }

    /// Returns the proof that curves between stations do not gouge this face.
    pub(crate) fn clearance(&self, precision: f64) -> ClearanceProof<'_> {
        let CoverOptions { band, path_share, .. } = *self.options;
        ClearanceProof {
            face: self.face,
            chart: &self.chart,
            tree: &self.tree,
            tool: &self.tool,
            // The proof may be short of the target by the precision; what it then keeps is the
            // widened band.
            target: band.lower - path_share + precision,
            precision,
        }
    }

    /// Returns `true` if the tool keeps off this face and the others between the stations.
    pub(crate) fn keeps_off(&self, sweep: &PassSweep) -> bool {
        (0..sweep.curve.spans.len()).all(|span| self.keeps_off_on(sweep, span))
    }

    /// Returns the spans between stations on which the tool does not keep off this face and the others.
    pub(crate) fn spans_too_near(&self, sweep: &PassSweep) -> Vec<usize> {
        let spans = (0..sweep.curve.spans.len()).into_par_iter();
        spans.filter(|span| !self.keeps_off_on(sweep, *span)).collect()
    }

    fn keeps_off_on(&self, sweep: &PassSweep, span: usize) -> bool {
        let keep_off = self.keep_off();
        let clearance = self.clearance(keep_off.precision);
        let times = SpanTimes::all(sweep, span, self.setup.cutter.radius());
        let enough = clearance.target - clearance.precision;
        keep_off.clearance(sweep, span, times, clearance.target) >= enough
            && keep_off.own_clearance(&clearance, sweep, span, times) >= enough
    }

    /// Returns the parameters of the point of the face nearest to `p`: near a guess where one is found there within a distance
    /// \[mm\], which takes a fraction of the time.
    pub(crate) fn foot_near(
        &self,
        p: &Point3<f64>,
        guess: [f64; 2],
        within: f64,
    ) -> Option<[f64; 2]> {
        let bounds = self.face.face().bounds();
        let is_inside =
            |foot: &FootPoint| bounds[0].contains(foot.uv.u) && bounds[1].contains(foot.uv.v);
        let near = self.face.closest_near(p, guess.into()).ok();
        let near = near.filter(|foot| foot.distance <= within && is_inside(foot));
        near.or_else(|| self.face.closest(p).ok()).map(|foot| foot.uv.into())
    }

    /// Makes a pass of stations that finish a strip of one width.
    pub(crate) fn whole_pass(&self, stations: Vec<Station>, width: f64) -> Pass {
        let uv = |station: &Station| {
            self.face.closest(&station.contact).map_or(Uv::new(0.0, 0.0), |foot| foot.uv)
        };
        let track = stations.iter().map(uv).collect();
        let widths = vec![width; stations.len()];
        Pass { face: self.face.face().number, stations, widths, track }
    }

    /// Returns the proof of the part of `region` that `sweeps` have finished.
    pub(crate) fn coverage<'b>(
        &'b self,
        region: &'b TrimmedRegion<&'b Inside>,
        sweeps: &'b [&'b PassSweep],
    ) -> CoverageProof<'b, &'b Inside> {
        let smallest = 0.5 * self.options.spacing.low;
        CoverageProof {
            face: self.face,
            chart: &self.chart,
            region,
            end: self.tool.end,
            limit: self.options.band.upper + self.options.path_share,
            smallest,
            grain: match self.options.method {
                // A fraction of a percent of wide strips adds up to a pass.
                PlacementMethod::Widest => CellGrain { usual: smallest, long: 1.0 },
                PlacementMethod::Inclined => {
                    CellGrain { usual: smallest.max(USUAL * self.narrow()), long: LONG }
                }
            },
            sweeps,
        }
    }
}
