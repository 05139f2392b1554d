//! The C interface: `linuxcnc/trunnion_rt.h` is made from this file.
//!
//! Angles are in rad, lengths in mm. Joints and words are arrays of [`TRUNNION_AXES`] numbers in the order X, Y, Z,
//! then the rotary axes in chain order; a pose is six numbers, the tip and the unit vector from tip to spindle.
//! Only [`trunnion_open`], [`trunnion_read`], [`trunnion_ini`] and [`trunnion_close`] may allocate or read files: the rest may be
//! called in a servo cycle. One [`Trunnion`] belongs to one thread at a time.

#![expect(unsafe_code, reason = "pointers from C; every block states what the caller promises")]

mod planner;

use crate::ini::ini_differences;
use crate::kinematics::MachineKinematics;
use crate::load::{LoadError, machine_from_text, machine_named};
use crate::refusal::{Refusal, RefusalCode};
use crate::switched::{KinematicsMode, SwitchedKinematics};
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use trunnion::machine::AxisKind;
use trunnion::nalgebra::{Point3, UnitVector3, Vector3};
use trunnion::types::{AxisVector, ToolPose};

pub use planner::*;

/// Number of axes: X, Y, Z and two rotaries.
pub const TRUNNION_AXES: usize = 5;

/// Numbers of a pose: tip, and unit vector from tip to spindle.
pub const TRUNNION_POSE: usize = 6;

/// Machine with its switch between plain axes (0) and tool-centre-point control (1).
#[derive(Debug)]
pub struct Trunnion {
    kinematics: SwitchedKinematics,
}

/// Axis of a machine. Positions and rates are in mm or rad, and s.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrunnionAxis {
    /// Upper-case letter of its words.
    pub letter: c_char,
    /// 1: rotary; 0: linear.
    pub rotary: i32,
    /// Lower end of travel; minus infinity on an axis that turns without end.
    pub low: f64,
    /// Upper end of travel.
    pub high: f64,
}

/// Result of a call: a `RefusalCode`, 0 where nothing is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct TrunnionStatus {
    /// Number of the reason; `trunnion_refusal_text` has its text.
    pub code: i32,
    /// Index of the axis that is outside its travel; -1 for none.
    pub axis: i32,
    /// Distance outside, in mm or rad.
    pub excess: f64,
}

impl TrunnionStatus {
    const DONE: Self = Self { code: RefusalCode::None as i32, axis: -1, excess: 0.0 };
    const INTERNAL: Self = Self { code: RefusalCode::Internal as i32, ..Self::DONE };
}

impl From<Refusal> for TrunnionStatus {
    fn from(refusal: Refusal) -> Self {
        let axis = refusal.axis.and_then(|axis| i32::try_from(axis).ok());
        Self { code: refusal.code as i32, axis: axis.unwrap_or(-1), excess: refusal.excess }
    }
}

/// Opens a machine file, or a built-in machine by its name. Returns null where that fails, with the reason as text in
/// `message`, which holds `size` bytes. `trunnion_close` frees the machine.
///
/// # Safety
///
/// `name` is a string that ends with a zero byte; `message` is null or points to `size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_open(
    name: *const c_char,
    message: *mut c_char,
    size: usize,
) -> *mut Trunnion {
    // SAFETY: the caller promises both pointers.
    unsafe { load(name, machine_named, message, size) }
}

/// Reads the text of a machine file, as `trunnion_open` reads a file.
///
/// # Safety
///
/// As `trunnion_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_read(
    text: *const c_char,
    message: *mut c_char,
    size: usize,
) -> *mut Trunnion {
    // SAFETY: the caller promises both pointers.
    unsafe { load(text, machine_from_text, message, size) }
}

/// Frees a machine; null is ignored.
///
/// # Safety
///
/// `machine` comes from `trunnion_open` or `trunnion_read`, and is not used after this call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_close(machine: *mut Trunnion) {
    if !machine.is_null() {
        // SAFETY: it was made by `Box::into_raw` in `load`, and the caller gives it up.
        drop(unsafe { Box::from_raw(machine) });
    }
}

/// Describes an axis; `index` counts from 0 in the order of joints.
///
/// # Safety
///
/// `machine` is open; `axis` points to a writable `TrunnionAxis`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_axis(
    machine: *const Trunnion,
    index: usize,
    axis: *mut TrunnionAxis,
) -> TrunnionStatus {
    // SAFETY: the caller promises that the machine is open.
    let Some(machine) = (unsafe { machine.as_ref() }) else { return TrunnionStatus::INTERNAL };
    let machine = machine.kinematics.machine().machine();
    let Some(found) = machine.axes.get(index) else { return TrunnionStatus::INTERNAL };
    let text = found.output.letter.as_deref().unwrap_or(&found.name);
    let letter = text.bytes().next().unwrap_or_default().to_ascii_uppercase();
    let [low, high] = found.limits.ends();
    let rotary = i32::from(found.kind == AxisKind::Rotary);
    let described = TrunnionAxis { letter: letter.cast_signed(), rotary, low, high };
    // SAFETY: the caller promises a writable axis.
    unsafe { put(axis, described) }
}

/// Compares the joints of an INI file of `LinuxCNC` with the axes of a machine. Returns the number of differences because of
/// which the machine cannot run by both files, -1 for a file that cannot be read; `message`, which holds `size` bytes, has a
/// line for each, with the remedy.
///
/// # Safety
///
/// `machine` is open; `path` is a string that ends with a zero byte; `message` is null or points to `size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_ini(
    machine: *const Trunnion,
    path: *const c_char,
    message: *mut c_char,
    size: usize,
) -> i32 {
    let compared = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the caller promises that the machine is open.
        let machine = unsafe { kinematics(machine) }.map_err(|refusal| refusal.to_string())?;
        if path.is_null() {
            return Err("no INI file was named".to_owned());
        }
        // SAFETY: the caller promises that the string ends.
        compared(machine, unsafe { CStr::from_ptr(path) })
    }));
    let (count, text) = match compared {
        Ok(Ok(lines)) => (i32::try_from(lines.len()).unwrap_or(i32::MAX), lines.join("\n")),
        Ok(Err(reason)) => (-1, reason),
        Err(_) => (-1, RefusalCode::Internal.text().to_owned()),
    };
    // SAFETY: the caller promises `size` bytes.
    unsafe { write_text(&text, message, size) };
    count
}

/// Returns the differences of an INI file from a machine as texts.
fn compared(machine: &MachineKinematics, path: &CStr) -> Result<Vec<String>, String> {
    let path = path.to_str().map_err(|error| format!("the INI file: {error}"))?;
    let reading = |error| format!("reading the INI file {path}: {error}");
    let text = std::fs::read_to_string(path).map_err(reading)?;
    let found = ini_differences(machine.machine(), &text).map_err(|error| error.to_string())?;
    Ok(found.iter().map(ToString::to_string).collect())
}

/// Switches to plain axes (0) or tool-centre-point control (1), with the length of the tool in the spindle.
///
/// # Safety
///
/// `machine` is open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_switch(
    machine: *mut Trunnion,
    mode: i32,
    tool_length: f64,
) -> TrunnionStatus {
    guarded(|| {
        // SAFETY: the caller promises that the machine is open and used by this thread alone.
        let machine = unsafe { machine.as_mut() }.ok_or(INTERNAL)?;
        machine.kinematics.switch(KinematicsMode::from_number(mode)?, tool_length)?;
        Ok(TrunnionStatus::DONE)
    })
}

/// Computes the words at which the machine stands, by its joints. Takes a changed tool length over where no axis has
/// to jump for it.
///
/// # Safety
///
/// `machine` is open; `joints` holds `TRUNNION_AXES` numbers, `words` has room for as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_forward(
    machine: *mut Trunnion,
    tool_length: f64,
    joints: *const f64,
    words: *mut f64,
) -> TrunnionStatus {
    guarded(|| {
        // SAFETY: the caller promises that the machine is open and used by this thread alone.
        let machine = unsafe { machine.as_mut() }.ok_or(INTERNAL)?;
        // SAFETY: the caller promises the numbers.
        let joints = unsafe { numbers(joints) }.ok_or(INTERNAL)?;
        let found = machine.kinematics.forward(tool_length, &joints.into())?;
        // SAFETY: the caller promises the room.
        Ok(unsafe { put(words.cast::<[f64; TRUNNION_AXES]>(), found.into()) })
    })
}

/// Computes the joints for words. Outside travel the joints are returned with code 1 and the axis; with every other
/// code they are left as they were.
///
/// # Safety
///
/// As `trunnion_forward`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_inverse(
    machine: *mut Trunnion,
    words: *const f64,
    joints: *mut f64,
) -> TrunnionStatus {
    guarded(|| {
        // SAFETY: the caller promises that the machine is open and used by this thread alone.
        let machine = unsafe { machine.as_mut() }.ok_or(INTERNAL)?;
        // SAFETY: the caller promises the numbers.
        let words = unsafe { numbers(words) }.ok_or(INTERNAL)?;
        let reached = machine.kinematics.inverse(&words.into())?;
        // SAFETY: the caller promises the room.
        let put = unsafe { put(joints.cast::<[f64; TRUNNION_AXES]>(), reached.joints.into()) };
        Ok(reached.excess.map_or(put, |excess| Refusal::from(excess).into()))
    })
}

/// Computes the tool pose in the table frame, by joints.
///
/// # Safety
///
/// `machine` is open; `joints` holds `TRUNNION_AXES` numbers, `pose` has room for `TRUNNION_POSE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_pose(
    machine: *const Trunnion,
    tool_length: f64,
    joints: *const f64,
    pose: *mut f64,
) -> TrunnionStatus {
    guarded(|| {
        // SAFETY: the caller promises that the machine is open.
        let machine = unsafe { kinematics(machine) }?;
        // SAFETY: the caller promises the numbers.
        let joints = unsafe { numbers::<TRUNNION_AXES>(joints) }.ok_or(INTERNAL)?;
        let ToolPose { tip, axis } = machine.pose(tool_length, &joints.into());
        let numbers = [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z];
        // SAFETY: the caller promises the room.
        Ok(unsafe { put(pose.cast::<[f64; TRUNNION_POSE]>(), numbers) })
    })
}

/// Computes the joints for a tool pose, inside travel, on the branch and turn nearest to the joints `near`. The
/// direction of the pose may have any length but zero.
///
/// # Safety
///
/// `machine` is open; `pose` holds `TRUNNION_POSE` numbers, `near` holds `TRUNNION_AXES`, `joints` has room for as many
/// and may be `near`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trunnion_nearest(
    machine: *const Trunnion,
    tool_length: f64,
    pose: *const f64,
    near: *const f64,
    joints: *mut f64,
) -> TrunnionStatus {
    guarded(|| {
        // SAFETY: the caller promises that the machine is open.
        let machine = unsafe { kinematics(machine) }?;
        // SAFETY: the caller promises the numbers.
        let [x, y, z, i, j, k] = unsafe { numbers::<TRUNNION_POSE>(pose) }.ok_or(INTERNAL)?;
        // SAFETY: the caller promises the numbers.
        let near = unsafe { numbers::<TRUNNION_AXES>(near) }.ok_or(INTERNAL)?;
        let axis = UnitVector3::try_new(Vector3::new(i, j, k), 0.0);
        let axis = axis.ok_or(Refusal::new(RefusalCode::NotFinite))?;
        let pose = ToolPose { tip: Point3::new(x, y, z), axis };
        let found: AxisVector = machine.nearest(tool_length, &pose, &near.into())?;
        // SAFETY: the caller promises the room.
        Ok(unsafe { put(joints.cast::<[f64; TRUNNION_AXES]>(), found.into()) })
    })
}

/// Returns the text of a refusal's number; it lives as long as the program.
#[unsafe(no_mangle)]
pub extern "C" fn trunnion_refusal_text(code: i32) -> *const c_char {
    let known = RefusalCode::from_number(code).unwrap_or(RefusalCode::Internal);
    known.c_text().as_ptr().cast()
}

/// Refusal of a null pointer.
const INTERNAL: Refusal = Refusal::new(RefusalCode::Internal);

/// Runs a call so that no panic reaches C. None is known; where one is found it becomes a refusal.
fn guarded(call: impl FnOnce() -> Result<TrunnionStatus, Refusal>) -> TrunnionStatus {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(status)) => status,
        Ok(Err(refusal)) => refusal.into(),
        Err(_) => TrunnionStatus::INTERNAL,
    }
}

/// Loads a machine by a string of the caller.
///
/// # Safety
///
/// `text` is null or ends with a zero byte; `message` is null or points to `size` writable bytes.
unsafe fn load(
    text: *const c_char,
    by: fn(&str) -> Result<MachineKinematics, LoadError>,
    message: *mut c_char,
    size: usize,
) -> *mut Trunnion {
    let loaded = catch_unwind(AssertUnwindSafe(|| {
        if text.is_null() {
            return Err("no machine was named; load with machine=PATH".to_owned());
        }
        // SAFETY: the caller promises that the string ends.
        let text = unsafe { CStr::from_ptr(text) };
        let text = text.to_str().map_err(|error| format!("the machine file: {error}"))?;
        by(text).map_err(|error| error.to_string())
    }));
    let reason = match loaded {
        Ok(Ok(machine)) => {
            let kinematics = SwitchedKinematics::new(machine);
            return Box::into_raw(Box::new(Trunnion { kinematics }));
        }
        Ok(Err(reason)) => reason,
        Err(_) => RefusalCode::Internal.text().to_owned(),
    };
    // SAFETY: the caller promises `size` bytes.
    unsafe { write_text(&reason, message, size) };
    std::ptr::null_mut()
}

/// Writes as much of a text as fits, with a zero byte behind it.
///
/// # Safety
///
/// `message` is null or points to `size` writable bytes.
unsafe fn write_text(text: &str, message: *mut c_char, size: usize) {
    let (false, Some(most)) = (message.is_null(), size.checked_sub(1)) else { return };
    let mut length = most.min(text.len());
    while !text.is_char_boundary(length) {
        length -= 1;
    }
    // SAFETY: `length < size` bytes are copied into the caller's `size`, from a text that has as many.
    unsafe { std::ptr::copy_nonoverlapping(text.as_ptr().cast(), message, length) };
    // SAFETY: `length` is at most `size - 1`.
    unsafe { message.add(length).write(0) };
}

/// Returns the kinematics of an open machine.
///
/// # Safety
///
/// `machine` is null or open.
unsafe fn kinematics<'a>(machine: *const Trunnion) -> Result<&'a MachineKinematics, Refusal> {
    // SAFETY: the caller promises that it is open.
    let machine = unsafe { machine.as_ref() }.ok_or(INTERNAL)?;
    Ok(machine.kinematics.machine())
}

/// Reads numbers of the caller.
///
/// # Safety
///
/// `from` is null or points to `N` numbers.
unsafe fn numbers<const N: usize>(from: *const f64) -> Option<[f64; N]> {
    // SAFETY: the caller promises the numbers; an array of them is as they lie.
    unsafe { from.cast::<[f64; N]>().as_ref() }.copied()
}

/// Writes a value to where the caller has room for it.
///
/// # Safety
///
/// `to` is null or writable, and aligned.
unsafe fn put<T>(to: *mut T, value: T) -> TrunnionStatus {
    if to.is_null() {
        return TrunnionStatus::INTERNAL;
    }
    // SAFETY: it is not null, and the caller promises the rest.
    unsafe { to.write(value) };
    TrunnionStatus::DONE
}
