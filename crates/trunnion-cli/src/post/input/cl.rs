//! Cutter locations.

use super::{ARC_TOLERANCE, Source, stem};
use crate::outcome::Failure;
use crate::path::MOST_FAULTS;
use crate::post::Head;
use std::collections::VecDeque;
use trunnion::blocks::Control;
use trunnion::nc::read::{ClItem, ClMotion, ClReader, ClRecord};
use trunnion::pipeline::{PostMove, PostPace};
use trunnion::types::{Fault, ToolPose};

/// A CL file that is being read.
pub(in crate::post) struct Locations<'a> {
    pub(super) source: Source<'a>,
    reader: Option<ClReader>,
    waiting: VecDeque<ClRecord>,
    place: Option<ToolPose>,
    tool: Option<u32>,
    feed: f64,
}

impl<'a> Locations<'a> {
    pub(super) fn new(source: Source<'a>) -> Self {
        Self {
            source,
            reader: Some(ClReader::new(MOST_FAULTS)),
            waiting: VecDeque::new(),
            place: None,
            tool: None,
            feed: 0.0,
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
        PostMove { line, pose, q: None, pace, way: Control::GreatCircle }
    }

    /// Reads a line; false at the end.
    fn line(&mut self) -> Result<bool, Failure> {
        let Some(reader) = &mut self.reader else { return Ok(false) };
        let Some(line) = self.source.line()? else {
            let Some(reader) = self.reader.take() else { return Ok(false) };
            let path = &self.source.path;
            let warnings = reader.finish().map_err(|faults| Failure::faults(path, &faults))?;
            for warning in warnings {
                eprintln!("warning: {}:{warning}", path.display());
            }
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
            self.one_tool(tool, record.line)?;
            if record.way == trunnion::nc::read::ClWay::Straight {
                self.waiting.push_back(record);
            } else {
                self.waiting.extend(record.straight(self.place.as_ref(), ARC_TOLERANCE));
            }
            self.place = Some(record.end());
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
                Err(Failure::faults(&self.source.path, &[fault]))
            }
            _ => {
                self.tool = tool.or(self.tool);
                Ok(())
            }
        }
    }

    pub(super) fn head(&self, head: &mut Head) {
        if head.name.is_empty() {
            head.name = stem(&self.source.path);
        }
        if let Some(reader) = &self.reader {
            head.tool = reader.tool();
            head.cutter = reader.cutter();
            head.spindle = reader.spindle_speed().unwrap_or(0.0) * 60.0;
        }
        head.feed = self.feed;
    }
}
