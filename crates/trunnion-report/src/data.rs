//! What a report shows: plain data in the units people read (mm, degrees, seconds).

use serde::Serialize;

/// Everything on the page.
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
    /// Whether the result keeps every tolerance and limit.
    pub passed: bool,
    /// The verdict, a sentence each: the reasons where it failed.
    pub verdict: Vec<String>,
    /// What to know before using the program.
    pub warnings: Vec<String>,
    /// The numbers, most important first.
    pub numbers: Vec<Number>,
    /// Tolerance and how it was shared out.
    pub budget: Budget,
    /// Cross-section of every tool, `[radius, height above the tip]` \[mm\], from the tip up.
    pub tools: Vec<Vec<[f64; 2]>>,
    /// The surface with what was measured on it.
    pub surface: Surface,
    /// The path, in the order it is run.
    pub path: Vec<PathPiece>,
    /// The machine's axes over time.
    pub motion: Motion,
    /// What the final check found.
    pub check: Check,
    /// What is left of the stock; `None` for none.
    pub stock: Option<Solid>,
    /// What the tool must not touch; `None` for nothing.
    pub fixtures: Option<Solid>,
    /// Drawing (SVG) of how far the smoothed path strays, put in as it stands; empty for none.
    pub smoothing: String,
}

/// How a number is to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Nothing to judge.
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
    /// What it is.
    pub label: String,
    /// Value as text, already rounded.
    pub value: String,
    /// Unit, or empty.
    pub unit: String,
    /// A remark, or empty: what it is compared with.
    pub note: String,
    /// How it is to be read.
    pub state: State,
    /// Whether it also stands large at the top of the page.
    pub headline: bool,
}

/// The tolerance and its shares \[mm\].
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Budget {
    /// Most material left.
    pub total: f64,
    /// Deepest gouge.
    pub gouge: f64,
    /// Who gets what.
    pub shares: Vec<Share>,
}

/// One share of the tolerance.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Share {
    /// What needs it.
    pub name: String,
    /// Allowed \[mm\].
    pub allowed: f64,
    /// Used, where known \[mm\].
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

/// Surface of a solid, to be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solid {
    /// Vertices \[mm\].
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// What the tool does along a piece of path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MotionKind {
    /// Travel above the part.
    Link,
    /// Down to a pass.
    LeadIn,
    /// Cutting.
    Cut,
    /// Up from a pass.
    LeadOut,
}

/// A piece of path as a chain of tool positions in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPiece {
    /// Kind of motion.
    pub motion: MotionKind,
    /// Place of the tool in [`ReportData::tools`].
    pub tool: usize,
    /// Positions in order of time.
    pub points: Vec<PathPoint>,
}

/// The tool at one moment.
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

/// A machine axis and its limits.
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
    /// Whether that is what the chord error asked for allows, less than the axis can do.
    pub chord: bool,
    /// Largest jerk \[unit/s³\]; 0 where none is kept.
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

/// The machine over time, in slots of equal length. Made by [`crate::Recorder`].
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
    /// What holds the motion back in each slot: 0 nothing, 1 the feed, `2 + 3k` the velocity of
    /// axis `k`, `3 + 3k` its acceleration, `4 + 3k` its jerk.
    pub binding: Vec<u8>,
}

/// What the final check found.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Check {
    /// What was checked and how, in words; empty if nothing was checked.
    pub method: String,
    /// Distance between measured points \[mm\].
    pub grid: f64,
    /// Points measured.
    pub points: u64,
    /// Of these, not cut at all.
    pub uncut: u64,
    /// Histogram of what was left.
    pub histogram: Histogram,
    /// The worst places, worst first.
    pub places: Vec<WorstPlace>,
}

/// Counts of deviations.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Histogram {
    /// Lower edge of the first bin \[mm\].
    pub start: f64,
    /// Width of a bin \[mm\].
    pub width: f64,
    /// Points in each bin; the first and the last also hold what lies beyond.
    pub counts: Vec<u64>,
}

/// A place worth looking at.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct WorstPlace {
    /// `gouge`, `excess`, `uncut`, or whatever else was found, in one or two words.
    pub kind: String,
    /// Where \[mm\].
    pub point: [f64; 3],
    /// Deviation \[mm\]; `None` where nothing was cut.
    pub deviation: Option<f64>,
    /// Line of the program, face, u and v: whatever helps to find it.
    pub note: String,
}
