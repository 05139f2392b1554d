//! Posting with new feeds: cutter locations in, text out, blocks per second on one core. The budget is 200 000.
//!
//! Beside it, in the same run, the part that any check of the text has to do: read it.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trunnion::blocks::BlockInterpolation;
use trunnion::files::machine::{built_in, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{ReadOptions, steps};
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

/// Machine, words and template of a dialect.
struct Setting {
    kinematics: Kinematics,
    style: Style,
    options: PostOptions,
    template: Template,
}

impl Setting {
    fn of(name: &str) -> Option<Self> {
        let dialect = OutputFormat::from_name(name)?;
        let file = parse(built_in("ac-trunnion").ok()?).ok()?;
        let setup = Setup::new([0.0, 0.0, -450.0].into(), [0.0; 3], 100.0);
        let kinematics = Kinematics::new(&file.machine, &setup);
        let style = Style::of(&kinematics, dialect, AxisWords::of(&file.machine).ok()?);
        let control = control_of(&kinematics, dialect);
        let options = PostOptions::within(control, PoseTolerance::new(0.01, 1e-3));
        Some(Self { kinematics, style, options, template: Template::of(dialect).ok()? })
    }

    /// Posts moves, and hands the text on in pieces.
    fn post(&self, moves: &[PostMove], mut take: impl FnMut(&str)) -> Option<usize> {
        let head = ProgramHead { note: &NOTE, template: &self.template };
        let source = PostSource::Locations;
        let mut poster = Poster::new(&self.kinematics, source, &self.options, &self.style).ok()?;
        let mut text = String::new();
        for one in moves {
            poster.push(&mut text, black_box(one), head).ok()?;
            take(&text);
            text.clear();
        }
        let report = poster.finish(&mut text, head).ok()?;
        take(&text);
        Some(report.blocks.output)
    }
}

const NOTE: Note<'static> = Note {
    name: "bench",
    tool: ToolNote { number: 1, major: 0.0, minor: 5.0 },
    spindle: 0.0,
    coolant: Coolant::Off,
    feed: 0.0,
    budget: &[],
    duration: 0.0,
    remarks: &[],
};

#[divan::bench(args = ["linuxcnc", "g93", "fanuc", "siemens", "heidenhain"])]
fn blocks(bencher: Bencher, name: &str) {
    let Some(setting) = Setting::of(name) else { return };
    let moves = moves();
    bencher.counter(ItemsCount::new(MOVES)).bench(|| {
        let mut length = 0;
        setting.post(&moves, |text| length += text.len()).map_or(0, |blocks| length + blocks)
    });
}

/// Reads the posted text alone, as posting does besides.
#[divan::bench(args = ["linuxcnc", "g93", "fanuc", "siemens", "heidenhain"])]
fn reading(bencher: Bencher, name: &str) {
    let Some(setting) = Setting::of(name) else { return };
    let mut posted = String::new();
    setting.post(&moves(), |text| posted.push_str(text));
    let options = ReadOptions::new(setting.style.dialect.dialect(), setting.style.axes, 5);
    bencher
        .counter(ItemsCount::new(MOVES))
        .bench(|| steps(black_box(&posted).lines(), &options).map_while(Result::ok).count());
}
