//! Locations and the arcs that lead to them.

use super::file::{ClItem, ClMotion, ClRecord};
use super::path::{ClArc, ClPath};
use super::reader::{ClReader, no_number};
use super::state::{AnnouncedCircle, ClResult, PathShape};
use super::statement::{ClWord, Numbers, Statement};
use crate::math;
use crate::types::ToolPose;
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Two decimals of each component leave 0.9 % of the length of an axis; more is a slip.
const AXIS_SLIP: f64 = 1e-2;
/// Four decimals leave 0.9e-4: more is worth a warning.
const AXIS_SLACK: f64 = 1e-4;

/// Two ends of an arc may differ in their distance from its axis by what three decimals of an inch leave
/// \[mm\], or by a thousandth of it where angles were rounded.
const RADIUS_SLACK: [f64; 2] = [0.05, 1e-3];

impl ClReader {
    pub(super) fn goto(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        let tip = match *numbers.as_slice() {
            [x, y, z] => Point3::new(x, y, z),
            // The axis is modal: later locations without it keep it.
            [x, y, z, i, j, k] => {
                self.state.axis = self.axis_of(of, rest.at, Vector3::new(i, j, k))?;
                Point3::new(x, y, z)
            }
            _ => {
                let message =
                    format!("{} numbers; a location has 3 or 6", numbers.as_slice().len());
                return Err(Box::new(of.fault(
                    rest.at,
                    message,
                    "write GOTO/x,y,z or GOTO/x,y,z,i,j,k",
                )));
            }
        };
        self.locate(of, tip * self.state.scale)
    }

    /// Reads a location relative to the current one: by a vector, or along the tool axis.
    pub(super) fn delta(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        let way = match *numbers.as_slice() {
            // GODLTA with one number moves along the tool axis.
            [along] => self.state.axis.scale(along),
            [x, y, z] => Vector3::new(x, y, z),
            _ => {
                let message = format!("{} numbers; GODLTA has 1 or 3", numbers.as_slice().len());
                return Err(Box::new(of.fault(rest.at, message, "")));
            }
        };
        let Some(place) = self.state.place else {
            let message = "GODLTA, and no location before it".to_owned();
            return Err(Box::new(of.fault(rest.at, message, "write FROM or GOTO before it")));
        };
        self.locate(of, place.tip + way * self.state.scale)
    }

    /// Sets the pose of the tool without a move.
    pub(super) fn from(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        if let [x, y, z, ref axis @ ..] = *numbers.as_slice() {
            if let [i, j, k] = *axis {
                self.state.axis = self.axis_of(of, rest.at, Vector3::new(i, j, k))?;
            }
            let tip = Point3::new(x, y, z) * self.state.scale;
            self.state.place = Some(ToolPose { tip, axis: self.state.axis });
            return Ok(());
        }
        let message = format!("{} numbers; FROM has 3 or 6", numbers.as_slice().len());
        Err(Box::new(of.fault(rest.at, message, "write FROM/x,y,z")))
    }

    fn locate(&mut self, of: &Statement<'_>, tip: Point3<f64>) -> ClResult<ClItem> {
        let pose = ToolPose { tip, axis: self.state.axis };
        // A cycle makes a hole of every location, whatever path was announced.
        let way = match (self.state.cycle, self.state.shape) {
            (Some(cycle), _) => ClPath::Hole(self.hole(of, &cycle, &pose)?),
            (None, PathShape::Straight) => ClPath::Straight,
            (None, PathShape::Circle(circle)) => self.on(of, circle, &tip)?,
        };
        let feed = self.state.cycle.and_then(|cycle| cycle.feed).or(self.state.feed);
        // RAPID holds for one location; holes have rapid and feed moves of their own.
        let rapid = self.state.rapid && !matches!(way, ClPath::Hole(_));
        let motion = match feed {
            _ if rapid => ClMotion::Rapid,
            Some(feed) => ClMotion::Feed(feed),
            // Many files begin with a location before any feed: it is only the starting point.
            None if self.state.place.is_none() && way == ClPath::Straight => ClMotion::Rapid,
            None => {
                let message = "a location, and no feed before it".to_owned();
                return Err(Box::new(of.fault(0, message, "write RAPID or FEDRAT before it")));
            }
        };
        self.state.rapid = false;
        let record = ClRecord { line: of.line(), pose, motion, way };
        self.state.place = Some(record.end());
        Ok(ClItem::Location(record))
    }

    /// Checks and normalizes a tool axis, whose length is 1 up to the rounding of its decimals.
    pub(super) fn axis_of(
        &mut self,
        of: &Statement<'_>,
        at: usize,
        vector: Vector3<f64>,
    ) -> ClResult<UnitVector3<f64>> {
        let length = vector.norm();
        let off = (length - 1.0).abs();
        if off > AXIS_SLIP {
            let message = format!("the tool axis has length {length:.6}, not 1");
            return Err(Box::new(of.fault(at, message, "write i,j,k of length 1")));
        }
        if off > AXIS_SLACK {
            let message =
                format!("the tool axis has length {length:.6}; it is taken as a direction");
            self.warn(of, "axis length", message, "write more decimals of i,j,k");
        }
        Ok(UnitVector3::new_normalize(vector))
    }

    /// Reads `CIRCLE`: centre, axis, perhaps radius; behind these NX has the cutter, perhaps turns.
    pub(super) fn circle(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        if let Some(word) = rest.items().find(|word| word.is("TIMES")) {
            let message = "a helix of several turns".to_owned();
            return Err(Box::new(of.fault(word.at, message, "post it as points (linear output)")));
        }
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        let [x, y, z, i, j, k, ref behind @ ..] = *numbers.as_slice() else {
            let message = format!("{} numbers; CIRCLE has 6 or more", numbers.as_slice().len());
            return Err(Box::new(of.fault(rest.at, message, "centre, axis, radius")));
        };
        let normal = self.axis_of(of, rest.at, Vector3::new(i, j, k))?;
        let radius = behind.first().map(|radius| radius * self.state.scale);
        self.state.shape = PathShape::Circle(AnnouncedCircle {
            center: Point3::new(x, y, z) * self.state.scale,
            normal,
            radius,
            sweep: None,
            // Creo: centre, axis and radius, and nothing behind, hold for all locations on the
            // circle.
            turned: (behind.len() == 1).then_some(0.0),
        });
        Ok(ClItem::Manner)
    }

    /// Reads `MOVARC/centre,axis,radius,ANGLE,degrees`.
    pub(super) fn arc(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        let mut values = [0.0; 8];
        let numbers = rest.items().filter(|word| !word.is("ANGLE"));
        let mut count = 0;
        for word in numbers {
            let slot = values.get_mut(count).ok_or_else(|| no_number(of, word))?;
            *slot = word.number().ok_or_else(|| no_number(of, word))?;
            count += 1;
        }
        if count < values.len() {
            let message = format!("MOVARC has {count} numbers; 8 are needed");
            return Err(Box::new(of.fault(
                rest.at,
                message,
                "centre, axis, radius, ANGLE, degrees",
            )));
        }
        let [x, y, z, i, j, k, radius, degrees] = values;
        let normal = self.axis_of(of, rest.at, Vector3::new(i, j, k))?;
        self.state.shape = PathShape::Circle(AnnouncedCircle {
            center: Point3::new(x, y, z) * self.state.scale,
            normal,
            radius: Some(radius * self.state.scale),
            sweep: Some(degrees.abs().to_radians()),
            turned: None,
        });
        Ok(ClItem::Manner)
    }

    /// Reads `INDIRV`, the direction in which the next curve starts; `AUTOPS` has no numbers.
    pub(super) fn direction(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        if rest.text.trim().is_empty() || rest.text.trim() == "-" {
            return Ok(ClItem::Manner);
        }
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        if let [i, j, k] = *numbers.as_slice() {
            self.state.direction = Some(Vector3::new(i, j, k));
        }
        Ok(ClItem::Manner)
    }

    /// Reads `TLON,GOFWD/(CIRCLE/centre,radius),ON,(LINE/from,to)`: on the circle from the current
    /// location, in the
    /// direction of `INDIRV`, to the end of the line.
    pub(super) fn curve(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        let fault = |message: &str| {
            let help = "INDIRV/i,j,k, then TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z)";
            Box::new(of.fault(rest.at, message.to_owned(), help))
        };
        let numbers = in_kind(rest, "CIRCLE").zip(in_kind(rest, "LINE"));
        let Some(([x, y, z, radius, ..], [_, _, _, ex, ey, ez])) = numbers else {
            return Err(fault("a curve other than a circle up to a line"));
        };
        let (Some(place), Some(direction)) = (self.state.place, self.state.direction.take()) else {
            return Err(fault("no location, or no INDIRV, before the circle"));
        };
        let scale = self.state.scale;
        let center = Point3::new(x, y, z) * scale;
        // The turn from the radius to the direction of travel: r × t is the axis of the arc.
        let normal = UnitVector3::try_new((place.tip - center).cross(&direction), 0.0)
            .ok_or_else(|| fault("the circle does not start in the direction of INDIRV"))?;
        let circle = AnnouncedCircle {
            center,
            normal,
            radius: Some(radius * scale),
            sweep: None,
            turned: None,
        };
        self.state.shape = PathShape::Circle(circle);
        self.locate(of, Point3::new(ex, ey, ez) * scale)
    }

    /// Returns the path to `tip` on a circle, or a straight one where a circle for several
    /// locations has ended.
    fn on(
        &mut self,
        of: &Statement<'_>,
        circle: AnnouncedCircle,
        tip: &Point3<f64>,
    ) -> ClResult<ClPath> {
        self.state.shape = PathShape::Straight;
        let Some(place) = self.state.place else {
            let message = "an arc, and no location before it".to_owned();
            return Err(Box::new(of.fault(0, message, "write GOTO before it")));
        };
        let turn = circle.turn(&place.tip, tip);
        // A location off the circle ends one that holds for several; else it is a fault.
        let Some((sweep, normal)) = turn else {
            if circle.turned.is_some_and(|turned| turned > 0.0) {
                return Ok(ClPath::Straight);
            }
            let across = |point| circle.across(point).norm();
            let radius = circle.radius.unwrap_or(across(&place.tip));
            let message = format!(
                "start and end are {:.4} and {:.4} mm from the axis of an arc of {radius:.4} mm",
                across(&place.tip),
                across(tip)
            );
            return Err(Box::new(of.fault(0, message, "post the arc as points (linear output)")));
        };
        if let Some(turned) = circle.turned {
            let turned = turned + sweep;
            // More than once round: a straight move that ends on the circle.
            if turned > TAU * (1.0 + RADIUS_SLACK[1]) {
                return Ok(ClPath::Straight);
            }
            self.state.shape =
                PathShape::Circle(AnnouncedCircle { turned: Some(turned), ..circle });
        }
        Ok(ClPath::Arc(ClArc { start: place.tip, center: circle.center, normal, sweep }))
    }
}

impl AnnouncedCircle {
    fn across(&self, point: &Point3<f64>) -> Vector3<f64> {
        let way = point - self.center;
        // Component square to the axis of the arc.
        way - self.normal.scale(way.dot(&self.normal))
    }

    /// Returns the angle from one point to another by the right-hand rule, in (0, 2π], and the
    /// axis; `None` where one is
    /// off the circle.
    fn turn(&self, from: &Point3<f64>, to: &Point3<f64>) -> Option<(f64, UnitVector3<f64>)> {
        let [a, b] = [from, to].map(|point| self.across(point));
        let radius = self.radius.unwrap_or(a.norm());
        // An absolute slack for rounded coordinates, a relative one for rounded angles.
        let slack = RADIUS_SLACK[0].max(RADIUS_SLACK[1] * radius);
        if [a, b].iter().any(|way| (way.norm() - radius).abs() > slack) || radius <= 0.0 {
            return None;
        }
        // a × b = |a| |b| sin along the axis; a · b = |a| |b| cos.
        let angle = math::atan2(a.cross(&b).dot(&self.normal), a.dot(&b));
        let sweep = if angle > 0.0 { angle } else { angle + TAU };
        // Some writers do not turn the axis round for clockwise arcs; the written angle decides.
        match self.sweep {
            Some(written) if (TAU - sweep - written).abs() < (sweep - written).abs() => {
                Some((TAU - sweep, -self.normal))
            }
            _ => Some((sweep, self.normal)),
        }
    }
}

/// Reads the numbers of a geometry in a `TLON`, as many as it has, up to six.
fn in_kind(rest: ClWord<'_>, kind: &str) -> Option<[f64; 6]> {
    let mut values = [0.0; 6];
    let mut words = rest.parts().skip_while(|word| !word.is(kind)).skip(1);
    let needed = if kind == "LINE" { 6 } else { 4 };
    for slot in values.iter_mut().take(needed) {
        *slot = words.next()?.number()?;
    }
    Some(values)
}
