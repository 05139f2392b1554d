//! The program that is checked, with everything it is checked against.

use super::args::CheckArgs;
use super::assumed_tool::{AssumedTool, described};
use super::remedy;
use super::setting::{self, Setting};
use super::tool::ToolShape;
use super::what_if::Assumption;
use crate::outcome::Failure;
use crate::table_tool::DescribedTool;
use crate::{inspect, machine, text};
use std::path::Path;
use trunnion::cutter::Cutter;
use trunnion::files::summary::ChordSummary;
use trunnion::machine::{Kinematics, Machine};
use trunnion::nc::read::{
    AxisWords, ClSource, ClText, Dialect, ProgramSource, ProgramText, ReadOptions, ToolRow,
};
use trunnion::nc::write::work_offset;
use trunnion::pipeline::{Fixtures, MOST_COLLISIONS, WatchedMachine};
use trunnion::post::MOST_FAULTS;
use trunnion::surface::Face;
use trunnion::types::Progress;
use trunnion::verify::{
    self, CheckInput, CheckOptions, CoolantDemand, DeviationTolerance, FindingKind, Inspection,
    InspectionReport, PlannedCuts, ReplayedBlock, Stock, TimedStock, TimedStockOptions,
    TimelineOptions, TimelinePoint, Tool, Track, VerifyError, WorkOffset,
};

/// Largest distance between two drawn tool positions \[mm\].
const DRAWN_STEP: f64 = 1.0;

/// Source of the tool's motion.
pub(super) enum CheckedMotion {
    Program(Box<ProgramText>, Box<Kinematics>),
    Locations(Box<ClText>),
}

/// Program with everything it is checked against.
pub(super) struct Subject {
    pub(super) motion: CheckedMotion,
    /// Names of program, part and machine.
    pub(super) program: String,
    pub(super) part: Option<String>,
    pub(super) machine: Option<String>,
    pub(super) faces: Vec<Face>,
    pub(super) others: Vec<Face>,
    /// Only tool, or the first of several.
    pub(super) cutter: Cutter,
    /// Tools by number; empty for a single tool.
    pub(super) tools: Vec<(u32, Cutter)>,
    offsets: Vec<WorkOffset>,
    pub(super) options: CheckOptions,
    /// Raw material, if it was named.
    stock: Option<Stock>,
    pub(super) fixtures: Option<Fixtures>,
    pub(super) bodies: Option<WatchedMachine>,
    /// Chord tolerances of the triangles that stand for STEP solids.
    pub(super) chords: Vec<ChordSummary>,
    pub(super) warnings: Vec<String>,
    /// Contradictions between the program's tool and the one that is checked in its place.
    pub(super) contradictions: Vec<String>,
    /// Kinds of findings that do not fail the check.
    pub(super) accepted: Vec<FindingKind>,
    pub(super) coolant: CoolantDemand,
    /// Numbers of the job's tools, and its feed \[mm/s\].
    planned: Option<(Vec<u32>, f64)>,
    /// Errors of machine, tool and setup to study.
    pub(super) assumptions: Vec<Assumption>,
}

impl Subject {
    /// Reads everything the arguments name.
    pub(super) fn load(args: &CheckArgs, bars: &dyn Progress) -> Result<Self, Failure> {
        let setting = Setting::read(args, bars)?;
        let (stock, fixtures) = setting.solids()?;
        let bodies = setting.bodies()?;
        let offsets = offsets(args, setting.kinematics.as_ref());
        let shapes = setting::shape(args);
        let ReadProgram { motion, tools: rows } = motion(args, setting.kinematics)?;
        let meets_nothing = setting.part.is_none() && stock.is_none() && fixtures.is_none();
        if meets_nothing && matches!(motion, CheckedMotion::Locations(_)) {
            let help = "give what the tool meets: --part, --stock or --fixture, with --cutter";
            return Err(Failure::input(format!(
                "{}: cutter locations have no axes, so nothing is left to check\n  help: {help}",
                args.program.display()
            )));
        }
        let mut warnings = setting.warnings;
        let reading = match &motion {
            CheckedMotion::Program(program, _) => program.warnings(),
            CheckedMotion::Locations(file) => file.warnings(),
        };
        let file = args.program.display();
        warnings.extend(reading.iter().map(|warning| format!("{file}:{warning}")));
        // With several tools the number selects the tool; with one it can only be a misunderstanding.
        let mut contradictions = Vec::new();
        if setting.tools.is_empty()
            && let Some(number) = setting.number.and_then(|own| misnamed(&motion, own))
        {
            let taken = AssumedTool {
                number,
                own: setting.number.unwrap_or_default(),
                cutter: &setting.cutter,
            };
            warnings.push(taken.warning());
            contradictions.extend(taken.contradiction(&rows));
        }
        let described = DescribedTools {
            numbered: &setting.tools,
            own: setting.number,
            only: &setting.cutter,
            shapes,
        };
        contradictions.extend(described.others(&motion, &rows));
        let numbers = setting.tools.iter().map(|(number, _)| *number);
        let numbers: Vec<u32> = if setting.tools.is_empty() {
            setting.number.into_iter().collect()
        } else {
            numbers.collect()
        };
        let planned = setting.feed.map(|feed| (numbers, feed));
        let machine = match &motion {
            CheckedMotion::Program(_, kinematics) => Some(kinematics.machine().name.clone()),
            CheckedMotion::Locations(_) => None,
        };
        let grid = args.grid.unwrap_or(setting.grid);
        let options = CheckOptions::of_tolerance(
            DeviationTolerance { excess: setting.tolerance[0], gouge: setting.tolerance[1] },
            grid,
        );
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
            bodies,
            chords: setting.chords,
            warnings,
            contradictions,
            accepted: accepted(args),
            coolant: setting.coolant,
            planned,
            assumptions: args.what_if.clone(),
        })
    }

    /// Runs the program and returns everything that is found.
    pub(super) fn check(&self, bars: &dyn Progress) -> Result<InspectionReport, Failure> {
        let tools = self.table();
        let inspection = Inspection::new(self.input(&tools), self.options).others(&self.others);
        let mut inspection = inspection.coolant(self.coolant);
        if let Some((tools, feed)) = &self.planned {
            inspection = inspection.planned(PlannedCuts { tools, feed: *feed });
        }
        if let Some(stock) = &self.stock {
            inspection = inspection.stock(stock, MOST_COLLISIONS);
        }
        if let Some(fixtures) = &self.fixtures {
            inspection = inspection.fixtures(fixtures.all(), fixtures.watch());
        }
        if let Some(machine) = &self.bodies {
            inspection = inspection.bodies(machine.bodies(), machine.watch());
        }
        inspection.run(bars).map_err(|error| self.failure(&error))
    }

    /// Returns true if only axes and the state of the control are audited.
    pub(super) fn meets_nothing(&self) -> bool {
        self.part.is_none() && self.stock.is_none() && self.fixtures.is_none()
    }

    /// Returns the tools by number for the replay.
    fn table(&self) -> Vec<Tool<'_>> {
        self.tools.iter().map(|(number, cutter)| Tool { number: *number, cutter }).collect()
    }

    fn input<'a>(&'a self, tools: &'a [Tool<'a>]) -> CheckInput<'a> {
        let input = match &self.motion {
            CheckedMotion::Program(program, kinematics) => {
                CheckInput::program(&**program, kinematics, &self.cutter)
            }
            CheckedMotion::Locations(file) => CheckInput::locations(&**file, &self.cutter),
        };
        self.with_tables(input, tools)
    }

    /// Sets faces and the tables of the control.
    pub(super) fn with_tables<'a>(
        &'a self,
        input: CheckInput<'a>,
        tools: &'a [Tool<'a>],
    ) -> CheckInput<'a> {
        input.faces(&self.faces).tools(tools).offsets(&self.offsets)
    }

    /// Returns positions of the tool for the picture.
    pub(super) fn track(&self) -> Result<Vec<Track>, Failure> {
        let tools = self.table();
        verify::track(&self.input(&tools), DRAWN_STEP).map_err(|error| self.failure(&error))
    }

    /// Returns machine and tool over the time of the program.
    pub(super) fn timeline(&self) -> Result<Vec<TimelinePoint>, Failure> {
        let tools = self.table();
        verify::timeline(&self.input(&tools), &TimelineOptions::for_pictures())
            .map_err(|error| self.failure(&error))
    }

    /// Returns the machine of the program; `None` for cutter locations.
    pub(super) fn program_machine(&self) -> Option<&Machine> {
        match &self.motion {
            CheckedMotion::Program(_, kinematics) => Some(kinematics.machine()),
            CheckedMotion::Locations(_) => None,
        }
    }

    /// Replays the blocks of the program, arcs in chords within `chord` \[mm\].
    pub(super) fn replay_blocks<E: From<VerifyError>>(
        &self,
        chord: f64,
        visit: impl FnMut(&ReplayedBlock) -> Result<(), E>,
    ) -> Result<(), E> {
        let tools = self.table();
        verify::replay_blocks(&self.input(&tools), chord, visit)
    }

    /// Returns the raw material, if it was named.
    pub(super) fn stock(&self) -> Option<&Stock> {
        self.stock.as_ref()
    }

    /// Prepares stock to be cut by the program, to the accuracy that its rays have.
    pub(super) fn timed_stock(&self, stock: &Stock) -> Result<TimedStock, Failure> {
        let options = TimedStockOptions::within(stock.tolerance(f64::INFINITY));
        let tools = self.table();
        TimedStock::new(&self.input(&tools), stock, &options).map_err(|error| self.failure(&error))
    }

    /// Words an error, with the options that help.
    pub(super) fn failure(&self, error: &VerifyError) -> Failure {
        let remedy = remedy::words(error);
        match error {
            VerifyError::Cancelled(_) => Failure::Stopped,
            VerifyError::FromBehind { from_back, examined } => Failure::input(format!(
                "{}: the tool cuts the faces of {} from behind, at {from_back} of {examined} points examined{remedy}",
                self.program,
                self.part.as_deref().unwrap_or_default()
            )),
            error => {
                let program: Option<&dyn ProgramSource> = match &self.motion {
                    CheckedMotion::Program(program, _) => Some(&**program),
                    CheckedMotion::Locations(_) => None,
                };
                let mut fault = error.fault(program);
                // The library names the cause; the options are those of this command line.
                fault.message += &remedy;
                Failure::faults(Path::new(&self.program), &[fault])
            }
        }
    }
}

/// Returns the kinds of findings that do not fail the check: the program of one operation leaves what others cut.
fn accepted(args: &CheckArgs) -> Vec<FindingKind> {
    let left = [FindingKind::Uncut, FindingKind::Excess];
    let of_operation = args.operation.map(|_| left).into_iter().flatten();
    args.accept.iter().copied().chain(of_operation).collect()
}

/// Returns the work offsets beside that of the setup.
fn offsets(args: &CheckArgs, kinematics: Option<&Kinematics>) -> Vec<WorkOffset> {
    // Offsets are compared with G54, which the setup defines.
    let g54 = kinematics.and_then(work_offset).unwrap_or_default();
    args.offset.iter().map(|argument| argument.offset(g54)).collect()
}

/// Returns the number that the program gives its only tool, if it is not that of the job.
fn misnamed(motion: &CheckedMotion, own: u32) -> Option<u32> {
    let called = match motion {
        CheckedMotion::Program(program, _) => program.tools().first().copied(),
        CheckedMotion::Locations(file) => file.tools().first().map(|tool| tool.number),
    };
    // The check of the state finds a call that is missing.
    called.filter(|number| *number != own)
}

/// Tools of the command line or of the job.
struct DescribedTools<'a> {
    numbered: &'a [(u32, Cutter)],
    /// Number of the job's only tool.
    own: Option<u32>,
    /// The only tool, where none has a number.
    only: &'a Cutter,
    /// Use of their shapes.
    shapes: ToolShape,
}

impl DescribedTools<'_> {
    /// States which tools that a program calls are others in the control's own tool table.
    fn others(&self, motion: &CheckedMotion, table: &[ToolRow]) -> Vec<String> {
        let CheckedMotion::Program(program, _) = motion else { return Vec::new() };
        let tools = program.tools().iter().filter_map(|&number| self.tool(number));
        tools.filter_map(|tool| tool.contradiction(table, "--tool-length")).collect()
    }

    /// Returns the tool that is checked under a number; `None` if there is none, or another one stands in for it.
    fn tool(&self, number: u32) -> Option<DescribedTool> {
        let numbered = self.numbered.iter().find(|(own, _)| *own == number);
        let cutter = match numbered {
            Some((_, cutter)) => cutter,
            None if !self.numbered.is_empty() || self.own.is_some_and(|own| own != number) => {
                return None;
            }
            None => self.only,
        };
        let tool = described(number, cutter);
        // Without anything to meet, the shape of the cutter is nominal.
        let diameter = tool.diameter.filter(|_| self.shapes == ToolShape::Needed);
        Some(DescribedTool { diameter, ..tool })
    }
}

/// Program, and the tool table of its control.
struct ReadProgram {
    motion: CheckedMotion,
    tools: Vec<ToolRow>,
}

/// Reads the program.
fn motion(args: &CheckArgs, kinematics: Option<Kinematics>) -> Result<ReadProgram, Failure> {
    let path = &args.program;
    let text = text::program(path)?;
    let faults = |faults: trunnion::types::Diagnostics| Failure::program_faults(path, &faults);
    let guessed = || if inspect::is_cl(path) { Dialect::Apt } else { Dialect::guess(text.lines()) };
    let dialect = args.dialect.unwrap_or_else(guessed);
    if dialect == Dialect::Apt {
        // Cutter locations need no machine: they are checked against the part alone.
        let file = ClText::new(text, MOST_FAULTS).map_err(faults)?;
        return Ok(ReadProgram {
            motion: CheckedMotion::Locations(Box::new(file)),
            tools: Vec::new(),
        });
    }
    let Some(kinematics) = kinematics else {
        let help = "add --machine M; for cutter locations --dialect apt";
        let message = format!("{}: a {} program needs a machine", path.display(), dialect.name());
        return Err(Failure::input(format!("{message}\n  help: {help}")));
    };
    let mut axes = AxisWords::of(kinematics.machine()).map_err(Failure::input)?;
    if args.reversed_rotaries {
        axes = axes.with_reversed_rotaries();
    }
    let mut options = ReadOptions {
        block_delete: args.block_delete,
        parameters: args.parameters.clone(),
        retract_height: machine::top_of_z(kinematics.machine()),
        ..ReadOptions::new(dialect, axes, MOST_FAULTS)
    };
    args.files.fill(&mut options, path)?;
    let tools = options.tools.clone();
    let program = ProgramText::new(text, options).map_err(faults)?;
    Ok(ReadProgram {
        motion: CheckedMotion::Program(Box::new(program), Box::new(kinematics)),
        tools,
    })
}
