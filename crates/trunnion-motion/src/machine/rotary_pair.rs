//! One number for each of the two rotary axes.

/// One number for each rotary axis: positions, travels or weights.
///
/// # Example
///
/// ```
/// use trunnion_motion::machine::RotaryPair;
///
/// let travel = RotaryPair::new(1.5, 0.25);
/// assert_eq!(RotaryPair::from([1.5, 0.25]), travel);
/// let [first, second] = travel.into();
/// assert_eq!((first, second), (travel.first, travel.second));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryPair {
    /// Number of the workpiece-side rotary axis \[rad, if it is an angle\].
    pub first: f64,
    /// Number of the tool-side rotary axis \[rad, if it is an angle\].
    pub second: f64,
}

impl RotaryPair {
    /// Creates a pair, workpiece side first.
    pub const fn new(first: f64, second: f64) -> Self {
        Self { first, second }
    }
}

impl From<[f64; 2]> for RotaryPair {
    /// Takes the workpiece side first.
    fn from([first, second]: [f64; 2]) -> Self {
        Self { first, second }
    }
}

impl From<RotaryPair> for [f64; 2] {
    /// Returns the workpiece side first.
    fn from(pair: RotaryPair) -> Self {
        [pair.first, pair.second]
    }
}
