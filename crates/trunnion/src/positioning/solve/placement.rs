//! Cutter locations through two end points: pose and its derivatives by `(w, alpha, theta)`.
//!
//! `docs/sources.md#004`, section 1: `P3 = P1 + w d`, `P2` its closest surface point, `C1`, `C2` at
//! `r + e` above them, and the torus circle turned by theta about the chord.

use crate::math;
use crate::positioning::distance::circle::ErrorSample;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::ring::CenterCircle;
use crate::positioning::error::PositioningError;
use crate::positioning::request::{ContactSide, LocationRequest};
use crate::types::{ToolPose, Uv};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Largest rotation about the chord \[rad\]: a cutter that leans farther than about 35 degrees reaches
/// nothing more, but its flank and holder come down to the part.
pub(crate) const MOST_ROTATION: f64 = 0.6;

/// Frame at the first end point, the same throughout a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EndPointFrame {
    /// Radius of the centre circle `R` \[mm\].
    pub(crate) major: f64,
    /// Corner radius `r`, or the radius of the large arc of a barrel \[mm\].
    pub(crate) minor: f64,
    /// Distance of `C1` and `C2` from the surface: `r + e` \[mm\].
    pub(crate) lift: f64,
    /// The first end point.
    pub(crate) first: DistanceReading,
    /// Feed direction.
    pub(crate) a: Vector3<f64>,
    /// Direction across the feed, to the strip's side.
    pub(crate) v: Vector3<f64>,
    /// Side of the cutter that cuts: `Ahead` or `Behind`.
    pub(crate) side: ContactSide,
    /// `e3 = hand * (e1 x e2)` points along the feed for a contact arc ahead.
    hand: f64,
}

/// A cutter location, and how it moves with `x = (w, alpha, theta)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TorusPlacement {
    pub(crate) x: [f64; 3],
    /// Foot of `P3`: the second end point.
    pub(crate) second: DistanceReading,
    /// Angle 0 is the middle of the arc, `e2` points along the chord to the second end point.
    pub(crate) ring: CenterCircle,
    pub(crate) axis: UnitVector3<f64>,
    /// Half the angle of the arc between the end points \[rad\].
    pub(crate) half_arc: f64,
    /// Half the chord \[mm\].
    pub(crate) half_chord: f64,
    rates: [MotionRate; 3],
}

/// Motion of the tool per unit of one unknown: a point `Q` moves by `shift + spin x (Q - M)`, `M`
/// the middle of the chord, and a point fixed in the arc's own parameter also along the arc.
#[derive(Debug, Clone, Copy)]
struct MotionRate {
    middle: Point3<f64>,
    shift: Vector3<f64>,
    spin: Vector3<f64>,
    half_arc: f64,
    half_chord: f64,
}

/// Chord between `C1` and `C2`, about which the circle is turned.
struct ChordFrame {
    /// Unit vector square to the chord, towards the normal at `P1`.
    e1: Vector3<f64>,
    /// Length of the part of that normal square to the chord: the sine of the angle between them.
    up: f64,
    /// Middle of the chord \[mm\].
    middle: Point3<f64>,
    /// Distance of the chord from the centre of the circle \[mm\].
    sagitta: f64,
}

impl EndPointFrame {
    /// Creates the frame at the first end point of `request`, for the side `Ahead` or `Behind`.
    pub(crate) fn new(
        request: &LocationRequest,
        side: ContactSide,
        probe: &mut FaceProbe,
    ) -> Result<Self, PositioningError> {
        let no_direction = || PositioningError::NoDirection { feed: request.feed, uv: request.at };
        let Uv { u, v } = request.at;
        let face = request.face.face();
        let point = face.surface.point(u, v);
        let first = probe.foot(&point, request.at.into())?;
        let jet = &first.foot.jet;
        let along = jet.su * request.feed[0] + jet.sv * request.feed[1];
        let a = UnitVector3::try_new(along, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
        let strip = request.strip.sign();
        let sense = if side == ContactSide::Behind { -1.0 } else { 1.0 };
        let minor = request.cutter.contact_arc().radius;
        Ok(Self {
            major: request.cutter.major(),
            minor,
            lift: minor + request.band.upper,
            first,
            a: a.into_inner(),
            v: a.cross(&first.normal()) * strip,
            side,
            hand: strip * sense,
        })
    }

    /// Returns the tangent direction at angle `alpha` from `v` towards `a`.
    pub(crate) fn direction(&self, alpha: f64) -> Vector3<f64> {
        self.v * math::cos(alpha) + self.a * math::sin(alpha)
    }

    /// Returns the width of the chord across the feed.
    pub(crate) fn width([w, alpha, _]: [f64; 3]) -> f64 {
        w * math::cos(alpha)
    }

    /// Places the cutter; `None` where the chord does not fit into the circle.
    pub(crate) fn place(
        &self,
        x @ [w, alpha, theta]: [f64; 3],
        probe: &mut FaceProbe,
        guess: Option<[f64; 2]>,
    ) -> Result<Option<TorusPlacement>, PositioningError> {
        let d = self.direction(alpha);
        let p3 = self.first.foot.point + d * w;
        let guess = guess.unwrap_or_else(|| self.first.ahead(&(d * w)));
        let second = probe.foot(&p3, guess)?;
        let n1 = self.first.normal().into_inner();
        let c1 = self.first.foot.point + n1 * self.lift;
        let c2 = second.foot.point + second.normal().into_inner() * self.lift;
        let half_chord = 0.5 * (c2 - c1).norm();
        let Some(e2) = UnitVector3::try_new(c2 - c1, f64::MIN_POSITIVE) else { return Ok(None) };
        let up = n1 - e2.scale(n1.dot(&e2));
        let Some(e1) = UnitVector3::try_new(up, f64::MIN_POSITIVE) else { return Ok(None) };
        if half_chord >= self.major {
            return Ok(None);
        }
        // Frame of the chord: e2 along it, e1 up, e3 along the feed; theta turns e1 towards e3.
        let e3 = e1.cross(&e2) * self.hand;
        let (sin, cos) = math::sin_cos(theta);
        let f = e3 * cos - e1.scale(sin);
        let axis = UnitVector3::new_normalize(e1.scale(cos) + e3 * sin);
        // Pythagoras: distance of the chord from the centre of the circle.
        let sagitta = (self.major * self.major - half_chord * half_chord).sqrt();
        let middle = nalgebra::center(&c1, &c2);
        let bare = TorusPlacement {
            x,
            second,
            ring: CenterCircle {
                center: middle - f * sagitta,
                f,
                e2: e2.into_inner(),
                radius: self.major,
            },
            axis,
            half_arc: math::atan2(half_chord, sagitta),
            half_chord,
            rates: [MotionRate::turning(middle, -e2.scale(self.hand)); 3],
        };
        // d(P3) / d(alpha) = w d(direction) / d(alpha).
        let along = self.a * math::cos(alpha) - self.v * math::sin(alpha);
        let chord = ChordFrame { e1: e1.into_inner(), up: up.norm(), middle, sagitta };
        let by_w = self.rate(&bare, &chord, &d);
        let by_alpha = self.rate(&bare, &chord, &(along * w));
        Ok(Some(TorusPlacement { rates: [by_w, by_alpha, bare.rates[2]], ..bare }))
    }

    /// Returns the motion of the tool when `P3` moves by `step`.
    fn rate(&self, at: &TorusPlacement, chord: &ChordFrame, step: &Vector3<f64>) -> MotionRate {
        let ChordFrame { e1, up, middle, sagitta } = *chord;
        let (foot, normal) = at.second.foot_rate(step);
        let c2 = foot + normal * self.lift;
        let n1 = self.first.normal().into_inner();
        let e2 = at.ring.e2;
        // C1 is fixed, C2 moves by `c2`: the chord grows by its part along e2, and turns by the
        // rest.
        let half_chord = 0.5 * e2.dot(&c2);
        let turned = (c2 - e2 * e2.dot(&c2)) / (2.0 * at.half_chord);
        // e1 = unit(n1 - (n1.e2) e2); the part of its change along e3 is a spin about e2.
        let risen = -(e2 * n1.dot(&turned) + turned * n1.dot(&e2)) / up;
        let spin = e2.cross(&turned) + e2 * (e2.cross(&e1)).dot(&risen);
        // From sagitta^2 + half_chord^2 = R^2.
        let sagitta_rate = -at.half_chord * half_chord / sagitta;
        MotionRate {
            middle,
            shift: c2 * 0.5 - at.ring.f * sagitta_rate,
            spin,
            half_arc: half_chord / sagitta,
            half_chord,
        }
    }
}

impl MotionRate {
    fn turning(middle: Point3<f64>, spin: Vector3<f64>) -> Self {
        Self { middle, shift: Vector3::zeros(), spin, half_arc: 0.0, half_chord: 0.0 }
    }
}

impl TorusPlacement {
    /// Returns the derivatives by `x` of the distance of a point fixed in the tool (envelope theorem:
    /// the foot's own motion does not count).
    pub(crate) fn gradient(&self, q: &Point3<f64>, normal: &Vector3<f64>) -> [f64; 3] {
        self.rates
            .map(|rate| normal.dot(&rate.shift) + rate.spin.dot(&(q - rate.middle).cross(normal)))
    }

    /// Returns [`TorusPlacement::gradient`] for the circle point at `psi = share * half_arc`, whose share of
    /// the arc is kept: at the end points the distance is constant.
    pub(crate) fn arc_gradient(&self, share: f64, sample: &ErrorSample) -> [f64; 3] {
        let mut gradient = self.gradient(&sample.at, &sample.reading.normal());
        for (entry, rate) in gradient.iter_mut().zip(&self.rates) {
            *entry += sample.slope * share * rate.half_arc;
        }
        gradient
    }

    /// Returns the derivatives of half the chord.
    pub(crate) fn chord_gradient(&self) -> [f64; 3] {
        self.rates.map(|rate| rate.half_chord)
    }

    /// Returns the derivatives of `axis . direction`.
    pub(crate) fn axis_gradient(&self, direction: &Vector3<f64>) -> [f64; 3] {
        self.rates.map(|rate| rate.spin.cross(&self.axis).dot(direction))
    }

    /// Returns tip and axis; the circle's plane is `minor` above the tip.
    pub(crate) fn pose(&self, minor: f64) -> ToolPose {
        ToolPose { tip: self.ring.center - self.axis.scale(minor), axis: self.axis }
    }
}
