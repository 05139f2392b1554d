//! `trunnion position`: one cutter location, explained.

mod answer;
mod compare;

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, part};
use answer::{Answer, table};
use nalgebra::Vector3;
use std::path::PathBuf;
use trunnion::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};
use trunnion::positioning::{
    ContactSide, CutterLocation, LocationRequest, NestedGrid, PlacementMethod, PositioningError,
    StripSide, ToleranceBand, error_picture, place, trace,
};
use trunnion::surface::{Face, FaceIndex, Surface};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Surface JSON or STEP file.
    #[arg(long, value_name = "FILE")]
    surface: PathBuf,
    /// Number of the face, see `trunnion inspect`.
    #[arg(long, value_name = "N", default_value_t = 1)]
    face: usize,
    /// Place the cutter on the other side of the face.
    #[arg(long)]
    flip: bool,
    /// Radii in mm: R of the centre circle, r of the corner. Optional: L, length of the tool that
    /// must keep clear (default 2 (R + r)); inner, radius inside which inserts do not cut.
    #[arg(long, value_name = "R=10,r=6")]
    cutter: String,
    /// Largest error of the strip in mm; nothing may gouge.
    #[arg(long, value_name = "MM")]
    tolerance: f64,
    /// Parameters of the point where the strip begins, as in the knots of the surface.
    #[arg(long, value_name = "U,V", value_parser = two, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Feed direction in parameters; its sign counts.
    #[arg(long, value_name = "DU,DV", value_parser = two, allow_hyphen_values = true)]
    feed: [f64; 2],
    /// Side of the feed on which the strip lies.
    #[arg(long, default_value = "right")]
    strip: Strip,
    /// Where the contact arc lies from the cutter centre, along the feed; anything but `ahead`
    /// needs a centre-cutting tool.
    #[arg(long, default_value = "ahead")]
    side: Side,
    /// Range of the offset direction in degrees, from the strip's side towards the feed.
    #[arg(long, value_name = "LO,HI", value_parser = two, default_value = "-75,75", allow_hyphen_values = true)]
    offset_range: [f64; 2],
    /// Method of placing the cutter.
    #[arg(long, default_value = "end-point")]
    method: Method,
    /// Place the cutter by every method, and print the results side by side.
    #[arg(long, conflicts_with = "method")]
    compare: bool,
    /// sturz, ball: lead angle in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 5.0, allow_hyphen_values = true)]
    lead: f64,
    /// lead-swivel: largest swivel to either side of the feed in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 20.0)]
    swivel: f64,
    /// Also draw the error along the cutting circle into this SVG file; with --compare, the strips of
    /// all methods.
    #[arg(short, long, value_name = "SVG")]
    output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
The strip begins at the point --at, where the error is the tolerance, and lies to the right of the feed
(seen along it, the normal up); `left` is for the return pass of a zigzag.
  end-point    the widest strip: error within [0, tolerance] on it, no gouge anywhere (default)
  nested       the same by the grid search of the original paper: slow, and only as good as its grid
  mpm          two contacts, the error between them at the tolerance (multi-point machining)
  hermite      the same with the contacts assumed at Chebyshev nodes
  ball         a ball as large as the cutter
These touch at --at, and their strip lies around it:
  lead-swivel  one contact with the lead and swivel that give the widest strip
  curvature    inclined until the circle has the curvature of the surface, more if that gouges
  sturz        fixed lead
  three-axis   the tool axis along z
Every pose is checked independently of its method: one that gouges, or touches where the cutter does not cut,
is refused with the reason and a remedy.
Exit codes: 0 found; 1 none exists (with reason and remedy); 2 malformed input.

  trunnion position --surface patch.json --cutter R=10,r=6 --tolerance 0.01 --at 0.4,0.5 --feed 0,1
  trunnion position --surface patch.json --cutter R=10,r=6 --tolerance 0.01 --at 0.4,0.5 --feed 0,1 --compare -o strips.svg
  trunnion position --surface part.step --face 3 --cutter R=8,r=2 --tolerance 0.02 --at 0.5,0.5 --feed 1,0 --json -o error.svg";

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Strip {
    Right,
    Left,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Side {
    Ahead,
    Behind,
    Either,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Method {
    EndPoint,
    Nested,
    Mpm,
    Hermite,
    LeadSwivel,
    Curvature,
    Sturz,
    ThreeAxis,
    Ball,
}

impl Method {
    /// In the order in which they are compared: those that begin at the place first.
    const ALL: [Self; 9] = [
        Self::EndPoint,
        Self::Nested,
        Self::Mpm,
        Self::Hermite,
        Self::LeadSwivel,
        Self::Curvature,
        Self::Sturz,
        Self::ThreeAxis,
        Self::Ball,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::EndPoint => "end-point",
            Self::Nested => "nested",
            Self::Mpm => "mpm",
            Self::Hermite => "hermite",
            Self::LeadSwivel => "lead-swivel",
            Self::Curvature => "curvature",
            Self::Sturz => "sturz",
            Self::ThreeAxis => "three-axis",
            Self::Ball => "ball",
        }
    }

    fn placing(self, args: &Args) -> PlacementMethod {
        let lead = args.lead.to_radians();
        match self {
            Self::EndPoint => PlacementMethod::EndPoint,
            Self::Nested => PlacementMethod::Nested(grid(args.tolerance)),
            Self::Mpm => PlacementMethod::MultiPoint,
            Self::Hermite => PlacementMethod::HermiteChebyshev,
            Self::LeadSwivel => PlacementMethod::LeadSwivel { swivel: args.swivel.to_radians() },
            Self::Curvature => PlacementMethod::CurvatureMatched,
            Self::Sturz => PlacementMethod::Sturz { lead },
            Self::ThreeAxis => PlacementMethod::FixedAxis { axis: Vector3::z_axis() },
            Self::Ball => PlacementMethod::Ball { lead },
        }
    }
}

/// What the nested search is compared with: 3 degrees of arc or less between samples, the offset to
/// a micrometre, its direction to a hundredth of a degree, contacts to a thousandth of the band.
fn grid(tolerance: f64) -> NestedGrid {
    NestedGrid {
        front: 41,
        rear: 90,
        directions: 10,
        offset: 1e-3,
        direction: 0.01_f64.to_radians(),
        touch: 1e-3 * tolerance,
    }
}

fn two(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f64>());
    let numbers: Vec<f64> = numbers.filter_map(Result::ok).filter(|x| x.is_finite()).collect();
    let count = text.split(',').count();
    let pair = numbers.try_into().ok().filter(|_| count == 2);
    pair.ok_or_else(|| "two numbers separated by a comma are expected".to_owned())
}

pub(crate) fn run(args: &Args, form: OutputForm) -> Result<Done, Failure> {
    let face = face(args)?;
    on_the_surface(&face.face().surface, args.at)?;
    let cutter = cutter(args)?;
    let tolerance = args.tolerance;
    let request = LocationRequest {
        face: &face,
        cutter: &cutter,
        band: ToleranceBand { lower: 0.0, upper: tolerance },
        at: args.at,
        feed: args.feed,
        strip: match args.strip {
            Strip::Right => StripSide::Right,
            Strip::Left => StripSide::Left,
        },
        side: match args.side {
            Side::Ahead => ContactSide::Ahead,
            Side::Behind => ContactSide::Behind,
            Side::Either => ContactSide::Either,
        },
        offset_range: args.offset_range.map(f64::to_radians),
        axis_cone: None,
    };
    if args.compare {
        return compare::run(&request, args, form);
    }
    let method = args.method.placing(args);
    match place(&request, &method) {
        Ok(location) => {
            if let Some(path) = &args.output {
                let picture = picture(&request, &location, args).map_err(refusal)?;
                output::file(path, |out| out.write_all(picture.as_bytes()))?;
            }
            form.print(&Answer::new(&location, args.method), |_| table(&location, args))
        }
        Err(error) if asked_wrong(&error) => Err(refusal(error)),
        Err(error) => {
            let refused = serde_json::json!({ "refused": error.to_string() });
            form.print(&refused, |_| format!("no cutter location: {error}\n"))?;
            Ok(Done::Broken)
        }
    }
}

/// Whether the request itself is at fault, not the place.
fn asked_wrong(error: &PositioningError) -> bool {
    use PositioningError as E;
    matches!(
        error,
        E::EmptyBand { .. }
            | E::OffsetRange { .. }
            | E::NoDirection { .. }
            | E::NotCentreCutting { .. }
            | E::NoCircle
            | E::Angle { .. }
            | E::Cutter(_)
    )
}

fn refusal(error: PositioningError) -> Failure {
    Failure::input(error)
}

/// The library goes on beyond an edge, where a tool rolls off; a place asked for there is a slip.
fn on_the_surface(surface: &Surface, at: [f64; 2]) -> Result<(), Failure> {
    let parameters = ["u", "v"].into_iter().zip(at).zip(surface.domain()).zip(surface.periods());
    for (((name, value), [low, high]), period) in parameters {
        if period.is_none() && !(low..=high).contains(&value) {
            return Err(Failure::input(format!(
                "--at: {name} = {value} is off the surface, where {name} goes from {low} to {high}"
            )));
        }
    }
    Ok(())
}

fn face(args: &Args) -> Result<FaceIndex, Failure> {
    let part = part::read(&args.surface, &Bars::new())?;
    for warning in &part.warnings {
        eprintln!("warning: {warning}");
    }
    let count = part.faces.len();
    let wanted = part.faces.into_iter().find(|face| face.number == args.face);
    let Some(Face { number, surface, loops, flip }) = wanted else {
        let file = args.surface.display();
        let help = format!("trunnion inspect {file} lists them");
        let face = args.face;
        return Err(Failure::input(format!(
            "{file} has {count} faces, none with the number {face}\n  help: {help}"
        )));
    };
    Face::new(number, surface, loops, flip != args.flip)
        .and_then(FaceIndex::new)
        .map_err(Failure::input)
}

/// `R=10,r=6`, optionally `L=..` and `inner=..`.
fn cutter(args: &Args) -> Result<Cutter, Failure> {
    let wrong = |what: &str| {
        let help = "for instance --cutter R=10,r=6 or R=10,r=6,L=120,inner=4";
        Failure::input(format!("--cutter {}: {what}\n  help: {help}", args.cutter))
    };
    let (mut major, mut minor, mut length, mut inner) = (None, None, None, None);
    for entry in args.cutter.split(',') {
        let (name, value) = entry.split_once('=').ok_or_else(|| wrong("name=value is expected"))?;
        let value = value.trim().parse::<f64>();
        let value = value.map_err(|_| wrong(&format!("{entry} is no number")))?;
        let place = match name.trim() {
            "R" => &mut major,
            "r" => &mut minor,
            "L" => &mut length,
            "inner" => &mut inner,
            other => return Err(wrong(&format!("{other} is none of R, r, L, inner"))),
        };
        *place = Some(value);
    }
    let (Some(major), Some(minor)) = (major, minor) else {
        return Err(wrong("both R and r are needed"));
    };
    let kind = match (major > 0.0, minor > 0.0) {
        (true, true) => CutterKind::Bull,
        (true, false) => CutterKind::Flat,
        (false, _) => CutterKind::Ball,
    };
    let length = length.unwrap_or(2.0 * (major + minor));
    let construction = inner.map_or(CutterConstruction::Solid, |inner_cutting_radius| {
        CutterConstruction::Insert { inner_cutting_radius }
    });
    Cutter::new(CutterSpec { kind, major, minor, length, construction, shank: Vec::new() })
        .map_err(|faults| Failure::Input(faults.iter().map(ToString::to_string).collect()))
}

fn picture(
    request: &LocationRequest,
    location: &CutterLocation,
    args: &Args,
) -> Result<String, PositioningError> {
    let cutter = args.method.placing(args).cutter(request.cutter)?;
    let name = args.method.name();
    let trace = trace(&LocationRequest { cutter: &cutter, ..*request }, location, name)?;
    Ok(error_picture(&trace, request.band, &title(args, &format!("{name}, {:.3} mm", trace.width))))
}

fn title(args: &Args, what: &str) -> String {
    let ([u, v], [du, dv]) = (args.at, args.feed);
    format!("{what}, at (u, v) = ({u}, {v}), feed ({du}, {dv}), tolerance {} mm", args.tolerance)
}
