//! Style of a program: format, words, feed.

use super::format::OutputFormat;
use crate::machine::{FeedMode, Kinematics};
use crate::types::PoseTolerance;
use crate::words::AxisWords;

/// Style in which a program is written. No `Default`: the caller knows the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Format.
    pub dialect: OutputFormat,
    /// Letters, decimals and signs of the axes.
    pub axes: AxisWords,
    /// F is one over the time of the block, not the speed of the tip.
    pub inverse_time: bool,
    /// Step of block numbers; 0 for none where they can be left out.
    pub numbers: u32,
    /// Number of the program.
    pub program: u32,
    /// Deviation from the path that the control may use to keep its speed.
    pub blend: Option<PoseTolerance>,
}

impl Style {
    /// Returns the style that a machine file requests.
    ///
    /// Further strings of `[dialect]` are taken in: `numbers` (step of block numbers), `program` (its number),
    /// `tcp_on` and `tcp_off`.
    pub fn of(kinematics: &Kinematics, dialect: OutputFormat, axes: AxisWords) -> Self {
        let machine = kinematics.machine();
        let requested = &machine.dialect;
        // The machine file describes its own control; another format has its own defaults.
        let own = OutputFormat::from_name(&requested.name) == Some(dialect);
        let inverse_time =
            if own { requested.feed == FeedMode::InverseTime } else { dialect.by_time() };
        let number =
            |key: &str| requested.strings.get(key).and_then(|text| text.trim().parse().ok());
        Self {
            dialect,
            axes,
            inverse_time: inverse_time || dialect == OutputFormat::G93,
            numbers: number("numbers").unwrap_or(0),
            program: number("program").unwrap_or(1),
            blend: None,
        }
    }
}
