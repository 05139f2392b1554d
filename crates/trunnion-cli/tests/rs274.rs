//! Programs for `LinuxCNC`, read by its own interpreter where that is installed.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

mod binary;

use binary::trunnion;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The stand-alone interpreter on the path.
fn interpreter() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join("rs274")).find(|file| file.is_file())
}

/// Kinematics are switched by remapped codes, which a machine's own configuration has.
fn configuration(folder: &Path) {
    let here = folder.display();
    let remaps = ["428", "429"].map(|code| {
        let text = format!("o<m{code}> sub\no<m{code}> endsub [0]\nM2\n");
        fs::write(folder.join(format!("m{code}.ngc")), text).unwrap();
        format!("REMAP = M{code} modalgroup=10 ngc=m{code}\n")
    });
    let text = format!(
        "[EMC]\nVERSION = 1.1\n[RS274NGC]\nPARAMETER_FILE = {here}/check.var\nSUBROUTINE_PATH = {here}\n{}\
         [TRAJ]\nCOORDINATES = X Y Z A B C\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n",
        remaps.concat()
    );
    fs::write(folder.join("check.ini"), text).unwrap();
    fs::write(folder.join("tool.tbl"), "T1 P1 Z50 D10 ;check\n").unwrap();
}

#[test]
fn linuxcnc_accepts_what_is_written_for_it() {
    let Some(interpreter) = interpreter() else {
        eprintln!("rs274 of LinuxCNC is not installed: its opinion of the programs is not asked");
        return;
    };
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    configuration(folder);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let wave = root.join("examples/wave/wave.cls");
    for (dialect, more) in [("linuxcnc", "--reduce"), ("linuxcnc", "--smooth"), ("g93", "--smooth")]
    {
        let arguments = [
            "post",
            wave.to_str().unwrap(),
            "-m",
            "bc-trunnion",
            "--origin=-381,-254,-505",
            "--tool-length",
            "120",
            "-d",
            dialect,
            more,
            "-o",
            "program.ngc",
        ];
        assert!(trunnion(folder, &arguments).status.success());
        let read = Command::new(&interpreter)
            .args(["-g", "-i", "check.ini", "-t", "tool.tbl", "program.ngc"])
            .current_dir(folder)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&read.stderr).into_owned();
        assert!(read.status.success(), "{dialect} {more}: {told}");
        let moves = String::from_utf8_lossy(&read.stdout).matches("STRAIGHT_FEED").count();
        assert!(moves > 50, "{dialect} {more}: {moves} moves");
    }
}
