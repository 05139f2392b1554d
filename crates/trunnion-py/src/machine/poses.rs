//! Tool poses of calls, and those without an answer.

use crate::arrays::Numbers;
use crate::errors::WrongArgument;
use pyo3::prelude::*;
use trunnion::nalgebra::{Unit, Vector3};
use trunnion::types::ToolPose;

/// Most poses without an answer that a warning names.
const LISTED: usize = 3;

/// Poses without an answer.
#[derive(Default)]
pub(super) struct Unreached {
    count: usize,
    first: Vec<String>,
}

impl Unreached {
    pub(super) fn add(&mut self, pose: usize, error: &dyn std::fmt::Display) {
        self.count += 1;
        if self.first.len() < LISTED {
            self.first.push(format!("pose {pose}: {error}"));
        }
    }

    /// Warns about poses whose rows are NaN.
    pub(super) fn warn(&self, py: Python<'_>, poses: usize) -> PyResult<()> {
        if self.count == 0 {
            return Ok(());
        }
        let more = if self.count > LISTED { "\n  .." } else { "" };
        let message = format!(
            "{} of {poses} poses have no axis position, and rows of NaN:\n  {}{more}",
            self.count,
            self.first.join("\n  ")
        );
        let warning = py.import("trunnion._errors")?.getattr("UnreachableWarning")?;
        py.import("warnings")?.call_method1("warn", (message, warning)).map(drop)
    }
}

/// Tool poses of an argument pair.
#[derive(Clone, Copy)]
pub(crate) struct Poses<'a> {
    pub(crate) tips: &'a [[f64; 3]],
    pub(crate) axes: &'a [[f64; 3]],
    /// True for one pose without a row index.
    pub(super) single: bool,
}

/// Arrays behind [`Poses`].
pub(crate) struct PoseArrays<'py> {
    tips: Numbers<'py>,
    axes: Numbers<'py>,
}

impl<'py> PoseArrays<'py> {
    /// Takes tips of any finite value, and axes of length 1.
    pub(crate) fn of(tip: &Bound<'py, PyAny>, axis: &Bound<'py, PyAny>) -> PyResult<Self> {
        let (tips, axes) = (Numbers::of("tip", tip)?, Numbers::of("axis", axis)?);
        tips.shaped("tip", &[&[3], &[0, 3]])?;
        axes.shaped("axis", &[&[3], &[0, 3]])?;
        if tips.shape() != axes.shape() {
            let value = format!("shape {:?}", axes.shape());
            let defect = format!("does not match the shape {:?} of tip", tips.shape());
            let wrong =
                WrongArgument { name: "axis", index: &[], value, defect: &defect, remedy: "" };
            return Err(wrong.error(tip.py()));
        }
        axes.unit("axis")?;
        Ok(Self { tips, axes })
    }

    pub(crate) fn view(&self) -> Poses<'_> {
        let single = self.tips.shape().len() == 1;
        Poses { tips: self.tips.rows(), axes: self.axes.rows(), single }
    }
}

pub(super) fn pose(tip: &[f64; 3], axis: &[f64; 3]) -> ToolPose {
    ToolPose { tip: (*tip).into(), axis: Unit::new_normalize(Vector3::from(*axis)) }
}
