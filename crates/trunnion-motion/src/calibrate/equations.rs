//! Normal equations of the least squares: deviations and sphere centres.

use super::deviation::CHAIN_DEVIATIONS;
use super::model::{Deviations, PlaceDerivative, TipJet};
use super::reading::{ReadingKind, SphereReading};
use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

/// Square matrix over the deviations.
pub(super) type DeviationMatrix = SMatrix<f64, CHAIN_DEVIATIONS, CHAIN_DEVIATIONS>;

/// Eigenvalue of a sphere's own equations, as a share of the largest, below which its centre is free in that
/// direction: a ball bar in one plane says nothing across it. Far above rounding, far below a measured direction.
const FREE_CENTER: f64 = 1e-6;

/// Part of one sphere in the equations.
#[derive(Debug, Clone, Copy)]
struct SpherePart {
    mixed: SMatrix<f64, CHAIN_DEVIATIONS, 3>,
    own: Matrix3<f64>,
    right: Vector3<f64>,
}

/// Normal equations at one point: `J^T J x = -J^T r`, in scaled deviations.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    scale: Deviations,
    matrix: DeviationMatrix,
    right: Deviations,
    spheres: Vec<SpherePart>,
    /// Sum of the squared residuals \[mm²\].
    pub(super) squares: f64,
    /// Numbers that were read.
    pub(super) numbers: usize,
}

/// Equations of the scaled deviations alone, the best sphere centres put in.
#[derive(Debug, Clone)]
pub(super) struct ReducedEquations {
    pub(super) eigen: SymmetricEigen<f64, nalgebra::Const<CHAIN_DEVIATIONS>>,
    right: Deviations,
}

/// One number that was read: its residual, and the derivative of the residual.
struct ResidualRow {
    residual: f64,
    by_deviations: Deviations,
    by_center: Vector3<f64>,
}

impl NormalEquations {
    /// Starts without readings; `scale` turns scaled deviations \[mm\] into mm and rad.
    pub(super) fn new(scale: Deviations, spheres: usize) -> Self {
        let part =
            SpherePart { mixed: SMatrix::zeros(), own: Matrix3::zeros(), right: Vector3::zeros() };
        Self {
            scale,
            matrix: DeviationMatrix::zeros(),
            right: Deviations::zeros(),
            spheres: vec![part; spheres],
            squares: 0.0,
            numbers: 0,
        }
    }

    /// Adds one reading; returns the length of its residual \[mm\].
    pub(super) fn add(
        &mut self,
        reading: &SphereReading,
        jet: &TipJet,
        center: &Vector3<f64>,
    ) -> f64 {
        let rows = rows(reading, jet, center);
        let before = self.squares;
        for row in &rows {
            self.add_row(row, reading.sphere);
        }
        (self.squares - before).max(0.0).sqrt()
    }

    fn add_row(&mut self, row: &ResidualRow, sphere: usize) {
        let by = row.by_deviations.component_mul(&self.scale);
        self.squares += row.residual.powi(2);
        self.numbers += 1;
        self.matrix += by * by.transpose();
        self.right -= by * row.residual;
        if let Some(part) = self.spheres.get_mut(sphere) {
            part.mixed += by * row.by_center.transpose();
            part.own += row.by_center * row.by_center.transpose();
            part.right -= row.by_center * row.residual;
        }
    }

    /// Eliminates the sphere centres.
    pub(super) fn reduced(&self) -> ReducedEquations {
        let (mut matrix, mut right) = (self.matrix, self.right);
        for part in &self.spheres {
            let through = part.mixed * inverse(&part.own);
            matrix -= through * part.mixed.transpose();
            right -= through * part.right;
        }
        // Symmetric up to rounding; the mean is symmetric exactly.
        let eigen = SymmetricEigen::new(0.5 * (matrix + matrix.transpose()));
        ReducedEquations { eigen, right }
    }

    /// Returns the motion of the sphere centres that goes with a step of the scaled deviations.
    pub(super) fn center_steps(&self, scaled: &Deviations) -> Vec<Vector3<f64>> {
        let step =
            |part: &SpherePart| inverse(&part.own) * (part.right - part.mixed.transpose() * scaled);
        self.spheres.iter().map(step).collect()
    }

    /// Returns the number of sphere coordinates that the readings fix.
    pub(super) fn center_numbers(&self) -> usize {
        let rank = |part: &SpherePart| {
            let values = part.own.symmetric_eigenvalues();
            values.iter().filter(|value| is_fixed(**value, values.amax())).count()
        };
        self.spheres.iter().map(rank).sum()
    }
}

impl ReducedEquations {
    /// Returns the step along the eigenvectors whose eigenvalue is at least `least`; the others stay.
    pub(super) fn step(&self, least: f64) -> Deviations {
        let mut step = Deviations::zeros();
        for (value, vector) in self.pairs() {
            if value >= least {
                step += vector * (vector.dot(&self.right) / value);
            }
        }
        step
    }

    /// Returns the diagonal of the covariance for a noise of 1 mm, along those eigenvectors.
    pub(super) fn variances(&self, least: f64) -> Deviations {
        let mut sum = Deviations::zeros();
        for (value, vector) in self.pairs() {
            if value >= least {
                sum += vector.component_mul(&vector) / value;
            }
        }
        sum
    }

    /// Returns the directions of the others.
    pub(super) fn undetermined(&self, least: f64) -> Vec<Deviations> {
        self.pairs().filter(|(value, _)| *value < least).map(|(_, vector)| vector).collect()
    }

    fn pairs(&self) -> impl Iterator<Item = (f64, Deviations)> {
        let vectors = self.eigen.eigenvectors.column_iter().map(nalgebra::Matrix::into_owned);
        self.eigen.eigenvalues.iter().copied().zip(vectors)
    }
}

fn is_fixed(value: f64, largest: f64) -> bool {
    value > FREE_CENTER * largest
}

/// Returns the inverse of a sphere's own matrix in the directions that are fixed, zero across them.
fn inverse(own: &Matrix3<f64>) -> Matrix3<f64> {
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(*own);
    let largest = eigenvalues.amax();
    let inverted =
        eigenvalues.map(|value| if is_fixed(value, largest) { 1.0 / value } else { 0.0 });
    eigenvectors * Matrix3::from_diagonal(&inverted) * eigenvectors.transpose()
}

fn rows(reading: &SphereReading, jet: &TipJet, center: &Vector3<f64>) -> Vec<ResidualRow> {
    let from_center = jet.tip - center;
    match reading.kind {
        ReadingKind::Center { deviation } => [Vector3::x(), Vector3::y(), Vector3::z()]
            .map(|along| projected(&jet.derivative, along.dot(&(from_center - deviation)), along))
            .into(),
        ReadingKind::Radius { radius } => {
            let distance = from_center.norm();
            // At the centre itself the distance has no derivative: the row says nothing there.
            let along = if distance > 0.0 { from_center / distance } else { Vector3::zeros() };
            vec![projected(&jet.derivative, distance - radius, along)]
        }
    }
}

fn projected(derivative: &PlaceDerivative, residual: f64, along: Vector3<f64>) -> ResidualRow {
    let by_deviations: SVector<f64, CHAIN_DEVIATIONS> = derivative.transpose() * along;
    ResidualRow { residual, by_deviations, by_center: -along }
}
