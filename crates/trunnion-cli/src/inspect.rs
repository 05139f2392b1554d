//! `trunnion inspect`: lists the faces of a part for a job, or summarises a CL file or program.

mod cl;
mod program;

pub(crate) use program::parameter;

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, part};
use std::path::PathBuf;
use trunnion::import::inspect::{self, FaceSummary};

#[derive(Debug, clap::Args)]
pub(crate) struct InspectArgs {
    /// Surface JSON or STEP file; a CL file (.cls .clsf .apt .aptsource .ncl .cl .clt); or an NC program
    /// (.ngc .nc .cnc .tap .gcode .mpf .spf .h .eia .min .ptp).
    part: PathBuf,
    /// Also draw the faces with their numbers into this SVG file.
    #[arg(short, long, value_name = "SVG")]
    output: Option<PathBuf>,
    #[command(flatten)]
    program: program::ProgramArgs,
}

/// Returns true if the file name is that of a CL file.
pub(crate) fn is_cl(path: &std::path::Path) -> bool {
    cl::is_one(path)
}

/// Returns true if the file name is that of a program or CL file.
pub(crate) fn is_motion(path: &std::path::Path) -> bool {
    cl::is_one(path) || program::is_one(path)
}

pub(crate) fn run(args: &InspectArgs, form: OutputForm) -> Result<Done, Failure> {
    if cl::is_one(&args.part) {
        // -o draws faces; ignoring it would leave the user without a file.
        if args.output.is_some() {
            return Err(Failure::input("-o draws parts, not CL files\n  help: leave out -o"));
        }
        return cl::run(&args.part, form);
    }
    if program::is_one(&args.part) {
        if args.output.is_some() {
            return Err(Failure::input("-o draws parts, not programs\n  help: leave out -o"));
        }
        return program::run(&args.part, &args.program, form);
    }
    if let Some(path) = &args.output {
        output::protect(path, &[&args.part])?;
    }
    let part = part::read(&args.part, &Bars::new())?;
    for warning in &part.warnings {
        eprintln!("warning: {warning}");
    }
    let faces: Vec<FaceSummary> = part.faces.iter().map(inspect::summary).collect();
    if let Some(path) = &args.output {
        let picture = inspect::picture(&part.faces);
        output::file(path, |out| out.write_all(picture.as_bytes()))?;
    }
    let rows: Vec<FaceJson> = faces.iter().map(FaceJson::of).collect();
    form.print(&rows, |_| table(&faces))
}

/// One face for scripts; lengths in mm.
#[derive(Debug, serde::Serialize)]
struct FaceJson {
    number: usize,
    kind: &'static str,
    range: [[f64; 2]; 2],
    bounds: [[f64; 3]; 2],
    area: f64,
    concave_radius: Option<f64>,
    normal: Option<[f64; 3]>,
    trimmed: bool,
}

impl FaceJson {
    fn of(face: &FaceSummary) -> Self {
        Self {
            number: face.number,
            kind: face.kind,
            range: face.range.map(trunnion::types::Interval::ends),
            bounds: face.bounds.map(|corner| corner.coords.into()),
            area: face.area,
            concave_radius: face.concave_radius,
            normal: face.normal.map(|normal| normal.into_inner().into()),
            trimmed: face.trimmed,
        }
    }
}

fn table(faces: &[FaceSummary]) -> String {
    let mut lines = vec![format!(
        "{:>4}  {:<10} {:>24}  {:>22} {:>11}  {:>12}  {:<22} {}",
        "face", "kind", "u, v range", "size mm", "area mm2", "concave mm", "cutter side", "trim"
    )];
    lines.extend(faces.iter().map(row));
    lines.join("\n") + "\n"
}

fn row(face: &FaceSummary) -> String {
    let [[u0, u1], [v0, v1]] = face.range.map(<[f64; 2]>::from);
    let size = face.bounds[1] - face.bounds[0];
    let concave = face.concave_radius.map_or("none".to_owned(), |r| format!("{r:.2}"));
    let normal = face
        .normal
        .map_or("all round".to_owned(), |n| format!("{:+.2} {:+.2} {:+.2}", n.x, n.y, n.z));
    format!(
        "{:>4}  {:<10} {:>24}  {:>22} {:>11.1}  {concave:>12}  {normal:<22} {}",
        face.number,
        face.kind,
        format!("{u0:.3}..{u1:.3}, {v0:.3}..{v1:.3}"),
        format!("{:.1} x {:.1} x {:.1}", size.x, size.y, size.z),
        face.area,
        if face.trimmed { "trimmed" } else { "" },
    )
}
