//! Layout of solids: stock and fixtures.

use schemars::JsonSchema;
use serde::Deserialize;

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in super::super) struct RawStock {
    /// Kind of stock, which decides the other keys. offset: thickness; box: min, max; cylinder: base, radius, height;
    /// stl: file, optionally origin, rotation; step: file, optionally chord, origin, rotation.
    pub(in super::super) kind: RawStockKind,
    /// Thickness of the material on the part, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(in super::super) thickness: Option<f64>,
    #[serde(flatten)]
    pub(in super::super) solid: RawSolid,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in super::super) struct RawFixture {
    /// Name of the fixture in findings. Default: its file, or its kind and numbers.
    #[schemars(length(min = 1))]
    pub(in super::super) name: Option<String>,
    /// Kind of solid, which decides the other keys. box: min, max; cylinder: base, radius, height; stl: file, optionally
    /// origin, rotation; step: file, optionally chord, origin, rotation.
    pub(in super::super) kind: RawSolidKind,
    #[serde(flatten)]
    pub(in super::super) solid: RawSolid,
}

// Keys that stock and fixtures share, in the workpiece frame. A plain comment, because the description
// of a flattened struct would become that of both tables.
#[derive(Debug, Deserialize, JsonSchema)]
pub(in super::super) struct RawSolid {
    /// Corner of the box with the smallest coordinates, in mm.
    pub(in super::super) min: Option<[f64; 3]>,
    /// Corner of the box with the largest coordinates, in mm.
    pub(in super::super) max: Option<[f64; 3]>,
    /// Centre of the lower end of the cylinder, in mm.
    pub(in super::super) base: Option<[f64; 3]>,
    /// Radius of the cylinder, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(in super::super) radius: Option<f64>,
    /// Height of the cylinder, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(in super::super) height: Option<f64>,
    /// STL file in mm, or STEP file, relative to this file.
    #[schemars(length(min = 1))]
    pub(in super::super) file: Option<String>,
    /// Largest distance of the triangles that represent a STEP solid from its faces, in mm. A fixture is enlarged by it.
    /// Default: 0.01.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 10.0))]
    pub(in super::super) chord: Option<f64>,
    /// Position of the file's origin in the part's coordinates, in mm. Default: 0, 0, 0.
    pub(in super::super) origin: Option<[f64; 3]>,
    /// Rotation of the solid about the part's fixed x, then y, then z, in degrees, before it is moved to `origin`.
    /// Default: 0, 0, 0.
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub(in super::super) rotation: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum RawStockKind {
    Offset,
    Box,
    Cylinder,
    Stl,
    Step,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum RawSolidKind {
    Box,
    Cylinder,
    Stl,
    Step,
}

impl RawStockKind {
    /// Returns the kind of solid; `None` for an offset of the part.
    pub(in super::super) fn solid(self) -> Option<RawSolidKind> {
        match self {
            Self::Offset => None,
            Self::Box => Some(RawSolidKind::Box),
            Self::Cylinder => Some(RawSolidKind::Cylinder),
            Self::Stl => Some(RawSolidKind::Stl),
            Self::Step => Some(RawSolidKind::Step),
        }
    }
}
