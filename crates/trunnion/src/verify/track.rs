//! Where the tool goes, for pictures.

use super::replay::{self, Control, Course, Mover, Segment};
use super::{CHORD_SHARE, ClInput, Input, VerifyError};
use crate::math::angle::angle_between;
use crate::types::ToolPose;

/// Consecutive moves of one kind as a chain of tool positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Line of the first move.
    pub line: u32,
    /// Run at rapid speed.
    pub rapid: bool,
    /// Time \[s\] and tool, workpiece frame.
    pub poses: Vec<(f64, ToolPose)>,
}

/// Turn of the tool axis between two positions at most \[rad\].
const TURN: f64 = 0.1;
/// Positions within one move at most.
const MOST: f64 = 1000.0;

/// Tool positions of a program, at most `step` \[mm\] apart.
///
/// # Errors
///
/// [`VerifyError`].
pub fn track(input: &Input<'_>, step: f64) -> Result<Vec<Track>, VerifyError> {
    let control = Control::new(input)?;
    let segments = replay::replay(&control, input)?;
    tracks(&Mover::Machine(&control), &segments, step)
}

/// Tool positions of a CL file, at most `step` \[mm\] apart.
///
/// # Errors
///
/// [`VerifyError`].
pub fn track_cl(input: &ClInput<'_>, tolerance: f64, step: f64) -> Result<Vec<Track>, VerifyError> {
    let segments = replay::locations(input.file, CHORD_SHARE * tolerance)?;
    tracks(&Mover::Locations, &segments, step)
}

fn tracks(mover: &Mover<'_>, segments: &[Segment], step: f64) -> Result<Vec<Track>, VerifyError> {
    let mut tracks: Vec<Track> = Vec::new();
    let mut now = 0.0;
    for segment in segments {
        if !matches!(segment.course, Course::Rest) {
            let [from, to] = [mover.pose(segment, 0.0)?, mover.pose(segment, 1.0)?];
            let turn = angle_between(&from.axis, &to.axis) / TURN;
            let count = ((to.tip - from.tip).norm() / step).max(turn).ceil().clamp(1.0, MOST);
            let continued = tracks.last().is_some_and(|track| track.rapid == segment.rapid);
            if !continued {
                let poses = vec![(now, from)];
                tracks.push(Track { line: segment.line, rapid: segment.rapid, poses });
            }
            let Some(track) = tracks.last_mut() else { continue };
            let mut index = 1.0;
            while index <= count {
                let t = index / count;
                track.poses.push((now + t * segment.duration, mover.pose(segment, t)?));
                index += 1.0;
            }
        }
        now += segment.duration;
    }
    Ok(tracks)
}
