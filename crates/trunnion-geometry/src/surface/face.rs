//! A face: a surface, its trim loops, and the side the cutter is on.

use super::error::SurfaceError;
use super::geometry::Surface;
use super::trim::ROUNDING;
use super::trim::TrimLoop;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::UnitVector3;

/// A surface with trim loops and a side. The cutter stands where the normal
/// `n = S_u x S_v` points to, or opposite if `flip`.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Number for messages and job files, from 1.
    pub number: usize,
    /// Geometry.
    pub surface: Surface,
    /// Trim loops; none = the whole domain. What an odd number of loops encloses is the face.
    pub loops: Vec<TrimLoop>,
    /// `true` if the cutter is on the `-n` side.
    pub flip: bool,
}

impl Face {
    /// Creates a face with the cutter on the side of `S_u x S_v`; see [`Face::flipped`] for the
    /// other. On a periodic surface the loops are moved by whole periods so that the largest is
    /// centred in the domain and the others lie around it.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Unbounded`] for an endless surface without trims.
    pub fn new(
        number: usize,
        surface: Surface,
        mut loops: Vec<TrimLoop>,
    ) -> Result<Self, SurfaceError> {
        centre_loops(&surface, &mut loops);
        let face = Self { number, surface, loops, flip: false };
        for (bounds, direction) in face.bounds().into_iter().zip(["u", "v"]) {
            if !bounds.is_bounded() {
                return Err(SurfaceError::Unbounded { face: number, direction });
            }
        }
        Ok(face)
    }

    /// Turns the face over: the cutter moves to the other side.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::{Point3, Vector3};
    /// use trunnion_geometry::surface::{Face, SphereSurface, Surface, SurfaceFrame};
    ///
    /// let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x())?;
    /// let ball = Face::new(1, Surface::Sphere(SphereSurface::new(frame, 10.0)?), vec![])?;
    /// assert_eq!(ball.normal(0.0, 0.0), Some(Vector3::x_axis()));
    ///
    /// // The same sphere milled from inside, as a socket.
    /// assert_eq!(ball.flipped().normal(0.0, 0.0), Some(-Vector3::x_axis()));
    /// # Ok::<(), trunnion_geometry::surface::SurfaceError>(())
    /// ```
    #[must_use]
    pub fn flipped(mut self) -> Self {
        self.flip = !self.flip;
        self
    }

    /// Turns the face about the origin of space; parameters and trims stay.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::{Point3, Rotation3, Vector3};
    /// use std::f64::consts::FRAC_PI_2;
    /// use trunnion_geometry::surface::{Face, SphereSurface, Surface, SurfaceFrame};
    ///
    /// let frame = SurfaceFrame::new(Point3::new(0.0, 20.0, 0.0), Vector3::z(), Vector3::x())?;
    /// let ball = Face::new(1, Surface::Sphere(SphereSurface::new(frame, 10.0)?), vec![])?;
    /// let turned = ball.turned(&Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2));
    /// assert!((turned.point(0.0, 0.0) - Point3::new(10.0, 0.0, 20.0)).norm() < 1e-12);
    /// # Ok::<(), trunnion_geometry::surface::SurfaceError>(())
    /// ```
    #[must_use]
    pub fn turned(self, rotation: &Rotation3<f64>) -> Self {
        Self { surface: self.surface.turned(rotation), ..self }
    }

    /// Returns the box in u, v of the trim loops, or the domain where there are none. By a periodic
    /// parameter it may reach outside the domain but is never wider than the period.
    pub fn bounds(&self) -> [Interval; 2] {
        let domain = self.surface.domain();
        let periods = self.surface.periods();
        [0, 1].map(|k| {
            let boxes = self.loops.iter().map(|trim| trim.bounds()[k]);
            let extent = boxes.reduce(|a, b| a.hull(b)).unwrap_or(domain[k]);
            let inside = extent.intersection(domain[k]);
            let around = self.loops.iter().any(|trim| trim.turns()[k] != 0);
            let turns = self.loops.iter().map(|trim| trim.turns()[1 - k]).sum::<i32>();
            match periods[k] {
                // With a loop that runs round, or loops that together span a period, all values of
                // it may occur.
                Some(period) if around || extent.width() > period => domain[k],
                Some(_) => extent,
                // A cap round a pole, on the left of its rim.
                None if turns != 0 && beyond(turns, k) => Interval { low: inside.low, ..domain[k] },
                None if turns != 0 => Interval { high: inside.high, ..domain[k] },
                None => inside,
            }
        })
    }

    /// Returns `true` if `(u, v)` lies inside the trims; without trims, inside the domain. Points
    /// on a trim curve itself may be either. Parameters of a periodic surface may be given on any
    /// turn.
    pub fn contains(&self, u: f64, v: f64) -> bool {
        let (domain, periods) = (self.surface.domain(), self.surface.periods());
        let in_domain = [u, v]
            .iter()
            .enumerate()
            .all(|(k, x)| x.is_finite() && (periods[k].is_some() || domain[k].contains(*x)));
        if !in_domain || self.loops.is_empty() {
            return in_domain;
        }
        // A loop that closes only after a period encloses nothing alone: such loops count together.
        let (plain, round): (Vec<_>, Vec<_>) =
            self.loops.iter().partition(|trim| trim.turns() == [0, 0]);
        // Even-odd rule: every loop round the point changes its side.
        let odd = plain.iter().filter(|trim| inside_plain(trim, [u, v], periods)).count() % 2 == 1;
        odd != (!round.is_empty() && inside_round(&round, [u, v], periods))
    }

    /// Returns the unit normal on the cutter's side; `None` where the surface has none.
    pub fn normal(&self, u: f64, v: f64) -> Option<UnitVector3<f64>> {
        let jet = self.surface.jet2(u, v);
        let n = jet.normal_towards(self.inwards(u, v))?;
        Some(if self.flip { -n } else { n })
    }

    /// Returns the point at `(u, v)`.
    pub fn point(&self, u: f64, v: f64) -> Point3<f64> {
        self.surface.point(u, v)
    }

    /// Returns a step from `(u, v)` towards the middle of the face: where limits are taken.
    pub(crate) fn inwards(&self, u: f64, v: f64) -> [f64; 2] {
        let [bu, bv] = self.bounds();
        [bu.middle() - u, bv.middle() - v]
    }
}

/// More copies of a point than this over a loop's box are no trim but a broken file.
const TURNS: usize = 1000;

/// Returns the values of a parameter, `x` plus whole periods, that lie within a range.
fn copies(x: f64, within: Interval, period: Option<f64>) -> impl Iterator<Item = f64> {
    let Interval { low, high } = within;
    // The lowest copy not below `low`.
    let first = period.map_or(x, |period| low + (x - low).rem_euclid(period));
    let count = if period.is_some() { TURNS } else { 1 };
    (0..count)
        .map(move |turn| first + turn as f64 * period.unwrap_or(0.0))
        .take_while(move |x| *x <= high)
        .filter(move |x| *x >= low)
}

/// Returns the values as [`copies`] does for a loop that runs round the period, counted from its
/// joint so that a point on the joint's line has copies exactly at the loop's ends.
fn round_copies(x: f64, trim: &TrimLoop, across: usize, period: f64) -> impl Iterator<Item = f64> {
    let (Interval { low, high }, joint) = (trim.bounds()[across], trim.joint()[across]);
    let past = (x - joint).rem_euclid(period);
    // Within rounding of the joint the copy is put on it: the half-open rule then counts it once.
    let on_joint = past.min(period - past) <= ROUNDING * (period + x.abs());
    let base = if on_joint { joint } else { joint + past };
    let first = ((low - base) / period).ceil();
    (0..TURNS)
        .map(move |turn| base + (first + turn as f64) * period)
        .take_while(move |x| *x <= high)
}

/// Returns `true` if `point`, on some turn, lies inside a loop that does not run round the period.
fn inside_plain(trim: &TrimLoop, point: [f64; 2], periods: [Option<f64>; 2]) -> bool {
    let [bu, bv] = trim.bounds();
    let points = copies(point[0], bu, periods[0])
        .flat_map(|u| copies(point[1], bv, periods[1]).map(move |v| [u, v]));
    points.map(|copy| trim.crossings(copy, 0)).sum::<u32>() % 2 == 1
}

/// Returns `true` if `point` lies inside loops that run round the period: parity of the crossings
/// of a ray across them.
///
/// A point beyond all of them belongs to the face or not by the sense of the outermost loop (the
/// face is on a loop's left), where that can be: where the surface is periodic that way too, or the
/// turns do not cancel (a cap round a pole).
fn inside_round(loops: &[&TrimLoop], mut point: [f64; 2], periods: [Option<f64>; 2]) -> bool {
    let along = usize::from(loops.iter().any(|trim| trim.turns()[0] != 0));
    let across = 1 - along;
    if let Some(period) = periods[along] {
        // On the lowest turn, where the ray meets all that lies beyond the point.
        let low = loops.iter().map(|trim| trim.bounds()[along].low).fold(f64::INFINITY, f64::min);
        point[along] = low + (point[along] - low).rem_euclid(period);
    }
    let crossings = |trim: &&TrimLoop| {
        round_copies(point[across], trim, across, periods[across].unwrap_or(f64::INFINITY))
            .map(|x| {
                let mut copy = point;
                copy[across] = x;
                trim.crossings(copy, along)
            })
            .sum::<u32>()
    };
    let count: u32 = loops.iter().map(crossings).sum();
    let net: i32 = loops.iter().map(|trim| trim.turns()[across]).sum();
    let high = |trim: &TrimLoop| trim.bounds()[along].high;
    let outermost = loops.iter().max_by(|a, b| high(a).total_cmp(&high(b)));
    let outermost = outermost.map_or(0, |trim| trim.turns()[across]);
    let sense = if periods[along].is_some() { outermost } else { net };
    // Parity gives the side relative to the far end of the ray, `beyond` the side of that end.
    (count % 2 == 1) != beyond(sense, along)
}

/// Returns `true` if the high end of parameter `along` is on the left of loops that make these
/// turns by the other one: left of a loop towards +u is +v, left of one towards +v is -u.
fn beyond(turns: i32, along: usize) -> bool {
    turns != 0 && (turns > 0) == (along == 1)
}

/// Moves loops by whole periods: the largest into the domain, the others next to it.
fn centre_loops(surface: &Surface, loops: &mut [TrimLoop]) {
    let (domain, periods) = (surface.domain(), surface.periods());
    for k in 0..2 {
        let Some(period) = periods[k] else { continue };
        let width = |trim: &TrimLoop| trim.bounds()[k].width();
        let centre = |trim: &TrimLoop| trim.bounds()[k].middle();
        let Some(largest) = loops.iter().max_by(|a, b| width(a).total_cmp(&width(b))) else {
            return;
        };
        // The largest loop goes into the domain, then every other within half a period of it.
        let turn = ((centre(largest) - domain[k].low) / period).floor();
        let middle = centre(largest) - turn * period;
        for trim in loops.iter_mut() {
            let turn = ((centre(trim) - middle) / period).round();
            let mut step = [0.0; 2];
            step[k] = -turn * period;
            if turn != 0.0 {
                trim.shift(step);
            }
        }
    }
}
