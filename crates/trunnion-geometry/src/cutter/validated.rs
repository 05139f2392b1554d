//! A cutter description that passed all checks.

use super::error::{CutterError, CutterErrors};
use super::profile::{ProfilePiece, lay_out};
use super::spec::{CutterConstruction, CutterKind, CutterSide, CutterSpec};
use super::tangent::TangentProfile;
use std::f64::consts::FRAC_PI_2;

/// A cutter that passed all checks of [`Cutter::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct Cutter {
    spec: CutterSpec,
    profile: Vec<ProfilePiece>,
    /// Cutting end of a cutter with a side.
    tangent: Option<TangentProfile>,
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
        // So does a profile from such lengths, which checks of kinds and heights need.
        let tangent = if errors.is_empty() { tangent(&spec) } else { None };
        if errors.is_empty() {
            errors = bad_side(&spec, tangent.as_ref());
        }
        errors.extend(bad_shank(&spec, tangent.as_ref()));
        if errors.is_empty() {
            let profile = lay_out(&spec, tangent.as_ref());
            Ok(Self { spec, profile, tangent })
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

    /// Returns the outer radius \[mm\]: `R + r`, or half the diameter of a cutter with a side.
    pub fn radius(&self) -> f64 {
        outer_radius(&self.spec)
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
    /// end to end: disc (flat, bull), arc (all but flat), side (taper, barrel, lens), flank and shank lines.
    pub fn profile(&self) -> &[ProfilePiece] {
        &self.profile
    }

    /// Returns the cutting end of a tapered, barrel or lens cutter with its flank, up to the shank; `None` for flat,
    /// ball and bull nose, whose tip arc ends in the flank.
    pub fn tangent_profile(&self) -> Option<&TangentProfile> {
        self.tangent.as_ref()
    }

    /// Returns the height at which the tip arc ends \[mm\]: `r`, or less if a side goes on from it. Above are side,
    /// flank and shank.
    pub fn cutting_height(&self) -> f64 {
        self.tangent.map_or(self.spec.minor, |profile| profile.joint()[1])
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
    let side = match spec.side {
        CutterSide::Straight => Vec::new(),
        CutterSide::Cone { diameter, .. } => vec![("diameter", diameter)],
        CutterSide::Arc { radius, diameter, .. } => {
            vec![("radius of the side arc", radius), ("diameter", diameter)]
        }
    };
    for (name, value) in side {
        if !(value.is_finite() && value > 0.0) {
            errors.push(CutterError::BadLength { name, value, must: "above 0" });
        }
    }
    if !(spec.length.is_finite() && spec.length > 0.0) {
        let (name, value) = ("length", spec.length);
        errors.push(CutterError::BadLength { name, value, must: "above 0" });
    }
    errors
}

/// Returns the outer radius \[mm\].
fn outer_radius(spec: &CutterSpec) -> f64 {
    spec.side.diameter().map_or(spec.major + spec.minor, |diameter| 0.5 * diameter)
}

/// Returns the cutting end of a cutter with a side, if there is such a profile.
fn tangent(spec: &CutterSpec) -> Option<TangentProfile> {
    let top = spec.shank.first().map_or(spec.length, |&[height, _]| height);
    TangentProfile::new([spec.major, spec.minor], spec.side, top)
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
        CutterKind::Taper | CutterKind::Barrel | CutterKind::ConicalBarrel => {
            (minor > 0.0, "a tip radius r above 0")
        }
        CutterKind::Lens => (major <= 0.0 && minor > 0.0, "R = 0 and a tip radius r above 0"),
    };
    if !fits {
        errors.push(CutterError::WrongKind { kind, major, minor, must });
    }
    // The corner arc reaches up to the height r.
    if spec.length < minor && spec.side == CutterSide::Straight {
        errors.push(CutterError::TooShort { length: spec.length, minor });
    }
    if let CutterConstruction::Insert { inner_cutting_radius: inner } = spec.construction {
        let radius = outer_radius(spec);
        if !(inner >= 0.0 && inner < radius) {
            errors.push(CutterError::InnerRadius { inner, radius });
        }
    }
    errors
}

/// Checks the side against kind, radii and length.
fn bad_side(spec: &CutterSpec, tangent: Option<&TangentProfile>) -> Vec<CutterError> {
    let kind = spec.kind;
    let in_range = |angle: f64| angle > 0.0 && angle < FRAC_PI_2;
    let (fits, must) = match (kind, spec.side) {
        (CutterKind::Flat | CutterKind::Ball | CutterKind::Bull, side) => {
            (side == CutterSide::Straight, "flat, ball and bull have a straight flank")
        }
        (CutterKind::Taper, side) => (
            matches!(side, CutterSide::Cone { taper_angle, .. } if in_range(taper_angle)),
            "a cone needs a taper angle between 0 and 90 degrees and a diameter above that of the tip arc where the cone begins",
        ),
        (CutterKind::Barrel, side) => (
            matches!(side, CutterSide::Arc { radius, taper_angle, .. } if radius > spec.minor && taper_angle.abs() <= 0.0),
            "the barrel radius must exceed tip radius and half the diameter, the diameter must exceed that of the tip",
        ),
        (CutterKind::ConicalBarrel, side) => (
            matches!(side, CutterSide::Arc { radius, taper_angle, .. } if radius > spec.minor && in_range(taper_angle)),
            "the barrel radius must exceed the tip radius, the taper angle lie between 0 and 90 degrees, and the diameter exceed that of the tip arc but not what the barrel arc reaches",
        ),
        (CutterKind::Lens, side) => (
            matches!(side, CutterSide::Arc { radius, taper_angle, .. } if radius > 0.0 && radius < spec.minor && taper_angle.abs() <= 0.0),
            "half the diameter must lie between corner radius and tip radius",
        ),
    };
    if !fits || tangent.is_none() != (spec.side == CutterSide::Straight) {
        let (tip_radius, given) = (spec.minor, describe(spec.side));
        return vec![CutterError::WrongSide { kind, tip_radius, must, given }];
    }
    match tangent {
        Some(profile) if profile.flank_start() > spec.length => {
            let (length, height) = (spec.length, profile.flank_start());
            vec![CutterError::SideTooLong { length, height }]
        }
        _ => Vec::new(),
    }
}

/// Describes a side in mm and degrees.
fn describe(side: CutterSide) -> String {
    match side {
        CutterSide::Straight => "no side".to_owned(),
        CutterSide::Cone { taper_angle, diameter } => {
            format!(
                "a cone of {} degrees up to a diameter of {diameter} mm",
                taper_angle.to_degrees()
            )
        }
        CutterSide::Arc { radius, taper_angle, diameter } => format!(
            "an arc of {radius} mm that ends at {} degrees and a diameter of {diameter} mm",
            taper_angle.to_degrees()
        ),
    }
}

/// Lists entries of the shank profile that are out of order or out of range.
fn bad_shank(spec: &CutterSpec, tangent: Option<&TangentProfile>) -> Vec<CutterError> {
    // The shank begins above the cutting end.
    let mut below = tangent.map_or(spec.minor, TangentProfile::flank_start);
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
                ProfilePiece::Arc {
                    center: [10.0, 6.0],
                    radius: 6.0,
                    from: [0.0, -1.0],
                    to: [1.0, 0.0]
                },
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
    fn sides_that_cannot_be_are_refused_with_their_values() {
        let message = |spec: CutterSpec| Cutter::new(spec).unwrap_err()[0].to_string();
        // A cone that ends below the tip, a barrel smaller than its flank, a lens narrower than its corners.
        let taper = message(CutterSpec::taper(3.0, 0.1, 4.0));
        assert!(taper.contains("taper") && taper.contains("diameter of 4 mm"), "{taper}");
        let barrel = message(CutterSpec::barrel(2.0, 5.0, 12.0));
        assert!(barrel.contains("barrel") && barrel.contains("an arc of 5 mm"), "{barrel}");
        assert!(message(CutterSpec::lens(85.0, 3.0, 5.0)).contains("corner radius"));
        assert!(message(CutterSpec::lens(4.0, 3.0, 12.0)).contains("lens"));
        let long = CutterSpec { length: 9.0, ..CutterSpec::barrel(2.0, 85.0, 12.0) };
        assert!(message(long).contains("9 mm long"));
        let flat =
            CutterSpec { side: CutterSpec::taper(1.0, 0.1, 8.0).side, ..CutterSpec::flat(8.0) };
        assert!(message(flat).contains("straight flank"));
        let nan = CutterSpec::conical_barrel(1.0, f64::NAN, 0.3, 12.0);
        assert!(message(nan).contains("side arc"));
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
