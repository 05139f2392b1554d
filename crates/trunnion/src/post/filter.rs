//! Smooths moves, or leaves moves out, before they are posted; both within a tolerance of the input.

use super::constants::LEVER;
use super::error::PostError;
use super::options::{PostFilter, PostMove, PostPace, PostSource};
use super::smoothing::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS};
use crate::blocks::{BlockEnd, BlockInterpolation, bend, moved};
use crate::math::angle::{angle_between, great_circle};
use crate::toolpath::{
    PathSmoother, SmoothError, SmoothOptions, SmoothReference, SmoothReport, SmoothSpan,
};
use crate::types::{Station, ToolPose};
use std::collections::VecDeque;

/// Shares of the tolerance for the filter itself, for the chords of a smoothed path, and for the bows of the input.
///
/// About 25 splits were tried, at two tolerances each, on a program with long chords, one with very short chords and a
/// waved part. This split took the least time within the limits of the axes: the looser the path, the less it turns,
/// and the remaining share makes chords fine only where rotaries turn fast.
const SMOOTH: [f64; 3] = [0.8, 0.15, 0.01];

/// Shares for a control that moves the axes linearly: the bow of the tip needs a share, and nearly uses it up where
/// blocks are few.
const SMOOTH_AXES: [f64; 3] = [0.5, 0.1, 0.02];

/// Shares where moves are left out: the remainder lets the planner round the corners, which are sharper.
const REDUCE: [f64; 3] = [0.5, 0.0, 0.05];

impl PostFilter {
    fn shares(self, control: BlockInterpolation) -> [f64; 3] {
        match (self, control) {
            (Self::None, _) => [0.0; 3],
            (Self::Smooth, BlockInterpolation::Axes) => SMOOTH_AXES,
            (Self::Smooth, _) => SMOOTH,
            (Self::Reduce, _) => REDUCE,
        }
    }

    /// Returns the share of the tolerance that remains for the conversion to the machine.
    pub(super) fn left(self, control: BlockInterpolation) -> f64 {
        1.0 - self.shares(control).iter().sum::<f64>()
    }
}

/// Most moves that one move replaces.
const MOST: usize = 256;

/// Filter between the input and the poster.
#[derive(Debug)]
pub(super) struct MoveFilter {
    kind: PostFilter,
    shares: [f64; 3],
    source: PostSource,
    tolerance: [f64; 2],
    last: Option<PostMove>,
    run: Option<SmoothedRun>,
    /// Moves that one move may replace.
    chain: Vec<PostMove>,
    start: Option<PostMove>,
    report: SmoothReport,
    /// Largest deviations of the reduction.
    reduced: [f64; 2],
}

/// Moves with feed between two rapid moves, being smoothed.
#[derive(Debug)]
struct SmoothedRun {
    smoother: Box<PathSmoother>,
    /// Feeds, each from a path length \[mm\] on.
    feeds: VecDeque<(f64, f64)>,
    last: PostMove,
}

/// Share of a chord that may reach into the next move, since path lengths are rounded sums.
const SLIVER: f64 = 1e-6;

impl SmoothedRun {
    /// Returns the feed of a part of the path. Parts come in order: earlier feeds are dropped.
    fn feed(&mut self, [from, to]: [f64; 2]) -> f64 {
        // Feeds that end before this part, but for the rounding of path lengths, are over.
        let sliver = SLIVER * (to - from);
        while self.feeds.get(1).is_some_and(|(next, _)| *next <= from + sliver) {
            self.feeds.pop_front();
        }
        // Each feed holds up to where the next one starts; its share of the part is the overlap.
        let ends = self.feeds.iter().skip(1).map(|(start, _)| *start).chain([f64::INFINITY]);
        let parts = self.feeds.iter().zip(ends);
        let inside = parts.take_while(|((start, _), _)| *start < to - sliver);
        common_feed(
            inside.map(|((start, feed), end)| ((end.min(to) - start.max(from)).max(0.0), *feed)),
        )
    }
}

/// Largest ratio of feeds that count as equal: the words of the program only round them differently.
const ALIKE: f64 = 1.05;

/// Moves shorter than this share of a chord do not decide its feed.
const SHORT: f64 = 0.05;

/// Returns the feed of a chord that replaces moves with these lengths \[mm\] and feeds.
///
/// Feeds that are alike give the one that takes as long as the moves did; otherwise the slowest feed is taken.
fn common_feed(parts: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let (length, time) = parts
        .clone()
        .fold((0.0, 0.0), |(length, time), (part, feed)| (length + part, time + part / feed));
    // The feed that takes as long as the moves did: total length over total time.
    let mean = length / time;
    let long = parts.filter(|(part, _)| *part >= SHORT * length).map(|(_, feed)| feed);
    let least = long.fold(f64::INFINITY, f64::min);
    if mean <= ALIKE * least { mean } else { least }
}

impl MoveFilter {
    /// Creates a filter; `control` is that of the target.
    pub(super) fn new(
        kind: PostFilter,
        control: BlockInterpolation,
        source: PostSource,
        tolerance: [f64; 2],
    ) -> Self {
        Self {
            kind,
            shares: kind.shares(control),
            source,
            tolerance,
            last: None,
            run: None,
            chain: Vec::new(),
            start: None,
            report: SmoothReport::default(),
            reduced: [0.0; 2],
        }
    }

    /// Bounds the deviation of the filtered moves: tip \[mm\], axis \[rad\].
    pub(super) fn strayed(&self) -> [f64; 2] {
        let [_, chords, bows] = self.shares;
        let share = chords + bows;
        match self.kind {
            PostFilter::None => [0.0; 2],
            PostFilter::Smooth => {
                let most = &self.report.deviated;
                [
                    most.tip_bound + share * self.tolerance[0],
                    most.axis_bound + share * self.tolerance[1],
                ]
            }
            PostFilter::Reduce => {
                [0, 1].map(|k: usize| self.reduced[k] + share * self.tolerance[k])
            }
        }
    }

    /// Starts the next move at the end of this one, which is not handed out.
    pub(super) fn start_at(&mut self, one: &PostMove) {
        self.last = Some(*one);
        self.start = Some(*one);
    }

    /// Takes in a move, and appends the moves to post.
    pub(super) fn push(
        &mut self,
        one: &PostMove,
        out: &mut Vec<PostMove>,
    ) -> Result<(), PostError> {
        let Some(before) = self.last.replace(*one) else {
            out.push(*one);
            self.start = Some(*one);
            return Ok(());
        };
        // A move that keeps the tip in place has no feed, and ends a path just as a rapid move does.
        let length = (one.pose.tip - before.pose.tip).norm();
        let feed = match one.pace {
            PostPace::Feed(feed) => Some(feed),
            PostPace::Seconds(seconds) if length > 0.0 => Some(length / seconds),
            _ => None,
        };
        let Some(feed) = feed.filter(|_| self.kind != PostFilter::None) else {
            self.finish(out)?;
            out.push(*one);
            self.start = Some(*one);
            return Ok(());
        };
        // The filters work on straight chords; a move that bows is divided into such chords first.
        for part in self.chords(&before, one, feed)? {
            match self.kind {
                PostFilter::Smooth => self.smooth(&part, feed, out)?,
                _ => self.reduce(&part, out),
            }
        }
        Ok(())
    }

    /// Ends the moves between two rapid moves.
    pub(super) fn finish(&mut self, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        if let Some(run) = self.run.take() {
            self.end(run, out)?;
        }
        self.hand_out(out);
        Ok(())
    }

    /// Divides a move into straight ones with the tool on great circles, within a small share of the tolerance.
    fn chords(
        &self,
        from: &PostMove,
        to: &PostMove,
        feed: f64,
    ) -> Result<Vec<PostMove>, PostError> {
        let plain = |pose: ToolPose| PostMove {
            pose,
            q: None,
            way: BlockInterpolation::GreatCircle,
            pace: PostPace::Feed(feed),
            ..*to
        };
        let ends = match (&self.source, from.q, to.q) {
            (PostSource::Program(kinematics), Some(a), Some(b))
                if to.way != BlockInterpolation::GreatCircle =>
            {
                (kinematics, a, b)
            }
            _ => return Ok(vec![plain(to.pose)]),
        };
        let (kinematics, a, b) = ends;
        let pair = [BlockEnd::new(&a, &from.pose), BlockEnd::new(&b, &to.pose)];
        // A chord is off its arc by at most an eighth of the second derivative times the step squared. The
        // axis of the chord turns on a great circle, which itself bends by the square of its turn.
        let [tip, axis] = bend(kinematics, to.way, pair);
        let turn = angle_between(&from.pose.axis, &to.pose.axis);
        let [.., share] = self.shares;
        let [most_tip, most_axis] = self.tolerance.map(|most| share * most);
        let excess = (tip / most_tip).max((axis + turn * turn) / most_axis);
        // Equal parts shrink that bound by the square of their number.
        let parts = (0.125 * excess).sqrt().ceil().clamp(1.0, 4096.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts as u32;
        let mut chords = Vec::new();
        for part in 1..parts {
            let share = f64::from(part) / f64::from(parts);
            let pose = moved(kinematics, to.way, pair, share);
            chords.push(plain(pose.ok_or(PostError::Reversal { line: to.line })?));
        }
        chords.push(plain(to.pose));
        Ok(chords)
    }

    /// Adds a chord to the smoother, and appends the moves whose path is final.
    fn smooth(
        &mut self,
        one: &PostMove,
        feed: f64,
        out: &mut Vec<PostMove>,
    ) -> Result<(), PostError> {
        let mut run = match self.run.take() {
            Some(run) => run,
            None => self.begin(one)?,
        };
        let at_line = |error: SmoothError| smoothing(&error, one.line);
        // Feeds are kept by path length, because chords of the smoothed path fall across move ends.
        if run.feeds.back().is_none_or(|(_, last)| last.total_cmp(&feed).is_ne()) {
            run.feeds.push_back((run.smoother.along(), feed));
        }
        run.smoother.push(&station(&one.pose)).map_err(at_line)?;
        run.last = *one;
        // Spans are final once later stations cannot move them any more.
        for span in &run.smoother.take() {
            self.cut(&mut run, span, out);
        }
        self.run = Some(run);
        Ok(())
    }

    /// Starts a smoother at the end of the move before.
    fn begin(&self, one: &PostMove) -> Result<SmoothedRun, PostError> {
        let [tip, axis] = self.tolerance.map(|most| self.shares[0] * most);
        let options = SmoothOptions {
            tip,
            axis,
            reference: SmoothReference::Chords,
            lever: LEVER,
            corner: CORNER,
            step_ratio: STEP_RATIO,
            largest_blend: LARGEST_BLEND,
            window: WINDOW_STATIONS,
        };
        let at_line = |error: SmoothError| smoothing(&error, one.line);
        let mut smoother = PathSmoother::new(&options).map_err(at_line)?;
        if let Some(start) = &self.start {
            smoother.push(&station(&start.pose)).map_err(at_line)?;
        }
        Ok(SmoothedRun { smoother: Box::new(smoother), feeds: VecDeque::new(), last: *one })
    }

    /// Finishes a smoother, and appends its last moves.
    fn end(&mut self, mut run: SmoothedRun, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        let last = run.last;
        let smoother = std::mem::replace(&mut run.smoother, self.begin(&last)?.smoother);
        match smoother.finish() {
            Ok((spans, report)) => {
                self.report.add(&report);
                for span in &spans {
                    self.cut(&mut run, span, out);
                }
            }
            // Too few stations to smooth: all of them are within a small part of the tolerance of the last.
            Err(SmoothError::Stations(_)) => out.push(last),
            Err(error) => return Err(smoothing(&error, last.line)),
        }
        self.start = Some(last);
        Ok(())
    }

    /// Appends the chords of a span, each at the feed of the moves it replaces.
    fn cut(&self, run: &mut SmoothedRun, span: &SmoothSpan, out: &mut Vec<PostMove>) {
        // Chords of a span have their own share of the tolerance beside that of the smoothing.
        let parts = span.chords(self.tolerance.map(|most| self.shares[1] * most).into());
        let start = span.range.low;
        let width = span.range.width() / f64::from(parts);
        for part in 1..=parts {
            let to = start + width * f64::from(part);
            let pace = PostPace::Feed(run.feed([to - width, to]));
            if let Some(pose) = span.pose(f64::from(part) / f64::from(parts)) {
                out.push(PostMove { pose, pace, ..run.last });
            }
        }
    }

    /// Collects moves as long as one move can replace them.
    fn reduce(&mut self, one: &PostMove, out: &mut Vec<PostMove>) {
        let Some(start) = self.start else { return out.push(*one) };
        self.chain.push(*one);
        // Greedy: the chain grows while one straight move from its start stays within the share.
        let fits = self.chain.len() <= MOST && alike(&start, &self.chain);
        let off = if fits { chord_off(&start.pose, &self.chain) } else { [f64::INFINITY; 2] };
        let [tip, axis] = self.tolerance.map(|most| self.shares[0] * most);
        if off[0] <= tip && off[1] <= axis {
            self.reduced = [0, 1].map(|k: usize| self.reduced[k].max(off[k]));
            return;
        }
        // The move that does not fit begins the next chain.
        self.chain.pop();
        self.hand_out(out);
        self.chain.push(*one);
    }

    /// Appends one move for those of the chain.
    fn hand_out(&mut self, out: &mut Vec<PostMove>) {
        if let (Some(start), Some(last)) = (self.start, self.chain.last().copied()) {
            let pace = PostPace::Feed(common_feed(lengths(&start, &self.chain)));
            out.push(PostMove { pace, ..last });
            self.start = Some(last);
        }
        self.chain.clear();
    }
}

/// Returns the travel of the tip in each move \[mm\] and its feed \[mm/s\].
fn lengths<'a>(
    start: &'a PostMove,
    chain: &'a [PostMove],
) -> impl Iterator<Item = (f64, f64)> + Clone + 'a {
    let before = std::iter::once(start).chain(chain);
    before.zip(chain).filter_map(|(from, to)| match to.pace {
        PostPace::Feed(feed) => Some(((to.pose.tip - from.pose.tip).norm(), feed)),
        _ => None,
    })
}

/// Returns true if the feeds of all moves but the shortest are alike.
fn alike(start: &PostMove, chain: &[PostMove]) -> bool {
    let length: f64 = lengths(start, chain).map(|(part, _)| part).sum();
    let long = lengths(start, chain).filter(|(part, _)| *part >= SHORT * length);
    let [least, most] = long
        .fold([f64::INFINITY, 0.0], |[least, most], (_, feed)| [feed.min(least), feed.max(most)]);
    most <= ALIKE * least
}

/// Bounds the deviation of a single move from the chain that it replaces: tip \[mm\], axis \[rad\].
///
/// Each end of the chain is matched with the nearest share of the move, in order. Between two ends both tips run
/// straight, so that none is farther off than at an end. Two great circles part by no more than an eighth of the
/// squares of their turns.
fn chord_off(start: &ToolPose, chain: &[PostMove]) -> [f64; 2] {
    let Some(end) = chain.last().map(|last| last.pose) else { return [0.0; 2] };
    let chord = end.tip - start.tip;
    let square = chord.norm_squared();
    let whole = angle_between(&start.axis, &end.axis);
    let mut off = [0.0_f64; 2];
    let mut before = (0.0_f64, *start);
    for one in chain {
        let pose = &one.pose;
        // Nearest point of the chord to this end of the chain.
        let share = if square > 0.0 { (pose.tip - start.tip).dot(&chord) / square } else { 1.0 };
        // Shares must not decrease: going back counts as standing still.
        let share = share.clamp(before.0, 1.0);
        let Some(axis) = great_circle(&start.axis, &end.axis, share) else {
            return [f64::INFINITY; 2];
        };
        // Both axes turn on great circles between two ends, so the bound adds an eighth of both squares.
        let own = angle_between(&before.1.axis, &pose.axis);
        let turned = whole * (share - before.0);
        off[0] = off[0].max((start.tip + chord * share - pose.tip).norm());
        off[1] =
            off[1].max(angle_between(&axis, &pose.axis) + 0.125 * (own * own + turned * turned));
        before = (share, *pose);
    }
    off
}

fn station(pose: &ToolPose) -> Station {
    Station { pose: *pose, contact: pose.tip }
}

fn smoothing(error: &SmoothError, line: u32) -> PostError {
    match error {
        SmoothError::AxisReversal { .. } => PostError::Reversal { line },
        error => PostError::Smooth { line, error: *error },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn a_chord_takes_the_time_of_moves_that_are_alike_and_else_runs_at_the_least_feed() {
        let feed = |parts: &[(f64, f64)]| common_feed(parts.iter().copied());
        // 1 mm at 10 and 1 mm at 10.4 mm/s: 2 mm in 0.1 + 0.09615 s.
        let mean = 2.0 / (0.1 + 1.0 / 10.4);
        assert!((feed(&[(1.0, 10.0), (1.0, 10.4)]) - mean).abs() < 1e-12);
        assert!((feed(&[(1.0, 10.0), (1.0, 12.0)]) - 10.0).abs() < 1e-12);
        // A hundredth of the way takes its own time, but does not hold the rest back.
        let mean = 1.01 / (0.1 + 0.01 / 5.0);
        assert!((feed(&[(1.0, 10.0), (0.01, 5.0)]) - mean).abs() < 1e-12);
    }

    #[test]
    fn a_chord_runs_at_the_feed_of_its_own_moves() {
        let pose = ToolPose { tip: Point3::origin(), axis: Vector3::z_axis() };
        let last = PostMove {
            line: 1,
            pose,
            q: None,
            pace: PostPace::Rapid,
            way: BlockInterpolation::GreatCircle,
        };
        let filter = MoveFilter::new(
            PostFilter::Smooth,
            BlockInterpolation::GreatCircle,
            PostSource::Locations,
            [0.01, 1e-3],
        );
        let mut run = filter.begin(&last).unwrap();
        // 30 mm/s for 5 mm, 2 for 1 mm, then 20.
        run.feeds = [(0.0, 30.0), (5.0, 2.0), (6.0, 20.0)].into();
        let feeds: Vec<f64> = [[0.0, 2.0], [2.0, 5.0], [5.0, 5.5], [5.5, 7.0], [7.0, 9.0]]
            .into_iter()
            .map(|part| run.feed(part))
            .collect();
        assert_eq!(feeds, [30.0, 30.0, 2.0, 2.0, 20.0]);
        assert_eq!(run.feeds.len(), 1);
    }
}
