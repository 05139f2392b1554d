//! Sinumerik programs: `X10`, `A3=0.5`, `C=ACP(33)`, `CYCLE832(..)`, `R1=5`.

mod codes;
mod cycle;
mod cycle_call;
mod decide;
mod drilling;
mod evaluate;
mod flow;
mod frame;
mod head;
mod line;
mod motion;
mod pattern;
mod polar;
mod reader;
mod rotary;
mod smoothing;
mod swivel;
mod value;
mod word;

pub(super) use reader::SiemensReader;
