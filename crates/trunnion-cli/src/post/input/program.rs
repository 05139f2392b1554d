//! Moves of an NC program.

use super::refusal::failure;
use super::source::{ARC_TOLERANCE, InputOptions, Source};
use crate::outcome::Failure;
use crate::post::head::HeadState;
use crate::post::summary::LeftOutCount;
use crate::table_tool::DescribedTool;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use trunnion::machine::Kinematics;
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, Steps, ToolRow, steps};
use trunnion::post::MOST_FAULTS;
use trunnion::post::{LeftOut, PostMove, PostPace, ProgramMoves};
use trunnion::types::Diagnostic;

/// Lines of a file for a reader that knows no I/O errors: an error ends the lines and is kept.
struct Text<'a> {
    source: Source<'a>,
    failed: Rc<RefCell<Option<Failure>>>,
}

impl Iterator for Text<'_> {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        match self.source.line() {
            Ok(line) => line.map(std::borrow::Cow::into_owned),
            Err(failure) => {
                *self.failed.borrow_mut() = Some(failure);
                None
            }
        }
    }
}

/// Program that is being read.
pub(crate) struct Program<'a> {
    path: PathBuf,
    steps: Steps<Text<'a>>,
    failed: Rc<RefCell<Option<Failure>>>,
    moves: ProgramMoves,
    /// Moves of the last step; the first `taken` of them have been returned.
    waiting: Vec<PostMove>,
    taken: usize,
    feed: f64,
    ended: bool,
    /// The warnings of the whole program are among those below.
    warned: bool,
    pub(super) warnings: Vec<String>,
    /// Tool table of the control.
    table: Vec<ToolRow>,
    /// Tools so far that the table has otherwise.
    contradictions: Vec<String>,
    /// Last tool that was compared with the table.
    compared: Option<u32>,
}

impl<'a> Program<'a> {
    pub(super) fn new(
        source: Source<'a>,
        dialect: Dialect,
        machine: &Kinematics,
        words: AxisWords,
        options: &InputOptions,
    ) -> Result<Self, Failure> {
        let path = source.path.clone();
        let failed = Rc::new(RefCell::new(None));
        let text = Text { source, failed: Rc::clone(&failed) };
        let mut read_options = ReadOptions {
            parameters: options.parameters.clone(),
            block_delete: options.block_delete,
            retract_height: crate::machine::top_of_z(machine.machine()),
            ..ReadOptions::new(dialect, words, MOST_FAULTS)
        };
        options.files.fill(&mut read_options, &path)?;
        // One tool: its moves alone. Several: each with its own length.
        let moves = ProgramMoves::new(machine, ARC_TOLERANCE).map(|moves| match options.tool {
            Some(tool) => moves.only(tool),
            None => moves.with_lengths(&options.lengths),
        });
        Ok(Self {
            steps: steps(text, &read_options),
            moves: moves.map_err(|error| failure(&path, &error))?,
            path,
            failed,
            waiting: Vec::new(),
            taken: 0,
            feed: 0.0,
            ended: false,
            warned: false,
            warnings: Vec::new(),
            table: read_options.tools,
            contradictions: Vec::new(),
            compared: None,
        })
    }

    pub(super) fn next(&mut self) -> Result<Option<PostMove>, Failure> {
        loop {
            if let Some(one) = self.waiting.get(self.taken) {
                self.taken += 1;
                if let PostPace::Feed(feed) = one.pace {
                    self.feed = self.feed.max(feed);
                }
                return Ok(Some(*one));
            }
            self.waiting.clear();
            self.taken = 0;
            if self.ended {
                return Ok(None);
            }
            let step = self.steps.next();
            // The reader takes an error for the end of the file: the kept failure comes first.
            if let Some(failure) = self.failed.borrow_mut().take() {
                return Err(failure);
            }
            match step {
                None => self.ended = true,
                Some(Err(faults)) => return Err(Failure::program_faults(&self.path, &faults)),
                Some(Ok(step)) => {
                    let taken = self.moves.step(&step, &mut self.waiting);
                    taken.map_err(|error| failure(&self.path, &error))?;
                    self.compare_tool();
                }
            }
        }
    }

    /// Compares the tool in the spindle with the tool table of the control.
    fn compare_tool(&mut self) {
        let Some(number) = self.moves.tool().filter(|number| self.compared != Some(*number)) else {
            return;
        };
        self.compared = Some(number);
        let length = self.kinematics().setup().tool_length;
        let tool = DescribedTool { number, length, diameter: None };
        if let Some(found) = tool.contradiction(&self.table, "--from-tool-length")
            && !self.contradictions.contains(&found)
        {
            self.contradictions.push(found);
        }
    }

    /// Returns the tools that the tool table of the control has otherwise.
    pub(super) fn contradictions(&self) -> &[String] {
        &self.contradictions
    }

    pub(super) fn tool(&self) -> Option<u32> {
        self.moves.tool()
    }

    /// Returns the machine with the tool in the spindle.
    pub(super) fn kinematics(&self) -> &Kinematics {
        self.moves.kinematics()
    }

    /// Warns of moves without a tool length, of which a refusal may come.
    pub(super) fn explain_refusal(&mut self, line: u32) {
        // At the end of the program it was warned of; behind the refused line it is no reason.
        let first =
            if line == 0 { self.moves.gauge_point() } else { self.moves.gauge_point_at(line) };
        if let Some(first) = first.filter(|_| !self.warned) {
            self.warn_gauge_point(first);
        }
    }

    /// Warns that the moves from a line on are those of the gauge point.
    fn warn_gauge_point(&mut self, line: u32) {
        let path = self.path.display();
        let length = self.moves.kinematics().setup().tool_length;
        let message = format!(
            "no tool length is in force (G43, G43.4, TRAORI, M128): X, Y and Z are taken as the gauge point, \
             {length:.4} mm above the tip"
        );
        let help = "if they are the tip, switch the length on before this line, or give --from-tool-length 0";
        let warning = Diagnostic { line, column: 0, message, help: help.to_owned() };
        self.warnings.push(format!("{path}:{warning}"));
    }

    /// Adds the warnings of the whole program, once it was read to its end.
    pub(super) fn warn(&mut self) {
        if !self.ended || std::mem::replace(&mut self.warned, true) {
            return;
        }
        let path = self.path.display();
        let placed = self.steps.warnings().iter().map(|warning| format!("{path}:{warning}"));
        self.warnings.extend(placed);
        if let Some(line) = self.moves.gauge_point() {
            self.warn_gauge_point(line);
        }
        let left = self.moves.left();
        // Words that cannot move the tool are dropped, but never silently.
        if left.dwells > 0 || left.words > 0 {
            self.warnings.push(format!(
                "{}: left out: {} dwells, {} lines of other words (stops, smoothing, messages): the template has its own",
                self.path.display(),
                left.dwells,
                left.words
            ));
        }
    }

    pub(super) fn state(&self) -> HeadState {
        HeadState {
            tool: self.moves.tool(),
            cutter: None,
            spindle: self.moves.spindle().abs(),
            coolant: self.moves.coolant(),
            feed: self.feed,
        }
    }

    pub(super) fn left_out(&self) -> LeftOutCount {
        let LeftOut { moves, dwells, words, .. } = self.moves.left();
        LeftOutCount { moves, dwells, words }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}
