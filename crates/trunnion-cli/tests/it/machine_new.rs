//! `trunnion machine new` from flags; the dialogue is tested beside its code.

use crate::binary;
use binary::{outcome, trunnion};
use std::fs;
use trunnion::files::machine::{built_in, parse};

const TRUNNION: [&str; 30] = [
    "machine",
    "new",
    "-o",
    "my.toml",
    "--drawing",
    "my.svg",
    "--name",
    "mill",
    "--table",
    "C,B",
    "--head",
    "none",
    "--carries",
    "none",
    "--meet=-381,-254,-535",
    "--travel",
    "X=-762,0",
    "--travel",
    "Y=-508,0",
    "--travel",
    "Z=-508,0",
    "--travel",
    "C=endless",
    "--travel",
    "B=-35,120",
    "--jog",
    "C=clockwise",
    "--jog",
    "B=clockwise",
    "--linear=500,2500,40000",
];

#[test]
fn flags_make_a_machine_that_check_accepts() {
    let folder = tempfile::tempdir().unwrap();
    let arguments: Vec<&str> = TRUNNION.into_iter().chain(["--rotary", "150,300,6000"]).collect();
    let (code, text, errors) = outcome(&trunnion(folder.path(), &arguments));
    assert_eq!(code, Some(0), "{errors}");
    assert!(text.contains("[part] -- C -- B -- [bed] -- X -- Y -- Z -- [tool]"), "{text}");
    assert!(text.contains("B +30: the table's +x side goes to +z"), "{text}");
    let check = trunnion(folder.path(), &["machine", "check", "my.toml"]);
    assert!(check.status.success());
    let machine =
        parse(&fs::read_to_string(folder.path().join("my.toml")).unwrap()).unwrap().machine;
    let like = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    assert_eq!(machine.chain, like.chain);
    for (a, b) in machine.axes.iter().zip(&like.axes) {
        assert_eq!((&a.name, a.dir, a.sense.to_bits()), (&b.name, b.dir, b.sense.to_bits()));
    }
    assert!(
        fs::read_to_string(folder.path().join("my.svg"))
            .unwrap()
            .contains("mill: table-table, layout 24")
    );
    // The file may have been changed since: it is not replaced.
    let (code, _, errors) = outcome(&trunnion(folder.path(), &arguments));
    assert!(code == Some(2) && errors.contains("exists already"), "{errors}");
}

/// The machine file and its drawing: both, or neither.
#[test]
fn a_drawing_that_cannot_be_written_leaves_no_machine_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "in the way").unwrap();
    let with = |drawing: &'static str| -> Vec<&str> {
        let all = TRUNNION.into_iter().chain(["--rotary", "150,300,6000"]);
        all.map(|word| if word == "my.svg" { drawing } else { word }).collect()
    };
    for (drawing, reason) in [("file/my.svg", "file is a file"), ("my.toml", "cannot be one file")]
    {
        let (code, _, errors) = outcome(&trunnion(folder.path(), &with(drawing)));
        assert!(code != Some(0) && errors.contains(reason), "{code:?} {errors}");
        assert!(!folder.path().join("my.toml").exists(), "{drawing}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{drawing}");
    }
}

#[test]
fn missing_and_wrong_answers_are_all_named() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str]| {
        let (code, _, errors) = outcome(&trunnion(folder.path(), arguments));
        assert_eq!(code, Some(2), "{errors}");
        errors
    };
    let errors = refused(&TRUNNION);
    assert!(errors.contains("answers are missing\n  --rotary: "), "{errors}");
    let errors = refused(&["machine", "new", "-o", "my.toml", "--name", "m"]);
    assert!(errors.contains("--table: ") && errors.contains("--head: "), "{errors}");
    let wrong: Vec<&str> =
        TRUNNION.into_iter().chain(["--rotary", "1,2,3", "--jog", "A=clockwise"]).collect();
    assert!(refused(&wrong).contains("--jog A: the machine has no such axis"));
    let turned: Vec<&str> = TRUNNION
        .into_iter()
        .map(|word| if word == "X=-762,0" { "X=0,-762" } else { word })
        .collect();
    assert!(refused(&turned).contains("--travel X=0,-762: the lower end comes first"));
}
