//! Cost models of passes and links.

use crate::types::{Station, ToolPose};

/// Times of passes and links on a machine, and the poses within its reach. Passes are chosen by this cost;
/// [`super::cover`] itself knows no machine.
pub trait PassCost: Sync {
    /// Returns the speed of the contact where only the feed limits the tool \[mm/s\].
    fn feed(&self) -> f64;

    /// Returns the time of a pass through `stations` \[s\].
    fn pass(&self, stations: &[Station]) -> f64;

    /// Returns the time from the end of one pass to the beginning of the next, with leads and link \[s\].
    fn link(&self, from: &Station, to: &Station) -> f64;

    /// Returns `true` if `pose` is inside the travel of the machine's rotary axes.
    fn reaches(&self, _pose: &ToolPose) -> bool {
        true
    }
}

/// Cost by length alone: the contact track at 1 mm/s, and a fixed length for every link.
///
/// # Example
///
/// ```
/// use nalgebra::{Point3, Vector3};
/// use trunnion::cover::{LengthCost, PassCost};
/// use trunnion::types::{Station, ToolPose};
///
/// let station = |x: f64| {
///     let tip = Point3::new(x, 0.0, 0.0);
///     Station { pose: ToolPose { tip, axis: Vector3::z_axis() }, contact: tip }
/// };
/// let cost = LengthCost { link: 25.0 };
/// assert_eq!(cost.pass(&[station(0.0), station(3.0), station(10.0)]), 10.0);
/// assert_eq!(cost.link(&station(10.0), &station(0.0)), 25.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthCost {
    /// Length that is cut in the time of one link \[mm\].
    pub link: f64,
}

impl PassCost for LengthCost {
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
