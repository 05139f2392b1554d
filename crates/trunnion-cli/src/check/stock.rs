//! Stock and fixtures as arguments, and STL files.

use super::tool::finite;
use crate::outcome::Failure;
use crate::text;
use nalgebra::{Point3, Vector3};
use std::io::{Result as IoResult, Write};
use std::path::Path;
use trunnion::types::Mesh;
use trunnion::verify::{Solid, Stock};

/// Rays of one stock at most: some gigabytes.
const MOST_RAYS: usize = 30_000_000;
/// Rays along the longest side where nothing is said.
const USUAL_RAYS: f64 = 400.0;

/// `box:x,y,z,X,Y,Z`, `cylinder:x,y,z,radius,height`, or a file.
pub(super) fn read(said: &str) -> Result<Solid, Failure> {
    let numbers = |text: &str| -> Result<Vec<f64>, Failure> {
        let all: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
        all.map_err(|error| Failure::input(format!("{said}: {error}")))
    };
    if let Some(text) = said.strip_prefix("box:") {
        return match numbers(text)?[..] {
            [x, y, z, u, v, w] => {
                Ok(Solid::Box { low: Point3::new(x, y, z), high: Point3::new(u, v, w) })
            }
            _ => Err(Failure::input(format!(
                "{said}: lowest and highest corner are wanted, box:x,y,z,X,Y,Z"
            ))),
        };
    }
    if let Some(text) = said.strip_prefix("cylinder:") {
        return match numbers(text)?[..] {
            [x, y, z, radius, height] => {
                Ok(Solid::Cylinder { base: Point3::new(x, y, z), radius, height })
            }
            _ => Err(Failure::input(format!(
                "{said}: centre of the lower end, radius and height are wanted, cylinder:x,y,z,r,h"
            ))),
        };
    }
    let path = Path::new(said);
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("stl")) {
        let bytes = text::read_bytes(path)?;
        let mesh = stl(&bytes).map_err(|what| Failure::input(format!("{said}: {what}")))?;
        return Ok(Solid::Mesh(mesh));
    }
    let help = "export it as STL: faces of a STEP file do not close to a watertight mesh here";
    Err(Failure::input(format!("{said}: neither box:, cylinder: nor an STL file\n  help: {help}")))
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

/// Triangles of an STL file, binary or text.
fn stl(bytes: &[u8]) -> Result<Mesh, String> {
    let count = bytes.get(80..84).and_then(|four| four.try_into().ok()).map(u32::from_le_bytes);
    let triangles = match count {
        Some(count) if bytes.len() as u64 == 84 + 50 * u64::from(count) => binary(bytes),
        _ if bytes.trim_ascii_start().starts_with(b"solid") => written(bytes)?,
        _ => return Err("neither a binary nor a text STL file".to_owned()),
    };
    let mut mesh = Mesh::default();
    for corners in triangles {
        if !corners.iter().flatten().all(|value| value.is_finite()) {
            return Err("a coordinate is no finite number".to_owned());
        }
        let first = u32::try_from(mesh.vertices.len()).map_err(|_| "too many triangles")?;
        mesh.vertices.extend(corners.map(Point3::from));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(mesh)
}

fn binary(bytes: &[u8]) -> Vec<[[f64; 3]; 3]> {
    let number = |bytes: &[u8]| {
        bytes.try_into().map_or(f64::NAN, |four: [u8; 4]| f64::from(f32::from_le_bytes(four)))
    };
    let records = bytes.get(84..).unwrap_or_default().chunks_exact(50);
    records
        .map(|record| {
            let mut values = record.get(12..48).unwrap_or_default().chunks_exact(4).map(number);
            [0; 3].map(|_| [0; 3].map(|_| values.next().unwrap_or(f64::NAN)))
        })
        .collect()
}

fn written(bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if words.next() != Some("vertex") {
            continue;
        }
        let values: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        let [x, y, z] = values[..] else { return Err(format!("line {}: no vertex", index + 1)) };
        corners.push([x, y, z]);
    }
    let whole = corners.chunks_exact(3);
    if !whole.remainder().is_empty() || corners.is_empty() {
        return Err("the number of vertices is no multiple of three, or 0".to_owned());
    }
    Ok(whole.filter_map(|three| three.try_into().ok()).collect())
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
    fn stl_is_read_as_it_is_written_and_as_text() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 1.5]];
        let mesh =
            Mesh { vertices: corners.map(Point3::from).to_vec(), triangles: vec![[0, 1, 2]] };
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh).unwrap();
        assert_eq!(stl(&bytes), Ok(mesh.clone()));
        let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\n vertex 0 3 1.5\nendloop\nendfacet\nendsolid x\n";
        assert_eq!(stl(text.as_bytes()), Ok(mesh));
        assert!(stl(b"solid x\nvertex 1 2\n").is_err() && stl(b"PK").is_err());
    }
}
