//! Simulates material removal, and finds collisions with stock.

use super::super::error::VerifyError;
use super::super::input::CheckInput;
use super::super::options::CHORD_SHARE;
use super::between_rays::boxes::{self, CloseBox};
use super::between_rays::inspect::{self, BoxFinding};
use super::broad_phase;
use super::broad_phase::MovingPart;
use super::build::solid::Solid;
use super::clip::batch;
use super::clip::batch::{ClipBatch, ClipFindings};
use super::collision::{Collision, CollisionKind};
use super::material::Stock;
use super::moving_tools::MovingTools;
use crate::cutter::Cutter;
use crate::types::{Progress, Stage};
use crate::verify::line_stats::{LineCount, LineHistory, LineStatistics};
use crate::verify::replay::segment::Segment;
use crate::verify::replay::segments::Run;
use crate::verify::swept::mesh::ClosedMesh;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Result of running a program through stock.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StockReport {
    /// Volume removed \[mm³\].
    pub removed: f64,
    /// Volume remaining \[mm³\].
    pub left: f64,
    /// Colliding lines in order, the worst of each kind, with the deepest point of each. Material that one line has run
    /// through is removed, so the next line reports only its own collisions.
    pub collisions: Vec<Collision>,
    /// Number of lines of each kind.
    pub lines: Vec<(CollisionKind, LineCount)>,
    /// Deepest undecided collision of shank, holder or rapid move between rays, if the search met its limit.
    pub undecided: Option<UndecidedCollision>,
}

/// Possible collision between rays that could not be decided.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct UndecidedCollision {
    /// Kind of the collision.
    pub kind: CollisionKind,
    /// Line of the program.
    pub line: u32,
    /// Upper bound on its depth \[mm\].
    pub depth: f64,
}

impl StockReport {
    /// Returns the number of colliding lines, each counted once per kind.
    pub fn count(&self) -> usize {
        self.lines.iter().map(|(_, lines)| lines.count).sum()
    }
}

/// Accuracy and extent of a simulation. Begin with [`StockOptions::within`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StockOptions {
    /// Nothing farther than this outside the swept tool is removed, and nothing deeper than this inside it remains on a
    /// ray \[mm\].
    pub tolerance: f64,
    /// Most lines reported of each kind of collision: the worst.
    pub worst: usize,
}

impl StockOptions {
    /// Cuts to that accuracy \[mm\], and reports the worst hundred lines of each kind of collision.
    #[must_use]
    pub const fn within(tolerance: f64) -> Self {
        Self { tolerance, worst: 100 }
    }
}

/// Moves per batch: enough for threads to share, few enough to keep in memory.
pub(super) const BATCH: usize = 256;

/// Runs a program through stock. Rapid moves run both with all axes together and with each axis at its own speed.
///
/// Cutting moves are judged on the rays. Shank, holder and rapid moves are also checked between the rays, within two ray
/// spacings of a ray. Between the rays of stock that was cut before, nothing is known.
///
/// # Example
///
/// A slot 6 mm wide and 1 mm deep through a block 20 mm long:
///
/// ```
/// use nalgebra::Point3;
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::nc::read::ClText;
/// use trunnion::types::Silent;
/// use trunnion::verify::{CheckInput, Solid, Stock, StockOptions, simulate};
///
/// let cutter = Cutter::new(CutterSpec { length: 50.0, ..CutterSpec::flat(6.0) })?;
/// let text = "FEDRAT/600,MMPM\nGOTO/-5,0,-1,0,0,1\nGOTO/25,0,-1,0,0,1\nFINI\n";
/// let locations = ClText::new(text.to_owned(), 20)?;
/// let [low, high] = [Point3::new(0.0, -5.0, -4.0), Point3::new(20.0, 5.0, 0.0)];
/// let mut stock = Stock::new(&Solid::Box { low, high }, 0.2, 100_000)?;
///
/// let options = StockOptions::within(1e-3);
/// let input = CheckInput::locations(&locations, &cutter);
/// let report = simulate(&input, &mut stock, &options, &Silent)?;
/// assert!((report.removed - 120.0).abs() < 1.0); // mm³
/// assert!(report.collisions.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`VerifyError`].
pub fn simulate(
    input: &CheckInput<'_>,
    stock: &mut Stock,
    cutting: &StockOptions,
    progress: &dyn Progress,
) -> Result<StockReport, VerifyError> {
    let controls = input.controls()?;
    let run = input.run(controls.as_ref(), CHORD_SHARE * cutting.tolerance)?;
    let cutters = input.cutters();
    StockCutter::new(stock, &cutters, cutting)?.run(&run, progress)
}

/// Clips stock by a batch of bodies, and returns all that they met.
pub(super) fn clip_by(stock: &mut Stock, parts: &[MovingPart], tolerance: f64) -> ClipFindings {
    let lattice = stock.lattice;
    let mut found = ClipFindings::default();
    // The three families are independent: each is clipped by all moves.
    for family in &mut stock.families {
        let near = broad_phase::by_tile(parts, &lattice, family);
        let work = ClipBatch::new(lattice, family, parts, tolerance);
        let tiles = family.tiles.par_iter_mut().zip(near.par_iter());
        let all: Vec<ClipFindings> = tiles.map(|(tile, near)| work.cut(tile, near)).collect();
        for findings in all {
            found.hits.extend(findings.hits);
            found.close.extend(findings.close);
        }
    }
    found
}

/// Stock being cut.
pub(super) struct StockCutter<'a> {
    stock: &'a mut Stock,
    tools: MovingTools,
    worst: usize,
    found: BTreeMap<CollisionKind, LineStatistics<Collision>>,
    /// Boxes to inspect between rays, and the original solid; `None` if it is unknown.
    close: Vec<CloseBox>,
    uncut: Option<Arc<Solid>>,
    /// Its triangles, once needed.
    shell: Option<ClosedMesh>,
    undecided: Option<UndecidedCollision>,
}

/// Most boxes collected before they are inspected.
const MOST_CLOSE: usize = 50_000;
/// Allowance of the prism that replaces a cylinder, as a share of the least depth reported between rays.
const PRISM: f64 = 0.1;

impl<'a> StockCutter<'a> {
    pub(super) fn new(
        stock: &'a mut Stock,
        cutters: &[&Cutter],
        cutting: &StockOptions,
    ) -> Result<Self, VerifyError> {
        let StockOptions { tolerance, worst } = *cutting;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let (name, must) = ("stock tolerance", "a length above 0");
            return Err(VerifyError::Option { name, value: tolerance, must });
        }
        // Bodies that must not touch material come close to it at this distance from a ray.
        let margin = batch::margin(&stock.lattice);
        let tools = MovingTools::new(cutters, tolerance, margin);
        // Stock that was cut has no known surface between its rays any more.
        let uncut = stock.uncut.take();
        let (found, close) = (BTreeMap::new(), Vec::new());
        Ok(Self { stock, tools, worst, found, close, uncut, shell: None, undecided: None })
    }

    fn run(&mut self, run: &Run<'_>, progress: &dyn Progress) -> Result<StockReport, VerifyError> {
        let (mut segments, steps) = (run.segments(), run.steps());
        let before = self.stock.volume();
        let (mut done, mut number) = (0, 0);
        loop {
            let mut parts = Vec::new();
            let mut count = 0;
            for segment in segments.by_ref().take(BATCH) {
                self.tools.parts(&run.mover, &segment?, number + parts.len(), &mut parts)?;
                count += 1;
            }
            if count == 0 {
                break;
            }
            self.cut(&parts);
            if self.close.len() > MOST_CLOSE {
                self.inspect_between_rays(run, progress)?;
            }
            done += count;
            number += parts.len();
            progress.step(Stage::Verify, done as u64, steps.max(done) as u64)?;
        }
        if done == 0 {
            return Err(VerifyError::NoMotion);
        }
        self.inspect_between_rays(run, progress)?;
        let left = self.stock.volume();
        let (mut collisions, mut lines) = (Vec::new(), Vec::new());
        for (kind, found) in std::mem::take(&mut self.found) {
            let (worst, all) = found.finish();
            collisions.extend(worst);
            lines.extend(all.map(|all| (kind, all)));
        }
        collisions.sort_by_key(|hit: &Collision| (hit.line, hit.kind));
        Ok(StockReport {
            removed: before - left,
            left,
            collisions,
            lines,
            undecided: self.undecided,
        })
    }

    /// Cuts with some moves, in batches.
    pub(super) fn cut_moves(
        &mut self,
        run: &Run<'_>,
        segments: &[Segment],
    ) -> Result<(), VerifyError> {
        for batch in segments.chunks(BATCH) {
            let mut parts = Vec::new();
            for segment in batch {
                self.tools.parts(&run.mover, segment, parts.len(), &mut parts)?;
            }
            self.cut(&parts);
        }
        Ok(())
    }

    /// Inspects the boxes in which bodies come close to material.
    fn inspect_between_rays(
        &mut self,
        run: &Run<'_>,
        progress: &dyn Progress,
    ) -> Result<(), VerifyError> {
        let close = std::mem::take(&mut self.close);
        if close.is_empty() {
            return Ok(());
        }
        if self.shell.is_none() {
            let solid = self.uncut.as_ref();
            self.shell =
                solid.and_then(|solid| ClosedMesh::new(solid.triangles(PRISM * inspect::LEAST)));
        }
        let Some(shell) = &self.shell else { return Ok(()) };
        for BoxFinding { line, kind, known, hit, open } in
            inspect::inspect_boxes(run, &self.tools, shell, close, progress)?
        {
            if let Some(hit) = hit {
                let history = if known { LineHistory::Noted } else { LineHistory::New };
                let worst = self.worst;
                let found = self.found.entry(kind).or_insert_with(|| LineStatistics::new(worst));
                found.note_late(line, hit.depth, hit, history);
            }
            let deepest = self.undecided.map_or(0.0, |undecided| undecided.depth);
            if let Some(depth) = open.filter(|depth| *depth > deepest) {
                self.undecided = Some(UndecidedCollision { kind, line, depth });
            }
        }
        Ok(())
    }

    /// Clips the stock by a batch.
    fn cut(&mut self, parts: &[MovingPart]) {
        let ClipFindings { hits, close } = clip_by(self.stock, parts, self.tools.tolerance);
        let deepest = self.note(hits);
        if self.uncut.is_none() {
            return;
        }
        // Collisions deeper than the ray spacing show on the rays as well.
        let cell = self.stock.cell().into_iter().fold(f64::INFINITY, f64::min);
        for mut close in boxes::merge(close) {
            // Collisions that the rays show already are searched for a greater depth only.
            close.known = deepest.get(&(close.kind, close.line)).map_or(0.0, |hit| hit.depth);
            if close.known < cell {
                self.close.push(close);
            }
        }
    }

    /// Records the collisions of a batch line by line; returns the deepest of each line and kind.
    fn note(&mut self, hits: Vec<Collision>) -> BTreeMap<(CollisionKind, u32), Collision> {
        let mut deepest: BTreeMap<(CollisionKind, u32), Collision> = BTreeMap::new();
        for hit in hits {
            let worst = deepest.entry((hit.kind, hit.line)).or_insert(hit);
            if hit.depth > worst.depth {
                *worst = hit;
            }
        }
        for (&(kind, line), &hit) in &deepest {
            let worst = self.worst;
            let found = self.found.entry(kind).or_insert_with(|| LineStatistics::new(worst));
            found.note(line, hit.depth, hit);
        }
        deepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{CutterKind, CutterSpec, ProfilePiece};
    use crate::nc::read::{ClFile, ClMotion, ClPath, ClRecord};
    use crate::types::{Silent, ToolPose};
    use crate::verify::Solid;
    use crate::verify::stock::broad_phase::RayFrame;
    use crate::verify::stock::clip::closest_approach::RayLine;
    use crate::verify::stock::dexel::unit;
    use nalgebra::{Point3, Rotation3, Unit, Vector3};
    use proptest::prelude::*;

    const TOLERANCE: f64 = 1e-3;

    fn cutter(kind: CutterKind, major: f64, minor: f64) -> Cutter {
        let spec = CutterSpec { kind, length: 25.0, ..CutterSpec::of_radii(major, minor) };
        Cutter::new(spec).unwrap()
    }

    fn any_cutter() -> impl Strategy<Value = Cutter> {
        prop_oneof![
            Just(cutter(CutterKind::Bull, 3.0, 2.0)),
            Just(cutter(CutterKind::Ball, 0.0, 2.5)),
            Just(cutter(CutterKind::Flat, 4.0, 0.0)),
            Just(with_side(CutterSpec::taper(1.0, 0.2, 8.0))),
            Just(with_side(CutterSpec::barrel(1.0, 40.0, 8.0))),
            Just(with_side(CutterSpec::conical_barrel(1.0, 60.0, 0.3, 8.0))),
            Just(with_side(CutterSpec::lens(30.0, 1.0, 8.0))),
        ]
    }

    fn with_side(spec: CutterSpec) -> Cutter {
        Cutter::new(CutterSpec { length: 25.0, ..spec }).unwrap()
    }

    /// Outward normal of a supporting line of the profile, and its distance from the tip.
    type ProfileLine = ([f64; 2], f64);

    /// Lines around the profile, close enough together to stand for its arcs: no piece decides where a point lies.
    fn lines(cutter: &Cutter) -> Vec<ProfileLine> {
        let mut all = vec![([0.0, 1.0], cutter.length())];
        for piece in cutter.profile() {
            match *piece {
                ProfilePiece::Line { from, to } => {
                    let along = [to[0] - from[0], to[1] - from[1]];
                    let length = along[0].hypot(along[1]);
                    let normal = [along[1] / length, -along[0] / length];
                    all.push((normal, normal[0] * from[0] + normal[1] * from[1]));
                }
                ProfilePiece::Arc { center, radius, from, to } => {
                    let [first, last] = [from, to].map(|[out, up]| out.atan2(-up));
                    all.extend((0..=80).map(|k| {
                        let (out, down) = (first + (last - first) * f64::from(k) / 80.0).sin_cos();
                        ([out, -down], center[0] * out - center[1] * down + radius)
                    }));
                }
            }
        }
        all
    }

    /// Forth and back, leaning this way and that, through the block and out of it.
    fn far_apart() -> impl Strategy<Value = Vec<ToolPose>> {
        let step = (-9.0..9.0, -7.0..7.0, -6.0..4.0, -0.5..0.5, -0.5..0.5);
        prop::collection::vec(step, 3..12).prop_map(|steps| {
            steps.into_iter().map(|(x, y, z, a, b)| pose([x, y, z], [a, b])).collect()
        })
    }

    /// Short moves that lean a little more or less every time, as along a surface.
    fn close_by() -> impl Strategy<Value = Vec<ToolPose>> {
        let start = (-9.0..-4.0, -5.0..5.0, -4.0..-1.0, -0.4..0.4, -0.4..0.4);
        let rate = (-0.15..0.15, -0.3..0.3, -0.03..0.03, -0.03..0.03);
        (start, rate, 0.3..1.0, 10..20u32).prop_map(|(start, rate, step, count)| {
            let (x, y, z, a, b) = start;
            let (swerve, dive, lean, tilt) = rate;
            let at = |k: u32| {
                let s: f64 = step * f64::from(k);
                let z = z + dive * (0.5 * s).sin();
                pose([x + s, y + swerve * s * s, z], [a + lean * s, b + tilt * s])
            };
            (0..=count).map(at).collect()
        })
    }

    fn pose(tip: [f64; 3], [a, b]: [f64; 2]) -> ToolPose {
        let axis = Rotation3::from_euler_angles(a, b, 0.0) * Vector3::z();
        ToolPose { tip: Point3::from(tip), axis: Unit::new_normalize(axis) }
    }

    fn any_path() -> impl Strategy<Value = Vec<ToolPose>> {
        prop_oneof![far_apart(), close_by()]
    }

    /// Cutter with the lines around its profile, if it has a side.
    struct Outline<'a> {
        cutter: &'a Cutter,
        lines: Vec<ProfileLine>,
    }

    impl<'a> Outline<'a> {
        fn of(cutter: &'a Cutter) -> Self {
            let has_side = cutter.tangent_profile().is_some();
            Self { cutter, lines: if has_side { lines(cutter) } else { Vec::new() } }
        }
    }

    fn distance(outline: &Outline<'_>, [from, to]: &[ToolPose; 2], t: f64, p: &Point3<f64>) -> f64 {
        let axis = from.axis.slerp(&to.axis, t);
        let y = p - (from.tip + (to.tip - from.tip) * t);
        let Outline { cutter, lines } = outline;
        if !lines.is_empty() {
            let (rho, z) = (axis.cross(&y).norm(), axis.dot(&y));
            let beyond = |([out, up], reach): ProfileLine| out * rho + up * z - reach;
            return lines.iter().copied().map(beyond).fold(f64::NEG_INFINITY, f64::max);
        }
        let [out, down] = [axis.cross(&y).norm() - cutter.major(), cutter.minor() - axis.dot(&y)];
        let round = out.max(0.0).hypot(down.max(0.0)) + out.max(down).min(0.0);
        (round - cutter.minor()).max(axis.dot(&y) - cutter.length())
    }

    /// Over a whole path: sampled, then by thirds around the best samples of every move.
    fn nearest(outline: &Outline<'_>, path: &[ToolPose], p: &Point3<f64>) -> f64 {
        let ends = path.windows(2).map(|pair| [pair[0], pair[1]]);
        let least = ends.map(|ends| {
            let at = |t: f64| distance(outline, &ends, t, p);
            let values: Vec<f64> = (0..=40).map(|k| at(f64::from(k) / 40.0)).collect();
            let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
            if lowest > 1.0 {
                return lowest;
            }
            // A move that turns may come near twice.
            let around = |k: usize| {
                let [mut low, mut high] =
                    [k as f64 - 1.0, k as f64 + 1.0].map(|k| (k / 40.0).clamp(0.0, 1.0));
                for _ in 0..30 {
                    let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                    if at(a) < at(b) { high = b } else { low = a }
                }
                at(low)
            };
            (0..=40).filter(|&k| values[k] < lowest + 0.3).map(around).fold(lowest, f64::min)
        });
        least.fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: cases(32), ..ProptestConfig::default() })]

        /// On every ray, whatever was put off, grouped or passed over: what is left is outside the swept
        /// tool, what is gone is inside, to the tolerance.
        #[test]
        fn what_is_left_is_what_no_pose_holds(cutter in any_cutter(), path in any_path()) {
            let outline = Outline::of(&cutter);
            let motion = ClMotion::Feed(10.0);
            let record = |(line, &pose)| ClRecord { line, pose, motion, way: ClPath::Straight };
            let file = ClFile { records: (1..).zip(&path).map(record).collect(), ..ClFile::default() };
            let input = CheckInput::locations(&file, &cutter);
            let [low, high] = [Point3::new(-8.0, -6.0, -5.0), Point3::new(8.0, 6.0, 0.0)];
            let mut stock = Stock::new(&Solid::Box { low, high }, 0.45, 100_000).unwrap();
            simulate(&input, &mut stock, &StockOptions::within(TOLERANCE), &Silent).unwrap();
            for family in &stock.families {
                let along = family.along;
                for (index, tile) in family.tiles.iter().enumerate() {
                    // Every 37th ray, another one in each tile.
                    for ray in (index % 37..tile.rays.len()).step_by(37) {
                        let frame = RayFrame { lattice: stock.lattice, along, bins: family.bins };
                        let line = RayLine { from: frame.ray(tile, ray), direction: unit(along) };
                        let spans = &tile.rays[ray];
                        let ends: Vec<f64> = spans.iter().flatten().collect();
                        let mut places: Vec<f64> = (1..12)
                            .map(|k| low[along] + (high[along] - low[along]) * f64::from(k) / 12.0)
                            .collect();
                        places.extend(ends.iter().flat_map(|end| [end - 1e-5, end + 1e-5]));
                        for s in places {
                            if s <= low[along] || s >= high[along] {
                                continue;
                            }
                            let distance = nearest(&outline, &path, &line.at(s));
                            let kept = spans.iter().any(|[from, to]| (from..=to).contains(&s));
                            let sound = if kept { distance >= -TOLERANCE } else { distance <= TOLERANCE };
                            prop_assert!(sound, "axis {along}: {distance} at {s}, {spans:?}");
                        }
                    }
                }
            }
        }
    }

    fn cases(usual: u32) -> u32 {
        let said = std::env::var("PROPTEST_CASES").ok().and_then(|said| said.parse::<u32>().ok());
        said.map_or(usual, |cases| (cases / 10).max(1))
    }
}
