//! `trunnion position`: one cutter location, explained.

use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, part, text};
use std::fmt::Write;
use std::path::PathBuf;
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::positioning::{
    Active, Band, ContactSide, Location, Look, PositioningError, Request, Setting, StripSide,
    curvature_matched, error_curve, error_picture, inclined, widest,
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
    /// The cutter is on the other side of the face.
    #[arg(long)]
    flip: bool,
    /// Radii in mm: R of the centre circle, r of the corner. Optional: L, length of the tool that
    /// must keep clear (default 2 (R + r)); inner, radius inside which inserts do not cut.
    #[arg(long, value_name = "R=10,r=6")]
    cutter: String,
    /// Largest error of the strip in mm; nothing may gouge.
    #[arg(long, value_name = "MM")]
    tolerance: f64,
    /// Knot parameters of the point where the strip begins.
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
    /// How the cutter is placed.
    #[arg(long, default_value = "end-point")]
    method: Method,
    /// sturz, ball: lead angle in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 5.0, allow_hyphen_values = true)]
    lead: f64,
    /// Also draw the error round the cutting circle into this SVG file.
    #[arg(short, long, value_name = "SVG")]
    output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
The strip begins at the point --at, where the error is the tolerance, and lies to the right of the feed
(seen along it, the normal up); `left` is what the return pass of a zigzag needs.
  end-point   the widest strip: error within [0, tolerance] on it, no gouge anywhere (default)
  sturz       fixed lead, chord across the feed; more lead only where the rear would gouge
  curvature   touches at the point, leans until the circle bends like the surface
  ball        a ball as large as the cutter
Exit codes: 0 found; 1 there is none (and why, and what would help); 2 malformed input.

  trunnion position --surface patch.json --cutter R=10,r=6 --tolerance 0.01 --at 0.4,0.5 --feed 0,1
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
    Sturz,
    Curvature,
    Ball,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::EndPoint => "end-point",
            Self::Sturz => "sturz",
            Self::Curvature => "curvature",
            Self::Ball => "ball",
        }
    }
}

fn two(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f64>());
    let numbers: Vec<f64> = numbers.filter_map(Result::ok).filter(|x| x.is_finite()).collect();
    let count = text.split(',').count();
    let pair = numbers.try_into().ok().filter(|_| count == 2);
    pair.ok_or_else(|| "two numbers separated by a comma are wanted".to_owned())
}

pub(crate) fn run(args: &Args, json: bool) -> Result<Done, Failure> {
    let face = face(args)?;
    on_the_surface(&face.face().surface, args.at)?;
    let cutter = cutter(args)?;
    let tolerance = args.tolerance;
    let request = Request {
        face: &face,
        cutter: &cutter,
        band: Band { lower: 0.0, upper: tolerance },
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
        axis_near: None,
    };
    let lead = args.lead.to_radians();
    let found = match args.method {
        Method::EndPoint => widest(&request, None),
        Method::Sturz => inclined(&Request { offset_range: [0.0; 2], ..request }, lead, None),
        Method::Curvature => curvature_matched(&request),
        Method::Ball => inclined(&request, lead, None),
    };
    match found {
        Ok(location) => {
            if let Some(path) = &args.output {
                let picture = picture(&request, &location, args).map_err(refusal)?;
                output::file(path, |out| out.write_all(picture.as_bytes()))?;
            }
            if json {
                text::print_json(&Answer::new(&location, args.method))
            } else {
                text::print(&table(&location, args))
            }
        }
        Err(error) if asked_wrong(&error) => Err(refusal(error)),
        Err(error) => {
            if json {
                text::print_json(&serde_json::json!({ "refused": error.to_string() }))?;
            } else {
                text::print(&format!("no cutter location: {error}\n"))?;
            }
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
        let (name, value) = entry.split_once('=').ok_or_else(|| wrong("name=value is wanted"))?;
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
    let (Some(mut major), Some(mut minor)) = (major, minor) else {
        return Err(wrong("both R and r are needed"));
    };
    if args.method == Method::Ball {
        (major, minor) = (0.0, major + minor);
    }
    let kind = match (major > 0.0, minor > 0.0) {
        (true, true) => Kind::Bull,
        (true, false) => Kind::Flat,
        (false, _) => Kind::Ball,
    };
    let length = length.unwrap_or(2.0 * (major + minor));
    let construction = inner.map_or(Construction::Solid, |inner_cutting_radius| {
        Construction::Insert { inner_cutting_radius }
    });
    Cutter::new(CutterSpec { kind, major, minor, length, construction, shank: Vec::new() })
        .map_err(|faults| Failure::Input(faults.iter().map(ToString::to_string).collect()))
}

fn picture(
    request: &Request,
    location: &Location,
    args: &Args,
) -> Result<String, PositioningError> {
    /// Half the points of the curve: one a degree.
    const HALF: u32 = 180;
    let setting = Setting { face: request.face, cutter: request.cutter, band: request.band };
    let jet = request.face.face().surface.jet1(request.at[0], request.at[1]);
    let look = Look {
        feed: jet.su * request.feed[0] + jet.sv * request.feed[1],
        strip: request.strip,
        contact: location.contact,
        uv: location.contact_uv,
    };
    let curve = error_curve(&setting, &location.pose, &look, HALF)?;
    let width = location.strip_width;
    let title = format!(
        "{}: {width:.3} mm at (u, v) = ({}, {}), feed ({}, {})",
        args.method.name(),
        args.at[0],
        args.at[1],
        args.feed[0],
        args.feed[1]
    );
    Ok(error_picture(&curve, request.band, &title))
}

/// The location for scripts; mm and degrees.
#[derive(Debug, serde::Serialize)]
struct Answer {
    method: &'static str,
    strip_width: f64,
    chord_width: f64,
    offset: f64,
    offset_direction_deg: f64,
    rotation_deg: f64,
    center: [f64; 3],
    tip: [f64; 3],
    axis: [f64; 3],
    side: &'static str,
    contact_angles_deg: Vec<f64>,
    active: Vec<&'static str>,
    front_max: f64,
    front_max_bound: f64,
    front_min: f64,
    rear_min: f64,
    rear_min_bound: f64,
    queries: u32,
}

impl Answer {
    fn new(location: &Location, method: Method) -> Self {
        Self {
            method: method.name(),
            strip_width: location.strip_width,
            chord_width: location.chord_width,
            offset: location.offset,
            offset_direction_deg: location.offset_direction.to_degrees(),
            rotation_deg: location.rotation.to_degrees(),
            center: location.center.coords.into(),
            tip: location.pose.tip.coords.into(),
            axis: location.pose.axis.into_inner().into(),
            side: side_name(location.side),
            contact_angles_deg: location.contact_angles.iter().map(|a| a.to_degrees()).collect(),
            active: location.active.iter().map(|active| words(*active).0).collect(),
            front_max: location.front_max,
            front_max_bound: location.front_max_bound,
            front_min: location.front_min,
            rear_min: location.rear_min,
            rear_min_bound: location.rear_min_bound,
            queries: location.queries,
        }
    }
}

fn side_name(side: ContactSide) -> &'static str {
    match side {
        ContactSide::Ahead => "ahead",
        ContactSide::Behind => "behind",
        ContactSide::Either => "either",
    }
}

/// Name of a constraint, and what it means for the shop.
fn words(active: Active) -> (&'static str, &'static str) {
    match active {
        Active::Touch => ("touch", "the cutter touches inside the strip"),
        Active::Middle => ("middle", "the error reaches the tolerance inside the strip"),
        Active::FirstSlope => ("first-slope", "the error would leave the band at the first end"),
        Active::SecondSlope => ("second-slope", "the error would leave the band at the far end"),
        Active::Rear => ("rear", "the rear of the cutter touches: a smaller R would reach farther"),
        Active::Disc => ("disc", "the flat underside touches"),
        Active::Chord => ("chord", "the strip is as wide as the cutter: a larger R would be wider"),
        Active::OffsetRange => ("offset-range", "the range of the offset direction ends here"),
        Active::AxisTurn => ("axis-turn", "the tool axis may not turn farther"),
        Active::GivenLead => ("given-lead", "the lead was given, not found"),
    }
}

fn table(location: &Location, args: &Args) -> String {
    let triple = |x: [f64; 3]| format!("{:.4} {:.4} {:.4}", x[0], x[1], x[2]);
    let degrees: Vec<String> =
        location.contact_angles.iter().map(|a| format!("{:.2}", a.to_degrees())).collect();
    let mut rows = vec![
        (
            "strip width",
            format!("{:.4} mm (chord {:.4})", location.strip_width, location.chord_width),
        ),
        ("tip", format!("{} mm", triple(location.pose.tip.coords.into()))),
        ("tool axis", triple(location.pose.axis.into_inner().into())),
        ("circle centre", format!("{} mm", triple(location.center.coords.into()))),
        (
            "offset",
            format!(
                "{:.4} mm, {:.3} deg from across the feed",
                location.offset,
                location.offset_direction.to_degrees()
            ),
        ),
        ("rotation", format!("{:.3} deg", location.rotation.to_degrees())),
        ("contact arc", side_name(location.side).to_owned()),
        (
            "contacts",
            format!("{} deg along an arc of {:.2}", degrees.join(", "), location.arc.to_degrees()),
        ),
        (
            "strip error",
            format!(
                "{:.6} .. {:.6} mm, never above {:.6}; tolerance {}",
                location.front_min, location.front_max, location.front_max_bound, args.tolerance
            ),
        ),
        (
            "rear clearance",
            format!(
                "{:.6} mm, the whole cutter never below {:.6}",
                location.rear_min, location.rear_min_bound
            ),
        ),
        ("queries", location.queries.to_string()),
    ];
    rows.extend(location.active.iter().map(|active| {
        let (name, meaning) = words(*active);
        ("held back by", format!("{name}: {meaning}"))
    }));
    let mut text = format!("{} at (u, v) = ({}, {})\n", args.method.name(), args.at[0], args.at[1]);
    for (name, value) in rows {
        // Writing to a String does not fail.
        let _ = writeln!(text, "  {name:<16} {value}");
    }
    text
}
