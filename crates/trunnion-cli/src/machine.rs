//! `trunnion machine`: lists, shows, checks, makes, imports and calibrates machine files; loads machines for other verbs.

mod calibrate;
mod create;
mod import;

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::{disk, material, output, text};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trunnion::files::machine::{BUILT_IN, MachineFile, built_in, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Axis, AxisKind, BodyShape, Kinematics, Machine, Setup, picture};
use trunnion::math;
use trunnion::types::{Diagnostic, Diagnostics};

pub(crate) use calibrate::{CalibrateArgs, answer as calibration};
pub use calibrate::{CalibrationAnswer, CalibrationSummary};
pub use import::{ImportAnswer, ImportSummary};
pub(crate) use import::{ImportArgs, answer as imported};

#[derive(Debug, clap::Subcommand)]
pub(crate) enum Action {
    /// List the built-in machines, and the given files.
    List {
        /// Further machine files to list.
        files: Vec<String>,
    },
    /// Describe one machine: chain, travel, limits, reach, singular directions, a check of signs.
    Show {
        /// Machine file, or name of a built-in machine.
        machine: String,
        /// Also draw the chain into this SVG file.
        #[arg(short, long, value_name = "SVG")]
        output: Option<PathBuf>,
        /// Print the machine file itself, as a start for your own.
        #[arg(long, conflicts_with = "output")]
        file: bool,
    },
    /// Report all errors in machine files, with line and column.
    Check {
        /// Machine files.
        #[arg(required = true)]
        files: Vec<String>,
    },
    /// Make a machine file from a few answers: what turns the table, what tilts, where they meet, what a jog shows.
    New(Box<create::NewArgs>),
    /// Turn the parameters of a control, or a machine of `FreeCAD`, into a machine file.
    ///
    /// Prints each value with the key that it became. A value that is missing is asked for by its key; a sign that the manual
    /// leaves open becomes a comment in the machine file.
    Import(ImportArgs),
    /// Find the errors of a real machine from measured spheres, and write its calibrated file.
    ///
    /// Readings are the positions of the axes at which a probe or an R-test finds the centre of a sphere on the table, at
    /// several rotary positions, or ball-bar radii. The report names deviations that the readings do not separate, and further
    /// positions that would. `trunnion post --to-calibrated` moves a program to the calibrated machine.
    Calibrate(CalibrateArgs),
}

pub(crate) fn run(action: &Action, form: OutputForm) -> Result<Done, Failure> {
    match action {
        Action::List { files } => list(files, form),
        Action::Show { machine, file: true, .. } => text::print(&source(machine)?),
        Action::Show { machine, output, .. } => show(machine, output.as_deref(), form),
        Action::Check { files } => check(files, form),
        Action::New(args) => create::run(args, form),
        Action::Import(args) => import::run(args, form),
        Action::Calibrate(args) => calibrate::run(args, form),
    }
}

/// Reads a machine file, or the built-in machine of that name if there is no such file.
pub(crate) fn load(argument: &str) -> Result<MachineFile, Failure> {
    let path = Path::new(argument);
    let text = source(argument)?;
    let file = parse(&text).map_err(|faults| Failure::faults(path, &faults))?;
    with_solids(path, file)
}

/// Reads the files of a machine's bodies, beside the machine file.
fn with_solids(path: &Path, mut file: MachineFile) -> Result<MachineFile, Failure> {
    let mut faults = Vec::new();
    for (number, body) in file.machine.bodies.iter_mut().enumerate() {
        let BodyShape::File { file: name, place, chord } = &body.shape else { continue };
        let solid = path.parent().unwrap_or(Path::new("")).join(name);
        let key = format!("body.{number}.file");
        if !disk::is_file(&solid) {
            let fault = file.places.fault(&key, format!("{name}: there is no such file"));
            faults.push(fault.with_help("paths count from the folder of the machine file"));
            continue;
        }
        let chord = material::is_step(&solid).then_some(*chord);
        match material::mesh_of(&solid, chord) {
            Ok(mesh) => {
                let (mesh, place) = (Arc::new(mesh), *place);
                let allowance = chord.unwrap_or(0.0);
                body.shape = BodyShape::Mesh { mesh, place, allowance };
            }
            Err(what) => {
                faults.push(file.places.fault(&key, format!("{name}: {what}")));
            }
        }
    }
    if faults.is_empty() { Ok(file) } else { Err(Failure::faults(path, &faults)) }
}

/// Reads the machine that a job names: a file beside the job, else a built-in machine.
pub(crate) fn load_beside(job: &Path, name: &str) -> Result<MachineFile, Failure> {
    // A file beside the job wins, so that an edited copy may keep the name of its built-in original.
    let path = job.parent().unwrap_or(Path::new("")).join(name);
    if is_built_in(job, name) { load(name) } else { load(&path.to_string_lossy()) }
}

/// Returns true if a job beside which no such file stands names a built-in machine.
pub(crate) fn is_built_in(job: &Path, name: &str) -> bool {
    let path = job.parent().unwrap_or(Path::new("")).join(name);
    !disk::exists(&path) && built_in(name).is_ok()
}

/// Returns the text of a machine file or built-in machine.
pub(crate) fn source(argument: &str) -> Result<String, Failure> {
    let path = Path::new(argument);
    // A folder of that name is no machine file, but a built-in machine may be meant.
    if disk::is_file(path) || (disk::exists(path) && built_in(argument).is_err()) {
        return text::read(path);
    }
    built_in(argument).map(str::to_owned).map_err(|nearest| {
        let help = match nearest {
            Some(name) => format!("did you mean the built-in machine `{name}`?"),
            None => "`trunnion machine list` names the built-in ones".to_owned(),
        };
        Failure::input(format!(
            "{argument}: neither a machine file nor the name of a built-in machine\n  help: {help}"
        ))
    })
}

/// Description of a machine for scripts; mm, deg, s.
#[derive(Debug, serde::Serialize)]
struct MachineJson {
    /// File, or name of the built-in machine.
    source: String,
    name: String,
    kind: &'static str,
    layout: Option<u8>,
    chain: Vec<String>,
    axes: Vec<AxisJson>,
    /// Angle between tool and workpiece-side rotary, by geometry and within travel.
    reach: [f64; 2],
    reach_in_travel: [f64; 2],
    singular_directions: Vec<[f64; 3]>,
    signs: Vec<SignJson>,
}

#[derive(Debug, serde::Serialize)]
struct AxisJson {
    name: String,
    kind: &'static str,
    direction: [f64; 3],
    point: Option<[f64; 3]>,
    /// Travel; `null` for an axis that turns without end.
    travel: Option<[f64; 2]>,
    home: f64,
    vel: f64,
    rapid: f64,
    acc: f64,
    jerk: f64,
    sense: f64,
}

#[derive(Debug, serde::Serialize)]
struct SignJson {
    axis: String,
    jog: f64,
    expect: String,
}

/// Returns the factor to the unit that people read, and its name.
fn unit(axis: &Axis) -> (f64, &'static str) {
    match axis.kind {
        AxisKind::Linear => (1.0, "mm"),
        AxisKind::Rotary => (1.0_f64.to_degrees(), "deg"),
    }
}

/// Drops digits that the conversion of units made up.
fn round(value: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    (value * 1e9).round() / 1e9 + 0.0
}

impl AxisJson {
    fn of(axis: &Axis) -> Self {
        let (factor, _) = unit(axis);
        let figure = |value: f64| round(value * factor);
        let rotary = axis.kind == AxisKind::Rotary;
        Self {
            name: axis.name.clone(),
            kind: if rotary { "rotary" } else { "linear" },
            direction: axis.dir.into_inner().into(),
            point: rotary.then(|| axis.point.coords.into()),
            travel: axis.limits.is_bounded().then(|| axis.limits.ends().map(figure)),
            home: figure(axis.home),
            vel: figure(axis.vel),
            rapid: figure(axis.rapid),
            acc: figure(axis.acc),
            jerk: figure(axis.jerk),
            sense: axis.sense,
        }
    }
}

/// Returns the inverse for a workpiece frame parallel to the machine frame.
fn inverse(machine: &Machine) -> Result<Inverse, Failure> {
    let setup = Setup::new([0.0; 3].into(), [0.0; 3], 0.0);
    Inverse::new(&Kinematics::new(machine, &setup)).map_err(Failure::input)
}

impl MachineJson {
    fn of(source: &str, machine: &Machine) -> Result<Self, Failure> {
        let inverse = inverse(machine)?;
        let degrees = |angles: [f64; 2]| angles.map(|angle| round(angle.to_degrees()));
        let singular = inverse.singular_directions();
        let signs = machine.sign_checks().into_iter().filter_map(|check| {
            let axis = machine.axes.get(check.axis)?;
            let jog = round(check.by * unit(axis).0);
            Some(SignJson { axis: axis.name.clone(), jog, expect: check.words })
        });
        Ok(Self {
            source: source.to_owned(),
            name: machine.name.clone(),
            kind: machine.kind().name(),
            layout: machine.layout(),
            chain: machine.chain.clone(),
            axes: machine.axes.iter().map(AxisJson::of).collect(),
            reach: degrees(inverse.reach().ends()),
            reach_in_travel: degrees(machine.tilt_range().ends()),
            singular_directions: singular.iter().map(|dir| dir.into_inner().into()).collect(),
            signs: signs.collect(),
        })
    }
}

fn list(files: &[String], form: OutputForm) -> Result<Done, Failure> {
    let names = BUILT_IN.iter().map(|(name, _)| *name);
    let mut machines = Vec::new();
    // A file that is called as a built-in machine is still read from disk.
    for source in names.chain(files.iter().map(String::as_str)) {
        let built_in =
            BUILT_IN.iter().find(|(name, _)| *name == source && machines.len() < BUILT_IN.len());
        let text = match built_in {
            Some((_, text)) => (*text).to_owned(),
            None => text::read(Path::new(source))?,
        };
        let file = parse(&text).map_err(|faults| Failure::faults(Path::new(source), &faults))?;
        machines.push((source, file.machine));
    }
    if form.is_json() {
        let list: Result<Vec<_>, _> =
            machines.iter().map(|(source, machine)| MachineJson::of(source, machine)).collect();
        return text::print_json(&list?);
    }
    let mut lines = vec![format!(
        "{:<28} {:<12} {:>6}  {:<24} {}",
        "machine", "kind", "layout", "travel mm", "rotary travel deg"
    )];
    lines.extend(machines.iter().map(|(source, machine)| list_row(source, machine)));
    lines.push("\n`trunnion machine show NAME` describes one; `show NAME --file > my.toml` is a start for your own".into());
    text::print(&(lines.join("\n") + "\n"))
}

fn list_row(source: &str, machine: &Machine) -> String {
    let layout = machine.layout().map_or("-".to_owned(), |code| code.to_string());
    let [x, y, z, first, second] = &machine.axes;
    let length = |axis: &Axis| format!("{}", round(axis.limits.width()));
    let linear = [x, y, z].map(length).join(" x ");
    // The workpiece side comes first, as in all tables.
    let rotary = [first, second].map(|axis| format!("{} {}", axis.name, travel(axis))).join(", ");
    format!("{source:<28} {:<12} {layout:>6}  {linear:<24} {rotary}", machine.kind().name())
}

/// Describes the travel: `-35 .. 120`, or `endless`.
fn travel(axis: &Axis) -> String {
    let (factor, _) = unit(axis);
    let [low, high] = axis.limits.ends().map(|end| round(end * factor));
    if low.is_finite() { format!("{low} .. {high}") } else { "endless".to_owned() }
}

fn show(argument: &str, output: Option<&Path>, form: OutputForm) -> Result<Done, Failure> {
    let machine = load(argument)?.machine;
    if let Some(path) = output {
        output::protect(path, &[Path::new(argument)])?;
        let picture = picture(&machine);
        output::file(path, |out| out.write_all(picture.as_bytes()))?;
    }
    let about = MachineJson::of(argument, &machine)?;
    if form.is_json() {
        return text::print_json(&about);
    }
    let mut lines = chain_lines(&machine);
    lines.extend(axis_lines(&machine, &about));
    lines.extend(reach_lines(&machine, &about)?);
    lines.extend(sign_lines(&machine, &about));
    text::print(&(lines.join("\n") + "\n"))
}

fn chain_lines(machine: &Machine) -> Vec<String> {
    let layout = match machine.layout() {
        Some(code) => format!("layout {code} of the twelve"),
        None => "none of the twelve orthogonal layouts".to_owned(),
    };
    let words: Vec<&str> = machine
        .chain
        .iter()
        .map(|word| match word.as_str() {
            "w" => "workpiece",
            "b" => "bed",
            "t" => "tool",
            axis => axis,
        })
        .collect();
    vec![
        format!("{}: {}, {layout}", machine.name, machine.kind().name()),
        format!("chain     {}", words.join(" - ")),
    ]
}

fn axis_lines(machine: &Machine, about: &MachineJson) -> Vec<String> {
    let vector = |[x, y, z]: [f64; 3]| format!("({}, {}, {})", short(x), short(y), short(z));
    let mut lines = vec![
        format!("tool      axis {} at home, tip to spindle", vector((*machine.tool_axis).into())),
        format!(
            "gauge     {} mm: spindle nose with all axes at zero",
            vector(machine.gauge.coords.into())
        ),
        String::new(),
        format!(
            "{:<5} {:<22} {:<26} {:<16} {:>8}  {:>8} {:>8} {:>8} {:>9}  {}",
            "axis", "direction", "point", "travel", "home", "vel", "rapid", "acc", "jerk", "in"
        ),
    ];
    for (axis, row) in machine.axes.iter().zip(&about.axes) {
        // An axis that counts against ISO 841 is marked, because its numbers have the other sign.
        let reversed = if row.sense < 0.0 { " reversed" } else { "" };
        lines.push(format!(
            "{:<5} {:<22} {:<26} {:<16} {:>8}  {:>8} {:>8} {:>8} {:>9}  {}, s",
            row.name,
            vector(row.direction) + reversed,
            row.point.map(vector).unwrap_or_default(),
            travel(axis),
            digits(row.home),
            digits(row.vel),
            digits(row.rapid),
            digits(row.acc),
            digits(row.jerk),
            unit(axis).1,
        ));
    }
    lines
}

/// Rounds a component to four decimals.
fn short(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

/// Rounds to six digits, at least to the unit.
fn digits(value: f64) -> f64 {
    // Six digits in all: fewer decimals for larger numbers, none from 1e5 on.
    let places = (5.0 - math::log10(value.abs().max(1.0)).floor()).max(0.0);
    let scale = math::powf(10.0, places);
    (value * scale).round() / scale + 0.0
}

fn reach_lines(machine: &Machine, about: &MachineJson) -> Result<Vec<String>, Failure> {
    let [_, _, _, first, second] = &machine.axes;
    let [low, high] = about.reach.map(short);
    let [least, most] = about.reach_in_travel.map(short);
    let mut lines = vec![
        String::new(),
        format!(
            "reach     the tool is inclined to {}'s direction by {low} .. {high} deg; with the travel of {} by {least} .. {most} deg",
            first.name, second.name
        ),
        match first.limits.width() {
            turn if turn >= std::f64::consts::TAU => {
                format!("          to every side: {} turns a full circle", first.name)
            }
            turn => format!(
                "          over a sector of {} deg: the travel of {}",
                short(turn.to_degrees()),
                first.name
            ),
        },
    ];
    // Directions are those of a part parallel to the machine; a setup rotates them.
    let inverse = inverse(machine)?;
    let directions = inverse.singular_directions();
    if directions.is_empty() {
        lines.push(
            "singular  nowhere: the tool is never parallel to the workpiece-side rotary".into(),
        );
    }
    for (direction, part) in directions.iter().zip(&about.singular_directions) {
        let [x, y, z] = part.map(short);
        // The second rotary has one position there, up to full turns: the one nearest to its middle.
        let at = inverse.second_at_pole(direction, 1e-9).unwrap_or_default();
        let [low, high] = second.limits.ends();
        let middle = if low.is_finite() { 0.5 * (low + high) } else { 0.0 };
        let at = trunnion::math::angle::unwrap_near(at, middle);
        let inside = if (low..=high).contains(&at) { "" } else { ", outside its travel" };
        lines.push(format!(
            "singular  tool along ({x}, {y}, {z}) of the part: {} = {} deg{inside}, {} is free there",
            second.name,
            short(at.to_degrees()),
            first.name
        ));
    }
    Ok(lines)
}

fn sign_lines(machine: &Machine, about: &MachineJson) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        "signs     jog each axis from home and watch; if the machine moves the other way, write sense = -1".into(),
    ];
    lines.extend(about.signs.iter().zip(&machine.axes).map(|(sign, axis)| {
        let jog = format!("{} {:+}", sign.axis, sign.jog);
        format!("  {jog:<8} {:<4} {}", unit(axis).1, sign.expect)
    }));
    lines
}

/// Diagnostics of one file for scripts.
#[derive(Debug, serde::Serialize)]
struct CheckJson {
    file: String,
    ok: bool,
    faults: Vec<FaultJson>,
}

#[derive(Debug, serde::Serialize)]
struct FaultJson {
    line: u32,
    column: u32,
    message: String,
    help: String,
}

fn check(files: &[String], form: OutputForm) -> Result<Done, Failure> {
    let mut checks = Vec::new();
    for file in files {
        let faults = match source(file) {
            Ok(text) => parse(&text).err().unwrap_or_default(),
            Err(Failure::Input(messages)) => {
                messages.into_iter().map(|message| unreadable(file, &message)).collect()
            }
            Err(failure) => return Err(failure),
        };
        // Each file is reported as soon as it is read; JSON needs all of them.
        if !form.is_json() {
            match faults.len() {
                0 => text::print(&format!("{file}: in order\n"))?,
                1 => text::print(&format!("{file}: 1 fault\n"))?,
                count => text::print(&format!("{file}: {count} faults\n"))?,
            };
            for fault in &faults {
                eprintln!("error: {file}:{fault}");
            }
        }
        checks.push((file, faults));
    }
    let done =
        // Faulty files are the answer to this verb, but scripts expect the code of bad input.
        if checks.iter().all(|(_, faults)| faults.is_empty()) { Done::Kept } else { Done::Refused };
    if form.is_json() {
        let checks = checks.into_iter().map(|(file, faults)| CheckJson::of(file, faults));
        text::print_json(&checks.collect::<Vec<_>>())?;
    }
    Ok(done)
}

/// Returns the diagnostic of an unreadable file, whose message starts with its name.
fn unreadable(file: &str, message: &str) -> Diagnostic {
    let message = message.strip_prefix(file).unwrap_or(message).trim_start_matches([':', ' ']);
    let (message, help) = message.split_once("\n  help: ").unwrap_or((message, ""));
    Diagnostic::whole(message).with_help(help)
}

impl CheckJson {
    fn of(file: &str, faults: Diagnostics) -> Self {
        let ok = faults.is_empty();
        let faults = faults
            .into_iter()
            .map(|Diagnostic { line, column, message, help }| FaultJson {
                line,
                column,
                message,
                help,
            })
            .collect();
        Self { file: file.to_owned(), ok, faults }
    }
}

/// Returns the upper end of the travel of Z \[mm\]; `None` without one.
pub(crate) fn top_of_z(machine: &Machine) -> Option<f64> {
    let [_, _, z, ..] = &machine.axes;
    Some(z.limits.high).filter(|end| end.is_finite())
}
