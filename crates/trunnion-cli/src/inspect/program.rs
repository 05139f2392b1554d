//! Summary of an NC program.

use crate::form::OutputForm;
use crate::option_values::three;
use crate::outcome::{Done, Failure};
use crate::path::lines::{self, Lines};
use crate::program_files::ProgramFileArgs;
use crate::text::unreadable;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use trunnion::nc::read::{self, AxisWord, AxisWords, Dialect, ReadOptions, Step, Tally};
use trunnion::post::MOST_FAULTS;

/// Extensions of programs.
const ENDINGS: [&str; 11] =
    ["ngc", "nc", "cnc", "tap", "gcode", "mpf", "spf", "h", "eia", "min", "ptp"];

/// Lines from which the dialect is detected.
const FIRST: usize = 500;

/// Returns true if the file name is that of an NC program.
pub(super) fn is_one(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default();
    ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

/// Options for reading a program.
#[derive(Debug, clap::Args)]
pub(super) struct ProgramArgs {
    /// Dialect of a program: linuxcnc, fanuc, haas, siemens, heidenhain. Without it, the first lines decide.
    #[arg(long, value_name = "DIALECT", value_parser = dialect)]
    from: Option<Dialect>,
    /// Value of a parameter that the program does not set, such as `500=0`, `_hal[x]=3`, `R1=5`. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = parameter)]
    parameters: Vec<(String, f64)>,
    /// Run the lines that begin with / (true), or skip them (false).
    #[arg(long, value_name = "RUN")]
    block_delete: Option<bool>,
    /// Start as on a control that was just switched on, with X, Y and Z at these positions in mm: rotaries, work offsets and
    /// the positions of G28 and G30 are zero, and no tool is in the spindle. Without it, none of these is known.
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_negative_numbers = true)]
    start: Option<[f64; 3]>,
    #[command(flatten)]
    files: ProgramFileArgs,
}

fn dialect(name: &str) -> Result<Dialect, String> {
    Dialect::from_name(name).filter(|dialect| *dialect != Dialect::Apt).ok_or_else(|| {
        let known: Vec<_> =
            Dialect::ALL.iter().filter(|d| **d != Dialect::Apt).map(|d| d.name()).collect();
        format!("known are {}", known.join(", "))
    })
}

pub(crate) fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').ok_or("write NAME=VALUE")?;
    let value: f64 = value.trim().parse().map_err(|_| format!("{value} is not a number"))?;
    if value.is_finite() {
        Ok((name.trim().to_owned(), value))
    } else {
        Err("not finite".to_owned())
    }
}

/// Axis for scripts; mm or degrees.
#[derive(Debug, serde::Serialize)]
struct AxisRange {
    name: char,
    range: [f64; 2],
}

/// Moves from one tool change to the next.
#[derive(Debug, serde::Serialize)]
struct ByTool {
    tool: u32,
    blocks: usize,
    /// Length of rapid moves and of feed moves.
    length: [f64; 2],
    seconds: f64,
}

impl ByTool {
    fn new(tool: u32, tally: &Tally) -> Self {
        Self {
            tool,
            blocks: tally.blocks,
            length: [tally.rapid_length, tally.cut_length],
            seconds: tally.seconds,
        }
    }
}

/// Answer of `--json`; mm, degrees, s.
#[derive(Debug, serde::Serialize)]
struct ProgramSummary {
    schema: &'static str,
    dialect: &'static str,
    lines: u64,
    blocks: usize,
    rapids: usize,
    arcs: usize,
    /// Length of rapid moves and of feed moves.
    length: [f64; 2],
    /// Time at the feeds written, with dwells, without rapid moves.
    seconds: f64,
    axes: Vec<AxisRange>,
    tools: Vec<u32>,
    /// Work of each tool in order; moves before the first are left out.
    by_tool: Vec<ByTool>,
    warnings: Vec<String>,
}

pub(super) fn run(path: &Path, args: &ProgramArgs, form: OutputForm) -> Result<Done, Failure> {
    let summary = read(path, args)?;
    for warning in &summary.warnings {
        eprintln!("warning: {warning}");
    }
    form.print(&summary, describe)
}

/// Lines of a file; an error ends them and is kept.
struct FileLines {
    lines: Lines<BufReader<File>>,
    count: u64,
    failure: Option<std::io::Error>,
}

impl FileLines {
    fn open(path: &Path) -> Result<Self, Failure> {
        let file = File::open(path).map_err(|error| {
            Failure::input(format!("{}: {}", path.display(), unreadable(&error)))
        })?;
        Ok(Self { lines: Lines::new(BufReader::new(file)), count: 0, failure: None })
    }

    /// Returns the error that ended the lines, if one did.
    fn ended(&mut self, path: &Path) -> Result<(), Failure> {
        let reading =
            |error| anyhow::Error::new(error).context(format!("reading {}", path.display()));
        self.failure.take().map_or(Ok(()), |error| Err(Failure::from(reading(error))))
    }
}

impl Iterator for FileLines {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        match self.lines.next() {
            Ok(line) => {
                self.count += u64::from(line.is_some());
                line.map(|line| lines::text(line).into_owned())
            }
            Err(error) => {
                self.failure = Some(error);
                None
            }
        }
    }
}

fn read(path: &Path, args: &ProgramArgs) -> Result<ProgramSummary, Failure> {
    let dialect = match args.from {
        Some(dialect) => dialect,
        None => Dialect::guess(FileLines::open(path)?.take(FIRST)),
    };
    // A file without a machine: its axes are the letters that it uses.
    let (axes, sixth) = letters(FileLines::open(path)?);
    let mut options = ReadOptions {
        sixth: true,
        block_delete: args.block_delete,
        parameters: args.parameters.clone(),
        // Retracts to the end of travel count with other axis positions: their lengths stay out.
        retract_height: Some(0.0),
        start: args.start.map(|[x, y, z]| [x, y, z, 0.0, 0.0]),
        ..ReadOptions::new(dialect, axes, MOST_FAULTS)
    };
    args.files.fill(&mut options, path)?;
    let mut source = FileLines::open(path)?;
    // Read three times, line by line: memory does not grow with the program.
    let mut steps = read::steps(&mut source, &options);
    let tally = Tally::new(axes.0.map(|word| word.rotary));
    let mut tally = options.start.map_or(tally.clone(), |start| tally.starting_at(start));
    let mut tools: Vec<(u32, Tally)> = Vec::new();
    for step in &mut steps {
        let step = step.map_err(|faults| Failure::program_faults(path, &faults))?;
        tally.push(&step);
        if let Step::Tool { number, .. } = &step {
            tools.push((*number, Tally::new(axes.0.map(|word| word.rotary))));
        }
        if let Some((_, own)) = tools.last_mut() {
            own.push(&step);
        }
    }
    let by_tool = tools.iter().map(|(tool, tally)| ByTool::new(*tool, tally)).collect();
    let warnings = steps.warnings().iter().map(|warning| format!("{}:{warning}", path.display()));
    let (warnings, tools) = (warnings.collect(), steps.tools().to_vec());
    drop(steps);
    source.ended(path)?;
    let names = axes.0.map(|word| word.letter).into_iter().chain([sixth]);
    let ranges = names.zip(&tally.ranges).filter_map(|(name, range)| {
        let unit = |value: f64| if "ABC".contains(name) { value.to_degrees() } else { value };
        range.map(|range| AxisRange { name, range: range.ends().map(unit) })
    });
    Ok(ProgramSummary {
        schema: "trunnion-inspect-program/1",
        dialect: dialect.name(),
        lines: source.count,
        blocks: tally.blocks,
        rapids: tally.rapids,
        arcs: tally.arcs,
        length: [tally.rapid_length, tally.cut_length],
        seconds: tally.seconds,
        axes: ranges.collect(),
        tools,
        by_tool,
        warnings,
    })
}

/// Returns the five axes that a program names, and the letter of a sixth.
fn letters(lines: impl Iterator<Item = String>) -> (AxisWords, char) {
    let mut named = [false; 26];
    for line in lines {
        let mut comment = false;
        let bytes = line.as_bytes();
        for pair in bytes.windows(2) {
            comment = match pair[0] {
                b'(' => true,
                b')' => false,
                _ => comment,
            };
            // A letter is an address only if a number, sign, variable or expression follows it.
            let value =
                matches!(pair[1], b'0'..=b'9' | b'+' | b'-' | b'.' | b'#' | b'[' | b'=' | b' ');
            if !comment && value && pair[0].is_ascii_alphabetic() {
                named[usize::from(pair[0].to_ascii_uppercase() - b'A')] = true;
            }
        }
    }
    let is = |letter: char| named[letter as usize - 'A' as usize];
    // Named rotaries come first; A and C fill up, the usual pair.
    let mut rotary: Vec<char> = "ABC".chars().filter(|letter| is(*letter)).collect();
    rotary.extend("ACB".chars().filter(|letter| !is(*letter)));
    let sixth =
        if is(rotary[2]) { Some(rotary[2]) } else { "UVW".chars().find(|letter| is(*letter)) };
    let word = |letter: char| AxisWord {
        letter,
        rotary: "ABC".contains(letter),
        decimals: 4,
        reversed: false,
    };
    (AxisWords(['X', 'Y', 'Z', rotary[0], rotary[1]].map(word)), sixth.unwrap_or(rotary[2]))
}

fn describe(summary: &ProgramSummary) -> String {
    let row = |name: &str, value: String| format!("{name:<12}{value}");
    let [rapid, feed] = summary.length;
    let mut rows = vec![
        row("dialect", summary.dialect.to_owned()),
        row("lines", summary.lines.to_string()),
        row(
            "blocks",
            format!("{}, {} of them rapid, {} arcs", summary.blocks, summary.rapids, summary.arcs),
        ),
        row("length", format!("{feed:.3} mm of words with feed, {rapid:.3} mm rapid")),
        row("time", format!("{:.1} s at the feeds written, without rapid moves", summary.seconds)),
    ];
    for AxisRange { name, range: [low, high] } in &summary.axes {
        let unit = if "ABC".contains(*name) { "deg" } else { "mm" };
        rows.push(row(&name.to_string(), format!("{low:.4} .. {high:.4} {unit}")));
    }
    if !summary.tools.is_empty() {
        let tools: Vec<_> = summary.tools.iter().map(ToString::to_string).collect();
        rows.push(row("tools", tools.join(", ")));
    }
    for own in summary.by_tool.iter().filter(|_| summary.by_tool.len() > 1) {
        let ByTool { tool, blocks, length: [_, feed], seconds } = own;
        let text = format!("{blocks} blocks, {feed:.3} mm with feed, {seconds:.1} s");
        rows.push(row(&format!("tool {tool}"), text));
    }
    rows.join("\n") + "\n"
}
