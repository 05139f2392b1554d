//! How the times of places are found.

use super::classic::Classic;
use super::leg::Place;
use super::pace::{Pace, Timed};
use super::{PostError, PostMethod, PostOptions};
use crate::machine::{Kinematics, Machine};
use crate::types::AxisVector;

/// Takes in places, hands out their times.
#[derive(Debug)]
pub(super) enum Timer {
    /// Along a smooth path.
    Path(Box<Pace>),
    /// Block after block.
    Blocks(Box<Classic>),
    /// As programmed.
    Programmed(Programmed),
}

impl Timer {
    pub(super) fn new(
        kinematics: &Kinematics,
        options: &PostOptions,
        at: AxisVector,
    ) -> Result<Self, PostError> {
        let machine = kinematics.machine();
        Ok(match options.method {
            PostMethod::Optimal | PostMethod::Jerk => {
                Self::Path(Box::new(Pace::new(kinematics, options, at)?))
            }
            PostMethod::Blocks => Self::Blocks(Box::new(Classic::new(machine, options, at))),
            PostMethod::Programmed => Self::Programmed(Programmed::new(machine, at)),
        })
    }

    /// Takes in a place; those whose time is known are appended.
    pub(super) fn push(&mut self, place: &Place, out: &mut Vec<Timed>) -> Result<(), PostError> {
        match self {
            Self::Path(pace) => pace.push(place, out),
            Self::Blocks(classic) => classic.push(place, out),
            Self::Programmed(programmed) => {
                out.push(programmed.timed(place));
                Ok(())
            }
        }
    }

    /// Ends the path; all places that are left are appended.
    pub(super) fn finish(self, out: &mut Vec<Timed>) -> Result<(), PostError> {
        match self {
            Self::Path(pace) => pace.finish(out),
            Self::Blocks(mut classic) => classic.rest(out),
            Self::Programmed(_) => Ok(()),
        }
    }
}

/// The feeds of the input, whatever the axes can do; where it names none, the velocities of the axes.
#[derive(Debug)]
pub(super) struct Programmed {
    velocity: AxisVector,
    rapid: AxisVector,
    at: AxisVector,
}

impl Programmed {
    fn new(machine: &Machine, at: AxisVector) -> Self {
        let [velocity, rapid] =
            [machine.vector(|axis| axis.vel), machine.vector(|axis| axis.rapid)];
        Self { velocity, rapid, at }
    }

    fn timed(&mut self, place: &Place) -> Timed {
        let travel = place.q - std::mem::replace(&mut self.at, place.q);
        let by = |limits: &AxisVector| travel.component_div(limits).amax();
        let seconds = match place.least {
            None => by(&self.rapid),
            Some(least) if least > 0.0 => least,
            Some(_) => by(&self.velocity),
        };
        Timed { place: *place, seconds }
    }
}
