//! The binary `trunnion`; everything is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    trunnion_cli::main()
}
