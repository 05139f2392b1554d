//! Lines of a NURBS surface across which its curvature may jump.

use super::nurbs::NurbsSurface;
use super::patches::hull_box;
use nalgebra::Point3;
use nalgebra::Vector3;
use nalgebra::Vector4;

/// Halvings of the piece of a line on one patch.
const HALVINGS: u32 = 3;

/// Low and high corner.
type HullBox = [Vector3<f64>; 2];

/// Rims, and knot lines across which second derivatives are not continuous, in boxes.
#[derive(Debug, Clone)]
pub(super) struct CreaseIndex {
    lines: Vec<CreaseLine>,
}

#[derive(Debug, Clone)]
struct CreaseLine {
    hull: HullBox,
    pieces: Vec<HullBox>,
}

impl CreaseIndex {
    pub(super) fn new(surface: &NurbsSurface) -> Self {
        let mut lines = Vec::new();
        for direction in 0..2 {
            let knots = &surface.knots()[direction];
            let breaks = knots.breaks();
            for (index, value) in breaks.iter().enumerate() {
                let rim = index == 0 || index + 1 == breaks.len();
                let times =
                    knots.knots().iter().filter(|knot| (*knot - value).abs() <= 0.0).count();
                // Derivatives to the order degree - multiplicity are continuous.
                if rim || times + 2 > knots.degree() {
                    lines.push(CreaseLine::new(surface, direction, index));
                }
            }
        }
        Self { lines }
    }

    /// Returns `true` if a crease may come closer to `p` than `radius`.
    pub(super) fn any_near(&self, p: &Point3<f64>, radius: f64) -> bool {
        let met = |hull: &HullBox| meets(hull, p, radius);
        self.lines.iter().any(|line| met(&line.hull) && line.pieces.iter().any(met))
    }
}

impl CreaseLine {
    /// Creates the line at a break of the parameter `direction`.
    fn new(surface: &NurbsSurface, direction: usize, index: usize) -> Self {
        let counts = surface.patch_count();
        let [p, q] = surface.degree();
        let last = index == counts[direction];
        // The last break is the far side of the last patch.
        let own = if last { index - 1 } else { index };
        let mut pieces = Vec::new();
        for other in 0..counts[1 - direction] {
            let [i, j] = if direction == 0 { [own, other] } else { [other, own] };
            let Some(patch) = surface.patch(i, j) else { continue };
            let line: Vec<Vector4<f64>> = if direction == 0 {
                let row = if last { p } else { 0 };
                patch.points.iter().skip(row * (q + 1)).take(q + 1).copied().collect()
            } else {
                let column = if last { q } else { 0 };
                patch.points.iter().skip(column).step_by(q + 1).copied().collect()
            };
            split(line, HALVINGS, &mut pieces);
        }
        let nothing = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
        let hull = pieces
            .iter()
            .fold(nothing, |[low, high], piece| [low.inf(&piece[0]), high.sup(&piece[1])]);
        Self { hull, pieces }
    }
}

/// Appends boxes of the control points of the pieces of a Bezier curve, halved `times` times.
fn split(mut high: Vec<Vector4<f64>>, times: u32, pieces: &mut Vec<HullBox>) {
    if times == 0 {
        let (low, high) = hull_box(&high);
        pieces.push([low, high]);
        return;
    }
    // De Casteljau at one half.
    let mut low = high.clone();
    let last = high.len() - 1;
    for (level, point) in low.iter_mut().enumerate() {
        *point = high[0];
        for i in 0..last - level {
            high[i] = (high[i] + high[i + 1]) * 0.5;
        }
    }
    split(low, times - 1, pieces);
    split(high, times - 1, pieces);
}

/// Returns `true` if a box comes closer to `p` than `radius`, or if a value is not a number.
pub(super) fn meets([low, high]: &[Vector3<f64>; 2], p: &Point3<f64>, radius: f64) -> bool {
    let gap = (low - p.coords).sup(&(p.coords - high)).sup(&Vector3::zeros());
    // Not `<=`: a comparison with NaN is false, and must not count as apart.
    let apart = gap.norm_squared() > radius * radius;
    !apart
}
