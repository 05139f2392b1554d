//! `trunnion batch`: many jobs, programs and CL files on one machine, resumable.

use crate::calls;
use crate::form::OutputForm;
use crate::inspect;
use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use crate::text;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use trunnion::types::{Progress, Stage};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BatchArgs {
    /// Folder with jobs (.toml), programs and CL files, or a text file that lists them, one path a line.
    input: PathBuf,
    /// Folder for the results: one folder and one record for each item.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Items that are worked on at the same time [default: one for each core].
    #[arg(short = 'J', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    jobs: Option<u32>,
    /// Options of `trunnion check` for programs and CL files, behind --.
    #[arg(last = true, value_name = "CHECK OPTIONS")]
    check: Vec<String>,
}

const EXAMPLES: &str = "\
Jobs are run, programs and CL files are checked with the options behind --. Each item has a
record, NAME-KEY.json, with its verdict and messages, and a folder of that name with its files.
KEY is the hash of everything the result depends on: an item that is finished is not run again,
one that changed is. Items that cannot be run are recorded with their messages, and do not stop
the others.
Exit codes: 0 every tolerance and limit is kept; 1 one is broken, or an item could not be run;
2 bad input, nothing written.

  trunnion batch jobs/ -o results
  trunnion batch programs.txt -o results -- --machine bc-trunnion --tool-length 120";

/// Most items of a list: longer ones are a wrong file.
const MOST_ITEMS: usize = 1_000_000;

/// Job, program or CL file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
enum ItemKind {
    Job,
    Program,
}

/// Verdict on an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum ItemStatus {
    /// Every tolerance and limit is kept.
    Kept,
    /// A tolerance or limit is broken.
    Broken,
    /// The item could not be run.
    Failed,
}

/// Record of an item, as it is kept beside its folder.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
struct ItemRecord {
    schema: String,
    item: String,
    status: ItemStatus,
    messages: Vec<String>,
}

/// Row of the summary.
#[derive(Debug, serde::Serialize)]
struct ItemRow {
    #[serde(flatten)]
    record: ItemRecord,
    /// Name of the record and of the folder.
    result: String,
    /// True if the item was finished before.
    resumed: bool,
}

#[derive(Debug, serde::Serialize)]
struct Summary {
    schema: &'static str,
    items: Vec<ItemRow>,
    kept: usize,
    broken: usize,
    failed: usize,
    resumed: usize,
    output: String,
}

/// One item of the batch.
struct Item {
    path: PathBuf,
    kind: ItemKind,
    /// Name of its record and folder.
    name: String,
}

pub(crate) fn run(args: &BatchArgs, form: OutputForm) -> Result<Done, Failure> {
    let items = items(args)?;
    Outputs::probe(&args.output)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = args.jobs.map_or(cores, |jobs| jobs as usize).min(items.len()).max(1);
    let (next, stop) = (AtomicUsize::new(0), Bars::without_bars());
    let rows: Mutex<Vec<Option<ItemRow>>> = Mutex::new(items.iter().map(|_| None).collect());
    let work = || -> Result<(), Failure> {
        while let Some((at, item)) = {
            let at = next.fetch_add(1, Ordering::Relaxed);
            items.get(at).map(|item| (at, item))
        } {
            let row = row(args, item, &stop)?;
            eprintln!("{}: {}", row.record.item, verdict(&row));
            if let Some(slot) = rows.lock().unwrap_or_else(PoisonError::into_inner).get_mut(at) {
                *slot = Some(row);
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let ended = |thread: std::thread::ScopedJoinHandle<'_, Result<(), Failure>>| {
            thread.join().unwrap_or_else(|_| Err(Failure::defect("a thread ended without result")))
        };
        threads.into_iter().map(ended).collect::<Result<Vec<()>, Failure>>()
    })?;
    let items = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let items: Vec<ItemRow> = items.into_iter().flatten().collect();
    let count = |status: ItemStatus| items.iter().filter(|row| row.record.status == status).count();
    let summary = Summary {
        schema: "trunnion-batch/1",
        kept: count(ItemStatus::Kept),
        broken: count(ItemStatus::Broken),
        failed: count(ItemStatus::Failed),
        resumed: items.iter().filter(|row| row.resumed).count(),
        items,
        output: args.output.display().to_string(),
    };
    form.print(&summary, table)?;
    Ok(if summary.kept == summary.items.len() { Done::Kept } else { Done::Broken })
}

/// Returns the items of a folder, in order of their names, or of a list, in its order.
fn items(args: &BatchArgs) -> Result<Vec<Item>, Failure> {
    let fault =
        |what: &dyn std::fmt::Display| Failure::input(format!("{}: {what}", args.input.display()));
    let mut paths: Vec<PathBuf> = if args.input.is_dir() {
        let entries = std::fs::read_dir(&args.input).map_err(|error| fault(&error))?;
        let mut paths: Vec<PathBuf> =
            entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
        paths.retain(|path| path.is_file() && kind_of(path).is_some());
        paths.sort();
        paths
    } else {
        let folder = args.input.parent().unwrap_or(Path::new(""));
        let text = text::read(&args.input)?;
        let lines = text.lines().map(str::trim);
        let named = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        named.take(MOST_ITEMS).map(|line| folder.join(line)).collect()
    };
    paths.dedup();
    if paths.is_empty() {
        let help = "name a folder with jobs (.toml), programs (.ngc, .nc, ..) or CL files, or a list of paths";
        return Err(fault(&format!("there is nothing to run\n  help: {help}")));
    }
    let item = |path: PathBuf| {
        let kind = kind_of(&path).unwrap_or(ItemKind::Program);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = format!("{stem}-{}", key(&path, kind, &args.check));
        Item { path, kind, name }
    };
    Ok(paths.into_iter().map(item).collect())
}

fn kind_of(path: &Path) -> Option<ItemKind> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Some(ItemKind::Job);
    }
    inspect::is_motion(path).then_some(ItemKind::Program)
}

/// Returns the record of an item: the one that is kept, or that of a new run.
fn row(args: &BatchArgs, item: &Item, progress: &dyn Progress) -> Result<ItemRow, Failure> {
    let file = args.output.join(format!("{}.json", item.name));
    let result = item.name.clone();
    // A record that cannot be read counts as absent: the item is run again.
    let kept = std::fs::read(&file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(record) = kept {
        return Ok(ItemRow { record, result, resumed: true });
    }
    if progress.report(Stage::Verify, 0, 1).is_break() {
        return Err(Failure::Stopped);
    }
    let (status, messages) = match work(args, item, progress) {
        Ok((true, messages)) => (ItemStatus::Kept, messages),
        Ok((false, messages)) => (ItemStatus::Broken, messages),
        Err(Failure::Stopped) => return Err(Failure::Stopped),
        Err(failure) => (ItemStatus::Failed, failure.messages()),
    };
    let record = ItemRecord {
        schema: "trunnion-batch-item/1".to_owned(),
        item: item.path.display().to_string(),
        status,
        messages,
    };
    let json = serde_json::to_string_pretty(&record).map_err(anyhow::Error::from)?;
    let (mut outputs, name) = Outputs::beside(&file)?;
    outputs.text(&name, &(json + "\n"))?;
    outputs.commit()?;
    Ok(ItemRow { record, result, resumed: false })
}

/// Runs a job or checks a program; returns true with its messages if everything is kept.
fn work(
    args: &BatchArgs,
    item: &Item,
    progress: &dyn Progress,
) -> Result<(bool, Vec<String>), Failure> {
    let folder = args.output.join(&item.name);
    if item.kind == ItemKind::Job {
        let loaded = calls::load_job(&item.path, progress)?;
        let answer = calls::run_job(&item.path, &loaded, Some(&folder), progress)?;
        let summary = answer.outcome.summary;
        return Ok((summary.passed, summary.failures));
    }
    let mut options = vec![item.path.display().to_string()];
    options.extend(args.check.iter().cloned());
    options.extend(["--output".to_owned(), folder.display().to_string()]);
    let answer = calls::check(&options, progress)?;
    let failures = answer.summary.get("failures").and_then(|list| list.as_array());
    let words = failures.into_iter().flatten().filter_map(|one| one.as_str().map(str::to_owned));
    Ok((answer.passed, words.collect()))
}

/// Returns the hash of everything that a result depends on, in hexadecimal.
fn key(path: &Path, kind: ItemKind, check: &[String]) -> String {
    let mut hash = ContentHash::new();
    hash.bytes(env!("CARGO_PKG_VERSION").as_bytes());
    let content = std::fs::read(path).unwrap_or_default();
    hash.bytes(&content);
    if kind == ItemKind::Job {
        for named in named(path, &content) {
            hash.input(&named);
        }
        return hash.hexadecimal();
    }
    for word in check {
        hash.bytes(word.as_bytes());
        // `--part=plane.json` names its file behind the sign, `vise.stl@10,0,0` before its placement.
        let value = word.rsplit_once('=').map_or(word.as_str(), |(_, value)| value);
        hash.input(Path::new(value.split('@').next().unwrap_or_default()));
    }
    let mut options = vec![path.display().to_string()];
    options.extend(check.iter().cloned());
    // What cannot be read is reported by the item itself.
    for file in calls::subprograms(&options).unwrap_or_default() {
        hash.bytes(file.name.as_bytes());
        hash.bytes(file.text.as_bytes());
    }
    hash.hexadecimal()
}

/// Returns the files that a job or machine file names: its quoted words that are files beside it.
fn named(file: &Path, content: &[u8]) -> Vec<PathBuf> {
    let text = String::from_utf8_lossy(content);
    let folder = file.parent().unwrap_or(Path::new(""));
    let words = text.split(['"', '\'']).filter(|word| !word.is_empty());
    words.map(|word| folder.join(word)).filter(|path| path.is_file()).collect()
}

/// FNV-1a of 128 bits: two different contents of a batch meet by chance with a probability below 1e-25.
struct ContentHash(u128);

impl ContentHash {
    fn new() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        // The length keeps neighbouring parts apart.
        for byte in bytes.len().to_le_bytes().iter().chain(bytes) {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
        }
    }

    /// Adds a file; of a machine file also the solids of its bodies.
    fn input(&mut self, path: &Path) {
        let Some(content) = path.is_file().then(|| std::fs::read(path).ok()).flatten() else {
            return;
        };
        self.bytes(&content);
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            for solid in named(path, &content) {
                self.bytes(&std::fs::read(solid).unwrap_or_default());
            }
        }
    }

    fn hexadecimal(&self) -> String {
        format!("{:032x}", self.0)
    }
}

fn verdict(row: &ItemRow) -> String {
    let words = match row.record.status {
        ItemStatus::Kept => "kept",
        ItemStatus::Broken => "NOT KEPT",
        ItemStatus::Failed => "failed",
    };
    let before = if row.resumed { " (finished before)" } else { "" };
    format!("{words}{before}")
}

fn table(summary: &Summary) -> String {
    let mut out = String::new();
    for row in &summary.items {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{:<40} {}", row.record.item, verdict(row));
        for message in row.record.messages.iter().take(3) {
            let _ = writeln!(out, "    {}", message.replace('\n', "\n    "));
        }
    }
    let Summary { kept, broken, failed, resumed, output, .. } = summary;
    let _ = writeln!(
        out,
        "{kept} kept, {broken} not kept, {failed} failed; {resumed} finished before\nresults in {output}"
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_hash_are_kept_apart() {
        let of = |parts: &[&str]| {
            let mut hash = ContentHash::new();
            for part in parts {
                hash.bytes(part.as_bytes());
            }
            hash.hexadecimal()
        };
        assert_ne!(of(&["ab", "c"]), of(&["a", "bc"]));
        assert_eq!(of(&["ab", "c"]), of(&["ab", "c"]));
        assert_eq!(of(&[]).len(), 32);
    }

    #[test]
    fn every_file_that_an_item_reads_counts() {
        let home = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = home.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let job = write("job.toml", "[machine]\nfile = 'own.toml'\n");
        let machine = write("own.toml", "[[body]]\nfile = \"column.stl\"\n");
        let program = write("part.ngc", "o<pocket> call\nM2\n");
        let vise = format!("--fixture={}@10,0,0", home.path().join("vise.stl").display());
        let check = ["--machine".to_owned(), machine, vise];
        let keys = || {
            let job = key(Path::new(&job), ItemKind::Job, &[]);
            (job, key(Path::new(&program), ItemKind::Program, &check))
        };
        for (name, job_too) in [("column.stl", true), ("vise.stl", false), ("pocket.ngc", false)] {
            write(name, "o<pocket> sub\no<pocket> endsub\n");
            let (job, program) = keys();
            write(name, "o<pocket> sub\nG4 P1\no<pocket> endsub\n");
            let again = keys();
            assert_eq!(job != again.0, job_too, "{name}");
            assert_ne!(program, again.1, "{name}");
        }
    }
}
