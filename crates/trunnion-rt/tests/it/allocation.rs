//! After the load no call allocates, also where it refuses a position.

#![expect(unsafe_code, reason = "an allocator that counts is unsafe to write")]

use crate::walk::{Dice, machines};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use trunnion_rt::planner::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, MotionBlock, PlannerOptions,
    PlannerThread, ServoSpeeds, planner,
};
use trunnion_rt::{KinematicsMode, MachineKinematics, SwitchedKinematics, machine_named};

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

/// The planning thread allocates as it likes; the servo thread never does, also where it aborts and begins again.
#[test]
fn no_servo_call_of_the_planner_allocates() {
    let kinematics = machine_named("ac-trunnion").unwrap();
    let (mut servo, core) = planner(&kinematics, PlannerOptions::STANDARD, 0.001).unwrap();
    let thread = PlannerThread::start(core).unwrap();
    let place = |x: f64| [x, 0.0, -300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    servo.reset(place(0.0));
    let (mut number, mut from, mut moved) = (0_u32, 0.0, 0_u32);
    let before = CALLS.with(Cell::get);
    for cycle in 0..3000_u32 {
        if servo.is_done() {
            from = servo.position()[0];
        }
        let to = from + if from > 50.0 { -0.2 } else { 0.2 };
        number += 1;
        let block = MotionBlock {
            number,
            start: place(from),
            end: place(to),
            shape: BlockShape::Line,
            kind: BlockKind::Feed,
            speed: 50.0,
            begins: BlockStart::Flow,
            ending: BlockEnding::Blend,
            tolerance: 0.01,
            coordinates: BlockCoordinates::Axes,
            tool_length: 0.0,
        };
        if servo.push(&block).is_some() {
            from = to;
        }
        let sample = servo.cycle(ServoSpeeds { feed: 1.0, rapid: 1.0 });
        moved += u32::from(!sample.rests);
        let _ = (servo.fault(), servo.state());
        if cycle % 700 == 699 {
            servo.abort();
        }
        std::thread::sleep(std::time::Duration::from_micros(300));
    }
    assert_eq!(CALLS.with(Cell::get), before);
    drop(thread);
    assert!(moved > 300, "{moved}");
}
