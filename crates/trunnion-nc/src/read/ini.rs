//! Configuration of a `LinuxCNC` machine: values that programs can read, and the files beside it.

use super::options::CodeRemap;
use std::ops::RangeInclusive;

/// Values of a configuration, as far as programs depend on them.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct IniFile {
    /// Numbers as parameters: `_ini[section]name`.
    pub parameters: Vec<(String, f64)>,
    /// Unit of lengths in the tool table \[mm\]: `[TRAJ] LINEAR_UNITS`.
    pub unit: f64,
    /// Name of the tool table: `[EMCIO] TOOL_TABLE`.
    pub tool_table: Option<String>,
    /// Folders of subprograms: `[DISPLAY] PROGRAM_PREFIX`, `[RS274NGC] SUBROUTINE_PATH`.
    pub folders: Vec<String>,
    /// Codes with another meaning: `[RS274NGC] REMAP`.
    pub remaps: Vec<CodeRemap>,
}

/// Reads the configuration of a `LinuxCNC` machine; what is no number stays out of the parameters.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::ini_file;
///
/// let ini = ini_file("[TRAJ]\nLINEAR_UNITS = inch\n[PROBE]\nspeed = 20 # fast\n");
/// assert_eq!(ini.parameters, [("_ini[PROBE]speed".to_owned(), 20.0)]);
/// assert_eq!(ini.unit, 25.4);
/// ```
pub fn ini_file(text: &str) -> IniFile {
    let mut ini = IniFile { unit: 1.0, ..IniFile::default() };
    let mut section = "";
    for line in text.lines() {
        let line = line.trim();
        if let Some(name) = line.strip_prefix('[') {
            section = name.split(']').next().unwrap_or_default().trim();
            continue;
        }
        // Remarks begin with a semicolon or a hash.
        let Some((name, value)) = line.split_once('=').filter(|_| !line.starts_with([';', '#']))
        else {
            continue;
        };
        let (name, value) = (name.trim(), value.trim());
        let number = value.split([';', '#']).next().unwrap_or_default().trim();
        if let Ok(number) = number.parse::<f64>()
            && number.is_finite()
        {
            ini.parameters.push((format!("_ini[{section}]{name}"), number));
        }
        let is = |of: &str, named: &str| {
            section.eq_ignore_ascii_case(of) && name.eq_ignore_ascii_case(named)
        };
        if is("TRAJ", "LINEAR_UNITS") {
            ini.unit = unit_of(number).unwrap_or(ini.unit);
        } else if is("EMCIO", "TOOL_TABLE") {
            ini.tool_table = Some(value.to_owned());
        } else if is("DISPLAY", "PROGRAM_PREFIX") || is("RS274NGC", "SUBROUTINE_PATH") {
            ini.folders.extend(
                value.split(':').map(str::trim).filter(|of| !of.is_empty()).map(str::to_owned),
            );
        } else if is("RS274NGC", "REMAP") {
            ini.remaps.extend(remap_of(value));
        }
    }
    ini
}

/// Reads `M400 modalgroup=10 argspec=PQ ngc=name`.
fn remap_of(value: &str) -> Option<CodeRemap> {
    let mut fields = value.split_whitespace();
    let code = fields.next()?.to_ascii_uppercase();
    let mut remap = CodeRemap { code, words: String::new(), subprogram: None };
    let mut python = false;
    for field in fields.filter_map(|field| field.split_once('=')) {
        match field {
            ("ngc", name) => remap.subprogram = Some(name.to_owned()),
            ("argspec", words) => words.clone_into(&mut remap.words),
            ("py" | "python" | "prolog" | "epilog", _) => python = true,
            _ => {}
        }
    }
    // Python around a subprogram may move axes and change its parameters.
    remap.subprogram = remap.subprogram.filter(|_| !python);
    Some(remap)
}

/// Units in a millimetre that a machine can have: from kilometres to nanometres.
const UNITS: RangeInclusive<f64> = 1e-6..=1e6;

/// Returns the millimetres of a unit, which is a name or the number of units in a millimetre.
fn unit_of(text: &str) -> Option<f64> {
    match text.to_ascii_lowercase().as_str() {
        "mm" | "metric" => Some(1.0),
        "in" | "inch" | "imperial" => Some(25.4),
        number => {
            // Beyond any length: the unit would be none, or none of the table's lengths a number.
            let number = number.parse::<f64>().ok().filter(|number| UNITS.contains(number))?;
            Some(1.0 / number)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_that_no_machine_has_is_left_out() {
        let unit = |text: &str| ini_file(&format!("[TRAJ]\nLINEAR_UNITS = {text}\n")).unit;
        for beyond in ["1e-320", "inf", "1e308", "0", "-1", "nan"] {
            assert!((unit(beyond) - 1.0).abs() < 1e-15, "{beyond}");
        }
        assert!((unit("0.03937007874015748") - 25.4).abs() < 1e-12);
    }
}
