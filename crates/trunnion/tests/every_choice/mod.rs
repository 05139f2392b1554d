//! Every choice of branch, whole turns and retracts, tried one by one.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use crate::chains::{V3, curve, pose};
use std::f64::consts::TAU;
use trunnion::axes::Followed;
use trunnion::inverse::{Inverse, Solutions};
use trunnion::machine::Kinematics;
use trunnion::math::angle::wrap;
use trunnion::math::jet::{Jet, Real};
use trunnion::types::{Geometry, Motion, ToolPath, ToolPiece, ToolPose};

pub(crate) fn cut(geometry: Geometry) -> ToolPiece {
    ToolPiece { motion: Motion::Cut, geometry }
}

pub(crate) fn link(from: ToolPose, to: ToolPose) -> ToolPiece {
    ToolPiece { motion: Motion::Link, geometry: Geometry::Reorient { from, to } }
}

/// Straight move with a fixed axis.
pub(crate) fn straight(from: V3, to: V3, axis: V3) -> Geometry {
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
            let Solutions::Regular(both) = inverse.solutions(&pose(V3::zeros(), axis)).unwrap()
            else {
                panic!()
            };
            let mut all = Vec::new();
            for q in both {
                for [i, j] in (-2..=2).flat_map(|i| (-2..=2).map(move |j| [i, j])) {
                    let value = [q[3] + TAU * f64::from(i), q[4] + TAU * f64::from(j)];
                    let inside = |axis: usize| {
                        let [low, high] = machine.axes[3 + axis].limits;
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

/// Cheapest run through all nodes, by trying every sequence of branch, turns and retracts.
pub(crate) fn brute_force_retracts(
    machine: &Kinematics,
    nodes: &[ToolPose],
    weights: [f64; 2],
    retract: f64,
) -> Option<f64> {
    let inverse = Inverse::new(machine).unwrap();
    let inside = |value: [f64; 2]| {
        (0..2).all(|axis| {
            let [low, high] = machine.machine().axes[3 + axis].limits;
            low <= value[axis] && value[axis] <= high
        })
    };
    // Both branches by continuity.
    let mut strands: [Vec<[f64; 2]>; 2] = [Vec::new(), Vec::new()];
    for pose in nodes {
        let Solutions::Regular(both) = inverse.solutions(pose).unwrap() else { panic!() };
        for (strand, q) in strands.iter_mut().zip(both) {
            let near = strand.last().copied().unwrap_or([q[3], q[4]]);
            strand.push([near[0] + wrap(q[3] - near[0]), near[1] + wrap(q[4] - near[1])]);
        }
    }
    let at = |(strand, i, j): (usize, i32, i32), node: usize| {
        let value = strands[strand][node];
        [value[0] + TAU * f64::from(i), value[1] + TAU * f64::from(j)]
    };
    let price = |a: [f64; 2], b: [f64; 2]| {
        weights[0] * (a[0] - b[0]).abs() + weights[1] * (a[1] - b[1]).abs()
    };
    let choices: Vec<(usize, i32, i32)> = (0..2)
        .flat_map(|strand| (-3..=3).flat_map(move |i| (-1..=1).map(move |j| (strand, i, j))))
        .collect();
    let mut best = None;
    // Depth first: the state on each interval.
    let mut open: Vec<(usize, (usize, i32, i32), f64)> =
        choices.iter().map(|&choice| (0, choice, price([0.0; 2], at(choice, 0)))).collect();
    while let Some((node, choice, cost)) = open.pop() {
        let [from, to] = [at(choice, node), at(choice, node + 1)];
        if !inside(from) || !inside(to) || best.is_some_and(|best| cost >= best) {
            continue;
        }
        let cost = cost + price(from, to);
        if node + 2 == nodes.len() {
            best = Some(best.map_or(cost, |best: f64| best.min(cost)));
            continue;
        }
        for &next in &choices {
            let more = if next == choice { 0.0 } else { retract + price(to, at(next, node + 1)) };
            open.push((node + 1, next, cost + more));
        }
    }
    best
}

/// Every pose of the tool path is run, in order; where the tool leaves, it comes back to the place.
pub(crate) fn assert_complete(path: &ToolPath, followed: &Followed) {
    for (source, tool) in path.pieces.iter().enumerate() {
        let Geometry::Curve(curve) = &tool.geometry else { continue };
        let [start, end] = curve.range();
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
