//! What a program makes the tool do: steps to moves. Forward map, and an inverse for tool vectors.

mod tools;

use super::error::{PostError, PostRemedy};
use super::options::{PostMove, PostPace};
use crate::blocks::BlockInterpolation;
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::math::jet::{Jet, Real};
use crate::nc::read::{Frame, Move, Pace, Step, Turning, Way};
use crate::nc::write::work_offset;
use crate::types::{AXES, AxisVector, ToolPose};
use nalgebra::{Isometry3, Point3, UnitVector3, Vector3};
use tools::inverses;

/// Most straight moves for one arc.
const MOST_PARTS: u32 = 65_535;

/// Where a control stands, and what its program makes the tool do.
///
/// The work offset is taken to hold the workpiece origin, as in the setup sheets of this crate: whichever of G54 to
/// G59.3 the program uses, as long as it is one. Moves before all of X, Y and Z were commanded are how the machine
/// gets to the part, and moves in machine coordinates (`G53`) before and after all others are how it gets away:
/// they are left out.
#[derive(Debug)]
pub struct ProgramMoves {
    /// With the tool, and without.
    inverse: [Inverse; 2],
    offset: Vector3<f64>,
    /// Distance that straight moves may keep from arcs \[mm\].
    arc_tolerance: f64,
    q: AxisVector,
    /// Which of X Y Z are known, by words.
    known: [bool; 3],
    started: bool,
    work: Option<u8>,
    tool: Option<u32>,
    /// The only tool whose moves are wanted, and how far the program is with it.
    only: Option<(u32, Turn)>,
    /// Tools that may be called, and their lengths \[mm\]; none: one tool, whose length is that of the setup.
    lengths: Vec<(u32, f64)>,
    /// The last tilted plane: its number, and from its coordinates to those without it.
    plane: (u16, Isometry3<f64>),
    /// Moves in machine coordinates, of which is not known yet whether others follow.
    away: Vec<PostMove>,
    /// Left out: moves at the start, dwells, and lines of words.
    left: Left,
    /// Spindle speed, clockwise positive \[1/min\].
    spindle: f64,
}

/// Where a program is with the tool that is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    Before,
    Now,
    Over,
}

/// What was read and does not show in moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Left {
    /// Moves before the starting position, and in machine coordinates at the end.
    pub moves: usize,
    /// Dwells.
    pub dwells: usize,
    /// Lines of words without motion: coolant, stops, smoothing.
    pub words: usize,
}

/// A position by the words of a frame.
#[derive(Debug, Clone, Copy)]
struct Words {
    values: [f64; AXES],
    tcp: bool,
    length: bool,
    /// From the coordinates of X Y Z to those without tilted plane.
    plane: Isometry3<f64>,
}

impl ProgramMoves {
    /// Starts with the machine at home.
    ///
    /// # Errors
    ///
    /// [`PostError::Reach`], [`PostError::Write`] for a setup without numbers or work offset.
    pub fn new(kinematics: &Kinematics, arc_tolerance: f64) -> Result<Self, PostError> {
        let offset = work_offset(kinematics).ok_or(crate::nc::write::WriteError::WorkOffset)?;
        Ok(Self {
            inverse: inverses(kinematics)?,
            offset,
            arc_tolerance,
            q: kinematics.machine().home(),
            known: [false; 3],
            started: false,
            work: None,
            tool: None,
            only: None,
            lengths: Vec::new(),
            plane: (0, Isometry3::identity()),
            away: Vec::new(),
            left: Left::default(),
            spindle: 0.0,
        })
    }

    /// Takes only the moves of one tool, for which the tool length of the setup is.
    #[must_use]
    pub fn only(self, tool: u32) -> Self {
        Self { only: Some((tool, Turn::Before)), ..self }
    }

    /// Takes the moves of all these tools, each with its own length \[mm\]. They begin anew where a tool is first told
    /// X, Y and Z; ways to and from the change are left out.
    #[must_use]
    pub fn with_lengths(self, lengths: &[(u32, f64)]) -> Self {
        Self { lengths: lengths.to_vec(), ..self }
    }

    /// The machine with the tool that is in the spindle.
    pub fn kinematics(&self) -> &Kinematics {
        self.inverse[0].kinematics()
    }

    /// Axes as they stand.
    pub fn axes(&self) -> AxisVector {
        self.q
    }

    /// Number of the tool in the spindle, if the program says.
    pub fn tool(&self) -> Option<u32> {
        self.tool
    }

    /// Spindle speed \[1/min\]; 0 if it does not turn.
    pub fn spindle(&self) -> f64 {
        self.spindle
    }

    /// Where the tool is.
    pub fn pose(&self) -> ToolPose {
        self.inverse[0].kinematics().forward(&self.q)
    }

    /// What was left out so far.
    pub fn left(&self) -> Left {
        let mut left = self.left;
        left.moves += self.away.len();
        left
    }

    /// Takes in a step; the moves it makes are appended.
    ///
    /// # Errors
    ///
    /// [`PostError::Refused`] for what cannot be posted, with what to do; [`PostError::Reach`].
    pub fn step(&mut self, step: &Step, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        match step {
            Step::Move(one) => return self.go(one, out),
            Step::Dwell { .. } => self.left.dwells += 1,
            Step::Words { .. } => self.left.words += 1,
            Step::Spindle { speed, .. } => {
                let over = self.only.is_some_and(|(_, turn)| turn == Turn::Over);
                if *speed != 0.0 && !over {
                    self.spindle = *speed;
                }
            }
            Step::Tool { line, number } => return self.change(*line, *number),
            Step::Offset(of) => {
                let help =
                    "enter the work offset at the control, and give the origin with --from-origin";
                return Err(refused(of.line, "a work offset written by the program", help));
            }
            Step::Plane(of) => self.plane = (of.number, of.work_from_plane),
        }
        Ok(())
    }

    fn go(&mut self, one: &Move, out: &mut Vec<PostMove>) -> Result<(), PostError> {
        if self.is_wanted() && one.sixth.is_some() {
            return Err(refused(one.line, "a sixth axis", "only five axes are posted"));
        }
        let (tcp, length) = match one.frame {
            Frame::Machine => return self.go_in_machine(one),
            Frame::Work { offset, length, tcp } => {
                if self.is_wanted() && *self.work.get_or_insert(offset) != offset {
                    let help = "post the parts of the program with one work offset each";
                    return Err(refused(one.line, "a second work offset", help));
                }
                (tcp, length)
            }
        };
        for (known, word) in self.known.iter_mut().zip(one.words) {
            *known |= word.is_some() && !one.incremental;
        }
        if self.is_wanted() {
            out.append(&mut self.away);
        }
        let plane = if one.plane == self.plane.0 { self.plane.1 } else { Isometry3::identity() };
        let from = self.words((tcp, length), plane);
        let to = end_of(from, one);
        let parts = match one.way {
            Way::Line => 1,
            Way::Arc(arc) => arc.parts(self.arc_tolerance).min(MOST_PARTS),
        };
        let travel = length_of(one, &from, &to);
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let mut at = to;
            if part < parts {
                for (value, (a, b)) in at.values.iter_mut().zip(from.values.iter().zip(to.values)) {
                    *value = a + share * (b - a);
                }
                if let Way::Arc(arc) = one.way {
                    for (axis, by) in arc.plane.into_iter().zip(arc.at(share)) {
                        if let (Some(value), Some(start)) =
                            (at.values.get_mut(axis), from.values.get(axis))
                        {
                            *value = start + by;
                        }
                    }
                }
            }
            let before = self.q;
            let pose = match self.take(one, &at) {
                Ok(pose) => pose,
                // Where another tool goes does not matter.
                Err(_) if !self.is_wanted() => return Ok(()),
                Err(error) => return Err(error),
            };
            let pace = self.pace(one, travel / f64::from(parts), &before, tcp);
            self.push(one, pose, pace, (tcp, out));
        }
        Ok(())
    }

    /// `G53`: axis positions. Kept back until it is known whether the program goes on.
    fn go_in_machine(&mut self, one: &Move) -> Result<(), PostError> {
        for (value, word) in self.q.iter_mut().zip(one.words) {
            *value = word.unwrap_or(*value);
        }
        if one.pace != Pace::Rapid {
            let what = "a move with feed in machine coordinates";
            return Err(refused(one.line, what, "program it in a work offset"));
        }
        if self.started && self.is_wanted() {
            let pose = self.inverse[0].kinematics().forward(&self.q);
            let (line, q) = (one.line, Some(self.q));
            self.away.push(PostMove {
                line,
                pose,
                q,
                pace: PostPace::Rapid,
                way: BlockInterpolation::Axes,
            });
        } else {
            self.left.moves += 1;
        }
        Ok(())
    }

    fn push(
        &mut self,
        one: &Move,
        pose: ToolPose,
        pace: PostPace,
        (tcp, out): (bool, &mut Vec<PostMove>),
    ) {
        if !self.is_wanted() || (!self.started && self.known != [true; 3]) {
            self.left.moves += 1;
            return;
        }
        self.started = true;
        let way = match (tcp, one.turning) {
            (false, _) => BlockInterpolation::Axes,
            (true, Turning::Rotary) => BlockInterpolation::RotaryLinear,
            (true, Turning::GreatCircle) => BlockInterpolation::GreatCircle,
        };
        out.push(PostMove { line: one.line, pose, q: Some(self.q), pace, way });
    }

    /// Present position by the words of a frame.
    fn words(&self, (tcp, length): (bool, bool), plane: Isometry3<f64>) -> Words {
        let mut values: [f64; AXES] = self.q.into();
        let linear = if tcp {
            let kinematics = self.of(length).kinematics();
            let tip = kinematics.setup().rotation * kinematics.forward(&self.q).tip;
            plane.inverse_transform_point(&tip).coords
        } else {
            self.q.fixed_rows::<3>(0) - self.shift(length)
        };
        values[..3].copy_from_slice(linear.as_slice());
        Words { values, tcp, length, plane }
    }

    /// Moves the axes to a position; the pose of the tool there.
    fn take(&mut self, one: &Move, to: &Words) -> Result<ToolPose, PostError> {
        let [x, y, z, first, second] = to.values;
        let point = Vector3::new(x, y, z);
        if to.tcp {
            let inverse = self.of(to.length);
            let back = inverse.kinematics().setup().rotation.inverse();
            let tip = back * to.plane.transform_point(&Point3::from(point)).coords;
            let reach = |error| PostError::reach(one.line, error);
            self.q = if let Some(axis) = one.axis {
                let axis = UnitVector3::new_normalize(back * axis.into_inner());
                let pose = ToolPose { tip: Point3::from(tip), axis };
                match inverse.near_inside(&pose, &self.q) {
                    // Before the program has said where the tool is, it stands anywhere.
                    Err(_) if !self.started => inverse.near(&pose, &self.q).map_err(reach)?,
                    found => found.map_err(reach)?,
                }
            } else {
                let still = Vector3::zeros();
                let turns = [first, second].map(<Jet as Real>::constant);
                inverse.with_rotaries(&[tip, still, still, still], turns).map_err(reach)?[0]
            };
        } else if let Some(axis) = one.axis {
            // The tool turns to a plane; the linear axes stand.
            let inverse = self.of(to.length);
            let axis = inverse.kinematics().setup().rotation.inverse() * axis.into_inner();
            let axis = UnitVector3::new_normalize(axis);
            let pose = ToolPose { axis, ..inverse.kinematics().forward(&self.q) };
            // Whether the tip could stay where it is does not matter.
            let found =
                inverse.near_inside(&pose, &self.q).or_else(|_| inverse.near(&pose, &self.q));
            let found = found.map_err(|error| PostError::reach(one.line, error))?;
            let turns = found.fixed_rows::<2>(FIRST_ROTARY).into_owned();
            self.q.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from(&turns);
        } else {
            let linear = point + self.shift(to.length);
            self.q = AxisVector::from([linear.x, linear.y, linear.z, first, second]);
        }
        Ok(self.inverse[0].kinematics().forward(&self.q))
    }

    fn pace(&self, one: &Move, travel: f64, before: &AxisVector, tcp: bool) -> PostPace {
        let turn = (self.q - before).fixed_rows::<2>(FIRST_ROTARY).norm();
        match one.pace {
            Pace::Rapid => PostPace::Rapid,
            Pace::Inverse { seconds } => {
                let parts = if let Way::Arc(arc) = one.way {
                    arc.parts(self.arc_tolerance).min(MOST_PARTS)
                } else {
                    1
                };
                PostPace::Seconds(seconds / f64::from(parts))
            }
            Pace::PerMinute { speed } if travel > 0.0 && tcp => PostPace::Feed(speed),
            Pace::PerMinute { speed } if travel > 0.0 => PostPace::Seconds(travel / speed),
            Pace::PerMinute { speed } => PostPace::Seconds(turn.to_degrees() / speed),
        }
    }

    fn of(&self, length: bool) -> &Inverse {
        let [with, without] = &self.inverse;
        if length { with } else { without }
    }

    fn shift(&self, length: bool) -> Vector3<f64> {
        let long = self.inverse[0].kinematics().setup().tool_length;
        self.offset + Vector3::z() * if length { long } else { 0.0 }
    }
}

/// Where a move leads to from a position.
fn end_of(from: Words, one: &Move) -> Words {
    let mut to = from;
    for (value, word) in to.values.iter_mut().zip(one.words) {
        *value = match word {
            Some(word) if one.incremental => *value + word,
            Some(word) => word,
            None => *value,
        };
    }
    to
}

/// Way of X Y Z \[mm\].
fn length_of(one: &Move, from: &Words, to: &Words) -> f64 {
    let by =
        |axis: usize| to.values.get(axis).unwrap_or(&0.0) - from.values.get(axis).unwrap_or(&0.0);
    match one.way {
        Way::Line => Vector3::new(by(0), by(1), by(2)).norm(),
        Way::Arc(arc) => {
            let across = (0..3).filter(|axis| !arc.plane.contains(axis)).map(by).sum::<f64>();
            (arc.radius() * arc.sweep).hypot(across)
        }
    }
}

fn refused(line: u32, what: &'static str, remedy: impl Into<PostRemedy>) -> PostError {
    PostError::Refused { line, what, remedy: remedy.into() }
}
