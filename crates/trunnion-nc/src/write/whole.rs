//! All blocks of a plan as one program.

use super::error::WriteError;
use super::note::Note;
use super::position::WrittenPosition;
use super::program::{BlockPace, ProgramForm, ProgramWriter};
use super::sheet::SheetTool;
use super::style::Style;
use super::template::Template;
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::types::{Block, Motion};

/// Writes blocks with their passes and the remarks of the note. Returns the byte offsets at which
/// the texts of the blocks end; the first is the end of the head of the program.
///
/// The first block is the starting position. Links run at their planned time, too: all axes together. A block
/// whose words all round to those before it is left out, and its time is added to the next.
///
/// # Example
///
/// ```
/// use trunnion_motion::machine::{KinematicChain, Kinematics, Machine, MachineSpec, Setup};
/// use trunnion_nc::write::{
///     AxisWords, Coolant, Note, OutputFormat, ProgramForm, Style, Template, ToolNote, program,
/// };
/// use trunnion_types::types::{AxisVector, Block, Motion};
///
/// let chain = KinematicChain::new()
///     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
///     .rotary("A", [1.0, 0.0, 0.0], [0.0; 3])
///     .bed()
///     .linear("X", [1.0, 0.0, 0.0])
///     .linear("Y", [0.0, 1.0, 0.0])
///     .linear("Z", [0.0, 0.0, 1.0]);
/// let machine = Machine::new(MachineSpec::from(chain))?;
/// let kinematics = Kinematics::new(&machine, &Setup::default());
/// let block = |x: f64, duration: f64| {
///     let mut q = AxisVector::zeros();
///     q[0] = x;
///     Block { motion: Motion::Cut, q, pose: kinematics.forward(&q), duration }
/// };
/// let note = Note {
///     name: "demo",
///     tool: ToolNote { number: 1, major: 0.0, minor: 5.0 },
///     spindle: 8000.0,
///     coolant: Coolant::Off,
///     feed: 10.0,
///     budget: &[],
///     duration: 0.5,
///     remarks: &[],
/// };
/// let style = Style::of(&kinematics, OutputFormat::Fanuc, AxisWords::of(&machine)?);
/// let template = Template::of(OutputFormat::Fanuc)?;
///
/// let mut text = String::new();
/// let form = ProgramForm { note: &note, style: &style, template: &template, changes: &[] };
/// program(&mut text, &kinematics, &[block(0.0, 0.0), block(5.0, 0.5)], form)?;
/// assert!(text.contains("G1 X5. F600."));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`WriteError`].
pub fn program(
    out: &mut String,
    kinematics: &Kinematics,
    blocks: &[Block],
    form: ProgramForm<'_>,
) -> Result<Vec<usize>, WriteError> {
    let ProgramForm { note, style, template, .. } = form;
    let section = ToolSection { kinematics, note, blocks };
    let ends = sections(out, &[section], style, template)?;
    Ok(ends.into_iter().next().unwrap_or_default())
}

/// Blocks that one tool runs in a program of several.
#[derive(Debug, Clone, Copy)]
pub struct ToolSection<'a> {
    /// Machine and setup, with the length of the tool.
    pub kinematics: &'a Kinematics,
    /// Facts about the tool and its cuts. The head of the program has those of the first section.
    pub note: &'a Note<'a>,
    /// Blocks; the first is the starting position.
    pub blocks: &'a [Block],
}

/// Writes the blocks of several tools, with a change of tool in front of each but the first. Returns the ends of the
/// texts of the blocks as [`program`] does, section by section.
///
/// # Errors
///
/// [`WriteError`].
pub fn sections(
    out: &mut String,
    sections: &[ToolSection<'_>],
    style: &Style,
    template: &Template,
) -> Result<Vec<Vec<usize>>, WriteError> {
    let mut writer: Option<ProgramWriter> = None;
    let mut ends = Vec::new();
    let tool = |of: &ToolSection<'_>| SheetTool {
        tool: of.note.tool,
        length: of.kinematics.setup().tool_length,
    };
    let tools = SheetTool::each_once(sections.iter().map(tool));
    for section in sections {
        let &ToolSection { kinematics, note, blocks } = section;
        let first = blocks.first().ok_or(WriteError::Empty)?;
        let start = WrittenPosition { q: &first.q, pose: &first.pose };
        let mut at_start = match writer.take() {
            None => {
                let form = ProgramForm {
                    note,
                    style,
                    template,
                    changes: tools.get(1..).unwrap_or_default(),
                };
                ProgramWriter::new(out, kinematics, form, start)?
            }
            Some(mut before) => {
                before.comment(out, &note.tool.to_string());
                before.change_tool(out, kinematics, note, template, start)?;
                before
            }
        };
        ends.push(section_blocks(out, &mut at_start, section)?);
        writer = Some(at_start);
    }
    writer.ok_or(WriteError::Empty)?.finish(out);
    Ok(ends)
}

/// Writes the blocks of a section behind its starting position.
fn section_blocks(
    out: &mut String,
    writer: &mut ProgramWriter,
    section: &ToolSection<'_>,
) -> Result<Vec<usize>, WriteError> {
    let (mut before, rest) = section.blocks.split_first().ok_or(WriteError::Empty)?;
    let mut ends = vec![out.len()];
    let mut remarks = section.note.remarks.iter().peekable();
    let mut passes = PassComments::default();
    for (index, block) in rest.iter().enumerate() {
        // Remarks stand before their block; several may stand before one.
        while let Some(remark) = remarks.next_if(|remark| remark.block <= index + 1) {
            writer.comment(out, &remark.text);
            passes.interrupt();
        }
        if let Some(line) = passes.line(block.motion) {
            writer.comment(out, &line);
        }
        let to = WrittenPosition { q: &block.q, pose: &block.pose };
        writer.block(out, to, pace(before, block))?;
        ends.push(out.len());
        before = block;
    }
    Ok(ends)
}

/// Returns the time and travel of a block from the one before.
pub fn pace(before: &Block, block: &Block) -> BlockPace {
    let length = (block.pose.tip - before.pose.tip).norm();
    // Root of the sum of squares of both rotaries, as F has it where the tip stands.
    let turn = (block.q - before.q).fixed_rows::<2>(FIRST_ROTARY).norm();
    BlockPace::Timed { seconds: block.duration, length, turn }
}

/// Counts passes; one that a remark parts goes on.
#[derive(Debug, Default)]
struct PassComments {
    motion: Option<Motion>,
    count: u32,
    interrupted: bool,
}

impl PassComments {
    fn interrupt(&mut self) {
        self.interrupted = self.motion == Some(Motion::Cut);
    }

    /// Returns the comment before the first block of a pass.
    fn line(&mut self, motion: Motion) -> Option<String> {
        let begins = self.motion.replace(motion) != Some(motion) && motion == Motion::Cut;
        if !begins {
            return None;
        }
        let goes_on = std::mem::take(&mut self.interrupted);
        self.count += u32::from(!goes_on);
        Some(format!("pass {}{}", self.count, if goes_on { " goes on" } else { "" }))
    }
}
