//! Local search: the best rotations of a grid, and the best near them.

use super::angle_check::AngleResult;
use super::evaluation::{PlannedSetups, SetupTask};
use super::result::EvaluatedSetup;
use super::workpiece_tilt::WorkpieceTilt;
use crate::math;
use crate::types::Cancelled;
use nalgebra::Rotation3;
use rayon::prelude::*;

/// Rotations of the grid that are improved.
const SEEDS: usize = 64;

/// Halvings of the distance from a rotation that fits towards a better one that does not.
const HALVINGS: u32 = 4;

/// A rotation, judged by its angles.
#[derive(Debug, Clone, Copy)]
pub(super) struct SetupCandidate {
    pub(super) workpiece: WorkpieceTilt,
    pub(super) check: AngleResult,
}

/// A rotation, and the best near it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImprovedCandidate {
    pub(super) from: SetupCandidate,
    pub(super) best: SetupCandidate,
}

impl SetupTask<'_> {
    /// Judges the rotations of the grid by their angles.
    pub(super) fn grid(&self, workpieces: Vec<WorkpieceTilt>) -> Vec<SetupCandidate> {
        let samples = self.samples.within(self.search.grid);
        let judge = |workpiece: WorkpieceTilt| SetupCandidate {
            workpiece,
            check: self.angles.check(samples, &workpiece.rotation()),
        };
        workpieces.into_par_iter().map(judge).collect()
    }

    /// Plans the best of the grid; `inside` has the best first.
    pub(super) fn level(
        &self,
        inside: &[SetupCandidate],
        planned: &mut PlannedSetups,
    ) -> Result<(), Cancelled> {
        // Turning the workpiece by an angle changes the least angle by that much at most: what is more than
        // a grid step below the best cannot have a better rotation near it.
        let floor = inside.first().map_or(0.0, |best| best.check.least - self.search.grid);
        let (level, _) = inside.split_at(inside.partition_point(|one| one.check.least >= floor));
        let seeds = spread(level, SEEDS);
        let mut climbed: Vec<ImprovedCandidate> =
            seeds.par_iter().map(|from| self.climb(from)).collect();
        climbed.sort_by(|a, b| b.best.check.least.total_cmp(&a.best.check.least));
        let top = climbed.first().map_or(0.0, |one| one.best.check.least);
        let alike = climbed.partition_point(|one| one.best.check.least >= top - self.search.alike);
        let (top, below) = climbed.split_at(alike);
        // The axes may not fit the best: others, far apart from each other, are planned as well.
        let mut tried = spread(top, self.search.batch);
        tried.extend(spread(below, self.search.batch));
        let all: Result<Vec<Vec<EvaluatedSetup>>, Cancelled> =
            tried.par_iter().map(|one| self.improve(one)).collect();
        all?.into_iter().flatten().for_each(|one| planned.add(one));
        Ok(())
    }

    /// Plans the best rotation near one; if only the one itself fits, rotations between both by bisection.
    /// Returns all that was planned, what fits last.
    pub(super) fn improve(
        &self,
        climbed: &ImprovedCandidate,
    ) -> Result<Vec<EvaluatedSetup>, Cancelled> {
        let (from, to) = (climbed.from.workpiece, climbed.best.workpiece);
        let best = self.evaluate(&to)?;
        if best.verdict.fits().is_some() || from == to {
            return Ok(vec![best]);
        }
        let mut found = self.evaluate(&from)?;
        if found.verdict.fits().is_none() {
            return Ok(vec![best, found]);
        }
        // `low` fits and `high` does not: the least angle grows from one to the other.
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let between = self.evaluate(&from.part_way(&to, middle))?;
            if between.verdict.fits().is_some() {
                (found, low) = (between, middle);
            } else {
                high = middle;
            }
        }
        Ok(vec![best, found])
    }

    /// Searches from the best rotation that fits for better ones near it that fit as well, in ever smaller
    /// steps. Where better rotations do not fit, the best lies at the edge of travel.
    pub(super) fn polish(&self, planned: &mut PlannedSetups) -> Result<(), Cancelled> {
        let by_least = |a: &&EvaluatedSetup, b: &&EvaluatedSetup| a.least.total_cmp(&b.least);
        let Some(mut best) = planned.fitting.iter().max_by(by_least).cloned() else {
            return Ok(());
        };
        let enough = |one: &EvaluatedSetup| one.least <= best.least + self.search.alike;
        if planned.others.iter().all(enough) {
            return Ok(());
        }
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            // Planning the axes takes long: only rotations that are better by their angles are planned.
            let promising = |workpiece: &WorkpieceTilt| {
                let check = self.angles.check(self.samples.finest(), &workpiece.rotation());
                check.fits() && check.least > best.least + self.search.tolerance
            };
            let near: Vec<WorkpieceTilt> =
                self.search.bounds.around(&best.workpiece, width).filter(promising).collect();
            let judged: Result<Vec<EvaluatedSetup>, Cancelled> =
                near.par_iter().map(|workpiece| self.evaluate(workpiece)).collect();
            let fits =
                |one: &EvaluatedSetup| one.verdict.fits().is_some() && one.least > best.least;
            let found = judged?.into_iter().filter(fits).max_by(|a, b| a.least.total_cmp(&b.least));
            match found {
                Some(better) => best = better,
                None => width *= 0.5,
            }
        }
        planned.add(best);
        Ok(())
    }

    /// Finds the best rotation near one, by angles: the best of a small grid around it, which shrinks.
    pub(super) fn climb(&self, from: &SetupCandidate) -> ImprovedCandidate {
        let finest = self.samples.finest();
        let check = self.angles.check(finest, &from.workpiece.rotation());
        let from = SetupCandidate { check, ..*from };
        let mut best = from;
        let mut width = self.search.grid;
        while width > self.search.tolerance {
            let samples = self.samples.within(width);
            best.check = self.angles.check(samples, &best.workpiece.rotation());
            for workpiece in self.search.bounds.around(&best.workpiece, width) {
                let rotation = workpiece.rotation();
                let angles = self.angles.check_angles(samples, &rotation);
                // Rotary travel can only make a rotation worse: what loses without it loses with it.
                if !angles.before(&best.check) {
                    continue;
                }
                let check = self.angles.check(samples, &rotation);
                if check.before(&best.check) {
                    best = SetupCandidate { workpiece, check };
                }
            }
            width *= 0.5;
        }
        best.check = self.angles.check(finest, &best.workpiece.rotation());
        // Whole degrees are easier to clamp.
        let workpiece = best.workpiece.whole_degrees();
        let check = self.angles.check(finest, &workpiece.rotation());
        let as_good = check.fits() && check.least >= best.check.least - self.search.tolerance;
        if as_good && self.search.bounds.holds(&workpiece) {
            best = SetupCandidate { workpiece, check };
        }
        // Coarse samples chose the way: on the finest ones the start may be the better.
        if from.check.before(&best.check) && !as_good {
            best = from;
        }
        ImprovedCandidate { from, best }
    }
}

/// Something with a rotation.
pub(super) trait HasRotation: Copy + Sync {
    fn rotation(&self) -> Rotation3<f64>;
}

impl HasRotation for SetupCandidate {
    fn rotation(&self) -> Rotation3<f64> {
        self.workpiece.rotation()
    }
}

impl HasRotation for ImprovedCandidate {
    fn rotation(&self) -> Rotation3<f64> {
        self.best.workpiece.rotation()
    }
}

/// Picks up to `count` rotations: the first, and then always the one farthest from all picked before.
pub(super) fn spread<T: HasRotation>(all: &[T], count: usize) -> Vec<T> {
    // Angle of each rotation to the nearest one picked (farthest-point sampling).
    let mut far = vec![f64::INFINITY; all.len()];
    let rotations: Vec<Rotation3<f64>> = all.iter().map(HasRotation::rotation).collect();
    let mut taken = Vec::new();
    let mut next = all.first().map(|_| 0);
    while let Some(index) = next
        && let (Some(one), Some(from)) = (all.get(index), rotations.get(index))
        && taken.len() < count
    {
        taken.push(*one);
        for (far, rotation) in far.iter_mut().zip(&rotations) {
            *far = far.min(math::angle_apart(from, rotation));
        }
        next = farthest(&far);
    }
    taken
}

/// Returns the first of those farthest off, if it is farther than rounding.
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
