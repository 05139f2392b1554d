//! The verb: copies or smooths a CL file, line by line.

use super::answer::{answer, describe};
use super::args::PathArgs;
use super::chart;
use super::conserved::{self, Counted, Counter};
use super::lines::{self, Lines};
use super::smoothed::{Rewriter, Sheet, Stop};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::progress::Bars;
use crate::{output, run as jobs, text};
use anyhow::Context;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Cursor, Seek, Write};
use std::path::Path;
use trunnion::nc::read::{ClItem, ClReader};
use trunnion::pipeline;
use trunnion::post::MOST_FAULTS;
use trunnion::types::{PoseTolerance, Progress, Stage};

/// Bytes read at a time.
const BUFFER: usize = 1 << 16;

/// Lines between two checks for cancellation.
const LINES_A_STEP: u64 = 4096;

pub(crate) fn run(args: &PathArgs, form: OutputForm) -> Result<Done, Failure> {
    if form.is_json() && args.output.is_none() {
        let help = "help: name the CL file with -o";
        return Err(Failure::input(format!("--json and the CL file both go to stdout\n  {help}")));
    }
    for written in [&args.output, &args.chart].into_iter().flatten() {
        output::protect(written, &[&args.input])?;
    }
    let bars = Bars::new();
    let input = Input::open(&args.input, &bars)?;
    let Some(place) = &args.output else {
        // Whole or not at all: a file that is refused in its last line must not have gone to stdout.
        let mut spool = tempfile::tempfile().context("making a temporary file")?;
        let done_sheet = rewrite(input, &bars, args.smooth, BufWriter::new(&mut spool))?;
        draw(args, &done_sheet)?;
        spool.rewind().context("reading a temporary file")?;
        let copied = std::io::copy(&mut spool, &mut std::io::stdout().lock());
        return match copied {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(anyhow::Error::new(error).context("writing to stdout").into())
            }
            _ => Ok(Done::Kept),
        };
    };
    let done_sheet = output::file_checked(place, |out| rewrite(input, &bars, args.smooth, out))?;
    bars.finish();
    draw(args, &done_sheet)?;
    let answer = answer(&done_sheet, args.smooth);
    form.print(&answer, |answer| describe(answer, place))
}

/// CL file that is read line by line.
struct Input<'a> {
    name: &'a Path,
    lines: Lines<Box<dyn BufRead>>,
    size: u64,
}

impl<'a> Input<'a> {
    fn open(name: &'a Path, bars: &dyn Progress) -> Result<Self, Failure> {
        let (from, size): (Box<dyn BufRead>, u64) = if name == Path::new("-") {
            (Box::new(std::io::stdin().lock()), 0)
        } else if name.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("toml")) {
            let (job, warnings) = jobs::load(name, None, bars)?;
            for warning in warnings {
                eprintln!("warning: {warning}");
            }
            // A job has no CL file yet: its passes are placed, and read back as one.
            let cl = pipeline::locations(&job, bars).map_err(jobs::failure)?;
            let size = cl.len() as u64;
            (Box::new(Cursor::new(cl)), size)
        } else {
            let fault = |what: String| Failure::input(format!("{}: {what}", name.display()));
            let size = std::fs::metadata(name).map_err(|error| fault(text::unreadable(&error)))?;
            if size.is_dir() {
                return Err(fault("is a folder; a file is expected".into()));
            }
            let file = File::open(name).map_err(|error| fault(text::unreadable(&error)))?;
            (Box::new(BufReader::with_capacity(BUFFER, file)), size.len())
        };
        Ok(Self { name, lines: Lines::new(from), size })
    }
}

/// Copies a CL file, or writes it smoothed. After an error the output is discarded.
fn rewrite(
    mut input: Input<'_>,
    bars: &dyn Progress,
    smooth: Option<PoseTolerance>,
    out: impl Write,
) -> Result<Sheet, Failure> {
    let name = input.name;
    let (mut counter, mut counted) = (Counter::default(), Counted::new(out));
    let mut writer = match smooth {
        Some(tolerance) => Writer::Smooth(Box::new(Rewriter::new(&mut counted, tolerance))),
        None => Writer::Copy(&mut counted, Box::default()),
    };
    let mut reader = ClReader::new(MOST_FAULTS);
    let mut raw = Vec::new();
    let unread = |error| anyhow::Error::new(error).context(format!("reading {}", name.display()));
    let mut count = 0_u64;
    while let Some(line) = input.lines.next().map_err(unread)? {
        raw.extend_from_slice(line);
        let item = reader.line(&lines::text(line));
        if reader.is_full() {
            // Enough faults for one report.
            break;
        }
        if !reader.faults().is_empty() {
            // Nothing will be written any more; the rest is read for its faults.
            raw.clear();
        } else if let Some(item) = item {
            counter.item(&item);
            writer.item(&item, &raw, &reader).map_err(|stop| stopped(name, stop))?;
            raw.clear();
        }
        count += 1;
        if count.is_multiple_of(LINES_A_STEP) && input.size > 0 {
            let on = bars.report(Stage::ToolPath, input.lines.bytes, input.size);
            if on.is_break() {
                return Err(Failure::Stopped);
            }
        }
    }
    let warnings = reader.finish().map_err(|faults| Failure::faults(name, &faults))?;
    for warning in warnings {
        eprintln!("warning: {}:{warning}", name.display());
    }
    let sheet = writer.finish().map_err(|stop| stopped(name, stop))?;
    let conserved = [counter.count, counted.count()];
    conserved::compare(
        name,
        [&conserved[0], &conserved[1]],
        smooth.map(|tolerance| tolerance.tip),
    )?;
    Ok(Sheet { conserved, ..sheet })
}

/// Writer of a file, unchanged or smoothed.
enum Writer<W> {
    Copy(W, Box<Sheet>),
    Smooth(Box<Rewriter<W>>),
}

impl<W: Write> Writer<W> {
    fn item(&mut self, item: &ClItem, raw: &[u8], reader: &ClReader) -> Result<(), Stop> {
        match self {
            Self::Smooth(rewriter) => rewriter.item(item, raw, reader),
            Self::Copy(out, sheet) => {
                if matches!(item, ClItem::Location(_)) {
                    sheet.locations = sheet.locations.map(|count| count + 1);
                }
                Ok(out.write_all(raw)?)
            }
        }
    }

    fn finish(self) -> Result<Sheet, Stop> {
        match self {
            Self::Smooth(rewriter) => rewriter.finish(),
            Self::Copy(mut out, sheet) => {
                out.flush()?;
                Ok(*sheet)
            }
        }
    }
}

fn stopped(name: &Path, stop: Stop) -> Failure {
    match stop {
        Stop::Diagnostic(fault) => Failure::faults(name, &[fault]),
        Stop::Output(error) => anyhow::Error::new(error).context("writing the CL file").into(),
    }
}

fn draw(args: &PathArgs, sheet: &Sheet) -> Result<(), Failure> {
    let (Some(place), Some(tolerance)) = (&args.chart, args.smooth) else { return Ok(()) };
    let chart = chart::draw(&sheet.profile, tolerance);
    output::file(place, |out| out.write_all(chart.as_bytes()))
}
