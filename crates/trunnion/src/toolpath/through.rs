//! Curves through every station of the legs of a job.

use super::error::ToolPathError;
use super::interpolation::LARGEST_TURN;
use super::options::ToolPathOptions;
use crate::math::angle::angle_between;
use crate::types::{
    Leg, Motion, PieceGeometry, PoseCoordinates, PoseCurve, PoseSpan, Progress, Stage, Station,
    ToolPath, ToolPiece,
};

/// Two unit vectors normalised apart from the same direction differ by at most a few units in the
/// last place (2⁻⁵³ each for three products, two sums, a root and a quotient, on both sides).
const SAME_AXIS: f64 = 16.0 * f64::EPSILON;

/// Lays smooth curves through the stations of `legs`: one piece per cutting leg or link, and one
/// per straight part of a lead.
///
/// A cutting leg becomes one C2 cubic spline of tip, axis vector and contact over a common
/// parameter, the chord length of the contact track \[mm\]. It passes through every station, where
/// the axis vector is unit. Its ends carry on the neighbouring cubic (not-a-knot). So does a link
/// with stations between its ends; one of two stations is left to the machine, from pose to pose.
///
/// # Errors
///
/// [`ToolPathError`] with the leg and station concerned; [`ToolPathError::Cancelled`] on request.
///
/// # Example
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trunnion::toolpath::{ToolPathOptions, through};
/// use trunnion::types::{Leg, Motion, Silent, Station, ToolPose};
///
/// let at = |x: f64| Station {
///     pose: ToolPose { tip: Point3::new(x, 0.0, x * x / 100.0), axis: Vector3::z_axis() },
///     contact: Point3::new(x, 0.0, x * x / 100.0),
/// };
/// let stations = [0.0, 4.0, 8.0, 12.0].map(at).to_vec();
/// let legs = [Leg { motion: Motion::Cut, stations }];
/// let path = through(&legs, &ToolPathOptions::with_lever(16.0), &Silent)?;
/// assert_eq!(path.pieces.len(), 1);
/// # Ok::<(), trunnion::toolpath::ToolPathError>(())
/// ```
pub fn through(
    legs: &[Leg],
    options: &ToolPathOptions,
    progress: &dyn Progress,
) -> Result<ToolPath, ToolPathError> {
    if !(options.lever > 0.0 && options.lever.is_finite()) {
        return Err(ToolPathError::BadLever(options.lever));
    }
    let mut path = ToolPath::default();
    for (leg, of) in legs.iter().enumerate() {
        progress.step(Stage::ToolPath, leg as u64, legs.len() as u64)?;
        check(leg, of)?;
        if leg > 0 {
            joined(leg, &legs[leg - 1], of)?;
        }
        match of.motion {
            Motion::Link if of.stations.len() == 2 => path.pieces.extend(link(of)),
            // A link with stations between its ends: the way matters.
            Motion::Cut | Motion::Step | Motion::Hop | Motion::Link => {
                path.pieces.push(curve(leg, of, options.lever)?);
            }
            Motion::LeadIn | Motion::LeadOut => path.pieces.extend(lead(leg, of)?),
        }
    }
    progress.step(Stage::ToolPath, legs.len() as u64, legs.len() as u64)?;
    Ok(path)
}

/// Checks that a leg has two stations or more, with finite coordinates.
pub(super) fn check(leg: usize, of: &Leg) -> Result<(), ToolPathError> {
    let stations = of.stations.len();
    if stations < 2 {
        return Err(ToolPathError::Stations { leg, stations });
    }
    let finite = |station: &Station| station.coordinates().iter().all(|x| x.is_finite());
    match of.stations.iter().position(|station| !finite(station)) {
        Some(station) => Err(ToolPathError::NotFinite { leg, station }),
        None => Ok(()),
    }
}

/// Checks that a leg starts where the one before ended.
pub(super) fn joined(leg: usize, before: &Leg, of: &Leg) -> Result<(), ToolPathError> {
    let (Some(end), Some(start)) = (before.stations.last(), of.stations.first()) else {
        return Ok(());
    };
    if end.pose == start.pose {
        return Ok(());
    }
    let distance = (end.pose.tip - start.pose.tip).norm();
    let angle = angle_between(&end.pose.axis, &start.pose.axis);
    Err(ToolPathError::Gap { leg, distance, angle })
}

/// Lays the cubic spline of one leg.
fn curve(leg: usize, of: &Leg, lever: f64) -> Result<ToolPiece, ToolPathError> {
    // The parameter has to increase, and axis vectors must not pass near 0 between two stations.
    for (station, pair) in of.stations.windows(2).enumerate() {
        let angle = angle_between(&pair[0].pose.axis, &pair[1].pose.axis);
        if angle > LARGEST_TURN {
            let limit = LARGEST_TURN;
            return Err(ToolPathError::AxisReversal { leg, station, angle, limit });
        }
        if pair[0].advance(&pair[1], lever) <= 0.0 {
            return Err(ToolPathError::Repeated { leg, station });
        }
    }
    let curve = PoseCurve::through(&of.stations, lever);
    Ok(ToolPiece { motion: of.motion, geometry: PieceGeometry::Curve(curve) })
}

/// Leaves a link to the machine, from pose to pose.
fn link(of: &Leg) -> Option<ToolPiece> {
    let (from, to) = (of.stations.first()?.pose, of.stations.last()?.pose);
    Some(ToolPiece { motion: of.motion, geometry: PieceGeometry::Reorient { from, to } })
}

/// Lays one straight piece per pair of stations, so that the tool rests at corners of the lead.
fn lead(leg: usize, of: &Leg) -> Result<Vec<ToolPiece>, ToolPathError> {
    let mut pieces = Vec::new();
    for (station, pair) in of.stations.windows(2).enumerate() {
        let angle = angle_between(&pair[0].pose.axis, &pair[1].pose.axis);
        if angle > SAME_AXIS {
            return Err(ToolPathError::LeadTurns { leg, angle });
        }
        // A lead is run by the distance of its tip: a unit velocity, and no second derivative.
        let length = (pair[1].pose.tip - pair[0].pose.tip).norm();
        if length <= 0.0 {
            return Err(ToolPathError::Repeated { leg, station });
        }
        let coefficients = line(&pair[0].coordinates(), &pair[1].coordinates(), length);
        let curve = PoseCurve { knots: vec![0.0, length], spans: vec![PoseSpan { coefficients }] };
        pieces.push(ToolPiece { motion: of.motion, geometry: PieceGeometry::Curve(curve) });
    }
    Ok(pieces)
}

fn line(from: &PoseCoordinates, to: &PoseCoordinates, length: f64) -> [PoseCoordinates; 6] {
    let mut coefficients = [PoseCoordinates::zeros(); 6];
    coefficients[0] = *from;
    coefficients[1] = (to - from) / length;
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Silent, ToolPose};
    use nalgebra::{Point3, UnitVector3, Vector3};

    const OPTIONS: ToolPathOptions = ToolPathOptions::with_lever(16.0);

    fn station(tip: [f64; 3], axis: [f64; 3], contact: [f64; 3]) -> Station {
        let axis = UnitVector3::new_normalize(Vector3::from(axis));
        Station { pose: ToolPose { tip: Point3::from(tip), axis }, contact: Point3::from(contact) }
    }

    fn leg(motion: Motion, stations: Vec<Station>) -> Leg {
        Leg { motion, stations }
    }

    #[test]
    fn a_lead_and_a_link_are_straight() {
        let up = |z: f64| station([0.0, 0.0, z], [0.0, 0.0, 1.0], [0.0, 0.0, z]);
        let over = station([9.0, 0.0, 50.0], [1.0, 0.0, 1.0], [9.0, 0.0, 50.0]);
        let legs = [
            leg(Motion::LeadOut, vec![up(0.0), up(50.0)]),
            leg(Motion::Link, vec![up(50.0), over]),
        ];
        let path = through(&legs, &OPTIONS, &Silent).unwrap();
        let PieceGeometry::Curve(out) = &path.pieces[0].geometry else {
            panic!("a lead is a curve")
        };
        assert!((out.range().high - 50.0).abs() < 1e-12);
        let rates = out.rates(20.0);
        assert!((rates.tip[0].z - 20.0).abs() < 1e-12);
        assert_eq!(rates.axis[1], Vector3::zeros());
        let end = PieceGeometry::Reorient { from: up(50.0).pose, to: over.pose };
        assert_eq!(path.pieces[1].geometry, end);
    }

    #[test]
    fn a_tool_that_pivots_on_its_contact_still_has_a_parameter() {
        let turned = |angle: f64| {
            let tip = [angle.sin(), 0.0, 1.0 - angle.cos()];
            station(tip, [angle.sin(), 0.0, angle.cos()], [0.0; 3])
        };
        let stations = [0.0, 0.1, 0.2, 0.3].map(turned).to_vec();
        let path = through(&[leg(Motion::Cut, stations)], &OPTIONS, &Silent).unwrap();
        let PieceGeometry::Curve(curve) = &path.pieces[0].geometry else {
            panic!("a cut is a curve")
        };
        assert!((curve.range().high - 0.3 * 16.0 / 8.0).abs() < 1e-12);
    }

    #[test]
    fn faults_have_names() {
        let fault = |stations| through(&[leg(Motion::Cut, stations)], &OPTIONS, &Silent);
        let a = station([0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]);
        let down = station([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
        let nan = station([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        assert_eq!(fault(vec![a]), Err(ToolPathError::Stations { leg: 0, stations: 1 }));
        assert_eq!(fault(vec![a, a]), Err(ToolPathError::Repeated { leg: 0, station: 0 }));
        assert_eq!(fault(vec![a, nan]), Err(ToolPathError::NotFinite { leg: 0, station: 1 }));
        assert!(matches!(fault(vec![a, down]), Err(ToolPathError::AxisReversal { .. })));
        let turned = leg(Motion::LeadIn, vec![a, station([0.0; 3], [0.1, 0.0, 1.0], [0.0; 3])]);
        let lead = through(&[turned], &OPTIONS, &Silent);
        assert!(matches!(lead, Err(ToolPathError::LeadTurns { leg: 0, .. })));
        let b = station([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let apart = [leg(Motion::Cut, vec![a, b]), leg(Motion::Cut, vec![a, b])];
        assert!(matches!(through(&apart, &OPTIONS, &Silent), Err(ToolPathError::Gap { .. })));
        let options = ToolPathOptions::with_lever(f64::NAN);
        assert!(matches!(through(&[], &options, &Silent), Err(ToolPathError::BadLever(_))));
    }
}
