//! Drilling cycles of Sinumerik as the moves they consist of.

use super::cycle::{CycleDwell, CycleKind, CyclePecks, SiemensCycle};
use super::reader::SiemensReader;
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step, Way};

/// Strokes of one hole beyond which a value is taken for a slip.
const MOST_STROKES: usize = 10_000;

/// A hole at the present place.
struct SiemensHole {
    /// Slots of the plane, and of the drill axis.
    slots: [usize; 3],
    line: u32,
    at: usize,
    column: u32,
}

impl SiemensReader {
    /// Drills at the present place.
    pub(super) fn drill(
        &self,
        state: &mut ReaderState,
        cycle: &SiemensCycle,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let axes = match self.plane {
            1 => [2, 0, 1],
            2 => [1, 2, 0],
            _ => [0, 1, 2],
        };
        let slots = axes.map(|axis: usize| state.control.xyz[axis]);
        let (line, at) = (state.log.line, cycle.at);
        let hole = SiemensHole { slots, line, at, column: column(code, at) };
        hole.rapid(state, cycle.start)?;
        match cycle.kind {
            CycleKind::Drill => {
                hole.feed(state, cycle.bottom, 1.0)?;
                hole.wait(state, cycle.dwell)?;
            }
            CycleKind::Pecks(pecks) => hole.pecks(state, cycle, &pecks)?,
            CycleKind::Tap { .. } => hole.tap(state, cycle)?,
            CycleKind::Ream { feeds: [down, out] } => {
                let down = hole.pace_at(state, cycle.bottom, down)?;
                hole.go(state, cycle.bottom, down)?;
                hole.wait(state, cycle.dwell)?;
                let out = hole.pace_at(state, cycle.start, out)?;
                hole.go(state, cycle.start, out)?;
            }
            CycleKind::Bore { .. } => return hole.bore(state, cycle),
            CycleKind::Stop => {
                hole.feed(state, cycle.bottom, 1.0)?;
                hole.wait(state, cycle.dwell)?;
                state.control.sense = 0;
                state.control.spindle(line);
                state.control.keep(line, "M0");
            }
            CycleKind::FeedOut => {
                hole.feed(state, cycle.bottom, 1.0)?;
                hole.wait(state, cycle.dwell)?;
                hole.feed(state, cycle.start, 1.0)?;
            }
        }
        hole.rapid(state, cycle.retract)
    }
}

impl SiemensHole {
    fn target(&self, height: f64) -> MoveTarget {
        let mut target = MoveTarget::new(self.at, self.column);
        target.set(self.slots[2], height, DistanceMode::Absolute);
        target
    }

    /// Moves the drill axis, if it is not there.
    fn go(&self, state: &mut ReaderState, height: f64, pace: Pace) -> Result<(), ReadRemark> {
        let stood = state.control.reading(self.slots[2]);
        if stood.is_some_and(|stood| (stood - height).abs() < 1e-9) {
            return Ok(());
        }
        state.control.go(self.line, self.target(height), pace, Way::Line)
    }

    fn rapid(&self, state: &mut ReaderState, height: f64) -> Result<(), ReadRemark> {
        self.go(state, height, Pace::Rapid)
    }

    /// Moves with a share of the active feed.
    fn feed(&self, state: &mut ReaderState, height: f64, share: f64) -> Result<(), ReadRemark> {
        let pace = match state.control.pace(&self.target(height), None)? {
            Pace::PerMinute { speed } => Pace::PerMinute { speed: share * speed },
            other => other,
        };
        self.go(state, height, pace)
    }

    /// Returns the pace of a feed of the cycle; zero: of the active one.
    fn pace_at(&self, state: &mut ReaderState, height: f64, feed: f64) -> Result<Pace, ReadRemark> {
        let active = state.control.feed;
        if feed > 0.0 {
            state.control.feed = Some(feed);
        }
        let pace = state.control.pace(&self.target(height), None);
        state.control.feed = active;
        pace
    }

    fn wait(&self, state: &mut ReaderState, dwell: CycleDwell) -> Result<(), ReadRemark> {
        let seconds = match dwell {
            CycleDwell::Seconds(seconds) => seconds,
            CycleDwell::Turns(turns) if turns <= 0.0 => 0.0,
            CycleDwell::Turns(turns) if state.control.speed > 0.0 => {
                60.0 * turns / state.control.speed
            }
            CycleDwell::Turns(_) => {
                let message = "a dwell in turns of a spindle without speed";
                return Err(ReadRemark::new(self.at, message, "write S before"));
            }
        };
        if seconds > 0.0 {
            let line = self.line;
            state.control.steps.push_back(Step::Dwell { line, seconds });
        }
        Ok(())
    }

    /// Drills in strokes.
    fn pecks(
        &self,
        state: &mut ReaderState,
        cycle: &SiemensCycle,
        pecks: &CyclePecks,
    ) -> Result<(), ReadRemark> {
        let total = cycle.reference - cycle.bottom;
        let depths = stroke_depths(total, pecks).ok_or_else(|| {
            let message = "CYCLE83: its strokes become too short to reach the bottom";
            ReadRemark::new(self.at, message, "look at _DAM and _MDEP")
        })?;
        // The manual: 0.6 mm up to a depth of 30 mm, then a fiftieth of it, 7 mm at most.
        let ahead = match pecks.ahead {
            ahead if ahead > 0.0 => ahead,
            _ if total <= 30.0 => 0.6,
            _ => (total / 50.0).min(7.0),
        };
        let last = depths.len().saturating_sub(1);
        for (at, depth) in depths.into_iter().enumerate() {
            let height = cycle.reference - depth;
            self.feed(state, height, if at == 0 { pecks.first_feed } else { 1.0 })?;
            if at == last {
                return self.wait(state, pecks.at_bottom);
            }
            self.wait(state, pecks.at_depth)?;
            if pecks.clears {
                self.rapid(state, cycle.start)?;
                self.wait(state, pecks.at_start)?;
                self.rapid(state, (height + ahead).min(cycle.start))?;
            } else {
                self.feed(state, height + pecks.back, 1.0)?;
            }
        }
        Ok(())
    }

    /// Taps a thread.
    fn tap(&self, state: &mut ReaderState, cycle: &SiemensCycle) -> Result<(), ReadRemark> {
        let CycleKind::Tap { pitch, speeds, after } = cycle.kind else { return Ok(()) };
        let Some(pitch) = pitch else {
            // A compensating chuck without a pitch follows the active feed.
            self.feed(state, cycle.bottom, 1.0)?;
            self.wait(state, cycle.dwell)?;
            return self.feed(state, cycle.start, 1.0);
        };
        let [down, out] = speeds;
        if down <= 0.0 {
            let message = "a thread at no speed of the spindle";
            return Err(ReadRemark::new(self.at, message, "write S, or SST"));
        }
        let along = |speed: f64| Pace::PerMinute { speed: pitch.abs() * speed / 60.0 };
        let line = self.line;
        let speed = down.copysign(pitch);
        state.control.steps.push_back(Step::Spindle { line, speed });
        self.go(state, cycle.bottom, along(down))?;
        self.wait(state, cycle.dwell)?;
        self.go(state, cycle.start, along(out))?;
        // 3, 4 and 5 are the M codes of the spindle; left out, it goes on as before.
        if (3.0..=5.0).contains(&after) {
            state.control.sense = i8::from(after < 3.5) - i8::from((3.5..4.5).contains(&after));
        }
        state.control.spindle(line);
        Ok(())
    }

    /// Bores, and draws the standing tool out beside the wall.
    fn bore(&self, state: &mut ReaderState, cycle: &SiemensCycle) -> Result<(), ReadRemark> {
        let CycleKind::Bore { aside, sense } = cycle.kind else { return Ok(()) };
        let line = self.line;
        if (3.0..=4.0).contains(&sense) {
            state.control.sense = if sense < 3.5 { 1 } else { -1 };
            state.control.spindle(line);
        }
        self.feed(state, cycle.bottom, 1.0)?;
        self.wait(state, cycle.dwell)?;
        let sense = std::mem::take(&mut state.control.sense);
        state.control.spindle(line);
        if aside.iter().any(|way| way.abs() > 0.0) {
            let mut target = MoveTarget::new(self.at, self.column);
            for (slot, way) in self.slots.into_iter().zip(aside) {
                target.set(slot, way, DistanceMode::Incremental);
            }
            state.control.go(line, target, Pace::Rapid, Way::Line)?;
        }
        self.rapid(state, cycle.start)?;
        // On the way to the retraction plane the axes of the plane return to the hole.
        let mut target = self.target(cycle.retract);
        for (slot, way) in self.slots.into_iter().zip(aside).take(2) {
            if way.abs() > 0.0 {
                target.set(slot, -way, DistanceMode::Incremental);
            }
        }
        state.control.go(line, target, Pace::Rapid, Way::Line)?;
        state.control.sense = sense;
        state.control.spindle(line);
        Ok(())
    }
}

/// Returns the depths of the strokes below the reference plane; `None`: they never reach the bottom.
fn stroke_depths(total: f64, pecks: &CyclePecks) -> Option<Vec<f64>> {
    let mut depths = Vec::new();
    let (mut depth, mut stroke) = (0.0, pecks.first);
    let least = match (pecks.least, pecks.decrease) {
        (least, _) if least > 0.0 => least,
        (_, decrease) => decrease.max(0.0),
    };
    while total - depth > 1e-9 {
        let left: f64 = total - depth;
        // At the shortest stroke the last two are equal, so that none is below half of it.
        let shortest = pecks.decrease > 0.0 && stroke <= least;
        if shortest && left > least && left < 2.0 * least && !depths.is_empty() {
            stroke = 0.5 * left;
        }
        depth = if left <= stroke * (1.0 + 1e-12) { total } else { depth + stroke };
        depths.push(depth);
        if depths.len() > MOST_STROKES || stroke <= 0.0 {
            return None;
        }
        stroke = match pecks.decrease {
            decrease if decrease > 0.0 => (stroke - decrease).max(least),
            decrease if decrease < 0.0 => (stroke * decrease.abs()).max(least),
            _ => stroke,
        };
    }
    Some(depths)
}
