//! A picture of the faces with their numbers.

use super::quadrature;
use crate::math;
use crate::surface::Face;
use nalgebra::Point3;
use std::fmt::Write;

/// Width and height of the picture \[px\].
const SIZE: f64 = 800.0;
/// Margin around the part \[px\].
const MARGIN: f64 = 24.0;
/// Chords along one side of a rim.
const CHORDS: f64 = 24.0;

/// One face, projected: right, up, and towards the viewer \[mm\].
struct ProjectedFace {
    number: usize,
    rims: Vec<Vec<[f64; 2]>>,
    label: [f64; 2],
    depth: f64,
}

/// Draws an SVG document: outlines of the faces in isometric view (from +x, -y, +z), the nearer
/// over the farther, each with its number inside.
pub fn picture(faces: &[Face]) -> String {
    let mut outlines: Vec<ProjectedFace> = faces.iter().map(outline).collect();
    // Painter's algorithm: the farthest first.
    outlines.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let scale = fit(&outlines);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIZE} {SIZE}\" \
         font-family=\"sans-serif\" font-size=\"13\" text-anchor=\"middle\">\n\
         <title>Faces and their numbers</title>\n"
    );
    // Writing to a string cannot fail.
    let _ = outlines.iter().try_for_each(|outline| draw(&mut svg, outline, &scale));
    let _ = outlines.iter().try_for_each(|outline| {
        let [x, y] = scale.apply(outline.label);
        let number = outline.number;
        writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" dy=\"0.35em\" fill=\"#111\" stroke=\"#fff\" \
             stroke-width=\"3\" paint-order=\"stroke\">{number}</text>"
        )
    });
    svg.push_str("</svg>\n");
    svg
}

fn draw(svg: &mut String, outline: &ProjectedFace, scale: &PictureFit) -> std::fmt::Result {
    write!(
        svg,
        "<path fill=\"#8ab\" fill-opacity=\"0.35\" fill-rule=\"evenodd\" stroke=\"#246\" d=\""
    )?;
    for rim in &outline.rims {
        for (i, point) in rim.iter().enumerate() {
            let [x, y] = scale.apply(*point);
            write!(svg, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' })?;
        }
        svg.push('Z');
    }
    writeln!(svg, "\"><title>face {}</title></path>", outline.number)
}

fn outline(face: &Face) -> ProjectedFace {
    let rims: Vec<Vec<[f64; 2]>> =
        quadrature::rims(face).iter().map(|rim| projected(face, rim)).collect();
    let nodes = quadrature::nodes(face);
    let points: Vec<[f64; 3]> =
        nodes.iter().map(|node| project(&face.point(node.uv[0], node.uv[1]))).collect();
    let count = points.len().max(1) as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    // The point of the face closest to its middle: inside, even if the face is a ring.
    let distance = |p: &[f64; 3]| math::hypot(p[0] - x, p[1] - y);
    let label = points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let label = label.map_or([x, y], |p| [p[0], p[1]]);
    ProjectedFace { number: face.number, rims, label, depth: mean(2) }
}

fn projected(face: &Face, rim: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let flat = |uv: [f64; 2]| {
        let [x, y, _] = project(&face.point(uv[0], uv[1]));
        [x, y]
    };
    quadrature::dense(face, rim, CHORDS).into_iter().map(flat).collect()
}

/// Projects isometrically: the three axes appear equally long, z upright.
fn project(p: &Point3<f64>) -> [f64; 3] {
    // Orthonormal directions (1, 1, 0), (-1, 1, 2) and (1, -1, 1): right, up, towards the viewer.
    let (half, third, sixth) = (0.5_f64.sqrt(), 3.0_f64.sqrt(), 6.0_f64.sqrt());
    [(p.x + p.y) * half, (p.y - p.x + 2.0 * p.z) / sixth, (p.x - p.y + p.z) / third]
}

/// From projected mm to the picture.
struct PictureFit {
    scale: f64,
    middle: [f64; 2],
}

impl PictureFit {
    fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            0.5 * SIZE + (x - self.middle[0]) * self.scale,
            // SVG counts y downwards.
            0.5 * SIZE - (y - self.middle[1]) * self.scale,
        ]
    }
}

fn fit(outlines: &[ProjectedFace]) -> PictureFit {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for point in outlines.iter().flat_map(|outline| outline.rims.iter().flatten()) {
        for k in 0..2 {
            low[k] = low[k].min(point[k]);
            high[k] = high[k].max(point[k]);
        }
    }
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    let scale = if size > 0.0 && size.is_finite() { (SIZE - 2.0 * MARGIN) / size } else { 1.0 };
    let middle = [0, 1].map(|k| {
        let m = 0.5 * (low[k] + high[k]);
        if m.is_finite() { m } else { 0.0 }
    });
    PictureFit { scale, middle }
}
