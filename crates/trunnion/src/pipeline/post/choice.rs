//! Where smoothing makes a cut quicker, where leaving moves out does, and where it is left as it is: each is run, and
//! the times decide.

use super::ahead::{Ahead, Part, Planned};
use super::course::Course;
use super::filter::Filter;
use super::gauge::Clock;
use super::leg::Place;
use super::pace::Timed;
use super::timer::Timer;
use super::written::Written;
use super::{PostError, PostFilter, PostMethod, PostMove, PostOptions, PostPace, PostSource};
use crate::machine::Kinematics;
use crate::nc::write::Style;
use crate::types::{AxisVector, ToolPose};

/// Most moves of a unit; a longer cut is decided in parts.
const MOST: usize = 1 << 16;

/// Moves of the smallest parts of a cut of which each may be smoothed or not.
const PART: usize = 16;

/// Smallest parts in those that are tried.
const PARTS: [usize; 3] = [16, 4, 1];

/// Fewer moves than this are left as they are.
const LEAST: usize = 3;

/// What was decided, and by which clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PostChoice {
    /// Cuts that were left as they are, changed in part, and changed as a whole.
    pub cuts: [usize; 3],
    /// Time of the cuts with nothing changed, and as they were chosen \[s\].
    pub seconds: [f64; 2],
    /// The control model decided; else the limits of the axes.
    pub by_model: bool,
}

/// Rapid moves and the cut behind them.
#[derive(Debug, Default)]
pub(super) struct Unit {
    /// The last move of the unit before.
    from: Option<PostMove>,
    moves: Vec<PostMove>,
}

impl Unit {
    /// Takes in a move; true if the unit is complete without it.
    pub(super) fn ends_before(&self, one: &PostMove) -> bool {
        let cutting = self.moves.last().is_some_and(|last| last.pace != PostPace::Rapid);
        (cutting && one.pace == PostPace::Rapid) || self.moves.len() >= MOST
    }

    pub(super) fn push(&mut self, one: PostMove) {
        self.moves.push(one);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.moves.is_empty()
    }

    /// Starts the next one.
    pub(super) fn clear(&mut self) {
        self.from = self.moves.last().copied().or(self.from);
        self.moves.clear();
    }

    fn cut(&self) -> usize {
        self.moves.iter().filter(|one| one.pace != PostPace::Rapid).count()
    }

    /// The cut neither begins nor ends in the middle of a longer one.
    fn is_whole(&self) -> bool {
        let begins = self.moves.first().is_none_or(|one| one.pace == PostPace::Rapid);
        (begins || self.from.is_none_or(|one| one.pace == PostPace::Rapid))
            && self.moves.len() < MOST
    }
}

/// What is done to the parts of a cut.
#[derive(Debug, Clone)]
struct Parts {
    /// Moves of each but the last.
    size: usize,
    kinds: Vec<PostFilter>,
}

impl Parts {
    fn all(cut: usize, size: usize, kind: PostFilter) -> Self {
        Self { size, kinds: vec![kind; cut.div_ceil(size.max(1))] }
    }

    fn kind(&self, part: usize) -> PostFilter {
        self.kinds.get(part).copied().unwrap_or(PostFilter::None)
    }
}

/// What may be done to a part.
const KINDS: [PostFilter; 2] = [PostFilter::Smooth, PostFilter::Reduce];

/// Moves of a unit with parts of its cut changed.
struct Filtered {
    moves: Vec<PostMove>,
    /// Of which part each is.
    tags: Vec<usize>,
    /// Bounds on what each of [`KINDS`] moved them by \[mm, rad\].
    strayed: [[f64; 2]; 2],
}

/// What runs units.
pub(super) struct Choice<'a> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) source: &'a PostSource,
    pub(super) options: &'a PostOptions,
    pub(super) style: &'a Style,
    pub(super) ahead: &'a Ahead,
    pub(super) course: &'a Course,
}

/// A unit that was run one way.
#[derive(Debug)]
pub(super) struct Trial {
    pub(super) ahead: Ahead,
    pub(super) course: Course,
    pub(super) places: Vec<Place>,
    /// Where the program starts, if it does so in this unit.
    pub(super) start: Option<(AxisVector, ToolPose)>,
    /// Bounds on how far it strays from the input \[mm, rad\].
    pub(super) strayed: [f64; 2],
    /// Times of the parts of the cut \[s\].
    costs: Vec<f64>,
}

impl Trial {
    fn cost(&self) -> f64 {
        self.costs.iter().sum()
    }
}

impl Choice<'_> {
    /// Runs a unit each way; the quickest, and what was decided is added up.
    ///
    /// # Errors
    ///
    /// [`PostError`] of the unit as it is. Where smoothing fails, the cut is left as it is.
    pub(super) fn quickest(&self, unit: &Unit, told: &mut PostChoice) -> Result<Trial, PostError> {
        told.by_model = Clock::by_model(self.kinematics, self.style);
        let cut = unit.cut();
        let plain = self.run(unit, &Parts::all(cut, PART, PostFilter::None))?;
        if cut == 0 {
            return Ok(plain);
        }
        let costs = plain.costs.clone();
        let before = plain.cost();
        // Two parts of a long cut meet without a stop, each by itself has one.
        let stop = if unit.is_whole() { 0.0 } else { 2.0 * self.stop() };
        let (mut best, mut kind) = (plain, 0);
        let mut offer = |trial: Option<Trial>, changed: usize| {
            let quicker = |of: &Trial| of.cost() + stop < before && of.cost() < best.cost();
            if let Some(trial) = trial.filter(quicker) {
                (best, kind) = (trial, changed);
            }
        };
        if cut >= LEAST {
            for kind in KINDS {
                offer(self.run(unit, &Parts::all(cut, cut, kind)).ok(), 2);
            }
        }
        for size in PARTS.into_iter().filter(|size| PART * size < cut) {
            let plain: Vec<f64> = costs.chunks(size).map(|part| part.iter().sum()).collect();
            offer(self.mixed(unit, (PART * size, plain)), 1);
        }
        told.cuts[kind] += 1;
        told.seconds[0] += before;
        told.seconds[1] += best.cost();
        Ok(best)
    }

    /// Does to each part what makes it quickest.
    fn mixed(&self, unit: &Unit, (size, mut least): (usize, Vec<f64>)) -> Option<Trial> {
        let mut kinds = vec![PostFilter::None; least.len()];
        for kind in KINDS {
            let all = Parts { size, kinds: vec![kind; least.len()] };
            let Ok(trial) = self.run(unit, &all) else { continue };
            for ((least, slot), cost) in least.iter_mut().zip(&mut kinds).zip(trial.costs) {
                if cost < *least {
                    (*least, *slot) = (cost, kind);
                }
            }
        }
        let changed = kinds.iter().any(|kind| *kind != PostFilter::None);
        if changed { self.run(unit, &Parts { size, kinds }).ok() } else { None }
    }

    /// Longest time in which an axis stops \[s\].
    fn stop(&self) -> f64 {
        let machine = self.kinematics.machine();
        machine.axes.iter().map(|axis| axis.vel / axis.acc).fold(0.0, f64::max)
    }

    fn run(&self, unit: &Unit, parts: &Parts) -> Result<Trial, PostError> {
        let Filtered { moves, tags, strayed: filtered } = self.filtered(unit, parts)?;
        let mut trial = Trial {
            ahead: self.ahead.clone(),
            course: self.course.clone(),
            places: Vec::new(),
            start: None,
            strayed: [0.0; 2],
            costs: vec![0.0; parts.kinds.len()],
        };
        let mut planned: Vec<Planned> = Vec::new();
        for one in &moves {
            trial.ahead.push(one, &mut planned);
        }
        trial.ahead.finish(&mut planned);
        let mut tags = tags.into_iter();
        let mut tag = None;
        let all = self.options.tolerance;
        for one in &planned {
            if one.part.is_none() {
                tag = tags.next();
            }
            let part: usize = tag.unwrap_or_default();
            let kind = parts.kind(part);
            let share = kind.left(self.options.control);
            let moved = KINDS.iter().zip(filtered).find(|(own, _)| **own == kind);
            let moved = moved.map_or([0.0; 2], |(_, moved)| moved);
            trial.course.tolerance = all.map(|of| share * of);
            trial.course.strayed = [0.0; 2];
            let begin = trial.places.len();
            let starts = trial.course.place().is_none();
            trial.course.go(one, &mut trial.places)?;
            if starts {
                trial.start = trial.course.place();
            }
            let off = [0, 1].map(|k: usize| moved[k] + trial.course.strayed[k]);
            trial.strayed = [0, 1].map(|k: usize| trial.strayed[k].max(off[k]));
            for place in trial.places.get_mut(begin..).unwrap_or_default() {
                place.part = part;
            }
            if let (Some(Part::Out), Some(first)) = (one.part, trial.places.get_mut(begin)) {
                first.goes_out = true;
            }
        }
        self.time(&mut trial)?;
        Ok(trial)
    }

    /// Does to the parts of a cut what is to be done.
    fn filtered(&self, unit: &Unit, parts: &Parts) -> Result<Filtered, PostError> {
        let options = self.options;
        let mut filters = KINDS.map(|kind| {
            let kind = (kind, options.control);
            Filter::new(kind, self.source.clone(), options.tolerance)
        });
        if let Some(from) = &unit.from {
            for filter in &mut filters {
                filter.start_at(from);
            }
        }
        let (mut moves, mut tags) = (Vec::new(), Vec::new());
        let (mut count, mut part) = (0, 0);
        let mut before: Option<PostMove> = None;
        for one in &unit.moves {
            let now = count / parts.size.max(1);
            count += usize::from(one.pace != PostPace::Rapid);
            if now != part {
                filters.iter_mut().try_for_each(|filter| filter.finish(&mut moves))?;
                tags.resize(moves.len(), part);
                if let (Some(end), Some(before)) = (moves.last_mut(), before) {
                    // What follows goes on from where the rotaries of the input are.
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
        Ok(Filtered { moves, tags, strayed })
    }

    /// Times of the parts.
    fn time(&self, trial: &mut Trial) -> Result<(), PostError> {
        let Some(start) = self.course.place().or(trial.start) else { return Ok(()) };
        let mut clock = Clock::new(self.kinematics, self.style, start);
        let mut pace = Timer::new(self.kinematics, self.options, start.0)?;
        let mut timed = Vec::new();
        let mut add = |timed: &mut Vec<Timed>| {
            for one in timed.drain(..) {
                if let Some(cost) = trial.costs.get_mut(one.place.part) {
                    *cost += clock.seconds(&one);
                }
            }
        };
        let mut places = trial.places.clone();
        let course = (self.options.method != PostMethod::Programmed).then_some(self.course);
        let of = (self.kinematics, self.style);
        Written::new(of.0, of.1, &start).take(of, course, &mut places);
        for place in &places {
            pace.push(place, &mut timed)?;
            add(&mut timed);
        }
        pace.finish(&mut timed)?;
        add(&mut timed);
        Ok(())
    }
}
