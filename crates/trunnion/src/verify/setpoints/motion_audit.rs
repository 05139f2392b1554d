//! A table of axis setpoints against the machine: every row, and what no motion through the rows can avoid.

use super::least::{self, JerkErrors};
use super::options::MotionOptions;
use super::rate::{AxisState, MotionFinding, MotionReport, Unevenness};
use crate::machine::Machine;
use crate::types::{AXES, AxisVector};

/// One row of a table of setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionRow {
    /// Its line.
    pub line: u32,
    /// Time \[s\].
    pub t: f64,
    /// Position, velocity, acceleration, jerk of every axis \[mm, rad and s\]; those the table does not hold are
    /// not looked at. Where jerk steps, it is the one that begins.
    pub values: [AxisVector; 4],
}

/// Why a table of setpoints cannot be audited.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// An option that is not a usable number.
    #[error("{name} is {value}; it must be {must}")]
    Option {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Time does not grow.
    #[error("line {line}: t = {t} s comes after {before} s; times must grow from row to row")]
    Time {
        /// Line of the row.
        line: u32,
        /// Its time \[s\].
        t: f64,
        /// Time of the row before \[s\].
        before: f64,
    },
    /// Less than two rows.
    #[error("the table has {rows} rows of setpoints; a motion has at least two")]
    TooShort {
        /// How many.
        rows: usize,
    },
}

/// Rows that are looked at together at most: the third difference of positions has four.
const WINDOW: usize = 4;

/// Audits a table of setpoints row by row, in constant memory.
///
/// Every row is held against travel, velocity, acceleration and jerk as it says them. Between two rows it finds
/// the least acceleration and the least jerk that any motion through both can have, which is exact: a motion with
/// that bound exists, and none with a smaller one. Of positions alone it takes divided differences, which are
/// weighted means of the derivative and so cannot exceed a limit that is kept. A ratio above 1 is therefore a
/// limit broken for certain, whatever the drive does between the rows; the rounding of the decimals is taken off
/// first. The machine stands still before the first row and after the last.
#[derive(Debug, Clone)]
pub struct MotionAudit<'a> {
    options: MotionOptions,
    axes: [AxisState<'a>; AXES],
    errors: JerkErrors,
    /// The last rows, oldest first.
    window: Vec<Timed>,
    first: f64,
    rows: usize,
    /// A step that is not the period, until it turns out to be the last.
    odd: Option<(u32, f64)>,
    uneven: Option<Unevenness>,
    findings: Vec<MotionFinding>,
}

/// A row, when it is exactly, and how exactly that is known.
#[derive(Debug, Clone, Copy)]
struct Timed {
    row: MotionRow,
    /// On the raster of the period: how manieth.
    tick: Option<f64>,
}

/// Written times of rows on the raster are off by their rounding, as is the first; a period found from them adds
/// as much again.
const TICK_ROUNDING: f64 = 3.0;

impl<'a> MotionAudit<'a> {
    /// Starts an audit.
    ///
    /// # Errors
    ///
    /// [`MotionError::Option`] if the period is not positive, or a rounding is negative or no number.
    pub fn new(machine: &'a Machine, options: MotionOptions) -> Result<Self, MotionError> {
        let period = options.period;
        if !(period > 0.0 && period.is_finite()) {
            let must = "a time above 0, in s";
            return Err(MotionError::Option { name: "period", value: period, must });
        }
        let roundings = options.rounding.iter().flat_map(|all| all.iter().copied());
        if let Some(value) = roundings
            .chain([options.time_rounding])
            .find(|value| !(*value >= 0.0 && value.is_finite()))
        {
            return Err(MotionError::Option { name: "rounding", value, must: "0 or above" });
        }
        Ok(Self {
            axes: machine.axes.each_ref().map(AxisState::new),
            errors: JerkErrors::new(),
            window: Vec::with_capacity(WINDOW),
            first: 0.0,
            rows: 0,
            odd: None,
            uneven: None,
            findings: Vec::new(),
            options,
        })
    }

    /// Takes the next row in.
    ///
    /// # Errors
    ///
    /// [`MotionError::Time`] if it is not later than the one before.
    pub fn push(&mut self, row: &MotionRow) -> Result<(), MotionError> {
        if let Some(Timed { row: before, .. }) = self.window.last()
            && row.t.partial_cmp(&before.t) != Some(std::cmp::Ordering::Greater)
        {
            return Err(MotionError::Time { line: row.line, t: row.t, before: before.t });
        }
        if self.rows == 0 {
            self.first = row.t;
            self.stand(row, -(WINDOW as f64) + 1.0);
            self.at_rest(row, "first");
        } else {
            self.step(row);
        }
        self.rows += 1;
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let values = row.values.map(|values| values[index]);
            axis.visit(&values, row.line, &self.options, index);
        }
        let tick = self.tick(row.t);
        self.take(Timed { row: *row, tick });
        Ok(())
    }

    /// What was found.
    ///
    /// # Errors
    ///
    /// [`MotionError::TooShort`].
    pub fn finish(mut self) -> Result<MotionReport, MotionError> {
        let Some(Timed { row, .. }) = self.window.last().copied().filter(|_| self.rows > 1) else {
            return Err(MotionError::TooShort { rows: self.rows });
        };
        // The last step alone may be shorter than the period.
        let short = |step: f64| step < self.options.period;
        if let Some((line, step)) = self.odd.take().filter(|(_, step)| !short(*step)) {
            self.note(line, step);
        }
        let duration = row.t - self.first;
        self.at_rest(&row, "last");
        self.stand(&row, 1.0);
        let mut findings = self.findings;
        findings.extend(self.uneven.map(MotionFinding::Period));
        for axis in &self.axes {
            findings.extend(axis.findings(self.options.jerk));
        }
        let axes = self.axes.map(AxisState::finish);
        Ok(MotionReport { axes, rows: self.rows, duration, period: self.options.period, findings })
    }

    /// Where the raster has a time.
    fn tick(&self, t: f64) -> Option<f64> {
        let since = t - self.first;
        let tick = (since / self.options.period).round();
        let rounding = TICK_ROUNDING * self.time_error(t);
        ((since - tick * self.options.period).abs() <= rounding).then_some(tick)
    }

    /// How exactly a written time is known \[s\].
    fn time_error(&self, t: f64) -> f64 {
        self.options.time_rounding + 4.0 * f64::EPSILON * t.abs()
    }

    /// Time between two rows, and its error.
    fn between(&self, from: &Timed, to: &Timed) -> (f64, f64) {
        match (from.tick, to.tick) {
            (Some(a), Some(b)) if a < b => ((b - a) * self.options.period, 0.0),
            _ => {
                let error = self.time_error(from.row.t) + self.time_error(to.row.t);
                (to.row.t - from.row.t, error)
            }
        }
    }

    /// Holds a step against the period; the one before was not the last.
    fn step(&mut self, row: &MotionRow) {
        if let Some((line, step)) = self.odd.take() {
            self.note(line, step);
        }
        let Some(before) = self.window.last() else { return };
        let step = row.t - before.row.t;
        let error = self.time_error(before.row.t) + self.time_error(row.t);
        if (step - self.options.period).abs() > error {
            self.odd = Some((row.line, step));
        }
    }

    fn note(&mut self, line: u32, step: f64) {
        let period = self.options.period;
        let uneven = self.uneven.get_or_insert(Unevenness { line, step, rows: 0, period });
        uneven.rows += 1;
    }

    /// Where the rows hold no derivatives, the machine stands at the same place for rows before the first and
    /// after the last.
    fn stand(&mut self, row: &MotionRow, first: f64) {
        if self.options.derivatives > 0 {
            return;
        }
        for index in 0..WINDOW - 1 {
            let t = row.t + (first + index as f64) * self.options.period;
            self.take(Timed { row: MotionRow { t, ..*row }, tick: self.tick(t) });
        }
    }

    /// The first and the last row stand still; without limited jerk acceleration may begin at once.
    fn at_rest(&mut self, row: &MotionRow, which: &'static str) {
        let orders = if self.options.jerk { 2 } else { 1 };
        for order in 1..=orders.min(self.options.derivatives) {
            for (index, state) in self.axes.iter().enumerate() {
                let value = row.values[order][index];
                if value.abs() > self.options.rounding[order][index] * (1.0 + f64::EPSILON) {
                    let (axis, kind) = (state.name(), state.kind());
                    let (line, accelerates) = (row.line, order == 2);
                    let moving =
                        MotionFinding::Moving { axis, kind, line, which, accelerates, value };
                    self.findings.push(moving);
                }
            }
        }
    }

    /// Looks at a row together with those before it.
    fn take(&mut self, next: Timed) {
        self.window.push(next);
        match self.options.derivatives {
            0 => {
                self.differences::<2>(0, 1.0, 1);
                self.differences::<3>(0, 2.0, 2);
                self.differences::<4>(0, 6.0, 3);
            }
            1 => {
                self.differences::<2>(0, 1.0, 1);
                self.pair();
                self.differences::<3>(1, 2.0, 3);
            }
            _ => {
                self.differences::<2>(0, 1.0, 1);
                self.pair();
            }
        }
        if self.window.len() == WINDOW {
            self.window.remove(0);
        }
    }

    /// A derivative of a column as a divided difference of the last rows.
    fn differences<const N: usize>(&mut self, order: usize, factorial: f64, told: usize) {
        let Some(first) = self.window.len().checked_sub(N) else { return };
        let rows = &self.window[first..];
        let (mut times, mut errors) = ([0.0; N], [0.0; N]);
        for k in 1..N {
            let (h, error) = self.between(&rows[k - 1], &rows[k]);
            if h <= 2.0 * error {
                return;
            }
            times[k] = times[k - 1] + h;
            errors[k] = errors[k - 1] + error;
        }
        // A row that stands out counts most where it is in the middle.
        let line = rows[N / 2].row.line;
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let values: [f64; N] = std::array::from_fn(|k| rows[k].row.values[order][index]);
            let rate = axis.limit(order + 1);
            let slack = std::array::from_fn(|k| {
                self.options.rounding[order][index]
                    + 4.0 * f64::EPSILON * values[k].abs()
                    + rate * errors[k]
            });
            let (value, slack) = least::divided(&times, &values, &slack);
            axis.take(told, (factorial * value, factorial * slack), line, true);
        }
    }

    /// The least acceleration and jerk of any motion through the last two rows.
    fn pair(&mut self) {
        let [.., from, to] = self.window.as_slice() else { return };
        let (h, error) = self.between(from, to);
        if h <= 2.0 * error {
            return;
        }
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let [a, b] = [from, to].map(|timed| timed.row.values.map(|values| values[index]));
            let line = to.row.line;
            let rounding = |order: usize| {
                let size = a[order].abs() + b[order].abs();
                2.0 * self.options.rounding[order][index] + 4.0 * f64::EPSILON * size
            };
            let rounding = [0, 1, 2].map(rounding);
            let errors =
                |drift: [f64; 3]| std::array::from_fn(|order| rounding[order] + drift[order]);
            let [position, velocity, _] = errors(axis.drift(&b, 2, error));
            let ends = [[a[0], a[1]], [b[0], b[1]]];
            axis.take(2, least::acceleration(ends, h, [position, velocity]), line, true);
            let [position, velocity, acceleration] = errors(axis.drift(&b, 3, error));
            let least = if self.options.derivatives > 1 {
                let ends = [[a[0], a[1], a[2]], [b[0], b[1], b[2]]];
                self.errors.jerk(ends, h, [position, velocity, acceleration], axis.known_jerk())
            } else {
                least::bend(ends, h, [position, velocity])
            };
            axis.take(3, least, line, true);
        }
    }
}
