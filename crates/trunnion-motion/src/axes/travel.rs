//! Ends of travel: the whole turns that fit, and the excess of those that do not.

use super::axis_bounds::AxisBounds;
use super::branch_run::{BranchRun, NodePosition, PathSegment};
use super::error::AxesError;
use super::options::AxesOptions;
use crate::machine::{Axis, AxisKind, FIRST_ROTARY, PreferredSign, SECOND_ROTARY};
use crate::math::angle::{unwrap_near, wrap};
use crate::types::{AXES, Interval, TRAVEL_ROUNDING};
use std::cmp::Ordering;
use std::f64::consts::TAU;
use std::iter::successors;

/// The ends of travel of a machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct TravelLimits<'a> {
    pub(super) axes: &'a [Axis; AXES],
}

/// An axis beyond its travel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct TravelExcess {
    pub(super) axis: usize,
    pub(super) value: f64,
    pub(super) limit: f64,
    pub(super) excess: f64,
}

impl TravelLimits<'_> {
    fn limits(self, axis: usize) -> Interval {
        self.axes.get(axis).map_or(Interval::point(0.0), |axis| axis.limits)
    }

    /// Returns `true` if an axis lacks an end of travel.
    fn endless(self, axis: usize) -> bool {
        !self.limits(axis).is_bounded()
    }

    /// Returns the whole turns `[first, last]` that keep a rotary inside travel; none if `first > last`. An
    /// axis without ends gets turn 0 alone: its turn follows from where it comes from.
    fn window(self, axis: usize, [from, to]: [f64; 2]) -> [f64; 2] {
        if self.endless(axis) {
            return [0.0; 2];
        }
        // Least n with from + 2π n >= low, and largest n with to + 2π n <= high.
        let Interval { low, high } = self.limits(axis);
        let first = ((low - TRAVEL_ROUNDING - from) / TAU).ceil();
        // -0 and 0 are one turn, and turns are compared by their bits.
        [first + 0.0, ((high + TRAVEL_ROUNDING - to) / TAU).floor() + 0.0]
    }

    /// Returns `true` if the linear axes stay inside travel.
    pub(super) fn slides_inside(self, bounds: &AxisBounds) -> bool {
        self.axes.iter().zip(&bounds.0).take(FIRST_ROTARY).all(|(axis, [low, high])| {
            // Bounds hold between nodes as well, so that the whole interval is inside.
            let [least, most] = axis.limits.ends();
            *low >= least - TRAVEL_ROUNDING && *high <= most + TRAVEL_ROUNDING
        })
    }

    /// Returns the turns of both rotaries that keep all axes inside; none if a linear axis is outside.
    pub(super) fn turns(self, bounds: &AxisBounds) -> impl Iterator<Item = [f64; 2]> + use<> {
        let windows = self.slides_inside(bounds).then(|| self.windows(bounds));
        windows.into_iter().flat_map(|[first, second]| {
            each(first).flat_map(move |first| each(second).map(move |second| [first, second]))
        })
    }

    fn windows(self, bounds: &AxisBounds) -> [[f64; 2]; 2] {
        let [.., first, second] = bounds.0;
        [self.window(FIRST_ROTARY, first), self.window(SECOND_ROTARY, second)]
    }

    /// Returns the rotary moves from one position to another \[rad\]: the shorter way round where there
    /// are no ends.
    pub(super) fn moved(self, from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let turn = to[axis] - from[axis];
            if self.endless(FIRST_ROTARY + axis) { wrap(turn) } else { turn }
        })
    }

    /// Counts the rotaries on the side that they do not prefer.
    pub(super) fn unpreferred(self, at: [f64; 2]) -> usize {
        let rotaries = self.axes.iter().skip(FIRST_ROTARY).zip(at);
        rotaries.filter(|(axis, value)| wrong_side(axis, *value)).count()
    }

    /// Returns lower bounds of the rotary moves from any point of one part of a path to any of another
    /// \[rad\]; each part has its bounds and whole turns.
    pub(super) fn least_moved(
        self,
        from: &AxisBounds,
        from_turns: [f64; 2],
        to: &AxisBounds,
        to_turns: [f64; 2],
    ) -> [f64; 2] {
        let ends = |bounds: &AxisBounds, turns: [f64; 2], axis: usize| {
            let [.., first, second] = bounds.0;
            [first, second][axis].map(|end| end + TAU * turns[axis])
        };
        [0, 1].map(|axis| {
            // The gap between [a, b] and [c, d]. Without ends of travel whole turns may close it.
            let [[a, b], [c, d]] = [ends(from, from_turns, axis), ends(to, to_turns, axis)];
            if self.endless(FIRST_ROTARY + axis) { 0.0 } else { (c - b).max(a - d).max(0.0) }
        })
    }

    /// Counts the rotaries that are on the side they do not prefer all over a part of a path.
    pub(super) fn unpreferred_all_over(self, bounds: &AxisBounds, turns: [f64; 2]) -> usize {
        let [.., first, second] = bounds.0;
        let end = |end: usize| [first[end] + TAU * turns[0], second[end] + TAU * turns[1]];
        let [low, high] = [end(0), end(1)];
        // Each side is a half-line: an interval with both ends on it lies on it.
        let one = |axis: usize| {
            let only = |at: [f64; 2]| {
                self.axes.get(FIRST_ROTARY + axis).is_some_and(|of| wrong_side(of, at[axis]))
            };
            usize::from(only(low) && only(high))
        };
        one(0) + one(1)
    }

    /// Returns the axis farthest beyond its travel.
    pub(super) fn worst(self, bounds: &AxisBounds, offset: [f64; 2]) -> Option<TravelExcess> {
        let all = bounds.0.iter().enumerate().map(|(axis, [from, to])| {
            let offset = axis.checked_sub(FIRST_ROTARY).and_then(|at| offset.get(at)).copied();
            let [from, to] = [from, to].map(|value| value + offset.unwrap_or(0.0));
            // The larger of both excesses; negative where the axis is inside.
            let Interval { low, high } = self.limits(axis);
            if low - from > to - high {
                TravelExcess { axis, value: from, limit: low, excess: low - from }
            } else {
                TravelExcess { axis, value: to, limit: high, excess: to - high }
            }
        });
        all.filter(|one| one.excess > TRAVEL_ROUNDING).max_by(|a, b| self.compare(a, b))
    }

    /// Compares excesses by what they take to mend: another origin brings linear axes back, but no rotary.
    fn compare(self, a: &TravelExcess, b: &TravelExcess) -> Ordering {
        let rotary = |one: &TravelExcess| {
            self.axes.get(one.axis).is_some_and(|axis| axis.kind == AxisKind::Rotary)
        };
        rotary(a).cmp(&rotary(b)).then(a.excess.total_cmp(&b.excess))
    }

    /// Returns the whole turns that leave the rotaries least outside \[rad\]: the middle of the bounds next
    /// to the middle of the travel.
    fn least_turns(self, bounds: &AxisBounds) -> [f64; 2] {
        [FIRST_ROTARY, SECOND_ROTARY].map(|axis| {
            let middle = bounds.0.get(axis).map_or(0.0, |[from, to]| 0.5 * (from + to));
            if self.endless(axis) {
                0.0
            } else {
                unwrap_near(middle, self.limits(axis).middle()) - middle
            }
        })
    }

    /// Returns the error of a segment that no branch keeps inside travel: of each branch the worst node, of
    /// those the best. If the path may be interrupted by a retract, each cell has its own turns.
    pub(super) fn outside(self, segment: &PathSegment, options: &AxesOptions) -> AxesError {
        let whole = options.retract.is_none();
        let worst_of = |branch: &BranchRun| {
            let all = branch.all_cells(options);
            let mut bounds = AxisBounds::NONE;
            for cell in &all {
                bounds.merge(&cell.bounds);
            }
            // Without a retract one turn has to serve the whole segment.
            let cells = all.iter().enumerate().filter_map(|(index, cell)| {
                let offset = self.least_turns(if whole { &bounds } else { &cell.bounds });
                Some((index, self.worst(&cell.bounds, offset)?))
            });
            let (cell, beyond) = cells.max_by(|a, b| self.compare(&a.1, &b.1))?;
            let start = NodePosition { piece: segment.piece, ..NodePosition::default() };
            Some((branch.position(cell).unwrap_or(start), beyond))
        };
        let all = segment.branches.iter().filter_map(worst_of);
        let least = all.min_by(|a, b| self.compare(&a.1, &b.1));
        let (at, beyond) = least.unwrap_or_default();
        self.fault(at, &beyond)
    }

    /// Converts an excess at a node to an error with its remedy.
    pub(super) fn fault(self, at: NodePosition, beyond: &TravelExcess) -> AxesError {
        let NodePosition { piece, node, u } = at;
        let TravelExcess { axis, value, limit, excess } = *beyond;
        let name = self.axes.get(axis).map_or_else(String::new, |axis| axis.name.clone());
        let kind = self.axes.get(axis).map_or(AxisKind::Linear, |axis| axis.kind);
        let remedy = if kind == AxisKind::Rotary {
            format!("turn the setup, or split the path so that {name} can unwind on a link")
        } else {
            let way = if value > limit { "down" } else { "up" };
            format!(
                "move the workpiece origin so that {name} comes {way} by {excess:.3} mm, or turn the setup"
            )
        };
        AxesError::OutOfTravel { piece, node, u, axis: name, kind, value, limit, excess, remedy }
    }
}

/// Returns the whole numbers from `first` to `last`.
fn each([first, last]: [f64; 2]) -> impl Iterator<Item = f64> {
    let until = move |turn: f64| (turn <= last).then_some(turn);
    successors(until(first), move |turn| until(turn + 1.0))
}

/// Returns `true` if an axis is on the side that it does not prefer.
fn wrong_side(axis: &Axis, value: f64) -> bool {
    match axis.prefer {
        Some(PreferredSign::Positive) => value < 0.0,
        Some(PreferredSign::Negative) => value >= 0.0,
        None => false,
    }
}
