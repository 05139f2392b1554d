//! Job: everything that the chain needs, checked and in internal units.

use super::budget::{Budget, BudgetError};
use super::fixtures::Held;
use crate::cover;
use crate::cutter::{Cutter, CutterError};
use crate::files::job::{self, JobFile};
use crate::import::inspect;
use crate::machine::Kinematics;
use crate::surface::{FaceIndex, SurfaceError};
use crate::types::Mesh;
use crate::verify::Solid;
use nalgebra::{Isometry3, Point3, Unit, UnitVector3, Vector3};
use rayon::prelude::*;

/// Everything that one run needs. Created by [`Job::new`] from files that were read elsewhere.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name of the operation; empty if the job has only one.
    pub name: String,
    /// Index of the operation.
    pub index: usize,
    /// The operations behind this one, in order, each as a job of its own.
    pub following: Vec<Job>,
    /// The job file, checked.
    pub file: JobFile,
    /// Faces to machine, in the order of the job, ready for closest-point queries.
    pub faces: Vec<FaceIndex>,
    /// Other faces of the part, which the tool must avoid.
    pub others: Vec<FaceIndex>,
    /// Other faces that cannot be worked with, by number, with the error.
    pub unguarded: Vec<(usize, SurfaceError)>,
    /// Stock, if it is known as a solid; [`Job::with_stock`] sets one from a file.
    pub stock: Option<Solid>,
    /// Fixtures, in the order of the job; [`Job::with_fixture`] sets one from a file.
    pub fixtures: Vec<Held>,
    /// The cutter.
    pub cutter: Cutter,
    /// Tools that other programs call beside it, by number, for their check.
    pub other_tools: Vec<(u32, Cutter)>,
    /// Machine, setup and tool as one chain.
    pub kinematics: Kinematics,
    /// The tolerance, split.
    pub budget: Budget,
}

/// Reason for refusing a job.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// A face that the part does not have.
    #[error("the part has no face {number}; it has {available}")]
    NoFace {
        /// Number asked for.
        number: usize,
        /// Numbers there are, in words.
        available: String,
        /// Key of the job file that names it.
        key: &'static str,
    },
    /// A part without a face.
    #[error("the part has no face to machine")]
    EmptyPart,
    /// A face that cannot be worked with.
    #[error("face {number}: {error}")]
    Face {
        /// Number of the face.
        number: usize,
        /// Error of the surface.
        error: SurfaceError,
    },
    /// The cutter.
    #[error(transparent)]
    Cutter(#[from] CutterError),
    /// The tolerance.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}

/// Key of the faces to cut.
pub(super) const FACES: &str = "part.faces";

impl JobError {
    /// Returns the key of the job file that the error is about.
    pub(super) fn key(&self) -> &'static str {
        match self {
            Self::NoFace { key, .. } => key,
            Self::EmptyPart => FACES,
            Self::Face { .. } => "part.file",
            Self::Cutter(_) => "tool",
            Self::Budget(_) => "tolerance",
        }
    }
}

/// Least sum of the area normals of the faces, as a share of their area, for a mean normal to exist.
const LEAST_SENSE: f64 = 0.05;

/// Cosine between mean normal and workpiece z below which links no longer go up along z: a tool on such a face would
/// have to leave it sideways.
const LEAST_RISE: f64 = 0.5;

impl Job {
    /// Returns the operations in the order in which they are cut, this job as the first.
    pub fn operations(&self) -> impl Iterator<Item = &Job> {
        std::iter::once(self).chain(&self.following)
    }

    /// Returns the operation of an index as a job of its own, with stock and fixtures of this job, and without the tools of
    /// the other operations; `None` if there is none.
    pub fn into_operation(mut self, index: usize) -> Option<Self> {
        let of_operations: Vec<u32> = self.operations().map(|one| one.file.tool.number).collect();
        let mut other_tools = std::mem::take(&mut self.other_tools);
        other_tools.retain(|(number, _)| !of_operations.contains(number));
        let following = std::mem::take(&mut self.following);
        if self.index == index {
            return Some(Self { other_tools, ..self });
        }
        let found = following.into_iter().find(|one| one.index == index)?;
        Some(Self { stock: self.stock, fixtures: self.fixtures, other_tools, ..found })
    }

    /// Returns the faces that some operation cuts, each once.
    pub fn cut_faces(&self) -> Vec<&FaceIndex> {
        let mut all: Vec<&FaceIndex> = Vec::new();
        for face in self.operations().flat_map(|one| &one.faces) {
            if all.iter().all(|known| known.face().number != face.face().number) {
                all.push(face);
            }
        }
        all
    }

    /// Returns the faces that every operation must avoid.
    pub fn avoided_faces(&self) -> Vec<&FaceIndex> {
        let cut = self.cut_faces();
        let is_cut =
            |face: &&FaceIndex| cut.iter().any(|other| other.face().number == face.face().number);
        self.others.iter().filter(|face| !is_cut(face)).collect()
    }

    /// Sets the stock from its file, moved to its place in the job.
    #[must_use]
    pub fn with_stock(self, mesh: Mesh) -> Self {
        let solid = self.file.stock.as_ref().and_then(job::JobStock::solid);
        let place = solid.map_or_else(Isometry3::identity, job::JobSolid::place);
        self.with_stock_solid(&Solid::Mesh(mesh.moved(&place)))
    }

    fn with_stock_solid(mut self, stock: &Solid) -> Self {
        self.stock = Some(stock.clone());
        let following = std::mem::take(&mut self.following).into_iter();
        self.following = following.map(|one| one.with_stock_solid(stock)).collect();
        self
    }

    /// Sets the solid of a fixture from its file, moved to its place in the job; `number` counts from 0.
    #[must_use]
    pub fn with_fixture(self, number: usize, mesh: Mesh) -> Self {
        let place = self.file.fixtures.get(number).map(|fixture| fixture.solid.place());
        let place = place.unwrap_or_else(Isometry3::identity);
        self.with_fixture_solid(number, &Solid::Mesh(mesh.moved(&place)))
    }

    fn with_fixture_solid(mut self, number: usize, solid: &Solid) -> Self {
        if let Some(held) = self.fixtures.get_mut(number) {
            held.solid = Some(solid.clone());
        }
        let following = std::mem::take(&mut self.following).into_iter();
        self.following = following.map(|one| one.with_fixture_solid(number, solid)).collect();
        self
    }
}

impl Job {
    /// Returns the direction in which the tool leaves the part.
    ///
    /// It is workpiece z, unless the faces look too far to the side; then it is their mean normal. Faces that look
    /// all round have no mean normal.
    pub(super) fn up(&self) -> UnitVector3<f64> {
        let elements = || self.faces.iter().flat_map(|face| inspect::elements(face.face()));
        let mean: Vector3<f64> = elements().map(|element| element.area).sum();
        let area: f64 = elements().map(|element| element.area.norm()).sum();
        // Area normals of a closed surface cancel out: their sum is small beside the area.
        match Unit::try_new(mean, LEAST_SENSE * area) {
            Some(normal) if normal.z < LEAST_RISE => normal,
            _ => Vector3::z_axis(),
        }
    }

    /// Returns the highest point of part and stock along `up` \[mm\].
    pub(super) fn highest(&self, up: &UnitVector3<f64>) -> f64 {
        cover::height(&self.boxes(), up) + self.thickness()
    }

    /// Returns boxes that enclose part and stock, without [`Job::thickness`].
    pub(super) fn boxes(&self) -> Vec<[Point3<f64>; 2]> {
        let bounds = |face: &FaceIndex| inspect::summary(face.face()).bounds;
        let mut boxes: Vec<_> = self.faces.par_iter().chain(&self.others).map(bounds).collect();
        // Stock of even thickness on the part is counted by its thickness.
        let stock = self.stock.as_ref().filter(|_| self.thickness() <= 0.0);
        boxes.extend(stock.and_then(Solid::bounds));
        boxes
    }

    /// Returns the thickness of even stock on the part \[mm\]; 0 for other stock.
    pub(super) fn thickness(&self) -> f64 {
        match &self.file.stock {
            Some(job::JobStock::Offset { thickness }) => *thickness,
            _ => 0.0,
        }
    }

    /// Returns the length of a lead that runs at the cutting feed \[mm\].
    ///
    /// It is half the cutter radius above the material; all of the lead if the stock is not known to follow the part.
    pub(super) fn approach(&self) -> f64 {
        let above = 0.5 * self.cutter.radius();
        match &self.file.stock {
            None => above,
            Some(job::JobStock::Offset { thickness }) => above + thickness,
            Some(_) => f64::INFINITY,
        }
    }
}
