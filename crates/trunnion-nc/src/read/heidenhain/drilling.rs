//! Drilling cycles, `CYCL DEF 200 .. Q200=+2`, and their calls, `M99` and `CYCL CALL`.

use super::drilling_cycle::{CycleFeed, KlartextCycle};
use super::reader::HeidenhainReader;
use super::units::feed_unit;
use super::units::value_begins;
use crate::read::control::{DistanceMode, FeedMode, INCH, MoveTarget};
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Step, Way};

/// Infeeds of one hole beyond which a value is taken for a slip.
const MOST_INFEEDS: f64 = 10_000.0;

/// Parameters that let the tool table or the machine decide: their values without effect, and remedies.
const NEUTRAL: [(&str, f64, &str); 5] = [
    ("Q395", 0.0, "give the depth of the tip, without it"),
    ("Q343", 0.0, "give the depth of the tip, without it"),
    ("Q379", 0.0, "give the whole depth, without it"),
    ("Q214", 0.0, "write Q214=+0: the control steps aside with a stopped spindle"),
    ("Q403", 1.0, "write Q403=1, or leave it out"),
];

/// A Q parameter of a cycle: its name, and its value or the word in place of one.
type CycleParameter = (String, Result<f64, String>);

/// Heights between which the strokes of a hole run, and the place of its call.
struct DrilledWay {
    slot: usize,
    at: usize,
    line: u32,
    clearance: f64,
    bottom: f64,
    end: f64,
}

impl HeidenhainReader {
    /// Takes a line of cycle 1: `1.1 SETUP 2`, `1.2 DEPTH -20`, `1.3 PECKG 5`, `1.4 DWELL 0`, `1.5 F200`.
    pub(super) fn pecking_line(
        &mut self,
        part: &str,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        // The name of a value differs with the language of the control; its number does not.
        let digits = value_begins(text);
        let (Some(digits), Some(cycle)) = (digits, self.drilling) else {
            return Err(ReadRemark::new(at, "a line of cycle 1 without its value", "write it"));
        };
        let written = text.get(digits..).unwrap_or_default().replace(char::is_whitespace, "");
        let value = self.arithmetic(&written, at)?;
        let changed = match part {
            "1" => KlartextCycle { setup: value.abs(), ..cycle },
            "2" => KlartextCycle { depth: -value, ..cycle },
            "3" => KlartextCycle { infeed: Some(value.abs()), ..cycle },
            "4" => KlartextCycle { dwell_bottom: value, ..cycle },
            "5" => KlartextCycle { feed: CycleFeed::PerMinute(value), ..cycle },
            _ => return Err(ReadRemark::new(at, "cycle 1 has lines 1.0 to 1.5", "look at it")),
        };
        self.drilling = Some(changed);
        Ok(())
    }

    /// Defines a cycle with Q parameters, all in one block.
    pub(super) fn define_drilling(
        &mut self,
        state: &ReaderState,
        number: u32,
        text: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        self.drilling = None;
        let given = self.parameters_of_cycle(text, at)?;
        let found = |key: &str| given.iter().rev().find(|(name, _)| name == key);
        let refused = |message: String, help: &str| Err(ReadRemark::new(at, message, help));
        for (name, value) in &given {
            if let Ok(value) = value {
                self.variables.insert(name.as_str().into(), *value);
            }
        }
        let value = |key: &str| match found(key) {
            Some((_, Ok(value))) => Ok(Some(*value)),
            Some((_, Err(word))) => {
                let message = format!("{key}={} in cycle {number}", excerpt(word));
                Err(ReadRemark::new(at, message, "write a number"))
            }
            None => Ok(None),
        };
        let needed = |key: &str| {
            let message = format!("cycle {number} without {key}");
            value(key)?.ok_or_else(|| ReadRemark::new(at, message, "write all of its parameters"))
        };
        let feed = |key: &str| match found(key) {
            Some((_, Err(word))) if matches!(word.as_str(), "MAX" | "FMAX") => Ok(CycleFeed::Rapid),
            // FAUTO is the feed of TOOL CALL.
            Some((_, Err(word))) if matches!(word.as_str(), "AUTO" | "FAUTO") => {
                let feed = self.tool_feed.map(|feed| CycleFeed::PerMinute(feed / feed_unit(state)));
                feed.ok_or_else(|| {
                    ReadRemark::new(at, "FAUTO without a feed", "write F in TOOL CALL")
                })
            }
            _ => needed(key).map(CycleFeed::PerMinute),
        };
        // These turn the hole into something that the tool table or the machine decides.
        for (key, neutral, help) in NEUTRAL {
            if value(key)?.is_some_and(|value| (value - neutral).abs() > 0.0) {
                return refused(format!("{key} in cycle {number}"), help);
            }
        }
        let taps = matches!(number, 207 | 209);
        let down = if taps { CycleFeed::Pitch(needed("Q239")?.abs()) } else { feed("Q206")? };
        // A retraction feed of zero is that of the plunge (cycles 201 and 203).
        let retract = match (number, found("Q208")) {
            (206 | 207 | 209, _) | (201 | 202, None) => down,
            (201..=203, Some(_)) => match feed("Q208")? {
                CycleFeed::PerMinute(value) if value <= 0.0 => down,
                given => given,
            },
            // Cycle 205 leaves with a feed of its own only on newer controls.
            (205, Some((_, Ok(_)))) => {
                let help = "write Q208=MAX, or leave it out";
                return refused("Q208 in cycle 205".to_owned(), help);
            }
            _ => CycleFeed::Rapid,
        };
        let depth = -needed("Q201")?;
        let infeed = match number {
            200 | 203 | 205 => value("Q202")?,
            209 => value("Q257")?,
            _ => None,
        };
        let above = match number {
            205 => {
                let (upper, lower) = (needed("Q258")?, value("Q259")?);
                // In between the control changes the distance from infeed to infeed.
                if lower.is_some_and(|lower| (lower - upper).abs() > 0.0) {
                    let help = "write Q259 like Q258";
                    return refused("two advanced stop distances in cycle 205".to_owned(), help);
                }
                if value("Q257")?.is_some_and(|chip| chip > 0.0 && chip < depth) {
                    let help = "write Q257=+0, or cycle 203";
                    return refused("chip breaks (Q257) in cycle 205".to_owned(), help);
                }
                Some(upper)
            }
            _ => None,
        };
        let decreases = value("Q212")?.is_some_and(|value| value.abs() > 0.0);
        if decreases && infeed.is_some_and(|infeed| infeed < depth) {
            let help = "write Q212=+0, or Q202 as deep as the hole";
            return refused(format!("a decreasing infeed (Q212) in cycle {number}"), help);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let breaks = value("Q213")?.unwrap_or(0.0) as u32;
        self.drilling = Some(KlartextCycle {
            number,
            setup: needed("Q200")?,
            depth,
            infeed,
            feed: down,
            retract,
            surface: Some(needed("Q203")?),
            second: value("Q204")?.unwrap_or(0.0),
            dwell_top: value("Q210")?.unwrap_or(0.0),
            dwell_bottom: value("Q211")?.unwrap_or(0.0),
            breaks,
            chip: match (number, down) {
                // A multiple of the pitch.
                (209, CycleFeed::Pitch(pitch)) => value("Q256")?.unwrap_or(0.0) * pitch,
                _ => value("Q256")?.unwrap_or(0.0),
            },
            above,
        });
        Ok(())
    }

    /// Returns names and values of `Q200=+5 Q208= MAX`; a word in place of a value as it stands.
    fn parameters_of_cycle(
        &self,
        text: &str,
        at: usize,
    ) -> Result<Vec<CycleParameter>, ReadRemark> {
        let upper = text.to_ascii_uppercase();
        let spaced: Vec<&str> = upper.split_whitespace().collect();
        // Blanks may stand on both sides of the sign.
        let joined = spaced.join(" ").replace(" =", "=").replace("= ", "=");
        let mut given = Vec::new();
        for word in joined.split(' ') {
            let Some((name, value)) = word.split_once('=') else { continue };
            if !super::token::is_q(name) {
                let message = format!("{} in a cycle", excerpt(word));
                return Err(ReadRemark::new(at, message, "write Q and its number"));
            }
            let is_word = value.starts_with(|c: char| c.is_ascii_alphabetic() && c != 'Q');
            let value =
                if is_word { Err(value.to_owned()) } else { Ok(self.arithmetic(value, at)?) };
            given.push((name.to_owned(), value));
        }
        Ok(given)
    }

    /// Runs the cycle defined last at the present position.
    pub(super) fn call_cycle(
        &mut self,
        state: &mut ReaderState,
        at: usize,
    ) -> Result<(), ReadRemark> {
        if self.feed_mode == FeedMode::PerRevolution {
            let help = "write M137 before it";
            return Err(ReadRemark::new(at, "a cycle with feeds per revolution (M136)", help));
        }
        let Some(cycle) = self.drilling else {
            let help = "define one of cycles 1, 200 to 203, 205 to 207, 209, 240 before";
            return Err(ReadRemark::new(at, "a call without a drilling cycle", help));
        };
        // A depth of zero: the control does not run the cycle.
        if cycle.depth.abs() <= 0.0 {
            return Ok(());
        }
        if cycle.depth < 0.0 {
            let help = "write the depth as a negative number";
            return Err(ReadRemark::new(at, "a cycle with a depth upwards", help));
        }
        // The tool axis is the one of X Y Z that does not span the plane of circles.
        let axis = 3 - self.plane[0] - self.plane[1];
        let slot = state.control.xyz.get(axis).copied().unwrap_or(2);
        let scale = state.control.scale();
        let surface = if let Some(surface) = cycle.surface {
            scale * surface
        } else {
            let stands = state.control.reading(slot).ok_or_else(|| {
                let message = "a cycle from a height that the program does not state";
                ReadRemark::new(at, message, "program the tool axis before it")
            })?;
            stands - scale * cycle.setup
        };
        let clearance = surface + scale * cycle.setup;
        let way = DrilledWay {
            slot,
            at,
            line: state.log.line,
            clearance,
            bottom: surface - scale * cycle.depth,
            // The second set-up clearance counts if it is the larger.
            end: clearance.max(surface + scale * cycle.second),
        };
        way.go(state, clearance, CycleFeed::Rapid)?;
        way.strokes(state, &cycle, surface)?;
        if !matches!(cycle.retract, CycleFeed::Rapid) {
            way.go(state, clearance, cycle.retract)?;
        }
        way.go(state, way.end, CycleFeed::Rapid)
    }
}

impl DrilledWay {
    /// Drills down to the bottom, infeed by infeed.
    fn strokes(
        &self,
        state: &mut ReaderState,
        cycle: &KlartextCycle,
        surface: f64,
    ) -> Result<(), ReadRemark> {
        let scale = state.control.scale();
        let whole = surface - self.bottom;
        let infeed = cycle.infeed.map_or(whole, |infeed| scale * infeed);
        // An infeed of nothing, or beyond the depth, is the whole depth.
        let infeed = if infeed > 0.0 { infeed.min(whole) } else { whole };
        if whole > MOST_INFEEDS * infeed {
            let message = format!("more than {MOST_INFEEDS} infeeds in a hole");
            return Err(ReadRemark::new(self.at, message, "look at Q202"));
        }
        let mut depth = surface;
        let mut broken = 0;
        loop {
            // Rounding must not leave a stroke of no length.
            let last = depth - infeed <= self.bottom + 1e-9;
            depth = if last { self.bottom } else { depth - infeed };
            self.go(state, depth, cycle.feed)?;
            // Cycle 200 dwells at the end of each infeed, the others at the bottom.
            if last || cycle.number == 200 {
                self.dwell(state, cycle.dwell_bottom);
            }
            if last {
                return Ok(());
            }
            // Q256 = 0: the tap leaves the hole.
            if cycle.number == 209 && cycle.chip > 0.0 {
                self.go(state, (depth + scale * cycle.chip).min(self.clearance), cycle.retract)?;
                continue;
            }
            if cycle.number == 203 && broken < cycle.breaks {
                broken += 1;
                self.go(state, (depth + scale * cycle.chip).min(self.clearance), cycle.retract)?;
                continue;
            }
            broken = 0;
            self.go(state, self.clearance, cycle.retract)?;
            self.dwell(state, cycle.dwell_top);
            let above = match cycle.number {
                // The thread goes on from the clearance at its own feed.
                209 => continue,
                205 => scale * cycle.above.unwrap_or(cycle.setup),
                1 => advance_stop(whole),
                203 if cycle.breaks > 0 => scale * cycle.chip,
                _ => scale * cycle.setup,
            };
            self.go(state, (depth + above).min(self.clearance), CycleFeed::Rapid)?;
        }
    }

    /// Moves the tool axis, if it is not there.
    fn go(&self, state: &mut ReaderState, to: f64, feed: CycleFeed) -> Result<(), ReadRemark> {
        // A move of no length would count as a block.
        let stands = state.control.reading(self.slot);
        if stands.is_some_and(|stands| (stands - to).abs() <= 0.0) {
            return Ok(());
        }
        let mut target = MoveTarget::new(self.at, 1);
        target.set(self.slot, to, DistanceMode::Absolute);
        let feed = match feed {
            CycleFeed::Rapid => None,
            CycleFeed::PerMinute(feed) => Some(feed * feed_unit(state)),
            CycleFeed::Pitch(pitch) => Some(pitch * state.control.speed),
        };
        let pace = match feed {
            None => Pace::Rapid,
            Some(feed) if feed > 0.0 => {
                let scale = if state.control.inch { INCH } else { 1.0 };
                Pace::PerMinute { speed: feed * scale / 60.0 }
            }
            Some(_) => {
                let help = "write Q206, or S and the pitch of a thread, above 0";
                return Err(ReadRemark::new(self.at, "a cycle without a feed", help));
            }
        };
        state.control.go(self.line, target, pace, Way::Line)
    }

    fn dwell(&self, state: &mut ReaderState, seconds: f64) {
        if seconds > 0.0 {
            state.control.steps.push_back(Step::Dwell { line: self.line, seconds });
        }
    }
}

/// Returns the height above the last depth at which cycle 1 begins to cut again \[mm\].
fn advance_stop(depth: f64) -> f64 {
    // 0.6 mm for holes of up to 30 mm, beyond a fiftieth of their depth up to 7 mm.
    if depth <= 30.0 { 0.6 } else { (depth / 50.0).min(7.0) }
}
