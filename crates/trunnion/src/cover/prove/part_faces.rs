//! Faces of a part that the tool keeps off while one of them is cut, and the distance of a tool
//! from them.

use crate::cover::cost::PassCost;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::trims;
use crate::cover::pattern::FeedDirection;
use crate::cover::prove::clearance::ClearanceProof;
use crate::cover::prove::face_cell::{CellShare, FaceCell};
use crate::cover::prove::face_tree::{FaceTree, TreeBranch};
use crate::cover::prove::sweep::PassSweep;
use crate::cover::prove::swept_cell::{SweptCell, SweptPoint};
use crate::cover::prove::time_slab::SpanTimes;
use crate::cutter::Cutter;
use crate::cutter::{ConvexSolid, SignedDistance, ToolBody};
use crate::positioning::PositioningError;
use crate::surface::FaceIndex;
use crate::types::{ToolPose, Uv};
use nalgebra::{Point3, UnitVector3, Vector3};
use rayon::prelude::*;

/// Sizes of cells inside a face and at its trims, as shares of the cutter's radius. Cells at the
/// trims are halved further where it matters which part of them the face has.
pub(crate) const SIZES: [f64; 2] = [0.5, 1.0 / 16.0];

/// Halvings of a cell before its bound is taken as it is: from millimetres to nanometres both ways.
const DEPTH: u32 = 40;

/// Cosine of the largest angle between two faces that continue each other smoothly, so that the
/// tool may be raised: eight degrees.
const BELOW: f64 = 0.99;

/// Faces of a part as trees, for distance queries.
pub(crate) struct PartFaces<'a> {
    /// Chart of all trees.
    chart: Chart,
    faces: Vec<(&'a FaceIndex, FaceTree)>,
}

/// Point of a face that comes nearest to a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NearestPoint {
    /// Signed distance from the solid \[mm\].
    pub(crate) distance: f64,
    /// Index of the face.
    pub(crate) face: usize,
    pub(crate) point: Point3<f64>,
}

/// Limits of a distance query.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearestQuery {
    /// Points farther off than this do not count \[mm\].
    pub(crate) within: f64,
    /// Points may be missed that are nearer than that by less than this \[mm\]: a tool that just touches would be
    /// searched for ever.
    pub(crate) slack: f64,
    /// Precision: points are not searched that are nearer than the known one by less than this
    /// \[mm\].
    pub(crate) precision: f64,
    /// The search ends at the first point nearer than this \[mm\].
    pub(crate) enough: f64,
}

impl NearestQuery {
    /// Returns the query for any point nearer than `within`, to a precision \[mm\].
    pub(crate) fn any(within: f64, precision: f64) -> Self {
        Self { within, slack: precision, precision, enough: within }
    }
}

impl<'a> PartFaces<'a> {
    pub(crate) fn new(faces: impl Iterator<Item = &'a FaceIndex>, cutter: &Cutter) -> Self {
        let faces: Vec<&FaceIndex> = faces.collect();
        let sizes = SIZES.map(|share| share * cutter.radius());
        let chart = Chart::straight(FeedDirection::V);
        let ready = |face: &'a FaceIndex| {
            let region = trims::guarded(face, &chart);
            (face, FaceTree::adaptive(face, &chart, &region, sizes))
        };
        let faces = faces.into_par_iter().map(ready).collect();
        Self { chart, faces }
    }

    /// Returns the number of a face.
    pub(crate) fn number(&self, face: usize) -> usize {
        self.faces.get(face).map_or(0, |(face, _)| face.face().number)
    }

    /// Finds the point of all faces but one that comes nearest to a solid.
    pub(crate) fn nearest(
        &self,
        solid: &ConvexSolid,
        pose: &ToolPose,
        without: Option<usize>,
        query: NearestQuery,
    ) -> Option<NearestPoint> {
        let mut found: Option<NearestPoint> = None;
        for (index, (face, tree)) in self.faces.iter().enumerate() {
            if Some(index) != without {
                let search = NearestSearch { face, tree, index, solid, pose, query };
                search.run(&mut found);
            }
            if found.is_some_and(|near| near.distance < query.enough) {
                break;
            }
        }
        found
    }
}

impl PartFaces<'_> {
    /// Finds the point of one face that comes nearest to a solid.
    pub(crate) fn nearest_of(
        &self,
        index: usize,
        solid: &ConvexSolid,
        pose: &ToolPose,
        query: NearestQuery,
    ) -> Option<NearestPoint> {
        let (face, tree) = self.faces.get(index)?;
        let mut found = None;
        NearestSearch { face, tree, index, solid, pose, query }.run(&mut found);
        found
    }
}

/// Search over one face for one solid.
struct NearestSearch<'a> {
    face: &'a FaceIndex,
    tree: &'a FaceTree,
    index: usize,
    solid: &'a ConvexSolid,
    pose: &'a ToolPose,
    query: NearestQuery,
}

impl NearestSearch<'_> {
    /// Returns the distance from which on points do not matter.
    fn limit(&self, found: Option<&NearestPoint>) -> f64 {
        let NearestQuery { within, slack, precision, .. } = self.query;
        found.map_or(within - slack, |near| near.distance - precision)
    }

    /// Returns a lower bound of the distance of a node. The distance is convex: over a ball it lies above the tangent plane
    /// at its centre.
    fn bound(&self, node: usize) -> f64 {
        let node = &self.tree.nodes[node];
        let gap = self.solid.gap(&node.centre, self.pose);
        gap.distance - node.along(&gap.gradient)
    }

    /// Searches the tree, the nearer half first.
    fn run(&self, found: &mut Option<NearestPoint>) {
        let Some(root) = self.tree.nodes.len().checked_sub(1) else { return };
        let (bound, limit) = (self.bound(root), self.limit(found.as_ref()));
        if bound >= limit || self.is_beyond_outline(limit) {
            return;
        }
        let mut waiting = vec![(root, bound)];
        while let Some((index, bound)) = waiting.pop() {
            let limit = self.limit(found.as_ref());
            if bound >= limit {
                continue;
            }
            match self.tree.nodes[index].below {
                TreeBranch::Halves(halves) => {
                    let [a, b] = halves.map(|half| (half, self.bound(half)));
                    // The nearer half is popped first.
                    let both = if a.1 < b.1 { [b, a] } else { [a, b] };
                    waiting.extend(both.into_iter().filter(|(_, bound)| *bound < limit));
                }
                TreeBranch::Leaf(cell) => self.cell(cell, found),
            }
            if found.is_some_and(|near| near.distance < self.query.enough) {
                return;
            }
        }
    }

    /// Returns `true` if a plane shows the whole of a plane face to be at least `limit` from the solid.
    fn is_beyond_outline(&self, limit: f64) -> bool {
        let Some(hull) = &self.tree.hull else { return false };
        let beyond = |normal: &Vector3<f64>| {
            let away = |p: &Point3<f64>| self.solid.plane(p, self.pose, *normal).distance;
            let limit = limit + hull.beyond(normal);
            hull.points.iter().all(|p| away(p) >= limit)
        };
        hull.normals(&self.pose.axis).iter().any(beyond)
    }

    /// Searches a cell. Over it the distance lies above the tangent plane at the middle, which is
    /// least at a corner, but for the bows of the cell.
    fn cell(&self, index: usize, found: &mut Option<NearestPoint>) {
        let at = |[u, v]: [f64; 2]| self.face.face().point(u, v);
        let holds = |[u, v]: [f64; 2]| self.face.face().contains(u, v);
        let mut waiting = vec![(self.tree.cells[index], CellShare::Cut(false), 0)];
        while let Some((cell, before, depth)) = waiting.pop() {
            // Only a cell that a trim may cut is compared with the trims again; its halves inherit a known
            // share.
            let share = match before {
                CellShare::Cut(_) => self.tree.share(index, &cell, holds),
                known => known,
            };
            if share == CellShare::None {
                continue;
            }
            let point = cell.centre();
            let gap = self.solid.gap(&point, self.pose);
            let known = found.map_or(self.query.within, |near| near.distance);
            // Upper bound: some point of the face is within that distance of the middle.
            let some = cell.some_within(share).map(|away| gap.distance + away);
            if let Some(distance) = some.filter(|distance| *distance < known) {
                *found = Some(NearestPoint { distance, face: self.index, point });
            }
            // Lower bound: a plane below the distance is least at a corner, less the sags in both directions.
            let sags = [cell.sag(0), cell.sag(1)];
            let (sag, corners) = (sags[0] + sags[1], cell.corners());
            let enough = |found: &Option<NearestPoint>| {
                found.is_some_and(|near| near.distance < self.query.enough)
            };
            if enough(found) || gap.least_over(&point, &corners) - sag >= self.limit(found.as_ref())
            {
                continue;
            }
            let near = SweptCell::new(&cell, |_| Vector3::zeros()).nearest(self.solid, self.pose);
            // Upper bound of a cell that is all on the face: the image is as near as that point, but for the sags.
            if share == CellShare::Whole {
                let known = found.map_or(self.query.within, |near| near.distance);
                let distance = near.gap.distance + sag;
                if distance < known {
                    *found = Some(NearestPoint { distance, face: self.index, point: near.point });
                }
            }
            let limit = self.limit(found.as_ref());
            let searched = SearchedCell { index, cell: &cell, share, gap: &gap, near: &near, sag };
            if enough(found) || depth == DEPTH || self.is_beyond(&searched, limit) {
                continue;
            }
            // Halve the edge along which the bound loses more: of a whole cell by the bows and by what the search for the
            // nearest point left, unless its twist costs more than both.
            let slopes = [0, 1].map(|k| 0.5 * gap.gradient.dot(&cell.across_edges(k)).abs());
            let [left, over] =
                [near.left[0] + near.left[1], near.gap.least_over(&near.point, &corners)];
            let is_tight = 2.0 * (sag + left) >= near.gap.distance - over + sag;
            let lost = if share == CellShare::Whole && is_tight {
                [near.left[0], near.left[1]]
            } else {
                slopes
            };
            let losses = [0, 1].map(|k| sags[k] + lost[k]);
            let halves = cell.halves(cell.side(losses, share), &at);
            waiting.extend(halves.map(|half| (half, share, depth + 1)));
        }
    }
}

/// Cell under search.
struct SearchedCell<'a> {
    /// Index of the cell of the tree that it is part of.
    index: usize,
    cell: &'a FaceCell,
    share: CellShare,
    /// Distance of its middle from the solid.
    gap: &'a SignedDistance,
    /// Point of its flat image that was found nearest to the solid.
    near: &'a SweptPoint,
    /// Deviation of its image from the hull of its corners \[mm\].
    sag: f64,
}

impl NearestSearch<'_> {
    /// Returns `true` if a plane shows all that the face has of a cell to be at least `limit` from the solid.
    ///
    /// A plane is least at an extreme point of what the face has of the cell, less the sags in both directions. The
    /// tangent plane at the nearest point is tried first, then those along the normal of the cell and the end of the
    /// tool, which often bound more sharply where the solid has an edge.
    fn is_beyond(&self, part: &SearchedCell<'_>, limit: f64) -> bool {
        let SearchedCell { index, cell, share, gap, near, sag } = *part;
        let (middle, corners) = (cell.centre(), cell.corners());
        if near.gap.least_over(&near.point, &corners) - sag >= limit {
            return true;
        }
        let below = -self.pose.axis.into_inner();
        let sides = cell.normal().into_iter().flat_map(|n| [n, -n]).chain([below]);
        let mut planes = sides.map(|n| self.solid.plane(&middle, self.pose, n));
        let kept =
            matches!(share, CellShare::Cut(_)).then(|| self.tree.kept(index, cell)).flatten();
        let Some(kept) = kept else {
            return planes.any(|plane| plane.least_over(&middle, &corners) - sag >= limit);
        };
        let touching = [(middle, *gap), (near.point, near.gap)];
        touching
            .into_iter()
            .chain(planes.map(|plane| (middle, plane)))
            .any(|(at, plane)| plane.least_over(&at, kept.points()) - sag - kept.twist >= limit)
    }
}

/// Check of cutter locations: all faces but the one that is cut, the tool that keeps off them, and
/// the reach of the machine.
#[derive(Clone, Copy)]
pub(crate) struct KeepOff<'a> {
    pub(crate) cost: &'a dyn PassCost,
    pub(crate) part_faces: &'a PartFaces<'a>,
    /// Index of the face that is cut.
    pub(crate) own: usize,
    pub(crate) tool: &'a ToolBody,
    /// Distance that the tool keeps from every point \[mm\], to this precision \[mm\].
    pub(crate) least: f64,
    pub(crate) precision: f64,
}

/// Precision of questions whose answer is checked later, over that of the check.
const ROUGH: f64 = 10.0;

impl KeepOff<'_> {
    /// Returns the check at a coarser precision: a pose that it passes may go in by that much. A tool that touches the face
    /// that is cut is searched there down to cells whose size grows with the square root of the precision.
    pub(crate) fn rough(&self) -> Self {
        Self { precision: ROUGH * self.precision, ..*self }
    }

    /// Checks that the machine reaches a pose, and that the tool keeps off all other faces.
    ///
    /// # Errors
    ///
    /// `OutOfReach` or `Neighbour`, at parameters `uv` of the face that is cut.
    pub(crate) fn check(&self, pose: &ToolPose, uv: Uv) -> Result<(), PositioningError> {
        // The machine first: it costs least to find.
        if !self.cost.reaches(pose) {
            return Err(PositioningError::OutOfReach { uv });
        }
        let within = self.least - self.precision;
        let query = NearestQuery::any(within, self.precision);
        for solid in self.tool.solids() {
            if let Some(near) = self.part_faces.nearest(solid, pose, Some(self.own), query) {
                let (face, depth) = (self.part_faces.number(near.face), self.least - near.distance);
                return Err(PositioningError::Neighbour { uv, face, depth });
            }
        }
        Ok(())
    }

    /// Checks that the tool keeps off the face that is cut, as near to it as it touches.
    ///
    /// # Errors
    ///
    /// `Body`, at parameters `uv` of that face.
    pub(crate) fn check_own(&self, pose: &ToolPose, uv: Uv) -> Result<(), PositioningError> {
        let within = self.least - self.precision;
        let query = NearestQuery::any(within, self.precision);
        for solid in self.tool.solids() {
            if let Some(near) = self.part_faces.nearest_of(self.own, solid, pose, query) {
                let height = (near.point - pose.tip).dot(&pose.axis);
                let clearance = near.distance - self.least;
                return Err(PositioningError::Body { uv, height, clearance });
            }
        }
        Ok(())
    }

    /// Returns `true` if the point of another face that a pose goes into lies right below the tool,
    /// seen along `normal`.
    pub(crate) fn is_right_below(&self, pose: &ToolPose, normal: &Vector3<f64>) -> bool {
        let within = self.least - self.precision;
        let query = NearestQuery::any(within, self.precision);
        let below = |solid: &ConvexSolid| {
            let near = self.part_faces.nearest(solid, pose, Some(self.own), query)?;
            Some(solid.gap(&near.point, pose).gradient.dot(normal) <= -BELOW)
        };
        self.tool.solids().find_map(below).unwrap_or(false)
    }

    /// Returns the face that is cut.
    pub(crate) fn own_face(&self) -> Option<&FaceIndex> {
        self.part_faces.faces.get(self.own).map(|(face, _)| *face)
    }

    /// Returns the normal of the nearest other face within a distance \[mm\] of a point, there where it is nearest.
    pub(crate) fn neighbour_normal(
        &self,
        point: &Point3<f64>,
        within: f64,
    ) -> Option<UnitVector3<f64>> {
        let ball = ConvexSolid::ball(self.precision);
        let pose = ToolPose { tip: *point, axis: Vector3::z_axis() };
        let (slack, precision) = (0.0, self.precision);
        let query = NearestQuery { within, slack, precision, enough: f64::NEG_INFINITY };
        let near = self.part_faces.nearest(&ball, &pose, Some(self.own), query)?;
        let (face, _) = self.part_faces.faces.get(near.face)?;
        let foot = face.closest(&near.point).ok()?;
        face.face().normal(foot.uv.u, foot.uv.v)
    }

    /// Returns `true` if a pose goes into any face, including the one that is cut.
    pub(crate) fn hits_any(&self, pose: &ToolPose) -> bool {
        let within = self.least - self.precision;
        let query = NearestQuery::any(within, self.precision);
        self.tool.solids().any(|solid| self.part_faces.nearest(solid, pose, None, query).is_some())
    }

    /// Returns the least of [`ClearanceProof::least`] over every other face.
    pub(crate) fn clearance(
        &self,
        sweep: &PassSweep,
        span: usize,
        times: SpanTimes,
        target: f64,
    ) -> f64 {
        let others = (0..self.part_faces.faces.len()).filter(|index| *index != self.own);
        // The target is the same for every face; the least of all bounds counts.
        others.fold(target, |least, index| {
            least.min(self.clearance_of(index, sweep, span, times, target))
        })
    }

    /// Returns the clearance from the face that is cut, as [`ClearanceProof::least`] does: by `coarse`, whose cells reach over
    /// the edges of the face, and where that is too little, by the face within its edges. The shank may pass close above
    /// one of them.
    pub(crate) fn own_clearance(
        &self,
        coarse: &ClearanceProof<'_>,
        sweep: &PassSweep,
        span: usize,
        times: SpanTimes,
    ) -> f64 {
        let least = coarse.least(sweep, span, times);
        if least >= coarse.target - coarse.precision {
            return least;
        }
        self.clearance_of(self.own, sweep, span, times, coarse.target)
    }

    fn clearance_of(
        &self,
        index: usize,
        sweep: &PassSweep,
        span: usize,
        times: SpanTimes,
        target: f64,
    ) -> f64 {
        let Some((face, tree)) = self.part_faces.faces.get(index) else { return target };
        let (tool, precision, chart) = (self.tool, self.precision, &self.part_faces.chart);
        ClearanceProof { face, chart, tree, tool, target, precision }.least(sweep, span, times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::cost::LengthCost;
    use crate::cover::layout::trims::region;
    use crate::cutter::CutterSpec;
    use crate::surface::{Face, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
    use crate::types::{PoseCurve, Station};
    use std::f64::consts::FRAC_1_SQRT_2;

    /// A triangle of 20 mm in the plane z = 0.
    fn triangle() -> FaceIndex {
        let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
        let border =
            TrimCurve::polyline(&[[0.0, 0.0], [20.0, 0.0], [0.0, 20.0], [0.0, 0.0]]).unwrap();
        let trims = vec![TrimLoop::new(vec![border], [None, None], 1e-9).unwrap()];
        let face = Face::new(1, Surface::Plane(PlaneSurface { frame }), trims).unwrap();
        FaceIndex::new(face).unwrap()
    }

    /// Tools go along the long edge, deeper than the face and `beside` it \[mm\]; the cells with which passes are searched
    /// count whole and reach beyond the edge.
    #[test]
    fn a_tool_below_the_edge_of_the_face_that_it_cuts_keeps_off_what_the_face_has() {
        let (face, cutter) = (triangle(), Cutter::new(CutterSpec::of_radii(2.0, 1.0)).unwrap());
        let (tool, cost) = (ToolBody::new(&cutter), LengthCost { link: 1.0 });
        let part_faces = PartFaces::new(std::iter::once(&face), &cutter);
        let (precision, target) = (1e-5, 0.02);
        let keep_off = KeepOff {
            cost: &cost,
            part_faces: &part_faces,
            own: 0,
            tool: &tool,
            least: 0.0,
            precision,
        };
        let chart = Chart::straight(FeedDirection::U);
        let trimmed = region(&face, &chart);
        let tree = FaceTree::new(&face, &chart, &trimmed, 0.5);
        let (face, chart, tree, tool) = (&face, &chart, &tree, &tool);
        let coarse = ClearanceProof { face, chart, tree, tool, target, precision };
        let clearances = |beside: f64| {
            let off = 10.0 + FRAC_1_SQRT_2 * (cutter.radius() + beside);
            let at = |x: f64| {
                let tip = Point3::new(off + x, off - x, -2.0);
                Station { pose: ToolPose { tip, axis: Vector3::z_axis() }, contact: tip }
            };
            let curve = PoseCurve::through(&[at(-1.0), at(0.0), at(1.0)], 3.0);
            let (sweep, times) = (PassSweep::of(curve, 3.0), SpanTimes::Slabs(1));
            let own = keep_off.own_clearance(&coarse, &sweep, 0, times);
            [own, coarse.least(&sweep, 0, times)]
        };
        let [own, whole] = clearances(0.03);
        assert!(own >= target - precision && whole < target - precision, "{own} {whole}");
        for beside in [0.01, -0.05] {
            let [own, _] = clearances(beside);
            assert!(own < target - precision, "{beside}: {own}");
        }
    }
}
