//! G codes of Fanuc and Haas that `LinuxCNC` does not have, or has another meaning for.

use super::block::{CodeWord, GcodeBlock};
use super::modal::{BlockActions, PolarPlace, group};
use super::reader::GcodeReader;
use super::words::keep_with;
use crate::read::dialect::Dialect;
use crate::read::state::ReaderState;

impl GcodeReader {
    /// Applies such a code and returns its group; `None`: it is another one.
    pub(super) fn code_of_others(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: CodeWord,
        now: &mut BlockActions,
    ) -> Option<u32> {
        Some(match code.tenths {
            // Turned, mirrored and polar words of Fanuc and Haas.
            700 | 710 if self.dialect == Dialect::Haas => {
                now.nonmodal = Some((code.tenths, code.at));
                group::NONMODAL
            }
            680 | 510 | 511 | 501 | 1000 | 1010 => {
                now.nonmodal = Some((code.tenths, code.at));
                group::NONMODAL
            }
            150 | 160 => {
                self.modal.polar = (code.tenths == 160).then(PolarPlace::default);
                group::POLAR
            }
            1100..=1290 if self.dialect == Dialect::Haas && code.tenths.is_multiple_of(10) => {
                // G110 is G154 P1 and so on.
                let offset = (code.tenths - 1100) / 10 + 9;
                state.control.set_offset(u8::try_from(offset).unwrap_or(u8::MAX));
                group::OFFSET
            }
            // High speed machining, corner override, tapping mode; the axis words of G22 are limits.
            50 | 220 | 230 | 620 | 630 => {
                let limits = code.tenths == 220;
                keep_with(state, block, text, code, if limits { "PQRXYZIJK" } else { "PQR" });
                group::NONE
            }
            _ => return None,
        })
    }
}
