//! Moves of an input in batches, so that one batch can be read while the one before is posted.

use super::moves::Input;
use crate::outcome::Failure;
use crate::post::head::HeadState;
use trunnion::post::{PostMove, PostSource};

/// Most moves of a batch.
const BATCH: usize = 4096;

/// Move of an input, and the state of its control there.
#[derive(Debug, Clone, Copy)]
pub(in crate::post) struct InputMove {
    pub(in crate::post) one: PostMove,
    pub(in crate::post) state: HeadState,
}

/// Consecutive moves of one tool.
#[derive(Debug)]
pub(in crate::post) struct InputBatch {
    pub(in crate::post) moves: Vec<InputMove>,
    /// Tool that makes them.
    pub(in crate::post) tool: Option<u32>,
    /// Source of the moves, with that tool in the spindle.
    pub(in crate::post) source: PostSource,
    /// Failure of the input behind the moves.
    pub(in crate::post) failure: Option<Failure>,
}

/// Reader of batches.
pub(in crate::post) struct BatchReader<'a> {
    pub(in crate::post) input: Input<'a>,
    /// First move of the next tool.
    held: Option<InputMove>,
}

impl<'a> BatchReader<'a> {
    pub(in crate::post) fn new(input: Input<'a>) -> Self {
        Self { input, held: None }
    }

    /// Reads the next batch; `None` at the end.
    pub(in crate::post) fn next(&mut self) -> Option<InputBatch> {
        let first = match self.held.take() {
            Some(first) => first,
            None => match self.step() {
                Ok(first) => first?,
                Err(failure) => return Some(self.batch(Vec::new(), Some(failure))),
            },
        };
        let mut batch = self.batch(Vec::with_capacity(BATCH), None);
        batch.moves.push(first);
        while batch.moves.len() < BATCH {
            match self.step() {
                Ok(Some(next)) if self.input.tool() != batch.tool => {
                    self.held = Some(next);
                    break;
                }
                Ok(Some(next)) => batch.moves.push(next),
                Ok(None) => break,
                Err(failure) => {
                    batch.failure = Some(failure);
                    break;
                }
            }
        }
        Some(batch)
    }

    /// Starts a batch with the tool that is in the spindle.
    fn batch(&self, moves: Vec<InputMove>, failure: Option<Failure>) -> InputBatch {
        InputBatch { moves, tool: self.input.tool(), source: self.input.source(), failure }
    }

    fn step(&mut self) -> Result<Option<InputMove>, Failure> {
        let next = self.input.next()?;
        Ok(next.map(|one| InputMove { one, state: self.input.state() }))
    }
}
