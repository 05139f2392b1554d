//! Cell of a face that moves past a solid: the point of it that comes nearest, at the time when it does.

use crate::cover::prove::face_cell::FaceCell;
use crate::cutter::{ConvexSolid, SignedDistance};
use crate::types::ToolPose;
use nalgebra::{Point3, Vector3};

/// Steps of the search for the nearest point. For a ball the first one finds it.
const STEPS: u32 = 3;

/// Rounds over the three parameters in one step.
const ROUNDS: u32 = 2;

/// Remainder at which the search ends, as a share of the cell's size.
const SMALL: f64 = 1e-3;

/// Bilinear image of a cell that moves to first order, seen from the tool in the middle of the time.
#[derive(Debug, Clone, Copy)]
pub(super) struct SweptCell<Motion> {
    centre: Point3<f64>,
    /// Changes by either parameter, from the middle to an end \[mm\], and what both together add.
    sides: [Vector3<f64>; 2],
    twist: Vector3<f64>,
    /// Motion of a point from the middle of the time to its end.
    motion: Motion,
}

/// Point of a cell, and time, at which it comes nearest to a solid, as far as it was searched.
#[derive(Debug, Clone, Copy)]
pub(super) struct SweptPoint {
    pub(super) point: Point3<f64>,
    pub(super) gap: SignedDistance,
    /// Amount by which other points may be nearer, by either parameter and by time \[mm\].
    pub(super) left: [f64; 3],
}

impl<Motion: Fn(&Point3<f64>) -> Vector3<f64>> SweptCell<Motion> {
    pub(super) fn new(cell: &FaceCell, motion: Motion) -> Self {
        let [a, b, c, d] = cell.corners().map(|corner| corner.coords);
        let centre = Point3::from(0.25 * (a + b + c + d));
        let sides = [0.25 * ((c - a) + (d - b)), 0.25 * ((b - a) + (d - c))];
        Self { centre, sides, twist: 0.25 * ((a - b) + (d - c)), motion }
    }

    /// Searches the point that is nearest to a solid. What is found lies on the cell; nothing promises that it is the
    /// nearest one.
    ///
    /// Projections in turn: the point of the solid's core next to the cell's point, then the point of the flat cell next to
    /// that one. Between two convex sets this never leads away; where the twist of the cell or an early end of the rounds
    /// does, the better point stays.
    pub(super) fn nearest(&self, solid: &ConvexSolid, pose: &ToolPose) -> SweptPoint {
        let moved = (self.motion)(&self.centre);
        let ways = [self.sides[0], self.sides[1], moved];
        let squares = ways.map(|way| way.norm_squared());
        let core = solid.inner_radius();
        let mut place = [0.0; 3];
        let mut found = self.at(place, solid, pose, &ways);
        for _ in 0..STEPS {
            let SignedDistance { distance, gradient } = found.gap;
            let goal = found.point - gradient * (distance + core);
            let mut off = goal - (self.centre + linear(&ways, place));
            for _ in 0..ROUNDS {
                for k in [2, 0, 1] {
                    if squares[k] > 0.0 {
                        let next = (place[k] + off.dot(&ways[k]) / squares[k]).clamp(-1.0, 1.0);
                        off -= ways[k] * (next - place[k]);
                        place[k] = next;
                    }
                }
            }
            let next = self.at(place, solid, pose, &ways);
            let gained = found.gap.distance - next.gap.distance;
            if gained > 0.0 {
                found = next;
            }
            if gained <= SMALL * found.left.iter().sum::<f64>() {
                break;
            }
        }
        found
    }

    /// Measures the point at a place: the share of either parameter, and of the time, in `[-1, 1]`.
    fn at(
        &self,
        place: [f64; 3],
        solid: &ConvexSolid,
        pose: &ToolPose,
        ways: &[Vector3<f64>; 3],
    ) -> SweptPoint {
        let [a, b, time] = place;
        let still = self.centre + self.sides[0] * a + self.sides[1] * b + self.twist * (a * b);
        let point = still + (self.motion)(&still) * time;
        let gap = solid.gap(&point, pose);
        // How far the tangent plane falls from here to the end of each parameter to which it falls.
        let left = [0, 1, 2].map(|k| {
            let slope = gap.gradient.dot(&ways[k]);
            slope.abs() + slope * place[k]
        });
        SweptPoint { point, gap, left }
    }
}

/// Returns the change from the middle to a place, to first order.
fn linear(ways: &[Vector3<f64>; 3], place: [f64; 3]) -> Vector3<f64> {
    ways[0] * place[0] + ways[1] * place[1] + ways[2] * place[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Cutter, CutterSpec, ToolBody};
    use nalgebra::Unit;

    /// Cells all round the tool, moving every way, against a grid of their points and times.
    #[test]
    fn the_point_found_is_on_the_cell_and_about_the_nearest_one() {
        const N: i32 = 16;
        let specs = [[0.0, 4.0], [3.0, 1.0], [4.0, 0.0]];
        let axis = Unit::new_normalize(Vector3::new(0.2, -0.3, 0.9));
        let pose = ToolPose { tip: Point3::new(1.0, 2.0, 3.0), axis };
        let (mut all, mut best) = (0, 0);
        for [major, minor] in specs {
            let tool = ToolBody::new(&Cutter::new(CutterSpec::of_radii(major, minor)).unwrap());
            for k in 0..200 {
                let part = |n: u32| f64::from(k * n % 97) / 48.5 - 1.0;
                let out = Vector3::new(part(31), part(17), part(53)).normalize();
                let middle = pose.tip + axis.into_inner() * minor + out * (major + minor + 0.2);
                let (u, v) = (Vector3::new(part(7), part(11), part(13)), out.cross(&Vector3::x()));
                let twist = out * (0.3 * part(3));
                let at =
                    |[a, b]: [f64; 2]| middle + u * (a - 0.5) + v * (b - 0.5) + twist * (a * b);
                let cell = FaceCell::new([[0.0, 1.0]; 2], &at);
                let velocity = Vector3::new(part(19), part(23), part(29)) * 0.5;
                let moved = |p: &Point3<f64>| velocity + out.cross(&(p - pose.tip)) * 0.02;
                let found = SweptCell::new(&cell, moved).nearest(&tool.end, &pose);
                assert_eq!(found.gap, tool.end.gap(&found.point, &pose));
                let share = |i: i32| f64::from(i) / f64::from(N);
                let (mut least, mut off) = (f64::INFINITY, f64::INFINITY);
                for i in 0..(N + 1).pow(3) {
                    let [a, b, t] = [i % (N + 1), i / (N + 1) % (N + 1), i / (N + 1).pow(2)];
                    let still = at([share(a), share(b)]);
                    let point = still + moved(&still) * (2.0 * share(t) - 1.0);
                    least = least.min(tool.end.distance(&point, &pose));
                    off = off.min((point - found.point).norm());
                }
                assert!(off < 0.2, "{k}: {off}");
                // Inside the core no ball touches; what goes in that deep is a breach anyway.
                if least > -0.5 * minor {
                    all += 1;
                    // The grid, and what the twist adds, are some hundredths; a bound need not start from the nearest.
                    best += u32::from(found.gap.distance <= least + 0.02);
                }
            }
        }
        assert!(all > 200 && best * 10 >= all * 9, "{best} of {all}");
    }
}
