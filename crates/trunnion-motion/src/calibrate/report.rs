//! Result of a calibration.

use super::deviation::ChainDeviation;
use crate::machine::Machine;
use nalgebra::Point3;

/// Estimate of one deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct DeviationEstimate {
    /// The deviation.
    pub deviation: ChainDeviation,
    /// Its value \[mm or rad\]: real machine less machine file.
    pub value: f64,
    /// Standard uncertainty \[mm or rad\]; `None` if the readings do not fix the deviation by itself.
    pub uncertainty: Option<f64>,
}

/// Share of one deviation in a combination.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CombinationPart {
    /// The deviation.
    pub deviation: ChainDeviation,
    /// Its change \[mm or rad\].
    pub change: f64,
}

/// Change of several deviations together that no reading notices.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DeviationCombination {
    /// The parts, the largest first.
    pub parts: Vec<CombinationPart>,
}

/// Result of a calibration.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CalibrationReport {
    /// The machine with its deviations. A combination that no reading notices stays as in the file.
    pub machine: Machine,
    /// All deviations, in a fixed order.
    pub estimates: Vec<DeviationEstimate>,
    /// Combinations that the readings do not separate.
    pub confounded: Vec<DeviationCombination>,
    /// Centres of the spheres \[mm\], workpiece frame of a workpiece at the machine origin.
    pub spheres: Vec<Point3<f64>>,
    /// Root mean square of the residuals before and after \[mm\], per number that was read.
    pub rms_before: f64,
    /// The same after the fit.
    pub rms: f64,
    /// Noise of a number \[mm\] on which the uncertainties rest: as stated, or by the residuals.
    pub noise: f64,
    /// Numbers read less numbers found.
    pub freedom: usize,
    /// Length of the residual of each reading \[mm\].
    pub residuals: Vec<f64>,
    /// Indices of readings that contradict the others.
    pub contradicting: Vec<usize>,
}
