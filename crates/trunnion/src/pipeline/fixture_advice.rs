//! Advice for programs that come too near fixtures.

use super::job::Job;
use super::program::CheckedProgram;
use crate::cover;
use crate::files::job;

/// Returns advice if programs of the job come too near fixtures.
pub(super) fn remedy(job: &Job, programs: &[CheckedProgram]) -> Option<String> {
    let [links, cuts] = [0, 1].map(|of| programs.iter().any(|program| program.too_near[of]));
    let links = links.then(|| over(job));
    let cuts = cuts.then(|| {
        "cuts or their leads come too near: move the fixture or the part, or take a longer tool or a slimmer holder"
            .to_owned()
    });
    let what: Vec<String> = [links, cuts].into_iter().flatten().collect();
    (!what.is_empty()).then(|| format!("passes and links keep off fixtures where they are planned, but the program does not everywhere; {}", what.join("; ")))
}

/// Returns advice for links: the clearance that passes over the tallest fixture, or another link strategy.
fn over(job: &Job) -> String {
    let (up, file) = (job.up(), &job.file);
    let clearance = file.setup.clearance;
    let links = job.highest(&up) + clearance;
    let tops = job.fixtures.iter().filter_map(|held| {
        let bounds = held.solid.as_ref()?.bounds()?;
        Some((cover::height(&[bounds], &up) + held.allowance, &held.name))
    });
    let tallest = tops.max_by(|a, b| a.0.total_cmp(&b.0));
    let higher = tallest.map(|(top, name)| (top - links, name)).filter(|(above, _)| *above > 0.0);
    if let Some((above, name)) = higher {
        // Raising the plane by `above` puts it level with the fixture's top.
        let least = clearance + above + file.fixture_clearance;
        return format!(
            "links come too near: {name} stands {above:.3} mm higher than they travel; setup.clearance, {clearance} mm now, \
             above {least:.3} mm passes over it"
        );
    }
    match file.strategy.links {
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
