//! Passes over a chain of points of a face, each inclined as the tool fits there.

use crate::cover::layout::region::ChartPoint;
use crate::cover::options::lever;
use crate::cover::place::context::FaceContext;
use crate::cover::place::spots::Spot;
use crate::cover::place::tool_fit::{ContactPoint, PoseOrder, PoseSearch, fitting_pose_near};
use crate::cover::prove::sweep::PassSweep;
use crate::math::angle::angle_between;
use crate::positioning::ToleranceBand;
use crate::types::{Pass, Station, ToolPose, Uv};

/// Turn of the tool from spot to spot at which a pass ends \[rad\].
const TURN: f64 = 0.3;

/// Length of a pass that touches a single spot, in widths of a narrow strip.
const SINGLE: f64 = 0.1;

/// Number of times that a station is added in the middle of spans that come too deep.
const DENSER: u32 = 3;

/// Number of times that a pass is cut at spans that come too deep all the same: the curve through what stays is another.
const CUTS: u32 = 4;

/// Share of the band by which the tool is raised at most.
const RAISED: f64 = 0.5;

/// Returns the height by which the tool may be raised \[mm\].
pub(crate) fn room<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
) -> f64 {
    let ToleranceBand { lower, upper } = context.options.band;
    RAISED * (upper - lower)
}

/// A pass over spots, with its curve.
pub(crate) struct SpotPass {
    pub(crate) pass: Pass,
    pub(crate) sweep: PassSweep,
}

/// Station with the parameters of its contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpotStation {
    pub(crate) uv: [f64; 2],
    pub(crate) station: Station,
}

impl SpotStation {
    /// Returns the angle by which the tool turns from one to the other \[rad\].
    fn turn_to(&self, other: &Self) -> f64 {
        angle_between(&self.station.pose.axis, &other.station.pose.axis)
    }
}

/// Splits stations to runs between which the tool is lifted: where it does not fit, or has to turn.
pub(crate) fn split(stations: &[Option<SpotStation>]) -> Vec<Vec<SpotStation>> {
    let turns = |a: &Option<SpotStation>, b: &Option<SpotStation>| match (a, b) {
        (Some(a), Some(b)) => a.turn_to(b) > TURN,
        _ => true,
    };
    let runs = stations.chunk_by(|a, b| !turns(a, b));
    let run = |run: &[Option<SpotStation>]| run.iter().copied().flatten().collect::<Vec<_>>();
    runs.map(run).filter(|run| !run.is_empty()).collect()
}

/// Planner of the passes over a chain of spots.
pub(crate) struct ChainPlanner<'a, 'b, Inside> {
    pub(crate) context: &'a FaceContext<'b, Inside>,
    pub(crate) order: PoseOrder,
}

/// Stations of a pass, and the spans between them that come too deep.
struct BrokenChain {
    stations: Vec<SpotStation>,
    /// In order.
    spans: Vec<usize>,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> ChainPlanner<'_, '_, Inside> {
    /// Returns the search of a pose after another.
    fn search(&self, before: Option<ToolPose>) -> PoseSearch {
        PoseSearch { room: room(self.context), before, order: self.order }
    }

    /// Returns the stations over a chain of spots; `None` where the tool does not fit.
    pub(crate) fn stations(&self, chain: &[Spot]) -> Vec<Option<SpotStation>> {
        let mut before: Option<SpotStation> = None;
        let station = |spot: &Spot| {
            before = self.station(spot.uv, before.map(|spot| spot.station.pose));
            before
        };
        chain.iter().map(station).collect()
    }

    /// Returns the station at a point of the face, after a pose; `None` where the tool does not fit.
    pub(crate) fn station(&self, uv: [f64; 2], before: Option<ToolPose>) -> Option<SpotStation> {
        let contact = ContactPoint::new(self.context.face, uv)?;
        let (keep_off, cutter) = (self.context.keep_off().rough(), self.context.setup.cutter);
        let pose = fitting_pose_near(&keep_off, &contact, cutter, self.search(before))?;
        Some(SpotStation { uv, station: Station { pose, contact: contact.point } })
    }

    /// Returns the pass through stations if the tool keeps off all faces on it, with more stations between them where that
    /// helps, or else passes through the parts of it that keep off.
    pub(crate) fn proven_passes(&self, stations: Vec<SpotStation>) -> Vec<SpotPass> {
        let mut passes = Vec::new();
        self.prove(stations, CUTS, &mut passes);
        passes
    }

    /// Adds the pass through stations, or passes through its parts.
    fn prove(&self, mut stations: Vec<SpotStation>, cuts: u32, passes: &mut Vec<SpotPass>) {
        if let [single] = *stations {
            stations.extend(self.beside(single));
        }
        if stations.len() < 2 {
            return;
        }
        // Between two stations there is nothing to cut.
        let cuts = if stations.len() == 2 { 0 } else { cuts };
        match self.refined(stations, DENSER) {
            Ok(pass) => passes.push(pass),
            Err(BrokenChain { stations, spans }) if cuts > 0 => {
                let mut start = 0;
                for end in spans.into_iter().chain([stations.len() - 1]) {
                    self.prove(stations[start..=end].to_vec(), cuts - 1, passes);
                    start = end + 1;
                }
            }
            Err(_) => {}
        }
    }

    /// Adds stations in spans that come too deep, a number of times. On a face that bulges, the tool cuts the corner between
    /// stations far apart.
    fn refined(&self, mut stations: Vec<SpotStation>, times: u32) -> Result<SpotPass, BrokenChain> {
        let poses: Vec<Station> = stations.iter().map(|spot| spot.station).collect();
        let sweep = PassSweep::through(&poses, lever(self.context.setup.cutter));
        let spans = self.context.spans_too_near(&sweep);
        if spans.is_empty() {
            return Ok(self.pass(&stations, sweep));
        }
        if times == 0 {
            return Err(BrokenChain { stations, spans });
        }
        let mut hopeless = Vec::new();
        // From the last on, so that the spans before keep their numbers.
        for span in spans.into_iter().rev() {
            match self.middle(&stations[span], &stations[span + 1]) {
                Some(middle) => {
                    stations.insert(span + 1, middle);
                    for later in &mut hopeless {
                        *later += 1;
                    }
                }
                None => hopeless.insert(0, span),
            }
        }
        if !hopeless.is_empty() {
            return Err(BrokenChain { stations, spans: hopeless });
        }
        self.refined(stations, times - 1)
    }

    /// Makes the pass through stations.
    fn pass(&self, stations: &[SpotStation], sweep: PassSweep) -> SpotPass {
        let pass = Pass {
            face: self.context.face.face().number,
            stations: stations.iter().map(|spot| spot.station).collect(),
            widths: vec![self.context.narrow(); stations.len()],
            track: stations.iter().map(|spot| Uv::from(spot.uv)).collect(),
        };
        SpotPass { pass, sweep }
    }

    /// Returns a station in the middle between two; `None` where the tool does not fit there, or has to turn.
    fn middle(&self, a: &SpotStation, b: &SpotStation) -> Option<SpotStation> {
        let middle = nalgebra::center(&a.station.contact, &b.station.contact);
        let guess = [0, 1].map(|k| 0.5 * (a.uv[k] + b.uv[k]));
        let within = 0.5 * (b.station.contact - a.station.contact).norm();
        self.near(self.context.foot_near(&middle, guess, within)?, a)
    }

    /// Returns a station a little beside another: a pass needs two.
    fn beside(&self, spot: SpotStation) -> Option<SpotStation> {
        let face = self.context.face.face();
        let mut to = spot.uv;
        let jet = face.surface.jet1(to[0], to[1]);
        // Near a pole only one of the parameters moves the point.
        let paces = [jet.su.norm(), jet.sv.norm()];
        let k = usize::from(paces[1] > paces[0]);
        let by = SINGLE * self.context.narrow() / paces[k].max(f64::MIN_POSITIVE);
        // Away from the nearer end of the range.
        to[k] += if to[k] > face.bounds()[k].middle() { -by } else { by };
        self.near(to, &spot)
    }

    /// Returns the station at a point of the face with about the inclination of another.
    fn near(&self, uv: [f64; 2], other: &SpotStation) -> Option<SpotStation> {
        let station = self.station(uv, Some(other.station.pose))?;
        (station.turn_to(other) <= TURN).then_some(station)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::cost::LengthCost;
    use crate::cover::layout::chart::Chart;
    use crate::cover::layout::trims::region;
    use crate::cover::options::{CoverOptions, FinishTolerance};
    use crate::cover::pattern::FeedDirection;
    use crate::cover::place::context::{FaceRequest, PartSetup};
    use crate::cover::place::progress::FacesProgress;
    use crate::cover::prove::part_faces::PartFaces;
    use crate::cutter::{Cutter, CutterSpec};
    use crate::surface::{
        Face, FaceIndex, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
    };
    use crate::types::Silent;
    use nalgebra::{Point3, Vector3};

    /// A plane of 40 by 20 mm.
    fn plate() -> FaceIndex {
        let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
        let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 20.0], [0.0, 20.0], [0.0, 0.0]];
        let border = TrimCurve::polyline(&corners).unwrap();
        let trims = vec![TrimLoop::new(vec![border], [None, None], 1e-9).unwrap()];
        let face = Face::new(1, Surface::Plane(PlaneSurface { frame }), trims).unwrap();
        FaceIndex::new(face).unwrap()
    }

    /// A pass of 20 stations whose seventh is 0.1 mm too deep is cut on both sides of that, and nowhere else:
    /// the long parts stay whole.
    #[test]
    fn a_pass_is_cut_where_it_comes_too_deep_and_nowhere_else() {
        let (face, cutter) = (plate(), Cutter::new(CutterSpec::ball(6.0)).unwrap());
        let options =
            CoverOptions::finishing(&cutter, FinishTolerance { excess: 0.02, gouge: 0.0 });
        let faces = [face];
        let part_faces = PartFaces::new(faces.iter(), &cutter);
        let cost = LengthCost { link: 10.0 };
        let setup = PartSetup { cutter: &cutter, part_faces: &part_faces, own: 0, cost: &cost };
        let all = FacesProgress::new(&Silent, 1);
        let request =
            FaceRequest { face: &faces[0], setup, options: &options, progress: all.face(0, 1) };
        let chart = Chart::straight(FeedDirection::V);
        let region = region(&faces[0], &chart);
        let context = FaceContext::new(request, chart, &region);
        let planner = ChainPlanner { context: &context, order: PoseOrder::AsBefore };
        let station = |i: u32| planner.station([4.0 + f64::from(i), 10.0], None);
        let mut stations: Vec<SpotStation> = (0..20).map(|i| station(i).unwrap()).collect();
        let whole = planner.proven_passes(stations.clone());
        assert_eq!(whole.len(), 1);
        assert_eq!(whole[0].pass.stations.len(), 20);
        stations[6].station.pose.tip.z -= 0.1;
        let passes = planner.proven_passes(stations.clone());
        let bounds = |pass: &SpotPass| {
            let x = pass.pass.stations.iter().map(|station| station.contact.x);
            [x.clone().fold(f64::INFINITY, f64::min), x.fold(0.0, f64::max)]
        };
        let long: Vec<[f64; 2]> =
            passes.iter().filter(|pass| pass.pass.stations.len() > 2).map(bounds).collect();
        assert_eq!(long.len(), 2, "{long:?}");
        assert!(long[0][0] <= 4.0 && long[0][1] >= 9.0, "{long:?}");
        assert!(long[1][0] <= 11.0 && long[1][1] >= 23.0, "{long:?}");
        for pass in &passes {
            assert!(pass.pass.stations.iter().all(|station| station.pose.tip.z > -0.01));
            assert_eq!(pass.pass.track.len(), pass.pass.stations.len());
        }
    }
}
