//! Halves of the travel of rotary axes, in which other branches are the quickest.

use crate::machine::{FIRST_ROTARY, Kinematics, Machine};
use crate::types::Interval;

/// Half of the travel of one rotary axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotaryHalf {
    index: usize,
    limits: Interval,
}

impl RotaryHalf {
    /// Returns the halves of travel to both sides of home, of every rotary axis that does not turn without end.
    pub(super) fn all(machine: &Machine) -> Vec<Self> {
        let rotaries = machine.axes.iter().enumerate().skip(FIRST_ROTARY);
        let sides = rotaries.flat_map(|(index, axis)| {
            let ([low, high], home) = (axis.limits.ends(), axis.home);
            [Interval::new(home, high), Interval::new(low, home)]
                .map(|limits| Self { index, limits })
        });
        let is_a_part = |half: &Self| {
            let [low, high] = half.limits.ends();
            low < high && low.is_finite() && high.is_finite()
        };
        sides.filter(is_a_part).collect()
    }

    /// Returns the machine with its axis kept in the half.
    pub(super) fn of(&self, kinematics: &Kinematics) -> Kinematics {
        let mut machine = kinematics.machine().clone();
        if let Some(axis) = machine.axes.get_mut(self.index) {
            axis.limits = self.limits;
        }
        Kinematics::new(&machine, kinematics.setup())
    }

    /// Describes the half.
    pub(super) fn describe(&self, machine: &Machine) -> String {
        let name = machine.axes.get(self.index).map_or("", |axis| axis.name.as_str());
        let [low, high] = self.limits.ends().map(f64::to_degrees);
        format!("{name} stays in [{low:.1}, {high:.1}] deg")
    }
}
