//! Face, point and cutter that the arguments name.

use super::args::PositionArgs;
use crate::check::ToolDescription;
use crate::outcome::Failure;
use crate::part;
use crate::progress::Bars;
use trunnion::cutter::{Cutter, CutterConstruction, CutterSpec};
use trunnion::surface::{FaceIndex, Surface};
use trunnion::types::Interval;

/// Refuses a point beyond the edges of the surface.
///
/// The library continues surfaces beyond their edges, because a tool rolls off there; a point
/// that a user names beyond an edge is a slip.
pub(super) fn require_on_surface(surface: &Surface, at: [f64; 2]) -> Result<(), Failure> {
    let parameters = ["u", "v"].into_iter().zip(at).zip(surface.domain()).zip(surface.periods());
    for (((name, value), range), period) in parameters {
        // A periodic parameter has no edge to cross.
        if period.is_none() && !range.contains(value) {
            let Interval { low, high } = range;
            return Err(Failure::input(format!(
                "--at: {name} = {value} is off the surface, where {name} goes from {low} to {high}"
            )));
        }
    }
    Ok(())
}

/// Reads the face that is machined.
pub(super) fn face(args: &PositionArgs) -> Result<FaceIndex, Failure> {
    let part = part::read(&args.surface, &Bars::new())?;
    for warning in &part.warnings {
        eprintln!("warning: {warning}");
    }
    let count = part.faces.len();
    let wanted = part.faces.into_iter().find(|face| face.number == args.face);
    let Some(mut face) = wanted else {
        let file = args.surface.display();
        let help = format!("trunnion inspect {file} lists them");
        let number = args.face;
        return Err(Failure::input(format!(
            "{file} has {count} faces, none with the number {number}\n  help: {help}"
        )));
    };
    // The part may have flipped the face already.
    face.flip ^= args.flip;
    FaceIndex::new(face).map_err(Failure::input)
}

/// Reads a cutter with a side beside its tip arc: `r=1,taper=5,D=10`, a lens or a barrel.
///
/// The large arc of a barrel is placed, of others the tip arc; the rest of the tool is kept off.
fn with_side(text: &str) -> Result<Cutter, Failure> {
    let tool = ToolDescription { cutter: text, shank: None, holder: None, length: None };
    tool.cutter()
}

/// Reads the cutter: `R=10,r=6`, optionally `L=..` and `inner=..`, or one with a side.
pub(super) fn cutter(args: &PositionArgs) -> Result<Cutter, Failure> {
    if args.cutter.split(',').any(|entry| entry.trim_start().starts_with("D=")) {
        return with_side(&args.cutter);
    }
    let wrong = |what: &str| {
        let help = "for instance --cutter R=10,r=6 or R=10,r=6,L=120,inner=4";
        Failure::input(format!("--cutter {}: {what}\n  help: {help}", args.cutter))
    };
    let (mut major, mut minor, mut length, mut inner) = (None, None, None, None);
    for entry in args.cutter.split(',') {
        let (name, value) = entry.split_once('=').ok_or_else(|| wrong("name=value is expected"))?;
        let value = value.trim().parse::<f64>();
        let value = value.map_err(|_| wrong(&format!("{entry} is not a number")))?;
        let place = match name.trim() {
            "R" => &mut major,
            "r" => &mut minor,
            "L" => &mut length,
            "inner" => &mut inner,
            other => return Err(wrong(&format!("{other} is not one of R, r, L, inner"))),
        };
        *place = Some(value);
    }
    let (Some(major), Some(minor)) = (major, minor) else {
        return Err(wrong("both R and r are needed"));
    };
    // By default, the part of the tool that must be clear is as high as the cutter is wide.
    let length = length.unwrap_or(2.0 * (major + minor));
    let construction = inner.map_or(CutterConstruction::Solid, |inner_cutting_radius| {
        CutterConstruction::Insert { inner_cutting_radius }
    });
    Cutter::new(CutterSpec { length, construction, ..CutterSpec::of_radii(major, minor) })
        .map_err(|faults| Failure::Input(faults.iter().map(ToString::to_string).collect()))
}
