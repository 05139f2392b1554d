//! The loop from the first move of an input to the last.

use super::head::Head;
use super::input::{BatchReader, Input, InputBatch, InputMove};
use super::plan::Plan;
use super::summary::LeftOutCount;
use crate::outcome::Failure;
use std::io::Write;
use trunnion::nc::write::Coolant;
use trunnion::post::{PostError, PostMove, PostPace, PostReport, PostSource, Poster, ProgramHead};

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

/// Reads the input of a plan to its end while the program is written; its warnings stand also behind a failure.
pub(super) fn post(
    plan: &Plan,
    input: Input<'_>,
    warnings: &mut Vec<String>,
    out: &mut dyn Write,
) -> Result<Posted, Failure> {
    let mut reader = BatchReader::new(input);
    let posted = posted(plan, &mut reader, out);
    warnings.extend(reader.input.take_warnings());
    posted
}

fn posted(
    plan: &Plan,
    reader: &mut BatchReader<'_>,
    out: &mut dyn Write,
) -> Result<Posted, Failure> {
    let mut posting = Posting {
        plan,
        poster: None,
        head: Head { name: reader.input.name(), ..Head::default() },
        first: None,
        approach: Vec::new(),
        is_cutting: false,
        tools: Vec::new(),
        coolant: Coolant::Off,
        text: String::with_capacity(2 * CHUNK),
    };
    let mut now = reader.next();
    while let Some(batch) = now {
        let mut posted = Ok(());
        let mut next = None;
        // One batch is posted while the next is read: what is written does not depend on either's speed.
        rayon::in_place_scope(|scope| {
            scope.spawn(|_| posted = posting.run(&batch));
            // Behind a failure there is nothing to read.
            next = if batch.failure.is_none() { reader.next() } else { None };
        });
        posted.map_err(|error| reader.input.failure(&error))?;
        if let Some(failure) = batch.failure {
            return Err(failure);
        }
        // Written in chunks, so that memory does not grow with the program.
        if posting.text.len() > CHUNK {
            write(out, &posting.text)?;
            posting.text.clear();
        }
        now = next;
    }
    reader.input.warn();
    let Finished { report, head, text } =
        posting.finish().map_err(|error| reader.input.failure(&error))?;
    write(out, &text)?;
    let contradictions = reader.input.contradictions().to_vec();
    Ok(Posted { report, head, left_out: reader.input.left_out(), contradictions })
}

/// Program that is posted to its end.
struct Finished {
    report: PostReport,
    head: Head,
    /// Text that is not written yet.
    text: String,
}

/// An input that is being posted.
struct Posting<'a> {
    plan: &'a Plan,
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
    /// Takes in the next moves.
    fn run(&mut self, batch: &InputBatch) -> Result<(), PostError> {
        batch.moves.iter().try_for_each(|one| self.take(one, batch))
    }

    /// Takes in the next move.
    fn take(&mut self, read: &InputMove, batch: &InputBatch) -> Result<(), PostError> {
        let InputMove { one, state } = *read;
        // A change of tool ends the program part of the tool before, with its own length.
        if self.plan.tools.are_several() && self.head.tool != batch.tool {
            self.change_tool(batch)?;
        }
        self.head.take(&state);
        self.head.spindle = self.plan.spindle.unwrap_or(self.head.spindle);
        self.head.coolant = self.plan.coolant.unwrap_or(self.head.coolant);
        if let Some(number) = self.head.tool.filter(|number| self.tools.last() != Some(number)) {
            self.tools.push(number);
        }
        self.open(&batch.source)?;
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
    fn open(&mut self, source: &PostSource) -> Result<(), PostError> {
        if self.poster.is_none() {
            let plan = self.plan;
            let machine = plan.with_tool(self.head.tool);
            let new = Poster::new(&machine, source.clone(), &plan.options, &plan.style)?;
            self.poster = Some(new);
        }
        Ok(())
    }

    /// Posts the moves that were held back.
    fn begin_cuts(&mut self) -> Result<(), PostError> {
        self.is_cutting = true;
        self.coolant = self.first.as_ref().map_or(self.coolant, |first| first.coolant);
        std::mem::take(&mut self.approach).iter().try_for_each(|one| self.push(one))
    }

    /// Switches the coolant where the input does.
    fn switch_coolant(&mut self) -> Result<(), PostError> {
        let now = self.head.coolant;
        if std::mem::replace(&mut self.coolant, now) == now {
            return Ok(());
        }
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let texts = ProgramHead { note: &note, template: &self.plan.template };
        let Some(poster) = &mut self.poster else { return Ok(()) };
        poster.switch_coolant(&mut self.text, now, texts)
    }

    fn push(&mut self, one: &PostMove) -> Result<(), PostError> {
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let texts = ProgramHead { note: &note, template: &self.plan.template };
        let Some(poster) = &mut self.poster else { return Ok(()) };
        poster.push(&mut self.text, one, texts)
    }

    /// Ends the part of the tool before.
    fn change_tool(&mut self, batch: &InputBatch) -> Result<(), PostError> {
        self.begin_cuts()?;
        self.is_cutting = false;
        let (Some(poster), Some(before)) = (&mut self.poster, self.first.take()) else {
            return Ok(());
        };
        let texts = ProgramHead { note: &before.note(), template: &self.plan.template };
        let machine = self.plan.with_tool(batch.tool);
        poster.change_tool(&mut self.text, &machine, batch.source.clone(), texts)
    }

    /// Posts what is held back, and the end of the program.
    fn finish(mut self) -> Result<Finished, PostError> {
        self.begin_cuts()?;
        let note = self.first.as_ref().unwrap_or(&self.head).note();
        let last = ProgramHead { note: &note, template: &self.plan.template };
        let poster = self.poster.ok_or(PostError::Empty)?;
        let report = poster.finish(&mut self.text, last)?;
        // Known only now; the sheet has it, the head of the program does not.
        let mut head = self.head;
        head.duration = report.seconds.output + report.rapid_seconds;
        head.tools = self.tools;
        Ok(Finished { report, head, text: self.text })
    }
}

fn write(out: &mut dyn Write, text: &str) -> Result<(), Failure> {
    let written = out.write_all(text.as_bytes());
    Ok(written.map_err(|error| anyhow::Error::new(error).context("writing the program"))?)
}
