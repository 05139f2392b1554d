//! `trunnion machine new`: a machine file from answers, given by flags or asked on a terminal.

use super::import::key_value;
use crate::form::OutputForm;
use crate::option_values::three;
use crate::outcome::{Done, Failure};
use crate::output::{self, Outputs};
use std::collections::BTreeMap;
use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use trunnion::files::machine::write;
use trunnion::machine::{AxisSpec, Machine, MachineSpec, SignCheck, picture};
use trunnion::types::Interval;

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct NewArgs {
    /// Machine file to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Draw the chain into this SVG file.
    #[arg(long, value_name = "SVG")]
    drawing: Option<PathBuf>,
    /// Name of the machine.
    #[arg(long)]
    name: Option<String>,
    /// Rotary axes that turn the part, from the part to the bed: C,B for C on a tilting B; none if there are none.
    #[arg(long, value_name = "AXES")]
    table: Option<String>,
    /// Rotary axes that turn the spindle, from the bed to the spindle: C,A for a fork head; none if there are none.
    #[arg(long, value_name = "AXES")]
    head: Option<String>,
    /// Linear axes that move the table: X,Y; none if all move the spindle.
    #[arg(long, value_name = "AXES")]
    carries: Option<String>,
    /// Point in which the lines of both rotary axes meet, machine coordinates at zero, mm.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    meet: Option<String>,
    /// A point of the line of one rotary axis, in place of --meet, such as B=-381,-254,-535. May be repeated.
    #[arg(long, value_name = "AXIS=X,Y,Z", value_parser = key_value)]
    point: Vec<(String, String)>,
    /// Direction of an axis that is not along x, y, z as its letter says, such as B=0,1,1. May be repeated.
    #[arg(long, value_name = "AXIS=X,Y,Z", value_parser = key_value)]
    dir: Vec<(String, String)>,
    /// Ends of travel in mm or degrees, such as X=-762,0 or C=endless. May be repeated.
    #[arg(long, value_name = "AXIS=LOW,HIGH", value_parser = key_value)]
    travel: Vec<(String, String)>,
    /// Turn of the table or head when an axis is jogged by +30 degrees, seen from the positive end of the axis (C from
    /// above, A from +x, B from +y): clockwise or counterclockwise, such as C=clockwise. May be repeated.
    #[arg(long, value_name = "AXIS=TURN", value_parser = key_value)]
    jog: Vec<(String, String)>,
    /// Largest velocity, acceleration and jerk of the linear axes, mm and s.
    #[arg(long, value_name = "VEL,ACC,JERK")]
    linear: Option<String>,
    /// The same of the rotary axes, degrees and s.
    #[arg(long, value_name = "VEL,ACC,JERK")]
    rotary: Option<String>,
}

const EXAMPLES: &str = "\
On a terminal, everything that no flag states is asked for. In a script it is an error that names the flag.

  trunnion machine new -o my.toml
  trunnion machine new -o my.toml --name mill --table C,B --head none --carries none \\
      --meet=-381,-254,-535 --travel X=-762,0 --travel Y=-508,0 --travel Z=-508,0 \\
      --travel C=endless --travel B=-35,120 \\
      --jog C=clockwise --jog B=clockwise --linear 500,2500,40000 --rotary 150,300,6000";

pub(crate) fn run(args: &NewArgs, form: OutputForm) -> Result<Done, Failure> {
    // Before the first question: no answers are asked for in vain.
    output::refuse_existing(&args.output)?;
    if args.drawing.as_ref() == Some(&args.output) {
        return Err(Failure::input(format!(
            "{}: the machine file and the drawing cannot be one file\n  help: name another file with --drawing",
            args.output.display()
        )));
    }
    let stdin = std::io::stdin();
    let terminal = stdin.is_terminal() && std::io::stderr().is_terminal();
    let mut input = stdin.lock();
    let mut answers = Answers {
        flags: flags(args),
        input: terminal.then_some(&mut input),
        missing: Vec::new(),
        wrong: Vec::new(),
    };
    let spec = interview(&mut answers)?;
    let machine = Machine::new(spec.clone()).map_err(|errors| {
        let message = |error: &trunnion::machine::MachineError| {
            format!("{error}\n  help: {}", error.remedy())
        };
        Failure::Input(errors.iter().map(message).collect())
    })?;
    let notes = ["Written by trunnion machine new: compare the signs with the machine, trunnion machine show".to_owned()];
    let text = write(&spec, &notes);
    // Both are complete before either is seen.
    let mut complete = vec![staged(&args.output, &text)?];
    if let Some(drawing) = &args.drawing {
        complete.push(staged(drawing, &picture(&machine))?);
    }
    for outputs in complete {
        outputs.commit()?;
    }
    let checks = machine.sign_checks();
    let summary = Summary {
        output: args.output.display().to_string(),
        name: machine.name.clone(),
        chain: machine.chain.clone(),
        signs: checks.iter().map(|check| sign_line(check, &machine)).collect(),
    };
    form.print(&summary, Summary::describe)
}

fn staged(path: &Path, text: &str) -> Result<Outputs, Failure> {
    let (mut outputs, name) = Outputs::beside(path)?;
    outputs.text(&name, text)?;
    Ok(outputs)
}

/// Result for scripts.
#[derive(Debug, serde::Serialize)]
struct Summary {
    output: String,
    name: String,
    chain: Vec<String>,
    /// Motions to expect.
    signs: Vec<String>,
}

impl Summary {
    fn describe(&self) -> String {
        format!(
            "{}\n\njog each axis and compare:\n  {}\nwrote {}\n",
            drawn(&self.chain),
            self.signs.join("\n  "),
            self.output
        )
    }
}

fn sign_line(check: &SignCheck, machine: &Machine) -> String {
    let axis = machine.axes.get(check.axis);
    let name = axis.map_or("", |axis| axis.name.as_str());
    let jog = if check.axis < 3 { check.by } else { check.by.to_degrees() };
    format!("{name} {:+}: {}", jog.round(), check.words)
}

/// Draws the chain as a line.
fn drawn(chain: &[String]) -> String {
    let words = chain.iter().map(|word| match word.as_str() {
        "w" => "[part]",
        "b" => "[bed]",
        "t" => "[tool]",
        axis => axis,
    });
    words.collect::<Vec<_>>().join(" -- ")
}

/// Gathers the flags by key.
fn flags(args: &NewArgs) -> BTreeMap<String, String> {
    let single = [
        ("name", &args.name),
        ("table", &args.table),
        ("head", &args.head),
        ("carries", &args.carries),
        ("meet", &args.meet),
        ("linear", &args.linear),
        ("rotary", &args.rotary),
    ];
    let several =
        [("point", &args.point), ("dir", &args.dir), ("travel", &args.travel), ("jog", &args.jog)];
    let single =
        single.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value.clone()?)));
    let several = several.into_iter().flat_map(|(key, list)| {
        list.iter().map(move |(axis, value)| (format!("{key} {axis}"), value.clone()))
    });
    single.chain(several).collect()
}

/// Source of answers: flags, then the terminal.
struct Answers<'a> {
    flags: BTreeMap<String, String>,
    /// Lines of a terminal; `None` in a script.
    input: Option<&'a mut dyn BufRead>,
    /// Flags that a script lacks.
    missing: Vec<String>,
    wrong: Vec<String>,
}

impl Answers<'_> {
    /// Returns the answer to a question; `None` if it is missing or wrong, which is kept for the end.
    fn get<T>(
        &mut self,
        key: &str,
        question: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Option<T> {
        if let Some(value) = self.flags.remove(key) {
            return read(&value)
                .map_err(|what| self.wrong.push(format!("--{key}={value}: {what}")))
                .ok();
        }
        let Some(input) = &mut self.input else {
            self.missing.push(format!("--{key}: {question}"));
            return None;
        };
        loop {
            // A terminal that is gone ends the dialogue below.
            let _ = write!(std::io::stderr(), "{question}\n  {key}: ");
            let mut line = String::new();
            if !input.read_line(&mut line).is_ok_and(|read| read > 0) {
                self.missing.push(format!("--{key}: {question}"));
                return None;
            }
            match read(line.trim()) {
                Ok(answer) => return Some(answer),
                Err(what) => {
                    let _ = writeln!(std::io::stderr(), "  {what}");
                }
            }
        }
    }

    /// Returns the failure of all that is missing, wrong or left over.
    fn end(self) -> Result<(), Failure> {
        let mut messages = self.wrong;
        messages.extend(self.flags.keys().map(|key| {
            format!("--{key}: the machine has no such axis, or the flag is not needed")
        }));
        if !self.missing.is_empty() {
            messages.push(format!("answers are missing\n  {}", self.missing.join("\n  ")));
        }
        if messages.is_empty() { Ok(()) } else { Err(Failure::Input(messages)) }
    }
}

/// Asks for the machine.
fn interview(answers: &mut Answers<'_>) -> Result<MachineSpec, Failure> {
    let finish = |answers: &mut Answers<'_>| {
        let taken = Answers {
            flags: std::mem::take(&mut answers.flags),
            input: None,
            missing: std::mem::take(&mut answers.missing),
            wrong: std::mem::take(&mut answers.wrong),
        };
        taken.end()
    };
    let name = answers.get("name", "name of the machine", |word| Ok(word.to_owned()));
    let table = answers.get(
        "table",
        "rotary axes that turn the part, from the part to the bed (C,B), or none",
        |word| names(word, "ABC"),
    );
    let head = answers.get(
        "head",
        "rotary axes that turn the spindle, from the bed to the spindle (C,A), or none",
        |word| names(word, "ABC"),
    );
    let carries =
        answers.get("carries", "linear axes that move the table (X,Y), or none", |word| {
            names(word, "XYZ")
        });
    let (Some(table), Some(head), Some(carries)) = (table, head, carries) else {
        // Further answers depend on these.
        answers.flags.clear();
        finish(answers)?;
        return Err(Failure::defect("an answer is missing, and no message says so"));
    };
    if table.len() + head.len() != 2 {
        let (table, head) = (table.join(","), head.join(","));
        return Err(Failure::input(format!(
            "--table {table} --head {head}: a five-axis machine has two rotary axes in all\n  help: name two, and none for the other flag"
        )));
    }
    let mut chain = vec!["w".to_owned()];
    chain.extend(table.iter().cloned());
    chain.extend(carries.iter().rev().cloned());
    chain.push("b".to_owned());
    chain.extend(
        ["X", "Y", "Z"].map(str::to_owned).into_iter().filter(|axis| !carries.contains(axis)),
    );
    chain.extend(head.iter().cloned());
    chain.push("t".to_owned());
    if answers.input.is_some() {
        let _ = writeln!(std::io::stderr(), "\n  {}\n", drawn(&chain));
    }
    let axes = axes(answers, &table, &head);
    finish(answers)?;
    let words: Vec<&str> = chain.iter().map(String::as_str).collect();
    Ok(MachineSpec::new(&name.unwrap_or_default(), &words, axes))
}

/// Asks for everything about the axes.
fn axes(answers: &mut Answers<'_>, table: &[String], head: &[String]) -> Vec<AxisSpec> {
    let mut all = Vec::new();
    let linear = answers.get(
        "linear",
        "velocity, acceleration and jerk of the linear axes (500,2500,40000) in mm and s",
        three,
    );
    for (name, dir) in [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])] {
        let dir = own_dir(answers, name).unwrap_or(dir);
        let limits = answers.get(
            &format!("travel {name}"),
            &format!("travel of {name} in mm (-400,400)"),
            ends,
        );
        let [vel, acc, jerk] = linear.unwrap_or([1.0; 3]);
        all.push(AxisSpec { limits, vel, acc, jerk, ..AxisSpec::linear(name, dir) });
    }
    let rates = answers.get(
        "rotary",
        "velocity, acceleration and jerk of the rotary axes (150,300,6000) in degrees and s",
        three,
    );
    let [vel, acc, jerk] = rates.unwrap_or([1.0; 3]).map(f64::to_radians);
    let several =
        table.iter().chain(head).any(|name| answers.flags.contains_key(&format!("point {name}")));
    let meet = if several {
        None
    } else {
        answers.get(
            "meet",
            "point in which the lines of both rotary axes meet, mm (-381,-254,-535)",
            three,
        )
    };
    for name in table.iter().chain(head) {
        let point = match meet {
            Some(point) => Some(point),
            None if several => answers.get(
                &format!("point {name}"),
                &format!("a point of the line of {name}, mm"),
                three,
            ),
            None => None,
        };
        let travel = answers.get(
            &format!("travel {name}"),
            &format!("travel of {name} in degrees (-110,110), or endless"),
            |word| if word == "endless" { Ok(None) } else { ends(word).map(Some) },
        );
        let clockwise = answers.get(
            &format!("jog {name}"),
            &format!("jog {name} by +30: from the positive end of its line, what turns goes clockwise or counterclockwise"),
            clockwise,
        );
        let dir = own_dir(answers, name).unwrap_or_else(|| named_dir(name));
        let limits = travel.flatten().map(|limits| limits.scaled(1.0_f64.to_radians()));
        let base = AxisSpec::rotary(name, dir, point.unwrap_or_default());
        // By ISO 841 a table turns clockwise for +, since the tool turns counterclockwise about it; a head does not.
        let sense = if clockwise == Some(table.contains(name)) { 1.0 } else { -1.0 };
        let cyclic = base.cyclic.filter(|_| limits.is_none());
        all.push(AxisSpec { limits, cyclic, vel, acc, jerk, sense, ..base });
    }
    all
}

fn own_dir(answers: &mut Answers<'_>, name: &str) -> Option<[f64; 3]> {
    // Only a flag states it: the letter of an axis is its direction.
    let key = format!("dir {name}");
    answers.flags.contains_key(&key).then(|| answers.get(&key, "", three)).flatten()
}

fn named_dir(name: &str) -> [f64; 3] {
    match name {
        "A" => [1.0, 0.0, 0.0],
        "B" => [0.0, 1.0, 0.0],
        _ => [0.0, 0.0, 1.0],
    }
}

/// Reads names of axes, each one of `allowed`, or none.
fn names(word: &str, allowed: &str) -> Result<Vec<String>, String> {
    if word.eq_ignore_ascii_case("none") {
        return Ok(Vec::new());
    }
    let names: Vec<String> = word.split(',').map(|name| name.trim().to_ascii_uppercase()).collect();
    let known = |name: &String| name.len() == 1 && allowed.contains(name.as_str());
    let twice =
        names.iter().enumerate().any(|(at, name)| names.iter().take(at).any(|other| other == name));
    if names.iter().all(known) && !twice {
        Ok(names)
    } else {
        let letters: Vec<String> = allowed.chars().map(String::from).collect();
        Err(format!("write axes of {} with commas between them, or none", letters.join(", ")))
    }
}

fn ends(word: &str) -> Result<Interval, String> {
    let [low, high] = crate::option_values::two(word)?;
    if low < high { Ok(Interval::new(low, high)) } else { Err("the lower end comes first".into()) }
}

fn clockwise(word: &str) -> Result<bool, String> {
    match word {
        "clockwise" | "cw" => Ok(true),
        "counterclockwise" | "ccw" => Ok(false),
        _ => Err("write clockwise or counterclockwise".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The dialogue as a person types it, with two slips.
    #[test]
    fn a_dialogue_makes_a_machine() {
        let lines = "mill\nC,B\nnone\nX,Q\nY\n500,2500,40000\n-400,400\n9,-9\n-300,300\n-200,0\n150,300,6000\n0,0,-100\nendless\ncw\n-35,120\nccw\n";
        let mut input = lines.as_bytes();
        let mut answers = Answers {
            flags: BTreeMap::new(),
            input: Some(&mut input),
            missing: Vec::new(),
            wrong: Vec::new(),
        };
        let spec = interview(&mut answers).unwrap();
        let machine = Machine::new(spec).unwrap();
        assert_eq!(machine.chain, ["w", "C", "B", "Y", "b", "X", "Z", "t"]);
        let senses: Vec<f64> = machine.axes.iter().map(|axis| axis.sense).collect();
        assert_eq!(senses, [1.0, 1.0, 1.0, 1.0, -1.0]);
        assert!(machine.axes[3].cyclic && machine.axes[4].limits.high > 2.0);
    }
}
