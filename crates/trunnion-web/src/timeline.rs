//! Machine and tool over time as flat arrays.

use crate::machine_model::MachineModel;
use trunnion::verify::TimelinePoint;
use trunnion_cli::calls::ReplayAnswer;

/// Numbers of a point in [`Timeline::poses`]: tip, then tool axis.
const POSE: usize = 6;

/// Moves of a program over time, each array with one entry or a fixed number of them a point.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Timeline {
    /// Time from the start of the program \[s\].
    pub times: Vec<f64>,
    /// Line of the program.
    pub lines: Vec<u32>,
    /// Place of the tool in the table, times 4; plus 1 in rapid moves, plus 2 where the move is apart from the last.
    pub kinds: Vec<u32>,
    /// Axes X, Y, Z and the rotaries \[mm, rad\]; empty for a CL file.
    pub axes: Vec<f64>,
    /// Tip \[mm\] and tool axis in the workpiece frame.
    pub poses: Vec<f32>,
    /// Machine and setup; `None` for a CL file.
    pub machine: Option<MachineModel>,
    /// Outline of each tool: radius and height above the tip \[mm\].
    pub tools: Vec<Vec<[f64; 2]>>,
    /// True if there is stock, or a part whose box stands for it.
    pub has_stock: bool,
}

impl Timeline {
    pub(crate) fn of(replay: &ReplayAnswer) -> Self {
        let points = &replay.points;
        let has_axes = replay.kinematics.is_some();
        let axes = points.iter().filter(|_| has_axes).flat_map(|point| point.axes.iter().copied());
        let mut poses = Vec::with_capacity(POSE * points.len());
        poses.extend(points.iter().flat_map(pose));
        Self {
            times: points.iter().map(|point| point.time).collect(),
            lines: points.iter().map(|point| point.line).collect(),
            kinds: points.iter().map(kind).collect(),
            axes: axes.collect(),
            poses,
            machine: replay.kinematics.as_ref().map(MachineModel::with_setup),
            tools: replay.tools.clone(),
            has_stock: replay.stock.is_some(),
        }
    }
}

fn kind(point: &TimelinePoint) -> u32 {
    let tool = u32::try_from(point.tool).unwrap_or_default();
    4 * tool + u32::from(point.rapid) + 2 * u32::from(point.apart)
}

#[expect(clippy::cast_possible_truncation, reason = "for a picture")]
fn pose(point: &TimelinePoint) -> [f32; POSE] {
    let (tip, axis) = (point.pose.tip.coords, point.pose.axis);
    [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z].map(|value| value as f32)
}
