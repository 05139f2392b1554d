//! Flank, shank and holder: everything above the cutting end.

use crate::cutter::ConvexSolid;
use crate::math;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::request::ToleranceBand;
use crate::positioning::strip::CuttingContext;
use crate::surface::SolidProximity;
use crate::types::{ToolPose, Uv};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Queries after which a body that could not be proven clear counts as touching.
const QUERIES: u32 = 400;

/// Below this share of the cutter's radius the flank of a flat cutter is its edge, which the
/// circle answers for.
const EDGE: f64 = 0.125;

/// Share of the band by which the arc of a barrel may come nearer than it allows.
const CONTACT_ROOM: f64 = 1e-2;

/// Sectors into which the flank is cut where a sphere around the axis does not clear it.
const SECTORS: u32 = 12;

/// Proves that the tool above its cutting end keeps `band.lower` from the whole face.
///
/// The distance `D` of a point from the face clears the sphere of radius `D` around it. Where the
/// sphere around the middle of a segment of the axis holds that segment of the tool, it is clear; else
/// the segment is halved, and where it is shorter than wide, cut into sectors. Beside a spline surface the pieces of
/// the surface are compared with the tool instead.
/// Unlike the circle's, these distances are to the nearest point over the box of the face's trims.
///
/// Returns the number of closest-point queries.
///
/// # Errors
///
/// [`PositioningError::Body`], [`PositioningError::Closest`].
pub fn body_clear(
    setting: &CuttingContext,
    pose: &ToolPose,
    uv: Uv,
) -> Result<u32, PositioningError> {
    let mut probe = FaceProbe::new(setting.face);
    check_body(setting, pose, uv, &mut probe)?;
    Ok(probe.queries)
}

pub(crate) fn check_body(
    setting: &CuttingContext,
    pose: &ToolPose,
    uv: Uv,
    probe: &mut FaceProbe,
) -> Result<(), PositioningError> {
    let cutter = setting.cutter;
    if cutter.is_barrel() && setting.face.distance_over_box(&pose.tip).is_none() {
        // Its arc touches far from the tip, which may come down to the face as well as the flank. Where it does touch,
        // it is as near as the band allows: without some room nothing is proven there.
        let ToleranceBand { lower, upper } = setting.band;
        let band = ToleranceBand { lower: lower - CONTACT_ROOM * (upper - lower), upper };
        let setting = &CuttingContext { band, ..*setting };
        return BodyCheck { setting, pose, uv, limit: 0 }.check_solids(0.0);
    }
    let bottom = match cutter.tangent_profile() {
        // Of a barrel that touches a face with distances in closed form, what is above its arc.
        Some(profile) if cutter.is_barrel() => profile.flank_start(),
        // What lies inside the circle of the tip arc is as clear as the whole circle, which is proven by its centre.
        Some(profile) => profile.height_in_tip_circle(),
        None => cutter.cutting_height().max(EDGE * cutter.radius()),
    };
    let body = BodyCheck { setting, pose, uv, limit: probe.queries + QUERIES };
    let mut stretches = vec![[bottom, cutter.length()]];
    while let Some(stretch) = stretches.pop() {
        let [low, high] = stretch;
        if high <= low {
            continue;
        }
        let radius = body.widest(stretch);
        let middle = 0.5 * (low + high);
        // Radius of the sphere around the middle that holds the cylinder over the stretch.
        let needed = math::hypot(radius, 0.5 * (high - low));
        let centre = pose.tip + pose.axis.scale(middle);
        // Boxes show it soonest where all is far away; near the face the solids themselves decide.
        if setting.face.clear_of(&centre, needed + setting.band.lower) {
            continue;
        }
        if setting.face.distance_over_box(&centre).is_none() {
            return body.check_solids(bottom);
        }
        let free = body.free(centre, middle, needed, probe)?;
        if free >= needed {
            continue;
        }
        if high - low > radius {
            stretches.extend([[low, middle], [middle, high]]);
        } else {
            body.sectors(stretch, radius, probe)?;
        }
    }
    Ok(())
}

struct BodyCheck<'a> {
    setting: &'a CuttingContext<'a>,
    pose: &'a ToolPose,
    uv: Uv,
    limit: u32,
}

impl BodyCheck<'_> {
    /// Proves that all of the tool above `bottom` is clear; where neither this nor the contrary is proven, it counts as
    /// touching.
    fn check_solids(&self, bottom: f64) -> Result<(), PositioningError> {
        let CuttingContext { face, cutter, band } = self.setting;
        for solid in ConvexSolid::above(cutter, bottom) {
            let gap = |p: &Point3<f64>| {
                let gap = solid.gap(p, self.pose);
                (gap.distance, gap.gradient)
            };
            match face.meets(&gap, band.lower) {
                SolidProximity::Clear => {}
                SolidProximity::Undecided => {
                    return Err(PositioningError::Body {
                        uv: self.uv,
                        height: bottom,
                        clearance: 0.0,
                    });
                }
                SolidProximity::Nearer(p) => {
                    let height = (p - self.pose.tip).dot(&self.pose.axis);
                    let clearance = gap(&p).0 - band.lower;
                    return Err(PositioningError::Body { uv: self.uv, height, clearance });
                }
            }
        }
        Ok(())
    }

    /// Returns the largest radius of the profile over an interval of heights.
    fn widest(&self, [low, high]: [f64; 2]) -> f64 {
        let mut radius = 0.0_f64;
        for piece in self.setting.cutter.profile() {
            let ([rho0, z0], [rho1, z1]) = (piece.start(), piece.end());
            if z1 >= low && z0 <= high {
                radius = radius.max(rho0).max(rho1);
            }
        }
        radius
    }

    /// Returns the radius of a sphere around `p` that keeps off the face, the largest one if it is not as
    /// large as `needed`.
    fn free(
        &self,
        p: Point3<f64>,
        height: f64,
        needed: f64,
        probe: &mut FaceProbe,
    ) -> Result<f64, PositioningError> {
        let lower = self.setting.band.lower;
        // The sum, less `lower` again, may be below `needed` by its rounding.
        let enough = (needed + lower) * (1.0 + 4.0 * f64::EPSILON);
        let distance = probe.nearest(&p, enough, self.uv)? - lower;
        if probe.queries > self.limit {
            let clearance = distance;
            return Err(PositioningError::Body { uv: self.uv, height, clearance });
        }
        Ok(distance)
    }

    fn sectors(
        &self,
        stretch: [f64; 2],
        radius: f64,
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let axis = self.pose.axis;
        let side = axis.iamin();
        let mut across = Vector3::zeros();
        across[side] = 1.0;
        let one = UnitVector3::new_normalize(axis.cross(&across));
        let two = axis.cross(&one);
        let step = TAU / f64::from(SECTORS);
        let mut cells: Vec<([f64; 2], [f64; 2])> = (0..SECTORS)
            .map(|k| (stretch, [step * f64::from(k), step * f64::from(k + 1)]))
            .collect();
        while let Some(([low, high], [from, to])) = cells.pop() {
            let (height, angle) = (0.5 * (low + high), 0.5 * (from + to));
            let (sin, cos) = math::sin_cos(angle);
            let out = one.scale(cos) + two * sin;
            let p = self.pose.tip + axis.scale(height) + out * radius;
            let [tall, wide] = [high - low, radius * (to - from)];
            // Half the diagonal of the patch, unrolled: no point of it is farther from its middle.
            let needed = 0.5 * math::hypot(tall, wide);
            let free = self.free(p, height, needed, probe)?;
            if free >= needed {
                continue;
            }
            // A point of the body lies in the face, or nearer than the band allows.
            if free <= 0.0 {
                let uv = self.uv;
                return Err(PositioningError::Body { uv, height, clearance: free });
            }
            // Halve the longer side, so that patches stay about square.
            if tall > wide {
                cells.extend([([low, height], [from, to]), ([height, high], [from, to])]);
            } else {
                cells.extend([([low, high], [from, angle]), ([low, high], [angle, to])]);
            }
        }
        Ok(())
    }
}
