//! The methods of `trunnion feed`.

use super::args::{FeedArgs, FeedMethod};
use super::path::Table;
use trunnion::feed::{
    self, FeedError, FeedOptions, FeedPlan, FeedStream, GivenSpeed, LimitBreach, Limits, LookAhead,
    LookAheadOptions, RowCount, StreamOptions,
};
use trunnion::types::{AxisNode, AxisPath, Progress};

/// Look-ahead of paper 001: a number of blocks at first, extended until they last a number of periods.
const BLOCKS_AHEAD: LookAhead = LookAhead::Dynamic { blocks: 5, periods: 1000.0 };

/// Least number of rows of a streamed path: longer stretches between rows of the table are divided.
pub(super) const LEAST_ROWS: f64 = 128.0;

/// Path and limits that a method plans with.
pub(super) struct PlanInput<'a, const N: usize> {
    pub(super) path: &'a AxisPath<N>,
    /// Table of the path, with the column `speed` of `--method given`.
    pub(super) table: &'a Table,
    pub(super) limits: &'a Limits<N>,
    pub(super) options: &'a FeedOptions,
}

/// A path with its schedule.
pub(super) struct Planned<'a, const N: usize> {
    pub(super) path: &'a AxisPath<N>,
    pub(super) plan: FeedPlan,
    /// Stretches on which a given speed breaks a limit.
    pub(super) breaches: Vec<LimitBreach>,
    /// Wall-clock time of planning \[s\].
    pub(super) seconds: f64,
}

/// Plans by the method of the arguments; breaches occur with given speeds only.
pub(super) fn plan<const N: usize>(
    args: &FeedArgs,
    input: &PlanInput<'_, N>,
    progress: &dyn Progress,
) -> Result<(FeedPlan, Vec<LimitBreach>), FeedError> {
    let PlanInput { path, table, limits, options } = *input;
    let unbroken = |plan| (plan, Vec::new());
    match (args.method, args.window) {
        (FeedMethod::Optimal, Some(rows)) => {
            let speeds = streamed(input, rows as usize, progress)?;
            // The speeds of the stream are measured and bounded as given speeds are.
            let (plan, _) = feed::given(path, &speeds, limits, options, progress)?;
            Ok(unbroken(plan))
        }
        (FeedMethod::Optimal, None) => feed::optimal(path, limits, options, progress).map(unbroken),
        (FeedMethod::Jerk, Some(rows)) => {
            feed::jerk_through_window(path, limits, options, rows as usize, progress).map(unbroken)
        }
        (FeedMethod::Jerk, None) => feed::jerk(path, limits, options, progress).map(unbroken),
        (FeedMethod::Blocks, _) => {
            let blocks =
                LookAheadOptions { ahead: BLOCKS_AHEAD, ..LookAheadOptions::whole(args.period) };
            feed::blocks(path, limits, options, &blocks, progress).map(unbroken)
        }
        (FeedMethod::Given, _) => feed::given(path, &table.speeds(path), limits, options, progress),
    }
}

/// Returns the speeds of a path that is planned row by row through a window.
fn streamed<const N: usize>(
    input: &PlanInput<'_, N>,
    window: usize,
    progress: &dyn Progress,
) -> Result<Vec<GivenSpeed>, FeedError> {
    let PlanInput { path, limits, options, .. } = *input;
    let ends = |nodes: &[AxisNode<N>]| Some(nodes.last()?.s - nodes.first()?.s);
    let length: f64 = path.pieces.iter().filter_map(|piece| ends(&piece.nodes)).sum();
    let step = length / LEAST_ROWS;
    let window = StreamOptions { speeds: options.speeds, ..StreamOptions::fastest(window, step) };
    let mut stream = FeedStream::new(*limits, window)?;
    let mut speeds = vec![GivenSpeed::default(); path.pieces.len()];
    let mut nodes = path.pieces.iter().flat_map(|piece| {
        piece.nodes.iter().enumerate().map(|(index, node)| (index == 0, piece.motion, node))
    });
    let mut rows = RowCount::of(path);
    loop {
        while stream.wants() {
            let Some((first, motion, node)) = nodes.next() else { break };
            rows.report(progress)?;
            if first {
                stream.begin(motion);
            }
            stream.push(*node)?;
        }
        let Some(step) = stream.next() else { break };
        let Some(given) = speeds.get_mut(step.piece) else { break };
        if given.s.is_empty() {
            given.s.push(step.s.low);
            given.speed.push(step.speed.start);
        }
        given.s.push(step.s.high);
        given.speed.push(step.speed.end);
    }
    Ok(speeds)
}
