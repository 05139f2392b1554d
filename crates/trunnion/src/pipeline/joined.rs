//! Numbers of several operations as those of one job.

use crate::files::summary::{
    AxisSummary, CoverSummary, MotionSummary, OperationSummary, SingularSummary,
};

/// Returns the passes of all operations together; what is left is not theirs to state.
pub(super) fn cover(operations: &[OperationSummary]) -> CoverSummary {
    let covers = || operations.iter().map(|one| &one.cover);
    let stations = |cover: &CoverSummary| cover.stations as f64;
    let all: f64 = covers().map(stations).sum();
    // The mean width is that of all stations.
    let mean = covers().map(|cover| cover.strip_width[1] * stations(cover)).sum::<f64>();
    let mut faces: Vec<usize> = Vec::new();
    let mut along: Vec<String> = Vec::new();
    for (face, way) in covers().flat_map(|cover| cover.faces.iter().zip(&cover.along)) {
        // A face keeps the layout of the first operation that cuts it.
        if !faces.contains(face) {
            faces.push(*face);
            along.push(way.clone());
        }
    }
    CoverSummary {
        faces,
        along,
        passes: covers().map(|cover| cover.passes).sum(),
        stations: covers().map(|cover| cover.stations).sum(),
        cutting_length: covers().map(|cover| cover.cutting_length).sum(),
        strip_width: [
            covers().map(|cover| cover.strip_width[0]).fold(f64::INFINITY, f64::min),
            mean / all.max(1.0),
            covers().map(|cover| cover.strip_width[2]).fold(0.0, f64::max),
        ],
        turn_limit: covers().find_map(|cover| cover.turn_limit),
        area: covers().map(|cover| cover.area).sum(),
        layouts: covers().flat_map(|cover| cover.layouts.iter().cloned()).collect(),
        fixed: covers().flat_map(|cover| cover.fixed.iter().cloned()).collect(),
        rest: Vec::new(),
    }
}

/// Returns the motion of all operations together; `None` without any.
pub(super) fn motion(operations: &[OperationSummary]) -> Option<MotionSummary> {
    let motions = operations.iter().map(|one| one.motion.clone());
    motions.reduce(|before, next| MotionSummary {
        duration: before.duration + next.duration,
        cutting: before.cutting + next.cutting,
        lower_bound: before.lower_bound + next.lower_bound,
        jerk_ratio: before.jerk_ratio.zip(next.jerk_ratio).map(|(a, b)| a.max(b)),
        axes: before.axes.iter().zip(&next.axes).map(|(a, b)| axis(a, b)).collect(),
        retracts: [before.retracts, next.retracts].concat(),
        singular: match (before.singular, next.singular) {
            (Some(a), Some(b)) => Some(singular(a, b)),
            (a, b) => a.or(b),
        },
        ..before
    })
}

fn axis(a: &AxisSummary, b: &AxisSummary) -> AxisSummary {
    AxisSummary {
        range: [a.range[0].min(b.range[0]), a.range[1].max(b.range[1])],
        velocity_ratio: a.velocity_ratio.max(b.velocity_ratio),
        acceleration_ratio: a.acceleration_ratio.max(b.acceleration_ratio),
        ..a.clone()
    }
}

fn singular(a: SingularSummary, b: SingularSummary) -> SingularSummary {
    SingularSummary {
        passages: a.passages + b.passages,
        through: a.through + b.through,
        tilt: a.tilt.max(b.tilt),
        turn_saved: a.turn_saved + b.turn_saved,
        seconds_saved: a.seconds_saved + b.seconds_saved,
    }
}
