//! The widest strip: starts, and the choice between what they lead to.

use super::ActiveConstraint;
use super::ContactSide;
use super::CutterLocation;
use super::LocationRequest;
use super::PositioningError;
use super::ToleranceBand;
use super::ToolInclination;
use super::ball;
use super::body;
use super::check::CuttingContext;
use super::check::MeasuredStrip;
use super::check::Survey;
use super::circle::Circle;
use super::constraints::COARSE;
use super::constraints::FINE;
use super::constraints::MARGIN;
use super::constraints::Problem;
use super::location::Found;
use super::location::marks;
use super::placement::Frame;
use super::probe::Probe;
use super::solve::ARRIVED;
use super::solve::BADLY;
use super::solve::MOST_ROTATION;
use super::solve::Optimum;
use super::solve::ROUGHLY;
use super::starts::START_SPACING;
use super::starts::TILTS;
use super::starts::again;
use super::starts::cold_starts;
use super::starts::leaning_start;
use super::starts::warm_start;
use crate::types::ToolPose;
use nalgebra::Point3;
use std::f64::consts::FRAC_PI_2;

/// A warm start that ends this much narrower than its neighbour is not trusted alone.
const NARROWED: f64 = 0.9;

/// Share of the least strip below which a neighbour's lead has ended in nothing.
const SLIVER: f64 = 0.25;

/// The cutter location with the widest strip from `request.at` \[mm\].
///
/// `warm`, the location of a neighbour on the same side, starts the search there; without it, or
/// where it leads nowhere, several offset directions are tried. The width is `w cos(alpha)`.
///
/// Source: `docs/sources.md#004`, sections 1 and 2, with the errata named there.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn widest_strip(
    request: &LocationRequest,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    check(request)?;
    let rotation = [-MOST_ROTATION, MOST_ROTATION];
    on_sides(request, |side| {
        if request.cutter.major() > 0.0 {
            search(request, side, warm, rotation)
        } else {
            ball::location(request, side, ToolInclination { angle: 0.0, towards: None })
        }
    })
}

/// The widest location whose rotation about the chord is at least `lead` \[rad\]: fixed
/// inclination, more only where the rear would gouge. An offset range of `[0, 0]` keeps the chord
/// across the feed.
///
/// For places where no wide strip fits, and for ball cutters.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn with_lead(
    request: &LocationRequest,
    lead: f64,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    with_inclination(request, ToolInclination { angle: lead, towards: None }, warm)
}

/// As [`with_lead`], leaning to a given side: for a ball any, for other cutters less than 90 degrees from the feed,
/// which turns the chord by as much.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn with_inclination(
    request: &LocationRequest,
    lean: ToolInclination,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    let turned = lean.towards.filter(|_| request.cutter.major() > 0.0);
    // The chord lies square to the lean: alpha turns it from the strip side towards the feed.
    let offset_range = turned.map_or(request.offset_range, |towards| [-towards, -towards]);
    let request = &LocationRequest { offset_range, ..*request };
    check(request)?;
    on_sides(request, |side| {
        if request.cutter.major() <= 0.0 {
            return ball::location(request, side, lean);
        }
        let least = lean.angle.min(MOST_ROTATION);
        let mut location = search(request, side, warm, [least, MOST_ROTATION])?;
        if location.rotation <= lean.angle {
            location.active.push(ActiveConstraint::GivenLead);
        }
        Ok(location)
    })
}

/// The wider one of the sides allowed.
pub(super) fn on_sides(
    request: &LocationRequest,
    find: impl Fn(ContactSide) -> Result<CutterLocation, PositioningError>,
) -> Result<CutterLocation, PositioningError> {
    match request.side {
        ContactSide::Either => {
            let [ahead, behind] = [find(ContactSide::Ahead), find(ContactSide::Behind)];
            match (ahead, behind) {
                (Ok(a), Ok(b)) if b.strip_width > a.strip_width => Ok(b),
                (Ok(a), _) => Ok(a),
                (Err(_), Ok(b)) => Ok(b),
                (Err(error), Err(_)) => Err(error),
            }
        }
        side => find(side),
    }
}

/// What can be refused before any search.
pub(super) fn check(request: &LocationRequest) -> Result<(), PositioningError> {
    let ToleranceBand { lower, upper } = request.band;
    if !(lower.is_finite() && upper.is_finite() && lower < upper) {
        return Err(PositioningError::EmptyBand { lower, upper });
    }
    let range = request.offset_range;
    let fits = range[0] <= range[1] && range[0] > -FRAC_PI_2 && range[1] < FRAC_PI_2;
    if !fits {
        return Err(PositioningError::OffsetRange { range });
    }
    let cutter = request.cutter;
    if request.side != ContactSide::Ahead && !cutter.centre_cutting() {
        return Err(PositioningError::NotCentreCutting { inner: cutter.inner_cutting_radius() });
    }
    Ok(())
}

/// Searches on one side of the cutter.
fn search(
    request: &LocationRequest,
    side: ContactSide,
    warm: Option<&CutterLocation>,
    rotation_range: [f64; 2],
) -> Result<CutterLocation, PositioningError> {
    let mut probe = Probe::new(request.face);
    let ToleranceBand { lower, upper } = request.band;
    let margin = MARGIN * (upper - lower);
    let band = ToleranceBand { lower: lower + margin, upper: upper - margin };
    let inner = LocationRequest { band, ..*request };
    let frame = Frame::new(&inner, side, &mut probe)?;
    let concave = frame.first.curvatures()[1];
    if concave * frame.lift >= 1.0 {
        let (uv, concave) = (request.at, 1.0 / concave);
        return Err(PositioningError::ConcaveRadius { uv, concave, minor: frame.minor });
    }
    let (axis_cone, intervals) = (request.axis_cone, COARSE);
    let problem = Problem { frame, band, axis_cone, intervals, swift: false };
    let ranges = [request.offset_range, rotation_range];
    let hunt = Hunt { request, side, problem: &problem, margin, ranges };
    let warm = warm.filter(|warm| warm.side == side && warm.strip == request.strip);
    let mut found = Vec::new();
    if let Some(warm) = warm
        && let Some(location) = hunt.beside(warm, &mut found, &mut probe)?
    {
        return Ok(location);
    }
    match warm {
        Some(warm) if hunt.is_held() => hunt.leaning(warm, &mut found, &mut probe)?,
        _ => hunt.everywhere(&mut found, &mut probe)?,
    }
    hunt.best(found, &mut probe)
}

/// A search on one side of the cutter.
struct Hunt<'a> {
    request: &'a LocationRequest<'a>,
    side: ContactSide,
    problem: &'a Problem,
    /// By how much conditions may be broken \[mm\].
    margin: f64,
    /// Of offset direction and rotation.
    ranges: [[f64; 2]; 2],
}

impl Hunt<'_> {
    fn fits(&self, optimum: &Optimum) -> bool {
        optimum.state.breach() <= self.margin
    }

    /// Whether it is too far off to be followed up.
    fn is_bad(&self, optimum: &Optimum) -> bool {
        let ToleranceBand { lower, upper } = self.problem.band;
        optimum.state.breach() > BADLY * (upper - lower)
    }

    /// Whether axis and offset direction are held so near to a direction that no place allowed is
    /// farther from a neighbour's than starts are from each other.
    fn is_held(&self) -> bool {
        let [low, high] = self.request.offset_range;
        let near = self.request.axis_cone.is_some_and(|near| near.max_turn <= START_SPACING);
        near && high - low <= 2.0 * START_SPACING
    }

    /// The location that climbing from a neighbour's leads to; what ends elsewhere is `found`.
    fn beside(
        &self,
        warm: &CutterLocation,
        found: &mut Vec<Optimum>,
        probe: &mut Probe,
    ) -> Result<Option<CutterLocation>, PositioningError> {
        let start = warm_start(warm, self.ranges);
        let glided = self.problem.glide((&start, &warm.marks), ARRIVED, probe)?;
        if let Some(optimum) = &glided
            && let Some(location) = self.proven(warm, optimum, probe)?
        {
            return Ok(Some(location));
        }
        let sampled = match glided {
            Some(optimum) => self.problem.sampled(optimum, probe)?,
            None => None,
        };
        let climbed = match sampled {
            Some((optimum, _)) if self.fits(&optimum) => Some(optimum),
            // Nothing was overlooked: what is broken there cannot be mended nearby.
            Some((optimum, true)) if self.is_held() && self.is_bad(&optimum) => Some(optimum),
            _ => self.problem.climb(&start, ARRIVED, probe)?,
        };
        let Some(optimum) = climbed else { return Ok(None) };
        let width = Frame::width(optimum.state.placement.x);
        if width < SLIVER * smallest(self.request) {
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

    /// The location at the end of a glide if bounds between its few readings prove it.
    fn proven(
        &self,
        warm: &CutterLocation,
        optimum: &Optimum,
        probe: &mut Probe,
    ) -> Result<Option<CutterLocation>, PositioningError> {
        let width = Frame::width(optimum.state.placement.x);
        let wide = width >= SLIVER * smallest(self.request)
            && (self.is_held() || width >= NARROWED * warm.chord_width);
        if !wide {
            return Ok(None);
        }
        let Some(optimum) = self.problem.known(optimum, probe) else { return Ok(None) };
        let strip = look((self.request, true), self.problem, &optimum, probe)?;
        if !keeps(self.request.band, &strip, &optimum) {
            return Ok(None);
        }
        let described = (self.side, self.problem);
        Ok(finish(self.request, described, &optimum, &strip, probe.again()).ok())
    }

    /// Climbs from the one other start worth it next to a neighbour.
    fn leaning(
        &self,
        warm: &CutterLocation,
        found: &mut Vec<Optimum>,
        probe: &mut Probe,
    ) -> Result<(), PositioningError> {
        if !found.iter().any(|optimum| self.fits(optimum)) {
            let start = leaning_start(self.problem, warm, self.ranges);
            let glided = self.problem.glide((&start, &[]), ROUGHLY, probe)?;
            let sampled = match glided {
                Some(optimum) => self.problem.sampled(optimum, probe)?,
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
        found: &mut Vec<Optimum>,
        probe: &mut Probe,
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

    /// The best location that the ends of climbs lead to.
    fn best(
        &self,
        found: Vec<Optimum>,
        probe: &mut Probe,
    ) -> Result<CutterLocation, PositioningError> {
        let mut failed = None;
        for rough in worth(found, self.problem.band) {
            if self.is_held() && self.is_bad(&rough) {
                failed = failed.or_else(|| Some(no_strip(self.request, Some(&rough))));
                continue;
            }
            let start = again(&rough, self.ranges);
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

    fn settle(&self, optimum: Optimum, probe: &Probe) -> Result<CutterLocation, PositioningError> {
        settle(self.request, self.side, self.problem, optimum, (self.ranges, probe.again()))
    }
}

/// Looks densely at the optimum; where that finds a breach between the samples, the search goes on
/// with more of them, and then with the band narrowed from below by what was still missing.
fn settle(
    request: &LocationRequest,
    side: ContactSide,
    problem: &Problem,
    mut optimum: Optimum,
    (ranges, mut probe): ([[f64; 2]; 2], Probe),
) -> Result<CutterLocation, PositioningError> {
    let mut problem = Problem { ..*problem };
    for _ in 0..NARROWINGS {
        let strip = look((request, false), &problem, &optimum, &mut probe)?;
        if keeps(request.band, &strip, &optimum) {
            return finish(request, (side, &problem), &optimum, &strip, probe);
        }
        let missing = request.band.lower - strip.front_min.min(strip.rear_min);
        if problem.intervals == FINE && missing > 0.0 {
            problem.band.lower += 2.0 * missing;
        }
        problem.intervals = FINE;
        match problem.climb(&again(&optimum, ranges), ARRIVED, &mut probe)? {
            Some(better) => optimum = better,
            None => break,
        }
    }
    let strip = look((request, false), &problem, &optimum, &mut probe)?;
    if clear(request.band, &strip) && strip.width > 0.0 {
        return finish(request, (side, &problem), &optimum, &strip, probe);
    }
    Err(no_strip(request, Some(&optimum)))
}

/// How often the dense look may send the search on. What is missing falls with its square, so a few
/// times do where any number does.
const NARROWINGS: usize = 4;

/// Nothing closer than the lower end of the band.
fn clear(band: ToleranceBand, strip: &MeasuredStrip) -> bool {
    strip.front_min >= band.lower && strip.rear_min >= band.lower
}

/// Nothing closer than the lower end of the band, and the strip reaches the second end point:
/// an error above the band on the way would have cut it short.
fn keeps(band: ToleranceBand, strip: &MeasuredStrip, optimum: &Optimum) -> bool {
    /// Of the width: on a strongly curved surface the widths of strip and chord, seen from
    /// different tangent planes, differ a little.
    const WHOLE: f64 = 0.99;
    let whole = strip.width >= WHOLE * Frame::width(optimum.state.placement.x);
    whole && clear(band, strip)
}

/// About the least strip that a fitting cutter leaves: upright on a plane \[mm\].
fn smallest(request: &LocationRequest) -> f64 {
    (8.0 * request.cutter.major() * (request.band.upper - request.band.lower)).sqrt()
}

fn no_strip(request: &LocationRequest, failed: Option<&Optimum>) -> PositioningError {
    PositioningError::NoStrip {
        uv: request.at,
        smallest: smallest(request),
        excess: failed.map_or(f64::INFINITY, |optimum| optimum.state.breach()),
        binding: failed.map_or(ActiveConstraint::Touch, |optimum| optimum.state.tightest()),
    }
}

/// The most promising ones, best first: by their width, less a price for what they still break
/// (few climbs end exactly in the band).
fn worth(mut found: Vec<Optimum>, band: ToleranceBand) -> impl Iterator<Item = Optimum> {
    let value = |optimum: &Optimum| {
        let width = Frame::width(optimum.state.placement.x);
        width - PRICE * width * optimum.state.breach() / (band.upper - band.lower)
    };
    found.sort_by(|a, b| value(b).total_cmp(&value(a)));
    // Climbs that arrived at the same place are one.
    found.dedup_by(|b, a| (value(a) - value(b)).abs() <= SAME * value(a).abs());
    found.into_iter().take(PROMISING)
}

/// Widths a breach as large as the band costs. A width grows like a root of the band.
const PRICE: f64 = 10.0;

/// Climbs whose values differ by less than this share ended at the same place.
const SAME: f64 = 1e-4;

/// How many ends of climbs are followed up before the place is given up.
const PROMISING: usize = 3;

/// A dense look at the optimum.
fn look(
    (request, thorough): (&LocationRequest, bool),
    problem: &Problem,
    optimum: &Optimum,
    probe: &mut Probe,
) -> Result<MeasuredStrip, PositioningError> {
    let placement = &optimum.state.placement;
    let frame = &problem.frame;
    let circle = Circle { ring: placement.ring, minor: frame.minor };
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    let survey = Survey {
        setting: &setting,
        circle,
        axis: placement.axis,
        v: frame.v,
        half_arc: placement.half_arc,
        seen: &optimum.state.samples,
        thorough,
    };
    let [u1, v1] = frame.first.foot.uv;
    let [u2, v2] = placement.second.foot.uv;
    survey.strip([0.5 * (u1 + u2), 0.5 * (v1 + v2)], probe)
}

/// Describes the optimum; the rest of the tool is checked.
fn finish(
    request: &LocationRequest,
    (side, problem): (ContactSide, &Problem),
    optimum: &Optimum,
    strip: &MeasuredStrip,
    mut probe: Probe,
) -> Result<CutterLocation, PositioningError> {
    let placement = &optimum.state.placement;
    let frame = &problem.frame;
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    let pose = placement.pose(frame.minor);
    cuts_there(&setting, &pose, strip)?;
    touches_where_it_cuts(&setting, &pose, optimum)?;
    body::clear(&setting, &pose, request.at, &mut probe)?;
    let (contact_angles, active) = binding(request, optimum);
    let found = Found {
        pose,
        side,
        x: placement.x,
        widths: [strip.width, Frame::width(placement.x)],
        arc: 2.0 * placement.half_arc,
        contact_angles,
        active,
        end: placement.second.foot.uv,
        queries: probe.queries,
        marks: marks(&optimum.state, frame.first.foot.uv),
    };
    Ok(CutterLocation::new(request, strip, found))
}

/// Share of the band within which a condition counts as reached.
const TOUCHING: f64 = 1e-3;

/// The strip must lie under the part of the underside that cuts.
pub(super) fn cuts_there(
    setting: &CuttingContext,
    pose: &ToolPose,
    strip: &MeasuredStrip,
) -> Result<(), PositioningError> {
    within_cutting(setting, pose, [strip.near, strip.contact, strip.far].into_iter())
}

/// So must whatever else touches: contacts within the strip, under the rear, under the disc.
fn touches_where_it_cuts(
    setting: &CuttingContext,
    pose: &ToolPose,
    optimum: &Optimum,
) -> Result<(), PositioningError> {
    let slight = TOUCHING * (setting.band.upper - setting.band.lower);
    let touching = optimum.state.conditions.iter().filter(|c| c.value <= slight);
    within_cutting(setting, pose, touching.filter_map(|condition| condition.contact))
}

pub(super) fn within_cutting(
    setting: &CuttingContext,
    pose: &ToolPose,
    contacts: impl Iterator<Item = ([f64; 2], Point3<f64>)>,
) -> Result<(), PositioningError> {
    let inner = setting.cutter.inner_cutting_radius();
    for (uv, point) in contacts {
        let radius = pose.axis.cross(&(point - pose.tip)).norm();
        if radius < inner {
            return Err(PositioningError::NotCutting { uv, radius, inner });
        }
    }
    Ok(())
}

/// Contacts, as angles from the first end point, and the conditions that bind.
fn binding(request: &LocationRequest, optimum: &Optimum) -> (Vec<f64>, Vec<ActiveConstraint>) {
    let band = request.band.upper - request.band.lower;
    let half = optimum.state.placement.half_arc;
    let mut active = Vec::new();
    let mut angles = Vec::new();
    for (condition, multiplier) in optimum.state.conditions.iter().zip(&optimum.multipliers) {
        if condition.kind == ActiveConstraint::Touch {
            angles.push(condition.psi + half);
        }
        if *multiplier > 0.0 && condition.value <= TOUCHING * band {
            active.push(condition.kind);
        }
    }
    if optimum.at_range_end {
        active.push(ActiveConstraint::OffsetRange);
    }
    (angles, active)
}
