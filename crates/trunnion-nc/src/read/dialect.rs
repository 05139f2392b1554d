//! The languages of controls, and the detection of the language of a program.

use std::fmt;

/// The language of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// `LinuxCNC`'s G-code; also any plain G-code.
    LinuxCnc,
    /// Fanuc and what follows it.
    Fanuc,
    /// Haas NGC.
    Haas,
    /// Sinumerik 840D and ONE.
    Siemens,
    /// Heidenhain Klartext.
    Heidenhain,
    /// APT/CL: cutter locations, read by [`cl`](super::cl()).
    Apt,
}

/// Names, the first of each dialect is its own.
const NAMES: [(&str, Dialect); 13] = [
    ("linuxcnc", Dialect::LinuxCnc),
    ("gcode", Dialect::LinuxCnc),
    ("g93", Dialect::LinuxCnc),
    ("rs274", Dialect::LinuxCnc),
    ("fanuc", Dialect::Fanuc),
    ("haas", Dialect::Haas),
    ("siemens", Dialect::Siemens),
    ("sinumerik", Dialect::Siemens),
    ("heidenhain", Dialect::Heidenhain),
    ("klartext", Dialect::Heidenhain),
    ("apt", Dialect::Apt),
    ("cl", Dialect::Apt),
    ("clsf", Dialect::Apt),
];

/// Words that only one language has, at the beginning of a line.
const STARTS: [(&str, Dialect); 20] = [
    ("BEGIN PGM", Dialect::Heidenhain),
    ("BLK FORM", Dialect::Heidenhain),
    ("TOOL CALL", Dialect::Heidenhain),
    ("CYCL DEF", Dialect::Heidenhain),
    ("PARTNO", Dialect::Apt),
    ("TOOL PATH/", Dialect::Apt),
    ("TLDATA/", Dialect::Apt),
    ("UNITS/", Dialect::Apt),
    ("MULTAX", Dialect::Apt),
    ("MACHIN/", Dialect::Apt),
    ("MACHIN /", Dialect::Apt),
    ("LOADTL/", Dialect::Apt),
    ("LOAD/", Dialect::Apt),
    ("GOTO/", Dialect::Apt),
    ("GOTO /", Dialect::Apt),
    ("FEDRAT/", Dialect::Apt),
    ("$$", Dialect::Apt),
    ("%_N_", Dialect::Siemens),
    ("DEF REAL", Dialect::Siemens),
    ("DEF INT", Dialect::Siemens),
];

/// Statements that only one language begins a block with, behind its number and label.
const STATEMENTS: [(&str, Dialect); 15] = [
    ("GOTOF", Dialect::Siemens),
    ("GOTOB", Dialect::Siemens),
    ("FOR ", Dialect::Siemens),
    ("WHILE R", Dialect::Siemens),
    ("IF R", Dialect::Siemens),
    ("ENDIF", Dialect::Siemens),
    ("ENDFOR", Dialect::Siemens),
    ("ENDWHILE", Dialect::Siemens),
    ("ENDLOOP", Dialect::Siemens),
    ("IF[", Dialect::Fanuc),
    ("IF [", Dialect::Fanuc),
    ("WHILE[", Dialect::Fanuc),
    ("WHILE [", Dialect::Fanuc),
    ("CALL LBL", Dialect::Heidenhain),
    ("LBL ", Dialect::Heidenhain),
];

/// Words that only one language has, anywhere on a line.
const WORDS: [(&str, Dialect); 27] = [
    ("TRAORI", Dialect::Siemens),
    ("TRAFOOF", Dialect::Siemens),
    ("A3=", Dialect::Siemens),
    ("C3=", Dialect::Siemens),
    ("CYCLE8", Dialect::Siemens),
    ("ORIWKS", Dialect::Siemens),
    ("ORIMKS", Dialect::Siemens),
    ("T=\"", Dialect::Siemens),
    ("SUPA", Dialect::Siemens),
    ("MSG(", Dialect::Siemens),
    ("G642", Dialect::Siemens),
    ("G710", Dialect::Siemens),
    ("CR=", Dialect::Siemens),
    ("#<", Dialect::LinuxCnc),
    ("M428", Dialect::LinuxCnc),
    ("M429", Dialect::LinuxCnc),
    ("ENDSUB", Dialect::LinuxCnc),
    ("ENDWHILE", Dialect::LinuxCnc),
    ("G64P", Dialect::LinuxCnc),
    ("G12.1P", Dialect::LinuxCnc),
    ("G234", Dialect::Haas),
    ("G187", Dialect::Haas),
    ("G254", Dialect::Haas),
    ("G43.4", Dialect::Fanuc),
    ("G43.5", Dialect::Fanuc),
    ("G68.2", Dialect::Fanuc),
    ("G05.1", Dialect::Fanuc),
];

impl Dialect {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::LinuxCnc, Self::Fanuc, Self::Haas, Self::Siemens, Self::Heidenhain, Self::Apt];

    /// Returns the dialect of a name, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|&(_, dialect)| dialect)
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(_, dialect)| *dialect == self).map_or("", |(name, _)| name)
    }

    /// Detects the dialect of a program from its first lines: the first line that only one of them
    /// has decides.
    /// Without such a line it is G-code, and read as `LinuxCNC`'s.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_nc::read::Dialect;
    ///
    /// assert_eq!(Dialect::guess("G21\nG43.4 H1 X10.\n".lines()), Dialect::Fanuc);
    /// assert_eq!(Dialect::guess("G0 X1\nM2\n".lines()), Dialect::LinuxCnc);
    /// ```
    pub fn guess<I>(lines: I) -> Self
    where
        I: IntoIterator<Item: AsRef<str>>,
    {
        // Many programs begin with lines that all dialects share: the first characteristic line
        // decides.
        let mut program_number = false;
        for line in lines {
            let line = line.as_ref();
            if let Some(dialect) = Self::of_line(line) {
                return dialect;
            }
            // `O0001` alone is not decisive, as LinuxCNC has O-words: it counts when nothing else
            // does.
            program_number |= is_program_number(line);
        }
        if program_number { Self::Fanuc } else { Self::LinuxCnc }
    }

    /// Returns the dialect of a line that only one of them has.
    fn of_line(line: &str) -> Option<Self> {
        // Words stand near the beginning of a line.
        let head: String = line.trim_start().chars().take(200).collect();
        // Klartext numbers its blocks without a letter, so leading digits are passed over.
        let upper = head.to_ascii_uppercase();
        let after_number = upper.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        if let Some((_, dialect)) = STARTS.iter().find(|(word, _)| after_number.starts_with(word)) {
            return Some(*dialect);
        }
        if is_klartext(after_number) || is_heidenhain_iso(after_number) {
            return Some(Self::Heidenhain);
        }
        // Statements count at the beginning of a block only: in a comment they are plain text.
        let bare = behind_number_and_label(after_number);
        if let Some((_, dialect)) = STATEMENTS.iter().find(|(word, _)| bare.starts_with(word)) {
            return Some(*dialect);
        }
        // Words are searched without blanks, as G-code allows `G 43.4` and `G05 .1`.
        let code_text = without_comments(&upper);
        WORDS.iter().find(|(word, _)| code_text.contains(word)).map(|&(_, dialect)| dialect)
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns a block without `N10` and `LABEL:`.
fn behind_number_and_label(line: &str) -> &str {
    let number =
        line.strip_prefix('N').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    let line = number.unwrap_or(line).trim_start();
    let name = |label: &str| label.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    // Labels of Sinumerik have two characters at least.
    let label = line.split_once(':').filter(|(label, _)| label.len() > 1 && name(label));
    label.map_or(line, |(_, rest)| rest).trim_start()
}

/// Returns true for `L X+10`, `LN X-3`.
fn is_klartext(line: &str) -> bool {
    let rest = line.strip_prefix("LN ").or_else(|| line.strip_prefix("L "));
    rest.is_some_and(|rest| {
        // An axis letter and a sign, a second letter (`IX`) or a parameter (`XQ1`) follow.
        let mut letters = rest.trim_start().chars();
        letters.next().is_some_and(|c| "XYZABCI".contains(c))
            && letters.next().is_some_and(|c| "+-XYZABCQ".contains(c))
    })
}

/// Returns true for `%NAME G71 *`, the first line of a DIN/ISO program of Heidenhain.
pub(super) fn is_heidenhain_iso(line: &str) -> bool {
    let head = line.trim().strip_prefix('%').and_then(|line| line.strip_suffix('*'));
    head.is_some_and(|head| {
        let unit = head.split_whitespace().last();
        unit.is_some_and(|unit| matches!(unit.to_ascii_uppercase().as_str(), "G70" | "G71"))
    })
}

/// Returns true for `O0001` or `:1` with at most a comment behind.
fn is_program_number(line: &str) -> bool {
    let line = line.trim_start();
    let rest = line.strip_prefix(['O', 'o', ':']);
    rest.is_some_and(|rest| {
        let digits = rest.chars().take_while(char::is_ascii_digit).count();
        let behind = rest.chars().nth(digits);
        // `O100 sub` is an O-word of LinuxCNC, not a program number.
        digits > 0
            && behind.is_none_or(|c| c.is_whitespace() || c == '(')
            && !rest
                .chars()
                .skip(digits)
                .collect::<String>()
                .trim_start()
                .starts_with(|c: char| c.is_ascii_alphabetic())
    })
}

/// Returns a line without comments and blanks.
fn without_comments(line: &str) -> String {
    let mut depth = 0_u32;
    let mut code_text = String::with_capacity(line.len());
    // A semicolon inside a comment in brackets does not begin one itself.
    let code = if line.contains('(') && line.contains(')') {
        line
    } else {
        line.split(';').next().unwrap_or(line)
    };
    for (at, c) in code.char_indices() {
        match c {
            // `MSG(` and `CYCLE832(` are words with arguments, not words with comments.
            '(' => {
                if depth == 0
                    && code
                        .get(..at)
                        .is_some_and(|before| before.ends_with(|c: char| c.is_ascii_alphanumeric()))
                {
                    code_text.push(c);
                }
                depth += 1;
            }
            ')' => depth = depth.saturating_sub(1),
            ';' if depth == 0 => break,
            c if depth == 0 && !c.is_whitespace() => code_text.push(c),
            _ => {}
        }
    }
    code_text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_dialects() {
        for dialect in Dialect::ALL {
            assert_eq!(Dialect::from_name(dialect.name()), Some(dialect));
            assert_eq!(Dialect::from_name(&dialect.name().to_uppercase()), Some(dialect));
        }
        assert_eq!(Dialect::from_name("pascal"), None);
    }

    #[test]
    fn one_line_tells() {
        let cases = [
            ("%\nO0001 (DEMO)\nG21 G17\nG43.4 H1 X10.\n", Dialect::Fanuc),
            ("O1234\nG0 X1.\nM30\n", Dialect::Fanuc),
            ("o100 sub\nG0 X1\no100 endsub\n", Dialect::LinuxCnc),
            ("G21 G90\nT1 M6 (TRAORI)\nM428\n", Dialect::LinuxCnc),
            ("G0 X1\nM2\n", Dialect::LinuxCnc),
            ("N10 G17 G90 G94 G710 G54\n", Dialect::Siemens),
            ("N10 T=\"BALL10\" D1\n", Dialect::Siemens),
            ("; made by\nTRAORI(1)\n", Dialect::Siemens),
            ("0 BEGIN PGM DEMO MM\n", Dialect::Heidenhain),
            ("%DEMO G71 *\nN10 G30 G17 X+0 Y+0 Z-40 *\n", Dialect::Heidenhain),
            ("8 L X+10 Y+5 R0 FMAX\n", Dialect::Heidenhain),
            ("PARTNO DEMO\nUNITS/MM\n", Dialect::Apt),
            ("goto / 1,2,3\n", Dialect::Apt),
            ("G0 X1\nG234 H1\n", Dialect::Haas),
            ("N10 R1=0\nN20 AGAIN: IF R1==5 GOTOF ENDE\n", Dialect::Siemens),
            ("G0 X1\nENDWHILE\n", Dialect::Siemens),
            ("o1 while [#1 lt 2]\no1 endwhile\n", Dialect::LinuxCnc),
            ("#1=1\nN5 WHILE [#1 LT 5] DO 1\n", Dialect::Fanuc),
            ("12 CALL LBL 3 REP 2\n", Dialect::Heidenhain),
            ("", Dialect::LinuxCnc),
        ];
        for (text, dialect) in cases {
            assert_eq!(Dialect::guess(text.lines()), dialect, "{text}");
        }
    }
}
