//! Moves of a CL file, one by one.

use super::Head;
use crate::outcome::Failure;
use crate::path::MOST_FAULTS;
use crate::path::lines::{self, Lines};
use crate::progress::Bars;
use anyhow::Context;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use trunnion::nc::read::{ClItem, ClMotion, ClReader, ClRecord};
use trunnion::pipeline::{PostError, PostMove, PostPace};
use trunnion::types::{Fault, Progress, Stage, ToolPose};

/// Bytes read at a time.
const BUFFER: usize = 1 << 16;

/// Lines between two looks at whether the user wants to stop.
const LINES_A_STEP: u64 = 4096;

/// Arcs become straight moves this close to them \[mm\].
const ARC_TOLERANCE: f64 = 1e-3;

/// A CL file that is being read.
pub(super) struct Input {
    path: PathBuf,
    lines: Lines<Box<dyn BufRead>>,
    size: u64,
    count: u64,
    reader: Option<ClReader>,
    waiting: VecDeque<ClRecord>,
    place: Option<ToolPose>,
    tool: Option<u32>,
    feed: f64,
}

impl Input {
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let (from, size): (Box<dyn BufRead>, u64) = if path == Path::new("-") {
            (Box::new(std::io::stdin().lock()), 0)
        } else {
            let fault = |what: String| Failure::input(format!("{}: {what}", path.display()));
            let size = std::fs::metadata(path).map_err(|error| fault(error.to_string()))?;
            if size.is_dir() {
                return Err(fault("is a folder; a file is wanted".into()));
            }
            let file = File::open(path).map_err(|error| fault(error.to_string()))?;
            (Box::new(BufReader::with_capacity(BUFFER, file)), size.len())
        };
        Ok(Self {
            path: path.to_owned(),
            lines: Lines::new(from),
            size,
            count: 0,
            reader: Some(ClReader::new(MOST_FAULTS)),
            waiting: VecDeque::new(),
            place: None,
            tool: None,
            feed: 0.0,
        })
    }

    /// The next move; `None` at the end.
    pub(super) fn next(&mut self, bars: &Bars) -> Result<Option<PostMove>, Failure> {
        loop {
            if let Some(record) = self.waiting.pop_front() {
                return Ok(Some(self.moved(&record)));
            }
            if !self.line(bars)? {
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
        PostMove { line: record.line, pose: record.pose, q: None, pace }
    }

    /// Reads a line; false at the end.
    fn line(&mut self, bars: &Bars) -> Result<bool, Failure> {
        let Some(reader) = &mut self.reader else { return Ok(false) };
        let unread = || format!("reading {}", self.path.display());
        let Some(line) = self.lines.next().with_context(unread)? else {
            let Some(reader) = self.reader.take() else { return Ok(false) };
            let warnings =
                reader.finish().map_err(|faults| Failure::faults(&self.path, &faults))?;
            for warning in warnings {
                eprintln!("warning: {}:{warning}", self.path.display());
            }
            return Ok(false);
        };
        let item = reader.line(&lines::text(line));
        if reader.is_full() {
            return Err(Failure::faults(&self.path, reader.faults()));
        }
        self.count += 1;
        if self.count.is_multiple_of(LINES_A_STEP) && self.size > 0 {
            let on = bars.report(Stage::Program, self.lines.bytes, self.size);
            if on.is_break() {
                return Err(Failure::Stopped);
            }
        }
        // After a fault only further faults are looked for.
        if let (Some(ClItem::Location(record)), true) = (item, reader.faults().is_empty()) {
            let record = record.moved(&reader.first_from_written());
            let tool = reader.tool();
            self.one_tool(tool, record.line)?;
            let straight = record.straight(self.place.as_ref(), ARC_TOLERANCE);
            self.place = Some(record.end());
            self.waiting.extend(straight);
        }
        Ok(true)
    }

    /// A program is for one tool: its length is in every number where there is no tool-centre-point control.
    fn one_tool(&mut self, tool: Option<u32>, line: u32) -> Result<(), Failure> {
        match (self.tool, tool) {
            (Some(before), Some(now)) if before != now => {
                let message = format!("tool {now} after tool {before}: a program has one tool");
                let fault = Fault { line, column: 0, message, help: String::new() };
                let fault = fault.with_help("post the operations of each tool on their own");
                Err(Failure::faults(&self.path, &[fault]))
            }
            _ => {
                self.tool = tool.or(self.tool);
                Ok(())
            }
        }
    }

    /// What has been told of tool and spindle.
    pub(super) fn head(&self, head: &mut Head) {
        if head.name.is_empty() {
            head.name = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        if let Some(reader) = &self.reader {
            head.tool = reader.tool();
            head.cutter = reader.cutter();
            head.spindle = reader.spindle_speed().unwrap_or(0.0) * 60.0;
        }
        head.feed = self.feed;
    }

    /// A message with the place in the file.
    pub(super) fn failure(&self, error: &PostError) -> Failure {
        let fault = Fault {
            line: error.line(),
            column: 0,
            message: error.to_string(),
            help: error.help().to_owned(),
        };
        Failure::faults(&self.path, &[fault])
    }
}
