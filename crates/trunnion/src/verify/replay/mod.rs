//! Replays a program or CL file as a restartable stream of motion segments.

pub(crate) mod control;
pub(crate) mod controls;
pub(crate) mod mover;
pub(crate) mod offset_names;
pub(crate) mod orient;
pub(crate) mod position;
mod replayed_block;
pub(crate) mod segment;
pub(crate) mod segments;
pub(crate) mod tables;
pub(crate) mod timeline;
pub(crate) mod track;

pub use crate::nc::control::WorkOffset;
pub use offset_names::{offset_name, offset_short_name};
pub use orient::{Choice, Choices};
pub use replayed_block::{ReplayedBlock, ReplayedCourse, ReplayedSpeed, replay_blocks};
pub use tables::{Changes, Tables, Tool};
pub use timeline::{TimelineOptions, TimelinePoint, timeline};
pub use track::{TimedPose, Track, track};
