//! Modal state of G-code, and the actions of one block.

use super::block::CodeWord;
use super::compensation::Compensation;
use super::predefined::{ModalCodes, NO_COMPENSATION};
use super::saved_state::SavedState;
use super::spline_points::SplineState;
use crate::read::arc::ArcSense;
use crate::read::control::{DistanceMode, SLOTS};

/// Motion that axis words make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GcodeMotion {
    Rapid,
    Feed,
    /// `G2` or `G3`.
    Arc(ArcSense),
    /// `G81` and so on, in tenths.
    Cycle(u32),
    /// `G5`, `G5.1`, `G5.2`.
    Spline,
    /// `G33`, `G33.1`, `G76` of `LinuxCNC`, in tenths.
    Thread(u32),
    /// `G38.2` and so on, in tenths.
    Probe(u32),
}

/// Distance \[mm\] and angle \[degrees\] of words in polar coordinates (`G16`).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PolarPlace {
    pub(super) radius: Option<f64>,
    pub(super) angle: Option<f64>,
}

/// Modal state that holds from line to line, beside [`ControlState`](super::control::Control).
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "modal switches are what a control has")]
pub(super) struct ModalState {
    pub(super) motion: Option<GcodeMotion>,
    /// Motion that a cycle interrupts.
    pub(super) before_cycle: Option<GcodeMotion>,
    pub(super) distance: DistanceMode,
    /// `G90.1`.
    pub(super) arc_absolute: bool,
    /// 0: XY, 1: ZX, 2: YZ.
    pub(super) plane: usize,
    /// `G43.5`.
    pub(super) vector: bool,
    /// `G7`: X counts in diameters.
    pub(super) diameter: bool,
    /// Cutter compensation that is on.
    pub(super) compensation: Option<Box<Compensation>>,
    /// Compensation has ended and nothing has moved since: an arc cannot lead away.
    pub(super) leaves_contour: bool,
    /// Steps that were there when the line began.
    pub(super) line_began: usize,
    /// The code of a spline in tenths, and what its lines have collected.
    pub(super) spline_code: u32,
    pub(super) spline: SplineState,
    /// States that `M70` and `M73` saved, those of inner calls last.
    pub(super) saved: Vec<SavedState>,
    /// `G99`.
    pub(super) to_r: bool,
    pub(super) cycle: CycleState,
    /// Shift that `G92.3` brings back.
    pub(super) kept_shift: [f64; SLOTS],
    /// `G92` stood at a position that the program had not stated.
    pub(super) stood: bool,
    /// `G66`.
    pub(super) each: Option<ModalCall>,
    /// `G16`: words of the plane are a distance and an angle, and these were the last.
    pub(super) polar: Option<PolarPlace>,
    /// Planes of mirror images (`G51.1`) \[mm\].
    pub(super) mirror: [Option<f64>; 3],
    /// `G28` and `G30` \[mm, rad\]; `None`: not known.
    pub(super) references: [[Option<f64>; SLOTS]; 2],
}

impl ModalState {
    /// Returns true if words are mirrored.
    pub(super) fn mirrors(&self) -> bool {
        self.mirror.iter().any(Option::is_some)
    }

    /// Returns the codes that parameters of the control show.
    pub(super) fn codes(&self) -> ModalCodes {
        ModalCodes {
            motion: self.motion_code(),
            compensation: self.compensation.as_ref().map_or(NO_COMPENSATION, |on| on.code()),
            plane: self.plane,
            distance: self.distance,
            arc_absolute: self.arc_absolute,
            diameter: self.diameter,
            to_r: self.to_r,
        }
    }

    /// Returns the code of the motion in tenths: 10 for `G1`.
    fn motion_code(&self) -> u32 {
        match self.motion {
            Some(GcodeMotion::Rapid) => 0,
            Some(GcodeMotion::Feed) => 10,
            Some(GcodeMotion::Arc(ArcSense::Clockwise)) => 20,
            Some(GcodeMotion::Arc(ArcSense::Counterclockwise)) => 30,
            Some(
                GcodeMotion::Cycle(code) | GcodeMotion::Thread(code) | GcodeMotion::Probe(code),
            ) => code,
            Some(GcodeMotion::Spline) => self.spline_code,
            None => 800,
        }
    }
}

/// Modal groups, as bits: two codes of one group cannot stand on one line.
pub(super) mod group {
    pub(in crate::read::gcode) const NONE: u32 = 0;
    pub(in crate::read::gcode) const NONMODAL: u32 = 1;
    pub(in crate::read::gcode) const MOTION: u32 = 1 << 1;
    pub(in crate::read::gcode) const PLANE: u32 = 1 << 2;
    pub(in crate::read::gcode) const UNITS: u32 = 1 << 3;
    pub(in crate::read::gcode) const DISTANCE: u32 = 1 << 4;
    pub(in crate::read::gcode) const FEED: u32 = 1 << 5;
    pub(in crate::read::gcode) const LENGTH: u32 = 1 << 6;
    pub(in crate::read::gcode) const OFFSET: u32 = 1 << 7;
    pub(in crate::read::gcode) const BLEND: u32 = 1 << 8;
    pub(in crate::read::gcode) const ARC: u32 = 1 << 9;
    pub(in crate::read::gcode) const RETRACT: u32 = 1 << 10;
    pub(in crate::read::gcode) const STOP: u32 = 1 << 11;
    pub(in crate::read::gcode) const SPINDLE: u32 = 1 << 12;
    pub(in crate::read::gcode) const TOOL: u32 = 1 << 13;
    pub(in crate::read::gcode) const TCP: u32 = 1 << 14;
    pub(in crate::read::gcode) const TILT: u32 = 1 << 15;
    pub(in crate::read::gcode) const CANCEL: u32 = 1 << 16;
    pub(in crate::read::gcode) const SPEED: u32 = 1 << 17;
    pub(in crate::read::gcode) const LATHE: u32 = 1 << 18;
    pub(in crate::read::gcode) const COMPENSATION: u32 = 1 << 19;
    pub(in crate::read::gcode) const DWELL: u32 = 1 << 20;
    pub(in crate::read::gcode) const POLAR: u32 = 1 << 21;
}

/// Actions of a line besides its motion.
#[derive(Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "words that stand on a line or do not")]
pub(super) struct BlockActions {
    pub(super) groups: u32,
    /// `G4`, `G10`, `G28`, `G52`, `G92`, `G68.2`, `G53.1`: tenths and place.
    pub(super) nonmodal: Option<(u32, usize)>,
    /// `G53`.
    pub(super) machine: bool,
    /// `G41`, `G42`, `G41.1`, `G42.1`.
    pub(super) compensates: Option<CodeWord>,
    /// `G4` before the motion of the line: its place.
    pub(super) dwells: Option<usize>,
    /// A motion code stood on the line.
    pub(super) motion: bool,
    /// `G43` and its kin.
    pub(super) length: Option<CodeWord>,
    pub(super) changes_tool: bool,
    pub(super) turns_spindle: bool,
    /// The F word.
    pub(super) feed: Option<f64>,
    /// `M0`, `M1`: places of what is kept behind the motion.
    pub(super) stops: [Option<(usize, usize)>; 2],
    pub(super) ends: bool,
    pub(super) returns: bool,
    /// `M99 P10`: the line that is run next, and its place.
    pub(super) return_to: Option<(f64, usize)>,
    /// The subprogram is a part of this program (`M97`).
    pub(super) calls_locally: bool,
    /// Subprogram, times, place.
    pub(super) call: Option<(Box<str>, u32, usize)>,
    /// Parameters of its own.
    pub(super) arguments: Option<Vec<f64>>,
}

impl BlockActions {
    pub(super) fn has(&self, group: u32) -> bool {
        self.groups & group != 0
    }
}

/// Values that stay from hole to hole.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CycleState {
    /// Haas: by how much each peck is less than the one before, and the least \[mm\].
    pub(super) shrinks: Option<[f64; 2]>,
    pub(super) r: Option<f64>,
    /// Bottom.
    pub(super) z: Option<f64>,
    /// Depth of a peck.
    pub(super) q: Option<f64>,
    /// I J K of `G87`.
    pub(super) back: [Option<f64>; 3],
    /// \[s\]
    pub(super) dwell: f64,
    /// Position of the drill axis before the first hole.
    pub(super) initial: Option<f64>,
    pub(super) running: bool,
}

/// A call that every move makes: `G66`.
#[derive(Debug, Clone)]
pub(super) struct ModalCall {
    pub(super) program: Box<str>,
    pub(super) arguments: Vec<f64>,
    /// Depth of calls at which it was given: moves of the macro itself make none.
    pub(super) level: usize,
    pub(super) at: usize,
}
