//! `trunnion linuxcnc`: a configuration of `LinuxCNC` for a machine file.

mod args;
mod configuration;
mod hal;
mod ini;
mod notes;
mod run;
mod subroutines;

pub(crate) use args::LinuxcncArgs;
pub(crate) use run::run;
