//! Splits the moves of tools into moving bodies, as stock is clipped by them.

use super::broad_phase::{BoundedPiece, MovingPart};
use super::clip::ray;
use super::collision::CollisionKind;
use crate::cutter::Cutter;
use crate::verify::error::VerifyError;
use crate::verify::replay::mover::Mover;
use crate::verify::replay::segment::Segment;
use crate::verify::swept::quadratic;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::tool;
use crate::verify::swept::tool::ConvexBody;
use std::sync::Arc;

/// Tools in the order of the tool table, with the accuracy of their motion.
pub(crate) struct MovingTools {
    /// Bodies of each tool, with the largest distance of a point from the tip \[mm\].
    all: Vec<(Vec<ConvexBody>, f64)>,
    /// Clipping tolerance \[mm\].
    pub(crate) tolerance: f64,
    /// Distance from material at which a body is close to it \[mm\]; `None` if collisions are not searched.
    margin: Option<f64>,
}

impl MovingTools {
    /// Tools whose collisions are searched within `margin` \[mm\] of material.
    pub(crate) fn new(cutters: &[&Cutter], tolerance: f64, margin: f64) -> Self {
        Self { all: tool::tools(cutters), tolerance, margin: Some(margin) }
    }

    /// Tools that only cut: nothing that they meet is a collision.
    pub(crate) fn cutting(cutters: &[&Cutter], tolerance: f64) -> Self {
        Self { all: tool::tools(cutters), tolerance, margin: None }
    }

    /// Returns the largest distance of a tool's points from its tip \[mm\].
    pub(crate) fn size(&self, tool: usize) -> f64 {
        self.all.get(tool).map_or(0.0, |(_, size)| *size)
    }

    /// Adds the bodies of a move, in all ways it may run; `number` is that of its first part.
    pub(crate) fn parts(
        &self,
        mover: &Mover<'_>,
        segment: &Segment,
        number: usize,
        parts: &mut Vec<MovingPart>,
    ) -> Result<(), VerifyError> {
        let known = parts.len();
        self.parts_of(mover, segment, parts)?;
        for other in &mover.dog_leg(segment) {
            self.parts_of(mover, other, parts)?;
        }
        for (own, part) in (number..).zip(parts.iter_mut().skip(known)) {
            part.number([number, own], self.margin.unwrap_or_default());
        }
        Ok(())
    }

    fn parts_of(
        &self,
        mover: &Mover<'_>,
        segment: &Segment,
        parts: &mut Vec<MovingPart>,
    ) -> Result<(), VerifyError> {
        let [error, bend] = [ray::ERROR, ray::BEND].map(|share| share * self.tolerance);
        let Some((bodies, size)) = self.all.get(segment.tool) else { return Ok(()) };
        let mut pieces = Vec::new();
        quadratic::pieces(mover, segment, *size, error, &mut pieces)?;
        for piece in &pieces {
            let straight = quadratic::straight(mover, segment, piece, [*size, bend])?;
            let bounded = |piece: &MotionPiece| BoundedPiece::new(piece, *size);
            let straight: Arc<[BoundedPiece]> = straight.iter().map(bounded).collect();
            for (index, body) in bodies.iter().enumerate() {
                // The first body is the cutting part: it may meet material at feed, the others never.
                let harm = match (index, segment.rapid) {
                    _ if self.margin.is_none() => None,
                    (0, false) => None,
                    (0, true) => Some(CollisionKind::Rapid),
                    _ => Some(CollisionKind::Holder),
                };
                parts.push(MovingPart::new(&bounded(piece), Arc::clone(&straight), *body, harm));
            }
        }
        Ok(())
    }
}
