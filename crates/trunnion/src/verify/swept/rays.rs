//! Bounds of a moving body against bundles of rays, and against planes.

use super::quadratic::{DistanceMargin, MotionInstant, MotionPiece, SurfacePatch};
use super::tool::{ConvexBody, NormalRay};
use nalgebra::{Point3, Vector3};

/// Shortest half interval of time in a search: a millionth of the piece.
const SHORTEST: f64 = 1e-6;

/// Bundle of nearby rays: origins within `bulge` of a flat disc, normals within `turn` of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayBundle {
    pub(crate) centre: Point3<f64>,
    pub(crate) normal: Vector3<f64>,
    pub(crate) radius: f64,
    pub(crate) bulge: f64,
    pub(crate) turn: f64,
}

impl RayBundle {
    /// Returns the bundle of some rays, with the disc across one of them.
    pub(crate) fn around(middle: &NormalRay, rays: &[NormalRay]) -> Self {
        let NormalRay { origin: centre, normal, .. } = *middle;
        let none = Self { centre, normal, radius: 0.0, bulge: 0.0, turn: 0.0 };
        rays.iter().fold(none, |disc, ray| {
            let aside = ray.origin - centre;
            // Height over the disc counts as bulge, distance across as radius.
            let up = aside.dot(&normal);
            Self {
                radius: disc.radius.max((aside - normal * up).norm()),
                bulge: disc.bulge.max(up.abs()),
                turn: disc.turn.max((ray.normal - normal).norm()),
                ..disc
            }
        })
    }
}

impl MotionPiece {
    /// Bounds the distance of a body from a bundle over `u` within `half` of the instant, from `below` under the disc to
    /// `top` over it.
    ///
    /// The linear part of the distance function at the top of the middle ray supports it, as in
    /// [`MotionPiece::keeps_off`].
    fn off_rays(
        &self,
        instant: &MotionInstant,
        half: f64,
        body: ConvexBody,
        disc: &RayBundle,
        [below, top]: [f64; 2],
    ) -> DistanceMargin {
        let MotionInstant { pose, tip_rate, axis_rate } = instant;
        let y = disc.centre + disc.normal * top - pose.tip;
        let probe = body.probe(&y, &pose.axis);
        let along = probe.axial - probe.radial * probe.height;
        let gradient = y * probe.radial + pose.axis * along;
        // As in `MotionInstant::distance`: the derivative by u for a point that is fixed in space.
        let drift = y.dot(axis_rate) * along - gradient.dot(tip_rate);
        // From the top of the middle ray, other rays change the distance by the slope across, and lower
        // points by the slope along the rays if the distance falls downwards.
        let up = gradient.dot(&disc.normal);
        let aside = (gradient - disc.normal * up).norm();
        // A ray that is inclined by `turn` departs from parallel in proportion to its length.
        let bulge = disc.bulge + below.max(top.abs()) * disc.turn;
        let radius = disc.radius + top + below + bulge;
        let [bend, shear] = self.beyond(half, y.norm() + radius);
        let extent = aside * disc.radius + bulge + up.max(0.0) * (top + below);
        DistanceMargin {
            distance: probe.distance,
            extent,
            spread: extent,
            time: drift.abs() * half + bend + shear * radius,
        }
    }

    /// Returns a lower bound of the distance of a body from a bundle over the whole piece.
    pub(crate) fn keeps_off_rays(
        &self,
        body: ConvexBody,
        disc: &RayBundle,
        range: [f64; 2],
    ) -> f64 {
        let DistanceMargin { distance, extent, time, .. } =
            self.off_rays(&self.middle, 1.0, body, disc, range);
        distance - extent - time
    }

    /// Tests if a body may come within `slack` of a bundle during the piece; returns its approximate distance if so.
    ///
    /// Bisects time as long as time loses more of the distance than the extent of the bundle does.
    pub(crate) fn comes(
        &self,
        body: ConvexBody,
        disc: &RayBundle,
        range: [f64; 2],
        slack: f64,
    ) -> Option<f64> {
        let (mut next, mut open) = (Some((0.0, 1.0)), Vec::new());
        // The whole piece decides nearly always, and nothing is allocated for it.
        while let Some((u, half)) = next.take().or_else(|| open.pop()) {
            let margin = self.off_rays(&self.instant(u), half, body, disc, range);
            let DistanceMargin { distance, extent, time, .. } = margin;
            if distance - extent - time > slack {
                continue;
            }
            // Shorter intervals would gain less than the extent of the bundle loses: the body may come.
            if time <= extent || half < SHORTEST {
                return Some(distance);
            }
            open.extend([(u - 0.5 * half, 0.5 * half), (u + 0.5 * half, 0.5 * half)]);
        }
        None
    }

    /// Bounds the distance of a body from a patch by the body's support plane along the patch normal.
    ///
    /// Where a sharp edge is nearest, this plane bounds better than the planes of both sides of the edge that
    /// [`MotionPiece::keeps_off`] uses.
    pub(crate) fn keeps_above(
        &self,
        instant: &MotionInstant,
        half: f64,
        body: ConvexBody,
        patch: &SurfacePatch<'_>,
    ) -> DistanceMargin {
        let MotionInstant { pose, tip_rate, axis_rate } = instant;
        let y = patch.centre - pose.tip;
        let down = -patch.normal;
        // The tool turns without spin about its own axis.
        let turning = pose.axis.cross(axis_rate).cross(&y);
        let drift = down.dot(&(tip_rate + turning));
        // Departure from linear motion at the centre, and the turn times the radius for the other points.
        let [bend, shear] = self.beyond(half, y.norm() + patch.radius);
        DistanceMargin {
            distance: down.dot(&y) - body.extent(&pose.axis, &down),
            extent: patch.bulge,
            spread: patch.bulge,
            time: drift.abs() * half + bend + shear * patch.radius,
        }
    }
}
