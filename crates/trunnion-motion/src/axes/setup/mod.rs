//! The setup search: a rotation of the workpiece that keeps a path far from the singular directions
//! and inside travel.
//!
//! `sight` looks at a rotation by angles alone, `turning` knows the ends of travel of the rotaries;
//! `judge` plans the axes. `climb` finds good rotations fast; `proof` halves boxes of rotations (`cell`)
//! until none is left that could hold a better one.

mod cell;
mod climb;
mod judge;
mod lean;
mod proof;
mod sight;
mod turning;

pub use lean::{Lean, LeanBounds};

use super::origin;
use super::{AxesError, AxesOptions, Followed, error};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, Setup};
use crate::types::{Progress, Stage, ToolPath};
use judge::Task;
use sight::{Sight, Views};
use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

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
    /// No rotation within bounds is to be better than the best by more than this \[rad\].
    pub within: f64,
    /// Rotations looked at and planned to show that, at most; where they do not suffice, what is shown
    /// is less.
    pub most: [usize; 2],
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
    /// What is known of all others.
    pub assurance: Assurance,
}

/// What is known of all rotations within the bounds.
///
/// Turning the workpiece by an angle changes the angle between tool axis and singular directions by
/// that angle at most, and bounds how far the rotaries move; so one rotation tells of all about it. The
/// bounds are halved until no part of them can hold a better rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assurance {
    /// The least angle of none that fits is larger \[rad\]; `None`: none fits.
    pub bound: Option<f64>,
    /// This does not hold for rotations nearer than this \[rad\] to one that was planned in vain for
    /// another reason than the ends of travel of the rotaries.
    pub except: f64,
    /// Rotations that were looked at.
    pub looked: usize,
    /// Rotations whose axes were planned.
    pub planned: usize,
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
/// [`follow`](super::follow) does; where linear travel ends, the origin is moved as little as can be. Then boxes of
/// rotations are halved until no rotation that fits can be better by more than
/// [`SetupOptions::within`]; what is left open is told ([`Assurance`]). Of rotations with (nearly) the
/// same least angle that were planned the one with the least rotary travel wins. What is returned was
/// followed with the very numbers of its setup, rounded to [`SetupOptions::digits`].
///
/// Least angles are those of tool axes no more than [`SetupOptions::tolerance`] apart.
///
/// `options` are those of [`follow`](super::follow) for the path.
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
    error::options(options)?;
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
        sight: Sight::new(&inverse, options.retract.is_none()),
        views: Views::new(path, COARSE * search.grid, search.tolerance),
        progress: Search { progress, done: AtomicU64::new(0), total },
    };
    task.run(leans)
}

/// Fineness of tool axes on the grid, as a share of its step: little beside what lies between two
/// rotations of the grid.
const COARSE: f64 = 0.1;

fn check(search: &SetupOptions) -> Result<(), AxesError> {
    search.bounds.check()?;
    let [origin, rotation] = search.digits;
    for (option, value) in [
        ("setup.grid", search.grid),
        ("setup.tolerance", search.tolerance),
        ("setup.alike", search.alike),
        ("setup.within", search.within),
        ("setup.digits of the origin", origin),
        ("setup.digits of the rotation", rotation),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(AxesError::BadOption { option, value });
        }
    }
    Ok(())
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

/// How far the search is, whatever is told of the paths it tries.
struct Search<'a> {
    progress: &'a dyn Progress,
    done: AtomicU64,
    total: u64,
}

impl Progress for Search<'_> {
    fn report(&self, stage: Stage, _: u64, _: u64) -> ControlFlow<()> {
        self.progress.report(stage, self.done.load(Ordering::Relaxed), self.total)
    }
}
