//! The motion that is checked, with tools and faces.

use super::error::VerifyError;
use crate::cutter::Cutter;
use crate::machine::Kinematics;
use crate::nc::control::WorkOffset;
use crate::nc::read::{ClSource, ProgramSource};
use crate::surface::Face;
use crate::types::UncutRegion;
use crate::verify::replay::controls::{self, Controls};
use crate::verify::replay::segments::Run;
use crate::verify::replay::tables::{Tables, Tool};

/// Source of the motion.
#[derive(Debug, Clone, Copy)]
pub(super) enum MotionSource<'a> {
    /// A program, run from the machine's home position.
    Program {
        /// Its steps, or its text where it is long.
        program: &'a dyn ProgramSource,
        /// Machine and setup as the control knows them: work offset, tool length, pivots.
        control: &'a Kinematics,
        /// Machine and setup as they are.
        machine: &'a Kinematics,
    },
    /// Cutter locations: the tip runs straight, the tool axis on a great circle from one to the next.
    Locations(&'a dyn ClSource),
}

/// Motion to be checked, with its tools and the faces that it cuts.
#[derive(Debug, Clone, Copy)]
pub struct CheckInput<'a> {
    pub(super) motion: MotionSource<'a>,
    pub(super) faces: &'a [Face],
    pub(super) cutter: &'a Cutter,
    pub(super) rest: &'a [UncutRegion],
    pub(super) tables: Tables<'a>,
}

impl<'a> CheckInput<'a> {
    /// A program on a machine with one tool, from tip to gauge point.
    pub fn program(
        program: &'a dyn ProgramSource,
        kinematics: &'a Kinematics,
        cutter: &'a Cutter,
    ) -> Self {
        let motion = MotionSource::Program { program, control: kinematics, machine: kinematics };
        Self::new(motion, cutter)
    }

    /// Cutter locations of one tool. Axes are not audited: a CL file has none.
    pub fn locations(file: &'a dyn ClSource, cutter: &'a Cutter) -> Self {
        Self::new(MotionSource::Locations(file), cutter)
    }

    fn new(motion: MotionSource<'a>, cutter: &'a Cutter) -> Self {
        Self { motion, faces: &[], cutter, rest: &[], tables: Tables::NONE }
    }

    /// Sets the faces to be cut, in the workpiece frame.
    #[must_use]
    pub fn faces(self, faces: &'a [Face]) -> Self {
        Self { faces, ..self }
    }

    /// Sets the regions that are known to be unfinished: they may be uncut or exceed the tolerance.
    #[must_use]
    pub fn rest(self, rest: &'a [UncutRegion]) -> Self {
        Self { rest, ..self }
    }

    /// Sets the tools of a program that calls several; empty: it has one, whatever its number. Between the last
    /// location of one tool of a CL file and the first of the next nothing is measured.
    #[must_use]
    pub fn tools(self, tools: &'a [Tool<'a>]) -> Self {
        Self { tables: Tables { tools, ..self.tables }, ..self }
    }

    /// Sets the work offsets; `G54` is that of the setup if it is not among them.
    #[must_use]
    pub fn offsets(self, offsets: &'a [WorkOffset]) -> Self {
        Self { tables: Tables { offsets, ..self.tables }, ..self }
    }

    /// Sets both tables of the control.
    #[must_use]
    pub fn tables(self, tables: Tables<'a>) -> Self {
        Self { tables, ..self }
    }

    /// Sets the machine and setup as they are, to study an error of either; the control keeps its own. No effect on
    /// cutter locations.
    #[must_use]
    pub fn machine(self, machine: &'a Kinematics) -> Self {
        let motion = match self.motion {
            MotionSource::Program { program, control, .. } => {
                MotionSource::Program { program, control, machine }
            }
            locations @ MotionSource::Locations(_) => locations,
        };
        Self { motion, ..self }
    }

    /// Returns the machine as it is; `None` for cutter locations.
    pub(super) fn real(&self) -> Option<&'a Kinematics> {
        match self.motion {
            MotionSource::Program { machine, .. } => Some(machine),
            MotionSource::Locations(_) => None,
        }
    }

    /// The program, if it is one.
    pub(super) fn source(&self) -> Option<&'a dyn ProgramSource> {
        match self.motion {
            MotionSource::Program { program, .. } => Some(program),
            MotionSource::Locations(_) => None,
        }
    }

    /// Returns true if the control adds the length of a tool to Z.
    pub(super) fn has_tool_length(&self) -> bool {
        let MotionSource::Program { control, .. } = self.motion else { return false };
        let mut tools = self.tables.tools.iter();
        // Without a table the setup has the only tool.
        control.setup().tool_length > 0.0 && tools.len() == 0
            || tools.any(|tool| tool.cutter.length() > 0.0)
    }

    /// Cutters by their places in the table of tools.
    pub(super) fn cutters(&self) -> Vec<&'a Cutter> {
        controls::cutters(self.cutter, self.tables.tools)
    }

    /// The control with each tool; `None` for cutter locations.
    pub(super) fn controls(&self) -> Result<Option<Controls>, VerifyError> {
        match self.motion {
            MotionSource::Program { program, control, machine } => {
                controls::known(program, &self.tables)?;
                Controls::new(control, machine, &self.tables).map(Some)
            }
            MotionSource::Locations(_) => Ok(None),
        }
    }

    /// The moves; arcs in chords within `tolerance` \[mm\]. `controls` are those of [`Self::controls`].
    pub(super) fn run<'r>(
        &self,
        controls: Option<&'r Controls>,
        tolerance: f64,
    ) -> Result<Run<'r>, VerifyError>
    where
        'a: 'r,
    {
        match (self.motion, controls) {
            (MotionSource::Program { program, .. }, Some(controls)) => {
                Ok(Run::program(controls, program, &self.tables, tolerance))
            }
            (MotionSource::Program { .. }, None) => Err(VerifyError::NoMotion),
            (MotionSource::Locations(file), _) => {
                Run::locations(file, self.tables.tools, tolerance)
            }
        }
    }
}
