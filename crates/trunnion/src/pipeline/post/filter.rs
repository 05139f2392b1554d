//! Fewer and smoother moves before they are posted: both within a tolerance of what was read.

use super::{PostError, PostMove, PostPace, PostSource};
use crate::blocks::{Control, bend, moved};
use crate::math::angle::{angle_between, great_circle};
use crate::pipeline::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS};
use crate::toolpath::{Reference, SmoothError, SmoothOptions, SmoothReport, SmoothSpan, Smoother};
use crate::types::{AxisVector, Station, ToolPose};
use std::collections::VecDeque;

/// What is done to moves before they are posted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PostFilter {
    /// Nothing.
    None,
    /// A C3 path is laid through the moves between rapid ones, and cut into chords.
    Smooth,
    /// Moves are left out that a longer one stands for.
    Reduce,
}

/// Shares of the tolerance: for the filter itself, for the chords of what was smoothed, and for the input's own bows.
///
/// Of some 25 splits tried on a program with long chords, one with very short ones and a waved part, at two tolerances
/// each, this one took the least time within the limits of the axes: the looser the path, the less it turns; what is left
/// for the way to the machine cuts chords finely just where rotaries turn fast.
const SMOOTH: [f64; 3] = [0.8, 0.15, 0.01];

/// The same for a control that moves the axes linearly: the bow of the tip needs a part, too, and is not much less than it
/// where blocks are few.
const SMOOTH_AXES: [f64; 3] = [0.5, 0.1, 0.02];

/// The same where moves are left out: the rest lets the planner round the corners, which are sharper.
const REDUCE: [f64; 3] = [0.5, 0.0, 0.05];

impl PostFilter {
    fn shares(self, control: Control) -> [f64; 3] {
        match (self, control) {
            (Self::None, _) => [0.0; 3],
            (Self::Smooth, Control::Axes) => SMOOTH_AXES,
            (Self::Smooth, _) => SMOOTH,
            (Self::Reduce, _) => REDUCE,
        }
    }

    /// Share of the tolerance that is left for the way to the machine.
    pub(super) fn left(self, control: Control) -> f64 {
        1.0 - self.shares(control).iter().sum::<f64>()
    }
}

/// Length at which a turn of the axis counts as movement where the tip stands \[mm/rad\].
const LEVER: f64 = 10.0;

/// Most moves that one stands for.
const MOST: usize = 256;

/// Takes in moves, hands out those to post.
#[derive(Debug)]
pub(super) struct Filter {
    kind: PostFilter,
    shares: [f64; 3],
    source: PostSource,
    tolerance: [f64; 2],
    place: Option<PostMove>,
    stretch: Option<Stretch>,
    /// Moves that one may stand for.
    chain: Vec<PostMove>,
    start: Option<PostMove>,
    report: SmoothReport,
    /// Largest deviations of the reduction.
    reduced: [f64; 2],
}

/// Moves with feed between two rapid ones.
#[derive(Debug)]
struct Stretch {
    smoother: Box<Smoother>,
    /// Feeds, each from a place along the path on.
    feeds: VecDeque<(f64, f64)>,
    last: PostMove,
}

/// Share of a chord that may reach into the next move: places along the path are sums, and rounded.
const SLIVER: f64 = 1e-6;

impl Stretch {
    /// Feed of a part of the path. Parts come in order: what lies before is forgotten.
    fn feed(&mut self, [from, to]: [f64; 2]) -> f64 {
        let sliver = SLIVER * (to - from);
        while self.feeds.get(1).is_some_and(|(next, _)| *next <= from + sliver) {
            self.feeds.pop_front();
        }
        let ends = self.feeds.iter().skip(1).map(|(start, _)| *start).chain([f64::INFINITY]);
        let parts = self.feeds.iter().zip(ends);
        let inside = parts.take_while(|((start, _), _)| *start < to - sliver);
        common_feed(
            inside.map(|((start, feed), end)| ((end.min(to) - start.max(from)).max(0.0), *feed)),
        )
    }
}

/// Feeds that differ by no more than this are one, which the program's words only round differently.
const ALIKE: f64 = 1.05;

/// Moves shorter than this share of a chord do not decide its feed.
const SHORT: f64 = 0.05;

/// Feed of a chord that stands for moves of some lengths and feeds: the one that takes as long as they did, if they are
/// alike; else the least of them.
fn common_feed(parts: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let (length, time) = parts
        .clone()
        .fold((0.0, 0.0), |(length, time), (part, feed)| (length + part, time + part / feed));
    let mean = length / time;
    let long = parts.filter(|(part, _)| *part >= SHORT * length).map(|(_, feed)| feed);
    let least = long.fold(f64::INFINITY, f64::min);
    if mean <= ALIKE * least { mean } else { least }
}

impl Filter {
    /// `control`: of the target.
    pub(super) fn new(
        (kind, control): (PostFilter, Control),
        source: PostSource,
        tolerance: [f64; 2],
    ) -> Self {
        Self {
            kind,
            shares: kind.shares(control),
            source,
            tolerance,
            place: None,
            stretch: None,
            chain: Vec::new(),
            start: None,
            report: SmoothReport::default(),
            reduced: [0.0; 2],
        }
    }

    /// Bounds on what it moved tip \[mm\] and axis \[rad\].
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

    /// The next move begins where this one ends; it itself is not handed out.
    pub(super) fn start_at(&mut self, one: &PostMove) {
        (self.place, self.start) = (Some(*one), Some(*one));
    }

    /// Takes in a move; those to post are appended.
    pub(super) fn push(
        &mut self,
        one: &PostMove,
        out: &mut Vec<PostMove>,
    ) -> Result<(), PostError> {
        let Some(before) = self.place.replace(*one) else {
            out.push(*one);
            self.start = Some(*one);
            return Ok(());
        };
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
        for part in self.chords(&before, one, feed)? {
            match self.kind {
                PostFilter::Smooth => self.smooth(&part, feed, out)?,
                _ => self.reduce(&part, out),
            }
        }
        Ok(())
    }

    /// Ends a stretch between rapid moves.
    pub(super) fn finish(&mut self, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        if let Some(stretch) = self.stretch.take() {
            self.end(stretch, out)?;
        }
        self.hand_out(out);
        Ok(())
    }

    /// A move as straight ones with the tool on great circles, within a small share of the tolerance.
    fn chords(
        &self,
        from: &PostMove,
        to: &PostMove,
        feed: f64,
    ) -> Result<Vec<PostMove>, PostError> {
        let plain = |pose: ToolPose| PostMove {
            pose,
            q: None,
            way: Control::GreatCircle,
            pace: PostPace::Feed(feed),
            ..*to
        };
        let ends = match (&self.source, from.q, to.q) {
            (PostSource::Program(kinematics), Some(a), Some(b))
                if to.way != Control::GreatCircle =>
            {
                (kinematics, a, b)
            }
            _ => return Ok(vec![plain(to.pose)]),
        };
        let (kinematics, a, b) = ends;
        let pair: [(&AxisVector, &ToolPose); 2] = [(&a, &from.pose), (&b, &to.pose)];
        let [tip, axis] = bend(kinematics, to.way, pair);
        let turn = angle_between(&from.pose.axis, &to.pose.axis);
        let [.., share] = self.shares;
        let [most_tip, most_axis] = self.tolerance.map(|most| share * most);
        let excess = (tip / most_tip).max((axis + turn * turn) / most_axis);
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

    fn smooth(
        &mut self,
        one: &PostMove,
        feed: f64,
        out: &mut Vec<PostMove>,
    ) -> Result<(), PostError> {
        let mut stretch = match self.stretch.take() {
            Some(stretch) => stretch,
            None => self.begin(one)?,
        };
        let told = |error: SmoothError| smoothing(&error, one.line);
        if stretch.feeds.back().is_none_or(|(_, last)| last.total_cmp(&feed).is_ne()) {
            stretch.feeds.push_back((stretch.smoother.along(), feed));
        }
        stretch.smoother.push(&station(&one.pose)).map_err(told)?;
        stretch.last = *one;
        for span in &stretch.smoother.take() {
            self.cut(&mut stretch, span, out);
        }
        self.stretch = Some(stretch);
        Ok(())
    }

    fn begin(&self, one: &PostMove) -> Result<Stretch, PostError> {
        let [tip, axis] = self.tolerance.map(|most| self.shares[0] * most);
        let options = SmoothOptions {
            tip,
            axis,
            reference: Reference::Chords,
            lever: LEVER,
            corner: CORNER,
            step_ratio: STEP_RATIO,
            largest_blend: LARGEST_BLEND,
            window: WINDOW_STATIONS,
        };
        let told = |error: SmoothError| smoothing(&error, one.line);
        let mut smoother = Smoother::new(&options).map_err(told)?;
        if let Some(start) = &self.start {
            smoother.push(&station(&start.pose)).map_err(told)?;
        }
        Ok(Stretch { smoother: Box::new(smoother), feeds: VecDeque::new(), last: *one })
    }

    fn end(&mut self, mut stretch: Stretch, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        let last = stretch.last;
        let smoother = std::mem::replace(&mut stretch.smoother, self.begin(&last)?.smoother);
        match smoother.finish() {
            Ok((spans, report)) => {
                self.report.add(&report);
                for span in &spans {
                    self.cut(&mut stretch, span, out);
                }
            }
            // Nothing that could be smoothed: all is within a small part of the tolerance of the last.
            Err(SmoothError::Stations(_)) => out.push(last),
            Err(error) => return Err(smoothing(&error, last.line)),
        }
        self.start = Some(last);
        Ok(())
    }

    /// Chords of a span, each at the feed of the moves it stands for.
    fn cut(&self, stretch: &mut Stretch, span: &SmoothSpan, out: &mut Vec<PostMove>) {
        let [tip, axis] = self.tolerance.map(|most| self.shares[1] * most);
        let parts = span.chords(tip, axis);
        let [start, end] = span.range;
        let width = (end - start) / f64::from(parts);
        for part in 1..=parts {
            let to = start + width * f64::from(part);
            let pace = PostPace::Feed(stretch.feed([to - width, to]));
            if let Some(pose) = span.pose(f64::from(part) / f64::from(parts)) {
                out.push(PostMove { pose, pace, ..stretch.last });
            }
        }
    }

    /// Leaves moves out as long as one stands for them.
    fn reduce(&mut self, one: &PostMove, out: &mut Vec<PostMove>) {
        let Some(start) = self.start else { return out.push(*one) };
        self.chain.push(*one);
        let fits = self.chain.len() <= MOST && alike(&start, &self.chain);
        let off = if fits { chord_off(&start.pose, &self.chain) } else { [f64::INFINITY; 2] };
        let [tip, axis] = self.tolerance.map(|most| self.shares[0] * most);
        if off[0] <= tip && off[1] <= axis {
            self.reduced = [0, 1].map(|k: usize| self.reduced[k].max(off[k]));
            return;
        }
        self.chain.pop();
        self.hand_out(out);
        self.chain.push(*one);
    }

    /// One move for those of the chain.
    fn hand_out(&mut self, out: &mut Vec<PostMove>) {
        if let (Some(start), Some(last)) = (self.start, self.chain.last().copied()) {
            let pace = PostPace::Feed(common_feed(lengths(&start, &self.chain)));
            out.push(PostMove { pace, ..last });
            self.start = Some(last);
        }
        self.chain.clear();
    }
}

/// Way of the tip of each move \[mm\] and its feed \[mm/s\].
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

/// The feeds of moves that are not short among them are alike.
fn alike(start: &PostMove, chain: &[PostMove]) -> bool {
    let length: f64 = lengths(start, chain).map(|(part, _)| part).sum();
    let long = lengths(start, chain).filter(|(part, _)| *part >= SHORT * length);
    let [least, most] = long
        .fold([f64::INFINITY, 0.0], |[least, most], (_, feed)| [feed.min(least), feed.max(most)]);
    most <= ALIKE * least
}

/// Bounds on how far a move to the last of some strays from all of them: tip \[mm\], axis \[rad\].
///
/// Each is matched with the share of the move nearest to it, in order; between two of them both tips run straight, so
/// that none is farther off than at an end, and two great circles part by no more than an eighth of the squares of
/// their turns.
fn chord_off(start: &ToolPose, chain: &[PostMove]) -> [f64; 2] {
    let Some(end) = chain.last().map(|last| last.pose) else { return [0.0; 2] };
    let chord = end.tip - start.tip;
    let square = chord.norm_squared();
    let whole = angle_between(&start.axis, &end.axis);
    let mut off = [0.0_f64; 2];
    let mut before = (0.0_f64, *start);
    for one in chain {
        let pose = &one.pose;
        let share = if square > 0.0 { (pose.tip - start.tip).dot(&chord) / square } else { 1.0 };
        // In order: going back counts as standing still.
        let share = share.clamp(before.0, 1.0);
        let Some(axis) = great_circle(&start.axis, &end.axis, share) else {
            return [f64::INFINITY; 2];
        };
        let own = angle_between(&before.1.axis, &pose.axis);
        let run = whole * (share - before.0);
        off[0] = off[0].max((start.tip + chord * share - pose.tip).norm());
        off[1] = off[1].max(angle_between(&axis, &pose.axis) + 0.125 * (own * own + run * run));
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
        let last =
            PostMove { line: 1, pose, q: None, pace: PostPace::Rapid, way: Control::GreatCircle };
        let filter = Filter::new(
            (PostFilter::Smooth, Control::GreatCircle),
            PostSource::Locations,
            [0.01, 1e-3],
        );
        let mut stretch = filter.begin(&last).unwrap();
        // 30 mm/s for 5 mm, 2 for 1 mm, then 20.
        stretch.feeds = [(0.0, 30.0), (5.0, 2.0), (6.0, 20.0)].into();
        let feeds: Vec<f64> = [[0.0, 2.0], [2.0, 5.0], [5.0, 5.5], [5.5, 7.0], [7.0, 9.0]]
            .into_iter()
            .map(|part| stretch.feed(part))
            .collect();
        assert_eq!(feeds, [30.0, 30.0, 2.0, 2.0, 20.0]);
        assert_eq!(stretch.feeds.len(), 1);
    }
}
