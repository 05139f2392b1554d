//! Cells of a face: rectangles of local parameters with their images.

use crate::cover::layout::region::ChartPoint;
use nalgebra::{Point3, Vector3};

/// Largest ratio of the sides of a cell that an edge of the trims crosses.
const SLIVER: f64 = 64.0;

/// Largest sag of a straight line, as a share of its length.
const STRAIGHT: f64 = 1e-9;

/// Rectangle of local parameters with its image at 3 x 3 points, first index across.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceCell {
    pub(crate) range: [[f64; 2]; 2],
    pub(crate) points: [[Point3<f64>; 3]; 3],
}

impl FaceCell {
    pub(crate) fn new(range: [[f64; 2]; 2], at: &impl Fn(ChartPoint) -> Point3<f64>) -> Self {
        let [a, b] = range.map(|[low, high]| [low, 0.5 * (low + high), high]);
        Self { range, points: a.map(|across| b.map(|along| at([across, along]))) }
    }

    pub(crate) fn middle(&self) -> ChartPoint {
        self.range.map(|[low, high]| 0.5 * (low + high))
    }

    pub(crate) fn centre(&self) -> Point3<f64> {
        self.points[1][1]
    }

    /// Returns the corners: lower-lower, lower-upper, upper-lower, upper-upper.
    pub(crate) fn corners(&self) -> [Point3<f64>; 4] {
        let p = &self.points;
        [p[0][0], p[0][2], p[2][0], p[2][2]]
    }

    /// Returns row `i` of three points by parameter `k`.
    fn line(&self, k: usize, i: usize) -> [Point3<f64>; 3] {
        if k == 0 { [0, 1, 2].map(|j| self.points[j][i]) } else { self.points[i] }
    }

    /// Returns the unit normal of the corners' diagonals, of either sign; none for a cell without
    /// area.
    pub(crate) fn normal(&self) -> Option<Vector3<f64>> {
        let [a, b, c, d] = self.corners();
        (d - a).cross(&(c - b)).try_normalize(0.0)
    }

    /// Returns the vector from the middle of one edge to that of the opposite one, by parameter
    /// `k`.
    pub(crate) fn across_edges(&self, k: usize) -> Vector3<f64> {
        let line = self.line(k, 1);
        line[2] - line[0]
    }

    /// Returns the extent by parameter `k` \[mm\].
    pub(crate) fn extent(&self, k: usize) -> f64 {
        let line = self.line(k, 1);
        (line[1] - line[0]).norm() + (line[2] - line[1]).norm()
    }

    /// Bounds the deviation of the image from the hull of its corners, by parameter `k` \[mm\].
    ///
    /// A bilinear patch through the corners is in their hull; the image is off it by at most
    /// `|S_kk| h^2 / 8` for either parameter. The second difference of three points `h / 2` apart
    /// is a mean of `S_kk h^2 / 4`. Taken whole, it allows a second derivative of twice the largest
    /// mean on the cell's three lines.
    pub(crate) fn sag(&self, k: usize) -> f64 {
        // Second difference of each of the three lines of points by parameter k.
        let bow = |i: usize| {
            let [a, b, c] = self.line(k, i);
            ((a - b) + (c - b)).norm()
        };
        bow(0).max(bow(1)).max(bow(2))
    }

    /// Returns `true` if the lines along parameter `k` are straight.
    pub(super) fn is_straight(&self, k: usize) -> bool {
        self.sag(k) <= STRAIGHT * self.extent(k)
    }

    /// Returns the parameter by which to halve the cell, for the loss of a bound by either.
    ///
    /// A cell that an edge of the trims crosses loses by what lies beyond the edge as well, which a sliver along
    /// one parameter never sheds.
    pub(crate) fn side(&self, losses: [f64; 2], share: CellShare) -> usize {
        let by_loss = usize::from(losses[1] > losses[0]);
        if !matches!(share, CellShare::Cut(_)) {
            return by_loss;
        }
        let [across, along] = [self.extent(0), self.extent(1)];
        if along > SLIVER * across {
            1
        } else if across > SLIVER * along {
            0
        } else {
            by_loss
        }
    }

    /// Returns the area: half the parallelogram of the diagonals \[mm²\].
    pub(crate) fn area(&self) -> f64 {
        let [a, b, c, d] = self.corners();
        0.5 * (d - a).cross(&(c - b)).norm()
    }

    /// Returns the radius of the ball about the centre that holds the image.
    pub(crate) fn radius(&self) -> f64 {
        let centre = self.centre();
        let far = self.corners().iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        far + self.sag(0) + self.sag(1)
    }

    /// Bounds the distance from the centre to some point of the face in the cell \[mm\]; `None` if
    /// there is no such point.
    ///
    /// If an edge of the trims runs through a cell without its middle, nothing more is known.
    /// Without this bound a cell at a corner of the trims, that the tool goes into, would be halved
    /// until rounding ends it.
    pub(crate) fn some_within(&self, share: CellShare) -> Option<f64> {
        match share {
            CellShare::Whole | CellShare::Cut(true) => Some(0.0),
            CellShare::Cut(false) => Some(self.radius()),
            CellShare::None => None,
        }
    }

    /// Halves the cell by parameter `k`.
    pub(crate) fn halves(&self, k: usize, at: &impl Fn(ChartPoint) -> Point3<f64>) -> [Self; 2] {
        let [low, high] = self.range[k];
        let middle = 0.5 * (low + high);
        [[low, middle], [middle, high]].map(|part| {
            let mut range = self.range;
            range[k] = part;
            let first = usize::from(part[0] > low);
            let quarter = 0.5 * (part[0] + part[1]);
            let other = range[1 - k];
            let others = [other[0], 0.5 * (other[0] + other[1]), other[1]];
            let mut points = self.points;
            for (i, &other) in others.iter().enumerate() {
                let line = self.line(k, i);
                let place = if k == 0 { [quarter, other] } else { [other, quarter] };
                for (j, point) in [line[first], at(place), line[first + 1]].into_iter().enumerate()
                {
                    if k == 0 { points[j][i] = point } else { points[i][j] = point }
                }
            }
            Self { range, points }
        })
    }
}

/// Share of a cell that a trimmed face has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellShare {
    Whole,
    /// Some of it; `true` if that includes the middle.
    Cut(bool),
    None,
}
