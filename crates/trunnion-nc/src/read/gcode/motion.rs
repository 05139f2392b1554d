//! Moves that a block's axis words make.

use super::block::{BlockWord, CodeWord, GcodeBlock};
use super::modal::{BlockActions, GcodeMotion};
use super::reader::GcodeReader;
use super::thread::cut_thread;
use crate::read::control::{DistanceMode, LARGEST, MoveTarget};
use crate::read::dialect::Dialect;
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step, Way};
use nalgebra::{UnitVector3, Vector3};

/// Letters of axes.
const AXES: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

impl GcodeReader {
    /// Runs the motion of the block, if it programs one.
    pub(super) fn motion(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        if let Some(at) = now.dwells {
            self.wait(state, block, at)?;
        }
        // Such a code uses the axis words itself: nothing moves by the modal motion.
        if let Some((code, at)) = now.nonmodal {
            if code == 53 {
                return self.end_spline(state, now, at);
            }
            return self.nonmodal(state, block, text, code, at);
        }
        if self.modal.spline.is_open() && !matches!(self.modal.motion, Some(GcodeMotion::Spline)) {
            let message = "control points of a spline (G5.2) without their end (G5.3)";
            return Err(ReadRemark::new(0, message, "write G5.3 before another motion"));
        }
        // Without words left, a motion code of this block or G53, nothing is to be moved.
        if block.none_left() && !now.motion && !now.machine {
            return Ok(());
        }
        let polar_words = self.polar_words(state, block)?;
        let mut target = self.target(state, block, text)?;
        if let Some(end) = polar_words {
            end.apply(&mut target, text);
        }
        // G53: the words are axis positions.
        target.machine = now.machine;
        // A cycle under G91 moves on from hole to hole.
        let drills = matches!(self.modal.motion, Some(GcodeMotion::Cycle(_)));
        let steps = drills && self.modal.distance == DistanceMode::Incremental;
        if !block.polar.is_empty() && !steps {
            let polar = std::mem::take(&mut block.polar);
            self.polar_end(&state.control, &polar, &mut target)?;
            target.column = column(text, target.at);
        }
        // G43.5: I J K are the tool axis, except of arcs, where they would be the centre.
        if self.modal.vector
            && block.has_any("IJK")
            && !matches!(self.modal.motion, Some(GcodeMotion::Arc(_)))
        {
            target.axis = Some(vector(block, &target)?);
        }
        // A full circle has no axis words, and a repeated hole may have R alone.
        let also = match self.modal.motion {
            Some(GcodeMotion::Arc(_)) => "IJKR",
            Some(GcodeMotion::Cycle(_)) => "R",
            Some(GcodeMotion::Spline) => "P",
            _ => "",
        };
        let moves = !target.is_empty() || block.has_any(also) || !block.polar.is_empty();
        if now.machine {
            if !moves {
                let help = "name the axes that are to move";
                return Err(ReadRemark::new(0, "G53 without axis words", help));
            }
            self.check_machine(state, &target)?;
        }
        if moves
            && std::mem::take(&mut self.modal.leaves_contour)
            && matches!(self.modal.motion, Some(GcodeMotion::Arc(_)))
        {
            let message = "an arc as the first move behind cutter compensation";
            return Err(ReadRemark::new(target.at, message, "lead out by a straight move"));
        }
        match self.modal.motion {
            Some(GcodeMotion::Cycle(code)) if moves || now.motion => {
                self.cycle(state, block, target, code)
            }
            _ if !moves => Ok(()),
            Some(GcodeMotion::Rapid | GcodeMotion::Feed) if self.is_compensating() => {
                self.contour_line(state, target, now)
            }
            Some(GcodeMotion::Spline) => self.spline(state, block, target, now),
            Some(GcodeMotion::Thread(760)) => self.thread_cycle(state, block, target),
            Some(GcodeMotion::Thread(code)) => cut_thread(state, block, target, code),
            Some(GcodeMotion::Probe(code)) => self.probe(state, target, now, code),
            Some(GcodeMotion::Rapid) => {
                state.control.go(state.log.line, target, Pace::Rapid, Way::Line)
            }
            Some(GcodeMotion::Feed) => {
                let pace = state.control.pace(&target, now.feed)?;
                state.control.go(state.log.line, target, pace, Way::Line)
            }
            Some(GcodeMotion::Arc(sense)) => self.arc(state, block, target, sense, now.feed),
            _ => {
                let message = "axis words without G0 or G1";
                Err(ReadRemark::new(target.at, message, "write G0 or G1 before them"))
            }
        }
    }

    /// Checks a move with `G53`.
    fn check_machine(&self, state: &ReaderState, target: &MoveTarget) -> Result<(), ReadRemark> {
        if !matches!(self.modal.motion, Some(GcodeMotion::Rapid | GcodeMotion::Feed)) {
            return Err(ReadRemark::new(
                target.at,
                "G53 without G0 or G1",
                "write G0 or G1 before it",
            ));
        }
        // Under TCP the text does not define which of the two X Y Z are.
        if state.control.tcp && target.axis.is_some() {
            return Err(ReadRemark::new(
                target.at,
                "a tool-axis vector with G53",
                "use rotary words",
            ));
        }
        Ok(())
    }

    /// Reads the axis words of a block.
    #[inline]
    pub(super) fn target(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
    ) -> Result<MoveTarget, ReadRemark> {
        let mut target = MoveTarget::new(usize::MAX, 0);
        for letter in AXES.iter().copied() {
            let Some(word) = block.take(letter) else { continue };
            let Some(slot) = state.control.slot(letter as u8) else {
                let what = text.get(word.at..word.end).unwrap_or_default();
                return Err(state.control.no_axis(word.at, what));
            };
            // Beyond any machine: often increments of 0.001 mm that were written without a point.
            if word.value.abs() > LARGEST {
                let what = text.get(word.at..word.end).unwrap_or_default();
                let message = format!("{what} is beyond {LARGEST} mm or degrees");
                return Err(ReadRemark::new(word.at, message, "is a point missing?"));
            }
            self.check_point(state, letter, word, text);
            // Units and the sense of rotation are applied here, once for all consumers.
            let mut value = state.control.meant(slot, word.value, word.decimals);
            if letter == 'X' && self.modal.diameter {
                value *= 0.5;
            }
            target.set(slot, value, self.modal.distance);
            target.at = target.at.min(word.at);
        }
        if target.at == usize::MAX {
            target.at = 0;
        }
        target.column = column(text, target.at);
        Ok(target)
    }

    /// Warns of a word without a point: Fanuc and Haas count it in the smallest increment, if so
    /// set.
    #[inline]
    fn check_point(&self, state: &mut ReaderState, letter: char, word: BlockWord, text: &str) {
        // Parameter 3401 bit 0 (DPI) decides at Fanuc: X10 is 10 mm or 10 increments of 0.001 mm.
        if self.dialect != Dialect::LinuxCnc && !word.point && word.value.abs() > 0.0 {
            let message = "words without a decimal point are read as millimetres and degrees";
            let help = format!("{letter}{}. reads so on any control", word.value);
            state.log.warn(text, ReadRemark::new(word.at, message, help));
        }
    }

    /// Runs a code that holds for its line only.
    fn nonmodal(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: u32,
        at: usize,
    ) -> Result<(), ReadRemark> {
        // These codes would need positions in both kinds of coordinates.
        let mapped = state.control.word_map.is_some();
        if mapped && matches!(code, 100 | 280 | 281 | 300 | 301 | 520 | 531 | 682 | 920..=923) {
            let message = "a shift, plane or home in turned or mirrored coordinates";
            return Err(ReadRemark::new(at, message, "end them before (G69, G50.1)"));
        }
        let place = CodeWord { letter: b'G', tenths: code, at, end: at };
        match code {
            40 => self.dwell(state, block, at),
            100 => self.write_offset(state, block, text, at),
            280 | 300 => self.home(state, block, text, code, at),
            // G28.1 and G30.1 store the present axis positions, as far as the program defines them.
            281 | 301 => {
                self.modal.references[usize::from(code == 301)] = state.control.machine;
                Ok(())
            }
            531 => self.turn_to_plane(state, at),
            682 => self.tilt(state, block, text, at),
            700 | 710 => self.bolt_circle(state, block, text, place),
            680 | 510 | 511 | 501 | 1000 | 1010 => self.map_code(state, block, text, place),
            _ => self.shift(state, block, text, code, at),
        }
    }

    /// Runs `G4`.
    fn dwell(
        &self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let mut time = block.take('P');
        let mut seconds = time.map(|word| self.dwell_seconds(word));
        // Fanuc: G4 X or U in seconds, G4 P in milliseconds.
        if self.dialect == Dialect::Fanuc && time.is_none() {
            time = block.take('X').or_else(|| block.take('U'));
            seconds = time.map(|word| word.value);
        }
        if let Some(axis) = AXES.iter().find_map(|letter| block.look(*letter)) {
            let help = "put them on a line of their own";
            return Err(ReadRemark::new(axis.at, "axis words beside G4", help));
        }
        push_dwell(state, seconds, at)
    }

    /// Runs `G4` of `LinuxCNC`, which may stand on a line with a motion.
    fn wait(
        &self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let seconds = block.take('P').map(|word| self.dwell_seconds(word));
        push_dwell(state, seconds, at)
    }

    /// Returns the dwell time of P \[s\]: seconds in `LinuxCNC`, milliseconds at Fanuc, at Haas by its point.
    pub(super) fn dwell_seconds(&self, word: BlockWord) -> f64 {
        match self.dialect {
            Dialect::Fanuc => 1e-3 * word.value,
            Dialect::Haas if !word.point => 1e-3 * word.value,
            _ => word.value,
        }
    }
}

/// Makes the step of `G4`.
fn push_dwell(state: &mut ReaderState, seconds: Option<f64>, at: usize) -> Result<(), ReadRemark> {
    match seconds {
        Some(seconds) if seconds >= 0.0 => {
            let line = state.log.line;
            state.control.steps.push_back(Step::Dwell { line, seconds });
            Ok(())
        }
        _ => Err(ReadRemark::new(at, "G4 without a time", "write G4 P and the time")),
    }
}

/// Reads I J K as the tool axis; a component that is missing is zero.
fn vector(block: &mut GcodeBlock, target: &MoveTarget) -> Result<UnitVector3<f64>, ReadRemark> {
    let [i, j, k] = ['I', 'J', 'K'].map(|letter| block.take(letter).map_or(0.0, |word| word.value));
    if let Some(angle) = block.look('Q') {
        let help = "write the tool axis itself";
        return Err(ReadRemark::new(angle.at, "an inclination (Q) beside the tool axis", help));
    }
    axis_of(Vector3::new(i, j, k), target.at)
}

/// Normalizes a direction.
pub(in super::super) fn axis_of(
    vector: Vector3<f64>,
    at: usize,
) -> Result<UnitVector3<f64>, ReadRemark> {
    // Any length will do: controls normalize the vector.
    UnitVector3::try_new(vector, f64::MIN_POSITIVE)
        .filter(|axis| axis.iter().all(|value| value.is_finite()))
        .ok_or_else(|| ReadRemark::new(at, "a tool axis of length zero", "look at its components"))
}
