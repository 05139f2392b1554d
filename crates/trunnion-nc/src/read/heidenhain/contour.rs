//! Elements of a contour that wait for the next one: `RND R5`, `CHF 2`, `APPR LT`, `APPR LCT`.
//!
//! A contour element waits until the next block, which may be a corner; a corner waits until the next element tells
//! where it begins and ends. Steps that are made in between wait behind the element.

use super::element::{ElementWay, FilletSide, PlaneElement, cross, dot, minus, norm, plus, scaled};
use crate::math;
use crate::read::control::{ControlState, SLOTS};
use crate::read::log::ReadRemark;
use crate::read::step::{Arc, Frame, Move, Pace, Step, Way};
use std::collections::VecDeque;

/// Steps that may wait behind an element; more are no contour.
const MOST_WAITING: usize = 10_000;

/// Sine of an angle below which two directions are the same.
const SAME_DIRECTION: f64 = 1e-9;

/// Positions, as words of the work offset \[mm, rad\].
pub(super) type Place = [Option<f64>; SLOTS];

/// Form of the corner between two elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CornerForm {
    /// `RND`: an arc of this radius \[mm\].
    Round(f64),
    /// `CHF`: a chamfer that takes this length off either side \[mm\].
    Chamfer(f64),
    /// `APPR LT`: the last length of the way to the second element is in its direction \[mm\].
    Tangent(f64),
    /// `APPR LCT`: the way ends with an arc of this radius into the direction of the second element \[mm\].
    TangentArc(f64),
}

/// A corner whose second element is still to come.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenCorner {
    pub(super) form: CornerForm,
    /// Pace on the corner itself.
    pub(super) pace: Pace,
    pub(super) line: u32,
    pub(super) at: usize,
    pub(super) column: u32,
}

/// A move of the contour with its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContourStep {
    pub(super) step: Move,
    pub(super) start: Place,
    pub(super) end: Place,
    /// Slots of the plane.
    pub(super) plane: [usize; 2],
}

/// An element that waits, and everything behind it.
#[derive(Debug)]
pub(super) struct HeldElement {
    element: ContourStep,
    corner: Option<OpenCorner>,
    behind: VecDeque<Step>,
}

impl HeldElement {
    pub(super) fn new(element: &ContourStep, corner: Option<OpenCorner>) -> Self {
        Self { element: *element, corner, behind: VecDeque::new() }
    }

    /// Returns the corner that waits for its second element.
    pub(super) fn corner(&self) -> Option<&OpenCorner> {
        self.corner.as_ref()
    }

    /// Opens a corner behind the element.
    pub(super) fn open(&mut self, corner: OpenCorner) {
        self.corner = Some(corner);
    }

    /// Takes steps that belong behind the element.
    pub(super) fn follow(&mut self, steps: VecDeque<Step>) -> Result<(), ReadRemark> {
        if self.behind.len() + steps.len() > MOST_WAITING {
            let message = format!("more than {MOST_WAITING} steps between two contour elements");
            return Err(ReadRemark::new(0, message, "write the second element behind the corner"));
        }
        self.behind.extend(steps);
        Ok(())
    }

    /// Runs the element and everything behind it.
    pub(super) fn release(self, control: &mut ControlState) {
        control.steps.push_back(Step::Move(self.element.step));
        control.steps.extend(self.behind);
    }

    /// Closes the corner with its second element: runs the first and the corner, and returns the rest of the second.
    pub(super) fn close(
        self,
        control: &mut ControlState,
        second: &ContourStep,
    ) -> Result<ContourStep, ReadRemark> {
        let Some(corner) = self.corner else {
            self.release(control);
            return Ok(*second);
        };
        let ends = self.element.element(corner.at)?;
        let next = second.element(corner.at)?;
        let parts = match corner.form {
            CornerForm::Round(radius) => rounded(ends, next, radius, corner.at)?,
            CornerForm::Chamfer(length) => chamfered(ends, next, length, corner.at)?,
            CornerForm::Tangent(length) => approached(ends, next, length, corner.at)?,
            CornerForm::TangentArc(radius) => approached_on_arc(ends, next, radius, corner.at)?,
        };
        let CornerParts { first, between, second: rest } = parts;
        let first_step = self.element.on(&first, corner.at)?;
        control.steps.push_back(Step::Move(first_step.step));
        control.steps.extend(self.behind);
        if let Some(between) = between {
            let step = Move {
                line: corner.line,
                column: corner.column,
                pace: corner.pace,
                ..first_step.step
            };
            let between = ContourStep { step, start: first_step.end, ..first_step }
                .alone_on(&between, corner.at)?;
            control.steps.push_back(Step::Move(between.step));
        }
        second.on(&rest, corner.at)
    }
}

/// The two elements with what is between them.
struct CornerParts {
    first: PlaneElement,
    between: Option<PlaneElement>,
    second: PlaneElement,
}

impl ContourStep {
    /// Returns the element in its plane.
    pub(super) fn element(&self, at: usize) -> Result<PlaneElement, ReadRemark> {
        let outside = |why: &str| {
            let message = format!("a corner or an approach beside a move {why}");
            Err(ReadRemark::new(at, message, "write the contour as L, C and CR"))
        };
        if !matches!(self.step.frame, Frame::Work { .. })
            || self.step.axis.is_some()
            || self.step.sixth.is_some()
        {
            return outside("with M91, tool vectors or a sixth axis");
        }
        // Corners are of the plane: nothing else may move on either side.
        let moves = |slot: usize| {
            let word = self.step.words.get(slot).copied().flatten().is_some();
            let [from, to] = [self.start, self.end].map(|of| of.get(slot).copied().flatten());
            let still = from.zip(to).is_some_and(|(from, to)| (from - to).abs() <= 0.0);
            word && !still
        };
        if (0..self.step.words.len()).any(|slot| !self.plane.contains(&slot) && moves(slot)) {
            return outside("that leaves the plane");
        }
        let point = |place: &Place| {
            let [u, v] = self.plane.map(|slot| place.get(slot).copied().flatten());
            u.zip(v).map(|(u, v)| [u, v])
        };
        let Some((start, end)) = point(&self.start).zip(point(&self.end)) else {
            let message = "a corner or an approach at a position that the program does not state";
            let help = "program both axes of the plane absolutely before it";
            return Err(ReadRemark::new(at, message, help));
        };
        let way = match self.step.way {
            Way::Line => ElementWay::Line,
            Way::Arc(arc) if arc.plane == self.plane => {
                ElementWay::Arc { center: plus(start, arc.center), sweep: arc.sweep }
            }
            Way::Arc(_) => return outside("in another plane"),
        };
        Ok(PlaneElement { start, end, way })
    }

    /// Returns the direction in which the element ends.
    pub(super) fn heading(&self) -> Option<[f64; 2]> {
        self.element(0).ok()?.last_direction()
    }

    /// Returns the step on another element of its plane, whose words are all absolute then.
    fn on(mut self, element: &PlaneElement, at: usize) -> Result<Self, ReadRemark> {
        if self.step.incremental {
            for (word, end) in self.step.words.iter_mut().zip(self.end) {
                *word = word.and(end);
            }
            self.step.incremental = false;
        }
        self.put(element, at)?;
        Ok(self)
    }

    /// Returns a step on an element that moves the plane alone.
    fn alone_on(mut self, element: &PlaneElement, at: usize) -> Result<Self, ReadRemark> {
        self.step.words = [None; 5];
        self.step.incremental = false;
        self.put(element, at)?;
        Ok(self)
    }

    fn put(&mut self, element: &PlaneElement, at: usize) -> Result<(), ReadRemark> {
        for (axis, slot) in self.plane.into_iter().enumerate() {
            let place = (element.start.get(axis).copied(), element.end.get(axis).copied());
            if let (Some(start), (Some(from), Some(to))) = (self.start.get_mut(slot), place)
                && let (Some(end), Some(word)) =
                    (self.end.get_mut(slot), self.step.words.get_mut(slot))
            {
                (*start, *end, *word) = (Some(from), Some(to), Some(to));
            }
        }
        self.step.way = match element.way {
            ElementWay::Line => Way::Line,
            ElementWay::Arc { center, sweep } => {
                Way::Arc(Arc { plane: self.plane, center: minus(center, element.start), sweep })
            }
        };
        if element.start.iter().chain(&element.end).all(|value| value.is_finite()) {
            return Ok(());
        }
        Err(ReadRemark::new(at, "a corner that has no place", "look at the two elements"))
    }
}

fn unfit(at: usize, what: &str) -> ReadRemark {
    let message = format!("{what} does not fit between its two elements");
    ReadRemark::new(at, message, "make it smaller, or look at the elements")
}

/// Returns the directions at a corner.
fn directions(
    first: &PlaneElement,
    second: &PlaneElement,
    at: usize,
) -> Result<[[f64; 2]; 2], ReadRemark> {
    let pair = first.last_direction().zip(second.first_direction());
    let (before, behind) = pair.ok_or_else(|| {
        ReadRemark::new(at, "a corner at an element of no length", "look at its ends")
    })?;
    Ok([before, behind])
}

/// Puts an arc that touches both elements between them.
fn rounded(
    first: PlaneElement,
    second: PlaneElement,
    radius: f64,
    at: usize,
) -> Result<CornerParts, ReadRemark> {
    let [before, behind] = directions(&first, &second, at)?;
    let turn = cross(before, behind);
    if turn.abs() < SAME_DIRECTION {
        if dot(before, behind) > 0.0 {
            // The elements touch already.
            return Ok(CornerParts { first, between: None, second });
        }
        return Err(unfit(at, "RND between opposite directions"));
    }
    let side = if turn > 0.0 { FilletSide::Left } else { FilletSide::Right };
    let corner = first.end;
    // The centre is as far from both elements, on the side to which the contour turns.
    let centers = first.centers_beside(&second, side.sign() * radius);
    let mut best: Option<(f64, CornerParts)> = None;
    for center in centers.into_iter().flatten() {
        let touch = first.foot(center).zip(second.foot(center));
        let Some((from, to)) = touch else { continue };
        let Some((one, other)) = first.up_to(from).zip(second.from(to)) else { continue };
        let away = norm(minus(center, corner));
        if best.as_ref().is_none_or(|(least, _)| away < *least) {
            let sweep = side.sweep(minus(from, center), minus(to, center));
            let way = ElementWay::Arc { center, sweep };
            let between = Some(PlaneElement { start: from, end: to, way });
            best = Some((away, CornerParts { first: one, between, second: other }));
        }
    }
    best.map(|(_, parts)| parts).ok_or_else(|| unfit(at, &format!("RND R{radius}")))
}

/// Cuts a corner between two straight elements off.
fn chamfered(
    first: PlaneElement,
    second: PlaneElement,
    length: f64,
    at: usize,
) -> Result<CornerParts, ReadRemark> {
    let [before, behind] = directions(&first, &second, at)?;
    if first.way != ElementWay::Line || second.way != ElementWay::Line {
        let help = "write the chamfer as L";
        return Err(ReadRemark::new(at, "CHF beside an arc", help));
    }
    let from = minus(first.end, scaled(before, length));
    let to = plus(second.start, scaled(behind, length));
    let cut = first.up_to(from).zip(second.from(to));
    let (first, second) = cut.ok_or_else(|| unfit(at, &format!("CHF {length}")))?;
    let between = Some(PlaneElement { start: from, end: to, way: ElementWay::Line });
    Ok(CornerParts { first, between, second })
}

/// Leads to the second element in its direction.
fn approached(
    first: PlaneElement,
    second: PlaneElement,
    length: f64,
    at: usize,
) -> Result<CornerParts, ReadRemark> {
    let direction = second.first_direction();
    let direction = direction.ok_or_else(|| unfit(at, "APPR"))?;
    let auxiliary = minus(first.end, scaled(direction, length));
    let between = Some(PlaneElement { start: auxiliary, end: first.end, way: ElementWay::Line });
    Ok(CornerParts { first: PlaneElement { end: auxiliary, ..first }, between, second })
}

/// Leads to the second element on a line and an arc that touches both.
fn approached_on_arc(
    first: PlaneElement,
    second: PlaneElement,
    radius: f64,
    at: usize,
) -> Result<CornerParts, ReadRemark> {
    let direction = second.first_direction();
    let direction = direction.ok_or_else(|| unfit(at, "APPR"))?;
    // The way backwards departs from the element.
    let back = departure(first.end, scaled(direction, -1.0), radius, first.start);
    let back = back.ok_or_else(|| unfit(at, &format!("the arc R{radius}")))?;
    let [arc, line] = back.map(PlaneElement::reversed);
    Ok(CornerParts { first: line, between: Some(arc), second })
}

/// Returns the arc and the line that leave `start` in a direction and end at `end`; `None`: there are none.
pub(super) fn departure(
    start: [f64; 2],
    direction: [f64; 2],
    radius: f64,
    end: [f64; 2],
) -> Option<[PlaneElement; 2]> {
    let side = if cross(direction, minus(end, start)) > 0.0 {
        FilletSide::Left
    } else {
        FilletSide::Right
    };
    let center = plus(start, scaled(FilletSide::Left.normal(direction), side.sign() * radius));
    let to_end = minus(end, center);
    // The tangent from the end to the circle has the length sqrt(D^2 - R^2).
    let tangent = (dot(to_end, to_end) - radius * radius).max(0.0).sqrt();
    if tangent.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    // to_end = R u + L t, with t square to u in the sense of the arc.
    let angle = math::atan2(to_end[1], to_end[0]) - side.sign() * math::atan2(tangent, radius);
    let touch = plus(center, [radius * math::cos(angle), radius * math::sin(angle)]);
    let sweep = side.sweep(minus(start, center), minus(touch, center));
    Some([
        PlaneElement { start, end: touch, way: ElementWay::Arc { center, sweep } },
        PlaneElement { start: touch, end, way: ElementWay::Line },
    ])
}
