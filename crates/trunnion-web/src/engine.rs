//! Files in memory, and the verbs that work on them.

use crate::answer::{PageAnswer, Verdict};
use crate::library_model::LibraryModel;
use crate::machine_model::MachineModel;
use crate::part_model::PartModel;
use crate::stock_model::StockModel;
use crate::timeline::Timeline;
use std::path::Path;
use trunnion::files::library;
use trunnion::math;
use trunnion::types::{Progress, Silent};
use trunnion_cli::Failure;
use trunnion_cli::calls::{self, MemoryFiles};

/// Folder of the outputs of the last run.
pub const RUN_FOLDER: &str = "out";
/// Folder of the outputs of the last check: a program that a run wrote can be checked, and stays.
pub const CHECK_FOLDER: &str = "checked";

/// Named files, and the verbs that read and write them.
///
/// # Example
///
/// ```
/// use trunnion::types::Silent;
/// use trunnion_web::Engine;
///
/// let mut engine = Engine::default();
/// engine.insert("job.toml", b"schema = 3".to_vec());
/// let answer = engine.run("job.toml", &Silent);
/// assert_eq!(answer.code, 2);
/// assert!(answer.messages[0].starts_with("job.toml:1:"));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Engine {
    files: MemoryFiles,
}

impl Engine {
    /// Adds a file, or replaces the one of that name. Names may have folders, as `../part.step` in a job.
    pub fn insert(&mut self, name: &str, bytes: Vec<u8>) {
        self.files.insert(name, bytes);
    }

    /// Takes a file away.
    pub fn remove(&mut self, name: &str) {
        self.files.remove(name);
    }

    /// Returns the bytes of a file, of an output as well: `out/summary.json`.
    pub fn file(&self, name: &str) -> Option<&[u8]> {
        self.files.get(name)
    }

    /// Runs a job, as `trunnion run JOB -o out` does.
    pub fn run(&mut self, job: &str, progress: &dyn Progress) -> PageAnswer {
        let path = Path::new(job);
        self.written(RUN_FOLDER, || {
            let loaded = calls::load_job(path, progress)?;
            let answer = calls::run_job(path, &loaded, Some(Path::new(RUN_FOLDER)), progress)?;
            let verdict = Verdict::of(answer.outcome.summary.passed);
            Ok(PageAnswer { warnings: answer.warnings, ..PageAnswer::done(answer.table, verdict) })
        })
    }

    /// Checks a program, as `trunnion check OPTIONS -o checked` does.
    pub fn check(&mut self, options: &[String], progress: &dyn Progress) -> PageAnswer {
        let place = ["--output", CHECK_FOLDER].map(str::to_owned);
        let options = [options, &place].concat();
        self.written(CHECK_FOLDER, || {
            let answer = calls::check(&options, progress)?;
            Ok(PageAnswer::done(answer.table, Verdict::of(answer.passed)))
        })
    }

    /// Reads a job and the files that it names, without planning; the answer has the faults.
    pub fn read_job(&mut self, job: &str) -> PageAnswer {
        let read = || {
            let loaded = calls::load_job(Path::new(job), &Silent)?;
            Ok(PageAnswer { warnings: loaded.warnings, ..PageAnswer::default() })
        };
        let read = calls::in_memory(&mut self.files, read);
        read.unwrap_or_else(|failure: Failure| PageAnswer::refused(&failure))
    }

    /// Proposes a job, as `trunnion init OPTIONS` prints it; the job is the table of the answer.
    pub fn propose(&mut self, options: &[String], progress: &dyn Progress) -> PageAnswer {
        let propose = || {
            let made = calls::propose(options, progress)?;
            let answer = PageAnswer::done(made.job, Verdict::Kept);
            Ok(PageAnswer { warnings: made.warnings, ..answer })
        };
        let proposed = calls::in_memory(&mut self.files, propose);
        proposed.unwrap_or_else(|failure: Failure| PageAnswer::refused(&failure))
    }

    /// Reads a part, turns it about its x, then y, then z by angles in degrees, and draws its faces.
    ///
    /// # Errors
    ///
    /// The messages of the command line.
    pub fn part(&mut self, name: &str, angles: [f64; 3]) -> Result<PartModel, Vec<String>> {
        let read = || calls::part(Path::new(name), &Silent);
        let mut part =
            calls::in_memory(&mut self.files, read).map_err(|failure| failure.messages())?;
        let rotation = math::exact_rotation_of_xyz(angles.map(f64::to_radians).into());
        part.faces = part.faces.into_iter().map(|face| face.turned(&rotation)).collect();
        Ok(PartModel::of(&part))
    }

    /// Runs a program as `trunnion check OPTIONS` would, and returns its moves over time.
    ///
    /// # Errors
    ///
    /// The messages of the command line.
    pub fn timeline(&mut self, options: &[String]) -> Result<Timeline, Vec<String>> {
        let replay = calls::in_memory(&mut self.files, || calls::replay(options, &Silent));
        replay.map(|replay| Timeline::of(&replay)).map_err(|failure| failure.messages())
    }

    /// Prepares the stock of a program, which runs as `trunnion check OPTIONS` would, to be cut in a picture, with rays about
    /// `cell` \[mm\] apart. Returns nothing without stock and part.
    ///
    /// # Errors
    ///
    /// The messages of the command line.
    pub fn stock(
        &mut self,
        options: &[String],
        cell: f64,
    ) -> Result<Option<StockModel>, Vec<String>> {
        let read = || calls::timed_stock(options, cell, &Silent);
        let found = calls::in_memory(&mut self.files, read);
        found.map(|found| found.map(StockModel::of)).map_err(|failure| failure.messages())
    }

    /// Returns the chain of a machine file, or of the built-in machine of that name.
    ///
    /// # Errors
    ///
    /// The messages of the command line.
    pub fn machine(&mut self, name: &str) -> Result<MachineModel, Vec<String>> {
        let read = calls::in_memory(&mut self.files, || calls::machine(name));
        let file = read.map_err(|failure| failure.messages())?;
        Ok(MachineModel::of(&file.machine))
    }

    /// Reads a library; `None` for the standard one.
    ///
    /// # Errors
    ///
    /// The messages of the command line.
    pub fn library(&mut self, name: Option<&str>) -> Result<LibraryModel, Vec<String>> {
        let Some(name) = name else { return Ok(LibraryModel::of(&library::standard())) };
        let read = calls::in_memory(&mut self.files, || calls::library(Path::new(name)));
        read.map(|file| LibraryModel::of(&file)).map_err(|failure| failure.messages())
    }

    /// Runs a verb that writes into `folder`, which is emptied first.
    fn written(
        &mut self,
        folder: &str,
        work: impl FnOnce() -> Result<PageAnswer, Failure>,
    ) -> PageAnswer {
        self.files.clear_below(folder);
        let done = calls::in_memory(&mut self.files, work);
        let mut answer = done.unwrap_or_else(|failure| PageAnswer::refused(&failure));
        let name = |(name, _): (&Path, &[u8])| format!("{folder}/{}", name.display());
        answer.files = self.files.below(folder).map(name).collect();
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_in_a_folder_is_named_as_it_is_open() {
        let mut engine = Engine::default();
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/step-face/part.step");
        engine.insert("parts/face.step", std::fs::read(file).unwrap());
        let answer = engine.propose(&["parts/face.step".to_owned()], &Silent);
        assert_eq!((answer.code, &answer.messages[..]), (0, &[][..]));
        engine.insert("job.toml", answer.table.into_bytes());
        assert_eq!(engine.read_job("job.toml"), PageAnswer::default());
    }

    #[test]
    fn a_library_is_read_with_its_faults() {
        let mut engine = Engine::default();
        let text = "schema = \"trunnion-library/1\"\nname = \"shop\"\n[[cutter]]\nname = \"b\"\nnumber = 2\n\
                    kind = \"ball\"\ndiameter = 6\nlength = 70\n";
        engine.insert("shop.toml", text.as_bytes().to_vec());
        let model = engine.library(Some("shop.toml")).unwrap();
        assert_eq!(model.cutters[0].keys[3], ["diameter", "6"].map(str::to_owned));
        engine.insert("shop.toml", text.replace("ball", "bell").into_bytes());
        assert!(engine.library(Some("shop.toml")).unwrap_err()[0].starts_with("shop.toml:6:8: "));
        assert_eq!(engine.library(None).unwrap().name, "standard");
    }

    #[test]
    fn a_part_that_cannot_be_read_is_refused_in_the_words_of_the_command_line() {
        let mut engine = Engine::default();
        engine.insert("part.step", b"noise".to_vec());
        let refused = engine.part("part.step", [0.0; 3]).unwrap_err();
        assert!(refused[0].starts_with("part.step"), "{refused:?}");
        assert_eq!(engine.propose(&["part.step".to_owned()], &Silent).messages, refused);
    }
}
