//! Joints, words and poses against the library's own forward map and inverse, for every built-in machine.

use crate::walk::{Dice, machines};
use std::f64::consts::PI;
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nalgebra::{UnitVector3, Vector3};
use trunnion::types::{AxisVector, ToolPose};
use trunnion_rt::{MachineKinematics, Refusal, RefusalCode, machine_from_text, machine_named};

const LENGTHS: [f64; 3] = [0.0, 83.5, 250.0];

/// The library's kinematics with the length in the setup.
fn with_length(machine: &Machine, length: f64) -> Inverse {
    let setup = Setup { tool_length: length, ..Setup::default() };
    Inverse::new(&Kinematics::new(machine, &setup)).unwrap()
}

#[test]
fn poses_are_those_of_the_library_for_any_length() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let mut dice = Dice::new(1);
        for length in LENGTHS {
            let library = with_length(&machine, length);
            for _ in 0..500 {
                let joints = dice.joints(&machine);
                let [ours, wanted] =
                    [rt.pose(length, &joints), library.kinematics().forward(&joints)];
                assert!((ours.tip - wanted.tip).norm() < 1e-9, "{}", machine.name);
                assert!((*ours.axis - *wanted.axis).norm() < 1e-14, "{}", machine.name);
            }
        }
    }
}

#[test]
fn the_inverse_takes_the_branch_of_the_library() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let mut dice = Dice::new(2);
        let mut refused = 0;
        for length in LENGTHS {
            let library = with_length(&machine, length);
            for _ in 0..500 {
                let near = dice.joints(&machine);
                let pose = rt.pose(length, &dice.joints(&machine));
                let wanted = library.continued(&pose, &near);
                match (rt.nearest(length, &pose, &near), wanted) {
                    (Ok(joints), Ok(wanted)) => {
                        assert!((joints - wanted.q).amax() < 1e-7, "{}", machine.name);
                    }
                    (Err(_), Err(_)) => refused += 1,
                    (ours, wanted) => panic!("{}: {ours:?} {wanted:?}", machine.name),
                }
            }
        }
        // Every pose comes from joints inside travel.
        assert_eq!(refused, 0, "{}", machine.name);
    }
}

#[test]
fn the_branch_goes_on_along_a_path() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        for seed in 0..10 {
            let mut dice = Dice::new(100 + seed);
            let [from, to] = [dice.joints(&machine), dice.joints(&machine)];
            let mut joints = from;
            // A rotary goes by three turns at most: 20000 steps are finer than a servo cycle.
            let steps = 20_000;
            for step in 1..=steps {
                let wanted = from + (to - from) * (f64::from(step) / f64::from(steps));
                let pose = rt.pose(120.0, &wanted);
                joints = rt.nearest(120.0, &pose, &joints).unwrap();
                assert!((joints - wanted).amax() < 1e-6, "{} {seed} {step}", machine.name);
            }
        }
    }
}

#[test]
fn words_lead_back_to_the_joints() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let mut dice = Dice::new(3);
        for length in LENGTHS {
            for _ in 0..500 {
                let joints = dice.joints(&machine);
                let words = rt.words(length, &joints);
                let reached = rt.joints(length, &words).unwrap();
                assert!((reached.joints - joints).amax() < 1e-8, "{}", machine.name);
            }
        }
    }
}

/// The programs of `trunnion run`: the tip in the table frame from the workpiece origin, with the origin in G54 and the
/// length along Z.
#[test]
fn words_are_those_that_programs_are_written_with() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let mut dice = Dice::new(4);
        let origin = Vector3::new(-310.0, 45.5, -200.0);
        let setup = Setup::new(origin, [0.1, -0.2, 0.3], 97.25);
        let workpiece = Kinematics::new(&machine, &setup);
        // All built-in machines have linear axes along the machine frame.
        let offset = origin - machine.gauge.coords;
        for _ in 0..500 {
            let joints = dice.joints(&machine);
            let written = setup.rotation * workpiece.forward(&joints).tip.coords;
            let words = rt.words(97.25, &joints);
            let xyz = written + offset + Vector3::z() * 97.25;
            assert!((words.fixed_rows::<3>(0) - xyz).norm() < 1e-9, "{}", machine.name);
            assert_eq!(words.fixed_rows::<2>(3), joints.fixed_rows::<2>(3));
        }
    }
}

#[test]
fn with_the_rotaries_at_zero_words_are_joints() {
    for machine in machines() {
        let rt = MachineKinematics::new(&machine).unwrap();
        let joints = AxisVector::from([10.0, -20.0, 30.0, 0.0, 0.0]);
        assert!((rt.words(140.0, &joints) - joints).amax() < 1e-10, "{}", machine.name);
    }
}

#[test]
fn joints_outside_travel_come_with_their_axis() {
    let rt = machine_named("bc-trunnion").unwrap();
    let words = rt.words(100.0, &AxisVector::from([-300.0, -200.0, 12.5, 0.4, 0.3]));
    let excess = rt.joints(100.0, &words).unwrap().excess.unwrap();
    assert_eq!(excess.index, 2);
    assert!((excess.excess - 12.5).abs() < 1e-9);
}

#[test]
fn reasons_are_numbers_with_texts() {
    let rt = machine_named("bc-trunnion").unwrap();
    let near = AxisVector::from([-381.0, -254.0, -250.0, 0.0, 0.1]);
    let pose = |tip: [f64; 3], axis: [f64; 3]| ToolPose {
        tip: tip.into(),
        axis: UnitVector3::new_normalize(axis.into()),
    };
    let code = |refused: Result<AxisVector, Refusal>| refused.unwrap_err().code;
    let inside = [-381.0, -254.0, -500.0];
    let far = rt.nearest(100.0, &pose([9000.0, 0.0, 0.0], [0.2, 0.0, 1.0]), &near);
    assert_eq!(code(far), RefusalCode::OutOfTravel);
    // Straight down needs B = 180, beyond the travel of both branches.
    let down = rt.nearest(100.0, &pose(inside, [0.01, 0.0, -1.0]), &near);
    assert_eq!(code(down), RefusalCode::OutOfTravel);
    let nan = rt.nearest(100.0, &pose([f64::NAN, 0.0, 0.0], [0.0, 0.1, 1.0]), &near);
    assert_eq!(code(nan), RefusalCode::NotFinite);
    assert_eq!(rt.joints(f64::INFINITY, &near).unwrap_err().code, RefusalCode::NotFinite);
    let nutating = machine_named("dmu-nutating45").unwrap();
    let below = nutating.nearest(100.0, &pose(inside, [0.0, 0.0, -1.0]), &near).unwrap_err();
    assert_eq!(below.code, RefusalCode::Unreachable);
    assert!(below.excess > 0.1 && below.excess < PI, "{}", below.excess);
    for number in 0..9 {
        let code = RefusalCode::from_number(number).unwrap();
        assert_eq!(code as i32, number);
        assert!(code.text().len() > 10 && !code.text().contains('\0'));
    }
    assert_eq!(RefusalCode::from_number(9), None);
    assert_eq!(RefusalCode::from_number(-1), None);
}

#[test]
fn machine_files_are_refused_with_place_and_remedy() {
    let faulty = machine_from_text("schema = \"trunnion-machine/1\"\nchian = []\n").unwrap_err();
    assert!(faulty.to_string().contains("2:1"), "{faulty}");
    let missing = machine_named("no/such/machine.toml").unwrap_err();
    assert!(missing.to_string().contains("trunnion machine list"), "{missing}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.toml");
    let (_, text) = trunnion::files::machine::BUILT_IN[1];
    std::fs::write(&path, text).unwrap();
    let read = machine_named(path.to_str().unwrap()).unwrap();
    assert_eq!(read, machine_named("bc-trunnion").unwrap());
    let other = text.replace("modulo = \"unwound\" }", "letter = \"W\" }");
    let refused = machine_from_text(&other).unwrap_err().to_string();
    assert!(refused.contains("letter W") && refused.contains("A, B or C"), "{refused}");
}
