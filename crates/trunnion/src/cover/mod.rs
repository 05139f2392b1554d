//! Passes over faces: where strips lie, lead-in, lead-out, links.
//!
//! [`cover`] lays passes along end-point tracks over each face, iso-parametric or bent to where strips
//! are wide (`chart`, `guide`), so that the strips of neighbouring passes meet; [`legs`] joins them to one program of motions.
//!
//! A strip begins at the track (the first end points, where the error equals the upper end of the
//! band) and ends at the far track (the second end points), which is no line of the chart. The next
//! track lies as far on as is worth it (`split`): what a pass leaves narrower, and places where it
//! has to be lifted, get passes of their own. Passes begin and end where their strips are off
//! what they cut, on the continued surface.
//!
//! Where no wide strip fits the tool is placed at the fixed lean, and where it would touch another face then (`guard`), at
//! one of other leans (`leans`) or as near as it may come. What it still does not finish is told (`rest`), with the
//! largest ball that fits there (`fit`).
//!
//! What the curves through the stations do to the face is not sampled but bounded: how near the tool
//! comes (`clear`) and which cells are finished (`left`), both from the convexity of the tool
//! (`cutter::solid`).

mod around;
mod between;
mod beyond;
mod chart;
mod clear;
mod clock;
mod face;
mod field;
mod fit;
mod guard;
mod guide;
mod held;
mod hop;
mod lane;
mod leans;
mod left;
mod legs;
mod options;
mod pulled;
mod region;
mod rest;
mod runout;
mod settle;
mod sheet;
mod site;
mod split;
mod state;
mod stretch;
mod sweep;
mod task;
mod track;
mod turns;
mod work;

pub(crate) use around::height;
pub use clock::{Clock, Length};
pub use hop::Hops;
pub use legs::{LeadKind, LinkOptions, Ways, legs};
pub use options::{
    Along, CoverError, CoverOptions, CoverReport, Covering, Direction, Fallback, FallbackReason,
    Method, Place, Way, lever,
};
pub use turns::Turns;

use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Cancelled, Progress, Stage};
use guard::Guards;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of progress a face is worth.
const STEPS: u64 = 1000;

/// Passes over `faces`, face after face, in cutting order.
///
/// Every place of a face inside its trims comes to lie in a strip: at the stations the error keeps
/// `options.band`, and on the curve that `toolpath::through` lays through them (with [`lever`]) it
/// leaves the band by at most `options.path_share`, proven over all of the curve and the face; what no
/// pass finishes is counted in the [`CoverReport`].
///
/// # Errors
///
/// [`CoverError`] with face and place; [`CoverError::Cancelled`] on request.
///
/// # Source
///
/// Placing each pass from the end points of the one before: `docs/sources.md#004`, covering a face.
pub fn cover(
    faces: &[FaceIndex],
    cutter: &Cutter,
    options: &CoverOptions,
    progress: &dyn Progress,
) -> Result<Covering, CoverError> {
    cover_by(faces, cutter, options, (&Length { link: options.link }, progress))
}

/// As [`cover`], by what passes and links take on a machine.
///
/// # Errors
///
/// As [`cover`].
pub fn cover_by(
    faces: &[FaceIndex],
    cutter: &Cutter,
    options: &CoverOptions,
    by: (&dyn Clock, &dyn Progress),
) -> Result<Covering, CoverError> {
    cover_beside((faces, &[]), cutter, options, by)
}

/// As [`cover_by`], on a part with `others`: faces that are not cut. The tool keeps off them, and off each face while
/// another is cut, as it does off the face itself: the lower end of the band at the stations, and `options.path_share`
/// less between them, proven for all of the tool up to the gauge point.
///
/// # Errors
///
/// [`CoverError`] with face and place; [`CoverError::Cancelled`] on request.
pub fn cover_beside(
    (faces, others): (&[FaceIndex], &[FaceIndex]),
    cutter: &Cutter,
    options: &CoverOptions,
    (clock, progress): (&dyn Clock, &dyn Progress),
) -> Result<Covering, CoverError> {
    options.check()?;
    let guards = Guards::new(faces.iter().chain(others), cutter);
    let done: Vec<AtomicU64> = faces.iter().map(|_| AtomicU64::new(0)).collect();
    let total = STEPS * faces.len() as u64;
    let covered: Vec<_> = faces
        .par_iter()
        .zip(&done)
        .enumerate()
        .map(|(own, (face, mine))| {
            let report = |share: f64| -> Result<(), Cancelled> {
                // A share of 0..=1: the product is a small non-negative number.
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "see above"
                )]
                let steps = (share.clamp(0.0, 1.0) * STEPS as f64) as u64;
                mine.store(steps, Ordering::Relaxed);
                let sum = done.iter().map(|face| face.load(Ordering::Relaxed)).sum();
                progress.step(Stage::Cover, sum, total)
            };
            face::cover(face, (cutter, (&guards, own)), options, (clock, &report))
        })
        .collect();
    let mut all = Covering::default();
    let mut refused = None;
    for of_face in covered {
        let Covering { passes, report } = of_face?;
        all.passes.extend(passes);
        refused = refused.or_else(|| report.refused.clone());
        all.report.add(report);
    }
    match refused {
        Some((number, at, error)) if all.passes.is_empty() => {
            let face = faces.iter().find(|face| face.face().number == number);
            let at = face.map(|face| Box::new(Place::new(face, at)));
            at.map_or(Ok(all), |at| Err(CoverError::NoPose { face: number, at, error }))
        }
        _ => Ok(all),
    }
}
