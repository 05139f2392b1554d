//! Places that a page lists.

use trunnion::files::summary::FixturesSummary;
use trunnion::pipeline;
use trunnion::verify::{self, ExtremeHeight, Finding};
use trunnion_report::WorstPlace;

/// Places of fixtures that are listed.
const TOUCHED: usize = 5;

/// Worst places of a check, and the nearest of those that come too near a fixture: first what has no tolerance, then by
/// how much of its tolerance (most material left, deepest gouge \[mm\]) each takes.
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
        kind: if extreme.height < 0.0 { "gouge" } else { name }.to_owned(),
        point: extreme.point.coords.into(),
        deviation: Some(extreme.height),
        note: extreme.to_string(),
    };
    let mut places: Vec<WorstPlace> =
        [("excess", &deviation.highest), ("least left", &deviation.lowest)]
            .iter()
            .filter_map(|(name, extreme)| extreme.as_ref().map(|extreme| place(name, extreme)))
            .collect();
    places.extend(fixtures.into_iter().flat_map(touched));
    for finding in &check.findings {
        if let Finding::Uncut { point, .. } = finding {
            let point = point.coords.into();
            let note = finding.to_string();
            places.push(WorstPlace { kind: "uncut".to_owned(), point, deviation: None, note });
        }
    }
    places.sort_by(|a, b| share(b).total_cmp(&share(a)));
    places
}

/// Places of fixtures, the nearest first.
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
