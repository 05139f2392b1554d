//! The tables of the book's pages on Heidenhain and APT, row by row.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use readings::options;
use std::fs;
use std::path::Path;
use trunnion_nc::read::{ClFile, Dialect, Step, cl, read};

/// Rows of a page: example, result.
fn rows(page: &str) -> Vec<(String, String)> {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/reference/dialects");
    let row = |line: &str| {
        let cells: Vec<&str> = line.strip_prefix("| ")?.split(" | ").collect();
        let [_, example, result, ..] = cells[..] else { return None };
        let example = example.strip_prefix('`')?.strip_suffix('`')?;
        Some((example.replace(" / ", "\n"), result.trim().to_owned()))
    };
    fs::read_to_string(folder.join(page)).unwrap().lines().filter_map(row).collect()
}

#[test]
fn the_table_of_heidenhain_is_true() {
    let rows = rows("heidenhain.md");
    assert!(rows.len() > 50, "{} rows", rows.len());
    let before =
        "BEGIN PGM T MM\nTOOL CALL 1 Z S500 F100\nL X+10 Y+10 Z+10 R0 FMAX M3\nL X+20 F200";
    let steps = |example: &str| {
        let text = format!("{before}\n{example}\nEND PGM T MM\n");
        read(&text, &options(Dialect::Heidenhain, "XYZAC")).map(|program| program.steps)
    };
    let plain = steps("").unwrap();
    let count =
        |steps: &[Step], of: fn(&Step) -> bool| steps.iter().filter(|step| of(step)).count();
    let moves = |steps: &[Step]| count(steps, |step| matches!(step, Step::Move(_)));
    let words = |steps: &[Step]| count(steps, |step| matches!(step, Step::Words { .. }));
    for (example, result) in rows {
        let made = steps(&example);
        match (result.as_str(), made) {
            ("refused", Err(faults)) => {
                assert!(!faults[0].help.is_empty(), "{example}: {}", faults[0]);
                assert!(faults[0].line > 4, "{example}: {}", faults[0]);
            }
            ("kept", Ok(made)) => {
                assert_eq!(
                    (moves(&made), words(&made)),
                    (moves(&plain), words(&plain) + 1),
                    "{example}"
                );
            }
            ("run", Ok(made)) => {
                let tools = usize::from(example.starts_with("TOOL CALL"));
                assert!(
                    words(&made) == words(&plain) + tools && made.len() >= plain.len(),
                    "{example}"
                );
            }
            (_, made) => panic!("{example} is not {result}: {made:?}"),
        }
    }
}

/// All that a CL file says, but the lines.
fn said(file: &ClFile) -> String {
    let records: Vec<_> =
        file.records.iter().map(|record| (record.pose, record.motion, record.way)).collect();
    let tools: Vec<_> = file.tools.iter().map(|tool| tool.number).collect();
    format!("{records:?} {tools:?} {:?}", file.cutter)
}

#[test]
fn the_table_of_apt_is_true() {
    let rows = rows("apt.md");
    assert!(rows.len() > 40, "{} rows", rows.len());
    let before = "UNITS/MM\nMSYS/0,0,0,1,0,0,0,1,0\nLOADTL/1\nSPINDL/500,RPM,CLW\nFEDRAT/100,MMPM\nRAPID\nGOTO/10,10,10,0,0,1";
    let file = |example: &str| cl(&format!("{before}\n{example}\nGOTO/20,10,10\nFINI\n"), 10);
    let plain = said(&file("$$").unwrap());
    for (example, result) in rows {
        match (result.as_str(), file(&example)) {
            ("refused", Err(faults)) => {
                assert!(!faults[0].help.is_empty(), "{example}: {}", faults[0]);
                assert!(faults[0].line > 7 && faults[0].column > 0, "{example}: {}", faults[0]);
            }
            ("kept", Ok(made)) => assert_eq!(said(&made), plain, "{example}"),
            ("run", Ok(made)) => assert_ne!(said(&made), plain, "{example}"),
            (_, made) => panic!("{example} is not {result}: {made:?}"),
        }
    }
}
