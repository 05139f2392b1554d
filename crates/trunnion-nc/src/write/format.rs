//! Output formats: the meaning of X Y Z and F, the form of numbers, the words of moves.

use super::error_bound::Coordinates;
use super::number::NumberForm;
use crate::machine::Machine;
use crate::read::Dialect;
use crate::words::Coolant;

/// A program format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OutputFormat {
    /// `LinuxCNC` with TCP kinematics: tip and rotary angles.
    LinuxCnc,
    /// Any control without TCP: axis positions in inverse time.
    G93,
    /// Fanuc `G43.4`: tip and rotary angles.
    Fanuc,
    /// Fanuc `G43.5`: tip and tool vector I J K.
    FanucVector,
    /// Haas `G234`: tip and rotary angles.
    Haas,
    /// Siemens `TRAORI`: tip and tool vector A3 B3 C3.
    Siemens,
    /// Siemens `TRAORI` with rotary angles.
    SiemensAxes,
    /// Heidenhain `LN` with TX TY TZ under `FUNCTION TCPM`.
    Heidenhain,
    /// Heidenhain `L` with rotary angles under `FUNCTION TCPM`.
    HeidenhainAxes,
    /// APT/CL file, ISO 4343 style: cutter locations in the workpiece frame.
    Apt,
}

/// Words that give the tool orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OrientationWords {
    /// Rotary axis words.
    Angles,
    /// Components of the tool vector, with what stands before each number.
    Vector([&'static str; 3]),
}

/// Syntax of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BlockSyntax {
    pub(super) form: NumberForm,
    pub(super) pointing: OrientationWords,
    /// Word of a rapid move, and of one with feed.
    pub(super) moves: [&'static str; 2],
    /// That word stands in every block.
    pub(super) every_block: bool,
    /// X Y Z stand in every block with feed.
    pub(super) whole_tip: bool,
    /// Stands at the end of a rapid block.
    pub(super) rapid_tail: &'static str,
}

/// Every dialect with its name.
pub const OUTPUT_FORMATS: [(&str, OutputFormat); 10] = [
    ("linuxcnc", OutputFormat::LinuxCnc),
    ("g93", OutputFormat::G93),
    ("fanuc", OutputFormat::Fanuc),
    ("fanuc-vector", OutputFormat::FanucVector),
    ("haas", OutputFormat::Haas),
    ("siemens", OutputFormat::Siemens),
    ("siemens-axes", OutputFormat::SiemensAxes),
    ("heidenhain", OutputFormat::Heidenhain),
    ("heidenhain-axes", OutputFormat::HeidenhainAxes),
    ("apt", OutputFormat::Apt),
];

/// Further names that machine files use.
const ALIASES: [(&str, OutputFormat); 6] = [
    ("haas-ngc", OutputFormat::Haas),
    ("siemens-840d", OutputFormat::Siemens),
    ("siemens-one", OutputFormat::Siemens),
    ("heidenhain-klartext", OutputFormat::Heidenhain),
    ("fanuc-30i", OutputFormat::Fanuc),
    ("iso", OutputFormat::G93),
];

impl OutputFormat {
    /// Returns the format of a name, which may be one that machine files use.
    pub fn from_name(name: &str) -> Option<Self> {
        let known = OUTPUT_FORMATS.iter().chain(&ALIASES);
        known.into_iter().find(|(of, _)| name.eq_ignore_ascii_case(of)).map(|&(_, one)| one)
    }

    /// Returns the format that the machine file names, `G93` if it names none that is known.
    pub fn of(machine: &Machine) -> Self {
        Self::from_name(&machine.dialect.name).unwrap_or(Self::G93)
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        OUTPUT_FORMATS.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }

    /// Returns the extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::LinuxCnc => "ngc",
            Self::Siemens | Self::SiemensAxes => "mpf",
            Self::Heidenhain | Self::HeidenhainAxes => "h",
            Self::Apt => "cls",
            Self::G93 | Self::Fanuc | Self::FanucVector | Self::Haas => "nc",
        }
    }

    /// Returns the name of the file that a job writes in this format.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_nc::write::OutputFormat;
    ///
    /// assert_eq!(OutputFormat::SiemensAxes.program_file(), "program.siemens-axes.mpf");
    /// ```
    pub fn program_file(self) -> &'static str {
        match self {
            Self::LinuxCnc => "program.linuxcnc.ngc",
            Self::G93 => "program.g93.nc",
            Self::Fanuc => "program.fanuc.nc",
            Self::FanucVector => "program.fanuc-vector.nc",
            Self::Haas => "program.haas.nc",
            Self::Siemens => "program.siemens.mpf",
            Self::SiemensAxes => "program.siemens-axes.mpf",
            Self::Heidenhain => "program.heidenhain.h",
            Self::HeidenhainAxes => "program.heidenhain-axes.h",
            Self::Apt => "program.apt.cls",
        }
    }

    /// Returns the dialect whose reader understands this format.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_nc::read::Dialect;
    /// use trunnion_nc::write::OutputFormat;
    ///
    /// assert_eq!(OutputFormat::FanucVector.dialect(), Dialect::Fanuc);
    /// ```
    pub fn dialect(self) -> Dialect {
        match self {
            Self::LinuxCnc | Self::G93 => Dialect::LinuxCnc,
            Self::Fanuc | Self::FanucVector => Dialect::Fanuc,
            Self::Haas => Dialect::Haas,
            Self::Siemens | Self::SiemensAxes => Dialect::Siemens,
            Self::Heidenhain | Self::HeidenhainAxes => Dialect::Heidenhain,
            Self::Apt => Dialect::Apt,
        }
    }

    /// Returns the meaning of X Y Z.
    pub fn coordinates(self) -> Coordinates {
        if self == Self::G93 { Coordinates::Axes } else { Coordinates::Tip }
    }

    /// Returns true if blocks carry the tool vector, not rotary angles.
    pub fn is_vector(self) -> bool {
        matches!(self.syntax().pointing, OrientationWords::Vector(_))
    }

    /// Returns true if F is one over the time of the block, unless the machine file chooses otherwise.
    pub(super) fn by_time(self) -> bool {
        matches!(self, Self::LinuxCnc | Self::G93)
    }

    /// Returns the words that start a coolant; `None` for none.
    pub(super) fn coolant_words(self, coolant: Coolant) -> Option<&'static str> {
        match (coolant, self) {
            (Coolant::Off, _) => None,
            (Coolant::Mist, Self::Apt) => Some("MIST"),
            (_, Self::Apt) => Some("ON"),
            (Coolant::Mist, _) => Some("M7"),
            (Coolant::Flood, _) => Some("M8"),
            // Two codes of one group stand on lines of their own.
            (Coolant::MistAndFlood, _) => Some("M7\nM8"),
        }
    }

    /// Returns the lines that switch from one coolant to another.
    pub(super) fn coolant_switch(self, from: Coolant, to: Coolant) -> Vec<&'static str> {
        let words = self.coolant_words(to);
        if self == Self::Apt {
            return vec![match words {
                None => "COOLNT/OFF",
                Some("MIST") => "COOLNT/MIST",
                Some(_) => "COOLNT/ON",
            }];
        }
        // M9 ends both; M7 and M8 end nothing.
        let ends = from.is_on() && !to.includes(from);
        ends.then_some("M9").into_iter().chain(words.into_iter().flat_map(str::lines)).collect()
    }

    pub(super) fn syntax(self) -> BlockSyntax {
        // ISO 6983 words; the others differ from it in the fields that are set.
        let iso = BlockSyntax {
            form: NumberForm::Point,
            pointing: OrientationWords::Angles,
            moves: ["G0", "G1"],
            every_block: false,
            whole_tip: false,
            rapid_tail: "",
        };
        let siemens = BlockSyntax { form: NumberForm::Plain, ..iso };
        // Klartext: every block begins with L, numbers have signs, and FMAX is rapid.
        let klartext = BlockSyntax {
            form: NumberForm::Signed,
            moves: ["L", "L"],
            every_block: true,
            rapid_tail: " FMAX",
            ..iso
        };
        match self {
            Self::LinuxCnc | Self::G93 => BlockSyntax { every_block: true, ..iso },
            Self::Fanuc | Self::Haas => iso,
            Self::FanucVector => {
                BlockSyntax { pointing: OrientationWords::Vector(["I", "J", "K"]), ..iso }
            }
            Self::SiemensAxes => siemens,
            Self::Siemens => {
                BlockSyntax { pointing: OrientationWords::Vector(["A3=", "B3=", "C3="]), ..siemens }
            }
            Self::HeidenhainAxes => klartext,
            Self::Heidenhain => BlockSyntax {
                pointing: OrientationWords::Vector(["TX", "TY", "TZ"]),
                moves: ["LN", "LN"],
                // LN needs X Y Z and the whole vector in every block.
                whole_tip: true,
                ..klartext
            },
            Self::Apt => BlockSyntax { pointing: OrientationWords::Vector(["", "", ""]), ..iso },
        }
    }

    /// Returns the text of its built-in template.
    pub fn template(self) -> &'static str {
        match self {
            Self::LinuxCnc => include_str!("templates/linuxcnc.j2"),
            Self::G93 => include_str!("templates/g93.j2"),
            Self::Fanuc => include_str!("templates/fanuc.j2"),
            Self::FanucVector => include_str!("templates/fanuc-vector.j2"),
            Self::Haas => include_str!("templates/haas.j2"),
            Self::Siemens => include_str!("templates/siemens.j2"),
            Self::SiemensAxes => include_str!("templates/siemens-axes.j2"),
            Self::Heidenhain => include_str!("templates/heidenhain.j2"),
            Self::HeidenhainAxes => include_str!("templates/heidenhain-axes.j2"),
            Self::Apt => include_str!("templates/apt.j2"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dialect_comes_back_from_its_name() {
        for (name, dialect) in OUTPUT_FORMATS {
            assert_eq!(OutputFormat::from_name(name), Some(dialect));
            assert_eq!(dialect.name(), name);
        }
        assert_eq!(OutputFormat::from_name("Siemens-840D"), Some(OutputFormat::Siemens));
        assert_eq!(OutputFormat::from_name("fnauc"), None);
    }
}
