//! Steps that a control emits beside its motion: tools, spindle, smoothing, lengths, words.

use super::control::{ControlState, INCH, SLOTS, SurfaceSpeed};
use super::step::{LengthEntry, Smoothing, Step};

impl ControlState {
    /// Puts a tool into the spindle.
    pub(super) fn change_tool(&mut self, line: u32, number: u32) {
        // Behind a tool change the control looks where the axes are.
        for slot in (0..SLOTS).filter(|slot| self.restated >> slot & 1 == 1) {
            if let (Some(place), Some(beside)) = (self.place.get_mut(slot), self.beside.get(slot)) {
                *place = *beside;
            }
        }
        self.restated = 0;
        self.tools.push(number);
        self.steps.push_back(Step::Tool { line, number });
    }

    /// Emits the present state of the spindle.
    pub(super) fn spindle(&mut self, line: u32) {
        // The sign is the sense of rotation: M3 positive, M4 negative, M5 zero.
        let [x, ..] = self.xyz;
        let speed = self.spindle_speed(self.reading(x)).unwrap_or(self.speed);
        let speed = f64::from(self.sense) * speed;
        self.steps.push_back(Step::Spindle { line, speed });
    }

    /// Emits the distance that the control may keep from the path.
    pub(super) fn smooth(&mut self, line: u32, smoothing: Smoothing) {
        self.steps.push_back(Step::Smoothing { line, smoothing });
    }

    /// Emits the entry of the table of tool lengths.
    pub(super) fn choose_length(&mut self, line: u32, entry: LengthEntry) {
        self.steps.push_back(Step::LengthEntry { line, entry });
    }

    /// Returns the speed of the spindle \[1/min\] at a position of X, which a constant cutting speed
    /// depends on.
    pub(super) fn spindle_speed(&self, x: Option<f64>) -> Option<f64> {
        let Some(SurfaceSpeed { most }) = self.surface else { return Some(self.speed) };
        // S in m/min or ft/min, over the circumference in mm.
        let unit = if self.inch { 12.0 * INCH } else { 1000.0 };
        let turns = x.map(|x| unit * self.speed / (std::f64::consts::TAU * x.abs()));
        match (turns.filter(|turns| turns.is_finite()), most) {
            (Some(turns), Some(most)) => Some(turns.min(most)),
            (turns, most) => turns.or(most),
        }
    }

    /// Keeps words without motion.
    pub(super) fn keep(&mut self, line: u32, text: &str) {
        self.steps.push_back(Step::Words { line, text: text.trim().into() });
    }
}
