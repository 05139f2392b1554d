//! Data of a drilling cycle.

/// A drilling cycle as it was defined; lengths as written, depths downwards positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct KlartextCycle {
    pub(super) number: u32,
    /// `Q200`: from the surface up to where the tool starts.
    pub(super) setup: f64,
    /// `Q201`: from the surface down to the bottom.
    pub(super) depth: f64,
    /// `Q202`; `None`: the hole is one stroke.
    pub(super) infeed: Option<f64>,
    /// `Q206` \[mm/min\]; for tapping with `Q239` the pitch times the speed.
    pub(super) feed: CycleFeed,
    /// `Q208`.
    pub(super) retract: CycleFeed,
    /// `Q203`; `None`: the tool stands at the set-up clearance when the cycle is called.
    pub(super) surface: Option<f64>,
    /// `Q204`: from the surface up to where the tool ends.
    pub(super) second: f64,
    /// `Q210` \[s\].
    pub(super) dwell_top: f64,
    /// `Q211` \[s\].
    pub(super) dwell_bottom: f64,
    /// `Q213`: chip breaks before the tool leaves the hole.
    pub(super) breaks: u32,
    /// `Q256`; of cycle 209 as a length.
    pub(super) chip: f64,
    /// `Q258`: height above the last depth at which cycle 205 begins to cut again.
    pub(super) above: Option<f64>,
}

/// Feed of a stroke of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CycleFeed {
    /// `FMAX`.
    Rapid,
    /// \[mm/min\] as written.
    PerMinute(f64),
    /// Pitch of a thread as written: the spindle leads.
    Pitch(f64),
}

impl KlartextCycle {
    /// Begins cycle 1, whose data follow line by line.
    pub(super) fn pecking() -> Self {
        Self {
            number: 1,
            setup: 0.0,
            depth: 0.0,
            infeed: None,
            feed: CycleFeed::PerMinute(0.0),
            retract: CycleFeed::Rapid,
            surface: None,
            second: 0.0,
            dwell_top: 0.0,
            dwell_bottom: 0.0,
            breaks: 0,
            chip: 0.0,
            above: None,
        }
    }
}
