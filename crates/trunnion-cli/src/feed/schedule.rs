//! The schedule as a table, and the axes at the servo period.

use super::args::FeedArgs;
use super::path::Table;
use super::plan::Planned;
use crate::motion::SUFFIXES;
#[cfg(feature = "parquet")]
use crate::motion::is_parquet;
use crate::outcome::Failure;
use crate::output;
use std::io::{Error, Result as Written, Write};
use trunnion::feed::FeedPlan;
use trunnion::files::table::write_number;
use trunnion::setpoint;

/// Columns of a schedule.
pub(super) const HEADER: &str = "s,t,speed,acceleration,jerk";

/// Writes the schedule, and the axes at the servo period where asked for.
pub(super) fn write<const N: usize>(
    args: &FeedArgs,
    planned: &Planned<'_, N>,
    table: &Table,
) -> Result<(), Failure> {
    if let Some(place) = &args.motion {
        // The motion first: if it fails, there is no schedule without it.
        output::file(place, |out| {
            #[cfg(feature = "parquet")]
            if is_parquet(place) {
                return columns(out, planned, table.layout.names(), args.period);
            }
            motion(out, planned, table.layout.names(), args.period)
        })?;
    }
    args.ends.write(|out| schedule(out, &planned.plan))
}

fn schedule(out: &mut dyn Write, plan: &FeedPlan) -> Written<()> {
    writeln!(out, "{HEADER}")?;
    // One buffer for all rows: a schedule has up to millions.
    let mut line = String::new();
    for piece in &plan.schedule.pieces {
        for (row, t) in piece.t.iter().enumerate() {
            let at = |list: &[f64]| list.get(row).copied().unwrap_or_default();
            let jerk = piece.at_time(*t).map_or(0.0, |moment| moment.jerk);
            let numbers = [at(&piece.s), *t, at(&piece.speed), at(&piece.acceleration), jerk];
            write_row(&mut line, numbers);
            out.write_all(line.as_bytes())?;
        }
    }
    Ok(())
}

fn motion<const N: usize>(
    out: &mut dyn Write,
    planned: &Planned<'_, N>,
    names: &[String],
    period: f64,
) -> Written<()> {
    write!(out, "t")?;
    for suffix in SUFFIXES {
        for name in names {
            write!(out, ",{name}{suffix}")?;
        }
    }
    writeln!(out)?;
    let mut line = String::new();
    let points =
        setpoint::sample(planned.path, &planned.plan.schedule, period).map_err(Error::other)?;
    for point in points {
        line.clear();
        write_number(&mut line, point.t);
        for values in [&point.position, &point.velocity, &point.acceleration, &point.jerk] {
            for value in values.iter().take(names.len()) {
                line.push(',');
                write_number(&mut line, *value);
            }
        }
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

#[cfg(feature = "parquet")]
fn columns<const N: usize>(
    out: impl Write + Send,
    planned: &Planned<'_, N>,
    names: &[String],
    period: f64,
) -> Written<()> {
    let all =
        SUFFIXES.iter().flat_map(|suffix| names.iter().map(move |name| format!("{name}{suffix}")));
    let all: Vec<String> = std::iter::once("t".to_owned()).chain(all).collect();
    let points =
        setpoint::sample(planned.path, &planned.plan.schedule, period).map_err(Error::other)?;
    let rows = points.map(|point| {
        let tables = [point.position, point.velocity, point.acceleration, point.jerk];
        let values = tables.iter().flat_map(|values| values.iter().take(names.len()).copied());
        std::iter::once(point.t).chain(values).collect()
    });
    crate::parquet::write(out, &all, rows)
}

/// Puts a row of a schedule into `line`.
pub(super) fn write_row(line: &mut String, values: [f64; 5]) {
    line.clear();
    for (index, value) in values.into_iter().enumerate() {
        if index > 0 {
            line.push(',');
        }
        write_number(line, value);
    }
    line.push('\n');
}
