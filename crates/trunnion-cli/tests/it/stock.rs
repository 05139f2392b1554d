//! A job's stock and fixtures as a user meets them: stock is cut away in the final check of a run, and what runs into
//! either is reported.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{folder, json, outcome, replace, root, trunnion};
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
    add(folder, "[[fixture]]\nkind = \"stl\"\nfile = \"block.stl\"\n");
    add(folder, "[[fixture]]\nkind = \"step\"\nfile = \"vise.step\"\n");
    let (code, _, errors) = outcome(&trunnion(folder, &dry));
    let missing = ["job.toml:11:8: block.stl: ", ":8: block.stl: ", ":8: vise.step: "];
    assert!(code == Some(2) && missing.iter().all(|what| errors.contains(what)), "{errors}");
    assert_eq!(
        errors.matches("paths count from the folder of the job file").count(),
        3,
        "{errors}"
    );
    let open = block();
    let cut = open.find("endfacet").unwrap() + "endfacet\n".len();
    fs::write(folder.join("block.stl"), "solid block\n".to_owned() + &open[cut..]).unwrap();
    let solid = root().join("fixtures/step/hollow.step");
    fs::copy(solid, folder.join("vise.step")).unwrap();
    let (code, _, errors) = outcome(&trunnion(folder, &dry));
    let open = ["job.toml:11:8: the stock: ", ":8: fixture block.stl: "];
    assert!(code == Some(2) && open.iter().all(|what| errors.contains(what)), "{errors}");
    assert_eq!(errors.matches("is not closed").count(), 2, "{errors}");
    fs::write(folder.join("block.stl"), block()).unwrap();
    let (code, said, errors) = outcome(&trunnion(folder, &dry));
    assert!(code == Some(0) && said.contains("block.stl, vise.step"), "{said}{errors}");
    replace(folder, "job.toml", "kind = \"step\"", "kind = \"stl\"");
    let (code, _, errors) = outcome(&trunnion(folder, &dry));
    assert!(code == Some(2) && errors.contains("write kind = \"step\""), "{errors}");
    replace(folder, "job.toml", "\"stl\"\nfile = \"vise.step\"", "\"step\"\nfile = \"vise.step\"");
    let face = root().join("examples/step-face/part.step");
    fs::copy(face, folder.join("vise.step")).unwrap();
    let (code, _, errors) = outcome(&trunnion(folder, &dry));
    assert!(
        code == Some(2) && errors.contains(":8: vise.step: the solid is not closed"),
        "{errors}"
    );
}

/// Adds lines to the job.
fn add(folder: &Path, lines: &str) {
    let path = folder.join("job.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(path, text + lines).unwrap();
}

/// A clamp beside the patch, its corner under the passes or off them.
fn clamp(corner: f64) -> String {
    format!("[[fixture]]\nkind = \"box\"\nmin = [-40, 10, -12]\nmax = [{corner}, 30, 4]\n")
}

/// One program, measured coarsely: the part is not what is looked at.
fn quick(folder: &Path) {
    replace(folder, "job.toml", "dialects = [\"linuxcnc\", \"g93\"]", "dialects = [\"linuxcnc\"]");
    replace(folder, "job.toml", "grid = 0.5", "grid = 2");
}

#[test]
fn links_pass_over_a_wall_that_is_higher_than_the_part() {
    let folder = folder();
    let folder = folder.path();
    quick(folder);
    // A wall on the way from home to the passes.
    let wall = "kind = \"box\"\nmin = [60, -400, -12]\nmax = [80, 400, 300]\n";
    add(folder, &format!("[[fixture]]\nname = \"wall\"\n{wall}"));
    let (code, summary) = run(folder);
    assert!(code == Some(0) && summary["passed"] == true, "{summary:#}");
    let fixtures = &summary["programs"][0]["fixtures"];
    assert!(fixtures["hits"].is_null() && fixtures["least"]["fixture"] == "wall", "{fixtures:#}");
    assert!(fixtures["least"]["distance"].as_f64().unwrap() > 0.0, "{fixtures:#}");
}

#[test]
fn passes_keep_off_a_clamp_and_what_it_covers_is_named() {
    let folder = folder();
    let folder = folder.path();
    quick(folder);
    add(folder, "fixture_clearance = 2.5\n");
    add(folder, &clamp(-18.0));
    let (code, summary) = run(folder);
    let fixtures = &summary["programs"][0]["fixtures"];
    assert!(fixtures["lines"].is_null() && fixtures["hits"].is_null(), "{fixtures:#}");
    let failures = summary["failures"].to_string();
    assert!(code == Some(1) && failures.contains("gouge fixture box:-40,10,-12"), "{failures}");
}

/// The clamp in the way, of more triangles than planning keeps off.
fn fine_clamp() -> String {
    const N: usize = 8;
    let (low, high) = ([-40.0, 10.0, -12.0], [-18.0, 30.0, 4.0]);
    let mut text = "solid clamp\n".to_owned();
    for (k, end) in (0..3).flat_map(|k| [(k, 0.0), (k, 1.0)]) {
        let at = |i: usize, j: usize| {
            let mut share = [end; 3];
            share[(k + 1) % 3] = i as f64 / N as f64;
            share[(k + 2) % 3] = j as f64 / N as f64;
            let place = [0, 1, 2].map(|k: usize| low[k] + share[k] * (high[k] - low[k]));
            format!("vertex {} {} {}\n", place[0], place[1], place[2])
        };
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let halves = if end < 0.5 { [[2, 1, 0], [3, 2, 0]] } else { [[0, 1, 2], [0, 2, 3]] };
            for half in halves {
                let corners = half.map(|corner| corners[corner].clone()).concat();
                text.extend(["facet normal 0 0 0\nouter loop\n", &corners, "endloop\nendfacet\n"]);
            }
        }
    }
    text + "endsolid clamp\n"
}

#[test]
fn a_fixture_is_reported_where_a_program_runs_into_it() {
    let folder = folder();
    let folder = folder.path();
    quick(folder);
    let plain = fs::read_to_string(folder.join("job.toml")).unwrap();
    add(folder, "fixture_clearance = 2.5\n");
    add(folder, &clamp(-30.0));
    let (code, summary) = run(folder);
    assert_eq!(code, Some(0), "{summary:#}");
    let least =
        |summary: &Value| summary["programs"][0]["fixtures"]["least"]["distance"].as_f64().unwrap();
    assert!(least(&summary) > 2.5, "{summary:#}");
    let program = "out/program.linuxcnc.ngc";
    let check = |job: &str, more: &[&str]| {
        let output =
            trunnion(folder, &[&["--json", "check", program, "--job", job], more].concat());
        (output.status.code(), json(&output))
    };

    // In the way: the run and the check say the same, whoever says the fixture.
    fs::write(folder.join("plain.toml"), &plain).unwrap();
    fs::write(folder.join("clamp.stl"), fine_clamp()).unwrap();
    let only_checked = format!(
        "{plain}fixture_clearance = 2.5\n[[fixture]]\nkind = \"stl\"\nfile = \"clamp.stl\"\n"
    );
    fs::write(folder.join("job.toml"), only_checked).unwrap();
    let (code, summary) = run(folder);
    assert_eq!(code, Some(1), "{summary:#}");
    let fixtures = &summary["programs"][0]["fixtures"];
    assert_eq!(fixtures["least"]["fixture"], "clamp.stl");
    let deepest = fixtures["near"].as_array().unwrap().iter();
    let deepest = deepest.map(|near| near["distance"].as_f64().unwrap()).reduce(f64::min);
    assert!((-6.0..-2.0).contains(&least(&summary)) && deepest == Some(least(&summary)));
    let said = ["--fixture", "clamp.stl", "--clearance", "2.5"];
    let [of_job, of_arguments] = [check("job.toml", &[]), check("plain.toml", &said)];
    assert_eq!((of_job.0, of_arguments.0), (Some(1), Some(1)));
    assert_eq!(&of_job.1["fixtures"], fixtures);
    assert_eq!(&of_arguments.1["fixtures"], fixtures);
    assert_eq!(of_job.1["failures"], of_arguments.1["failures"]);
    let failures = summary["failures"].as_array().unwrap();
    let words = [": runs into clamp.stl, ", " mm deep at X ", "nearer than 2.5 mm"];
    for words in words {
        assert!(
            failures.iter().any(|failure| failure.as_str().unwrap().contains(words)),
            "{failures:?}"
        );
    }
    let warnings = summary["warnings"].to_string();
    let remedies = [
        "cuts or their leads come too near: move",
        "keeps them up from pass to pass",
        "has more than 600 triangles",
    ];
    assert!(remedies.iter().all(|remedy| warnings.contains(remedy)), "{warnings}");
    let page = fs::read_to_string(folder.join("out/report.html")).unwrap();
    assert!(page.contains("least fixture distance") && page.contains("deep in clamp.stl"));
    assert!(
        page.contains("The part among its fixtures") && page.contains("data:image/png;base64,")
    );

    // With stock hits in fixtures stand among what is run into; --fixture is looked at beside the job's own.
    with_stock(folder, BOX);
    let (_, both) = check("job.toml", &["--fixture", "cyl:-300,-200,-200,1,2"]);
    let hits = both["stock"]["collisions"].as_array().unwrap();
    let first = hits.iter().find(|hit| hit["kind"] == "fixture").unwrap();
    let mut near = fixtures["near"].as_array().unwrap().iter();
    let near = near.find(|near| near["line"] == first["line"]).unwrap();
    let [depth, distance] = [&first["depth"], &near["distance"]].map(|of| of.as_f64().unwrap());
    assert!(distance < 0.0 && (depth + distance).abs() < 1e-12, "{first} {near}");
    assert_eq!(both["fixtures"]["hits"], fixtures["hits"]);
}

#[test]
fn the_chord_of_a_step_fixture_is_that_of_the_command_line() {
    let folder = folder();
    let folder = folder.path();
    let plain = fs::read_to_string(folder.join("job.toml")).unwrap();
    fs::write(folder.join("plain.toml"), &plain).unwrap();
    let solid = root().join("fixtures/step/hollow.step");
    fs::copy(solid, folder.join("hollow.step")).unwrap();
    add(folder, "[[fixture]]\nkind = \"step\"\nfile = \"hollow.step\"\nchord = 0.004\n");
    let moves = "TOOL PATH/A\nRAPID\nGOTO/0,0,60,0,0,1\nFEDRAT/600\nGOTO/0,0,25,0,0,1\nFINI\n";
    fs::write(folder.join("moves.cls"), moves).unwrap();
    let check = |job: &str, more: &[&str]| {
        let all = [&["--json", "check", "moves.cls", "--job", job], more].concat();
        let found = json(&trunnion(folder, &all));
        (found["chords"].clone(), found["fixtures"].clone())
    };
    let of_job = check("job.toml", &[]);
    assert_eq!(of_job.0, serde_json::json!([{"solid": "hollow.step", "chord": 0.004}]));
    // Every solid with its own.
    let both = ["check", "moves.cls", "--job", "job.toml", "--stock", "hollow.step"];
    let (_, table, errors) = outcome(&trunnion(folder, &both));
    let wanted =
        "triangles within about 0.004 mm of hollow.step; 0.01 mm of stock; fixtures are enlarged";
    assert!(table.contains(wanted), "{table}{errors}");
    assert_eq!(of_job, check("plain.toml", &["--fixture", "hollow.step", "--chord", "0.004"]));
    let coarser = check("job.toml", &["--chord", "0.5"]);
    assert_eq!(coarser, check("plain.toml", &["--fixture", "hollow.step", "--chord", "0.5"]));
    let [fine, coarse] = [of_job, coarser].map(|(_, of)| of["least"]["distance"].as_f64().unwrap());
    assert!((fine - coarse - 0.496).abs() < 1e-3, "{fine} {coarse}");
    // Its place is said by the job as that of the setup, and on the command line behind it.
    let place = "origin = [14, -3, 7]\nrotation = [10, 0, 35]\n";
    let text = fs::read_to_string(folder.join("job.toml")).unwrap();
    fs::write(folder.join("moved.toml"), format!("{text}{place}")).unwrap();
    let moved = check("moved.toml", &[]);
    let said =
        check("plain.toml", &["--fixture", "hollow.step@14,-3,7,10,0,35", "--chord", "0.004"]);
    let least = |of: &serde_json::Value| of["least"]["distance"].as_f64().unwrap();
    let [moved, said] = [moved, said].map(|(_, of)| least(&of));
    assert!((moved - said).abs() < 1e-12 && (moved - fine).abs() > 0.1, "{moved} {said} {fine}");
    let wrong = ["check", "moves.cls", "--job", "plain.toml", "--fixture", "hollow.step@1,2"];
    let (code, _, errors) = outcome(&trunnion(folder, &wrong));
    assert!(code == Some(2) && errors.contains("vise.step@10,0,-25,0,0,90"), "{errors}");
}
