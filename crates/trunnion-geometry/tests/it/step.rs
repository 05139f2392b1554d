//! STEP files against what OCCT says about them, and against damage of every kind.
//!
//! Areas, centroids and volumes check surfaces, trims and sides together: the area of a face is
//! right only if both its surface and its loops are, and the volume only if every face looks
//! outwards. The values are OCCT's own integrals (`fixtures/step/generate.py`).

#![cfg(feature = "step")]
#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "a test says what it could not compare")]

use crate::property;

use nalgebra::Point3;
use proptest::prelude::*;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::time::Duration;
use std::time::Instant;
use trunnion::import::ImportError;
use trunnion::import::Part;
use trunnion::import::Reader;
use trunnion::import::inspect;
use trunnion::import::step::StepReader;
use trunnion::types::Interval;
use trunnion::types::Silent;

const READER: StepReader = StepReader { chord: 0.002, same: 0.01 };

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn read(bytes: &[u8]) -> Result<Part, ImportError> {
    READER.read(bytes, &Silent)
}

fn lossless(path: &Path) -> Part {
    let part = read(&fs::read(path).unwrap()).unwrap();
    assert_eq!(part.warnings, vec![], "{}", path.display());
    part
}

/// Sums over the faces of a part.
struct Sums {
    area: f64,
    volume: f64,
    bounds: [Point3<f64>; 2],
}

fn sums(part: &Part) -> Sums {
    let mut sums = Sums {
        area: 0.0,
        volume: 0.0,
        bounds: [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])],
    };
    for face in &part.faces {
        let summary = inspect::summary(face);
        sums.area += summary.area;
        sums.bounds[0] = sums.bounds[0].inf(&summary.bounds[0]);
        sums.bounds[1] = sums.bounds[1].sup(&summary.bounds[1]);
        let elements = inspect::elements(face);
        sums.volume += elements.iter().map(|e| e.point.coords.dot(&e.area) / 3.0).sum::<f64>();
    }
    sums
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// The box must hold: OCCT's is enlarged by its tolerance, and for B-splines may be a little wide.
fn assert_bounds(name: &str, ours: &[Point3<f64>; 2], low: &[f64], high: &[f64]) {
    let size = (ours[1] - ours[0]).norm();
    for k in 0..3 {
        for (mine, theirs) in [(ours[0][k], low[k]), (ours[1][k], high[k])] {
            assert!((mine - theirs).abs() < 1e-3 * size, "{name}: {ours:?} {low:?} {high:?}");
        }
    }
}

fn assert_share(name: &str, ours: f64, theirs: f64, share: f64) {
    assert!((ours - theirs).abs() <= share * theirs.abs(), "{name}: {ours}, OCCT has {theirs}");
}

/// OCCT's word for a kind of surface.
fn occt_kind(kind: &str) -> &str {
    match kind {
        "B-spline" | "NURBS" => "BSPLINE",
        "plane" => "PLANE",
        "cylinder" => "CYLINDER",
        "cone" => "CONE",
        "sphere" => "SPHERE",
        "torus" => "TORUS",
        "extrusion" => "EXTRUSION",
        "revolution" => "REVOLUTION",
        other => other,
    }
}

#[test]
fn fixtures_agree_with_occt_face_by_face() {
    let reference = json(&root().join("fixtures/step/reference.json"));
    for (name, expected) in reference.as_object().unwrap() {
        let part = lossless(&root().join(name));
        let faces = expected["faces"].as_array().unwrap();
        assert_eq!(part.faces.len(), faces.len(), "{name}");
        for (face, expected) in part.faces.iter().zip(faces) {
            let summary = inspect::summary(face);
            let place = format!("{name}, face {}", face.number);
            let kind = expected["kind"].as_str().unwrap();
            // Rings of rational nets are read as the elementary surfaces that they are.
            let kind = if name.contains("rational") && kind == "BSPLINE" { "TORUS" } else { kind };
            // A wave that is swept in its own plane is read as a plane.
            let kind = if name.contains("wavy") && kind == "EXTRUSION" { "PLANE" } else { kind };
            assert_eq!(occt_kind(summary.kind), kind, "{place}");
            let area = expected["area"].as_f64().unwrap();
            assert_share(&place, summary.area, area, 1e-3);
            let elements = inspect::elements(face);
            let moment = elements
                .iter()
                .fold(nalgebra::Vector3::zeros(), |sum, e| sum + e.point.coords * e.area.norm());
            let centroid = moment / summary.area;
            let theirs = Point3::from_slice(&numbers(&expected["centroid"]));
            let off = (centroid - theirs.coords).norm();
            assert!(off < 1e-3 * area.sqrt(), "{place}: {centroid:?} {theirs:?}");
        }
        let sums = sums(&part);
        assert_share(name, sums.area, expected["area"].as_f64().unwrap(), 5e-4);
        let volume = expected["volume"].as_f64().unwrap();
        if volume > 0.0 {
            assert_share(name, sums.volume, volume, 1e-3);
        }
        let box_ = &expected["bounds"];
        assert_bounds(name, &sums.bounds, &numbers(&box_[0]), &numbers(&box_[1]));
    }
}

#[test]
fn shared_models_agree_with_occt() {
    let folder = root().join("../shared/models/step");
    if !folder.exists() {
        println!("{} is absent: nothing compared", folder.display());
        return;
    }
    let reference = json(&folder.join("reference.json"));
    for (name, expected) in reference.as_object().unwrap() {
        let path = folder.join(format!("{name}.step"));
        if !path.exists() {
            println!("{} is absent", path.display());
            continue;
        }
        let part = lossless(&path);
        assert_eq!(part.faces.len() as u64, expected["faces"].as_u64().unwrap(), "{name}");
        // The same solids with every face written as a rational net: read as what they were.
        let original = name.strip_prefix("nurbs_").and_then(|name| reference.get(name));
        for (kind, count) in original.unwrap_or(expected)["kinds"].as_object().unwrap() {
            // The sides of these solids are border curves that are swept in their own planes.
            let flat = name.starts_with("bsp") && kind == "EXTRUSION";
            let kind = if flat { "PLANE" } else { kind };
            let same = |face: &&trunnion::surface::Face| occt_kind(face.surface.kind()) == kind;
            let ours = part.faces.iter().filter(same).count();
            assert_eq!(ours as u64, count.as_u64().unwrap(), "{name}: {kind}");
        }
        let sums = sums(&part);
        // OCCT's default integration, used for these values, is half a per cent off on this one;
        // 4 pi^2 R r and 2 pi^2 R r^2 are exact.
        let exact = std::f64::consts::TAU.powi(2) * 30.0 * 8.0;
        let torus = name == "nurbs_torus";
        let area = if torus { exact } else { expected["area"].as_f64().unwrap() };
        let volume = if torus { exact * 4.0 } else { expected["volume"].as_f64().unwrap() };
        assert_share(name, sums.area, area, 1e-3);
        if volume > 0.0 {
            // The blade's volumes are off by 8e-3 for the same reason.
            assert_share(
                name,
                sums.volume,
                volume,
                if name.contains("blade") { 1e-2 } else { 1e-3 },
            );
        }
        let bb = numbers(&expected["bb"]);
        assert_bounds(name, &sums.bounds, &bb[..3], &bb[3..]);
    }
}

#[test]
fn the_impeller_agrees_with_occt() {
    let path = root().join("../shared/models/kj66_impeller.step");
    if !path.exists() {
        println!("{} is absent: nothing compared", path.display());
        return;
    }
    let part = lossless(&path);
    assert_eq!(part.faces.len(), 92);
    let sums = sums(&part);
    // OCCT's adaptive integrators, 1e-6; 11 solids.
    assert_share("impeller area", sums.area, 54_446.353_66, 1e-3);
    assert_share("impeller volume", sums.volume, 78_552.814_55, 2e-3);
}

/// The mutated file is the smallest fixture with a curved, trimmed face.
fn example() -> Vec<u8> {
    fs::read(root().join("examples/step-face/part.step")).unwrap()
}

fn message(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

fn changed(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(example()).unwrap();
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn a_file_that_is_not_what_its_name_says_is_named() {
    for (bytes, word) in [
        (&b"solid part\n facet normal 0 0 1"[..], "STL (text)"),
        (b"{\"degree\": [3, 3]}", "JSON"),
        (b"", "an empty file"),
        (b"\x00\x01\x02", "binary data"),
        (b"dear reader", "some other text"),
    ] {
        assert_eq!(message(bytes), format!("this is not a STEP file: it looks like {word}"));
    }
}

#[test]
fn damage_is_one_clear_message_with_its_line() {
    let whole = example();
    let half = message(&whole[..whole.len() / 2]);
    assert!(half.contains("cut short"), "{half}");
    let nan = message(&changed("(100.,70.,", "(NAN,70.,"));
    assert!(nan.starts_with("line ") && nan.contains("NAN"), "{nan}");
    let empty = changed("OPEN_SHELL('',(#17))", "OPEN_SHELL('',())");
    let empty = String::from_utf8(empty).unwrap().replace("ADVANCED_FACE", "FORMER_FACE");
    let empty = message(empty.as_bytes());
    assert_eq!(empty, "the file gives no face: line 27, #16: the OPEN_SHELL is empty");
    let headless = b"ISO-10303-21;HEADER;ENDSEC;DATA;ENDSEC;END-ISO-10303-21;";
    assert_eq!(message(headless), "the file gives no face: its data section is empty");
}

#[test]
fn references_in_a_circle_are_a_loss_not_a_crash() {
    // A surface curve that is its own curve in space.
    let text = String::from_utf8(example()).unwrap();
    let at = text.find("= SURFACE_CURVE('',#").unwrap();
    let id: String = text[..at].trim_end().chars().rev().take_while(|c| *c != '#').collect();
    let id: String = id.chars().rev().collect();
    let rest = &text[at + "= SURFACE_CURVE('',#".len()..];
    let inner: String = rest.chars().take_while(char::is_ascii_digit).collect();
    let circle = changed(
        &format!("#{id} = SURFACE_CURVE('',#{inner}"),
        &format!("#{id} = SURFACE_CURVE('',#{id}"),
    );
    let said = message(&circle);
    assert!(said.contains("refers to itself") && said.contains("line "), "{said}");
}

#[test]
fn one_bad_face_is_a_warning_and_the_others_keep_their_numbers() {
    let path = root().join("fixtures/step/primitives_no_pcurves.step");
    let text = fs::read_to_string(path).unwrap();
    let at = text.find("= TOROIDAL_SURFACE('',").unwrap();
    let end = at + text[at..].find(");").unwrap();
    let broken = format!("{}= OFFSET_SURFACE('',#1,1.{}", &text[..at], &text[end..]);
    let part = read(broken.as_bytes()).unwrap();
    assert_eq!(part.warnings.len(), 1, "{:?}", part.warnings);
    let lost = part.warnings[0].face.unwrap();
    assert!(part.warnings[0].to_string().contains("OFFSET_SURFACE"));
    assert!(part.faces.iter().all(|face| face.number != lost));
    assert_eq!(part.faces.len(), 21);
    assert_eq!(part.faces.last().unwrap().number, 22);
}

#[test]
fn the_example_suits_a_wide_strip() {
    let part = lossless(&root().join("examples/step-face/part.step"));
    let summary = inspect::summary(&part.faces[0]);
    assert!(summary.trimmed);
    assert!(summary.concave_radius.unwrap() > 60.0, "{summary:?}");
    assert!(summary.normal.unwrap().z > 0.9);
    let svg = inspect::picture(&part.faces);
    assert!(svg.starts_with("<svg") && svg.contains(">1</text>") && !svg.contains("NaN"));
}

/// Bytes changed, cut or repeated at random places.
fn damage() -> impl Strategy<Value = Vec<(usize, u8, usize, u8)>> {
    prop::collection::vec((any::<usize>(), 0..4_u8, 1..40_usize, any::<u8>()), 1..6)
}

fn damaged(mut bytes: Vec<u8>, damage: &[(usize, u8, usize, u8)]) -> Vec<u8> {
    for &(at, kind, length, byte) in damage {
        let start = at % bytes.len().max(1);
        let end = (start + length).min(bytes.len());
        match kind {
            0 if start < bytes.len() => bytes[start] = byte,
            // Digits make for files that still parse and mean something else.
            1 if start < bytes.len() => {
                for place in &mut bytes[start..end] {
                    if place.is_ascii_digit() {
                        *place = b'0' + byte % 10;
                    }
                }
            }
            2 => drop(bytes.drain(start..end)),
            _ => {
                let copy = bytes[start..end].to_vec();
                bytes.splice(start..start, copy);
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(property::cases(150))]

    /// Whatever happens to a file: faces or a message, soon, and never a panic.
    #[test]
    fn damaged_files_give_faces_or_a_message(damage in damage(), which in 0..3_usize) {
        let names = ["examples/step-face/part.step", "fixtures/step/rings.step",
            "fixtures/step/revolved.step"];
        let bytes = damaged(fs::read(root().join(names[which])).unwrap(), &damage);
        let start = Instant::now();
        match read(&bytes) {
            Ok(part) => {
                for face in &part.faces {
                    prop_assert!(face.bounds().iter().all(Interval::is_bounded));
                }
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
        prop_assert!(start.elapsed() < Duration::from_secs(5));
    }
}

/// A plane wall whose upper edge is a cubic with these heights of its control points at x = -20, -6.67, 6.67, 20 mm.
fn wall(heights: [f64; 4]) -> Vec<u8> {
    let mut text = String::from(
        "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n\
         #1=DIRECTION('',(0.,-1.,0.));\n#2=DIRECTION('',(1.,0.,0.));\n#3=CARTESIAN_POINT('',(0.,0.,0.));\n\
         #4=AXIS2_PLACEMENT_3D('',#3,#1,#2);\n#5=PLANE('',#4);\n#6=DIRECTION('',(0.,0.,1.));\n\
         #7=VECTOR('',#6,1.);\n#8=VECTOR('',#2,1.);\n",
    );
    let corners = [[-20.0, 0.0], [20.0, 0.0], [20.0, heights[3]], [-20.0, heights[0]]];
    for (k, [x, z]) in corners.iter().enumerate() {
        let id = 10 + k;
        let _ = write!(
            text,
            "#{id}=CARTESIAN_POINT('',({x:?},0.,{z:?}));\n#2{id}=VERTEX_POINT('',#{id});\n"
        );
    }
    for (k, z) in heights.iter().enumerate() {
        let x = -20.0 + 40.0 * k as f64 / 3.0;
        let _ = writeln!(text, "#{}=CARTESIAN_POINT('',({x:?},0.,{z:?}));", 30 + k);
    }
    text += "#40=B_SPLINE_CURVE_WITH_KNOTS('',3,(#30,#31,#32,#33),.UNSPECIFIED.,.F.,.F.,(4,4),(0.,1.),.UNSPECIFIED.);\n\
             #41=LINE('',#10,#8);\n#42=LINE('',#11,#7);\n#43=LINE('',#10,#7);\n\
             #51=EDGE_CURVE('',#210,#211,#41,.T.);\n#52=EDGE_CURVE('',#211,#212,#42,.T.);\n\
             #53=EDGE_CURVE('',#213,#212,#40,.T.);\n#54=EDGE_CURVE('',#210,#213,#43,.T.);\n\
             #61=ORIENTED_EDGE('',*,*,#51,.T.);\n#62=ORIENTED_EDGE('',*,*,#52,.T.);\n\
             #63=ORIENTED_EDGE('',*,*,#53,.F.);\n#64=ORIENTED_EDGE('',*,*,#54,.F.);\n\
             #70=EDGE_LOOP('',(#61,#62,#63,#64));\n#71=FACE_OUTER_BOUND('',#70,.T.);\n\
             #72=ADVANCED_FACE('',(#71),#5,.T.);\n#73=OPEN_SHELL('',(#72));\n\
             #74=SHELL_BASED_SURFACE_MODEL('',(#73));\nENDSEC;\nEND-ISO-10303-21;\n";
    text.into_bytes()
}

/// Edges that cross their chords are followed all the same: a cubic in the shape of an S, symmetric and not.
#[test]
fn an_edge_with_an_inflection_is_kept_within_the_chord_tolerance() {
    for heights in [[10.0, 13.0, 8.0, 11.0], [10.0, 12.0, 8.0, 10.0], [9.0, 14.0, 7.5, 10.5]] {
        let part = read(&wall(heights)).unwrap();
        let face = &part.faces[0];
        for k in 1..1000 {
            let t = f64::from(k) * 1e-3;
            let s = 1.0 - t;
            let z = s * s * s * heights[0]
                + 3.0 * s * s * t * heights[1]
                + 3.0 * s * t * t * heights[2]
                + t * t * t * heights[3];
            let x = -20.0 + 40.0 * t;
            let holds = |z: f64| {
                let origin = face.point(0.0, 0.0);
                let jet = face.surface.jet2(0.0, 0.0);
                let away = Point3::new(x, 0.0, z) - origin;
                face.contains(jet.su.dot(&away), jet.sv.dot(&away))
            };
            let off = READER.chord;
            assert!(holds(z - off) && !holds(z + off), "{heights:?} at x = {x}");
        }
    }
}
