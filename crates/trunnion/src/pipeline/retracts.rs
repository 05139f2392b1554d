//! Retracts for unwinding, as numbers and in words.

use super::job::Job;
use crate::axes::{FollowedPath, RetractMove};
use crate::files::summary::RetractSummary;
use crate::machine::{Axis, FIRST_ROTARY};
use crate::types::Schedule;

/// Returns one entry for each retract, in order.
pub(super) fn summaries(
    job: &Job,
    followed: &FollowedPath,
    schedule: &Schedule,
) -> Vec<RetractSummary> {
    followed.retracts.iter().map(|retract| summary(job, retract, schedule)).collect()
}

fn summary(job: &Job, retract: &RetractMove, schedule: &Schedule) -> RetractSummary {
    let pieces = schedule.pieces.get(retract.pieces.clone()).unwrap_or_default();
    // From the start of the first piece out of the part to the end of the last piece back.
    let ends = [
        pieces.first().and_then(|rows| rows.t.first()),
        pieces.last().and_then(|rows| rows.t.last()),
    ];
    let seconds = match ends {
        [Some(start), Some(end)] => end - start,
        _ => 0.0,
    };
    let axes = &job.kinematics.machine().axes;
    let [before, after]: [[f64; 2]; 2] = [retract.before.into(), retract.after.into()];
    let mut why = Vec::new();
    for (axis, [from, to]) in
        axes.iter().skip(FIRST_ROTARY).zip([0, 1].map(|at| [before[at], after[at]]))
    {
        // Less than a millionth of a degree is rounding.
        if (to - from).abs().to_degrees() > 1e-6 {
            why.push(describe_turn(axis, from, to));
        }
    }
    let tip = retract.pose.tip;
    RetractSummary {
        tip: [tip.x, tip.y, tip.z],
        in_cut: retract.in_cut,
        why: why.join("; "),
        seconds,
    }
}

/// Describes the turn of a rotary \[rad\], with the ends of its travel if it has some.
fn describe_turn(axis: &Axis, from: f64, to: f64) -> String {
    let turn = format!("{} from {:.4} to {:.4} deg", axis.name, from.to_degrees(), to.to_degrees());
    if !axis.limits.is_bounded() {
        return turn;
    }
    let [low, high] = axis.limits.ends().map(f64::to_degrees);
    format!("{turn}, travel [{low:.0}, {high:.0}]")
}

/// Describes a retract in a line of a program or a setup sheet.
pub(super) fn line(retract: &RetractSummary) -> String {
    let [x, y, z] = retract.tip;
    let place = if retract.in_cut { "in a pass" } else { "between two motions" };
    format!(
        "retract {place} at X {x:.3} Y {y:.3} Z {z:.3} of the part, unwind {}, back to the same point: {:.1} s",
        retract.why, retract.seconds
    )
}

/// Warns about all retracts together.
pub(super) fn warning(retracts: &[RetractSummary]) -> Option<String> {
    let first = retracts.first()?;
    let inside = retracts.iter().filter(|retract| retract.in_cut).count();
    let seconds: f64 = retracts.iter().map(|retract| retract.seconds).sum();
    let marks = if inside > 0 {
        ", which may leave a mark where the tool comes back; a turned setup may avoid it"
    } else {
        ""
    };
    let times = match retracts.len() {
        1 => "once".to_owned(),
        count => format!("{count} times"),
    };
    Some(format!(
        "a rotary axis comes to the end of its travel on the path, or has to turn while the tool stands: \
         the tool retracts and unwinds {times} in {seconds:.1} s, \
         {inside} of them inside a pass{marks}; the first: {}",
        line(first)
    ))
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn only_an_axis_with_ends_of_travel_has_them_named() {
        let text = include_str!("../../../../machines/bc-trunnion.toml");
        let machine = crate::files::machine::parse(text).unwrap().machine;
        let [.., c, b] = &machine.axes;
        assert_eq!(describe_turn(c, -std::f64::consts::PI, 0.0), "C from -180.0000 to 0.0000 deg");
        assert_eq!(
            describe_turn(b, 0.0, std::f64::consts::FRAC_PI_2),
            "B from 0.0000 to 90.0000 deg, travel [-35, 120]"
        );
    }
}
