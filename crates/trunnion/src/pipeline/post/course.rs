//! Moves of an input to places on the machine, close enough for its control to stay within tolerance.

use super::ahead::{Part, Planned};
use super::leg::{Leg, Place, Stop};
use super::{PostError, PostMove, PostOptions, PostPace, PostSource};
use crate::blocks::{Control, bend, moved};
use crate::inverse::{Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, Kinematics, Modulo, SECOND_ROTARY};
use crate::math::angle::great_circle;
use crate::math::jet::{Jet, Real};
use crate::types::{AxisVector, ToolPose};
use nalgebra::Vector3;

/// Most parts of one move: one that needs more does not get closer by being cut.
const MOST_PARTS: u32 = 4096;

/// Samples of a block whose bound is too large are doubled up to so many.
const MOST_SAMPLES: u32 = 64;

/// Turn of both rotaries after which the times inside a block are looked at: its axes bend \[rad\].
const TURN: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Turn up to which axes keep their mean velocity, to a thousandth of that of lever and tip \[rad\].
const LITTLE: f64 = 1e-3;

/// Most turn of a rotary in a block where a control takes the shorter way \[rad\].
const SHORT_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Deviation of the tip on rapid moves without tool-centre-point control \[mm\].
const RAPID_TOLERANCE: f64 = 1.0;

/// Positions are sums of a few numbers below 1e6, each rounded by 2^-53 of it \[mm or rad\].
const TRAVEL_ROUNDING: f64 = 1e-9;

/// A machine with what its control does between blocks.
#[derive(Debug, Clone)]
struct Target {
    inverse: Inverse,
    control: Control,
}

/// Takes in moves, hands out places.
#[derive(Debug, Clone)]
pub(super) struct Course {
    target: Target,
    source: PostSource,
    /// The input is for the same machine, set up alike: its rotaries count.
    own: bool,
    pub(super) tolerance: [f64; 2],
    most_turn: f64,
    at: Option<Stop>,
    /// Largest bounds so far: tip \[mm\], axis \[rad\].
    pub(super) strayed: [f64; 2],
}

/// A move between two stops, by shares.
#[derive(Clone, Copy)]
struct Way<'a> {
    /// Machine and control that run it; `None`: tip straight, tool on the great circle.
    run: Option<(&'a Kinematics, Control)>,
    ends: [Stop; 2],
}

impl Way<'_> {
    fn at(&self, share: f64) -> Option<ToolPose> {
        let [from, to] = &self.ends;
        if let Some((kinematics, control)) = self.run {
            let ends = [(&from.source, &from.pose), (&to.source, &to.pose)];
            return moved(kinematics, control, ends, share);
        }
        let tip = from.pose.tip + (to.pose.tip - from.pose.tip) * share;
        let axis = great_circle(&from.pose.axis, &to.pose.axis, share)?;
        Some(ToolPose { tip, axis })
    }

    /// Bounds on its second derivatives by the share.
    fn bend(&self) -> [f64; 2] {
        let [from, to] = &self.ends;
        if let Some((kinematics, control)) = self.run {
            let ends = [(&from.source, &from.pose), (&to.source, &to.pose)];
            return bend(kinematics, control, ends);
        }
        let chord = (*to.pose.axis - *from.pose.axis).norm_squared();
        // The square of an angle up to a half turn is at most π²/4 times that of its chord.
        [0.0, if chord < 1.0 { chord * (1.0 + 0.1 * chord) } else { 2.5 * chord }]
    }
}

impl Course {
    pub(super) fn new(
        kinematics: &Kinematics,
        source: PostSource,
        options: &PostOptions,
    ) -> Result<Self, PostError> {
        let inverse = Inverse::new(kinematics).map_err(|error| PostError::reach(0, error))?;
        let control = options.control;
        let own = matches!(&source, PostSource::Program(of) if **of == *kinematics);
        let rotaries = [FIRST_ROTARY, SECOND_ROTARY];
        let wound = rotaries.iter().all(|&axis| {
            kinematics
                .machine()
                .axes
                .get(axis)
                .is_some_and(|of| of.output.modulo == Modulo::Unwound)
        });
        Ok(Self {
            target: Target { inverse, control },
            source,
            own,
            tolerance: options.tolerance,
            most_turn: if wound { f64::INFINITY } else { SHORT_TURN },
            at: None,
            strayed: [0.0; 2],
        })
    }

    /// Where the machine is; `None` before the first move.
    pub(super) fn place(&self) -> Option<(AxisVector, ToolPose)> {
        self.at.as_ref().map(|at| (at.q, at.pose))
    }

    /// Takes in a move: places up to its end are appended. The first only says where the program starts.
    pub(super) fn go(&mut self, planned: &Planned, out: &mut Vec<Place>) -> Result<(), PostError> {
        let one = &planned.one;
        let home = self.target.inverse.kinematics().machine().home();
        let near = self.at.as_ref().map_or(home, |at| at.q);
        let q = match (planned.stand, one.q) {
            (Some(q), _) => q,
            (_, Some(q)) if self.own => self.inside_travel(one.line, q)?,
            _ => self.axes(one.line, &one.pose, &near)?,
        };
        let to = Stop { q, pose: one.pose, source: one.q.unwrap_or(q) };
        let Some(from) = self.at.replace(to) else { return Ok(()) };
        let length = (to.pose.tip - from.pose.tip).norm();
        let rapid = one.pace == PostPace::Rapid;
        // Seconds for all of the way, or by its length.
        let (per_share, per_length) = match one.pace {
            PostPace::Rapid => (0.0, 0.0),
            PostPace::Feed(feed) => (0.0, 1.0 / feed),
            PostPace::Seconds(seconds) if length > 0.0 => (0.0, seconds / length),
            PostPace::Seconds(seconds) => (seconds, 0.0),
        };
        let same = self.own && one.q.is_some() && one.way == self.target.control;
        let bows = one.way == Control::Axes && !same;
        let share = if bows { 0.5 } else { 1.0 };
        let mut leg = Leg {
            line: one.line,
            rapid,
            same,
            // A way whose tip bows leaves half of the tolerance for each: to poses, and from there to axes.
            tolerance: [share * self.tolerance[0], self.tolerance[1]],
            bowed: (1.0 - share) * self.tolerance[0],
            per_length,
            per_share,
            per_way: if matches!(one.pace, PostPace::Feed(_)) { per_length } else { 0.0 },
            out,
        };
        let turns = planned.part == Some(Part::Turn);
        if same || turns || (rapid && self.target.control != Control::Axes) {
            return self.direct([from, to], 1.0, &mut leg);
        }
        let source = std::mem::replace(&mut self.source, PostSource::Locations);
        let run = match &source {
            PostSource::Program(of) if one.way != Control::GreatCircle && one.q.is_some() => {
                Some((&**of, one.way))
            }
            _ => None,
        };
        let cut = self.cut(&Way { run, ends: [from, to] }, &mut leg);
        self.source = source;
        cut
    }

    /// Travel from place to place inside a block, had each axis kept the largest velocity it has on the way: that at an end
    /// of the parabola through both and the middle.
    pub(super) fn fastest(&self, pair: [(&AxisVector, &ToolPose); 2]) -> AxisVector {
        let [from, to] = pair.map(|(q, _)| q);
        let travel = to - from;
        let Target { inverse, control } = &self.target;
        let turns = travel.fixed_rows::<2>(FIRST_ROTARY).lp_norm(1) > LITTLE;
        let middle = if turns && *control != Control::Axes {
            let pose = moved(inverse.kinematics(), *control, pair, 0.5);
            pose.and_then(|pose| inverse.near(&pose, &from.lerp(to, 0.5)).ok())
        } else {
            None
        };
        let Some(middle) = middle else { return travel.abs() };
        let [first, second] = [middle - from, to - middle];
        (3.0 * first - second).abs().sup(&(3.0 * second - first).abs())
    }

    /// Axes at the end of a move, near those before.
    pub(super) fn near(
        &self,
        one: &PostMove,
        from: Option<&(AxisVector, ToolPose)>,
    ) -> Result<AxisVector, PostError> {
        let near = match (one.q, from) {
            (Some(q), _) if self.own => return Ok(q),
            (_, Some((q, _))) => *q,
            (_, None) => self.target.inverse.kinematics().machine().home(),
        };
        self.axes(one.line, &one.pose, &near)
    }

    /// Axes as they are programmed, if the machine has them.
    fn inside_travel(&self, line: u32, q: AxisVector) -> Result<AxisVector, PostError> {
        match self.target.inverse.kinematics().machine().out_of_travel(&q) {
            Some(out) if out.excess > TRAVEL_ROUNDING => {
                Err(PostError::reach(line, InverseError::OutOfTravel(out)))
            }
            _ => Ok(q),
        }
    }

    fn axes(&self, line: u32, pose: &ToolPose, near: &AxisVector) -> Result<AxisVector, PostError> {
        let found = self.target.inverse.near_inside(pose, near);
        found.map_err(|error| PostError::reach(line, error))
    }

    /// Cuts a move so that tip straight and rotaries linear (or the great circle) stay within tolerance.
    fn cut(&mut self, way: &Way<'_>, leg: &mut Leg<'_>) -> Result<(), PostError> {
        let poses = match self.target.control {
            Control::GreatCircle => Control::GreatCircle,
            _ => Control::RotaryLinear,
        };
        let tolerance = if leg.rapid { [RAPID_TOLERANCE, f64::INFINITY] } else { leg.tolerance };
        let [from, to] = way.ends;
        let mut parts = 1_u32;
        loop {
            let stops = self.stops(way, parts, leg)?;
            let mut worst = [0.0_f64; 2];
            let mut before = from;
            for (index, stop) in stops.iter().enumerate() {
                let shares =
                    [index as f64 / f64::from(parts), (index + 1) as f64 / f64::from(parts)];
                let off = self.stray(way, (shares, poses), [&before, stop], tolerance);
                worst = [worst[0].max(off[0]), worst[1].max(off[1])];
                before = *stop;
            }
            let excess = (worst[0] / tolerance[0]).max(worst[1] / tolerance[1]);
            if excess <= 1.0 {
                if !leg.rapid {
                    self.strayed = [self.strayed[0].max(worst[0]), self.strayed[1].max(worst[1])];
                }
                let mut before = from;
                for stop in stops {
                    self.direct([before, stop], 1.0 / f64::from(parts), leg)?;
                    before = stop;
                }
                self.at = Some(Stop { q: before.q, ..to });
                return Ok(());
            }
            if parts >= MOST_PARTS || !excess.is_finite() {
                return Err(PostError::Strays { line: leg.line, strayed: worst, tolerance });
            }
            // A bound falls with the square of the parts; no more than four times as many at once.
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1..=4")]
            let factor = excess.sqrt().ceil().clamp(2.0, 4.0) as u32;
            let next = if excess < 2.0 { parts + parts / 2 } else { parts * factor };
            parts = next.max(parts + 1).min(MOST_PARTS);
        }
    }

    /// Ends of the parts of a move.
    fn stops(&self, way: &Way<'_>, parts: u32, leg: &Leg<'_>) -> Result<Vec<Stop>, PostError> {
        let line = leg.line;
        let [from, to] = way.ends;
        if parts == 1 {
            return Ok(vec![to]);
        }
        let pair = [(&from.q, &from.pose), (&to.q, &to.pose)];
        let mut stops = Vec::new();
        let mut near = from.q;
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let pose = if part == parts { Some(to.pose) } else { way.at(share) };
            let pose = pose.ok_or(PostError::Reversal { line })?;
            let q = match way.run {
                Some((_, Control::Axes)) if self.own => from.source.lerp(&to.source, share),
                Some(_) if self.own => self.slid(pair, share, line)?.q,
                _ => self.axes(line, &pose, &near)?,
            };
            near = q;
            stops.push(Stop { q, pose, source: q });
        }
        Ok(stops)
    }

    /// Bounds on how far the target strays from a part of the way, at equal shares: tip \[mm\], axis \[rad\].
    fn stray(
        &self,
        way: &Way<'_>,
        (shares, control): ([f64; 2], Control),
        ends: [&Stop; 2],
        enough: [f64; 2],
    ) -> [f64; 2] {
        let alike = match way.run {
            None => control == Control::GreatCircle,
            Some((_, run)) => self.own && run == control,
        };
        if alike {
            return [0.0; 2];
        }
        let kinematics = self.target.inverse.kinematics();
        let pair = ends.map(|end| (&end.q, &end.pose));
        let width = shares[1] - shares[0];
        let [path, run] =
            [way.bend().map(|of| of * width * width), bend(kinematics, control, pair)];
        let curved = [0, 1].map(|k: usize| 0.125 * (path[k] + run[k]));
        let mut samples = 1_u32;
        loop {
            let mut off = [0.0_f64; 2];
            for k in 1..samples {
                let share = f64::from(k) / f64::from(samples);
                let place = way.at(shares[0] + width * share);
                let there = moved(kinematics, control, pair, share);
                let (Some(place), Some(there)) = (place, there) else { return [f64::INFINITY; 2] };
                off[0] = off[0].max((place.tip - there.tip).norm());
                off[1] = off[1].max((*place.axis - *there.axis).norm());
            }
            let square = f64::from(samples * samples);
            let tip = off[0] + curved[0] / square;
            let bound = [tip, angle_of(off[1] + curved[1] / square)];
            let fits = bound[0] <= enough[0] && bound[1] <= enough[1];
            let hopeless = off[0] > enough[0] || off[1] > enough[1];
            if fits || hopeless || samples >= MOST_SAMPLES {
                return bound;
            }
            samples *= 2;
        }
    }

    /// Goes from one stop to another as the target's control does, in blocks whose tip stays straight.
    fn direct(&mut self, ends: [Stop; 2], share: f64, leg: &mut Leg<'_>) -> Result<(), PostError> {
        let [from, to] = ends;
        let turns = (to.q - from.q).fixed_rows::<2>(FIRST_ROTARY).abs();
        let mut blocks = (turns.amax() / self.most_turn).ceil().max(1.0);
        let pair = [(&from.q, &from.pose), (&to.q, &to.pose)];
        if self.target.control == Control::Axes && !leg.same {
            let tolerance = if leg.rapid { RAPID_TOLERANCE } else { leg.tolerance[0] };
            let bow = 0.125 * bend(self.target.inverse.kinematics(), Control::Axes, pair)[0];
            let count = (bow / tolerance).sqrt().ceil();
            blocks = blocks.max(count);
            if !leg.rapid {
                self.strayed[0] = self.strayed[0].max(leg.bowed + bow / (blocks * blocks));
            }
        }
        if blocks > f64::from(MOST_PARTS) {
            return Err(PostError::Strays {
                line: leg.line,
                strayed: [f64::INFINITY, 0.0],
                tolerance: self.tolerance,
            });
        }
        let looks = match self.target.control {
            Control::Axes => 1.0,
            _ => (turns.sum() / blocks / TURN).ceil().max(1.0),
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let [blocks, looks] = [blocks, looks].map(|count| count as u32);
        let parts = blocks * looks;
        let mut before = from;
        for part in 1..=parts {
            let stop = if part == parts {
                to
            } else {
                self.inside(pair, f64::from(part) / f64::from(parts), (leg, &before.q))?
            };
            leg.push(&before, &stop, (part.is_multiple_of(looks), share / f64::from(parts)));
            before = stop;
        }
        Ok(())
    }

    /// Where the control is inside a block: tip straight, rotaries linear or the tool on the great circle.
    fn inside(
        &self,
        pair: [(&AxisVector, &ToolPose); 2],
        share: f64,
        (leg, near): (&Leg<'_>, &AxisVector),
    ) -> Result<Stop, PostError> {
        let inverse = &self.target.inverse;
        let kinematics = inverse.kinematics();
        match self.target.control {
            Control::GreatCircle => {
                let pose = moved(kinematics, Control::GreatCircle, pair, share);
                let pose = pose.ok_or(PostError::Reversal { line: leg.line })?;
                let found = inverse.near(&pose, near);
                let q = found.map_err(|error| PostError::reach(leg.line, error))?;
                Ok(Stop { q, pose, source: q })
            }
            Control::Axes if leg.same => {
                let q = pair[0].0.lerp(pair[1].0, share);
                Ok(Stop { q, pose: kinematics.forward(&q), source: q })
            }
            _ => self.slid(pair, share, leg.line),
        }
    }

    /// Tip straight, rotaries linear.
    fn slid(
        &self,
        pair: [(&AxisVector, &ToolPose); 2],
        share: f64,
        line: u32,
    ) -> Result<Stop, PostError> {
        let inverse = &self.target.inverse;
        let mixed = pair[0].0.lerp(pair[1].0, share);
        let tip = pair[0].1.tip + (pair[1].1.tip - pair[0].1.tip) * share;
        let zero = Vector3::zeros();
        let turns = [mixed[FIRST_ROTARY], mixed[SECOND_ROTARY]].map(<Jet as Real>::constant);
        let found = inverse.with_rotaries(&[tip.coords, zero, zero, zero], turns);
        let [q, ..] = found.map_err(|error| PostError::reach(line, error))?;
        Ok(Stop { q, pose: inverse.kinematics().forward(&q), source: q })
    }
}

/// Angle of a chord between unit vectors, from above: `2 asin(c/2) <= c (1 + c²/20)` for chords up to 1.
fn angle_of(chord: f64) -> f64 {
    if chord > 1.0 { f64::INFINITY } else { chord * (1.0 + 0.05 * chord * chord) }
}
