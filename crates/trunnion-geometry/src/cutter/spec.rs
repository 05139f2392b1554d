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
    /// Tapered ball or bull nose: a cone tangent to the tip arc.
    Taper,
    /// Tangential barrel: a large arc tangent to the tip arc and to the flank.
    Barrel,
    /// Conical barrel: a large arc tangent to the tip arc, inclined to the axis where it ends.
    ConicalBarrel,
    /// Lens: a large arc across the tip, with a small corner arc tangent to it and to the flank.
    Lens,
}

impl CutterKind {
    /// Returns the name of the kind, as job files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Ball => "ball",
            Self::Bull => "bull",
            Self::Taper => "taper",
            Self::Barrel => "barrel",
            Self::ConicalBarrel => "conical-barrel",
            Self::Lens => "lens",
        }
    }
}

/// Part of the profile between the tip arc and the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CutterSide {
    /// None: the tip arc ends in the straight flank.
    Straight,
    /// Cone tangent to the tip arc.
    Cone {
        /// Angle between the cone and the axis, half of the cone's own \[rad\].
        taper_angle: f64,
        /// Diameter at which the cone ends and the flank begins \[mm\].
        diameter: f64,
    },
    /// Arc tangent to the tip arc.
    Arc {
        /// Radius of the arc \[mm\]: above that of the tip arc for a barrel, below it for the corner of a lens.
        radius: f64,
        /// Angle between the arc and the axis where the arc ends \[rad\]; 0 if it is tangent to the flank.
        taper_angle: f64,
        /// Diameter at which the arc ends and the flank begins \[mm\].
        diameter: f64,
    },
}

impl CutterSide {
    /// Returns the diameter at which the flank begins \[mm\], if the side decides it.
    pub fn diameter(&self) -> Option<f64> {
        match *self {
            Self::Straight => None,
            Self::Cone { diameter, .. } | Self::Arc { diameter, .. } => Some(diameter),
        }
    }

    /// Returns the side of a cutter whose outline lies outside by `by` everywhere \[mm\]; negative is inside.
    #[must_use]
    pub fn grown(self, by: f64) -> Self {
        match self {
            Self::Straight => Self::Straight,
            Self::Cone { taper_angle, diameter } => {
                Self::Cone { taper_angle, diameter: diameter + 2.0 * by }
            }
            Self::Arc { radius, taper_angle, diameter } => {
                Self::Arc { radius: radius + by, taper_angle, diameter: diameter + 2.0 * by }
            }
        }
    }

    /// Returns the angle between the upper end of the side and the axis \[rad\].
    pub fn taper_angle(&self) -> f64 {
        match *self {
            Self::Straight => 0.0,
            Self::Cone { taper_angle, .. } | Self::Arc { taper_angle, .. } => taper_angle,
        }
    }
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
/// [`CutterSpec::ball`], [`CutterSpec::bull`], [`CutterSpec::flat`], [`CutterSpec::taper`],
/// [`CutterSpec::barrel`], [`CutterSpec::conical_barrel`] and [`CutterSpec::lens`] fill it with a solid tool
/// without a shank; struct update syntax changes the rest. [`Cutter::new`](super::Cutter::new)
/// checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct CutterSpec {
    /// Shape of the cutting end.
    pub kind: CutterKind,
    /// Radius `R` of the centre circle of the tip arc \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius `r` of the tip arc \[mm\]; 0 for a flat cutter. That of a lens is the large one.
    pub minor: f64,
    /// Part of the profile between the tip arc and the flank.
    pub side: CutterSide,
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

    /// Describes a tapered ball end mill: tip radius \[mm\], half angle of its cone \[rad\], diameter where the cone
    /// ends \[mm\]. Solid, five diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterSpec};
    ///
    /// let taper = Cutter::new(CutterSpec::taper(2.0, 5_f64.to_radians(), 10.0))?;
    /// assert_eq!([taper.minor(), taper.radius()], [2.0, 5.0]);
    /// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
    /// ```
    pub fn taper(tip_radius: f64, taper_angle: f64, diameter: f64) -> Self {
        let side = CutterSide::Cone { taper_angle, diameter };
        Self::with_side(CutterKind::Taper, tip_radius, side, diameter)
    }

    /// Describes a tangential barrel cutter: tip radius, radius of the barrel arc, diameter \[mm\]. Solid, five
    /// diameters long, no shank.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_geometry::cutter::{Cutter, CutterSpec};
    ///
    /// let barrel = Cutter::new(CutterSpec::barrel(2.0, 85.0, 12.0))?;
    /// assert_eq!(barrel.profile().len(), 3); // tip arc, barrel arc, flank
    /// # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
    /// ```
    pub fn barrel(tip_radius: f64, barrel_radius: f64, diameter: f64) -> Self {
        let side = CutterSide::Arc { radius: barrel_radius, taper_angle: 0.0, diameter };
        Self::with_side(CutterKind::Barrel, tip_radius, side, diameter)
    }

    /// Describes a conical barrel cutter: tip radius, radius of the barrel arc \[mm\], angle between arc and axis where
    /// the arc ends \[rad\], diameter there \[mm\]. Solid, five diameters long, no shank.
    pub fn conical_barrel(
        tip_radius: f64,
        barrel_radius: f64,
        taper_angle: f64,
        diameter: f64,
    ) -> Self {
        let side = CutterSide::Arc { radius: barrel_radius, taper_angle, diameter };
        Self::with_side(CutterKind::ConicalBarrel, tip_radius, side, diameter)
    }

    /// Describes a lens cutter: radius of the large arc across the tip, radius of the corner, diameter \[mm\]. Solid,
    /// five diameters long, no shank.
    pub fn lens(tip_radius: f64, corner_radius: f64, diameter: f64) -> Self {
        let side = CutterSide::Arc { radius: corner_radius, taper_angle: 0.0, diameter };
        Self::with_side(CutterKind::Lens, tip_radius, side, diameter)
    }

    /// Describes a solid cutter with a side beyond its tip arc.
    fn with_side(kind: CutterKind, minor: f64, side: CutterSide, diameter: f64) -> Self {
        Self { side, length: PRESET_LENGTH * diameter, ..Self::solid(kind, 0.0, minor) }
    }

    /// Describes a solid cutter of the preset length without a shank.
    fn solid(kind: CutterKind, major: f64, minor: f64) -> Self {
        Self {
            kind,
            major,
            minor,
            side: CutterSide::Straight,
            length: PRESET_LENGTH * 2.0 * (major + minor),
            construction: CutterConstruction::Solid,
            shank: Vec::new(),
        }
    }
}
