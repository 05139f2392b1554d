//! Coordinates that stay known over a tool change.

use super::kinematics::ControlKinematics;
use super::word_frame::ToolLength;
use crate::types::AxisVector;

/// Sine below which a direction is along Z: words of rotaries have no more digits \[1\].
const ALONG_Z: f64 = 1e-6;

/// Returns true if neither another tool length nor a travel of Z moves the tip along X or Y of the table.
///
/// Then X and Y are as well known after a tool change as before it: a change sends only Z away from the part.
pub fn keeps_xy<C: ControlKinematics>(control: &C, axes: &AxisVector) -> bool {
    let mut raised = *axes;
    raised[2] += 1.0;
    // The tip follows the Z axis by its unit direction in the table frame.
    let travel = control.tip(&raised, ToolLength::Active) - control.tip(axes, ToolLength::Active);
    travel.xy().norm() <= ALONG_Z && control.axis(axes).xy().norm() <= ALONG_Z
}
