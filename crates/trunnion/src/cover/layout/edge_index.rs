//! Edges of closed polylines, in blocks: a block whose box misses a query costs one comparison.

/// Local parameters of a pass, `[across, along]`. Passes follow `along`; the next pass lies farther
/// `across`.
pub(crate) type ChartPoint = [f64; 2];

/// Edges of a block.
const BLOCK: usize = 16;

/// Edges of closed polylines, in their order.
#[derive(Debug, Default)]
pub(super) struct EdgeIndex {
    edges: Vec<[ChartPoint; 2]>,
    /// Ranges across and along of each block of edges.
    boxes: Vec<[[f64; 2]; 2]>,
}

impl EdgeIndex {
    /// Joins the points of every polyline, and the last one with the first.
    pub(super) fn new(polylines: &[Vec<ChartPoint>]) -> Self {
        let closed = |points: &Vec<ChartPoint>| {
            let next = points.iter().copied().cycle().skip(1);
            points.iter().copied().zip(next).map(<[ChartPoint; 2]>::from).collect::<Vec<_>>()
        };
        let edges: Vec<[ChartPoint; 2]> = polylines.iter().flat_map(closed).collect();
        let boxes = edges.chunks(BLOCK).map(box_of).collect();
        Self { edges, boxes }
    }

    /// Returns the corners of all polylines.
    pub(super) fn corners(&self) -> impl Iterator<Item = ChartPoint> + '_ {
        self.edges.iter().map(|[from, _]| *from)
    }

    /// Returns the corners within `[low, high]` along.
    pub(super) fn corners_along(
        &self,
        [low, high]: [f64; 2],
    ) -> impl Iterator<Item = ChartPoint> + '_ {
        let inside = move |p: &ChartPoint| (low..=high).contains(&p[1]);
        self.near(move |[_, along]| along[0] <= high && along[1] >= low)
            .map(|[from, _]| *from)
            .filter(inside)
    }

    /// Returns the edges that meet a box.
    pub(super) fn meeting(
        &self,
        range: [[f64; 2]; 2],
    ) -> impl Iterator<Item = [ChartPoint; 2]> + '_ {
        let apart = move |of: &[[f64; 2]; 2]| {
            (0..2).any(|k| of[k][0] > range[k][1] || of[k][1] < range[k][0])
        };
        self.near(move |of| !apart(of)).filter(move |edge| meets(**edge, range)).copied()
    }

    /// Returns the edges that cross the line where coordinate `k` has a value.
    ///
    /// Half-open test: a corner on the line counts for one of two edges that cross, and for none or both of two that turn
    /// back.
    pub(super) fn crossing(
        &self,
        k: usize,
        value: f64,
    ) -> impl Iterator<Item = [ChartPoint; 2]> + '_ {
        self.near(move |of| of[k][0] <= value && of[k][1] >= value)
            .filter(move |[a, b]| (a[k] <= value) != (b[k] <= value))
            .copied()
    }

    /// Returns the edges of the blocks whose boxes satisfy a condition.
    fn near(
        &self,
        condition: impl Fn(&[[f64; 2]; 2]) -> bool,
    ) -> impl Iterator<Item = &[ChartPoint; 2]> {
        let blocks = self.edges.chunks(BLOCK).zip(&self.boxes);
        blocks.filter(move |(_, of)| condition(of)).flat_map(|(edges, _)| edges)
    }
}

/// Returns `true` if a segment meets a rectangle.
pub(crate) fn meets(segment: [ChartPoint; 2], range: [[f64; 2]; 2]) -> bool {
    clip(segment, range).is_some()
}

/// Returns the ends of the part of a segment in a rectangle, borders included (Liang and Barsky); `None` if there is no
/// such part.
pub(crate) fn clip([a, b]: [ChartPoint; 2], range: [[f64; 2]; 2]) -> Option<[ChartPoint; 2]> {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        let [low, high] = range[k];
        let way = b[k] - a[k];
        if way.abs() > 0.0 {
            // Clip the segment to the slab low..high: the shares at which it enters and leaves.
            let ends = [(low - a[k]) / way, (high - a[k]) / way];
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        } else if a[k] < low || a[k] > high {
            return None;
        }
    }
    let at = |share: f64| [0, 1].map(|k| a[k] + share * (b[k] - a[k]));
    (first <= last).then(|| [at(first), at(last)])
}

/// Returns the ranges across and along of some edges.
fn box_of(edges: &[[ChartPoint; 2]]) -> [[f64; 2]; 2] {
    let nothing = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    edges
        .iter()
        .flatten()
        .fold(nothing, |of, p| [0, 1].map(|k| [of[k][0].min(p[k]), of[k][1].max(p[k])]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A coil of 400 edges, and a square.
    fn polylines() -> [Vec<ChartPoint>; 2] {
        let turn = |k: u32| {
            let (sin, cos) = (0.37 * f64::from(k)).sin_cos();
            let radius = 0.01 * f64::from(k);
            [radius * cos, radius * sin]
        };
        [(0..400).map(turn).collect(), vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]]
    }

    fn all(of: &[Vec<ChartPoint>]) -> Vec<[ChartPoint; 2]> {
        let closed = |points: &Vec<ChartPoint>| {
            (0..points.len())
                .map(|i| [points[i], points[(i + 1) % points.len()]])
                .collect::<Vec<_>>()
        };
        of.iter().flat_map(closed).collect()
    }

    #[test]
    fn blocks_leave_out_no_edge() {
        let polylines = polylines();
        let (index, edges) = (EdgeIndex::new(&polylines), all(&polylines));
        for i in 0..60 {
            let at = 0.13 * f64::from(i) - 4.0;
            let range = [[at, at + 0.3], [-at, 0.4 - at]];
            let expected: Vec<_> =
                edges.iter().copied().filter(|edge| meets(*edge, range)).collect();
            assert_eq!(index.meeting(range).collect::<Vec<_>>(), expected);
            for k in 0..2 {
                let crosses = |[a, b]: &[ChartPoint; 2]| (a[k] <= at) != (b[k] <= at);
                let expected: Vec<_> = edges.iter().copied().filter(crosses).collect();
                assert_eq!(index.crossing(k, at).collect::<Vec<_>>(), expected);
            }
            let expected: Vec<_> = edges
                .iter()
                .map(|edge| edge[0])
                .filter(|p| (at..=at + 0.3).contains(&p[1]))
                .collect();
            assert_eq!(index.corners_along([at, at + 0.3]).collect::<Vec<_>>(), expected);
        }
    }
}
