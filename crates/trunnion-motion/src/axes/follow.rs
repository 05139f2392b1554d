//! From a tool path to an axis path.

use super::assemble::assemble;
use super::error::{self, AxesError};
use super::follower::PathFollower;
use super::options::AxesOptions;
use super::result::FollowedPath;
use super::{branch_plan, origins, segments, singular_passage};
use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::types::{Progress, ToolPath};

/// Axes along a tool path.
///
/// Curves keep their parameter: `s` of a node is the curve's `u`. Between curves that meet without
/// a link the axes are continuous. On a link ([`crate::types::PieceGeometry::Reorient`]) the tip moves
/// straight and the rotaries turn in proportion from the end of the segment before to the start of
/// the next, over `s` in mm (rad where the tip stands); a link that moves nothing gives no piece.
///
/// Branch and whole turns are chosen once for each segment between two links, so that the weighted
/// rotary travel of the whole path is least (dynamic programming over branch and turn; ties go to
/// what the axes prefer), every segment inside travel. Where the tool stays in the singular
/// direction the free rotary is held.
///
/// If a rotary's travel ends on a segment, the tool leaves the part, the rotaries turn, and it
/// comes back to the same place (`RetractOptions`); where that is best done is part of the choice.
///
/// # Errors
///
/// [`AxesError`]: a pose out of reach or travel with piece, place and remedy; options without
/// sense; pieces that do not meet; cancelled.
///
/// # Source
///
/// `docs/sources.md#000` (derivatives), `docs/sources.md#002` (branches, singular directions).
pub fn follow(
    kinematics: &Kinematics,
    path: &ToolPath,
    options: &AxesOptions,
    progress: &dyn Progress,
) -> Result<FollowedPath, AxesError> {
    error::options(options)?;
    let inverse = Inverse::new(kinematics).map_err(|source| AxesError::Inverse {
        piece: 0,
        u: 0.0,
        source,
    })?;
    let follower = PathFollower { inverse: &inverse, options };
    let (smoothed, passages) = singular_passage::smooth(&inverse, path, options).unzip();
    let path = smoothed.as_ref().unwrap_or(path);
    let (shapes, links) = segments::split(path, options)?;
    let segments = segments::candidates(&follower, path, &shapes, progress)?;
    let chosen = branch_plan::plan_branches(&follower, &segments, &links)
        .map_err(|error| origins::explain(error, &follower, &segments, &links))?;
    let passages = passages.unwrap_or_default();
    Ok(FollowedPath { passages, ..assemble(chosen, &links, segments) })
}
