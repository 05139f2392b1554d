//! Branch and bound: boxes of rotations are halved until none is left that could hold a better one.

use super::evaluation::{PlannedSetups, SetupTask};
use super::local_search::SetupCandidate;
use super::result::{EvaluatedSetup, SearchAssurance, SetupVerdict};
use super::rotary_triangle::RotationBall;
use super::rotation_cell::RotationCell;
use crate::machine::{FIRST_ROTARY, Kinematics, SECOND_ROTARY};
use crate::types::{AxisVector, Cancelled, PieceGeometry, Progress, Stage};
use nalgebra::{Matrix3, Point3};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

/// Cells that are halved at a time.
const BATCH: usize = 8;

/// Cells smaller than this share of what is asked for are not halved if their centre does not fit.
const SMALLEST: f64 = 0.25;

/// Error of arc cosines of the least angles next to 1 \[rad\].
const ROUNDING: f64 = 1e-7;

/// A cell that may hold a better rotation.
#[derive(Debug, Clone, Copy)]
struct OpenCell {
    cell: RotationCell,
    /// Ball of rotations about its centre that contains it.
    ball: RotationBall,
    /// Upper bound on the least angle of all its rotations \[rad\].
    bound: f64,
}

/// Effort spent on the axes at the centre of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlanEffort {
    /// Searches the best rotation near the centre first.
    BestNearby,
    /// Plans the centre alone.
    CentreOnly,
}

/// Result of halving a cell.
#[derive(Debug, Default)]
struct HalvedCell {
    planned: Vec<EvaluatedSetup>,
    open: Vec<OpenCell>,
    /// Largest bound of parts that cannot be better by enough.
    floor: f64,
    /// Radius, if the centre was planned in vain and nothing more is known of the cell.
    except: f64,
    evaluated: usize,
}

/// Lever arms, which bound how far a change of rotation moves the linear axes \[mm\].
#[derive(Debug, Clone, Copy)]
struct TravelLevers {
    /// Of the linear axes by the tip.
    stiffness: f64,
    /// From the rotary axes to the tip, as far as travel allows.
    rotaries: [f64; 2],
    /// From the workpiece origin to the path.
    path: f64,
}

/// Branch and bound over the rotations within the search bounds.
pub(super) struct OptimalityProof<'a> {
    task: &'a SetupTask<'a>,
    levers: TravelLevers,
    queue: CellQueue,
    sum: SearchAssurance,
}

impl<'a> OptimalityProof<'a> {
    pub(super) fn new(task: &'a SetupTask<'a>) -> Self {
        let sum = SearchAssurance { bound: None, except: 0.0, evaluated: 0, planned: 0 };
        Self { task, levers: TravelLevers::of(task), queue: CellQueue::default(), sum }
    }

    /// Halves cells until none can be better by enough, or the effort allowed is spent.
    pub(super) fn run(mut self, planned: &mut PlannedSetups) -> Result<SearchAssurance, Cancelled> {
        let search = self.task.search;
        let mut best = planned.least();
        self.queue.by_bound = best.is_some();
        let mut floor: f64 = 0.0;
        let mut whole = HalvedCell::default();
        self.bound_cell(RotationCell::whole(&search.bounds), PI, f64::NEG_INFINITY, &mut whole);
        self.queue.add(whole.open);
        let progress: &dyn Progress = &self.task.progress;
        loop {
            progress.step(Stage::Axes, 0, 0)?;
            let spent = self.sum.evaluated >= search.most_evaluated
                || self.sum.planned >= search.most_planned;
            if spent {
                break;
            }
            let batch = self.queue.take(self.target(best));
            if batch.is_empty() {
                break;
            }
            let halved: Result<Vec<HalvedCell>, Cancelled> = batch
                .par_iter()
                .enumerate()
                .map(|(place, open)| {
                    let first = place == 0;
                    let effort =
                        if first { PlanEffort::BestNearby } else { PlanEffort::CentreOnly };
                    self.halve(open, best, effort)
                })
                .collect();
            for one in halved? {
                self.sum.evaluated += one.evaluated;
                self.sum.planned += one.planned.len();
                self.sum.except = self.sum.except.max(one.except);
                floor = floor.max(one.floor);
                one.planned.into_iter().for_each(|judged| planned.add(judged));
                self.queue.add(one.open);
            }
            best = planned.least();
            if best.is_some() {
                self.queue.sort_by_bound();
            }
        }
        // Open cells, and cells that were dropped because they cannot be better by enough, bound what no
        // rotation exceeds.
        let open = self.queue.bound();
        self.sum.bound = match best {
            Some(best) => Some(open.unwrap_or(0.0).max(floor).max(best)),
            None => open,
        };
        Ok(self.sum)
    }

    /// Returns the least angle that a cell must be able to contain to be halved.
    fn target(&self, best: Option<f64>) -> f64 {
        best.map_or(f64::NEG_INFINITY, |best| best + self.task.search.within)
    }

    /// Bounds a cell, and keeps it in `into` if it may hold a rotation better than `target` \[rad\]. `above`
    /// is the bound of the cell that it is a part of.
    fn bound_cell(&self, cell: RotationCell, above: f64, target: f64, into: &mut HalvedCell) {
        let SetupTask { angles, samples, .. } = self.task;
        into.evaluated += 1;
        let radius = cell.radius();
        // Along the cell the first rotary's direction, seen from the workpiece, moves by this at most; a
        // turn by the radius moves no direction farther than that.
        let drift = cell.moves(&angles.first).iter().sum::<f64>().min(radius);
        let rotation = cell.centre.rotation();
        let check = angles.check_angles(samples.within(drift), &rotation);
        // Needs more tilt at the centre than the cell can save: none of its rotations fits.
        if check.missing_tilt > drift + ROUNDING {
            return;
        }
        // Within the cell the least angle grows by at most the drift.
        let bound = above.min(check.least + drift + ROUNDING);
        if bound <= target {
            into.floor = into.floor.max(bound);
            return;
        }
        let ball = RotationBall { radius, drift };
        let samples = samples.within(radius);
        if angles.missing_turn(samples, &rotation, ball) > 0.0 {
            return;
        }
        into.open.push(OpenCell { cell, ball, bound });
    }

    /// Plans the centre of a cell where that may pay, and bounds its halves.
    fn halve(
        &self,
        open: &OpenCell,
        best: Option<f64>,
        effort: PlanEffort,
    ) -> Result<HalvedCell, Cancelled> {
        let search = self.task.search;
        let mut halved = HalvedCell::default();
        let fine = self.task.angles.check(self.task.samples.finest(), &open.cell.centre.rotation());
        let bound = open.bound.min(fine.least + open.ball.drift + ROUNDING);
        let target = self.target(best);
        if bound <= target {
            halved.floor = bound;
            return Ok(halved);
        }
        let better = best.is_none_or(|best| fine.least > best + 0.5 * search.within);
        let mut in_vain = false;
        if better && fine.fits() {
            halved.planned =
                self.plan(&SetupCandidate { workpiece: open.cell.centre, check: fine }, effort)?;
            let last = halved.planned.last();
            in_vain = last.is_some_and(|one| one.verdict.fits().is_none());
            if last.is_some_and(|one| self.too_short(open, &one.verdict)) {
                return Ok(halved);
            }
        }
        // With an endless workpiece-side rotary, only its direction matters.
        // Otherwise a cell is worth halving as long as any turn of the workpiece in it is large.
        let by_direction =
            !in_vain && (fine.missing_turn <= 0.0 || self.task.angles.turning.endless_first());
        let size = if by_direction { open.ball.drift } else { open.ball.radius };
        // Too small to matter: its centre does not fit, and nothing is known of what is near it.
        if (in_vain || !fine.fits()) && size <= SMALLEST * search.within {
            halved.except = size;
            return Ok(halved);
        }
        let does =
            if by_direction { open.cell.moves(&self.task.angles.first) } else { open.cell.turns() };
        for half in open.cell.halves(does) {
            self.bound_cell(half, bound, target, &mut halved);
        }
        Ok(halved)
    }

    /// Plans the centre of a cell, or the best near it; the last one planned represents the cell.
    fn plan(
        &self,
        centre: &SetupCandidate,
        effort: PlanEffort,
    ) -> Result<Vec<EvaluatedSetup>, Cancelled> {
        match effort {
            PlanEffort::BestNearby => self.task.improve(&self.task.climb(centre)),
            PlanEffort::CentreOnly => Ok(vec![self.task.evaluate(&centre.workpiece)?]),
        }
    }

    /// Returns `true` if linear travel is too short for every rotation of a cell, rotaries as they were planned
    /// for its centre: a smaller rotation moves the linear axes by less than what is missing.
    fn too_short(&self, open: &OpenCell, verdict: &SetupVerdict) -> bool {
        let SetupVerdict::Short { by, .. } = verdict else { return false };
        let RotationBall { radius, .. } = open.ball;
        let rotation = open.cell.centre.rotation();
        let trail = self.task.samples.within(radius).trail();
        let slack = self.task.angles.turning.slack(trail, &rotation, open.ball);
        // A rotary that moves by δ moves the tip by no more than its lever times δ, and a turn of the
        // workpiece by r by no more than r times the path's distance from the origin. The slides follow
        // by `stiffness` times that: less than what is missing leaves it missing.
        let TravelLevers { stiffness, rotaries, path } = self.levers;
        slack.is_some_and(|[first, second]| {
            *by > stiffness * (first * rotaries[0] + second * rotaries[1] + radius * path)
        })
    }
}

impl TravelLevers {
    /// Measures the levers of a machine and a path.
    fn of(task: &SetupTask<'_>) -> Self {
        let machine = task.kinematics.machine();
        let setup = task.kinematics.setup();
        let axes = &machine.axes;
        let slides: f64 = axes[..FIRST_ROTARY]
            .iter()
            .map(|axis| axis.limits.low.abs().max(axis.limits.high.abs()))
            .sum();
        let tip = machine.gauge - machine.tool_axis.scale(setup.tool_length);
        let [first, second] = [axes[FIRST_ROTARY].point, axes[SECOND_ROTARY].point];
        let between = (first - second).norm();
        // The tip is off its position at zero by all linear travel at most, and a rotary line that turns
        // about the other one by twice their distance.
        let far = |point: Point3<f64>| (tip - point).norm() + slides + 2.0 * between;
        let tips = task.path.pieces.iter().flat_map(|piece| match &piece.geometry {
            PieceGeometry::Curve(curve) => {
                curve.knots.iter().filter_map(|&u| curve.pose(u)).map(|pose| pose.tip).collect()
            }
            PieceGeometry::Reorient { from, to } => vec![from.tip, to.tip],
        });
        let path = tips.fold(0.0_f64, |far, tip| far.max(tip.coords.norm()));
        Self { stiffness: stiffness(task.kinematics), rotaries: [far(first), far(second)], path }
    }
}

/// Returns the largest move of a linear axis that moves the tip by one, over positions of the rotaries.
fn stiffness(kinematics: &Kinematics) -> f64 {
    const EACH: u32 = 8;
    let mut most: f64 = 0.0;
    for place in 0..EACH * EACH {
        let mut q = AxisVector::zeros();
        q[FIRST_ROTARY] = TAU * f64::from(place / EACH) / f64::from(EACH);
        q[SECOND_ROTARY] = TAU * f64::from(place % EACH) / f64::from(EACH);
        let zero = kinematics.forward(&q).tip;
        let column = |slide: usize| {
            let mut moved = q;
            moved[slide] = 1.0;
            kinematics.forward(&moved).tip - zero
        };
        // Derivatives of the tip by the linear axes; a row of the inverse gives one axis per tip move.
        let columns = Matrix3::from_columns(&[column(0), column(1), column(2)]);
        let Some(inverse) = columns.try_inverse() else { return f64::INFINITY };
        most = inverse.row_iter().fold(most, |most, row| most.max(row.norm()));
    }
    most
}

/// Cells still to be halved.
#[derive(Debug, Default)]
struct CellQueue {
    heap: BinaryHeap<QueueEntry>,
    added: usize,
    /// Largest bound first; else largest cells first, so that a rotation that fits is found soon.
    by_bound: bool,
}

#[derive(Debug, Clone, Copy)]
struct QueueEntry {
    key: f64,
    order: usize,
    open: OpenCell,
}

impl CellQueue {
    fn add(&mut self, open: Vec<OpenCell>) {
        for open in open {
            let key = if self.by_bound { open.bound } else { open.ball.radius };
            self.heap.push(QueueEntry { key, order: self.added, open });
            self.added += 1;
        }
    }

    fn sort_by_bound(&mut self) {
        if !self.by_bound {
            self.by_bound = true;
            let entries = std::mem::take(&mut self.heap);
            let by_bound = |entry: QueueEntry| QueueEntry { key: entry.open.bound, ..entry };
            self.heap = entries.into_iter().map(by_bound).collect();
        }
    }

    /// Takes up to [`BATCH`] of the first cells that may be better than `target`.
    fn take(&mut self, target: f64) -> Vec<OpenCell> {
        let mut taken = Vec::new();
        while taken.len() < BATCH && self.heap.peek().is_some_and(|entry| entry.open.bound > target)
        {
            taken.extend(self.heap.pop().map(|entry| entry.open));
        }
        taken
    }

    /// Returns the largest bound of all cells.
    fn bound(&self) -> Option<f64> {
        self.heap.iter().map(|entry| entry.open.bound).reduce(f64::max)
    }
}

impl PartialEq for QueueEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for QueueEntry {}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for QueueEntry {
    /// Orders by key; of equal keys the cell added first.
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then(other.order.cmp(&self.order))
    }
}
