//! Holes in a tilted plane, in three languages, against the same holes reckoned by hand.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use nalgebra::Vector3;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions, Step};
use trunnion::post::{PostMove, PostPace, ProgramMoves};

fn kinematics() -> Kinematics {
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "bc-trunnion").unwrap();
    let setup = Setup::new(Vector3::new(-381.0, -254.0, -505.0), [0.0; 3], 120.0);
    Kinematics::new(&parse(text).unwrap().machine, &setup)
}

fn moves(text: &str, dialect: Dialect) -> Vec<PostMove> {
    let kinematics = kinematics();
    let axes = AxisWords::of(kinematics.machine()).unwrap();
    let program = read::read(text, &ReadOptions::new(dialect, axes, 5))
        .unwrap_or_else(|faults| panic!("{dialect}: {faults:?}"));
    let (mut replay, mut out) = (ProgramMoves::new(&kinematics, 1e-3).unwrap(), Vec::new());
    for step in &program.steps {
        replay.step(step, &mut out).unwrap();
    }
    out
}

/// About z by 15 degrees, about the new y by 30; its origin at 10, -5, 20.
fn in_part([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (s, c) = 15.0_f64.to_radians().sin_cos();
    let (t, d) = 30.0_f64.to_radians().sin_cos();
    let (u, w) = (d * x + t * z, d * z - t * x);
    [10.0 + c * u - s * y, -5.0 + s * u + c * y, 20.0 + w]
}

const HOLES: [[f64; 2]; 3] = [[1.0, 2.0], [11.0, 2.0], [6.0, -7.5]];

fn holes(over: &str, down: &str, up: &str) -> String {
    HOLES
        .iter()
        .map(|[x, y]| {
            let over = over.replace("{x}", &format!("{x:+}")).replace("{y}", &format!("{y:+}"));
            format!("{over}\n{down}\n{up}\n")
        })
        .collect()
}

#[test]
fn a_plane_is_the_same_in_every_language_and_as_reckoned_by_hand() {
    let fanuc = "G21 G90 G94 G54 G49\nT1 M6\nS3000 M3\nG68.2 X10. Y-5. Z20. I105. J30. K-90.\nG53.1\n\
                 G0 G43 H1 Z50.\n";
    let cycle = "G81 X1. Y2. Z-8. R2. F300.\nX11.\nX6. Y-7.5\nG80\n";
    let klartext = |how: &str| {
        let holes = holes("L X{x} Y{y} FMAX", "L Z+2 FMAX\nL Z-8 F300", "L Z+50 FMAX");
        format!(
            "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S3000\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\n\
             CYCL DEF 7.2 Y-5\nCYCL DEF 7.3 Z+20\n{how}\nL Z+50 R0 FMAX M3\n{holes}PLANE RESET STAY\n\
             END PGM T MM\n"
        )
    };
    let siemens = |call: &str| {
        let holes = holes("G0 X={x} Y={y}", "G0 Z2\nG1 Z-8 F300", "G0 Z50");
        format!("G17 G90 G94 G54\nT1 D1\nM6\nS3000 M3\n{call}\nG0 Z50\n{holes}CYCLE800()\nM30\n")
    };
    let spatial = "PLANE SPATIAL SPA+0 SPB+30 SPC+15";
    let programs = [
        (format!("{fanuc}{cycle}G69\nG49\nM30\n"), Dialect::Fanuc),
        (klartext(&format!("{spatial} TURN MBMAX FMAX SEQ- TABLE ROT")), Dialect::Heidenhain),
        (klartext(&format!("{spatial} MOVE DIST20 F2000")), Dialect::Heidenhain),
        (klartext(&format!("{spatial} STAY\nL B+Q121 C+Q122 R0 FMAX")), Dialect::Heidenhain),
        (klartext("PLANE EULER EULPR+105 EULNU+30 EULROT-90 TURN FMAX"), Dialect::Heidenhain),
        (
            klartext(
                "PLANE VECTOR BX+0.8365163 BY+0.2241439 BZ-0.5 NX+0.4829629 NY+0.1294095 NZ+0.8660254 TURN FMAX",
            ),
            Dialect::Heidenhain,
        ),
        (siemens("CYCLE800(1,\"TC1\",200000,27,10,-5,20,15,30,0,0,0,0,1,0,1)"), Dialect::Siemens),
        (siemens("CYCLE800(0,\"\",0,57,10,-5,20,7.435,0,0,0,0,0,1)"), Dialect::Siemens),
    ];
    let wanted: Vec<[f64; 3]> = HOLES.iter().map(|[x, y]| in_part([*x, *y, -8.0])).collect();
    let [from, to] = [in_part([0.0; 3]), in_part([0.0, 0.0, 1.0])];
    let normal = Vector3::from(to) - Vector3::from(from);
    for (index, (text, dialect)) in programs.iter().enumerate() {
        let moves = moves(text, *dialect);
        let cut: Vec<&PostMove> = moves.iter().filter(|one| one.pace != PostPace::Rapid).collect();
        assert_eq!(cut.len(), HOLES.len(), "{text}");
        // The last turns about x alone: another plane, which only has to be another.
        let other = index + 1 == programs.len();
        for (one, wanted) in cut.iter().zip(&wanted) {
            let off = (one.pose.tip.coords - Vector3::from(*wanted)).norm();
            let turned = (*one.pose.axis - normal).norm();
            assert_eq!(off < 1e-5 && turned < 1e-6, !other, "{text}\n{one:?} {wanted:?}");
        }
    }
}

#[test]
fn an_angle_about_x_alone_turns_about_x() {
    let text = "G17 G90 G94 G54\nT1 D1\nM6\nCYCLE800(0,\"\",0,57,0,0,0,10,0,0,0,0,0,1)\n\
                G0 X0 Y5 Z2\nG1 Z-8 F300\nCYCLE800()\nM30\n";
    let (s, c) = 10.0_f64.to_radians().sin_cos();
    let cut = moves(text, Dialect::Siemens).pop().unwrap();
    let wanted = Vector3::new(0.0, 5.0 * c + 8.0 * s, 5.0 * s - 8.0 * c);
    assert!((cut.pose.tip.coords - wanted).norm() < 1e-9, "{cut:?}");
}

#[test]
fn what_cannot_be_followed_is_refused_with_its_line() {
    let axes = AxisWords::of(kinematics().machine()).unwrap();
    let cases = [
        (Dialect::Heidenhain, "PLANE AXIAL B+30 TURN FMAX", "PLANE SPATIAL"),
        (Dialect::Heidenhain, "PLANE SPATIAL SPB+30", "MOVE"),
        (Dialect::Heidenhain, "PLANE SPATIAL SPB+30 STAY\nL X+1 F100", "TURN"),
        (Dialect::Heidenhain, "PLANE SPATIAL SPB+30 TURN\nCYCL DEF 7.1 X+1", "before PLANE"),
        (Dialect::Siemens, "CYCLE800(0,\"\",0,192,0,0,0,1,0,0,0,0,0,1)", "axis by axis"),
        (Dialect::Siemens, "CYCLE800(0,\"\",1,57,0,0,0,1,0,0,0,0,0,1)", "one call"),
        (Dialect::Siemens, "CYCLE800(0,\"\",0,57,0,0,0,1,0,0,0,0,0,0)\nG1 X1 F10", "direction"),
        (Dialect::Siemens, "TRANS X5\nCYCLE800(0,\"\",0,57,0,0,0,1,0,0,0,0,0,1)", "TRANS"),
    ];
    for (dialect, words, reported) in cases {
        let start = if dialect == Dialect::Siemens { "G90 G54" } else { "0 BEGIN PGM T MM" };
        let text = format!("{start}\n{words}\n");
        let faults = read::read(&text, &ReadOptions::new(dialect, axes, 5)).unwrap_err();
        let fault = faults.first().unwrap();
        let said = fault.to_string();
        assert!(said.contains(reported) && fault.line >= 2, "{words}: {said}");
    }
    // Planes are steps of their own for whoever follows them.
    let text = "0 BEGIN PGM T MM\nPLANE SPATIAL SPB+30 TURN FMAX\nEND PGM T MM\n";
    let program = read::read(text, &ReadOptions::new(Dialect::Heidenhain, axes, 5)).unwrap();
    assert!(program.steps.iter().any(|step| matches!(step, Step::Plane(_))));
}
