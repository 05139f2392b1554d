//! Region of a parameter rectangle inside the trim loops, seen across and along the passes.

use std::sync::Arc;

/// Local parameters of a pass, `[across, along]`. Passes follow `along`; the next pass lies farther
/// `across`.
pub(crate) type ChartPoint = [f64; 2];

/// Area that is excluded from a region: a test for points, and its edges.
#[derive(Clone)]
struct ExcludedArea {
    holds: Arc<dyn Fn(ChartPoint) -> bool + Send + Sync>,
    edges: Arc<[Vec<ChartPoint>]>,
}

/// Trimmed region of a face in local parameters.
#[derive(Clone)]
pub(crate) struct TrimmedRegion<Inside> {
    /// Ranges of across and along that hold the region.
    pub(crate) bounds: [[f64; 2]; 2],
    /// Trim loops as closed polylines (the last point joins the first).
    loops: Vec<Vec<ChartPoint>>,
    inside: Inside,
    out: Option<ExcludedArea>,
}

impl<Inside: Fn(ChartPoint) -> bool> TrimmedRegion<Inside> {
    pub(crate) fn new(bounds: [[f64; 2]; 2], loops: Vec<Vec<ChartPoint>>, inside: Inside) -> Self {
        Self { bounds, loops, inside, out: None }
    }

    /// Excludes the points for which `holds` is true; `edges` bound them.
    pub(crate) fn without(
        mut self,
        holds: impl Fn(ChartPoint) -> bool + Send + Sync + 'static,
        edges: Vec<[ChartPoint; 2]>,
    ) -> Self {
        // There and back makes a closed polyline of an edge.
        let edges = edges.into_iter().map(|edge| edge.to_vec()).collect();
        self.out = Some(ExcludedArea { holds: Arc::new(holds), edges });
        self
    }

    /// Returns the region with the excluded area.
    pub(crate) fn complete(&self) -> TrimmedRegion<&Inside> {
        TrimmedRegion { out: None, ..self.within(self.bounds) }
    }

    /// Returns the part of the region within other bounds.
    pub(crate) fn within(&self, bounds: [[f64; 2]; 2]) -> TrimmedRegion<&Inside> {
        let (loops, out) = (self.loops.clone(), self.out.clone());
        TrimmedRegion { bounds, loops, inside: &self.inside, out }
    }

    /// Returns `true` if a point lies in the region.
    pub(crate) fn holds(&self, place: ChartPoint) -> bool {
        (self.inside)(place) && self.out.as_ref().is_none_or(|out| !(out.holds)(place))
    }

    /// Returns the corners of all trim loops.
    pub(crate) fn outline(&self) -> impl Iterator<Item = ChartPoint> + '_ {
        self.loops.iter().flatten().copied()
    }

    /// Returns the closed polylines between the region and the rest.
    fn polylines(&self) -> impl Iterator<Item = &Vec<ChartPoint>> {
        self.loops.iter().chain(self.out.iter().flat_map(|out| out.edges.iter()))
    }

    /// Returns the intervals of `across` inside the region on the line `along` = const; none
    /// outside the bounds.
    pub(crate) fn row(&self, along: f64) -> Vec<[f64; 2]> {
        let [[first, last], [low, high]] = self.bounds;
        if !(low..=high).contains(&along) {
            return Vec::new();
        }
        // The crossings with the polylines cut the line into pieces; the middle of each decides.
        let mut cuts = vec![first, last];
        cuts.extend(self.crossings(along).map(|cut| cut.clamp(first, last)));
        cuts.sort_by(f64::total_cmp);
        let mut row: Vec<[f64; 2]> = Vec::new();
        for pair in cuts.windows(2).filter(|pair| pair[1] > pair[0]) {
            if !self.holds([0.5 * (pair[0] + pair[1]), along]) {
                continue;
            }
            match row.last_mut() {
                Some(before) if before[1] >= pair[0] => before[1] = pair[1],
                _ => row.push([pair[0], pair[1]]),
            }
        }
        row
    }

    fn crossings(&self, along: f64) -> impl Iterator<Item = f64> {
        // Half-open test: a corner on the line counts for one of two edges that cross, and for none or both
        // of two that turn back.
        let edges = self.polylines().flat_map(|points| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next)
        });
        edges
            .filter(move |(a, b)| (a[1] <= along) != (b[1] <= along))
            .map(move |(a, b)| a[0] + (b[0] - a[0]) * (along - a[1]) / (b[1] - a[1]))
    }

    /// Returns the edges of the trim loops that meet a box.
    pub(crate) fn edges(&self, range: [[f64; 2]; 2]) -> Vec<[ChartPoint; 2]> {
        let pairs = self.polylines().flat_map(|points| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next)
        });
        pairs.map(|(a, b)| [*a, *b]).filter(|edge| meets(*edge, range)).collect()
    }

    /// Returns the corners of the trim loops within `[low, high]` along.
    fn corners(&self, [low, high]: [f64; 2]) -> impl Iterator<Item = &ChartPoint> {
        self.polylines().flatten().filter(move |p| (low..=high).contains(&p[1]))
    }

    /// Returns the range along that holds the region between two values of across; `None` if there
    /// is none of it.
    pub(crate) fn range_along(&self, across: [f64; 2]) -> Option<[f64; 2]> {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for [a, b] in self.edges([across, everywhere]) {
            let way = b[0] - a[0];
            // Clip the edge to the interval across; its ends and the corners within give the extremes along.
            let at = |across: f64| {
                // Where the edge meets the line; an edge along the line has all of it there.
                let share = if way.abs() > 0.0 { (across - a[0]) / way } else { 0.0 };
                a[1] + share.clamp(0.0, 1.0) * (b[1] - a[1])
            };
            for along in [at(across[0]), at(across[1]), at(a[0].clamp(across[0], across[1]))] {
                range = [range[0].min(along), range[1].max(along)];
            }
            let inside = |p: ChartPoint| (across[0]..=across[1]).contains(&p[0]);
            for p in [a, b].into_iter().filter(|p| inside(*p)) {
                range = [range[0].min(p[1]), range[1].max(p[1])];
            }
        }
        let slab = self.clip(range)?;
        (slab[0] < slab[1]).then_some(slab)
    }

    /// Cuts `slab` to the bounds along; `None` where nothing remains.
    fn clip(&self, slab: [f64; 2]) -> Option<[f64; 2]> {
        let [low, high] = self.bounds[1];
        let slab = [slab[0].max(low), slab[1].min(high)];
        (slab[0] <= slab[1]).then_some(slab)
    }

    /// Returns `true` if any of the region lies in the box `across` x `along`.
    ///
    /// Exact for the polylines: the region meets the box on one of its two lines, or has a corner
    /// inside.
    pub(crate) fn touches(&self, across: [f64; 2], along: [f64; 2]) -> bool {
        let Some(slab) = self.clip(along) else { return false };
        slab.iter()
            .flat_map(|&line| self.row(line))
            .any(|row| row[0] <= across[1] && row[1] >= across[0])
            || self.corners(slab).any(|p| (across[0]..=across[1]).contains(&p[0]))
    }

    /// Returns `true` if any of the region lies on the line `across` = const.
    fn meets_line(&self, across: f64) -> bool {
        let [low, high] = self.bounds[1];
        let edges = self.polylines().flat_map(|points| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next)
        });
        let mut cuts: Vec<f64> = edges
            .filter(|(a, b)| (a[0] <= across) != (b[0] <= across))
            .map(|(a, b)| a[1] + (b[1] - a[1]) * (across - a[0]) / (b[0] - a[0]))
            .map(|cut| cut.clamp(low, high))
            .chain([low, high])
            .collect();
        cuts.sort_by(f64::total_cmp);
        let mut parts = cuts.windows(2).filter(|pair| pair[1] > pair[0]);
        parts.any(|pair| self.holds([across, 0.5 * (pair[0] + pair[1])]))
    }

    /// Returns the first value across, from `from` on, that has some of the region behind it;
    /// `None` if there is none.
    pub(crate) fn next_from(&self, from: f64) -> Option<f64> {
        let [_, last] = self.bounds[0];
        let mut corners: Vec<f64> = self.corners(self.bounds[1]).map(|p| p[0]).collect();
        corners.retain(|across| *across > from && *across < last);
        corners.push(last);
        corners.sort_by(f64::total_cmp);
        // Between two neighbouring corners either all lines meet the region or none does.
        let mut here = from;
        for next in corners {
            // The middle line of a strip between corners stands for all of its lines.
            if next > here && self.meets_line(0.5 * (here + next)) {
                return Some(here);
            }
            here = next;
        }
        None
    }

    /// Returns the first `across`, from `from` on, at which the slab holds some of the region.
    pub(crate) fn first_from(&self, from: f64, slab: [f64; 2]) -> Option<f64> {
        let slab = self.clip(slab)?;
        let rows = slab
            .iter()
            .flat_map(|&line| self.row(line))
            .filter(|row| row[1] > from)
            .map(|row| row[0].max(from));
        let corners = self.corners(slab).map(|p| p[0]).filter(|&across| across >= from);
        rows.chain(corners).min_by(f64::total_cmp)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TrimmedRegion<impl Fn(ChartPoint) -> bool> {
        let inside = |[x, y]: ChartPoint| y > 0.0 && y < x && x < 1.0;
        TrimmedRegion::new(
            [[0.0, 1.0], [0.0, 1.0]],
            vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]],
            inside,
        )
    }

    #[test]
    fn rows_of_a_triangle_by_pencil() {
        let region = triangle();
        assert_eq!(region.row(0.25), [[0.25, 1.0]]);
        assert!(region.row(1.5).is_empty());
        assert_eq!(region.first_from(0.0, [0.5, 0.75]), Some(0.5));
        assert_eq!(region.first_from(0.6, [0.5, 0.75]), Some(0.6));
        assert_eq!(region.first_from(0.0, [1.5, 2.0]), None);
        assert!(!region.touches([0.0, 0.4], [0.5, 0.9]));
        assert!(region.touches([0.0, 0.5], [0.5, 0.9]));
    }

    #[test]
    fn a_corner_between_the_lines_is_found() {
        // A square on its corner; the box holds only its left corner.
        let inside = |[x, y]: ChartPoint| (x - 5.0).abs() + (y - 5.0).abs() < 2.0;
        let square = vec![[3.0, 5.0], [5.0, 3.0], [7.0, 5.0], [5.0, 7.0]];
        let region = TrimmedRegion::new([[0.0, 9.0], [0.0, 9.0]], vec![square], inside);
        assert!(region.touches([0.0, 3.2], [4.5, 5.5]));
        assert_eq!(region.first_from(0.0, [4.5, 5.5]), Some(3.0));
    }

    #[test]
    fn what_is_left_out_is_a_hole_with_an_end() {
        // The unit square without 0.3 to 0.9.
        let region = TrimmedRegion::new([[0.0, 1.0]; 2], Vec::new(), |_: ChartPoint| true);
        let edge = |x: f64| [[x, 0.0], [x, 1.0]];
        let region = region.without(|[x, _]| x > 0.3 && x < 0.9, vec![edge(0.3), edge(0.9)]);
        assert_eq!(region.row(0.5), [[0.0, 0.3], [0.9, 1.0]]);
        assert_eq!(region.next_from(0.1), Some(0.1));
        assert_eq!(region.next_from(0.4), Some(0.9));
        assert_eq!(region.next_from(1.0), None);
        assert_eq!(region.complete().row(0.5), [[0.0, 1.0]]);
        assert!(!region.touches([0.4, 0.6], [0.2, 0.4]));
    }

    #[test]
    fn a_segment_meets_a_box_by_pencil() {
        let unit = [[0.0, 1.0], [0.0, 1.0]];
        assert!(meets([[-1.0, 0.5], [2.0, 0.5]], unit));
        assert!(meets([[-0.5, 0.9], [0.6, 1.9]], [[0.0, 1.0], [0.0, 2.0]]));
        assert!(!meets([[-0.5, 0.9], [0.6, 1.9]], unit));
        assert!(!meets([[2.0, 0.0], [2.0, 1.0]], unit));
        assert!(meets([[0.2, 0.2], [0.3, 0.3]], unit));
    }

    #[test]
    fn a_hole_splits_a_row() {
        let inside = |[x, y]: ChartPoint| !(x > 0.4 && x < 0.6 && y > 0.4 && y < 0.6);
        let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
        let loops = vec![square(0.0, 1.0), square(0.4, 0.6)];
        let region = TrimmedRegion::new([[0.0, 1.0], [0.0, 1.0]], loops, inside);
        assert_eq!(region.row(0.5), [[0.0, 0.4], [0.6, 1.0]]);
        assert_eq!(region.row(0.7), [[0.0, 1.0]]);
        assert_eq!(region.first_from(0.45, [0.45, 0.55]), Some(0.6));
    }
}
