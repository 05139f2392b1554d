//! Closest points: bound-and-prune over Bezier patches, then Newton's method.

use super::curvature_source::{CurvaturePieces, CurvatureSource};
use super::error::ClosestError;
use super::error::{SurfaceError, SurfaceErrors};
use super::face::Face;
use super::geometry::Surface;
use super::hull::HullTree;
use super::jet::SurfaceJet2;
use super::newton;
use super::nurbs::NurbsSurface;
use super::over_box::distance_over;
use super::parameter_box::ParameterBox;
use super::patches::PatchTree;
use super::proximity::{SolidDistance, SolidProximity};
use super::swept::NurbsConversion;
use super::swept::RevolutionSurface;
use crate::types::{Interval, Uv};
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// A face prepared for closest-point queries.
#[derive(Debug, Clone)]
pub struct FaceIndex {
    face: Face,
    search: ClosestSearch,
    curvatures: CurvatureSource,
    /// Pieces over the box of the trims; none where distances are known in closed form.
    part: Option<FacePart>,
}

/// Part of a surface over the box of the trims: nothing else of it is there to be kept off.
#[derive(Debug, Clone)]
struct FacePart {
    /// Equal NURBS surface, where the face has none of its own.
    converted: Option<Box<NurbsSurface>>,
    tree: PatchTree,
    /// Boxes of the pieces.
    hulls: HullTree,
}

/// Search for the closest point over the whole domain.
#[derive(Debug, Clone)]
enum ClosestSearch {
    /// Over the patches of the surface itself.
    Patches(PatchTree),
    /// Over the patches of an equal NURBS surface.
    Converted(Box<NurbsConversion>, PatchTree),
    /// In closed form.
    Closed,
}

/// Share of the domain by which trims may lie beyond its ends by rounding of the file's digits.
const SEAM: f64 = 1e-6;

/// Foot of a perpendicular (or, from a search over the domain, possibly a border point).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootPoint {
    /// Parameters.
    pub uv: Uv,
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
    /// [`SurfaceError::Unbounded`] for an endless surface without trims;
    /// [`SurfaceError::DegeneratePatch`] for a sweep without area.
    pub fn new(face: Face) -> Result<Self, SurfaceError> {
        let Face { number, surface, loops, flip } = face;
        let face = Face { flip, ..Face::new(number, surface, loops)? };
        let bounds = search_bounds(&face);
        let [u, v] = bounds;
        let whole = |faults: SurfaceErrors| {
            let degenerate = SurfaceError::DegeneratePatch { u, v };
            faults.into_iter().next().unwrap_or(degenerate)
        };
        let (search, curvatures) = match &face.surface {
            Surface::Nurbs(surface) => {
                let tree = PatchTree::new(surface, surface.domain());
                (ClosestSearch::Patches(tree), CurvatureSource::Own(CurvaturePieces::default()))
            }
            Surface::Extrusion(surface) => {
                // Along v the curvature of an extrusion is constant: a short strip bounds it
                // everywhere.
                let strip = [u, Interval::new(0.0, surface.thin())];
                let [all, thin] = [bounds, strip].map(|range| surface.to_nurbs(range));
                (ClosestSearch::over(all.map_err(whole)?), thin_strip(thin.map_err(whole)?, 0))
            }
            Surface::Revolution(surface) => {
                // So it is round the axis of a revolution: a short arc stands for the whole turn.
                let strip = [Interval::new(0.0, RevolutionSurface::THIN), v];
                let [all, thin] = [bounds, strip].map(|range| surface.to_nurbs(range));
                (ClosestSearch::over(all.map_err(whole)?), thin_strip(thin.map_err(whole)?, 1))
            }
            _ => (ClosestSearch::Closed, CurvatureSource::Closed),
        };
        let part = FacePart::of(&face).map_err(whole)?;
        Ok(Self { face, search, curvatures, part })
    }

    /// Returns the face.
    pub fn face(&self) -> &Face {
        &self.face
    }

    /// Finds the surface point closest to `p` over the whole domain, trims disregarded. Where an
    /// extrusion or revolution has no end, over the box of the trims that way.
    ///
    /// Guaranteed: whatever is left unsearched is proved to be no closer, up to rounding
    /// (`1e-10` of the size of surface and query). Spline surfaces are bounded by the boxes and
    /// the planes of support of their patches' control points.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trunnion_geometry::surface::{Face, FaceIndex, NurbsSurface, Surface};
    ///
    /// // The plane z = 0 over a square of 40 mm.
    /// let point = |x, y| Point3::new(x, y, 0.0);
    /// let points =
    ///     vec![vec![point(0.0, 0.0), point(0.0, 40.0)], vec![point(40.0, 0.0), point(40.0, 40.0)]];
    /// let knots = vec![0.0, 0.0, 1.0, 1.0];
    /// let plane = NurbsSurface::new([1, 1], [knots.clone(), knots], points, None).unwrap();
    /// let index = FaceIndex::new(Face::new(1, Surface::Nurbs(plane), vec![])?)?;
    /// let foot = index.closest(&Point3::new(10.0, 20.0, 3.0))?;
    /// assert!((foot.distance - 3.0).abs() < 1e-12);
    /// assert!((foot.uv.u - 0.25).abs() < 1e-9 && (foot.uv.v - 0.5).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ClosestError`]: a query that is not finite, no normal at the closest point, or too many
    /// places equally close.
    pub fn closest(&self, p: &Point3<f64>) -> Result<FootPoint, ClosestError> {
        if !p.iter().all(|x| x.is_finite()) {
            return Err(ClosestError::NotFinite);
        }
        let surface = &self.face.surface;
        let uv = match (&self.search, surface) {
            (ClosestSearch::Patches(tree), Surface::Nurbs(surface)) => tree.closest(surface, p)?,
            (ClosestSearch::Converted(converted, tree), _) => {
                converted.original(tree.closest(&converted.surface, p)?)
            }
            _ => surface.elementary().map_or([f64::NAN; 2], |surface| surface.closest(p)),
        };
        self.foot(uv, surface.jet2(uv[0], uv[1]), p)
    }

    /// Proves that the surface over the box of the face's trims is at least `radius` \[mm\] away from
    /// `p`; returns `false` where boxes round its pieces do not show it, up to a few percent of the
    /// face's size. Some hundred times as fast as [`FaceIndex::closest`].
    pub fn clear_of(&self, p: &Point3<f64>, radius: f64) -> bool {
        match &self.part {
            Some(part) => part.hulls.clear_of(p, radius),
            None => self.distance_over_box(p).is_some_and(|distance| distance >= radius),
        }
    }

    /// Returns the distance \[mm\] from `p` of a point over the box of the face's trims that is
    /// nearer than `enough`: mostly of the nearest one; `None` proves that there is none. Faster
    /// than [`FaceIndex::closest`], which finds the nearest of points that are about equally near.
    ///
    /// Across a trimmed bowl or tube there is nothing, where the whole one has its other side.
    ///
    /// # Errors
    ///
    /// As [`FaceIndex::closest`], but for the missing normal.
    pub fn nearer(&self, p: &Point3<f64>, enough: f64) -> Result<Option<f64>, ClosestError> {
        if !p.iter().all(|x| x.is_finite()) {
            return Err(ClosestError::NotFinite);
        }
        let Some(part) = &self.part else {
            return Ok(self.distance_over_box(p).filter(|distance| *distance < enough));
        };
        if part.hulls.clear_of(p, enough) {
            return Ok(None);
        }
        match part.surface(&self.face.surface) {
            Some(surface) => part.tree.nearer(surface, p, enough),
            // Without a surface to search nothing is proven.
            None => Ok(Some(0.0)),
        }
    }

    /// Decides if the surface over the box of the face's trims comes nearer than `limit` \[mm\] to a
    /// convex solid. Undecided on surfaces whose distances are known in closed form.
    pub fn meets(&self, gap: SolidDistance<'_>, limit: f64) -> SolidProximity {
        let Some(part) = &self.part else { return SolidProximity::Undecided };
        match (part.hulls.meets(gap, limit), part.surface(&self.face.surface)) {
            (SolidProximity::Undecided, Some(surface)) => part.tree.meets(surface, gap, limit),
            (roughly, _) => roughly,
        }
    }

    /// Returns the unsigned distance \[mm\] of `p` from the surface over the box of the face's
    /// trims, where this is known in closed form: of the elementary surfaces.
    pub fn distance_over_box(&self, p: &Point3<f64>) -> Option<f64> {
        distance_over(&self.face.surface, p, self.face.bounds())
    }

    /// Finds the foot of the perpendicular from `p` near `guess`, by Newton's method on the surface
    /// and its continuation beyond the domain; in closed form on elementary surfaces. Parameters
    /// stay on the turn of `guess` on a periodic surface. Where the method finds no minimum, or one
    /// at a rim that is a point, the same as [`FaceIndex::closest`].
    ///
    /// # Errors
    ///
    /// As [`FaceIndex::closest`].
    pub fn closest_near(&self, p: &Point3<f64>, guess: Uv) -> Result<FootPoint, ClosestError> {
        let (surface, guess) = (&self.face.surface, guess.into());
        if let Some(elementary) = surface.elementary()
            && p.iter().all(|x| x.is_finite())
        {
            let uv = on_turn(elementary.closest(p), guess, surface.periods());
            return self.foot(uv, surface.jet2(uv[0], uv[1]), p);
        }
        // Newton's method finds a local minimum on the continuation. Where it fails, the search
        // over all patches decides.
        if let Some(found) = newton::free(surface, p, guess)
            && let Ok(foot) = self.foot(found.uv, found.jet, p)
        {
            return Ok(foot);
        }
        self.closest(p)
    }

    /// Returns bounds of the curvature \[1/mm\] over a rectangle of parameters (clipped to the
    /// domain): no normal curvature there is below the first or above the second number. The first
    /// is at most 0, the second at least 0; positive = the surface bends towards the cutter
    /// (concave).
    ///
    /// Guaranteed, from derivative control nets of pieces bounded once, and within 10 % of the
    /// largest curvature over the pieces the rectangle meets, unless the surface is singular there
    /// (infinite at a pole or a collapsed edge). Takes no longer than an evaluation or two.
    pub fn curvature_range(&self, cell: [Interval; 2]) -> Interval {
        let range = match (&self.curvatures, &self.face.surface) {
            (CurvatureSource::Own(pieces), Surface::Nurbs(surface)) => {
                pieces.of(surface).range(cell)
            }
            (CurvatureSource::Thin { across, strip, pieces }, _) => {
                // The parameter of the profile is clipped to its range; along the sweep all of the
                // strip counts.
                let mut within = strip.surface.domain();
                let own = within[*across];
                within[*across] = cell[*across].ends().map(|x| own.clamp(x)).into();
                // Parameters of the NURBS form run at another pace in arcs, but increase with
                // these: ends map to ends.
                let [low, high] = [0, 1].map(|end| strip.converted(within.map(|x| x.ends()[end])));
                let cell = [0, 1].map(|k| Interval::new(low[k], high[k]));
                pieces.of(&strip.surface).range(cell)
            }
            (_, surface) => {
                let elementary = surface.elementary();
                elementary.map_or(Interval::point(0.0), |surface| surface.curvatures(cell[1]))
            }
        };
        self.towards_cutter(range)
    }

    /// Returns the interval of curvatures as the cutter's side sees it.
    fn towards_cutter(&self, range: Interval) -> Interval {
        // Seen from the other side curvatures change their sign, and so their order.
        if self.face.flip { Interval::new(-range.high, -range.low) } else { range }
    }

    /// Returns bounds of the curvature as [`FaceIndex::curvature_range`] does, over all of the
    /// surface within `reach` mm of `feet` along it.
    ///
    /// Guaranteed on spline surfaces (over all there is in a ball round the feet) and on the
    /// elementary ones (whose curvature depends on `v`, which runs at a constant pace). On
    /// extrusions and revolutions, whose profile may run at any pace, if this does not fall to less
    /// than half beyond the feet. Of the continuation beyond the domain nothing is known but the
    /// curvature at the feet.
    pub fn curvature_around<'a>(
        &self,
        feet: impl Iterator<Item = &'a FootPoint> + Clone,
        reach: f64,
    ) -> Interval {
        let empty = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        if let (CurvatureSource::Own(pieces), Surface::Nurbs(surface)) =
            (&self.curvatures, &self.face.surface)
        {
            let (middle, far) = ball_round(feet);
            return self.towards_cutter(pieces.of(surface).near(&middle, far + reach));
        }
        let closed = matches!(self.curvatures, CurvatureSource::Closed);
        // A profile may run at half the pace beyond the feet: twice the range of parameters then.
        let reach = if closed { reach } else { 2.0 * reach };
        let cell = feet.fold([empty; 2], |cell, foot| {
            let paces = [foot.jet.su.norm(), foot.jet.sv.norm()];
            let uv: [f64; 2] = foot.uv.into();
            [0, 1].map(|k| {
                // reach / |S_k| is the range of the parameter that takes `reach` mm at the foot.
                cell[k].hull(Interval::point(uv[k]).widened(reach / paces[k]))
            })
        });
        self.curvature_range(cell)
    }

    /// Bounds the rate \[1/mm^2\] at which the normal curvature along a geodesic changes, over all
    /// of the surface within `reach` mm of `feet` along it: of `|(d II)(t, t, t)|` for unit
    /// tangents `t`.
    ///
    /// Guaranteed; infinite where the curvature may jump (across knots of low continuity), where
    /// the surface ends within reach, and for rational and swept surfaces, of which no bound is
    /// kept.
    pub fn curvature_rate_around<'a>(
        &self,
        feet: impl Iterator<Item = &'a FootPoint> + Clone,
        reach: f64,
    ) -> f64 {
        match (&self.curvatures, &self.face.surface) {
            (CurvatureSource::Own(pieces), Surface::Nurbs(surface)) => {
                let tree = pieces.of(surface);
                let domain = self.face.surface.domain();
                let inside = |foot: &FootPoint| {
                    let uv: [f64; 2] = foot.uv.into();
                    uv.iter().zip(domain).all(|(at, range)| range.contains(*at))
                };
                let smooth =
                    |foot: &FootPoint| inside(foot) && !tree.jumps_near(&foot.point, reach);
                // Third derivatives bound nothing across a crease or beyond the rim.
                if !feet.clone().all(smooth) {
                    return f64::INFINITY;
                }
                let (middle, far) = ball_round(feet);
                tree.rate_near(&middle, far + reach)
            }
            (_, Surface::Plane(_) | Surface::Cylinder(_) | Surface::Sphere(_)) => 0.0,
            _ => f64::INFINITY,
        }
    }

    /// Returns an upper bound of |curvature| \[1/mm\] over a rectangle of parameters; see
    /// [`FaceIndex::curvature_range`]. For the whole face pass [`Face::bounds`].
    pub fn curvature_bound(&self, cell: [Interval; 2]) -> f64 {
        let Interval { low, high } = self.curvature_range(cell);
        high.max(-low)
    }

    /// Returns a lower bound of the smallest radius \[mm\] by which the face bends towards the
    /// cutter, over its bounds; infinite where it is nowhere concave. A cutter with a larger radius
    /// of curvature cannot touch everywhere without gouging.
    pub fn smallest_concave_radius(&self) -> f64 {
        let most = self.curvature_range(self.face.bounds()).high;
        // A plane seen from its other side has the curvature -0, whose reciprocal is negative.
        if most > 0.0 { most.recip() } else { f64::INFINITY }
    }

    /// Returns side, normal and distance for parameters found.
    fn foot(
        &self,
        uv: [f64; 2],
        jet: SurfaceJet2,
        p: &Point3<f64>,
    ) -> Result<FootPoint, ClosestError> {
        let offset = p - jet.s;
        let size = offset.norm();
        let normal = jet
            .normal()
            // At a pole: the limit on the way to the middle of the face.
            .or_else(|| jet.normal_towards(self.face.inwards(uv[0], uv[1])))
            .map(|n| if self.face.flip { -n } else { n })
            .ok_or(ClosestError::NoNormal { uv: uv.into(), distance: size })?;
        let distance = if offset.dot(&normal) < 0.0 { -size } else { size };
        Ok(FootPoint { uv: uv.into(), point: jet.s, normal, distance, jet })
    }
}

impl FacePart {
    /// Prepares the part; `None` for an elementary surface.
    fn of(face: &Face) -> Result<Option<Self>, SurfaceErrors> {
        let bounds = face.bounds();
        let over = |surface: &NurbsSurface, bounds: ParameterBox| {
            let tree = PatchTree::new(surface, bounds);
            Self { converted: None, tree, hulls: HullTree::new(surface, bounds) }
        };
        let converted = |NurbsConversion { surface, .. }: NurbsConversion| {
            let part = over(&surface, surface.domain());
            Self { converted: Some(Box::new(surface)), ..part }
        };
        match &face.surface {
            Surface::Nurbs(surface) => {
                let domain = surface.domain();
                let bounds = [0, 1].map(|k| within(bounds[k], domain[k]));
                Ok(Some(over(surface, bounds)))
            }
            Surface::Extrusion(surface) => surface.to_nurbs(bounds).map(converted).map(Some),
            Surface::Revolution(surface) => surface.to_nurbs(bounds).map(converted).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns the surface of the pieces: its own, or that of the face.
    fn surface<'a>(&'a self, own: &'a Surface) -> Option<&'a NurbsSurface> {
        match (&self.converted, own) {
            (Some(converted), _) => Some(converted),
            (None, Surface::Nurbs(surface)) => Some(surface),
            _ => None,
        }
    }
}

impl ClosestSearch {
    fn over(converted: NurbsConversion) -> Self {
        let tree = PatchTree::new(&converted.surface, converted.surface.domain());
        Self::Converted(Box::new(converted), tree)
    }
}

/// Returns the curvature of a strip for all of a sweep.
fn thin_strip(strip: NurbsConversion, across: usize) -> CurvatureSource {
    CurvatureSource::Thin { across, strip: Box::new(strip), pieces: CurvaturePieces::default() }
}

/// Returns a range of parameters within a domain. A range beyond the seam of a closed surface counts as all the way
/// round.
fn within(range: Interval, domain: Interval) -> Interval {
    // Trims that begin at the seam begin a rounding before it.
    let whole = domain.widened(SEAM * domain.width());
    if range.low < whole.low || range.high > whole.high {
        return domain;
    }
    range.intersection(domain)
}

/// Returns the middle and radius of a ball that holds all feet.
fn ball_round<'a>(feet: impl Iterator<Item = &'a FootPoint> + Clone) -> (Point3<f64>, f64) {
    // About the middle of the box of the feet: not the smallest ball, but cheap, and it holds all.
    let empty = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    let [low, high] = feet.clone().fold(empty, |[low, high], foot| {
        [low.inf(&foot.point.coords), high.sup(&foot.point.coords)]
    });
    let middle = Point3::from(0.5 * (low + high));
    let far = feet.map(|foot| (foot.point - middle).norm()).fold(0.0, f64::max);
    (middle, far)
}

/// Moves parameters by whole periods next to a guess.
fn on_turn(uv: [f64; 2], guess: [f64; 2], periods: [Option<f64>; 2]) -> [f64; 2] {
    [0, 1].map(|k| match periods[k] {
        Some(period) if guess[k].is_finite() => {
            uv[k] + period * ((guess[k] - uv[k]) / period).round()
        }
        _ => uv[k],
    })
}

/// Returns the domain; where it is endless, the box of the trims.
fn search_bounds(face: &Face) -> ParameterBox {
    let (domain, trims) = (face.surface.domain(), face.bounds());
    [0, 1].map(|k| if domain[k].is_bounded() { domain[k] } else { trims[k] })
}

impl std::ops::Deref for FaceIndex {
    type Target = Face;

    fn deref(&self) -> &Face {
        &self.face
    }
}
