//! `trunnion machine import`: every sample against the formula of its manual, and files that cannot be used.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;
use binary::{root, stderr, trunnion};
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;
use trunnion::files::machine::parse;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nalgebra::{Rotation3, UnitVector3, Vector3};
use trunnion::types::AxisVector;

type V3 = Vector3<f64>;

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Length of the tool in all comparisons \[mm\].
const LENGTH: f64 = 137.5;

/// Copies the samples into a folder of their own.
fn samples() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(root().join("fixtures/machine-descriptions")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    folder
}

fn import(folder: &Path, file: &str, given: &[&str]) -> Machine {
    let mut arguments = vec!["machine", "import", file, "-o", "machine.toml"];
    for one in given {
        arguments.extend(["--set", one]);
    }
    let output = trunnion(folder, &arguments);
    assert!(output.status.success(), "{file}: {}", stderr(&output));
    assert!(stdout(&output).contains("became"), "{}", stdout(&output));
    let check = trunnion(folder, &["machine", "check", "machine.toml"]);
    assert!(check.status.success(), "{file}: {}", stdout(&check));
    let text = fs::read_to_string(folder.join("machine.toml")).unwrap();
    // Another import into the same file would be refused.
    fs::remove_file(folder.join("machine.toml")).unwrap();
    parse(&text).unwrap().machine
}

/// Compares the tip at many positions with a formula of positions by axis name.
fn compare(machine: &Machine, formula: impl Fn(&dyn Fn(&str) -> f64) -> V3) {
    compare_in(&Setup::default(), machine, formula);
}

/// The same in a workpiece frame.
fn compare_in(setup: &Setup, machine: &Machine, formula: impl Fn(&dyn Fn(&str) -> f64) -> V3) {
    let setup = Setup { tool_length: LENGTH, ..*setup };
    let kinematics = Kinematics::new(machine, &setup);
    for step in 0..50 {
        let t = f64::from(step);
        let wave = |rate: f64, size: f64| size * (rate * t).sin();
        let q = AxisVector::from([
            wave(0.7, 200.0),
            wave(1.1, 150.0),
            wave(0.4, 180.0),
            wave(1.7, 3.0),
            wave(0.9, 1.5),
        ]);
        let at = |name: &str| q[machine.index_of(name).unwrap()];
        let (found, expected) = (kinematics.forward(&q).tip.coords, formula(&at));
        let off = (found - expected).norm();
        assert!(off < 1e-9, "{}: {off:e} mm at {q:?}: {found:?} {expected:?}", machine.name);
    }
}

fn axes(at: &dyn Fn(&str) -> f64) -> V3 {
    V3::new(at("X"), at("Y"), at("Z"))
}

fn tool() -> V3 {
    V3::new(0.0, 0.0, -LENGTH)
}

fn turn(dir: V3, angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&UnitVector3::new_normalize(dir), angle)
}

/// The place that a body turned about a line brings to `place`.
fn back(place: V3, point: V3, dir: V3, angle: f64) -> V3 {
    point + turn(dir, -angle) * (place - point)
}

#[test]
fn linuxcnc_trunnion() {
    let folder = samples();
    let machine = import(folder.path(), "xyzac-trt.ini", &["linear.jerk=5000", "rotary.jerk=3000"]);
    let (r, dy, dz) = (V3::new(3.5, -1.25, -40.0), 20.0, 10.0 + LENGTH);
    compare(&machine, |at| {
        let ((sa, ca), (sc, cc)) = (at("A").sin_cos(), at("C").sin_cos());
        let [x, y, z] = (axes(at) - r - V3::new(0.0, dy, dz)).into();
        // The position of the control is that of the tip, a tool length higher.
        let position = V3::new(
            cc * x + sc * ca * y + sc * sa * z + sc * dy,
            -sc * x + cc * ca * y + cc * sa * z + cc * dy,
            -sa * y + ca * z + dz,
        );
        position + r + tool()
    });
    assert!(machine.axes[3].cyclic && (machine.axes[0].vel - 20.0).abs() < 1e-12);
}

#[test]
fn linuxcnc_bridge_mill() {
    let folder = samples();
    let machine = import(folder.path(), "5axis.ini", &["linear.jerk=5000", "rotary.jerk=3000"]);
    assert_eq!(machine.chain, ["w", "b", "X", "Y", "Z", "C", "B", "t"]);
    // W has the tool length: the position of the control is a tool length above the tip at B = 0.
    compare(&machine, |at| {
        let (r, t, p) = (187.25 + LENGTH, at("C"), std::f64::consts::PI - at("B"));
        let arm = V3::new(p.sin() * t.cos(), p.sin() * t.sin(), p.cos());
        axes(at) + arm * r + V3::z() * 187.25
    });
    // Nothing connected: the module has a length of its own.
    fs::write(folder.path().join("5axis.hal"), "# nothing\n").unwrap();
    let machine = import(folder.path(), "5axis.ini", &["linear.jerk=5000", "rotary.jerk=3000"]);
    assert!(machine.axes.iter().skip(3).all(|axis| (axis.point.z - 250.0).abs() < 1e-12));
}

/// As in the sample configuration, the pin is driven by a component: its value is asked for.
#[test]
fn a_length_that_a_component_computes_is_asked_for() {
    let folder = samples();
    let hal = "net :pivot-len <= pivotsum.out\nnet :pivot-len => 5axiskins.pivot-length\n";
    fs::write(folder.path().join("5axis.hal"), hal).unwrap();
    let given = ["linear.jerk=5000", "rotary.jerk=3000"];
    let mut arguments = vec!["machine", "import", "5axis.ini"];
    arguments.extend(given.iter().flat_map(|one| ["--set", one]));
    let output = trunnion(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(said.contains("does not state point of B, C: 5axiskins.pivot-length"), "{said}");
    assert!(said.contains(":pivot-len") && said.contains("give axis.B.point"), "{said}");
    let given = [given[0], given[1], "rotary.point=0,0,200"];
    let machine = import(folder.path(), "5axis.ini", &given);
    assert!((machine.axes[3].point.z - 200.0).abs() < 1e-12);
}

/// The formula of the module in inch, without its tool offset.
#[test]
fn linuxcnc_two_rotary_tables() {
    let folder = samples();
    let machine = import(folder.path(), "xyzab-tdr.ini", &["linear.jerk=5000", "rotary.jerk=3000"]);
    assert_eq!(machine.chain, ["w", "A", "B", "b", "X", "Y", "Z", "t"]);
    let (r, dz) = (V3::new(0.5, -0.25, -4.0) * 25.4, -0.4 * 25.4);
    compare(&machine, |at| {
        let ((sa, ca), (sb, cb)) = (at("A").sin_cos(), at("B").sin_cos());
        let [px, py, pz] = (axes(at) + tool() - r).into();
        r + V3::new(
            cb * px + sb * pz,
            sa * sb * px + ca * py - cb * sa * pz + sa * dz,
            -ca * sb * px + sa * py + ca * cb * pz - ca * dz + dz,
        )
    });
    assert!((machine.axes[0].vel - 25.4).abs() < 1e-12);
    let limits = machine.axes[0].limits;
    assert!((limits.low + 203.2).abs() < 1e-9 && (limits.high - 203.2).abs() < 1e-9);
}

/// The vectors hold at other positions of the rotary axes: the formula turns by the difference.
#[test]
fn siemens_angle_offsets() {
    let folder = samples();
    let head = import(folder.path(), "siemens-head-angles.mpf", &[]);
    let (l2, l3) = (V3::new(0.0, -5.0, 385.5), V3::new(-0.2, 0.1, -235.0));
    let off = |degrees: f64| degrees.to_radians();
    compare(&head, |at| {
        let c = turn(V3::z(), at("C") - off(90.0));
        let a = turn(V3::x(), at("A") + off(15.0));
        axes(at) - (l2 + l3) + c * (l2 + a * (l3 + tool()))
    });
    let table = import(folder.path(), "siemens-table-angles.mpf", &[]);
    let (l2, l3) = (V3::new(10.0, 20.0, -300.0), V3::new(0.25, 0.5, -30.5));
    let neutral =
        |place: V3, a: f64, c: f64| back(back(place, l2, -V3::x(), a), l2 + l3, -V3::z(), c);
    // The frame of the control is that of the table where the vectors hold.
    let turned = turn(-V3::z(), off(45.0)) * turn(-V3::x(), off(30.0));
    let origin = turned.inverse() * (V3::zeros() - neutral(V3::zeros(), -off(30.0), -off(45.0)));
    let setup = Setup { origin, rotation: turned.inverse(), ..Setup::default() };
    compare_in(&setup, &table, |at| {
        neutral(axes(at) + tool(), at("A") - off(30.0), at("C") - off(45.0))
    });
    let mixed = import(folder.path(), "siemens-mixed-angles.mpf", &[]);
    let (l2, l3) = (V3::new(1.5, 0.0, -180.0), V3::new(50.0, 60.0, -450.0));
    let turned = turn(-V3::z(), off(-60.0));
    let origin = l3 - turned.inverse() * l3;
    let setup = Setup { origin, rotation: turned.inverse(), ..Setup::default() };
    compare_in(&setup, &mixed, |at| {
        let tip = axes(at) - l2 + turn(V3::y(), -at("B")) * (l2 + tool());
        back(tip, l3, -V3::z(), at("C") + off(60.0))
    });
    let output = trunnion(folder.path(), &["machine", "import", "siemens-table-angles.mpf"]);
    let said = stdout(&output);
    assert!(said.contains("as the table stands with A at 30 deg and C at 45 deg"), "{said}");
}

#[test]
fn fanuc_tilted_axes() {
    let folder = samples();
    let jerk = ["linear.jerk=40000", "rotary.jerk=6000"];
    let half = 0.5_f64.sqrt();
    let head = import(folder.path(), "fanuc-tilted.prm", &jerk);
    let (de, a) = (V3::new(-1.5, 0.0, 180.0), V3::new(50.0, 60.0, -450.0));
    compare(&head, |at| {
        let tip = axes(at) + de + turn(V3::new(0.0, half, half), at("B")) * (-de + tool());
        back(tip, a, V3::z(), at("C"))
    });
    let table = import(folder.path(), "fanuc-tilted-table.prm", &jerk);
    let a = V3::new(10.0, 20.0, -300.0);
    let b = a + V3::new(0.25, -0.5, -30.5);
    let [(s1, c1), (s2, c2)] = [-30.0_f64, 20.0].map(|degrees| degrees.to_radians().sin_cos());
    compare(&table, |at| {
        let tip = back(axes(at) + tool(), a, V3::new(c1, s1, 0.0), -at("A"));
        back(tip, b, V3::new(s2, 0.0, c2), -at("C"))
    });
}

#[test]
fn siemens_head_table_and_both() {
    let folder = samples();
    let head = import(folder.path(), "siemens-head.mpf", &[]);
    let (l2, l3) = (V3::new(0.0, -5.0, 385.5), V3::new(-0.2, 0.1, -235.0));
    compare(&head, |at| {
        let (c, a) = (turn(V3::z(), at("C")), turn(V3::x(), at("A")));
        axes(at) - (l2 + l3) + c * (l2 + a * (l3 + tool()))
    });
    assert!((head.axes[3].vel - 150.0_f64.to_radians()).abs() < 1e-12);
    let table = import(folder.path(), "siemens-table.mpf", &[]);
    let (l2, l3) = (V3::new(10.0, 20.0, -300.0), V3::new(0.25, 0.5, -30.5));
    compare(&table, |at| {
        let tip = back(axes(at) + tool(), l2, -V3::x(), at("A"));
        back(tip, l2 + l3, -V3::z(), at("C"))
    });
    let mixed = import(folder.path(), "siemens-mixed.mpf", &[]);
    let (l2, l3) = (V3::new(1.5, 0.0, -180.0), V3::new(50.0, 60.0, -450.0));
    compare(&mixed, |at| {
        let tip = axes(at) - l2 + turn(V3::y(), at("B")) * (l2 + tool());
        back(tip, l3, -V3::z(), at("C"))
    });
}

#[test]
fn fanuc_table_head_and_both() {
    let folder = samples();
    let jerk = ["linear.jerk=40000", "rotary.jerk=6000"];
    let table = import(folder.path(), "fanuc-table.prm", &jerk);
    let a = V3::new(10.0, 20.0, -300.0);
    let b = a + V3::new(0.25, -0.5, -30.5);
    // Both count left-handed as the table turns.
    compare(&table, |at| back(back(axes(at) + tool(), a, V3::y(), -at("B")), b, V3::z(), -at("C")));
    let head = import(folder.path(), "fanuc-head.prm", &jerk);
    let (de, ef) = (V3::new(0.2, -0.1, 235.0), V3::new(0.0, 5.0, 150.0));
    compare(&head, |at| {
        let (c, a) = (turn(V3::z(), at("C")), turn(V3::x(), at("A")));
        axes(at) + de + ef + c * (-ef + a * (-de + tool()))
    });
    // This table counts the other way than ISO 841 would.
    let mixed = import(folder.path(), "fanuc-mixed.prm", &jerk);
    let (de, a) = (V3::new(-1.5, 0.0, 180.0), V3::new(50.0, 60.0, -450.0));
    compare(&mixed, |at| {
        let tip = axes(at) + de + turn(V3::y(), at("B")) * (-de + tool());
        back(tip, a, V3::z(), at("C"))
    });
}

#[test]
fn heidenhain_haas_and_freecad() {
    let folder = samples();
    let limits = [
        "axis.X.limits=-300,300",
        "axis.Y.limits=-300,300",
        "axis.Z.limits=-300,300",
        "axis.B.limits=-95,95",
        "axis.C.limits=endless",
    ];
    let rates = [
        "linear.vel=500",
        "linear.acc=3000",
        "linear.jerk=40000",
        "rotary.vel=120",
        "rotary.acc=600",
        "rotary.jerk=9000",
    ];
    let given: Vec<&str> = limits.into_iter().chain(rates).collect();
    let machine = import(folder.path(), "heidenhain.tab", &given);
    assert_eq!(machine.chain, ["w", "C", "Z", "b", "X", "Y", "B", "t"]);
    let (b, c) = (V3::new(0.016, 0.0, 250.051), V3::new(0.016 - 298.923, 200.172, 250.051));
    compare(&machine, |at| {
        let head = V3::new(at("X"), at("Y"), 0.0) + b + turn(V3::y(), at("B")) * (-b + tool());
        back(head + V3::z() * at("Z"), c, V3::z(), -at("C"))
    });
    let haas: Vec<&str> = given.iter().copied().chain(["chain=w,C,B,b,X,Y,Z,t"]).collect();
    let machine = import(folder.path(), "haas.txt", &haas);
    let p = V3::new(-15.0, -10.0, -21.0625) * 25.4;
    let trunnion = |p: V3, q: V3, tilt: V3, name: &'static str| {
        move |at: &dyn Fn(&str) -> f64| {
            back(back(axes(at) + tool(), p, tilt, -at(name)), q, V3::z(), -at("C"))
        }
    };
    compare(&machine, trunnion(p, p, V3::y(), "B"));
    let freecad = ["linear.acc=3000", "linear.jerk=40000", "rotary.acc=600", "rotary.jerk=9000"];
    let machine = import(folder.path(), "freecad.fcm", &freecad);
    assert_eq!(machine.chain, ["w", "C", "A", "b", "X", "Y", "Z", "t"]);
    let (p, q) = (V3::new(10.0, 20.0, -300.0), V3::new(10.25, 20.5, -330.5));
    compare(&machine, trunnion(p, q, V3::x(), "A"));
}

/// A configuration that trunnion wrote is read back to the same machine.
#[test]
fn a_configuration_of_linuxcnc_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["bc-trunnion", "gantry-ca-fork", "dmu-nutating45"] {
        let written = trunnion(folder.path(), &["linuxcnc", name, "-o", name]);
        assert!(written.status.success(), "{}", stderr(&written));
        let ini =
            fs::read_dir(folder.path().join(name)).unwrap().map(|entry| entry.unwrap().path());
        let ini =
            ini.into_iter().find(|path| path.extension().is_some_and(|end| end == "ini")).unwrap();
        let back = import(folder.path(), ini.to_str().unwrap(), &[]);
        let first = parse(trunnion::files::machine::built_in(name).unwrap()).unwrap().machine;
        assert_eq!(back.chain, first.chain);
        for (a, b) in back.axes.iter().zip(&first.axes) {
            assert!(
                (*a.dir - *b.dir).norm() < 1e-15 && (a.point - b.point).norm() < 1e-12,
                "{}",
                a.name
            );
            assert!(
                a.cyclic == b.cyclic
                    && (a.vel - b.vel).abs() < 1e-6
                    && (a.sense - b.sense).abs() < 1e-15
            );
        }
    }
}

#[test]
fn what_cannot_be_used_is_said_with_its_line() {
    let folder = samples();
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let head = text("siemens-head.mpf");
    let fanuc = text("fanuc-table.prm");
    for (name, content, expected) in [
        ("none.txt", "G1 X5\n".to_owned(), "marks of no format"),
        (
            "jerk.prm",
            fanuc.clone(),
            "the file does not state jerk of X, Y, Z\n  help: --set KEY=VALUE: give axis.X.jerk (mm/s3), or linear.jerk",
        ),
        ("type.prm", fanuc.replace("N19680 P12", "N19680 P3"), "type.prm:8: parameter 19680 = 3"),
        (
            "gone.prm",
            fanuc.replace("N19704", "(N19704)"),
            "19704 is not in the file; axis.point is made of it",
        ),
        (
            "word.prm",
            fanuc.replace("N19700 P10.0", "N19700 P1O.0"),
            "word.prm:19: O.0 is no word of a parameter",
        ),
        (
            "twice.prm",
            fanuc.replace("N19700 P10.0", "N19700 P10.0\nN19700 P11.0"),
            "19700 is 11.0 here and 10.0 in line",
        ),
        (
            "open.mpf",
            head.replace("JOINT_OFFSET_1[2]=385.5", "JOINT_OFFSET_1[2]=380.5"),
            "the offsets contradict each other in coordinate 2",
        ),
        (
            "angle.mpf",
            head.replace(
                "N24550 $MC_TRAFO5_BASE_TOOL_1[0]",
                "N24510 $MC_TRAFO5_ROT_AX_OFFSET_1[1]=2\nN24520 $MC_TRAFO5_ROT_SIGN_IS_PLUS_1[1]=0\nN24550 $MC_TRAFO5_BASE_TOOL_1[0]",
            ),
            "angle.mpf:16: $MC_TRAFO5_ROT_AX_OFFSET_1[1] = 2 deg and",
        ),
        ("base.tab", text("heidenhain.tab").replace("MachBase", "        "), "no row MachBase"),
        (
            "unit.txt",
            text("haas.txt").replace("9 DIMENSIONING INCH\n", ""),
            "9 is not in the file; the unit of all lengths",
        ),
        (
            "kins.ini",
            text("xyzac-trt.ini").replace("= xyzac-trt-kins", "= maxkins"),
            "kins.ini:7: KINEMATICS = maxkins: this module is not read\n  help: xyzac-trt-kins",
        ),
        (
            "units.ini",
            text("5axis.ini").replace("LINEAR_UNITS = mm", "LINEAR_UNITS = cm"),
            "units.ini:18: LINEAR_UNITS = cm is no unit that is read\n  help: mm and inch are read",
        ),
        (
            "radian.ini",
            text("5axis.ini").replace("ANGULAR_UNITS = degree", "ANGULAR_UNITS = rad"),
            "radian.ini:19: ANGULAR_UNITS = rad: only degrees are read",
        ),
        (
            "pivot.ini",
            text("5axis.ini").replace("PIVOT = 187.25", "PIVOT = long"),
            "5axis.hal:2, setp 5axiskins.pivot-length) = \"long\" is not a number",
        ),
        (
            "tilt.prm",
            text("fanuc-tilted.prm").replace("N19683 P45.0\n", ""),
            "19683 is not in the file; axis.dir is made of it",
        ),
    ] {
        fs::write(folder.path().join(name), content).unwrap();
        let output = trunnion(folder.path(), &["machine", "import", name, "-o", "out.toml"]);
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert!(stderr(&output).contains(expected), "{name}: {}", stderr(&output));
        assert!(!folder.path().join("out.toml").exists());
    }
    // One number in two forms contradicts nothing.
    fs::write(
        folder.path().join("same.prm"),
        fanuc.replace("N19700 P10.0", "N19700 P10.0\nN19700 P10"),
    )
    .unwrap();
    let same = trunnion(folder.path(), &["machine", "import", "same.prm"]);
    assert!(!stderr(&same).contains("19700"), "{}", stderr(&same));
    let output =
        trunnion(folder.path(), &["machine", "import", "fanuc-table.prm", "--set", "axis.C.jrk=3"]);
    assert!(stderr(&output).contains("did you mean jerk?"), "{}", stderr(&output));
}
