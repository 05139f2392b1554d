//! The chain with deviations, and the derivative of its tip by each of them.

use super::deviation::{CHAIN_DEVIATIONS, ChainDeviation, DeviationKind, deviations};
use crate::machine::{ChainGeometry, FIRST_ROTARY, Kinematics, Machine, RotaryJoint, Setup};
use crate::math;
use crate::types::AxisVector;
use nalgebra::{SMatrix, SVector, UnitVector3, Vector3};

/// One number for each deviation.
pub(super) type Deviations = SVector<f64, CHAIN_DEVIATIONS>;

/// Derivative of a place by all deviations.
pub(super) type PlaceDerivative = SMatrix<f64, 3, CHAIN_DEVIATIONS>;

/// A machine as the file has it, and the deviations that it may have.
#[derive(Debug, Clone)]
pub(super) struct ChainModel {
    pub(super) nominal: Machine,
    pub(super) deviations: [ChainDeviation; CHAIN_DEVIATIONS],
}

/// The chain at one value of the deviations.
#[derive(Debug, Clone)]
pub(super) struct DeviatedChain {
    chain: ChainGeometry,
    /// Motion of the point or direction that each deviation moves; `sense` is in it.
    moves: [Vector3<f64>; CHAIN_DEVIATIONS],
    deviations: [ChainDeviation; CHAIN_DEVIATIONS],
}

/// Tip with its derivative.
#[derive(Debug, Clone, Copy)]
pub(super) struct TipJet {
    /// Tip \[mm\], workpiece frame.
    pub(super) tip: Vector3<f64>,
    /// Its derivative \[mm per mm or rad\].
    pub(super) derivative: PlaceDerivative,
}

impl ChainModel {
    pub(super) fn new(machine: &Machine) -> Self {
        Self { nominal: machine.clone(), deviations: deviations(machine) }
    }

    /// Returns the machine with deviations.
    pub(super) fn machine(&self, by: &Deviations) -> Machine {
        let mut machine = self.nominal.clone();
        for (deviation, value) in self.deviations.iter().zip(by.iter()) {
            if let (DeviationKind::Offset, Some(axis)) =
                (deviation.kind, deviation.axis.and_then(|axis| machine.axes.get_mut(axis)))
            {
                axis.point += deviation.direction.scale(*value);
            }
        }
        for (index, axis) in machine.axes.iter_mut().enumerate() {
            axis.dir = UnitVector3::new_normalize(self.tilted(Some(index), by));
        }
        machine.tool_axis = UnitVector3::new_normalize(self.tilted(None, by));
        machine
    }

    /// Returns the chain with deviations, ready for derivatives.
    pub(super) fn at(&self, by: &Deviations) -> DeviatedChain {
        let chain = *Kinematics::new(&self.machine(by), &Setup::default()).chain();
        let moves = std::array::from_fn(|index| {
            self.deviations.get(index).map_or(Vector3::zeros(), |one| self.motion(one, by))
        });
        DeviatedChain { chain, moves, deviations: self.deviations }
    }

    /// Returns the direction of an axis (`None`: the tool) in the file.
    fn nominal_dir(&self, axis: Option<usize>) -> Vector3<f64> {
        let axis = axis.and_then(|axis| self.nominal.axes.get(axis));
        axis.map_or(self.nominal.tool_axis, |axis| axis.dir).into_inner()
    }

    /// Returns a tilted direction, before it is made a unit vector: `d + sum(angle e x d)`.
    fn tilted(&self, axis: Option<usize>, by: &Deviations) -> Vector3<f64> {
        let dir = self.nominal_dir(axis);
        let tilts = self.deviations.iter().zip(by.iter());
        tilts
            .filter(|(one, _)| one.kind == DeviationKind::Tilt && one.axis == axis)
            .fold(dir, |sum, (one, angle)| sum + one.direction.cross(&dir) * *angle)
    }

    /// Returns the derivative of the point or direction that a deviation moves.
    fn motion(&self, of: &ChainDeviation, by: &Deviations) -> Vector3<f64> {
        if of.kind == DeviationKind::Offset {
            return of.direction.into_inner();
        }
        let tilted = self.tilted(of.axis, by);
        let unit = tilted.normalize();
        let turned = of.direction.cross(&self.nominal_dir(of.axis));
        // The derivative of v / |v|: what lies across v, over |v|.
        let sense =
            of.axis.and_then(|axis| self.nominal.axes.get(axis)).map_or(1.0, |axis| axis.sense);
        (turned - unit * unit.dot(&turned)) * (sense / tilted.norm())
    }
}

impl DeviatedChain {
    /// Returns the tip at `q` for a tool of `length`, and its derivative, by the formula of [`ChainGeometry`].
    pub(super) fn tip(&self, q: &AxisVector, length: f64) -> TipJet {
        let ChainGeometry { rotary: [first, second], slides, stage, tip, axis, .. } = &self.chain;
        let linear = Vector3::new(q[0], q[1], q[2]);
        let turn = |joint: &RotaryJoint, angle| math::rotation_about(&joint.dir, angle);
        let (angle1, angle2) = (q[FIRST_ROTARY], q[FIRST_ROTARY + 1]);
        let (turn1, turn2) = (turn(first, angle1), turn(second, angle2));
        let inner = slides[2] * linear + tip - axis.scale(length) - second.point;
        let middle = slides[1] * linear + second.point - first.point + turn2 * inner;
        let column = |(of, by): (&ChainDeviation, &Vector3<f64>)| match (of.kind, of.axis) {
            (DeviationKind::Offset, Some(FIRST_ROTARY)) => by - turn1 * by,
            (DeviationKind::Offset, _) => turn1 * (by - turn2 * by),
            (_, None) => turn1 * (turn2 * (by * -length)),
            (_, Some(FIRST_ROTARY)) => turned_by(first, angle1, by, &middle),
            (_, Some(axis)) => match stage.get(axis) {
                // No stage: the second rotary.
                None => turn1 * turned_by(second, angle2, by, &inner),
                Some(0) => by * q[axis],
                Some(1) => turn1 * (by * q[axis]),
                Some(_) => turn1 * (turn2 * (by * q[axis])),
            },
        };
        let columns: Vec<Vector3<f64>> =
            self.deviations.iter().zip(&self.moves).map(column).collect();
        TipJet {
            tip: slides[0] * linear + first.point + turn1 * middle,
            derivative: PlaceDerivative::from_columns(&columns),
        }
    }
}

/// Returns the derivative of a turned arm while the direction of the axis moves by `by` (Rodrigues' formula).
fn turned_by(
    joint: &RotaryJoint,
    angle: f64,
    by: &Vector3<f64>,
    arm: &Vector3<f64>,
) -> Vector3<f64> {
    let dir = joint.dir.into_inner();
    by.cross(arm) * math::sin(angle)
        + (by * dir.dot(arm) + dir * by.dot(arm)) * (1.0 - math::cos(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisKind;
    use crate::machine::samples::{ac_trunnion, axis, machine};

    /// Every chain shape, with skew axes, reversed ones, and deviations of a size that bends.
    #[test]
    fn derivatives_agree_with_differences() {
        let rotary = |name, dir| axis(name, AxisKind::Rotary, dir);
        let [b, c] = [rotary("B", [0.1, 1.0, 0.7]), rotary("C", [0.0, 0.1, 1.0])];
        let mut table = ac_trunnion();
        table.axes[4].sense = -1.0;
        let specs = [
            table,
            machine(&["w", "Y", "b", "X", "Z", "C", "B", "t"], [c.clone(), b.clone()]),
            machine(&["w", "C", "X", "b", "Y", "B", "Z", "t"], [c, b]),
        ];
        for spec in specs {
            let model = ChainModel::new(&Machine::new(spec).unwrap());
            let by = Deviations::from_fn(|row, _| 0.01 * (row as f64 - 5.0));
            let q = AxisVector::from([31.0, -47.0, 12.0, 0.7, -1.9]);
            let jet = model.at(&by).tip(&q, 120.0);
            let setup = Setup { tool_length: 120.0, ..Setup::default() };
            let there = Kinematics::new(&model.machine(&by), &setup).forward(&q).tip;
            assert!((there.coords - jet.tip).norm() < 1e-12);
            for index in 0..CHAIN_DEVIATIONS {
                let h = 1e-5;
                let at = |step: f64| {
                    let mut by = by;
                    by[index] += step;
                    model.at(&by).tip(&q, 120.0).tip
                };
                let numeric = (at(h) - at(-h)) / (2.0 * h);
                assert!((numeric - jet.derivative.column(index)).norm() < 1e-6, "{index}");
            }
        }
    }
}
