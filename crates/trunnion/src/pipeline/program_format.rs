//! Dialect and file name of a program.

use crate::files::job as file;
use crate::nc::write::Dialect;

/// Dialect of the writer, and file name of the program.
pub(super) struct ProgramFormat {
    pub(super) dialect: Dialect,
    pub(super) file: &'static str,
}

/// Returns the format of a dialect of the job file.
pub(super) fn format_of(dialect: file::Dialect) -> ProgramFormat {
    let (dialect, file) = match dialect {
        file::Dialect::LinuxCnc => (Dialect::LinuxCnc, "program.linuxcnc.ngc"),
        file::Dialect::G93 => (Dialect::G93, "program.g93.nc"),
        file::Dialect::Fanuc => (Dialect::Fanuc, "program.fanuc.nc"),
        file::Dialect::FanucVector => (Dialect::FanucVector, "program.fanuc-vector.nc"),
        file::Dialect::Haas => (Dialect::Haas, "program.haas.nc"),
        file::Dialect::Siemens => (Dialect::Siemens, "program.siemens.mpf"),
        file::Dialect::SiemensAxes => (Dialect::SiemensAxes, "program.siemens-axes.mpf"),
        file::Dialect::Heidenhain => (Dialect::Heidenhain, "program.heidenhain.h"),
        file::Dialect::HeidenhainAxes => (Dialect::HeidenhainAxes, "program.heidenhain-axes.h"),
    };
    ProgramFormat { dialect, file }
}
