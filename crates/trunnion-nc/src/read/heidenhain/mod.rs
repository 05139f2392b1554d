//! Klartext: `L X+10 FMAX`, `LN .. TX TY TZ`, `CC`, `C`, `CYCL DEF`, `Q1 = 5`.

mod approach;
mod assignment;
mod calls;
mod circles;
mod contour;
mod drilling;
mod drilling_cycle;
mod element;
mod flow;
mod frame;
mod function;
mod iso;
mod m_functions;
mod path;
mod path_block;
mod path_words;
mod plane;
mod reader;
mod technology;
mod token;
mod transform;
mod units;
mod value;

pub(super) use reader::HeidenhainReader;
