//! From passes to a whole program of motions: leads and links.

use super::CoverError;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Leg, Motion, Pass, Progress, Stage, Station, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};

/// How the tool comes down to a pass and leaves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeadKind {
    /// Straight along the tool axis.
    Axis,
    /// First along the pass, carried on straight by `length` \[mm\], then along the tool axis.
    Tangent {
        /// How far the pass is carried on \[mm\].
        length: f64,
    },
}

/// How passes are joined. No `Default`: the caller knows part, stock and tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkOptions {
    /// Way out of the part: square to the plane of the links.
    pub up: UnitVector3<f64>,
    /// Height along `up` of the plane that no part of the cutting end goes below during a link \[mm\]:
    /// the highest point of part and stock plus the clearance.
    pub plane: f64,
    /// Kind of lead.
    pub lead: LeadKind,
    /// Last stretch of a lead that is run at the cutting feed \[mm\]; what lies above counts as a link.
    /// Longer than the lead: all of it.
    pub approach: f64,
    /// Depth to which the cutter may go into a face during a lead \[mm\]: the gouge tolerance.
    pub gouge: f64,
}

/// A lead climbs at least this much per mm of its length: a flatter one would run over the part
/// for more than ten times the height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Points on the cutter's centre circle whose distance to the faces is taken along a lead.
const CIRCLE_POINTS: u32 = 32;

/// Joins passes with leads and links: down to each pass, along it, up again, and over to the next at
/// a height where the tool may turn. Passes are run in the order and direction given.
///
/// Each lead is checked by distance queries from the cutter's centre circle against all `faces`;
/// where the way along the tool axis is barred, one leaning towards `up` is taken.
///
/// # Errors
///
/// [`CoverError::LeadGouges`] where every way gouges or does not lead up; [`CoverError::Cancelled`].
pub fn legs(
    passes: &[Pass],
    faces: &[FaceIndex],
    cutter: &Cutter,
    options: &LinkOptions,
    progress: &dyn Progress,
) -> Result<Vec<Leg>, CoverError> {
    let mut legs: Vec<Leg> = Vec::new();
    let leads = Leads { faces, cutter, options };
    for (number, pass) in passes.iter().enumerate() {
        progress.step(Stage::Cover, number as u64, passes.len() as u64)?;
        let gouges = |depth| CoverError::LeadGouges { pass: number, face: pass.face, depth };
        let forward = pass.stations.iter();
        let out = leads.away(&mut forward.clone().rev().copied()).map_err(gouges)?;
        let down = leads.away(&mut forward.copied()).map_err(gouges)?;
        if let (Some(above), Some(&below)) =
            (legs.last().and_then(|leg| leg.stations.last()), down.last())
        {
            legs.push(Leg { motion: Motion::Link, stations: vec![*above, below] });
        }
        let (high, low) = split(out, options.approach);
        let (high_down, low_down) = split(down, options.approach);
        legs.extend(high_down.map(|link| Leg { motion: Motion::Link, stations: reversed(link) }));
        legs.push(Leg { motion: Motion::LeadIn, stations: reversed(low_down) });
        legs.push(Leg { motion: Motion::Cut, stations: pass.stations.clone() });
        legs.push(Leg { motion: Motion::LeadOut, stations: low });
        legs.extend(high.map(|link| Leg { motion: Motion::Link, stations: link }));
    }
    progress.step(Stage::Cover, passes.len() as u64, passes.len() as u64)?;
    Ok(legs)
}

/// Splits a way up where its last straight part, the climb, is `approach` long: what lies above, if
/// anything does, and what lies below.
fn split(mut up: Vec<Station>, approach: f64) -> (Option<Vec<Station>>, Vec<Station>) {
    let Some(&[foot, top]) = up.last_chunk::<2>() else { return (None, up) };
    let climb = top.pose.tip - foot.pose.tip;
    if climb.norm() <= approach {
        return (None, up);
    }
    let near = moved(&foot, &climb.scale(approach / climb.norm()));
    up.pop();
    up.push(near);
    (Some(vec![near, top]), up)
}

fn reversed(mut stations: Vec<Station>) -> Vec<Station> {
    stations.reverse();
    stations
}

struct Leads<'a> {
    faces: &'a [FaceIndex],
    cutter: &'a Cutter,
    options: &'a LinkOptions,
}

impl Leads<'_> {
    /// Stations from the first of `inwards` (a pass seen from one end) up to the link height; the
    /// greatest depth of a gouge where there is no way.
    fn away(&self, inwards: &mut dyn Iterator<Item = Station>) -> Result<Vec<Station>, f64> {
        let (Some(end), Some(before)) = (inwards.next(), inwards.next()) else {
            return Ok(Vec::new());
        };
        let mut ways = Vec::new();
        if let LeadKind::Tangent { length } = self.options.lead
            && let Some(tangent) = Unit::try_new(end.pose.tip - before.pose.tip, 0.0)
        {
            ways.extend(self.ups(&end).map(|up| vec![(tangent, length), up]));
        }
        ways.extend(self.ups(&end).map(|up| vec![up]));
        let mut deepest = 0.0;
        for way in ways {
            match self.follow(end, &way) {
                Ok(stations) => return Ok(stations),
                Err(depth) => deepest = f64::max(deepest, depth),
            }
        }
        Err(deepest)
    }

    /// Directions up to the link height with the way to go: the tool axis, and more and more of straight up.
    fn ups(&self, end: &Station) -> impl Iterator<Item = (UnitVector3<f64>, f64)> {
        let axis = end.pose.axis.into_inner();
        let radius = self.cutter.radius();
        // With its tip a radius above the plane, the cutting end is above it however it is turned.
        let up = self.options.up;
        let height = self.options.plane + radius - end.pose.tip.coords.dot(&up);
        [0.0, 0.5, 1.0].into_iter().filter_map(move |share| {
            let direction = Unit::try_new(axis.lerp(&up, share), 0.0)?;
            let climb = direction.dot(&up);
            (climb >= LEAST_CLIMB).then(|| (direction, (height / climb).max(radius)))
        })
    }

    /// Stations at the corners of a way, or how deep it gouges.
    fn follow(&self, from: Station, way: &[(UnitVector3<f64>, f64)]) -> Result<Vec<Station>, f64> {
        let mut stations = vec![from];
        let mut here = from;
        for (direction, length) in way {
            let depth = self.depth(&here.pose, direction, *length);
            if depth > self.options.gouge {
                return Err(depth);
            }
            here = moved(&here, &(direction.scale(*length)));
            stations.push(here);
        }
        Ok(stations)
    }

    /// Greatest depth below a face on a straight way, by marching: the clearance changes by at most
    /// the distance moved, so a step as long as the clearance cannot miss a contact. Shorter steps
    /// than an eighth of the cutter's radius are not taken.
    fn depth(&self, from: &ToolPose, direction: &UnitVector3<f64>, length: f64) -> f64 {
        let least = 0.125 * self.cutter.radius();
        let (mut way, mut deepest) = (0.0, f64::NEG_INFINITY);
        while way < length {
            let tip = from.tip + direction.scale(way);
            let clearance = self.clearance(&ToolPose { tip, axis: from.axis });
            deepest = deepest.max(-clearance);
            way += clearance.max(least);
        }
        deepest
    }

    /// Distance of the faces from the tube about the centre circle, negative inside \[mm\].
    fn clearance(&self, pose: &ToolPose) -> f64 {
        let minor = self.cutter.minor();
        circle(pose, self.cutter, CIRCLE_POINTS)
            .flat_map(|point| self.faces.iter().map(move |face| height_over(face, &point) - minor))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Distance of a point from a face, negative below it. Beside the face's border there is no
/// below, so the distance counts as it is.
fn height_over(face: &FaceIndex, point: &Point3<f64>) -> f64 {
    // Where no closest point is unique or has a normal, nothing is known of the side.
    let Ok(foot) = face.closest(point) else { return f64::INFINITY };
    let away = point - foot.point;
    let across = away - foot.normal.scale(away.dot(&foot.normal));
    // A foot inside the face has its normal along `away` to rounding and the query's tolerance.
    if across.norm() <= SQUARE * away.norm() { foot.distance } else { away.norm() }
}

/// Sine of the angle up to which a foot counts as lying inside the face and not on its border.
const SQUARE: f64 = 1e-3;

fn moved(station: &Station, by: &Vector3<f64>) -> Station {
    let pose = ToolPose { tip: station.pose.tip + by, axis: station.pose.axis };
    Station { pose, contact: station.contact + by }
}

/// Points of the cutter's centre circle at a pose, evenly spaced.
fn circle(pose: &ToolPose, cutter: &Cutter, points: u32) -> impl Iterator<Item = Point3<f64>> {
    let centre = pose.tip + pose.axis.scale(cutter.minor());
    let [e, f] = square_to(&pose.axis);
    let major = cutter.major();
    (0..points).map(move |i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(points)).sin_cos();
        centre + e.scale(major * cos) + f.scale(major * sin)
    })
}

/// Two unit vectors square to `axis` and each other.
fn square_to(axis: &UnitVector3<f64>) -> [UnitVector3<f64>; 2] {
    let least = Vector3::ith(axis.iamin(), 1.0);
    let e = Unit::new_normalize(axis.cross(&least));
    [e, Unit::new_normalize(axis.cross(&e))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_stretch_of_a_climb_is_run_at_the_feed() {
        let axis = Unit::new_normalize(Vector3::new(0.0, 0.6, 0.8));
        let at = |z: f64| {
            let tip = Point3::from(axis.scale(z));
            Station { pose: ToolPose { tip, axis }, contact: tip }
        };
        let (high, low) = split(vec![at(0.0), at(50.0)], 8.0);
        let (high, tip) = (high.unwrap(), |station: &Station| station.pose.tip.coords.norm());
        assert!((tip(&low[1]) - 8.0).abs() < 1e-12 && low.len() == 2);
        assert!((high[0].pose.tip - low[1].pose.tip).norm() < 1e-15);
        assert!((tip(&high[1]) - 50.0).abs() < 1e-12);
        assert!(split(vec![at(0.0), at(5.0)], 8.0).0.is_none());
    }
}
