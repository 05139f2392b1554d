//! A program read back while it is written: block by block it has to say what was meant.

use super::post::{PostMove, PostPace, ProgramMoves};
use crate::machine::Kinematics;
use crate::math::angle::angle_between;
use crate::nc::read::{self, ClItem, ClMotion, ClReader, LineReader, ReadOptions};
use crate::nc::write::{self, BlockPace, Dialect, Style, rounding};
use crate::types::{AxisVector, Block, Diagnostic, Diagnostics, ToolPose};

/// Faults after which nothing more is read.
const MOST_FAULTS: usize = 20;

/// Last digit of a feed \[mm/min or 1/min\], by which it is rounded down, and up to a whole number of mm/min.
const FEED_DIGIT: f64 = 1e-3;

/// Largest inverse-time word; a quicker block has it, too.
const LARGEST_FEED: f64 = 99_999.999;

/// Times and lengths are sums of some thousand rounded numbers; a share.
const SUMS: f64 = 1e-8;

/// Positions are reckoned from words up to 1e6 mm through a chain of rotations and back \[mm\].
const PLACES: f64 = 1e-7;

/// Tool vectors have seven decimals: three errors of half a digit.
const VECTOR: f64 = 1e-7;

/// Chords of arcs \[mm\]; nothing is written as an arc.
const ARC: f64 = 1e-3;

/// What reading back found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadBackError {
    /// The text says something else than was meant.
    #[error("line {line} of the program: {what}")]
    Differs {
        /// Line of the program.
        line: u32,
        /// What was read and what was meant.
        what: String,
    },
    /// The reader does not understand all of the text.
    #[error("not understood: {}", .0.first().map(ToString::to_string).unwrap_or_default())]
    Unread(Diagnostics),
}

#[derive(Debug)]
enum Language {
    Program(Box<(LineReader, ProgramMoves)>),
    Locations(Box<ClReader>),
}

/// Reads a program while it is written.
#[derive(Debug)]
pub(super) struct ReadBack {
    kinematics: Kinematics,
    style: Style,
    language: Language,
    steps: Vec<read::Step>,
    moves: Vec<PostMove>,
    /// Lines so far.
    lines: u32,
    /// Time, way and turn of blocks whose words did not change.
    waiting: [f64; 3],
    before: ToolPose,
    /// Axes there, as the reader understands them.
    axes: AxisVector,
}

/// The reader of a dialect.
pub(super) fn reader_of(dialect: Dialect) -> read::Dialect {
    match dialect {
        Dialect::LinuxCnc | Dialect::G93 => read::Dialect::LinuxCnc,
        Dialect::Fanuc | Dialect::FanucVector => read::Dialect::Fanuc,
        Dialect::Haas => read::Dialect::Haas,
        Dialect::Siemens | Dialect::SiemensAxes => read::Dialect::Siemens,
        Dialect::Heidenhain | Dialect::HeidenhainAxes => read::Dialect::Heidenhain,
        Dialect::Apt => read::Dialect::Apt,
    }
}

/// Reads a whole program back; `ends` are those of the texts of its blocks.
///
/// # Errors
///
/// [`ReadBackError`].
pub(super) fn whole(
    kinematics: &Kinematics,
    style: &Style,
    blocks: &[Block],
    (text, ends): (&str, &[usize]),
) -> Result<(), ReadBackError> {
    let (Some(start), [begin, rest @ ..]) = (blocks.first(), ends) else { return Ok(()) };
    let part = |from: usize, to: usize| text.get(from..to).unwrap_or_default();
    let mut read = ReadBack::new(kinematics, style, (part(0, *begin), &start.pose))?;
    for ((pair, from), to) in blocks.windows(2).zip(ends).zip(rest) {
        let [before, block] = pair else { continue };
        read.block(part(*from, *to), (&block.q, &block.pose), write::pace(before, block))?;
    }
    read.end(text.get(ends.last().copied().unwrap_or(0)..).unwrap_or_default())
}

impl ReadBack {
    /// Starts with a program's text up to its starting position, where the tool is to be.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn new(
        kinematics: &Kinematics,
        style: &Style,
        (text, pose): (&str, &ToolPose),
    ) -> Result<Self, ReadBackError> {
        let dialect = reader_of(style.dialect);
        let language = if dialect == read::Dialect::Apt {
            Language::Locations(Box::new(ClReader::new(MOST_FAULTS)))
        } else {
            let options = ReadOptions::new(dialect, style.axes, MOST_FAULTS);
            let moves = ProgramMoves::new(kinematics, ARC).map_err(|error| unread(0, &error))?;
            Language::Program(Box::new((LineReader::new(&options), moves)))
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
            axes: AxisVector::zeros(),
        };
        read.start(text, pose)?;
        Ok(read)
    }

    /// Goes on with another tool: takes in the text of the change, up to where the tool starts.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn change_tool(
        &mut self,
        kinematics: &Kinematics,
        (text, pose): (&str, &ToolPose),
    ) -> Result<(), ReadBackError> {
        self.kinematics = kinematics.clone();
        if let Language::Program(of) = &mut self.language {
            of.1 =
                ProgramMoves::new(kinematics, ARC).map_err(|error| unread(self.lines, &error))?;
        }
        self.waiting = [0.0; 3];
        self.start(text, pose)
    }

    /// Text up to a place where the tool starts.
    fn start(&mut self, text: &str, pose: &ToolPose) -> Result<(), ReadBackError> {
        self.moves.clear();
        self.take(text)?;
        let stands = match &self.language {
            Language::Program(of) => Some(of.1.pose()),
            Language::Locations(cl) => cl.place(),
        };
        let q = self.kinematics.machine().home();
        match stands {
            Some(stands) => self.place(&stands, (&q, pose), [PLACES + 1.0, 1.0])?,
            None => return Err(self.differs("the start of the program moves nothing".to_owned())),
        }
        self.before = *pose;
        self.axes = match &self.language {
            Language::Program(of) => of.1.axes(),
            Language::Locations(_) => AxisVector::zeros(),
        };
        self.moves.clear();
        Ok(())
    }

    /// Takes in the text of a block, which may be none, and compares it with what is meant.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn block(
        &mut self,
        text: &str,
        (q, pose): (&AxisVector, &ToolPose),
        pace: BlockPace,
    ) -> Result<(), ReadBackError> {
        self.moves.clear();
        self.take(text)?;
        if let BlockPace::Timed { seconds, length, turn } = pace {
            let [time, way, round] = self.waiting;
            self.waiting = [time + seconds, way + length, round + turn];
        }
        let one = match self.moves.as_slice() {
            // Its words are those before.
            [] => return self.place(&self.before, (q, pose), [0.0; 2]),
            [one] => *one,
            all => return Err(self.differs(format!("{} moves for one block", all.len()))),
        };
        self.place(&one.pose, (q, pose), [0.0; 2])?;
        self.pace(&one, pace)?;
        self.before = one.pose;
        self.axes = one.q.unwrap_or(self.axes);
        self.waiting = [0.0; 3];
        Ok(())
    }

    /// Takes in the end of the program.
    ///
    /// # Errors
    ///
    /// [`ReadBackError`].
    pub(super) fn end(mut self, text: &str) -> Result<(), ReadBackError> {
        self.take(text)?;
        match self.language {
            Language::Program(of) => of.0.finish().map_err(ReadBackError::Unread),
            Language::Locations(cl) => cl.finish().map(|_| ()).map_err(ReadBackError::Unread),
        }
    }

    fn take(&mut self, text: &str) -> Result<(), ReadBackError> {
        for line in text.lines() {
            self.lines = self.lines.saturating_add(1);
            match &mut self.language {
                Language::Program(of) => {
                    let (reader, moves) = &mut **of;
                    reader.line(line, &mut self.steps).map_err(ReadBackError::Unread)?;
                    for step in self.steps.drain(..) {
                        let taken = moves.step(&step, &mut self.moves);
                        taken.map_err(|error| unread(self.lines, &error))?;
                    }
                }
                Language::Locations(cl) => {
                    if let Some(ClItem::Location(found)) = cl.line(line) {
                        let pace = match found.motion {
                            ClMotion::Rapid => PostPace::Rapid,
                            ClMotion::Feed(feed) => PostPace::Feed(feed),
                        };
                        let way = crate::blocks::Control::GreatCircle;
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

    /// What was read is where it is meant to be, to within rounding.
    fn place(
        &self,
        read: &ToolPose,
        (q, pose): (&AxisVector, &ToolPose),
        more: [f64; 2],
    ) -> Result<(), ReadBackError> {
        let words = &self.style.axes;
        let coordinates = self.style.dialect.coordinates();
        let half = words.rounding();
        let tip = rounding(&self.kinematics, q, words, coordinates, 0.0) + PLACES + more[0];
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

    /// F says what is meant to a last digit; in inverse time it is not above.
    fn pace(&self, read: &PostMove, pace: BlockPace) -> Result<(), ReadBackError> {
        let [seconds, length, turn] = self.waiting;
        let is_apt = self.style.dialect == Dialect::Apt;
        let (said, meant) = match (read.pace, pace) {
            (PostPace::Rapid, BlockPace::Rapid) => return Ok(()),
            (PostPace::Rapid, _) => return Err(self.differs("rapid instead of feed".to_owned())),
            (_, BlockPace::Rapid) => return Err(self.differs("feed instead of rapid".to_owned())),
            // A CL file cannot say how fast the tool turns where its tip stands.
            (PostPace::Feed(_), _) if is_apt && length <= 0.0 => return Ok(()),
            (PostPace::Feed(said), _) if length > 0.0 => (60.0 * said, 60.0 * length / seconds),
            (PostPace::Seconds(time), _) if self.style.inverse_time => {
                (60.0 / time, (60.0 / seconds).min(LARGEST_FEED))
            }
            (PostPace::Seconds(_) | PostPace::Feed(_), _) if turn <= 0.0 => {
                return Err(self.differs("F of nothing".to_owned()));
            }
            // Degrees per minute of both rotaries: the reader's time is that of its own turn.
            (PostPace::Seconds(time), _) => {
                let turned = read.q.map_or(0.0, |q| (q - self.axes).fixed_rows::<2>(3).norm());
                if !(turned > 0.0 && time > 0.0) {
                    return Ok(());
                }
                (60.0 * turned.to_degrees() / time, 60.0 * turn.to_degrees() / seconds)
            }
            // Rounding moves the tip where none was meant.
            (PostPace::Feed(_), _) => return Ok(()),
        };
        let above = if self.style.inverse_time { 0.0 } else { FEED_DIGIT };
        let fits =
            said <= meant * (1.0 + SUMS) + above && said >= meant * (1.0 - SUMS) - FEED_DIGIT;
        if fits {
            return Ok(());
        }
        Err(self.differs(format!("F is {said:.4} instead of {meant:.4}")))
    }

    /// A difference; where the reader knows not all of the text, that comes first.
    fn differs(&self, what: String) -> ReadBackError {
        let warnings = match &self.language {
            Language::Program(of) => of.0.warnings(),
            Language::Locations(cl) => cl.warnings(),
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
