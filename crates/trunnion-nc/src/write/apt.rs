//! Legs as an APT/CL file, ISO 4343 style.

use super::error::WriteError;
use super::format::OutputFormat;
use super::note::Note;
use super::number::{FixedNumber, NumberForm, list};
use crate::types::{Leg, Motion, Station};
use std::fmt::Write;

/// Decimals of tool-axis components: an error of 5e-10 rad.
pub(super) const AXIS_DECIMALS: u8 = 9;

/// Decimals of feeds \[mm/min\].
const FEED_DECIMALS: u8 = 3;

/// Legs that one tool runs.
#[derive(Debug, Clone, Copy)]
pub struct LegSection<'a> {
    /// Facts about the tool and its cuts.
    pub note: &'a Note<'a>,
    /// Legs in the order in which they are run.
    pub legs: &'a [Leg],
}

/// Writes legs as APT/CL records in the workpiece frame, tips with `decimals` decimals, tool after tool.
///
/// Links are `RAPID`, everything else runs at the job's feed. The first station of a leg is the last
/// of the leg before and is written once.
///
/// # Errors
///
/// [`WriteError`].
pub fn apt(out: &mut String, sections: &[LegSection<'_>], decimals: u8) -> Result<(), WriteError> {
    let first = sections.first().ok_or(WriteError::Empty)?;
    writeln!(out, "PARTNO {}", plain(first.note.name))?;
    writeln!(out, "UNITS/MM")?;
    writeln!(out, "MULTAX/ON")?;
    for section in sections {
        tool_section(out, section, decimals)?;
    }
    out.push_str("FINI\n");
    Ok(())
}

fn tool_section(
    out: &mut String,
    section: &LegSection<'_>,
    decimals: u8,
) -> Result<(), WriteError> {
    let &LegSection { note, legs } = section;
    // The first station is only approached.
    let first = legs.first().and_then(|leg| leg.stations.first()).ok_or(WriteError::Empty)?;
    // APT: CUTTER/diameter, corner radius. The centre circle and the rounding add up to the radius.
    let [diameter, corner] = [2.0 * (note.tool.major + note.tool.minor), note.tool.minor];
    writeln!(out, "LOADTL/{}", note.tool.number)?;
    writeln!(out, "CUTTER/{diameter:.4},{corner:.4}")?;
    writeln!(out, "SPINDL/{:.0},RPM,CLW", note.spindle)?;
    if let Some(words) = OutputFormat::Apt.coolant_words(note.coolant) {
        writeln!(out, "COOLNT/{words}")?;
    }
    // mm/s to mm/min.
    let feed = FixedNumber::nearest(note.feed * 60.0, FEED_DECIMALS);
    let feed = feed.ok_or(WriteError::Number {
        block: 0,
        value: note.feed * 60.0,
        decimals: FEED_DECIMALS,
    })?;
    let mut locations = LocationWriter::default();
    locations.go(out, None, &rounded(0, first, decimals)?);
    for (index, leg) in legs.iter().enumerate() {
        // Links are rapid moves, without a feed.
        let feed = (leg.motion != Motion::Link).then_some(feed);
        // Stations are shared by consecutive legs: each is written once.
        for station in leg.stations.iter().skip(1) {
            locations.go(out, feed, &rounded(index, station, decimals)?);
        }
    }
    if note.coolant.is_on() {
        out.push_str("COOLNT/OFF\n");
    }
    out.push_str("SPINDL/OFF\n");
    Ok(())
}

/// Records of cutter locations; the feed is written where it changes.
#[derive(Debug, Default)]
pub(super) struct LocationWriter {
    feed: Option<FixedNumber>,
}

impl LocationWriter {
    /// Writes one `GOTO`, with `feed` \[mm/min\]; `None`: in rapid.
    pub(super) fn go(
        &mut self,
        out: &mut String,
        feed: Option<FixedNumber>,
        location: &[FixedNumber; 6],
    ) {
        match feed {
            None => out.push_str("RAPID\n"),
            Some(feed) if self.feed != Some(feed) => {
                out.push_str("FEDRAT/");
                feed.push(out, NumberForm::Point);
                out.push_str(",MMPM\n");
            }
            Some(_) => {}
        }
        // RAPID holds for one location, so the feed is written again behind it.
        self.feed = feed;
        out.push_str("GOTO/");
        out.push_str(&list(location.iter()));
        out.push('\n');
    }
}

/// Rounds tip \[mm\] and axis of a station.
fn rounded(leg: usize, station: &Station, decimals: u8) -> Result<[FixedNumber; 6], WriteError> {
    let [tip, axis] = [station.pose.tip.coords, station.pose.axis.into_inner()];
    let fixed = |value: f64, decimals: u8| {
        let number = FixedNumber::nearest(value, decimals);
        number.ok_or(WriteError::Number { block: leg, value, decimals })
    };
    Ok([
        fixed(tip.x, decimals)?,
        fixed(tip.y, decimals)?,
        fixed(tip.z, decimals)?,
        fixed(axis.x, AXIS_DECIMALS)?,
        fixed(axis.y, AXIS_DECIMALS)?,
        fixed(axis.z, AXIS_DECIMALS)?,
    ])
}

/// Returns a name on one line that no reader takes for a comment or a continued line.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() && c != '$' { c } else { ' ' }).collect()
}
