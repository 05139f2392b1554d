//! Arguments of `trunnion position`.

use crate::option_values::two;
use nalgebra::Vector3;
use std::path::PathBuf;
use trunnion::positioning::{NestedGrid, PlacementMethod};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PositionArgs {
    /// Surface JSON or STEP file.
    #[arg(long, value_name = "FILE")]
    pub(super) surface: PathBuf,
    /// Number of the face, see `trunnion inspect`.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) face: usize,
    /// Place the cutter on the other side of the face.
    #[arg(long)]
    pub(super) flip: bool,
    /// Radii in mm: R of the centre circle, r of the corner. Optional: L, length of the tool that
    /// must keep clear (default 2 (R + r)); inner, radius inside which inserts do not cut. Tapered r=1,taper=5,D=10 and lens
    /// r=85,corner=1,D=12 are placed by their tip arc, barrels r=2,barrel=85,D=12 by their large one, with --method ball.
    #[arg(long, value_name = "R=10,r=6")]
    pub(super) cutter: String,
    /// Largest error of the strip in mm; gouges are not allowed.
    #[arg(long, value_name = "MM")]
    pub(super) tolerance: f64,
    /// Parameters of the point where the strip begins, as in the knots of the surface.
    #[arg(long, value_name = "U,V", value_parser = two, allow_hyphen_values = true)]
    pub(super) at: [f64; 2],
    /// Feed direction in parameters; its sign matters.
    #[arg(long, value_name = "DU,DV", value_parser = two, allow_hyphen_values = true)]
    pub(super) feed: [f64; 2],
    /// Side of the feed on which the strip lies.
    #[arg(long, default_value = "right")]
    pub(super) strip: Strip,
    /// Position of the contact arc along the feed, seen from the cutter centre; anything but `ahead` needs a
    /// centre-cutting tool.
    #[arg(long, default_value = "ahead")]
    pub(super) side: Side,
    /// Range of the offset direction in degrees, from the strip's side towards the feed.
    #[arg(long, value_name = "LO,HI", value_parser = two, default_value = "-75,75", allow_hyphen_values = true)]
    pub(super) offset_range: [f64; 2],
    /// Method of placing the cutter.
    #[arg(long, default_value = "end-point")]
    pub(super) method: PositionMethod,
    /// Place the cutter by every method, and print the results side by side.
    #[arg(long, conflicts_with = "method")]
    pub(super) compare: bool,
    /// sturz, ball: lead angle in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 5.0, allow_hyphen_values = true)]
    pub(super) lead: f64,
    /// lead-swivel: largest swivel to either side of the feed in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 20.0)]
    pub(super) swivel: f64,
    /// Also draw the error along the cutting circle into this SVG file; with --compare, the strips of
    /// all methods.
    #[arg(short, long, value_name = "SVG")]
    pub(super) output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
The strip begins at the point --at, where the error is the tolerance, and lies to the right of the
feed (seen along it, the normal up); `left` is for the return pass of a zigzag.
  end-point    the widest strip: error within [0, tolerance] on it, no gouge anywhere (default)
  nested       the same by the grid search of the original paper: slow, only as good as its grid
  mpm          two contacts, the error between them at the tolerance (multi-point machining)
  hermite      the same with the contacts assumed at Chebyshev nodes
  ball         a ball as large as the cutter
These touch at --at, and their strip lies around it:
  lead-swivel  one contact with the lead and swivel that give the widest strip
  curvature    inclined until the circle has the curvature of the surface, more if that gouges
  sturz        fixed lead
  three-axis   the tool axis along z
Every pose is checked independently of its method. One that gouges, or touches where the cutter does
not cut, is refused with the reason and a remedy.
Exit codes: 0 found; 1 none exists (with reason and remedy); 2 bad input.

  trunnion position --surface patch.json --cutter R=10,r=6 --tolerance 0.01 --at 0.4,0.5 --feed 0,1
  trunnion position --surface patch.json --cutter R=10,r=6 --tolerance 0.01 --at 0.4,0.5 \\
      --feed 0,1 --compare -o strips.svg
  trunnion position --surface part.step --face 3 --cutter R=8,r=2 --tolerance 0.02 --at 0.5,0.5 \\
      --feed 1,0 --json -o error.svg";

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(super) enum Strip {
    Right,
    Left,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(super) enum Side {
    Ahead,
    Behind,
    Either,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PositionMethod {
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

impl PositionMethod {
    /// All methods in the order of the comparison: first those whose strip begins at the point.
    pub(super) const ALL: [Self; 9] = [
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

    pub(super) fn name(self) -> &'static str {
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

    pub(super) fn placing(self, args: &PositionArgs) -> PlacementMethod {
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

/// Returns the grid of the nested search: at most 3 degrees of arc between samples, the offset to
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
