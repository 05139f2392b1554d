//! Which way passes should run.
//!
//! A chart is judged by laying passes on paper: their widths come from a table ([`StripWidthTable`]), each brings
//! the face on by what costs least (`split`), and what all of them cost is added up. For
//! [`FeedDirection::Curvature`] passes are bent to the directions of least curvature in the least-squares
//! sense; for [`FeedDirection::Adaptive`] bends are searched that cost least on paper, and the best of these are
//! placed in earnest, beside lines of constant u and v.

use crate::cover::layout::advance::{self, AdvanceCosts, PassPart};
use crate::cover::layout::chart::{BentChart, Chart, ChartSpline};
use crate::cover::layout::effort::WorkCounter;
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::widths::{self, StripWidthTable, TableFill};
use crate::cover::options::{CoverOptions, FeedDirection, PlacementMethod};
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Frames that passes are graphs over, over half a turn: none leans from its own by more than half the way
/// to the next.
const FRAMES: u32 = 4;

/// Intervals of the spline across and along. More follow what no tool can: passes a few cutters apart are alike.
const INTERVALS: [usize; 2] = [2, 3];

/// Rounds of a fit: the directions are taken where the passes of the round before lie.
const ROUNDS: u32 = 4;

/// Largest lean of a pass from its frame that is fitted.
const LEAN: f64 = 1.5;

/// Samples each way for a fit, along a pass on paper, and passes on paper at most.
const SAMPLES: u32 = 24;
const PASSES: u32 = 500;

/// Weight of a bend's second differences in a fit, and how often it is multiplied by ten until passes do not
/// cross.
const STIFF: f64 = 1e-3;
const STIFFER: u32 = 8;

/// Weight of the coefficients themselves, over that of second differences: far less, and enough to settle what
/// neither these nor slopes along tell.
const GROUND: f64 = 1e-3;

/// Steps of a search, as shares of the face's extent.
const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// Bends searched on paper, and ways placed in earnest.
const SEARCHED: usize = 3;
const PLACED: usize = 4;

/// What may cost this much more on paper than the best may still turn out better.
const HOPE: f64 = 1.5;

/// Forms that passes are bent by: powers of the place across and along. Those without the second would only
/// count passes differently.
const FORMS: [[i32; 2]; 8] = [[0, 1], [0, 2], [1, 1], [0, 3], [1, 2], [2, 1], [1, 3], [2, 2]];

/// Charts to place passes on, the most promising first, and the work it took to find them.
pub(crate) fn choose(face: &FaceIndex, cutter: &Cutter, options: &CoverOptions) -> ChosenLayouts {
    if let FeedDirection::U | FeedDirection::V = options.feed_direction {
        return ChosenLayouts { charts: vec![Chart::straight(options.feed_direction)], work: 0 };
    }
    let work = WorkCounter::default();
    let table = options.feed_direction == FeedDirection::Adaptive
        && options.method == PlacementMethod::Widest;
    let narrow = advance::ball_strip_width(cutter, options);
    let widths = table
        .then(|| StripWidthTable::new(face, cutter, options, &TableFill { narrow, work: &work }));
    let found =
        LayoutChooser::new(face, cutter, options, widths).map_or_else(Vec::new, |chooser| {
            if options.feed_direction == FeedDirection::Curvature {
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
    /// Work that the choice took.
    pub(crate) work: u64,
}

/// Bent passes, with their cost by estimate.
#[derive(Clone)]
struct PricedBend {
    price: f64,
    bent: BentChart,
}

/// A face to be judged.
struct LayoutChooser<'a> {
    face: &'a FaceIndex,
    cutter: &'a Cutter,
    bounds: [[f64; 2]; 2],
    /// Length of a step by u, and by v, on average \[mm\].
    rates: [f64; 2],
    costs: AdvanceCosts,
    widths: Option<StripWidthTable>,
}

impl<'a> LayoutChooser<'a> {
    /// `None` for a face that closes on itself: passes bent in a plane do not close.
    fn new(
        face: &'a FaceIndex,
        cutter: &'a Cutter,
        options: &CoverOptions,
        widths: Option<StripWidthTable>,
    ) -> Option<Self> {
        let bounds = face.face().bounds();
        let periods = face.face().surface.periods();
        let closed =
            |k: usize| periods[k].is_some_and(|period| bounds[k][1] - bounds[k][0] >= period);
        if closed(0) || closed(1) {
            return None;
        }
        let costs = AdvanceCosts::new(cutter, options);
        let mut chooser = Self { face, cutter, bounds, rates: [1.0; 2], costs, widths };
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

    /// Places over the box of the face.
    fn samples(&self) -> impl Iterator<Item = [f64; 2]> + use<'_> {
        let at = |k: usize, i: u32| {
            let [low, high] = self.bounds[k];
            low + (high - low) * (f64::from(i) + 0.5) / f64::from(SAMPLES)
        };
        (0..SAMPLES).flat_map(move |i| (0..SAMPLES).map(move |j| [at(0, i), at(1, j)]))
    }

    /// A straight frame turned by a share of half a turn, in mm.
    fn frame(&self, index: u32) -> BentChart {
        let (sin, cos) = (PI * f64::from(index) / f64::from(FRAMES)).sin_cos();
        let [by_u, by_v] = self.rates;
        let axes = [[cos / by_u, sin / by_v], [-sin / by_u, cos / by_v]];
        let origin = self.bounds.map(|[low, high]| 0.5 * (low + high));
        let bend = ChartSpline::flat([[0.0, 1.0]; 2], INTERVALS);
        let mut bent = BentChart { origin, axes, bend };
        let [u, v] = self.bounds;
        let corners = [[u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
        let places = corners.map(|corner| bent.frame(corner));
        let reach = [0.0, 2.0 * self.cutter.radius()];
        bent.bend.ranges = [0, 1].map(|k| {
            let values = places.map(|place| place[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            [low - reach[k], high + reach[k]]
        });
        bent
    }

    /// Passes along the directions of least curvature.
    fn curvature(&self) -> Vec<Chart> {
        let fits: Vec<(f64, BentChart)> =
            (0..FRAMES).into_par_iter().map(|i| self.fit(self.frame(i))).collect();
        let best = fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, bent)| Chart::bent(bent)).into_iter().collect()
    }

    /// Step of least curvature towards the cutter, and by how much it differs from the most \[1/mm\].
    fn least_bent(&self, [u, v]: [f64; 2]) -> Option<([f64; 2], f64)> {
        let face = self.face.face();
        let jet = face.surface.jet2(u, v);
        let curvature = jet.curvature()?;
        let direction = if face.flip { curvature.max_direction } else { curvature.min_direction };
        let step = widths::along([jet.su, jet.sv], &direction)?;
        Some((step, curvature.max - curvature.min))
    }

    /// The frame's passes bent to the directions of least curvature, and what they miss them by: a mean
    /// square of sines, weighed by how much the curvature differs by direction.
    fn fit(&self, mut bent: BentChart) -> (f64, BentChart) {
        for _ in 0..ROUNDS {
            let mut stiff = STIFF;
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
            let (wanted, pass) = (su * du + sv * dv, su * pu + sv * pv);
            let sine = wanted.cross(&pass).norm() / (wanted.norm() * pass.norm());
            if sine.is_finite() {
                sum += weight * sine * sine;
                weights += weight;
            }
        }
        (if weights > 0.0 { sum / weights } else { 0.0 }, bent)
    }

    /// Least squares for the slopes of passes where they lie now.
    fn fitted(&self, bent: &BentChart, stiff: f64) -> ChartSpline {
        let chart = Chart::bent(bent.clone());
        let shape = bent.bend.coefficients.shape();
        let (count, index) = (shape.0 * shape.1, |i: usize, j: usize| i * shape.1 + j);
        let mut normal = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        let mut total = 0.0;
        for uv in self.samples() {
            let Some((step, weight)) = self.least_bent(uv) else { continue };
            let [dx, dy] = bent.frame([0, 1].map(|k| bent.origin[k] + step[k]));
            if dy.abs() * LEAN < dx.abs() || weight.is_nan() {
                continue;
            }
            let local = chart.local(uv);
            let (i, a, ..) = bent.bend.basis(0, local[0]);
            let (j, _, rates, _) = bent.bend.basis(1, local[1]);
            let row: Vec<(usize, f64)> = (0..4)
                .flat_map(|m| (0..4).map(move |n| (m, n)))
                .map(|(m, n)| (index(i + m, j + n), a[m] * rates[n]))
                .collect();
            for (p, x) in &row {
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

    /// Adds squares of second differences, and a little of the coefficients themselves, which slopes along do
    /// not tell.
    fn stiffen(&self, normal: &mut DMatrix<f64>, [rows, columns]: [usize; 2], weight: f64) {
        let size = 2.0 * self.cutter.radius();
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

    /// The best ways found on paper: straight ones, oblique ones, those along the curvature, and bends.
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
        let mut charts: Vec<(f64, Chart)> = [oblique.collect(), fits, found]
            .into_iter()
            .filter_map(|kind| self.best(kind))
            .chain([FeedDirection::V, FeedDirection::U].map(Chart::straight))
            .map(|chart| (self.price(&chart), chart))
            .collect();
        // A stable sort.
        charts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = charts.first().map_or(0.0, |chart| chart.0);
        charts.retain(|chart| chart.0 <= least * HOPE);
        // Where all strips are alike, paper tells it all.
        charts.truncate(if self.widths.is_some() { PLACED } else { 1 });
        charts.into_iter().map(|(_, chart)| chart).collect()
    }

    /// The bend that costs least on paper.
    fn best(&self, bents: Vec<BentChart>) -> Option<Chart> {
        let charts = bents.into_par_iter().map(Chart::bent);
        let priced: Vec<(f64, Chart)> = charts.map(|chart| (self.price(&chart), chart)).collect();
        priced.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, chart)| chart)
    }

    /// Bends a chart by a few smooth forms, as long as that saves something on paper.
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

    /// What passes on a chart cost on paper \[mm\].
    fn price(&self, chart: &Chart) -> f64 {
        let bounds = self.extent(chart);
        let [first, last] = bounds[0];
        let mut across = first;
        let mut price = 0.0;
        for _ in 0..PASSES {
            let (parts, rate) = self.parts(chart, across, bounds[1]);
            let advance = advance::advance(&parts, &self.costs);
            if parts.is_empty() || advance <= 0.0 {
                // No face here: on by a hundredth.
                across += 0.01 * (last - first);
            } else {
                // A pass is a pass, however little is left for it.
                price += advance::price(&parts, advance, &self.costs);
                across += advance / rate;
            }
            if across >= last {
                return price;
            }
        }
        f64::INFINITY
    }

    /// Local box of the face.
    fn extent(&self, chart: &Chart) -> [[f64; 2]; 2] {
        let [u, v] = self.bounds;
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for i in 0..=SAMPLES {
            let share = f64::from(i) / f64::from(SAMPLES);
            let at = |[low, high]: [f64; 2]| low + share * (high - low);
            for uv in [[u[0], at(v)], [u[1], at(v)], [at(u), v[0]], [at(u), v[1]]] {
                let local = chart.local(uv);
                for k in 0..2 {
                    bounds[k] = [bounds[k][0].min(local[k]), bounds[k][1].max(local[k])];
                }
            }
        }
        bounds
    }

    /// A pass on paper, where it lies on the face, and the length of a step across.
    fn parts(&self, chart: &Chart, across: f64, [low, high]: [f64; 2]) -> (Vec<PassPart>, f64) {
        let mut parts = Vec::new();
        let mut rates = 0.0;
        let piece = (high - low) / f64::from(SAMPLES);
        for i in 0..SAMPLES {
            let local: ChartPoint = [across, low + piece * (f64::from(i) + 0.5)];
            let uv = chart.uv(local);
            if !self.face.face().contains(uv[0], uv[1]) {
                continue;
            }
            let tangents = self.tangents(uv);
            let [over, way] =
                chart.steps(local).map(|[du, dv]| tangents[0] * du + tangents[1] * dv);
            let rate = over.cross(&way).norm() / way.norm();
            let width = match &self.widths {
                Some(widths) => widths.width(uv, tangents, &way).unwrap_or(self.costs.narrow),
                None => self.costs.narrow,
            };
            if !(rate > 0.0 && width > 0.0) {
                continue;
            }
            rates += rate;
            parts.push(PassPart { length: piece * way.norm(), width: width / rate });
        }
        let rate = rates / parts.len().max(1) as f64;
        for part in &mut parts {
            part.width *= rate;
        }
        (parts, rate)
    }
}

/// Adds a form: powers of the place across and along, each from -1 to 1.
fn shift(coefficients: &mut DMatrix<f64>, [m, n]: [i32; 2], by: f64) {
    let (rows, columns) = coefficients.shape();
    let place = |k: usize, count: usize| 2.0 * k as f64 / (count - 1).max(1) as f64 - 1.0;
    for i in 0..rows {
        for j in 0..columns {
            coefficients[(i, j)] += by * place(i, rows).powi(m) * place(j, columns).powi(n);
        }
    }
}
