//! `motion.csv`: the axes at the servo period.

use std::io::{Error, Result, Write};
use trunnion::files::job::MotionMethod;
use trunnion::machine::AxisKind;
use trunnion::pipeline::{Job, Outcome};
use trunnion::setpoint;
use trunnion::types::AxisVector;

/// Suffixes of axis names in the header: the derivatives by time.
pub(crate) const SUFFIXES: [&str; 4] = ["", "_vel", "_acc", "_jerk"];

/// Decimals of positions and their derivatives. Over a period of 1 ms their rounding can be taken for a jerk of
/// 6 units/s³ at most (32 h⁻³, 17 h⁻² and 4.4 h⁻¹ times twice half a unit): below a per mille of what axes have.
const DECIMALS: [usize; 4] = [10, 7, 4, 1];

/// Writes one row a servo period: time, then position, velocity, acceleration, jerk of every axis.
pub(crate) fn write(out: &mut dyn Write, job: &Job, outcome: &Outcome) -> Result<()> {
    let axes = &job.kinematics.machine().axes;
    // The first line states which limits hold, because the numbers alone do not show it.
    let limits = match job.file.motion.method {
        MotionMethod::Jerk => "# jerk-limited: velocity, acceleration and jerk of every axis",
        MotionMethod::Optimal => "# velocity/acceleration-limited: jerk is not limited",
        MotionMethod::Blocks => "# classical look-ahead: axis limits are not certain to hold",
    };
    writeln!(out, "{limits}")?;
    writeln!(out, "# mm, deg, s; rotary axes unwound")?;
    write!(out, "t")?;
    for suffix in SUFFIXES {
        for axis in axes {
            write!(out, ",{}{suffix}", axis.name)?;
        }
    }
    writeln!(out)?;
    let period = job.file.motion.servo_period;
    let setpoints = setpoint::sample(&outcome.followed.path, &outcome.plan.schedule, period)
        .map_err(Error::other)?;
    let rotary = |index: usize| axes.get(index).is_some_and(|axis| axis.kind == AxisKind::Rotary);
    for setpoint in setpoints {
        write!(out, "{:.9}", setpoint.t)?;
        // Fixed decimals, not the shortest form: columns stay aligned, and their rounding is known.
        let mut row = |values: &AxisVector, decimals: usize| {
            values.iter().enumerate().try_for_each(|(index, value)| {
                let value = if rotary(index) { value.to_degrees() } else { *value };
                write!(out, ",{value:.decimals$}")
            })
        };
        for (values, decimals) in
            [&setpoint.position, &setpoint.velocity, &setpoint.acceleration, &setpoint.jerk]
                .into_iter()
                .zip(DECIMALS)
        {
            row(values, decimals)?;
        }
        writeln!(out)?;
    }
    Ok(())
}
