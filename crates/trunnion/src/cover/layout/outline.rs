//! Outline of a plane face, and the straight lines that sweep it.

use super::contour::{PlanePoint, apart, between};
use crate::math;
use crate::types::Interval;

/// Length of an edge from which its direction is tried for the lines, as a share of the outline's extent.
const LONG_EDGE: f64 = 0.1;

/// Directions that are tried at most.
const DIRECTIONS: usize = 8;

/// Scan lines in a strip, besides its borders.
const SCANS: u32 = 7;

/// Closed polylines around a plane face; the last point of each joins the first.
#[derive(Debug, Clone)]
pub(crate) struct FaceOutline {
    loops: Vec<Vec<PlanePoint>>,
}

/// Straight line across the outline, with the ranges that are worth a pass.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SweepLine {
    /// Distance of the line across.
    pub(crate) across: f64,
    /// Ranges along the line.
    pub(crate) along: Vec<Interval>,
}

impl FaceOutline {
    pub(crate) fn new(loops: Vec<Vec<PlanePoint>>) -> Self {
        Self { loops }
    }

    fn edges(&self) -> impl Iterator<Item = [PlanePoint; 2]> + '_ {
        self.loops.iter().flat_map(|points| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next).map(|(a, b)| [*a, *b])
        })
    }

    /// Returns the box around the outline.
    pub(crate) fn bounds(&self) -> [PlanePoint; 2] {
        let all = || self.loops.iter().flatten();
        let low = [0, 1].map(|k| all().map(|p| p[k]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|k| all().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
        [low, high]
    }

    /// Returns the outline turned by an angle: a point at that angle comes to lie along the first axis.
    pub(crate) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = math::sin_cos(angle);
        let turn = |p: &PlanePoint| [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]];
        Self { loops: self.loops.iter().map(|points| points.iter().map(turn).collect()).collect() }
    }

    /// Returns the direction along which lines a distance of `spacing` apart are fewest, and shortest among equals, as
    /// an angle.
    pub(crate) fn direction(&self, spacing: f64) -> f64 {
        let [low, high] = self.bounds();
        let long = LONG_EDGE * apart(low, high);
        let mut edges: Vec<[PlanePoint; 2]> =
            self.edges().filter(|[a, b]| apart(*a, *b) >= long).collect();
        edges.sort_by(|[a, b], [c, d]| apart(*c, *d).total_cmp(&apart(*a, *b)));
        let edges = edges.into_iter().take(DIRECTIONS);
        let angles = edges.map(|[a, b]| math::atan2(b[1] - a[1], b[0] - a[0]));
        let angles = [0.0, std::f64::consts::FRAC_PI_2].into_iter().chain(angles);
        let rank = |angle: f64| {
            let [low, high] = self.turned(angle).bounds();
            // Lines of nearly the same number count as equal: rounding must not choose.
            (((high[1] - low[1]) / spacing - 1e-6).ceil(), high[0] - low[0])
        };
        let order = |(a, b): &(f64, f64), (c, d): &(f64, f64)| {
            a.total_cmp(c).then_with(|| {
                if (b - d).abs() < 1e-6 { std::cmp::Ordering::Equal } else { b.total_cmp(d) }
            })
        };
        let ranked = angles.map(|angle| (rank(angle), angle));
        ranked.min_by(|a, b| order(&a.0, &b.0)).map_or(0.0, |(_, angle)| angle)
    }

    /// Returns lines along the first axis, such that every point of the face is within `reach` of one, measured across.
    ///
    /// Ranges that are nearer to each other than `joined` are one.
    pub(crate) fn lines(&self, reach: f64, joined: f64) -> Vec<SweepLine> {
        let [[_, low], [_, high]] = self.bounds();
        let extent = high - low;
        let middle = 0.5 * (low + high);
        if extent <= 2.0 * reach {
            return vec![self.line(middle, 0.5 * extent, joined)];
        }
        let gaps = (extent / (2.0 * reach) - 1.0).ceil().max(1.0);
        let spacing = (extent - 2.0 * reach) / gaps;
        let count = std::iter::successors(Some(0.0), |i| Some(i + 1.0)).take_while(|i| *i <= gaps);
        count.map(|i| self.line(low + reach + spacing * i, reach, joined)).collect()
    }

    fn line(&self, across: f64, reach: f64, joined: f64) -> SweepLine {
        let strip = Interval::new(across - reach, across + reach);
        // Step 1: ranges inside on scan lines, and those of the edges in the strip.
        let scans = (0..=SCANS).map(|i| strip.at((f64::from(i) + 0.5) / f64::from(SCANS + 1)));
        let mut ranges: Vec<Interval> = scans.flat_map(|at| self.row(at)).collect();
        ranges.extend(self.edges().filter_map(|edge| within_strip(edge, strip)));
        ranges.sort_by(|a, b| a.low.total_cmp(&b.low));
        // Step 2: their union.
        let mut along: Vec<Interval> = Vec::new();
        for range in ranges {
            match along.last_mut() {
                Some(last) if range.low <= last.high + joined => *last = last.hull(range),
                _ => along.push(range),
            }
        }
        SweepLine { across, along }
    }

    /// Returns the ranges inside the outline on a line along the first axis.
    fn row(&self, across: f64) -> Vec<Interval> {
        let crossing = |[a, b]: [PlanePoint; 2]| {
            ((a[1] <= across) != (b[1] <= across))
                .then(|| between(a, b, (across - a[1]) / (b[1] - a[1]))[0])
        };
        let mut cuts: Vec<f64> = self.edges().filter_map(crossing).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.chunks_exact(2).map(|pair| Interval::new(pair[0], pair[1])).collect()
    }

    /// Returns `true` if a point is inside the outline or at most `reach` from it.
    pub(crate) fn is_near(&self, p: PlanePoint, reach: f64) -> bool {
        let inside = self.row(p[1]).iter().any(|range| range.contains(p[0]));
        inside || self.edges().any(|edge| off_edge(edge, p) <= reach)
    }
}

/// Returns the range along of the part of an edge that lies in a strip.
fn within_strip([a, b]: [PlanePoint; 2], strip: Interval) -> Option<Interval> {
    let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    if high[1] < strip.low || low[1] > strip.high {
        return None;
    }
    let rise = high[1] - low[1];
    let at = |level: f64| if rise > 0.0 { ((level - low[1]) / rise).clamp(0.0, 1.0) } else { 0.0 };
    let [from, to] = if rise > 0.0 { [at(strip.low), at(strip.high)] } else { [0.0, 1.0] };
    let [from, to] = [from, to].map(|share| between(low, high, share)[0]);
    Some(Interval::new(from.min(to), from.max(to)))
}

fn off_edge([a, b]: [PlanePoint; 2], p: PlanePoint) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
    let share = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / square;
    apart(between(a, b, share.clamp(0.0, 1.0)), p)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate of 60 x 40 with a square hole of 10.
    fn plate() -> FaceOutline {
        FaceOutline::new(vec![
            vec![[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]],
            vec![[25.0, 15.0], [35.0, 15.0], [35.0, 25.0], [25.0, 25.0]],
        ])
    }

    #[test]
    fn lines_run_the_long_way_and_miss_nothing() {
        let plate = plate();
        assert!(plate.direction(9.0).abs() < 1e-12);
        let lines = plate.lines(4.5, 0.0);
        assert_eq!(lines.len(), 5);
        assert!((lines[0].across - 4.5).abs() < 1e-12 && (lines[4].across - 35.5).abs() < 1e-12);
        // The strip of the middle line, 15.5 to 24.5, lies wholly beside the hole.
        let along: Vec<[f64; 2]> = lines[2].along.iter().map(|r| [r.low, r.high]).collect();
        assert_eq!(along, [[0.0, 25.0], [35.0, 60.0]]);
        // The strips beside it, 7.75 to 16.75, hold what is in front of the hole.
        assert_eq!(lines[1].along, [Interval::new(0.0, 60.0)]);
        assert_eq!(plate.lines(4.5, 11.0)[2].along, [Interval::new(0.0, 60.0)]);
    }

    #[test]
    fn a_turned_outline_is_swept_along_its_edges() {
        let turned = plate().turned(0.3);
        let angle = turned.direction(9.0);
        assert!((angle + 0.3).sin().abs() < 1e-9, "{angle}");
        let [low, high] = turned.turned(angle).bounds();
        assert!((high[1] - low[1] - 40.0).abs() < 1e-9);
    }

    #[test]
    fn points_beside_the_outline_are_near() {
        let plate = plate();
        assert!(plate.is_near([10.0, 10.0], 0.0) && !plate.is_near([30.0, 20.0], 4.9));
        assert!(plate.is_near([30.0, 20.0], 5.0) && plate.is_near([-3.0, 10.0], 3.0));
    }
}
