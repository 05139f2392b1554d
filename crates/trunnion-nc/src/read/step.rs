//! Steps of a program, the same for every dialect.

use crate::math;
use crate::types::{AXES, AxisVector};
use nalgebra::{Isometry3, UnitVector3};

/// Steps of the control, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Everything in order.
    pub steps: Vec<Step>,
    /// Largest rounding error of each axis word \[mm, rad\]: half of the last digit that the text
    /// uses anywhere on that axis.
    pub rounding: AxisVector,
    /// Half of the last digit of the feed words, in their own unit (mm/min or 1/min).
    pub feed_rounding: f64,
    /// Numbers of the tools called, in order.
    pub tools: Vec<u32>,
    /// Warnings: words kept but not understood, and likely slips.
    pub warnings: Vec<crate::types::Diagnostic>,
}

/// One thing a program does.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// A block that moves axes.
    Move(Move),
    /// `G4`.
    Dwell {
        /// Line, counted from 1.
        line: u32,
        /// Time \[s\].
        seconds: f64,
    },
    /// A tool goes into the spindle: `M6`, `TOOL CALL`.
    Tool {
        /// Line, counted from 1.
        line: u32,
        /// Its number.
        number: u32,
    },
    /// The spindle turns, or stops.
    Spindle {
        /// Line, counted from 1.
        line: u32,
        /// Speed \[1/min\]; clockwise positive, 0: it stops.
        speed: f64,
    },
    /// From here on the control may leave the programmed path.
    Smoothing {
        /// Line, counted from 1.
        line: u32,
        /// Distance from the path that it may take.
        smoothing: Smoothing,
    },
    /// An entry of the table of tool lengths is chosen: `H2` beside `G43`, `D2` at Siemens.
    LengthEntry {
        /// Line, counted from 1.
        line: u32,
        /// The entry.
        entry: LengthEntry,
    },
    /// A work offset is written: `G10 L2`, `G10 L20`.
    Offset(Offset),
    /// A tilted plane that later moves name by its number.
    Plane(Plane),
    /// The next move is that of a probe: its end is where it stops without contact.
    Probe {
        /// Line, counted from 1.
        line: u32,
    },
    /// Words without motion, kept as they stand: coolant, smoothing, stops, messages.
    Words {
        /// Line, counted from 1.
        line: u32,
        /// As written.
        text: Box<str>,
    },
}

/// One block that moves axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Line, counted from 1.
    pub line: u32,
    /// Column of the first axis word in characters, counted from 1.
    pub column: u32,
    /// Word of the block for each axis \[mm, rad\]; `None`: nothing.
    pub words: [Option<f64>; AXES],
    /// An axis beyond the machine's five, if [`ReadOptions::sixth`](super::ReadOptions::sixth)
    /// allows one: its letter, and its word \[mm, rad\].
    pub sixth: Option<(char, f64)>,
    /// The words are distances from where the axes stand (`G91`); `axis` never is.
    pub incremental: bool,
    /// Frame of the words.
    pub frame: Frame,
    /// Number of the tilted plane ([`Step::Plane`]) whose coordinates X Y Z are; 0: none.
    pub plane: u16,
    /// Direction of the tool axis (tip to spindle) in the coordinates without tilted plane, instead
    /// of rotary words: `A3= B3= C3=`, `TX TY TZ`, `I J K` of `G43.5`, the normal of a plane at `G53.1`.
    pub axis: Option<UnitVector3<f64>>,
    /// Speed or time of the move.
    pub pace: Pace,
    /// On which way the linear axes, or the tip, get there.
    pub way: Way,
    /// Interpolation of the tool axis.
    pub turning: Turning,
}

/// Frame of axis words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// `G53`: axis positions.
    Machine,
    /// A work offset.
    Work {
        /// 0 for `G54`, 1 for `G55` and so on.
        offset: u8,
        /// `G43`: the tool length counts.
        length: bool,
        /// Tool-centre-point control: X Y Z are the tip.
        tcp: bool,
    },
}

/// Speed or time of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// `G0`.
    Rapid,
    /// `G93 G1 F`: the block takes this long \[s\].
    Inverse {
        /// Time of the block \[s\].
        seconds: f64,
    },
    /// `G94 G1 F`: speed \[mm/s\] of X Y Z; of the rotaries \[deg/s\] if X Y Z stand still.
    PerMinute {
        /// mm/s, or deg/s.
        speed: f64,
    },
}

/// The way of the three linear words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// Straight.
    Line,
    /// A circle or helix: the words of [`Move`] are its end.
    Arc(Arc),
}

/// An arc about an axis parallel to a coordinate axis; along that axis, and of the rotaries, the way is
/// linear in the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Indices of the two of X Y Z that span the plane, so that the positive sense turns the first into the second.
    pub plane: [usize; 2],
    /// From where the arc begins to its centre \[mm\], in the two words of the plane.
    pub center: [f64; 2],
    /// Angle run through \[rad\]: positive is `G3`, whole turns included.
    pub sweep: f64,
}

/// Interpolation of the tool axis within a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turning {
    /// Rotary axes linear: without TCP together with the linear axes, with TCP together with the tip.
    Rotary,
    /// The tool axis stays in the plane of its two ends and turns at an even rate: `ORIVECT`,
    /// `PATHCTRL VECTOR`, `G43.4 P1`.
    GreatCircle,
}

/// Distance that a control may keep from the programmed path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Smoothing {
    /// None: it passes exactly through the ends of blocks, and stops where the direction changes (`G61`, `G60`).
    Exact,
    /// None: it stops at the end of every block (`G61.1`).
    Stop,
    /// As far as stated \[mm\]: `CYCLE832`, `CYCL DEF 32`, `G187 E`.
    Within(f64),
    /// `G64` of `LinuxCNC`: lines are joined before corners are rounded, and both distances add up.
    Blended {
        /// Distance within which corners are rounded, P \[mm\].
        corners: f64,
        /// Distance within which lines are joined, Q \[mm\].
        lines: f64,
    },
    /// As far as speed demands: `G64` of `LinuxCNC` without P.
    Unbounded,
    /// The setting of the machine, which no program states.
    OfMachine,
}

impl Smoothing {
    /// Returns the largest distance from the programmed path \[mm\]; `None` where the program states no bound.
    pub fn bound(self) -> Option<f64> {
        match self {
            Self::Exact | Self::Stop => Some(0.0),
            Self::Within(distance) => Some(distance),
            Self::Blended { corners, lines } => Some(corners + lines),
            Self::Unbounded | Self::OfMachine => None,
        }
    }
}

/// Entry of a table of tool lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthEntry {
    /// A row of the table (`H2`), which has the number of its tool by custom.
    Row(u32),
    /// An edge of the tool in the spindle (`D2`); the first is the tool's own, 0 none.
    Edge(u32),
}

/// A work offset that the program writes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// Line, counted from 1.
    pub line: u32,
    /// 0 for `G54`, 1 for `G55` and so on.
    pub offset: u8,
    /// Values \[mm, rad\]; `None`: this axis stays.
    pub words: [Option<f64>; AXES],
    /// Kind of the values.
    pub kind: OffsetKind,
}

/// Kind of the values of an [`Offset`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OffsetKind {
    /// Axis positions of the origin (`G10 L2`).
    Origin,
    /// Words that the present position shall read as (`G10 L20`).
    Reading,
    /// Words that the present position is taken to read as, since the program states none before it sets
    /// coordinates (`G92` at its start): the offset stays.
    Standing,
}

/// A plane tilted about the work offset: `G68.2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Line, counted from 1.
    pub line: u32,
    /// Number by which [`Move::plane`] refers to it, counted from 1.
    pub number: u16,
    /// From its coordinates to those without it \[mm\].
    pub work_from_plane: Isometry3<f64>,
}

impl Move {
    /// Names the first feature beyond five straight axis words that a consumer cannot ignore.
    pub fn special(&self) -> Option<&'static str> {
        // Each of these changes the path of the tool, so that leaving it out would be wrong.
        match self {
            Self { sixth: Some(_), .. } => Some("a sixth axis"),
            Self { plane: 1.., .. } => Some("a tilted plane"),
            Self { axis: Some(_), .. } => Some("a tool-axis vector"),
            Self { way: Way::Arc(_), .. } => Some("an arc"),
            Self { turning: Turning::GreatCircle, .. } => Some("tool axes turned on great circles"),
            _ => None,
        }
    }
}

impl Arc {
    /// Returns the radius \[mm\].
    pub fn radius(&self) -> f64 {
        math::hypot(self.center[0], self.center[1])
    }

    /// Returns the point after the share `t` of the sweep, relative to the start of the arc \[mm\].
    pub fn at(&self, t: f64) -> [f64; 2] {
        // With the start as origin the radius is -c, and the point c + R(t sweep)(-c) = c - R c.
        let (sin, cos) = math::sin_cos(t * self.sweep);
        let [u, v] = self.center;
        [u - (u * cos - v * sin), v - (u * sin + v * cos)]
    }

    /// Returns the number of equal parts whose chords stay within `tolerance` \[mm\] of the arc; at
    /// least one.
    ///
    /// A chord over the angle `a` is off by `r (1 - cos(a / 2)) <= r a^2 / 8`.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_nc::read::Arc;
    ///
    /// // A half circle of radius 10 mm.
    /// let arc = Arc { plane: [0, 1], center: [10.0, 0.0], sweep: std::f64::consts::PI };
    /// assert_eq!(arc.parts(0.01), 36);
    /// assert!((arc.at(1.0)[0] - 20.0).abs() < 1e-12);
    /// ```
    pub fn parts(&self, tolerance: f64) -> u32 {
        // r (sweep / n)^2 / 8 <= tolerance, solved for n.
        let parts = self.sweep.abs() * (self.radius() / (8.0 * tolerance)).sqrt();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let parts = parts.ceil() as u32;
        parts.max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn an_arc_runs_about_its_centre() {
        let arc = Arc { plane: [0, 1], center: [-2.0, 0.0], sweep: FRAC_PI_2 };
        let [x, y] = arc.at(1.0);
        assert!((x + 2.0).abs() < 1e-15 && (y - 2.0).abs() < 1e-15);
        assert!((arc.radius() - 2.0).abs() < 1e-15);
    }

    #[test]
    fn chords_stay_within_the_tolerance() {
        let arc = Arc { plane: [0, 1], center: [30.0, 40.0], sweep: -3.0 * PI };
        let parts = arc.parts(0.01);
        let half = 0.5 * arc.sweep.abs() / f64::from(parts);
        assert!(50.0 * (1.0 - half.cos()) <= 0.01);
        assert!(50.0 * (1.0 - (1.1 * half).cos()) > 0.01, "not finer than needed");
    }
}
