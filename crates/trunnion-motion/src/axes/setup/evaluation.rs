//! Plans the axes for rotations of the workpiece, and picks among those that fit.

use super::angle_check::{AngleCheck, SampleLevels};
use super::options::SetupOptions;
use super::progress::SearchProgress;
use super::result::{EvaluatedSetup, PathTravel, SetupVerdict};
use super::workpiece_tilt::WorkpieceTilt;
use crate::axes::error::AxesError;
use crate::axes::follow::follow;
use crate::axes::options::AxesOptions;
use crate::axes::origins::{self, OriginFit};
use crate::axes::result::FollowedPath;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, RotaryPair, SECOND_ROTARY, Setup};
use crate::math;
use crate::types::{Cancelled, ToolPath};

/// Everything that a setup search works with.
pub(super) struct SetupTask<'a> {
    pub(super) kinematics: &'a Kinematics,
    /// The machine without ends of travel of its linear axes.
    pub(super) endless: Machine,
    pub(super) path: &'a ToolPath,
    pub(super) options: &'a AxesOptions,
    pub(super) search: &'a SetupOptions,
    pub(super) angles: AngleCheck,
    /// Tool axes of the path.
    pub(super) samples: SampleLevels,
    pub(super) progress: SearchProgress<'a>,
}

/// Setups whose axes were planned.
#[derive(Debug, Default)]
pub(super) struct PlannedSetups {
    /// Setups that fit.
    pub(super) fitting: Vec<EvaluatedSetup>,
    /// Setups that do not fit.
    pub(super) others: Vec<EvaluatedSetup>,
}

impl PlannedSetups {
    /// Returns the largest least angle \[rad\].
    pub(super) fn least(&self) -> Option<f64> {
        self.fitting.iter().map(|one| one.least).reduce(f64::max)
    }

    pub(super) fn add(&mut self, one: EvaluatedSetup) {
        if one.verdict.fits().is_some() { self.fitting.push(one) } else { self.others.push(one) }
    }
}

impl SetupTask<'_> {
    /// Follows the path on given kinematics; only a cancelled run is an error.
    pub(super) fn followed(
        &self,
        on: &Kinematics,
    ) -> Result<(SetupVerdict, Option<FollowedPath>), AxesError> {
        match follow(on, self.path, self.options, &self.progress) {
            Ok(followed) => Ok((SetupVerdict::Fits(travelled(&followed)), Some(followed))),
            Err(AxesError::Cancelled(stop)) => Err(stop.into()),
            Err(error) => Ok((SetupVerdict::Fails(error), None)),
        }
    }

    /// Rounds a rotation as it would be written, and plans the axes with it.
    pub(super) fn evaluate(&self, workpiece: &WorkpieceTilt) -> Result<EvaluatedSetup, Cancelled> {
        let digit = self.search.rotation_digit;
        let angles: [f64; 3] = math::xyz_of_rotation(&workpiece.rotation()).into();
        // Rounded before it is judged, so that the setup that is written is the one that was planned.
        let angles = angles.map(|angle| rounded(angle.to_degrees(), digit).to_radians());
        let before = self.kinematics.setup();
        let mut setup = Setup::new(before.origin, angles, before.tool_length);
        let check = self.angles.check_angles(self.samples.finest(), &setup.rotation);
        let verdict = if check.missing_tilt > 0.0 {
            SetupVerdict::BeyondTilt(check.missing_tilt)
        } else {
            self.verdict(&mut setup)?
        };
        Ok(EvaluatedSetup {
            setup,
            angles,
            workpiece: WorkpieceTilt::of(&setup.rotation),
            least: check.least,
            verdict,
        })
    }

    /// Plans the axes of a setup, and moves its origin where linear travel is too short.
    fn verdict(&self, setup: &mut Setup) -> Result<SetupVerdict, Cancelled> {
        // The linear axes are affine in the origin: one plan without their ends decides for all origins.
        let free = Kinematics::new(&self.endless, setup);
        let followed = match follow(&free, self.path, self.options, &self.progress) {
            Ok(followed) => followed,
            Err(AxesError::Cancelled(stop)) => return Err(stop),
            Err(error) => return Ok(SetupVerdict::Fails(error)),
        };
        let real = Kinematics::new(self.kinematics.machine(), setup);
        Ok(match origins::place(&real, &followed) {
            Some(OriginFit::Fits(origin)) => {
                let digit = self.search.origin_digit;
                if origin != setup.origin {
                    setup.origin = origin.map(|value| rounded(value, digit));
                }
                SetupVerdict::Fits(travelled(&followed))
            }
            Some(OriginFit::Short { by, axes }) => SetupVerdict::Short { by, axes },
            None => SetupVerdict::Fits(travelled(&followed)),
        })
    }
}

/// Sums up the rotary travel of an axis path.
fn travelled(followed: &FollowedPath) -> PathTravel {
    // Along a quintic an axis may turn back; the sum over nodes is what the branches are compared by.
    let mut rotary = [0.0; 2];
    for pair in followed.path.pieces.iter().flat_map(|piece| piece.nodes.windows(2)) {
        let moved = pair[1].q[0] - pair[0].q[0];
        rotary[0] += moved[FIRST_ROTARY].abs();
        rotary[1] += moved[SECOND_ROTARY].abs();
    }
    let rotary = RotaryPair::from(rotary);
    let (weighted, retracts) = (followed.rotary_travel, followed.retracts.len());
    PathTravel { rotary, weighted, retracts }
}

/// Rounds to a multiple of `digit`.
fn rounded(value: f64, digit: f64) -> f64 {
    // + 0 turns -0 into 0.
    (value / digit).round() * digit + 0.0
}
