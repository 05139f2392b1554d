//! Stock and fixtures as arguments, read from words.

use super::setting::Named;
use super::tool::finite;
use crate::material;
use crate::outcome::Failure;
use nalgebra::Point3;
use std::path::Path;
use trunnion::pipeline::MOST_RAYS;
use trunnion::verify::{Solid, Stock};

/// Whether a solid is named that is read from a STEP file.
pub(super) fn is_step(said: &str) -> bool {
    !said.starts_with("box:") && material::is_step(Path::new(said))
}

/// `box:x,y,z,X,Y,Z`, `cyl:x,y,z,radius,height`, or an STL or STEP file; of this the triangles are within about
/// `chord` \[mm\] of its faces.
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
    let path = Path::new(said);
    if is_step(said) || material::is_stl(path) {
        return Ok(Solid::Mesh(material::mesh(path, chord)?));
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
