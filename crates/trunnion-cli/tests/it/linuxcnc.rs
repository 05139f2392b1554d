//! `trunnion linuxcnc`: its files, and programs that run in `LinuxCNC` with them.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::{outcome, trunnion};
use crate::linuxcnc_run::{Control, Plan, wait_for_the_task};
use crate::rs274::examples;
use std::fs;
use std::path::Path;
use trunnion::files::machine::{BUILT_IN, built_in, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, RotaryPair, Setup};
use trunnion::nalgebra::{Point3, Vector3};
use trunnion::types::AxisVector;
use trunnion_rt::ini_differences;

const FILES: [&str; 7] = [
    "bc-trunnion.hal",
    "bc-trunnion.ini",
    "bc-trunnion.tbl",
    "bc-trunnion.toml",
    "bc-trunnion.txt",
    "subroutines/m428.ngc",
    "subroutines/m429.ngc",
];

fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            found.extend(files(&entry.path()).iter().map(|inner| format!("{name}/{inner}")));
        } else {
            found.push(name);
        }
    }
    found.sort();
    found
}

/// The planner loads with the configuration of every built-in machine: it refuses joints that are narrower than the axes.
#[test]
fn the_joints_of_a_configuration_fit_the_machine_file() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (name, text) in BUILT_IN.iter().filter(|(name, _)| !name.ends_with("-bodies")) {
        let arguments = ["linuxcnc", name, "-o", name, "--planner", "trunnion"];
        let (code, _, errors) = outcome(&trunnion(folder, &arguments));
        assert_eq!(code, Some(0), "{name}: {errors}");
        let ini = fs::read_to_string(folder.join(name).join(format!("{name}.ini"))).unwrap();
        let differences = ini_differences(&parse(text).unwrap().machine, &ini).unwrap();
        assert!(differences.is_empty(), "{name}: {differences:?}");
        let narrow = ini.replacen("MAX_ACCELERATION = ", "MAX_ACCELERATION = 1 # ", 99);
        let differences = ini_differences(&parse(text).unwrap().machine, &narrow).unwrap();
        assert_eq!(differences.len(), 5, "{name}: {differences:?}");
    }
}

#[test]
fn a_configuration_has_the_limits_of_the_machine_file() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let arguments = ["linuxcnc", "bc-trunnion", "-o", "control", "--tool-length", "82.5"];
    let (code, out, errors) = outcome(&trunnion(folder, &arguments));
    assert_eq!(code, Some(0), "{errors}");
    assert!(out.contains("joint 3: B -35.000 to 120.000 deg, 150.0 deg/s"), "{out}");
    assert_eq!(files(&folder.join("control")), FILES);
    let ini = fs::read_to_string(folder.join("control/bc-trunnion.ini")).unwrap();
    let section = |name: &str| {
        let begin = ini.find(&format!("[{name}]")).unwrap();
        ini[begin..].split("\n\n").next().unwrap().to_owned()
    };
    for (name, lines) in [
        (
            "KINS",
            "KINEMATICS = trunnionkins machine=bc-trunnion.toml coordinates=XYZBC\nJOINTS = 5",
        ),
        (
            "JOINT_0",
            "TYPE = LINEAR\nMIN_LIMIT = -762\nMAX_LIMIT = 0\nMAX_VELOCITY = 500\nMAX_ACCELERATION = 2500",
        ),
        (
            "JOINT_3",
            "TYPE = ANGULAR\nMIN_LIMIT = -35\nMAX_LIMIT = 120\nMAX_VELOCITY = 150\nMAX_ACCELERATION = 300",
        ),
        ("JOINT_4", "TYPE = ANGULAR\nMAX_VELOCITY = 300"),
        ("AXIS_B", "MIN_LIMIT = -35\nMAX_LIMIT = 120"),
        ("TRAJ", "COORDINATES = X Y Z B C"),
    ] {
        assert!(section(name).contains(lines), "{}", section(name));
    }
    let tools = fs::read_to_string(folder.join("control/bc-trunnion.tbl")).unwrap();
    assert!(tools.starts_with("T1 P1 Z82.5 "), "{tools}");
    // The machine file beside it is the one that was named.
    let machine = fs::read_to_string(folder.join("control/bc-trunnion.toml")).unwrap();
    assert_eq!(machine, built_in("bc-trunnion").unwrap());
}

#[test]
fn a_configuration_that_stands_there_is_left_alone() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::create_dir(folder.join("control")).unwrap();
    fs::write(folder.join("control/bc-trunnion.ini"), "mine").unwrap();
    let (code, _, errors) =
        outcome(&trunnion(folder, &["linuxcnc", "bc-trunnion", "-o", "control"]));
    assert_eq!(code, Some(2));
    assert!(errors.contains("exists already"), "{errors}");
    assert_eq!(files(&folder.join("control")), ["bc-trunnion.ini"]);
}

#[test]
fn what_cannot_be_configured_is_refused_and_leaves_no_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = built_in("bc-trunnion").unwrap();
    let lettered = text.replace("modulo = \"unwound\" }", "letter = \"W\" }");
    fs::write(folder.join("lettered.toml"), lettered).unwrap();
    for (arguments, reason) in [
        (&["bc-trunion"][..], "did you mean the built-in machine `bc-trunnion`?"),
        (&["lettered.toml"], "set output.letter of [axis.C]"),
        (&["bc-trunnion", "--tool-length", "9000"], "at most 500 mm"),
    ] {
        let arguments = [&["linuxcnc", "-o", "control"], arguments].concat();
        let (code, _, errors) = outcome(&trunnion(folder, &arguments));
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains(reason), "{errors}");
        assert!(!folder.join("control").exists());
    }
}

#[test]
fn a_machine_that_counts_against_the_frame_is_told_of_its_work_offset() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = built_in("bc-trunnion").unwrap();
    let reversed = text.replacen("dir    = [1, 0, 0]\n", "dir    = [1, 0, 0]\nsense = -1\n", 1);
    fs::write(folder.join("reversed.toml"), reversed).unwrap();
    for (machine, remark) in [("bc-trunnion", false), ("reversed.toml", true)] {
        let output = machine.replace('.', "-");
        assert!(trunnion(folder, &["linuxcnc", machine, "-o", &output]).status.success());
        let notes = fs::read_to_string(folder.join(output).join("bc-trunnion.txt")).unwrap();
        assert_eq!(notes.contains("do not count along the machine frame"), remark, "{notes}");
    }
}

#[test]
fn every_built_in_machine_starts_as_it_is_written() {
    let Some(control) = Control::ready() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    // With bodies the kinematics are those of the machine without.
    for (machine, _) in BUILT_IN.iter().filter(|(name, _)| !name.ends_with("-bodies")) {
        assert!(trunnion(folder, &["linuxcnc", machine, "-o", machine]).status.success());
        let ini = format!("{machine}.ini");
        wait_for_the_task(&folder.join(machine).join(&ini));
        let (code, log) = control.start(&folder.join(machine), &ini, 120);
        assert_eq!(code, Some(0), "{machine}: {log}");
        // The screen is reached, behind kinematics, joints and HAL.
        assert!(log.contains("the task answers") && !log.to_lowercase().contains("error"), "{log}");
    }
}

/// Length of the tool of both examples \[mm\].
const LENGTH: f64 = 120.0;

/// One servo cycle: joints and words in mm and rad, in the order of the machine file.
struct Cycle {
    joints: AxisVector,
    words: AxisVector,
    tool_center_point: bool,
    inverse_ns: f64,
}

/// Reads a line of the sampler: its number, joints 0 to 4, words of X Y Z B C, and what else the plan samples.
fn cycle(line: &str) -> Cycle {
    let numbers: Vec<f64> =
        line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
    // Joint 3 is B and joint 4 is C; the machine file has C first.
    let axes = |at: usize| {
        let [b, c] = [numbers[at + 3], numbers[at + 4]].map(f64::to_radians);
        AxisVector::from([numbers[at], numbers[at + 1], numbers[at + 2], c, b])
    };
    Cycle {
        joints: axes(0) * 1e-6,
        words: axes(5),
        tool_center_point: numbers[10] > 0.5,
        inverse_ns: numbers[11],
    }
}

/// The joints that the library finds for words with tool-centre-point control.
fn wanted(inverse: &Inverse, words: &AxisVector) -> AxisVector {
    let gauge = inverse.kinematics().machine().gauge.coords;
    let tip = Vector3::new(words[0], words[1], words[2] - LENGTH) + gauge;
    inverse.at_rotaries(&Point3::from(tip), RotaryPair::new(words[3], words[4])).unwrap()
}

/// `LinuxCNC` passes joint positions through a cubic B-spline: the mean of three cycles, weighted 1 4 1.
fn splined(of: &[AxisVector], at: usize) -> AxisVector {
    (of[at - 1] + of[at] * 4.0 + of[at + 1]) / 6.0
}

/// Checks joints against words over the whole run. Returns the number of cycles with tool-centre-point control.
fn follows(cycles: &[Cycle]) -> usize {
    let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    let setup = Setup { tool_length: LENGTH, ..Setup::default() };
    let inverse = Inverse::new(&Kinematics::new(&machine, &setup)).unwrap();
    let joints = |cycle: &Cycle| {
        if cycle.tool_center_point { wanted(&inverse, &cycle.words) } else { cycle.words }
    };
    let expected: Vec<AxisVector> = cycles.iter().map(joints).collect();
    let mut compared = 0;
    let mut worst = 0.0_f64;
    for at in 3..cycles.len() {
        let same_kind = cycles[at - 3..=at]
            .iter()
            .all(|cycle| cycle.tool_center_point == cycles[at].tool_center_point);
        if same_kind {
            worst = worst.max((cycles[at].joints - splined(&expected, at - 2)).amax());
            compared += usize::from(cycles[at].tool_center_point);
        }
    }
    eprintln!("joints are off by {worst:.2e} mm or rad at most");
    // The sampler writes six decimals of a millimetre or degree, and a degree has a lever of half a metre.
    assert!(worst < 1e-5, "{worst}");
    compared
}

/// Largest step of a joint in a cycle, as a share of its velocity limit.
fn largest_step(cycles: &[Cycle]) -> f64 {
    let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    let limits = machine.vector(|axis| axis.vel) * 1e-3;
    let step = |pair: &[Cycle]| (pair[1].joints - pair[0].joints).component_div(&limits).amax();
    cycles.windows(2).map(step).fold(0.0, f64::max)
}

/// The work offset that the head of a program asks for, as a line.
fn offset_line(program: &str) -> String {
    let line = program.lines().find(|line| line.contains("G54 must hold")).unwrap();
    let words = line.split("hold ").nth(1).unwrap().split(';').next().unwrap();
    format!("G10 L2 P1 {words} B0 C0 R0")
}

#[test]
fn linuxcnc_runs_written_programs_with_these_kinematics() {
    let Some(control) = Control::ready() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let length = LENGTH.to_string();
    for (name, program) in examples(folder) {
        let work = name.replace('/', "-");
        let arguments = ["linuxcnc", "bc-trunnion", "-o", &work, "--tool-length", &length];
        assert!(trunnion(folder, &arguments).status.success());
        let plan = Plan {
            ini: "bc-trunnion.ini",
            program: &program,
            start: &["G21 G90 G94 G40 G49 G54", &offset_line(&program)],
            letters: "xyzbc",
            seconds: 300,
            actions: &[],
            pins: &[],
            hal: "",
        };
        let run = control.run(&folder.join(&work), &plan);
        assert!(run.errors.is_empty() && run.ended, "{name}: {:?}\n{}", run.errors, run.log);
        let cycles: Vec<Cycle> =
            run.samples.lines().filter(|line| !line.contains("overrun")).map(cycle).collect();
        assert_eq!(run.lost, 0, "{name}: cycles that the sampler lost");
        let compared = follows(&cycles);
        let step = largest_step(&cycles);
        let mut times: Vec<f64> = cycles.iter().map(|cycle| cycle.inverse_ns).collect();
        times.sort_by(f64::total_cmp);
        eprintln!(
            "{name}: {} cycles, {compared} with tool-centre-point control; largest step {step:.3} of the limit; \
             inverse {:.0} ns median, {:.0} ns worst",
            cycles.len(),
            times[times.len() / 2],
            run.worst_inverse_ns
        );
        assert!(compared > 5000, "{name}: {compared}");
        // The stock planner keeps no joint limits with tool-centre-point control; a jump would be far above.
        assert!(step < 2.0, "{name}: {step}");
        assert_eq!(run.refusals, 0, "{name}");
    }
}

/// Beginning of a program on the workpiece of the examples, up to tool-centre-point control.
const HEAD: &str = "G21 G90 G17 G40 G80 G54 G94\nM429\nG53 G0 Z0\nT1 M6\nG43 H1\nM428\n";

#[test]
fn linuxcnc_says_why_a_program_is_refused_and_stops_inside_travel() {
    let Some(control) = Control::ready() else { return };
    let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    let tilted = "G49\nG0 X10 Y5 Z140\nG1 B35 C30 F6000\nG43 H1\nG1 X20\nM2\n";
    let outside = "G0 X10 Y5 Z20\nG1 X20 Z-200 B30 F6000\nM2\n";
    // Both ends of the turn are inside travel: half way the tip goes round by Y.
    let inside_a_block = "G0 X260 Y0 Z180\nG1 C180 F6000\nM2\n";
    for (case, code, messages) in [
        (tilted, 5, ["tool-centre-point control off before G43", "kinematicsInverse failed"]),
        (outside, 1, ["joint 2 (Z) by ", "Linear move on line 8 fails kinematicsInverse"]),
        (inside_a_block, 1, ["joint 1 (Y) by ", "kinematicsInverse failed"]),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let arguments = ["linuxcnc", "bc-trunnion", "-o", "control", "--tool-length", "120"];
        assert!(trunnion(folder, &arguments).status.success());
        let plan = Plan {
            ini: "bc-trunnion.ini",
            program: &[HEAD, case].concat(),
            start: &["G21 G90 G94 G40 G49 G54", "G10 L2 P1 X-381 Y-254 Z-505 B0 C0 R0"],
            letters: "xyzbc",
            seconds: 60,
            actions: &[],
            pins: &[],
            hal: "",
        };
        let run = control.run(&folder.join("control"), &plan);
        let said = run.errors.join("\n");
        assert!(!run.ended && run.refusal == code, "{case}: {} {said}", run.refusal);
        for message in messages {
            assert!(said.contains(message), "{case}: {said}");
        }
        let cycles: Vec<Cycle> = run.samples.lines().map(cycle).collect();
        for Cycle { joints, .. } in &cycles {
            let excess = machine.travel_excess(joints).map_or(0.0, |excess| excess.excess);
            assert!(excess < 1e-3, "{case}: {excess}");
        }
        assert!(largest_step(&cycles) < 1.1, "{case}: {}", largest_step(&cycles));
    }
}
