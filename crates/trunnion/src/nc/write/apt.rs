//! Legs as an APT/CL file, ISO 4343 style.

use super::number::Fixed;
use super::{Note, WriteError};
use crate::types::{Leg, Motion, Station};
use std::fmt::Write;

/// Decimals of tool-axis components: an error of 5e-10 rad.
const AXIS_DECIMALS: u8 = 9;

/// Writes legs as APT/CL records in the workpiece frame, tips with `decimals` decimals.
///
/// Links are `RAPID`, everything else runs at the job's feed. The first station of a leg is the last
/// of the leg before and is written once.
///
/// # Errors
///
/// [`WriteError`].
pub fn apt(
    out: &mut impl Write,
    legs: &[Leg],
    note: &Note<'_>,
    decimals: u8,
) -> Result<(), WriteError> {
    let first = legs.first().and_then(|leg| leg.stations.first()).ok_or(WriteError::Empty)?;
    let [diameter, corner] = [2.0 * (note.tool.major + note.tool.minor), note.tool.minor];
    writeln!(out, "PARTNO {}", plain(note.name))?;
    writeln!(out, "UNITS/MM")?;
    writeln!(out, "MULTAX/ON")?;
    writeln!(out, "LOADTL/{}", note.tool.number)?;
    writeln!(out, "CUTTER/{diameter:.4},{corner:.4}")?;
    writeln!(out, "SPINDL/{:.0},RPM,CLW", note.spindle)?;
    if note.coolant {
        writeln!(out, "COOLNT/ON")?;
    }
    writeln!(out, "RAPID")?;
    goto(out, 0, first, decimals)?;
    let mut cutting = false;
    for (index, leg) in legs.iter().enumerate() {
        let link = leg.motion == Motion::Link;
        for station in leg.stations.iter().skip(1) {
            if link {
                writeln!(out, "RAPID")?;
            } else if !cutting {
                writeln!(out, "FEDRAT/{:.3},MMPM", note.feed * 60.0)?;
            }
            cutting = !link;
            goto(out, index, station, decimals)?;
        }
    }
    if note.coolant {
        writeln!(out, "COOLNT/OFF")?;
    }
    writeln!(out, "SPINDL/OFF")?;
    writeln!(out, "FINI")?;
    Ok(())
}

/// One `GOTO`.
fn goto(
    out: &mut impl Write,
    leg: usize,
    station: &Station,
    decimals: u8,
) -> Result<(), WriteError> {
    write!(out, "GOTO/")?;
    let tip = station.pose.tip.coords.iter().map(|&value| (value, decimals));
    let axis = station.pose.axis.iter().map(|&value| (value, AXIS_DECIMALS));
    for (index, (value, decimals)) in tip.chain(axis).enumerate() {
        let number = Fixed::nearest(value, decimals).ok_or(WriteError::Number {
            block: leg,
            value,
            decimals,
        })?;
        write!(out, "{}{number}", if index == 0 { "" } else { "," })?;
    }
    writeln!(out)?;
    Ok(())
}

/// A name on one line that no reader takes for a comment or a continued line.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() && c != '$' { c } else { ' ' }).collect()
}
