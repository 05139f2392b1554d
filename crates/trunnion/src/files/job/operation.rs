//! The job's `[[operation]]` tables: what an operation leaves out is as in the tables of the job.

use super::super::document::Document;
use super::super::path::join;
use super::cutting::cutting;
use super::data::{FaceSelection, JobArea, JobOperation, JobTool};
use super::part::faces;
use super::raw::{RawCutting, RawMethod, RawOperation, RawStrategy, RawToolChoice};
use super::strategy::{side_of, strategy};
use super::tool::tool;

/// Key of the tables.
pub(super) const KEY: &str = "operation";

/// Tools and faces of the job, which are those of an operation that states none.
#[derive(Debug, Clone, Copy)]
pub(super) struct OperationDefaults<'a> {
    /// The tool of the job.
    pub(super) tool: Option<&'a JobTool>,
    /// Tools described for the check of other programs.
    pub(super) others: &'a [JobTool],
    pub(super) faces: Option<&'a FaceSelection>,
}

/// Tool of an operation, as written.
enum OperationTool {
    OfJob,
    Number(u32),
    Own(JobTool),
    Faulty,
}

/// Operations as read, without the tools that are described elsewhere.
pub(super) struct ReadOperations {
    raw: Vec<Option<RawOperation>>,
    tools: Vec<OperationTool>,
}

impl ReadOperations {
    /// Reads the tables, and the tools in them.
    pub(super) fn read(doc: &mut Document<'_>) -> Self {
        let mut raw = doc.list::<RawOperation>(KEY);
        let tools = raw.iter_mut().enumerate().map(|(index, raw)| {
            let Some(raw) = raw else { return OperationTool::Faulty };
            match raw.tool.take() {
                None => OperationTool::OfJob,
                Some(RawToolChoice::Number(number)) => OperationTool::Number(number),
                Some(RawToolChoice::Tool(raw)) => {
                    let own = tool(*raw, &path(index, "tool"), doc);
                    own.map_or(OperationTool::Faulty, OperationTool::Own)
                }
            }
        });
        let tools = tools.collect();
        Self { raw, tools }
    }

    /// Returns true without any.
    pub(super) fn is_empty(&self) -> bool {
        self.raw.is_empty()
    }

    /// Returns the tools that the operations describe.
    pub(super) fn described(&self) -> impl Iterator<Item = &JobTool> {
        self.tools.iter().filter_map(|tool| match tool {
            OperationTool::Own(tool) => Some(tool),
            _ => None,
        })
    }

    /// Returns the operations, if their entries agree with each other and with the job.
    pub(super) fn with(
        self,
        defaults: OperationDefaults<'_>,
        doc: &mut Document<'_>,
    ) -> Option<Vec<JobOperation>> {
        one_number_one_tool(&self, defaults.tool, doc);
        let tools: Vec<Option<JobTool>> =
            (0..self.tools.len()).map(|index| self.tool(index, defaults, doc)).collect();
        let mut all = Vec::new();
        for (index, (raw, tool)) in self.raw.into_iter().zip(tools).enumerate() {
            all.push(
                raw.and_then(|raw| operation(raw, index, OperationParts { tool, defaults }, doc)),
            );
        }
        // One faulty operation is enough to refuse the job, but only after all were read.
        all.into_iter().collect()
    }

    /// Returns the tool of an operation.
    fn tool(
        &self,
        index: usize,
        defaults: OperationDefaults<'_>,
        doc: &mut Document<'_>,
    ) -> Option<JobTool> {
        let number = match self.tools.get(index)? {
            OperationTool::OfJob => return defaults.tool.cloned(),
            OperationTool::Own(tool) => return Some(tool.clone()),
            OperationTool::Faulty => return None,
            OperationTool::Number(number) => *number,
        };
        let mut known = defaults.tool.into_iter().chain(self.described()).chain(defaults.others);
        let found = known.find(|tool| tool.number == number).cloned();
        if found.is_none() {
            let message = format!("tool {number} is not described in this job");
            let help = "describe it here, with the keys of [tool], as in `tool = { number = 2, kind = \"ball\", diameter = 6, \
                        length = 80 }`";
            doc.fault(&path(index, "tool"), message, help);
        }
        found
    }
}

fn path(index: usize, key: &str) -> String {
    join(&join(KEY, &index.to_string()), key)
}

/// Refuses a number for two different tools.
fn one_number_one_tool(read: &ReadOperations, own: Option<&JobTool>, doc: &mut Document<'_>) {
    for (index, tool) in read.tools.iter().enumerate() {
        let OperationTool::Own(tool) = tool else { continue };
        let before = read.tools.iter().take(index).filter_map(|tool| match tool {
            OperationTool::Own(tool) => Some(tool),
            _ => None,
        });
        let mut before = own.into_iter().chain(before);
        if before.any(|other| other.number == tool.number && other != tool) {
            let message = format!("tool {} is given twice, and differently", tool.number);
            let help = "give every tool its own number; the number alone is enough the second time";
            doc.fault(&path(index, "tool"), message, help);
        }
    }
}

/// Tool of an operation, and the tables of the job.
struct OperationParts<'a> {
    tool: Option<JobTool>,
    defaults: OperationDefaults<'a>,
}

fn operation(
    raw: RawOperation,
    index: usize,
    parts: OperationParts<'_>,
    doc: &mut Document<'_>,
) -> Option<JobOperation> {
    let OperationParts { tool, defaults } = parts;
    let selected = match raw.faces {
        Some(raw) => faces(raw, &path(index, "faces"), doc),
        None => defaults.faces.cloned(),
    };
    let own_cutting = doc.merged::<RawCutting>("cutting", [KEY, &index.to_string()]);
    let strategy_path = path(index, "strategy");
    let mut own = doc.merged::<RawStrategy>("strategy", [KEY, &index.to_string()])?;
    own.method = raw.method.unwrap_or(own.method);
    if own.method == RawMethod::Rest && index == 0 {
        let message =
            "method \"rest\" cuts what the operations before have left, and this is the first";
        doc.fault(&path(index, "method"), message, "put the operation behind another one");
    }
    let own = strategy(&own, tool.as_ref(), &strategy_path, doc);
    if let (Some(tool), Some(own)) = (&tool, &own) {
        side_of(tool, own, &strategy_path, doc);
    }
    let (tool, own) = (tool?, own?);
    let area = match own.area {
        JobArea::Whole => "",
        JobArea::Rest => ", rest",
    };
    Some(JobOperation {
        name: raw
            .name
            .unwrap_or_else(|| format!("operation {}, T{}{area}", index + 1, tool.number)),
        faces: selected?,
        tool,
        strategy: own,
        cutting: cutting(&own_cutting?),
    })
}
