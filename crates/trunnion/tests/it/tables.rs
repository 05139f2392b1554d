//! Programs with several tools, work offsets and tilted planes, against heights reckoned by hand.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::{Point3, Vector3};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords, ClText, Dialect, ReadOptions};
use trunnion::nc::write::work_offset;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::Silent;
use trunnion::verify::{
    self, CheckInput, CheckOptions, DeviationTolerance, Finding, Report, Solid, Stock, Tables,
    Tool, VerifyError, WorkOffset,
};

const MACHINE: &str = include_str!("../../../../machines/bc-trunnion.toml");
const OPTIONS: CheckOptions = CheckOptions {
    reach: 3.0,
    ray_tolerance: 1e-5,
    most_points: 100_000,
    bounds: None,
    ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 1.0)
};

fn kinematics() -> Kinematics {
    let machine = machine::parse(MACHINE).unwrap().machine;
    Kinematics::new(&machine, &Setup::new(Vector3::new(-381.0, -254.0, -505.0), [0.0; 3], 100.0))
}

fn flat(radius: f64, length: f64) -> Cutter {
    let (major, minor, shank) = (radius, 0.0, Vec::new());
    Cutter::new(CutterSpec { length, shank, ..CutterSpec::of_radii(major, minor) }).unwrap()
}

/// A flat face through three corners of a parallelogram, its normal `(b - a) x (c - a)`.
fn parallelogram(number: usize, [a, b, c]: [[f64; 3]; 3]) -> Face {
    let [a, b, c] = [a, b, c].map(Point3::from);
    let points = vec![vec![a, c], vec![b, b + (c - a)]];
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::new([1, 1], [knots(), knots()], points, None).unwrap();
    Face::new(number, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// A floor at height 0, and a wall on its far side.
fn floor_and_wall() -> [Face; 2] {
    let floor = [[-10.0, -10.0, 0.0], [10.0, -10.0, 0.0], [-10.0, 9.5, 0.0]];
    let wall = [[-10.0, 10.0, 0.5], [10.0, 10.0, 0.5], [-10.0, 10.0, 8.0]];
    [parallelogram(1, floor), parallelogram(2, wall)]
}

fn check(
    (text, dialect): (&str, Dialect),
    faces: &[Face],
    (cutter, tables): (&Cutter, Tables<'_>),
) -> Result<Report, VerifyError> {
    let kinematics = kinematics();
    let words = AxisWords::of(kinematics.machine()).unwrap();
    let program = read::read(text, &ReadOptions::new(dialect, words, 5)).unwrap();
    let (believed, real) = (&kinematics, &kinematics);
    let input =
        CheckInput::program(&program, believed, cutter).machine(real).faces(faces).tables(tables);
    verify::check(&input, &OPTIONS, &Silent)
}

/// All heights on a face are within a tenth of a micrometre of what `wanted` says of a place, where it says something.
fn assert_heights(report: &Report, face: usize, wanted: impl Fn(&Point3<f64>) -> Option<f64>) {
    let samples: Vec<_> = report.maps[face].samples.iter().flatten().collect();
    assert!(samples.len() > 100);
    for sample in samples {
        let (Some(wanted), height) = (wanted(&sample.point), sample.height) else { continue };
        let off = height.map_or(f64::INFINITY, |height| (height - wanted).abs());
        assert!(off < 1e-4, "{:?} {height:?}, wanted {wanted}", sample.point);
    }
}

/// Rows along X at these Y and this Z, from outside of the face.
fn rows(ys: &[f64], z: f64) -> String {
    let row = |y: &f64| format!("G0 Y{y}\nZ{z}\nG1 F600. X16.\nG0 Z40.\nX-16.\n");
    ys.iter().map(row).collect()
}

/// Tool 1 with a radius of 4 leaves 3 µm, tool 2 with one of 2 leaves 1 µm.
fn two_tools() -> String {
    format!(
        "G21 G90 G94 G17 G54 G49\nT1 M6\nG0 X-16. Y-10. B0. C0.\nG43 H1 Z40.\n{}G49\nT2 M6\nG0 X-16. Y2.\nG43 H2 Z40.\n{}M30\n",
        rows(&[-10.0, -4.0, 0.0], 0.003),
        rows(&[2.0, 5.0, 8.0], 0.001)
    )
}

#[test]
fn every_section_is_measured_with_its_own_tool() {
    let [one, two] = [flat(4.0, 100.0), flat(2.0, 80.0)];
    let table = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
    let tables = Tables { tools: &table, offsets: &[] };
    let faces = floor_and_wall();
    let check = |text: &str| check((text, Dialect::Fanuc), &faces, (&one, tables));
    let text = two_tools();
    let report = check(&text).unwrap();
    assert!(report.passed(), "{:?}", report.findings);
    assert_heights(&report, 0, |p| match p.y {
        y if y < -0.1 => Some(0.003),
        y if y > 0.1 => Some(0.001),
        _ => None,
    });
    assert_heights(&report, 1, |p| (p.z > 0.1).then_some(0.0));
    let changes = report.changes.unwrap();
    let line =
        |of: &str| u32::try_from(text.lines().position(|line| line == of).unwrap()).unwrap() + 1;
    assert_eq!((changes.count, changes.line), (1, line("T2 M6")));
    assert_eq!((changes.unmeasured, changes.first), (2, Some(line("T2 M6") + 1)));

    // The wrong number: the other tool is 2 mm into the wall.
    let wrong = check(&text.replace("T2 M6", "T1 M6")).unwrap();
    let found = wrong.findings.iter().find_map(|finding| match finding {
        Finding::Gouge(at) => Some(*at),
        _ => None,
    });
    let found = found.unwrap();
    assert!(found.face == 2 && (found.height + 2.0).abs() < 1e-3, "{found:?}");
    assert_eq!(found.line, line("G0 Y8") + 2);

    // What is refused, with its line.
    let error = check(&text.replace("T2 M6", "T7 M6")).unwrap_err();
    assert_eq!(error, VerifyError::UnknownTool { line: line("T2 M6"), number: 7 });
    let error = check(&text.replace("G43 H2 Z40.", "G43 H2 G1 F600. Z40.")).unwrap_err();
    assert_eq!(error, VerifyError::Unfollowed { line: line("T2 M6") + 2 });
    let error =
        check(&text.replace("T1 M6\n", "").replace("G43 H1", "G43 H1 G1 F600.")).unwrap_err();
    assert_eq!(error, VerifyError::NoTool { line: 3 });
    let error = self::check((&text, Dialect::Fanuc), &faces, (&one, Tables::NONE)).unwrap_err();
    assert_eq!(error, VerifyError::Tools { line: line("T2 M6"), numbers: [1, 2] });
}

#[test]
fn every_tool_of_a_cl_file_is_measured_where_it_is() {
    let [one, two] = [flat(4.0, 100.0), flat(2.0, 80.0)];
    let row = |y: f64, z: f64| {
        format!(
            "RAPID\nGOTO/-16,{y},40\nRAPID\nGOTO/-16,{y},{z}\nFEDRAT/600,MMPM\nGOTO/16,{y},{z}\nGOTO/16,{y},40\n"
        )
    };
    let rows = |ys: &[f64], z: f64| ys.iter().map(|y| row(*y, z)).collect::<String>();
    let text = format!(
        "UNITS/MM\nMULTAX/ON\nLOADTL/1\nGOTO/-16,-10,40,0,0,1\n{}LOADTL/2\n{}FINI\n",
        rows(&[-10.0, -4.0, 0.0], 0.003),
        rows(&[2.0, 5.0, 8.0], 0.001)
    );
    let faces = floor_and_wall();
    let check = |text: &str, tools: &[Tool<'_>]| {
        let file = ClText::new(text.to_owned(), 5).unwrap();
        let input = CheckInput::locations(&file, &one).faces(&faces).tools(tools);
        verify::check(&input, &OPTIONS, &Silent)
    };
    let tools = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
    let report = check(&text, &tools).unwrap();
    assert!(report.passed(), "{:?}", report.findings);
    assert_heights(&report, 0, |p| {
        (p.y.abs() > 0.1).then_some(if p.y < 0.0 { 0.003 } else { 0.001 })
    });
    let wrong = check(&text.replace("LOADTL/2", "LOADTL/1"), &tools).unwrap();
    assert!(matches!(wrong.findings[..], [Finding::Gouge(at)] if (at.height + 2.0).abs() < 1e-3));
    let line =
        |of: &str| u32::try_from(text.lines().position(|line| line == of).unwrap()).unwrap() + 1;
    let line = line("LOADTL/2") + 2;
    let error = check(&text, &[]).unwrap_err();
    assert_eq!(error, VerifyError::Tools { line, numbers: [1, 2] });
    assert_eq!(
        check(&text, &tools[..1]).unwrap_err(),
        VerifyError::UnknownTool { line, number: 2 }
    );
    let none = check(&text.replace("LOADTL/1\n", ""), &tools).unwrap_err();
    assert_eq!(none, VerifyError::NoTool { line: 3 });
}

#[test]
fn stock_is_cut_by_the_tool_in_the_spindle() {
    let text = format!(
        "G21 G90 G94 G17 G54 G49\nT1 M6\nG0 X-16. Y-4. B0. C0.\nG43 H1 Z40.\n{}G49\nT2 M6\nG0 X-16. Y5.\nG43 H2 Z40.\n{}M30\n",
        rows(&[-4.0], -1.0),
        rows(&[5.0], -2.0)
    );
    let [one, two] = [flat(4.0, 100.0), flat(2.0, 80.0)];
    let tools = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
    let kinematics = kinematics();
    let words = AxisWords::of(kinematics.machine()).unwrap();
    let program = read::read(&text, &ReadOptions::new(Dialect::Fanuc, words, 5)).unwrap();
    let removed = |tools: &[Tool<'_>]| {
        let solid =
            Solid::Box { low: Point3::new(-10.0, -10.0, -5.0), high: Point3::new(10.0, 10.0, 0.0) };
        let mut stock = Stock::new(&solid, 0.25, 1_000_000).unwrap();
        let (believed, real, tables) = (&kinematics, &kinematics, Tables { tools, offsets: &[] });
        let input = CheckInput::program(&program, believed, &one).machine(real).tables(tables);
        verify::simulate(
            &input,
            &mut stock,
            &verify::StockOptions { worst: 10, ..verify::StockOptions::within(1e-3) },
            &Silent,
        )
        .unwrap()
        .removed
    };
    // 20 x 8 x 1 and 20 x 4 x 2 mm.
    assert!((removed(&tools) - 320.0).abs() < 3.0, "{}", removed(&tools));
    // Both alike: 20 x 8 x 2 for the second.
    let alike = [tools[0], Tool { number: 2, cutter: &one }];
    assert!((removed(&alike) - 480.0).abs() < 5.0, "{}", removed(&alike));
}

const SHIFT: [f64; 3] = [5.0, -3.0, 2.0];

/// Rows over the floor, their words counted from `SHIFT`.
fn shifted(begin: &str, end: &str) -> String {
    let row = |y: f64| format!("G0 Y{y}\nZ-1.995\nG1 F600. X21.\nG0 Z38.\nX-21.\n");
    let rows: String = YS.into_iter().map(row).collect();
    format!("{begin}\nG0 X-21. Y-7. Z38.\n{rows}{end}")
}

/// The same in Klartext.
fn klartext(begin: &str) -> String {
    let row =
        |y: f64| format!("L Y{y:+} FMAX\nL Z-1.995 FMAX\nL X+21 F600\nL Z+38 FMAX\nL X-21 FMAX\n");
    let rows: String = YS.into_iter().map(row).collect();
    format!(
        "0 BEGIN PGM T MM\nTOOL CALL 1 Z S3000\n{begin}\nL X-21 Y-7 Z+38 R0 FMAX\n{rows}END PGM T MM\n"
    )
}

const YS: [f64; 5] = [-7.0, -2.0, 3.0, 8.0, 13.0];
const START: &str = "G21 G90 G94 G17";

fn shifted_origin() -> Vector3<f64> {
    work_offset(&kinematics()).unwrap() + Vector3::from(SHIFT)
}

fn with_offsets(
    text: &str,
    dialect: Dialect,
    offsets: &[WorkOffset],
) -> Result<Report, VerifyError> {
    let (cutter, faces) = (flat(4.0, 100.0), floor_and_wall());
    check((text, dialect), &faces[..1], (&cutter, Tables { tools: &[], offsets }))
}

#[test]
fn words_count_from_the_work_offset_that_is_active() {
    let at =
        |number: u8, by: f64| [WorkOffset { number, origin: shifted_origin() + Vector3::z() * by }];
    let tcp = |turned: &str| format!("{START} G55\nG0 B0. C{turned}\nG43.4 H1");
    let cases = [
        (shifted(&format!("{START} G55 G43 H1"), "M30\n"), Dialect::Fanuc, 1),
        (shifted(&format!("{START} G54.1 P3 G43 H1"), "M30\n"), Dialect::Fanuc, 11),
        (shifted(&format!("{START} G59.1 G43 H1"), "M2\n"), Dialect::LinuxCnc, 6),
        (shifted(&tcp("0."), "M30\n"), Dialect::Fanuc, 1),
        (shifted(&tcp("90."), "M30\n"), Dialect::Fanuc, 1),
        (shifted("G17 G90 G94 G505\nT1 D1\nM6", "M30\n"), Dialect::Siemens, 4),
        (klartext("CYCL DEF 247 Q339=+2"), Dialect::Heidenhain, 1),
    ];
    for (text, dialect, number) in &cases {
        let report = with_offsets(text, *dialect, &at(*number, 0.0)).unwrap();
        assert_heights(&report, 0, |_| Some(0.005));
        // 10 micrometres lower is found, and so is an offset that nobody named.
        let report = with_offsets(text, *dialect, &at(*number, -0.01)).unwrap();
        let gouge = matches!(report.findings[..], [Finding::Gouge(at), ..] if (at.height + 0.005).abs() < 1e-4);
        assert!(gouge, "{:?}", report.findings);
        let error = with_offsets(text, *dialect, &[]).unwrap_err();
        let first = text.lines().position(|line| line.contains("X-21") || line.contains("B0"));
        let line = u32::try_from(first.unwrap() + 1).unwrap();
        assert_eq!(error, VerifyError::WorkOffset { line, number: *number });
    }
}

#[test]
fn offsets_that_the_program_writes_are_read() {
    let [x, y, z]: [f64; 3] = shifted_origin().into();
    let [dx, dy, dz] = SHIFT;
    let reads = format!("X{} Y{} Z{}", -dx, -dy, 40.0 - dz);
    let there = format!("{START} G54 G43 H1\nG0 X0. Y0. Z40. B0. C0.\n");
    let written = [
        (format!("{START} G55 G43 H1\nG10 L2 P2 X{x} Y{y} Z{z}"), Dialect::LinuxCnc),
        (format!("{START} G54 G43 H1\nG10 L2 P1 X{x} Y{y} Z{z}"), Dialect::LinuxCnc),
        (format!("{START} G54 G43 H1\nG52 X{dx} Y{dy} Z{dz}"), Dialect::Fanuc),
        (format!("{there}G92 {reads}"), Dialect::LinuxCnc),
        (format!("{there}G10 L20 P2 {reads}\nG55"), Dialect::LinuxCnc),
        (format!("G17 G90 G94 G54\nT1 D1\nM6\nTRANS X{dx} Y{dy}\nATRANS Z{dz}"), Dialect::Siemens),
    ];
    for (begin, dialect) in written {
        let end = if dialect == Dialect::LinuxCnc { "M2\n" } else { "M30\n" };
        let report = with_offsets(&shifted(&begin, end), dialect, &[]).unwrap();
        assert_heights(&report, 0, |_| Some(0.005));
        let wrong = shifted(&begin, end).replace("Z-1.995", "Z-2.005");
        assert!(!with_offsets(&wrong, dialect, &[]).unwrap().passed());
    }
    let shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5\nCYCL DEF 7.2 Y-3\nCYCL DEF 7.3 Z+2";
    let report = with_offsets(&klartext(shift), Dialect::Heidenhain, &[]).unwrap();
    assert_heights(&report, 0, |_| Some(0.005));
    // What is not followed, with line and remedy.
    let refused = [
        ("G10 L2 P2 X0. Y0. Z0. C5.", "line 2: a work offset of a rotary axis"),
        ("G10 L2 P2 X0.", "line 2: a part of a work offset"),
    ];
    for (block, reported) in refused {
        let text = shifted(&format!("{START} G55 G43 H1\n{block}"), "M2\n");
        let error = with_offsets(&text, Dialect::LinuxCnc, &[]).unwrap_err().to_string();
        assert!(error.starts_with(reported) && error.contains("as axis positions"), "{error}");
    }
}

/// About z by 15 degrees, about the new y by 30; its origin at 10, -5, 20.
fn tilted([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (s, c) = 15.0_f64.to_radians().sin_cos();
    let (t, d) = 30.0_f64.to_radians().sin_cos();
    let (u, w) = (d * x + t * z, d * z - t * x);
    [10.0 + c * u - s * y, -5.0 + s * u + c * y, 20.0 + w]
}

const ROWS: [f64; 5] = [-10.0, -5.0, 0.0, 5.0, 10.0];

fn in_plane(begin: &str, end: &str) -> String {
    let row = |y: f64| format!("G0 X-16. Y{y}\nG0 Z1.\nG1 Z0.002 F300.\nG1 X16.\nG0 Z50.\n");
    format!("{begin}{}{end}", ROWS.into_iter().map(row).collect::<String>())
}

fn fanuc_plane(lean: &str, then: &str) -> String {
    let begin = format!(
        "G21 G90 G94 G54 G49\nT1 M6\nG68.2 X10. Y-5. Z20. I105. J{lean} K-90.\nG53.1\nG0 G43 H1 Z50.\n{then}"
    );
    in_plane(&begin, "G69\nG49\nM30\n")
}

fn klartext_plane(how: &str) -> String {
    let row =
        |y: f64| format!("L X-16 Y{y:+} FMAX\nL Z+1 FMAX\nL Z+0.002 F300\nL X+16\nL Z+50 FMAX\n");
    let rows: String = ROWS.into_iter().map(row).collect();
    format!(
        "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S3000\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\n\
         CYCL DEF 7.2 Y-5\nCYCL DEF 7.3 Z+20\n{how}\nL Z+50 R0 FMAX M3\n{rows}PLANE RESET STAY\n\
         END PGM T MM\n"
    )
}

fn measured_in_plane(text: &str, dialect: Dialect) -> Report {
    let corners = [[-10.0, -10.0, 0.0], [10.0, -10.0, 0.0], [-10.0, 10.0, 0.0]].map(tilted);
    let (face, cutter) = (parallelogram(1, corners), flat(4.0, 100.0));
    check((text, dialect), std::slice::from_ref(&face), (&cutter, Tables::NONE)).unwrap()
}

#[test]
fn a_tilted_plane_is_cut_where_it_is() {
    let siemens = |call: &str| {
        let begin = format!("G17 G90 G94 G54\nT1 D1\nM6\n{call}\nG0 Z50\n");
        in_plane(&begin, "CYCLE800()\nM30\n")
    };
    let spatial = "PLANE SPATIAL SPA+0 SPB+30 SPC+15";
    let euler = "PLANE EULER EULPR+105 EULNU+30 EULROT-90 TURN FMAX";
    let stay = format!("{spatial} STAY\nL B+Q121 C+Q122 R0 FMAX");
    let programs = [
        (fanuc_plane("30.", ""), Dialect::Fanuc),
        (klartext_plane(&format!("{spatial} TURN FMAX")), Dialect::Heidenhain),
        (klartext_plane(&format!("{spatial} MOVE DIST20 F2000")), Dialect::Heidenhain),
        (klartext_plane(&stay), Dialect::Heidenhain),
        (klartext_plane(euler), Dialect::Heidenhain),
        (siemens("CYCLE800(1,\"TC1\",200000,27,10,-5,20,15,30,0,0,0,0,1,0,1)"), Dialect::Siemens),
    ];
    for (text, dialect) in &programs {
        let report = measured_in_plane(text, *dialect);
        assert_heights(&report, 0, |_| Some(0.002));
        let (choices, first) = (&report.choices, report.choices.places[0]);
        assert_eq!((choices.planes, choices.vectors, first.plane), (1, 0, true));
        assert!((first.taken.second.abs() - 30f64.to_radians()).abs() < 1e-9, "{first:?}");
        assert!((first.other.unwrap().second + first.taken.second).abs() < 1e-9, "{first:?}");
        let travel = |finding: &Finding| matches!(finding, Finding::Travel { .. });
        assert!(report.findings.iter().all(travel), "{:?}", report.findings);
    }
}

#[test]
fn faults_in_a_tilted_plane_are_found() {
    // A tenth of a degree over 10 mm.
    let wrong = measured_in_plane(&fanuc_plane("30.1", ""), Dialect::Fanuc);
    let deepest = wrong.deviation.lowest.unwrap();
    let by_hand = 0.002 - 10.0 * 0.1f64.to_radians();
    assert!((deepest.height - by_hand).abs() < 2e-3, "{deepest:?} {by_hand}");
    // Half a ring, half a millimetre deep.
    let arc = "G0 X8. Y0.\nG1 Z-0.5 F300.\nG17 G3 X-8. Y0. I-8. J0.\nG0 Z50.\n";
    let grooved = measured_in_plane(&fanuc_plane("30.", arc), Dialect::Fanuc);
    assert!((grooved.deviation.lowest.unwrap().height + 0.5).abs() < 1e-4);
    let samples = grooved.maps[0].samples.iter().flatten();
    let deep = samples.filter(|sample| sample.height < Some(-0.4)).count();
    let ring = std::f64::consts::PI * (12.0_f64.powi(2) - 4.0_f64.powi(2)) / 2.0;
    assert!((deep as f64 - ring).abs() < 0.3 * ring, "{deep} {ring}");
}
