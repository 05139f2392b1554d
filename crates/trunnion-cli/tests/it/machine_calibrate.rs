//! `trunnion machine calibrate` and `trunnion post --to-calibrated`, as a shop uses them.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the test prints its figure")]

use crate::binary;
use binary::{json, outcome, trunnion};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use trunnion::files::machine::{built_in, parse, write};
use trunnion::machine::{Kinematics, Machine, MachineSpec, Setup};
use trunnion::nalgebra::{Matrix3, Vector3};
use trunnion::types::AxisVector;

type V3 = Vector3<f64>;

const ORIGIN: [f64; 3] = [-381.0, -254.0, -505.0];
const LENGTH: f64 = 120.0;

/// Pseudo-random numbers in `[-1, 1)`.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self, size: f64) -> V3 {
        V3::from_fn(|_, _| size * self.next())
    }
}

fn ideal() -> MachineSpec {
    parse(built_in("bc-trunnion").unwrap()).unwrap().spec
}

/// The machine as it was built: X and the nose as in the file, all else a little off.
fn real() -> Machine {
    let mut dice = Dice(7);
    let mut spec = ideal();
    for axis in spec.axes.iter_mut().filter(|axis| axis.name != "X") {
        let tilt = if axis.name == "Y" { V3::z() * 2e-4 } else { dice.point(5e-4) };
        let dir = V3::from(axis.dir);
        axis.dir = (dir + tilt.cross(&dir)).into();
        axis.point = axis.point.map(|point| (V3::from(point) + dice.point(0.15)).into());
    }
    let tool = V3::from(spec.tool_axis);
    spec.tool_axis = (tool + dice.point(2e-4).cross(&tool)).into();
    Machine::new(spec).unwrap()
}

/// Axis positions at which a probe of that length finds the sphere, with noise.
fn found(real: &Machine, sphere: V3, length: f64, rotary: [f64; 2], dice: &mut Dice) -> AxisVector {
    let setup = Setup { tool_length: length, ..Setup::default() };
    let kinematics = Kinematics::new(real, &setup);
    let mut q = AxisVector::from([0.0, 0.0, 0.0, rotary[0], rotary[1]]);
    let linear = Matrix3::from_columns(&kinematics.tip_levers(&q).linear).try_inverse().unwrap();
    let way = linear * (sphere - kinematics.forward(&q).tip.coords);
    for axis in 0..3 {
        q[axis] = way[axis] + 0.0015 * dice.next();
    }
    q
}

fn row(q: &AxisVector) -> String {
    format!("{:.5},{:.5},{:.5},{:.6},{:.6}", q[0], q[1], q[2], q[3].to_degrees(), q[4].to_degrees())
}

/// A table of probed spheres: two lengths and two spheres, if asked for.
fn table(lengths: &[f64], tilts: &[f64]) -> String {
    let (real, mut dice) = (real(), Dice(3));
    let center = V3::new(-381.0, -254.0, -560.0);
    let spheres = [center + V3::new(160.0, 0.0, 190.0), center + V3::new(-40.0, 150.0, 250.0)];
    let mut text = "# probed spheres\nX_mm,Y_mm,Z_mm,C_deg,B_deg,length_mm,sphere\n".to_owned();
    for (index, turn) in (0..20).map(|index: usize| (index, 0.31 * index as f64)) {
        for length in lengths {
            let (sphere, tilt) = (index % 2, tilts[index % tilts.len()].to_radians());
            let q = found(&real, spheres[sphere], *length, [turn, tilt], &mut dice);
            writeln!(text, "{},{length},{}", row(&q), sphere + 1).unwrap();
        }
    }
    text
}

const TILTS: [f64; 5] = [-30.0, 0.0, 45.0, 60.0, 20.0];

fn calibrated() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("probe.csv"), table(&[80.0, 260.0], &TILTS)).unwrap();
    let output = trunnion(
        folder.path(),
        &["machine", "calibrate", "probe.csv", "-m", "bc-trunnion", "-o", "calibrated.toml"],
    );
    let (code, text, errors) = outcome(&output);
    assert_eq!(code, Some(0), "{text}{errors}");
    assert!(
        text.contains("C.offset.x") && text.contains("squareness: tilt of Y about z"),
        "{text}"
    );
    folder
}

/// Compares a calibrated file with the real machine.
fn compare(text: &str) {
    let machine = parse(text).unwrap().machine;
    for (a, b) in machine.axes.iter().zip(&real().axes) {
        assert!(a.dir.cross(&b.dir).norm() < 15e-6, "{}: {:e}", a.name, a.dir.cross(&b.dir).norm());
        let apart = a.point - b.point;
        assert!((apart - *b.dir * b.dir.dot(&apart)).norm() < 0.004, "{}: {apart}", a.name);
    }
}

/// A ball bar of 100 mm between a ball in the spindle and two on the table, all around.
#[test]
fn ball_bar_radii_give_the_real_machine() {
    let (real, mut dice) = (real(), Dice(11));
    let center = V3::new(-381.0, -254.0, -560.0);
    let spheres = [center + V3::new(160.0, 0.0, 190.0), center + V3::new(-40.0, 150.0, 250.0)];
    let mut text = "X_mm,Y_mm,Z_mm,C_deg,B_deg,length_mm,sphere,radius_mm\n".to_owned();
    for index in 0..400 {
        let (sphere, length) = (index % 2, [80.0, 260.0][index / 2 % 2]);
        let rotary = [3.1 * dice.next(), TILTS[index % 5].to_radians()];
        let bar = dice.point(1.0).normalize() * 100.0;
        let q = found(&real, spheres[sphere] + bar, length, rotary, &mut dice);
        if real.out_of_travel(&q).is_none() {
            writeln!(text, "{},{length},{},100", row(&q), sphere + 1).unwrap();
        }
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bar.csv"), text).unwrap();
    let arguments =
        ["machine", "calibrate", "bar.csv", "-m", "bc-trunnion", "-o", "calibrated.toml"];
    let (code, text, errors) = outcome(&trunnion(folder.path(), &arguments));
    assert_eq!(code, Some(0), "{text}{errors}");
    compare(&fs::read_to_string(folder.path().join("calibrated.toml")).unwrap());
}

#[test]
fn a_calibrated_file_is_the_real_machine() {
    let folder = calibrated();
    let text = fs::read_to_string(folder.path().join("calibrated.toml")).unwrap();
    assert!(
        text.starts_with("# Calibrated by trunnion from bc-trunnion and 40 readings: probe.csv.\n")
    );
    compare(&text);
    let check = trunnion(folder.path(), &["machine", "check", "calibrated.toml"]);
    assert_eq!(check.status.code(), Some(0));
}

/// Axis positions of a program: its words count from G54, as the head states it, and the end of the tool.
fn words(text: &str) -> Vec<AxisVector> {
    let head = text.lines().find_map(|line| line.strip_prefix("(G54 must hold X ")).unwrap();
    let held: Vec<f64> = head.split([' ', ';']).filter_map(|word| word.parse().ok()).collect();
    let offset = AxisVector::from([held[0], held[1], held[2] + LENGTH, 0.0, 0.0]);
    let mut q: AxisVector = AxisVector::zeros();
    let mut all = Vec::new();
    // Comments, and moves in machine coordinates, are no poses.
    let move_of = |line: &&str| !line.starts_with(['(', ';', '%']) && !line.contains("G53");
    for line in text.lines().filter(move_of) {
        let (mut moved, start) = (false, q);
        for word in line.split_whitespace() {
            let Some(axis) =
                ["X", "Y", "Z", "C", "B"].iter().position(|letter| word.starts_with(letter))
            else {
                continue;
            };
            let Ok(value) = word[1..].parse::<f64>() else { continue };
            q[axis] = if axis < 3 { value } else { value.to_radians() };
            moved = true;
        }
        // Cuts have a feed; approaches and links go their own way.
        if moved && line.contains('F') {
            // The cut begins where the approach ends.
            if all.is_empty() {
                all.push(start + offset);
            }
            all.push(q + offset);
        }
    }
    all
}

/// The part made with the wrong file, the machine measured, the program posted anew.
#[test]
fn a_program_posted_to_the_calibrated_machine_is_fifty_times_nearer() {
    let folder = calibrated();
    let mut cl = "UNITS/MM\nLOADTL/1\nFEDRAT/600,MMPM\n".to_owned();
    for step in 0..30 {
        let t = 0.1 * f64::from(step);
        let axis = V3::new(0.5 * t.sin(), 0.4 * t.cos(), 1.0).normalize();
        let tip = V3::new(80.0 * t.cos(), 60.0 * t.sin(), 20.0 + 5.0 * t);
        writeln!(
            cl,
            "GOTO/{:.6},{:.6},{:.6},{:.9},{:.9},{:.9}",
            tip.x, tip.y, tip.z, axis.x, axis.y, axis.z
        )
        .unwrap();
    }
    cl.push_str("FINI\n");
    fs::write(folder.path().join("part.cls"), cl).unwrap();
    let origin = ORIGIN.map(|part| part.to_string()).join(",");
    let common =
        ["-d", "g93", "--tool-length", "120", "--tolerance", "0.001,0.005", "--origin", &origin];
    let post = |arguments: &[&str]| {
        let all: Vec<&str> = ["post"].iter().chain(arguments).chain(&common).copied().collect();
        let (code, text, errors) = outcome(&trunnion(folder.path(), &all));
        assert_eq!(code, Some(0), "{text}{errors}");
    };
    post(&["part.cls", "-m", "bc-trunnion", "-o", "ideal.nc"]);
    post(&["ideal.nc", "-m", "bc-trunnion", "--to-calibrated", "calibrated.toml", "-o", "real.nc"]);
    let setup = Setup::new(ORIGIN.into(), [0.0; 3], LENGTH);
    let on_real = Kinematics::new(&real(), &setup);
    let meant = Kinematics::new(&Machine::new(ideal()).unwrap(), &setup);
    let ideal_words = words(&fs::read_to_string(folder.path().join("ideal.nc")).unwrap());
    let real_words = words(&fs::read_to_string(folder.path().join("real.nc")).unwrap());
    assert!(ideal_words.len() > 25 && real_words.len() > 25);
    let meant: Vec<V3> = ideal_words.iter().map(|q| meant.forward(q).tip.coords).collect();
    let before =
        ideal_words.iter().zip(&meant).map(|(q, tip)| (on_real.forward(q).tip.coords - tip).norm());
    let before = before.fold(0.0, f64::max);
    // The new program may have more blocks: each is compared with the meant path.
    let off_path = |tip: V3| {
        let segment = |pair: &[V3]| {
            let along = pair[1] - pair[0];
            let share =
                ((tip - pair[0]).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
            (pair[0] + along * share - tip).norm()
        };
        meant.windows(2).map(segment).fold(f64::INFINITY, f64::min)
    };
    let after =
        real_words.iter().map(|q| off_path(on_real.forward(q).tip.coords)).fold(0.0, f64::max);
    println!("worst tip error {before:.4} mm before, {after:.5} mm after");
    assert!(before > 0.05 && after * 50.0 < before, "{before} mm before, {after} mm after");
}

#[test]
fn what_the_readings_leave_open_is_named_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("short.csv"), table(&[100.0], &TILTS)).unwrap();
    let arguments = ["machine", "calibrate", "short.csv", "-m", "bc-trunnion"];
    let (code, text, _) = outcome(&trunnion(folder.path(), &arguments));
    assert_eq!(code, Some(1), "{text}");
    // One length: the tilt of the tool is an offset of everything else.
    assert!(text.contains("tool.tilt.x") && text.contains("open"), "{text}");
    assert!(
        text.contains("the readings do not separate")
            && text.contains("mm farther from the spindle"),
        "{text}"
    );
    fs::write(folder.path().join("flat.csv"), table(&[100.0, 200.0], &[0.0])).unwrap();
    let flat = trunnion(
        folder.path(),
        &["machine", "calibrate", "flat.csv", "-m", "bc-trunnion", "--json"],
    );
    let summary = json(&flat);
    assert!(!summary["confounded"].as_array().unwrap().is_empty(), "{summary}");
    assert!(summary["further"][0]["words"].as_str().unwrap().contains("B "), "{summary}");
}

#[test]
fn readings_that_contradict_are_named_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let text = table(&[80.0, 260.0], &TILTS);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let (x, rest) = lines[20].split_once(',').unwrap();
    lines[20] = format!("{},{rest}", x.parse::<f64>().unwrap() + 0.2);
    fs::write(folder.path().join("probe.csv"), lines.join("\n")).unwrap();
    let (code, text, _) = outcome(&trunnion(
        folder.path(),
        &["machine", "calibrate", "probe.csv", "-m", "bc-trunnion"],
    ));
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("probe.csv:21: this reading is 0.1"), "{text}");
}

#[test]
fn readings_of_another_machine_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("probe.csv"), table(&[80.0, 260.0], &TILTS)).unwrap();
    let mut other = ideal();
    other.axes.iter_mut().filter(|axis| axis.name == "C").for_each(|axis| axis.sense = -1.0);
    fs::write(folder.path().join("other.toml"), write(&other, &[])).unwrap();
    let run = |path: &Path, arguments: &[&str]| {
        let all: Vec<&str> = ["machine", "calibrate"].iter().chain(arguments).copied().collect();
        let (code, _, errors) = outcome(&trunnion(path, &all));
        assert_eq!(code, Some(2), "{errors}");
        errors
    };
    let errors = run(folder.path(), &["probe.csv", "-m", "other.toml", "-o", "x.toml"]);
    assert!(
        errors.contains("if C turns the other way") && errors.contains("sense = -1"),
        "{errors}"
    );
    let few: String =
        table(&[100.0], &TILTS).lines().take(4).map(|line| format!("{line}\n")).collect();
    fs::write(folder.path().join("few.csv"), few).unwrap();
    let errors = run(folder.path(), &["few.csv", "-m", "bc-trunnion"]);
    assert!(errors.contains("few.csv: 6 numbers were read, and they depend on"), "{errors}");
    let output = trunnion(
        folder.path(),
        &[
            "post",
            "probe.csv",
            "-m",
            "bc-trunnion",
            "--to-calibrated",
            "bc-trunnion",
            "-d",
            "fanuc",
            "-o",
            "x.nc",
        ],
    );
    let (code, _, errors) = outcome(&output);
    assert!(code == Some(2) && errors.contains("-d g93"), "{errors}");
}
