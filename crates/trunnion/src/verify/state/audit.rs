//! Follows the state of the control through a program, apart from its motion.

use super::finding::{
    ActiveSmoothing, AffectedCuts, CoolantDemand, PlannedCuts, StateFinding, StateReport,
};
use crate::nc::read::{Coolant, Frame, LengthEntry, Move, Pace, Smoothing, Step};

/// Values against which the state is judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StateLimits<'a> {
    /// Tolerance of the part \[mm\]; `None` without a part.
    pub(crate) tolerance: Option<f64>,
    /// Effect of tool length compensation.
    pub(crate) length: LengthUse,
    pub(crate) coolant: CoolantDemand,
    /// Tools of the job; `None` without one.
    pub(crate) planned: Option<PlannedCuts<'a>>,
}

/// Effect of tool length compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LengthUse {
    /// A tool has a length: cuts without compensation are wrong.
    Compensated,
    /// No tool has a length: compensation changes nothing.
    Irrelevant,
}

/// Audits the state during all cuts of a program.
pub(crate) fn audit(steps: impl Iterator<Item = Step>, limits: &StateLimits<'_>) -> StateReport {
    let mut state = StateFollower::default();
    for step in steps {
        state.take(&step, limits);
    }
    state.finish(limits)
}

/// State so far, and the cuts that it affects.
#[derive(Default)]
struct StateFollower {
    /// Speed of the spindle, clockwise positive \[1/min\].
    spindle: f64,
    tool: Option<u32>,
    entry: Option<LengthEntry>,
    /// No cut has run since the entry was chosen: it may be meant for the tool that comes.
    entry_waits: bool,
    smoothing: Option<ActiveSmoothing>,
    loosest: Option<ActiveSmoothing>,
    stopped: Option<AffectedCuts>,
    reversed: Option<AffectedCuts>,
    no_length: Option<AffectedCuts>,
    wrong_length: Option<WrongLength>,
    coolant: Coolant,
    /// The next move is that of a probe.
    probes: bool,
    no_coolant: Option<AffectedCuts>,
    /// All cuts.
    cuts: Option<AffectedCuts>,
    /// Numbers of the tools that were called.
    called: Vec<u32>,
}

/// Cuts with a wrong length.
struct WrongLength {
    cuts: AffectedCuts,
    tool: u32,
    entry: LengthEntry,
}

impl StateFollower {
    fn take(&mut self, step: &Step, limits: &StateLimits<'_>) {
        match step {
            Step::Spindle { speed, .. } => self.spindle = *speed,
            Step::Tool { number, .. } => self.change(*number),
            Step::LengthEntry { entry, .. } => {
                (self.entry, self.entry_waits) = (Some(*entry), true);
            }
            Step::Smoothing { line, smoothing } => {
                self.smoothing = Some(ActiveSmoothing { line: *line, smoothing: *smoothing });
            }
            Step::Words { text, .. } => self.coolant = self.coolant.after(text),
            Step::Probe { .. } => self.probes = true,
            // A probe needs neither spindle nor coolant.
            Step::Move(_) if std::mem::take(&mut self.probes) => {}
            Step::Move(step) if step.pace != Pace::Rapid => self.cut(step, limits),
            _ => {}
        }
    }

    /// Another tool goes into the spindle, which stops for it.
    fn change(&mut self, number: u32) {
        if !self.called.contains(&number) {
            self.called.push(number);
        }
        if self.tool.replace(number) == Some(number) {
            return;
        }
        self.spindle = 0.0;
        // A row of the table stays chosen; edges begin with the first of the new tool, unless one stands beside its T or M6.
        if let (Some(LengthEntry::Edge(_)), false) = (self.entry, self.entry_waits) {
            self.entry = None;
        }
    }

    fn cut(&mut self, step: &Move, limits: &StateLimits<'_>) {
        let line = step.line;
        self.entry_waits = false;
        count(&mut self.cuts, line);
        if self.spindle < 0.0 {
            count(&mut self.reversed, line);
        } else if self.spindle <= 0.0 {
            count(&mut self.stopped, line);
        }
        if let Frame::Work { length, .. } = step.frame {
            if length {
                self.judge_entry(line);
            } else if limits.length == LengthUse::Compensated {
                count(&mut self.no_length, line);
            }
        }
        if limits.coolant == CoolantDemand::Needed && !self.coolant.is_on() {
            count(&mut self.no_coolant, line);
        }
        if let Some(active) = self.smoothing {
            let looser =
                self.loosest.is_none_or(|of| reach(of.smoothing) < reach(active.smoothing));
            self.loosest = if looser { Some(active) } else { self.loosest };
        }
    }

    /// Counts a cut whose length is that of another tool or edge.
    fn judge_entry(&mut self, line: u32) {
        let (Some(tool), Some(entry)) = (self.tool, self.entry) else { return };
        let is_own = match entry {
            LengthEntry::Row(row) => row == tool,
            LengthEntry::Edge(edge) => edge <= 1,
        };
        if is_own {
            return;
        }
        match &mut self.wrong_length {
            Some(wrong) => wrong.cuts.count += 1,
            none => {
                *none = Some(WrongLength { cuts: AffectedCuts { line, count: 1 }, tool, entry });
            }
        }
    }

    /// Returns the first tool of the job that the program does not call.
    fn missing_tool(&self, limits: &StateLimits<'_>) -> Option<StateFinding> {
        let (planned, cuts) = (limits.planned?, self.cuts?);
        // A single tool may have another number at the control.
        if planned.tools.len() < 2 && !self.called.is_empty() {
            return None;
        }
        let tool = planned.tools.iter().find(|tool| !self.called.contains(tool))?;
        Some(StateFinding::NoTool { cuts, tool: *tool })
    }

    fn finish(self, limits: &StateLimits<'_>) -> StateReport {
        let missing = self.missing_tool(limits);
        let wrong = |of: WrongLength| {
            let WrongLength { cuts, tool, entry } = of;
            StateFinding::WrongLength { cuts, tool, entry }
        };
        let loose = self.loosest.zip(limits.tolerance).and_then(|(active, tolerance)| match active
            .smoothing
        {
            Smoothing::Unbounded => {
                Some(StateFinding::UnboundedSmoothing { line: active.line, tolerance })
            }
            // A sum of two words has no more decimals than they have.
            stated => stated
                .bound()
                .map(|sum| (sum * 1e9).round() / 1e9)
                .filter(|sum| *sum > tolerance)
                .map(|smoothing| StateFinding::Smoothing {
                    line: active.line,
                    smoothing,
                    tolerance,
                }),
        });
        let findings = [
            self.stopped.map(StateFinding::SpindleStopped),
            self.reversed.map(StateFinding::SpindleReversed),
            self.no_length.map(StateFinding::NoLength),
            self.wrong_length.map(wrong),
            missing,
            self.no_coolant.map(StateFinding::NoCoolant),
            loose,
        ];
        let findings = findings.into_iter().flatten().collect();
        StateReport { smoothing: self.loosest, cuts: self.cuts, findings }
    }
}

/// Counts a cut.
fn count(cuts: &mut Option<AffectedCuts>, line: u32) {
    cuts.get_or_insert(AffectedCuts { line, count: 0 }).count += 1;
}

/// Orders smoothing by the distance that is stated; a machine's own setting counts least, since nothing is known of it.
fn reach(smoothing: Smoothing) -> f64 {
    match smoothing {
        Smoothing::OfMachine => -1.0,
        stated => stated.bound().unwrap_or(f64::INFINITY),
    }
}
