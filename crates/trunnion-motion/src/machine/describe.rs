//! Description of a machine: its kind among the twelve layouts, the tilt range of the tool, and the
//! motion to expect when each axis is jogged.

use super::checked::{Axis, FIRST_ROTARY, Machine, SECOND_ROTARY};
use super::forward::{Kinematics, Setup};
use crate::math;
use crate::math::angle::unwrap_near;
use crate::types::{AxisVector, Interval};
use nalgebra::{Rotation3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// Arrangement of the two rotary axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MachineKind {
    /// Both turn the spindle.
    HeadHead,
    /// Both turn the part.
    TableTable,
    /// One turns the part, one the spindle.
    TableHead,
}

impl MachineKind {
    /// Returns the name, such as `table-table`.
    pub fn name(self) -> &'static str {
        match self {
            Self::HeadHead => "head-head",
            Self::TableTable => "table-table",
            Self::TableHead => "table-head",
        }
    }
}

/// Body that an axis moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MovedBody {
    /// The workpiece: the axis stands before the bed in the chain.
    Part,
    /// The spindle.
    Tool,
}

/// Motion to expect when one axis is jogged from home.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SignCheck {
    /// Index of the axis in an [`AxisVector`].
    pub axis: usize,
    /// The jog \[mm or rad\].
    pub by: f64,
    /// The motion, as a sentence.
    pub words: String,
}

/// Largest angle between a direction and the coordinate axis it is named after \[rad\]: well above
/// what calibration finds, well below what is built on purpose.
const NAMED: f64 = 0.01;

impl Machine {
    /// Returns the arrangement of the two rotary axes.
    pub fn kind(&self) -> MachineKind {
        match [FIRST_ROTARY, SECOND_ROTARY].map(|axis| self.body(axis)) {
            [MovedBody::Part, MovedBody::Part] => MachineKind::TableTable,
            [MovedBody::Tool, MovedBody::Tool] => MachineKind::HeadHead,
            _ => MachineKind::TableHead,
        }
    }

    /// Returns the body that the axis of that index moves.
    pub fn body(&self, axis: usize) -> MovedBody {
        let name = self.axes.get(axis).map(|axis| axis.name.as_str());
        // Axes before the bed in the chain carry the workpiece.
        let place = |word: Option<&str>| self.chain.iter().position(|w| Some(w.as_str()) == word);
        if place(name) < place(Some("b")) { MovedBody::Part } else { MovedBody::Tool }
    }

    /// Returns the number among the twelve layouts of `docs/sources.md#002` (11 to 34), by directions, whatever
    /// the axes are called; `None` for oblique axes, or a tool that is not along z at home.
    pub fn layout(&self) -> Option<u8> {
        let [_, _, _, first, second] = &self.axes;
        if compass(&self.tool_axis)? != "+z" {
            return None;
        }
        // By the lines of the axes alone: a reversed axis is the same layout.
        let letter = |axis: &Axis| compass(&axis.dir)?.chars().last();
        let (tens, first, second) = match self.kind() {
            MachineKind::HeadHead => (10, first, second),
            MachineKind::TableTable => (20, second, first),
            MachineKind::TableHead => (30, first, second),
        };
        let unit = match (tens, letter(first)?, letter(second)?) {
            (_, 'x', 'y') => 1,
            (_, 'y', 'x') => 2,
            (20, 'x', 'z') | (10 | 30, 'z', 'x') => 3,
            (20, 'y', 'z') | (10 | 30, 'z', 'y') => 4,
            _ => return None,
        };
        Some(tens + unit)
    }

    /// Returns the angles between the tool and `dir` of the workpiece-side rotary \[rad\] that the travel of
    /// the tool-side rotary allows.
    pub fn tilt_range(&self) -> Interval {
        let [_, _, _, first, second] = &self.axes;
        let (w1, w2) = (first.dir.into_inner(), second.dir.scale(second.sense));
        let o = self.tool_axis.into_inner();
        let along = w2 * w2.dot(&o);
        // The tool's angle to the first rotary depends on the second alone, by Rodrigues' formula:
        // w1 . R2(t) o = still + with_cos cos t + with_sin sin t
        let [still, with_cos, with_sin] =
            [along, o - along, w2.cross(&o)].map(|vector| w1.dot(&vector));
        let angle = |t: f64| {
            math::acos((still + with_cos * math::cos(t) + with_sin * math::sin(t)).clamp(-1.0, 1.0))
        };
        // The cosine of the angle is largest at this position of the second rotary, least half a turn away.
        let turning = math::atan2(with_sin, with_cos);
        let [low, high] = second.limits.ends();
        let whole = [turning, turning + PI];
        if !(low.is_finite() && high.is_finite()) {
            return whole.map(angle).into();
        }
        // Extremes: the ends of travel, and turning points within it.
        let inside = |t: f64| {
            let near = unwrap_near(t, 0.5 * (low + high));
            (low..=high).contains(&near).then_some(near)
        };
        let candidates = [Some(low), Some(high), inside(turning), inside(turning + PI)];
        let all = candidates.into_iter().flatten().map(angle);
        all.fold(Interval::new(PI, 0.0), |range, angle| range.hull(Interval::point(angle)))
    }

    /// Describes the motion when each axis is jogged from home, in axis order.
    ///
    /// Each description has first the motion of the machine, then the motion of the tool seen from the part.
    pub fn sign_checks(&self) -> Vec<SignCheck> {
        let linear = (0..FIRST_ROTARY).map(|axis| self.linear_check(axis));
        linear.chain((FIRST_ROTARY..=SECOND_ROTARY).map(|axis| self.rotary_check(axis))).collect()
    }

    fn linear_check(&self, index: usize) -> SignCheck {
        // By ISO 841 +q moves the tool relative to the part; a part that is moved goes the other way.
        let by = self.jog(index, 10.0);
        let towards =
            self.axes.get(index).map_or(Vector3::zeros(), |axis| axis.dir.scale(axis.sense * by));
        let words = match self.body(index) {
            MovedBody::Part => format!(
                "the part goes to {}; seen from it the tool goes to {}",
                direction(&-towards),
                direction(&towards)
            ),
            MovedBody::Tool => format!("the tool goes to {}", direction(&towards)),
        };
        SignCheck { axis: index, by, words }
    }

    fn rotary_check(&self, index: usize) -> SignCheck {
        let kinematics = Kinematics::new(self, &Setup::new(Vector3::zeros(), [0.0; 3], 0.0));
        let seen = |q: &AxisVector| kinematics.forward(q).axis.into_inner();
        let by = self.jog(index, 30.0_f64.to_radians());
        let mut from = self.home();
        // A tool parallel to the axis only spins: tilt it first, by the other rotary.
        let mut first = String::new();
        if seen(&moved(&from, index, by)).cross(&seen(&from)).norm() < NAMED {
            let other = FIRST_ROTARY + SECOND_ROTARY - index;
            let lean = self.jog(other, 30.0_f64.to_radians());
            from = moved(&from, other, lean);
            first = format!(" (with {} at {})", self.name(other), degrees(from[other]));
        }
        let before = seen(&from);
        let physical = self.rotation_direction(index, by);
        let side = side_of(&physical);
        let moves = match self.body(index) {
            MovedBody::Part => {
                let goes = direction(&physical.cross(&side));
                format!(
                    "the table's {} side goes to {goes}; seen from the part{first} ",
                    direction(&side)
                )
            }
            MovedBody::Tool => format!("the head turns{first}: "),
        };
        let turns = if first.is_empty() {
            // The component of the new tool axis across the old one is where the spindle end leans.
            let after = seen(&moved(&from, index, by));
            let lean = after - before * before.dot(&after);
            let [spindle, nose] = [lean, -lean].map(|end| direction(&end));
            format!("the spindle end tilts to {spindle}, the nose to {nose}")
        } else {
            let upright = seen(&self.home());
            let lean = direction(&(before - upright * upright.dot(&before)));
            // At the start of the turn: its end depends on how far the jog goes.
            let towards = seen(&moved(&from, index, by * 1e-6)) - before;
            format!("the tilt of the spindle end turns from {lean} towards {}", direction(&towards))
        };
        let words = moves + &turns;
        SignCheck { axis: index, by, words }
    }

    /// Returns the direction about which the machine turns on a jog from home, in the machine frame.
    ///
    /// A table turns against the count; the axis that carries it may have turned it already.
    fn rotation_direction(&self, index: usize, by: f64) -> Vector3<f64> {
        let sign = |body| if body == MovedBody::Part { -1.0 } else { 1.0 };
        let turn = |index: usize| {
            let axis = self.axes.get(index)?;
            Some(axis.dir.scale(axis.sense * sign(self.body(index))))
        };
        // On a table the second rotary carries the first, on a head the first carries the second.
        let carrier = match self.kind() {
            MachineKind::TableTable if index == FIRST_ROTARY => Some(SECOND_ROTARY),
            MachineKind::HeadHead if index == SECOND_ROTARY => Some(FIRST_ROTARY),
            _ => None,
        };
        let carried = carrier
            .and_then(|carrier| Some(Rotation3::new(turn(carrier)? * self.home()[carrier])))
            .unwrap_or_default();
        carried * turn(index).unwrap_or_default() * by.signum()
    }

    fn name(&self, index: usize) -> &str {
        self.axes.get(index).map_or("", |axis| axis.name.as_str())
    }

    /// Returns a jog of about `wanted` from home: up if travel allows it, else down, else less.
    fn jog(&self, index: usize, wanted: f64) -> f64 {
        let Some(Axis { limits: Interval { low, high }, home, .. }) = self.axes.get(index) else {
            return 0.0;
        };
        // Where travel allows neither direction in full, the one with more room.
        let [up, down] = [high - home, home - low];
        if up >= wanted {
            wanted
        } else if down >= wanted {
            -wanted
        } else if up >= down {
            up
        } else {
            -down
        }
    }
}

fn moved(q: &AxisVector, index: usize, by: f64) -> AxisVector {
    let mut q = *q;
    q[index] += by;
    q
}

/// Returns a coordinate direction across `axis`, x if possible.
fn side_of(axis: &Vector3<f64>) -> Vector3<f64> {
    // More than 30 degrees from the axis.
    let across = |side: &Vector3<f64>| side.cross(axis).norm() > 0.5 * axis.norm();
    [Vector3::x(), Vector3::y()].into_iter().find(across).unwrap_or_else(Vector3::z)
}

/// Returns `+x`, ..., `-z` for a direction that is one of these.
fn compass(v: &UnitVector3<f64>) -> Option<&'static str> {
    const NAMES: [[&str; 2]; 3] = [["+x", "-x"], ["+y", "-y"], ["+z", "-z"]];
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    // |v x axis| is the sine of the angle to the axis' line.
    let near = axes.iter().position(|axis| v.cross(axis).norm() < NAMED)?;
    let names = NAMES.get(near)?;
    Some(if v[near] > 0.0 { names[0] } else { names[1] })
}

/// Formats a direction: by name, else by its components.
pub(super) fn direction(v: &Vector3<f64>) -> String {
    let Some(unit) = UnitVector3::try_new(*v, 0.0) else { return "nowhere".to_owned() };
    compass(&unit).map_or_else(
        || {
            let [x, y, z] =
                [unit.x, unit.y, unit.z].map(|part| (part * 100.0).round() / 100.0 + 0.0);
            format!("({x}, {y}, {z})")
        },
        str::to_owned,
    )
}

fn degrees(angle: f64) -> String {
    format!("{:+}", (angle.to_degrees() * 1000.0).round() / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{ac_trunnion, axis, machine};
    use super::super::spec::{AxisKind, MachineSpec};
    use super::*;

    fn words(spec: MachineSpec) -> Vec<String> {
        let machine = Machine::new(spec).unwrap();
        machine.sign_checks().into_iter().map(|check| check.words).collect()
    }

    /// docs/book/src/concepts/frames.md: A +30 leans the spindle end to -y, seen from the part.
    #[test]
    fn a_trunnion_jogged() {
        let found = words(ac_trunnion());
        assert_eq!(found[0], "the tool goes to +x");
        assert_eq!(
            found[3],
            "the table's +x side goes to -y; seen from the part (with A at +30) the tilt of the spindle end turns from -y towards +x"
        );
        assert_eq!(
            found[4],
            "the table's +y side goes to -z; seen from the part the spindle end tilts to -y, the nose to +y"
        );
    }

    #[test]
    fn a_fork_head_jogged_and_reversed() {
        let rotary = |name, dir| axis(name, AxisKind::Rotary, dir);
        let mut spec = machine(
            &["w", "Y", "b", "X", "Z", "C", "B", "t"],
            [rotary("C", [0.0, 0.0, 1.0]), rotary("B", [0.0, 1.0, 0.0])],
        );
        let found = words(spec.clone());
        assert_eq!(found[1], "the part goes to -y; seen from it the tool goes to +y");
        assert_eq!(found[4], "the head turns: the spindle end tilts to +x, the nose to -x");
        assert_eq!(
            found[3],
            "the head turns (with B at +30): the tilt of the spindle end turns from +x towards +y"
        );
        spec.axes[4].sense = -1.0;
        assert_eq!(words(spec)[4], "the head turns: the spindle end tilts to -x, the nose to +x");
    }

    #[test]
    fn kinds_and_layouts() {
        let rotary = |name, dir| axis(name, AxisKind::Rotary, dir);
        let [a, b] = [rotary("A", [1.0, 0.0, 0.0]), rotary("B", [0.0, 1.0, 0.0])];
        let of = |chain: [&str; 8], rotary| {
            let machine = Machine::new(machine(&chain, rotary)).unwrap();
            (machine.kind(), machine.layout())
        };
        let on_bed = of(["w", "A", "b", "X", "Y", "Z", "B", "t"], [a.clone(), b.clone()]);
        assert_eq!(on_bed, (MachineKind::TableHead, Some(31)));
        let cradle = of(["w", "A", "B", "b", "X", "Y", "Z", "t"], [a, b]);
        assert_eq!(cradle, (MachineKind::TableTable, Some(22)));
        let trunnion = Machine::new(ac_trunnion()).unwrap();
        assert_eq!((trunnion.kind(), trunnion.layout()), (MachineKind::TableTable, Some(23)));
    }

    #[test]
    fn travel_bounds_the_lean() {
        let lean = |spec| Machine::new(spec).unwrap().tilt_range().ends().map(f64::to_degrees);
        let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() + (b - d).abs() < 1e-6;
        let mut spec = ac_trunnion();
        spec.axes[4].limits = Some(Interval::new(-0.5, 1.0));
        assert!(near(lean(spec.clone()), [0.0, 1.0_f64.to_degrees()]));
        spec.axes[4].limits = Some(Interval::new(0.5, 1.0));
        assert!(near(lean(spec.clone()), [0.5_f64.to_degrees(), 1.0_f64.to_degrees()]));
        spec.axes[4].limits = None;
        spec.axes[4].cyclic = Some(std::f64::consts::TAU);
        assert!(near(lean(spec.clone()), [0.0, 180.0]));
        // A nutating table at 45 deg leans by up to 90.
        spec.axes[4].dir = [0.0, 1.0, 1.0];
        assert!(near(lean(spec), [0.0, 90.0]));
    }
}
