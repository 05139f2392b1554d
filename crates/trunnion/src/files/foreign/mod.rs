//! Machines as other programs describe them: parameters of controls and files of `FreeCAD`.
//!
//! Each format has a reader that turns its values into a [`draft`](import_machine) of a chain and records which value
//! became which. What a format does not state is asked for by key, never assumed.

mod control_format;
mod draft;
mod fanuc;
mod freecad;
mod given;
mod haas;
mod hal_pins;
mod heidenhain;
mod import;
mod linuxcnc;
mod neutral;
mod siemens;
mod source_value;
mod source_values;
mod value_origin;

pub use control_format::ControlFormat;
pub use import::{CompanionFile, ImportRequest, ImportedMachine, import_machine};
pub use value_origin::ValueOrigin;
