//! Blocks for the tool and its spindle: `TOOL CALL`, `TOOL DEF`, `STOP`.

use super::flow::same;
use super::reader::{HeidenhainReader, not_understood};
use super::token::{Token, Tokens};
use super::units::feed_unit;
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;

impl HeidenhainReader {
    /// Runs `BLK FORM`, `TOOL CALL`, `TOOL DEF`, `STOP`.
    pub(super) fn technology(
        &mut self,
        state: &mut ReaderState,
        first: &Token<'_>,
        code: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let text = code.get(first.at..).unwrap_or_default();
        let second = tokens.next_token();
        // The number of a tool may stand at its word: TOOL DEF1.
        let is = |word: &str| {
            second.is_some_and(|token| {
                let name = token.text.trim_end_matches(|c: char| c.is_ascii_digit());
                token.text.eq_ignore_ascii_case(word) || word == "DEF" && same(name, word)
            })
        };
        match first.text.to_ascii_uppercase().as_str() {
            "BLK" if is("FORM") => Ok(()),
            "TOOL" if is("CALL") => self.tool_call(state, text, tokens),
            "TOOL" if is("DEF") => Ok(()),
            "STOP" => {
                state.control.keep(state.log.line, first.text);
                // M functions may stand behind it.
                self.path(state, "L", first, Tokens::new(code, first.at + first.text.len()))
            }
            _ => Err(not_understood(first, code)),
        }
    }

    /// Runs `TOOL CALL 5 Z S8000 F500`.
    pub(super) fn tool_call(
        &mut self,
        state: &mut ReaderState,
        text: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let mut number = None;
        let mut speed = None;
        while let Some(token) = tokens.next_word() {
            let upper = token.text.to_ascii_uppercase();
            match upper.as_bytes() {
                [b'0'..=b'9', ..] => {
                    let help = "write the number of a tool in the tool table";
                    let wrong = || {
                        ReadRemark::new(token.at, format!("TOOL CALL {upper} is not known"), help)
                    };
                    number = Some(upper.parse().map_err(|_| wrong())?);
                }
                [b'"', ..] => number = Some(self.named_tool(&token, &upper)?),
                // The tool axis is the third axis of a right-handed plane: X to YZ, Y to ZX, Z to
                // XY.
                b"X" => self.plane = [1, 2],
                b"Y" => self.plane = [2, 0],
                b"Z" => self.plane = [0, 1],
                [b'S', ..] => speed = Some(self.value(&token.after(1))?.value),
                [b'F', ..] => {
                    let feed = self.value(&token.after(1))?.value * feed_unit(state);
                    (self.tool_feed, state.control.feed) = (Some(feed), Some(feed));
                }
                // An oversize changes length or radius of the tool against the programmed path.
                [b'D', b'L' | b'R', ..] => {
                    let skip = if upper.starts_with("DR2") { 3 } else { 2 };
                    if self.value(&token.after(skip))?.value.abs() > 0.0 {
                        let message = "a tool with oversize (DL, DR)";
                        return Err(ReadRemark::new(
                            token.at,
                            message,
                            "post the path of the real tool",
                        ));
                    }
                }
                _ => return Err(ReadRemark::new(token.at, format!("{upper} in TOOL CALL"), "")),
            }
        }
        let line = state.log.line;
        self.heading = None;
        if let Some(speed) = speed {
            state.control.speed = speed;
            if state.control.sense != 0 {
                state.control.spindle(line);
            }
        }
        if let Some(number) = number {
            state.control.keep(line, text);
            state.control.tool = number;
            // TOOL CALL changes the tool and compensates its length at once; tool 0 is none.
            state.control.change_tool(line, number);
            if number == 0 {
                state.control.disable_length();
            } else {
                state.control.enable_length();
            }
        }
        Ok(())
    }

    /// Returns the number of a tool that is called by its name.
    fn named_tool(&mut self, token: &Token<'_>, name: &str) -> Result<u32, ReadRemark> {
        let digits = name.chars().filter(char::is_ascii_digit).take(9);
        let number = digits.collect::<String>().parse().unwrap_or(0);
        let known = self.tool_names.entry(number).or_insert_with(|| name.into());
        if **known == *name {
            return Ok(number);
        }
        let message = format!("tools {known} and {name} would both be tool {number}");
        Err(ReadRemark::new(token.at, message, "call them by their numbers"))
    }
}
