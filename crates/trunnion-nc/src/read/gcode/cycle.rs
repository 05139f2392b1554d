//! Drilling cycles as the moves they consist of.

use super::block::{CodeWord, GcodeBlock};
use super::modal::{BlockActions, CycleState, GcodeMotion};
use super::reader::GcodeReader;
use super::words::{natural, not_understood};
use crate::math;
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::dialect::Dialect;
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step, Way};
use std::f64::consts::TAU;

/// So far above the last depth a peck begins, and so far a chip-breaking drill is drawn back \[mm\]:
/// a hundredth of an inch, as `LinuxCNC`'s interpreter has it.
const CLEARANCE: f64 = 0.254;

/// One hole.
pub(super) struct DrilledHole {
    pub(super) code: u32,
    pub(super) line: u32,
    /// Slot of the drill axis.
    pub(super) axis: usize,
    r: f64,
    bottom: f64,
    /// Height to which the tool retracts.
    pub(super) clear: f64,
    pub(super) feed: Pace,
    /// Factor of the feed out of a thread.
    faster: f64,
    pub(super) at: usize,
    pub(super) column: u32,
}

impl GcodeReader {
    /// Applies `G81` and so on; a series of holes begins.
    pub(super) fn cycle_code(
        &mut self,
        code: CodeWord,
        now: &mut BlockActions,
    ) -> Result<u32, ReadRemark> {
        if self.dialect == Dialect::LinuxCnc && code.tenths == 880 {
            let message = "G88: the operator draws the tool back by hand";
            return Err(ReadRemark::new(code.at, message, "use G86 or G89"));
        }
        let back_boring = self.dialect == Dialect::LinuxCnc && code.tenths == 870;
        if matches!(code.tenths, 870 | 880) && !back_boring || !code.tenths.is_multiple_of(10) {
            return Err(not_understood(code, "", self.dialect)
                .with(format!("cycle G{} is not understood", code.tenths / 10)));
        }
        // A new series forgets R, Z, P and Q; within a series they are modal.
        if !matches!(self.modal.motion, Some(GcodeMotion::Cycle(_))) {
            self.modal.cycle = CycleState::default();
            self.modal.before_cycle = self.modal.motion;
        }
        self.modal.motion = Some(GcodeMotion::Cycle(code.tenths));
        now.motion = true;
        Ok(1 << 1)
    }

    /// Drills a block's holes.
    pub(super) fn cycle(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        mut target: MoveTarget,
        code: u32,
    ) -> Result<(), ReadRemark> {
        let (axes, _) = self.plane();
        let [_, _, axis] = axes.map(|axis| state.control.xyz[axis]);
        let stood = state.control.reading(axis);
        // The initial level of G98 is the height before the first hole of the series.
        if !self.modal.cycle.running {
            self.modal.cycle.initial = stood;
            self.modal.cycle.running = true;
        }
        self.parameters_of_cycle(state, block, &target, axis)?;
        // The word of the drill axis is the depth, not a target of the approach.
        if let Some(word) = target.words.get_mut(axis) {
            *word = None;
        }
        target.incremental &= !(1 << axis);
        // Repetitions: L in LinuxCNC and at Haas, K at Fanuc; K0 and L0 only store the data.
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        let fanuc = self.dialect == Dialect::Fanuc;
        let times = block.take('L').or_else(|| if fanuc { block.take('K') } else { None });
        let times = times.map_or(Ok(1), |word| natural(word, 'L'))?;
        // A rigid tap (M29) turns the spindle itself.
        let sense = state.control.sense;
        if !linuxcnc && matches!(code, 740 | 840) && sense == 0 {
            state.control.sense = 1;
        }
        let hole = self.hole(state, &target, code, axis);
        state.control.sense = sense;
        let mut hole = hole?;
        // Haas: a thread is left so many times faster.
        if self.dialect == Dialect::Haas && matches!(code, 740 | 840) {
            hole.faster = block.take('J').map_or(1.0, |word| word.value.max(1.0));
        }
        // Without distances (G91) every control drills the same hole again and again.
        let count = times;
        let wide = self.back_boring(state, block, code)?;
        let polar = std::mem::take(&mut block.polar);
        for _ in 0..count {
            if !self.may_repeat(state, "") {
                return Ok(());
            }
            if self.dialect == Dialect::LinuxCnc {
                let mut target = target;
                if !polar.is_empty() {
                    self.polar_end(&state.control, &polar, &mut target)?;
                }
                self.linuxcnc_approach(state, &target, &hole)?;
            } else {
                approach(state, &target, &hole)?;
            }
            match wide {
                Some(wide) => hole.bore_back(state, &wide)?,
                None => self.drill(state, &mut hole)?,
            }
        }
        Ok(())
    }

    /// Takes I J K of `G87`; they stay from hole to hole.
    fn back_boring(
        &mut self,
        state: &ReaderState,
        block: &mut GcodeBlock,
        code: u32,
    ) -> Result<Option<BackBoring>, ReadRemark> {
        if code != 870 {
            return Ok(None);
        }
        let scale = state.control.scale();
        for (letter, known) in ['I', 'J', 'K'].into_iter().zip(&mut self.modal.cycle.back) {
            let word = block.take(letter).map(|word| scale * word.value);
            *known = word.or(*known);
        }
        // I J K belong to X Y Z: two of them move aside, that of the drill axis is the upper end.
        let (axes, _) = self.plane();
        let [u, v, along] = axes.map(|axis| self.modal.cycle.back.get(axis).copied().flatten());
        let (Some(u), Some(v), Some(top)) = (u, v, along) else {
            let message = "G87 without I, J and K";
            return Err(ReadRemark::new(
                0,
                message,
                "write how far to move aside, and up to which height",
            ));
        };
        let [slot_u, slot_v, _] = axes.map(|axis| state.control.xyz[axis]);
        Ok(Some(BackBoring {
            aside: [(slot_u, u), (slot_v, v)],
            top,
            from_bottom: self.modal.distance == DistanceMode::Incremental,
        }))
    }

    /// Moves over a hole and down to R in the order of `LinuxCNC`'s interpreter.
    fn linuxcnc_approach(
        &self,
        state: &mut ReaderState,
        target: &MoveTarget,
        hole: &DrilledHole,
    ) -> Result<(), ReadRemark> {
        // The level before the series decides, not the present one.
        if self.modal.cycle.initial.is_none_or(|initial| initial < hole.r)
            && state.control.reading(hole.axis).is_none_or(|stood| stood < hole.r)
        {
            hole.go(state, hole.r, Pace::Rapid)?;
        }
        let stood = state.control.reading(hole.axis);
        let mut over = *target;
        // From R, where G99 left it, to the level of G98 it goes on the way over the hole.
        if stood.is_some_and(|stood| stood <= hole.r && stood < hole.clear) {
            over.set(hole.axis, hole.clear, DistanceMode::Absolute);
        }
        if !over.is_empty() {
            state.control.go(hole.line, over, Pace::Rapid, Way::Line)?;
        }
        hole.go(state, hole.r, Pace::Rapid)
    }

    /// Takes R, Z, Q and P where written; the others stay.
    fn parameters_of_cycle(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        target: &MoveTarget,
        axis: usize,
    ) -> Result<(), ReadRemark> {
        let scale = state.control.scale();
        let stood = state.control.reading(axis);
        let incremental = self.modal.distance == DistanceMode::Incremental;
        if let Some(word) = block.take('R') {
            // G91: R counts from the current height, the depth from R (RS274/NGC).
            let counts = incremental && self.dialect != Dialect::LinuxCnc;
            let from = if counts { stood } else { Some(0.0) };
            let from = from.ok_or_else(|| unknown_height(word.at))?;
            self.modal.cycle.r = Some(from + scale * word.value);
        }
        // P of a cycle is a dwell, in the unit of G4.
        if let Some(word) = block.take('P') {
            self.modal.cycle.dwell = self.dwell_seconds(word);
        }
        if let Some(word) = block.take('Q') {
            let depth = scale * word.value;
            if !(depth > 0.0 && depth.is_finite()) {
                return Err(ReadRemark::new(
                    word.at,
                    "a peck that goes no deeper",
                    "Q must be above 0",
                ));
            }
            self.modal.cycle.q = Some(depth);
        }
        self.shrinking_pecks(block, scale)?;
        let cycle = &mut self.modal.cycle;
        // LinuxCNC keeps the words, and adds them up anew for every hole.
        if self.dialect == Dialect::LinuxCnc {
            cycle.z = target.get(axis).or(cycle.z);
            return Ok(());
        }
        if let Some(depth) = target.get(axis) {
            let from = if incremental { cycle.r } else { Some(0.0) };
            let from = from.ok_or_else(|| unknown_height(target.at))?;
            cycle.z = Some(from + depth);
        }
        Ok(())
    }

    /// Takes I J K of `G83` at Haas: the first peck, by how much each is less, and the least.
    fn shrinking_pecks(&mut self, block: &mut GcodeBlock, scale: f64) -> Result<(), ReadRemark> {
        let pecks = self.modal.motion == Some(GcodeMotion::Cycle(830));
        if !pecks || self.dialect != Dialect::Haas {
            return Ok(());
        }
        let Some(first) = block.take('I') else { return Ok(()) };
        let [less, least] = ['J', 'K'].map(|letter| block.take(letter).map(|word| word.value));
        let (Some(less), Some(least)) = (less, least.filter(|least| *least > 0.0)) else {
            let message = "G83 with I, without J or K";
            return Err(ReadRemark::new(first.at, message, "write all three, or Q"));
        };
        if first.value <= 0.0 {
            let message = "a peck that goes no deeper";
            return Err(ReadRemark::new(first.at, message, "I must be above 0"));
        }
        self.modal.cycle.q = Some(scale * first.value);
        self.modal.cycle.shrinks = Some([scale * less.max(0.0), scale * least]);
        Ok(())
    }

    /// Runs `G70` and `G71` of Haas: the active cycle at holes on a circle about the tool.
    pub(super) fn bolt_circle(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        place: CodeWord,
    ) -> Result<(), ReadRemark> {
        let refused = |message: &str, help: &str| Err(ReadRemark::new(place.at, message, help));
        let Some(GcodeMotion::Cycle(code)) = self.modal.motion else {
            return refused("a circle of holes without a cycle", "write G81 .. L0 before it");
        };
        let scale = state.control.scale();
        let [radius, start, apart] = ['I', 'J', 'K'].map(|letter| block.take(letter));
        let number = block.take('L').map(|word| natural(word, 'L')).transpose()?;
        let (Some(radius), Some(number)) = (radius, number.filter(|number| *number > 0)) else {
            return refused("a circle of holes without I or L", "write radius and number");
        };
        let radius = scale * radius.value;
        // G70 shares the whole circle, G71 states the angle between holes.
        let apart = match (place.tenths, apart) {
            (700, _) => TAU / f64::from(number),
            (_, Some(apart)) => apart.value.to_radians(),
            _ => return refused("G71 without K", "write the angle between the holes"),
        };
        let start = start.map_or(0.0, |word| word.value.to_radians());
        let (axes, _) = self.plane();
        let slots = [axes[0], axes[1]].map(|axis| state.control.xyz[axis]);
        let [Some(u), Some(v)] = slots.map(|slot| state.control.reading(slot)) else {
            return refused(
                "a circle of holes about a place that is not stated",
                "write X and Y before",
            );
        };
        for index in 0..number {
            if !self.may_repeat(state, text) {
                return Ok(());
            }
            let (sin, cos) = math::sin_cos(start + f64::from(index) * apart);
            let mut target = MoveTarget::new(place.at, column(text, place.at));
            target.set(slots[0], u + radius * cos, DistanceMode::Absolute);
            target.set(slots[1], v + radius * sin, DistanceMode::Absolute);
            self.cycle(state, &mut GcodeBlock::new(), target, code)?;
        }
        Ok(())
    }

    /// Returns the hole that the parameters make.
    fn hole(
        &self,
        state: &ReaderState,
        target: &MoveTarget,
        code: u32,
        axis: usize,
    ) -> Result<DrilledHole, ReadRemark> {
        let cycle = &self.modal.cycle;
        // R and Z are modal, so only the first hole must have them.
        let (Some(r), Some(bottom)) = (cycle.r, cycle.z) else {
            let message = "a cycle without R and depth";
            return Err(ReadRemark::new(target.at, message, "write both on its first line"));
        };
        let (r, bottom) = if self.dialect == Dialect::LinuxCnc
            && self.modal.distance == DistanceMode::Incremental
        {
            // G91: R counts from the level before the series, the depth from R.
            let initial = cycle.initial.ok_or_else(|| unknown_height(target.at))?;
            (initial + r, initial + r + bottom)
        } else {
            (r, bottom)
        };
        if bottom > r {
            let message = format!("the bottom {bottom} mm is above the retract level {r} mm");
            return Err(ReadRemark::new(target.at, message, "look at R and the depth"));
        }
        // G99: retract to R. G98: to the initial level, unless R lies above it.
        let clear = if self.modal.to_r {
            r
        } else {
            let initial = cycle.initial.ok_or_else(|| unknown_height(target.at))?;
            initial.max(r)
        };
        // The feed depends on the axes that move: here the drill axis alone.
        let mut down = MoveTarget::new(target.at, target.column);
        down.set(axis, bottom, DistanceMode::Absolute);
        let feed = state.control.pace(&down, None)?;
        let (line, at, column) = (state.log.line, target.at, target.column);
        Ok(DrilledHole { code, line, axis, r, bottom, clear, feed, faster: 1.0, at, column })
    }

    /// Drills a hole and retracts.
    fn drill(&mut self, state: &mut ReaderState, hole: &mut DrilledHole) -> Result<(), ReadRemark> {
        let (feed, line) = (hole.feed, hole.line);
        // G73 and G83 peck before the last cut to the bottom.
        if matches!(hole.code, 730 | 830) && !self.peck(state, hole)? {
            return Ok(());
        }
        let swapped = self.swapped_axes(state, hole);
        match &swapped {
            Some(swapped) => swapped.feed(state, hole, hole.bottom)?,
            None => hole.go(state, hole.bottom, feed)?,
        }
        let dwells = match hole.code {
            // G82 and G89 always dwell; G86 and the tapping cycles G74 and G84 only with P.
            820 | 890 => true,
            860 | 740 | 840 => self.modal.cycle.dwell > 0.0,
            _ => false,
        };
        if dwells {
            let seconds = self.modal.cycle.dwell;
            state.control.steps.push_back(Step::Dwell { line, seconds });
        }
        // G74, G84 (tapping), G85 and G89 (boring) come out with the feed, at least to R; the
        // others in rapid.
        if matches!(hole.code, 740 | 840 | 850 | 890) {
            // LinuxCNC feeds all the way out.
            let all = self.dialect == Dialect::LinuxCnc;
            if let Some(swapped) = swapped {
                swapped.feed(state, hole, hole.clear)?;
                swapped.end(state, hole);
                return Ok(());
            }
            let out = match feed {
                Pace::PerMinute { speed } => Pace::PerMinute { speed: hole.faster * speed },
                other => other,
            };
            hole.go(state, if all { hole.clear } else { hole.r }, out)?;
        }
        hole.go(state, hole.clear, Pace::Rapid)
    }

    /// Drills all pecks but the last; returns false if no further line may run.
    fn peck(&mut self, state: &mut ReaderState, hole: &DrilledHole) -> Result<bool, ReadRemark> {
        let Some(step) = self.modal.cycle.q else {
            return Err(ReadRemark::new(hole.at, "pecking without Q", "write the depth of a peck"));
        };
        let (mut depth, mut step) = (hole.r, step);
        // Heights of the pecks: R - Q, R - 2 Q and so on, above the bottom.
        while depth - step > hole.bottom {
            if !self.may_repeat(state, "") {
                return Ok(false);
            }
            depth -= step;
            hole.go(state, depth, hole.feed)?;
            // G83 clears the chips at R; G73 only breaks them on its way.
            if hole.code == 830 {
                hole.go(state, hole.r, Pace::Rapid)?;
            }
            // LinuxCNC goes above R if a peck is shorter than the clearance.
            let near = depth + CLEARANCE;
            let above = self.dialect == Dialect::LinuxCnc;
            hole.go(state, if above { near } else { near.min(hole.r) }, Pace::Rapid)?;
            if let Some([less, least]) = self.modal.cycle.shrinks {
                step = (step - less).max(least);
            }
        }
        Ok(true)
    }
}

/// Moves of `G87`: aside, down, back over the hole, up with the feed, and out the same way.
#[derive(Clone, Copy)]
struct BackBoring {
    /// Slots of the plane, with the distances aside.
    aside: [(usize, f64); 2],
    /// Upper end of the bore.
    top: f64,
    /// It counts from the bottom: `G91`.
    from_bottom: bool,
}

impl DrilledHole {
    /// Bores back, after the approach.
    fn bore_back(&self, state: &mut ReaderState, wide: &BackBoring) -> Result<(), ReadRemark> {
        let top = if wide.from_bottom { self.bottom + wide.top } else { wide.top };
        let sideways = |state: &mut ReaderState, sign: f64| {
            let mut target = MoveTarget::new(self.at, self.column);
            for (slot, distance) in wide.aside {
                target.set(slot, sign * distance, DistanceMode::Incremental);
            }
            state.control.go(self.line, target, Pace::Rapid, Way::Line)
        };
        sideways(state, 1.0)?;
        self.go(state, self.bottom, Pace::Rapid)?;
        sideways(state, -1.0)?;
        self.go(state, top, self.feed)?;
        self.go(state, self.bottom, self.feed)?;
        sideways(state, 1.0)?;
        self.go(state, self.clear, Pace::Rapid)?;
        sideways(state, -1.0)
    }

    /// Moves the drill axis, if it is not there.
    fn go(&self, state: &mut ReaderState, to: f64, pace: Pace) -> Result<(), ReadRemark> {
        let stood = state.control.reading(self.axis);
        // A move of no length would count as a block.
        if stood.is_some_and(|stood| (stood - to).abs() <= 0.0) {
            return Ok(());
        }
        let mut target = MoveTarget::new(self.at, self.column);
        target.set(self.axis, to, DistanceMode::Absolute);
        state.control.go(self.line, target, pace, Way::Line)
    }
}

/// Moves over the hole and down to R.
fn approach(
    state: &mut ReaderState,
    target: &MoveTarget,
    hole: &DrilledHole,
) -> Result<(), ReadRemark> {
    // RS274/NGC: up to R if below it, then over the hole, then down to R.
    if state.control.reading(hole.axis).is_some_and(|stood| stood < hole.r) {
        hole.go(state, hole.r, Pace::Rapid)?;
    }
    if !target.is_empty() {
        state.control.go(hole.line, *target, Pace::Rapid, Way::Line)?;
    }
    hole.go(state, hole.r, Pace::Rapid)
}

fn unknown_height(at: usize) -> ReadRemark {
    let message = "a cycle from a height that the program does not state";
    ReadRemark::new(at, message, "program the drill axis absolutely before it, or write G99")
}
