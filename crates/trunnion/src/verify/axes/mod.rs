//! Audits the axes of a program against their limits, at the times of its own blocks.

pub(crate) mod audit;
mod blocks;
mod linuxcnc;
mod within_block;
