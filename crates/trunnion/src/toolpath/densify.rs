//! More cutter locations between given ones.

use super::interpolation::{GreatCircle, InterpolationError};
use crate::types::{Progress, Stage, ToolPose};
use nalgebra::UnitVector3;

/// Largest steps between the cutter locations of a path. No `Default`: the caller knows the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathResolution {
    /// Largest distance between neighbouring tips \[mm\].
    pub max_step: f64,
    /// Largest angle between neighbouring tool axes \[rad\]: the practical knob of paper 003.
    pub max_turn: f64,
}

/// Cutter locations between two reports: below a millisecond of work.
const REPORTED: usize = 4096;

/// Inserts cutter locations so that neither step nor turn exceeds `resolution`: equal parts of the
/// straight move of the tip and of the great circle of the tool axis, both in the workpiece frame.
///
/// Given locations are kept, in order and bit for bit.
///
/// # Errors
///
/// [`InterpolationError::Opposite`] for opposite tool axes, [`InterpolationError::BadResolution`]
/// unless both limits are positive; [`InterpolationError::Cancelled`] on request.
///
/// # Source
///
/// Fig. 5 of `docs/sources.md#003`; its limit reads 0.08° but is 0.08 rad.
///
/// # Example
///
/// A move of 10 mm with a turn of 45 degrees: steps of at most 4 mm would take three parts, turns of at most
/// 0.1 rad take eight.
///
/// ```
/// use trunnion::toolpath::{PathResolution, densify};
/// use trunnion::types::{Silent, ToolPose};
///
/// let from = ToolPose::new([0.0; 3], [0.0, 0.0, 1.0]).unwrap();
/// let to = ToolPose::new([10.0, 0.0, 0.0], [0.0, 1.0, 1.0]).unwrap();
/// let fine = densify(&[from, to], PathResolution { max_step: 4.0, max_turn: 0.1 }, &Silent)?;
/// assert_eq!(fine.len(), 1 + 8);
/// assert_eq!([fine[0], fine[8]], [from, to]);
/// # Ok::<(), trunnion::toolpath::InterpolationError>(())
/// ```
pub fn densify(
    path: &[ToolPose],
    resolution: PathResolution,
    progress: &dyn Progress,
) -> Result<Vec<ToolPose>, InterpolationError> {
    let PathResolution { max_step, max_turn } = resolution;
    if !(max_step > 0.0 && max_turn > 0.0) {
        return Err(InterpolationError::BadResolution { max_step, max_turn });
    }
    let mut fine: Vec<ToolPose> = path.first().copied().into_iter().collect();
    let moves = path.len().saturating_sub(1) as u64;
    for (done, pair) in (0..).zip(path.windows(2)) {
        let [from, to] = [pair[0], pair[1]];
        let turn = GreatCircle::new(&from.axis, &to.axis)?;
        let way = to.tip - from.tip;
        // The stricter of both limits decides the number of equal parts.
        let parts = (way.norm() / max_step).max(turn.angle() / max_turn).ceil().max(1.0);
        let mut part = 1.0;
        while part < parts {
            if fine.len().is_multiple_of(REPORTED) {
                progress.step(Stage::ToolPath, done, moves)?;
            }
            let share = part / parts;
            // Unit but for rounding, which normalising removes.
            let axis = UnitVector3::new_normalize(turn.derivatives(share)[0]);
            fine.push(ToolPose { tip: from.tip + way * share, axis });
            part += 1.0;
        }
        if fine.len().is_multiple_of(REPORTED) {
            progress.step(Stage::ToolPath, done, moves)?;
        }
        fine.push(to);
    }
    progress.step(Stage::ToolPath, moves, moves)?;
    Ok(fine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::Silent;

    #[test]
    fn parts_are_equal_and_ends_are_kept() {
        let path = [([0.0; 3], [0.0, 0.0, 1.0]), ([10.0, 0.0, 0.0], [0.0, 1.0, 1.0])]
            .map(|(tip, axis)| ToolPose::new(tip, axis).unwrap());
        let fine =
            densify(&path, PathResolution { max_step: 4.0, max_turn: 0.1 }, &Silent).unwrap();
        assert_eq!(fine.len(), 1 + 8); // 45° in steps of at most 0.1 rad
        assert_eq!([fine[0], fine[8]], path);
        assert!((fine[4].tip.x - 5.0).abs() < 1e-15);
        let by_step =
            densify(&path, PathResolution { max_step: 4.0, max_turn: 1.0 }, &Silent).unwrap();
        assert_eq!(by_step.len(), 1 + 3);
        let none = PathResolution { max_step: 0.0, max_turn: 1.0 };
        assert!(matches!(
            densify(&path, none, &Silent),
            Err(InterpolationError::BadResolution { .. })
        ));
    }
}
