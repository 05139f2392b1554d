//! Controls with the tools and work offsets of their tables.

use super::control::Control;
use super::tables::{Tables, Tool};
use crate::cutter::Cutter;
use crate::machine::{Kinematics, Setup};
use crate::nc::control::{NO_OFFSET, WorkOffset, WorkOffsets, position_of};
use crate::nc::read::{ClSource, ClTool, ProgramSource, Step};
use crate::verify::error::VerifyError;
use nalgebra::Vector3;

/// The control of a machine, one for each tool.
pub(crate) struct Controls {
    first: Control,
    others: Vec<Control>,
    /// Numbers, where there are several.
    numbers: Vec<u32>,
}

impl Controls {
    /// Takes the machine as its control knows it, and as it is, with the setup's tool.
    pub(crate) fn new(
        believed: &Kinematics,
        real: &Kinematics,
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
    pub(crate) fn of(&self, tool: usize) -> &Control {
        let other = tool.checked_sub(1).and_then(|place| self.others.get(place));
        other.unwrap_or(&self.first)
    }

    /// That of the only or first tool.
    pub(crate) fn first(&self) -> &Control {
        &self.first
    }

    /// Returns true if the table gives tools by number.
    pub(crate) fn are_several(&self) -> bool {
        !self.numbers.is_empty()
    }

    /// Position of a tool in the table.
    pub(crate) fn position(&self, line: u32, number: u32) -> Result<usize, VerifyError> {
        position_of(&self.numbers, number).ok_or(VerifyError::UnknownTool { line, number })
    }
}

/// Cutters by their places in the table.
pub(crate) fn cutters<'a>(only: &'a Cutter, tools: &[Tool<'a>]) -> Vec<&'a Cutter> {
    if tools.is_empty() {
        return vec![only];
    }
    tools.iter().map(|tool| tool.cutter).collect()
}

/// First record of a tool in a CL file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ToolStart {
    /// Index of the record.
    pub(crate) record: usize,
    /// Position of the tool in the table.
    pub(crate) tool: usize,
}

/// Returns the starts of the tools of a CL file.
pub(crate) fn tool_starts(
    file: &dyn ClSource,
    tools: &[Tool<'_>],
) -> Result<Vec<ToolStart>, VerifyError> {
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
        let tool = tools.iter().position(|tool| tool.number == number);
        Ok(ToolStart { record, tool: tool.ok_or(VerifyError::UnknownTool { line, number })? })
    };
    loaded.iter().map(place).collect()
}

/// Refuses a program with several tools where the table has none.
pub(crate) fn known(program: &dyn ProgramSource, tables: &Tables<'_>) -> Result<(), VerifyError> {
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

/// Work offsets of a table, and `G54` of the setup.
pub(crate) fn work_offsets(control: &Control, tables: &Tables<'_>) -> WorkOffsets {
    let mut offsets = WorkOffsets::default();
    // The setup's own is at the workpiece origin to the last digit.
    offsets.set(WorkOffset { number: 0, origin: control.offset() }, Vector3::zeros());
    let none = WorkOffset { number: NO_OFFSET, origin: Vector3::zeros() };
    for offset in [none].iter().chain(tables.offsets) {
        offsets.set(*offset, control.in_table(&offset.origin));
    }
    offsets
}
