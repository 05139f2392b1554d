//! Elementary surfaces through samples of points and normals.
//!
//! Every fit is linear, by singular values, so that samples of an exact surface give it to
//! rounding; of other samples it gives something, which the proof refuses.

use super::sample::NetSample;
use crate::import::step::model::StepFrame;
use crate::import::step::shape::StepShape;
use crate::math;
use nalgebra::DMatrix;
use nalgebra::DVector;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Singular values below this share of the largest leave a solution undetermined: samples have
/// about 1e-16, and solutions with half of these digits are refused by any useful tolerance.
const SINGULAR: f64 = 1e-9;

/// Cosine of the cap \[75 deg\] that a net on a sphere may fill and still have its poles away from
/// it: samples lie inside its rim.
const CAP: f64 = 0.26;

pub(super) fn plane(samples: &[NetSample], middle: &NetSample) -> Option<StepShape> {
    let across = samples.first()?.point - middle.point;
    let x = UnitVector3::try_new(across, f64::MIN_POSITIVE);
    Some(StepShape::Plane(StepFrame::new(middle.point, middle.normal, x)))
}

/// Fits a sphere from `|p|^2 = 2 p . c + (R^2 - |c|^2)`. Poles lie off the net where that can be.
pub(super) fn sphere(samples: &[NetSample], middle: &NetSample) -> Option<StepShape> {
    let rows = samples.iter().map(|s| {
        // About a sample, so that squares keep their digits.
        let p = s.point - middle.point;
        ([p.x, p.y, p.z], p.norm_squared())
    });
    let (centre, radius) = round(rows)?;
    let origin = middle.point + Vector3::from(centre);
    let frame = level(samples, &origin, middle).or_else(|| banded(samples, &origin, middle))?;
    Some(StepShape::Sphere { frame, radius })
}

/// Chooses axes with the middle of the samples at u = pi, v = 0, where v runs about as it does on
/// the net: no pole is near, if the samples lie within a cap.
fn level(samples: &[NetSample], origin: &Point3<f64>, middle: &NetSample) -> Option<StepFrame> {
    let outs = || samples.iter().filter_map(|s| (s.point - origin).try_normalize(0.0));
    let out = UnitVector3::try_new(outs().sum::<Vector3<f64>>(), f64::MIN_POSITIVE)?;
    // Beyond the cap a sample could come near a pole, 90 degrees from the middle.
    if outs().any(|other| other.dot(&out) < CAP) {
        return None;
    }
    let along = middle.tangents[1];
    let up = along - out.scale(along.dot(&out));
    Some(StepFrame::new(*origin, UnitVector3::try_new(up, f64::MIN_POSITIVE)?, Some(-out)))
}

/// Finds axes round which the net turns by one of its parameters.
fn banded(samples: &[NetSample], origin: &Point3<f64>, middle: &NetSample) -> Option<StepFrame> {
    let around = |k: usize| {
        let ways = samples.iter().filter_map(|s| s.tangents[k].try_normalize(0.0));
        let ways: Vec<[f64; 3]> = ways.map(|t| [t.x, t.y, t.z]).collect();
        let axis = Vector3::from(null(&ways)?);
        // Circles round an axis have tangents square to it: any part along it rules this parameter
        // out.
        let off = ways.iter().map(|t| Vector3::from(*t).dot(&axis).abs()).fold(0.0, f64::max);
        (off <= SINGULAR).then_some((axis, middle.tangents[1 - k]))
    };
    let (axis, along) = around(0).or_else(|| around(1))?;
    let axis = towards(axis, &along)?;
    let back = UnitVector3::try_new(origin - middle.point, f64::MIN_POSITIVE);
    Some(StepFrame::new(*origin, axis, back))
}

/// Fits a cylinder: its axis is square to all normals.
pub(super) fn cylinder(samples: &[NetSample], middle: &NetSample) -> Option<StepShape> {
    let normals: Vec<Vector3<f64>> = samples.iter().map(|s| s.normal.into_inner()).collect();
    let axis = Vector3::from(null(&normals.iter().map(|n| [n.x, n.y, n.z]).collect::<Vec<_>>())?);
    let frame = across(middle, towards(axis, &middle.tangents[1])?);
    let rows = samples.iter().map(|s| {
        let q = frame.local(&s.point);
        ([q.x, q.y], q.x * q.x + q.y * q.y)
    });
    let ([x, y], radius) = round(rows)?;
    let frame = about(&frame, frame.point(x, y, 0.0), middle);
    Some(StepShape::Cylinder { frame, radius })
}

/// Fits a cone: all normals make one angle with the axis, and all tangent planes meet in the apex.
pub(super) fn cone(samples: &[NetSample], middle: &NetSample) -> Option<StepShape> {
    let count = samples.len() as f64;
    let mean = samples.iter().map(|s| s.normal.into_inner()).sum::<Vector3<f64>>() / count;
    // Equal angles to the axis: differences of normals are square to it.
    let off = samples.iter().map(|s| s.normal.into_inner() - mean).map(|n| [n.x, n.y, n.z]);
    let axis = Vector3::from(null(&off.collect::<Vec<_>>())?);
    let rows = samples.iter().map(|s| {
        let n = s.normal;
        // Tangent plane through the apex a: n . a = n . p.
        ([n.x, n.y, n.z], n.dot(&(s.point - middle.point)))
    });
    let apex = middle.point + Vector3::from(least_squares(rows)?);
    let from_apex = samples.iter().map(|s| s.point - apex).sum::<Vector3<f64>>() / count;
    let axis = towards(axis, &from_apex)?;
    // The normals stand at the half angle to the plane across the axis.
    let angle = math::asin(mean.dot(&axis).abs().clamp(0.0, 1.0));
    let height = from_apex.dot(&axis);
    let frame = about(&StepFrame::new(apex, axis, None), apex + axis.scale(height), middle);
    (angle > 0.0 && angle < FRAC_PI_2).then_some(StepShape::Cone {
        frame,
        radius: height * math::tan(angle),
        angle,
    })
}

/// Fits a torus: all normals meet the axis. With `b = o x a` for its direction `a` and a point `o`
/// of it, `(p x n) . a + n . b = 0` (Plücker).
pub(super) fn torus(samples: &[NetSample], middle: &NetSample) -> Option<StepShape> {
    let size = samples.iter().map(|s| (s.point - middle.point).norm()).fold(0.0, f64::max);
    let rows: Vec<[f64; 6]> = samples
        .iter()
        .map(|s| {
            let n = s.normal.into_inner();
            // In units of the size, so that both halves of a row are of order 1.
            let moment = ((s.point - middle.point) / size).cross(&n);
            [moment.x, moment.y, moment.z, n.x, n.y, n.z]
        })
        .collect();
    let [ax, ay, az, bx, by, bz] = null(&rows)?;
    let (a, b) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
    // Point of the line closest to the middle: a x (o x a) / |a|^2 = o for o square to a.
    let origin = middle.point + a.cross(&b) * (size / a.norm_squared());
    let frame = StepFrame::new(origin, UnitVector3::try_new(a, f64::MIN_POSITIVE)?, None);
    let rows = samples.iter().map(|s| {
        let q = frame.local(&s.point);
        let rho = math::hypot(q.x, q.y);
        ([rho, q.z], rho * rho + q.z * q.z)
    });
    let ([major, height], minor) = round(rows)?;
    let frame = about(&frame, frame.point(0.0, 0.0, height), middle);
    // A spindle torus meets its axis: the bound of the proof does not hold for it.
    (major > minor).then_some(StepShape::Torus { frame, major, minor })
}

/// Returns axes at a sample with z along `axis`.
fn across(middle: &NetSample, axis: UnitVector3<f64>) -> StepFrame {
    StepFrame::new(middle.point, axis, None)
}

/// Returns axes at `origin` with the z axis given and the middle of the samples at u = pi, far from
/// the seam.
fn about(frame: &StepFrame, origin: Point3<f64>, middle: &NetSample) -> StepFrame {
    let back = UnitVector3::try_new(origin - middle.point, f64::MIN_POSITIVE);
    StepFrame::new(origin, frame.z, back)
}

/// Directs a line's axis the way that `along` points.
fn towards(axis: Vector3<f64>, along: &Vector3<f64>) -> Option<UnitVector3<f64>> {
    let axis = UnitVector3::try_new(axis, f64::MIN_POSITIVE)?;
    Some(if axis.dot(along) < 0.0 { -axis } else { axis })
}

/// Fits centre and radius to coordinates and their squared norms.
fn round<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> Option<([f64; N], f64)> {
    let rows: Vec<([f64; N], f64)> = rows.collect();
    // Unknowns (c, R^2 - |c|^2): columns 2 x and 1.
    let matrix = DMatrix::from_fn(rows.len(), N + 1, |i, j| {
        rows.get(i).map_or(0.0, |(x, _)| x.get(j).map_or(1.0, |x| 2.0 * x))
    });
    let right = DVector::from_iterator(rows.len(), rows.iter().map(|(_, square)| *square));
    let solution = solve(matrix, &right)?;
    let mut centre = [0.0; N];
    centre.iter_mut().zip(solution.iter()).for_each(|(to, from)| *to = *from);
    let square = solution.iter().next_back()? + centre.iter().map(|x| x * x).sum::<f64>();
    (square > 0.0 && square.is_finite()).then(|| (centre, square.sqrt()))
}

fn least_squares<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> Option<[f64; N]> {
    let rows: Vec<([f64; N], f64)> = rows.collect();
    let matrix = DMatrix::from_fn(rows.len(), N, |i, j| rows[i].0[j]);
    let right = DVector::from_iterator(rows.len(), rows.iter().map(|(_, value)| *value));
    let solution = solve(matrix, &right)?;
    let mut found = [0.0; N];
    found.iter_mut().zip(solution.iter()).for_each(|(to, from)| *to = *from);
    Some(found)
}

fn solve(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    if matrix.nrows() < matrix.ncols() || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let parts = matrix.svd(true, true);
    let least = SINGULAR * parts.singular_values.max();
    // Samples on a line or a circle leave a centre undetermined.
    if parts.singular_values.min() <= least {
        return None;
    }
    parts.solve(right, least).ok()
}

/// Returns the unit vector on which all rows are closest to zero: the last right singular vector.
fn null<const N: usize>(rows: &[[f64; N]]) -> Option<[f64; N]> {
    if rows.len() < N || !rows.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let matrix = DMatrix::from_fn(rows.len(), N, |i, j| rows[i][j]);
    let parts = matrix.svd(false, true);
    let row = parts.singular_values.imin();
    let all = parts.v_t?;
    let mut found = [0.0; N];
    found.iter_mut().zip(all.row(row).iter()).for_each(|(to, from)| *to = *from);
    Some(found)
}
