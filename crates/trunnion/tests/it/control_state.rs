//! Faults in the state of the control: each is planted into a clean program of two tools, and must be the only finding.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Vector3};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::Silent;
use trunnion::verify::{
    AssumedError, CheckInput, CheckOptions, CoolantDemand, DeviationTolerance, Finding,
    FindingKind, Inspection, InspectionReport, PlannedCuts, Tool,
};

const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");

fn kinematics() -> Kinematics {
    let machine = machine::parse(MACHINE).unwrap().machine;
    Kinematics::new(&machine, &Setup::new(Vector3::new(-381.0, -254.0, -505.0), [0.0; 3], 100.0))
}

fn flat(radius: f64, length: f64) -> Cutter {
    let (major, minor, shank) = (radius, 0.0, Vec::new());
    Cutter::new(CutterSpec { length, shank, ..CutterSpec::of_radii(major, minor) }).unwrap()
}

fn floor() -> Face {
    let corner = |x, y| Point3::new(x, y, 0.0);
    let points = vec![
        vec![corner(-10.0, -10.0), corner(-10.0, 8.0)],
        vec![corner(10.0, -10.0), corner(10.0, 8.0)],
    ];
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::new([1, 1], [knots(), knots()], points, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// Rows along X at these Y, 1 micrometre above the floor.
fn rows(ys: &[f64]) -> String {
    let row = |y: &f64| format!("G0 Y{y}\nZ0.001\nG1 F600. X16.\nG0 Z40.\nX-16.\n");
    ys.iter().map(row).collect()
}

fn clean() -> String {
    format!(
        "G21 G90 G94 G17 G54 G49\nG64 P0.01\nT1 M6\nS5000 M3\nG0 X-16. Y-10. B0. C0.\nG43 H1 Z40.\n{}M5\nG49\n\
         T2 M6\nS8000 M3\nG0 X-16. Y2.\nG43 H2 Z40.\n{}M30\n",
        rows(&[-10.0, -4.0, 0.0]),
        rows(&[2.0, 5.0, 8.0])
    )
}

fn inspect(text: &str) -> InspectionReport {
    inspect_cooled(text, CoolantDemand::Unknown)
}

fn inspect_cooled(text: &str, coolant: CoolantDemand) -> InspectionReport {
    inspect_in(Dialect::LinuxCnc, text, coolant)
}

fn inspect_in(dialect: Dialect, text: &str, coolant: CoolantDemand) -> InspectionReport {
    inspect_planned(dialect, text, (coolant, None))
}

fn inspect_planned(
    dialect: Dialect,
    text: &str,
    (coolant, planned): (CoolantDemand, Option<PlannedCuts<'_>>),
) -> InspectionReport {
    let kinematics = kinematics();
    let words = AxisWords::of(kinematics.machine()).unwrap();
    let program = read::read(text, &ReadOptions::new(dialect, words, 5)).unwrap();
    let [one, two] = [flat(4.0, 100.0), flat(2.0, 80.0)];
    let tools = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
    let faces = [floor()];
    let input = CheckInput::program(&program, &kinematics, &one).faces(&faces).tools(&tools);
    let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
    let options = CheckOptions { bounds: None, ..CheckOptions::of_tolerance(tolerance, 1.0) };
    let inspection = Inspection::new(input, options).coolant(coolant);
    let inspection = planned.map_or(inspection, |planned| inspection.planned(planned));
    inspection.run(&Silent).unwrap()
}

/// Coolant is a fault only where the job asks for it; M9 behind the first tool leaves the second dry.
#[test]
fn cuts_without_the_coolant_of_the_job_are_found() {
    let kinds = |text: &str| -> Vec<FindingKind> {
        let found = inspect_cooled(text, CoolantDemand::Needed).report.findings;
        found.iter().map(Finding::kind).collect()
    };
    assert_eq!(kinds(&clean()), [FindingKind::NoCoolant]);
    let wet = clean().replace("S5000 M3", "S5000 M3\nM8");
    assert_eq!(kinds(&wet), []);
    assert_eq!(kinds(&wet.replace("M5\n", "M5 M9\n")), [FindingKind::NoCoolant]);
    assert_eq!(kinds(&wet.replace("M5\n", "M9\nM5\n")), [FindingKind::NoCoolant]);
}

#[test]
fn a_clean_program_has_no_finding() {
    let found = inspect(&clean());
    assert!(found.report.passed(), "{:?}", found.report.findings);
    assert_eq!(found.state.unwrap().smoothing.unwrap().line, 2);
}

#[test]
fn every_planted_state_is_the_only_finding() {
    let text = clean();
    let line = |of: &str| text.lines().position(|line| line == of).unwrap() + 1;
    // The first feed move behind a line of the clean program.
    let cut_behind =
        |at: usize| at + 1 + text.lines().skip(at).position(|line| line.starts_with("G1")).unwrap();
    let second = line("T2 M6");
    let faults = [
        // The spindle is never started again after the change.
        ("S8000 M3\n", "", FindingKind::SpindleStopped, cut_behind(second) - 1),
        // It is stopped, or never was on.
        ("S5000 M3\n", "M5\n", FindingKind::SpindleStopped, cut_behind(4)),
        // M6 stops it, even for the tool that is in it.
        ("S5000 M3\n", "S5000 M3\nM6\n", FindingKind::SpindleStopped, cut_behind(4) + 1),
        ("S5000 M3\n", "S5000 M4\n", FindingKind::SpindleReversed, cut_behind(4)),
        // The length of the other tool.
        ("G43 H2", "G43 H1", FindingKind::WrongLength, cut_behind(second)),
        ("G64 P0.01", "G64 P1", FindingKind::Smoothing, 2),
        ("G64 P0.01", "G64", FindingKind::Smoothing, 2),
    ];
    for (from, to, kind, at) in faults {
        let found = inspect(&text.replace(from, to)).report.findings;
        let kinds: Vec<FindingKind> = found.iter().map(Finding::kind).collect();
        assert_eq!(kinds, [kind], "{from} -> {to}: {found:?}");
        let words = found[0].to_string();
        assert!(words.starts_with(&format!("line {at}: ")), "{from} -> {to}: {words}");
    }
}

/// Without compensation the gauge point runs where the tip should: the part is far from right as well.
#[test]
fn a_missing_length_is_found_beside_its_effect() {
    let text = clean().replace("G43 H2 Z40.", "G0 Z40.");
    let found = inspect(&text).report.findings;
    let kinds: Vec<FindingKind> = found.iter().map(Finding::kind).collect();
    assert!(kinds.contains(&FindingKind::NoLength), "{found:?}");
    assert!(kinds.len() > 1, "{found:?}");
}

/// A tool that is longer than the control knows cuts deeper by as much; one with a smaller radius leaves the floor as it
/// is, since the tip is measured.
#[test]
fn an_error_that_the_control_does_not_know_changes_the_part() {
    let kinematics = kinematics();
    let words = AxisWords::of(kinematics.machine()).unwrap();
    let program = read::read(&clean(), &ReadOptions::new(Dialect::LinuxCnc, words, 5)).unwrap();
    let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
    let options = CheckOptions { bounds: None, ..CheckOptions::of_tolerance(tolerance, 1.0) };
    let faces = [floor()];
    let lowest = |error: AssumedError| {
        let [one, two] =
            [flat(4.0, 100.0), flat(2.0, 80.0)].map(|cutter| error.cutter(&cutter).unwrap());
        let tools = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
        let machine = error.kinematics(&kinematics);
        let input = CheckInput::program(&program, &kinematics, &one).faces(&faces).tools(&tools);
        let report = trunnion::verify::check(&input.machine(&machine), &options, &Silent).unwrap();
        report.deviation.lowest.unwrap().height
    };
    assert!((lowest(AssumedError::NONE) - 0.001).abs() < 1e-6);
    let longer = AssumedError { length: 0.01, ..AssumedError::NONE };
    assert!((lowest(longer) + 0.009).abs() < 1e-6);
    let smaller = AssumedError { radius: -0.01, ..AssumedError::NONE };
    assert!((lowest(smaller) - 0.001).abs() < 1e-6);
    // The rotaries stand at zero, where the workpiece was set: their positions do not matter.
    let pivots = [Vector3::new(0.0, 0.0, 0.02), Vector3::new(0.05, 0.0, 0.0)];
    let moved = AssumedError { pivots, ..AssumedError::NONE };
    assert!((lowest(moved) - 0.001).abs() < 1e-6);
    // A workpiece that stands higher is cut deeper.
    let higher = AssumedError { origin: Vector3::new(0.0, 0.0, 0.005), ..AssumedError::NONE };
    assert!((lowest(longer + higher) + 0.014).abs() < 1e-6);
}

/// On Sinumerik D may stand beside T, beside M6, or behind it.
#[test]
fn another_edge_is_found_wherever_it_is_chosen() {
    let text = |change: &str| {
        format!(
            "G17 G90 G94 G710 G54\n{change}\nS5000 M3\nG0 X-16. Y-10. B0. C0.\nZ40.\n{}M30\n",
            rows(&[-10.0, -4.0, 0.0, 3.0, 6.0, 8.0])
        )
    };
    let kinds = |change: &str| -> Vec<FindingKind> {
        let found = inspect_in(Dialect::Siemens, &text(change), CoolantDemand::Unknown);
        found.report.findings.iter().map(Finding::kind).collect()
    };
    for clean in ["T1 D1\nM6", "T1\nM6 D1", "T1\nM6"] {
        assert!(!kinds(clean).contains(&FindingKind::WrongLength), "{clean}");
    }
    for planted in ["T1 D2\nM6", "T1\nM6 D2", "T1\nM6\nD2"] {
        assert!(kinds(planted).contains(&FindingKind::WrongLength), "{planted}");
    }
}

/// With the tools and the feed of a job, a call that is left out and feeds in another unit are faults.
#[test]
fn a_job_shows_missing_calls_and_slow_cuts() {
    let kinds = |text: &str, tools: &[u32]| -> Vec<FindingKind> {
        let planned = Some(PlannedCuts { tools, feed: 10.0 });
        let found = inspect_planned(Dialect::LinuxCnc, text, (CoolantDemand::Unknown, planned));
        found.report.findings.iter().map(Finding::kind).collect()
    };
    let text = clean();
    assert_eq!(kinds(&text, &[1, 2]), []);
    assert!(kinds(&text.replace("T2 M6\n", ""), &[1, 2]).contains(&FindingKind::NoTool));
    // A single tool may have another number at the control.
    assert_eq!(kinds(&text, &[7]), []);
    assert_eq!(kinds(&text.replace("F600.", "F0.6"), &[1, 2]), [FindingKind::SlowCuts]);
    assert_eq!(kinds(&text.replace("F600.", "F60."), &[1, 2]), []);
}

/// A wrong digit of F in one block of many is a fault where the block cuts, and none on the way through the air.
#[test]
fn one_fast_cut_between_slow_ones_is_found() {
    let found = |low: f64, feeds: [u32; 3]| -> Vec<String> {
        let [before, middle, after] = feeds;
        let blocks = format!("Z{low}\nG1 F{before}. X-4.\nF{middle}. X4.\nF{after}. X16.\n");
        let text = clean().replacen("Z0.001\nG1 F600. X16.\n", &blocks, 1);
        let planned = Some(PlannedCuts { tools: &[1, 2], feed: 10.0 });
        let found = inspect_planned(Dialect::LinuxCnc, &text, (CoolantDemand::Unknown, planned));
        let findings = found.report.findings.iter();
        let fast = findings.filter(|finding| finding.kind() == FindingKind::FastCuts);
        fast.map(ToString::to_string).collect()
    };
    let [fast] = found(0.001, [600, 6000, 500]).try_into().unwrap();
    assert!(
        fast.starts_with("line 10: this cut runs at 6000 mm/min between cuts at 600 "),
        "{fast}"
    );
    // Twice the feed of the job, faster than one neighbour alone, and in the air.
    assert_eq!(found(0.001, [600, 1100, 300]), [""; 0]);
    assert_eq!(found(0.001, [3000, 6000, 600]), [""; 0]);
    assert_eq!(found(5.0, [600, 6000, 600]), [""; 0]);
}

/// A tool that comes down to the face at the speed of links finishes a point with the end of that block, and cuts nothing.
#[test]
fn a_fast_way_down_to_a_cut_is_none() {
    let fast = |down: &str| -> usize {
        let text = clean().replacen(
            "Z0.001\nG1 F600. X16.\n",
            &format!("Z5.\nG1 F600. X-4.1\nX-4.\n{down}F600. X16.\n"),
            1,
        );
        let planned = Some(PlannedCuts { tools: &[1, 2], feed: 10.0 });
        let found = inspect_planned(Dialect::LinuxCnc, &text, (CoolantDemand::Unknown, planned));
        let findings = found.report.findings.iter();
        findings.filter(|finding| finding.kind() == FindingKind::FastCuts).count()
    };
    assert_eq!(fast("F6000. Z0.001\n"), 0);
    // The same way aslant cuts with its end.
    assert_eq!(fast("F6000. X4. Z0.001\n"), 1);
}
