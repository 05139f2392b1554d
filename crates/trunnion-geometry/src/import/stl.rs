//! STL, binary and text: triangles of stock and fixtures. The format has no units; mm are taken.

use super::error::ImportError;
use super::format::{looks_like, without_mark};
use crate::types::Mesh;
use nalgebra::Point3;

/// Bytes before the first triangle of a binary file, and bytes of a triangle.
const HEADER: usize = 84;
const RECORD: usize = 50;

/// Reads the triangles of an STL file, with corners as written there \[mm\]; normals are not read.
///
/// # Example
///
/// ```
/// use trunnion_geometry::import::stl;
///
/// let text = "solid a\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 1\nendsolid a\n";
/// assert_eq!(stl::read(text.as_bytes())?.triangles, [[0, 1, 2]]);
/// # Ok::<(), trunnion_geometry::import::ImportError>(())
/// ```
///
/// # Errors
///
/// [`ImportError::WrongFormat`], or [`ImportError::Syntax`] for triangles that cannot be read; in a
/// binary file the line is 1 and the column the byte.
pub fn read(bytes: &[u8]) -> Result<Mesh, ImportError> {
    let count = bytes.get(80..HEADER).and_then(|four| four.try_into().ok()).map(u32::from_le_bytes);
    let size = |count: u32| HEADER as u64 + RECORD as u64 * u64::from(count);
    // The length first: a binary file may begin with `solid`, too.
    let corners = if count.is_some_and(|count| bytes.len() as u64 == size(count)) {
        binary(bytes)?
    } else if without_mark(bytes).trim_ascii_start().starts_with(b"solid") {
        text(bytes)?
    } else {
        return Err(ImportError::WrongFormat { expected: "STL", found: looks_like(bytes) });
    };
    let numbers = (0u32..).step_by(3).take(corners.len() / 3);
    let triangles = numbers.map(|first| [first, first + 1, first + 2]).collect();
    Ok(Mesh { vertices: corners, triangles })
}

fn binary(bytes: &[u8]) -> Result<Vec<Point3<f64>>, ImportError> {
    let records = bytes.get(HEADER..).unwrap_or_default().chunks_exact(RECORD);
    let mut corners = Vec::with_capacity(3 * records.len());
    for (index, record) in records.enumerate() {
        // Three floats of normal are passed over; 9 of corners follow, then 2 bytes of attributes.
        let number = |four: &[u8]| {
            four.try_into().map_or(f64::NAN, |four: [u8; 4]| f64::from(f32::from_le_bytes(four)))
        };
        let values: Vec<f64> =
            record.get(12..48).unwrap_or_default().chunks_exact(4).map(number).collect();
        if !values.iter().all(|value| value.is_finite()) {
            let message = format!("triangle {} has a corner that is not finite", index + 1);
            return Err(ImportError::Syntax {
                line: 1,
                column: HEADER + RECORD * index + 1,
                message,
            });
        }
        corners.extend(values.chunks_exact(3).map(Point3::from_slice));
    }
    Ok(corners)
}

fn text(bytes: &[u8]) -> Result<Vec<Point3<f64>>, ImportError> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners = Vec::new();
    let mut last = 1;
    for (line, content) in (1..).zip(text.lines()) {
        last = line;
        let mut words = content.split_whitespace();
        // `facet`, `outer loop` and their ends only enclose the vertices, three for every triangle.
        if words.next() != Some("vertex") {
            continue;
        }
        let values: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        match values[..] {
            [x, y, z] if values.iter().all(|value| value.is_finite()) => {
                corners.push(Point3::new(x, y, z));
            }
            _ => {
                let message = "a vertex is three finite numbers".to_owned();
                return Err(ImportError::Syntax { line, column: 1, message });
            }
        }
    }
    if corners.is_empty() || corners.len() % 3 != 0 {
        let message = format!("{} vertices make no triangles", corners.len());
        return Err(ImportError::Syntax { line: last, column: 1, message });
    }
    Ok(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary_and_text_give_the_same_triangle() {
        let places = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 1.5f32]];
        let mut bytes = vec![b' '; 80];
        bytes.extend(1u32.to_le_bytes());
        bytes.extend([0; 12]);
        bytes.extend(places.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
        let mesh = read(&bytes).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.vertices, places.map(|place| Point3::from(place.map(f64::from))));
        let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\n vertex 0 3 1.5\nendloop\nendfacet\nendsolid x\n";
        assert_eq!(read(text.as_bytes()), Ok(mesh));
        bytes[HEADER + 12..HEADER + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(read(&bytes).unwrap_err().to_string().contains("column 85"));
    }

    #[test]
    fn what_is_no_stl_is_reported_with_its_place() {
        let reported = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(reported(b"solid x\nvertex 1 2\n").starts_with("line 2"));
        assert!(reported(b"solid x\nvertex 1 2 3\nvertex 1 2 3\n").contains("2 vertices"));
        assert!(reported(b"PK").contains("not a STL file"));
    }
}
