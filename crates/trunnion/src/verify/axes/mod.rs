//! Audits the axes of a program against their limits, at the times of its own blocks.

pub(crate) mod audit;
mod block_course;
mod block_timing;
mod linuxcnc;
mod mean_acceleration;
mod within_block;
