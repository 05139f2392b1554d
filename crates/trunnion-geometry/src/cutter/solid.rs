//! The tool as convex solids of revolution.
//!
//! The signed distance from a convex solid is a convex function of the point, inside and outside.
//! Over a convex hull it is therefore largest at a corner, and nowhere below its tangent plane. The
//! bounds on a moving cutter's distance from a face rest on these two facts.

use super::profile::ProfilePiece;
use super::tangent::TangentProfile;
use super::validated::Cutter;
use crate::types::ToolPose;
use nalgebra::{Point3, Vector3};

/// A convex solid about the tool axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexSolid(SolidShape);

#[derive(Debug, Clone, Copy, PartialEq)]
enum SolidShape {
    Grown(GrownCone),
    Tangent(TangentProfile),
}

/// A truncated cone about the tool axis, grown by a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
struct GrownCone {
    /// `[rho, z]` of the rim below and above, before growing \[mm\].
    low: [f64; 2],
    high: [f64; 2],
    /// Radius of the ball \[mm\].
    rounding: f64,
    /// From the lower rim to the upper one \[mm\], and the square of its length.
    along: [f64; 2],
    square: f64,
    /// Outward normal of the slanted side.
    normal: [f64; 2],
}

impl GrownCone {
    fn new(low: [f64; 2], high: [f64; 2], rounding: f64) -> Self {
        let along = [high[0] - low[0], high[1] - low[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let length = square.sqrt();
        let normal =
            if length > 0.0 { [along[1] / length, -along[0] / length] } else { [1.0, 0.0] };
        Self { low, high, rounding, along, square, normal }
    }
}

/// Signed distance of a point from a solid, with its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignedDistance {
    /// Signed distance \[mm\], negative inside.
    pub distance: f64,
    /// Unit vector in which the distance grows fastest.
    pub gradient: Vector3<f64>,
}

impl SignedDistance {
    /// Returns the least value over some points of the plane through this distance at a point \[mm\].
    #[inline]
    pub fn least_over(&self, at: &Point3<f64>, points: &[Point3<f64>]) -> f64 {
        let over = |point: &Point3<f64>| self.gradient.dot(&(point - at));
        self.distance + points.iter().map(over).fold(f64::INFINITY, f64::min)
    }
}

/// A tool as convex solids: the cutting end with its flank, then shank and holder above.
///
/// The flat upper end of the flank is rounded too, so the tool is modelled larger there than it is.
///
/// # Example
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trunnion_geometry::cutter::{Cutter, CutterSpec, ToolBody};
/// use trunnion_geometry::types::ToolPose;
///
/// let tool = ToolBody::new(&Cutter::new(CutterSpec::bull(4.0, 3.0))?);
/// let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
/// // 1 mm below the tip, and 2 mm beside the flank.
/// assert_eq!(tool.end.distance(&Point3::new(0.0, 0.0, -1.0), &pose), 1.0);
/// assert_eq!(tool.end.distance(&Point3::new(9.0, 0.0, 8.0), &pose), 2.0);
/// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ToolBody {
    /// The cutting end with its flank.
    pub end: ConvexSolid,
    body: Vec<ConvexSolid>,
}

impl ToolBody {
    /// Divides a cutter into its convex solids.
    pub fn new(cutter: &Cutter) -> Self {
        let [major, minor] = [cutter.major(), cutter.minor()];
        let shank = cutter.spec().shank.first();
        // The flank ends where the shank begins.
        let top = shank.map_or(cutter.length(), |&[height, _]| height).max(minor);
        let end = match cutter.tangent_profile() {
            Some(profile) => ConvexSolid(SolidShape::Tangent(*profile)),
            None => ConvexSolid::grown([major, minor], [major, top], minor),
        };
        let top = cutter.tangent_profile().map_or(top, TangentProfile::top);
        // Horizontal shoulders are the discs of the solids below and above them.
        let above = cutter.profile().iter().filter_map(|piece| match *piece {
            ProfilePiece::Line { from, to } if from[1] >= top && to[1] > from[1] => {
                Some(ConvexSolid::grown(from, to, 0.0))
            }
            _ => None,
        });
        Self { end, body: above.collect() }
    }

    /// Returns all solids, the cutting end first.
    pub fn solids(&self) -> impl Iterator<Item = &ConvexSolid> {
        std::iter::once(&self.end).chain(&self.body)
    }
}

impl ConvexSolid {
    fn grown(low: [f64; 2], high: [f64; 2], rounding: f64) -> Self {
        Self(SolidShape::Grown(GrownCone::new(low, high, rounding)))
    }

    /// Returns the solids above a height: side and flank, shank and holder.
    pub fn above(cutter: &Cutter, bottom: f64) -> impl Iterator<Item = Self> {
        cutter.profile().iter().filter_map(move |piece| match *piece {
            ProfilePiece::Line { from, to } if to[1] > from[1].max(bottom) => {
                // A line that begins below the height is cut there.
                let up = ((bottom - from[1]) / (to[1] - from[1])).max(0.0);
                let low = [from[0] + up * (to[0] - from[0]), from[1].max(bottom)];
                Some(Self::grown(low, to, 0.0))
            }
            // The corner of a lens is the rim of a disc, grown by its radius. The side of a barrel is not: there the whole
            // cutting end stands for it.
            ProfilePiece::Arc { center, radius, from, .. } if from[0] > 0.0 => {
                let end = cutter.tangent_profile()?;
                if radius < end.tip_radius() {
                    Some(Self::grown(center, center, radius))
                } else {
                    Some(Self(SolidShape::Tangent(*end)))
                }
            }
            ProfilePiece::Arc { .. } | ProfilePiece::Line { .. } => None,
        })
    }

    /// Creates a ball about the tip of a pose.
    pub fn ball(radius: f64) -> Self {
        Self::grown([0.0; 2], [0.0; 2], radius)
    }

    /// Returns the signed distance of `point` from the solid at `pose` \[mm\].
    pub fn distance(&self, point: &Point3<f64>, pose: &ToolPose) -> f64 {
        let from_tip = point - pose.tip;
        let z = from_tip.dot(&pose.axis);
        // Pythagoras; on the axis rounding may make the square negative.
        let rho = (from_tip.norm_squared() - z * z).max(0.0).sqrt();
        self.section([rho, z]).0
    }

    /// Returns the largest diameter \[mm\].
    pub fn width(&self) -> f64 {
        match &self.0 {
            SolidShape::Grown(cone) => 2.0 * (cone.low[0].max(cone.high[0]) + cone.rounding),
            SolidShape::Tangent(profile) => 2.0 * profile.radius(),
        }
    }

    /// Returns about the radius at which a point passes under the cutter, the scale on which the
    /// rate of its distance changes \[mm\].
    pub fn bending_radius(&self) -> f64 {
        match &self.0 {
            // A sharp edge has none; then anything well below the width of the cutter serves.
            SolidShape::Grown(cone) => cone.rounding.max(0.05 * cone.low[0]),
            SolidShape::Tangent(profile) => profile.tip_radius().min(profile.radius()),
        }
    }

    /// Returns the radius of a ball that rolls inside along the rounded end \[mm\]: the corner radius, 0 at a sharp edge.
    pub fn inner_radius(&self) -> f64 {
        match &self.0 {
            SolidShape::Grown(cone) => cone.rounding,
            SolidShape::Tangent(profile) => profile.tip_radius().min(profile.radius()),
        }
    }

    /// Returns the signed distance of `point` from the solid at `pose`, with its gradient.
    pub fn gap(&self, point: &Point3<f64>, pose: &ToolPose) -> SignedDistance {
        let from_tip = point - pose.tip;
        let z = from_tip.dot(&pose.axis);
        let out = from_tip - pose.axis.scale(z);
        let rho = out.norm();
        let (distance, [by_rho, by_z]) = self.section([rho, z]);
        // On the axis the distance has a kink or does not change outward: 0 is a subgradient.
        let outward = if rho > 0.0 { out / rho } else { Vector3::zeros() };
        SignedDistance { distance, gradient: outward.scale(by_rho) + pose.axis.scale(by_z) }
    }

    /// Returns the signed distance of `point` from the plane square to `normal` that supports the
    /// solid: a lower bound on the distance from the solid, for any unit vector.
    ///
    /// Along a sharp edge the gradient is not continuous; there the face's own normal gives the
    /// better plane.
    pub fn plane(
        &self,
        point: &Point3<f64>,
        pose: &ToolPose,
        normal: Vector3<f64>,
    ) -> SignedDistance {
        let up = normal.dot(&pose.axis);
        let out = (1.0 - up * up).max(0.0).sqrt();
        let reach = match &self.0 {
            SolidShape::Grown(cone) => {
                // Support function: the farthest point of either rim along the normal, and the ball.
                let rim = |[rho, z]: [f64; 2]| rho * out + z * up;
                rim(cone.low).max(rim(cone.high)) + cone.rounding
            }
            SolidShape::Tangent(profile) => profile.extent([out, up]),
        };
        SignedDistance { distance: normal.dot(&(point - pose.tip)) - reach, gradient: normal }
    }

    /// Returns the distance in the half plane through the axis, and its gradient by `[rho, z]`.
    #[inline]
    fn section(&self, place: [f64; 2]) -> (f64, [f64; 2]) {
        match &self.0 {
            SolidShape::Grown(cone) => cone.section(place),
            SolidShape::Tangent(profile) => {
                let found = profile.distance(place);
                (found.distance, found.gradient)
            }
        }
    }
}

impl GrownCone {
    /// Returns the distance in the half plane through the axis, and its gradient by `[rho, z]`.
    #[inline]
    fn section(&self, place: [f64; 2]) -> (f64, [f64; 2]) {
        let [rho, z] = place;
        let Self { low, high, along, square, normal, .. } = *self;
        let from_low = [rho - low[0], z - low[1]];
        let away = from_low[0] * normal[0] + from_low[1] * normal[1];
        // Inside, the nearest of the three faces decides.
        let (below, above) = (low[1] - z, z - high[1]);
        let deepest = below.max(above).max(away);
        if deepest <= 0.0 {
            let flat = [0.0, if below >= above { -1.0 } else { 1.0 }];
            return (deepest - self.rounding, if away >= deepest { normal } else { flat });
        }
        // The nearest point of the boundary: of the flank, of the lower disc or of the upper one.
        let share = (from_low[0] * along[0] + from_low[1] * along[1]) / square;
        let t = if square > 0.0 { share.clamp(0.0, 1.0) } else { 0.0 };
        let off = |p: [f64; 2]| {
            let way = [rho - p[0], z - p[1]];
            (way[0] * way[0] + way[1] * way[1], way)
        };
        let nearer = |a: (f64, [f64; 2]), b: (f64, [f64; 2])| if b.0 < a.0 { b } else { a };
        let flank = off([low[0] + t * along[0], low[1] + t * along[1]]);
        let discs = nearer(off([rho.min(low[0]), low[1]]), off([rho.min(high[0]), high[1]]));
        let (square, way) = nearer(flank, discs);
        let distance = square.sqrt();
        (distance - self.rounding, way.map(|x| x / distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::CutterSpec;
    use nalgebra::Unit;

    fn tool(shank: Vec<[f64; 2]>) -> ToolBody {
        let spec = CutterSpec { length: 60.0, shank, ..CutterSpec::of_radii(4.0, 3.0) };
        ToolBody::new(&Cutter::new(spec).unwrap())
    }

    #[test]
    fn distances_from_a_standing_cutter_by_pencil() {
        let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
        let tool = tool(vec![[30.0, 12.0], [40.0, 12.0]]);
        let at = |x: f64, z: f64| tool.end.distance(&Point3::new(x, 0.0, z), &pose);
        for (x, z, expected) in
            [(0.0, -1.0, 1.0), (9.0, 8.0, 2.0), (8.0, 0.0, 2.0), (7.0, 3.0, 0.0), (0.0, 1.0, -1.0)]
        {
            assert!((at(x, z) - expected).abs() < 1e-12, "{x} {z}: {}", at(x, z));
        }
        let above = |x: f64, z: f64| tool.body[0].distance(&Point3::new(x, 0.0, z), &pose);
        assert!((above(5.0, 28.0) - 2.0).abs() < 1e-12 && (above(10.0, 35.0) + 2.0).abs() < 1e-12);
    }

    /// Corners of lenses of many sizes: above the tip arc no solid comes down to it.
    #[test]
    fn what_is_above_the_tip_arc_of_a_lens_keeps_off_its_tip() {
        let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
        for k in 0..2000 {
            let corner = 0.1 + 0.001 * f64::from(k);
            let (tip, diameter) = (12.0 + 0.37 * f64::from(k % 97), 2.0 * corner + 9.0);
            let spec = CutterSpec { length: 60.0, ..CutterSpec::lens(tip, corner, diameter) };
            let cutter = Cutter::new(spec).unwrap();
            let joint = cutter.cutting_height();
            for solid in ConvexSolid::above(&cutter, joint) {
                let clear = solid.distance(&Point3::origin(), &pose);
                assert!(clear > 0.5 * joint, "{tip} {corner} {diameter}: {clear} of {joint}");
            }
        }
    }

    /// Convexity as it is used: nowhere below the tangent plane at any place.
    #[test]
    fn no_distance_lies_below_a_tangent_plane() {
        let axis = Unit::new_normalize(Vector3::new(0.3, -0.2, 0.9));
        let pose = ToolPose { tip: Point3::new(1.0, 2.0, 3.0), axis };
        let grid = |i: u32| {
            let at = |k: u32| f64::from((i / 7_u32.pow(k)) % 7) * 4.1 - 12.0;
            Point3::new(at(0), at(1), at(2))
        };
        let others = [
            CutterSpec::taper(1.5, 0.3, 12.0),
            CutterSpec::barrel(1.5, 40.0, 12.0),
            CutterSpec::conical_barrel(1.5, 60.0, 0.4, 12.0),
            CutterSpec::lens(30.0, 1.5, 12.0),
        ];
        let others = others.map(|spec| ToolBody::new(&Cutter::new(spec).unwrap()));
        let bull = tool(vec![[10.0, 5.0], [20.0, 12.0]]);
        for solid in bull.solids().chain(others.iter().flat_map(ToolBody::solids)) {
            for p in (0..343).map(grid) {
                let gap = solid.gap(&p, &pose);
                assert!((gap.distance - solid.distance(&p, &pose)).abs() < 1e-12);
                assert!(gap.gradient.norm() <= 1.0 + 1e-12);
                for q in (0..343).map(grid) {
                    let plane = gap.distance + gap.gradient.dot(&(q - p));
                    let distance = solid.distance(&q, &pose);
                    assert!(distance >= plane - 1e-9, "{solid:?} {p} {q}");
                    let any = solid.plane(&q, &pose, (p - Point3::origin()).normalize());
                    assert!(distance >= any.distance - 1e-9, "{solid:?} {p} {q}");
                }
            }
        }
    }
}
