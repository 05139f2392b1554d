//! Further readings that separate deviations.

use super::candidates::{OTHER_LENGTHS, OTHER_PLACES, SphereTarget, over_travel, reading};
use super::equations::NormalEquations;
use super::fit::scale;
use super::model::{ChainModel, DeviatedChain, Deviations};
use super::reading::SphereReading;
use super::report::CalibrationReport;
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math;
use nalgebra::{Point3, Vector3};

/// Most readings that are named.
const MOST: usize = 8;

/// Most rotary positions at which a second sphere is read.
const POSITIONS_OF_SECOND: usize = 12;

/// Readings to take, and the combinations that they fix.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FurtherReading {
    /// Readings; several only for a second sphere, which is read at the positions of the first.
    pub readings: Vec<SphereReading>,
    /// Place of a second sphere beside the first \[mm\], workpiece frame.
    pub second_sphere: Option<Vector3<f64>>,
    /// Tool longer than that of the first reading by this \[mm\]; shorter if negative.
    pub longer: f64,
    /// Number of combinations that are fixed then and were not before.
    pub fixes: usize,
}

/// Names readings that fix what `readings` leave open, each the best after those before it.
///
/// Positions with the same sphere and tool come first, then another tool length, then a second sphere. Empty if
/// nothing is open, or if no such reading helps. `weak` is that of the calibration options \[mm\].
pub fn further_readings(
    readings: &[SphereReading],
    report: &CalibrationReport,
    weak: f64,
) -> Vec<FurtherReading> {
    let Some(first) = readings.first() else { return Vec::new() };
    let mut search = Search::new(readings, report, weak);
    let mut found = Vec::new();
    while found.len() < MOST && search.open > 0 {
        let Some(next) = search.best(first, report) else { break };
        search.take(&next.readings);
        found.push(next);
    }
    found
}

struct Search {
    chain: DeviatedChain,
    scale: Deviations,
    least: f64,
    spheres: Vec<Point3<f64>>,
    taken: Vec<SphereReading>,
    open: usize,
}

impl Search {
    fn new(readings: &[SphereReading], report: &CalibrationReport, weak: f64) -> Self {
        let model = ChainModel::new(&report.machine);
        let mut search = Self {
            chain: model.at(&Deviations::zeros()),
            scale: scale(&model, readings),
            least: (report.noise / weak).powi(2),
            spheres: report.spheres.clone(),
            taken: readings.to_vec(),
            open: 0,
        };
        search.open = search.judged(&[]).0;
        search
    }

    fn take(&mut self, readings: &[SphereReading]) {
        self.taken.extend_from_slice(readings);
        self.open = self.judged(&[]).0;
    }

    /// Returns the combinations that stay open with these readings as well, and how well the others are fixed.
    fn judged(&self, more: &[SphereReading]) -> (usize, f64) {
        let spheres = self.taken.iter().chain(more).map(|one| one.sphere + 1).max().unwrap_or(0);
        let mut equations = NormalEquations::new(self.scale, spheres);
        for reading in self.taken.iter().chain(more) {
            let jet = self.chain.tip(&reading.q, reading.tool_length);
            // A second sphere is where its readings find it.
            let center = self.spheres.get(reading.sphere).map_or(jet.tip, |center| center.coords);
            equations.add(reading, &jet, &center);
        }
        let values = equations.reduced().eigen.eigenvalues;
        let open = values.iter().filter(|value| **value < self.least).count();
        (open, values.iter().map(|value| math::ln(value.max(self.least))).sum())
    }

    fn best(&self, first: &SphereReading, report: &CalibrationReport) -> Option<FurtherReading> {
        let center = report.spheres.get(first.sphere)?.coords;
        let target = SphereTarget { sphere: first.sphere, center, tool_length: first.tool_length };
        self.best_of(positions(report, target, 0.0))
            .or_else(|| {
                let longer = |by| {
                    let tool_length = first.tool_length + by;
                    positions(report, SphereTarget { tool_length, ..target }, by)
                };
                self.best_of(OTHER_LENGTHS.into_iter().flat_map(longer).collect())
            })
            .or_else(|| self.best_of(self.second_spheres(report, target)))
    }

    /// Returns the readings of a second sphere at the rotary positions that were read.
    fn second_spheres(
        &self,
        report: &CalibrationReport,
        target: SphereTarget,
    ) -> Vec<FurtherReading> {
        let mut rotary: Vec<[f64; 2]> = Vec::new();
        for one in &self.taken {
            let pair = [one.q[FIRST_ROTARY], one.q[SECOND_ROTARY]];
            if rotary.len() < POSITIONS_OF_SECOND && !rotary.contains(&pair) {
                rotary.push(pair);
            }
        }
        let beside = |by: [f64; 3]| {
            let by = Vector3::from(by);
            let sphere = report.spheres.len();
            let target = SphereTarget { sphere, center: target.center + by, ..target };
            let reached = rotary.iter().filter_map(|pair| reading(&report.machine, &target, *pair));
            FurtherReading {
                readings: reached.collect(),
                second_sphere: Some(by),
                longer: 0.0,
                fixes: 0,
            }
        };
        OTHER_PLACES.into_iter().map(beside).collect()
    }

    /// Returns the candidate that leaves the fewest combinations open, and fixes the rest best.
    fn best_of(&self, candidates: Vec<FurtherReading>) -> Option<FurtherReading> {
        let judged = candidates.into_iter().map(|one| {
            let (open, quality) = self.judged(&one.readings);
            (FurtherReading { fixes: self.open.saturating_sub(open), ..one }, quality)
        });
        let best = judged
            .filter(|(one, _)| one.fixes > 0)
            .max_by(|(a, p), (b, q)| a.fixes.cmp(&b.fixes).then(p.total_cmp(q)));
        best.map(|(one, _)| one)
    }
}

/// Returns readings of a sphere at rotary positions over the travel.
fn positions(report: &CalibrationReport, target: SphereTarget, longer: f64) -> Vec<FurtherReading> {
    let one =
        |reading| FurtherReading { readings: vec![reading], second_sphere: None, longer, fixes: 0 };
    over_travel(&report.machine, &target).into_iter().map(one).collect()
}
