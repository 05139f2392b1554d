//! Time of a program on `LinuxCNC` with the planner of trunnion: the program is rounded and planned as that planner does it.

use super::subject::Subject;
use crate::figure::plain;
use crate::outcome::Failure;
use trunnion::inverse::InverseError;
use trunnion::machine::Machine;
use trunnion::math;
use trunnion::nc::read::{AxisWords, Smoothing};
use trunnion::program_motion::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, DurationFault, LETTERS,
    MotionBlock, ProgramDuration,
};
use trunnion::types::{AXES, AxisVector};
use trunnion::verify::{ReplayedBlock, ReplayedCourse, ReplayedSpeed, VerifyError};
use trunnion_report::Number;

/// Letters of a position, in their order.
const NAMES: &str = "XYZABCUVW";

/// Largest deviation of the rotaries at corners: that of the pin `trunniontp.axis-tolerance` \[rad\].
const AXIS_TOLERANCE: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Largest deviation of the tip for `G64` without P: that of the pin `trunniontp.path-tolerance` \[mm\].
const PATH_TOLERANCE: f64 = 0.1;

/// Largest distance of chords from arcs \[mm\]: far within what corners are rounded by.
const CHORD: f64 = 1e-4;

/// Length below which a block does not move \[mm or rad\].
const SHORTEST: f64 = 1e-7;

/// Time on the control, and the stops in it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub(super) struct PlannerTime {
    pub(super) seconds: f64,
    pub(super) stops: usize,
}

impl PlannerTime {
    /// Returns the time for the page.
    pub(super) fn number(&self) -> Number {
        let note = format!("with {} stops", self.stops);
        plain("LinuxCNC with trunniontp, time", format!("{:.1}", self.seconds), "s", note)
    }

    /// Returns the row of the table.
    pub(super) fn words(&self) -> String {
        let Self { seconds, stops } = self;
        format!(
            "linuxcnc-trunnion: {seconds:.1} s with {stops} stops, within every limit of the axes"
        )
    }
}

/// Reason why the time is not known.
#[derive(Debug)]
enum TimeFault {
    Replay(VerifyError),
    /// The planner refuses a block of this line.
    Plan(u32, DurationFault),
}

impl From<VerifyError> for TimeFault {
    fn from(error: VerifyError) -> Self {
        Self::Replay(error)
    }
}

/// Blocks of a program on their way into the planner.
struct Feeder {
    /// Index of the letter of each axis.
    letters: [usize; AXES],
    gauge: [f64; 3],
    /// Largest velocities of the letters with feed and at rapid speed, as the control limits them \[mm/s, rad/s\].
    velocity: AxisVector,
    duration: ProgramDuration,
    blocks: u32,
}

/// Plans the program of a subject; `None` for cutter locations, which have no blocks.
pub(super) fn planner_time(subject: &Subject) -> Result<Option<PlannerTime>, Failure> {
    let Some(machine) = subject.program_machine() else { return Ok(None) };
    let words = AxisWords::of(machine).map_err(Failure::input)?;
    let letters = words.0.each_ref().map(|word| word.letter);
    let mut feeder = Feeder::new(machine, letters).map_err(Failure::input)?;
    let ran = subject.replay_blocks(CHORD, |block| feeder.take(block));
    match ran.and_then(|()| feeder.finish()) {
        Ok(time) => Ok(Some(time)),
        Err(TimeFault::Replay(error)) => Err(subject.failure(&error)),
        Err(TimeFault::Plan(line, fault)) => Err(Failure::input(format!(
            "{}:{line}: the planner of --control linuxcnc-trunnion refuses the program: {fault}\n  help: check it without \
             --control for the reason, with line and axis",
            subject.program
        ))),
    }
}

impl Feeder {
    fn new(machine: &Machine, names: [char; AXES]) -> Result<Self, InverseError> {
        let gauge = machine.gauge.coords;
        Ok(Self {
            letters: names.map(|name| NAMES.find(name).unwrap_or(LETTERS)),
            gauge: [gauge.x, gauge.y, gauge.z],
            velocity: machine.vector(|axis| axis.vel),
            duration: ProgramDuration::new(machine, names, AXIS_TOLERANCE)?,
            blocks: 0,
        })
    }

    fn take(&mut self, block: &ReplayedBlock) -> Result<(), TimeFault> {
        let refused = |fault| TimeFault::Plan(block.line, fault);
        match self.motion(block) {
            Some(motion) => self.duration.push(&motion).map_err(refused),
            None if block.course == ReplayedCourse::Rest => self.duration.rest().map_err(refused),
            None => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<PlannerTime, TimeFault> {
        self.duration.rest().map_err(|fault| TimeFault::Plan(0, fault))?;
        Ok(PlannerTime { seconds: self.duration.seconds(), stops: self.duration.stops() })
    }

    /// Returns a block as `LinuxCNC` hands it to its planner; `None` for one that does not move.
    fn motion(&mut self, block: &ReplayedBlock) -> Option<MotionBlock> {
        let (coordinates, tool_length) = match block.course {
            ReplayedCourse::Axes => (BlockCoordinates::Axes, 0.0),
            ReplayedCourse::Tip { tool_length } => (BlockCoordinates::Tip, tool_length),
            ReplayedCourse::Rest => return None,
        };
        let change = block.ends[1] - block.ends[0];
        let norm = |of: [f64; 3]| math::hypot(math::hypot(of[0], of[1]), of[2]);
        let linear = norm([change[0], change[1], change[2]]);
        let leading = if linear > SHORTEST { linear } else { norm([change[3], change[4], 0.0]) };
        (leading > SHORTEST).then_some(())?;
        // The control lets no letter be faster than its axis.
        let least = change.abs().component_div(&self.velocity).amax();
        let (kind, seconds) = match block.speed {
            ReplayedSpeed::Rapid => (BlockKind::Rapid, least),
            ReplayedSpeed::Time => (BlockKind::Timed, block.seconds.max(least)),
            ReplayedSpeed::Feed => (BlockKind::Feed, block.seconds.max(least)),
        };
        let (ending, tolerance) = corner(block.smoothing);
        self.blocks = self.blocks.wrapping_add(1);
        let [start, end] = block.ends.map(|words| self.position(&words, coordinates, tool_length));
        Some(MotionBlock {
            number: self.blocks,
            start,
            end,
            shape: BlockShape::Line,
            kind,
            speed: leading / seconds,
            begins: BlockStart::Flow,
            ending,
            tolerance,
            coordinates,
            tool_length,
        })
    }

    /// Returns the position of all letters.
    fn position(
        &self,
        words: &AxisVector,
        coordinates: BlockCoordinates,
        tool_length: f64,
    ) -> [f64; LETTERS] {
        let mut position = [0.0; LETTERS];
        for (letter, word) in self.letters.iter().zip(words.iter()) {
            if let Some(at) = position.get_mut(*letter) {
                *at = *word;
            }
        }
        if coordinates == BlockCoordinates::Tip {
            // Words count from the gauge point, and the length along Z.
            for (at, gauge) in position.iter_mut().zip(self.gauge) {
                *at -= gauge;
            }
            position[2] += tool_length;
        }
        position
    }
}

/// Returns how a block ends, and the tolerance of its corner \[mm\].
fn corner(smoothing: Option<Smoothing>) -> (BlockEnding, f64) {
    match smoothing {
        Some(Smoothing::Exact) => (BlockEnding::Exact, PATH_TOLERANCE),
        Some(Smoothing::Within(corners) | Smoothing::Blended { corners, .. }) if corners > 0.0 => {
            (BlockEnding::Blend, corners)
        }
        _ => (BlockEnding::Blend, PATH_TOLERANCE),
    }
}
