//! Posting from a program of any dialect to another: no panic, no endless run; motion is conserved or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
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

fuzz_target!(|input: (u8, &str)| {
    let (choice, text) = input;
    let Some((_, machine)) = BUILT_IN.get(usize::from(choice) % BUILT_IN.len()) else { return };
    let Ok(machine) = parse(machine) else { return };
    let kinematics = Kinematics::new(&machine.machine, &Setup::default());
    let _ = post(&kinematics, choice, text);
});

fn post(kinematics: &Kinematics, choice: u8, text: &str) -> Option<String> {
    let axes = AxisWords::of(kinematics.machine()).ok()?;
    let options = ReadOptions { most_repeated: 1000, ..ReadOptions::new(Dialect::guess(text.lines()), axes, 5) };
    let program = read(text, &options).ok()?;
    let mut moves: Vec<PostMove> = Vec::new();
    let mut replay = ProgramMoves::new(kinematics, 1e-2).ok()?;
    for step in program.steps.iter().take(2000) {
        replay.step(step, &mut moves).ok()?;
    }
    moves.truncate(2000);
    let (_, format) = OUTPUT_FORMATS[usize::from(choice / 7) % OUTPUT_FORMATS.len()];
    let style = Style::of(kinematics, format, axes);
    let options = PostOptions {
        control: control_of(kinematics, format),
        tolerance: PoseTolerance::new(0.01, 1e-3),
        max_feed: None,
        method: PostMethod::Optimal,
        window: 256,
        filter: PostFilter::None,
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
