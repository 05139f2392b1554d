//! Programs, CL files and the setup sheet as text.
//!
//! [`ProgramWriter`] writes blocks one by one in any [`OutputFormat`], [`program`] all of them; see [`nc`](super) for what
//! X Y Z mean in each. Positions are rounded to nearest; [`rounding`] bounds what that does at the tool. Feeds are
//! rounded down, so that a block takes no less time than planned; feeds of the tip up to a whole number of mm/min where a
//! last digit is missing.

mod apt;
mod error;
mod error_bound;
mod feed_word;
mod format;
mod head;
mod note;
mod number;
mod position;
mod program;
mod sheet;
mod style;
mod template;
mod whole;
mod words_of;

pub use super::words::{AxisWord, AxisWords, Coolant, WordsError};
pub use apt::{LegSection, apt};
pub use error::WriteError;
pub use error_bound::{Coordinates, rounding};
pub use feed_word::BRIEFEST_BLOCK;
pub use format::{OUTPUT_FORMATS, OutputFormat};
pub use note::{Note, Remark, ToolNote};
pub use position::WrittenPosition;
pub use program::{BlockPace, ProgramForm, ProgramWriter};
pub use sheet::{SheetProgram, SheetPrograms, SheetTool, program_sheet, setup_sheet, work_offset};
pub use style::Style;
pub use template::{Template, TemplateError};
pub use whole::{ToolSection, pace, program, sections};
pub use words_of::PlaceWords;
