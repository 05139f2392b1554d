//! Progress bars on a terminal, and Ctrl-C.

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use trunnion::types::{Progress, Stage};

/// Asks the library to stop at the first Ctrl-C, by `flag`, and ends the process at the second.
#[cfg(not(target_family = "wasm"))]
fn listen(flag: Arc<AtomicBool>) {
    // Without a handler Ctrl-C ends the process, and staged files are never renamed: as safe.
    let _ = ctrlc::set_handler(move || {
        // The first signal asks, the second does not wait for an answer.
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    });
}

/// A page has no signals.
#[cfg(target_family = "wasm")]
fn listen(_: Arc<AtomicBool>) {}

/// Lets Ctrl-C no longer stop the process.
pub(crate) fn ignore_interrupts() {
    #[cfg(not(target_family = "wasm"))]
    let _ = ctrlc::set_handler(|| {});
}

/// Progress bars on stderr, one for each stage; none if stderr is not a terminal.
#[derive(Debug)]
pub(crate) struct Bars {
    stopped: Arc<AtomicBool>,
    bars: Option<(MultiProgress, Mutex<BTreeMap<Stage, ProgressBar>>)>,
}

impl Bars {
    /// Creates bars that also listen to Ctrl-C: the first asks the library to stop, a second ends at once.
    pub(crate) fn new() -> Self {
        let stopped = Arc::new(AtomicBool::new(false));
        listen(Arc::clone(&stopped));
        let terminal = std::io::stderr().is_terminal();
        let bars = terminal.then(|| (MultiProgress::new(), Mutex::new(BTreeMap::new())));
        Self { stopped, bars }
    }

    /// Creates a progress that shows nothing, and listens to Ctrl-C.
    pub(crate) fn without_bars() -> Self {
        Self { bars: None, ..Self::new() }
    }

    /// Leaves the finished bars on the screen.
    pub(crate) fn finish(&self) {
        if let Some((_, bars)) = &self.bars {
            for bar in bars.lock().unwrap_or_else(PoisonError::into_inner).values() {
                bar.finish();
            }
        }
    }
}

impl Progress for Bars {
    fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()> {
        if let Some((all, bars)) = &self.bars {
            let mut bars = bars.lock().unwrap_or_else(PoisonError::into_inner);
            // Stages may overlap: each keeps its own bar.
            let bar = bars.entry(stage).or_insert_with(|| all.add(bar(stage)));
            bar.set_length(total);
            bar.set_position(done);
        }
        if self.stopped.load(Ordering::SeqCst) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

fn bar(stage: Stage) -> ProgressBar {
    // The time left is that of the stage.
    let style =
        ProgressStyle::with_template("{msg:<28} {bar:32} {percent:>3} %  {elapsed}, {eta} left");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(0).with_style(style).with_message(stage_words(stage))
}

/// Names a stage for people.
pub fn stage_words(stage: Stage) -> &'static str {
    match stage {
        Stage::Import => "reading the part",
        Stage::Cover => "placing strips",
        Stage::ToolPath => "fitting curves",
        Stage::Axes => "solving the axes",
        Stage::Feed => "planning speeds",
        Stage::Setpoints => "sampling setpoints",
        Stage::Program => "writing programs",
        Stage::Verify => "checking the program",
    }
}
