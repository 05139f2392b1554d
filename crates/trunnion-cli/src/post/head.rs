//! Head of the program.

use trunnion::nc::write::{Coolant, Note, ToolNote};

/// Texts and numbers at the head of the program.
#[derive(Debug, Clone, Default)]
pub(super) struct Head {
    pub(super) name: String,
    pub(super) tool: Option<u32>,
    /// All that were posted.
    pub(super) tools: Vec<u32>,
    pub(super) cutter: Option<[f64; 2]>,
    pub(super) spindle: f64,
    pub(super) coolant: Coolant,
    pub(super) feed: f64,
    pub(super) duration: f64,
}

/// State of the input's control at a move, as far as the head of the program has it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct HeadState {
    pub(super) tool: Option<u32>,
    pub(super) cutter: Option<[f64; 2]>,
    /// Spindle speed \[1/min\].
    pub(super) spindle: f64,
    pub(super) coolant: Coolant,
    /// Largest feed so far \[mm/s\].
    pub(super) feed: f64,
}

impl Head {
    /// Takes over the state at a move.
    pub(super) fn take(&mut self, state: &HeadState) {
        let HeadState { tool, cutter, spindle, coolant, feed } = *state;
        (self.tool, self.cutter, self.spindle) = (tool, cutter, spindle);
        (self.coolant, self.feed) = (coolant, feed);
    }

    /// Returns the note that programs and sheets are written with.
    pub(super) fn note(&self) -> Note<'_> {
        // CL files state diameter and corner radius: D = 2 (R + r).
        let [diameter, minor] = self.cutter.unwrap_or([0.0; 2]);
        Note {
            name: &self.name,
            tool: ToolNote {
                number: self.tool.unwrap_or(1),
                major: (0.5 * diameter - minor).max(0.0),
                minor,
            },
            spindle: self.spindle,
            coolant: self.coolant,
            feed: self.feed,
            budget: &[],
            duration: self.duration,
            remarks: &[],
        }
    }
}
