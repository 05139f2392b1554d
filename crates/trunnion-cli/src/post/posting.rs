//! The loop from the first move of an input to the last.

use super::head::Head;
use super::input::Input;
use super::plan::Plan;
use super::summary::LeftOutCount;
use crate::outcome::Failure;
use std::io::Write;
use std::path::Path;
use trunnion::nc::write::Coolant;
use trunnion::post::{PostError, PostMove, PostPace, PostReport, Poster, ProgramHead};
use trunnion::types::Progress;

/// Bytes of text that are kept before they are written.
const CHUNK: usize = 1 << 16;

/// Most moves in front of the first cut of a tool that are held back until the coolant of that cut is known.
const LONGEST_APPROACH: usize = 4096;

/// Result of a posting.
pub(super) struct Posted {
    pub(super) report: PostReport,
    pub(super) head: Head,
    pub(super) left_out: LeftOutCount,
    /// Tools that the tool table of the input's control has otherwise.
    pub(super) contradictions: Vec<String>,
}

/// Reads the input of a plan to its end while the program is written.
pub(super) fn post(
    plan: &Plan,
    path: &Path,
    bars: &dyn Progress,
    out: &mut dyn Write,
) -> Result<Posted, Failure> {
    let input = Input::open(path, &plan.from_machine, plan.from_words, &plan.input_options, bars)?;
    let mut posting = Posting {
        plan,
        input,
        poster: None,
        head: Head::default(),
        first: None,
        approach: Vec::new(),
        is_cutting: false,
        tools: Vec::new(),
        coolant: Coolant::Off,
        text: String::with_capacity(2 * CHUNK),
    };
    while let Some(one) = posting.input.next()? {
        posting.take(one)?;
        // Written in chunks, so that memory does not grow with the program.
        if posting.text.len() > CHUNK {
            write(out, &posting.text)?;
            posting.text.clear();
        }
    }
    posting.finish(out)
}

/// An input that is being posted.
struct Posting<'a> {
    plan: &'a Plan,
    input: Input<'a>,
    poster: Option<Poster>,
    /// State at the last move.
    head: Head,
    /// State that the program of the tool begins with.
    first: Option<Head>,
    /// Moves in front of the first cut of the tool.
    approach: Vec<PostMove>,
    /// The tool has begun to cut, so that its head is settled.
    is_cutting: bool,
    tools: Vec<u32>,
    /// Coolant of the moves that were posted.
    coolant: Coolant,
    text: String,
}

impl Posting<'_> {
    /// Takes in the next move.
    fn take(&mut self, one: PostMove) -> Result<(), Failure> {
        // A change of tool ends the program part of the tool before, with its own length.
        if self.plan.tools.are_several() && self.head.tool != self.input.tool() {
            self.change_tool()?;
        }
        self.input.head(&mut self.head);
        self.head.spindle = self.plan.spindle.unwrap_or(self.head.spindle);
        self.head.coolant = self.plan.coolant.unwrap_or(self.head.coolant);
        if let Some(number) = self.head.tool.filter(|number| self.tools.last() != Some(number)) {
            self.tools.push(number);
        }
        self.open()?;
        let cuts = one.pace != PostPace::Rapid;
        let first = self.first.get_or_insert_with(|| self.head.clone());
        if self.is_cutting {
            self.switch_coolant()?;
            return self.push(&one);
        }
        // Spindle and coolant may start behind the first rapid moves: they are those of the first cut.
        (first.spindle, first.coolant) = (self.head.spindle, self.head.coolant);
        self.approach.push(one);
        if cuts || self.approach.len() >= LONGEST_APPROACH {
            self.begin_cuts()?;
        }
        Ok(())
    }

    /// Makes the poster at the first move.
    fn open(&mut self) -> Result<(), Failure> {
        if self.poster.is_none() {
            let plan = self.plan;
            let machine = plan.with_tool(self.head.tool);
            let new = Poster::new(&machine, self.input.source(), &plan.options, &plan.style);
            self.poster = Some(new.map_err(|error| self.input.failure(&error))?);
        }
        Ok(())
    }

    /// Posts the moves that were held back.
    fn begin_cuts(&mut self) -> Result<(), Failure> {
        self.is_cutting = true;
        self.coolant = self.first.as_ref().map_or(self.coolant, |first| first.coolant);
        std::mem::take(&mut self.approach).iter().try_for_each(|one| self.push(one))
    }

    /// Switches the coolant where the input does.
    fn switch_coolant(&mut self) -> Result<(), Failure> {
        let now = self.head.coolant;
        if std::mem::replace(&mut self.coolant, now) == now {
            return Ok(());
        }
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let texts = ProgramHead { note: &note, template: &self.plan.template };
        let Some(poster) = &mut self.poster else { return Ok(()) };
        let switched = poster.switch_coolant(&mut self.text, now, texts);
        switched.map_err(|error| self.input.failure(&error))
    }

    fn push(&mut self, one: &PostMove) -> Result<(), Failure> {
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let texts = ProgramHead { note: &note, template: &self.plan.template };
        let Some(poster) = &mut self.poster else { return Ok(()) };
        let pushed = poster.push(&mut self.text, one, texts);
        pushed.map_err(|error| self.input.failure(&error))
    }

    /// Ends the part of the tool before.
    fn change_tool(&mut self) -> Result<(), Failure> {
        self.begin_cuts()?;
        self.is_cutting = false;
        let (Some(poster), Some(before)) = (&mut self.poster, self.first.take()) else {
            return Ok(());
        };
        let texts = ProgramHead { note: &before.note(), template: &self.plan.template };
        let machine = self.plan.with_tool(self.input.tool());
        let done = poster.change_tool(&mut self.text, &machine, self.input.source(), texts);
        done.map_err(|error| self.input.failure(&error))
    }

    /// Writes what is held back, and the end of the program.
    fn finish(mut self, out: &mut dyn Write) -> Result<Posted, Failure> {
        self.begin_cuts()?;
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let last = ProgramHead { note: &note, template: &self.plan.template };
        let poster = self.poster.ok_or_else(|| self.input.failure(&PostError::Empty))?;
        let report = poster.finish(&mut self.text, last);
        let report = report.map_err(|error| self.input.failure(&error))?;
        write(out, &self.text)?;
        // Known only now; the sheet has it, the head of the program does not.
        let mut head = self.head;
        head.duration = report.seconds.output + report.rapid_seconds;
        head.tools = self.tools;
        let left_out = self.input.left_out();
        let contradictions = self.input.contradictions().to_vec();
        Ok(Posted { report, head, left_out, contradictions })
    }
}

fn write(out: &mut dyn Write, text: &str) -> Result<(), Failure> {
    let written = out.write_all(text.as_bytes());
    Ok(written.map_err(|error| anyhow::Error::new(error).context("writing the program"))?)
}
