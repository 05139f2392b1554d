//! Straight lines of a face, upwards, and the axes of a tool whose side lies along them.
//!
//! On planes, cylinders, cones and extrusions the normal is the same all along a straight line (a ruling): an axis parallel
//! to it, the radius off along the normal, touches the whole line. On other ruled faces, as lofts between two sections are,
//! the normal turns from end to end. There the axis is the line that stays most evenly the radius off the face.

use crate::positioning::ToleranceBand;
use crate::surface::{FaceIndex, Surface};
use crate::types::{Interval, ToolPose};
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};

/// Least z of a ruling of unit length: a tool that lies flatter than about ten degrees hangs beside the part.
const LEAST_RISE: f64 = 0.17;

/// Largest z of the normal of a plane that is cut by the flank: flatter ones are cut by the underside.
const FLATTEST_WALL: f64 = 0.5;

/// Share of the band by which the side of the tool stays inside it.
const INSIDE: f64 = 0.1;

/// Overlap of a pass round a closed face, as a share of the radius.
const OVERLAP: f64 = 0.1;

/// Tolerance of the polylines that stand for the outline of a face, as a share of its ranges.
const LOOP_SHARE: f64 = 1e-6;

/// Sine of the angle between edges up to which they are parallel: a micrometre in 10 mm.
const PARALLEL: f64 = 1e-4;

/// Least length of a straight edge, and distance between two, as a share of the longest.
const LEAST_EDGE: f64 = 0.1;

/// Lines, and points of each, at which a surface is tried for rulings; largest distance of a point from the line between
/// the ends, as a share of its length.
const TRIED: [u32; 2] = [9, 7];
const STRAIGHT: f64 = 1e-7;

/// Run of a pass beyond the ends of an open face, over the distance by which the axis leaves the end's ruling: the tool
/// touches the corner of the face there.
const RUN_ON: f64 = 1.5;

/// Steps along a pass by which its length is measured.
const SAMPLES: u32 = 64;

/// Points along a ruling at which an axis is compared with the face, and rounds of its fit.
const FITTED: u32 = 13;
const ROUNDS: u32 = 12;

/// Share of the largest diagonal term that is added where a step leaves the distances as they are, as the third one does
/// where the face does not twist.
const DAMPING: f64 = 1e-9;

/// A straight line of the face, upwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ruling {
    /// Lower and upper end.
    ends: [Point3<f64>; 2],
    /// Normals at the ends.
    normals: [UnitVector3<f64>; 2],
    /// Parameters of the ends.
    uv: [[f64; 2]; 2],
}

impl Ruling {
    /// Returns its middle.
    pub(super) fn middle(&self) -> Point3<f64> {
        nalgebra::center(&self.ends[0], &self.ends[1])
    }
}

/// Axis of a tool that lies along a ruling.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlankAxis {
    /// Point beside the lower end of the ruling.
    low: Point3<f64>,
    along: UnitVector3<f64>,
    /// Distance by which its ends are off the ruling's, along the pass \[mm\].
    aside: f64,
}

impl FlankAxis {
    /// Returns the pose with the tip at a height above the lower end of the ruling \[mm\].
    pub(super) fn pose(&self, height: f64) -> ToolPose {
        ToolPose { tip: self.low + self.along.scale(height), axis: self.along }
    }
}

/// Coordinates of a face by its rulings.
#[derive(Debug, Clone, Copy)]
enum RulingChart {
    /// A plane: the pass runs along the first direction, and the rulings along the second.
    Plane { origin: Point3<f64>, across: Vector3<f64>, up: UnitVector3<f64> },
    /// The normal is constant along the rulings, which are lines of constant u; v is the low end first.
    Parallel { ends: [f64; 2] },
    /// The normal may turn; rulings run along parameter `ruled` (0 for u, 1 for v), the low end first.
    Twisted { ruled: usize, ends: [f64; 2] },
}

/// Face with rulings that a tool can lie along.
pub(super) struct RuledFace<'a> {
    face: &'a FaceIndex,
    chart: RulingChart,
    /// Range along the pass; parameters, or mm on a plane.
    range: [f64; 2],
    /// Length of the longest ruling \[mm\].
    pub(super) height: f64,
    /// `true` if the pass runs all round.
    closed: bool,
}

impl<'a> RuledFace<'a> {
    /// Finds the rulings of a face, of a plane the steepest lines; `None` where it has none, or they lie too flat for a
    /// tool from above.
    pub(super) fn new(face: &'a FaceIndex) -> Option<Self> {
        let ruled = match &face.face().surface {
            Surface::Plane(_) => Self::plane(face, steepest(face)?)?,
            Surface::Cylinder(_) | Surface::Cone(_) | Surface::Extrusion(_) => {
                Self::lines(face, 1, |ends| RulingChart::Parallel { ends })?
            }
            Surface::Sphere(_) | Surface::Torus(_) => return None,
            surface => {
                let ruled = straight_parameter(surface, face.face().bounds())?;
                Self::lines(face, ruled, |ends| RulingChart::Twisted { ruled, ends })?
            }
        };
        ruled.rises()
    }

    /// Takes lines along the edges of a plane as rulings: between walls that lean, a tool leans as they do. `None` where no
    /// two edges are parallel, or they run along the steepest lines anyway.
    pub(super) fn along_edges(face: &'a FaceIndex) -> Option<Self> {
        let Surface::Plane(plane) = &face.face().surface else { return None };
        let (steepest, edge) = (steepest(face)?, steepest_edges(face)?);
        // Edges are straight in the plane up to rounding.
        let up = UnitVector3::try_new(
            edge.into_inner() - plane.frame.z().scale(plane.frame.z().dot(&edge)),
            f64::MIN_POSITIVE,
        )?;
        let is_new = up.cross(&steepest).norm() > PARALLEL;
        is_new.then(|| Self::plane(face, up)).flatten()?.rises()
    }

    /// Returns the face if its rulings rise enough for a tool from above.
    fn rises(self) -> Option<Self> {
        let places = (0..=TRIED[0]).map(|i| f64::from(i) / f64::from(TRIED[0]));
        let [first, last] = self.range;
        let rises = |share: f64| {
            let ruling = self.ruling(first + (last - first) * share)?;
            let along = UnitVector3::try_new(ruling.ends[1] - ruling.ends[0], f64::MIN_POSITIVE)?;
            (along.z >= LEAST_RISE).then_some(())
        };
        places.map(rises).collect::<Option<()>>().map(|()| self)
    }

    /// Takes the lines of a plane along `up` as rulings.
    fn plane(face: &'a FaceIndex, up: UnitVector3<f64>) -> Option<Self> {
        let Surface::Plane(plane) = &face.face().surface else { return None };
        let normal = plane.frame.z();
        if normal.z.abs() > FLATTEST_WALL {
            return None;
        }
        let across = up.cross(&normal);
        let origin = plane.frame.origin();
        let place = |[u, v]: [f64; 2]| {
            let point = face.face().point(u, v) - origin;
            [point.dot(&across), point.dot(&up)]
        };
        let [range, [low, high]] = extent(face, place)?;
        let chart = RulingChart::Plane { origin: origin + up.scale(low), across, up };
        Some(Self { face, chart, range, height: high - low, closed: false })
    }

    /// Takes the lines along parameter `ruled` as rulings.
    fn lines(
        face: &'a FaceIndex,
        ruled: usize,
        chart: impl Fn([f64; 2]) -> RulingChart,
    ) -> Option<Self> {
        let [_, mut ends] = extent(face, |uv| [uv[1 - ruled], uv[ruled]])?;
        // Loops that run round a closed face leave the box of the face.
        let around = face.face().bounds()[1 - ruled];
        let at = |end: f64| {
            let uv = if ruled == 1 { [around.middle(), end] } else { [end, around.middle()] };
            face.face().point(uv[0], uv[1])
        };
        if at(ends[0]).z > at(ends[1]).z {
            ends.reverse();
        }
        let period = face.face().surface.periods()[1 - ruled];
        let closed = period.is_some_and(|period| around.width() >= period * (1.0 - LOOP_SHARE));
        let mut found =
            Self { face, chart: chart(ends), range: around.ends(), height: 0.0, closed };
        let places = (0..=TRIED[0]).map(|i| around.at(f64::from(i) / f64::from(TRIED[0])));
        let length = |at: f64| found.ruling(at).map(|r| (r.ends[1] - r.ends[0]).norm());
        let longest = places.filter_map(length).fold(0.0, f64::max);
        found.height = longest;
        (longest > 0.0).then_some(found)
    }

    /// Returns the ruling at a place along the pass; `None` where the face has no normal.
    pub(super) fn ruling(&self, at: f64) -> Option<Ruling> {
        let face = self.face.face();
        match self.chart {
            RulingChart::Plane { origin, across, up } => {
                let [u, v] = face.bounds();
                let normal = face.normal(u.middle(), v.middle())?;
                let low = origin + across * at;
                let uv = [[u.middle(), v.middle()]; 2];
                Some(Ruling { ends: [low, low + up.scale(self.height)], normals: [normal; 2], uv })
            }
            RulingChart::Parallel { ends } => {
                // Off the ends: at the apex of a cone there is no normal.
                let normal = face.normal(at, 0.5 * (ends[0] + ends[1]))?;
                let uv = ends.map(|end| [at, end]);
                Some(Ruling { ends: uv.map(|[u, v]| face.point(u, v)), normals: [normal; 2], uv })
            }
            RulingChart::Twisted { ruled, ends } => {
                let uv = ends.map(|end| if ruled == 1 { [at, end] } else { [end, at] });
                let [low, high] = uv.map(|[u, v]| face.normal(u, v));
                let normals = [low?, high?];
                Some(Ruling { ends: uv.map(|[u, v]| face.point(u, v)), normals, uv })
            }
        }
    }

    /// Returns the axis of a tool that lies along the ruling at a place, its side inside the band; `None` where the face
    /// twists too much for that.
    pub(super) fn axis(&self, at: f64, radius: f64, band: ToleranceBand) -> Option<FlankAxis> {
        let ruling = self.ruling(at)?;
        let spare = INSIDE * (band.upper - band.lower);
        let inside = Interval::new(band.lower + spare, band.upper - spare);
        let (fit, aside) = if matches!(self.chart, RulingChart::Twisted { .. }) {
            let fit = AxisFit::new(self.face, ruling, radius);
            let moves = fit.run(inside)?;
            (fit.ends(&moves), 0.5 * moves[2].abs())
        } else {
            // The side lies on the face itself, where the band holds that.
            let off = radius + 0.0_f64.clamp(inside.low, inside.high);
            ([0, 1].map(|k| ruling.ends[k] + ruling.normals[k].scale(off)), 0.0)
        };
        let along = UnitVector3::try_new(fit[1] - fit[0], f64::MIN_POSITIVE)?;
        Some(FlankAxis { low: fit[0], along, aside })
    }

    /// Returns the length of a step along the pass, at most on both ends of the rulings and on the path of the
    /// tool's axis \[mm\].
    fn pace(&self, at: f64, step: f64, radius: f64) -> Option<f64> {
        let [a, b] = [self.ruling(at)?, self.ruling(at + step)?];
        let apart = |end: usize, out: f64| {
            let at = |r: &Ruling| r.ends[end] + r.normals[end].scale(out);
            (at(&b) - at(&a)).norm()
        };
        let all = [apart(0, 0.0), apart(1, 0.0), apart(0, radius), apart(1, radius)];
        Some(all.into_iter().fold(0.0, f64::max))
    }

    /// Returns the range along the pass: of a closed face once round and a little on, of an open one longer at both ends by
    /// what the axis there is off the ruling.
    pub(super) fn run(&self, radius: f64, band: ToleranceBand) -> Option<Interval> {
        let [first, last] = self.range;
        if self.closed {
            let length: f64 = self.paces(Interval::new(first, last), radius)?.iter().sum();
            return Some(Interval::new(first, last + OVERLAP * radius * (last - first) / length));
        }
        let step = (last - first) / f64::from(SAMPLES);
        let on = |at: f64, inwards: f64| {
            let aside = RUN_ON * self.axis(at, radius, band)?.aside;
            let [a, b] = [self.ruling(at)?, self.ruling(at + inwards)?];
            let pace = (0..2).map(|k| (b.ends[k] - a.ends[k]).norm()).fold(f64::INFINITY, f64::min);
            let by = aside / pace * step;
            by.is_finite().then_some(by)
        };
        Some(Interval::new(first - on(first, step)?, last + on(last, -step)?))
    }

    /// Returns once round a closed face; `None` for an open one.
    pub(super) fn round(&self) -> Option<Interval> {
        self.closed.then(|| self.range.into())
    }

    /// Returns the lengths of [`SAMPLES`] even steps over a range.
    fn paces(&self, range: Interval, radius: f64) -> Option<Vec<f64>> {
        let step = range.width() / f64::from(SAMPLES);
        (0..SAMPLES).map(|i| self.pace(range.low + step * f64::from(i), step, radius)).collect()
    }

    /// Returns the places of stations at most `spacing` apart over a range.
    pub(super) fn stations(&self, range: Interval, spacing: f64, radius: f64) -> Option<Vec<f64>> {
        // Even steps of the parameter: the longest counts.
        let longest = self.paces(range, radius)?.into_iter().fold(0.0, f64::max);
        let count = (longest * f64::from(SAMPLES) / spacing).ceil().max(2.0);
        let places = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
        Some(places.take_while(|i| *i <= count).map(|i| range.at(i / count)).collect())
    }
}

/// Returns an axis along which the flank of a tool may lie on a wall, upwards: along the edges of a plane where these are
/// parallel, else along the ruling in the middle of the wall; `None` for a face without lines that rise.
pub fn flank_axis(face: &FaceIndex) -> Option<UnitVector3<f64>> {
    let ruled = RuledFace::along_edges(face).or_else(|| RuledFace::new(face))?;
    let [first, last] = ruled.range;
    let Ruling { ends: [low, high], .. } = ruled.ruling(0.5 * (first + last))?;
    UnitVector3::try_new(high - low, f64::MIN_POSITIVE)
}

/// Returns `true` if the side of a tool of a radius \[mm\] lies within a band along every straight line of a face: the face
/// has such lines, and twists little enough along them.
pub fn rulings_fit(face: &FaceIndex, radius: f64, band: ToleranceBand) -> bool {
    RuledFace::new(face).is_some_and(|ruled| {
        let range = Interval::from(ruled.range);
        let places = (0..=TRIED[0]).map(|i| range.at(f64::from(i) / f64::from(TRIED[0])));
        places.into_iter().all(|at| ruled.axis(at, radius, band).is_some())
    })
}

/// Returns the steepest direction in a plane; `None` for another surface, or a level plane.
fn steepest(face: &FaceIndex) -> Option<UnitVector3<f64>> {
    let Surface::Plane(plane) = &face.face().surface else { return None };
    let normal = plane.frame.z();
    UnitVector3::try_new(Vector3::z() - normal.scale(normal.z), f64::MIN_POSITIVE)
}

/// Returns the upward direction of the steepest two straight edges of a face that are parallel and apart; `None` where
/// there are none.
fn steepest_edges(face: &FaceIndex) -> Option<UnitVector3<f64>> {
    let corner = |[u, v]: [f64; 2]| face.face().point(u, v);
    let mut edges: Vec<[Point3<f64>; 2]> = Vec::new();
    for outline in outlines(face) {
        let points: Vec<Point3<f64>> = outline.into_iter().map(corner).collect();
        let next = points.iter().cycle().skip(1);
        edges.extend(points.iter().zip(next).map(|(a, b)| [*a, *b]));
    }
    let length = |[a, b]: &[Point3<f64>; 2]| (b - a).norm();
    let longest = edges.iter().map(length).fold(0.0, f64::max);
    // The chords of a bent edge are short.
    edges.retain(|edge| length(edge) >= LEAST_EDGE * longest);
    let upward = |[a, b]: &[Point3<f64>; 2]| {
        let along = UnitVector3::try_new(b - a, f64::MIN_POSITIVE)?;
        Some(if along.z < 0.0 { -along } else { along })
    };
    let directions: Vec<_> =
        edges.iter().filter_map(|edge| Some((edge[0], upward(edge)?))).collect();
    let has_partner = |(at, along): &&(Point3<f64>, UnitVector3<f64>)| {
        directions.iter().any(|(other, same)| {
            along.cross(same).norm() <= PARALLEL
                && along.cross(&(other - at)).norm() >= LEAST_EDGE * longest
        })
    };
    let paired = directions.iter().filter(has_partner).map(|(_, along)| *along);
    paired.max_by(|a, b| a.z.total_cmp(&b.z))
}

/// Returns the trims of a face as polylines in its parameters; the whole rectangle of a face without trims.
fn outlines(face: &FaceIndex) -> Vec<Vec<[f64; 2]>> {
    let [u, v] = face.face().bounds();
    let tolerance = [u, v].map(|range| LOOP_SHARE * range.width());
    let loops = &face.face().loops;
    if loops.is_empty() {
        return vec![vec![[u.low, v.low], [u.high, v.low], [u.high, v.high], [u.low, v.high]]];
    }
    loops.iter().map(|trim| trim.polyline(tolerance)).collect()
}

/// Returns the ranges of the two coordinates of a face's outline; `None` where one is empty.
fn extent(face: &FaceIndex, place: impl Fn([f64; 2]) -> [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let places: Vec<[f64; 2]> = outlines(face).into_iter().flatten().map(place).collect();
    let ranges = [0, 1].map(|k| {
        let all = || places.iter().map(|place| place[k]);
        [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
    });
    let finite = ranges.iter().flatten().all(|x| x.is_finite());
    (finite && ranges.iter().all(|[low, high]| high > low)).then_some(ranges)
}

/// Returns the parameter along which all lines of a surface are straight, the first of the two: 0 for u, 1 for v.
fn straight_parameter(surface: &Surface, bounds: [Interval; 2]) -> Option<usize> {
    let [lines, points] = TRIED;
    let is_straight = |ruled: usize, line: u32| {
        let fixed = bounds[1 - ruled].at(f64::from(line) / f64::from(lines));
        let at = |share: f64| {
            let moved = bounds[ruled].at(share);
            if ruled == 1 { surface.point(fixed, moved) } else { surface.point(moved, fixed) }
        };
        let [low, high] = [at(0.0), at(1.0)];
        let way = high - low;
        (1..points).all(|i| {
            let off = at(f64::from(i) / f64::from(points)) - low;
            way.cross(&off).norm() <= STRAIGHT * way.norm_squared()
        })
    };
    [1, 0].into_iter().find(|ruled| (0..=lines).all(|line| is_straight(*ruled, line)))
}

/// Fit of an axis to a ruling along which the normal turns.
///
/// The distance of a point of the axis from the face, less the radius, is the deviation of the side there. Both ends of the
/// axis move along their normals, and one against the other along the pass: where the offset face is saddle-shaped, a line
/// in its asymptotic direction follows it to third order.
struct AxisFit<'a> {
    face: &'a FaceIndex,
    ruling: Ruling,
    radius: f64,
    /// Tangents of the face across the ruling, at its ends.
    tangents: [Vector3<f64>; 2],
}

/// Distance of a point of the axis from the face less the radius, and its rates with the three moves.
struct FitPoint {
    deviation: f64,
    rates: Vector3<f64>,
}

impl<'a> AxisFit<'a> {
    fn new(face: &'a FaceIndex, ruling: Ruling, radius: f64) -> Self {
        let along = (ruling.ends[1] - ruling.ends[0]).normalize();
        let tangents = ruling.normals.map(|normal| along.cross(&normal));
        Self { face, ruling, radius, tangents }
    }

    /// Returns both ends of the axis after the moves.
    fn ends(&self, moves: &Vector3<f64>) -> [Point3<f64>; 2] {
        [0, 1].map(|k| {
            let out = self.ruling.normals[k].scale(self.radius + moves[k]);
            let turn = if k == 0 { 0.5 * moves[2] } else { -0.5 * moves[2] };
            self.ruling.ends[k] + out + self.tangents[k] * turn
        })
    }

    /// Returns the deviations along the axis; `None` where the face has no foot point.
    fn points(&self, moves: &Vector3<f64>) -> Option<Vec<FitPoint>> {
        let [low, high] = self.ends(moves);
        let [from, to] = self.ruling.uv;
        let point = |i: u32| {
            let share = f64::from(i) / f64::from(FITTED - 1);
            let at = low + (high - low) * share;
            let guess = [0, 1].map(|k| from[k] + (to[k] - from[k]) * share);
            let foot = self.face.closest_near(&at, guess.into()).ok()?;
            // The foot moves within the face: only the part of a move along the normal counts.
            let n = foot.normal;
            let turn = self.tangents[0] * (0.5 * (1.0 - share)) - self.tangents[1] * (0.5 * share);
            let rates = Vector3::new(
                (1.0 - share) * n.dot(&self.ruling.normals[0]),
                share * n.dot(&self.ruling.normals[1]),
                n.dot(&turn),
            );
            Some(FitPoint { deviation: foot.distance - self.radius, rates })
        };
        (0..FITTED).map(point).collect()
    }

    /// Returns the moves with which the deviations differ least, inside a range \[mm\]; `None` where they do not fit.
    fn run(&self, inside: Interval) -> Option<Vector3<f64>> {
        let mut moves = Vector3::zeros();
        let mut weights = [1.0; FITTED as usize];
        let mut best: Option<(f64, Vector3<f64>)> = None;
        for _ in 0..ROUNDS {
            let points = self.points(&moves)?;
            let worst = points.iter().map(|p| p.deviation.abs()).fold(0.0, f64::max);
            if best.is_none_or(|(least, _)| worst < least) {
                best = Some((worst, moves));
            }
            // Step 1: Lawson's weights lead from least squares to the least largest deviation.
            for (weight, p) in weights.iter_mut().zip(&points) {
                *weight *= p.deviation.abs().max(1e-3 * worst);
            }
            let sum: f64 = weights.iter().sum();
            if sum.is_nan() || sum <= 0.0 {
                break;
            }
            for weight in &mut weights {
                *weight /= sum;
            }
            // Step 2: a Gauss-Newton step of the weighted squares.
            let mut normal = Matrix3::zeros();
            let mut right = Vector3::zeros();
            for (weight, p) in weights.iter().zip(&points) {
                normal += p.rates * p.rates.transpose() * *weight;
                right -= p.rates * (*weight * p.deviation);
            }
            let damping = DAMPING * normal.diagonal().max();
            moves += (normal + Matrix3::identity() * damping).cholesky()?.solve(&right);
        }
        // Step 3: into the range, as near to the face itself as may be.
        let (_, mut moves) = best?;
        let points = self.points(&moves)?;
        let low = points.iter().map(|p| p.deviation).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p.deviation).fold(f64::NEG_INFINITY, f64::max);
        if high - low > inside.width() {
            return None;
        }
        let by = 0.0_f64.clamp(inside.low - low, inside.high - high);
        moves += Vector3::new(by, by, 0.0);
        Some(moves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Face, PlaneSurface, SurfaceFrame, TrimCurve, TrimLoop};

    /// Upright wall in the xz plane whose outline has these corners (x, z).
    fn wall(corners: [[f64; 2]; 4]) -> FaceIndex {
        let frame = SurfaceFrame::new(Point3::origin(), -Vector3::y(), Vector3::x()).unwrap();
        let plane = Surface::Plane(PlaneSurface { frame });
        let [a, b, c, d] = corners;
        let outline = TrimCurve::polyline(&[a, b, c, d, a]).unwrap();
        let outline = TrimLoop::new(vec![outline], [None, None], 1e-9).unwrap();
        FaceIndex::new(Face::new(1, plane, vec![outline]).unwrap()).unwrap()
    }

    fn leans(corners: [[f64; 2]; 4]) -> f64 {
        let along = flank_axis(&wall(corners)).unwrap();
        (along.x / along.z).atan().to_degrees()
    }

    #[test]
    fn the_rulings_of_a_plane_run_along_its_edges_where_these_are_parallel() {
        assert!(leans([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]]).abs() < 1e-9);
        // Between two walls that lean by 45 degrees.
        let leaning = leans([[0.0, 0.0], [30.0, 0.0], [50.0, 20.0], [20.0, 20.0]]);
        assert!((leaning - 45.0).abs() < 1e-9, "{leaning}");
        // Between drafts, which lean against each other, the steepest lines.
        assert!(leans([[0.0, 0.0], [30.0, 0.0], [35.0, 20.0], [-5.0, 20.0]]).abs() < 1e-9);
    }
}
