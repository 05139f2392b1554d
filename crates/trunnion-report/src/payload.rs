//! Input of the page's script: JSON, with large arrays as base64 of little-endian numbers.

use crate::data::{
    Axis, AxisBands, Band, Budget, Check, Motion, MotionKind, PathPiece, ReportData,
};
use crate::data::{PathPoint, Solid, Surface};
use crate::thin::{thinned_path, thinned_surface};
use serde::Serialize;

/// Most vertices of the surface in a page: about one for each pixel, and 5 MB.
const VERTICES: usize = 100_000;
/// Most triangles of fixtures in a page: about 2 MB.
const TRIANGLES: usize = 60_000;
/// Most points of the path in a page: about 3 MB.
const POINTS: usize = 60_000;

/// Input of the script.
#[derive(Debug, Serialize)]
pub(crate) struct Payload<'a> {
    job: &'a str,
    budget: &'a Budget,
    tools: &'a [Vec<[f64; 2]>],
    surface: PackedSurface,
    path: PackedPath,
    /// Fixtures; `None` without any, or if they are too large for a page. The still picture shows them in any case.
    fixtures: Option<PackedSolid>,
    motion: PackedMotion<'a>,
    check: &'a Check,
}

/// Positions as 16-bit fractions of the box, deviations as 16-bit multiples of `step`.
#[derive(Debug, Serialize)]
struct PackedSurface {
    low: [f64; 3],
    high: [f64; 3],
    positions: String,
    step: f64,
    /// `i16`; the least value stands for "nothing was cut". Empty if nothing was measured.
    deviation: String,
    /// `u32`.
    triangles: String,
    /// Vertices before thinning.
    measured: usize,
}

#[derive(Debug, Serialize)]
struct PackedPath {
    kinds: Vec<MotionKind>,
    counts: Vec<usize>,
    tools: Vec<usize>,
    /// True if contacts are known.
    contacts: bool,
    /// `f32`: t, tip, axis and contact of every point, ten numbers each.
    points: String,
}

#[derive(Debug, Serialize)]
struct PackedSolid {
    /// `f32`.
    positions: String,
    /// `u32`.
    triangles: String,
}

#[derive(Debug, Serialize)]
struct PackedMotion<'a> {
    duration: f64,
    axes: &'a [Axis],
    slots: usize,
    feed: f64,
    bands: Vec<PackedAxis>,
    speed: PackedBand,
    tip: PackedBand,
    binding: String,
}

#[derive(Debug, Serialize)]
struct PackedAxis {
    position: PackedBand,
    velocity: PackedBand,
    acceleration: PackedBand,
    jerk: PackedBand,
}

/// `f32` arrays.
#[derive(Debug, Serialize)]
struct PackedBand {
    min: String,
    max: String,
}

impl<'a> Payload<'a> {
    pub(crate) fn new(data: &'a ReportData) -> Self {
        Self {
            job: &data.job,
            budget: &data.budget,
            tools: &data.tools,
            surface: surface(&data.surface, &data.budget),
            path: path(&thinned_path(&data.path, POINTS)),
            fixtures: data.fixtures.as_ref().and_then(solid),
            motion: motion(&data.motion),
            check: &data.check,
        }
    }

    /// Returns JSON that is safe inside a `script` element.
    pub(crate) fn to_json(&self) -> Result<String, serde_json::Error> {
        // `<` occurs in strings only, where the escape means the same; so no element can end early.
        Ok(serde_json::to_string(self)?
            .replace('<', "\\u003c")
            .replace('\u{2028}', "\\u2028")
            .replace('\u{2029}', "\\u2029"))
    }
}

fn surface(full: &Surface, budget: &Budget) -> PackedSurface {
    let thin = thinned_surface(full, budget, VERTICES);
    let [low, high] = bounds(&thin.vertices);
    let mut positions = Vec::with_capacity(6 * thin.vertices.len());
    for vertex in &thin.vertices {
        for ((value, low), high) in vertex.iter().zip(low).zip(high) {
            // 65,535 steps of a box of 100 mm are 1.5 µm each: below a pixel.
            let share = (value - low) / (high - low).max(f64::MIN_POSITIVE);
            positions.extend(quantised(share * f64::from(u16::MAX), 0.0, u16::MAX).to_le_bytes());
        }
    }
    let largest = thin.deviation.iter().flatten().fold(0.0_f64, |most, d| most.max(d.abs()));
    // The largest deviation uses the whole range, so that small ones keep their digits.
    let step = (largest / f64::from(i16::MAX)).max(f64::MIN_POSITIVE);
    let deviation = thin.deviation.iter().flat_map(|deviation| {
        let packed = deviation.map_or(i16::MIN, |deviation| {
            // The offset keeps the cast unsigned; the least value stays free for "nothing was cut".
            let offset = f64::from(i16::MAX);
            let shifted = quantised(deviation / step + offset, 0.0, 2 * i16::MAX.unsigned_abs());
            i16::try_from(i32::from(shifted) - i32::from(i16::MAX)).unwrap_or(i16::MAX)
        });
        packed.to_le_bytes()
    });
    PackedSurface {
        low,
        high,
        positions: base64(&positions),
        step,
        deviation: base64(&deviation.collect::<Vec<u8>>()),
        triangles: base64(
            &thin.triangles.iter().flatten().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>(),
        ),
        measured: full.vertices.len(),
    }
}

/// Rounds to the nearest whole number in `[least, most]`; NaN becomes `least`.
fn quantised(value: f64, least: f64, most: u16) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of the type"
    )]
    let whole = value.round().max(least).min(f64::from(most)) as u16;
    whole
}

fn bounds(vertices: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let Some(&first) = vertices.first() else { return [[0.0; 3]; 2] };
    vertices.iter().fold([first; 2], |[mut low, mut high], vertex| {
        for ((low, high), value) in low.iter_mut().zip(&mut high).zip(vertex) {
            *low = low.min(*value);
            *high = high.max(*value);
        }
        [low, high]
    })
}

fn path(pieces: &[PathPiece]) -> PackedPath {
    let points = pieces.iter().flat_map(|piece| &piece.points).flat_map(|point| {
        let PathPoint { t, tip, axis, contact } = point;
        std::iter::once(*t).chain(*tip).chain(*axis).chain(*contact).collect::<Vec<f64>>()
    });
    // An unknown contact is stored as the tip.
    let off = |PathPoint { tip, contact, .. }: &PathPoint| {
        tip.iter().zip(contact).any(|(a, b)| (a - b).abs() > 0.0)
    };
    PackedPath {
        kinds: pieces.iter().map(|piece| piece.motion).collect(),
        counts: pieces.iter().map(|piece| piece.points.len()).collect(),
        tools: pieces.iter().map(|piece| piece.tool).collect(),
        contacts: pieces.iter().flat_map(|piece| &piece.points).any(off),
        points: floats(points),
    }
}

fn solid(solid: &Solid) -> Option<PackedSolid> {
    if solid.triangles.len() > TRIANGLES {
        return None;
    }
    let corners = solid.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes());
    Some(PackedSolid {
        positions: floats(solid.vertices.iter().flatten().copied()),
        triangles: base64(&corners.collect::<Vec<u8>>()),
    })
}

fn motion(motion: &Motion) -> PackedMotion<'_> {
    let Motion { duration, axes, bands, speed, tip, feed, binding } = motion;
    PackedMotion {
        duration: *duration,
        axes,
        slots: binding.len(),
        feed: *feed,
        bands: bands.iter().map(axis_bands).collect(),
        speed: band(speed),
        tip: band(tip),
        binding: base64(binding),
    }
}

fn axis_bands(bands: &AxisBands) -> PackedAxis {
    let AxisBands { position, velocity, acceleration, jerk } = bands;
    PackedAxis {
        position: band(position),
        velocity: band(velocity),
        acceleration: band(acceleration),
        jerk: band(jerk),
    }
}

fn band(band: &Band) -> PackedBand {
    let pack = |values: &[f64]| floats(values.iter().copied());
    PackedBand { min: pack(&band.min), max: pack(&band.max) }
}

fn floats(values: impl Iterator<Item = f64>) -> String {
    // Which zero is the lesser is the processor's choice: + 0.0 makes both the same one.
    #[expect(clippy::cast_possible_truncation, reason = "for a picture")]
    let bytes: Vec<u8> = values.flat_map(|value| (value as f32 + 0.0).to_le_bytes()).collect();
    base64(&bytes)
}

/// Base64 with padding (RFC 4648, section 4).
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |at: usize| u32::from(chunk.get(at).copied().unwrap_or(0));
        // Three bytes are four letters of six bits each.
        let group = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let letter = LETTERS[(group >> (18 - 6 * place) & 63) as usize];
            // n bytes fill n + 1 letters; the rest is padding.
            text.push(if place > chunk.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of RFC 4648, section 10.
    #[test]
    fn base64_of_the_standard() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn deviations_survive_packing_to_a_step() {
        let full = Surface {
            vertices: vec![[0.0; 3], [1.0, 2.0, 3.0], [1.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            deviation: vec![Some(-0.03), None, Some(0.015)],
        };
        let packed = surface(&full, &Budget::default());
        assert_eq!(packed.deviation, base64(&[0x01, 0x80, 0x00, 0x80, 0x00, 0x40]));
        assert!((packed.step * 32767.0 - 0.03).abs() < 1e-15);
    }
}
