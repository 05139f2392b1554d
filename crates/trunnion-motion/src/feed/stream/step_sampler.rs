//! Setpoints of a stream, step by step: neither path nor schedule is kept.

use super::step::StreamStep;
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, PathState, Setpoint};

/// Sampler of the steps of a stream at the servo period, from 0 on.
///
/// The setpoints are those of [`sample`](crate::setpoint::sample()) on the whole path.
///
/// # Example
///
/// One axis over 1 mm, with at most 2 mm/s, sampled every 0.25 s:
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{AnyStream, Limits, StepSampler, StreamKind, StreamOptions};
/// use trunnion_motion::types::{AxisNode, Motion};
///
/// let node = |s: f64| {
///     let q = [Vector1::new(s), Vector1::new(1.0), Vector1::zeros(), Vector1::zeros()];
///     AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
/// };
/// let ends = [node(0.0), node(1.0)];
/// let limits = Limits::symmetric(Vector1::new(2.0), Vector1::new(1e6), Vector1::new(1e9));
/// let mut stream = AnyStream::new(StreamKind::Optimal, limits, StreamOptions::fastest(10, 1.0))?;
/// stream.begin(Motion::Cut);
/// for node in ends {
///     stream.push(node)?;
/// }
/// let mut sampler = StepSampler::new(0.25);
/// let mut setpoints = Vec::new();
/// while let Some(step) = stream.next() {
///     sampler.take(&step, &ends, &mut setpoints);
/// }
/// sampler.finish(&mut setpoints);
/// // The last one is the end of the path, at rest.
/// let last = &setpoints[setpoints.len() - 1];
/// assert!((last.position.x - 1.0).abs() < 1e-12 && last.velocity.x.abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct StepSampler<const N: usize = AXES> {
    period: f64,
    /// Index of the next setpoint.
    next: u64,
    /// Time at which the present stream began \[s\].
    begin: f64,
    /// State at the end of the last step.
    end: Option<Setpoint<N>>,
}

impl<const N: usize> StepSampler<N> {
    /// Starts at time 0; the period is that of the servo \[s\]. One that is not positive gives only the end.
    pub fn new(period: f64) -> Self {
        Self { period, next: 0, begin: 0.0, end: None }
    }

    /// Appends the setpoints of a step; `ends` are the nodes of the interval in which it lies.
    pub fn take(&mut self, step: &StreamStep, ends: &[AxisNode<N>; 2], out: &mut Vec<Setpoint<N>>) {
        let [from, to] = ends;
        let jet = |node: &AxisNode<N>| [node.q[0], node.q[1], node.q[2]];
        let path = Quintic::new(to.s - from.s, jet(from), jet(to));
        let start = self.begin + step.t;
        let end = start + step.duration;
        let at = |t: f64, state: &PathState| Setpoint::on_path(t, path.at(state.s - from.s), state);
        // A time at which two steps meet belongs to the later one.
        loop {
            // A product instead of a sum: the times do not drift with the number of setpoints.
            let t = self.next as f64 * self.period;
            if t >= end || self.period <= 0.0 {
                break;
            }
            out.push(at(t, &step.at(t - start)));
            self.next += 1;
        }
        let state = step.at(step.duration);
        // The last node is reached exactly: sampling would round it.
        let q = if step.s.high >= to.s { to.q } else { path.at(state.s - from.s) };
        let s = step.s.high;
        let state = PathState { s, speed: step.speed.end, ..state };
        self.end = Some(Setpoint::on_path(end, q, &state));
    }

    /// Goes on with another stream, which begins where and when the present one ends.
    pub fn restart(&mut self) {
        self.begin = self.end.as_ref().map_or(self.begin, |end| end.t);
    }

    /// Appends the setpoint at the end, where the axes are exactly on the last node.
    pub fn finish(self, out: &mut Vec<Setpoint<N>>) {
        out.extend(self.end);
    }
}
