//! Holders from triangles enclose every point of them, tightly.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use trunnion::pipeline::holder_profile;
use trunnion::types::Mesh;

/// Prism around the axis from a lower to an upper height.
fn prism(corners: u32, radius: f64, ends: [f64; 2]) -> Mesh {
    let around = |z: f64| {
        (0..corners).map(move |k| {
            let angle = TAU * f64::from(k) / f64::from(corners);
            Point3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    };
    let mut vertices: Vec<Point3<f64>> = around(ends[0]).chain(around(ends[1])).collect();
    vertices.extend(ends.map(|z| Point3::new(0.0, 0.0, z)));
    let triangles = (0..corners).flat_map(|k| {
        let [a, b] = [k, (k + 1) % corners];
        let [c, d] = [a + corners, b + corners];
        [[a, b, d], [a, d, c], [2 * corners, b, a], [2 * corners + 1, c, d]]
    });
    Mesh { triangles: triangles.collect(), vertices }
}

fn joined(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for mesh in meshes {
        let from = u32::try_from(all.vertices.len()).unwrap();
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|corner| corner + from)));
    }
    all
}

#[test]
fn a_holder_with_flats_turns_in_the_cylinder_round_its_corners() {
    let square = prism(4, 20.0, [-40.0, 30.0]);
    let profile = holder_profile(&square, 100.0).unwrap();
    assert_eq!(profile.len(), 2, "{profile:?}");
    let near = |found: &[f64; 2], wanted: [f64; 2]| {
        assert!(
            (found[0] - wanted[0]).abs() < 1e-6 && (found[1] - wanted[1]).abs() < 1e-9,
            "{found:?}, {wanted:?}"
        );
    };
    // From the lower end to the gauge point: what is in the spindle does not count.
    near(&profile[0], [60.0, 20.0]);
    near(&profile[1], [100.0, 20.0]);
    // A nut below it.
    let stepped = joined(&[square, prism(64, 12.0, [-55.0, -40.0])]);
    let profile = holder_profile(&stepped, 100.0).unwrap();
    assert_eq!(profile.len(), 4, "{profile:?}");
    near(&profile[0], [45.0, 12.0]);
    near(&profile[1], [60.0, 12.0]);
    near(&profile[2], [60.0, 20.0]);
}

/// No point of the triangles is outside of the profile, and each of its bends is near one.
#[test]
fn a_tilted_box_is_enclosed_tightly() {
    let turn = Rotation3::from_euler_angles(0.5, 0.3, 0.2);
    let mut mesh = prism(4, 20.0, [-15.0, 15.0]);
    for p in &mut mesh.vertices {
        *p = turn * *p + Vector3::new(3.0, -2.0, -40.0);
    }
    let profile = holder_profile(&mesh, 100.0).unwrap();
    let radius_at = |height: f64| {
        let at = profile.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&height));
        let at = at.unwrap();
        let share = (height - at[0][0]) / (at[1][0] - at[0][0]).max(1e-12);
        at[0][1] + share * (at[1][1] - at[0][1])
    };
    let mut largest = BTreeMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize]);
        for (i, j) in (0..=200).flat_map(|i| (0..=200 - i).map(move |j| (i, j))) {
            let [u, v] = [f64::from(i) / 200.0, f64::from(j) / 200.0];
            let p = a + (b - a) * u + (c - a) * v;
            let (height, radius) = (p.z + 100.0, p.x.hypot(p.y));
            assert!(radius <= radius_at(height) + 1e-6, "{p}");
            #[expect(clippy::cast_possible_truncation, reason = "millimetres")]
            let bin = (2.0 * height) as i64;
            let most: &mut f64 = largest.entry(bin).or_default();
            *most = most.max(radius);
        }
    }
    // In every half millimetre it is as large as the largest of the points there, but for its change over that height.
    for (bin, radius) in largest {
        let ends = [0.0, 0.5].map(|by| {
            let [low, high] = [profile[0][0], profile[profile.len() - 1][0]];
            radius_at((0.5 * bin as f64 + by).clamp(low, high))
        });
        let least = ends[0].min(ends[1]);
        assert!(least <= radius + 0.1, "{bin}: {least}, {radius}");
    }
}

#[test]
fn an_open_holder_is_refused() {
    let mut open = prism(16, 20.0, [-40.0, 0.0]);
    open.triangles.truncate(20);
    let refused = holder_profile(&open, 100.0).unwrap_err().to_string();
    assert!(refused.contains("closed"), "{refused}");
    let above = prism(16, 20.0, [5.0, 40.0]);
    let refused = holder_profile(&above, 100.0).unwrap_err().to_string();
    assert!(refused.contains("gauge point"), "{refused}");
}
