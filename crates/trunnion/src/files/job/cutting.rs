//! The job's `[cutting]`.

use super::data::{CuttingData, FeedReference};
use super::raw::{RawCutting, RawReference};
use std::f64::consts::TAU;

/// Converts feed and spindle to internal units.
pub(super) fn cutting(raw: &RawCutting) -> CuttingData {
    CuttingData {
        // mm/min and rev/min are the shop's units; inside, everything is per second.
        feed: raw.feed / 60.0,
        reference: match raw.reference {
            RawReference::Contact => FeedReference::Contact,
            RawReference::Tip => FeedReference::Tip,
        },
        spindle: raw.spindle * TAU / 60.0,
        coolant: raw.coolant,
    }
}
