//! One cutter location, for people and for scripts.

use super::args::{PositionArgs, PositionMethod};
use std::fmt::Write;
use trunnion::positioning::{ActiveConstraint, ContactSide, CutterLocation};

/// Cutter location for scripts; mm and degrees.
#[derive(Debug, serde::Serialize)]
pub(super) struct Answer {
    method: &'static str,
    strip_width: f64,
    chord_width: f64,
    offset: f64,
    offset_direction_deg: f64,
    rotation_deg: f64,
    center: [f64; 3],
    tip: [f64; 3],
    axis: [f64; 3],
    side: &'static str,
    contact_angles_deg: Vec<f64>,
    active: Vec<&'static str>,
    front_max: f64,
    front_max_bound: f64,
    front_min: f64,
    rear_min: f64,
    rear_min_bound: f64,
    queries: u32,
}

impl Answer {
    pub(super) fn new(location: &CutterLocation, method: PositionMethod) -> Self {
        Self {
            method: method.name(),
            strip_width: location.strip_width,
            chord_width: location.chord_width,
            offset: location.offset,
            offset_direction_deg: location.offset_direction.to_degrees(),
            rotation_deg: location.rotation.to_degrees(),
            center: location.center.coords.into(),
            tip: location.pose.tip.coords.into(),
            axis: location.pose.axis.into_inner().into(),
            side: side_name(location.side),
            contact_angles_deg: location.contact_angles.iter().map(|a| a.to_degrees()).collect(),
            active: location.active.iter().map(|active| words(*active).0).collect(),
            front_max: location.front_max,
            front_max_bound: location.front_max_bound,
            front_min: location.front_min,
            rear_min: location.rear_min,
            rear_min_bound: location.rear_min_bound,
            queries: location.queries,
        }
    }
}

pub(super) fn side_name(side: ContactSide) -> &'static str {
    match side {
        ContactSide::Ahead => "ahead",
        ContactSide::Behind => "behind",
        ContactSide::Either => "either",
    }
}

/// Returns the name of a constraint and its meaning in the shop.
pub(super) fn words(active: ActiveConstraint) -> (&'static str, &'static str) {
    match active {
        ActiveConstraint::Touch => ("touch", "the cutter touches inside the strip"),
        ActiveConstraint::Middle => ("middle", "the error reaches the tolerance inside the strip"),
        ActiveConstraint::FirstSlope => {
            ("first-slope", "the error would leave the band at the first end")
        }
        ActiveConstraint::SecondSlope => {
            ("second-slope", "the error would leave the band at the far end")
        }
        ActiveConstraint::Rear => {
            ("rear", "the rear of the cutter touches: a smaller R would reach farther")
        }
        ActiveConstraint::Disc => ("disc", "the flat underside touches"),
        ActiveConstraint::Chord => {
            ("chord", "the strip is as wide as the cutter: a larger R would give a wider strip")
        }
        ActiveConstraint::OffsetRange => {
            ("offset-range", "the range of the offset direction ends here")
        }
        ActiveConstraint::AxisTurn => ("axis-turn", "the tool axis may not turn farther"),
        ActiveConstraint::GivenLead => ("given-lead", "the lead was given, not found"),
        _ => ("other", "another condition of the search is met exactly"),
    }
}

pub(super) fn table(location: &CutterLocation, args: &PositionArgs) -> String {
    let triple = |x: [f64; 3]| format!("{:.4} {:.4} {:.4}", x[0], x[1], x[2]);
    let degrees: Vec<String> =
        location.contact_angles.iter().map(|a| format!("{:.2}", a.to_degrees())).collect();
    let mut rows = vec![
        (
            "strip width",
            format!("{:.4} mm (chord {:.4})", location.strip_width, location.chord_width),
        ),
        ("tip", format!("{} mm", triple(location.pose.tip.coords.into()))),
        ("tool axis", triple(location.pose.axis.into_inner().into())),
        ("circle centre", format!("{} mm", triple(location.center.coords.into()))),
        (
            "offset",
            format!(
                "{:.4} mm, {:.3} deg from across the feed",
                location.offset,
                location.offset_direction.to_degrees()
            ),
        ),
        ("rotation", format!("{:.3} deg", location.rotation.to_degrees())),
        ("contact arc", side_name(location.side).to_owned()),
        (
            "contacts",
            format!("{} deg along an arc of {:.2}", degrees.join(", "), location.arc.to_degrees()),
        ),
        (
            "strip error",
            format!(
                "{:.6} .. {:.6} mm, never above {:.6}; tolerance {}",
                location.front_min, location.front_max, location.front_max_bound, args.tolerance
            ),
        ),
        (
            "rear clearance",
            format!(
                "{:.6} mm, the whole cutter never below {:.6}",
                location.rear_min, location.rear_min_bound
            ),
        ),
        // Closest-point queries are the cost of the method, for comparisons.
        ("queries", location.queries.to_string()),
    ];
    // The constraints that bind show what would give a wider strip.
    rows.extend(location.active.iter().map(|active| {
        let (name, meaning) = words(*active);
        ("limited by", format!("{name}: {meaning}"))
    }));
    let mut text = format!("{} at (u, v) = ({}, {})\n", args.method.name(), args.at[0], args.at[1]);
    for (name, value) in rows {
        // Writing to a String does not fail.
        let _ = writeln!(text, "  {name:<16} {value}");
    }
    text
}
