//! What is wrong on lines of a program: the worst of it, and how often, in memory that does not grow with the program.

use std::collections::BTreeMap;

/// Lines of a program on which something was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lines {
    /// How many; a line to which the program comes back may count again.
    pub count: usize,
    /// The first that was run.
    pub first: u32,
    /// The last.
    pub last: u32,
}

/// The worst of what was found on lines, in a number that is given.
#[derive(Debug)]
pub(crate) struct Ledger<T> {
    most: usize,
    lines: Option<Lines>,
    kept: BTreeMap<u32, (f64, T)>,
}

impl<T: Copy> Ledger<T> {
    /// Keeps the `most` worst.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, lines: None, kept: BTreeMap::new() }
    }

    /// Takes in what was found on a line, and how bad it is. Lines come in the order of the program.
    pub(crate) fn note(&mut self, line: u32, bad: f64, what: T) {
        let lines = self.lines.get_or_insert(Lines { count: 0, first: line, last: line });
        let again = lines.count > 0 && (lines.last == line || self.kept.contains_key(&line));
        lines.count += usize::from(!again);
        lines.last = line;
        let worst = self.kept.entry(line).or_insert((bad, what));
        if bad > worst.0 {
            *worst = (bad, what);
        }
        // Rarely, so that a line costs little.
        if self.kept.len() > 2 * self.most {
            self.prune();
        }
    }

    /// Takes in what was found on a line that may have been passed; `known`: it had been noted.
    pub(crate) fn note_late(&mut self, line: u32, bad: f64, what: T, known: bool) {
        let lines = self.lines.get_or_insert(Lines { count: 0, first: line, last: line });
        lines.count += usize::from(!known && !self.kept.contains_key(&line));
        (lines.first, lines.last) = (lines.first.min(line), lines.last.max(line));
        let worst = self.kept.entry(line).or_insert((bad, what));
        if bad > worst.0 {
            *worst = (bad, what);
        }
        if self.kept.len() > 2 * self.most {
            self.prune();
        }
    }

    fn prune(&mut self) {
        let mut bad: Vec<f64> = self.kept.values().map(|(bad, _)| *bad).collect();
        bad.sort_by(|a, b| b.total_cmp(a));
        let Some(&least) = bad.get(self.most.saturating_sub(1)) else { return };
        // Of those that are equally bad the first stay.
        let mut room = self.most - bad.iter().filter(|bad| **bad > least).count().min(self.most);
        self.kept.retain(|_, (bad, _)| {
            let equal = bad.total_cmp(&least).is_eq();
            let stays = *bad > least || (equal && room > 0);
            room -= usize::from(equal && stays);
            stays
        });
    }

    /// The worst in the order of lines, and the count of all.
    pub(crate) fn finish(mut self) -> (Vec<T>, Option<Lines>) {
        self.prune();
        (self.kept.into_values().map(|(_, what)| what).collect(), self.lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_are_kept_and_all_are_counted() {
        let mut ledger = Ledger::new(3);
        for line in 1..=1000_u32 {
            let bad = f64::from(line % 100);
            ledger.note(line, bad, line);
            ledger.note(line, bad - 0.5, 0);
        }
        let (kept, lines) = ledger.finish();
        assert_eq!(kept, [99, 199, 299]);
        assert_eq!(lines, Some(Lines { count: 1000, first: 1, last: 1000 }));
        assert_eq!(Ledger::<u32>::new(3).finish(), (vec![], None));
    }
}
