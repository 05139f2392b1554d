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
//! What the curves through the stations do to the face is not sampled but bounded: how near the tool
//! comes (`clear`) and which cells are finished (`left`), both from the convexity of the tool
//! (`solid`).

mod around;
mod between;
mod chart;
mod clear;
mod clock;
mod face;
mod field;
mod guide;
mod hop;
mod lane;
mod left;
mod legs;
mod options;
mod region;
mod runout;
mod settle;
mod sheet;
mod site;
mod solid;
mod split;
mod state;
mod stretch;
mod sweep;
mod task;
mod track;
mod work;

pub(crate) use around::height;
pub use clock::{Clock, Length};
pub use hop::Hops;
pub use legs::{LeadKind, LinkOptions, legs};
pub use options::{
    Along, CoverError, CoverOptions, CoverReport, Covering, Direction, Fallback, FallbackReason,
    Method, Place, lever,
};

use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Cancelled, Progress, Stage};
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
    (clock, progress): (&dyn Clock, &dyn Progress),
) -> Result<Covering, CoverError> {
    options.check()?;
    let done: Vec<AtomicU64> = faces.iter().map(|_| AtomicU64::new(0)).collect();
    let total = STEPS * faces.len() as u64;
    let covered: Vec<_> = faces
        .par_iter()
        .zip(&done)
        .map(|(face, mine)| {
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
            face::cover(face, cutter, options, (clock, &report))
        })
        .collect();
    let mut all = Covering::default();
    for of_face in covered {
        let Covering { passes, report } = of_face?;
        all.passes.extend(passes);
        all.report.add(report);
    }
    Ok(all)
}
