//! Files that verbs read and write: those of the disk, or of memory where there is no disk, as in a page.
//!
//! Memory replaces the disk as a whole while [`in_memory`] runs, on the thread that runs it. Verbs read and write on
//! the thread that calls them, so that they need no word about it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Cursor, Error, ErrorKind, Result};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Bytes read at a time.
const BUFFER: usize = 1 << 16;

thread_local! {
    static MEMORY: RefCell<Option<MemoryFiles>> = const { RefCell::new(None) };
}

/// Files by name, in place of a disk. Names may have folders: `../part.step` beside `jobs/job.toml` is `part.step`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MemoryFiles(BTreeMap<PathBuf, Arc<[u8]>>);

impl MemoryFiles {
    /// Adds a file, or replaces the one of that name.
    pub fn insert(&mut self, name: impl AsRef<Path>, bytes: impl Into<Arc<[u8]>>) {
        self.0.insert(plain(name.as_ref()), bytes.into());
    }

    /// Takes a file away.
    pub fn remove(&mut self, name: impl AsRef<Path>) {
        self.0.remove(&plain(name.as_ref()));
    }

    /// Returns the bytes of a file.
    pub fn get(&self, name: impl AsRef<Path>) -> Option<&[u8]> {
        self.0.get(&plain(name.as_ref())).map(AsRef::as_ref)
    }

    /// Returns the files below a folder: their names within it, and their bytes.
    pub fn below(&self, folder: impl AsRef<Path>) -> impl Iterator<Item = (&Path, &[u8])> {
        let folder = plain(folder.as_ref());
        self.0.iter().filter_map(move |(name, bytes)| {
            Some((name.strip_prefix(&folder).ok()?, bytes.as_ref()))
        })
    }

    /// Takes all files below a folder away.
    pub fn clear_below(&mut self, folder: impl AsRef<Path>) {
        let folder = plain(folder.as_ref());
        self.0.retain(|name, _| !name.starts_with(&folder));
    }

    fn is_folder(&self, path: &Path) -> bool {
        let path = plain(path);
        path.as_os_str().is_empty()
            || self.0.keys().any(|name| *name != path && name.starts_with(&path))
    }
}

/// Returns a path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::Normal(name) => plain.push(name),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    plain
}

/// Runs `work` with `files` in place of the disk; files that it writes are added to them.
pub fn in_memory<T>(files: &mut MemoryFiles, work: impl FnOnce() -> T) -> T {
    /// Brings the disk back, also where the work panics.
    struct Back<'a>(&'a mut MemoryFiles);
    impl Drop for Back<'_> {
        fn drop(&mut self) {
            *self.0 = MEMORY.take().unwrap_or_default();
        }
    }
    MEMORY.set(Some(std::mem::take(files)));
    let back = Back(files);
    let done = work();
    drop(back);
    done
}

/// Returns an answer about the files in memory; `None` while the disk is used.
fn memory<T>(ask: impl FnOnce(&MemoryFiles) -> T) -> Option<T> {
    MEMORY.with_borrow(|files| files.as_ref().map(ask))
}

/// Returns true while files are those of memory.
pub(crate) fn is_memory() -> bool {
    memory(|_| ()).is_some()
}

/// Writes a file to memory.
pub(crate) fn keep(path: &Path, bytes: Vec<u8>) {
    MEMORY.with_borrow_mut(|files| {
        if let Some(files) = files {
            files.insert(path, bytes);
        }
    });
}

/// Returns true if there is a file of that name.
pub(crate) fn is_file(path: &Path) -> bool {
    memory(|files| files.get(path).is_some()).unwrap_or_else(|| path.is_file())
}

/// Returns true if there is a file or folder of that name.
pub(crate) fn exists(path: &Path) -> bool {
    memory(|files| files.get(path).is_some() || files.is_folder(path))
        .unwrap_or_else(|| path.exists())
}

/// Returns the size of a file \[bytes\], if it is known beforehand.
pub(crate) fn size(path: &Path) -> Option<u64> {
    let found = memory(|files| files.get(path).map(|bytes| bytes.len() as u64));
    found.unwrap_or_else(|| std::fs::metadata(path).ok().map(|data| data.len()))
}

/// Opens a file for reading.
///
/// # Errors
///
/// That of the disk; [`ErrorKind::IsADirectory`] for a folder.
pub(crate) fn open(path: &Path) -> Result<Box<dyn BufRead>> {
    let found = memory(|files| {
        let shared = files.0.get(&plain(path)).cloned();
        shared.ok_or_else(|| {
            let kind =
                if files.is_folder(path) { ErrorKind::IsADirectory } else { ErrorKind::NotFound };
            Error::from(kind)
        })
    });
    if let Some(found) = found {
        return Ok(Box::new(Cursor::new(found?)));
    }
    let file = std::fs::File::open(path)?;
    // Some systems open a folder, and refuse only the reading.
    if file.metadata().is_ok_and(|data| data.is_dir()) {
        return Err(ErrorKind::IsADirectory.into());
    }
    Ok(Box::new(BufReader::with_capacity(BUFFER, file)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn memory_stands_for_the_disk_while_work_runs() {
        let mut files = MemoryFiles::default();
        files.insert("fixtures/patch.json", *b"{}");
        files.insert("jobs/one/job.toml", *b"name");
        let text = in_memory(&mut files, || {
            assert!(exists(Path::new("jobs/one")) && !is_file(Path::new("jobs/one")));
            assert!(!exists(Path::new("Cargo.toml")), "the disk must not show through");
            let gone = open(Path::new("jobs/two.toml")).err().map(|error| error.kind());
            assert_eq!(gone, Some(ErrorKind::NotFound));
            let folder = open(Path::new("jobs")).err().map(|error| error.kind());
            assert_eq!(folder, Some(ErrorKind::IsADirectory));
            keep(Path::new("out/a.txt"), b"made".to_vec());
            let mut text = String::new();
            let mut file = open(Path::new("jobs/one/../../fixtures/./patch.json")).unwrap();
            file.read_to_string(&mut text).unwrap();
            text
        });
        assert_eq!(text, "{}");
        assert!(!is_memory());
        let made: Vec<_> = files.below("out").collect();
        assert_eq!(made, [(Path::new("a.txt"), &b"made"[..])]);
        files.clear_below("out");
        assert_eq!(files.below("").count(), 2);
    }
}
