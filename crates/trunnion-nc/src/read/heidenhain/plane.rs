//! `PLANE SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX`, `PLANE EULER`, `PLANE VECTOR`, `PLANE RESET STAY`.

use super::reader::HeidenhainReader;
use super::token::{Token, Tokens};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::read::control::{DistanceMode, MoveTarget};
use crate::read::gcode::axis_of;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Way};
use crate::read::tilt::{HeldPoint, about, euler};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Words with a value, by kind.
const SPATIAL: [&str; 3] = ["SPA", "SPB", "SPC"];
const EULER: [&str; 3] = ["EULPR", "EULNU", "EULROT"];
const VECTOR: [&str; 6] = ["BX", "BY", "BZ", "NX", "NY", "NZ"];

/// Positioning of the rotary axes for a tilted plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlanePositioning {
    /// The tip stands meanwhile.
    Move,
    Turn,
    /// Left to a later block.
    Stay,
}

impl HeidenhainReader {
    /// Begins or ends a tilted plane.
    pub(super) fn plane(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        mut tokens: Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        _ = tokens.next_token();
        let kind = tokens.expect()?;
        let name = kind.text.to_ascii_uppercase();
        let names: &[&str] = match name.as_str() {
            "SPATIAL" => &SPATIAL,
            "EULER" => &EULER,
            "VECTOR" => &VECTOR,
            "RESET" => &[],
            _ => {
                let message = format!("PLANE {} is not understood", excerpt(kind.text));
                let help = "write the plane as PLANE SPATIAL, PLANE EULER or PLANE VECTOR";
                return Err(ReadRemark::new(kind.at, message, help));
            }
        };
        let (values, positioning) = self.words_of_plane(names, &mut tokens)?;
        let line = state.log.line;
        let at = first.at;
        let positioning = positioning.ok_or_else(|| {
            ReadRemark::new(
                at,
                "PLANE without MOVE, TURN or STAY",
                "state how the rotary axes get there",
            )
        })?;
        // RESET ends the plane; TURN and MOVE then take the rotaries to zero.
        if name == "RESET" {
            state.control.untilt();
            return turn_back(state, at, positioning);
        }
        let [a, b, c, i, j, k] = values;
        self.plain_frame(at, "PLANE")?;
        self.turned = true;
        let turn = match name.as_str() {
            "VECTOR" => {
                // VECTOR: N is the z axis of the plane, B its x axis as far as it is square to N
                // (Gram-Schmidt).
                let normal = axis_of(Vector3::new(i, j, k), at)?;
                let base = Vector3::new(a, b, c);
                let across = axis_of(base - normal.scale(normal.dot(&base)), at)?;
                // Right-handed: y = z × x. The columns are the axes, so the matrix takes plane to
                // work.
                let third = normal.cross(&across);
                let columns = [across.into_inner(), third, normal.into_inner()];
                let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns));
                UnitQuaternion::from_rotation_matrix(&turn)
            }
            // EULER: precession about Z, nutation about the new X, rotation about the new Z.
            "EULER" => euler([a, b, c].map(f64::to_radians)),
            // About the fixed X, then the fixed Y, then the fixed Z.
            _ => {
                about(Vector3::z_axis(), c.to_radians())
                    * about(Vector3::y_axis(), b.to_radians())
                    * about(Vector3::x_axis(), a.to_radians())
            }
        };
        // PLANE turns about the current datum.
        let origin = state.control.linear_shift();
        state.control.tilt(line, origin, turn);
        match positioning {
            PlanePositioning::Stay => Ok(()),
            PlanePositioning::Move => state.control.turn_to_plane(line, at, HeldPoint::Tip),
            PlanePositioning::Turn => state.control.turn_to_plane(line, at, HeldPoint::LinearAxes),
        }
    }

    /// Reads values by name, and the positioning of the rotary axes.
    fn words_of_plane(
        &self,
        names: &[&str],
        tokens: &mut Tokens<'_>,
    ) -> Result<([f64; 6], Option<PlanePositioning>), ReadRemark> {
        let mut values = [0.0; 6];
        let mut positioning = None;
        while let Some(token) = tokens.next_word() {
            let upper = token.text.to_ascii_uppercase();
            let named = names.iter().zip(&mut values).find(|(name, _)| upper.starts_with(**name));
            // SPB+45 and SPB45 alike: the value follows the name at once.
            if let Some((name, value)) = named {
                *value = self.value(&token.after(name.len()))?.value;
                continue;
            }
            match upper.as_str() {
                "MOVE" => positioning = Some(PlanePositioning::Move),
                "TURN" => positioning = Some(PlanePositioning::Turn),
                "STAY" => positioning = Some(PlanePositioning::Stay),
                // Which of two equal ways the machine stands, and what its table does, is the machine's.
                "SEQ+" | "SEQ-" | "SYM+" | "SYM-" | "TABLE" | "COORD" | "ROT" | "MBMAX"
                | "FMAX" | "FAUTO" => {}
                _ if upper.starts_with("DIST") || upper.starts_with("MB") => {}
                "F" => _ = tokens.expect()?,
                _ if upper.starts_with('F') => {}
                _ => {
                    let message = format!("{} in PLANE is not understood", excerpt(token.text));
                    let help = "angles, MOVE, TURN or STAY, SEQ, TABLE ROT and COORD ROT are";
                    return Err(ReadRemark::new(token.at, message, help));
                }
            }
        }
        Ok((values, positioning))
    }
}

/// Runs `PLANE RESET TURN`: the rotary axes go to zero.
fn turn_back(
    state: &mut ReaderState,
    at: usize,
    positioning: PlanePositioning,
) -> Result<(), ReadRemark> {
    if positioning == PlanePositioning::Stay {
        return Ok(());
    }
    // Zero of both rotaries is the position without tilt.
    let mut target = MoveTarget::new(at, 1);
    for slot in [FIRST_ROTARY, SECOND_ROTARY] {
        target.set(slot, 0.0, DistanceMode::Absolute);
    }
    let tip_stands = positioning == PlanePositioning::Move;
    let tcp = std::mem::replace(&mut state.control.tcp, tip_stands);
    let done = state.control.go(state.log.line, target, Pace::Rapid, Way::Line);
    state.control.tcp = tcp;
    state.control.forget_linear();
    done
}
