//! Worst points that a page lists.

use trunnion::files::summary::FixturesSummary;
use trunnion::pipeline;
use trunnion::verify::{self, ExtremeHeight, Finding};
use trunnion_report::WorstPlace;

/// Most approaches to fixtures that are listed.
const TOUCHED: usize = 5;

/// Returns the worst places of a check: first those without a tolerance (uncut, too near a fixture), then by the share
/// of the tolerance (excess, gouge \[mm\]) that each takes.
pub(crate) fn worst(
    check: &verify::Report,
    fixtures: Option<&FixturesSummary>,
    [total, gouge]: [f64; 2],
) -> Vec<WorstPlace> {
    let deviation = &check.deviation;
    let share = |place: &WorstPlace| match place.deviation {
        None => f64::INFINITY,
        Some(height) if height < 0.0 => -height / gouge.max(f64::MIN_POSITIVE),
        Some(height) => height / total.max(f64::MIN_POSITIVE),
    };
    let place = |name: &str, extreme: &ExtremeHeight| WorstPlace {
        // Both extremes may lie on the same side of the face: the sign decides.
        kind: if extreme.height < 0.0 { "gouge" } else { name }.to_owned(),
        point: extreme.point.coords.into(),
        deviation: Some(extreme.height),
        note: extreme.to_string(),
    };
    // All places that break a tolerance, and the extremes where none does.
    let broken = |finding: &Finding| match finding {
        Finding::Gouge(at) | Finding::Excess(at) => Some(*at),
        _ => None,
    };
    let broken: Vec<ExtremeHeight> = check.findings.iter().filter_map(broken).collect();
    let kept = [("excess", deviation.highest), ("lowest", deviation.lowest)].into_iter();
    let kept = kept.filter_map(|(name, extreme)| Some((name, extreme?)));
    let mut places: Vec<WorstPlace> = kept
        .filter(|(_, extreme)| !broken.contains(extreme))
        .map(|(name, extreme)| place(name, &extreme))
        .collect();
    places.extend(broken.iter().map(|at| place("excess", at)));
    places.extend(fixtures.into_iter().flat_map(touched));
    for finding in &check.findings {
        if let Finding::Uncut { point, .. } = finding {
            let point = point.coords.into();
            let note = finding.to_string();
            places.push(WorstPlace { kind: "uncut".to_owned(), point, deviation: None, note });
        }
    }
    // A stable sort: equal places keep the order above.
    places.sort_by(|a, b| share(b).total_cmp(&share(a)));
    places
}

/// Returns approaches to fixtures, the closest first.
fn touched(fixtures: &FixturesSummary) -> impl Iterator<Item = WorstPlace> + use<> {
    let mut near = fixtures.near.clone();
    near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    near.into_iter().take(TOUCHED).map(|near| WorstPlace {
        kind: "fixture".to_owned(),
        point: near.point,
        deviation: None,
        note: pipeline::approach(&near),
    })
}
