//! Cutter compensation of `LinuxCNC`: `G41`, `G42`, `G41.1`, `G42.1`, `G40`.
//!
//! A compensated move waits until the next one tells where the two meet. Steps that are made in between wait behind it.

use super::block::GcodeBlock;
use super::corner::{
    ContourArc, ContourCorner, CornerKind, CutterSide, OffsetWay, distance, dot, minus, plus,
    scaled, sweep, sweep_left, unit,
};
use crate::read::arc::{self, ArcForm, ArcSense, GivenArc};
use crate::read::control::{ControlState, DistanceMode, INCH, MoveTarget};
use crate::read::log::ReadRemark;
use crate::read::step::{Arc, Pace, Step, Way};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// An arc may become longer than programmed by this angle \[rad\], in mm and in inch programs.
const LONGER: f64 = 0.0254;
const LONGER_INCH: f64 = 0.001;

/// Radii of an arc at both ends may differ by so much \[units of the program\].
const MISMATCH: f64 = 0.01;

/// Steps that may wait behind a move; more are no contour.
const MOST_WAITING: usize = 10_000;

/// Help of faults of contours into which the cutter does not fit.
const SMALLER: &str = "use a smaller cutter, or change the contour";

/// A move that waits; the two axes of the plane apart.
#[derive(Debug, Clone, Copy)]
struct WaitingMove {
    line: u32,
    target: MoveTarget,
    end: [f64; 2],
    way: OffsetWay,
    pace: Pace,
}

/// A step that waits.
#[derive(Debug)]
enum WaitingStep {
    Move(WaitingMove),
    Other(Step),
}

/// A move as the program has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContourMove {
    pub(super) line: u32,
    pub(super) target: MoveTarget,
    pub(super) pace: Pace,
}

/// An arc as the program has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProgrammedArc {
    pub(super) form: ArcForm,
    /// The centre is a coordinate: `G90.1`.
    pub(super) absolute: bool,
    pub(super) sense: ArcSense,
    pub(super) turns: u32,
    pub(super) rounded: f64,
}

/// Cutter compensation that is on.
#[derive(Debug)]
pub(super) struct Compensation {
    side: CutterSide,
    radius: f64,
    /// Slots of the plane.
    slots: [usize; 2],
    /// From the middle of a turning tool to the corner that its offsets are of, in the plane.
    corner: [f64; 2],
    /// End of the last programmed move; `None` before the first.
    programmed: Option<[f64; 2]>,
    /// Centre of the cutter there, before the next move is known.
    reached: [f64; 2],
    /// Point at which the first waiting move begins.
    begin: [f64; 2],
    waiting: VecDeque<WaitingStep>,
}

impl Compensation {
    /// Switches compensation on; a negative radius is on the other side.
    pub(super) fn new(side: CutterSide, radius: f64, slots: [usize; 2]) -> Self {
        let side = if radius < 0.0 { side.other() } else { side };
        Self {
            side,
            radius: radius.abs(),
            slots,
            corner: [0.0; 2],
            programmed: None,
            reached: [0.0; 2],
            begin: [0.0; 2],
            waiting: VecDeque::new(),
        }
    }

    /// Sets the corner of a turning tool by its number, 1 to 8, in the plane of Z and X.
    pub(super) fn with_corner(mut self, number: u32) -> Self {
        let along_z = match number {
            2 | 3 | 7 => -1.0,
            1 | 4 | 5 => 1.0,
            _ => 0.0,
        };
        let along_x = match number {
            1 | 2 | 6 => -1.0,
            3 | 4 | 8 => 1.0,
            _ => 0.0,
        };
        self.corner = [along_z * self.radius, along_x * self.radius];
        self
    }

    /// Returns 410 for left, 420 for right.
    pub(super) fn code(&self) -> u32 {
        match self.side {
            CutterSide::Left => 410,
            CutterSide::Right => 420,
        }
    }

    /// Returns true if moves of the program are changed by it.
    pub(super) fn changes_moves(&self) -> bool {
        self.radius > 0.0
    }

    /// Returns true behind the first move.
    pub(super) fn has_moved(&self) -> bool {
        self.programmed.is_some()
    }

    /// Takes steps that belong behind those that wait.
    pub(super) fn follow(&mut self, control: &mut ControlState, steps: VecDeque<Step>) {
        if self.waiting.is_empty() {
            control.steps.extend(steps);
        } else if self.waiting.len() < MOST_WAITING {
            self.waiting.extend(steps.into_iter().map(WaitingStep::Other));
        }
    }

    /// Compensates a straight move; `late` are the steps of its line that come before it.
    pub(super) fn line(
        &mut self,
        control: &mut ControlState,
        given: &ContourMove,
        late: VecDeque<Step>,
    ) -> Result<(), ReadRemark> {
        let at = given.target.at;
        let Some(corner_at) = self.programmed else { return self.entry_line(control, given, late) };
        let end = self.end_of(&given.target, corner_at);
        if distance(end, corner_at) <= 0.0 {
            self.follow(control, late);
            return self.wait(given, self.reached, OffsetWay::Line { direction: [0.0; 2] });
        }
        let direction = unit(minus(end, corner_at));
        let across = self.side.across(direction);
        let corner = self.corner_at(corner_at);
        let held = self.held();
        match corner.kind_to_line(across, held.map(|held| held.way)) {
            CornerKind::Inside => {
                let meet = match held {
                    Some(WaitingMove { way: way @ OffsetWay::Arc { .. }, end, .. }) => {
                        corner.arc_to_line(way, end, direction)
                    }
                    _ => corner.line_to_line(across),
                };
                self.meet(control, meet, at)?;
                self.follow(control, late);
            }
            CornerKind::Outside => {
                self.keep_end(control, at)?;
                control.steps.extend(late);
                let mid = plus(corner_at, scaled(across, self.radius));
                self.roll(control, given, mid, distance(corner_at, end))?;
            }
            CornerKind::Smooth => {
                self.keep_end(control, at)?;
                control.steps.extend(late);
                self.begin = self.reached;
            }
        }
        let reached = plus(end, scaled(across, self.radius));
        self.wait(given, reached, OffsetWay::Line { direction: minus(end, corner_at) })?;
        (self.programmed, self.reached) = (Some(end), reached);
        Ok(())
    }

    /// Compensates the first move, a straight one.
    fn entry_line(
        &mut self,
        control: &mut ControlState,
        given: &ContourMove,
        late: VecDeque<Step>,
    ) -> Result<(), ReadRemark> {
        let at = given.target.at;
        let start = self.start(control, at)?;
        let end = self.end_of(&given.target, start);
        if distance(start, end) <= self.radius {
            let message = "the first move of cutter compensation is not longer than the radius";
            return Err(ReadRemark::new(at, message, "begin further away"));
        }
        let across = self.side.across(unit(minus(end, start)));
        let reached = plus(end, scaled(across, self.radius));
        self.follow(control, late);
        self.begin = start;
        self.wait(given, reached, OffsetWay::Line { direction: across })?;
        (self.programmed, self.reached) = (Some(end), reached);
        Ok(())
    }

    /// Compensates an arc.
    pub(super) fn arc(
        &mut self,
        control: &mut ControlState,
        given: &ContourMove,
        programmed: &ProgrammedArc,
        late: VecDeque<Step>,
    ) -> Result<(), ReadRemark> {
        let at = given.target.at;
        let start = match self.programmed {
            Some(programmed) => programmed,
            None => self.start(control, at)?,
        };
        let end = self.end_of(&given.target, start);
        let way = self.programmed_way(control, [start, end], programmed, at)?;
        let center = plus(start, way.center);
        let turns = i32::try_from(programmed.turns).unwrap_or(i32::MAX);
        let turn = if way.sweep > 0.0 { turns } else { -turns };
        let arc = ContourArc { center, radius: distance(center, end), turn: f64::from(turn) };
        let inside = self.side.is_inside(arc.turn);
        if inside && arc.radius <= self.radius {
            let message = format!(
                "an arc of radius {:.4} mm inside of which the cutter does not fit",
                arc.radius
            );
            return Err(ReadRemark::new(at, message, SMALLER));
        }
        let to_cutter = |point: [f64; 2]| {
            let out = unit(minus(point, center));
            scaled(out, if inside { -self.radius } else { self.radius })
        };
        let reached = plus(end, to_cutter(end));
        if self.programmed.is_none() {
            return self.entry_arc(control, given, [start, end, reached], &arc, late);
        }
        let corner = self.corner_at(start);
        let held = self.held();
        let across = unit(to_cutter(start));
        match corner.kind_to_arc(across, &arc) {
            CornerKind::Inside => {
                let meet = match held {
                    Some(WaitingMove { way: way @ OffsetWay::Arc { .. }, end, .. }) => {
                        corner.arc_to_arc(way, end, &arc)
                    }
                    _ => corner.line_to_arc(&arc),
                };
                self.meet(control, meet, at)?;
                self.follow(control, late);
            }
            CornerKind::Outside => {
                self.keep_end(control, at)?;
                control.steps.extend(late);
                let mid = plus(start, scaled(across, self.radius));
                self.roll(control, given, mid, arc.radius * way.sweep.abs())?;
            }
            CornerKind::Smooth => {
                self.keep_end(control, at)?;
                control.steps.extend(late);
                self.begin = self.reached;
            }
        }
        self.wait(given, reached, OffsetWay::Arc { center, turn, sweep: way.sweep })?;
        (self.programmed, self.reached) = (Some(end), reached);
        Ok(())
    }

    /// Compensates the first move, an arc: it begins where the cutter is and ends beside its end.
    fn entry_arc(
        &mut self,
        control: &mut ControlState,
        given: &ContourMove,
        [start, end, reached]: [[f64; 2]; 3],
        arc: &ContourArc,
        late: VecDeque<Step>,
    ) -> Result<(), ReadRemark> {
        let at = given.target.at;
        if distance(start, end) <= self.radius {
            let message = "the first arc of cutter compensation is not longer than the radius";
            return Err(ReadRemark::new(at, message, "begin further away"));
        }
        // The centre lies on the line from the end to the programmed centre, as far from the start as
        // from the end: |c - s|^2 = |c - e|^2 with c = e + t d gives t = |s - e|^2 / (2 (s - e) d).
        let towards = unit(minus(arc.center, reached));
        let chord = minus(start, reached);
        let along = dot(chord, towards);
        if (along / distance(start, reached)).abs() < 1e-6 {
            let message = "an arc that cannot lead to the side of the contour";
            return Err(ReadRemark::new(at, message, "begin with a straight move"));
        }
        let center = plus(reached, scaled(towards, dot(chord, chord) / (2.0 * along)));
        self.follow(control, late);
        self.begin = start;
        let turn = if arc.turn > 0.0 { 1 } else { -1 };
        if distance(self.corner, [0.0; 2]) > 0.0 {
            // The corner of a turning tool goes to its place before the arc.
            let still = ContourMove { target: MoveTarget::new(at, given.target.column), ..*given };
            self.wait(&still, start, OffsetWay::Line { direction: [0.0; 2] })?;
            self.release(control)?;
        }
        let angle = sweep(center, [start, reached], turn);
        self.wait(given, reached, OffsetWay::Arc { center, turn, sweep: angle })?;
        (self.programmed, self.reached) = (Some(end), reached);
        Ok(())
    }

    /// Returns the programmed arc from its start.
    fn programmed_way(
        &self,
        control: &ControlState,
        [start, end]: [[f64; 2]; 2],
        programmed: &ProgrammedArc,
        at: usize,
    ) -> Result<Arc, ReadRemark> {
        let mut probe = MoveTarget::new(at, 0);
        for (slot, distance) in self.slots.into_iter().zip(minus(end, start)) {
            probe.set(slot, distance, DistanceMode::Incremental);
        }
        let form = match programmed.form {
            ArcForm::Center(center) if programmed.absolute => ArcForm::Center(minus(center, start)),
            form => form,
        };
        let ProgrammedArc { sense, turns, rounded, .. } = *programmed;
        match arc::way(
            control,
            &probe,
            &GivenArc { plane: self.slots, form, sense, turns, rounded },
        )? {
            Way::Arc(arc) => Ok(arc),
            Way::Line => Err(ReadRemark::new(at, "an arc that is a line", "")),
        }
    }

    fn corner_at(&self, at: [f64; 2]) -> ContourCorner {
        ContourCorner { at, before: self.reached, side: self.side, radius: self.radius }
    }

    /// Returns the end of a move in the plane, from a programmed point.
    fn end_of(&self, target: &MoveTarget, from: [f64; 2]) -> [f64; 2] {
        let mut end = from;
        for (end, slot) in end.iter_mut().zip(self.slots) {
            match target.get(slot) {
                Some(word) if target.is_incremental(slot) => *end += word,
                Some(word) => *end = word,
                None => {}
            }
        }
        end
    }

    fn start(&self, control: &ControlState, at: usize) -> Result<[f64; 2], ReadRemark> {
        let [u, v] = self.slots;
        let known = control.reading(u).zip(control.reading(v));
        let (u, v) = known.ok_or_else(|| {
            let message = "cutter compensation from a position that the program does not state";
            ReadRemark::new(at, message, "program both axes of its plane absolutely before it")
        })?;
        Ok([u, v])
    }

    /// Returns the first move that waits.
    fn held(&self) -> Option<WaitingMove> {
        self.waiting.iter().find_map(|step| match step {
            WaitingStep::Move(held) => Some(*held),
            WaitingStep::Other(_) => None,
        })
    }

    fn wait(
        &mut self,
        given: &ContourMove,
        end: [f64; 2],
        way: OffsetWay,
    ) -> Result<(), ReadRemark> {
        let ContourMove { line, mut target, pace } = *given;
        if self.waiting.len() >= MOST_WAITING {
            let message = format!(
                "more than {MOST_WAITING} lines between two moves of a compensated contour"
            );
            return Err(ReadRemark::new(target.at, message, "write G40 before them"));
        }
        for slot in self.slots {
            target.unset(slot);
        }
        self.waiting.push_back(WaitingStep::Move(WaitingMove { line, target, end, way, pace }));
        Ok(())
    }

    /// Runs the moves that wait to their own ends: the next one leads on from there.
    fn keep_end(&mut self, control: &mut ControlState, at: usize) -> Result<(), ReadRemark> {
        // A line that is shorter than the corner before it would run backwards.
        if let Some(WaitingMove { way: OffsetWay::Line { direction }, end, .. }) = self.held()
            && dot(direction, minus(end, self.begin)) < 0.0
        {
            return Err(gouging_corner(at));
        }
        self.release(control)
    }

    /// Ends the moves that wait where they meet the next one, and runs them.
    fn meet(
        &mut self,
        control: &mut ControlState,
        meet: Option<[f64; 2]>,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let gouges = || gouging_corner(at);
        let meet = meet.ok_or_else(gouges)?;
        let (longer, mismatch) =
            if control.inch { (LONGER_INCH, MISMATCH * INCH) } else { (LONGER, MISMATCH) };
        for step in &mut self.waiting {
            let WaitingStep::Move(held) = step else { continue };
            match held.way {
                OffsetWay::Line { direction } => {
                    // Backwards: the corner lies before the beginning of the line.
                    if dot(direction, minus(meet, self.begin)) < 0.0 {
                        return Err(gouges());
                    }
                }
                OffsetWay::Arc { center, turn, sweep: programmed } => {
                    let now = sweep_left(center, [self.begin, meet], turn, programmed);
                    let off = (distance(center, held.end) - distance(center, meet)).abs();
                    if off > mismatch || now.abs() > programmed.abs() + longer {
                        return Err(gouges());
                    }
                }
            }
            held.end = meet;
        }
        self.release(control)?;
        self.begin = meet;
        Ok(())
    }

    /// Rolls about an outer corner, before the next move.
    fn roll(
        &mut self,
        control: &mut ControlState,
        given: &ContourMove,
        mid: [f64; 2],
        length: f64,
    ) -> Result<(), ReadRemark> {
        let center = self.programmed.unwrap_or(mid);
        // Clockwise on the left side.
        let turn = if self.side == CutterSide::Left { -1 } else { 1 };
        let angle = sweep(center, [self.reached, mid], turn);
        let way = if given.pace == Pace::Rapid {
            OffsetWay::Line { direction: [0.0; 2] }
        } else {
            OffsetWay::Arc { center, turn, sweep: angle }
        };
        let pace = match given.pace {
            // The block's time is that of its own move: the corner runs as fast.
            Pace::Inverse { seconds } => {
                let share = if length > 0.0 { self.radius * angle.abs() / length } else { 1.0 };
                Pace::Inverse { seconds: seconds * share }
            }
            pace => pace,
        };
        let target = MoveTarget::new(given.target.at, given.target.column);
        self.run(control, &WaitingMove { line: given.line, target, end: mid, way, pace })?;
        self.begin = mid;
        Ok(())
    }

    /// Runs everything that waits.
    pub(super) fn release(&mut self, control: &mut ControlState) -> Result<(), ReadRemark> {
        while let Some(step) = self.waiting.pop_front() {
            match step {
                WaitingStep::Move(held) => self.run(control, &held)?,
                WaitingStep::Other(step) => control.steps.push_back(step),
            }
        }
        Ok(())
    }

    fn run(&self, control: &mut ControlState, held: &WaitingMove) -> Result<(), ReadRemark> {
        let mut target = held.target;
        let end = plus(held.end, self.corner);
        for (slot, value) in self.slots.into_iter().zip(end) {
            target.set(slot, value, DistanceMode::Absolute);
        }
        let way = match held.way {
            OffsetWay::Line { .. } => Way::Line,
            OffsetWay::Arc { center, turn, sweep: programmed } => {
                let start = self.start(control, target.at)?;
                let center = plus(center, self.corner);
                let whole = TAU * f64::from(turn.abs() - 1) * f64::from(turn.signum());
                let angle = sweep_left(center, [start, end], turn, programmed) + whole;
                Way::Arc(Arc { plane: self.slots, center: minus(center, start), sweep: angle })
            }
        };
        control.go(held.line, target, held.pace, way)
    }

    /// Ends compensation: what waits is run, and the next move leads from beside the contour to where it is programmed.
    pub(super) fn end(mut self, control: &mut ControlState) -> Result<(), ReadRemark> {
        self.release(control)?;
        if let Some(programmed) = self.programmed {
            control.restate(self.slots, programmed);
        }
        Ok(())
    }
}

/// Fault of a corner that is too narrow.
fn gouging_corner(at: usize) -> ReadRemark {
    let message = "a corner into which the cutter does not fit without gouging";
    ReadRemark::new(at, message, SMALLER)
}

/// Returns a word of a line as a length \[mm\].
pub(super) fn length_word(
    control: &ControlState,
    block: &mut GcodeBlock,
    letter: char,
) -> Option<f64> {
    block.take(letter).map(|word| control.scale() * word.value)
}
