//! Formats that are read, and their marks.

/// Format of a foreign machine description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ControlFormat {
    /// INI file of `LinuxCNC`, with HAL files beside it.
    LinuxCnc,
    /// Machine data of Siemens as text (`$MC_TRAFO5_...`).
    Siemens,
    /// Kinematics table of Heidenhain, as exported.
    Heidenhain,
    /// Parameters of Fanuc, as punched out.
    Fanuc,
    /// List of Haas settings.
    Haas,
    /// Machine of `FreeCAD` (`.fcm`).
    FreeCad,
}

impl ControlFormat {
    /// All formats with their names.
    pub const ALL: [(&str, Self); 6] = [
        ("linuxcnc", Self::LinuxCnc),
        ("siemens", Self::Siemens),
        ("heidenhain", Self::Heidenhain),
        ("fanuc", Self::Fanuc),
        ("haas", Self::Haas),
        ("freecad", Self::FreeCad),
    ];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }

    /// Returns the format of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(one, _)| *one == name).map(|&(_, one)| one)
    }

    /// Returns the format whose marks a text has; `None` if it has those of none.
    pub fn detect(text: &str) -> Option<Self> {
        let has = |mark: &str| text.contains(mark);
        if text.trim_start().starts_with('{') {
            return has("\"machine\"").then_some(Self::FreeCad);
        }
        let punched = |line: &str| {
            let line = line.trim_start();
            line.strip_prefix('N')
                .is_some_and(|rest| rest.trim_start_matches('0').starts_with("1968"))
        };
        if has("[KINS]") {
            Some(Self::LinuxCnc)
        } else if has("$MC_TRAFO") {
            Some(Self::Siemens)
        } else if has("MachAxis") {
            Some(Self::Heidenhain)
        } else if text.lines().any(punched) {
            Some(Self::Fanuc)
        } else if text.to_ascii_uppercase().contains("MRZP") {
            Some(Self::Haas)
        } else {
            None
        }
    }
}
