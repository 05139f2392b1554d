//! A job's stock as a user meets it: it is cut away in the final check of a run, and what runs into it is told.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

mod binary;

use binary::{folder, json, replace, told, trunnion};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;

const BOX: &str = "[stock]\nkind = \"box\"\nmin = [-20, -18, -12]\nmax = [20, 18, 6]\n\n[tool]";
const CELL: &str = "[verify]\nstock_cell = 0.5\n";

/// Says the stock and how finely to look.
fn with_stock(folder: &Path, stock: &str) {
    replace(folder, "job.toml", "[tool]", stock);
    replace(folder, "job.toml", "[verify]\n", CELL);
}

fn run(folder: &Path) -> (Option<i32>, Value) {
    let output = trunnion(folder, &["--json", "run", "job.toml", "-o", "out"]);
    (output.status.code(), json(&output))
}

/// The box of [`BOX`] as an STL text.
fn block() -> String {
    let corner = |k: usize| {
        let pick =
            |bit: usize, low: &'static str, high| if (k >> bit) & 1 == 1 { high } else { low };
        format!("{} {} {}", pick(0, "-20", "20"), pick(1, "-18", "18"), pick(2, "-12", "6"))
    };
    let squares =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let mut text = "solid block\n".to_owned();
    for [a, b, c] in squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]) {
        let [a, b, c] = [a, b, c].map(corner);
        write!(text, "facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n")
            .unwrap();
    }
    text + "endsolid block\n"
}

#[test]
fn the_stock_of_a_job_is_cut_by_its_programs() {
    let folder = folder();
    let folder = folder.path();
    with_stock(folder, BOX);
    let (code, summary) = run(folder);
    assert_eq!(code, Some(0), "{summary:#}");
    let stock = |summary: &Value, program: usize| summary["programs"][program]["stock"].clone();
    let number = |value: &Value| value.as_f64().unwrap();
    let [first, second] = [0, 1].map(|program| stock(&summary, program));
    assert_eq!(first["collisions"], Value::Array(Vec::new()));
    let [whole, removed] = [40.0 * 36.0 * 18.0, number(&first["removed"])];
    assert!((number(&first["left"]) + removed - whole).abs() < 1e-6, "{first}");
    // Both programs cut the same, to their tolerance over the patch.
    assert!(removed > 1000.0 && (number(&second["removed"]) - removed).abs() < 20.0, "{second}");
    let left = trunnion::import::stl::read(&fs::read(folder.join("out/stock.stl")).unwrap());
    assert!(!left.unwrap().triangles.is_empty());
    let page = fs::read_to_string(folder.join("out/report.html")).unwrap();
    assert!(page.contains("What is left of the stock") && page.contains("data:image/png;base64,"));

    // The same said as a file, and by the check.
    fs::write(folder.join("block.stl"), block()).unwrap();
    replace(folder, "job.toml", BOX, "[stock]\nkind = \"stl\"\nfile = \"block.stl\"\n\n[tool]");
    let program = "out/program.linuxcnc.ngc";
    let output = trunnion(folder, &["--json", "check", program, "--job", "job.toml"]);
    let checked = json(&output)["stock"].clone();
    assert_eq!(checked["cell"], first["cell"]);
    assert!((number(&checked["removed"]) - removed).abs() < 1e-6, "{checked}");
    let (code, again) = run(folder);
    assert_eq!((code, stock(&again, 0)), (Some(0), checked));

    // What stands on the part: all of it is cut away, but for what the triangles are off.
    let stl = "kind = \"stl\"\nfile = \"block.stl\"";
    replace(folder, "job.toml", stl, "kind = \"offset\"\nthickness = 0.8");
    let output = trunnion(folder, &["--json", "check", program, "--job", "job.toml"]);
    let skin = json(&output)["stock"].clone();
    assert_eq!(skin["collisions"], Value::Array(Vec::new()), "{skin}");
    let [removed, left] = ["removed", "left"].map(|name| number(&skin[name]));
    assert!(removed > 100.0 && left < 0.03 * removed, "{skin}");
}

#[test]
fn a_holder_in_the_stock_fails_the_run() {
    let folder = folder();
    let folder = folder.path();
    // A wall beside the patch, as high as the holder is low.
    let wall = BOX.replace("min = [-20, -18, -12]", "min = [-40, 25, -12]");
    let wall = wall.replace("max = [20, 18, 6]", "max = [40, 30, 30]");
    with_stock(folder, &wall);
    replace(
        folder,
        "job.toml",
        "length = 100",
        "length = 100\nholder = [[20, 8], [25, 40], [60, 40]]",
    );
    let (code, summary) = run(folder);
    assert_eq!(code, Some(1), "{summary:#}");
    let hits = summary["programs"][0]["stock"]["collisions"].as_array().unwrap().clone();
    assert!(hits.iter().any(|hit| hit["kind"] == "holder"), "{hits:?}");
    let failures = summary["failures"].to_string();
    assert!(failures.contains("shank or holder run into the stock"), "{failures}");
}

#[test]
fn a_stock_that_cannot_be_used_is_refused_before_the_work() {
    let folder = folder();
    let folder = folder.path();
    with_stock(folder, "[stock]\nkind = \"stl\"\nfile = \"block.stl\"\n\n[tool]");
    let dry = ["run", "job.toml", "--dry-run"];
    let (code, _, errors) = told(&trunnion(folder, &dry));
    assert!(code == Some(2) && errors.contains("block.stl"), "{errors}");
    let open = block();
    let cut = open.find("endfacet").unwrap() + "endfacet\n".len();
    fs::write(folder.join("block.stl"), "solid block\n".to_owned() + &open[cut..]).unwrap();
    let (code, _, errors) = told(&trunnion(folder, &dry));
    assert!(code == Some(2) && errors.contains("closed"), "{errors}");
}
