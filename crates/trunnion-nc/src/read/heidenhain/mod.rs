//! Klartext: `L X+10 FMAX`, `LN .. TX TY TZ`, `CC`, `C`, `CYCL DEF`, `Q1 = 5`.

mod calls;
mod drilling;
mod drilling_cycle;
mod flow;
mod function;
mod path;
mod plane;
mod reader;
mod token;
mod value;

pub(super) use reader::HeidenhainReader;
