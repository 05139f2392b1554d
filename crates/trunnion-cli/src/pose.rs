//! `trunnion pose`: tables of poses to tables of axes, and back.

use crate::form::OutputForm;
use crate::option_values::{finite, three};
use crate::outcome::{Done, Failure};
use crate::table::{Ends, Refusal, Work};
use crate::{machine, text};
use std::fmt::Write;
use trunnion::files::table::write_number;
use trunnion::inverse::{Branch, Inverse, InverseError, InverseSolutions};
use trunnion::machine::{Axis, FIRST_ROTARY, Kinematics, Machine, SECOND_ROTARY, Setup};
use trunnion::math::jet::by_arc_length;
use trunnion::types::{AxisVector, PoseRates, ToolPose};

/// Columns of a pose.
const POSE: [&str; 6] = ["x", "y", "z", "i", "j", "k"];

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PoseArgs {
    /// Machine file, or name of a built-in machine (see `trunnion machine list`).
    machine: String,
    /// Direction of the conversion.
    direction: Direction,
    #[command(flatten)]
    ends: Ends,
    /// Length of the tool, gauge point to tip, in mm.
    #[arg(long, value_name = "L", default_value = "0", value_parser = finite, allow_hyphen_values = true)]
    tool_length: f64,
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    origin: [f64; 3],
    /// Rotation of the workpiece about the fixed x, then y, then z, in degrees.
    #[arg(long, value_name = "RX,RY,RZ", default_value = "0,0,0", value_parser = three, allow_hyphen_values = true)]
    rotation: [f64; 3],
    /// inverse: every branch, rotaries in (-180, 180], travel ignored.
    #[arg(long)]
    all: bool,
    /// inverse, jets: position of the axes before the first row [default: home].
    #[arg(long, value_name = "C=10,B=20", allow_hyphen_values = true)]
    near: Option<String>,
    /// jets: derivatives by the arc length of the tip (t, K, L) instead of the parameter of the table.
    #[arg(long)]
    arc_length: bool,
}

const EXAMPLES: &str = "\
Columns are matched by name, others ignored; mm and degrees. Lines starting with # are comments.
  inverse  x,y,z,i,j,k -> pose,solution,X,Y,Z and the rotaries; the tool axis i,j,k points from the
           tip to the spindle and may have any length. One row per pose, inside travel, continuing
           from the row before. A pose out of reach gives a row with empty axis fields.
  forward  X,Y,Z and the rotaries -> x,y,z,i,j,k
  jets     x,y,z,i,j,k,x1,..,k1,x2,..,k2,x3,..,k3 (derivatives by any parameter) -> the axes and
           their first three derivatives: X,..,X1,..,X2,..,X3,..
Exit codes: 0 every row has an answer; 1 some have none; 2 malformed input, nothing written.

  trunnion pose bc-trunnion inverse poses.csv --tool-length 120 --origin -381,-254,-505
  trunnion pose my-machine.toml inverse --all < poses.csv | trunnion pose my-machine.toml forward";

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Direction {
    /// Axes to poses.
    Forward,
    /// Poses to axes.
    Inverse,
    /// Poses with derivatives to axes with derivatives.
    Jets,
}

pub(crate) fn run(args: &PoseArgs, form: OutputForm) -> Result<Done, Failure> {
    usage(args, form)?;
    let machine = machine::load(&args.machine)?.machine;
    let setup =
        Setup::new(args.origin.into(), args.rotation.map(f64::to_radians), args.tool_length);
    let kinematics = Kinematics::new(&machine, &setup);
    let near = near(&machine, args.near.as_deref().unwrap_or_default())?;
    let inverse = || Inverse::new(&kinematics).map_err(Failure::input);
    let names = machine.axes.each_ref().map(|axis: &Axis| axis.name.clone());
    let tally = match args.direction {
        Direction::Forward => args.ends.run(&mut Forward { kinematics, names })?,
        Direction::Inverse if args.all => {
            args.ends.run(&mut All { inverse: inverse()?, names, pose: 0 })?
        }
        Direction::Inverse => {
            args.ends.run(&mut Follow { inverse: inverse()?, names, near, pose: 0 })?
        }
        Direction::Jets => {
            let arc_length = args.arc_length;
            args.ends.run(&mut Jets { inverse: inverse()?, names, near, arc_length })?
        }
    };
    let output = args.ends.output().display().to_string();
    if form.is_json() {
        let direction = format!("{:?}", args.direction).to_lowercase();
        let rows = tally.rows;
        let Machine { name: machine, .. } = machine;
        let (unsolved, messages) = (tally.unsolved, tally.messages);
        text::print_json(&PoseSummary { machine, direction, rows, unsolved, messages, output })?;
    } else if !args.ends.to_stdout() {
        let (rows, none) = (tally.rows, tally.unsolved);
        text::print(&format!("{rows} rows, {none} without an answer\nwrote {output}\n"))?;
    }
    Ok(if tally.unsolved == 0 { Done::Kept } else { Done::Broken })
}

/// Summary for scripts.
#[derive(Debug, serde::Serialize)]
struct PoseSummary {
    machine: String,
    direction: String,
    /// Rows read.
    rows: u64,
    /// Number of rows without an answer, and the messages of the first of them.
    unsolved: u64,
    #[serde(rename = "told")]
    messages: Vec<String>,
    output: String,
}

/// Refuses options that do not go together.
fn usage(args: &PoseArgs, form: OutputForm) -> Result<(), Failure> {
    let refuse = |message: &str| Err(Failure::input(message));
    if form.is_json() && args.ends.to_stdout() {
        return refuse("--json prints a summary on stdout\n  help: give the table a file with -o");
    }
    if args.all && args.direction != Direction::Inverse {
        return refuse("--all goes with `inverse` only");
    }
    if args.arc_length && args.direction != Direction::Jets {
        return refuse("--arc-length goes with `jets` only");
    }
    if args.near.is_some() && (args.all || args.direction == Direction::Forward) {
        return refuse(
            "--near sets the starting position: it goes with `inverse` and `jets`, without --all",
        );
    }
    Ok(())
}

/// Returns the home position with some axes changed: `C=10,B=20` in mm and degrees.
fn near(machine: &Machine, words: &str) -> Result<AxisVector, Failure> {
    let mut q = machine.home();
    for word in words.split(',').filter(|word| !word.trim().is_empty()) {
        let fault = |what: String| Failure::input(format!("--near {words}: {what}"));
        let (name, value) = word
            .split_once('=')
            .ok_or_else(|| fault(format!("{word:?} is not of the form C=10")))?;
        let index = machine.index_of(name.trim()).ok_or_else(|| {
            let names = machine.axes.each_ref().map(|axis| axis.name.as_str()).join(", ");
            fault(format!("{} has no axis {}; it has {names}", machine.name, name.trim()))
        })?;
        let value = finite(value).map_err(|what| fault(format!("{word}: {what}")))?;
        // Options are in degrees, axis vectors in radians.
        q[index] = if index < FIRST_ROTARY { value } else { value.to_radians() };
    }
    Ok(q)
}

/// Axes to poses.
struct Forward {
    kinematics: Kinematics,
    names: [String; 5],
}

impl Work for Forward {
    fn columns(&self) -> Vec<String> {
        self.names.to_vec()
    }

    fn header(&self) -> String {
        POSE.join(",")
    }

    fn row(&mut self, values: Option<&[f64]>, out: &mut String) -> Result<(), Refusal> {
        let Some(values) = values else {
            // An empty row keeps input and output aligned line by line.
            out.push_str(",,,,,\n");
            return Err(Refusal::Unsolved("the row has no axis position".into()));
        };
        let q = AxisVector::from_fn(|row, _| {
            let value = values.get(row).copied().unwrap_or_default();
            if row < FIRST_ROTARY { value } else { value.to_radians() }
        });
        let ToolPose { tip, axis } = self.kinematics.forward(&q);
        let numbers = [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z];
        // Positions of 1e300 mm overflow in the products of the chain.
        if !numbers.iter().all(|number| number.is_finite()) {
            out.push_str(",,,,,\n");
            return Err(Refusal::Unsolved("the pose is too large to compute with".into()));
        }
        numbers_to(out, numbers);
        out.push('\n');
        Ok(())
    }
}

/// Poses to axes inside travel, each continuing from the one before.
struct Follow {
    inverse: Inverse,
    names: [String; 5],
    near: AxisVector,
    pose: u64,
}

impl Work for Follow {
    fn columns(&self) -> Vec<String> {
        POSE.map(str::to_owned).to_vec()
    }

    fn header(&self) -> String {
        format!("pose,solution,{}", self.names.join(","))
    }

    fn row(&mut self, values: Option<&[f64]>, out: &mut String) -> Result<(), Refusal> {
        self.pose += 1;
        let pose = pose(values)?;
        match self.inverse.continued(&pose, &self.near) {
            Ok(found) => {
                // The next row continues from here, so that rotaries do not jump between branches.
                self.near = found.q;
                let solution = if found.branch == Some(Branch::Minus) { 2 } else { 1 };
                solution_to(out, self.pose, solution, &found.q);
                Ok(())
            }
            Err(error) => Err(unreached(out, self.pose, &error)),
        }
    }
}

/// Poses to axes on every branch.
struct All {
    inverse: Inverse,
    names: [String; 5],
    pose: u64,
}

impl Work for All {
    fn columns(&self) -> Vec<String> {
        POSE.map(str::to_owned).to_vec()
    }

    fn header(&self) -> String {
        format!("pose,solution,{}", self.names.join(","))
    }

    fn row(&mut self, values: Option<&[f64]>, out: &mut String) -> Result<(), Refusal> {
        self.pose += 1;
        match self.inverse.solutions(&pose(values)?) {
            Ok(InverseSolutions::Singular(mut q)) => {
                // The first rotary is free, and stands at its home, whatever turn that is.
                q[SECOND_ROTARY] = half_open(q)[SECOND_ROTARY];
                solution_to(out, self.pose, 1, &q);
            }
            Ok(InverseSolutions::Regular(both)) => {
                for (solution, q) in (1..).zip(both) {
                    solution_to(out, self.pose, solution, &half_open(q));
                }
            }
            Err(error) => return Err(unreached(out, self.pose, &error)),
        }
        Ok(())
    }
}

/// Moves rotaries into (-180, 180] deg: -180 becomes 180.
fn half_open(q: AxisVector) -> AxisVector {
    let fold = |angle: f64| if angle <= -std::f64::consts::PI { -angle } else { angle };
    AxisVector::from_fn(|row, _| if row < FIRST_ROTARY { q[row] } else { fold(q[row]) })
}

/// Poses with derivatives to axes with derivatives.
struct Jets {
    inverse: Inverse,
    names: [String; 5],
    near: AxisVector,
    arc_length: bool,
}

/// Suffixes of the derivatives of a column.
const ORDERS: [&str; 4] = ["", "1", "2", "3"];

impl Work for Jets {
    fn columns(&self) -> Vec<String> {
        let order = |order: &str| POSE.map(|name| format!("{name}{order}"));
        ORDERS.into_iter().flat_map(order).collect()
    }

    fn header(&self) -> String {
        let order = |order: &str| self.names.each_ref().map(|name| format!("{name}{order}"));
        ORDERS.into_iter().flat_map(order).collect::<Vec<_>>().join(",")
    }

    fn row(&mut self, values: Option<&[f64]>, out: &mut String) -> Result<(), Refusal> {
        let values = values.unwrap_or_default();
        pose(Some(values))?;
        let part = |order: usize, first: usize| {
            let at = |row: usize| values.get(6 * order + first + row).copied().unwrap_or_default();
            [at(0), at(1), at(2)].into()
        };
        let rows = |first: usize| [0, 1, 2, 3].map(|order| part(order, first));
        // The contact is not used by the inverse; the tip stands in for it.
        let rates = PoseRates { tip: rows(0), axis: rows(3), contact: rows(0) };
        let answer = self
            .inverse
            .jets_continued(&rates, &self.near)
            .map_err(|error| error.to_string())
            .and_then(|q| self.by_parameter(q, &rates));
        match answer {
            Ok(q) => {
                self.near = q[0];
                for (order, row) in q.iter().enumerate() {
                    if order > 0 {
                        out.push(',');
                    }
                    axes_to(out, row);
                }
                out.push('\n');
                Ok(())
            }
            Err(why) => {
                // Four orders of five axes: empty fields keep the columns.
                out.push_str(&",".repeat(4 * self.names.len() - 1));
                out.push('\n');
                Err(Refusal::Unsolved(why))
            }
        }
    }
}

impl Jets {
    fn by_parameter(
        &self,
        q: [AxisVector; 4],
        rates: &PoseRates,
    ) -> Result<[AxisVector; 4], String> {
        if !self.arc_length {
            return Ok(q);
        }
        let ([q0, q1, q2, q3], [_, p1, p2, p3]) = (q, rates.tip);
        let [t, k, l] = by_arc_length([q1, q2, q3], [p1, p2, p3]).ok_or(
            "the tip stands still (x1 = y1 = z1 = 0): there are no derivatives by its arc length; leave out --arc-length",
        )?;
        Ok([q0, t, k, l])
    }
}

fn pose(values: Option<&[f64]>) -> Result<ToolPose, Refusal> {
    let [x, y, z, i, j, k] =
        values.and_then(|values| values.first_chunk()).copied().unwrap_or_default();
    ToolPose::new([x, y, z], [i, j, k])
        .ok_or_else(|| Refusal::Malformed("the tool axis i,j,k is the zero vector".into()))
}

/// Appends the row of a solution: `pose,solution,` and the axes.
fn solution_to(out: &mut String, pose: u64, solution: u32, q: &AxisVector) {
    // Writing to a string cannot fail.
    let _ = write!(out, "{pose},{solution},");
    axes_to(out, q);
    out.push('\n');
}

/// Appends a row without axes, and returns the reason. Solutions count from 1: 0 is none.
fn unreached(out: &mut String, pose: u64, error: &InverseError) -> Refusal {
    let _ = writeln!(out, "{pose},0,,,,,");
    Refusal::Unsolved(error.to_string())
}

/// Appends axes, or their derivatives, in mm and degrees.
fn axes_to(out: &mut String, q: &AxisVector) {
    let [x, y, z, first, second] = (*q).into();
    numbers_to(out, [x, y, z, first.to_degrees(), second.to_degrees()]);
}

fn numbers_to<const N: usize>(out: &mut String, numbers: [f64; N]) {
    for (index, number) in numbers.into_iter().enumerate() {
        if index > 0 {
            out.push(',');
        }
        write_number(out, number);
    }
}
