//! Words of a block that moves.

use crate::read::arc::ArcSense;
use crate::read::control::{DistanceMode, MoveTarget};

/// A polar word: `PR`, `PA`, `IPR`, `IPA`.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolarWord {
    /// Radius \[mm\] or angle \[rad\].
    pub(super) value: f64,
    pub(super) mode: DistanceMode,
}

/// Retraction along the tool axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Retraction {
    /// `M140`: `MB` is to follow.
    Unstated,
    /// `MB50` \[mm\].
    Distance(f64),
    /// `MB MAX`.
    Limit,
}

/// Words of a block.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "words that stand in a block or do not")]
pub(super) struct PathBlock {
    pub(super) target: MoveTarget,
    /// `TX TY TZ`.
    pub(super) vector: [Option<f64>; 3],
    pub(super) feed: Option<f64>,
    /// `FU`: the feed is one per revolution.
    pub(super) per_revolution: bool,
    pub(super) rapid: bool,
    /// `DR+` is counterclockwise.
    pub(super) sense: Option<ArcSense>,
    pub(super) radius: Option<f64>,
    /// `LEN` \[mm\].
    pub(super) length: Option<f64>,
    /// `PR`, `PA`.
    pub(super) polar: [Option<PolarWord>; 2],
    /// `M128` stood in the block: F is how fast it may compensate.
    pub(super) tcpm: bool,
    /// `M99`.
    pub(super) calls: bool,
    /// `M140`, and how far `MB` retracts.
    pub(super) retract: Option<Retraction>,
    /// `C+Q122`: the rotary axes go where `PLANE` reckoned.
    pub(super) to_plane: bool,
    pub(super) ends: bool,
    pub(super) stop: Option<(usize, usize)>,
}

impl PathBlock {
    pub(super) fn new() -> Self {
        Self {
            target: MoveTarget::new(usize::MAX, 1),
            vector: [None; 3],
            feed: None,
            per_revolution: false,
            rapid: false,
            sense: None,
            radius: None,
            length: None,
            polar: [None; 2],
            tcpm: false,
            calls: false,
            retract: None,
            to_plane: false,
            ends: false,
            stop: None,
        }
    }
}
