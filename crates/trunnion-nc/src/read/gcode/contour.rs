//! Lines of a program while cutter compensation is on.

use super::block::{CodeWord, GcodeBlock};
use super::compensation::{Compensation, ContourMove, ProgrammedArc, length_word};
use super::corner::CutterSide;
use super::modal::{BlockActions, GcodeMotion};
use super::reader::GcodeReader;
use super::words::natural;
use crate::read::control::MoveTarget;
use crate::read::log::ReadRemark;
use crate::read::remedy::unknown_tool;
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step};
use std::collections::VecDeque;

impl GcodeReader {
    /// Returns true if moves run beside their contour.
    pub(super) fn is_compensating(&self) -> bool {
        self.modal.compensation.as_ref().is_some_and(|on| on.changes_moves())
    }

    /// Runs `G41`, `G42` with D, the number of a tool, and `G41.1`, `G42.1` with D, a diameter.
    pub(super) fn compensate(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        code: CodeWord,
    ) -> Result<(), ReadRemark> {
        let CodeWord { tenths, at, .. } = code;
        let side = if tenths < 420 { CutterSide::Left } else { CutterSide::Right };
        let refused = |message: &str, help: &str| Err(ReadRemark::new(at, message, help));
        if self.modal.plane == 2 {
            return refused("cutter compensation in G19", "use G17 or G18");
        }
        if state.control.tcp || state.control.tilted.is_some() {
            return refused(
                "cutter compensation with tool-centre-point control or in a tilted plane",
                "end them before it",
            );
        }
        let (radius, corner) = if tenths % 10 == 1 {
            let Some(diameter) = length_word(&state.control, block, 'D') else {
                return refused("G41.1 or G42.1 without D", "write the diameter of the cutter");
            };
            let corner = block.take('L').map_or(Ok(0), |word| natural(word, 'L'))?;
            (0.5 * diameter, corner)
        } else {
            // D0 and no D are the tool in the spindle.
            let word = block.take('D').map(|word| natural(word, 'D')).transpose()?;
            let spindle = state.control.tools.last().copied().unwrap_or(0);
            let number = word.filter(|number| *number > 0).unwrap_or(spindle);
            let row = state.control.tool_table.get(number);
            let row = row.ok_or_else(|| {
                unknown_tool(
                    at,
                    format!(
                        "the radius of tool {number} is not known, which cutter compensation needs"
                    ),
                )
            })?;
            (0.5 * row.diameter, row.corner)
        };
        let turning = !matches!(corner, 0 | 9);
        if turning && self.modal.plane != 1 {
            return refused("cutter compensation for a turning tool outside of G18", "write G18");
        }
        let (axes, _) = self.plane();
        let [u, v, _] = axes.map(|axis| state.control.xyz[axis]);
        let compensation = Compensation::new(side, radius, [u, v]).with_corner(corner);
        self.modal.compensation = Some(Box::new(compensation));
        Ok(())
    }

    /// Runs `G40`: what waits is run before the steps of this line.
    pub(super) fn end_compensation(&mut self, state: &mut ReaderState) -> Result<(), ReadRemark> {
        let Some(compensation) = self.modal.compensation.take() else { return Ok(()) };
        let late = self.late_steps(state);
        self.modal.leaves_contour = compensation.has_moved();
        compensation.end(&mut state.control)?;
        state.control.steps.extend(late);
        self.modal.line_began = state.control.steps.len();
        Ok(())
    }

    /// Refuses codes that a control does not take while compensation is on.
    pub(super) fn check_compensated(
        &self,
        compensation: &Compensation,
        code: CodeWord,
        text: &str,
    ) -> Result<(), ReadRemark> {
        let plane = [170, 180].get(self.modal.plane).copied();
        let stays = match (code.letter, code.tenths) {
            (b'G', tenths @ (170 | 180 | 190)) => plane == Some(tenths),
            (
                b'G',
                0 | 10 | 20 | 30 | 40 | 80 | 90 | 400 | 610 | 611 | 640 | 800 | 900 | 901 | 910
                | 911 | 930 | 940 | 950 | 960 | 970 | 980 | 990,
            ) => true,
            (b'G', _) | (_, 60 | 610) => false,
            _ => true,
        };
        if stays {
            return Ok(());
        }
        let what = text.get(code.at..code.end).unwrap_or_default();
        let message = format!("{what} with cutter compensation on (G{})", compensation.code() / 10);
        Err(ReadRemark::new(code.at, message, "write G40 before it"))
    }

    /// Runs a straight move beside its contour.
    pub(super) fn contour_line(
        &mut self,
        state: &mut ReaderState,
        target: MoveTarget,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        let pace = match self.modal.motion {
            Some(GcodeMotion::Rapid) => Pace::Rapid,
            _ => state.control.pace(&target, now.feed)?,
        };
        let given = ContourMove { line: state.log.line, target, pace };
        let late = self.late_steps(state);
        let Some(mut compensation) = self.modal.compensation.take() else { return Ok(()) };
        let done = compensation.line(&mut state.control, &given, late);
        self.resume(state, compensation);
        done
    }

    /// Runs an arc beside its contour.
    pub(super) fn contour_arc(
        &mut self,
        state: &mut ReaderState,
        target: MoveTarget,
        programmed: &ProgrammedArc,
        feed: Option<f64>,
    ) -> Result<(), ReadRemark> {
        let pace = state.control.pace(&target, feed)?;
        let given = ContourMove { line: state.log.line, target, pace };
        let late = self.late_steps(state);
        let Some(mut compensation) = self.modal.compensation.take() else { return Ok(()) };
        let done = compensation.arc(&mut state.control, &given, programmed, late);
        self.resume(state, compensation);
        done
    }

    fn resume(&mut self, state: &ReaderState, compensation: Box<Compensation>) {
        self.modal.compensation = Some(compensation);
        self.modal.line_began = state.control.steps.len();
    }

    /// Takes the steps that this line has made so far.
    fn late_steps(&self, state: &mut ReaderState) -> VecDeque<Step> {
        let from = self.modal.line_began.min(state.control.steps.len());
        state.control.steps.split_off(from)
    }

    /// Puts steps of a line behind the moves that wait; runs them all if the program ends.
    pub(super) fn order_steps(&mut self, state: &mut ReaderState) {
        if self.modal.compensation.is_none() {
            return;
        }
        let late = self.late_steps(state);
        if let Some(compensation) = self.modal.compensation.as_mut() {
            compensation.follow(&mut state.control, late);
        }
        self.modal.line_began = state.control.steps.len();
    }

    /// Runs what waits at the end of the program.
    pub(super) fn settle(&mut self, state: &mut ReaderState) {
        if state.control.ended
            && let Some(compensation) = self.modal.compensation.take()
        {
            let done = compensation.end(&mut state.control);
            super::reader::note(state, "", done);
        }
    }
}
