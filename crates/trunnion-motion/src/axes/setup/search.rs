//! The setup search from start to end.

use super::angle_check::{AngleCheck, SampleLevels};
use super::evaluation::{PlannedSetups, SetupTask};
use super::local_search::{SetupCandidate, spread};
use super::optimality_proof::OptimalityProof;
use super::options::SetupOptions;
use super::progress::SearchProgress;
use super::result::{EvaluatedSetup, SetupSearch, SetupVerdict};
use super::workpiece_tilt::WorkpieceTilt;
use crate::axes::error::{self, AxesError};
use crate::axes::options::AxesOptions;
use crate::axes::origins;
use crate::axes::result::FollowedPath;
use crate::inverse::Inverse;
use crate::machine::{Kinematics, Setup};
use crate::math;
use crate::types::{Cancelled, Progress, ToolPath};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::atomic::{AtomicU64, Ordering as AtomicOrdering};

/// Searches the rotation of the workpiece that keeps a path farthest from the singular directions and
/// inside travel, and an origin for it.
///
/// The least angle between tool axis and singular directions is evaluated on a grid of rotations
/// within bounds, the best are improved, and for those the axes are planned over the whole path as
/// `follow` does; where linear travel ends, the origin is moved as little as possible. Then boxes of
/// rotations are halved until no rotation that fits can be better by more than
/// [`SetupOptions::within`]; the rest is reported (`SearchAssurance`). Of planned rotations with
/// (nearly) the same least angle the one with the least rotary travel wins. The setup returned was
/// followed with exactly its own numbers, rounded to the digits of [`SetupOptions`].
///
/// Least angles are those of tool axes no more than [`SetupOptions::tolerance`] apart.
///
/// `options` are those of `follow` for the path.
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
    options: &AxesOptions,
    search: &SetupOptions,
    progress: &dyn Progress,
) -> Result<SetupSearch, AxesError> {
    error::options(options)?;
    check(search)?;
    let inverse = Inverse::new(kinematics).map_err(|source| AxesError::Inverse {
        piece: 0,
        u: 0.0,
        source,
    })?;
    // Everything that does not depend on the rotation is prepared once: tool axes at several steps, and a
    // machine without ends of linear travel.
    let workpieces = search.bounds.grid(search.grid);
    let total = workpieces.len() as u64;
    let task = SetupTask {
        kinematics,
        endless: origins::endless(kinematics.machine()),
        path,
        options,
        search,
        angles: AngleCheck::new(&inverse, options.retract.as_ref()),
        samples: SampleLevels::new(path, COARSE * search.grid, search.tolerance),
        progress: SearchProgress { progress, done: AtomicU64::new(0), total },
    };
    task.run(workpieces)
}

/// Step of the sampled tool axes on the grid, as a share of its own step: small beside the angle between
/// two rotations of the grid.
const COARSE: f64 = 0.1;

fn check(search: &SetupOptions) -> Result<(), AxesError> {
    search.bounds.check()?;
    for (option, value) in [
        ("setup.grid", search.grid),
        ("setup.tolerance", search.tolerance),
        ("setup.alike", search.alike),
        ("setup.within", search.within),
        ("setup.origin_digit", search.origin_digit),
        ("setup.rotation_digit", search.rotation_digit),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(AxesError::BadOption { option, value });
        }
    }
    Ok(())
}

/// Setups beside the best that are reported.
const OTHERS: usize = 64;

impl SetupTask<'_> {
    /// Runs the search on the rotations of the grid.
    pub(super) fn run(&self, workpieces: Vec<WorkpieceTilt>) -> Result<SetupSearch, AxesError> {
        let (before, before_axes) = self.before()?;
        let grid = self.grid(workpieces);
        let evaluated = grid.len();
        let beyond_tilt = grid.iter().filter(|one| one.check.missing_tilt > 0.0).count();
        let mut inside: Vec<SetupCandidate> =
            grid.iter().filter(|one| one.check.fits()).copied().collect();
        inside.sort_by(|a, b| b.check.least.total_cmp(&a.check.least));
        let mut planned = PlannedSetups::default();
        // If the tool-side rotary is too short everywhere, the rotation that lacks least is reported.
        if let (true, Some(least)) = (beyond_tilt == evaluated, least_leaning(&grid)) {
            planned.others.push(self.without_axes(&least));
        }
        self.level(&inside, &mut planned)?;
        // The setup of the job competes where it is within the bounds.
        if self.search.bounds.holds(&before.workpiece) && before.verdict.fits().is_some() {
            planned.fitting.push(before.clone());
        }
        self.polish(&mut planned)?;
        self.progress.done.store(self.progress.total, AtomicOrdering::Relaxed);
        let first = planned.least();
        let assurance = OptimalityProof::new(self).run(&mut planned)?;
        self.alike(&inside, first, &mut planned)?;
        let best = self.confirm(planned.fitting, &mut planned.others)?;
        let mut others = planned.others;
        others.sort_by(order);
        others.dedup_by(|a, b| a.setup == b.setup);
        if let Some((best, _)) = &best {
            others.retain(|other| other.setup != best.setup);
        }
        others.truncate(OTHERS);
        Ok(SetupSearch { before, before_axes, best, others, evaluated, beyond_tilt, assurance })
    }

    /// Plans the rotations of the grid that are as good as the best, if that was found only after those of
    /// the grid had been planned.
    fn alike(
        &self,
        inside: &[SetupCandidate],
        first: Option<f64>,
        planned: &mut PlannedSetups,
    ) -> Result<(), Cancelled> {
        // Where the best was known from the grid already, its equals were planned with it.
        let Some(best) = planned.least() else { return Ok(()) };
        if first.is_some_and(|first| first >= best - self.search.alike) {
            return Ok(());
        }
        let as_good: Vec<SetupCandidate> = inside
            .iter()
            .filter(|one| (one.check.least - best).abs() <= self.search.alike)
            .copied()
            .collect();
        let some = spread(&as_good, self.search.batch);
        let judged: Result<Vec<EvaluatedSetup>, Cancelled> =
            some.par_iter().map(|one| self.evaluate(&one.workpiece)).collect();
        judged?.into_iter().for_each(|one| planned.add(one));
        Ok(())
    }

    /// Evaluates the setup of the job, origin and all.
    fn before(&self) -> Result<(EvaluatedSetup, Option<FollowedPath>), AxesError> {
        let setup = *self.kinematics.setup();
        let check = self.angles.check_angles(self.samples.finest(), &setup.rotation);
        let (verdict, followed) = self.followed(self.kinematics)?;
        let angles = math::xyz_of_rotation(&setup.rotation).into();
        let workpiece = WorkpieceTilt::of(&setup.rotation);
        Ok((EvaluatedSetup { setup, angles, workpiece, least: check.least, verdict }, followed))
    }

    /// Reports a rotation that needs the tool-side rotary beyond its travel, without planning its axes.
    fn without_axes(&self, candidate: &SetupCandidate) -> EvaluatedSetup {
        let SetupCandidate { workpiece, check } = *candidate;
        let before = self.kinematics.setup();
        let angles = math::xyz_of_rotation(&workpiece.rotation()).into();
        let setup = Setup::new(before.origin, angles, before.tool_length);
        let verdict = SetupVerdict::BeyondTilt(check.missing_tilt);
        EvaluatedSetup { setup, angles, workpiece, least: check.least, verdict }
    }

    /// Returns the best of those that fit whose axes are found with all ends of travel; the others are
    /// appended to `others`.
    fn confirm(
        &self,
        mut fitting: Vec<EvaluatedSetup>,
        others: &mut Vec<EvaluatedSetup>,
    ) -> Result<Option<(EvaluatedSetup, FollowedPath)>, AxesError> {
        // Best least angle first; among those alike the least rotary travel first.
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
            // Planned before without ends of linear travel: this run is the one that counts.
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

/// Orders best first: setups that fit by their least angle, the others by what is missing.
fn order(a: &EvaluatedSetup, b: &EvaluatedSetup) -> Ordering {
    let ([class_a, class_b], [by_a, by_b]) = {
        let (a, b) = (a.verdict.trouble(), b.verdict.trouble());
        ([a.0, b.0], [a.1, b.1])
    };
    class_a.cmp(&class_b).then(by_a.total_cmp(&by_b)).then(b.least.total_cmp(&a.least))
}

fn weight(judged: &EvaluatedSetup) -> f64 {
    judged.verdict.fits().map_or(f64::INFINITY, |travelled| travelled.weighted)
}

fn least_leaning(grid: &[SetupCandidate]) -> Option<SetupCandidate> {
    grid.iter().min_by(|a, b| a.check.missing_tilt.total_cmp(&b.check.missing_tilt)).copied()
}
