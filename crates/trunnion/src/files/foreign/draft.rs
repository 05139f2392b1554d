//! A machine as far as a foreign file states it, in mm and deg.

use crate::machine::{AxisInterpolation, AxisKind, FeedMode, ProgramFormat};
use std::collections::BTreeMap;

/// An axis as far as it is stated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisDraft {
    pub(super) name: String,
    pub(super) kind: AxisKind,
    pub(super) dir: Option<[f64; 3]>,
    /// Point of a rotary axis \[mm\].
    pub(super) point: Option<[f64; 3]>,
    /// Reason why the file does not state the point.
    pub(super) unknown_point: Option<String>,
    pub(super) sense: f64,
    /// Travel \[mm or deg\].
    pub(super) limits: Option<[f64; 2]>,
    pub(super) endless: bool,
    pub(super) home: Option<f64>,
    /// Velocity, acceleration and jerk \[mm or deg per s, s², s³\].
    pub(super) rates: [Option<f64>; 3],
}

/// Names of the rates.
pub(super) const RATES: [&str; 3] = ["vel", "acc", "jerk"];

impl AxisDraft {
    pub(super) fn new(name: &str, kind: AxisKind) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            dir: None,
            point: None,
            unknown_point: None,
            sense: 1.0,
            limits: None,
            endless: false,
            home: None,
            rates: [None; 3],
        }
    }

    pub(super) fn linear(name: &str, dir: [f64; 3]) -> Self {
        Self { dir: Some(dir), ..Self::new(name, AxisKind::Linear) }
    }

    pub(super) fn rotary(name: &str, dir: [f64; 3], point: Option<[f64; 3]>) -> Self {
        Self { dir: Some(dir), point, ..Self::new(name, AxisKind::Rotary) }
    }
}

/// A machine as far as it is stated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MachineDraft {
    pub(super) name: String,
    /// From `w` to `t`; `None` if the format does not state the order.
    pub(super) chain: Option<Vec<String>>,
    pub(super) tool_axis: [f64; 3],
    pub(super) gauge: [f64; 3],
    pub(super) axes: Vec<AxisDraft>,
    pub(super) dialect: ProgramFormat,
    pub(super) servo_period: Option<f64>,
    /// Statements that the format or its manual leaves open.
    pub(super) notes: Vec<String>,
}

impl MachineDraft {
    /// Starts with X, Y and Z along the machine frame.
    pub(super) fn new(name: &str, dialect: ProgramFormat) -> Self {
        let linear = [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])];
        Self {
            name: name.to_owned(),
            chain: None,
            tool_axis: [0.0, 0.0, 1.0],
            gauge: [0.0; 3],
            axes: linear.map(|(name, dir)| AxisDraft::linear(name, dir)).into(),
            dialect,
            servo_period: None,
            notes: Vec::new(),
        }
    }

    /// Sets the chain from its words.
    pub(super) fn set_chain(&mut self, words: &[&str]) {
        self.chain = Some(words.iter().map(|&word| word.to_owned()).collect());
    }
}

/// Returns the program format of a control with tool-centre-point control.
pub(super) fn tip_format(name: &str, interpolation: AxisInterpolation) -> ProgramFormat {
    ProgramFormat {
        name: name.to_owned(),
        interpolation,
        feed: FeedMode::Tip,
        strings: BTreeMap::new(),
    }
}
