//! Threads of `LinuxCNC`, whose feed follows the spindle: `G33`, `G33.1`, `G76`.

use super::block::GcodeBlock;
use super::reader::GcodeReader;
use super::words::natural;
use crate::math;
use crate::read::control::{ControlState, DistanceMode, MoveTarget};
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Way};

/// Ends of `G76` that are cut at an angle: bits of its L word.
const AT_ENTRY: u32 = 1;
const AT_EXIT: u32 = 2;

/// Passes of a thread; more are a slip.
const MOST_PASSES: u32 = 10_000;

/// Words of `G76`.
struct ThreadCycle {
    /// Position of X, Y and Z before the cycle \[mm\].
    start: [f64; 3],
    /// +1: depth grows along X, a bore; -1: against it.
    outward: f64,
    /// From the drive line to the crest.
    crest: f64,
    /// From the drive line to the full depth.
    full: f64,
    /// Height of the thread.
    height: f64,
    /// Speeds along the thread and along its ends \[mm/s\].
    pace: [Pace; 2],
    /// Length of an end that is cut at an angle, against Z.
    taper: f64,
    ends: u32,
    /// Tangent of the angle at which passes move along Z as they get deeper.
    slide: f64,
    /// Z at the end of the drive line.
    end: f64,
    target: MoveTarget,
    line: u32,
}

impl GcodeReader {
    /// Runs `G76`: passes along Z that get deeper along X.
    pub(super) fn thread_cycle(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        target: MoveTarget,
    ) -> Result<(), ReadRemark> {
        let scale = state.control.scale();
        // In diameter mode (G7) depths are differences of diameters.
        let depth_scale = if self.modal.diameter { 0.5 * scale } else { scale };
        let mut length =
            |letter: char, scale: f64| block.take(letter).map(|word| scale * word.value);
        let depths = ['I', 'J', 'K'].map(|letter| length(letter, depth_scale));
        let ([Some(peak), Some(first), Some(height)], Some(pitch)) = (depths, length('P', scale))
        else {
            let message = "G76 without P, I, J and K";
            let help = "write pitch, offset of the crest, first depth and height of the thread";
            return Err(ReadRemark::new(target.at, message, help));
        };
        let (degression, angle) = (length('R', 1.0), length('Q', 1.0).unwrap_or(0.0));
        let taper = length('E', scale).unwrap_or(0.0).max(0.0);
        let springs = block.take('H').map_or(Ok(0), |word| natural(word, 'H'))?;
        let ends = block.take('L').map_or(Ok(0), |word| natural(word, 'L'))?;
        if peak.abs() <= 0.0 || first <= 0.0 || height <= first || !(peak + pitch).is_finite() {
            let message = "G76 needs I other than 0, J above 0 and K above J";
            return Err(ReadRemark::new(target.at, message, "look at its depths"));
        }
        let places = state.control.xyz.map(|slot| state.control.reading(slot));
        let [Some(x), Some(y), Some(z)] = places else { return Err(unknown(target.at)) };
        let end = thread_end(&state.control, &target, [x, y, z]);
        let backward = if end[2] > z { -1.0 } else { 1.0 };
        let steeper = if taper > 0.0 { math::hypot(taper, height) / taper } else { 1.0 };
        let cycle = ThreadCycle {
            start: [x, y, z],
            outward: peak.signum(),
            crest: peak.abs(),
            full: peak.abs() + height,
            height,
            pace: [
                thread_pace(&state.control, pitch, target.at)?,
                thread_pace(&state.control, pitch * steeper, target.at)?,
            ],
            taper: backward * taper,
            ends: if taper > 0.0 { ends } else { 0 },
            slide: math::tan(backward * angle.to_radians()),
            end: end[2] + height * math::tan(backward * angle.to_radians()),
            target,
            line: state.log.line,
        };
        // Depth grows with the root of the pass, so that every pass cuts as much.
        let root = 1.0 / degression.unwrap_or(1.0).max(1.0);
        let mut pass = 1_u32;
        let mut depth = cycle.crest + first;
        while depth < cycle.full {
            if pass > MOST_PASSES || !self.may_repeat(state, "") {
                let message = format!("G76 with more than {MOST_PASSES} passes");
                return Err(ReadRemark::new(cycle.target.at, message, "look at J and R"));
            }
            cycle.pass(state, depth)?;
            pass += 1;
            depth = cycle.crest + first * math::powf(f64::from(pass), root);
        }
        for _ in 0..=springs.min(MOST_PASSES) {
            cycle.pass(state, cycle.full)?;
        }
        cycle.go(state, end, Pace::Rapid)
    }
}

/// Runs `G33 Z K`: a straight move of K per revolution; `G33.1` also returns.
pub(super) fn cut_thread(
    state: &mut ReaderState,
    block: &mut GcodeBlock,
    target: MoveTarget,
    code: u32,
) -> Result<(), ReadRemark> {
    let scale = state.control.scale();
    let Some(pitch) = block.take('K').map(|word| scale * word.value) else {
        return Err(ReadRemark::new(
            target.at,
            "a thread without K",
            "write the travel of a revolution",
        ));
    };
    let pace = thread_pace(&state.control, pitch, target.at)?;
    let line = state.log.line;
    if code == 330 {
        return state.control.go(line, target, pace, Way::Line);
    }
    // I is how many times faster it returns.
    let faster = block.take('I').map_or(1.0, |word| word.value);
    if faster <= 0.0 || faster.is_nan() {
        return Err(ReadRemark::new(target.at, "G33.1 with I that is not above 0", "leave I out"));
    }
    // Rigid tapping: the tap goes back the same way, behind which the position is that before.
    let mut back = MoveTarget::new(target.at, target.column);
    for slot in 0..target.words.len() {
        let Some(word) = target.get(slot) else { continue };
        if target.is_incremental(slot) {
            back.set(slot, -word, DistanceMode::Incremental);
        } else {
            let stood = state.control.reading(slot).ok_or_else(|| unknown(target.at))?;
            back.set(slot, stood, DistanceMode::Absolute);
        }
    }
    state.control.go(line, target, pace, Way::Line)?;
    let pace = thread_pace(&state.control, faster * pitch, target.at)?;
    state.control.go(line, back, pace, Way::Line)
}

impl ThreadCycle {
    /// Cuts along the thread at a depth under the drive line.
    fn pass(&self, state: &mut ReaderState, depth: f64) -> Result<(), ReadRemark> {
        let [x, y, z] = self.start;
        // Passes move along Z so that the tool cuts on one flank.
        let along = (depth - self.crest) * self.slide;
        let at = |depth: f64| x + self.outward * depth;
        let clear = at(depth - self.full);
        let near = at(depth - self.height);
        let [thread, taper] = self.pace;
        let far = self.end - along;
        self.go(state, [clear, y, z - along], Pace::Rapid)?;
        if self.ends & AT_ENTRY != 0 {
            self.go(state, [near, y, z - along], taper)?;
            self.go(state, [at(depth), y, z - along - self.taper], taper)?;
        } else {
            self.go(state, [at(depth), y, z - along], Pace::Rapid)?;
        }
        if self.ends & AT_EXIT != 0 {
            self.go(state, [at(depth), y, far + self.taper], thread)?;
            self.go(state, [near, y, far], taper)?;
        } else {
            self.go(state, [at(depth), y, far], thread)?;
        }
        self.go(state, [clear, y, far], Pace::Rapid)
    }

    fn go(&self, state: &mut ReaderState, to: [f64; 3], pace: Pace) -> Result<(), ReadRemark> {
        let mut target = MoveTarget::new(self.target.at, self.target.column);
        for (slot, value) in state.control.xyz.into_iter().zip(to) {
            target.set(slot, value, DistanceMode::Absolute);
        }
        state.control.go(self.line, target, pace, Way::Line)
    }
}

/// Returns the speed of a feed of `pitch` \[mm\] per revolution.
fn thread_pace(control: &ControlState, pitch: f64, at: usize) -> Result<Pace, ReadRemark> {
    let [x, ..] = control.xyz;
    let speed = control.spindle_speed(control.reading(x)).filter(|speed| *speed > 0.0);
    if let Some(speed) = speed.filter(|_| control.sense != 0 && pitch.abs() > 0.0) {
        return Ok(Pace::PerMinute { speed: pitch.abs() * speed / 60.0 });
    }
    let message = "a thread with a spindle that stands, or without a pitch";
    Err(ReadRemark::new(at, message, "write S and M3 before it"))
}

/// Returns the end of the drive line.
fn thread_end(control: &ControlState, target: &MoveTarget, start: [f64; 3]) -> [f64; 3] {
    let mut end = start;
    for (end, slot) in end.iter_mut().zip(control.xyz) {
        match target.get(slot) {
            Some(word) if target.is_incremental(slot) => *end += word,
            Some(word) => *end = word,
            None => {}
        }
    }
    end
}

fn unknown(at: usize) -> ReadRemark {
    let message = "a thread from a position that the program does not state";
    ReadRemark::new(at, message, "program X, Y and Z absolutely before it")
}
