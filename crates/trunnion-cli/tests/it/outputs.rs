//! Outputs through links, into pipes, and onto their own input.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::{folder, trunnion};
use std::fs;
use std::io::Read as _;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::path::Path;
use std::process::{Command, Output};

fn post(folder: &Path, input: &str, output: &str) -> Output {
    let setup =
        ["-m", "bc-trunnion", "-d", "apt", "--origin=-381,-254,-505", "--tool-length", "120"];
    trunnion(folder, &[&["post", input, "-o", output][..], &setup].concat())
}

fn wave(folder: &Path) {
    let wave = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/wave/wave.cls");
    fs::copy(wave, folder.join("wave.cls")).unwrap();
}

#[test]
fn an_output_never_replaces_its_input() {
    let folder = folder();
    let folder = folder.path();
    wave(folder);
    let before = fs::read(folder.join("wave.cls")).unwrap();
    fs::create_dir(folder.join("deep")).unwrap();
    symlink("../wave.cls", folder.join("deep/link.cls")).unwrap();
    for output in ["wave.cls", "./deep/../wave.cls", "deep/link.cls"] {
        let refused = post(folder, "wave.cls", output);
        let errors = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{output}: {errors}");
        assert!(errors.contains(output) && errors.contains("-o"), "{errors}");
        let smoothed = trunnion(folder, &["path", "wave.cls", "-o", output]);
        assert_eq!(smoothed.status.code(), Some(2), "{output}");
    }
    assert_eq!(fs::read(folder.join("wave.cls")).unwrap(), before);
    assert!(!folder.join("wave.setup.txt").exists());
}

#[test]
fn a_link_stays_and_what_it_names_is_written() {
    let folder = folder();
    let folder = folder.path();
    wave(folder);
    fs::create_dir(folder.join("share")).unwrap();
    fs::write(folder.join("share/part.cls"), "old").unwrap();
    symlink("share/part.cls", folder.join("here.cls")).unwrap();
    symlink("share/new.cls", folder.join("dangling.cls")).unwrap();
    for (link, target) in [("here.cls", "share/part.cls"), ("dangling.cls", "share/new.cls")] {
        let posted = post(folder, "wave.cls", link);
        assert_eq!(posted.status.code(), Some(0), "{}", String::from_utf8_lossy(&posted.stderr));
        assert!(fs::symlink_metadata(folder.join(link)).unwrap().is_symlink());
        assert!(fs::read_to_string(folder.join(target)).unwrap().contains("GOTO"));
    }
}

#[test]
fn pipes_and_devices_receive_the_program_and_stay() {
    let folder = folder();
    let folder = folder.path();
    wave(folder);
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || {
            let mut text = String::new();
            fs::File::open(pipe).unwrap().read_to_string(&mut text).map(|_| text)
        }
    });
    let posted = post(folder, "wave.cls", "pipe");
    assert_eq!(posted.status.code(), Some(0), "{}", String::from_utf8_lossy(&posted.stderr));
    assert!(reader.join().unwrap().unwrap().contains("GOTO"));
    assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
    assert!(!folder.join("pipe.setup.txt").exists(), "no sheet beside a pipe");
    let posted = post(folder, "wave.cls", "/dev/null");
    assert_eq!(posted.status.code(), Some(0), "{}", String::from_utf8_lossy(&posted.stderr));
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
    // Standard output by its name: the program, then the summary.
    let posted = post(folder, "wave.cls", "/dev/stdout");
    assert!(String::from_utf8_lossy(&posted.stdout).contains("GOTO"));
}
