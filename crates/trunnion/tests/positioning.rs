//! Cutter locations against the reference cases, brute force, and symmetry.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use trunnion::cutter::{Construction, Cutter, CutterSpec, Kind};
use trunnion::positioning::{
    Active, AxisNear, Band, ContactSide, Location, Look, PositioningError, Request, Setting,
    StripSide, inclined, strip_of_pose, widest,
};
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};

const CASES: &str = include_str!("../../../fixtures/positioning/cases.json");

fn bezier(points: Vec<Vec<Point3<f64>>>) -> FaceIndex {
    let degree = points.len() - 1;
    let knots = || [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    let surface = NurbsSurface::new([degree, degree], [knots(), knots()], points, None).unwrap();
    FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new(), false).unwrap()).unwrap()
}

/// The bicubic patch of the reference cases: printed rows are y, columns x; u along x.
fn patch(cases: &Value) -> FaceIndex {
    let number = |value: &Value| value.as_f64().unwrap();
    let places = &cases["patch"]["places"];
    let heights = &cases["patch"]["heights"];
    let point = |i: usize, j: usize| {
        Point3::new(number(&places[i]), number(&places[j]), number(&heights[j][i]))
    };
    bezier((0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect())
}

/// Half the side of the square over which quadrics are defined.
const HALF: f64 = 60.0;

/// z = (k1 x^2 + k2 y^2) / 2 over a square; u along x, v along y, (0.5, 0.5) at the origin.
fn quadric(k1: f64, k2: f64) -> FaceIndex {
    // Bezier ordinates of x^2 over [-h, h] are h^2, -h^2, h^2.
    let square = |i: usize| if i == 1 { -HALF * HALF } else { HALF * HALF };
    let place = |i: usize| [-HALF, 0.0, HALF][i];
    let point = |i, j| Point3::new(place(i), place(j), 0.5 * (k1 * square(i) + k2 * square(j)));
    bezier((0..3).map(|i| (0..3).map(|j| point(i, j)).collect()).collect())
}

fn cutter(major: f64, minor: f64) -> Cutter {
    let kind = match (major > 0.0, minor > 0.0) {
        (true, true) => Kind::Bull,
        (true, false) => Kind::Flat,
        (false, _) => Kind::Ball,
    };
    let construction = Construction::Solid;
    let shank = Vec::new();
    Cutter::new(CutterSpec { kind, major, minor, length: 120.0, construction, shank }).unwrap()
}

fn request<'a>(face: &'a FaceIndex, cutter: &'a Cutter, feed: [f64; 2]) -> Request<'a> {
    Request {
        face,
        cutter,
        band: Band { lower: 0.0, upper: 0.01 },
        at: [0.5, 0.5],
        feed,
        strip: StripSide::Right,
        side: ContactSide::Ahead,
        offset_range: [-0.4, 0.4],
        axis_near: None,
    }
}

fn heading(degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos, sin]
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
}

#[test]
fn the_reference_cases_are_reached() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    let pair = |value: &Value| [0, 1].map(|k| value[k].as_f64().unwrap());
    for case in cases["cases"].as_array().unwrap() {
        let number = |name: &str| case[name].as_f64().unwrap();
        let ahead = number("side") > 0.0;
        let side = if ahead { ContactSide::Ahead } else { ContactSide::Behind };
        let request = Request {
            at: pair(&case["at"]),
            side,
            offset_range: pair(&case["offset_range_deg"]).map(f64::to_radians),
            ..request(&face, &bull, pair(&case["feed"]))
        };
        let found = widest(&request, None).unwrap();
        let name = case["id"].as_str().unwrap();
        close(name, found.chord_width, number("width"), number("width_tolerance"));
        assert!(found.strip_width >= found.chord_width - 1e-3, "{name}");
        close(name, found.offset_direction.to_degrees(), number("alpha_deg"), 0.2);
        close(name, found.rotation.to_degrees(), number("theta_deg"), 0.01);
        close(name, found.arc, number("arc"), 5e-4);
        for k in 0..3 {
            close(name, found.center[k], case["center"][k].as_f64().unwrap(), 5e-3);
            close(name, found.pose.axis[k], case["axis"][k].as_f64().unwrap(), 1e-4);
        }
        for (zero, angle) in case["zeros"].as_array().unwrap().iter().zip(&found.contact_angles) {
            close(name, *angle, zero.as_f64().unwrap(), 1e-3);
        }
        assert!(found.front_min >= 0.0 && found.rear_min >= 0.0, "{name}: {found:?}");
        assert!(found.front_max <= 0.01 && found.front_max_bound >= found.front_max, "{name}");
        let warm = widest(&request, Some(&found)).unwrap();
        close(name, warm.chord_width, found.chord_width, 1e-5);
        assert!(warm.queries < 250, "{name}: {} queries warm", warm.queries);
    }
}

/// Mirrored in the plane y = 0, the quadric is itself, the heading turns round and the strip
/// changes sides.
#[test]
fn a_mirrored_problem_has_the_mirrored_answer() {
    let bull = cutter(9.0, 4.0);
    for (k1, k2, degrees) in [(0.002, 0.006, 100.0), (-0.004, 0.003, 15.0), (0.0, 0.01, 70.0)] {
        let face = quadric(k1, k2);
        for side in [ContactSide::Ahead, ContactSide::Behind] {
            let right = Request { side, ..request(&face, &bull, heading(degrees)) };
            let left = Request { strip: StripSide::Left, feed: heading(-degrees), ..right };
            let (right, left) = (widest(&right, None).unwrap(), widest(&left, None).unwrap());
            close("width", left.chord_width, right.chord_width, 1e-5);
            close("alpha", left.offset_direction, right.offset_direction, 1e-4);
            close("theta", left.rotation, right.rotation, 1e-5);
            let mirror = Vector3::new(1.0, -1.0, 1.0);
            let tip = right.pose.tip.coords.component_mul(&mirror);
            assert!((left.pose.tip.coords - tip).norm() < 1e-3, "{left:?} {right:?}");
            let axis = right.pose.axis.component_mul(&mirror);
            assert!((left.pose.axis.into_inner() - axis).norm() < 1e-4);
            // The strip lies on the side asked for.
            let n = Vector3::z();
            for (location, sign, angle) in [(&right, 1.0, degrees), (&left, -1.0, -degrees)] {
                let [x, y] = heading(angle);
                let across = Vector3::new(x, y, 0.0).cross(&n) * sign;
                let far = face.face().surface.point(location.far[0], location.far[1]);
                assert!(far.coords.dot(&across) > 0.9 * location.chord_width);
                let ahead = Vector3::new(x, y, 0.0).dot(&(location.contact - location.center));
                assert_eq!(ahead > 0.0, location.side == ContactSide::Ahead);
            }
        }
    }
}

/// A band that starts above zero is a larger corner radius and a narrower band.
#[test]
fn a_shifted_band_is_a_thicker_cutter() {
    let face = quadric(0.001, 0.006);
    let (thin, thick) = (cutter(8.0, 5.0), cutter(8.0, 5.004));
    let shifted = Request {
        band: Band { lower: 0.004, upper: 0.018 },
        ..request(&face, &thin, heading(80.0))
    };
    let plain = Request {
        band: Band { lower: 0.0, upper: 0.014 },
        ..request(&face, &thick, heading(80.0))
    };
    let (shifted, plain) = (widest(&shifted, None).unwrap(), widest(&plain, None).unwrap());
    close("width", shifted.chord_width, plain.chord_width, 1e-5);
    assert!((shifted.center - plain.center).norm() < 1e-4);
    assert!(shifted.front_min >= 0.004 && shifted.rear_min >= 0.004, "{shifted:?}");
}

#[test]
fn a_dense_look_finds_the_strip_again() {
    let face = quadric(0.002, 0.005);
    let bull = cutter(10.0, 6.0);
    let request = request(&face, &bull, heading(95.0));
    let found = widest(&request, None).unwrap();
    let setting = Setting { face: &face, cutter: &bull, band: request.band };
    let [x, y] = heading(95.0);
    let (feed, strip) = (Vector3::new(x, y, 0.0), request.strip);
    let look = Look { feed, strip, contact: found.contact, uv: found.contact_uv };
    let strip = strip_of_pose(&setting, &found.pose, &look).unwrap();
    close("near u", strip.near.0[0], found.near[0], 1e-5);
    close("far v", strip.far.0[1], found.far[1], 1e-5);
    assert!(strip.front_min >= 0.0 && strip.rear_min >= 0.0);
    // Sunk by 2 um it gouges, and the check says so.
    let mut sunk = found.pose;
    sunk.tip -= sunk.axis.scale(0.002);
    let strip = strip_of_pose(&setting, &sunk, &look).unwrap();
    close("gouge", strip.front_min, -0.002, 1e-5);
}

#[test]
fn on_a_plane_the_cutter_is_as_wide_as_its_circle() {
    let face = quadric(0.0, 0.0);
    for bull in [cutter(10.0, 6.0), cutter(10.0, 0.0)] {
        let found = widest(&request(&face, &bull, heading(30.0)), None).unwrap();
        assert!(found.chord_width > 0.995 * 20.0 && found.chord_width <= 20.0, "{found:?}");
        assert!(found.rear_min >= 0.0 && found.rear_min_bound > -1e-3, "{found:?}");
    }
}

#[test]
fn a_ball_on_a_plane_leaves_its_chord() {
    let face = quadric(0.0, 0.0);
    let ball = cutter(0.0, 8.0);
    let found = inclined(&request(&face, &ball, heading(0.0)), 0.1, None).unwrap();
    let half = (8.01_f64.powi(2) - 8.0_f64.powi(2)).sqrt();
    close("width", found.strip_width, 2.0 * half, 1e-6);
    close("start", found.near[0], 0.5, 1e-9);
    // Strip on the right of +x: towards -y, the ball half way.
    close("contact", found.contact.y, -half, 1e-6);
    close("height", found.center.z, 8.0, 1e-9);
    // Contact ahead: the tool leans forward.
    close("lean", found.pose.axis.x, 0.1_f64.sin(), 1e-12);
}

#[test]
fn a_given_lead_is_kept() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    let request = Request { at: [0.4, 0.5], ..request(&face, &bull, [0.0, 1.0]) };
    let lead = 5.0_f64.to_radians();
    let found = inclined(&request, lead, None).unwrap();
    close("lead", found.rotation, lead, 1e-12);
    // Inclined by 5 degrees at a contact there, the strip is 5.436 mm wide (baseline of the
    // reference cases); here the strip begins there, and the contact lies 2.7 mm beside.
    close("width", found.chord_width, 5.436, 0.03 * 5.436);
    let across = Request { offset_range: [0.0, 0.0], ..request };
    let across = inclined(&across, lead, Some(&found)).unwrap();
    assert!(across.chord_width <= found.chord_width, "{across:?}");
    close("alpha", across.offset_direction, 0.0, 0.0);
    assert!(found.active.contains(&Active::GivenLead), "{:?}", found.active);
    assert!(found.front_min >= 0.0 && found.rear_min >= 0.0);
}

#[test]
fn the_tool_axis_can_be_held_near_a_direction() {
    let face = quadric(0.002, 0.005);
    let bull = cutter(10.0, 6.0);
    let free = request(&face, &bull, heading(95.0));
    let found = widest(&free, None).unwrap();
    let [x, y] = heading(95.0);
    let tilt = nalgebra::Rotation3::new(Vector3::new(-y, x, 0.0) * 0.03);
    let axis = tilt * found.pose.axis;
    let held = Request { axis_near: Some(AxisNear { axis, max_turn: 0.01 }), ..free };
    let held = widest(&held, None).unwrap();
    assert!(held.pose.axis.angle(&axis) <= 0.01 + 1e-6, "{held:?}");
    assert!(held.chord_width < found.chord_width);
    assert!(held.active.contains(&Active::AxisTurn), "{:?}", held.active);
    assert!(held.front_min >= 0.0 && held.rear_min >= 0.0);
}

#[test]
fn what_does_not_fit_is_refused_with_the_reason() {
    let bull = cutter(10.0, 6.0);
    let steep = quadric(0.0, 0.2);
    let refused = widest(&request(&steep, &bull, heading(0.0)), None).unwrap_err();
    assert!(matches!(refused, PositioningError::ConcaveRadius { .. }), "{refused}");
    assert!(refused.to_string().contains("5.000 mm"), "{refused}");
    // A trough of 7 mm radius holds the corner of 6 mm, but not the whole cutter across it.
    let trough = quadric(0.0, 1.0 / 7.0);
    let refused = widest(&request(&trough, &bull, heading(0.0)), None).unwrap_err();
    let fits_not =
        matches!(refused, PositioningError::NoStrip { .. } | PositioningError::Body { .. });
    assert!(fits_not, "{refused}");
    let flat = quadric(0.0, 0.0);
    let feed = Request { feed: [0.0, 0.0], ..request(&flat, &bull, heading(0.0)) };
    assert!(matches!(widest(&feed, None), Err(PositioningError::NoDirection { .. })));
    let band = Band { lower: 0.01, upper: 0.01 };
    let empty = Request { band, ..request(&flat, &bull, heading(0.0)) };
    assert!(matches!(widest(&empty, None), Err(PositioningError::EmptyBand { .. })));
    let spec = CutterSpec {
        construction: Construction::Insert { inner_cutting_radius: 8.0 },
        ..bull.spec().clone()
    };
    let insert = Cutter::new(spec).unwrap();
    let behind = Request { side: ContactSide::Either, ..request(&flat, &insert, heading(0.0)) };
    assert!(matches!(widest(&behind, None), Err(PositioningError::NotCentreCutting { .. })));
}

#[test]
fn a_wall_near_the_shank_is_seen() {
    // A trough of 40 mm radius: the cutter of 16 mm fits, a holder of 45 mm radius does not.
    let trough = quadric(0.0, 0.025);
    let spec = CutterSpec { shank: vec![[20.0, 45.0]], ..cutter(10.0, 6.0).spec().clone() };
    let wide = Cutter::new(spec).unwrap();
    let slim = cutter(10.0, 6.0);
    assert!(widest(&request(&trough, &slim, heading(0.0)), None).is_ok());
    let refused = widest(&request(&trough, &wide, heading(0.0)), None).unwrap_err();
    assert!(matches!(refused, PositioningError::Body { .. }), "{refused}");
}

#[test]
fn strips_may_run_off_the_edge() {
    let cases: Value = serde_json::from_str(CASES).unwrap();
    let face = patch(&cases);
    let bull = cutter(10.0, 6.0);
    for at in [[0.0, 0.5], [-0.1, 0.3], [0.5, 1.1]] {
        let found = widest(&Request { at, ..request(&face, &bull, [0.0, 1.0]) }, None).unwrap();
        assert!(found.front_min >= 0.0 && found.rear_min >= 0.0, "{at:?} {found:?}");
        assert!(found.chord_width > 1.0, "{at:?} {}", found.chord_width);
    }
}

mod brute_force {
    //! A slow search that shares nothing with the library: own closest points on the quadric, own
    //! placement of the circle, random trials around the best found.
    use super::{Band, Point3, Vector3};

    pub(crate) struct Quadric {
        pub(crate) k: [f64; 2],
    }

    impl Quadric {
        /// Signed distance by Newton's method on the foot's place.
        pub(crate) fn distance(&self, p: &Point3<f64>) -> f64 {
            let [k1, k2] = self.k;
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
                let step =
                    [(b * g[1] - c * g[0]) / determinant, (b * g[0] - a * g[1]) / determinant];
                x += step[0];
                y += step[1];
                if step[0].abs() + step[1].abs() < 1e-13 {
                    break;
                }
            }
            let n = Vector3::new(-k1 * x, -k2 * y, 1.0).normalize();
            n.dot(&(p - Point3::new(x, y, z)))
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
    }

    pub(crate) struct Task {
        pub(crate) surface: Quadric,
        pub(crate) major: f64,
        pub(crate) minor: f64,
        pub(crate) band: Band,
        pub(crate) degrees: f64,
        pub(crate) left: bool,
    }

    impl Task {
        /// Width of the location, if it keeps the band everywhere.
        fn width(&self, [w, alpha, theta]: [f64; 3]) -> Option<f64> {
            let (sin, cos) = self.degrees.to_radians().sin_cos();
            let a = Vector3::new(cos, sin, 0.0);
            let mirror = if self.left { -1.0 } else { 1.0 };
            let v = a.cross(&Vector3::z()) * mirror;
            let lift = self.minor + self.band.upper;
            let p3 = Point3::from((v * alpha.cos() + a * alpha.sin()) * w);
            let (p2, n2) = self.surface.foot(&p3);
            let c1 = Point3::new(0.0, 0.0, lift);
            let c2 = p2 + n2 * lift;
            let chord = (c2 - c1).norm();
            let reach = self.major * self.major - 0.25 * chord * chord;
            if w <= 0.0 || reach <= 0.0 {
                return None;
            }
            let e2 = (c2 - c1) / chord;
            let e1 = (Vector3::z() - e2 * e2.z).normalize();
            let e3 = e1.cross(&e2) * mirror;
            let back = e1 * theta.sin() - e3 * theta.cos();
            let axis = e1 * theta.cos() + e3 * theta.sin();
            let center = nalgebra::center(&c1, &c2) + back * reach.sqrt();
            let half = (0.5 * chord / self.major).asin();
            let keeps = |psi: f64, front: bool| {
                let q = center + (e2 * psi.sin() - back * psi.cos()) * self.major;
                let error = self.surface.distance(&q) - self.minor;
                let top = if front { self.band.upper + 1e-9 } else { f64::INFINITY };
                error >= self.band.lower - 1e-9 && error <= top
            };
            let front = (1..60).map(|k| half * (f64::from(k) / 30.0 - 1.0));
            let rear = (0..60)
                .map(|k| half + 2.0 * (std::f64::consts::PI - half) * (f64::from(k) + 0.5) / 60.0);
            let fits = keeps(0.0, true)
                && keeps(0.5 * half, true)
                && keeps(std::f64::consts::PI, false)
                && front.into_iter().all(|psi| keeps(psi, true))
                && rear.into_iter().all(|psi| keeps(psi, false))
                && self.disc_keeps(&(center - axis * self.minor), [&e2, &back]);
            fits.then(|| w * alpha.cos())
        }

        /// Lowest point of the disc by ever finer rings of trials around the lowest so far.
        fn disc_keeps(&self, center: &Point3<f64>, [x, y]: [&Vector3<f64>; 2]) -> bool {
            let height = |[a, b]: [f64; 2]| self.surface.distance(&(center + x * a + y * b));
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

        /// Best width found by a grid and random trials around the best, ever closer.
        pub(crate) fn best(&self, range: [f64; 2], trials: u32) -> f64 {
            let mut best = (0.0, [0.0; 3]);
            let keep = |x: [f64; 3], best: &mut (f64, [f64; 3])| {
                // Trials that cannot win are not worth their check.
                if x[0] * x[1].cos() > best.0
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
            let mut state = 88_172_645_463_325_252_u64;
            let mut random = move || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            for trial in 0..trials {
                // A spread of scales at every stage: corners of the feasible set are narrow.
                let scale = 10.0_f64.powf(-4.0 * f64::from(trial % 64) / 64.0);
                let [w, alpha, theta] = best.1;
                let x = [
                    w + scale * self.major * random(),
                    (alpha + scale * random()).clamp(range[0], range[1]),
                    theta + 0.1 * scale * random(),
                ];
                keep(x, &mut best);
            }
            best.0
        }

        /// Least error over a fine sampling of circle and disc of a pose.
        pub(crate) fn deepest(&self, tip: &Point3<f64>, axis: &Vector3<f64>) -> f64 {
            let x = axis.cross(&Vector3::new(0.3, 1.0, 0.1)).normalize();
            let y = axis.cross(&x);
            let center = tip + axis * self.minor;
            let mut least = f64::INFINITY;
            for k in 0..3600 {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 3600.0).sin_cos();
                let q = center + (x * cos + y * sin) * self.major;
                least = least.min(self.surface.distance(&q) - self.minor);
                let inside = tip + (x * cos + y * sin) * (self.major * f64::from(k % 30) / 30.0);
                least = least.min(self.surface.distance(&inside));
            }
            least
        }
    }
}

fn brute_task(task: &brute_force::Task, trials: u32) -> (Result<Location, PositioningError>, f64) {
    let [k1, k2] = task.surface.k;
    let face = quadric(k1, k2);
    let cutter = cutter(task.major, task.minor);
    let strip = if task.left { StripSide::Left } else { StripSide::Right };
    let band = task.band;
    let request = Request { strip, band, ..request(&face, &cutter, heading(task.degrees)) };
    let found = widest(&request, None);
    let best = task.best(request.offset_range, trials);
    (found, best)
}

#[test]
fn never_a_gouge_and_hardly_ever_wider_by_brute_force() {
    let trials: u32 =
        std::env::var("POSITIONING_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(6);
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |low: f64, high: f64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let mut failures = Vec::new();
    for case in 0..trials {
        let major = random(3.0, 12.0);
        let minor = random(1.0, 8.0);
        let limit = 0.6 / (major + minor);
        let curved = |x: f64| x * x.abs();
        let k = [curved(random(-1.0, 1.0)) * limit, curved(random(-1.0, 1.0)) * limit];
        let band = Band { lower: 0.0, upper: random(0.004, 0.03) };
        let (degrees, left) = (random(0.0, 360.0), random(0.0, 1.0) < 0.5);
        let surface = brute_force::Quadric { k };
        let task = brute_force::Task { surface, major, minor, band, degrees, left };
        let (found, best) = brute_task(&task, 6000);
        let what = format!(
            "{case}: k {:?} R {major} r {minor} {band:?} {degrees} left {left}",
            task.surface.k
        );
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                failures.push(format!("{what}: {error}; brute force {best}"));
                continue;
            }
        };
        let least = task.deepest(&found.pose.tip, &found.pose.axis);
        if least < -1e-7 {
            failures.push(format!("{what}: gouge {least} {found:?}"));
        }
        if found.chord_width < 0.995 * best {
            failures.push(format!("{what}: {} < {best} {:?}", found.chord_width, found.active));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
