//! Tools by the numbers that a program calls them.

/// A tool number, and the length of that tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberedLength {
    /// Number that the program calls.
    pub number: u32,
    /// Tool length, from tip to gauge point \[mm\].
    pub length: f64,
}

/// Returns the position of a tool number in a table; a table without numbers has one tool for all of them.
pub fn position_of(numbers: &[u32], number: u32) -> Option<usize> {
    if numbers.is_empty() {
        return Some(0);
    }
    numbers.iter().position(|known| *known == number)
}
