//! Samples of a control net: points, normals and tangents.

use crate::surface::NurbsSurface;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// Samples of a patch by each parameter: an elementary surface is determined by fewer.
const SAMPLES: usize = 4;

/// A sample of a net.
#[derive(Debug, Clone, Copy)]
pub(super) struct NetSample {
    pub(super) point: Point3<f64>,
    pub(super) normal: UnitVector3<f64>,
    /// Derivatives by u and v.
    pub(super) tangents: [Vector3<f64>; 2],
}

/// Returns samples of all patches, where they have a normal.
pub(super) fn samples(net: &NurbsSurface) -> Vec<NetSample> {
    let [columns, rows] = net.patch_count();
    let patches = (0..columns).flat_map(|i| (0..rows).filter_map(move |j| net.patch(i, j)));
    // In the middle of cells: rims, which may be poles, are avoided.
    let share = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
    let mut samples = Vec::new();
    for patch in patches {
        let [u, v] = patch.bounds;
        for (i, j) in (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j))) {
            let at = |range: Interval, k: usize| range.at(share(k));
            let jet = net.jet2(at(u, i), at(v, j));
            let sample = |normal| NetSample { point: jet.s, normal, tangents: [jet.su, jet.sv] };
            samples.extend(jet.normal().map(sample));
        }
    }
    samples
}
