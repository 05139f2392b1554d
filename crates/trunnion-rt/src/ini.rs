//! Joints of an INI file of `LinuxCNC` beside the axes of a machine file.

use trunnion::machine::{Axis, AxisKind, FIRST_ROTARY, Machine};
use trunnion::nc::read::AxisWords;
use trunnion::nc::write::WordsError;

/// Travel that rounding of an INI file explains \[mm or deg\].
const ROUNDING: f64 = 1e-3;

/// Share of a rate that it explains.
const ROUNDING_SHARE: f64 = 1e-6;

/// Difference between an INI file and the machine file because of which a machine cannot run by both.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IniDifference {
    /// Lengths of the INI file are not in mm.
    #[error(
        "[TRAJ]LINEAR_UNITS = {stated}: the joints of the machine file are in mm; write mm, and all lengths in it"
    )]
    Units {
        /// Unit that the file states.
        stated: String,
    },
    /// A joint turns and its axis does not, or the other way round.
    #[error(
        "[JOINT_{joint}]TYPE = {stated}: axis {letter} of the machine file needs {wanted}; write it, or take the file of this machine"
    )]
    Kind {
        /// Number of the joint.
        joint: usize,
        /// Kind that the file states.
        stated: String,
        /// Letter of the axis.
        letter: char,
        /// Kind of the axis.
        wanted: &'static str,
    },
    /// The travel of a joint ends inside that of its axis: the control would stop there inside a block.
    #[error(
        "[JOINT_{joint}]{key} = {stated}: axis {letter} of the machine file goes on to {end} {unit}; write the same travel in both files"
    )]
    Travel {
        /// Number of the joint.
        joint: usize,
        /// Key of the end.
        key: &'static str,
        /// End that the file states \[mm or deg\].
        stated: f64,
        /// Letter of the axis.
        letter: char,
        /// End of the axis \[mm or deg\].
        end: f64,
        /// Unit of both.
        unit: &'static str,
    },
    /// A joint may not be as fast as its axis.
    #[error(
        "[JOINT_{joint}]{key} = {stated}: axis {letter} of the machine file has {limit} {unit}, which is planned with; write the smaller of both in both files"
    )]
    Rate {
        /// Number of the joint.
        joint: usize,
        /// Key of the limit.
        key: &'static str,
        /// Limit that the file states.
        stated: f64,
        /// Letter of the axis.
        letter: char,
        /// Limit of the axis.
        limit: f64,
        /// Unit of both.
        unit: &'static str,
    },
}

/// Compares the joints of an INI file with the axes of a machine. Limits of the INI file may be wider than those of the
/// machine, which are planned with, and keys may be absent.
///
/// # Errors
///
/// [`WordsError`] if the axes have no letters.
pub fn ini_differences(machine: &Machine, ini: &str) -> Result<Vec<IniDifference>, WordsError> {
    let ini = IniText(ini);
    let letters = AxisWords::of(machine)?.0.map(|word| word.letter);
    let axes: Vec<LetteredAxis<'_>> = letters
        .into_iter()
        .zip(&machine.axes)
        .map(|(letter, axis)| LetteredAxis { letter, axis })
        .collect();
    let mut found: Vec<IniDifference> = units(&ini).into_iter().collect();
    for (joint, letter) in joint_letters(&ini, &letters).into_iter().enumerate() {
        // A letter without an axis is a fault of the kinematics, which name it.
        let Some(axis) = axes.iter().find(|axis| axis.letter == letter) else { continue };
        found.extend(axis.kind(&ini, joint));
        found.extend(axis.travel(&ini, joint));
        found.extend(axis.rates(&ini, joint));
    }
    Ok(found)
}

/// Text of an INI file.
struct IniText<'a>(&'a str);

impl<'a> IniText<'a> {
    /// Returns the first value of a key in a section.
    fn value(&self, section: &str, key: &str) -> Option<&'a str> {
        let mut inside = false;
        for row in self.0.lines().map(str::trim) {
            if let Some(name) = row.strip_prefix('[').and_then(|row| row.split(']').next()) {
                inside = name.trim() == section;
            } else if inside
                && let Some((found, value)) = row.split_once('=')
                && found.trim() == key
            {
                return value.split(" #").next().map(str::trim);
            }
        }
        None
    }

    /// Returns the number of a key of a joint.
    fn number(&self, joint: usize, key: &str) -> Option<f64> {
        let value = self.value(&format!("JOINT_{joint}"), key)?;
        value.split_whitespace().next()?.parse().ok()
    }
}

fn units(ini: &IniText<'_>) -> Option<IniDifference> {
    let stated = ini.value("TRAJ", "LINEAR_UNITS")?;
    let is_metric = matches!(stated, "mm" | "metric");
    (!is_metric).then(|| IniDifference::Units { stated: stated.to_owned() })
}

/// Returns the letters of the joints, as the kinematics give them.
fn joint_letters(ini: &IniText<'_>, letters: &[char]) -> Vec<char> {
    let kinematics = ini.value("KINS", "KINEMATICS").unwrap_or_default();
    let stated = kinematics.split_whitespace().find_map(|word| word.strip_prefix("coordinates="));
    if let Some(stated) = stated {
        return stated.chars().map(|letter| letter.to_ascii_uppercase()).collect();
    }
    let mut usual = letters.to_vec();
    if let Some(rotaries) = usual.get_mut(FIRST_ROTARY..) {
        rotaries.sort_unstable();
    }
    usual
}

/// Returns a number with nine decimals: the machine has its angles in rad.
fn decimals(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// An axis with the letter of its words.
struct LetteredAxis<'a> {
    letter: char,
    axis: &'a Axis,
}

impl LetteredAxis<'_> {
    fn is_rotary(&self) -> bool {
        self.axis.kind == AxisKind::Rotary
    }

    /// Units of the INI file in one of the machine.
    fn scale(&self) -> f64 {
        if self.is_rotary() { 1.0_f64.to_degrees() } else { 1.0 }
    }

    fn kind(&self, ini: &IniText<'_>, joint: usize) -> Option<IniDifference> {
        let stated = ini.value(&format!("JOINT_{joint}"), "TYPE")?;
        let wanted = if self.is_rotary() { "ANGULAR" } else { "LINEAR" };
        (stated != wanted).then(|| IniDifference::Kind {
            joint,
            stated: stated.to_owned(),
            letter: self.letter,
            wanted,
        })
    }

    fn travel(&self, ini: &IniText<'_>, joint: usize) -> Vec<IniDifference> {
        let unit = if self.is_rotary() { "deg" } else { "mm" };
        let ends = self.axis.limits.ends().map(|end| decimals(end * self.scale()));
        let sides = [("MIN_LIMIT", ends[0], -1.0), ("MAX_LIMIT", ends[1], 1.0)];
        let inside = |(key, end, outwards): (&'static str, f64, f64)| {
            let stated = ini.number(joint, key)?;
            let short = (end - stated) * outwards > ROUNDING;
            let letter = self.letter;
            short.then_some(IniDifference::Travel { joint, key, stated, letter, end, unit })
        };
        sides.into_iter().filter_map(inside).collect()
    }

    fn rates(&self, ini: &IniText<'_>, joint: usize) -> Vec<IniDifference> {
        let units = if self.is_rotary() { ["deg/s", "deg/s2"] } else { ["mm/s", "mm/s2"] };
        let rates = [("MAX_VELOCITY", self.axis.vel), ("MAX_ACCELERATION", self.axis.acc)];
        let slower = |((key, rate), unit): ((&'static str, f64), &'static str)| {
            let (limit, letter) = (decimals(rate * self.scale()), self.letter);
            let stated = ini.number(joint, key)?;
            let low = stated < limit * (1.0 - ROUNDING_SHARE);
            low.then_some(IniDifference::Rate { joint, key, stated, letter, limit, unit })
        };
        rates.into_iter().zip(units).filter_map(slower).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::machine_named;

    const INI: &str = "[KINS]\nKINEMATICS = trunnionkins machine=m.toml coordinates=XYZBC\n[TRAJ]\nLINEAR_UNITS = mm\n\
        [JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = -762\nMAX_LIMIT = 0\nMAX_VELOCITY = 500 # as the drive\n\
        [JOINT_3]\nTYPE = ANGULAR\nMIN_LIMIT = -35.0004\nMAX_LIMIT = 120\nMAX_ACCELERATION = 300\n";

    fn found(from: &str, to: &str) -> Vec<String> {
        let kinematics = machine_named("bc-trunnion").unwrap();
        assert!(INI.contains(from));
        let ini = INI.replace(from, to);
        let differences = ini_differences(kinematics.machine(), &ini).unwrap();
        differences.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn an_ini_file_that_fits_has_no_differences() {
        assert!(found("mm", "mm").is_empty(), "{:?}", found("mm", "mm"));
        // Wider limits do no harm: those of the machine are planned with.
        assert!(found("MAX_LIMIT = 0", "MAX_LIMIT = 10").is_empty());
        assert!(found("MAX_LIMIT = 0\n", "").is_empty());
    }

    #[test]
    fn what_is_narrower_or_of_another_kind_is_named() {
        for (from, to, says) in [
            ("= mm", "= inch", "[TRAJ]LINEAR_UNITS = inch: "),
            (
                "TYPE = ANGULAR",
                "TYPE = LINEAR",
                "[JOINT_3]TYPE = LINEAR: axis B of the machine file needs ANGULAR",
            ),
            (
                "MIN_LIMIT = -762",
                "MIN_LIMIT = -700",
                "[JOINT_0]MIN_LIMIT = -700: axis X of the machine file goes on to -762 mm",
            ),
            (
                "MAX_LIMIT = 120",
                "MAX_LIMIT = 90",
                "[JOINT_3]MAX_LIMIT = 90: axis B of the machine file goes on to 120",
            ),
            ("= 500 #", "= 50 #", "[JOINT_0]MAX_VELOCITY = 50: axis X of the machine file has "),
            (
                "MAX_ACCELERATION = 300",
                "MAX_ACCELERATION = 299",
                "[JOINT_3]MAX_ACCELERATION = 299: axis B",
            ),
        ] {
            let said = found(from, to);
            assert!(said.len() == 1 && said[0].starts_with(says), "{says}: {said:?}");
        }
    }

    #[test]
    fn joints_follow_the_letters_of_the_kinematics() {
        let said = found("coordinates=XYZBC", "coordinates=byzxc");
        assert!(
            said.iter().any(|line| line.starts_with("[JOINT_0]TYPE = LINEAR: axis B")),
            "{said:?}"
        );
        // Without letters the rotaries are in the order of the alphabet: joint 3 is B.
        assert!(found(" coordinates=XYZBC", "").is_empty());
    }
}
