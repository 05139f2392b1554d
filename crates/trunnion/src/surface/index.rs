//! Closest points: bound-and-prune over Bezier patches, then Newton's method.

use super::Surface;
use super::error::ClosestError;
use super::error::SurfaceError;
use super::face::Face;
use super::jet::SurfaceJet2;
use super::newton;
use super::patches::PatchTree;
use nalgebra::Point3;
use nalgebra::UnitVector3;

/// A face prepared for closest-point queries.
#[derive(Debug, Clone)]
pub struct FaceIndex {
    face: Face,
    search: Search,
}

/// How the closest point over the whole domain is found.
#[derive(Debug, Clone)]
enum Search {
    Patches(PatchTree),
}

/// Foot of a perpendicular (or, from a search over the domain, possibly a border point).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Parameters.
    pub uv: [f64; 2],
    /// Point of the surface.
    pub point: Point3<f64>,
    /// Unit normal on the cutter's side (the face's `flip` applied).
    pub normal: UnitVector3<f64>,
    /// Distance \[mm\] of the query point, positive on the cutter's side of the tangent plane.
    pub distance: f64,
    /// Derivatives at the foot (`flip` not applied).
    pub jet: SurfaceJet2,
}

impl FaceIndex {
    /// Prepares `face`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Unbounded`] for an endless surface without trims.
    pub fn new(face: Face) -> Result<Self, SurfaceError> {
        let Face { number, surface, loops, flip } = face;
        let face = Face::new(number, surface, loops, flip)?;
        let search = match &face.surface {
            Surface::Nurbs(surface) => Search::Patches(PatchTree::new(surface)),
        };
        Ok(Self { face, search })
    }

    /// The face.
    pub fn face(&self) -> &Face {
        &self.face
    }

    /// The surface point closest to `p` over the whole domain, trims disregarded.
    ///
    /// Guaranteed: whatever is left unsearched is proved to be no closer, up to rounding
    /// (`1e-10` of the size of surface and query). Spline surfaces are bounded by the boxes and
    /// the planes of support of their patches' control points.
    ///
    /// # Errors
    ///
    /// [`ClosestError`]: a query that is not finite, no normal at the closest point, or too many
    /// places equally close.
    pub fn closest(&self, p: &Point3<f64>) -> Result<Foot, ClosestError> {
        if !p.iter().all(|x| x.is_finite()) {
            return Err(ClosestError::NotFinite);
        }
        match (&self.search, &self.face.surface) {
            (Search::Patches(tree), Surface::Nurbs(surface)) => {
                let found = tree.closest(surface, p)?;
                self.foot(found, self.face.surface.jet2(found[0], found[1]), p)
            }
        }
    }

    /// Foot of the perpendicular from `p` near `guess`, by Newton's method on the surface and its
    /// continuation beyond the domain. Parameters stay on the turn of `guess` on a periodic
    /// surface. Where the method finds no minimum, the same as [`FaceIndex::closest`].
    ///
    /// # Errors
    ///
    /// As [`FaceIndex::closest`].
    pub fn closest_near(&self, p: &Point3<f64>, guess: [f64; 2]) -> Result<Foot, ClosestError> {
        if let Some((uv, jet)) = newton::free(&self.face.surface, p, guess)
            && let Ok(foot) = self.foot(uv, jet, p)
        {
            return Ok(foot);
        }
        self.closest(p)
    }

    /// Side, normal and distance for parameters found.
    fn foot(&self, uv: [f64; 2], jet: SurfaceJet2, p: &Point3<f64>) -> Result<Foot, ClosestError> {
        let offset = p - jet.s;
        let size = offset.norm();
        let normal = jet
            .normal()
            .or_else(|| jet.normal_towards(self.face.inwards(uv[0], uv[1])))
            .map(|n| if self.face.flip { -n } else { n })
            .ok_or(ClosestError::NoNormal { uv, distance: size })?;
        let distance = if offset.dot(&normal) < 0.0 { -size } else { size };
        Ok(Foot { uv, point: jet.s, normal, distance, jet })
    }
}

impl std::ops::Deref for FaceIndex {
    type Target = Face;

    fn deref(&self) -> &Face {
        &self.face
    }
}
