//! Columns of a table of axis positions, and faults of its rows.

use super::args::FeedMethod;
use crate::table::Faults;
use nalgebra::SVector;
use trunnion::feed::{FeedError, Limits, MinusLimits};
use trunnion::files::limits::{AxisLimits, LimitsFile};
use trunnion::files::table::TableHeader;
use trunnion::types::{AxisNode, AxisPiece, Diagnostic, Diagnostics};

/// A limit that never binds: its square is still a number.
const UNLIMITED: f64 = 1e150;

/// Meaning of the columns.
pub(super) struct Layout {
    /// Axes of the table, in order.
    axes: Vec<String>,
    /// True for axes with a column NAME3.
    has_third: Vec<bool>,
    has_feed: bool,
    /// True if the path parameter itself is limited, as one more axis.
    path_axis: bool,
    path_feed: Option<f64>,
}

/// Position of a row that repeats the s of the row before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JumpPosition {
    /// Inside the path, with no other such row next to it.
    Inside,
    /// At an end of the path, or next to another such row.
    AtEnd,
}

/// Interval between two neighbouring rows of a piece.
pub(super) struct PieceInterval<'a, const N: usize> {
    /// Lines of its two rows in the table.
    pub(super) lines: [u32; 2],
    pub(super) piece: &'a AxisPiece<N>,
    /// Number of the interval in the piece, from 0.
    pub(super) index: usize,
}

/// Settings of the comparison of NAME3 with the quintic between rows.
pub(super) struct ThirdTolerance<'a, const N: usize> {
    pub(super) limits: &'a Limits<N>,
    pub(super) method: FeedMethod,
    /// Largest difference, as a share of the largest NAME3.
    pub(super) share: f64,
}

/// Continuation of the path from a row to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// The row belongs to the piece of the row before.
    On,
    /// The row has the s of the row before: another piece begins.
    Piece,
}

impl Layout {
    /// Creates the layout of the columns that [`columns`] chose. Axes are those of the limits file.
    pub(super) fn new(names: &[String], limits: &LimitsFile) -> Self {
        let has = |name: &str| names.iter().any(|column| column == name);
        let axes = in_order(names, limits);
        Self {
            has_third: axes.iter().map(|axis| has(&format!("{axis}3"))).collect(),
            has_feed: has("feed"),
            path_feed: limits.path.feed,
            axes,
            path_axis: limits.path.acc.is_some() || limits.path.jerk.is_some(),
        }
    }

    /// Returns the number of axes to plan for.
    pub(super) fn axes(&self) -> usize {
        self.axes.len() + usize::from(self.path_axis)
    }

    /// Returns the name of an axis for messages.
    pub(super) fn axis(&self, index: usize) -> &str {
        self.axes.get(index).map_or("the path", String::as_str)
    }

    /// Returns the names of the axes in the table.
    pub(super) fn names(&self) -> &[String] {
        &self.axes
    }

    /// Returns the axes whose third derivative is in the table.
    pub(super) fn thirds(&self) -> impl Iterator<Item = usize> {
        (0..self.axes.len()).filter(|axis| self.has_third.get(*axis) == Some(&true))
    }

    /// Returns the unit of feed rates: with a column `feed` they are shares of it.
    pub(super) fn feed(&self) -> Option<f64> {
        if self.has_feed { Some(1.0) } else { self.path_feed }
    }

    /// Returns the limits of the axes to plan for, and flags for the accelerations that the chord error lowers at a
    /// servo period \[s\].
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
        // Axes that stand still never bind, whatever their limits; 1 avoids divisions by zero.
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

    /// Converts a row to a node.
    pub(super) fn node<const N: usize>(
        &self,
        line: u32,
        mut values: impl Iterator<Item = f64>,
        faults: &mut Faults,
    ) -> AxisNode<N> {
        let s = values.next().unwrap_or_default();
        let mut q = [SVector::zeros(); 4];
        for (axis, third) in self.has_third.iter().enumerate() {
            for derivative in &mut q[..if *third { 4 } else { 3 }] {
                derivative[axis] = values.next().unwrap_or_default();
            }
        }
        if self.path_axis {
            // The path parameter as an axis: q = s, dq/ds = 1, higher derivatives 0. Its acceleration and
            // jerk limits then limit those of s.
            (q[0][self.axes.len()], q[1][self.axes.len()]) = (s, 1.0);
        }
        let feed = values.next().filter(|_| self.has_feed);
        if let Some(feed) = feed.filter(|feed| *feed <= 0.0) {
            let help = "write the largest ds/dt at this row, or leave the column out";
            faults.add(fault(line, format!("feed = {feed} must be above 0"), help));
        }
        // The feed rate is the reciprocal: ds/dt = feed where rate times ds/dt is 1.
        let most = feed.map(|feed| feed.min(self.path_feed.unwrap_or(feed)));
        AxisNode { s, q, tip_rate: 0.0, feed_rate: most.map_or(1.0, f64::recip) }
    }

    /// Decides if a row continues a piece or begins one.
    pub(super) fn next<const N: usize>(
        &self,
        line: u32,
        [before, node]: [&AxisNode<N>; 2],
        position: JumpPosition,
        faults: &mut Faults,
    ) -> Next {
        if node.s > before.s {
            return Next::On;
        }
        if node.s < before.s {
            let message = format!("s = {} is below {} of the row before", node.s, before.s);
            let help =
                "sort the rows by s; two rows with the same s mark a jump of the derivatives";
            faults.add(fault(line, message, help));
            return Next::On;
        }
        self.joint(line, before, node, faults);
        if position == JumpPosition::AtEnd {
            let message = format!("s = {} is repeated once too often", node.s);
            let help = "two rows with the same s mark a jump inside the path, not at its ends; remove the others";
            faults.add(fault(line, message, help));
        }
        Next::Piece
    }

    /// Reports axes whose value differs between the two rows of a jump.
    fn joint<const N: usize>(
        &self,
        line: u32,
        before: &AxisNode<N>,
        node: &AxisNode<N>,
        faults: &mut Faults,
    ) {
        for (axis, name) in self.axes.iter().enumerate() {
            let [from, to] = [before.q[0][axis], node.q[0][axis]];
            // 0 and -0 are the same position.
            if from.to_bits() != to.to_bits() && (from - to).abs() > 0.0 {
                faults.add(fault(
                    line,
                    format!("{name} jumps by {} from {from} to {to} at s = {}", to - from, node.s),
                    "no axis can jump: derivatives may differ between rows with the same s, values may not",
                ));
            }
        }
    }

    /// Compares NAME3 of two neighbouring rows of a piece with the third derivative of the quintic between them;
    /// `largest` is that of the whole table.
    pub(super) fn third<const N: usize>(
        &self,
        interval: &PieceInterval<'_, N>,
        axis: usize,
        largest: f64,
        tolerance: &ThirdTolerance<'_, N>,
        faults: &mut Faults,
    ) {
        let PieceInterval { lines, piece, index } = *interval;
        let Some((_, quintic)) = piece.quintic(index) else { return };
        let Some(pair) = piece.nodes.get(index..index + 2) else { return };
        let h = pair[1].s - pair[0].s;
        for ((line, node), x) in lines.into_iter().zip(pair).zip([0.0, h]) {
            let [given, quintic_value] = [node.q[3][axis], quintic.at(x)[3][axis]];
            let noticed = noticed(node, axis, h, tolerance.limits, tolerance.method);
            // A table of small third derivatives is compared with the size that would matter.
            let share = tolerance.share * largest.max(noticed);
            if (quintic_value - given).abs() > share + rounding(pair, axis, h) {
                faults.add(self.disagrees(line, axis, [given, quintic_value]));
            }
        }
    }

    fn disagrees(&self, line: u32, axis: usize, [given, quintic_value]: [f64; 2]) -> Diagnostic {
        let name = self.axis(axis);
        fault(
            line,
            format!(
                "{name}3 = {given}, but the quintic through {name}, {name}1, {name}2 of this row and its \
                 neighbour has {quintic_value:.6}"
            ),
            "are all derivatives by s? Otherwise: more decimals, or rows closer together; \
             --third-tolerance sets the limit",
        )
    }

    /// Returns the derivative that jumps between the rows of a rest, and by how much; the lowest order first.
    pub(super) fn jump<const N: usize>(
        &self,
        [before, after]: [&AxisNode<N>; 2],
    ) -> Option<(String, f64)> {
        let jumps = (1..3).flat_map(|order| {
            self.axes.iter().enumerate().map(move |(axis, name)| {
                (format!("{name}{order}"), after.q[order][axis] - before.q[order][axis])
            })
        });
        // A jump of the direction matters more than one of the curvature: first one wins.
        jumps.into_iter().find(|(_, jump)| jump.abs() > 0.0)
    }
}

fn fault(line: u32, message: String, help: &str) -> Diagnostic {
    Diagnostic { line, column: 0, message, help: help.to_owned() }
}

/// Returns the third derivative below which neither jerk nor acceleration change by more than their limits.
fn noticed<const N: usize>(
    node: &AxisNode<N>,
    axis: usize,
    h: f64,
    limits: &Limits<N>,
    method: FeedMethod,
) -> f64 {
    // The velocity limits alone allow ds/dt up to 1 / max |q'_k| / v_k.
    let fastest = node.q[1].component_div(&limits.velocity).amax().recip();
    match (method, &limits.jerk) {
        // The term q''' (ds/dt)³ of the jerk.
        (FeedMethod::Jerk, Some(jerk)) => jerk[axis] / fastest.powi(3),
        // Over an interval h, q''' changes q'' by q''' h, and the acceleration by q''' h (ds/dt)².
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

/// Returns the columns to read: s, the axes with limits in the table's order, `feed` if present, and `speed` for given
/// speeds.
pub(super) fn columns(
    header: &TableHeader,
    limits: &LimitsFile,
    method: FeedMethod,
) -> Result<Vec<String>, Diagnostics> {
    let has = |name: &str| header.names().iter().any(|column| column == name);
    let mut faults = Vec::new();
    for name in header.names() {
        // A column with derivatives is an axis; one without a limit would be planned at any speed.
        let is_axis = has(&format!("{name}1")) && has(&format!("{name}2"));
        if is_axis && !limits.axes.contains_key(name) {
            let help = format!("add [axis.{name}] with vel, acc, jerk to the limits file");
            faults.push(Diagnostic::whole(format!("axis {name} has no limits")).with_help(help));
        }
    }
    if !faults.is_empty() {
        return Err(faults.into());
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
    if method == FeedMethod::Given {
        wanted.push("speed".into());
    }
    Ok(wanted)
}

/// Returns the axes of the limits file: those of the table in its order, then the missing ones.
fn in_order(names: &[String], limits: &LimitsFile) -> Vec<String> {
    let place = |axis: &&String| names.iter().position(|name| name == *axis).unwrap_or(usize::MAX);
    let mut axes: Vec<&String> = limits.axes.keys().collect();
    axes.sort_by_key(place);
    axes.into_iter().cloned().collect()
}
