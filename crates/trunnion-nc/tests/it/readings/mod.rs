//! What programs of any dialect come to, for the tests of their readers.

#![allow(dead_code, reason = "every test uses its own part")]
#![allow(clippy::panic, clippy::expect_used, reason = "a test stops on surprise")]
#![allow(clippy::print_stdout, reason = "says which files are absent")]

use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion_nc::read::{AxisWord, AxisWords, Dialect, Move, Program, ReadOptions, Step, Way};

/// Axes by their letters; A B C turn.
pub(crate) fn options(dialect: Dialect, letters: &str) -> ReadOptions {
    let mut axes = [AxisWord { letter: ' ', rotary: false, decimals: 4, reversed: false }; 5];
    for (word, letter) in axes.iter_mut().zip(letters.chars()) {
        (word.letter, word.rotary) = (letter, "ABC".contains(letter));
    }
    ReadOptions::new(dialect, AxisWords(axes), 20)
}

pub(crate) fn read(text: &str, options: &ReadOptions) -> Program {
    trunnion_nc::read::read(text, options).unwrap_or_else(|faults| {
        let all: Vec<_> = faults.iter().map(ToString::to_string).collect();
        panic!("{}", all.join("\n"))
    })
}

pub(crate) fn moves(program: &Program) -> Vec<Move> {
    let step = |step: &Step| match step {
        Step::Move(found) => Some(*found),
        _ => None,
    };
    program.steps.iter().filter_map(step).collect()
}

/// Plane, centre from the start, and sweep over half a turn of an arc.
pub(crate) type ArcSaid = ([usize; 2], [f64; 2], f64);

/// The first arcs are those expected; all of them are returned.
pub(crate) fn arcs(program: &Program, expected: &[ArcSaid]) -> Vec<ArcSaid> {
    let said = |found: Move| match found.way {
        Way::Arc(arc) => Some((arc.plane, arc.center, arc.sweep / PI)),
        Way::Line => None,
    };
    let arcs: Vec<_> = moves(program).into_iter().filter_map(said).collect();
    assert!(arcs.len() >= expected.len(), "{arcs:?}");
    for (found, (plane, center, sweep)) in arcs.iter().zip(expected) {
        assert_eq!(found.0, *plane);
        assert!((found.1[0] - center[0]).hypot(found.1[1] - center[1]) < 1e-9, "{found:?}");
        assert!((found.2 - sweep).abs() < 1e-9, "{found:?} is not {sweep}");
    }
    arcs
}

/// First three words after each move, as far as absolute and relative words tell.
pub(crate) fn places(program: &Program) -> Vec<[f64; 3]> {
    let mut at = [0.0; 3];
    let follow = |found: Move| {
        for (place, word) in at.iter_mut().zip(found.words) {
            match word {
                Some(word) if found.incremental => *place += word,
                Some(word) => *place = word,
                None => {}
            }
        }
        at
    };
    moves(program).into_iter().map(follow).collect()
}

/// A sample beside the repository; says so where it is absent.
pub(crate) fn sample(name: &str) -> Option<String> {
    let path = root().join("../shared/samples").join(name);
    let text = fs::read(&path).ok().map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    if text.is_none() {
        println!("skipped: {} is absent", path.display());
    }
    text
}

pub(crate) fn fixture(name: &str) -> String {
    fs::read_to_string(root().join("fixtures/worked-cut").join(name)).expect("a fixture")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The last three poses with feed are those of the worked cut: tips as written, tool axes of A and C of a trunnion,
/// `Rz(C) Rx(A) z`, or as vectors.
pub(crate) fn is_the_worked_cut(program: &Program, tolerance: f64) {
    let expected = [
        ([10.0, 5.0, -2.0], [0.129_409_5, -0.224_143_9, 0.965_925_8]),
        ([12.5, 6.0, -2.2], [0.159_237_0, -0.245_203_5, 0.956_304_8]),
        ([15.0, 7.4, -2.5], [0.205_832_9, -0.273_149_4, 0.939_692_6]),
    ];
    let (mut tip, mut angles, mut vector) = ([f64::NAN; 3], [f64::NAN; 2], None);
    let mut poses = Vec::new();
    for found in moves(program) {
        if found.frame == trunnion_nc::read::Frame::Machine {
            continue;
        }
        for (place, word) in tip.iter_mut().zip(found.words) {
            *place = word.unwrap_or(*place);
        }
        for (angle, word) in angles.iter_mut().zip([found.words[3], found.words[4]]) {
            if let Some(word) = word {
                (*angle, vector) = (word, None);
            }
        }
        vector = found.axis.map(nalgebra::UnitVector3::into_inner).or(vector);
        let [a, c] = angles;
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), c)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), a)
            * Vector3::z();
        poses.push((tip, vector.unwrap_or(turned)));
    }
    let mut next = expected.iter();
    let mut wanted = next.next();
    for (tip, axis) in &poses {
        let Some((at, along)) = wanted else { break };
        let near =
            (0..3).all(|k| (tip[k] - at[k]).abs() < 1e-9 && (axis[k] - along[k]).abs() < tolerance);
        if near {
            wanted = next.next();
        }
    }
    assert!(wanted.is_none(), "{wanted:?} is not among {poses:?}");
}

/// A row of a table of the book: an example of a code, and what becomes of it.
#[derive(Debug, Clone)]
pub(crate) struct BookRow {
    /// Heading above it.
    pub(crate) heading: String,
    pub(crate) example: String,
    pub(crate) result: String,
}

/// Rows of the tables of a page about a dialect.
pub(crate) fn rows_of_the_book(page: &str) -> Vec<BookRow> {
    let page = root().join("docs/book/src/reference/dialects").join(page);
    let text = fs::read_to_string(page).expect("a page of the book");
    let (mut heading, mut rows) = (String::new(), Vec::new());
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            title.trim().clone_into(&mut heading);
        }
        let Some(row) = line.strip_prefix("| ") else { continue };
        let cells: Vec<&str> = row.split(" | ").collect();
        let [_, example, result, ..] = cells[..] else { continue };
        if let Some(example) = example.strip_prefix('`').and_then(|cell| cell.strip_suffix('`')) {
            let (example, result) = (example.to_owned(), result.trim().to_owned());
            rows.push(BookRow { heading: heading.clone(), example, result });
        }
    }
    rows
}

/// A program around the examples of a page.
#[derive(Debug, Clone)]
pub(crate) struct ExampleProgram<'a> {
    pub(crate) before: &'a str,
    pub(crate) behind: &'a str,
    pub(crate) options: ReadOptions,
}

impl ExampleProgram<'_> {
    /// A row of the book says what becomes of its example.
    pub(crate) fn holds(&self, row: &BookRow) {
        let BookRow { example, result, .. } = row;
        let dialect = self.options.dialect;
        let steps = |example: &str| {
            let lines = example.replace(" / ", "\n");
            let text = format!("{}{lines}{}", self.before, self.behind);
            trunnion_nc::read::read(&text, &self.options).map(|program| program.steps)
        };
        let plain = steps("").expect("the program around the examples");
        let moves = |steps: &[Step]| steps.iter().filter(|s| matches!(s, Step::Move(_))).count();
        let words =
            |steps: &[Step]| steps.iter().filter(|s| matches!(s, Step::Words { .. })).count();
        match (result.as_str(), steps(example)) {
            ("refused", Err(faults)) => {
                let fault = &faults[0];
                let placed = fault.line > 0 && !fault.help.is_empty();
                assert!(placed, "{dialect}: {example}: {fault}");
            }
            ("refused", Ok(_)) => panic!("{dialect}: {example} is not refused"),
            (_, Err(faults)) => panic!("{dialect}: {example}: {}", faults[0]),
            // One step more: the words as they stand.
            ("kept", Ok(made)) => {
                assert_eq!(moves(&made), moves(&plain), "{dialect}: {example}");
                assert_eq!(words(&made), 1, "{dialect}: {example}");
            }
            ("run", Ok(made)) => {
                let kept = words(&made) > 0;
                assert!(!kept && made.len() >= plain.len(), "{dialect}: {example}");
            }
            (other, _) => panic!("{dialect}: {example}: {other}"),
        }
    }
}
