//! Part and machine for which a job is proposed, and the proposal.

use super::left_out::LeftOutFace;
use crate::cover::FinishTolerance;
use crate::cutter::CutterSpec;
use crate::files::job::JobArea;
use crate::files::library::LibraryFile;
use crate::machine::Machine;
use crate::surface::Face;
use nalgebra::Vector3;

/// Tolerance of a proposal \[mm\].
pub(super) const TOLERANCE: FinishTolerance = FinishTolerance { excess: 0.02, gouge: 0.002 };

/// Part and machine for which a job is proposed. Begin with [`ProposalRequest::new`] and change the rest by struct
/// update.
#[derive(Debug, Clone, Copy)]
pub struct ProposalRequest<'a> {
    /// Faces of the part.
    pub faces: &'a [Face],
    /// Numbers of the faces to choose from; `None`: all.
    pub wanted: Option<&'a [usize]>,
    /// Angles by which the part is turned about x, then y, then z \[rad\]; `None`: a quarter turn or a half where a
    /// tool then reaches much more of the part from above than as it is drawn.
    pub angles: Option<[f64; 3]>,
    /// Machine that is to cut it.
    pub machine: &'a Machine,
    /// Library of the cutters to choose from; `None`: the standard one.
    pub library: Option<&'a LibraryFile>,
}

impl<'a> ProposalRequest<'a> {
    /// Requests a job for all faces of a part.
    pub const fn new(faces: &'a [Face], machine: &'a Machine) -> Self {
        Self { faces, wanted: None, angles: None, machine, library: None }
    }
}

/// Job that is proposed: everything that a job file needs besides names.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobProposal {
    /// Numbers of the faces to cut.
    pub faces: Vec<usize>,
    /// Angles by which the part is turned about x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// `true` if the cutter works on the other side of the faces.
    pub flip: bool,
    /// Faces that the job does not cut, each with the reason.
    pub left_out: Vec<LeftOutFace>,
    /// Operations in the order in which they are cut; at least one.
    pub operations: Vec<ProposedOperation>,
    /// Tightest concave radius of the faces to cut \[mm\]; infinite where they are nowhere concave.
    pub concave_radius: f64,
    /// Workpiece origin in machine coordinates \[mm\]; the workpiece is the turned part.
    pub origin: Vector3<f64>,
    /// Height of the clearance plane above the part \[mm\].
    pub clearance: f64,
    /// Tolerance.
    pub tolerance: FinishTolerance,
}

/// Operation of a proposed job: a cutter over some faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ProposedOperation {
    /// Numbers of the faces to cut.
    pub faces: Vec<usize>,
    /// Part of them that it cuts.
    pub area: JobArea,
    /// Cutter.
    pub cutter: CutterSpec,
    /// Feed \[mm/s\].
    pub feed: f64,
    /// Spindle speed \[rev/s\].
    pub spindle: f64,
}
