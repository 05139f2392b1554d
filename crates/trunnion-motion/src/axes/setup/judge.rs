//! Plans the axes for rotations of the workpiece, and picks among those that fit.

use super::climb::Candidate;
use super::lean::Lean;
use super::proof::Proof;
use super::sight::{Sight, Views};
use super::{Judged, Search, SetupOptions, SetupSearch, Travelled, Verdict};
use crate::axes::origin::{self, Place};
use crate::axes::{AxesError, AxesOptions, Followed, follow};
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, SECOND_ROTARY, Setup};
use crate::types::{Cancelled, ToolPath};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::atomic::Ordering as AtomicOrdering;

pub(super) struct Task<'a> {
    pub(super) kinematics: &'a Kinematics,
    /// The machine without ends of its linear axes.
    pub(super) endless: Machine,
    pub(super) path: &'a ToolPath,
    pub(super) options: &'a AxesOptions,
    pub(super) search: &'a SetupOptions,
    pub(super) sight: Sight,
    /// Tool axes of the path.
    pub(super) views: Views,
    pub(super) progress: Search<'a>,
}

/// What was planned.
#[derive(Debug, Default)]
pub(super) struct Planned {
    /// What fits.
    pub(super) fitting: Vec<Judged>,
    /// What does not.
    pub(super) others: Vec<Judged>,
}

/// Setups beside the best that are told.
const OTHERS: usize = 64;

impl Planned {
    /// The largest least angle \[rad\].
    pub(super) fn least(&self) -> Option<f64> {
        self.fitting.iter().map(|one| one.least).reduce(f64::max)
    }

    pub(super) fn add(&mut self, one: Judged) {
        if one.verdict.fits().is_some() { self.fitting.push(one) } else { self.others.push(one) }
    }
}

impl Task<'_> {
    pub(super) fn run(&self, leans: Vec<Lean>) -> Result<SetupSearch, AxesError> {
        let (before, before_axes) = self.before()?;
        let grid = self.grid(leans);
        let looked = grid.len();
        let leaning = grid.iter().filter(|one| one.seen.leans > 0.0).count();
        let mut inside: Vec<Candidate> =
            grid.iter().filter(|one| one.seen.fits()).copied().collect();
        inside.sort_by(|a, b| b.seen.least.total_cmp(&a.seen.least));
        let mut planned = Planned::default();
        if let (true, Some(least)) = (leaning == looked, least_leaning(&grid)) {
            planned.others.push(self.without_axes(&least));
        }
        self.level(&inside, &mut planned)?;
        if self.search.bounds.holds(&before.lean) && before.verdict.fits().is_some() {
            planned.fitting.push(before.clone());
        }
        self.polish(&mut planned)?;
        self.progress.done.store(self.progress.total, AtomicOrdering::Relaxed);
        let first = planned.least();
        let assurance = Proof::new(self).run(&mut planned)?;
        self.alike(&inside, first, &mut planned)?;
        let best = self.confirm(planned.fitting, &mut planned.others)?;
        let mut others = planned.others;
        others.sort_by(order);
        others.dedup_by(|a, b| a.setup == b.setup);
        if let Some((best, _)) = &best {
            others.retain(|other| other.setup != best.setup);
        }
        others.truncate(OTHERS);
        Ok(SetupSearch { before, before_axes, best, others, looked, leaning, assurance })
    }

    /// Where the best was only found after those of the grid had been planned: rotations of the grid
    /// that are as good.
    fn alike(
        &self,
        inside: &[Candidate],
        first: Option<f64>,
        planned: &mut Planned,
    ) -> Result<(), Cancelled> {
        let Some(best) = planned.least() else { return Ok(()) };
        if first.is_some_and(|first| first >= best - self.search.alike) {
            return Ok(());
        }
        let as_good: Vec<Candidate> = inside
            .iter()
            .filter(|one| (one.seen.least - best).abs() <= self.search.alike)
            .copied()
            .collect();
        let some = super::climb::spread(&as_good, self.search.batch);
        let judged: Result<Vec<Judged>, Cancelled> =
            some.par_iter().map(|one| self.judge(&one.lean)).collect();
        judged?.into_iter().for_each(|one| planned.add(one));
        Ok(())
    }

    /// The setup as it is, on the machine as it is.
    fn before(&self) -> Result<(Judged, Option<Followed>), AxesError> {
        let setup = *self.kinematics.setup();
        let seen = self.sight.glance(self.views.finest(), &setup.rotation);
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

    /// The rotation as it would be written, and what the axes do with it.
    pub(super) fn judge(&self, lean: &Lean) -> Result<Judged, Cancelled> {
        let [_, digit] = self.search.digits;
        let (x, y, z) = lean.rotation().euler_angles();
        let angles = [x, y, z].map(|angle| rounded(angle.to_degrees(), digit).to_radians());
        let before = self.kinematics.setup();
        let mut setup = Setup::new(before.origin, angles, before.tool_length);
        let seen = self.sight.glance(self.views.finest(), &setup.rotation);
        let verdict =
            if seen.leans > 0.0 { Verdict::Leans(seen.leans) } else { self.verdict(&mut setup)? };
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
        let verdict = Verdict::Leans(seen.leans);
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
    grid.iter().min_by(|a, b| a.seen.leans.total_cmp(&b.seen.leans)).copied()
}

fn rounded(value: f64, digit: f64) -> f64 {
    // + 0 turns -0 into 0.
    (value / digit).round() * digit + 0.0
}
