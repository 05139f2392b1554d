//! Edge loops brought into the parameters of their surface.
//!
//! The curve in space is taken as the edge; parameter curves of the file, where there are any, are
//! not needed and not read (they are often absent, and differ from the curve in space by as much as
//! the file's tolerance). Every loop is followed *continuously*: parameters of a periodic surface
//! are never brought back by a period, so that a seam, run along twice, needs no special case. At a
//! pole, where one parameter is free, the loop runs along the pole's line; the face is on the left.

use super::chart::ChartPole;
use super::chart::SurfaceChart;
use super::model::FaceLoss;
use super::model::Read;
use super::model::loss;
use super::topology::FaceBoundary;
use super::topology::LoopEdge;
use crate::surface::TrimCurve;
use crate::surface::TrimLoop;
use nalgebra::Point3;

/// Bisections of one interval of an edge: chords shrink to 1/1024, their sagitta to a millionth.
const HALVINGS: u32 = 10;

/// Points of one edge: a bound on memory that no sane edge reaches.
const MAX_POINTS: usize = 20_000;

/// Tolerances of trims.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrimExactness {
    /// Largest distance \[mm\] of a chord of the trim from the edge curve.
    pub(super) chord: f64,
    /// Distance \[mm\] up to which two points count as one.
    pub(super) same: f64,
}

/// An edge in parameters, on some turn.
pub(super) struct EdgeTrack {
    pub(super) edge: u64,
    pub(super) points: Vec<[f64; 2]>,
    pub(super) ends: [TrackEnd; 2],
}

#[derive(Clone, Copy)]
pub(super) struct TrackEnd {
    pub(super) point: Point3<f64>,
    pub(super) pole: Option<ChartPole>,
}

/// Returns the loop in parameters, and the largest distance \[mm\] of its edges from the surface
/// with the entity of the worst edge. `None` for a loop that bounds nothing: a single vertex.
pub(super) fn trim_loop(
    chart: &SurfaceChart<'_>,
    boundary: &FaceBoundary,
    exactness: TrimExactness,
) -> Read<Option<(TrimLoop, f64, u64)>> {
    let mut worst = (0.0, 0);
    let mut tracks: Vec<EdgeTrack> = Vec::new();
    for edge in &boundary.edges {
        let near = tracks.last().and_then(|track| track.points.last().copied());
        let (track, off) = EdgeTracer { chart, edge, exactness, off: 0.0 }.track(near)?;
        if off > worst.0 {
            worst = (off, edge.id);
        }
        tracks.extend(track);
    }
    if tracks.is_empty() {
        return Ok(None);
    }
    let curves = chain(chart, boundary.id, &mut tracks, exactness)?;
    let named = |faults: crate::surface::SurfaceErrors| {
        let all: Vec<String> = faults.iter().map(ToString::to_string).collect();
        FaceLoss { entity: boundary.id, message: all.join("; ") }
    };
    let curves: Result<Vec<TrimCurve>, _> =
        curves.iter().map(|points| TrimCurve::polyline(points)).collect();
    // The chain is continuous by construction; what is left is rounding of whole periods.
    let rounding = 1e-9 * (1.0 + size(&tracks));
    let trim = curves.and_then(|c| TrimLoop::new(c, chart.surface.periods(), rounding));
    trim.map(|trim| Some((trim, worst.0, worst.1))).map_err(named)
}

fn size(tracks: &[EdgeTrack]) -> f64 {
    tracks.iter().flat_map(|t| &t.points).flatten().fold(0.0, |size, x| x.abs().max(size))
}

/// Samples one edge.
struct EdgeTracer<'a> {
    chart: &'a SurfaceChart<'a>,
    edge: &'a LoopEdge,
    exactness: TrimExactness,
    off: f64,
}

/// A sample of an edge.
#[derive(Clone, Copy)]
struct EdgeSample {
    t: f64,
    uv: [f64; 2],
}

impl EdgeTracer<'_> {
    /// Follows the edge in parameters; `None` if it lies in a pole altogether.
    fn track(mut self, near: Option<[f64; 2]>) -> Read<(Option<EdgeTrack>, f64)> {
        let stations = self.edge.curve.stations(self.edge.range);
        let points: Vec<(f64, Point3<f64>)> =
            stations.iter().map(|&t| (t, self.edge.curve.point_around(t))).collect();
        let poles: Vec<Option<ChartPole>> =
            points.iter().map(|(_, p)| self.chart.pole(p)).collect();
        let mut samples: Vec<EdgeSample> = Vec::new();
        let mut guess = near;
        for (&(t, point), pole) in points.iter().zip(&poles) {
            if pole.is_some() {
                continue;
            }
            let uv = self.uv(&point, guess)?;
            samples.push(EdgeSample { t, uv });
            // Each sample stays on the turn of the one before: the edge is continuous.
            guess = Some(uv);
        }
        let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else {
            return Ok((None, 0.0));
        };
        let (Some(start), Some(end)) = (points.first(), points.last()) else {
            return Ok((None, 0.0));
        };
        let mut fine = vec![first.uv];
        for pair in samples.windows(2) {
            self.refine(pair[0], pair[1], HALVINGS, &mut fine)?;
        }
        let mut fine = self.simplified(&fine);
        // At a pole the free parameter is taken from the nearest sample beside it.
        if let Some(pole) = poles.first().copied().flatten() {
            fine.insert(0, beside(pole, first.uv));
        }
        if let Some(pole) = poles.last().copied().flatten() {
            fine.push(beside(pole, last.uv));
        }
        let ends = [
            TrackEnd { point: start.1, pole: poles.first().copied().flatten() },
            TrackEnd { point: end.1, pole: poles.last().copied().flatten() },
        ];
        Ok((Some(EdgeTrack { edge: self.edge.id, points: fine, ends }), self.off))
    }

    fn uv(&mut self, point: &Point3<f64>, near: Option<[f64; 2]>) -> Read<[f64; 2]> {
        let Some(uv) = self.chart.uv(point, near) else {
            return loss(self.edge.id, "a point of the edge has no parameters on the surface");
        };
        self.off = self.off.max((self.chart.point(uv) - point).norm());
        Ok(uv)
    }

    /// Adds points up to and with `b`, so that chords stay within the tolerance.
    fn refine(
        &mut self,
        a: EdgeSample,
        b: EdgeSample,
        left: u32,
        out: &mut Vec<[f64; 2]>,
    ) -> Read<()> {
        let t = 0.5 * (a.t + b.t);
        let middle = between(a.uv, b.uv, 0.5);
        let point = self.edge.curve.point_around(t);
        let ends_here = left == 0 || out.len() >= MAX_POINTS || self.chart.pole(&point).is_some();
        if ends_here || self.is_chord(a, b) {
            out.push(b.uv);
            return Ok(());
        }
        let uv = self.uv(&point, Some(middle))?;
        let m = EdgeSample { t, uv };
        self.refine(a, m, left - 1, out)?;
        self.refine(m, b, left - 1, out)
    }

    /// Returns `true` if the edge is within half the tolerance of the straight line in u, v: at its quarters, too, since
    /// an edge in the shape of an S crosses the line in the middle.
    fn is_chord(&self, a: EdgeSample, b: EdgeSample) -> bool {
        const QUARTERS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
        let line = QUARTERS.map(|share| self.chart.point(between(a.uv, b.uv, share)));
        (1..4).all(|k| {
            let gap = line[k] - self.edge.curve.point_around(a.t + QUARTERS[k] * (b.t - a.t));
            // Only the part across the line counts: parameters may run unevenly along it.
            let way = line[k + 1] - line[k - 1];
            let along = way * (way.dot(&gap) / way.norm_squared().max(f64::MIN_POSITIVE));
            (gap - along).norm() <= 0.5 * self.exactness.chord
        })
    }
}

/// Returns the point at a share of the way between two.
fn between(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| a[k] + share * (b[k] - a[k]))
}

impl EdgeTracer<'_> {
    /// Leaves out points that chords pass within half the tolerance (Douglas and Peucker's scheme;
    /// the other half is spent by [`EdgeTracer::refine`]): spline edges come in many short spans.
    fn simplified(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut keep = vec![false; points.len()];
        let mut open = vec![(0, points.len().saturating_sub(1))];
        while let Some((from, to)) = open.pop() {
            for end in [from, to] {
                keep.iter_mut().skip(end).take(1).for_each(|kept| *kept = true);
            }
            let (mut worst, mut place) = (0.5 * self.exactness.chord, None);
            for middle in from + 1..to {
                let gap = self.off_chord(points[middle], [points[from], points[to]]);
                if gap > worst {
                    (worst, place) = (gap, Some(middle));
                }
            }
            // The point farthest off is kept, and both halves are examined.
            if let Some(place) = place {
                open.extend([(from, place), (place, to)]);
            }
        }
        points.iter().zip(keep).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
    }

    /// Returns the distance \[mm\] of a point from the chord's point at the same share of its
    /// length.
    fn off_chord(&self, p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
        let (step, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        // Shares of u and v apart: they may be mm and rad.
        let k = usize::from(step[1].abs() > step[0].abs());
        let share = if step[k].abs() > 0.0 { (from[k] / step[k]).clamp(0.0, 1.0) } else { 0.0 };
        let foot = [a[0] + share * step[0], a[1] + share * step[1]];
        (self.chart.point(foot) - self.chart.point(p)).norm()
    }
}

/// Returns the parameters of a pole as met along an edge whose nearest other sample is `uv`.
pub(super) fn beside(pole: ChartPole, uv: [f64; 2]) -> [f64; 2] {
    let mut at = uv;
    at[pole.fixed] = pole.at;
    at
}

/// Moves the tracks to follow each other and adds the lines along poles between them.
pub(super) fn chain(
    chart: &SurfaceChart<'_>,
    id: u64,
    tracks: &mut [EdgeTrack],
    exactness: TrimExactness,
) -> Read<Vec<Vec<[f64; 2]>>> {
    let count = tracks.len();
    let mut curves = Vec::new();
    for i in 0..count {
        let curve = tracks[i].points.clone();
        let (Some(&end), Some(&before)) = (curve.last(), curve.iter().rev().nth(1)) else {
            return loss(id, "an edge has fewer than two points");
        };
        let next = &tracks[(i + 1) % count];
        let (from, to) = (tracks[i].ends[1], next.ends[0]);
        let Some(&start) = next.points.first() else {
            return loss(id, "an edge has no points");
        };
        // Two edges that meet in a pole are joined along it; others start where the last one ends,
        // on its turn.
        let goal = match (from.pole, to.pole) {
            (Some(pole), Some(other)) if pole == other => {
                along_pole(chart, pole, [before, end], start)
            }
            _ => {
                let gap = (from.point - to.point).norm();
                if gap > exactness.same {
                    let (a, b) = (tracks[i].edge, next.edge);
                    let message = format!("edges #{a} and #{b} do not meet: {gap:.6} mm apart");
                    return loss(id, message);
                }
                chart.nearest_turn(start, end)
            }
        };
        curves.push(curve);
        let gap = (goal[0] - end[0]).abs() + (goal[1] - end[1]).abs();
        if gap > 0.0 {
            curves.push(vec![end, goal]);
        }
        // The last edge is not moved back to the first: the difference is the turns of the loop.
        if i + 1 < count {
            let shift = [goal[0] - start[0], goal[1] - start[1]];
            for point in &mut tracks[i + 1].points {
                *point = [point[0] + shift[0], point[1] + shift[1]];
            }
        }
    }
    Ok(curves)
}

/// Returns the parameters at which the next edge starts when the loop arrives at a pole by
/// `[before, end]` and its next edge leaves it at `start`, on some turn.
///
/// The face is on the left of the loop: along the upper line v = const the loop runs towards -u,
/// along the lower towards +u; along the right line u = const towards +v, along the left towards
/// -v. An edge that goes back where it came from (a seam) runs round the whole pole.
fn along_pole(
    chart: &SurfaceChart<'_>,
    pole: ChartPole,
    [before, end]: [[f64; 2]; 2],
    start: [f64; 2],
) -> [f64; 2] {
    /// Share of a period below which two directions at the pole are one: the last digits of a file.
    const SAME: f64 = 1e-6;
    let free = 1 - pole.fixed;
    let mut goal = start;
    goal[pole.fixed] = pole.at;
    let Some(period) = chart.periods[free] else { return goal };
    let high = before[pole.fixed] < pole.at;
    let forward = high == (pole.fixed == 0);
    // Share of a period from the end of one edge forward to the start of the next.
    let ahead = ((start[free] - end[free]) / period).rem_euclid(1.0);
    let share = if forward { ahead } else { 1.0 - ahead };
    let share = if share < SAME { share + 1.0 } else { share };
    goal[free] = end[free] + period * if forward { share } else { -share };
    goal
}
