//! Tools and work offsets as a control has them in its tables, beyond the one of the setup.

use super::VerifyError;
use super::replay::Control;
use crate::cutter::Cutter;
use crate::machine::{Kinematics, Setup};
use crate::nc::read::{ClSource, ClTool, ProgramSource, Step};
use nalgebra::{Point3, Vector3};

/// What stands in the tables of a control beside the setup's own tool and `G54`.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    /// Tools of a program that calls several; empty: it has one, whatever its number.
    pub tools: &'a [Tool<'a>],
    /// Work offsets; `G54` is that of the setup if it is not here.
    pub offsets: &'a [WorkOffset],
}

impl Tables<'_> {
    /// One tool, and `G54`.
    pub const NONE: Tables<'static> = Tables { tools: &[], offsets: &[] };
}

/// A tool by its number.
#[derive(Debug, Clone, Copy)]
pub struct Tool<'a> {
    /// What the program calls it.
    pub number: u32,
    /// The tool, from tip to gauge point: its length is the tool length.
    pub cutter: &'a Cutter,
}

/// A work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkOffset {
    /// 0 for `G54`, 1 for `G55` and so on, see [`Frame::Work`](crate::nc::read::Frame::Work).
    pub number: u8,
    /// Positions of X, Y, Z as they stand in the table: with the gauge point on the origin and the rotaries at
    /// zero \[mm\].
    pub origin: Vector3<f64>,
}

/// How often the tool is changed, and what is not known of the ways there: where a change leaves X, Y and Z is the
/// machine's own. They are known again once the program tells them; the rotaries are taken to stand as before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Changes {
    /// Tools put in after the first move.
    pub count: usize,
    /// Line of the first.
    pub line: u32,
    /// Rapid moves that were not measured: before X, Y and Z were told, or before the first tool.
    pub unmeasured: usize,
    /// Line of the first of them.
    pub first: Option<u32>,
}

/// The control of a machine, one for each tool.
pub(super) struct Controls {
    first: Control,
    others: Vec<Control>,
    /// Numbers, where there are several.
    numbers: Vec<u32>,
}

impl Controls {
    /// `[believed, real]` machines with the setup's tool.
    pub(super) fn new(
        [believed, real]: [&Kinematics; 2],
        tables: &Tables<'_>,
    ) -> Result<Self, VerifyError> {
        let with = |of: &Kinematics, by: f64| {
            let tool_length = of.setup().tool_length + by;
            Kinematics::new(of.machine(), &Setup { tool_length, ..*of.setup() })
        };
        let each = |tool: &Tool<'_>| {
            let by = tool.cutter.length() - believed.setup().tool_length;
            Control::new(with(believed, by), with(real, by))
        };
        let mut all = tables.tools.iter().map(each);
        let first = all.next().unwrap_or_else(|| Control::new(believed.clone(), real.clone()))?;
        let others: Result<Vec<Control>, VerifyError> = all.collect();
        let numbers = tables.tools.iter().map(|tool| tool.number).collect();
        Ok(Self { first, others: others?, numbers })
    }

    /// That of a tool by its place in the table.
    pub(super) fn of(&self, tool: usize) -> &Control {
        let other = tool.checked_sub(1).and_then(|place| self.others.get(place));
        other.unwrap_or(&self.first)
    }

    /// That of the only or first tool.
    pub(super) fn first(&self) -> &Control {
        &self.first
    }

    /// Whether tools are told apart by their numbers.
    pub(super) fn are_several(&self) -> bool {
        !self.numbers.is_empty()
    }

    /// Place of a tool in the table.
    pub(super) fn place(&self, line: u32, number: u32) -> Result<usize, VerifyError> {
        if !self.are_several() {
            return Ok(0);
        }
        let found = self.numbers.iter().position(|known| *known == number);
        found.ok_or(VerifyError::UnknownTool { line, number })
    }
}

/// Cutters by their places in the table.
pub(super) fn cutters<'a>(only: &'a Cutter, tools: &[Tool<'a>]) -> Vec<&'a Cutter> {
    if tools.is_empty() {
        return vec![only];
    }
    tools.iter().map(|tool| tool.cutter).collect()
}

/// Places in the table of the tools of a CL file, each from a location on.
pub(super) fn places(
    file: &dyn ClSource,
    tools: &[Tool<'_>],
) -> Result<Vec<(usize, usize)>, VerifyError> {
    let loaded = file.tools();
    if tools.is_empty() {
        let Some(first) = loaded.first() else { return Ok(Vec::new()) };
        return match loaded.iter().find(|tool| tool.number != first.number) {
            Some(&ClTool { line, number, .. }) => {
                Err(VerifyError::Tools { line, numbers: [first.number, number] })
            }
            None => Ok(Vec::new()),
        };
    }
    if loaded.first().is_none_or(|first| first.record > 0) {
        let line = file.records().next().map_or(0, |record| record.line);
        return Err(VerifyError::NoTool { line });
    }
    let place = |&ClTool { record, line, number }: &ClTool| {
        let place = tools.iter().position(|tool| tool.number == number);
        Ok((record, place.ok_or(VerifyError::UnknownTool { line, number })?))
    };
    loaded.iter().map(place).collect()
}

/// Refuses a program with several tools where the table has none.
pub(super) fn known(program: &dyn ProgramSource, tables: &Tables<'_>) -> Result<(), VerifyError> {
    let Some(&first) = program.tools().first() else { return Ok(()) };
    if !tables.tools.is_empty() || program.tools().iter().all(|number| *number == first) {
        return Ok(());
    }
    let second = program.steps().find_map(|step| match step {
        Step::Tool { line, number } if number != first => Some((line, number)),
        _ => None,
    });
    let (line, number) = second.unwrap_or((0, first));
    Err(VerifyError::Tools { line, numbers: [first, number] })
}

/// Work offsets as a program finds and leaves them.
#[derive(Debug, Clone)]
pub(super) struct Offsets(Vec<(WorkOffset, Vector3<f64>)>);

/// Siemens `G500`: words count from machine zero.
const NO_OFFSET: u8 = u8::MAX;

impl Offsets {
    /// Those of a table, and `G54` of the setup.
    pub(super) fn new(control: &Control, tables: &Tables<'_>) -> Self {
        let mut offsets = Self(Vec::new());
        let setup = WorkOffset { number: 0, origin: control.offset() };
        // The setup's own is at the workpiece origin to the last digit.
        offsets.0.push((setup, Vector3::zeros()));
        offsets.set(control, WorkOffset { number: NO_OFFSET, origin: Vector3::zeros() });
        tables.offsets.iter().for_each(|of| offsets.set(control, *of));
        offsets
    }

    /// Writes one.
    pub(super) fn set(&mut self, control: &Control, of: WorkOffset) {
        self.0.retain(|(known, _)| known.number != of.number);
        self.0.push((of, control.in_table(&of.origin)));
    }

    /// Its values, and its origin in the table frame \[mm\].
    pub(super) fn get(&self, line: u32, number: u8) -> Result<[Vector3<f64>; 2], VerifyError> {
        let found = self.0.iter().find(|(known, _)| known.number == number);
        let (of, place) = found.ok_or(VerifyError::WorkOffset { line, number })?;
        Ok([of.origin, *place])
    }
}

/// What a work offset is called.
pub(super) fn name(number: u8) -> String {
    match number {
        0..=5 => format!("G{}", 54 + number),
        6..=8 => format!("G59.{}", number - 5),
        NO_OFFSET => "G500".to_owned(),
        _ => format!(
            "G54.1 P{0} (Siemens G{1}, Heidenhain preset {2})",
            number - 8,
            501 + u16::from(number),
            u16::from(number) + 1
        ),
    }
}

/// The same for the command line.
pub(super) fn plain_name(number: u8) -> String {
    match number {
        0..=8 | NO_OFFSET => name(number),
        _ => format!("G54.1P{}", number - 8),
    }
}

/// Where an offset puts the origin in the table frame: the gauge point, with the rotaries at zero.
pub(super) fn origin(bare: &Kinematics, joints: &Vector3<f64>) -> Vector3<f64> {
    let q = crate::types::AxisVector::new(joints.x, joints.y, joints.z, 0.0, 0.0);
    let place: Point3<f64> = bare.forward(&q).tip;
    bare.setup().rotation * place.coords
}
