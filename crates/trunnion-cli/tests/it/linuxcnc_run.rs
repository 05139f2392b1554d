//! A `LinuxCNC` without people: builds and installs the kinematics module, runs a program, returns samples.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test stops on surprise")]

use crate::binary::root;
use crate::rs274::installed;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Folder from which `LinuxCNC` loads modules.
const MODULES: &str = "/usr/lib/linuxcnc/modules";
const MODULE_NAMES: [&str; 2] = ["trunnionkins.so", "trunniontp.so"];

/// User and group without rights: the control refuses to run as root.
const NOBODY: &str = "65534";

/// An installed control with the modules of this tree. Dropped, the modules that stood there before are back.
pub(crate) struct Control {
    modules: Vec<InstalledModule>,
    /// Held while the modules are installed: tests, and other runs of them, wait for each other.
    _lock: fs::File,
}

struct InstalledModule {
    path: PathBuf,
    /// Module that was installed before.
    before: Option<Vec<u8>>,
}

/// Program to run, and the lines of the operator before it.
pub(crate) struct Plan<'a> {
    pub(crate) ini: &'a str,
    pub(crate) program: &'a str,
    pub(crate) start: &'a [&'a str],
    /// Letters of the joints in their order.
    pub(crate) letters: &'a str,
    /// Time limit.
    pub(crate) seconds: u32,
    /// Actions of the operator while the program runs.
    pub(crate) actions: &'a [Action],
    /// Pins that are read at the end, besides those of the kinematics.
    pub(crate) pins: &'a [&'a str],
    /// HAL commands behind those of the sampler.
    pub(crate) hal: &'a str,
}

/// One thing that the operator does.
#[derive(serde::Serialize)]
pub(crate) struct Action(
    /// Time after the start \[s\].
    pub(crate) f64,
    /// Name in the script of the screen.
    pub(crate) &'static str,
    pub(crate) f64,
);

/// Result of a run.
pub(crate) struct Run {
    /// Messages for the operator.
    pub(crate) errors: Vec<String>,
    /// The program was run to its end.
    pub(crate) ended: bool,
    /// Cycles without a sample.
    pub(crate) lost: u64,
    /// One cycle a line: number, joints times a million, words of the same letters, type of kinematics, time of the inverse
    /// in ns, two digital outputs and an analogue one, time of the planner in ns. The sampler writes six decimals, and third differences of joints need more.
    pub(crate) samples: String,
    pub(crate) refusals: u64,
    /// Reason of the last refusal, 0 for none.
    pub(crate) refusal: u64,
    pub(crate) worst_inverse_ns: f64,
    /// Everything that the screen wrote down, pins among it.
    pub(crate) values: Value,
    /// Output of the control.
    pub(crate) log: String,
}

impl Control {
    /// Builds the modules and installs them; `None`, with the reason, where that is not possible.
    pub(crate) fn ready() -> Option<Self> {
        for (program, package) in [
            ("linuxcnc", "linuxcnc-uspace"),
            ("halcompile", "linuxcnc-uspace-dev"),
            ("setpriv", "util-linux"),
        ] {
            if installed(program).is_none() {
                eprintln!("{program} of {package} is not installed: no program is run in LinuxCNC");
                return None;
            }
        }
        if Command::new("id").arg("-u").output().unwrap().stdout != b"0\n" {
            eprintln!("only root installs a module of LinuxCNC: no program is run in it");
            return None;
        }
        let lock = fs::File::create(std::env::temp_dir().join("trunnionkins.lock")).unwrap();
        lock.lock().unwrap();
        let built = build();
        let install = |name: &&str| {
            let path = Path::new(MODULES).join(name);
            let before = fs::read(&path).ok();
            fs::copy(built.path().join(name), &path).unwrap();
            InstalledModule { path, before }
        };
        Some(Self { modules: MODULE_NAMES.iter().map(install).collect(), _lock: lock })
    }

    /// Runs a program with the configuration in a folder.
    pub(crate) fn run(&self, folder: &Path, plan: &Plan<'_>) -> Run {
        prepare(folder, plan);
        let (_, log) = self.start(folder, plan.ini, plan.seconds + 60);
        result(folder, log)
    }

    /// Starts the control with a configuration, as a user without rights, and waits for its end: exit code and output.
    pub(crate) fn start(&self, folder: &Path, ini: &str, seconds: u32) -> (Option<i32>, String) {
        assert!(self.modules.iter().all(|module| module.path.is_file()));
        let owner = format!("{NOBODY}:{NOBODY}");
        assert!(Command::new("chown").args(["-R", &owner]).arg(folder).status().unwrap().success());
        // Memory of the control has one name on a machine: runs wait for each other.
        let lock = std::env::temp_dir().join("lcnc-run.lock");
        let ran = Command::new("flock")
            .arg("--close")
            .arg(lock)
            .args(["timeout", "-k", "20", &seconds.to_string()])
            .arg("setpriv")
            .args([&format!("--reuid={NOBODY}"), &format!("--regid={NOBODY}"), "--clear-groups"])
            .args(["linuxcnc", "-r", ini])
            .current_dir(folder)
            .env("HOME", folder)
            .env_remove("DISPLAY")
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        (ran.status.code(), [ran.stdout, ran.stderr].map(text).concat())
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        for InstalledModule { path, before } in &self.modules {
            // A test that failed already has more to say than this.
            let _ = match before {
                Some(bytes) => fs::write(path, bytes),
                None => fs::remove_file(path),
            };
        }
    }
}

/// The newest static library that cargo built for these tests.
fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let files = fs::read_dir(test.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let archive = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with("libtrunnion_rt") && path.extension().is_some_and(|of| of == "a")
    };
    let newest =
        files.filter(archive).max_by_key(|path| path.metadata().unwrap().modified().unwrap());
    newest.expect("cargo builds the static library of trunnion-rt for this test")
}

/// Builds the modules in a folder of its own.
fn build() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["Makefile", "trunnionkins.c", "trunniontp.c", "trunnion_rt.h"] {
        fs::copy(root().join("linuxcnc").join(name), folder.path().join(name)).unwrap();
    }
    let made = Command::new("make")
        .arg("-s")
        .arg(format!("LIBRARY={}", library().display()))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    folder
}

/// Replaces the screen of a configuration by one that ends when the task answers.
///
/// The dummy screen ends at once, and `LinuxCNC` starts the task beside the screen: on a busy machine it would be shut
/// down while it starts.
pub(crate) fn wait_for_the_task(ini: &Path) {
    replace_screen(ini, "wait.py");
}

/// Replaces the screen of a configuration by a script of these tests.
fn replace_screen(ini: &Path, script: &str) {
    let screen = ini.with_file_name(script);
    fs::copy(root().join("crates/trunnion-cli/tests/linuxcnc").join(script), &screen).unwrap();
    assert!(Command::new("chmod").arg("755").arg(&screen).status().unwrap().success());
    let text = fs::read_to_string(ini).unwrap();
    let driven =
        text.replace("\nDISPLAY = dummy\n", &format!("\nDISPLAY = {}\n", screen.display()));
    assert!(driven.contains(script));
    fs::write(ini, driven).unwrap();
}

/// Adds the driver and the sampler to a configuration.
fn prepare(folder: &Path, plan: &Plan<'_>) {
    let ini = folder.join(plan.ini);
    replace_screen(&ini, "drive.py");
    let text = fs::read_to_string(&ini).unwrap();
    let sampled = text.replace("\n\n[EMCIO]", "\nHALFILE = sample.hal\n\n[EMCIO]");
    assert!(sampled.contains("sample.hal"));
    fs::write(&ini, sampled).unwrap();
    fs::write(folder.join("sample.hal"), sampler(plan)).unwrap();
    fs::write(folder.join("program.ngc"), plan.program).unwrap();
    let kinematics =
        ["trunnionkins.refusals", "trunnionkins.refusal", "trunnionkins.inverse-ns-max"];
    let pins: Vec<&str> = kinematics.iter().chain(plan.pins).copied().collect();
    let steps = serde_json::json!({
        "program": "program.ngc",
        "start": plan.start,
        "seconds": plan.seconds,
        "pins": pins,
        "actions": plan.actions,
    });
    fs::write(folder.join("drive.json"), steps.to_string()).unwrap();
}

/// Samples joints, words, the type of kinematics, outputs and the times of inverse and planner in every servo cycle.
fn sampler(plan: &Plan<'_>) -> String {
    let letters = plan.letters;
    let count = letters.len();
    let mut text = format!(
        "loadrt scale count={count}\nloadrt sampler depth=16000 cfg={}bsbbfs\n",
        "f".repeat(2 * count)
    );
    for joint in 0..count {
        write!(text, "addf scale.{joint} servo-thread\nsetp scale.{joint}.gain 1e6\n").unwrap();
    }
    text.push_str("addf sampler.0 servo-thread\nsetp sampler.0.enable 0\n");
    for (joint, letter) in letters.chars().enumerate() {
        let word = count + joint;
        write!(
            text,
            "net joint-fine-{joint} joint.{joint}.pos-cmd => scale.{joint}.in\n\
             net sampled-joint-{joint} scale.{joint}.out => sampler.0.pin.{joint}\n\
             net sampled-{letter} axis.{letter}.pos-cmd => sampler.0.pin.{word}\n"
        )
        .unwrap();
    }
    write!(
        text,
        "net sampled-kind kinstype.is-1 => sampler.0.pin.{}\nnet sampled-time trunnionkins.inverse-ns => sampler.0.pin.{}\n",
        2 * count,
        2 * count + 1
    )
    .unwrap();
    let outputs = ["motion.digital-out-00", "motion.digital-out-01", "motion.analog-out-00"];
    let planner = plan.pins.iter().any(|pin| pin.starts_with("trunniontp."));
    let cycle = planner.then_some("trunniontp.cycle-ns");
    for (index, source) in outputs.into_iter().chain(cycle).enumerate() {
        let pin = 2 * count + 2 + index;
        writeln!(text, "net sampled-more-{index} {source} => sampler.0.pin.{pin}").unwrap();
    }
    text + plan.hal
}

fn result(folder: &Path, log: String) -> Run {
    let text = fs::read_to_string(folder.join("result.json"));
    let text = text.unwrap_or_else(|error| format!("{{\"errors\": [\"no result: {error}\"]}}"));
    let result: Value = serde_json::from_str(&text).unwrap();
    let number = |pin: &str| result[pin].as_f64().unwrap_or(f64::NAN);
    let whole = |pin: &str| result[pin].as_u64().unwrap_or(u64::MAX);
    let errors = result["errors"].as_array().unwrap().iter();
    Run {
        errors: errors.map(|error| error.as_str().unwrap().to_owned()).collect(),
        ended: result["ended"] == true,
        lost: whole("lost"),
        samples: fs::read_to_string(folder.join("samples.txt")).unwrap_or_default(),
        refusals: whole("trunnionkins.refusals"),
        refusal: whole("trunnionkins.refusal"),
        worst_inverse_ns: number("trunnionkins.inverse-ns-max"),
        values: result,
        log,
    }
}
