//! Axes of a table of setpoints against their limits.

use super::least::RateBound;
use super::options::{MotionOptions, shown};
use crate::machine::{Axis, AxisKind};
use crate::types::{AXES, Interval};
use std::fmt;

/// Result of an audit of setpoints.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MotionReport {
    /// In the order of the machine's axes.
    pub axes: [AxisMotion; AXES],
    /// Rows read.
    pub rows: usize,
    /// Time from the first to the last \[s\].
    pub duration: f64,
    /// Time from row to row \[s\].
    pub period: f64,
    /// Everything that breaks a limit or the period.
    pub findings: Vec<MotionFinding>,
}

/// One axis over all rows.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AxisMotion {
    /// Name of the axis.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Smallest and largest position \[mm or rad\].
    pub range: Interval,
    /// Velocity, acceleration and jerk against their limits. Velocity is compared with that of rapids, since a row does not
    /// state if it is one.
    pub rates: [RowRatio; 3],
}

/// A rate against its limit, the rounding of the table taken off.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RowRatio {
    /// Largest rate over limit.
    pub worst: f64,
    /// Line where it was found; 0 if nothing moves.
    pub line: u32,
    /// The rows around the line require the rate; the row itself does not state it.
    pub between: bool,
    /// Count of rows above the limit.
    pub broken: usize,
    last: u32,
}

/// Rows that do not keep the period.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Unevenness {
    /// Line of the first.
    pub line: u32,
    /// Time since the row before it \[s\].
    pub step: f64,
    /// Number of such rows.
    pub rows: usize,
    /// The period \[s\].
    pub period: f64,
}

/// Something wrong with a table of setpoints.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum MotionFinding {
    /// Rows that do not keep the period.
    Period(Unevenness),
    /// The first or the last row is not at rest.
    Moving {
        /// Name of the axis.
        axis: String,
        /// Of a linear or a rotary axis.
        kind: AxisKind,
        /// Line of the row.
        line: u32,
        /// `first` or `last`.
        which: &'static str,
        /// `true` if the acceleration is not 0, `false` if the velocity is not.
        accelerates: bool,
        /// Its value \[mm, rad and s\].
        value: f64,
    },
    /// An axis leaves its travel.
    Travel {
        /// Name of the axis.
        axis: String,
        /// Of a linear or a rotary axis.
        kind: AxisKind,
        /// Line of the row farthest outside.
        line: u32,
        /// Position there \[mm or rad\].
        value: f64,
        /// Distance beyond the end of travel \[mm or rad\].
        excess: f64,
        /// Count of rows outside.
        rows: usize,
    },
    /// A rate above its limit.
    Rate {
        /// Name of the axis.
        axis: String,
        /// `velocity`, `acceleration` or `jerk`.
        rate: &'static str,
        /// Largest ratio.
        worst: RowRatio,
    },
}

impl fmt::Display for MotionFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Period(Unevenness { line, step, rows, period }) => write!(
                f,
                "line {line}: {:.6} ms after the row before, the period is {:.6} ms; rows that do not keep it: {rows}",
                1e3 * step,
                1e3 * period
            ),
            Self::Moving { axis, kind, line, which, accelerates, value } => {
                let value = shown(*kind, *value);
                let length = if *kind == AxisKind::Rotary { "deg" } else { "mm" };
                let (does, per) =
                    if *accelerates { ("accelerates", "s²") } else { ("moves", "s") };
                write!(
                    f,
                    "line {line}: {axis} {does} in the {which} row, with {value} {length}/{per}; \
                     the machine stands still there"
                )
            }
            Self::Travel { axis, kind, line, value, excess, rows } => write!(
                f,
                "line {line}: {axis} at {} is {} outside its travel; rows outside: {rows}",
                kind.format_value(*value),
                kind.format_value(*excess)
            ),
            Self::Rate { axis, rate, worst } => write!(f, "{axis} {rate} {worst}"),
        }
    }
}

impl fmt::Display for RowRatio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let asked = if self.between { ", asked for by the rows around it" } else { "" };
        let Self { worst, line, broken, .. } = self;
        write!(f, "is {worst:.4} times its limit at line {line}{asked}; rows above it: {broken}")
    }
}

/// Conversions between degrees and radians, and differences of rows whose own rounding is taken off, are known to
/// some units in the last place.
const ROUNDING: f64 = 1e-9;
/// Names of the derivatives.
const RATES: [&str; 3] = ["velocity", "acceleration", "jerk"];

impl RowRatio {
    const NONE: Self = Self { worst: 0.0, line: 0, between: false, broken: 0, last: 0 };

    fn take(&mut self, worst: f64, line: u32, origin: RateOrigin) {
        if worst > self.worst {
            (self.worst, self.line) = (worst, line);
            self.between = origin == RateOrigin::Difference;
        }
        // A row is counted once, however many ways it breaks the limit.
        if worst > 1.0 + ROUNDING && line != self.last {
            self.broken += 1;
            self.last = line;
        }
    }
}

/// Origin of a rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RateOrigin {
    /// The row states it.
    Row,
    /// The rows around it require it.
    Difference,
}

/// Row farthest outside the travel of an axis.
#[derive(Debug, Clone, Copy)]
struct OutsideTravel {
    line: u32,
    /// Position \[mm or rad\].
    value: f64,
    /// Distance beyond the end of travel \[mm or rad\].
    excess: f64,
    /// Number of rows outside.
    rows: usize,
}

/// Running results of an axis.
#[derive(Debug, Clone)]
pub(super) struct AxisState<'a> {
    axis: &'a Axis,
    range: [f64; 2],
    /// Row farthest outside the travel, and the number of rows outside.
    outside: Option<OutsideTravel>,
    rates: [RowRatio; 3],
}

impl<'a> AxisState<'a> {
    pub(super) fn new(axis: &'a Axis) -> Self {
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Self { axis, range, outside: None, rates: [RowRatio::NONE; 3] }
    }

    pub(super) fn name(&self) -> String {
        self.axis.name.clone()
    }

    pub(super) fn kind(&self) -> AxisKind {
        self.axis.kind
    }

    /// Limit of a derivative: 1 velocity, 2 acceleration, 3 jerk.
    pub(super) fn limit(&self, order: usize) -> f64 {
        match order {
            // Rows do not state if they are rapid, so the larger of both velocity limits counts.
            1 => self.axis.vel.max(self.axis.rapid),
            2 => self.axis.acc,
            _ => self.axis.jerk,
        }
    }

    /// Bounds the changes of position and derivatives below the one of order `last` from `state` within `time`, if that
    /// one keeps its limit.
    pub(super) fn drift(&self, state: &[f64; 4], last: usize, time: f64) -> [f64; 3] {
        let mut drift = [0.0; 3];
        // |x(t) - x| <= t max |x'|, and max |x'| <= |x'(0)| + its own change: from the limited derivative down.
        let mut above = self.limit(last);
        for order in (0..last).rev() {
            drift[order] = time * above;
            above = state[order].abs() + drift[order];
        }
        drift
    }

    /// Takes in the values of a row: position and as many derivatives as it has.
    pub(super) fn visit(
        &mut self,
        values: &[f64; 4],
        line: u32,
        options: &MotionOptions,
        index: usize,
    ) {
        let rounding = |order: usize| options.rounding[order][index];
        let q = values[0];
        self.range = [self.range[0].min(q), self.range[1].max(q)];
        let [low, high] = self.axis.limits.ends();
        let excess = (low - q).max(q - high);
        if excess > rounding(0) + ROUNDING {
            let first = OutsideTravel { line, value: q, excess, rows: 0 };
            let outside = self.outside.get_or_insert(first);
            let rows = outside.rows + 1;
            *outside = if excess > outside.excess { first } else { *outside };
            outside.rows = rows;
        }
        for (order, value) in values.iter().enumerate().take(options.derivatives + 1).skip(1) {
            let rate = RateBound { value: *value, slack: rounding(order) };
            self.take(order, rate, line, RateOrigin::Row);
        }
    }

    /// Takes in a derivative of an order.
    pub(super) fn take(&mut self, order: usize, rate: RateBound, line: u32, origin: RateOrigin) {
        let limit = self.limit(order);
        let least = (rate.value.abs() - rate.slack).max(0.0);
        self.rates[order - 1].take(least / limit, line, origin);
    }

    /// Returns a jerk up to which a bound changes neither the worst ratio nor the count.
    pub(super) fn known_jerk(&self) -> f64 {
        self.rates[2].worst.min(1.0) * self.axis.jerk
    }

    /// Returns the broken limits of the axis, judging the first `judged` derivatives.
    pub(super) fn findings(&self, judged: usize) -> impl Iterator<Item = MotionFinding> {
        let axis = || self.axis.name.clone();
        let travel = self.outside.map(|outside| {
            let OutsideTravel { line, value, excess, rows } = outside;
            MotionFinding::Travel { axis: axis(), kind: self.axis.kind, line, value, excess, rows }
        });
        let rates = RATES.into_iter().zip(self.rates).take(judged).filter(|(_, r)| r.broken > 0);
        let rates: Vec<MotionFinding> =
            rates.map(|(rate, worst)| MotionFinding::Rate { axis: axis(), rate, worst }).collect();
        travel.into_iter().chain(rates)
    }

    pub(super) fn finish(self) -> AxisMotion {
        let Self { axis, range, rates, .. } = self;
        AxisMotion { name: axis.name.clone(), kind: axis.kind, range: range.into(), rates }
    }
}
