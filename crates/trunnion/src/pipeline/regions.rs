//! Regions of the faces in words and numbers: where wide strips did not fit, and what stays unfinished.

use super::job::Job;
use super::summary::{counted, reason};
use crate::cover::{Covering, Fallback};
use crate::files::summary::{RegionSummary, RestSummary};
use crate::types::{Rest, RestReason};

/// Regions that are told at most, in words.
const TOLD: usize = 5;

/// Where wide strips did not fit, the largest first: what touches is one region.
pub(super) fn summaries(covering: &Covering) -> Vec<RegionSummary> {
    let mut regions: Vec<RegionSummary> = Vec::new();
    for fallback in &covering.report.fallbacks {
        add(&mut regions, region(fallback));
    }
    for region in &mut regions {
        // Passes of a region may overlap: it is no larger than the faces.
        region.share = (region.area / covering.report.area.max(f64::MIN_POSITIVE)).min(1.0);
    }
    regions.sort_by(|a, b| b.area.total_cmp(&a.area));
    regions
}

fn region(fallback: &Fallback) -> RegionSummary {
    let Fallback { face, uv, area, .. } = *fallback;
    RegionSummary { face, uv, area, share: 0.0, why: reason(&fallback.reason) }
}

/// Joins a region to those it touches; the reason of the first stays.
fn add(regions: &mut Vec<RegionSummary>, mut new: RegionSummary) {
    let touch = |a: &RegionSummary, b: &RegionSummary| {
        let over = |k: usize| a.uv[k][0] <= b.uv[k][1] && b.uv[k][0] <= a.uv[k][1];
        a.face == b.face && over(0) && over(1)
    };
    while let Some(index) = regions.iter().position(|old| touch(old, &new)) {
        let old = regions.swap_remove(index);
        let hull = |k: usize| [old.uv[k][0].min(new.uv[k][0]), old.uv[k][1].max(new.uv[k][1])];
        new = RegionSummary { uv: [hull(0), hull(1)], area: old.area + new.area, ..old };
    }
    regions.push(new);
}

/// What to know of regions at a fixed lean.
pub(super) fn fixed(covering: &Covering) -> Option<String> {
    let regions = summaries(covering);
    let first = regions.first()?;
    let area: f64 = regions.iter().map(|region| region.area).sum();
    let all = covering.report.area.max(f64::MIN_POSITIVE);
    let [[a, b], [c, d]] = first.uv;
    Some(format!(
        "wide strips do not fit in {} ({area:.1} mm2, {:.1} % of the faces), finished at a fixed lean; the largest \
         is on face {} at u {a:.4}..{b:.4}, v {c:.4}..{d:.4}: {}",
        counted(regions.len(), "region"),
        (100.0 * area / all).min(100.0),
        first.face,
        first.why
    ))
}

/// One part that stays unfinished.
pub(super) fn rest(rest: &Rest) -> RestSummary {
    RestSummary {
        face: rest.face,
        area: rest.area,
        uv: rest.uv,
        bounds: rest.bounds.map(|corner| corner.coords.into()),
        depth: rest.depth,
        deepest: rest.point.coords.into(),
        ball: Some(rest.ball).filter(|radius| radius.is_finite()),
        least_ball: Some(rest.balls[0]).filter(|radius| radius.is_finite()),
        why: why(rest.reason),
    }
}

fn why(reason: RestReason) -> String {
    match reason {
        RestReason::Hollow => "the face is hollow there, for the corner of the cutter".to_owned(),
        RestReason::Neighbour(face) => {
            format!("the corner of the cutter would go into face {face}")
        }
        RestReason::Tool(face) => {
            format!(
                "however it leans, the tool beside or above its corner would go into face {face}"
            )
        }
        RestReason::Machine => {
            "the tool fits there only where the machine does not get to: turn the setup".to_owned()
        }
        RestReason::Passes => "the tool fits there, but no pass gets to it".to_owned(),
    }
}

/// What stays unfinished, one sentence a part; the smaller ones of many together.
pub(super) fn unfinished(job: &Job, covering: &Covering) -> Vec<String> {
    let mut parts: Vec<&Rest> = covering.report.rest.iter().collect();
    parts.sort_by(|a, b| b.area.total_cmp(&a.area));
    let all = covering.report.area.max(f64::MIN_POSITIVE);
    let mut told: Vec<String> = parts.iter().take(TOLD).map(|rest| part(rest, all)).collect();
    let others = parts.get(TOLD..).unwrap_or_default();
    if !others.is_empty() {
        let area: f64 = others.iter().map(|rest| rest.area).sum();
        told.push(format!(
            "rest: {} of {area:.3} mm2 together",
            counted(others.len(), "smaller part")
        ));
    }
    if job.cutter.minor() > 0.0 && !told.is_empty() {
        told.push(format!(
            "rest: the cutter, with a corner of {} mm, finishes {:.2} % of the faces; a smaller one in a further job, \
             or another setup, finishes more",
            job.cutter.minor(),
            100.0 * (1.0 - parts.iter().map(|rest| rest.area).sum::<f64>() / all).max(0.0)
        ));
    }
    told
}

fn part(rest: &Rest, all: f64) -> String {
    let [[a, b], [c, d]] = rest.uv;
    let p = rest.point;
    let ball = if rest.ball.is_finite() {
        format!("the largest ball that fits there has a radius of {:.3} mm", rest.ball)
    } else {
        "far larger balls fit there".to_owned()
    };
    format!(
        "rest: {:.3} mm2 ({:.2} %) of face {} at u {a:.4}..{b:.4}, v {c:.4}..{d:.4} are not finished, up to {:.3} mm at \
         X {:.3} Y {:.3} Z {:.3}: {}; {ball}",
        rest.area,
        100.0 * rest.area / all,
        rest.face,
        rest.depth,
        p.x,
        p.y,
        p.z,
        why(rest.reason)
    )
}

/// Faces that cannot be kept off.
pub(super) fn unguarded(job: &Job) -> Vec<String> {
    let told = |(face, error): &(usize, crate::surface::SurfaceError)| {
        format!("face {face} cannot be worked with, so nothing keeps the tool off it: {error}")
    };
    job.unguarded.iter().map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_that_touch_are_one() {
        let region = |low: f64, face: usize| RegionSummary {
            face,
            uv: [[low, low + 1.0], [0.0, 1.0]],
            area: 1.0,
            share: 0.0,
            why: String::new(),
        };
        let mut regions = Vec::new();
        for (low, face) in [(0.0, 1), (2.0, 1), (0.5, 2), (1.0, 1)] {
            add(&mut regions, region(low, face));
        }
        let found: Vec<_> = regions.iter().map(|r| (r.face, r.uv[0], r.area)).collect();
        assert_eq!(found, [(2, [0.5, 1.5], 1.0), (1, [0.0, 3.0], 3.0)]);
    }
}
