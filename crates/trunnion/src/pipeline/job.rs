//! One job: everything the chain needs, checked and in internal units.

use super::budget::{Budget, BudgetError, Shares};
use super::fixtures::Held;
use super::{material, programs};
use crate::cover;
use crate::cutter::{Cutter, CutterConstruction, CutterError, CutterKind, CutterSpec};
use crate::files::job::{self, JobFile};
use crate::import::inspect;
use crate::machine::{Kinematics, Machine, Setup};
use crate::surface::{Face, FaceIndex, SurfaceError};
use crate::types::{Diagnostic, Diagnostics, Mesh};
use crate::verify::Solid;
use nalgebra::{Isometry3, Point3, Unit, UnitVector3, Vector3};

/// Everything one run needs. Made by [`Job::new`] from files that were read elsewhere.
#[derive(Debug)]
pub struct Job {
    /// The job file, checked.
    pub file: JobFile,
    /// Faces to machine, in the order of the job, ready for closest-point queries.
    pub faces: Vec<FaceIndex>,
    /// The other faces of the part, that the tool keeps off.
    pub others: Vec<FaceIndex>,
    /// Numbers of other faces that nothing can be kept off, and why.
    pub unguarded: Vec<(usize, SurfaceError)>,
    /// What it is cut from, if that is known as a solid: [`Job::with_stock`] for one from a file.
    pub stock: Option<Solid>,
    /// What the tool must not touch, in the order of the job: [`Job::with_fixture`] for one from a file.
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

/// Why a job cannot be run as it stands.
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
        /// Why.
        error: SurfaceError,
    },
    /// The cutter.
    #[error(transparent)]
    Cutter(#[from] CutterError),
    /// The tolerance.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}

impl JobError {
    /// Key of the job file this is about.
    fn key(&self) -> &'static str {
        match self {
            Self::NoFace { key, .. } => key,
            Self::EmptyPart => "part.faces",
            Self::Face { .. } => "part.file",
            Self::Cutter(_) => "tool",
            Self::Budget(_) => "tolerance",
        }
    }
}

impl Job {
    /// Puts a job together from its file, the faces of its part and its machine.
    ///
    /// # Errors
    ///
    /// All faults found, each at its line of the job file.
    pub fn new(file: JobFile, faces: &[Face], machine: &Machine) -> Result<Self, Diagnostics> {
        let mut faults = Vec::new();
        let cutter = Cutter::new(cutter_spec(&file.tool))
            .map_err(|errors| faults.extend(errors.into_iter().map(JobError::Cutter)))
            .ok();
        let (other_tools, mut tool_faults) = other_tools(&file);
        let (others, unguarded) = others(&file.part, faces).unwrap_or_else(|error| {
            faults.push(error);
            Default::default()
        });
        let faces = choose(&file.part, faces).map_err(|errors| faults.extend(errors)).ok();
        let kinematics = Kinematics::new(machine, &setup(&file));
        let needed = programs::expected_rounding(
            &kinematics,
            faces.as_deref().unwrap_or_default(),
            &file.dialects,
            cutter.as_ref().map_or(0.0, cover::lever),
        );
        let budget = budget(&file, needed).map_err(|error| faults.push(error.into())).ok();
        match (cutter, faces, budget) {
            (Some(cutter), Some(faces), Some(budget)) if tool_faults.is_empty() => {
                let all = faces.iter().chain(&others).map(FaceIndex::face);
                let stock = file.stock.as_ref().and_then(|stock| material::solid(stock, all));
                let fixtures = file.fixtures.iter().map(Held::of).collect();
                Ok(Self {
                    file,
                    faces,
                    others,
                    unguarded,
                    stock,
                    fixtures,
                    cutter,
                    other_tools,
                    kinematics,
                    budget,
                })
            }
            _ => {
                let place = |fault: JobError| file.places.fault(fault.key(), fault.to_string());
                tool_faults.splice(0..0, faults.into_iter().map(place));
                Err(tool_faults.into())
            }
        }
    }
}

impl Job {
    /// With what the job's stock file holds, moved to where the job places it.
    #[must_use]
    pub fn with_stock(self, mesh: Mesh) -> Self {
        let solid = self.file.stock.as_ref().and_then(job::Stock::solid);
        let place = solid.map_or_else(Isometry3::identity, job::Solid::place);
        Self { stock: Some(Solid::Mesh(mesh.moved(&place))), ..self }
    }

    /// With what the file of a fixture holds, moved to where the job places it; `number` counts the job's fixtures
    /// from 0.
    #[must_use]
    pub fn with_fixture(mut self, number: usize, mesh: Mesh) -> Self {
        let said = self.file.fixtures.get(number);
        if let (Some(held), Some(said)) = (self.fixtures.get_mut(number), said) {
            held.solid = Some(Solid::Mesh(mesh.moved(&said.solid.place())));
        }
        self
    }
}

impl Job {
    /// Way out of the part: workpiece z, unless the faces look too far to the side for the tool to be
    /// drawn out that way; then their mean normal. Faces that look all round have none.
    pub(super) fn up(&self) -> UnitVector3<f64> {
        let elements = || self.faces.iter().flat_map(|face| inspect::elements(face.face()));
        let mean: Vector3<f64> = elements().map(|element| element.area).sum();
        let area: f64 = elements().map(|element| element.area.norm()).sum();
        match Unit::try_new(mean, LEAST_SENSE * area) {
            Some(normal) if normal.z < LEAST_RISE => normal,
            _ => Vector3::z_axis(),
        }
    }

    /// Highest point of part and stock along `up` \[mm\].
    pub(super) fn highest(&self, up: &UnitVector3<f64>) -> f64 {
        cover::height(&self.boxes(), up) + self.thickness()
    }

    /// Boxes that hold part and stock, but for [`Job::thickness`].
    pub(super) fn boxes(&self) -> Vec<[Point3<f64>; 2]> {
        let all = self.faces.iter().chain(&self.others);
        let faces = all.map(|face| inspect::summary(face.face()).bounds);
        // What stands on the part is counted by its thickness.
        let stock = self.stock.as_ref().filter(|_| self.thickness() <= 0.0);
        faces.chain(stock.and_then(Solid::bounds)).collect()
    }

    /// What the stock stands out from the part all over \[mm\].
    pub(super) fn thickness(&self) -> f64 {
        match &self.file.stock {
            Some(job::Stock::Offset { thickness }) => *thickness,
            _ => 0.0,
        }
    }
}

/// Share of their area that the faces' normals have to add up to for them to look one way.
const LEAST_SENSE: f64 = 0.05;

/// Cosine between the faces' mean normal and workpiece z below which links no longer go up along z:
/// a tool standing on such a face would have to be drawn out sideways.
const LEAST_RISE: f64 = 0.5;

impl Job {
    /// Last stretch of a lead that is run at the cutting feed \[mm\]: half the cutter's radius above
    /// what there is to cut; all of it where the stock is not known to follow the part.
    pub(super) fn approach(&self) -> f64 {
        let above = 0.5 * self.cutter.radius();
        match &self.file.stock {
            None => above,
            Some(job::Stock::Offset { thickness }) => above + thickness,
            Some(_) => f64::INFINITY,
        }
    }
}

fn cutter_spec(tool: &job::Tool) -> CutterSpec {
    CutterSpec {
        kind: match tool.kind {
            job::ToolKind::Flat => CutterKind::Flat,
            job::ToolKind::Ball => CutterKind::Ball,
            job::ToolKind::Bull => CutterKind::Bull,
        },
        major: tool.major,
        minor: tool.minor,
        length: tool.length,
        construction: match tool.construction {
            job::Construction::Solid => CutterConstruction::Solid,
            job::Construction::Insert { inner_cutting_radius } => {
                CutterConstruction::Insert { inner_cutting_radius }
            }
        },
        shank: above_the_cutting_end(tool),
    }
}

/// Tools of other programs, and what is wrong with them.
fn other_tools(file: &JobFile) -> (Vec<(u32, Cutter)>, Vec<Diagnostic>) {
    let (mut tools, mut faults) = (Vec::new(), Vec::new());
    for (at, tool) in file.other_tools.iter().enumerate() {
        let fault = |error: CutterError| {
            file.places.fault(&format!("verify.tool.{at}"), JobError::from(error).to_string())
        };
        match Cutter::new(cutter_spec(tool)) {
            Ok(cutter) => tools.push((tool.number, cutter)),
            Err(errors) => faults.extend(errors.into_iter().map(fault)),
        }
    }
    (tools, faults)
}

/// Shank and holder as one profile; up to the holder the shank goes straight on.
fn above_the_cutting_end(tool: &job::Tool) -> Vec<[f64; 2]> {
    let radius = tool.shank.last().map_or(tool.major + tool.minor, |&[_, radius]| radius);
    let joint = tool.holder.first().map(|&[height, _]| [height, radius]);
    tool.shank.iter().copied().chain(joint).chain(tool.holder.iter().copied()).collect()
}

fn setup(file: &JobFile) -> Setup {
    let job::Setup { origin, angles, .. } = file.setup;
    Setup::new(origin, angles, file.tool.length)
}

fn numbers(wanted: &job::Faces, faces: &[Face]) -> Vec<usize> {
    match wanted {
        job::Faces::All => faces.iter().map(|face| face.number).collect(),
        job::Faces::Numbers(numbers) => numbers.clone(),
    }
}

/// Numbers of the faces there are, in words.
fn available(faces: &[Face]) -> String {
    match (faces.first(), faces.last()) {
        (Some(first), Some(last)) => format!("faces {} to {}", first.number, last.number),
        _ => "none".to_owned(),
    }
}

/// Faces that cannot be kept off, by number.
type Unguarded = Vec<(usize, SurfaceError)>;

/// Faces that are not cut but kept off, and those of them that nothing can be kept off.
fn others(part: &job::Part, faces: &[Face]) -> Result<(Vec<FaceIndex>, Unguarded), JobError> {
    let cut = numbers(&part.faces, faces);
    let (mut others, mut unguarded) = (Vec::new(), Vec::new());
    for number in numbers(&part.avoid, faces) {
        let Some(face) = faces.iter().find(|face| face.number == number) else {
            let (available, key) = (available(faces), "part.avoid");
            return Err(JobError::NoFace { number, available, key });
        };
        if !cut.contains(&number) {
            match FaceIndex::new(face.clone()) {
                Ok(index) => others.push(index),
                Err(error) => unguarded.push((number, error)),
            }
        }
    }
    Ok((others, unguarded))
}

/// Faces of the job in its order, turned over if it says so.
fn choose(part: &job::Part, faces: &[Face]) -> Result<Vec<FaceIndex>, Vec<JobError>> {
    let numbers = numbers(&part.faces, faces);
    if numbers.is_empty() {
        return Err(vec![JobError::EmptyPart]);
    }
    let mut errors = Vec::new();
    let mut chosen = Vec::new();
    for number in numbers {
        let Some(face) = faces.iter().find(|face| face.number == number) else {
            errors.push(JobError::NoFace {
                number,
                available: available(faces),
                key: "part.faces",
            });
            continue;
        };
        let mut face = face.clone();
        face.flip ^= part.flip;
        match FaceIndex::new(face) {
            Ok(index) => chosen.push(index),
            Err(error) => errors.push(JobError::Face { number, error }),
        }
    }
    if errors.is_empty() { Ok(chosen) } else { Err(errors) }
}

/// How much more than expected rounding may turn out to do along the path.
const ROUNDING_RESERVE: f64 = 1.2;

/// Splits the tolerance; `needed` is what rounding is expected to do \[mm\].
fn budget(file: &JobFile, needed: f64) -> Result<Budget, BudgetError> {
    let job::Tolerance { total, gouge, split } = file.tolerance;
    let usual = Shares::usual(total);
    let shares = Shares {
        path: split.path.unwrap_or(usual.path),
        linearisation: split.linearisation.unwrap_or(usual.linearisation),
        rounding: split.rounding.unwrap_or(usual.rounding.max(ROUNDING_RESERVE * needed)),
        control: split.control.unwrap_or(usual.control),
        singular: split.singular.unwrap_or(usual.singular),
        smoothing: split.smoothing.unwrap_or(usual.smoothing),
    };
    Budget::split(total, gouge, shares, split.strip)
}
