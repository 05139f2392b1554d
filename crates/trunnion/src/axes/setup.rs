//! The setup search: a rotation of the workpiece that keeps a path far from the singular directions
//! and inside travel.

use super::lean::{Lean, LeanBounds};
use super::origin::{self, Place};
use super::sight::{self, Seen, Sight};
use super::{AxesError, AxesOptions, Followed, follow};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, SECOND_ROTARY, Setup};
use crate::types::{Cancelled, Progress, Stage, ToolPath};
use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering as AtomicOrdering};

/// A workpiece-side rotary within this of the machine's z counts as upright \[rad\]: tilting the
/// workpiece then moves its direction every way, and turning it adds nothing.
const UPRIGHT: f64 = FRAC_PI_4;

/// What is looked for, and how finely. No `Default`: the caller knows the fixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetupOptions {
    /// How the workpiece may be clamped.
    pub bounds: LeanBounds,
    /// Distance of neighbours of the first grid \[rad\].
    pub grid: f64,
    /// To which the best of the grid are improved, and tool axes of the path are told apart \[rad\].
    pub tolerance: f64,
    /// Rotations whose least angles differ by less than this are equally good \[rad\]; rotary travel
    /// decides.
    pub alike: f64,
    /// Rotations of about one least angle that are planned: so many of the best, and as many others.
    pub batch: usize,
    /// Digit to which setups are rounded: of the origin \[mm\], of the rotation \[deg\].
    pub digits: [f64; 2],
}

/// A setup and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The setup. Its origin is the one asked for, unless the path only fits with another.
    pub setup: Setup,
    /// Its rotation about the fixed x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// The same as it is clamped.
    pub lean: Lean,
    /// Least angle between tool axis and singular directions \[rad\].
    pub least: f64,
    /// How the axes do.
    pub verdict: Verdict,
}

/// How the axes do with a setup.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// The path is inside travel.
    Fits(Travelled),
    /// The tool-side rotary would have to go beyond its travel: by this much \[rad\].
    Leans(f64),
    /// Linear travel is too short, wherever the origin is.
    Short {
        /// By so much \[mm\].
        by: f64,
        /// These axes.
        axes: Vec<String>,
    },
    /// There is no axis path.
    Fails(AxesError),
}

/// Rotary travel of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travelled {
    /// Of each rotary, workpiece side first \[rad\].
    pub rotary: [f64; 2],
    /// Weighted, with the prices of retracts \[rad\].
    pub weighted: f64,
    /// Retracts to unwind.
    pub retracts: usize,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct SetupSearch {
    /// The setup of the job.
    pub before: Judged,
    /// Its axes, if it fits.
    pub before_axes: Option<Followed>,
    /// The best setup and its axes; `None` if none fits. It may be the one before.
    pub best: Option<(Judged, Followed)>,
    /// Others that were planned, best first.
    pub others: Vec<Judged>,
    /// Rotations looked at on the grid.
    pub looked: usize,
    /// Of these, how many need the tool-side rotary beyond its travel.
    pub leaning: usize,
}

impl LeanBounds {
    /// Bounds for a machine when nothing is said: the workpiece leans up to 45 degrees, or by up to 45
    /// degrees more or less than it does, any way. It is turned as it is; any way where that can help,
    /// which is on a machine whose workpiece-side rotary is not upright, or has ends of travel.
    pub fn usual(kinematics: &Kinematics) -> Self {
        let now = Lean::of(&kinematics.setup().rotation);
        let (least, most) = (now.tilt - FRAC_PI_4, now.tilt + FRAC_PI_4);
        let tilt = if least > 0.0 { [least, most.min(PI)] } else { [0.0, FRAC_PI_4] };
        let axis = kinematics.machine().axes.get(FIRST_ROTARY);
        let free = axis.is_some_and(|axis| {
            axis.dir.z.abs() > UPRIGHT.cos() && axis.limits.iter().all(|end| end.is_infinite())
        });
        let turn = if free { [now.turn; 2] } else { [-PI, PI] };
        Self { tilt, towards: [-PI, PI], turn }
    }
}

/// Searches the rotation of the workpiece that keeps a path farthest from the singular directions and
/// inside travel, and an origin for it.
///
/// The least angle between tool axis and singular directions is looked at on a grid of rotations
/// within bounds, the best are improved, and for those the axes are planned over the whole path as
/// [`follow`] does; where linear travel ends, the origin is moved as little as can be. Of rotations
/// with (nearly) the same least angle the one with the least rotary travel wins. What is returned was
/// followed with the very numbers of its setup, rounded to [`SetupOptions::digits`].
///
/// `options` are those of [`follow`] for the path.
///
/// # Errors
///
/// [`AxesError`]: options or bounds without sense, cancelled. That no setup fits is not an error.
///
/// # Source
///
/// The angle to the pole bounds the speed of the rotaries: `docs/sources.md#002`.
pub fn setup(
    kinematics: &Kinematics,
    path: &ToolPath,
    (options, search): (&AxesOptions, &SetupOptions),
    progress: &dyn Progress,
) -> Result<SetupSearch, AxesError> {
    super::error::options(options)?;
    check(search)?;
    let inverse = Inverse::new(kinematics).map_err(|source| AxesError::Inverse {
        piece: 0,
        u: 0.0,
        source,
    })?;
    let leans = search.bounds.grid(search.grid);
    let total = leans.len() as u64;
    let task = Task {
        kinematics,
        endless: origin::endless(kinematics.machine()),
        path,
        options,
        search,
        sight: Sight::new(&inverse),
        fine: sight::axes(path, search.tolerance),
        coarse: sight::axes(path, COARSE * search.grid),
        progress: Search { progress, done: AtomicU64::new(0), total },
    };
    task.run(leans)
}

/// Fineness of tool axes on the grid, as a share of its step: little beside what lies between two
/// rotations of the grid.
const COARSE: f64 = 0.1;

/// Rotations of a level that are improved.
const SEEDS: usize = 64;

/// Halvings of the way from a rotation that fits towards a better one that does not.
const HALVINGS: u32 = 4;

fn check(search: &SetupOptions) -> Result<(), AxesError> {
    search.bounds.check()?;
    let [origin, rotation] = search.digits;
    for (option, value) in [
        ("setup.grid", search.grid),
        ("setup.tolerance", search.tolerance),
        ("setup.alike", search.alike),
        ("setup.digits of the origin", origin),
        ("setup.digits of the rotation", rotation),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(AxesError::BadOption { option, value });
        }
    }
    Ok(())
}

struct Task<'a> {
    kinematics: &'a Kinematics,
    /// The machine without ends of its linear axes.
    endless: Machine,
    path: &'a ToolPath,
    options: &'a AxesOptions,
    search: &'a SetupOptions,
    sight: Sight,
    /// Tool axes of the path.
    fine: Vec<Vector3<f64>>,
    /// Fewer of them.
    coarse: Vec<Vector3<f64>>,
    progress: Search<'a>,
}

/// A rotation and how it shows the path.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    lean: Lean,
    seen: Seen,
}

/// A rotation of the grid, and the best near it.
#[derive(Debug, Clone, Copy)]
struct Climbed {
    from: Candidate,
    best: Candidate,
}

impl Task<'_> {
    fn run(&self, leans: Vec<Lean>) -> Result<SetupSearch, AxesError> {
        let (before, before_axes) = self.before()?;
        let grid = self.grid(leans);
        let looked = grid.len();
        let mut inside: Vec<Candidate> =
            grid.iter().filter(|one| one.seen.beyond <= 0.0).copied().collect();
        let leaning = looked - inside.len();
        inside.sort_by(|a, b| b.seen.least.total_cmp(&a.seen.least));
        let mut others = Vec::new();
        if let (true, Some(least)) = (inside.is_empty(), least_leaning(&grid)) {
            others.push(self.without_axes(&least));
        }
        let mut fitting = self.descend(&inside, &mut others)?;
        if self.search.bounds.holds(&before.lean) && before.verdict.fits().is_some() {
            fitting.push(before.clone());
        }
        self.polish(&mut fitting, &others)?;
        let best = self.confirm(fitting, &mut others)?;
        others.sort_by(order);
        others.dedup_by(|a, b| a.setup == b.setup);
        if let Some((best, _)) = &best {
            others.retain(|other| other.setup != best.setup);
        }
        Ok(SetupSearch { before, before_axes, best, others, looked, leaning })
    }

    fn grid(&self, leans: Vec<Lean>) -> Vec<Candidate> {
        let look =
            |lean: Lean| Candidate { lean, seen: self.sight.look(&self.coarse, &lean.rotation()) };
        leans.into_par_iter().map(look).collect()
    }

    /// The setup as it is, on the machine as it is.
    fn before(&self) -> Result<(Judged, Option<Followed>), AxesError> {
        let setup = *self.kinematics.setup();
        let seen = self.sight.look(&self.fine, &setup.rotation);
        let (verdict, followed) = self.followed(self.kinematics)?;
        let (x, y, z) = setup.rotation.euler_angles();
        let lean = Lean::of(&setup.rotation);
        Ok((Judged { setup, angles: [x, y, z], lean, least: seen.least, verdict }, followed))
    }

    fn followed(&self, on: &Kinematics) -> Result<(Verdict, Option<Followed>), AxesError> {
        match follow(on, self.path, self.options, &self.progress) {
            Ok(followed) => Ok((Verdict::Fits(travelled(&followed)), Some(followed))),
            Err(AxesError::Cancelled(stop)) => Err(stop.into()),
            Err(error) => Ok((Verdict::Fails(error), None)),
        }
    }

    /// Plans rotations of the grid, level after level of least angle, until some fit; those.
    fn descend(
        &self,
        inside: &[Candidate],
        others: &mut Vec<Judged>,
    ) -> Result<Vec<Judged>, AxesError> {
        let mut rest = inside;
        while let Some(best) = rest.first() {
            // A rotation of the grid is no farther than a step from the best near it.
            let floor = best.seen.least - self.search.grid;
            let (level, below) = rest.split_at(rest.partition_point(|c| c.seen.least >= floor));
            rest = below;
            let done = inside.len() - rest.len();
            self.progress.done.store(done as u64, AtomicOrdering::Relaxed);
            let fitting = self.level(level, others)?;
            if !fitting.is_empty() {
                return Ok(fitting);
            }
        }
        Ok(Vec::new())
    }

    /// Of rotations with about the same least angle those that fit.
    fn level(
        &self,
        level: &[Candidate],
        others: &mut Vec<Judged>,
    ) -> Result<Vec<Judged>, Cancelled> {
        let seeds = spread(level, SEEDS);
        let mut climbed: Vec<Climbed> = seeds.par_iter().map(|from| self.climb(from)).collect();
        climbed.sort_by(|a, b| b.best.seen.least.total_cmp(&a.best.seen.least));
        let top = climbed.first().map_or(0.0, |one| one.best.seen.least);
        let alike = climbed.partition_point(|one| one.best.seen.least >= top - self.search.alike);
        let (top, below) = climbed.split_at(alike);
        // Those below tell what else there is.
        let mut tried = spread(top, self.search.batch);
        tried.extend(spread(below, self.search.batch));
        let (mut fitting, mut rest) = self.planned(&tried)?;
        if fitting.is_empty() {
            // Ends of travel leave few: all of them are looked at.
            let (more, fallen) = self.planned(&climbed)?;
            fitting = more;
            rest.extend(fallen);
        }
        others.extend(rest);
        Ok(fitting)
    }

    /// Rotations that fit, and those that do not.
    fn planned(&self, tried: &[Climbed]) -> Result<(Vec<Judged>, Vec<Judged>), Cancelled> {
        let judged: Result<Vec<Judged>, Cancelled> =
            tried.par_iter().map(|one| self.improve(one)).collect();
        Ok(judged?.into_iter().partition(|one| one.verdict.fits().is_some()))
    }

    /// The best rotation near one of the grid; where only that of the grid fits, some way between.
    fn improve(&self, climbed: &Climbed) -> Result<Judged, Cancelled> {
        let (from, to) = (climbed.from.lean, climbed.best.lean);
        let best = self.judge(&to)?;
        if best.verdict.fits().is_some() {
            return Ok(best);
        }
        let mut found = self.judge(&from)?;
        if found.verdict.fits().is_none() {
            return Ok(best);
        }
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let between = self.judge(&from.part_way(&to, middle))?;
            if between.verdict.fits().is_some() {
                (found, low) = (between, middle);
            } else {
                high = middle;
            }
        }
        Ok(found)
    }

    /// Where better rotations fell, what fits lies at the edge of what the travel allows: from there on to the best
    /// that fits near it, ever closer.
    fn polish(&self, fitting: &mut Vec<Judged>, others: &[Judged]) -> Result<(), Cancelled> {
        let by_least = |a: &&Judged, b: &&Judged| a.least.total_cmp(&b.least);
        let Some(mut best) = fitting.iter().max_by(by_least).cloned() else { return Ok(()) };
        if !others.iter().any(|other| other.least > best.least + self.search.alike) {
            return Ok(());
        }
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            let promising = |lean: &Lean| {
                let seen = self.sight.look(&self.fine, &lean.rotation());
                seen.beyond <= 0.0 && seen.least > best.least + self.search.tolerance
            };
            let near: Vec<Lean> =
                self.search.bounds.around(&best.lean, width).filter(promising).collect();
            let judged: Result<Vec<Judged>, Cancelled> =
                near.par_iter().map(|lean| self.judge(lean)).collect();
            let found = judged?
                .into_iter()
                .filter(|one| one.verdict.fits().is_some() && one.least > best.least)
                .max_by(|a, b| a.least.total_cmp(&b.least));
            match found {
                Some(better) => best = better,
                None => width *= 0.5,
            }
        }
        fitting.push(best);
        Ok(())
    }

    /// The best rotation near one: the best of those around, ever closer.
    fn climb(&self, from: &Candidate) -> Climbed {
        let look = |lean: Lean| {
            let seen = self.sight.look(&self.fine, &lean.rotation());
            Candidate { lean, seen }
        };
        let from = look(from.lean);
        let mut best = from;
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            for lean in self.search.bounds.around(&best.lean, width) {
                let near = look(lean);
                if near.seen.before(&best.seen) {
                    best = near;
                }
            }
            width *= 0.5;
        }
        // Whole degrees are easier to clamp.
        let whole = look(best.lean.whole_degrees());
        let as_good =
            whole.seen.beyond <= 0.0 && whole.seen.least >= best.seen.least - self.search.tolerance;
        if as_good && self.search.bounds.holds(&whole.lean) {
            best = whole;
        }
        Climbed { from, best }
    }

    /// The rotation as it would be written, and what the axes do with it.
    fn judge(&self, lean: &Lean) -> Result<Judged, Cancelled> {
        let [_, digit] = self.search.digits;
        let (x, y, z) = lean.rotation().euler_angles();
        let angles = [x, y, z].map(|angle| rounded(angle.to_degrees(), digit).to_radians());
        let before = self.kinematics.setup();
        let mut setup = Setup::new(before.origin, angles, before.tool_length);
        let seen = self.sight.look(&self.fine, &setup.rotation);
        let verdict =
            if seen.beyond > 0.0 { Verdict::Leans(seen.beyond) } else { self.verdict(&mut setup)? };
        Ok(Judged { setup, angles, lean: Lean::of(&setup.rotation), least: seen.least, verdict })
    }

    fn verdict(&self, setup: &mut Setup) -> Result<Verdict, Cancelled> {
        let free = Kinematics::new(&self.endless, setup);
        let followed = match follow(&free, self.path, self.options, &self.progress) {
            Ok(followed) => followed,
            Err(AxesError::Cancelled(stop)) => return Err(stop),
            Err(error) => return Ok(Verdict::Fails(error)),
        };
        let real = Kinematics::new(self.kinematics.machine(), setup);
        Ok(match origin::place(&real, &followed) {
            Some(Place::Fits(origin)) => {
                let [digit, _] = self.search.digits;
                if origin != setup.origin {
                    setup.origin = origin.map(|value| rounded(value, digit));
                }
                Verdict::Fits(travelled(&followed))
            }
            Some(Place::Short { by, axes }) => Verdict::Short { by, axes },
            None => Verdict::Fits(travelled(&followed)),
        })
    }

    fn without_axes(&self, candidate: &Candidate) -> Judged {
        let Candidate { lean, seen } = *candidate;
        let before = self.kinematics.setup();
        let (x, y, z) = lean.rotation().euler_angles();
        let setup = Setup::new(before.origin, [x, y, z], before.tool_length);
        let verdict = Verdict::Leans(seen.beyond);
        Judged { setup, angles: [x, y, z], lean, least: seen.least, verdict }
    }

    /// Of those that fit the best whose axes are found on the machine as it is.
    fn confirm(
        &self,
        mut fitting: Vec<Judged>,
        others: &mut Vec<Judged>,
    ) -> Result<Option<(Judged, Followed)>, AxesError> {
        fitting.sort_by(|a, b| b.least.total_cmp(&a.least));
        let top = fitting.first().map_or(0.0, |one| one.least);
        let alike = fitting.partition_point(|one| one.least >= top - self.search.alike);
        if let Some(first) = fitting.get_mut(..alike) {
            first.sort_by(|a, b| weight(a).total_cmp(&weight(b)));
        }
        let mut best = None;
        for mut one in fitting {
            if best.is_some() {
                others.push(one);
                continue;
            }
            let on = Kinematics::new(self.kinematics.machine(), &one.setup);
            let (verdict, followed) = self.followed(&on)?;
            one.verdict = verdict;
            match followed {
                Some(followed) => best = Some((one, followed)),
                None => others.push(one),
            }
        }
        Ok(best)
    }
}

impl Verdict {
    /// The travel, if the path fits.
    pub fn fits(&self) -> Option<&Travelled> {
        if let Self::Fits(travelled) = self { Some(travelled) } else { None }
    }

    /// The nearer to fitting, the less.
    fn trouble(&self) -> (u8, f64) {
        match self {
            Self::Fits(_) => (0, 0.0),
            Self::Short { by, .. } => (1, *by),
            Self::Leans(by) => (2, *by),
            Self::Fails(_) => (3, 0.0),
        }
    }
}

/// Best first: what fits by its least angle, what does not by what is missing.
fn order(a: &Judged, b: &Judged) -> Ordering {
    let ([class_a, class_b], [by_a, by_b]) = {
        let (a, b) = (a.verdict.trouble(), b.verdict.trouble());
        ([a.0, b.0], [a.1, b.1])
    };
    class_a.cmp(&class_b).then(by_a.total_cmp(&by_b)).then(b.least.total_cmp(&a.least))
}

fn weight(judged: &Judged) -> f64 {
    judged.verdict.fits().map_or(f64::INFINITY, |travelled| travelled.weighted)
}

fn travelled(followed: &Followed) -> Travelled {
    let mut rotary = [0.0; 2];
    for pair in followed.path.pieces.iter().flat_map(|piece| piece.nodes.windows(2)) {
        let moved = pair[1].q[0] - pair[0].q[0];
        rotary[0] += moved[FIRST_ROTARY].abs();
        rotary[1] += moved[SECOND_ROTARY].abs();
    }
    let (weighted, retracts) = (followed.rotary_travel, followed.retracts.len());
    Travelled { rotary, weighted, retracts }
}

fn least_leaning(grid: &[Candidate]) -> Option<Candidate> {
    grid.iter().min_by(|a, b| a.seen.beyond.total_cmp(&b.seen.beyond)).copied()
}

fn rounded(value: f64, digit: f64) -> f64 {
    // + 0 turns -0 into 0.
    (value / digit).round() * digit + 0.0
}

/// Something with a rotation.
trait Turned: Copy + Sync {
    fn rotation(&self) -> Rotation3<f64>;
}

impl Turned for Candidate {
    fn rotation(&self) -> Rotation3<f64> {
        self.lean.rotation()
    }
}

impl Turned for Climbed {
    fn rotation(&self) -> Rotation3<f64> {
        self.best.lean.rotation()
    }
}

/// The first, and of the others those farthest from all taken before.
fn spread<T: Turned>(all: &[T], count: usize) -> Vec<T> {
    let mut far = vec![f64::INFINITY; all.len()];
    let rotations: Vec<Rotation3<f64>> = all.iter().map(Turned::rotation).collect();
    let mut taken = Vec::new();
    let mut next = all.first().map(|_| 0);
    while let Some(index) = next
        && let (Some(one), Some(from)) = (all.get(index), rotations.get(index))
        && taken.len() < count
    {
        taken.push(*one);
        for (far, rotation) in far.iter_mut().zip(&rotations) {
            *far = far.min(from.angle_to(rotation));
        }
        next = farthest(&far);
    }
    taken
}

/// The first of those farthest off, if it is off at all.
fn farthest(far: &[f64]) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (index, &far) in far.iter().enumerate() {
        if far > best.map_or(SAME, |(_, most)| most) {
            best = Some((index, far));
        }
    }
    best.map(|(index, _)| index)
}

/// Rotations closer than this are one \[rad\]: an angle between two is found from a cosine, good to
/// some roots of an ulp.
const SAME: f64 = 1e-6;

/// How far the search is, whatever is told of the paths it tries.
struct Search<'a> {
    progress: &'a dyn Progress,
    done: AtomicU64,
    total: u64,
}

impl Progress for Search<'_> {
    fn report(&self, stage: Stage, _: u64, _: u64) -> ControlFlow<()> {
        self.progress.report(stage, self.done.load(AtomicOrdering::Relaxed), self.total)
    }
}
