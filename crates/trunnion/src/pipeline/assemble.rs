//! Assembly of a job from its file, the faces of its part, and its machine.

use super::budget::{Budget, BudgetError, BudgetShares};
use super::fixtures::Held;
use super::job::{FACES, Job, JobError};
use super::rounding::expected_rounding;
use super::stock_solid::stock_solid;
use crate::cutter::{Cutter, CutterConstruction, CutterError, CutterKind, CutterSide, CutterSpec};
use crate::files::job::{self, JobFile};
use crate::machine::{Kinematics, Machine, Setup};
use crate::surface::{Face, FaceIndex, SurfaceError};
use crate::types::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;

impl Job {
    /// Creates a job from its file, the faces of its part as it is drawn, and its machine.
    ///
    /// # Errors
    ///
    /// All faults found, each at its line of the job file.
    pub fn new(file: JobFile, faces: &[Face], machine: &Machine) -> Result<Self, Diagnostics> {
        let rotation = file.part.rotation();
        let turned: Vec<Face> = faces.iter().map(|face| face.clone().turned(&rotation)).collect();
        let mut part = PartIndex { faces: &turned, known: BTreeMap::new() };
        let (other_tools, mut faults) = other_tools(&file);
        faults.extend(file.unread_holders());
        let count = file.operations.len().max(1);
        let mut jobs = Vec::new();
        for index in 0..count {
            let of_operation = file.operations.get(index);
            let own = of_operation.map_or_else(|| file.clone(), |one| file.of_operation(one));
            let operation = OperationFile {
                name: of_operation.map_or_else(String::new, |one| one.name.clone()),
                index,
                path: if count > 1 { format!("operation.{index}.") } else { String::new() },
                file: own,
            };
            match one(operation, &mut part, machine) {
                Ok(job) => jobs.push(job),
                Err(found) => faults.extend(found),
            }
        }
        let mut jobs = jobs.into_iter();
        match jobs.next() {
            Some(first) if faults.is_empty() => {
                Ok(Self { file, other_tools, following: jobs.collect(), ..first })
            }
            _ => {
                // Operations share the part and the tolerance: each of their faults is reported once.
                faults.sort_by_key(|fault| (fault.line, fault.column));
                faults.dedup();
                Err(faults.into())
            }
        }
    }
}

/// One operation, as a job file of its own.
struct OperationFile {
    name: String,
    index: usize,
    /// Prefix of the keys of the operation.
    path: String,
    file: JobFile,
}

/// Faces of the part, each prepared for queries once.
struct PartIndex<'a> {
    faces: &'a [Face],
    /// By number and side.
    known: BTreeMap<(usize, bool), FaceIndex>,
}

impl PartIndex<'_> {
    fn get(&mut self, face: Face) -> Result<FaceIndex, SurfaceError> {
        let key = (face.number, face.flip);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let index = FaceIndex::new(face)?;
        self.known.insert(key, index.clone());
        Ok(index)
    }
}

/// Creates the job of one operation.
fn one(
    operation: OperationFile,
    part: &mut PartIndex<'_>,
    machine: &Machine,
) -> Result<Job, Vec<Diagnostic>> {
    let OperationFile { name, index, path, file } = operation;
    let mut faults = Vec::new();
    let cutter = Cutter::new(cutter_spec(&file.tool))
        .map_err(|errors| faults.extend(errors.into_iter().map(JobError::Cutter)))
        .ok();
    let (others, unguarded) = others(&file.part, part).unwrap_or_else(|error| {
        faults.push(error);
        Default::default()
    });
    let faces = choose(&file.part, part).map_err(|errors| faults.extend(errors)).ok();
    let kinematics = Kinematics::new(machine, &setup(&file));
    // Faulty faces or a faulty cutter only make the estimate smaller: the job is refused anyway.
    let needed = expected_rounding(
        &kinematics,
        faces.as_deref().unwrap_or_default(),
        &file.dialects,
        cutter.as_ref(),
    );
    let budget = budget(&file, needed).map_err(|error| faults.push(error.into())).ok();
    let (Some(cutter), Some(faces), Some(budget)) = (cutter, faces, budget) else {
        let own = |key: &str| match key {
            FACES => format!("{path}faces"),
            "tool" => format!("{path}tool"),
            _ => key.to_owned(),
        };
        let key = |key: &'static str| if path.is_empty() { key.to_owned() } else { own(key) };
        let place = |fault: JobError| file.places.fault(&key(fault.key()), fault.to_string());
        return Err(faults.into_iter().map(place).collect());
    };
    let all = faces.iter().chain(&others).map(FaceIndex::face);
    let stock = file.stock.as_ref().and_then(|stock| stock_solid(stock, all));
    let fixtures = file.fixtures.iter().map(Held::of).collect();
    Ok(Job {
        name,
        index,
        following: Vec::new(),
        file,
        faces,
        others,
        unguarded,
        stock,
        fixtures,
        cutter,
        other_tools: Vec::new(),
        kinematics,
        budget,
    })
}

/// Describes the tool of a job, or of a library.
pub(super) fn cutter_spec(tool: &job::JobTool) -> CutterSpec {
    CutterSpec {
        kind: match tool.kind {
            job::ToolKind::Flat => CutterKind::Flat,
            job::ToolKind::Ball => CutterKind::Ball,
            job::ToolKind::Bull => CutterKind::Bull,
            job::ToolKind::Taper => CutterKind::Taper,
            job::ToolKind::Barrel => CutterKind::Barrel,
            job::ToolKind::ConicalBarrel => CutterKind::ConicalBarrel,
            job::ToolKind::Lens => CutterKind::Lens,
        },
        major: tool.major,
        minor: tool.minor,
        side: match tool.side {
            job::ToolSide::Straight => CutterSide::Straight,
            job::ToolSide::Cone { taper_angle, diameter } => {
                CutterSide::Cone { taper_angle, diameter }
            }
            job::ToolSide::Arc { radius, taper_angle, diameter } => {
                CutterSide::Arc { radius, taper_angle, diameter }
            }
        },
        length: tool.length,
        construction: match tool.construction {
            job::ToolConstruction::Solid => CutterConstruction::Solid,
            job::ToolConstruction::Insert { inner_cutting_radius } => {
                CutterConstruction::Insert { inner_cutting_radius }
            }
        },
        shank: above_the_cutting_end(tool),
    }
}

/// Returns the tools of other programs, and the errors in them.
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

/// Returns shank and holder as one profile; the shank continues straight up to the holder.
fn above_the_cutting_end(tool: &job::JobTool) -> Vec<[f64; 2]> {
    let radius = tool.shank.last().map_or(tool.radius(), |&[_, radius]| radius);
    let joint = tool.holder.first().map(|&[height, _]| [height, radius]);
    tool.shank.iter().copied().chain(joint).chain(tool.holder.iter().copied()).collect()
}

fn setup(file: &JobFile) -> Setup {
    let job::JobSetup { origin, angles, .. } = file.setup;
    Setup::new(origin, angles, file.tool.length)
}

fn numbers(wanted: &job::FaceSelection, faces: &[Face]) -> Vec<usize> {
    match wanted {
        job::FaceSelection::All => faces.iter().map(|face| face.number).collect(),
        job::FaceSelection::Numbers(numbers) => numbers.clone(),
    }
}

/// Describes the numbers of the available faces.
fn available(faces: &[Face]) -> String {
    match (faces.first(), faces.last()) {
        (Some(first), Some(last)) => format!("faces {} to {}", first.number, last.number),
        _ => "none".to_owned(),
    }
}

/// Faces that the tool cannot be kept off, by number.
type UnguardedFaces = Vec<(usize, SurfaceError)>;

/// Returns the faces that the tool must avoid, and those of them that cannot be worked with.
fn others(
    part: &job::JobPart,
    index: &mut PartIndex<'_>,
) -> Result<(Vec<FaceIndex>, UnguardedFaces), JobError> {
    let faces = index.faces;
    let cut = numbers(&part.faces, faces);
    let (mut others, mut unguarded) = (Vec::new(), Vec::new());
    for number in numbers(&part.avoid, faces) {
        let Some(face) = faces.iter().find(|face| face.number == number) else {
            let (available, key) = (available(faces), "part.avoid");
            return Err(JobError::NoFace { number, available, key });
        };
        // `avoid = "all"` names the faces that are cut, too.
        if !cut.contains(&number) {
            match index.get(face.clone()) {
                Ok(index) => others.push(index),
                // A face that cannot be indexed is a warning: the job may still be worth running.
                Err(error) => unguarded.push((number, error)),
            }
        }
    }
    Ok((others, unguarded))
}

/// Returns the faces to cut, in the order of the job, with normals flipped if the job asks for it.
fn choose(part: &job::JobPart, index: &mut PartIndex<'_>) -> Result<Vec<FaceIndex>, Vec<JobError>> {
    let faces = index.faces;
    let numbers = numbers(&part.faces, faces);
    if numbers.is_empty() {
        return Err(vec![JobError::EmptyPart]);
    }
    let mut errors = Vec::new();
    let mut chosen = Vec::new();
    for number in numbers {
        let Some(face) = faces.iter().find(|face| face.number == number) else {
            errors.push(JobError::NoFace { number, available: available(faces), key: FACES });
            continue;
        };
        let mut face = face.clone();
        // The face may be flipped in the part already.
        face.flip ^= part.flip;
        match index.get(face) {
            Ok(face) => chosen.push(face),
            Err(error) => errors.push(JobError::Face { number, error }),
        }
    }
    if errors.is_empty() { Ok(chosen) } else { Err(errors) }
}

/// Reserve factor for rounding along the path over the estimate.
const ROUNDING_RESERVE: f64 = 1.2;

/// Splits the tolerance; `needed` is the estimated effect of rounding \[mm\].
fn budget(file: &JobFile, needed: f64) -> Result<Budget, BudgetError> {
    let job::JobTolerance { total, gouge, split } = file.tolerance;
    let usual = BudgetShares::usual(total);
    let shares = BudgetShares {
        path: split.path.unwrap_or(usual.path),
        linearisation: split.linearisation.unwrap_or(usual.linearisation),
        // Poses along the path may round worse than those of the estimate.
        rounding: split.rounding.unwrap_or(usual.rounding.max(ROUNDING_RESERVE * needed)),
        control: split.control.unwrap_or(usual.control),
        singular: split.singular.unwrap_or(usual.singular),
        smoothing: split.smoothing.unwrap_or(usual.smoothing),
    };
    Budget::split(total, gouge, shares, split.strip)
}
