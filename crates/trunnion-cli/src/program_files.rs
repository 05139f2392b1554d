//! Files that a program depends on: the control's tool table and configuration.

use crate::outcome::Failure;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion::nc::read::{IniFile, ReadOptions, ini_file, tool_rows};

/// Files of the control.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct ProgramFileArgs {
    /// Tool table of the control (.tbl), in the unit of --ini or mm: for cutter compensation and for tool offsets that the
    /// program writes (G10 L1).
    #[arg(long, value_name = "TBL")]
    tool_table: Option<PathBuf>,
    /// Configuration of the control (.ini): its values (#<_ini[section]name>), unit and tool table.
    #[arg(long, value_name = "INI")]
    ini: Option<PathBuf>,
}

impl ProgramFileArgs {
    /// Puts what the files say into the options of a reader.
    pub(crate) fn fill(&self, options: &mut ReadOptions) -> Result<(), Failure> {
        let ini = match &self.ini {
            Some(path) => ini_file(&text_of(path)?),
            None => IniFile { unit: 1.0, ..IniFile::default() },
        };
        // Values of the command line go first.
        let given = |name: &str| options.parameters.iter().any(|(known, _)| known == name);
        let more: Vec<_> = ini.parameters.into_iter().filter(|(name, _)| !given(name)).collect();
        options.parameters.extend(more);
        let beside = self.ini.as_deref().and_then(Path::parent);
        let of_ini = ini.tool_table.zip(beside).map(|(name, folder)| folder.join(name));
        // A table that the configuration merely names may be absent here.
        let table = self.tool_table.clone().or(of_ini.filter(|path| path.is_file()));
        if let Some(path) = table {
            let rows = tool_rows(&text_of(&path)?, ini.unit);
            options.tools = rows.map_err(|faults| Failure::faults(&path, &faults))?;
        }
        Ok(())
    }
}

fn text_of(path: &Path) -> Result<String, Failure> {
    let bytes =
        fs::read(path).map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
