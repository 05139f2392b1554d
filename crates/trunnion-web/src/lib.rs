//! The verbs of trunnion for web pages.
//!
//! An [`Engine`] holds named files in memory, and runs jobs and checks on them. Its outputs, tables and messages are those
//! of the command line: both call `trunnion_cli::calls`. On `wasm32` the module `page` makes it a JavaScript class.

mod answer;
mod engine;
mod library_model;
mod machine_model;
#[cfg(target_family = "wasm")]
pub mod page;
mod part_model;
mod stock_model;
mod timeline;

pub use answer::PageAnswer;
pub use engine::{CHECK_FOLDER, Engine, RUN_FOLDER};
pub use library_model::{CutterModel, LibraryModel};
pub use machine_model::{LinkModel, MachineModel};
pub use part_model::{FaceModel, PartModel};
pub use stock_model::{BrickModel, StockModel};
pub use timeline::Timeline;
