//! Layout of solids: stock and fixtures.

use schemars::JsonSchema;
use serde::Deserialize;

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in super::super) struct RawStock {
    /// Which of the keys below apply: offset: thickness; box: min, max; cylinder: base, radius,
    /// height; stl: file; step: file, and chord if wanted; of both, origin and rotation if wanted.
    pub(in super::super) kind: RawStockKind,
    /// Material left on the part, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(in super::super) thickness: Option<f64>,
    #[serde(flatten)]
    pub(in super::super) solid: RawSolid,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in super::super) struct RawFixture {
    /// What findings call it; left out: its file, or its kind and numbers.
    #[schemars(length(min = 1))]
    pub(in super::super) name: Option<String>,
    /// Which of the keys below apply: box: min, max; cylinder: base, radius, height; stl: file;
    /// step: file, and chord if wanted; of both, origin and rotation if wanted.
    pub(in super::super) kind: RawSolidKind,
    #[serde(flatten)]
    pub(in super::super) solid: RawSolid,
}

// What stock and fixtures have in common, in the workpiece frame.
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
    /// How far the triangles that stand for a STEP solid may be off its faces, in mm; 0.01 if left out. A fixture is
    /// taken to be larger by that.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 10.0))]
    pub(in super::super) chord: Option<f64>,
    /// Where the origin of the file lies in the part's coordinates, in mm; 0, 0, 0 if left out.
    pub(in super::super) origin: Option<[f64; 3]>,
    /// Turns of what is in the file about the part's fixed x, then y, then z, in degrees, before it is moved to its
    /// origin.
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
    /// The same of a solid; `None` for an offset.
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
