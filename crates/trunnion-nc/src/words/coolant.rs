//! Coolant that a program switches.

/// Coolant that runs.
///
/// # Example
///
/// ```
/// use trunnion_nc::words::Coolant;
///
/// let running = Coolant::Off.after("S8000 M3 M8");
/// assert_eq!(running, Coolant::Flood);
/// assert_eq!(running.after("M9"), Coolant::Off);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coolant {
    /// None.
    #[default]
    Off,
    /// `M7`.
    Mist,
    /// `M8`, or `M13` and `M14` with the spindle.
    Flood,
    /// `M7` and `M8`.
    MistAndFlood,
}

impl Coolant {
    /// Returns true unless nothing runs.
    pub fn is_on(self) -> bool {
        self != Self::Off
    }

    /// Returns true if all of the other coolant runs.
    pub fn includes(self, other: Self) -> bool {
        self == other || self == Self::MistAndFlood || other == Self::Off
    }

    /// Returns the coolant that runs behind words of a program.
    #[must_use]
    pub fn after(self, words: &str) -> Self {
        m_codes(words).fold(self, |before, code| match (code, before) {
            (7, Self::Off | Self::Mist) => Self::Mist,
            (8 | 13 | 14, Self::Off | Self::Flood) => Self::Flood,
            (7 | 8 | 13 | 14, _) => Self::MistAndFlood,
            (9, _) => Self::Off,
            _ => before,
        })
    }

    /// Returns the coolant behind the words of `COOLNT` in a CL file: `OFF`, `MIST`, or any other to start it.
    pub(crate) fn of_cl<'a>(mut words: impl Iterator<Item = &'a str>) -> Self {
        match words.next() {
            Some(word) if word.eq_ignore_ascii_case("OFF") => Self::Off,
            Some(word) if word.eq_ignore_ascii_case("MIST") => Self::Mist,
            _ => Self::Flood,
        }
    }
}

/// Returns the numbers of the M codes in a text, without those of its comments.
fn m_codes(text: &str) -> impl Iterator<Item = u32> {
    // A message may speak of a code: ( ) and the rest behind ; run nothing.
    let code = text.split(';').next().unwrap_or_default();
    let pieces = code.split('(').enumerate().map(|(index, piece)| match index {
        0 => piece,
        _ => piece.split_once(')').map_or("", |(_, behind)| behind),
    });
    pieces.flat_map(m_codes_of)
}

/// Returns the numbers of the M codes in a text without comments.
fn m_codes_of(text: &str) -> impl Iterator<Item = u32> {
    text.match_indices(['M', 'm']).filter_map(|(at, _)| {
        let (before, code) = (text.get(..at)?, text.get(at + 1..)?);
        let digits = code.len() - code.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        // A letter in front belongs to another word.
        let begins = !before.ends_with(|c: char| c.is_ascii_alphabetic());
        begins.then(|| code.get(..digits)?.parse().ok()).flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_count_and_comments_do_not() {
        let both = Coolant::Off.after("M7").after("M08");
        assert_eq!(both, Coolant::MistAndFlood);
        assert_eq!(both.after("(M9 comes later) M10 ; M9"), both);
        assert_eq!(both.after("L Z+100 M9"), Coolant::Off);
        assert_eq!(Coolant::Off.after("M13"), Coolant::Flood);
        assert_eq!(Coolant::Off.after("M88 CHAM8"), Coolant::Off);
    }
}
