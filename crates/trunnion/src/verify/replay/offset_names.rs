//! Names of work offsets.

use crate::nc::control::NO_OFFSET;

/// Returns the name of a work offset: `G54`, or what each family of controls calls an extended one.
///
/// # Example
///
/// ```
/// use trunnion::verify::{offset_name, offset_short_name};
///
/// assert_eq!(offset_name(1), "G55");
/// assert_eq!(offset_name(9), "G54.1 P1 (Siemens G510, Heidenhain preset 10)");
/// assert_eq!(offset_short_name(9), "G54.1P1");
/// ```
pub fn offset_name(number: u8) -> String {
    match number {
        0..=5 => format!("G{}", 54 + number),
        6..=8 => format!("G59.{}", number - 5),
        NO_OFFSET => "G500".to_owned(),
        _ => format!(
            "G54.1 P{0} (Siemens G{1}, Heidenhain preset {2})",
            number - 8,
            501 + u16::from(number),
            u16::from(number) + 1
        ),
    }
}

/// Returns the name of a work offset in one word: `G55`, `G54.1P1`.
pub fn offset_short_name(number: u8) -> String {
    match number {
        0..=8 | NO_OFFSET => offset_name(number),
        _ => format!("G54.1P{}", number - 8),
    }
}
