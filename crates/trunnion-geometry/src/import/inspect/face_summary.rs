//! Area, extent, tightest hollow and mean normal of a face, by quadrature.

use super::quadrature::{self, QuadratureNode};
use crate::surface::Face;
use crate::types::{Interval, Uv};
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// One line of the table of faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FaceSummary {
    /// Number for a job file.
    pub number: usize,
    /// Kind of surface.
    pub kind: &'static str,
    /// Ranges of u and v the trims leave \[knot parameter, mm or rad\].
    pub range: [Interval; 2],
    /// Opposite corners of the box around the trimmed face \[mm\].
    pub bounds: [Point3<f64>; 2],
    /// Area of the trimmed face \[mm²\], by quadrature; good to about 1e-3.
    pub area: f64,
    /// Radius \[mm\] of the tightest hollow on the cutter's side, found at the quadrature's nodes;
    /// `None` where the face is nowhere hollow. A ball of a larger radius cannot reach it.
    pub concave_radius: Option<f64>,
    /// Mean unit normal on the cutter's side; `None` where the face faces all ways alike.
    pub normal: Option<UnitVector3<f64>>,
    /// `true` if trims cut anything off the surface's own range (of an endless surface they always
    /// do).
    pub trimmed: bool,
}

/// A small piece of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AreaElement {
    /// Parameters.
    pub uv: Uv,
    /// Point of the face \[mm\].
    pub point: Point3<f64>,
    /// Its area times the unit normal on the cutter's side \[mm²\].
    pub area: Vector3<f64>,
}

/// Returns elements that cover the trimmed face. Sums over them are integrals over the face, such
/// as `sum of |area|`, or `sum of point . area / 3`, a closed shell's volume.
///
/// # Example
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trunnion_geometry::import::inspect;
/// use trunnion_geometry::surface::{Face, SphereSurface, Surface, SurfaceFrame};
///
/// let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x())?;
/// let ball = Face::new(1, Surface::Sphere(SphereSurface::new(frame, 1.0)?), vec![])?;
/// let volume: f64 =
///     inspect::elements(&ball).iter().map(|e| e.point.coords.dot(&e.area) / 3.0).sum();
/// assert!((volume - 4.0 / 3.0 * std::f64::consts::PI).abs() < 1e-6);
/// # Ok::<(), trunnion_geometry::surface::SurfaceError>(())
/// ```
pub fn elements(face: &Face) -> Vec<AreaElement> {
    elements_at(face, &quadrature::nodes(face))
}

fn elements_at(face: &Face, nodes: &[QuadratureNode]) -> Vec<AreaElement> {
    let element = |node: &QuadratureNode| {
        let jet = face.surface.jet1(node.uv[0], node.uv[1]);
        let side = if face.flip { -node.weight } else { node.weight };
        // dA = S_u x S_v du dv: the weight is the area in parameters.
        AreaElement { uv: node.uv.into(), point: jet.s, area: jet.su.cross(&jet.sv) * side }
    };
    nodes.iter().map(element).collect()
}

/// Measures area, extent, tightest hollow and mean normal of a face.
pub fn summary(face: &Face) -> FaceSummary {
    let nodes = quadrature::nodes(face);
    let elements = elements_at(face, &nodes);
    let area = elements.iter().map(|element| element.area.norm()).sum();
    // The vector area: 0 for a closed surface, as long as the area for a plane.
    let mean = elements.iter().fold(Vector3::zeros(), |sum, element| sum + element.area);
    let towards = |node: &QuadratureNode| {
        let curvature = face.surface.jet2(node.uv[0], node.uv[1]).curvature()?;
        // Hollow is positive curvature towards the cutter; on the other side signs change.
        Some(if face.flip { -curvature.min } else { curvature.max })
    };
    let hollow = nodes.iter().filter_map(towards).fold(0.0, f64::max);
    let covered = nodes.iter().map(|node| node.weight).sum();
    FaceSummary {
        number: face.number,
        kind: face.surface.kind(),
        range: face.bounds().map(Interval::from),
        bounds: bounds(face, &nodes),
        area,
        concave_radius: hollow_radius(hollow, area),
        normal: mean_normal(&mean, area),
        trimmed: trimmed(face, covered),
    }
}

/// Returns the radius of a hollow \[mm\], `None` if it is no deeper than rounding.
fn hollow_radius(curvature: f64, area: f64) -> Option<f64> {
    // Rounding leaves a curvature of about 1e-12 / size on a plane. Over a chord of length l a
    // sphere sags by l^2 / (8 r): a hollow of less than 1e-9 mm over the whole face is none.
    (curvature * area > 8e-9).then(|| 1.0 / curvature)
}

/// Returns the direction of the vector area `mean`, unless this is only rounding and quadrature
/// error.
fn mean_normal(mean: &Vector3<f64>, area: f64) -> Option<UnitVector3<f64>> {
    UnitVector3::try_new(*mean, 1e-3 * area)
}

fn trimmed(face: &Face, covered: f64) -> bool {
    /// Share of a range covered whole that the quadrature may miss.
    const MISSED: f64 = 1e-6;
    let [u, v] = face.surface.domain();
    let whole = (u.high - u.low) * (v.high - v.low);
    let complete = whole.is_finite() && covered >= whole * (1.0 - MISSED);
    !face.loops.is_empty() && !complete
}

/// A point of a face with its parameters.
type PlacedPoint = ([f64; 2], Point3<f64>);

/// Returns the box of rims and nodes, each side pushed out to the extreme along the rim and inside.
fn bounds(face: &Face, nodes: &[QuadratureNode]) -> [Point3<f64>; 2] {
    let placed = |uv: [f64; 2]| (uv, face.point(uv[0], uv[1]));
    let rims: Vec<Vec<PlacedPoint>> = quadrature::rims(face)
        .iter()
        .map(|rim| quadrature::dense(face, rim, RIM_CHORDS).into_iter().map(placed).collect())
        .collect();
    let inner: Vec<PlacedPoint> = nodes.iter().map(|node| placed(node.uv)).collect();
    let side = |sign: f64| {
        Point3::from([0, 1, 2].map(|k| {
            let all = inner.iter().chain(rims.iter().flatten());
            let top = all.max_by(|a, b| (sign * a.1[k]).total_cmp(&(sign * b.1[k])));
            // Inside the face the gradient of the coordinate vanishes at an extreme: found from the
            // best node.
            let inside = top.map(|(uv, _)| extreme(face, k, sign, *uv));
            let along = rims.iter().filter_map(|rim| along_rim(face, rim, k, sign));
            sign * along.chain(inside).fold(f64::NEG_INFINITY, f64::max)
        }))
    };
    [side(-1.0), side(1.0)]
}

/// Chords a rim is divided into per range of the face.
const RIM_CHORDS: f64 = 64.0;

/// Finds the largest `sign * coordinate k` along a rim: the best corner, then golden sections on both chords beside it.
fn along_rim(face: &Face, rim: &[PlacedPoint], k: usize, sign: f64) -> Option<f64> {
    const SECTIONS: usize = 40;
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let corner = |at: &usize| sign * rim[*at].1[k];
    let best = (0..rim.len()).max_by(|a, b| corner(a).total_cmp(&corner(b)))?;
    let mut largest = corner(&best);
    for neighbour in [best.checked_sub(1), Some(best + 1)].into_iter().flatten() {
        let (Some((a, _)), Some((b, _))) = (rim.get(best), rim.get(neighbour)) else { continue };
        let at = |t: f64| {
            let [u, v] = [0, 1].map(|k| a[k] + t * (b[k] - a[k]));
            sign * face.point(u, v)[k]
        };
        let (mut low, mut high) = (0.0, 1.0);
        // Golden section search: 0.618^40 leaves 4e-9 of the chord.
        for _ in 0..SECTIONS {
            let (x, y) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            if at(x) < at(y) {
                low = x;
            } else {
                high = y;
            }
        }
        largest = largest.max(at(0.5 * (low + high)));
    }
    Some(largest)
}

/// Finds the largest `sign * coordinate k` from `start` by Newton's method inside the face.
fn extreme(face: &Face, k: usize, sign: f64, start: [f64; 2]) -> f64 {
    const STEPS: usize = 8;
    let (mut best, mut uv) = (sign * face.point(start[0], start[1])[k], start);
    for _ in 0..STEPS {
        let jet = face.surface.jet2(uv[0], uv[1]);
        // Newton's method for the zero of the gradient of coordinate k, by Cramer's rule.
        let determinant = jet.suu[k] * jet.svv[k] - jet.suv[k] * jet.suv[k];
        let du = -(jet.svv[k] * jet.su[k] - jet.suv[k] * jet.sv[k]) / determinant;
        let dv = -(jet.suu[k] * jet.sv[k] - jet.suv[k] * jet.su[k]) / determinant;
        let next = [uv[0] + du, uv[1] + dv];
        if !face.contains(next[0], next[1]) {
            break;
        }
        let value = sign * face.point(next[0], next[1])[k];
        // Also where a vanishing determinant made it NaN.
        if value.is_nan() || value <= best {
            break;
        }
        (best, uv) = (value, next);
    }
    best
}
