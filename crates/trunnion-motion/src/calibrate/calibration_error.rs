//! Errors of a calibration.

/// Error of a calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// There are fewer numbers than unknowns.
    #[error("{numbers} numbers were read, and they depend on {unknowns} unknowns")]
    TooFew {
        /// Numbers in all readings.
        numbers: usize,
        /// Deviations that they depend on, and sphere coordinates.
        unknowns: usize,
    },
    /// A number of a reading is NaN or infinite, or a radius is not above 0.
    #[error("reading {reading}: {what} = {value} mm or rad is no possible reading")]
    Number {
        /// Index of the reading, from 0.
        reading: usize,
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The readings fit the machine far better with other senses of rotation.
    #[error(
        "the readings are up to {rms:.3} mm (rms) off this machine, but {other:.4} mm if {} the other way",
        turn(axes)
    )]
    OtherSense {
        /// Names of the axes that count the other way.
        axes: Vec<String>,
        /// Residual with the senses of the machine \[mm\].
        rms: f64,
        /// Residual with the others \[mm\].
        other: f64,
    },
    /// The best fit has a deviation that no machine has.
    #[error(
        "the readings fit only with {name} = {value:.4} ({unit}), which no machine has; they are off by {rms:.4} mm then"
    )]
    Implausible {
        /// Name of the deviation.
        name: String,
        /// Its value \[mm or rad\].
        value: f64,
        /// `mm` or `rad`.
        unit: &'static str,
        /// Residual of the fit \[mm\].
        rms: f64,
    },
}

fn turn(axes: &[String]) -> String {
    match axes {
        [one] => format!("{one} turns"),
        several => format!("{} turn", several.join(" and ")),
    }
}

impl CalibrationError {
    /// Returns the remedy.
    pub fn remedy(&self) -> String {
        match self {
            Self::TooFew { .. } => {
                "measure at more rotary positions: each sphere centre gives three numbers".into()
            }
            Self::Number { .. } => "correct the row, or leave it out".into(),
            Self::OtherSense { axes, .. } => format!(
                "write sense = -1 (or take it out) for {} in the machine file, and calibrate again",
                axes.join(" and ")
            ),
            Self::Implausible { .. } => {
                "compare units, tool length, order of the chain and signs with the machine: \
                 `machine show` lists the motions to expect"
                    .into()
            }
        }
    }
}
