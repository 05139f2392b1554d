//! Summary of a CL file.

use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::path::lines::{self, Lines};
use crate::text::unreadable;
use anyhow::Context;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use trunnion::nc::read::{ClItem, ClReader, ClTally};
use trunnion::post::MOST_FAULTS;

/// Extensions of CL files.
const ENDINGS: [&str; 7] = ["cls", "clsf", "apt", "aptsource", "ncl", "cl", "clt"];

/// Chord tolerance of arcs \[mm\].
const ARC_TOLERANCE: f64 = 1e-3;

/// Returns true if the file name is that of a CL file.
pub(super) fn is_one(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default();
    ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

/// Answer of `--json`; mm, degrees, s.
#[derive(Debug, serde::Serialize)]
struct ClSummary {
    schema: &'static str,
    lines: u64,
    locations: usize,
    arcs: usize,
    holes: usize,
    /// Length of rapid moves and of feed moves.
    length: [f64; 2],
    /// Time at the feeds written, without rapid moves.
    seconds: f64,
    /// Smallest and largest coordinates, in the frame of the first operation.
    x: [f64; 2],
    y: [f64; 2],
    z: [f64; 2],
    i: [f64; 2],
    j: [f64; 2],
    k: [f64; 2],
    /// Sum of all rotations of the tool axis.
    turn: f64,
    tool: Option<u32>,
    cutter: Option<[f64; 2]>,
    warnings: Vec<String>,
}

pub(super) fn run(path: &Path, form: OutputForm) -> Result<Done, Failure> {
    let summary = read(path)?;
    for warning in &summary.warnings {
        eprintln!("warning: {warning}");
    }
    // A file without locations is of another kind, or empty: nothing to summarise.
    if summary.locations == 0 {
        return Err(Failure::input(format!("{}: no cutter locations", path.display())));
    }
    form.print(&summary, describe)
}

fn read(path: &Path) -> Result<ClSummary, Failure> {
    let file = File::open(path)
        .map_err(|error| Failure::input(format!("{}: {}", path.display(), unreadable(&error))))?;
    let mut lines = Lines::new(BufReader::new(file));
    let mut reader = ClReader::new(MOST_FAULTS);
    let mut tally = ClTally::new(ARC_TOLERANCE);
    let mut count = 0;
    let unread = || format!("reading {}", path.display());
    while let Some(line) = lines.next().with_context(unread)? {
        count += 1;
        // Operations may have frames of their own: all are measured in the first.
        if let Some(ClItem::Location(record)) = reader.line(&lines::text(line)) {
            tally.push(&record.moved(&reader.first_from_written()));
        }
        if reader.is_full() {
            break;
        }
    }
    let (tool, cutter) = (reader.tool(), reader.cutter());
    let warnings = reader.finish().map_err(|faults| Failure::faults(path, &faults))?;
    let warnings = warnings.iter().map(|warning| format!("{}:{warning}", path.display()));
    let tip = |at: usize| tally.tip.map(|end| end[at]);
    let axis = |at: usize| tally.axis.map(|end| end[at]);
    Ok(ClSummary {
        schema: "trunnion-inspect-cl/1",
        lines: count,
        locations: tally.locations,
        arcs: tally.arcs,
        holes: tally.holes,
        length: [tally.rapid_length, tally.cut_length],
        seconds: tally.seconds,
        x: tip(0),
        y: tip(1),
        z: tip(2),
        i: axis(0),
        j: axis(1),
        k: axis(2),
        turn: tally.turn.to_degrees(),
        tool,
        cutter,
        warnings: warnings.collect(),
    })
}

fn describe(summary: &ClSummary) -> String {
    let row = |name: &str, value: String| format!("{name:<12}{value}");
    let range = |name: &str, [low, high]: [f64; 2], decimals: usize| {
        row(name, format!("{low:.decimals$} .. {high:.decimals$}"))
    };
    let ClSummary { lines, locations, arcs, holes, length: [rapid, feed], seconds, .. } = summary;
    let mut rows = vec![
        row("lines", lines.to_string()),
        row("locations", format!("{locations}, {arcs} reached on arcs, {holes} of them holes")),
        row("length", format!("{feed:.3} mm with feed, {rapid:.3} mm rapid")),
        row("time", format!("{seconds:.1} s at the feeds written, without rapid moves")),
    ];
    rows.extend(
        [("x", summary.x), ("y", summary.y), ("z", summary.z)].map(|(name, of)| range(name, of, 4)),
    );
    rows.extend(
        [("i", summary.i), ("j", summary.j), ("k", summary.k)].map(|(name, of)| range(name, of, 6)),
    );
    rows.push(row("turns", format!("{:.2} deg of the tool axis in all", summary.turn)));
    if let Some([diameter, corner]) = summary.cutter {
        let tool = summary.tool.map_or(String::new(), |tool| format!(", tool {tool}"));
        rows.push(row(
            "cutter",
            format!("D {diameter} mm, corner radius {corner} mm{tool}: the last"),
        ));
    }
    rows.join("\n") + "\n"
}
