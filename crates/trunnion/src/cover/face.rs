//! All passes over one face.

use super::options::{Along, CoverError, CoverOptions, Covering};
use super::plan;
use super::region::{Local, Region};
use super::site::{Report, Site};
use super::state::price;
use crate::cutter::Cutter;
use crate::positioning::ContactSide;
use crate::surface::FaceIndex;

/// Trim loops are followed to this share of the face's extent in u and in v. Passes run on the cutter's
/// radius beyond, and their strips begin at a border and end beyond it.
const LOOP_SHARE: f64 = 1e-4;

/// All passes over one face. Where either side of the cutter may cut, that which takes less over
/// the whole face: passes that change sides from place to place would have to turn the tool over.
pub(super) fn cover(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
    report: Report<'_>,
) -> Result<Covering, CoverError> {
    if options.side != ContactSide::Either {
        return on_side(face, cutter, options, report);
    }
    let half = |side: ContactSide, from: f64| {
        let sided = CoverOptions { side, ..*options };
        on_side(face, cutter, &sided, &|share| report(from + 0.5 * share))
    };
    let (ahead, behind) = (half(ContactSide::Ahead, 0.0), half(ContactSide::Behind, 0.5));
    let price = |done: &Covering| price(done, options);
    let better = |a: &Covering, b: &Covering| {
        a.report.missed.cmp(&b.report.missed).then(price(a).total_cmp(&price(b))).is_lt()
    };
    match (ahead, behind) {
        (Ok(ahead), Ok(behind)) => Ok(if better(&behind, &ahead) { behind } else { ahead }),
        (_, Err(CoverError::Cancelled(cancelled))) => Err(cancelled.into()),
        (Err(_), Ok(behind)) => Ok(behind),
        (ahead, _) => ahead,
    }
}

fn on_side(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
    report: Report<'_>,
) -> Result<Covering, CoverError> {
    let crossed = CoverOptions { along: options.along.other(), ..*options };
    let (whole, turned) = (region(face, options.along), region(face, crossed.along));
    let site = Site::new((face, &whole), cutter, options, report);
    let cross = Site::new((face, &turned), cutter, &crossed, report);
    let mut state = plan::best([&site, &cross])?;
    site.audit(&mut state);
    report(1.0)?;
    Ok(state.covering())
}

/// The trimmed region in local parameters; loops on periodic surfaces also a period further on
/// either side, so that every line across the face meets them.
pub(super) fn region(face: &FaceIndex, along: Along) -> Region<impl Fn(Local) -> bool + Sync> {
    let face = face.face();
    let [u, v] = face.bounds();
    let tolerance = [u, v].map(|range| LOOP_SHARE * (range[1] - range[0]));
    let shifts = |period: Option<f64>| match period {
        Some(period) => vec![-period, 0.0, period],
        None => vec![0.0],
    };
    let [pu, pv] = face.surface.periods();
    let mut loops = Vec::new();
    for points in face.loops.iter().map(|trim| trim.polyline(tolerance)) {
        for du in shifts(pu) {
            for dv in shifts(pv) {
                loops.push(points.iter().map(|p| along.local([p[0] + du, p[1] + dv])).collect());
            }
        }
    }
    let bounds = match along {
        Along::U => [v, u],
        Along::V => [u, v],
    };
    Region::new(bounds, loops, move |local| {
        let [u, v] = along.uv(local);
        face.contains(u, v)
    })
}
