//! Tools of a program, each with its length, or the one that is wanted.

use super::{ProgramMoves, Turn, refused};
use crate::inverse::Inverse;
use crate::machine::{Kinematics, Setup};
use crate::post::error::{PostError, PostRemedy};

impl ProgramMoves {
    /// Another tool goes into the spindle.
    pub(super) fn change(&mut self, line: u32, number: u32) -> Result<(), PostError> {
        if !self.lengths.is_empty() {
            return self.change_length(line, number);
        }
        let Some((only, before)) = self.only else {
            if self.tool.is_some_and(|before| before != number) && self.started {
                return Err(refused(line, "a second tool", PostRemedy::ToolLengths));
            }
            self.tool = Some(number);
            return Ok(());
        };
        let turn = match (before, number == only) {
            (Turn::Over, true) if self.started => {
                let help = "post the part of the program behind this line on its own";
                return Err(refused(line, "this tool a second time, after another", help));
            }
            (Turn::Now, false) => Turn::Over,
            (_, true) => {
                self.start_anew(number);
                Turn::Now
            }
            (turn, false) => turn,
        };
        self.only = Some((only, turn));
        Ok(())
    }

    /// It starts where this tool is first told to go to.
    fn start_anew(&mut self, tool: u32) {
        (self.started, self.known, self.work) = (false, [false; 3], None);
        self.left.moves += self.away.len();
        self.away.clear();
        self.tool = Some(tool);
    }

    /// Another tool with its own length.
    fn change_length(&mut self, line: u32, number: u32) -> Result<(), PostError> {
        if self.tool == Some(number) {
            return Ok(());
        }
        let found = self.lengths.iter().find(|(known, _)| *known == number);
        let Some(&(_, tool_length)) = found else {
            let what = "a tool whose length is not known";
            return Err(refused(line, what, PostRemedy::ToolLength));
        };
        let setup = Setup { tool_length, ..*self.kinematics().setup() };
        self.inverse = inverses(&Kinematics::new(self.kinematics().machine(), &setup))?;
        self.start_anew(number);
        Ok(())
    }

    /// Moves are those of the tool that is wanted.
    pub(super) fn is_wanted(&self) -> bool {
        self.only.is_none_or(|(_, turn)| turn == Turn::Now)
    }
}

/// With the tool, and without.
pub(super) fn inverses(kinematics: &Kinematics) -> Result<[Inverse; 2], PostError> {
    let bare = Setup { tool_length: 0.0, ..*kinematics.setup() };
    let bare = Kinematics::new(kinematics.machine(), &bare);
    let inverse = |of: &Kinematics| Inverse::new(of).map_err(|error| PostError::reach(0, error));
    Ok([inverse(kinematics)?, inverse(&bare)?])
}
