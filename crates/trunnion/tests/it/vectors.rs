//! Programs whose tool axis is a vector, against the same cutter locations, and what they leave unknown.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::dice;

use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, ClFile, ClMotion, ClPath, ClRecord, Dialect, Program, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::{AxisVector, Silent, ToolPose};
use trunnion::verify::{self, CheckInput, CheckOptions, DeviationTolerance, Report, VerifyError};

const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");
const LENGTH: f64 = 100.0;
const OPTIONS: CheckOptions = CheckOptions {
    reach: 3.0,
    ray_tolerance: 1e-5,
    most_points: 100_000,
    bounds: None,
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 1.0)
};

/// The workpiece is turned about x, so that the table frame is not its own.
fn kinematics() -> Kinematics {
    let machine = machine::parse(MACHINE).unwrap().machine;
    let origin = Vector3::new(-381.0, -254.0, -505.0);
    Kinematics::new(&machine, &Setup::new(origin, [0.3, 0.0, 0.0], LENGTH))
}

fn cutter() -> Cutter {
    let (major, minor) = (4.0, 2.0);
    Cutter::new(CutterSpec { length: LENGTH, ..CutterSpec::of_radii(major, minor) }).unwrap()
}

/// 20 mm square at height 0 of the workpiece.
fn face() -> Face {
    let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let points =
        vec![vec![at(-10.0, -10.0), at(-10.0, 10.0)], vec![at(10.0, -10.0), at(10.0, 10.0)]];
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::new([1, 1], [knots(), knots()], points, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// Zigzag that leans this way and that, and dips by some hundredths.
fn poses() -> Vec<ToolPose> {
    (0..12_u8)
        .map(|row| {
            let k = f64::from(row);
            let x = if row % 4 == 0 || row % 4 == 3 { -12.0 } else { 12.0 };
            let lean = Vector3::new(0.1 * (0.7 * k).sin(), 0.05 + 0.1 * (1.3 * k).cos(), 1.0);
            let tip = Point3::new(x, f64::from(row / 2) * 4.0 - 10.0, 0.3 + 0.05 * (2.0 * k).sin());
            ToolPose { tip, axis: UnitVector3::new_normalize(lean) }
        })
        .collect()
}

/// Numbers of a pose in the table frame: tip, and axis.
fn coordinates(pose: &ToolPose) -> [f64; 6] {
    let table = Rotation3::from_euler_angles(0.3, 0.0, 0.0);
    let (tip, axis) = (table * pose.tip, table * pose.axis);
    [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z]
}

fn siemens(pose: &ToolPose) -> String {
    let [x, y, z, i, j, k] = coordinates(pose);
    format!("X{x:.9} Y{y:.9} Z{z:.9} A3={i:.12} B3={j:.12} C3={k:.12}")
}

fn fanuc(pose: &ToolPose) -> String {
    let [x, y, z, i, j, k] = coordinates(pose);
    format!("X{x:.9} Y{y:.9} Z{z:.9} I{i:.12} J{j:.12} K{k:.12}")
}

fn heidenhain(pose: &ToolPose) -> String {
    let [x, y, z, i, j, k] = coordinates(pose);
    format!("LN X{x:+.9} Y{y:+.9} Z{z:+.9} TX{i:+.12} TY{j:+.12} TZ{k:+.12}")
}

fn parse(text: &str, dialect: Dialect) -> Program {
    let words = AxisWords::of(kinematics().machine()).unwrap();
    read::read(text, &ReadOptions::new(dialect, words, 5)).unwrap()
}

fn check(text: &str, dialect: Dialect) -> Result<Report, VerifyError> {
    let (program, kinematics) = (parse(text, dialect), kinematics());
    let (faces, cutter) = ([face()], cutter());
    let (believed, real) = (&kinematics, &kinematics);
    let input = CheckInput::program(&program, believed, &cutter).machine(real).faces(&faces);
    verify::check(&input, &OPTIONS, &Silent)
}

/// The cuts between the poses as cutter locations.
fn by_locations(poses: &[ToolPose]) -> Report {
    let record = |(line, &pose): (u32, &ToolPose)| {
        let motion = if line == 1 { ClMotion::Rapid } else { ClMotion::Feed(10.0) };
        ClRecord { line, pose, motion, way: ClPath::Straight }
    };
    let records = (1..).zip(poses).map(record).collect();
    let file = ClFile { records, ..ClFile::default() };
    let (faces, cutter) = ([face()], cutter());
    let input = CheckInput::locations(&file, &cutter).faces(&faces);
    verify::check(&input, &OPTIONS, &Silent).unwrap()
}

/// Heights of both at every point; the rest of a program is clear of the part.
fn assert_alike(of: &Report, wanted: &Report, name: &str) {
    let heights = |report: &Report| -> Vec<Option<f64>> {
        let samples = report.maps.iter().flat_map(|map| &map.samples);
        samples.map(|sample| sample.as_ref().and_then(|sample| sample.height)).collect()
    };
    let (a, b) = (heights(of), heights(wanted));
    assert!(a.len() > 400 && a.len() == b.len());
    assert!(b.iter().flatten().count() > 300, "the passes reach most of the face");
    for (a, b) in a.iter().zip(&b) {
        let off = a.zip(*b).map_or(0.0, |(a, b)| (a - b).abs());
        assert!(a.is_some() == b.is_some() && off < 3e-5, "{name}: {a:?} {b:?}");
    }
}

fn lines(begin: &str, poses: &[ToolPose], word: fn(&ToolPose) -> String, end: &str) -> String {
    let mut text = begin.to_owned();
    for pose in poses {
        text += &(word(pose) + "\n");
    }
    text + end
}

/// High over the part, the tool upright to the first pose.
fn above(poses: &[ToolPose]) -> ToolPose {
    ToolPose { tip: poses[0].tip + Vector3::z() * 60.0, axis: poses[0].axis }
}

#[test]
fn vectors_are_measured_as_the_cutter_locations_they_are() {
    let poses = poses();
    let wanted = by_locations(&poses);
    let over = above(&poses);
    let begin = format!("G90 G94 G54\nTRAORI\nORIWKS ORIVECT\nG0 {}\nG1 F600\n", siemens(&over));
    let text = lines(&begin, &poses, siemens, "TRAFOOF\nG0 SUPA Z0 D0\nM30\n");
    let report = check(&text, Dialect::Siemens).unwrap();
    assert_alike(&report, &wanted, "siemens");
    let (choices, first) = (&report.choices, report.choices.places[0]);
    assert_eq!((choices.vectors, choices.planes, choices.more), (poses.len() + 1, 0, 0));
    assert_eq!((first.line, first.plane, report.changes), (4, false, None));
    assert!(report.audit.is_some());

    let begin = format!("G21 G90 G94 G54\nG0 G43.5 H1 {}\nG1 F600.\n", fanuc(&over));
    let report = check(&lines(&begin, &poses, fanuc, "M30\n"), Dialect::Fanuc).unwrap();
    assert_alike(&report, &wanted, "fanuc");
    assert_eq!((report.choices.vectors, report.changes), (poses.len() + 1, None));

    let begin = "BEGIN PGM A MM\nTOOL CALL 1 Z\nFUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\n";
    let begin = format!("{begin}{} FMAX\n", heidenhain(&over));
    let report = check(
        &lines(&begin, &poses, |pose| heidenhain(pose) + " F600", "M30\nEND PGM A MM\n"),
        Dialect::Heidenhain,
    );
    assert_alike(&report.unwrap(), &wanted, "heidenhain");
}

#[test]
fn ways_between_vectors_are_run_on_the_branch_that_was_taken() {
    let poses = poses();
    let (first, second) = poses.split_at(6);
    let cuts = |poses: &[ToolPose]| {
        let begin = format!("TRAORI\nG0 {}\nG1 F600\n", siemens(&above(poses)));
        lines(&begin, poses, siemens, &format!("G0 {}\nTRAFOOF\n", siemens(&above(poses))))
    };
    // Away on the branch that was taken, and back.
    let between = "G0 SUPA Z0 D0\nG0 SUPA X-300 Y-200 B0 C0\nT=1 D1\nG0 SUPA Z-10\n";
    let text = format!("G90 G94 G54\n{}{between}{}M30\n", cuts(first), cuts(second));
    let report = check(&text, Dialect::Siemens).unwrap();
    assert_eq!((report.choices.vectors, report.changes), (poses.len() + 4, None));
    let [a, b] = [by_locations(first), by_locations(second)];
    let lowest = |report: &Report| report.deviation.lowest.unwrap().height;
    assert!((lowest(&report) - lowest(&a).min(lowest(&b))).abs() < 3e-5);
}

/// Past the direction of the first rotary a great circle turns it by up to half a turn, and never into the other solution:
/// one block, or the same in 200 blocks, leads to the same axes.
#[test]
fn a_great_circle_keeps_the_solution_of_the_rotaries() {
    let mut dice = dice::Random(11);
    // C and B over the whole program [rad].
    let ranges = |axes: &[UnitVector3<f64>]| {
        let block = |axis: &UnitVector3<f64>| {
            format!("X0 Y0 Z50 A3={:.12} B3={:.12} C3={:.12}\n", axis.x, axis.y, axis.z)
        };
        let [first, rest @ ..] = axes else { unreachable!("there is a first direction") };
        let rest: String = rest.iter().map(block).collect();
        let text = format!(
            "G90 G94 G54\nTRAORI\nORIWKS ORIVECT\nG0 {}G1 F6000\n{rest}TRAFOOF\nG0 SUPA Z0 D0\nM30\n",
            block(first)
        );
        let (program, kinematics, cutter) =
            (parse(&text, Dialect::Siemens), kinematics(), cutter());
        let input = CheckInput::program(&program, &kinematics, &cutter).machine(&kinematics);
        let report = verify::check(&input, &OPTIONS, &Silent).unwrap();
        assert_eq!(report.choices.places.len(), 1, "{:?}", report.choices);
        let audit = report.audit.unwrap();
        [3, 4].map(|slot| audit.axes[slot].range.ends())
    };
    let mut swung = 0;
    for _ in 0..60 {
        let [from, to] = [(); 2].map(|()| {
            let [x, y] = [(); 2].map(|()| dice.within(-0.4, 0.4));
            UnitVector3::new_normalize(Vector3::new(x, y, 1.0))
        });
        // Between the solutions nothing is steep, but at the pole itself.
        let near_pole = from.cross(&to).z.abs() / from.cross(&to).norm() < 0.02;
        if near_pole || from.angle(&to) < 0.05 {
            continue;
        }
        let between = |k: u32| from.slerp(&to, f64::from(k) / 200.0);
        let dense: Vec<_> = (0..=200).map(between).collect();
        let [one, many] = [ranges(&[from, to]), ranges(&dense)];
        for (one, many) in one.iter().flatten().zip(many.iter().flatten()) {
            assert!((one - many).abs() < 0.01, "{from:?} {to:?}: {one} {many}");
        }
        swung += usize::from(many[0][1] - many[0][0] > 1.8);
    }
    assert!(swung > 5, "{swung} swing C by more than a hundred degrees");
}

#[test]
fn what_cannot_be_followed_is_refused_with_line_and_remedy() {
    let pose = above(&poses());
    let refused = |rest: &str| {
        let begin = format!("G90 G94 G54\nTRAORI\nG0 {}\n", siemens(&pose));
        let refused = check(&(begin + rest + "M30\n"), Dialect::Siemens).map(|_| ());
        refused.unwrap_err().to_string()
    };
    let reported = refused("G17 G2 X-2 I5 J0 A3=0 B3=0 C3=1 F100\n");
    assert!(reported.starts_with("line 4: an arc between tool vectors"), "{reported}");
}

/// The rotaries that are taken for a vector are those of the makers' inverse, which shares nothing with the check.
#[test]
fn rotaries_are_those_of_the_inverse() {
    let mut dice = dice::Random(5);
    for (name, text) in machine::BUILT_IN {
        let machine = machine::parse(text).unwrap().machine;
        let setup = Setup::new(Vector3::new(3.0, -8.0, -40.0), [0.2, -0.1, 0.4], LENGTH);
        let kinematics = Kinematics::new(&machine, &setup);
        let inverse = trunnion::inverse::Inverse::new(&kinematics).unwrap();
        let words = AxisWords::of(&machine).unwrap();
        let mut compared = 0;
        for _ in 0..40 {
            let home = machine.home();
            let turns = [0, 1].map(|slot| {
                let [low, high] =
                    machine.axes[3 + slot].limits.ends().map(|limit| limit.clamp(-3.0, 3.0));
                low + (high - low) * dice.within(0.0, 1.0)
            });
            let middle = |slot: usize| {
                let [low, high] =
                    machine.axes[slot].limits.ends().map(|limit| limit.clamp(-1e3, 1e3));
                0.5 * (low + high)
            };
            let q = AxisVector::new(middle(0), middle(1), middle(2), turns[0], turns[1]);
            let pose = kinematics.forward(&q);
            let Ok(wanted) = inverse.near_inside(&pose, &home) else { continue };
            let table = setup.rotation * pose.axis;
            let tip = setup.rotation * pose.tip;
            let text = format!(
                "G90 G94 G54\nTRAORI\nG0 X{:.9} Y{:.9} Z{:.9} A3={:.15} B3={:.15} C3={:.15}\nM30\n",
                tip.x, tip.y, tip.z, table.x, table.y, table.z
            );
            let program = read::read(&text, &ReadOptions::new(Dialect::Siemens, words, 5)).unwrap();
            let (faces, cutter) = ([face()], cutter());
            let (believed, real, tables) = (&kinematics, &kinematics, verify::Tables::NONE);
            let input = CheckInput::program(&program, believed, &cutter)
                .machine(real)
                .faces(&faces)
                .tables(tables);
            let report =
                verify::check(&input, &CheckOptions { grid: 20.0, ..OPTIONS }, &Silent).unwrap();
            let taken = report.choices.places[0].taken;
            let off = (taken.first - wanted[3]).abs().max((taken.second - wanted[4]).abs());
            assert!(off < 1e-6, "{name}: {taken:?} {wanted:?}");
            compared += 1;
        }
        assert!(compared > 5, "{name}: {compared}");
    }
}
