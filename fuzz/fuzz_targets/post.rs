//! Posting from a program of any dialect to another: no panic, no endless run; motion is conserved or refused.
//!
//! Behind the text of the input come moves inside the travel of the machine, so that most inputs are posted to the end.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::fmt::Write;
use std::sync::LazyLock;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{AxisWords, Dialect, ReadOptions, read};
use trunnion::nc::write::{Coolant, Note, OUTPUT_FORMATS, Style, Template, ToolNote};
use trunnion::post::{
    PostError, PostFilter, PostMethod, PostMove, PostOptions, PostSource, Poster, ProgramHead,
    ProgramMoves, control_of,
};
use trunnion::types::PoseTolerance;

const NOTE: Note<'static> = Note {
    name: "fuzz",
    tool: ToolNote { number: 1, major: 0.0, minor: 5.0 },
    spindle: 1000.0,
    coolant: Coolant::Flood,
    feed: 0.0,
    budget: &[],
    duration: 0.0,
    remarks: &[],
};

/// Built-in machines with their words, parsed once.
static MACHINES: LazyLock<Vec<(Kinematics, AxisWords)>> = LazyLock::new(|| {
    let machines = BUILT_IN.iter().filter_map(|(_, text)| parse(text).ok());
    machines
        .filter_map(|file| {
            let words = AxisWords::of(&file.machine).ok()?;
            Some((Kinematics::new(&file.machine, &Setup::default()), words))
        })
        .collect()
});

/// Choice of machine, dialect and method, text of a program, and moves behind it.
type Input<'a> = (u8, u8, &'a str, Vec<(u8, [i8; 5])>);

fuzz_target!(|input: Input<'_>| {
    let (machine, choice, text, moves) = input;
    let Some((kinematics, words)) = MACHINES.get(usize::from(machine) % MACHINES.len()) else { return };
    let mut whole = text.to_owned();
    append_moves(&mut whole, kinematics, words, &moves);
    let _ = post(kinematics, *words, choice, &whole);
});

/// Appends moves whose axes are inside travel: the first number is the feed, zero a rapid move.
fn append_moves(text: &mut String, kinematics: &Kinematics, words: &AxisWords, moves: &[(u8, [i8; 5])]) {
    if moves.is_empty() {
        return;
    }
    text.push_str("\nG21 G90 G94 G54 G17 G49\n");
    for (feed, shares) in moves.iter().take(200) {
        text.push_str(if *feed == 0 { "G0" } else { "G1" });
        for ((word, share), axis) in words.0.iter().zip(shares).zip(&kinematics.machine().axes) {
            let [low, high] = axis.limits.ends();
            let [low, high] = [low.max(-10.0), high.min(10.0)];
            let at = low + (f64::from(*share) + 128.0) / 256.0 * (high - low);
            let _ = write!(text, " {}{:.3}", word.letter, if word.rotary { at.to_degrees() } else { at });
        }
        let _ = if *feed == 0 { writeln!(text) } else { writeln!(text, " F{}", 40 * u32::from(*feed)) };
    }
}

fn post(kinematics: &Kinematics, axes: AxisWords, choice: u8, text: &str) -> Option<String> {
    let dialect = Dialect::guess(text.lines());
    let options = ReadOptions { most_repeated: 1000, ..ReadOptions::new(dialect, axes, 5) };
    let program = read(text, &options).ok()?;
    let mut moves: Vec<PostMove> = Vec::new();
    let mut replay = ProgramMoves::new(kinematics, 1e-2).ok()?;
    for step in program.steps.iter().take(2000) {
        replay.step(step, &mut moves).ok()?;
    }
    moves.truncate(2000);
    let (_, format) = OUTPUT_FORMATS[usize::from(choice) % OUTPUT_FORMATS.len()];
    let style = Style::of(kinematics, format, axes);
    let methods = [PostMethod::Optimal, PostMethod::Blocks, PostMethod::Programmed];
    let filters = [PostFilter::None, PostFilter::None, PostFilter::Reduce, PostFilter::Smooth];
    let options = PostOptions {
        control: control_of(kinematics, format),
        tolerance: PoseTolerance::new(0.01, 1e-3),
        max_feed: None,
        method: methods[usize::from(choice / 16) % methods.len()],
        window: 256,
        filter: filters[usize::from(choice / 48) % filters.len()],
        unwind: None,
    };
    let template = Template::of(format).ok()?;
    let head = ProgramHead { note: &NOTE, template: &template };
    let source = PostSource::Program(Box::new(kinematics.clone()));
    let mut out = String::new();
    let posted = (|| {
        let mut poster = Poster::new(kinematics, source, &options, &style)?;
        moves.iter().try_for_each(|one| poster.push(&mut out, one, head))?;
        poster.finish(&mut out, head)
    })();
    // What is written must read back as it was meant.
    if let Err(PostError::ReadBack(error)) = &posted {
        panic!("{error}");
    }
    posted.ok().map(|_| out)
}
