//! End-point track of a pass: a line of its chart with its arc length, run out at both ends.

use crate::cover::layout::chart::Chart;
use crate::surface::FaceIndex;

/// Intervals of the arc-length table over the face, and over either extension.
const INTERVALS: u32 = 256;
const EXTENSION_INTERVALS: u32 = 16;

/// Arc length over the parameter along, on a line `across` = const.
#[derive(Debug, Clone)]
pub(crate) struct EndPointTrack {
    /// Increasing parameters.
    along: Vec<f64>,
    /// Arc length \[mm\] from the border of the face; negative before it.
    arc: Vec<f64>,
    /// Arc length over the face itself \[mm\].
    length: f64,
}

impl EndPointTrack {
    /// Tabulates the line over `range`, carried on by `extension` \[mm\] on the continued surface.
    /// An end where the line stands still (a collapsed edge) is not carried on.
    pub(crate) fn new(
        face: &FaceIndex,
        chart: &Chart,
        across: f64,
        [start, end]: [f64; 2],
        extension: f64,
    ) -> Self {
        let speed = |along: f64| {
            let [u, v] = chart.uv([across, along]);
            let jet = face.face().surface.jet1(u, v);
            let [_, [du, dv]] = chart.steps([across, along]);
            (jet.su * du + jet.sv * dv).norm()
        };
        let width = (end - start) / f64::from(INTERVALS);
        let mut track = Self { along: vec![start], arc: vec![0.0], length: 0.0 };
        for i in 1..=INTERVALS {
            let to = if i == INTERVALS { end } else { start + width * f64::from(i) };
            track.walk(to, &speed);
        }
        track.length = track.arc.last().copied().unwrap_or(0.0);
        track.extend(extension, &speed);
        track.turn_round();
        track.extend(extension, &speed);
        track.turn_round();
        track
    }

    /// Adds one interval by Simpson's rule.
    fn walk(&mut self, to: f64, speed: &impl Fn(f64) -> f64) {
        let (Some(&from), Some(&arc)) = (self.along.last(), self.arc.last()) else { return };
        // Mean speed by Simpson's rule, exact for cubics; the arc length is its integral.
        let mean = (speed(from) + 4.0 * speed(0.5 * (from + to)) + speed(to)) / 6.0;
        self.along.push(to);
        self.arc.push(arc + (to - from) * mean);
    }

    /// Carries the line on in steps of a share of the extension, at the speed of the border.
    fn extend(&mut self, extension: f64, speed: &impl Fn(f64) -> f64) {
        let Some(&[before, last]) = self.along.last_chunk() else { return };
        let rate = speed(last);
        // A border that is crossed 1000 times more slowly than the face on average is a collapsed
        // edge.
        let span = (self.along[0] - last).abs() * 1e3;
        let length = self.arc.last().map_or(0.0, |arc| (arc - self.arc[0]).abs());
        if rate * span < length {
            return;
        }
        let step = (extension / f64::from(EXTENSION_INTERVALS) / rate).copysign(last - before);
        for i in 1..=EXTENSION_INTERVALS {
            self.walk(last + step * f64::from(i), speed);
        }
    }

    fn turn_round(&mut self) {
        self.along.reverse();
        self.arc.reverse();
    }

    /// Returns the first and last arc length.
    pub(crate) fn range(&self) -> [f64; 2] {
        match (self.arc.first(), self.arc.last()) {
            (Some(&first), Some(&last)) => [first, last],
            _ => [0.0, 0.0],
        }
    }

    /// Returns the arc lengths between which the track lies over the face.
    pub(crate) fn face(&self) -> [f64; 2] {
        [0.0, self.length]
    }

    /// Returns `true` if `arc` lies over the face and not on its continuation.
    pub(crate) fn over_face(&self, arc: f64) -> bool {
        (0.0..=self.length).contains(&arc)
    }

    /// Returns the parameter along at arc length `arc`.
    pub(crate) fn at(&self, arc: f64) -> f64 {
        let after = self.arc.partition_point(|&w| w <= arc).clamp(1, self.arc.len() - 1);
        let (w, a) = (&self.arc[after - 1..=after], &self.along[after - 1..=after]);
        // Inverse of the table, linear in the interval.
        let share = if w[1] > w[0] { (arc - w[0]) / (w[1] - w[0]) } else { 0.0 };
        a[0] + share * (a[1] - a[0])
    }
}
