//! What the words of a block do together.

use super::super::arc::{self, Form, Given};
use super::super::control::SLOTS;
use super::super::gcode::axis_of;
use super::super::log::Remark;
use super::super::reader::State;
use super::super::{Pace, Step, Way};
use super::value::Mode;
use super::word::Item;
use super::{Line, Motion, Siemens};
use nalgebra::Vector3;
use std::f64::consts::TAU;

impl Siemens {
    /// Does what a block says.
    pub(super) fn run(&mut self, state: &mut State, mut line: Line) -> Result<(), Remark> {
        technology(state, &line)?;
        if line.dwell {
            return dwell(state, &line);
        }
        if let Some(further) = line.shift {
            shift(state, &line, further)?;
            return Ok(());
        }
        if line.vector.iter().any(Option::is_some) {
            check_vector(state, &line)?;
            let [a, b, c] = line.vector.map(|value| value.unwrap_or(0.0));
            line.target.axis = Some(axis_of(Vector3::new(a, b, c), line.target.at)?);
        }
        line.target.machine = line.machine;
        let centered = line.center.iter().any(Option::is_some) || line.radius.is_some();
        let arc = matches!(self.motion, Some(Motion::Arc { .. }));
        if !line.target.is_empty() || (arc && centered) {
            self.go(state, &line)?;
        }
        state.control.ended |= line.ends;
        Ok(())
    }

    fn go(&mut self, state: &mut State, line: &Line) -> Result<(), Remark> {
        let target = line.target;
        let motion = self.motion.ok_or_else(|| {
            Remark::new(target.at, "axis words without G0 or G1", "write G0 or G1 before them")
        })?;
        let way = match motion {
            Motion::Arc { clockwise } => self.arc(state, line, clockwise)?,
            _ => Way::Line,
        };
        let pace = match motion {
            Motion::Rapid => Pace::Rapid,
            _ => state.control.pace(&target, line.feed)?,
        };
        state.control.go(state.log.line, target, (pace, way))
    }

    fn arc(&self, state: &State, line: &Line, clockwise: bool) -> Result<Way, Remark> {
        let at = line.target.at;
        let [u, v] = match self.plane {
            1 => [2, 0],
            2 => [1, 2],
            _ => [0, 1],
        };
        let slots = [u, v].map(|axis: usize| state.control.xyz[axis]);
        let form = if let Some(radius) = line.radius {
            Form::Radius(radius)
        } else {
            if line.center[u].is_none() && line.center[v].is_none() {
                let message = "arcs need their centre or radius";
                return Err(Remark::new(at, message, "write I J K of this plane, or CR="));
            }
            let from_start = |axis: usize, slot: usize| match line.center[axis] {
                None => Ok(0.0),
                Some((value, false)) => Ok(value),
                Some((value, true)) => {
                    let place = state.control.reading(slot);
                    Ok(value - place.ok_or_else(|| arc::unknown_start(at))?)
                }
            };
            Form::Center([from_start(u, slots[0])?, from_start(v, slots[1])?])
        };
        let turns = line.turns.saturating_add(1);
        arc::way(&state.control, &line.target, &Given { plane: slots, form, clockwise, turns })
    }
}

/// `G4 F2` seconds, `G4 S10` turns.
fn dwell(state: &mut State, line: &Line) -> Result<(), Remark> {
    let seconds = match (line.feed, line.speed) {
        (Some(seconds), None) => seconds,
        (None, Some(turns)) if state.control.speed > 0.0 => 60.0 * turns / state.control.speed,
        _ => {
            let message = "G4 without a time";
            return Err(Remark::new(line.target.at, message, "write G4 F and the seconds"));
        }
    };
    if !(seconds >= 0.0 && line.target.is_empty()) {
        return Err(Remark::new(line.target.at, "G4 beside other words", "put it on its own line"));
    }
    let line = state.log.line;
    state.control.steps.push_back(Step::Dwell { line, seconds });
    Ok(())
}

/// `TRANS X Y Z`, `ATRANS`: words are shifted.
fn shift(state: &mut State, line: &Line, further: bool) -> Result<(), Remark> {
    if state.control.tilted.is_some() {
        let help = "put it in CYCLE800, or end the plane before: CYCLE800()";
        return Err(Remark::new(line.target.at, "TRANS in a tilted plane", help));
    }
    if !further {
        state.control.local = [0.0; SLOTS];
    }
    for slot in 0..SLOTS {
        if let (Some(word), Some(local)) =
            (line.target.get(slot), state.control.local.get_mut(slot))
        {
            *local += word;
        }
    }
    Ok(())
}

/// `DC`, `ACP`, `ACN`: the way round that leads to an angle.
pub(super) fn unwound(
    state: &mut State,
    (slot, meant, mode): (usize, f64, Mode),
    item: &Item<'_>,
) -> Result<f64, Remark> {
    if !matches!(mode, Mode::Shortest | Mode::Positive | Mode::Negative) {
        return Ok(meant);
    }
    if !state.control.is_rotary(slot) {
        let help = "write AC(..)";
        return Err(Remark::new(item.at, "DC, ACP and ACN are of rotary axes", help));
    }
    let Some(stands) = state.control.reading(slot) else {
        let message = "DC, ACP or ACN before the axis stands anywhere: taken as written";
        state.log.warn(item.line, Remark::new(item.at, message, ""));
        return Ok(meant);
    };
    // The control's positive sense is the other one where the axis is reversed.
    let positive = mode == Mode::Positive;
    let up = (meant - stands).rem_euclid(TAU);
    let way = match mode {
        Mode::Shortest if up > 0.5 * TAU => up - TAU,
        Mode::Shortest => up,
        _ if positive != state.control.is_reversed(slot) => up,
        _ if up > 0.0 => up - TAU,
        _ => 0.0,
    };
    Ok(stands + way)
}

fn check_vector(state: &State, line: &Line) -> Result<(), Remark> {
    if !state.control.tcp {
        let message = "a tool-axis vector without TRAORI";
        return Err(Remark::new(line.target.at, message, "write TRAORI before"));
    }
    let rotary = (0..SLOTS).any(|s| line.target.get(s).is_some() && state.control.is_rotary(s));
    if rotary || line.machine {
        let message = "a tool-axis vector beside rotary words or SUPA";
        return Err(Remark::new(line.target.at, message, "keep one of them"));
    }
    Ok(())
}

/// F, S, T, M6, M3.
fn technology(state: &mut State, line: &Line) -> Result<(), Remark> {
    let at = line.target.at;
    let control = &mut state.control;
    if let (Some(feed), false) = (line.feed, line.dwell) {
        if !(feed > 0.0 && feed.is_finite()) {
            return Err(Remark::new(at, format!("F{feed} is no feed"), "give one above 0"));
        }
        control.feed = Some(feed);
    }
    if let Some(tool) = line.tool {
        control.tool = tool;
    }
    if line.changes_tool {
        let tool = control.tool;
        control.change_tool(state.log.line, tool);
    }
    let speed = line.speed.filter(|_| !line.dwell);
    let turned = speed.is_some_and(|speed| (speed - control.speed).abs() > 0.0);
    control.speed = speed.unwrap_or(control.speed);
    if line.turns_spindle || (turned && control.sense != 0) {
        control.spindle(state.log.line);
    }
    Ok(())
}
