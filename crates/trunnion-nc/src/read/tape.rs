//! Lines that may be run again: what jumps, loops and calls within a program lead to.

use super::log::ReadRemark;
use std::collections::VecDeque;
use std::sync::Arc;

/// Most text that is kept \[bytes\]; a jump to a line before it is a fault.
const MOST: usize = 1 << 26;

/// Lines of a program from the first that may be run again on.
#[derive(Debug)]
pub(super) struct Tape {
    kept: VecDeque<Arc<str>>,
    bytes: usize,
    /// Number of the first kept line.
    first: u32,
    /// Number of the kept line to run next; `None`: the next of the file.
    next: Option<u32>,
    keeping: bool,
    /// Lines that may still be run again or passed over.
    left: u64,
    most: u64,
}

impl Tape {
    /// Starts a tape; `most` lines may be run again, or searched for one to run.
    pub(super) fn new(most: u64) -> Self {
        Self {
            kept: VecDeque::new(),
            bytes: 0,
            first: 1,
            next: None,
            keeping: false,
            left: most,
            most,
        }
    }

    /// Returns true if kept lines come before the next of the file.
    #[inline]
    pub(super) fn is_busy(&self) -> bool {
        self.next.is_some()
    }

    /// Takes in the next line of the file.
    #[inline]
    pub(super) fn record(&mut self, number: u32, text: &str) {
        // Lines are kept from the first on that something may lead back to.
        if self.keeping && number == self.end() {
            return self.push(text);
        }
        // Lines of loops that run elsewhere leave a gap, over which nothing jumps.
        self.kept.clear();
        (self.bytes, self.first) = (0, number);
        if self.keeping {
            self.push(text);
        }
    }

    fn push(&mut self, text: &str) {
        // The oldest lines are dropped: memory stays bounded however long the program is.
        self.bytes += text.len();
        self.kept.push_back(text.into());
        while self.bytes > MOST
            && let Some(oldest) = self.kept.pop_front()
        {
            self.bytes -= oldest.len();
            self.first = self.first.saturating_add(1);
        }
    }

    /// Keeps lines from this one on, which was recorded last.
    #[inline]
    pub(super) fn keep(&mut self, text: &str) {
        if !self.keeping {
            self.keeping = true;
            self.push(text);
        }
    }

    fn end(&self) -> u32 {
        self.first.saturating_add(u32::try_from(self.kept.len()).unwrap_or(u32::MAX))
    }

    /// Returns the next kept line and its number.
    ///
    /// # Errors
    ///
    /// More lines were run again than are allowed.
    pub(super) fn play(&mut self) -> Result<Option<(u32, Arc<str>)>, ReadRemark> {
        let Some(number) = self.next else { return Ok(None) };
        // Every line that runs again counts, so that an endless loop ends with a fault.
        self.count(1)?;
        let line = self.line(number).map(|text| (number, text));
        self.go_to(number.saturating_add(1));
        Ok(line)
    }

    /// Goes on at a line: a kept one, or the one behind them.
    pub(super) fn go_to(&mut self, line: u32) {
        self.next = (self.first..self.end()).contains(&line).then_some(line);
    }

    /// Returns a kept line.
    pub(super) fn line(&self, number: u32) -> Option<Arc<str>> {
        let at = usize::try_from(number.checked_sub(self.first)?).ok()?;
        self.kept.get(at).map(Arc::clone)
    }

    /// Finds the last kept line before `before` that fits.
    ///
    /// # Errors
    ///
    /// More lines were passed over than are allowed.
    pub(super) fn back(
        &mut self,
        before: u32,
        is: impl Fn(&str) -> bool,
    ) -> Result<Option<u32>, ReadRemark> {
        let count = usize::try_from(before.saturating_sub(self.first)).unwrap_or(usize::MAX);
        // Of several such lines the nearest before the jump is taken.
        let found = self.kept.iter().take(count).rposition(|text| is(text));
        // Lines that are only searched count as well: a loop could search without end.
        self.count(count.saturating_sub(found.unwrap_or(0)))?;
        Ok(found.and_then(|at| u32::try_from(at).ok()).map(|at| self.first + at))
    }

    fn count(&mut self, lines: usize) -> Result<(), ReadRemark> {
        let lines = u64::try_from(lines).unwrap_or(u64::MAX);
        let Some(left) = self.left.checked_sub(lines) else {
            let message = format!("jumps, loops and calls run more than {} lines", self.most);
            let help = "does the loop end? if so, allow more when reading";
            return Err(ReadRemark::new(0, message, help));
        };
        self.left = left;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_lines_are_played_again_and_counted() {
        let mut tape = Tape::new(5);
        for (number, text) in (1..).zip(["a", "b", "c", "d"]) {
            tape.record(number, text);
            if number == 2 {
                tape.keep(text);
            }
        }
        assert_eq!(tape.back(5, |text| text == "a").unwrap(), None);
        tape.go_to(3);
        let line =
            |tape: &mut Tape| tape.play().map(|line| line.map(|(n, text)| (n, text.to_string())));
        assert_eq!(line(&mut tape).unwrap(), Some((3, "c".to_owned())));
        assert_eq!(line(&mut tape).unwrap(), Some((4, "d".to_owned())));
        assert!(!tape.is_busy());
        tape.go_to(2);
        assert!(line(&mut tape).unwrap_err().message.contains("more than 5 lines"));
    }
}
