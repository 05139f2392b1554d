//! Drilling cycles.

use super::path::ClHole;
use super::reader::{ClReader, no_number, shortened};
use super::setting::INCH;
use super::state::{ClCycle, ClResult};
use super::statement::{ClWord, Statement};
use crate::types::ToolPose;
/// Role of a number in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CycleRole {
    Depth,
    Clear,
    Retract,
    Step,
    Further,
    Dwell,
    Feed,
    FeedInch,
    /// Per revolution of the spindle.
    Turn,
    TurnInch,
    /// Per revolution, in the unit of the file.
    Pitch,
    /// Threads an inch.
    Threads,
    /// One that is not needed.
    Other,
    /// Behind a number, without a word of its own.
    Bare,
}

/// Numbers of a cycle, in the unit of the file.
#[derive(Debug, Default)]
struct CycleNumbers {
    depth: Option<f64>,
    clear: Option<f64>,
    retract: Option<f64>,
    steps: [Option<f64>; 2],
    dwell: Option<f64>,
    feed: Option<(f64, CycleRole)>,
}

fn role(word: &str) -> Option<CycleRole> {
    Some(match word {
        "DEPTH" | "FEDTO" => CycleRole::Depth,
        "CLEAR" | "RAPTO" => CycleRole::Clear,
        "RTRCTO" | "RETURN" | "RETRCT" => CycleRole::Retract,
        "STEP" | "INCR" | "1STPECK" | "STEP1" => CycleRole::Step,
        "SUBPECK" | "STEP2" => CycleRole::Further,
        "DWELL" => CycleRole::Dwell,
        "MMPM" => CycleRole::Feed,
        "IPM" => CycleRole::FeedInch,
        "MMPR" => CycleRole::Turn,
        "IPR" => CycleRole::TurnInch,
        "PITCH" | "LEAD" => CycleRole::Pitch,
        "TPI" => CycleRole::Threads,
        _ => return None,
    })
}

/// Kinds that come out of the hole with rapid speed.
const RAPID_OUT: [&str; 9] =
    ["DRILL", "DEEP", "DEEP2", "BRKCHP", "CSINK", "CBORE", "FACE", "DEEPHL", "SPOT"];

/// All kinds, some of which have a number behind them.
const KINDS: [&str; 14] = [
    "DRILL", "DEEP", "BRKCHP", "CSINK", "CBORE", "FACE", "DEEPHL", "SPOT", "THRU", "TAP", "RIGID",
    "BORE", "REAM", "CDRILL",
];

/// Words of boring cycles after which the tool leaves the middle of the hole.
const ASIDES: [&str; 4] = ["NODRAG", "ORIENT", "MANUAL", "BACK"];

impl CycleNumbers {
    fn set(&mut self, role: CycleRole, value: f64) {
        match role {
            CycleRole::Depth => self.depth = Some(value.abs()),
            CycleRole::Clear => self.clear = Some(value),
            CycleRole::Retract => self.retract = Some(value),
            CycleRole::Step => self.steps[0] = Some(value.abs()),
            CycleRole::Further => self.steps[1] = Some(value.abs()),
            CycleRole::Dwell => self.dwell = Some(value),
            CycleRole::Feed
            | CycleRole::FeedInch
            | CycleRole::Turn
            | CycleRole::TurnInch
            | CycleRole::Pitch
            | CycleRole::Threads => self.feed = Some((value, role)),
            // The order of ISO 4343: depth, feed, clearance.
            CycleRole::Bare if self.depth.is_none() => self.depth = Some(value.abs()),
            CycleRole::Bare if self.clear.is_none() => self.clear = Some(value),
            CycleRole::Bare | CycleRole::Other => {}
        }
    }
}

impl ClReader {
    /// Begins a cycle, which makes holes of the locations that follow; `CYCLE/OFF` and `CYCLE/INIT`
    /// end it.
    pub(super) fn cycle(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let mut words = rest.items();
        let kind = words.next().unwrap_or(rest);
        let name = kind.text.to_ascii_uppercase();
        self.state.cycle = None;
        match name.as_str() {
            "OFF" | "NOMORE" | "INIT" | "START" => return Ok(()),
            "ON" | "" => {
                let message = "CYCLE without a kind".to_owned();
                return Err(Box::new(of.fault(
                    rest.at,
                    message,
                    "write CYCLE/DRILL,FEDTO,5,RAPTO,2",
                )));
            }
            _ => {}
        }
        if !KINDS.iter().any(|kind| name.trim_end_matches(|c: char| c.is_ascii_digit()) == *kind) {
            let message = format!("CYCLE/{} is not known", shortened(kind.text));
            let help = "DRILL, DEEP, BRKCHP, CSINK, CBORE, FACE, THRU, TAP, RIGID, BORE, REAM and SPOT are";
            return Err(Box::new(of.fault(kind.at, message, help)));
        }
        let asides = rest.items().find(|word| ASIDES.iter().any(|aside| word.is(aside)));
        if let Some(word) = asides {
            let message = format!("{} in a cycle: the tool steps aside", shortened(word.text));
            return Err(Box::new(of.fault(word.at, message, "post the cycle as moves")));
        }
        // Steps of the smaller retract are the control's own.
        if rest.items().any(|word| word.is("BRKCHP")) {
            let message = "chip breaks: the tool is taken out of the hole at each of them";
            self.warn(of, "BRKCHP", message.to_owned(), "");
        }
        let auto = rest.items().any(|word| word.is("AUTO"));
        let numbers = numbers(of, words)?;
        let Some(depth) = numbers.depth else {
            let message = format!("CYCLE/{}: no depth is known", shortened(kind.text));
            return Err(Box::new(of.fault(kind.at, message, "write it behind FEDTO or DEPTH")));
        };
        let scale = self.state.scale;
        // CLEAR and RTRCTO are heights above the location, DEPTH and FEDTO lengths below it.
        let clear = numbers.clear.unwrap_or(0.0).max(0.0);
        // One step given serves as first and further step.
        let steps = match numbers.steps {
            [Some(first), further] => Some([first, further.unwrap_or(first)]),
            [None, Some(further)] => Some([further, further]),
            [None, None] => None,
        };
        let steps = steps.filter(|steps| steps.iter().all(|step| *step > 0.0));
        let hole = ClHole {
            clear: clear * scale,
            depth: depth * scale,
            retract: numbers.retract.unwrap_or(clear).max(0.0) * scale,
            steps: steps.map(|steps| steps.map(|step| step * scale)),
            dwell: numbers.dwell.unwrap_or(0.0).max(0.0),
            feed_out: !RAPID_OUT.contains(&name.as_str()),
        };
        let given = numbers.feed.filter(|(feed, _)| *feed > 0.0);
        let feed = given.map(|(feed, unit)| self.cycle_feed(of, feed, unit)).transpose()?;
        self.state.cycle = Some(ClCycle { hole, feed, auto });
        Ok(())
    }

    /// Returns the feed of a cycle \[mm/s\].
    fn cycle_feed(&self, of: &Statement<'_>, feed: f64, unit: CycleRole) -> ClResult<f64> {
        let length = match unit {
            CycleRole::FeedInch | CycleRole::TurnInch => feed * INCH,
            CycleRole::Pitch => feed * self.state.scale,
            CycleRole::Threads => INCH / feed,
            _ => feed,
        };
        // mm/min to mm/s.
        if matches!(unit, CycleRole::Feed | CycleRole::FeedInch) {
            return Ok(length / 60.0);
        }
        let spindle = self.state.spindle.ok_or_else(|| {
            let message = "a cycle with a feed per revolution, and no SPINDL before it".to_owned();
            Box::new(of.fault(0, message, "write SPINDL/800,RPM before it"))
        })?;
        Ok(length * spindle)
    }

    /// Returns the hole of a location; RTRCTO,AUTO goes back up to where the tool came from.
    pub(super) fn hole(
        &self,
        of: &Statement<'_>,
        cycle: &ClCycle,
        pose: &ToolPose,
    ) -> ClResult<ClHole> {
        if !cycle.auto {
            return Ok(cycle.hole);
        }
        let Some(before) = self.state.place else {
            let message = "RTRCTO,AUTO, and no location before it".to_owned();
            return Err(Box::new(of.fault(0, message, "write GOTO before the cycle")));
        };
        let height = (before.tip - pose.tip).dot(&pose.axis);
        Ok(ClHole { retract: height.max(cycle.hole.clear), ..cycle.hole })
    }
}

fn numbers<'a>(
    of: &Statement<'_>,
    words: impl Iterator<Item = ClWord<'a>>,
) -> ClResult<CycleNumbers> {
    let mut numbers = CycleNumbers::default();
    let mut next = CycleRole::Bare;
    // CATIA writes the feed before its unit, between depth and clearance; others behind it.
    let mut second = false;
    for word in words {
        if let Some(value) = word.number() {
            // A bare number behind the depth may be a feed whose unit follows.
            second = next == CycleRole::Bare && numbers.depth.is_some() && numbers.clear.is_none();
            numbers.set(next, value);
            next = CycleRole::Bare;
            continue;
        }
        let name = word.text.to_ascii_uppercase();
        let begins_as_number =
            name.starts_with(|c: char| c == '.' || c == '-' || c.is_ascii_digit());
        next = match role(&name) {
            // The number before was a feed after all, not the clearance.
            Some(
                unit @ (CycleRole::Feed
                | CycleRole::FeedInch
                | CycleRole::Turn
                | CycleRole::TurnInch),
            ) if second => {
                numbers.feed = numbers.clear.take().map(|feed| (feed, unit));
                CycleRole::Bare
            }
            Some(role) => role,
            None if begins_as_number => return Err(no_number(of, word)),
            None => CycleRole::Other,
        };
        second = false;
    }
    Ok(numbers)
}
