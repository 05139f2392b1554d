//! Values of HAL pins in a configuration of `LinuxCNC`: set directly, or by a signal.

use super::source_value::SourceValue;
use super::source_values::SourceValues;
use super::value_origin::ValueOrigin;
use std::collections::BTreeMap;

/// HAL commands of a configuration, and the values of its INI file that they use.
#[derive(Debug, Default)]
pub(super) struct HalPins {
    pins: BTreeMap<String, SourceValue>,
    signals: BTreeMap<String, SourceValue>,
    nets: BTreeMap<String, String>,
    /// Values of the INI file, as `[SECTION]KEY` without brackets and in one case.
    ini: BTreeMap<String, String>,
}

/// Length of a configuration as a pin states it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PinLength {
    /// Stated, or the value that an unconnected pin has.
    Known(f64),
    /// Its signal gets its value while the machine runs; in words.
    Driven(String),
}

impl HalPins {
    /// Reads a HAL file.
    pub(super) fn read(&mut self, name: &str, text: &str) {
        for (line, row) in (1_u64..).zip(text.lines()) {
            self.command(row, 0, &format!("{name}:{line}, "));
        }
    }

    /// Reads a command in a line of the INI file (0: of another file, which `source` names).
    pub(super) fn command(&mut self, row: &str, line: u64, source: &str) {
        let words: Vec<&str> =
            row.split('#').next().unwrap_or_default().split_whitespace().collect();
        match words.as_slice() {
            [command @ ("setp" | "sets"), name, value, ..] => {
                let key = format!("{source}{command} {name}");
                let found = SourceValue { key, value: (*value).to_owned(), line };
                let map = if *command == "setp" { &mut self.pins } else { &mut self.signals };
                map.insert((*name).to_owned(), found);
            }
            ["net", signal, pins @ ..] => {
                for pin in pins.iter().filter(|pin| pin.contains('.')) {
                    self.nets.insert((*pin).to_owned(), (*signal).to_owned());
                }
            }
            _ => {}
        }
    }

    /// Keeps a value of the INI file for the HAL commands that use it.
    pub(super) fn keep(&mut self, section: &str, key: &str, value: &str) {
        self.ini.entry(ini_key(section, key)).or_insert_with(|| value.trim().to_owned());
    }

    /// Returns the value of a pin in units of the configuration; one that nothing is connected to has the value `unset`.
    pub(super) fn length(
        &self,
        pin: &str,
        target: &str,
        unset: f64,
        values: &mut SourceValues,
    ) -> PinLength {
        let signal = self.nets.get(pin);
        let set = self.pins.get(pin).or_else(|| self.signals.get(signal?));
        let Some(found) = set else {
            if let Some(signal) = signal {
                return PinLength::Driven(format!("{pin} gets its value from the signal {signal}"));
            }
            let from =
                SourceValue { key: pin.to_owned(), value: format!("{unset} (not set)"), line: 0 };
            values.origins.push(ValueOrigin::new(&from, target));
            return PinLength::Known(unset);
        };
        let key = format!("{pin} ({})", found.key);
        values.add(&key, self.stated(&found.value), found.line);
        // A value that is no number was reported; the place holder is not used.
        PinLength::Known(values.number(&key, target).unwrap_or(0.0))
    }

    /// Returns a value, that of the INI file where it is named as `[SECTION]KEY` or `[SECTION](KEY)`.
    fn stated<'a>(&'a self, value: &'a str) -> &'a str {
        let named = value.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        let named = named.map(|(section, key)| ini_key(section, key.trim_matches(['(', ')'])));
        named.and_then(|key| self.ini.get(&key)).map_or(value, String::as_str)
    }
}

fn ini_key(section: &str, key: &str) -> String {
    format!("{}]{}", section.trim(), key.trim()).to_ascii_uppercase()
}
