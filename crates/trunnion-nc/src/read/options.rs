//! Options of the program readers.

use super::dialect::Dialect;
use crate::types::AXES;
use crate::words::AxisWords;

/// Options that decide the meaning of a program. Begin with [`ReadOptions::new`] and change the rest by struct update.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// The control's language.
    pub dialect: Dialect,
    /// Letters, units and signs of the axes. The decimals are not used: the text shows them.
    pub axes: AxisWords,
    /// One axis beyond those five may move, too: [`Move::sixth`](super::step::Move::sixth).
    pub sixth: bool,
    /// Faults after which reading stops.
    pub most_faults: usize,
    /// Lines that loops, subprograms and repeated cycles may run or pass over in all.
    pub most_repeated: u64,
    /// Run lines that begin with `/`; `None`: such a line is a fault, as nobody knows.
    pub block_delete: Option<bool>,
    /// Values of parameters that the program does not set itself: `5`, `_hal[x]`, `R1`, `Q5`.
    pub parameters: Vec<(String, f64)>,
    /// Axis positions of `G28` \[mm, rad\].
    pub reference: [f64; AXES],
    /// Upper end of the travel of Z \[mm\], to which `M140 MB MAX` retracts; `None`: such a retract is refused.
    pub retract_height: Option<f64>,
    /// Codes that move nothing and change no meaning, by the user's word: `M400`, `CYCLE999`, `CYCL DEF 239`. One that begins
    /// a line is kept with the rest of it, another by itself.
    pub passive: Vec<String>,
    /// Axis positions before the first block \[mm, rad\], of a control as it is switched on: work offsets, shifts and the
    /// places of `G28` and `G30` are zero, and no tool is in the spindle. `None`: all that is not known.
    pub start: Option<[f64; AXES]>,
    /// Tool table of the control, for cutter compensation and tool offsets that a program writes.
    pub tools: Vec<ToolRow>,
    /// Files of subprograms that the program calls and does not contain.
    pub subprograms: Vec<SubprogramFile>,
    /// Codes that the configuration of the control gives another meaning.
    pub remaps: Vec<CodeRemap>,
}

/// A code that stands for a subprogram: `REMAP` in the configuration of `LinuxCNC`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodeRemap {
    /// The code: `M400`, `G88.1`.
    pub code: String,
    /// Words that it takes (`argspec`): upper case it needs, lower case it may have; behind `@` they become `#1`, `#2` and so
    /// on, otherwise `#<p>`, `#<q>`.
    pub words: String,
    /// Name of the subprogram; `None`: it is Python, which is not run.
    pub subprogram: Option<String>,
}

/// A file with a subprogram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SubprogramFile {
    /// Name of the subprogram, which is that of the file without its ending.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// A row of the control's tool table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolRow {
    /// Number of the tool.
    pub number: u32,
    /// Offsets along X Y Z \[mm\]; along Z it is the length of the tool.
    pub offset: [f64; 3],
    /// Diameter \[mm\]; cutter compensation halves it.
    pub diameter: f64,
    /// Corner of a turning tool that its offsets are of, 1 to 8; 0 and 9 are its middle.
    pub corner: u32,
}

impl ReadOptions {
    /// Creates options for five axes: a million repeated lines, no parameters, the reference
    /// position at machine zero.
    pub fn new(dialect: Dialect, axes: AxisWords, most_faults: usize) -> Self {
        Self {
            dialect,
            axes,
            sixth: false,
            most_faults,
            most_repeated: 1_000_000,
            block_delete: None,
            parameters: Vec::new(),
            reference: [0.0; AXES],
            retract_height: None,
            passive: Vec::new(),
            start: None,
            tools: Vec::new(),
            subprograms: Vec::new(),
            remaps: Vec::new(),
        }
    }
}
