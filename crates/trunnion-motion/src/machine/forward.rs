//! The chain seen from the workpiece, and its forward map.

use super::checked::{Axis, FIRST_ROTARY, Machine, SECOND_ROTARY};
use crate::math;
use crate::types::{AxisVector, ToolPose};
use nalgebra::{Matrix3, Point3, Rotation3, UnitVector3, Vector3};

/// Position of the workpiece in the machine, and the tool length.
///
/// The default is a workpiece at the machine origin, not rotated, and a tool of no length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setup {
    /// Workpiece origin in machine coordinates with all axes at zero \[mm\].
    pub origin: Vector3<f64>,
    /// `machine_from_workpiece` with all axes at zero.
    pub rotation: Rotation3<f64>,
    /// Gauge point to tip \[mm\].
    pub tool_length: f64,
}

impl Setup {
    /// Creates a setup from its origin \[mm\] and its rotation \[rad\] about the fixed x, then y, then z.
    pub fn new(origin: Vector3<f64>, rotation: [f64; 3], tool_length: f64) -> Self {
        let [x, y, z] = rotation;
        Self { origin, rotation: math::rotation_of_xyz([x, y, z].into()), tool_length }
    }
}

/// A rotary axis in the workpiece frame at q = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryJoint {
    /// Direction about which +q turns the tool relative to the workpiece; `sense` is in it.
    pub dir: UnitVector3<f64>,
    /// A point of the line \[mm\].
    pub point: Vector3<f64>,
}

/// The chain in the workpiece frame at q = 0: all that the forward map and its inverse need.
///
/// With `l = (X, Y, Z)` and rotations `R1`, `R2` about the two rotary axes through `p1`, `p2`:
///
/// ```text
/// tip  = S0 l + p1 + R1 (S1 l + p2 - p1 + R2 (S2 l + tip0 - p2))
/// axis = R1 R2 axis0
/// ```
///
/// where `S0`, `S1`, `S2` hold the directions of the linear axes that stand before, between and
/// after the rotaries (other columns zero). The setup is inside: rotating a chain as a whole is
/// again a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChainGeometry {
    /// Workpiece side first.
    pub rotary: [RotaryJoint; 2],
    /// `S0`, `S1`, `S2`.
    pub slides: [Matrix3<f64>; 3],
    /// Number of rotaries between the workpiece and each of X, Y, Z.
    pub stage: [usize; 3],
    /// Tip at q = 0 \[mm\].
    pub tip: Vector3<f64>,
    /// Tool axis at q = 0, tip to spindle.
    pub axis: UnitVector3<f64>,
}

/// Forward map of a machine with a setup: axes -> tool pose in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    machine: Machine,
    setup: Setup,
    chain: ChainGeometry,
}

impl Kinematics {
    /// Transforms a machine's chain into the workpiece frame of a setup.
    pub fn new(machine: &Machine, setup: &Setup) -> Self {
        // The setup is a rigid motion of the whole chain: points are moved, directions only turned. After this
        // nothing refers to the machine frame.
        let workpiece_from_machine = setup.rotation.inverse();
        let place = |point: &Point3<f64>| workpiece_from_machine * (point.coords - setup.origin);
        let turn = |axis: &Axis| workpiece_from_machine * axis.dir.scale(axis.sense);
        let [x, y, z, first, second] = &machine.axes;
        let joint = |axis: &Axis| RotaryJoint {
            dir: UnitVector3::new_normalize(turn(axis)),
            point: place(&axis.point),
        };
        let linear = [turn(x), turn(y), turn(z)];
        // Each linear axis has its column in the matrix of its stage, and zeros in the two others.
        let slides = [0, 1, 2].map(|stage| {
            let column = |axis: usize| {
                let here = machine.stage.get(axis) == Some(&stage);
                linear.get(axis).copied().filter(|_| here).unwrap_or_default()
            };
            Matrix3::from_columns(&[column(0), column(1), column(2)])
        });
        let tip = machine.gauge - machine.tool_axis.scale(setup.tool_length);
        let chain = ChainGeometry {
            rotary: [joint(first), joint(second)],
            slides,
            stage: machine.stage,
            tip: place(&tip),
            axis: workpiece_from_machine * machine.tool_axis,
        };
        Self { machine: machine.clone(), setup: *setup, chain }
    }

    /// Returns the machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Returns the setup.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Returns the chain in the workpiece frame.
    pub fn chain(&self) -> &ChainGeometry {
        &self.chain
    }

    /// Returns the tool pose in the workpiece frame. Total: every `q` has a pose.
    pub fn forward(&self, q: &AxisVector) -> ToolPose {
        let ChainGeometry { rotary: [first, second], slides, axis, .. } = &self.chain;
        let ChainArms { linear, sin_cos: [sin_cos1, sin_cos2], middle, .. } = self.arms(q);
        let tip = slides[0] * linear + first.point + first.turn(sin_cos1, &middle);
        let axis = first.turn(sin_cos1, &second.turn(sin_cos2, axis));
        // A product of two rotations of a unit vector: unit to a few roundings, no need to divide.
        ToolPose { tip: Point3::from(tip), axis: UnitVector3::new_unchecked(axis) }
    }

    /// Returns the arms of the rotaries at `q`. From the tool to the workpiece, each rotary turns everything behind it
    /// about its point.
    fn arms(&self, q: &AxisVector) -> ChainArms {
        let ChainGeometry { rotary: [first, second], slides, tip, .. } = &self.chain;
        let linear = Vector3::new(q[0], q[1], q[2]);
        let sin_cos = [FIRST_ROTARY, SECOND_ROTARY].map(|axis| math::sin_cos(q[axis]).into());
        let inner = slides[2] * linear + (tip - second.point);
        let middle =
            slides[1] * linear + (second.point - first.point) + second.turn(sin_cos[1], &inner);
        ChainArms { linear, sin_cos, inner, middle }
    }

    /// Returns the motion of the tip by each axis at `q`: its partial derivatives.
    pub fn tip_levers(&self, q: &AxisVector) -> TipLevers {
        let ChainGeometry { rotary: [first, second], slides, stage, .. } = &self.chain;
        let ChainArms { sin_cos: [sin_cos1, sin_cos2], inner, middle, .. } = self.arms(q);
        // Rotations keep distances, so each lever is taken before the turns that follow in the chain.
        let lever = |joint: &RotaryJoint, arm: &Vector3<f64>| joint.dir.cross(arm).norm();
        // The tip is affine in a linear axis: its direction, turned by the rotaries before it.
        let linear = [0, 1, 2].map(|axis| match stage[axis] {
            0 => slides[0].column(axis).into_owned(),
            1 => first.turn(sin_cos1, &slides[1].column(axis).into_owned()),
            _ => {
                let inner = second.turn(sin_cos2, &slides[2].column(axis).into_owned());
                first.turn(sin_cos1, &inner)
            }
        });
        let rotary = [lever(first, &middle), lever(second, &inner)];
        TipLevers { linear, rotary }
    }

    /// Returns the rates `[tip, tool axis]` at `q` while the axes change at `rate`.
    ///
    /// This is the derivative of [`Self::forward`] along `rate`, in the workpiece frame \[mm and 1 per unit
    /// of the rate\].
    pub fn forward_rate(&self, q: &AxisVector, rate: &AxisVector) -> [Vector3<f64>; 2] {
        let ChainGeometry { rotary: [first, second], slides, tip, axis, .. } = &self.chain;
        let [linear, slide] = [q, rate].map(|of| Vector3::new(of[0], of[1], of[2]));
        let [sin_cos1, sin_cos2] =
            [FIRST_ROTARY, SECOND_ROTARY].map(|axis| math::sin_cos(q[axis]).into());
        let [spin1, spin2] = [
            first.dir.into_inner() * rate[FIRST_ROTARY],
            second.dir.into_inner() * rate[SECOND_ROTARY],
        ];
        // d/dt (R v) = w x (R v) + R dv/dt with w the axis direction times its rate, stage by stage.
        let inner = second.turn(sin_cos2, &(slides[2] * linear + (tip - second.point)));
        let inner_rate = spin2.cross(&inner) + second.turn(sin_cos2, &(slides[2] * slide));
        let middle = slides[1] * linear + (second.point - first.point) + inner;
        let middle_rate = slides[1] * slide + inner_rate;
        let turned = first.turn(sin_cos1, &middle);
        let tip = slides[0] * slide + spin1.cross(&turned) + first.turn(sin_cos1, &middle_rate);
        // The same for the tool axis, which has no linear part.
        let inner_axis = second.turn(sin_cos2, axis);
        let axis = spin1.cross(&first.turn(sin_cos1, &inner_axis))
            + first.turn(sin_cos1, &spin2.cross(&inner_axis));
        [tip, axis]
    }
}

/// Arms of the rotary axes at one position of a machine, each before its own axis turns it.
struct ChainArms {
    /// Positions of the linear axes \[mm\].
    linear: Vector3<f64>,
    /// Sine and cosine of each rotary axis.
    sin_cos: [[f64; 2]; 2],
    /// From the point of the second rotary axis to the tip \[mm\].
    inner: Vector3<f64>,
    /// From the point of the first rotary axis to the tip \[mm\].
    middle: Vector3<f64>,
}

/// Motion of the tip by each axis at one position of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TipLevers {
    /// Motion of the tip by 1 mm of X, Y and Z, workpiece frame \[mm\].
    pub linear: [Vector3<f64>; 3],
    /// Distance of the tip from each rotary axis \[mm\].
    pub rotary: [f64; 2],
}

impl RotaryJoint {
    /// Turns `v` about the direction by the angle with this sine and cosine (Rodrigues' formula).
    fn turn(&self, [sin, cos]: [f64; 2], v: &Vector3<f64>) -> Vector3<f64> {
        // The component along the direction stays; the one across it turns in its plane.
        v * cos + self.dir.cross(v) * sin + self.dir.scale((1.0 - cos) * self.dir.dot(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisKind;
    use crate::machine::samples::{ac_trunnion, axis, machine};

    /// The worked cut of a trunnion with the datum 80 mm above the crossing of A and C.
    #[test]
    fn a_trunnion_by_hand() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let setup = Setup::new(Vector3::new(0.0, 0.0, 80.0), [0.0; 3], 150.0);
        let kinematics = Kinematics::new(&machine, &setup);
        for (xyz, a, c, tip, axis) in [
            (
                [13.7512, 21.0482, 74.9198],
                17.0_f64,
                33.0_f64,
                [12.5, 6.0, -2.2],
                [0.159_237, -0.245_203_5, 0.956_304_8],
            ),
            (
                [16.4330, 23.5772, 73.8924],
                20.0,
                37.0,
                [15.0, 7.4, -2.5],
                [0.205_832_9, -0.273_149_4, 0.939_692_6],
            ),
        ] {
            let [x, y, z] = xyz;
            let z = z + 150.0; // gauge point above the tip, both at zero at q = 0
            let pose =
                kinematics.forward(&AxisVector::from([x, y, z, c.to_radians(), a.to_radians()]));
            assert!((pose.tip.coords - Vector3::from(tip)).norm() < 1e-4, "{}", pose.tip);
            assert!((*pose.axis - Vector3::from(axis)).norm() < 1e-7, "{}", *pose.axis);
        }
    }

    #[test]
    fn the_setup_is_the_workpiece_in_the_machine() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let origin = Vector3::new(10.0, 20.0, -300.0);
        let quarter = std::f64::consts::FRAC_PI_2;
        let setup = Setup::new(origin, [0.0, quarter, 0.0], 100.0);
        let pose = Kinematics::new(&machine, &setup).forward(&AxisVector::zeros());
        // Machine z is the workpiece's -x after a quarter turn of the workpiece about y.
        assert!((*pose.axis - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-15);
        let tip_in_machine = setup.rotation * pose.tip.coords + origin;
        assert!((tip_in_machine - Vector3::new(0.0, 0.0, -100.0)).norm() < 1e-12);
    }

    /// Against central differences: third derivatives are of the size of arms, so that a step of 1e-5 leaves 1e-8.
    #[test]
    fn the_rate_is_the_derivative_of_the_forward_map() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let setup = Setup::new(Vector3::new(40.0, -30.0, 20.0), [0.1, 0.2, 0.3], 120.0);
        let kinematics = Kinematics::new(&machine, &setup);
        for seed in 0..20_u32 {
            let of = |k: f64| {
                AxisVector::from_fn(|i, _| {
                    let size = if i < 3 { 50.0 } else { 1.5 };
                    size * (f64::from(seed) * 1.3 + k + 1.7 * i as f64).sin()
                })
            };
            let (q, rate, step) = (of(0.0), of(0.7), 1e-5);
            let [before, after] =
                [q - rate * step, q + rate * step].map(|q| kinematics.forward(&q));
            let [tip, axis] = kinematics.forward_rate(&q, &rate);
            assert!((tip - (after.tip - before.tip) / (2.0 * step)).norm() < 1e-5, "{seed}");
            assert!((axis - (*after.axis - *before.axis) / (2.0 * step)).norm() < 1e-7, "{seed}");
        }
    }

    /// Against the forward map: a step of a linear axis, and half a turn of a rotary, which leads to the opposite point
    /// of a circle.
    #[test]
    fn levers_are_those_of_the_forward_map() {
        let rotary = |name, dir| axis(name, AxisKind::Rotary, dir);
        let a = rotary("A", [1.0, 0.0, 0.0]);
        let c = rotary("C", [0.0, 0.6, 0.8]);
        let chains: [(&[&str], _); 3] = [
            (&["w", "C", "A", "b", "X", "Y", "Z", "t"], [c.clone(), a.clone()]),
            (&["w", "C", "X", "b", "Y", "A", "Z", "t"], [c.clone(), a.clone()]),
            (&["w", "b", "X", "Y", "Z", "C", "A", "t"], [c, a]),
        ];
        let setup = Setup::new(Vector3::new(40.0, -30.0, 20.0), [0.1, 0.2, 0.3], 120.0);
        for (chain, rotary) in chains {
            let spec = machine(chain, rotary);
            let kinematics = Kinematics::new(&Machine::new(spec).unwrap(), &setup);
            let q = AxisVector::from([31.0, -47.0, 12.0, 0.7, -1.9]);
            let tip = kinematics.forward(&q).tip;
            let levers = kinematics.tip_levers(&q);
            for axis in 0..5 {
                let mut moved = q;
                moved[axis] += if axis < 3 { 1.0 } else { std::f64::consts::PI };
                let way = kinematics.forward(&moved).tip - tip;
                match axis.checked_sub(3) {
                    None => assert!((way - levers.linear[axis]).norm() < 1e-12),
                    Some(rotary) => {
                        assert!((0.5 * way.norm() - levers.rotary[rotary]).abs() < 1e-11);
                    }
                }
            }
        }
    }

    #[test]
    fn a_reversed_axis_is_the_same_machine_with_the_other_sign() {
        let mut spec = ac_trunnion();
        let machine = Machine::new(spec.clone()).unwrap();
        for axis in &mut spec.axes {
            axis.sense = -1.0;
        }
        let reversed = Machine::new(spec).unwrap();
        let setup = Setup::new(Vector3::new(1.0, 2.0, 3.0), [0.1, 0.2, 0.3], 50.0);
        let q = AxisVector::from([1.0, -2.0, 3.0, 0.4, -0.5]);
        let one = Kinematics::new(&machine, &setup).forward(&q);
        let other = Kinematics::new(&reversed, &setup).forward(&-q);
        assert!((one.tip - other.tip).norm() < 1e-12);
        assert!((*one.axis - *other.axis).norm() < 1e-15);
    }
}
