//! Independent measurement of the strip that a pose leaves.

use crate::positioning::check::arc_contact;
use crate::positioning::check::ball_strip::{PlacedBall, ball_strip, limit};
use crate::positioning::check::survey::{CircleSurvey, GapRefinement};
use crate::positioning::distance::circle::ErrorCircle;
use crate::positioning::distance::curve::circle_of_pose;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::contact_center;
use crate::positioning::strip::{CuttingContext, MeasuredStrip, StripQuery};
use crate::types::ToolPose;

/// Measures the strip that a pose leaves, without any of the assumptions it was made with.
///
/// The signed error (distance from the surface minus the corner radius) is sampled round the whole
/// circle, extrema and ends of the strip are refined; between samples it is bounded through a range
/// of its second derivative, from curvatures bounded over all the surface that feet can reach.
/// The bounds hold for the foot that is followed round the circle; of the continuation beyond the
/// face's domain they know the curvature at the samples only.
///
/// A pose that gouges is not an error: `front_min` and `rear_min` show it.
///
/// # Example
///
/// ```
/// # use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
/// # let point = |x, y| nalgebra::Point3::new(x, y, 0.0);
/// # let points = vec![vec![point(0.0, 0.0), point(0.0, 40.0)], vec![point(40.0, 0.0), point(40.0, 40.0)]];
/// # let knots = vec![0.0, 0.0, 1.0, 1.0];
/// # let plane = NurbsSurface::new([1, 1], [knots.clone(), knots], points, None).unwrap();
/// # let face = FaceIndex::new(Face::new(1, Surface::Nurbs(plane), vec![])?)?;
/// use nalgebra::{Point3, Vector3};
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::positioning::{
///     CuttingContext, StripQuery, StripSide, ToleranceBand, strip_of_pose,
/// };
/// use trunnion::types::{ToolPose, Uv};
///
/// // A ball of radius 5 mm that touches the plane z = 0 in (20, 20).
/// let cutter = Cutter::new(CutterSpec::ball(10.0))?;
/// let band = ToleranceBand { lower: 0.0, upper: 0.01 };
/// let contact = Point3::new(20.0, 20.0, 0.0);
/// let strip = strip_of_pose(
///     &CuttingContext { face: &face, cutter: &cutter, band },
///     &ToolPose { tip: contact, axis: Vector3::z_axis() },
///     &StripQuery { feed: Vector3::x(), strip: StripSide::Right, contact, uv: Uv::new(0.5, 0.5) },
/// )?;
/// let expected = 2.0 * (2.0 * 5.0 * 0.01 - 0.01_f64.powi(2)).sqrt();
/// assert!((strip.width - expected).abs() < 1e-6);
/// assert!(strip.front_min.abs() < 1e-9); // it does not gouge
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn strip_of_pose(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
) -> Result<MeasuredStrip, PositioningError> {
    let mut probe = FaceProbe::new(setting.face);
    let middle = probe.read(&look.contact, look.uv.into())?;
    let (ring, v) = circle_of_pose(setting, pose, look, &middle)?;
    if ring.radius <= 0.0 {
        let (center, middle) = if setting.cutter.is_barrel() {
            let touch = arc_contact::contact(setting, pose, look, &mut probe)?;
            (contact_center(setting.cutter, pose, &touch.foot.point), touch)
        } else {
            (ring.center, middle)
        };
        let ball = PlacedBall { center, pose, limit: limit(setting.cutter) };
        return ball_strip(setting, ball, &v, &middle, &mut probe);
    }
    let circle = ErrorCircle { ring, minor: setting.cutter.minor() };
    let (axis, v) = (pose.axis, v.into_inner());
    let survey = CircleSurvey {
        setting,
        circle,
        axis,
        v,
        half_arc: 0.0,
        seen: &[],
        refinement: GapRefinement::Thorough,
    };
    survey.strip(middle.foot.uv.into(), &mut probe)
}
