//! Smoothed programs: never longer than the same program without smoothing, and within the tolerance of it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::dice;
use crate::posted;

use dice::Random;
use nalgebra::Vector3;
use trunnion::blocks::BlockInterpolation;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::math::angle::great_circle;
use trunnion::nc::read::{self, AxisWords, ReadOptions};
use trunnion::nc::write::{OutputFormat, Style, Template};
use trunnion::post::{
    PostFilter, PostMethod, PostMove, PostOptions, PostPace, PostReport, PostSource, Poster,
    ProgramHead, ProgramMoves, control_of,
};
use trunnion::types::{AxisVector, PoseTolerance, Setpoint, ToolPose};

const TOLERANCE: PoseTolerance = PoseTolerance::new(0.02, 1e-3);

/// Rounding of the words at a lever of a metre, as in the tests of posting.
const ROUNDING: f64 = 2.0 * 0.5e-4 * std::f64::consts::PI / 180.0 * 1000.0 + 1e-4;

/// Cuts of straight stretches, corners, waves and steps of all sizes, rapid moves between.
fn moves(kinematics: &Kinematics, random: &mut Random) -> Vec<PostMove> {
    let machine = kinematics.machine();
    let mut q = machine.vector(|axis| {
        let [low, high] = axis.limits.ends();
        if (high - low).is_finite() { 0.5 * (low + high) } else { 0.3 }
    });
    let mut line = 0;
    let mut moves = Vec::new();
    let mut add = |q: &AxisVector, pace: PostPace| {
        line += 1;
        let pose = kinematics.forward(q);
        moves.push(PostMove { line, pose, q: None, pace, way: BlockInterpolation::GreatCircle });
    };
    for _ in 0..3 {
        add(&q, PostPace::Rapid);
        let feed = random.within(5.0, 200.0);
        let kinds = [random.within(0.0, 3.0), random.within(0.0, 3.0)];
        for k in 0..90_u32 {
            let step = 10.0_f64.powf(random.within(-2.0, 0.5));
            let kind = kinds[usize::from(k > 45)];
            let t = 0.1 * f64::from(k);
            let way = match kind {
                of if of < 1.0 => AxisVector::from([step, 0.0, 0.0, 0.0, 1e-3]),
                of if of < 2.0 => {
                    AxisVector::from([step * t.cos(), step * t.sin(), 0.1, 1e-3 * t.sin(), 2e-3])
                }
                _ => AxisVector::from_fn(|axis, _| {
                    random.within(-1.0, 1.0) * if axis < 3 { step } else { 0.01 * step }
                }),
            };
            q += way;
            add(&q, PostPace::Feed(feed));
        }
        add(&q, PostPace::Rapid);
        q += AxisVector::from([5.0, -5.0, 3.0, 0.01, 0.02]);
    }
    // Nothing to gain on a straight line.
    add(&q, PostPace::Rapid);
    q[0] += 20.0;
    add(&q, PostPace::Feed(30.0));
    moves
}

fn post(
    kinematics: &Kinematics,
    style: &Style,
    (filter, moves): (PostFilter, &[PostMove]),
) -> (String, PostReport) {
    let options = PostOptions {
        window: 512,
        filter,
        ..PostOptions::within(control_of(kinematics, style.dialect), TOLERANCE)
    };
    let template = Template::of(style.dialect).unwrap();
    let mut poster = Poster::new(kinematics, PostSource::Locations, &options, style).unwrap();
    let mut text = String::new();
    for one in moves {
        poster
            .push(&mut text, one, ProgramHead { note: &posted::NOTE, template: &template })
            .unwrap();
    }
    let report =
        poster.finish(&mut text, ProgramHead { note: &posted::NOTE, template: &template }).unwrap();
    (text, report)
}

/// Least distance of a pose from the straight moves, a tolerance each of tip and tool axis being 1.
fn off(pose: &ToolPose, moves: &[PostMove]) -> f64 {
    off_pairs(pose, moves.windows(2))
}

/// The same of some of the moves, each with the one before it.
fn off_pairs<'a>(pose: &ToolPose, moves: impl Iterator<Item = &'a [PostMove]>) -> f64 {
    let one = |pair: &[PostMove]| {
        let [from, to] = [&pair[0].pose, &pair[1].pose];
        let chord = to.tip - from.tip;
        let square = chord.norm_squared();
        let share = if square > 0.0 { (pose.tip - from.tip).dot(&chord) / square } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        let axis = great_circle(&from.axis, &to.axis, share).unwrap();
        let tip = (from.tip + chord * share - pose.tip).norm();
        ((tip - ROUNDING) / TOLERANCE.tip).max((axis.angle(&pose.axis) - 1e-5) / TOLERANCE.axis)
    };
    moves.map(one).fold(f64::INFINITY, f64::min)
}

#[test]
fn smoothing_is_chosen_where_it_is_quicker_and_stays_within_the_tolerance() {
    let mut random = Random(dice::seed());
    let (mut gained, mut kept) = (0, 0);
    for (name, text) in BUILT_IN.into_iter().take(4) {
        let machine = parse(text).unwrap().machine;
        let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 120.0));
        let moves = moves(&kinematics, &mut random);
        let axes = AxisWords::of(&machine).unwrap();
        let dialects = [
            (OutputFormat::LinuxCnc, read::Dialect::LinuxCnc),
            (OutputFormat::G93, read::Dialect::LinuxCnc),
            (OutputFormat::Haas, read::Dialect::Haas),
            (OutputFormat::Siemens, read::Dialect::Siemens),
        ];
        for (dialect, language) in dialects {
            let style = Style::of(&kinematics, dialect, axes);
            let [plain, smooth] = [PostFilter::None, PostFilter::Smooth]
                .map(|filter| post(&kinematics, &style, (filter, &moves)));
            let choice = smooth.1.smoothing.unwrap();
            let of = |report: &PostReport| {
                if choice.by_model { report.model_seconds.output } else { report.seconds.output }
            };
            let [before, after] = [of(&plain.1), of(&smooth.1)];
            assert!(after <= before * (1.0 + 1e-9), "{name} {dialect:?}: {before} -> {after}");
            assert!((choice.seconds.input - before).abs() <= 1e-6 * before, "{choice:?} {before}");
            assert!((choice.seconds.output - after).abs() <= 1e-6 * after, "{choice:?} {after}");
            assert_eq!(choice.cuts.iter().sum::<usize>(), 4, "{choice:?}");
            gained += choice.cuts[1] + choice.cuts[2];
            kept += choice.cuts[0];
            assert!(
                smooth.1.deviation.tip <= TOLERANCE.tip
                    && smooth.1.deviation.axis <= TOLERANCE.axis
            );
            let program = read::read(&smooth.0, &ReadOptions::new(language, axes, 5)).unwrap();
            let (mut replay, mut places) =
                (ProgramMoves::new(&kinematics, 1e-3).unwrap(), Vec::new());
            for step in &program.steps {
                replay.step(step, &mut places).unwrap();
            }
            assert!(places.len() > 30, "{name} {dialect:?}: {} places", places.len());
            for place in places.iter().filter(|place| place.pace != PostPace::Rapid) {
                let off = off(&place.pose, &moves);
                assert!(off <= 1.0, "{name} {dialect:?}: {off} tolerances at {place:?}");
            }
        }
    }
    assert!(gained > 0 && kept > 0, "{gained} smoothed, {kept} as they were");
}

/// Setpoints of moves, at a millisecond.
fn setpoints(kinematics: &Kinematics, moves: &[PostMove]) -> Vec<Setpoint> {
    let dialect = OutputFormat::G93;
    let style = Style::of(kinematics, dialect, AxisWords::of(kinematics.machine()).unwrap());
    let options = PostOptions {
        method: PostMethod::Programmed,
        window: 512,
        // Half for the points, half for the corners between them.
        ..PostOptions::within(control_of(kinematics, dialect), TOLERANCE.scaled(0.5))
    };
    let template = Template::of(dialect).unwrap();
    let head = ProgramHead { note: &posted::NOTE, template: &template };
    let poster = Poster::new(kinematics, PostSource::Locations, &options, &style).unwrap();
    let mut poster = poster.with_setpoints(PERIOD);
    let (mut text, mut setpoints) = (String::new(), Vec::new());
    for one in moves {
        poster.push(&mut text, one, head).unwrap();
        setpoints.append(&mut poster.take_setpoints());
    }
    setpoints.append(&mut poster.finish_motion(&mut text, head).unwrap());
    setpoints
}

const PERIOD: f64 = 0.001;

/// Positions against velocities by the trapezoidal rule, the path against the moves, rates against the limits.
#[test]
fn setpoints_keep_path_and_limits() {
    let mut random = Random(dice::seed());
    for (name, text) in BUILT_IN.into_iter().take(4) {
        let machine = parse(text).unwrap().machine;
        let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 120.0));
        let moves = moves(&kinematics, &mut random);
        let found = setpoints(&kinematics, &moves);
        let ends = [found.first().unwrap(), found.last().unwrap()];
        for (end, wanted) in ends.into_iter().zip([&moves[0], moves.last().unwrap()]) {
            assert!((kinematics.forward(&end.position).tip - wanted.pose.tip).norm() < 1e-6);
            assert!(end.velocity.amax() < 1e-6, "{name}: {}", end.velocity);
        }
        let limits = [
            machine.vector(|axis| axis.vel.max(axis.rapid)),
            machine.vector(|axis| axis.acc),
            machine.vector(|axis| axis.jerk),
        ];
        for one in &found {
            let rates = [one.velocity, one.acceleration, one.jerk];
            for (rate, limit) in rates.iter().zip(&limits) {
                let ratio = rate.component_div(limit).amax();
                assert!(ratio < 1.0 + 1e-4, "{name}: {ratio} at {} s", one.t);
            }
            let pose = kinematics.forward(&one.position);
            let of = |rapid: bool| {
                let pairs = moves.windows(2);
                off_pairs(&pose, pairs.filter(|pair| (pair[1].pace == PostPace::Rapid) == rapid))
            };
            // Rapid moves are straight in the axes: 0.02 rad at a lever of half a metre bulge by 0.025 mm.
            let [cut, rapid] = [of(false), of(true)];
            assert!(
                cut <= 1.0 || rapid <= 1.0 + 0.025 / TOLERANCE.tip,
                "{name}: {cut} at {} s",
                one.t
            );
        }
        for pair in found.windows(2) {
            let [from, to] = [&pair[0], &pair[1]];
            let time = to.t - from.t;
            assert!(time > 0.0 && time < PERIOD + 1e-9, "{name}: {time}");
            // Error of the rule: h³ / 12 times the largest jerk.
            let way = (from.velocity + to.velocity) * (0.5 * time);
            let most = limits[2] * (time.powi(3) / 6.0);
            let error = (to.position - from.position - way).abs();
            let within = error.iter().zip(&most).all(|(error, most)| *error <= most + 1e-9);
            assert!(within, "{name}: {error} at {} s", from.t);
        }
        let time = found.last().unwrap().t;
        assert!((found.len() - 1) as f64 * PERIOD >= time, "{name}: {time}");
    }
}
