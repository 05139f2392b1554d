//! M codes.

use super::block::{CodeWord, GcodeBlock};
use super::modal::{BlockActions, group};
use super::reader::GcodeReader;
use super::words::{keep_with, natural, not_understood};
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
impl GcodeReader {
    /// Applies an M code and returns its group.
    pub(super) fn m_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
        now: &mut BlockActions,
    ) -> Result<u32, ReadRemark> {
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        Ok(match code.tenths {
            // M0, M1 and M60 stop behind the motion of their line.
            0 | 10 | 600 => {
                if let Some(free) = now.stops.iter_mut().find(|stop| stop.is_none()) {
                    *free = Some((code.at, code.end));
                }
                group::STOP
            }
            // M2 and M30 take effect when the line is over.
            20 | 300 => {
                now.ends = true;
                group::STOP
            }
            // M3 clockwise, M4 counterclockwise, M5 stop.
            30 | 40 | 50 => {
                state.control.sense = i8::from(code.tenths == 30) - i8::from(code.tenths == 40);
                now.turns_spindle = true;
                group::SPINDLE
            }
            60 => {
                now.changes_tool = true;
                group::TOOL
            }
            610 if linuxcnc => {
                state.control.tool = declared_tool(block, code)?;
                now.changes_tool = true;
                group::TOOL
            }
            970 if self.dialect == Dialect::Haas => {
                now.calls_locally = true;
                call_numbered(block, code, now)?
            }
            980 => call_numbered(block, code, now)?,
            990 => {
                now.return_to = self.return_line(block, code)?;
                now.returns = true;
                group::NONE
            }
            // Remappings of the trunnion configurations that come with LinuxCNC: M428 TCP, M429
            // identity kinematics.
            4280 | 4290 if linuxcnc => {
                if code.tenths == 4280 {
                    state.control.enable_tcp();
                } else {
                    state.control.disable_tcp();
                }
                group::TCP
            }
            700 | 710 | 720 | 730 if linuxcnc => {
                self.saved_code(state, code.tenths, code.at)?;
                group::NONE
            }
            _ => self.kept_code(state, block, text, code)?,
        })
    }

    /// Returns the line of the caller at which a program goes on behind `M99 P10`, and the column of the code.
    fn return_line(
        &self,
        block: &mut GcodeBlock,
        code: CodeWord,
    ) -> Result<Option<(f64, usize)>, ReadRemark> {
        let Some(line) = block.take('P') else { return Ok(None) };
        if self.dialect == Dialect::LinuxCnc {
            return Err(ReadRemark::new(code.at, "M99 P: a jump", "return without P"));
        }
        Ok(Some((line.value, code.at)))
    }

    /// Keeps M codes without motion as they stand.
    fn kept_code(
        &self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
    ) -> Result<u32, ReadRemark> {
        let what = text.get(code.at..code.end).unwrap_or_default();
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        match code.tenths {
            // M50 to M53 of LinuxCNC: P switches the override on or off.
            500 | 510 | 520 | 530 if linuxcnc => {
                keep_with(state, block, text, code, "P");
                return Ok(group::NONE);
            }
            // Coolant, override switches and the like.
            70 | 80 | 90 | 480 | 490 | 500 | 510 | 520 | 530 => {}
            // Rigid tapping, chip conveyor, coolant and clamps as posts of these controls write them.
            290 | 100 | 110 | 310 | 330 | 830 | 840 | 880 | 890
                if !linuxcnc && code.tenths.is_multiple_of(10) =>
            {
                keep_with(state, block, text, code, "PQS");
                return Ok(group::NONE);
            }
            190 | 620..=680 => {
                keep_with(state, block, text, code, "EDLPQR");
                return Ok(group::NONE);
            }
            // What a control does with these decides what later words mean.
            650..=739 | 960 | 970 | 1980 => return Err(not_understood(code, text, self.dialect)),
            tenths if linuxcnc && tenths >= 2000 => {
                return Err(not_understood(code, text, self.dialect));
            }
            tenths if tenths % 10 != 0 => return Err(not_understood(code, text, self.dialect)),
            _ => {
                let message = format!("{what} is not known: it is kept, and taken to move nothing");
                state.log.warn(text, ReadRemark::new(code.at, message, ""));
                keep_with(state, block, text, code, "PQ");
                return Ok(group::NONE);
            }
        }
        state.control.keep(state.log.line, what);
        Ok(group::NONE)
    }
}

/// Returns the tool that `M61 Q2` declares to be in the spindle, without a change.
fn declared_tool(block: &mut GcodeBlock, code: CodeWord) -> Result<u32, ReadRemark> {
    let number = block.take('Q');
    let number = number
        .ok_or_else(|| ReadRemark::new(code.at, "M61 without a tool", "write Q and its number"))?;
    natural(number, 'Q')
}

/// Reads `M98 P1000 L3`.
fn call_numbered(
    block: &mut GcodeBlock,
    code: CodeWord,
    now: &mut BlockActions,
) -> Result<u32, ReadRemark> {
    let Some(number) = block.take('P') else {
        return Err(ReadRemark::new(code.at, "M98 or M97 without P", "name the subprogram"));
    };
    let number = natural(number, 'P')?;
    // Repetitions: L at Haas and in LinuxCNC, K on some controls.
    let times = block.take('L').or_else(|| block.take('K'));
    let (number, times) = match times {
        Some(times) => (number, natural(times, 'L')?),
        // P30100: three times O100.
        None if number > 9999 && !now.calls_locally => (number % 10_000, number / 10_000),
        None => (number, 1),
    };
    if times > 0 {
        now.call = Some((number.to_string().into(), times, code.at));
    }
    Ok(group::NONE)
}
