//! Parameters of a surface.

/// Parameters `(u, v)` of a point on a face, in the face's own units (often 0 to 1, or mm and rad).
///
/// # Example
///
/// ```
/// use trunnion_types::types::Uv;
///
/// let corner = Uv::new(0.0, 0.5);
/// assert_eq!(corner, Uv::from([0.0, 0.5]));
/// assert_eq!(<[f64; 2]>::from(corner), [0.0, 0.5]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uv {
    /// First parameter.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
}

impl Uv {
    /// Creates the pair `(u, v)`.
    pub const fn new(u: f64, v: f64) -> Self {
        Self { u, v }
    }
}

impl From<[f64; 2]> for Uv {
    fn from([u, v]: [f64; 2]) -> Self {
        Self { u, v }
    }
}

impl From<Uv> for [f64; 2] {
    fn from(uv: Uv) -> Self {
        [uv.u, uv.v]
    }
}
