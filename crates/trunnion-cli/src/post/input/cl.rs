//! Moves of a CL file.

use super::source::{ARC_TOLERANCE, InputOptions, Source};
use crate::outcome::Failure;
use crate::post::head::HeadState;
use crate::post::summary::LeftOutCount;
use std::collections::VecDeque;
use trunnion::blocks::BlockInterpolation;
use trunnion::nc::read::{ClItem, ClMotion, ClReader, ClRecord};
use trunnion::post::MOST_FAULTS;
use trunnion::post::{PostMove, PostPace};
use trunnion::types::{Diagnostic, ToolPose};

/// CL file that is being read.
pub(crate) struct Locations<'a> {
    pub(super) source: Source<'a>,
    reader: Option<ClReader>,
    waiting: VecDeque<ClRecord>,
    place: Option<ToolPose>,
    tool: Option<u32>,
    /// Only tool whose locations are posted.
    only: Option<u32>,
    /// Tools whose lengths are known; empty for a single tool.
    known: Vec<u32>,
    feed: f64,
    /// Locations of other tools.
    left: usize,
    /// Warnings of the whole file.
    pub(super) warnings: Vec<String>,
}

impl<'a> Locations<'a> {
    pub(super) fn new(source: Source<'a>, options: &InputOptions) -> Self {
        Self {
            source,
            reader: Some(ClReader::new(MOST_FAULTS)),
            waiting: VecDeque::new(),
            place: None,
            tool: None,
            only: options.tool,
            known: options.lengths.iter().map(|tool| tool.number).collect(),
            feed: 0.0,
            left: 0,
            warnings: Vec::new(),
        }
    }

    pub(super) fn next(&mut self) -> Result<Option<PostMove>, Failure> {
        loop {
            if let Some(record) = self.waiting.pop_front() {
                return Ok(Some(self.moved(&record)));
            }
            if !self.line()? {
                return Ok(None);
            }
        }
    }

    fn moved(&mut self, record: &ClRecord) -> PostMove {
        let pace = match record.motion {
            ClMotion::Rapid => PostPace::Rapid,
            ClMotion::Feed(feed) => {
                self.feed = self.feed.max(feed);
                PostPace::Feed(feed)
            }
        };
        let (line, pose) = (record.line, record.pose);
        PostMove { line, pose, q: None, pace, way: BlockInterpolation::GreatCircle }
    }

    /// Reads a line; returns false at the end.
    fn line(&mut self) -> Result<bool, Failure> {
        let Some(reader) = &mut self.reader else { return Ok(false) };
        let Some(line) = self.source.line()? else {
            let Some(reader) = self.reader.take() else { return Ok(false) };
            let path = &self.source.path;
            let found = reader.finish().map_err(|faults| Failure::faults(path, &faults))?;
            let placed = found.iter().map(|warning| format!("{}:{warning}", path.display()));
            self.warnings.extend(placed);
            return Ok(false);
        };
        let item = reader.line(&line);
        if reader.is_full() {
            return Err(Failure::faults(&self.source.path, reader.faults()));
        }
        // After a fault only further faults are looked for.
        if let (Some(ClItem::Location(record)), true) = (item, reader.faults().is_empty()) {
            let record = record.moved(&reader.first_from_written());
            let tool = reader.tool();
            // An arc starts where the last location ended, even if that tool is not posted.
            let from = self.place.replace(record.end());
            if !self.is_wanted(tool, record.line)? {
                self.left += 1;
                return Ok(true);
            }
            if record.way == trunnion::nc::read::ClPath::Straight {
                self.waiting.push_back(record);
            } else {
                self.waiting.extend(record.straight(from.as_ref(), ARC_TOLERANCE));
            }
        }
        Ok(true)
    }

    /// Returns true if a location is posted. Without the lengths of several tools, a program is for one tool: without
    /// tool-centre-point control its length is part of every axis position.
    fn is_wanted(&mut self, tool: Option<u32>, line: u32) -> Result<bool, Failure> {
        let before = self.tool;
        self.tool = tool.or(before);
        let refused = |message: String, help: &str| {
            let fault = Diagnostic { line, column: 0, message, help: String::new() };
            Failure::faults(&self.source.path, &[fault.with_help(help)])
        };
        if let (None, Some(now), false) = (self.only, self.tool, self.known.is_empty()) {
            if self.known.contains(&now) {
                return Ok(true);
            }
            let help = "give its length: --tool-length NUMBER=L";
            return Err(refused(format!("tool {now}: its length is not known"), help));
        }
        match (self.only, before, self.tool) {
            (Some(only), _, now) if now != Some(only) => Ok(false),
            // Moves between two uses of the tool are left out: the cut could not continue safely.
            (Some(only), Some(before), _) if before != only && self.feed > 0.0 => {
                let message = format!("tool {only} is called a second time, after another tool");
                Err(refused(message, "post the part of the file from here on by itself"))
            }
            (None, Some(before), Some(now)) if before != now => {
                let message = format!("tool {now} after tool {before}: a program has one tool");
                Err(refused(
                    message,
                    "give the length of each tool, --tool-length NUMBER=L; or post one tool: --tool NUMBER",
                ))
            }
            _ => Ok(true),
        }
    }

    pub(super) fn left_out(&self) -> LeftOutCount {
        LeftOutCount { moves: self.left, ..LeftOutCount::default() }
    }

    pub(super) fn tool(&self) -> Option<u32> {
        self.tool
    }

    pub(super) fn state(&self) -> HeadState {
        let feed = self.feed;
        let Some(reader) = &self.reader else { return HeadState { feed, ..HeadState::default() } };
        HeadState {
            tool: reader.tool(),
            cutter: reader.cutter(),
            spindle: reader.spindle_speed().unwrap_or(0.0) * 60.0,
            coolant: reader.coolant(),
            feed,
        }
    }
}
