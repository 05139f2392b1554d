//! State of a CL file from statement to statement.

use super::path::ClHole;
use crate::types::{Diagnostic, ToolPose};
use crate::words::Coolant;
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};

/// Modal state for the next statement.
#[derive(Debug)]
pub(super) struct ClState {
    pub(super) scale: f64,
    /// True once the file has declared its units.
    pub(super) units: bool,
    pub(super) axis: UnitVector3<f64>,
    /// Tool axis of the frame.
    pub(super) frame_axis: UnitVector3<f64>,
    /// Speed \[mm/s\].
    pub(super) feed: Option<f64>,
    /// Spindle speed \[1/s\].
    pub(super) spindle: Option<f64>,
    pub(super) rapid: bool,
    pub(super) shape: PathShape,
    /// `INDIRV`: direction in which a curve starts.
    pub(super) direction: Option<Vector3<f64>>,
    pub(super) cycle: Option<ClCycle>,
    /// Current pose of the tool.
    pub(super) place: Option<ToolPose>,
    pub(super) frame: Isometry3<f64>,
    pub(super) first_frame: Option<Isometry3<f64>>,
    pub(super) world: bool,
    pub(super) directive: Option<String>,
    /// Diameter and corner radius in the unit of the file, which may be declared later.
    pub(super) cutter: Option<[f64; 2]>,
    pub(super) tool: Option<u32>,
    pub(super) coolant: Coolant,
    pub(super) end: Option<FileEnd>,
}

/// End of the file or path, as far as it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FileEnd {
    File,
    Path,
}

/// Result of a statement: a diagnostic stands where it was found.
pub(super) type ClResult<T> = Result<T, Box<Diagnostic>>;

/// Path on which the next location is reached.
#[derive(Debug, Clone, Copy)]
pub(super) enum PathShape {
    Straight,
    Circle(AnnouncedCircle),
}

/// A cycle that holds for the locations that follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClCycle {
    pub(super) hole: ClHole,
    /// Feed in the hole \[mm/s\]; that of `FEDRAT` if there is none.
    pub(super) feed: Option<f64>,
    /// `RTRCTO,AUTO`: up to where the tool stood before.
    pub(super) auto: bool,
}

/// A circle that was announced.
#[derive(Debug, Clone, Copy)]
pub(super) struct AnnouncedCircle {
    pub(super) center: Point3<f64>,
    pub(super) normal: UnitVector3<f64>,
    pub(super) radius: Option<f64>,
    /// Angle of the turn as written \[rad\].
    pub(super) sweep: Option<f64>,
    /// Holds for all locations on it, of which this angle has been turned.
    pub(super) turned: Option<f64>,
}

impl PathShape {
    /// Ends a circle that holds for several locations, at the next statement of another kind.
    pub(super) fn leave(&mut self) {
        if let Self::Circle(AnnouncedCircle { turned: Some(turned), .. }) = self
            && *turned > 0.0
        {
            *self = Self::Straight;
        }
    }
}
