//! Moves of an input, as they are posted.

use super::args::PostArgs;
use super::plan::Plan;
use crate::outcome::Failure;
use trunnion::post::PostMove;
use trunnion::types::Progress;

/// Moves of an input for callers in other languages.
#[derive(Debug)]
#[non_exhaustive]
pub struct MovesAnswer {
    /// All moves, in order.
    pub moves: Vec<PostMove>,
    /// Warnings about the input, as `trunnion post` prints them.
    pub warnings: Vec<String>,
}

/// Reads all moves of an input.
pub(crate) fn moves(args: &PostArgs, progress: &dyn Progress) -> Result<MovesAnswer, Failure> {
    let (Some(path), Some(machine)) = (&args.input, &args.machine) else {
        return Err(Failure::input("an input and a machine are needed"));
    };
    let mut input = Plan::new(args, machine)?.open(path, progress)?;
    let mut moves = Vec::new();
    while let Some(one) = input.next()? {
        moves.push(one);
    }
    input.warn();
    Ok(MovesAnswer { moves, warnings: input.take_warnings() })
}
