//! The files of `machines/`: each loads, fits its schema, and the twelve layouts agree with the
//! closed forms of docs/sources.md#002. And files with faults: each is reported at its line.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::chains;
use crate::property;
use crate::validator;

use chains::{V3, pose};
use nalgebra::Rotation3;
use proptest::prelude::*;
use serde_json::Value;
use std::path::Path;
use trunnion::files::machine::{BUILT_IN, built_in, parse};
use trunnion::files::schema;
use trunnion::inverse::{Inverse, InverseSolutions};
use trunnion::machine::{AxisKind, Kinematics, Machine, MachineKind, Setup};
use trunnion::math::angle::{angle_between, wrap};

fn machine(name: &str) -> Machine {
    let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name).unwrap();
    parse(text).unwrap().machine
}

#[test]
fn the_built_in_machines_are_the_folder() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    assert_eq!(names, BUILT_IN.map(|(name, _)| name));
    for (name, text) in BUILT_IN {
        let file = parse(text).unwrap();
        assert_eq!(file.machine.name, name);
        // A machine is what its specification says: the same again.
        assert_eq!(Machine::new(file.spec).unwrap(), file.machine);
    }
}

#[test]
fn a_name_that_is_near_is_suggested() {
    for name in ["bc-trunion", "machines/bc-trunion.toml", "bc-trunnion.toml"] {
        assert_eq!(built_in(name), Err(Some("bc-trunnion")), "{name}");
    }
    assert_eq!(built_in("lathe"), Err(None));
}

/// docs/book/src/concepts/frames.md: seen from the part, +30 on a rotary about x leans the spindle end to -y, about y to
/// +x; about z, with a lean, it turns the lean by the right hand.
#[test]
fn signs_in_words_are_those_of_the_frames() {
    for (name, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        for check in machine.sign_checks() {
            let axis = &machine.axes[check.axis];
            let up = check.by * axis.sense > 0.0;
            let leans = match (axis.kind, axis.name.as_str()) {
                (AxisKind::Rotary, "A") if !check.words.contains("(with") => ["-y", "+y"],
                (AxisKind::Rotary, "B") if axis.dir.y > 0.99 && !check.words.contains("(with") => {
                    ["+x", "-x"]
                }
                _ => continue,
            };
            let expected = format!("the spindle end tilts to {}", leans[usize::from(!up)]);
            assert!(check.words.contains(&expected), "{name} {}: {}", axis.name, check.words);
        }
    }
}

/// How far the tool leans within travel, against a fine walk over the tool-side rotary.
#[test]
fn the_reach_within_travel_is_what_the_forward_map_reaches() {
    for (name, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        let kinematics = Kinematics::new(&machine, &Setup::new(V3::zeros(), [0.0; 3], 0.0));
        let [.., first, second] = &machine.axes;
        let [low, high] = second.limits.ends();
        let mut walked = [f64::INFINITY, 0.0];
        for step in 0..=10_000 {
            let mut q = machine.home();
            q[4] = low + (high - low) * f64::from(step) / 10_000.0;
            let lean = angle_between(&kinematics.forward(&q).axis, &first.dir);
            walked = [f64::min(walked[0], lean), f64::max(walked[1], lean)];
        }
        let [least, most] = machine.tilt_range().ends();
        assert!((least - walked[0]).abs() < 5e-4 && (most - walked[1]).abs() < 5e-4, "{name}");
        let [low, high] = Inverse::new(&kinematics).unwrap().reach().ends();
        assert!(low <= least + 1e-7 && most <= high + 1e-7, "{name}");
    }
}

/// The codes stand for what the paper's table says, by directions and not by names.
#[test]
fn every_layout_has_its_file() {
    let kinds = [MachineKind::HeadHead, MachineKind::TableTable, MachineKind::TableHead];
    let mut codes = Vec::new();
    for (name, text) in BUILT_IN.iter().filter(|(name, _)| name.starts_with("layout-")) {
        let machine = parse(text).unwrap().machine;
        let code: u8 = name[7..9].parse().unwrap();
        assert_eq!(machine.layout(), Some(code), "{name}");
        assert_eq!(machine.kind(), kinds[usize::from(code / 10) - 1]);
        assert!(name.ends_with(machine.kind().name()));
        codes.push(code);
    }
    assert_eq!(codes, [11, 12, 13, 14, 21, 22, 23, 24, 31, 32, 33, 34]);
}

/// Angles (first, second) of the table in docs/sources.md#002 for tool axis (i, j, k) and branch s;
/// a table is taken to turn physically by +theta.
fn angles(code: u8, [i, j, k]: [f64; 3], s: f64) -> [f64; 2] {
    let h = f64::hypot;
    match code {
        11 => [(-s * j).atan2(s * k), i.atan2(s * h(j, k))],
        12 => [(s * i).atan2(s * k), (-j).atan2(s * h(i, k))],
        13 => [(s * i).atan2(-s * j), (s * h(i, j)).atan2(k)],
        14 => [(s * j).atan2(s * i), (s * h(i, j)).atan2(k)],
        21 => [j.atan2(s * h(i, k)), (-s * i).atan2(s * k)],
        22 => [(-i).atan2(s * h(j, k)), (s * j).atan2(s * k)],
        23 => [(s * h(i, j)).atan2(k), (s * i).atan2(s * j)],
        24 => [(s * h(i, j)).atan2(k), (s * j).atan2(-s * i)],
        31 => [(s * j).atan2(s * k), i.atan2(s * h(j, k))],
        32 => [(-s * i).atan2(s * k), (-j).atan2(s * h(i, k))],
        33 => [(-s * i).atan2(-s * j), (s * h(i, j)).atan2(k)],
        _ => [(-s * j).atan2(s * i), (s * h(i, j)).atan2(k)],
    }
}

/// Rotation about the axis of a letter of the layout's name.
fn about(letter: u8, angle: f64) -> Rotation3<f64> {
    match letter {
        b'a' => Rotation3::from_axis_angle(&V3::x_axis(), angle),
        b'b' => Rotation3::from_axis_angle(&V3::y_axis(), angle),
        _ => Rotation3::from_axis_angle(&V3::z_axis(), angle),
    }
}

/// Slides of CT1, CT2, CT3 with D = Q - L.
fn slides(kind: MachineKind, [r1, r2]: [Rotation3<f64>; 2], [d, r, t]: [V3; 3]) -> V3 {
    match kind {
        MachineKind::HeadHead => d - r1 * (r + r2 * t),
        MachineKind::TableTable => r1 * (r + r2 * d) - t,
        MachineKind::TableHead => r1 * d - r - r2 * t,
    }
}

proptest! {
    #![proptest_config(property::cases(400))]

    /// The file's chain and the general inverse against the closed forms, on both branches.
    #[test]
    fn the_closed_forms_of_every_layout(
        tip in prop::array::uniform3(-300.0..300.0f64),
        axis in prop::array::uniform3(-1.0..1.0f64),
        origin in prop::array::uniform3(-400.0..400.0f64),
        length in 0.0..300.0f64,
    ) {
        prop_assume!(V3::from(axis).norm() > 0.2);
        let [tip, origin] = [tip, origin].map(V3::from);
        let there = pose(tip, V3::from(axis));
        for (name, text) in BUILT_IN.iter().filter(|(name, _)| name.starts_with("layout-")) {
            let machine = parse(text).unwrap().machine;
            let code = machine.layout().unwrap();
            let kind = machine.kind();
            // Near a pole angles are good to rounding over the distance: that has its own test.
            let kinematics = Kinematics::new(&machine, &Setup::new(origin, [0.0; 3], length));
            let inverse = Inverse::new(&kinematics).unwrap();
            if inverse.pole_distance(&there.axis) < 1e-2 {
                continue;
            }
            let letters = [name.as_bytes()[10], name.as_bytes()[11]];
            // Axis vectors have the workpiece side first, the layout of two tables the base side.
            let order = if kind == MachineKind::TableTable { [4, 3] } else { [3, 4] };
            let [p1, p2] = order.map(|index| machine.axes[index].point.coords);
            let gauge = machine.gauge.coords - machine.tool_axis.scale(length);
            let [l, t] = match kind {
                MachineKind::TableTable => [p2 - origin, gauge - p1],
                _ => [p1 - origin, gauge - p2],
            };
            // Machine files count by ISO 841: a table that shows +q has turned by -q.
            let signs = match kind {
                MachineKind::HeadHead => [1.0, 1.0],
                MachineKind::TableTable => [-1.0, -1.0],
                MachineKind::TableHead => [-1.0, 1.0],
            };
            let InverseSolutions::Regular(found) = inverse.solutions(&there).unwrap() else {
                panic!("{name}: singular")
            };
            for s in [1.0, -1.0] {
                let [a, b] = angles(code, (*there.axis).into(), s);
                let turns = [about(letters[0], a), about(letters[1], b)];
                let xyz = slides(kind, turns, [tip - l, p2 - p1, t]);
                let hit = found.iter().any(|q| {
                    (q.fixed_rows::<3>(0) - xyz).norm() <= 1e-9
                        && wrap(q[order[0]] - signs[0] * a).abs() <= 1e-12
                        && wrap(q[order[1]] - signs[1] * b).abs() <= 1e-12
                });
                prop_assert!(hit, "{name}, s = {s}: {a} {b} {xyz} not among {found:?}");
            }
        }
    }
}

fn schema_breaches(text: &str) -> Vec<String> {
    let schema: Value = serde_json::from_str(&schema::machine()).unwrap();
    let value: Value = toml::from_str(text).unwrap();
    validator::breaches(&schema, &value, "")
}

#[test]
fn every_machine_file_fits_the_schema_and_faulty_ones_do_not() {
    for (name, text) in BUILT_IN {
        assert_eq!(schema_breaches(text), Vec::<String>::new(), "{name}");
    }
    let (_, good) = BUILT_IN[1];
    for (from, to, breach) in [
        ("prefer = \"positive\"", "prefer = \"up\"", ".axis.B.prefer: enum"),
        ("kind   = \"rotary\"", "kind = 1", ".axis.C.kind"),
        ("vel    = 500.0", "vell   = 500.0", ".axis.X.vel: missing"),
        ("vel    = 500.0", "vell   = 500.0", ".axis.X.vell: unknown"),
        ("acc    = 2500.0", "acc    = 0.0", ".axis.X.acc: range"),
        ("limits = [-762.0, 0.0]", "limits = [-762.0]", ".axis.X.limits: items"),
        ("trunnion-machine/1", "trunnion-machine/2", ".schema: const"),
        ("length = \"mm\"", "length = \"cm\"", ".units.length"),
    ] {
        assert!(good.contains(from), "{from}");
        let found = schema_breaches(&good.replacen(from, to, 1));
        assert!(found.iter().any(|line| line.starts_with(breach)), "{breach}: {found:#?}");
    }
}

/// bc-trunnion with one edit -> the fault's place and first words, and its remedy.
const FAULTS: &[(&str, &str, &str, &str)] = &[
    (
        "[0, 1, 0]\npoint",
        "[0, 0, 1]\npoint",
        "47:10: rotary axes C and B are parallel",
        "all axes are at zero",
    ),
    ("[0, 0, 1]\npoint", "[0, 0, 0]\npoint", "36:10: axis.C.dir is the zero vector", "for example"),
    (
        "[0, 0, 1]\nlimits",
        "[0, 0, 0]\nlimits",
        "28:10: axis.Z.dir is the zero vector",
        "for example",
    ),
    (
        "tool_axis = [0, 0, 1]",
        "tool_axis = [0, 0, 0]",
        "7:13: tool_axis is the zero vector",
        "for example",
    ),
    (
        "[0, 0, 1]\nlimits",
        "[1, 1, 0]\nlimits",
        "28:10: linear axes [\"X\", \"Y\", \"Z\"] lie in one plane",
        "not in one plane",
    ),
    (
        "[-762.0, 0.0]",
        "[0.0, 0.0]",
        "13:10: travel of axis X is empty: [0, 0]",
        "the lower end comes first",
    ),
    (
        "[-35.0, 120.0]",
        "[120.0, -35.0]",
        "49:10: travel of axis B is empty: [120, -35]",
        "the lower end comes first",
    ),
    (
        "home   = 0.0\nprefer",
        "home   = 121.0\nprefer",
        "53:10: home 121 of axis B is outside its travel [-35, 120]",
        "put it inside",
    ),
    (
        "\"X\", \"Y\", \"Z\"",
        "\"X\", \"Z\"",
        "18:7: axis Y is described but is not in the chain",
        "put \"Y\" into the chain",
    ),
    (
        "\"X\", \"Y\", \"Z\"",
        "\"X\", \"Y\", \"W\"",
        "6:10: the chain names axis W, but there is no [axis.W]",
        "add [axis.W]",
    ),
    (
        "\"X\", \"Y\", \"Z\"",
        "\"X\", \"Y\", \"Y\"",
        "6:10: chain [\"w\", \"C\", \"B\", \"b\", \"X\", \"Y\", \"Y\", \"t\"]: \"Y\" is in it twice",
        "for example chain",
    ),
    (
        "[\"w\", \"C\"",
        "[\"C\"",
        "6:10: chain [\"C\", \"B\", \"b\", \"X\", \"Y\", \"Z\", \"t\"]: it must start with \"w\"",
        "for example chain",
    ),
    (
        ", \"t\"]",
        "]",
        "6:10: chain [\"w\", \"C\", \"B\", \"b\", \"X\", \"Y\", \"Z\"]: it must end with \"t\"",
        "for example chain",
    ),
    (
        "\"b\", ",
        "",
        "6:10: chain [\"w\", \"C\", \"B\", \"X\", \"Y\", \"Z\", \"t\"]: it needs \"b\"",
        "for example chain",
    ),
    (
        "prefer = \"positive\"",
        "output = { letter = \"C\" }",
        "54:21: two axes are written with the letter C: C and B",
        "output.letter",
    ),
    (
        "cyclic = 360.0",
        "cyclic = 180.0",
        "38:10: axis C has the period 180, which is 0.5 turns",
        "one turn: 360",
    ),
    (
        "cyclic = 360.0\n",
        "",
        "34:7: axis.C.limits is missing: only a cyclic axis has no ends of travel",
        "add it",
    ),
    (
        "point  = [-381.0, -254.0, -560.0]",
        "",
        "34:7: axis.C.point is missing: a rotary axis turns about a line",
        "add it",
    ),
    (
        "vel    = 150.0",
        "vel    = inf",
        "50:10: `axis.B.vel` = inf is not a finite number",
        "finite",
    ),
    (
        "[-381.0, -254.0, -535.0]",
        "[-381.0, nan, -535.0]",
        "48:19: `axis.B.point.1` = nan is not a finite number",
        "finite",
    ),
    (
        "[-35.0, 120.0]",
        "[-35.0, 1e999]",
        "49:18: `axis.B.limits.1` = 1e999 is not a finite number",
        "finite",
    ),
    (
        "vel    = 150.0",
        "vel    = -150.0",
        "50:10: `axis.B.vel` = -150.0 must be above 0",
        "velocity",
    ),
    (
        "prefer = ",
        "sense = 0.5\nprefer = ",
        "54:9: axis.B.sense = 0.5: must be 1 (ISO 841) or -1",
        "leave it out",
    ),
    (
        "prefer = ",
        "preferr = ",
        "54:1: unknown key `preferr` in [axis.B]",
        "did you mean `prefer`?",
    ),
    ("[axis.B]", "[axis.B]\nkind = \"rotary\"", "47:1: duplicate key", "keep one of the two"),
    ("[axis.B]", "[axis.C]", "45:", ""),
    (
        "axis  = \"Z\"",
        "axis  = \"B\"",
        "71:9: the retracting axis B is a rotary axis",
        "linear axis",
    ),
    (
        "to    = 0.0",
        "to    = 5.0",
        "72:9: the retract goes to 5, outside the travel of Z",
        "inside",
    ),
    ("[singular]", "[singlar]", "64:2: unknown key", "did you mean `singular`?"),
    ("length = \"mm\"", "length = \"cm\"", "5:21: `units.length` cannot be \"cm\"", "It can be"),
];

#[test]
fn every_fault_is_reported_at_its_line_with_a_remedy() {
    let (_, good) = BUILT_IN[1];
    let mut missing = Vec::new();
    for (from, to, place, remedy) in FAULTS {
        assert!(good.contains(from), "{from}");
        let faults = parse(&good.replacen(from, to, 1)).err().unwrap_or_default();
        let reported: Vec<String> = faults.iter().map(ToString::to_string).collect();
        let hit = reported.iter().any(|fault| fault.starts_with(place) && fault.contains(remedy));
        if !hit || faults.iter().any(|fault| fault.help.is_empty()) {
            missing.push(format!(
                "{from} -> {to}\n wanted {place} .. {remedy}\n found  {reported:#?}"
            ));
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// One fault must not hide another, nor make up a third.
#[test]
fn faults_are_reported_together_and_once() {
    let (_, good) = BUILT_IN[1];
    let bad = good
        .replacen("tool_axis = [0, 0, 1]", "tool_axis = [0, 0]", 1)
        .replacen("vel    = 500.0", "", 1)
        .replacen("[-508.0, 0.0]", "[0.0, -508.0]", 1)
        .replacen("[0, 1, 0]\npoint", "[0, 0, 0]\npoint", 1)
        .replacen("servo_period          = 0.001", "servo_period = \"fast\"", 1);
    let reported: Vec<String> = parse(&bad).unwrap_err().iter().map(ToString::to_string).collect();
    let starts = [
        "7:13: `tool_axis` needs 3 entries",
        "10:7: missing key `vel` in [axis.X]",
        "21:10: travel of axis Y is empty",
        "47:10: axis.B.dir is the zero vector",
        "57:16: `cycle.servo_period` must be a number",
    ];
    assert_eq!(reported.len(), starts.len(), "{reported:#?}");
    for (fault, start) in reported.iter().zip(starts) {
        assert!(fault.starts_with(start), "{start}: {reported:#?}");
    }
    // What axes are to each other does not wait for the chain.
    let bad = good.replacen(", \"t\"]", "]", 1).replacen("[0, 1, 0]\npoint", "[0, 0, 1]\npoint", 1);
    let bad = bad.replacen("[0, 0, 1]\nlimits", "[1, 1, 0]\nlimits", 1);
    let reported: Vec<String> = parse(&bad).unwrap_err().iter().map(ToString::to_string).collect();
    let words = ["must end with \"t\"", "lie in one plane", "are parallel"];
    assert!(
        reported.len() == 3 && reported.iter().zip(words).all(|(fault, word)| fault.contains(word)),
        "{reported:#?}"
    );
    // What is missing is what was misspelt.
    let bad = good.replacen("limits = [-35.0", "limit = [-35.0", 1);
    let reported = parse(&bad).unwrap_err();
    assert!(reported.len() == 1 && reported[0].help == "did you mean `limits`?", "{reported:?}");
    // Nothing is known of a machine without units but what each line says.
    let bad = good.replacen("angle = \"deg\"", "angle = \"grad\"", 1);
    assert_eq!(parse(&bad).unwrap_err().len(), 1);
}

#[test]
fn paper_000_is_layout_13_with_the_table_moving() {
    let mut text =
        BUILT_IN.iter().find(|(name, _)| name.starts_with("layout-13")).unwrap().1.to_owned();
    text = text.replace("[\"w\", \"b\", \"X\", \"Y\", \"Z\"", "[\"w\", \"X\", \"Y\", \"b\", \"Z\"");
    let moving = parse(&text).unwrap().machine;
    assert_eq!(moving.layout(), Some(13));
    let setup = Setup::new(V3::new(1500.0, 1000.0, -900.0), [0.0; 3], 100.0);
    let [moving, fixed] = [moving, machine("layout-13-ca-head-head")]
        .map(|machine| Kinematics::new(&machine, &setup));
    let q = [1500.0, 1100.0, -400.0, 0.7, 0.4].into();
    // By ISO 841 it does not matter which side of the bed a slide is on.
    assert_eq!(moving.forward(&q), fixed.forward(&q));
}
