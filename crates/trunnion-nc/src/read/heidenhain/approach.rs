//! Tangents: `CT`, `RND`, `CHF`, `APPR LT`, `APPR LCT`, `DEP LT`, `DEP LCT`.

use super::contour::{CornerForm, OpenCorner, departure};
use super::element::{ElementWay, FilletSide, PlaneElement, cross, dot, minus, norm, scaled};
use super::path_block::PathBlock;
use super::reader::{HeidenhainReader, LastPace};
use super::token::{Token, Tokens};
use super::units::feed_unit;
use crate::read::arc;
use crate::read::arc::{ArcForm, ArcSense, GivenArc};
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::log::{ReadRemark, column, excerpt};
use crate::read::state::ReaderState;
use crate::read::step::{Arc, Pace, Way};

/// Share of the way to the end below which an arc is straight.
const STRAIGHT: f64 = 1e-9;

impl HeidenhainReader {
    /// Opens a corner behind the last element: `RND R5 F100`, `CHF 2`.
    pub(super) fn corner(
        &mut self,
        state: &mut ReaderState,
        word: &str,
        first: &Token<'_>,
        mut tokens: Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let at = first.at;
        if self.held.as_ref().is_none_or(|held| held.corner().is_some()) {
            let message = format!("{word} without a contour element before it");
            let help = "write L, C, CR or CT with its end before it";
            return Err(ReadRemark::new(at, message, help));
        }
        let (mut size, mut feed) = (None, None);
        let rounds = word == "RND";
        while let Some(token) = tokens.next_word() {
            let upper = token.text.to_ascii_uppercase();
            match upper.as_bytes() {
                [b'F', ..] => feed = Some(self.value(&token.after(1))?.value * feed_unit(state)),
                [b'R', ..] if rounds => size = Some(self.value(&token.after(1))?.value),
                [b'0'..=b'9' | b'+' | b'Q' | b'.', ..] if !rounds => {
                    size = Some(self.value(&token)?.value);
                }
                _ => {
                    let message = format!("{} in {word}", excerpt(token.text));
                    return Err(ReadRemark::new(token.at, message, "write RND R5 F100, or CHF 2"));
                }
            }
        }
        let size = size.filter(|size| *size > 0.0).map(|size| size * state.control.scale());
        let Some(size) = size else {
            let message = format!("{word} without a size above 0");
            return Err(ReadRemark::new(at, message, "write RND R5, or CHF 2"));
        };
        // The F of a corner is of the corner alone.
        let mut inside = MoveTarget::new(at, 1);
        inside.set(self.plane_slots(state)[0], 1.0, DistanceMode::Incremental);
        let modal = state.control.feed;
        state.control.feed = feed.or(modal);
        let pace = state.control.pace(&inside, feed);
        state.control.feed = modal;
        let form = if rounds { CornerForm::Round(size) } else { CornerForm::Chamfer(size) };
        let corner = OpenCorner {
            form,
            pace: pace?,
            line: state.log.line,
            at,
            column: column(tokens.text(), at),
        };
        if let Some(held) = &mut self.held {
            held.open(corner);
        }
        Ok(())
    }

    /// Returns the arc of `CT X Y`, which goes on in the direction of the last element.
    pub(super) fn tangent_circle(
        &self,
        state: &ReaderState,
        block: &PathBlock,
    ) -> Result<Way, ReadRemark> {
        let at = block.target.at;
        let heading = self.heading(at)?;
        let chord = self.chord(state, &block.target)?;
        let across = dot(chord, FilletSide::Left.normal(heading));
        if across.abs() <= STRAIGHT * norm(chord) {
            if dot(chord, heading) > 0.0 {
                return Ok(Way::Line);
            }
            let help = "look at its end and at the element before it";
            return Err(ReadRemark::new(at, "CT to a point behind the contour", help));
        }
        // |e - r n| = |r|: r = e.e / (2 e.n), left of the way if positive.
        let radius = dot(chord, chord) / (2.0 * across);
        let center = scaled(FilletSide::Left.normal(heading), radius);
        let sense = if radius > 0.0 { ArcSense::Counterclockwise } else { ArcSense::Clockwise };
        let plane = self.plane_slots(state);
        let form = ArcForm::Center(center);
        let given = GivenArc { plane, form, sense, turns: 1, rounded: arc::ROUNDED };
        arc::way(&state.control, &block.target, &given)
    }

    /// Runs `APPR LT X Y LEN15`, `APPR LCT X Y R10`, and their polar forms.
    pub(super) fn approach(
        &mut self,
        state: &mut ReaderState,
        kind: &str,
        block: &mut PathBlock,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        let (form, polar) = match kind {
            "LT" | "PLT" => (CornerForm::Tangent(positive(block.length, at, "LEN")?), "PLT"),
            "LCT" | "PLCT" => (CornerForm::TangentArc(positive(block.radius, at, "R")?), "PLCT"),
            _ => return Err(sided("APPR", kind, at)),
        };
        if kind == polar {
            self.polar_end(state, block)?;
        }
        self.level(state, &block.target)?;
        let pace = Self::pace(state, block)?;
        // Up to the auxiliary point LT goes on as the block before it, LCT with its own feed.
        let rapid =
            self.last_pace == Some(LastPace::Rapid) && matches!(form, CornerForm::Tangent(_));
        self.opened =
            Some(OpenCorner { form, pace, line: state.log.line, at, column: block.target.column });
        let before = if rapid { Pace::Rapid } else { pace };
        state.control.go(state.log.line, block.target, before, Way::Line)
    }

    /// Runs `DEP LT LEN20`, `DEP LCT X Y R10`, and its polar form.
    pub(super) fn depart(
        &mut self,
        state: &mut ReaderState,
        kind: &str,
        block: &mut PathBlock,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        let plane = self.plane_slots(state);
        let heading = self.heading(at)?;
        let line = state.log.line;
        match kind {
            "LT" => {
                let length = positive(block.length, at, "LEN")?;
                if !block.target.is_empty() {
                    let help = "it leaves along the last element: write LEN alone";
                    return Err(ReadRemark::new(at, "axis words in DEP LT", help));
                }
                let mut target = MoveTarget::new(at, block.target.column);
                for (slot, along) in plane.into_iter().zip(scaled(heading, length)) {
                    target.set(slot, along, DistanceMode::Incremental);
                }
                block.target = target;
                let pace = Self::pace(state, block)?;
                state.control.go(line, target, pace, Way::Line)
            }
            "LCT" | "PLCT" => {
                let radius = positive(block.radius, at, "R")?;
                if kind == "PLCT" {
                    self.polar_end(state, block)?;
                }
                self.level(state, &block.target)?;
                let end = self.chord(state, &block.target)?;
                let parts = departure([0.0; 2], heading, radius, end);
                let parts = parts.filter(|_| cross(heading, end).abs() > STRAIGHT * norm(end));
                let Some(parts) = parts else {
                    let message =
                        format!("DEP LCT to a point that its arc R{radius} does not reach");
                    return Err(ReadRemark::new(at, message, "look at its end and its radius"));
                };
                let pace = Self::pace(state, block)?;
                for part in parts {
                    let (target, way) = departed(&block.target, plane, &part);
                    state.control.go(line, target, pace, way)?;
                }
                Ok(())
            }
            _ => Err(sided("DEP", kind, at)),
        }
    }

    fn heading(&self, at: usize) -> Result<[f64; 2], ReadRemark> {
        self.heading.ok_or_else(|| {
            let message = "a tangent to a contour element that is not known";
            let help = "write L, C, CR or CT with known ends in the block before";
            ReadRemark::new(at, message, help)
        })
    }

    /// Returns the way to the end of a block in the plane.
    fn chord(&self, state: &ReaderState, target: &MoveTarget) -> Result<[f64; 2], ReadRemark> {
        let along = |slot: usize| match target.get(slot) {
            None => Ok(0.0),
            Some(word) if target.is_incremental(slot) => Ok(word),
            Some(word) => {
                let stands = state.control.reading(slot);
                Ok(word - stands.ok_or_else(|| arc::unknown_start(target.at))?)
            }
        };
        let [u, v] = self.plane_slots(state);
        Ok([along(u)?, along(v)?])
    }

    /// Checks that an approach stays in the plane.
    fn level(&self, state: &ReaderState, target: &MoveTarget) -> Result<(), ReadRemark> {
        let plane = self.plane_slots(state);
        let moves = |slot: usize| match target.get(slot) {
            None => false,
            Some(word) if target.is_incremental(slot) => word.abs() > 0.0,
            Some(word) => state.control.reading(slot).is_none_or(|at| (at - word).abs() > 0.0),
        };
        if (0..target.words.len()).any(|slot| !plane.contains(&slot) && moves(slot)) {
            // Older controls go down behind the auxiliary point, newer ones all along the way.
            let message = "APPR or DEP with a move out of the plane";
            let help = "controls differ: move the tool axis in a block of its own";
            return Err(ReadRemark::new(target.at, message, help));
        }
        Ok(())
    }
}

/// Returns a size above zero.
fn positive(size: Option<f64>, at: usize, word: &str) -> Result<f64, ReadRemark> {
    size.filter(|size| *size > 0.0).ok_or_else(|| {
        ReadRemark::new(at, format!("APPR or DEP without {word} above 0"), format!("write {word}"))
    })
}

/// Returns the fault of an approach whose side is that of the cutter compensation.
fn sided(word: &str, kind: &str, at: usize) -> ReadRemark {
    let message = format!("{word} {kind} is not understood");
    let help = match kind {
        "LN" | "CT" | "PLN" | "PCT" => {
            "its side is that of the cutter compensation: write it as L and C, or as LT or LCT"
        }
        _ => "LT and LCT are",
    };
    ReadRemark::new(at, message, help)
}

/// Returns the move along a part of a departure from where the tool stands.
fn departed(given: &MoveTarget, plane: [usize; 2], part: &PlaneElement) -> (MoveTarget, Way) {
    let mut target = MoveTarget::new(given.at, given.column);
    for (slot, along) in plane.into_iter().zip(minus(part.end, part.start)) {
        target.set(slot, along, DistanceMode::Incremental);
    }
    let way = match part.way {
        ElementWay::Line => Way::Line,
        ElementWay::Arc { center, sweep } => {
            Way::Arc(Arc { plane, center: minus(center, part.start), sweep })
        }
    };
    (target, way)
}
