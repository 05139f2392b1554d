//! `trunnion post`: writes a program for a machine from cutter locations or another program, with new feeds.

mod input;
mod summary;
pub(crate) mod tools;

use crate::outcome::{Done, Failure};
use crate::output::Outputs;
use crate::progress::Bars;
use crate::{inspect, machine, text};
use input::{Input, Taken};
use std::io::Write;
use std::path::{Path, PathBuf};
use summary::PostSummary;
use tools::{ToolLength, Tools};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read;
use trunnion::nc::write::{
    AxisWords, Note, OUTPUT_FORMATS, OutputFormat, SheetProgram, Style, Template, ToolNote,
    program_sheet,
};
use trunnion::post::{
    POST_WINDOW, PostError, PostFilter, PostMethod, PostOptions, PostReport, Poster, ProgramHead,
    control_of,
};

/// Bytes of text that are kept before they are written.
const CHUNK: usize = 1 << 16;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line")]
pub(crate) struct Args {
    /// CL file (APT/CL as written by NX, CATIA, Creo, SOLIDWORKS and Autodesk) or NC program; - is stdin.
    #[arg(required_unless_present = "print_template")]
    input: Option<PathBuf>,
    /// Machine file, or name of a built-in machine (see `trunnion machine list`).
    #[arg(short, long, required_unless_present = "print_template")]
    machine: Option<String>,
    /// Program to write; its setup sheet is written beside it, OUT.setup.txt.
    #[arg(short, long, value_name = "OUT", required_unless_present = "print_template")]
    output: Option<PathBuf>,
    /// Dialect of the program [default: that of the machine file].
    #[arg(short, long, value_parser = dialect)]
    dialect: Option<OutputFormat>,
    /// Largest deviation of the program from the input: mm at the tip, degrees of the tool axis.
    #[arg(long, value_name = "TIP,AXIS", value_parser = tolerances, default_value = "0.01,0.05", allow_hyphen_values = true)]
    tolerance: [f64; 2],
    /// Dialect of the input [default: detected from its text]: apt linuxcnc fanuc haas siemens heidenhain.
    #[arg(long, value_name = "DIALECT", value_parser = read_dialect)]
    from: Option<read::Dialect>,
    /// Machine of the input program [default: that of --machine].
    #[arg(long, value_name = "MACHINE")]
    from_machine: Option<String>,
    /// Workpiece origin assumed by the input program [default: --origin].
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    from_origin: Option<[f64; 3]>,
    /// Workpiece rotation assumed by the input program [default: --rotation].
    #[arg(long, value_name = "RX,RY,RZ", value_parser = three, allow_hyphen_values = true)]
    from_rotation: Option<[f64; 3]>,
    /// Tool length assumed by the input program [default: --tool-length]; NUMBER=L for each of several tools.
    #[arg(long, value_name = "L|NUMBER=L", value_parser = tools::length, allow_hyphen_values = true)]
    from_tool_length: Vec<ToolLength>,
    /// Rotaries of the input program count against ISO 841.
    #[arg(long)]
    from_reversed_rotaries: bool,
    /// Post the moves of this tool only; --tool-length and --from-tool-length are those of this tool.
    #[arg(long, value_name = "NUMBER")]
    tool: Option<u32>,
    /// Value of a parameter that the input program does not set, such as `500=0`, `_hal[x]=3`, `R1=5`. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = inspect::parameter)]
    parameters: Vec<(String, f64)>,
    /// Run the lines that begin with / (true), or skip them (false).
    #[arg(long, value_name = "RUN")]
    block_delete: Option<bool>,
    /// Fit a C3 path through the moves between rapid moves: fewer and longer blocks, and no corners that slow the
    /// axes down.
    #[arg(long, conflicts_with = "reduce")]
    smooth: bool,
    /// Leave out moves that a longer one replaces within tolerance.
    #[arg(long)]
    reduce: bool,
    /// Retract so far along the tool, in mm, if a rotary axis reaches the end of its travel inside a cut; the rotaries
    /// unwind and the tool returns. Without this option such a cut is refused.
    #[arg(long, value_name = "MM", value_parser = positive, allow_hyphen_values = true)]
    unwind: Option<f64>,
    /// Feed in mm/min to which feeds may be raised if the axes allow it [default: feeds of the input are the upper
    /// limit].
    #[arg(long, value_name = "F", value_parser = positive, allow_hyphen_values = true)]
    max_feed: Option<f64>,
    /// Method for the times of blocks, and with them F.
    #[arg(long, value_enum, default_value_t = Method::Optimal)]
    feed: Method,
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    origin: [f64; 3],
    /// Rotation of the workpiece about the fixed x, then y, then z, in degrees.
    #[arg(long, value_name = "RX,RY,RZ", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    rotation: [f64; 3],
    /// Length of the tool, gauge point to tip, in mm [default: 0]. With NUMBER=L, once for each tool, an input with
    /// several tools becomes one program.
    #[arg(long, value_name = "L|NUMBER=L", value_parser = tools::length, allow_hyphen_values = true)]
    tool_length: Vec<ToolLength>,
    /// Write rotaries against ISO 841, as the trunnion kinematics of `LinuxCNC` count them by default.
    #[arg(long)]
    reversed_rotaries: bool,
    /// Spindle speed in 1/min [default: that of the input].
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    spindle: Option<f64>,
    /// Switch the coolant on at the start and off at the end.
    #[arg(long)]
    coolant: bool,
    /// Template of the text around the blocks; --print-template prints one to start from.
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    /// Print the template of a dialect, and do nothing else.
    #[arg(long, value_name = "DIALECT", value_parser = dialect, exclusive = true)]
    print_template: Option<OutputFormat>,
}

const EXAMPLES: &str = "\
Feeds never exceed those of the input unless --max-feed allows it; rapid moves stay rapid. With tool-centre-point
control F is an upper limit: the control plans its own speed below it. Without it (g93) each block has its time.
Dialects: linuxcnc g93 fanuc fanuc-vector haas siemens siemens-axes heidenhain heidenhain-axes apt.
Exit codes: 0 done; 1 written, but a limit is broken; 2 bad input, or poses out of reach: nothing written.

  trunnion post out/toolpath.cls -m bc-trunnion --origin -381,-254,-505 --tool-length 120 -d fanuc -o part.nc
  trunnion post old.ngc -m new.toml --from-machine old.toml --from-tool-length 150 --tool-length 120 -d g93 -o new.nc
  trunnion post two-tools.ngc -m new.toml --tool 2 --tool-length 95 -d g93 -o second.nc
  trunnion post two-tools.ngc -m new.toml --tool-length 1=120 --tool-length 2=95 -d fanuc -o both.nc
  trunnion post --print-template fanuc > shop.j2
  trunnion post part.cls -m my-machine.toml --template shop.j2 -o part.nc";

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Method {
    /// Shortest time within velocity and acceleration limits.
    Optimal,
    /// Jerk limits as well: gentler, and a little slower.
    Jerk,
    /// Block after block with look-ahead, as a classical control without smoothing runs them.
    Blocks,
    /// Times of the input; the load on the axes is reported. For controls with a tip feed that plan by themselves.
    Programmed,
}

fn dialect(name: &str) -> Result<OutputFormat, String> {
    OutputFormat::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = OUTPUT_FORMATS.iter().map(|(name, _)| *name).collect();
        format!("write one of {}", names.join(", "))
    })
}

fn read_dialect(name: &str) -> Result<read::Dialect, String> {
    let names = read::Dialect::ALL.map(read::Dialect::name);
    read::Dialect::from_name(name).ok_or_else(|| format!("write one of {}", names.join(", ")))
}

fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a finite number is expected".into()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| {
        if value > 0.0 { Ok(value) } else { Err("a number above 0 is expected".into()) }
    })
}

fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    numbers?.try_into().map_err(|_| "three numbers separated by commas are expected".to_owned())
}

/// Two positive numbers; the angle as radians.
fn tolerances(text: &str) -> Result<[f64; 2], String> {
    match text.split_once(',').map(|(tip, axis)| (positive(tip), positive(axis))) {
        Some((Ok(tip), Ok(axis))) => Ok([tip, axis.to_radians()]),
        _ => Err("write two numbers above 0, mm and degrees, such as 0.01,0.05".to_owned()),
    }
}

pub(crate) fn run(args: &Args, json: bool) -> Result<Done, Failure> {
    if let Some(dialect) = args.print_template {
        return text::print(dialect.template());
    }
    let (Some(input), Some(machine), Some(output)) = (&args.input, &args.machine, &args.output)
    else {
        return Err(Failure::input("an input, a machine (-m) and an output (-o) are needed"));
    };
    let plan = Plan::new(args, machine)?;
    let name = output.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name
        .filter(|_| !output.is_dir())
        .ok_or_else(|| Failure::input(format!("{}: not a file", output.display())))?;
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut outputs = Outputs::open(folder.unwrap_or(Path::new(".")))?;
    let bars = Bars::new();
    let mut posted = None;
    let written = outputs.add(&name, |out| match plan.post(input, &bars, out) {
        Ok(done) => {
            posted = Some(Ok(done));
            Ok(())
        }
        Err(failure) => {
            posted = Some(Err(failure));
            Err(std::io::Error::other("refused"))
        }
    });
    let posted = posted.transpose()?;
    written?;
    let Some((report, note)) = posted else { return Ok(Done::Kept) };
    if let Some(unread) = &report.unread {
        let path = output.display();
        eprintln!("warning: {path}:{unread}\nwarning: from there on the program was not read back");
    }
    let sheet = plan.sheet(&name, &note)?;
    outputs.text(&sheet_name(&name), &sheet)?;
    outputs.commit()?;
    bars.finish();
    let summary = PostSummary::new(&plan, &report, &note.tools, output);
    if json {
        text::print_json(&summary)?
    } else {
        text::print(&summary.describe())?
    };
    Ok(if summary.kept() { Done::Kept } else { Done::Broken })
}

/// `part.nc` has `part.setup.txt` beside it.
fn sheet_name(name: &str) -> String {
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    format!("{stem}.setup.txt")
}

/// Settings that are known before the input is read.
struct Plan {
    kinematics: Kinematics,
    options: PostOptions,
    style: Style,
    template: Template,
    spindle: Option<f64>,
    coolant: bool,
    taken: Taken,
    /// Lengths of tools by number, where there are several.
    tools: Tools,
    /// The machine that a program is for, and its words.
    from_machine: Kinematics,
    from_words: AxisWords,
}

/// Texts and numbers at the head of the program.
#[derive(Debug, Clone, Default)]
struct Head {
    name: String,
    tool: Option<u32>,
    /// All that were posted.
    tools: Vec<u32>,
    cutter: Option<[f64; 2]>,
    spindle: f64,
    coolant: bool,
    feed: f64,
    duration: f64,
}

impl Head {
    fn note(&self) -> Note<'_> {
        let [diameter, minor] = self.cutter.unwrap_or([0.0; 2]);
        Note {
            name: &self.name,
            tool: ToolNote {
                number: self.tool.unwrap_or(1),
                major: (0.5 * diameter - minor).max(0.0),
                minor,
            },
            spindle: self.spindle,
            coolant: self.coolant,
            feed: self.feed,
            budget: &[],
            duration: self.duration,
            remarks: &[],
        }
    }
}

impl Plan {
    fn new(args: &Args, name: &str) -> Result<Self, Failure> {
        let machine = machine::load(name)?.machine;
        let rotation = args.rotation.map(f64::to_radians);
        let tools = Tools::new(&args.tool_length, &args.from_tool_length, args.tool);
        let setup = Setup::new(args.origin.into(), rotation, tools.length);
        let kinematics = Kinematics::new(&machine, &setup);
        let dialect = args.dialect.unwrap_or_else(|| OutputFormat::of(&machine));
        let from_machine = match &args.from_machine {
            Some(name) => machine::load(name)?.machine,
            None => machine.clone(),
        };
        let from_setup = Setup::new(
            args.from_origin.unwrap_or(args.origin).into(),
            args.from_rotation.unwrap_or(args.rotation).map(f64::to_radians),
            tools.from_length,
        );
        let mut from_words = AxisWords::of(&from_machine);
        if args.from_reversed_rotaries {
            from_words = from_words.map(AxisWords::with_reversed_rotaries);
        }
        let mut axes = AxisWords::of(&machine).map_err(Failure::input)?;
        if args.reversed_rotaries {
            axes = axes.with_reversed_rotaries();
        }
        let style = Style { blend: Some(args.tolerance), ..Style::of(&kinematics, dialect, axes) };
        let template = match &args.template {
            None => Template::of(dialect).map_err(|error| Failure::input(error.to_string())),
            Some(path) => Template::new(&text::read(path)?)
                .map_err(|error| Failure::input(format!("{}: {error}", path.display()))),
        };
        let options = PostOptions {
            control: control_of(&kinematics, dialect),
            tolerance: args.tolerance,
            max_feed: args.max_feed.map(|feed| feed / 60.0),
            method: match args.feed {
                Method::Optimal => PostMethod::Optimal,
                Method::Jerk => PostMethod::Jerk,
                Method::Blocks => PostMethod::Blocks,
                Method::Programmed => PostMethod::Programmed,
            },
            window: POST_WINDOW,
            filter: match (args.smooth, args.reduce) {
                (true, _) => PostFilter::Smooth,
                (_, true) => PostFilter::Reduce,
                _ => PostFilter::None,
            },
            unwind: args.unwind,
        };
        Ok(Self {
            kinematics,
            options,
            style,
            template: template?,
            spindle: args.spindle,
            coolant: args.coolant,
            taken: Taken {
                from: args.from,
                tool: args.tool,
                lengths: tools.assumed(),
                parameters: args.parameters.clone(),
                block_delete: args.block_delete,
            },
            tools,
            from_machine: Kinematics::new(&from_machine, &from_setup),
            from_words: from_words.map_err(Failure::input)?,
        })
    }

    /// Reads the input to its end while the program is written.
    fn post(
        &self,
        path: &Path,
        bars: &Bars,
        out: &mut dyn Write,
    ) -> Result<(PostReport, Head), Failure> {
        let from = (&self.from_machine, self.from_words);
        let mut input = Input::open(path, from, &self.taken, bars)?;
        let mut poster: Option<Poster> = None;
        let mut text = String::with_capacity(2 * CHUNK);
        let (mut head, mut first) = (Head::default(), None);
        let unwritten = |error| anyhow::Error::new(error).context("writing the program");
        let mut tools: Vec<u32> = Vec::new();
        while let Some(one) = input.next()? {
            let changed = self.tools.are_several() && head.tool != input.tool();
            let begun = poster.as_mut().filter(|_| changed);
            if let (Some(poster), Some(before)) = (begun, first.take_if(|_| changed)) {
                let before: Head = before;
                let texts = ProgramHead { note: &before.note(), template: &self.template };
                let machine = self.with_tool(input.tool());
                let done = poster.change_tool(&mut text, &machine, input.source(), texts);
                done.map_err(|error| input.failure(&error))?;
            }
            input.head(&mut head);
            head.spindle = self.spindle.unwrap_or(head.spindle);
            head.coolant = self.coolant;
            // The head holds the state at the start of the program, whenever it is written.
            let first: &Head = first.get_or_insert_with(|| head.clone());
            let texts = ProgramHead { note: &first.note(), template: &self.template };
            if let Some(number) = head.tool.filter(|number| tools.last() != Some(number)) {
                tools.push(number);
            }
            let poster = match &mut poster {
                Some(poster) => poster,
                none => {
                    let machine = self.with_tool(head.tool);
                    let new = Poster::new(&machine, input.source(), &self.options, &self.style);
                    none.insert(new.map_err(|error| input.failure(&error))?)
                }
            };
            poster.push(&mut text, &one, texts).map_err(|error| input.failure(&error))?;
            if text.len() > CHUNK {
                out.write_all(text.as_bytes()).map_err(unwritten)?;
                text.clear();
            }
        }
        let note = first.as_ref().unwrap_or(&head).note();
        let last = ProgramHead { note: &note, template: &self.template };
        let poster = poster.ok_or_else(|| input.failure(&PostError::Empty))?;
        let report = poster.finish(&mut text, last).map_err(|error| input.failure(&error))?;
        out.write_all(text.as_bytes()).map_err(unwritten)?;
        head.duration = report.seconds[1] + report.rapid_seconds;
        head.tools = tools;
        Ok((report, head))
    }

    /// The machine with a tool.
    fn with_tool(&self, number: Option<u32>) -> Kinematics {
        let tool_length = self.tools.length_of(number);
        let setup = Setup { tool_length, ..*self.kinematics.setup() };
        Kinematics::new(self.kinematics.machine(), &setup)
    }

    fn sheet(&self, file: &str, head: &Head) -> Result<String, Failure> {
        let mut sheet = String::new();
        let lengths = self.tools.lengths();
        let program = SheetProgram { file, style: &self.style, lengths: &lengths };
        program_sheet(&mut sheet, &self.kinematics, &head.note(), program)
            .map_err(|error| Failure::input(error.to_string()))?;
        Ok(sheet)
    }
}
