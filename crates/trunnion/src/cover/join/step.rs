//! Steps: from a pass to the next beside it along the face, at the feed.
//!
//! Over a distance of a strip or two the tool need not leave the face: off it and on again takes several times as long.

use super::hop::HopOptions;
use super::leads::{LinkPlanner, PRECISION};
use crate::cover::prove::sweep::PassSweep;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{Pass, PoseCurve, Station, ToolPose, Uv};
use nalgebra::{Unit, UnitVector3};
use std::f64::consts::FRAC_PI_4;

/// Heights in the middle of a step that are tried, over its length: the face may bulge between its ends, and round the
/// edge between two walls the tip goes a longer way than the contact.
const HEIGHTS: [f64; 4] = [0.02, 0.06, 0.15, 0.3];

/// Steps between the stations of a step: a parabola, which a spline follows closely.
const PARTS: u32 = 4;

/// Step that goes straight \[mm\]: over so little no face bulges.
const STRAIGHT: f64 = 0.01;

/// Distance \[mm\] and angle \[rad\] up to which a pass continues the one before: a hundredth of the last digit of a
/// program, and as little at the gauge point.
const SAME: [f64; 2] = [1e-6, 1e-8];

/// Least length of the sum of the normals at both ends: of opposite faces, no direction leads off both.
const LEAST_SUM: f64 = 0.5;

/// Longest step, in widths of the strips at its ends. Farther away lies no neighbour.
const STRIPS: f64 = 2.0;

impl LinkPlanner<'_> {
    /// Plans a step from one pass to the next, with its time \[s\], if one keeps off all faces and takes less than `most`.
    pub(crate) fn step(
        &self,
        [before, next]: [&Pass; 2],
        hops: &HopOptions<'_>,
        most: f64,
    ) -> Option<(f64, Vec<Station>)> {
        let feed = hops.feed?;
        let [from, to] = [before.stations.last()?, next.stations.first()?];
        let length = (to.contact - from.contact).norm();
        let tips = (to.pose.tip - from.pose.tip).norm();
        let longest = STRIPS * before.widths.last()?.max(*next.widths.first()?);
        if length > longest {
            return None;
        }
        let axes = [from.pose.axis, to.pose.axis];
        if angle_between(&axes[0], &axes[1]) > FRAC_PI_4 {
            return None;
        }
        let [from_normal, to_normal] =
            [self.normal(before, before.track.last()?)?, self.normal(next, next.track.first()?)?];
        let up = Unit::try_new(from_normal.into_inner() + to_normal.into_inner(), LEAST_SUM)?;
        let seconds = |stations: &[Station]| {
            let lengths =
                stations.windows(2).map(|pair| (pair[1].pose.tip - pair[0].pose.tip).norm());
            hops.time(stations).max(lengths.sum::<f64>() / feed)
        };
        let gouge = self.options.gouge;
        let margin = PRECISION * gouge.abs();
        let heights: &[f64] = if tips < STRAIGHT { &[0.0] } else { &HEIGHTS };
        heights.iter().find_map(|share| {
            let stations = parabola([from, to], &up, share * length.max(tips));
            let time = Some(seconds(&stations)).filter(|time| *time < most)?;
            let sweep = PassSweep::of(PoseCurve::through(&stations, self.lever), self.lever);
            let free = |span| self.depth_in(&sweep, span, margin - gouge) <= gouge;
            (0..sweep.curve.spans.len()).all(free).then_some((time, stations))
        })
    }

    /// Returns the normal of the face of a pass at a point of its track.
    fn normal(&self, pass: &Pass, at: &Uv) -> Option<UnitVector3<f64>> {
        let face = self.faces.iter().find(|face| face.face().number == pass.face)?;
        face.face().normal(at.u, at.v)
    }
}

/// Tests if a pass continues the one before, as at the seam of two walls that meet smoothly.
pub(super) fn continues([before, next]: [&Pass; 2]) -> bool {
    let ends = before.stations.last().zip(next.stations.first());
    ends.is_some_and(|(from, to)| {
        (to.pose.tip - from.pose.tip).norm() <= SAME[0]
            && angle_between(&from.pose.axis, &to.pose.axis) <= SAME[1]
    })
}

/// Returns the stations of a parabola of some height between two stations; the axis turns on the great circle.
fn parabola([from, to]: [&Station; 2], up: &UnitVector3<f64>, height: f64) -> Vec<Station> {
    let at = |part: u32| {
        let share = f64::from(part) / f64::from(PARTS);
        let rise = up.scale(4.0 * height * share * (1.0 - share));
        let [a, b] = [from.pose.axis, to.pose.axis];
        let tip = from.pose.tip + (to.pose.tip - from.pose.tip) * share + rise;
        let contact = from.contact + (to.contact - from.contact) * share + rise;
        Station { pose: ToolPose { tip, axis: great_circle(&a, &b, share).unwrap_or(a) }, contact }
    };
    let between = (1..PARTS).map(at);
    std::iter::once(*from).chain(between).chain(std::iter::once(*to)).collect()
}
