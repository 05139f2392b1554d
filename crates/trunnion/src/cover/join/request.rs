//! Input of joining: passes, options, and the reach and speed of the machine.

use super::axis_reach::AxisReach;
use super::hop::HopOptions;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::Pass;
use nalgebra::{Point3, UnitVector3};

/// Path by which the tool comes down to a pass and leaves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeadKind {
    /// Straight along the tool axis.
    Axis,
    /// First along the pass, carried on straight by `length` \[mm\], then along the tool axis.
    Tangent {
        /// Length by which the pass is carried on \[mm\].
        length: f64,
    },
}

/// Options of [`legs`](super::legs::legs). Begin with [`LinkOptions::above`] and change the rest by struct update.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkOptions {
    /// Direction out of the part: square to the plane of the links.
    pub up: UnitVector3<f64>,
    /// Boxes that hold part and stock, by low and high corner \[mm\].
    pub boxes: Vec<[Point3<f64>; 2]>,
    /// Clearance of links from part and stock \[mm\]. No part of the cutting end goes below the plane square to
    /// `up` that lies this much above the boxes, nor, on links round the part, below such a plane square to the
    /// tool axis.
    pub clearance: f64,
    /// Kind of lead.
    pub lead: LeadKind,
    /// Last part of a lead that is run at the cutting feed \[mm\]; what lies above counts as a link.
    /// If it is longer than the lead, all of the lead is run at the feed.
    pub approach: f64,
    /// Depth to which the cutter may go into a face during a lead or hop \[mm\]: the gouge tolerance, less the errors of
    /// what follows; a negative number is a distance that it keeps.
    pub gouge: f64,
}

impl LinkOptions {
    /// Links `clearance` \[mm\] above `boxes`, which hold part and stock.
    ///
    /// Presets: leads along the tool axis, all of them at the cutting feed, that do not go into a face.
    pub const fn above(up: UnitVector3<f64>, boxes: Vec<[Point3<f64>; 2]>, clearance: f64) -> Self {
        Self { up, boxes, clearance, lead: LeadKind::Axis, approach: f64::INFINITY, gouge: 0.0 }
    }
}

/// Passes to join, with the faces that the tool keeps off. Begin with [`LinkRequest::new`] and change the rest by
/// struct update.
#[derive(Debug, Clone, Copy)]
pub struct LinkRequest<'a> {
    /// Passes in cutting order.
    pub passes: &'a [Pass],
    /// All faces of the part.
    pub faces: &'a [FaceIndex],
    /// Cutter with shank and holder.
    pub cutter: &'a Cutter,
    /// Options of leads and links.
    pub options: &'a LinkOptions,
    /// Hops from pass to pass; `None` always goes up to the plane of the links.
    pub hops: Option<HopOptions<'a>>,
    /// Tool axes within reach on links round the part; `None` allows all.
    pub reach: Option<AxisReach<'a>>,
}

impl<'a> LinkRequest<'a> {
    /// Requests links without hops, for a machine that reaches every tool axis.
    pub fn new(
        passes: &'a [Pass],
        faces: &'a [FaceIndex],
        cutter: &'a Cutter,
        options: &'a LinkOptions,
    ) -> Self {
        Self { passes, faces, cutter, options, hops: None, reach: None }
    }
}
