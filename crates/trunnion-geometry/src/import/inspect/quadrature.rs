//! Points and weights over the trimmed part of a face.

use crate::math;
use crate::surface::Face;
use crate::types::Interval;

/// Intervals between columns of nodes, across the face.
const COLUMNS: usize = 48;
/// Intervals along a column, between two trims.
const ROWS: usize = 6;
/// Chords of a trim are this share of the face's range.
const RIM: f64 = 1.0 / 2048.0;

/// Gauss-Legendre nodes on `[0, 1]` and weights, order 3: exact to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// A point of the face, and the parameter area it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct QuadratureNode {
    pub(super) uv: [f64; 2],
    pub(super) weight: f64,
}

/// Returns nodes inside the trims: columns across the face, each cut at the trims it crosses.
pub(super) fn nodes(face: &Face) -> Vec<QuadratureNode> {
    let bounds = face.bounds();
    // Columns run across loops that run round the surface.
    let round_v = face.loops.iter().any(|trim| trim.turns()[1] != 0);
    let sweep = usize::from(round_v);
    let rims = rims(face);
    let mut nodes = Vec::new();
    for [low, high] in intervals(&cuts(face, &rims, sweep), COLUMNS) {
        for (share, weight) in GAUSS {
            // Outer integral over the columns, inner one along each of them.
            let (x, width) = (low + share * (high - low), weight * (high - low));
            let line = IsoparametricLine { parameter: sweep, value: x };
            for [low, high] in inside(face, &rims, line, bounds[1 - sweep]) {
                rows([low, high], |y, weight| {
                    let uv = if sweep == 0 { [x, y] } else { [y, x] };
                    nodes.push(QuadratureNode { uv, weight: weight * width });
                });
            }
        }
    }
    nodes
}

/// Returns the loops as polylines, or the rim of the range where there are none.
pub(super) fn rims(face: &Face) -> Vec<Vec<[f64; 2]>> {
    let [u, v] = face.bounds();
    let tolerance = [(u.high - u.low) * RIM, (v.high - v.low) * RIM];
    let closed = |mut points: Vec<[f64; 2]>, turns: [i32; 2]| {
        if turns == [0, 0] {
            points.extend(points.first().copied());
        }
        points
    };
    if face.loops.is_empty() {
        return vec![vec![
            [u.low, v.low],
            [u.high, v.low],
            [u.high, v.high],
            [u.low, v.high],
            [u.low, v.low],
        ]];
    }
    face.loops.iter().map(|trim| closed(trim.polyline(tolerance), trim.turns())).collect()
}

/// Divides a rim into steps of at most 1 / `chords` of the face's range: straight in (u, v) is not
/// straight in space.
pub(super) fn dense(face: &Face, rim: &[[f64; 2]], chords: f64) -> Vec<[f64; 2]> {
    let size = face.bounds().map(|range| range.width());
    let mut points: Vec<[f64; 2]> = rim.first().copied().into_iter().collect();
    for pair in rim.windows(2) {
        let step = [0, 1].map(|k| pair[1][k] - pair[0][k]);
        let length = (step[0] / size[0]).abs().max((step[1] / size[1]).abs());
        // A rim runs round a period at most once between two points.
        let parts = (length * chords).ceil().clamp(1.0, 4.0 * chords);
        let mut part = 1.0;
        while part <= parts {
            let share = part / parts;
            points.push([0, 1].map(|k| pair[0][k] + step[k] * share));
            part += 1.0;
        }
    }
    points
}

/// Returns the values of the swept parameter at which the face's width may change abruptly: at
/// corners of the rims, and where a rim turns back.
fn cuts(face: &Face, rims: &[Vec<[f64; 2]>], sweep: usize) -> Vec<f64> {
    /// Cosine of the turn that makes a corner: 30 degrees, a good deal more than a chord's.
    const CORNER: f64 = 0.866;
    let bounds = face.bounds();
    let Interval { low, high } = bounds[sweep];
    let size = bounds.map(|range| range.width());
    let mut cuts = vec![low, high];
    for rim in rims {
        for triple in rim.windows(3) {
            let step = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| (b[k] - a[k]) / size[k]);
            let (a, b) = (step(triple[0], triple[1]), step(triple[1], triple[2]));
            // In shares of the range, so that mm and rad compare.
            let cosine =
                (a[0] * b[0] + a[1] * b[1]) / (math::hypot(a[0], a[1]) * math::hypot(b[0], b[1]));
            if cosine < CORNER || a[sweep] * b[sweep] < 0.0 {
                cuts.push(triple[1][sweep]);
            }
        }
        // The first point has no chord before it; a loop may have its corner there.
        cuts.extend(rim.first().map(|point| point[sweep]));
    }
    cuts.retain(|x| (low..=high).contains(x));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

/// Divides the intervals between `cuts` so that there are about `count` in all.
fn intervals(cuts: &[f64], count: usize) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (cuts.first(), cuts.last()) else { return Vec::new() };
    let step = (last - first) / count as f64;
    let mut all = Vec::new();
    for pair in cuts.windows(2) {
        let width = pair[1] - pair[0];
        let parts = (width / step).ceil().clamp(1.0, count as f64);
        let mut low = pair[0];
        let mut part = 1.0;
        while part <= parts {
            let high = pair[0] + width * (part / parts);
            all.push([low, high]);
            low = high;
            part += 1.0;
        }
    }
    all
}

/// A line along which one parameter keeps its value.
#[derive(Debug, Clone, Copy, PartialEq)]
struct IsoparametricLine {
    /// The fixed parameter: 0 = u, 1 = v.
    parameter: usize,
    value: f64,
}

/// Returns the segments of a line over `[low, high]` that lie inside the trims.
fn inside(
    face: &Face,
    rims: &[Vec<[f64; 2]>],
    line: IsoparametricLine,
    Interval { low, high }: Interval,
) -> Vec<[f64; 2]> {
    let periods = face.surface.periods();
    let mut cuts = vec![low, high];
    for rim in rims {
        crossings(rim, line, periods, &mut cuts);
    }
    cuts.retain(|y| (low..=high).contains(y));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    // Between two crossings the line is inside or outside as a whole: the middle decides.
    let kept = |pair: &[f64]| {
        let y = 0.5 * (pair[0] + pair[1]);
        let [u, v] = if line.parameter == 0 { [line.value, y] } else { [y, line.value] };
        face.contains(u, v)
    };
    cuts.windows(2).filter(|pair| kept(pair)).map(|pair| [pair[0], pair[1]]).collect()
}

/// Calls `node` with the Gauss nodes and weights of an interval.
fn rows([low, high]: [f64; 2], mut node: impl FnMut(f64, f64)) {
    let step = (high - low) / ROWS as f64;
    for row in 0..ROWS {
        for (share, weight) in GAUSS {
            node(low + step * (row as f64 + share), weight * step);
        }
    }
}

/// Adds the points at which a line meets a polyline or one of its copies on other turns.
fn crossings(
    rim: &[[f64; 2]],
    line: IsoparametricLine,
    periods: [Option<f64>; 2],
    cuts: &mut Vec<f64>,
) {
    let IsoparametricLine { parameter: sweep, value: x } = line;
    // A face is at most one period wide, and its loops lie within a period of each other.
    let turns = |k: usize| match periods[k] {
        Some(period) => vec![-2.0 * period, -period, 0.0, period, 2.0 * period],
        None => vec![0.0],
    };
    for pair in rim.windows(2) {
        let [a, b] = [pair[0][sweep], pair[1][sweep]];
        let [c, d] = [pair[0][1 - sweep], pair[1][1 - sweep]];
        for turn in turns(sweep) {
            let (a, b) = (a + turn, b + turn);
            // Half-open: a line through a corner crosses one of the two chords there.
            if (a <= x) == (b <= x) {
                continue;
            }
            // A crossing counts on every turn; the caller keeps those within the range.
            let y = c + (d - c) * ((x - a) / (b - a));
            cuts.extend(turns(1 - sweep).iter().map(|other| y + other));
        }
    }
}
