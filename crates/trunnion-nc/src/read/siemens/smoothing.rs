//! Smoothing: `CYCLE832(0.01)`, `CTOL=0.02`, `ADIS=0.05`.

use super::codes;
use super::reader::SiemensReader;
use super::word::{SiemensWord, WordTail};
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::log::ReadRemark;
use crate::read::number::DecimalMark;
use crate::read::step::Smoothing;

impl SiemensReader {
    /// Returns the distance from the path that a word allows; `None` if it is about something else.
    pub(super) fn smoothing(
        &self,
        item: &SiemensWord<'_>,
        name: &str,
    ) -> Result<Option<Smoothing>, ReadRemark> {
        let text = match (name, item.behind) {
            // The tolerance is the first argument; without one the cycle gives the machine its own setting back.
            ("CYCLE832", _) => codes::arguments(item).split(',').next().unwrap_or_default(),
            ("CTOL" | "ADIS", WordTail::Assigned(text)) => text,
            _ => return Ok(None),
        };
        if text.trim().is_empty() {
            return Ok(Some(Smoothing::OfMachine));
        }
        let written = FormulaText { text, from: 0, at: item.value_at, mark: DecimalMark::Point };
        let tolerance = arithmetic::value(&written, &self.variables)?;
        // Zero switches the cycle off, and a negative CTOL returns to the machine's setting.
        Ok(Some(if tolerance > 0.0 { Smoothing::Within(tolerance) } else { Smoothing::OfMachine }))
    }
}
