//! Posted programs, read back: the same motion within tolerance, limits kept, on every built-in machine.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use crate::dice;

use dice::Random;
use nalgebra::Vector3;
use trunnion::blocks::{BlockEnd, BlockInterpolation, moved};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::math::angle::great_circle;
use trunnion::nc::read::{self, Frame, Move, Pace, ReadOptions, Step};
use trunnion::nc::write::{
    AxisWords, Coolant, Note, OUTPUT_FORMATS, OutputFormat, Style, Template, ToolNote, work_offset,
};
use trunnion::post::{
    PostError, PostMove, PostOptions, PostPace, PostReport, PostSource, Poster, ProgramHead,
    control_of,
};
use trunnion::types::{AxisVector, PoseTolerance, ToolPose};

const TOLERANCE: PoseTolerance = PoseTolerance::new(0.01, 1e-3);

/// Rounding of words of four decimals at a lever of a metre: half a last digit of two rotaries, and of X Y Z.
const ROUNDING: f64 = 2.0 * 0.5e-4 * std::f64::consts::PI / 180.0 * 1000.0 + 1e-4;

fn note() -> Note<'static> {
    Note {
        name: "random (path)",
        tool: ToolNote { number: 1, major: 0.0, minor: 5.0 },
        spindle: 8000.0,
        coolant: Coolant::Flood,
        feed: 0.0,
        budget: &[],
        duration: 0.0,
        remarks: &[],
    }
}

/// Returns true if the axes keep their limits, as the report says.
fn kept(report: &PostReport) -> bool {
    report.loads.output.velocity.max(report.loads.output.acceleration) <= 1.0 + 1e-6
}

fn options(control: BlockInterpolation) -> PostOptions {
    PostOptions { window: 512, ..PostOptions::within(control, TOLERANCE) }
}

fn posted(
    kinematics: &Kinematics,
    source: PostSource,
    dialect: OutputFormat,
    moves: &[PostMove],
) -> (String, PostReport) {
    let options = options(control_of(kinematics, dialect));
    let template = Template::of(dialect).unwrap();
    posted_with(kinematics, source, (dialect, &template), moves, &options).unwrap()
}

fn posted_with(
    kinematics: &Kinematics,
    source: PostSource,
    (dialect, template): (OutputFormat, &Template),
    moves: &[PostMove],
    options: &PostOptions,
) -> Result<(String, PostReport), PostError> {
    let axes = AxisWords::of(kinematics.machine()).unwrap();
    let style = Style {
        inverse_time: dialect == OutputFormat::LinuxCnc || dialect == OutputFormat::G93,
        ..Style::of(kinematics, dialect, axes)
    };
    let mut poster = Poster::new(kinematics, source, options, &style).unwrap();
    let mut text = String::new();
    for one in moves {
        poster.push(&mut text, one, ProgramHead { note: &note(), template })?;
    }
    let report = poster.finish(&mut text, ProgramHead { note: &note(), template })?;
    Ok((text, report))
}

/// A path that the machine reaches: forward images of a smooth path of its axes about the middle of their travel.
fn path(kinematics: &Kinematics, random: &mut Random, count: u32) -> Vec<PostMove> {
    let machine = kinematics.machine();
    let middle = machine.vector(|axis| {
        let [low, high] = axis.limits.ends();
        if (high - low).is_finite() { 0.5 * (low + high) } else { 0.3 }
    });
    let size = |axis: usize| if axis < 3 { 20.0 } else { 0.15 };
    let wave = AxisVector::from_fn(|axis, _| random.within(0.2, 1.0) * size(axis));
    let phase = AxisVector::from_fn(|_, _| random.within(0.0, 6.0));
    let feed = random.within(5.0, 80.0);
    (0..count)
        .map(|k| {
            let t = 0.05 * f64::from(k);
            let q = middle
                + AxisVector::from_fn(|axis, _| {
                    wave[axis] * (t * (1.0 + 0.2 * axis as f64) + phase[axis]).sin()
                });
            let pace = match k {
                0 | 1 | 20 => PostPace::Rapid,
                k if k < 10 => PostPace::Feed(0.5 * feed),
                _ => PostPace::Feed(feed),
            };
            PostMove {
                line: k + 1,
                pose: kinematics.forward(&q),
                q: None,
                pace,
                way: BlockInterpolation::GreatCircle,
            }
        })
        .collect()
}

/// One block of a program that was read: axes and pose at its end.
#[derive(Debug, Clone, Copy)]
struct Ran {
    q: AxisVector,
    pose: ToolPose,
    pace: Pace,
}

/// Follows the words; what a control does with them, written anew for this test.
fn run(kinematics: &Kinematics, dialect: OutputFormat, moves: &[Move]) -> Vec<Ran> {
    let offset = work_offset(kinematics).unwrap();
    let length = kinematics.setup().tool_length;
    let back = kinematics.setup().rotation.inverse();
    let mut words = [0.0; 5];
    let mut before: Option<Ran> = None;
    let mut ran = Vec::new();
    let inverse = trunnion::inverse::Inverse::new(kinematics).unwrap();
    let mut axis = Vector3::z();
    for one in moves {
        let Frame::Work { tcp, length: long, .. } = one.frame else { continue };
        assert!(!one.incremental);
        for (slot, word) in words.iter_mut().zip(one.words) {
            *slot = word.unwrap_or(*slot);
        }
        if let Some(vector) = one.axis {
            axis = kinematics.setup().rotation.inverse() * vector.into_inner();
        }
        let tip = Vector3::new(words[0], words[1], words[2]);
        let (q, pose) = if tcp {
            let mut q = AxisVector::from([0.0, 0.0, 0.0, words[3], words[4]]);
            let direction = if dialect.is_vector() && one.axis.is_some()
                || before.is_some() && dialect.is_vector()
            {
                axis
            } else {
                kinematics.forward(&q).axis.into_inner()
            };
            let pose = ToolPose::new((back * tip).into(), direction.into()).unwrap();
            let near = before.map_or(q, |ran: Ran| ran.q);
            let near = if dialect.is_vector() { near } else { q };
            q = inverse.near(&pose, &near).unwrap();
            (q, pose)
        } else {
            let shift = offset + Vector3::z() * if long { length } else { 0.0 };
            let linear = tip + shift;
            let q = AxisVector::from([linear.x, linear.y, linear.z, words[3], words[4]]);
            (q, kinematics.forward(&q))
        };
        let now = Ran { q, pose, pace: one.pace };
        before = Some(now);
        ran.push(now);
    }
    ran
}

fn reader(dialect: OutputFormat) -> Option<read::Dialect> {
    Some(match dialect {
        OutputFormat::LinuxCnc | OutputFormat::G93 => read::Dialect::LinuxCnc,
        OutputFormat::Fanuc | OutputFormat::FanucVector => read::Dialect::Fanuc,
        OutputFormat::Haas => read::Dialect::Haas,
        OutputFormat::Siemens | OutputFormat::SiemensAxes => read::Dialect::Siemens,
        OutputFormat::Heidenhain | OutputFormat::HeidenhainAxes => read::Dialect::Heidenhain,
        OutputFormat::Apt => return None,
    })
}

/// Distance of a pose from a chord of the input, at its best share.
fn off(pose: &ToolPose, [from, to]: [&ToolPose; 2]) -> [f64; 2] {
    let chord = to.tip - from.tip;
    let share = ((pose.tip - from.tip).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
    let axis = great_circle(&from.axis, &to.axis, share).unwrap();
    [(from.tip + chord * share - pose.tip).norm(), axis.angle(&pose.axis)]
}

/// Blocks of a program against the moves it was posted from.
fn compare(
    kinematics: &Kinematics,
    dialect: OutputFormat,
    ran: &[Ran],
    moves: &[PostMove],
    name: &str,
) {
    let control = control_of(kinematics, dialect);
    // Words of the starting position come one by one: what counts is where the first block starts.
    let start = ran.iter().position(|one| (one.pose.tip - moves[0].pose.tip).norm() < ROUNDING);
    let mut ran = ran[start.unwrap()..].windows(2).peekable();
    for pair in moves.windows(2) {
        let ends = [&pair[0].pose, &pair[1].pose];
        loop {
            let Some(block) = ran.next() else {
                panic!("{name}: the program ends before line {}", pair[1].line)
            };
            let (from, to) = (&block[0], &block[1]);
            let rapid = pair[1].pace == PostPace::Rapid;
            assert_eq!(to.pace == Pace::Rapid, rapid, "{name}: line {}", pair[1].line);
            for k in 0..=8 {
                let share = f64::from(k) / 8.0;
                let at = moved(
                    kinematics,
                    control,
                    [from, to].map(|end| BlockEnd::new(&end.q, &end.pose)),
                    share,
                );
                let [tip, axis] = off(&at.unwrap(), ends);
                let limits = if rapid { [1.0, 1.0] } else { TOLERANCE.into() };
                assert!(
                    tip <= limits[0] + ROUNDING,
                    "{name}: tip off by {tip} at line {}",
                    pair[1].line
                );
                assert!(
                    axis <= limits[1] + 1e-5,
                    "{name}: axis off by {axis} at line {}",
                    pair[1].line
                );
            }
            let reached = (to.pose.tip - ends[1].tip).norm() <= ROUNDING
                && to.pose.axis.angle(&ends[1].axis) <= 5e-6;
            if reached {
                break;
            }
        }
        let length = (pair[1].pose.tip - pair[0].pose.tip).norm();
        assert!(length > 0.0);
    }
    assert!(ran.next().is_none(), "{name}: the program goes on");
}

/// Mean speeds of blocks in inverse time against the limits, from the text alone.
fn limits(kinematics: &Kinematics, ran: &[Ran], name: &str) {
    let machine = kinematics.machine();
    let [velocity, acceleration] =
        [machine.vector(|axis| axis.vel), machine.vector(|axis| axis.acc)];
    let mut before = (AxisVector::zeros(), 0.0);
    for pair in ran.windows(2) {
        let travel = pair[1].q - pair[0].q;
        let Pace::Inverse { seconds } = pair[1].pace else {
            before = (AxisVector::zeros(), 0.0);
            continue;
        };
        let mean = travel / seconds;
        // Words are right to half of their last digit at both ends, feeds to a thousandth of 1/min.
        let slack = 4.0 * ROUNDING / seconds;
        for axis in 0..5 {
            let most = velocity[axis] + slack;
            assert!(mean[axis].abs() <= most, "{name}: axis {axis} at {} of {most}", mean[axis]);
            let middle = 0.5 * (seconds + before.1);
            let change = (mean[axis] - before.0[axis]).abs() / middle;
            let most = acceleration[axis] * 1.001 + 2.0 * slack / middle;
            assert!(change <= most, "{name}: axis {axis} changes by {change} of {most}");
        }
        before = (mean, seconds);
    }
}

/// No block has a higher feed than the move of the input that it belongs to.
fn assert_no_faster(ran: &[Ran], moves: &[PostMove], name: &str) {
    let reached = |one: &PostMove, now: &Ran| (one.pose.tip - now.pose.tip).norm() < ROUNDING;
    let start = ran.iter().position(|now| reached(&moves[0], now)).unwrap();
    let mut wanted = moves[1..].iter().peekable();
    for now in &ran[start + 1..] {
        let Some(one) = wanted.peek() else { break };
        if let (Pace::PerMinute { speed }, PostPace::Feed(feed)) = (now.pace, one.pace) {
            assert!(speed <= feed * (1.0 + 1e-9), "{name}: {speed} above {feed} at {now:?}");
        }
        if reached(one, now) {
            wanted.next();
        }
    }
    assert!(wanted.next().is_none(), "{name}: a move is not reached");
}

fn moves_of(steps: &[Step]) -> Vec<Move> {
    let one = |step: &Step| match step {
        Step::Move(one) => Some(*one),
        _ => None,
    };
    steps.iter().filter_map(one).collect()
}

/// Whether a dialect can be read back.
fn is_read(dialect: OutputFormat) -> bool {
    dialect != OutputFormat::Apt
}

#[test]
fn programs_read_back_are_the_moves_they_were_posted_from() {
    let mut random = Random(dice::seed());
    for (built_in, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        let origin = random.point(20.0);
        let rotation = [0.0, 0.0, random.within(-1.0, 1.0)];
        let kinematics = Kinematics::new(&machine, &Setup::new(origin, rotation, 120.0));
        let moves = path(&kinematics, &mut random, 40);
        for (format, dialect) in OUTPUT_FORMATS.into_iter().filter(|(_, dialect)| is_read(*dialect))
        {
            let name = format!("{built_in}, {format}");
            let (text, report) = posted(&kinematics, PostSource::Locations, dialect, &moves);
            let axes = AxisWords::of(&machine).unwrap();
            // The reference point is the machine's, not the part's.
            let text = text.replace("G91 G28 Z0.\nG90\n", "");
            let read = ReadOptions::new(reader(dialect).unwrap(), axes, 5);
            let program = read::read(&text, &read)
                .unwrap_or_else(|faults| panic!("{name}: {faults:?}\n{text}"));
            let ran = run(&kinematics, dialect, &moves_of(&program.steps));
            compare(&kinematics, dialect, &ran, &moves, &name);
            limits(&kinematics, &ran, &name);
            assert!(kept(&report), "{name}: {report:?}");
            assert_no_faster(&ran, &moves, &name);
            // A tip feed is that of the rounded way, whose time differs with its length.
            if matches!(dialect, OutputFormat::G93 | OutputFormat::LinuxCnc) {
                assert!(
                    report.seconds.output >= report.seconds.input * (1.0 - 1e-9),
                    "{name}: {report:?}"
                );
            }
        }
    }
}

/// A helix about z in moves of a degree and a half, the tool leaning outwards by 20 degrees: the turning axis goes round
/// with it.
fn helix(count: u32) -> Vec<PostMove> {
    let lean = 20.0_f64.to_radians();
    (0..=count)
        .map(|line| {
            let k = f64::from(line);
            let (sin, cos) = (1.5 * k).to_radians().sin_cos();
            let axis = [lean.sin() * cos, lean.sin() * sin, lean.cos()];
            let tip = [60.0 * cos, 60.0 * sin, 100.0 - 0.05 * k];
            let pace = if line == 0 { PostPace::Rapid } else { PostPace::Feed(50.0) };
            let pose = ToolPose::new(tip, axis).unwrap();
            PostMove { line: line + 1, pose, q: None, pace, way: BlockInterpolation::GreatCircle }
        })
        .collect()
}

#[test]
fn a_helix_beyond_the_travel_of_a_rotary_goes_round_off_the_part() {
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "gantry-ca-fork").unwrap();
    let machine = parse(text).unwrap().machine;
    let setup = Setup::new(Vector3::new(1500.0, 700.0, -800.0), [0.0; 3], 100.0);
    let kinematics = Kinematics::new(&machine, &setup);
    let axes = AxisWords::of(&machine).unwrap();
    for dialect in [OutputFormat::Fanuc, OutputFormat::G93] {
        let template = Template::of(dialect).unwrap();
        let plain = options(control_of(&kinematics, dialect));
        let post = |moves: &[PostMove], unwind| {
            let options = PostOptions { unwind, ..plain };
            posted_with(&kinematics, PostSource::Locations, (dialect, &template), moves, &options)
        };
        // From the turn next to home the axis comes to its end after 1.3 turns at most, from another after 1.7.
        let (_, report) = post(&helix(408), None).unwrap();
        assert!(report.unwound.is_empty());
        let moves = helix(720);
        assert!(matches!(post(&moves, None), Err(PostError::Strays { .. })));
        let (text, report) = post(&moves, Some(50.0)).unwrap();
        assert_eq!(report.unwound.len(), 1);
        let read = ReadOptions::new(reader(dialect).unwrap(), axes, 5);
        let program = read::read(&text.replace("G91 G28 Z0.\nG90\n", ""), &read).unwrap();
        let ran = run(&kinematics, dialect, &moves_of(&program.steps));
        let start = ran.iter().position(|one| (one.pose.tip - moves[0].pose.tip).norm() < ROUNDING);
        let mut wanted = moves[1..].iter().peekable();
        for pair in ran[start.unwrap()..].windows(2) {
            let [before, now] = [&pair[0], &pair[1]];
            assert!(machine.out_of_travel(&now.q).is_none(), "{now:?}");
            let turned = (now.q - before.q).fixed_rows::<2>(3).amax();
            if now.pace == Pace::Rapid && turned > 0.1 {
                let out = |one: &PostMove| one.pose.tip + one.pose.axis.scale(50.0);
                let is = |one: &PostMove| (out(one) - now.pose.tip).norm() < ROUNDING;
                assert!(moves.iter().any(is), "{now:?}");
            }
            let at = |one: &PostMove| (one.pose.tip - now.pose.tip).norm() < ROUNDING;
            while wanted.next_if(|one| at(one)).is_some() {}
        }
        assert!(wanted.count() == 0, "{dialect:?}: places are left out");
        assert!(kept(&report), "{report:?}");
    }
}

/// Tool vectors do not say which way a rotary turns: its end of travel would be a turn inside the cut, at F0.07.
#[test]
fn a_rotary_that_must_go_round_in_a_cut_of_tool_vectors_is_refused() {
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "gantry-ca-fork").unwrap();
    let machine = parse(text).unwrap().machine;
    let setup = Setup::new(Vector3::new(1500.0, 700.0, -800.0), [0.0; 3], 100.0);
    let kinematics = Kinematics::new(&machine, &setup);
    for dialect in [OutputFormat::Heidenhain, OutputFormat::Siemens, OutputFormat::FanucVector] {
        let template = Template::of(dialect).unwrap();
        let plain = options(control_of(&kinematics, dialect));
        for unwind in [None, Some(50.0)] {
            let options = PostOptions { unwind, ..plain };
            let post = |moves: &[PostMove]| {
                let source = PostSource::Locations;
                posted_with(&kinematics, source, (dialect, &template), moves, &options)
            };
            post(&helix(200)).unwrap();
            let refused = post(&helix(720)).unwrap_err();
            let PostError::GoesRound { line, turn } = refused else { panic!("{refused:?}") };
            assert!(line > 200 && turn > 1.5, "line {line}, {turn} rad");
        }
    }
}

#[test]
fn a_template_that_says_something_else_is_found_by_reading_back() {
    let machine = parse(BUILT_IN[0].1).unwrap().machine;
    let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 100.0));
    let moves = path(&kinematics, &mut Random(dice::seed()), 20);
    let plain = options(control_of(&kinematics, OutputFormat::G93));
    let post = |start: &str| {
        let text =
            format!("{{% extends \"g93\" %}}\n{{% block start %}}\n{start}\n{{% endblock %}}\n");
        let template = Template::new(&text).unwrap();
        let to = (OutputFormat::G93, &template);
        posted_with(&kinematics, PostSource::Locations, to, &moves, &plain)
    };
    let good =
        "G21 G90 G54 G94 G49\nT1 M6\nG43 H1\nG0 {{ first.rotary }}\nG0 {{ first.axes }}\nG93";
    let (_, report) = post(good).unwrap();
    assert_eq!(report.unread, None);
    for (good_word, bad_word, part) in [
        ("G43 H1\n", "", "instead of"),
        ("G21", "G20", "instead of"),
        ("G0 {{ first.axes }}\n", "", "instead of"),
        ("G93", "G91 G93", "instead of"),
        ("G93", "", "instead of"),
    ] {
        let reported = post(&good.replace(good_word, bad_word)).unwrap_err().to_string();
        assert!(
            reported.contains("read back") && reported.contains(part),
            "{bad_word:?}: {reported}"
        );
    }
    // Words that are not known are reported, and the program is written.
    let (_, report) = post(&good.replace("T1 M6", "G65 P9810 Z10.")).unwrap();
    assert!(report.unread.unwrap().message.contains("G65"));
}

#[test]
fn a_cl_file_posted_as_one_says_the_same_locations() {
    let mut random = Random(dice::seed());
    let machine = parse(BUILT_IN[0].1).unwrap().machine;
    let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 100.0));
    let moves = path(&kinematics, &mut random, 40);
    let (text, _) = posted(&kinematics, PostSource::Locations, OutputFormat::Apt, &moves);
    let file = read::cl(&text, 5).unwrap();
    assert_eq!(file.records.len(), moves.len());
    for (record, one) in file.records.iter().zip(&moves) {
        assert!((record.pose.tip - one.pose.tip).norm() <= 1e-4, "{record:?}");
        assert!((*record.pose.axis - *one.pose.axis).norm() <= 2e-9);
        match (record.motion, one.pace) {
            (read::ClMotion::Rapid, PostPace::Rapid) => {}
            (read::ClMotion::Feed(read), PostPace::Feed(asked)) => {
                assert!(read <= asked * (1.0 + 1e-9));
            }
            other => panic!("{other:?}"),
        }
    }
}
