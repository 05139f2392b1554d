//! A path that is known as a whole, planned through a window.

use super::jerk_stream::JerkStream;
use super::options::StreamOptions;
use crate::feed::error::FeedError;
use crate::feed::jerk::known_of;
use crate::feed::limits::Limits;
use crate::feed::options::FeedOptions;
use crate::feed::pieces::{PlannedPiece, assemble};
use crate::feed::plan::FeedPlan;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::feed::validate;
use crate::types::{AccelerationProfile, AxisPath, AxisPiece, Progress, SchedulePiece, Stage};

/// Rows between two reports: some hundredths of a second with jerk limits.
const ROWS_A_REPORT: u64 = 64;

/// Plans within jerk limits through a window of so many rows, as a [`JerkStream`] does; from rest
/// to rest.
///
/// # Errors
///
/// As [`jerk()`](crate::feed::jerk()), and [`FeedError::BadWindow`]; [`FeedError::Cancelled`] if `progress` stops it, which
/// hears of the rows taken.
pub fn jerk_through_window<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
    window: usize,
    progress: &dyn Progress,
) -> Result<FeedPlan, FeedError> {
    validate::validate(path, limits, options)?;
    let stream_options = StreamOptions { speeds: options.speeds, window, step: f64::MAX };
    let mut stream = JerkStream::new(*limits, stream_options)?;
    let mut nodes = path.pieces.iter().flat_map(|piece| {
        piece.nodes.iter().enumerate().map(|(index, node)| (index, piece.motion, node))
    });
    let mut pieces =
        vec![
            SchedulePiece { profile: AccelerationProfile::Linear, ..SchedulePiece::default() };
            path.pieces.len()
        ];
    let (mut started, mut rows) = (None, RowCount::of(path));
    loop {
        while stream.wants() {
            let Some((index, motion, node)) = nodes.next() else { break };
            rows.report(progress)?;
            if index == 0 {
                stream.begin(motion);
            }
            stream.push(*node)?;
        }
        let Some(step) = stream.next() else { break };
        let Some(piece) = pieces.get_mut(step.piece) else { break };
        // Times count from the start of each piece, as in a plan of the whole path.
        if started != Some(step.piece) {
            started = Some(step.piece);
            row(piece, [step.s.low, 0.0, step.speed.start, step.acceleration]);
        }
        let t = piece.t.last().copied().unwrap_or(0.0) + step.duration;
        row(piece, [step.s.high, t, step.speed.end, step.end_acceleration]);
    }
    // A stream that stops short has no error of its own.
    let ends = |piece: &AxisPiece<N>| piece.nodes.last().map(|node| node.s);
    let short =
        |(piece, run): (&AxisPiece<N>, &SchedulePiece)| run.s.last().copied() != ends(piece);
    if let Some(piece) = path.pieces.iter().zip(&pieces).position(short) {
        return Err(FeedError::Unresolved { piece });
    }
    let bounds = stream.bounds();
    let planned = path.pieces.iter().zip(pieces).map(|(piece, schedule)| {
        let limits = ReciprocalLimits::new(piece.motion, &limits.smaller(), options);
        PlannedPiece { bounds, ..known_of(piece, schedule, &limits) }
    });
    assemble(planned.collect())
}

/// Count of the rows that a stream has taken.
#[derive(Debug, Clone, Copy)]
pub struct RowCount {
    taken: u64,
    total: u64,
}

impl RowCount {
    /// Begins at the first row of a path.
    pub fn of<const N: usize>(path: &AxisPath<N>) -> Self {
        Self { taken: 0, total: path.pieces.iter().map(|piece| piece.nodes.len() as u64).sum() }
    }

    /// Counts a row, and reports some of them.
    ///
    /// # Errors
    ///
    /// [`FeedError::Cancelled`] if `progress` stops the stage.
    pub fn report(&mut self, progress: &dyn Progress) -> Result<(), FeedError> {
        if self.taken.is_multiple_of(ROWS_A_REPORT) {
            progress.step(Stage::Feed, self.taken, self.total)?;
        }
        self.taken += 1;
        Ok(())
    }
}

/// Appends a row to a schedule.
fn row(piece: &mut SchedulePiece, [s, t, speed, acceleration]: [f64; 4]) {
    piece.s.push(s);
    piece.t.push(t);
    piece.speed.push(speed);
    piece.acceleration.push(acceleration);
}
