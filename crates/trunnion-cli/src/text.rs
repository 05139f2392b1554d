//! Output on stdout, and reading of text files.

use crate::disk;
use crate::outcome::{Done, Failure};
use anyhow::Context;
use std::io::{Read, Write};
use std::path::Path;

/// Largest text file that is read at once \[bytes\]; a guard against a device or a wrong file.
const LARGEST: u64 = 1 << 30;

/// Prints to stdout; a closed pipe is not an error.
pub(crate) fn print(text: &str) -> Result<Done, Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("writing to stdout").into())
        }
        _ => Ok(Done::Kept),
    }
}

/// Prints a value as JSON.
pub(crate) fn print_json(value: &impl serde::Serialize) -> Result<Done, Failure> {
    let text = serde_json::to_string_pretty(value).context("writing JSON")?;
    print(&(text + "\n"))
}

/// States why a file cannot be read, and what helps.
pub(crate) fn unreadable(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            "there is no such file\n  help: check the name; in a job file paths count from the folder of the job file, on the command line from the \
             folder in which the command runs"
                .to_owned()
        }
        std::io::ErrorKind::IsADirectory => "is a folder; a file is expected".to_owned(),
        _ => error.to_string(),
    }
}

/// Reads a file whole.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    bytes(path).map_err(|what| Failure::input(format!("{}: {what}", path.display())))
}

/// Reads a whole file, or reports the error.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    if let Some(size) = disk::size(path).filter(|size| *size > LARGEST) {
        return Err(format!("has {size} bytes; at most {LARGEST} are read"));
    }
    // A device or a pipe has no size beforehand.
    let mut bytes = Vec::new();
    disk::open(path)
        .and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes))
        .map_err(|error| unreadable(&error))?;
    if bytes.len() as u64 > LARGEST {
        return Err(format!("does not end; at most {LARGEST} bytes are read"));
    }
    Ok(bytes)
}

/// Reads a program whole. Its comments may be in any character set.
pub(crate) fn program(path: &Path) -> Result<String, Failure> {
    // Older controls write comments in Latin-1: the letters are lost, the words are not.
    let text =
        |error: std::string::FromUtf8Error| String::from_utf8_lossy(error.as_bytes()).into_owned();
    Ok(String::from_utf8(read_bytes(path)?).unwrap_or_else(text))
}

/// Reads a text file whole.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::input(format!("{}: not a text file (byte {at} is not UTF-8)", path.display()))
    })
}
