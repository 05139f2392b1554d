//! Blocks as G-code in inverse time.

use super::number::Fixed;
use super::{Note, ProgramOptions, Remark, WriteError, comment, work_offset};
use crate::machine::{Kinematics, RetractFrame};
use crate::types::{AXES, AxisVector, Block, Motion};
use nalgebra::Vector3;
use std::fmt::Write;

/// Writes a program for `LinuxCNC` with TCP kinematics: X Y Z are the tip in the table frame.
///
/// Inverse time on every move, so that the plan's time is kept whatever the axes do. `M428` and
/// `M429` switch TCP on and off, as `LinuxCNC`'s trunnion configurations name it. A block whose words
/// all round to those before it is left out, and its time is added to the next.
///
/// # Errors
///
/// [`WriteError`].
pub fn linuxcnc(
    out: &mut impl Write,
    kinematics: &Kinematics,
    blocks: &[Block],
    note: &Note<'_>,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    let turn = kinematics.setup().rotation;
    let words = |block: &Block| {
        let tip = turn * block.pose.tip.coords;
        AxisVector::new(tip.x, tip.y, tip.z, block.q[3], block.q[4])
    };
    let (first, rest) = blocks.split_first().ok_or(WriteError::Empty)?;
    writeln!(
        out,
        "(X Y Z: tool tip in the table frame, mm; rotaries in degrees; TCP on with M428)"
    )?;
    header(out, kinematics, note, options)?;
    writeln!(out, "M429")?;
    start(out, kinematics, note, options)?;
    let mut writer = Writer::new(out, options);
    writer.rapid(&words(first), &[3, 4])?;
    writeln!(writer.out, "M428")?;
    writer.rapid(&words(first), &[0, 1, 2])?;
    writer.cuts(rest, note.remarks, words)?;
    writeln!(out, "G94")?;
    writeln!(out, "M429")?;
    finish(out, kinematics, note, options)
}

/// Writes a program for any control without TCP: X Y Z are axis positions less the work offset and,
/// along Z, less the tool length. All axes are linear in a block, so the blocks have to be fine
/// enough for that. Otherwise as [`linuxcnc`].
///
/// # Errors
///
/// [`WriteError`].
pub fn g93(
    out: &mut impl Write,
    kinematics: &Kinematics,
    blocks: &[Block],
    note: &Note<'_>,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?;
    let shift = offset + Vector3::z() * kinematics.setup().tool_length;
    let words = |block: &Block| block.q - AxisVector::new(shift.x, shift.y, shift.z, 0.0, 0.0);
    let (first, rest) = blocks.split_first().ok_or(WriteError::Empty)?;
    writeln!(
        out,
        "(X Y Z: axis positions less work offset and tool length, mm; rotaries in degrees; no TCP)"
    )?;
    header(out, kinematics, note, options)?;
    start(out, kinematics, note, options)?;
    let mut writer = Writer::new(out, options);
    writer.rapid(&words(first), &[3, 4])?;
    writer.rapid(&words(first), &[0, 1, 2])?;
    writer.cuts(rest, note.remarks, words)?;
    writeln!(out, "G94")?;
    finish(out, kinematics, note, options)
}

/// Comments that say what the program assumes, and the modes it relies on.
fn header(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?;
    for line in super::sheet::facts(kinematics, note, options.axes) {
        writeln!(out, "({})", comment(&line))?;
    }
    let [x, y, z] = offset.into();
    writeln!(out, "(G54 must hold X {x:.4} Y {y:.4} Z {z:.4}; details in setup.txt)")?;
    writeln!(out, "G21 G90 G17 G40 G80 G54 G94")?;
    match options.blend {
        Some(blend) => writeln!(out, "G64 P{blend:.6} Q{blend:.6}")?,
        None => writeln!(out, "G61")?,
    }
    Ok(())
}

/// Retracts, takes the tool, starts the spindle.
fn start(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    let number = note.tool.number;
    retract(out, kinematics, options)?;
    writeln!(out, "T{number} M6")?;
    writeln!(out, "S{:.0} M3", note.spindle)?;
    if note.coolant {
        writeln!(out, "M8")?;
    }
    writeln!(out, "G43 H{number}")?;
    Ok(())
}

/// Retracts, stops the spindle, ends the program.
fn finish(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    retract(out, kinematics, options)?;
    if note.coolant {
        writeln!(out, "M9")?;
    }
    writeln!(out, "M5")?;
    writeln!(out, "M2")?;
    Ok(())
}

/// The machine's own way out, where it is an axis position.
fn retract(
    out: &mut impl Write,
    kinematics: &Kinematics,
    options: &ProgramOptions,
) -> Result<(), WriteError> {
    let retract = &kinematics.machine().retract;
    let index = kinematics.machine().index_of(&retract.axis);
    let word = index.and_then(|index| options.axes.0.get(index));
    if let (RetractFrame::Machine, Some(word)) = (retract.frame, word) {
        let (value, decimals) = (word.written(retract.to), word.decimals);
        let to = Fixed::nearest(value, decimals).ok_or(WriteError::Number {
            block: 0,
            value,
            decimals,
        })?;
        writeln!(out, "G53 G0 {}{to}", word.letter)?;
    }
    Ok(())
}

/// Writes positions, each word only when it changes.
struct Writer<'a, W> {
    out: &'a mut W,
    options: &'a ProgramOptions,
    last: [Option<Fixed>; AXES],
}

impl<'a, W: Write> Writer<'a, W> {
    fn new(out: &'a mut W, options: &'a ProgramOptions) -> Self {
        Self { out, options, last: [None; AXES] }
    }

    /// Rounds the words of a block.
    fn rounded(&self, index: usize, words: &AxisVector) -> Result<[Fixed; AXES], WriteError> {
        let mut rounded = [Fixed::nearest(0.0, 0).ok_or(WriteError::Empty)?; AXES];
        for ((place, word), &value) in
            rounded.iter_mut().zip(&self.options.axes.0).zip(words.iter())
        {
            let (value, decimals) = (word.written(value), word.decimals);
            *place = Fixed::nearest(value, decimals).ok_or(WriteError::Number {
                block: index,
                value,
                decimals,
            })?;
        }
        Ok(rounded)
    }

    /// Appends the words that differ from the last written ones.
    fn changes(&mut self, rounded: &[Fixed; AXES], axes: &[usize]) -> Result<(), WriteError> {
        for &axis in axes {
            let parts = (self.last.get_mut(axis), rounded.get(axis), self.options.axes.0.get(axis));
            if let (Some(last), Some(&now), Some(word)) = parts
                && *last != Some(now)
            {
                write!(self.out, " {}{now}", word.letter)?;
                *last = Some(now);
            }
        }
        Ok(())
    }

    /// `G0` of some axes to the starting position.
    fn rapid(&mut self, words: &AxisVector, axes: &[usize]) -> Result<(), WriteError> {
        let rounded = self.rounded(0, words)?;
        write!(self.out, "G0")?;
        self.changes(&rounded, axes)?;
        writeln!(self.out)?;
        Ok(())
    }

    /// All blocks after the first.
    fn cuts(
        &mut self,
        blocks: &[Block],
        remarks: &[Remark],
        words: impl Fn(&Block) -> AxisVector,
    ) -> Result<(), WriteError> {
        writeln!(self.out, "G93")?;
        let mut motion = None;
        let mut pass = 0;
        let mut waiting = 0.0;
        let mut remarks = remarks.iter().peekable();
        let mut interrupted = false;
        for (index, block) in blocks.iter().enumerate() {
            let index = index + 1;
            while let Some(remark) = remarks.next_if(|remark| remark.block <= index) {
                writeln!(self.out, "({})", comment(&remark.text))?;
                interrupted = motion == Some(Motion::Cut);
            }
            if motion != Some(block.motion) && block.motion == Motion::Cut {
                pass += u32::from(!interrupted);
                let again = if interrupted { " goes on" } else { "" };
                writeln!(self.out, "(pass {pass}{again})")?;
                interrupted = false;
            }
            motion = Some(block.motion);
            let rounded = self.rounded(index, &words(block))?;
            let duration = block.duration + waiting;
            if rounded.iter().zip(&self.last).all(|(now, last)| Some(*now) == *last) {
                waiting = duration;
                continue;
            }
            waiting = 0.0;
            let feed = self.feed(index, duration)?;
            write!(self.out, "G1")?;
            self.changes(&rounded, &[0, 1, 2, 3, 4])?;
            writeln!(self.out, " F{feed}")?;
        }
        Ok(())
    }

    /// Inverse-time feed word, rounded down: never faster than planned.
    fn feed(&self, block: usize, duration: f64) -> Result<Fixed, WriteError> {
        let failed = WriteError::Duration { block, duration };
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(failed);
        }
        let feed = Fixed::down(60.0 / duration, self.options.feed_decimals);
        feed.filter(|feed| !feed.is_zero()).ok_or(failed)
    }
}
