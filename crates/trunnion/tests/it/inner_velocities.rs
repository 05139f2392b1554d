//! Velocities of the axes inside blocks with tool-centre-point control, against dense sampling of the machine's inverse.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::audited;
use crate::dice;
use crate::posted;

use audited::check;
use dice::Random;
use trunnion::blocks::{BlockEnd, BlockInterpolation, moved};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords};
use trunnion::nc::write::OutputFormat;
use trunnion::types::{AxisVector, Block, Motion};

/// What is reported may differ from the largest velocity by this share of that of lever and tip, or of both rotaries, together.
const SHARE: f64 = 1e-3;

/// Times at which the inverse is sampled.
const SAMPLES: u32 = 4000;

/// Largest velocities of a block, from parabolas through densely sampled axes; and of the linear axes together.
fn sampled(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    ends: [&Block; 2],
) -> (AxisVector, f64) {
    let inverse = Inverse::new(kinematics).unwrap();
    let [from, to] = ends;
    let pair = [(&from.q, &from.pose), (&to.q, &to.pose)];
    let mut places = vec![from.q];
    for k in 1..=SAMPLES {
        let share = f64::from(k) / f64::from(SAMPLES);
        let pose = moved(kinematics, control, pair.map(|(q, pose)| BlockEnd::new(q, pose)), share)
            .unwrap();
        places.push(inverse.near(&pose, places.last().unwrap()).unwrap());
    }
    let per = f64::from(SAMPLES) / to.duration;
    let (mut fastest, mut together) = (AxisVector::zeros(), 0.0_f64);
    for three in places.windows(3) {
        let ends = [[-1.5, 2.0, -0.5], [0.5, -2.0, 1.5]]
            .map(|[a, b, c]| (a * three[0] + b * three[1] + c * three[2]) * per);
        for velocity in ends {
            fastest = fastest.sup(&velocity.abs());
            together = together.max(velocity.fixed_rows::<3>(0).norm());
        }
    }
    (fastest, together)
}

/// A block from one place to another \[mm, rad\], and what is reported of it, whose rotaries are reported to within `rounding`.
fn compare(
    kinematics: &Kinematics,
    (dialect, language, control): (OutputFormat, read::Dialect, BlockInterpolation),
    [from, to]: [AxisVector; 2],
    (seconds, rounding): (f64, f64),
) {
    let axes = AxisWords::of(kinematics.machine()).unwrap().with_decimals(7, 7);
    let block = |q: AxisVector, duration: f64| Block {
        q,
        pose: kinematics.forward(&q),
        duration,
        motion: Motion::Cut,
    };
    let blocks = [block(from, 0.0), block(to, seconds)];
    let style = posted::style(dialect, axes);
    let text = posted::text(kinematics, &blocks, (&posted::NOTE, &style)).unwrap();
    let audit = check(kinematics, axes, (&text, language)).audit.unwrap();
    let (fastest, together) = sampled(kinematics, control, [&blocks[0], &blocks[1]]);
    let tip = (blocks[1].pose.tip - blocks[0].pose.tip).norm() / seconds;
    for (index, axis) in audit.axes.iter().enumerate() {
        let limit = kinematics.machine().axes[index].vel;
        let reported = axis.velocity.raw * limit;
        // Of the lever, too, which is shorter than a metre.
        let off = 2.0 * rounding / seconds * if index < 3 { 1e3 } else { 1.0 };
        let scale = if index < 3 { together + tip } else { fastest[3] + fastest[4] };
        assert!(
            (reported - fastest[index]).abs() <= SHARE * scale + off + 1e-6 / seconds,
            "{} {dialect:?}: {} at {reported} of {} ({scale}), {from:?} to {to:?}",
            kinematics.machine().name,
            axis.name,
            fastest[index]
        );
    }
}

#[test]
fn the_largest_velocity_inside_a_block_is_reported() {
    let mut random = Random(dice::seed());
    for (_, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        let kinematics =
            Kinematics::new(&machine, &Setup::new(random.point(200.0), [0.0; 3], 150.0));
        for k in 0..12 {
            let turn = 10_f64.powf(-0.25 * f64::from(k));
            let from = machine.vector(|axis| {
                let [low, high] = axis.limits.ends();
                if (high - low).is_finite() { 0.4 * low + 0.6 * high } else { 0.3 }
            });
            let by = |axis: usize| if axis < 3 { 20.0 } else { 0.3 * turn };
            let to = from + AxisVector::from_fn(|axis, _| by(axis) * random.within(-1.0, 1.0));
            let way =
                (OutputFormat::LinuxCnc, read::Dialect::LinuxCnc, BlockInterpolation::RotaryLinear);
            compare(&kinematics, way, [from, to], (random.within(0.1, 10.0), 0.0));
        }
    }
}

#[test]
fn so_it_is_between_vectors() {
    let mut random = Random(dice::seed());
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "bc-trunnion").unwrap();
    let machine = parse(text).unwrap().machine;
    let kinematics = Kinematics::new(&machine, &Setup::new(random.point(200.0), [0.0; 3], 150.0));
    // A control that receives vectors starts with the rotaries nearest to home.
    let home = machine.home();
    for (k, near) in (0..12).zip([0.02, 0.1, 0.7].into_iter().cycle()) {
        let turn = 10_f64.powf(-0.25 * f64::from(k));
        // C turns fast where the tool is nearly along it.
        let from = home + AxisVector::from([10.0, 20.0, 30.0, random.within(-0.5, 0.5), near]);
        let by = |axis: usize| if axis < 3 { 20.0 } else { 0.3 * turn };
        let to = from + AxisVector::from_fn(|axis, _| by(axis) * random.within(0.0, 1.0));
        let way =
            (OutputFormat::FanucVector, read::Dialect::Fanuc, BlockInterpolation::GreatCircle);
        // Half of the last of seven decimals, three times; so near to the axis it turns C by more.
        let rounding = 0.5e-7 * 3_f64.sqrt() / f64::sin(near);
        compare(&kinematics, way, [from, to], (random.within(0.1, 10.0), rounding));
    }
}
