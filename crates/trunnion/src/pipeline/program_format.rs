//! Dialect and file name of a program.

use crate::nc::write::OutputFormat;

/// Dialect of the writer, and file name of the program.
pub(super) struct ProgramFormat {
    pub(super) dialect: OutputFormat,
    pub(super) file: &'static str,
}

/// Returns the format of a dialect of the job file.
pub(super) fn format_of(dialect: OutputFormat) -> ProgramFormat {
    ProgramFormat { dialect, file: dialect.program_file() }
}
