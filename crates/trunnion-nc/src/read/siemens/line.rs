//! Words of one Sinumerik block.

use super::cycle::SiemensCycle;
use crate::read::arc::ArcSense;
use crate::read::control::{DistanceMode, MoveTarget};

/// Motion that axis words make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SiemensMotion {
    Rapid,
    Feed,
    Arc(ArcSense),
}

/// Kind of a programmable frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameEffect {
    /// `TRANS`.
    Shift,
    /// `ROT`.
    Turn,
    /// `MIRROR`.
    Mirror,
    /// `SCALE`.
    Scale,
}

/// A programmable frame of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameWord {
    pub(super) kind: FrameEffect,
    pub(super) mode: ShiftMode,
    /// Values of X Y Z as written, beside those of shifts.
    pub(super) values: [Option<f64>; 3],
    /// `RPL=`: the turn in the active plane.
    pub(super) in_plane: Option<f64>,
    pub(super) at: usize,
}

impl FrameWord {
    pub(super) fn new(kind: FrameEffect, mode: ShiftMode, at: usize) -> Self {
        Self { kind, mode, values: [None; 3], in_plane: None, at }
    }
}

/// Effect of a programmable frame on the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ShiftMode {
    /// `TRANS`.
    Replacing,
    /// `ATRANS`.
    Additive,
}

/// A centre word: `I5`, `I=AC(5)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CenterWord {
    /// \[mm\]
    pub(super) value: f64,
    /// A coordinate, or a distance from the start of the arc.
    pub(super) mode: DistanceMode,
}

/// Pole of polar coordinates, and the last of them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PolarPole {
    /// \[mm\]
    pub(super) pole: [f64; 2],
    pub(super) radius: Option<f64>,
    /// \[degrees\]
    pub(super) angle: Option<f64>,
}

/// Words of one block.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "words that stand in a block or do not")]
pub(super) struct SiemensBlock {
    pub(super) target: MoveTarget,
    /// `A3= B3= C3=`.
    pub(super) vector: [Option<f64>; 3],
    /// `I J K`.
    pub(super) center: [Option<CenterWord>; 3],
    pub(super) radius: Option<f64>,
    /// `RP=` and `AP=`.
    pub(super) polar: [Option<CenterWord>; 2],
    /// `G110` to `G112`.
    pub(super) pole: Option<u32>,
    pub(super) turns: u32,
    pub(super) feed: Option<f64>,
    pub(super) speed: Option<f64>,
    pub(super) dwell: bool,
    pub(super) machine: bool,
    pub(super) motion: bool,
    pub(super) tool: Option<u32>,
    pub(super) changes_tool: bool,
    pub(super) turns_spindle: bool,
    /// `TRANS`, `AROT` and the like.
    pub(super) frame: Option<FrameWord>,
    pub(super) ends: bool,
    /// Its words are limits, and move nothing.
    pub(super) passive: bool,
    /// `MCALL`, and the cycle behind it or alone.
    pub(super) calls_modally: bool,
    pub(super) cycle: Option<SiemensCycle>,
}

impl SiemensBlock {
    pub(super) fn new() -> Self {
        Self {
            target: MoveTarget::new(usize::MAX, 1),
            vector: [None; 3],
            center: [None; 3],
            radius: None,
            polar: [None; 2],
            pole: None,
            turns: 0,
            feed: None,
            speed: None,
            dwell: false,
            machine: false,
            motion: false,
            tool: None,
            changes_tool: false,
            turns_spindle: false,
            frame: None,
            ends: false,
            passive: false,
            calls_modally: false,
            cycle: None,
        }
    }
}
