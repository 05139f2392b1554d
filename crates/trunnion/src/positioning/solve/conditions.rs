//! Constraints of a cutter location, with derivatives by `x = (w, alpha, theta)`.

use crate::math;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::distance::circle::{ErrorCircle, ErrorExtremum, ErrorSample};
use crate::positioning::distance::disc::FlatDisc;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::request::{AxisCone, ToleranceBand};
use crate::positioning::solve::placement::{EndPointFrame, TorusPlacement};
use crate::positioning::surface_point::SurfacePoint;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Intervals of front and rear. The error of the front is close to a polynomial of degree four,
/// whose slope changes sign at most three times; that of the rear to two waves of a cosine.
pub(crate) const COARSE: [u32; 2] = [10, 12];

/// Intervals after a dense measurement found an extremum that the coarse sampling missed.
pub(crate) const FINE: [u32; 2] = [24, 64];

/// Share of the arc over which the slope at an end point is differenced: the truncation is of
/// the same relative size, the rounding 1e-13 mm / 1e-4.
const END_STEP: f64 = 1e-4;

/// The chord may take this share of the circle's diameter; at the diameter itself the height of
/// the arc has no derivative. Costs 0.1 % of the width where nothing else limits it.
pub(crate) const CHORD: f64 = 0.999;

/// Share of half the arc beyond which the condition of a maximum is counted in proportion to its
/// distance from the end point, where the error is given: value and derivatives vanish there like
/// that distance.
pub(crate) const AT_END: f64 = 0.9;

/// A condition on a cutter location: kept where `value >= 0`, else broken \[mm\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct StripCondition {
    pub(crate) kind: ActiveConstraint,
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 3],
    /// Angle on the circle it belongs to, from the middle of the arc \[rad\].
    pub(crate) psi: f64,
    /// The extremum it belongs to, if to one.
    pub(crate) sample: Option<ErrorSample>,
    /// Contact of the cutter once the value is 0.
    pub(crate) contact: Option<SurfacePoint>,
}

/// Source of the extrema of the error round the circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ExtremaSource {
    /// Sampling round the circle.
    Sampled,
    /// The extrema of the state before, each followed; samples are kept for later proofs.
    Followed,
}

/// The problem to be solved at one end point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StripProblem {
    pub(crate) frame: EndPointFrame,
    /// The band the solver works in.
    pub(crate) band: ToleranceBand,
    pub(crate) axis_cone: Option<AxisCone>,
    /// Intervals of front and rear that are sampled.
    pub(crate) intervals: [u32; 2],
    /// Source of the extrema of a state.
    pub(crate) extrema: ExtremaSource,
}

/// End of the strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StripEnd {
    /// The first end point, at the angle `-half_arc`.
    First,
    /// The second end point, at the angle `half_arc`.
    Second,
}

impl StripEnd {
    /// Returns the sign of the end's angle.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::First => -1.0,
            Self::Second => 1.0,
        }
    }

    /// Returns the constraint on the slope of the error at the end.
    fn slope(self) -> ActiveConstraint {
        match self {
            Self::First => ActiveConstraint::FirstSlope,
            Self::Second => ActiveConstraint::SecondSlope,
        }
    }
}

/// A placement and all its conditions.
#[derive(Debug, Clone)]
pub(crate) struct ProblemState {
    pub(crate) placement: TorusPlacement,
    pub(crate) conditions: Vec<StripCondition>,
    /// Samples read round the circle, over `[-pi, pi]` in no order; none unless extrema are followed.
    pub(crate) samples: Vec<ErrorSample>,
}

impl ProblemState {
    /// Returns the breach of the worst condition \[mm\]; 0 where all hold.
    pub(crate) fn breach(&self) -> f64 {
        self.conditions.iter().fold(0.0, |worst, c| (-c.value).max(worst))
    }

    /// Returns the condition with the least value.
    pub(crate) fn tightest(&self) -> ActiveConstraint {
        self.conditions
            .iter()
            .min_by(|a, b| a.value.total_cmp(&b.value))
            .map_or(ActiveConstraint::Touch, |condition| condition.kind)
    }
}

impl StripProblem {
    /// Returns the breach that conditions may have \[mm\].
    pub(crate) fn margin(&self) -> f64 {
        self.band.margin()
    }

    /// Evaluates everything at `x`; `None` where the cutter cannot be placed.
    pub(crate) fn state(
        &self,
        x: [f64; 3],
        probe: &mut FaceProbe,
        near: Option<&ProblemState>,
    ) -> Result<Option<ProblemState>, PositioningError> {
        let Some(placement) = self.placement(x, probe, near)? else { return Ok(None) };
        let front = self.circle(&placement).front(
            placement.half_arc,
            self.intervals[0],
            &self.frame.first,
            probe,
        )?;
        let conditions = vec![self.chord(&placement)];
        let samples =
            if self.extrema == ExtremaSource::Followed { front.clone() } else { Vec::new() };
        let mut state = ProblemState { placement, conditions, samples };
        if let (Some(first), Some(last)) = (front.first(), front.last()) {
            for (sample, end) in [(first, StripEnd::First), (last, StripEnd::Second)] {
                let slope = self.end_slope(&state.placement, sample, end, probe)?;
                state.conditions.extend(slope);
            }
            self.front(&mut state, &front, probe)?;
            self.rear(&mut state, [first, last], probe)?;
        }
        self.disc(&state.placement, &mut state.conditions, probe)?;
        self.axis(&state.placement, &mut state.conditions);
        Ok(Some(state))
    }

    /// Returns the circle of a placement.
    pub(crate) fn circle(&self, placement: &TorusPlacement) -> ErrorCircle {
        ErrorCircle { ring: placement.ring, minor: self.frame.minor }
    }

    /// Places the cutter, the second end point sought from where it was before.
    pub(crate) fn placement(
        &self,
        x: [f64; 3],
        probe: &mut FaceProbe,
        near: Option<&ProblemState>,
    ) -> Result<Option<TorusPlacement>, PositioningError> {
        let guess = near.map(|state| {
            let from = &state.placement;
            let step =
                self.frame.direction(x[1]) * x[0] - self.frame.direction(from.x[1]) * from.x[0];
            from.second.ahead(&step)
        });
        self.frame.place(x, probe, guess)
    }

    pub(crate) fn chord(&self, placement: &TorusPlacement) -> StripCondition {
        StripCondition {
            kind: ActiveConstraint::Chord,
            value: CHORD * self.frame.major - placement.half_chord,
            gradient: placement.chord_gradient().map(|rate| -rate),
            psi: 0.0,
            sample: None,
            contact: None,
        }
    }

    /// Returns the condition that the error must not rise from an end point into the strip.
    pub(crate) fn end_slope(
        &self,
        placement: &TorusPlacement,
        sample: &ErrorSample,
        end: StripEnd,
        probe: &mut FaceProbe,
    ) -> Result<Option<StripCondition>, PositioningError> {
        let half = placement.half_arc;
        let value = end.sign() * sample.slope * half;
        // The slope times half the arc is a length, comparable with the other conditions.
        // Far from level it binds nothing: four times the slope of a parabola as deep as the band.
        if value > 8.0 * (self.band.upper - self.band.lower) {
            return Ok(None);
        }
        let share = end.sign() * (1.0 - END_STEP);
        let inside = self.circle(placement).read_from(share * half, sample, probe)?;
        // At the end point the error is given whatever x, so that the derivative of the slope is a
        // difference quotient of gradients over END_STEP of the half arc, the first of them 0.
        let gradient = placement.arc_gradient(share, &inside).map(|g| -g / END_STEP);
        Ok(Some(StripCondition {
            kind: end.slope(),
            value,
            gradient,
            psi: sample.psi,
            sample: None,
            contact: None,
        }))
    }

    /// Adds the conditions of the extrema between the end points, sampled by `front`.
    fn front(
        &self,
        state: &mut ProblemState,
        front: &[ErrorSample],
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let ProblemState { placement, conditions, samples } = state;
        let circle = self.circle(placement);
        let extrema = circle.extrema(front, probe)?;
        if self.extrema == ExtremaSource::Followed {
            samples.extend(extrema.iter().map(|extremum| extremum.sample));
        }
        for extremum in &extrema {
            let share = extremum.sample.psi / placement.half_arc;
            // A maximum right at an end point is as high as the slope there makes it, which has a
            // condition of its own.
            if !(extremum.maximum && share.abs() > 1.0 - END_STEP) {
                conditions.push(self.inside(placement, extremum));
            }
        }
        Ok(())
    }

    /// Returns the condition of an extremum between the end points.
    pub(crate) fn inside(
        &self,
        placement: &TorusPlacement,
        extremum: &ErrorExtremum,
    ) -> StripCondition {
        let sample = extremum.sample;
        let psi = sample.psi;
        let share = psi / placement.half_arc;
        let gradient = placement.arc_gradient(share, &sample);
        let (kind, value, gradient) = if extremum.maximum {
            let scale = (1.0 - AT_END) / (1.0 - share.abs()).clamp(END_STEP, 1.0 - AT_END);
            let value = scale * (self.band.upper - extremum.value);
            (ActiveConstraint::Middle, value, gradient.map(|g| -scale * g))
        } else {
            (ActiveConstraint::Touch, extremum.value - self.band.lower, gradient)
        };
        let contact = (!extremum.maximum).then(|| SurfacePoint::from(&sample.reading.foot));
        StripCondition { kind, value, gradient, psi, sample: Some(sample), contact }
    }

    /// Returns the condition of a minimum of the rest of the circle.
    pub(crate) fn outside(
        &self,
        placement: &TorusPlacement,
        extremum: &ErrorExtremum,
    ) -> StripCondition {
        let sample = extremum.sample;
        StripCondition {
            kind: ActiveConstraint::Rear,
            value: extremum.value - self.band.lower,
            gradient: placement.gradient(&sample.at, &sample.reading.normal()),
            psi: sample.psi,
            sample: Some(sample),
            contact: Some(SurfacePoint::from(&sample.reading.foot)),
        }
    }

    /// Adds the conditions of the minima outside the strip, whose ends are `first` and `last`.
    fn rear(
        &self,
        state: &mut ProblemState,
        [first, last]: [&ErrorSample; 2],
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let ProblemState { placement, conditions, samples } = state;
        let circle = self.circle(placement);
        let mut rear = vec![*last];
        rear.extend(circle.rear(placement.half_arc, self.intervals[1], last, probe)?);
        // The first end point once more, a full turn later, closes the rear.
        rear.push(ErrorSample { psi: first.psi + TAU, ..*first });
        let extrema = circle.extrema(&rear, probe)?;
        let inner = rear.get(1..rear.len() - 1).unwrap_or_default();
        let kept = if self.extrema == ExtremaSource::Followed { usize::MAX } else { 0 };
        let read = inner.iter().chain(extrema.iter().map(|extremum| &extremum.sample));
        samples.extend(read.take(kept).map(|sample| {
            // Samples are kept over [-pi, pi].
            let turn = if sample.psi > PI { TAU } else { 0.0 };
            ErrorSample { psi: sample.psi - turn, ..*sample }
        }));
        let minima = extrema.iter().filter(|extremum| !extremum.maximum);
        conditions.extend(minima.map(|extremum| self.outside(placement, extremum)));
        Ok(())
    }

    /// Adds the condition of the disc inside the circle, where the surface is convex below it.
    pub(crate) fn disc(
        &self,
        placement: &TorusPlacement,
        conditions: &mut Vec<StripCondition>,
        probe: &mut FaceProbe,
    ) -> Result<(), PositioningError> {
        let disc = FlatDisc {
            center: placement.pose(self.frame.minor).tip,
            axis: placement.axis,
            radius: self.frame.major,
        };
        let ends = [&self.frame.first, &placement.second];
        let centre = disc.middle(ends[0], probe)?;
        if let Some((point, reading)) = disc.lowest(&centre, &ends, probe)? {
            conditions.push(StripCondition {
                kind: ActiveConstraint::Disc,
                value: reading.distance - self.band.lower,
                gradient: placement.gradient(&point, &reading.normal()),
                psi: 0.0,
                sample: None,
                contact: Some(SurfacePoint::from(&reading.foot)),
            });
        }
        Ok(())
    }

    pub(crate) fn axis(&self, placement: &TorusPlacement, conditions: &mut Vec<StripCondition>) {
        let Some(near) = self.axis_cone else { return };
        // Arc on a circle of the cutter's size: comparable with the other conditions.
        let (sin, cos) = math::sin_cos(near.max_turn);
        let scale = self.frame.major / sin.max(f64::EPSILON);
        conditions.push(StripCondition {
            kind: ActiveConstraint::AxisTurn,
            value: scale * (placement.axis.dot(&near.axis) - cos),
            gradient: placement.axis_gradient(&near.axis).map(|rate| scale * rate),
            psi: 0.0,
            sample: None,
            contact: None,
        });
    }
}

/// Returns the normal curvature of the offset surface at distance `lift` in `direction`; `None` where the
/// offset surface has no such side (the cutter's corner is larger than the concave radius).
pub(crate) fn offset_curvature(
    reading: &DistanceReading,
    direction: &Vector3<f64>,
    lift: f64,
) -> Option<f64> {
    let curvature = reading.normal_curvature(direction);
    // Curvature of the parallel surface: k / (1 - k d).
    let left = 1.0 - curvature * lift;
    (left > 0.0).then(|| curvature / left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;

    use crate::cutter::CutterSpec;
    use crate::positioning::ContactSide;
    use crate::positioning::LocationRequest;
    use crate::positioning::StripSide;
    use crate::surface::Face;
    use crate::surface::FaceIndex;
    use crate::surface::NurbsSurface;
    use crate::surface::Surface;
    use crate::types::{Interval, Uv};
    use nalgebra::Point3;
    use nalgebra::UnitVector3;
    use nalgebra::Vector3;

    /// z = (k1 x^2 + k2 y^2) / 2 over a square of side 120.
    fn quadric(k1: f64, k2: f64) -> FaceIndex {
        let square = |i: usize| if i == 1 { -3600.0 } else { 3600.0 };
        let place = |i: usize| [-60.0, 0.0, 60.0][i];
        let point = |i, j| Point3::new(place(i), place(j), 0.5 * (k1 * square(i) + k2 * square(j)));
        let points = (0..3).map(|i| (0..3).map(|j| point(i, j)).collect()).collect();
        let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let surface = NurbsSurface::new([2, 2], [knots(), knots()], points, None).unwrap();
        FaceIndex::new(Face::new(1, Surface::Nurbs(surface), vec![]).unwrap()).unwrap()
    }

    /// Central differences of every condition against its derivative.
    fn check(
        k: [f64; 2],
        strip: StripSide,
        side: ContactSide,
        x: [f64; 3],
    ) -> Vec<ActiveConstraint> {
        let face = quadric(k[0], k[1]);
        let cutter =
            Cutter::new(CutterSpec { length: 100.0, ..CutterSpec::bull(9.0, 4.0) }).unwrap();
        let band = ToleranceBand { lower: 0.0, upper: 0.02 };
        let request = LocationRequest {
            strip,
            side,
            offset_range: Interval::new(-0.5, 0.5),
            ..LocationRequest::new(&face, &cutter, band, Uv::new(0.45, 0.52), [0.2, 1.0])
        };
        let mut probe = FaceProbe::new(&face);
        let frame = EndPointFrame::new(&request, side, &mut probe).unwrap();
        let axis = UnitVector3::new_normalize(Vector3::new(0.05, 0.02, 1.0));
        let axis_cone = Some(AxisCone { axis, max_turn: 0.3 });
        let problem = StripProblem {
            frame,
            band,
            axis_cone,
            intervals: COARSE,
            extrema: ExtremaSource::Sampled,
        };
        let at = problem.state(x, &mut probe, None).unwrap().unwrap();
        for (entry, h) in [1e-4, 1e-5, 1e-5].into_iter().enumerate() {
            let mut moved = |step: f64| {
                let mut x = x;
                x[entry] += step;
                problem.state(x, &mut probe, Some(&at)).unwrap().unwrap()
            };
            let (low, high) = (moved(-h), moved(h));
            assert_eq!(low.conditions.len(), high.conditions.len());
            for ((a, b), c) in low.conditions.iter().zip(&high.conditions).zip(&at.conditions) {
                let slope = (b.value - a.value) / (2.0 * h);
                let size = c.gradient.iter().map(|g| g.abs()).fold(0.02, f64::max);
                // The slope at an end point is differenced over 1e-4 of the arc.
                let wrong = (slope - c.gradient[entry]).abs() / size;
                assert!(wrong < 1e-3, "{:?} {entry}: {slope} {:?}", c.kind, c.gradient);
            }
        }
        at.conditions.iter().map(|condition| condition.kind).collect()
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let mut seen = Vec::new();
        for strip in [StripSide::Right, StripSide::Left] {
            for side in [ContactSide::Ahead, ContactSide::Behind] {
                seen.extend(check([0.002, 0.006], strip, side, [8.0, 0.1, 0.06]));
                seen.extend(check([0.006, 0.002], strip, side, [12.0, -0.2, 0.04]));
                seen.extend(check([-0.01, -0.02], strip, side, [5.0, 0.2, -0.05]));
            }
        }
        for kind in [
            ActiveConstraint::Chord,
            ActiveConstraint::FirstSlope,
            ActiveConstraint::SecondSlope,
            ActiveConstraint::Touch,
            ActiveConstraint::Middle,
            ActiveConstraint::Rear,
            ActiveConstraint::Disc,
            ActiveConstraint::AxisTurn,
        ] {
            assert!(seen.contains(&kind), "{kind:?} was never checked");
        }
    }
}
