//! The setup sheet: what has to be entered at the control for the programs to be true.

use super::error::WriteError;
use super::error_bound::Coordinates;
use super::format::OutputFormat;
use super::note::{Note, ToolNote};
use super::style::Style;
use crate::control::NumberedLength;
use crate::machine::{AxisKind, Kinematics, TurnFormat};
use crate::math;
use crate::types::AxisVector;
use crate::words::AxisWords;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Write;

/// Returns the work offset of all programs: the positions of X, Y, Z at which, rotaries at zero and
/// no tool,
/// the gauge point stands on the workpiece origin \[mm\]. `None` if X, Y, Z do not span space.
///
/// The gauge point is affine in the linear axes, so four forward maps give it.
pub fn work_offset(kinematics: &Kinematics) -> Option<Vector3<f64>> {
    let length = kinematics.setup().tool_length;
    let gauge = |q: &AxisVector| {
        let pose = kinematics.forward(q);
        // Gauge point: from the tip along the tool axis by the gauge length.
        pose.tip.coords + pose.axis.into_inner() * length
    };
    let start = gauge(&AxisVector::zeros());
    let column = |axis: usize| {
        let mut q = AxisVector::zeros();
        q[axis] = 1.0;
        gauge(&q) - start
    };
    // g(q) = start + J q = 0 at the workpiece origin, so q = -J^-1 start.
    let columns = Matrix3::from_columns(&[column(0), column(1), column(2)]);
    columns.try_inverse().map(|inverse| -(inverse * start))
}

/// Programs that one setup sheet describes.
#[derive(Debug, Clone, Copy)]
pub struct SheetPrograms<'a> {
    /// Words of the axes.
    pub axes: AxisWords,
    /// Dialects of the programs that are written.
    pub dialects: &'a [OutputFormat],
    /// Tools of the programs with their lengths; empty for the one of the setup.
    pub tools: &'a [SheetTool],
}

/// Tool of a setup sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetTool {
    /// Number and shape.
    pub tool: ToolNote,
    /// Length from gauge point to tip \[mm\].
    pub length: f64,
}

impl SheetTool {
    /// Returns the tools with different numbers, in the order of their first cuts.
    pub fn each_once(all: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut tools: Vec<Self> = Vec::new();
        for one in all {
            if tools.iter().all(|known| known.tool.number != one.tool.number) {
                tools.push(one);
            }
        }
        tools
    }
}

/// Writes the setup sheet.
///
/// # Errors
///
/// [`WriteError::Store`], [`WriteError::WorkOffset`].
pub fn setup_sheet(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    programs: SheetPrograms<'_>,
) -> Result<(), WriteError> {
    let SheetPrograms { axes, dialects, tools } = programs;
    writeln!(out, "Setup sheet")?;
    writeln!(out)?;
    // Its other tools have a list of their own.
    for line in facts(kinematics, HeadNote { note, changes: &[] }, axes) {
        writeln!(out, "{line}")?;
    }
    writeln!(out)?;
    if !tools.is_empty() {
        writeln!(out, "Tools in the order of their first cuts")?;
        for SheetTool { tool, length } in tools {
            writeln!(out, "  {tool}, gauge length {length:.4} mm")?;
        }
        writeln!(out)?;
    }
    let length =
        |tool: &SheetTool| NumberedLength { number: tool.tool.number, length: tool.length };
    let lengths: Vec<NumberedLength> = tools.iter().map(length).collect();
    entries(out, kinematics, note, &lengths)?;
    writeln!(out)?;
    meanings(out, kinematics, dialects)?;
    writeln!(out)?;
    if !note.remarks.is_empty() {
        writeln!(out, "Watch")?;
        for remark in note.remarks {
            writeln!(out, "  {}", remark.text)?;
        }
        writeln!(out)?;
    }
    writeln!(out, "Tolerance budget (mm)")?;
    for (what, share) in note.budget {
        writeln!(out, "  {what:<28} {share:.6}")?;
    }
    Ok(())
}

/// Program that a setup sheet describes.
#[derive(Debug, Clone, Copy)]
pub struct SheetProgram<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Format, words and feed of the program.
    pub style: &'a Style,
    /// Lengths of its tools; empty for a single tool with the length of the setup.
    pub lengths: &'a [NumberedLength],
}

/// Writes the setup sheet of one program.
///
/// # Errors
///
/// [`WriteError::Store`], [`WriteError::WorkOffset`].
pub fn program_sheet(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    program: SheetProgram<'_>,
) -> Result<(), WriteError> {
    let SheetProgram { file, style, lengths } = program;
    writeln!(out, "Setup sheet of {file}")?;
    writeln!(out)?;
    for line in facts(kinematics, HeadNote { note, changes: &[] }, style.axes) {
        writeln!(out, "{line}")?;
    }
    writeln!(out)?;
    entries(out, kinematics, note, lengths)?;
    writeln!(out)?;
    let [roll, pitch, yaw] = turns(kinematics);
    let turned = format!("{roll:.4}, {pitch:.4}, {yaw:.4} deg about the fixed x, then y, then z");
    writeln!(out, "Coordinates")?;
    let points = match (style.dialect, style.dialect.coordinates()) {
        (OutputFormat::Apt, _) => "tool tip in the workpiece frame".to_owned(),
        (_, Coordinates::Axes) => "axis positions less the work offset and, along Z, less the tool length;\n                        \
             true only for the pivots, origin and tool length above".to_owned(),
        (_, Coordinates::Tip) => format!(
            "tool tip in the table frame: origin at the workpiece origin, axes parallel to\n                        \
             the machine's while all axes stand at zero; that is the workpiece frame turned by\n                        \
             {turned}"
        ),
    };
    writeln!(out, "  X Y Z                 {points}")?;
    let feed = if style.inverse_time {
        "one over the time of the block, in minutes (G93)"
    } else {
        "speed of the tip in mm/min, of the rotaries in deg/min where the tip stands: a cap"
    };
    writeln!(out, "  F                     {feed}")?;
    writeln!(
        out,
        "  tip reference         the lowest point of the cutter on its axis, not the ball centre"
    )?;
    for (word, axis) in style.axes.0.iter().zip(&kinematics.machine().axes) {
        let values = match axis.output.modulo {
            _ if !word.rotary => continue,
            TurnFormat::Unwound => "unwound: 370 is not 10",
            TurnFormat::Positive => "0 to 360; the control must take the shorter way",
            TurnFormat::Signed => "-180 to 180; the control must take the shorter way",
        };
        writeln!(out, "  {:<22}degrees, {values}", word.letter)?;
    }
    Ok(())
}

/// Writes the values to enter at the control.
fn entries(
    out: &mut impl Write,
    kinematics: &Kinematics,
    note: &Note<'_>,
    lengths: &[NumberedLength],
) -> Result<(), WriteError> {
    let offset = work_offset(kinematics).ok_or(WriteError::WorkOffset)?.map(unsigned_zero);
    writeln!(out, "Enter at the control")?;
    writeln!(
        out,
        "  G54 (every program)   X {:.4}  Y {:.4}  Z {:.4}",
        offset.x, offset.y, offset.z
    )?;
    writeln!(out, "  G54 of the rotaries   0, and no rotation of the work offset")?;
    let length = kinematics.setup().tool_length;
    let one = [NumberedLength { number: note.tool.number, length }];
    for NumberedLength { number, length } in if lengths.is_empty() { &one } else { lengths } {
        writeln!(out, "  tool length H{number:<8} Z {length:.4}")?;
    }
    writeln!(out, "Pivots assumed (machine coordinates, all axes at zero)")?;
    for axis in kinematics.machine().axes.iter().filter(|axis| axis.kind == AxisKind::Rotary) {
        let (p, d) = (axis.point, axis.dir);
        writeln!(
            out,
            "  {:<4} line through X {:.4}  Y {:.4}  Z {:.4}  along {:.6} {:.6} {:.6}{}",
            axis.name,
            p.x,
            p.y,
            p.z,
            d.x,
            d.y,
            d.z,
            if axis.sense < 0.0 { "  (counts against ISO 841)" } else { "" }
        )?;
    }
    Ok(())
}

/// Writes the meaning of the numbers in the programs.
fn meanings(
    out: &mut impl Write,
    kinematics: &Kinematics,
    dialects: &[OutputFormat],
) -> Result<(), WriteError> {
    let [roll, pitch, yaw] = turns(kinematics);
    writeln!(out, "Coordinates")?;
    writeln!(out, "  {:<20}  workpiece frame: as in the part file", "toolpath.cls")?;
    for dialect in dialects {
        let file = dialect.program_file();
        match (dialect, dialect.coordinates()) {
            (OutputFormat::Apt, _) => {
                writeln!(out, "  {file:<20}  X Y Z = tool tip in the workpiece frame")?;
            }
            (_, Coordinates::Tip) => writeln!(
                out,
                "  {file:<20}  X Y Z = tool tip in the table frame: origin at the workpiece origin,\n  \
                 \x20                     axes parallel to the machine's while all axes stand at zero, turning\n  \
                 \x20                     with the table; that is the workpiece frame turned by\n  \
                 \x20                     {roll:.4}, {pitch:.4}, {yaw:.4} deg about the fixed x, then y, then z"
            )?,
            (_, Coordinates::Axes) => writeln!(
                out,
                "  {file:<20}  X Y Z = axis positions less G54 and, along Z, less the tool length;\n  \
                 \x20                     true only for the pivots, origin and tool length above"
            )?,
        }
    }
    writeln!(
        out,
        "  tip reference         the lowest point of the cutter on its axis, not the ball centre\n  \
         rotaries              axis positions in degrees, unwound (370 is not 10)"
    )?;
    Ok(())
}

/// Returns a number without the sign of a zero at four decimals.
fn unsigned_zero(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}

/// Returns the turns of the workpiece about the fixed x, then y, then z \[deg\].
fn turns(kinematics: &Kinematics) -> [f64; 3] {
    // Rz(yaw) Ry(pitch) Rx(roll): turns about the fixed x, then y, then z.
    let angles: [f64; 3] = math::xyz_of_rotation(&kinematics.setup().rotation).into();
    angles.map(|angle| unsigned_zero(angle.to_degrees()))
}

/// Facts at the head of a program.
#[derive(Clone, Copy)]
pub(super) struct HeadNote<'a> {
    /// Facts about the first tool and all motion.
    pub(super) note: &'a Note<'a>,
    /// Tools that the program changes to.
    pub(super) changes: &'a [SheetTool],
}

/// Returns the lines that stand at the head of every program.
pub(super) fn facts(kinematics: &Kinematics, head: HeadNote<'_>, axes: AxisWords) -> Vec<String> {
    let HeadNote { note, changes } = head;
    let (machine, setup) = (kinematics.machine(), kinematics.setup());
    let [roll, pitch, yaw] = turns(kinematics);
    let [x, y, z] = <[f64; 3]>::from(setup.origin).map(unsigned_zero);
    let first = SheetTool { tool: note.tool, length: setup.tool_length };
    let budget: Vec<String> =
        note.budget.iter().map(|(what, share)| format!("{what} {share:.6}")).collect();
    let reversed = axes.0.iter().any(|word| word.reversed);
    let mut lines = vec![
        format!("job      {}", note.name),
        format!("machine  {}, chain {}, words {axes}", machine.name, machine.chain.join(" ")),
        format!("rotaries {}", if reversed { "written reversed" } else { "as the machine counts" }),
        format!("origin   X {x:.4} Y {y:.4} Z {z:.4} mm in machine coordinates, all axes at zero"),
        format!("rotation {roll:.4} {pitch:.4} {yaw:.4} deg about the fixed x, then y, then z"),
    ];
    lines.extend(std::iter::once(&first).chain(changes).map(tool_fact));
    // A program that is written while its input is read knows neither yet.
    if note.feed > 0.0 {
        let feed = note.feed * 60.0;
        lines.push(format!("cutting  feed {feed:.1} mm/min, spindle {:.0} 1/min", note.spindle));
    }
    if !budget.is_empty() {
        lines.push(format!("budget   {} mm", budget.join(", ")));
    }
    if note.duration > 0.0 {
        lines.push(format!("time     {:.1} s planned", note.duration));
    }
    lines
}

fn tool_fact(of: &SheetTool) -> String {
    let ToolNote { number, major, minor } = of.tool;
    format!(
        "tool     T{number} R {major:.4} r {minor:.4} mm, gauge length {:.4} mm, reference: tip",
        of.length
    )
}
