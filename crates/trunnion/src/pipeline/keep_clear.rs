//! Changes of a plan after which bodies of the machine and fixtures keep clear: another branch, other links, another lean.

use super::collisions::fixtures_summary;
use super::job::Job;
use super::program::{CheckedProgram, NearMoves};
use super::rotary_half::RotaryHalf;
use super::solids::Solids;
use crate::files::job::{JobLinks, JobPlacement};
use crate::files::summary::ApproachSummary;
use crate::verify::BodyApproach;

/// Heights by which links rise above their clearance \[mm\].
const HIGHER: [f64; 3] = [10.0, 25.0, 50.0];

/// Inclinations of a tool that leans at the choice of the planner \[deg\].
const LEANS: [f64; 3] = [20.0, 30.0, 5.0];

/// Difference of two inclinations that are the same \[rad\].
const ALIKE: f64 = 1e-6;

/// Change of how a job is planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PlanChange {
    /// The axes stay on other branches.
    Branch(RotaryHalf),
    /// Links go up to their clearance everywhere, without hops.
    Retracts,
    /// Links go up to a clearance that is larger by a length \[mm\], without hops.
    HigherLinks(f64),
    /// The tool leans by another angle \[rad\].
    Lean(f64),
}

/// Moves of the programs of a job that come too near something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NearThings {
    fixtures: NearMoves,
    bodies: NearMoves,
}

impl NearThings {
    /// Returns the moves of programs that come too near something.
    pub(super) fn of(programs: &[CheckedProgram]) -> Self {
        let joined = |of: fn(&CheckedProgram) -> NearMoves| {
            programs.iter().map(of).fold(NearMoves::default(), NearMoves::or)
        };
        Self {
            fixtures: joined(|program| program.too_near),
            bodies: joined(|program| program.bodies_near),
        }
    }

    /// Returns true if anything comes too near.
    pub(super) fn any(self) -> bool {
        self.fixtures.any() || self.bodies.any()
    }

    /// Returns the changes that may help, those that take least time to plan first.
    pub(super) fn changes(self, job: &Job) -> Vec<PlanChange> {
        let mut changes = Vec::new();
        // A link that comes too near beside a cut that does is of no use alone.
        if !(self.fixtures.cuts || self.bodies.cuts) {
            if job.operations().any(|one| one.file.strategy.links == JobLinks::Hop) {
                changes.push(PlanChange::Retracts);
            }
            changes.extend(HIGHER.map(PlanChange::HigherLinks));
        }
        // The tool stands before the fixtures in the same way on every branch.
        if self.bodies.any() && !self.fixtures.any() {
            let halves = RotaryHalf::all(job.kinematics.machine());
            changes.extend(halves.into_iter().map(PlanChange::Branch));
        }
        if self.fixtures.cuts || self.bodies.cuts {
            let leans: Vec<f64> = job.operations().filter_map(lean).collect();
            let is_other = |angle: &f64| leans.iter().any(|lean| (lean - angle).abs() > ALIKE);
            let others = LEANS.map(f64::to_radians).into_iter().filter(is_other);
            changes.extend(others.map(PlanChange::Lean));
        }
        changes
    }
}

/// Returns the inclination that the planner has chosen for an operation; `None` if it did not.
fn lean(job: &Job) -> Option<f64> {
    match job.file.strategy.method {
        JobPlacement::Leaning { angle } => Some(angle),
        _ => None,
    }
}

impl PlanChange {
    /// Returns true if the passes are others afterwards.
    pub(super) fn moves_passes(self) -> bool {
        matches!(self, Self::Lean(_))
    }

    /// Returns true if the links between the passes are others afterwards.
    pub(super) fn moves_links(self) -> bool {
        matches!(self, Self::Lean(_) | Self::Retracts | Self::HigherLinks(_))
    }

    /// Returns the job with the change in all of its operations.
    pub(super) fn job(self, job: &Job) -> Job {
        let mut changed = job.clone();
        self.apply(&mut changed);
        changed.following.iter_mut().for_each(|one| self.apply(one));
        changed
    }

    fn apply(self, job: &mut Job) {
        match self {
            Self::Branch(half) => job.kinematics = half.of(&job.kinematics),
            Self::Retracts => job.file.strategy.links = JobLinks::Retract,
            Self::HigherLinks(by) => {
                // Hops stay below the clearance.
                job.file.strategy.links = JobLinks::Retract;
                job.file.setup.clearance += by;
            }
            Self::Lean(angle) => {
                if let JobPlacement::Leaning { angle: lean } = &mut job.file.strategy.method {
                    *lean = angle;
                }
            }
        }
    }

    /// Describes what the change was for and what it is, with the times before and after \[s\].
    pub(super) fn describe(self, job: &Job, near: &str, [before, after]: [f64; 2]) -> String {
        let what = match self {
            Self::Branch(half) => half.describe(job.kinematics.machine()),
            Self::Retracts => {
                "links go up to the clearance above the part, without hops".to_owned()
            }
            Self::HigherLinks(by) => {
                let to = job.file.setup.clearance + by;
                format!(
                    "links go up to {to} mm above the part, without hops (setup.clearance = {to})"
                )
            }
            Self::Lean(angle) => {
                let from = job.operations().find_map(lean).unwrap_or_default().to_degrees();
                format!("the tool leans by {:.0} instead of {from:.0} deg", angle.to_degrees())
            }
        };
        format!(
            "{near} on the quickest plan: {what}, where all keeps clear; {after:.1} instead of {before:.1} s"
        )
    }
}

/// Describes the nearest approach in the programs, and its line.
pub(super) fn nearest(programs: &[CheckedProgram], solids: &Solids) -> String {
    let bodies = programs.iter().filter_map(|program| {
        let near = program.bodies.iter().flat_map(|found| &found.near);
        let nearest = near.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let BodyApproach { line, bodies: [one, other], .. } = nearest;
        Some(format!("{one} and {other} come too near each other ({} line {line})", program.file))
    });
    let fixtures = programs.iter().filter_map(|program| {
        let summary = fixtures_summary(program, solids)?;
        let near = summary.near.iter();
        let nearest = near.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let ApproachSummary { line, fixture, .. } = nearest;
        Some(format!("the tool comes too near fixture {fixture} ({} line {line})", program.file))
    });
    bodies.chain(fixtures).next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{job, machine};
    use crate::import::surface_json;
    use crate::surface::Face;

    const PATCH: &str = include_str!("../../../../fixtures/small-patch/patch.json");
    const JOB: &str = include_str!("../../../../fixtures/small-patch/job.toml");
    const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");

    fn job() -> Job {
        let machine = machine::parse(MACHINE).unwrap().machine;
        let surface = surface_json::read(PATCH.as_bytes()).unwrap();
        let face = Face::new(1, surface, Vec::new()).unwrap();
        Job::new(job::parse(JOB).unwrap(), &[face], &machine).unwrap()
    }

    #[test]
    fn links_change_where_links_alone_come_too_near() {
        let job = job();
        let links = NearMoves { links: true, cuts: false };
        let none = NearMoves::default();
        let near = NearThings { fixtures: links, bodies: none };
        let changes = near.changes(&job);
        assert_eq!(changes[0], PlanChange::Retracts);
        assert_eq!(changes[1..], HIGHER.map(PlanChange::HigherLinks));
        assert_eq!(changes[0].job(&job).file.strategy.links, JobLinks::Retract);
        let before = job.file.setup.clearance;
        let higher = changes[1].job(&job).file;
        assert_eq!(higher.strategy.links, JobLinks::Retract);
        let after = higher.setup.clearance;
        assert!((after - before - HIGHER[0]).abs() < 1e-12, "{before} {after}");
        // A tool whose widest strips decide its inclination does not lean otherwise; before fixtures all branches are alike.
        let cuts = NearMoves { links: true, cuts: true };
        assert!(NearThings { fixtures: cuts, bodies: none }.changes(&job).is_empty());
        let branches = NearThings { fixtures: none, bodies: cuts }.changes(&job);
        assert!(!branches.is_empty());
        assert!(branches.iter().all(|change| matches!(change, PlanChange::Branch(_))));
    }
}
