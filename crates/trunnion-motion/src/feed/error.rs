//! Errors of paths, limits and options.

use crate::types::Cancelled;
use std::fmt;

/// Kind of limit that an error is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// Axis velocity while cutting.
    Velocity,
    /// Axis velocity on links.
    Rapid,
    /// Axis acceleration.
    Acceleration,
    /// Axis jerk.
    Jerk,
}

impl fmt::Display for LimitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Velocity => "velocity",
            Self::Rapid => "rapid velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        })
    }
}

/// Writes a number without hundreds of zeros.
fn brief(value: f64) -> String {
    let plain = value == 0.0 || !value.is_finite() || (1e-6..1e9).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

/// Reasons why no schedule was planned. Pieces, nodes and axes count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FeedError {
    /// A limit is missing (infinite), zero, negative, not a number, or too large or small to compute with.
    #[error(
        "{kind} limit of axis {axis} is {}; it must be finite and positive, between 1e-24 and 1e150 (mm, rad, s)",
        brief(*value)
    )]
    BadLimit {
        /// Kind of limit.
        kind: LimitKind,
        /// Index of the axis.
        axis: usize,
        /// Value given.
        value: f64,
    },
    /// A jerk-limited schedule needs jerk limits.
    #[error("no jerk limits are given, and the method keeps them")]
    NoJerkLimit,
    /// The feed, link feed or tip speed is zero, negative, infinite, not a number, or too large or small to compute
    /// with.
    #[error(
        "{name} is {} mm/s; it must be finite and positive, between 1e-24 and 1e150, or absent for no limit",
        brief(*value)
    )]
    BadFeed {
        /// Name of the field of [`ProgrammedSpeeds`](super::ProgrammedSpeeds).
        name: &'static str,
        /// Value given.
        value: f64,
    },
    /// The time tolerance is not positive.
    #[error("time tolerance is {value}; it must be positive")]
    BadTolerance {
        /// Value given.
        value: f64,
    },
    /// A speed at the ends of the path is negative, infinite or not a number.
    #[error("{name} speed is {value}; it must be finite and not negative (s per second)")]
    BadEnd {
        /// `start` or `end`.
        name: &'static str,
        /// Value given.
        value: f64,
    },
    /// The path does not allow the speed it is to start with.
    #[error("start speed {speed} is above what the path allows, {most}")]
    StartTooFast {
        /// Speed asked for.
        speed: f64,
        /// Largest speed at the start from which the limits can be kept; with jerk limits a speed for
        /// which a schedule was found.
        most: f64,
    },
    /// The speed asked for at the end cannot be reached, or is not allowed there.
    #[error("end speed {speed} is above what can be had at the end of the path, {most}")]
    EndTooFast {
        /// Speed asked for.
        speed: f64,
        /// Largest speed within the limits; with jerk limits one for which a schedule was found.
        most: f64,
    },
    /// An acceleration at the ends of the path is not a number, or there without a speed.
    #[error(
        "{name} acceleration is {value} at speed {speed}; it must be finite, and 0 at rest \
         (s per second squared)"
    )]
    BadEndAcceleration {
        /// `start` or `end`.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Speed there.
        speed: f64,
    },
    /// A chord error or the servo period it is meant for is not positive.
    #[error(
        "chord error of axis {axis} is {value} at a period of {period} s; both must be positive, and \
         the error infinite for no limit"
    )]
    BadChord {
        /// Index of the axis.
        axis: usize,
        /// Error given.
        value: f64,
        /// Period given.
        period: f64,
    },
    /// A speed limit of a node is zero, negative or not a number.
    #[error("piece {piece}, node {node}: speed limit {value}; it must be positive (s per second)")]
    BadSpeedLimit {
        /// Index of the piece.
        piece: usize,
        /// Index of the node.
        node: usize,
        /// Value given.
        value: f64,
    },
    /// A piece has less than two nodes.
    #[error("piece {piece} has {nodes} node(s); at least two are needed")]
    TooFewNodes {
        /// Index of the piece.
        piece: usize,
        /// Nodes it has.
        nodes: usize,
    },
    /// The path parameter does not increase.
    #[error("piece {piece}, node {node}: s = {s} does not increase from {before}")]
    NotIncreasing {
        /// Index of the piece.
        piece: usize,
        /// Index of the node.
        node: usize,
        /// Its path parameter.
        s: f64,
        /// Path parameter of the node before.
        before: f64,
    },
    /// A coordinate or derivative is infinite or not a number.
    #[error(
        "piece {piece}, node {node}: derivative {order} of axis {axis} is {value}; \
         it must be finite"
    )]
    NotFinite {
        /// Index of the piece.
        piece: usize,
        /// Index of the node.
        node: usize,
        /// Index of the axis.
        axis: usize,
        /// Order of the derivative; 0 is the position.
        order: usize,
        /// The value.
        value: f64,
    },
    /// A number of the path is too large to compute with.
    #[error("piece {piece}, node {node}: {name} is {value:e}; it must be at most 1e24 in size")]
    TooLarge {
        /// Index of the piece.
        piece: usize,
        /// Index of the node.
        node: usize,
        /// `s`, `position`, `derivative` or the name of a rate.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The numbers of a piece are so far apart, or so close together, that rounding leaves no schedule.
    #[error(
        "piece {piece}: no schedule can be computed; its numbers are too far apart, or its rows too close together \
         beside s"
    )]
    Unresolved {
        /// Index of the piece.
        piece: usize,
    },
    /// A tip or feed rate is negative, infinite or not a number.
    #[error("piece {piece}, node {node}: {name} is {value}; it must be finite and not negative")]
    BadRate {
        /// Index of the piece.
        piece: usize,
        /// Index of the node.
        node: usize,
        /// `tip_rate` or `feed_rate`.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// An option of the block-wise planner makes no sense.
    #[error("{name} is {value}; it must be finite and positive")]
    BadBlockOption {
        /// Name of the option.
        name: &'static str,
        /// Value given.
        value: f64,
    },
    /// A move is infinite or not a number.
    #[error("move {index}: axis {axis} moves by {value}; it must be finite")]
    BadMove {
        /// Index of the move.
        index: usize,
        /// Index of the axis.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// The number of given speeds is not that of the pieces.
    #[error("the path has {path} piece(s), but speeds are given for {given}")]
    GivenPieces {
        /// Pieces of the path.
        path: usize,
        /// Lists given.
        given: usize,
    },
    /// A row of a given speed makes no sense.
    #[error(
        "piece {piece}, row {row} of the given speeds: s = {s} after {before}, speed {speed}; \
         s must increase, speeds be finite and not negative"
    )]
    GivenRow {
        /// Index of the piece.
        piece: usize,
        /// Index of the row.
        row: usize,
        /// Its path parameter.
        s: f64,
        /// Path parameter of the row before.
        before: f64,
        /// Its speed.
        speed: f64,
    },
    /// Given speeds do not cover their piece.
    #[error(
        "piece {piece} runs from s = {from} to {to}, but its {} path parameters and {} speeds are given \
         from {first} to {last}",
        .rows[0], .rows[1]
    )]
    GivenCover {
        /// Index of the piece.
        piece: usize,
        /// Start of the piece.
        from: f64,
        /// Its end.
        to: f64,
        /// First path parameter given.
        first: f64,
        /// Last path parameter given.
        last: f64,
        /// Numbers of path parameters and of speeds.
        rows: [usize; 2],
    },
    /// A given speed is zero where the path goes on: the end would never be reached.
    #[error(
        "piece {piece}: the given speed is zero from s = {from} to {to}, where the path goes on"
    )]
    GivenStop {
        /// Index of the piece.
        piece: usize,
        /// Start of the interval.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// The window of a stream is too short, or its step is not positive.
    #[error(
        "the window is {window} rows and the largest step {step}; at least 4 rows and a finite, \
         positive step are needed"
    )]
    BadWindow {
        /// Rows asked for.
        window: usize,
        /// Largest step asked for.
        step: f64,
    },
    /// An override is out of range.
    #[error("override is {value}; it must be from 0 (hold) to 2 (200 %)")]
    BadOverride {
        /// Value given.
        value: f64,
    },
    /// The caller cancelled the plan.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FeedError {
    /// Returns what to change so that a schedule can be planned; `None` if the reason alone says it.
    pub fn remedy(&self) -> Option<&'static str> {
        Some(match self {
            Self::BadLimit { .. } => {
                "state the limit of the machine; a large one for an axis that never binds"
            }
            Self::NoJerkLimit => "give one for every axis, or plan without jerk limits",
            Self::BadFeed { .. } => "give a speed above 0, or leave it out for no limit",
            Self::BadTolerance { .. } => "give 1e-3, for instance",
            Self::BadEnd { .. } => "give 0 for a path that starts and ends at rest",
            Self::StartTooFast { .. } => {
                "start slower, or raise the limits that bind near the start"
            }
            Self::EndTooFast { .. } => "end slower, or raise the limits that bind",
            Self::BadEndAcceleration { .. } => "give 0",
            Self::BadChord { .. } => {
                "give the servo period of the control, and no chord error for no limit"
            }
            Self::BadSpeedLimit { .. } => {
                "give a speed above 0, and end the piece where the path is to rest"
            }
            Self::TooFewNodes { .. } => "leave the piece out",
            Self::NotIncreasing { .. } => "remove repeated nodes, and sort the rest",
            Self::TooLarge { .. } => "choose larger units",
            Self::Unresolved { .. } => {
                "let s begin near 0, and use units in which limits and path are of like size"
            }
            Self::GivenPieces { .. } => "give one list a piece",
            Self::GivenRow { .. } => "sort the rows, and leave out those that repeat s",
            Self::GivenCover { .. } => "give at least two rows that cover the piece",
            Self::GivenStop { .. } => "give a speed there",
            Self::BadWindow { .. } => "take 512 rows and 0.5 mm, for instance",
            Self::NotFinite { .. }
            | Self::BadRate { .. }
            | Self::BadBlockOption { .. }
            | Self::BadMove { .. }
            | Self::BadOverride { .. }
            | Self::Cancelled(_) => return None,
        })
    }

    /// Returns reason and remedy in one line, for reports that have no line of their own for the remedy.
    pub fn in_one_line(&self) -> String {
        self.remedy().map_or_else(|| self.to_string(), |remedy| format!("{self}; {remedy}"))
    }
}
