//! Picture of the solids, seen from the front, the right and above, as a PNG inside the page.

use crate::data::Solid;
use crate::payload::base64;

/// Size of the picture \[pixels\].
const WIDTH: usize = 640;
const HEIGHT: usize = 420;
/// Margin \[pixels\].
const MARGIN: f64 = 6.0;
/// Directions to the right, up, and towards the eye in an isometric view.
const RIGHT: [f64; 3] = [0.707_106_781_186_547_5, 0.707_106_781_186_547_5, 0.0];
const UP: [f64; 3] = [-0.408_248_290_463_863, 0.408_248_290_463_863, 0.816_496_580_927_726];
const EYE: [f64; 3] = [0.577_350_269_189_625_8, -0.577_350_269_189_625_8, 0.577_350_269_189_625_8];
/// Direction towards the light.
const LIGHT: [f64; 3] = [-0.2, -0.45, 0.87];
/// Share of the light that reaches every face.
const AMBIENT: f64 = 0.3;
/// Lightest colours of the workpiece and of the fixtures.
const COLOURS: [[f64; 3]; 2] = [[196.0, 208.0, 222.0], [240.0, 160.0, 70.0]];
/// Number of shades of one colour.
const SHADES: u8 = 127;

/// Returns a data URI of the picture of workpiece and fixtures; `None` without triangles.
pub(crate) fn of(solids: [&Solid; 2]) -> Option<String> {
    let pixels = draw(solids)?;
    Some(format!("data:image/png;base64,{}", base64(&png(&pixels))))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a shade for every pixel, row by row from the top. 0 is nothing; the shades of the second solid follow those
/// of the first.
fn draw(solids: [&Solid; 2]) -> Option<Vec<u8>> {
    let seen = |p: &[f64; 3]| [dot(p, &RIGHT), dot(p, &UP), dot(p, &EYE)];
    let corners = |solid: &Solid, triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| solid.vertices.get(corner as usize).copied());
        Some([a?, b?, c?])
    };
    let used = || {
        let all = solids.iter().flat_map(|solid| solid.triangles.iter().map(move |of| (solid, of)));
        all.filter_map(|(solid, triangle)| corners(solid, triangle)).flatten().map(|p| seen(&p))
    };
    let range = |axis: usize| {
        used().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p[axis]), high.max(p[axis])]
        })
    };
    let [[left, right], [bottom, top]] = [range(0), range(1)];
    if !(left < right && bottom < top) {
        return None;
    }
    // One scale for both directions keeps right angles; the tighter side decides.
    let scale = ((WIDTH as f64 - 2.0 * MARGIN) / (right - left))
        .min((HEIGHT as f64 - 2.0 * MARGIN) / (top - bottom));
    let [across, down] = [left + right, top + bottom].map(|sum| 0.5 * sum);
    let place = |[x, y, depth]: [f64; 3]| {
        [0.5 * WIDTH as f64 + scale * (x - across), 0.5 * HEIGHT as f64 - scale * (y - down), depth]
    };
    let mut canvas = Canvas::new();
    for (solid, first) in solids.iter().zip([0, SHADES]) {
        for triangle in &solid.triangles {
            let Some([a, b, c]) = corners(solid, triangle) else { continue };
            let side = |to: [f64; 3]| [to[0] - a[0], to[1] - a[1], to[2] - a[2]];
            let shade = first + shade(cross(side(b), side(c)));
            canvas.fill([a, b, c].map(|p| place(seen(&p))), shade);
        }
    }
    Some(canvas.shades)
}

/// Returns the shade of a face, from 1 to [`SHADES`], by the light on it. The orientation of its triangle does not
/// matter: a visible face always faces the eye.
fn shade(normal: [f64; 3]) -> u8 {
    let length = dot(&normal, &normal).sqrt();
    if length <= 0.0 {
        return 1;
    }
    // signum turns the normal to the eye, the length makes it a unit vector.
    let facing = dot(&normal, &EYE).signum() / length;
    let light = (facing * dot(&normal, &LIGHT)).max(0.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates"
    )]
    let shade = (f64::from(SHADES) * (AMBIENT + (1.0 - AMBIENT) * light)).round() as u8;
    shade.clamp(1, SHADES)
}

/// Shades with their depths (z-buffer).
struct Canvas {
    shades: Vec<u8>,
    depth: Vec<f64>,
}

impl Canvas {
    fn new() -> Self {
        let size = WIDTH * HEIGHT;
        Self { shades: vec![0; size], depth: vec![f64::NEG_INFINITY; size] }
    }

    /// Fills a triangle where it is nearest to the eye.
    fn fill(&mut self, [a, b, c]: [[f64; 3]; 3], shade: u8) {
        // Twice the signed area; the weights below are areas over it (barycentric coordinates).
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice.abs() <= 0.0 {
            return;
        }
        let [columns, rows] = [(0, WIDTH), (1, HEIGHT)].map(|(axis, size): (usize, usize)| {
            let all = [a[axis], b[axis], c[axis]];
            let low = all.iter().copied().fold(f64::INFINITY, f64::min);
            let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            pixel(low - 0.5, size)..=pixel(high + 0.5, size)
        });
        for row in rows {
            for column in columns.clone() {
                let [x, y] = [column, row].map(|k| k as f64 + 0.5);
                let weight = |p: [f64; 3], q: [f64; 3]| {
                    ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / twice
                };
                let [u, v, w] = [weight(b, c), weight(c, a), weight(a, b)];
                // Outside of one edge at least.
                if u.min(v).min(w) < 0.0 {
                    continue;
                }
                let depth = u * a[2] + v * b[2] + w * c[2];
                let at = row * WIDTH + column;
                if let (Some(nearest), Some(pixel)) =
                    (self.depth.get_mut(at), self.shades.get_mut(at))
                    && depth > *nearest
                {
                    (*nearest, *pixel) = (depth, shade);
                }
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn pixel(place: f64, size: usize) -> usize {
    (place.max(0.0) as usize).min(size - 1)
}

/// Encodes shades as PNG with a palette, 0 transparent (W3C, *Portable Network Graphics*, 2nd edition).
fn png(shades: &[u8]) -> Vec<u8> {
    let [width, height] = [WIDTH, HEIGHT].map(|size| u32::try_from(size).unwrap_or(u32::MAX));
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    // 8 bits a pixel, palette, deflate, standard filters, not interlaced.
    header.extend([8, 3, 0, 0, 0]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
    let level = |(colour, shade): ([f64; 3], u8)| {
        colour.map(|most| (most * f64::from(shade) / f64::from(SHADES)) as u8)
    };
    let shaded = COLOURS.into_iter().flat_map(|colour| (1..=SHADES).map(move |k| (colour, k)));
    let palette: Vec<u8> = std::iter::once([0; 3]).chain(shaded.map(level)).flatten().collect();
    // Every row starts with its filter: none.
    let rows: Vec<u8> = shades.chunks(WIDTH).flat_map(|row| [&[0], row].concat()).collect();
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, *b"IHDR", &header);
    chunk(&mut file, *b"PLTE", &palette);
    chunk(&mut file, *b"tRNS", &[0]);
    chunk(&mut file, *b"IDAT", &stored(&rows));
    chunk(&mut file, *b"IEND", &[]);
    file
}

fn chunk(file: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    let named = [&name, data].concat();
    file.extend(u32::try_from(data.len()).unwrap_or(u32::MAX).to_be_bytes());
    file.extend(&named);
    file.extend(crc(&named).to_be_bytes());
}

/// Returns the CRC-32 of ISO 3309, computed bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 }
        })
    })
}

/// Returns a zlib stream without compression (RFC 1950, 1951).
fn stored(bytes: &[u8]) -> Vec<u8> {
    // Deflate with a 32 KiB window; the second byte makes the header divisible by 31.
    let mut stream = vec![0x78, 0x01];
    let mut blocks = bytes.chunks(usize::from(u16::MAX)).peekable();
    while let Some(block) = blocks.next() {
        let length = u16::try_from(block.len()).unwrap_or(u16::MAX);
        // Stored block: final flag, length and its complement.
        stream.push(u8::from(blocks.peek().is_none()));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    // Adler-32 of the uncompressed bytes.
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (a + b) % 65_521)
    });
    stream.extend(((b << 16) | a).to_be_bytes());
    stream
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_standards() {
        assert_eq!(crc(b"123456789"), 0xCBF4_3926);
        // "Wikipedia" has the Adler sum 11E60398.
        let stream = stored(b"Wikipedia");
        assert_eq!(stream[stream.len() - 4..], [0x11, 0xE6, 0x03, 0x98]);
        assert_eq!(stream[2..7], [1, 9, 0, 0xF6, 0xFF]);
    }

    /// Of a cube, three faces are seen, each in its own shade, the top the lightest, and nothing round them.
    #[test]
    fn a_cube_shows_three_faces() {
        let corner = |k: u32| [0, 1, 2].map(|bit| f64::from((k >> bit) & 1));
        let squares =
            [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles = squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let solid =
            Solid { vertices: (0..8).map(corner).collect(), triangles: triangles.collect() };
        let nothing = Solid::default();
        let shades = draw([&solid, &nothing]).unwrap();
        let at = |x: usize, y: usize| shades[y * WIDTH + x];
        let [top, front, right] = [(320, 120), (240, 260), (400, 260)].map(|(x, y)| at(x, y));
        assert!(top > front && front > right && right > 0, "{top} {front} {right}");
        assert_eq!(at(10, 10), 0);
        assert_eq!(draw([&nothing; 2]), None);
        // What holds it has the same shades in another colour, and hides what is behind it.
        let held = draw([&nothing, &solid]).unwrap();
        let as_held = |shade: &u8| if *shade > 0 { shade + SHADES } else { 0 };
        assert_eq!(held, shades.iter().map(as_held).collect::<Vec<_>>());
        let nearer = solid.vertices.iter().map(|[x, y, z]| [x + 0.5, y - 0.5, z + 0.5]).collect();
        let nearer = Solid { vertices: nearer, ..solid.clone() };
        let both = draw([&solid, &nearer]).unwrap();
        assert!(both.iter().all(|shade| *shade == 0 || *shade > SHADES));
    }
}
