//! Stock and fixtures as arguments, and STL files.

use super::tool::finite;
use crate::outcome::Failure;
use crate::text;
use nalgebra::{Point3, Vector3};
use std::io::{Result as IoResult, Write};
use std::path::Path;
use trunnion::files;
use trunnion::import::stl;
use trunnion::types::Mesh;
use trunnion::verify::{Solid, Stock};

/// Rays of one stock at most: some gigabytes.
const MOST_RAYS: usize = 30_000_000;
/// Rays along the longest side where nothing is said.
const USUAL_RAYS: f64 = 400.0;

/// `box:x,y,z,X,Y,Z`, `cyl:x,y,z,radius,height`, or an STL file.
pub(super) fn read(said: &str) -> Result<Solid, Failure> {
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
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("stl")) {
        let bytes = text::read_bytes(path)?;
        let mesh = stl::read(&bytes).map_err(|what| Failure::input(format!("{said}: {what}")))?;
        return Ok(Solid::Mesh(mesh));
    }
    let help = "write box:x,y,z,X,Y,Z or cyl:x,y,z,radius,height, or name a closed .stl file (export a STEP solid as STL)";
    Err(Failure::input(format!("{said}: neither box:, cyl: nor an STL file\n  help: {help}")))
}

/// The stock of a job; what stands on the part alone is not a solid that could be cut here.
pub(super) fn of_job(stock: &files::job::Stock) -> Option<Solid> {
    match *stock {
        files::job::Stock::Box { min, max } => {
            Some(Solid::Box { low: Point3::from(min), high: Point3::from(max) })
        }
        files::job::Stock::Cylinder { base, radius, height } => {
            Some(Solid::Cylinder { base: Point3::from(base), radius, height })
        }
        files::job::Stock::Offset { .. } => None,
    }
}

/// Rays through a solid.
pub(super) fn rays(said: &str, solid: &Solid, cell: Option<f64>) -> Result<Stock, Failure> {
    let usual = || {
        let size = solid.bounds().map_or(1.0, |[low, high]| (high - low).amax());
        size / USUAL_RAYS
    };
    Stock::new(solid, cell.unwrap_or_else(usual), MOST_RAYS)
        .map_err(|error| Failure::input(format!("{said}: {error}")))
}

/// Writes a mesh as binary STL.
pub(super) fn write(out: &mut dyn Write, mesh: &Mesh) -> IoResult<()> {
    let mut header = [b' '; 80];
    for (to, from) in header.iter_mut().zip(b"trunnion: stock left") {
        *to = *from;
    }
    out.write_all(&header)?;
    let count = u32::try_from(mesh.triangles.len()).map_err(std::io::Error::other)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &mesh.triangles {
        let at = |corner: u32| mesh.vertices.get(corner as usize).copied().unwrap_or_default();
        let [a, b, c] = triangle.map(at);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        let vectors: [Vector3<f64>; 4] = [normal, a.coords, b.coords, c.coords];
        for value in vectors.iter().flat_map(|vector| vector.iter()) {
            #[expect(clippy::cast_possible_truncation, reason = "STL has single precision")]
            out.write_all(&(*value as f32).to_le_bytes())?;
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stl_is_read_as_it_is_written() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 1.5]];
        let mesh =
            Mesh { vertices: corners.map(Point3::from).to_vec(), triangles: vec![[0, 1, 2]] };
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh).unwrap();
        assert_eq!(stl::read(&bytes), Ok(mesh));
    }

    #[test]
    fn a_solid_is_said_in_words() {
        let said = |text: &str| read(text).ok();
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
