//! What is checked, against what.

use super::Args;
use super::setting::Setting;
use crate::outcome::Failure;
use crate::path::MOST_FAULTS;
use crate::progress::Bars;
use crate::{inspect, text};
use std::path::Path;
use trunnion::cutter::Cutter;
use trunnion::files::summary::ChordSummary;
use trunnion::machine::Kinematics;
use trunnion::nc::read::{
    AxisWords, ClSource, ClText, Dialect, ProgramSource, ProgramText, ReadOptions,
};
use trunnion::nc::write::work_offset;
use trunnion::pipeline::{self, Fixtures, MOST_COLLISIONS};
use trunnion::surface::Face;
use trunnion::types::Progress;
use trunnion::verify::{
    self, ClInput, ClearanceReport, Finding, Input, Options, Promise, Report, Stock, StockOptions,
    StockReport, Tables, Tool, Track, VerifyError, WorkOffset,
};

/// Distance between measured points where nothing is said \[mm\].
pub(super) const GRID: f64 = 0.2;
/// Grid on the faces that are not cut, over that on those that are.
const OTHERS_GRID: f64 = 3.0;
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
    /// How far the triangles of STEP solids may be off their faces.
    pub(super) chords: Vec<ChordSummary>,
    pub(super) warnings: Vec<String>,
}

/// What was found.
pub(super) struct Found {
    pub(super) report: Report,
    /// On faces that are not cut: points, and the deepest gouge \[mm\].
    pub(super) others: (usize, f64),
    /// What the tool did to the stock, and what is left of it.
    pub(super) stock: Option<(StockReport, Stock)>,
    /// How near it came to fixtures.
    pub(super) clearance: Option<ClearanceReport>,
}

impl Subject {
    /// Reads everything the arguments name.
    pub(super) fn load(args: &Args, bars: &Bars) -> Result<Self, Failure> {
        let setting = Setting::read(args, bars)?;
        let (stock, fixtures) = setting.solids()?;
        let offsets = offsets(args, setting.kinematics.as_ref());
        let motion = motion(args, setting.kinematics)?;
        let mut warnings = setting.warnings;
        let said = match &motion {
            Motion::Program(program, _) => program.warnings(),
            Motion::Locations(file) => file.warnings(),
        };
        let place = args.program.display();
        warnings.extend(said.iter().map(|warning| format!("{place}:{warning}")));
        if setting.tools.is_empty() {
            warnings.extend(setting.number.and_then(|own| misnamed(&motion, own)));
        }
        let machine = match &motion {
            Motion::Program(_, kinematics) => Some(kinematics.machine().name.clone()),
            Motion::Locations(_) => None,
        };
        let grid = args.grid.unwrap_or(setting.grid);
        let options = Options::of_tolerance(setting.tolerance, grid);
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
            chords: setting.chords,
            warnings,
        })
    }

    /// Runs the program and measures what it leaves.
    pub(super) fn check(&self, bars: &dyn Progress) -> Result<Found, Failure> {
        self.right_side()?;
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
        if let (Some((carving, _)), Some(clearance)) = (&mut stock, &clearance) {
            pipeline::add_hits(carving, clearance);
        }
        Ok(Found { report, others, stock, clearance })
    }

    /// Refuses faces that the tool cuts from behind: no height on them would mean anything.
    fn right_side(&self) -> Result<(), Failure> {
        let (faces, cutter) = (&self.faces[..], &self.cutter);
        let tools = self.table();
        let found = match &self.motion {
            Motion::Program(program, kinematics) => {
                verify::behind(&self.input((program, kinematics), faces, &tools))
            }
            Motion::Locations(file) => {
                let input = ClInput { file: &**file, faces, cutter, rest: &[], tools: &tools };
                verify::behind_cl(&input, self.options.ray_tolerance)
            }
        };
        match found.map_err(|error| self.failure(&error))? {
            None => Ok(()),
            Some([back, all]) => Err(Failure::input(format!(
                "{}: the tool cuts the faces of {} from behind, at {back} of {all} places that were looked at\n  \
                 help: turn the faces over with --flip, or leave it out; in a job, part.flip",
                self.program, self.part
            ))),
        }
    }

    /// The tools that the program tells apart.
    fn table(&self) -> Vec<Tool<'_>> {
        self.tools.iter().map(|(number, cutter)| Tool { number: *number, cutter }).collect()
    }

    /// Runs the program through stock.
    fn carve(&self, bars: &dyn Progress) -> Result<Option<(StockReport, Stock)>, Failure> {
        let Some(mut stock) = self.stock.clone() else { return Ok(None) };
        let (faces, cutter) = (&self.faces[..], &self.cutter);
        let tolerance = stock.tolerance(self.options.total);
        let cutting = StockOptions { tolerance, worst: MOST_COLLISIONS };
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
    fn clearance(&self, bars: &dyn Progress) -> Result<Option<ClearanceReport>, Failure> {
        let Some(fixtures) = &self.fixtures else { return Ok(None) };
        let (all, watch) = (fixtures.all(), fixtures.watch());
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
            error => {
                let program: Option<&dyn ProgramSource> = match &self.motion {
                    Motion::Program(program, _) => Some(&**program),
                    Motion::Locations(_) => None,
                };
                Failure::faults(Path::new(&self.program), &[error.fault(program)])
            }
        }
    }
}

/// Work offsets beside that of the setup.
fn offsets(args: &Args, kinematics: Option<&Kinematics>) -> Vec<WorkOffset> {
    let g54 = kinematics.and_then(work_offset).unwrap_or_default();
    args.offset.iter().map(|said| said.offset(g54)).collect()
}

/// What is told of a program that calls its only tool otherwise than the job.
fn misnamed(motion: &Motion, own: u32) -> Option<String> {
    let called = match motion {
        Motion::Program(program, _) => program.tools().first().copied(),
        Motion::Locations(file) => file.tools().first().map(|tool| tool.number),
    };
    let called = called.filter(|number| *number != own)?;
    Some(format!(
        "the program calls tool {called}; it is taken to be the job's, which is tool {own}"
    ))
}

/// Reads the program.
fn motion(args: &Args, kinematics: Option<Kinematics>) -> Result<Motion, Failure> {
    let path = &args.program;
    let text = text::program(path)?;
    let faults = |faults: trunnion::types::Diagnostics| Failure::faults(path, &faults);
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
    let options = ReadOptions {
        block_delete: args.block_delete,
        parameters: args.parameters.clone(),
        ..ReadOptions::new(dialect, axes, MOST_FAULTS)
    };
    let program = ProgramText::new(text, options).map_err(faults)?;
    Ok(Motion::Program(Box::new(program), Box::new(kinematics)))
}
