//! Verification against brute force, and against faults planted in a program's text.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::posted;
use crate::property;
use crate::shop;

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use shop::Layout;
use std::f64::consts::PI;
use trunnion::cutter::{Cutter, CutterKind, CutterSpec, ProfilePiece};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nc::read::{self, Dialect, Program, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{AxisVector, Block, Motion, Silent, ToolPose};
use trunnion::verify::{self, CheckInput, CheckOptions, DeviationTolerance, Finding, Report};

const OPTIONS: CheckOptions = CheckOptions {
    reach: 3.0,
    ray_tolerance: 1e-4,
    most_points: 1_000_000,
    bounds: None,
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 0.5)
};

fn cutter(kind: CutterKind, major: f64, minor: f64) -> Cutter {
    let shank = vec![[30.0, major + minor], [40.0, major + minor + 6.0]];
    Cutter::new(CutterSpec { kind, length: 120.0, shank, ..CutterSpec::of_radii(major, minor) })
        .unwrap()
}

/// A biquadratic Bezier patch: `size` wide, centred at `place`, bulging by `bulge` at the middle
/// and twisted, in the frame of `turn`.
fn patch(place: Point3<f64>, turn: Rotation3<f64>, size: f64, bulge: [f64; 3]) -> Face {
    let row = |i: u8| {
        let point = |j: u8| {
            let [x, y] = [f64::from(i) - 1.0, f64::from(j) - 1.0];
            let z = bulge[0] * x * x + bulge[1] * y * y + bulge[2] * x * y;
            place + turn * Vector3::new(0.5 * size * x, 0.5 * size * y, z)
        };
        (0..3).map(point).collect()
    };
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let surface =
        NurbsSurface::new([2, 2], [knots(), knots()], (0..3).map(row).collect(), None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// Blocks as text and back.
fn program(kinematics: &Kinematics, blocks: &[Block], tcp: bool) -> (String, Program) {
    let text = posted::plain(kinematics, blocks, (words(kinematics.machine()), tcp));
    let program = parse(&text, kinematics.machine());
    (text, program)
}

fn words(machine: &Machine) -> AxisWords {
    AxisWords::of(machine).unwrap().with_decimals(6, 6)
}

fn parse(text: &str, machine: &Machine) -> Program {
    read::read(text, &ReadOptions::new(Dialect::LinuxCnc, words(machine), 5)).unwrap()
}

/// Whether a point is inside the tool grown by `grow`: by its outline, height for height.
fn inside(cutter: &Cutter, pose: &ToolPose, p: &Point3<f64>, grow: f64) -> bool {
    let y = p - pose.tip;
    let z = pose.axis.dot(&y);
    let rho = (y - pose.axis.into_inner() * z).norm();
    let radius = if cutter.tangent_profile().is_some() && (-grow..30.0).contains(&z) {
        let Some(radius) = beside_tip(cutter, z, grow) else { return false };
        radius
    } else if (-grow..cutter.minor()).contains(&z) {
        let down = cutter.minor() - z;
        cutter.major() + ((cutter.minor() + grow).powi(2) - down.powi(2)).max(0.0).sqrt()
    } else if (cutter.minor().max(-grow)..30.0).contains(&z) {
        cutter.radius() + grow
    } else if (30.0..40.0).contains(&z) {
        cutter.radius() + 6.0 * (z - 30.0) / 10.0 + 2.0 * grow
    } else if (40.0..=cutter.length()).contains(&z) {
        cutter.radius() + 6.0 + grow
    } else {
        return false;
    };
    rho <= radius
}

/// Radius at a height of a cutter with a side, grown by `grow`: circle by circle and line by line.
fn beside_tip(cutter: &Cutter, z: f64, grow: f64) -> Option<f64> {
    cutter.profile().iter().find_map(|piece| {
        let height = z.max(0.0);
        if !(piece.start()[1]..=piece.end()[1]).contains(&height) {
            return None;
        }
        match *piece {
            ProfilePiece::Arc { center, radius, .. } => {
                let square = (radius + grow).powi(2) - (z - center[1]).powi(2);
                Some(center[0] + square.max(0.0).sqrt())
            }
            ProfilePiece::Line { from, to } if to[1] > from[1] => {
                let slope = (to[0] - from[0]) / (to[1] - from[1]);
                Some(from[0] + slope * (z - from[1]) + grow * slope.hypot(1.0))
            }
            ProfilePiece::Line { .. } => None,
        }
    })
}

/// Lowest `s` on a ray that is inside the tool, shrunk by what verification may overlook (a tenth
/// of the ray tolerance in motion, a tenth in grazing touches): fine steps, then halving.
fn first_inside(cutter: &Cutter, pose: &ToolPose, p: Point3<f64>, n: Vector3<f64>) -> Option<f64> {
    const STEPS: u32 = 120;
    let step = 2.0 * OPTIONS.reach / f64::from(STEPS);
    let at = |s: f64| inside(cutter, pose, &(p + n * s), -2e-5);
    // What leaves the ray below the surface is another's gouge: the tool is convex.
    let low = if at(0.0) { -OPTIONS.reach } else { 0.0 };
    let hits = (0..=STEPS).map(|k| -OPTIONS.reach + step * f64::from(k));
    let hit = hits.filter(|&s| s >= low).find(|&s| at(s))?;
    let (mut out, mut in_) = (hit - step, hit);
    for _ in 0..30 {
        let middle = 0.5 * (out + in_);
        if at(middle) { in_ = middle } else { out = middle }
    }
    Some(if hit <= -OPTIONS.reach { -OPTIONS.reach } else { in_ })
}

fn any_cutter() -> impl Strategy<Value = Cutter> {
    prop_oneof![
        Just(cutter(CutterKind::Flat, 5.0, 0.0)),
        Just(cutter(CutterKind::Ball, 0.0, 5.0)),
        Just(cutter(CutterKind::Bull, 3.0, 2.0)),
        Just(with_side(&CutterSpec::taper(1.0, 0.3, 10.0))),
        Just(with_side(&CutterSpec::barrel(1.0, 40.0, 10.0))),
        Just(with_side(&CutterSpec::conical_barrel(1.0, 60.0, 0.4, 10.0))),
        Just(with_side(&CutterSpec::lens(30.0, 1.0, 10.0))),
    ]
}

fn with_side(spec: &CutterSpec) -> Cutter {
    Cutter::new(CutterSpec {
        length: 120.0,
        shank: vec![[30.0, 5.0], [40.0, 11.0]],
        ..spec.clone()
    })
    .unwrap()
}

/// Point of a cutter with a side that is farthest against a direction.
fn lowest(cutter: &Cutter, pose: &ToolPose, normal: &Vector3<f64>) -> Option<Point3<f64>> {
    let up = -normal.dot(&pose.axis);
    let out = -normal - pose.axis.into_inner() * up;
    let [rho, z] = cutter.tangent_profile()?.farthest([out.norm(), up]);
    Some(pose.tip + pose.axis.into_inner() * z + out.normalize() * rho)
}

proptest! {
    #![proptest_config(ProptestConfig { max_shrink_iters: 0, ..property::cases(8) })]

    /// Heights over a small curved face against dense sampling of time and ray by the outline of
    /// the tool, on tilting moves, with and without TCP.
    #[test]
    fn heights_agree_with_brute_force(
        cutter in any_cutter(),
        layout in prop_oneof![Just(Layout::TableTable), Just(Layout::HeadHead)],
        tcp: bool,
        start in prop::array::uniform5(-1.0..1.0f64),
        changes in prop::collection::vec(prop::array::uniform5(-1.0..1.0f64), 1..4),
        tilt in prop::array::uniform2(-0.5..0.5f64),
        bulge in prop::array::uniform3(-0.4..0.4f64),
        gap in -0.3..0.3f64,
        aside in 0.1..1.4f64,
    ) {
        let mut machine = shop::machine(layout);
        let scale = AxisVector::new(2.0, 2.0, 0.5, 0.03, 0.03);
        let mut q = AxisVector::new(-350.0, -240.0, -200.0, 0.4, 0.3)
            + AxisVector::from(start).component_mul(&scale);
        // The machine starts where the program does, so that brute force sees every move.
        machine.axes.iter_mut().zip(q.iter()).for_each(|(axis, &q)| axis.home = q);
        let kinematics = Kinematics::new(&machine, &shop::setup(layout));
        let block = |q: AxisVector, duration| {
            Block { motion: Motion::Cut, q, pose: kinematics.forward(&q), duration }
        };
        let mut blocks = vec![block(q, 0.0)];
        for change in &changes {
            q += AxisVector::from(*change).component_mul(&scale);
            blocks.push(block(q, 0.1));
        }
        let pose = blocks[0].pose;
        let up = Rotation3::rotation_between(&Vector3::z(), &pose.axis).unwrap();
        let mut turn = up * Rotation3::from_euler_angles(tilt[0], tilt[1], 0.0);
        let lean = tilt[0].hypot(tilt[1]) * cutter.radius();
        let mut place = pose.tip - pose.axis.into_inner() * (gap + 0.3 * lean);
        if cutter.tangent_profile().is_some() {
            // The face lies at the tip arc, at the side or at the flank.
            turn = up * Rotation3::from_euler_angles(aside, 0.3 * tilt[1], 0.0);
            let normal = turn * Vector3::z();
            if let Some(point) = lowest(&cutter, &pose, &normal) {
                place = point - normal * gap;
            }
        }
        let face = patch(place, turn, 5.0, bulge);
        let (text, _) = program(&kinematics, &blocks, tcp);
        let program = parse(&text.replace("G53 G0 Z0.", ""), &machine);
        let input = CheckInput::program(&program, &kinematics, &cutter).faces(std::slice::from_ref(&face));
        let options = CheckOptions { grid: 2.0, ..OPTIONS };
        let report = verify::check(&input, &options, &Silent).unwrap();
        prop_assert_eq!(report.deviation.unmeasured, 0);
        let samples = 60;
        for sample in report.maps[0].samples.iter().flatten() {
            let n = face.normal(sample.uv.u, sample.uv.v).unwrap().into_inner();
            let lowest = |from: f64, to: f64, pair: &[Block]| {
                (0..=samples).filter_map(|k| {
                    let t = from + (to - from) * f64::from(k) / f64::from(samples);
                    let pose = pose_at(&kinematics, pair, t, tcp);
                    first_inside(&cutter, &pose, sample.point, n).map(|s| (s, t))
                }).min_by(|a, b| a.0.total_cmp(&b.0))
            };
            // Coarse over each move, then fine around the best time.
            let brute = blocks.windows(2).filter_map(|pair| {
                let (s, t) = lowest(0.0, 1.0, pair)?;
                let around = 2.0 / f64::from(samples);
                let fine = lowest((t - around).max(0.0), (t + around).min(1.0), pair);
                Some(fine.map_or(s, |(fine, _)| fine.min(s)))
            }).min_by(f64::total_cmp);
            let found = sample.height;
            // What was found lower than sampling could is at least touched at some time.
            let touched = |s: f64| {
                let p = sample.point + n * s;
                blocks.windows(2).any(|pair| {
                    (0..=10_000).any(|k| {
                        let pose = pose_at(&kinematics, pair, f64::from(k) / 1e4, tcp);
                        inside(&cutter, &pose, &p, 3e-4)
                    })
                })
            };
            // Within the tolerance the distance from the nearest cutting end counts, where it is less than along the normal.
            let near = |s: f64| {
                let grow = s + 3e-4;
                s <= OPTIONS.total
                    && blocks.windows(2).any(|pair| {
                        (0..=10_000).any(|k| {
                            let pose = pose_at(&kinematics, pair, f64::from(k) / 1e4, tcp);
                            inside(&cutter, &pose, &sample.point, grow)
                        })
                    })
            };
            let right = |s: f64| touched(s) || near(s);
            match (brute, found) {
                (Some(brute), Some(found)) => {
                    prop_assert!(found <= brute + 1.001e-4, "missed {brute}, found {found}");
                    let right = found >= brute - 1e-5 || right(found);
                    prop_assert!(right, "found {found}, sampling only {brute}");
                }
                (Some(brute), None) => prop_assert!(brute > OPTIONS.reach - 1e-3, "missed {brute}"),
                (None, Some(found)) => prop_assert!(right(found), "only {found}"),
                (None, None) => {}
            }
        }
    }
}

/// The pose a control makes between two blocks.
fn pose_at(kinematics: &Kinematics, pair: &[Block], t: f64, tcp: bool) -> ToolPose {
    let q = pair[0].q + (pair[1].q - pair[0].q) * t;
    let mut pose = kinematics.forward(&q);
    if tcp {
        pose.tip = pair[0].pose.tip + (pair[1].pose.tip - pair[0].pose.tip) * t;
    }
    pose
}

/// A ball cutter on a small patch: rows of blocks with a swinging tilt.
struct Job {
    machine: Machine,
    setup: Setup,
    face: Face,
    cutter: Cutter,
    text: String,
}

const RADIUS: f64 = 5.0;
const HALF: f64 = 4.0;
/// Blocks of a row.
const STEPS: u32 = 16;

impl Job {
    fn new() -> Self {
        let machine = shop::machine(Layout::TableTable);
        let setup = shop::setup(Layout::TableTable);
        let kinematics = Kinematics::new(&machine, &setup);
        let face = patch(Point3::origin(), Rotation3::identity(), 2.0 * HALF, [0.1, -0.1, 0.0]);
        let cutter = cutter(CutterKind::Ball, 0.0, RADIUS);
        let (text, _) = program(&kinematics, &blocks(&kinematics, &face), true);
        Self { machine, setup, face, cutter, text }
    }

    fn check_text(&self, text: &str) -> Report {
        self.check_with(text, &self.machine, &self.setup)
    }

    /// Checks a text; the control believes in the job's setup, `real` is the true one.
    fn check_with(&self, text: &str, machine: &Machine, real: &Setup) -> Report {
        let program = parse(text, machine);
        let [believed, real] = [&self.setup, real].map(|setup| Kinematics::new(machine, setup));
        let input = CheckInput::program(&program, &believed, &self.cutter)
            .machine(&real)
            .faces(std::slice::from_ref(&self.face));
        verify::check(&input, &CheckOptions { grid: 0.1, ..OPTIONS }, &Silent).unwrap()
    }

    /// Number (from 1) and text of a cutting line in the middle of the program.
    fn middle_line(&self) -> (u32, &str) {
        let lines: Vec<_> = self.text.lines().collect();
        let at = lines.len() / 2;
        assert!(lines[at].starts_with("G1") && lines[at].contains('Z') && lines[at].contains('B'));
        (u32::try_from(at + 1).unwrap(), lines[at])
    }

    /// The text with one line changed.
    fn with_line(&self, number: u32, line: &str) -> String {
        posted::with_line(&self.text, number, line)
    }
}

/// From above down to the first row, over all rows and up again.
fn blocks(kinematics: &Kinematics, face: &Face) -> Vec<Block> {
    let pose = |x: f64, y: f64, lift: f64| {
        let [u, v] = [0.5 + 0.5 * x / HALF, 0.5 + 0.5 * y / HALF];
        let normal = face.normal(u, v).unwrap();
        let tilt = 0.3 + 0.12 * (PI * y / HALF).cos();
        let axis = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt) * normal;
        let centre = face.point(u, v) + normal.into_inner() * (RADIUS + lift);
        ToolPose { tip: centre - axis.into_inner() * RADIUS, axis }
    };
    let rows = 12;
    let mut poses = Vec::new();
    for row in 0..=rows {
        let x = (HALF + 0.5) * (2.0 * f64::from(row) / f64::from(rows) - 1.0);
        for step in 0..=STEPS {
            let y = HALF * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
            poses.push(pose(x, if row % 2 == 0 { y } else { -y }, 0.0));
        }
    }
    let (first, last) = (-HALF - 0.5, HALF + 0.5);
    poses.insert(0, pose(first, -HALF, 20.0));
    poses.push(pose(last, HALF, 20.0));
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

fn messages(report: &Report) -> Vec<String> {
    report.findings.iter().map(ToString::to_string).collect()
}

/// Line of the worst gouge, and how deep it is.
fn gouge(report: &Report) -> Option<(u32, f64)> {
    report.findings.iter().find_map(|finding| match finding {
        Finding::Gouge(worst) => Some((worst.line, -worst.height)),
        _ => None,
    })
}

#[test]
fn a_clean_program_passes() {
    let report = Job::new();
    let report = report.check_text(&report.text);
    assert!(report.passed(), "{:?}", messages(&report));
    let deviation = &report.deviation;
    let high = deviation.highest.unwrap().height;
    assert!(high > 0.005, "rows 0.75 mm apart leave 14 um scallops, found {high}");
    assert!((deviation.area - 64.0).abs() < 0.5, "{}", deviation.area);
    let binned: f64 = deviation.histogram.iter().map(|bin| bin.area).sum();
    assert!((binned - deviation.area).abs() < 1e-9);
}

#[test]
fn a_gouge_of_five_micrometres_in_one_block_is_found() {
    let job = Job::new();
    let (number, line) = job.middle_line();
    let text = job
        .with_line(number, &posted::reworded(line, 'Z', |z| z - 0.005 / 20f64.to_radians().cos()));
    let (found, depth) = gouge(&job.check_text(&text)).unwrap();
    assert!(found == number || found == number + 1, "line {found}, planted in {number}");
    assert!((0.0045..0.0075).contains(&depth), "{depth}");
}

#[test]
fn a_flipped_sign_in_one_rotary_word_is_found() {
    let job = Job::new();
    let (number, line) = job.middle_line();
    let report = job.check_text(&job.with_line(number, &posted::reworded(line, 'B', |b| -b)));
    let (found, depth) = gouge(&report).unwrap();
    assert!(found == number || found == number + 1, "line {found}, planted in {number}");
    assert!(depth > 0.1, "{depth}");
}

#[test]
fn a_block_deleted_where_it_matters_is_found() {
    let job = Job::new();
    let clean = job.check_text(&job.text).deviation.highest.unwrap().height;
    // Without the first block of a row, the step from row to row cuts the corner at the border.
    let first = job.text.lines().position(|line| line.starts_with("G1")).unwrap();
    let corner = first + 6 * (STEPS as usize + 1);
    let text = job.with_line(u32::try_from(corner + 1).unwrap(), "");
    let highest = job.check_text(&text).deviation.highest.unwrap();
    assert!(highest.height > clean + 0.002, "{} after {clean}", highest.height);
    assert!((highest.point.y.abs() - HALF).abs() < 0.3, "{}", highest.point);
}

#[test]
fn a_wrong_tool_length_is_found() {
    let job = Job::new();
    let length = job.setup.tool_length;
    let longer = Setup { tool_length: length + 0.05, ..job.setup };
    let (_, depth) = gouge(&job.check_with(&job.text, &job.machine, &longer)).unwrap();
    assert!((0.04..0.055).contains(&depth), "{depth}");
    let shorter = Setup { tool_length: length - 0.05, ..job.setup };
    let report = job.check_with(&job.text, &job.machine, &shorter);
    assert!(matches!(report.findings[..], [Finding::Excess(_), ..]), "{:?}", messages(&report));
}

#[test]
fn an_axis_one_percent_too_fast_is_found() {
    let job = Job::new();
    let clean = job.check_text(&job.text);
    let mut machine = job.machine.clone();
    let fastest = |index: usize| clean.audit.as_ref().unwrap().axes[index].velocity;
    for index in 0..5 {
        machine.axes[index].vel *= fastest(index).raw * 1.0001;
    }
    let report = job.check_with(&job.text, &machine, &job.setup);
    assert!(report.passed(), "{:?}", messages(&report));
    let line = fastest(4).line;
    let old = job.text.lines().nth(line as usize - 1).unwrap();
    let text = job.with_line(line, &posted::reworded(old, 'F', |f| f * 1.0101));
    let report = job.check_with(&text, &machine, &job.setup);
    let velocity = |finding: &Finding| match finding {
        Finding::Velocity { axis, worst } if axis == "B" => Some(*worst),
        _ => None,
    };
    let worst = report.findings.iter().find_map(velocity).unwrap();
    assert_eq!((worst.line, worst.broken), (line, 1));
    assert!((worst.worst - 1.01).abs() < 1e-3, "{}", worst.worst);
}

#[test]
fn an_axis_that_accelerates_too_much_is_found() {
    let job = Job::new();
    let clean = job.check_text(&job.text);
    let mut machine = job.machine.clone();
    let hardest = clean.audit.as_ref().unwrap().axes[4].acceleration;
    machine.axes[4].acc *= hardest.worst / 1.01;
    let report = job.check_with(&job.text, &machine, &job.setup);
    let acceleration = |finding: &Finding| match finding {
        Finding::Acceleration { axis, worst } => Some((axis.clone(), worst.line)),
        _ => None,
    };
    let found: Vec<_> = report.findings.iter().filter_map(acceleration).collect();
    assert_eq!(found, [("B".to_owned(), hardest.line)]);
}

#[test]
fn leaving_the_travel_is_found() {
    let job = Job::new();
    let clean = job.check_text(&job.text);
    let mut machine = job.machine.clone();
    for (axis, audit) in machine.axes.iter_mut().zip(&clean.audit.as_ref().unwrap().axes) {
        axis.limits = audit.range.widened(0.01);
    }
    assert!(job.check_with(&job.text, &machine, &job.setup).passed());
    let (number, line) = job.middle_line();
    let text = job.with_line(number, &posted::reworded(line, 'Z', |z| z - 60.0));
    let report = job.check_with(&text, &machine, &job.setup);
    let travel = |finding: &Finding| match finding {
        Finding::Travel { axis, worst } if axis == "Z" => Some(worst.line),
        _ => None,
    };
    assert_eq!(report.findings.iter().find_map(travel), Some(number));
    // Deeper than is looked for: not reported as a depth.
    let reported = messages(&report);
    assert!(
        reported.iter().any(|line| line.contains("gouge of 3.0000 mm or more")),
        "{reported:?}"
    );
}

#[test]
fn what_no_tool_reaches_is_uncut() {
    let mut job = Job::new();
    job.face = patch(Point3::origin(), Rotation3::identity(), 40.0, [0.0; 3]);
    let report = job.check_text(&job.text);
    let area = report.findings.iter().find_map(|finding| match finding {
        Finding::Uncut { area, .. } => Some(*area),
        _ => None,
    });
    // 40 mm square less the rows, less what lies within the reach beside them.
    assert!(area.is_some_and(|area| area > 1200.0 && area < 1520.0), "{area:?}");
}

/// The other side of a wall, 0.8 mm below what is cut: the tool stands within reach of it and does not touch it. Where it
/// lies 0.05 mm higher than what is cut, the tool comes through.
#[test]
fn a_tool_behind_a_thin_wall_is_no_gouge_and_one_through_it_is() {
    let job = Job::new();
    let kinematics = Kinematics::new(&job.machine, &job.setup);
    let program = parse(&job.text, &job.machine);
    let gouge_at = |z: f64| {
        let front = patch(Point3::new(0.0, 0.0, z), Rotation3::identity(), 6.0, [0.1, -0.1, 0.0]);
        let back = Face::new(2, front.surface, Vec::new()).unwrap().flipped();
        let input = CheckInput::program(&program, &kinematics, &job.cutter)
            .faces(std::slice::from_ref(&back));
        gouge(&verify::check(&input, &CheckOptions { grid: 0.2, ..OPTIONS }, &Silent).unwrap())
    };
    assert_eq!(gouge_at(-0.8), None);
    assert_eq!(gouge_at(-0.05), None);
    assert!(gouge_at(0.05).is_some());
}

#[test]
fn the_same_report_on_one_and_two_threads() {
    let job = Job::new();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| job.check_text(&job.text))
    };
    assert_eq!(on(1), on(2));
}

/// A program that stays text is checked as its steps are.
#[test]
fn the_same_report_from_steps_and_from_text() {
    let job = Job::new();
    let plain = job.check_text(&job.text);
    let options = ReadOptions::new(Dialect::LinuxCnc, words(&job.machine), 5);
    let text = read::ProgramText::new(job.text.clone(), options).unwrap();
    let kinematics = Kinematics::new(&job.machine, &job.setup);
    let (believed, real) = (&kinematics, &kinematics);
    let (faces, cutter) = (std::slice::from_ref(&job.face), &job.cutter);
    let input = CheckInput::program(&text, believed, cutter).machine(real).faces(faces);
    let options = CheckOptions { grid: 0.1, ..OPTIONS };
    assert_eq!(verify::check(&input, &options, &Silent).unwrap(), plain);
}

#[test]
fn a_stop_on_request_stops() {
    struct Stop;
    impl trunnion::types::Progress for Stop {
        fn report(&self, _: trunnion::types::Stage, _: u64, _: u64) -> std::ops::ControlFlow<()> {
            std::ops::ControlFlow::Break(())
        }
    }
    let job = Job::new();
    let program = parse(&job.text, &job.machine);
    let kinematics = Kinematics::new(&job.machine, &job.setup);
    let faces = std::slice::from_ref(&job.face);
    let (believed, real, cutter) = (&kinematics, &kinematics, &job.cutter);
    let input = CheckInput::program(&program, believed, cutter).machine(real).faces(faces);
    let stopped = verify::check(&input, &OPTIONS, &Stop);
    assert!(matches!(stopped, Err(verify::VerifyError::Cancelled(_))));
}
