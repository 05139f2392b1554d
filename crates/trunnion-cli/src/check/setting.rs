//! Part, machine, tools and solids that a program is checked against: from a job or the arguments.

use super::args::CheckArgs;
use super::named::Named;
use super::stock;
use super::tool::{ToolShape, Toolbox};
use crate::outcome::Failure;
use crate::run::{self, both};
use crate::{machine, part};
use nalgebra::Vector3;
use std::path::Path;
use trunnion::cutter::Cutter;
use trunnion::files::job::STEP_CHORD;
use trunnion::files::summary::ChordSummary;
use trunnion::machine::{Kinematics, Setup};
use trunnion::math;
use trunnion::pipeline::{Fixtures, Held, Job, WatchedMachine};
use trunnion::surface::{Face, FaceIndex};
use trunnion::types::Progress;
use trunnion::verify::{CoolantDemand, LEAST_GOUGE, Solid, Stock};

/// Distance between measured points by default \[mm\].
const GRID: f64 = 0.2;

/// Accuracy of depths in stock and of distances from fixtures without a part \[mm\]: excess and gouge.
const TOLERANCE_WITHOUT_PART: [f64; 2] = [0.01, 0.001];

/// Everything that a check needs besides the program.
pub(super) struct Setting {
    /// `None`: nothing is measured, only axes, stock and fixtures count.
    pub(super) part: Option<String>,
    pub(super) kinematics: Option<Kinematics>,
    pub(super) faces: Vec<Face>,
    pub(super) others: Vec<Face>,
    pub(super) cutter: Cutter,
    pub(super) tools: Vec<(u32, Cutter)>,
    /// Number of the job's tool.
    pub(super) number: Option<u32>,
    pub(super) tolerance: [f64; 2],
    pub(super) grid: f64,
    stock: Option<Named<Solid>>,
    stock_cell: Option<Named<f64>>,
    fixtures: Vec<Named<Held>>,
    pub(super) coolant: CoolantDemand,
    /// Feed of the job \[mm/s\].
    pub(super) feed: Option<f64>,
    /// Keep-off distance of every part of the tool from fixtures \[mm\].
    clearance: f64,
    /// Chord tolerances of the triangles that stand for STEP solids.
    pub(super) chords: Vec<ChordSummary>,
    pub(super) warnings: Vec<String>,
}

/// Returns an operation of a job, counted from 1, as a job of its own.
fn operation(path: &Path, job: Job, number: u32) -> Result<Job, Failure> {
    let count = job.operations().count();
    let index = (number as usize).checked_sub(1);
    index.and_then(|index| job.into_operation(index)).ok_or_else(|| {
        let help = format!("--operation is a number from 1 to {count}");
        let path = path.display();
        Failure::input(format!("{path}: the job has no operation {number}\n  help: {help}"))
    })
}

impl Setting {
    pub(super) fn read(args: &CheckArgs, bars: &dyn Progress) -> Result<Self, Failure> {
        let mut setting = match &args.job {
            Some(job) => Self::of_job(job, args, bars)?,
            None => Self::of_arguments(args, bars)?,
        };
        // Options take precedence over the job, so that it can be checked again without an edit.
        setting.tolerance = args.tolerance.unwrap_or(setting.tolerance);
        setting.clearance = args.clearance.unwrap_or(setting.clearance);
        let cell = args.stock_cell.map(|cell| Named::new(format!("--stock-cell {cell}"), cell));
        setting.stock_cell = cell.or(setting.stock_cell);
        if setting.tolerance[1] < LEAST_GOUGE {
            setting.warnings.push(least_gouge(setting.tolerance[1]));
        }
        setting.add_solids(args)?;
        // An option without an effect is a mistake, not a preference.
        let bodies = setting.kinematics.iter().any(|chain| !chain.machine().bodies.is_empty());
        if args.clearance.is_some() && setting.fixtures.is_empty() && !bodies {
            let help =
                "describe with --fixture what the tool must not touch, or give the machine bodies";
            return Err(Failure::input(format!("--clearance needs a fixture\n  help: {help}")));
        }
        if args.stock_cell.is_some() && setting.stock.is_none() {
            let help = "describe with --stock the material that is cut";
            return Err(Failure::input(format!("--stock-cell needs --stock\n  help: {help}")));
        }
        Ok(setting)
    }

    /// Adds the solids of the command line: stock replaces that of the job, fixtures join its own.
    fn add_solids(&mut self, args: &CheckArgs) -> Result<(), Failure> {
        let chord = args.chord.unwrap_or(STEP_CHORD);
        if let Some(name) = &args.stock {
            self.stock = Some(Named::new(name, stock::read(name, chord)?));
        }
        for name in &args.fixture {
            let solid = Some(stock::read(name, chord)?);
            // Triangles may lie inside the true faces by the chord: the fixture grows by it.
            let allowance = if stock::is_step(name) { chord } else { 0.0 };
            let held = Held { name: name.clone(), solid, allowance };
            self.fixtures.push(Named::new(name, held));
        }
        let stock = args.stock.iter().map(|argument| (argument, "stock"));
        let all = stock.chain(args.fixture.iter().map(|argument| (argument, argument.as_str())));
        let step = all.filter(|(argument, _)| stock::is_step(argument));
        self.chords.extend(step.map(|(_, name)| ChordSummary { solid: name.to_owned(), chord }));
        Ok(())
    }

    /// Returns the stock as rays, and the fixtures; every unusable solid is reported.
    pub(super) fn solids(&self) -> Result<(Option<Stock>, Option<Fixtures>), Failure> {
        let rays = |solid| stock::rays(solid, self.stock_cell.as_ref());
        let stock = self.stock.as_ref().map(rays).transpose();
        let mut fixtures = Fixtures::new(self.tolerance[0], self.clearance);
        let mut faults = Vec::new();
        for Named { name, value } in &self.fixtures {
            faults.extend(fixtures.add(value).err().map(|error| format!("{name}: {error}")));
        }
        let fixtures = Some(fixtures).filter(|_| !self.fixtures.is_empty());
        // Faults of stock and fixtures are reported together.
        both(stock, if faults.is_empty() { Ok(fixtures) } else { Err(Failure::Input(faults)) })
    }

    /// Returns the bodies of the machine, with stock and fixtures.
    pub(super) fn bodies(&self) -> Result<Option<WatchedMachine>, Failure> {
        let Some(kinematics) = &self.kinematics else { return Ok(None) };
        let machine = WatchedMachine::new(kinematics.machine(), self.clearance);
        let mut machine = machine.map_err(Failure::input)?;
        if let Some(machine) = &mut machine {
            for Named { value, .. } in &self.fixtures {
                let solid = value.solid.iter();
                solid.for_each(|solid| machine.hold(&value.name, solid, value.allowance));
            }
            self.stock.iter().for_each(|stock| machine.hold_stock(&stock.value));
        }
        Ok(machine)
    }

    fn of_job(path: &Path, args: &CheckArgs, bars: &dyn Progress) -> Result<Self, Failure> {
        let (mut job, warnings) = run::load(path, args.chord, bars)?;
        if let Some(number) = args.operation {
            job = operation(path, job, number)?;
        }
        // The stock of the command line replaces that of the job.
        if args.stock.is_some() {
            job.file.stock = None;
        }
        let (stock, fixtures) = of_file(path, &job);
        let stock_cell = job
            .file
            .stock_cell
            .map(|cell| Named::new(place(path, &job, "verify.stock_cell", "the stock"), cell));
        let options = toolbox(args);
        if options.has_plain() {
            let help =
                "describe a further tool with its number: --cutter 2=R=5,r=1 --tool-length 2=95";
            return Err(Failure::input(format!(
                "--job describes the tool already; a further one needs a number\n  help: {help}"
            )));
        }
        // A tool of the command line replaces the one of the job with the same number.
        let mut tools = numbered(&options)?;
        let own = (job.file.tool.number, job.cutter.clone());
        let has = |tools: &[(u32, Cutter)], number: u32| tools.iter().any(|of| of.0 == number);
        job.other_tools.retain(|(number, _)| !has(&tools, *number));
        tools.append(&mut job.other_tools);
        // Without other tools the list stays empty: the only tool then answers to every number.
        if !tools.is_empty() && !has(&tools, own.0) {
            tools.insert(0, own);
        }
        let plain = |faces: Vec<&FaceIndex>| -> Vec<Face> {
            faces.into_iter().map(|face| face.face().clone()).collect()
        };
        // Cuts as slow as the slowest operation are as planned, and so are cuts without coolant if one has none.
        let cutting = || job.operations().map(|one| one.file.cutting);
        let feed = cutting().map(|of| of.feed).fold(f64::INFINITY, f64::min);
        let coolant = cutting().all(|of| of.coolant);
        let (faces, others) = (plain(job.cut_faces()), plain(job.avoided_faces()));
        Ok(Self {
            part: Some(job.file.part.file.clone()),
            faces,
            others,
            tolerance: [job.budget.total, job.budget.gouge],
            grid: job.file.verify_grid,
            stock,
            stock_cell,
            fixtures,
            clearance: job.file.fixture_clearance,
            chords: job.file.chords(),
            number: Some(job.file.tool.number),
            feed: Some(feed),
            coolant: if coolant { CoolantDemand::Needed } else { CoolantDemand::Unknown },
            cutter: job.cutter,
            tools,
            kinematics: Some(job.kinematics),
            warnings,
        })
    }

    /// Reads what the arguments name; without a job they must name everything.
    fn of_arguments(args: &CheckArgs, bars: &dyn Progress) -> Result<Self, Failure> {
        let missing = |name: &str| {
            let help = match args.part {
                Some(_) => "give --part, --cutter and --tolerance, or --job JOB.toml",
                None => {
                    "the check of the axes needs --tool-length, that of stock and fixtures also --cutter; or give --job JOB.toml"
                }
            };
            Failure::input(format!("{name} is missing\n  help: {help}"))
        };
        if args.part.is_none() {
            refuse_nothing(args)?;
            refuse_face_options(args)?;
        }
        let options = toolbox(args);
        let tools = numbered(&options)?;
        let needed = match options.shape {
            ToolShape::Needed => "--cutter",
            ToolShape::LengthOnly => "--tool-length",
        };
        let cutter = match tools.first() {
            Some((_, cutter)) => Ok(cutter.clone()),
            None => options.of(None).ok_or_else(|| missing(needed))?.cutter(),
        };
        let length = cutter.as_ref().map_or(0.0, Cutter::length);
        let setup =
            Setup::new(Vector3::from(args.origin), args.rotation.map(f64::to_radians), length);
        let machine = args.machine.as_deref().map(machine::load).transpose();
        let part = args.part.as_ref().map(|file| part::read(file, bars)).transpose();
        // All unusable files are reported at once.
        let (cutter, (machine, part)) = both(cutter, both(machine, part))?;
        let kinematics = machine.map(|file| Kinematics::new(&file.machine, &setup));
        let warnings = part.iter().flat_map(|part| &part.warnings);
        let warnings = warnings.map(|warning| format!("part: {warning}")).collect();
        let tolerance = match part {
            Some(_) => args.tolerance.ok_or_else(|| missing("--tolerance"))?,
            None => TOLERANCE_WITHOUT_PART,
        };
        let (faces, others) = match part {
            Some(part) => choose(part.faces, args)?,
            None => (Vec::new(), Vec::new()),
        };
        Ok(Self {
            part: args.part.as_ref().map(|file| file.display().to_string()),
            kinematics,
            faces,
            others,
            cutter,
            tools,
            number: None,
            feed: None,
            coolant: CoolantDemand::Unknown,
            tolerance,
            grid: GRID,
            stock: None,
            stock_cell: None,
            fixtures: Vec::new(),
            clearance: 0.0,
            chords: Vec::new(),
            warnings,
        })
    }
}

/// Refuses a check in which there is nothing to check against.
fn refuse_nothing(args: &CheckArgs) -> Result<(), Failure> {
    if args.machine.is_some() || args.stock.is_some() || !args.fixture.is_empty() {
        return Ok(());
    }
    let help = "--machine M and --tool-length L audit the axes of a program; --part, --stock and --fixture need --cutter";
    Err(Failure::input(format!(
        "{}: nothing to check against\n  help: {help}",
        args.program.display()
    )))
}

/// Refuses options about faces where there are none: they would have no effect.
fn refuse_face_options(args: &CheckArgs) -> Result<(), Failure> {
    let given = [
        ("--faces", !args.faces.is_empty()),
        ("--flip", args.flip),
        ("--part-rotation", args.part_rotation.is_some()),
        ("--grid", args.grid.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((name, _)) => {
            let help = format!("name the part with --part, or leave {name} out");
            Err(Failure::input(format!("{name} needs a part\n  help: {help}")))
        }
        None => Ok(()),
    }
}

/// Returns the warning about a gouge tolerance below the least that can be kept.
fn least_gouge(gouge: f64) -> String {
    format!(
        "only gouges deeper than {LEAST_GOUGE} mm are reported, instead of {gouge} mm: the rounding of words alone causes gouges up to that depth"
    )
}

/// Returns the position of a key of a job, followed by `what` it describes.
fn place(path: &Path, job: &Job, key: &str, what: &str) -> String {
    let at = job.file.places.get(key);
    format!("{}:{}:{}: {what}", path.display(), at.line, at.column)
}

/// Returns stock and fixtures of a job with their positions in the job file.
fn of_file(path: &Path, job: &Job) -> (Option<Named<Solid>>, Vec<Named<Held>>) {
    let place = |key: &str, what: &str| place(path, job, key, what);
    let solid = job.stock.clone().filter(|_| job.file.stock.is_some());
    let fixture = |(number, held): (usize, &Held)| {
        let what = format!("fixture {}", held.name);
        Named::new(place(&format!("fixture.{number}.file"), &what), held.clone())
    };
    let fixtures = job.fixtures.iter().enumerate().map(fixture).collect();
    (solid.map(|solid| Named::new(place("stock.file", "the stock"), solid)), fixtures)
}

fn toolbox(args: &CheckArgs) -> Toolbox<'_> {
    let CheckArgs { cutter, shank, holder, tool_length: length, .. } = args;
    Toolbox { cutter, shank, holder, length, shape: shape(args) }
}

/// Returns the use of the tools' shapes.
pub(super) fn shape(args: &CheckArgs) -> ToolShape {
    let meets_nothing = args.part.is_none() && args.job.is_none();
    if meets_nothing && args.stock.is_none() && args.fixture.is_empty() {
        ToolShape::LengthOnly
    } else {
        ToolShape::Needed
    }
}

/// Returns the tools that the options describe by number.
fn numbered(options: &Toolbox<'_>) -> Result<Vec<(u32, Cutter)>, Failure> {
    let tool = |number: u32| {
        let found = options.of(Some(number)).ok_or_else(|| {
            let help = format!("describe it: --cutter {number}=R=10,r=6");
            Failure::input(format!("tool {number} has no cutter\n  help: {help}"))
        });
        Ok((number, found?.cutter()?))
    };
    options.numbers().into_iter().map(tool).collect()
}

/// Separates the faces that are cut, flipped if asked for, from the others, and turns the part.
fn choose(faces: Vec<Face>, args: &CheckArgs) -> Result<(Vec<Face>, Vec<Face>), Failure> {
    let known = |number: &usize| faces.iter().any(|face| face.number == *number);
    if let Some(number) = args.faces.iter().find(|number| !known(number)) {
        let count = faces.len();
        return Err(Failure::input(format!(
            "the part has no face {number}; it has {count}\n  help: trunnion inspect lists them"
        )));
    }
    let cut = |face: &Face| args.faces.is_empty() || args.faces.contains(&face.number);
    let (mut chosen, others): (Vec<Face>, Vec<Face>) = faces.into_iter().partition(cut);
    for face in &mut chosen {
        // The part may have flipped the face already.
        face.flip ^= args.flip;
    }
    let angles = args.part_rotation.unwrap_or_default().map(f64::to_radians);
    let rotation = math::exact_rotation_of_xyz(angles.into());
    let turned = |faces: Vec<Face>| faces.into_iter().map(|face| face.turned(&rotation)).collect();
    Ok((turned(chosen), turned(others)))
}
