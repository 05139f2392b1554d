//! After the load no call allocates, also where it refuses a position.

#![expect(unsafe_code, reason = "an allocator that counts is unsafe to write")]

use crate::walk::{Dice, machines};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use trunnion_rt::motion::{LETTERS, MotionPiece, MotionPlayer, RateBounds, piece_queue};
use trunnion_rt::{KinematicsMode, MachineKinematics, SwitchedKinematics};

/// The system's allocator, with a count of this thread's calls.
struct CountingAllocator;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    CALLS.with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn the_allocator_counts() {
    let before = CALLS.with(Cell::get);
    drop(std::hint::black_box(vec![1.0; 100]));
    assert_eq!(CALLS.with(Cell::get), before + 2);
}

#[test]
fn no_call_allocates() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let mut switched = SwitchedKinematics::new(rt.clone());
        let mut dice = Dice::new(5);
        let cases: Vec<_> =
            (0..2000).map(|_| [dice.joints(&machine), dice.joints(&machine)]).collect();
        let (mut reached, mut refused) = (0, 0);
        let before = CALLS.with(Cell::get);
        for (index, [joints, near]) in cases.iter().enumerate() {
            let length = (index % 7) as f64 * 30.0;
            let mode = [KinematicsMode::Axes, KinematicsMode::ToolCenterPoint][index / 9 % 2];
            if index % 9 == 0 {
                let _ = switched.switch(mode, length);
            }
            let words = switched.forward(length, joints);
            let back = words.and_then(|words| switched.inverse(&words));
            let mut pose = rt.pose(length, joints);
            // Every third pose is far outside, every eleventh is none.
            if index % 3 == 0 {
                pose.tip *= 40.0;
            }
            if index % 11 == 0 {
                pose.tip.x = f64::NAN;
            }
            if index % 5 == 0 {
                pose.axis = -pose.axis;
            }
            for ok in [back.is_ok(), rt.nearest(length, &pose, near).is_ok()] {
                *(if ok { &mut reached } else { &mut refused }) += 1;
            }
        }
        assert_eq!(CALLS.with(Cell::get), before, "{}", machine.name);
        assert!(reached > 500 && refused > 500, "{}: {reached} {refused}", machine.name);
    }
}

#[test]
fn no_cycle_of_a_plan_allocates() {
    let (mut sender, receiver) = piece_queue(100);
    let bounds = RateBounds { change: 10.0, bend: 200.0 };
    let mut player = MotionPlayer::new(receiver, [0.0; LETTERS], bounds, 0.001).unwrap();
    let before = CALLS.with(Cell::get);
    let mut x = 0.0;
    for cycle in 0..3000 {
        let mut letters = [[0.0; 6]; LETTERS];
        letters[0] = [x, 20.0, 0.0, 0.0, 0.0, 0.0];
        let piece = MotionPiece { duration: 0.002, letters, block: cycle };
        if sender.send(&piece).is_ok() {
            x = piece.at(piece.duration)[0];
        }
        player.cycle(if cycle % 500 < 400 { 1.0 } else { 0.0 });
    }
    assert_eq!(CALLS.with(Cell::get), before);
}
