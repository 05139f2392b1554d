//! Files that a program depends on: the control's tool table and configuration, subprograms beside it.

use crate::disk;
use crate::outcome::Failure;
use crate::path::lines::{self, Lines};
use crate::text;
use anyhow::Context;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion::nc::read::{
    CodeRemap, Dialect, ReadOptions, SubprogramFile, ini_file, subprogram_calls, tool_rows,
};

/// True for characters one of which every call of a subprogram has: `o<name> call`, `M98 P100`. A table, since every byte of
/// a program is looked at.
const CALLS: [bool; 256] = {
    let mut calls = [false; 256];
    let (marks, mut at) = (b":OoMm", 0);
    while at < marks.len() {
        calls[marks[at] as usize] = true;
        at += 1;
    }
    calls
};

/// Files of the control.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct ProgramFileArgs {
    /// Tool table of the control (.tbl), in the unit of --ini or mm: for cutter compensation and for tool offsets that the
    /// program writes (G10 L1).
    #[arg(long, value_name = "TBL")]
    tool_table: Option<PathBuf>,
    /// Configuration of the control (.ini): its values (`#<_ini[section]name>`), unit, tool table, and the codes that it
    /// remaps to subprograms.
    #[arg(long, value_name = "INI")]
    ini: Option<PathBuf>,
    /// Folder with files of subprograms, searched after the folders of the program and of --ini. May be repeated.
    #[arg(long, value_name = "FOLDER")]
    sub_dir: Vec<PathBuf>,
    /// Code of this machine that causes no motion, such as M400, CYCLE999 or "CYCL DEF 239"; it is kept and not run. May be repeated.
    #[arg(long, value_name = "CODE")]
    passive: Vec<String>,
}

impl ProgramFileArgs {
    /// Puts what the files say into the options of a reader.
    pub(crate) fn fill(&self, options: &mut ReadOptions, program: &Path) -> Result<(), Failure> {
        options.passive.clone_from(&self.passive);
        let ini = match &self.ini {
            Some(path) => ini_file(&text_of(path)?),
            None => ini_file(""),
        };
        // Values of the command line go first.
        let given = |name: &str| options.parameters.iter().any(|(known, _)| known == name);
        let more: Vec<_> = ini.parameters.into_iter().filter(|(name, _)| !given(name)).collect();
        options.parameters.extend(more);
        if options.dialect == Dialect::LinuxCnc {
            options.remaps = ini.remaps;
            options.subprograms = self.subprograms(program, &ini.folders, &options.remaps)?;
        }
        let beside = self.ini.as_deref().and_then(Path::parent);
        let of_ini = ini.tool_table.zip(beside).map(|(name, folder)| folder.join(name));
        // A table that the configuration merely names may be absent here.
        let table = self.tool_table.clone().or(of_ini.filter(|path| disk::is_file(path)));
        if let Some(path) = table {
            let rows = tool_rows(&text_of(&path)?, ini.unit);
            options.tools = rows.map_err(|faults| Failure::faults(&path, &faults))?;
        }
        Ok(())
    }

    /// Returns the files of the subprograms that a program in the dialect of `LinuxCNC` runs.
    pub(crate) fn called(&self, program: &Path) -> Result<Vec<SubprogramFile>, Failure> {
        let ini = match &self.ini {
            Some(path) => ini_file(&text_of(path)?),
            None => ini_file(""),
        };
        self.subprograms(program, &ini.folders, &ini.remaps)
    }

    /// Returns the files of the subprograms that a program calls, and that these call.
    fn subprograms(
        &self,
        program: &Path,
        of_ini: &[String],
        remaps: &[CodeRemap],
    ) -> Result<Vec<SubprogramFile>, Failure> {
        let mut folders: Vec<PathBuf> =
            program.parent().map(Path::to_path_buf).into_iter().collect();
        let beside = self.ini.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        folders.extend(of_ini.iter().map(|folder| beside.join(folder)));
        folders.extend(self.sub_dir.iter().cloned());
        // A device or pipe can be read once only, so it is not searched for calls.
        if !disk::is_file(program) {
            return Ok(Vec::new());
        }
        let file = disk::open(program).with_context(|| program.display().to_string())?;
        let mut lines = Lines::new(file);
        // A file that cannot be read ends the search; the reader reports it.
        let calls = std::iter::from_fn(|| {
            while let Some(raw) = lines.next().ok()? {
                if raw.iter().any(|byte| CALLS[usize::from(*byte)]) {
                    return Some(lines::text(raw).into_owned());
                }
            }
            None
        });
        let mut names: Vec<String> = subprogram_calls(calls).into_iter().collect();
        let remapped = remaps.iter().filter_map(|remap| remap.subprogram.as_ref());
        names.extend(remapped.map(|name| name.to_ascii_lowercase()));
        let mut files: BTreeMap<String, SubprogramFile> = BTreeMap::new();
        while let Some(name) = names.pop() {
            // The control asks its file system for a name in lower case.
            let path = folders.iter().map(|folder| folder.join(format!("{name}.ngc")));
            let found = path.into_iter().find(|path| disk::is_file(path));
            if let Some(path) = found.filter(|_| !files.contains_key(&name)) {
                let text = text_of(&path)?;
                names.extend(subprogram_calls(text.lines()));
                files.insert(name.clone(), SubprogramFile { name, text });
            }
        }
        Ok(files.into_values().collect())
    }
}

fn text_of(path: &Path) -> Result<String, Failure> {
    Ok(String::from_utf8_lossy(&text::read_bytes(path)?).into_owned())
}
