//! Typed access to the records of a file: numbers, points, directions, placements, in mm and rad.

use super::part21::StepExchange;
use super::part21::StepInstance;
use super::part21::StepValue;
use nalgebra::Isometry3;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// mm and rad, assumed of a file that states no units.
pub(super) const ASSUMED: UnitScale = UnitScale { length: 1.0, angle: 1.0 };

/// Longest chain of references that is not taken for a circle. Curves on surfaces on
/// curves nest three or four deep in real files.
pub(super) const MAX_CHAIN: usize = 16;

/// Something the file holds and the result does not.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceLoss {
    /// The entity it is about.
    pub(super) entity: u64,
    /// Thing lost, and the reason.
    pub(super) message: String,
}

pub(super) type Read<T> = Result<T, FaceLoss>;

pub(super) fn loss<T>(entity: u64, message: impl Into<String>) -> Read<T> {
    Err(FaceLoss { entity, message: message.into() })
}

/// Right-handed orthonormal axes at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepFrame {
    pub(super) origin: Point3<f64>,
    pub(super) x: UnitVector3<f64>,
    pub(super) y: UnitVector3<f64>,
    pub(super) z: UnitVector3<f64>,
}

impl StepFrame {
    /// Creates the frame with `z` along `axis` and `x` as close to `reference` as that allows. STEP
    /// lets the reference be left out, or be parallel to the axis; any perpendicular will do then.
    pub(super) fn new(
        origin: Point3<f64>,
        axis: UnitVector3<f64>,
        reference: Option<UnitVector3<f64>>,
    ) -> Self {
        let across = |v: Vector3<f64>| {
            let part = v - axis.scale(axis.dot(&v));
            // Rounding leaves about 1e-16 of a parallel unit vector; a direction of a file has
            // some ten digits.
            UnitVector3::try_new(part, 1e-12)
        };
        let x = reference
            .and_then(|r| across(r.into_inner()))
            .or_else(|| across(Vector3::x()))
            .or_else(|| across(Vector3::y()))
            .unwrap_or_else(Vector3::z_axis);
        let y = UnitVector3::new_normalize(axis.cross(&x));
        Self { origin, x, y, z: axis }
    }

    /// Returns the point with these coordinates along the axes.
    pub(super) fn point(&self, x: f64, y: f64, z: f64) -> Point3<f64> {
        self.origin + self.x.scale(x) + self.y.scale(y) + self.z.scale(z)
    }

    /// Returns the coordinates of `p` along the axes.
    pub(super) fn local(&self, p: &Point3<f64>) -> Vector3<f64> {
        let d = p - self.origin;
        Vector3::new(self.x.dot(&d), self.y.dot(&d), self.z.dot(&d))
    }
}

/// Factors from the units of the file to mm and rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UnitScale {
    pub(super) length: f64,
    pub(super) angle: f64,
}

/// A file and the units of the representation being read.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepModel<'a> {
    pub(super) exchange: &'a StepExchange,
    pub(super) scale: UnitScale,
    /// Placement of the representation: `file_from_representation`.
    pub(super) place: Isometry3<f64>,
}

/// Parameters of one record, with the entity they belong to, for messages.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecordFields<'a> {
    pub(super) id: u64,
    pub(super) name: &'a str,
    pub(super) values: &'a [StepValue],
}

impl<'a> RecordFields<'a> {
    pub(super) fn value(&self, index: usize) -> Read<&'a StepValue> {
        match self.values.get(index) {
            Some(value) => Ok(value),
            None => loss(self.id, format!("{} has no parameter {}", self.name, index + 1)),
        }
    }

    fn wrong<T>(&self, index: usize, wanted: &str) -> Read<T> {
        loss(self.id, format!("parameter {} of {} is not {wanted}", index + 1, self.name))
    }

    pub(super) fn number(&self, index: usize) -> Read<f64> {
        self.value(index)?.number().map_or_else(|| self.wrong(index, "a number"), Ok)
    }

    pub(super) fn count(&self, index: usize) -> Read<usize> {
        self.value(index)?.count().map_or_else(|| self.wrong(index, "a count"), Ok)
    }

    pub(super) fn reference(&self, index: usize) -> Read<u64> {
        self.value(index)?.reference().map_or_else(|| self.wrong(index, "a reference"), Ok)
    }

    pub(super) fn truth(&self, index: usize) -> Read<bool> {
        self.value(index)?.truth().map_or_else(|| self.wrong(index, ".T. or .F."), Ok)
    }

    pub(super) fn list(&self, index: usize) -> Read<&'a [StepValue]> {
        self.value(index)?.list().map_or_else(|| self.wrong(index, "a list"), Ok)
    }

    pub(super) fn numbers(&self, index: usize) -> Read<Vec<f64>> {
        let numbers: Option<Vec<f64>> = self.list(index)?.iter().map(StepValue::number).collect();
        numbers.map_or_else(|| self.wrong(index, "a list of numbers"), Ok)
    }

    pub(super) fn counts(&self, index: usize) -> Read<Vec<usize>> {
        let counts: Option<Vec<usize>> = self.list(index)?.iter().map(StepValue::count).collect();
        counts.map_or_else(|| self.wrong(index, "a list of counts"), Ok)
    }

    pub(super) fn references(&self, index: usize) -> Read<Vec<u64>> {
        let ids: Option<Vec<u64>> = self.list(index)?.iter().map(StepValue::reference).collect();
        ids.map_or_else(|| self.wrong(index, "a list of references"), Ok)
    }

    /// Reads a length that must be positive \[mm\].
    pub(super) fn radius(&self, index: usize, model: &StepModel<'_>) -> Read<f64> {
        // Scaled first: a positive number may underflow in mm.
        let radius = self.number(index)? * model.scale.length;
        if radius > 0.0 && radius.is_finite() {
            return Ok(radius);
        }
        loss(self.id, format!("{} has a radius of {radius} mm; it must be positive", self.name))
    }
}

impl<'a> StepModel<'a> {
    /// Creates the view of a file as it is: its own units, its own frame.
    pub(super) fn plain(exchange: &'a StepExchange) -> Self {
        Self { exchange, scale: ASSUMED, place: Isometry3::identity() }
    }

    pub(super) fn instance(&self, id: u64, from: u64) -> Read<&'a StepInstance> {
        match self.exchange.get(id) {
            Some(instance) => Ok(instance),
            None => loss(from, format!("refers to #{id}, which the file does not define")),
        }
    }

    /// Returns the fields of the part called `name`.
    pub(super) fn part(instance: &'a StepInstance, name: &str) -> Option<RecordFields<'a>> {
        let record = instance.part(name)?;
        Some(RecordFields { id: instance.id, name: &record.name, values: &record.values })
    }

    /// Returns the fields of a simple entity, whatever its name.
    pub(super) fn simple(instance: &'a StepInstance) -> Option<RecordFields<'a>> {
        match instance.records.as_slice() {
            [record] => {
                Some(RecordFields { id: instance.id, name: &record.name, values: &record.values })
            }
            _ => None,
        }
    }

    /// Returns the fields of an entity that must have one of these names.
    pub(super) fn named(&self, id: u64, from: u64, names: &[&str]) -> Read<RecordFields<'a>> {
        let instance = self.instance(id, from)?;
        let found = names.iter().find_map(|name| Self::part(instance, name));
        match found {
            Some(fields) => Ok(fields),
            None => loss(
                from,
                format!("refers to #{id}, a {}, where {} is due", instance.kind(), names.join("|")),
            ),
        }
    }

    fn triple(fields: RecordFields<'a>) -> Read<Vector3<f64>> {
        match fields.numbers(1)?.as_slice() {
            &[x, y, z] => Ok(Vector3::new(x, y, z)),
            // Parameter-space entities have two coordinates; none is ever read as a point in space.
            other => loss(fields.id, format!("{} coordinates where 3 are due", other.len())),
        }
    }

    /// Reads a point \[mm\].
    pub(super) fn point(&self, id: u64, from: u64) -> Read<Point3<f64>> {
        let fields = self.named(id, from, &["CARTESIAN_POINT"])?;
        // Units first: the placement is in mm.
        let p = self.place * Point3::from(Self::triple(fields)? * self.scale.length);
        if p.iter().all(|x| x.is_finite()) {
            return Ok(p);
        }
        loss(id, "the point is not finite in mm")
    }

    /// Reads a direction; STEP does not ask for unit length.
    pub(super) fn direction(&self, id: u64, from: u64) -> Read<UnitVector3<f64>> {
        let fields = self.named(id, from, &["DIRECTION"])?;
        let vector = Self::triple(fields)?;
        let largest = vector.amax();
        // Divided first, so that huge or tiny ratios neither overflow nor vanish when squared.
        match UnitVector3::try_new(vector / largest, 0.5) {
            Some(unit) => Ok(self.placed(unit.into_inner())),
            None => loss(id, "the direction has no length"),
        }
    }

    /// Reads a vector with length \[mm\].
    pub(super) fn vector(&self, id: u64, from: u64) -> Read<Vector3<f64>> {
        let fields = self.named(id, from, &["VECTOR"])?;
        let direction = self.direction(fields.reference(1)?, id)?;
        let length = fields.number(2)? * self.scale.length;
        if length.is_finite() && length != 0.0 {
            return Ok(direction.scale(length));
        }
        loss(id, "the vector has no length")
    }

    fn placed(&self, axis: Vector3<f64>) -> UnitVector3<f64> {
        UnitVector3::new_normalize(self.place * axis)
    }

    fn optional_direction(
        &self,
        fields: RecordFields<'a>,
        index: usize,
    ) -> Read<Option<UnitVector3<f64>>> {
        match fields.values.get(index).and_then(StepValue::reference) {
            Some(id) => self.direction(id, fields.id).map(Some),
            None => Ok(None),
        }
    }

    /// Reads an `AXIS2_PLACEMENT_3D` or `AXIS1_PLACEMENT`.
    pub(super) fn frame(&self, id: u64, from: u64) -> Read<StepFrame> {
        let fields = self.named(id, from, &["AXIS2_PLACEMENT_3D", "AXIS1_PLACEMENT"])?;
        let origin = self.point(fields.reference(1)?, id)?;
        // ISO 10303-42: an axis left out is z, a reference left out is x, both of the
        // representation.
        let axis = self.optional_direction(fields, 2)?.unwrap_or_else(|| self.placed(Vector3::z()));
        let reference = self.optional_direction(fields, 3)?;
        let reference = reference.unwrap_or_else(|| self.placed(Vector3::x()));
        Ok(StepFrame::new(origin, axis, Some(reference)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_right_handed_whatever_the_reference() {
        for reference in [None, Some(Vector3::z_axis()), Some(Vector3::y_axis())] {
            let frame = StepFrame::new(Point3::origin(), Vector3::z_axis(), reference);
            assert!((frame.x.cross(&frame.y) - Vector3::z()).norm() < 1e-15);
            let p = frame.point(1.0, 2.0, 3.0);
            assert!((frame.local(&p) - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
        }
    }
}
