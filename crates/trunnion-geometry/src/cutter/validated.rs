//! A cutter description that passed all checks.

use super::error::{CutterError, CutterErrors};
use super::profile::{ProfilePiece, lay_out};
use super::spec::{CutterConstruction, CutterKind, CutterSpec};

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
    /// All errors of the description, not only the first.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterSpec};
    ///
    /// let errors = Cutter::new(CutterSpec { length: f64::NAN, ..CutterSpec::ball(-1.0) });
    /// assert_eq!(errors.unwrap_err().len(), 2); // the radius and the length
    /// ```
    pub fn new(spec: CutterSpec) -> Result<Self, CutterErrors> {
        let mut errors = bad_lengths(&spec);
        // Comparisons of radii mean nothing while one of them is no number.
        if errors.is_empty() {
            errors = bad_shape(&spec);
        }
        errors.extend(bad_shank(&spec));
        if errors.is_empty() {
            let profile = lay_out(&spec);
            Ok(Self { spec, profile })
        } else {
            Err(errors.into())
        }
    }

    /// Returns the shape of the cutting end.
    pub fn kind(&self) -> CutterKind {
        self.spec.kind
    }

    /// Returns the radius `R` of the centre circle \[mm\].
    pub fn major(&self) -> f64 {
        self.spec.major
    }

    /// Returns the radius `r` of the rounding, and height of the centre circle above the tip
    /// \[mm\].
    pub fn minor(&self) -> f64 {
        self.spec.minor
    }

    /// Returns the outer radius `R + r` \[mm\].
    pub fn radius(&self) -> f64 {
        self.spec.major + self.spec.minor
    }

    /// Returns the distance from the tip to the gauge point \[mm\].
    pub fn length(&self) -> f64 {
        self.spec.length
    }

    /// Returns `true` if the underside cuts from the axis outward.
    pub fn centre_cutting(&self) -> bool {
        self.inner_cutting_radius() <= 0.0
    }

    /// Returns the distance from the axis where cutting begins \[mm\]; 0 for a solid cutter.
    pub fn inner_cutting_radius(&self) -> f64 {
        match self.spec.construction {
            CutterConstruction::Solid => 0.0,
            CutterConstruction::Insert { inner_cutting_radius } => inner_cutting_radius,
        }
    }

    /// Returns the description the cutter was made from.
    pub fn spec(&self) -> &CutterSpec {
        &self.spec
    }

    /// Returns the profile of revolution from the tip outward and up to [`Cutter::length`], pieces
    /// end to end: disc (flat, bull), arc (ball, bull), flank and shank lines.
    pub fn profile(&self) -> &[ProfilePiece] {
        &self.profile
    }

    /// Returns the height below which the outline is the cutting end: `r` \[mm\]. Above are flank
    /// and shank.
    pub fn cutting_height(&self) -> f64 {
        self.spec.minor
    }
}

/// Lists lengths that are not numbers or have the wrong sign.
fn bad_lengths(spec: &CutterSpec) -> Vec<CutterError> {
    let mut errors = Vec::new();
    for (name, value) in [("major radius", spec.major), ("minor radius", spec.minor)] {
        if !(value.is_finite() && value >= 0.0) {
            errors.push(CutterError::BadLength { name, value, must: "at least 0" });
        }
    }
    if !(spec.length.is_finite() && spec.length > 0.0) {
        let (name, value) = ("length", spec.length);
        errors.push(CutterError::BadLength { name, value, must: "above 0" });
    }
    errors
}

/// Checks kind, inner cutting radius and length against the radii, which are numbers by now.
fn bad_shape(spec: &CutterSpec) -> Vec<CutterError> {
    let mut errors = Vec::new();
    let [major, minor] = [spec.major, spec.minor];
    let kind = spec.kind;
    let (fits, must) = match kind {
        CutterKind::Flat => (major > 0.0 && minor <= 0.0, "R above 0 and r = 0"),
        CutterKind::Ball => (major <= 0.0 && minor > 0.0, "R = 0 and r above 0"),
        CutterKind::Bull => (major > 0.0 && minor > 0.0, "R and r above 0"),
    };
    if !fits {
        errors.push(CutterError::WrongKind { kind, major, minor, must });
    }
    // The corner arc reaches up to the height r.
    if spec.length < minor {
        errors.push(CutterError::TooShort { length: spec.length, minor });
    }
    if let CutterConstruction::Insert { inner_cutting_radius: inner } = spec.construction {
        let radius = major + minor;
        if !(inner >= 0.0 && inner < radius) {
            errors.push(CutterError::InnerRadius { inner, radius });
        }
    }
    errors
}

/// Lists entries of the shank profile that are out of order or out of range.
fn bad_shank(spec: &CutterSpec) -> Vec<CutterError> {
    let mut below = spec.minor;
    let mut errors = Vec::new();
    for (index, &[height, radius]) in spec.shank.iter().enumerate() {
        let fits = height >= below && height <= spec.length && radius > 0.0 && radius.is_finite();
        if fits {
            below = height;
        } else {
            errors.push(CutterError::Shank { index, height, radius });
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bull() -> CutterSpec {
        CutterSpec { length: 120.0, ..CutterSpec::bull(10.0, 6.0) }
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
