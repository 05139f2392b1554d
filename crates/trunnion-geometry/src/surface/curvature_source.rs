//! Source of the bounds of curvature of a face, made with the first question.

use super::curvatures::CurvatureTree;
use super::nurbs::NurbsSurface;
use super::swept::NurbsConversion;
use std::sync::{Arc, OnceLock};

/// Source of the bounds of curvature.
#[derive(Debug, Clone)]
pub(super) enum CurvatureSource {
    /// Pieces of the surface itself.
    Own(CurvaturePieces),
    /// Pieces of an equal NURBS surface over a thin strip `across` a sweep: along its straight
    /// lines or circles the curvature is the same everywhere.
    Thin { across: usize, strip: Box<NurbsConversion>, pieces: CurvaturePieces },
    /// In closed form.
    Closed,
}

/// Pieces of a surface, bounded when they are first asked for: a tool keeps off most faces of a part without them, and
/// bounding them takes longer than all else that a face needs. Copies share them.
#[derive(Debug, Clone, Default)]
pub(super) struct CurvaturePieces {
    tree: Arc<OnceLock<CurvatureTree>>,
}

impl CurvaturePieces {
    /// Returns the pieces of `surface`, which is the same one in every call.
    pub(super) fn of(&self, surface: &NurbsSurface) -> &CurvatureTree {
        self.tree.get_or_init(|| CurvatureTree::new(surface))
    }
}
