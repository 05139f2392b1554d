//! Good rotations fast: the best of a grid, and the best near them.

use super::Judged;
use super::judge::{Planned, Task};
use super::lean::Lean;
use super::sight::Seen;
use crate::types::Cancelled;
use nalgebra::Rotation3;
use rayon::prelude::*;

/// Rotations of a level that are improved.
const SEEDS: usize = 64;

/// Halvings of the way from a rotation that fits towards a better one that does not.
const HALVINGS: u32 = 4;

/// A rotation and how it shows the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) lean: Lean,
    pub(super) seen: Seen,
}

/// A rotation, and the best near it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Climbed {
    pub(super) from: Candidate,
    pub(super) best: Candidate,
}

impl Task<'_> {
    pub(super) fn grid(&self, leans: Vec<Lean>) -> Vec<Candidate> {
        let view = self.views.within(self.search.grid);
        let look = |lean: Lean| Candidate { lean, seen: self.sight.look(view, &lean.rotation()) };
        leans.into_par_iter().map(look).collect()
    }

    /// Plans the best of the grid; `inside` has the best first.
    pub(super) fn level(
        &self,
        inside: &[Candidate],
        planned: &mut Planned,
    ) -> Result<(), Cancelled> {
        // A rotation of the grid is no farther than a step from the best near it.
        let floor = inside.first().map_or(0.0, |best| best.seen.least - self.search.grid);
        let (level, _) = inside.split_at(inside.partition_point(|one| one.seen.least >= floor));
        let seeds = spread(level, SEEDS);
        let mut climbed: Vec<Climbed> = seeds.par_iter().map(|from| self.climb(from)).collect();
        climbed.sort_by(|a, b| b.best.seen.least.total_cmp(&a.best.seen.least));
        let top = climbed.first().map_or(0.0, |one| one.best.seen.least);
        let alike = climbed.partition_point(|one| one.best.seen.least >= top - self.search.alike);
        let (top, below) = climbed.split_at(alike);
        // Those below tell what else there is.
        let mut tried = spread(top, self.search.batch);
        tried.extend(spread(below, self.search.batch));
        let all: Result<Vec<Vec<Judged>>, Cancelled> =
            tried.par_iter().map(|one| self.improve(one)).collect();
        all?.into_iter().flatten().for_each(|one| planned.add(one));
        Ok(())
    }

    /// The best rotation near one; where only that one fits, some way between. All that was planned,
    /// what fits last.
    pub(super) fn improve(&self, climbed: &Climbed) -> Result<Vec<Judged>, Cancelled> {
        let (from, to) = (climbed.from.lean, climbed.best.lean);
        let best = self.judge(&to)?;
        if best.verdict.fits().is_some() || from == to {
            return Ok(vec![best]);
        }
        let mut found = self.judge(&from)?;
        if found.verdict.fits().is_none() {
            return Ok(vec![best, found]);
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
        Ok(vec![best, found])
    }

    /// Where better rotations fell, what fits lies at the edge of what the travel allows: from there on
    /// to the best that fits near it, ever closer.
    pub(super) fn polish(&self, planned: &mut Planned) -> Result<(), Cancelled> {
        let by_least = |a: &&Judged, b: &&Judged| a.least.total_cmp(&b.least);
        let Some(mut best) = planned.fitting.iter().max_by(by_least).cloned() else {
            return Ok(());
        };
        let enough = |one: &Judged| one.least <= best.least + self.search.alike;
        if planned.others.iter().all(enough) {
            return Ok(());
        }
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            let promising = |lean: &Lean| {
                let seen = self.sight.look(self.views.finest(), &lean.rotation());
                seen.fits() && seen.least > best.least + self.search.tolerance
            };
            let near: Vec<Lean> =
                self.search.bounds.around(&best.lean, width).filter(promising).collect();
            let judged: Result<Vec<Judged>, Cancelled> =
                near.par_iter().map(|lean| self.judge(lean)).collect();
            let fits = |one: &Judged| one.verdict.fits().is_some() && one.least > best.least;
            let found = judged?.into_iter().filter(fits).max_by(|a, b| a.least.total_cmp(&b.least));
            match found {
                Some(better) => best = better,
                None => width *= 0.5,
            }
        }
        planned.add(best);
        Ok(())
    }

    /// The best rotation near one: the best of those around, ever closer.
    pub(super) fn climb(&self, from: &Candidate) -> Climbed {
        let finest = self.views.finest();
        let from = Candidate { seen: self.sight.look(finest, &from.lean.rotation()), ..*from };
        let mut best = from;
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            let view = self.views.within(width);
            best.seen = self.sight.look(view, &best.lean.rotation());
            for lean in self.search.bounds.around(&best.lean, width) {
                let rotation = lean.rotation();
                let glance = self.sight.glance(view, &rotation);
                // What the rotaries do makes nothing better.
                if !glance.before(&best.seen) {
                    continue;
                }
                let seen = self.sight.look(view, &rotation);
                if seen.before(&best.seen) {
                    best = Candidate { lean, seen };
                }
            }
            width *= 0.5;
        }
        best.seen = self.sight.look(finest, &best.lean.rotation());
        // Whole degrees are easier to clamp.
        let lean = best.lean.whole_degrees();
        let seen = self.sight.look(finest, &lean.rotation());
        let as_good = seen.fits() && seen.least >= best.seen.least - self.search.tolerance;
        if as_good && self.search.bounds.holds(&lean) {
            best = Candidate { lean, seen };
        }
        // The path in more detail may show the start as the better.
        if from.seen.before(&best.seen) && !as_good {
            best = from;
        }
        Climbed { from, best }
    }
}

/// Something with a rotation.
pub(super) trait Turned: Copy + Sync {
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
pub(super) fn spread<T: Turned>(all: &[T], count: usize) -> Vec<T> {
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
