//! Meshes of STEP solids against the volumes that OCCT states, and stock and fixtures made of them.

#![cfg(feature = "step")]
#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "a test says what it could not compare")]

use nalgebra::{Point3, Vector3};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::import::ImportError;
use trunnion::import::step::StepReader;
use trunnion::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
use trunnion::types::{Mesh, Silent, ToolPose};
use trunnion::verify::{self, CheckInput, ClearanceOptions, Fixture, Solid, Stock};

const READER: StepReader = StepReader { chord: 0.002, same: 0.01 };

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn mesh(path: &Path, chord: f64) -> Result<Mesh, ImportError> {
    READER.mesh(&fs::read(path).unwrap(), chord, &Silent)
}

fn volume(mesh: &Mesh) -> f64 {
    let at = |corner: u32| mesh.vertices[corner as usize].coords;
    let cones = mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0);
    cones.sum()
}

fn area(mesh: &Mesh) -> f64 {
    let at = |corner: u32| mesh.vertices[corner as usize];
    let areas = mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| 0.5 * (at(b) - at(a)).cross(&(at(c) - at(a))).norm());
    areas.sum()
}

/// A mesh has the volume and the area of its solid, as far as its chords let it.
fn compare(name: &str, path: &Path, [exact, around]: [f64; 2], chord: f64) {
    let mesh = mesh(path, chord).map_err(|error| format!("{name}: {error}")).unwrap();
    let (volume, area) = (volume(&mesh), area(&mesh));
    println!(
        "{name}: {} triangles, volume {volume} of {exact}, area {area} of {around}",
        mesh.triangles.len()
    );
    let allowed = chord * around + 1e-5 * exact;
    assert!((volume - exact).abs() <= allowed, "{name}: {volume} {exact}");
    // OCCT's own integrals are off by half a per cent on rational tori.
    assert!((area / around - 1.0).abs() <= 6e-3, "{name}: {area} {around}");
}

#[test]
fn meshes_have_the_volumes_of_their_solids() {
    let reference = json(&root().join("fixtures/step/reference.json"));
    let mut count = 0;
    for (name, stated) in reference.as_object().unwrap() {
        let [exact, around] = ["volume", "area"].map(|key| stated[key].as_f64().unwrap());
        if exact > 0.0 {
            // The numbers of some files are inches or metres.
            let chord = 0.01 * (around / 2500.0).sqrt();
            compare(name, &root().join(name), [exact, around], chord);
            count += 1;
        }
    }
    assert_eq!(count, 14);
}

#[test]
fn shared_models_have_their_volumes() {
    let folder = root().join("../shared/models");
    if !folder.exists() {
        println!("{} is absent: nothing compared", folder.display());
        return;
    }
    let reference = json(&folder.join("step/reference.json"));
    for (name, stated) in reference.as_object().unwrap() {
        let path = folder.join(format!("step/{name}.step"));
        let [exact, around] = ["volume", "area"].map(|key| stated[key].as_f64().unwrap());
        if exact > 0.0 && path.exists() {
            compare(name, &path, [exact, around], 0.02);
        }
    }
    let impeller = folder.join("kj66_impeller.step");
    compare("impeller", &impeller, [78_552.814_55, 54_446.353_66], 0.05);
}

#[test]
fn finer_chords_come_nearer() {
    let path = root().join("fixtures/step/rings.step");
    let exact =
        json(&root().join("fixtures/step/reference.json"))["fixtures/step/rings.step"]["volume"]
            .as_f64();
    let errors = [0.1, 0.025].map(|chord| exact.unwrap() - volume(&mesh(&path, chord).unwrap()));
    // Inscribed, and off by chords: a quarter of them is a quarter of the volume that is missing.
    assert!(errors[1] > 0.0 && errors[1] < 0.4 * errors[0], "{errors:?}");
}

#[test]
fn what_is_not_closed_is_said() {
    let error = mesh(&root().join("examples/step-face/part.step"), 0.01).unwrap_err().to_string();
    assert!(error.contains("edges have a face on one side only, the first of face 1"), "{error}");
    let whole = fs::read_to_string(root().join("fixtures/step/hollow.step")).unwrap();
    // The first plane of the file becomes something unknown: its face is lost.
    let broken = whole.replacen("= PLANE(", "= PLANET(", 1);
    assert_ne!(broken, whole);
    let error = READER.mesh(broken.as_bytes(), 0.01, &Silent).unwrap_err().to_string();
    assert!(error.contains("not closed") && error.contains("PLANET"), "{error}");
}

#[test]
fn stock_of_a_solid_has_its_volume() {
    let path = root().join("fixtures/step/hollow.step");
    let solid = Solid::Mesh(mesh(&path, 0.01).unwrap());
    let stock = Stock::new(&solid, 0.25, 1_000_000).unwrap();
    assert!((stock.volume() / 7760.0 - 1.0).abs() < 1e-9, "{}", stock.volume());
    let tilted = Solid::Mesh(mesh(&root().join("fixtures/step/tilted_cap.step"), 0.005).unwrap());
    let stock = Stock::new(&tilted, 0.1, 1_000_000).unwrap();
    assert!((stock.volume() / 12_299.694_46 - 1.0).abs() < 2e-3, "{}", stock.volume());
}

/// A tool down to 5 um above the top of a solid, and 5 um into it.
#[test]
fn a_solid_is_a_fixture() {
    let solid = Solid::Mesh(mesh(&root().join("fixtures/step/hollow.step"), 0.01).unwrap());
    let [low, high] = solid.bounds().unwrap();
    let fixtures = [Fixture::new(&solid, 1e-3).unwrap()];
    let spec = CutterSpec { length: 40.0, ..CutterSpec::of_radii(1.0, 0.0) };
    let cutter = Cutter::new(spec).unwrap();
    let middle = nalgebra::center(&low, &high);
    for (above, lines) in [(0.005, 0), (-0.005, 1)] {
        let tip = |z: f64| Point3::new(middle.x, middle.y, high.z + z);
        let pose = |z: f64| ToolPose { tip: tip(z), axis: Vector3::z_axis() };
        let record = |(line, z)| ClRecord {
            line,
            pose: pose(z),
            motion: ClMotion::Feed(10.0),
            way: ClPath::Straight,
        };
        let records = (1..).zip([30.0, above]).map(record).collect();
        let file = ClFile { records, ..ClFile::default() };
        let input = CheckInput::locations(&file, &cutter);
        let watch = ClearanceOptions::within(1e-3);
        let found = verify::clearance(&input, &fixtures, &watch, &Silent).unwrap();
        assert!((found.least.unwrap().distance - above).abs() < 1e-3, "{found:?}");
        assert_eq!(found.near.len(), lines);
    }
}
