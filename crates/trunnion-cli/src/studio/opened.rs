//! The files that the page opens at its start.

use crate::outcome::Failure;
use crate::{machine, text};
use std::path::{Path, PathBuf};
use trunnion::files::job::{self, JobStock};

/// Files with their names in the page: their paths below the folder that all of them have in common.
#[derive(Debug, Default)]
pub(super) struct OpenedFiles {
    /// Names, in the order of the places.
    pub(super) names: Vec<String>,
    places: Vec<PathBuf>,
}

impl OpenedFiles {
    /// Takes files, and those that jobs among them name.
    pub(super) fn of(files: &[PathBuf]) -> Result<Self, Failure> {
        let mut places = Vec::new();
        for file in files {
            // A name that is wrong is reported here, in the words of other verbs.
            text::bytes(file)
                .map_err(|what| Failure::input(format!("{}: {what}", file.display())))?;
            add(&mut places, file);
            for named in named_by(file) {
                add(&mut places, &named);
            }
        }
        let root = common(&places);
        let name = |place: &PathBuf| {
            let below = place.strip_prefix(&root).unwrap_or(place);
            below.to_string_lossy().replace('\\', "/")
        };
        Ok(Self { names: places.iter().map(name).collect(), places })
    }

    /// Returns the bytes of a file by its place in the list.
    pub(super) fn bytes(&self, at: usize) -> Option<Vec<u8>> {
        text::bytes(self.places.get(at)?).ok()
    }
}

/// Adds a file that exists, once.
fn add(places: &mut Vec<PathBuf>, file: &Path) {
    if let Ok(place) = file.canonicalize()
        && !places.contains(&place)
    {
        places.push(place);
    }
}

/// Returns the files that a job names. A faulty job names none: the page shows its faults.
fn named_by(path: &Path) -> Vec<PathBuf> {
    let is_toml = path.extension().is_some_and(|name| name.eq_ignore_ascii_case("toml"));
    let Some(job) = is_toml.then(|| job::parse(&text::read(path).ok()?).ok()).flatten() else {
        return Vec::new();
    };
    let stock = job.stock.as_ref().and_then(JobStock::solid);
    let fixtures = job.fixtures.iter().map(|fixture| &fixture.solid);
    let solids = stock.into_iter().chain(fixtures).filter_map(|solid| solid.file());
    let beside = |name: &str| path.parent().unwrap_or(Path::new("")).join(name);
    let machine = Some(job.machine.as_str()).filter(|name| !machine::is_built_in(path, name));
    let files = std::iter::once(job.part.file.as_str()).chain(machine).chain(solids);
    files.map(beside).collect()
}

/// Returns the deepest folder that has all of the files below it.
fn common(places: &[PathBuf]) -> PathBuf {
    let mut folders = places.iter().filter_map(|place| place.parent());
    let Some(first) = folders.next() else { return PathBuf::new() };
    let mut root = first.to_owned();
    for folder in folders {
        while !folder.starts_with(&root) && root.pop() {}
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_their_common_folder() {
        let places = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(common(&places(&["/a/b/job.toml"])), Path::new("/a/b"));
        assert_eq!(common(&places(&["/a/b/job.toml", "/a/c/part.step"])), Path::new("/a"));
        assert_eq!(common(&places(&["/a/b/job.toml", "/a/bc/part.step"])), Path::new("/a"));
        assert_eq!(common(&[]), Path::new(""));
    }
}
