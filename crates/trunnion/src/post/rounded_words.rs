//! Lengths and times as rounded words express them, so that planning uses what the program will contain.

use super::axis_point::{AxesPose, AxisPoint};
use super::subdivision::Subdivider;
use crate::machine::Kinematics;
use crate::nc::write::{BRIEFEST_BLOCK, PlaceWords, Style, WrittenPosition};

/// Words of the program so far, and the travel since.
#[derive(Debug, Clone)]
pub(super) struct RoundedWords {
    /// Last words that are written; `None` where F is not a speed of the tip.
    last: Option<PlaceWords>,
    /// Travel of tip \[mm\] and rotaries \[rad\] since then, in blocks left out because no word changes.
    since: [f64; 2],
    /// Last point.
    at: AxesPose,
}

impl RoundedWords {
    pub(super) fn new(kinematics: &Kinematics, style: &Style, start: &AxesPose) -> Self {
        let last = words(kinematics, style, start);
        Self { last, since: [0.0; 2], at: *start }
    }

    /// Takes in the points of whole blocks, and adapts their travel and least times to the rounded words.
    ///
    /// A tip feed is the speed between rounded points: the time of a block is their distance over the feed, and the
    /// programmed feed is kept where that distance is a little longer. In inverse time a block shorter than the
    /// largest F word takes as long as that word asks for.
    ///
    /// With `subdivider`, no axis exceeds its velocity inside a block that runs at one speed.
    pub(super) fn take(
        &mut self,
        kinematics: &Kinematics,
        style: &Style,
        subdivider: Option<&Subdivider>,
        points: &mut [AxisPoint],
    ) {
        for block in points.chunk_by_mut(same_block) {
            if style.inverse_time {
                lengthen(block);
            } else if let Some(end) = block.last() {
                let now = words(kinematics, style, &end.end());
                self.block(block, now);
            }
            if let Some(subdivider) = subdivider {
                self.hold(subdivider, kinematics, block);
            }
            self.at = block.last().map_or(self.at, AxisPoint::end);
        }
    }

    /// Gives a block the time that its fastest axis asks for.
    fn hold(&self, subdivider: &Subdivider, kinematics: &Kinematics, block: &mut [AxisPoint]) {
        let limits = kinematics.machine().vector(|axis| axis.vel);
        let whole: f64 = block.iter().map(AxisPoint::size).sum();
        let (mut need, mut before) = (0.0_f64, self.at);
        for point in block.iter_mut() {
            let end = point.end();
            // The block runs at one speed: its time is the largest that any of its points asks for.
            let fastest = subdivider.fastest([before.block_end(), end.block_end()]);
            point.fastest = Some(fastest);
            need = need.max(fastest.component_div(&limits).amax() * whole / point.size());
            before = end;
        }
        for point in block.iter_mut().filter(|_| need.is_finite()) {
            let share = need * point.size() / whole;
            point.least = point.least.map(|least| least.max(share));
        }
    }

    /// Gives a block the travel between its rounded words.
    fn block(&mut self, block: &mut [AxisPoint], now: Option<PlaceWords>) {
        let (Some(last), Some(to)) = (self.last, now) else {
            self.last = now;
            return;
        };
        let sum = |of: fn(&AxisPoint) -> f64| -> f64 { block.iter().map(of).sum() };
        let whole = [sum(|point| point.tip), sum(|point| point.turn)];
        if last == to {
            self.since = [0, 1].map(|k: usize| self.since[k] + whole[k]);
            return;
        }
        let since = std::mem::take(&mut self.since);
        // Distance between the words as written, from which the control computes its speed.
        let written = [last.way(&to), last.turn(&to).unwrap_or(whole[1] + since[1])];
        self.last = now;
        let even = 1.0 / block.len() as f64;
        for point in block {
            let planned = [point.tip, point.turn];
            let share = |k: usize| if whole[k] > 0.0 { planned[k] / whole[k] } else { even };
            point.written = [0, 1].map(|k: usize| (written[k] - since[k]) * share(k));
            // A feed along a longer way takes longer; one along a shorter way less.
            let longer = point.per_way * (point.written[0] - point.tip);
            point.least = point.least.map(|least| (least + longer).max(0.0));
        }
    }
}

fn words(kinematics: &Kinematics, style: &Style, end: &AxesPose) -> Option<PlaceWords> {
    let at = WrittenPosition { q: &end.q, pose: &end.pose };
    if style.inverse_time { None } else { PlaceWords::new(kinematics, style, at) }
}

/// Makes a block last as long as the largest inverse-time word asks for.
fn lengthen(block: &mut [AxisPoint]) {
    let time: f64 = block.iter().map(|point| point.least.unwrap_or(f64::INFINITY)).sum();
    let size = |point: &AxisPoint| point.tip + point.turn;
    let whole: f64 = block.iter().map(size).sum();
    // The largest F word of inverse time bounds how short a block can be.
    let more = BRIEFEST_BLOCK - time;
    if more <= 0.0 || whole <= 0.0 {
        return;
    }
    for point in block {
        let by = more * size(point) / whole;
        point.least = point.least.map(|least| least + by);
    }
}

/// Returns true if the next point belongs to the same block.
fn same_block(point: &AxisPoint, _: &AxisPoint) -> bool {
    !point.block
}
