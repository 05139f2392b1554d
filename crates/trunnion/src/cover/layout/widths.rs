//! Table of strip widths over a face, by point and feed direction; layouts are chosen by it.

use crate::cover::layout::effort::{SearchOutcome, WorkCounter};
use crate::cover::options::CoverOptions;
use crate::cutter::Cutter;
use crate::math;
use crate::positioning::{LocationRequest, StripSide, widest_strip_counted};
use crate::surface::FaceIndex;
use crate::types::Interval;
use nalgebra::{Unit, Vector3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Points per parameter.
const PLACES: u32 = 13;

/// Feed directions over half a turn.
const DIRECTIONS: u32 = 12;

/// Distance of the outermost points from the border of the face, as a share of its extent.
const INSET: f64 = 0.005;

/// Strip widths at evenly spaced points and feed directions.
pub(crate) struct StripWidthTable {
    bounds: [Interval; 2],
    /// By point (v fastest), then by direction \[mm\].
    widths: Vec<f64>,
}

/// Default entry of a table, and the counter of the work to fill it.
pub(crate) struct TableFill<'a> {
    /// Width of entries without a wide strip \[mm\].
    pub(crate) narrow: f64,
    pub(crate) work: &'a WorkCounter,
}

/// Returns a point of the table.
fn place(bounds: [Interval; 2], index: u32) -> [f64; 2] {
    let [i, j] = [index / PLACES, index % PLACES];
    let share = |i: u32| (f64::from(i) / f64::from(PLACES - 1)).clamp(INSET, 1.0 - INSET);
    let at = |k: usize, i: u32| bounds[k].low + bounds[k].width() * share(i);
    [at(0, i), at(1, j)]
}

/// Returns the step of u and v along a direction in the tangent plane, given by its angle from
/// `S_u` towards `S_v`.
fn step([su, sv]: [Vector3<f64>; 2], angle: f64) -> Option<[f64; 2]> {
    // Orthonormal frame of the tangent plane: S_u, and the part of S_v square to it.
    let first = Unit::try_new(su, f64::MIN_POSITIVE)?;
    let second = Unit::try_new(sv - first.scale(first.dot(&sv)), f64::MIN_POSITIVE)?;
    let (sin, cos) = math::sin_cos(angle);
    // The direction is du S_u + dv S_v: its component along `second` gives dv, then that along `first` gives
    // du.
    let dv = sin / sv.dot(&second);
    Some([(cos - dv * sv.dot(&first)) / su.norm(), dv])
}

/// Returns the angle of a direction in the tangent plane, from `S_u` towards `S_v`.
fn angle([su, sv]: [Vector3<f64>; 2], way: &Vector3<f64>) -> Option<f64> {
    let first = Unit::try_new(su, f64::MIN_POSITIVE)?;
    let second = Unit::try_new(sv - first.scale(first.dot(&sv)), f64::MIN_POSITIVE)?;
    Some(math::atan2(way.dot(&second), way.dot(&first)))
}

/// Returns the step of u and v along a direction in the tangent plane.
pub(crate) fn along(tangents: [Vector3<f64>; 2], way: &Vector3<f64>) -> Option<[f64; 2]> {
    step(tangents, angle(tangents, way)?)
}

impl StripWidthTable {
    /// Fills the table. A point off the face or without a wide strip gets `fill.narrow`.
    pub(crate) fn new(
        face: &FaceIndex,
        cutter: &Cutter,
        options: &CoverOptions,
        fill: &TableFill<'_>,
    ) -> Self {
        let TableFill { narrow, work } = *fill;
        let bounds = face.face().bounds();
        let spread = [0, 1].map(|k| bounds[k].width() / f64::from(PLACES - 1));
        let near = |[u, v]: [f64; 2]| {
            // Points up to half a step off the face still serve the interpolation on it.
            let shifts = [-0.5, 0.0, 0.5];
            shifts.iter().any(|a| {
                shifts.iter().any(|b| face.face().contains(u + a * spread[0], v + b * spread[1]))
            })
        };
        let at = |index: u32| {
            let uv = place(bounds, index);
            let jet = face.face().surface.jet1(uv[0], uv[1]);
            // The location for one direction is the initial guess for the next; if it misleads, a search
            // without it follows.
            let mut warm = None;
            (0..DIRECTIONS)
                .map(|k| {
                    let angle = PI * f64::from(k) / f64::from(DIRECTIONS);
                    let Some(feed) = step([jet.su, jet.sv], angle).filter(|_| near(uv)) else {
                        return narrow;
                    };
                    let request = LocationRequest {
                        face,
                        cutter,
                        band: options.band,
                        at: uv.into(),
                        feed,
                        strip: if face.face().flip { StripSide::Left } else { StripSide::Right },
                        side: options.side,
                        offset_range: options.offset_range,
                        axis_cone: None,
                    };
                    let mut queries = 0;
                    let mut search =
                        |warm: Option<&_>| widest_strip_counted(&request, warm, &mut queries);
                    let found = search(warm.as_ref()).or_else(|error| match warm {
                        Some(_) => search(None),
                        None => Err(error),
                    });
                    work.location(match found {
                        Ok(_) => SearchOutcome::Found,
                        Err(_) => SearchOutcome::Missed { queries },
                    });
                    warm = found.ok();
                    warm.as_ref().map_or(narrow, |location| location.strip_width.max(narrow))
                })
                .collect::<Vec<f64>>()
        };
        let widths = (0..PLACES * PLACES).into_par_iter().map(at).collect::<Vec<_>>().concat();
        Self { bounds, widths }
    }

    /// Returns the strip width \[mm\] of a pass through a point in a direction, interpolated in the
    /// table.
    pub(crate) fn width(
        &self,
        uv: [f64; 2],
        tangents: [Vector3<f64>; 2],
        way: &Vector3<f64>,
    ) -> Option<f64> {
        // Directions repeat after half a turn.
        let turned = angle(tangents, way)? / PI;
        let (k, s) = cell((turned - turned.floor()) * f64::from(DIRECTIONS), DIRECTIONS);
        let [(i, a), (j, b)] = [0, 1].map(|k| {
            let Interval { low, high } = self.bounds[k];
            let share = ((uv[k] - low) / (high - low)).clamp(0.0, 1.0);
            cell(share * f64::from(PLACES - 1), PLACES - 1)
        });
        let at = |i: u32, j: u32, k: u32| {
            let index = (i * PLACES + j) * DIRECTIONS + k % DIRECTIONS;
            self.widths.get(index as usize).copied().unwrap_or(0.0)
        };
        // Linear in the direction, then bilinear in the point.
        let by = |i: u32, j: u32| at(i, j, k) * (1.0 - s) + at(i, j, k + 1) * s;
        let along = |i: u32| by(i, j) * (1.0 - b) + by(i, j + 1) * b;
        Some(along(i) * (1.0 - a) + along(i + 1) * a)
    }
}

/// Returns the interval of a value between `0` and `count`, and the position in it.
fn cell(at: f64, count: u32) -> (u32, f64) {
    // Within 0..=count.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let index = (at as u32).min(count - 1);
    (index, at - f64::from(index))
}
