//! Job as the stages use it: mm, rad, s; every value checked.

use super::super::places::KeyPositions;
use super::super::summary::ChordSummary;
use super::solid::{JobFixture, JobSolid, JobStock};
use crate::math;
use crate::nc::write::OutputFormat;
use crate::types::Interval;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Checked job file. Paths are as written, relative to it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobFile {
    /// Name of the job.
    pub name: String,
    /// Part to machine.
    pub part: JobPart,
    /// Position of the workpiece on the machine.
    pub setup: JobSetup,
    /// Raw material; `None` if nothing is known of it.
    pub stock: Option<JobStock>,
    /// Fixtures that the tool must not touch: passes and links are planned round them, programs are checked against them.
    pub fixtures: Vec<JobFixture>,
    /// Tool that cuts the part.
    pub tool: JobTool,
    /// Further tools that other programs call, for their check.
    pub other_tools: Vec<JobTool>,
    /// Permitted deviation of the finished part.
    pub tolerance: JobTolerance,
    /// Arrangement of the passes.
    pub strategy: JobStrategy,
    /// Feed and spindle.
    pub cutting: CuttingData,
    /// Operations in the order in which they are cut; empty if the job is one operation. Tool, faces, strategy and
    /// cutting data of the job are those of the first.
    pub operations: Vec<JobOperation>,
    /// Machine file.
    pub machine: String,
    /// Planning of the speed along the path.
    pub motion: MotionSettings,
    /// Programs to write; never empty.
    pub dialects: Vec<OutputFormat>,
    /// Programs of a job of several operations.
    pub programs: JobPrograms,
    /// Blocks of links in the programs.
    pub link_blocks: JobLinkBlocks,
    /// Largest distance between two measured points of the final check \[mm\].
    pub verify_grid: f64,
    /// Largest distance between the rays that represent the stock \[mm\]; `None` derives it from its
    /// size.
    pub stock_cell: Option<f64>,
    /// Keep-off distance of every part of the tool from fixtures \[mm\]; at 0 only contact is reported.
    pub fixture_clearance: f64,
    /// Positions of the keys in the file.
    pub places: KeyPositions,
}

/// Programs of a job of several operations, in every dialect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobPrograms {
    /// One with changes of tool.
    One,
    /// That one, and one more for each operation.
    Each,
}

/// Length of the blocks on links.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobLinkBlocks {
    /// As few as possible, for controls that look few blocks ahead.
    Long,
    /// Near to the path, for controls that look far ahead and round corners.
    Short,
}

impl JobFile {
    /// Returns the job as one operation alone.
    #[must_use]
    pub fn of_operation(&self, operation: &JobOperation) -> Self {
        let JobOperation { faces, tool, strategy, cutting, .. } = operation.clone();
        let part = JobPart { faces, ..self.part.clone() };
        Self { part, tool, strategy, cutting, operations: Vec::new(), ..self.clone() }
    }

    /// Sets the chord tolerance of the triangles of all STEP solids \[mm\].
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

    /// Returns the chord tolerances of the STEP solids: the stock, then fixtures by name.
    pub fn chords(&self) -> Vec<ChordSummary> {
        let stock = self.stock.iter().filter_map(JobStock::solid).map(|solid| ("stock", solid));
        let held = self.fixtures.iter().map(|fixture| (fixture.name.as_str(), &fixture.solid));
        let of = |(name, solid): (&str, &JobSolid)| {
            solid.chord().map(|chord| ChordSummary { solid: name.to_owned(), chord })
        };
        stock.chain(held).filter_map(of).collect()
    }
}

/// Operation of a job: one tool over some faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobOperation {
    /// Name for reports.
    pub name: String,
    /// Faces to machine.
    pub faces: FaceSelection,
    /// Tool.
    pub tool: JobTool,
    /// Arrangement of the passes.
    pub strategy: JobStrategy,
    /// Feed and spindle.
    pub cutting: CuttingData,
}

/// Part to machine.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobPart {
    /// Surface JSON or STEP file.
    pub file: String,
    /// Rotation of the part about its fixed x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// Faces to machine.
    pub faces: FaceSelection,
    /// True if the cutter works on the other side of the faces.
    pub flip: bool,
    /// Other faces that the tool must not gouge.
    pub avoid: FaceSelection,
}

impl JobPart {
    /// Returns the rotation of `workpiece_from_part`, `Rz Ry Rx`; quarter turns are exact.
    pub fn rotation(&self) -> Rotation3<f64> {
        let [x, y, z] = self.angles;
        math::exact_rotation_of_xyz([x, y, z].into())
    }
}

/// Selection of faces of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FaceSelection {
    /// All faces.
    All,
    /// These numbers, in this order; never empty, no number twice.
    Numbers(Vec<usize>),
}

/// Position of the workpiece on the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct JobSetup {
    /// Workpiece origin in machine coordinates with all axes at zero \[mm\].
    pub origin: Vector3<f64>,
    /// Rotation of the workpiece about the machine's fixed x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// Height of the clearance plane above part and stock \[mm\].
    pub clearance: f64,
}

impl JobSetup {
    /// Returns the rotation part of `machine_from_workpiece`: `Rz Ry Rx`.
    pub fn rotation(&self) -> Rotation3<f64> {
        let [x, y, z] = self.angles;
        math::rotation_of_xyz([x, y, z].into())
    }
}

/// Tool of a job.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobTool {
    /// Tool number in the magazine.
    pub number: u32,
    /// Shape of the cutting end.
    pub kind: ToolKind,
    /// Radius of the circle the torus is swept along, `R` \[mm\]; 0 for a ball.
    pub major: f64,
    /// Radius of the tip arc, `r` \[mm\]; 0 for a flat end.
    pub minor: f64,
    /// Part of the profile between the tip arc and the flank.
    pub side: ToolSide,
    /// Tool length from the gauge point to the tip \[mm\].
    pub length: f64,
    /// Construction, which limits where it cuts.
    pub construction: ToolConstruction,
    /// Profile above the cutting part, `[height above the tip, radius]` \[mm\], heights ascending.
    pub shank: Vec<[f64; 2]>,
    /// Profile of the holder, likewise.
    pub holder: Vec<[f64; 2]>,
    /// File of the holder, until it is read: [`JobFile::with_holders`].
    pub holder_file: Option<HolderFile>,
}

/// File with the triangles of a holder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HolderFile {
    /// Name, relative to the job file.
    pub name: String,
    /// Key of the job file that states it.
    pub key: String,
}

/// Shape of the cutting end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolKind {
    /// Sharp corner, `r = 0`.
    Flat,
    /// Hemisphere, `R = 0`.
    Ball,
    /// Torus.
    Bull,
    /// Cone tangent to the tip arc.
    Taper,
    /// Large arc tangent to tip arc and flank.
    Barrel,
    /// Large arc tangent to the tip arc, inclined to the axis where it ends.
    ConicalBarrel,
    /// Large arc across the tip, with a corner.
    Lens,
}

/// Part of a tool's profile between the tip arc and the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolSide {
    /// None: the tip arc ends in the flank.
    Straight,
    /// Cone tangent to the tip arc.
    Cone {
        /// Half angle of the cone \[rad\].
        taper_angle: f64,
        /// Diameter at which it ends \[mm\].
        diameter: f64,
    },
    /// Arc tangent to the tip arc.
    Arc {
        /// Radius of the arc \[mm\].
        radius: f64,
        /// Angle between the arc and the axis where it ends \[rad\].
        taper_angle: f64,
        /// Diameter at which it ends \[mm\].
        diameter: f64,
    },
}

impl JobTool {
    /// Returns the largest angle between a normal of the tip arc and the axis \[rad\].
    ///
    /// A right angle without a side. A side begins where it is tangent: `sin = (rho - R) / (r - q)` for an arc of radius
    /// `q` that ends on the normal `n` at `rho + q n`.
    pub fn tip_angle(&self) -> f64 {
        match self.side {
            ToolSide::Straight => FRAC_PI_2,
            ToolSide::Cone { taper_angle, .. } => FRAC_PI_2 - taper_angle,
            ToolSide::Arc { radius, taper_angle, diameter } => {
                let rho = 0.5 * diameter - radius * math::cos(taper_angle);
                math::asin((rho - self.major) / (self.minor - radius))
            }
        }
    }

    /// Returns `true` for a barrel or conical barrel.
    pub fn is_barrel(&self) -> bool {
        matches!(self.kind, ToolKind::Barrel | ToolKind::ConicalBarrel)
    }

    /// Returns the angles between tool axis and face normal at which the side of the tool touches \[rad\]: from the end of
    /// the tip arc to its own.
    pub fn arc_inclinations(&self) -> Interval {
        let taper_angle = match self.side {
            ToolSide::Straight => 0.0,
            ToolSide::Cone { taper_angle, .. } | ToolSide::Arc { taper_angle, .. } => taper_angle,
        };
        Interval::new(self.tip_angle(), FRAC_PI_2 - taper_angle)
    }

    /// Returns the outer radius of the cutting end \[mm\].
    pub fn radius(&self) -> f64 {
        match self.side {
            ToolSide::Straight => self.major + self.minor,
            ToolSide::Cone { diameter, .. } | ToolSide::Arc { diameter, .. } => 0.5 * diameter,
        }
    }
}

/// Construction of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolConstruction {
    /// Cuts to the centre.
    Solid,
    /// Has inserts that cut outside a radius only.
    Insert {
        /// Radius inside which nothing cuts \[mm\].
        inner_cutting_radius: f64,
    },
}

/// Permitted deviation of the finished part.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct JobTolerance {
    /// Largest excess \[mm\].
    pub total: f64,
    /// Deepest gouge \[mm\]; not above `total`.
    pub gouge: f64,
    /// Shares that the user fixed.
    pub split: ToleranceSplit,
}

/// Shares of the tolerance \[mm\]; `None` leaves a share to the pipeline. Their sum is within `total`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
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

/// Use of passes for prismatic shapes: the flank on walls, the underside on floors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobPrismatic {
    /// Never.
    Never,
    /// Wherever such passes finish the face.
    WallsAndFloors,
    /// The flank alone, on every face.
    Flank,
}

/// Part of the faces that an operation cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobArea {
    /// All of them.
    Whole,
    /// Area that the operations before have left.
    Rest,
}

/// Arrangement of the passes on the faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobStrategy {
    /// Part of the faces that is cut.
    pub area: JobArea,
    /// Placement of the tool.
    pub method: JobPlacement,
    /// Use of passes for walls and floors.
    pub prismatic: JobPrismatic,
    /// Feed direction of the passes.
    pub along: JobFeedDirection,
    /// Cut pattern.
    pub direction: JobCutPattern,
    /// Position of the contact arc along the feed, seen from the cutter centre.
    pub side: JobContactSide,
    /// Largest rotation of the tool axis along a pass \[rad/mm\].
    pub max_axis_turn: f64,
    /// True if the run reports the cost of that limit; `None` reports it if that takes little time.
    pub turn_cost: Option<bool>,
    /// Lead-in and lead-out.
    pub lead: JobLead,
    /// Links between passes.
    pub links: JobLinks,
    /// Range of offset directions to search, from the side of the strip towards the feed \[rad\];
    /// `None` for the default of the method.
    pub offset_range: Option<Interval>,
}

/// Placement of the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JobPlacement {
    /// Inclination with the widest strip at every cutter location.
    Widest,
    /// Inclination of a ball that is not stated: along the feed, and the same way on the return.
    Leaning {
        /// Angle from the surface normal \[rad\].
        angle: f64,
    },
    /// Fixed inclination.
    Fixed {
        /// Lead angle, along the feed from the surface normal \[rad\].
        lead: f64,
        /// Tilt angle, sideways towards the next pass \[rad\].
        tilt: f64,
    },
}

/// Feed direction of the passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobFeedDirection {
    /// Along the first parameter.
    U,
    /// Along the second parameter.
    V,
    /// Along the direction in which the face is least concave.
    Curvature,
    /// Along whichever of these, blends between them and turns at the edges takes the machine least
    /// time.
    Adaptive,
}

/// Order of passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobCutPattern {
    /// Every second pass runs back.
    Zigzag,
    /// All passes run the same way.
    OneWay,
}

/// Position of the contact arc along the feed, seen from the cutter centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobContactSide {
    /// In front.
    Ahead,
    /// At the back: needs a centre-cutting tool.
    Behind,
    /// Whichever gives the wider strip.
    Either,
}

/// Lead-in and lead-out of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobLead {
    /// Along the tool axis.
    Axis,
    /// Tangentially to the pass.
    Tangent,
}

/// Links between passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobLinks {
    /// Close to the part, if that is faster and free of collisions.
    Hop,
    /// Up to the clearance plane.
    Retract,
}

/// Feed and spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CuttingData {
    /// Feed of the reference point \[mm/s\].
    pub feed: f64,
    /// Point that moves at the feed.
    pub reference: FeedReference,
    /// Spindle speed \[rad/s\].
    pub spindle: f64,
    /// True if the coolant is on.
    pub coolant: bool,
}

impl CuttingData {
    /// Returns the spindle speed as programs state it \[rev/min\].
    pub fn spindle_rpm(&self) -> f64 {
        self.spindle * 60.0 / std::f64::consts::TAU
    }
}

/// Point that moves at the feed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedReference {
    /// Cutter contact.
    Contact,
    /// Tool tip.
    Tip,
}

/// Planning and sampling of the speed along the path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
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
    /// Fast schedule within velocity, acceleration and jerk limits.
    Jerk,
    /// Shortest time within velocity and acceleration limits.
    Optimal,
    /// Classical look-ahead, block by block, for comparison.
    Blocks,
}
