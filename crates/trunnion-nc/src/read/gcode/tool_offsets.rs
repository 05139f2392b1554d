//! Tool offsets that a program writes: `G10 L1`, `L10`, `L11`, `G43.1`, `G43.2`.

use super::block::GcodeBlock;
use super::reader::GcodeReader;
use super::words::natural;
use crate::read::control::{ControlState, MoveTarget};
use crate::read::log::ReadRemark;
use crate::read::positions::rotate;
use crate::read::remedy::unknown_tool;
use crate::read::state::ReaderState;

/// `G10 L1`, `G10 L10` or `G10 L11` on a line.
pub(super) struct TableCode {
    /// 1, 10 or 11.
    pub(super) table: u32,
    /// Byte offset of the code.
    pub(super) at: usize,
}

/// Work offset from which `G10 L11` counts: that of a fixture, `G59.3`.
const FIXTURE: u8 = 8;

impl GcodeReader {
    /// Runs `G10 L1 P Z R` and its kin: a row of the tool table, which counts from the next `G43` on.
    pub(super) fn write_tool(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: &TableCode,
    ) -> Result<(), ReadRemark> {
        let TableCode { table, at } = *code;
        let number = block.take('P').map_or(Ok(0), |word| natural(word, 'P'))?;
        let target = self.target(state, block, text)?;
        let scale = state.control.scale();
        let radius = block.take('R').map(|word| scale * word.value);
        // Angles and orientation of a turning tool change no word of a program.
        let _angles = ["I", "J", "Q"].map(|letter| letter.chars().find_map(|c| block.take(c)));
        if state.control.tool_table.get(number).is_none() {
            return Err(unknown_tool(
                at,
                format!("G10 L{table} P{number}: a tool that is not in the tool table"),
            ));
        }
        let mut values = [None; 3];
        for (value, slot) in values.iter_mut().zip(state.control.xyz) {
            *value = target.get(slot);
        }
        if table != 1 && values.iter().any(Option::is_some) {
            let before = state.control.tool_table.get(number).map(|row| row.offset);
            values = measured(&state.control, &target, code)?;
            if let (10, true, Some(before)) = (table, state.control.turn().abs() > 0.0, before) {
                let [x, y] = turned_offset(&state.control, &target, [before[0], before[1]], code)?;
                (values[0], values[1]) = (Some(x), Some(y));
            }
        }
        if let Some(row) = state.control.tool_table.row(number) {
            for (offset, value) in row.offset.iter_mut().zip(values) {
                *offset = value.unwrap_or(*offset);
            }
            row.diameter = radius.map_or(row.diameter, |radius| 2.0 * radius);
        }
        Ok(())
    }
}

/// Returns the offsets with which the present position reads as the words.
fn measured(
    control: &ControlState,
    target: &MoveTarget,
    code: &TableCode,
) -> Result<[Option<f64>; 3], ReadRemark> {
    let active = applied_offset(control);
    let mut values = [None; 3];
    for (index, slot) in control.xyz.into_iter().enumerate() {
        let Some(value) = target.get(slot) else { continue };
        // L10: in the active work offset with its shifts; L11: in that of the fixture. A turned offset mixes X and Y only.
        let turned = |angle: f64| angle.abs() > 0.0 && control.turned_axis(slot).is_some();
        if code.table == 10 && turned(control.turn()) {
            continue;
        }
        let fixture_turn = control.written_offsets.turn(FIXTURE);
        if code.table == 11 && !turned(fixture_turn) {
            // Where the axis stands, less the fixture: no other offset takes part, nor does a tool length in force.
            let stands = control.machine.get(slot).copied().flatten();
            let fixture = control.written_offsets.origin(FIXTURE, slot);
            if let Some((stands, fixture)) = stands.zip(fixture) {
                values[index] = Some(stands - fixture - value);
                continue;
            }
        }
        let reads = if code.table == 10 {
            control.reading(slot)
        } else if code.table == 11 && !turned(control.turn()) && !turned(fixture_turn) {
            let of = |offset| control.written_offsets.origin(offset, slot);
            let between = of(control.offset).zip(of(FIXTURE)).map(|(from, to)| from - to);
            let stands = control.stands(slot).map(|stands| stands - control.tool_offset(slot));
            stands.zip(between).map(|(stands, between)| stands + between)
        } else {
            None
        };
        let Some((reads, active)) = reads.zip(active) else {
            return Err(unstated(code));
        };
        values[index] = Some(reads + active[index] - value);
    }
    Ok(values)
}

/// Returns X and Y of the tool offset of `G10 L10` in a turned work offset.
///
/// The offset is reckoned in the turned coordinates, where an axis without a word keeps that of `before`.
fn turned_offset(
    control: &ControlState,
    target: &MoveTarget,
    before: [f64; 2],
    code: &TableCode,
) -> Result<[f64; 2], ReadRemark> {
    let [x, y, _] = control.xyz;
    let stands = control.stands(x).zip(control.stands(y)).ok_or_else(|| unstated(code))?;
    let here = rotate([stands.0, stands.1], -control.turn());
    let kept = rotate(before, -control.turn());
    let offset = [(x, here[0], kept[0]), (y, here[1], kept[1])].map(|(slot, here, kept)| {
        target.get(slot).map_or(kept, |word| here - control.shift(slot) - word)
    });
    Ok(rotate(offset, control.turn()))
}

/// Fault of a measured offset whose position is not known.
fn unstated(code: &TableCode) -> ReadRemark {
    let message = format!("G10 L{} at a position that the program does not state", code.table);
    let help = "program the axis absolutely and write the work offsets before, or use G10 L1";
    ReadRemark::new(code.at, message, help)
}

/// Applies the tool offset of `G43 H`, `G43.1` or `G43.2` beside the length of the tool in the spindle.
pub(super) fn shift_tool(state: &mut ReaderState, offset: &ToolOffset) -> Result<(), ReadRemark> {
    let control = &mut state.control;
    let spindle = control.tools.last().copied().unwrap_or(control.tool);
    let row = |number: u32| control.tool_table.get(number);
    match *offset {
        ToolOffset::Of { number, at } => {
            let number = number.unwrap_or(spindle);
            let shift = match row(number).zip(row(spindle)) {
                // The length of the tool in the spindle is added by whoever runs the steps.
                Some((tool, own)) => {
                    let [x, y, z] = tool.offset;
                    [x, y, z - own.length]
                }
                None => [0.0; 3],
            };
            // Without a tool change the tool in the spindle is not known, and none contradicts.
            let changed = !control.tools.is_empty();
            let missing = changed && number != spindle && row(number).is_none();
            control.set_tool_shift(shift);
            control.enable_length();
            if let (true, Some(at)) = (missing, at) {
                let message = format!("H{number} with tool {spindle} in the spindle");
                let help = "the length of the tool is taken, as if its number stood there";
                state.log.warn("", ReadRemark::new(at, message, help));
            }
        }
        ToolOffset::Given { values } => {
            let mut shift = control.xyz.map(|slot| control.tool_offset(slot));
            for (shift, value) in shift.iter_mut().zip(values) {
                *shift = value.unwrap_or(*shift);
            }
            // A length that the words replace no longer counts.
            if values[2].is_some() {
                control.disable_length();
            }
            control.set_tool_shift(shift);
        }
        ToolOffset::Added { number, values, at } => {
            let more = match number {
                Some(number) => {
                    let missing = || {
                        unknown_tool(
                            at,
                            format!("G43.2 H{number}: a tool that is not in the tool table"),
                        )
                    };
                    row(number).ok_or_else(missing)?.offset
                }
                None => values.map(|value| value.unwrap_or(0.0)),
            };
            let mut shift = control.xyz.map(|slot| control.tool_offset(slot));
            for (shift, more) in shift.iter_mut().zip(more) {
                *shift += more;
            }
            control.set_tool_shift(shift);
        }
    }
    Ok(())
}

/// A tool offset as a line has it.
#[derive(Debug, Clone, Copy)]
pub(super) enum ToolOffset {
    /// `G43`, `G43 H`: that of a tool; where the H word stands.
    Of { number: Option<u32>, at: Option<usize> },
    /// `G43.1 X Y Z`: these values.
    Given { values: [Option<f64>; 3] },
    /// `G43.2 H` or `G43.2 X Y Z`: added to what counts.
    Added { number: Option<u32>, values: [Option<f64>; 3], at: usize },
}

/// Returns the offset that counts now, if the length of the tool is known.
fn applied_offset(control: &ControlState) -> Option<[f64; 3]> {
    let spindle = control.tools.last().copied().unwrap_or(control.tool);
    let length = if control.length { control.tool_table.get(spindle)?.length } else { 0.0 };
    let [x, y, z] = control.xyz.map(|slot| control.tool_offset(slot));
    Some([x, y, z + length])
}
