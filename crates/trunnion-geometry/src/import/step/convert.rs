//! Stated surfaces to the project's own.

use super::curve::StepCurve;
use super::model::FaceLoss;
use super::model::Read;
use super::model::StepFrame;
use super::model::loss;
use super::shape::StepShape;
use crate::surface;
use crate::surface::Face;
use crate::surface::NurbsCurve;
use crate::surface::NurbsSurface;
use crate::surface::Surface;
use crate::surface::{SurfaceError, SurfaceErrors};
use nalgebra::Point3;

/// Converts a stated surface, keeping its parametrisation.
pub(super) fn surface(shape: &StepShape, id: u64) -> Read<Surface> {
    let named = |fault: SurfaceError| FaceLoss { entity: id, message: fault.to_string() };
    let several = |faults: SurfaceErrors| joined(&faults, id);
    match shape {
        StepShape::Plane(at) => Ok(Surface::Plane(surface::PlaneSurface { frame: frame(at, id)? })),
        StepShape::Cylinder { frame: at, radius } => {
            surface::CylinderSurface::new(frame(at, id)?, *radius)
                .map(Surface::Cylinder)
                .map_err(named)
        }
        StepShape::Cone { frame: at, radius, angle } => {
            surface::ConeSurface::new(frame(at, id)?, *radius, *angle)
                .map(Surface::Cone)
                .map_err(named)
        }
        StepShape::Sphere { frame: at, radius } => {
            surface::SphereSurface::new(frame(at, id)?, *radius).map(Surface::Sphere).map_err(named)
        }
        StepShape::Torus { frame: at, major, minor } => {
            let torus = surface::TorusSurface::new(frame(at, id)?, *major, *minor);
            torus.map(Surface::Torus).map_err(named)
        }
        StepShape::Extrusion { curve, direction } => {
            let swept = surface::ExtrusionSurface::new(profile(curve, id)?, *direction);
            swept.map(Surface::Extrusion).map_err(named)
        }
        StepShape::Revolution { curve, axis } => {
            let swept = surface::RevolutionSurface::new(profile(curve, id)?, axis.origin, axis.z);
            swept.map(Surface::Revolution).map_err(named)
        }
        StepShape::Net(net) => {
            let net = net.clone();
            let surface = NurbsSurface::new(net.degree, net.knots, net.points, net.weights);
            surface.map(Surface::Nurbs).map_err(several)
        }
    }
}

fn joined(faults: &[SurfaceError], id: u64) -> FaceLoss {
    let all: Vec<String> = faults.iter().map(ToString::to_string).collect();
    FaceLoss { entity: id, message: all.join("; ") }
}

fn frame(at: &StepFrame, id: u64) -> Read<surface::SurfaceFrame> {
    surface::SurfaceFrame::new(at.origin, at.z.into_inner(), at.x.into_inner())
        .map_err(|fault| FaceLoss { entity: id, message: fault.to_string() })
}

fn profile(curve: &StepCurve, id: u64) -> Read<surface::SpaceCurve> {
    let named = |fault: SurfaceError| FaceLoss { entity: id, message: fault.to_string() };
    match curve {
        StepCurve::Line { origin, direction } => {
            surface::SpaceCurve::line(*origin, *direction).map_err(named)
        }
        StepCurve::Ellipse { frame: at, semi } => {
            surface::SpaceCurve::ellipse(frame(at, id)?, *semi).map_err(named)
        }
        StepCurve::Spline(spline) => {
            let points: Vec<Point3<f64>> =
                spline.points.iter().map(|h| Point3::from(h.xyz() / h.w)).collect();
            let weights: Vec<f64> = spline.points.iter().map(|h| h.w).collect();
            let knots = spline.knots.knots().to_vec();
            NurbsCurve::new(spline.knots.degree(), knots, &points, Some(&weights))
                .map(surface::SpaceCurve::Nurbs)
                .map_err(|faults| joined(&faults, id))
        }
        StepCurve::Hyperbola { .. } | StepCurve::Parabola { .. } => loss(
            id,
            "a swept hyperbola or parabola is not read; export its surface as a B-spline surface",
        ),
    }
}

/// Refuses a face that reaches beyond its surface: over the rim of one that closes with an edge,
/// or of a damaged file. There it would be continued wrongly.
pub(super) fn inside_domain(face: &Face, id: u64, tolerance: f64) -> Read<()> {
    let domain = face.surface.domain();
    let periods = face.surface.periods();
    for k in (0..2).filter(|&k| periods[k].is_none()) {
        let ends = face.loops.iter().map(|trim| trim.bounds()[k]);
        let low = ends.clone().map(|end| end.low).fold(f64::INFINITY, f64::min);
        let high = ends.map(|end| end.high).fold(f64::NEG_INFINITY, f64::max);
        let [u, v] = face.bounds();
        // Compared in space, in the middle of the other parameter: both ends may be one seam.
        let middle = [0.5 * (u.low + u.high), 0.5 * (v.low + v.high)];
        let point = |x: f64| {
            let mut uv = middle;
            uv[k] = x;
            face.point(uv[0], uv[1])
        };
        for (beyond, bound, rim) in [
            (low < domain[k].low, low, domain[k].low),
            (high > domain[k].high, high, domain[k].high),
        ] {
            if beyond && (point(bound) - point(rim)).norm() > tolerance {
                return loss(id, "the face reaches beyond the rim of its surface");
            }
        }
    }
    Ok(())
}
