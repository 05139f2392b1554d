//! Plans the passes of all faces.

use super::cost::{LengthCost, PassCost};
use super::error::{CoverError, FacePoint};
use super::options::CoverOptions;
use super::place::context::{FaceRequest, PartSetup};
use super::place::face::cover_face;
use super::place::leftover::cover_leftover;
use super::place::progress::FacesProgress;
use super::place::without::left_by;
use super::prove::part_faces::PartFaces;
use super::report::{CoverReport, Covering, RefusedPoint};
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Pass, Progress, Silent, UncutRegion};
use rayon::prelude::*;
use std::fmt;

/// Faces to cover, with tool, options and cost model. Begin with [`CoverRequest::new`] and change the rest by struct
/// update.
#[derive(Clone, Copy)]
pub struct CoverRequest<'a> {
    /// Faces that are cut.
    pub faces: &'a [FaceIndex],
    /// Faces of the part that are not cut. The tool keeps off them.
    pub others: &'a [FaceIndex],
    /// Cutter with shank and holder.
    pub cutter: &'a Cutter,
    /// Options of the passes.
    pub options: &'a CoverOptions,
    /// Area that operations before have left; `None`: all of the faces.
    pub left: Option<LeftArea<'a>>,
    /// Cost of passes and links on a machine; `None` counts lengths ([`LengthCost`]).
    pub cost: Option<&'a dyn PassCost>,
}

/// Area that operations before have left.
#[derive(Debug, Clone, Copy)]
pub struct LeftArea<'a> {
    /// Numbers of the faces that were cut before; all others are cut whole.
    pub cut: &'a [usize],
    /// Regions of these faces that are left.
    pub regions: &'a [UncutRegion],
}

impl fmt::Debug for CoverRequest<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { faces, others, cutter, options, .. } = self;
        f.debug_struct("CoverRequest")
            .field("faces", &faces.len())
            .field("others", &others.len())
            .field("cutter", cutter)
            .field("options", options)
            .finish_non_exhaustive()
    }
}

impl<'a> CoverRequest<'a> {
    /// Requests passes over `faces` alone, by length.
    pub fn new(faces: &'a [FaceIndex], cutter: &'a Cutter, options: &'a CoverOptions) -> Self {
        Self { faces, others: &[], cutter, options, left: None, cost: None }
    }
}

/// Plans passes over the faces of `request`, face after face, in cutting order.
///
/// With [`CoverRequest::left`], passes are limited to what an operation before has left: a smaller cutter finishes
/// corners and fillets. The report then is about that area alone.
///
/// Every point of a face inside its trims comes to lie in a strip. At the stations the error keeps
/// [`CoverOptions::band`]. On the curve that `toolpath::through` lays through them (with [`lever`](super::lever)) it
/// leaves the band by at most [`CoverOptions::path_share`], proven over all of the curve and the face. The
/// [`CoverReport`](super::CoverReport) lists the regions that no pass finishes.
///
/// The tool keeps off [`CoverRequest::others`], and off each face while another is cut, as it does off the face
/// itself: by the lower end of the band at the stations, and by [`CoverOptions::path_share`] less between them. This is
/// proven for all of the tool up to the gauge point.
///
/// # Errors
///
/// [`CoverError`] with face and point; [`CoverError::Cancelled`] on request.
///
/// # Source
///
/// Placing each pass from the end points of the one before: `docs/sources.md#004`, covering a face.
///
/// # Example
///
/// A ball of radius 5 mm leaves cusps of 0.1 mm on a plane between strips of sqrt(8 * 5 * 0.1) = 2 mm, so a
/// plane of 20 mm takes ten passes at least.
///
/// ```
/// use nalgebra::Point3;
/// use trunnion::cover::{CoverOptions, CoverRequest, FeedDirection, FinishTolerance, PlacementMethod, cover};
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
/// use trunnion::types::Silent;
///
/// let points = [0.0, 20.0].map(|x| [0.0, 20.0].map(|y| Point3::new(x, y, 0.0)).to_vec()).to_vec();
/// let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
/// let plane = Surface::Nurbs(NurbsSurface::new([1, 1], knots, points, None)?);
/// let faces = [FaceIndex::new(Face::new(1, plane, Vec::new())?)?];
///
/// let spec = CutterSpec { length: 60.0, ..CutterSpec::ball(10.0) };
/// let cutter = Cutter::new(spec).expect("a ball of radius 5 mm");
/// let options = CoverOptions {
///     feed_direction: FeedDirection::U,
///     method: PlacementMethod::Inclined,
///     ..CoverOptions::finishing(&cutter, FinishTolerance { excess: 0.1, gouge: 0.01 })
/// };
///
/// let covering = cover(&CoverRequest::new(&faces, &cutter, &options), &Silent)?;
/// assert!(covering.report.rest.is_empty(), "all of the plane is finished");
/// assert!((10..=13).contains(&covering.passes.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cover(request: &CoverRequest<'_>, progress: &dyn Progress) -> Result<Covering, CoverError> {
    let CoverRequest { faces, others, cutter, options, left, cost } = *request;
    options.check()?;
    let by_length = LengthCost { link: options.link };
    let cost: &dyn PassCost = cost.unwrap_or(&by_length);
    let part_faces = PartFaces::new(faces.iter().chain(others), cutter);
    let progress = FacesProgress::new(progress, faces.len());
    let covered: Vec<_> = faces
        .par_iter()
        .enumerate()
        .map(|(own, face)| -> Result<Covering, CoverError> {
            let number = face.face().number;
            let setup = PartSetup { cutter, part_faces: &part_faces, own, cost };
            let progress = progress.face(own, number);
            let request = FaceRequest { face, setup, options, progress };
            let placed = match left.filter(|left| left.cut.contains(&number)) {
                None => cover_face(&request)?,
                Some(LeftArea { regions, .. }) => {
                    let parts: Vec<_> = regions.iter().filter(|part| part.face == number).collect();
                    if parts.is_empty() {
                        return Ok(Covering::default());
                    }
                    cover_leftover(&request, &parts)?
                }
            };
            progress.show(&placed);
            Ok(placed.covering())
        })
        .collect();
    // Faces are collected in their own order, so that threads decide nothing.
    let mut all = Covering::default();
    let mut refused = None;
    for of_face in covered {
        let Covering { passes, report } = of_face?;
        all.passes.extend(passes);
        refused = refused.or_else(|| report.refused.clone());
        all.report.add(report);
    }
    match refused {
        Some(RefusedPoint { face: number, uv, error })
            if all.passes.is_empty() && left.is_none() =>
        {
            let face = faces.iter().find(|face| face.face().number == number);
            let at = face.map(|face| Box::new(FacePoint::new(face, uv)));
            at.map_or(Ok(all), |at| Err(CoverError::NoPose { face: number, at, error }))
        }
        _ => Ok(all),
    }
}

/// Takes some passes out of the result of `request`, by their indices, and measures anew what is left of their faces.
///
/// For passes that cannot be joined to the others ([`join`](super::join())).
pub fn without(request: &CoverRequest<'_>, covering: Covering, indices: &[usize]) -> Covering {
    let CoverRequest { faces, others, cutter, options, left, cost } = *request;
    let by_length = LengthCost { link: options.link };
    let cost: &dyn PassCost = cost.unwrap_or(&by_length);
    let part_faces = PartFaces::new(faces.iter().chain(others), cutter);
    let progress = FacesProgress::new(&Silent, faces.len());
    let Covering { passes, mut report } = covering;
    let (mut kept, mut lost): (Vec<Pass>, Vec<Pass>) = (Vec::new(), Vec::new());
    for (index, pass) in passes.into_iter().enumerate() {
        if indices.contains(&index) { lost.push(pass) } else { kept.push(pass) }
    }
    let loses = |number: usize| lost.iter().any(|pass| pass.face == number);
    let measured: Vec<CoverReport> = faces
        .par_iter()
        .enumerate()
        .filter(|(_, face)| loses(face.face().number))
        .map(|(own, face)| {
            let number = face.face().number;
            let setup = PartSetup { cutter, part_faces: &part_faces, own, cost };
            let request =
                FaceRequest { face, setup, options, progress: progress.face(own, number) };
            let of_face: Vec<&Pass> = kept.iter().filter(|pass| pass.face == number).collect();
            let parts = left.filter(|left| left.cut.contains(&number)).map(|left| {
                left.regions.iter().filter(|part| part.face == number).collect::<Vec<_>>()
            });
            left_by(&request, &of_face, parts.as_deref()).report
        })
        .collect();
    report.rest.retain(|part| !loses(part.face));
    report.rest.extend(measured.into_iter().flat_map(|of_face| of_face.rest));
    for pass in &lost {
        report.stations -= pass.stations.len();
        report.length -= by_length.pass(&pass.stations);
        report.cost -= cost.pass(&pass.stations) * cost.feed();
    }
    Covering { passes: kept, report }
}
