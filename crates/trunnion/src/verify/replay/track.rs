//! Path of the tool, for pictures.

use crate::math::angle::angle_between;
use crate::types::ToolPose;
use crate::verify::error::VerifyError;
use crate::verify::input::CheckInput;
use crate::verify::options::CHORD_SHARE;
use crate::verify::replay::segment::{Course, Segment};
use crate::verify::replay::segments::Run;

/// Consecutive moves of one kind with one tool as a chain of tool positions.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Track {
    /// Line of the first move.
    pub line: u32,
    /// Run at rapid speed.
    pub rapid: bool,
    /// Place of the tool in the table, 0 without one.
    pub tool: usize,
    /// Tool positions in order.
    pub poses: Vec<TimedPose>,
}

/// Pose of the tool at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPose {
    /// Time from the start of the program \[s\].
    pub time: f64,
    /// Pose in the workpiece frame.
    pub pose: ToolPose,
}

/// Turn of the tool axis between two positions at most \[rad\].
const TURN: f64 = 0.1;
/// Positions within one move at most.
const MOST: f64 = 1000.0;
/// Positions in all, at first: a picture of some tens of megabytes.
const MOST_POSES: usize = 200_000;
/// Share of the step by which positions are thinned out first.
const FINEST: f64 = 0.125;

/// Returns the positions of the tool, at most `step` \[mm\] apart; of several hundred thousand, every other or fewer.
///
/// # Errors
///
/// [`VerifyError`].
pub fn track(input: &CheckInput<'_>, step: f64) -> Result<Vec<Track>, VerifyError> {
    let controls = input.controls()?;
    tracks(&input.run(controls.as_ref(), CHORD_SHARE * step)?, step)
}

fn tracks(run: &Run<'_>, step: f64) -> Result<Vec<Track>, VerifyError> {
    let mut drawing =
        Drawing { tracks: Vec::new(), count: 0, most: MOST_POSES, spacing: 0.0, broken: false };
    let mut now = 0.0;
    let mover = &run.mover;
    for segment in run.segments() {
        let segment = &segment?;
        if segment.is_unknown() {
            drawing.broken = true;
        } else if !matches!(segment.course, Course::Rest) {
            let [from, to] = [mover.pose(segment, 0.0)?, mover.pose(segment, 1.0)?];
            // As many positions as the longer of travel and turn asks for.
            let turn = angle_between(&from.axis, &to.axis) / TURN;
            let count = ((to.tip - from.tip).norm() / step).max(turn).ceil().clamp(1.0, MOST);
            let track = drawing.track(segment, TimedPose { time: now, pose: from });
            let mut index = 1.0;
            while index <= count {
                let t = index / count;
                let time = now + t * segment.duration;
                track.push(TimedPose { time, pose: mover.pose(segment, t)? });
                index += 1.0;
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            drawing.drawn(count as usize, step);
        }
        now += segment.duration;
    }
    Ok(drawing.tracks)
}

/// Tracks, with no more positions than a picture needs.
struct Drawing {
    tracks: Vec<Track>,
    /// Positions in all.
    count: usize,
    /// Positions at which they are thinned out next.
    most: usize,
    /// Length of the path between two positions at least \[mm\].
    spacing: f64,
    /// The next move does not begin where the last one ended.
    broken: bool,
}

impl Drawing {
    /// The poses to which a move is added that begins at `from`.
    fn track(&mut self, segment: &Segment, from: TimedPose) -> &mut Vec<TimedPose> {
        let Segment { line, rapid, tool, .. } = *segment;
        let broken = std::mem::take(&mut self.broken);
        let other = |track: &Track| track.rapid != rapid || track.tool != tool;
        if broken || self.tracks.last().is_none_or(other) {
            self.tracks.push(Track { line, rapid, tool, poses: vec![from] });
        }
        let last = self.tracks.len() - 1;
        &mut self.tracks[last].poses
    }

    /// Notes how many positions were added, and leaves some out where there are too many.
    fn drawn(&mut self, count: usize, step: f64) {
        self.count += count;
        if self.count <= self.most {
            return;
        }
        self.spacing = (2.0 * self.spacing).max(FINEST * step);
        self.tracks.iter_mut().for_each(|track| thin(&mut track.poses, self.spacing));
        self.count = self.tracks.iter().map(|track| track.poses.len()).sum();
        self.most = MOST_POSES.max(2 * self.count);
    }
}

/// Leaves out positions nearer to the last one than `spacing` \[mm\] along the path that turned little since; not
/// the first, nor the last.
fn thin(poses: &mut Vec<TimedPose>, spacing: f64) {
    let Some(&TimedPose { pose: first, .. }) = poses.first() else { return };
    let (mut kept, mut before, mut length, mut left) = (first, first, 0.0, poses.len());
    poses.retain(|TimedPose { pose, .. }| {
        length += (pose.tip - before.tip).norm();
        before = *pose;
        left -= 1;
        // The first and the last position, and every one that shows a turn, stay.
        let far = length >= spacing || angle_between(&kept.axis, &pose.axis) >= TURN;
        if far || left == 0 || pose == &first {
            (kept, length) = (*pose, 0.0);
            return true;
        }
        false
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn positions_close_together_are_left_out() {
        let pose = |x: f64| TimedPose {
            time: x,
            pose: ToolPose { tip: Point3::new(x, 0.0, 0.0), axis: Vector3::z_axis() },
        };
        let mut poses: Vec<_> = (0..=10).map(|k| pose(f64::from(k) * 0.1)).collect();
        thin(&mut poses, 0.35);
        let left: Vec<f64> = poses.iter().map(|at| (10.0 * at.time).round()).collect();
        assert_eq!(left, [0.0, 4.0, 8.0, 10.0]);
    }
}
