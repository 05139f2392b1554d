//! Moves at the beginning of a program that run before a tool length is in force.

/// Moves from the first one without a tool length on, up to the first one with it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BareMoves {
    /// Lines of the first and of the last one so far.
    lines: Option<[u32; 2]>,
    /// A tool length has come into force behind them.
    is_over: bool,
}

impl BareMoves {
    /// Takes in a move that runs without a tool length.
    pub(super) fn add(&mut self, line: u32) {
        if !self.is_over {
            let [first, _] = self.lines.unwrap_or([line; 2]);
            self.lines = Some([first, line]);
        }
    }

    /// Takes in a move that runs with a tool length.
    pub(super) fn end(&mut self) {
        self.is_over |= self.lines.is_some();
    }

    /// Returns the line of the first one, if the move of a line is among them.
    pub(super) fn first(&self, line: u32) -> Option<u32> {
        self.lines.filter(|[first, last]| (*first..=*last).contains(&line)).map(|[first, _]| first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_behind_the_first_length_are_not_among_them() {
        let mut moves = BareMoves::default();
        moves.end();
        moves.add(3);
        moves.add(5);
        assert_eq!([2, 3, 5, 6].map(|line| moves.first(line)), [None, Some(3), Some(3), None]);
        moves.end();
        moves.add(9);
        assert_eq!(moves.first(9), None);
    }
}
