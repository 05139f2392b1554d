//! Places with the ways and times that their words can say, so that what comes before and behind is planned with them.

use super::course::Course;
use super::leg::Place;
use crate::machine::Kinematics;
use crate::nc::write::{BRIEFEST_BLOCK, PlaceWords, Style};
use crate::types::{AxisVector, ToolPose};

/// Follows the words of a program.
#[derive(Debug, Clone)]
pub(super) struct Written {
    /// The last words that are written; `None` where F is not a speed of the tip.
    last: Option<PlaceWords>,
    /// Way and turn since then, of blocks that are left out as their words say nothing new.
    since: [f64; 2],
    /// The last place.
    at: (AxisVector, ToolPose),
}

impl Written {
    pub(super) fn new(
        kinematics: &Kinematics,
        style: &Style,
        start: &(AxisVector, ToolPose),
    ) -> Self {
        let last = words(kinematics, style, start);
        Self { last, since: [0.0; 2], at: *start }
    }

    /// Takes in the places of whole blocks.
    ///
    /// A tip feed is a speed between rounded places: there the time of a block is that way over it, and the programmed
    /// feed is kept where the way is a little longer. In inverse time a block that is quicker than F can say takes as
    /// long as it can.
    ///
    /// With `course` no axis is to exceed its velocity inside a block that is run at one speed.
    pub(super) fn take(
        &mut self,
        (kinematics, style): (&Kinematics, &Style),
        course: Option<&Course>,
        places: &mut [Place],
    ) {
        for block in places.chunk_by_mut(same_block) {
            if style.inverse_time {
                lengthen(block);
            } else if let Some(end) = block.last() {
                let now = words(kinematics, style, &(end.q, end.pose));
                self.block(block, now);
            }
            if let Some(course) = course {
                self.hold(course, kinematics, block);
            }
            self.at = block.last().map_or(self.at, |end| (end.q, end.pose));
        }
    }

    /// Gives a block the time that its fastest place asks for.
    fn hold(&self, course: &Course, kinematics: &Kinematics, block: &mut [Place]) {
        let limits = kinematics.machine().vector(|axis| axis.vel);
        let whole: f64 = block.iter().map(Place::size).sum();
        let (mut need, mut before) = (0.0_f64, self.at);
        for place in block.iter() {
            let fastest = course.fastest([(&before.0, &before.1), (&place.q, &place.pose)]);
            need = need.max(fastest.component_div(&limits).amax() * whole / place.size());
            before = (place.q, place.pose);
        }
        for place in block.iter_mut().filter(|_| need.is_finite()) {
            let share = need * place.size() / whole;
            place.least = place.least.map(|least| least.max(share));
        }
    }

    /// Gives a block the way between its words.
    fn block(&mut self, block: &mut [Place], now: Option<PlaceWords>) {
        let (Some(last), Some(to)) = (self.last, now) else {
            self.last = now;
            return;
        };
        let sum = |of: fn(&Place) -> f64| -> f64 { block.iter().map(of).sum() };
        let whole = [sum(|place| place.tip), sum(|place| place.turn)];
        if last == to {
            self.since = [0, 1].map(|k: usize| self.since[k] + whole[k]);
            return;
        }
        let since = std::mem::take(&mut self.since);
        let told = [last.way(&to), last.turn(&to).unwrap_or(whole[1] + since[1])];
        self.last = now;
        let even = 1.0 / block.len() as f64;
        for place in block {
            let planned = [place.tip, place.turn];
            let share = |k: usize| if whole[k] > 0.0 { planned[k] / whole[k] } else { even };
            place.written = [0, 1].map(|k: usize| (told[k] - since[k]) * share(k));
            let longer = place.per_way * (place.written[0] - place.tip);
            place.least = place.least.map(|least| (least + longer).max(0.0));
        }
    }
}

fn words(
    kinematics: &Kinematics,
    style: &Style,
    (q, pose): &(AxisVector, ToolPose),
) -> Option<PlaceWords> {
    if style.inverse_time { None } else { PlaceWords::new(kinematics, style, (q, pose)) }
}

/// As long as inverse time can say.
fn lengthen(block: &mut [Place]) {
    let time: f64 = block.iter().map(|place| place.least.unwrap_or(f64::INFINITY)).sum();
    let size = |place: &Place| place.tip + place.turn;
    let whole: f64 = block.iter().map(size).sum();
    let more = BRIEFEST_BLOCK - time;
    if more <= 0.0 || whole <= 0.0 {
        return;
    }
    for place in block {
        let by = more * size(place) / whole;
        place.least = place.least.map(|least| least + by);
    }
}

/// Whether the next place is on the way to the same block end.
fn same_block(place: &Place, _: &Place) -> bool {
    !place.block
}
