//! Tools over moves, body by body, as stock is cut by them.

use super::broad_phase::{BoundedPiece, MovingPart};
use super::clip::ray;
use super::collision::CollisionKind;
use crate::cutter::Cutter;
use crate::verify::VerifyError;
use crate::verify::replay::{Mover, Segment};
use crate::verify::swept::quadratic;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::tool;
use crate::verify::swept::tool::ConvexBody;
use std::sync::Arc;

/// Tools by their places in the table, and how exactly they are moved.
pub(crate) struct MovingTools {
    /// The bodies, and how far a point may be from the tip \[mm\].
    all: Vec<(Vec<ConvexBody>, f64)>,
    /// \[mm\]
    pub(crate) tolerance: f64,
    /// How near to material is close \[mm\].
    margin: f64,
}

impl MovingTools {
    pub(crate) fn new(cutters: &[&Cutter], tolerance: f64, margin: f64) -> Self {
        Self { all: tool::tools(cutters), tolerance, margin }
    }

    /// How far a point of a tool may be from its tip \[mm\].
    pub(crate) fn size(&self, tool: usize) -> f64 {
        self.all.get(tool).map_or(0.0, |(_, size)| *size)
    }

    /// The tool over a move, in all the ways it may be run; `number` is that of its first part.
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
            part.number([number, own], self.margin);
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
            let stretch = |piece: &MotionPiece| BoundedPiece::new(piece, *size);
            let straight: Arc<[BoundedPiece]> = straight.iter().map(stretch).collect();
            for (index, body) in bodies.iter().enumerate() {
                let harm = match (index, segment.rapid) {
                    (0, false) => None,
                    (0, true) => Some(CollisionKind::Rapid),
                    _ => Some(CollisionKind::Holder),
                };
                parts.push(MovingPart::new(&stretch(piece), Arc::clone(&straight), *body, harm));
            }
        }
        Ok(())
    }
}
