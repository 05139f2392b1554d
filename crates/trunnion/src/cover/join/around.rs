//! Links around the part, for passes that no common plane clears.
//!
//! A tool with its axis along `n` and its tip on a plane square to `n` is on the far side of that
//! plane with everything it has, however wide its holder. So it keeps off a part wherever its tip
//! is higher, seen along its own axis, than all of the part. The planes that touch the part and its
//! stock, raised by the clearance, envelop the link.

use crate::cover::join::axis_reach::AxisReach;
use crate::cover::join::leads::LinkPlanner;
use crate::cover::prove::clearance::ClearanceProof;
use crate::cover::prove::sweep::PassSweep;
use crate::cover::prove::time_slab::SpanTimes;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{PoseCurve, Station, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use std::f64::consts::PI;

/// Largest turn between two stations of a link \[rad\].
const STEP: f64 = PI / 12.0;

/// Least number of steps. With a station between its ends a link is a curve, and run as it is.
const LEAST_STEPS: u32 = 2;

/// Number of steps of half a turn.
const MOST_STEPS: u32 = 12;

/// Share of the clearance that the tool keeps from all faces between the stations.
const KEPT: f64 = 0.25;

/// Precision of that proof, as a share of the clearance.
const PRECISION: f64 = 0.05;

/// Number of heights, one clearance apart, at which a link is tried.
const RAISES: u32 = 3;

impl LinkPlanner<'_> {
    /// Returns the stations of a link from one point over the part, as seen along its axis, to
    /// another, with its ends. The axis turns on a great circle; the tip goes straight but for its
    /// lift along the axis.
    ///
    /// If the machine does not reach the axes in between, the link turns over a further axis, the
    /// one with the shortest turn. A curve through stations so far apart leaves the great circle by
    /// some tenths of a degree near its ends, so the curve itself is checked.
    pub(crate) fn around(
        &self,
        from: &Station,
        to: &Station,
        reach: Option<&AxisReach<'_>>,
    ) -> Option<Vec<Station>> {
        let over = |axes: &[UnitVector3<f64>], reach: Option<&AxisReach<'_>>| {
            (0..RAISES).find_map(|raise| {
                let stations =
                    self.stations([from, to], axes, self.options.clearance * f64::from(raise));
                let curve = PoseCurve::through(&stations, self.lever);
                let within = reach.is_none_or(|reach| reach.holds_on(&curve));
                (within && self.keeps_off(curve)).then_some(stations)
            })
        };
        let ends = [&from.pose.axis, &to.pose.axis];
        let direct = direct(ends);
        let Some(reach) = reach else { return over(&direct, None) };
        let first = reach.holds(&direct).then(|| over(&direct, Some(reach))).flatten();
        let others = || corners(ends, reach).iter().find_map(|axes| over(axes, Some(reach)));
        // If no turn is within reach, the direct one is returned; the check of the axes then reports
        // the missing travel.
        first.or_else(others).or_else(|| over(&direct, None))
    }

    fn stations(
        &self,
        [from, to]: [&Station; 2],
        axes: &[UnitVector3<f64>],
        raise: f64,
    ) -> Vec<Station> {
        // The tip advances in proportion to the angle turned so far.
        let turns: Vec<f64> = axes.windows(2).map(|a| angle_between(&a[0], &a[1])).collect();
        let all: f64 = turns.iter().sum();
        let tips = [from.pose.tip, to.pose.tip];
        let mut stations = vec![*from];
        let mut gone = 0.0;
        for (pair, turn) in axes.windows(2).zip(&turns) {
            let count = steps(*turn);
            for step in 1..=count {
                let share = f64::from(step) / f64::from(count);
                let Some(axis) = great_circle(&pair[0], &pair[1], share) else { continue };
                let whole = if all > 0.0 { (gone + share * turn) / all } else { share };
                stations.push(self.lifted(tips[0] + (tips[1] - tips[0]) * whole, axis, raise));
            }
            gone += turn;
        }
        // The last of them is at the end of the link, which takes its place.
        stations.pop();
        stations.push(*to);
        stations
    }

    /// Returns a station at the point, raised along the axis until it is above the part.
    fn lifted(&self, tip: Point3<f64>, axis: UnitVector3<f64>, raise: f64) -> Station {
        // Height of the part along this axis, less the height of the tip.
        let missing = self.height(&axis) + raise - tip.coords.dot(&axis);
        let tip = tip + axis.scale(missing.max(0.0));
        Station { pose: ToolPose { tip, axis }, contact: tip }
    }

    /// Proves that the tool keeps a share of the clearance from all faces on a curve.
    fn keeps_off(&self, curve: PoseCurve) -> bool {
        let spans = curve.spans.len();
        if !curve.knots.iter().all(|knot| knot.is_finite()) {
            return false;
        }
        let sweep = PassSweep::of(curve, self.lever);
        let [kept, precision] = [KEPT, PRECISION].map(|share| share * self.options.clearance);
        self.faces.iter().zip(&self.trees).all(|(face, tree)| {
            let (target, tool, chart) = (kept, &self.tool, &self.chart);
            let clearance = ClearanceProof { face, chart, tree, tool, target, precision };
            (0..spans)
                .all(|span| clearance.least(&sweep, span, SpanTimes::Slabs(1)) >= kept - precision)
        })
    }
}

/// Returns the axes of the shortest turn, ends included.
fn direct([from, to]: [&UnitVector3<f64>; 2]) -> Vec<UnitVector3<f64>> {
    match corner(from, to) {
        Some(corner) => vec![*from, corner, *to],
        None => vec![*from, *to],
    }
}

/// Returns the turns over one axis near home, ends included, the shortest first. The machine
/// reaches all axes in between.
fn corners(
    [from, to]: [&UnitVector3<f64>; 2],
    reach: &AxisReach<'_>,
) -> Vec<Vec<UnitVector3<f64>>> {
    let over = reach.around_home().map(|corner| vec![*from, corner, *to]);
    let mut routes: Vec<_> = over.filter(|axes| reach.holds(axes)).collect();
    let length = |axes: &Vec<UnitVector3<f64>>| -> f64 {
        axes.windows(2).map(|pair| angle_between(&pair[0], &pair[1])).sum()
    };
    routes.sort_by(|a, b| length(a).total_cmp(&length(b)));
    routes
}

/// Returns a direction between two opposite ones, which no great circle joins.
fn corner(from: &UnitVector3<f64>, to: &UnitVector3<f64>) -> Option<UnitVector3<f64>> {
    (angle_between(from, to) > PI - STEP).then(|| {
        // The two are nearly parallel, so any direction square to one serves for both.
        let side = from.cross(&Vector3::ith(from.iamin(), 1.0));
        Unit::new_normalize(side)
    })
}

fn steps(turn: f64) -> u32 {
    let fits = |count: &u32| turn <= STEP * f64::from(*count);
    (LEAST_STEPS..MOST_STEPS).find(fits).unwrap_or(MOST_STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_axes_turn_over_a_corner() {
        let z = Vector3::z_axis();
        let corner = corner(&z, &-z).unwrap();
        assert!(corner.dot(&z).abs() < 1e-15);
        assert_eq!(steps(0.0), 2);
        assert_eq!(steps(PI / 2.0), 6);
    }
}
