//! Search for the widest strip on one side of the cutter: initial guesses, climbs, choice.

use crate::positioning::check::survey::GapRefinement;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::methods::settle::{finish, keeps, measure_optimum};
use crate::positioning::methods::settle::{no_strip, settle};
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand};
use crate::positioning::solve::climb::{ARRIVED, BADLY, ROUGHLY};
use crate::positioning::solve::conditions::ExtremaSource;
use crate::positioning::solve::conditions::{COARSE, StripProblem};
use crate::positioning::solve::initial_guesses::{
    START_SPACING, SearchRanges, TILTS, cold_starts, inclined_start, restart_from, warm_start,
};
use crate::positioning::solve::optimum::LocalOptimum;
use crate::positioning::solve::placement::EndPointFrame;
use crate::types::Interval;

/// A warm start that ends this much narrower than its neighbour is not trusted alone.
const NARROWED: f64 = 0.9;

/// Share of the least strip below which a neighbour's lead has ended in nothing.
const SLIVER: f64 = 0.25;

/// Request for the widest strip on one side of the cutter.
#[derive(Clone, Copy)]
pub(crate) struct SideRequest<'a> {
    pub(crate) request: &'a LocationRequest<'a>,
    pub(crate) side: ContactSide,
    pub(crate) warm: Option<&'a CutterLocation>,
    pub(crate) rotation_range: Interval,
}

/// Searches the widest strip on one side of the cutter, and adds the closest-point queries that it took to `queries`.
pub(crate) fn search_side(
    of: SideRequest<'_>,
    queries: &mut u64,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(of.request.face);
    let found = search(of, &mut probe);
    *queries += u64::from(probe.queries);
    found
}

fn search(of: SideRequest<'_>, probe: &mut FaceProbe) -> Result<CutterLocation, PositioningError> {
    let SideRequest { request, side, warm, rotation_range } = of;
    // The search works in the inner band, so that a breach within the margin still keeps the outer
    // one.
    let (band, margin) = (request.band.inner(), request.band.margin());
    let inner = LocationRequest { band, ..*request };
    let frame = EndPointFrame::new(&inner, side, probe)?;
    let concave = frame.first.curvatures()[1];
    // k (r + e) >= 1: the offset surface folds over, and no corner of radius r reaches the point.
    if concave * frame.lift >= 1.0 {
        let (uv, concave) = (request.at, 1.0 / concave);
        return Err(PositioningError::ConcaveRadius { uv, concave, minor: frame.minor });
    }
    let (axis_cone, intervals) = (request.axis_cone, COARSE);
    let problem =
        StripProblem { frame, band, axis_cone, intervals, extrema: ExtremaSource::Sampled };
    let ranges = SearchRanges { offset: request.offset_range, rotation: rotation_range };
    let side_search = WidestSearch { request, problem: &problem, margin, ranges };
    let warm = warm.filter(|warm| warm.side == side && warm.strip == request.strip);
    let mut found = Vec::new();
    // A neighbour's location is nearly optimal here: a few steps from it replace the whole search.
    if let Some(warm) = warm
        && let Some(location) = side_search.beside(warm, &mut found, probe)?
    {
        return Ok(location);
    }
    match warm {
        Some(warm) if side_search.is_held() => {
            side_search.climb_from_inclined_start(warm, &mut found, probe)?;
        }
        _ => side_search.everywhere(&mut found, probe)?,
    }
    side_search.best(found, probe)
}

/// A search on one side of the cutter.
struct WidestSearch<'a> {
    request: &'a LocationRequest<'a>,
    problem: &'a StripProblem,
    /// By how much conditions may be broken \[mm\].
    margin: f64,
    /// Ranges of offset direction and rotation.
    ranges: SearchRanges,
}

impl WidestSearch<'_> {
    fn fits(&self, optimum: &LocalOptimum) -> bool {
        optimum.state.breach() <= self.margin
    }

    /// Returns `true` if the optimum breaks the band too much to be followed up.
    fn is_bad(&self, optimum: &LocalOptimum) -> bool {
        let ToleranceBand { lower, upper } = self.problem.band;
        optimum.state.breach() > BADLY * (upper - lower)
    }

    /// Returns `true` if axis and offset direction are confined so closely that no allowed location is
    /// farther from a neighbour's than initial guesses are from each other.
    fn is_held(&self) -> bool {
        let range = self.request.offset_range;
        let near = self.request.axis_cone.is_some_and(|near| near.max_turn <= START_SPACING);
        near && range.width() <= 2.0 * START_SPACING
    }

    /// Climbs from a neighbour's location. An end that is not accepted at once is added to `found`.
    fn beside(
        &self,
        warm: &CutterLocation,
        found: &mut Vec<LocalOptimum>,
        probe: &mut FaceProbe,
    ) -> Result<Option<CutterLocation>, PositioningError> {
        let start = warm_start(warm, self.ranges);
        let followed = self.problem.climb_following(&start, &warm.marks, ARRIVED, probe)?;
        if let Some(optimum) = &followed
            && let Some(location) = self.proven(warm, optimum, probe)?
        {
            return Ok(Some(location));
        }
        let sampled = match followed {
            Some(optimum) => self.problem.sampled_all_round(optimum, probe)?,
            None => None,
        };
        let climbed = match sampled {
            Some((optimum, _)) if self.fits(&optimum) => Some(optimum),
            // Nothing was overlooked: what is broken there cannot be mended nearby.
            Some((optimum, true)) if self.is_held() && self.is_bad(&optimum) => Some(optimum),
            _ => self.problem.climb(&start, ARRIVED, probe)?,
        };
        let Some(optimum) = climbed else { return Ok(None) };
        let width = EndPointFrame::width(optimum.state.placement.x);
        if width < SLIVER * self.request.narrowest_strip() {
            return Ok(None);
        }
        // What is held near a neighbour may well be narrower than it.
        let wide = width >= NARROWED * warm.chord_width;
        let fits = self.fits(&optimum);
        if fits && (wide || self.is_held()) {
            let settled = self.settle(optimum.clone(), probe);
            if settled.is_ok() {
                return settled.map(Some);
            }
        }
        if fits || self.is_held() {
            found.push(optimum);
        }
        Ok(None)
    }

    /// Returns the location at the end of a followed climb if bounds between its few readings prove it.
    fn proven(
        &self,
        warm: &CutterLocation,
        optimum: &LocalOptimum,
        probe: &mut FaceProbe,
    ) -> Result<Option<CutterLocation>, PositioningError> {
        let width = EndPointFrame::width(optimum.state.placement.x);
        let wide = width >= SLIVER * self.request.narrowest_strip()
            && (self.is_held() || width >= NARROWED * warm.chord_width);
        if !wide {
            return Ok(None);
        }
        let Some(optimum) = self.problem.proven(optimum, probe) else { return Ok(None) };
        let strip =
            measure_optimum(self.request, GapRefinement::Thorough, self.problem, &optimum, probe)?;
        if !keeps(self.request.band, &strip, &optimum) {
            return Ok(None);
        }
        Ok(finish(self.request, self.problem, &optimum, &strip, probe).ok())
    }

    /// Climbs from the one other guess that is worth it next to a neighbour.
    fn climb_from_inclined_start(
        &self,
        warm: &CutterLocation,
        found: &mut Vec<LocalOptimum>,
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        if !found.iter().any(|optimum| self.fits(optimum)) {
            let start = inclined_start(self.problem, warm, self.ranges);
            let followed = self.problem.climb_following(&start, &[], ROUGHLY, probe)?;
            let sampled = match followed {
                Some(optimum) => self.problem.sampled_all_round(optimum, probe)?,
                None => None,
            };
            found.extend(match sampled {
                Some((optimum, true)) => Some(optimum),
                _ => self.problem.climb(&start, ROUGHLY, probe)?,
            });
        }
        Ok(())
    }

    /// Climbs from starts spread over the offset range.
    fn everywhere(
        &self,
        found: &mut Vec<LocalOptimum>,
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        for tilt in TILTS {
            for start in cold_starts(self.problem, tilt, self.ranges) {
                found.extend(self.problem.climb(&start, ROUGHLY, probe)?);
            }
            if found.iter().any(|optimum| self.fits(optimum)) {
                break;
            }
        }
        Ok(())
    }

    /// Returns the best location that the ends of climbs lead to.
    fn best(
        &self,
        found: Vec<LocalOptimum>,
        probe: &mut FaceProbe,
    ) -> Result<CutterLocation, PositioningError> {
        let mut failed = None;
        for rough in worth(found, self.problem.band) {
            if self.is_held() && self.is_bad(&rough) {
                failed = failed.or_else(|| Some(no_strip(self.request, Some(&rough))));
                continue;
            }
            let start = restart_from(&rough, self.ranges);
            let Some(best) = self.problem.climb(&start, ARRIVED, probe)? else { continue };
            if self.fits(&best) {
                match self.settle(best, probe) {
                    Ok(location) => return Ok(location),
                    Err(error) => failed = failed.or(Some(error)),
                }
            } else {
                failed = failed.or_else(|| Some(no_strip(self.request, Some(&best))));
            }
        }
        Err(failed.unwrap_or_else(|| no_strip(self.request, None)))
    }

    fn settle(
        &self,
        optimum: LocalOptimum,
        probe: &mut FaceProbe,
    ) -> Result<CutterLocation, PositioningError> {
        settle(self.request, self.problem, optimum, self.ranges, probe)
    }
}

/// Returns the most promising optima, best first: by their width, less a price for what they still
/// break (few climbs end exactly in the band).
fn worth(mut found: Vec<LocalOptimum>, band: ToleranceBand) -> impl Iterator<Item = LocalOptimum> {
    let value = |optimum: &LocalOptimum| {
        let width = EndPointFrame::width(optimum.state.placement.x);
        width - PRICE * width * optimum.state.breach() / (band.upper - band.lower)
    };
    found.sort_by(|a, b| value(b).total_cmp(&value(a)));
    // Climbs that arrived at the same place are one.
    found.dedup_by(|b, a| (value(a) - value(b)).abs() <= SAME * value(a).abs());
    found.into_iter().take(PROMISING)
}

/// Widths a breach as large as the band costs. A width grows like a root of the band.
const PRICE: f64 = 10.0;

/// Climbs whose values differ by less than this share ended at the same optimum.
const SAME: f64 = 1e-4;

/// Ends of climbs that are followed up before the search gives up.
const PROMISING: usize = 3;
