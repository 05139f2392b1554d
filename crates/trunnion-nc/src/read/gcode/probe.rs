//! Probing moves of `LinuxCNC`: `G38.2` to `G38.5`.

use super::modal::BlockActions;
use super::parameters::ParameterKey;
use super::reader::GcodeReader;
use crate::read::control::MoveTarget;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Step, Way};

/// Parameter with the contact along X; those of Y Z A B C U V W follow.
const CONTACT: u32 = 5061;

/// Parameter that tells whether there was contact.
const TRIPPED: u32 = 5070;

/// Axes that have a parameter, in the order of these.
const LETTERS: &str = "XYZABCUVW";

impl GcodeReader {
    /// Moves a probe to the end of its line, as if nothing were in its way.
    pub(super) fn probe(
        &mut self,
        state: &mut ReaderState,
        target: MoveTarget,
        now: &BlockActions,
        tenths: u32,
    ) -> Result<(), ReadRemark> {
        let line = state.log.line;
        let message = format!(
            "G38.{}: where the probe stops is not in the program; it is taken to reach the end of the line, without contact",
            tenths % 10
        );
        let help = "positions and offsets behind it depend on the contact";
        state.log.warn("", ReadRemark::new(target.at, message, help));
        let pace = state.control.pace(&target, now.feed)?;
        state.control.steps.push_back(Step::Probe { line });
        state.control.go(line, target, pace, Way::Line)?;
        self.store_contact(state);
        Ok(())
    }

    /// Sets the parameters of the contact as the stand-alone interpreter does.
    fn store_contact(&mut self, state: &ReaderState) {
        for (number, letter) in (CONTACT..).zip(LETTERS.chars()) {
            let control = &state.control;
            let slot = control.known_slot(letter);
            let reads =
                slot.map_or(Some(0.0), |slot| Some(control.written(slot, control.reading(slot)?)));
            // An axis whose position is not stated has no contact either.
            if let Some(value) = reads {
                self.parameters.set(ParameterKey::Number(number), value);
            }
        }
        self.parameters.set(ParameterKey::Number(TRIPPED), 0.0);
    }
}
