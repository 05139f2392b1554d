//! Curves in space: the edges of faces, and the profiles of swept surfaces.

use super::model::MAX_CHAIN;
use super::model::Read;
use super::model::RecordFields;
use super::model::StepFrame;
use super::model::StepModel;
use super::model::loss;
use super::part21::StepInstance;
use crate::math;
use crate::math::bspline::KnotError;
use crate::math::bspline::KnotVector;
use crate::math::bspline::MAX_DEGREE;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Vector3;
use nalgebra::Vector4;
use std::f64::consts::TAU;

/// A curve with the parametrisation STEP gives it, except that lengths are mm and angles rad.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StepCurve {
    /// `origin + t direction`
    Line { origin: Point3<f64>, direction: Vector3<f64> },
    /// `a cos t`, `b sin t` along x and y; a circle if both are equal.
    Ellipse { frame: StepFrame, semi: [f64; 2] },
    /// `a cosh t`, `b sinh t`.
    Hyperbola { frame: StepFrame, semi: [f64; 2] },
    /// `f t^2`, `2 f t`.
    Parabola { frame: StepFrame, focal: f64 },
    /// B-spline, rational or not.
    Spline(Spline),
}

/// A B-spline curve in homogeneous coordinates `(w x, w y, w z, w)`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    pub(super) knots: KnotVector,
    pub(super) points: Vec<Vector4<f64>>,
}

impl Spline {
    /// Returns the point and the first derivative.
    fn jet(&self, t: f64) -> (Point3<f64>, Vector3<f64>) {
        let (first, basis) = self.knots.basis(t, 1);
        let local = self.points.get(first..=first + self.knots.degree()).unwrap_or_default();
        let sum = |row: usize| {
            local.iter().zip(&basis[row]).fold(Vector4::zeros(), |sum, (p, b)| sum + p * *b)
        };
        let (h, dh) = (sum(0), sum(1));
        // Quotient rule on the homogeneous curve: p = h / w, p' = (h' - p w') / w.
        let p = h.xyz() / h.w;
        (Point3::from(p), (dh.xyz() - p * dh.w) / h.w)
    }

    fn closed(&self, tolerance: f64) -> bool {
        let Interval { low, high } = self.knots.range();
        (self.jet(low).0 - self.jet(high).0).norm() <= tolerance
    }
}

impl StepCurve {
    pub(super) fn point(&self, t: f64) -> Point3<f64> {
        match self {
            Self::Line { origin, direction } => origin + direction * t,
            Self::Ellipse { frame, semi } => {
                frame.point(semi[0] * math::cos(t), semi[1] * math::sin(t), 0.0)
            }
            Self::Hyperbola { frame, semi } => {
                frame.point(semi[0] * math::cosh(t), semi[1] * math::sinh(t), 0.0)
            }
            Self::Parabola { frame, focal } => frame.point(focal * t * t, 2.0 * focal * t, 0.0),
            Self::Spline(spline) => spline.jet(t).0,
        }
    }

    /// Finds the parameter of the point of the curve at (or, for a slightly wrong file, near) `p`.
    fn parameter(&self, p: &Point3<f64>) -> f64 {
        match self {
            Self::Line { origin, direction } => {
                direction.dot(&(p - origin)) / direction.norm_squared()
            }
            Self::Ellipse { frame, semi } => {
                let q = frame.local(p);
                // Scaled to the unit circle, the parameter is the angle.
                math::atan2(q.y / semi[1], q.x / semi[0])
            }
            Self::Hyperbola { frame, semi } => (frame.local(p).y / semi[1]).asinh(),
            Self::Parabola { frame, focal } => frame.local(p).y / (2.0 * focal),
            Self::Spline(_) => self.nearest([0.0, 0.0], &|s, ds| (s - p, ds)),
        }
    }

    /// Returns the point and the first derivative.
    fn jet(&self, t: f64) -> (Point3<f64>, Vector3<f64>) {
        let slope = |frame: &StepFrame, x: f64, y: f64| frame.x.scale(x) + frame.y.scale(y);
        let tangent = match self {
            Self::Line { direction, .. } => *direction,
            Self::Ellipse { frame, semi } => {
                slope(frame, -semi[0] * math::sin(t), semi[1] * math::cos(t))
            }
            Self::Hyperbola { frame, semi } => {
                slope(frame, semi[0] * math::sinh(t), semi[1] * math::cosh(t))
            }
            Self::Parabola { frame, focal } => slope(frame, 2.0 * focal * t, 2.0 * focal),
            Self::Spline(spline) => return spline.jet(t),
        };
        (self.point(t), tangent)
    }

    /// Finds the parameter where the residual that `measure` makes of point and tangent is least:
    /// the best of `8 (degree + 1)` samples a polynomial piece (64 over `window` for a curve
    /// without end), then Gauss-Newton. The samples only have to distinguish one part of the curve
    /// from another: the points asked for lie on the curve, or on the surface it sweeps.
    pub(super) fn nearest(
        &self,
        window: [f64; 2],
        measure: &dyn Fn(Point3<f64>, Vector3<f64>) -> (Vector3<f64>, Vector3<f64>),
    ) -> f64 {
        const STEPS: usize = 32;
        let square = |t: f64| {
            let (s, ds) = self.jet(t);
            measure(s, ds).0.norm_squared()
        };
        let (mut best, mut least) = (window[0], f64::INFINITY);
        for t in self.samples(window) {
            let value = square(t);
            if value < least {
                (best, least) = (t, value);
            }
        }
        for _ in 0..STEPS {
            let (s, ds) = self.jet(best);
            let (r, dr) = measure(s, ds);
            // One unknown: the Gauss-Newton step is -(r' . r) / |r'|^2.
            let next = self.clamped(best - dr.dot(&r) / dr.norm_squared());
            let value = square(next);
            // The residual no longer falls: rounding, or a minimum at the end of the range.
            if value.is_nan() || value >= least {
                break;
            }
            (best, least) = (next, value);
        }
        best
    }

    fn clamped(&self, t: f64) -> f64 {
        match self {
            Self::Spline(spline) => {
                let Interval { low, high } = spline.knots.range();
                t.clamp(low, high)
            }
            _ => t,
        }
    }

    fn samples(&self, window: [f64; 2]) -> Vec<f64> {
        let even = |[a, b]: [f64; 2], count: usize| {
            (0..=count).map(move |i| a + (b - a) * ratio(i, count))
        };
        match self {
            Self::Spline(spline) => {
                // More samples than the square of the distance has extremes on a polynomial piece.
                let per_piece = 8 * (spline.knots.degree() + 1);
                let pieces = spline.knots.breaks().windows(2);
                pieces.flat_map(|pair| even([pair[0], pair[1]], per_piece)).collect()
            }
            Self::Ellipse { .. } => even([0.0, TAU], 64).collect(),
            _ => even(window, 64).collect(),
        }
    }

    /// Returns the period of the parameter, if the curve is closed.
    pub(super) fn period(&self, tolerance: f64) -> Option<f64> {
        match self {
            Self::Ellipse { .. } => Some(TAU),
            Self::Spline(spline) if spline.closed(tolerance) => {
                let Interval { low, high } = spline.knots.range();
                Some(high - low)
            }
            _ => None,
        }
    }

    /// Finds the parameters of `start` and `end` along the curve; a closed curve is followed
    /// forward, all the way round if both ends are one vertex.
    pub(super) fn range(&self, start: &Point3<f64>, end: &Point3<f64>, tolerance: f64) -> [f64; 2] {
        let same = (start - end).norm() <= tolerance;
        if let (Self::Spline(spline), true) = (self, same)
            && spline.closed(tolerance)
            && (spline.jet(spline.knots.range().low).0 - start).norm() <= tolerance
        {
            return spline.knots.range().ends();
        }
        let from = self.parameter(start);
        let to = self.parameter(end);
        match self.period(tolerance) {
            // One vertex at both ends of a closed curve: once round, not a point.
            Some(period) if same => [from, from + period],
            // The arc runs past the seam of the parameter.
            Some(period) if to <= from => [from, to + period],
            _ => [from, to],
        }
    }

    /// Returns the point at a parameter that may have run past the end of a closed spline.
    pub(super) fn point_around(&self, t: f64) -> Point3<f64> {
        match self {
            Self::Spline(spline) => {
                let Interval { low, high } = spline.knots.range();
                self.point(if t > high { t - (high - low) } else { t.max(low) })
            }
            _ => self.point(t),
        }
    }

    /// Returns parameters in `[from, to]` (either order) close enough for bisection between them to
    /// find every bend.
    pub(super) fn stations(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let even = |count: usize| -> Vec<f64> {
            (0..=count).map(|i| from + (to - from) * ratio(i, count)).collect()
        };
        match self {
            Self::Line { .. } => even(2),
            // At most 22.5 degrees each: an edge is at most one turn.
            Self::Ellipse { .. } | Self::Hyperbola { .. } | Self::Parabola { .. } => even(16),
            Self::Spline(spline) => {
                let Interval { low, high } = spline.knots.range();
                let breaks = spline.knots.breaks();
                // A closed spline may be followed past its end: its breaks repeat a period later.
                let again = breaks.iter().map(|knot| knot + (high - low));
                let inner = breaks.iter().copied().chain(again);
                let (a, b) = (from.min(to), from.max(to));
                let mut coarse = vec![a];
                coarse.extend(inner.filter(|&knot| a < knot && knot < b));
                coarse.push(b);
                coarse.dedup();
                let parts = spline.knots.degree().max(2);
                let mut fine = vec![a];
                for pair in coarse.windows(2) {
                    let step = (pair[1] - pair[0]) / parts as f64;
                    fine.extend((1..parts).map(|i| pair[0] + step * i as f64));
                    // To the last bit: a parameter past the end would run round a closed curve.
                    fine.push(pair[1]);
                }
                if from > to {
                    fine.reverse();
                }
                fine
            }
        }
    }
}

fn ratio(i: usize, count: usize) -> f64 {
    i as f64 / count as f64
}

impl<'a> StepModel<'a> {
    /// Reads a curve in space. Curves on surfaces give their curve in space, trimmed ones their
    /// basis: the ends come from the vertices.
    pub(super) fn curve(&self, id: u64, from: u64) -> Read<StepCurve> {
        self.curve_in(id, from, 0)
    }

    fn curve_in(&self, id: u64, from: u64, depth: usize) -> Read<StepCurve> {
        if depth > MAX_CHAIN {
            return loss(id, "the curve refers to itself");
        }
        let instance = self.instance(id, from)?;
        if let Some(spline) = self.spline_curve(instance)? {
            return Ok(StepCurve::Spline(spline));
        }
        let Some(fields) = Self::simple(instance) else {
            return loss(id, format!("{} is not a curve this reader knows", instance.kind()));
        };
        match fields.name {
            "LINE" => Ok(StepCurve::Line {
                origin: self.point(fields.reference(1)?, id)?,
                direction: self.vector(fields.reference(2)?, id)?,
            }),
            "CIRCLE" => {
                let radius = fields.radius(2, self)?;
                let frame = self.frame(fields.reference(1)?, id)?;
                Ok(StepCurve::Ellipse { frame, semi: [radius, radius] })
            }
            "ELLIPSE" => self.conic(fields).map(|(frame, semi)| StepCurve::Ellipse { frame, semi }),
            "HYPERBOLA" => {
                self.conic(fields).map(|(frame, semi)| StepCurve::Hyperbola { frame, semi })
            }
            "PARABOLA" => {
                let focal = fields.radius(2, self)?;
                Ok(StepCurve::Parabola { frame: self.frame(fields.reference(1)?, id)?, focal })
            }
            // All of them refer to a curve in space first; curves in parameters are not needed.
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" | "TRIMMED_CURVE" => {
                self.curve_in(fields.reference(1)?, id, depth + 1)
            }
            other => loss(id, format!("{other} is not a curve this reader knows")),
        }
    }

    fn conic(&self, fields: RecordFields<'a>) -> Read<(StepFrame, [f64; 2])> {
        let semi = [fields.radius(2, self)?, fields.radius(3, self)?];
        Ok((self.frame(fields.reference(1)?, fields.id)?, semi))
    }

    fn points(&self, ids: &[u64], from: u64) -> Read<Vec<Point3<f64>>> {
        ids.iter().map(|&id| self.point(id, from)).collect()
    }

    /// Reads a polyline or any kind of B-spline curve; `None` if it is something else.
    fn spline_curve(&self, instance: &'a StepInstance) -> Read<Option<Spline>> {
        let id = instance.id;
        if let Some(fields) = Self::part(instance, "POLYLINE") {
            let points = self.points(&fields.references(1)?, id)?;
            let knots = StepKnots::Even.expand(1, points.len(), id)?;
            return Ok(Some(spline(knots, &points, None)));
        }
        let complex = Self::part(instance, "B_SPLINE_CURVE");
        let names =
            ["B_SPLINE_CURVE_WITH_KNOTS", "BEZIER_CURVE", "QUASI_UNIFORM_CURVE", "UNIFORM_CURVE"];
        let Some(kind) = names.iter().find_map(|name| Self::part(instance, name)) else {
            return Ok(None);
        };
        // A simple entity has its label first; the parts of a complex one have none.
        let (base, skip) = complex.map_or((kind, 1), |base| (base, 0));
        let degree = base.count(skip)?;
        let points = self.points(&base.references(skip + 1)?, id)?;
        let knots = match kind.name {
            "B_SPLINE_CURVE_WITH_KNOTS" => {
                let first = if complex.is_some() { 0 } else { 6 };
                StepKnots::Given { counts: kind.counts(first)?, values: kind.numbers(first + 1)? }
            }
            "UNIFORM_CURVE" => StepKnots::Uniform,
            _ => StepKnots::Even,
        };
        let weights = match Self::part(instance, "RATIONAL_B_SPLINE_CURVE") {
            Some(fields) => Some(positive(&fields.numbers(0)?, points.len(), id)?),
            None => None,
        };
        let knots = knots.expand(degree, points.len(), id)?;
        Ok(Some(spline(knots, &points, weights.as_deref())))
    }
}

fn spline(knots: KnotVector, points: &[Point3<f64>], weights: Option<&[f64]>) -> Spline {
    let weight = |i: usize| weights.and_then(|w| w.get(i)).copied().unwrap_or(1.0);
    // (w x, w y, w z, w) for each point.
    let homogeneous = points.iter().enumerate().map(|(i, p)| p.coords.push(1.0) * weight(i));
    Spline { knots, points: homogeneous.collect() }
}

/// Checks weights, which must be as many as points and positive: else the curve leaves the hull of
/// its points, and may run to infinity.
pub(super) fn positive(weights: &[f64], count: usize, id: u64) -> Read<Vec<f64>> {
    if weights.len() != count {
        return loss(id, format!("{} weights for {count} control points", weights.len()));
    }
    if let Some(bad) = weights.iter().find(|weight| weight.is_nan() || **weight <= 0.0) {
        return loss(id, format!("weight {bad} is not positive"));
    }
    Ok(weights.to_vec())
}

/// Knots as a file states them.
#[derive(Debug, Clone)]
pub(super) enum StepKnots {
    /// Distinct values and how often each occurs.
    Given { counts: Vec<usize>, values: Vec<f64> },
    /// `-degree, ..., 0, 1, 2, ...`: not clamped.
    Uniform,
    /// Clamped and evenly spaced; a Bezier curve is the case without inner knots.
    Even,
}

impl StepKnots {
    /// Returns the full knot vector, checked.
    pub(super) fn expand(&self, degree: usize, points: usize, id: u64) -> Read<KnotVector> {
        if degree > MAX_DEGREE {
            return loss(id, KnotError::Degree { degree }.to_string());
        }
        // Quasi-uniform and Bezier knots are given by name only; the width of their equal spacing
        // does not change the curve in space.
        let full = match self {
            Self::Given { counts, values } => given(counts, values, degree + 1 + points, id)?,
            Self::Uniform => {
                (0..points.saturating_add(degree + 1)).map(|i| i as f64 - degree as f64).collect()
            }
            Self::Even => (0..points.saturating_add(degree + 1))
                .map(|i| i.clamp(degree, points.max(degree)) as f64 - degree as f64)
                .collect(),
        };
        KnotVector::new(degree, points, full).or_else(|faults| {
            let all: Vec<String> = faults.iter().map(ToString::to_string).collect();
            loss(id, all.join("; "))
        })
    }
}

fn given(counts: &[usize], values: &[f64], needed: usize, id: u64) -> Read<Vec<f64>> {
    // Checked before it is written out: a damaged multiplicity must not fill the memory.
    let total = counts.iter().fold(0_usize, |sum, &count| sum.saturating_add(count));
    if counts.len() != values.len() || total != needed {
        let (values, counts) = (values.len(), counts.len());
        return loss(
            id,
            format!(
                "{values} knots with {counts} multiplicities give {total} knots; {needed} are \
                 needed (control points + degree + 1)"
            ),
        );
    }
    let repeated = counts.iter().zip(values);
    Ok(repeated.flat_map(|(&count, &value)| std::iter::repeat_n(value, count)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle() -> StepCurve {
        let frame = StepFrame::new(Point3::new(1.0, 2.0, 3.0), Vector3::z_axis(), None);
        StepCurve::Ellipse { frame, semi: [5.0, 5.0] }
    }

    #[test]
    fn a_closed_curve_is_followed_forward() {
        let curve = circle();
        let (east, north) = (curve.point(0.0), curve.point(TAU / 4.0));
        let close = |range: [f64; 2], expected: [f64; 2]| {
            assert!((range[0] - expected[0]).abs() + (range[1] - expected[1]).abs() < 1e-14);
        };
        close(curve.range(&east, &north, 1e-6), [0.0, TAU / 4.0]);
        close(curve.range(&north, &east, 1e-6), [TAU / 4.0, TAU]);
        close(curve.range(&east, &east, 1e-6), [0.0, TAU]);
    }

    #[test]
    fn a_vertex_in_the_middle_of_a_spline_is_found() {
        let knots = StepKnots::Given { counts: vec![4, 1, 4], values: vec![0.0, 0.4, 1.0] };
        let knots = knots.expand(3, 5, 1).unwrap();
        let points: Vec<_> = (0..5)
            .map(|i| Point3::new(f64::from(i), f64::from(i * i) * 0.3, f64::from(i % 2)))
            .collect();
        let curve = StepCurve::Spline(spline(knots, &points, Some(&[1.0, 0.5, 2.0, 1.0, 1.0])));
        for t in [0.0, 0.123, 0.4, 0.77, 1.0] {
            assert!((curve.parameter(&curve.point(t)) - t).abs() < 1e-9);
        }
    }

    #[test]
    fn damaged_multiplicities_are_refused_before_they_are_written_out() {
        let knots = StepKnots::Given { counts: vec![usize::MAX, 4], values: vec![0.0, 1.0] };
        assert!(knots.expand(3, 4, 9).is_err());
    }
}
