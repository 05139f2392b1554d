//! Regions of the faces in words and numbers: where wide strips did not fit, and what stays unfinished.

use super::guards::with_fixture_names;
use super::job::Job;
use super::leftover::Leftover;
use super::origin_advice::origin_in_reach;
use super::wording::{counted, reason};
use crate::cover::{Covering, PassFallback};
use crate::files::summary::{RegionSummary, RestSummary};
use crate::import::inspect::{AreaElement, elements};
use crate::surface::{Face, FaceIndex};
use crate::types::UncutRegion;

/// Most regions that are listed in words.
const MOST_LISTED: usize = 5;

/// Bounds of u and v.
type ParameterBounds = [[f64; 2]; 2];

/// Region joined from parts that touch.
struct JoinedRegion {
    face: usize,
    parts: Vec<ParameterBounds>,
    why: String,
}

/// Returns the regions in which wide strips did not fit, the largest first.
pub(super) fn summaries(faces: &[FaceIndex], covering: &Covering) -> Vec<RegionSummary> {
    let mut joined: Vec<JoinedRegion> = Vec::new();
    for PassFallback { face, u, v, reason: why, .. } in &covering.report.fallbacks {
        join(
            &mut joined,
            JoinedRegion { face: *face, parts: vec![[u.ends(), v.ends()]], why: reason(why) },
        );
    }
    let all = covering.report.area.max(f64::MIN_POSITIVE);
    let summary = |JoinedRegion { face, parts, why }: JoinedRegion| {
        let of = faces.iter().find(|one| one.face().number == face);
        let area = of.map_or(0.0, |of| area(of.face(), &parts));
        RegionSummary { face, uv: hull(&parts), area, share: area / all, why }
    };
    let mut regions: Vec<RegionSummary> = joined.into_iter().map(summary).collect();
    regions.sort_by(|a, b| b.area.total_cmp(&a.area));
    regions
}

/// Returns the area of a face inside any of the bounds, which may overlap \[mm²\].
fn area(face: &Face, parts: &[ParameterBounds]) -> f64 {
    let within = |element: &AreaElement| {
        let holds = |part: &ParameterBounds| {
            let uv: [f64; 2] = element.uv.into();
            uv.iter().zip(part).all(|(at, [low, high])| low <= at && at <= high)
        };
        parts.iter().any(holds)
    };
    // An element counts once, however many of the bounds hold its point.
    elements(face).iter().filter(|one| within(one)).map(|one| one.area.norm()).sum()
}

fn hull(parts: &[ParameterBounds]) -> ParameterBounds {
    [0, 1].map(|k| {
        let low = parts.iter().map(|part| part[k][0]).fold(f64::INFINITY, f64::min);
        let high = parts.iter().map(|part| part[k][1]).fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    })
}

/// Joins a region to those it touches; the reason of the first stays.
fn join(regions: &mut Vec<JoinedRegion>, mut new: JoinedRegion) {
    let over = |a: &ParameterBounds, b: &ParameterBounds| {
        (0..2).all(|k| a[k][0] <= b[k][1] && b[k][0] <= a[k][1])
    };
    let touch = |a: &JoinedRegion, b: &JoinedRegion| {
        a.face == b.face && a.parts.iter().any(|a| b.parts.iter().any(|b| over(a, b)))
    };
    // A joined region may touch others that the parts did not: repeat until nothing touches.
    while let Some(index) = regions.iter().position(|old| touch(old, &new)) {
        let mut old = regions.swap_remove(index);
        old.parts.append(&mut new.parts);
        new = old;
    }
    regions.push(new);
}

/// Warns about regions that are finished at a fixed inclination.
pub(super) fn fixed(faces: &[FaceIndex], covering: &Covering) -> Option<String> {
    let regions = summaries(faces, covering);
    let first = regions.first()?;
    let area: f64 = regions.iter().map(|region| region.area).sum();
    let all = covering.report.area.max(f64::MIN_POSITIVE);
    let [[a, b], [c, d]] = first.uv;
    Some(format!(
        "wide strips do not fit in {} ({area:.1} mm2, {:.1} % of the faces), finished at a fixed inclination; the largest \
         is on face {} at u {a:.4}..{b:.4}, v {c:.4}..{d:.4}: {}",
        counted(regions.len(), "region"),
        100.0 * area / all,
        first.face,
        first.why
    ))
}

/// Returns the summary of an uncut region.
pub(super) fn rest(job: &Job, rest: &UncutRegion) -> RestSummary {
    RestSummary {
        face: rest.face,
        area: rest.area,
        uv: rest.uv.map(Into::into),
        bounds: rest.bounds.map(|corner| corner.coords.into()),
        depth: rest.depth,
        deepest: rest.point.coords.into(),
        ball: Some(rest.ball).filter(|radius| radius.is_finite()),
        least_ball: Some(rest.balls.low).filter(|radius| radius.is_finite()),
        why: with_fixture_names(job, &rest.reason.to_string()),
    }
}

/// Reports the uncut regions, one sentence each; of many, the smaller ones together.
pub(super) fn unfinished(job: &Job, left: &Leftover) -> Vec<String> {
    let mut parts: Vec<&UncutRegion> = left.regions.iter().collect();
    parts.sort_by(|a, b| b.area.total_cmp(&a.area));
    let all = left.area().max(f64::MIN_POSITIVE);
    let mut lines: Vec<String> =
        parts.iter().take(MOST_LISTED).map(|rest| part(job, rest, all)).collect();
    let others = parts.get(MOST_LISTED..).unwrap_or_default();
    if !others.is_empty() {
        let area: f64 = others.iter().map(|rest| rest.area).sum();
        lines.push(format!(
            "rest: {} of {area:.3} mm2 together",
            counted(others.len(), "smaller part")
        ));
    }
    if let Some(origin) = origin_in_reach(job, &left.regions) {
        let [x, y, z]: [f64; 3] = origin.into();
        lines.push(format!(
            "rest: linear axes reach the ends of their travel; setup.origin = [{x:.1}, {y:.1}, {z:.1}] keeps all faces inside"
        ));
    }
    let cutters = job.operations().map(|one| &one.cutter);
    let finest = cutters.min_by(|a, b| a.minor().total_cmp(&b.minor()));
    if let Some(finest) = finest.filter(|finest| finest.minor() > 0.0 && !lines.is_empty()) {
        // A lens has a small corner, too, but it cuts with the large arc at its tip.
        let arc = if finest.tangent_profile().is_some() { "tip arc" } else { "corner" };
        let smallest = finest.minor();
        let share = parts.iter().map(|rest| rest.area).sum::<f64>() / all;
        lines.push(format!(
            "rest: the cutter, with a {arc} of {smallest} mm, finishes {:.2} % of the faces; a smaller one in a further \
             [[operation]] with method = \"rest\", or another setup, finishes more",
            100.0 * (1.0 - share).max(0.0)
        ));
    }
    lines
}

fn part(job: &Job, rest: &UncutRegion, all: f64) -> String {
    let [[a, b], [c, d]] = rest.uv.map(<[f64; 2]>::from);
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
        with_fixture_names(job, &rest.reason.to_string())
    )
}

/// Warns about faces that the tool cannot be kept off.
pub(super) fn unguarded(job: &Job) -> Vec<String> {
    let lines = |(face, error): &(usize, crate::surface::SurfaceError)| {
        format!("face {face} cannot be worked with, so nothing keeps the tool off it: {error}")
    };
    job.unguarded.iter().map(lines).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{SphereSurface, Surface, SurfaceFrame};
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::PI;

    #[test]
    fn regions_that_touch_are_one() {
        let region = |low: f64, face: usize| JoinedRegion {
            face,
            parts: vec![[[low, low + 1.0], [0.0, 1.0]]],
            why: String::new(),
        };
        let mut regions = Vec::new();
        for (low, face) in [(0.0, 1), (2.0, 1), (0.5, 2), (1.0, 1)] {
            join(&mut regions, region(low, face));
        }
        let found: Vec<_> =
            regions.iter().map(|r| (r.face, hull(&r.parts)[0], r.parts.len())).collect();
        assert_eq!(found, [(2, [0.5, 1.5], 1), (1, [0.0, 3.0], 3)]);
    }

    /// Ranges that overlap count once: a quarter of a sphere and half of that again.
    #[test]
    fn what_overlaps_is_measured_once() {
        let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
        let sphere = Surface::Sphere(SphereSurface::new(frame, 10.0).unwrap());
        let face = Face::new(1, sphere, Vec::new()).unwrap();
        let parts = [[[0.0, 0.5 * PI], [-0.5 * PI, 0.5 * PI]], [[0.0, 0.25 * PI], [-1.0, 1.0]]];
        let quarter = 100.0 * PI;
        assert!((area(&face, &parts) / quarter - 1.0).abs() < 0.03, "{}", area(&face, &parts));
    }
}
