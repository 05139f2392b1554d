//! Segments between links, and the candidate motions of each.

use super::branch_run::{self, PathSegment};
use super::candidate::{CandidateRun, CurveRun, rotaries};
use super::error::AxesError;
use super::follower::PathFollower;
use super::options::AxesOptions;
use super::path_motion::CurveMotion;
use crate::inverse::{InverseError, InverseSolutions};
use crate::machine::FIRST_ROTARY;
use crate::math::angle::angle_between;
use crate::types::Interval;
use crate::types::{
    AxisVector, Cancelled, Motion, PieceGeometry, PoseCurve, Progress, Stage, ToolPath, ToolPose,
};
use nalgebra::Point3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Shape of the path between two links.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SegmentShape {
    /// Curves that meet.
    Curves(Range<usize>),
    /// Only a pose, where two links meet or the path starts or ends with one.
    Point {
        /// Index of the link it belongs to.
        piece: usize,
        /// The pose.
        pose: ToolPose,
    },
}

/// A link between two shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LinkMove {
    pub(super) piece: usize,
    pub(super) motion: Motion,
    pub(super) tips: [Point3<f64>; 2],
}

/// Splits a tool path at its links: one link fewer than shapes.
pub(super) fn split(
    path: &ToolPath,
    options: &AxesOptions,
) -> Result<(Vec<SegmentShape>, Vec<LinkMove>), AxesError> {
    meet(path, options)?;
    let mut shapes = Vec::new();
    let mut links = Vec::new();
    let mut curves: Option<Range<usize>> = None;
    for (piece, tool) in path.pieces.iter().enumerate() {
        match &tool.geometry {
            // Curves without a link in between belong to one segment.
            PieceGeometry::Curve(_) => {
                curves = Some(curves.map_or(piece..piece + 1, |range| range.start..piece + 1));
            }
            PieceGeometry::Reorient { from, to } => {
                // A link at the start, or after another link, begins at a single pose.
                shapes.push(
                    curves
                        .take()
                        .map_or(SegmentShape::Point { piece, pose: *from }, SegmentShape::Curves),
                );
                links.push(LinkMove { piece, motion: tool.motion, tips: [from.tip, to.tip] });
                let last = piece + 1 == path.pieces.len();
                if last {
                    shapes.push(SegmentShape::Point { piece, pose: *to });
                }
            }
        }
    }
    shapes.extend(curves.map(SegmentShape::Curves));
    Ok((shapes, links))
}

/// Checks that pieces end where the next one starts, within tolerance.
fn meet(path: &ToolPath, options: &AxesOptions) -> Result<(), AxesError> {
    for (before, pair) in path.pieces.windows(2).enumerate() {
        let [Some([_, end]), Some([start, _])] = [ends(&pair[0].geometry), ends(&pair[1].geometry)]
        else {
            continue; // A vanishing tool axis is reported with its parameter where it is followed.
        };
        let tip = (start.tip - end.tip).norm();
        let axis = angle_between(&start.axis, &end.axis);
        if tip > options.tolerance.tip || axis > options.tolerance.axis {
            return Err(AxesError::Gap { piece: before + 1, before, tip, axis });
        }
    }
    Ok(())
}

/// Returns the first and last pose; `None` if the tool axis vanishes there.
fn ends(geometry: &PieceGeometry) -> Option<[ToolPose; 2]> {
    match geometry {
        PieceGeometry::Curve(curve) => {
            let Interval { low: start, high: end } = curve.range();
            Some([curve.pose(start)?, curve.pose(end)?])
        }
        PieceGeometry::Reorient { from, to } => Some([*from, *to]),
    }
}

/// Returns all candidates of each shape; travel is not checked yet.
pub(super) fn candidates(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    shapes: &[SegmentShape],
    progress: &dyn Progress,
) -> Result<Vec<PathSegment>, AxesError> {
    let done = AtomicU64::new(0);
    let total = shapes.len() as u64;
    let report = || -> Result<(), Cancelled> {
        progress.step(Stage::Axes, done.fetch_add(1, Ordering::Relaxed), total)
    };
    let mut all: Vec<Option<Vec<CandidateRun>>> = shapes
        .par_iter()
        .map(|shape| {
            report()?;
            determined(follower, path, shape)
        })
        .collect::<Result<_, AxesError>>()?;
    // Where the tool stays in the singular direction the first rotary may take any angle. Rotary travel
    // is least where it keeps the angle of a neighbour, or home.
    for index in 0..all.len() {
        if all.get(index).is_some_and(Option::is_none) {
            let values = held_values(follower, &all, index);
            let found =
                shapes.get(index).map(|shape| held(follower, path, shape, &values)).transpose()?;
            if let Some(slot) = all.get_mut(index) {
                *slot = found;
            }
        }
    }
    let cut = |found: Option<Vec<CandidateRun>>| {
        branch_run::segment(found.unwrap_or_default(), follower.options)
    };
    Ok(all.into_par_iter().map(cut).collect())
}

/// Follows both branches of a shape; `None` if it lies in the singular direction altogether.
fn determined(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    shape: &SegmentShape,
) -> Result<Option<Vec<CandidateRun>>, AxesError> {
    let starts = match shape {
        SegmentShape::Point { piece, pose } => point_starts(follower, *piece, pose)?,
        SegmentShape::Curves(range) => curve_starts(follower, path, range.clone())?,
    };
    starts.map(|starts| run_all(follower, path, shape, &starts)).transpose()
}

/// Follows a shape in the singular direction, with the first rotary at given values \[rad\].
fn held(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    shape: &SegmentShape,
    values: &[f64],
) -> Result<Vec<CandidateRun>, AxesError> {
    let mut start = AxisVector::zeros();
    let starts: Vec<AxisVector> = values
        .iter()
        .map(|&value| {
            start[FIRST_ROTARY] = value;
            start
        })
        .collect();
    run_all(follower, path, shape, &starts)
}

/// Follows a shape from every start that allows it; the first error if none does.
fn run_all(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    shape: &SegmentShape,
    starts: &[AxisVector],
) -> Result<Vec<CandidateRun>, AxesError> {
    let all = match shape {
        SegmentShape::Point { piece, pose } => {
            starts.iter().map(|start| run_point(follower, *piece, pose, start)).collect()
        }
        SegmentShape::Curves(range) => run_curves(follower, path, range.clone(), starts),
    };
    // One branch may leave reach where the other goes on: only if none is left it is an error.
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

/// Returns angles for the free rotary: those of the nearest determined shapes on both sides, home, and
/// quarter turns from it.
fn held_values(
    follower: &PathFollower<'_>,
    all: &[Option<Vec<CandidateRun>>],
    index: usize,
) -> Vec<f64> {
    let home = follower.inverse.kinematics().machine().home()[FIRST_ROTARY];
    let before = all.iter().take(index).rev().flatten().next().into_iter().flatten();
    let after = all.iter().skip(index + 1).flatten().next().into_iter().flatten();
    let mut values: Vec<f64> =
        (0..4).map(|quarter| home + FRAC_PI_2 * f64::from(quarter)).collect();
    // Where the rotary keeps the angle of a neighbour the link to it does not turn it.
    let ends = before.map(|candidate| candidate.end[0]);
    for value in ends.chain(after.map(|candidate| candidate.start[0])) {
        if values.iter().all(|other| other.to_bits() != value.to_bits()) {
            values.push(value);
        }
    }
    values
}

/// Returns the axes of both branches at a pose; `None` in the singular direction.
fn point_starts(
    follower: &PathFollower<'_>,
    piece: usize,
    pose: &ToolPose,
) -> Result<Option<Vec<AxisVector>>, AxesError> {
    // Within the cone of the follower a pose counts as singular, so that curves and points agree.
    if follower.inverse.second_at_pole(&pose.axis, follower.pole()).is_some() {
        return Ok(None);
    }
    match follower.inverse.solutions(pose) {
        Ok(InverseSolutions::Regular(both)) => Ok(Some(both.to_vec())),
        Ok(InverseSolutions::Singular(_)) => Ok(None),
        Err(source) => Err(AxesError::Inverse { piece, u: 0.0, source }),
    }
}

/// Returns the axes of both branches at the first knot of a segment where the tool does not stay in the
/// singular direction; `None` if there is none.
fn curve_starts(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    range: Range<usize>,
) -> Result<Option<Vec<AxisVector>>, AxesError> {
    for (piece, curve) in curves(path, range) {
        let along = follower.along(curve);
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

fn both_at(along: &CurveMotion<'_>, span: usize, u: f64) -> Result<Vec<AxisVector>, InverseError> {
    let rates = along.curve.rates_in(span, u);
    Ok(along.both(&rates)?.map(|jets| jets.q[0]).to_vec())
}

fn curves(path: &ToolPath, range: Range<usize>) -> impl Iterator<Item = (usize, &PoseCurve)> {
    let pieces = path.pieces.iter().enumerate().take(range.end).skip(range.start);
    pieces.filter_map(|(piece, tool)| match &tool.geometry {
        PieceGeometry::Curve(curve) => Some((piece, curve)),
        PieceGeometry::Reorient { .. } => None,
    })
}

/// Makes the candidate of a single pose, with the rotaries nearest to `near`.
fn run_point(
    follower: &PathFollower<'_>,
    piece: usize,
    pose: &ToolPose,
    near: &AxisVector,
) -> Result<CandidateRun, AxesError> {
    let q = follower.inverse.near(pose, near).map_err(|source| AxesError::Inverse {
        piece,
        u: 0.0,
        source,
    })?;
    let rotaries = rotaries(&q);
    Ok(CandidateRun {
        piece,
        runs: Vec::new(),
        point_axes: Some(q),
        start: rotaries,
        end: rotaries,
    })
}

/// Follows a segment from each start, curve by curve.
fn run_curves(
    follower: &PathFollower<'_>,
    path: &ToolPath,
    range: Range<usize>,
    starts: &[AxisVector],
) -> Vec<Result<CandidateRun, AxesError>> {
    let nothing = || CandidateRun {
        piece: range.start,
        runs: Vec::new(),
        point_axes: None,
        start: [0.0; 2],
        end: [0.0; 2],
    };
    let mut all: Vec<Result<(AxisVector, CandidateRun), AxesError>> =
        starts.iter().map(|start| Ok((*start, nothing()))).collect();
    for (piece, curve) in curves(path, range.clone()) {
        let motion = path.pieces.get(piece).map_or(Motion::Cut, |tool| tool.motion);
        // Starts that failed on an earlier curve drop out; the others share the kinematics of this one.
        let near: Vec<AxisVector> = all.iter().flatten().map(|(near, _)| *near).collect();
        let on = all.iter_mut().filter(|slot| slot.is_ok());
        for (slot, track) in on.zip(follower.curve(curve, &near)) {
            let Ok((near, candidate)) = slot else { continue };
            let longer = track.map_err(|trouble| trouble.of(piece)).and_then(|track| {
                candidate.extend(
                    CurveRun { piece, motion, track, jumps: false },
                    near,
                    follower.options,
                )
            });
            if let Err(error) = longer {
                *slot = Err(error);
            }
        }
    }
    all.into_iter().map(|slot| slot.map(|(_, candidate)| candidate)).collect()
}
