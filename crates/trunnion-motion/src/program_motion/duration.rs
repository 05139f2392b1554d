//! Time of a program, by the runs that a control plans.

use super::block::{MotionBlock, NAMES};
use super::joints::{WordJoints, WordsFault};
use super::run::{ProgramRun, RunFault, planned_limits};
use crate::feed::{FeedError, Limits};
use crate::inverse::{Inverse, InverseError};
use crate::machine::{Kinematics, Machine, Setup};
use crate::types::AXES;

/// Reason why a program has no time: the control refuses it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DurationFault {
    /// The joints cannot follow a block.
    #[error("block {block}: {refusal}")]
    Refused {
        /// Number of the block.
        block: u32,
        /// Reason.
        refusal: InverseError,
    },
    /// A block moves a letter for which the machine has no axis.
    #[error("block {block}: the machine has no axis for the letter {letter}")]
    NoAxis {
        /// Number of the block.
        block: u32,
        /// The letter.
        letter: char,
    },
    /// The path cannot be planned at a block.
    #[error("block {block}: the motion cannot be planned within the limits of the machine")]
    Plan {
        /// Number of the block.
        block: u32,
    },
    /// The limits of the machine have no plan.
    #[error(transparent)]
    Limits(#[from] FeedError),
    /// The kinematics cannot be inverted with the tool of a block.
    #[error(transparent)]
    Kinematics(#[from] InverseError),
}

impl DurationFault {
    /// Returns the number of the block; `None` if the fault is that of the machine.
    pub fn block(&self) -> Option<u32> {
        match self {
            Self::Refused { block, .. } | Self::NoAxis { block, .. } | Self::Plan { block } => {
                Some(*block)
            }
            Self::Limits(_) | Self::Kinematics(_) => None,
        }
    }
}

/// Duration of a program whose blocks arrive one by one.
///
/// Rounds and plans them as a control does that never waits for a block. What a control needs to begin again after a stop is
/// the caller's to add: [`ProgramDuration::stops`].
///
/// # Example
///
/// ```
/// use trunnion_motion::machine::{AxisKind, AxisSpec, Machine, MachineSpec};
/// use trunnion_motion::program_motion::{
///     BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, ProgramDuration,
/// };
///
/// let linear = |name, dir| {
///     let axis = AxisSpec::linear(name, dir);
///     AxisSpec { limits: Some([-500.0, 500.0].into()), vel: 100.0, acc: 1000.0, jerk: 20_000.0, ..axis }
/// };
/// let rotary = |name, dir| {
///     let axis = AxisSpec::rotary(name, dir, [0.0; 3]);
///     AxisSpec { limits: Some([-3.0, 3.0].into()), vel: 2.0, acc: 10.0, jerk: 100.0, ..axis }
/// };
/// let axes = vec![
///     linear("X", [1.0, 0.0, 0.0]),
///     linear("Y", [0.0, 1.0, 0.0]),
///     linear("Z", [0.0, 0.0, 1.0]),
///     rotary("C", [0.0, 0.0, 1.0]),
///     rotary("A", [1.0, 0.0, 0.0]),
/// ];
/// let chain = ["w", "C", "A", "b", "X", "Y", "Z", "t"];
/// let machine = Machine::new(MachineSpec::new("table", &chain, axes))?;
/// let (start, mut end) = ([0.0; 9], [0.0; 9]);
/// end[0] = 100.0;
/// let block = MotionBlock {
///     number: 1,
///     start,
///     end,
///     shape: BlockShape::Line,
///     kind: BlockKind::Feed,
///     speed: 50.0,
///     begins: BlockStart::Flow,
///     ending: BlockEnding::Stop,
///     tolerance: 0.01,
///     coordinates: BlockCoordinates::Axes,
///     tool_length: 0.0,
/// };
/// let mut duration = ProgramDuration::new(&machine, ['X', 'Y', 'Z', 'C', 'A'], 0.002)?;
/// duration.push(&block)?;
/// duration.rest()?;
/// // 2 s at the feed, and the time to speed up and to slow down.
/// assert!(duration.seconds() > 2.0 && duration.seconds() < 2.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProgramDuration {
    joints: WordJoints,
    limits: Limits<AXES>,
    axis_tolerance: f64,
    run: Option<ProgramRun>,
    seconds: f64,
    stops: usize,
}

impl ProgramDuration {
    /// Starts at rest. `letters` are those of the axes, `axis_tolerance` is the largest deviation of the rotaries at corners
    /// \[rad\].
    ///
    /// # Errors
    ///
    /// [`InverseError::NotFinite`] if the machine cannot be inverted.
    pub fn new(
        machine: &Machine,
        letters: [char; AXES],
        axis_tolerance: f64,
    ) -> Result<Self, InverseError> {
        let bare = Inverse::new(&Kinematics::new(machine, &Setup::default()))?;
        let joints = WordJoints::new(bare, letters);
        let limits = planned_limits(machine);
        Ok(Self { joints, limits, axis_tolerance, run: None, seconds: 0.0, stops: 0 })
    }

    /// Takes the next block, and plans as much as makes room for it.
    ///
    /// # Errors
    ///
    /// [`DurationFault`].
    pub fn push(&mut self, block: &MotionBlock) -> Result<(), DurationFault> {
        loop {
            let mut run = match self.run.take() {
                Some(run) => run,
                None => self.begun(block)?,
            };
            while run.is_full() && self.advance(&mut run)? {}
            let taken = run.take(block).map_err(|fault| self.refused(block.number, fault))?;
            self.run = Some(run);
            if taken {
                return Ok(());
            }
            self.rest()?;
        }
    }

    /// Comes to rest behind the last block.
    ///
    /// # Errors
    ///
    /// [`DurationFault::Plan`].
    pub fn rest(&mut self) -> Result<(), DurationFault> {
        let Some(mut run) = self.run.take() else { return Ok(()) };
        run.end();
        while self.advance(&mut run)? {}
        if !run.is_finished() {
            return Err(DurationFault::Plan { block: run.block() });
        }
        self.stops += 1;
        Ok(())
    }

    /// Returns the time of what is planned \[s\].
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Returns the number of stops so far, the last one among them.
    pub fn stops(&self) -> usize {
        self.stops
    }

    /// Begins a run with the kinematics of a block.
    fn begun(&mut self, block: &MotionBlock) -> Result<ProgramRun, DurationFault> {
        self.joints.set(block.coordinates, block.tool_length)?;
        Ok(ProgramRun::new(self.joints.clone(), &self.limits, self.axis_tolerance)?)
    }

    fn refused(&self, block: u32, fault: WordsFault) -> DurationFault {
        match fault {
            WordsFault::Refused(refusal) => {
                DurationFault::Refused { block, refusal: self.joints.named(refusal) }
            }
            WordsFault::NoAxis { letter } => {
                let letter = NAMES.get(letter).copied().unwrap_or('?');
                DurationFault::NoAxis { block, letter }
            }
        }
    }

    /// Plans and runs a step; false where none is left without more blocks.
    fn advance(&mut self, run: &mut ProgramRun) -> Result<bool, DurationFault> {
        run.feed().map_err(|RunFault { block }| DurationFault::Plan { block })?;
        let Some(step) = run.stream().next() else { return Ok(false) };
        self.seconds += step.duration;
        run.forget(step.s.low);
        Ok(true)
    }
}
