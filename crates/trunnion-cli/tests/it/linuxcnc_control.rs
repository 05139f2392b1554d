//! What a program asks of a control beside motion, with the planner of trunnion as with the stock planner: probes, outputs,
//! arcs, files that do not fit.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::trunnion;
use crate::linuxcnc_run::{Control, Plan, Run, wait_for_the_task};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The table on which `LinuxCNC`'s own planner was timed.
const TIMED_MACHINE: &str = include_str!("../../../../fixtures/linuxcnc/timed-table.toml");

/// A probe that closes where Z is below -5 mm.
const PROBE: &str = "loadrt comp count=1
addf comp.0 servo-thread
setp comp.0.in1 -5
net sampled-z => comp.0.in0
net probe comp.0.out => motion.probe-input
";

/// Writes a configuration of the timed machine with a planner.
fn configuration(folder: &Path, planner: &str) {
    fs::write(folder.join("timed.toml"), TIMED_MACHINE).unwrap();
    let arguments =
        ["linuxcnc", "timed.toml", "-o", planner, "--planner", planner, "--tool-length", "0"];
    assert!(trunnion(folder, &arguments).status.success());
}

/// Runs a program on the timed machine with a planner.
fn run(control: &Control, planner: &str, text: &str, hal: &str) -> (Run, Option<String>) {
    let temporary = tempfile::tempdir().unwrap();
    configuration(temporary.path(), planner);
    let plan = Plan {
        ini: "ac-trunnion.ini",
        program: text,
        start: &["G21 G90 G94 G40 G49 G54", "G10 L2 P1 X0 Y0 Z0 A0 C0 R0"],
        letters: "xyzac",
        seconds: 90,
        actions: &[],
        pins: &[],
        hal,
    };
    let work = temporary.path().join(planner);
    let run = control.run(&work, &plan);
    eprintln!("{planner}: lines {}, at {:?}", run.values["lines"], cycles(&run).last());
    (run, fs::read_to_string(work.join("probed.txt")).ok())
}

/// Numbers of a sampled cycle.
fn cycles(run: &Run) -> Vec<Vec<f64>> {
    let lines = run.samples.lines().filter(|line| !line.contains("overrun"));
    lines
        .map(|line| line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect())
        .collect()
}

/// Words of X, Y and Z, and outputs among the sampled numbers.
const X: usize = 5;
const DIGITAL: [usize; 2] = [12, 13];
const ANALOG: usize = 14;

/// Towards a surface and away from it, with contact and without: the same places and results as with the stock planner.
#[test]
fn probes_find_what_they_find_with_the_stock_planner() {
    let Some(control) = Control::ready() else { return };
    let text = "G21 G90 G94 G49 G64 P0.01
(LOGOPEN,probed.txt)
G0 X0 Y0 Z0
G38.2 Z-20 F120
(LOG,#5070 #5063)
G38.4 Z0 F120
(LOG,#5070 #5063)
G0 Z0
G38.3 X10 F600
(LOG,#5070 #5061)
G38.3 Z-20 F120
(LOG,#5070 #5063)
G38.5 Z0 F120
(LOG,#5070 #5063)
(LOGCLOSE)
G0 Z0
G38.2 X30 F600
G0 X40
M2
";
    let mut all = Vec::new();
    for planner in ["stock", "trunnion"] {
        let (run, log) = run(&control, planner, text, PROBE);
        let found: Vec<[f64; 2]> = log
            .unwrap_or_default()
            .lines()
            .map(|line| {
                let numbers: Vec<f64> =
                    line.split_whitespace().map(|word| word.parse().unwrap()).collect();
                [numbers[0], numbers[1]]
            })
            .collect();
        eprintln!("{planner}: {found:?}, {:?}", run.errors);
        // Without contact the last probe is an error, and the program ends before what follows.
        assert!(!run.ended && run.errors.join(" ").contains("without making contact"), "{planner}");
        let end = cycles(&run).last().unwrap()[X];
        assert!((end - 30.0).abs() < 1e-3, "{planner}: {end}");
        all.push(found);
    }
    assert_eq!(all[0].len(), 5);
    for (stock, own) in all[0].iter().zip(&all[1]) {
        assert!((stock[0] - own[0]).abs() < 1e-9, "{stock:?} {own:?}");
        // A cycle at 2 mm/s, and six decimals.
        assert!((stock[1] - own[1]).abs() < 0.005, "{stock:?} {own:?}");
    }
}

/// Blocks of 0.4 mm from X 20 on: every third one switches an output, every fourth one sets the analogue output to its
/// number.
fn short_blocks() -> String {
    let mut text = String::new();
    for block in 0..BLOCKS {
        if block % 3 == 0 {
            writeln!(text, "M{} P0", if block % 2 == 0 { 62 } else { 63 }).unwrap();
        }
        if block % 4 == 0 {
            writeln!(text, "M67 E0 Q{}", block + 1).unwrap();
        }
        writeln!(text, "G1 X{:.1}", 20.0 + 0.4 * f64::from(block + 1)).unwrap();
    }
    text
}

/// Number of short blocks.
const BLOCKS: u32 = 90;

/// Outputs that belong to a block change in the cycle in which the tool passes its beginning, without a stop, though
/// blocks are short beside the steps of the plan, and are merged where nothing is between them.
#[test]
fn outputs_change_at_the_beginning_of_their_block() {
    let Some(control) = Control::ready() else { return };
    let text = format!(
        "G21 G90 G94 G49 G64 P0.01\nG0 X0 Y0 Z0\nF3000\nG1 X20\n{}M62 P1\nG1 X80\nM65 P1\nM68 E0 Q-1\nG1 X100\nM2\n",
        short_blocks()
    );
    let (run, _) = run(&control, "trunnion", &text, "");
    assert!(run.errors.is_empty() && run.ended, "{:?}\n{}", run.errors, run.log);
    let cycles = cycles(&run);
    let changes = |of: usize| -> Vec<[f64; 2]> {
        let two = cycles.windows(2).filter(|two| (two[1][of] - two[0][of]).abs() > 1e-6);
        two.map(|two| [two[1][X], two[1][of]]).collect()
    };
    let [first, second, analog] = [DIGITAL[0], DIGITAL[1], ANALOG].map(changes);
    eprintln!("{first:?} {second:?} {analog:?}");
    let meets = |found: &[f64; 2], wanted: [f64; 2]| {
        // 50 mm/s are 0.05 mm a cycle, and the sample of the words is a cycle late.
        (found[0] - wanted[0]).abs() < 0.12 && (found[1] - wanted[1]).abs() < 1e-6
    };
    let place = |block: u32| 20.0 + 0.4 * f64::from(block);
    let switches = (0..BLOCKS).step_by(3);
    let wanted: Vec<[f64; 2]> =
        switches.map(|block| [place(block), f64::from((block + 1) % 2)]).collect();
    assert_eq!(first.len(), wanted.len());
    assert!(first.iter().zip(&wanted).all(|(found, wanted)| meets(found, *wanted)), "{wanted:?}");
    let sets = (0..BLOCKS).step_by(4);
    let mut wanted: Vec<[f64; 2]> =
        sets.map(|block| [place(block), f64::from(block + 1)]).collect();
    // M65 and M68 take effect when they are read: the tool stands at 80 mm then.
    wanted.push([80.0, -1.0]);
    assert_eq!(analog.len(), wanted.len());
    assert!(analog.iter().zip(&wanted).all(|(found, wanted)| meets(found, *wanted)), "{wanted:?}");
    let [on, off] = [[place(BLOCKS), 1.0], [80.0, 0.0]];
    assert!(second.len() == 2 && meets(&second[0], on) && meets(&second[1], off));
    let stands = |from: f64, to: f64| {
        let near = |two: &&[Vec<f64>]| (from..to).contains(&two[1][X]);
        let still = |two: &[Vec<f64>]| (two[1][X] - two[0][X]).abs() < 1e-7;
        cycles.windows(2).filter(near).filter(|two| still(two)).count()
    };
    assert_eq!(stands(10.0, 79.8), 0);
    assert!(stands(79.8, 80.2) > 0);
}

/// Full circles, a helix, arcs that are tangential to lines, a spiral, moves of a millionth of a millimetre and of nothing.
#[test]
fn arcs_are_run_within_the_tolerance_and_tiny_moves_do_no_harm() {
    let Some(control) = Control::ready() else { return };
    let text = "G21 G90 G94 G49 G17 G64 P0.01
G0 X20 Y0 Z0
F3000
G2 X20 Y0 I-20
G3 X20 Y0 Z-10 I-20 P2
G1 X20 Y10
G3 X10 Y20 I-10
G1 X-10
G3 X-20 Y10 J-10
G1 Y0
G18
G2 X-40 Z-10 I-10
G17
G1 X-40.000001
G1 X-40.000001
G1 X-40.00001 Y0.000001
G0 X-40.00001 Y0.000001
G91
G1 X0
G1 X0.000002 Y0.000001
G90
G1 X-40 Y5
M2
";
    let (run, _) = run(&control, "trunnion", text, "");
    assert!(run.errors.is_empty() && run.ended, "{:?}\n{}", run.errors, run.log);
    let cycles = cycles(&run);
    // Both circles about the origin are run before anything leaves them by Y above 1e-3 at X 20.
    let circle = cycles.iter().skip_while(|of| of[X] < 19.999).take_while(|of| {
        let radius = of[X].hypot(of[X + 1]);
        (radius - 20.0).abs() < 1.0
    });
    let (mut count, mut turned, mut worst) = (0, 0.0_f64, 0.0_f64);
    let mut before: Option<f64> = None;
    for of in circle {
        let angle = of[X + 1].atan2(of[X]);
        if let Some(before) = before.replace(angle) {
            let turn = angle - before;
            turned += (turn.abs()).min((turn.abs() - std::f64::consts::TAU).abs());
        }
        count += 1;
        if of[X + 1].abs() > 1.0 || of[X] < 0.0 {
            worst = worst.max((of[X].hypot(of[X + 1]) - 20.0).abs());
        }
        if turned > 3.0 * std::f64::consts::TAU - 0.2 {
            break;
        }
    }
    eprintln!("{count} cycles on the circles, off by {worst:.5} mm, {turned:.2} rad");
    assert!(turned > 3.0 * std::f64::consts::TAU - 0.2, "{turned}");
    assert!(worst <= 0.01, "{worst}");
    let end = cycles.last().unwrap();
    assert!((end[X] + 40.0).abs() < 1e-5 && (end[X + 1] - 5.0).abs() < 1e-5, "{end:?}");
}

/// A program that begins outside the travel, with plain axes and with the tip: the operator reads line, axis and remedy, and
/// no joint moves.
#[test]
fn a_program_that_starts_outside_the_travel_is_refused_before_it_moves() {
    let Some(control) = Control::ready() else { return };
    for (kind, text, line) in [
        ("plain axes", "G21 G90 G94 G49 G64 P0.01\n(a remark)\nG0 X700\nG0 X0\nM2\n", 3),
        ("tip", "G21 G90 G94 G49 G64 P0.01\nM428\nG0 X0 Y0 Z0 C90\nG1 X20 Y700 F3000\nM2\n", 4),
    ] {
        let (run, _) = run(&control, "trunnion", text, "");
        let said = run.errors.join("\n");
        eprintln!("{kind}: {said}");
        assert!(!run.ended && said.contains(&format!("line {line}")), "{said}");
        assert!(
            said.contains("(X) by 200.0000 mm: an axis would leave its travel; move the workpiece"),
            "{said}"
        );
        let outside = cycles(&run).into_iter().flat_map(|cycle| cycle[..3].to_vec());
        // Joints are sampled a million times as large.
        assert!(outside.fold(0.0, |most: f64, joint| most.max(joint.abs())) < 1e-3 * 1e6, "{kind}");
    }
}

/// A module that cannot read its machine file, or whose file has other joints than the INI file, says so at the start.
#[test]
fn files_that_do_not_fit_are_named_at_the_start() {
    let Some(control) = Control::ready() else { return };
    for (from, to, says) in [
        ("trunniontp machine=ac-trunnion.toml", "trunniontp machine=missing.toml", "missing.toml"),
        (
            "trunnionkins machine=ac-trunnion.toml",
            "trunnionkins machine=missing.toml",
            "missing.toml",
        ),
        ("ac-trunnion.toml coordinates=XYZAC", "ac-trunnion.toml coordinates=XYZBC", "no axis B"),
        // Joints that are narrower than the axes, which are planned with.
        ("LINEAR_UNITS = mm", "LINEAR_UNITS = inch", "[TRAJ]LINEAR_UNITS = inch: "),
        ("TYPE = ANGULAR", "TYPE = LINEAR", "[JOINT_3]TYPE = LINEAR: axis A "),
        (
            "[JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = -500\n",
            "[JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = -400\n",
            "[JOINT_0]MIN_LIMIT = -400: axis X of the machine file goes on to -500 mm; write",
        ),
        ("MAX_VELOCITY = 100\n", "MAX_VELOCITY = 90\n", "[JOINT_3]MAX_VELOCITY = 90: axis A "),
        ("= 5000\nFERROR", "= 4000\nFERROR", "[JOINT_0]MAX_ACCELERATION = 4000: axis X "),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        configuration(temporary.path(), "trunnion");
        let work = temporary.path().join("trunnion");
        let ini = work.join("ac-trunnion.ini");
        wait_for_the_task(&ini);
        let text = fs::read_to_string(&ini).unwrap();
        assert!(text.contains(from), "{text}");
        fs::write(&ini, text.replace(from, to)).unwrap();
        let (code, log) = control.start(&work, "ac-trunnion.ini", 120);
        let of_kinematics = to.contains("trunnionkins") || to.contains("coordinates");
        let module = if of_kinematics { "trunnionkins" } else { "trunniontp" };
        let says = |line: &&str| line.starts_with(&format!("{module}: ")) && line.contains(says);
        let line = log.lines().find(says);
        eprintln!("{to}: {code:?}, {line:?}");
        assert!(code != Some(0) && !log.contains("the task answers"), "{to}: {log}");
        assert!(line.is_some(), "{module} {to}: {log}");
    }
}
