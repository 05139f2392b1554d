//! Small faults planted in a program that keeps its tolerance: each is found, at its block, and in the
//! clean program there is none. A checker that never failed on a planted fault has not been tested.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::posted;
use crate::shop;

use nalgebra::{Point3, Rotation3, Vector3};
use shop::Layout;
use std::f64::consts::PI;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nc::read::{self, ClFile, ClMotion, ClPath, ClRecord, Dialect, Program, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::surface::{
    Face, NurbsSurface, PlaneSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop,
};
use trunnion::types::{Block, Motion, Silent, ToolPose};
use trunnion::verify::{
    self, BoundMargins, BoundOptions, CheckInput, CheckOptions, DeviationTolerance, Finding, Report,
};

const RADIUS: f64 = 5.0;
/// Half of the patch's side.
const HALF: f64 = 3.0;
/// Kept off the surface, so that chords over what is hollow do not gouge.
const LIFT: f64 = 0.0006;
const ROWS: u32 = 12;
const STEPS: u32 = 16;

const OPTIONS: CheckOptions = CheckOptions {
    reach: 1.0,
    ray_tolerance: 2e-5,
    most_points: 1_000_000,
    bounds: Some(BoundOptions::within(BoundMargins::both(5e-4))),
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.012, gouge: 0.001 }, 0.1)
};

/// Rows with a ball over a patch, the tool swinging, and a holder.
struct Job {
    machine: Machine,
    setup: Setup,
    face: Face,
    cutter: Cutter,
    text: String,
}

fn words(machine: &Machine) -> AxisWords {
    AxisWords::of(machine).unwrap().with_decimals(6, 6)
}

fn parse(text: &str, machine: &Machine) -> Program {
    read::read(text, &ReadOptions::new(Dialect::LinuxCnc, words(machine), 5)).unwrap()
}

fn patch() -> Face {
    let row = |i: u8| {
        let point = |j: u8| {
            let [x, y] = [f64::from(i) - 1.0, f64::from(j) - 1.0];
            Point3::new(HALF * x, HALF * y, 0.1 * x * x - 0.1 * y * y)
        };
        (0..3).map(point).collect()
    };
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let net = (0..3).map(row).collect();
    let surface = NurbsSurface::new([2, 2], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// From above to the first row, over all rows, up again.
fn blocks(kinematics: &Kinematics, face: &Face) -> Vec<Block> {
    let pose = |x: f64, y: f64, lift: f64| {
        let [u, v] = [0.5 + 0.5 * x / HALF, 0.5 + 0.5 * y / HALF];
        let normal = face.normal(u, v).unwrap();
        let tilt = 0.3 + 0.12 * (PI * y / HALF).cos();
        let axis = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt) * normal;
        let centre = face.point(u, v) + normal.into_inner() * (RADIUS + lift);
        ToolPose { tip: centre - axis.into_inner() * RADIUS, axis }
    };
    let far = HALF + 0.3;
    let mut poses = vec![pose(-far, -far, 20.0)];
    for row in 0..=ROWS {
        let x = far * (2.0 * f64::from(row) / f64::from(ROWS) - 1.0);
        for step in 0..=STEPS {
            let y = far * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
            poses.push(pose(x, if row % 2 == 0 { y } else { -y }, LIFT));
        }
    }
    poses.push(pose(far, far, 20.0));
    let inverse = Inverse::new(kinematics).unwrap();
    let mut q = kinematics.machine().home();
    let mut blocks: Vec<Block> = Vec::new();
    for pose in poses {
        q = inverse.near(&pose, &q).unwrap();
        let duration = blocks.last().map_or(0.0, |block| (pose.tip - block.pose.tip).norm() / 8.0);
        blocks.push(Block { motion: Motion::Cut, q, pose, duration });
    }
    blocks
}

impl Job {
    fn new() -> Self {
        let machine = shop::machine(Layout::TableTable);
        let setup = shop::setup(Layout::TableTable);
        let kinematics = Kinematics::new(&machine, &setup);
        let face = patch();
        let shank = vec![[30.0, RADIUS], [40.0, 12.0]];
        let spec = CutterSpec { length: 120.0, shank, ..CutterSpec::of_radii(0.0, RADIUS) };
        let blocks = blocks(&kinematics, &face);
        let text = posted::plain(&kinematics, &blocks, (words(&machine), true));
        Self { machine, setup, face, cutter: Cutter::new(spec).unwrap(), text }
    }

    fn check(&self, text: &str) -> Report {
        self.check_of(text, &self.machine, &self.setup, &self.face)
    }

    /// The check with grid points at most so far apart.
    fn check_on(&self, text: &str, grid: f64) -> Report {
        let program = parse(text, &self.machine);
        let kinematics = Kinematics::new(&self.machine, &self.setup);
        let input = CheckInput::program(&program, &kinematics, &self.cutter)
            .faces(std::slice::from_ref(&self.face));
        verify::check(&input, &CheckOptions { grid, ..OPTIONS }, &Silent).unwrap()
    }

    fn check_of(&self, text: &str, machine: &Machine, real: &Setup, face: &Face) -> Report {
        let program = parse(text, machine);
        let [believed, real] = [&self.setup, real].map(|setup| Kinematics::new(machine, setup));
        let input = CheckInput::program(&program, &believed, &self.cutter)
            .machine(&real)
            .faces(std::slice::from_ref(face));
        verify::check(&input, &OPTIONS, &Silent).unwrap()
    }

    /// Number (from 1) of a cutting line of row 6, and the line.
    fn line(&self, step: usize) -> (u32, &str) {
        self.line_of(6, step)
    }

    /// Number (from 1) of a cutting line, and the line.
    fn line_of(&self, row: usize, step: usize) -> (u32, &str) {
        let lines: Vec<_> = self.text.lines().collect();
        let first = lines.iter().position(|line| line.starts_with("G1")).unwrap();
        let at = first + row * (STEPS as usize + 1) + step;
        (u32::try_from(at + 1).unwrap(), lines[at])
    }

    /// The text with one line changed.
    fn with_line(&self, number: u32, line: &str) -> String {
        posted::with_line(&self.text, number, line)
    }
}

fn messages(report: &Report) -> Vec<String> {
    report.findings.iter().map(ToString::to_string).collect()
}

fn gouge(report: &Report) -> (u32, f64) {
    let found = report.findings.iter().find_map(|finding| match finding {
        Finding::Gouge(worst) => Some((worst.line, -worst.height)),
        _ => None,
    });
    found.unwrap()
}

#[test]
fn nothing_is_found_in_the_clean_program_and_its_bounds_keep_the_tolerance() {
    let job = Job::new();
    let report = job.check(&job.text);
    assert!(report.passed(), "{:?}", messages(&report));
    let bounds = report.deviation.bounds.unwrap();
    assert!(bounds.open <= 0.0 && bounds.gouge <= OPTIONS.gouge, "{bounds:?}");
    assert!(bounds.excess.unwrap() <= OPTIONS.total, "{bounds:?} {:?}", report.deviation.highest);
}

#[test]
fn a_gouge_of_two_micrometres_in_one_block() {
    let job = Job::new();
    let (number, line) = job.line(8);
    let deeper = 0.002 + LIFT;
    let text = job
        .with_line(number, &posted::reworded(line, 'Z', |z| z - deeper / 20f64.to_radians().cos()));
    let (found, depth) = gouge(&job.check(&text));
    assert!(found == number || found == number + 1, "line {found}, planted in {number}");
    assert!((0.0014..0.0028).contains(&depth), "{depth}");
}

/// Lines and depths of all gouges that are named.
fn gouges(report: &Report) -> Vec<(u32, f64)> {
    let gouge = |finding: &Finding| match finding {
        Finding::Gouge(at) => Some((at.line, -at.height)),
        _ => None,
    };
    report.findings.iter().filter_map(gouge).collect()
}

/// Locations too deep by 3 micrometres, far from each other: each is named once, on a grid that is finer than what they
/// cut and on one that misses some of them.
#[test]
fn every_fault_is_named() {
    let job = Job::new();
    let planted = [[2, 4], [2, 12], [5, 8], [8, 3], [8, 11], [10, 8]];
    let mut text = job.text.clone();
    let numbers = planted.map(|[row, step]| {
        let (number, line) = job.line_of(row, step);
        let deeper = 0.003 + LIFT + 1e-5 * f64::from(number % 7);
        let line = posted::reworded(line, 'Z', |z| z - deeper / 20f64.to_radians().cos());
        text = posted::with_line(&text, number, &line);
        number
    });
    let mut missed = 0;
    for grid in [0.1, 0.4, 1.0] {
        let report = job.check_on(&text, grid);
        let found = gouges(&report);
        let names =
            |number: u32| found.iter().filter(|(l, _)| [number, number + 1].contains(l)).count();
        let named = numbers.map(names);
        assert_eq!((named, found.len()), ([1; 6], 6), "grid {grid}: {found:?}");
        assert!(found.is_sorted_by(|a, b| a.1 >= b.1), "{found:?}");
        let samples = report.maps[0].samples.iter().flatten();
        let broken = samples.filter(|sample| sample.height.is_some_and(|h| h < -OPTIONS.gouge));
        missed += usize::from(broken.count() < 6);
    }
    assert!(missed > 0, "every fault was on a grid point: nothing had to be found between them");
}

/// More faults than are named are counted.
#[test]
fn faults_beyond_those_named_are_counted() {
    let job = Job::new();
    let mut text = job.text.clone();
    let mut planted = 0;
    for row in (1..12).step_by(2) {
        for step in (2..16).step_by(3) {
            let (number, line) = job.line_of(row, step);
            text = posted::with_line(&text, number, &posted::reworded(line, 'Z', |z| z - 0.004));
            planted += 1;
        }
    }
    let report = job.check_on(&text, 0.05);
    let named = gouges(&report).len();
    let further = report.findings.iter().find_map(|finding| match finding {
        Finding::FurtherGouges { regions } => Some(*regions),
        _ => None,
    });
    assert_eq!((named, named + further.unwrap()), (20, planted), "{:?}", messages(&report));
}

#[test]
fn an_axis_at_1_002_of_its_velocity() {
    let job = Job::new();
    let clean = job.check(&job.text).audit.unwrap();
    let mut machine = job.machine.clone();
    for (axis, found) in machine.axes.iter_mut().zip(&clean.axes) {
        axis.vel *= found.velocity.raw * 1.0001;
    }
    assert!(job.check_of(&job.text, &machine, &job.setup, &job.face).passed());
    let line = clean.axes[4].velocity.line;
    let old = job.text.lines().nth(line as usize - 1).unwrap();
    let text = job.with_line(line, &posted::reworded(old, 'F', |f| f * 1.0021));
    let report = job.check_of(&text, &machine, &job.setup, &job.face);
    let fast = report.findings.iter().find_map(|finding| match finding {
        Finding::Velocity { axis, worst } if axis == "B" => Some(*worst),
        _ => None,
    });
    let worst = fast.unwrap();
    assert_eq!((worst.line, worst.broken), (line, 1));
    assert!((worst.worst - 1.002).abs() < 2e-4, "{}", worst.worst);
}

#[test]
fn a_sign_flipped_in_one_rotary_word() {
    let job = Job::new();
    let (number, line) = job.line(5);
    let (found, depth) =
        gouge(&job.check(&job.with_line(number, &posted::reworded(line, 'B', |b| -b))));
    assert!(found == number || found == number + 1, "line {found}, planted in {number}");
    assert!(depth > 0.05, "{depth}");
}

#[test]
fn a_tool_ten_micrometres_too_long_gouges_all_over() {
    let job = Job::new();
    let longer = Setup { tool_length: job.setup.tool_length + 0.01, ..job.setup };
    let report = job.check_of(&job.text, &job.machine, &longer, &job.face);
    let (_, depth) = gouge(&report);
    assert!((0.008..0.0101).contains(&depth), "{depth}");
    let samples = || report.maps[0].samples.iter().flatten();
    let gouged = samples().filter(|sample| sample.height.is_some_and(|h| h < -0.001)).count();
    assert!(gouged * 5 > samples().count(), "{gouged} of {}", samples().count());
    assert!(report.deviation.sensitivity.length > 0.85);
}

/// How much higher the tool would have to be, where that is all that is wrong.
fn as_a_whole(report: &Report) -> Option<[f64; 2]> {
    report.findings.iter().find_map(|finding| match finding {
        Finding::Length { higher } => Some(higher.ends()),
        _ => None,
    })
}

#[test]
fn a_wrong_tool_length_is_named_as_a_whole_and_a_wrong_block_is_not() {
    let job = Job::new();
    for by in [0.01, -0.03] {
        let other = Setup { tool_length: job.setup.tool_length + by, ..job.setup };
        let report = job.check_of(&job.text, &job.machine, &other, &job.face);
        let [least, most] = as_a_whole(&report).unwrap();
        // A length that is off is off along the tool.
        assert!(least <= by && by <= most && least.signum() == by.signum(), "{least} {most} {by}");
        assert!(most - least <= (OPTIONS.total + OPTIONS.gouge) / 0.85, "{least} {most}");
    }
    let (number, line) = job.line(8);
    let faults = [
        job.text.clone(),
        job.with_line(number, &posted::reworded(line, 'Z', |z| z - 0.004)),
        job.with_line(number, &posted::reworded(line, 'Z', |z| z + 0.1)),
        job.with_line(number, &posted::reworded(line, 'B', |b| -b)),
        job.with_line(number, ""),
    ];
    for text in faults {
        assert_eq!(as_a_whole(&job.check(&text)), None);
    }
}

/// Locations past an upright wall, a micrometre off it with the holder; one of them 6 micrometres nearer.
#[test]
fn a_holder_grazing_by_five_micrometres() {
    let job = Job::new();
    let frame =
        SurfaceFrame::new(Point3::new(-12.001, 0.0, 0.0), Vector3::x(), Vector3::y()).unwrap();
    let corners = [[-20.0, 20.0], [20.0, 20.0], [20.0, 80.0], [-20.0, 80.0], [-20.0, 20.0]];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    let face = Face::new(2, Surface::Plane(PlaneSurface { frame }), vec![trim.unwrap()]).unwrap();
    let bounds =
        Some(BoundOptions { excess: false, ..BoundOptions::within(BoundMargins::both(5e-4)) });
    let options = CheckOptions { grid: 1.0, bounds, ..OPTIONS };
    let check = |nearer: f64| {
        let record = |k: u32| {
            let x = if k == 7 { -nearer } else { 0.0 };
            let pose = ToolPose::new([x, f64::from(k) - 6.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
            ClRecord { line: k, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
        };
        let file = ClFile { records: (1..12).map(record).collect(), ..ClFile::default() };
        let (faces, cutter) = (std::slice::from_ref(&face), &job.cutter);
        verify::check(&CheckInput::locations(&file, cutter).faces(faces), &options, &Silent)
            .unwrap()
    };
    // Only gouges count on a wall that is not cut.
    let gouges = |report: &Report| {
        let all = report.findings.iter();
        all.filter(|finding| matches!(finding, Finding::Gouge(_))).count()
    };
    let clean = check(0.0);
    assert_eq!(gouges(&clean), 0, "{:?}", messages(&clean));
    assert!(clean.deviation.bounds.unwrap().gouge <= 5e-4);
    let grazed = check(0.006);
    let (line, depth) = gouge(&grazed);
    assert!(line == 7 || line == 8, "line {line}");
    assert!((0.004..0.0055).contains(&depth), "{depth}");
    assert!(grazed.deviation.bounds.unwrap().gouge >= 0.005);
}
