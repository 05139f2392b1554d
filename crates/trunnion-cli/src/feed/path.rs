//! A table of axis positions and derivatives as an axis path.

use super::{Args, Method};
use crate::outcome::Failure;
use crate::table::{Ends, Faults, Rows};
use nalgebra::SVector;
use std::path::PathBuf;
use trunnion::feed::{FeedError, GivenSpeed, Limits, MinusLimits};
use trunnion::files::limits::{AxisLimits, LimitsFile};
use trunnion::files::table::Header;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Fault, Motion};

/// A limit that never binds: its square is still a number.
const UNLIMITED: f64 = 1e150;

/// The table and what its columns are.
pub(super) struct Table {
    name: PathBuf,
    rows: Rows,
    /// Axes of the table, in order.
    axes: Vec<String>,
    /// Whether NAME3 stands in the table.
    has_third: Vec<bool>,
    has_feed: bool,
    /// Whether the path parameter itself is limited, as an axis more.
    path_axis: bool,
    path_feed: Option<f64>,
}

/// A place at which the axes rest although the path goes on.
pub(super) struct Rest {
    pub(super) s: f64,
    pub(super) line: u32,
    /// The derivative that jumps most, and by how much; nothing where none does.
    pub(super) jump: Option<(String, f64)>,
}

impl Table {
    /// Reads the table. Its axes are those of the limits file; others have no limits, which is a fault.
    pub(super) fn read(ends: &Ends, limits: &LimitsFile, method: Method) -> Result<Self, Failure> {
        let speed = method == Method::Given;
        let rows = ends.read(|header| columns(header, limits, speed))?;
        let has = |name: &str| rows.names.iter().any(|column| column == name);
        let axes = in_order(&rows.names, limits);
        let path_axis = limits.path.acc.is_some() || limits.path.jerk.is_some();
        Ok(Self {
            name: ends.name().to_owned(),
            has_third: axes.iter().map(|axis| has(&format!("{axis}3"))).collect(),
            has_feed: has("feed"),
            path_feed: limits.path.feed,
            rows,
            axes,
            path_axis,
        })
    }

    /// Axes to plan for.
    pub(super) fn axes(&self) -> usize {
        self.axes.len() + usize::from(self.path_axis)
    }

    /// Name of an axis in messages.
    pub(super) fn axis(&self, index: usize) -> &str {
        self.axes.get(index).map_or("the path", String::as_str)
    }

    /// Names of the axes of the table.
    pub(super) fn names(&self) -> &[String] {
        &self.axes
    }

    /// What feed rates are measured in: with a column `feed` they are shares of it.
    pub(super) fn feed(&self) -> Option<f64> {
        if self.has_feed { Some(1.0) } else { self.path_feed }
    }

    /// Limits of the axes to plan for, and which of their accelerations chord errors lower; `period` is that of
    /// the setpoints.
    pub(super) fn limits<const N: usize>(
        &self,
        file: &LimitsFile,
        period: f64,
    ) -> Result<(Limits<N>, [bool; N]), FeedError> {
        let path = AxisLimits {
            vel: UNLIMITED,
            acc: file.path.acc.unwrap_or(UNLIMITED),
            jerk: Some(file.path.jerk.unwrap_or(UNLIMITED)),
            ..AxisLimits::default()
        };
        // Axes that stand still never bind.
        let still = AxisLimits { vel: 1.0, acc: 1.0, jerk: Some(1.0), ..AxisLimits::default() };
        let of = |index: usize| match self.axes.get(index) {
            Some(name) => file.axes.get(name).copied().unwrap_or(still),
            None if index == self.axes.len() && self.path_axis => path,
            None => still,
        };
        let has_jerk = (0..N).all(|index| of(index).jerk.is_some());
        let vector = |get: &dyn Fn(AxisLimits) -> f64| SVector::from_fn(|row, _| get(of(row)));
        let differs = |axis: AxisLimits| axis.vel_minus.or(axis.acc_minus).is_some();
        let velocity = vector(&|axis| axis.vel_minus.unwrap_or(axis.vel));
        let acceleration = vector(&|axis| axis.acc_minus.unwrap_or(axis.acc));
        let minus = MinusLimits { velocity, rapid: velocity, acceleration };
        let limits = Limits {
            velocity: vector(&|axis| axis.vel),
            rapid: vector(&|axis| axis.vel),
            acceleration: vector(&|axis| axis.acc),
            jerk: has_jerk.then(|| vector(&|axis| axis.jerk.unwrap_or(UNLIMITED))),
            minus: (0..N).any(|index| differs(of(index))).then_some(minus),
        };
        let chords = vector(&|axis| axis.chord.unwrap_or(f64::INFINITY));
        let limited = limits.with_chord_error(&chords, period)?;
        Ok((limited, limited.lowered_from(&limits)))
    }

    /// The path, or everything wrong with it.
    pub(super) fn path<const N: usize>(
        &self,
        limits: &Limits<N>,
        args: &Args,
    ) -> Result<AxisPath<N>, Failure> {
        let mut faults = Faults::default();
        if self.rows.lines.len() < 2 {
            faults.add(Fault::whole("a path needs at least two rows"));
        }
        let path = AxisPath { pieces: self.pieces(&mut faults) };
        if faults.is_empty() {
            self.thirds(&path, limits, args, &mut faults);
        }
        if faults.is_empty() { Ok(path) } else { Err(Failure::faults(&self.name, &faults.told())) }
    }

    /// The rows, cut where s stays the same.
    fn pieces<const N: usize>(&self, faults: &mut Faults) -> Vec<AxisPiece<N>> {
        let mut pieces = Vec::new();
        let mut nodes: Vec<AxisNode<N>> = Vec::new();
        let rows = self.rows.lines.len();
        for row in 0..rows {
            let node = self.node(row, faults);
            match nodes.last() {
                Some(before) if node.s < before.s => faults.add(self.fault(
                    row,
                    format!("s = {} falls back from {}", node.s, before.s),
                    "sort the rows by s; two rows with the same s mark a jump of the derivatives",
                )),
                Some(before) if node.s <= before.s => {
                    self.joint(row, before, &node, faults);
                    if nodes.len() < 2 || row + 1 == rows {
                        let message = format!("s = {} stands here once too often", node.s);
                        let help = "two rows with the same s mark a jump inside the path, not at its \
                                    ends; remove the others";
                        faults.add(self.fault(row, message, help));
                    }
                    pieces.push(piece(std::mem::take(&mut nodes)));
                }
                _ => {}
            }
            nodes.push(node);
        }
        pieces.push(piece(nodes));
        pieces
    }

    fn node<const N: usize>(&self, row: usize, faults: &mut Faults) -> AxisNode<N> {
        let width = self.rows.names.len();
        let values = self.rows.values.get(row * width..(row + 1) * width).unwrap_or_default();
        let mut values = values.iter().copied();
        let s = values.next().unwrap_or_default();
        let mut q = [SVector::zeros(); 4];
        for (axis, third) in self.has_third.iter().enumerate() {
            for derivative in &mut q[..if *third { 4 } else { 3 }] {
                derivative[axis] = values.next().unwrap_or_default();
            }
        }
        if self.path_axis {
            (q[0][self.axes.len()], q[1][self.axes.len()]) = (s, 1.0);
        }
        let feed = values.next().filter(|_| self.has_feed);
        if let Some(feed) = feed.filter(|feed| *feed <= 0.0) {
            let help = "write the largest ds/dt at this row, or leave the column out";
            faults.add(self.fault(row, format!("feed = {feed} must be above 0"), help));
        }
        let most = feed.map(|feed| feed.min(self.path_feed.unwrap_or(feed)));
        AxisNode { s, q, tip_rate: 0.0, feed_rate: most.map_or(1.0, f64::recip) }
    }

    /// The column `speed`, piece by piece.
    pub(super) fn speeds<const N: usize>(&self, path: &AxisPath<N>) -> Vec<GivenSpeed> {
        let width = self.rows.names.len();
        let mut speeds = self.rows.values.chunks(width).map(|row| row.last().copied());
        let of = |piece: &AxisPiece<N>| GivenSpeed {
            s: piece.nodes.iter().map(|node| node.s).collect(),
            speed: speeds.by_ref().take(piece.nodes.len()).flatten().collect(),
        };
        path.pieces.iter().map(of).collect()
    }

    /// Both rows of a jump must be at the same place.
    fn joint<const N: usize>(
        &self,
        row: usize,
        before: &AxisNode<N>,
        node: &AxisNode<N>,
        faults: &mut Faults,
    ) {
        for (axis, name) in self.axes.iter().enumerate() {
            let [from, to] = [before.q[0][axis], node.q[0][axis]];
            if from.to_bits() != to.to_bits() && (from - to).abs() > 0.0 {
                faults.add(self.fault(
                    row,
                    format!("{name} jumps by {} from {from} to {to} at s = {}", to - from, node.s),
                    "no axis can jump: derivatives may differ between rows with the same s, values may not",
                ));
            }
        }
    }

    fn fault(&self, row: usize, message: String, help: &str) -> Fault {
        let line = self.rows.lines.get(row).copied().unwrap_or(0);
        Fault { line, column: 0, message, help: help.to_owned() }
    }

    /// Compares NAME3 with the third derivative of the quintic on both sides of every row.
    fn thirds<const N: usize>(
        &self,
        path: &AxisPath<N>,
        limits: &Limits<N>,
        args: &Args,
        faults: &mut Faults,
    ) {
        let third = |axis: &usize| self.has_third.get(*axis) == Some(&true);
        for axis in (0..self.axes.len()).filter(third) {
            let nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
            let largest = nodes.fold(0.0_f64, |most, node| most.max(node.q[3][axis].abs()));
            let noticed =
                |node: &AxisNode<N>, h: f64| noticed(node, (axis, h), limits, args.method);
            for (row, pair, thirds) in Self::intervals(path, axis) {
                let h = pair[1].s - pair[0].s;
                for (end, node) in pair.iter().enumerate() {
                    let [told, got] = [node.q[3][axis], thirds[end]];
                    let share = args.third_tolerance * largest.max(noticed(node, h));
                    if (got - told).abs() > share + rounding(pair, axis, h) {
                        faults.add(self.disagrees(row + end, axis, [told, got]));
                    }
                }
            }
        }
    }

    /// Row, nodes and the quintic's third derivatives at both ends, of every interval.
    fn intervals<const N: usize>(
        path: &AxisPath<N>,
        axis: usize,
    ) -> impl Iterator<Item = (usize, &[AxisNode<N>], [f64; 2])> {
        let pieces = path.pieces.iter().scan(0, |first, piece| {
            let row = *first;
            *first += piece.nodes.len();
            Some((row, piece))
        });
        pieces.flat_map(move |(first, piece)| {
            piece.nodes.windows(2).enumerate().filter_map(move |(interval, pair)| {
                let (_, quintic) = piece.quintic(interval)?;
                let ends = [0.0, pair[1].s - pair[0].s].map(|x| quintic.at(x)[3][axis]);
                Some((first + interval, pair, ends))
            })
        })
    }

    fn disagrees(&self, row: usize, axis: usize, [told, got]: [f64; 2]) -> Fault {
        let name = self.axis(axis);
        self.fault(
            row,
            format!(
                "{name}3 = {told}, but the quintic through {name}, {name}1, {name}2 of this row and its \
                 neighbour has {got:.6}"
            ),
            "are all derivatives by s? Otherwise: more decimals, or rows closer together; \
             --third-tolerance says how much is allowed",
        )
    }

    /// Where the axes rest inside the path.
    pub(super) fn rests<const N: usize>(&self, path: &AxisPath<N>) -> Vec<Rest> {
        let mut row = 0;
        let mut rests = Vec::new();
        for pair in path.pieces.windows(2) {
            row += pair[0].nodes.len();
            let (Some(before), Some(after)) = (pair[0].nodes.last(), pair[1].nodes.first()) else {
                continue;
            };
            let line = self.rows.lines.get(row).copied().unwrap_or(0);
            let jumps = (1..3).flat_map(|order| {
                self.axes.iter().enumerate().map(move |(axis, name)| {
                    (format!("{name}{order}"), after.q[order][axis] - before.q[order][axis])
                })
            });
            // A jump of the direction matters more than one of the curvature: first one wins.
            let jump = jumps.into_iter().find(|(_, jump)| jump.abs() > 0.0);
            rests.push(Rest { s: after.s, line, jump });
        }
        rests
    }
}

/// Third derivatives below this change neither jerk nor acceleration by more than their limits.
fn noticed<const N: usize>(
    node: &AxisNode<N>,
    (axis, h): (usize, f64),
    limits: &Limits<N>,
    method: Method,
) -> f64 {
    let fastest = node.q[1].component_div(&limits.velocity).amax().recip();
    match (method, &limits.jerk) {
        (Method::Jerk, Some(jerk)) => jerk[axis] / fastest.powi(3),
        _ => limits.acceleration[axis] / (fastest * fastest * h),
    }
}

/// Rounding of the quintic's third derivative at an end: `60 q / h³ - 36 q' / h² + 9 q'' / h`, each
/// number to half a unit of its last place and a few sums.
fn rounding<const N: usize>(pair: &[AxisNode<N>], axis: usize, h: f64) -> f64 {
    const SUMS: f64 = 16.0 * f64::EPSILON;
    let size = |order: usize| pair.iter().map(|node| node.q[order][axis].abs()).sum::<f64>();
    SUMS * (60.0 * size(0) / h.powi(3) + 36.0 * size(1) / (h * h) + 9.0 * size(2) / h)
}

fn piece<const N: usize>(nodes: Vec<AxisNode<N>>) -> AxisPiece<N> {
    AxisPiece { motion: Motion::Cut, source: 0, nodes }
}

/// Columns to read: s, the axes with limits in the table's order, `feed` if it is there, `speed` if it is
/// asked for.
fn columns(header: &Header, limits: &LimitsFile, speed: bool) -> Result<Vec<String>, Vec<Fault>> {
    let has = |name: &str| header.names().iter().any(|column| column == name);
    let mut faults = Vec::new();
    for name in header.names() {
        let is_axis = has(&format!("{name}1")) && has(&format!("{name}2"));
        if is_axis && !limits.axes.contains_key(name) {
            let help = format!("add [axis.{name}] with vel, acc, jerk to the limits file");
            faults.push(Fault::whole(format!("axis {name} has no limits")).with_help(help));
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut wanted = vec!["s".to_owned()];
    for axis in in_order(header.names(), limits) {
        let third = has(&format!("{axis}3"));
        let orders = ["", "1", "2", "3"].into_iter().take(if third { 4 } else { 3 });
        wanted.extend(orders.map(|order| format!("{axis}{order}")));
    }
    if has("feed") {
        wanted.push("feed".into());
    }
    if speed {
        wanted.push("speed".into());
    }
    Ok(wanted)
}

/// Axes of the limits file: those in the table in its order, then those that are missing there.
fn in_order(names: &[String], limits: &LimitsFile) -> Vec<String> {
    let place = |axis: &&String| names.iter().position(|name| name == *axis).unwrap_or(usize::MAX);
    let mut axes: Vec<&String> = limits.axes.keys().collect();
    axes.sort_by_key(place);
    axes.into_iter().cloned().collect()
}
