//! The program of the desktop for files and addresses.

use crate::outcome::Failure;
use std::process::Command;

/// Opens a file or address with the application that the user has chosen for it.
///
/// # Errors
///
/// [`Failure::Input`] if the program of the desktop cannot be started.
pub(crate) fn open(what: &str) -> Result<(), Failure> {
    // Each desktop has one program that opens a file with the default application.
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    match Command::new(opener).arg(what).status() {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::input(format!(
            "cannot start {opener} ({error})\n  help: open {what} in a browser"
        ))),
    }
}
