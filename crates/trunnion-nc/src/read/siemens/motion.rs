//! Effect of the words of a block as a whole.

use super::frame;
use super::line::{CenterWord, SiemensBlock, SiemensMotion};
use super::reader::SiemensReader;
use crate::read::arc;
use crate::read::arc::{ArcForm, ArcSense, GivenArc};
use crate::read::control::{DistanceMode, FeedUnit, SLOTS};
use crate::read::gcode::axis_of;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step, Way};
use nalgebra::Vector3;

impl SiemensReader {
    /// Runs a block.
    pub(super) fn run(
        &mut self,
        state: &mut ReaderState,
        mut line: SiemensBlock,
        code: &str,
    ) -> Result<(), ReadRemark> {
        if line.passive {
            return Ok(());
        }
        technology(state, &line, self.feed_unit)?;
        // In the block of G4, F and S are its time.
        if line.dwell {
            return dwell(state, &line);
        }
        // Frames stand in a block of their own: the axis words are their values.
        if let Some(frame) = &line.frame {
            return frame::apply(state, &line.target, frame, self.plane);
        }
        if let Some(code) = line.pole {
            return self.set_pole(state, &line, code);
        }
        if line.polar.iter().any(Option::is_some) {
            self.polar_end(state, &mut line)?;
        }
        if line.vector.iter().any(Option::is_some) {
            check_vector(state, &line)?;
            let [a, b, c] = line.vector.map(|value| value.unwrap_or(0.0));
            line.target.axis = Some(axis_of(Vector3::new(a, b, c), line.target.at)?);
        }
        line.target.machine = line.machine;
        let centered = line.center.iter().any(Option::is_some) || line.radius.is_some();
        // A full circle has no axis words.
        let arc = matches!(self.motion, Some(SiemensMotion::Arc(_)));
        let moves = !line.target.is_empty() || (arc && centered);
        if moves {
            self.go(state, &line)?;
        }
        // MCALL sets the cycle of blocks to come, and alone it ends it; a cycle alone is drilled here.
        match line.cycle {
            cycle if line.calls_modally => self.modal_cycle = cycle,
            Some(cycle) => self.drill(state, &cycle, code)?,
            None => {
                if let Some(cycle) = self.modal_cycle.filter(|_| moves) {
                    self.drill(state, &cycle, code)?;
                }
            }
        }
        state.control.ended |= line.ends;
        Ok(())
    }

    fn go(&mut self, state: &mut ReaderState, line: &SiemensBlock) -> Result<(), ReadRemark> {
        let target = line.target;
        let motion = self.motion.ok_or_else(|| {
            ReadRemark::new(target.at, "axis words without G0 or G1", "write G0 or G1 before them")
        })?;
        let way = match motion {
            SiemensMotion::Arc(sense) => self.arc(state, line, sense)?,
            _ => Way::Line,
        };
        let pace = match motion {
            SiemensMotion::Rapid => Pace::Rapid,
            _ => state.control.pace(&target, line.feed)?,
        };
        state.control.go(state.log.line, target, pace, way)
    }

    fn arc(
        &self,
        state: &ReaderState,
        line: &SiemensBlock,
        sense: ArcSense,
    ) -> Result<Way, ReadRemark> {
        let at = line.target.at;
        // G17 XY, G18 ZX, G19 YZ, right-handed with the third axis.
        let [u, v] = match self.plane {
            1 => [2, 0],
            2 => [1, 2],
            _ => [0, 1],
        };
        let slots = [u, v].map(|axis: usize| state.control.xyz[axis]);
        let form = if let Some(radius) = line.radius {
            ArcForm::Radius(radius)
        } else {
            if line.center[u].is_none() && line.center[v].is_none() {
                let message = "arcs need their centre or radius";
                return Err(ReadRemark::new(at, message, "write I J K of this plane, or CR="));
            }
            // I J K count from the start of the arc; I=AC(..) is a coordinate.
            let from_start = |axis: usize, slot: usize| match line.center[axis] {
                None => Ok(0.0),
                Some(CenterWord { value, mode: DistanceMode::Incremental }) => Ok(value),
                Some(CenterWord { value, mode: DistanceMode::Absolute }) => {
                    let place = state.control.reading(slot);
                    Ok(value - place.ok_or_else(|| arc::unknown_start(at))?)
                }
            };
            ArcForm::Center([from_start(u, slots[0])?, from_start(v, slots[1])?])
        };
        // TURN counts turns beyond the first.
        let turns = line.turns.saturating_add(1);
        arc::way(
            &state.control,
            &line.target,
            &GivenArc { plane: slots, form, sense, turns, rounded: arc::ROUNDED },
        )
    }
}

/// Runs `G4 F2` (seconds), `G4 S10` (turns).
fn dwell(state: &mut ReaderState, line: &SiemensBlock) -> Result<(), ReadRemark> {
    let seconds = match (line.feed, line.speed) {
        (Some(seconds), None) => seconds,
        // G4 S: revolutions over revolutions per minute.
        (None, Some(turns)) if state.control.speed > 0.0 => 60.0 * turns / state.control.speed,
        _ => {
            let message = "G4 without a time";
            return Err(ReadRemark::new(line.target.at, message, "write G4 F and the seconds"));
        }
    };
    if !(seconds >= 0.0 && line.target.is_empty()) {
        return Err(ReadRemark::new(
            line.target.at,
            "G4 beside other words",
            "put it on its own line",
        ));
    }
    let line = state.log.line;
    state.control.steps.push_back(Step::Dwell { line, seconds });
    Ok(())
}

fn check_vector(state: &ReaderState, line: &SiemensBlock) -> Result<(), ReadRemark> {
    // Without TRAORI the control cannot turn a vector into rotary axes.
    if !state.control.tcp {
        let message = "a tool-axis vector without TRAORI";
        return Err(ReadRemark::new(line.target.at, message, "write TRAORI before"));
    }
    let rotary = (0..SLOTS).any(|s| line.target.get(s).is_some() && state.control.is_rotary(s));
    if rotary || line.machine {
        let message = "a tool-axis vector beside rotary words or SUPA";
        return Err(ReadRemark::new(line.target.at, message, "keep one of them"));
    }
    Ok(())
}

/// Applies F, S, T, M6, M3.
fn technology(
    state: &mut ReaderState,
    line: &SiemensBlock,
    unit: FeedUnit,
) -> Result<(), ReadRemark> {
    let at = line.target.at;
    let control = &mut state.control;
    if let (Some(feed), false) = (line.feed, line.dwell) {
        if !(feed > 0.0 && feed.is_finite()) {
            return Err(ReadRemark::new(at, format!("F{feed} is no feed"), "give one above 0"));
        }
        // A feed keeps its unit: G70 behind it does not change it.
        control.feed_unit = Some(unit);
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
    // A new S while the spindle turns changes its speed at once.
    let turned = speed.is_some_and(|speed| (speed - control.speed).abs() > 0.0);
    control.speed = speed.unwrap_or(control.speed);
    if line.turns_spindle || (turned && control.sense != 0) {
        control.spindle(state.log.line);
    }
    Ok(())
}
