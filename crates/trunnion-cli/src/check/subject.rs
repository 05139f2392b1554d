//! What is checked, against what.

use super::fixtures::Fixtures;
use super::tool::Toolbox;
use super::{Args, stock};
use crate::outcome::Failure;
use crate::path::MOST_FAULTS;
use crate::progress::Bars;
use crate::{inspect, machine, material, part, run, text};
use nalgebra::Vector3;
use std::path::Path;
use trunnion::cutter::Cutter;
use trunnion::files::job;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{AxisWords, ClText, Dialect, ProgramText, ReadOptions};
use trunnion::nc::write::work_offset;
use trunnion::pipeline::MOST_COLLISIONS;
use trunnion::surface::Face;
use trunnion::types::Progress;
use trunnion::verify::{
    self, Approach, Carving, ClInput, Clearance, CollisionKind, Cutting, Finding, Input, Options,
    Promise, Report, Solid, Stock, Tables, Tool, Track, VerifyError, WorkOffset,
};

/// Distance between measured points where nothing is said \[mm\].
const GRID: f64 = 0.2;
/// Grid on the faces that are not cut, over that on those that are.
const OTHERS_GRID: f64 = 3.0;
/// Material higher than this counts as uncut \[mm\].
const REACH: f64 = 1.0;
/// Share of the total tolerance by which a ray may miss the swept cutter.
const RAY_SHARE: f64 = 0.005;
/// Share of the total tolerance by which what is certain between the measured points may lie beyond the
/// worst of them.
const MARGIN_SHARE: f64 = 0.05;
/// Most measured points on one face.
const MOST_POINTS: usize = 20_000_000;
/// Longest stretch between two drawn tool positions \[mm\].
const DRAWN_STEP: f64 = 1.0;

/// What moves the tool.
pub(super) enum Motion {
    Program(Box<ProgramText>, Box<Kinematics>),
    Locations(Box<ClText>),
}

/// A program with all that it is checked against.
pub(super) struct Subject {
    pub(super) motion: Motion,
    /// Names of program, part and machine.
    pub(super) program: String,
    pub(super) part: String,
    pub(super) machine: Option<String>,
    pub(super) faces: Vec<Face>,
    pub(super) others: Vec<Face>,
    /// The only tool, or the first.
    pub(super) cutter: Cutter,
    /// Tools by their numbers, where there are several.
    pub(super) tools: Vec<(u32, Cutter)>,
    offsets: Vec<WorkOffset>,
    pub(super) options: Options,
    /// Material and fixtures, where they were named.
    stock: Option<Stock>,
    pub(super) fixtures: Option<Fixtures>,
    /// How far the triangles of STEP solids may be off their faces \[mm\]; `None` if there are none.
    pub(super) chord: Option<f64>,
    pub(super) warnings: Vec<String>,
}

/// What was found.
pub(super) struct Found {
    pub(super) report: Report,
    /// On faces that are not cut: points, and the deepest gouge \[mm\].
    pub(super) others: (usize, f64),
    /// What the tool did to the stock, and what is left of it.
    pub(super) stock: Option<(Carving, Stock)>,
    /// How near it came to fixtures.
    pub(super) clearance: Option<Clearance>,
}

/// All but the program.
struct Setting {
    part: String,
    kinematics: Option<Kinematics>,
    faces: Vec<Face>,
    others: Vec<Face>,
    cutter: Cutter,
    tools: Vec<(u32, Cutter)>,
    tolerance: [f64; 2],
    grid: f64,
    /// Of a job.
    stock: Option<Solid>,
    stock_cell: Option<f64>,
    /// It is of a STEP file.
    step_stock: bool,
    warnings: Vec<String>,
}

impl Subject {
    /// Reads everything the arguments name.
    pub(super) fn load(args: &Args, bars: &Bars) -> Result<Self, Failure> {
        let setting = match &args.job {
            Some(job) => Setting::of_job((job, args), bars)?,
            None => Setting::of_arguments(args, bars)?,
        };
        let offsets = offsets(args, setting.kinematics.as_ref());
        let motion = motion(args, setting.kinematics)?;
        let stock = stock_of(args, setting.stock, setting.stock_cell)?;
        let mut warnings = setting.warnings;
        let said = match &motion {
            Motion::Program(program, _) => program.warnings(),
            Motion::Locations(file) => file.warnings(),
        };
        let place = args.program.display();
        warnings.extend(said.iter().map(|warning| format!("{place}:{warning}")));
        let machine = match &motion {
            Motion::Program(_, kinematics) => Some(kinematics.machine().name.clone()),
            Motion::Locations(_) => None,
        };
        let of_job = args.stock.is_none() && setting.step_stock;
        let has_step =
            of_job || args.stock.iter().chain(&args.fixture).any(|said| stock::is_step(said));
        let [total, gouge] = args.tolerance.unwrap_or(setting.tolerance);
        let chord = args.chord.unwrap_or(material::CHORD);
        let clearance = args.clearance.unwrap_or(0.0);
        let fixtures = || Fixtures::read(&args.fixture, clearance, [total, chord]);
        let fixtures = (!args.fixture.is_empty()).then(fixtures).transpose()?;
        let options = Options {
            grid: args.grid.unwrap_or(setting.grid),
            reach: REACH.max(2.0 * total),
            ray_tolerance: RAY_SHARE * total,
            total,
            gouge,
            most_points: MOST_POINTS,
            promise: Some(Promise { margin: [MARGIN_SHARE * total; 2], excess: true }),
        };
        Ok(Self {
            motion,
            program: args.program.display().to_string(),
            part: setting.part,
            machine,
            faces: setting.faces,
            others: setting.others,
            cutter: setting.cutter,
            tools: setting.tools,
            offsets,
            options,
            stock,
            fixtures,
            chord: has_step.then_some(chord),
            warnings,
        })
    }

    /// Runs the program and measures what it leaves.
    pub(super) fn check(&self, bars: &dyn Progress) -> Result<Found, Failure> {
        let mut report = self.measure(&self.faces, &self.options, bars)?;
        let mut others = (0, 0.0);
        if !self.others.is_empty() {
            let grid = OTHERS_GRID * self.options.grid;
            let promise = self.options.promise.map(|all| Promise { excess: false, ..all });
            let options = Options { grid, promise, ..self.options };
            let other = self.measure(&self.others, &options, bars)?;
            let gouges = other.findings.into_iter().filter(|f| matches!(f, Finding::Gouge(_)));
            report.findings.extend(gouges);
            let depth = other.deviation.lowest.map_or(0.0, |lowest| (-lowest.height).max(0.0));
            others = (other.deviation.points, depth);
        }
        let mut stock = self.carve(bars)?;
        let clearance = self.clearance(bars)?;
        if let Some((carving, _)) = &mut stock {
            let near = clearance.iter().flat_map(|found| &found.near);
            carving.collisions.extend(near.filter_map(Approach::collision));
            let hits = clearance.iter().filter_map(|found| found.hits);
            carving.lines.extend(hits.map(|hits| (CollisionKind::Fixture, hits)));
            carving.collisions.sort_by_key(|hit| (hit.line, hit.kind));
        }
        Ok(Found { report, others, stock, clearance })
    }

    /// The tools that the program tells apart.
    fn table(&self) -> Vec<Tool<'_>> {
        self.tools.iter().map(|(number, cutter)| Tool { number: *number, cutter }).collect()
    }

    /// Runs the program through stock.
    fn carve(&self, bars: &dyn Progress) -> Result<Option<(Carving, Stock)>, Failure> {
        let Some(mut stock) = self.stock.clone() else { return Ok(None) };
        let (faces, cutter) = (&self.faces[..], &self.cutter);
        let tolerance = stock.tolerance(self.options.total);
        let cutting = Cutting { tolerance, worst: MOST_COLLISIONS };
        let carving = match &self.motion {
            Motion::Program(program, kinematics) => {
                let tools = self.table();
                let input = self.input((program, kinematics), faces, &tools);
                verify::simulate(&input, &mut stock, &cutting, bars)
            }
            Motion::Locations(file) => {
                let input =
                    ClInput { file: &**file, faces, cutter, rest: &[], tools: &self.table() };
                verify::simulate_cl(&input, &mut stock, &cutting, bars)
            }
        };
        Ok(Some((carving.map_err(|error| self.failure(&error))?, stock)))
    }

    /// How near the program comes to fixtures.
    fn clearance(&self, bars: &dyn Progress) -> Result<Option<Clearance>, Failure> {
        let Some(Fixtures { all, watch, .. }) = &self.fixtures else { return Ok(None) };
        let (faces, cutter) = (&self.faces[..], &self.cutter);
        let found = match &self.motion {
            Motion::Program(program, kinematics) => {
                let tools = self.table();
                let input = self.input((program, kinematics), faces, &tools);
                verify::clearance(&input, all, watch, bars)
            }
            Motion::Locations(file) => {
                let input =
                    ClInput { file: &**file, faces, cutter, rest: &[], tools: &self.table() };
                verify::clearance_cl(&input, all, watch, bars)
            }
        };
        found.map(Some).map_err(|error| self.failure(&error))
    }

    fn measure(
        &self,
        faces: &[Face],
        options: &Options,
        bars: &dyn Progress,
    ) -> Result<Report, Failure> {
        let cutter = &self.cutter;
        let found = match &self.motion {
            Motion::Program(program, kinematics) => {
                let tools = self.table();
                let input = self.input((program, kinematics), faces, &tools);
                verify::check(&input, options, bars)
            }
            Motion::Locations(file) => verify::check_cl(
                &ClInput { file: &**file, faces, cutter, rest: &[], tools: &self.table() },
                options,
                bars,
            ),
        };
        found.map_err(|error| self.failure(&error))
    }

    fn input<'a>(
        &'a self,
        (program, kinematics): (&'a ProgramText, &'a Kinematics),
        faces: &'a [Face],
        tools: &'a [Tool<'a>],
    ) -> Input<'a> {
        let (believed, real, cutter) = (kinematics, kinematics, &self.cutter);
        let tables = Tables { tools, offsets: &self.offsets };
        Input { program, believed, real, faces, cutter, rest: &[], tables }
    }

    /// Where the tool goes.
    pub(super) fn track(&self) -> Result<Vec<Track>, Failure> {
        let (faces, cutter) = (&self.faces[..], &self.cutter);
        let tracks = match &self.motion {
            Motion::Program(program, kinematics) => {
                let tools = self.table();
                verify::track(&self.input((program, kinematics), faces, &tools), DRAWN_STEP)
            }
            Motion::Locations(file) => {
                let input =
                    ClInput { file: &**file, faces, cutter, rest: &[], tools: &self.table() };
                verify::track_cl(&input, self.options.ray_tolerance, DRAWN_STEP)
            }
        };
        tracks.map_err(|error| self.failure(&error))
    }

    fn failure(&self, error: &VerifyError) -> Failure {
        match error {
            VerifyError::Cancelled(_) => Failure::Stopped,
            error => Failure::input(format!("{}: {error}", self.program)),
        }
    }
}

impl Setting {
    fn of_job((path, args): (&Path, &Args), bars: &Bars) -> Result<Self, Failure> {
        let (job, warnings) = run::load(path, bars)?;
        let said = toolbox(args);
        if said.has_plain() {
            let help = "the job has its tool; say others by their numbers: --cutter 2=R=5,r=1 --tool-length 2=95";
            return Err(Failure::input(format!(
                "a tool without number beside --job\n  help: {help}"
            )));
        }
        let mut tools = numbered(&said)?;
        let own = job.file.tool.number;
        if !tools.is_empty() && tools.iter().all(|(number, _)| *number != own) {
            tools.insert(0, (own, job.cutter.clone()));
        }
        let plain = |faces: &[trunnion::surface::FaceIndex]| -> Vec<Face> {
            faces.iter().map(|face| face.face().clone()).collect()
        };
        Ok(Self {
            part: job.file.part.file.clone(),
            faces: plain(&job.faces),
            others: plain(&job.others),
            tolerance: [job.budget.total, job.budget.gouge],
            grid: job.file.verify_grid,
            step_stock: matches!(job.file.stock, Some(job::Stock::Step { .. })),
            stock: job.stock,
            stock_cell: job.file.stock_cell,
            cutter: job.cutter,
            tools,
            kinematics: Some(job.kinematics),
            warnings,
        })
    }

    /// The arguments are there: clap sees to that where there is no job.
    fn of_arguments(args: &Args, bars: &Bars) -> Result<Self, Failure> {
        let missing = |name: &str| {
            let help = "say --part, --cutter and --tolerance, or --job JOB.toml";
            Failure::input(format!("{name} is missing\n  help: {help}"))
        };
        let file = args.part.as_ref().ok_or_else(|| missing("--part"))?;
        let said = toolbox(args);
        let tools = numbered(&said)?;
        let cutter = match tools.first() {
            Some((_, cutter)) => Ok(cutter.clone()),
            None => said.of(None).ok_or_else(|| missing("--cutter"))?.cutter(),
        };
        let length = cutter.as_ref().map_or(0.0, Cutter::length);
        let setup =
            Setup::new(Vector3::from(args.origin), args.rotation.map(f64::to_radians), length);
        let machine = args.machine.as_deref().map(machine::load).transpose();
        let part = part::read(file, bars);
        // Whatever is wrong is told at once.
        let (cutter, (machine, part)) = both(cutter, both(machine, part))?;
        let kinematics = machine.map(|file| Kinematics::new(&file.machine, &setup));
        let (faces, others) = choose(part.faces, args)?;
        Ok(Self {
            part: file.display().to_string(),
            kinematics,
            faces,
            others,
            cutter,
            tools,
            tolerance: args.tolerance.ok_or_else(|| missing("--tolerance"))?,
            grid: GRID,
            stock: None,
            stock_cell: None,
            step_stock: false,
            warnings: part.warnings.iter().map(|warning| format!("part: {warning}")).collect(),
        })
    }
}

fn toolbox(args: &Args) -> Toolbox<'_> {
    let Args { cutter, shank, holder, tool_length: length, .. } = args;
    Toolbox { cutter, shank, holder, length }
}

/// Tools that are told by number.
fn numbered(said: &Toolbox<'_>) -> Result<Vec<(u32, Cutter)>, Failure> {
    let tool = |number: u32| {
        let found = said.of(Some(number)).ok_or_else(|| {
            let help = format!("say what it is: --cutter {number}=R=10,r=6");
            Failure::input(format!("tool {number} has no cutter\n  help: {help}"))
        });
        Ok((number, found?.cutter()?))
    };
    said.numbers().into_iter().map(tool).collect()
}

/// Work offsets beside that of the setup.
fn offsets(args: &Args, kinematics: Option<&Kinematics>) -> Vec<WorkOffset> {
    let g54 = kinematics.and_then(work_offset).unwrap_or_default();
    args.offset.iter().map(|said| said.offset(g54)).collect()
}

/// Stock, as it is said or as the job has it.
fn stock_of(
    args: &Args,
    of_job: Option<Solid>,
    cell: Option<f64>,
) -> Result<Option<Stock>, Failure> {
    let cell = args.stock_cell.or(cell);
    let stock = match (&args.stock, of_job) {
        (Some(said), _) => {
            let chord = args.chord.unwrap_or(material::CHORD);
            Some((said.as_str(), stock::read(said, chord)?))
        }
        (None, Some(solid)) => Some(("the job's stock", solid)),
        (None, None) if args.stock_cell.is_some() => {
            let help = "say what is cut with --stock";
            return Err(Failure::input(format!("--stock-cell needs --stock\n  help: {help}")));
        }
        (None, None) => None,
    };
    let rays = |(said, solid): (&str, Solid)| stock::rays(said, &solid, cell);
    stock.map(rays).transpose()
}

/// Both, or all that is wrong with either.
fn both<A, B>(a: Result<A, Failure>, b: Result<B, Failure>) -> Result<(A, B), Failure> {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(a), Err(b)) => Err(a.and(b)),
        (Err(fault), _) | (_, Err(fault)) => Err(fault),
    }
}

/// Faces that are cut, turned over if asked for, and the others.
fn choose(faces: Vec<Face>, args: &Args) -> Result<(Vec<Face>, Vec<Face>), Failure> {
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
        face.flip ^= args.flip;
    }
    Ok((chosen, others))
}

/// Reads the program.
fn motion(args: &Args, kinematics: Option<Kinematics>) -> Result<Motion, Failure> {
    let path = &args.program;
    let text = text::read(path)?;
    let faults = |faults: Vec<trunnion::types::Fault>| Failure::faults(path, &faults);
    let told = || if inspect::is_cl(path) { Dialect::Apt } else { Dialect::guess(text.lines()) };
    let dialect = args.dialect.unwrap_or_else(told);
    if dialect == Dialect::Apt {
        let file = ClText::new(text, MOST_FAULTS).map_err(faults)?;
        return Ok(Motion::Locations(Box::new(file)));
    }
    let Some(kinematics) = kinematics else {
        let help = "add --machine M; for cutter locations --dialect apt";
        let message = format!("{}: a {} program needs a machine", path.display(), dialect.name());
        return Err(Failure::input(format!("{message}\n  help: {help}")));
    };
    let axes = AxisWords::of(kinematics.machine(), false).map_err(Failure::input)?;
    let options = ReadOptions::new(dialect, axes, MOST_FAULTS);
    let program = ProgramText::new(text, options).map_err(faults)?;
    Ok(Motion::Program(Box::new(program), Box::new(kinematics)))
}
