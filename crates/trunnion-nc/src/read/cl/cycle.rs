//! Drilling cycles.

use super::path::ClHole;
use super::reader::{ClReader, no_number, shortened};
use super::setting::INCH;
use super::state::{ClCycle, ClResult};
use super::statement::{ClWord, Statement};
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
        _ => return None,
    })
}

/// Kinds that come out of the hole with rapid speed.
const RAPID_OUT: [&str; 8] =
    ["DRILL", "DEEP", "DEEP2", "BRKCHP", "CSINK", "CBORE", "FACE", "DEEPHL"];

impl CycleNumbers {
    fn set(&mut self, role: CycleRole, value: f64) {
        match role {
            CycleRole::Depth => self.depth = Some(value.abs()),
            CycleRole::Clear => self.clear = Some(value),
            CycleRole::Retract => self.retract = Some(value),
            CycleRole::Step => self.steps[0] = Some(value.abs()),
            CycleRole::Further => self.steps[1] = Some(value.abs()),
            CycleRole::Dwell => self.dwell = Some(value),
            CycleRole::Feed | CycleRole::FeedInch => self.feed = Some((value, role)),
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
        // mm/min or in/min to mm/s.
        let feed = numbers.feed.filter(|(feed, _)| *feed > 0.0).map(|(feed, unit)| {
            let scale = if unit == CycleRole::FeedInch { INCH } else { 1.0 };
            feed * scale / 60.0
        });
        self.state.cycle = Some(ClCycle { hole, feed });
        Ok(())
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
            Some(unit @ (CycleRole::Feed | CycleRole::FeedInch)) if second => {
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
