//! Errors of checks.

use super::replay::offset_names::offset_name;
use crate::nc::control::OffsetFault;
use crate::nc::read::{Move, ProgramSource, Step};
use crate::types::{Cancelled, Diagnostic};

/// Reasons for which motion cannot be checked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// An option that is not a usable number.
    #[error("option {name} is {value}; it must be {must}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Condition that it breaks.
        must: &'static str,
    },
    /// The tool cuts the faces from their backs.
    #[error(
        "the tool cuts the faces from behind, at {from_back} of {examined} points that were examined"
    )]
    FromBehind {
        /// Points that the tool reaches from the back alone.
        from_back: usize,
        /// All points that were examined.
        examined: usize,
    },
    /// Bodies of the machine that cannot be checked.
    #[error("{what}")]
    Bodies {
        /// Defect, with its remedy.
        what: String,
    },
    /// The program moves nothing.
    #[error("the program has no moves")]
    NoMotion,
    /// More than one tool, and no table of them.
    #[error(
        "line {line}: tool {} after tool {}", numbers[1], numbers[0]
    )]
    Tools {
        /// Line of the program.
        line: u32,
        /// The first, and that of the line.
        numbers: [u32; 2],
    },
    /// A tool that the table does not have.
    #[error("line {line}: tool {number} is not known")]
    UnknownTool {
        /// Line of the program.
        line: u32,
        /// Number of the tool in the program.
        number: u32,
    },
    /// A cut before the first of several tools.
    #[error(
        "line {line}: a move before the program calls a tool; call it before (T.. M6, TOOL CALL, LOADTL)"
    )]
    NoTool {
        /// Line of the program.
        line: u32,
    },
    /// A work offset that the table does not have.
    #[error("line {line}: work offset {} is not known", offset_name(*number))]
    WorkOffset {
        /// Line of the program.
        line: u32,
        /// 0 for `G54`, 1 for `G55` and so on.
        number: u8,
    },
    /// A work offset that the program writes in a way that is not followed.
    #[error(
        "line {line}: {fault} is not followed; write X, Y and Z of the offset as axis positions (G10 L2), and rotaries as 0"
    )]
    Offset {
        /// Line of the program.
        line: u32,
        /// The reason.
        fault: OffsetFault,
    },
    /// A direction that no position of the rotaries gives the tool.
    #[error("line {line}: no position of the rotary axes turns the tool along {:.6}, {:.6}, {:.6} (workpiece); check the vector or plane, and machine and rotation of the setup", axis[0], axis[1], axis[2])]
    OutOfReach {
        /// Line of the program.
        line: u32,
        /// Tool axis, workpiece frame.
        axis: [f64; 3],
    },
    /// A step that is read, but not replayed.
    #[error(
        "line {line}: {what} is not replayed; post the program with straight moves of five axes"
    )]
    Special {
        /// Line of the program.
        line: u32,
        /// Kind of the step.
        what: &'static str,
    },
    /// A cut from a position that is not known.
    #[error(
        "line {line}: after the tool change the position of X, Y and Z is not known, so this cut cannot be followed; put \
         rapid moves before it that command X, Y and Z"
    )]
    Unfollowed {
        /// Line of the program.
        line: u32,
    },
    /// X, Y and Z do not span space.
    #[error("the linear axes do not reach every position")]
    LinearAxes,
    /// A block that turns so far that its motion cannot be followed.
    #[error("line {line}: the block turns too far to be followed; break it up")]
    TurnsTooFar {
        /// Line of the program.
        line: u32,
    },
    /// Stock or a fixture that cannot be worked with.
    #[error("the solid {what}")]
    Stock {
        /// Defect, as the rest of a sentence about the solid.
        what: String,
    },
    /// The grid is too fine.
    #[error("face {face} would have {points:.0} grid points, more than {most}; use a coarser grid")]
    TooManyPoints {
        /// Number of the face.
        face: usize,
        /// Points asked for.
        points: f64,
        /// Points allowed.
        most: usize,
    },
}

/// Remedy of a [`VerifyError`]; a command line or user interface names its own options for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum VerifyRemedy {
    /// The text of the error names the remedy, or there is none.
    None,
    /// Describe every tool of the program in [`Tables::tools`](super::Tables::tools), this one first.
    DescribeTools {
        /// Number of the first tool.
        first: u32,
    },
    /// Describe this tool in [`Tables::tools`](super::Tables::tools).
    DescribeTool {
        /// Number of the tool.
        number: u32,
    },
    /// Give this work offset in [`Tables::offsets`](super::Tables::offsets).
    GiveOffset {
        /// Number of the offset: 0 for `G54`, 1 for `G55` and so on.
        number: u8,
    },
    /// Turn the faces over.
    FlipFaces,
}

impl VerifyError {
    /// Returns the remedy, for the caller to put into the words of its own options.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::verify::{VerifyError, VerifyRemedy};
    ///
    /// let error = VerifyError::UnknownTool { line: 3, number: 2 };
    /// assert_eq!(error.to_string(), "line 3: tool 2 is not known");
    /// assert_eq!(error.remedy(), VerifyRemedy::DescribeTool { number: 2 });
    /// ```
    pub fn remedy(&self) -> VerifyRemedy {
        match *self {
            Self::Tools { numbers: [first, _], .. } => VerifyRemedy::DescribeTools { first },
            Self::UnknownTool { number, .. } => VerifyRemedy::DescribeTool { number },
            Self::WorkOffset { number, .. } => VerifyRemedy::GiveOffset { number },
            Self::FromBehind { .. } => VerifyRemedy::FlipFaces,
            _ => VerifyRemedy::None,
        }
    }

    /// Returns the line of the program, counted from 1; `None` if the error belongs to no line.
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

    /// Returns the error as a diagnostic of the program's text: at the axis words of its line, or at the whole line if it
    /// has none or `program` is `None` (cutter locations).
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
        let text_of = |error: VerifyError| error.fault(Some(&program)).to_string();
        let far = VerifyError::TurnsTooFar { line: 4 };
        assert_eq!(
            text_of(far.clone()),
            "4:17: the block turns too far to be followed; break it up"
        );
        assert!(
            text_of(VerifyError::UnknownTool { line: 2, number: 1 }).starts_with("2: tool 1 is")
        );
        assert!(far.fault(None).to_string().starts_with("4: the block"));
        assert_eq!(text_of(VerifyError::NoMotion), " the program has no moves");
        assert!(VerifyError::NoTool { line: 0 }.line().is_none());
    }
}
