//! Settings of a posting.

use super::args::{PostArgs, PostTiming};
use super::head::Head;
use super::input::{Input, InputOptions};
use super::tools::Tools;
use crate::outcome::Failure;
use crate::{machine, text};
use std::path::Path;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nc::write::{
    AxisWords, Coolant, OutputFormat, SheetProgram, Style, Template, program_sheet,
};
use trunnion::post::{PostFilter, PostMethod, PostOptions, control_of};
use trunnion::types::Progress;

/// Settings that are known before the input is read.
pub(super) struct Plan {
    pub(super) kinematics: Kinematics,
    pub(super) options: PostOptions,
    pub(super) style: Style,
    pub(super) template: Template,
    pub(super) spindle: Option<f64>,
    /// Coolant of all cuts; `None`: that of the input.
    pub(super) coolant: Option<Coolant>,
    pub(super) input_options: InputOptions,
    /// Lengths of tools by number, where there are several.
    pub(super) tools: Tools,
    /// The machine that a program is for, and its words.
    pub(super) from_machine: Kinematics,
    pub(super) from_words: AxisWords,
}

impl Plan {
    /// Opens the input of the plan.
    pub(super) fn open<'a>(
        &self,
        path: &Path,
        bars: &'a dyn Progress,
    ) -> Result<Input<'a>, Failure> {
        Input::open(path, &self.from_machine, self.from_words, &self.input_options, bars)
    }

    pub(super) fn new(args: &PostArgs, name: &str) -> Result<Self, Failure> {
        let stated = machine::load(name)?.machine;
        let machine = match &args.to_calibrated {
            Some(file) => calibrated(&stated, file)?,
            None => stated.clone(),
        };
        let rotation = args.rotation.map(f64::to_radians);
        let tools = Tools::new(&args.tool_length, &args.from_tool_length, args.tool);
        let setup = Setup::new(args.origin.into(), rotation, tools.length);
        let kinematics = Kinematics::new(&machine, &setup);
        let dialect = args.dialect.unwrap_or_else(|| OutputFormat::of(&machine));
        if args.to_calibrated.is_some() {
            in_axis_positions(dialect)?;
        }
        let from_machine = match &args.from_machine {
            Some(name) => machine::load(name)?.machine,
            None => stated,
        };
        let from_setup = Setup::new(
            // The input is for the same setup unless stated otherwise.
            args.from_origin.unwrap_or(args.origin).into(),
            args.from_rotation.unwrap_or(args.rotation).map(f64::to_radians),
            tools.from_length,
        );
        let mut from_words = AxisWords::of(&from_machine);
        if args.from_reversed_rotaries {
            from_words = from_words.map(AxisWords::with_reversed_rotaries);
        }
        let mut axes = AxisWords::of(&machine).map_err(Failure::input)?;
        if args.reversed_rotaries {
            axes = axes.with_reversed_rotaries();
        }
        // The control may round corners within the same tolerance as the program.
        let style = Style { blend: Some(args.tolerance), ..Style::of(&kinematics, dialect, axes) };
        let template = match &args.template {
            None => Template::of(dialect).map_err(|error| Failure::input(error.to_string())),
            Some(path) => Template::new(&text::read(path)?)
                .map_err(|error| Failure::input(format!("{}: {error}", path.display()))),
        };
        let options = PostOptions {
            // Options are in mm/min, as programs are; the library works in mm/s.
            max_feed: args.max_feed.map(|feed| feed / 60.0),
            method: match args.feed {
                PostTiming::Optimal => PostMethod::Optimal,
                PostTiming::Jerk => PostMethod::Jerk,
                PostTiming::Blocks => PostMethod::Blocks,
                PostTiming::Programmed => PostMethod::Programmed,
            },
            // clap refuses both together.
            filter: match (args.smooth, args.reduce) {
                (true, _) => PostFilter::Smooth,
                (_, true) => PostFilter::Reduce,
                _ => PostFilter::None,
            },
            unwind: args.unwind,
            ..PostOptions::within(control_of(&kinematics, dialect), args.tolerance)
        };
        Ok(Self {
            kinematics,
            options,
            style,
            template: template?,
            spindle: args.spindle,
            coolant: args.coolant.then_some(Coolant::Flood),
            input_options: InputOptions {
                from: args.from,
                tool: args.tool,
                lengths: tools.assumed(),
                parameters: args.parameters.clone(),
                block_delete: args.block_delete,
                files: args.files.clone(),
            },
            tools,
            from_machine: Kinematics::new(&from_machine, &from_setup),
            from_words: from_words.map_err(Failure::input)?,
        })
    }

    /// Returns the machine with the length of a tool.
    pub(super) fn with_tool(&self, number: Option<u32>) -> Kinematics {
        let tool_length = self.tools.length_of(number);
        let setup = Setup { tool_length, ..*self.kinematics.setup() };
        Kinematics::new(self.kinematics.machine(), &setup)
    }

    /// Writes the setup sheet of the program `file`.
    pub(super) fn sheet(&self, file: &str, head: &Head) -> Result<String, Failure> {
        let mut sheet = String::new();
        let program = SheetProgram { file, style: &self.style, lengths: self.tools.lengths() };
        program_sheet(&mut sheet, &self.kinematics, &head.note(), program)
            .map_err(|error| Failure::input(error.to_string()))?;
        Ok(sheet)
    }
}

/// Reads the calibrated file of a machine, which has the same axes in the same order.
fn calibrated(stated: &Machine, file: &str) -> Result<Machine, Failure> {
    let machine = machine::load(file)?.machine;
    if machine.chain == stated.chain {
        return Ok(machine);
    }
    let [here, there] = [&machine, stated].map(|machine| machine.chain.join(" - "));
    Err(Failure::input(format!(
        "--to-calibrated {file}: its chain is {here}, and that of --machine is {there}\n  help: calibrate the machine \
         of --machine; a program for another machine is posted with --machine and --from-machine"
    )))
}

/// Refuses formats in which the control computes the axes by its own kinematics.
fn in_axis_positions(dialect: OutputFormat) -> Result<(), Failure> {
    if dialect == OutputFormat::G93 {
        return Ok(());
    }
    Err(Failure::input(format!(
        "--to-calibrated with dialect {}: the control computes the axes from the tool tip by its own kinematics, and \
         would correct twice or not at all\n  help: write axis positions with -d g93, or enter the calibrated values \
         into the control and run the program as it is",
        dialect.name()
    )))
}
