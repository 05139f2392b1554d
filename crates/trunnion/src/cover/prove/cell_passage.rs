//! Passage of a cutter over a cell: proves that the whole cell was inside.
//!
//! The cutter is convex, so a cell is inside if its corners are, by more than the cell bows. Every corner may have its
//! own time, as long as the tool between those times bows little as well.

use crate::cover::prove::deepest::deepest;
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::ConvexSolid;
use crate::math::hypot;
use crate::types::Interval;
use nalgebra::Vector3;

/// Cell of a raised face, and a pass of the cutter over it.
pub(crate) struct CellPassage<'a> {
    pub(crate) end: &'a ConvexSolid,
    pub(crate) cell: &'a FaceCell,
    pub(crate) sweep: &'a PassSweep,
}

/// Times of the corners: lower-lower, lower-upper, upper-lower, upper-upper.
type CornerTimes = [f64; 4];

/// Corners of a cell as the tool sees them at their times.
struct SeenCorners {
    times: CornerTimes,
    /// Vectors from the tip.
    from_tip: [Vector3<f64>; 4],
    /// Largest distance of a corner from the cutter \[mm\].
    highest: f64,
}

impl CellPassage<'_> {
    /// Returns `true` if the cell is proven to be inside the cutter about the time `start`; `None` where there is no
    /// pose.
    pub(crate) fn is_inside(&self, start: f64) -> Option<bool> {
        let Self { end, cell, sweep } = *self;
        let centre = cell.centre();
        let (u, here) = deepest(sweep, end, &centre, start)?;
        if end.distance(&centre, &here.pose) > 0.0 {
            return Some(false);
        }
        // First at one instant. Where the cutter hardly moves, as about a pole, the deepest times of neighbouring points
        // lie far apart, and the bounds over the time between them prove nothing.
        if self.holds([u; 4])? {
            return Some(true);
        }
        // Guess for each corner: the time at which the cutter has moved on by its offset.
        // Time in which the cutter moves on by a vector: its component along the velocity over the
        // speed.
        let pace = here.velocity / here.velocity.norm_squared().max(f64::MIN_POSITIVE);
        let Interval { low, high } = sweep.curve.range();
        let corners = cell.corners();
        let mut times = corners.map(|corner| (u + (corner - centre).dot(&pace)).clamp(low, high));
        // Then with guessed times; only if that fails, with the deepest time of each corner.
        if self.holds(times)? {
            return Some(true);
        }
        for (time, corner) in times.iter_mut().zip(&corners) {
            *time = deepest(sweep, end, corner, *time)?.0;
        }
        self.holds(times)
    }

    /// Returns `true` if all corners, at their times, are inside the cutter by more than anything
    /// bows.
    fn holds(&self, times: CornerTimes) -> Option<bool> {
        let seen = self.seen(times)?;
        if seen.highest > 0.0 {
            return Some(false);
        }
        let bows = self.bows(&seen);
        if seen.highest + bows[0] + bows[1] <= 0.0 {
            return Some(true);
        }
        // The bows as the tool sees them take five more poses.
        let less = self.bows_seen(times)?;
        Some(seen.highest + bows[0].min(less[0]) + bows[1].min(less[1]) <= 0.0)
    }

    fn seen(&self, times: CornerTimes) -> Option<SeenCorners> {
        let mut seen =
            SeenCorners { times, from_tip: [Vector3::zeros(); 4], highest: f64::NEG_INFINITY };
        for ((corner, time), from_tip) in
            self.cell.corners().iter().zip(times).zip(&mut seen.from_tip)
        {
            let pose = self.sweep.curve.pose(time)?;
            seen.highest = seen.highest.max(self.end.distance(corner, &pose));
            *from_tip = corner - pose.tip;
        }
        Some(seen)
    }

    /// Bounds the deviation of the cell from the hull of its corners, as the moving tool sees it, by either parameter
    /// \[mm\]: what the face bends, and what the tool turns and bends meanwhile.
    fn bows(&self, seen: &SeenCorners) -> [f64; 2] {
        let SeenCorners { times, from_tip, .. } = seen;
        let (first, last) = earliest_and_latest(times);
        let bend = self.sweep.bend_between(first, last);
        let far = from_tip.iter().map(Vector3::norm).fold(0.0, f64::max);
        // Between two corners with times t0 and t1 the image deviates from the chord by its sag,
        // the second-order motion of the tip, and the turn over the distance, each over 8.
        [0, 1].map(|k| {
            let sag = self.cell.sag(k);
            let of = |[i, j]: [usize; 2]| {
                let time = (times[j] - times[i]).abs();
                let apart = (from_tip[j] - from_tip[i]).norm();
                let tip = bend.tip * time * time;
                // Second-order terms of a product: the turn times the change of the point seen from
                // the tool.
                let turning = 2.0 * bend.turn * time * (apart + 8.0 * sag + tip);
                tip + turning + (bend.twist + bend.turn * bend.turn) * time * time * far
            };
            sag + 0.125 * opposite(k).map(of).into_iter().fold(0.0, f64::max)
        })
    }

    /// Bounds the same deviation by what the tool sees of it in the half plane through its axis; infinite about
    /// the axis. Where face and motion bend alike, as on a ring about an axis, it is far less than either bends.
    ///
    /// The distance from the cutter is convex in that half plane, and 1-Lipschitz. As in [`FaceCell::sag`], second
    /// differences of three points, taken whole, allow twice the mean second derivative. A motion that is no single
    /// cubic adds what its third derivative jumps ([`PassSweep::unevenness`]).
    fn bows_seen(&self, times: CornerTimes) -> Option<[f64; 2]> {
        let [a, b, c, d] = times;
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        // The time is bilinear over the cell.
        let grid = [
            [a, mean(a, b), b],
            [mean(a, c), mean(mean(a, b), mean(c, d)), mean(b, d)],
            [c, mean(c, d), d],
        ];
        let mut seen = [[[0.0; 2]; 3]; 3];
        let mut from_tip = [[Vector3::zeros(); 3]; 3];
        let mut nearest = f64::INFINITY;
        for (i, row) in grid.iter().enumerate() {
            for (j, time) in row.iter().enumerate() {
                let pose = self.sweep.curve.pose(*time)?;
                let q = self.cell.points[i][j] - pose.tip;
                let z = q.dot(&pose.axis);
                let rho = (q.norm_squared() - z * z).max(0.0).sqrt();
                (seen[i][j], from_tip[i][j]) = ([rho, z], q);
                nearest = nearest.min(rho);
            }
        }
        let largest = |of: &dyn Fn(&Vector3<f64>) -> f64| {
            from_tip.iter().flatten().map(of).fold(0.0, f64::max)
        };
        let centre = from_tip[1][1];
        let (far, reach) = (largest(&|q| q.norm()), largest(&|q| (q - centre).norm()));
        let reach = reach.max(self.cell.radius());
        // About the axis the distance from it is not smooth.
        if nearest <= reach {
            return Some([f64::INFINITY; 2]);
        }
        // One cubic for all times of the cell. The axis vector of a spline is at least half a unit long, so the axis
        // deviates by twice as much; it counts with the distance from the tip, which changes by less than the cell's reach.
        let (first, last) = earliest_and_latest(&times);
        let [tip, axis] = self.sweep.unevenness(first, last);
        let uneven = tip + 2.0 * axis * (far + 2.0 * reach);
        let line = |k: usize, i: usize| {
            [0, 1, 2].map(|j: usize| if k == 0 { seen[j][i] } else { seen[i][j] })
        };
        Some([0, 1].map(|k| {
            let sag = (0..3).map(|i| second_difference(line(k, i))).fold(0.0, f64::max);
            let time = |[i, j]: [usize; 2]| (times[j] - times[i]).abs();
            let time = opposite(k).map(time).into_iter().fold(0.0, f64::max);
            sag + 0.125 * uneven * time * time
        }))
    }
}

/// Returns the earliest and the latest of some times.
fn earliest_and_latest(times: &CornerTimes) -> (f64, f64) {
    times.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(*u), b.max(*u)))
}

/// Returns the pairs of corners that differ by parameter `k`.
fn opposite(k: usize) -> [[usize; 2]; 2] {
    if k == 0 { [[0, 2], [1, 3]] } else { [[0, 1], [2, 3]] }
}

/// Returns the size of the second difference of three points.
fn second_difference([a, b, c]: [[f64; 2]; 3]) -> f64 {
    hypot(a[0] - 2.0 * b[0] + c[0], a[1] - 2.0 * b[1] + c[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Cutter, CutterSpec, ToolBody};
    use crate::types::{PoseCurve, Station, ToolPose};
    use nalgebra::{Point3, UnitVector3};

    /// Radius of the sphere that is cut, and of the ring on which the contacts lie.
    const SPHERE: f64 = 25.0;

    /// Corner radius of the cutter.
    const MINOR: f64 = 2.5;

    /// Returns the point of the sphere, raised by `height`, at a latitude and a longitude.
    fn at(height: f64, [latitude, longitude]: [f64; 2]) -> Point3<f64> {
        let (sin, cos) = latitude.sin_cos();
        let (y, x) = longitude.sin_cos();
        Point3::from(Vector3::new(cos * x, cos * y, sin) * (SPHERE + height))
    }

    /// Returns a ring pass of a bull-nose cutter round the sphere at 0.6 rad. With a wobble every other station is
    /// lifted by that \[mm\].
    fn ring(cutter: &Cutter, wobble: f64) -> PassSweep {
        let station = |i: i32| {
            let longitude = 0.05 * f64::from(i);
            let contact = at(0.0, [0.6, longitude]);
            let normal = contact.coords / SPHERE;
            let east = Vector3::new(-longitude.sin(), longitude.cos(), 0.0);
            let lead = 0.06_f64;
            let axis = UnitVector3::new_normalize(normal * lead.cos() + east * lead.sin());
            // Centre of the ring's tube, then to the axis, then down to the tip.
            let out = UnitVector3::new_normalize(normal - *axis * normal.dot(&axis));
            let lift = if i % 2 == 0 { 0.0 } else { wobble };
            let tip = contact + normal * (MINOR + lift)
                - out.scale(cutter.radius() - MINOR)
                - axis.scale(MINOR);
            Station { pose: ToolPose { tip, axis }, contact }
        };
        let stations: Vec<Station> = (-12..=12).map(station).collect();
        PassSweep::of(PoseCurve::through(&stations, cutter.radius()), cutter.radius())
    }

    /// Whatever is called inside was inside at all points, by brute force over the time; long cells along the ring are
    /// inside by what the tool sees alone.
    #[test]
    fn cells_along_a_ring_are_inside_only_if_all_their_points_are() {
        let cutter = Cutter::new(CutterSpec::of_radii(7.5, MINOR)).unwrap();
        let end = ToolBody::new(&cutter).end;
        let (mut proven, mut long, mut refused) = (0, 0, 0);
        for k in 0..720_u32 {
            let wobble = [0.0, 1e-5, 2e-3, 0.02][k as usize % 4];
            let sweep = ring(&cutter, wobble);
            let height = [0.004, 0.02, 0.08][k as usize / 4 % 3];
            let (wide, length) = (0.002 * f64::from(k % 5 + 1), 0.02 * f64::from(k % 11 + 1));
            let low = 0.6 - 0.2 + 0.4 * f64::from(k % 40) / 40.0;
            let range =
                [[low, low + wide], [0.025 * f64::from(k % 7), 0.025 * f64::from(k % 7) + length]];
            let raised = |place: [f64; 2]| at(height, place);
            let cell = FaceCell::new(range, &raised);
            let passage = CellPassage { end: &end, cell: &cell, sweep: &sweep };
            let centre = cell.centre();
            let depth = |place: &Point3<f64>, u: f64| {
                sweep.curve.pose(u).map_or(f64::INFINITY, |pose| end.distance(place, &pose))
            };
            let times = || sweep.poses.iter().map(|(u, _)| *u);
            let start = times().min_by(|a, b| depth(&centre, *a).total_cmp(&depth(&centre, *b)));
            let Some(start) = start else { continue };
            if !passage.is_inside(start).unwrap() {
                refused += 1;
                continue;
            }
            proven += 1;
            long += i32::from(cell.extent(1) > 8.0 * cell.extent(0));
            for i in 0..=6 {
                for j in 0..=12 {
                    let share = |[a, b]: [f64; 2], s: f64| a + (b - a) * s;
                    let place = raised([
                        share(range[0], f64::from(i) / 6.0),
                        share(range[1], f64::from(j) / 12.0),
                    ]);
                    let near = (-600..=600).map(|n| start + 0.01 * f64::from(n));
                    let least = near.map(|u| depth(&place, u)).fold(f64::INFINITY, f64::min);
                    assert!(least <= 1e-9, "{k} at {i} {j}: {least}");
                }
            }
        }
        assert!(proven > 100 && refused > 100 && long > 40, "{proven} {refused} {long}");
    }

    /// Every other station is lifted by more than the excess. A cell whose corners and middle lie at the others is not
    /// called inside, though the second differences see nothing.
    #[test]
    fn a_wobble_between_the_points_of_a_cell_is_not_overlooked() {
        let cutter = Cutter::new(CutterSpec::of_radii(7.5, MINOR)).unwrap();
        let end = ToolBody::new(&cutter).end;
        let inside = |wobble: f64| {
            let sweep = ring(&cutter, wobble);
            let cell = FaceCell::new([[0.5995, 0.6005], [-0.1, 0.1]], &|place| at(0.004, place));
            let passage = CellPassage { end: &end, cell: &cell, sweep: &sweep };
            let middle = 0.5 * (sweep.curve.range().low + sweep.curve.range().high);
            passage.is_inside(middle).unwrap()
        };
        assert!(inside(0.0) && inside(1e-5));
        assert!(!inside(0.008) && !inside(0.02));
    }
}
