//! Curves between cutter locations with exact derivatives: great circle, local cubic.

use crate::math;
use crate::math::angle::angle_between;
use crate::types::{Cancelled, PoseCoordinates, PoseCurve, PoseSpan, Station};
use nalgebra::{UnitVector3, Vector3};

/// Reasons why no curve could be laid between cutter locations.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InterpolationError {
    /// Opposite axes: infinitely many great circles join them.
    #[error(
        "the tool axis is reversed ({angle:.9} rad apart): the plane of the turn is not defined; \
         insert a location between them"
    )]
    Opposite {
        /// Angle between the axes \[rad\].
        angle: f64,
    },
    /// A curve needs two stations.
    #[error("{0} station(s); a curve needs at least 2")]
    Stations(usize),
    /// A coordinate is NaN or infinite.
    #[error("station {0}: a coordinate is not a finite number")]
    NotFinite(usize),
    /// Nothing moves between two stations.
    #[error("stations {0} and the one after are the same; drop one of them")]
    Repeated(usize),
    /// Neighbouring axes are too far apart for a cubic of axis vectors.
    #[error(
        "the tool axis turns {angle:.4} rad from station {station} to the next; \
         above {limit:.4} rad the turn is not defined: insert stations between them"
    )]
    Turn {
        /// Index of the first of the two stations.
        station: usize,
        /// Angle between the axes \[rad\].
        angle: f64,
        /// Largest angle for which the curve is laid \[rad\].
        limit: f64,
    },
    /// The lever is not a positive number.
    #[error("lever {0} mm/rad must be positive and finite")]
    BadLever(f64),
    /// A limit is not a positive number.
    #[error("step {max_step} mm and turn {max_turn} rad must both be positive")]
    BadResolution {
        /// Largest step \[mm\].
        max_step: f64,
        /// Largest turn \[rad\].
        max_turn: f64,
    },
    /// Stopped through [`Progress`](crate::types::Progress).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Turn of the tool axis on the great circle from one direction to another.
///
/// # Example
///
/// ```
/// use nalgebra::Vector3;
/// use std::f64::consts::FRAC_PI_2;
/// use trunnion::toolpath::GreatCircle;
///
/// let turn = GreatCircle::new(&Vector3::z_axis(), &Vector3::x_axis())?;
/// assert!((turn.angle() - FRAC_PI_2).abs() < 1e-15);
/// let [axis, rate, ..] = turn.derivatives(0.5);
/// assert!((axis - Vector3::new(0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt())).norm() < 1e-15);
/// assert!((rate.norm() - FRAC_PI_2).abs() < 1e-15);
/// # Ok::<(), trunnion::toolpath::InterpolationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreatCircle {
    from: Vector3<f64>,
    /// Unit vector in the plane of the turn, a quarter turn ahead of `from`; zero without a turn.
    ahead: Vector3<f64>,
    angle: f64,
}

impl GreatCircle {
    /// Creates the shorter great circle from `from` to `to`. Equal directions give a turn by 0.
    ///
    /// # Errors
    ///
    /// [`InterpolationError::Opposite`] where both directions are opposite to the last digit.
    ///
    /// # Source
    ///
    /// Eq. (3)–(8) of `docs/sources.md#003`, (8) with the factor 1/|a × b| it lacks in print.
    pub fn new(from: &UnitVector3<f64>, to: &UnitVector3<f64>) -> Result<Self, InterpolationError> {
        // Difference and sum of nearly equal or opposite vectors are exact, their cross product is not:
        // Kahan's other formula, and the way ahead from whichever of the two is short.
        let [way, sum] = [**to - **from, **to + **from];
        // angle = 2 atan2(|b - a|, |b + a|), accurate at both ends of [0, pi].
        let angle = 2.0 * math::atan2(way.norm(), sum.norm());
        let short = if from.dot(to) > 0.0 { way } else { sum };
        let across = |v: Vector3<f64>| UnitVector3::try_new(v - from.scale(from.dot(&v)), 0.0);
        // Twice: of a difference in length alone, once would leave its rounding.
        let ahead = match across(short).and_then(|ahead| across(*ahead)) {
            Some(ahead) => ahead.into_inner(),
            None if from.dot(to) > 0.0 => Vector3::zeros(),
            None => return Err(InterpolationError::Opposite { angle }),
        };
        Ok(Self { from: from.into_inner(), ahead, angle })
    }

    /// Returns the whole angle of the turn \[rad\].
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Returns the direction and its first three derivatives by the share `t` of the turn, 0 at
    /// its start and 1 at its end \[1 per t^k\].
    pub fn derivatives(&self, t: f64) -> [Vector3<f64>; 4] {
        let (sin, cos) = math::sin_cos(t * self.angle);
        // Uniform turn in the plane of both vectors: d^2/dt^2 = -angle^2, twice.
        let axis = self.from * cos + self.ahead * sin;
        let rate = (self.ahead * cos - self.from * sin) * self.angle;
        let square = self.angle * self.angle;
        if square > 0.0 {
            // Without a turn `ahead` is no unit vector, and all derivatives are exactly 0.
            [axis, rate, axis * -square, rate * -square]
        } else {
            [self.from, Vector3::zeros(), Vector3::zeros(), Vector3::zeros()]
        }
    }
}

/// Stations on either side of one that its tangent is taken from. With two, the tangent is of
/// fourth order, so that the cubic keeps its own fourth order.
const REACH: usize = 2;

/// As for splines of unit vectors in [`super::through`]: beyond a right angle the chord of two
/// axes passes closer than cos(45°) to zero.
pub(super) const LARGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Lays a local cubic curve of tip, tool-axis vector and contact through `stations`. It passes through
/// each, where the axis is unit, with one velocity there (C1). A station moves only the curve
/// between its third neighbours.
///
/// Its parameter is the sum of [`Station::advance`] with `lever` \[mm/rad\]. The tangent at a station is that of
/// the polynomial through it and up to two stations on either side: steps that change abruptly make
/// it overshoot, so split at corners first. Not smooth enough to plan on: it seeds a fit.
///
/// # Errors
///
/// [`InterpolationError`] with the station concerned.
///
/// # Source
///
/// Cubic Hermite interpolation; comparison with the great circle in `docs/sources.md#003`.
pub fn local_cubic(stations: &[Station], lever: f64) -> Result<PoseCurve, InterpolationError> {
    let knots = parameters(stations, lever)?;
    let points: Vec<PoseCoordinates> = stations.iter().map(Station::coordinates).collect();
    let tangents: Vec<PoseCoordinates> =
        (0..points.len()).map(|at| tangent(&knots, &points, at)).collect();
    let ends = points.windows(2).zip(tangents.windows(2));
    let spans = knots
        .windows(2)
        .zip(ends)
        .map(|(u, (point, tangent))| hermite(u[1] - u[0], point, tangent))
        .collect();
    Ok(PoseCurve { knots, spans })
}

fn parameters(stations: &[Station], lever: f64) -> Result<Vec<f64>, InterpolationError> {
    if !(lever > 0.0 && lever.is_finite()) {
        return Err(InterpolationError::BadLever(lever));
    }
    if stations.len() < 2 {
        return Err(InterpolationError::Stations(stations.len()));
    }
    let finite = |station: &Station| station.coordinates().iter().all(|x| x.is_finite());
    if let Some(station) = stations.iter().position(|station| !finite(station)) {
        return Err(InterpolationError::NotFinite(station));
    }
    let mut knots = vec![0.0];
    let mut end = 0.0;
    for (station, pair) in stations.windows(2).enumerate() {
        let angle = angle_between(&pair[0].pose.axis, &pair[1].pose.axis);
        if angle > LARGEST_TURN {
            return Err(InterpolationError::Turn { station, angle, limit: LARGEST_TURN });
        }
        let before = end;
        end += pair[0].advance(&pair[1], lever);
        // Also a step that is lost in the rounding of the sum: no span could be laid over it.
        if end <= before {
            return Err(InterpolationError::Repeated(station));
        }
        knots.push(end);
    }
    Ok(knots)
}

fn tangent(knots: &[f64], points: &[PoseCoordinates], at: usize) -> PoseCoordinates {
    tangent_at(at, [0, points.len() - 1], |k| knots[k], |k| &points[k])
}

/// Returns the derivative, at one of its points, of the polynomial through that point and its
/// neighbours between `first` and `last` (Lagrange's form).
pub(super) fn tangent_at<'a>(
    at: usize,
    [first, last]: [usize; 2],
    knot: impl Fn(usize) -> f64,
    point: impl Fn(usize) -> &'a PoseCoordinates,
) -> PoseCoordinates {
    // Up to five points; fewer at the ends, where the order falls by as much.
    let near = at.saturating_sub(REACH).max(first)..=(at + REACH).min(last);
    let here = knot(at);
    let mut sum = PoseCoordinates::zeros();
    for other in near.clone().filter(|&other| other != at) {
        // L_j'(x_i) = prod_{k != i, j} (x_i - x_k) / (x_j - x_k) / (x_j - x_i) for the Lagrange
        // polynomial of another point j.
        let weight = near
            .clone()
            .filter(|&third| third != other && third != at)
            .map(|third| (here - knot(third)) / (knot(other) - knot(third)))
            .product::<f64>();
        // Differences, so that a coordinate that stands still has no rate at all.
        sum += (point(other) - point(at)) * (weight / (knot(other) - here));
    }
    sum
}

fn hermite(width: f64, point: &[PoseCoordinates], tangent: &[PoseCoordinates]) -> PoseSpan {
    let [from, to, rate, last] = [point[0], point[1], tangent[0], tangent[1]];
    // Cubic Hermite in powers of the distance x: c2 = (3 m - 2 a - b) / w, c3 = (a + b - 2 m) / w^2
    // with the mean slope m and end slopes a, b.
    let mean = (to - from) / width;
    let none = PoseCoordinates::zeros();
    let second = (mean * 3.0 - rate * 2.0 - last) / width;
    let third = (rate + last - mean * 2.0) / (width * width);
    PoseSpan { coefficients: [from, rate, second, third, none, none] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::ToolPose;
    use nalgebra::Point3;

    const LEVER: f64 = 10.0;

    fn direction(v: [f64; 3]) -> UnitVector3<f64> {
        UnitVector3::new_normalize(Vector3::from(v))
    }

    /// On a circle of radius 20 mm, the axis on a cone about it that breathes.
    fn around(angle: f64) -> Station {
        let tilt = 0.5 + 0.1 * (2.0 * angle).sin();
        let axis = [tilt.sin() * angle.cos(), tilt.sin() * angle.sin(), tilt.cos()];
        let tip = Point3::new(20.0 * angle.cos(), 20.0 * angle.sin(), 3.0 * angle.sin());
        Station { pose: ToolPose { tip, axis: direction(axis) }, contact: tip }
    }

    fn stations(steps: u32) -> Vec<Station> {
        (0..=steps).map(|k| around(f64::from(k) / f64::from(steps))).collect()
    }

    /// Largest distance of the curve's tip from the circle's equation, and of its axis from the cone
    /// at the same angle about z; spans at the ends have one-sided tangents and are left out.
    fn error(steps: u32) -> [f64; 2] {
        let curve = local_cubic(&stations(steps), LEVER).unwrap();
        let [mut tip, mut axis] = [0.0_f64; 2];
        for span in 2..curve.spans.len() - 2 {
            let middle = 0.5 * (curve.knots[span] + curve.knots[span + 1]);
            for share in [0.3, 0.5, 0.8] {
                let u = middle + (share - 0.5) * (curve.knots[span + 1] - curve.knots[span]);
                let pose = curve.pose(u).unwrap();
                let truth = around(pose.tip.y.atan2(pose.tip.x)).pose;
                tip = tip.max((pose.tip - truth.tip).norm());
                axis = axis.max(angle_between(&pose.axis, &truth.axis));
            }
        }
        [tip, axis]
    }

    #[test]
    fn a_quarter_turn_has_derivatives_of_sine_and_cosine() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let turn = GreatCircle::new(&Vector3::z_axis(), &Vector3::x_axis()).unwrap();
        assert!((turn.angle() - quarter).abs() < 1e-15);
        let [axis, rate, second, third] = turn.derivatives(0.0);
        assert!((axis - Vector3::z()).norm() < 1e-15);
        assert!((rate - Vector3::x() * quarter).norm() < 1e-15);
        assert!((second + Vector3::z() * quarter.powi(2)).norm() < 1e-14);
        assert!((third + Vector3::x() * quarter.powi(3)).norm() < 1e-14);
        assert!((turn.derivatives(1.0)[0] - Vector3::x()).norm() < 1e-15);
    }

    #[test]
    fn great_circles_agree_with_the_reference_cases() {
        let text = include_str!("../../../../fixtures/slerp/slerp.json");
        let cases: serde_json::Value = serde_json::from_str(text).unwrap();
        for case in cases["slerp"].as_array().unwrap() {
            let [a, b] = ["a", "b"].map(|end| [0, 1, 2].map(|i| case[end][i].as_f64().unwrap()));
            let turn = GreatCircle::new(&direction(a), &direction(b));
            if case["expect"].is_string() {
                assert!(matches!(turn, Err(InterpolationError::Opposite { .. })), "{case}");
                continue;
            }
            let [t, tolerance] = ["t", "tol"].map(|name| case[name].as_f64().unwrap());
            let got = turn.unwrap().derivatives(t)[0];
            for i in 0..3 {
                let expect = case["expect"][i].as_f64().unwrap();
                assert!((got[i] - expect).abs() <= tolerance, "{case}");
            }
        }
    }

    #[test]
    fn equal_axes_are_exact_and_opposite_ones_an_error() {
        let axis = direction([0.2, -0.3, 0.9]);
        let still = GreatCircle::new(&axis, &axis).unwrap().derivatives(0.3);
        assert_eq!(still[0], axis.into_inner());
        assert_eq!(still[1..], [Vector3::zeros(); 3]);
        let back = GreatCircle::new(&axis, &-axis);
        assert!(matches!(back, Err(InterpolationError::Opposite { .. })));
    }

    #[test]
    fn a_local_cubic_passes_through_its_stations_with_one_velocity() {
        let stations = stations(8);
        let curve = local_cubic(&stations, LEVER).unwrap();
        for (at, station) in stations.iter().enumerate().skip(1).take(7) {
            let [left, right] = [at - 1, at].map(|span| curve.rates_in(span, curve.knots[at]));
            assert!((left.tip[0] - station.pose.tip.coords).norm() < 1e-13);
            assert!((left.axis[0] - station.pose.axis.into_inner()).norm() < 1e-14);
            assert!((left.tip[1] - right.tip[1]).norm() < 1e-13);
            assert!((left.axis[1] - right.axis[1]).norm() < 1e-13);
        }
    }

    #[test]
    fn the_error_of_a_local_cubic_falls_with_the_fourth_power_of_the_step() {
        let [coarse, fine] = [error(16), error(32)];
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            assert!(fine * 12.0 < coarse, "{coarse:e} -> {fine:e}");
        }
    }

    #[test]
    fn a_local_cubic_is_closer_to_the_true_turn_than_great_circles() {
        let stations = stations(12);
        let straight = stations.windows(2).enumerate().map(|(k, pair)| {
            let turn = GreatCircle::new(&pair[0].pose.axis, &pair[1].pose.axis).unwrap();
            let middle = around((k as f64 + 0.5) / 12.0).pose.axis;
            angle_between(&UnitVector3::new_normalize(turn.derivatives(0.5)[0]), &middle)
        });
        let straight = straight.fold(0.0, f64::max);
        assert!(error(12)[1] * 50.0 < straight, "{:e} against {straight:e}", error(12)[1]);
    }

    #[test]
    fn faults_have_names() {
        let a = around(0.0);
        let nan = Station { contact: Point3::new(f64::NAN, 0.0, 0.0), ..a };
        let mut down = around(1.0);
        down.pose.axis = -a.pose.axis;
        assert_eq!(local_cubic(&[a], LEVER), Err(InterpolationError::Stations(1)));
        assert_eq!(local_cubic(&[a, nan], LEVER), Err(InterpolationError::NotFinite(1)));
        assert_eq!(local_cubic(&[a, a], LEVER), Err(InterpolationError::Repeated(0)));
        let turned = local_cubic(&[a, down], LEVER);
        assert!(matches!(turned, Err(InterpolationError::Turn { station: 0, .. })));
        assert_eq!(local_cubic(&[a, around(1.0)], 0.0), Err(InterpolationError::BadLever(0.0)));
    }
}
