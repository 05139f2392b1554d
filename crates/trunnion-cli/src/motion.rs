//! `motion.csv`: the axes at the servo period.

use crate::decimals;
use std::io::{Error, Result, Write};
use std::path::Path;
use trunnion::files::job::MotionMethod;
use trunnion::machine::{Axis, AxisKind};
use trunnion::pipeline::{Job, PlannedOperation};
use trunnion::setpoint;
use trunnion::types::{AXES, Setpoint};

/// Suffixes of axis names in the header: the derivatives by time.
pub(crate) const SUFFIXES: [&str; 4] = ["", "_vel", "_acc", "_jerk"];

/// Decimals of positions and their derivatives. Over a period of 1 ms their rounding can be taken for a jerk of
/// 6 units/s³ at most (32 h⁻³, 17 h⁻² and 4.4 h⁻¹ times twice half a unit): below a per mille of what axes have.
const DECIMALS: [usize; 4] = [10, 7, 4, 1];

/// Decimals of the time.
const TIME_DECIMALS: usize = 9;

/// Usual length of a row \[bytes\].
const LINE: usize = 256;

/// Returns the name of the table of an operation: a tool change parts one from the next.
pub(crate) fn file_name(job: &Job, operation: &PlannedOperation) -> String {
    if job.following.is_empty() {
        "motion.csv".to_owned()
    } else {
        format!("motion-{}.csv", operation.index + 1)
    }
}

/// Writes one row a servo period: time, then position, velocity, acceleration, jerk of every axis.
pub(crate) fn write(out: &mut dyn Write, job: &Job, operation: &PlannedOperation) -> Result<()> {
    let axes = &job.kinematics.machine().axes;
    // The first line states which limits hold, because the numbers alone do not show it.
    let limits = match job.file.motion.method {
        MotionMethod::Jerk => JERK_LIMITED,
        MotionMethod::Optimal => "# velocity/acceleration-limited: jerk is not limited",
        MotionMethod::Blocks => "# classical look-ahead: axis limits are not guaranteed",
    };
    header(out, axes, limits)?;
    let period = job.file.motion.servo_period;
    let mut setpoints =
        setpoint::sample(&operation.followed.path, &operation.plan.schedule, period)
            .map_err(Error::other)?;
    setpoints.try_for_each(|setpoint| row(out, axes, &setpoint))
}

/// Limits of motion that is planned within jerk limits, as the first line states them.
pub(crate) const JERK_LIMITED: &str =
    "# jerk-limited: velocity, acceleration and jerk of every axis";

/// Writes the lines above the rows.
pub(crate) fn header(out: &mut dyn Write, axes: &[Axis; AXES], limits: &str) -> Result<()> {
    writeln!(out, "{limits}")?;
    writeln!(out, "# mm, deg, s; rotary axes unwound")?;
    writeln!(out, "{}", columns(axes).join(","))
}

/// Returns the names of the columns.
pub(crate) fn columns(axes: &[Axis; AXES]) -> Vec<String> {
    let named =
        |suffix: &'static str| axes.iter().map(move |axis| format!("{}{suffix}", axis.name));
    std::iter::once("t".to_owned()).chain(SUFFIXES.into_iter().flat_map(named)).collect()
}

/// Returns the values of a setpoint in the order of the columns, in mm, degrees and s.
pub(crate) fn values(axes: &[Axis; AXES], setpoint: &Setpoint) -> Vec<f64> {
    let Setpoint { t, position, velocity, acceleration, jerk } = setpoint;
    let shown = |(value, axis): (&f64, &Axis)| match axis.kind {
        AxisKind::Rotary => value.to_degrees(),
        AxisKind::Linear => *value,
    };
    let groups = [position, velocity, acceleration, jerk];
    let values = groups.into_iter().flat_map(|group| group.iter().zip(axes).map(shown));
    std::iter::once(*t).chain(values).collect()
}

/// Writes a row.
pub(crate) fn row(out: &mut dyn Write, axes: &[Axis; AXES], setpoint: &Setpoint) -> Result<()> {
    let values = values(axes, setpoint);
    let Some((t, values)) = values.split_first() else { return Ok(()) };
    let mut line = Vec::with_capacity(LINE);
    decimals::write(&mut line, *t, TIME_DECIMALS)?;
    // Fixed decimals, not the shortest form: columns stay aligned, and their rounding is known.
    for (group, count) in values.chunks(AXES).zip(DECIMALS) {
        for value in group {
            line.push(b',');
            decimals::write(&mut line, *value, count)?;
        }
    }
    line.push(b'\n');
    out.write_all(&line)
}

/// Returns true if a file is named as a Parquet file.
pub(crate) fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|name| name.eq_ignore_ascii_case("parquet"))
}
