//! Programs whose F is the speed of the tip, audited from their text: what posting says of the axes is what the blocks ask
//! of them.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::audited;
use crate::dice;
use crate::posted;

use audited::check;
use dice::Random;
use nalgebra::Vector3;
use trunnion::blocks::BlockInterpolation;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Axis, Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords};
use trunnion::nc::write::{OutputFormat, Style, Template};
use trunnion::post::{
    PostError, PostFilter, PostMove, PostOptions, PostPace, PostReport, PostSource, Poster,
    ProgramHead, control_of,
};
use trunnion::types::{AxisVector, PoseTolerance};
use trunnion::verify::{self, Audit, LimitRatio};

/// Dialects whose F is a speed of the tip, by what reads them. (Of tool vectors the rotaries are reckoned back, from words
/// that no axis has.)
const TIP_FEEDS: [(OutputFormat, read::Dialect); 4] = [
    (OutputFormat::Fanuc, read::Dialect::Fanuc),
    (OutputFormat::Haas, read::Dialect::Haas),
    (OutputFormat::SiemensAxes, read::Dialect::Siemens),
    (OutputFormat::HeidenhainAxes, read::Dialect::Heidenhain),
];

const FEED: f64 = 50.0;

/// A cut whose axes speed up and slow down all the time: in even steps, or from a hundredth of a millimetre to some
/// millimetres.
fn moves(kinematics: &Kinematics, random: &mut Random, even: bool) -> Vec<PostMove> {
    // Away from the middle, where the tool often stands along an axis.
    let inside = |axis: &Axis| {
        let [low, high] = axis.limits.ends();
        let margin = 0.02 * (high - low);
        if margin.is_finite() { axis.limits.widened(-margin).ends() } else { axis.limits.ends() }
    };
    let mut q = kinematics.machine().vector(|axis| {
        let [low, high] = axis.limits.ends();
        if (high - low).is_finite() { 0.3 * low + 0.7 * high } else { 0.3 }
    });
    let wave = AxisVector::from_fn(|_, _| random.within(0.2, 1.0));
    let turn =
        if even { random.within(0.01, 0.03) } else { 10_f64.powf(random.within(-3.0, -1.0)) };
    let count = if even { 240 } else { 120 };
    (0..count)
        .map(|k| {
            let step = if even { 0.5 } else { 10_f64.powf(random.within(-2.0, 0.5)) };
            let size = |axis: usize| if axis < 3 { step } else { turn * step };
            let t = 0.1 * f64::from(k);
            q += AxisVector::from_fn(|axis, _| size(axis) * (t * (1.0 + wave[axis])).sin());
            for (value, axis) in q.iter_mut().zip(&kinematics.machine().axes) {
                let [low, high] = inside(axis);
                *value = value.clamp(low, high);
            }
            let pace = if k == 0 { PostPace::Rapid } else { PostPace::Feed(FEED) };
            let pose = kinematics.forward(&q);
            PostMove { line: k + 1, pose, q: None, pace, way: BlockInterpolation::GreatCircle }
        })
        .collect()
}

/// `None` where the rotaries that posting chooses do not get there.
fn post(
    kinematics: &Kinematics,
    style: &Style,
    (filter, moves): (PostFilter, &[PostMove]),
) -> Option<(String, PostReport)> {
    let options = PostOptions {
        window: 512,
        filter,
        ..PostOptions::within(control_of(kinematics, style.dialect), PoseTolerance::new(0.01, 1e-3))
    };
    let template = Template::of(style.dialect).unwrap();
    let mut poster = Poster::new(kinematics, PostSource::Locations, &options, style).unwrap();
    let mut text = String::new();
    let head = ProgramHead { note: &posted::NOTE, template: &template };
    let done = moves.iter().try_for_each(|one| poster.push(&mut text, one, head));
    match done.and_then(|()| poster.finish(&mut text, head)) {
        Err(PostError::Reach { .. }) => None,
        done => Some((text, done.unwrap())),
    }
}

/// Largest ratio of all axes.
fn worst(audit: &Audit, of: impl Fn(&verify::AxisAudit) -> LimitRatio) -> f64 {
    audit.axes.iter().map(|axis| of(axis).worst).fold(0.0, f64::max)
}

#[test]
fn what_is_said_of_the_axes_is_what_the_program_asks_of_them() {
    let mut random = Random(dice::seed());
    let mut limited = 0;
    for (index, (name, text)) in BUILT_IN.into_iter().enumerate() {
        let machine = parse(text).unwrap().machine;
        let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 120.0));
        let axes = AxisWords::of(&machine).unwrap();
        for even in [true, false] {
            // What rounding the words may have added is taken off: the finer they are, the more F has to say.
            let axes = if even { axes.with_decimals(6, 6) } else { axes };
            let moves = moves(&kinematics, &mut random, even);
            let (dialect, language) = TIP_FEEDS[(index + usize::from(even)) % TIP_FEEDS.len()];
            let style = Style::of(&kinematics, dialect, axes);
            assert!(!style.inverse_time, "{name} {dialect:?}");
            for filter in [PostFilter::None, PostFilter::Smooth, PostFilter::Reduce] {
                let posted = post(&kinematics, &style, (filter, &moves));
                let Some((text, report)) = posted else { continue };
                let audit = check(&kinematics, axes, (&text, language)).audit.unwrap();
                let read =
                    [worst(&audit, |axis| axis.velocity), worst(&audit, |axis| axis.acceleration)];
                let loads = report.loads.output;
                for (read, said) in read.into_iter().zip([loads.velocity, loads.acceleration]) {
                    let case = format!("{name} {dialect:?} {filter:?} {even}: {read} of {said}");
                    assert!(said <= 1.0 + 1e-6, "{case}");
                    assert!(read <= said * (1.0 + 1e-3), "{case}");
                }
                limited += usize::from(loads.acceleration > 0.95);
            }
        }
    }
    assert!(limited > 30, "{limited}");
}
