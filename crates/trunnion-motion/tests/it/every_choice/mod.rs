//! Every choice of branch, whole turns and retracts, tried one by one.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use crate::chains::{V3, curve, pose};
use std::f64::consts::TAU;
use trunnion::axes::FollowedPath;
use trunnion::inverse::{Inverse, InverseSolutions};
use trunnion::machine::Kinematics;
use trunnion::math::angle::wrap;
use trunnion::math::jet::{Jet, Real};
use trunnion::types::{Interval, Motion, PieceGeometry, ToolPath, ToolPiece, ToolPose};

pub(crate) fn cut(geometry: PieceGeometry) -> ToolPiece {
    ToolPiece { motion: Motion::Cut, geometry }
}

pub(crate) fn link(from: ToolPose, to: ToolPose) -> ToolPiece {
    ToolPiece { motion: Motion::Link, geometry: PieceGeometry::Reorient { from, to } }
}

/// Straight move with a fixed axis.
pub(crate) fn straight(from: V3, to: V3, axis: V3) -> PieceGeometry {
    curve(vec![0.0, 1.0], |u| {
        (
            [0, 1, 2].map(|i| u * (to[i] - from[i]) + from[i]),
            [axis.x, axis.y, axis.z].map(Jet::constant),
        )
    })
}

/// Cuts with fixed axes, joined by links: a case small enough for brute force.
pub(crate) fn fixed_cuts(axes: &[V3]) -> ToolPath {
    let mut pieces: Vec<ToolPiece> = Vec::new();
    let mut last: Option<ToolPose> = None;
    for (index, &axis) in (0..).zip(axes) {
        let from = V3::new(10.0 * f64::from(index), 0.0, 0.0);
        let to = from + V3::new(0.0, 20.0, 0.0);
        if let Some(last) = last {
            pieces.push(link(last, pose(from, axis)));
        }
        pieces.push(cut(straight(from, to, axis)));
        last = Some(pose(to, axis));
    }
    ToolPath { pieces }
}

/// Least rotary travel over all branches and turns, by trying every combination.
pub(crate) fn brute_force(kinematics: &Kinematics, axes: &[V3], weights: [f64; 2]) -> Option<f64> {
    let inverse = Inverse::new(kinematics).unwrap();
    let machine = kinematics.machine();
    let choices: Vec<Vec<[f64; 2]>> = axes
        .iter()
        .map(|&axis| {
            let InverseSolutions::Regular(both) =
                inverse.solutions(&pose(V3::zeros(), axis)).unwrap()
            else {
                panic!()
            };
            let mut all = Vec::new();
            for q in both {
                for [i, j] in (-2..=2).flat_map(|i| (-2..=2).map(move |j| [i, j])) {
                    let value = [q[3] + TAU * f64::from(i), q[4] + TAU * f64::from(j)];
                    let inside = |axis: usize| {
                        let [low, high] = machine.axes[3 + axis].limits.ends();
                        low <= value[axis] && value[axis] <= high
                    };
                    if inside(0) && inside(1) {
                        all.push(value);
                    }
                }
            }
            all
        })
        .collect();
    let mut combinations: Vec<(f64, [f64; 2])> = vec![(0.0, [0.0; 2])];
    for column in choices {
        combinations = combinations
            .iter()
            .flat_map(|(cost, from)| {
                column.iter().map(move |to| {
                    let step =
                        weights[0] * (to[0] - from[0]).abs() + weights[1] * (to[1] - from[1]).abs();
                    (cost + step, *to)
                })
            })
            .collect();
    }
    combinations.iter().map(|(cost, _)| *cost).min_by(f64::total_cmp)
}

/// Both branches through all nodes by continuity, with whole turns, and what they cost.
struct Choices {
    strands: [Vec<[f64; 2]>; 2],
    limits: [Interval; 2],
    weights: [f64; 2],
}

/// Strand and whole turns.
type Choice = (usize, i32, i32);

impl Choices {
    fn new(machine: &Kinematics, nodes: &[ToolPose], weights: [f64; 2]) -> Self {
        let inverse = Inverse::new(machine).unwrap();
        let mut strands: [Vec<[f64; 2]>; 2] = [Vec::new(), Vec::new()];
        for pose in nodes {
            let InverseSolutions::Regular(both) = inverse.solutions(pose).unwrap() else {
                panic!()
            };
            for (strand, q) in strands.iter_mut().zip(both) {
                let near = strand.last().copied().unwrap_or([q[3], q[4]]);
                strand.push([near[0] + wrap(q[3] - near[0]), near[1] + wrap(q[4] - near[1])]);
            }
        }
        let limits = [3, 4].map(|axis| machine.machine().axes[axis].limits);
        Self { strands, limits, weights }
    }

    fn all() -> Vec<Choice> {
        (0..2)
            .flat_map(|strand| (-4..=4).flat_map(move |i| (-1..=1).map(move |j| (strand, i, j))))
            .collect()
    }

    fn at(&self, (strand, i, j): Choice, node: usize) -> [f64; 2] {
        let value = self.strands[strand][node];
        [value[0] + TAU * f64::from(i), value[1] + TAU * f64::from(j)]
    }

    /// Of the interval that starts at a node; `None` where it leaves travel.
    fn run(&self, choice: Choice, node: usize) -> Option<f64> {
        let ends = [self.at(choice, node), self.at(choice, node + 1)];
        let inside = |value: [f64; 2]| (0..2).all(|axis| self.limits[axis].contains(value[axis]));
        ends.into_iter().all(inside).then(|| self.price(ends[0], ends[1]))
    }

    fn price(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        self.weights[0] * (a[0] - b[0]).abs() + self.weights[1] * (a[1] - b[1]).abs()
    }
}

/// Cheapest run through all nodes, by trying every sequence of branch, turns and retracts.
pub(crate) fn brute_force_retracts(
    machine: &Kinematics,
    nodes: &[ToolPose],
    weights: [f64; 2],
    retract: f64,
) -> Option<f64> {
    let of = Choices::new(machine, nodes, weights);
    let choices = Choices::all();
    let mut best = None;
    // Depth first: the state on each interval.
    let mut open: Vec<(usize, Choice, f64)> =
        choices.iter().map(|&choice| (0, choice, of.price([0.0; 2], of.at(choice, 0)))).collect();
    while let Some((node, choice, cost)) = open.pop() {
        let Some(run) = of.run(choice, node).filter(|_| best.is_none_or(|best| cost < best)) else {
            continue;
        };
        let cost = cost + run;
        if node + 2 == nodes.len() {
            best = Some(best.map_or(cost, |best: f64| best.min(cost)));
            continue;
        }
        let to = of.at(choice, node + 1);
        for &next in &choices {
            let more =
                if next == choice { 0.0 } else { retract + of.price(to, of.at(next, node + 1)) };
            open.push((node + 1, next, cost + more));
        }
    }
    best
}

/// The same for many nodes: the cheapest way to every choice, interval by interval.
pub(crate) fn every_interval(
    machine: &Kinematics,
    nodes: &[ToolPose],
    weights: [f64; 2],
    retract: f64,
) -> Option<f64> {
    let of = Choices::new(machine, nodes, weights);
    let choices = Choices::all();
    let mut costs: Vec<f64> =
        choices.iter().map(|&choice| of.price([0.0; 2], of.at(choice, 0))).collect();
    for node in 0..nodes.len() - 1 {
        if node > 0 {
            let before = costs.clone();
            for (to, cost) in choices.iter().zip(&mut costs) {
                for (from, before) in choices.iter().zip(&before).filter(|(from, _)| *from != to) {
                    let moved = of.price(of.at(*from, node), of.at(*to, node));
                    *cost = cost.min(before + retract + moved);
                }
            }
        }
        for (choice, cost) in choices.iter().zip(&mut costs) {
            *cost += of.run(*choice, node).unwrap_or(f64::INFINITY);
        }
    }
    costs.into_iter().filter(|cost| cost.is_finite()).min_by(f64::total_cmp)
}

/// Every pose of the tool path is run, in order; where the tool leaves, it comes back to the place.
pub(crate) fn assert_complete(path: &ToolPath, followed: &FollowedPath) {
    for (source, tool) in path.pieces.iter().enumerate() {
        let PieceGeometry::Curve(curve) = &tool.geometry else { continue };
        let Interval { low: start, high: end } = curve.range();
        let mut at = start;
        let cuts = followed.path.pieces.iter().enumerate().filter(|(index, piece)| {
            piece.source == source
                && !followed.retracts.iter().any(|retract| retract.pieces.contains(index))
        });
        for (_, piece) in cuts {
            let [first, last] = [piece.nodes.first().unwrap().s, piece.nodes.last().unwrap().s];
            assert_eq!(first.to_bits(), at.to_bits(), "nothing is left out, nothing run twice");
            at = last;
        }
        assert_eq!(at.to_bits(), end.to_bits());
    }
}
