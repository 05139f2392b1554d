//! Measures heights over faces, and bounds them between the grid points.

use super::bounds::faces::{self, BoundRequest, FoundBounds};
use super::bounds::margin::MarginRule;
use super::chunks::{MeasureScope, MeasuredTools, MotionChunks, MoveKind};
use super::grid::FaceGrid;
use super::map;
use super::map::{FacePoints, GridSamples, MeasuredMap};
use super::tool_length;
use crate::cutter::Cutter;
use crate::math;
use crate::surface::Face;
use crate::types::{Cancelled, Progress, Stage, UncutRegion};
use crate::verify::broken_regions::{self, BrokenTolerance};
use crate::verify::error::VerifyError;
use crate::verify::options::{BoundMargins, BoundOptions, CheckOptions};
use crate::verify::replay::segments::Run;
use crate::verify::report::{Audit, Deviation, ExtremeHeight, FaceMap, HeightBounds, Sensitivity};
use std::f64::consts::PI;

/// Faces, cutters and declared rest material of a measurement.
#[derive(Clone, Copy)]
pub(crate) struct MeasureSubject<'a> {
    pub(crate) faces: &'a [Face],
    /// Cutters in the order of the tool table.
    pub(crate) cutters: &'a [&'a Cutter],
    pub(crate) rest: &'a [UncutRegion],
}

/// Steps of the progress bar.
const STEPS: f64 = 1000.0;

/// Result of a measurement.
pub(crate) struct MeasuredHeights {
    pub(crate) maps: Vec<FaceMap>,
    pub(crate) deviation: Deviation,
    /// Heights beyond a tolerance that are not in the maps: found between their points, or of rapids.
    pub(crate) between: Vec<ExtremeHeight>,
}

/// Measures the heights over all faces, including what rapids gouge in whichever way they are run.
pub(crate) fn measure(
    run: &Run<'_>,
    subject: &MeasureSubject<'_>,
    options: &CheckOptions,
    progress: &dyn Progress,
) -> Result<MeasuredHeights, VerifyError> {
    let tools = MeasuredTools { cutters: subject.cutters, options };
    let cuts = MotionChunks::new(run, tools)?;
    // The points are the same for all motion: cuts search farthest.
    let (points, samples) = points(subject.faces, options, &cuts.scope)?;
    let task = MeasureTask { subject, points: &points, options, progress };
    let mut heights = task.cuts(&cuts, samples)?;
    for moves in [MoveKind::Rapids, MoveKind::DogLegs] {
        if let Some(chunks) = MotionChunks::rapids(run, tools, moves)? {
            task.rapids(&chunks, &mut heights)?;
        }
    }
    // At the end of the search range a depth is only a lower bound.
    if let Some(lowest) = &mut heights.deviation.lowest {
        lowest.or_deeper = lowest.height <= -options.reach;
    }
    Ok(heights)
}

/// Returns the points of the faces, and their samples without heights.
fn points<'a>(
    faces: &'a [Face],
    options: &CheckOptions,
    scope: &MeasureScope,
) -> Result<(Vec<FacePoints<'a>>, Vec<GridSamples>), VerifyError> {
    let of = |face| FacePoints::new(face, FaceGrid::over(face, options)?, scope);
    let all = faces.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    Ok(all.into_iter().unzip())
}

/// Measurement of one motion: subject, points of its faces, options and progress.
struct MeasureTask<'a> {
    subject: &'a MeasureSubject<'a>,
    points: &'a [FacePoints<'a>],
    options: &'a CheckOptions,
    progress: &'a dyn Progress,
}

impl MeasureTask<'_> {
    /// Measures the heights that the cutting moves leave.
    fn cuts(
        &self,
        chunks: &MotionChunks<'_>,
        samples: Vec<GridSamples>,
    ) -> Result<MeasuredHeights, VerifyError> {
        let Self { subject, points, options, .. } = *self;
        // Step 1: measure the grid points.
        let mut advance = |share: f64| self.advance(share);
        let mut measured = map::maps(chunks, points, samples, &mut advance)?;
        for measured in &mut measured {
            measured.map.note(subject.rest);
        }
        // Step 2: summarize them.
        let mut deviation = Deviation::of(&measured.iter().map(|measured| &measured.map));
        deviation.sensitivity = sensitivity(subject.faces, &measured);
        deviation.higher = tool_length::length(subject.faces, &measured, options);
        // Step 3: bound the heights between them.
        let between = match &options.bounds {
            Some(promise) => self.promised(chunks, &measured, promise, &mut deviation)?,
            None => Vec::new(),
        };
        let maps = measured.into_iter().map(|measured| measured.map).collect();
        Ok(MeasuredHeights { maps, deviation, between })
    }

    /// Reports the share done.
    fn advance(&self, share: f64) -> Result<(), Cancelled> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 1")]
        self.progress.step(Stage::Verify, (STEPS * share) as u64, STEPS as u64)
    }

    /// Adds the gouges of rapids, and finds points that only rapids finish. The material left over the faces stays as
    /// measured without them.
    fn rapids(
        &self,
        chunks: &MotionChunks<'_>,
        heights: &mut MeasuredHeights,
    ) -> Result<(), VerifyError> {
        let Self { points, options, .. } = *self;
        let MeasuredHeights { maps, deviation, between } = heights;
        // There are few rapids, so progress stays at its end; the run may still be cancelled.
        let mut go_on = |_: f64| self.advance(1.0);
        let samples = maps.iter().map(map::unmeasured).collect();
        let measured = map::maps(chunks, points, samples, &mut go_on)?;
        let mut other = Deviation::of(&measured.iter().map(|measured| &measured.map));
        let dog_leg = chunks.scope.moves == MoveKind::DogLegs;
        other.lowest = [deviation.lowest, other.lowest]
            .into_iter()
            .flatten()
            .min_by(|a, b| a.height.total_cmp(&b.height));
        let mut found = Vec::new();
        if let Some(promise) = options.bounds.filter(|_| deviation.bounds.is_some()) {
            // Rapids leave nothing that counts as finished, so only their gouges are bounded.
            let promise = BoundOptions { excess: false, ..promise };
            found = self.promised(chunks, &measured, &promise, &mut other)?;
        }
        // The map of the cuts takes no gouge where nothing cuts, so their regions are kept.
        let rapids = measured.iter().map(|measured| &measured.map);
        between.extend(broken_regions::broken(BrokenTolerance::Gouge, rapids, &found, options));
        deviation.lowest = other.lowest;
        deviation.bounds = deviation.bounds.zip(other.bounds).map(|(bounds, other)| HeightBounds {
            // The bound over all motion is the larger of both; areas without proof may differ, so they add up.
            gouge: bounds.gouge.max(other.gouge),
            open: bounds.open + other.open,
            ..bounds
        });
        // The same points have no normal in both measurements.
        deviation.unmeasured = deviation.unmeasured.max(other.unmeasured);
        for (map, MeasuredMap { map: other, .. }) in maps.iter_mut().zip(measured) {
            // Dog legs are the same rapids run otherwise: those with all axes together decide what only a rapid finishes.
            if !dog_leg {
                deviation.rapid =
                    deviation.rapid.or_else(|| map.finished_by(&other, options.total));
            }
            map.deepen(&other);
        }
        deviation.histogram = Deviation::of(&maps.iter()).histogram;
        Ok(())
    }

    /// Bounds the heights between the points, and records worse points that this finds; returns the worst of each tile that
    /// breaks a tolerance.
    fn promised(
        &self,
        chunks: &MotionChunks<'_>,
        measured: &[MeasuredMap<'_>],
        promise: &BoundOptions,
        deviation: &mut Deviation,
    ) -> Result<Vec<ExtremeHeight>, VerifyError> {
        let Self { subject, options, .. } = *self;
        let extremes = [&deviation.lowest, &deviation.highest]
            .map(|extreme| extreme.as_ref().map(|extreme| extreme.height));
        if extremes[0].is_some_and(|lowest| lowest <= -options.reach) {
            // Deeper than the search goes: no bound is possible.
            return Ok(Vec::new());
        }
        let BoundMargins { gouge, excess } = promise.margin;
        let exact = options.ray_tolerance;
        let rules = [(gouge, options.gouge), (excess, options.total)]
            .map(|(margin, tolerance)| MarginRule { margin, tolerance, exact });
        let request = BoundRequest { rules, excess: promise.excess, extremes };
        let FoundBounds { bounds, worst: [lowest, highest], broken } =
            faces::bounds(chunks, subject.faces, measured, &request)?;
        deviation.bounds = Some(bounds);
        deviation.lowest = lowest.or(deviation.lowest);
        deviation.highest = highest.or(deviation.highest);
        Ok(broken)
    }
}

/// Stride of the points that are evaluated for sensitivity.
const STRIDE: usize = 7;

/// Returns the effect of tool errors at the points where the tool cuts.
fn sensitivity(faces: &[Face], measured: &[MeasuredMap]) -> Sensitivity {
    let mut worst = Sensitivity { length: 0.0, radius: 0.0, pivot: None };
    for (face, MeasuredMap { map, deciding, .. }) in faces.iter().zip(measured) {
        for (sample, by) in map.samples.iter().zip(deciding).step_by(STRIDE) {
            let normal = sample.as_ref().and_then(|s| face.normal(s.uv.u, s.uv.v));
            let (Some(by), Some(normal)) = (by, normal) else { continue };
            // The tool touches with its outward normal against that of the surface. Its tip stays where it is measured, so
            // a larger corner radius rises with its centre.
            let along = by.pose.axis.dot(&normal);
            worst.length = worst.length.max(along.abs());
            worst.radius = worst.radius.max(1.0 - along);
        }
    }
    worst
}

/// Returns the largest displacement of the tool in the workpiece, per error of a rotary axis position.
///
/// At angle `q` the point that was set at zero is displaced by `2 sin(q / 2)` times the error.
pub(crate) fn pivot(audit: &Audit) -> f64 {
    // Chord of the angle q on a circle of radius 1: 2 |sin(q / 2)|, at most 2.
    let chord = |[low, high]: [f64; 2]| {
        // Half a turn, or an odd number of them, is farthest.
        let half_turns = |q: f64| ((q - PI) / (2.0 * PI)).floor();
        if half_turns(low) < half_turns(high) {
            return 2.0;
        }
        [low, high].map(|q| 2.0 * math::sin(0.5 * q).abs()).into_iter().fold(0.0, f64::max)
    };
    audit.axes.iter().skip(3).map(|axis| chord(axis.range.into())).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::CutterSpec;
    use crate::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
    use crate::surface::{NurbsSurface, Surface};
    use crate::types::{Silent, ToolPose};
    use crate::verify::{CheckInput, DeviationTolerance, Finding};
    use nalgebra::{Point3, Rotation3, Vector3};

    fn face() -> Face {
        let row = |i: u8| {
            let point = |j: u8| {
                let [x, y] = [f64::from(i) - 1.0, f64::from(j) - 1.0];
                Point3::new(6.0 * x, 6.0 * y, 0.5 * x * x - 0.3 * y * y)
            };
            (0..3).map(point).collect()
        };
        let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let net = (0..3).map(row).collect();
        let surface = NurbsSurface::new([2, 2], [knots(), knots()], net, None).unwrap();
        Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
    }

    /// Rows of a bull nose over the face; one location is too deep.
    fn rows(face: &Face) -> ClFile {
        let record = |k: u32| {
            let [row, step] = [k / 41, k % 41].map(f64::from);
            let normal = face.normal(step / 40.0, row / 20.0).unwrap();
            let lean =
                Rotation3::from_axis_angle(&Vector3::y_axis(), 0.1 + 0.01 * (step * 0.3).sin());
            let axis = lean * normal;
            let out = (normal.dot(&axis) * axis.into_inner() - normal.into_inner()).normalize();
            let deeper = if k == 437 { -0.01 } else { 0.0 };
            let tube = face.point(step / 40.0, row / 20.0) + normal.into_inner() * (1.0 + deeper);
            let tip = tube - out * 2.0 - axis.into_inner();
            let pose = ToolPose { tip, axis };
            ClRecord { line: k + 1, pose, motion: ClMotion::Feed(10.0), way: ClPath::Straight }
        };
        let records = (0..41 * 21).map(record).collect();
        ClFile { records, ..ClFile::default() }
    }

    /// The findings do not depend on how many moves are measured together, up to the tolerance of the search.
    #[test]
    fn a_program_in_chunks_leaves_what_it_leaves_as_a_whole() {
        let face = face();
        let file = rows(&face);
        let spec = CutterSpec { length: 20.0, ..CutterSpec::of_radii(2.0, 1.0) };
        let cutter = Cutter::new(spec).unwrap();
        let promise = Some(BoundOptions::within(BoundMargins::both(1e-3)));
        let options = CheckOptions {
            reach: 0.5,
            ray_tolerance: 1e-4,
            most_points: 10_000,
            bounds: promise,
            ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.05, gouge: 2e-3 }, 0.4)
        };
        let input = CheckInput::locations(&file, &cutter);
        let run = input.run(None, 1e-5).unwrap();
        let faces = std::slice::from_ref(&face);
        let subject = MeasureSubject { faces, cutters: &[&cutter], rest: &[] };
        let measure = |size: usize| {
            let tools = MeasuredTools { cutters: &[&cutter], options: &options };
            let chunks = MotionChunks::of(&run, tools, size).unwrap();
            let (points, samples) = points(subject.faces, &options, &chunks.scope).unwrap();
            let (subject, options) = (&subject, &options);
            let task = MeasureTask { subject, points: &points, options, progress: &Silent };
            task.cuts(&chunks, samples).unwrap()
        };
        let whole = measure(100_000);
        let MeasuredHeights { maps, deviation, .. } = &whole;
        let findings = crate::verify::findings::broken_tolerances(&whole, &options);
        assert!(matches!(findings[..], [Finding::Gouge(_)]), "{findings:?}");
        for size in [300, 431] {
            let parts = measure(size);
            let MeasuredHeights { maps: others, deviation: other, .. } = &parts;
            for (a, b) in maps[0].samples.iter().zip(&others[0].samples) {
                let [a, b] = [a, b].map(|sample| sample.unwrap().height.unwrap());
                assert!((a - b).abs() <= 2.0 * options.ray_tolerance, "{a} {b}");
            }
            let [a, b] = [deviation, other].map(|deviation| deviation.bounds.unwrap());
            let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * options.ray_tolerance;
            assert!(
                near(a.gouge, b.gouge) && near(a.excess.unwrap(), b.excess.unwrap()),
                "{a:?} {b:?}"
            );
            assert!(a.open == 0.0 && b.open == 0.0, "{a:?} {b:?}");
            let found = crate::verify::findings::broken_tolerances(&parts, &options);
            let [Finding::Gouge(a), Finding::Gouge(b)] = [&findings[0], &found[0]] else {
                panic!("{found:?}")
            };
            assert_eq!(a.line, b.line);
        }
    }
}
