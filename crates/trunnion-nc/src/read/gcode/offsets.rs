//! Codes that change what coordinates mean, or go to fixed places.

use super::block::GcodeBlock;
use super::modal::GcodeMotion;
use super::reader::GcodeReader;
use super::tool_offsets::TableCode;
use super::words::natural;
use crate::read::control::{ControlState, DistanceMode, MoveTarget, SLOTS};
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Offset, OffsetKind, Pace, Step, Way};
use crate::read::tilt::{HeldPoint, euler};
use crate::types::AXES;
use nalgebra::Vector3;

/// Parameters of the first axis of `G28` and `G30` in `LinuxCNC`.
const REFERENCES: [u32; 2] = [5161, 5181];

/// A work offset as a block writes it.
struct WrittenOffset {
    offset: u8,
    kind: OffsetKind,
    target: MoveTarget,
    /// Byte offset of the code.
    at: usize,
}

/// Table that a `G10` writes.
enum TableDestination {
    /// None.
    Unchanged,
    /// Tools, by the number behind L.
    Tools(u32),
    Offsets(OffsetDestination),
}

/// Work offsets that a `G10` writes.
struct OffsetDestination {
    kind: OffsetKind,
    first: FirstOffset,
}

/// Offset that P1 names.
enum FirstOffset {
    /// `G54`.
    Usual,
    /// `G54.1 P1`, behind the usual ones.
    Further,
}

impl GcodeReader {
    /// Runs `G10`.
    pub(super) fn write_offset(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let destination = match self.destination(block, at)? {
            // L0 reads the tool table again, which is as it was.
            TableDestination::Unchanged => {
                state.control.keep(state.log.line, "G10 L0");
                return Ok(());
            }
            TableDestination::Tools(table) => {
                return self.write_tool(state, block, text, &TableCode { table, at });
            }
            TableDestination::Offsets(destination) => destination,
        };
        let turn = self.offset_turn(block, destination.kind)?;
        let offset = self.offset_number(state, block, &destination, at)?;
        let target = self.target(state, block, text)?;
        // LinuxCNC takes the words of G10 as values in any distance mode; Fanuc adds them under
        // G91.
        if target.incremental != 0 && self.dialect != Dialect::LinuxCnc {
            return Err(ReadRemark::new(at, "G10 with distances (G91)", "write G90"));
        }
        let kind = destination.kind;
        let words = note_offset(state, &WrittenOffset { offset, kind, target, at })?;
        if let Some(turn) = turn {
            state.control.written_offsets.set_turn(offset, turn);
        }
        let [w0, w1, w2, w3, w4, sixth] = words;
        if sixth.is_some() {
            let message = "the work offset of a sixth axis is taken as given at the control";
            state.log.warn(text, ReadRemark::new(at, message, ""));
        }
        let words = [w0, w1, w2, w3, w4];
        let line = state.log.line;
        if words.iter().any(Option::is_some) {
            state.control.steps.push_back(Step::Offset(Offset { line, offset, words, kind }));
        }
        Ok(())
    }

    /// Returns the table that `L` of a `G10` chooses.
    fn destination(
        &self,
        block: &mut GcodeBlock,
        at: usize,
    ) -> Result<TableDestination, ReadRemark> {
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        let offsets = |kind, first| TableDestination::Offsets(OffsetDestination { kind, first });
        // L2 writes the offset itself; L20 writes it so that the present position reads as the
        // words.
        Ok(match block.take('L').map(|word| natural(word, 'L')).transpose()? {
            Some(2) => offsets(OffsetKind::Origin, FirstOffset::Usual),
            // Fanuc and Haas: L20 writes the further offsets, G54.1 P1 and on.
            Some(20) if !linuxcnc => offsets(OffsetKind::Origin, FirstOffset::Further),
            Some(20) => offsets(OffsetKind::Reading, FirstOffset::Usual),
            Some(0) if linuxcnc => TableDestination::Unchanged,
            Some(table @ (1 | 10 | 11)) if linuxcnc => TableDestination::Tools(table),
            _ => {
                let message = "G10 other than L2 or L20 changes what later words mean";
                return Err(ReadRemark::new(at, message, "set tool tables at the control"));
            }
        })
    }

    /// Returns the angle of an offset about Z \[rad\], `R`.
    fn offset_turn(
        &self,
        block: &mut GcodeBlock,
        kind: OffsetKind,
    ) -> Result<Option<f64>, ReadRemark> {
        let Some(turn) = block.take('R') else { return Ok(None) };
        let understood = self.dialect == Dialect::LinuxCnc && kind != OffsetKind::Reading;
        if !understood && turn.value.abs() > 0.0 {
            let message = "a turned work offset (R)";
            return Err(ReadRemark::new(turn.at, message, "post turned coordinates"));
        }
        Ok(Some(turn.value.to_radians()))
    }

    /// Returns the number of the offset that `P` names.
    fn offset_number(
        &self,
        state: &ReaderState,
        block: &mut GcodeBlock,
        destination: &OffsetDestination,
        at: usize,
    ) -> Result<u8, ReadRemark> {
        // P1 is G54; P0 or no P is the active offset.
        let number = block.take('P').map_or(Ok(0), |word| natural(word, 'P'))?;
        if self.dialect != Dialect::LinuxCnc && number == 0 {
            let message = "G10 P0 writes the external offset, which shifts all others";
            return Err(ReadRemark::new(at, message, "write P1 for G54 and so on"));
        }
        let (number, most) = match destination.first {
            FirstOffset::Usual => (number, 9),
            FirstOffset::Further => (number.saturating_add(9), 255),
        };
        if number > most {
            return Err(ReadRemark::new(at, format!("G10 P{number}"), "work offsets are P1 to P9"));
        }
        let present = state.control.offset;
        Ok(number.checked_sub(1).map_or(present, |n| u8::try_from(n).unwrap_or(u8::MAX)))
    }

    /// Runs `G52`, `G92`, `G92.1`, `G92.2`, `G92.3`: words are shifted.
    pub(super) fn shift(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: u32,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if state.control.tilted.is_some() {
            return Err(ReadRemark::new(
                at,
                "a shift in a tilted plane",
                "end the plane before (G69)",
            ));
        }
        let linuxcnc = self.dialect == Dialect::LinuxCnc;
        if self.modal.stood && (code > 920 || linuxcnc && code == 520) {
            let message = "the end of a shift (G92) whose amount the program does not state";
            let help = "program the axes absolutely before G92, or use G10 L20";
            return Err(ReadRemark::new(at, message, help));
        }
        // G92.1 and G92.2 cancel the shift, G92.3 brings back what G92.2 cancelled.
        if code > 920 {
            if code == 921 {
                self.modal.kept_shift = [0.0; SLOTS];
            }
            let kept = if code == 923 { self.modal.kept_shift } else { [0.0; SLOTS] };
            state.control.set_by_92 = kept;
            return Ok(());
        }
        let target = self.target(state, block, text)?;
        if code == 520 {
            for slot in 0..SLOTS {
                // G52 replaces the local shift; in LinuxCNC it is that of G92.
                let Some(value) = target.get(slot) else { continue };
                let control = &mut state.control;
                let shift = if linuxcnc { &mut control.set_by_92 } else { &mut control.local };
                if let Some(shift) = shift.get_mut(slot) {
                    *shift = value;
                }
            }
        } else {
            self.set_reading(state, &target, text, at)?;
        }
        self.modal.kept_shift = state.control.set_by_92;
        Ok(())
    }

    /// Runs `G92`: the present position is to read as the words.
    fn set_reading(
        &mut self,
        state: &mut ReaderState,
        target: &MoveTarget,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let before = state.control.readings();
        let mut stands = [None; SLOTS];
        for (slot, stands) in stands.iter_mut().enumerate() {
            let Some(value) = target.get(slot) else { continue };
            match before.get(slot).copied().flatten() {
                // The shift grows by the difference.
                Some(reads) => {
                    if let Some(set) = state.control.set_by_92.get_mut(slot) {
                        *set += reads - value;
                    }
                }
                None => *stands = Some(value),
            }
        }
        if stands.iter().all(Option::is_none) {
            return Ok(());
        }
        // Only where nothing was known can the work offset be meant as it is behind G92.
        let turned = state.control.turn().abs() > 0.0;
        if self.dialect != Dialect::LinuxCnc || state.control.tcp || turned {
            let message = "G92 at a position that the program does not state";
            let help = "program the axis absolutely before it, or use G10 L20";
            return Err(ReadRemark::new(at, message, help));
        }
        let message = "G92 at a position that the program does not state: its coordinates are taken to count \
                       from the work offset";
        let help = "give the work offset as it is behind G92";
        state.log.warn(text, ReadRemark::new(at, message, help));
        self.modal.stood = true;
        let place = state.control.place_of(&stands);
        let mut words = [None; AXES];
        for (slot, place) in place.into_iter().enumerate().filter(|(_, place)| place.is_some()) {
            if let Some(stood) = state.control.place.get_mut(slot) {
                *stood = place;
            }
            if let Some(word) = words.get_mut(slot) {
                *word = place;
            }
        }
        let (line, offset) = (state.log.line, state.control.offset);
        let kind = OffsetKind::Standing;
        state.control.steps.push_back(Step::Offset(Offset { line, offset, words, kind }));
        Ok(())
    }

    /// Runs `G28`, `G30`: over an intermediate position to the reference.
    pub(super) fn home(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        code: u32,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let between = self.target(state, block, text)?;
        let line = state.log.line;
        // G91 G28 Z0 goes home at once: the intermediate point is the present one.
        let still = |word: &Option<f64>| word.is_none_or(|word| word.abs() <= 0.0);
        let distances = between.incremental != 0;
        let rests = distances && between.words.iter().all(still);
        if !(between.is_empty() || rests) {
            state.control.go(line, between, Pace::Rapid, Way::Line)?;
        }
        let mut home = MoveTarget::new(between.at, between.column);
        // The reference position is one of axes.
        home.machine = true;
        for slot in 0..SLOTS {
            // Without words all five axes go home, but not a sixth, whose reference is unknown.
            let all = between.is_empty() && slot + 1 < SLOTS;
            if between.get(slot).is_some() || all {
                let value = self.reference(state, usize::from(code == 300), slot);
                let help =
                    "give the parameters of its place when reading (#5161 and on, #5181 and on)";
                let message = "where G28 or G30 leads to is not known";
                let value = value.ok_or_else(|| ReadRemark::new(at, message, help))?;
                home.set(slot, value, DistanceMode::Absolute);
            }
        }
        state.control.go(line, home, Pace::Rapid, Way::Line)
    }

    fn reference(&self, state: &mut ReaderState, which: usize, slot: usize) -> Option<f64> {
        let first = REFERENCES.get(which)?;
        let at = state.control.letter(slot).and_then(|c| "XYZABCUVW".find(c))?;
        // #5161 to #5169 are X Y Z A B C U V W of G28, #5181 and on those of G30.
        let number = first + u32::try_from(at).ok()?;
        let key = super::parameters::ParameterKey::Number(number);
        let given = self.parameters.get(&key, &self.view(&state.control, state.log.line));
        match given {
            Some(given) => Some(state.control.meant(slot, given, super::super::control::COMPUTED)),
            None => self.modal.references.get(which)?.get(slot).copied().flatten(),
        }
    }

    /// Runs `G68.2 X Y Z I J K`: Euler angles about Z, the new X, the new Z.
    pub(super) fn tilt(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if state.control.tilted.is_some() {
            return Err(ReadRemark::new(
                at,
                "a tilted plane in another",
                "end the first before (G69)",
            ));
        }
        // P1 to P4 define the plane by fixed angles, three points, two vectors or projected angles.
        if let Some(kind) = block.take('P')
            && kind.value.abs() > 0.0
        {
            let help = "write Euler angles: G68.2 X Y Z I J K";
            return Err(ReadRemark::new(
                kind.at,
                "a tilted plane other than by Euler angles",
                help,
            ));
        }
        let [i, j, k] =
            ['I', 'J', 'K'].map(|letter| block.take(letter).map_or(0.0, |w| w.value.to_radians()));
        // X Y Z are the origin of the plane, absolute in any distance mode.
        let mode = std::mem::replace(&mut self.modal.distance, DistanceMode::Absolute);
        let target = self.target(state, block, text);
        self.modal.distance = mode;
        let target = target?;
        let [x, y, z] = state.control.xyz.map(|slot| target.get(slot).unwrap_or(0.0));
        // The plane keeps the shifts that were active when it was defined.
        let origin = Vector3::new(x, y, z) + state.control.linear_shift();
        state.control.tilt(state.log.line, origin, euler([i, j, k]));
        Ok(())
    }

    /// Runs `G53.1`: the rotary axes turn the tool to the normal of the plane.
    pub(super) fn turn_to_plane(
        &mut self,
        state: &mut ReaderState,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if state.control.tilted.is_none() {
            return Err(ReadRemark::new(at, "G53.1 without a tilted plane", "write G68.2 before"));
        }
        if matches!(self.modal.motion, Some(GcodeMotion::Cycle(_))) {
            self.modal.motion = None;
        }
        state.control.turn_to_plane(state.log.line, at, HeldPoint::LinearAxes)
    }
}

/// Notes what an offset is from now on, and what the words of the active one then read.
///
/// Returns the words for the consumer, which knows nothing of a turn about Z.
fn note_offset(
    state: &mut ReaderState,
    written: &WrittenOffset,
) -> Result<[Option<f64>; SLOTS], ReadRemark> {
    let WrittenOffset { offset, kind, target, at } = written;
    let control = &mut state.control;
    let words = match kind {
        OffsetKind::Reading => read_words(control, written)?,
        _ => target.words,
    };
    let active = *offset == control.offset;
    for slot in 0..SLOTS {
        let Some(value) = words.get(slot).copied().flatten() else { continue };
        let before = control.written_offsets.origin(*offset, slot);
        let stood = control.stands(slot);
        let (place, origin) = match kind {
            // The words change by as much as the origin moves.
            OffsetKind::Origin => {
                let moved = before.map(|before| value - before);
                (stood.zip(moved).map(|(stood, moved)| stood - moved), Some(value))
            }
            _ if active => {
                let moved = stood.map(|stood| stood - value);
                (Some(value), before.zip(moved).map(|(before, moved)| before + moved))
            }
            _ => (None, None),
        };
        control.written_offsets.set_origin(*offset, slot, origin);
        if let (true, Some(to)) = (active, control.place.get_mut(slot)) {
            *to = place;
        }
    }
    if words.iter().any(Option::is_some) && active && control.tcp {
        // With TCP, or rotary offsets, the others read anew, too.
        control.forget_linear();
    }
    if control.written_offsets.turn(*offset).abs() > 0.0 && control.tcp {
        let message = "a turned work offset (G10 R) under tool-centre-point control";
        return Err(ReadRemark::new(*at, message, "end TCP before it"));
    }
    Ok(words)
}

/// Returns the words that the present position reads as with a written offset, with shifts and turned
/// as those of moves are.
fn read_words(
    control: &ControlState,
    written: &WrittenOffset,
) -> Result<[Option<f64>; SLOTS], ReadRemark> {
    let WrittenOffset { offset, target, at, .. } = written;
    let [x, y, _] = control.xyz;
    let turn = control.written_offsets.turn(*offset);
    let turned = turn.abs() > 0.0 && (target.get(x).is_some() || target.get(y).is_some());
    let mut readings = target.words;
    if turned {
        // X and Y turn together: the axis that is not written keeps its reading.
        for slot in [x, y] {
            let known = || if *offset == control.offset { control.reading(slot) } else { None };
            let reading = target.get(slot).or_else(known).ok_or_else(|| {
                let message =
                    "one of X Y of a turned work offset, at a position that is not stated";
                ReadRemark::new(*at, message, "write both")
            })?;
            if let Some(word) = readings.get_mut(slot) {
                *word = Some(reading);
            }
        }
    }
    Ok(control.place_in(&readings, turn))
}
