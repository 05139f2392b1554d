//! Stretches between links, and the ways the machine can run each.

use super::course::Along;
use super::march::{Marched, Marcher};
use super::strand::{self, Stretch};
use super::{AxesError, AxesOptions};
use crate::inverse::{InverseError, Solutions};
use crate::machine::FIRST_ROTARY;
use crate::math::angle::angle_between;
use crate::types::{
    AxisVector, Cancelled, Motion, PieceGeometry, PoseCurve, Progress, Stage, ToolPath, ToolPose,
};
use nalgebra::Point3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// What lies between two links.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stop {
    /// Curves that meet.
    Curves(Range<usize>),
    /// Only a pose, where two links meet or the path starts or ends with one.
    Point {
        /// Index of the link it belongs to.
        piece: usize,
        /// Where.
        pose: ToolPose,
    },
}

/// A link between two stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    pub(super) piece: usize,
    pub(super) motion: Motion,
    pub(super) tips: [Point3<f64>; 2],
}

/// One way to run a stop: a branch, followed by continuity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    /// Index of the tool-path piece it starts with.
    pub(super) piece: usize,
    /// Its curves in order; none for a point.
    pub(super) runs: Vec<Run>,
    /// Axes at a point.
    pub(super) stand: Option<AxisVector>,
    /// Rotaries at both ends \[rad\].
    pub(super) start: [f64; 2],
    pub(super) end: [f64; 2],
}

/// One curve, followed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// Index of the tool-path piece.
    pub(super) piece: usize,
    pub(super) motion: Motion,
    pub(super) marched: Marched,
    /// Whether the rotaries jump before it: only a retract can do that.
    pub(super) torn: bool,
}

/// Stops and the links between them: one link fewer than stops.
pub(super) fn split(
    path: &ToolPath,
    options: &AxesOptions,
) -> Result<(Vec<Stop>, Vec<Link>), AxesError> {
    meet(path, options)?;
    let mut stops = Vec::new();
    let mut links = Vec::new();
    let mut curves: Option<Range<usize>> = None;
    for (piece, tool) in path.pieces.iter().enumerate() {
        match &tool.geometry {
            PieceGeometry::Curve(_) => {
                curves = Some(curves.map_or(piece..piece + 1, |range| range.start..piece + 1));
            }
            PieceGeometry::Reorient { from, to } => {
                stops.push(curves.take().map_or(Stop::Point { piece, pose: *from }, Stop::Curves));
                links.push(Link { piece, motion: tool.motion, tips: [from.tip, to.tip] });
                let last = piece + 1 == path.pieces.len();
                if last {
                    stops.push(Stop::Point { piece, pose: *to });
                }
            }
        }
    }
    stops.extend(curves.map(Stop::Curves));
    Ok((stops, links))
}

/// Pieces end where the next one starts, within tolerance.
fn meet(path: &ToolPath, options: &AxesOptions) -> Result<(), AxesError> {
    for (before, pair) in path.pieces.windows(2).enumerate() {
        let [Some([_, end]), Some([start, _])] = [ends(&pair[0].geometry), ends(&pair[1].geometry)]
        else {
            continue; // A vanishing tool axis is reported with its place where it is followed.
        };
        let tip = (start.tip - end.tip).norm();
        let axis = angle_between(&start.axis, &end.axis);
        if tip > options.tip_tolerance || axis > options.axis_tolerance {
            return Err(AxesError::Gap { piece: before + 1, before, tip, axis });
        }
    }
    Ok(())
}

/// First and last pose.
fn ends(geometry: &PieceGeometry) -> Option<[ToolPose; 2]> {
    match geometry {
        PieceGeometry::Curve(curve) => {
            let [start, end] = curve.range();
            Some([curve.pose(start)?, curve.pose(end)?])
        }
        PieceGeometry::Reorient { from, to } => Some([*from, *to]),
    }
}

/// All ways to run each stop, travel not yet looked at.
pub(super) fn candidates(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    stops: &[Stop],
    progress: &dyn Progress,
) -> Result<Vec<Stretch>, AxesError> {
    let done = AtomicU64::new(0);
    let total = stops.len() as u64;
    let report = || -> Result<(), Cancelled> {
        progress.step(Stage::Axes, done.fetch_add(1, Ordering::Relaxed), total)
    };
    let mut all: Vec<Option<Vec<Candidate>>> = stops
        .par_iter()
        .map(|stop| {
            report()?;
            determined(marcher, path, stop)
        })
        .collect::<Result<_, AxesError>>()?;
    // Where the tool stays in the singular direction the first rotary may stand anywhere; what
    // can save travel is where the neighbours have it, or home.
    for index in 0..all.len() {
        if all.get(index).is_some_and(Option::is_none) {
            let values = held_values(marcher, &all, index);
            let found =
                stops.get(index).map(|stop| held(marcher, path, stop, &values)).transpose()?;
            if let Some(slot) = all.get_mut(index) {
                *slot = found;
            }
        }
    }
    let cut =
        |found: Option<Vec<Candidate>>| strand::stretch(found.unwrap_or_default(), marcher.options);
    Ok(all.into_par_iter().map(cut).collect())
}

/// Both branches of a stop; `None` if it lies in the singular direction altogether.
fn determined(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    stop: &Stop,
) -> Result<Option<Vec<Candidate>>, AxesError> {
    let starts = match stop {
        Stop::Point { piece, pose } => point_starts(marcher, *piece, pose)?,
        Stop::Curves(range) => curve_starts(marcher, path, range.clone())?,
    };
    starts.map(|starts| run_all(marcher, path, stop, &starts)).transpose()
}

/// A stop in the singular direction, with the first rotary at given values.
fn held(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    stop: &Stop,
    values: &[f64],
) -> Result<Vec<Candidate>, AxesError> {
    let mut start = AxisVector::zeros();
    let starts: Vec<AxisVector> = values
        .iter()
        .map(|&value| {
            start[FIRST_ROTARY] = value;
            start
        })
        .collect();
    run_all(marcher, path, stop, &starts)
}

/// Every start that can be followed; the first error if none can.
fn run_all(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    stop: &Stop,
    starts: &[AxisVector],
) -> Result<Vec<Candidate>, AxesError> {
    let all = match stop {
        Stop::Point { piece, pose } => {
            starts.iter().map(|start| stand(marcher, *piece, pose, start)).collect()
        }
        Stop::Curves(range) => run_curves(marcher, path, range.clone(), starts),
    };
    let mut found = Vec::new();
    let mut fault = None;
    for candidate in all {
        match candidate {
            Ok(candidate) => found.push(candidate),
            Err(error) => fault = fault.or(Some(error)),
        }
    }
    match fault {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found),
    }
}

/// Where the free rotary may stand: as at the nearest determined stops on both sides, and home and
/// quarter turns from it.
fn held_values(marcher: &Marcher<'_>, all: &[Option<Vec<Candidate>>], index: usize) -> Vec<f64> {
    let home = marcher.inverse.kinematics().machine().home()[FIRST_ROTARY];
    let before = all.iter().take(index).rev().flatten().next().into_iter().flatten();
    let after = all.iter().skip(index + 1).flatten().next().into_iter().flatten();
    let mut values: Vec<f64> =
        (0..4).map(|quarter| home + FRAC_PI_2 * f64::from(quarter)).collect();
    let ends = before.map(|candidate| candidate.end[0]);
    for value in ends.chain(after.map(|candidate| candidate.start[0])) {
        if values.iter().all(|other| other.to_bits() != value.to_bits()) {
            values.push(value);
        }
    }
    values
}

/// Rotaries of both branches at a pose; `None` in the singular direction.
fn point_starts(
    marcher: &Marcher<'_>,
    piece: usize,
    pose: &ToolPose,
) -> Result<Option<Vec<AxisVector>>, AxesError> {
    if marcher.inverse.second_at_pole(&pose.axis, marcher.pole()).is_some() {
        return Ok(None);
    }
    match marcher.inverse.solutions(pose) {
        Ok(Solutions::Regular(both)) => Ok(Some(both.to_vec())),
        Ok(Solutions::Singular(_)) => Ok(None),
        Err(source) => Err(AxesError::Inverse { piece, u: 0.0, source }),
    }
}

/// Rotaries of both branches at the first point of a stretch where the tool is not held in the
/// singular direction; `None` if there is none.
fn curve_starts(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    range: Range<usize>,
) -> Result<Option<Vec<AxisVector>>, AxesError> {
    for (piece, curve) in curves(path, range) {
        let along = marcher.along(curve);
        for (span, &u) in curve.knots.iter().enumerate().take(curve.spans.len()) {
            match both_at(&along, span, u) {
                Ok(starts) => return Ok(Some(starts)),
                Err(InverseError::Singular { .. }) => {}
                Err(source) => return Err(AxesError::Inverse { piece, u, source }),
            }
        }
    }
    Ok(None)
}

fn both_at(along: &Along<'_>, span: usize, u: f64) -> Result<Vec<AxisVector>, InverseError> {
    let rates = along.curve.rates_in(span, u);
    Ok(along.both(&rates)?.map(|way| way.q[0]).to_vec())
}

fn curves(path: &ToolPath, range: Range<usize>) -> impl Iterator<Item = (usize, &PoseCurve)> {
    let pieces = path.pieces.iter().enumerate().take(range.end).skip(range.start);
    pieces.filter_map(|(piece, tool)| match &tool.geometry {
        PieceGeometry::Curve(curve) => Some((piece, curve)),
        PieceGeometry::Reorient { .. } => None,
    })
}

/// A single pose with the rotaries nearest to `near`.
fn stand(
    marcher: &Marcher<'_>,
    piece: usize,
    pose: &ToolPose,
    near: &AxisVector,
) -> Result<Candidate, AxesError> {
    let q = marcher.inverse.near(pose, near).map_err(|source| AxesError::Inverse {
        piece,
        u: 0.0,
        source,
    })?;
    let rotaries = strand::rotaries(&q);
    Ok(Candidate { piece, runs: Vec::new(), stand: Some(q), start: rotaries, end: rotaries })
}

/// A stretch from each start, curve by curve.
fn run_curves(
    marcher: &Marcher<'_>,
    path: &ToolPath,
    range: Range<usize>,
    starts: &[AxisVector],
) -> Vec<Result<Candidate, AxesError>> {
    let nothing = || Candidate {
        piece: range.start,
        runs: Vec::new(),
        stand: None,
        start: [0.0; 2],
        end: [0.0; 2],
    };
    let mut all: Vec<Result<(AxisVector, Candidate), AxesError>> =
        starts.iter().map(|start| Ok((*start, nothing()))).collect();
    for (piece, curve) in curves(path, range.clone()) {
        let motion = path.pieces.get(piece).map_or(Motion::Cut, |tool| tool.motion);
        let near: Vec<AxisVector> = all.iter().flatten().map(|(near, _)| *near).collect();
        let on = all.iter_mut().filter(|slot| slot.is_ok());
        for (slot, marched) in on.zip(marcher.curve(curve, &near)) {
            let Ok((near, candidate)) = slot else { continue };
            let longer = marched.map_err(|trouble| trouble.of(piece)).and_then(|marched| {
                candidate.extend(Run { piece, motion, marched, torn: false }, near, marcher.options)
            });
            if let Err(error) = longer {
                *slot = Err(error);
            }
        }
    }
    all.into_iter().map(|slot| slot.map(|(_, candidate)| candidate)).collect()
}

impl Candidate {
    /// One more curve, which starts where the axes are `near`, and ends where that then is.
    fn extend(
        &mut self,
        mut run: Run,
        near: &mut AxisVector,
        options: &AxesOptions,
    ) -> Result<(), AxesError> {
        let (Some(first), Some(last)) = (run.marched.nodes.first(), run.marched.nodes.last())
        else {
            return Ok(());
        };
        let [from, to] = [first, last].map(|node| strand::rotaries(&node.q[0]));
        *near = last.q[0];
        if self.runs.is_empty() {
            (self.piece, self.start, self.end) = (run.piece, from, from);
        }
        let turn = (from[0] - self.end[0]).abs().max((from[1] - self.end[1]).abs());
        run.torn = turn > options.axis_tolerance;
        if run.torn && options.retract.is_none() {
            let piece = run.piece;
            return Err(AxesError::TurnAtRest { piece, before: piece.saturating_sub(1), turn });
        }
        self.end = to;
        self.runs.push(run);
        Ok(())
    }
}
