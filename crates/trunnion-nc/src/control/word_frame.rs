//! Coordinates that the words of a block count from.

use crate::read::Frame;
use crate::types::AxisVector;
use nalgebra::{Isometry3, Point3};

/// Tool-length compensation along Z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolLength {
    /// `G43`: words reach to the tool tip.
    Active,
    /// `G49`: words reach to the gauge point.
    Cancelled,
}

impl ToolLength {
    /// Returns the compensation in a work offset; `None` in machine coordinates, which know none.
    pub fn in_frame(frame: &Frame) -> Option<Self> {
        match frame {
            Frame::Machine => None,
            Frame::Work { length: true, .. } => Some(Self::Active),
            Frame::Work { length: false, .. } => Some(Self::Cancelled),
        }
    }

    /// Returns the length that is added to Z: that of the tool, or zero \[mm\].
    pub fn of(self, tool_length: f64) -> f64 {
        match self {
            Self::Active => tool_length,
            Self::Cancelled => 0.0,
        }
    }
}

/// Coordinates that the words of a block are.
#[derive(Debug, Clone, Copy)]
pub enum WordFrame {
    /// Axis positions, less these \[mm, rad\].
    Axes(AxisVector),
    /// The tool tip, and the rotary axes: tool-centre-point control.
    Tip(TipFrame),
}

/// Coordinates of the tool tip under tool-centre-point control.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipFrame {
    /// The point is the tip of the tool, or the gauge point.
    pub length: ToolLength,
    /// From the coordinates of X, Y, Z to the table frame; `None` where both are the same.
    pub table_from_words: Option<Isometry3<f64>>,
}

impl TipFrame {
    /// Returns the point of the table frame that words name \[mm\].
    pub fn to_table(&self, words: &Point3<f64>) -> Point3<f64> {
        self.table_from_words.map_or(*words, |frame| frame * words)
    }

    /// Returns the words that name a point of the table frame \[mm\].
    pub fn to_words(&self, point: &Point3<f64>) -> Point3<f64> {
        self.table_from_words.map_or(*point, |frame| frame.inverse_transform_point(point))
    }
}
