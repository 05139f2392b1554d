//! Cutters as profiles of revolution about the tool axis: flat, ball and bull nose.
//!
//! All three are one shape: a circle of radius `R` (major) swept by a circle of radius `r` (minor);
//! a flat cutter has `r = 0`, a ball `R = 0`. The centre circle lies `r` above the tip.
//! Coordinates of the profile are `[rho, z]`: distance from the axis, height above the tip \[mm\].

mod profile;
pub mod solid;

pub use profile::ProfilePiece;

use crate::types::ErrorList;

/// Shape of the cutting end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CutterKind {
    /// Flat end mill: `r = 0`.
    Flat,
    /// Ball end mill: `R = 0`.
    Ball,
    /// Bull-nose (toroidal, filleted) end mill.
    Bull,
}

/// Where the underside cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CutterConstruction {
    /// Cuts from the centre outward.
    Solid,
    /// Indexable inserts: nothing cuts closer to the axis than `inner_cutting_radius`.
    Insert {
        /// Distance from the axis where cutting begins \[mm\].
        inner_cutting_radius: f64,
    },
}

/// What describes a cutter; [`Cutter::new`] checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct CutterSpec {
    /// Shape of the cutting end.
    pub kind: CutterKind,
    /// Radius `R` of the centre circle \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius `r` of the rounding \[mm\]; 0 for a flat cutter.
    pub minor: f64,
    /// From the tip to the gauge point, the end of the modelled tool \[mm\].
    pub length: f64,
    /// Where the underside cuts.
    pub construction: CutterConstruction,
    /// Profile above the cutting part, `[height above the tip, radius]` \[mm\], heights not falling.
    /// Below the first entry the tool has the cutter's radius, above the last the last radius.
    pub shank: Vec<[f64; 2]>,
}

/// All errors of a cutter description.
pub type CutterErrors = ErrorList<CutterError>;

/// A fault in a [`CutterSpec`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutterError {
    /// A length is NaN, infinite, or negative where it must not be.
    #[error("{name} of the cutter is {value} mm: must be finite and {must}")]
    BadLength {
        /// Which one.
        name: &'static str,
        /// The value given \[mm\].
        value: f64,
        /// What it has to be.
        must: &'static str,
    },
    /// The radii do not make the kind named.
    #[error(
        "a {kind:?} cutter has {must}, but R = {major} mm and r = {minor} mm were given; \
         correct the radius or the kind"
    )]
    WrongKind {
        /// The kind named.
        kind: CutterKind,
        /// `R` \[mm\].
        major: f64,
        /// `r` \[mm\].
        minor: f64,
        /// What the kind asks for.
        must: &'static str,
    },
    /// The rounding is higher than the tool is long.
    #[error("the cutter is {length} mm long, shorter than its corner radius of {minor} mm")]
    TooShort {
        /// Tip to gauge point \[mm\].
        length: f64,
        /// `r` \[mm\].
        minor: f64,
    },
    /// Nothing is left to cut with.
    #[error(
        "inner cutting radius {inner} mm must be at least 0 and below the cutter radius {radius} mm"
    )]
    InnerRadius {
        /// The value given \[mm\].
        inner: f64,
        /// `R + r` \[mm\].
        radius: f64,
    },
    /// An entry of the shank profile.
    #[error(
        "shank entry {index} is [height {height}, radius {radius}] mm: the radius must be above 0, \
         heights must not fall and lie between the corner radius and the length of the tool"
    )]
    Shank {
        /// Which entry, from 0.
        index: usize,
        /// Its height above the tip \[mm\].
        height: f64,
        /// Its radius \[mm\].
        radius: f64,
    },
}

/// A cutter that passed all checks of [`Cutter::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct Cutter {
    spec: CutterSpec,
    profile: Vec<ProfilePiece>,
}

impl Cutter {
    /// Checks the description and lays out the profile.
    ///
    /// # Errors
    ///
    /// Every fault found, not only the first.
    pub fn new(spec: CutterSpec) -> Result<Self, CutterErrors> {
        let mut faults = bad_lengths(&spec);
        if faults.is_empty() {
            faults = bad_shape(&spec);
        }
        faults.extend(bad_shank(&spec));
        if faults.is_empty() {
            let profile = profile::lay_out(&spec);
            Ok(Self { spec, profile })
        } else {
            Err(faults.into())
        }
    }

    /// Shape of the cutting end.
    pub fn kind(&self) -> CutterKind {
        self.spec.kind
    }

    /// Radius `R` of the centre circle \[mm\].
    pub fn major(&self) -> f64 {
        self.spec.major
    }

    /// Radius `r` of the rounding, and height of the centre circle above the tip \[mm\].
    pub fn minor(&self) -> f64 {
        self.spec.minor
    }

    /// Outer radius `R + r` \[mm\].
    pub fn radius(&self) -> f64 {
        self.spec.major + self.spec.minor
    }

    /// Tip to gauge point \[mm\].
    pub fn length(&self) -> f64 {
        self.spec.length
    }

    /// Whether the underside cuts from the axis outward.
    pub fn centre_cutting(&self) -> bool {
        self.inner_cutting_radius() <= 0.0
    }

    /// Distance from the axis where cutting begins \[mm\]; 0 for a solid cutter.
    pub fn inner_cutting_radius(&self) -> f64 {
        match self.spec.construction {
            CutterConstruction::Solid => 0.0,
            CutterConstruction::Insert { inner_cutting_radius } => inner_cutting_radius,
        }
    }

    /// The description it was made from.
    pub fn spec(&self) -> &CutterSpec {
        &self.spec
    }

    /// Profile of revolution from the tip outward and up to [`Cutter::length`], pieces end to end:
    /// disc (flat, bull), arc (ball, bull), flank and shank lines.
    pub fn profile(&self) -> &[ProfilePiece] {
        &self.profile
    }

    /// Height below which the outline is the cutting end: `r` \[mm\]. Above are flank and shank.
    pub fn cutting_height(&self) -> f64 {
        self.spec.minor
    }
}

/// Lengths that are not numbers or have the wrong sign.
fn bad_lengths(spec: &CutterSpec) -> Vec<CutterError> {
    let mut faults = Vec::new();
    for (name, value) in [("major radius", spec.major), ("minor radius", spec.minor)] {
        if !(value.is_finite() && value >= 0.0) {
            faults.push(CutterError::BadLength { name, value, must: "at least 0" });
        }
    }
    if !(spec.length.is_finite() && spec.length > 0.0) {
        let (name, value) = ("length", spec.length);
        faults.push(CutterError::BadLength { name, value, must: "above 0" });
    }
    faults
}

/// Kind, inner cutting radius and length against the radii, which are numbers by now.
fn bad_shape(spec: &CutterSpec) -> Vec<CutterError> {
    let mut faults = Vec::new();
    let [major, minor] = [spec.major, spec.minor];
    let kind = spec.kind;
    let (fits, must) = match kind {
        CutterKind::Flat => (major > 0.0 && minor <= 0.0, "R above 0 and r = 0"),
        CutterKind::Ball => (major <= 0.0 && minor > 0.0, "R = 0 and r above 0"),
        CutterKind::Bull => (major > 0.0 && minor > 0.0, "R and r above 0"),
    };
    if !fits {
        faults.push(CutterError::WrongKind { kind, major, minor, must });
    }
    if spec.length < minor {
        faults.push(CutterError::TooShort { length: spec.length, minor });
    }
    if let CutterConstruction::Insert { inner_cutting_radius: inner } = spec.construction {
        let radius = major + minor;
        if !(inner >= 0.0 && inner < radius) {
            faults.push(CutterError::InnerRadius { inner, radius });
        }
    }
    faults
}

/// Entries of the shank profile that are out of order or out of range.
fn bad_shank(spec: &CutterSpec) -> Vec<CutterError> {
    let mut below = spec.minor;
    let mut faults = Vec::new();
    for (index, &[height, radius]) in spec.shank.iter().enumerate() {
        let fits = height >= below && height <= spec.length && radius > 0.0 && radius.is_finite();
        if fits {
            below = height;
        } else {
            faults.push(CutterError::Shank { index, height, radius });
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bull() -> CutterSpec {
        CutterSpec {
            kind: CutterKind::Bull,
            major: 10.0,
            minor: 6.0,
            length: 120.0,
            construction: CutterConstruction::Solid,
            shank: Vec::new(),
        }
    }

    #[test]
    fn a_bull_nose_is_disc_arc_and_flank() {
        let cutter = Cutter::new(bull()).unwrap();
        assert_eq!(
            cutter.profile(),
            [
                ProfilePiece::Line { from: [0.0, 0.0], to: [10.0, 0.0] },
                ProfilePiece::Arc { center: [10.0, 6.0], radius: 6.0 },
                ProfilePiece::Line { from: [16.0, 6.0], to: [16.0, 120.0] },
            ]
        );
        assert!(cutter.centre_cutting());
    }

    #[test]
    fn a_shank_steps_out_at_its_height() {
        let shank = vec![[30.0, 12.5], [60.0, 25.0]];
        let cutter = Cutter::new(CutterSpec { shank, ..bull() }).unwrap();
        let ends: Vec<[f64; 2]> = cutter.profile().iter().map(ProfilePiece::end).collect();
        let expected =
            [[10.0, 0.0], [16.0, 6.0], [16.0, 30.0], [12.5, 30.0], [25.0, 60.0], [25.0, 120.0]];
        assert_eq!(ends, expected);
    }

    #[test]
    fn flat_and_ball_lack_what_they_lack() {
        let flat = CutterSpec { kind: CutterKind::Flat, minor: 0.0, ..bull() };
        assert_eq!(Cutter::new(flat).unwrap().profile().len(), 2);
        let ball =
            Cutter::new(CutterSpec { kind: CutterKind::Ball, major: 0.0, ..bull() }).unwrap();
        assert!(matches!(ball.profile()[0], ProfilePiece::Arc { center: [0.0, 6.0], .. }));
    }

    #[test]
    fn pieces_join() {
        let shank = vec![[6.0, 8.0], [6.0, 9.0], [120.0, 20.0]];
        let cutter = Cutter::new(CutterSpec { shank, ..bull() }).unwrap();
        let ends: Vec<[f64; 2]> = cutter.profile().iter().map(ProfilePiece::end).collect();
        let starts: Vec<[f64; 2]> = cutter.profile().iter().map(ProfilePiece::start).collect();
        assert_eq!(ends[..ends.len() - 1], starts[1..]);
    }

    #[test]
    fn all_faults_are_reported_together() {
        let faults = Cutter::new(CutterSpec {
            kind: CutterKind::Ball,
            length: 5.0,
            construction: CutterConstruction::Insert { inner_cutting_radius: 16.0 },
            shank: vec![[40.0, 10.0], [4.0, -1.0]],
            ..bull()
        })
        .unwrap_err();
        assert_eq!(faults.len(), 5, "{faults:?}");
        assert!(faults[0].to_string().contains("R = 0"), "{}", faults[0]);
    }

    #[test]
    fn a_length_that_is_no_number_is_named() {
        let faults = Cutter::new(CutterSpec { major: f64::NAN, length: 0.0, ..bull() });
        let messages: Vec<String> = faults.unwrap_err().iter().map(ToString::to_string).collect();
        assert_eq!(messages.len(), 2);
        assert!(messages[0].contains("major radius") && messages[1].contains("length"));
    }
}
