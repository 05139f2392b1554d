//! The planning thread.

use super::core::{PlannerCore, PlannerOptions};
use super::servo::PlannerServo;
use super::shared::Shared;
use crate::kinematics::MachineKinematics;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use trunnion::nc::write::WordsError;

/// Pause between two turns.
const PAUSE: Duration = Duration::from_micros(500);

/// Makes both sides of a planner, for a servo period \[s\]. Allocates the memory that they share.
///
/// # Errors
///
/// [`WordsError`] if the axes of the machine have no letters.
pub fn planner(
    kinematics: &MachineKinematics,
    options: PlannerOptions,
    period: f64,
) -> Result<(PlannerServo, PlannerCore), WordsError> {
    let PlannerOptions { blocks, pieces, axis_tolerance } = options;
    let shared = Arc::new(Shared::new(blocks, pieces, axis_tolerance));
    let core = PlannerCore::new(Arc::clone(&shared), kinematics)?;
    Ok((PlannerServo::new(shared, period), core))
}

/// Thread that plans until it is dropped.
#[derive(Debug)]
pub struct PlannerThread {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl PlannerThread {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// Those of the system.
    pub fn start(mut core: PlannerCore) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let work = move || {
            let begin = Instant::now();
            let mut clock = || begin.elapsed().as_secs_f64();
            while !stopped.load(Ordering::Acquire) {
                let start = clock();
                core.turn(&mut clock);
                core.note(clock() - start);
                std::thread::sleep(PAUSE);
            }
        };
        let thread = std::thread::Builder::new().name("trunnion-planner".to_owned()).spawn(work)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for PlannerThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}
