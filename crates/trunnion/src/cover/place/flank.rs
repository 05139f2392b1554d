//! Flank passes: the side of the tool lies along the straight lines of a face.
//!
//! On planes, cylinders, cones and extrusions the normal is the same all along a straight line (a ruling). A tool whose
//! axis is parallel to the ruling, its radius off along the normal, touches the whole line: one pass finishes the face
//! over the height of the tool's straight side, without any scallop.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::options::lever;
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::prove::sweep::PassSweep;
use crate::cutter::Cutter;
use crate::positioning::ToleranceBand;
use crate::surface::{FaceIndex, Surface};
use crate::types::{Station, ToolPose, Uv};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Least z of a ruling of unit length: a tool that lies flatter than about ten degrees hangs beside the part.
const LEAST_RISE: f64 = 0.17;

/// Largest z of the normal of a plane that is cut by the flank: flatter ones are cut by the underside.
const FLATTEST_WALL: f64 = 0.5;

/// Run of the tip beyond the lower end of the rulings where nothing is in its way, as a share of the radius, and at
/// most \[mm\].
const OVERRUN: [f64; 2] = [0.5, 2.0];

/// Share of the straight side that stays above the upper end of the rulings.
const SPARE: f64 = 0.02;

/// Halvings of the range in which the lowest tip is sought: from millimetres to nanometres.
const HALVINGS: u32 = 22;

/// Poses at which the tip is kept off the other faces in that search.
const TIP_POSES: usize = 48;

/// Share of the band by which the side of the tool stays inside it.
const INSIDE: f64 = 0.1;

/// Overlap of a pass round a closed face, as a share of the radius.
const OVERLAP: f64 = 0.1;

/// Tolerance of the polylines by which the extent of a face is found, as a share of its ranges.
const LOOP_SHARE: f64 = 1e-6;

/// A straight line of the face, upwards.
#[derive(Debug, Clone, Copy)]
struct Ruling {
    /// Point at height 0 of the line.
    foot: Point3<f64>,
    along: UnitVector3<f64>,
    normal: UnitVector3<f64>,
}

/// Coordinates of a face by its rulings: along the pass, and the height on the ruling \[mm\].
#[derive(Debug, Clone, Copy)]
enum RulingChart {
    /// The pass runs along u, and the rulings along v; `base` is v at height 0, `rate` the height by v \[mm\].
    Parameters { base: f64, rate: f64 },
    /// A plane: the pass runs along the first direction, and the rulings along the second.
    Plane { origin: Point3<f64>, across: Vector3<f64>, up: UnitVector3<f64> },
}

/// Face with rulings that a tool can lie along.
struct RuledFace<'a> {
    face: &'a FaceIndex,
    chart: RulingChart,
    /// Range along the pass; parameters, or mm on a plane.
    range: [f64; 2],
    /// Lowest and highest point of the face on its rulings \[mm\].
    heights: [f64; 2],
    /// `true` if the pass runs all round.
    closed: bool,
}

impl<'a> RuledFace<'a> {
    /// Finds the rulings of a face; `None` where it has none, or they lie too flat for a tool from above.
    fn new(face: &'a FaceIndex) -> Option<Self> {
        let [_, v] = face.face().bounds();
        let chart = match &face.face().surface {
            Surface::Plane(plane) => {
                let normal = plane.frame.z();
                if normal.z.abs() > FLATTEST_WALL {
                    return None;
                }
                // Steepest direction in the plane.
                let up = Vector3::z() - normal.scale(normal.z);
                let up = UnitVector3::try_new(up, f64::MIN_POSITIVE)?;
                let across = up.cross(&normal);
                RulingChart::Plane { origin: plane.frame.origin(), across, up }
            }
            Surface::Cylinder(_) | Surface::Cone(_) | Surface::Extrusion(_) => {
                let [u, _] = face.face().bounds();
                let step = face.face().surface.jet1(u.middle(), v.middle()).sv;
                let rate = step.norm() * if step.z < 0.0 { -1.0 } else { 1.0 };
                let base = if rate < 0.0 { v.high } else { v.low };
                RulingChart::Parameters { base, rate }
            }
            _ => return None,
        };
        let mut ruled = Self { face, chart, range: [0.0; 2], heights: [0.0; 2], closed: false };
        ruled.measure()?;
        let ends = ruled.range.map(|at| ruled.ruling(at));
        let rises = |ruling: &Option<Ruling>| ruling.is_some_and(|r| r.along.z >= LEAST_RISE);
        ends.iter().all(rises).then_some(ruled)
    }

    /// Finds the extent along the pass and along the rulings.
    fn measure(&mut self) -> Option<()> {
        let face = self.face.face();
        let [u, v] = face.bounds();
        let tolerance = [u, v].map(|range| LOOP_SHARE * range.width());
        let mut points: Vec<[f64; 2]> =
            face.loops.iter().flat_map(|trim| trim.polyline(tolerance)).collect();
        if points.is_empty() {
            points = vec![[u.low, v.low], [u.low, v.high], [u.high, v.low], [u.high, v.high]];
        }
        let places: Vec<[f64; 2]> = points.iter().map(|uv| self.place(*uv)).collect();
        let range = |k: usize| {
            let all = || places.iter().map(|place| place[k]);
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
        };
        (self.range, self.heights) = (range(0), range(1));
        if let RulingChart::Parameters { .. } = self.chart {
            // Loops that run round a closed face leave the box of the face.
            self.range = u.ends();
            let period = face.surface.periods()[0];
            self.closed = period.is_some_and(|period| u.width() >= period * (1.0 - LOOP_SHARE));
        }
        let finite = self.range.iter().chain(&self.heights).all(|x| x.is_finite());
        (finite && self.range[1] > self.range[0] && self.heights[1] > self.heights[0]).then_some(())
    }

    /// Returns the place of parameters: along the pass, and the height on the ruling.
    fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        match &self.chart {
            RulingChart::Parameters { base, rate } => [u, (v - base) * rate],
            RulingChart::Plane { origin, across, up } => {
                let point = self.face.face().point(u, v) - origin;
                [point.dot(across), point.dot(up)]
            }
        }
    }

    fn ruling(&self, at: f64) -> Option<Ruling> {
        match &self.chart {
            RulingChart::Parameters { base, rate } => {
                let face = self.face.face();
                let jet = face.surface.jet1(at, *base);
                let along = UnitVector3::try_new(jet.sv * rate.signum(), f64::MIN_POSITIVE)?;
                // Off the lower end: at the apex of a cone there is no normal.
                let middle = base + 0.5 * (self.heights[0] + self.heights[1]) / rate;
                let normal = face.normal(at, middle)?;
                Some(Ruling { foot: jet.s, along, normal })
            }
            RulingChart::Plane { origin, across, up } => {
                let [u, v] = self.face.face().bounds();
                let normal = self.face.face().normal(u.middle(), v.middle())?;
                Some(Ruling { foot: origin + across * at, along: *up, normal })
            }
        }
    }

    /// Returns the length of a step along the pass, at most on both ends of the rulings and on the path of the
    /// tool's axis \[mm\].
    fn pace(&self, at: f64, step: f64, radius: f64) -> Option<f64> {
        let [a, b] = [self.ruling(at)?, self.ruling(at + step)?];
        let apart = |height: f64, out: f64| {
            let at = |r: &Ruling| r.foot + r.along.scale(height) + r.normal.scale(out);
            (at(&b) - at(&a)).norm()
        };
        let [low, high] = self.heights;
        let all = [apart(low, 0.0), apart(high, 0.0), apart(low, radius), apart(high, radius)];
        Some(all.into_iter().fold(0.0, f64::max))
    }

    /// Returns the places of stations at most `spacing` apart, over the face and, round a closed one, a little more.
    fn stations(&self, spacing: f64, radius: f64) -> Option<Vec<f64>> {
        const SAMPLES: u32 = 64;
        let [first, last] = self.range;
        let step = (last - first) / f64::from(SAMPLES);
        let paces: Option<Vec<f64>> =
            (0..SAMPLES).map(|i| self.pace(first + step * f64::from(i), step, radius)).collect();
        let paces = paces?;
        let length: f64 = paces.iter().sum();
        let more = if self.closed { OVERLAP * radius * (last - first) / length } else { 0.0 };
        // Even steps of the parameter: the longest counts.
        let longest = paces.iter().copied().fold(0.0, f64::max) * f64::from(SAMPLES);
        let count = (longest / spacing).ceil().max(2.0);
        let width = last - first + more;
        let places = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
        Some(places.take_while(|i| *i <= count).map(|i| first + width * (i / count)).collect())
    }

    /// Returns the pose of a tool whose axis is `off` from a ruling, its tip at a height.
    fn pose(&self, at: f64, tip: f64, off: f64) -> Option<ToolPose> {
        let Ruling { foot, along, normal } = self.ruling(at)?;
        let tip = foot + along.scale(tip) + normal.scale(off);
        Some(ToolPose { tip, axis: along })
    }
}

/// Returns the distance of the tool axis from the rulings: the side lies on the face itself, where the band holds
/// that \[mm\].
fn offset(cutter: &Cutter, band: ToleranceBand) -> f64 {
    let spare = INSIDE * (band.upper - band.lower);
    cutter.radius() + 0.0_f64.clamp(band.lower + spare, band.upper - spare)
}

/// Returns the straight side of the tool above its corner \[mm\].
fn straight_side(cutter: &Cutter) -> [f64; 2] {
    let top = cutter.spec().shank.first().map_or(cutter.length(), |&[height, _]| height);
    [cutter.minor(), top]
}

/// Plans one flank pass over a face; `None` where the face has no rulings for it, the tool is too short, or it would
/// gouge. What the pass leaves is in its report.
pub(crate) fn flank_pass(request: FaceRequest<'_>) -> Option<PlacedPasses> {
    let FaceRequest { face, setup, options } = request;
    let cutter = setup.cutter;
    let ruled = RuledFace::new(face)?;
    // Step 1: the tool has to be as long as the rulings, and on a concave face narrower than it.
    let [corner, top] = straight_side(cutter);
    let [low, high] = ruled.heights;
    if top * (1.0 - SPARE) - corner < high - low
        || face.smallest_concave_radius() <= cutter.radius()
    {
        return None;
    }
    let chart = Chart::straight(FeedDirection::U);
    let region = crate::cover::layout::trims::region(face, &chart);
    let silent = |_: f64| Ok(());
    let context = FaceContext::new(request, chart.clone(), &region, &silent);
    // Step 2: the lowest tip that keeps off the other faces.
    let places = ruled.stations(options.spacing.high, cutter.radius())?;
    let off = offset(cutter, options.band);
    let tip = lowest_tip(&context, &ruled, &places, off)?;
    // Step 3: stations, touching in the middle of the rulings.
    let middle = 0.5 * (low + high);
    let stations: Option<Vec<Station>> = places
        .iter()
        .map(|at| {
            let ruling = ruled.ruling(*at)?;
            let contact = ruling.foot + ruling.along.scale(middle);
            Some(Station { pose: ruled.pose(*at, tip, off)?, contact })
        })
        .collect();
    let stations = stations?;
    // Step 4: the curve between the stations keeps off this face and all others.
    let sweep = PassSweep::through(&stations, lever(cutter));
    if !context.keeps_off(&sweep) {
        return None;
    }
    let pass = context.whole_pass(stations, high - low);
    let mut placed = PlacedPasses::new();
    let source = PassSource { face: face.face().number, chart: &chart, options, cost: setup.cost };
    placed.add_whole(pass, sweep, source);
    // Step 5: what the pass leaves of the whole face.
    context.measure_whole(&mut placed);
    Some(placed)
}

/// Finds the lowest height of the tip at which the tool keeps off all other faces, all along the pass.
fn lowest_tip<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    ruled: &RuledFace<'_>,
    places: &[f64],
    off: f64,
) -> Option<f64> {
    let (cutter, keep_off) = (context.setup.cutter, context.keep_off());
    let stride = places.len().div_ceil(TIP_POSES).max(1);
    let clear = |tip: f64| {
        places.iter().step_by(stride).chain(places.last()).all(|at| {
            let pose = ruled.pose(*at, tip, off);
            pose.is_some_and(|pose| keep_off.check(&pose, Uv::new(0.0, 0.0)).is_ok())
        })
    };
    let [low, high] = ruled.heights;
    let over = (OVERRUN[0] * cutter.radius()).min(OVERRUN[1]);
    let mut below = low - cutter.minor() - over;
    if clear(below) {
        return Some(below);
    }
    // Above the lower end by half the height there would be little left to finish.
    let mut above = 0.5 * (low + high);
    if !clear(above) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (below + above);
        if clear(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    Some(above)
}
