//! The switch between plain axes and tool-centre-point control, and changes of the tool length.

use trunnion::types::AxisVector;
use trunnion_rt::{KinematicsMode, RefusalCode, SwitchedKinematics, machine_named};

fn tilted() -> AxisVector {
    AxisVector::from([-300.0, -200.0, -220.0, 0.3, 0.5])
}

fn upright() -> AxisVector {
    AxisVector::from([-300.0, -200.0, -220.0, 0.3, 0.0])
}

fn trunnion_table() -> SwitchedKinematics {
    SwitchedKinematics::new(machine_named("bc-trunnion").unwrap())
}

#[test]
fn plain_axes_come_first() {
    let mut kinematics = trunnion_table();
    assert_eq!(kinematics.mode(), KinematicsMode::Axes);
    assert_eq!(kinematics.forward(120.0, &tilted()).unwrap(), tilted());
    assert_eq!(kinematics.inverse(&tilted()).unwrap().joints, tilted());
}

#[test]
fn a_switch_moves_no_joint() {
    let mut kinematics = trunnion_table();
    for mode in [KinematicsMode::ToolCenterPoint, KinematicsMode::Axes] {
        kinematics.switch(mode, 120.0).unwrap();
        let words = kinematics.forward(120.0, &tilted()).unwrap();
        let joints = kinematics.inverse(&words).unwrap().joints;
        assert!((joints - tilted()).amax() < 1e-9, "{mode:?}");
    }
}

#[test]
fn a_length_is_taken_at_once_while_the_tool_stands_upright() {
    let mut kinematics = trunnion_table();
    kinematics.switch(KinematicsMode::ToolCenterPoint, 0.0).unwrap();
    let before = kinematics.forward(0.0, &upright()).unwrap();
    let after = kinematics.forward(120.0, &upright()).unwrap();
    assert!((before - after).amax() < 1e-10);
    // The next tilted words count with it.
    let words = kinematics.machine().words(120.0, &tilted());
    assert!((kinematics.inverse(&words).unwrap().joints - tilted()).amax() < 1e-9);
}

#[test]
fn a_length_that_would_make_axes_jump_is_refused_until_the_control_has_stopped() {
    let mut kinematics = trunnion_table();
    kinematics.switch(KinematicsMode::ToolCenterPoint, 0.0).unwrap();
    let words = kinematics.forward(0.0, &tilted()).unwrap();
    // G43 with the tool tilted: the control still counts with the old length, and the next inverse refuses.
    assert_eq!(kinematics.forward(120.0, &tilted()).unwrap(), words);
    assert_eq!(kinematics.forward(120.0, &tilted()).unwrap(), words);
    let refused = kinematics.inverse(&words).unwrap_err();
    assert_eq!(refused.code, RefusalCode::LengthChanged);
    // The control has stopped and asks where the machine stands.
    let words = kinematics.forward(120.0, &tilted()).unwrap();
    let joints = kinematics.inverse(&words).unwrap().joints;
    assert!((joints - tilted()).amax() < 1e-9);
}

#[test]
fn a_length_that_comes_back_is_no_change() {
    let mut kinematics = trunnion_table();
    kinematics.switch(KinematicsMode::ToolCenterPoint, 50.0).unwrap();
    let words = kinematics.forward(50.0, &tilted()).unwrap();
    kinematics.forward(120.0, &tilted()).unwrap();
    kinematics.forward(50.0, &tilted()).unwrap();
    assert!((kinematics.inverse(&words).unwrap().joints - tilted()).amax() < 1e-9);
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mut kinematics = trunnion_table();
    assert!(kinematics.switch(KinematicsMode::ToolCenterPoint, f64::NAN).is_err());
    assert_eq!(kinematics.mode(), KinematicsMode::Axes);
    let mut joints = tilted();
    joints[4] = f64::NAN;
    assert_eq!(kinematics.forward(0.0, &joints).unwrap_err().code, RefusalCode::NotFinite);
    assert_eq!(kinematics.inverse(&joints).unwrap_err().code, RefusalCode::NotFinite);
    assert_eq!(KinematicsMode::from_number(2).unwrap_err().code, RefusalCode::UnknownMode);
}
