//! All methods at one point, side by side.

use super::answer::{Answer, words};
use super::args::{PositionArgs, PositionMethod};
use super::drawing::title;
use super::refusal::{is_request_error, refusal};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::output;
use std::fmt::Write;
use trunnion::positioning::{
    CutterLocation, ErrorTrace, LocationRequest, PositioningError, comparison_picture, place, trace,
};

/// Result of one method.
struct Row {
    method: PositionMethod,
    found: Result<CutterLocation, PositioningError>,
}

pub(super) fn run(
    request: &LocationRequest,
    args: &PositionArgs,
    form: OutputForm,
) -> Result<Done, Failure> {
    let mut rows = Vec::new();
    for method in PositionMethod::ALL {
        let found = place(request, &method.placing(args));
        match found {
            // A ball has no circle to place, which is no fault of the comparison.
            Err(error) if is_request_error(&error) && error != PositioningError::NoCircle => {
                return Err(refusal(&error));
            }
            found => rows.push(Row { method, found }),
        }
    }
    if let Some(path) = &args.output {
        let traces: Result<Vec<ErrorTrace>, PositioningError> =
            rows.iter().filter_map(|row| traced(request, args, row)).collect();
        let title = title(args, "error across the feed");
        let picture =
            comparison_picture(&traces.map_err(|error| refusal(&error))?, request.band, &title);
        output::file(path, |out| out.write_all(picture.as_bytes()))?;
    }
    // One method that works is an answer: failures of others are part of the comparison.
    let any = rows.iter().any(|row| row.found.is_ok());
    let answers: Vec<_> = rows.iter().map(answer).collect();
    form.print(&serde_json::json!({ "methods": answers }), |_| table(&rows, args))?;
    Ok(if any { Done::Kept } else { Done::Broken })
}

fn traced(
    request: &LocationRequest,
    args: &PositionArgs,
    row: &Row,
) -> Option<Result<ErrorTrace, PositioningError>> {
    let location = row.found.as_ref().ok()?;
    let cutter = row.method.placing(args).cutter(request.cutter);
    Some(cutter.and_then(|cutter| {
        trace(&LocationRequest { cutter: &cutter, ..*request }, location, row.method.name())
    }))
}

fn answer(row: &Row) -> serde_json::Value {
    let name = row.method.name();
    match &row.found {
        Ok(location) => serde_json::json!(Answer::new(location, row.method)),
        Err(error) => {
            let (refused, remedy) = (error.to_string(), error.remedy());
            serde_json::json!({ "method": name, "refused": refused, "remedy": remedy })
        }
    }
}

fn table(rows: &[Row], args: &PositionArgs) -> String {
    let width = |row: &Row| row.found.as_ref().map_or(0.0, |location| location.strip_width);
    // Shares are of the widest strip found, whichever method found it.
    let widest = rows.iter().map(width).fold(0.0, f64::max);
    let ([u, v], [du, dv]) = (args.at, args.feed);
    let mut text = format!(
        "strips at (u, v) = ({u}, {v}), feed ({du}, {dv}), error within [0, {}] mm, nothing gouges\n",
        args.tolerance
    );
    // Writing to a String does not fail.
    let _ = writeln!(
        text,
        "  {:<12}{:>10}{:>9}{:>10}{:>10}{:>10}  limited by",
        "method", "width, mm", "share", "turn, deg", "rear, um", "queries"
    );
    for row in rows {
        let name = row.method.name();
        let _ = match &row.found {
            Ok(found) => writeln!(
                text,
                "  {name:<12}{:>10.4}{:>7.1} %{:>10.3}{:>10.2}{:>10}  {}",
                found.strip_width,
                100.0 * found.strip_width / widest,
                found.rotation.to_degrees(),
                // A touch is 0 up to rounding; no minus before it.
                (found.rear_min * 1e5).round() / 1e2 + 0.0,
                found.queries,
                bounds(found)
            ),
            Err(error) => writeln!(text, "  {name:<12}{:>10}{:>9}  {}", "none", "", why(error)),
        };
    }
    text.push_str(
        "share: of the widest strip; the number of passes over a face is about inversely proportional to it.\n\
         turn: about the chord, or from the normal where there is one contact.\n\
         rear: least clearance of the cutter beside the strip.\n",
    );
    text
}

fn bounds(found: &CutterLocation) -> String {
    let names: Vec<&str> = found.active.iter().map(|active| words(*active).0).collect();
    names.join(", ")
}

/// Describes the refusal in a few words; `--method` prints it in full.
fn why(error: &PositioningError) -> String {
    use PositioningError as E;
    match error {
        E::Gouges { depth, binding, .. } => format!("gouges by {:.2} um: {binding}", depth * 1e3),
        E::NoPair { .. } => {
            "no pose touches twice with the error between at the tolerance".to_owned()
        }
        E::NotCutting { radius, inner, .. } => {
            format!("touches {radius:.3} mm from the axis, the inserts begin at {inner}")
        }
        E::NoCircle => "a ball has no cutting circle to place".to_owned(),
        error => error.to_string(),
    }
}
