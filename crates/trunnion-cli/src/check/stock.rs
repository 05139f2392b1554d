//! Stock and fixtures as arguments, read from words.

use super::setting::Named;
use super::tool::finite;
use crate::material;
use crate::outcome::Failure;
use crate::run::both;
use nalgebra::{Isometry3, Point3};
use std::path::Path;
use trunnion::files::job::placement;
use trunnion::pipeline::MOST_RAYS;
use trunnion::verify::{Solid, Stock};

/// Whether a solid is named that is read from a STEP file.
pub(super) fn is_step(said: &str) -> bool {
    !said.starts_with("box:") && material::is_step(Path::new(file(said).0))
}

/// A file, and what stands behind it: where it is placed.
fn file(said: &str) -> (&str, Option<&str>) {
    let is_solid =
        |name: &str| material::is_step(Path::new(name)) || material::is_stl(Path::new(name));
    match said.rsplit_once('@') {
        Some((name, place)) if is_solid(name) => (name, Some(place)),
        _ => (said, None),
    }
}

/// `x,y,z` in mm, or these and three angles in degrees: the part's coordinates from those of the file.
fn place(said: &str, text: &str) -> Result<Isometry3<f64>, Failure> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(placement([x, y, z], [0.0; 3])),
        Ok(&[x, y, z, a, b, c]) => Ok(placement([x, y, z], [a, b, c].map(f64::to_radians))),
        _ => Err(Failure::input(format!(
            "{said}: behind @, the place of the file's origin in mm is wanted, and turns about x, then y, then z in degrees \
             if there are any\n  help: for instance vise.step@10,0,-25 or vise.step@10,0,-25,0,0,90"
        ))),
    }
}

/// `box:x,y,z,X,Y,Z`, `cyl:x,y,z,radius,height`, or an STL or STEP file, with or without a place; of the last the
/// triangles are within about `chord` \[mm\] of its faces.
pub(super) fn read(said: &str, chord: f64) -> Result<Solid, Failure> {
    let numbers = |text: &str| -> Result<Vec<f64>, Failure> {
        let all: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
        all.map_err(|error| Failure::input(format!("{said}: {error}")))
    };
    let wrong = |what: &str, example: &str| {
        Failure::input(format!("{said}: {what} are wanted\n  help: for instance {example}"))
    };
    if let Some(text) = said.strip_prefix("box:") {
        return match numbers(text)?[..] {
            [x, y, z, u, v, w] if x < u && y < v && z < w => {
                Ok(Solid::Box { low: Point3::new(x, y, z), high: Point3::new(u, v, w) })
            }
            _ => Err(wrong("lowest and highest corner x,y,z,X,Y,Z", "box:-50,-30,-20,50,30,0")),
        };
    }
    let cylinder = said.strip_prefix("cylinder:").or_else(|| said.strip_prefix("cyl:"));
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
    let (name, at) = file(said);
    let path = Path::new(name);
    if is_step(said) || material::is_stl(path) {
        let (mesh, place) =
            both(material::mesh(path, chord), at.map(|at| place(said, at)).transpose())?;
        return Ok(Solid::Mesh(mesh.moved(&place.unwrap_or_default())));
    }
    let help = "write box:x,y,z,X,Y,Z or cyl:x,y,z,radius,height, or name a closed .stl, .step or .stp file";
    Err(Failure::input(format!(
        "{said}: neither box:, cyl: nor an STL or STEP file\n  help: {help}"
    )))
}

/// Rays through a solid, so far apart as is said. What is wrong is told of the one that says it: of the cell, if the
/// solid is sound with the usual one.
pub(super) fn rays(
    (said, solid): &Named<Solid>,
    cell: Option<&Named<f64>>,
) -> Result<Stock, Failure> {
    let usual = || Stock::new(solid, solid.usual_cell(), MOST_RAYS);
    let Some((cell_said, cell)) = cell else {
        return usual().map_err(|error| Failure::input(format!("{said}: {error}")));
    };
    Stock::new(solid, *cell, MOST_RAYS).map_err(|error| {
        let said = if usual().is_ok() { cell_said } else { said };
        Failure::input(format!("{said}: {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_may_have_a_place_behind_it() {
        assert_eq!(file("a@b.stl"), ("a@b.stl", None));
        assert_eq!(file("a@b.STP@1,2,3"), ("a@b.STP", Some("1,2,3")));
        assert!(is_step("vise.step@0,0,0,0,0,90") && !is_step("vise.stl@1,2,3"));
        let at = |text: &str| {
            place("vise.stl", text).ok().map(|place| place * Point3::new(1.0, 2.0, 3.0))
        };
        assert_eq!(at("-1, 0,2"), Some(Point3::new(0.0, 2.0, 5.0)));
        let turned = at("0,0,10,0,0,90").unwrap();
        assert!((turned - Point3::new(-2.0, 1.0, 13.0)).norm() < 1e-12, "{turned}");
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf"] {
            assert!(at(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn a_solid_is_said_in_words() {
        let said = |text: &str| read(text, 0.01).ok();
        let [low, high] = [Point3::new(-1.0, -2.0, -3.0), Point3::new(1.0, 2.0, 0.5)];
        assert_eq!(said("box:-1,-2,-3,1,2,0.5"), Some(Solid::Box { low, high }));
        let cylinder = Solid::Cylinder { base: low, radius: 4.0, height: 5.0 };
        assert_eq!(said("cyl:-1,-2,-3,4,5"), Some(cylinder.clone()));
        assert_eq!(said("cylinder:-1,-2,-3,4,5"), Some(cylinder));
        for wrong in ["box:1,2,3", "cyl:0,0,0,5", "cyl:0,0,0,-5,3", "box:0,0,0,1,x,1", "part.step"]
        {
            assert_eq!(said(wrong), None, "{wrong}");
        }
    }
}
