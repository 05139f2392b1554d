//! Checks the moves of a program for collisions of the machine's bodies.

use super::bodies::{HeldBody, HeldRole, MachineBodies};
use super::linked::{LinkedBody, TOOL, WORKPIECE, nose_profile, placed};
use super::pair::BodyPair;
use super::search::{self, PairApproach, PairGoal};
use super::spans::MoveSpans;
use super::stock_watch::{PlacedMoves, StockApproach, StockScene, StockWatch};
use crate::cutter::Cutter;
use crate::machine::Kinematics;
use crate::types::{AxisVector, Progress, Stage};
use crate::verify::error::VerifyError;
use crate::verify::fixture::watch::ClearanceOptions;
use crate::verify::line_stats::{LineCount, LineStatistics};
use crate::verify::replay::controls::Controls;
use crate::verify::replay::mover::Mover;
use crate::verify::replay::segment::{Course, Segment};
use crate::verify::replay::segments::Run;
use crate::verify::stock::carve::StockOptions;
use crate::verify::stock::material::Stock;
use crate::verify::stock::partly_cut::PartlyCutStock;
use crate::verify::swept::revolved::revolved;
use crate::verify::swept::tool::{self, ConvexBody};
use nalgebra::{Isometry3, Point3};
use rayon::prelude::*;

/// Nearest approach of two bodies on one line of a program.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct BodyApproach {
    /// Line of the program.
    pub line: u32,
    /// Names of both bodies, the one nearer to the workpiece first.
    pub bodies: [String; 2],
    /// Least distance \[mm\], to within the tolerance, or 1 % of what is beyond the clearance; negative if they touch.
    pub distance: f64,
    /// Point between them, in machine coordinates with the link of the first body at zero \[mm\].
    pub point: Point3<f64>,
    /// Positions of the axes there, to within what the distance is certain to \[mm, rad\].
    pub axes: AxisVector,
}

/// Distances of the machine's bodies over a program.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct BodyReport {
    /// Pairs that were compared.
    pub pairs: usize,
    /// Nearest approach of all; `None` without a pair.
    pub least: Option<BodyApproach>,
    /// Lines nearer than the required clearance, in order: the nearest of them.
    pub near: Vec<BodyApproach>,
    /// Number of such lines; `None` if there are none.
    pub lines: Option<LineCount>,
    /// Number of lines on which bodies touch.
    pub hits: Option<LineCount>,
}

/// Moves in a tree: the memory does not grow with the program.
const BATCH: usize = 8192;

/// Positions of a batch at which pairs are compared beforehand.
const SAMPLES: usize = 24;

/// Share of a sampled distance that may be missed, and the longest distance of which \[mm\]: they are a first bound.
const ROUGH: f64 = 0.05;
const FAR: f64 = 1e3;

/// Shares of the tolerance: error of round bodies as prisms, and loss of the search.
const ROUND: f64 = 0.3;
const SEARCH: f64 = 0.6;

/// Bodies that are compared, and the accuracy.
pub(crate) struct WatchedBodies<'a> {
    pub(crate) bodies: &'a MachineBodies,
    pub(crate) cutters: &'a [&'a Cutter],
    pub(crate) kinematics: &'a Kinematics,
    pub(crate) watch: ClearanceOptions,
    /// Stock that the program cuts; without it, stock counts with all of its material.
    pub(crate) stock: Option<(&'a Stock, StockOptions)>,
}

/// Checks the distances of the bodies of a machine over a program.
pub(crate) fn watch_bodies(
    watched: &WatchedBodies<'_>,
    run: &Run<'_>,
    progress: &dyn Progress,
) -> Result<BodyReport, VerifyError> {
    let Mover::Machine(controls) = &run.mover else { return Err(VerifyError::NoMotion) };
    BodyWatcher::new(watched).run(controls, run, progress)
}

struct BodyWatcher<'a> {
    /// Pairs without the tool.
    fixed: Vec<BodyPair<'a>>,
    bodies: &'a MachineBodies,
    kinematics: &'a Kinematics,
    /// Fixtures, and stock that is not cut.
    held: Vec<LinkedBody>,
    /// All of the stock that is cut.
    uncut: Option<LinkedBody>,
    stock: Option<(&'a Stock, StockOptions)>,
    cutters: &'a [&'a Cutter],
    /// Bodies of each tool.
    tools: Vec<Vec<LinkedBody>>,
    watch: ClearanceOptions,
}

/// Findings, in order of the program.
struct BodyFindings {
    least: Option<NearBodies>,
    near: LineStatistics<NearBodies>,
    hits: LineStatistics<()>,
    /// Names of bodies that came near, each once.
    names: Vec<String>,
}

/// Approach with the places of its names.
#[derive(Debug, Clone, Copy)]
struct NearBodies {
    line: u32,
    names: [usize; 2],
    distance: f64,
    point: Point3<f64>,
    axes: AxisVector,
}

impl BodyFindings {
    fn place_of(&mut self, name: &str) -> usize {
        let known = self.names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        })
    }

    fn approach(&self, near: &NearBodies) -> BodyApproach {
        let NearBodies { line, names, distance, point, axes } = *near;
        let bodies = names.map(|at| self.names.get(at).cloned().unwrap_or_default());
        BodyApproach { line, bodies, distance, point, axes }
    }
}

/// Bodies at one position of the axes, with one tool.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StandingBodies<'a> {
    pub(crate) bodies: &'a MachineBodies,
    pub(crate) cutter: &'a Cutter,
    pub(crate) kinematics: &'a Kinematics,
}

impl StandingBodies<'_> {
    /// Returns true if every two bodies of these names keep a clearance \[mm\]; stock counts with all of its material.
    pub(crate) fn keep_clear(&self, names: &[String; 2], q: &AxisVector, clearance: f64) -> bool {
        let StandingBodies { bodies, cutter, kinematics } = *self;
        let watch = ClearanceOptions { clearance, ..ClearanceOptions::within(bodies.tolerance()) };
        let cutters = [cutter];
        let watched = WatchedBodies { bodies, cutters: &cutters, kinematics, watch, stock: None };
        let watcher = BodyWatcher::new(&watched);
        let pairs = watcher.pairs(0);
        let named =
            |pair: &&BodyPair<'_>| pair.bodies.iter().all(|body| names.contains(&body.name));
        let least = clearance.max(bodies.tolerance());
        pairs.iter().filter(named).all(|pair| !pair.touches(q, least))
    }
}

impl<'a> BodyWatcher<'a> {
    fn new(watched: &WatchedBodies<'a>) -> Self {
        let WatchedBodies { bodies, cutters, kinematics, watch, stock } = *watched;
        let place = workpiece_place(kinematics);
        let on_workpiece = |HeldBody { name, mesh, allowance, .. }: &HeldBody| {
            LinkedBody::new(name.clone(), WORKPIECE, placed(mesh, &place), *allowance)
        };
        let is_cut = |held: &&HeldBody| held.role == HeldRole::Stock && stock.is_some();
        let held = bodies.held.iter().filter(|held| !is_cut(held)).filter_map(on_workpiece);
        let uncut = bodies.held.iter().find(is_cut).and_then(on_workpiece);
        let tolerance = ROUND * watch.tolerance;
        let tools = cutters.iter().map(|cutter| tool_bodies(kinematics, cutter, tolerance));
        let machine = kinematics.machine();
        let pairs = bodies.pairs.iter().filter_map(|[a, b]| {
            Some(BodyPair::new(machine, [bodies.all.get(*a)?, bodies.all.get(*b)?]))
        });
        Self {
            fixed: pairs.collect(),
            bodies,
            kinematics,
            held: held.collect(),
            uncut,
            stock,
            cutters,
            tools: tools.collect(),
            watch,
        }
    }

    /// Returns the watch over stock that is cut; `None` without such stock.
    fn stock_watch<'w>(&'w self, run: &'w Run<'w>) -> Option<StockWatch<'w>> {
        let (uncut, (stock, options)) = (self.uncut.as_ref()?, self.stock?);
        let scene = StockScene {
            machine: self.kinematics.machine(),
            bodies: self.bodies.all.iter().filter(|body| body.link != WORKPIECE).collect(),
            uncut,
            place: workpiece_place(self.kinematics),
        };
        Some(StockWatch::new(scene, PartlyCutStock::new(stock, options, self.cutters, run)))
    }

    /// Returns all pairs with a tool in the spindle, without stock that is cut.
    fn pairs(&self, tool: usize) -> Vec<BodyPair<'_>> {
        let machine = self.kinematics.machine();
        let mut pairs = self.fixed.clone();
        for body in &self.bodies.all {
            if body.link != WORKPIECE {
                pairs.extend(self.held.iter().map(|held| BodyPair::new(machine, [held, body])));
            }
            if body.link != TOOL {
                let tools = self.tools.get(tool).into_iter().flatten();
                pairs.extend(tools.map(|tool| BodyPair::new(machine, [body, tool])));
            }
        }
        pairs
    }

    fn run(
        &self,
        controls: &Controls,
        run: &Run<'_>,
        progress: &dyn Progress,
    ) -> Result<BodyReport, VerifyError> {
        let most = self.watch.worst;
        let mut found = BodyFindings {
            least: None,
            near: LineStatistics::new(most),
            hits: LineStatistics::new(most),
            names: Vec::new(),
        };
        let (mut segments, steps) = (run.segments().peekable(), run.steps());
        let (mut done, mut count, mut start) = (0, 0, true);
        let mut stock = self.stock_watch(run);
        let with_stock: Vec<BodyPair<'_>> = stock.iter().flat_map(StockWatch::pairs).collect();
        while segments.peek().is_some() {
            // A batch has one tool.
            let mut batch = PlacedMoves { segments: Vec::new(), places: Vec::new() };
            let mut tool = None;
            while batch.segments.len() < BATCH {
                let Some(Ok(next)) = segments.peek() else { break };
                if tool.is_some_and(|tool| tool != next.tool) {
                    break;
                }
                tool = Some(next.tool);
                if let Some(Ok(segment)) = segments.next() {
                    let is_known = !matches!(segment.course, Course::Unknown);
                    batch.segments.extend(is_known.then_some(segment));
                    // Rapids run in both ways that controls know; both must keep clear.
                    batch.segments.extend(run.mover.dog_leg(&segment));
                    batch.places.resize(batch.segments.len(), done);
                }
                done += 1;
            }
            if let Some(Err(_)) = segments.peek() {
                segments.next().transpose()?;
            }
            let pairs = self.pairs(tool.unwrap_or_default());
            count = count.max(pairs.len() + with_stock.len());
            if start && let Some(segment) = batch.segments.first() {
                start = false;
                self.note_inside(&pairs, segment, &mut found);
                self.note_inside(&with_stock, segment, &mut found);
            }
            let near_stock = match &mut stock {
                Some(stock) => stock.search(controls, &batch, self.goal(found_least(&found)))?,
                None => Vec::new(),
            };
            let spans = MoveSpans::new(controls, batch.segments);
            self.search(&pairs, &spans, &mut found)?;
            for StockApproach { body, approach } in &near_stock {
                let pair = with_stock.iter().find(|pair| std::ptr::eq(pair.bodies[1], *body));
                if let Some(pair) = pair {
                    self.note(pair, approach, &mut found);
                }
            }
            progress.step(Stage::Verify, done as u64, steps.max(done) as u64)?;
        }
        let empty = LineStatistics::new(most);
        let (near, lines) = std::mem::replace(&mut found.near, empty).finish();
        let (_, hits) = std::mem::replace(&mut found.hits, LineStatistics::new(most)).finish();
        let near = near.iter().map(|near| found.approach(near)).collect();
        let least = found.least.map(|least| found.approach(&least));
        Ok(BodyReport { pairs: count, least, near, lines, hits })
    }

    /// Notes bodies that are inside others at the start: from then on they cannot get out without touching.
    fn note_inside(&self, pairs: &[BodyPair<'_>], segment: &Segment, found: &mut BodyFindings) {
        for pair in pairs.iter().filter(|pair| pair.is_inside(&segment.joints[0])) {
            let point = pair.bodies[0].middle;
            let distance = -self.watch.tolerance;
            let (line, axes) = (segment.line, segment.joints[0]);
            let approach = PairApproach { line, first: 0, distance, point, axes };
            self.note(pair, &approach, found);
        }
    }

    fn search(
        &self,
        pairs: &[BodyPair<'_>],
        spans: &MoveSpans<'_>,
        found: &mut BodyFindings,
    ) -> Result<(), VerifyError> {
        // Step 1: all pairs begin with the least distance of the batches before and of some positions, so that those that
        // stay far apart need few steps, and the result does not depend on the threads.
        let before = found_least(found);
        let sampled = |pair: &BodyPair<'_>| {
            let (mut nearest, mut hint) = (before, None);
            for q in spans.samples(SAMPLES) {
                let slack = self.watch.tolerance.max(ROUGH * nearest.min(FAR));
                if let Some(gap) = pair.gap(q, [nearest, slack], hint) {
                    (nearest, hint) = (gap.distance, Some(gap.triangles));
                }
            }
            nearest
        };
        let least = pairs.par_iter().map(sampled).reduce(|| f64::INFINITY, f64::min);
        // Not below what is found there again, so that the pair itself is named.
        let least = least.max(0.0) * (1.0 + 3.0 * search::SHARE) + 2.0 * self.watch.tolerance;
        let least = least.min(before);
        let goal = self.goal(least);
        // Step 2: each pair by itself.
        let all: Vec<Result<Vec<PairApproach>, VerifyError>> =
            pairs.par_iter().map(|pair| approaches(pair, spans, goal)).collect();
        let mut ordered: Vec<(usize, PairApproach)> = Vec::new();
        for (index, approaches) in all.into_iter().enumerate() {
            ordered.extend(approaches?.into_iter().map(|approach| (index, approach)));
        }
        // In the order of the program.
        ordered.sort_by_key(|(index, approach)| (approach.line, *index));
        for (index, approach) in &ordered {
            if let Some(pair) = pairs.get(*index) {
                self.note(pair, approach, found);
            }
        }
        Ok(())
    }

    /// Returns the goal of a search with the least distance so far \[mm\].
    fn goal(&self, least: f64) -> PairGoal {
        PairGoal { reported: self.reported(), least, tolerance: SEARCH * self.watch.tolerance }
    }

    /// Returns the distance below which a line is reported \[mm\]: where bodies may touch, always.
    fn reported(&self) -> f64 {
        self.watch.clearance.max(0.0)
    }

    fn note(&self, pair: &BodyPair<'_>, approach: &PairApproach, found: &mut BodyFindings) {
        let PairApproach { line, distance, point, axes, .. } = *approach;
        let names = pair.bodies.map(|body| found.place_of(&body.name));
        let near = NearBodies { line, names, distance, point, axes };
        if found.least.is_none_or(|least| distance < least.distance) {
            found.least = Some(near);
        }
        if distance < self.reported() {
            found.near.note(line, -distance, near);
            if distance < 0.0 {
                found.hits.note(line, -distance, ());
            }
        }
    }
}

/// Returns the least distance of all so far \[mm\].
fn found_least(found: &BodyFindings) -> f64 {
    found.least.map_or(f64::INFINITY, |least| least.distance)
}

/// Returns the place of the workpiece in the machine frame with all axes at zero.
fn workpiece_place(kinematics: &Kinematics) -> Isometry3<f64> {
    let setup = kinematics.setup();
    Isometry3::from_parts(setup.origin.into(), setup.rotation.into())
}

/// Finds the approaches of a pair that is not clear as a whole.
fn approaches(
    pair: &BodyPair<'_>,
    spans: &MoveSpans<'_>,
    goal: PairGoal,
) -> Result<Vec<PairApproach>, VerifyError> {
    if search::is_clear(pair, spans, goal)? {
        return Ok(Vec::new());
    }
    search::nearest(pair, spans, goal)
}

/// Returns a tool as bodies on its link: prisms and cones around its parts.
fn tool_bodies(kinematics: &Kinematics, cutter: &Cutter, tolerance: f64) -> Vec<LinkedBody> {
    let machine = kinematics.machine();
    let axis = machine.tool_axis;
    let tip = machine.gauge - axis.scale(cutter.length());
    let all = tool::bodies(cutter).into_iter().filter_map(|body| {
        let (name, profile) = match body {
            ConvexBody::Frustum { low, high, radius, slope } => {
                ("holder", vec![[radius, low], [radius + slope * (high - low), high]])
            }
            ConvexBody::Nose { major, minor, top } => ("tool", nose_profile([major, minor, top])),
            // The cylinder round a taper or a barrel.
            ConvexBody::Tangent(_) => {
                ("tool", body.heights().map(|height| [body.radius(), height]).into())
            }
        };
        let mesh = revolved(&tip, &axis, &profile, tolerance);
        LinkedBody::new(name.to_owned(), TOOL, mesh, 0.0)
    });
    all.collect()
}
