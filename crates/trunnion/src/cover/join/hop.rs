//! Hops: short links from pass to pass, off the face and on again in one sweep.

use crate::cover::prove::sweep::PassSweep;
use crate::math;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{PoseCurve, Station, ToolPose};
use nalgebra::Point3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

/// Estimate of the time of the machine through poses, from rest to rest \[s\].
pub type TravelTime<'a> = &'a (dyn Fn(&[ToolPose]) -> f64 + Sync);

/// Options of hops. Begin with [`HopOptions::new`] and change the rest by struct update.
#[derive(Clone, Copy)]
pub struct HopOptions<'a> {
    /// Height of the tip above the ends of the passes in the middle of a hop \[mm\]: more than the
    /// stock. Twice, four and eight times the height are tried as well.
    pub height: f64,
    /// Least distance from the faces in the middle of a hop \[mm\]: the material that may be left
    /// on them.
    pub clear: f64,
    /// Estimates the time of the machine through poses, from rest to rest \[s\]. A hop is
    /// taken if it is quicker than three straight moves up, over and down.
    pub seconds: TravelTime<'a>,
    /// Feed of leads and of steps \[mm/s\]: from a pass to one beside it the tool may go along the face where that is quicker
    /// than to leave it. `None`: leads take no longer than the machine needs, and there are no steps.
    pub feed: Option<f64>,
}

impl<'a> HopOptions<'a> {
    /// Hops `height` \[mm\] high on a machine with that estimate of time, at least half the height from the faces
    /// in the middle. There are no steps.
    pub fn new(height: f64, seconds: TravelTime<'a>) -> Self {
        Self { height, clear: 0.5 * height, seconds, feed: None }
    }

    /// Returns the time of the machine through stations \[s\].
    pub(super) fn time(&self, stations: &[Station]) -> f64 {
        let poses: Vec<ToolPose> = stations.iter().map(|station| station.pose).collect();
        (self.seconds)(&poses)
    }
}

impl fmt::Debug for HopOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { height, clear, feed, .. } = self;
        let mut all = f.debug_struct("HopOptions");
        let all = all.field("height", height).field("clear", clear).field("feed", feed);
        all.finish_non_exhaustive()
    }
}

/// Heights that are tried, over [`HopOptions::height`].
const HEIGHTS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// Steps of a hop. A spline through them is half an ellipse to a thousandth of its height.
const STEPS: u32 = 16;

/// Steps at either end on which the tool still leaves the face: there it is at less than half its
/// height.
const NEAR: usize = 3;

/// Least distance from the faces over that from the ends of the hop: blocks may be off the curve by as much.
const CLEAR: f64 = 0.1;

/// Hop from the end of one pass to the start of another.
pub(crate) struct HopPath<'a> {
    pub(crate) from: &'a Station,
    pub(crate) to: &'a Station,
    /// Ends of the leads that the hop would replace, if there are any.
    pub(crate) over: [Option<ToolPose>; 2],
    pub(crate) lever: f64,
    /// Time of the parts of these leads that are run at the feed \[s\].
    pub(crate) leads: f64,
}

impl HopPath<'_> {
    /// Returns the stations of the lowest hop that is free and quicker than a link.
    ///
    /// `free` returns `true` if the tool keeps a distance from all faces during a span. Into a face
    /// it may go by `gouge`.
    pub(crate) fn find(
        &self,
        hops: &HopOptions<'_>,
        free: impl Fn(&PassSweep, usize, f64) -> bool,
        gouge: f64,
    ) -> Option<Vec<Station>> {
        let [from, to] = [self.from, self.to].map(|station| station.pose);
        // A hop lifts along the axis: opposite sides of a part are no place for it.
        if angle_between(&from.axis, &to.axis) >= FRAC_PI_2 {
            return None;
        }
        let link = self.link_time(hops);
        let quick = |stations: &[Station]| hops.time(stations) < link;
        HEIGHTS.iter().find_map(|share| {
            let stations = half_ellipse([self.from, self.to], share * hops.height);
            let sweep = PassSweep::of(PoseCurve::through(&stations, self.lever), self.lever);
            let spans = sweep.curve.spans.len();
            // At its ends the tool may touch the face within the gouge tolerance, and is clear by a share of the way from
            // there; in the middle it clears the material.
            let kept = |span: usize| {
                let middle = (NEAR..spans - NEAR).contains(&span);
                let near = CLEAR * self.away(&stations[span..=span + 1]) - gouge;
                free(&sweep, span, if middle { hops.clear } else { near })
            };
            (quick(&stations) && (0..spans).all(kept)).then_some(stations)
        })
    }

    /// Returns the time of the leads at the feed and of the three straight moves that a hop replaces \[s\].
    pub(crate) fn link_time(&self, hops: &HopOptions<'_>) -> f64 {
        let [from, to] = [self.from, self.to].map(|station| station.pose);
        let moves = match self.over {
            [Some(above), Some(beyond)] => [[from, above], [above, beyond], [beyond, to]]
                .iter()
                .map(|way| (hops.seconds)(way))
                .sum::<f64>(),
            _ => f64::INFINITY,
        };
        moves + self.leads
    }

    /// Returns the time of the lowest hop, which may not be free \[s\].
    pub(crate) fn least_time(&self, hops: &HopOptions<'_>) -> f64 {
        hops.time(&half_ellipse([self.from, self.to], hops.height))
    }

    /// Returns the least distance of some stations from the ends of the hop \[mm\].
    fn away(&self, stations: &[Station]) -> f64 {
        let ends = [self.from, self.to].map(|end| end.pose.tip);
        let away = |station: &Station| ends.map(|end| (station.pose.tip - end).norm());
        stations.iter().flat_map(away).fold(f64::INFINITY, f64::min)
    }
}

/// Returns the stations of half an ellipse between two stations, up along the tool axis; the axis turns on the great
/// circle.
pub(super) fn half_ellipse([from, to]: [&Station; 2], height: f64) -> Vec<Station> {
    let at = |step: u32| {
        if step == 0 || step == STEPS {
            return if step == 0 { *from } else { *to };
        }
        // Half an ellipse: the distance advances by (1 - cos) / 2 while the height follows the sine.
        let (sin, cos) = math::sin_cos(PI * f64::from(step) / f64::from(STEPS));
        let share = 0.5 * (1.0 - cos);
        let between = |a: &Point3<f64>, b: &Point3<f64>| a + (b - a) * share;
        let [a, b] = [from.pose.axis, to.pose.axis];
        let axis = great_circle(&a, &b, share).unwrap_or(a);
        let up = axis.scale(height * sin);
        let tip = between(&from.pose.tip, &to.pose.tip) + up;
        Station { pose: ToolPose { tip, axis }, contact: between(&from.contact, &to.contact) + up }
    };
    (0..=STEPS).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use std::cell::RefCell;

    /// A hop of 40 mm: what it keeps from the faces is asked span by span, and grows with the way from its ends.
    #[test]
    fn near_its_ends_a_hop_keeps_a_share_of_the_way() {
        let at = |x: f64| {
            let tip = Point3::new(x, 0.0, 0.0);
            Station { pose: ToolPose { tip, axis: Vector3::z_axis() }, contact: tip }
        };
        let (from, to) = (at(0.0), at(40.0));
        let over = [None; 2];
        let hop = HopPath { from: &from, to: &to, over, lever: 5.0, leads: 0.0 };
        let asked = RefCell::new(Vec::new());
        let free = |_: &PassSweep, span: usize, least: f64| {
            asked.borrow_mut().push((span, least));
            true
        };
        let seconds = |_: &[ToolPose]| 1.0;
        let stations = hop.find(&HopOptions::new(4.0, &seconds), free, 0.01).unwrap();
        for (span, least) in asked.into_inner() {
            let last = stations.len() - 1;
            let near = span.min(last - 1 - span);
            let tip = stations[near].pose.tip;
            let expected = if near < NEAR { CLEAR * tip.coords.norm() - 0.01 } else { 2.0 };
            assert!((least - expected).abs() < 1e-9, "span {span}: {least} instead of {expected}");
        }
    }
}
