//! Programs as shops and posts write them (`fixtures/shop-programs`): read, or refused where it says here.

use crate::readings;

use readings::options;
use std::fs;
use std::path::Path;
use trunnion_nc::read::{Dialect, read};

/// Programs that are refused, and the line at which they are.
const REFUSED: [(&str, u32); 11] = [
    // Cutter compensation.
    ("siemens/comp.mpf", 6),
    ("fanuc/comp.nc", 8),
    // Approach of a fixed point of the machine.
    ("siemens/helix.mpf", 11),
    // Programs that are not in the file.
    ("siemens/subprogram.mpf", 5),
    ("fanuc/probe.nc", 6),
    // Pockets of the control.
    ("siemens/pocket.mpf", 5),
    ("haas/g12.nc", 8),
    // Values that only the control has.
    ("siemens/stopre.mpf", 3),
    ("fanuc/g54-4.nc", 4),
    ("haas/g254.nc", 6),
    // A corner that the control rounds.
    ("fanuc/corner-rounding.nc", 8),
];

#[test]
fn every_program_is_read_or_refused_with_a_remedy() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shop-programs");
    let (mut run, mut refused) = (0, 0);
    for dialect in [Dialect::Siemens, Dialect::Fanuc, Dialect::Haas] {
        let name = dialect.name();
        for file in fs::read_dir(folder.join(name)).unwrap() {
            let path = file.unwrap().path();
            let title = format!("{name}/{}", path.file_name().unwrap().to_string_lossy());
            let text = fs::read_to_string(&path).unwrap();
            let line = REFUSED.iter().find(|(of, _)| *of == title).map(|(_, line)| *line);
            match (read(&text, &options(dialect, "XYZAC")), line) {
                (Ok(program), None) => {
                    assert!(!readings::moves(&program).is_empty(), "{title}");
                    run += 1;
                }
                (Err(faults), Some(line)) => {
                    let fault = &faults[0];
                    assert!(fault.line == line && !fault.help.is_empty(), "{title}: {fault}");
                    refused += 1;
                }
                (Ok(_), Some(line)) => panic!("{title} is not refused at {line}"),
                (Err(faults), None) => panic!("{title}: {}", faults[0]),
            }
        }
    }
    assert_eq!((run, refused), (37, REFUSED.len()));
}
