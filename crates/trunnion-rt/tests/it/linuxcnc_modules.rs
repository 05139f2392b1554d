//! `trunnionkins` beside the kinematics modules that come with `LinuxCNC`.

use crate::c_interface::library;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const STOCK: &str = "/usr/lib/linuxcnc/modules";

/// A folder with the module and the program that loads it; `None`, with the reason, where it cannot be built.
fn built() -> Option<TempDir> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    for name in ["Makefile", "trunnionkins.c", "trunniontp.c", "trunnion_rt.h"] {
        fs::copy(root.join("../../linuxcnc").join(name), file(name)).unwrap();
    }
    if Command::new("halcompile").arg("--print-modinc").output().is_err() {
        eprintln!("linuxcnc-uspace-dev is not installed: trunnionkins is not built");
        return None;
    }
    let run = |command: &mut Command| {
        let made = command.current_dir(folder.path()).output().unwrap();
        let [out, errors] = [made.stdout, made.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(made.status.success() && errors.is_empty(), "{out}{errors}");
    };
    run(Command::new("make").arg("-s").arg(format!("LIBRARY={}", library().display())));
    run(Command::new("cc")
        .args(["-std=gnu11", "-Wall", "-Wextra", "-O2", "-rdynamic", "-o", "modules"])
        .arg(root.join("tests/c/modules.c"))
        .args(["-ldl", "-lm"]));
    Some(folder)
}

/// Runs the program with a machine: exit code and output.
fn run(folder: &TempDir, stock: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let module = folder.path().join("trunnionkins.so");
    let command = ["./modules", stock, module.to_str().unwrap()];
    let ran = Command::new(folder.path().join("modules"))
        .args(&command[1..])
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .unwrap();
    (ran.status.code(), String::from_utf8(ran.stdout).unwrap())
}

/// A table on two rotaries as `LinuxCNC` has it: both count the motion of the table, against ISO 841.
fn table(tilt: &str, direction: &str, tilt_point: &str) -> String {
    let axis = |name: &str, dir: &str| {
        format!(
            "[axis.{name}]\nkind = \"linear\"\ndir = {dir}\nlimits = [-2000, 2000]\nvel = 1\nacc = 1\njerk = 1\n"
        )
    };
    let rotary = |name: &str, dir: &str, point: &str| {
        format!(
            "[axis.{name}]\nkind = \"rotary\"\ndir = {dir}\npoint = {point}\ncyclic = 360\nvel = 1\nacc = 1\n\
             jerk = 1\nsense = -1\n"
        )
    };
    [
        format!(
            "schema = \"trunnion-machine/1\"\nname = \"stock\"\nchain = [\"w\", \"C\", \"{tilt}\", \"b\", \"X\", \
             \"Y\", \"Z\", \"t\"]\ntool_axis = [0, 0, 1]\ngauge = [0, 0, 0]\n"
        ),
        axis("X", "[1, 0, 0]"),
        axis("Y", "[0, 1, 0]"),
        axis("Z", "[0, 0, 1]"),
        rotary(tilt, direction, tilt_point),
        rotary("C", "[0, 0, 1]", "[11, 13.5, 0]"),
    ]
    .concat()
}

/// One test, because the module takes long to link.
#[test]
fn trunnionkins_stands_in_for_the_modules_of_linuxcnc() {
    let Some(folder) = built() else { return };
    the_tables_of_linuxcnc_are_machine_files(&folder);
    joints_have_the_letters_that_the_configuration_gives_them(&folder);
}

fn the_tables_of_linuxcnc_are_machine_files(folder: &TempDir) {
    let rows = [
        ("xyzac-trt-kins", "A", "[1, 0, 0]", "[0, 33.5, -12.25]", ".y-offset=20"),
        ("xyzbc-trt-kins", "B", "[0, 1, 0]", "[31, 0, -12.25]", ".x-offset=20"),
    ];
    for (stock, tilt, direction, point, offset) in rows {
        let module = PathBuf::from(STOCK).join(format!("{stock}.so"));
        if !module.is_file() {
            eprintln!("{stock} of LinuxCNC is not installed: nothing is compared with it");
            continue;
        }
        let machine = format!("{stock}.toml");
        fs::write(folder.path().join(&machine), table(tilt, direction, point)).unwrap();
        let pins = [".x-rot-point=11", ".y-rot-point=13.5", ".z-rot-point=7", ".z-offset=-19.25"];
        let arguments = [&[machine.as_str(), offset], &pins[..]].concat();
        let (code, out) = run(folder, module.to_str().unwrap(), &arguments);
        eprintln!("{stock}: {out}");
        assert_eq!(code, Some(0), "{stock}: {out}");
    }
}

fn joints_have_the_letters_that_the_configuration_gives_them(folder: &TempDir) {
    let joints = |arguments: &[&str]| {
        let (code, out) = run(folder, "-", arguments);
        assert_eq!(code, Some(0), "{out}");
        out.lines().find(|line| line.starts_with("10 ")).unwrap_or_default().trim().to_owned()
    };
    // The pose is X10 Y20 Z30 A4 B5 C6; joints without a letter are left alone.
    assert_eq!(joints(&["bc-trunnion"]), "10 20 30 5 6 -1 -1");
    assert_eq!(joints(&["ac-trunnion"]), "10 20 30 4 6 -1 -1");
    assert_eq!(joints(&["bc-trunnion", "coordinates=XXYZCB"]), "10 10 20 30 6 5 -1");
    for (arguments, reason) in [
        (["bc-trunnion", "coordinates=XYZAC"], "the machine file has no axis A"),
        (["bc-trunnion", "coordinates=XYZC"], "axis B of the machine file has no joint"),
        (["missing.toml", ""], "reading machine file missing.toml"),
    ] {
        let (code, out) = run(folder, "-", &arguments);
        assert_eq!(code, Some(2), "{out}");
        assert!(out.contains(reason), "{out}");
    }
}
