//! Smoothing of a CL file, statement by statement; everything but its moves stays as it is.

use super::conserved::ClMotionCount;
use super::profile::Profile;
use std::collections::VecDeque;
use std::io::{self, Write};
use trunnion::nc::read::{ClItem, ClMotion, ClPath, ClReader, ClRecord};
use trunnion::post::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS};
use trunnion::toolpath::{PathSmoother, SmoothError, SmoothOptions, SmoothReport, SmoothSpan};
use trunnion::types::{Diagnostic, PoseTolerance, Station, ToolPose};

/// Share of the tolerances for the straight moves between the locations written; the path has the rest.
pub(super) const SHARE: f64 = 0.5;

/// Rounding of the decimals written: half a unit of the last in three coordinates, rounded up \[mm, rad\].
pub(super) const WRITTEN: [f64; 2] = [1e-6, 1e-9];

/// Share of the tip tolerance for the division of arcs into straight moves before smoothing.
pub(super) const ARC_SHARE: f64 = 1.0 / 16.0;

/// Default radius of the tool \[mm\].
const USUAL_RADIUS: f64 = 10.0;

/// Result of copying or smoothing a file.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    pub(super) report: SmoothReport,
    /// Number of locations read and written.
    pub(super) locations: [usize; 2],
    pub(super) profile: Profile,
    /// Motion as it was read, and as it was read back.
    pub(super) conserved: [ClMotionCount; 2],
}

/// Reason why a statement was not written.
#[derive(Debug)]
pub(super) enum Stop {
    /// The file cannot be smoothed.
    Diagnostic(Diagnostic),
    /// The output failed.
    Output(io::Error),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Feed moves between two rapid moves, or between statements of other kinds.
struct Stretch {
    smoother: Option<PathSmoother>,
    /// Feeds \[mm/s\], each with the station from which it holds.
    feeds: VecDeque<(usize, f64)>,
    /// Remarks, each with the number of stations before it.
    remarks: VecDeque<(usize, Vec<u8>)>,
    stations: usize,
    /// Last span, whose end is known with the next.
    held: Option<SmoothSpan>,
    /// Last record.
    last: ClRecord,
}

/// Writes a smoothed file.
pub(super) struct Rewriter<W> {
    out: W,
    /// Tolerance of the path.
    path: PoseTolerance,
    /// Tolerance of the moves between the locations written.
    moves: PoseTolerance,
    stretch: Option<Stretch>,
    /// Position of the tool.
    place: Option<ToolPose>,
    /// Last feed written \[mm/s\].
    feed: Option<f64>,
    /// Millimetres in the unit of the file.
    unit: f64,
    /// True after a location whose tool axis is not z: from there on, all are written with their axis.
    tilted: bool,
    sheet: Sheet,
}

impl<W: Write> Rewriter<W> {
    pub(super) fn new(out: W, tolerance: PoseTolerance) -> Self {
        let PoseTolerance { tip, axis } = tolerance;
        // Arcs, path, straight moves and rounding share the tip tolerance.
        let tip = (1.0 - SHARE - ARC_SHARE) * tip - WRITTEN[0];
        let path = PoseTolerance::new(tip, (1.0 - SHARE) * axis - WRITTEN[1]);
        Self {
            out,
            path,
            moves: tolerance.scaled(SHARE),
            stretch: None,
            place: None,
            feed: None,
            unit: 1.0,
            tilted: false,
            sheet: Sheet::default(),
        }
    }

    /// Processes a statement, as read and as written in the file.
    pub(super) fn item(
        &mut self,
        item: &ClItem,
        raw: &[u8],
        reader: &ClReader,
    ) -> Result<(), Stop> {
        match item {
            ClItem::Remark => match &mut self.stretch {
                Some(stretch) => stretch.remarks.push_back((stretch.stations, raw.to_vec())),
                None => self.out.write_all(raw)?,
            },
            // FEDRAT and the like are written again with the moves they apply to.
            ClItem::Manner => {}
            ClItem::Words => {
                self.end_stretch()?;
                self.out.write_all(raw)?;
                self.unit = reader.unit();
                self.place = reader.place();
            }
            ClItem::Location(record) => self.location(record, raw, reader)?,
        }
        Ok(())
    }

    /// Ends the file.
    pub(super) fn finish(mut self) -> Result<Sheet, Stop> {
        self.end_stretch()?;
        self.out.flush()?;
        Ok(self.sheet)
    }

    fn location(&mut self, record: &ClRecord, raw: &[u8], reader: &ClReader) -> Result<(), Stop> {
        self.sheet.locations[0] += 1;
        let arc = ARC_SHARE * self.moves.tip / SHARE;
        match (record.way, record.motion, self.place) {
            // A drilling cycle is written as it is: its moves belong to the control.
            (ClPath::Hole(_), ..) => {
                self.end_stretch()?;
                if let Some(feed) = reader.feed() {
                    self.feed_is(feed)?;
                }
                self.out.write_all(raw)?;
                self.sheet.locations[1] += 1;
            }
            (_, ClMotion::Feed(feed), Some(place)) => {
                for record in record.straight(Some(&place), arc) {
                    self.push(&record, &place, feed, reader)?;
                }
            }
            (_, motion, place) => {
                self.end_stretch()?;
                for record in record.straight(place.as_ref(), arc) {
                    self.goto(&record.pose, motion)?;
                }
            }
        }
        self.place = Some(record.end());
        Ok(())
    }

    fn push(
        &mut self,
        record: &ClRecord,
        from: &ToolPose,
        feed: f64,
        reader: &ClReader,
    ) -> Result<(), Stop> {
        let mut stretch = match self.stretch.take() {
            Some(stretch) => stretch,
            // The first feed move starts at the current position of the tool.
            None => self.start(record, from, reader)?,
        };
        let Some(smoother) = &mut stretch.smoother else { return Ok(()) };
        let pushed = smoother.push(&station(&record.pose));
        pushed.map_err(|error| refused(&error, stretch.last.line))?;
        let spans = smoother.take();
        if stretch.feeds.back().is_none_or(|(_, last)| last.total_cmp(&feed).is_ne()) {
            stretch.feeds.push_back((stretch.stations, feed));
        }
        stretch.stations += 1;
        stretch.last = *record;
        for span in &spans {
            self.span(&mut stretch, span)?;
        }
        self.stretch = Some(stretch);
        Ok(())
    }

    fn start(
        &self,
        record: &ClRecord,
        from: &ToolPose,
        reader: &ClReader,
    ) -> Result<Stretch, Stop> {
        let radius = reader.cutter().map_or(USUAL_RADIUS, |[diameter, _]| 0.5 * diameter);
        let mut options = SmoothOptions::within(self.path);
        options.lever = if radius > 0.0 { radius } else { USUAL_RADIUS };
        options.corner = CORNER;
        options.step_ratio = STEP_RATIO;
        options.largest_blend = LARGEST_BLEND;
        options.window = WINDOW_STATIONS;
        let mut smoother = PathSmoother::new(&options).map_err(|error| refused(&error, 0))?;
        smoother.push(&station(from)).map_err(|error| refused(&error, record.line))?;
        Ok(Stretch {
            smoother: Some(smoother),
            feeds: VecDeque::new(),
            remarks: VecDeque::new(),
            stations: 1,
            held: None,
            last: *record,
        })
    }

    fn end_stretch(&mut self) -> Result<(), Stop> {
        let Some(mut stretch) = self.stretch.take() else { return Ok(()) };
        let Some(smoother) = stretch.smoother.take() else { return Ok(()) };
        match smoother.finish() {
            Ok((spans, report)) => {
                self.sheet.report.add(&report);
                for span in &spans {
                    self.span(&mut stretch, span)?;
                }
                if let Some(held) = stretch.held.take() {
                    let end = stretch.stations - 1;
                    self.write(&mut stretch, &held, end)?;
                }
            }
            // Nothing to smooth: all stations coincide within a small part of the tolerance.
            Err(SmoothError::Stations(stations)) => {
                self.sheet.report.stations += stations;
                self.sheet.report.merged += stations - 1;
                let ClRecord { pose, motion, .. } = stretch.last;
                self.goto(&pose, motion)?;
            }
            Err(error) => return Err(refused(&error, stretch.last.line)),
        }
        for (_, raw) in stretch.remarks {
            self.out.write_all(&raw)?;
        }
        Ok(())
    }

    /// Holds a span back, and writes the one before.
    fn span(&mut self, stretch: &mut Stretch, span: &SmoothSpan) -> Result<(), Stop> {
        match stretch.held.replace(*span) {
            Some(before) => self.write(stretch, &before, span.station),
            None => Ok(()),
        }
    }

    /// Writes the locations of a span up to a station, at the least feed of the records it stands for.
    fn write(&mut self, stretch: &mut Stretch, span: &SmoothSpan, to: usize) -> Result<(), Stop> {
        let to = to.max(span.station + 1);
        while stretch.remarks.front().is_some_and(|(behind, _)| *behind <= to) {
            if let Some((_, raw)) = stretch.remarks.pop_front() {
                self.out.write_all(&raw)?;
            }
        }
        // Feeds that ended before this span are no longer needed.
        while stretch.feeds.get(1).is_some_and(|(from, _)| *from <= span.station + 1) {
            stretch.feeds.pop_front();
        }
        // A span may replace moves of several feeds: the slowest of them is safe.
        let feeds = stretch.feeds.iter().take_while(|(from, _)| *from <= to);
        let feed = feeds.map(|(_, feed)| *feed).reduce(f64::min);
        let motion = feed.map_or(ClMotion::Rapid, ClMotion::Feed);
        // As few straight moves as keep the other share of the tolerances.
        let parts = span.chords(self.moves);
        for part in 1..=parts {
            if let Some(pose) = span.pose(f64::from(part) / f64::from(parts)) {
                self.goto(&pose, motion)?;
            }
        }
        let length = self.sheet.profile.length() + span.range.high - span.range.low;
        self.sheet.profile.push(length, &span.deviated);
        Ok(())
    }

    fn feed_is(&mut self, feed: f64) -> Result<(), Stop> {
        if self.feed.is_none_or(|last| last.total_cmp(&feed).is_ne()) {
            if self.unit > 1.0 {
                writeln!(self.out, "FEDRAT/{:.4},IPM", feed * 60.0 / 25.4)?;
            } else {
                writeln!(self.out, "FEDRAT/{:.3},MMPM", feed * 60.0)?;
            }
            self.feed = Some(feed);
        }
        Ok(())
    }

    fn goto(&mut self, pose: &ToolPose, motion: ClMotion) -> Result<(), Stop> {
        match motion {
            ClMotion::Rapid => {
                writeln!(self.out, "RAPID")?;
                // Postprocessors differ in keeping the feed over RAPID: the next feed move states it again.
                self.feed = None;
            }
            ClMotion::Feed(feed) => self.feed_is(feed)?,
        }
        let [p, a] = [pose.tip.coords / self.unit, pose.axis.into_inner()];
        self.tilted |= a.x != 0.0 || a.y != 0.0 || a.z < 0.0;
        // 1e-8 in is finer than 1e-6 mm: both keep the rounding in WRITTEN.
        let decimals = if self.unit > 1.0 { 8 } else { 6 };
        write!(self.out, "GOTO/{:.decimals$},{:.decimals$},{:.decimals$}", p.x, p.y, p.z)?;
        if self.tilted {
            write!(self.out, ",{:.9},{:.9},{:.9}", a.x, a.y, a.z)?;
        }
        writeln!(self.out)?;
        self.sheet.locations[1] += 1;
        Ok(())
    }
}

fn station(pose: &ToolPose) -> Station {
    Station { pose: *pose, contact: pose.tip }
}

fn refused(error: &SmoothError, line: u32) -> Stop {
    let fault = |message: String| Diagnostic { line, column: 0, message, help: String::new() };
    Stop::Diagnostic(match error {
        SmoothError::AxisReversal { .. } => {
            let message = "the tool axis is reversed at the next location: between opposite axes \
                           the turn is not defined";
            fault(message.to_owned()).with_help("insert locations between, or make the move rapid")
        }
        error => fault(error.to_string()),
    })
}
