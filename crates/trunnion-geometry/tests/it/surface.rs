//! Surfaces against independent oracles: a peer's kernel, finite differences, brute force.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
use nalgebra::Point3;
use nalgebra::Point4;
use nalgebra::Rotation3;
use nalgebra::Vector3;
use proptest::prelude::*;
use trunnion::surface::ClosestError;
use trunnion::surface::ConeSurface;
use trunnion::surface::CylinderSurface;
use trunnion::surface::ExtrusionSurface;
use trunnion::surface::Face;
use trunnion::surface::FaceIndex;
use trunnion::surface::NurbsCurve;
use trunnion::surface::NurbsSurface;
use trunnion::surface::PlaneSurface;
use trunnion::surface::RevolutionSurface;
use trunnion::surface::SolidProximity;
use trunnion::surface::SpaceCurve;
use trunnion::surface::SphereSurface;
use trunnion::surface::Surface;
use trunnion::surface::SurfaceFrame;
use trunnion::surface::SurfaceJet;
use trunnion::surface::TorusSurface;
use trunnion::surface::TrimCurve;
use trunnion::surface::TrimLoop;
use trunnion::types::Interval;
use trunnion::types::Uv;

/// The paper's patch: see fixtures/bezier-patch/README.md.
fn bezier_patch() -> Surface {
    let grid = [-60.0, -30.0, 30.0, 60.0];
    let table = [
        [0.0, -20.0, -20.0, 5.0],
        [-5.0, -15.0, -25.0, -5.0],
        [-5.0, -25.0, -20.0, -5.0],
        [5.0, -15.0, -15.0, 0.0],
    ];
    let point = |i: usize, j: usize| Point3::new(grid[i], grid[j], table[j][i]);
    let points = (0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect();
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let net = NurbsSurface::new([3, 3], [knots.clone(), knots], points, None);
    Surface::Nurbs(net.unwrap())
}

/// Deterministic numbers in [-1, 1].
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64) / ((1_u64 << 52) as f64) - 1.0
    }
}

/// Clamped knots with random interior steps.
fn knots(numbers: &mut Numbers, degree: usize, points: usize) -> Vec<f64> {
    let mut knots = vec![0.0; degree + 1];
    for _ in 0..points - degree - 1 {
        let last = knots[knots.len() - 1];
        knots.push(last + 0.6 + 0.5 * numbers.next());
    }
    let end = knots[knots.len() - 1] + 0.7;
    knots.extend(vec![end; degree + 1]);
    knots
}

/// A wavy sheet of about 100 mm x 100 mm.
fn wavy(seed: u64, degree: [usize; 2], count: [usize; 2], rational: bool) -> NurbsSurface {
    let mut numbers = Numbers(seed.wrapping_mul(77).wrapping_add(5));
    let knots = [0, 1].map(|k| knots(&mut numbers, degree[k], count[k]));
    let step = [0, 1].map(|k| 100.0 / (count[k] - 1) as f64);
    let point = |i: usize, j: usize, numbers: &mut Numbers| {
        let [x, y] = [i as f64 * step[0], j as f64 * step[1]];
        let mut shake = || 0.2 * numbers.next();
        Point3::new(x + shake() * step[0], y + shake() * step[1], 75.0 * shake())
    };
    let points =
        (0..count[0]).map(|i| (0..count[1]).map(|j| point(i, j, &mut numbers)).collect()).collect();
    let weights = rational.then(|| {
        (0..count[0]).map(|_| (0..count[1]).map(|_| 1.0 + 0.7 * numbers.next()).collect()).collect()
    });
    NurbsSurface::new(degree, knots, points, weights).unwrap()
}

/// Derivatives to order 3 with names, for comparing.
fn entries(jet: &SurfaceJet) -> [Vector3<f64>; 10] {
    let SurfaceJet { s, su, sv, suu, suv, svv, suuu, suuv, suvv, svvv } = *jet;
    [s.coords, su, sv, suu, suv, svv, suuu, suuv, suvv, svvv]
}

#[test]
fn curvature_of_the_papers_patch() {
    let curvature = bezier_patch().jet2(0.4, 0.5).curvature().unwrap();
    assert!((curvature.min - 0.001_509_81).abs() < 1e-7, "{curvature:?}");
    assert!((curvature.max - 0.005_738_69).abs() < 1e-7, "{curvature:?}");
    let s = bezier_patch().point(0.4, 0.5);
    assert!((s - Point3::new(-13.44, 0.0, -15.365)).norm() < 1e-12, "{s}");
}

/// Each derivative against the central difference of the one below it.
fn check_differences(surface: &Surface, [u, v]: [f64; 2]) {
    let jet = |u: f64, v: f64| entries(&surface.jet(u, v));
    let here = jet(u, v);
    let h = 1e-5;
    let by_u = [jet(u - h, v), jet(u + h, v)];
    let by_v = [jet(u, v - h), jet(u, v + h)];
    let slope = |pair: &[[Vector3<f64>; 10]; 2], k: usize| (pair[1][k] - pair[0][k]) / (2.0 * h);
    // (derivative, the one below it, by which parameter)
    let steps = [
        (1, 0, 0),
        (2, 0, 1),
        (3, 1, 0),
        (4, 2, 0),
        (4, 1, 1),
        (5, 2, 1),
        (6, 3, 0),
        (7, 4, 0),
        (7, 3, 1),
        (8, 5, 0),
        (8, 4, 1),
        (9, 5, 1),
    ];
    for (k, below, direction) in steps {
        let numeric = slope(if direction == 0 { &by_u } else { &by_v }, below);
        let scale = 1.0 + here.iter().map(Vector3::norm).fold(0.0, f64::max);
        let error = (numeric - here[k]).norm() / scale;
        assert!(error < 1e-6, "derivative {k} at ({u}, {v}): {numeric} {} {error:e}", here[k]);
    }
}

#[test]
fn derivatives_agree_with_differences() {
    for (seed, degree) in [(1, [3, 3]), (2, [2, 4]), (3, [5, 3]), (4, [1, 2])] {
        for rational in [false, true] {
            let surface = Surface::Nurbs(wavy(seed, degree, [8, 9], rational));
            let [Interval { low: u0, high: u1 }, Interval { low: v0, high: v1 }] = surface.domain();
            let mut numbers = Numbers(seed + 100);
            for _ in 0..20 {
                // Off the domain too: 20 % beyond every border.
                let u = 0.5 * (u0 + u1) + 0.7 * (u1 - u0) * numbers.next();
                let v = 0.5 * (v0 + v1) + 0.7 * (v1 - v0) * numbers.next();
                check_differences(&surface, [u, v]);
            }
        }
    }
}

#[test]
fn the_continuation_is_twice_continuously_differentiable() {
    for rational in [false, true] {
        let surface = Surface::Nurbs(wavy(9, [3, 4], [7, 6], rational));
        let [Interval { low: u0, high: u1 }, Interval { low: v0, high: v1 }] = surface.domain();
        let h = 1e-12;
        let inside = 0.37;
        let border = [
            ([u0, v0 + inside], [h, 0.0]),
            ([u1, v0 + inside], [h, 0.0]),
            ([u0 + inside, v0], [0.0, h]),
            ([u0 + inside, v1], [0.0, h]),
            // Across the lines that go on from the corners.
            ([u1, v1 + inside], [h, 0.0]),
            ([u1 + inside, v1], [0.0, h]),
            ([u0, v0 - inside], [h, 0.0]),
            ([u0 - inside, v0], [0.0, h]),
        ];
        for ([u, v], [du, dv]) in border {
            let one = entries(&surface.jet(u - du, v - dv));
            let two = entries(&surface.jet(u + du, v + dv));
            for k in 0..6 {
                let size = 1.0 + one[k].norm();
                assert!((one[k] - two[k]).norm() < 1e-8 * size, "derivative {k} at {u} {v}");
            }
        }
    }
}

/// Points of a dense grid with their parameters.
fn dense(surface: &Surface) -> Vec<([f64; 2], Point3<f64>)> {
    let n = 120;
    let at = |range: Interval, k: i32| range.at(f64::from(k) / f64::from(n));
    let [u, v] = surface.domain();
    let all = (0..=n).flat_map(|i| (0..=n).map(move |j| [at(u, i), at(v, j)]));
    all.map(|uv| (uv, surface.point(uv[0], uv[1]))).collect()
}

/// Closest of a dense grid, refined by shrinking grids round the best: no derivatives, no bounds.
fn brute(surface: &Surface, grid: &[([f64; 2], Point3<f64>)], p: &Point3<f64>) -> f64 {
    let bounds = surface.domain();
    let mut best: Vec<_> = grid.iter().map(|(uv, point)| ((point - p).norm(), *uv)).collect();
    let by_distance = |a: &(f64, [f64; 2]), b: &(f64, [f64; 2])| a.0.total_cmp(&b.0);
    best.select_nth_unstable_by(6, by_distance);
    best.truncate(6);
    let refine = |&(mut d, mut uv): &(f64, [f64; 2])| {
        let mut step = bounds.map(|range| range.width() / 120.0);
        for _ in 0..40 {
            let (centre, before) = (uv, d);
            for k in (0..9).filter(|k| *k != 4) {
                let move_by = [f64::from(k / 3 - 1) * step[0], f64::from(k % 3 - 1) * step[1]];
                let to = [0, 1].map(|k| bounds[k].clamp(centre[k] + move_by[k]));
                let there = (surface.point(to[0], to[1]) - p).norm();
                if there < d {
                    (d, uv) = (there, to);
                }
            }
            if d >= before {
                step = step.map(|s| 0.5 * s);
            }
        }
        d
    };
    best.iter().map(refine).fold(f64::INFINITY, f64::min)
}

type Net = (Vec<Vec<Point3<f64>>>, Vec<Vec<f64>>, [Vec<f64>; 2]);

/// A sphere of the peer's making, centre (50, 50, 0), radius 40: quadratic, rational, closed by one
/// parameter and collapsed at the poles.
fn peer_sphere() -> Net {
    use curvo::prelude::NurbsSurface3D;
    let centre = Point3::new(50.0, 50.0, 0.0);
    let sphere = NurbsSurface3D::try_sphere(&centre, &Vector3::z(), &Vector3::x(), 40.0).unwrap();
    let rows = sphere.control_points();
    let points =
        rows.iter().map(|row| row.iter().map(|p| Point3::from(p.coords.xyz() / p.w)).collect());
    let weights = rows.iter().map(|row| row.iter().map(|p| p.w).collect());
    let knots = [sphere.u_knots().to_vec(), sphere.v_knots().to_vec()];
    (points.collect(), weights.collect(), knots)
}

/// The sphere, or with `bump` a potato: control points moved in and out, the seam kept shut.
fn potato(bump: f64) -> Surface {
    let (mut points, weights, knots) = peer_sphere();
    let mut numbers = Numbers(5);
    let centre = Point3::new(50.0, 50.0, 0.0);
    let mut moved: Vec<(Point3<f64>, f64)> = Vec::new();
    for point in points.iter_mut().flatten() {
        let known = moved.iter().find(|(at, _)| (at - *point).norm() < 1e-9).map(|pair| pair.1);
        let share = known.unwrap_or_else(|| 1.0 + bump * numbers.next());
        moved.push((*point, share));
        *point = centre + (*point - centre) * share;
    }
    Surface::Nurbs(NurbsSurface::new([2, 2], knots, points, Some(weights)).unwrap())
}

/// 1000 queries: on the surface, 20, 60 and 120 mm away, inside closed ones; none wrong.
#[test]
fn closest_agrees_with_brute_force() {
    let wavy = |seed, rational| Surface::Nurbs(wavy(seed, [3, 3], [9, 8], rational));
    let surfaces = [wavy(21, false), wavy(22, true), potato(0.0), potato(0.4), bezier_patch()];
    for surface in surfaces {
        let index = FaceIndex::new(Face::new(1, surface.clone(), vec![]).unwrap()).unwrap();
        let grid = dense(&surface);
        let mut numbers = Numbers(3);
        for query in 0..200 {
            let far = [0.0, 20.0, 120.0, -60.0][query % 4];
            let mut around = || 50.0 + 70.0 * numbers.next();
            let p = Point3::new(around(), around(), far + 0.15 * around());
            let foot = index.closest(&p).unwrap();
            let brute = brute(&surface, &grid, &p);
            assert!(foot.distance.abs() <= brute + 1e-6, "{p}: {} against {brute}", foot.distance);
            assert!((surface.point(foot.uv.u, foot.uv.v) - foot.point).norm() < 1e-12);
            assert!((foot.distance.abs() - (p - foot.point).norm()).abs() < 1e-12);
        }
    }
}

/// The centre of a sphere has no one closest point: an answer that says so, or a right distance.
#[test]
fn the_centre_of_a_sphere_is_undecided() {
    let index = FaceIndex::new(Face::new(1, potato(0.0), vec![]).unwrap()).unwrap();
    match index.closest(&Point3::new(50.0, 50.0, 0.0)) {
        Ok(foot) => assert!((foot.distance.abs() - 40.0).abs() < 1e-9, "{foot:?}"),
        Err(error) => assert!(matches!(error, ClosestError::Undecided { .. }), "{error}"),
    }
    let nan = index.closest(&Point3::new(f64::NAN, 0.0, 0.0));
    assert_eq!(nan, Err(ClosestError::NotFinite));
    assert!(index.closest_near(&Point3::new(f64::INFINITY, 0.0, 0.0), Uv::new(0.0, 0.0)).is_err());
}

/// Values and all derivatives to order 3 against the peer's recursive basis functions.
#[test]
fn derivatives_agree_with_the_peers() {
    use curvo::prelude::NurbsSurface3D;
    for (seed, degree) in [(31, [3, 3]), (32, [2, 4]), (33, [5, 3]), (34, [1, 2])] {
        for rational in [false, true] {
            let ours = wavy(seed, degree, [8, 9], rational);
            let lift = |i: usize, j: usize, p: &Point3<f64>| {
                let w = ours.weights().map_or(1.0, |rows| rows[i][j]);
                Point4::new(p.x * w, p.y * w, p.z * w, w)
            };
            let net = ours.points().iter().enumerate();
            let net =
                net.map(|(i, row)| row.iter().enumerate().map(|(j, p)| lift(i, j, p)).collect());
            let [u, v] = ours.knots().each_ref().map(|knots| knots.knots().to_vec());
            let peer = NurbsSurface3D::new(degree[0], degree[1], u, v, net.collect());
            let surface = Surface::Nurbs(ours.clone());
            let [u, v] = surface.domain();
            let width = [u.width(), v.width()];
            let mut numbers = Numbers(seed);
            for _ in 0..50 {
                let (u, v) = (between(u, numbers.next()), between(v, numbers.next()));
                let theirs = peer.rational_derivatives(u, v, 3);
                let order = [
                    (0, 0),
                    (1, 0),
                    (0, 1),
                    (2, 0),
                    (1, 1),
                    (0, 2),
                    (3, 0),
                    (2, 1),
                    (1, 2),
                    (0, 3),
                ];
                for ((k, l), own) in order.into_iter().zip(entries(&surface.jet(u, v))) {
                    let error = (theirs[k][l] - own).norm() / (1.0 + own.norm());
                    assert!(error < 1e-10, "({k}, {l}) at ({u}, {v}): {error:e}");
                }
                // The quick forms, inside and beyond one rim or two, are those of all orders, bit for bit.
                for [over_u, over_v] in [[0.0, 0.0], [1.2, 0.0], [0.0, -1.1], [-1.4, 1.3]] {
                    let [u, v] = [u + over_u * width[0], v + over_v * width[1]];
                    let all = surface.jet(u, v).second();
                    assert_eq!(surface.jet2(u, v), all, "({u}, {v})");
                    assert_eq!(surface.point(u, v), all.s, "({u}, {v})");
                    let one = surface.jet1(u, v);
                    assert_eq!((one.s, one.su, one.sv), (all.s, all.su, all.sv), "({u}, {v})");
                }
            }
        }
    }
}

proptest! {
    /// A point put up on the normal comes back to its foot, also beyond the border.
    #[test]
    fn a_point_on_the_normal_has_that_foot(u in -0.15..1.15_f64, v in -0.15..1.15_f64, h in -20.0..20.0_f64, flip: bool) {
        let surface = bezier_patch();
        let index = FaceIndex::new(Face { flip, ..Face::new(1, surface.clone(), vec![]).unwrap() }).unwrap();
        let side = if flip { -1.0 } else { 1.0 };
        let p = surface.point(u, v) + surface.jet1(u, v).normal().unwrap().scale(h * side);
        let foot = index.closest_near(&p, Uv::new(u + 0.02, v - 0.02)).unwrap();
        prop_assert!((foot.uv.u - u).abs() < 1e-9 && (foot.uv.v - v).abs() < 1e-9, "{:?}", foot);
        prop_assert!((foot.distance - h).abs() < 1e-9, "{:?}", foot);
    }
}

/// One face of every kind, trimmed to a rectangle of parameters where endless.
fn every_kind() -> Vec<(Face, [Interval; 2])> {
    let frame =
        SurfaceFrame::new(Point3::new(1.0, -2.0, 3.0), Vector3::new(0.2, 0.3, 1.0), Vector3::x());
    let frame = frame.unwrap();
    let spline = {
        let points = [
            [20.0, 0.0, -10.0],
            [30.0, 5.0, 0.0],
            [22.0, -3.0, 10.0],
            [28.0, 4.0, 25.0],
            [35.0, 0.0, 30.0],
        ];
        let points = points.map(Point3::from);
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0];
        SpaceCurve::Nurbs(
            NurbsCurve::new(3, knots, &points, Some(&[1.0, 2.0, 0.7, 1.0, 1.3])).unwrap(),
        )
    };
    let ring = SpaceCurve::ellipse(frame, [12.0, 12.0]).unwrap();
    let oval = SpaceCurve::ellipse(frame, [25.0, 9.0]).unwrap();
    let line = SpaceCurve::line(Point3::new(15.0, 0.0, 0.0), Vector3::new(0.1, 0.4, 2.0)).unwrap();
    let z = Vector3::z_axis();
    let off = Point3::new(-40.0, 3.0, 0.0);
    let kinds: Vec<(Surface, [[f64; 2]; 2])> = vec![
        (Surface::Plane(PlaneSurface { frame }), [[-20.0, 30.0], [-10.0, 15.0]]),
        (Surface::Cylinder(CylinderSurface::new(frame, 12.0).unwrap()), [[1.0, 3.0], [-5.0, 20.0]]),
        (Surface::Cone(ConeSurface::new(frame, 5.0, 0.4).unwrap()), [[0.5, 2.5], [-3.0, 30.0]]),
        (Surface::Sphere(SphereSurface::new(frame, 20.0).unwrap()), [[0.5, 3.5], [-1.0, 1.2]]),
        (Surface::Torus(TorusSurface::new(frame, 20.0, 6.0).unwrap()), [[0.5, 3.5], [1.0, 4.2]]),
        (
            Surface::Extrusion(
                ExtrusionSurface::new(spline.clone(), Vector3::new(3.0, 40.0, 4.0)).unwrap(),
            ),
            [[0.0, 1.0], [-0.5, 1.5]],
        ),
        (
            Surface::Extrusion(ExtrusionSurface::new(oval, Vector3::new(0.0, 1.0, 4.0)).unwrap()),
            [[0.4, 5.0], [-5.0, 15.0]],
        ),
        (
            Surface::Revolution(RevolutionSurface::new(spline, Point3::origin(), z).unwrap()),
            [[0.2, 6.0], [0.0, 1.0]],
        ),
        (
            Surface::Revolution(RevolutionSurface::new(ring, off, z).unwrap()),
            [[0.2, 6.0], [0.4, 5.0]],
        ),
        (
            Surface::Revolution(RevolutionSurface::new(line, Point3::origin(), z).unwrap()),
            [[0.2, 4.0], [-8.0, 9.0]],
        ),
    ];
    let face = |(number, (surface, bounds)): (usize, (Surface, [[f64; 2]; 2]))| {
        let [[a, b], [c, d]] = bounds;
        let corners = [[a, c], [b, c], [b, d], [a, d], [a, c]];
        let trim = TrimCurve::polyline(&corners).unwrap();
        let trim = TrimLoop::new(vec![trim], surface.periods(), 1e-9).unwrap();
        (Face::new(number + 1, surface, vec![trim]).unwrap(), bounds.map(Interval::from))
    };
    kinds.into_iter().enumerate().map(face).collect()
}

fn between(range: Interval, x: f64) -> f64 {
    range.low + range.width() * 0.5 * (x + 1.0)
}

#[test]
fn every_kind_has_exact_derivatives_and_closest_points() {
    for (face, bounds) in every_kind() {
        let kind = face.surface.kind();
        assert_eq!(face.bounds(), bounds, "{kind}");
        let index = FaceIndex::new(face.clone()).unwrap();
        let mut numbers = Numbers(17);
        for query in 0..60 {
            let uv = bounds.map(|range| between(range, 0.98 * numbers.next()));
            check_differences(&face.surface, uv);
            assert!(face.contains(uv[0], uv[1]), "{kind}: {uv:?}");
            assert!(!face.contains(uv[0], bounds[1].high + 0.01), "{kind}: {uv:?}");
            // Close enough to the surface that the foot is the only one.
            let h = 0.3 * numbers.next();
            let p = face.surface.point(uv[0], uv[1]) + face.normal(uv[0], uv[1]).unwrap().scale(h);
            let near = index.closest_near(&p, uv.map(|x| x + 1e-3).into()).unwrap();
            assert!((near.distance - h).abs() < 1e-9, "{kind} {query}: {near:?}");
            let foot = index.closest(&p).unwrap();
            let there = face.surface.point(foot.uv.u, foot.uv.v);
            assert!((foot.point - there).norm() < 1e-12, "{kind}");
            assert!((p - there).norm() <= h.abs() + 1e-9, "{kind} {query}: {foot:?}");
        }
    }
}

#[test]
fn every_kind_is_turned_with_its_parameters() {
    let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for (face, bounds) in every_kind() {
        let kind = face.surface.kind();
        let turned = face.clone().turned(&rotation);
        assert_eq!(turned.bounds(), bounds, "{kind}");
        let mut numbers = Numbers(29);
        for _ in 0..40 {
            // Beyond the ends too, where splines are continued.
            let [u, v] = bounds.map(|range| between(range, 1.2 * numbers.next()));
            let (a, b) = (face.surface.jet(u, v), turned.surface.jet(u, v));
            let apart = |a: Vector3<f64>, b: Vector3<f64>| {
                let error = (rotation * a - b).norm();
                assert!(error <= 1e-12 * (1.0 + a.norm()), "{kind} {u} {v}: {error:e}");
            };
            apart(face.point(u, v).coords, turned.point(u, v).coords);
            apart(a.su, b.su);
            apart(a.svv, b.svv);
            if let Some(normal) = face.normal(u, v) {
                apart(normal.into_inner(), turned.normal(u, v).unwrap().into_inner());
            }
        }
    }
}

/// Bounds over small rectangles hold, and are of use there: mostly near what is attained.
fn check_small_cells(index: &FaceIndex, face: &Face, bounds: [Interval; 2]) {
    let mut numbers = Numbers(23);
    let largest = index.curvature_bound(bounds);
    let mut loose = 0;
    for _ in 0..200 {
        let middle = bounds.map(|range| between(range, numbers.next()));
        let half = bounds.map(|range| 0.02 * range.width() * numbers.next().abs());
        let cell = [0, 1].map(|k| Interval::point(middle[k]).widened(half[k]));
        let [low, high] = index.curvature_range(cell).ends();
        let mut attained = 0.0_f64;
        for _ in 0..20 {
            let uv = [0, 1].map(|k| bounds[k].clamp(between(cell[k], numbers.next())));
            let curvature = face.surface.jet2(uv[0], uv[1]).curvature().unwrap();
            let sign = if face.flip { -1.0 } else { 1.0 };
            let pair = [sign * curvature.min, sign * curvature.max];
            assert!(pair.iter().all(|k| (low - 1e-9..=high + 1e-9).contains(k)), "{cell:?}");
            attained = attained.max(pair[0].abs()).max(pair[1].abs());
        }
        loose += u32::from(high.max(-low) > 1.5 * attained + 0.02 * largest);
    }
    // The steep random waves use up what may be spent; there the bounds need only hold.
    let kind = face.surface.kind();
    assert!(loose <= 20 || face.number == 2, "{kind}: {loose} of 200 bounds are loose");
}

/// A net whose parametrisation slows down and speeds up by large factors, twisted at random.
fn uneven(seed: u64) -> Surface {
    let mut numbers = Numbers(seed);
    let pace = [0, 1].map(|_| [0.0, 0.05, 0.35, 1.0].map(|x: f64| x.powf(1.0 + numbers.next())));
    let turn = numbers.next() > 0.0;
    let row = |i: usize| {
        let point = |j: usize| {
            let place = |k: usize, i: usize| {
                let x = pace[k][if turn { 3 - i } else { i }];
                100.0 * if turn { 1.0 - x } else { x }
            };
            Point3::new(place(0, i), place(1, j), 12.0 * numbers.next())
        };
        (0..4).map(point).collect()
    };
    let points = (0..4).map(row).collect();
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    Surface::Nurbs(NurbsSurface::new([3, 3], [knots.clone(), knots], points, None).unwrap())
}

#[test]
fn beyond_the_border_a_surface_goes_on_and_does_not_turn_back() {
    for seed in 0..200 {
        let surface = uneven(seed);
        let mut numbers = Numbers(seed + 1000);
        for _ in 0..20 {
            let y = 0.5 + 0.5 * numbers.next();
            let (by, step) = (0.02 * 10_f64.powf(2.0 * numbers.next().abs()), 1e-6);
            for (x, outwards) in [(0.0, -1.0), (1.0, 1.0)] {
                let at = |x: f64, along_u: bool| {
                    let [u, v] = if along_u { [x, y] } else { [y, x] };
                    let d = surface.jet2(u, v);
                    if along_u { (d.s, d.su, d.suu, d.suv) } else { (d.s, d.sv, d.svv, d.suv) }
                };
                for along_u in [true, false] {
                    let border = at(x, along_u);
                    let near = at(x + outwards * step, along_u);
                    // Continuous to second order: what is left falls with the step.
                    let scale = border.1.norm() + border.2.norm() + border.3.norm();
                    let jump = 200.0 * step * (1.0 + scale + scale * scale);
                    assert!((near.1 - border.1).norm() < jump, "{seed}: slope");
                    assert!((near.2 - border.2).norm() < jump, "{seed}: second derivative");
                    assert!((near.3 - border.3).norm() < jump, "{seed}: mixed derivative");
                    let far = at(x + outwards * by, along_u);
                    let kept = far.1.dot(&border.1) / border.1.norm_squared();
                    assert!(kept > 0.45, "{seed}: {kept} of the slope is left {by} beyond");
                    check_differences(
                        &surface,
                        if along_u { [x + outwards * by, y] } else { [y, x + outwards * by] },
                    );
                }
            }
        }
    }
}

#[test]
fn curvature_bounds_hold_and_are_close() {
    let patch = Face::new(1, bezier_patch(), vec![]).unwrap();
    let waves =
        Face::new(2, Surface::Nurbs(wavy(5, [3, 3], [8, 8], true)), vec![]).unwrap().flipped();
    let sheets = [patch, waves].map(|face| (face.clone(), face.bounds()));
    for (face, bounds) in every_kind().into_iter().chain(sheets) {
        let index = FaceIndex::new(face.clone()).unwrap();
        let [low, high] = index.curvature_range(bounds).ends();
        let mut attained = [0.0_f64; 2];
        for i in 0..=60 {
            for j in 0..=60 {
                let u = between(bounds[0], f64::from(i) / 30.0 - 1.0);
                let v = between(bounds[1], f64::from(j) / 30.0 - 1.0);
                let curvature = face.surface.jet2(u, v).curvature().unwrap();
                let pair = if face.flip {
                    [-curvature.max, -curvature.min]
                } else {
                    [curvature.min, curvature.max]
                };
                attained = [attained[0].min(pair[0]), attained[1].max(pair[1])];
            }
        }
        let size = attained[1].max(-attained[0]);
        let place =
            format!("{} {}: [{low}, {high}] {attained:?}", face.number, face.surface.kind());
        assert!(low <= attained[0] + 1e-9 && high >= attained[1] - 1e-9, "{place}");
        // 10 % as promised, and some for a peak between the samples.
        assert!(low >= attained[0] - 0.13 * size && high <= attained[1] + 0.13 * size, "{place}");
        check_small_cells(&index, &face, bounds);
    }
}

/// Nine-point rational circle.
fn circle([cu, cv]: [f64; 2], radius: f64) -> TrimCurve {
    let h = 0.5_f64.sqrt();
    let square = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
    let points = square.map(|[a, b]| [cu + f64::from(a) * radius, cv + f64::from(b) * radius]);
    let weights = [1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0];
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    TrimCurve::spline(2, knots, &points, Some(&weights)).unwrap()
}

fn closed(curve: TrimCurve) -> TrimLoop {
    TrimLoop::new(vec![curve], [None; 2], 1e-9).unwrap()
}

/// A plane with a disc of radius 20 round (3, -4), without one of radius 8.
fn disc_with_hole() -> Face {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let loops =
        vec![closed(circle([3.0, -4.0], 20.0)), closed(circle([5.0, -2.0], 8.0).reversed())];
    Face::new(1, Surface::Plane(PlaneSurface { frame }), loops).unwrap().flipped()
}

proptest! {
    #[test]
    fn trims_agree_with_circles(u in -25.0..30.0_f64, v in -30.0..20.0_f64, share in 0.99..1.01_f64, turn in 0.0..6.3_f64) {
        let face = disc_with_hole();
        let inside = |u: f64, v: f64| (u - 3.0).hypot(v + 4.0) < 20.0 && (u - 5.0).hypot(v + 2.0) > 8.0;
        prop_assert_eq!(face.contains(u, v), inside(u, v));
        // Close to the rims.
        for (c, r) in [([3.0, -4.0], 20.0), ([5.0, -2.0], 8.0)] {
            let (u, v) = (c[0] + r * share * turn.cos(), c[1] + r * share * turn.sin());
            prop_assume!((share - 1.0).abs() > 1e-12);
            prop_assert_eq!(face.contains(u, v), inside(u, v));
        }
    }

    /// Whatever the bytes, a surface or faults, never a panic.
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = trunnion::import::surface_json::read(&bytes);
    }

    /// The patch with a few bytes changed, taken out or doubled.
    #[test]
    fn a_mutated_file_is_read_or_refused(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..6)) {
        let mut bytes = include_bytes!("../../../../fixtures/bezier-patch/patch.json").to_vec();
        for (at, byte, kind) in edits {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] = b"0123456789-.,[]{}e\""[usize::from(byte) % 19],
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, bytes[at]),
            }
        }
        match trunnion::import::surface_json::read(&bytes) {
            Ok(surface) => {
                let [u, v] = surface.domain();
                let _ = surface.jet(u.high, v.low).normal();
                if let Ok(index) = FaceIndex::new(Face::new(1, surface, vec![]).unwrap()) {
                    let _ = index.closest(&Point3::new(1.0, 2.0, 30.0));
                }
            }
            Err(faults) => prop_assert!(!faults.is_empty()),
        }
    }
}

/// Elementary surface with a box of parameters: a number of the kind, and a start and width by u and v as shares.
fn part_of(kind: usize, start: [f64; 2], width: [f64; 2]) -> (Surface, [[f64; 2]; 2]) {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    let frame =
        SurfaceFrame::new(Point3::new(1.0, 2.0, 3.0), Vector3::new(1.0, 1.0, 0.3), Vector3::x())
            .unwrap();
    let turn = [7.0 * (start[0] - 0.5), 7.0 * (start[0] - 0.5) + TAU * width[0]];
    let range = |low: f64, high: f64| {
        let from = low + (high - low) * start[1];
        [from, from + (high - from) * width[1]]
    };
    match kind {
        0 => {
            (Surface::Cylinder(CylinderSurface::new(frame, 4.0).unwrap()), [turn, range(-2.0, 3.0)])
        }
        1 => (Surface::Cone(ConeSurface::new(frame, 3.0, 0.6).unwrap()), [turn, range(-4.0, 3.0)]),
        2 => (
            Surface::Sphere(SphereSurface::new(frame, 5.0).unwrap()),
            [turn, range(-FRAC_PI_2, FRAC_PI_2)],
        ),
        3 => (Surface::Torus(TorusSurface::new(frame, 5.0, 2.0).unwrap()), [turn, range(-PI, PI)]),
        _ => (Surface::Plane(PlaneSurface { frame }), [range(-4.0, 6.0), range(-3.0, 2.0)]),
    }
}

proptest! {
    /// Parts of all elementary surfaces against a grid of their points, seen from anywhere, across the seam too.
    #[test]
    fn the_distance_from_part_of_a_surface_agrees_with_brute_force(
        kind in 0..5usize,
        p in prop::array::uniform3(-12.0..12.0f64),
        start in prop::array::uniform2(0.0..0.95f64),
        width in prop::array::uniform2(0.02..0.98f64),
    ) {
        const N: u32 = 120;
        let (surface, [u, v]) = part_of(kind, start, width);
        let corners = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]], [u[0], v[0]]];
        let border = TrimCurve::polyline(&corners).unwrap();
        let trim = TrimLoop::new(vec![border], [None, None], 1e-9).unwrap();
        let index = FaceIndex::new(Face::new(1, surface, vec![trim]).unwrap()).unwrap();
        let p = Point3::from(p);
        let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(N);
        let point = |i, j| index.face().point(at(u, i), at(v, j));
        let places = (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j)));
        let brute = places.map(|(i, j)| (point(i, j) - p).norm()).fold(f64::INFINITY, f64::min);
        let found = index.distance_over_box(&p).unwrap();
        // No point is farther from the grid than half a cell's diagonal; none of these surfaces runs faster than 7.
        let cell = 0.5 * 7.0 / f64::from(N) * (u[1] - u[0]).hypot(v[1] - v[0]);
        prop_assert!(found <= brute + 1e-9 && brute <= found + cell, "{found} {brute}");
        prop_assert!(index.clear_of(&p, found * (1.0 - 1e-12)) && !index.clear_of(&p, brute + 1e-6));
    }
}

/// The lower half of a tube as a spline surface keeps no tool out that stands in it, and one that goes through its
/// wall.
/// One patch all round ends where it begins: it has to be halved round the turn as well.
#[test]
fn a_closed_patch_is_known_to_keep_off_a_solid() {
    let around =
        [[10.0, 0.0], [10.0, 20.0], [-20.0, 10.0], [-20.0, -10.0], [10.0, -20.0], [10.0, 0.0]];
    let ring = |x: f64| around.map(|[y, z]| Point3::new(x, y, z)).to_vec();
    let knots = [vec![0.0, 0.0, 1.0, 1.0], [vec![0.0; 6], vec![1.0; 6]].concat()];
    let tube = NurbsSurface::new([1, 5], knots, vec![ring(0.0), ring(2.0)], None).unwrap();
    let index = FaceIndex::new(Face::new(1, Surface::Nurbs(tube), Vec::new()).unwrap()).unwrap();
    let centre = Point3::new(1.0, 0.0, 0.0);
    let distance = index.closest(&centre).unwrap().distance.abs();
    let ball = |radius: f64| {
        move |p: &Point3<f64>| ((p - centre).norm() - radius, (p - centre).normalize())
    };
    assert_eq!(index.meets(&ball(distance - 0.01), 0.0), SolidProximity::Clear);
    assert!(matches!(index.meets(&ball(distance + 0.01), 0.0), SolidProximity::Nearer(_)));
}

#[test]
fn a_trimmed_tube_is_open_at_the_top() {
    let h = 0.5_f64.sqrt();
    let square = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
    let ring = |x: f64| square.map(|[y, z]| Point3::new(x, 6.0 * f64::from(y), 6.0 * f64::from(z)));
    let points = [0.0, 40.0].map(|x| ring(x).to_vec()).to_vec();
    let weights = vec![vec![1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0]; 2];
    let around = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let knots = [vec![0.0, 0.0, 40.0, 40.0], around];
    let tube = Surface::Nurbs(NurbsSurface::new([1, 2], knots, points, Some(weights)).unwrap());
    // The half with z < 0 is v from 2 to 4; exporters write ends that lie a rounding beyond.
    let corners = [[-1e-12, 2.0], [40.0, 2.0], [40.0, 4.0], [-1e-12, 4.0], [-1e-12, 2.0]];
    let trim = TrimLoop::new(vec![TrimCurve::polyline(&corners).unwrap()], [None, None], 1e-9);
    let index = FaceIndex::new(Face::new(1, tube, vec![trim.unwrap()]).unwrap()).unwrap();
    let ball = |centre: Point3<f64>, radius: f64| {
        move |p: &Point3<f64>| ((p - centre).norm() - radius, (p - centre).normalize())
    };
    // High above the axis only the upper half, which is not there, would be near.
    let above = Point3::new(20.0, 0.0, 8.0);
    assert_eq!(index.nearer(&above, 9.0).unwrap(), None);
    assert!(index.clear_of(&above, 9.0));
    assert_eq!(index.meets(&ball(above, 9.0), 0.0), SolidProximity::Clear);
    // In the middle of the tube a ball of nearly its radius is clear, one that is larger is not.
    let inside = Point3::new(20.0, 0.0, 0.0);
    assert_eq!(index.meets(&ball(inside, 5.99), 0.0), SolidProximity::Clear);
    assert!(matches!(index.meets(&ball(inside, 6.01), 0.0), SolidProximity::Nearer(_)));
    let found = index.nearer(&Point3::new(20.0, 0.0, -4.0), 3.0).unwrap().unwrap();
    assert!((found - 2.0).abs() < 1e-9, "{found}");
    // The whole tube is still found by its closest point.
    let foot = index.closest(&above).unwrap();
    assert!((foot.distance.abs() - 2.0).abs() < 1e-9 && foot.point.z > 5.9, "{foot:?}");
}

#[test]
fn the_patch_file_is_the_papers_patch() {
    let bytes = include_bytes!("../../../../fixtures/bezier-patch/patch.json");
    assert_eq!(trunnion::import::surface_json::read(bytes).unwrap(), bezier_patch());
}

#[test]
fn a_grid_covers_the_face_and_nothing_else() {
    let face = disc_with_hole();
    let spacing = 0.25;
    let grid = face.grid(spacing).unwrap();
    let area = std::f64::consts::PI * (400.0 - 64.0);
    let covered = grid.len() as f64 * spacing * spacing;
    assert!((covered / area - 1.0).abs() < 0.01, "{covered} {area}");
    assert!(grid.iter().all(|sample| sample.normal.z < 0.0), "flipped");
    assert!(face.grid(0.0).is_err() && face.grid(f64::NAN).is_err() && face.grid(1e-6).is_err());
    // Free-form: neighbours on the patch are about the spacing apart, none farther than it.
    let patch = Face::new(1, bezier_patch(), vec![]).unwrap();
    let grid = patch.grid(2.0).unwrap();
    let rows = grid.chunk_by(|a, b| a.uv.v.total_cmp(&b.uv.v).is_eq());
    for row in rows {
        for pair in row.windows(2) {
            let gap = (pair[1].point - pair[0].point).norm();
            assert!(gap < 2.02 && gap > 1.8, "{gap}");
        }
    }
}

#[test]
fn a_tessellation_has_the_area_and_the_side_of_the_face() {
    let area_and_sense = |face: &Face, chord: f64| {
        let out = face.tessellate(chord).unwrap();
        let [mut area, mut sense] = [0.0; 2];
        for [a, b, c] in &out.mesh.triangles {
            let at = |index: &u32| out.mesh.vertices[*index as usize];
            let normal = (at(b) - at(a)).cross(&(at(c) - at(a))) * 0.5;
            area += normal.norm();
            sense += normal.dot(&out.normals[*a as usize]);
        }
        for (uv, vertex) in out.uv.iter().zip(&out.mesh.vertices) {
            assert!((face.surface.point(uv.u, uv.v) - vertex).norm() < 1e-12);
        }
        (area, sense)
    };
    // The disc: its rims are chords, at most a quarter of the tolerance off.
    let (area, sense) = area_and_sense(&disc_with_hole(), 0.1);
    let exact = std::f64::consts::PI * (400.0 - 64.0);
    assert!(
        (area / exact - 1.0).abs() < 3e-3 && (sense / area - 1.0).abs() < 1e-9,
        "{area} {exact}"
    );
    // A whole sphere: 4 pi r^2, a little less.
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let sphere = Face::new(1, Surface::Sphere(SphereSurface::new(frame, 10.0).unwrap()), vec![]);
    let (area, sense) = area_and_sense(&sphere.unwrap(), 0.01);
    let exact = 400.0 * std::f64::consts::PI;
    assert!(area < exact && area > 0.995 * exact && sense > 0.99 * area, "{area} {exact}");
}

/// A trim that is a polygon is kept to the corner, whatever the cells; slots thinner than a cell too.
#[test]
fn a_tessellation_keeps_the_corners_of_trims() {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let polygon = |points: &[[f64; 2]]| {
        let mut closed = points.to_vec();
        closed.push(points[0]);
        TrimLoop::new(vec![TrimCurve::polyline(&closed).unwrap()], [None, None], 1e-9).unwrap()
    };
    // A star with a sharp notch, and a slot of a hundredth across five cells.
    let outer = polygon(&[[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [21.0, 4.3], [0.3, 29.7]]);
    let slot = polygon(&[[5.0, 3.1], [30.0, 3.1], [30.0, 3.11], [5.0, 3.11]]);
    let face = Face::new(1, Surface::Plane(PlaneSurface { frame }), vec![outer, slot]).unwrap();
    let made = face.tessellate(0.1).unwrap();
    let corner = |index: u32| made.mesh.vertices[index as usize];
    let areas = made
        .mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| 0.5 * (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).z);
    let (area, least) = areas
        .fold((0.0, f64::INFINITY), |(sum, least): (f64, f64), area| (sum + area, least.min(area)));
    let shoelace = 0.5 * (40.0 * 30.0 + (40.0 * 4.3 - 21.0 * 30.0) + (21.0 * 29.7 - 0.3 * 4.3));
    assert!((area - (shoelace - 0.25)).abs() < 1e-9 && least > 0.0, "{area} {least}");
    assert_eq!(made.deviation_bound(&face.surface), Some(0.0));
    for [x, y] in [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [21.0, 4.3], [0.3, 29.7], [5.0, 3.11]] {
        assert!(made.mesh.vertices.iter().any(|p| (p - Point3::new(x, y, 0.0)).norm() < 1e-12));
    }
    // Neighbours share their edges: what is left is the outline, each loop once round.
    let mut open = std::collections::BTreeSet::new();
    for &[a, b, c] in &made.mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if !open.remove(&(to, from)) {
                assert!(open.insert((from, to)), "an edge stands twice");
            }
        }
    }
    let length: f64 = open.iter().map(|&(a, b)| (corner(b) - corner(a)).norm()).sum();
    let sides: [[f64; 2]; 6] =
        [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [21.0, 4.3], [0.3, 29.7], [0.0, 0.0]];
    let outline: f64 =
        sides.windows(2).map(|of| (of[1][0] - of[0][0]).hypot(of[1][1] - of[0][1])).sum();
    assert!((length - (outline + 50.02)).abs() < 1e-9, "{length} {outline}");
}

#[test]
fn loops_round_a_period() {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let turn = std::f64::consts::TAU;
    let round = |v: f64, ahead: bool, periods| {
        let (a, b) = if ahead { (0.3, 0.3 + turn) } else { (0.3 + turn, 0.3) };
        let line = TrimCurve::polyline(&[[a, v], [b, v]]).unwrap();
        TrimLoop::new(vec![line], periods, 1e-9).unwrap()
    };
    // A band of a cylinder between two full circles, whatever turn a point is given on.
    let cylinder = Surface::Cylinder(CylinderSurface::new(frame, 5.0).unwrap());
    let periods = cylinder.periods();
    let loops = vec![round(1.0, true, periods), round(4.0, false, periods)];
    assert_eq!(loops[0].turns(), [1, 0]);
    let band = Face::new(1, cylinder, loops).unwrap();
    for u in [0.0, 0.3, 3.0, 6.2, -20.0, 40.0] {
        assert!(band.contains(u, 2.0) && !band.contains(u, 0.9) && !band.contains(u, 4.1), "{u}");
    }
    assert_eq!(band.bounds(), [Interval::new(0.0, turn), Interval::new(1.0, 4.0)]);
    // Caps of a sphere above and below a circle of latitude.
    for (ahead, inside, outside) in [(true, 1.0, -1.0), (false, -1.0, 1.0)] {
        let sphere = Surface::Sphere(SphereSurface::new(frame, 5.0).unwrap());
        let loops = vec![round(0.5, ahead, sphere.periods())];
        let cap = Face::new(1, sphere, loops).unwrap();
        assert!(cap.contains(2.0, inside) && !cap.contains(2.0, outside));
    }
    // Both bands of a torus between two circles of latitude: the loops' sense tells them apart.
    for (ahead, inside, outside) in [(true, 2.0, 5.0), (false, 5.0, 2.0)] {
        let torus = Surface::Torus(TorusSurface::new(frame, 10.0, 2.0).unwrap());
        let periods = torus.periods();
        let loops = vec![round(1.0, ahead, periods), round(3.0, !ahead, periods)];
        let face = Face::new(1, torus, loops).unwrap();
        for turns in [-1.0, 0.0, 1.0] {
            let v = turns * turn;
            assert!(face.contains(0.1, inside + v) && !face.contains(0.1, outside + v), "{ahead}");
        }
    }
    // A patch of a cylinder across the seam.
    let cylinder = Surface::Cylinder(CylinderSurface::new(frame, 5.0).unwrap());
    let across = [[6.0, 0.0], [6.8, 0.0], [6.8, 3.0], [6.0, 3.0], [6.0, 0.0]];
    let trim = closed(TrimCurve::polyline(&across).unwrap());
    let patch = Face::new(1, cylinder, vec![trim]).unwrap();
    assert!(patch.contains(6.2, 1.0) && patch.contains(0.2, 1.0) && patch.contains(-0.1, 1.0));
    assert!(!patch.contains(1.0, 1.0) && !patch.contains(5.9, 1.0) && !patch.contains(0.2, 3.1));
}
