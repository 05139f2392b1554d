//! Tool axes told as vectors. Where the rotaries go is the control's own choice, and no inverse is asked for it: the
//! tool is followed from vector to vector, and axes are known again once the program names them all.

use super::VerifyError;
use super::replay::{Control, Counted};
use super::report::Vectors;
use super::run::Run;
use crate::machine::FIRST_ROTARY;
use crate::math::angle::angle_between;
use crate::nc::read::{Move, Pace, ProgramSource, Step};
use crate::types::{AXES, AxisVector, ToolPose};
use nalgebra::{Point3, UnitVector3};

/// Where the machine stands, as far as the program tells.
#[derive(Debug, Clone, Copy)]
pub(super) enum Known {
    /// All axes.
    Axes(AxisVector),
    /// The tool, workpiece frame.
    Tool(ToolPose),
    /// Axes named since the tool was last told by a vector \[mm, rad\].
    Part([Option<f64>; AXES]),
}

impl Known {
    /// Where a straight block leads to, and the tool at both ends if the way between them is known: straight for the
    /// tip, on the great circle for the tool axis. For blocks with a vector, and those after one.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Special`], [`VerifyError::WorkOffset`], [`VerifyError::LinearAxes`].
    pub(super) fn after(
        &self,
        control: &Control<'_>,
        step: &Move,
    ) -> Result<(Self, Option<[ToolPose; 2]>), VerifyError> {
        match control.counted(step.frame, step.line)? {
            Counted::From(_) if step.axis.is_some() => {
                let what = "a turn into a tilted plane, or a tool vector, without tool-centre-point control";
                Err(VerifyError::Special { line: step.line, what })
            }
            Counted::From(shift) => {
                let axes = put(self.axes(), step, &shift);
                Ok((all(&axes).map_or(Self::Part(axes), Self::Axes), None))
            }
            Counted::Tip(length) => match self.axis(control, step) {
                Some(axis) => Ok(self.by_vector(control, (step, axis), length)),
                None => Ok((self.by_angles(control, step, length)?, None)),
            },
        }
    }

    /// What is known of the axes.
    fn axes(&self) -> [Option<f64>; AXES] {
        match self {
            Self::Axes(q) => (*q).map(Some).into(),
            Self::Tool(_) => [None; AXES],
            Self::Part(axes) => *axes,
        }
    }

    /// The tool, as far as it is known.
    fn pose(&self, control: &Control<'_>) -> Option<ToolPose> {
        match self {
            Self::Axes(q) => Some(control.real().forward(q)),
            Self::Tool(pose) => Some(*pose),
            Self::Part(_) => None,
        }
    }

    /// The tool axis a block leads to, workpiece frame; `None` if rotary words say it.
    fn axis(&self, control: &Control<'_>, step: &Move) -> Option<UnitVector3<f64>> {
        let turns = step.words.iter().skip(FIRST_ROTARY).any(Option::is_some);
        match (step.axis, self) {
            (Some(told), _) => Some(control.in_workpiece(&told)),
            (None, Self::Tool(pose)) if !turns => Some(pose.axis),
            _ => None,
        }
    }

    /// A block that leads to a tool axis.
    fn by_vector(
        &self,
        control: &Control<'_>,
        (step, axis): (&Move, UnitVector3<f64>),
        length: bool,
    ) -> (Self, Option<[ToolPose; 2]>) {
        let from = self.pose(control);
        let here = from.map(|pose| control.reading(&pose, length));
        let mut axes = [None; AXES];
        for (value, start) in axes.iter_mut().zip(here.iter().flat_map(|here| here.iter())) {
            *value = Some(*start);
        }
        let [x, y, z, ..] = put(axes, step, &AxisVector::zeros());
        let (Some(x), Some(y), Some(z)) = (x, y, z) else {
            return (Self::Part([None; AXES]), None);
        };
        let to = control.tool_at(&Point3::new(x, y, z), axis, length);
        (Self::Tool(to), from.map(|from| [from, to]))
    }

    /// A block that leads to angles; where they came from is not known.
    fn by_angles(
        &self,
        control: &Control<'_>,
        step: &Move,
        length: bool,
    ) -> Result<Self, VerifyError> {
        // The linear axes follow the tip: what they were is over.
        let [.., first, second] = self.axes();
        let axes = put([None, None, None, first, second], step, &AxisVector::zeros());
        let [.., first, second] = axes;
        let Some(mut q) = all(&axes) else {
            return Ok(Self::Part([None, None, None, first, second]));
        };
        let linear = control.linear_joints(&Point3::new(q[0], q[1], q[2]), &q, length)?;
        q.fixed_rows_mut::<3>(0).copy_from(&linear);
        Ok(Self::Axes(q))
    }
}

/// Values with a block's words put in; `shift` is what words are short of them.
fn put(mut values: [Option<f64>; AXES], step: &Move, shift: &AxisVector) -> [Option<f64>; AXES] {
    for ((value, word), shift) in values.iter_mut().zip(step.words).zip(shift.iter()) {
        *value = match word {
            Some(word) if step.incremental => value.map(|value| value + word),
            Some(word) => Some(word + shift),
            None => *value,
        };
    }
    values
}

/// All axes, if all are known.
fn all(axes: &[Option<f64>; AXES]) -> Option<AxisVector> {
    let known: Vec<f64> = axes.iter().copied().flatten().collect();
    (known.len() == AXES).then(|| AxisVector::from_column_slice(&known))
}

/// Time of a move between two places of the tool \[s\]: none at rapid speed, as the axes are not known.
pub(super) fn duration([from, to]: &[ToolPose; 2], pace: Pace) -> f64 {
    match pace {
        Pace::Rapid => 0.0,
        Pace::Inverse { seconds } => seconds,
        Pace::PerMinute { speed } => {
            let length = (to.tip - from.tip).norm();
            let turn = angle_between(&from.axis, &to.axis).to_degrees();
            if length > 0.0 { length / speed } else { turn / speed }
        }
    }
}

/// What is not known of a program with vectors; `None` if it has none.
pub(super) fn of(
    run: &Run<'_>,
    program: &dyn ProgramSource,
) -> Result<Option<Vectors>, VerifyError> {
    let told = |step: Step| match step {
        Step::Move(step) if step.axis.is_some() => Some(step.line),
        _ => None,
    };
    let Some(line) = program.steps().find_map(told) else { return Ok(None) };
    let mut vectors = Vectors { line, unmeasured: 0, first: None };
    for segment in run.segments() {
        let segment = segment?;
        if segment.is_unknown() {
            vectors.unmeasured += 1;
            vectors.first.get_or_insert(segment.line);
        }
    }
    Ok(Some(vectors))
}
