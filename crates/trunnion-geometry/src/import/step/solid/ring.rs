//! Edge loops as corners in space and in parameters.

use super::super::chart::SurfaceChart;
use super::super::curve::StepCurve;
use super::super::model::{Read, loss};
use super::super::topology::{FaceBoundary, LoopEdge};
use super::super::trim::{EdgeTrack, TrackEnd, TrimExactness, beside, chain};
use super::corner::MeshCorner;
use nalgebra::Point3;

/// A loop, face on the left, each corner once.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoundaryRing {
    pub(super) corners: Vec<MeshCorner>,
    /// Difference of end and start by u and v: whole periods.
    pub(super) advance: [f64; 2],
}

/// Shares of the tolerance that the chords of an edge are off at most, and that leaving out points
/// may add: less than inside a face, where triangles would be parted for ever if their border were
/// worse than they may be.
pub(super) const CHORDS: f64 = 0.2;
const THINNED: f64 = 0.1;
/// Halvings of one interval of an edge.
const HALVINGS: u32 = 10;

/// Brings a loop into parameters; `None` for one that bounds nothing: a single vertex.
pub(super) fn ring(
    chart: &SurfaceChart<'_>,
    boundary: &FaceBoundary,
    [chord, same]: [f64; 2],
) -> Read<Option<BoundaryRing>> {
    let (mut tracks, mut places): (Vec<EdgeTrack>, Vec<Vec<Point3<f64>>>) =
        (Vec::new(), Vec::new());
    for edge in &boundary.edges {
        let near = tracks.last().and_then(|track| track.points.last().copied());
        if let Some((track, points)) = track(chart, edge, chord, near)? {
            tracks.push(track);
            places.push(points);
        }
    }
    if tracks.is_empty() {
        return Ok(None);
    }
    // Now the tracks follow each other; between them there may be lines along poles.
    let curves = chain(chart, boundary.id, &mut tracks, TrimExactness { chord, same })?;
    let first = tracks[0].points[0];
    let last = curves.last().and_then(|curve| curve.last()).copied().unwrap_or(first);
    let mut corners = Vec::new();
    for (k, (track, points)) in tracks.iter().zip(&places).enumerate() {
        let next = &tracks[(k + 1) % tracks.len()].ends[0];
        let along_pole = track.ends[1].pole.is_some() && track.ends[1].pole == next.pole;
        let all = track.points.iter().zip(points).map(|(&uv, &point)| MeshCorner { uv, point });
        // The last corner of an edge is the first of the next one.
        corners.extend(all.take(if along_pole { points.len() } else { points.len() - 1 }));
    }
    let turns = |k: usize| match chart.periods[k] {
        Some(period) => period * ((last[k] - first[k]) / period).round(),
        None => 0.0,
    };
    Ok(Some(BoundaryRing { corners, advance: [turns(0), turns(1)] }))
}

/// Brings an edge into parameters; `None` for one that lies in a pole altogether.
fn track(
    chart: &SurfaceChart<'_>,
    edge: &LoopEdge,
    chord: f64,
    near: Option<[f64; 2]>,
) -> Read<Option<(EdgeTrack, Vec<Point3<f64>>)>> {
    let all = chords(edge, chord);
    let [Some(&start), Some(&end)] = [all.first(), all.last()] else { return Ok(None) };
    let (mut points, mut places) = (Vec::new(), Vec::new());
    let mut guess = near;
    for point in &all {
        if chart.pole(point).is_some() {
            continue;
        }
        let Some(uv) = chart.uv(point, guess) else {
            return loss(edge.id, "a point of the edge has no parameters on the surface");
        };
        points.push(uv);
        places.push(*point);
        guess = Some(uv);
    }
    let [Some(&first), Some(&last)] = [points.first(), points.last()] else { return Ok(None) };
    let ends = [start, end].map(|point| TrackEnd { point, pole: chart.pole(&point) });
    if let Some(pole) = ends[0].pole {
        points.insert(0, beside(pole, first));
        places.insert(0, start);
    }
    if let Some(pole) = ends[1].pole {
        points.push(beside(pole, last));
        places.push(end);
    }
    Ok(Some((EdgeTrack { edge: edge.id, points, ends }, places)))
}

/// Returns points of an edge from vertex to vertex, chords within about `chord` of it: the same
/// ones for both its faces.
fn chords(edge: &LoopEdge, chord: f64) -> Vec<Point3<f64>> {
    let [start, end] = edge.ends;
    if matches!(edge.curve, StepCurve::Line { .. }) {
        return vec![start, end];
    }
    // Always divided forward along the curve: both faces of the edge get the same points.
    let backward = edge.range[0] > edge.range[1];
    let mut range = edge.range;
    if backward {
        range.reverse();
    }
    let at = |t: f64| CurveSample { t, point: edge.curve.point_around(t) };
    let mut points = vec![at(range[0]).point];
    for pair in edge.curve.stations(range).windows(2) {
        let ends = [at(pair[0]), at(pair[1])];
        halve(&edge.curve, ends, chord, HALVINGS, &mut points);
        points.push(ends[1].point);
    }
    // Splines come in many short spans; of a small closed one something has to be left.
    if matches!(edge.curve, StepCurve::Spline(_)) && (end - start).norm() > SMALL * chord {
        points = thinned(&points, chord);
    }
    if backward {
        points.reverse();
    }
    // Vertices replace the ends of the curve, which may be off by the tolerance of the file.
    if let [first, .., last] = &mut points[..] {
        (*first, *last) = (start, end);
    }
    points
}

/// Ends of an edge that are this many chord tolerances apart are those of an open curve.
const SMALL: f64 = 10.0;

/// A point of a curve with its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CurveSample {
    t: f64,
    point: Point3<f64>,
}

/// Adds the points between two samples of a curve, by at most `left` halvings.
fn halve(
    curve: &StepCurve,
    [a, b]: [CurveSample; 2],
    chord: f64,
    left: u32,
    out: &mut Vec<Point3<f64>>,
) {
    let at = |share: f64| curve.point_around(a.t + share * (b.t - a.t));
    if left == 0 || is_chord(&at, [&a.point, &b.point], CHORDS * chord) {
        return;
    }
    let middle = CurveSample { t: 0.5 * (a.t + b.t), point: at(0.5) };
    halve(curve, [a, middle], chord, left - 1, out);
    out.push(middle.point);
    halve(curve, [middle, b], chord, left - 1, out);
}

/// Leaves out points that chords pass closely.
fn thinned(all: &[Point3<f64>], chord: f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::new();
    let mut from = 0;
    for at in 0..all.len() {
        let passes = |k: usize| off(&all[k], [&all[from], &all[at]]) <= THINNED * chord;
        // The chord to this point passes one before it too far off: it has to end at the last.
        if at > from + 1 && !(from + 1..at).all(passes) {
            kept.push(all[from]);
            from = at - 1;
        }
    }
    kept.extend(all.get(from));
    kept.extend(all.last());
    kept
}

/// Returns `true` if a curve is within `chord` \[mm\] of its chord: at its quarters, too, since it
/// may cross the chord in the middle.
pub(super) fn is_chord(
    at: &dyn Fn(f64) -> Point3<f64>,
    ends: [&Point3<f64>; 2],
    chord: f64,
) -> bool {
    [0.5, 0.25, 0.75].iter().all(|&share| off(&at(share), ends) <= chord)
}

/// Returns the distance of a point from a segment.
pub(super) fn off(p: &Point3<f64>, [a, b]: [&Point3<f64>; 2]) -> f64 {
    let along = b - a;
    // A segment without length is a point: the share is then 0.
    let share = along.dot(&(p - a)) / along.norm_squared().max(f64::MIN_POSITIVE);
    (p - (a + along * share.clamp(0.0, 1.0))).norm()
}
