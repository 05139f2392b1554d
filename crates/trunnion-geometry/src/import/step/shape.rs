//! Surfaces as a STEP file states them.

use super::curve::StepCurve;
use super::curve::StepKnots;
use super::curve::positive;
use super::model::MAX_CHAIN;
use super::model::Read;
use super::model::RecordFields;
use super::model::StepFrame;
use super::model::StepModel;
use super::model::loss;
use super::part21::StepInstance;
use super::part21::StepValue;
use nalgebra::Point3;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// A surface with the parametrisation STEP gives it, except that lengths are mm and angles rad.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StepShape {
    /// u along x, v along y.
    Plane(StepFrame),
    /// u about z, v along z.
    Cylinder { frame: StepFrame, radius: f64 },
    /// As a cylinder; the radius at v is `radius + v tan(angle)`.
    Cone { frame: StepFrame, radius: f64, angle: f64 },
    /// u about z, v from the equator towards z.
    Sphere { frame: StepFrame, radius: f64 },
    /// u about z, v about the tube, from its outer equator towards z.
    Torus { frame: StepFrame, major: f64, minor: f64 },
    /// `curve(u) + v direction`.
    Extrusion { curve: StepCurve, direction: Vector3<f64> },
    /// `curve(v)` turned by u about the z axis of the frame.
    Revolution { curve: StepCurve, axis: StepFrame },
    /// Control net, rational or not.
    Net(Net),
}

/// A B-spline control net; `points[i][j]` with i along u.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Net {
    pub(super) degree: [usize; 2],
    pub(super) knots: [Vec<f64>; 2],
    pub(super) points: Vec<Vec<Point3<f64>>>,
    pub(super) weights: Option<Vec<Vec<f64>>>,
}

impl<'a> StepModel<'a> {
    pub(super) fn shape(&self, id: u64, from: u64) -> Read<StepShape> {
        self.shape_in(id, from, 0)
    }

    fn shape_in(&self, id: u64, from: u64, depth: usize) -> Read<StepShape> {
        if depth > MAX_CHAIN {
            return loss(id, "the surface refers to itself");
        }
        let instance = self.instance(id, from)?;
        if let Some(net) = self.net(instance)? {
            return Ok(StepShape::Net(net));
        }
        let Some(fields) = Self::simple(instance) else {
            return loss(id, format!("{} is not a surface this reader knows", instance.kind()));
        };
        match fields.name {
            "RECTANGULAR_TRIMMED_SURFACE" => self.shape_in(fields.reference(1)?, id, depth + 1),
            "SURFACE_OF_LINEAR_EXTRUSION" => Ok(StepShape::Extrusion {
                curve: self.curve(fields.reference(1)?, id)?,
                direction: self.vector(fields.reference(2)?, id)?,
            }),
            "SURFACE_OF_REVOLUTION" => Ok(StepShape::Revolution {
                curve: self.curve(fields.reference(1)?, id)?,
                axis: self.frame(fields.reference(2)?, id)?,
            }),
            _ => self.elementary(fields),
        }
    }

    fn elementary(&self, fields: RecordFields<'a>) -> Read<StepShape> {
        let frame = || self.frame(fields.reference(1)?, fields.id);
        match fields.name {
            "PLANE" => Ok(StepShape::Plane(frame()?)),
            "CYLINDRICAL_SURFACE" => {
                Ok(StepShape::Cylinder { frame: frame()?, radius: fields.radius(2, self)? })
            }
            "CONICAL_SURFACE" => self.cone(fields, frame()?),
            "SPHERICAL_SURFACE" => {
                Ok(StepShape::Sphere { frame: frame()?, radius: fields.radius(2, self)? })
            }
            "TOROIDAL_SURFACE" | "DEGENERATE_TOROIDAL_SURFACE" => {
                let [major, minor] = [fields.radius(2, self)?, fields.radius(3, self)?];
                Ok(StepShape::Torus { frame: frame()?, major, minor })
            }
            other => loss(fields.id, format!("{other} is not a surface this reader knows")),
        }
    }

    /// Reads a cone. Its radius may be zero: its apex is the origin then.
    fn cone(&self, fields: RecordFields<'a>, frame: StepFrame) -> Read<StepShape> {
        let radius = fields.number(2)? * self.scale.length;
        let angle = fields.number(3)? * self.scale.angle;
        if !(radius >= 0.0 && radius.is_finite()) {
            return loss(fields.id, format!("the cone has a radius of {radius} mm"));
        }
        if !(angle > 0.0 && angle < FRAC_PI_2) {
            let degrees = angle.to_degrees();
            let message = format!(
                "the cone has a half angle of {degrees} degrees; it must lie between 0 and 90"
            );
            return loss(fields.id, message);
        }
        Ok(StepShape::Cone { frame, radius, angle })
    }

    /// Reads any kind of B-spline surface; `None` if it is something else.
    fn net(&self, instance: &'a StepInstance) -> Read<Option<Net>> {
        let id = instance.id;
        let complex = Self::part(instance, "B_SPLINE_SURFACE");
        let names = [
            "B_SPLINE_SURFACE_WITH_KNOTS",
            "BEZIER_SURFACE",
            "QUASI_UNIFORM_SURFACE",
            "UNIFORM_SURFACE",
        ];
        let Some(kind) = names.iter().find_map(|name| Self::part(instance, name)) else {
            return Ok(None);
        };
        // A simple entity has its label first; the parts of a complex one have none.
        let (base, skip) = complex.map_or((kind, 1), |base| (base, 0));
        let degree = [base.count(skip)?, base.count(skip + 1)?];
        let points = self.net_points(base, skip + 2)?;
        let columns = points.first().map_or(0, Vec::len);
        let knots = match kind.name {
            "B_SPLINE_SURFACE_WITH_KNOTS" => {
                // Label, two degrees, net, form, two flags of closure, self-intersection; then
                // multiplicities.
                let first = if complex.is_some() { 0 } else { 8 };
                [0, 1].map(|k| {
                    let counts = kind.counts(first + k)?;
                    Ok(StepKnots::Given { counts, values: kind.numbers(first + 2 + k)? })
                })
            }
            "UNIFORM_SURFACE" => [Ok(StepKnots::Uniform), Ok(StepKnots::Uniform)],
            _ => [Ok(StepKnots::Even), Ok(StepKnots::Even)],
        };
        let [ku, kv] = knots;
        let ku = ku?.expand(degree[0], points.len(), id)?;
        let kv = kv?.expand(degree[1], columns, id)?;
        let weights = match Self::part(instance, "RATIONAL_B_SPLINE_SURFACE") {
            Some(fields) => Some(weights(fields, &points)?),
            None => None,
        };
        let knots = [ku.knots().to_vec(), kv.knots().to_vec()];
        Ok(Some(Net { degree, knots, points, weights }))
    }

    fn net_points(&self, fields: RecordFields<'a>, index: usize) -> Read<Vec<Vec<Point3<f64>>>> {
        let row = |row: &StepValue| -> Read<Vec<Point3<f64>>> {
            let Some(row) = row.list() else {
                return loss(fields.id, "a row of the control net is not a list");
            };
            row.iter()
                .map(|point| match point.reference() {
                    Some(point) => self.point(point, fields.id),
                    None => loss(fields.id, "the control net holds something else than points"),
                })
                .collect()
        };
        fields.list(index)?.iter().map(row).collect()
    }
}

fn weights(fields: RecordFields<'_>, points: &[Vec<Point3<f64>>]) -> Read<Vec<Vec<f64>>> {
    let rows = fields.list(0)?;
    if rows.len() != points.len() {
        let message = format!("{} rows of weights for {} of points", rows.len(), points.len());
        return loss(fields.id, message);
    }
    rows.iter()
        .zip(points)
        .map(|(row, points)| {
            let numbers: Option<Vec<f64>> =
                row.list().and_then(|row| row.iter().map(StepValue::number).collect());
            match numbers {
                Some(numbers) => positive(&numbers, points.len(), fields.id),
                None => loss(fields.id, "the weights are not numbers"),
            }
        })
        .collect()
}
