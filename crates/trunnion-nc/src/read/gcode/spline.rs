//! Splines of `LinuxCNC` as chords: `G5`, `G5.1`, `G5.2` with `G5.3`.

use super::block::GcodeBlock;
use super::modal::BlockActions;
use super::reader::GcodeReader;
use super::spline_points::{SplineState, WeightedPoint};
use super::words::natural;
use crate::math;
use crate::read::control::{ControlState, DistanceMode, FeedMode, MoveTarget};
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Pace, Way};

/// Largest distance between a spline and its chords \[mm\]: far below what the control's own arcs are off.
const CHORD: f64 = 5e-4;

/// Halvings of a span; its chords are then shorter than any tolerance.
const DEEPEST: u32 = 12;

/// Control points of a spline; more are no program for a machine.
const MOST_POINTS: usize = 10_000;

/// Highest order of a spline.
const HIGHEST_ORDER: usize = 20;

impl GcodeReader {
    /// Runs a line of `G5`, `G5.1` or `G5.2`.
    pub(super) fn spline(
        &mut self,
        state: &mut ReaderState,
        block: &mut GcodeBlock,
        target: MoveTarget,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        let (axes, _) = self.plane();
        let slots = axes.map(|axis| state.control.xyz[axis]);
        // The interpreter moves nothing but the plane, whatever the line says.
        if let Some(slot) = (0..target.words.len())
            .find(|slot| target.get(*slot).is_some() && !slots[..2].contains(slot))
        {
            let letter = state.control.letter(slot).unwrap_or(' ');
            let message = format!("{letter} beside a spline, which LinuxCNC does not move");
            return Err(ReadRemark::new(target.at, message, "move it on a line of its own"));
        }
        let [u, v, _] = slots;
        let places = state.control.reading(u).zip(state.control.reading(v));
        let Some((start_u, start_v)) = places else {
            let message = "a spline from a position that the program does not state";
            let help = "program both axes of its plane absolutely before it";
            return Err(ReadRemark::new(target.at, message, help));
        };
        let start = [start_u, start_v];
        let scale = state.control.scale();
        let mut pair = |letters: [char; 2]| {
            let [first, second] = letters.map(|letter| block.take(letter));
            first.zip(second).map(|(first, second)| [scale * first.value, scale * second.value])
        };
        let end = ends(&state.control, &target, [u, v], start);
        let points = match self.modal.spline_code {
            51 => {
                let Some(to) = pair(['I', 'J']) else {
                    return Err(missing(&target, "G5.1", "I and J"));
                };
                let middle = [start[0] + to[0], start[1] + to[1]];
                [start, middle, end].map(plain).to_vec()
            }
            50 => {
                let first = pair(['I', 'J']).or(self.modal.spline.continues);
                let last = pair(['P', 'Q']);
                let (Some(first), Some(last)) = (first, last) else {
                    return Err(missing(&target, "G5", "I and J, P and Q"));
                };
                self.modal.spline.continues = Some([-last[0], -last[1]]);
                let before = [start[0] + first[0], start[1] + first[1]];
                let behind = [end[0] + last[0], end[1] + last[1]];
                [start, before, behind, end].map(plain).to_vec()
            }
            _ => return self.control_point(block, &target, [u, v], [start, end]),
        };
        let spline = NurbsCurve::new(points.len(), points);
        self.run_spline(state, &spline, &target, now)
    }

    /// Keeps a control point of `G5.2`.
    fn control_point(
        &mut self,
        block: &mut GcodeBlock,
        target: &MoveTarget,
        slots: [usize; 2],
        [start, end]: [[f64; 2]; 2],
    ) -> Result<(), ReadRemark> {
        let weight = block.take('P').map(|word| word.value);
        let order = block.take('L').map(|word| natural(word, 'L')).transpose()?;
        let given = slots.map(|slot| target.get(slot).is_some());
        let spline = &mut self.modal.spline;
        if given[0] != given[1] || spline.points.len() >= MOST_POINTS {
            return Err(missing(target, "G5.2", "both axes of the plane"));
        }
        if spline.points.is_empty() {
            // The spline begins where the tool stands; P alone is the weight of that point.
            let own = weight.filter(|_| !given[0]);
            spline.points.push(WeightedPoint { point: start, weight: own.unwrap_or(1.0) });
            spline.order = 3;
        }
        if let Some(order) = order.and_then(|order| usize::try_from(order).ok()) {
            if order > HIGHEST_ORDER {
                let message = format!("a spline of order {order}");
                return Err(ReadRemark::new(target.at, message, "L is 3 or a little more"));
            }
            spline.order = order.max(3);
        }
        if given[0] {
            let Some(weight) = weight.filter(|weight| *weight > 0.0) else {
                return Err(missing(target, "G5.2", "a weight P above 0"));
            };
            spline.points.push(WeightedPoint { point: end, weight });
        }
        Ok(())
    }

    /// Runs `G5.3`: the spline through the control points so far.
    pub(super) fn end_spline(
        &mut self,
        state: &mut ReaderState,
        now: &BlockActions,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let SplineState { points, order, .. } = std::mem::take(&mut self.modal.spline);
        self.modal.motion = None;
        if points.len() < order || points.is_empty() {
            let message = format!(
                "G5.3 behind {} control points, of which order {order} needs more",
                points.len()
            );
            return Err(ReadRemark::new(at, message, "write more lines of G5.2 before it"));
        }
        let target = MoveTarget::new(at, 0);
        self.run_spline(state, &NurbsCurve::new(order, points), &target, now)
    }

    /// Moves along a spline by chords.
    fn run_spline(
        &mut self,
        state: &mut ReaderState,
        spline: &NurbsCurve,
        target: &MoveTarget,
        now: &BlockActions,
    ) -> Result<(), ReadRemark> {
        let (axes, _) = self.plane();
        let [u, v, _] = axes.map(|axis| state.control.xyz[axis]);
        let nodes = spline.nodes();
        let length =
            |pair: &[[f64; 2]]| math::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let whole: f64 = nodes.windows(2).map(length).sum();
        let line = state.log.line;
        for pair in nodes.windows(2) {
            if !self.may_repeat(state, "") {
                return Ok(());
            }
            let mut step = MoveTarget::new(target.at, target.column);
            step.set(u, pair[1][0], DistanceMode::Absolute);
            step.set(v, pair[1][1], DistanceMode::Absolute);
            let mut pace = state.control.pace(&step, now.feed)?;
            // The time of the block is that of the whole spline.
            if let (FeedMode::Inverse, Pace::Inverse { seconds }) =
                (state.control.feed_mode, &mut pace)
            {
                *seconds *= if whole > 0.0 { length(pair) / whole } else { 1.0 };
            }
            state.control.go(line, step, pace, Way::Line)?;
        }
        Ok(())
    }
}

fn plain(point: [f64; 2]) -> WeightedPoint {
    WeightedPoint { point, weight: 1.0 }
}

fn missing(target: &MoveTarget, code: &str, words: &str) -> ReadRemark {
    ReadRemark::new(target.at, format!("{code} without {words}"), "write both of each pair")
}

/// Returns the end of a line in the plane.
fn ends(
    control: &ControlState,
    target: &MoveTarget,
    slots: [usize; 2],
    start: [f64; 2],
) -> [f64; 2] {
    let mut end = start;
    for (end, slot) in end.iter_mut().zip(slots) {
        match target.get(slot) {
            Some(word) if target.is_incremental(slot) => {
                *end = control.reading(slot).unwrap_or(*end) + word;
            }
            Some(word) => *end = word,
            None => {}
        }
    }
    end
}

/// A rational B-spline that begins and ends in its outer control points, with even knots between.
struct NurbsCurve {
    order: usize,
    points: Vec<WeightedPoint>,
}

impl NurbsCurve {
    fn new(order: usize, points: Vec<WeightedPoint>) -> Self {
        Self { order, points }
    }

    /// Returns knot number `at`: `order` zeros, then 1, 2 and so on, then `order` times the last.
    fn knot(&self, at: usize) -> f64 {
        let inner = at.saturating_sub(self.order - 1).min(self.spans());
        f64::from(u32::try_from(inner).unwrap_or(u32::MAX))
    }

    /// Returns the number of spans between different knots.
    fn spans(&self) -> usize {
        self.points.len() + 1 - self.order
    }

    /// Returns a point of the curve by de Boor's algorithm; `t` counts within a span from 0 to 1.
    fn at(&self, span: usize, t: f64) -> [f64; 2] {
        let degree = self.order - 1;
        let knot = self.knot(span + degree) + t;
        let of = |at: usize| {
            let WeightedPoint { point: [u, v], weight } =
                self.points.get(span + at).copied().unwrap_or(plain([0.0; 2]));
            [u * weight, v * weight, weight]
        };
        // Points in homogeneous coordinates, blended once per degree.
        let mut blend: Vec<[f64; 3]> = (0..=degree).map(of).collect();
        for level in 1..=degree {
            for at in (level..=degree).rev() {
                let [low, high] = [self.knot(span + at), self.knot(span + at + degree + 1 - level)];
                let share = if high > low { (knot - low) / (high - low) } else { 0.0 };
                let before = blend[at - 1];
                for (value, before) in blend[at].iter_mut().zip(before) {
                    *value = (1.0 - share) * before + share * *value;
                }
            }
        }
        let [u, v, weight] = blend[degree];
        [u / weight, v / weight]
    }

    /// Returns points whose chords stay near the curve.
    fn nodes(&self) -> Vec<[f64; 2]> {
        let mut nodes = vec![self.at(0, 0.0)];
        for span in 0..self.spans() {
            // A curve may cross its chord in the middle: halves are always looked at.
            for half in [[0.0, 0.5], [0.5, 1.0]] {
                self.halve(span, half, &mut nodes, 0);
            }
        }
        nodes
    }

    /// Appends the nodes behind the first of a range.
    fn halve(&self, span: usize, [from, to]: [f64; 2], nodes: &mut Vec<[f64; 2]>, depth: u32) {
        let ends = [from, to].map(|t| self.at(span, t));
        let off = |share: f64| distance_to_chord(self.at(span, from + share * (to - from)), ends);
        let straight = [0.25, 0.5, 0.75].into_iter().all(|share| off(share) <= CHORD);
        if straight || depth >= DEEPEST {
            nodes.push(ends[1]);
            return;
        }
        let middle = 0.5 * (from + to);
        self.halve(span, [from, middle], nodes, depth + 1);
        self.halve(span, [middle, to], nodes, depth + 1);
    }
}

/// Returns how far a point is from the segment between two others.
fn distance_to_chord(point: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let rest = [point[0] - from[0], point[1] - from[1]];
    let length2 = chord[0] * chord[0] + chord[1] * chord[1];
    let along = if length2 > 0.0 {
        ((rest[0] * chord[0] + rest[1] * chord[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    math::hypot(rest[0] - along * chord[0], rest[1] - along * chord[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_parabola_is_a_quarter_circle() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let point = |u: f64, v: f64, weight: f64| WeightedPoint { point: [u, v], weight };
        let arc = NurbsCurve::new(
            3,
            vec![point(10.0, 0.0, 1.0), point(10.0, 10.0, half), point(0.0, 10.0, 1.0)],
        );
        let nodes = arc.nodes();
        assert!(nodes.len() > 10);
        for [u, v] in nodes {
            assert!((u.hypot(v) - 10.0).abs() < 1e-12);
        }
    }

    #[test]
    fn even_knots_make_known_points() {
        // A uniform quadratic B-spline passes through the middle of inner legs of its control polygon.
        let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 2.0], [4.0, 0.0]].map(plain).to_vec();
        let curve = NurbsCurve::new(3, points);
        assert_eq!(curve.spans(), 2);
        let [u, v] = curve.at(1, 0.0);
        assert!((u - 2.0).abs() < 1e-12 && (v - 2.0).abs() < 1e-12);
        let [u, v] = curve.at(1, 1.0);
        assert!((u - 4.0).abs() < 1e-12 && v.abs() < 1e-12);
    }
}
