//! A slow search for the widest strip that shares nothing with the library: own distances, own
//! placement of the circle, random trials around the best found.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};
use trunnion::positioning::ToleranceBand;
use trunnion::surface::{
    Face, FaceIndex, NurbsSurface, SphereSurface, Surface, SurfaceFrame, TorusSurface,
};

/// Half the side of the square over which quadrics are defined.
const HALF: f64 = 60.0;

/// Surfaces through the origin, where their normal is z.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    /// z = (k1 x^2 + k2 y^2) / 2: bowls, hills, saddles and cylinders.
    Quadric([f64; 2]),
    /// The same away from its middle: at `[x, y]`, turned so that the normal there is z.
    Slope { k: [f64; 2], at: [f64; 2] },
    /// Ball of this radius below the origin; the inside of one above it where negative.
    Ball(f64),
    /// Cylinder of this radius along x below the origin; the inside of one above it where negative.
    Rod(f64),
    /// Ring whose circle of radius `minor` passes through the origin, `turn` past its outermost
    /// point; its axis lies in the plane y = 0. Seen from its inside where `minor` is negative.
    Ring { major: f64, minor: f64, turn: f64 },
}

/// z = (k1 x^2 + k2 y^2) / 2 over a square; u along x, v along y, (0.5, 0.5) at the origin.
pub(crate) fn quadric(k1: f64, k2: f64) -> FaceIndex {
    moved_quadric([k1, k2], &|p| p)
}

fn moved_quadric([k1, k2]: [f64; 2], moved: &dyn Fn(Point3<f64>) -> Point3<f64>) -> FaceIndex {
    // Bezier ordinates of x^2 over [-h, h] are h^2, -h^2, h^2.
    let square = |i: usize| if i == 1 { -HALF * HALF } else { HALF * HALF };
    let place = |i: usize| [-HALF, 0.0, HALF][i];
    let point = |i, j| Point3::new(place(i), place(j), 0.5 * (k1 * square(i) + k2 * square(j)));
    bezier((0..3).map(|i| (0..3).map(|j| moved(point(i, j))).collect()).collect())
}

/// A third of a cylinder along x as a rational patch, the origin in its middle, u along x.
fn rod(radius: f64) -> FaceIndex {
    let (sin, cos) = (std::f64::consts::PI / 3.0).sin_cos();
    let arc = [[-sin, cos - 1.0], [0.0, 1.0 / cos - 1.0], [sin, cos - 1.0]];
    let row = |x: f64| arc.map(|[y, z]| Point3::new(x, y * radius.abs(), z * radius)).to_vec();
    let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]];
    let weights = Some(vec![vec![1.0, cos, 1.0]; 2]);
    let surface = NurbsSurface::new([1, 2], knots, vec![row(-HALF), row(HALF)], weights).unwrap();
    index(Surface::Nurbs(surface))
}

/// Rotation of a quadric's normal at `[x, y]` into z, and that place.
fn upright([k1, k2]: [f64; 2], [x, y]: [f64; 2]) -> (Rotation3<f64>, Point3<f64>) {
    let normal = Vector3::new(-k1 * x, -k2 * y, 1.0);
    let rotation = Rotation3::rotation_between(&normal, &Vector3::z()).unwrap();
    (rotation, Point3::new(x, y, 0.5 * (k1 * x * x + k2 * y * y)))
}

pub(crate) fn bezier(points: Vec<Vec<Point3<f64>>>) -> FaceIndex {
    let degree = points.len() - 1;
    let knots = || [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    let surface = NurbsSurface::new([degree, degree], [knots(), knots()], points, None).unwrap();
    index(Surface::Nurbs(surface))
}

fn index(surface: Surface) -> FaceIndex {
    sided(surface, false)
}

fn sided(surface: Surface, flip: bool) -> FaceIndex {
    FaceIndex::new(Face { flip, ..Face::new(1, surface, Vec::new()).unwrap() }).unwrap()
}

impl Shape {
    /// Signed distance.
    pub(crate) fn distance(&self, p: &Point3<f64>) -> f64 {
        match *self {
            Self::Quadric(k) => quadric_distance(k, p),
            Self::Slope { k, at } => {
                let (rotation, place) = upright(k, at);
                quadric_distance(k, &(place + rotation.inverse() * p.coords))
            }
            Self::Ball(radius) => {
                let out = (p - Point3::new(0.0, 0.0, -radius)).norm();
                radius.signum() * (out - radius.abs())
            }
            Self::Rod(radius) => radius.signum() * (p.y.hypot(p.z + radius) - radius.abs()),
            Self::Ring { major, minor, .. } => {
                let (middle, axis) = self.ring();
                let out = p - middle;
                let height = axis.dot(&out);
                let to_circle = (out.cross(&axis).norm() - major).hypot(height);
                minor.signum() * (to_circle - minor.abs())
            }
        }
    }

    /// Middle and axis of a ring.
    fn ring(&self) -> (Point3<f64>, Vector3<f64>) {
        let Self::Ring { major, minor, turn } = *self else { unreachable!() };
        let (sin, cos) = turn.sin_cos();
        // The normal cos(turn) out + sin(turn) axis is z, or -z where the inside is meant.
        let sign = minor.signum();
        let out = Vector3::new(sin, 0.0, sign * cos);
        let axis = Vector3::new(-cos, 0.0, sign * sin);
        (Point3::from(Vector3::z() * -minor - out * major), axis)
    }

    fn foot(&self, p: &Point3<f64>) -> (Point3<f64>, Vector3<f64>) {
        let d = self.distance(p);
        // Gradient of the distance by central differences points along the normal.
        let h = 1e-4;
        let slope = |k: usize| {
            let mut step = Vector3::zeros();
            step[k] = h;
            (self.distance(&(p + step)) - self.distance(&(p - step))) / (2.0 * h)
        };
        let n = Vector3::new(slope(0), slope(1), slope(2)).normalize();
        (p - n * d, n)
    }

    /// The same surface for the library, parameters of the origin, and of a heading there.
    pub(crate) fn face(&self, degrees: f64) -> (FaceIndex, [f64; 2], [f64; 2]) {
        let face = match *self {
            Self::Quadric([k1, k2]) => quadric(k1, k2),
            Self::Slope { k, at } => {
                let (rotation, place) = upright(k, at);
                moved_quadric(k, &|p| Point3::from(rotation * (p - place)))
            }
            Self::Ball(radius) => {
                // The poles lie to the sides.
                let origin = Point3::new(0.0, 0.0, -radius);
                let frame =
                    SurfaceFrame::new(origin, Vector3::new(1.0, 2.0, 0.0), Vector3::z()).unwrap();
                let sphere = SphereSurface::new(frame, radius.abs()).unwrap();
                sided(Surface::Sphere(sphere), radius < 0.0)
            }
            Self::Rod(radius) => rod(radius),
            Self::Ring { major, minor, .. } => {
                let (origin, axis) = self.ring();
                let frame = SurfaceFrame::new(origin, axis, Vector3::y()).unwrap();
                let torus = TorusSurface::new(frame, major, minor.abs()).unwrap();
                sided(Surface::Torus(torus), minor < 0.0)
            }
        };
        let at = face.closest(&Point3::origin()).unwrap();
        // As near as a foot is sought: what that shifts the strip by is far below what is compared.
        let (off, turned) =
            (at.point.coords.norm(), (at.normal.into_inner() - Vector3::z()).norm());
        assert!(off < 1e-6 && turned < 1e-7, "{self:?}: {off} {turned} {at:?}");
        let (sin, cos) = degrees.to_radians().sin_cos();
        let way = Vector3::new(cos, sin, 0.0);
        let [su, sv] = [at.jet.su, at.jet.sv];
        let [e, f, g] = [su.dot(&su), su.dot(&sv), sv.dot(&sv)];
        let (p, q) = (su.dot(&way), sv.dot(&way));
        let area = e * g - f * f;
        let feed = [(g * p - f * q) / area, (e * q - f * p) / area];
        (face, at.uv.into(), feed)
    }
}

/// By Newton's method on the foot's place.
fn quadric_distance([k1, k2]: [f64; 2], p: &Point3<f64>) -> f64 {
    let (mut x, mut y) = (p.x, p.y);
    let mut z = 0.0;
    for _ in 0..50 {
        z = 0.5 * (k1 * x * x + k2 * y * y);
        let h = p.z - z;
        // Half the squared distance: gradient and Hessian.
        let g = [x - p.x - h * k1 * x, y - p.y - h * k2 * y];
        let a = 1.0 - h * k1 + (k1 * x).powi(2);
        let c = 1.0 - h * k2 + (k2 * y).powi(2);
        let b = k1 * x * k2 * y;
        let determinant = a * c - b * b;
        let step = [(b * g[1] - c * g[0]) / determinant, (b * g[0] - a * g[1]) / determinant];
        x += step[0];
        y += step[1];
        if step[0].abs() + step[1].abs() < 1e-13 {
            break;
        }
    }
    let n = Vector3::new(-k1 * x, -k2 * y, 1.0).normalize();
    n.dot(&(p - Point3::new(x, y, z)))
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    pub(crate) shape: Shape,
    pub(crate) major: f64,
    pub(crate) minor: f64,
    pub(crate) band: ToleranceBand,
    pub(crate) degrees: f64,
    pub(crate) left: bool,
    /// Whether the contact arc lies behind the centre.
    pub(crate) behind: bool,
}

/// Centre circle of a location: angle 0 opposite to `back`, `half` the arc over the strip.
struct Circle {
    center: Point3<f64>,
    axis: Vector3<f64>,
    e2: Vector3<f64>,
    back: Vector3<f64>,
    half: f64,
}

impl Task {
    fn circle(&self, [w, alpha, theta]: [f64; 3]) -> Option<Circle> {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let a = Vector3::new(cos, sin, 0.0);
        let mirror = if self.left { -1.0 } else { 1.0 };
        let v = a.cross(&Vector3::z()) * mirror;
        let lift = self.minor + self.band.upper;
        let p3 = Point3::from((v * alpha.cos() + a * alpha.sin()) * w);
        let (p2, n2) = self.shape.foot(&p3);
        let c1 = Point3::new(0.0, 0.0, lift);
        let c2 = p2 + n2 * lift;
        let chord = (c2 - c1).norm();
        let reach = self.major * self.major - 0.25 * chord * chord;
        if w <= 0.0 || reach <= 0.0 {
            return None;
        }
        let e2 = (c2 - c1) / chord;
        let e1 = (Vector3::z() - e2 * e2.z).normalize();
        let e3 = e1.cross(&e2) * if self.behind { -mirror } else { mirror };
        let back = e1 * theta.sin() - e3 * theta.cos();
        let axis = e1 * theta.cos() + e3 * theta.sin();
        let center = nalgebra::center(&c1, &c2) + back * reach.sqrt();
        Some(Circle { center, axis, e2, back, half: (0.5 * chord / self.major).asin() })
    }

    /// Width of the location, if it keeps the band everywhere.
    fn width(&self, x: [f64; 3]) -> Option<f64> {
        let Circle { center, axis, e2, back, half } = self.circle(x)?;
        let keeps = |psi: f64, front: bool| {
            let q = center + (e2 * psi.sin() - back * psi.cos()) * self.major;
            let error = self.shape.distance(&q) - self.minor;
            let top = if front { self.band.upper + 1e-9 } else { f64::INFINITY };
            error >= self.band.lower - 1e-9 && error <= top
        };
        // Closer together towards the ends, where the error may leave the band at once.
        let front = (1..60).map(|k| half * (f64::from(k) * std::f64::consts::PI / 60.0).cos());
        let rear = (0..60)
            .map(|k| half + 2.0 * (std::f64::consts::PI - half) * (f64::from(k) + 0.5) / 60.0);
        let fits = keeps(0.0, true)
            && keeps(0.5 * half, true)
            && keeps(std::f64::consts::PI, false)
            && front.into_iter().all(|psi| keeps(psi, true))
            && rear.into_iter().all(|psi| keeps(psi, false))
            && self.disc_keeps(&(center - axis * self.minor), [&e2, &back]);
        fits.then(|| x[0] * x[1].cos())
    }

    /// Lowest point of the disc by ever finer rings of trials around the lowest so far.
    fn disc_keeps(&self, center: &Point3<f64>, [x, y]: [&Vector3<f64>; 2]) -> bool {
        let height = |[a, b]: [f64; 2]| self.shape.distance(&(center + x * a + y * b));
        let mut best = (height([0.0, 0.0]), [0.0, 0.0]);
        let mut reach = 0.5 * self.major;
        while reach > 1e-3 * self.major {
            let (lowest, around) = best;
            for k in 0..12 {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
                let at = [around[0] + reach * cos, around[1] + reach * sin];
                let out = (at[0].hypot(at[1]) / self.major).max(1.0);
                let at = at.map(|x| x / out);
                let h = height(at);
                if h < best.0 {
                    best = (h, at);
                }
            }
            if best.0 >= lowest {
                reach *= 0.5;
            }
        }
        best.0 >= self.band.lower - 1e-9
    }

    /// Best width found, and where, by a grid and random trials around the best, ever closer.
    pub(crate) fn best(&self, range: [f64; 2], trials: u32) -> (f64, [f64; 3]) {
        let mut best = (0.0, [0.0; 3]);
        let keep = |x: [f64; 3], best: &mut (f64, [f64; 3])| {
            // Trials that cannot win are not worth their check.
            if x[0] * x[1].cos() > best.0
                && x[2].abs() <= LEAN
                && let Some(width) = self.width(x)
            {
                *best = (width, x);
            }
        };
        for i in 0..9 {
            let alpha = range[0] + (range[1] - range[0]) * (f64::from(i) + 0.5) / 9.0;
            for j in 0..30 {
                let theta = 0.6 * (f64::from(j) / 30.0).powi(2) - 0.01;
                for k in 1..30 {
                    keep([2.0 * self.major * f64::from(k) / 30.0, alpha, theta], &mut best);
                }
            }
        }
        let mut random = Random::new(88_172_645_463_325_252);
        for trial in 0..trials {
            // A spread of scales at every stage: corners of the feasible set are narrow.
            let scale = 10.0_f64.powf(-4.0 * f64::from(trial % 64) / 64.0);
            let [w, alpha, theta] = best.1;
            let mut share = || random.within(-0.5, 0.5);
            let x = [
                w + scale * self.major * share(),
                (alpha + scale * share()).clamp(range[0], range[1]),
                theta + 0.1 * scale * share(),
            ];
            keep(x, &mut best);
        }
        best
    }

    /// Largest error over a fine sampling of the arc between the end points of a location.
    pub(crate) fn highest(&self, x: [f64; 3]) -> f64 {
        let Circle { center, e2, back, half, .. } = self.circle(x).unwrap();
        let error = |k: u32| {
            let (sin, cos) = (half * (f64::from(k) / 500.0 - 1.0)).sin_cos();
            let q = center + (e2 * sin - back * cos) * self.major;
            self.shape.distance(&q) - self.minor
        };
        (0..=1000).map(error).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the shank of 120 mm comes closer than a hair at the location.
    pub(crate) fn shank_touches(&self, x: [f64; 3]) -> bool {
        let Some(Circle { center, axis, e2, back, .. }) = self.circle(x) else { return true };
        let tip = center - axis * self.minor;
        let point = |k: u32, i: u32| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 60.0).sin_cos();
            let height = self.minor + f64::from(i) * (120.0 - self.minor) / 60.0;
            tip + axis * height + (e2 * cos + back * sin) * (self.major + self.minor)
        };
        let hair = 0.01 * (self.major + self.minor);
        (0..=60).any(|i| {
            (0..60).any(|k| self.shape.distance(&point(k, i)) < hair + f64::from(i.min(1)) * hair)
        })
    }

    /// Least error over a fine sampling of circle and disc of a pose.
    pub(crate) fn deepest(&self, tip: &Point3<f64>, axis: &UnitVector3<f64>) -> f64 {
        let x = axis.cross(&Vector3::new(0.3, 1.0, 0.1)).normalize();
        let y = axis.cross(&x);
        let center = tip + axis.scale(self.minor);
        let mut least = f64::INFINITY;
        for k in 0..3600 {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 3600.0).sin_cos();
            let q = center + (x * cos + y * sin) * self.major;
            least = least.min(self.shape.distance(&q) - self.minor);
            let inside = tip + (x * cos + y * sin) * (self.major * f64::from(k % 30) / 30.0);
            least = least.min(self.shape.distance(&inside));
        }
        least
    }
}

/// Largest rotation \[rad\] the library tries.
const LEAN: f64 = 1.5;

/// Xorshift numbers.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed | 1)
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        let Self(state) = self;
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        low + (high - low) * ((*state >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// Task number `case` of a seed.
pub(crate) fn task(seed: u64, case: u32) -> Task {
    // Odd multiplier of splitmix64: neighbouring cases have nothing in common.
    let mix = seed.wrapping_add(u64::from(case) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut random = Random::new(mix ^ (mix >> 31));
    for _ in 0..8 {
        random.within(0.0, 1.0);
    }
    let major = random.within(3.0, 12.0);
    let minor = random.within(1.0, 8.0);
    let limit = 0.6 / (major + minor);
    let mut curvature = || {
        let x = random.within(-1.0, 1.0);
        x * x.abs() * limit
    };
    let [k1, k2] = [curvature(), curvature()];
    // A closed surface around the tool has to be larger than the tool is long.
    let mut inside = || -random.within(100.0, 400.0);
    let shape = match case % 12 {
        0 => Shape::Quadric([k1, 0.0]),
        1 => Shape::Quadric([k1, k1]),
        2 => Shape::Ball(k1.abs().max(0.05 * limit).recip()),
        3 | 4 => {
            let minor = k1.abs().max(0.05 * limit).recip();
            let major = minor + k2.abs().max(0.05 * limit).recip();
            Shape::Ring { major, minor, turn: random.within(-3.1, 3.1) }
        }
        5 => Shape::Ball(inside()),
        6 => {
            let minor = inside();
            let major = -minor + k2.abs().max(0.05 * limit).recip();
            Shape::Ring { major, minor, turn: random.within(-3.1, 3.1) }
        }
        7 => Shape::Rod(if k1 < 0.0 { k1.abs().max(0.05 * limit).recip() } else { inside() }),
        8 | 9 => {
            let at = [random.within(-30.0, 30.0), random.within(-30.0, 30.0)];
            Shape::Slope { k: [k1, k2], at }
        }
        _ => Shape::Quadric([k1, k2]),
    };
    let lower = if case % 5 == 4 { random.within(-0.004, 0.004) } else { 0.0 };
    let band = ToleranceBand { lower, upper: lower + random.within(0.004, 0.03) };
    let (degrees, left) = (random.within(0.0, 360.0), random.within(0.0, 1.0) < 0.5);
    let behind = random.within(0.0, 1.0) < 0.25;
    Task { shape, major, minor, band, degrees, left, behind }
}
