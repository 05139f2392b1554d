//! The C interface as a C program uses it, with system calls forbidden after the load.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The static library that cargo built beside this test: the newest, if others were built before.
pub(crate) fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let files = std::fs::read_dir(test.parent().unwrap()).unwrap().map(|entry| entry.unwrap());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let archives = files.map(|file| file.path()).filter(|path| {
        name(path).starts_with("libtrunnion_rt") && path.extension().is_some_and(|of| of == "a")
    });
    let newest = archives.max_by_key(|path| path.metadata().unwrap().modified().unwrap());
    newest.expect("cargo builds the static library for this test")
}

#[test]
fn a_c_program_needs_no_system_call_after_the_load() {
    let library = library();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let temporary = tempfile::tempdir().unwrap();
    let program = temporary.path().join("servo");
    let compiled = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-I"])
        .arg(root.join("../../linuxcnc"))
        .arg(root.join("tests/c/servo.c"))
        .arg(&library)
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output();
    let Ok(compiled) = compiled else {
        eprintln!("there is no C compiler: the C interface is not run");
        return;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    for (machine, _) in trunnion::files::machine::BUILT_IN {
        let ran = Command::new(&program).arg(machine).output().unwrap();
        let text = String::from_utf8_lossy(&ran.stdout).into_owned();
        assert!(ran.status.success(), "{machine}: {} {text}", ran.status);
        eprintln!("{text}");
    }
    let refused = Command::new(&program).arg("bc-trunion").output().unwrap();
    assert_eq!(refused.status.code(), Some(3));
    let text = String::from_utf8_lossy(&refused.stdout);
    assert!(text.contains("reading machine file bc-trunion"), "{text}");
}
