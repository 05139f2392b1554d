//! The verb: reads a machine, writes a configuration.

use super::args::LinuxcncArgs;
use super::configuration::{Configuration, Joint};
use super::subroutines::SWITCHES;
use super::{hal, ini, notes, subroutines};
use crate::form::OutputForm;
use crate::machine;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use std::fmt::Write as _;
use std::path::Path;
use trunnion::machine::AxisKind;

/// Folder of the remapped codes, inside the configuration.
const SUBROUTINES: &str = "subroutines";

pub(crate) fn run(args: &LinuxcncArgs, form: OutputForm) -> Result<Done, Failure> {
    let source = machine::source(&args.machine)?;
    let machine = machine::load(&args.machine)?.machine;
    let configuration = Configuration::of(&machine, args.tool_length, args.planner)?;
    let folder = &args.output;
    let name = &configuration.name;
    let ini_file = folder.join(format!("{name}.ini"));
    if ini_file.exists() {
        return Err(Failure::input(format!(
            "{}: the configuration exists already, and may hold your work\n  help: choose another folder, or remove \
             the file",
            ini_file.display()
        )));
    }
    write(folder, &configuration, &source)?;
    let summary = LinuxcncJson {
        ini: ini_file.display().to_string(),
        joints: configuration.joints.clone(),
        tip_travel: configuration.tip_travel,
    };
    form.print(&summary, |summary| describe(summary, &configuration))
}

/// Writes all files, or none.
fn write(folder: &Path, of: &Configuration, source: &str) -> Result<(), Failure> {
    let name = &of.name;
    let mut outputs = Outputs::open(folder)?;
    let mut codes = Outputs::open(&folder.join(SUBROUTINES))?;
    for (code, kind, meaning) in SWITCHES {
        codes.text(&format!("{code}.ngc"), &subroutines::switch(code, kind, meaning))?;
    }
    for (ending, text) in [
        ("toml", source.to_owned()),
        ("hal", hal::hal(of)),
        ("tbl", subroutines::tools(of)),
        ("txt", notes::notes(of)),
        ("ini", ini::ini(of)),
    ] {
        outputs.text(&format!("{name}.{ending}"), &text)?;
    }
    codes.commit()?;
    outputs.commit()?;
    Ok(())
}

/// Result for scripts; mm, degrees, seconds.
#[derive(Debug, serde::Serialize)]
struct LinuxcncJson {
    ini: String,
    joints: Vec<Joint>,
    tip_travel: f64,
}

fn describe(summary: &LinuxcncJson, of: &Configuration) -> String {
    let mut text = format!("wrote {}\n", summary.ini);
    for (index, joint) in of.joints.iter().enumerate() {
        let unit = if joint.kind == AxisKind::Rotary { "deg" } else { "mm" };
        let travel = match (joint.low, joint.high) {
            (Some(low), Some(high)) => format!("{low:.3} to {high:.3} {unit}"),
            _ => "without end".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "joint {index}: {} {travel}, {:.1} {unit}/s, {:.1} {unit}/s2",
            joint.letter, joint.velocity, joint.acceleration
        );
    }
    let name = &of.name;
    let _ = writeln!(
        text,
        "start it with `linuxcnc {name}.ini`; {name}.txt says what to change for real drives"
    );
    text
}
