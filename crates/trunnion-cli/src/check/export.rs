//! Deviations as a VTK file.

use std::io::{Result, Write};
use trunnion::verify::{FaceMap, HeightSample};

/// Writes the measured points of all faces as triangles with their heights (VTK `PolyData`, XML, ASCII):
/// `height` in mm, not a number where nothing was cut; `line` of the program that cut last there.
pub(super) fn vtp(out: &mut dyn Write, maps: &[FaceMap]) -> Result<()> {
    // Every array of the file is one pass over the samples, in the same order.
    let samples = || maps.iter().flat_map(|map| map.samples.iter().flatten());
    let triangles = triangles(maps);
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(out, "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">")?;
    writeln!(out, "<PolyData>")?;
    let (points, count) = (samples().count(), triangles.len());
    writeln!(out, "<Piece NumberOfPoints=\"{points}\" NumberOfPolys=\"{count}\">")?;
    writeln!(out, "<PointData Scalars=\"height\">")?;
    array(out, "Float32", "height", samples().map(|s| number(s.height)))?;
    array(out, "UInt32", "line", samples().map(|s| s.line.unwrap_or(0).to_string()))?;
    array(out, "UInt8", "rest", samples().map(|s| u8::from(s.rest).to_string()))?;
    writeln!(out, "</PointData>\n<Points>")?;
    writeln!(out, "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">")?;
    for HeightSample { point: p, .. } in samples() {
        writeln!(out, "{:.6} {:.6} {:.6}", p.x, p.y, p.z)?;
    }
    writeln!(out, "</DataArray>\n</Points>\n<Polys>")?;
    let corners = triangles.iter().map(|[a, b, c]| format!("{a} {b} {c}"));
    array(out, "UInt32", "connectivity", corners)?;
    // An offset is the end of a polygon in the list of corners.
    array(out, "UInt32", "offsets", (1..=triangles.len()).map(|k| (3 * k).to_string()))?;
    writeln!(out, "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>")
}

/// Writes a height; nothing was cut where there is none.
fn number(height: Option<f64>) -> String {
    height.map_or_else(|| "nan".to_owned(), |height| format!("{height:.7}"))
}

fn array(
    out: &mut dyn Write,
    kind: &str,
    name: &str,
    values: impl Iterator<Item = String>,
) -> Result<()> {
    writeln!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">")?;
    for value in values {
        writeln!(out, "{value}")?;
    }
    writeln!(out, "</DataArray>")
}

/// Corners of the triangles of all maps, counting the points that were measured.
fn triangles(maps: &[FaceMap]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut next = 0;
    for map in maps {
        // Points off the face are not written: the numbers of the others close up.
        let mut number = || {
            next += 1;
            next - 1
        };
        let index: Vec<Option<usize>> =
            map.samples.iter().map(|sample| sample.as_ref().map(|_| number())).collect();
        let rows: Vec<&[Option<usize>]> = index.chunks_exact(map.v.len().max(1)).collect();
        for pair in rows.windows(2) {
            let &[low, high] = pair else { continue };
            for (a, b) in low.windows(2).zip(high.windows(2)) {
                let (&[a0, a1], &[b0, b1]) = (a, b) else { continue };
                // Both triangles of a cell share its diagonal; one with a missing corner is left out.
                triangles.extend(triangle([a0, a1, b1]));
                triangles.extend(triangle([a0, b1, b0]));
            }
        }
    }
    triangles
}

fn triangle([a, b, c]: [Option<usize>; 3]) -> Option<[usize; 3]> {
    Some([a?, b?, c?])
}
