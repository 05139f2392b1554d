//! Stock as it is cut at any time of a program, for pictures: forwards and backwards, with the pieces of its surface that change.

mod brick;
mod difference;
mod keyframes;
mod options;
mod playback;

pub use brick::{StockBrick, StockChanges};
pub use options::TimedStockOptions;
pub use playback::TimedStock;
