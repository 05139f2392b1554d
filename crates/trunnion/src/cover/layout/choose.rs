//! Choice of the pass layout: the charts on which passes are placed in earnest.
//!
//! A chart is judged by an estimate. The widths of its passes come from a table
//! ([`StripWidthTable`]), each pass advances by the least cost ([`advance`]), and the costs of all
//! passes are added up. For [`FeedDirection::Curvature`] passes are bent to the directions of least
//! curvature in the least-squares sense. For [`FeedDirection::Adaptive`] the bends with the least
//! estimated cost are searched, and the best of these are placed beside lines of constant u and v.

use crate::cover::layout::advance::{self, AdvanceCosts, PassPart};
use crate::cover::layout::cell_grid::CellGrid;
use crate::cover::layout::chart::{BentChart, Chart, ChartSpline};
use crate::cover::layout::effort::WorkCounter;
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::widths::{self, StripWidthTable, TableFill};
use crate::cover::options::CoverOptions;
use crate::cover::pattern::{FeedDirection, PlacementMethod};
use crate::cutter::Cutter;
use crate::math;
use crate::surface::FaceIndex;
use crate::types::Interval;
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of straight frames over half a turn. No pass leans from its own frame by more than half
/// the angle to the next.
const FRAMES: u32 = 4;

/// Intervals of the spline across and along. With more intervals the passes follow details that no
/// tool can: passes a few cutters apart are alike.
const INTERVALS: [usize; 2] = [2, 3];

/// Rounds of a fit. Each takes the directions where the passes of the round before lie.
const ROUNDS: u32 = 4;

/// Largest slope of a pass against its frame that is fitted.
const LEAN: f64 = 1.5;

/// Samples each way for a fit, and along an estimated pass; largest number of estimated passes.
const SAMPLES: u32 = 24;
const PASSES: u32 = 500;

/// Weight of the second differences of a bend in a fit, and number of times that it is multiplied
/// by ten until passes do not cross.
const STIFF: f64 = 1e-3;
const STIFFER: u32 = 8;

/// Weight of the coefficients themselves, over that of the second differences. It is small, and
/// settles the coefficients that neither second differences nor slopes along determine.
const GROUND: f64 = 1e-3;

/// Steps of the search, as shares of the face's extent.
const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// Number of bends that are searched, and of charts that are placed in earnest.
const SEARCHED: usize = 3;
const PLACED: usize = 4;

/// Largest estimated cost over the least one at which a chart may still turn out best.
const HOPE: f64 = 1.5;

/// The same on a closed face, where passes run round it or across and nothing bends them.
const CLOSED_HOPE: f64 = 1.25;

/// Forms by which passes are bent: powers of the coordinates across and along. Those without the
/// second would only renumber the passes.
const FORMS: [[i32; 2]; 8] = [[0, 1], [0, 2], [1, 1], [0, 3], [1, 2], [2, 1], [1, 3], [2, 2]];

/// Chooses the charts to place passes on, the most promising first.
pub(crate) fn choose(
    part: WantedPart<'_>,
    cutter: &Cutter,
    options: &CoverOptions,
) -> ChosenLayouts {
    let face = part.face;
    if let FeedDirection::U | FeedDirection::V = options.feed_direction {
        return ChosenLayouts { charts: vec![Chart::straight(options.feed_direction)], work: 0 };
    }
    let work = WorkCounter::default();
    // The strips of a barrel are as wide as the face bends across them.
    let varies = options.method == PlacementMethod::Widest || cutter.is_barrel();
    let table = options.feed_direction == FeedDirection::Adaptive && varies;
    let narrow = advance::ball_strip_width(cutter, options);
    let widths = table
        .then(|| StripWidthTable::new(face, cutter, options, &TableFill { narrow, work: &work }));
    let found =
        LayoutChooser::new(part, cutter, options, widths).map_or_else(Vec::new, |chooser| {
            if chooser.closed {
                chooser.straight()
            } else if options.feed_direction == FeedDirection::Curvature {
                chooser.curvature()
            } else {
                chooser.adaptive()
            }
        });
    let plain = || [FeedDirection::V, FeedDirection::U].map(Chart::straight).to_vec();
    let charts = if found.is_empty() { plain() } else { found };
    ChosenLayouts { charts, work: work.done() }
}

/// Charts of a face, the most promising first.
pub(crate) struct ChosenLayouts {
    pub(crate) charts: Vec<Chart>,
    /// Work of the choice.
    pub(crate) work: u64,
}

/// Part of a face that passes are to finish.
#[derive(Clone, Copy)]
pub(crate) struct WantedPart<'a> {
    pub(crate) face: &'a FaceIndex,
    /// Cells that no pass finishes.
    pub(crate) without: Option<&'a CellGrid>,
}

impl WantedPart<'_> {
    fn holds(&self, uv: [f64; 2]) -> bool {
        self.face.face().contains(uv[0], uv[1]) && self.without.is_none_or(|cells| !cells.holds(uv))
    }
}

/// Bent passes with their estimated cost.
#[derive(Clone)]
struct PricedBend {
    price: f64,
    bent: BentChart,
}

/// Face whose layouts are compared.
struct LayoutChooser<'a> {
    part: WantedPart<'a>,
    face: &'a FaceIndex,
    cutter: &'a Cutter,
    bounds: [Interval; 2],
    /// `true` for a face that closes on itself: passes bent in a plane do not close.
    closed: bool,
    /// Mean length of a step by u, and by v \[mm\].
    rates: [f64; 2],
    costs: AdvanceCosts,
    widths: Option<StripWidthTable>,
}

impl<'a> LayoutChooser<'a> {
    /// Prepares the comparison; `None` for a face without extent.
    fn new(
        part: WantedPart<'a>,
        cutter: &'a Cutter,
        options: &CoverOptions,
        widths: Option<StripWidthTable>,
    ) -> Option<Self> {
        let face = part.face;
        let bounds = face.face().bounds();
        let periods = face.face().surface.periods();
        let closed = |k: usize| periods[k].is_some_and(|period| bounds[k].width() >= period);
        let closed = closed(0) || closed(1);
        let costs = AdvanceCosts::new(cutter, options);
        let mut chooser =
            Self { part, face, cutter, bounds, closed, rates: [1.0; 2], costs, widths };
        let places: Vec<[f64; 2]> = chooser.samples().collect();
        let mean = |pick: &dyn Fn(&[Vector3<f64>; 2]) -> f64| {
            let sum: f64 = places.iter().map(|uv| pick(&chooser.tangents(*uv))).sum();
            sum / places.len() as f64
        };
        let rates = [mean(&|t| t[0].norm()), mean(&|t| t[1].norm())];
        chooser.rates = rates;
        rates.iter().all(|rate| *rate > 0.0 && rate.is_finite()).then_some(chooser)
    }

    fn tangents(&self, [u, v]: [f64; 2]) -> [Vector3<f64>; 2] {
        let jet = self.face.face().surface.jet1(u, v);
        [jet.su, jet.sv]
    }

    /// Returns points spread over the box of the face.
    fn samples(&self) -> impl Iterator<Item = [f64; 2]> + use<'_> {
        let at = |k: usize, i: u32| {
            let Interval { low, high } = self.bounds[k];
            low + (high - low) * (f64::from(i) + 0.5) / f64::from(SAMPLES)
        };
        (0..SAMPLES).flat_map(move |i| (0..SAMPLES).map(move |j| [at(0, i), at(1, j)]))
    }

    /// Returns the straight frame with this index, turned by a share of half a turn, in mm.
    fn frame(&self, index: u32) -> BentChart {
        let (sin, cos) = math::sin_cos(PI * f64::from(index) / f64::from(FRAMES));
        // Divided by the mean rates, a step of 1 in x or y is about 1 mm on the face in any
        // direction.
        let [by_u, by_v] = self.rates;
        let axes = [[cos / by_u, sin / by_v], [-sin / by_u, cos / by_v]];
        let origin = self.bounds.map(|range| range.middle());
        let bend = ChartSpline::flat([[0.0, 1.0]; 2], INTERVALS);
        let mut bent = BentChart { origin, axes, bend };
        let [u, v] = self.bounds;
        let corners = [[u.low, v.low], [u.low, v.high], [u.high, v.low], [u.high, v.high]];
        let places = corners.map(|corner| bent.frame(corner));
        // Run-outs follow the spline a cutter's width beyond the face; across there are none.
        let reach = [0.0, 2.0 * self.cutter.radius()];
        bent.bend.ranges = [0, 1].map(|k| {
            let values = places.map(|place| place[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            [low - reach[k], high + reach[k]]
        });
        bent
    }

    /// Returns the passes along the directions of least curvature.
    fn curvature(&self) -> Vec<Chart> {
        let fits: Vec<(f64, BentChart)> =
            (0..FRAMES).into_par_iter().map(|i| self.fit(self.frame(i))).collect();
        let best = fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, bent)| Chart::bent(bent)).into_iter().collect()
    }

    /// Returns the step of least curvature towards the cutter, and the difference of the principal
    /// curvatures \[1/mm\].
    fn least_bent(&self, [u, v]: [f64; 2]) -> Option<([f64; 2], f64)> {
        let face = self.face.face();
        let jet = face.surface.jet2(u, v);
        let curvature = jet.curvature()?;
        // Seen from the other side the curvatures change sign, and with them the directions change
        // roles.
        let direction = if face.flip { curvature.max_direction } else { curvature.min_direction };
        let step = widths::along([jet.su, jet.sv], &direction)?;
        Some((step, curvature.max - curvature.min))
    }

    /// Bends the passes of a frame to the directions of least curvature. Returns them with their
    /// error: a mean square of sines, weighed by the difference of the principal curvatures.
    fn fit(&self, mut bent: BentChart) -> (f64, BentChart) {
        for _ in 0..ROUNDS {
            let mut stiff = STIFF;
            // Stiffer until no pass crosses its neighbour.
            for _ in 0..STIFFER {
                let bend = self.fitted(&bent, stiff);
                if bend.is_monotone() {
                    bent.bend = bend;
                    break;
                }
                stiff *= 10.0;
            }
        }
        let chart = Chart::bent(bent.clone());
        let (mut sum, mut weights) = (0.0, 0.0);
        for uv in self.samples() {
            let Some(([du, dv], weight)) = self.least_bent(uv) else { continue };
            let [su, sv] = self.tangents(uv);
            let [_, [pu, pv]] = chart.steps(chart.local(uv));
            // Angle between the direction of least curvature and the pass, on the face.
            let (wanted, pass) = (su * du + sv * dv, su * pu + sv * pv);
            let sine = wanted.cross(&pass).norm() / (wanted.norm() * pass.norm());
            if sine.is_finite() {
                sum += weight * sine * sine;
                weights += weight;
            }
        }
        (if weights > 0.0 { sum / weights } else { 0.0 }, bent)
    }

    /// Solves the least-squares problem for the slopes of the passes where they lie now.
    fn fitted(&self, bent: &BentChart, stiff: f64) -> ChartSpline {
        let chart = Chart::bent(bent.clone());
        let shape = bent.bend.coefficients.shape();
        let (count, index) = (shape.0 * shape.1, |i: usize, j: usize| i * shape.1 + j);
        let mut normal = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        let mut total = 0.0;
        for uv in self.samples() {
            let Some((step, weight)) = self.least_bent(uv) else { continue };
            // Wanted slope dx / dy of the pass in the frame; steep ones are left to other frames.
            let [dx, dy] = bent.frame([0, 1].map(|k| bent.origin[k] + step[k]));
            if dy.abs() * LEAN < dx.abs() || weight.is_nan() {
                continue;
            }
            let local = chart.local(uv);
            let (i, a, ..) = bent.bend.basis(0, local[0]);
            let (j, _, rates, _) = bent.bend.basis(1, local[1]);
            // Derivative of s by y as a linear form in the 16 coefficients of this cell.
            let row: Vec<(usize, f64)> = (0..4)
                .flat_map(|m| (0..4).map(move |n| (m, n)))
                .map(|(m, n)| (index(i + m, j + n), a[m] * rates[n]))
                .collect();
            for (p, x) in &row {
                // Normal equations of the weighted squares (form - dx / dy)^2.
                right[*p] += weight * x * dx / dy;
                for (q, y) in &row {
                    normal[(*p, *q)] += weight * x * y;
                }
            }
            total += weight;
        }
        self.stiffen(&mut normal, [shape.0, shape.1], stiff * total.max(f64::MIN_POSITIVE));
        let solution = normal.cholesky().map(|cholesky| cholesky.solve(&right));
        let mut bend = bent.bend.clone();
        match solution {
            Some(c) => {
                bend.coefficients = DMatrix::from_fn(shape.0, shape.1, |i, j| c[index(i, j)]);
            }
            None => bend.coefficients.fill(0.0),
        }
        bend
    }

    /// Adds squares of second differences, and a little of the coefficients themselves, which
    /// slopes along do not determine.
    fn stiffen(&self, normal: &mut DMatrix<f64>, [rows, columns]: [usize; 2], weight: f64) {
        let size = 2.0 * self.cutter.radius();
        // The stiffness is set by the cutter: bends over its diameter count alike on faces of any
        // size.
        let weight = weight / (size * size);
        let index = |i: usize, j: usize| i * columns + j;
        let mut add = |places: [usize; 3]| {
            for (p, x) in places.iter().zip([1.0, -2.0, 1.0]) {
                for (q, y) in places.iter().zip([1.0, -2.0, 1.0]) {
                    normal[(*p, *q)] += weight * x * y;
                }
            }
        };
        for i in 0..rows {
            for j in 0..columns {
                // (c_i - 2 c_{i+1} + c_{i+2})^2 in either direction.
                if i + 2 < rows {
                    add([index(i, j), index(i + 1, j), index(i + 2, j)]);
                }
                if j + 2 < columns {
                    add([index(i, j), index(i, j + 1), index(i, j + 2)]);
                }
            }
        }
        for p in 0..rows * columns {
            normal[(p, p)] += GROUND * weight;
        }
    }

    /// Returns the straight charts, the cheaper by estimate first.
    fn straight(&self) -> Vec<Chart> {
        self.promising([FeedDirection::V, FeedDirection::U].map(Chart::straight).into())
    }

    /// Returns the charts that may turn out best, the cheapest by estimate first.
    fn promising(&self, charts: Vec<Chart>) -> Vec<Chart> {
        let mut priced: Vec<(f64, Chart)> =
            charts.into_iter().map(|chart| (self.price(&chart), chart)).collect();
        // A stable sort keeps the order of equals.
        priced.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = priced.first().map_or(0.0, |chart| chart.0);
        let hope = if self.closed { CLOSED_HOPE } else { HOPE };
        priced.retain(|chart| chart.0 <= least * hope);
        priced.into_iter().map(|(_, chart)| chart).collect()
    }

    /// Returns the best charts by estimate: straight ones, oblique ones, those along the curvature,
    /// and bends.
    fn adaptive(&self) -> Vec<Chart> {
        let frames: Vec<BentChart> = (0..FRAMES).map(|i| self.frame(i)).collect();
        let fits: Vec<BentChart> =
            frames.par_iter().map(|frame| self.fit(frame.clone()).1).collect();
        let mut starts: Vec<PricedBend> = frames
            .par_iter()
            .chain(&fits)
            .map(|bent| PricedBend {
                price: self.price(&Chart::bent(bent.clone())),
                bent: bent.clone(),
            })
            .collect();
        starts.sort_by(|a, b| a.price.total_cmp(&b.price));
        starts.truncate(SEARCHED);
        let found: Vec<BentChart> =
            starts.into_par_iter().map(|start| self.search(start)).collect();
        // The frames along u and v are straight charts.
        let oblique = frames.into_iter().enumerate().filter(|(i, _)| i % 2 == 1).map(|one| one.1);
        let charts = [oblique.collect(), fits, found]
            .into_iter()
            .filter_map(|kind| self.best(kind))
            .chain([FeedDirection::V, FeedDirection::U].map(Chart::straight));
        let mut charts = self.promising(charts.collect());
        if self.widths.is_some() {
            charts.truncate(PLACED);
            return charts;
        }
        // Where all strips are alike, the estimate is exact but for obstacles. These run along the face's own parameters more
        // often than across them: beside obstacles bent passes break into many short ones, and where they leave much, straight
        // ones are tried as well.
        if self.part.without.is_some() && charts.iter().any(Chart::is_straight) {
            charts.retain(Chart::is_straight);
        }
        let straight = charts.iter().skip(1).find(|chart| chart.is_straight()).cloned();
        charts.truncate(1);
        charts.extend(straight.filter(|_| !charts[0].is_straight()));
        charts
    }

    /// Returns the bend with the least estimated cost.
    fn best(&self, bents: Vec<BentChart>) -> Option<Chart> {
        let charts = bents.into_par_iter().map(Chart::bent);
        let priced: Vec<(f64, Chart)> = charts.map(|chart| (self.price(&chart), chart)).collect();
        priced.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, chart)| chart)
    }

    /// Bends a chart by a few smooth forms, as long as that lowers the estimated cost.
    fn search(&self, start: PricedBend) -> BentChart {
        let PricedBend { mut price, mut bent } = start;
        let extents = bent.bend.ranges.map(|[low, high]| high - low);
        let extent = extents[0].min(extents[1]);
        for step in STEPS {
            for form in FORMS {
                for sign in [1.0, -1.0] {
                    let mut tried = bent.clone();
                    shift(&mut tried.bend.coefficients, form, sign * step * extent);
                    if !tried.bend.is_monotone() {
                        continue;
                    }
                    // Coordinate search over the forms; the first sign that lowers the estimate is
                    // kept.
                    let now = self.price(&Chart::bent(tried.clone()));
                    if now < price {
                        (price, bent) = (now, tried);
                        break;
                    }
                }
            }
        }
        bent
    }

    /// Estimates the cost of passes on a chart \[mm\].
    fn price(&self, chart: &Chart) -> f64 {
        let bounds = self.extent(chart);
        let [first, last] = bounds[0];
        let mut across = first;
        let mut price = 0.0;
        for _ in 0..PASSES {
            let EstimatedPass { parts, rate, segments } = self.parts(chart, across, bounds[1]);
            let advance = advance::advance(&parts, &self.costs);
            if parts.is_empty() || advance <= 0.0 {
                // No face here: go on by a hundredth.
                across += 0.01 * (last - first);
            } else {
                // A pass costs its full length, however little is left for it.
                price += advance::price(&parts, advance, &self.costs);
                // The tool is lifted over what is not to be finished.
                price += f64::from(segments.saturating_sub(1)) * self.costs.pass;
                across += advance / rate;
            }
            if across >= last {
                return price;
            }
        }
        f64::INFINITY
    }

    /// Returns the local box of the face.
    fn extent(&self, chart: &Chart) -> [[f64; 2]; 2] {
        let [u, v] = self.bounds;
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for i in 0..=SAMPLES {
            let share = f64::from(i) / f64::from(SAMPLES);
            let at = |range: Interval| range.at(share);
            for uv in [[u.low, at(v)], [u.high, at(v)], [at(u), v.low], [at(u), v.high]] {
                let local = chart.local(uv);
                for k in 0..2 {
                    bounds[k] = [bounds[k][0].min(local[k]), bounds[k][1].max(local[k])];
                }
            }
        }
        bounds
    }

    /// Estimates the pass at a place across.
    fn parts(&self, chart: &Chart, across: f64, [low, high]: [f64; 2]) -> EstimatedPass {
        let mut parts = Vec::new();
        let (mut rates, mut segments, mut last) = (0.0, 0, None);
        let piece = (high - low) / f64::from(SAMPLES);
        for i in 0..SAMPLES {
            let local: ChartPoint = [across, low + piece * (f64::from(i) + 0.5)];
            let uv = chart.uv(local);
            if !self.part.holds(uv) {
                continue;
            }
            let tangents = self.tangents(uv);
            let [over, way] =
                chart.steps(local).map(|[du, dv]| tangents[0] * du + tangents[1] * dv);
            // Distance to the next pass per unit across: the part of the step square to the pass.
            let rate = over.cross(&way).norm() / way.norm();
            let width = match &self.widths {
                Some(widths) => widths.width(uv, tangents, &way).unwrap_or(self.costs.narrow),
                None => self.costs.narrow,
            };
            if !(rate > 0.0 && width > 0.0) {
                continue;
            }
            rates += rate;
            segments += u32::from(last.is_none_or(|last| last + 1 < i));
            last = Some(i);
            parts.push(PassPart { length: piece * way.norm(), width: width / rate });
        }
        let rate = rates / parts.len().max(1) as f64;
        for part in &mut parts {
            // Widths are compared as parameters across, then given as lengths at the mean rate.
            part.width *= rate;
        }
        EstimatedPass { parts, rate, segments }
    }
}

/// A pass of an estimate.
struct EstimatedPass {
    /// Its parts over what is to be finished.
    parts: Vec<PassPart>,
    /// Mean length of a step across \[mm\].
    rate: f64,
    /// Segments that these parts make up.
    segments: u32,
}

/// Adds a form: powers of the coordinates across and along, each from -1 to 1.
fn shift(coefficients: &mut DMatrix<f64>, [m, n]: [i32; 2], by: f64) {
    let (rows, columns) = coefficients.shape();
    let place = |k: usize, count: usize| 2.0 * k as f64 / (count - 1).max(1) as f64 - 1.0;
    for i in 0..rows {
        for j in 0..columns {
            coefficients[(i, j)] += by * place(i, rows).powi(m) * place(j, columns).powi(n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::options::FinishTolerance;
    use crate::cutter::CutterSpec;
    use crate::surface::{Face, NurbsSurface, Surface};
    use nalgebra::Point3;

    /// A trough of 16 mm that winds sideways by 10 mm over 60 mm.
    fn winding_trough() -> FaceIndex {
        let net = [[-8.0, 8.0], [0.0, -8.0], [8.0, 8.0]].map(|[x, z]: [f64; 2]| {
            [[0.0, 0.0], [20.0, 30.0], [0.0, 60.0]].map(|[by, y]| Point3::new(x + by, y, z))
        });
        let knots = [0, 1].map(|_| vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        let net = net.map(|row| row.to_vec()).to_vec();
        let surface = NurbsSurface::new([2, 2], knots, net, None).unwrap();
        FaceIndex::new(Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()).unwrap()
    }

    #[test]
    fn where_bent_passes_come_first_straight_ones_are_tried_after_them() {
        let face = winding_trough();
        let cutter = Cutter::new(CutterSpec::of_radii(0.0, 6.0)).unwrap();
        let tolerance = FinishTolerance { excess: 0.02, gouge: 0.0 };
        let options = CoverOptions {
            feed_direction: FeedDirection::Adaptive,
            method: PlacementMethod::Inclined,
            ..CoverOptions::finishing(&cutter, tolerance)
        };
        let chosen = choose(WantedPart { face: &face, without: None }, &cutter, &options);
        let straight: Vec<bool> = chosen.charts.iter().map(Chart::is_straight).collect();
        assert_eq!(straight, [false, true]);
    }
}
