//! Fixed-axis passes: the tool keeps its axis all over a curved face, and the rotary axes of the machine hold still.
//!
//! A ball touches wherever the normal is less than a right angle from the axis, and so does the corner of a bull-nose
//! cutter as a ball of its own radius. A location is therefore known in closed form, where a leaning rim has to be
//! searched for and does not fit a narrow fillet at all. Passes run along u or v, as far apart as strips of that ball
//! are wide. What they finish is proven as for all other passes.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::options::{CoverOptions, lever};
use crate::cover::pattern::{CutPattern, FeedDirection};
use crate::cover::place::ball_cap::BallCap;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::tool_fit::ContactPoint;
use crate::cover::prove::part_faces::KeepOff;
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::{ContactArc, Cutter, CutterKind};
use crate::math;
use crate::math::angle::angle_between;
use crate::positioning::ToleranceBand;
use crate::surface::{FaceIndex, Surface};
use crate::types::{Interval, Pass, Station, ToolPose};
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Height of the ball above the lower end of the tolerance band where it touches, as a share of the band.
const HEIGHT: f64 = 0.02;

/// Share of a strip's width by which the next pass follows.
const ADVANCE: f64 = 0.98;

/// Largest angle between normal and axis \[rad\]: the ball ends at a right angle.
const STEEPEST: f64 = 1.55;

/// Leans of the axis from the vertical that are tried, and directions of each \[rad\].
const LEANS: [f64; 4] = [0.2, 0.45, 0.7, 1.0];
const DIRECTIONS: u32 = 8;

/// Points of a face, each way, at which axes are compared.
const TRIED: u32 = 12;

/// Share of these points that the first axis in order has to reach.
const REACHED: f64 = 0.995;

/// Least share of the face that has to be finished: with less, passes whose inclination follows the face are better.
const LEAST: f64 = 0.9;

/// Points along a pass at which the distance of the next one is measured, and steps of its sum across.
const SAMPLES: u32 = 24;
const STEPS: u32 = 256;

/// Passes at most.
const PASSES: f64 = 4000.0;

/// Distance between points of a pass at which the tool is kept off, as a share of its radius; points at most and at
/// least.
const FINE: f64 = 0.03;
const POINTS: [f64; 2] = [32.0, 8192.0];

/// Halvings of the last step before something that the tool keeps off.
const HALVINGS: u32 = 24;

/// Largest distance between stations, as a share of the tool's radius, and turn of the normal between them \[rad\].
const SPACING: f64 = 0.5;
const TURN: f64 = 0.12;

/// Halvings of the distance between stations where the curve between them comes too near to a face.
const DENSER: u32 = 3;

/// Gap, in radii of the tool, over which a pass runs on.
const JOINED: f64 = 2.0;

/// Ball, or corner of a bull-nose cutter as a ball, that touches a face.
#[derive(Debug, Clone, Copy)]
struct CornerBall {
    arc: ContactArc,
    /// Height above the face where it touches \[mm\].
    height: f64,
    cap: BallCap,
}

impl CornerBall {
    /// Returns the ball of a cutter; `None` where it has none, or its side ends it.
    fn new(cutter: &Cutter, band: ToleranceBand) -> Option<Self> {
        let kind = cutter.spec().kind;
        let ball = matches!(kind, CutterKind::Ball | CutterKind::Bull) && cutter.minor() > 0.0;
        let cap = BallCap::new(band, HEIGHT);
        let height = band.lower + cap.above;
        ball.then(|| Self { arc: cutter.contact_arc(), height, cap })
    }

    /// Returns the pose in which the ball touches a point of the face; `None` beyond the end of the ball.
    fn pose(&self, at: &ContactPoint, axis: &UnitVector3<f64>) -> Option<ToolPose> {
        let angle = angle_between(&at.normal, axis);
        if angle > STEEPEST {
            return None;
        }
        // Where the normal is the axis, any direction serves.
        let lean = axis.into_inner() - at.normal.scale(at.normal.dot(axis));
        let towards = Unit::try_new(lean, f64::EPSILON).unwrap_or_else(|| {
            Unit::new_normalize(at.normal.cross(&Vector3::ith(at.normal.iamin(), 1.0)))
        });
        // The axis itself, without the rounding of sine and cosine: the rotaries hold still.
        Some(ToolPose { axis: *axis, ..self.inclined(at, &towards, angle) })
    }

    /// Returns the pose that touches a point of the face, inclined by an angle towards a tangent.
    fn inclined(&self, at: &ContactPoint, towards: &Vector3<f64>, angle: f64) -> ToolPose {
        let center = at.point + at.normal.scale(self.arc.radius + self.height);
        self.arc.pose(center, &at.normal, towards, angle)
    }

    /// Returns the width of its strip on a plane \[mm\].
    fn strip(&self) -> f64 {
        2.0 * self.cap.radius(self.arc.radius)
    }
}

/// Face on a straight chart, with the ball that touches it.
struct TouchedFace<'a> {
    face: &'a FaceIndex,
    chart: Chart,
    ball: CornerBall,
    /// Ranges across and along.
    bounds: [Interval; 2],
    /// `true` if passes run all round.
    closed: bool,
}

impl<'a> TouchedFace<'a> {
    fn new(face: &'a FaceIndex, along: FeedDirection, ball: CornerBall) -> Self {
        let chart = Chart::straight(along);
        let [u, v] = face.face().bounds();
        let [pu, pv] = face.face().surface.periods();
        let (bounds, period) = match along {
            FeedDirection::U => ([v, u], pu),
            _ => ([u, v], pv),
        };
        let closed = period.is_some_and(|period| bounds[1].width() >= period * (1.0 - 1e-9));
        Self { face, chart, ball, bounds, closed }
    }

    fn at(&self, local: ChartPoint) -> Option<ContactPoint> {
        ContactPoint::new(self.face, self.chart.uv(local))
    }

    fn pose(&self, local: ChartPoint, axis: &UnitVector3<f64>) -> Option<ToolPose> {
        self.ball.pose(&self.at(local)?, axis)
    }

    fn holds(&self, local: ChartPoint) -> bool {
        let [u, v] = self.chart.uv(local);
        self.face.face().contains(u, v)
    }

    /// Returns the width of a strip at a point, as a step of the parameter across; `None` where a step has no length.
    fn step(&self, local: ChartPoint) -> Option<f64> {
        let [u, v] = self.chart.uv(local);
        let face = self.face.face();
        let jet = face.surface.jet2(u, v);
        let normal = face.normal(u, v)?;
        let [[du, dv], [pu, pv]] = self.chart.steps(local);
        let over = jet.su * du + jet.sv * dv;
        let way = jet.su * pu + jet.sv * pv;
        let rate = over.norm();
        // The step square to the pass, and the curvature of the face along a step across: n.S'' / |S'|^2.
        let square = over.cross(&way).norm() / way.norm();
        let second = jet.suu * (du * du) + jet.suv * (2.0 * du * dv) + jet.svv * (dv * dv);
        let concave = normal.dot(&second) / (rate * rate);
        let lift = self.ball.arc.radius + self.ball.height;
        // The ball rises over the face by (1 / r - k) t^2 / 2 at a distance t; in a hollow of nearly its own radius it
        // finishes as much as it is wide.
        let bend = (1.0 / lift - concave).max(1.0 / (16.0 * lift));
        let width = 2.0 * (2.0 * self.ball.cap.rim / bend).sqrt().min(self.ball.arc.radius);
        let step = width / square;
        step.is_finite().then_some(step)
    }

    /// Returns the parameters across of the passes.
    fn tracks(&self) -> Option<Vec<f64>> {
        let [across, along] = self.bounds;
        // Step 1: the least step of each track, by points that lie on the face.
        let least = |c: f64| {
            let places =
                (0..SAMPLES).map(|j| [c, along.at((f64::from(j) + 0.5) / f64::from(SAMPLES))]);
            let held: Vec<ChartPoint> = places.filter(|place| self.holds(*place)).collect();
            held.iter().filter_map(|place| self.step(*place)).fold(f64::INFINITY, f64::min)
        };
        let parts: Vec<f64> = (0..STEPS)
            .into_par_iter()
            .map(|i| least(across.at((f64::from(i) + 0.5) / f64::from(STEPS))))
            .collect();
        // Step 2: the number of strips up to each place, and tracks in the middle of equal parts of it.
        let piece = across.width() / f64::from(STEPS);
        let mut sums = vec![0.0];
        for step in &parts {
            sums.push(sums[sums.len() - 1] + piece / (ADVANCE * step));
        }
        let count = sums[sums.len() - 1].ceil().max(1.0);
        if count.is_nan() || count > PASSES {
            return None;
        }
        let per = sums[sums.len() - 1] / count;
        let mut tracks = Vec::new();
        let mut part = 0;
        let mut index = 0.5;
        while index < count {
            let wanted = index * per;
            while part + 1 < parts.len() && sums[part + 1] < wanted {
                part += 1;
            }
            let share =
                (wanted - sums[part]) / (sums[part + 1] - sums[part]).max(f64::MIN_POSITIVE);
            tracks.push(across.low + piece * (part as f64 + share.clamp(0.0, 1.0)));
            index += 1.0;
        }
        Some(tracks)
    }

    /// Estimates the length of all passes, with `link` mm for each \[mm\].
    fn price(&self, tracks: &[f64], link: f64) -> f64 {
        let along = self.bounds[1];
        let length = |c: &f64| {
            let at = |j: u32| self.at([*c, along.at(f64::from(j) / f64::from(SAMPLES))]);
            let points: Vec<Point3<f64>> =
                (0..=SAMPLES).filter_map(at).map(|at| at.point).collect();
            points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>() + link
        };
        tracks.iter().map(length).sum()
    }

    /// Chooses the axis with which the tool reaches most of the face: the vertical, or one that leans as little as may be.
    fn axis(&self, keep_off: &KeepOff<'_>) -> Option<UnitVector3<f64>> {
        let at = |k: usize, i: u32| self.bounds[k].at((f64::from(i) + 0.5) / f64::from(TRIED));
        let all = (0..TRIED * TRIED).map(|i| [at(0, i / TRIED), at(1, i % TRIED)]);
        let places: Vec<ChartPoint> = all.filter(|place| self.holds(*place)).collect();
        let leaning = LEANS.into_iter().flat_map(|lean| {
            (0..DIRECTIONS).map(move |i| {
                let (sin, cos) = math::sin_cos(TAU * f64::from(i) / f64::from(DIRECTIONS));
                Unit::new_normalize(Vector3::new(
                    math::sin(lean) * cos,
                    math::sin(lean) * sin,
                    math::cos(lean),
                ))
            })
        });
        let mut best: Option<(usize, UnitVector3<f64>)> = None;
        for axis in std::iter::once(Vector3::z_axis()).chain(leaning) {
            let free = |place: &&ChartPoint| self.is_free(**place, &axis, keep_off);
            let reached = places.par_iter().filter(free).count();
            if best.is_none_or(|(most, _)| reached > most) {
                best = Some((reached, axis));
            }
            if reached as f64 >= REACHED * places.len() as f64 {
                break;
            }
        }
        best.filter(|(reached, _)| *reached as f64 >= LEAST * places.len() as f64 && *reached > 0)
            .map(|(_, axis)| axis)
    }

    fn is_free(&self, local: ChartPoint, axis: &UnitVector3<f64>, keep_off: &KeepOff<'_>) -> bool {
        self.pose(local, axis)
            .is_some_and(|pose| keep_off.cost.reaches(&pose) && !keep_off.hits_any(&pose))
    }
}

/// Returns `true` for a round face on which the normal turns so sharply that a tool which follows it would whip about, and
/// for a hollow into which the rim of a bull-nose cutter does not fit.
fn is_worth(face: &FaceIndex, cutter: &Cutter) -> bool {
    let round = matches!(
        face.face().surface,
        Surface::Cylinder(_) | Surface::Cone(_) | Surface::Sphere(_) | Surface::Torus(_)
    );
    if !round {
        return false;
    }
    if cutter.major() > 0.0 {
        // The rim of radius R + r, lying in the hollow, needs a hollow that is wider.
        return face.smallest_concave_radius() <= RIM * cutter.radius();
    }
    let Interval { low, high } = face.curvature_range(face.face().bounds());
    low.abs().max(high.abs()) * SHARP * cutter.radius() >= 1.0
}

/// Radius of a hollow over that of the cutter up to which its rim does not fit usefully.
const RIM: f64 = 1.5;

/// Radius of a rounding over that of a ball up to which the ball keeps its axis. On larger faces it keeps its lead, and
/// does not cut with its tip where the face is level.
const SHARP: f64 = 4.0;

/// Plans fixed-axis passes over a face; `None` where the face or the cutter is not of the kind, or no axis reaches most
/// of it. What the passes leave is in their report.
pub(crate) fn fixed_axis_passes(request: FaceRequest<'_>) -> Option<PlacedPasses> {
    let FaceRequest { face, setup, options, .. } = request;
    let ball = CornerBall::new(setup.cutter, options.band)?;
    if !is_worth(face, setup.cutter) {
        return None;
    }
    // Step 1: the direction with the shorter passes in all.
    let priced = |along: FeedDirection| {
        let touched = TouchedFace::new(face, along, ball);
        let tracks = touched.tracks()?;
        let price = touched.price(&tracks, if touched.closed { 0.0 } else { options.link });
        Some((price, touched, tracks))
    };
    let both = [FeedDirection::U, FeedDirection::V].into_iter().filter_map(priced);
    let (_, touched, tracks) = both.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let region = crate::cover::layout::trims::region(face, &touched.chart);
    let context = FaceContext::new(request, touched.chart.clone(), &region);
    let keep_off = context.keep_off();
    // Step 2: the axis.
    let axis = touched.axis(&keep_off)?;
    // Step 3: passes where the tool is free, and the proof that the curves between their stations are as well.
    let rows = FreeRows { touched: &touched, axis, keep_off, radius: setup.cutter.radius() };
    let mut runs: Vec<FreeRun> =
        tracks.into_par_iter().flat_map_iter(|across| rows.runs(across)).collect();
    alternate(&mut runs, &touched, options.pattern);
    let passes: Vec<(Pass, PassSweep)> =
        runs.par_iter().flat_map_iter(|run| rows.passes(run, &context)).collect();
    if setup.cutter.major() <= 0.0 && {
        let all: Vec<&Pass> = passes.iter().map(|(pass, _)| pass).collect();
        follows_sooner(&all, &touched, &request)
    } {
        return None;
    }
    let chart = touched.chart.clone();
    let source = PassSource { face: face.face().number, chart: &chart, options, cost: setup.cost };
    let mut placed = PlacedPasses::new();
    for (pass, sweep) in passes {
        placed.add_whole(pass, sweep, source);
    }
    if placed.passes.is_empty() {
        return None;
    }
    // Step 4: what the passes leave of the whole face.
    context.measure_whole(&mut placed);
    (placed.left() <= (1.0 - LEAST) * placed.report.area).then_some(placed)
}

/// Returns `true` if a ball would take less time for passes with its lead, by the cost model, than at a fixed axis.
///
/// The tip goes a longer way round a bulging face than the contact does, and the feed is that of the tip.
fn follows_sooner(passes: &[&Pass], touched: &TouchedFace<'_>, request: &FaceRequest<'_>) -> bool {
    let cost = request.setup.cost;
    let CoverOptions { lean, pattern, .. } = *request.options;
    // To and fro the axis stays as it is: on the return the tool leans back.
    let keeps = pattern == CutPattern::ZigZag && lean.towards.is_none();
    let leading = |pass: &Pass| -> Option<Vec<Station>> {
        let [first, last] = [pass.track.first()?, pass.track.last()?]
            .map(|uv| touched.chart.local((*uv).into())[1]);
        let way = if keeps && last < first { -1.0 } else { 1.0 };
        let ahead = |i: usize| {
            let (from, to) = (i.saturating_sub(1), (i + 1).min(pass.stations.len() - 1));
            pass.stations[to].contact - pass.stations[from].contact
        };
        let station = |i: usize| {
            let uv = pass.track[i];
            let at = ContactPoint::new(touched.face, uv.into())?;
            let feed = ahead(i) - at.normal.scale(at.normal.dot(&ahead(i)));
            let towards = Unit::try_new(feed.scale(way), f64::MIN_POSITIVE)?;
            let pose = touched.ball.inclined(&at, &towards, lean.angle);
            Some(Station { pose, contact: at.point })
        };
        (0..pass.stations.len()).map(station).collect()
    };
    let price = |all: &[Vec<Station>]| {
        let ends = |pair: &[Vec<Station>]| Some((*pair[0].last()?, *pair[1].first()?));
        let links = all.windows(2).filter_map(ends).map(|(from, to)| cost.link(&from, &to));
        all.iter().map(|stations| cost.pass(stations)).chain(links).sum::<f64>()
    };
    let fixed: Vec<Vec<Station>> = passes.iter().map(|pass| pass.stations.clone()).collect();
    let other: Option<Vec<Vec<Station>>> = passes.iter().map(|pass| leading(pass)).collect();
    other.is_some_and(|other| price(&other) < price(&fixed))
}

/// Part of a track on which the tool is free; `range` runs backwards where its ends have changed places.
#[derive(Debug, Clone, Copy)]
struct FreeRun {
    across: f64,
    range: [f64; 2],
    /// `true` if it runs all round.
    closed: bool,
}

/// Search of the parts of tracks on which the tool is free.
struct FreeRows<'a> {
    touched: &'a TouchedFace<'a>,
    axis: UnitVector3<f64>,
    keep_off: KeepOff<'a>,
    /// Radius of the tool \[mm\].
    radius: f64,
}

impl FreeRows<'_> {
    fn length(&self, across: f64) -> f64 {
        self.touched.price(&[across], 0.0)
    }

    fn is_free(&self, across: f64, along: f64) -> bool {
        self.touched.is_free([across, along], &self.axis, &self.keep_off)
    }

    /// Returns the free parts of a track that have something to cut.
    fn runs(&self, across: f64) -> Vec<FreeRun> {
        let touched = self.touched;
        let along = touched.bounds[1];
        let length = self.length(across);
        if length.is_nan() || length <= 0.0 {
            return Vec::new();
        }
        let parts = (length / (FINE * self.radius)).ceil().clamp(POINTS[0], POINTS[1]);
        // A pass runs on beyond the face by the width that its strips finish beside it.
        let half = 0.5 * touched.step([across, along.middle()]).unwrap_or(0.0);
        let beyond =
            if touched.closed { 0.0 } else { along.width() * touched.ball.strip() / length };
        let range = Interval::new(along.low - beyond, along.high + beyond);
        let at = |i: f64| range.at(i / parts);
        let count = std::iter::successors(Some(0.0), |i| Some(i + 1.0)).take_while(|i| *i <= parts);
        let places: Vec<f64> = count.map(at).collect();
        let cut = |place: f64| {
            [0.0, -half, half].into_iter().any(|by| touched.holds([across + by, place]))
        };
        let cut: Vec<bool> = places.iter().map(|place| cut(*place)).collect();
        let spread = (beyond / (range.width() / parts)).ceil();
        // Small and not negative.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let [joined, spread] =
            [JOINED * self.radius / (FINE * self.radius), spread].map(|n| n as usize);
        let wanted = joined_flags(&spread_flags(&cut, spread), joined);
        let free: Vec<bool> = places
            .iter()
            .zip(&wanted)
            .map(|(place, wanted)| *wanted && self.is_free(across, *place))
            .collect();
        if touched.closed && free.iter().all(|free| *free) {
            return vec![FreeRun { across, range: range.ends(), closed: true }];
        }
        let mut runs = Vec::new();
        let mut start: Option<usize> = None;
        for i in 0..=free.len() {
            match (start, free.get(i).copied().unwrap_or(false)) {
                (None, true) => start = Some(i),
                (Some(first), false) => {
                    let last = i - 1;
                    let low = first.checked_sub(1).filter(|before| wanted[*before]);
                    let low = low.map_or(places[first], |out| {
                        self.end(across, [places[first], places[out]])
                    });
                    let high = places.get(i).filter(|_| wanted[i]);
                    let high =
                        high.map_or(places[last], |out| self.end(across, [places[last], *out]));
                    let any = cut[first..=last].contains(&true);
                    if any && high > low {
                        runs.push(FreeRun { across, range: [low, high], closed: false });
                    }
                    start = None;
                }
                _ => {}
            }
        }
        runs
    }

    /// Returns the last free place between a free one and one that is not.
    fn end(&self, across: f64, [mut free, mut hit]: [f64; 2]) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (free + hit);
            if self.is_free(across, middle) {
                free = middle;
            } else {
                hit = middle;
            }
        }
        free
    }

    /// Makes the passes of a run: one, or its halves where the curve comes too near to a face.
    fn passes<Inside: Fn(ChartPoint) -> bool + Sync>(
        &self,
        run: &FreeRun,
        context: &FaceContext<'_, Inside>,
    ) -> Vec<(Pass, PassSweep)> {
        let count = self.stations(run);
        for denser in 0..=DENSER {
            let parts = count * f64::from(1 << denser);
            let Some(stations) = self.placed(run, parts) else { return Vec::new() };
            let sweep = PassSweep::through(&stations, lever(context.setup.cutter));
            if context.keeps_off(&sweep) {
                return vec![(context.whole_pass(stations, self.touched.ball.strip()), sweep)];
            }
        }
        let [from, to] = run.range;
        let middle = 0.5 * (from + to);
        if count < 4.0 {
            return Vec::new();
        }
        [[from, middle], [middle, to]]
            .into_iter()
            .flat_map(|range| self.passes(&FreeRun { range, closed: false, ..*run }, context))
            .collect()
    }

    /// Returns the number of spans between the stations of a run.
    fn stations(&self, run: &FreeRun) -> f64 {
        let [from, to] = run.range;
        let at = |i: u32| {
            let share = f64::from(i) / f64::from(SAMPLES);
            self.touched.at([run.across, from + (to - from) * share])
        };
        let points: Vec<ContactPoint> = (0..=SAMPLES).filter_map(at).collect();
        let length: f64 =
            points.windows(2).map(|pair| (pair[1].point - pair[0].point).norm()).sum();
        let turn: f64 =
            points.windows(2).map(|pair| angle_between(&pair[0].normal, &pair[1].normal)).sum();
        (length / (SPACING * self.radius)).max(turn / TURN).ceil().max(4.0)
    }

    /// Places the stations of a run; `None` where the face has no normal.
    fn placed(&self, run: &FreeRun, parts: f64) -> Option<Vec<Station>> {
        let [from, to] = run.range;
        // Round and a little on, so that the curve closes.
        let last = if run.closed { parts + 2.0 } else { parts };
        let places = std::iter::successors(Some(0.0), |i| Some(i + 1.0)).take_while(|i| *i <= last);
        let station = |i: f64| {
            let at = self.touched.at([run.across, from + (to - from) * i / parts])?;
            Some(Station { pose: self.touched.ball.pose(&at, &self.axis)?, contact: at.point })
        };
        places.map(station).collect()
    }
}

/// Sets the flags up to `by` places beside one that is set.
fn spread_flags(flags: &[bool], by: usize) -> Vec<bool> {
    let near =
        |i: usize| flags[i.saturating_sub(by)..(i + by + 1).min(flags.len())].contains(&true);
    (0..flags.len()).map(near).collect()
}

/// Sets the flags in gaps of up to `most` places.
fn joined_flags(flags: &[bool], most: usize) -> Vec<bool> {
    let mut joined = flags.to_vec();
    let mut last: Option<usize> = None;
    for (i, flag) in flags.iter().enumerate() {
        if !flag {
            continue;
        }
        if let Some(last) = last.filter(|last| i - last <= most) {
            joined[last..i].fill(true);
        }
        last = Some(i);
    }
    joined
}

/// Turns every run so that it begins at the end nearer to the end of the one before, unless passes run one way.
fn alternate(runs: &mut [FreeRun], touched: &TouchedFace<'_>, pattern: CutPattern) {
    if pattern == CutPattern::OneWay {
        return;
    }
    let mut end: Option<Point3<f64>> = None;
    for run in runs {
        let at = |along: f64| touched.at([run.across, along]).map(|at| at.point);
        let [Some(first), Some(last)] = run.range.map(at) else { continue };
        if let Some(end) = end
            && !run.closed
            && (end - last).norm() < (end - first).norm()
        {
            run.range.reverse();
        }
        end = touched.at([run.across, run.range[1]]).map(|at| at.point);
    }
}
