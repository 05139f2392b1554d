//! `motion.csv`: the axes at the servo period.

use std::io::{Error, Result, Write};
use trunnion::files::job::MotionMethod;
use trunnion::machine::AxisKind;
use trunnion::pipeline::{Job, Outcome};
use trunnion::setpoint;
use trunnion::types::AxisVector;

/// What follows an axis name in the header: the derivatives by time.
pub(crate) const SUFFIXES: [&str; 4] = ["", "_vel", "_acc", "_jerk"];

/// Writes one row a servo period: time, then position, velocity, acceleration, jerk of every axis.
pub(crate) fn write(out: &mut dyn Write, job: &Job, outcome: &Outcome) -> Result<()> {
    let axes = &job.kinematics.machine().axes;
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
        write!(out, "{:.6}", setpoint.t)?;
        let mut row = |values: &AxisVector, decimals: usize| {
            values.iter().enumerate().try_for_each(|(index, value)| {
                let value = if rotary(index) { value.to_degrees() } else { *value };
                write!(out, ",{value:.decimals$}")
            })
        };
        row(&setpoint.position, 6)?;
        row(&setpoint.velocity, 5)?;
        row(&setpoint.acceleration, 3)?;
        row(&setpoint.jerk, 1)?;
        writeln!(out)?;
    }
    Ok(())
}
