//! End of a verb: exit codes and messages.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trunnion::nc::read::ReadRemedy;
use trunnion::types::Diagnostic;

/// Result of a verb that ran to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Done {
    /// Everything asked for was done and holds.
    Kept,
    /// Done, but the result breaks a tolerance or a limit.
    Broken,
    /// The input was checked and is faulty; everything is reported.
    Refused,
}

/// Failure of a verb; no output was written except those that the message names.
#[derive(Debug)]
pub enum Failure {
    /// The input cannot be used: one or several messages, each complete in itself.
    Input(Vec<String>),
    /// The work could not be finished. What was done by then is kept in these files.
    Unfinished {
        /// Reasons, each complete in itself.
        messages: Vec<String>,
        /// Files that were written.
        kept: Vec<PathBuf>,
    },
    /// The user stopped it.
    Stopped,
    /// Something failed that is not the user's fault.
    Internal(anyhow::Error),
}

impl Failure {
    /// Returns a single message about the input.
    pub(crate) fn input(message: impl fmt::Display) -> Self {
        Self::Input(vec![message.to_string()])
    }

    /// Returns the failure for a defect of trunnion itself.
    pub fn defect(message: &'static str) -> Self {
        Self::Internal(anyhow::Error::msg(message))
    }

    /// Returns all messages of the failure.
    pub fn messages(&self) -> Vec<String> {
        match self {
            Self::Input(messages) | Self::Unfinished { messages, .. } => messages.clone(),
            Self::Stopped => vec!["stopped on request".to_owned()],
            Self::Internal(error) => vec![format!("internal error: {error:#}")],
        }
    }

    /// Returns messages about a file: `path:line:column: message`, then the remedy.
    pub(crate) fn faults(path: &Path, faults: &[Diagnostic]) -> Self {
        let messages = faults.iter().map(|fault| format!("{}:{fault}", path.display())).collect();
        Self::Input(messages)
    }

    /// Returns messages about a program, with the flags of this command line as remedies.
    pub(crate) fn program_faults(path: &Path, faults: &[Diagnostic]) -> Self {
        let with_flags = |fault: &Diagnostic| {
            match ReadRemedy::of(fault) {
            Some(ReadRemedy::DecideBlockDelete) => fault
                .clone()
                .with_help("state whether such blocks are run: --block-delete true, or false"),
            Some(ReadRemedy::GiveTools) => {
                fault.clone().with_help("give the control's tool table: --tool-table FILE")
            }
            Some(ReadRemedy::DeclarePassive) => fault.clone().with_help(
                "it may move the machine: leave it out, or state that it moves nothing: --passive CODE",
            ),
            _ => fault.clone(),
        }
        };
        Self::faults(path, &faults.iter().map(with_flags).collect::<Vec<_>>())
    }
}

impl Failure {
    /// Joins two failures: the messages of both if both concern the input, else the graver failure.
    pub(crate) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Input(mut first), Self::Input(second)) => {
                first.extend(second);
                Self::Input(first)
            }
            (Self::Input(_), graver) | (graver, _) => graver,
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Internal(error)
    }
}

/// Exit code of a failure, as the process returns it: 1 a part was done, 2 bad input, 3 internal, 130 stopped.
pub fn exit_code(failure: &Failure) -> u8 {
    match failure {
        // Scripts distinguish a result that breaks a tolerance (1) from input that gave none (2).
        Failure::Unfinished { .. } => 1,
        Failure::Input(_) => 2,
        Failure::Internal(_) => 3,
        // 128 + SIGINT, as shells report it.
        Failure::Stopped => 130,
    }
}

/// Returns the exit code of a verb; failures are reported on stderr first.
pub(crate) fn exit(result: Result<Done, Failure>) -> ExitCode {
    let failure = match result {
        Ok(Done::Kept) => return ExitCode::SUCCESS,
        Ok(Done::Broken) => return ExitCode::from(1),
        Ok(Done::Refused) => return ExitCode::from(2),
        Err(failure) => failure,
    };
    match &failure {
        Failure::Input(messages) => {
            for message in messages {
                eprintln!("error: {message}");
            }
            eprintln!("nothing was written");
        }
        Failure::Unfinished { messages, kept } => {
            for message in messages {
                eprintln!("error: {message}");
            }
            for file in kept {
                eprintln!("wrote {}", file.display());
            }
        }
        Failure::Stopped => eprintln!("stopped on request; nothing was written"),
        Failure::Internal(error) => eprintln!("internal error: {error:#}"),
    }
    ExitCode::from(exit_code(&failure))
}
