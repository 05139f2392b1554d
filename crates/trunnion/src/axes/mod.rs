//! Tool path to axis path: branch over the whole path, unwinding, singular cone.
//!
//! Along a curve the axes follow by continuity: nodes carry exact derivatives and stand so close
//! that the quintic between them stays within tolerance of the exact kinematics. Which branch and
//! which whole turn each stretch between two links takes is chosen over the whole path
//! ([`follow`]), because a greedy choice can run into the end of a rotary's travel.

mod course;
mod error;
mod march;
mod plan;
mod stops;

pub use error::AxesError;

use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::types::{AxisPath, AxisPiece, AxisVector, Progress, ToolPath};

/// Which point the programmed feed refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FeedPoint {
    /// The tool tip.
    Tip,
    /// The cutter contact.
    Contact,
}

/// How closely axes follow a tool path. No `Default`: the caller knows the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxesOptions {
    /// Largest distance between the tip of the axis path and that of the tool path \[mm\].
    pub tip_tolerance: f64,
    /// Largest angle between the tool axes of both \[rad\]. A singular direction that is passed
    /// within a tenth of it is passed straight through, if the tip stays within its tolerance.
    pub axis_tolerance: f64,
    /// Largest rotary move between two nodes \[rad\].
    pub max_rotary_step: f64,
    /// What `feed_rate` of the nodes refers to.
    pub feed_at: FeedPoint,
    /// Price of a radian of each rotary, workpiece side first; the whole path is made as cheap
    /// as possible.
    pub rotary_weights: [f64; 2],
    /// Where the rotaries stand before the path; usually [`crate::machine::Machine::home`].
    pub start: AxisVector,
}

/// Worst distance between axis path and tool path, at points between the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Tip \[mm\].
    pub tip: f64,
    /// Tool axis \[rad\].
    pub axis: f64,
}

/// An axis path and how well it follows.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// The axes.
    pub path: AxisPath,
    /// The worst deviation found.
    pub deviation: Deviation,
    /// Weighted rotary travel of the whole path \[rad\], the least of all choices of branch and
    /// turn.
    pub rotary_travel: f64,
}

impl Deviation {
    /// The worse of both, tip and axis apart.
    #[must_use]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { tip: self.tip.max(other.tip), axis: self.axis.max(other.axis) }
    }
}

/// Axes along a tool path.
///
/// Curves keep their parameter: `s` of a node is the curve's `u`. Between curves that meet without
/// a link the axes are continuous. On a link ([`crate::types::Geometry::Reorient`]) the tip moves
/// straight and the rotaries turn in proportion from the end of the stretch before to the start of
/// the next, over `s` in mm (rad where the tip stands); a link that moves nothing gives no piece.
///
/// Branch and whole turns are chosen once for each stretch between two links, so that the weighted
/// rotary travel of the whole path is least (dynamic programming over branch and turn; ties go to
/// what the axes prefer), every stretch inside travel. Where the tool stays in the singular
/// direction the free rotary is held.
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
) -> Result<Followed, AxesError> {
    error::options(options)?;
    let inverse = Inverse::new(kinematics).map_err(|source| AxesError::Inverse {
        piece: 0,
        u: 0.0,
        source,
    })?;
    let marcher = march::Marcher { inverse: &inverse, options };
    let (stops, links) = stops::split(path, options)?;
    let stops = stops::candidates(&marcher, path, &stops, progress)?;
    let chosen = plan::choose(&marcher, &stops, &links)?;
    Ok(assemble(&chosen, &links, &stops))
}

/// Stretches and links in order.
fn assemble(
    chosen: &plan::Chosen,
    links: &[stops::Link],
    stops: &[Vec<stops::Candidate>],
) -> Followed {
    let mut pieces: Vec<AxisPiece> = Vec::new();
    let mut deviation = Deviation::default();
    let all = stops.iter().zip(&chosen.steps).enumerate();
    for (index, (candidates, step)) in all {
        if let Some(candidate) = candidates.get(step.candidate) {
            pieces.extend(candidate.shifted(step.offset));
            deviation = deviation.max(candidate.deviation);
        }
        if let (Some(link), Some(marched)) = (links.get(index), chosen.links.get(index)) {
            deviation = deviation.max(marched.deviation);
            if let Some(nodes) = marched.nodes() {
                pieces.push(AxisPiece { motion: link.motion, source: link.piece, nodes });
            }
        }
    }
    Followed { path: AxisPath { pieces }, deviation, rotary_travel: chosen.cost }
}
