//! A CL file with its moves smoothed; everything else stays as it stands.

use crate::outcome::Failure;
use std::fmt::Write;
use std::path::Path;
use trunnion::nc::read::{self, ClFile, ClMotion, ClRecord, Passage};
use trunnion::pipeline::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS};
use trunnion::toolpath::{
    Deviated, Reference, SmoothError, SmoothOptions, SmoothReport, SmoothSpan, Smoother,
};
use trunnion::types::{Fault, Station, ToolPose};

/// Share of the tolerances for the moves between the locations written; the rest is for the path.
pub(super) const SHARE: f64 = 0.5;

/// Radius of the tool where the file does not name one \[mm\].
const USUAL_RADIUS: f64 = 10.0;

/// The new file.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    pub(super) text: String,
    pub(super) report: SmoothReport,
    /// Locations read and written.
    pub(super) locations: [usize; 2],
    /// Distance along the path \[mm\], and what was found up to there.
    pub(super) deviations: Vec<(f64, Deviated)>,
}

/// Smooths the stretches between rapid moves of a file that [`read::cl`] has read before.
pub(super) fn smooth(name: &Path, text: &str, tolerance: [f64; 2]) -> Result<Sheet, Failure> {
    let failure = |faults: &[Fault]| Failure::faults(name, faults);
    let file = read::cl(text, 1).map_err(|faults| failure(&faults))?;
    let radius = file.cutter.map_or(USUAL_RADIUS, |[diameter, _]| 0.5 * diameter);
    let options = SmoothOptions {
        tip: (1.0 - SHARE) * tolerance[0],
        axis: (1.0 - SHARE) * tolerance[1],
        reference: Reference::Chords,
        lever: if radius > 0.0 { radius } else { USUAL_RADIUS },
        corner: CORNER,
        step_ratio: STEP_RATIO,
        largest_blend: LARGEST_BLEND,
        window: WINDOW_STATIONS,
    };
    let chord = tolerance.map(|tolerance| SHARE * tolerance);
    let mut writer =
        Writer { sheet: Sheet::default(), feed: None, millimetres: false, length: 0.0 };
    for passage in read::passages(text) {
        match passage {
            Passage::Words(lines) => lines.iter().for_each(|line| writer.line(line)),
            Passage::Moves(range) => {
                let mut from = range.start;
                while from < range.end {
                    from = writer
                        .stretch(&file, from..range.end, (&options, chord))
                        .map_err(|fault| failure(&[fault]))?;
                }
            }
        }
    }
    writer.sheet.locations[0] = file.records.len();
    Ok(writer.sheet)
}

struct Writer {
    sheet: Sheet,
    /// Feed that holds \[mm/s\].
    feed: Option<f64>,
    millimetres: bool,
    /// Length of the stretches before \[mm\].
    length: f64,
}

impl Writer {
    fn line(&mut self, line: &str) {
        self.sheet.text.push_str(line);
        self.sheet.text.push('\n');
    }

    /// Writes a rapid move, or everything up to the next; where to go on.
    fn stretch(
        &mut self,
        file: &ClFile,
        range: std::ops::Range<usize>,
        (options, chord): (&SmoothOptions, [f64; 2]),
    ) -> Result<usize, Fault> {
        if !self.millimetres {
            self.line("UNITS/MM");
            self.millimetres = true;
        }
        let first = range.start;
        let records = &file.records;
        if records[first].motion == ClMotion::Rapid || first == 0 {
            self.goto(&records[first].pose, records[first].motion);
            return Ok(first + 1);
        }
        let rapid = |at: &usize| records[*at].motion == ClMotion::Rapid;
        let end = range.clone().find(rapid).unwrap_or(range.end);
        // The stretch starts where the tool stands.
        let stations = &records[first - 1..end];
        match spans(stations, options) {
            Ok((spans, report)) => {
                self.sheet.report.add(&report);
                for (at, span) in spans.iter().enumerate() {
                    let to = spans.get(at + 1).map_or(stations.len() - 1, |next| next.station);
                    self.span(span, &stations[span.station..=to.max(span.station + 1)], chord);
                }
                self.length += spans.last().map_or(0.0, |last| last.range[1]);
            }
            // Nothing that could be smoothed.
            Err(SmoothError::Stations(_)) => {
                for record in &records[first..end] {
                    self.goto(&record.pose, record.motion);
                }
            }
            Err(SmoothError::AxisReversal { station, .. }) => {
                let message = "the tool axis turns by more than a right angle to the next location: \
                               the way is not defined";
                let line = stations[station].line;
                let fault =
                    Fault { line, column: 0, message: message.to_owned(), help: String::new() };
                return Err(fault.with_help("insert locations between, or make the move rapid"));
            }
            Err(error) => return Err(Fault::whole(error.to_string())),
        }
        Ok(end)
    }

    /// The locations of a span, at the least feed of the records it stands for.
    fn span(&mut self, span: &SmoothSpan, records: &[ClRecord], [tip, axis]: [f64; 2]) {
        let feed = records.iter().skip(1).filter_map(|record| match record.motion {
            ClMotion::Feed(feed) => Some(feed),
            ClMotion::Rapid => None,
        });
        let motion = feed.reduce(f64::min).map_or(ClMotion::Rapid, ClMotion::Feed);
        let parts = span.chords(tip, axis);
        for part in 1..=parts {
            if let Some(pose) = span.pose(f64::from(part) / f64::from(parts)) {
                self.goto(&pose, motion);
            }
        }
        self.sheet.deviations.push((self.length + span.range[1], span.deviated));
    }

    fn goto(&mut self, pose: &ToolPose, motion: ClMotion) {
        match motion {
            ClMotion::Rapid => {
                self.line("RAPID");
                self.feed = None;
            }
            ClMotion::Feed(feed) => {
                if self.feed != Some(feed) {
                    self.line(&format!("FEDRAT/{:.3},MMPM", feed * 60.0));
                    self.feed = Some(feed);
                }
            }
        }
        let [p, a] = [pose.tip.coords, pose.axis.into_inner()];
        let text = &mut self.sheet.text;
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "GOTO/{:.6},{:.6},{:.6},{:.9},{:.9},{:.9}",
            p.x, p.y, p.z, a.x, a.y, a.z
        );
        self.sheet.locations[1] += 1;
    }
}

fn spans(
    records: &[ClRecord],
    options: &SmoothOptions,
) -> Result<(Vec<SmoothSpan>, SmoothReport), SmoothError> {
    let mut smoother = Smoother::new(options)?;
    for record in records {
        smoother.push(&Station { pose: record.pose, contact: record.pose.tip })?;
    }
    smoother.finish()
}
