//! Work offsets as arguments.

use crate::option_values::three;
use nalgebra::Vector3;
use trunnion::verify::WorkOffset;

/// Work offset of the command line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WorkOffsetArgument {
    /// Number as the readers count: 0 for `G54`.
    number: u8,
    /// Origin X, Y, Z \[mm\]; `None` for that of `G54`.
    origin: Option<[f64; 3]>,
}

impl WorkOffsetArgument {
    /// Returns the offset on a control whose `G54` is at `g54` \[mm\].
    pub(super) fn offset(&self, g54: Vector3<f64>) -> WorkOffset {
        WorkOffset { number: self.number, origin: self.origin.map_or(g54, Vector3::from) }
    }
}

/// Reads `G55=X,Y,Z` or `G55=G54`.
pub(super) fn read(text: &str) -> Result<WorkOffsetArgument, String> {
    let expected = "write an offset and its origin, such as G55=-381,-204,-505 or G55=G54";
    let (name, origin) = text.split_once('=').ok_or(expected)?;
    let number = number(&name.trim().to_ascii_uppercase()).ok_or(
        "G54 to G59, G59.1 to G59.3, G54.1P1 and on, G505 and on, or a preset number is expected",
    )?;
    let origin =
        if origin.trim().eq_ignore_ascii_case("G54") { None } else { Some(three(origin)?) };
    Ok(WorkOffsetArgument { number, origin })
}

/// Returns the number of an offset as the readers count: 0 for `G54`.
fn number(name: &str) -> Option<u8> {
    let Some(code) = name.strip_prefix('G') else {
        let preset: u8 = name.parse().ok()?;
        // Presets of Heidenhain count from 1.
        return preset.checked_sub(1);
    };
    if let Some(extended) = code.strip_prefix("54.1P") {
        return extended.trim().parse().ok().filter(|n| (1..=240).contains(n)).map(|n: u8| n + 8);
    }
    if let Some(further) = code.strip_prefix("59.") {
        return further.parse().ok().filter(|n| (1..=3).contains(n)).map(|n: u8| n + 5);
    }
    // Siemens continues G54..G57 with G505: both name entries of one table.
    match code.parse::<u16>().ok()? {
        code @ 54..=59 => u8::try_from(code - 54).ok(),
        code @ 505..=599 => u8::try_from(code - 501).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_named_as_in_programs() {
        let numbers = ["G54", "G59", "G59.3", "G54.1P1", "G505", "3"].map(number);
        assert_eq!(numbers, [Some(0), Some(5), Some(8), Some(9), Some(4), Some(2)]);
        for wrong in ["G53", "G60", "G59.4", "G54.1P0", "0", "X"] {
            assert_eq!(number(wrong), None, "{wrong}");
        }
        assert_eq!(read("G55=G54"), Ok(WorkOffsetArgument { number: 1, origin: None }));
        assert_eq!(
            read("g55=1,-2,3"),
            Ok(WorkOffsetArgument { number: 1, origin: Some([1.0, -2.0, 3.0]) })
        );
        assert!(read("G55=1,2").is_err() && read("G55").is_err());
    }
}
