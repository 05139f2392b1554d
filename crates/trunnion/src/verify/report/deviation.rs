//! Worst heights of all faces, and bounds on them.

use super::face_map::{FaceMap, HeightSample};
use crate::types::{Interval, Uv};
use nalgebra::Point3;
use std::fmt;

/// Lowest or highest sample of all faces.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ExtremeHeight {
    /// Number of the face.
    pub face: usize,
    /// Parameters.
    pub uv: Uv,
    /// Point of the face, workpiece frame \[mm\].
    pub point: Point3<f64>,
    /// Height left \[mm\].
    pub height: f64,
    /// The tool reaches the end of the search range: the gouge may be deeper.
    pub or_deeper: bool,
    /// Line of the program that made it.
    pub line: u32,
    /// The line is a rapid move that gouges on a control that runs each axis at its own speed.
    pub dog_leg: bool,
}

/// Summary of the heights over all faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Deviation {
    /// Points measured, uncut ones among them.
    pub points: usize,
    /// The lowest sample: the worst gouge, if below 0.
    pub lowest: Option<ExtremeHeight>,
    /// The highest sample outside what is known not to be finished: the worst excess, if above 0.
    pub highest: Option<ExtremeHeight>,
    /// Points in what is known not to be finished.
    pub rest: usize,
    /// Points elsewhere that no tool came near.
    pub uncut: usize,
    /// Area of the faces \[mm²\].
    pub area: f64,
    /// Area around uncut points \[mm²\].
    pub uncut_area: f64,
    /// Points that could not be measured.
    pub unmeasured: usize,
    /// Effect of errors of tool and setup on the heights.
    pub sensitivity: Sensitivity,
    /// Least and largest shift of the tool along its axis that would keep the tolerance everywhere \[mm\]: suggests a wrong
    /// tool length or height of the work offset. `None` unless most lines break the tolerance and one shift repairs all.
    pub higher: Option<Interval>,
    /// Line of a rapid move that gets to where no cut leaves as little as the tolerance.
    pub rapid: Option<u32>,
    /// Bounds between the points; `None` if they were not requested or cannot be proven.
    pub bounds: Option<HeightBounds>,
    /// Area by height, from lowest to highest.
    pub histogram: Vec<HistogramBin>,
}

/// Largest change of a height per error of a quantity that the check takes as exact \[mm/mm\], to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Sensitivity {
    /// Per error of the tool length: gouge or excess, by its sign.
    pub length: f64,
    /// Per error of the corner radius: a larger one gouges.
    pub radius: f64,
    /// Per error of the position of one rotary axis, in the worst direction, if the workpiece was set with the rotaries
    /// at zero; `None` without a machine.
    pub pivot: Option<f64>,
}

/// Bounds over whole faces, between the measured points as well, for the modelled geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeightBounds {
    /// Upper bound on the depth of gouges \[mm\].
    pub gouge: f64,
    /// Upper bound on excess \[mm\], outside known rest material, uncut points and the grid cells that touch either;
    /// `None` if it was not requested.
    pub excess: Option<f64>,
    /// Area for which the bounds are not proven \[mm²\].
    pub open: f64,
}

/// Area of the faces with a height in a range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HistogramBin {
    /// Range \[mm\].
    pub range: Interval,
    /// Area \[mm²\].
    pub area: f64,
}

/// Bins of the histogram.
const BINS: usize = 40;

impl ExtremeHeight {
    /// Returns the height of a sample; `None` if nothing cuts there.
    pub(in crate::verify) fn of(face: usize, sample: &HeightSample) -> Option<Self> {
        let HeightSample { uv, point, dog_leg, .. } = *sample;
        let (height, line) = (sample.height?, sample.line?);
        Some(Self { face, uv, point, height, or_deeper: false, line, dog_leg })
    }
}

impl Deviation {
    /// Summarizes maps.
    pub(in crate::verify) fn of<'a, Maps>(maps: &Maps) -> Self
    where
        Maps: Iterator<Item = &'a FaceMap> + Clone,
    {
        let samples = || {
            let samples = |map: &'a FaceMap| map.samples.iter().flatten().map(|s| (map.face, s));
            maps.clone().flat_map(samples)
        };
        let extreme = |(face, sample)| ExtremeHeight::of(face, sample);
        let extremes = || samples().filter_map(extreme);
        let by_height = |a: &ExtremeHeight, b: &ExtremeHeight| a.height.total_cmp(&b.height);
        let uncut = || samples().filter(|(_, s)| s.height.is_none() && !s.rest);
        let finished = samples().filter(|(_, s)| !s.rest).filter_map(extreme);
        let (lowest, highest) = (extremes().min_by(by_height), finished.max_by(by_height));
        Self {
            points: samples().count(),
            lowest,
            highest,
            rest: samples().filter(|(_, s)| s.rest).count(),
            uncut: uncut().count(),
            area: samples().map(|(_, s)| s.area).sum(),
            // An empty sum of floating-point numbers is -0, which would be printed.
            uncut_area: uncut().map(|(_, s)| s.area).sum::<f64>() + 0.0,
            unmeasured: maps.clone().map(|map| map.unmeasured).sum(),
            sensitivity: Sensitivity { length: 0.0, radius: 0.0, pivot: None },
            higher: None,
            rapid: None,
            bounds: None,
            histogram: match (lowest, highest) {
                (Some(low), Some(high)) => {
                    let finished = samples().filter(|(_, s)| !s.rest);
                    let heights = finished.filter_map(|(_, s)| Some((s.height?, s.area)));
                    histogram(heights, [low.height, high.height])
                }
                _ => Vec::new(),
            },
        }
    }
}

/// Distributes areas into bins of equal height.
fn histogram(
    heights: impl Iterator<Item = (f64, f64)>,
    [low, high]: [f64; 2],
) -> Vec<HistogramBin> {
    // Computed from the ends alone, so that neighbouring bins share their edge exactly.
    let edge = |k: usize| low + (high - low) * k as f64 / BINS as f64;
    let mut bins: Vec<HistogramBin> = (0..BINS)
        .map(|k| HistogramBin { range: Interval::new(edge(k), edge(k + 1)), area: 0.0 })
        .collect();
    for (height, area) in heights {
        // The highest sample is at the upper edge of the last bin, and counts in it.
        let bin = bins.partition_point(|bin| bin.range.high <= height).min(BINS - 1);
        if let Some(bin) = bins.get_mut(bin) {
            bin.area += area;
        }
    }
    bins
}

impl fmt::Display for ExtremeHeight {
    /// Writes the point, and the line that made it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, Uv { u, v }) = (self.point, self.uv);
        write!(
            f,
            "on face {} at X {:.3} Y {:.3} Z {:.3} (u {u:.4}, v {v:.4}), made by line {}",
            self.face, p.x, p.y, p.z, self.line
        )?;
        f.write_str(if self.dog_leg { " if its axes run each at its own speed" } else { "" })
    }
}
