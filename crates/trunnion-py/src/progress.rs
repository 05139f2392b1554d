//! Long calls: without the lock of the interpreter, with progress and Ctrl-C.

use crate::errors;
use crate::locate::pass_of;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use trunnion::types::{Pass, Progress, Stage};
use trunnion_cli::Failure;

/// Time between two looks at signals and two reports: short for a person, long for a computer.
const LOOK: Duration = Duration::from_millis(40);

/// Passes of each face, by its number.
type FacePasses = BTreeMap<usize, Vec<Arc<Pass>>>;

/// Callables that hear of a call while it works.
#[derive(Clone, Copy, Default)]
pub(crate) struct Listeners<'a> {
    /// Hears stage, steps done and steps in all.
    pub(crate) progress: Option<&'a Py<PyAny>>,
    /// Hears the number of a face and its passes as far as they are placed.
    pub(crate) passes: Option<&'a Py<PyAny>>,
}

/// Newest report of the work, and the request to stop it.
#[derive(Default)]
struct Watch {
    newest: Mutex<Option<(Stage, u64, u64)>>,
    /// Faces whose passes have changed since the last look; `None` where nobody asks.
    placed: Option<Mutex<FacePasses>>,
    stopped: AtomicBool,
}

impl Progress for Watch {
    fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()> {
        *self.newest.lock().unwrap_or_else(PoisonError::into_inner) = Some((stage, done, total));
        if self.stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn report_passes(&self, face: usize, passes: &[Arc<Pass>]) {
        if let Some(placed) = &self.placed {
            let mut placed = placed.lock().unwrap_or_else(PoisonError::into_inner);
            placed.insert(face, passes.to_vec());
        }
    }
}

impl Watch {
    /// Hands what is new to the caller, and lets its signal handlers run.
    fn look(&self, listeners: Listeners<'_>, shown: &mut ShownPasses) -> PyResult<()> {
        let newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let placed = self.placed.as_ref().map(|placed| {
            std::mem::take(&mut *placed.lock().unwrap_or_else(PoisonError::into_inner))
        });
        Python::attach(|py| {
            py.check_signals()?;
            if let (Some(callable), Some((stage, done, total))) = (listeners.progress, newest) {
                callable.call1(py, (words(stage), done, total))?;
            }
            if let (Some(callable), Some(placed)) = (listeners.passes, placed) {
                for (face, passes) in placed {
                    callable.call1(py, (face, shown.list(py, face, passes)?))?;
                }
            }
            Ok(())
        })
    }
}

/// Pass, and what the caller got of it.
type ShownPass = (Arc<Pass>, Py<PyDict>);

/// Passes that the caller has got: those that stay are not converted again.
#[derive(Default)]
struct ShownPasses(BTreeMap<usize, Vec<ShownPass>>);

impl ShownPasses {
    /// Returns the passes of a face as a list of dicts.
    fn list<'py>(
        &mut self,
        py: Python<'py>,
        face: usize,
        passes: Vec<Arc<Pass>>,
    ) -> PyResult<Bound<'py, PyList>> {
        let shown = self.0.entry(face).or_default();
        let stay = shown.iter().zip(&passes).take_while(|(old, new)| Arc::ptr_eq(&old.0, new));
        shown.truncate(stay.count());
        for pass in passes.into_iter().skip(shown.len()) {
            let made = pass_of(py, &pass)?.unbind();
            shown.push((pass, made));
        }
        PyList::new(py, shown.iter().map(|(_, made)| made))
    }
}

/// Returns a callable of a callable or a tqdm bar; refuses everything else.
pub(crate) fn adapted(py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Option<Py<PyAny>>> {
    let Some(progress) = progress else { return Ok(None) };
    let found = py.import("trunnion._progress")?.call_method1("adapted", (progress,))?;
    Ok(Some(found.unbind()))
}

/// Runs `work` in a thread of its own, so that this one can report progress and take Ctrl-C.
///
/// An exception of the callable or of a signal handler stops the work, and is returned.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callable: Option<&Py<PyAny>>,
    work: impl FnOnce(&dyn Progress) -> T + Send,
) -> PyResult<T> {
    heard(py, Listeners { progress: callable, ..Listeners::default() }, work)
}

/// Runs `work` like [`watched`], and hands over passes as they are placed.
pub(crate) fn heard<T: Send>(
    py: Python<'_>,
    listeners: Listeners<'_>,
    work: impl FnOnce(&dyn Progress) -> T + Send,
) -> PyResult<T> {
    py.detach(|| {
        let placed = listeners.passes.map(|_| Mutex::default());
        let watch = Watch { placed, ..Watch::default() };
        let mut shown = ShownPasses::default();
        std::thread::scope(|scope| {
            let (sender, receiver) = channel();
            let watched = &watch;
            let worker = scope.spawn(move || {
                // Nobody waits any more only if this thread has failed.
                let _ = sender.send(work(watched));
            });
            let mut raised = None;
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(result) => {
                        // The last report may be newer than the last look. A callable that has raised is not called again.
                        raised = raised.or_else(|| watch.look(listeners, &mut shown).err());
                        return raised.map_or(Ok(result), Err);
                    }
                    Err(RecvTimeoutError::Timeout) if raised.is_none() => {
                        raised = watch.look(listeners, &mut shown).err();
                        watch.stopped.store(raised.is_some(), Ordering::Relaxed);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    // A defect of the library: the interpreter goes on.
                    Err(RecvTimeoutError::Disconnected) => {
                        let message = "the work ended without a result, by a defect of trunnion";
                        let _ = worker.join();
                        let internal = Failure::defect(message);
                        return Err(Python::attach(|py| errors::failure(py, internal)));
                    }
                }
            }
        })
    })
}

/// Rows between two looks at signals and two reports: below half a second for the slowest search.
pub(crate) const SLICE: usize = 8192;

/// Stage of a call, and the callable that hears how far it is.
#[derive(Clone, Copy)]
pub(crate) struct StageWatch<'a> {
    pub(crate) stage: &'a str,
    pub(crate) callable: Option<&'a Py<PyAny>>,
}

/// Works on ranges of `count` rows one after another, and lets signal handlers run between them; for work that goes on
/// from row to row.
pub(crate) fn in_turn(
    py: Python<'_>,
    count: usize,
    mut work: impl FnMut(Range<usize>) + Send,
) -> PyResult<()> {
    for start in (0..count).step_by(SLICE) {
        py.detach(|| work(start..count.min(start + SLICE)));
        py.check_signals()?;
    }
    Ok(())
}

/// Works on rows slice by slice, and lets signal handlers and the callable run between them.
pub(crate) fn in_slices<R: Sync, T: Send>(
    py: Python<'_>,
    watch: StageWatch<'_>,
    rows: &[R],
    work: impl Fn(&[R]) -> Vec<T> + Sync,
) -> PyResult<Vec<T>> {
    let mut all = Vec::with_capacity(rows.len());
    for slice in rows.chunks(SLICE) {
        all.extend(py.detach(|| work(slice)));
        py.check_signals()?;
        if let Some(callable) = watch.callable {
            callable.call1(py, (watch.stage, all.len(), rows.len()))?;
        }
    }
    Ok(all)
}

fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Import => "reading the part",
        Stage::Cover => "placing strips",
        Stage::ToolPath => "laying the path",
        Stage::Axes => "solving the axes",
        Stage::Feed => "planning speeds",
        Stage::Setpoints => "sampling setpoints",
        Stage::Program => "writing programs",
        Stage::Verify => "checking the program",
    }
}
