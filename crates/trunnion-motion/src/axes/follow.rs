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

/// Follows a tool path with the axes of a machine.
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
/// comes back to the same pose (`RetractOptions`); the best point for that is part of the choice.
///
/// # Errors
///
/// [`AxesError`]: a pose out of reach or travel, with piece, parameter and remedy; an option out of range;
/// pieces that do not meet; cancelled.
///
/// # Source
///
/// `docs/sources.md#000` (derivatives), `docs/sources.md#002` (branches, singular directions).
///
/// # Example
///
/// A straight cut of 100 mm while the tool tilts from 0.1 to 0.4 rad:
///
/// ```
/// use trunnion_motion::axes::{AxesOptions, follow};
/// use trunnion_motion::machine::{KinematicChain, Kinematics, Setup};
/// use trunnion_motion::types::{
///     Motion, PieceGeometry, PoseCurve, PoseTolerance, Silent, Station, ToolPath, ToolPiece, ToolPose,
/// };
///
/// let chain = KinematicChain::new()
///     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
///     .rotary("A", [1.0, 0.0, 0.0], [0.0; 3])
///     .bed()
///     .linear("X", [1.0, 0.0, 0.0])
///     .linear("Y", [0.0, 1.0, 0.0])
///     .linear("Z", [0.0, 0.0, 1.0]);
/// let kinematics = Kinematics::from_chain(&chain, &Setup::default())?;
///
/// let station = |share: f64| {
///     let (sin, cos) = (0.1 + 0.3 * share).sin_cos();
///     let pose = ToolPose::new([100.0 * share, 0.0, 50.0], [0.0, -sin, cos])?;
///     Some(Station { pose, contact: pose.tip })
/// };
/// let stations: Option<Vec<Station>> = (0..=10).map(|k| station(0.1 * f64::from(k))).collect();
/// let curve = PoseCurve::through(&stations.ok_or("a pose")?, 10.0);
/// let cut = ToolPiece { motion: Motion::Cut, geometry: PieceGeometry::Curve(curve) };
///
/// let options = AxesOptions::within(PoseTolerance::new(1e-3, 1e-4), kinematics.machine().home());
/// let followed = follow(&kinematics, &ToolPath { pieces: vec![cut] }, &options, &Silent)?;
/// assert!(followed.deviation.tip <= 1e-3 && followed.deviation.axis <= 1e-4);
/// // A turns from 0.1 to 0.4 rad, after 0.1 rad from home to the start.
/// assert!((followed.rotary_travel - 0.4).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    // Smooth singular passages, follow all branches of each segment, and choose among them.
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
