//! Two bodies on different links: their distance at a position, and how far it can change from there.

use super::linked::LinkedBody;
use crate::machine::{Axis, AxisKind, Machine, joint_motion};
use crate::types::AxisVector;
use crate::verify::swept::triangles::{GapGoal, MeshGap, MeshPair, SweptGap, SweptTravel};
use nalgebra::{Isometry3, Point3, Unit, UnitVector3, Vector3};

/// Two bodies, the one nearer to the workpiece in the chain first, and the joints between them.
#[derive(Debug, Clone)]
pub(crate) struct BodyPair<'a> {
    pub(crate) bodies: [&'a LinkedBody; 2],
    /// Axes between them from the first to the second, with their indices.
    joints: Vec<(usize, &'a Axis)>,
}

/// Positions of the axes that a box of positions holds: its middle, and half its size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointBox {
    pub(crate) middle: AxisVector,
    pub(crate) half: AxisVector,
}

impl<'a> BodyPair<'a> {
    pub(crate) fn new(machine: &'a Machine, bodies: [&'a LinkedBody; 2]) -> Self {
        let [a, b] = bodies;
        let bodies = if a.link <= b.link { [a, b] } else { [b, a] };
        let indices = machine.joints();
        let between = indices.iter().take(bodies[1].link).skip(bodies[0].link);
        let joints =
            between.filter_map(|index| Some((*index, machine.axes.get(*index)?))).collect();
        Self { bodies, joints }
    }

    /// Returns the indices of the axes between the bodies.
    pub(crate) fn axes(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(index, _)| *index)
    }

    /// Returns the place of the second body in the frame of the first.
    fn place(&self, q: &AxisVector) -> Isometry3<f64> {
        let motions = self.joints.iter().map(|(index, axis)| joint_motion(axis, q[*index]));
        motions.fold(Isometry3::identity(), |place, motion| place * motion)
    }

    fn meshes(&self, q: &AxisVector) -> MeshPair<'a> {
        let [first, second] = self.bodies;
        MeshPair::new(&first.shell, &second.shell, self.place(q))
    }

    /// Returns what the real bodies may be nearer than their triangles \[mm\].
    fn allowance(&self) -> f64 {
        self.bodies.iter().map(|body| body.allowance).sum()
    }

    /// Returns the gap at a position, if it is below `cap` \[mm\], to within `slack`, and the triangles that it is between.
    pub(crate) fn gap(
        &self,
        q: &AxisVector,
        [cap, slack]: [f64; 2],
        hint: Option<[u32; 2]>,
    ) -> Option<MeshGap> {
        let found = self.meshes(q).gap(cap + self.allowance(), slack, hint)?;
        Some(MeshGap { distance: found.distance - self.allowance(), ..found })
    }

    /// Bounds the gap over a box by a goal, whose travel is that of the box; points are in the frame of the first body.
    pub(crate) fn swept(&self, area: &JointBox, goal: GapGoal) -> Option<SweptGap> {
        let allowance = self.allowance();
        let travel = self.swept_travel(area);
        let goal = GapGoal { cap: goal.cap + allowance, travel, ..goal };
        let SweptGap { gap, low } = self.meshes(&area.middle).swept(goal)?;
        let gap = MeshGap { distance: gap.distance - allowance, ..gap };
        Some(SweptGap { gap, low: low.map(|low| low - allowance) })
    }

    /// Bounds the travel of the second body against the first, from the middle of a box to anywhere in it.
    fn swept_travel(&self, area: &JointBox) -> SweptTravel {
        let along = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()]
            .map(|across| self.travel(area, &across));
        SweptTravel { along: along.into(), most: self.spread(area) }
    }

    /// Bounds the distance anywhere in a box from below by two parallel planes between the bodies, across the gap in its
    /// middle \[mm\].
    ///
    /// It is sharp where bodies slide along a plane or turn about its normal, which changes nothing.
    pub(crate) fn between_planes(&self, area: &JointBox, gap: &MeshGap) -> f64 {
        let across = Unit::try_new(gap.ends[1] - gap.ends[0], f64::MIN_POSITIVE);
        across.map_or(f64::NEG_INFINITY, |across| self.apart_along(area, &across))
    }

    /// Bounds the distance anywhere in a box from below by planes across the coordinate axes of both links \[mm\]: bodies of
    /// machines slide and turn along these.
    pub(crate) fn between_axis_planes(&self, area: &JointBox) -> f64 {
        let turn = self.place(&area.middle).rotation;
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let all = axes.into_iter().chain(axes.map(|axis| turn * axis));
        let both = all.flat_map(|across| [across, -across]);
        both.map(|across| self.apart_along(area, &across)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Bounds the distance anywhere in a box from below by two planes across a direction \[mm\].
    fn apart_along(&self, area: &JointBox, across: &UnitVector3<f64>) -> f64 {
        let [first, second] = self.bodies;
        let place = self.place(&area.middle);
        // The second body is beyond the first along the direction.
        let back = place.rotation.inverse() * across;
        let reach = |body: &LinkedBody, along: &Vector3<f64>| {
            let points = body.shell.mesh().vertices.iter().map(|p| p.coords.dot(along));
            points.fold(f64::NEG_INFINITY, f64::max)
        };
        let lowest = place.translation.vector.dot(across) - reach(second, &-back.into_inner());
        let apart = lowest - reach(first, across) - self.allowance();
        apart - self.travel(area, across)
    }

    /// Bounds the travel of points of the second body along a direction of the frame of the first, from the middle of a box
    /// to anywhere in it \[mm\].
    ///
    /// From the outermost joint inwards, the direction is carried back to the middle of each. A travel of `h` along `d` adds
    /// `h |n d|`. A turn by `h` about `a` turns `n` by at most `h |n x a|`, square to `a`, and adds that times the distance of
    /// the farthest point from the line.
    fn travel(&self, area: &JointBox, across: &UnitVector3<f64>) -> f64 {
        // Distance of the body's middle from each line, and how far its points may have moved before it.
        let mut steps: Vec<(f64, &Axis, f64)> = Vec::with_capacity(self.joints.len());
        let body = self.bodies[1];
        let (mut middle, mut moved) = (body.middle, 0.0);
        for (index, axis) in self.joints.iter().rev() {
            let half = area.half[*index];
            let lever = off_line(&middle, axis) + body.reach + moved;
            moved += if axis.kind == AxisKind::Linear { half } else { half * lever };
            middle = joint_motion(axis, area.middle[*index]) * middle;
            steps.push((half, axis, lever));
        }
        let mut along = *across;
        let mut sum = 0.0;
        for ((index, _), (half, axis, lever)) in self.joints.iter().zip(steps.iter().rev()) {
            match axis.kind {
                AxisKind::Linear => sum += half * along.dot(&axis.dir).abs(),
                AxisKind::Rotary => {
                    sum += half * along.cross(&axis.dir).norm() * lever;
                    along = joint_motion(axis, area.middle[*index]).rotation.inverse() * along;
                }
            }
        }
        sum
    }

    /// Divides a box across the axis between the bodies that moves them farthest.
    pub(crate) fn halves(&self, area: &JointBox) -> [JointBox; 2] {
        let alone = |index: usize| {
            let mut half = AxisVector::zeros();
            half[index] = area.half[index];
            self.spread(&JointBox { half, ..*area })
        };
        let farthest = self.axes().max_by(|a, b| alone(*a).total_cmp(&alone(*b)));
        [-0.5, 0.5].map(|side| {
            let mut part = *area;
            if let Some(index) = farthest {
                part.middle[index] += side * area.half[index];
                part.half[index] *= 0.5;
            }
            part
        })
    }

    /// Returns true if the bodies touch or overlap.
    pub(crate) fn touches(&self, q: &AxisVector, tolerance: f64) -> bool {
        self.gap(q, [tolerance, 0.0], None).is_some() || self.meshes(q).is_inside()
    }

    /// Returns true if one body is inside the other.
    pub(crate) fn is_inside(&self, q: &AxisVector) -> bool {
        self.meshes(q).is_inside()
    }

    /// Bounds how far points of one body move against the other, from the middle of a box to anywhere in it \[mm\].
    ///
    /// The bound holds for either body seen from the other: the smaller one is taken.
    pub(crate) fn spread(&self, area: &JointBox) -> f64 {
        let [first, second] = self.bodies;
        let outwards = spread(second, self.joints.iter().rev(), area, 1.0);
        let inwards = spread(first, self.joints.iter(), area, -1.0);
        outwards.min(inwards)
    }
}

/// Bounds the motion of a body by joints, from the one next to it on.
///
/// Induction over the joints: if the points of the body are moved by at most `m` before a joint, a travel of `h` adds `h`,
/// and a turn by `h` adds at most `h` times the distance of the farthest point from the line, wherever it has moved to.
fn spread<'a>(
    body: &LinkedBody,
    joints: impl Iterator<Item = &'a (usize, &'a Axis)>,
    area: &JointBox,
    sign: f64,
) -> f64 {
    let mut middle = body.middle;
    let mut moved = 0.0;
    for (index, axis) in joints {
        let half = area.half[*index];
        match axis.kind {
            AxisKind::Linear => moved += half,
            AxisKind::Rotary => moved += half * (off_line(&middle, axis) + body.reach + moved),
        }
        middle = joint_motion(axis, sign * area.middle[*index]) * middle;
    }
    moved
}

/// Returns the distance of a point from the line of a rotary axis \[mm\].
fn off_line(point: &Point3<f64>, axis: &Axis) -> f64 {
    (point - axis.point).cross(&axis.dir).norm()
}
