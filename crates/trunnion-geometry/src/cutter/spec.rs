//! Description of a cutter.

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

/// Part of the underside that cuts.
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

/// Description of a cutter, not yet checked.
///
/// [`CutterSpec::ball`], [`CutterSpec::bull`] and [`CutterSpec::flat`] fill it with a solid tool
/// without a shank; struct update syntax changes the rest. [`Cutter::new`](super::Cutter::new)
/// checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct CutterSpec {
    /// Shape of the cutting end.
    pub kind: CutterKind,
    /// Radius `R` of the centre circle \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius `r` of the rounding \[mm\]; 0 for a flat cutter.
    pub minor: f64,
    /// Distance from the tip to the gauge point, the end of the modelled tool \[mm\].
    pub length: f64,
    /// Part of the underside that cuts.
    pub construction: CutterConstruction,
    /// Profile above the cutting part, `[height above the tip, radius]` \[mm\], heights not
    /// falling. Below the first entry the tool has the cutter's radius, above the last the last
    /// radius.
    pub shank: Vec<[f64; 2]>,
}

/// Length of the presets, in diameters.
const PRESET_LENGTH: f64 = 5.0;

impl CutterSpec {
    /// Describes a ball end mill of a diameter \[mm\]: solid, five diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterSpec};
    ///
    /// let ball = Cutter::new(CutterSpec::ball(10.0))?;
    /// assert_eq!([ball.major(), ball.minor(), ball.length()], [0.0, 5.0, 50.0]);
    /// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
    /// ```
    pub fn ball(diameter: f64) -> Self {
        Self::solid(CutterKind::Ball, 0.0, 0.5 * diameter)
    }

    /// Describes a bull-nose end mill with the centre circle `R` = `major` and the corner radius
    /// `r` = `minor` \[mm\]: solid, five diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterConstruction, CutterSpec};
    ///
    /// // With inserts, nothing cuts closer to the axis than 12 mm.
    /// let construction = CutterConstruction::Insert { inner_cutting_radius: 12.0 };
    /// let cutter = Cutter::new(CutterSpec { construction, ..CutterSpec::bull(10.0, 6.0) })?;
    /// assert!(!cutter.centre_cutting());
    /// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
    /// ```
    pub fn bull(major: f64, minor: f64) -> Self {
        Self::solid(CutterKind::Bull, major, minor)
    }

    /// Describes a flat end mill of a diameter \[mm\]: solid, five diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterSpec};
    ///
    /// let flat = Cutter::new(CutterSpec::flat(20.0))?;
    /// assert_eq!(flat.radius(), 10.0);
    /// assert_eq!(flat.profile().len(), 2); // the disc and the flank
    /// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
    /// ```
    pub fn flat(diameter: f64) -> Self {
        Self::solid(CutterKind::Flat, 0.5 * diameter, 0.0)
    }

    /// Describes a cutter by both radii \[mm\]; they decide the kind: `R` = 0 is a ball, `r` = 0 a flat cutter.
    /// Solid, five diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::CutterSpec;
    ///
    /// assert_eq!(CutterSpec::of_radii(10.0, 6.0), CutterSpec::bull(10.0, 6.0));
    /// assert_eq!(CutterSpec::of_radii(0.0, 4.0), CutterSpec::ball(8.0));
    /// assert_eq!(CutterSpec::of_radii(10.0, 0.0), CutterSpec::flat(20.0));
    /// ```
    pub fn of_radii(major: f64, minor: f64) -> Self {
        let kind = match (major > 0.0, minor > 0.0) {
            (true, true) => CutterKind::Bull,
            (true, false) => CutterKind::Flat,
            (false, _) => CutterKind::Ball,
        };
        Self::solid(kind, major, minor)
    }

    /// Describes a solid cutter of the preset length without a shank.
    fn solid(kind: CutterKind, major: f64, minor: f64) -> Self {
        Self {
            kind,
            major,
            minor,
            length: PRESET_LENGTH * 2.0 * (major + minor),
            construction: CutterConstruction::Solid,
            shank: Vec::new(),
        }
    }
}
