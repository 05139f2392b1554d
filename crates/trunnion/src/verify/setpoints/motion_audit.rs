//! Audit of a table of axis setpoints: every row, and the least rates of any motion through the rows.

use super::least::{self, JerkErrors, RateBound};
use super::options::MotionOptions;
use super::rate::{AxisState, MotionFinding, MotionReport, RateOrigin, Unevenness};
use crate::machine::Machine;
use crate::types::{AXES, AxisVector};

/// One row of a table of setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionRow {
    /// Line of the table.
    pub line: u32,
    /// Time \[s\].
    pub t: f64,
    /// Position, velocity, acceleration, jerk of every axis \[mm, rad and s\]; derivatives that the table does not hold
    /// are ignored. At a step of jerk, the value after the step.
    pub values: [AxisVector; 4],
}

/// Reasons for which a table of setpoints cannot be audited.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// An option that is not a usable number.
    #[error("{name} is {value}; it must be {must}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Condition that it breaks.
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
        /// Rows of the table.
        rows: usize,
    },
}

/// Rows that are looked at together at most: the third difference of positions has four.
const WINDOW: usize = 4;

/// Audits a table of setpoints row by row, in constant memory.
///
/// The values of every row are compared with travel, velocity, acceleration and jerk. Between two rows the audit finds
/// the least acceleration and the least jerk that any motion through both can have. The bound is exact: a motion with
/// that bound exists, and none with a smaller one. If the table holds positions alone, divided differences are
/// taken, which are weighted means of the derivative and so cannot exceed a limit that is kept. A ratio above 1 is
/// therefore a broken limit for certain, whatever the drive does between the rows; the rounding of the decimals is
/// subtracted first. The machine stands still before the first row and after the last.
#[derive(Debug, Clone)]
pub struct MotionAudit<'a> {
    options: MotionOptions,
    axes: [AxisState<'a>; AXES],
    errors: JerkErrors,
    /// The last rows, oldest first.
    window: Vec<TimedRow>,
    first: f64,
    rows: usize,
    /// A step that is not the period, until it turns out to be the last.
    odd: Option<(u32, f64)>,
    uneven: Option<Unevenness>,
    findings: Vec<MotionFinding>,
}

/// Row with its exact time on the raster of the period, if it is on it.
#[derive(Debug, Clone, Copy)]
struct TimedRow {
    row: MotionRow,
    /// Number of periods since the first row; `None` off the raster.
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

    /// Takes in the next row.
    ///
    /// # Errors
    ///
    /// [`MotionError::Time`] if it is not later than the one before.
    pub fn push(&mut self, row: &MotionRow) -> Result<(), MotionError> {
        if let Some(TimedRow { row: before, .. }) = self.window.last()
            && row.t.partial_cmp(&before.t) != Some(std::cmp::Ordering::Greater)
        {
            return Err(MotionError::Time { line: row.line, t: row.t, before: before.t });
        }
        if self.rows == 0 {
            self.first = row.t;
            self.hold_position(row, -(WINDOW as f64) + 1.0);
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
        self.take(TimedRow { row: *row, tick });
        Ok(())
    }

    /// Returns the report.
    ///
    /// # Errors
    ///
    /// [`MotionError::TooShort`].
    pub fn finish(mut self) -> Result<MotionReport, MotionError> {
        let Some(TimedRow { row, .. }) = self.window.last().copied().filter(|_| self.rows > 1)
        else {
            return Err(MotionError::TooShort { rows: self.rows });
        };
        // The last step alone may be shorter than the period.
        let short = |step: f64| step < self.options.period;
        if let Some((line, step)) = self.odd.take().filter(|(_, step)| !short(*step)) {
            self.note(line, step);
        }
        let duration = row.t - self.first;
        self.at_rest(&row, "last");
        self.hold_position(&row, 1.0);
        let mut findings = self.findings;
        findings.extend(self.uneven.map(MotionFinding::Period));
        for axis in &self.axes {
            findings.extend(axis.findings(if self.options.jerk { 3 } else { 2 }));
        }
        let axes = self.axes.map(AxisState::finish);
        Ok(MotionReport { axes, rows: self.rows, duration, period: self.options.period, findings })
    }

    /// Returns the number of periods from the first row to a time on the raster; `None` off it.
    fn tick(&self, t: f64) -> Option<f64> {
        // The nearest multiple of the period, if the written time is that multiple to within its rounding.
        let since = t - self.first;
        let tick = (since / self.options.period).round();
        let rounding = TICK_ROUNDING * self.time_error(t);
        ((since - tick * self.options.period).abs() <= rounding).then_some(tick)
    }

    /// Returns the uncertainty of a written time \[s\].
    fn time_error(&self, t: f64) -> f64 {
        self.options.time_rounding + 4.0 * f64::EPSILON * t.abs()
    }

    /// Returns the time between two rows, and its error \[s\].
    fn between(&self, from: &TimedRow, to: &TimedRow) -> (f64, f64) {
        match (from.tick, to.tick) {
            // Times on the raster are known without an error, however coarsely they are written.
            (Some(a), Some(b)) if a < b => ((b - a) * self.options.period, 0.0),
            _ => {
                let error = self.time_error(from.row.t) + self.time_error(to.row.t);
                (to.row.t - from.row.t, error)
            }
        }
    }

    /// Compares a step with the period; the step before was not the last.
    fn step(&mut self, row: &MotionRow) {
        if let Some((line, step)) = self.odd.take() {
            self.note(line, step);
        }
        let Some(before) = self.window.last() else { return };
        let step = row.t - before.row.t;
        // Within the rounding of both times the step may be the period.
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

    /// Adds rows at the same position before the first and after the last row, from tick `first` on, if the rows hold no
    /// derivatives: the machine stands still there.
    fn hold_position(&mut self, row: &MotionRow, first: f64) {
        if self.options.derivatives > 0 {
            return;
        }
        for index in 0..WINDOW - 1 {
            let t = row.t + (first + index as f64) * self.options.period;
            self.take(TimedRow { row: MotionRow { t, ..*row }, tick: self.tick(t) });
        }
    }

    /// Checks that the first or last row stands still; without limited jerk the acceleration may begin at once.
    fn at_rest(&mut self, row: &MotionRow, which: &'static str) {
        // Order 1 is velocity, order 2 acceleration.
        let orders = if self.options.jerk { 2 } else { 1 };
        for order in 1..=orders.min(self.options.derivatives) {
            for (index, state) in self.axes.iter().enumerate() {
                let value = row.values[order][index];
                // A written value of up to its rounding may stand for 0.
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

    /// Differences a row with those before it.
    fn take(&mut self, next: TimedRow) {
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

    /// Judges derivative `of` by the divided difference of column `order` over the last rows, times `factorial`.
    fn differences<const N: usize>(&mut self, order: usize, factorial: f64, of: usize) {
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
            // n! times the n-th divided difference is a mean of the n-th derivative over the rows.
            let values: [f64; N] = std::array::from_fn(|k| rows[k].row.values[order][index]);
            let rate = axis.limit(order + 1);
            // A value is off by its rounding, by that of floating-point numbers, and by the limit of the next derivative times
            // the error of its time.
            let slack = std::array::from_fn(|k| {
                self.options.rounding[order][index]
                    + 4.0 * f64::EPSILON * values[k].abs()
                    + rate * errors[k]
            });
            let RateBound { value, slack } = least::divided(&times, &values, &slack);
            let rate = RateBound { value: factorial * value, slack: factorial * slack };
            axis.take(of, rate, line, RateOrigin::Difference);
        }
    }

    /// Judges the least acceleration and jerk of any motion through the last two rows.
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
                // Errors of both ends together, as the norms of the moments take them.
                let size = a[order].abs() + b[order].abs();
                2.0 * self.options.rounding[order][index] + 4.0 * f64::EPSILON * size
            };
            let rounding = [0, 1, 2].map(rounding);
            let errors =
                |drift: [f64; 3]| std::array::from_fn(|order| rounding[order] + drift[order]);
            // Errors of time act as errors of the state, at the rate that the limits allow.
            let [position, velocity, _] = errors(axis.drift(&b, 2, error));
            let ends = [[a[0], a[1]], [b[0], b[1]]];
            let least = least::acceleration(ends, h, [position, velocity]);
            axis.take(2, least, line, RateOrigin::Difference);
            let [position, velocity, acceleration] = errors(axis.drift(&b, 3, error));
            let least = if self.options.derivatives > 1 {
                let ends = [[a[0], a[1], a[2]], [b[0], b[1], b[2]]];
                self.errors.jerk(ends, h, [position, velocity, acceleration], axis.known_jerk())
            } else {
                least::bend(ends, h, [position, velocity])
            };
            axis.take(3, least, line, RateOrigin::Difference);
        }
    }
}
