//! Reads a program back while it is written: every block must mean what was intended.

use super::axis_point::AxesPose;
use super::constants::MOST_FAULTS;
use super::error::ReadBackError;
use super::options::{PostMove, PostPace};
use super::replay::ProgramMoves;
use crate::machine::Kinematics;
use crate::math::angle::angle_between;
use crate::nc::control::STANDING;
use crate::nc::read::{self, ClItem, ClMotion, ClReader, Coolant, LineReader, ReadOptions};
use crate::nc::write::{self, BlockPace, Style, rounding};
use crate::types::{AxisVector, Block, Diagnostic, Diagnostics, ToolPose};
use nalgebra::Point3;

/// Last digit of a feed \[mm/min or 1/min\]: feeds are rounded down by it, or up to a whole number of mm/min.
const FEED_DIGIT: f64 = 1e-3;

/// Largest inverse-time word; shorter blocks have it, too.
const LARGEST_FEED: f64 = 99_999.999;

/// Rounding of times and lengths, which are sums of some thousand numbers, as a share.
const SUMS: f64 = 1e-8;

/// Rounding of positions, which come from words up to 1e6 mm through a chain of rotations and back \[mm\].
const POSITIONS: f64 = 1e-7;

/// Rounding of tool vectors with seven decimals: three errors of half a digit.
const VECTOR: f64 = 1e-7;

/// Chord tolerance of arcs \[mm\]; the writer writes no arcs.
const ARC: f64 = 1e-3;

/// Reader of the text.
#[derive(Debug)]
enum ReadBackLanguage {
    Program(Box<(LineReader, ProgramMoves)>),
    Locations(Box<ClReader>),
}

/// Reader that follows a program while it is written.
#[derive(Debug)]
pub(super) struct ReadBack {
    kinematics: Kinematics,
    style: Style,
    language: ReadBackLanguage,
    steps: Vec<read::Step>,
    moves: Vec<PostMove>,
    /// Number of lines so far.
    lines: u32,
    /// Time \[s\], travel of the tip \[mm\] and of the rotaries \[rad\] of blocks whose words did not change.
    waiting: [f64; 3],
    /// Tool pose at the last block end.
    before: ToolPose,
    /// Tip and axes there, as the reader understands them.
    tip: Point3<f64>,
    axes: AxisVector,
}

/// Program text, with the offsets at which the texts of its blocks end.
#[derive(Debug, Clone, Copy)]
pub struct WrittenText<'a> {
    /// Whole text.
    pub text: &'a str,
    /// End of the text of each block \[bytes\].
    pub ends: &'a [usize],
}

/// Reads a whole program back and compares every block with what was intended.
///
/// # Errors
///
/// [`ReadBackError`].
pub fn read_back(
    kinematics: &Kinematics,
    style: &Style,
    blocks: &[Block],
    written: WrittenText<'_>,
) -> Result<(), ReadBackError> {
    let WrittenText { text, ends } = written;
    read_back_sections(style, &[WrittenSection { kinematics, blocks, ends }], text)
}

/// Blocks that one tool runs in a program of several, with the ends of their texts.
#[derive(Debug, Clone, Copy)]
pub struct WrittenSection<'a> {
    /// Machine and setup, with the length of the tool.
    pub kinematics: &'a Kinematics,
    /// Intended blocks; the first is the starting position.
    pub blocks: &'a [Block],
    /// End of the text of each block \[bytes\].
    pub ends: &'a [usize],
}

/// Reads a whole program of several tools back, as [`read_back()`] does.
///
/// # Errors
///
/// [`ReadBackError`].
pub fn read_back_sections(
    style: &Style,
    sections: &[WrittenSection<'_>],
    text: &str,
) -> Result<(), ReadBackError> {
    let part = |from: usize, to: usize| text.get(from..to).unwrap_or_default();
    let mut read: Option<ReadBack> = None;
    let mut end = 0;
    for &WrittenSection { kinematics, blocks, ends } in sections {
        let (Some(start), [begin, rest @ ..]) = (blocks.first(), ends) else { continue };
        let head = part(end, *begin);
        let mut at_start = match read.take() {
            None => ReadBack::new(kinematics, style, head, &start.pose)?,
            Some(mut before) => {
                before.change_tool(kinematics, head, &start.pose)?;
                before
            }
        };
        for ((pair, from), to) in blocks.windows(2).zip(ends).zip(rest) {
            let [before, block] = pair else { continue };
            let at = AxesPose { q: block.q, pose: block.pose };
            at_start.block(part(*from, *to), &at, write::pace(before, block))?;
        }
        end = ends.last().copied().unwrap_or(end);
        read = Some(at_start);
    }
    read.map_or(Ok(()), |read| read.end(text.get(end..).unwrap_or_default()))
}

impl ReadBack {
    /// Starts with the text of a program up to its starting position, which must be `pose`.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn new(
        kinematics: &Kinematics,
        style: &Style,
        text: &str,
        pose: &ToolPose,
    ) -> Result<Self, ReadBackError> {
        let dialect = style.dialect.dialect();
        let language = if dialect == read::Dialect::Apt {
            ReadBackLanguage::Locations(Box::new(ClReader::new(MOST_FAULTS)))
        } else {
            let options = ReadOptions::new(dialect, style.axes, MOST_FAULTS);
            let moves = ProgramMoves::new(kinematics, ARC).map_err(|error| unread(0, &error))?;
            ReadBackLanguage::Program(Box::new((LineReader::new(&options), moves)))
        };
        let mut read = Self {
            kinematics: kinematics.clone(),
            style: *style,
            language,
            steps: Vec::new(),
            moves: Vec::new(),
            lines: 0,
            waiting: [0.0; 3],
            before: *pose,
            tip: pose.tip,
            axes: AxisVector::zeros(),
        };
        read.start(text, pose)?;
        Ok(read)
    }

    /// Continues with another tool: takes in the text of the change, up to the starting position of the tool.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn change_tool(
        &mut self,
        kinematics: &Kinematics,
        text: &str,
        pose: &ToolPose,
    ) -> Result<(), ReadBackError> {
        self.kinematics = kinematics.clone();
        if let ReadBackLanguage::Program(of) = &mut self.language {
            of.1 =
                ProgramMoves::new(kinematics, ARC).map_err(|error| unread(self.lines, &error))?;
        }
        self.waiting = [0.0; 3];
        self.start(text, pose)
    }

    /// Takes in the text up to a starting position.
    fn start(&mut self, text: &str, pose: &ToolPose) -> Result<(), ReadBackError> {
        self.moves.clear();
        self.take(text)?;
        // The tool may approach the start in several moves: only where it ends counts.
        let found = match &self.language {
            ReadBackLanguage::Program(of) => Some(of.1.pose()),
            ReadBackLanguage::Locations(cl) => cl.place(),
        };
        let q = self.kinematics.machine().home();
        match found {
            // The way to the part may end up to 1 mm and 1 rad away.
            Some(found) => {
                self.tip = found.tip;
                self.compare_pose(&found, &AxesPose { q, pose: *pose }, [POSITIONS + 1.0, 1.0])?;
            }
            None => return Err(self.differs("the start of the program moves nothing".to_owned())),
        }
        self.before = *pose;
        self.axes = match &self.language {
            ReadBackLanguage::Program(of) => of.1.axes(),
            ReadBackLanguage::Locations(_) => AxisVector::zeros(),
        };
        self.moves.clear();
        Ok(())
    }

    /// Takes in the text of a block, which may be empty, and compares it with the intended end and time.
    ///
    /// Returns the tool at both ends as the text has them.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn block(
        &mut self,
        text: &str,
        end: &AxesPose,
        pace: BlockPace,
    ) -> Result<[ToolPose; 2], ReadBackError> {
        self.moves.clear();
        self.take(text)?;
        // A block whose words all stay as they were is not written; its time belongs to the next one.
        if let BlockPace::Timed { seconds, length, turn } = pace {
            let [time, travel, turned] = self.waiting;
            self.waiting = [time + seconds, travel + length, turned + turn];
        }
        let one = match self.moves.as_slice() {
            // No word changes: the block ends where the one before does.
            [] => {
                self.compare_pose(&self.before, end, [0.0; 2])?;
                return Ok([self.before; 2]);
            }
            [one] => *one,
            all => return Err(self.differs(format!("{} moves for one block", all.len()))),
        };
        self.compare_pose(&one.pose, end, [0.0; 2])?;
        self.compare_feed(&one, pace)?;
        let before = std::mem::replace(&mut self.before, one.pose);
        (self.tip, self.axes) = (one.pose.tip, one.q.unwrap_or(self.axes));
        self.waiting = [0.0; 3];
        Ok([before, one.pose])
    }

    /// Takes in the text that switches the coolant.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn coolant(&mut self, text: &str, coolant: Coolant) -> Result<(), ReadBackError> {
        self.moves.clear();
        self.take(text)?;
        let read = match &self.language {
            ReadBackLanguage::Program(of) => of.1.coolant(),
            ReadBackLanguage::Locations(cl) => cl.coolant(),
        };
        if !self.moves.is_empty() || read.is_on() != coolant.is_on() {
            return Err(self.differs(format!("the coolant is {read:?} instead of {coolant:?}")));
        }
        Ok(())
    }

    /// Takes in the text behind the last block.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn end(mut self, text: &str) -> Result<(), ReadBackError> {
        self.take(text)?;
        match self.language {
            ReadBackLanguage::Program(of) => of.0.finish().map_err(ReadBackError::Unread),
            ReadBackLanguage::Locations(cl) => {
                cl.finish().map(|_| ()).map_err(ReadBackError::Unread)
            }
        }
    }

    /// Reads lines, and collects their moves.
    fn take(&mut self, text: &str) -> Result<(), ReadBackError> {
        for line in text.lines() {
            self.lines = self.lines.saturating_add(1);
            match &mut self.language {
                ReadBackLanguage::Program(of) => {
                    let (reader, moves) = &mut **of;
                    reader.line(line, &mut self.steps).map_err(ReadBackError::Unread)?;
                    // What is written has no rounded corners.
                    reader.release_element(&mut self.steps);
                    for step in self.steps.drain(..) {
                        let taken = moves.step(&step, &mut self.moves);
                        taken.map_err(|error| unread(self.lines, &error))?;
                    }
                }
                ReadBackLanguage::Locations(cl) => {
                    if let Some(ClItem::Location(found)) = cl.line(line) {
                        let pace = match found.motion {
                            ClMotion::Rapid => PostPace::Rapid,
                            ClMotion::Feed(feed) => PostPace::Feed(feed),
                        };
                        let way = crate::blocks::BlockInterpolation::GreatCircle;
                        let (line, pose) = (found.line, found.pose);
                        self.moves.push(PostMove { line, pose, q: None, pace, way });
                    }
                    if !cl.faults().is_empty() {
                        return Err(ReadBackError::Unread(cl.faults().to_vec().into()));
                    }
                }
            }
        }
        Ok(())
    }

    /// Compares a pose that was read with the intended one, to within rounding and `more` \[mm, rad\].
    fn compare_pose(
        &self,
        read: &ToolPose,
        end: &AxesPose,
        more: [f64; 2],
    ) -> Result<(), ReadBackError> {
        let AxesPose { q, pose } = end;
        let words = &self.style.axes;
        let coordinates = self.style.dialect.coordinates();
        let half = words.rounding();
        // Rounded axis words move the tip by up to this much; vectors have digits of their own.
        let tip = rounding(&self.kinematics, q, words, coordinates, 0.0) + POSITIONS + more[0];
        let axis = (half[3] + half[4]).max(VECTOR) * (1.0 + SUMS) + SUMS + more[1];
        let off = [(read.tip - pose.tip).norm(), angle_between(&read.axis, &pose.axis)];
        if off[0] <= tip && off[1] <= axis {
            return Ok(());
        }
        let [a, b] = [read, pose].map(|pose| {
            let ([x, y, z], [i, j, k]): ([f64; 3], [f64; 3]) =
                (pose.tip.coords.into(), pose.axis.into_inner().into());
            format!("X {x:.4} Y {y:.4} Z {z:.4} mm, axis {i:.6} {j:.6} {k:.6}")
        });
        Err(self.differs(format!("the tool goes to {a} instead of {b}, workpiece frame")))
    }

    /// Compares F with the intended speed, to its last digit; in inverse time it must not be above.
    fn compare_feed(&self, read: &PostMove, pace: BlockPace) -> Result<(), ReadBackError> {
        let (read_feed, meant) = match (read.pace, pace) {
            (PostPace::Rapid, BlockPace::Rapid) => return Ok(()),
            (PostPace::Rapid, _) => return Err(self.differs("rapid instead of feed".to_owned())),
            (_, BlockPace::Rapid) => return Err(self.differs("feed instead of rapid".to_owned())),
            (PostPace::Seconds(time), _) if self.style.inverse_time => {
                let meant = (60.0 / self.waiting[0]).min(LARGEST_FEED);
                (60.0 / time, [meant; 2])
            }
            (pace, _) => match self.speeds(read, pace)? {
                Some(speeds) => speeds,
                None => return Ok(()),
            },
        };
        // An inverse time above the intended one would be too fast; a feed may round either way.
        let above = if self.style.inverse_time { 0.0 } else { FEED_DIGIT };
        let fits = |meant: f64| {
            read_feed <= meant * (1.0 + SUMS) + above
                && read_feed >= meant * (1.0 - SUMS) - FEED_DIGIT
        };
        if meant.into_iter().any(fits) {
            return Ok(());
        }
        Err(self.differs(format!("F is {read_feed:.4} instead of {:.4}", meant[0])))
    }

    /// Returns a speed that was read, and those that are right: along the planned travel, and along the words, which
    /// takes the planned time. `None` where F does not matter. Speeds are in mm/min, or degrees/min.
    fn speeds(
        &self,
        read: &PostMove,
        pace: PostPace,
    ) -> Result<Option<(f64, [f64; 2])>, ReadBackError> {
        let [seconds, length, turn] = self.waiting;
        let moved = (read.pose.tip - self.tip).norm();
        let (feed, travels) = match pace {
            // A CL file has no word for the speed of a turn while the tip stands.
            PostPace::Feed(_) if moved <= STANDING => return Ok(None),
            PostPace::Feed(feed) => (feed, [length, moved]),
            _ if turn <= 0.0 => return Err(self.differs("F of nothing".to_owned())),
            // Degrees per minute of both rotaries: the reader's time is that of its own turn.
            PostPace::Seconds(time) => {
                let turned = read.q.map_or(0.0, |q| (q - self.axes).fixed_rows::<2>(3).norm());
                if !(turned > 0.0 && time > 0.0) {
                    return Ok(None);
                }
                let turned = turned.to_degrees();
                (turned / time, [turn.to_degrees(), turned])
            }
            PostPace::Rapid => return Ok(None),
        };
        Ok(Some((60.0 * feed, travels.map(|travel| 60.0 * travel / seconds))))
    }

    /// Returns the error for a difference; text that the reader does not understand comes first.
    fn differs(&self, what: String) -> ReadBackError {
        let warnings = match &self.language {
            ReadBackLanguage::Program(of) => of.0.warnings(),
            ReadBackLanguage::Locations(cl) => cl.warnings(),
        };
        if warnings.is_empty() {
            ReadBackError::Differs { line: self.lines, what }
        } else {
            ReadBackError::Unread(warnings.to_vec().into())
        }
    }
}

fn unread(line: u32, error: &dyn std::fmt::Display) -> ReadBackError {
    ReadBackError::Unread(Diagnostics::from(Diagnostic {
        line,
        column: 1,
        message: error.to_string(),
        help: String::new(),
    }))
}
