//! Files are written whole or not at all: under a temporary name in the same folder, then renamed.
//! Links lead to what they name; devices, pipes and sockets receive the finished text.

use crate::disk;
use crate::outcome::Failure;
use anyhow::{Context, Result};
use std::fs;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes one file, by `fill`, whole or not at all.
pub(crate) fn file(
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
) -> std::result::Result<(), Failure> {
    let (mut outputs, name) = Outputs::beside(path)?;
    outputs.add(&name, fill)?;
    outputs.commit()?;
    Ok(())
}

/// Writes one file whole or not at all, by a function that may refuse on the way.
pub(crate) fn file_checked<T>(
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> std::result::Result<T, Failure>,
) -> std::result::Result<T, Failure> {
    let (mut outputs, name) = Outputs::beside(path)?;
    let filled = outputs.add_checked(&name, fill)?;
    outputs.commit()?;
    Ok(filled)
}

/// Refuses an output that is one of the inputs: it would be overwritten by its own result.
pub(crate) fn protect(output: &Path, inputs: &[&Path]) -> std::result::Result<(), Failure> {
    let Ok(real) = output.canonicalize() else { return Ok(()) };
    let same = |input: &&Path| input.canonicalize().is_ok_and(|input| input == real);
    if real.is_file() && inputs.iter().any(same) {
        let output = output.display();
        return Err(Failure::input(format!(
            "{output}: the output file is also an input, and would be overwritten\n  help: name another file with -o"
        )));
    }
    Ok(())
}

/// Refuses an output that exists: people go on working in such files, so that none is ever replaced.
pub(crate) fn refuse_existing(path: &Path) -> std::result::Result<(), Failure> {
    if !path.exists() {
        return Ok(());
    }
    let help = "choose another name, or remove the file";
    Err(Failure::input(format!(
        "{}: the file exists already, and may hold your work\n  help: {help}",
        path.display()
    )))
}

/// Returns true if an output is, or becomes, a regular file; a device, pipe or socket has no files beside it.
pub(crate) fn is_regular(path: &Path) -> bool {
    matches!(Destination::of(path), Ok(Destination::File(_)))
}

/// Longest chain of links that is followed, as the kernel does.
const MOST_LINKS: usize = 40;

/// Place that an output's name stands for.
#[derive(Debug)]
enum Destination {
    /// A regular file, which need not exist yet.
    File(PathBuf),
    /// A device, pipe or socket.
    Stream(PathBuf),
}

impl Destination {
    fn of(path: &Path) -> std::io::Result<Self> {
        // Names of open files, such as /dev/stdout, are streams whatever they lead to.
        if path.starts_with("/dev") || path.starts_with("/proc") {
            return Ok(Self::Stream(path.to_owned()));
        }
        let mut path = path.to_owned();
        for _ in 0..MOST_LINKS {
            match fs::symlink_metadata(&path) {
                Ok(found) if found.is_symlink() => {
                    let target = fs::read_link(&path)?;
                    // Relative links count from the folder of the link.
                    path = path.parent().unwrap_or(Path::new("")).join(target);
                }
                Ok(found) if found.is_file() => return Ok(Self::File(path)),
                Ok(found) if found.is_dir() => return Err(std::io::ErrorKind::IsADirectory.into()),
                Ok(_) => return Ok(Self::Stream(path)),
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                    return Ok(Self::File(path));
                }
                Err(error) => return Err(error),
            }
        }
        Err(std::io::Error::other("too many symbolic links in a row"))
    }

    /// Makes the temporary file in which the output waits.
    fn stage(&self) -> std::io::Result<NamedTempFile> {
        match self {
            // In the same folder, because a rename is atomic on one file system only.
            Self::File(path) => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
                NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))
            }
            Self::Stream(_) => NamedTempFile::new(),
        }
    }

    /// Moves a finished file to its place, or sends its content there.
    fn receive(&self, mut file: NamedTempFile) -> Result<()> {
        match self {
            Self::File(path) => {
                readable(file.as_file())?;
                file.persist(path)?;
            }
            Self::Stream(path) => {
                file.as_file_mut().rewind()?;
                match std::io::copy(file.as_file_mut(), &mut stream(path)?) {
                    // A reader that has seen enough closes its pipe.
                    Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                        return Err(error.into());
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }
}

/// Opens a device, pipe or socket for writing.
#[cfg(unix)]
fn stream(path: &Path) -> std::io::Result<Box<dyn Write>> {
    use std::os::unix::fs::FileTypeExt;
    if fs::metadata(path)?.file_type().is_socket() {
        return Ok(Box::new(std::os::unix::net::UnixStream::connect(path)?));
    }
    Ok(Box::new(fs::OpenOptions::new().write(true).open(path)?))
}

#[cfg(not(unix))]
fn stream(path: &Path) -> std::io::Result<Box<dyn Write>> {
    Ok(Box::new(fs::OpenOptions::new().write(true).open(path)?))
}

/// Output files of one run, none of which is visible before [`Outputs::commit`].
#[derive(Debug)]
pub(crate) struct Outputs {
    folder: PathBuf,
    created: bool,
    staged: Vec<Staged>,
}

/// Complete file that waits for its name.
#[derive(Debug)]
enum Staged {
    /// Under a temporary name, with its name and what this stands for.
    Disk(NamedTempFile, PathBuf, Destination),
    Memory(Vec<u8>, PathBuf),
}

impl Outputs {
    /// Opens `folder`, making it if it is missing.
    pub(crate) fn open(folder: &Path) -> std::result::Result<Self, Failure> {
        if disk::is_memory() {
            return Ok(Self { folder: folder.to_owned(), created: false, staged: Vec::new() });
        }
        let created = !folder.exists();
        fs::create_dir_all(folder).map_err(|error| unusable(folder, &error))?;
        Ok(Self { folder: folder.to_owned(), created, staged: Vec::new() })
    }

    /// Opens the folder of a file; returns the name of the file as well.
    pub(crate) fn beside(path: &Path) -> std::result::Result<(Self, String), Failure> {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = name
            .filter(|_| !path.is_dir())
            .ok_or_else(|| Failure::input(format!("{}: not a file", path.display())))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        Ok((Self::open(folder.unwrap_or(Path::new(".")))?, name))
    }

    /// Checks before long work that `folder` is writable, or can be made.
    ///
    /// # Errors
    ///
    /// [`Failure::Input`] if it is not.
    pub(crate) fn probe(folder: &Path) -> std::result::Result<(), Failure> {
        if disk::is_memory() {
            return Ok(());
        }
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
        if disk::is_memory() {
            let mut bytes = Vec::new();
            fill(&mut bytes).with_context(context)?;
            self.staged.push(Staged::Memory(bytes, place));
            return Ok(());
        }
        let destination = Destination::of(&place).with_context(context)?;
        let file = destination.stage().with_context(context)?;
        let mut writer = BufWriter::new(file);
        fill(&mut writer).with_context(context)?;
        let file = writer.into_inner().map_err(std::io::IntoInnerError::into_error);
        self.staged.push(Staged::Disk(file.with_context(context)?, place, destination));
        Ok(())
    }

    /// Stages one file, written by a function that may refuse on the way.
    pub(crate) fn add_checked<T>(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut (dyn Write + Send)) -> std::result::Result<T, Failure>,
    ) -> std::result::Result<T, Failure> {
        // `add` only knows I/O errors: the refusal itself is kept beside it.
        let mut outcome = None;
        let written = self.add(name, |out| {
            let filled = outcome.insert(fill(out));
            filled.as_ref().map(drop).map_err(|_| std::io::Error::other("refused"))
        });
        match outcome {
            Some(Ok(filled)) => Ok(written.map(|()| filled)?),
            Some(Err(refused)) => Err(refused),
            None => Err(written
                .err()
                .map_or_else(|| Failure::input("nothing was written"), Failure::from)),
        }
    }

    /// Stages a text file.
    pub(crate) fn text(&mut self, name: &str, text: &str) -> Result<()> {
        self.add(name, |out| out.write_all(text.as_bytes()))
    }

    /// Moves every staged file to its place; returns their paths.
    pub(crate) fn commit(mut self) -> Result<Vec<PathBuf>> {
        let mut places = Vec::new();
        // All are complete here; only a full disk or a changed folder can stop a rename.
        for staged in self.staged.drain(..) {
            places.push(match staged {
                Staged::Disk(file, place, destination) => {
                    let context = || format!("writing {}", place.display());
                    destination.receive(file).with_context(context)?;
                    place
                }
                Staged::Memory(bytes, place) => {
                    disk::keep(&place, bytes);
                    place
                }
            });
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
        "{folder}: cannot write outputs into this folder: {why}\n  help: name another folder with -o"
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
