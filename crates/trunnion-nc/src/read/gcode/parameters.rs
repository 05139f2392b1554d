//! Parameters: `#1`, `#<name>`, `#<_global>`.

use crate::read::control::{ControlState, FeedMode};
use crate::read::log::ReadRemark;
use crate::read::options::ReadOptions;
use std::collections::HashMap;

/// Numbers of the parameters that belong to a subprogram call.
pub(super) const LOCALS: usize = 30;

/// Highest number of a parameter.
const HIGHEST: f64 = 1e6;

/// Parameters that stay in memory; a program that makes up more is not one for a machine.
const MOST: usize = 100_000;

/// Fanuc stops with an alarm where this one is set.
pub(super) const ALARM: ParameterKey = ParameterKey::Number(3000);

/// Number or name of a parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ParameterKey {
    Number(u32),
    /// Lower case, without blanks.
    Name(Box<str>),
}

/// Parameters of one subprogram call.
#[derive(Debug, Clone, Default)]
pub(super) struct ParameterScope {
    numbers: [f64; LOCALS],
    names: HashMap<Box<str>, f64>,
}

impl ParameterScope {
    /// Makes the arguments of a call `#1`, `#2` and so on.
    pub(super) fn of_call(arguments: &[f64]) -> Self {
        let mut scope = Self::default();
        for (number, argument) in scope.numbers.iter_mut().zip(arguments) {
            *number = *argument;
        }
        scope
    }
}

/// All parameters.
#[derive(Debug)]
pub(super) struct Parameters {
    numbers: HashMap<u32, f64>,
    /// Names that begin with `_`.
    globals: HashMap<Box<str>, f64>,
    scopes: Vec<ParameterScope>,
    given: HashMap<Box<str>, f64>,
}

impl Parameters {
    /// Starts with the values that the options give.
    pub(super) fn new(options: &ReadOptions) -> Self {
        let name = |name: &str| {
            // `#<_hal[x]>`, `<_hal[x]>` and `_hal[x]` all name one parameter.
            let inner = name.trim_start_matches('#').trim_matches(['<', '>']);
            normal(inner)
        };
        Self {
            numbers: HashMap::new(),
            globals: HashMap::new(),
            scopes: vec![ParameterScope::default()],
            given: options.parameters.iter().map(|(key, value)| (name(key), *value)).collect(),
        }
    }

    pub(super) fn enter(&mut self, scope: ParameterScope) {
        self.scopes.push(scope);
    }

    pub(super) fn leave(&mut self) {
        if self.scopes.len() > 1 {
            self.scopes.pop();
        }
    }

    pub(super) fn set(&mut self, key: ParameterKey, value: f64) {
        let Some(scope) = self.scopes.last_mut() else { return };
        match key {
            ParameterKey::Number(number) => {
                // #1 to #30 belong to the call, all others to the program.
                let local = usize::try_from(number).ok().and_then(|at| at.checked_sub(1));
                match local.and_then(|at| scope.numbers.get_mut(at)) {
                    Some(place) => *place = value,
                    None if self.numbers.len() < MOST => _ = self.numbers.insert(number, value),
                    None => {}
                }
            }
            ParameterKey::Name(name) => {
                // Names that begin with an underscore are global in LinuxCNC.
                let map = if name.starts_with('_') { &mut self.globals } else { &mut scope.names };
                if map.len() < MOST {
                    map.insert(name, value);
                }
            }
        }
    }

    /// Returns the value of a parameter, if it has one.
    pub(super) fn get(&self, key: &ParameterKey, control: &ControlState, line: u32) -> Option<f64> {
        match key {
            ParameterKey::Number(number) => self.number(*number, control),
            ParameterKey::Name(name) => self.name(name, control, line),
        }
    }

    fn number(&self, number: u32, control: &ControlState) -> Option<f64> {
        let local = usize::try_from(number).ok().and_then(|at| at.checked_sub(1));
        let local = local.and_then(|at| self.scopes.last()?.numbers.get(at).copied());
        local
            .or_else(|| self.numbers.get(&number).copied())
            // What the control provides goes before what is given for reading.
            .or_else(|| of_control(number, control))
            .or_else(|| self.given.get(number.to_string().as_str()).copied())
    }

    fn name(&self, name: &str, control: &ControlState, line: u32) -> Option<f64> {
        let scope = self.scopes.last()?;
        scope
            .names
            .get(name)
            .or_else(|| self.globals.get(name))
            .copied()
            .or_else(|| predefined(name, control, line))
            .or_else(|| self.given.get(name).copied())
    }
}

/// Returns a name without blanks, in lower case.
pub(super) fn normal(name: &str) -> Box<str> {
    let kept = name.chars().filter(|c| !c.is_whitespace());
    kept.map(|c| c.to_ascii_lowercase()).collect::<String>().into_boxed_str()
}

/// Returns the key of a parameter by its number.
pub(super) fn key_number(value: f64, at: usize) -> Result<ParameterKey, ReadRemark> {
    let whole = value.round();
    // Numbers are reckoned with, and 1e-4 is what the interpreter allows a whole number to be off.
    let fits = (value - whole).abs() < 1e-4 && (1.0..=HIGHEST).contains(&whole);
    if !fits {
        let message = format!("{value} is no number of a parameter");
        return Err(ReadRemark::new(at, message, "use whole numbers from 1"));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let number = whole as u32;
    Ok(ParameterKey::Number(number))
}

/// Returns a parameter that the control provides: current words (`#5420` and on), tool, offset.
fn of_control(number: u32, control: &ControlState) -> Option<f64> {
    match number {
        5400 => Some(f64::from(control.tool)),
        // LinuxCNC: #5420 to #5428 are the current X Y Z A B C U V W in the program's unit.
        5420..=5428 => {
            let at = usize::try_from(number - 5420).ok()?;
            position("xyzabcuvw".chars().nth(at)?, control)
        }
        // #5220 is the active work offset, counted from 1.
        5220 => Some(f64::from(control.offset) + 1.0),
        _ => None,
    }
}

fn position(letter: char, control: &ControlState) -> Option<f64> {
    let slot = control.known_slot(letter.to_ascii_uppercase())?;
    Some(control.written(slot, control.reading(slot)?))
}

/// Returns a named parameter that the control provides.
fn predefined(name: &str, control: &ControlState, line: u32) -> Option<f64> {
    let flag = |on: bool| Some(f64::from(u8::from(on)));
    let rest = name.strip_prefix('_')?;
    let mut letters = rest.chars();
    if let (Some(letter @ ('x' | 'y' | 'z' | 'a' | 'b' | 'c' | 'u' | 'v' | 'w')), None) =
        (letters.next(), letters.next())
    {
        return position(letter, control);
    }
    match rest {
        "metric" => flag(!control.inch),
        "imperial" => flag(control.inch),
        "feed" => control.feed,
        "rpm" => Some(control.speed),
        "current_tool" => control.tools.last().map(|&tool| f64::from(tool)),
        "selected_tool" => Some(f64::from(control.tool)),
        "line" => Some(f64::from(line)),
        "units_per_minute" => flag(control.feed_mode == FeedMode::PerMinute),
        "inverse_time" => flag(control.feed_mode == FeedMode::Inverse),
        "units_per_rev" => flag(control.feed_mode == FeedMode::PerRevolution),
        "spindle_on" => flag(control.sense != 0),
        "spindle_cw" => flag(control.sense > 0),
        _ => None,
    }
}
