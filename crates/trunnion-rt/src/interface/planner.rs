//! C functions of the planner.
//!
//! Letters are X Y Z A B C U V W, in mm and rad. [`trunnion_planner_start`] and [`trunnion_planner_stop`] allocate and
//! start a thread; the rest belongs to the servo thread, and neither allocates nor waits.

#![expect(unsafe_code, reason = "pointers from C; every block states what the caller promises")]

use super::{Trunnion, kinematics, write_text};
use crate::planner::LETTERS;
use crate::planner::{
    BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerOptions, PlannerServo,
    PlannerThread, ServoSpeeds, planner,
};
use crate::switched::KinematicsMode;
use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Number of letters of a pose.
pub const TRUNNION_LETTERS: usize = 9;

/// A block begins on the move, on the move at an exact place (outputs), or at rest.
pub const TRUNNION_BEGINS_FLOW: i32 = 0;
/// See `TRUNNION_BEGINS_FLOW`.
pub const TRUNNION_BEGINS_MARKED: i32 = 1;
/// See `TRUNNION_BEGINS_FLOW`.
pub const TRUNNION_BEGINS_REST: i32 = 2;

/// A block ends at rest, exactly on the path, or rounded within the tolerance.
pub const TRUNNION_ENDS_STOP: i32 = 0;
/// See `TRUNNION_ENDS_STOP`.
pub const TRUNNION_ENDS_EXACT: i32 = 1;
/// See `TRUNNION_ENDS_STOP`.
pub const TRUNNION_ENDS_BLEND: i32 = 2;

/// A block moves at its speed at most, as a rapid move, or in the time that its speed makes of its length.
pub const TRUNNION_MOVES_FEED: i32 = 0;
/// See `TRUNNION_MOVES_FEED`.
pub const TRUNNION_MOVES_RAPID: i32 = 1;
/// See `TRUNNION_MOVES_FEED`.
pub const TRUNNION_MOVES_TIMED: i32 = 2;

/// Planner with its thread; this end belongs to the servo thread.
#[derive(Debug)]
pub struct TrunnionPlanner {
    servo: PlannerServo,
    _thread: PlannerThread,
}

/// A block of a program.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrunnionBlock {
    /// Number that `trunnion_planner_cycle` reports back.
    pub number: u32,
    /// Position at the start.
    pub start: [f64; TRUNNION_LETTERS],
    /// Position at the end.
    pub end: [f64; TRUNNION_LETTERS],
    /// 1: an arc in X Y Z, the rest in proportion; 0: a line.
    pub arc: i32,
    /// Full turns of an arc besides itself; from -1 downwards it turns clockwise about its normal.
    pub turns: i32,
    /// Centre of an arc.
    pub center: [f64; 3],
    /// Normal of an arc.
    pub normal: [f64; 3],
    /// One of `TRUNNION_MOVES_..`.
    pub kind: i32,
    /// One of `TRUNNION_BEGINS_..`.
    pub begins: i32,
    /// One of `TRUNNION_ENDS_..`.
    pub ending: i32,
    /// Number of the kinematics: 0 plain axes, 1 tool-centre-point control.
    pub mode: i32,
    /// Programmed speed: of X Y Z; of U V W if those rest; of A B C if nothing else moves. In mm/s or rad/s.
    pub speed: f64,
    /// Largest deviation of the tip at the corner at the end, in mm.
    pub tolerance: f64,
    /// Length of the tool, in mm.
    pub tool_length: f64,
}

/// Position and state of a servo cycle.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrunnionSample {
    /// Position of the letters.
    pub position: [f64; TRUNNION_LETTERS],
    /// Velocity of the letters.
    pub velocity: [f64; TRUNNION_LETTERS],
    /// Block that is run, or the last one.
    pub block: u32,
    /// 1: nothing moves.
    pub rests: i32,
    /// 1: at rest behind the last block.
    pub done: i32,
}

/// Reason why a program cannot go on.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrunnionFault {
    /// Block that is refused; the tool stops before it.
    pub block: u32,
    /// Number of the reason, a `TrunnionRefusal`.
    pub code: i32,
    /// Axis outside its travel; for `TRUNNION_REFUSAL_NO_AXIS` the letter; -1 for none.
    pub axis: i32,
    /// Distance outside, in mm or rad.
    pub excess: f64,
}

/// State of the plan, for people.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrunnionPlannerState {
    /// Time until rest of what the servo thread has, in s.
    pub ahead: f64,
    /// Longest turn of the planning thread, in s.
    pub longest_turn: f64,
    /// Time that the planning thread has worked, in s.
    pub worked: f64,
    /// Number of plans that came too late.
    pub late: u32,
    /// Limit that binds: 0 none, 1 feed, 2 rapid; 10, 20 or 30 and the axis for its velocity, acceleration or jerk.
    pub limit: u32,
}

/// Starts a planner for `blocks` blocks and a servo period in s. Returns null where that fails, with the reason as text
/// in `message`, which holds `size` bytes. `trunnion_planner_stop` ends it.
///
/// # Safety
///
/// `machine` is open; `message` is null or points to `size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_start(
    machine: *const Trunnion,
    blocks: usize,
    period: f64,
    message: *mut c_char,
    size: usize,
) -> *mut TrunnionPlanner {
    let started = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the caller promises that the machine is open.
        let machine = unsafe { kinematics(machine) };
        let machine = machine.map_err(|_| "no machine is open".to_owned())?;
        let options = PlannerOptions { blocks, ..PlannerOptions::STANDARD };
        let (servo, core) = planner(machine, options, period).map_err(|error| error.to_string())?;
        let thread = PlannerThread::start(core).map_err(|error| format!("the thread: {error}"))?;
        Ok(TrunnionPlanner { servo, _thread: thread })
    }));
    let reason = match started {
        Ok(Ok(planner)) => return Box::into_raw(Box::new(planner)),
        Ok(Err(reason)) => reason,
        Err(_) => "a fault inside the library".to_owned(),
    };
    // SAFETY: the caller promises `size` bytes.
    unsafe { write_text(&reason, message, size) };
    std::ptr::null_mut()
}

/// Ends a planner and its thread; null is ignored.
///
/// # Safety
///
/// `planner` comes from `trunnion_planner_start`, and is not used after this call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_stop(planner: *mut TrunnionPlanner) {
    if !planner.is_null() {
        // SAFETY: it was made by `Box::into_raw`, and the caller gives it up.
        drop(unsafe { Box::from_raw(planner) });
    }
}

/// Hands a block over. Returns 1, or 0 where the queue is full, an abort is under way, or the block has a number that no
/// block can have.
///
/// # Safety
///
/// `planner` is running and used by this thread alone; `block` points to a block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_push(
    planner: *mut TrunnionPlanner,
    block: *const TrunnionBlock,
) -> i32 {
    // SAFETY: the caller promises both.
    let (Some(planner), Some(block)) = (unsafe { planner.as_mut() }, unsafe { block.as_ref() })
    else {
        return 0;
    };
    let pushed = block_of(block).and_then(|block| planner.servo.push(&block));
    i32::from(pushed.is_some())
}

/// Forgets all blocks, and stands at a position at once: for a machine at rest.
///
/// # Safety
///
/// As `trunnion_planner_push`; `position` holds `TRUNNION_LETTERS` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_reset(
    planner: *mut TrunnionPlanner,
    position: *const f64,
) {
    // SAFETY: the caller promises both.
    if let Some((planner, position)) = unsafe { with_letters(planner, position) } {
        planner.servo.reset(position);
    }
}

/// Sets the position of a machine that rests behind its last block.
///
/// # Safety
///
/// As `trunnion_planner_reset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_place(
    planner: *mut TrunnionPlanner,
    position: *const f64,
) {
    // SAFETY: the caller promises both.
    if let Some((planner, position)) = unsafe { with_letters(planner, position) } {
        planner.servo.set_position(position);
    }
}

/// Begins to stop, and to forget all blocks then.
///
/// # Safety
///
/// `planner` is running and used by this thread alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_abort(planner: *mut TrunnionPlanner) {
    // SAFETY: the caller promises it.
    if let Some(planner) = unsafe { planner.as_mut() } {
        planner.servo.abort();
    }
}

/// Returns 1 until an abort has come to rest, and 0 otherwise.
///
/// # Safety
///
/// As `trunnion_planner_abort`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_is_aborting(planner: *const TrunnionPlanner) -> i32 {
    // SAFETY: the caller promises it.
    unsafe { planner.as_ref() }.map_or(0, |planner| i32::from(planner.servo.is_aborting()))
}

/// Returns 1 at rest behind the last block, and 0 otherwise.
///
/// # Safety
///
/// As `trunnion_planner_abort`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_is_done(planner: *const TrunnionPlanner) -> i32 {
    // SAFETY: the caller promises it.
    unsafe { planner.as_ref() }.map_or(1, |planner| i32::from(planner.servo.is_done()))
}

/// Plays one servo cycle with overrides of the feed and of rapid moves; 0 holds.
///
/// # Safety
///
/// As `trunnion_planner_abort`; `sample` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_cycle(
    planner: *mut TrunnionPlanner,
    feed: f64,
    rapid: f64,
    sample: *mut TrunnionSample,
) {
    // SAFETY: the caller promises both.
    let (Some(planner), Some(sample)) = (unsafe { planner.as_mut() }, unsafe { sample.as_mut() })
    else {
        return;
    };
    let found = planner.servo.cycle(ServoSpeeds { feed, rapid });
    *sample = TrunnionSample {
        position: found.position,
        velocity: found.velocity,
        block: found.block,
        rests: i32::from(found.rests),
        done: i32::from(found.done),
    };
}

/// Takes the next fault of the plan. Returns 1 if there was one, and 0 otherwise.
///
/// # Safety
///
/// As `trunnion_planner_abort`; `fault` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_fault(
    planner: *mut TrunnionPlanner,
    fault: *mut TrunnionFault,
) -> i32 {
    // SAFETY: the caller promises both.
    let (Some(planner), Some(fault)) = (unsafe { planner.as_mut() }, unsafe { fault.as_mut() })
    else {
        return 0;
    };
    let Some(found) = planner.servo.fault() else { return 0 };
    let (block, code, axis, excess) = (found.block, found.code, found.axis, found.excess);
    *fault = TrunnionFault { block, code, axis, excess };
    1
}

/// Writes the state of the plan to `state`.
///
/// # Safety
///
/// As `trunnion_planner_abort`; `state` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_state(
    planner: *const TrunnionPlanner,
    state: *mut TrunnionPlannerState,
) {
    // SAFETY: the caller promises both.
    let (Some(planner), Some(state)) = (unsafe { planner.as_ref() }, unsafe { state.as_mut() })
    else {
        return;
    };
    let found = planner.servo.state();
    *state = TrunnionPlannerState {
        ahead: found.ahead,
        longest_turn: found.longest_turn,
        worked: found.worked,
        late: found.late,
        limit: found.limit,
    };
}

/// Sets the servo period in s, and the largest deviation of the rotaries at corners in rad; one that is not positive is
/// left as it is.
///
/// # Safety
///
/// As `trunnion_planner_abort`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_planner_set(
    planner: *mut TrunnionPlanner,
    period: f64,
    axis_tolerance: f64,
) {
    // SAFETY: the caller promises it.
    if let Some(planner) = unsafe { planner.as_mut() } {
        planner.servo.set_period(period);
        planner.servo.set_axis_tolerance(axis_tolerance);
    }
}

/// Returns a block, unless a number has no meaning.
fn block_of(block: &TrunnionBlock) -> Option<MotionBlock> {
    let shape = match block.arc {
        0 => BlockShape::Line,
        _ => BlockShape::Arc { center: block.center, normal: block.normal, turns: block.turns },
    };
    let begins = match block.begins {
        TRUNNION_BEGINS_FLOW => BlockStart::Flow,
        TRUNNION_BEGINS_MARKED => BlockStart::Marked,
        TRUNNION_BEGINS_REST => BlockStart::Rest,
        _ => return None,
    };
    let ending = match block.ending {
        TRUNNION_ENDS_STOP => BlockEnding::Stop,
        TRUNNION_ENDS_EXACT => BlockEnding::Exact,
        TRUNNION_ENDS_BLEND => BlockEnding::Blend,
        _ => return None,
    };
    let kind = match block.kind {
        TRUNNION_MOVES_FEED => BlockKind::Feed,
        TRUNNION_MOVES_RAPID => BlockKind::Rapid,
        TRUNNION_MOVES_TIMED => BlockKind::Timed,
        _ => return None,
    };
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let numbers = block.start.iter().chain(&block.end).chain([&block.tool_length]);
    let finite = numbers.into_iter().all(|value| value.is_finite());
    (finite && positive(block.speed) && positive(block.tolerance)).then_some(())?;
    Some(MotionBlock {
        number: block.number,
        start: block.start,
        end: block.end,
        shape,
        kind,
        speed: block.speed,
        begins,
        ending,
        tolerance: block.tolerance,
        coordinates: KinematicsMode::from_number(block.mode).ok()?.into(),
        tool_length: block.tool_length,
    })
}

/// Reads a position of the caller.
///
/// # Safety
///
/// `planner` is null, or running and used by this thread alone; `position` is null or holds `LETTERS` numbers.
unsafe fn with_letters<'a>(
    planner: *mut TrunnionPlanner,
    position: *const f64,
) -> Option<(&'a mut TrunnionPlanner, [f64; LETTERS])> {
    // SAFETY: the caller promises it.
    let planner = unsafe { planner.as_mut() }?;
    // SAFETY: the caller promises the numbers.
    let position = unsafe { super::numbers::<LETTERS>(position) }?;
    Some((planner, position))
}
