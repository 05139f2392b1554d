//! Drilling cycles of Sinumerik with their heights.

/// Time that the tool stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CycleDwell {
    Seconds(f64),
    Turns(f64),
}

/// Infeeds of `CYCLE83`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CyclePecks {
    /// First depth below the reference plane \[mm\].
    pub(super) first: f64,
    /// Amount by which strokes become shorter \[mm\]; negative: factor of each to the one before.
    pub(super) decrease: f64,
    /// Shortest stroke \[mm\]; zero: the amount of the decrease.
    pub(super) least: f64,
    /// Dwells at each depth, at the start, at the bottom.
    pub(super) at_depth: CycleDwell,
    pub(super) at_start: CycleDwell,
    pub(super) at_bottom: CycleDwell,
    /// Factor of the feed of the first stroke.
    pub(super) first_feed: f64,
    /// The tool comes out to clear the chips; else they are only broken.
    pub(super) clears: bool,
    /// Distance by which the tool is drawn back to break chips \[mm\].
    pub(super) back: f64,
    /// Distance before the last depth at which the feed begins again \[mm\]; zero: by the depth.
    pub(super) ahead: f64,
}

/// Kind of a hole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CycleKind {
    /// `CYCLE81`, `CYCLE82`.
    Drill,
    /// `CYCLE83`.
    Pecks(CyclePecks),
    /// `CYCLE84`, `CYCLE840`: pitch \[mm\] (negative: left-hand), speeds in and out \[1/min\]; without
    /// pitch the active feed. `after`: 3, 4 or 5, the spindle behind the cycle.
    Tap { pitch: Option<f64>, speeds: [f64; 2], after: f64 },
    /// `CYCLE85`: feeds in and out.
    Ream { feeds: [f64; 2] },
    /// `CYCLE86`: the tool moves aside with the spindle stopped \[mm\].
    Bore { aside: [f64; 3], sense: f64 },
    /// `CYCLE87`, `CYCLE88`: spindle and program stop at the bottom.
    Stop,
    /// `CYCLE89`: out with the feed.
    FeedOut,
}

/// A drilling cycle with its heights \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SiemensCycle {
    pub(super) kind: CycleKind,
    pub(super) retract: f64,
    pub(super) reference: f64,
    /// Reference plane and safety distance.
    pub(super) start: f64,
    pub(super) bottom: f64,
    pub(super) dwell: CycleDwell,
    /// Offset of the call, for messages.
    pub(super) at: usize,
}
