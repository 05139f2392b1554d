//! M functions.

use super::path_block::{PathBlock, Retraction};
use super::reader::HeidenhainReader;
use super::token::Token;
use crate::read::control::FeedMode;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;

impl HeidenhainReader {
    /// Runs an M function.
    pub(super) fn m_code(
        &mut self,
        state: &mut ReaderState,
        block: &mut PathBlock,
        token: Token<'_>,
    ) -> Result<(), ReadRemark> {
        let digits = token.text.get(1..).unwrap_or_default().trim();
        let Ok(number) = digits.parse::<u32>() else {
            return Err(ReadRemark::new(token.at, "M without a number", ""));
        };
        match number {
            2 | 30 => block.ends = true,
            0 | 1 => block.stop = Some((token.at, token.at + token.text.len())),
            3 | 4 | 5 | 13 | 14 => spindle(state, token, number),
            // Coolant, messages, look-ahead, and ends of modes that are refused where they begin.
            6..=9 | 90 | 102 | 107 | 108 | 111 | 113 | 115 | 117 | 120 | 141 | 145 | 148 | 149 => {
                state.control.keep(state.log.line, token.text);
            }
            // M91: axis positions, in its block.
            91 => block.target.machine = true,
            99 => block.calls = true,
            140 => block.retract = Some(Retraction::Unstated),
            126..=129 | 136 | 137 => self.mode(state, block, number),
            89 | 92 | 94 | 97 | 98 | 101..=119 | 121..=125 | 130..=150 => {
                let message = format!("{} is not understood", excerpt(token.text));
                return Err(ReadRemark::new(token.at, message, remedy(number)));
            }
            _ => {
                let name = excerpt(token.text);
                let message = format!("{name} is not known: it is kept, and taken to move nothing");
                state.log.warn("", ReadRemark::new(token.at, message, ""));
                state.control.keep(state.log.line, token.text);
            }
        }
        Ok(())
    }

    /// Switches a mode of the motion: rotary paths, tool-centre-point control, feed per revolution.
    fn mode(&mut self, state: &mut ReaderState, block: &mut PathBlock, number: u32) {
        match number {
            // M126: rotaries take the shorter way; M127 ends it.
            126 | 127 => self.shortest = number == 126,
            // M128 is FUNCTION TCPM; an F beside it limits the compensation only.
            128 => {
                state.control.enable_tcp();
                block.tcpm = true;
            }
            129 => {
                state.control.disable_tcp();
                state.control.turning = None;
            }
            // M136: cutting feeds are per revolution of the spindle.
            _ => {
                self.feed_mode =
                    if number == 136 { FeedMode::PerRevolution } else { FeedMode::PerMinute };
                state.control.feed_mode = self.feed_mode;
                state.control.feed = None;
            }
        }
    }
}

/// Starts or stops the spindle.
fn spindle(state: &mut ReaderState, token: Token<'_>, number: u32) {
    let clockwise = i8::from(matches!(number, 3 | 13));
    state.control.sense = clockwise - i8::from(matches!(number, 4 | 14));
    state.control.spindle(state.log.line);
    // M13 and M14 switch the coolant on as well.
    if number > 5 {
        state.control.keep(state.log.line, token.text);
    }
}

/// Returns the remedy for an M function that is refused.
fn remedy(number: u32) -> &'static str {
    match number {
        // A machine parameter decides what M89 does.
        89 => "write M99 in each block that is to call the cycle",
        92 => "write axis positions with M91",
        94 => "write M126, or rotary words that count on",
        116 => "write the feed in degrees a minute, or move under TCPM",
        124 => "the control leaves out points of the path: post with all of them",
        _ => "it changes what words or feeds mean; post without it",
    }
}
