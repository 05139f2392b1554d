//! Detects programs that cut the faces from their back.

use crate::cutter::Cutter;
use crate::surface::Face;
use crate::types::Interval;
use crate::verify::error::VerifyError;
use crate::verify::input::CheckInput;
use crate::verify::replay::track::{TimedPose, Track, track};
use crate::verify::swept::tool::{BodyPose, bodies};
use nalgebra::{Point3, Vector3};

/// Points tested along either parameter of a face, and in all at most.
const ACROSS: u32 = 5;
const MOST_POINTS: usize = 100;
/// Share of the points that must be cut from behind.
const SHARE: usize = 4;
/// Distance of the test points from the face, over the radius of the smallest tool. No tolerance is as large and no tool
/// as thin.
const OFF: f64 = 0.1;
/// Distance of tool positions over the same radius. A ball that touches a point between two of them has risen over it by
/// less than a tenth of `OFF` at the nearer one.
const STEP: f64 = 0.25;

/// Evidence that the tool comes to the faces from their backs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct FacesFromBehind {
    /// Points that the tool reaches from the back alone.
    pub from_back: usize,
    /// All points that were examined.
    pub examined: usize,
}

/// Finds faces that the motion cuts from their backs, where measured heights would report that nothing is cut.
///
/// Returns `None` if a tool reaches any point from the front, or only few points at all.
///
/// # Errors
///
/// [`VerifyError`].
pub fn behind(input: &CheckInput<'_>) -> Result<Option<FacesFromBehind>, VerifyError> {
    let probes = SideProbes::new(input.faces, input.cutters());
    Ok(probes.votes(&track(input, STEP * probes.radius)?))
}

/// Pairs of points in front of and behind faces, with the tools that may reach them.
struct SideProbes<'a> {
    pairs: Vec<[Point3<f64>; 2]>,
    cutters: Vec<&'a Cutter>,
    /// Smallest radius of a tool \[mm\].
    radius: f64,
}

impl<'a> SideProbes<'a> {
    fn new(faces: &[Face], cutters: Vec<&'a Cutter>) -> Self {
        let radius = cutters.iter().map(|cutter| cutter.radius()).fold(f64::INFINITY, f64::min);
        let pairs: Vec<_> = faces.iter().flat_map(|face| test_points(face, OFF * radius)).collect();
        let stride = pairs.len().div_ceil(MOST_POINTS).max(1);
        Self { pairs: pairs.into_iter().step_by(stride).collect(), cutters, radius }
    }

    fn votes(&self, tracks: &[Track]) -> Option<FacesFromBehind> {
        let bodies: Vec<_> = self.cutters.iter().map(|cutter| bodies(cutter)).collect();
        let reach: Vec<f64> =
            self.cutters.iter().map(|cutter| crate::verify::swept::tool::size(cutter)).collect();
        // For each pair: some tool position holds the point in front, or the point behind.
        let mut held = vec![[false; 2]; self.pairs.len()];
        for track in tracks.iter().filter(|track| !track.rapid) {
            let (Some(bodies), Some(&reach)) = (bodies.get(track.tool), reach.get(track.tool))
            else {
                continue;
            };
            for TimedPose { pose, .. } in &track.poses {
                let body_pose = BodyPose { tip: pose.tip, axis: pose.axis.into_inner() };
                for (pair, held) in self.pairs.iter().zip(&mut held) {
                    for (point, held) in pair.iter().zip(held) {
                        // Cheap test first: no point farther from the tip than the size of the tool is in it.
                        *held |= (point - pose.tip).norm_squared() < reach * reach
                            && bodies.iter().any(|body| body.holds(&body_pose, point));
                    }
                }
            }
        }
        let count = |wanted: [bool; 2]| held.iter().filter(|held| **held == wanted).count();
        let [front, back] = [count([true, false]), count([false, true])];
        let examined = held.len();
        // One point that is cut from the front shows that the faces are right; a few from behind may be a thin wall.
        (front == 0 && back > 0 && SHARE * back >= examined)
            .then_some(FacesFromBehind { from_back: back, examined })
    }
}

/// Returns pairs of points at a given distance in front of and behind a face.
fn test_points(face: &Face, off: f64) -> Vec<[Point3<f64>; 2]> {
    let [u, v] = face.bounds();
    // Middles of equal cells, away from the borders of the face.
    let at = |Interval { low, high }: Interval, k: u32| {
        low + (high - low) * (f64::from(k) + 0.5) / f64::from(ACROSS)
    };
    let grid = (0..ACROSS * ACROSS).map(|k| [at(u, k / ACROSS), at(v, k % ACROSS)]);
    let pair = |[u, v]: [f64; 2]| {
        let out: Vector3<f64> = face.normal(u, v)?.into_inner() * off;
        let point = face.point(u, v);
        face.contains(u, v).then_some([point + out, point - out])
    };
    grid.filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{CutterKind, CutterSpec};
    use crate::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
    use crate::surface::{NurbsSurface, Surface};
    use crate::types::ToolPose;

    /// 40 by 20 mm at height 0.
    fn plate(flip: bool) -> Face {
        let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let net = vec![vec![at(0.0, 0.0), at(0.0, 20.0)], vec![at(40.0, 0.0), at(40.0, 20.0)]];
        let knots = || vec![0.0, 0.0, 1.0, 1.0];
        let surface = NurbsSurface::new([1, 1], [knots(), knots()], net, None).unwrap();
        Face { flip, ..Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap() }
    }

    /// Rows 2 mm apart of a tool whose tip is at a height.
    fn rows(height: f64) -> ClFile {
        let record = |k: u32| {
            let [row, end] = [k / 2, k % 2].map(f64::from);
            let tip = Point3::new(40.0 * end, 2.0 * row, height);
            let pose = ToolPose { tip, axis: Vector3::z_axis() };
            ClRecord { line: k + 1, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
        };
        ClFile { records: (0..22).map(record).collect(), ..ClFile::default() }
    }

    #[test]
    fn a_tool_behind_the_face_is_found() {
        for (kind, major, minor) in [(CutterKind::Ball, 0.0, 4.0), (CutterKind::Bull, 3.0, 1.0)] {
            let spec = CutterSpec { kind, length: 50.0, ..CutterSpec::of_radii(major, minor) };
            let cutter = Cutter::new(spec).unwrap();
            let found = |height: f64, flip: bool| {
                let (file, faces) = (rows(height), [plate(flip)]);
                let input = CheckInput::locations(&file, &cutter).faces(&faces);
                behind(&input).unwrap()
            };
            for height in [-0.01, 0.0, 0.01] {
                assert_eq!(found(height, false), None, "{kind:?} {height}");
                assert_eq!(
                    found(height, true),
                    Some(FacesFromBehind { from_back: 25, examined: 25 }),
                    "{kind:?} {height}"
                );
            }
            // Far above, and far too deep: neither side is the wrong one.
            for height in [5.0, -5.0] {
                assert_eq!((found(height, false), found(height, true)), (None, None), "{kind:?}");
            }
        }
    }
}
