//! The files of the page: packed into the binary, or in a folder.

use crate::outcome::Failure;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Names and bytes of the built site; empty without the feature `studio`.
const PACKED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/site.rs"));

/// Source of the page.
#[derive(Debug)]
pub(super) enum Site {
    Packed,
    Folder(PathBuf),
}

impl Site {
    /// Finds the page in a folder, or in the binary.
    pub(super) fn find(folder: Option<&Path>) -> Result<Self, Failure> {
        let help = "build the site (just studio), and name it: --site studio/dist";
        match folder {
            Some(folder) if folder.join("index.html").is_file() => Ok(Self::Folder(folder.into())),
            Some(folder) => {
                let folder = folder.display();
                Err(Failure::input(format!("{folder}: there is no built site\n  help: {help}")))
            }
            None if PACKED.is_empty() => {
                let why = "this program was built without the site of the studio";
                Err(Failure::input(format!(
                    "{why}\n  help: {help}; or build trunnion with --features studio"
                )))
            }
            None => Ok(Self::Packed),
        }
    }

    /// Returns a file of the page by its name, such as `index.html`.
    pub(super) fn file(&self, name: &str) -> Option<Cow<'static, [u8]>> {
        match self {
            Self::Packed => {
                let found = PACKED.iter().find(|(packed, _)| *packed == name);
                found.map(|(_, bytes)| Cow::Borrowed(*bytes))
            }
            Self::Folder(folder) => {
                // Nothing outside the folder has a name in the page.
                let inside =
                    Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
                let path = folder.join(name);
                (inside && path.is_file())
                    .then(|| std::fs::read(path).ok().map(Cow::Owned))
                    .flatten()
            }
        }
    }
}
