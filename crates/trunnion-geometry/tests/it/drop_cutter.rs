//! Lowered cutters against dense samples of the triangles.

use crate::property;
use nalgebra::Point3;
use proptest::prelude::*;
use trunnion_geometry::cutter::{Cutter, CutterSpec, ProfilePiece, TangentProfile};
use trunnion_geometry::drop_cutter::{CuttingEnd, DropIndex};
use trunnion_geometry::types::Mesh;

/// Points of a triangle along each side.
const SAMPLES: u32 = 160;

/// The height of the outline over the tip at a distance from the axis, within the cutter's radius.
fn height(cutter: &Cutter, distance: f64) -> f64 {
    let reaches = |piece: &&ProfilePiece| distance <= piece.end()[0];
    match cutter.profile().iter().find(reaches) {
        Some(ProfilePiece::Arc { center, radius, .. }) => {
            let out = distance - center[0];
            center[1] - (radius * radius - out * out).max(0.0).sqrt()
        }
        Some(ProfilePiece::Line { from, to }) if to[0] > from[0] => {
            from[1] + (to[1] - from[1]) * (distance - from[0]) / (to[0] - from[0])
        }
        // On the rim, where the flank begins.
        _ => cutter.tangent_profile().map_or(cutter.minor(), TangentProfile::flank_start),
    }
}

/// The tip on points alone: a lower bound that dense samples bring close.
fn by_samples(corners: &[Point3<f64>; 3], cutter: &Cutter, place: [f64; 2]) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for i in 0..=SAMPLES {
        for j in 0..=SAMPLES - i {
            let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(SAMPLES));
            let point = corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t;
            let distance = (point.x - place[0]).hypot(point.y - place[1]);
            // No point is touched above its own height.
            if distance <= cutter.radius() && point.z > best {
                best = best.max(point.z - height(cutter, distance));
            }
        }
    }
    best
}

fn corner() -> impl Strategy<Value = Point3<f64>> {
    (-8.0..8.0, -8.0..8.0, -4.0..4.0).prop_map(|(x, y, z)| Point3::new(x, y, z))
}

fn cutters() -> impl Strategy<Value = Cutter> {
    let specs = prop_oneof![
        (0.5..6.0).prop_map(|r| CutterSpec::ball(2.0 * r)),
        (0.5..6.0).prop_map(|r| CutterSpec::flat(2.0 * r)),
        (0.2..5.0, 0.2..4.0).prop_map(|(major, minor)| CutterSpec::bull(major, minor)),
        (0.3..2.0, 0.1..1.2, 0.5..4.0).prop_map(|(r, angle, more)| CutterSpec::taper(
            r,
            angle,
            2.0 * (r + more)
        )),
        (0.3..2.0, 20.0..90.0, 0.5..4.0).prop_map(|(r, arc, more)| CutterSpec::barrel(
            r,
            arc,
            2.0 * (r + more)
        )),
        (0.3..2.0, 30.0..90.0, 0.1..0.8, 0.5..4.0).prop_map(|(r, arc, angle, more)| {
            CutterSpec::conical_barrel(r, arc, angle, 2.0 * (r + more))
        }),
        (12.0..40.0, 0.3..2.0, 0.5..4.0).prop_map(|(arc, r, more)| CutterSpec::lens(
            arc,
            r,
            2.0 * (r + more)
        )),
    ];
    let made = |spec| Cutter::new(CutterSpec { length: 300.0, ..spec }).ok();
    specs.prop_filter_map("a side that joins the tip arc to the diameter", made)
}

proptest! {
    #![proptest_config(property::cases(400))]

    /// No sample is higher than the contact, and a dense sample comes close to it.
    #[test]
    fn a_triangle_is_touched_where_samples_say(
        corners in [corner(), corner(), corner()],
        cutter in cutters(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] };
        let (index, end) = (DropIndex::new(&mesh)?, CuttingEnd::of(&cutter));
        let found = index.lowered(&end, place).map_or(f64::NEG_INFINITY, |contact| contact.tip.z);
        let sampled = by_samples(&corners, &cutter, place);
        prop_assert!(sampled <= found + 1e-9, "a sample touches at {sampled}, found {found}");
        // Steep triangles fall between two samples by more than the tool does.
        let near = corners[0] - corners[1];
        let size = near.norm().max((corners[0] - corners[2]).norm());
        if sampled.is_finite() {
            let step = 2.0 * size / f64::from(SAMPLES);
            let steepest = (height(&cutter, cutter.radius()) / cutter.radius()).max(1.0);
            let rim = (2.0 * cutter.radius() * step).sqrt() * steepest + 3.0 * step * steepest;
            prop_assert!(found - sampled <= rim, "found {found}, sampled {sampled}");
        }
        // The contact lies on the end: the height of the tip follows from it.
        if let Some(contact) = index.lowered(&end, place) {
            let distance = (contact.point.x - place[0]).hypot(contact.point.y - place[1]);
            prop_assert!(distance <= cutter.radius() + 1e-9);
            let height = height(&cutter, distance.min(cutter.radius()));
            prop_assert!((contact.point.z - height - contact.tip.z).abs() < 1e-6);
        }
    }

    /// The tree leaves out nothing: the highest contact of single triangles is that of the mesh.
    #[test]
    fn a_mesh_is_the_highest_of_its_triangles(
        corners in prop::collection::vec([corner(), corner(), corner()], 1..40),
        cutter in cutters(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let vertices: Vec<Point3<f64>> = corners.iter().flatten().copied().collect();
        let triangles = (0..).map(|k: u32| [3 * k, 3 * k + 1, 3 * k + 2]).take(corners.len());
        let mesh = Mesh { vertices, triangles: triangles.collect() };
        let end = CuttingEnd::of(&cutter);
        let whole = DropIndex::new(&mesh)?.lowered(&end, place).map(|contact| contact.tip.z);
        let mut best: Option<f64> = None;
        for triangle in &mesh.triangles {
            let one = Mesh { triangles: vec![*triangle], ..mesh.clone() };
            let tip = DropIndex::new(&one)?.lowered(&end, place).map(|contact| contact.tip.z);
            best = match (best, tip) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
        }
        prop_assert_eq!(whole, best);
    }

    /// Moving every vertex by less than the deviation leaves the tip inside the bounds.
    #[test]
    fn bounds_hold_for_meshes_within_the_deviation(
        corners in [corner(), corner(), corner()],
        moves in [[-1.0..1.0, -1.0..1.0, -1.0..1.0], [-1.0..1.0, -1.0..1.0, -1.0..1.0], [-1.0..1.0, -1.0..1.0, -1.0..1.0]],
        cutter in cutters(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let (deviation, end) = (0.05, CuttingEnd::of(&cutter));
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] };
        let mut other = mesh.clone();
        for (vertex, by) in other.vertices.iter_mut().zip(moves) {
            let by = nalgebra::Vector3::from(by);
            *vertex += by * (deviation / 3.0_f64.sqrt());
        }
        let bounds = DropIndex::new(&mesh)?.tip_bounds(&end, place, deviation);
        if let Some(bounds) = bounds {
            let tip = DropIndex::new(&other)?.lowered(&end, place).map(|contact| contact.tip.z);
            let tip = tip.ok_or_else(|| TestCaseError::fail("nothing is touched"))?;
            prop_assert!(bounds.low - 1e-9 <= tip && tip <= bounds.high + 1e-9, "{tip} not in {bounds:?}");
        }
    }
}
