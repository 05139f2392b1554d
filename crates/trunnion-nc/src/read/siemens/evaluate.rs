//! Values: numbers, `R` parameters, arithmetic, `AC(..)` and its kin.

use super::reader::SiemensReader;
use super::value::{MODES, SiemensValue, ValueMode};
use super::word::{SiemensWord, WordTail};
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::control::COMPUTED;
use crate::read::log::ReadRemark;
use crate::read::number::{self, DecimalMark};

impl SiemensReader {
    /// Returns the value of a word and its mode.
    pub(super) fn value(
        &self,
        item: &SiemensWord<'_>,
    ) -> Result<(SiemensValue, ValueMode), ReadRemark> {
        let (WordTail::Number(text) | WordTail::Assigned(text)) = item.behind else {
            let message = format!("{} without a value", item.text_name());
            return Err(ReadRemark::new(item.at, message, "write it behind ="));
        };
        if let Some(found) = number::signed(text.as_bytes(), DecimalMark::Point)
            && found.length == text.trim_end().len()
        {
            return Ok((
                SiemensValue { number: found.value, decimals: found.decimals },
                ValueMode::Plain,
            ));
        }
        // ACP and ACN stand before AC in the table, as it begins both.
        let mode = MODES.iter().find(|(name, _)| {
            let head = text.get(..name.len()).unwrap_or_default();
            let rest = text.get(name.len()..).unwrap_or_default();
            head.eq_ignore_ascii_case(name) && rest.trim_start().starts_with('(')
        });
        let skip = mode.map_or(0, |(name, _)| name.len());
        let written = FormulaText { text, from: skip, at: item.value_at, mark: DecimalMark::Point };
        let number = arithmetic::value(&written, &self.variables)?;
        // The digits in the brackets of AC(..) are those of the word.
        let inner = text.get(skip..).unwrap_or_default().trim();
        let inner = inner.strip_prefix('(').and_then(|inner| inner.strip_suffix(')'));
        let plain = inner.and_then(|inner| {
            let inner = inner.trim();
            number::signed(inner.as_bytes(), DecimalMark::Point)
                .filter(|found| found.length == inner.len())
        });
        let decimals = plain.map_or(COMPUTED, |found| found.decimals);
        Ok((SiemensValue { number, decimals }, mode.map_or(ValueMode::Plain, |(_, mode)| *mode)))
    }
}
