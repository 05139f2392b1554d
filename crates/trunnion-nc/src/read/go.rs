//! Moves of a control of any dialect: how fast, and where it then stands.

use super::control::{
    ActivePlane, ControlState, DistanceMode, FeedMode, FeedUnit, INCH, MoveTarget, SLOTS,
};
use super::log::ReadRemark;
use super::positions::rotate;
use super::step::{Arc, Frame, Move, Pace, Step, Turning, Way};

/// Distance of chords from an arc that is divided \[mm\]: that of splines.
const CHORD: f64 = 5e-4;

/// Most chords of an arc; more are a slip.
const MOST_CHORDS: u32 = 100_000;

impl ControlState {
    /// Returns the pace of a feed move; `feed` is the F word of its own block.
    pub(super) fn pace(&self, target: &MoveTarget, feed: Option<f64>) -> Result<Pace, ReadRemark> {
        let missing = |help: &str| ReadRemark::new(target.at, "feed move without a feed", help);
        match self.feed_mode {
            FeedMode::Inverse => {
                // G93: F is the inverse of the time of the block in minutes. It holds for its own
                // block only.
                let feed = feed.ok_or_else(|| missing("G93 needs an F word on every G1 line"))?;
                Ok(Pace::Inverse { seconds: 60.0 / feed })
            }
            FeedMode::PerMinute => {
                // G94: mm/min or degrees/min to mm/s or degrees/s.
                let help = "write an F word; G93 and G94 do not share one";
                let feed = self.feed.ok_or_else(|| missing(help))?;
                Ok(Pace::PerMinute { speed: feed * self.feed_scale(target) / 60.0 })
            }
            FeedMode::PerRevolution => {
                // G95: mm per revolution times revolutions per minute.
                let feed = self.feed.ok_or_else(|| missing("write an F word after G95"))?;
                let [x, ..] = self.xyz;
                let end = match target.get(x) {
                    Some(word) if target.is_incremental(x) => self.reading(x).map(|at| at + word),
                    Some(word) => Some(word),
                    None => self.reading(x),
                };
                let Some(speed) = self.spindle_speed(end) else {
                    let message = "feed per revolution (G95) with a cutting speed (G96) at an X that is not stated";
                    let help = "program X absolutely before, or give the fastest speed: G96 D";
                    return Err(ReadRemark::new(target.at, message, help));
                };
                if self.sense == 0 || speed <= 0.0 {
                    let message = "feed per revolution (G95) with a spindle that stands";
                    return Err(ReadRemark::new(
                        target.at,
                        message,
                        "write S and M3 before, or use G94",
                    ));
                }
                Ok(Pace::PerMinute { speed: feed * self.feed_scale(target) * speed / 60.0 })
            }
        }
    }

    /// Returns the scale of F: inch units are those of linear axes, rotaries alone turn in degrees.
    fn feed_scale(&self, target: &MoveTarget) -> f64 {
        // A word that repeats the current position moves nothing, and leaves F to the rotaries.
        let linear = |slot: usize| {
            let moves = |word: f64| match (target.is_incremental(slot), self.reading(slot)) {
                (true, _) => word.abs() > 0.0,
                (false, Some(place)) => (word - place).abs() > 0.0,
                (false, None) => true,
            };
            !self.is_rotary(slot) && target.get(slot).is_some_and(moves)
        };
        let inch = self.feed_unit.map_or(self.inch, |unit| unit == FeedUnit::Inch);
        if inch && (0..SLOTS).any(linear) { INCH } else { 1.0 }
    }

    /// Makes a move and stands at its end.
    pub(super) fn go(
        &mut self,
        line: u32,
        mut target: MoveTarget,
        pace: Pace,
        way: Way,
    ) -> Result<(), ReadRemark> {
        let mut way = way;
        self.state_again(&mut target)?;
        if let Way::Arc(arc) = way
            && self.turns_upright(&target, &arc)
        {
            return self.go_in_chords(line, &target, pace, &arc);
        }
        // Checks come before the positions are changed.
        if let Some(tilted) = &self.tilted {
            self.check_tilted(*tilted, &target)?;
        }
        let incremental = if target.machine {
            self.leave_work(&target)?;
            false
        } else {
            if let Some(map) = &self.word_map {
                way = self.map_move(map, &mut target, way)?;
            }
            if self.turn().abs() > 0.0 {
                way = self.turned(&mut target, way)?;
            }
            self.work_words(&mut target)?
        };
        // The inverse of the consumer chooses the rotaries: their words are not known afterwards.
        if target.axis.is_some() {
            self.forget(|rotary| rotary);
        }
        let [w0, w1, w2, w3, w4, sixth] = target.words;
        // G53 is in axis positions, and the turn to the plane precedes its coordinates.
        let tilted = self.tilted.filter(|tilted| tilted.ready && !target.machine);
        // A program gives tool vectors so that the tool stays in the plane between them; rotary words
        // are interpolated as axes.
        let default = if target.axis.is_some() { Turning::GreatCircle } else { Turning::Rotary };
        self.steps.push_back(Step::Move(Move {
            line,
            column: target.column,
            words: [w0, w1, w2, w3, w4],
            sixth: self.sixth.zip(sixth),
            incremental,
            frame: if target.machine { Frame::Machine } else { self.frame() },
            plane: tilted.map_or(0, |tilted| tilted.number),
            axis: target.axis,
            pace,
            way,
            turning: self.turning.unwrap_or(default),
        }));
        Ok(())
    }

    /// Takes a move in axis positions, which leaves the work coordinates.
    fn leave_work(&mut self, target: &MoveTarget) -> Result<(), ReadRemark> {
        // A distance would need the axis positions, which only the consumer knows.
        if target.incremental != 0 {
            return Err(ReadRemark::new(target.at, "G53 with distances (G91)", "write G90"));
        }
        // Axis positions leave the words unknown, unless the program wrote the work offset.
        for (slot, word) in target.words.iter().enumerate() {
            if word.is_some() {
                let place = self.place_at(slot, *word);
                if let Some(known) = self.place.get_mut(slot) {
                    *known = place;
                }
                if let Some(machine) = self.machine.get_mut(slot) {
                    *machine = *word;
                }
            }
        }
        // With TCP the tip, in coordinates of the table, moves with any axis.
        if self.tcp {
            self.forget_linear();
        }
        Ok(())
    }

    /// Returns the word of an axis at an axis position, if the program states what lies between.
    fn place_at(&self, slot: usize, machine: Option<f64>) -> Option<f64> {
        let [.., z] = self.xyz;
        // The length of the tool is not in the program; under TCP the rotaries take part.
        if self.tcp || self.length && slot == z {
            return None;
        }
        Some(machine? - self.written_offsets.origin(self.offset, slot)?)
    }

    /// Returns the axis position at a position of the work offset, if the program states what lies between.
    fn machine_at(&self, slot: usize, place: Option<f64>) -> Option<f64> {
        let [.., z] = self.xyz;
        if self.tcp || self.length && slot == z {
            return None;
        }
        Some(place? + self.written_offsets.origin(self.offset, slot)?)
    }

    /// Takes the words of a work offset: shifts them, and makes them all absolute unless all are
    /// distances.
    #[inline]
    fn work_words(&mut self, target: &mut MoveTarget) -> Result<bool, ReadRemark> {
        // Bit masks of the words: the move is incremental if all of them are distances.
        let mut present = 0_u8;
        for (slot, word) in target.words.iter().enumerate() {
            present |= u8::from(word.is_some()) << slot;
        }
        let all = present != 0 && target.incremental & present == present;
        for slot in 0..SLOTS {
            let Some(word) = target.get(slot) else { continue };
            let stood = self.stands(slot);
            // A block with both kinds of words is made absolute: position + distance. One of
            // distances alone may start anywhere, as the consumer adds them to its own positions.
            let end = if !target.is_incremental(slot) {
                Some(word + self.shift(slot) + self.tool_offset(slot))
            } else if all || stood.is_some() {
                stood.map(|stood| stood + word)
            } else {
                let message = "a distance from a position that the program does not state";
                return Err(ReadRemark::new(
                    target.at,
                    message,
                    "program the axis absolutely first",
                ));
            };
            if let Some(place) = self.place.get_mut(slot) {
                *place = end;
            }
            // The axis position that belongs to a word depends on the work offset.
            let position = if self.tcp { None } else { self.machine_at(slot, end) };
            if let Some(machine) = self.machine.get_mut(slot) {
                *machine = position;
            }
            if let (false, Some(word)) = (all, target.words.get_mut(slot)) {
                *word = end;
            }
        }
        // With TCP all axes compensate for a single word.
        if self.tcp {
            self.machine = [None; SLOTS];
        }
        Ok(all)
    }

    /// Adds the words of axes that are not where the control takes them to be.
    fn state_again(&mut self, target: &mut MoveTarget) -> Result<(), ReadRemark> {
        if self.restated == 0 {
            return Ok(());
        }
        for slot in (0..SLOTS).filter(|slot| self.restated >> slot & 1 == 1) {
            let word = match target.get(slot) {
                Some(_) if !target.is_incremental(slot) => continue,
                word => word.unwrap_or(0.0),
            };
            if target.machine {
                // The words of G53 are positions of axes: so is the one that is added.
                let Some(position) = self.machine_at(slot, self.stands(slot)) else {
                    let message = "G53 as the first move behind cutter compensation";
                    let help = "move away from the contour before it";
                    return Err(ReadRemark::new(target.at, message, help));
                };
                target.set(slot, position, DistanceMode::Absolute);
                continue;
            }
            if let Some(reading) = self.reading(slot) {
                target.set(slot, reading + word, DistanceMode::Absolute);
            }
        }
        self.restated = 0;
        Ok(())
    }

    /// Returns true for an arc of `G18` or `G19` whose plane is upright but, in a turned work offset, no longer along X or Y.
    fn turns_upright(&self, target: &MoveTarget, arc: &Arc) -> bool {
        let [x, y, _] = self.xyz;
        self.turn().abs() > 0.0 && !target.machine && arc.plane != [x, y]
    }

    /// Runs an arc as chords near it.
    fn go_in_chords(
        &mut self,
        line: u32,
        target: &MoveTarget,
        pace: Pace,
        arc: &Arc,
    ) -> Result<(), ReadRemark> {
        let parts = arc.parts(CHORD);
        if parts > MOST_CHORDS {
            let message =
                format!("an arc of more than {MOST_CHORDS} chords in a turned work offset");
            return Err(ReadRemark::new(target.at, message, "turn the offset back (R0)"));
        }
        let pace = match pace {
            // The time of the block is that of the whole arc.
            Pace::Inverse { seconds } => Pace::Inverse { seconds: seconds / f64::from(parts) },
            pace => pace,
        };
        let start = self.readings();
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let mut step = MoveTarget::new(target.at, target.column);
            for (slot, from) in start.iter().enumerate() {
                match (arc.plane.iter().position(|axis| *axis == slot), target.get(slot), from) {
                    (Some(axis), _, Some(from)) => {
                        step.set(slot, from + arc.at(share)[axis], DistanceMode::Absolute);
                    }
                    (_, Some(word), _) if target.is_incremental(slot) => {
                        step.set(slot, word / f64::from(parts), DistanceMode::Incremental);
                    }
                    (_, Some(word), Some(from)) => {
                        step.set(slot, from + share * (word - from), DistanceMode::Absolute);
                    }
                    // An axis whose position is not stated reaches its word with the first chord.
                    (_, Some(word), None) => step.set(slot, word, DistanceMode::Absolute),
                    _ => {}
                }
            }
            self.go(line, step, pace, Way::Line)?;
        }
        Ok(())
    }

    /// Turns the X Y words of a move, and the centre of its arc, with the work offset (`G10 L2 R`).
    fn turned(&self, target: &mut MoveTarget, way: Way) -> Result<Way, ReadRemark> {
        let [x, y, _] = self.xyz;
        if target.get(x).is_some() || target.get(y).is_some() {
            self.turn_words(target, [x, y])?;
        }
        match way {
            Way::Line => Ok(way),
            Way::Arc(arc) => Ok(Way::Arc(Arc { center: rotate(arc.center, self.turn()), ..arc })),
        }
    }

    /// Turns the X Y words of a move with the work offset.
    fn turn_words(&self, target: &mut MoveTarget, slots: [usize; 2]) -> Result<(), ReadRemark> {
        // One word of two moves both axes, so the other has to be known; distances alone turn as they are.
        let written = |slot: usize| target.get(slot).is_none() || target.is_incremental(slot);
        let distances = slots.into_iter().all(written);
        let component = |slot: usize| {
            if distances {
                return Ok(target.get(slot).unwrap_or(0.0));
            }
            let stood = || {
                self.reading(slot).ok_or_else(|| {
                    let message = "one of X Y in a turned work offset, the other is not stated";
                    ReadRemark::new(target.at, message, "program both absolutely first")
                })
            };
            let word = match target.get(slot) {
                None => stood()?,
                Some(word) if target.is_incremental(slot) => stood()? + word,
                Some(word) => word,
            };
            Ok(word + self.shift(slot))
        };
        let [x, y] = slots;
        let turned = rotate([component(x)?, component(y)?], self.turn());
        for (slot, value) in slots.into_iter().zip(turned) {
            target.unset(slot);
            if distances {
                target.set(slot, value, DistanceMode::Incremental);
            } else {
                // The shift, which was turned along, is added to absolute words later.
                target.set(slot, value - self.shift(slot), DistanceMode::Absolute);
            }
        }
        Ok(())
    }

    /// Checks a move in a tilted plane, where the tool stands along the normal.
    fn check_tilted(&self, tilted: ActivePlane, target: &MoveTarget) -> Result<(), ReadRemark> {
        // A rotary word would turn the tool away from the normal, on which the plane relies.
        let rotary = (0..SLOTS).any(|slot| target.get(slot).is_some() && self.is_rotary(slot));
        if target.machine || target.axis.is_some() {
            return Ok(());
        }
        if rotary {
            let message = "rotary words in a tilted plane";
            let help = "end the plane before (G69, PLANE RESET, CYCLE800())";
            return Err(ReadRemark::new(target.at, message, help));
        }
        if !tilted.ready {
            let message = "a move in a tilted plane to which the tool was not turned";
            let help = "write G53.1, PLANE .. TURN, or CYCLE800 with a direction";
            return Err(ReadRemark::new(target.at, message, help));
        }
        Ok(())
    }
}
