//! Cycles 8 and 10: mirror image and rotation.

use super::frame::ProgramFrame;
use super::reader::HeidenhainReader;
use super::token::Tokens;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;

impl HeidenhainReader {
    /// Takes `8.1 X Y`; without axes it ends the mirror image.
    pub(super) fn mirror(
        &mut self,
        state: &ReaderState,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let mut mirrored = [false; 2];
        while let Some(token) = tokens.next_token() {
            let letters = ["X", "Y", "Z"];
            let axis = letters.iter().position(|letter| token.text.eq_ignore_ascii_case(letter));
            let in_plane = self.plane.iter().position(|slot| Some(*slot) == axis);
            let Some(place) = in_plane.and_then(|place| mirrored.get_mut(place)) else {
                let message = format!("a mirror image of {} (cycle 8)", excerpt(token.text));
                return Err(ReadRemark::new(token.at, message, "post without it"));
            };
            *place = true;
        }
        let turned = self.frame.turn.abs() > 0.0;
        if turned && mirrored.contains(&true) {
            let help = "cancel cycle 10 before, or post without them";
            return Err(ReadRemark::new(at, "a mirror image of a rotated program", help));
        }
        self.reframe(state, ProgramFrame { mirrored, ..self.frame }, at)
    }

    /// Takes `10.1 ROT+30`, `10.1 IROT+5`; zero ends the rotation.
    pub(super) fn rotation(
        &mut self,
        state: &ReaderState,
        tokens: &mut Tokens<'_>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let text: String = std::iter::from_fn(|| tokens.next_token())
            .map(|token| token.text.to_ascii_uppercase())
            .collect();
        let (incremental, written) = match text.strip_prefix("IROT") {
            Some(written) => (true, written),
            None => (false, text.strip_prefix("ROT").unwrap_or(&text)),
        };
        let angle = self.arithmetic(written, at)?.to_radians();
        let turn = if incremental { self.frame.turn + angle } else { angle };
        if turn.abs() > 0.0 && self.frame.mirrored.contains(&true) {
            let help = "cancel cycle 8 before, or post without them";
            return Err(ReadRemark::new(at, "a rotation of a mirrored program", help));
        }
        self.reframe(state, ProgramFrame { turn, ..self.frame }, at)
    }

    fn reframe(
        &mut self,
        state: &ReaderState,
        frame: ProgramFrame,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if state.control.tilted.is_some() && !frame.is_plain() {
            let help = "post without it, or write the angle into PLANE";
            return Err(ReadRemark::new(at, "cycles 8 and 10 in a tilted plane", help));
        }
        // Poles are kept as they are run, so that one of another frame would be another place.
        self.pole = [None; 3];
        self.frame = frame;
        Ok(())
    }

    /// Checks that words are as written.
    pub(super) fn plain_frame(&self, at: usize, what: &str) -> Result<(), ReadRemark> {
        if self.frame.is_plain() {
            return Ok(());
        }
        let message = format!("{what} in a mirrored or rotated program");
        Err(ReadRemark::new(at, message, "cancel cycles 8 and 10 before"))
    }
}
