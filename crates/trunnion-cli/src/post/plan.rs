//! Settings of a posting, and the loop from the first move to the last.

use super::args::{Args, Method};
use super::head::Head;
use super::input::{Input, InputOptions};
use super::summary::LeftOutCount;
use super::tools::Tools;
use crate::outcome::Failure;
use crate::progress::Bars;
use crate::{machine, text};
use std::io::Write;
use std::path::Path;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::write::{AxisWords, OutputFormat, SheetProgram, Style, Template, program_sheet};
use trunnion::post::{
    PostError, PostFilter, PostMethod, PostOptions, PostReport, Poster, ProgramHead, control_of,
};

/// Bytes of text that are kept before they are written.
const CHUNK: usize = 1 << 16;

/// Result of a posting.
pub(super) struct Posted {
    pub(super) report: PostReport,
    pub(super) head: Head,
    pub(super) left_out: LeftOutCount,
}

/// Settings that are known before the input is read.
pub(super) struct Plan {
    pub(super) kinematics: Kinematics,
    pub(super) options: PostOptions,
    pub(super) style: Style,
    pub(super) template: Template,
    pub(super) spindle: Option<f64>,
    pub(super) coolant: bool,
    pub(super) input_options: InputOptions,
    /// Lengths of tools by number, where there are several.
    pub(super) tools: Tools,
    /// The machine that a program is for, and its words.
    pub(super) from_machine: Kinematics,
    pub(super) from_words: AxisWords,
}

impl Plan {
    pub(super) fn new(args: &Args, name: &str) -> Result<Self, Failure> {
        let machine = machine::load(name)?.machine;
        let rotation = args.rotation.map(f64::to_radians);
        let tools = Tools::new(&args.tool_length, &args.from_tool_length, args.tool);
        let setup = Setup::new(args.origin.into(), rotation, tools.length);
        let kinematics = Kinematics::new(&machine, &setup);
        let dialect = args.dialect.unwrap_or_else(|| OutputFormat::of(&machine));
        let from_machine = match &args.from_machine {
            Some(name) => machine::load(name)?.machine,
            None => machine.clone(),
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
                Method::Optimal => PostMethod::Optimal,
                Method::Jerk => PostMethod::Jerk,
                Method::Blocks => PostMethod::Blocks,
                Method::Programmed => PostMethod::Programmed,
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
            coolant: args.coolant,
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

    /// Reads the input to its end while the program is written.
    pub(super) fn post(
        &self,
        path: &Path,
        bars: &Bars,
        out: &mut dyn Write,
    ) -> Result<Posted, Failure> {
        let mut input =
            Input::open(path, &self.from_machine, self.from_words, &self.input_options, bars)?;
        let mut poster: Option<Poster> = None;
        let mut text = String::with_capacity(2 * CHUNK);
        let (mut head, mut first) = (Head::default(), None);
        let unwritten = |error| anyhow::Error::new(error).context("writing the program");
        let mut tools: Vec<u32> = Vec::new();
        while let Some(one) = input.next()? {
            // A change of tool ends the program part of the tool before, with its own length.
            let changed = self.tools.are_several() && head.tool != input.tool();
            let begun = poster.as_mut().filter(|_| changed);
            if let (Some(poster), Some(before)) = (begun, first.take_if(|_| changed)) {
                let before: Head = before;
                let texts = ProgramHead { note: &before.note(), template: &self.template };
                let machine = self.with_tool(input.tool());
                let done = poster.change_tool(&mut text, &machine, input.source(), texts);
                done.map_err(|error| input.failure(&error))?;
            }
            input.head(&mut head);
            head.spindle = self.spindle.unwrap_or(head.spindle);
            head.coolant = self.coolant;
            // The head holds the state at the start of the program, whenever it is written.
            let first: &Head = first.get_or_insert_with(|| head.clone());
            let texts = ProgramHead { note: &first.note(), template: &self.template };
            if let Some(number) = head.tool.filter(|number| tools.last() != Some(number)) {
                tools.push(number);
            }
            let poster = match &mut poster {
                Some(poster) => poster,
                none => {
                    let machine = self.with_tool(head.tool);
                    let new = Poster::new(&machine, input.source(), &self.options, &self.style);
                    none.insert(new.map_err(|error| input.failure(&error))?)
                }
            };
            poster.push(&mut text, &one, texts).map_err(|error| input.failure(&error))?;
            // Written in chunks, so that memory does not grow with the program.
            if text.len() > CHUNK {
                out.write_all(text.as_bytes()).map_err(unwritten)?;
                text.clear();
            }
        }
        let note = first.as_ref().unwrap_or(&head).note();
        let last = ProgramHead { note: &note, template: &self.template };
        let poster = poster.ok_or_else(|| input.failure(&PostError::Empty))?;
        let report = poster.finish(&mut text, last).map_err(|error| input.failure(&error))?;
        out.write_all(text.as_bytes()).map_err(unwritten)?;
        // Known only now; the sheet has it, the head of the program does not.
        head.duration = report.seconds.output + report.rapid_seconds;
        head.tools = tools;
        Ok(Posted { report, head, left_out: input.left_out() })
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
