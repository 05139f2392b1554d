//! Divides moves of the input into points so close that the target control stays within tolerance.

use super::axis_point::{AxesPose, AxisPoint, DividedMove, MachinePoint, PartEnd, PositionSource};
use super::error::PostError;
use super::options::{PostMove, PostOptions, PostPace, PostSource};
use super::rotaries::{PlannedMove, RetractPhase};
use crate::blocks::{BlockEnd, BlockInterpolation, bend, moved};
use crate::inverse::{Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, Kinematics, RotaryPair, SECOND_ROTARY, TurnFormat};
use crate::math::angle::great_circle;
use crate::nc::write::{AxisWords, Coordinates, OutputFormat, Style, rounding};
use crate::types::{AxisVector, TRAVEL_ROUNDING, ToolPose};
use std::f64::consts::PI;

/// Most parts of one move: if it needs more, dividing does not bring it closer.
const MOST_PARTS: u32 = 4096;

/// Largest number of samples of a block; they are doubled while its bound is too large.
const MOST_SAMPLES: u32 = 64;

/// Turn of both rotaries between two points inside a block: the axes curve, so that its times need them \[rad\].
const TURN: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Turn up to which axes keep their mean velocity, within a thousandth of that of lever and tip \[rad\].
const LITTLE: f64 = 1e-3;

/// Largest turn of a rotary in a block, for controls that take the shorter direction \[rad\].
const SHORT_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Deviation of the tip on rapid moves without tool-centre-point control \[mm\].
const RAPID_TOLERANCE: f64 = 1.0;

/// Machine with the motion of its control between blocks.
#[derive(Debug, Clone)]
struct TargetMachine {
    inverse: Inverse,
    control: BlockInterpolation,
}

/// Turns moves into points on the way of the axes.
#[derive(Debug, Clone)]
pub(super) struct Subdivider {
    target: TargetMachine,
    source: PostSource,
    /// True if the input is for the same machine with the same setup: its rotary words are kept.
    own: bool,
    pub(super) tolerance: [f64; 2],
    /// True if the program runs on a machine, whose rotaries turn; false for cutter locations.
    turns: bool,
    /// Words of the program, whose rounding the ends of blocks state.
    words: Option<AxisWords>,
    most_turn: f64,
    at: Option<MachinePoint>,
    /// Largest deviation bounds so far: tip \[mm\], axis \[rad\].
    pub(super) strayed: [f64; 2],
    /// The same of rapid moves.
    pub(super) strayed_rapid: [f64; 2],
}

/// Motion of the input between two points, by the share of the move.
#[derive(Clone, Copy)]
struct MoveGeometry<'a> {
    /// Machine and control of the input; `None`: tip straight, tool axis on a great circle.
    run: Option<(&'a Kinematics, BlockInterpolation)>,
    ends: [MachinePoint; 2],
}

/// Portion of a move between two points.
#[derive(Clone, Copy)]
struct Portion<'a> {
    /// Shares of the move at both ends.
    shares: [f64; 2],
    ends: [&'a MachinePoint; 2],
}

impl MoveGeometry<'_> {
    /// Returns the pose at a share of the move; `None` if the tool axis turns to its opposite.
    fn at(&self, share: f64) -> Option<ToolPose> {
        let [from, to] = &self.ends;
        if let Some((kinematics, control)) = self.run {
            // The input's own machine carries out its moves, with the axes as the input has them.
            let ends =
                [BlockEnd::new(&from.source, &from.pose), BlockEnd::new(&to.source, &to.pose)];
            return moved(kinematics, control, ends, share);
        }
        let tip = from.pose.tip + (to.pose.tip - from.pose.tip) * share;
        let axis = great_circle(&from.pose.axis, &to.pose.axis, share)?;
        Some(ToolPose { tip, axis })
    }

    /// Bounds the second derivatives of tip \[mm\] and axis \[rad\] by the share.
    fn bend(&self) -> [f64; 2] {
        let [from, to] = &self.ends;
        if let Some((kinematics, control)) = self.run {
            let ends =
                [BlockEnd::new(&from.source, &from.pose), BlockEnd::new(&to.source, &to.pose)];
            return bend(kinematics, control, ends);
        }
        let chord = (*to.pose.axis - *from.pose.axis).norm_squared();
        // The square of an angle up to a half turn is at most π²/4 times that of its chord.
        [0.0, if chord < 1.0 { chord * (1.0 + 0.1 * chord) } else { 2.5 * chord }]
    }
}

impl Subdivider {
    /// Creates a subdivider for a target machine.
    pub(super) fn new(
        kinematics: &Kinematics,
        source: PostSource,
        options: &PostOptions,
    ) -> Result<Self, PostError> {
        let inverse = Inverse::new(kinematics).map_err(|error| PostError::reach(0, error))?;
        let control = options.control;
        let own = matches!(&source, PostSource::Program(of) if **of == *kinematics);
        let rotaries = [FIRST_ROTARY, SECOND_ROTARY];
        // A control that takes the shorter direction must never be asked for half a turn or more.
        let wound = rotaries.iter().all(|&axis| {
            kinematics
                .machine()
                .axes
                .get(axis)
                .is_some_and(|of| of.output.modulo == TurnFormat::Unwound)
        });
        Ok(Self {
            target: TargetMachine { inverse, control },
            source,
            own,
            tolerance: options.tolerance.into(),
            turns: true,
            words: None,
            most_turn: if wound { f64::INFINITY } else { SHORT_TURN },
            at: None,
            strayed: [0.0; 2],
            strayed_rapid: [0.0; 2],
        })
    }

    /// Divides for programs of a style: cutter locations have no rotaries that could turn.
    pub(super) fn for_style(self, style: &Style) -> Self {
        Self { turns: style.dialect != OutputFormat::Apt, words: Some(style.axes), ..self }
    }

    /// Returns the largest error of X, Y and Z at `q` by the rounding of tip words; 0 where there are none \[mm\].
    pub(super) fn linear_error(&self, source: PositionSource, q: &AxisVector) -> f64 {
        match &self.words {
            // The linear axes follow the tip, whose words are off by their own rounding, and swing with the rotaries.
            Some(words) if source == PositionSource::Tip => {
                rounding(self.target.inverse.kinematics(), q, words, Coordinates::Axes, 0.0)
            }
            _ => 0.0,
        }
    }

    /// Returns the position of the machine; `None` before the first move.
    pub(super) fn position(&self) -> Option<AxesPose> {
        self.at.as_ref().map(|at| AxesPose { q: at.q, pose: at.pose })
    }

    /// Takes in a move and appends the points up to its end. The first move only sets the starting position.
    pub(super) fn divide(
        &mut self,
        planned: &PlannedMove,
        out: &mut Vec<AxisPoint>,
    ) -> Result<(), PostError> {
        let one = &planned.one;
        let home = self.target.inverse.kinematics().machine().home();
        let near = self.at.as_ref().map_or(home, |at| at.q);
        // Step 1: axes at the end of the move.
        let q = match (planned.axes, one.q) {
            (Some(q), _) => q,
            (_, Some(q)) if self.own => self.inside_travel(one.line, q)?,
            _ => self.axes(one.line, &one.pose, &near)?,
        };
        let to = MachinePoint { q, pose: one.pose, source: one.q.unwrap_or(q) };
        let Some(from) = self.at.replace(to) else { return Ok(()) };
        if planned.axes.is_none() {
            self.goes_on(one, &from.q, &q)?;
        }
        let (begin, source) = (out.len(), self.position_source(one));
        let length = (to.pose.tip - from.pose.tip).norm();
        let rapid = one.pace == PostPace::Rapid;
        // Step 2: programmed time, of the whole move or per length.
        let (per_share, per_length) = match one.pace {
            PostPace::Rapid => (0.0, 0.0),
            PostPace::Feed(feed) => (0.0, 1.0 / feed),
            PostPace::Seconds(seconds) if length > 0.0 => (0.0, seconds / length),
            PostPace::Seconds(seconds) => (seconds, 0.0),
        };
        let same = self.own && one.q.is_some() && one.way == self.target.control;
        let bows = one.way == BlockInterpolation::Axes && !same;
        // Linear axes make the tip of the input bow, which costs a share of the tolerance.
        let share = if bows { 0.5 } else { 1.0 };
        let mut target_move = DividedMove {
            line: one.line,
            rapid,
            same,
            is_added: planned.phase.is_some(),
            // If the tip of the input bows, each conversion has half of the tolerance: to poses, then to axes.
            tolerance: [share * self.tolerance[0], self.tolerance[1]],
            bowed: (1.0 - share) * self.tolerance[0],
            per_length,
            per_share,
            per_way: if matches!(one.pace, PostPace::Feed(_)) { per_length } else { 0.0 },
            source,
            out,
        };
        let input = std::mem::replace(&mut self.source, PostSource::Locations);
        let run = match &input {
            PostSource::Program(of)
                if one.way != BlockInterpolation::GreatCircle && one.q.is_some() =>
            {
                Some((&**of, one.way))
            }
            _ => None,
        };
        let geometry = MoveGeometry { run, ends: [from, to] };
        // Step 3: a move that needs no division is run as it is; any other is divided. The source is borrowed beside
        // `self`.
        let turns = planned.phase == Some(RetractPhase::Turn);
        let is_run = same || turns || (rapid && self.target.control != BlockInterpolation::Axes);
        let divided = if is_run {
            if rapid && !same && planned.phase.is_none() {
                self.compare_rapid(&geometry);
            }
            self.run_directly([from, to], 1.0, &mut target_move)
        } else {
            self.cut(&geometry, &mut target_move)
        };
        self.source = input;
        for point in out.iter_mut().skip(begin).filter(|point| point.block) {
            point.linear_error = self.linear_error(source, &point.q);
        }
        divided
    }

    /// Compares a rapid move that is run as it is with the way of the input.
    fn compare_rapid(&mut self, geometry: &MoveGeometry<'_>) {
        let [from, to] = &geometry.ends;
        let portion = Portion { shares: [0.0, 1.0], ends: [from, to] };
        // Rapid moves are sampled, not bounded: they may leave the line by any amount, which is only reported.
        let off = self.deviation(geometry, self.target.control, &portion, None);
        self.note_rapid(off);
    }

    /// Keeps the largest deviation of rapid moves \[mm, rad\].
    fn note_rapid(&mut self, off: [f64; 2]) {
        // Beyond half a turn no angle is larger.
        let off = [off[0], off[1].min(PI)];
        self.strayed_rapid = [0, 1].map(|k: usize| self.strayed_rapid[k].max(off[k]));
    }

    /// Returns the travel between two points of a block as if each axis kept its largest velocity between them.
    ///
    /// That velocity is the one at an end of the parabola through both points and the middle.
    pub(super) fn fastest(&self, pair: [BlockEnd<'_>; 2]) -> AxisVector {
        let [from, to] = pair.map(|end| end.q);
        let travel = to - from;
        let TargetMachine { inverse, control } = &self.target;
        // Between two points the axes are a parabola in time; its slope is largest at an end, 3/2 of the
        // first half less 1/2 of the second, times two. Small turns leave it straight.
        let turns = travel.fixed_rows::<2>(FIRST_ROTARY).lp_norm(1) > LITTLE;
        let middle = if turns && *control != BlockInterpolation::Axes {
            let pose = moved(inverse.kinematics(), *control, pair, 0.5);
            pose.and_then(|pose| inverse.near(&pose, &from.lerp(to, 0.5)).ok())
        } else {
            None
        };
        let Some(middle) = middle else { return travel.abs() };
        let [first, second] = [middle - from, to - middle];
        (3.0 * first - second).abs().sup(&(3.0 * second - first).abs())
    }

    /// Returns the axes at the end of a move, near those of `from`.
    pub(super) fn near(
        &self,
        one: &PostMove,
        from: Option<&AxesPose>,
    ) -> Result<AxisVector, PostError> {
        let near = match (one.q, from) {
            (Some(q), _) if self.own => return Ok(q),
            (_, Some(from)) => from.q,
            (_, None) => self.target.inverse.kinematics().machine().home(),
        };
        self.axes(one.line, &one.pose, &near)
    }

    /// Refuses a cut in which a rotary has to go round: along a great circle the tool would not show it.
    fn goes_on(&self, one: &PostMove, from: &AxisVector, to: &AxisVector) -> Result<(), PostError> {
        let great_circle = self.target.control == BlockInterpolation::GreatCircle;
        let turn = (to - from).fixed_rows::<2>(FIRST_ROTARY).amax();
        if !great_circle || !self.turns || one.pace == PostPace::Rapid || turn < SHORT_TURN {
            return Ok(());
        }
        // Axes that go on continuously end up elsewhere only if their travel ends.
        let Ok(on) = self.target.inverse.near(&one.pose, from) else { return Ok(()) };
        if (on - to).fixed_rows::<2>(FIRST_ROTARY).amax() <= SHORT_TURN {
            return Ok(());
        }
        Err(PostError::GoesRound { line: one.line, turn })
    }

    /// Returns the words that the positions of a move come from.
    pub(super) fn position_source(&self, one: &PostMove) -> PositionSource {
        match one.way {
            _ if !self.own || one.q.is_none() => PositionSource::Exact,
            BlockInterpolation::Axes => PositionSource::Axes,
            _ => PositionSource::Tip,
        }
    }

    /// Returns the axes as programmed, if they are inside travel.
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

    /// Divides a move until the target control stays within tolerance: tip straight, rotaries linear or on a great
    /// circle.
    fn cut(
        &mut self,
        geometry: &MoveGeometry<'_>,
        target_move: &mut DividedMove<'_>,
    ) -> Result<(), PostError> {
        // For linear axes the tip's own bow is bounded afterwards, in `run_directly`.
        let poses = match self.target.control {
            BlockInterpolation::GreatCircle => BlockInterpolation::GreatCircle,
            _ => BlockInterpolation::RotaryLinear,
        };
        let tolerance = if target_move.rapid {
            [RAPID_TOLERANCE, f64::INFINITY]
        } else {
            target_move.tolerance
        };
        let [from, to] = geometry.ends;
        let mut parts = 1_u32;
        loop {
            // Step 1: points at equal shares, and the largest deviation between them.
            let points = self.part_ends(geometry, parts, target_move)?;
            let mut worst = [0.0_f64; 2];
            let mut before = from;
            for (index, point) in points.iter().enumerate() {
                let shares =
                    [index as f64 / f64::from(parts), (index + 1) as f64 / f64::from(parts)];
                let off = self.deviation(
                    geometry,
                    poses,
                    &Portion { shares, ends: [&before, point] },
                    Some(tolerance),
                );
                worst = [worst[0].max(off[0]), worst[1].max(off[1])];
                before = *point;
            }
            // Step 2: accept them, or use more parts.
            let excess = (worst[0] / tolerance[0]).max(worst[1] / tolerance[1]);
            if excess <= 1.0 {
                if target_move.rapid {
                    self.note_rapid(worst);
                } else {
                    self.strayed = [self.strayed[0].max(worst[0]), self.strayed[1].max(worst[1])];
                }
                let mut before = from;
                for point in points {
                    self.run_directly([before, point], 1.0 / f64::from(parts), target_move)?;
                    before = point;
                }
                self.at = Some(MachinePoint { q: before.q, ..to });
                return Ok(());
            }
            // A bound on the tool axis that is none yet falls with more parts; one on the tip has no path.
            if parts >= MOST_PARTS || !worst[0].is_finite() {
                return Err(PostError::Strays {
                    line: target_move.line,
                    strayed: worst.into(),
                    tolerance: tolerance.into(),
                });
            }
            // A bound falls with the square of the parts; no more than four times as many at once.
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1..=4")]
            let factor = excess.sqrt().ceil().clamp(2.0, 4.0) as u32;
            let next = if excess < 2.0 { parts + parts / 2 } else { parts * factor };
            parts = next.max(parts + 1).min(MOST_PARTS);
        }
    }

    /// Returns the ends of equal parts of a move.
    fn part_ends(
        &self,
        geometry: &MoveGeometry<'_>,
        parts: u32,
        target_move: &DividedMove<'_>,
    ) -> Result<Vec<MachinePoint>, PostError> {
        let line = target_move.line;
        let [from, to] = geometry.ends;
        if parts == 1 {
            return Ok(vec![to]);
        }
        let pair = [BlockEnd::new(&from.q, &from.pose), BlockEnd::new(&to.q, &to.pose)];
        let mut points = Vec::new();
        let mut near = from.q;
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let pose = if part == parts { Some(to.pose) } else { geometry.at(share) };
            let pose = pose.ok_or(PostError::Reversal { line })?;
            let q = match geometry.run {
                Some((_, BlockInterpolation::Axes)) if self.own => {
                    from.source.lerp(&to.source, share)
                }
                Some(_) if self.own => self.slid(pair, share, line)?.q,
                _ => self.axes(line, &pose, &near)?,
            };
            near = q;
            points.push(MachinePoint { q, pose, source: q });
        }
        Ok(points)
    }

    /// Bounds the deviation of the target from a portion of a move, at equal shares: tip \[mm\], axis \[rad\].
    ///
    /// Sampling ends once the bound is within `enough`, or once a sample alone exceeds it; without it, at most samples.
    fn deviation(
        &self,
        geometry: &MoveGeometry<'_>,
        control: BlockInterpolation,
        portion: &Portion<'_>,
        enough: Option<[f64; 2]>,
    ) -> [f64; 2] {
        let Portion { shares, ends } = *portion;
        // The same interpolation on both sides: nothing deviates.
        let alike = match geometry.run {
            None => control == BlockInterpolation::GreatCircle,
            Some((_, run)) => self.own && run == control,
        };
        if alike {
            return [0.0; 2];
        }
        let kinematics = self.target.inverse.kinematics();
        let pair = ends.map(|end| BlockEnd::new(&end.q, &end.pose));
        let width = shares[1] - shares[0];
        // Second derivatives by the share of the portion, which scales them by its width squared.
        let [path, run] =
            [geometry.bend().map(|of| of * width * width), bend(kinematics, control, pair)];
        // Between two samples the difference of both curves bends by at most an eighth of their second derivatives.
        let curved = [0, 1].map(|k: usize| 0.125 * (path[k] + run[k]));
        let mut samples = 1_u32;
        loop {
            let mut off = [0.0_f64; 2];
            for k in 1..samples {
                let share = f64::from(k) / f64::from(samples);
                let here = geometry.at(shares[0] + width * share);
                let there = moved(kinematics, control, pair, share);
                let (Some(here), Some(there)) = (here, there) else { return [f64::INFINITY; 2] };
                off[0] = off[0].max((here.tip - there.tip).norm());
                off[1] = off[1].max((*here.axis - *there.axis).norm());
            }
            // Closer samples shrink what bends between them by the square of their number.
            let square = f64::from(samples * samples);
            let tip = off[0] + curved[0] / square;
            let bound = [tip, angle_of(off[1] + curved[1] / square)];
            let fits = enough.is_some_and(|most| bound[0] <= most[0] && bound[1] <= most[1]);
            // A sample beyond the tolerance settles it: more of them cannot lower the bound below it.
            let hopeless = enough.is_some_and(|most| off[0] > most[0] || off[1] > most[1]);
            if fits || hopeless || samples >= MOST_SAMPLES {
                return bound;
            }
            samples *= 2;
        }
    }

    /// Runs from one point to another as the target control does, in blocks whose tip stays straight.
    fn run_directly(
        &mut self,
        ends: [MachinePoint; 2],
        share: f64,
        target_move: &mut DividedMove<'_>,
    ) -> Result<(), PostError> {
        let [from, to] = ends;
        // Step 1: number of blocks, by the largest turn and by the bow of the tip.
        let turns = (to.q - from.q).fixed_rows::<2>(FIRST_ROTARY).abs();
        let mut blocks = (turns.amax() / self.most_turn).ceil().max(1.0);
        let pair = [BlockEnd::new(&from.q, &from.pose), BlockEnd::new(&to.q, &to.pose)];
        if self.target.control == BlockInterpolation::Axes && !target_move.same {
            let tolerance =
                if target_move.rapid { RAPID_TOLERANCE } else { target_move.tolerance[0] };
            let bow =
                0.125 * bend(self.target.inverse.kinematics(), BlockInterpolation::Axes, pair)[0];
            // A bow falls with the square of the number of blocks.
            let count = (bow / tolerance).sqrt().ceil();
            blocks = blocks.max(count);
            if target_move.rapid {
                self.note_rapid([bow / (blocks * blocks), 0.0]);
            } else {
                self.strayed[0] = self.strayed[0].max(target_move.bowed + bow / (blocks * blocks));
            }
        }
        if blocks > f64::from(MOST_PARTS) {
            return Err(PostError::Strays {
                line: target_move.line,
                strayed: [f64::INFINITY, 0.0].into(),
                tolerance: self.tolerance.into(),
            });
        }
        // Step 2: points inside each block, where the axes curve.
        let points = match self.target.control {
            BlockInterpolation::Axes => 1.0,
            // Points inside a block let the planner see how the linear axes curve while the rotaries turn.
            _ => (turns.sum() / blocks / TURN).ceil().max(1.0),
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let [blocks, points] = [blocks, points].map(|count| count as u32);
        let parts = blocks * points;
        let mut before = from;
        for part in 1..=parts {
            let point = if part == parts {
                to
            } else {
                self.inside(pair, f64::from(part) / f64::from(parts), target_move, &before.q)?
            };
            let end = if part.is_multiple_of(points) { PartEnd::Block } else { PartEnd::Inside };
            target_move.push(&before, &point, end, share / f64::from(parts));
            before = point;
        }
        Ok(())
    }

    /// Returns the position of the control inside a block: tip straight, rotaries linear or tool on a great circle.
    fn inside(
        &self,
        pair: [BlockEnd<'_>; 2],
        share: f64,
        target_move: &DividedMove<'_>,
        near: &AxisVector,
    ) -> Result<MachinePoint, PostError> {
        let inverse = &self.target.inverse;
        let kinematics = inverse.kinematics();
        match self.target.control {
            BlockInterpolation::GreatCircle => {
                let pose = moved(kinematics, BlockInterpolation::GreatCircle, pair, share);
                let pose = pose.ok_or(PostError::Reversal { line: target_move.line })?;
                let found = inverse.near(&pose, near);
                let q = found.map_err(|error| PostError::reach(target_move.line, error))?;
                Ok(MachinePoint { q, pose, source: q })
            }
            BlockInterpolation::Axes if target_move.same => {
                let q = pair[0].q.lerp(pair[1].q, share);
                Ok(MachinePoint { q, pose: kinematics.forward(&q), source: q })
            }
            _ => self.slid(pair, share, target_move.line),
        }
    }

    /// Returns the position at a share of a move with a straight tip and linear rotaries.
    fn slid(
        &self,
        pair: [BlockEnd<'_>; 2],
        share: f64,
        line: u32,
    ) -> Result<MachinePoint, PostError> {
        let inverse = &self.target.inverse;
        // Rotaries at their share; the linear axes follow from the tip on its straight line.
        let mixed = pair[0].q.lerp(pair[1].q, share);
        let tip = pair[0].pose.tip + (pair[1].pose.tip - pair[0].pose.tip) * share;
        let turns = RotaryPair::new(mixed[FIRST_ROTARY], mixed[SECOND_ROTARY]);
        let q = inverse.at_rotaries(&tip, turns).map_err(|error| PostError::reach(line, error))?;
        Ok(MachinePoint { q, pose: inverse.kinematics().forward(&q), source: q })
    }
}

/// Bounds the angle of a chord between unit vectors from above: `2 asin(c/2) <= c (1 + c²/20)` for chords up to 1.
fn angle_of(chord: f64) -> f64 {
    if chord > 1.0 { f64::INFINITY } else { chord * (1.0 + 0.05 * chord * chord) }
}
