//! The job's `[strategy]`.

use super::super::document::Document;
use super::super::path::join;
use super::data::{
    JobArea, JobContactSide, JobCutPattern, JobFeedDirection, JobLead, JobLinks, JobPlacement,
    JobPrismatic, JobStrategy, JobTool, ToolConstruction, ToolKind, ToolSide,
};
use super::raw::{RawAlong, RawDirection, RawLead, RawLinks, RawMethod, RawSide, RawStrategy};
use super::tool_side::kind_name;
use crate::math;
use crate::types::Interval;

/// Reads the strategy, if its entries agree with each other and with the tool.
pub(super) fn strategy(
    raw: &RawStrategy,
    tool: Option<&JobTool>,
    path: &str,
    doc: &mut Document<'_>,
) -> Option<JobStrategy> {
    let method = method(raw, tool, path, doc);
    let along = match raw.along {
        RawAlong::U => JobFeedDirection::U,
        RawAlong::V => JobFeedDirection::V,
        RawAlong::Curvature => JobFeedDirection::Curvature,
        RawAlong::Adaptive => JobFeedDirection::Adaptive,
    };
    if let Some([low, high]) = raw.offset_range
        && low >= high
    {
        let message = format!("offset_range [{low}, {high}] deg is empty");
        doc.fault(&join(path, "offset_range"), message, "the smaller angle comes first");
    }
    Some(JobStrategy {
        method: method?,
        prismatic: match raw.method {
            // Of a face that was not cut before, all is left.
            // Walls and floors take a straight flank and a flat end.
            RawMethod::Auto | RawMethod::Rest
                if tool.is_none_or(|tool| tool.side == ToolSide::Straight) =>
            {
                JobPrismatic::WallsAndFloors
            }
            RawMethod::Flank => JobPrismatic::Flank,
            _ => JobPrismatic::Never,
        },
        area: if raw.method == RawMethod::Rest { JobArea::Rest } else { JobArea::Whole },
        along,
        direction: match raw.direction {
            RawDirection::Zigzag => JobCutPattern::Zigzag,
            RawDirection::OneWay => JobCutPattern::OneWay,
        },
        side: match raw.side {
            RawSide::Ahead => JobContactSide::Ahead,
            RawSide::Behind => JobContactSide::Behind,
            RawSide::Either => JobContactSide::Either,
        },
        max_axis_turn: raw.max_axis_turn.to_radians(),
        turn_cost: raw.turn_cost,
        lead: match raw.lead {
            RawLead::Axis => JobLead::Axis,
            RawLead::Tangent => JobLead::Tangent,
        },
        links: match raw.links {
            RawLinks::Hop => JobLinks::Hop,
            RawLinks::Retract => JobLinks::Retract,
        },
        offset_range: raw.offset_range.map(|range| range.map(f64::to_radians).into()),
    })
}

/// Default lead angle of a ball \[deg\]: at its tip the cutting speed is zero.
const BALL_LEAD: f64 = 10.0;

/// Largest inclination of cutters other than balls \[deg\]: beyond, the flank comes down to the part.
const MOST_LEAN: f64 = 34.0;

/// Largest rotation of the strip's chord from across the feed \[deg\].
const MOST_TURN: f64 = 60.0;

fn method(
    raw: &RawStrategy,
    tool: Option<&JobTool>,
    path: &str,
    doc: &mut Document<'_>,
) -> Option<JobPlacement> {
    let angles = [("lead_angle", raw.lead_angle), ("tilt_angle", raw.tilt_angle)];
    let kind = tool.map(|tool| tool.kind);
    // The tip of a tapered cutter and the large arc of a lens are balls. A tool that could not be read is no reason for a
    // second fault here.
    let is_ball = |kind| matches!(kind, ToolKind::Ball | ToolKind::Taper | ToolKind::Lens);
    let ball = kind.is_none_or(is_ball);
    if raw.method == RawMethod::Flank
        && let Some(tool) = tool.filter(|tool| tool.side != ToolSide::Straight)
    {
        let message = format!(
            "method \"flank\" needs a tool with a straight side, not a {}",
            kind_name(tool.kind)
        );
        let help = "take `kind = \"flat\"`, \"ball\" or \"bull\", or another method";
        doc.fault(&join(path, "method"), message, help);
        return None;
    }
    let method = match raw.method {
        RawMethod::Auto | RawMethod::Rest if kind.is_some_and(is_ball) => RawMethod::Ball,
        // The flank places nothing by strips: their inclination does not matter.
        RawMethod::Auto | RawMethod::Rest | RawMethod::Flank => RawMethod::Widest,
        method => method,
    };
    if method == RawMethod::Widest {
        // The search owns the inclination: a fixed angle beside it would be ignored.
        for (key, _) in angles.iter().filter(|(_, angle)| angle.is_some()) {
            let help = format!("remove {key}, or write `method = \"fixed-tilt\"`");
            let message = "method \"widest\" finds the inclination of the tool itself";
            doc.fault(&join(path, key), message, &help);
        }
        return angles.iter().all(|(_, angle)| angle.is_none()).then_some(JobPlacement::Widest);
    }
    if method == RawMethod::Ball && !ball {
        let message = "method \"ball\" is for ball cutters";
        let help = "write `method = \"fixed-tilt\"` with lead_angle and tilt_angle, or `kind = \"ball\"` in [tool]";
        doc.fault(&join(path, "method"), message, help);
        return None;
    }
    if let Some(tool) = tool.filter(|tool| tool.is_barrel()) {
        return barrel(raw, tool, path, doc);
    }
    // Only a ball has a default: the lead of a bull decides which part of the corner cuts.
    let most = tool.map_or(90.0, |tool| tool.tip_angle().to_degrees());
    let usual = (method == RawMethod::Ball).then_some(BALL_LEAD.min(0.5 * most));
    if let (Some(usual), None, None) = (usual, raw.lead_angle, raw.tilt_angle) {
        return Some(JobPlacement::Leaning { angle: usual.to_radians() });
    }
    let Some(lead) = raw.lead_angle.or(usual) else {
        let message = "method \"fixed-tilt\" needs lead_angle";
        doc.fault(&join(path, "method"), message, "add `lead_angle = 5`, in degrees, for instance");
        return None;
    };
    let tilt = raw.tilt_angle.unwrap_or(0.0);
    // The axis leans along (tan lead, tan tilt) in the tangent plane of the surface.
    let [ahead, beside] = [lead, tilt].map(|angle| math::tan(angle.to_radians()));
    if !ball && math::atan2(beside.abs(), ahead) > MOST_TURN.to_radians() {
        refuse_tilt(lead, tilt, path, doc);
        return None;
    }
    // The inclination from the normal: tan² = tan² lead + tan² tilt.
    let angle = math::atan(math::hypot(ahead, beside)).to_degrees();
    if ball && angle > most {
        refuse_off_the_tip_arc([angle, most], path, doc);
        return None;
    }
    if !ball && angle > MOST_LEAN {
        let message = format!(
            "the tool would be inclined by {angle:.1} deg: only a ball may be by more than {MOST_LEAN} deg"
        );
        doc.fault(&join(path, "lead_angle"), message, "lower lead_angle and tilt_angle");
        return None;
    }
    Some(JobPlacement::Fixed { lead: lead.to_radians(), tilt: tilt.to_radians() })
}

/// Reads the fixed inclination of a barrel, which touches with its large arc: sideways, as far as that arc goes.
fn barrel(
    raw: &RawStrategy,
    tool: &JobTool,
    path: &str,
    doc: &mut Document<'_>,
) -> Option<JobPlacement> {
    let kind = kind_name(tool.kind);
    if let Some(lead) = raw.lead_angle.filter(|lead| lead.abs() > 0.0) {
        let message =
            format!("a {kind} tool cannot lead by {lead} deg: its arc lies across the feed");
        let help = "remove lead_angle; tilt_angle inclines the tool sideways";
        doc.fault(&join(path, "lead_angle"), message, help);
        return None;
    }
    let Interval { low, high } = tool.arc_inclinations();
    let [low, high] = [low, high].map(f64::to_degrees);
    let arc = format!("its large arc touches from {low:.2} to {high:.2} deg from the axis");
    let Some(tilt) = raw.tilt_angle else {
        let message = "method \"fixed-tilt\" needs tilt_angle with a barrel";
        let help = format!("add tilt_angle, or write `method = \"auto\"`: {arc}");
        doc.fault(&join(path, "method"), message, &help);
        return None;
    };
    if !(low..=high).contains(&tilt.abs()) {
        let message = format!("a {kind} tool cannot tilt by {tilt} deg: {arc}");
        let help = "keep tilt_angle between them, on either side, or write `method = \"auto\"`";
        doc.fault(&join(path, "tilt_angle"), message, help);
        return None;
    }
    Some(JobPlacement::Fixed { lead: 0.0, tilt: tilt.to_radians() })
}

/// Refuses an inclination at which the contact would leave the tip arc; both angles in degrees.
fn refuse_off_the_tip_arc([angle, most]: [f64; 2], path: &str, doc: &mut Document<'_>) {
    let message = format!(
        "the tool would be inclined by {angle:.2} deg: its tip arc ends at {most:.2} deg from the axis"
    );
    let help = format!("keep lead_angle and tilt_angle below {most:.2} deg");
    doc.fault(&join(path, "lead_angle"), message, &help);
}

/// Refuses a tilt angle, with the lead angle beside it, that turns the contact too far from the front; in degrees.
fn refuse_tilt(lead: f64, tilt: f64, path: &str, doc: &mut Document<'_>) {
    let ahead = math::tan(lead.to_radians());
    let message = format!(
        "only a ball can tilt by {tilt} deg with a lead of {lead} deg: other cutters cut with their front"
    );
    // atan2(tan tilt, tan lead) <= MOST_TURN solved for the tilt angle.
    let most = math::atan(ahead.max(0.0) * math::tan(MOST_TURN.to_radians())).to_degrees();
    let help = match lead {
        lead if lead > 0.0 => {
            format!("keep tilt_angle within {most:.1} deg, or raise lead_angle")
        }
        lead if lead < 0.0 => {
            "write a lead_angle above 0; `side = \"behind\"` cuts with the rear".to_owned()
        }
        _ => "write a lead_angle above 0".to_owned(),
    };
    doc.fault(&join(path, "tilt_angle"), message, &help);
}

/// Refuses contact behind the centre for a tool that does not cut at its centre.
pub(super) fn side_of(tool: &JobTool, strategy: &JobStrategy, path: &str, doc: &mut Document<'_>) {
    // With contact behind, the centre of the cutter passes over uncut material first.
    if strategy.side != JobContactSide::Ahead && tool.construction != ToolConstruction::Solid {
        let message = "a tool with inserts cannot cut behind its centre";
        let help = "write `side = \"ahead\"`, or use a tool with construction = \"solid\"";
        doc.fault(&join(path, "side"), message, help);
    }
}
