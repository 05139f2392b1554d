//! Passes that no lead connects with the others are left out, and what they leave is measured.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Unit, Vector3};
use trunnion::cover::{
    CoverOptions, CoverRequest, FeedDirection, FinishTolerance, LinkOptions, LinkRequest,
    PlacementMethod, cover, join, legs, without,
};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::{Leg, Motion, Pass, Silent, Station, ToolPose, Uv};

/// A cubic patch over rows of four points.
fn patch(rows: Vec<Vec<Point3<f64>>>) -> FaceIndex {
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let surface = NurbsSurface::new([3, 3], [knots(), knots()], rows, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
}

/// A floor with a wall 12 mm high at x = 24, y in 0..30.
fn walled() -> FaceIndex {
    let profile = [[0.0, 0.0], [18.0, 0.0], [24.0, 0.0], [24.0, 12.0]];
    let row =
        |[x, z]: &[f64; 2]| (0..4).map(|j| Point3::new(*x, 10.0 * f64::from(j), *z)).collect();
    patch(profile.iter().map(row).collect())
}

/// A pass over the floor at `x`, with its tip 8 mm above it.
fn upright(x: f64) -> Pass {
    let at = |y: f64| {
        let pose = ToolPose { tip: Point3::new(x, y, 8.0), axis: Vector3::z_axis() };
        Station { pose, contact: Point3::new(x, y, 0.0) }
    };
    let stations = vec![at(10.0), at(20.0)];
    Pass { face: 1, stations, widths: vec![1.0; 2], track: vec![Uv::new(0.0, 0.0); 2] }
}

#[test]
fn a_pass_without_a_lead_does_not_end_the_others() {
    let faces = [walled()];
    let cutter = Cutter::new(CutterSpec { length: 8.0, ..CutterSpec::bull(4.0, 3.0) }).unwrap();
    let boxes = vec![[Point3::origin(), Point3::new(24.0, 30.0, 12.0)]];
    let link = LinkOptions { gouge: 0.01, ..LinkOptions::above(Vector3::z_axis(), boxes, 3.0) };
    // The tool of the second and of the last stands in the wall.
    let all = [0.0, 22.0, 6.0, 22.5].map(upright);
    let joined = join(&LinkRequest::new(&all, &faces, &cutter, &link), &Silent).unwrap();
    let out: Vec<usize> = joined.left_out.iter().map(|one| one.index).collect();
    assert_eq!(out, [1, 3]);
    let kept = [0.0, 6.0].map(upright);
    let alone = legs(&LinkRequest::new(&kept, &faces, &cutter, &link), &Silent).unwrap();
    assert_eq!(joined.legs, alone);
    let cuts = |legs: &[Leg]| legs.iter().filter(|leg| leg.motion == Motion::Cut).count();
    assert_eq!(cuts(&joined.legs), 2);
}

/// A lead from a pass that keeps just the distance that leads have to.
#[test]
fn a_pass_at_the_end_of_the_tolerance_has_a_lead() {
    const KEPT: f64 = 5e-4;
    let heights = [
        [0.0, -4.0, -4.0, 0.0],
        [2.0, -1.0, -1.0, 2.0],
        [2.0, -1.0, -1.0, 2.0],
        [0.0, -4.0, -4.0, 0.0],
    ];
    let row = |i: usize| {
        let point = |j: usize| Point3::new(10.0 * i as f64, 10.0 * j as f64, heights[i][j]);
        (0..4).map(point).collect()
    };
    let faces = [patch((0..4).map(row).collect())];
    let cutter = Cutter::new(CutterSpec { length: 40.0, ..CutterSpec::ball(8.0) }).unwrap();
    let at = |v: f64| {
        let (contact, normal) =
            (faces[0].face().point(0.5, v), faces[0].face().normal(0.5, v).unwrap());
        let axis = Unit::new_normalize(Vector3::new(0.2, 0.1, 1.0));
        let centre = contact + normal.scale(cutter.radius() + KEPT + 1e-7);
        let tip = centre - axis.scale(cutter.radius());
        Station { pose: ToolPose { tip, axis }, contact }
    };
    let stations = vec![at(0.4), at(0.45), at(0.5)];
    let track = vec![Uv::new(0.5, 0.4); 3];
    let passes = [Pass { face: 1, stations, widths: vec![1.0; 3], track }];
    let boxes = vec![[Point3::new(0.0, 0.0, -4.0), Point3::new(30.0, 30.0, 3.0)]];
    let above = LinkOptions::above(Vector3::z_axis(), boxes, 3.0);
    for (gouge, fits) in [(-KEPT, true), (-1.1 * KEPT, false)] {
        let link = LinkOptions { gouge, ..above.clone() };
        let joined = legs(&LinkRequest::new(&passes, &faces, &cutter, &link), &Silent);
        assert_eq!(joined.is_ok(), fits, "{gouge}: {joined:?}");
    }
}

/// A ball over a plane: strips of 2 mm between cusps of 0.1 mm.
#[test]
fn what_a_pass_that_is_left_out_would_finish_is_left() {
    let rows = (0..4).map(|i| {
        (0..4).map(|j| Point3::new(8.0 * f64::from(i), 8.0 * f64::from(j), 0.0)).collect()
    });
    let faces = [patch(rows.collect())];
    let cutter = Cutter::new(CutterSpec { length: 60.0, ..CutterSpec::ball(10.0) }).unwrap();
    let options = CoverOptions {
        feed_direction: FeedDirection::U,
        method: PlacementMethod::Inclined,
        ..CoverOptions::finishing(&cutter, FinishTolerance { excess: 0.1, gouge: 0.01 })
    };
    let request = CoverRequest::new(&faces, &cutter, &options);
    let whole = cover(&request, &Silent).unwrap();
    assert!(whole.report.rest.is_empty());
    let same = without(&request, whole.clone(), &[]);
    assert_eq!(same, whole);
    let (count, length) = (whole.passes.len(), whole.report.length);
    let lost = whole.passes[4].clone();
    let less = without(&request, whole, &[4]);
    assert_eq!(less.passes.len(), count - 1);
    assert!(less.report.length < length - 20.0);
    let [rest] = less.report.rest.as_slice() else { panic!("{:?}", less.report.rest) };
    // A strip less what its neighbours finish of it, and the width of a cell at its rims.
    let width = rest.area / 24.0;
    assert!((1.2..2.4).contains(&width), "{width}");
    let middle = &lost.stations[lost.stations.len() / 2].contact;
    assert!((0..2).all(|k| (rest.bounds[0][k]..=rest.bounds[1][k]).contains(&middle[k])));
    // What stays between two passes is as high as the cusp of a strip twice as wide.
    assert!((0.2..0.5).contains(&rest.depth), "{}", rest.depth);
}
