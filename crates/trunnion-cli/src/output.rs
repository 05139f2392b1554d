//! Files are written whole or not at all: under a temporary name in the same folder, then renamed.

use crate::outcome::Failure;
use anyhow::{Context, Result};
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes one file, by `fill`, whole or not at all.
pub(crate) fn file(
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
) -> std::result::Result<(), Failure> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name
        .filter(|_| !path.is_dir())
        .ok_or_else(|| Failure::input(format!("{}: not a file", path.display())))?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut outputs = Outputs::open(folder.unwrap_or(Path::new(".")))?;
    outputs.add(&name, fill)?;
    outputs.commit()?;
    Ok(())
}

/// Output files of one run, none of which is visible before [`Outputs::commit`].
#[derive(Debug)]
pub(crate) struct Outputs {
    folder: PathBuf,
    created: bool,
    /// Complete files under their temporary names, with their final paths.
    staged: Vec<(NamedTempFile, PathBuf)>,
}

impl Outputs {
    /// Opens `folder`, making it if it is missing.
    pub(crate) fn open(folder: &Path) -> std::result::Result<Self, Failure> {
        let created = !folder.exists();
        fs::create_dir_all(folder).map_err(|error| unusable(folder, &error))?;
        Ok(Self { folder: folder.to_owned(), created, staged: Vec::new() })
    }

    /// Checks before long work that `folder` is writable, or can be made.
    ///
    /// # Errors
    ///
    /// [`Failure::Input`] if it is not.
    pub(crate) fn probe(folder: &Path) -> std::result::Result<(), Failure> {
        // The nearest folder that exists decides: the others are made below it.
        let missing = |place: &&Path| !place.as_os_str().is_empty() && !place.exists();
        let standing = folder.ancestors().find(|place| !missing(place)).unwrap_or(folder);
        let standing = if standing.as_os_str().is_empty() { Path::new(".") } else { standing };
        let probe = NamedTempFile::new_in(standing).map_err(|error| unusable(folder, &error))?;
        probe.close().map_err(|error| unusable(folder, &error))
    }

    /// Stages one file, written by `fill`.
    pub(crate) fn add(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
    ) -> Result<()> {
        let place = self.folder.join(name);
        let context = || format!("writing {}", place.display());
        // In the same folder, because a rename is atomic on one file system only.
        let file = NamedTempFile::new_in(&self.folder).with_context(context)?;
        let mut writer = BufWriter::new(file);
        fill(&mut writer).with_context(context)?;
        let file = writer.into_inner().map_err(std::io::IntoInnerError::into_error);
        self.staged.push((file.with_context(context)?, place));
        Ok(())
    }

    /// Stages a text file.
    pub(crate) fn text(&mut self, name: &str, text: &str) -> Result<()> {
        self.add(name, |out| out.write_all(text.as_bytes()))
    }

    /// Moves every staged file to its place; returns their paths.
    pub(crate) fn commit(mut self) -> Result<Vec<PathBuf>> {
        let mut places = Vec::new();
        // All are complete here; only a full disk or a changed folder can stop a rename.
        for (file, place) in self.staged.drain(..) {
            readable(file.as_file())?;
            file.persist(&place).with_context(|| format!("writing {}", place.display()))?;
            places.push(place);
        }
        self.created = false;
        Ok(places)
    }
}

fn unusable(folder: &Path, error: &std::io::Error) -> Failure {
    let why = match folder.ancestors().find(|place| place.is_file()) {
        Some(file) => format!("{} is a file", file.display()),
        // The name of a temporary file means nothing to the user.
        None => error.kind().to_string(),
    };
    let folder = folder.display();
    Failure::input(format!(
        "{folder}: no outputs can be written there: {why}\n  help: name another folder with -o"
    ))
}

impl Drop for Outputs {
    /// Removes a folder that was made for files that were never written.
    fn drop(&mut self) {
        self.staged.clear();
        if self.created {
            let _ = fs::remove_dir(&self.folder);
        }
    }
}

/// Temporary files are private to their owner; outputs are ordinary files.
#[cfg(unix)]
fn readable(file: &fs::File) -> Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(fs::Permissions::from_mode(0o644)).context("setting permissions")
}

#[cfg(not(unix))]
fn readable(_: &fs::File) -> Result<()> {
    Ok(())
}
