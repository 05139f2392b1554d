//! Linear axes for a tip, once the rotary axes are known: one 3x3 solve.

use super::rotary::RotaryAngle;
use crate::machine::ChainGeometry;
use crate::math::jet::Real;
use nalgebra::{Matrix3, Vector3};

/// A vector turned about the second rotary, seen in the first rotary's frame:
/// `still + with_cos cos t2 + with_sin sin t2`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TurnedVector {
    still: Vector3<f64>,
    with_cos: Vector3<f64>,
    with_sin: Vector3<f64>,
}

/// Position of the linear axes in the chain, which determines the system to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SlideLayout {
    /// All before both rotaries: `l = inverse R1 y`, frame of the first rotary back to the workpiece.
    Before(Matrix3<f64>),
    /// All between: `l = inverse y`.
    Between(Matrix3<f64>),
    /// All after: `l = inverse R2⁻¹ y`, through the frame of the second rotary.
    After { second_from_first: Matrix3<f64>, inverse: Matrix3<f64> },
    /// On both sides of a rotary: columns in the frame of the first.
    Mixed([SlideColumn; 3]),
}

/// Direction of one linear axis seen in the first rotary's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SlideColumn {
    /// Before the first rotary: turned back by it.
    Before(Vector3<f64>),
    Between(Vector3<f64>),
    After(TurnedVector),
}

/// Fixed parts of the solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlideSolver {
    /// Frame of the first rotary, and a point of it.
    frame: Matrix3<f64>,
    point: Vector3<f64>,
    /// `p2 - p1`, and `tip0 - p2` turned by the second rotary, in the frame of the first.
    offset: TurnedVector,
    layout: SlideLayout,
}

impl SlideSolver {
    /// Prepares the solve; `None` if the linear axes lie in one plane, or a number is not finite.
    pub(super) fn new(chain: &ChainGeometry, frame: &[Vector3<f64>; 3]) -> Option<Self> {
        let frame = Matrix3::from_rows(&frame.map(|row| row.transpose()));
        let [first, second] = &chain.rotary;
        let turned = |v: Vector3<f64>| {
            // Rodrigues: the part along the axis stays, the part across it turns.
            let along = second.dir.scale(second.dir.dot(&v));
            TurnedVector {
                still: frame * along,
                with_cos: frame * (v - along),
                with_sin: frame * second.dir.cross(&v),
            }
        };
        let mut offset = turned(chain.tip - second.point);
        offset.still += frame * (second.point - first.point);
        let all: Matrix3<f64> = chain.slides.iter().sum();
        let inverse = all.try_inverse()?;
        // Where all linear axes stand on one side of each rotary, one constant 3x3 matrix inverts them: the
        // rotaries in front of them are undone first. Only a mixed chain needs a solve for each pose.
        let layout = match chain.stage {
            [0, 0, 0] => SlideLayout::Before(inverse * frame.transpose()),
            [1, 1, 1] => SlideLayout::Between(inverse * frame.transpose()),
            [2, 2, 2] => after(chain, &frame, &inverse)?,
            stage => SlideLayout::Mixed([0, 1, 2].map(|axis| {
                let column: Vector3<f64> = all.column(axis).into();
                match stage.get(axis) {
                    Some(0) => SlideColumn::Before(frame * column),
                    Some(1) => SlideColumn::Between(frame * column),
                    _ => SlideColumn::After(turned(column)),
                }
            })),
        };
        let finite = offset.still.iter().chain(inverse.iter()).all(|x| x.is_finite());
        finite.then_some(Self { frame, point: first.point, offset, layout })
    }

    /// Returns the linear axes that bring the tip to `tip` with the rotaries at `turns`; `None` if the linear
    /// axes lie in one plane there.
    #[inline]
    pub(super) fn solve<T: Real>(
        &self,
        tip: [T; 3],
        turns: &[RotaryAngle<T>; 2],
    ) -> Option<[T; 3]> {
        let [first, second] = turns;
        let p = &self.point;
        let tip = apply(&self.frame, [tip[0] + -p.x, tip[1] + -p.y, tip[2] + -p.z]);
        // R1^-1 (tip - p1) - (p2 - p1) - R2 (tip0 - p2) = sum of the axis columns times l.
        // Turn the first rotary back and take off the offset: what remains is linear in the linear axes.
        let y = minus(back(first, tip), self.offset.at(second));
        match &self.layout {
            SlideLayout::Between(inverse) => Some(apply(inverse, y)),
            SlideLayout::Before(inverse) => Some(apply(inverse, on(first, y))),
            SlideLayout::After { second_from_first, inverse } => {
                Some(apply(inverse, back(second, apply(second_from_first, y))))
            }
            SlideLayout::Mixed(columns) => cramer(columns.map(|column| column.at(turns)), y),
        }
    }
}

/// Returns the layout with all linear axes after both rotaries: in a frame of the second rotary, whose
/// x-y plane it turns.
fn after(
    chain: &ChainGeometry,
    frame: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
) -> Option<SlideLayout> {
    // With w2 as third axis a turn by t2 is a plane rotation, as `back` computes it.
    let [first, second] = chain.rotary.map(|joint| *joint.dir);
    let across = first.cross(&second).try_normalize(0.0)?;
    let rows = [across, second.cross(&across), second].map(|row| row.transpose());
    let second_frame = Matrix3::from_rows(&rows);
    Some(SlideLayout::After {
        second_from_first: second_frame * frame.transpose(),
        inverse: inverse * second_frame.transpose(),
    })
}

impl TurnedVector {
    #[inline]
    fn at<T: Real>(&self, turn: &RotaryAngle<T>) -> [T; 3] {
        let one = |row: usize| {
            turn.cos * self.with_cos[row] + turn.sin * self.with_sin[row] + self.still[row]
        };
        [one(0), one(1), one(2)]
    }
}

impl SlideColumn {
    #[inline]
    fn at<T: Real>(&self, turns: &[RotaryAngle<T>; 2]) -> [T; 3] {
        let constant = |v: &Vector3<f64>| [v.x, v.y, v.z].map(T::constant);
        match self {
            Self::Before(v) => back(&turns[0], constant(v)),
            Self::Between(v) => constant(v),
            Self::After(turned) => turned.at(&turns[1]),
        }
    }
}

/// Returns `matrix v`.
#[inline]
fn apply<T: Real>(matrix: &Matrix3<f64>, v: [T; 3]) -> [T; 3] {
    let one =
        |row: usize| v[0] * matrix[(row, 0)] + v[1] * matrix[(row, 1)] + v[2] * matrix[(row, 2)];
    [one(0), one(1), one(2)]
}

/// Turns `v` about the third direction.
#[inline]
fn on<T: Real>(turn: &RotaryAngle<T>, [x, y, z]: [T; 3]) -> [T; 3] {
    [x * turn.cos - y * turn.sin, x * turn.sin + y * turn.cos, z]
}

/// Turns `v` back about the third direction.
#[inline]
fn back<T: Real>(turn: &RotaryAngle<T>, [x, y, z]: [T; 3]) -> [T; 3] {
    [x * turn.cos + y * turn.sin, y * turn.cos - x * turn.sin, z]
}

#[inline]
fn minus<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    let one = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [one(1, 2), one(2, 0), one(0, 1)]
}

#[inline]
fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Smallest volume of three unit directions that still counts as a frame: solving loses as many
/// digits as this is below 1, and half of them must stay.
const FLAT: f64 = 1e-8;

/// Solves `columns l = y` by Cramer's rule and one step of refinement: Cramer's rule alone leaves a
/// residual of rounding times the condition, which the tip would be off by where the axes nearly
/// lie in one plane and travel far.
#[inline]
fn cramer<T: Real>(columns: [[T; 3]; 3], y: [T; 3]) -> Option<[T; 3]> {
    let [a, b, c] = columns;
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, rows[0]);
    if volume.value().abs() <= FLAT {
        return None;
    }
    let inverse = T::constant(1.0) / volume;
    let solve = |y: [T; 3]| rows.map(|row| dot(row, y) * inverse);
    let [l, m, n] = solve(y);
    let at = |row: usize| a[row] * l + b[row] * m + c[row] * n;
    // One step of refinement: solve for the residual.
    let [dl, dm, dn] = solve(minus(y, [at(0), at(1), at(2)]));
    Some([l + dl, m + dm, n + dn])
}
