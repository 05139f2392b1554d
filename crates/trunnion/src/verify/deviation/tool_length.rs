//! Recognizes deviations that one wrong length explains: that of the tool, or the height of the workpiece.

use super::map::MeasuredMap;
use crate::surface::Face;
use crate::types::Interval;
use crate::verify::options::CheckOptions;
use std::collections::BTreeMap;

/// Least share of lines out of tolerance from which a wrong length is suspected.
const MOST: f64 = 0.5;

/// Returns the least and the largest shift along the tool axis that would keep the tolerance at every point \[mm\].
///
/// `None` if nothing is wrong, or if no single shift repairs everything. To first order: a point touched along its normal
/// by an inclined tool moves by the shift times the cosine.
pub(crate) fn length(
    faces: &[Face],
    measured: &[MeasuredMap<'_>],
    options: &CheckOptions,
) -> Option<Interval> {
    let [low, high] = [-options.gouge, options.total];
    let mut higher = [f64::NEG_INFINITY, f64::INFINITY];
    let mut lines: BTreeMap<u32, bool> = BTreeMap::new();
    for (face, MeasuredMap { map, deciding, .. }) in faces.iter().zip(measured) {
        for (sample, by) in map.samples.iter().zip(deciding) {
            let Some(sample) = sample.as_ref().filter(|sample| !sample.rest) else { continue };
            let (height, line) = (sample.height?, sample.line?);
            let normal = face.normal(sample.uv.u, sample.uv.v)?;
            // A shift d along the tool axis a moves the surface by d (a n): low <= h + d (a n) <= high bounds d on both sides.
            let along = by.as_ref()?.pose.axis.dot(&normal);
            *lines.entry(line).or_default() |= !(low..=high).contains(&height);
            if along > 0.0 {
                let [least, most] = [low, high].map(|bound| (bound - height) / along);
                higher = [higher[0].max(least), higher[1].min(most)];
            // A point whose normal is across the axis or against it is not repaired by a shift.
            } else if !(low..=high).contains(&height) {
                return None;
            }
        }
    }
    // A wrong length shows on nearly all lines; a few bad lines are defects of their own.
    let broken = lines.values().filter(|broken| **broken).count();
    let all_over = broken as f64 > MOST * lines.len() as f64;
    let [least, most] = higher;
    (all_over && least <= most && (least > 0.0 || most < 0.0)).then_some(higher.into())
}
