//! A job as the stages want it: mm, rad, s; every value checked.

use super::super::places::KeyPositions;
use super::super::summary::ChordSummary;
use super::solid::{JobFixture, JobSolid, JobStock};
use crate::nc::write::OutputFormat;
use nalgebra::{Rotation3, Vector3};

/// One job. Paths are as written in the file, relative to it.
#[derive(Debug, Clone, PartialEq)]
pub struct JobFile {
    /// Name of the job.
    pub name: String,
    /// What to machine.
    pub part: JobPart,
    /// Where it stands on the machine.
    pub setup: JobSetup,
    /// What it is cut from; `None`: nothing is known of the stock.
    pub stock: Option<JobStock>,
    /// What the tool must not touch: programs are checked against it, planning does not avoid it.
    pub fixtures: Vec<JobFixture>,
    /// What cuts it.
    pub tool: JobTool,
    /// Tools that other programs call beside it, for their check.
    pub other_tools: Vec<JobTool>,
    /// How well.
    pub tolerance: JobTolerance,
    /// How the surface is covered.
    pub strategy: JobStrategy,
    /// Feed and spindle.
    pub cutting: CuttingData,
    /// Machine file.
    pub machine: String,
    /// How the speed along the path is planned.
    pub motion: MotionSettings,
    /// Programs to write; never empty.
    pub dialects: Vec<OutputFormat>,
    /// Largest distance between two measured points of the final check \[mm\].
    pub verify_grid: f64,
    /// Largest distance of the rays that stand for the stock \[mm\]; `None`: by its size.
    pub stock_cell: Option<f64>,
    /// How far any part of the tool must keep off fixtures \[mm\]; at 0 only what runs into one is told.
    pub fixture_clearance: f64,
    /// Where each key stands in the file.
    pub places: KeyPositions,
}

impl JobFile {
    /// With triangles of all STEP solids within `chord` \[mm\] of their faces.
    #[must_use]
    pub fn with_chord(mut self, chord: f64) -> Self {
        if let Some(JobStock::Solid(solid)) = &mut self.stock {
            solid.set_chord(chord);
        }
        for fixture in &mut self.fixtures {
            fixture.solid.set_chord(chord);
        }
        self
    }

    /// How far the triangles of each of its STEP solids may be off their faces: the stock, then fixtures by name.
    pub fn chords(&self) -> Vec<ChordSummary> {
        let stock = self.stock.iter().filter_map(JobStock::solid).map(|solid| ("stock", solid));
        let held = self.fixtures.iter().map(|fixture| (fixture.name.as_str(), &fixture.solid));
        let of = |(name, solid): (&str, &JobSolid)| {
            solid.chord().map(|chord| ChordSummary { solid: name.to_owned(), chord })
        };
        stock.chain(held).filter_map(of).collect()
    }
}

/// The surface to machine.
#[derive(Debug, Clone, PartialEq)]
pub struct JobPart {
    /// Surface JSON or STEP file.
    pub file: String,
    /// Which of its faces.
    pub faces: FaceSelection,
    /// Whether the cutter works on the other side of the faces.
    pub flip: bool,
    /// Which of the other faces the tool keeps off.
    pub avoid: FaceSelection,
}

/// Faces of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FaceSelection {
    /// Every one.
    All,
    /// These numbers, in this order; never empty, no number twice.
    Numbers(Vec<usize>),
}

/// Where the workpiece stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JobSetup {
    /// Workpiece origin in machine coordinates with all axes at zero \[mm\].
    pub origin: Vector3<f64>,
    /// Turns of the workpiece about the machine's fixed x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// Height above part and stock at which links travel \[mm\].
    pub clearance: f64,
}

impl JobSetup {
    /// `machine_from_workpiece` without the origin: `Rz Ry Rx`.
    pub fn rotation(&self) -> Rotation3<f64> {
        let [x, y, z] = self.angles;
        Rotation3::from_euler_angles(x, y, z)
    }
}

/// The tool.
#[derive(Debug, Clone, PartialEq)]
pub struct JobTool {
    /// Number in the magazine.
    pub number: u32,
    /// Form of the cutting end.
    pub kind: ToolKind,
    /// Radius of the circle the torus is swept along, `R` \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius of the cutting arc, `r` \[mm\]; 0 for a flat end.
    pub minor: f64,
    /// From the gauge point to the tip \[mm\].
    pub length: f64,
    /// Where it cuts.
    pub construction: ToolConstruction,
    /// Profile above the cutting part, `[height above the tip, radius]` \[mm\], heights ascending.
    pub shank: Vec<[f64; 2]>,
    /// Holder in the same way.
    pub holder: Vec<[f64; 2]>,
}

/// Form of the cutting end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolKind {
    /// Sharp corner, `r = 0`.
    Flat,
    /// Hemisphere, `R = 0`.
    Ball,
    /// Torus.
    Bull,
}

/// Where the tool cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolConstruction {
    /// To the centre.
    Solid,
    /// With inserts: not inside this radius.
    Insert {
        /// Radius inside which nothing cuts \[mm\].
        inner_cutting_radius: f64,
    },
}

/// What the finished part may deviate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JobTolerance {
    /// Most material left \[mm\].
    pub total: f64,
    /// Deepest gouge \[mm\]; not above `total`.
    pub gouge: f64,
    /// Shares the user fixed.
    pub split: ToleranceSplit,
}

/// Shares of the tolerance \[mm\]; `None` leaves a share to the pipeline. Their sum is within `total`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ToleranceSplit {
    /// Scallops of the strips.
    pub strip: Option<f64>,
    /// Curves through the cutter locations.
    pub path: Option<f64>,
    /// Blocks of the program.
    pub linearisation: Option<f64>,
    /// Decimals of the program.
    pub rounding: Option<f64>,
    /// The control's own smoothing.
    pub control: Option<f64>,
    /// Moving the tool axis where a cut passes a singular direction; `None`: it is not moved.
    pub singular: Option<f64>,
    /// Smoothing of the cutter locations; `None`: curves pass through them.
    pub smoothing: Option<f64>,
}

/// How the surface is covered.
#[derive(Debug, Clone, PartialEq)]
pub struct JobStrategy {
    /// How the tool is placed.
    pub method: JobPlacement,
    /// What the passes follow.
    pub along: JobFeedDirection,
    /// Whether every second pass runs back.
    pub direction: JobCutPattern,
    /// Where the contact arc may lie, seen along the feed from the cutter centre.
    pub side: JobContactSide,
    /// Most turn of the tool axis along a pass \[rad/mm\].
    pub max_axis_turn: f64,
    /// Whether a run finds out what that costs; `None`: where it takes little.
    pub turn_cost: Option<bool>,
    /// How the tool comes down to a pass.
    pub lead: JobLead,
    /// How it goes from pass to pass.
    pub links: JobLinks,
    /// Offset directions to search, from the strip side towards the feed \[rad\]; `None`: the
    /// method's own range.
    pub offset_range: Option<[f64; 2]>,
}

/// How the tool is placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JobPlacement {
    /// Every cutter location with the widest strip.
    Widest,
    /// Leaning by fixed angles.
    Fixed {
        /// Along the feed, from the surface normal \[rad\].
        lead: f64,
        /// Sideways, towards the next pass \[rad\].
        tilt: f64,
    },
}

/// What a pass follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobFeedDirection {
    /// The first parameter.
    U,
    /// The second one.
    V,
    /// The direction in which the face is bent least towards the cutter.
    Curvature,
    /// Whichever of these, bends between them, and turns at the rims takes the machine least time.
    Adaptive,
}

/// Order of passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobCutPattern {
    /// There and back.
    Zigzag,
    /// All the same way.
    OneWay,
}

/// Where the contact arc lies along the feed, from the cutter centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobContactSide {
    /// In front.
    Ahead,
    /// At the back: needs a centre-cutting tool.
    Behind,
    /// Whichever gives the wider strip.
    Either,
}

/// How the tool comes down to a pass and leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobLead {
    /// Along the tool axis.
    Axis,
    /// Tangentially to the pass.
    Tangent,
}

/// How the tool goes from pass to pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobLinks {
    /// Over, close to the part, where that is quicker and free.
    Hop,
    /// Up to the clearance.
    Retract,
}

/// Feed and spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingData {
    /// Feed of `reference` \[mm/s\].
    pub feed: f64,
    /// The point whose speed is the feed.
    pub reference: FeedReference,
    /// Spindle speed \[rad/s\].
    pub spindle: f64,
    /// Whether coolant is on.
    pub coolant: bool,
}

impl CuttingData {
    /// Spindle speed as programs state it \[rev/min\].
    pub fn spindle_rpm(&self) -> f64 {
        self.spindle * 60.0 / std::f64::consts::TAU
    }
}

/// The point whose speed is the feed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedReference {
    /// Cutter contact.
    Contact,
    /// Tool tip.
    Tip,
}

/// How the speed along the path is planned and sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSettings {
    /// Planner.
    pub method: MotionMethod,
    /// Servo period \[s\].
    pub servo_period: f64,
    /// Largest distance from the straight line between two setpoints, of linear axes \[mm\] and rotary ones
    /// \[rad\].
    pub chord: [Option<f64>; 2],
}

/// Speed planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionMethod {
    /// Fast, under limits of velocity, acceleration and jerk.
    Jerk,
    /// Shortest time under limits of velocity and acceleration.
    Optimal,
    /// The classical block-wise look-ahead, for comparison.
    Blocks,
}
