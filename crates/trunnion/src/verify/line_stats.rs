//! Per-line statistics: the worst findings on lines of a program, and their number, in memory that does not grow with the
//! program.

use std::collections::BTreeMap;

/// Lines of a program on which something was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LineCount {
    /// Number of lines; a line to which the program comes back may count again.
    pub count: usize,
    /// First line in the order of execution.
    pub first: u32,
    /// Last line in the order of execution.
    pub last: u32,
}

/// Earlier notes about a line whose finding comes after later lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineHistory {
    /// The line was noted before, and counts already.
    Noted,
    /// The line is new.
    New,
}

/// Finding on a line.
#[derive(Debug, Clone, Copy)]
struct LineFinding<T> {
    /// Severity: the larger, the worse.
    severity: f64,
    content: T,
}

/// Worst findings by line, limited in number, with the count of all lines.
#[derive(Debug)]
pub(crate) struct LineStatistics<T> {
    most: usize,
    lines: Option<LineCount>,
    kept: BTreeMap<u32, LineFinding<T>>,
}

impl<T: Copy> LineStatistics<T> {
    /// Keeps the `most` worst lines.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, lines: None, kept: BTreeMap::new() }
    }

    /// Adds a finding. Lines come in the order of the program.
    pub(crate) fn note(&mut self, line: u32, severity: f64, content: T) {
        let lines = self.lines.get_or_insert(LineCount { count: 0, first: line, last: line });
        let again = lines.count > 0 && (lines.last == line || self.kept.contains_key(&line));
        lines.count += usize::from(!again);
        lines.last = line;
        self.keep(line, LineFinding { severity, content });
    }

    /// Adds a finding on a line that later lines may have followed.
    pub(crate) fn note_late(&mut self, line: u32, severity: f64, content: T, history: LineHistory) {
        let lines = self.lines.get_or_insert(LineCount { count: 0, first: line, last: line });
        // A line that was pruned cannot be recognized here: the caller knows if the rays had shown it.
        let counts = history == LineHistory::New && !self.kept.contains_key(&line);
        lines.count += usize::from(counts);
        (lines.first, lines.last) = (lines.first.min(line), lines.last.max(line));
        self.keep(line, LineFinding { severity, content });
    }

    fn keep(&mut self, line: u32, finding: LineFinding<T>) {
        let worst = self.kept.entry(line).or_insert(finding);
        if finding.severity > worst.severity {
            *worst = finding;
        }
        // Pruning at twice the number costs little per line, and bounds the memory.
        if self.kept.len() > 2 * self.most {
            self.prune();
        }
    }

    fn prune(&mut self) {
        let mut severities: Vec<f64> = self.kept.values().map(|kept| kept.severity).collect();
        severities.sort_by(|a, b| b.total_cmp(a));
        let Some(&least) = severities.get(self.most.saturating_sub(1)) else { return };
        // Of those that are equally bad the first stay.
        let worse = severities.iter().filter(|severity| **severity > least).count();
        let mut room = self.most - worse.min(self.most);
        self.kept.retain(|_, kept| {
            let equal = kept.severity.total_cmp(&least).is_eq();
            let stays = kept.severity > least || (equal && room > 0);
            room -= usize::from(equal && stays);
            stays
        });
    }

    /// Returns the worst findings in the order of lines, and the count of all lines.
    pub(crate) fn finish(mut self) -> (Vec<T>, Option<LineCount>) {
        self.prune();
        (self.kept.into_values().map(|kept| kept.content).collect(), self.lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_are_kept_and_all_are_counted() {
        let mut statistics = LineStatistics::new(3);
        for line in 1..=1000_u32 {
            let bad = f64::from(line % 100);
            statistics.note(line, bad, line);
            statistics.note(line, bad - 0.5, 0);
        }
        let (kept, lines) = statistics.finish();
        assert_eq!(kept, [99, 199, 299]);
        assert_eq!(lines, Some(LineCount { count: 1000, first: 1, last: 1000 }));
        assert_eq!(LineStatistics::<u32>::new(3).finish(), (vec![], None));
    }
}
