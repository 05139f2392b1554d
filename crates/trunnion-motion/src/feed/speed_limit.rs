//! Speed limits of single nodes.

use super::error::FeedError;
use crate::types::{AxisNode, AxisPath};

/// Raises the feed rates of a path so that `ds/dt` stays below `most` of piece and node. Plan the
/// path with the feed `feed` \[mm/s\] afterwards. `most` is `None` for nodes without a limit of
/// their own; between nodes the limit is harmonic.
///
/// # Errors
///
/// [`FeedError::BadSpeedLimit`] for one that is not positive.
pub fn limit_speeds<const N: usize>(
    mut path: AxisPath<N>,
    feed: f64,
    most: impl Fn(usize, &AxisNode<N>) -> Option<f64>,
) -> Result<AxisPath<N>, FeedError> {
    for (index, piece) in path.pieces.iter_mut().enumerate() {
        for (place, node) in piece.nodes.iter_mut().enumerate() {
            let Some(value) = most(index, node) else { continue };
            if value.is_nan() || value <= 0.0 {
                return Err(FeedError::BadSpeedLimit { piece: index, node: place, value });
            }
            // ds/dt <= feed / feed_rate, so this rate is the one at which the feed gives the limit.
            node.feed_rate = node.feed_rate.max(feed / value);
        }
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{BindingLimit, FeedOptions, Limits, jerk, optimal};
    use crate::setpoint::sample;
    use crate::types::{AxisPiece, Motion, Silent};
    use nalgebra::Vector2;

    const FREE: FeedOptions = FeedOptions::fastest();

    fn limits(acceleration: f64) -> Limits<2> {
        Limits {
            velocity: Vector2::repeat(1e4),
            rapid: Vector2::repeat(1e4),
            acceleration: Vector2::repeat(acceleration),
            jerk: Some(Vector2::repeat(1e6)),
            minus: None,
        }
    }

    /// Half a turn of radius 10.
    fn circle() -> AxisPath<2> {
        let r = 10.0;
        let nodes = (0..=100).map(|k| {
            let s = f64::from(k) / 100.0 * r * std::f64::consts::PI;
            let (sin, cos) = (s / r).sin_cos();
            let q = [
                Vector2::new(cos, sin) * r,
                Vector2::new(-sin, cos),
                Vector2::new(-cos, -sin) / r,
                Vector2::new(sin, -cos) / (r * r),
            ];
            AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
        });
        let nodes = nodes.collect();
        AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
    }

    /// 1 um at 10 ms: 80 mm/s², on a circle of 10 mm 28.3 mm/s.
    #[test]
    fn chords_between_setpoints_stay_within_their_error() {
        let (error, period) = (1e-3, 0.01);
        let tight = limits(5000.0).with_chord_error(&Vector2::repeat(error), period).unwrap();
        assert!((tight.acceleration[0] - 80.0).abs() < 1e-12);
        assert_eq!(tight.lowered_from(&limits(5000.0)), [true; 2]);
        let plans = [optimal, jerk].map(|plan| plan(&circle(), &tight, &FREE, &Silent).unwrap());
        for mut plan in plans {
            plan.name_chords([true, false]);
            assert!(plan.binding[0].contains(&BindingLimit::Chord(0)));
            assert!(plan.binding[0].contains(&BindingLimit::Acceleration(1)));
            let path = circle();
            let fine = sample(&path, &plan.schedule, 0.1 * period).unwrap();
            let points: Vec<_> = fine.map(|point| point.position).collect();
            let mut worst = 0.0_f64;
            for chord in points.windows(11) {
                for (step, point) in chord.iter().enumerate() {
                    let line = chord[0].lerp(&chord[10], 0.1 * step as f64);
                    worst = worst.max((point - line).amax());
                }
            }
            assert!(worst <= error * (1.0 + 1e-6) && worst > 0.9 * error, "{worst}");
        }
        let bad = limits(1.0).with_chord_error(&Vector2::new(1.0, 0.0), period).unwrap_err();
        assert!(bad.to_string().contains("axis 1"), "{bad}");
    }

    #[test]
    fn speeds_stay_below_their_own_limits() {
        let most = |s: f64| 20.0 + s;
        let path = limit_speeds(circle(), 40.0, |_, node| Some(most(node.s))).unwrap();
        let options = FREE.with_feed(40.0);
        for plan in [optimal, jerk] {
            let plan = plan(&path, &limits(5000.0), &options, &Silent).unwrap();
            let piece = &plan.schedule.pieces[0];
            let shares = piece.s.iter().zip(&piece.speed).map(|(s, v)| v / most(*s).min(40.0));
            let worst = shares.fold(0.0, f64::max);
            assert!(worst <= 1.0 + 1e-9 && worst > 0.99, "{worst}");
        }
        let bad = limit_speeds(circle(), 40.0, |_, _| Some(0.0)).unwrap_err();
        assert!(bad.to_string().contains("node 0"), "{bad}");
    }
}
