//! Lowered cutters against dense samples of the triangles.

use crate::property;
use nalgebra::Point3;
use proptest::prelude::*;
use trunnion_geometry::drop_cutter::{CuttingEnd, DropIndex};
use trunnion_geometry::types::Mesh;

/// Points of a triangle along each side.
const SAMPLES: u32 = 160;

/// The tip on points alone: a lower bound that dense samples bring close.
fn by_samples(corners: &[Point3<f64>; 3], end: CuttingEnd, place: [f64; 2]) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for i in 0..=SAMPLES {
        for j in 0..=SAMPLES - i {
            let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(SAMPLES));
            let point = corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t;
            let distance = (point.x - place[0]).hypot(point.y - place[1]);
            if distance > end.major + end.minor {
                continue;
            }
            let out = (distance - end.major).max(0.0);
            let height = end.minor - (end.minor * end.minor - out * out).max(0.0).sqrt();
            best = best.max(point.z - height);
        }
    }
    best
}

fn corner() -> impl Strategy<Value = Point3<f64>> {
    (-8.0..8.0, -8.0..8.0, -4.0..4.0).prop_map(|(x, y, z)| Point3::new(x, y, z))
}

fn ends() -> impl Strategy<Value = CuttingEnd> {
    prop_oneof![
        (0.5..6.0).prop_map(|minor| CuttingEnd { major: 0.0, minor }),
        (0.5..6.0).prop_map(|major| CuttingEnd { major, minor: 0.0 }),
        (0.2..5.0, 0.2..4.0).prop_map(|(major, minor)| CuttingEnd { major, minor }),
    ]
}

proptest! {
    #![proptest_config(property::cases(400))]

    /// No sample is higher than the contact, and a dense sample comes close to it.
    #[test]
    fn a_triangle_is_touched_where_samples_say(
        corners in [corner(), corner(), corner()],
        end in ends(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] };
        let index = DropIndex::new(&mesh)?;
        let found = index.lowered(&end, place).map_or(f64::NEG_INFINITY, |contact| contact.tip.z);
        let sampled = by_samples(&corners, end, place);
        prop_assert!(sampled <= found + 1e-9, "a sample touches at {sampled}, found {found}");
        // Steep triangles fall between two samples by more than the tool does.
        let near = corners[0] - corners[1];
        let size = near.norm().max((corners[0] - corners[2]).norm());
        if sampled.is_finite() {
            let step = 2.0 * size / f64::from(SAMPLES);
            let rim = (2.0 * (end.minor + end.major) * step).sqrt() + 3.0 * step;
            prop_assert!(found - sampled <= rim, "found {found}, sampled {sampled}");
        }
        // The contact lies on the end: the height of the tip follows from it.
        if let Some(contact) = index.lowered(&end, place) {
            let distance = (contact.point.x - place[0]).hypot(contact.point.y - place[1]);
            let out = (distance - end.major).clamp(0.0, end.minor);
            let height = end.minor - (end.minor * end.minor - out * out).max(0.0).sqrt();
            prop_assert!((contact.point.z - height - contact.tip.z).abs() < 1e-6);
            prop_assert!(distance <= end.major + end.minor + 1e-9);
        }
    }

    /// The tree leaves out nothing: the highest contact of single triangles is that of the mesh.
    #[test]
    fn a_mesh_is_the_highest_of_its_triangles(
        corners in prop::collection::vec([corner(), corner(), corner()], 1..40),
        end in ends(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let vertices: Vec<Point3<f64>> = corners.iter().flatten().copied().collect();
        let triangles = (0..).map(|k: u32| [3 * k, 3 * k + 1, 3 * k + 2]).take(corners.len());
        let mesh = Mesh { vertices, triangles: triangles.collect() };
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
        end in ends(),
        place in [-6.0..6.0, -6.0..6.0],
    ) {
        let deviation = 0.05;
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
