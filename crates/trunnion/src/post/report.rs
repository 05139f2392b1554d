//! Results of posting.

use super::conservation::MotionCount;
use crate::types::{Diagnostic, PoseDeviation};

/// One quantity of the input, and of the output.
///
/// # Example
///
/// ```
/// use trunnion::post::InputOutput;
///
/// let seconds = InputOutput { input: 12.0, output: 9.0 };
/// assert_eq!(seconds.output / seconds.input, 0.75);
/// assert_eq!(<[f64; 2]>::from(seconds), [12.0, 9.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InputOutput<T> {
    /// As it was read.
    pub input: T,
    /// As it was written.
    pub output: T,
}

impl<T> From<InputOutput<T>> for [T; 2] {
    fn from(of: InputOutput<T>) -> Self {
        [of.input, of.output]
    }
}

/// Largest load of any axis, over its limits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct AxisLoadRatios {
    /// Velocity over its limit.
    pub velocity: f64,
    /// Acceleration over its limit.
    pub acceleration: f64,
}

/// Result of posting an input.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct PostReport {
    /// Moves read, and blocks written.
    pub blocks: InputOutput<usize>,
    /// Motion as it was read, and as it was read back from what was written.
    pub motion: InputOutput<MotionCount>,
    /// Travel of the tip with feed \[mm\].
    pub length: f64,
    /// Time with feed as programmed, and with the limits of the axes kept \[s\].
    pub seconds: InputOutput<f64>,
    /// Time with feed that no block has, and so is not in the time above \[s\]: the last blocks of a cut whose words all
    /// round to those before.
    pub unwritten_seconds: f64,
    /// Time of rapid moves with the limits of the axes kept \[s\].
    pub rapid_seconds: f64,
    /// Time with feed on `LinuxCNC`, each cut from rest to rest \[s\].
    pub model_seconds: InputOutput<f64>,
    /// Time from the first to the last position on `LinuxCNC`, rapid moves included \[s\].
    pub linuxcnc_duration: InputOutput<f64>,
    /// Loads of the axes, of the input as programmed.
    pub loads: InputOutput<AxisLoadRatios>,
    /// Upper bound on the deviation from the input, before rounding.
    pub deviation: PoseDeviation,
    /// The same of rapid moves.
    pub rapid_deviation: PoseDeviation,
    /// Deviation of the tip that the program allows the control by asking for smoothing \[mm\].
    pub smoothing_bound: f64,
    /// Upper bound on the tip movement caused by rounding the words \[mm\].
    pub rounding: f64,
    /// Moves with feed that take longer than programmed, the first thousand in order.
    pub slowed: Vec<SlowedMove>,
    /// Number of all of them.
    pub slowed_moves: usize,
    /// The one that is slowed most.
    pub slowest: Option<SlowedMove>,
    /// Rapid move in which the control would run an axis beyond its velocity by most, if there is one.
    pub fastest_rapid: Option<FastRapid>,
    /// Cuts in which smoothing was chosen, if it was asked for.
    pub smoothing: Option<PostChoice>,
    /// Lines of the input before which the tool retracts so that the rotaries can unwind.
    pub unwound: Vec<u32>,
    /// First text that the reader does not understand, such as a word of a shop's own template.
    ///
    /// `None`: every block was read back from the text and found to mean what was intended.
    pub unread: Option<Diagnostic>,
}

/// Move that takes longer than programmed, because an axis could not follow it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowedMove {
    /// Line of the input.
    pub line: u32,
    /// Time as programmed and as written \[s\].
    pub seconds: InputOutput<f64>,
}

impl SlowedMove {
    /// Returns the time as written over that as programmed.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::post::{InputOutput, SlowedMove};
    ///
    /// let seconds = InputOutput { input: 0.5, output: 2.0 };
    /// assert_eq!(SlowedMove { line: 7, seconds }.ratio(), 4.0);
    /// ```
    pub fn ratio(&self) -> f64 {
        self.seconds.output / self.seconds.input
    }
}

/// Rapid move that a control plans without the limits of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FastRapid {
    /// Line of the input.
    pub line: u32,
    /// Largest axis velocity over its limit.
    pub ratio: f64,
}

/// Decisions on smoothing, and the timing they rest on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct PostChoice {
    /// Cuts left as they are, changed in part, and changed as a whole.
    pub cuts: [usize; 3],
    /// Time of the cuts unchanged and as chosen \[s\].
    pub seconds: InputOutput<f64>,
    /// True if the control model timed the cuts; false if the limits of the axes did.
    pub by_model: bool,
}
