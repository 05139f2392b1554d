//! Words with one meaning for [`read`](crate::read) and [`write`](mod@crate::write): axis words, and those of the coolant.

mod axis_words;
mod coolant;

pub use axis_words::{AxisWord, AxisWords, MOST_DECIMALS, WordsError};
pub use coolant::Coolant;
