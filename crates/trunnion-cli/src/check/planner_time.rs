//! Time of a program on `LinuxCNC` with the planner of trunnion: the program is rounded and planned as that planner does it.

use super::subject::Subject;
use crate::figure::plain;
use trunnion::inverse::InverseError;
use trunnion::machine::{FIRST_ROTARY, Machine};
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

/// Largest distance of chords from arcs \[mm\]. Rounded within twice that, chords are the arc again.
const CHORD: f64 = 5e-4;
const ARC_TOLERANCE: f64 = 2.0 * CHORD;

/// Cosine of the largest turn between two chords of an arc: at a larger one the block has a corner.
const CHORD_TURN: f64 = 0.7;

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
    /// The planner refuses a block; its number is the line of the program.
    Plan(DurationFault),
}

impl From<VerifyError> for TimeFault {
    fn from(error: VerifyError) -> Self {
        Self::Replay(error)
    }
}

impl From<DurationFault> for TimeFault {
    fn from(fault: DurationFault) -> Self {
        Self::Plan(fault)
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
    /// Last block: what follows decides whether it is a chord of an arc that goes on.
    held: Option<MotionBlock>,
}

/// Plans the program of a subject. The error is a warning: everything else about the program is known without its time.
pub(super) fn planner_time(subject: &Subject) -> Result<PlannerTime, String> {
    let Some(machine) = subject.program_machine() else {
        let reason = "cutter locations have no blocks; post them first (trunnion post)";
        return Err(warning(&subject.program, None, reason));
    };
    let machine_fault = |reason: String| warning(&subject.program, None, &reason);
    let words = AxisWords::of(machine).map_err(|fault| machine_fault(fault.to_string()))?;
    let letters = words.0.each_ref().map(|word| word.letter);
    let feeder = Feeder::new(machine, letters);
    let mut feeder = feeder.map_err(|fault| machine_fault(fault.to_string()))?;
    let ran = subject.replay_blocks(CHORD, |block| feeder.take(block));
    ran.and_then(|()| feeder.finish()).map_err(|fault| fault.warning(&subject.program))
}

/// Words the reason why a program has no time.
fn warning(program: &str, line: Option<u32>, reason: &str) -> String {
    let line = line.map_or_else(String::new, |line| format!("{line}:"));
    format!("{program}:{line} no time for --control linuxcnc-trunnion: {reason}")
}

impl TimeFault {
    fn warning(&self, program: &str) -> String {
        match self {
            Self::Replay(error) => {
                let line = error.line();
                warning(program, line, &reason(&error.to_string(), "line", line))
            }
            Self::Plan(fault) => {
                let line = fault.block();
                let reason = reason(&fault.to_string(), "block", line);
                warning(program, line, &format!("{reason}; {}", remedy(fault)))
            }
        }
    }
}

/// Returns a message without the place that it begins with.
fn reason(message: &str, place: &str, number: Option<u32>) -> String {
    let place = number.map_or_else(String::new, |number| format!("{place} {number}: "));
    message.strip_prefix(&place).unwrap_or(message).to_owned()
}

/// Returns what helps against a refusal.
fn remedy(fault: &DurationFault) -> &'static str {
    match fault {
        DurationFault::Refused { refusal: InverseError::OutOfTravel(of), .. }
            if of.index >= FIRST_ROTARY =>
        {
            "the control stops before this block: turn the rotary another way, or the workpiece (--rotation)"
        }
        DurationFault::Refused { refusal: InverseError::OutOfTravel(_), .. } => {
            "the control stops before this block: place the workpiece so that all of it is inside travel (--origin)"
        }
        DurationFault::NoAxis { .. } => {
            "the control stops before this block: leave the letter out, or take a machine file with this axis"
        }
        _ => "the control stops before this block: divide it, or turn the tool another way",
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
            held: None,
        })
    }

    fn take(&mut self, block: &ReplayedBlock) -> Result<(), TimeFault> {
        match self.motion(block) {
            Some(motion) => {
                if let Some(mut before) = self.held.replace(motion) {
                    if is_chord(&before, &motion) {
                        (before.ending, before.tolerance) = (BlockEnding::Blend, ARC_TOLERANCE);
                    }
                    self.duration.push(&before)?;
                }
            }
            None if block.course == ReplayedCourse::Rest => self.rest()?,
            None => {}
        }
        Ok(())
    }

    /// Comes to rest behind the last block.
    fn rest(&mut self) -> Result<(), TimeFault> {
        if let Some(last) = self.held.take() {
            self.duration.push(&last)?;
        }
        Ok(self.duration.rest()?)
    }

    fn finish(&mut self) -> Result<PlannerTime, TimeFault> {
        self.rest()?;
        Ok(PlannerTime { seconds: self.duration.seconds(), stops: self.duration.stops() })
    }

    /// Returns a block as `LinuxCNC` hands it to its planner; `None` for one that does not move.
    fn motion(&self, block: &ReplayedBlock) -> Option<MotionBlock> {
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
        let [start, end] = block.ends.map(|words| self.position(&words, coordinates, tool_length));
        Some(MotionBlock {
            number: block.line,
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

/// Returns `true` if a block is a chord of an arc that goes on, where only the end of the arc is exact.
fn is_chord(block: &MotionBlock, next: &MotionBlock) -> bool {
    let step = |of: &MotionBlock| [0, 1, 2].map(|letter: usize| of.end[letter] - of.start[letter]);
    let [one, other] = [block, next].map(step);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    block.number == next.number
        && block.kind == next.kind
        && block.kind != BlockKind::Rapid
        && block.ending != BlockEnding::Blend
        && dot(one, other) > CHORD_TURN * (dot(one, one) * dot(other, other)).sqrt()
}

/// Returns how a block ends, and the tolerance of its corner \[mm\].
fn corner(smoothing: Option<Smoothing>) -> (BlockEnding, f64) {
    match smoothing {
        Some(Smoothing::Exact) => (BlockEnding::Exact, PATH_TOLERANCE),
        Some(Smoothing::Stop) => (BlockEnding::Stop, PATH_TOLERANCE),
        Some(Smoothing::Within(corners) | Smoothing::Blended { corners, .. }) if corners > 0.0 => {
            (BlockEnding::Blend, corners)
        }
        _ => (BlockEnding::Blend, PATH_TOLERANCE),
    }
}
