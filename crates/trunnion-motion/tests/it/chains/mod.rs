//! Machines for the tests of kinematics: the twelve layouts, joint lists, random chains.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use nalgebra::{Point3, SVector, UnitVector3, Vector3};
use serde_json::Value;
use std::path::Path;
use trunnion::machine::{AxisSpec, Kinematics, Machine, MachineSpec, Setup};
use trunnion::math::jet::Jet;
use trunnion::types::{PieceGeometry, PoseCurve, PoseSpan, ToolPose};

pub(crate) type V3 = Vector3<f64>;

/// A fixture of `fixtures/kinematics`.
pub(crate) fn cases(name: &str) -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/kinematics");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    serde_json::from_str::<Vec<Value>>(&text).unwrap()
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

pub(crate) fn vector(value: &Value) -> V3 {
    V3::from_column_slice(&numbers(value))
}

/// An axis with generous limits: rotaries without end.
pub(crate) fn axis(name: &str, dir: V3, rotary_point: Option<V3>) -> AxisSpec {
    let rotary = rotary_point.is_some();
    let preset = match rotary_point {
        Some(point) => AxisSpec::rotary(name, dir.into(), point.into()),
        None => AxisSpec::linear(name, dir.into()),
    };
    let limits = (!rotary).then_some(trunnion::types::Interval::new(-1e5, 1e5));
    AxisSpec { limits, vel: 1.0, acc: 10.0, jerk: 100.0, ..preset }
}

/// A machine from its chain (without `w` and `t`) and axes.
pub(crate) fn spec(chain: &[&str], axes: Vec<AxisSpec>, tip: V3, tool_axis: V3) -> MachineSpec {
    let chain = [&["w"], chain, &["t"]].concat();
    let spec = MachineSpec::new("test", &chain, axes);
    MachineSpec { tool_axis: tool_axis.into(), gauge: tip.into(), ..spec }
}

pub(crate) fn slides() -> Vec<AxisSpec> {
    vec![axis("X", V3::x(), None), axis("Y", V3::y(), None), axis("Z", V3::z(), None)]
}

pub(crate) fn direction(name: &str) -> V3 {
    match name {
        "A" => V3::x(),
        "B" => V3::y(),
        _ => V3::z(),
    }
}

/// The kinematics of a case of the twelve layouts, and where its first and second angle stand in
/// an axis vector.
pub(crate) fn layout(case: &Value) -> (Kinematics, [usize; 2]) {
    const NAMES: [[[&str; 2]; 4]; 3] = [
        [["A", "B"], ["B", "A"], ["C", "A"], ["C", "B"]],
        [["A", "B"], ["B", "A"], ["A", "C"], ["B", "C"]],
        [["A", "B"], ["B", "A"], ["C", "A"], ["C", "B"]],
    ];
    let code = usize::try_from(case["layout"].as_u64().unwrap()).unwrap();
    let [first, second] = NAMES[code / 10 - 1][code % 10 - 1];
    let of = |key: &str| case.get(key).map_or(V3::zeros(), vector);
    let [l, r, t] = [of("L"), of("R"), of("T")];
    // A table that turns physically by +theta is the reverse of ISO 841.
    let table = -number(&case["table_sign"]);
    let rotary = |name: &str, point: V3, sense: f64| {
        let mut axis = axis(name, direction(name), Some(point));
        axis.sense = sense;
        axis
    };
    let mut axes = slides();
    let zero = V3::zeros();
    let (chain, tip, order) = match code / 10 {
        1 => {
            axes.extend([rotary(first, zero, 1.0), rotary(second, r, 1.0)]);
            (["b", "X", "Y", "Z", first, second], r + t, [3, 4])
        }
        2 => {
            axes.extend([rotary(first, -r, table), rotary(second, zero, table)]);
            ([second, first, "b", "X", "Y", "Z"], t - r, [4, 3])
        }
        _ => {
            axes.extend([rotary(first, zero, table), rotary(second, r, 1.0)]);
            ([first, "b", "X", "Y", "Z", second], r + t, [3, 4])
        }
    };
    let machine = Machine::new(spec(&chain, axes, tip, V3::z())).unwrap();
    (Kinematics::new(&machine, &Setup::new(-l, [0.0; 3], 0.0)), order)
}

/// A machine given as joint lists from the base outwards.
pub(crate) fn joints(machine: &Value) -> Kinematics {
    let list = |key: &str| machine[key].as_array().unwrap().clone();
    let one = |joint: &Value, side: f64| {
        let point = (joint["kind"] == "R").then(|| vector(&joint["point"]));
        let mut axis = axis(joint["name"].as_str().unwrap(), vector(&joint["axis"]), point);
        axis.sense = side * joint.get("sign").map_or(1.0, number);
        axis
    };
    // A joint that carries the workpiece moves the tool the other way.
    let work: Vec<AxisSpec> = list("work").iter().rev().map(|joint| one(joint, -1.0)).collect();
    let tool: Vec<AxisSpec> = list("tool").iter().map(|joint| one(joint, 1.0)).collect();
    let mut chain: Vec<&str> = work.iter().map(|axis| axis.name.as_str()).collect();
    chain.push("b");
    chain.extend(tool.iter().map(|axis| axis.name.as_str()));
    let axes = work.iter().chain(&tool).cloned().collect();
    let spec = spec(&chain, axes, vector(&machine["tip0"]), vector(&machine["o0"]));
    let machine_checked = Machine::new(spec).unwrap();
    Kinematics::new(&machine_checked, &Setup::new(vector(&machine["work_origin"]), [0.0; 3], 0.0))
}

pub(crate) fn pose(tip: V3, axis: V3) -> ToolPose {
    ToolPose { tip: Point3::from(tip), axis: UnitVector3::new_normalize(axis) }
}

/// Quintic spans through value and two derivatives of tip and axis at the knots.
pub(crate) fn curve(knots: Vec<f64>, at: impl Fn(Jet) -> ([Jet; 3], [Jet; 3])) -> PieceGeometry {
    let jets = |u: f64| {
        let (tip, axis) = at(Jet::variable(u));
        let mut taylor = [SVector::<f64, 9>::zeros(); 3];
        for (row, jet) in tip.iter().chain(&axis).chain(&tip).enumerate() {
            for (order, coefficients) in taylor.iter_mut().enumerate() {
                coefficients[row] = jet.c[order];
            }
        }
        taylor
    };
    let spans = knots
        .windows(2)
        .map(|pair| {
            let h = pair[1] - pair[0];
            let [a, b] = [jets(pair[0]), jets(pair[1])];
            let [d0, d1, d2] = [
                (b[0] - a[0] - a[1] * h - a[2] * (h * h)) / h.powi(3),
                (b[1] - a[1] - a[2] * (2.0 * h)) / h.powi(2),
                (b[2] - a[2]) / h,
            ];
            PoseSpan {
                coefficients: [
                    a[0],
                    a[1],
                    a[2],
                    d0 * 10.0 - d1 * 4.0 + d2,
                    (d0 * -15.0 + d1 * 7.0 - d2 * 2.0) / h,
                    (d0 * 6.0 - d1 * 3.0 + d2) / (h * h),
                ],
            }
        })
        .collect();
    PieceGeometry::Curve(PoseCurve { knots, spans })
}

pub(crate) fn knots(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect()
}
