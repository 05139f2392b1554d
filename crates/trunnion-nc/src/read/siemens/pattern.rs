//! Patterns of holes: `HOLES1` (row) and `HOLES2` (circle).

use super::cycle_call::CallArguments;
use super::reader::SiemensReader;
use super::value;
use super::word::SiemensWord;
use crate::math;
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::log::{ReadRemark, column};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Way};
use std::f64::consts::TAU;

/// Most holes of a pattern.
const MOST_HOLES: f64 = 100_000.0;

impl SiemensReader {
    /// Drills a pattern with the active modal cycle.
    pub(super) fn pattern(
        &self,
        state: &mut ReaderState,
        item: &SiemensWord<'_>,
        name: &str,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let Some(cycle) = self.modal_cycle else {
            let message = format!("{name} without a modal cycle");
            return Err(ReadRemark::new(item.at, message, "write MCALL CYCLE81(..) before it"));
        };
        let arguments = CallArguments::of(self, item);
        let axes = match self.plane {
            1 => [2, 0],
            2 => [1, 2],
            _ => [0, 1],
        };
        let slots = axes.map(|axis: usize| state.control.xyz[axis]);
        let here = slots.map(|slot| state.control.reading(slot));
        let points = match name {
            "HOLES1" => row(&arguments, state.control.scale(), here, item.at)?,
            _ => circle(&arguments, state.control.scale(), item.at)?,
        };
        for point in points {
            let mut target = MoveTarget::new(item.at, column(code, item.at));
            for (slot, value) in slots.into_iter().zip(point) {
                target.set(slot, value, DistanceMode::Absolute);
            }
            state.control.go(state.log.line, target, Pace::Rapid, Way::Line)?;
            self.drill(state, &cycle, code)?;
        }
        Ok(())
    }
}

fn count(value: f64, at: usize) -> Result<u32, ReadRemark> {
    if !(1.0..=MOST_HOLES).contains(&value) {
        return Err(ReadRemark::new(at, format!("{value} holes"), "look at NUM"));
    }
    value::natural(value, at)
}

/// Returns the points of `HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM)`, from the end that is nearer.
fn row(
    arguments: &CallArguments<'_>,
    scale: f64,
    here: [Option<f64>; 2],
    at: usize,
) -> Result<Vec<[f64; 2]>, ReadRemark> {
    let length = |place: usize| arguments.number(place).map(|value| scale * value);
    let (u, v, first, apart) = (length(0)?, length(1)?, length(3)?, length(4)?);
    let (sin, cos) = math::sin_cos(arguments.number(2)?.to_radians());
    let number = count(arguments.number(5)?, at)?;
    let point = |index: u32| {
        let along = first + f64::from(index) * apart;
        [u + along * cos, v + along * sin]
    };
    let mut points: Vec<_> = (0..number).map(point).collect();
    // The control spares an idle way: it begins at the end of the row that is nearer.
    let ends = points.first().copied().zip(points.last().copied());
    if let ([Some(x), Some(y)], Some((start, end))) = (here, ends) {
        let away = |[u, v]: [f64; 2]| math::hypot(u - x, v - y);
        if away(end) < away(start) - 1e-9 {
            points.reverse();
        }
    } else if number > 1 {
        let message = "HOLES1 from a position that the program does not state";
        let help = "program the axes of the plane before: the control begins at the nearer end";
        return Err(ReadRemark::new(at, message, help));
    }
    Ok(points)
}

/// Returns the points of `HOLES2(CPA, CPO, RAD, STA1, INDA, NUM)`.
fn circle(
    arguments: &CallArguments<'_>,
    scale: f64,
    at: usize,
) -> Result<Vec<[f64; 2]>, ReadRemark> {
    let length = |place: usize| arguments.number(place).map(|value| scale * value);
    let (u, v, radius) = (length(0)?, length(1)?, length(2)?);
    let start = arguments.number(3)?.to_radians();
    let number = count(arguments.number(5)?, at)?;
    // Without an angle between them the holes share the whole circle.
    let step = match arguments.number(4)?.to_radians() {
        step if step.abs() > 0.0 => step,
        _ => TAU / f64::from(number),
    };
    let point = |index: u32| {
        let (sin, cos) = math::sin_cos(start + f64::from(index) * step);
        [u + radius * cos, v + radius * sin]
    };
    Ok((0..number).map(point).collect())
}
