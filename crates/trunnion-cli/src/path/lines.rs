//! Lines of a file of any length and encoding, one in memory at a time.

use std::borrow::Cow;
use std::io::{BufRead, Read, Result};

/// Longest line \[bytes\]: a longer one is not of a text file.
const LONGEST: u64 = 1 << 20;

/// Reads lines as they stand.
pub(crate) struct Lines<R> {
    from: R,
    raw: Vec<u8>,
    /// Bytes read.
    pub(crate) bytes: u64,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(from: R) -> Self {
        Self { from, raw: Vec::new(), bytes: 0 }
    }

    /// Returns the next line with its line break; a line that is too long comes in parts.
    pub(crate) fn next(&mut self) -> Result<Option<&[u8]>> {
        self.raw.clear();
        let read = self.from.by_ref().take(LONGEST).read_until(b'\n', &mut self.raw)?;
        self.bytes += read as u64;
        Ok((read > 0).then_some(&self.raw[..]))
    }
}

/// Returns the text of a line without its line break. Letters of older encodings occur in comments and names only.
pub(crate) fn text(raw: &[u8]) -> Cow<'_, str> {
    let end = raw.strip_suffix(b"\n").unwrap_or(raw);
    let end = end.strip_suffix(b"\r").unwrap_or(end);
    // Nearly every line is plain text, for which this test is quicker than the search for broken letters.
    std::str::from_utf8(end).map_or_else(|_| String::from_utf8_lossy(end), Cow::Borrowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_their_bytes_and_lose_their_breaks() {
        let mut lines = Lines::new(&b"PARTNO Fl\xfcgel\r\nFINI"[..]);
        let first = lines.next().unwrap().unwrap().to_vec();
        assert_eq!(first, b"PARTNO Fl\xfcgel\r\n");
        assert_eq!(text(&first), "PARTNO Fl\u{fffd}gel");
        assert_eq!(lines.next().unwrap(), Some(&b"FINI"[..]));
        assert_eq!(lines.next().unwrap(), None);
        assert_eq!(lines.bytes, 19);
    }
}
