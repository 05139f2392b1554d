//! Stages of a run: one call each, with options from the job and its budget.

use super::error::PipelineError;
use super::estimate::{TravelEstimate, rest_to_rest};
use super::guards::{fixture_boxes, guarded_faces};
use super::job::Job;
use super::pass_cost::{JobPassCost, LinearTravel, inset};
use super::tolerances::{LINK_TOLERANCE, QUINTIC_SHARE};
use crate::axes::{
    self, AxesOptions, FeedPoint, FollowedPath, RetractOptions, SetupOptions, SetupSearch,
    SingularOptions, TiltBounds,
};
use crate::cover::{
    self, AxisReach, CoverOptions, CoverRequest, Covering, CutPattern, FeedDirection,
    FinishTolerance, HopOptions, JoinedPasses, LeftArea, LinkOptions, LinkRequest, PlacementMethod,
    PrismaticUse,
};
use crate::feed::{
    self, FeedError, FeedOptions, FeedPlan, Limits, LookAhead, LookAheadOptions, ProgrammedSpeeds,
};
use crate::files::job as file;
use crate::files::summary::SingularSummary;
use crate::inverse::Inverse;
use crate::machine::{AxisKind, SingularPolicy};
use crate::positioning::{ContactSide, ToleranceBand, ToolInclination};
use crate::post::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS, smoothing_tolerance};
use crate::surface::FaceIndex;
use crate::toolpath::{self, SmoothOptions, SmoothReference, SmoothedPath, ToolPathOptions};
use crate::types::{AXES, AxisPath, Leg, Pass, PoseTolerance, Progress, ToolPath, ToolPose};
use nalgebra::{Point3, UnitVector3};

/// Largest rotary move between two nodes of the axis path \[rad\].
const MAX_ROTARY_STEP: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Time still to gain at which the planner stops inserting rows \[s\].
const TIME_TOLERANCE: f64 = 1e-3;

/// Look-ahead of the classical planner: blocks and servo periods at least, as in paper 001.
const LEAST_BLOCKS: usize = 5;
const WINDOW: f64 = 1000.0;

/// Rows of `motion.csv` at most: some 4 GB, five hours at a millisecond.
const ROWS: f64 = 2e7;

/// Refuses a schedule with more setpoints than anybody could use.
pub(super) fn rows(job: &Job, plan: &FeedPlan) -> Result<(), PipelineError> {
    let duration = plan.schedule.duration();
    let rows = duration / job.file.motion.servo_period;
    if rows <= ROWS {
        return Ok(());
    }
    Err(PipelineError::Rows { duration, rows, most: ROWS, period: duration / ROWS })
}

/// Places the passes over the faces.
pub(super) fn cover(job: &Job, progress: &dyn Progress) -> Result<Covering, PipelineError> {
    cover_area(job, CoverArea::of(job), progress)
}

/// Places passes over the area that operations before have left.
pub(super) fn cover_left(
    job: &Job,
    left: LeftArea<'_>,
    progress: &dyn Progress,
) -> Result<Covering, PipelineError> {
    cover_area(job, CoverArea { left: Some(left), ..CoverArea::of(job) }, progress)
}

/// Passes with another limit of the turn of the tool axis \[rad/mm\].
pub(super) fn cover_turning(
    job: &Job,
    max_axis_turn: f64,
    progress: &dyn Progress,
) -> Result<Covering, PipelineError> {
    cover_area(job, CoverArea { max_axis_turn, left: None }, progress)
}

/// Area of the passes, and limit of the turn of the tool axis.
#[derive(Clone, Copy)]
struct CoverArea<'a> {
    /// Area that operations before have left; `None`: all of the faces.
    left: Option<LeftArea<'a>>,
    /// \[rad/mm\]
    max_axis_turn: f64,
}

impl CoverArea<'_> {
    fn of(job: &Job) -> Self {
        Self { left: None, max_axis_turn: job.file.strategy.max_axis_turn }
    }
}

fn cover_area(
    job: &Job,
    area: CoverArea<'_>,
    progress: &dyn Progress,
) -> Result<Covering, PipelineError> {
    let covering = with_request(job, area, |request| cover::cover(request, progress))?;
    Ok(without_shallow(job, covering))
}

/// Takes passes out of a covering, by their indices, and measures what is left of its faces, or of the area that operations
/// before have left.
pub(super) fn cover_without(
    job: &Job,
    left: Option<LeftArea<'_>>,
    covering: Covering,
    indices: &[usize],
) -> Covering {
    let area = CoverArea { left, ..CoverArea::of(job) };
    without_shallow(
        job,
        with_request(job, area, |request| cover::without(request, covering, indices)),
    )
}

/// Leaves the decision about spots that are within the tolerance, but above the strips' share, to the inspection of the
/// program.
fn without_shallow(job: &Job, mut covering: Covering) -> Covering {
    covering.report.rest.retain(|part| part.depth > job.budget.total);
    covering
}

/// Calls a function with the request for passes.
fn with_request<T>(job: &Job, area: CoverArea<'_>, call: impl FnOnce(&CoverRequest<'_>) -> T) -> T {
    let CoverArea { left, max_axis_turn } = area;
    let strategy = &job.file.strategy;
    let tolerance = FinishTolerance { excess: job.budget.total, gouge: job.budget.gouge };
    let preset = CoverOptions::finishing(&job.cutter, tolerance);
    let (method, lean) = match strategy.method {
        // A barrel has one inclination at which its arc touches with its middle.
        file::JobPlacement::Widest if job.cutter.is_barrel() => {
            (PlacementMethod::Inclined, preset.lean)
        }
        file::JobPlacement::Widest => (PlacementMethod::Widest, preset.lean),
        file::JobPlacement::Leaning { angle } => {
            (PlacementMethod::Inclined, ToolInclination { angle, towards: None })
        }
        file::JobPlacement::Fixed { lead, tilt } => {
            (PlacementMethod::Inclined, ToolInclination::of(lead, tilt))
        }
    };
    let options = CoverOptions {
        feed_direction: match strategy.along {
            file::JobFeedDirection::U => FeedDirection::U,
            file::JobFeedDirection::V => FeedDirection::V,
            file::JobFeedDirection::Curvature => FeedDirection::Curvature,
            file::JobFeedDirection::Adaptive => FeedDirection::Adaptive,
        },
        pattern: match strategy.direction {
            file::JobCutPattern::Zigzag => CutPattern::ZigZag,
            file::JobCutPattern::OneWay => CutPattern::OneWay,
        },
        method,
        prismatic: match strategy.prismatic {
            file::JobPrismatic::Never => PrismaticUse::Never,
            file::JobPrismatic::WallsAndFloors => PrismaticUse::WallsAndFloors,
            file::JobPrismatic::Flank => PrismaticUse::Flank,
        },
        side: match strategy.side {
            file::JobContactSide::Ahead => ContactSide::Ahead,
            file::JobContactSide::Behind => ContactSide::Behind,
            file::JobContactSide::Either => ContactSide::Either,
        },
        band: ToleranceBand { lower: job.budget.lower, upper: job.budget.upper },
        excess: job.budget.covered(),
        link: link_length(job),
        path_share: job.budget.shares.path,
        max_axis_turn,
        offset_range: strategy.offset_range.unwrap_or(preset.offset_range),
        lean,
        ..preset
    };
    // Candidate passes are compared by their time on this machine, not by their length.
    let cost = JobPassCost::new(job, options.link);
    let others = guarded_faces(job);
    let request = CoverRequest {
        others: &others,
        left,
        cost: Some(&cost),
        ..CoverRequest::new(&job.faces, &job.cutter, &options)
    };
    call(&request)
}

/// Returns true if the tool may hop; where stock may be anywhere, it links above all of it.
fn hop(job: &Job) -> bool {
    job.file.strategy.links == file::JobLinks::Hop && job.approach().is_finite()
}

/// Estimates the time between two passes, as the length cut in that time \[mm\].
///
/// With hops it is a hop as high as the approach or as wide as the cutter, whichever takes longer, and about as much
/// again for accelerating and braking on the pass (measured on passes of 60 mm: 0.6 s and 0.3 s). Without hops it is
/// the leads up to the clearance plane from half the height of the part, and as far again along it as the turn of the
/// tool takes, each from rest to rest.
fn link_length(job: &Job) -> f64 {
    let (machine, up, approach) = (job.kinematics.machine(), job.up(), job.approach());
    let slowest =
        |way: f64| machine.axes[..3].iter().map(|axis| rest_to_rest(axis, way)).fold(0.0, f64::max);
    let feed = job.file.cutting.feed;
    // Twice the hop: once for the hop itself, once for braking and accelerating on the pass.
    if hop(job) {
        return 2.0 * feed * slowest(2.0 * approach.max(job.cutter.radius()));
    }
    // Half the height of the part along `up`: highest(up) - lowest(up) = highest(up) + highest(-up).
    let below = 0.5 * (job.highest(&up) + job.highest(&-up));
    let way = below + job.file.setup.clearance;
    2.0 * way + 3.0 * feed * slowest(way)
}

/// Adds leads and links to the passes, as far as there are any.
pub(super) fn join(
    job: &Job,
    passes: &[Pass],
    progress: &dyn Progress,
) -> Result<JoinedPasses, PipelineError> {
    let lead = match job.file.strategy.lead {
        file::JobLead::Axis => cover::LeadKind::Axis,
        file::JobLead::Tangent => cover::LeadKind::Tangent { length: job.cutter.radius() },
    };
    let approach = job.approach();
    let options = LinkOptions {
        up: job.up(),
        boxes: job.boxes().into_iter().chain(fixture_boxes(job)).collect(),
        // Even stock is not in the boxes: links rise above it by its thickness.
        clearance: job.file.setup.clearance + job.thickness(),
        lead,
        approach,
        gouge: job.budget.link_gouge(),
    };
    let estimate = TravelEstimate::new(&job.kinematics);
    // A pose without a solution makes a hop infinitely long, so that the retract wins.
    let seconds =
        |poses: &[ToolPose]| estimate.as_ref().map_or(f64::INFINITY, |e| e.seconds(poses));
    let feed = Some(job.file.cutting.feed);
    let hops = HopOptions { feed, ..HopOptions::new(approach, &seconds) };
    let hops = Some(hops).filter(|_| hop(job));
    // Without ends of linear travel the direction alone decides, and any tip will do.
    let directions = Inverse::new(&inset(&job.kinematics, LinearTravel::Unbounded)).ok();
    let at_home = job.kinematics.machine().home();
    let reaches = |axis: &UnitVector3<f64>| {
        let pose = ToolPose { tip: Point3::origin(), axis: *axis };
        directions.as_ref().is_none_or(|inverse| inverse.continued(&pose, &at_home).is_ok())
    };
    let home = job.kinematics.forward(&job.kinematics.machine().home()).axis;
    let faces: Vec<FaceIndex> = job.faces.iter().cloned().chain(guarded_faces(job)).collect();
    let request = LinkRequest {
        hops,
        reach: Some(AxisReach { home, reaches: &reaches }),
        ..LinkRequest::new(passes, &faces, &job.cutter, &options)
    };
    Ok(cover::join(&request, progress)?)
}

/// Fits curves through the cutter locations, smoothed if the job asks for it.
pub(super) fn tool_path(
    job: &Job,
    legs: &[Leg],
    progress: &dyn Progress,
) -> Result<SmoothedPath, PipelineError> {
    let lever = cover::lever(&job.cutter);
    let options = ToolPathOptions::with_lever(lever);
    let share = job.budget.shares.smoothing;
    // Without a share the curves pass through the cutter locations exactly.
    if share <= 0.0 {
        let path = toolpath::through(legs, &options, progress)?;
        return Ok(SmoothedPath { path, ..SmoothedPath::default() });
    }
    let PoseTolerance { tip, axis } = smoothing_tolerance(share, lever);
    let smoothing = SmoothOptions {
        tip,
        axis,
        reference: SmoothReference::Curve,
        lever,
        corner: CORNER,
        step_ratio: STEP_RATIO,
        largest_blend: LARGEST_BLEND,
        window: WINDOW_STATIONS,
    };
    Ok(toolpath::smoothed(legs, &options, &smoothing, progress)?)
}

/// Follows the curves with the axes of the machine.
pub(super) fn axes(
    job: &Job,
    path: &ToolPath,
    progress: &dyn Progress,
) -> Result<FollowedPath, PipelineError> {
    Ok(axes::follow(&job.kinematics, path, &axes_options(job), progress)?)
}

/// Grid of a setup search, angle to which its best are refined, and angle within which two are alike \[rad\].
const SETUP_ANGLES: [f64; 3] = [5.0 * DEGREE, 0.05 * DEGREE, 1.0 * DEGREE];

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Digits of a setup in reports: a tenth of a millimetre, a hundredth of a degree.
const SETUP_DIGITS: [f64; 2] = [0.1, 0.01];

/// Number of setups with about the same least angle that are planned.
const SETUP_BATCH: usize = 8;

/// Largest improvement that the search may miss \[rad\].
pub const SETUP_WITHIN: f64 = 0.1 * DEGREE;

/// Improvement over the best setup below which a search is complete \[rad\].
///
/// It is the improvement that the search may miss, plus the angle given up for less rotary travel.
pub const SETUP_SHOWN: f64 = SETUP_WITHIN + SETUP_ANGLES[2];

/// Most rotations examined and planned to prove that: some seconds.
const SETUP_MOST: [usize; 2] = [400_000, 500];

/// Searches the setup for a path within bounds.
pub(super) fn search(
    job: &Job,
    path: &ToolPath,
    bounds: &TiltBounds,
    progress: &dyn Progress,
) -> Result<SetupSearch, PipelineError> {
    let [grid, tolerance, alike] = SETUP_ANGLES;
    let [most_evaluated, most_planned] = SETUP_MOST;
    let [origin_digit, rotation_digit] = SETUP_DIGITS;
    let search = SetupOptions {
        bounds: *bounds,
        grid,
        tolerance,
        alike,
        batch: SETUP_BATCH,
        within: SETUP_WITHIN,
        most_evaluated,
        most_planned,
        origin_digit,
        rotation_digit,
    };
    Ok(axes::setup(&job.kinematics, path, &axes_options(job), &search, progress)?)
}

/// Returns the time saved by moving the tool axis at singular directions: the same path is planned without.
pub(super) fn singular_gain(
    job: &Job,
    path: &ToolPath,
    followed: &FollowedPath,
    plan: &FeedPlan,
    progress: &dyn Progress,
) -> Result<Option<SingularSummary>, PipelineError> {
    let passages = &followed.passages;
    if passages.is_empty() {
        return Ok(None);
    }
    // The same path with the tool axis as programmed, through the same planner.
    let options = AxesOptions { singular: None, ..axes_options(job) };
    let plain = axes::follow(&job.kinematics, path, &options, progress)?;
    let without = feed(job, &plain.path, progress)?;
    let saved: f64 = passages.iter().map(|one| one.turn_before - one.turn_after).sum();
    Ok(Some(SingularSummary {
        passages: passages.len(),
        // A passage that comes nearer to the direction than before goes straight through it.
        through: passages.iter().filter(|one| one.distance_after < one.distance_before).count(),
        tilt: passages.iter().map(|one| one.tilt.to_degrees()).fold(0.0, f64::max),
        turn_saved: saved.to_degrees(),
        seconds_saved: without.schedule.duration() - plan.schedule.duration(),
    }))
}

fn axes_options(job: &Job) -> AxesOptions {
    // The quintic takes its share for the tip and, over the lever, again for the tool axis.
    let tip_tolerance = QUINTIC_SHARE * job.budget.shares.linearisation;
    let machine = job.kinematics.machine();
    let slowest = machine.axes[3].vel.min(machine.axes[4].vel);
    let axis_tolerance = tip_tolerance / cover::lever(&job.cutter);
    AxesOptions {
        tolerance: PoseTolerance::new(tip_tolerance, axis_tolerance),
        max_rotary_step: MAX_ROTARY_STEP,
        feed_at: match job.file.cutting.reference {
            file::FeedReference::Contact => FeedPoint::Contact,
            file::FeedReference::Tip => FeedPoint::Tip,
        },
        // Travel weighed by time: a slow axis counts fully, a fast one less.
        rotary_weights: [3, 4].map(|axis| slowest / machine.axes[axis].vel).into(),
        start: machine.home(),
        retract: Some(retract(job)),
        singular: singular(job),
    }
}

/// Returns the options at singular directions: cone and smallest move of the machine, and the largest tilt.
///
/// The tilt is the share of the job, up to the tolerance of the machine, over the lever from tip to contact.
fn singular(job: &Job) -> Option<SingularOptions> {
    let SingularPolicy { cone, min_rotary, tolerance } = job.kinematics.machine().singular;
    // Turning by `tilt` moves the contact by up to lever times tilt.
    let share = job.budget.shares.singular.min(tolerance);
    let tilt = share / cover::lever(&job.cutter);
    (share > 0.0).then_some(SingularOptions { cone, min_rotary, tilt })
}

/// Returns the options for retracts where travel ends; the tool turns at the height of links.
fn retract(job: &Job) -> RetractOptions {
    let up = job.up();
    let radius = job.cutter.radius();
    // The tool turns about its tip there: its side reaches down by the radius.
    let plane = job.highest(&up) + job.file.setup.clearance + radius;
    RetractOptions {
        least: radius,
        approach: job.approach(),
        margin: LINK_TOLERANCE,
        ..RetractOptions::to_plane(up, plane)
    }
}

/// Plans the speeds.
pub(super) fn feed(
    job: &Job,
    path: &AxisPath,
    progress: &dyn Progress,
) -> Result<FeedPlan, PipelineError> {
    let machine = job.kinematics.machine();
    let (limits, chords) = motion_limits(job)?;
    let options = FeedOptions {
        speeds: ProgrammedSpeeds {
            feed: Some(job.file.cutting.feed),
            tip: machine.cycle.tip_speed_max,
            ..ProgrammedSpeeds::FASTEST
        },
        time_tolerance: TIME_TOLERANCE,
        ..FeedOptions::fastest()
    };
    let mut plan = match job.file.motion.method {
        file::MotionMethod::Jerk => feed::jerk(path, &limits, &options, progress)?,
        file::MotionMethod::Optimal => feed::optimal(path, &limits, &options, progress)?,
        file::MotionMethod::Blocks => {
            let classical = LookAheadOptions {
                period: job.file.motion.servo_period,
                ahead: LookAhead::Dynamic { blocks: LEAST_BLOCKS, periods: WINDOW },
                tiny: None,
            };
            feed::blocks(path, &limits, &options, &classical, progress)?
        }
    };
    // An acceleration limit that the chord error lowered is reported as a chord limit.
    plan.name_chords(chords);
    Ok(plan)
}

/// Returns the limits of the axes for the motion of a job.
///
/// The flags mark the axes whose acceleration the requested chord error lowers.
///
/// # Errors
///
/// [`FeedError::BadChord`].
pub fn motion_limits(job: &Job) -> Result<(Limits<AXES>, [bool; AXES]), FeedError> {
    let machine = job.kinematics.machine();
    let own = Limits {
        velocity: machine.vector(|axis| axis.vel),
        rapid: machine.vector(|axis| axis.rapid),
        acceleration: machine.vector(|axis| axis.acc),
        jerk: Some(machine.vector(|axis| axis.jerk)),
        minus: None,
    };
    let motion = &job.file.motion;
    // Infinite without a request: 8 chord / period² then lowers nothing.
    let chords = machine.vector(|axis| {
        let rotary = axis.kind == AxisKind::Rotary;
        motion.chord[usize::from(rotary)].unwrap_or(f64::INFINITY)
    });
    let limits = own.with_chord_error(&chords, motion.servo_period)?;
    Ok((limits, limits.lowered_from(&own)))
}
