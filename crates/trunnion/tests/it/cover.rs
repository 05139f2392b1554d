//! Passes must finish the whole face: an independent check of what the cutter leaves.
//!
//! The oracle knows nothing of strips or closest points: it takes the curves that the tool path
//! follows, and for points of the face the least signed distance to the cutter, in closed form.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::swept_tool;

use nalgebra::{Point3, Vector3};
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};
use swept_tool::{SPACING, distance, poses};
use trunnion::cover::{
    CoverError, CoverOptions, CoverRequest, Covering, CutPattern, FeedDirection, FinishTolerance,
    GivenUp, LeadKind, LinkOptions, LinkRequest, PassCost, cover, legs, lever,
};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::positioning::{ContactSide, ToleranceBand, ToolInclination};
use trunnion::surface::{
    CylinderSurface, Face, FaceIndex, NurbsSurface, SphereSurface, Surface, SurfaceFrame,
    TrimCurve, TrimLoop,
};
use trunnion::toolpath::{ToolPathOptions, through};
use trunnion::types::{Interval, Motion, Pass, Progress, Silent, Stage, Station, ToolPose, Uv};

const BAND: ToleranceBand = ToleranceBand { lower: 0.0, upper: 0.02 };
const SHARE: f64 = 0.002;

/// What that may miss: a point is at most half of it from the nearest pose, where its distance has a
/// minimum with a second derivative of at most one over the corner radius of 3 mm.
const SAMPLING: f64 = 0.5 * (0.5 * SPACING) * (0.5 * SPACING) / 3.0;

/// A bicubic patch over 36 x 30 mm, hollow across and waved along: `lift` scales the heights.
fn surface(lift: f64) -> Surface {
    let heights = [
        [0.0, -1.5, -1.0, 0.5],
        [-1.0, -2.5, -2.0, -0.5],
        [-1.2, -2.0, -2.2, -0.8],
        [0.4, -1.0, -1.4, 0.2],
    ];
    let points = (0..4)
        .map(|i| {
            (0..4)
                .map(|j| Point3::new(12.0 * i as f64, 10.0 * j as f64, lift * heights[i][j]))
                .collect()
        })
        .collect();
    nurbs(points)
}

fn nurbs(points: Vec<Vec<Point3<f64>>>) -> Surface {
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    Surface::Nurbs(NurbsSurface::new([3, 3], [knots(), knots()], points, None).unwrap())
}

fn face(surface: Surface, loops: &[Vec<[f64; 2]>], flip: bool) -> FaceIndex {
    let loops = loops
        .iter()
        .map(|points| {
            let closed: Vec<_> = points.iter().chain(points.first()).copied().collect();
            let curve = TrimCurve::polyline(&closed).unwrap();
            TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap()
        })
        .collect();
    FaceIndex::new(Face { flip, ..Face::new(1, surface, loops).unwrap() }).unwrap()
}

fn cutter() -> Cutter {
    long(60.0)
}

fn long(length: f64) -> Cutter {
    Cutter::new(CutterSpec { length, ..CutterSpec::bull(4.0, 3.0) }).unwrap()
}

fn options() -> CoverOptions {
    CoverOptions {
        feed_direction: FeedDirection::V,
        band: BAND,
        link: 25.0,
        path_share: SHARE,
        spacing: Interval::new(0.05, 4.0),
        max_axis_turn: 0.1,
        offset_range: Interval::new(-0.5, 0.5),
        lean: ToolInclination { angle: 0.05, towards: None },
        ..CoverOptions::finishing(
            &cutter(),
            FinishTolerance { excess: BAND.upper, gouge: -BAND.lower },
        )
    }
}

/// Largest and least distance left over an `n` x `n` grid inside the trims, and where.
fn left_over(
    face: &FaceIndex,
    poses: &[ToolPose],
    cutter: &Cutter,
    n: u32,
) -> [(f64, f64, f64); 2] {
    let [bu, bv] = face.face().bounds();
    let mut worst = [(f64::NEG_INFINITY, 0.0, 0.0), (f64::INFINITY, 0.0, 0.0)];
    for i in 0..=n {
        for j in 0..=n {
            let at = |range: Interval, k: u32| range.at(f64::from(k) / f64::from(n));
            let (u, v) = (at(bu, i), at(bv, j));
            if !face.face().contains(u, v) {
                continue;
            }
            let p = face.face().point(u, v);
            let left = poses.iter().map(|q| distance(&p, q, cutter)).fold(f64::INFINITY, f64::min);
            if left > worst[0].0 {
                worst[0] = (left, u, v);
            }
            if left < worst[1].0 {
                worst[1] = (left, u, v);
            }
        }
    }
    worst
}

fn finished(face: &FaceIndex, options: &CoverOptions) -> Covering {
    finished_by(&cutter(), face, options)
}

fn finished_by(cutter: &Cutter, face: &FaceIndex, options: &CoverOptions) -> Covering {
    let covering =
        cover(&CoverRequest::new(std::slice::from_ref(face), cutter, options), &Silent).unwrap();
    let [most, least] = left_over(face, &poses(&covering.passes, cutter), cutter, 60);
    let report = &covering.report;
    let most_allowed = options.band.upper + SHARE + SAMPLING;
    let least_allowed = options.band.lower - SHARE;
    assert!(most.0 <= most_allowed, "excess {most:?} of {most_allowed}; {report:?}");
    assert!(report.rest.is_empty(), "{report:?}");
    assert!(least.0 >= least_allowed, "gouge {least:?} of {least_allowed}; {report:?}");
    covering
}

#[test]
fn strips_meet_over_the_whole_face() {
    let face = face(surface(1.0), &[], false);
    let to_and_fro = finished(&face, &options());
    assert!(to_and_fro.report.fallbacks.is_empty(), "{:?}", to_and_fro.report);
    let one_way = finished(&face, &CoverOptions { pattern: CutPattern::OneWay, ..options() });
    let feeds = |covering: &Covering| -> Vec<bool> {
        covering.passes.iter().map(|pass| pass.track[0].v < pass.track[1].v).collect()
    };
    assert!(feeds(&one_way).iter().all(|forward| *forward));
    // Parts of one lane run the same way, the lane after it the other way.
    for pair in to_and_fro.passes.windows(2) {
        let lane = |pass: &Pass| pass.track[0].u;
        let forward = |pass: &Pass| pass.track[0].v < pass.track[1].v;
        let same_lane = lane(&pair[0]).total_cmp(&lane(&pair[1])).is_eq();
        assert_eq!(forward(&pair[0]) == forward(&pair[1]), same_lane);
    }
}

/// A bicubic patch of about 36 x 30 mm, times `size`, from a seed: points off their grid, waves of a few
/// millimetres.
fn any_patch(seed: u64, size: f64) -> FaceIndex {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let lift = 2.5 + random();
    let mut point = |i: u32, j: u32| {
        let [x, y] = [12.0 * f64::from(i), 10.0 * f64::from(j)];
        Point3::new(x + 2.0 * random(), y + 2.0 * random(), lift * random()) * size
    };
    face(nurbs((0..4).map(|i| (0..4).map(|j| point(i, j)).collect()).collect()), &[], false)
}

#[test]
fn strips_meet_on_passes_that_bend() {
    for seed in [1, 2, 3] {
        finished(
            &any_patch(seed, 1.0),
            &CoverOptions { feed_direction: FeedDirection::Curvature, ..options() },
        );
    }
    finished(
        &face(surface(-1.0), &[], true),
        &CoverOptions {
            feed_direction: FeedDirection::Curvature,
            pattern: CutPattern::OneWay,
            ..options()
        },
    );
}

/// What is placed is chosen by its true cost: no search on paper can make it dearer than both parameters; and by
/// nothing that depends on threads.
#[test]
fn adaptive_passes_cost_no_more_than_straight_ones() {
    let face = any_patch(4, 0.6);
    let options = |feed_direction: FeedDirection| CoverOptions { feed_direction, ..options() };
    let cost = |covering: &Covering| {
        covering.report.length + options(FeedDirection::V).link * covering.passes.len() as f64
    };
    // What is refused one way may be done another.
    let straight = |along: FeedDirection| {
        let covering = cover(
            &CoverRequest::new(std::slice::from_ref(&face), &cutter(), &options(along)),
            &Silent,
        );
        covering.map_or(f64::INFINITY, |covering| cost(&covering))
    };
    let [u, v] = [FeedDirection::U, FeedDirection::V].map(straight);
    assert!(u.min(v).is_finite(), "{u} {v}");
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| finished(&face, &options(FeedDirection::Adaptive)))
    };
    let adaptive = run(1);
    assert!(cost(&adaptive) <= u.min(v), "{} mm, {u} mm along u, {v} mm along v", cost(&adaptive));
    assert_eq!(adaptive, run(3));
}

/// Bent passes leave a trimmed face where they please.
#[test]
fn bent_passes_finish_a_trimmed_face() {
    let slanted = [[0.1, 0.05], [0.9, 0.3], [0.7, 0.95], [0.3, 0.8]];
    let face = face(surface(1.0), &[slanted.to_vec()], false);
    finished(&face, &CoverOptions { feed_direction: FeedDirection::Curvature, ..options() });
}

/// Where turning round costs more than anything, there are no more passes than where it costs nothing.
#[test]
fn the_cost_of_links_decides_how_many_passes_there_are() {
    // A power of two turns lengths into times and back without rounding, so that equal costs are equal bits.
    const FEED: f64 = 8.0;
    struct Slow(f64);
    impl PassCost for Slow {
        fn feed(&self) -> f64 {
            FEED
        }
        fn pass(&self, stations: &[Station]) -> f64 {
            let length = stations.windows(2).map(|p| (p[1].contact - p[0].contact).norm());
            length.sum::<f64>() / FEED
        }
        fn link(&self, _: &Station, _: &Station) -> f64 {
            self.0
        }
    }
    let face = [face(surface(1.0), &[], false)];
    let passes = |link: f64| {
        let options = CoverOptions { link, ..options() };
        let cost = Slow(link / FEED);
        let cutter = cutter();
        let request =
            CoverRequest { cost: Some(&cost), ..CoverRequest::new(&face, &cutter, &options) };
        cover(&request, &Silent).unwrap()
    };
    assert!(passes(1000.0).passes.len() <= passes(0.0).passes.len());
    // A cost by length at the feed changes nothing.
    let plain = CoverOptions { link: 50.0, ..options() };
    assert_eq!(passes(50.0), cover(&CoverRequest::new(&face, &cutter(), &plain), &Silent).unwrap());
}

/// Wide strips are given up at the same place every time, and the face is finished all the same.
#[test]
fn a_face_is_finished_when_its_work_is_used_up() {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let shaft = Surface::Cylinder(CylinderSurface::new(frame, 12.0).unwrap());
    let half = [[0.0, 0.0], [3.0, 0.0], [3.0, 60.0], [0.0, 60.0]];
    let face = face(shaft, &[half.to_vec()], false);
    let with = |effort: f64| {
        let spacing = Interval::new(0.05, 1.0);
        finished(&face, &CoverOptions { effort, spacing, ..options() })
    };
    let ends = |passes: &[Pass]| {
        let widest = |pass: &Pass| pass.widths.iter().copied().fold(0.0, f64::max);
        [&passes[0], &passes[passes.len() - 1]].map(widest)
    };
    let mut shares = Vec::new();
    for effort in [0.05, 0.1, 0.2, 0.3, 0.5] {
        let Covering { passes, report, .. } = with(effort);
        let Some(GivenUp { face: number, share, .. }) = report.given_up else { break };
        assert_eq!(number, 1);
        shares.push(share);
        let [first, last] = ends(&passes);
        // Given up late, the first passes are wide strips.
        let is_early = share <= 0.0;
        assert!(is_early || (0.5..1.0).contains(&share), "{report:?}");
        assert!(is_early || first > last, "{share}: {first} mm, {last} mm");
    }
    assert!(shares.contains(&0.0) && shares.iter().any(|share| *share >= 0.5), "{shares:?}");
}

#[test]
fn strips_meet_along_u_and_on_the_other_side() {
    finished(
        &face(surface(1.0), &[], false),
        &CoverOptions { feed_direction: FeedDirection::U, ..options() },
    );
    finished(&face(surface(-1.0), &[], true), &options());
}

/// Left to itself the side may not change from place to place: a pass of its own for every change.
#[test]
fn either_side_is_as_good_as_the_better_one() {
    let face = face(surface(0.5), &[], false);
    let passes = |side: ContactSide| {
        cover(
            &CoverRequest::new(
                std::slice::from_ref(&face),
                &cutter(),
                &CoverOptions { side, ..options() },
            ),
            &Silent,
        )
        .unwrap()
        .passes
    };
    let [either, ahead, behind] =
        [ContactSide::Either, ContactSide::Ahead, ContactSide::Behind].map(passes);
    assert!(either == ahead || either == behind);
    assert!(either.len() <= ahead.len().max(behind.len()));
}

#[test]
fn passes_run_out_over_the_border() {
    let face = face(surface(1.0), &[], false);
    let cutter = cutter();
    let covering = finished(&face, &options());
    let mut whole = 0;
    for pass in &covering.passes {
        let [first, last] = [pass.track[0], pass.track[pass.track.len() - 1]];
        let outside = |v: f64| !(0.0..=1.0).contains(&v);
        assert!(outside(first.v) || outside(last.v), "an island from {first:?} to {last:?}");
        whole += usize::from(outside(first.v) && outside(last.v));
        for Uv { u, v } in [first, last] {
            // No farther than the tool needs to leave the face: half of that by its radius.
            let border = face.face().point(u, v.clamp(0.0, 1.0));
            let beyond = (face.face().point(u, v) - border).norm();
            assert!(beyond <= cutter.radius(), "{beyond} mm beyond the border");
        }
    }
    assert!(2 * whole > covering.passes.len(), "{whole} of {}", covering.passes.len());
}

#[test]
fn trims_shorten_and_split_passes() {
    // A plate with a large hole: passes beside the hole lie on one side of it or the other.
    let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
    let wide = nurbs(
        (0..4)
            .map(|i| {
                (0..4)
                    .map(|j| {
                        let [x, y] = [25.0 * f64::from(i), 25.0 * f64::from(j)];
                        Point3::new(x, y, 0.002 * (x - 37.0).powi(2) + 0.001 * y * y)
                    })
                    .collect()
            })
            .collect(),
    );
    let face = face(wide, &[square(0.02, 0.98), square(0.22, 0.78)], false);
    let covering = finished(&face, &options());
    let wholly = |inside: &dyn Fn(f64) -> bool| {
        covering.passes.iter().filter(|pass| pass.track.iter().all(|uv| inside(uv.v))).count()
    };
    let [below, above] = [wholly(&|v| v < 0.36), wholly(&|v| v > 0.64)];
    assert!(below > 0 && above > 0, "{below} passes below the hole, {above} above");
    let in_hole = |Uv { u, v }: &Uv| (0.36..0.64).contains(u) && (0.36..0.64).contains(v);
    assert!(!covering.passes.iter().flat_map(|pass| &pass.track).any(in_hole));
}

#[test]
fn a_collapsed_edge_is_covered_up_to_its_corner() {
    // Three-sided: the edge v = 0 is one point, near which the height is 1.8 v^2 mm.
    let heights = [0.0, 0.0, 0.6, 1.8];
    let fan = nurbs(
        (0..4)
            .map(|i| {
                (0..4)
                    .map(|j| {
                        let angle = 0.25 * f64::from(i) - 0.375;
                        let radius = 10.0 * j as f64;
                        Point3::new(radius * angle.sin(), radius * angle.cos(), heights[j])
                    })
                    .collect()
            })
            .collect(),
    );
    let fan = face(fan, &[], false);
    let covering = finished(&fan, &options());
    assert!(covering.report.rest.is_empty(), "{:?}", covering.report);
    // The other way the first pass with a length finishes the corner.
    let along_u = CoverOptions { feed_direction: FeedDirection::U, ..options() };
    let covering = finished(&fan, &along_u);
    assert!(covering.report.rest.is_empty(), "{:?}", covering.report);
}

#[test]
fn an_octant_of_a_sphere_is_covered_up_to_its_pole() {
    // It turns by 11.5 deg/mm, twice what the tool may turn by of its own: it has to follow.
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let sphere = Surface::Sphere(SphereSurface::new(frame, 5.0).unwrap());
    let quarter = FRAC_PI_2;
    let corners = [[0.0, 0.0], [quarter, 0.0], [quarter, quarter], [0.0, quarter]];
    let octant = face(sphere, &[corners.to_vec()], false);
    finished(&octant, &options());
}

/// A lens fits closely into a bowl: its corner comes within a tenth of a millimetre of the face all round.
#[test]
fn a_lens_finishes_a_bowl_that_it_nearly_fits() {
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x()).unwrap();
    let sphere = Surface::Sphere(SphereSurface::new(frame, 45.0).unwrap());
    let corners = [[0.0, -1.4], [0.6, -1.4], [0.6, -0.9], [0.0, -0.9]];
    let bowl = face(sphere, &[corners.to_vec()], true);
    let spec = CutterSpec { length: 100.0, ..CutterSpec::lens(20.0, 1.5, 12.0) };
    let lean = ToolInclination { angle: 10_f64.to_radians(), towards: None };
    let options =
        CoverOptions { method: trunnion::cover::PlacementMethod::Inclined, lean, ..options() };
    let covering = finished_by(&Cutter::new(spec).unwrap(), &bowl, &options);
    assert!(covering.report.rest.is_empty(), "{:?}", covering.report);
}

/// To and fro a ball keeps its axis, so that no rotary turns round between passes; a stated lead follows the feed, and
/// passes one way have nothing to keep.
#[test]
fn a_ball_leans_the_same_way_on_the_return() {
    let spec = CutterSpec { length: 60.0, ..CutterSpec::ball(8.0) };
    let angle = 10_f64.to_radians();
    // Largest turn of the axis from the end of a pass to the beginning of the next, beside it.
    let turn = |towards: Option<f64>, pattern: CutPattern| {
        let lean = ToolInclination { angle, towards };
        let method = trunnion::cover::PlacementMethod::Inclined;
        let options = CoverOptions { method, lean, pattern, ..options() };
        let covering = finished_by(
            &Cutter::new(spec.clone()).unwrap(),
            &face(surface(1.0), &[], false),
            &options,
        );
        let turn = |pair: &[Pass]| {
            let [from, to] = [pair[0].stations.last(), pair[1].stations.first()];
            from.unwrap().pose.axis.angle(&to.unwrap().pose.axis)
        };
        covering.passes.windows(2).map(turn).fold(0.0, f64::max)
    };
    assert!(turn(None, CutPattern::ZigZag) < 0.5 * angle);
    assert!(turn(Some(0.0), CutPattern::ZigZag) > 1.5 * angle);
}

#[test]
fn a_ball_needs_no_more_stations_than_the_face_bends() {
    let spec = CutterSpec { length: 60.0, ..CutterSpec::ball(8.0) };
    let options = CoverOptions { spacing: Interval::new(0.02, 1.0), ..options() };
    let covering =
        finished_by(&Cutter::new(spec).unwrap(), &face(surface(1.0), &[], false), &options);
    let report = &covering.report;
    let stations = report.stations as f64;
    // At the largest spacing there is one per mm, and one more at the end of each pass.
    let sparse = report.length + covering.passes.len() as f64;
    assert!(stations < 1.5 * sparse, "{stations} stations, {sparse} at the largest spacing");
}

#[test]
fn where_the_cutter_does_not_fit_the_face_tells_what_would() {
    // A tube of 2 mm seen from inside, for a cutter with a corner of 3 mm.
    let frame = SurfaceFrame::new(Point3::origin(), Vector3::x(), Vector3::z()).unwrap();
    let tube = Surface::Cylinder(CylinderSurface::new(frame, 2.0).unwrap());
    let below = [[2.5, 0.0], [3.7, 0.0], [3.7, 20.0], [2.5, 20.0]];
    let error = cover(
        &CoverRequest::new(&[face(tube, &[below.to_vec()], true)], &cutter(), &options()),
        &Silent,
    );
    let Err(CoverError::NoPose { at, .. }) = &error else { panic!("{error:?}") };
    assert!(
        (at.concave_radius - 2.0).abs() < 1e-9 && at.least_concave_radius <= at.concave_radius,
        "{at:?}"
    );
    assert!((at.point.y.hypot(at.point.z) - 2.0).abs() < 1e-9, "{at:?}");
    let text = error.unwrap_err().to_string();
    assert!(text.contains("radius of 2.000 mm, the largest ball that fits there"), "{text}");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    // Far enough apart that the tool does not have to keep off the one while it cuts the other.
    let frame =
        SurfaceFrame::new(Point3::new(100.0, 0.0, 0.0), Vector3::z(), Vector3::x()).unwrap();
    let sphere = Surface::Sphere(SphereSurface::new(frame, 20.0).unwrap());
    let cap = [[0.2, 0.6], [0.8, 0.6], [0.8, 1.1], [0.2, 1.1]];
    let faces = [face(surface(1.0), &[], false), face(sphere, &[cap.to_vec()], false)];
    let run = |threads: usize, along: FeedDirection| {
        let options = CoverOptions { feed_direction: along, ..options() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cover(&CoverRequest::new(&faces, &cutter(), &options), &Silent).unwrap())
    };
    for along in [FeedDirection::V, FeedDirection::Curvature] {
        assert_eq!(run(1, along), run(3, along));
    }
}

#[test]
fn a_stop_is_a_typed_error() {
    struct Stop;
    impl Progress for Stop {
        fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()> {
            assert_eq!(stage, Stage::Cover);
            assert!(done <= total);
            if 5 * done > total { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }
    let face = [face(surface(1.0), &[], false)];
    let stopped = cover(&CoverRequest::new(&face, &cutter(), &options()), &Stop);
    assert!(matches!(stopped, Err(CoverError::Cancelled(_))), "{stopped:?}");
}

#[test]
fn progress_does_not_fall_while_plans_are_compared() {
    #[derive(Default)]
    struct Rising(Mutex<Vec<u64>>);
    impl Progress for Rising {
        fn report(&self, _: Stage, done: u64, _: u64) -> ControlFlow<()> {
            self.0.lock().unwrap().push(done);
            ControlFlow::Continue(())
        }
    }
    let face = [face(surface(1.0), &[], false)];
    let options = CoverOptions {
        side: ContactSide::Either,
        feed_direction: FeedDirection::Adaptive,
        ..options()
    };
    let rising = Rising::default();
    cover(&CoverRequest::new(&face, &cutter(), &options), &rising).unwrap();
    let done = rising.0.into_inner().unwrap();
    assert!(done.windows(2).all(|pair| pair[0] <= pair[1]), "{done:?}");
    assert!(done.len() > 10, "{done:?}");
}

#[test]
fn passes_are_shown_while_they_are_placed() {
    #[derive(Default)]
    struct Shown(Mutex<Vec<(usize, Vec<Arc<Pass>>)>>);
    impl Progress for Shown {
        fn report(&self, _: Stage, _: u64, _: u64) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }

        fn report_passes(&self, face: usize, passes: &[Arc<Pass>]) {
            self.0.lock().unwrap().push((face, passes.to_vec()));
        }
    }
    let face = [face(surface(1.0), &[], false)];
    let shown = Shown::default();
    let covered = cover(&CoverRequest::new(&face, &cutter(), &options()), &shown).unwrap();
    let shown = shown.0.into_inner().unwrap();
    let number = face[0].face().number;
    assert!(shown.iter().all(|(of, _)| *of == number));
    // The last word is the result.
    let (_, last) = shown.last().unwrap();
    assert!(last.iter().map(AsRef::as_ref).eq(&covered.passes));
    // Passes come a few at a time, and those that stay are not made anew.
    let counts: Vec<usize> = shown.iter().map(|(_, passes)| passes.len()).collect();
    let stays = |[before, after]: [&Vec<Arc<Pass>>; 2]| {
        before.iter().zip(after).all(|(a, b)| Arc::ptr_eq(a, b))
    };
    assert!(shown.windows(2).all(|pair| stays([&pair[0].1, &pair[1].1])), "{counts:?}");
    assert!(
        counts.windows(2).all(|pair| pair[1] >= pair[0] && pair[1] - pair[0] <= 3),
        "{counts:?}"
    );
    assert!(counts[0] < last.len(), "{counts:?}");
}

#[test]
fn bad_options_are_named() {
    let face = [face(surface(1.0), &[], false)];
    let run = |options| cover(&CoverRequest::new(&face, &cutter(), &options), &Silent);
    for options in [
        CoverOptions { spacing: Interval::new(0.0, 1.0), ..options() },
        CoverOptions { spacing: Interval::new(2.0, 1.0), ..options() },
        CoverOptions { path_share: f64::NAN, ..options() },
        CoverOptions { max_axis_turn: -1.0, ..options() },
        CoverOptions { lean: ToolInclination { angle: f64::INFINITY, towards: None }, ..options() },
        CoverOptions { effort: 0.0, ..options() },
    ] {
        assert!(matches!(run(options), Err(CoverError::BadOption { .. })), "{options:?}");
    }
}

#[test]
fn legs_join_and_turn_only_above_the_plane() {
    let face = [face(surface(1.0), &[], false)];
    let cutter = cutter();
    let passes = cover(&CoverRequest::new(&face, &cutter, &options()), &Silent).unwrap().passes;
    for lead in [LeadKind::Axis, LeadKind::Tangent { length: 3.0 }] {
        let link = LinkOptions {
            lead,
            gouge: 0.002,
            ..LinkOptions::above(
                Vector3::z_axis(),
                vec![[Point3::new(0.0, 0.0, -9.0), Point3::new(30.0, 30.0, 12.0)]],
                8.0,
            )
        };
        let legs = legs(&LinkRequest::new(&passes, &face, &cutter, &link), &Silent).unwrap();
        assert_eq!(legs.len(), 4 * passes.len() - 1);
        // `through` refuses gaps and leads that turn.
        through(&legs, &ToolPathOptions::with_lever(lever(&cutter)), &Silent).unwrap();
        for leg in legs.iter().filter(|leg| leg.motion == Motion::Link) {
            for station in &leg.stations {
                assert!(station.pose.tip.z >= 20.0 + cutter.radius() - 1e-9);
            }
        }
    }
}

#[test]
fn a_lead_that_would_gouge_takes_another_way() {
    // A floor with a wall 12 mm high at x = 24.
    let profile = [[0.0, 0.0], [18.0, 0.0], [24.0, 0.0], [24.0, 12.0]];
    let wall = nurbs(
        profile
            .iter()
            .map(|[x, z]| (0..4).map(|j| Point3::new(*x, 10.0 * f64::from(j), *z)).collect())
            .collect(),
    );
    let faces = [face(wall, &[], false)];
    let standing = |x: f64, lean: f64| {
        let axis = nalgebra::Unit::new_normalize(Vector3::new(lean, 0.0, 1.0));
        let at = |y: f64| {
            let pose = ToolPose { tip: Point3::new(x, y, 8.0), axis };
            Station { pose, contact: Point3::new(x, y, 0.0) }
        };
        let stations = vec![at(10.0), at(20.0)];
        vec![Pass { face: 1, stations, widths: vec![1.0; 2], track: vec![Uv::new(0.0, 0.0); 2] }]
    };
    let link = LinkOptions {
        gouge: 0.01,
        ..LinkOptions::above(
            Vector3::z_axis(),
            vec![[Point3::origin(), Point3::new(24.0, 30.0, 12.0)]],
            3.0,
        )
    };
    // A longer tool would touch the wall with its flank from the start.
    let short = long(8.0);
    let up = |passes: &[Pass]| {
        let legs = legs(&LinkRequest::new(passes, &faces, &short, &link), &Silent).unwrap();
        let ends = &legs[2].stations;
        (ends[1].pose.tip - ends[0].pose.tip).normalize()
    };
    // Far from the wall the way is the axis, beside it the axis would lead into the wall.
    let free = standing(0.0, 0.4);
    assert!((up(&free) - *free[0].stations[0].pose.axis).norm() < 1e-12);
    let barred = standing(11.0, 1.5);
    assert!((up(&barred) - *barred[0].stations[0].pose.axis).norm() > 0.1);
    let flank = legs(&LinkRequest::new(&barred, &faces, &cutter(), &link), &Silent);
    assert!(matches!(flank, Err(CoverError::LeadGouges { .. })), "{flank:?}");
    // Inside the wall no way is free.
    let stuck = legs(&LinkRequest::new(&standing(22.0, 0.0), &faces, &short, &link), &Silent);
    assert!(matches!(stuck, Err(CoverError::LeadGouges { .. })), "{stuck:?}");
}
