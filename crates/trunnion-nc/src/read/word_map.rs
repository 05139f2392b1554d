//! Words that a program turns, mirrors or scales: `ROT`, `MIRROR`, `SCALE`, `G68`, `G51.1`.

use nalgebra::{Matrix3, Vector3};

/// Coefficients below this are those of axes that do not take part.
pub(super) const NOTHING: f64 = 1e-12;

/// From X Y Z words to those of the work offset: `p_work = linear p + shift`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WordMap {
    pub(super) linear: Matrix3<f64>,
    /// \[mm\]
    pub(super) shift: Vector3<f64>,
    /// Its inverse, as every reading needs it.
    pub(super) inverse: Matrix3<f64>,
}

impl WordMap {
    /// Creates a map; `None`: it flattens the words.
    pub(super) fn new(linear: Matrix3<f64>, shift: Vector3<f64>) -> Option<Self> {
        let inverse = linear.try_inverse()?;
        let finite = |matrix: &Matrix3<f64>| matrix.iter().all(|value| value.is_finite());
        (finite(&linear) && finite(&inverse)).then_some(Self { linear, shift, inverse })
    }

    /// Creates a map that leaves a point where it is.
    pub(super) fn about(linear: Matrix3<f64>, point: Vector3<f64>) -> Option<Self> {
        // p_work = c + linear (p - c).
        Self::new(linear, point - linear * point)
    }
}

/// Returns the turn counterclockwise about axis 0, 1 or 2 by an angle \[rad\], as a matrix.
pub(super) fn turn_about(axis: usize, angle: f64) -> Matrix3<f64> {
    let mut unit = Vector3::zeros();
    if let Some(component) = unit.get_mut(axis) {
        *component = 1.0;
    }
    let mut turn = nalgebra::Rotation3::new(angle * unit).into_inner();
    // Quarter turns are exact, so that axes which do not take part stay out.
    turn.iter_mut().filter(|value| value.abs() < NOTHING).for_each(|value| *value = 0.0);
    turn
}
