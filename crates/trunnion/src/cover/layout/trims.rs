//! Trimmed region of a face in the coordinates of a chart.

use super::chart::Chart;
use super::region::{ChartPoint, TrimmedRegion};
use crate::surface::FaceIndex;

/// Tolerance of trim loops as a share of the face's extent in u and in v. Passes run on by the
/// cutter's radius beyond the loops, and their strips begin at a border and end beyond it.
pub(crate) const LOOP_SHARE: f64 = 1e-4;

/// The same for faces that are not cut: well below a micrometre on faces of some hundred
/// millimetres.
pub(crate) const GUARDED_SHARE: f64 = 1e-7;

/// Longest edge of a trim loop on bent passes, as a share of the face's extent. Over such an edge a
/// bend leaves its chord by less than [`LOOP_SHARE`].
const BENT_SHARE: f64 = 1.0 / 256.0;

/// Returns the trimmed region of a face that is not cut, on lines of constant parameters. Beyond
/// its edges the tool is free; a tool that cuts the next face comes as near to these edges as it
/// does to that face.
pub(crate) fn guarded<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
) -> TrimmedRegion<impl Fn(ChartPoint) -> bool + Sync + use<'a>> {
    region_within(face, chart, GUARDED_SHARE)
}

/// Returns the trimmed region in local parameters. Loops on periodic surfaces are repeated a period
/// to either side, so that every line across the face meets them.
pub(crate) fn region<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
) -> TrimmedRegion<impl Fn(ChartPoint) -> bool + Sync + use<'a>> {
    region_within(face, chart, LOOP_SHARE)
}

/// Returns the shifts of the loops on a periodic surface: a period to either side as well, since
/// passes may run on there.
pub(crate) fn shifts(period: Option<f64>, chart: &Chart) -> Vec<f64> {
    match period {
        Some(period) if chart.is_straight() => vec![-period, 0.0, period],
        _ => vec![0.0],
    }
}

fn region_within<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
    share: f64,
) -> TrimmedRegion<impl Fn(ChartPoint) -> bool + Sync + use<'a>> {
    let face = face.face();
    let [u, v] = face.bounds();
    let tolerance = [u, v].map(|range| share * range.width());
    let [pu, pv] = face.surface.periods();
    let mut polylines: Vec<Vec<[f64; 2]>> =
        face.loops.iter().map(|trim| trim.polyline(tolerance)).collect();
    if !chart.is_straight() {
        if polylines.is_empty() {
            // Without trims the border of the rectangle bounds the region on a bent chart.
            polylines.push(vec![
                [u.low, v.low],
                [u.high, v.low],
                [u.high, v.high],
                [u.low, v.high],
            ]);
        }
        let most = [u, v].map(|range| BENT_SHARE * range.width());
        polylines = polylines.iter().map(|points| finer(points, most)).collect();
    }
    let mut loops: Vec<Vec<ChartPoint>> = Vec::new();
    for points in polylines {
        for du in shifts(pu, chart) {
            for dv in shifts(pv, chart) {
                loops.push(points.iter().map(|p| chart.local([p[0] + du, p[1] + dv])).collect());
            }
        }
    }
    let bounds = if chart.is_straight() {
        let [a, b] = [chart.local([u.low, v.low]), chart.local([u.high, v.high])];
        [[a[0], b[0]], [a[1], b[1]]]
    } else {
        [0, 1].map(|k| {
            let values = || loops.iter().flatten().map(|p| p[k]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        })
    };
    let chart = chart.clone();
    TrimmedRegion::new(bounds, &loops, move |local| {
        let [u, v] = chart.uv(local);
        face.contains(u, v)
    })
}

/// Divides a closed polyline into edges no longer than `most` by u and v.
fn finer(points: &[[f64; 2]], most: [f64; 2]) -> Vec<[f64; 2]> {
    let mut fine = Vec::new();
    for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let way = [0, 1].map(|k| b[k] - a[k]);
        // The parameter that would be exceeded most decides the number of pieces.
        let pieces = (way[0].abs() / most[0]).max(way[1].abs() / most[1]).ceil().max(1.0);
        let steps = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
        fine.extend(
            steps.take_while(|i| *i < pieces).map(|i| [0, 1].map(|k| a[k] + way[k] * (i / pieces))),
        );
    }
    fine
}
