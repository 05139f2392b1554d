//! The part of a program that one tool runs.

use crate::post::error::PostError;
use crate::post::refusal::refused;

/// The only tool whose moves are wanted, and how far the program is with it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnlyTool {
    number: u32,
    progress: ToolProgress,
}

/// Progress of a program with one of its tools.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ToolProgress {
    Before,
    Running,
    Over,
}

impl OnlyTool {
    pub(super) fn new(number: u32) -> Self {
        Self { number, progress: ToolProgress::Before }
    }

    pub(super) fn is_running(self) -> bool {
        self.progress == ToolProgress::Running
    }

    pub(super) fn is_over(self) -> bool {
        self.progress == ToolProgress::Over
    }

    /// Returns the progress after a tool change; `has_moved` once the wanted tool was moved.
    ///
    /// # Errors
    ///
    /// [`PostError::Refused`] where the tool comes back after another one.
    pub(super) fn after_change(
        self,
        line: u32,
        number: u32,
        moved: ToolMotion,
    ) -> Result<Self, PostError> {
        let progress = match (self.progress, number == self.number) {
            (ToolProgress::Over, true) if moved == ToolMotion::Moved => {
                let help = "post the part of the program behind this line on its own";
                return Err(refused(line, "this tool a second time, after another", help));
            }
            (ToolProgress::Running, false) => ToolProgress::Over,
            (_, true) => ToolProgress::Running,
            (progress, false) => progress,
        };
        Ok(Self { progress, ..self })
    }
}

/// Motion of the tool in the spindle so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolMotion {
    /// Its position in the workpiece is not stated yet.
    Unplaced,
    /// It was moved.
    Moved,
}
