//! `trunnion init`: writes a job for a part that runs as it is.

use crate::form::OutputForm;
use crate::option_values::part_angles;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{disk, library, machine, output, part, text};
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use trunnion::cutter::{CutterConstruction, CutterKind, CutterSpec};
use trunnion::files::job::JobArea;
use trunnion::math;
use trunnion::pipeline::{self, FaceReason, JobProposal, ProposalRequest, ProposedOperation};
use trunnion::types::Progress;

#[derive(Debug, clap::Args)]
pub(crate) struct InitArgs {
    /// STEP or surface JSON file of the part.
    part: PathBuf,
    /// Machine file, or name of a built-in machine.
    #[arg(short, long, value_name = "MACHINE", default_value = "bc-trunnion")]
    machine: String,
    /// Job file to write; without it, the job is printed. An existing file is left as it is.
    #[arg(short, long, value_name = "JOB")]
    output: Option<PathBuf>,
    /// Faces to choose from, by their numbers from `trunnion inspect` [default: all].
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    faces: Vec<usize>,
    /// Rotation of the part about its x, then y, then z, in degrees: the side to be cut comes up [default: as drawn, or by a
    /// quarter or half turn where a tool then reaches much more of it from above].
    #[arg(long, value_name = "A,B,C", value_parser = part_angles, allow_hyphen_values = true)]
    rotation: Option<[f64; 3]>,
    /// Library of the cutters to choose from, TOML as `trunnion schema library` has it [default: the standard one].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

pub(crate) fn run(args: &InitArgs, form: OutputForm) -> Result<Done, Failure> {
    if let Some(path) = &args.output {
        output::refuse_existing(path)?;
    }
    let bars = Bars::new();
    let ProposalAnswer { proposal, warnings, job } = answer(args, &bars)?;
    bars.finish();
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    let Some(path) = &args.output else {
        return if form.is_json() { text::print_json(&JobJson { job }) } else { text::print(&job) };
    };
    // The part is the only input that the output could replace.
    output::protect(path, &[&args.part])?;
    output::file(path, |out| out.write_all(job.as_bytes()))?;
    form.print(&InitJson::of(path, &proposal), |_| describe(path, args, &proposal))
}

/// Proposed job for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct ProposalAnswer {
    /// Text of the job file.
    pub job: String,
    /// Remarks about the part, in words.
    pub warnings: Vec<String>,
    /// Faces, tools and origin behind the text.
    pub proposal: JobProposal,
}

/// Proposes a job, and writes nothing.
pub(crate) fn answer(args: &InitArgs, progress: &dyn Progress) -> Result<ProposalAnswer, Failure> {
    let machine = machine::load(&args.machine)?;
    let part = part::read(&args.part, progress)?;
    for number in &args.faces {
        if !part.faces.iter().any(|face| face.number == *number) {
            let help = format!("`trunnion inspect {}` lists them", args.part.display());
            return Err(Failure::input(format!("the part has no face {number}\n  help: {help}")));
        }
    }
    let library = args.library.as_deref().map(library::read).transpose()?;
    let request = ProposalRequest {
        library: library.as_ref(),
        wanted: (!args.faces.is_empty()).then_some(&args.faces[..]),
        angles: args.rotation.map(|angles| angles.map(f64::to_radians)),
        ..ProposalRequest::new(&part.faces, &machine.machine)
    };
    let proposal = pipeline::propose(&request, progress).map_err(Failure::input)?;
    let warnings = part.warnings.iter().map(ToString::to_string).collect();
    Ok(ProposalAnswer { job: job_text(args, &proposal), warnings, proposal })
}

/// The job, for scripts.
#[derive(Debug, serde::Serialize)]
struct JobJson {
    job: String,
}

/// Result for scripts; lengths in mm.
#[derive(Debug, serde::Serialize)]
struct InitJson {
    job: String,
    /// Rotation of the part, in degrees.
    rotation: [f64; 3],
    faces: Vec<usize>,
    left_out: Vec<LeftOutJson>,
    /// Kind and diameter of the first tool.
    tool: &'static str,
    diameter: f64,
    operations: Vec<OperationJson>,
    origin: [f64; 3],
}

#[derive(Debug, serde::Serialize)]
struct OperationJson {
    faces: Vec<usize>,
    method: &'static str,
    tool: &'static str,
    diameter: f64,
}

impl OperationJson {
    fn of(operation: &ProposedOperation) -> Self {
        Self {
            faces: operation.faces.clone(),
            method: method(operation),
            tool: operation.cutter.kind.name(),
            diameter: diameter(&operation.cutter),
        }
    }
}

fn method(operation: &ProposedOperation) -> &'static str {
    match operation.area {
        JobArea::Whole => "auto",
        JobArea::Rest => "rest",
    }
}

#[derive(Debug, serde::Serialize)]
struct LeftOutJson {
    face: usize,
    reason: String,
}

impl InitJson {
    fn of(path: &Path, proposal: &JobProposal) -> Self {
        let left_out = proposal
            .left_out
            .iter()
            .map(|face| LeftOutJson { face: face.number, reason: face.reason.to_string() });
        let first = proposal.operations.first();
        Self {
            job: path.display().to_string(),
            rotation: rotation(proposal).unwrap_or_default(),
            faces: proposal.faces.clone(),
            left_out: left_out.collect(),
            tool: first.map_or("", |one| one.cutter.kind.name()),
            diameter: first.map_or(0.0, |one| diameter(&one.cutter)),
            operations: proposal.operations.iter().map(OperationJson::of).collect(),
            origin: proposal.origin.into(),
        }
    }
}

fn diameter(cutter: &CutterSpec) -> f64 {
    tidy(2.0 * (cutter.major + cutter.minor))
}

/// Drops the digits that sums of tenths leave behind.
fn tidy(value: f64) -> f64 {
    // + 0.0 turns -0 into 0.
    (value * 1e6).round() / 1e6 + 0.0
}

/// Returns the name of the part as the job names it: relative to the folder of the job.
fn part_name(args: &InitArgs) -> String {
    let folder = args.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    // A part beside its job is named without a folder, so that both can be moved together.
    let beside = args.part.parent().unwrap_or(Path::new("")) == folder;
    match args.part.file_name().filter(|_| beside) {
        Some(name) => name.to_string_lossy().into_owned(),
        // Any other folder: the whole path is right from everywhere.
        None => whole(&args.part),
    }
}

/// Returns the name of the machine as the job names it.
fn machine_name(args: &InitArgs) -> String {
    let path = Path::new(&args.machine);
    // The name of a built-in machine needs no path.
    if !disk::exists(path) {
        return args.machine.clone();
    }
    whole(path)
}

/// Returns a name that is right from every folder; names in memory are whole.
fn whole(path: &Path) -> String {
    let named = if disk::is_memory() { Ok(path.to_owned()) } else { std::path::absolute(path) };
    named.unwrap_or_else(|_| path.to_owned()).to_string_lossy().into_owned()
}

/// Returns a string in TOML, quoted.
fn quoted(text: &str) -> String {
    // JSON escapes quotes, backslashes and control characters as basic strings of TOML do.
    serde_json::to_string(text).unwrap_or_else(|_| format!("'{text}'"))
}

/// Writes the job, with comments for who has never seen one.
fn job_text(args: &InitArgs, proposal: &JobProposal) -> String {
    let part = part_name(args);
    let stem = args.part.file_stem().map_or_else(|| "part".into(), |stem| stem.to_string_lossy());
    let [x, y, z]: [f64; 3] = proposal.origin.map(tidy).into();
    let faces: Vec<String> = proposal.faces.iter().map(usize::to_string).collect();
    let mut out = String::new();
    let mut line = |text: &str| out.extend([text, "\n"]);
    line("# Proposed by trunnion init. Lines marked \"check\" hold what only you can know.");
    line("# Run it:  trunnion run THIS-FILE     Only check it:  trunnion run --dry-run THIS-FILE");
    line("schema = \"trunnion-job/1\"");
    line(&format!("name = {}", quoted(&stem)));
    line("\n[part]");
    line(&format!("file = {}", quoted(&part)));
    if let Some([x, y, z]) = rotation(proposal) {
        line(&format!(
            "rotation = [{x}, {y}, {z}]  # of the part about its x, y, z, deg: {}",
            turned(args)
        ));
    }
    line(&format!("faces = [{}]", faces.join(", ")));
    if proposal.flip {
        line(
            "flip = true  # the faces look down to the table: the cutter works on their other side",
        );
    }
    line(
        "# `trunnion inspect PART -o faces.svg` draws the numbers. The tool keeps off all other faces.",
    );
    // Faces left out stay in the text, so that the user can decide otherwise.
    for group in LeftOutGroup::all(proposal) {
        line(&format!("# not cut: {group}"));
    }
    line("\n[setup]");
    line(&format!(
        "origin = [{x}, {y}, {z}]  # check: the zero of the part in machine coordinates, all axes at 0, mm"
    ));
    line(
        "rotation = [0, 0, 0]  # about the machine's x, y, z, deg; `trunnion setup` searches for a better one",
    );
    line(&format!(
        "clearance = {}  # links travel this far above the part, mm",
        proposal.clearance
    ));
    line(&tools(proposal));
    line("\n[tolerance]");
    line(&format!(
        "total = {:.2}  # largest excess after everything, mm",
        Short(proposal.tolerance.excess)
    ));
    line(&format!(
        "gouge = {:.2}  # deepest gouge after everything, mm",
        Short(proposal.tolerance.gouge)
    ));
    line("\n[strategy]");
    line("method = \"auto\"  # a ball leans by 10 deg, other cutters cut the widest strips");
    line(
        "along = \"adaptive\"  # the quickest of several layouts; \"u\", \"v\" or \"curvature\" plan sooner",
    );
    if let [only] = &proposal.operations[..] {
        line("\n[cutting]");
        line(&format!("feed = {}  # check: mm/min", feed(only)));
        line(&format!("spindle = {}  # check: rev/min", spindle(only)));
        line("coolant = true");
    }
    line("\n[machine]");
    line(&format!(
        "file = {}  # `trunnion machine list` lists those built in",
        quoted(&machine_name(args))
    ));
    line("\n[output]");
    line("dialects = [\"linuxcnc\"]  # `trunnion schema job` lists all dialects and keys");
    out
}

/// Returns the rotation of the part in degrees; `None` for a part as drawn.
fn rotation(proposal: &JobProposal) -> Option<[f64; 3]> {
    let degrees = proposal.angles.map(|angle| tidy(angle.to_degrees()));
    degrees.iter().any(|angle| *angle != 0.0).then_some(degrees)
}

/// Returns the reason why the part is turned.
fn turned(args: &InitArgs) -> &'static str {
    match args.rotation {
        Some(_) => "as asked for",
        None => "more of it is reached from above; `--rotation 0,0,0` leaves it as drawn",
    }
}

/// Faces that are left out for the same reason.
struct LeftOutGroup {
    faces: Vec<usize>,
    reason: String,
    /// Help for the reason.
    help: String,
}

impl LeftOutGroup {
    /// Groups the faces that a proposal leaves out, in order of the first of each.
    fn all(proposal: &JobProposal) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for face in &proposal.left_out {
            let reason = face.reason.to_string();
            if let Some(group) = groups.iter_mut().find(|group| group.reason == reason) {
                group.faces.push(face.number);
            } else {
                let help = help(&face.reason, proposal);
                groups.push(Self { faces: vec![face.number], reason, help });
            }
        }
        groups
    }
}

impl std::fmt::Display for LeftOutGroup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { faces, reason, help } = self;
        let numbers: Vec<String> = faces.iter().map(usize::to_string).collect();
        match &faces[..] {
            [_] => write!(f, "face {} {reason}{help}", numbers.join(", ")),
            _ => write!(f, "faces {}: each {reason}{help}", numbers.join(", ")),
        }
    }
}

/// Returns how `trunnion init` cuts a face that this proposal leaves out.
fn help(reason: &FaceReason, proposal: &JobProposal) -> String {
    match reason {
        FaceReason::Down => {
            // Half a turn more about x.
            let over = math::rotation_of_xyz([PI, 0.0, 0.0].into())
                * math::exact_rotation_of_xyz(proposal.angles.into());
            let [x, y, z]: [f64; 3] =
                math::xyz_of_rotation(&over).map(|angle| tidy(angle.to_degrees())).into();
            format!(" (`--rotation {x},{y},{z}`)")
        }
        FaceReason::Wall => " (`--faces`)".to_owned(),
        _ => String::new(),
    }
}

/// A number with a few significant digits, without trailing zeros.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(3);
        // Power of ten of the first digit; the smallest number stands in for 0, which has none.
        let size = math::log10(self.0.abs().max(f64::MIN_POSITIVE)).floor();
        let unit = math::powf(10.0, size - digits as f64 + 1.0);
        write!(f, "{}", tidy((self.0 / unit).round() * unit))
    }
}

/// Returns the feed in mm/min.
fn feed(operation: &ProposedOperation) -> f64 {
    (60.0 * operation.feed).round()
}

/// Returns the spindle speed in rev/min.
fn spindle(operation: &ProposedOperation) -> f64 {
    (60.0 * operation.spindle).round()
}

/// Writes the tool of a job of one operation, or all operations.
fn tools(proposal: &JobProposal) -> String {
    let why = if proposal.concave_radius.is_finite() {
        format!(
            "the tightest concave radius of the faces is {:.3} mm",
            Short(proposal.concave_radius)
        )
    } else {
        "the faces are nowhere concave".to_owned()
    };
    let mut out = String::new();
    if let [only] = &proposal.operations[..] {
        out.push_str("\n[tool]\n");
        out.push_str(&tool_lines(&only.cutter, 1, Some(&why)));
        return out.trim_end().to_owned();
    }
    out.push_str("\n# One tool after the other; all in one program.\n");
    let count = proposal.operations.len();
    let mut cutters: Vec<&CutterSpec> = Vec::new();
    for (index, operation) in proposal.operations.iter().enumerate() {
        let faces: Vec<String> = operation.faces.iter().map(usize::to_string).collect();
        let _ = writeln!(out, "[[operation]]");
        let _ = writeln!(out, "faces = [{}]", faces.join(", "));
        if operation.area == JobArea::Rest {
            let _ = writeln!(
                out,
                "method = \"rest\"  # only what the operations before leave, and faces that they do not cut"
            );
        }
        let _ = writeln!(
            out,
            "cutting = {{ feed = {}, spindle = {}, coolant = true }}  # check: mm/min, rev/min",
            feed(operation),
            spindle(operation)
        );
        let why = (index + 1 == count).then_some(why.as_str());
        let known = cutters.iter().position(|cutter| *cutter == &operation.cutter);
        if let Some(known) = known {
            let why = why.map_or_else(String::new, |why| format!("; {why}"));
            let _ = writeln!(out, "tool = {}  # as above{why}", known + 1);
        } else {
            cutters.push(&operation.cutter);
            let _ = writeln!(out, "[operation.tool]");
            out.push_str(&tool_lines(&operation.cutter, cutters.len(), why));
        }
        out.push('\n');
    }
    out.trim_end().to_owned()
}

/// Writes the lines of a tool.
fn tool_lines(cutter: &CutterSpec, number: usize, why: Option<&str>) -> String {
    let mut out = String::new();
    let kind = cutter.kind.name();
    let why = why.map_or_else(String::new, |why| format!("  # {why}"));
    let _ = writeln!(out, "number = {number}");
    let _ = writeln!(out, "kind = \"{kind}\"{why}");
    let _ = writeln!(out, "diameter = {}", diameter(cutter));
    if cutter.kind == CutterKind::Bull {
        let _ = writeln!(out, "corner_radius = {}", tidy(cutter.minor));
    }
    let _ = writeln!(out, "length = {}  # check: gauge point to tip, mm", cutter.length);
    if let CutterConstruction::Insert { inner_cutting_radius } = cutter.construction {
        let _ = writeln!(out, "construction = \"insert\"");
        let _ = writeln!(out, "inner_cutting_radius = {}", tidy(inner_cutting_radius));
    }
    if !cutter.shank.is_empty() {
        let _ = writeln!(out, "shank = {:?}  # shank and holder", cutter.shank);
    }
    out
}

/// Returns "face 3" or "faces 3, 7".
fn list_faces(numbers: &[usize]) -> String {
    let list: Vec<String> = numbers.iter().map(usize::to_string).collect();
    let plural = if list.len() == 1 { "face" } else { "faces" };
    format!("{plural} {}", list.join(", "))
}

fn describe(path: &Path, args: &InitArgs, proposal: &JobProposal) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{}: cuts {}", path.display(), list_faces(&proposal.faces));
    if let Some([x, y, z]) = rotation(proposal) {
        let _ = writeln!(out, "  rotation of the part: [{x}, {y}, {z}] deg, {}", turned(args));
    }
    for group in LeftOutGroup::all(proposal) {
        let _ = writeln!(out, "  not cut: {group}");
    }
    let several = proposal.operations.len() > 1;
    for operation in &proposal.operations {
        let kind = match operation.cutter.kind {
            CutterKind::Flat => "flat end mill",
            CutterKind::Ball => "ball end mill",
            CutterKind::Bull => "bull-nose end mill",
            other => other.name(),
        };
        let faces = list_faces(&operation.faces);
        let cuts = match operation.area {
            _ if !several => String::new(),
            JobArea::Whole => format!(", for {faces}"),
            JobArea::Rest if operation.faces == proposal.faces => ", for the rest".to_owned(),
            JobArea::Rest => format!(", for the rest of {faces}"),
        };
        let _ = writeln!(
            out,
            "  tool: {kind}, diameter {} mm, length {} mm{cuts}",
            diameter(&operation.cutter),
            operation.cutter.length
        );
    }
    let [x, y, z]: [f64; 3] = proposal.origin.map(tidy).into();
    let _ = writeln!(out, "  origin: [{x}, {y}, {z}] mm, inside the travel of the machine");
    let _ = writeln!(
        out,
        "next: see the lines marked \"check\", then  trunnion run {}",
        path.display()
    );
    out
}
