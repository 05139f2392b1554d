//! Phrases that several reports share.

use crate::cover::FallbackReason;
use crate::positioning::PositioningError;

/// Returns a count with its noun: `1 place`, `2 places`.
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Returns the reason for a region at a fixed lead.
pub(super) fn reason(reason: &FallbackReason) -> String {
    match reason {
        FallbackReason::NoStrip(PositioningError::NoStrip { binding, .. }) => {
            format!("no wide strip fits, limited by {binding}")
        }
        FallbackReason::NoStrip(error) => error.in_one_line(),
        FallbackReason::Missed(lines) => {
            format!("the widest strips would leave {lines} columns across the pass unfinished")
        }
        FallbackReason::Effort => {
            "wide strips had taken the work that is allowed them, or were no wider than those of a ball"
                .to_owned()
        }
    }
}
