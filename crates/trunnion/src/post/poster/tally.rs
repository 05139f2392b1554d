//! Times and axis load of a program.

use crate::machine::Kinematics;
use crate::nc::write::Style;
use crate::post::timing::{AxisLoad, ControlClock};
use crate::types::AxisVector;

/// Times and axis load of the input or of the output.
#[derive(Debug)]
pub(super) struct FeedTally {
    pub(super) load: AxisLoad,
    /// Time with feed \[s\].
    pub(super) seconds: f64,
    /// Clock of the cuts, each from rest to rest.
    pub(super) cuts: ControlClock,
    /// Clock of everything.
    pub(super) clock: ControlClock,
    cutting: bool,
}

impl FeedTally {
    pub(super) fn new(kinematics: &Kinematics, style: &Style) -> Self {
        let machine = kinematics.machine();
        let (load, clock) = (AxisLoad::new(machine), ControlClock::new(machine, style));
        Self { load, seconds: 0.0, cuts: clock.clone(), clock, cutting: false }
    }

    /// Counts a rapid move whose words change by `words` \[mm, rad\]; before it the axes come to rest.
    pub(super) fn rapid(&mut self, words: &AxisVector) {
        self.rest();
        self.clock.rapid(words);
    }

    /// Counts a feed move of the axes, whose ends may be off by `error`.
    pub(super) fn block(&mut self, travel: &AxisVector, error: &AxisVector, seconds: f64) {
        self.cutting = true;
        self.seconds += seconds;
        self.load.push(travel, error, seconds);
    }

    /// Brings the axes to rest behind a cut.
    pub(super) fn rest(&mut self) {
        if self.cutting {
            self.load.rest();
        }
        self.cuts.stop();
        self.cutting = false;
    }

    /// Brings the axes and the control to rest, as words do for which it waits.
    pub(super) fn stop(&mut self) {
        self.rest();
        self.clock.stop();
    }

    /// Brings the control to rest, as a tool change does.
    pub(super) fn stop_clock(&mut self) {
        self.clock.stop();
    }

    /// Counts a feed move on the control.
    pub(super) fn feed(&mut self, words: &AxisVector, seconds: f64) {
        ControlClock::feed_both([&mut self.cuts, &mut self.clock], words, seconds);
    }
}
