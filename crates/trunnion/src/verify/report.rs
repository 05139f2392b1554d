//! Reports of verification: heights over faces, axes against limits, findings.

use crate::machine::AxisKind;
use crate::types::{AXES, Interval, UncutRegion, Uv};
use crate::verify::replay::orient::Choices;
use crate::verify::replay::tables::Changes;
use crate::verify::state::StateFinding;
use nalgebra::Point3;
use std::fmt;

/// Result of a check: measured heights, audited axes, findings.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Map of the heights over each face, in the order of the faces.
    pub maps: Vec<FaceMap>,
    /// Summary of the maps.
    pub deviation: Deviation,
    /// Axes against their limits; `None` where there is no machine.
    pub audit: Option<Audit>,
    /// Rotary positions that the program leaves to the control, and those assumed.
    pub choices: Choices,
    /// Moves that are unknown after tool changes; `None` without a tool change.
    pub changes: Option<Changes>,
    /// Everything that breaks a tolerance or a limit; the worst of its kind each.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Returns `true` if all tolerances and limits are kept.
    pub fn passed(&self) -> bool {
        self.findings.is_empty()
    }
}

/// Height left over a face at the points of a grid.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FaceMap {
    /// Number of the face.
    pub face: usize,
    /// Values of u, increasing.
    pub u: Vec<f64>,
    /// Values of v, increasing.
    pub v: Vec<f64>,
    /// `samples[i * v.len() + j]` at `(u[i], v[j])`; `None` outside the trims.
    pub samples: Vec<Option<HeightSample>>,
    /// Points that could not be measured: no surface normal, or a search that was given up.
    pub unmeasured: usize,
    /// Flags of cells that meet known rest material: that of cell `u[i]..u[i + 1]`, `v[j]..v[j + 1]` is at
    /// `[i * (v.len() - 1) + j]`. Empty if no cell does.
    pub unfinished: Vec<bool>,
}

/// Height of the machined surface over one point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeightSample {
    /// Parameters.
    pub uv: Uv,
    /// Point of the face, workpiece frame \[mm\].
    pub point: Point3<f64>,
    /// Lowest the tool gets on the normal \[mm\]: below 0 a gouge, above 0 excess, `None` if no tool
    /// comes within the reach searched. A gouge as deep as that reach is at least that deep.
    pub height: Option<f64>,
    /// Line of the program that gets there.
    pub line: Option<u32>,
    /// Area of the face that the point stands for \[mm²\].
    pub area: f64,
    /// The point lies in known rest material.
    pub rest: bool,
}

impl FaceMap {
    /// Marks the samples in known rest material, and the cells that meet it.
    pub(super) fn note(&mut self, rest: &[UncutRegion]) {
        let here = || rest.iter().filter(|part| part.face == self.face);
        if here().next().is_none() {
            return;
        }
        let [rows, columns] = [self.u.len(), self.v.len()].map(|n| n.saturating_sub(1));
        self.unfinished = vec![false; rows * columns];
        for [u, v] in here().flat_map(|part| &part.cells) {
            let [i, j] = [held(&self.u, u.ends()), held(&self.v, v.ends())];
            for index in i.clone().flat_map(|i| j.clone().map(move |j| i * (columns + 1) + j)) {
                if let Some(Some(sample)) = self.samples.get_mut(index) {
                    sample.rest = true;
                }
            }
            // A rectangle between two grid lines holds no sample, but meets the cell around it: cells count from the value
            // before the range to that behind it.
            let [i, j] = [i, j].map(|range| range.start.saturating_sub(1)..range.end);
            for (i, j) in i.flat_map(|i| j.clone().map(move |j| (i, j))) {
                if i < rows && j < columns {
                    self.unfinished[i * columns + j] = true;
                }
            }
        }
    }
}

impl FaceMap {
    /// Takes over the deeper gouges of another map. Uncut points stay uncut.
    pub(super) fn deepen(&mut self, other: &Self) {
        for (sample, other) in self.samples.iter_mut().zip(&other.samples) {
            let (Some(sample), Some(other)) = (sample, other) else { continue };
            // `None`, uncut, compares below every height and is kept.
            if sample.height > other.height && other.height.is_some_and(|height| height < 0.0) {
                (sample.height, sample.line) = (other.height, other.line);
            }
        }
    }

    /// Returns a line of the other map that finishes a point over which this one leaves more than `total` \[mm\], outside
    /// known rest material.
    pub(super) fn finished_by(&self, other: &Self, total: f64) -> Option<u32> {
        let pairs = self.samples.iter().flatten().zip(other.samples.iter().flatten());
        let mut open = pairs.filter(|(sample, _)| {
            !sample.rest && sample.height.is_none_or(|height| height > total)
        });
        open.find_map(|(_, other)| other.line.filter(|_| other.height <= Some(total)))
    }
}

/// Returns the indices of increasing values that lie in a range.
fn held(values: &[f64], [low, high]: [f64; 2]) -> std::ops::Range<usize> {
    values.partition_point(|value| *value < low)..values.partition_point(|value| *value <= high)
}

/// Lowest or highest sample of all faces.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ExtremeHeight {
    /// Number of the face.
    pub face: usize,
    /// Parameters.
    pub uv: Uv,
    /// Point of the face, workpiece frame \[mm\].
    pub point: Point3<f64>,
    /// Height left \[mm\].
    pub height: f64,
    /// The tool reaches the end of the search range: the gouge may be deeper.
    pub or_deeper: bool,
    /// Line of the program that made it.
    pub line: u32,
    /// The line is a rapid move that gouges on a control that runs each axis at its own speed.
    pub dog_leg: bool,
}

/// Summary of the heights over all faces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Deviation {
    /// Points measured, uncut ones among them.
    pub points: usize,
    /// The lowest sample: the worst gouge, if below 0.
    pub lowest: Option<ExtremeHeight>,
    /// The highest sample outside what is known not to be finished: the worst excess, if above 0.
    pub highest: Option<ExtremeHeight>,
    /// Points in what is known not to be finished.
    pub rest: usize,
    /// Points elsewhere that no tool came near.
    pub uncut: usize,
    /// Area of the faces \[mm²\].
    pub area: f64,
    /// Area around uncut points \[mm²\].
    pub uncut_area: f64,
    /// Points that could not be measured.
    pub unmeasured: usize,
    /// Effect of errors of tool and setup on the heights.
    pub sensitivity: Sensitivity,
    /// Least and largest shift of the tool along its axis that would keep the tolerance everywhere \[mm\]: suggests a wrong
    /// tool length or height of the work offset. `None` unless most lines break the tolerance and one shift repairs all.
    pub higher: Option<[f64; 2]>,
    /// Line of a rapid move that gets to where no cut leaves as little as the tolerance.
    pub rapid: Option<u32>,
    /// Bounds between the points; `None` if they were not requested or cannot be proven.
    pub bounds: Option<HeightBounds>,
    /// Area by height, from lowest to highest.
    pub histogram: Vec<HistogramBin>,
}

/// Largest change of a height per error of a quantity that the check takes as exact \[mm/mm\], to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Sensitivity {
    /// Per error of the tool length: gouge or excess, by its sign.
    pub length: f64,
    /// Per error of the corner radius: a larger one gouges.
    pub radius: f64,
    /// Per error of the position of one rotary axis, in the worst direction, if the workpiece was set with the rotaries
    /// at zero; `None` without a machine.
    pub pivot: Option<f64>,
}

/// Bounds over whole faces, between the measured points as well, for the modelled geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeightBounds {
    /// Upper bound on the depth of gouges \[mm\].
    pub gouge: f64,
    /// Upper bound on excess \[mm\], outside known rest material, uncut points and the grid cells that touch either;
    /// `None` if it was not requested.
    pub excess: Option<f64>,
    /// Area for which the bounds are not proven \[mm²\].
    pub open: f64,
}

/// Area of the faces with a height in a range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HistogramBin {
    /// Range \[mm\].
    pub range: [f64; 2],
    /// Area \[mm²\].
    pub area: f64,
}

/// Bins of the histogram.
const BINS: usize = 40;

impl Deviation {
    /// Summarizes maps.
    pub(super) fn of<'a, Maps>(maps: &Maps) -> Self
    where
        Maps: Iterator<Item = &'a FaceMap> + Clone,
    {
        let samples = || {
            let samples = |map: &'a FaceMap| map.samples.iter().flatten().map(|s| (map.face, s));
            maps.clone().flat_map(samples)
        };
        let extreme = |(face, s): (usize, &HeightSample)| {
            let (height, line) = (s.height?, s.line?);
            let (uv, point, or_deeper, dog_leg) = (s.uv, s.point, false, false);
            Some(ExtremeHeight { face, uv, point, height, or_deeper, line, dog_leg })
        };
        let extremes = || samples().filter_map(extreme);
        let by_height = |a: &ExtremeHeight, b: &ExtremeHeight| a.height.total_cmp(&b.height);
        let uncut = || samples().filter(|(_, s)| s.height.is_none() && !s.rest);
        let finished = samples().filter(|(_, s)| !s.rest).filter_map(extreme);
        let (lowest, highest) = (extremes().min_by(by_height), finished.max_by(by_height));
        Self {
            points: samples().count(),
            lowest,
            highest,
            rest: samples().filter(|(_, s)| s.rest).count(),
            uncut: uncut().count(),
            area: samples().map(|(_, s)| s.area).sum(),
            // An empty sum of floating-point numbers is -0, which would be printed.
            uncut_area: uncut().map(|(_, s)| s.area).sum::<f64>() + 0.0,
            unmeasured: maps.clone().map(|map| map.unmeasured).sum(),
            sensitivity: Sensitivity { length: 0.0, radius: 0.0, pivot: None },
            higher: None,
            rapid: None,
            bounds: None,
            histogram: match (lowest, highest) {
                (Some(low), Some(high)) => {
                    let finished = samples().filter(|(_, s)| !s.rest);
                    let heights = finished.filter_map(|(_, s)| Some((s.height?, s.area)));
                    histogram(heights, [low.height, high.height])
                }
                _ => Vec::new(),
            },
        }
    }
}

/// Distributes areas into bins of equal height.
fn histogram(
    heights: impl Iterator<Item = (f64, f64)>,
    [low, high]: [f64; 2],
) -> Vec<HistogramBin> {
    // Computed from the ends alone, so that neighbouring bins share their edge exactly.
    let edge = |k: usize| low + (high - low) * k as f64 / BINS as f64;
    let mut bins: Vec<HistogramBin> =
        (0..BINS).map(|k| HistogramBin { range: [edge(k), edge(k + 1)], area: 0.0 }).collect();
    for (height, area) in heights {
        // The highest sample is at the upper edge of the last bin, and counts in it.
        let bin = bins.partition_point(|bin| bin.range[1] <= height).min(BINS - 1);
        if let Some(bin) = bins.get_mut(bin) {
            bin.area += area;
        }
    }
    bins
}

/// Motion of a program. Travel is of the tool tip from end to end of the moves, of arcs by their chords; moves from a
/// place that the program does not state have none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct AuditedMotion {
    /// Rapid moves.
    pub rapids: usize,
    /// Moves with feed, and dwells.
    pub cuts: usize,
    /// Travel of the rapid moves \[mm\].
    pub rapid_length: f64,
    /// Travel of the moves with feed \[mm\].
    pub cut_length: f64,
}

/// Axes against their limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Audit {
    /// In the order of the machine's axes.
    pub axes: [AxisAudit; AXES],
    /// Time of all blocks \[s\]; rapids at rapid speed, without acceleration.
    pub duration: f64,
    /// Part of it that is rapid.
    pub rapid: f64,
    /// Number of moves.
    pub moves: usize,
    /// Rapid moves and moves with feed among them.
    pub motion: AuditedMotion,
    /// Time of all blocks when each lasts as long as the fastest of its axes needs \[s\]: a control cannot be
    /// faster.
    pub held: f64,
    /// The same on a control that does not look ahead where rotaries move.
    pub linuxcnc: ModelAudit,
    /// Feed moves shorter than the servo period; `None` if there are none, or the machine does not name it.
    pub brief: Option<ShortBlocks>,
    /// Feed moves that come within the machine's singular cone; `None` if there are none.
    pub singular: Option<SingularPassages>,
    /// Cuts after which the tool stays where it is; `None` if there are none.
    pub unended: Option<UnendedCut>,
    /// Feed blocks that are far slower than both of their neighbours; `None` if there are none.
    pub slow: Option<SlowBlocks>,
}

/// Cuts after which the program ends, or changes the tool, without leading the tool off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct UnendedCut {
    /// Number of them: one for each tool at most.
    pub count: usize,
    /// Line of the first.
    pub line: u32,
}

impl fmt::Display for UnendedCut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, line } = self;
        let help = "write a rapid move or a retract along the tool axis after it";
        match count {
            1 => {
                write!(f, "line {line}: nothing leads the tool off the part after this cut; {help}")
            }
            _ => write!(
                f,
                "line {line}: nothing leads the tool off the part after this cut, and after {} more; {help}",
                count - 1
            ),
        }
    }
}

/// Feed blocks that are slower by far than the blocks beside them, such as one with a wrong F word.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SlowBlocks {
    /// Number of them.
    pub count: usize,
    /// Line of the slowest.
    pub line: u32,
    /// Speed beside it over its own.
    pub ratio: f64,
    /// Time that all of them cost \[s\].
    pub lost: f64,
}

/// Blocks shorter than the servo period: a control joins them, slows down or skips some.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ShortBlocks {
    /// Number of blocks.
    pub count: usize,
    /// Line of the shortest.
    pub line: u32,
    /// Its time \[s\].
    pub shortest: f64,
    /// The servo period \[s\].
    pub period: f64,
}

/// Passages of the singular cone: the tool axis is nearly along the rotary axis next to the workpiece, and small changes
/// of direction need large turns.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SingularPassages {
    /// Number of times that the program enters the cone.
    pub passages: usize,
    /// Line that comes nearest to the singular direction.
    pub line: u32,
    /// Least angle from the singular direction \[rad\].
    pub angle: f64,
    /// Largest turn of a rotary axis in one of these blocks \[rad\].
    pub turn: f64,
}

impl fmt::Display for SlowBlocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, line, ratio, lost } = self;
        let (blocks, cost) =
            if *count == 1 { ("block is", "costs") } else { ("blocks are", "cost") };
        write!(
            f,
            "line {line}: {count} {blocks} slower by far than those beside, this one {ratio:.0} times, and {cost} \
             {lost:.2} s; is F as intended?"
        )
    }
}

/// Range and rates of one axis, against its limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AxisAudit {
    /// Name of the axis.
    pub name: String,
    /// Smallest and largest position \[mm or rad\].
    pub range: Interval,
    /// Position farthest outside the travel, if any is.
    pub travel: Option<TravelOverrun>,
    /// Largest velocity in a feed move, against the limit.
    pub velocity: LimitRatio,
    /// Largest acceleration between feed moves, against the limit.
    pub acceleration: LimitRatio,
    /// Largest jerk over three feed moves, against the limit, if the control keeps the times of the blocks and
    /// stands still without acceleration. It is reported, not judged: not every control limits it.
    pub jerk: LimitRatio,
}

/// A position outside the travel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TravelOverrun {
    /// Line of the program.
    pub line: u32,
    /// Of a linear or a rotary axis.
    pub kind: AxisKind,
    /// Position \[mm or rad\].
    pub value: f64,
    /// Distance beyond the end of travel \[mm or rad\].
    pub excess: f64,
}

/// A rate against its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LimitRatio {
    /// Largest rate over limit, by the words as written.
    pub raw: f64,
    /// Largest rate over limit less the part that the rounding of the words can have added: this one is judged.
    pub worst: f64,
    /// Line where `worst` was found; 0 if nothing moves.
    pub line: u32,
    /// Count of blocks above the limit.
    pub broken: usize,
}

/// Something that breaks a tolerance or a limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// The tool cuts too deep.
    Gouge(ExtremeHeight),
    /// The tool leaves too much material.
    Excess(ExtremeHeight),
    /// One shift of the tool along its axis would keep the tolerance everywhere, see [`Deviation::higher`].
    Length {
        /// Least and largest shift \[mm\].
        higher: [f64; 2],
    },
    /// Points that no tool came near.
    Uncut {
        /// Number of points.
        points: usize,
        /// Their area \[mm²\].
        area: f64,
        /// One of the points, workpiece frame \[mm\].
        point: Point3<f64>,
    },
    /// A rapid move finishes a point that no cut finishes; the material that a rapid cuts does not count as finished.
    Rapid {
        /// Line of the program.
        line: u32,
    },
    /// Points that could not be measured: no normal, or a search that was given up.
    Unmeasured {
        /// Number of points.
        points: usize,
    },
    /// An axis leaves its travel.
    Travel {
        /// Name of the axis.
        axis: String,
        /// Position farthest outside.
        worst: TravelOverrun,
    },
    /// An axis is too fast.
    Velocity {
        /// Name of the axis.
        axis: String,
        /// Largest ratio.
        worst: LimitRatio,
    },
    /// An axis accelerates too much.
    Acceleration {
        /// Name of the axis.
        axis: String,
        /// Largest ratio.
        worst: LimitRatio,
    },
    /// The control is in a state in which no cut is right.
    State(StateFinding),
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gouge(e) => {
                let more = if e.or_deeper { " or more" } else { "" };
                write!(f, "gouge of {:.4} mm{more} {e}", 0.0 - e.height)
            }
            Self::Excess(e) => write!(f, "excess of {:.4} mm {e}", e.height),
            Self::Length { higher: [least, most] } => {
                let (way, near, far) =
                    if least > &0.0 { ("low", *least, *most) } else { ("high", -most, -least) };
                write!(
                    f,
                    "as a whole the tool runs {near:.4} to {far:.4} mm too {way} along its axis: no line does by itself; \
                     check the tool length and the height of the work offset"
                )
            }
            Self::Uncut { points, area, point: p } => write!(
                f,
                "{points} points ({area:.2} mm²) stay uncut, one at X {:.3} Y {:.3} Z {:.3}",
                p.x, p.y, p.z
            ),
            Self::Rapid { line } => write!(
                f,
                "line {line}: the face is cut at rapid speed where no feed move finishes it; make it a feed move"
            ),
            Self::Unmeasured { points } => {
                write!(
                    f,
                    "{points} points could not be measured (no surface normal, or no end of the search)"
                )
            }
            Self::Travel { axis, worst } => write!(
                f,
                "line {}: {axis} at {} is {} outside its travel",
                worst.line,
                worst.kind.format_value(worst.value),
                worst.kind.format_value(worst.excess)
            ),
            Self::Velocity { axis, worst } => write!(f, "{axis} velocity {worst}"),
            Self::Acceleration { axis, worst } => write!(f, "{axis} acceleration {worst}"),
            Self::State(finding) => finding.fmt(f),
        }
    }
}

impl fmt::Display for ExtremeHeight {
    /// Writes the point, and the line that made it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, Uv { u, v }) = (self.point, self.uv);
        write!(
            f,
            "on face {} at X {:.3} Y {:.3} Z {:.3} (u {u:.4}, v {v:.4}), made by line {}",
            self.face, p.x, p.y, p.z, self.line
        )?;
        f.write_str(if self.dog_leg { " if its axes run each at its own speed" } else { "" })
    }
}

impl fmt::Display for LimitRatio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "is {:.4} times its limit at line {}, above it in {} blocks",
            self.worst, self.line, self.broken
        )
    }
}

/// Audit of a program on a model of `LinuxCNC` 2.9.
///
/// The time is that of [`BlendClock`](crate::nc::control::BlendClock), rapids included. For the loads a block of length L in
/// which a rotary moves counts as passed at `sqrt(a L / 2)` at most, whatever comes next, `a` being the acceleration that
/// the axes named in the block allow along it. The control limits the words. With tool-centre-point control those are the
/// tip's, so linear axes may be driven beyond their limits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ModelAudit {
    /// Time of all blocks \[s\].
    pub seconds: f64,
    /// Largest velocity in a feed move.
    pub velocity: AxisRatio,
    /// Largest acceleration between feed moves in which rotaries move, or from and to rest, as the divided difference of
    /// mean velocities.
    pub acceleration: AxisRatio,
    /// Largest jerk, as the divided difference of three mean velocities of such moves, from and to rest without
    /// acceleration. `LinuxCNC` 2.9 does not limit jerk: the machine has to bear it.
    pub jerk: AxisRatio,
}

/// Rate of the axis that is nearest to its limit, or farthest beyond.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AxisRatio {
    /// Name of the axis.
    pub axis: String,
    /// Its rate against the limit.
    pub ratio: LimitRatio,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tongue of the rest between two grid lines meets the cells it runs through, and no sample.
    #[test]
    fn a_rest_thinner_than_the_grid_is_noted() {
        assert_eq!(held(&[0.0, 1.0, 2.0, 3.0], [0.5, 2.0]), 1..3);
        assert!(held(&[0.0, 1.0, 2.0, 3.0], [1.2, 1.4]).is_empty());
        let axis = vec![0.0, 1.0, 2.0, 3.0];
        let (u, v) = (axis.clone(), axis);
        let samples = vec![None; 16];
        let mut map = FaceMap { face: 1, u, v, samples, unmeasured: 0, unfinished: Vec::new() };
        let rest = crate::types::UncutRegion {
            face: 1,
            cells: vec![[[1.2, 1.4].into(), [0.5, 2.5].into()]],
            area: 0.4,
            uv: [[1.2, 1.4].into(), [0.5, 2.5].into()],
            bounds: [Point3::origin(); 2],
            depth: 1.0,
            deepest: [1.3, 1.0].into(),
            point: Point3::origin(),
            ball: 1.0,
            balls: [1.0; 2].into(),
            reason: crate::types::UncutReason::Hollow,
        };
        map.note(&[rest]);
        let cells: Vec<usize> = (0..9).filter(|i| map.unfinished[*i]).collect();
        assert_eq!(cells, [3, 4, 5]);
    }
}
