//! The inverse of a machine with a setup.

use super::refusal::PoseRefusal;
use super::rotary::{
    FrameDirection, ROUNDING, ReachMiss, Reachability, RotaryAngle, RotaryTriangle,
};
use super::slides::SlideSolver;
use crate::machine::{FIRST_ROTARY, Kinematics, OutOfTravel, RotaryPair, SECOND_ROTARY};
use crate::math;
use crate::math::angle::unwrap_near;
use crate::math::jet::{Jet, Real};
use crate::types::{AxisVector, Interval, PoseRates, ToolPose};
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// One of the two rotary solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Branch {
    /// g = +1: the tool-side rotary is turned backwards from where the triangle is flat.
    Plus,
    /// g = -1.
    Minus,
}

impl Branch {
    /// Both branches, `Plus` first.
    pub const BOTH: [Self; 2] = [Self::Plus, Self::Minus];

    /// Returns the sign g of the spherical triangle.
    fn sign(self) -> f64 {
        match self {
            Self::Plus => 1.0,
            Self::Minus => -1.0,
        }
    }

    /// Returns the other branch.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Plus => Self::Minus,
            Self::Minus => Self::Plus,
        }
    }
}

/// All axis positions for one pose, travel ignored; rotaries in `[-π, π]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InverseSolutions {
    /// Two solutions: branch `Plus`, then `Minus`. They are equal at the rim of reach.
    Regular([AxisVector; 2]),
    /// The tool is parallel to the workpiece-side rotary, which is free; it is at its home.
    Singular(AxisVector),
}

/// Reason why a pose has no axis position.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InverseError {
    /// The direction is outside the cone the two rotaries reach.
    #[error(
        "tool direction ({:.6}, {:.6}, {:.6}) misses what rotary axes {first} and {second} reach by {:.4} deg; nearest: ({:.6}, {:.6}, {:.6})",
        direction.x, direction.y, direction.z, miss.to_degrees(), nearest.x, nearest.y, nearest.z
    )]
    Unreachable {
        /// Wanted direction, workpiece frame.
        direction: UnitVector3<f64>,
        /// Nearest direction within reach.
        nearest: UnitVector3<f64>,
        /// Angle between them \[rad\].
        miss: f64,
        /// Name of the workpiece-side rotary.
        first: String,
        /// Name of the tool-side rotary.
        second: String,
    },
    /// Every solution is outside the travel of some axis; the error has the nearest.
    #[error(transparent)]
    OutOfTravel(#[from] OutOfTravel),
    /// Derivatives do not exist: the tool is parallel to the workpiece-side rotary.
    #[error("tool parallel to rotary axis {axis}: its motion is not determined by the pose")]
    Singular {
        /// Name of the free axis.
        axis: String,
    },
    /// Derivatives do not exist: the direction is on the rim of reach, where both branches meet.
    #[error(
        "tool direction on the rim of what rotary axes {first} and {second} reach: they would need infinite speed"
    )]
    Rim {
        /// Name of the workpiece-side rotary.
        first: String,
        /// Name of the tool-side rotary.
        second: String,
    },
    /// The linear axes lie in one plane with the rotaries where they are.
    #[error("the linear axes lie in one plane at {first} = {:.3} deg, {second} = {:.3} deg", at.first.to_degrees(), at.second.to_degrees())]
    FlatSlides {
        /// Name of the workpiece-side rotary.
        first: String,
        /// Name of the tool-side rotary.
        second: String,
        /// The rotary positions \[rad\].
        at: RotaryPair,
    },
    /// A number of setup, tool or pose is NaN or infinite, or the tool axis vanishes.
    #[error("{what} is not a finite number, or a direction without length")]
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
    },
}

/// Axis jets at one point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AxisJets {
    /// `q`, `q'`, `q''`, `q'''`.
    pub q: [AxisVector; 4],
    /// Number of the highest derivatives that are unknown (and zero): none away from a pole.
    pub lost: usize,
}

/// One branch, and the rotary move to it from a position before.
#[derive(Debug, Clone, Copy)]
pub(super) struct BranchMove {
    pub(super) turns: [RotaryAngle<f64>; 2],
    /// Sum of both rotary moves, and the longer of them \[rad\].
    pub(super) travel: f64,
    pub(super) longest: f64,
}

/// Inverse map from poses to axes, for a machine with a setup.
///
/// Everything that does not depend on the pose is computed once; a call allocates nothing unless it
/// fails.
///
/// # Example
///
/// ```
/// use trunnion_motion::inverse::Inverse;
/// use trunnion_motion::machine::{KinematicChain, Kinematics, Setup};
/// use trunnion_motion::types::{AxisVector, ToolPose};
///
/// let chain = KinematicChain::new()
///     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
///     .rotary("A", [1.0, 0.0, 0.0], [0.0; 3])
///     .bed()
///     .linear("X", [1.0, 0.0, 0.0])
///     .linear("Y", [0.0, 1.0, 0.0])
///     .linear("Z", [0.0, 0.0, 1.0]);
/// let inverse = Inverse::new(&Kinematics::from_chain(&chain, &Setup::default())?)?;
///
/// // The tool 30 degrees from z towards -y: A = 30 degrees.
/// let pose = ToolPose::new([10.0, 0.0, 0.0], [0.0, -0.5, 0.75_f64.sqrt()]).ok_or("no pose")?;
/// let q = inverse.near(&pose, &AxisVector::zeros())?;
/// assert!((q[4].to_degrees() - 30.0).abs() < 1e-9 && q[3].abs() < 1e-12);
/// assert!((inverse.kinematics().forward(&q).tip - pose.tip).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    kinematics: Kinematics,
    triangle: RotaryTriangle,
    slides: SlideSolver,
}

impl Inverse {
    /// Prepares the inverse.
    ///
    /// # Errors
    ///
    /// [`InverseError::NotFinite`] if origin, rotation or tool length is not finite.
    pub fn new(kinematics: &Kinematics) -> Result<Self, InverseError> {
        let triangle = RotaryTriangle::new(kinematics.chain());
        let slides = SlideSolver::new(kinematics.chain(), &triangle.frame)
            .ok_or(InverseError::NotFinite { what: "the setup or the tool length" })?;
        Ok(Self { kinematics: kinematics.clone(), triangle, slides })
    }

    /// Returns the forward map.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Returns the directions parallel to the workpiece-side rotary that the tool can take, workpiece frame.
    pub fn singular_directions(&self) -> Vec<UnitVector3<f64>> {
        let w1 = self.kinematics.chain().rotary[0].dir;
        let [low, high] = self.triangle.band();
        // +w1 is singular if phi = 0 is within reach, -w1 if phi = π is; both ends of the band are exact.
        let up = (low <= 0.0).then_some(w1);
        let down = (high >= PI).then_some(-w1);
        up.into_iter().chain(down).collect()
    }

    /// Returns the angles within reach between the tool and `dir` of the workpiece-side rotary \[rad\].
    pub fn reach(&self) -> Interval {
        let [low, high] = self.triangle.band();
        let [_, _, _, first, _] = &self.kinematics.machine().axes;
        // The triangle knows the direction with `sense` in it.
        if first.sense < 0.0 {
            Interval::new(PI - high, PI - low)
        } else {
            Interval::new(low, high)
        }
    }

    /// Returns the angle between a tool direction and the line of the workpiece-side rotary \[rad\], in
    /// `[0, π/2]`.
    pub fn pole_distance(&self, axis: &UnitVector3<f64>) -> f64 {
        // The angle to the nearer of both directions, by atan2: small angles keep their digits.
        let w1 = self.kinematics.chain().rotary[0].dir;
        math::atan2(w1.cross(axis).norm(), w1.dot(axis).abs())
    }

    /// Returns the component of a tool direction square to the workpiece-side rotary.
    ///
    /// The vector may have any length. The result is the position about the singular direction.
    #[inline]
    pub(crate) fn across(&self, axis: &Vector3<f64>) -> [f64; 2] {
        // Coordinates in the plane perpendicular to w1; only the direction of the tool counts.
        let [x, y, _] = self.triangle.frame;
        let scale = 1.0 / axis.norm();
        [x.dot(axis) * scale, y.dot(axis) * scale]
    }

    /// Returns all axis positions for a pose, travel ignored, rotaries in `[-π, π]`.
    ///
    /// # Errors
    ///
    /// [`InverseError::Unreachable`] with the nearest direction, `FlatSlides`, `NotFinite`.
    pub fn solutions(&self, pose: &ToolPose) -> Result<InverseSolutions, InverseError> {
        self.every(pose).map_err(|refusal| self.named(refusal))
    }

    /// Returns [`Inverse::solutions`] without names in its refusal.
    pub(super) fn every(&self, pose: &ToolPose) -> Result<InverseSolutions, PoseRefusal> {
        let (seen, place) = self.seen(pose)?;
        match place {
            Reachability::Regular => {
                let [plus, minus] = self.triangle.both(seen);
                Ok(InverseSolutions::Regular([self.slide(pose, &plus)?, self.slide(pose, &minus)?]))
            }
            Reachability::Pole => {
                let home = self.kinematics.machine().home()[FIRST_ROTARY];
                Ok(InverseSolutions::Singular(self.held(pose, &seen, home)?))
            }
        }
    }

    /// Returns the axis position on the branch and turn nearest to `near` in rotary travel, travel ends
    /// ignored. At a singular pose the free rotary stays where `near` has it.
    ///
    /// # Errors
    ///
    /// As [`Inverse::solutions`].
    #[inline]
    pub fn near(&self, pose: &ToolPose, near: &AxisVector) -> Result<AxisVector, InverseError> {
        self.nearest(pose, near).map_err(|refusal| self.named(refusal))
    }

    /// Returns [`Inverse::near`] without names in its refusal.
    #[inline]
    pub(super) fn nearest(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<AxisVector, PoseRefusal> {
        let (seen, place) = self.seen(pose)?;
        if place == Reachability::Pole {
            return self.held(pose, &seen, near[FIRST_ROTARY]).map(|q| unwound(q, near));
        }
        // Both branches, unwound to the turn next to `near`; of equal travels the branch plus is taken.
        let [plus, minus] = self.triangle.both(seen);
        let travel = |turns: &[RotaryAngle<f64>; 2]| rotary_moves(turns, near).iter().sum::<f64>();
        let nearest = if travel(&plus) <= travel(&minus) { plus } else { minus };
        self.slide(pose, &nearest).map(|q| unwound(q, near))
    }

    /// Returns both branches of a regular pose, `Plus` first; `None` at a singular one.
    #[inline]
    pub(super) fn regular(
        &self,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<Option<[BranchMove; 2]>, PoseRefusal> {
        let (seen, place) = self.seen(pose)?;
        if place == Reachability::Pole {
            return Ok(None);
        }
        Ok(Some(self.triangle.both(seen).map(|turns| {
            let [first, second] = rotary_moves(&turns, near);
            BranchMove { turns, travel: first + second, longest: first.max(second) }
        })))
    }

    /// Returns the axis position and its first three derivatives along a path, on a given branch; rotaries in
    /// `[-π, π]`. `rates.axis` need not be a unit vector. Exact: truncated Taylor arithmetic
    /// through the closed form.
    ///
    /// # Errors
    ///
    /// As [`Inverse::solutions`]; [`InverseError::Singular`] and [`InverseError::Rim`] where there
    /// are no derivatives.
    pub fn jets(&self, rates: &PoseRates, branch: Branch) -> Result<[AxisVector; 4], InverseError> {
        let axis = direction(rates)?;
        let seen = self.triangle.see(axis);
        // Reach is decided on the plain numbers: comparing jets makes no sense.
        let plain = self.triangle.see(axis.map(Real::value));
        let place = self.reachable(&plain, ROUNDING, || unit(axis));
        if place.map_err(|refusal| self.named(refusal))? == Reachability::Pole {
            return Err(self.singular());
        }
        let turns = self.triangle.turns(seen, branch.sign());
        self.off_rim(&turns)?;
        self.slide_jets(rates, &turns)
    }

    /// Returns [`Inverse::jets`], with paths close to the singular direction taken through it.
    ///
    /// A direction within `pole` \[rad\] of the singular one is taken to pass through it: the result has the limits from the side of growing parameter. `reach` \[parameter\] is the
    /// distance over which the path must leave that cone to count as passing.
    ///
    /// # Errors
    ///
    /// [`InverseError::Singular`] if it stays there.
    pub fn jets_through(
        &self,
        rates: &PoseRates,
        branch: Branch,
        pole: f64,
        reach: f64,
    ) -> Result<AxisJets, InverseError> {
        let [plus, minus] = self.both_jets_through(rates, pole, reach)?;
        Ok(if branch == Branch::Plus { plus } else { minus })
    }

    /// Returns both branches of [`Inverse::jets_through`], `Plus` first, for little more than the cost of one.
    ///
    /// # Errors
    ///
    /// As [`Inverse::jets_through`].
    pub fn both_jets_through(
        &self,
        rates: &PoseRates,
        pole: f64,
        reach: f64,
    ) -> Result<[AxisJets; 2], InverseError> {
        let axis = direction(rates)?;
        let seen = self.triangle.see(axis);
        let plain = self.triangle.see(axis.map(Real::value));
        let place = self.reachable(&plain, pole.max(ROUNDING), || unit(axis));
        if place.map_err(|refusal| self.named(refusal))? == Reachability::Regular {
            let [plus, minus] = self.triangle.both(seen);
            self.off_rim(&plus)?;
            self.off_rim(&minus)?;
            // Away from the pole nothing is lost: all derivatives are exact.
            let [plus, minus] = [self.slide_jets(rates, &plus)?, self.slide_jets(rates, &minus)?];
            return Ok([plus, minus].map(|q| AxisJets { q, lost: 0 }));
        }
        // A coefficient of h^k counts if over the distance `reach` it leads out of the cone `pole`.
        let least = [1, 2, 3].map(|order| pole.max(ROUNDING) / reach.powi(order));
        let through = |branch: Branch| -> Result<AxisJets, InverseError> {
            let found = self.triangle.through_pole(seen, branch.sign(), least);
            let (turns, lost) = found.ok_or_else(|| self.singular())?;
            Ok(AxisJets { q: self.slide_jets(rates, &turns)?, lost })
        };
        Ok([through(Branch::Plus)?, through(Branch::Minus)?])
    }

    /// Refuses the rim of reach, where the rotaries have no derivatives.
    fn off_rim(&self, turns: &[RotaryAngle<Jet>; 2]) -> Result<(), InverseError> {
        // There S vanishes and its root has infinite derivatives; they come out as infinite or NaN.
        if turns.iter().all(|turn| turn.angle.c.iter().all(|c| c.is_finite())) {
            return Ok(());
        }
        let [first, second] = self.rotary_names();
        Err(InverseError::Rim { first, second })
    }

    /// Returns position and derivatives of all axes while the rotaries move as prescribed and the tip as
    /// in `tip` (derivatives 0..=3 each).
    ///
    /// # Errors
    ///
    /// [`InverseError::FlatSlides`].
    pub fn with_rotaries(
        &self,
        tip: &[Vector3<f64>; 4],
        rotaries: [Jet; 2],
    ) -> Result<[AxisVector; 4], InverseError> {
        self.with_turns(tip, &rotaries.map(RotaryAngle::from_angle))
    }

    /// Returns the axes that bring the tip to a point while the rotaries stand.
    ///
    /// The values are those of [`Inverse::with_rotaries`], without derivatives.
    ///
    /// # Errors
    ///
    /// [`InverseError::FlatSlides`].
    pub fn at_rotaries(
        &self,
        tip: &Point3<f64>,
        rotaries: RotaryPair,
    ) -> Result<AxisVector, InverseError> {
        self.at_rotaries_or_refused(tip, rotaries).map_err(|refusal| self.named(refusal))
    }

    /// Returns the axes of [`Inverse::at_rotaries`]. Allocates nothing, also where it refuses the point.
    ///
    /// # Errors
    ///
    /// [`PoseRefusal::FlatSlides`].
    pub fn at_rotaries_or_refused(
        &self,
        tip: &Point3<f64>,
        rotaries: RotaryPair,
    ) -> Result<AxisVector, PoseRefusal> {
        let RotaryPair { first, second } = rotaries;
        let turns = [first, second].map(RotaryAngle::from_angle);
        let found = self.slides.solve([tip.x, tip.y, tip.z], &turns);
        let [x, y, z] = found.ok_or_else(|| flat(first, second))?;
        Ok(AxisVector::from([x, y, z, first, second]))
    }

    /// Returns the second rotary's angle at a pose within `pole` \[rad\] of the singular direction, where
    /// the first is free; `None` elsewhere.
    pub fn second_at_pole(&self, axis: &UnitVector3<f64>, pole: f64) -> Option<f64> {
        let seen = self.triangle.see([axis.x, axis.y, axis.z]);
        // The sign of cos phi distinguishes the two poles.
        let at_pole = self.triangle.place(&seen, pole).ok()? == Reachability::Pole;
        let u = self.kinematics.chain().rotary[0].dir.dot(axis);
        at_pole.then(|| self.triangle.second_at_pole(u).angle)
    }

    /// Returns the tool direction in the frame of the first rotary, and its reachability.
    fn seen(&self, pose: &ToolPose) -> Result<(FrameDirection<f64>, Reachability), PoseRefusal> {
        let axis = pose.axis;
        let seen = self.triangle.see([axis.x, axis.y, axis.z]);
        let place = self.reachable(&seen, ROUNDING, || axis)?;
        Ok((seen, place))
    }

    /// Classifies a direction, and converts a miss to a refusal; `direction` is called for the refusal alone.
    #[inline]
    fn reachable(
        &self,
        seen: &FrameDirection<f64>,
        pole: f64,
        direction: impl FnOnce() -> UnitVector3<f64>,
    ) -> Result<Reachability, PoseRefusal> {
        self.triangle.place(seen, pole).map_err(|ReachMiss { angle: miss, nearest }| {
            // A NaN in the direction fails every comparison and ends up here.
            if miss.is_nan() {
                return PoseRefusal::NotFinite { what: "the tool axis" };
            }
            PoseRefusal::Unreachable { direction: direction(), nearest, miss }
        })
    }

    #[inline]
    pub(super) fn slide(
        &self,
        pose: &ToolPose,
        turns: &[RotaryAngle<f64>; 2],
    ) -> Result<AxisVector, PoseRefusal> {
        let tip = [pose.tip.x, pose.tip.y, pose.tip.z];
        match self.slides.solve(tip, turns) {
            // One test for three numbers: a sum with an infinity or a NaN is not finite.
            Some([x, y, z]) if (x + y + z).is_finite() => {
                Ok(AxisVector::from([x, y, z, turns[0].angle, turns[1].angle]))
            }
            Some(_) => Err(PoseRefusal::NotFinite { what: "the tip" }),
            None => Err(flat(turns[0].angle, turns[1].angle)),
        }
    }

    /// Solves at a pole, with the first rotary held.
    fn held(
        &self,
        pose: &ToolPose,
        seen: &FrameDirection<f64>,
        first: f64,
    ) -> Result<AxisVector, PoseRefusal> {
        self.slide(
            pose,
            &[RotaryAngle::from_angle(first), self.triangle.second_at_pole(seen.cos())],
        )
    }

    fn slide_jets(
        &self,
        rates: &PoseRates,
        turns: &[RotaryAngle<Jet>; 2],
    ) -> Result<[AxisVector; 4], InverseError> {
        self.with_turns(&rates.tip, turns)
    }

    fn with_turns(
        &self,
        tip: &[Vector3<f64>; 4],
        turns: &[RotaryAngle<Jet>; 2],
    ) -> Result<[AxisVector; 4], InverseError> {
        let [x, y, z] = self
            .slides
            .solve(jets_of(tip), turns)
            .ok_or_else(|| self.named(flat(turns[0].angle.value(), turns[1].angle.value())))?;
        // From one jet an axis to one axis vector a derivative.
        let all = [x, y, z, turns[0].angle, turns[1].angle].map(Jet::derivatives);
        Ok([0, 1, 2, 3].map(|order| AxisVector::from(all.map(|jet| jet[order]))))
    }

    /// Returns a refusal as an error that names the axes.
    pub fn named(&self, refusal: PoseRefusal) -> InverseError {
        let names = || self.rotary_names();
        match refusal {
            PoseRefusal::Unreachable { direction, nearest, miss } => {
                let [first, second] = names();
                InverseError::Unreachable { direction, nearest, miss, first, second }
            }
            PoseRefusal::OutOfTravel(excess) => excess.named(self.kinematics().machine()).into(),
            PoseRefusal::FlatSlides { at } => {
                let [first, second] = names();
                InverseError::FlatSlides { first, second, at }
            }
            PoseRefusal::NotFinite { what } => InverseError::NotFinite { what },
        }
    }

    fn rotary_names(&self) -> [String; 2] {
        let [_, _, _, first, second] = &self.kinematics.machine().axes;
        [first.name.clone(), second.name.clone()]
    }

    fn singular(&self) -> InverseError {
        let [axis, _] = self.rotary_names();
        InverseError::Singular { axis }
    }
}

/// Returns the refusal of linear axes that lie in one plane with the rotaries at these angles \[rad\].
fn flat(first: f64, second: f64) -> PoseRefusal {
    PoseRefusal::FlatSlides { at: RotaryPair::new(first, second) }
}

/// Converts three components with derivatives 0..=3 to jets.
fn jets_of(d: &[Vector3<f64>; 4]) -> [Jet; 3] {
    [0, 1, 2].map(|row| Jet::from_derivatives([d[0][row], d[1][row], d[2][row], d[3][row]]))
}

/// Returns the unit tool direction of a path as jets.
fn direction(rates: &PoseRates) -> Result<[Jet; 3], InverseError> {
    // Normalised in jet arithmetic, so that derivatives of the length drop out.
    let [x, y, z] = jets_of(&rates.axis);
    let length = (x * x + y * y + z * z).sqrt();
    if length.value() > 0.0 && length.value().is_finite() {
        let inverse = Jet::constant(1.0) / length;
        Ok([x * inverse, y * inverse, z * inverse])
    } else {
        Err(InverseError::NotFinite { what: "the tool axis" })
    }
}

fn unit(axis: [Jet; 3]) -> UnitVector3<f64> {
    UnitVector3::new_normalize(Vector3::from(axis.map(Real::value)))
}

/// Returns the move of each rotary from `near` by the shorter way \[rad\].
#[inline]
fn rotary_moves(turns: &[RotaryAngle<f64>; 2], near: &AxisVector) -> [f64; 2] {
    let to = |turn: &RotaryAngle<f64>, from: f64| (unwrap_near(turn.angle, from) - from).abs();
    [to(&turns[0], near[FIRST_ROTARY]), to(&turns[1], near[SECOND_ROTARY])]
}

/// Moves rotaries by whole turns to within half a turn of `near`.
#[inline]
pub(super) fn unwound(mut q: AxisVector, near: &AxisVector) -> AxisVector {
    for axis in [FIRST_ROTARY, SECOND_ROTARY] {
        q[axis] = unwrap_near(q[axis], near[axis]);
    }
    q
}
