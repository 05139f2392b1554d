//! `M70` to `M73`: modal states saved and restored.

use super::flow::FrameKind;
use super::reader::GcodeReader;
use super::saved_state::SavedState;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;

impl GcodeReader {
    /// Returns how many calls are running.
    pub(super) fn call_level(&self) -> usize {
        self.flow.frames.iter().filter(|frame| frame.of != FrameKind::File).count()
    }

    /// Runs `M70` to `M73`; the state of `M73` comes back when the call returns.
    pub(super) fn saved_code(
        &mut self,
        state: &mut ReaderState,
        tenths: u32,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let level = self.call_level();
        match tenths {
            700 | 730 => {
                let saved = self.save(state, level, tenths);
                self.forget_saved(level);
                self.modal.saved.push(saved);
            }
            710 => self.forget_saved(level),
            _ => {
                let saved = self.modal.saved.iter().find(|saved| saved.level == level).cloned();
                let Some(saved) = saved else {
                    let message = "M72 without a saved state";
                    return Err(ReadRemark::new(
                        at,
                        message,
                        "write M70 before, in the same subprogram",
                    ));
                };
                self.restore(state, &saved);
            }
        }
        Ok(())
    }

    /// Restores the state that `M73` saved in a call that has returned.
    pub(super) fn call_returned(&mut self, state: &mut ReaderState) {
        let level = self.call_level();
        let inner = self.modal.saved.iter().position(|saved| saved.level > level);
        let Some(at) = inner else { return };
        let saved = self.modal.saved.split_off(at);
        if let Some(saved) = saved.iter().find(|saved| saved.at_return && saved.level == level + 1)
        {
            self.restore(state, saved);
        }
    }

    fn forget_saved(&mut self, level: usize) {
        self.modal.saved.retain(|saved| saved.level < level);
    }

    fn save(&self, state: &ReaderState, level: usize, tenths: u32) -> SavedState {
        let control = &state.control;
        SavedState {
            level,
            at_return: tenths == 730,
            distance: self.modal.distance,
            arc_absolute: self.modal.arc_absolute,
            plane: self.modal.plane,
            diameter: self.modal.diameter,
            to_r: self.modal.to_r,
            inch: control.inch,
            feed_mode: control.feed_mode,
            feed: control.feed,
            speed: control.speed,
            surface: control.surface,
            sense: control.sense,
            offset: control.offset,
            length: control.length,
            shift: control.xyz.map(|slot| control.tool_offset(slot)),
        }
    }

    /// Brings a state back. The motion mode (G0, G1 and so on) is not part of it.
    fn restore(&mut self, state: &mut ReaderState, saved: &SavedState) {
        self.modal.distance = saved.distance;
        self.modal.arc_absolute = saved.arc_absolute;
        self.modal.plane = saved.plane;
        self.modal.diameter = saved.diameter;
        self.modal.to_r = saved.to_r;
        let control = &mut state.control;
        control.inch = saved.inch;
        control.feed_mode = saved.feed_mode;
        control.feed = saved.feed;
        control.set_offset(saved.offset);
        if control.length != saved.length {
            if saved.length {
                control.enable_length();
            } else {
                control.disable_length();
            }
        }
        control.set_tool_shift(saved.shift);
        let before = (control.sense, control.speed);
        (control.sense, control.speed, control.surface) = (saved.sense, saved.speed, saved.surface);
        if before != (saved.sense, saved.speed) {
            control.spindle(state.log.line);
        }
    }
}
