//! Calibration: the place and direction of every axis from measured sphere centres and ball-bar radii.
//!
//! A machine has thirteen deviations of its chain that do not move with the axes: each rotary axis line is
//! offset across itself (2) and tilted (2), Y is out of square with X (1), Z with both (2), and the tool axis
//! is tilted (2). X and the gauge point define the machine frame. [`calibrate`] finds them by least squares
//! on the derivatives of the forward map, the unknown centres of the spheres beside them, and states which
//! of them the readings do not separate. [`further_readings`] names the positions that would.
//!
//! # Example
//!
//! ```
//! use trunnion_motion::calibrate::{CalibrationOptions, SphereReading, calibrate};
//! use trunnion_motion::machine::{AxisSpec, Machine, MachineSpec};
//! use trunnion_motion::types::AxisVector;
//!
//! let [x, y, z] = [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])]
//!     .map(|(name, dir)| AxisSpec::linear(name, dir));
//! let [a, c] = [("A", [1.0, 0.0, 0.0]), ("C", [0.0, 0.0, 1.0])]
//!     .map(|(name, dir)| AxisSpec::rotary(name, dir, [0.0; 3]));
//! let chain = ["w", "C", "A", "b", "X", "Y", "Z", "t"];
//! let machine = Machine::new(MachineSpec::new("table", &chain, vec![x, y, z, a, c]))?;
//!
//! // A sphere at (100, 0, 0) of the table, found half a turn apart: C is not at 0 but at x = 0.01.
//! let found = [(0.0, 100.0), (90.0, 0.01), (180.0, -99.98), (270.0, 0.01)].map(|(c, x): (f64, f64)| {
//!     let turn = c.to_radians();
//!     let y = -99.99 * turn.sin();
//!     SphereReading::center(AxisVector::from([x, y, 0.0, turn, 0.0]), 0.0, 0)
//! });
//! let report = calibrate(&machine, &found, CalibrationOptions::standard())?;
//! assert!((report.machine.axes[3].point.x - 0.01).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod calibration;
mod calibration_error;
mod candidates;
mod combination;
mod deviation;
mod equations;
mod fit;
mod further;
mod model;
mod reading;
mod report;
mod senses;

pub use calibration::calibrate;
pub use calibration_error::CalibrationError;
pub use deviation::{CHAIN_DEVIATIONS, ChainDeviation, DeviationKind};
pub use fit::CalibrationOptions;
pub use further::{FurtherReading, further_readings};
pub use reading::{ReadingKind, SphereReading};
pub use report::{CalibrationReport, CombinationPart, DeviationCombination, DeviationEstimate};
