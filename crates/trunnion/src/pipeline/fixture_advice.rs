//! Advice for programs that come too near fixtures.

use super::job::Job;
use super::program::{CheckedProgram, NearMoves};
use crate::files::job;

/// Returns advice if programs of the job come too near fixtures.
pub(super) fn remedy(job: &Job, programs: &[CheckedProgram]) -> Option<String> {
    let near = programs.iter().map(|program| program.too_near);
    let NearMoves { links, cuts } = near.fold(NearMoves::default(), NearMoves::or);
    let links = links.then(|| over(job));
    let cuts = cuts.then(|| {
        "cuts or their leads come too near: move the fixture or the part, or take a longer tool or a slimmer holder"
            .to_owned()
    });
    let what: Vec<String> = [links, cuts].into_iter().flatten().collect();
    (!what.is_empty()).then(|| format!("fixtures: {}", what.join("; ")))
}

/// Returns advice for links: another link strategy.
fn over(job: &Job) -> String {
    match job.file.strategy.links {
        job::JobLinks::Hop => {
            "links come too near below the height at which they travel: strategy.links = \"retract\" keeps them up from pass \
             to pass; where they come down to one, move the fixture or the part"
        }
        job::JobLinks::Retract => {
            "links come too near where they come down to a pass: move the fixture or the part"
        }
    }
    .to_owned()
}
