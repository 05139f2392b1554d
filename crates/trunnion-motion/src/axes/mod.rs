//! Tool path to axis path: branch over the whole path, unwinding, singular cone.
//!
//! Along a curve the axes follow by continuity: nodes carry exact derivatives and stand so close
//! that the quintic between them stays within tolerance of the exact kinematics. Which branch and
//! which whole turn each stretch between two links takes is chosen over the whole path
//! ([`follow`]), because a greedy choice can run into the end of a rotary's travel.

mod course;
mod error;
mod march;
mod origin;
mod plan;
mod retract;
mod setup;
mod singular;
mod stops;
mod strand;
mod travel;

pub use error::AxesError;

pub use origin::{Origins, origins};
pub use setup::{
    Assurance, Judged, Lean, LeanBounds, SetupOptions, SetupSearch, Travelled, Verdict, setup,
};
pub use singular::{Passage, SingularOptions};

use crate::inverse::Inverse;
use crate::machine::Kinematics;
use crate::types::{AxisPath, AxisPiece, AxisVector, Progress, ToolPath, ToolPose};
use nalgebra::UnitVector3;
use std::ops::Range;

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
    /// How to leave the part where travel ends on a stretch between two links; `None`: that is an
    /// error.
    pub retract: Option<RetractOptions>,
    /// How far the tool axis may be moved where a cut passes a singular direction; `None`: not at all.
    pub singular: Option<SingularOptions>,
}

/// How the tool leaves the part to unwind a rotary axis, and what that is worth. The way of the
/// machine itself is [`crate::machine::RetractPolicy`]. No `Default`: the caller knows part and tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetractOptions {
    /// Way out of the part.
    pub up: UnitVector3<f64>,
    /// Height of the tip along `up` at which the tool may turn \[mm\]; reached along the tool axis.
    pub plane: f64,
    /// Least way along the tool axis \[mm\].
    pub least: f64,
    /// Of this way, what next to the part is run as a lead \[mm\]; infinite: all of it.
    pub approach: f64,
    /// Distance kept from the ends of travel of the retracting axis \[mm\]: what blocks of a link may
    /// be off.
    pub margin: f64,
    /// Price of a retract between two pieces \[rad\], beside the rotary travel: much more than any
    /// rotary travel it could save, so that there is one only where the path cannot go on.
    pub price: f64,
    /// The same inside a cut.
    pub price_in_cut: f64,
}

impl RetractOptions {
    fn price(&self, inside: bool) -> f64 {
        if inside { self.price_in_cut } else { self.price }
    }
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
    /// Weighted rotary travel of the whole path \[rad\] with the prices of retracts, the least of
    /// all choices of branch, turn and place of retracts.
    pub rotary_travel: f64,
    /// Where the tool left the part to unwind, in order.
    pub retracts: Vec<Retracted>,
    /// Where a singular direction is passed otherwise than the tool path says, within what
    /// [`SingularOptions`] allow.
    pub passages: Vec<Passage>,
}

/// A retract that was needed: the tool leaves the part, the rotaries turn, and it comes back to the
/// very place it left, so that nothing is left uncut.
#[derive(Debug, Clone, PartialEq)]
pub struct Retracted {
    /// Index of the tool-path piece it interrupts, or that ends or starts there.
    pub source: usize,
    /// Parameter of that piece.
    pub u: f64,
    /// Whether the tool cuts before and after.
    pub in_cut: bool,
    /// Where the tool leaves and comes back.
    pub pose: ToolPose,
    /// Rotaries before and after \[rad\].
    pub rotaries: [[f64; 2]; 2],
    /// Its pieces in the axis path.
    pub pieces: Range<usize>,
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
/// a link the axes are continuous. On a link ([`crate::types::PieceGeometry::Reorient`]) the tip moves
/// straight and the rotaries turn in proportion from the end of the stretch before to the start of
/// the next, over `s` in mm (rad where the tip stands); a link that moves nothing gives no piece.
///
/// Branch and whole turns are chosen once for each stretch between two links, so that the weighted
/// rotary travel of the whole path is least (dynamic programming over branch and turn; ties go to
/// what the axes prefer), every stretch inside travel. Where the tool stays in the singular
/// direction the free rotary is held.
///
/// Where a rotary's travel ends on a stretch, the tool leaves the part, the rotaries turn, and it
/// comes back to the same place ([`RetractOptions`]); where that is best done is part of the choice.
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
    let (smoothed, passages) = singular::smooth(&inverse, path, options).unzip();
    let path = smoothed.as_ref().unwrap_or(path);
    let (stops, links) = stops::split(path, options)?;
    let stretches = stops::candidates(&marcher, path, &stops, progress)?;
    let chosen = plan::choose(&marcher, &stretches, &links)
        .map_err(|error| origin::explain(error, &marcher, &stretches, &links))?;
    let passages = passages.unwrap_or_default();
    Ok(Followed { passages, ..assemble(chosen, &links, stretches) })
}

/// Stretches, links and retracts in order.
fn assemble(
    chosen: plan::Chosen,
    links: &[stops::Link],
    mut stretches: Vec<strand::Stretch>,
) -> Followed {
    let mut pieces: Vec<AxisPiece> = Vec::new();
    let mut deviation = Deviation::default();
    let mut retracts = Vec::new();
    for part in chosen.parts {
        match part.way {
            plan::Way::Start => {}
            plan::Way::Link(marched) => {
                deviation = deviation.max(marched.deviation);
                let link = part.stretch.checked_sub(1).and_then(|link| links.get(link));
                if let (Some(link), Some(nodes)) = (link, marched.into_nodes()) {
                    pieces.push(AxisPiece { motion: link.motion, source: link.piece, nodes });
                }
            }
            plan::Way::Retract { joint, pose, rotaries, legs } => {
                let source = joint.piece;
                let first = pieces.len();
                for (motion, marched) in legs {
                    deviation = deviation.max(marched.deviation);
                    pieces.push(AxisPiece { motion, source, nodes: marched.nodes });
                }
                let (u, in_cut, pieces) = (joint.u, joint.inside, first..pieces.len());
                retracts.push(Retracted { source, u, in_cut, pose, rotaries, pieces });
            }
        }
        let stretch = stretches.get_mut(part.stretch);
        if let Some(strand) = stretch.and_then(|of| of.strands.get_mut(part.strand)) {
            deviation = strand.runs().fold(deviation, |all, run| all.max(run.marched.deviation));
            pieces.extend(strand.pieces(part.cells, part.offset));
        }
    }
    let (path, passages) = (AxisPath { pieces }, Vec::new());
    Followed { path, deviation, rotary_travel: chosen.cost, retracts, passages }
}
