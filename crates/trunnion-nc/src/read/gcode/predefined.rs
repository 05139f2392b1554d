//! Parameters that the control provides.

use crate::read::control::{ControlState, DistanceMode, FeedMode};
use crate::read::dialect::Dialect;

/// Letters of axes in the order of their parameters.
const LETTERS: &str = "xyzabcuvw";

/// Code of `G40` in tenths.
pub(super) const NO_COMPENSATION: u32 = 400;

/// Modal codes that parameters of the control show.
#[derive(Clone, Copy)]
pub(super) struct ModalCodes {
    /// In tenths: 10 for `G1`.
    pub(super) motion: u32,
    /// Cutter compensation, in tenths: 400 for none.
    pub(super) compensation: u32,
    /// 0: XY, 1: ZX, 2: YZ.
    pub(super) plane: usize,
    pub(super) distance: DistanceMode,
    /// `G90.1`.
    pub(super) arc_absolute: bool,
    /// `G7`: X counts in diameters.
    pub(super) diameter: bool,
    /// `G99`.
    pub(super) to_r: bool,
}

/// State that parameters of the control show.
#[derive(Clone, Copy)]
pub(super) struct ModalView<'a> {
    pub(super) modal: ModalCodes,
    pub(super) control: &'a ControlState,
    pub(super) line: u32,
    pub(super) dialect: Dialect,
}

impl ModalView<'_> {
    /// Returns a numbered parameter: current words (`#5420` and on), tool, offsets.
    pub(super) fn number(&self, number: u32) -> Option<f64> {
        let control = self.control;
        let letter = |at: u32| LETTERS.chars().nth(usize::try_from(at).ok()?);
        match number {
            5400 => Some(f64::from(control.tool)),
            // LinuxCNC: #5420 to #5428 are the current X Y Z A B C U V W in the program's unit.
            5420..=5428 => self.position(letter(number - 5420)?),
            // #5220 is the active work offset, counted from 1.
            5220 => Some(f64::from(control.offset) + 1.0),
            _ if self.dialect != Dialect::LinuxCnc => None,
            // G92 as it counts now, or not.
            5210 => Some(flag(control.set_by_92.iter().any(|shift| shift.abs() > 0.0))),
            5211..=5219 => {
                let slot = control.known_slot(letter(number - 5211)?.to_ascii_uppercase());
                slot.map_or(Some(0.0), |slot| {
                    Some(control.written(slot, *control.set_by_92.get(slot)?))
                })
            }
            // Values of G54 are #5221 and on, and twenty further for each of the others.
            5221..=5390 => self.of_offset(number - 5221),
            // Messages of (DEBUG, ..) are shown.
            5599 => Some(1.0),
            _ => None,
        }
    }

    /// Returns a value of a work offset that the program wrote.
    fn of_offset(&self, at: u32) -> Option<f64> {
        let offset = u8::try_from(at / 20).ok()?;
        let at = at % 20;
        let offsets = &self.control.written_offsets;
        if at == 9 {
            return Some(offsets.turn(offset).to_degrees());
        }
        let letter = LETTERS.chars().nth(usize::try_from(at).ok()?)?;
        let slot = self.control.known_slot(letter.to_ascii_uppercase())?;
        Some(self.control.written(slot, offsets.origin(offset, slot)?))
    }

    fn position(&self, letter: char) -> Option<f64> {
        // A compensated move that waits has no end yet.
        if self.modal.compensation != NO_COMPENSATION {
            return None;
        }
        let slot = self.control.known_slot(letter.to_ascii_uppercase())?;
        let reading = self.control.reading(slot)?;
        let diameter = if self.modal.diameter && letter == 'x' { 2.0 } else { 1.0 };
        Some(diameter * self.control.written(slot, reading))
    }

    /// Returns a named parameter that the control provides; `calls` are running.
    pub(super) fn name(&self, name: &str, calls: usize) -> Option<f64> {
        let (control, modal) = (self.control, self.modal);
        let rest = name.strip_prefix('_')?;
        let mut letters = rest.chars();
        if let (Some(letter), None) = (letters.next(), letters.next())
            && LETTERS.contains(letter)
        {
            return self.position(letter);
        }
        let count = |number: u32| Some(f64::from(number));
        let is = |on: bool| Some(flag(on));
        let incremental = modal.distance == DistanceMode::Incremental;
        match rest {
            "metric" => is(!control.inch),
            "imperial" => is(control.inch),
            "feed" => control.feed.or(Some(0.0)),
            "rpm" => Some(control.speed),
            "current_tool" => control.tools.last().map(|&tool| f64::from(tool)),
            "selected_tool" => count(control.tool),
            "line" => count(self.line),
            "units_per_minute" => is(control.feed_mode == FeedMode::PerMinute),
            "inverse_time" => is(control.feed_mode == FeedMode::Inverse),
            "units_per_rev" => is(control.feed_mode == FeedMode::PerRevolution),
            "spindle_on" => is(control.sense != 0),
            "spindle_cw" => is(control.sense > 0),
            _ if self.dialect != Dialect::LinuxCnc => None,
            // What the last subprogram returned; none has yet.
            "value" | "value_returned" | "remap_level" | "vminor" => Some(0.0),
            "motion_mode" => count(modal.motion),
            "ccomp" => count(modal.compensation),
            "plane" => count(170 + 10 * u32::try_from(modal.plane).unwrap_or_default()),
            "absolute" => is(!incremental),
            "incremental" => is(incremental),
            "ijk_absolute_mode" => is(modal.arc_absolute),
            "lathe_diameter_mode" => is(modal.diameter),
            "lathe_radius_mode" => is(!modal.diameter),
            "retract_r_plane" => is(modal.to_r),
            "retract_old_z" => is(!modal.to_r),
            "spindle_css_mode" => is(control.surface.is_some()),
            "spindle_rpm_mode" => is(control.surface.is_none()),
            "tool_offset" => is(control.length),
            // G54 is 540, G59.3 is 593.
            "coord_system" => count(match u32::from(control.offset) {
                offset @ 0..=5 => 540 + 10 * offset,
                offset => 585 + offset,
            }),
            // The program runs on the machine, not in a preview.
            "task" => Some(1.0),
            "call_level" => Some(f64::from(u32::try_from(calls).ok()?)),
            "vmajor" => Some(2.9),
            "pi" => Some(std::f64::consts::PI),
            _ => None,
        }
    }
}

/// Returns 1 for what holds, and 0.
fn flag(holds: impl Into<u8>) -> f64 {
    f64::from(holds.into())
}
