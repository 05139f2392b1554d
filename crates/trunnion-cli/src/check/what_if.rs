//! `--what-if length=+0.01,pivot.B.z=0.02`: the part that machine, tool and setup with such errors would cut.

use super::subject::{CheckedMotion, Subject};
use crate::option_values::finite;
use crate::outcome::Failure;
use trunnion::cutter::Cutter;
use trunnion::machine::{FIRST_ROTARY, Kinematics};
use trunnion::types::Progress;
use trunnion::verify::{self, AssumedError, CheckInput, CheckOptions, Report, Tool};

/// One error that is assumed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assumption {
    quantity: Quantity,
    /// \[mm\]
    value: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Quantity {
    Length,
    Radius,
    /// Index of X, Y or Z.
    Origin(usize),
    /// Name of a rotary axis, and index of X, Y or Z.
    Pivot(String, usize),
}

/// Deviation of the part under an assumed error.
#[derive(Debug, serde::Serialize)]
pub(super) struct AssumedDeviation {
    assumed: String,
    /// Deepest gouge and largest excess measured \[mm\].
    gouge: f64,
    excess: f64,
    /// Points that no tool came near.
    uncut: usize,
    /// True if the tolerance is kept.
    kept: bool,
}

/// Directions of the machine frame.
const DIRECTIONS: [&str; 3] = ["x", "y", "z"];

/// Reads `length=+0.01`.
pub(super) fn read(text: &str) -> Result<Assumption, String> {
    let help = "write length, radius, origin.x or pivot.B.z, = and the error in mm";
    let (name, value) = text.split_once('=').ok_or(help)?;
    let direction = |name: &str| DIRECTIONS.iter().position(|known| *known == name).ok_or(help);
    // Dots divide a name into the thing that is off and the direction in which it is.
    let quantity = match name.trim().split('.').collect::<Vec<_>>()[..] {
        ["length"] => Quantity::Length,
        ["radius"] => Quantity::Radius,
        ["origin", along] => Quantity::Origin(direction(along)?),
        ["pivot", axis, along] => Quantity::Pivot(axis.to_owned(), direction(along)?),
        _ => return Err(help.to_owned()),
    };
    Ok(Assumption { quantity, value: finite(value)? })
}

impl Assumption {
    fn words(&self) -> String {
        let name = match &self.quantity {
            Quantity::Length => "length".to_owned(),
            Quantity::Radius => "radius".to_owned(),
            Quantity::Origin(along) => format!("origin.{}", DIRECTIONS[*along]),
            Quantity::Pivot(axis, along) => format!("pivot.{axis}.{}", DIRECTIONS[*along]),
        };
        format!("{name}={:+}", self.value)
    }

    /// Returns the error on a machine; cutter locations have none.
    fn error(&self, kinematics: Option<&Kinematics>) -> Result<AssumedError, Failure> {
        let mut error = AssumedError::NONE;
        match &self.quantity {
            Quantity::Radius => {
                error.radius = self.value;
                return Ok(error);
            }
            _ if kinematics.is_none() => {
                let help = "cutter locations have no machine: only radius=.. can be assumed";
                return Err(Failure::input(format!("--what-if {}\n  help: {help}", self.words())));
            }
            Quantity::Length => error.length = self.value,
            Quantity::Origin(along) => error.origin[*along] = self.value,
            Quantity::Pivot(name, along) => {
                // Only rotary axes have a pivot.
                let axes = kinematics.map(|of| &of.machine().axes[FIRST_ROTARY..]);
                let axes = axes.unwrap_or_default();
                let index = axes.iter().position(|axis| axis.name == *name).ok_or_else(|| {
                    let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
                    let help = format!("the rotary axes are {}", names.join(" and "));
                    Failure::input(format!("--what-if {}\n  help: {help}", self.words()))
                })?;
                error.pivots[index][*along] = self.value;
            }
        }
        Ok(error)
    }
}

impl Subject {
    /// Measures the part under each assumed error, and under all together if there are several.
    pub(super) fn assumed(&self, bars: &dyn Progress) -> Result<Vec<AssumedDeviation>, Failure> {
        let errors = self.errors()?;
        let mut cases: Vec<(String, AssumedError)> =
            self.assumptions.iter().map(Assumption::words).zip(errors.iter().copied()).collect();
        if errors.len() > 1 {
            // Errors are small, so their sum on one machine stands for all of them at once.
            let all = errors.iter().fold(AssumedError::NONE, |all, error| all + *error);
            cases.push(("all of these".to_owned(), all));
        }
        let measure = |(assumed, error): (String, AssumedError)| {
            let report = self.measure_with(&error, &assumed, bars)?;
            Ok(deviation(assumed, &report, &self.options))
        };
        cases.into_iter().map(measure).collect()
    }

    /// Returns the assumed errors; a wrong one is refused before the long work.
    pub(super) fn errors(&self) -> Result<Vec<AssumedError>, Failure> {
        let kinematics = match &self.motion {
            CheckedMotion::Program(_, kinematics) => Some(&**kinematics),
            CheckedMotion::Locations(_) => None,
        };
        if !self.assumptions.is_empty() && self.part.is_none() {
            let help = "name the part with --part, or leave --what-if out";
            return Err(Failure::input(format!("--what-if needs a part\n  help: {help}")));
        }
        self.assumptions.iter().map(|assumption| assumption.error(kinematics)).collect()
    }

    /// Measures the part that is cut with an error. Only heights at the grid points are compared, so no bounds are proven.
    fn measure_with(
        &self,
        error: &AssumedError,
        assumed: &str,
        bars: &dyn Progress,
    ) -> Result<Report, Failure> {
        let true_cutter = |cutter: &Cutter| {
            error
                .cutter(cutter)
                .map_err(|faults| Failure::input(format!("--what-if {assumed}: {faults}")))
        };
        let cutter = true_cutter(&self.cutter)?;
        let cutters: Result<Vec<Cutter>, Failure> =
            self.tools.iter().map(|(_, cutter)| true_cutter(cutter)).collect();
        let cutters = cutters?;
        let numbers = self.tools.iter().map(|(number, _)| *number);
        let tools: Vec<Tool<'_>> =
            numbers.zip(&cutters).map(|(number, cutter)| Tool { number, cutter }).collect();
        let options = CheckOptions { bounds: None, ..self.options };
        let report = match &self.motion {
            CheckedMotion::Program(program, kinematics) => {
                // The control computes with its own model; the machine moves with the error.
                let machine = error.kinematics(kinematics);
                let input = CheckInput::program(&**program, kinematics, &cutter).machine(&machine);
                verify::check(&self.with_tables(input, &tools), &options, bars)
            }
            CheckedMotion::Locations(file) => {
                let input = CheckInput::locations(&**file, &cutter);
                verify::check(&self.with_tables(input, &tools), &options, bars)
            }
        };
        report.map_err(|error| self.failure(&error))
    }
}

fn deviation(assumed: String, report: &Report, options: &CheckOptions) -> AssumedDeviation {
    let found = &report.deviation;
    // The lowest point may lie above the face: then nothing is gouged.
    let gouge = found.lowest.map_or(0.0, |lowest| (-lowest.height).max(0.0));
    let excess = found.highest.map_or(0.0, |highest| highest.height.max(0.0));
    let kept = gouge <= options.gouge && excess <= options.total && found.uncut == 0;
    AssumedDeviation { assumed, gouge, excess, uncut: found.uncut, kept }
}

impl AssumedDeviation {
    /// Returns the row of the table.
    pub(super) fn words(&self) -> String {
        let Self { assumed, gouge, excess, uncut, kept } = self;
        let verdict = if *kept { "kept" } else { "not kept" };
        format!(
            "{assumed}: gouge {gouge:.4}, excess {excess:.4} mm, {uncut} points uncut; {verdict}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assumption_is_read_as_written() {
        let pivot = Quantity::Pivot("B".to_owned(), 2);
        assert_eq!(read("pivot.B.z=0.02"), Ok(Assumption { quantity: pivot, value: 0.02 }));
        assert_eq!(read("length=+0.01").unwrap().words(), "length=+0.01");
        assert_eq!(read("origin.y=-1").unwrap().words(), "origin.y=-1");
        for wrong in ["length", "length=", "pivot.B=1", "pivot.B.w=1", "size=2", "radius=nan"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
