//! The planner of trunnion in `LinuxCNC`: times, limits of the joints, contour, and what the operator does.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::trunnion;
use crate::linuxcnc_run::{Action, Control, Plan, Run};
use crate::rs274::examples_with;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use trunnion::files::machine::{built_in, parse};
use trunnion::machine::Machine;

/// Pins that the tests read at the end.
const PINS: [&str; 5] = [
    "trunniontp.cycle-ns-max",
    "trunniontp.plan-longest",
    "trunniontp.plan-worked",
    "trunniontp.plan-late",
    "trunniontp.fault",
];

/// The table on which `LinuxCNC`'s own planner was timed.
const TIMED_MACHINE: &str = include_str!("../../../../fixtures/linuxcnc/timed-table.toml");

/// X Z A of a pass over a waved surface, the tool leaning 20 degrees ahead, in blocks of so many mm.
fn pass(step: f64) -> Vec<[f64; 3]> {
    let wave = std::f64::consts::TAU / 80.0;
    let mut points = Vec::new();
    let mut x = 0.0_f64;
    loop {
        let at = x.min(250.0);
        let slope = 3.0 * wave * (wave * at).cos();
        // Four decimals, as programs have.
        let rounded = |value: f64| (value * 1e4).round() / 1e4;
        let tilt = 20.0 - slope.atan().to_degrees();
        points.push([at, 3.0 * (wave * at).sin(), tilt].map(rounded));
        if at >= 250.0 {
            return points;
        }
        x += step / slope.hypot(1.0);
    }
}

/// The pass as a program with tool-centre-point control, with `lines` among its blocks.
fn program(points: &[[f64; 3]], lines: &[(usize, &str)]) -> String {
    let mut text = String::from("G21 G90 G94 G49 G64 P0.01\nM428\n");
    for (index, [x, z, a]) in points.iter().enumerate() {
        let code = if index == 0 { "G0 Y0 C90" } else { "G1 F3000" };
        for (_, line) in lines.iter().filter(|(at, _)| *at == index) {
            writeln!(text, "{line}").unwrap();
        }
        writeln!(text, "{code} X{x:.4} Z{z:.4} A{a:.4}").unwrap();
    }
    text.push_str("M2\n");
    text
}

/// The work offset that the head of a program asks for, as a line.
fn offset_line(program: &str) -> String {
    let line = program.lines().find(|line| line.contains("G54 must hold")).unwrap();
    let words = line.split("hold ").nth(1).unwrap().split(';').next().unwrap();
    format!("G10 L2 P1 {words} B0 C0 R0")
}

/// With `TRUNNION_TORTURE`, as it takes minutes: the pass of short blocks below always runs.
#[test]
fn both_examples_are_quicker_than_with_the_stock_planner() {
    if std::env::var_os("TRUNNION_TORTURE").is_none() {
        eprintln!("skipped: `just torture` runs both examples with the planner in LinuxCNC");
        return;
    }
    let Some(control) = Control::ready() else { return };
    for output in ["", "link_blocks = \"short\"\n"] {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        for (name, text) in examples_with(folder, output) {
            let seconds = run_example(&control, folder, &name, &text);
            let [planned, stock] = times(folder, &name);
            eprintln!(
                "{output}{name}: {seconds:.2} s, planned {planned:.2} s, stock planner {stock:.2} s"
            );
            // Corners of long chords on links are beyond what P lets be fast.
            assert!(output.is_empty() || seconds < 1.1 * planned, "{name}: {seconds} {planned}");
            assert!(seconds < stock, "{name}: {seconds} {stock}");
        }
    }
}

/// Planned time of a program, and that of the stock planner by a model of it that is right to 1 %.
fn times(folder: &Path, name: &str) -> [f64; 2] {
    let job = Path::new(name).parent().unwrap();
    let summary = fs::read_to_string(folder.join(job).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    ["planned", "linuxcnc"].map(|time| summary["times"][time].as_f64().unwrap())
}

/// Runs a program of an example, checks the limits, and returns its time on the planned motion.
fn run_example(control: &Control, folder: &Path, name: &str, text: &str) -> f64 {
    let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    let job = Path::new(name).parent().unwrap();
    let work = format!("{}-control", job.display());
    let planner = ["--planner", "trunnion", "--tool-length", "120"];
    let arguments = [&["linuxcnc", "bc-trunnion", "-o", &work][..], &planner].concat();
    assert!(trunnion(folder, &arguments).status.success());
    let plan = Plan {
        ini: "bc-trunnion.ini",
        program: text,
        start: &["G21 G90 G94 G40 G49 G54", &offset_line(text)],
        letters: "xyzbc",
        seconds: 300,
        actions: &[],
        pins: &PINS,
        hal: "",
    };
    let run = control.run(&folder.join(&work), &plan);
    assert!(run.errors.is_empty() && run.ended, "{name}: {:?}\n{}", run.errors, run.log);
    let motion = Motion::of(&run);
    let ratios = motion.ratios(&machine);
    let pins: Vec<String> = PINS.iter().map(|pin| format!("{pin} {}", run.values[*pin])).collect();
    eprintln!(
        "{name}: {:.2} s with the way to the start and home, predicted {:.2} s, ratios {ratios:.4?}, {}, {}",
        motion.moving(),
        predicted(folder, name),
        motion.cost(),
        pins.join(", ")
    );
    assert!(ratios.iter().all(|ratio| *ratio <= 1.001), "{name}: {ratios:?}");
    let (predicted, took) = (predicted(folder, name), motion.moving());
    assert!((predicted / took - 1.0).abs() < 0.1, "{name}: {predicted} {took}");
    motion.planned_part(first_place(text))
}

/// Time of a program with the planner, as `trunnion check` predicts it.
fn predicted(folder: &Path, name: &str) -> f64 {
    let arguments = [
        &["check", name, "--machine", "bc-trunnion", "--tool-length", "120"][..],
        &["--origin=-381,-254,-505", "--control", "linuxcnc-trunnion", "--json"],
    ];
    let checked = trunnion(folder, &arguments.concat());
    let summary: serde_json::Value = serde_json::from_slice(&checked.stdout).unwrap();
    summary["times"]["linuxcnc_trunnion"].as_f64().unwrap()
}

/// X Y Z of the control where the first block with a time begins: the tip, the work offset and the tool length together.
fn first_place(program: &str) -> [f64; 3] {
    let words = |line: &str| {
        ["X", "Y", "Z"].map(|letter| {
            let mut words = line.split_whitespace();
            words.find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok()).unwrap()
        })
    };
    let offset =
        words(&offset_line(program).replace("X ", "X").replace("Y ", "Y").replace("Z ", "Z"));
    let before = program.lines().take_while(|line| *line != "G93").last().unwrap();
    let tip = words(before);
    [tip[0] + offset[0], tip[1] + offset[1], tip[2] + offset[2] + 120.0]
}

/// Joints and X Y Z words of every cycle [mm and degrees], and the cycles with tool-centre-point control.
struct Motion {
    joints: Vec<[f64; 5]>,
    words: Vec<[f64; 3]>,
    tip: Vec<bool>,
    /// Time of planner and kinematics in a cycle [ns].
    costs: Vec<f64>,
}

impl Motion {
    fn of(run: &Run) -> Self {
        let (mut joints, mut words) = (Vec::new(), Vec::new());
        let (mut tip, mut costs) = (Vec::new(), Vec::new());
        for line in run.samples.lines().filter(|line| !line.contains("overrun")) {
            let numbers: Vec<f64> =
                line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
            joints.push(std::array::from_fn(|joint| numbers[joint] * 1e-6));
            words.push(std::array::from_fn(|letter| numbers[5 + letter]));
            tip.push(numbers[10] > 0.5);
            costs.push(numbers[11] + numbers[15]);
        }
        costs.sort_by(f64::total_cmp);
        Self { joints, words, tip, costs }
    }

    /// Time of a servo cycle in the median, below which 999 of 1000 are, and at most, in words.
    fn cost(&self) -> String {
        let at =
            |thousandths: usize| 1e-3 * self.costs[(self.costs.len() - 1) * thousandths / 1000];
        format!(
            "cycle {:.1} us in the median, 99.9 % below {:.1}, {:.1} at most",
            at(500),
            at(999),
            at(1000)
        )
    }

    /// Largest velocity, acceleration and jerk over their limits, from differences of cycles. Joints are X Y Z A C, and the
    /// machine file has C before A.
    fn ratios(&self, machine: &Machine) -> [f64; 3] {
        let order = [0, 1, 2, 4, 3];
        let mut values = self.joints.clone();
        [0, 1, 2].map(|derivative| {
            values = values
                .windows(2)
                .map(|two| std::array::from_fn(|joint| (two[1][joint] - two[0][joint]) * 1e3))
                .collect();
            let limit = |joint: usize| {
                let axis = &machine.axes[order[joint]];
                let limit = [axis.vel, axis.acc, axis.jerk][derivative];
                if joint < 3 { limit } else { limit.to_degrees() }
            };
            let shares =
                values.iter().flat_map(|all| (0..5).map(|joint| all[joint].abs() / limit(joint)));
            shares.fold(0.0, f64::max)
        })
    }

    /// Cycles in which a joint moves, in seconds.
    fn moving(&self) -> f64 {
        let moves =
            |two: &&[[f64; 5]]| (0..5).any(|joint| (two[1][joint] - two[0][joint]).abs() > 1e-9);
        self.joints.windows(2).filter(moves).count() as f64 * 1e-3
    }

    /// Cycles in motion with tool-centre-point control from a place on, in seconds.
    fn planned_part(&self, from: [f64; 3]) -> f64 {
        let distance = |cycle: &usize| {
            let words = self.words[*cycle];
            (0..3).map(|letter| (words[letter] - from[letter]).powi(2)).sum::<f64>()
        };
        let cycles = (1..self.words.len()).filter(|cycle| self.tip[*cycle]);
        // A later pass may come there again: the first time it comes within a millimetre and leaves counts.
        let (mut nearest, mut first) = (f64::INFINITY, 0);
        for (index, cycle) in cycles.clone().enumerate() {
            let square = distance(&cycle);
            if square < nearest {
                (nearest, first) = (square, index);
            } else if nearest < 1.0 && square > 25.0 {
                break;
            }
        }
        assert!(nearest < 1.0, "the program does not come to {from:?}");
        let moves = |cycle: &usize| {
            let [before, now] = [self.joints[cycle - 1], self.joints[*cycle]];
            (0..5).any(|joint| (now[joint] - before[joint]).abs() > 1e-9)
        };
        cycles.skip(first).filter(moves).count() as f64 * 1e-3
    }

    /// Cycles on the pass, in seconds.
    fn on_the_pass(&self) -> f64 {
        let inside = |words: &&[f64; 3]| words[0] > 1e-3 && words[0] < 249.999;
        self.words.iter().filter(inside).count() as f64 * 1e-3
    }

    /// Largest distance of the tip from the chords of the pass, over the cycles on it.
    fn contour(&self, points: &[[f64; 3]]) -> f64 {
        let mut worst = 0.0_f64;
        for [x, y, z] in self.words.iter().filter(|words| words[0] > 1e-3 && words[0] < 249.999) {
            let after = points.partition_point(|point| point[0] <= *x).clamp(1, points.len() - 1);
            let legs = after.saturating_sub(3)..(after + 2).min(points.len() - 1);
            let distance = |leg: usize| {
                let [from, to] = [points[leg], points[leg + 1]];
                let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
                let share = ((x - from[0]) * dx + (z - from[1]) * dz) / (dx * dx + dz * dz);
                let share = share.clamp(0.0, 1.0);
                (x - from[0] - share * dx).hypot(z - from[1] - share * dz).hypot(*y)
            };
            worst = worst.max(legs.map(distance).fold(f64::INFINITY, f64::min));
        }
        worst
    }
}

/// Runs a program on the timed machine with a planner.
fn run(control: &Control, folder: &Path, planner: &str, text: &str, actions: &[Action]) -> Run {
    fs::write(folder.join("timed.toml"), TIMED_MACHINE).unwrap();
    let work = folder.join(planner);
    let _ = fs::remove_dir_all(&work);
    let arguments =
        ["linuxcnc", "timed.toml", "-o", planner, "--planner", planner, "--tool-length", "0"];
    assert!(trunnion(folder, &arguments).status.success());
    let pins: &[&str] = if planner == "trunnion" { &PINS } else { &[] };
    let plan = Plan {
        ini: "ac-trunnion.ini",
        program: text,
        start: &["G21 G90 G94 G40 G49 G54", "G10 L2 P1 X0 Y0 Z0 A0 C0 R0"],
        letters: "xyzac",
        seconds: 120,
        actions,
        pins,
        hal: "",
    };
    control.run(&work, &plan)
}

/// Checks the limits of the joints and the contour of a run on the pass.
fn check(run: &Run, points: &[[f64; 3]], case: &str) -> Motion {
    let machine = parse(TIMED_MACHINE).unwrap().machine;
    let motion = Motion::of(run);
    let [velocity, acceleration, jerk] = motion.ratios(&machine);
    let miss = motion.contour(points);
    let pins: Vec<String> = PINS.iter().map(|pin| format!("{pin} {}", run.values[*pin])).collect();
    eprintln!(
        "{case}: {:.3} s on the pass, ratios {velocity:.4} {acceleration:.4} {jerk:.4}, contour {miss:.5} mm, {}, {}",
        motion.on_the_pass(),
        motion.cost(),
        pins.join(", ")
    );
    assert_eq!(run.lost, 0, "{case}: cycles that the sampler lost");
    assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001, "{case}");
    // The sampler rounds the words by half a micrometre of a thousandth.
    assert!(miss <= 0.01, "{case}: {miss}");
    motion
}

#[test]
fn a_pass_of_short_blocks_takes_what_its_feed_allows() {
    let Some(control) = Control::ready() else { return };
    let temporary = tempfile::tempdir().unwrap();
    for step in [0.5, 0.125] {
        let points = pass(step);
        let text = program(&points, &[]);
        let stock = run(&control, temporary.path(), "stock", &text, &[]);
        assert!(stock.errors.is_empty() && stock.ended, "{:?}\n{}", stock.errors, stock.log);
        eprintln!(
            "{step} mm, LinuxCNC's own: {:.3} s on the pass",
            Motion::of(&stock).on_the_pass()
        );
        let own = run(&control, temporary.path(), "trunnion", &text, &[]);
        assert!(own.errors.is_empty() && own.ended, "{:?}\n{}", own.errors, own.log);
        let seconds = check(&own, &points, &format!("{step} mm")).on_the_pass();
        assert!(seconds <= 5.6, "{step} mm: {seconds} s");
        assert!(seconds < Motion::of(&stock).on_the_pass());
    }
}

#[test]
fn holds_overrides_steps_and_aborts_keep_the_limits() {
    let Some(control) = Control::ready() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let points = pass(0.25);
    let text = program(&points, &[(5, "M62 P0\nM67 E0 Q3.5"), (20, "M63 P1")]);
    // A hold is felt after what is committed, up to 0.4 s on a busy machine: every stand gets 1.5 s.
    let actions = [
        Action(0.8, "feed", 0.3),
        Action(1.4, "feed", 1.2),
        Action(2.0, "pause", 0.0),
        Action(3.5, "step", 0.0),
        Action(5.0, "step", 0.0),
        Action(6.5, "resume", 0.0),
        Action(7.1, "feed", 0.0),
        Action(8.6, "feed", 1.0),
        Action(8.9, "rapid", 0.5),
    ];
    let whole = run(&control, temporary.path(), "trunnion", &text, &actions);
    assert!(whole.errors.is_empty() && whole.ended, "{:?}\n{}", whole.errors, whole.log);
    let motion = check(&whole, &points, "operator");
    // The two holds are stands of a third of a second at least.
    let stands = stands(&motion.words, 250);
    assert!(stands >= 4, "{stands}");
    // The screen saw line after line.
    let lines = whole.values["lines"].as_array().unwrap().len();
    assert!(lines > 100, "{lines}");

    let actions = [Action(1.5, "abort", 0.0)];
    let ended = run(&control, temporary.path(), "trunnion", &text, &actions);
    let motion = check(&ended, &points, "abort");
    let last = motion.words.last().unwrap();
    assert!(last[0] > 1.0 && last[0] < 240.0, "{last:?}");
}

/// Number of stands of more than so many cycles on the pass.
fn stands(words: &[[f64; 3]], cycles: usize) -> usize {
    let mut count = 0;
    let mut length = 0;
    for two in words.windows(2) {
        let inside = two[0][0] > 1e-3 && two[0][0] < 249.999;
        let still = (0..3).all(|letter| (two[1][letter] - two[0][letter]).abs() < 1e-7);
        length = if inside && still { length + 1 } else { 0 };
        count += usize::from(length == cycles);
    }
    count
}

#[test]
fn a_refused_block_is_named_and_the_tool_stops_before_it() {
    let Some(control) = Control::ready() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let machine = parse(TIMED_MACHINE).unwrap().machine;
    // Both ends of the turn are inside travel: half way the tip goes round beyond it.
    let text = "G21 G90 G94 G49 G64 P0.01\nM428\nG0 X-495 Y0 Z0\nG1 X-450 F6000\nG1 Y300 C0\nG1 C180 F20000\nM2\n";
    let run = run(&control, temporary.path(), "trunnion", text, &[]);
    let said = run.errors.join("\n");
    eprintln!("{said}");
    assert!(!run.ended && said.contains("trunniontp: line 6: axis X by "), "{said}");
    assert!(said.contains("an axis would leave its travel; move the workpiece"), "{said}");
    let motion = Motion::of(&run);
    let [velocity, acceleration, jerk] = motion.ratios(&machine);
    assert!(velocity <= 1.001 && acceleration <= 1.001 && jerk <= 1.001);
    for joints in &motion.joints {
        for (joint, value) in joints.iter().enumerate().take(3) {
            assert!(value.abs() <= 500.001, "{joint} {value}");
        }
    }
}
