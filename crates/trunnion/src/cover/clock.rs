//! What passes cost.

use crate::types::{Station, ToolPose};

/// What passes and the ways between them take on a machine, and where it gets to: passes are chosen by it.
/// [`super::cover`] itself knows no machine.
pub trait Clock: Sync {
    /// Speed of the contact where nothing but the feed holds the tool back \[mm/s\].
    fn feed(&self) -> f64;

    /// Time of a pass through these stations \[s\].
    fn pass(&self, stations: &[Station]) -> f64;

    /// Time from the end of one pass to the beginning of the next, leads and link \[s\].
    fn link(&self, from: &Station, to: &Station) -> f64;

    /// Whether the machine can stand in a pose, inside the travel of its rotary axes.
    fn reaches(&self, _pose: &ToolPose) -> bool {
        true
    }
}

/// Length of the contact track at 1 mm/s, and as much for every link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// What a link takes, as a length that is cut in that time \[mm\].
    pub link: f64,
}

impl Clock for Length {
    fn feed(&self) -> f64 {
        1.0
    }

    fn pass(&self, stations: &[Station]) -> f64 {
        stations.windows(2).map(|pair| (pair[1].contact - pair[0].contact).norm()).sum()
    }

    fn link(&self, _: &Station, _: &Station) -> f64 {
        self.link
    }
}
