//! `trunnion machine`: help with machine files. And machines as arguments of other verbs.

use crate::outcome::Failure;
use crate::text;
use std::path::Path;
use trunnion::files::machine::{MachineFile, built_in, parse};

/// Reads a machine file; where there is no such file, the built-in machine of that name.
pub(crate) fn load(argument: &str) -> Result<MachineFile, Failure> {
    let path = Path::new(argument);
    let text = source(argument)?;
    parse(&text).map_err(|faults| Failure::faults(path, &faults))
}

/// Text of a machine file or built-in machine.
fn source(argument: &str) -> Result<String, Failure> {
    let path = Path::new(argument);
    // A folder of that name is no machine file, but a built-in machine may be meant.
    if path.is_file() || (path.exists() && built_in(argument).is_err()) {
        return text::read(path);
    }
    built_in(argument).map(str::to_owned).map_err(|nearest| {
        let help = match nearest {
            Some(name) => format!("did you mean the built-in machine `{name}`?"),
            None => "`trunnion machine list` names the built-in ones".to_owned(),
        };
        Failure::input(format!(
            "{argument}: no machine file, and no built-in machine of that name\n  help: {help}"
        ))
    })
}
