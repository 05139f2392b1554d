//! Stock and fixtures as arguments.

use super::named::Named;
use crate::material;
use crate::option_values::list;
use crate::outcome::Failure;
use crate::run::both;
use nalgebra::{Isometry3, Point3};
use std::path::Path;
use trunnion::files::job::placement;
use trunnion::pipeline::MOST_RAYS;
use trunnion::verify::{Solid, Stock};

/// Returns true if the argument names a STEP file.
pub(super) fn is_step(argument: &str) -> bool {
    !argument.starts_with("box:") && material::is_step(Path::new(split_placement(argument).0))
}

/// Splits a file name from the placement behind it.
fn split_placement(argument: &str) -> (&str, Option<&str>) {
    let is_solid =
        |name: &str| material::is_step(Path::new(name)) || material::is_stl(Path::new(name));
    // A file name may itself contain an @: only what stands behind a known ending is a placement.
    match argument.rsplit_once('@') {
        Some((name, placement)) if is_solid(name) => (name, Some(placement)),
        _ => (argument, None),
    }
}

/// Reads a placement, `x,y,z` in mm or these and three angles in degrees, as the transformation from
/// the coordinates of the file to those of the part.
fn read_placement(argument: &str, text: &str) -> Result<Isometry3<f64>, Failure> {
    match list(text).as_deref() {
        Ok(&[x, y, z]) => Ok(placement([x, y, z], [0.0; 3])),
        Ok(&[x, y, z, a, b, c]) => Ok(placement([x, y, z], [a, b, c].map(f64::to_radians))),
        _ => Err(Failure::input(format!(
            "{argument}: after @, write the position of the file's origin in mm, and, if it is turned, three angles \
             about x, then y, then z in degrees\n  help: for instance vise.step@10,0,-25 or vise.step@10,0,-25,0,0,90"
        ))),
    }
}

/// Reads a solid: `box:x,y,z,X,Y,Z`, `cyl:x,y,z,radius,height`, or an STL or STEP file with or without
/// a placement.
///
/// `chord` \[mm\] is the chord tolerance of the triangles of a STEP file.
pub(super) fn read(argument: &str, chord: f64) -> Result<Solid, Failure> {
    let numbers =
        |text: &str| list(text).map_err(|error| Failure::input(format!("{argument}: {error}")));
    let wrong = |what: &str, example: &str| {
        Failure::input(format!("{argument}: {what} expected\n  help: for instance {example}"))
    };
    if let Some(text) = argument.strip_prefix("box:") {
        return match numbers(text)?[..] {
            [x, y, z, u, v, w] if x < u && y < v && z < w => {
                Ok(Solid::Box { low: Point3::new(x, y, z), high: Point3::new(u, v, w) })
            }
            _ => Err(wrong("lowest and highest corner x,y,z,X,Y,Z", "box:-50,-30,-20,50,30,0")),
        };
    }
    let cylinder = argument.strip_prefix("cylinder:").or_else(|| argument.strip_prefix("cyl:"));
    if let Some(text) = cylinder {
        return match numbers(text)?[..] {
            [x, y, z, radius, height] if radius > 0.0 && height > 0.0 => {
                Ok(Solid::Cylinder { base: Point3::new(x, y, z), radius, height })
            }
            _ => Err(wrong(
                "centre of the lower end x,y,z, radius and height above 0",
                "cyl:0,0,-20,40,20",
            )),
        };
    }
    let (name, placement) = split_placement(argument);
    let path = Path::new(name);
    if is_step(argument) || material::is_stl(path) {
        // Both are read before either is refused, so that one run shows every mistake.
        let placement = placement.map(|text| read_placement(argument, text)).transpose();
        let (mesh, placement) = both(material::mesh(path, chord), placement)?;
        return Ok(Solid::Mesh(mesh.moved(&placement.unwrap_or_default())));
    }
    let help = "write box:x,y,z,X,Y,Z or cyl:x,y,z,radius,height, or name a closed .stl, .step or .stp file";
    Err(Failure::input(format!(
        "{argument}: neither box:, cyl: nor an STL or STEP file\n  help: {help}"
    )))
}

/// Casts rays through a solid, at the distance `cell` \[mm\] if it is given.
///
/// An error names the culprit: the distance, if the solid is sound at the default distance.
pub(super) fn rays(solid: &Named<Solid>, cell: Option<&Named<f64>>) -> Result<Stock, Failure> {
    let Named { name, value: solid } = solid;
    let by_default = || Stock::new(solid, solid.usual_cell(), MOST_RAYS);
    let Some(cell) = cell else {
        return by_default().map_err(|error| Failure::input(format!("{name}: {error}")));
    };
    Stock::new(solid, cell.value, MOST_RAYS).map_err(|error| {
        let culprit = if by_default().is_ok() { &cell.name } else { name };
        Failure::input(format!("{culprit}: {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_may_have_a_placement() {
        assert_eq!(split_placement("a@b.stl"), ("a@b.stl", None));
        assert_eq!(split_placement("a@b.STP@1,2,3"), ("a@b.STP", Some("1,2,3")));
        assert!(is_step("vise.step@0,0,0,0,0,90") && !is_step("vise.stl@1,2,3"));
        let at = |text: &str| {
            read_placement("vise.stl", text).ok().map(|moved| moved * Point3::new(1.0, 2.0, 3.0))
        };
        assert_eq!(at("-1, 0,2"), Some(Point3::new(0.0, 2.0, 5.0)));
        let turned = at("0,0,10,0,0,90").unwrap();
        assert!((turned - Point3::new(-2.0, 1.0, 13.0)).norm() < 1e-12, "{turned}");
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf"] {
            assert!(at(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn a_solid_is_read_from_words() {
        let solid = |text: &str| read(text, 0.01).ok();
        let [low, high] = [Point3::new(-1.0, -2.0, -3.0), Point3::new(1.0, 2.0, 0.5)];
        assert_eq!(solid("box:-1,-2,-3,1,2,0.5"), Some(Solid::Box { low, high }));
        let cylinder = Solid::Cylinder { base: low, radius: 4.0, height: 5.0 };
        assert_eq!(solid("cyl:-1,-2,-3,4,5"), Some(cylinder.clone()));
        assert_eq!(solid("cylinder:-1,-2,-3,4,5"), Some(cylinder));
        for wrong in ["box:1,2,3", "cyl:0,0,0,5", "cyl:0,0,0,-5,3", "box:0,0,0,1,x,1", "part.step"]
        {
            assert_eq!(solid(wrong), None, "{wrong}");
        }
    }
}
