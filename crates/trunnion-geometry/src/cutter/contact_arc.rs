//! The arc of a profile with which a cutter touches a face.

use super::spec::CutterKind;
use super::tangent::{ProfileArc, ProfileSide, TangentProfile};
use super::validated::Cutter;
use crate::math;
use crate::types::{Interval, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Arc of the profile with which a cutter touches a face: the large arc of a barrel, the tip arc of all others.
///
/// The tool axis is inclined from the normal of the face by the angle between the axis and the arc's own normal at the
/// contact. A tip arc touches at any angle from 0 on, a barrel only far inclined.
///
/// # Example
///
/// ```
/// use trunnion_geometry::cutter::{Cutter, CutterSpec};
///
/// // Tip radius 1 mm, barrel radius 85 mm, 20 degrees between the upper end of the arc and the axis, diameter 8 mm.
/// let cutter = Cutter::new(CutterSpec::conical_barrel(1.0, 85.0, 20_f64.to_radians(), 8.0))?;
/// let arc = cutter.contact_arc();
/// assert_eq!(arc.radius, 85.0);
/// assert!((arc.inclinations.high.to_degrees() - 70.0).abs() < 1e-9);
/// // The arc ends at half the diameter.
/// assert!((arc.point(arc.inclinations.high)[0] - 4.0).abs() < 1e-12);
/// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactArc {
    /// Centre `[rho, z]` \[mm\]: distance from the axis, negative beyond it as seen from the arc, and height above the
    /// tip.
    pub center: [f64; 2],
    /// Radius \[mm\]; 0 for the edge of a flat cutter.
    pub radius: f64,
    /// Angles between tool axis and face normal at which the arc touches \[rad\].
    pub inclinations: Interval,
}

impl Cutter {
    /// Returns the arc with which the cutter touches a face.
    pub fn contact_arc(&self) -> ContactArc {
        let profile = self.tangent_profile();
        let tip_angle = profile.map_or(FRAC_PI_2, TangentProfile::tip_angle);
        let barrel = profile.filter(|_| self.is_barrel()).map(|profile| (profile, profile.side()));
        if let Some((profile, ProfileSide::Arc(ProfileArc { center, radius }))) = barrel {
            let [_, [out, up]] = profile.normals();
            return ContactArc {
                center,
                radius,
                inclinations: Interval::new(tip_angle, math::atan2(out, -up)),
            };
        }
        let center = [self.major(), self.minor()];
        ContactArc { center, radius: self.minor(), inclinations: Interval::new(0.0, tip_angle) }
    }

    /// Returns `true` for a barrel or conical barrel, which cuts with the large arc of its side.
    pub fn is_barrel(&self) -> bool {
        matches!(self.kind(), CutterKind::Barrel | CutterKind::ConicalBarrel)
    }

    /// Returns `true` if the cutter touches a face in one point: a ball, or an arc that stands for one across the feed.
    /// All others touch with their centre circle.
    pub fn touches_in_one_point(&self) -> bool {
        self.is_barrel() || self.has_ball_tip()
    }

    /// Returns `true` if the cutter cuts with a ball at its tip: all inclinations leave the same strip.
    pub fn has_ball_tip(&self) -> bool {
        !self.is_barrel() && self.major() <= 0.0
    }
}

impl ContactArc {
    /// Returns the point `[rho, z]` of the arc that touches at an inclination \[mm\].
    pub fn point(&self, inclination: f64) -> [f64; 2] {
        let (sin, cos) = math::sin_cos(inclination);
        [self.center[0] + self.radius * sin, self.center[1] - self.radius * cos]
    }

    /// Returns the radius of curvature of the cutter at the contact, square to the tool axis \[mm\].
    ///
    /// Meusnier: a surface of revolution bends there with the distance from its axis along the normal. Infinite where
    /// the normal is the axis, but for an arc about a point of the axis, which is a ball.
    pub fn radius_across(&self, inclination: f64) -> f64 {
        let [rho, _] = self.center;
        if rho.abs() <= 0.0 { self.radius } else { self.radius + rho / math::sin(inclination) }
    }

    /// Returns the pose that touches with the arc around `center`, inclined from the normal of the face by
    /// `inclination` \[rad\] towards a unit vector square to the normal.
    pub fn pose(
        &self,
        center: Point3<f64>,
        normal: &UnitVector3<f64>,
        towards: &Vector3<f64>,
        inclination: f64,
    ) -> ToolPose {
        let (sin, cos) = math::sin_cos(inclination);
        let axis = Unit::new_normalize(normal.scale(cos) + towards.scale(sin));
        // From the centre of the arc square to the axis onto it, then down to the tip.
        let [rho, z] = self.center;
        let out = towards.scale(cos) - normal.scale(sin);
        let on_axis = if rho.abs() > 0.0 { center - out.scale(rho) } else { center };
        ToolPose { tip: on_axis - axis.scale(z), axis }
    }

    /// Returns the centre of the arc on the side of the tool where `contact` is.
    pub fn center_at(&self, pose: &ToolPose, contact: &Point3<f64>) -> Point3<f64> {
        let [rho, z] = self.center;
        let on_axis = pose.tip + pose.axis.scale(z);
        let out = contact - on_axis;
        let flat = out - pose.axis.scale(out.dot(&pose.axis));
        // On the axis all sides are alike.
        match Unit::try_new(flat, f64::MIN_POSITIVE) {
            Some(out) if rho.abs() > 0.0 => on_axis + out.scale(rho),
            _ => on_axis,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::spec::CutterSpec;
    use super::*;
    use proptest::prelude::*;

    /// The radii of a barrel by pencil: tip arc and large arc touch, and both lie at half the diameter where they should.
    #[test]
    fn a_barrel_touches_with_its_large_arc() {
        let cutter = Cutter::new(CutterSpec::barrel(2.0, 85.0, 12.0)).unwrap();
        let arc = cutter.contact_arc();
        // Upright, the arc ends at the flank: its centre lies 85 - 6 mm beyond the axis.
        assert!((arc.center[0] + 79.0).abs() < 1e-12 && (arc.radius - 85.0).abs() < 1e-12);
        assert!((arc.inclinations.high - FRAC_PI_2).abs() < 1e-12);
        // sin = 79 / 83 where both arcs meet, 2 mm from the centre of the tip arc.
        assert!((arc.inclinations.low.sin() - 79.0 / 83.0).abs() < 1e-12);
        let [rho, z] = arc.point(arc.inclinations.low);
        assert!((rho - 2.0 * 79.0 / 83.0).abs() < 1e-12);
        assert!((z - 2.0 * (1.0 - arc.inclinations.low.cos())).abs() < 1e-12);
        // There the cutter bends like its tip, at the upper end like its flank.
        assert!((arc.radius_across(arc.inclinations.low) - 2.0).abs() < 1e-12);
        assert!((arc.radius_across(FRAC_PI_2) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn other_cutters_touch_with_their_tip_arc() {
        for spec in [CutterSpec::ball(8.0), CutterSpec::bull(4.0, 2.0), CutterSpec::flat(8.0)] {
            let cutter = Cutter::new(spec).unwrap();
            let arc = cutter.contact_arc();
            let expected = [cutter.major(), cutter.minor(), cutter.minor()];
            let found = [arc.center[0], arc.center[1], arc.radius];
            // The same numbers, taken over as they are.
            assert_eq!(expected.map(f64::to_bits), found.map(f64::to_bits));
        }
        let lens = Cutter::new(CutterSpec::lens(30.0, 1.0, 12.0)).unwrap();
        assert!(lens.touches_in_one_point() && !lens.is_barrel());
        assert!(lens.has_ball_tip());
        let barrel = Cutter::new(CutterSpec::barrel(2.0, 85.0, 12.0)).unwrap();
        assert!(barrel.touches_in_one_point() && !barrel.has_ball_tip());
        assert!((lens.contact_arc().inclinations.high.sin() - 5.0 / 29.0).abs() < 1e-12);
    }

    proptest! {
        /// At any inclination of the arc the contact lies on the cutter, which stays off the plane that it touches.
        #[test]
        fn the_pose_touches_a_plane_with_the_arc(
            share in 0.0..1.0f64,
            turn in 0.0..6.3f64,
            (tip, barrel, more, taper) in (0.2..3.0f64, 20.0..300.0f64, 1.0..9.0f64, 0.02..0.7f64),
        ) {
            let spec = CutterSpec::conical_barrel(tip, barrel, taper, 2.0 * (tip + more));
            let Ok(cutter) = Cutter::new(CutterSpec { length: 400.0, ..spec }) else { return Ok(()) };
            let arc = cutter.contact_arc();
            let inclination = arc.inclinations.at(share);
            let normal = Vector3::z_axis();
            let towards = Vector3::new(turn.cos(), turn.sin(), 0.0);
            let pose = arc.pose(Point3::new(0.0, 0.0, arc.radius), &normal, &towards, inclination);
            let end = crate::cutter::ToolBody::new(&cutter).end;
            prop_assert!(end.distance(&Point3::origin(), &pose).abs() < 1e-9);
            prop_assert!(end.plane(&Point3::origin(), &pose, -normal.into_inner()).distance.abs() < 1e-9);
            let center = arc.center_at(&pose, &Point3::origin());
            prop_assert!((center - Point3::new(0.0, 0.0, arc.radius)).norm() < 1e-9);
        }
    }
}
