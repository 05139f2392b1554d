//! Advice for programs in which bodies of the machine come too near.

use super::job::Job;
use super::program::CheckedProgram;
use super::solids::Solids;
use crate::cutter::{Cutter, CutterSpec};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, RotaryPair, Setup};
use crate::types::AxisVector;
use crate::verify::{BodyApproach, StandingBodies};
use nalgebra::Vector3;

/// Lengths that are tried \[mm\].
const TRIED: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 150.0, 200.0];

/// Most approaches for which a remedy is tried: the nearest of each program.
const MOST_TRIED: usize = 100;

/// Change of a setup that may keep bodies clear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SetupChange {
    /// The tool stands out farther.
    LongerTool,
    /// The part is farther from the table, along the machine's z.
    HigherPart,
}

impl SetupChange {
    fn words(self, length: f64) -> String {
        match self {
            Self::LongerTool => format!("a tool that stands out {length} mm more"),
            Self::HigherPart => format!("a part that lies {length} mm higher"),
        }
    }
}

/// Returns the nearest pair with its line, and the least changes of the setup after which the reported lines keep clear.
///
/// The tool keeps its locations on the part, and the rotary axes their angles.
pub(super) fn remedy(job: &Job, programs: &[CheckedProgram], solids: &Solids) -> Option<String> {
    let near: Vec<&BodyApproach> = programs
        .iter()
        .filter_map(|program| program.bodies.as_ref())
        .flat_map(|found| found.near.iter().take(MOST_TRIED))
        .collect();
    if let Some([one, other]) = near_at_home(job, programs, solids) {
        let clearance = job.file.fixture_clearance;
        return Some(format!(
            "bodies of the machine: {one} and {other} are nearer than {clearance} mm with all axes at home already, which no plan \
             changes: lower verify.fixture_clearance, or name the pair in `touches` of the machine file"
        ));
    }
    let worst = near.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))?;
    let BodyApproach { line, bodies: [one, other], .. } = worst;
    let what = format!(
        "bodies of the machine: {one} and {other} come nearest, line {line}, and no other branch, link or lean that was tried \
         keeps all clear"
    );
    let helps =
        [SetupChange::LongerTool, SetupChange::HigherPart].into_iter().filter_map(|change| {
            let clears = |length: &&f64| {
                let changed = ChangedSetup { change, length: **length };
                // Operations have tools of their own; which one a line belongs to does not matter if all of them keep clear.
                job.operations().all(|one| is_clear(one, solids, &near, changed))
            };
            Some(change.words(*TRIED.iter().find(clears)?))
        });
    let helps: Vec<String> = helps.collect();
    let longest = TRIED[TRIED.len() - 1];
    let helps = if helps.is_empty() {
        format!(
            "neither a longer tool nor a higher part, by up to {longest} mm, helps on the reported lines"
        )
    } else {
        format!("{} keeps the reported lines clear", helps.join(", or "))
    };
    Some(format!("{what}: {helps}; `trunnion setup` searches another rotation of the part"))
}

/// Returns the first pair that comes too near in programs and is too near at home already.
pub(super) fn near_at_home(
    job: &Job,
    programs: &[CheckedProgram],
    solids: &Solids,
) -> Option<[String; 2]> {
    let watched = solids.machine.as_ref()?;
    let kinematics = &job.kinematics;
    let standing = StandingBodies { bodies: watched.bodies(), cutter: &job.cutter, kinematics };
    let found = programs.iter().filter_map(|program| program.bodies.as_ref());
    let mut pairs: Vec<&[String; 2]> = Vec::new();
    for near in found.flat_map(|found| &found.near) {
        if !pairs.contains(&&near.bodies) {
            pairs.push(&near.bodies);
        }
    }
    let home = kinematics.machine().home();
    let clearance = watched.watch().clearance;
    pairs.into_iter().find(|names| !standing.keep_clear(names, &home, clearance)).cloned()
}

/// Change of a setup by a length.
#[derive(Clone, Copy)]
struct ChangedSetup {
    change: SetupChange,
    /// Length by which the tool is longer, or the part higher \[mm\].
    length: f64,
}

impl ChangedSetup {
    fn setup(&self, before: &Setup) -> Setup {
        let mut setup = *before;
        match self.change {
            SetupChange::LongerTool => setup.tool_length += self.length,
            SetupChange::HigherPart => setup.origin += Vector3::z() * self.length,
        }
        setup
    }

    /// Returns the cutter, its shank and holder moved up by the length.
    fn cutter(&self, before: &Cutter) -> Option<Cutter> {
        if self.change == SetupChange::HigherPart {
            return Some(before.clone());
        }
        let spec = before.spec();
        let shank = spec.shank.iter().map(|[height, radius]| [height + self.length, *radius]);
        let longer = CutterSpec {
            length: spec.length + self.length,
            shank: shank.collect(),
            ..spec.clone()
        };
        Cutter::new(longer).ok()
    }
}

/// Returns true if a change keeps all approaches clear, at the same tool locations.
fn is_clear(job: &Job, solids: &Solids, near: &[&BodyApproach], changed: ChangedSetup) -> bool {
    let Some(watched) = &solids.machine else { return false };
    let kinematics =
        Kinematics::new(job.kinematics.machine(), &changed.setup(job.kinematics.setup()));
    let (Ok(inverse), Some(cutter)) = (Inverse::new(&kinematics), changed.cutter(&job.cutter))
    else {
        return false;
    };
    let standing =
        StandingBodies { bodies: watched.bodies(), cutter: &cutter, kinematics: &kinematics };
    let machine = kinematics.machine();
    near.iter().all(|approach| {
        let [first, second] = [0, 1].map(|k| approach.axes[FIRST_ROTARY + k]);
        let tip = job.kinematics.forward(&approach.axes).tip;
        let moved = inverse.at_rotaries(&tip, RotaryPair { first, second });
        let within = |q: &AxisVector| {
            machine.axes.iter().enumerate().all(|(k, axis)| axis.limits.contains(q[k]))
        };
        moved.is_ok_and(|q| {
            within(&q) && standing.keep_clear(&approach.bodies, &q, watched.watch().clearance)
        })
    })
}
