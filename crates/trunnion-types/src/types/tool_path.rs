//! Cutter locations and the curves through them, in the workpiece frame.

use super::uv::Uv;
use crate::math::Interval;
use crate::math::angle::angle_between;
use crate::math::spline::cubic_spline;
use nalgebra::{Point3, SVector, UnitVector3, Vector3};

/// Tool tip and tool-axis direction, both in the workpiece frame (a *cutter location*).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Tool tip \[mm\].
    pub tip: Point3<f64>,
    /// Unit vector from the tip towards the spindle.
    pub axis: UnitVector3<f64>,
}

impl ToolPose {
    /// Creates a pose from a tip \[mm\] and a vector along the tool axis, of any length.
    ///
    /// Returns `None` if that vector is zero, or a number is not finite.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_types::types::ToolPose;
    ///
    /// let pose = ToolPose::new([0.0, 0.0, 50.0], [0.0, 3.0, 4.0]).ok_or("a pose")?;
    /// assert_eq!(pose.axis.z, 0.8);
    /// assert!(ToolPose::new([0.0; 3], [0.0; 3]).is_none());
    /// # Ok::<(), &str>(())
    /// ```
    pub fn new(tip: [f64; 3], axis: [f64; 3]) -> Option<Self> {
        // By its largest component first: squares of very long or short vectors leave the range.
        let size = axis.iter().fold(0.0_f64, |size, part| size.max(part.abs()));
        let finite = tip.iter().chain(&axis).all(|number| number.is_finite());
        let scaled = Vector3::from(axis.map(|part| part / size));
        let axis = UnitVector3::try_new(scaled, 0.0).filter(|_| finite && size > 0.0)?;
        Some(Self { tip: Point3::from(tip), axis })
    }
}

/// A cutter location of a pass, and the point of the surface it was made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Pose of the tool.
    pub pose: ToolPose,
    /// Cutter contact: the surface point whose speed is the feed "at the contact" \[mm\].
    pub contact: Point3<f64>,
}

/// While the tool turns about its contact, the path parameter still advances by this part of the
/// tip's or the lever's movement, so that nothing runs more than 8 times as fast as the parameter.
const PIVOT_SHARE: f64 = 0.125;

impl Station {
    /// Returns the advance of the path parameter to the next station \[mm\].
    ///
    /// It is the chord of the contact track. Where the contact stands still, it is a share of the tip's
    /// chord, or of `lever` \[mm/rad\] times the turn of the axis. It is zero only if nothing moves.
    pub fn advance(&self, next: &Self, lever: f64) -> f64 {
        // The contact track leads; where it stands still a share of the other motions keeps the parameter
        // increasing.
        let turn = angle_between(&self.pose.axis, &next.pose.axis);
        let tip = (next.pose.tip - self.pose.tip).norm();
        (next.contact - self.contact).norm().max(PIVOT_SHARE * tip.max(lever * turn))
    }

    /// Returns tip, unit axis and contact in the order of [`PoseCoordinates`].
    pub fn coordinates(&self) -> PoseCoordinates {
        let [p, a, c] = [self.pose.tip.coords, self.pose.axis.into_inner(), self.contact.coords];
        PoseCoordinates::from([p.x, p.y, p.z, a.x, a.y, a.z, c.x, c.y, c.z])
    }
}

/// Purpose of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Air move at the clearance height; the only motion in which the tool turns freely.
    Link,
    /// Air move from one pass to the next in one sweep, close to the part.
    Hop,
    /// From the clearance height down to the start of a pass.
    LeadIn,
    /// Cutting.
    Cut,
    /// From the end of a pass back up to the clearance height.
    LeadOut,
}

impl Motion {
    /// Returns `true` for air moves, in which the axes may move at rapid.
    pub fn is_free(self) -> bool {
        matches!(self, Self::Link | Self::Hop)
    }
}

/// One pass over a face: cutter locations in cutting order and the strip they leave finished.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// Number of the face.
    pub face: usize,
    /// Cutter locations, at least two.
    pub stations: Vec<Station>,
    /// Strip width at each station \[mm\].
    pub widths: Vec<f64>,
    /// End-point track in the face's parameters, one point per station.
    pub track: Vec<Uv>,
}

/// Consecutive cutter locations with one kind of motion. Consecutive legs share their end poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Kind of motion.
    pub motion: Motion,
    /// Cutter locations, at least two. A `Link` has exactly two: only its ends are prescribed.
    pub stations: Vec<Station>,
}

/// Tip (0..3), tool-axis vector, not necessarily unit (3..6), and contact point (6..9).
pub type PoseCoordinates = SVector<f64, 9>;

/// Polynomial piece of a [`PoseCurve`]: `sum coefficients[k] (u - start)^k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseSpan {
    /// Ascending coefficients, up to degree 5 \[mm per u^k, 1 per u^k\].
    pub coefficients: [PoseCoordinates; 6],
}

/// Piecewise polynomial curve of tip, tool axis and contact over a parameter `u`, close to the
/// arc length of the contact track \[mm\].
#[derive(Debug, Clone, PartialEq)]
pub struct PoseCurve {
    /// Increasing break points of `u`; one more than `spans`.
    pub knots: Vec<f64>,
    /// One polynomial between two break points.
    pub spans: Vec<PoseSpan>,
}

/// Derivatives 0..=3 of tip, tool-axis vector and contact by the curve parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseRates {
    /// Tip and its derivatives \[mm per u^k\].
    pub tip: [Vector3<f64>; 4],
    /// Tool-axis vector, not necessarily unit, and its derivatives.
    pub axis: [Vector3<f64>; 4],
    /// Contact point and its derivatives \[mm per u^k\].
    pub contact: [Vector3<f64>; 4],
}

impl PoseCurve {
    /// Fits the C2 cubic spline through `stations`, over the sum of [`Station::advance`].
    ///
    /// Neighbouring stations must differ, and there must be two or more; otherwise the curve has
    /// no spans, or its coefficients are not numbers (`toolpath` checks before it calls).
    pub fn through(stations: &[Station], lever: f64) -> Self {
        let mut end = 0.0;
        let mut knots = vec![end];
        for pair in stations.windows(2) {
            end += pair[0].advance(&pair[1], lever);
            knots.push(end);
        }
        // Tip, axis vector and contact are interpolated as one vector, over the same knots.
        let points: Vec<PoseCoordinates> = stations.iter().map(Station::coordinates).collect();
        let spans = cubic_spline(&knots, &points)
            .into_iter()
            .map(|[a, b, c, d]| {
                let none = PoseCoordinates::zeros();
                PoseSpan { coefficients: [a, b, c, d, none, none] }
            })
            .collect();
        Self { knots, spans }
    }

    /// Returns the first and last value of the parameter.
    pub fn range(&self) -> Interval {
        match (self.knots.first(), self.knots.last()) {
            (Some(&first), Some(&last)) => Interval::new(first, last),
            _ => Interval::point(0.0),
        }
    }

    /// Returns the index of the span that holds `u`; ends are clamped.
    pub fn span_at(&self, u: f64) -> usize {
        let after = self.knots.partition_point(|&knot| knot <= u);
        after.saturating_sub(1).min(self.spans.len().saturating_sub(1))
    }

    /// Returns [`PoseCurve::span_at`] by steps from a span that is likely to be near.
    pub fn span_near(&self, u: f64, near: usize) -> usize {
        let last = self.spans.len().saturating_sub(1);
        let begins_by = |span: usize| self.knots.get(span).is_some_and(|&knot| knot <= u);
        let mut span = near.min(last);
        while span < last && begins_by(span + 1) {
            span += 1;
        }
        while span > 0 && !begins_by(span) {
            span -= 1;
        }
        span
    }

    /// Returns value and derivatives at `u`; outside the range the end polynomial goes on.
    pub fn rates(&self, u: f64) -> PoseRates {
        self.rates_in(self.span_at(u), u)
    }

    /// Returns [`PoseCurve::rates`] of a given span: at a knot the two sides may differ.
    #[inline]
    pub fn rates_in(&self, span: usize, u: f64) -> PoseRates {
        let start = self.knots.get(span).copied().unwrap_or(0.0);
        // Rows 0 to 2 are the tip, 3 to 5 the axis vector, 6 to 8 the contact.
        let d =
            self.spans.get(span).map_or([SVector::zeros(); 4], |span| span.derivatives(u - start));
        let part = |first: usize| d.map(|row| row.fixed_rows::<3>(first).into_owned());
        PoseRates { tip: part(0), axis: part(3), contact: part(6) }
    }

    /// Returns the tool pose at `u`; `None` where the axis vector vanishes.
    pub fn pose(&self, u: f64) -> Option<ToolPose> {
        self.pose_in(self.span_at(u), u)
    }

    /// Returns [`PoseCurve::pose`] of a given span.
    pub fn pose_in(&self, span: usize, u: f64) -> Option<ToolPose> {
        let start = self.knots.get(span).copied().unwrap_or(0.0);
        let value = self.spans.get(span)?.value(u - start);
        // The axis vector of a spline is not a unit vector between stations.
        let axis = UnitVector3::try_new(value.fixed_rows::<3>(3).into_owned(), f64::MIN_POSITIVE)?;
        Some(ToolPose { tip: Point3::from(value.fixed_rows::<3>(0).into_owned()), axis })
    }
}

impl PoseRates {
    /// Returns the pose itself; `None` where the axis vector vanishes.
    pub fn pose(&self) -> Option<ToolPose> {
        let axis = UnitVector3::try_new(self.axis[0], f64::MIN_POSITIVE)?;
        Some(ToolPose { tip: Point3::from(self.tip[0]), axis })
    }
}

impl PoseSpan {
    /// Returns value and first three derivatives at `x` from the span's start.
    ///
    /// Horner's scheme, without the terms that are zero when it starts.
    #[inline]
    pub fn derivatives(&self, x: f64) -> [PoseCoordinates; 4] {
        let [c0, c1, c2, c3, c4, c5] = &self.coefficients;
        // Splines are cubic; blends between them, and adjusted spans, have degree 5.
        let cubic = c4.iter().chain(c5.iter()).all(|c| c.to_bits() == 0);
        let [b0, b1, b2, b3] = if cubic {
            let a0 = c3 * x + c2;
            [a0 * x + c1, c3 * x + a0, *c3, PoseCoordinates::zeros()]
        } else {
            let fourth = c5 * x + c4;
            let [a0, a1] = [fourth * x + c3, c5 * x + fourth];
            let [a0, a1, a2, a3] = [a0 * x + c2, a1 * x + a0, c5 * x + a1, *c5];
            [a0 * x + c1, a1 * x + a0, a2 * x + a1, a3 * x + a2]
        };
        // Repeated Horner gives f, f', f''/2 and f'''/6.
        let third = if cubic { b2 } else { b3 * x + b2 };
        [b0 * x + c0, b1 * x + b0, (b2 * x + b1) * 2.0, third * 6.0]
    }

    /// Returns the value at `x` from the span's start.
    pub fn value(&self, x: f64) -> PoseCoordinates {
        self.coefficients.iter().rev().fold(PoseCoordinates::zeros(), |sum, c| sum * x + c)
    }
}

/// Geometry of one piece of a tool path.
#[derive(Debug, Clone, PartialEq)]
pub enum PieceGeometry {
    /// Tip and axis both follow the curve.
    Curve(PoseCurve),
    /// The tip moves straight; the rotary axes turn in proportion. The machine
    /// decides in which direction, so only the ends are prescribed.
    Reorient {
        /// Start.
        from: ToolPose,
        /// End.
        to: ToolPose,
    },
}

/// One smooth piece of a tool path.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolPiece {
    /// Kind of motion.
    pub motion: Motion,
    /// Motion of the tool.
    pub geometry: PieceGeometry,
}

/// Smooth pieces end to end; the tool rests where two pieces meet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ToolPath {
    /// Pieces in the order they are run.
    pub pieces: Vec<ToolPiece>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_cube_are_a_pencil_calculation() {
        let mut coefficients = [PoseCoordinates::zeros(); 6];
        coefficients[3][0] = 1.0;
        coefficients[0][5] = 1.0;
        let curve = PoseCurve { knots: vec![1.0, 4.0], spans: vec![PoseSpan { coefficients }] };
        let rates = curve.rates(3.0);
        let x: Vec<f64> = rates.tip.iter().map(|d| d.x).collect();
        assert_eq!(x, [8.0, 12.0, 12.0, 6.0]);
        assert_eq!(curve.pose(2.0).map(|pose| pose.axis), Some(Vector3::z_axis()));
    }

    #[test]
    fn a_tool_axis_may_have_any_length_but_zero() {
        for length in [1e-310, 1.0, 1e300] {
            let pose = ToolPose::new([1.0, 2.0, 3.0], [0.0, 0.0, -length]).unwrap();
            assert!((*pose.axis + Vector3::z()).norm() < 1e-15);
        }
        assert_eq!(ToolPose::new([0.0; 3], [0.0; 3]), None);
        assert_eq!(ToolPose::new([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(ToolPose::new([0.0; 3], [0.0, f64::INFINITY, 1.0]), None);
    }

    #[test]
    fn steps_lead_to_the_span_that_a_search_finds() {
        let spans = vec![PoseSpan { coefficients: [PoseCoordinates::zeros(); 6] }; 6];
        let curve = PoseCurve { knots: vec![0.0, 0.5, 2.0, 2.0, 2.25, 7.0, 7.5], spans };
        for near in 0..8 {
            for k in -4..40 {
                let u = 0.25 * f64::from(k);
                assert_eq!(curve.span_near(u, near), curve.span_at(u), "{u} from {near}");
            }
        }
    }

    #[test]
    fn a_vanishing_axis_has_no_pose() {
        let span = PoseSpan { coefficients: [PoseCoordinates::zeros(); 6] };
        assert_eq!(PoseCurve { knots: vec![0.0, 1.0], spans: vec![span] }.pose(0.5), None);
    }
}
