//! Floor passes: a tool stands on a plane and keeps its axis.
//!
//! A tool with a flat underside stands upright. A ball leans by its lead in one direction all over the plane, so the
//! rotary axes of the machine hold still; its underside is the cap that is no higher than the excess allowed.
//!
//! The tool keeps off all other faces while its centre is in a certain region of the plane. Passes run along straight
//! lines, nearly as far apart as the underside is wide, and along the border of that region. They finish every point
//! that the underside reaches: either the tool may stand on the line right across from the point, or the border of the
//! region comes as near to the point as the underside is wide.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::contour::{
    Contour, ContourTolerance, LevelField, LevelGrid, PlanePoint, apart, between, on_contour,
    zero_between,
};
use crate::cover::layout::outline::FaceOutline;
use crate::cover::options::{CoverOptions, lever};
use crate::cover::pattern::{CutPattern, FeedDirection};
use crate::cover::place::ball_cap::BallCap;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::prove::part_faces::{KeepOff, NearestQuery};
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::{Cutter, CutterKind};
use crate::math;
use crate::positioning::ToleranceBand;
use crate::surface::{FaceIndex, Surface};
use crate::types::{Interval, Pass, Station, ToolPose};
use nalgebra::{Point3, UnitVector3, Vector3};
use rayon::prelude::*;

/// Least radius of the underside, as a share of the tool's: a narrower one leaves the plane to inclined tools.
const LEAST_FLAT: f64 = 0.25;

/// Height of a flat underside above the lower end of the tolerance band, as a share of the band. The edges of the plane
/// are as far below the underside, while the tool keeps the lower end from all other faces: it may run over the edges.
const HEIGHT: f64 = 0.2;

/// The same for a ball, whose cap is the wider the lower it runs.
const BALL_HEIGHT: f64 = 0.05;

/// Share of the underside's radius that a line is to finish to either side.
const REACH: f64 = 0.9;

/// The same for a ball: passes are narrow, and those along the border finish the rest.
const BALL_REACH: f64 = 0.98;

/// Directions in which a ball is tried to lean.
const LEANS: u32 = 8;

/// Points of a plane, each way, at which the directions are compared.
const TRIED: u32 = 16;

/// Share of the points that an upright ball reaches which a leaning one has to reach as well.
const REACHED: f64 = 0.98;

/// Run of the lines beyond the plane, as a share of the underside's radius.
const BEYOND: f64 = 0.05;

/// Gap, in radii of the tool, over which a line runs on.
const JOINED: f64 = 4.0;

/// Cells of the grid in a radius of the tool. What the tool cannot enter is at least as wide as the tool.
const CELLS: f64 = 4.0;

/// Nodes of a grid at most: a larger plane is left to passes that need none.
const NODES: usize = 250_000;

/// Cells of a finer grid in one of that grid, each way: what the tool barely enters may be narrower than a cell.
const FINER: usize = 4;

/// Distance within which a border has been found, as a share of the tool's radius: chords are far nearer to it.
const FOUND: f64 = 0.005;

/// Step along a line, as a share of the tool's radius. An obstacle is at least as wide as the tool: one that reaches
/// into the line between two steps does so by less than 0.0001 of the radius.
const STEP: f64 = 0.02;

/// Shortest pass on a line, as a share of the tool's radius: what it finishes is finished along the border too.
const SHORTEST: f64 = 0.02;

/// Height of the underside over the distance by which the tool's region keeps off the other faces beyond what they need:
/// more than 1, so that the tool runs over edges. Where it goes round a convex edge of the part, a nick of a tenth of a
/// micrometre is as deep, along the edge, as the tool is long.
const HIGHER: f64 = 4.0 / 3.0;

/// Distances are known up to this much above the one that the tool keeps \[mm\]: far ones take long to find.
const KNOWN: f64 = 1e-4;

/// Distance up to which a point lies on the border of the tool's region \[mm\]: about what distances are known to.
const ROOT: f64 = 2e-5;

/// Chord at which a border that still bends has a corner \[mm\].
const CORNER: f64 = 1e-4;

/// Largest distance of a border from its chords, in path shares: the curve through the stations is far nearer.
const SAGITTA: f64 = 4.0;

/// Largest distance between stations, as a share of the tool's radius.
const SPACING: f64 = 0.5;

/// Largest ratio of the chords on both sides of a station on a border.
const GRADED: f64 = 2.0;

/// Halvings of the distance between stations where the curve between them comes too near to a face.
const DENSER: u32 = 3;

/// Halvings of a path that gouges somewhere, or that the machine does not reach all along.
const HALVINGS: u32 = 5;

/// Underside of a tool that stands on a plane.
#[derive(Debug, Clone, Copy)]
struct Underside {
    /// Radius of what it finishes \[mm\].
    radius: f64,
    /// Share of that radius that a line is to finish to either side.
    reach: f64,
    /// Height above the lower end of the band \[mm\].
    above: f64,
    /// Radius of the ball about which the tool may lean; 0 for a tool that stands upright \[mm\].
    ball: f64,
}

impl Underside {
    /// Returns the underside of a cutter; `None` where it has none to speak of.
    fn new(cutter: &Cutter, band: ToleranceBand) -> Option<Self> {
        if cutter.spec().kind == CutterKind::Ball {
            let (ball, cap) = (cutter.minor(), BallCap::new(band, BALL_HEIGHT));
            let radius = cap.radius(ball);
            return (radius > 0.0).then_some(Self {
                radius,
                reach: BALL_REACH,
                above: cap.above,
                ball,
            });
        }
        let radius = cutter.major();
        (radius >= LEAST_FLAT * cutter.radius()).then_some(Self {
            radius,
            reach: REACH,
            above: HEIGHT * (band.upper - band.lower),
            ball: 0.0,
        })
    }

    /// Returns the distance that a line is to finish to either side \[mm\].
    fn reach(&self) -> f64 {
        self.reach * self.radius
    }
}

/// Plane of the floor with the tool on it.
struct FloorFrame {
    origin: Point3<f64>,
    axes: [Vector3<f64>; 2],
    normal: UnitVector3<f64>,
    /// Axis of the tool.
    tool: UnitVector3<f64>,
    underside: Underside,
    /// Height of the underside \[mm\].
    height: f64,
}

impl FloorFrame {
    fn new(face: &FaceIndex, options: &CoverOptions, underside: Underside) -> Option<Self> {
        let Surface::Plane(plane) = &face.face().surface else { return None };
        let [u, v] = face.face().bounds();
        let normal = face.face().normal(u.middle(), v.middle())?;
        let x = plane.frame.x().into_inner();
        let axes = [x, normal.cross(&x)];
        let height = options.band.lower + underside.above;
        let origin = plane.frame.origin();
        Some(Self { origin, axes, normal, tool: normal, underside, height })
    }

    /// Leans the tool in a direction of the plane, given as an angle.
    fn leaning(&self, lean: f64, towards: f64) -> Self {
        let (sin, cos) = math::sin_cos(towards);
        let [x, y] = self.axes;
        let way = x * cos + y * sin;
        let tool =
            UnitVector3::new_normalize(self.normal.scale(math::cos(lean)) + way * math::sin(lean));
        Self { tool, ..*self }
    }

    /// Turns the axes about the normal.
    fn turned(self, angle: f64) -> Self {
        let (sin, cos) = math::sin_cos(angle);
        let [x, y] = self.axes;
        Self { axes: [x * cos + y * sin, y * cos - x * sin], ..self }
    }

    fn place(&self, point: &Point3<f64>) -> PlanePoint {
        let out = point - self.origin;
        self.axes.map(|axis| axis.dot(&out))
    }

    fn point(&self, p: PlanePoint) -> Point3<f64> {
        self.origin + self.axes[0] * p[0] + self.axes[1] * p[1]
    }

    fn pose(&self, p: PlanePoint) -> ToolPose {
        // The middle of the ball stays above the point, and the tip goes round it.
        let round = (self.normal.into_inner() - self.tool.into_inner()) * self.underside.ball;
        let tip = self.point(p) + self.normal.scale(self.height) + round;
        ToolPose { tip, axis: self.tool }
    }

    /// Leans a ball in the direction in which it reaches most of the plane; it stands upright where leaning costs too
    /// much of that, and `None` where the machine reaches neither.
    fn best_leaning(
        self,
        lean: f64,
        outline: &FaceOutline,
        keep_off: &KeepOff<'_>,
        distance: f64,
    ) -> Option<Self> {
        let [low, high] = outline.bounds();
        let at = |k: usize, i: u32| {
            low[k] + (high[k] - low[k]) * (f64::from(i) + 0.5) / f64::from(TRIED)
        };
        let all = (0..TRIED * TRIED).map(|i| [at(0, i / TRIED), at(1, i % TRIED)]);
        let places: Vec<PlanePoint> = all.filter(|p| outline.is_near(*p, 0.0)).collect();
        let reached = |frame: &Self| {
            let poses = || places.iter().map(|p| frame.pose(*p));
            // The axis is the same everywhere, and with it the rotary axes.
            let reaches = poses().next().is_some_and(|pose| keep_off.cost.reaches(&pose));
            let free = |pose: &ToolPose| spare(keep_off, pose, distance) > 0.0;
            if reaches { poses().filter(free).count() } else { 0 }
        };
        let leaning = (0..LEANS).into_par_iter().map(|i| {
            let frame = self.leaning(lean, std::f64::consts::TAU * f64::from(i) / f64::from(LEANS));
            (reached(&frame), frame)
        });
        let leaning: Vec<(usize, Self)> = leaning.collect();
        let upright = reached(&self);
        // The first of the best, so that the order decides among equals.
        let best = leaning.into_iter().rev().max_by_key(|(reached, _)| *reached);
        match best {
            Some((most, frame)) if most > 0 && most as f64 >= REACHED * upright as f64 => {
                Some(frame)
            }
            _ => (upright > 0).then_some(self),
        }
    }

    /// Returns the outline of the face.
    fn outline(&self, face: &FaceIndex, tolerance: f64) -> FaceOutline {
        let face = face.face();
        // Parameters of a plane are lengths.
        let loops = face.loops.iter().map(|trim| {
            let corners = trim.polyline([tolerance; 2]);
            corners.iter().map(|[u, v]| self.place(&face.point(*u, *v))).collect()
        });
        let mut loops: Vec<Vec<PlanePoint>> = loops.collect();
        if loops.is_empty() {
            let [u, v] = face.bounds();
            let corners = [[u.low, v.low], [u.high, v.low], [u.high, v.high], [u.low, v.high]];
            loops.push(corners.iter().map(|[u, v]| self.place(&face.point(*u, *v))).collect());
        }
        FaceOutline::new(loops)
    }
}

/// Kind of a path of the tool's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PathKind {
    /// Straight line that may be run either way.
    Line,
    /// Straight line that is run one way.
    OneWayLine,
    /// Border of the tool's region, with the obstacle on the right: the cutter climbs.
    Border,
}

/// Plans floor passes over a plane; `None` where the face is none, the tool has no flat underside, or no pass is possible.
/// Their report lists the material that they leave.
pub(crate) fn floor_passes(request: FaceRequest<'_>) -> Option<PlacedPasses> {
    let FaceRequest { face, setup, options, .. } = request;
    let underside = Underside::new(setup.cutter, options.band)?;
    let (flat, radius) = (underside.radius, setup.cutter.radius());
    let frame = FloorFrame::new(face, options, underside)?;
    // Step 1: the direction of the lines.
    let outline = frame.outline(face, options.path_share);
    let angle = outline.direction(2.0 * underside.reach());
    let frame = frame.turned(angle);
    let outline = outline.turned(angle);
    let [low, high] = outline.bounds();
    let step = radius / CELLS;
    let margin = flat + step;
    let bounds = [low.map(|x| x - margin), high.map(|x| x + margin)];
    let grid = LevelGrid::over(bounds, step);
    if grid.nodes() > NODES || !low.iter().chain(&high).all(|x| x.is_finite()) {
        return None;
    }
    let chart = Chart::straight(FeedDirection::U);
    let region = crate::cover::layout::trims::region(face, &chart);
    let context = FaceContext::new(request, chart.clone(), &region);
    let keep_off = context.keep_off();
    let distance = keep_off.least + underside.above / HIGHER;
    let frame = if underside.ball > 0.0 {
        frame.best_leaning(options.lean.angle, &outline, &keep_off, distance)?
    } else {
        frame
    };
    let distance_at = |p: PlanePoint| spare(&keep_off, &frame.pose(p), distance);
    let field = LevelField { distance: &distance_at, root: ROOT };
    // Step 2: the border of the tool's region near the face, and the lines in that region.
    let tolerance = ContourTolerance {
        sagitta: SAGITTA * options.path_share,
        longest: SPACING * radius,
        corner: CORNER,
    };
    let near = |p: &PlanePoint| outline.is_near(*p, margin);
    let borders_on = |grid: LevelGrid| -> Vec<Contour> {
        let contours = grid.contours(field);
        let near = contours.iter().flat_map(|contour| contour.parts(near));
        near.flat_map(|part| part.followed(field, tolerance)).collect()
    };
    let free: Vec<FreeLine> = outline
        .lines(underside.reach(), JOINED * radius)
        .into_par_iter()
        .flat_map_iter(|line| {
            let beyond = BEYOND * flat;
            let ranges = line.along.into_iter();
            let ranges = ranges.map(|range| Interval::new(range.low - beyond, range.high + beyond));
            let free = ranges.flat_map(|range| FreeLine::find(range, line.across, field, radius));
            free.collect::<Vec<_>>()
        })
        .collect();
    let mut borders = borders_on(grid);
    // Where the tool barely gets through, its region may be narrower than the cells: a line ends at a border that is not found,
    // or a border runs across the region.
    let is_found =
        |end: &PlanePoint| borders.iter().any(|border| border.distance(*end) <= FOUND * radius);
    let are_found = || {
        free.iter().flat_map(|line| &line.on_border).all(is_found)
            && !borders.iter().any(|border| border.strays(field, FOUND * radius))
    };
    let finer = grid.finer(FINER);
    if finer.nodes() <= FINER * FINER * NODES && !are_found() {
        borders = borders_on(finer);
    }
    let lines = free.into_iter();
    let lines = lines.map(|line| Contour { points: line.ends.to_vec(), closed: false }).collect();
    // Step 3: passes in an order without long links.
    let line = match options.pattern {
        CutPattern::ZigZag => PathKind::Line,
        CutPattern::OneWay => PathKind::OneWayLine,
    };
    let mut at = None;
    let mut paths = ordered(lines, line, &mut at);
    paths.extend(ordered(borders, PathKind::Border, &mut at));
    let source = PassSource { face: face.face().number, chart: &chart, options, cost: setup.cost };
    let mut placed = PlacedPasses::new();
    let planned: Vec<(Pass, PassSweep)> = paths
        .par_iter()
        .flat_map_iter(|path| path.passes(&context, &frame, field, HALVINGS))
        .collect();
    for (pass, sweep) in planned {
        placed.add_whole(pass, sweep, source);
    }
    if placed.passes.is_empty() {
        return None;
    }
    // Step 4: what the passes leave of the whole face.
    context.measure_whole(&mut placed);
    Some(placed)
}

/// Returns the distance of the tool from all other faces beyond the one that it keeps, [`KNOWN`] at most; a negative
/// number where it is less \[mm\].
fn spare(keep_off: &KeepOff<'_>, pose: &ToolPose, distance: f64) -> f64 {
    let (part_faces, own) = (keep_off.part_faces, Some(keep_off.own));
    let within = distance + KNOWN;
    let query = NearestQuery { enough: distance, ..NearestQuery::any(within, keep_off.precision) };
    let mut solids = keep_off.tool.solids();
    let near = |solid| part_faces.nearest(solid, pose, own, query).map(|near| near.distance);
    let least = solids.try_fold(within, |least, solid| {
        let least = near(solid).map_or(least, |near| least.min(near));
        // Only the sign counts below.
        if least < distance { Err(least) } else { Ok(least) }
    });
    least.unwrap_or_else(|least| least) - distance
}

/// Part of a line along which the tool may stand.
struct FreeLine {
    ends: [PlanePoint; 2],
    /// Those ends that lie on the border of the tool's region.
    on_border: Vec<PlanePoint>,
}

impl FreeLine {
    /// Finds the parts of a range on a line along which a field is positive.
    fn find(range: Interval, across: f64, field: LevelField<'_>, radius: f64) -> Vec<Self> {
        let mut free = Vec::new();
        let mut at = range.low;
        let mut is_free = field.is_free([at, across]);
        let mut start = is_free.then_some(at);
        while at < range.high {
            let next = (at + STEP * radius).min(range.high);
            let ahead = field.is_free([next, across]);
            if ahead != is_free {
                let [cut, _] = zero_between([at, across], [next, across], field);
                match start.take() {
                    Some(low) => free.push(Interval::new(low, cut)),
                    None => start = Some(cut),
                }
            }
            (at, is_free) = (next, ahead);
        }
        free.extend(start.map(|low| Interval::new(low, range.high)));
        free.retain(|range| range.width() > SHORTEST * radius);
        let line = |part: Interval| {
            let on_border =
                part.ends().into_iter().filter(|end| *end > range.low && *end < range.high);
            Self {
                ends: part.ends().map(|along| [along, across]),
                on_border: on_border.map(|along| [along, across]).collect(),
            }
        };
        free.into_iter().map(line).collect()
    }
}

/// Path of the tool's centre.
struct FloorPath {
    contour: Contour,
    kind: PathKind,
}

/// Orders paths: after each, the one that begins nearest to its end.
fn ordered(mut paths: Vec<Contour>, kind: PathKind, at: &mut Option<PlanePoint>) -> Vec<FloorPath> {
    let mut order = Vec::new();
    while !paths.is_empty() {
        let from = at.or_else(|| paths.first()?.points.first().copied()).unwrap_or([0.0; 2]);
        let begins = |path: &Contour| -> Vec<(f64, usize)> {
            let last = path.points.len() - 1;
            let starts: Vec<usize> = match (path.closed, kind) {
                (true, _) => (0..=last).collect(),
                (false, PathKind::Line) => vec![0, last],
                (false, PathKind::OneWayLine | PathKind::Border) => vec![0],
            };
            starts.into_iter().map(|start| (apart(from, path.points[start]), start)).collect()
        };
        let nearest = paths
            .iter()
            .enumerate()
            .flat_map(|(index, path)| begins(path).into_iter().map(move |start| (index, start)))
            .min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
        let Some((index, (_, start))) = nearest else { break };
        let mut path = paths.remove(index);
        if path.closed {
            path.points.rotate_left(start);
        } else if start > 0 {
            path.points.reverse();
        }
        *at = if path.closed { path.points.first() } else { path.points.last() }.copied();
        order.push(FloorPath { contour: path, kind });
    }
    order
}

impl FloorPath {
    /// Makes passes of the path but for the pieces where it is none.
    fn passes<Inside: Fn([f64; 2]) -> bool + Sync>(
        &self,
        context: &FaceContext<'_, Inside>,
        frame: &FloorFrame,
        field: LevelField<'_>,
        halvings: u32,
    ) -> Vec<(Pass, PassSweep)> {
        let whole = self.pass(context, frame, field);
        if whole.is_some() || halvings == 0 {
            return whole.into_iter().collect();
        }
        let halves = self.halves().into_iter().flatten();
        halves.flat_map(|half| half.passes(context, frame, field, halvings - 1)).collect()
    }

    /// Returns both halves of the path, one behind the other; `None` for a piece of a border between two points.
    fn halves(&self) -> Option<[Self; 2]> {
        let Self { contour, kind } = self;
        let mut points = contour.points.clone();
        if contour.closed {
            points.extend(contour.points.first());
        }
        if let ([a, b], true) = (&points[..], *kind != PathKind::Border) {
            points = vec![*a, between(*a, *b, 0.5), *b];
        }
        let middle = points.len() / 2;
        let is_short = middle == 0 || middle + 1 == points.len();
        let of = |points: &[PlanePoint]| Self {
            contour: Contour { points: points.to_vec(), closed: false },
            kind: *kind,
        };
        (!is_short).then(|| [of(&points[..=middle]), of(&points[middle..])])
    }

    /// Makes a pass of the path; `None` where the machine does not reach it, or it gouges however dense its stations
    /// are.
    fn pass<Inside: Fn([f64; 2]) -> bool + Sync>(
        &self,
        context: &FaceContext<'_, Inside>,
        frame: &FloorFrame,
        field: LevelField<'_>,
    ) -> Option<(Pass, PassSweep)> {
        let cutter = context.setup.cutter;
        let mut points = self.points(SPACING * cutter.radius());
        if !points.iter().all(|p| context.setup.cost.reaches(&frame.pose(*p))) {
            return None;
        }
        if self.kind == PathKind::Border {
            points = graded(&points, field);
        }
        // A straight line is the same with more stations.
        let tries = if self.kind == PathKind::Border { DENSER } else { 0 };
        for denser in 0..=tries {
            if denser > 0 {
                points = halved(&points, field);
            }
            let stations: Vec<Station> = points
                .iter()
                .map(|p| Station { pose: frame.pose(*p), contact: frame.point(*p) })
                .collect();
            if !stations.iter().all(|station| context.setup.cost.reaches(&station.pose)) {
                return None;
            }
            let sweep = PassSweep::through(&stations, lever(cutter));
            if context.keeps_off(&sweep) {
                return Some((context.whole_pass(stations, 2.0 * frame.underside.radius), sweep));
            }
        }
        None
    }

    /// Returns the points of the stations.
    fn points(&self, spacing: f64) -> Vec<PlanePoint> {
        let Contour { points, closed } = &self.contour;
        if let [a, b] = points[..] {
            let parts = (apart(a, b) / spacing).ceil().max(2.0);
            let steps = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
            return steps.take_while(|i| *i <= parts).map(|i| between(a, b, i / parts)).collect();
        }
        // Round and a little on, so that the curve closes.
        let more = if *closed { 2 } else { 0 };
        points.iter().chain(points.iter().take(more)).copied().collect()
    }
}

/// Adds points of a border until no chord is more than [`GRADED`] times as long as the next.
///
/// Where a straight piece runs into a round one, the curve through the stations overshoots. The overshoot grows with the
/// longer of the two chords there, so short chords beside a long one do not help.
fn graded(points: &[PlanePoint], field: LevelField<'_>) -> Vec<PlanePoint> {
    let mut graded = points.to_vec();
    loop {
        let chords: Vec<f64> = graded.windows(2).map(|pair| apart(pair[0], pair[1])).collect();
        let is_long = |i: usize| {
            let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
            let least = beside.filter_map(|k| chords.get(k)).fold(f64::INFINITY, |a, b| a.min(*b));
            chords[i] > GRADED * least.max(CORNER)
        };
        if !(0..chords.len()).any(is_long) {
            return graded;
        }
        let mut finer = Vec::new();
        for (i, pair) in graded.windows(2).enumerate() {
            finer.push(pair[0]);
            if is_long(i) {
                finer.push(middle([pair[0], pair[1]], field));
            }
        }
        finer.extend(graded.last());
        graded = finer;
    }
}

/// Returns the point of the border across from the middle of a chord, or that middle.
fn middle(chord: [PlanePoint; 2], field: LevelField<'_>) -> PlanePoint {
    on_contour(chord, field).unwrap_or_else(|| between(chord[0], chord[1], 0.5))
}

/// Adds points of a border between each two.
fn halved(points: &[PlanePoint], field: LevelField<'_>) -> Vec<PlanePoint> {
    let mut dense = Vec::new();
    for pair in points.windows(2) {
        dense.push(pair[0]);
        dense.push(middle([pair[0], pair[1]], field));
    }
    dense.extend(points.last());
    dense
}
