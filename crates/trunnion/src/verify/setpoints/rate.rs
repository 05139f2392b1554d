//! Axes of a table of setpoints against their limits.

use super::options::{MotionOptions, shown};
use crate::machine::{Axis, AxisKind};
use crate::types::AXES;
use std::fmt;

/// What an audit of setpoints found.
#[derive(Debug, Clone, PartialEq)]
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
pub struct AxisMotion {
    /// Name of the axis.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Smallest and largest position \[mm or rad\].
    pub range: [f64; 2],
    /// Velocity, acceleration and jerk against their limits; velocity against that of rapids, as rows do not say
    /// which is one.
    pub rates: [RowRatio; 3],
}

/// A rate against its limit, the rounding of the table taken off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowRatio {
    /// Largest rate over limit.
    pub worst: f64,
    /// Line where it was found; 0 if nothing moves.
    pub line: u32,
    /// Whether it is what the rows around it ask for, rather than what the row says.
    pub between: bool,
    /// Count of rows above the limit.
    pub broken: usize,
    last: u32,
}

/// Rows that do not keep the period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unevenness {
    /// Line of the first.
    pub line: u32,
    /// Time since the row before it \[s\].
    pub step: f64,
    /// How many there are.
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
        /// Whether it is the acceleration that is not 0, or the velocity.
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
        /// How far outside \[mm or rad\].
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
        /// How much.
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

    fn take(&mut self, worst: f64, line: u32, between: bool) {
        if worst > self.worst {
            (self.worst, self.line, self.between) = (worst, line, between);
        }
        // A row is counted once, however many ways it breaks the limit.
        if worst > 1.0 + ROUNDING && line != self.last {
            self.broken += 1;
            self.last = line;
        }
    }
}

/// Running results of an axis.
#[derive(Debug, Clone)]
pub(super) struct AxisState<'a> {
    axis: &'a Axis,
    range: [f64; 2],
    /// Line, position and excess farthest outside the travel, and how many rows are.
    outside: Option<(u32, f64, f64, usize)>,
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
            1 => self.axis.vel.max(self.axis.rapid),
            2 => self.axis.acc,
            _ => self.axis.jerk,
        }
    }

    /// How far position and derivatives below the one of order `last` get from `state` within `time`, if that one
    /// keeps its limit.
    pub(super) fn drift(&self, state: &[f64; 4], last: usize, time: f64) -> [f64; 3] {
        let mut drift = [0.0; 3];
        // Taylor's formula with remainder: each from the one above it.
        let mut above = self.limit(last);
        for order in (0..last).rev() {
            drift[order] = time * above;
            above = state[order].abs() + drift[order];
        }
        drift
    }

    /// Takes in what a row says: position and as many derivatives as it has.
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
        let [low, high] = self.axis.limits;
        let excess = (low - q).max(q - high);
        if excess > rounding(0) + ROUNDING {
            let (worst, rows) = self.outside.map_or((0.0, 0), |(_, _, worst, rows)| (worst, rows));
            if let Some(outside) = self.outside.as_mut().filter(|_| excess <= worst) {
                outside.3 = rows + 1;
            } else {
                self.outside = Some((line, q, excess, rows + 1));
            }
        }
        for (order, value) in values.iter().enumerate().take(options.derivatives + 1).skip(1) {
            self.take(order, (*value, rounding(order)), line, false);
        }
    }

    /// Takes in a derivative and what rounding may have added to it.
    pub(super) fn take(
        &mut self,
        order: usize,
        (value, slack): (f64, f64),
        line: u32,
        between: bool,
    ) {
        let limit = self.limit(order);
        self.rates[order - 1].take((value.abs() - slack).max(0.0) / limit, line, between);
    }

    /// A jerk up to which nothing is news.
    pub(super) fn known_jerk(&self) -> f64 {
        self.rates[2].worst.min(1.0) * self.axis.jerk
    }

    pub(super) fn findings(&self, jerk: bool) -> impl Iterator<Item = MotionFinding> {
        let axis = || self.axis.name.clone();
        let travel = self.outside.map(|(line, value, excess, rows)| MotionFinding::Travel {
            axis: axis(),
            kind: self.axis.kind,
            line,
            value,
            excess,
            rows,
        });
        let judged = if jerk { 3 } else { 2 };
        let rates = RATES.into_iter().zip(self.rates).take(judged).filter(|(_, r)| r.broken > 0);
        let rates: Vec<MotionFinding> =
            rates.map(|(rate, worst)| MotionFinding::Rate { axis: axis(), rate, worst }).collect();
        travel.into_iter().chain(rates)
    }

    pub(super) fn finish(self) -> AxisMotion {
        let Self { axis, range, rates, .. } = self;
        AxisMotion { name: axis.name.clone(), kind: axis.kind, range, rates }
    }
}
