//! Pose to axes in closed form: all branches, jets, reach.
//!
//! The tool direction depends on the two rotary axes only: `O = R1(t1) R2(t2) o0`. With
//! `a1 = ∠(w1, w2)`, `a2 = ∠(w2, o0)`, `φ = ∠(w1, O)` the directions `w1`, `w2` and `R2 o0` form a
//! spherical triangle with known sides; its angles at `w1` and `w2` are `B1` and `B2`, and
//!
//! ```text
//! t1 = azimuth of O about w1 from w2 - g B1,   t2 = -g B2 - azimuth of o0 about w2 from w1,   g = ±1
//! ```
//!
//! (`docs/sources.md#002`). Both angles appear as sine and cosine first, by algebra from dot
//! products; the linear axes then follow from one 3x3 solve. The same code runs on plain numbers
//! and on jets, so that derivatives of all orders are exact.

mod refusal;
mod rotary;
mod slides;
mod solve;
mod travel;

pub use refusal::PoseRefusal;
pub use rotary::RotaryAngle;
pub use solve::{AxisJets, Branch, Inverse, InverseError, InverseSolutions};
pub use travel::ContinuedPosition;
pub(crate) use travel::TRAVEL_TIE;
