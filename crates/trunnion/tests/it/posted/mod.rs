//! Programs of blocks, and what is done to their lines to plant faults: shared by tests and benches.

#![allow(dead_code, reason = "every test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]

use trunnion::machine::Kinematics;
use trunnion::nc::write::{
    self, AxisWords, Coolant, Note, OutputFormat, Style, Template, ToolNote, WriteError,
};
use trunnion::types::Block;

/// What a program says of a job that has nothing to say.
pub(crate) const NOTE: Note<'static> = Note {
    name: "test",
    tool: ToolNote { number: 1, major: 0.0, minor: 6.0 },
    spindle: 1.0,
    coolant: Coolant::Off,
    feed: 1.0,
    budget: &[],
    duration: 0.0,
    remarks: &[],
};

/// Every block in inverse time, the path kept exactly.
pub(crate) fn style(dialect: OutputFormat, axes: AxisWords) -> Style {
    Style { dialect, axes, inverse_time: true, numbers: 0, program: 1, blend: None }
}

/// Blocks as text.
pub(crate) fn text(
    kinematics: &Kinematics,
    blocks: &[Block],
    (note, style): (&Note<'_>, &Style),
) -> Result<String, WriteError> {
    let mut text = String::new();
    let template = Template::of(style.dialect)?;
    let form = write::ProgramForm { note, style, template: &template, changes: &[] };
    write::program(&mut text, kinematics, blocks, form)?;
    Ok(text)
}

/// Blocks as text, with tip and angles or with axis positions.
pub(crate) fn plain(
    kinematics: &Kinematics,
    blocks: &[Block],
    (axes, tcp): (AxisWords, bool),
) -> String {
    let dialect = if tcp { OutputFormat::LinuxCnc } else { OutputFormat::G93 };
    text(kinematics, blocks, (&NOTE, &style(dialect, axes))).unwrap()
}

/// The text with one line changed; lines are counted from 1.
pub(crate) fn with_line(text: &str, number: u32, line: &str) -> String {
    let new = |(index, old)| if index + 1 == number as usize { line } else { old };
    text.lines().enumerate().map(new).collect::<Vec<_>>().join("\n")
}

/// A line with one word passed through `change`.
pub(crate) fn reworded(line: &str, letter: char, change: impl Fn(f64) -> f64) -> String {
    let word = |word: &str| match word.strip_prefix(letter) {
        Some(value) => format!("{letter}{:.6}", change(value.parse::<f64>().unwrap())),
        None => word.to_owned(),
    };
    line.split(' ').map(word).collect::<Vec<_>>().join(" ")
}
