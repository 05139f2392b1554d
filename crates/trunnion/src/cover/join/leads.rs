//! Leads: straight moves from the end of a pass up to the height of the links.

use super::request::{LeadKind, LinkOptions, LinkRequest};
use crate::cover::layout::chart::Chart;
use crate::cover::layout::trims::guarded;
use crate::cover::options::lever;
use crate::cover::pattern::FeedDirection;
use crate::cover::prove::clearance::ClearanceProof;
use crate::cover::prove::face_tree::FaceTree;
use crate::cover::prove::part_faces::SIZES;
use crate::cover::prove::sweep::PassSweep;
use crate::cover::prove::time_slab::SpanTimes;
use crate::cutter::Cutter;
use crate::cutter::ToolBody;
use crate::surface::FaceIndex;
use crate::types::{Pass, PoseCurve, Station, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};

/// Least climb of a lead per mm of its length. A flatter lead would run over the part for more than ten times the
/// height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Precision to which gouges of a lead are found, as a share of the gouge tolerance.
pub(crate) const PRECISION: f64 = 0.1;

/// Precision of a closer proof, over the usual one.
const CLOSER: f64 = 0.1;

/// Passes, faces and tool, ready for leads and links.
pub(crate) struct LinkPlanner<'a> {
    pub(crate) faces: &'a [FaceIndex],
    pub(crate) trees: Vec<FaceTree>,
    pub(crate) chart: Chart,
    pub(crate) tool: ToolBody,
    pub(crate) lever: f64,
    cutter: &'a Cutter,
    pub(crate) options: &'a LinkOptions,
}

/// End of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PassEnd {
    First,
    Last,
}

/// Level at which a lead ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ClearLevel {
    /// Above the plane square to `up`.
    Plane,
    /// Above the part as seen along the tool axis.
    Axis,
}

/// Proof that a lead does not gouge.
#[derive(Debug, Clone, Copy)]
struct LeadProof {
    /// Depth to which the tool may go into a face \[mm\].
    allowed: f64,
    /// Precision of the bounds \[mm\].
    precision: f64,
}

/// Straight part of a lead.
struct LeadStep {
    direction: UnitVector3<f64>,
    /// \[mm\].
    length: f64,
}

impl<'a> LinkPlanner<'a> {
    /// Divides the faces into cells.
    pub(crate) fn new(request: &LinkRequest<'a>) -> Self {
        let LinkRequest { faces, cutter, options, .. } = *request;
        let chart = Chart::straight(FeedDirection::V);
        let trees = faces.iter().map(|face| tree(face, &chart, cutter)).collect();
        let (tool, lever) = (ToolBody::new(cutter), lever(cutter));
        Self { faces, trees, chart, tool, lever, cutter, options }
    }
}

impl LinkPlanner<'_> {
    /// Returns the end of the shortest possible lead from `end`, without a check for gouges.
    pub(crate) fn shortest(&self, end: &Station) -> Option<Station> {
        let step = self.ups(end, ClearLevel::Plane).next()?;
        Some(moved(end, &step.direction.scale(step.length)))
    }

    /// Plans a lead: stations from an end of a pass up to the height of the links.
    ///
    /// # Errors
    ///
    /// The greatest depth of a gouge where every lead gouges.
    pub(crate) fn lead(
        &self,
        pass: &Pass,
        end: PassEnd,
        level: ClearLevel,
    ) -> Result<Vec<Station>, f64> {
        let pair = match (end, pass.stations.as_slice()) {
            (PassEnd::First, [end, before, ..]) | (PassEnd::Last, [.., before, end]) => {
                [*end, *before]
            }
            _ => return Ok(Vec::new()),
        };
        let [end, before] = pair;
        // Candidates by preference: first those that leave along the pass, if requested, then the straight
        // ones.
        let mut leads: Vec<Vec<LeadStep>> = Vec::new();
        if let LeadKind::Tangent { length } = self.options.lead
            && let Some(direction) = Unit::try_new(end.pose.tip - before.pose.tip, 0.0)
        {
            let tangent = || LeadStep { direction, length };
            leads.extend(self.ups(&end, level).map(|up| vec![tangent(), up]));
        }
        leads.extend(self.ups(&end, level).map(|up| vec![up]));
        // The end of a pass may keep no more than leads have to: a bound below that by its precision says nothing then, and
        // a closer one decides.
        let rough = LeadProof { allowed: self.options.gouge, precision: self.precision() };
        let precision = CLOSER * self.precision();
        let close = LeadProof { allowed: self.options.gouge + precision, precision };
        self.first_clear(end, &leads, rough).or_else(|_| self.first_clear(end, &leads, close))
    }

    /// Returns the stations of the first lead that is proven not to gouge.
    ///
    /// # Errors
    ///
    /// The greatest depth of a gouge where every lead gouges.
    fn first_clear(
        &self,
        end: Station,
        leads: &[Vec<LeadStep>],
        proof: LeadProof,
    ) -> Result<Vec<Station>, f64> {
        let mut deepest = 0.0;
        for lead in leads {
            match self.follow(end, lead, proof) {
                Ok(stations) => return Ok(stations),
                Err(depth) => deepest = f64::max(deepest, depth),
            }
        }
        Err(deepest)
    }

    /// Returns the usual precision of proofs of leads and hops \[mm\].
    fn precision(&self) -> f64 {
        PRECISION * self.options.gouge.abs()
    }

    /// Returns candidate steps up to the height of the links: along the tool axis, halfway towards `up`, and along
    /// `up`. If the axis itself counts as up, the last two are inclined away from the part instead.
    fn ups(&self, end: &Station, level: ClearLevel) -> impl Iterator<Item = LeadStep> {
        let (axis, tip) = (end.pose.axis, end.pose.tip);
        let radius = self.cutter.radius();
        let (up, aside, above) = match level {
            // With its tip a radius above the plane, the cutting end is above it at any inclination.
            ClearLevel::Plane => {
                let up = self.options.up;
                (up, up.into_inner(), self.height(&up) + radius)
            }
            ClearLevel::Axis => (axis, self.outwards(&tip), self.height(&axis)),
        };
        let height = above - tip.coords.dot(&up);
        [0.0, 0.5, 1.0].into_iter().filter_map(move |share| {
            let direction = Unit::try_new(axis.lerp(&aside, share), 0.0)?;
            let climb = direction.dot(&up);
            // Even from above the level, a lead is at least a radius long.
            // Along a direction that climbs by `climb` per mm.
            let length = (height / climb).max(radius);
            (climb >= LEAST_CLIMB).then_some(LeadStep { direction, length })
        })
    }

    /// Returns the unit vector away from the middle of part and stock.
    fn outwards(&self, tip: &Point3<f64>) -> Vector3<f64> {
        let corners = || self.options.boxes.iter().flatten().map(|corner| corner.coords);
        let low = corners().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(&b));
        let high = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
        let out = tip.coords - (low + high) * 0.5;
        out.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::zeros)
    }

    /// Returns the stations at the corners of a lead, or the depth of its gouge.
    fn follow(
        &self,
        from: Station,
        lead: &[LeadStep],
        proof: LeadProof,
    ) -> Result<Vec<Station>, f64> {
        let mut stations = vec![from];
        let mut here = from;
        for LeadStep { direction, length } in lead {
            let depth = self.depth(&here.pose, direction, *length, proof);
            if depth > proof.allowed {
                return Err(depth);
            }
            here = moved(&here, &(direction.scale(*length)));
            stations.push(here);
        }
        Ok(stations)
    }

    /// Returns the depth to which the tool goes into a face on a straight move; a lower bound of it where that is
    /// more than is allowed.
    fn depth(
        &self,
        from: &ToolPose,
        direction: &UnitVector3<f64>,
        length: f64,
        proof: LeadProof,
    ) -> f64 {
        let start = Station { pose: *from, contact: from.tip };
        let end = moved(&start, &direction.scale(length));
        let sweep = PassSweep::of(PoseCurve::through(&[start, end], self.lever), self.lever);
        let LeadProof { allowed, precision } = proof;
        self.depth_to(&sweep, 0, precision - allowed, precision)
    }

    /// Returns the depth to which the tool goes into a face during a span; a lower bound of it where the tool does not
    /// keep `target`.
    pub(crate) fn depth_in(&self, sweep: &PassSweep, span: usize, target: f64) -> f64 {
        self.depth_to(sweep, span, target, self.precision())
    }

    fn depth_to(&self, sweep: &PassSweep, span: usize, target: f64, precision: f64) -> f64 {
        let of = |(face, tree): (&FaceIndex, &FaceTree)| {
            let tool = &self.tool;
            let chart = &self.chart;
            let clearance = ClearanceProof { face, chart, tree, tool, target, precision };
            -clearance.least(sweep, span, SpanTimes::Slabs(1))
        };
        self.faces.iter().zip(&self.trees).map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the height along `normal` from which on nothing comes nearer to part and stock than the
    /// clearance \[mm\].
    pub(crate) fn height(&self, normal: &UnitVector3<f64>) -> f64 {
        height(&self.options.boxes, normal) + self.options.clearance
    }
}

/// Returns the height of boxes along `normal` \[mm\]: that of their highest corner.
pub(crate) fn height(boxes: &[[Point3<f64>; 2]], normal: &UnitVector3<f64>) -> f64 {
    let corner = |[low, high]: &[Point3<f64>; 2]| {
        // Support function of a box: coordinate by coordinate the end that lies higher.
        (0..3).map(|k| (low[k] * normal[k]).max(high[k] * normal[k])).sum::<f64>()
    };
    boxes.iter().map(corner).fold(f64::NEG_INFINITY, f64::max)
}

/// Divides a face into cells for the checks of leads.
fn tree(face: &FaceIndex, chart: &Chart, cutter: &Cutter) -> FaceTree {
    let region = guarded(face, chart);
    let sizes = SIZES.map(|share| share * cutter.radius());
    FaceTree::adaptive(face, chart, &region, sizes)
}

/// Returns a station moved by a vector, with the same tool axis.
pub(crate) fn moved(station: &Station, by: &Vector3<f64>) -> Station {
    let pose = ToolPose { tip: station.pose.tip + by, axis: station.pose.axis };
    Station { pose, contact: station.contact + by }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_of_boxes_by_pencil() {
        let boxes = [
            [Point3::new(-1.0, -2.0, 0.0), Point3::new(1.0, 2.0, 5.0)],
            [Point3::new(3.0, 0.0, 0.0), Point3::new(4.0, 1.0, 1.0)],
        ];
        assert!((height(&boxes, &Vector3::z_axis()) - 5.0).abs() < 1e-15);
        assert!((height(&boxes, &Vector3::x_axis()) - 4.0).abs() < 1e-15);
        let lean = Unit::new_normalize(Vector3::new(0.0, 3.0, 4.0));
        assert!((height(&boxes, &lean) - (2.0 * 0.6 + 5.0 * 0.8)).abs() < 1e-15);
    }
}
