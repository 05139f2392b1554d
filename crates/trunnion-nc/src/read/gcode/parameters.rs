//! Parameters: `#1`, `#<name>`, `#<_global>`.

use super::predefined::ModalView;
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::options::ReadOptions;
use std::cell::Cell;
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// Numbers of the parameters that belong to a subprogram call.
pub(super) const LOCALS: usize = 30;

/// Highest number of a parameter.
const HIGHEST: f64 = 1e6;

/// Parameters that stay in memory; a program that makes up more is not one for a machine.
const MOST: usize = 100_000;

/// Numbers that are the user's own, with the results of probing and inputs above them left out.
const USER_PARAMETERS: RangeInclusive<u32> = 31..=5000;

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
    /// Parameters that no one set read as zero: `LinuxCNC`.
    zeros: bool,
    /// One of them that was read since it was last asked for.
    unset: Cell<Option<u32>>,
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
            zeros: options.dialect == Dialect::LinuxCnc,
            unset: Cell::new(None),
            given: options.parameters.iter().map(|(key, value)| (name(key), *value)).collect(),
        }
    }

    /// Returns a parameter that was read as zero because neither program nor options set it.
    pub(super) fn take_unset(&self) -> Option<u32> {
        self.unset.take()
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
    pub(super) fn get(&self, key: &ParameterKey, view: &ModalView<'_>) -> Option<f64> {
        match key {
            ParameterKey::Number(number) => self.number(*number, view),
            ParameterKey::Name(name) => self.name(name, view),
        }
    }

    fn number(&self, number: u32, view: &ModalView<'_>) -> Option<f64> {
        let local = usize::try_from(number).ok().and_then(|at| at.checked_sub(1));
        let local = local.and_then(|at| self.scopes.last()?.numbers.get(at).copied());
        local
            .or_else(|| self.numbers.get(&number).copied())
            // What the control provides goes before what is given for reading.
            .or_else(|| view.number(number))
            .or_else(|| self.given.get(number.to_string().as_str()).copied())
            .or_else(|| self.zero(number))
    }

    /// Returns zero for a parameter of the user that nothing has set.
    fn zero(&self, number: u32) -> Option<f64> {
        // The interpreter starts with zeros, apart from what its parameter file keeps.
        if !self.zeros || !USER_PARAMETERS.contains(&number) {
            return None;
        }
        self.unset.set(Some(number));
        Some(0.0)
    }

    fn name(&self, name: &str, view: &ModalView<'_>) -> Option<f64> {
        let scope = self.scopes.last()?;
        scope
            .names
            .get(name)
            .or_else(|| self.globals.get(name))
            .copied()
            .or_else(|| view.name(name, self.scopes.len() - 1))
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
