//! Content of a report: plain data in the units that people read (mm, degrees, seconds).

use serde::Serialize;

/// Content of the page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReportData {
    /// Name of the job.
    pub job: String,
    /// Part file and faces, in words.
    pub part: String,
    /// Machine, in words.
    pub machine: String,
    /// Tool, in words.
    pub tool: String,
    /// Program and version that made the report.
    pub generator: String,
    /// True if the result keeps every tolerance and limit.
    pub passed: bool,
    /// Verdict, one sentence each; the reasons if it failed.
    pub verdict: Vec<String>,
    /// Warnings to read before the program is used.
    pub warnings: Vec<String>,
    /// Numbers, most important first.
    pub numbers: Vec<Number>,
    /// Tolerance and its shares.
    pub budget: Budget,
    /// Cross-section of every tool, `[radius, height above the tip]` \[mm\], from the tip up.
    pub tools: Vec<Vec<[f64; 2]>>,
    /// Surface with the deviations measured on it.
    pub surface: Surface,
    /// Tool path in the order of the run.
    pub path: Vec<PathPiece>,
    /// Machine axes over time.
    pub motion: Motion,
    /// Results of the final check.
    pub check: Check,
    /// Remaining stock, if it is known.
    pub stock: Option<Solid>,
    /// Fixtures that the tool must not touch, if there are any.
    pub fixtures: Option<Solid>,
    /// Drawing (SVG) of the deviation of the smoothed path, inserted unchanged; may be empty.
    pub smoothing: String,
}

/// Judgement of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Not judged.
    #[default]
    Plain,
    /// Within its limit.
    Good,
    /// Worth a look.
    Warn,
    /// Breaks its limit.
    Bad,
}

/// One line of the table of numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Number {
    /// Name of the quantity.
    pub label: String,
    /// Value as text, already rounded.
    pub value: String,
    /// Unit, or empty.
    pub unit: String,
    /// Remark, such as the limit that it is compared with; may be empty.
    pub note: String,
    /// Judgement.
    pub state: State,
    /// True if it is also shown large at the top of the page.
    pub headline: bool,
}

/// Tolerance and its shares \[mm\].
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Budget {
    /// Largest excess.
    pub total: f64,
    /// Deepest gouge.
    pub gouge: f64,
    /// Shares of the stages.
    pub shares: Vec<Share>,
}

/// Share of the tolerance.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Share {
    /// Stage that uses it.
    pub name: String,
    /// Deviation allowed \[mm\].
    pub allowed: f64,
    /// Deviation used, if known \[mm\].
    pub used: Option<f64>,
}

/// Triangles in the workpiece frame, with the deviation at each vertex.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Vertices \[mm\].
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Material left at each vertex, negative for a gouge \[mm\]; `None` where nothing was cut.
    /// As long as `vertices`, or empty if nothing was measured.
    pub deviation: Vec<Option<f64>>,
}

/// Point of a measured grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position in the workpiece frame \[mm\].
    pub position: [f64; 3],
    /// Material left along the normal, negative for a gouge \[mm\]; `None` where nothing was cut.
    pub deviation: Option<f64>,
}

/// Surface of a solid for the picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solid {
    /// Vertices \[mm\].
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Kind of motion along a piece of path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MotionKind {
    /// Link above the part.
    Link,
    /// Lead-in to a pass.
    LeadIn,
    /// Cutting.
    Cut,
    /// Lead-out of a pass.
    LeadOut,
}

/// Piece of path as a chain of tool positions in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPiece {
    /// Kind of motion.
    pub motion: MotionKind,
    /// Index of the tool in [`ReportData::tools`].
    pub tool: usize,
    /// Positions in order of time.
    pub points: Vec<PathPoint>,
}

/// Tool at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Time \[s\].
    pub t: f64,
    /// Tool tip \[mm\].
    pub tip: [f64; 3],
    /// Unit vector from the tip to the spindle.
    pub axis: [f64; 3],
    /// Cutter contact \[mm\]; the tip where it is not known.
    pub contact: [f64; 3],
}

/// Machine axis with its limits.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Axis {
    /// Name.
    pub name: String,
    /// `mm` or `deg`.
    pub unit: String,
    /// Ends of travel; `None` for an axis that turns without end.
    pub travel: Option<[f64; 2]>,
    /// Largest speed \[unit/s\].
    pub velocity: f64,
    /// Largest acceleration \[unit/s²\].
    pub acceleration: f64,
    /// True if the requested chord error lowers the acceleration below that of the axis.
    pub chord: bool,
    /// Largest jerk \[unit/s³\]; 0 if no jerk limit is kept.
    pub jerk: f64,
}

/// Smallest and largest value of a quantity in each time slot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Smallest.
    pub min: Vec<f64>,
    /// Largest.
    pub max: Vec<f64>,
}

/// Position, velocity, acceleration and jerk of one axis, slot by slot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisBands {
    /// Position \[unit\].
    pub position: Band,
    /// Velocity \[unit/s\].
    pub velocity: Band,
    /// Acceleration \[unit/s²\].
    pub acceleration: Band,
    /// Jerk \[unit/s³\].
    pub jerk: Band,
}

/// Motion of the machine in time slots of equal length. Created by [`crate::Recorder`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Duration of the whole \[s\].
    pub duration: f64,
    /// The axes.
    pub axes: Vec<Axis>,
    /// One per axis, each band with one entry per slot.
    pub bands: Vec<AxisBands>,
    /// Speed of the programmed point \[mm/s\].
    pub speed: Band,
    /// Speed of the tool tip \[mm/s\].
    pub tip: Band,
    /// Programmed feed \[mm/s\]; 0: none.
    pub feed: f64,
    /// Limit that binds in each slot: 0 none, 1 the feed, `2 + 3k` the velocity of axis `k`,
    /// `3 + 3k` its acceleration, `4 + 3k` its jerk.
    pub binding: Vec<u8>,
}

/// Results of the final check.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Check {
    /// Subject and method of the check in words; empty without a check.
    pub method: String,
    /// Distance between measured points \[mm\].
    pub grid: f64,
    /// Number of points measured.
    pub points: u64,
    /// Number of these that were not cut.
    pub uncut: u64,
    /// Histogram of the deviations.
    pub histogram: Histogram,
    /// Worst points, the worst first.
    pub places: Vec<WorstPlace>,
}

/// Histogram of deviations.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Histogram {
    /// Lower edge of the first bin \[mm\].
    pub start: f64,
    /// Width of a bin \[mm\].
    pub width: f64,
    /// Points in each bin; the first and the last bin include all beyond.
    pub counts: Vec<u64>,
}

/// One of the worst places.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct WorstPlace {
    /// Kind of finding in one or two words: `gouge`, `excess`, `uncut` or another.
    pub kind: String,
    /// Position \[mm\].
    pub point: [f64; 3],
    /// Deviation \[mm\]; `None` where nothing was cut.
    pub deviation: Option<f64>,
    /// Line of the program, face, u and v, to help to find it.
    pub note: String,
}
