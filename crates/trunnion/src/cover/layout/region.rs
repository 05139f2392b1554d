//! Region of a parameter rectangle inside the trim loops, seen across and along the passes.

use super::edge_index::EdgeIndex;
pub(crate) use super::edge_index::{ChartPoint, clip, meets};
use std::sync::Arc;

/// Area that is excluded from a region: a test for points, and its edges.
#[derive(Clone)]
struct ExcludedArea {
    holds: Arc<dyn Fn(ChartPoint) -> bool + Send + Sync>,
    edges: Arc<EdgeIndex>,
}

/// Trimmed region of a face in local parameters.
#[derive(Clone)]
pub(crate) struct TrimmedRegion<Inside> {
    /// Ranges of across and along that hold the region.
    pub(crate) bounds: [[f64; 2]; 2],
    /// Edges of the trim loops.
    loops: Arc<EdgeIndex>,
    inside: Inside,
    out: Option<ExcludedArea>,
}

impl<Inside: Fn(ChartPoint) -> bool> TrimmedRegion<Inside> {
    /// Trims `bounds` by loops, closed polylines whose last point joins the first.
    pub(crate) fn new(bounds: [[f64; 2]; 2], loops: &[Vec<ChartPoint>], inside: Inside) -> Self {
        Self { bounds, loops: Arc::new(EdgeIndex::new(loops)), inside, out: None }
    }

    /// Excludes the points for which `holds` is true; `edges` bound them.
    pub(crate) fn without(
        mut self,
        holds: impl Fn(ChartPoint) -> bool + Send + Sync + 'static,
        edges: Vec<[ChartPoint; 2]>,
    ) -> Self {
        // There and back makes a closed polyline of an edge.
        let edges: Vec<Vec<ChartPoint>> = edges.into_iter().map(|edge| edge.to_vec()).collect();
        let edges = Arc::new(EdgeIndex::new(&edges));
        self.out = Some(ExcludedArea { holds: Arc::new(holds), edges });
        self
    }

    /// Returns the region with the excluded area.
    pub(crate) fn complete(&self) -> TrimmedRegion<&Inside> {
        TrimmedRegion { out: None, ..self.within(self.bounds) }
    }

    /// Returns the part of the region within other bounds.
    pub(crate) fn within(&self, bounds: [[f64; 2]; 2]) -> TrimmedRegion<&Inside> {
        let (loops, out) = (Arc::clone(&self.loops), self.out.clone());
        TrimmedRegion { bounds, loops, inside: &self.inside, out }
    }

    /// Returns `true` if a point lies in the region.
    pub(crate) fn holds(&self, place: ChartPoint) -> bool {
        (self.inside)(place) && self.out.as_ref().is_none_or(|out| !(out.holds)(place))
    }

    /// Returns the corners of all trim loops.
    pub(crate) fn outline(&self) -> impl Iterator<Item = ChartPoint> + '_ {
        self.loops.corners()
    }

    /// Returns the edges between the region and the rest.
    fn all_edges(&self) -> impl Iterator<Item = &EdgeIndex> {
        std::iter::once(&*self.loops).chain(self.out.iter().map(|out| &*out.edges))
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
        let edges = self.all_edges().flat_map(move |edges| edges.crossing(1, along));
        edges.map(move |[a, b]| a[0] + (b[0] - a[0]) * (along - a[1]) / (b[1] - a[1]))
    }

    /// Returns the edges of the trim loops that meet a box.
    pub(crate) fn edges(&self, range: [[f64; 2]; 2]) -> Vec<[ChartPoint; 2]> {
        self.all_edges().flat_map(|edges| edges.meeting(range)).collect()
    }

    /// Returns the corners of the trim loops within a range along.
    fn corners(&self, range: [f64; 2]) -> impl Iterator<Item = ChartPoint> {
        self.all_edges().flat_map(move |edges| edges.corners_along(range))
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
        let edges = self.all_edges().flat_map(|edges| edges.crossing(0, across));
        let mut cuts: Vec<f64> = edges
            .map(|[a, b]| a[1] + (b[1] - a[1]) * (across - a[0]) / (b[0] - a[0]))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TrimmedRegion<impl Fn(ChartPoint) -> bool> {
        let inside = |[x, y]: ChartPoint| y > 0.0 && y < x && x < 1.0;
        TrimmedRegion::new(
            [[0.0, 1.0], [0.0, 1.0]],
            &[vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]],
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
        let region = TrimmedRegion::new([[0.0, 9.0], [0.0, 9.0]], &[square], inside);
        assert!(region.touches([0.0, 3.2], [4.5, 5.5]));
        assert_eq!(region.first_from(0.0, [4.5, 5.5]), Some(3.0));
    }

    #[test]
    fn what_is_left_out_is_a_hole_with_an_end() {
        // The unit square without 0.3 to 0.9.
        let region = TrimmedRegion::new([[0.0, 1.0]; 2], &[], |_: ChartPoint| true);
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
        let region = TrimmedRegion::new([[0.0, 1.0], [0.0, 1.0]], &loops, inside);
        assert_eq!(region.row(0.5), [[0.0, 0.4], [0.6, 1.0]]);
        assert_eq!(region.row(0.7), [[0.0, 1.0]]);
        assert_eq!(region.first_from(0.45, [0.45, 0.55]), Some(0.6));
    }
}
