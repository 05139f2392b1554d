//! Moves of an input, as they are posted.

use super::args::PostArgs;
use super::input::Input;
use super::plan::Plan;
use crate::outcome::Failure;
use trunnion::post::PostMove;
use trunnion::types::Progress;

/// Reads all moves of an input.
pub(crate) fn moves(args: &PostArgs, progress: &dyn Progress) -> Result<Vec<PostMove>, Failure> {
    let (Some(path), Some(machine)) = (&args.input, &args.machine) else {
        return Err(Failure::input("an input and a machine are needed"));
    };
    let Plan { from_machine, from_words, input_options, .. } = Plan::new(args, machine)?;
    let mut input = Input::open(path, &from_machine, from_words, &input_options, progress)?;
    let mut moves = Vec::new();
    while let Some(one) = input.next()? {
        moves.push(one);
    }
    input.warn();
    Ok(moves)
}
