//! Posting with new feeds: cutter locations in, text out, blocks per second on one core. The budget is 200 000.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trunnion::blocks::BlockInterpolation;
use trunnion::files::machine::{built_in, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::write::{AxisWords, Coolant, Note, OutputFormat, Style, Template, ToolNote};
use trunnion::post::{
    PostMove, PostOptions, PostPace, PostSource, Poster, ProgramHead, control_of,
};
use trunnion::types::{PoseTolerance, ToolPose};

const MOVES: u32 = 50_000;

fn main() {
    divan::main();
}

fn moves() -> Vec<PostMove> {
    (0..MOVES)
        .filter_map(|k| {
            let t = 2e-4 * f64::from(k);
            let tip = [40.0 * t.sin(), 30.0 * (1.3 * t).cos(), 3.0 * (7.0 * t).sin()];
            let [a, b] = [0.3 * (2.0 * t).sin(), 0.1 + 0.2 * (1.7 * t).cos()];
            let pose = ToolPose::new(tip, [a, b, 1.0])?;
            let pace = if k == 0 { PostPace::Rapid } else { PostPace::Feed(80.0) };
            Some(PostMove { line: k, pose, q: None, pace, way: BlockInterpolation::GreatCircle })
        })
        .collect()
}

#[divan::bench(args = ["linuxcnc", "g93", "fanuc", "siemens", "heidenhain"])]
fn blocks(bencher: Bencher, name: &str) {
    let Some(dialect) = OutputFormat::from_name(name) else { return };
    let Ok(text) = built_in("ac-trunnion") else { return };
    let Ok(file) = parse(text) else { return };
    let setup = Setup::new([0.0, 0.0, -450.0].into(), [0.0; 3], 100.0);
    let kinematics = Kinematics::new(&file.machine, &setup);
    let (Ok(axes), Ok(template)) = (AxisWords::of(&file.machine), Template::of(dialect)) else {
        return;
    };
    let style = Style::of(&kinematics, dialect, axes);
    let options =
        PostOptions::within(control_of(&kinematics, dialect), PoseTolerance::new(0.01, 1e-3));
    let note = Note {
        name: "bench",
        tool: ToolNote { number: 1, major: 0.0, minor: 5.0 },
        spindle: 0.0,
        coolant: Coolant::Off,
        feed: 0.0,
        budget: &[],
        duration: 0.0,
        remarks: &[],
    };
    let moves = moves();
    bencher.counter(ItemsCount::new(MOVES)).bench(|| {
        let Ok(mut poster) = Poster::new(&kinematics, PostSource::Locations, &options, &style)
        else {
            return 0;
        };
        let (mut text, mut length) = (String::new(), 0);
        for one in &moves {
            if poster
                .push(&mut text, black_box(one), ProgramHead { note: &note, template: &template })
                .is_err()
            {
                return 0;
            }
            length += text.len();
            text.clear();
        }
        let done = poster.finish(&mut text, ProgramHead { note: &note, template: &template });
        done.map_or(0, |report| length + report.blocks.output)
    });
}
