//! The state of a CL file from line to line.

use super::file::ClItem;
use super::known::{WordMeaning, meaning};
use super::state::{ClResult, ClState, FileEnd, PathShape};
use super::statement::LARGEST;
use super::statement::{ClLine, ClWord, JoinedLines, Statement, classify, single, text_word};
use crate::types::{Diagnostic, Diagnostics, ToolPose};
use crate::words::Coolant;
use nalgebra::{Isometry3, Vector3};

/// Reads a CL file line by line; in memory at a time is one statement.
///
/// Understood, in capitals or not, with or without `/` and blanks round it, `$` joining lines and `$$`
/// beginning comments:
///
/// * `GOTO` with or without `i,j,k`: left out, the tool axis stays (under `MULTAX/OFF` and after a new
///   frame it is that frame's z). `GODLTA`, `FROM`.
/// * `RAPID` for the next location; `FEDRAT` per minute or per revolution, unit first or last.
/// * Arcs: `CIRCLE` with centre and axis (right-hand rule), of which one with a radius and nothing behind
///   it holds for all locations on it (Creo), others for the next (NX and others); `MOVARC`;
///   `TLON,GOFWD/(CIRCLE/..),ON,(LINE/..)` behind `INDIRV` (CATIA).
/// * `CYCLE`: every location up to `CYCLE/OFF` is a hole. Depth behind `FEDTO` or `DEPTH`, or the first
///   number.
/// * `UNITS`; `MSYS` (locations are in it); `CSYS` (locations are not in it, its z is the tool axis);
///   `CUTTER`, `TLDATA`, `LOADTL`, `LOAD/TOOL`, `$$-> CUTTER`.
///
/// Words without effect on motion are passed over. Unknown ones, cutter compensation and text for the
/// post-processor are kept with a warning; what moves the tool or shifts coordinates in a way that is not understood
/// (`NURBS`, `TRANS`, `ROTABL` ..) is a fault.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::{ClItem, ClReader};
///
/// let mut reader = ClReader::new(10);
/// for line in ["RAPID", "GOTO/1.,2.,.5,0,0,1", "FEDRAT/MMPM,600.", "GOTO/2.,2.,.5", "FINI"] {
///     if let Some(ClItem::Location(record)) = reader.line(line) {
///         assert_eq!(record.pose.tip.z, 0.5);
///     }
/// }
/// assert!(reader.finish()?.is_empty());
/// # Ok::<(), trunnion_types::types::Diagnostics>(())
/// ```
#[derive(Debug)]
pub struct ClReader {
    pub(super) state: ClState,
    joined: JoinedLines,
    faults: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    /// Words that were warned of.
    warned: Vec<String>,
    most: usize,
    line: u32,
}

impl ClReader {
    /// Starts a file; `most_faults`: after so many nothing is read any more.
    pub fn new(most_faults: usize) -> Self {
        let axis = Vector3::z_axis();
        let state = ClState {
            scale: 1.0,
            units: false,
            axis,
            frame_axis: axis,
            feed: None,
            spindle: None,
            rapid: false,
            shape: PathShape::Straight,
            direction: None,
            cycle: None,
            place: None,
            frame: Isometry3::identity(),
            first_frame: None,
            world: true,
            directive: None,
            cutter: None,
            tool: None,
            coolant: Coolant::Off,
            end: None,
        };
        Self {
            state,
            joined: JoinedLines::default(),
            faults: Vec::new(),
            warnings: Vec::new(),
            warned: Vec::new(),
            most: most_faults.max(1),
            line: 0,
        }
    }

    /// Takes in a line, without its line break. `None`: the statement goes on in the next line, or is faulty.
    pub fn line(&mut self, line: &str) -> Option<ClItem> {
        self.line = self.line.saturating_add(1);
        if self.is_full() {
            return None;
        }
        let read = match classify(line, self.joined.next_line()) {
            ClLine::Comment => return Some(ClItem::Remark),
            ClLine::Open(words) => return self.join(words),
            ClLine::Whole(words) if self.joined.is_open() => {
                self.join(words);
                let joined = std::mem::take(&mut self.joined);
                let read = self.statement(&joined.statement());
                self.joined = joined;
                self.joined.clear();
                read
            }
            ClLine::Whole(words) => single(self.line, words, |statement| self.statement(statement)),
        };
        match read {
            Ok(item) => Some(item),
            Err(fault) => {
                self.faults.push(*fault);
                None
            }
        }
    }

    fn join(&mut self, words: &str) -> Option<ClItem> {
        if !self.joined.add(self.line, words) {
            let fault = self.joined.statement().fault(0, "the statement does not end".into(), "");
            self.faults
                .push(fault.with_help("end the lines of one statement with $, but not the last"));
            self.joined.clear();
        }
        None
    }

    /// Returns the faults so far.
    pub fn faults(&self) -> &[Diagnostic] {
        &self.faults
    }

    /// Returns true once so many defects were found that reading has stopped.
    pub fn is_full(&self) -> bool {
        self.faults.len() >= self.most
    }

    /// Returns the warnings so far: words kept but not understood.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// Returns diameter and corner radius of the current cutter \[mm\].
    pub fn cutter(&self) -> Option<[f64; 2]> {
        self.state.cutter.map(|cutter| cutter.map(|value| value * self.state.scale))
    }

    /// Returns the number of the current tool.
    pub fn tool(&self) -> Option<u32> {
        self.state.tool
    }

    /// Returns the current spindle speed \[1/s\].
    pub fn spindle_speed(&self) -> Option<f64> {
        self.state.spindle
    }

    /// Returns the coolant that runs.
    pub fn coolant(&self) -> Coolant {
        self.state.coolant
    }

    /// Returns the length of the unit of the file \[mm\].
    pub fn unit(&self) -> f64 {
        self.state.scale
    }

    /// Returns the current feed \[mm/s\].
    pub fn feed(&self) -> Option<f64> {
        self.state.feed
    }

    /// Returns the pose of the tool in the active coordinates; `None` before the first location, and after a change of
    /// coordinates.
    pub fn place(&self) -> Option<ToolPose> {
        self.state.place
    }

    /// Returns the transformation from the current coordinates to those of the first `MSYS`.
    pub fn first_from_written(&self) -> Isometry3<f64> {
        match self.state.first_frame {
            // first <- world <- current frame.
            Some(first) if first != self.state.frame => first.inverse() * self.state.frame,
            _ => Isometry3::identity(),
        }
    }

    /// Ends the file; returns the warnings: words kept but not understood.
    ///
    /// # Errors
    ///
    /// All faults; a file that was cut has one.
    pub fn finish(self) -> Result<Vec<Diagnostic>, Diagnostics> {
        let faults = self.faults_at_end();
        if faults.is_empty() { Ok(self.warnings) } else { Err(faults.into()) }
    }

    pub(super) fn faults_at_end(&self) -> Vec<Diagnostic> {
        let mut faults = self.faults.clone();
        if faults.is_empty() && (self.state.end.is_none() || self.joined.is_open()) {
            let message = "the file has no FINI: a line is missing, or the file was cut";
            faults.push(Diagnostic::whole(message).with_help("end it with FINI"));
        }
        faults
    }

    fn statement(&mut self, statement: &Statement<'_>) -> ClResult<ClItem> {
        if statement.text.trim_start().starts_with("$$->") {
            return self.directive(statement);
        }
        // Most statements are GOTO: they skip the table of words.
        let (word, rest) = statement.split();
        if word == "GOTO" && self.state.end != Some(FileEnd::File) {
            self.state.end = None;
            return self.goto(statement, rest);
        }
        // A second statement of the line must not be lost.
        Self::alone(statement, rest)?;
        let means = meaning(&word);
        if self.state.end == Some(FileEnd::File) {
            return Self::after_the_end(statement, means);
        }
        // A path may go on behind END-OF-PATH.
        if means != WordMeaning::Remark {
            self.state.end = None;
        }
        match means {
            WordMeaning::Doubtful(why) => {
                self.warn(statement, &word, format!("{word} is kept: {why}"), "");
            }
            WordMeaning::Unknown if word.is_empty() => {
                let text = statement.text.trim();
                let message = format!("{:?} does not begin with a word", shortened(text));
                return Err(Box::new(statement.fault(0, message, "a line before may lack its $")));
            }
            WordMeaning::Unknown => {
                let message = format!("{word} is not known; it is kept as it stands");
                let help =
                    "should it move the tool or change the coordinates, the path read is wrong";
                self.warn(statement, &word, message, help);
            }
            WordMeaning::Refused(help) => {
                let message = format!("{word} moves the tool in a way that is not understood");
                return Err(Box::new(statement.fault(0, message, help)));
            }
            _ => return self.understood(means, statement, rest),
        }
        Ok(ClItem::Words)
    }

    fn understood(
        &mut self,
        means: WordMeaning,
        of: &Statement<'_>,
        rest: ClWord<'_>,
    ) -> ClResult<ClItem> {
        match means {
            WordMeaning::Goto => return self.goto(of, rest),
            WordMeaning::Delta => return self.delta(of, rest),
            WordMeaning::Curve => return self.curve(of, rest),
            WordMeaning::Rapid => {
                self.state.rapid = true;
                self.state.shape.leave();
                return self.with_rapid(of, rest);
            }
            WordMeaning::Feed => return self.feed_rate(of, rest),
            WordMeaning::Circle => return self.circle(of, rest),
            WordMeaning::Arc => return self.arc(of, rest),
            WordMeaning::Direction => return self.direction(of, rest),
            WordMeaning::Remark => return Ok(ClItem::Remark),
            WordMeaning::From => self.from(of, rest)?,
            WordMeaning::Units => self.units(of, rest)?,
            WordMeaning::Cutter => self.set_cutter(rest),
            WordMeaning::ToolData => self.tool_data(rest),
            WordMeaning::Tool => self.set_tool(of, rest)?,
            WordMeaning::Spindle => self.spindle(rest),
            WordMeaning::Coolant => {
                self.state.coolant = Coolant::of_cl(rest.items().map(|word| word.text));
            }
            WordMeaning::MultiAxis if rest.is("OFF") => self.state.axis = self.state.frame_axis,
            WordMeaning::ToolAxis => self.tool_axis(of, rest)?,
            WordMeaning::Frame => self.frame(of, rest)?,
            WordMeaning::World => self.world(of, rest)?,
            WordMeaning::Transform => self.transform(of, rest)?,
            WordMeaning::Cycle => self.cycle(of, rest)?,
            WordMeaning::End => self.state.end = Some(FileEnd::File),
            WordMeaning::PathEnd => {
                self.state.end = Some(FileEnd::Path);
                self.state.cycle = None;
            }
            _ => {}
        }
        Ok(ClItem::Words)
    }

    /// Checks that no further statement stands behind `;`.
    fn alone(statement: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let Some(found) = rest.text.find(';').filter(|_| !text_word(statement.text.trim_start()))
        else {
            return Ok(());
        };
        // A comment of some writers may follow the last word.
        if rest.text.get(found + 1..).is_none_or(|behind| behind.trim().is_empty()) {
            return Ok(());
        }
        let message = "a second statement behind ;".to_owned();
        Err(Box::new(statement.fault(rest.at + found, message, "write one statement a line")))
    }

    /// Runs what stands behind `RAPID,`: a location.
    fn with_rapid(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        let text = rest.text.trim_start_matches([',', ' ']);
        let at = rest.at + rest.text.len() - text.len();
        let end = text.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len());
        let (word, behind) = text.split_at(end);
        let list = behind.trim_start().trim_start_matches('/');
        let list = ClWord { text: list, at: at + text.len() - list.len() };
        match meaning(&word.to_ascii_uppercase()) {
            WordMeaning::Goto => self.goto(of, list),
            WordMeaning::Delta => self.delta(of, list),
            _ if word.is_empty() || !text.contains('/') => Ok(ClItem::Manner),
            _ => {
                let message = format!("{} behind RAPID is not understood", shortened(text));
                Err(Box::new(of.fault(at, message, "write RAPID and what follows as two lines")))
            }
        }
    }

    /// Checks a statement behind `FINI`, where nothing may move.
    fn after_the_end(statement: &Statement<'_>, means: WordMeaning) -> ClResult<ClItem> {
        match means {
            WordMeaning::Remark | WordMeaning::End => Ok(ClItem::Remark),
            WordMeaning::Coolant => Ok(ClItem::Words),
            WordMeaning::Nothing if statement.text.trim_start().get(..6) != Some("PARTNO") => {
                Ok(ClItem::Words)
            }
            _ => {
                let message = "there is more behind FINI".to_owned();
                Err(Box::new(statement.fault(
                    0,
                    message,
                    "split the file: one program ends with FINI",
                )))
            }
        }
    }

    /// Warns of a word, once.
    pub(super) fn warn(&mut self, of: &Statement<'_>, word: &str, message: String, help: &str) {
        let known = self.warned.iter().any(|warned| warned == word);
        if !known && self.warned.len() < self.most {
            self.warned.push(word.to_owned());
            let at = of.text.len() - of.text.trim_start().len();
            self.warnings.push(of.fault(at, message, help));
        }
    }
}

#[expect(clippy::unnecessary_box_returns, reason = "errors of statements are boxed")]
pub(super) fn no_number(of: &Statement<'_>, word: ClWord<'_>) -> Box<Diagnostic> {
    let message = format!("{:?} is not a number up to {LARGEST}", shortened(word.text));
    Box::new(of.fault(word.at, message, "write numbers between commas, as in GOTO/1.5,.2,-3"))
}

/// Returns the start of a text, for messages.
pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 24;
    let mut shown: String = text.trim().chars().take(SHOWN).collect();
    if text.trim().chars().count() > SHOWN {
        shown.push_str("..");
    }
    shown
}
