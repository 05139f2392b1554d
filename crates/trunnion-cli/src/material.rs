//! Stock and fixtures in files, words, numbers and pictures.

use crate::figure::{Prominence, judged, none, plain};
use crate::outcome::Failure;
use crate::part::STEP;
use crate::text;
use nalgebra::Vector3;
use std::io::{Result as IoResult, Write};
use std::path::Path;
use trunnion::files::summary::{ChordSummary, FixturesSummary, StockSummary, UndecidedSummary};
use trunnion::import::stl;
use trunnion::pipeline::{self, Fixtures, Outcome};
use trunnion::types::{Mesh, Silent};
use trunnion::verify;
use trunnion_report::{Number, Solid};

/// Returns true if the file name is that of a STEP file.
pub(crate) fn is_step(path: &Path) -> bool {
    let endings = ["step", "stp"];
    path.extension().is_some_and(|is| endings.iter().any(|name| is.eq_ignore_ascii_case(name)))
}

/// Returns true if the file name is that of an STL file.
pub(crate) fn is_stl(path: &Path) -> bool {
    path.extension().is_some_and(|is| is.eq_ignore_ascii_case("stl"))
}

/// Reads the triangles of an STL file, or of the solids of a STEP file with the chord tolerance `chord` \[mm\].
pub(crate) fn mesh(path: &Path, chord: f64) -> Result<Mesh, Failure> {
    let chord = is_step(path).then_some(chord);
    mesh_of(path, chord).map_err(|what| Failure::input(format!("{}: {what}", path.display())))
}

/// Reads a STEP file if a chord tolerance is given, else an STL file; returns the error without the file name.
pub(crate) fn mesh_of(path: &Path, chord: Option<f64>) -> Result<Mesh, String> {
    let bytes = text::bytes(path)?;
    let mesh = match chord {
        Some(chord) => STEP.mesh(&bytes, chord, &Silent),
        None => stl::read(&bytes),
    };
    mesh.map_err(|what| what.to_string())
}

/// Reads the triangles of a holder; returns the error without the file name.
pub(crate) fn holder_mesh(path: &Path) -> Result<Mesh, String> {
    if is_step(path) {
        return Err("a holder is read from STL: export it with a tolerance of 0.01 mm".to_owned());
    }
    mesh_of(path, None)
}

/// Writes a mesh as binary STL.
pub(crate) fn write(out: &mut dyn Write, mesh: &Mesh) -> IoResult<()> {
    // Binary STL: 80 bytes of header, the count, then 50 bytes a triangle, all little-endian.
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
        // A triangle without area gets the zero normal, which readers compute themselves.
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        let vectors: [Vector3<f64>; 4] = [normal, a.coords, b.coords, c.coords];
        for value in vectors.iter().flat_map(|vector| vector.iter()) {
            #[expect(clippy::cast_possible_truncation, reason = "STL has single precision")]
            out.write_all(&(*value as f32).to_le_bytes())?;
        }
        // No attributes.
        out.write_all(&[0, 0])?;
    }
    Ok(())
}

/// Describes the volumes removed and left, and the number of colliding lines.
pub(crate) fn words(stock: &StockSummary) -> [String; 2] {
    let StockSummary { cell, removed, left, .. } = stock;
    // The rays of x, y and z differ in distance: the coarsest is stated.
    let cell = cell.iter().copied().fold(0.0, f64::max);
    [
        format!("{removed:.1} mm3 removed, {left:.1} mm3 remaining; rays {cell:.3} mm apart"),
        format!("{} lines run into stock or fixtures{}", lines(stock), undecided(stock)),
    ]
}

/// Describes a collision between rays that could not be excluded.
fn undecided(stock: &StockSummary) -> String {
    stock.undecided.as_ref().map_or_else(String::new, |UndecidedSummary { line, depth, .. }| {
        format!("; undecided between rays, at most {depth:.4} mm (line {line}): use smaller cells")
    })
}

/// Describes the chord tolerances of STEP solids, those with the same chord together.
pub(crate) fn chord_words(all: &[ChordSummary]) -> String {
    let mut lines: Vec<(f64, Vec<&str>)> = Vec::new();
    for ChordSummary { solid, chord } in all {
        // Bits are compared: chords come from options and files, not from arithmetic.
        match lines.iter_mut().find(|(known, _)| known.total_cmp(chord).is_eq()) {
            Some((_, solids)) => solids.push(solid),
            None => lines.push((*chord, vec![solid])),
        }
    }
    let of = |(chord, solids): &(f64, Vec<&str>)| format!("{chord} mm of {}", solids.join(", "));
    let lines: Vec<String> = lines.iter().map(of).collect();
    format!("triangles within about {}; fixtures are enlarged by that", lines.join("; "))
}

/// Describes the clearance of a program from fixtures; `label` names the program.
pub(crate) fn clearance_number(fixtures: &FixturesSummary, label: &str) -> Number {
    let least = fixtures.least.as_ref().map_or(0.0, |least| least.distance);
    let note = pipeline::nearest_fixture(fixtures);
    let near = fixtures.near.len();
    judged(none(near), plain(label, format!("{least:.4}"), "mm", note), if_any(near))
}

/// Returns the numbers of the stock after a program.
pub(crate) fn numbers(stock: &StockSummary, name: impl Fn(&str) -> String) -> [Number; 3] {
    let hits = lines(stock);
    let cell = stock.cell.iter().copied().fold(0.0, f64::max);
    let volume = |what: &str, of: f64| {
        plain(&name(what), format!("{of:.1}"), "mm3", format!("rays {cell:.3} mm apart"))
    };
    let note =
        "rapid through the stock, shank or holder in it, or anything in a fixture".to_owned();
    [
        judged(
            none(hits),
            plain(&name("lines in collision"), hits.to_string(), "", note),
            if_any(hits),
        ),
        volume("removed", stock.removed),
        volume("stock left", stock.left),
    ]
}

/// Moves a count of defects to the top of the page as soon as there is one.
fn if_any(count: usize) -> Prominence {
    if count == 0 { Prominence::Body } else { Prominence::Headline }
}

/// Returns the number of colliding lines of all kinds.
fn lines(stock: &StockSummary) -> usize {
    stock.collision_lines.iter().map(|of| of.lines.count).sum()
}

/// Returns the stock that the program with the most collisions leaves.
pub(crate) fn left(outcome: &Outcome) -> Option<&verify::Stock> {
    let carved = outcome.programs.iter().filter_map(|program| program.carving.as_ref());
    // The first of equals, as the last is taken.
    carved.rev().max_by_key(|stock| stock.report.count()).map(|stock| &stock.remaining)
}

/// Returns the surface of the remaining stock for a part with the tolerance `total` \[mm\].
pub(crate) fn surface(stock: &verify::Stock, total: f64) -> Mesh {
    stock.mesh(stock.tolerance(total))
}

/// Returns the remaining stock for the picture.
pub(crate) fn drawn(stock: &verify::Stock, total: f64) -> Solid {
    let mut solid = Solid::default();
    add(&mut solid, &surface(stock, total));
    solid
}

/// Returns the fixtures for the picture.
pub(crate) fn held(fixtures: &Fixtures) -> Solid {
    let mut solid = Solid::default();
    for fixture in fixtures.all() {
        add(&mut solid, fixture.mesh());
    }
    solid
}

fn add(solid: &mut Solid, mesh: &Mesh) {
    // Corners count over all solids of the picture.
    let Ok(first) = u32::try_from(solid.vertices.len()) else { return };
    solid.vertices.extend(mesh.vertices.iter().map(|vertex| <[f64; 3]>::from(vertex.coords)));
    let moved = |triangle: &[u32; 3]| triangle.map(|corner| first.saturating_add(corner));
    solid.triangles.extend(mesh.triangles.iter().map(moved));
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn stl_is_read_as_it_is_written() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 1.5]];
        let mesh =
            Mesh { vertices: corners.map(Point3::from).to_vec(), triangles: vec![[0, 1, 2]] };
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh).unwrap();
        assert_eq!(stl::read(&bytes), Ok(mesh));
    }
}
