//! Tables as comma-separated text with a header line: columns by name, numbers that round-trip.
//!
//! A line at a time, so that a shell can stream files of any length. Empty lines and lines that
//! start with `#` are skipped by [`is_row`].

use super::walk::nearest;
use crate::types::{Diagnostic, Diagnostics};
use std::fmt::Write;

const SEPARATORS: &str = "separate names and numbers by commas, with a decimal point";

/// Column names of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableHeader {
    line: u64,
    names: Vec<String>,
}

/// Selected columns of a table, in an order of the caller's choice.
///
/// # Example
///
/// ```
/// use trunnion::files::table::TableHeader;
///
/// let columns = TableHeader::parse(1, "t,X,C")?.columns(&["C", "t"]).map_err(|all| all[0].clone())?;
/// let mut values = Vec::new();
/// columns.read(2, "0.001,-381,90", &mut values)?;
/// assert_eq!(values, [90.0, 0.001]);
/// # Ok::<(), trunnion::types::Diagnostic>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableColumns {
    /// Index of each in a row, and its name.
    wanted: Vec<(usize, String)>,
    width: usize,
}

/// Returns true if a line holds a header or a row, false if it is empty or a comment.
pub fn is_row(line: &str) -> bool {
    let line = line.trim_start_matches('\u{feff}').trim();
    !line.is_empty() && !line.starts_with('#')
}

impl TableHeader {
    /// Reads the header line; `line` is its number, counted from 1.
    ///
    /// # Errors
    ///
    /// A line of numbers, or one with other separators.
    pub fn parse(line: u64, text: &str) -> Result<Self, Diagnostic> {
        let text = text.trim_start_matches('\u{feff}');
        let names: Vec<String> = fields(text).map(|(_, field)| field.to_owned()).collect();
        // Without names, columns would be guessed by position: a frequent and silent mistake.
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
            return Err(fault(line, 1, "the first line must name the columns, but holds numbers"));
        }
        // A single field with another separator in it is a table of another locale.
        if let [only] = names.as_slice()
            && only.contains([';', '\t', ' '])
        {
            return Err(
                fault(line, 1, format!("the header {only:?} has no commas")).with_help(SEPARATORS)
            );
        }
        Ok(Self { line, names })
    }

    /// Returns the names in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Finds columns by name; others are left alone.
    ///
    /// # Errors
    ///
    /// Returns a diagnostic for every column that is missing or present twice.
    pub fn columns(&self, wanted: &[&str]) -> Result<TableColumns, Diagnostics> {
        let mut faults = Vec::new();
        let mut found = Vec::new();
        for name in wanted {
            let mut places = self.names.iter().enumerate().filter(|(_, here)| here == name);
            match (places.next(), places.next()) {
                (Some((place, _)), None) => found.push((place, (*name).to_owned())),
                (Some(_), Some(_)) => {
                    faults.push(fault(self.line, 1, format!("column {name} occurs twice")));
                }
                (None, _) => faults.push(self.missing(name, wanted)),
            }
        }
        if faults.is_empty() {
            Ok(TableColumns { wanted: found, width: self.names.len() })
        } else {
            Err(faults.into())
        }
    }

    fn missing(&self, name: &str, wanted: &[&str]) -> Diagnostic {
        // A name that is wanted itself is no misspelling of another.
        let others: Vec<&str> = self
            .names
            .iter()
            .map(String::as_str)
            .filter(|here| !wanted.contains(here) && !here.is_empty())
            .collect();
        let same = others.iter().find(|here| here.eq_ignore_ascii_case(name)).copied();
        // Names of one or two letters are all near each other: `nearest` would guess.
        let help = match same.or_else(|| nearest(name, &others).filter(|_| name.len() > 2)) {
            Some(near) => {
                format!("rename `{near}` if it is this column; needed: {}", wanted.join(","))
            }
            None => format!("needed: {}", wanted.join(",")),
        };
        fault(self.line, 1, format!("column {name} is missing")).with_help(help)
    }
}

impl TableColumns {
    /// Reads the wanted numbers of row `line` into `values`, which it empties first.
    ///
    /// # Errors
    ///
    /// A number of fields other than the header's, or a field that is no finite number.
    pub fn read(&self, line: u64, text: &str, values: &mut Vec<f64>) -> Result<(), Diagnostic> {
        values.clear();
        let mut rest = fields(text);
        let mut field = rest.next();
        let mut count = 0;
        // Wanted columns mostly stand in order: one pass over the row, else one for each.
        for (place, name) in &self.wanted {
            // A column to the left of the last one: start over at the beginning of the row.
            if *place < count {
                (rest, count) = (fields(text), 0);
                field = rest.next();
            }
            while count < *place && field.is_some() {
                field = rest.next();
                count += 1;
            }
            let Some((start, word)) = field else { return Err(self.width_fault(line, text)) };
            values.push(number(line, text, start, &NamedWord { name, word })?);
        }
        // The remaining fields are counted, not read: a row of another width is shifted.
        while field.is_some() {
            field = rest.next();
            count += 1;
        }
        if count == self.width { Ok(()) } else { Err(self.width_fault(line, text)) }
    }

    /// Raises each entry of `most` to the number of decimals of the corresponding field.
    pub fn decimals(&self, text: &str, most: &mut [usize]) {
        let fields: Vec<&str> = fields(text).map(|(_, word)| word).collect();
        for ((place, _), most) in self.wanted.iter().zip(most) {
            *most = (*most).max(fields.get(*place).map_or(0, |word| decimals(word)));
        }
    }

    /// Returns true if all selected fields of a row are empty: a row without a result.
    pub fn are_empty(&self, text: &str) -> bool {
        fields(text).count() == self.width
            && self
                .wanted
                .iter()
                .all(|(place, _)| fields(text).nth(*place).is_some_and(|(_, word)| word.is_empty()))
    }

    fn width_fault(&self, line: u64, text: &str) -> Diagnostic {
        let count = fields(text).count();
        let fault = fault(
            line,
            text.trim_end().chars().count() + 1,
            format!("the row has {count} fields, but the header names {}", self.width),
        );
        if text.contains(';') || count > self.width { fault.with_help(SEPARATORS) } else { fault }
    }
}

/// Field of a row with the name of its column.
struct NamedWord<'a> {
    name: &'a str,
    word: &'a str,
}

/// One number of a row.
fn number(line: u64, text: &str, start: usize, field: &NamedWord<'_>) -> Result<f64, Diagnostic> {
    let NamedWord { name, word } = *field;
    let column = || text.get(..start).map_or(0, |before| before.chars().count()) + 1;
    let wrong = |what: String| Err(fault(line, column(), what));
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => wrong(format!("{name} = {word} is not a finite number")),
        Err(_) if word.is_empty() => wrong(format!("{name} is empty")),
        // A semicolon in a field means that commas are decimal points here.
        Err(_) if word.contains(';') => wrong(format!("{name} = {word:?} is not a number"))
            .map_err(|fault: Diagnostic| fault.with_help(SEPARATORS)),
        Err(_) => wrong(format!("{name} = {word:?} is not a number")),
    }
}

/// Returns the decimals of a number as written: `-1.250` has 3, `2.5e-4` has 5.
fn decimals(word: &str) -> usize {
    let (digits, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
    let behind = digits.split_once('.').map_or(0, |(_, behind)| behind.len());
    // An exponent of -4 moves the last digit four places to the right.
    let exponent: i64 = exponent.parse().unwrap_or(0);
    let behind = i64::try_from(behind).unwrap_or(i64::MAX).saturating_sub(exponent);
    usize::try_from(behind).unwrap_or(0)
}

/// Splits a row into fields: byte offset and text, without blanks and quotes around it.
fn fields(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    text.trim_end_matches(['\r', '\n']).split(',').map(move |field| {
        let start = at + (field.len() - field.trim_start().len());
        at += field.len() + 1;
        let word = field.trim();
        let inner = word.strip_prefix('"').and_then(|word| word.strip_suffix('"'));
        (start, inner.map_or(word, str::trim))
    })
}

fn fault(line: u64, column: usize, message: impl Into<String>) -> Diagnostic {
    let line = u32::try_from(line).unwrap_or(u32::MAX);
    let column = u32::try_from(column).unwrap_or(u32::MAX);
    Diagnostic { line, column, message: message.into(), help: String::new() }
}

/// Appends a number so that reading it gives the same bits (but `0` for `-0`): the shortest such
/// decimal, with an exponent where it would be long.
pub fn write_number(out: &mut String, value: f64) {
    // Adding 0 turns -0 into 0.
    let value = value + 0.0;
    let size = value.abs();
    // Writing to a string cannot fail.
    let _ = if size > 0.0 && !(1e-5..1e16).contains(&size) {
        write!(out, "{value:e}")
    } else {
        write!(out, "{value}")
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(header: &str, wanted: &[&str], row: &str) -> Result<Vec<f64>, String> {
        let columns = TableHeader::parse(1, header)
            .map_err(Diagnostics::from)
            .and_then(|header| header.columns(wanted))
            .map_err(|faults| faults.to_string())?;
        let mut values = Vec::new();
        columns.read(2, row, &mut values).map_err(|fault| fault.to_string())?;
        Ok(values)
    }

    #[test]
    fn columns_match_by_name_in_any_order() {
        assert_eq!(read("\u{feff}a, b,c", &["c", "a"], "1,x, \" 3e0\" \r\n"), Ok(vec![3.0, 1.0]));
        assert_eq!(read("a,b,c", &["a", "b", "c"], "-1,.5,5."), Ok(vec![-1.0, 0.5, 5.0]));
    }

    #[test]
    fn faults_have_a_place_and_a_remedy() {
        for (header, row, start) in [
            ("x,y", "1", "2:2: the row has 1 fields, but the header names 2"),
            ("x,y", "1,2,3", "2:6: the row has 3 fields"),
            ("x,y", "1;2", "2:1: x = \"1;2\" is not a number"),
            ("x,y", "1,inf", "2:3: y = inf is not a finite number"),
            ("x,y", "1, ", "2:4: y is empty"),
            ("x,y", "ä,1e999", "2:1: x = \"ä\""),
            ("x,y", "1,1e999", "2:3: y = 1e999 is not a finite"),
            ("1,2", "1,2", "1:1: the first line must name the columns"),
            ("x;y", "1;2", "1:1: the header \"x;y\" has no commas"),
            ("X,y", "1,2", "1:1: column x is missing\n  help: rename `X` if it is this column"),
            ("x,x,y", "1,2,3", "1:1: column x occurs twice"),
        ] {
            let found = read(header, &["x", "y"], row).unwrap_err();
            assert!(found.starts_with(start), "{found}");
        }
    }

    #[test]
    fn decimals_are_counted_as_they_are_written() {
        let columns = TableHeader::parse(1, "a,b,c,d").unwrap().columns(&["d", "a", "b"]).unwrap();
        let mut most = [0, 2, 9];
        columns.decimals("-1.250, 3. ,x,\"2.5E-4\"", &mut most);
        columns.decimals("1e3,1,1,1", &mut most);
        assert_eq!(most, [5, 3, 9]);
    }

    #[test]
    fn a_row_can_be_empty() {
        let columns = TableHeader::parse(1, "pose,x,y").unwrap().columns(&["x", "y"]).unwrap();
        assert!(columns.are_empty("7,,") && !columns.are_empty("7,,1") && !columns.are_empty(","));
    }

    #[test]
    fn numbers_round_trip() {
        let mut text = String::new();
        for value in [0.1 + 0.2, -0.0, 1e-300, f64::MAX, 5e-324, 90.0, 1e15, -1e-5, 123_456.789] {
            text.clear();
            write_number(&mut text, value);
            let again: f64 = text.parse().unwrap();
            assert_eq!((again + 0.0).to_bits(), (value + 0.0).to_bits(), "{text}");
            assert!(text.len() < 25, "{text}");
        }
        text.clear();
        write_number(&mut text, -0.0);
        assert_eq!(text, "0");
    }
}
