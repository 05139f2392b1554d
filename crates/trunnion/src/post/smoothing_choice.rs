//! Decides for each cut between smoothing, leaving moves out, and no change: each is tried, and the times decide.

use super::axis_point::{AxesPose, AxisPoint};
use super::error::PostError;
use super::filter::MoveFilter;
use super::options::{PostFilter, PostMethod, PostMove, PostOptions, PostPace, PostSource};
use super::report::PostChoice;
use super::rotaries::{PlannedMove, RetractPhase, RotaryPlanner};
use super::rounded_words::RoundedWords;
use super::subdivision::Subdivider;
use super::timing::{ControlTiming, PointTimer, TimedPoint};
use crate::machine::Kinematics;
use crate::nc::write::{OutputFormat, Style};

/// Most moves of a group; a longer cut is decided in parts.
const MOST: usize = 1 << 16;

/// Moves in the smallest part of a cut that may be smoothed by itself.
const PART: usize = 16;

/// Sizes of the parts that are tried, in smallest parts.
const PARTS: [usize; 3] = [16, 4, 1];

/// Least number of moves for a change; shorter cuts stay as they are.
const LEAST: usize = 3;

/// Rapid moves and the cut behind them.
#[derive(Debug, Default)]
pub(super) struct MoveGroup {
    /// Last move of the group before.
    from: Option<PostMove>,
    moves: Vec<PostMove>,
}

impl MoveGroup {
    /// Returns true if the group is complete without this move.
    pub(super) fn ends_before(&self, one: &PostMove) -> bool {
        let cutting = self.moves.last().is_some_and(|last| last.pace != PostPace::Rapid);
        (cutting && one.pace == PostPace::Rapid) || self.moves.len() >= MOST
    }

    /// Adds a move.
    pub(super) fn push(&mut self, one: PostMove) {
        self.moves.push(one);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.moves.is_empty()
    }

    /// Starts the next group.
    pub(super) fn clear(&mut self) {
        self.from = self.moves.last().copied().or(self.from);
        self.moves.clear();
    }

    /// Returns the number of moves with feed.
    fn cut(&self) -> usize {
        self.moves.iter().filter(|one| one.pace != PostPace::Rapid).count()
    }

    /// Returns true if the cut neither begins nor ends inside a longer one.
    fn is_whole(&self) -> bool {
        let begins = self.moves.first().is_none_or(|one| one.pace == PostPace::Rapid);
        (begins || self.from.is_none_or(|one| one.pace == PostPace::Rapid))
            && self.moves.len() < MOST
    }
}

/// Filters for the parts of a cut.
#[derive(Debug, Clone)]
struct GroupParts {
    /// Number of moves in each part but the last.
    size: usize,
    kinds: Vec<PostFilter>,
}

impl GroupParts {
    /// Divides `cut` moves into parts of `size` moves, all with one filter.
    fn all(cut: usize, size: usize, kind: PostFilter) -> Self {
        Self { size, kinds: vec![kind; cut.div_ceil(size.max(1))] }
    }

    fn kind(&self, part: usize) -> PostFilter {
        self.kinds.get(part).copied().unwrap_or(PostFilter::None)
    }
}

/// Share of the unchanged time that a change of a whole cut, and of a part of one, may take at most.
///
/// A smoothed cut that is posted again can always be smoothed a little more, farther from what it was made of: less than
/// this is no gain, so that the second posting leaves it as it is.
const PAYS: [f64; 2] = [0.95, 0.9];

/// Filters that change a part.
const KINDS: [PostFilter; 2] = [PostFilter::Smooth, PostFilter::Reduce];

/// Moves of a group with parts of its cut changed.
struct FilteredMoves {
    moves: Vec<PostMove>,
    /// Index of the part of each move.
    tags: Vec<usize>,
    /// Deviation bounds of each of [`KINDS`] \[mm, rad\].
    strayed: [[f64; 2]; 2],
}

/// State in front of a group, from which each trial starts.
pub(super) struct SmoothingChoice<'a> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) source: &'a PostSource,
    pub(super) options: &'a PostOptions,
    pub(super) style: &'a Style,
    pub(super) rotaries: &'a RotaryPlanner,
    pub(super) subdivider: &'a Subdivider,
}

/// Group of moves that was run with one choice of filters.
#[derive(Debug)]
pub(super) struct GroupTrial {
    pub(super) rotaries: RotaryPlanner,
    pub(super) subdivider: Subdivider,
    pub(super) points: Vec<AxisPoint>,
    /// Starting position of the program, if it starts in this group.
    pub(super) start: Option<AxesPose>,
    /// Deviation bounds from the input \[mm, rad\].
    pub(super) strayed: [f64; 2],
    /// Times of the parts of the cut \[s\].
    costs: Vec<f64>,
}

impl GroupTrial {
    fn cost(&self) -> f64 {
        self.costs.iter().sum()
    }
}

impl SmoothingChoice<'_> {
    /// Runs a group with each choice, returns the quickest, and adds the decision to `decisions`.
    ///
    /// # Errors
    ///
    /// [`PostError`] of the unchanged group. If smoothing fails, the cut stays as it is.
    pub(super) fn quickest(
        &self,
        group: &MoveGroup,
        decisions: &mut PostChoice,
    ) -> Result<GroupTrial, PostError> {
        decisions.by_model = ControlTiming::by_model(self.kinematics, self.style);
        let cut = group.cut();
        // The unchanged cut, timed part by part, is what every trial has to beat.
        let plain = self.run(group, &GroupParts::all(cut, PART, PostFilter::None))?;
        if cut == 0 {
            return Ok(plain);
        }
        let costs = plain.costs.clone();
        let before = plain.cost();
        // Two parts of a long cut meet without a stop; timed by itself, each has one.
        let stop = if group.is_whole() { 0.0 } else { 2.0 * self.stop() };
        let [pays, _] = self.pays();
        let (mut best, mut kind) = (plain, 0);
        let mut offer = |trial: Option<GroupTrial>, changed: usize| {
            let quicker =
                |of: &GroupTrial| of.cost() + stop < pays * before && of.cost() < best.cost();
            if let Some(trial) = trial.filter(quicker) {
                (best, kind) = (trial, changed);
            }
        };
        // One filter for the whole cut.
        if cut >= LEAST {
            for kind in KINDS {
                offer(self.run(group, &GroupParts::all(cut, cut, kind)).ok(), 2);
            }
        }
        // A filter of its own for each part.
        for size in PARTS.into_iter().filter(|size| PART * size < cut) {
            let plain: Vec<f64> = costs.chunks(size).map(|part| part.iter().sum()).collect();
            offer(self.mixed(group, PART * size, &plain), 1);
        }
        decisions.cuts[kind] += 1;
        decisions.seconds.input += before;
        decisions.seconds.output += best.cost();
        Ok(best)
    }

    /// Gives each part the filter that makes it quickest; `plain` are the times of the unchanged parts \[s\].
    fn mixed(&self, group: &MoveGroup, size: usize, plain: &[f64]) -> Option<GroupTrial> {
        // Less than a change has to gain counts as none.
        let [_, pays] = self.pays();
        let mut least: Vec<f64> = plain.iter().map(|time| pays * time).collect();
        let mut kinds = vec![PostFilter::None; least.len()];
        for kind in KINDS {
            let all = GroupParts { size, kinds: vec![kind; least.len()] };
            // Times of the parts with this filter everywhere; each part keeps the filter that is quickest for
            // it.
            let Ok(trial) = self.run(group, &all) else { continue };
            for ((least, slot), cost) in least.iter_mut().zip(&mut kinds).zip(trial.costs) {
                if cost < *least {
                    (*least, *slot) = (cost, kind);
                }
            }
        }
        let changed = kinds.iter().any(|kind| *kind != PostFilter::None);
        if changed { self.run(group, &GroupParts { size, kinds }).ok() } else { None }
    }

    /// Returns [`PAYS`]; on `LinuxCNC`, whose time grows with the number of blocks, small gains are real.
    fn pays(&self) -> [f64; 2] {
        if self.style.dialect == OutputFormat::LinuxCnc { [1.0; 2] } else { PAYS }
    }

    /// Returns the longest stopping time of an axis \[s\].
    fn stop(&self) -> f64 {
        let machine = self.kinematics.machine();
        machine.axes.iter().map(|axis| axis.vel / axis.acc).fold(0.0, f64::max)
    }

    /// Runs a group with these filters.
    fn run(&self, group: &MoveGroup, parts: &GroupParts) -> Result<GroupTrial, PostError> {
        let FilteredMoves { moves, tags, strayed: filtered } = self.filtered(group, parts)?;
        let mut trial = GroupTrial {
            rotaries: self.rotaries.clone(),
            subdivider: self.subdivider.clone(),
            points: Vec::new(),
            start: None,
            strayed: [0.0; 2],
            costs: vec![0.0; parts.kinds.len()],
        };
        // Step 1: rotaries of the filtered moves.
        let mut planned: Vec<PlannedMove> = Vec::new();
        for one in &moves {
            trial.rotaries.push(one, &mut planned);
        }
        trial.rotaries.finish(&mut planned);
        // Step 2: points of each move, within the tolerance that its filter leaves.
        let mut tags = tags.into_iter();
        let mut tag = None;
        let all = self.options.tolerance;
        for one in &planned {
            if one.phase.is_none() {
                tag = tags.next();
            }
            let part: usize = tag.unwrap_or_default();
            let kind = parts.kind(part);
            let share = kind.left(self.options.control);
            let moved = KINDS.iter().zip(filtered).find(|(own, _)| **own == kind);
            let moved = moved.map_or([0.0; 2], |(_, moved)| moved);
            trial.subdivider.tolerance = all.scaled(share).into();
            trial.subdivider.strayed = [0.0; 2];
            let begin = trial.points.len();
            let starts = trial.subdivider.position().is_none();
            trial.subdivider.divide(one, &mut trial.points)?;
            if starts {
                trial.start = trial.subdivider.position();
            }
            let off = [0, 1].map(|k: usize| moved[k] + trial.subdivider.strayed[k]);
            trial.strayed = [0, 1].map(|k: usize| trial.strayed[k].max(off[k]));
            for point in trial.points.get_mut(begin..).unwrap_or_default() {
                point.part = part;
            }
            if let (Some(RetractPhase::Out), Some(first)) = (one.phase, trial.points.get_mut(begin))
            {
                first.goes_out = true;
            }
        }
        // Step 3: their times.
        self.time(&mut trial)?;
        Ok(trial)
    }

    /// Applies the filters to the parts of a cut.
    fn filtered(&self, group: &MoveGroup, parts: &GroupParts) -> Result<FilteredMoves, PostError> {
        let options = self.options;
        let mut filters = KINDS.map(|kind| {
            MoveFilter::new(kind, options.control, self.source.clone(), options.tolerance.into())
        });
        if let Some(from) = &group.from {
            for filter in &mut filters {
                filter.start_at(from);
            }
        }
        let mut moves = Vec::new();
        let mut tags = Vec::new();
        let mut count = 0;
        let mut part = 0;
        let mut before: Option<PostMove> = None;
        for one in &group.moves {
            // Parts are counted in moves with feed: rapid moves belong to the part before.
            let now = count / parts.size.max(1);
            count += usize::from(one.pace != PostPace::Rapid);
            if now != part {
                filters.iter_mut().try_for_each(|filter| filter.finish(&mut moves))?;
                tags.resize(moves.len(), part);
                if let (Some(end), Some(before)) = (moves.last_mut(), before) {
                    // The next part continues from the rotaries of the input.
                    end.q = before.q;
                }
                part = now;
            }
            before = Some(*one);
            let kind = parts.kind(now);
            for (filter, _) in filters.iter_mut().zip(KINDS).filter(|(_, own)| *own != kind) {
                filter.start_at(one);
            }
            match filters.iter_mut().zip(KINDS).find(|(_, own)| *own == kind) {
                Some((filter, _)) => filter.push(one, &mut moves)?,
                None => moves.push(*one),
            }
            tags.resize(moves.len(), part);
        }
        filters.iter_mut().try_for_each(|filter| filter.finish(&mut moves))?;
        tags.resize(moves.len(), part);
        let strayed = filters.map(|filter| filter.strayed());
        Ok(FilteredMoves { moves, tags, strayed })
    }

    /// Adds up the times of the parts.
    fn time(&self, trial: &mut GroupTrial) -> Result<(), PostError> {
        let Some(start) = self.subdivider.position().or(trial.start) else { return Ok(()) };
        // Times are those of the control that runs the program, from the rounded words it is given.
        let mut control = ControlTiming::new(self.kinematics, self.style, start);
        let mut timer = PointTimer::new(self.kinematics, &self.style.axes, self.options, start.q)?;
        let mut timed = Vec::new();
        let costs = &mut trial.costs;
        let mut add = |timed: &mut Vec<TimedPoint>| {
            timed.drain(..).for_each(|one| control.pass(&one, costs));
        };
        let mut points = trial.points.clone();
        let limited = self.options.method != PostMethod::Programmed;
        let subdivider = limited.then_some(self.subdivider);
        RoundedWords::new(self.kinematics, self.style, &start).take(
            self.kinematics,
            self.style,
            subdivider,
            &mut points,
        );
        for point in &points {
            timer.push(point, &mut timed)?;
            add(&mut timed);
        }
        timer.finish(&mut timed)?;
        add(&mut timed);
        control.finish(&mut trial.costs);
        Ok(())
    }
}
