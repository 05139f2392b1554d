//! Motion of a CL file as it is read, and as it is read back from what is written.

use crate::outcome::Failure;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;
use trunnion::nc::read::{ClItem, ClMotion, ClPath, ClReader, ClRecord};
use trunnion::post::MOST_FAULTS;
use trunnion::types::ToolPose;

/// Chord tolerance of arcs \[mm\].
const ARC: f64 = 1e-3;

/// Rounding of a location \[mm\].
const ROUNDING: f64 = 1e-3;

/// Motion that was counted: rapid, then with feed; mm.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct ClMotionCount {
    pub(super) moves: [usize; 2],
    /// Travel of the tip.
    pub(super) length: [f64; 2],
    pub(super) holes: usize,
}

/// Count in progress.
#[derive(Debug, Default)]
pub(super) struct Counter {
    pub(super) count: ClMotionCount,
    at: Option<ToolPose>,
}

impl Counter {
    pub(super) fn item(&mut self, item: &ClItem) {
        if let ClItem::Location(record) = item {
            self.add(record);
        }
    }

    fn add(&mut self, record: &ClRecord) {
        // The first location has no motion: the tool is put there.
        let from = self.at.replace(record.end());
        let Some(from) = from else { return };
        let kind = usize::from(record.motion != ClMotion::Rapid);
        self.count.moves[kind] += 1;
        if record.way == ClPath::Straight {
            self.count.length[kind] += (record.end().tip - from.tip).norm();
            return;
        }
        // Arcs and holes are counted over the same chords in the input and in the output.
        let mut at = from;
        for part in record.straight(Some(&from), ARC) {
            let kind = usize::from(part.motion != ClMotion::Rapid);
            self.count.length[kind] += (part.pose.tip - at.tip).norm();
            at = part.pose;
        }
        self.count.holes += usize::from(matches!(record.way, ClPath::Hole(_)));
    }
}

/// Writer that reads back what passes.
pub(super) struct Counted<W> {
    out: W,
    line: Vec<u8>,
    reader: ClReader,
    counter: Counter,
}

impl<W: Write> Counted<W> {
    pub(super) fn new(out: W) -> Self {
        let reader = ClReader::new(MOST_FAULTS);
        Self { out, line: Vec::new(), reader, counter: Counter::default() }
    }

    /// Returns what was counted.
    pub(super) fn count(mut self) -> ClMotionCount {
        self.read();
        self.counter.count
    }

    fn read(&mut self) {
        let text = String::from_utf8_lossy(&self.line);
        if let Some(item) = self.reader.line(text.trim_end_matches(['\r', '\n'])) {
            self.counter.item(&item);
        }
        self.line.clear();
    }
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        for line in bytes.get(..count).unwrap_or_default().split_inclusive(|byte| *byte == b'\n') {
            self.line.extend_from_slice(line);
            if line.ends_with(b"\n") {
                self.read();
            }
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Refuses an output that has other rapid moves than the input, or none of its cuts.
///
/// Smoothing moves the ends of cuts within the tolerance \[mm\]; without it all motion is the same.
pub(super) fn compare(
    name: &Path,
    [read, written]: [&ClMotionCount; 2],
    tolerance: Option<f64>,
) -> Result<(), Failure> {
    let differs = |kind: usize| {
        // Each end of a move is off by at most the tolerance, so the length of a move by twice that.
        let most = 2.0 * read.moves[kind] as f64 * (tolerance.unwrap_or(0.0) + ROUNDING);
        let copied = tolerance.is_none();
        (copied && read.moves[kind] != written.moves[kind])
            || (read.length[kind] - written.length[kind]).abs() > most
    };
    let is_lost = differs(0)
        || read.holes != written.holes
        || match tolerance {
            None => differs(1),
            // Smoothing changes the length of cuts by design, but none may vanish.
            Some(_) => (read.length[1] > 0.0) != (written.length[1] > 0.0),
        };
    if !is_lost {
        return Ok(());
    }
    let name = name.display();
    Err(Failure::input(format!(
        "{name}: motion would be lost or invented: {} rapid moves of {:.4} mm and {} with feed of {:.4} mm were read, \
         {} of {:.4} mm and {} of {:.4} mm written",
        read.moves[0],
        read.length[0],
        read.moves[1],
        read.length[1],
        written.moves[0],
        written.length[0],
        written.moves[1],
        written.length[1]
    )))
}
