//! The page itself: a template, the bundled script and style, and the data, in one text.

use crate::data::{Budget, Number, ReportData, Solid, Surface, WorstPlace};
use crate::payload::Payload;
use crate::picture;
use minijinja::Environment;
use minijinja::value::Serde;
use serde::Serialize;

const TEMPLATE: &str = include_str!("../assets/report.html");
/// Built from `viewer/`; see its README.
const SCRIPT: &str = include_str!("../assets/viewer.js");
const STYLE: &str = include_str!("../assets/viewer.css");

/// Most places that are listed: more would hide the important ones.
const PLACES: usize = 20;

/// Reason why a page could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The data cannot be written as JSON.
    #[error("report data as JSON: {0}")]
    Data(#[from] serde_json::Error),
    /// The template cannot be filled.
    #[error("report page: {0}")]
    Template(#[from] minijinja::Error),
}

/// Content of the template.
#[derive(Debug, Serialize)]
struct Page<'a> {
    job: &'a str,
    part: &'a str,
    machine: &'a str,
    tool: &'a str,
    generator: &'a str,
    passed: bool,
    verdict: &'a [String],
    warnings: &'a [String],
    numbers: &'a [Number],
    headline: Vec<&'a Number>,
    total: String,
    gouge: String,
    bars: Vec<Bar>,
    method: &'a str,
    places: Vec<Row<'a>>,
    more_places: usize,
    has_motion: bool,
    has_path: bool,
    picture: Option<Picture>,
    smoothing: &'a str,
    script: &'static str,
    style: &'static str,
    payload: &'a str,
}

/// Row of the budget, ready to draw.
#[derive(Debug, Serialize)]
struct Bar {
    name: String,
    allowed: String,
    used: Option<String>,
    percent: f64,
}

/// Picture of the solids.
#[derive(Debug, Serialize)]
struct Picture {
    uri: String,
    stock: bool,
    fixtures: bool,
}

/// Row of the table of worst places.
#[derive(Debug, Serialize)]
struct Row<'a> {
    kind: &'a str,
    deviation: Option<String>,
    point: String,
    note: &'a str,
}

/// Renders the page as one HTML text that loads nothing from anywhere.
///
/// # Errors
///
/// [`ReportError`]; none is expected for data that was built from finite numbers.
///
/// # Example
///
/// ```
/// use trunnion_report::{ReportData, render};
///
/// let data = ReportData { job: "blade".to_owned(), passed: true, ..ReportData::default() };
/// let page = render(&data)?;
/// assert!(page.contains("blade"));
/// # Ok::<(), trunnion_report::ReportError>(())
/// ```
pub fn render(data: &ReportData) -> Result<String, ReportError> {
    let payload = Payload::new(data).to_json()?;
    let mut environment = Environment::new();
    environment.add_template("report.html", TEMPLATE)?;
    let page = Page {
        job: &data.job,
        part: &data.part,
        machine: &data.machine,
        tool: &data.tool,
        generator: &data.generator,
        passed: data.passed,
        verdict: &data.verdict,
        warnings: &data.warnings,
        numbers: &data.numbers,
        headline: data.numbers.iter().filter(|number| number.headline).collect(),
        total: micrometres(data.budget.total),
        gouge: micrometres(data.budget.gouge),
        bars: bars(&data.budget),
        method: &data.check.method,
        places: data.check.places.iter().take(PLACES).map(row).collect(),
        more_places: data.check.places.len().saturating_sub(PLACES),
        has_motion: !data.motion.binding.is_empty(),
        has_path: !data.path.is_empty(),
        picture: picture(data),
        smoothing: &data.smoothing,
        script: SCRIPT,
        style: STYLE,
        payload: &payload,
    };
    Ok(environment.get_template("report.html")?.render(Serde(&page))?)
}

fn bars(budget: &Budget) -> Vec<Bar> {
    // A check of setpoints has no tolerance: nothing is divided by zero.
    let whole = budget.total.max(f64::MIN_POSITIVE);
    let bar = |share: &crate::data::Share| Bar {
        name: share.name.clone(),
        allowed: micrometres(share.allowed),
        used: share.used.map(micrometres),
        percent: (100.0 * share.allowed / whole).clamp(0.0, 100.0),
    };
    budget.shares.iter().map(bar).collect()
}

/// Draws the remaining stock, or without stock the part, among its fixtures; `None` without either.
fn picture(data: &ReportData) -> Option<Picture> {
    let Surface { vertices, triangles, .. } = &data.surface;
    let part = || Solid { vertices: vertices.clone(), triangles: triangles.clone() };
    let (worked, held) = match (&data.stock, &data.fixtures) {
        (None, None) => return None,
        (Some(stock), fixtures) => (stock.clone(), fixtures.clone().unwrap_or_default()),
        (None, Some(fixtures)) => (part(), fixtures.clone()),
    };
    let uri = picture::of([&worked, &held])?;
    Some(Picture { uri, stock: data.stock.is_some(), fixtures: data.fixtures.is_some() })
}

fn row(place: &WorstPlace) -> Row<'_> {
    let [x, y, z] = place.point;
    Row {
        kind: &place.kind,
        deviation: place.deviation.map(micrometres),
        point: format!("{x:.3}, {y:.3}, {z:.3}"),
        note: &place.note,
    }
}

/// Writes a small length in micrometres, as machinists do.
fn micrometres(mm: f64) -> String {
    let value = 1000.0 * mm;
    // Three figures either way: 99.9 and 100.
    if value.abs() >= 99.95 { format!("{value:.0} µm") } else { format!("{value:.1} µm") }
}
