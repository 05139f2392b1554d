//! Results of posting.

use crate::types::Diagnostic;

/// Result of posting an input.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PostReport {
    /// Number of moves read and of blocks written.
    pub blocks: [usize; 2],
    /// Travel of the tip with feed \[mm\].
    pub length: f64,
    /// Time with feed as programmed, and with the limits of the axes kept \[s\].
    pub seconds: [f64; 2],
    /// Time of rapid moves with the limits of the axes kept \[s\].
    pub rapid_seconds: f64,
    /// Time with feed on the control model, of input and output \[s\].
    pub model_seconds: [f64; 2],
    /// Largest axis velocity and acceleration of the input over their limits, as programmed.
    pub ratios_before: [f64; 2],
    /// Largest axis velocity and acceleration of the output over their limits.
    pub ratios_after: [f64; 2],
    /// Upper bound on the deviation of tip \[mm\] and tool axis \[rad\] from the input, before rounding.
    pub strayed: [f64; 2],
    /// Upper bound on the tip movement caused by rounding the words \[mm\].
    pub rounding: f64,
    /// Cuts in which smoothing was chosen, if it was asked for.
    pub smoothing: Option<PostChoice>,
    /// Lines of the input before which the tool retracts so that the rotaries can unwind.
    pub unwound: Vec<u32>,
    /// First text that the reader does not understand, such as a word of a shop's own template.
    ///
    /// `None`: every block was read back from the text and found to mean what was intended.
    pub unread: Option<Diagnostic>,
}

/// Decisions on smoothing, and the timing they rest on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PostChoice {
    /// Cuts left as they are, changed in part, and changed as a whole.
    pub cuts: [usize; 3],
    /// Time of the cuts unchanged and as chosen \[s\].
    pub seconds: [f64; 2],
    /// True if the control model timed the cuts; false if the limits of the axes did.
    pub by_model: bool,
}
