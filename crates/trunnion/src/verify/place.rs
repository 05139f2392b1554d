//! Where in the program an error lies.

use super::VerifyError;
use crate::nc::read::{Move, ProgramSource, Step};
use crate::types::Diagnostic;

impl VerifyError {
    /// Line of the program, counted from 1; `None` if it lies in none.
    pub fn line(&self) -> Option<u32> {
        match *self {
            Self::Tools { line, .. }
            | Self::UnknownTool { line, .. }
            | Self::NoTool { line }
            | Self::WorkOffset { line, .. }
            | Self::Offset { line, .. }
            | Self::OutOfReach { line, .. }
            | Self::Special { line, .. }
            | Self::Unfollowed { line }
            | Self::TurnsTooFar { line } => Some(line).filter(|line| *line > 0),
            _ => None,
        }
    }

    /// As a fault of the program's text: at the axis words of its line, or at the line as a whole if it has none, or
    /// `program` is `None` (cutter locations).
    pub fn fault(&self, program: Option<&dyn ProgramSource>) -> Diagnostic {
        let text = self.to_string();
        let Some(line) = self.line() else { return Diagnostic::whole(text) };
        let column = program.and_then(|program| {
            program.steps().find_map(|step| match step {
                Step::Move(Move { line: of, column, .. }) if of == line => Some(column),
                _ => None,
            })
        });
        let message = text.strip_prefix(&format!("line {line}: ")).unwrap_or(&text).to_owned();
        Diagnostic { line, column: column.unwrap_or(0), message, help: String::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nc::read::{AxisWord, AxisWords, Dialect, ReadOptions, read};

    #[test]
    fn an_error_points_at_the_words_of_its_line() {
        let word = |letter: char| AxisWord {
            letter,
            rotary: "AC".contains(letter),
            decimals: 4,
            reversed: false,
        };
        let axes = AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word));
        let options = ReadOptions::new(Dialect::LinuxCnc, axes, 20);
        let text = "G21 G90 G94 G54\nT1 M6\nG0 X0\nN4 (in) G1 F100 X1\nM2\n";
        let program = read(text, &options).unwrap();
        let told = |error: VerifyError| error.fault(Some(&program)).to_string();
        let far = VerifyError::TurnsTooFar { line: 4 };
        assert_eq!(told(far.clone()), "4:17: the block turns too far to be followed; break it up");
        assert!(told(VerifyError::UnknownTool { line: 2, number: 1 }).starts_with("2: tool 1 is"));
        assert!(far.fault(None).to_string().starts_with("4: the block"));
        assert_eq!(told(VerifyError::NoMotion), " the program has no moves");
        assert!(VerifyError::NoTool { line: 0 }.line().is_none());
    }
}
