//! Contact of a barrel in a given pose.

use crate::cutter::ToolBody;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::strip::{CuttingContext, StripQuery};
use crate::types::{ToolPose, Uv};
use nalgebra::{Matrix2, Unit, Vector2, Vector3};

/// Newton's steps to the contact; from the middle of a strip five reach rounding.
const STEPS: u32 = 12;

/// Step at which the contact is found \[mm\].
const SMALL: f64 = 1e-10;

/// Finds the point of the face nearest to a barrel, near `look.contact`.
///
/// The distance from the tool has a unit gradient `g` and bends by `1 / R` in the plane of the tool axis and by the
/// distance from the axis along `g` across it: with both, Newton's method finds its minimum over the face.
pub(crate) fn contact(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
    probe: &mut FaceProbe,
) -> Result<DistanceReading, PositioningError> {
    let end = ToolBody::new(setting.cutter).end;
    let radius = setting.cutter.contact_arc().radius;
    let surface = &setting.face.face().surface;
    let mut uv = look.uv;
    for _ in 0..STEPS {
        let jet = surface.jet2(uv.u, uv.v);
        let p = jet.s;
        let gap = end.gap(&p, pose);
        let (g, out) = (gap.gradient, p - pose.tip);
        let rho = (out - pose.axis.scale(out.dot(&pose.axis))).norm();
        let Some(across) = Unit::try_new(pose.axis.cross(&g), f64::MIN_POSITIVE) else { break };
        let along = across.cross(&g);
        // From the point along the gradient to the axis: rho over the part of the unit gradient square to the axis.
        let bends = [1.0 / (radius + gap.distance), pose.axis.cross(&g).norm() / rho];
        let tangents = [jet.su, jet.sv];
        let second = [[jet.suu, jet.suv], [jet.suv, jet.svv]];
        let hessian = Matrix2::from_fn(|i, j| {
            let by = |direction: &Vector3<f64>| {
                direction.dot(&tangents[i]) * direction.dot(&tangents[j])
            };
            g.dot(&second[i][j]) + bends[0] * by(&along) + bends[1] * by(&across)
        });
        let slope = Vector2::new(g.dot(&jet.su), g.dot(&jet.sv));
        let Some(step) = hessian.cholesky().map(|cholesky| -cholesky.solve(&slope)) else { break };
        uv = Uv::new(uv.u + step.x, uv.v + step.y);
        if (jet.su * step.x + jet.sv * step.y).norm() <= SMALL {
            break;
        }
    }
    probe.foot(&surface.point(uv.u, uv.v), uv.into())
}
