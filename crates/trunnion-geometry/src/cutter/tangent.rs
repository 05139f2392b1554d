//! Cutting ends whose tip arc goes over into a second arc or a cone: tapered, barrel and lens cutters.

use super::spec::CutterSide;
use crate::math;

/// Convex profile of revolution: a flat bottom, the tip arc, a side tangent to it, and the flank.
///
/// The flat bottom reaches from the axis to the centre of the tip arc, and is a point where that lies on the axis. The
/// side is an arc or the straight line of a cone; it ends at the outer radius, where a straight flank goes on up to the
/// top. Coordinates are `[rho, z]`, distance from the axis and height above the tip \[mm\]. Directions are unit vectors
/// in the same plane.
///
/// # Example
///
/// ```
/// use trunnion_geometry::cutter::{Cutter, CutterSpec};
///
/// // A tapered ball: tip radius 1 mm, half angle 30 degrees, up to a diameter of 10 mm.
/// let cutter = Cutter::new(CutterSpec::taper(1.0, 30_f64.to_radians(), 10.0))?;
/// let profile = cutter.tangent_profile().expect("a cutter with a cone");
/// // 2 mm below the tip, and 3 mm beside the flank.
/// assert_eq!(profile.distance([0.0, -2.0]).distance, 2.0);
/// assert_eq!(profile.distance([8.0, 20.0]).distance, 3.0);
/// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentProfile {
    /// Centre of the tip arc and its radius.
    tip: ProfileArc,
    /// Outward normal at the end of the tip arc, where the side begins.
    joint: [f64; 2],
    side: ProfileSide,
    /// Outward normal at the upper end of the side.
    last: [f64; 2],
    /// Upper end of the side and lower end of the flank.
    end: [f64; 2],
    /// Upper end of the flank \[mm\].
    top: f64,
}

/// Circle that an arc of a profile lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfileArc {
    pub(super) center: [f64; 2],
    pub(super) radius: f64,
}

/// Side of a tangent profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ProfileSide {
    Cone,
    Arc(ProfileArc),
}

/// Signed distance of a point from a profile, with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileDistance {
    /// Signed distance \[mm\], negative inside.
    pub distance: f64,
    /// Derivatives by the distance from the axis and by the height: a unit vector.
    pub gradient: [f64; 2],
}

impl ProfileArc {
    /// Returns the point of the circle in a direction.
    pub(super) fn point(&self, [out, up]: [f64; 2]) -> [f64; 2] {
        [self.center[0] + self.radius * out, self.center[1] + self.radius * up]
    }

    /// Returns the height of the circle over its lowest point, at a distance from the axis of at most its reach
    /// \[mm\].
    fn height(&self, distance: f64) -> f64 {
        let out = (distance - self.center[0]).clamp(0.0, self.radius);
        // r - sqrt(r² - out²), without the cancellation of small distances.
        let square = out * out;
        let root = (self.radius * self.radius - square).max(0.0).sqrt();
        if square > 0.0 { square / (self.radius + root) } else { 0.0 }
    }

    fn distance(&self, [rho, z]: [f64; 2]) -> ProfileDistance {
        let [out, up] = [rho - self.center[0], z - self.center[1]];
        // Millimetres do not overflow, and hypot is a slow call.
        let away = (out * out + up * up).sqrt();
        // At the centre every direction is as good as any other.
        let gradient = if away > 0.0 { [out / away, up / away] } else { [0.0, -1.0] };
        ProfileDistance { distance: away - self.radius, gradient }
    }
}

/// Returns the derivative along the profile, counter-clockwise from an outward normal.
fn along([out, up]: [f64; 2]) -> [f64; 2] {
    [-up, out]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

impl TangentProfile {
    /// Lays out the profile of a tip arc about `[major, minor]` with a side; `None` for a straight side, or if no such
    /// profile exists.
    pub(super) fn new([major, minor]: [f64; 2], side: CutterSide, top: f64) -> Option<Self> {
        let tip = ProfileArc { center: [major, minor], radius: minor };
        let outer = 0.5 * side.diameter()?;
        let last = match side.taper_angle() {
            // Exactly outward, where the cosine of a right angle would not be 0.
            angle if angle > 0.0 => [math::cos(angle), -math::sin(angle)],
            _ => [1.0, 0.0],
        };
        let (joint, form, end) = match side {
            CutterSide::Straight => return None,
            CutterSide::Cone { .. } => {
                let start = tip.point(last);
                let [out, up] = along(last);
                let length = (outer - start[0]) / out;
                (last, ProfileSide::Cone, [outer, start[1] + length * up])
            }
            CutterSide::Arc { radius, .. } => {
                // Tangent circles have both centres on the normal at the joint: c2 = c1 - (q - r) n. With the outer end
                // of the side at the outer radius, c2 + q n_last gives the sine of the joint.
                let sin = (major + radius * last[0] - outer) / (radius - minor);
                let cos = (1.0 - sin * sin).sqrt();
                let joint = [sin, -cos];
                let off = radius - minor;
                let arc = ProfileArc { center: [major - off * sin, minor + off * cos], radius };
                (joint, ProfileSide::Arc(arc), [outer, arc.point(last)[1]])
            }
        };
        let is_convex = joint[0] > 0.0 && dot(along(joint), last) >= 0.0 && joint[1] < 0.0;
        let fits = is_convex && end[0] > tip.point(joint)[0] && end[1].is_finite();
        fits.then_some(Self { tip, joint, side: form, last, end, top: top.max(end[1]) })
    }

    /// Returns the height at which the straight flank begins \[mm\].
    pub fn flank_start(&self) -> f64 {
        self.end[1]
    }

    /// Returns the height of the upper end \[mm\].
    pub fn top(&self) -> f64 {
        self.top
    }

    /// Returns the outer radius \[mm\].
    pub fn radius(&self) -> f64 {
        self.end[0]
    }

    /// Returns the radius of the tip arc \[mm\].
    pub fn tip_radius(&self) -> f64 {
        self.tip.radius
    }

    /// Returns the end of the tip arc, where the side begins, `[rho, z]` \[mm\].
    pub fn joint(&self) -> [f64; 2] {
        self.tip.point(self.joint)
    }

    /// Returns the height up to which the profile lies inside the circle of its tip arc \[mm\].
    ///
    /// A cone or a larger arc leaves the circle at the joint. The corner of a lens turns inwards: there the flank leaves
    /// it, at `z = r + sqrt(r^2 - rho^2)` for the outer radius `rho`.
    pub fn height_in_tip_circle(&self) -> f64 {
        let (center, radius) = (self.tip.center, self.tip.radius);
        match self.side {
            ProfileSide::Arc(arc) if arc.radius < radius => {
                let across = self.end[0] - center[0];
                (center[1] + (radius * radius - across * across).max(0.0).sqrt()).min(self.top)
            }
            _ => self.joint()[1],
        }
    }

    /// Returns the largest angle between a normal of the tip arc and the axis \[rad\].
    pub fn tip_angle(&self) -> f64 {
        math::atan2(self.joint[0], -self.joint[1])
    }

    pub(super) fn tip(&self) -> ProfileArc {
        self.tip
    }

    pub(super) fn side(&self) -> ProfileSide {
        self.side
    }

    pub(super) fn end(&self) -> [f64; 2] {
        self.end
    }

    pub(super) fn normals(&self) -> [[f64; 2]; 2] {
        [self.joint, self.last]
    }

    /// Returns the signed distance of a point `[rho, z]` with `rho` at least 0.
    ///
    /// Every piece answers for the points between the normals at its ends. Outside that is one piece; inside it may be
    /// several, of which the nearest counts.
    #[inline]
    pub fn distance(&self, point: [f64; 2]) -> ProfileDistance {
        let [rho, z] = point;
        let [outer, up] = [rho - self.end[0], z - self.top];
        if up > 0.0 {
            // Over the top its disc or its rim is nearest.
            let out = outer.max(0.0);
            let away = (out * out + up * up).sqrt();
            return ProfileDistance { distance: away, gradient: [out / away, up / away] };
        }
        let mut nearest = ProfileDistance { distance: up, gradient: [0.0, 1.0] };
        let mut take = |piece: ProfileDistance| {
            if piece.distance > nearest.distance {
                nearest = piece;
            }
        };
        let before = dot(minus(point, self.tip.center), along(self.joint));
        let after = dot(minus(point, self.end), along(self.last));
        if rho <= self.tip.center[0] {
            take(ProfileDistance { distance: -z, gradient: [0.0, -1.0] });
        } else if before <= 0.0 {
            take(self.tip.distance(point));
        }
        if before >= 0.0 && after <= 0.0 {
            take(self.beside(point));
        }
        if z >= self.end[1] {
            take(ProfileDistance { distance: outer, gradient: [1.0, 0.0] });
        } else if after > 0.0 {
            // Between the normals of the side and of the flank, the rim where they meet.
            take(ProfileArc { center: self.end, radius: 0.0 }.distance(point));
        }
        nearest
    }

    /// Returns the signed distance from the circle or the line of the side.
    fn beside(&self, point: [f64; 2]) -> ProfileDistance {
        match self.side {
            ProfileSide::Cone => ProfileDistance {
                distance: dot(minus(point, self.end), self.last),
                gradient: self.last,
            },
            ProfileSide::Arc(arc) => arc.distance(point),
        }
    }

    /// Returns the point `[rho, z]` that is farthest along a unit vector `[out, up]` with `out` at least 0.
    pub fn farthest(&self, direction: [f64; 2]) -> [f64; 2] {
        let [out, up] = direction;
        if up > 0.0 {
            return [self.end[0], self.top];
        }
        if dot(along(self.joint), direction) <= 0.0 {
            return self.tip.point(direction);
        }
        match self.side {
            ProfileSide::Arc(arc) if dot(along(self.last), direction) <= 0.0 => {
                arc.point([out, up])
            }
            _ => self.end,
        }
    }

    /// Returns the height of the underside at a distance from the axis of at most [`TangentProfile::radius`] \[mm\].
    pub fn height(&self, distance: f64) -> f64 {
        let below = self.joint();
        if distance <= below[0] {
            return self.tip.height(distance);
        }
        match self.side {
            ProfileSide::Arc(arc) => arc.center[1] - arc.radius + arc.height(distance),
            ProfileSide::Cone => {
                let [out, up] = along(self.last);
                below[1] + (distance - below[0]) * up / out
            }
        }
    }

    /// Returns the profile of a cutting end that lies outside by `by` everywhere \[mm\], or inside by `-by`, in its own
    /// coordinates: its tip lies `by` below the tip of this one. `None` if an arc has no such radius.
    ///
    /// Where side and flank meet at an angle, everything within `by` has a rounded rim. The profile has a sharp one: it
    /// goes on along the side.
    pub fn parallel(&self, by: f64) -> Option<Self> {
        let moved = |arc: ProfileArc| {
            let [rho, z] = arc.center;
            ProfileArc { center: [rho, z + by], radius: arc.radius + by }
        };
        let (tip, outer) = (moved(self.tip), self.end[0] + by);
        let (side, last, end) = match self.side {
            ProfileSide::Arc(arc) => {
                let arc = moved(arc);
                let out = ((outer - arc.center[0]) / arc.radius).min(1.0);
                let last = [out, -(1.0 - out * out).sqrt()];
                (ProfileSide::Arc(arc), last, [outer, arc.point(last)[1]])
            }
            ProfileSide::Cone => {
                let (from, [out, up]) = (tip.point(self.joint), along(self.last));
                let end = [outer, from[1] + (outer - from[0]) * up / out];
                (ProfileSide::Cone, self.last, end)
            }
        };
        let has_radii = tip.radius > 0.0
            && match side {
                ProfileSide::Arc(arc) => arc.radius > 0.0,
                ProfileSide::Cone => true,
            };
        let fits = has_radii && outer > tip.point(self.joint)[0];
        let top = self.top.max(end[1]);
        fits.then_some(Self { tip, joint: self.joint, side, last, end, top })
    }

    /// Returns the support function: the reach of the profile along a unit vector `[out, up]` \[mm\].
    pub fn extent(&self, direction: [f64; 2]) -> f64 {
        dot(self.farthest(direction), direction)
    }

    /// Returns the height of the point of the axis that is deepest inside \[mm\].
    pub fn deepest(&self) -> f64 {
        /// Halvings from metres to below the spacing of numbers.
        const STEPS: u32 = 60;
        let (mut low, mut high) = (0.0, self.top);
        for _ in 0..STEPS {
            // The distance is convex along the axis: it falls while tip or side is nearest, and not where flank or top is.
            let middle = 0.5 * (low + high);
            let falls = self.distance([0.0, middle]).gradient[1] < 0.0;
            if falls { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Cutter, CutterSpec, ProfilePiece};
    use super::*;
    use proptest::prelude::*;

    fn any_cutter() -> impl Strategy<Value = Cutter> {
        let taper = (0.2..3.0f64, 6.0..60.0f64, 0.5..9.0f64).prop_map(|(r, angle, more)| {
            CutterSpec::taper(r, angle.to_radians(), 2.0 * (r + more))
        });
        let barrel = (0.3..3.0f64, 20.0..400.0f64, 0.2..8.0f64)
            .prop_map(|(r, q, more)| CutterSpec::barrel(r, q, 2.0 * (r + more)));
        let conical = (0.3..3.0f64, 40.0..400.0f64, 5.0..45.0f64, 0.2..8.0f64).prop_map(
            |(r, q, angle, more)| {
                CutterSpec::conical_barrel(r, q, angle.to_radians(), 2.0 * (r + more))
            },
        );
        let lens = (20.0..300.0f64, 0.2..2.0f64, 0.5..8.0f64)
            .prop_map(|(big, r, more)| CutterSpec::lens(big, r, 2.0 * (r + more)));
        prop_oneof![taper, barrel, conical, lens]
            .prop_map(|spec| Cutter::new(CutterSpec { length: 150.0, ..spec }).unwrap())
    }

    /// Points along the outline, near each other.
    fn outline(cutter: &Cutter) -> Vec<[f64; 2]> {
        let top = cutter.length();
        let share = |k: u32| f64::from(k) / 4000.0;
        let mut points: Vec<_> = cutter
            .profile()
            .iter()
            .flat_map(|piece| (0..=4000).map(|k| piece.at(share(k))))
            .collect();
        points.extend((0..=4000).map(|k| [cutter.radius() * share(k), top]));
        points
    }

    proptest! {
        /// Against the nearest of many points of the outline, and the plane through the foot.
        #[test]
        fn the_distance_is_that_to_the_outline(
            cutter in any_cutter(), rho in 0.0..14.0f64, z in -6.0..160.0f64, low in any::<bool>(),
        ) {
            let profile = cutter.tangent_profile().unwrap();
            let point = [rho, if low { 0.2 * z } else { z }];
            let found = profile.distance(point);
            let outline = outline(&cutter);
            let away = |p: &[f64; 2]| (p[0] - point[0]).hypot(p[1] - point[1]);
            let sampled = outline.iter().map(away).fold(f64::INFINITY, f64::min);
            // 150 mm in 4000 steps: half a step across, where the point is near, is 0.02 mm.
            prop_assert!(found.distance.abs() <= sampled + 1e-9, "{found:?} {sampled}");
            prop_assert!(sampled - found.distance.abs() < 0.02, "{found:?} {sampled}");
            prop_assert!((found.gradient[0].hypot(found.gradient[1]) - 1.0).abs() < 1e-12);
            let reach = profile.extent([found.gradient[0].max(0.0), found.gradient[1]]);
            if found.gradient[0] >= 0.0 {
                prop_assert!((dot(point, found.gradient) - found.distance - reach).abs() < 1e-9);
            }
        }

        /// Nothing lies beyond the support function, and its point is on the outline.
        #[test]
        fn nothing_lies_beyond_the_extent(cutter in any_cutter(), angle in 0.0..std::f64::consts::PI) {
            let profile = cutter.tangent_profile().unwrap();
            let direction = [angle.sin(), -angle.cos()];
            let reach = profile.extent(direction);
            let most = outline(&cutter).iter().map(|p| dot(*p, direction)).fold(f64::MIN, f64::max);
            prop_assert!(most <= reach + 1e-9 && reach - most < 0.02, "{most} {reach}");
            prop_assert!(profile.distance(profile.farthest(direction)).distance.abs() < 1e-9);
        }

        /// The underside is the outline, whose lowest point at that distance it is.
        #[test]
        fn the_height_is_that_of_the_outline(cutter in any_cutter(), share in 0.0..1.0f64) {
            let profile = cutter.tangent_profile().unwrap();
            let distance = share * profile.radius();
            let point = [distance, profile.height(distance)];
            prop_assert!(profile.distance(point).distance.abs() < 1e-9, "{point:?}");
            prop_assert!(point[1] <= profile.flank_start() + 1e-9);
        }

        /// Parallel profiles outside hold everything within the distance, and those inside are held.
        #[test]
        fn parallel_profiles_are_that_far_away(
            cutter in any_cutter(), share in 0.0..1.0f64, angle in 0.0..std::f64::consts::FRAC_PI_2,
        ) {
            let (by, profile) = (0.15, cutter.tangent_profile().unwrap());
            let [outside, inside] = [by, -by].map(|by| profile.parallel(by).unwrap());
            let distance = share * profile.radius();
            // Any point of the underside, moved by the distance in any direction down or out.
            let moved = [distance + by * angle.sin(), profile.height(distance) - by * angle.cos()];
            let of = outside.distance([moved[0], moved[1] + by]).distance;
            prop_assert!(of < 1e-9, "{moved:?} is {of} outside");
            // Every point of the inner one is that deep inside.
            let within = share * inside.radius();
            let deep = profile.distance([within, inside.height(within) + by]).distance;
            prop_assert!(deep < 1e-9 - by, "{within} from the axis is {deep} deep");
        }

        /// Outward normals turn one way along the outline, and its pieces join.
        #[test]
        fn pieces_join_and_turn_one_way(cutter in any_cutter()) {
            let pieces = cutter.profile();
            for pair in pieces.windows(2) {
                let (end, start) = (pair[0].end(), pair[1].start());
                prop_assert!((end[0] - start[0]).hypot(end[1] - start[1]) < 1e-9, "{pieces:?}");
            }
            let way = |piece: &ProfilePiece, [a, b]: [f64; 2]| {
                let [from, to] = [piece.at(a), piece.at(b)];
                (to[1] - from[1]).atan2(to[0] - from[0])
            };
            let ways: Vec<f64> =
                pieces.iter().flat_map(|one| [way(one, [0.0, 0.01]), way(one, [0.99, 1.0])]).collect();
            prop_assert!(ways.windows(2).all(|pair| pair[1] >= pair[0] - 1e-6), "{ways:?}");
        }

        #[test]
        fn nowhere_on_the_axis_is_deeper_than_the_deepest_point(cutter in any_cutter()) {
            let profile = cutter.tangent_profile().unwrap();
            let least = profile.distance([0.0, profile.deepest()]).distance;
            for k in 0..300 {
                prop_assert!(profile.distance([0.0, 0.5 * f64::from(k)]).distance >= least - 1e-12);
            }
        }
    }

    #[test]
    fn a_barrel_is_tangent_to_tip_and_flank_by_pencil() {
        // Tip ball 2, barrel 82, diameter 20: (82 - 10) / (82 - 2) = 0.9, so the centre lies 80 sqrt(0.19) above that
        // of the tip.
        let spec = CutterSpec { length: 90.0, ..CutterSpec::barrel(2.0, 82.0, 20.0) };
        let profile = *Cutter::new(spec).unwrap().tangent_profile().unwrap();
        assert!((profile.flank_start() - (2.0 + 80.0 * 0.19_f64.sqrt())).abs() < 1e-12);
        assert!((profile.joint()[0] - 1.8).abs() < 1e-12);
        assert!((profile.tip_angle().sin() - 0.9).abs() < 1e-12);
        assert!((profile.radius() - 10.0).abs() < 1e-12);
    }

    /// Sampled, from the tip up to that height: no point of a lens lies outside the circle, and above it one does.
    #[test]
    fn a_lens_lies_inside_its_tip_circle_up_to_that_height() {
        for (tip, corner, diameter) in [(20.0, 1.5, 12.0), (101.0, 1.0, 22.0), (14.0, 2.0, 12.0)] {
            let spec = CutterSpec { length: 300.0, ..CutterSpec::lens(tip, corner, diameter) };
            let cutter = Cutter::new(spec).unwrap();
            let height = cutter.tangent_profile().unwrap().height_in_tip_circle();
            let beyond = |[rho, z]: [f64; 2]| rho.hypot(z - tip) - tip;
            let below = outline(&cutter).into_iter().filter(|point| point[1] <= height);
            assert!(below.map(beyond).fold(f64::MIN, f64::max) <= 1e-9);
            assert!(beyond([0.5 * diameter, height + 0.01]) > 0.0);
        }
        let taper = Cutter::new(CutterSpec::taper(2.0, 0.2, 12.0)).unwrap();
        let profile = taper.tangent_profile().unwrap();
        assert_eq!(profile.height_in_tip_circle().to_bits(), profile.joint()[1].to_bits());
    }

    #[test]
    fn a_lens_is_a_large_arc_with_a_corner_by_pencil() {
        // Radius 101, corner 1, diameter 22: the corner centre is 10 off the axis, sin = 0.1.
        let spec = CutterSpec { length: 60.0, ..CutterSpec::lens(101.0, 1.0, 22.0) };
        let profile = *Cutter::new(spec).unwrap().tangent_profile().unwrap();
        assert!((profile.joint()[0] - 10.1).abs() < 1e-12);
        assert!((profile.flank_start() - (101.0 - 100.0 * 0.99_f64.sqrt())).abs() < 1e-12);
        assert!((profile.distance([0.0, -1.0]).distance - 1.0).abs() < 1e-12);
    }
}
