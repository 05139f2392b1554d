//! APT/CL files (ISO 4343 style): records to cutter locations.

use crate::types::{Fault, ToolPose};
use nalgebra::{Point3, UnitVector3, Vector3};

/// A CL file, in mm, rad, s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClFile {
    /// Cutter locations in order.
    pub records: Vec<ClRecord>,
    /// `CUTTER/d,r`: diameter and corner radius \[mm\].
    pub cutter: Option<[f64; 2]>,
    /// `LOADTL/n`.
    pub tool: Option<u32>,
}

/// One `GOTO`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClRecord {
    /// Line, counted from 1.
    pub line: u32,
    /// Tip and tool axis in the frame of the file.
    pub pose: ToolPose,
    /// How the tool gets there.
    pub motion: ClMotion,
}

/// How a cutter location is approached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClMotion {
    /// After `RAPID`.
    Rapid,
    /// At this tip speed \[mm/s\].
    Feed(f64),
}

/// Largest coordinate \[mm\]: beyond it is a slip.
const LARGEST: f64 = 1e6;
/// How far the length of an axis vector may be from 1: seven decimals leave 1e-7, four 1e-4.
const AXIS_SLACK: f64 = 1e-3;
/// Millimetres in an inch, by definition.
const INCH: f64 = 25.4;

/// Reads an APT/CL file.
///
/// Understood: `GOTO` with or without `i,j,k` (modal), `RAPID` (for the next `GOTO`), `FEDRAT` with
/// the unit first or last, `UNITS`, `CUTTER`, `LOADTL`, `MULTAX`; `PARTNO`, `PPRINT`, `SPINDL`,
/// `COOLNT`, `REMARK`, `TOLER` and `FINI` say nothing about motion. `$` joins lines, `$$` begins a
/// comment.
///
/// # Errors
///
/// Every fault found, up to `most_faults`: other major words (they may move the tool), bad numbers,
/// axis vectors that are not of length 1, a `GOTO` without a feed.
pub fn cl(text: &str, most_faults: usize) -> Result<ClFile, Vec<Fault>> {
    let mut reader = Reader::new();
    let mut statement = String::new();
    let mut first_line = 0;
    for (index, line) in text.lines().enumerate() {
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        if statement.is_empty() {
            first_line = number;
        }
        let line = line.split("$$").next().unwrap_or_default().trim();
        if let Some(open) = line.strip_suffix('$') {
            statement.push_str(open);
            statement.push(' ');
            continue;
        }
        statement.push_str(line);
        reader.statement(first_line, &statement);
        statement.clear();
        if reader.ended || reader.faults.len() >= most_faults {
            break;
        }
    }
    if reader.faults.is_empty() && !reader.ended {
        let fault = Fault::whole("the file has no FINI: a line is missing, or the file was cut");
        reader.faults.push(fault.with_help("end it with FINI"));
    }
    if reader.faults.is_empty() { Ok(reader.file) } else { Err(reader.faults) }
}

/// A stretch of an APT/CL file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Passage<'a> {
    /// Lines that say nothing about motion, as they stand; `UNITS` and comments between `GOTO`s are left out.
    Words(Vec<&'a str>),
    /// Cutter locations, by their index in [`ClFile::records`].
    Moves(std::ops::Range<usize>),
}

/// Splits a file that [`cl`] can read into what moves the tool and what does not, in order.
pub fn passages(text: &str) -> Vec<Passage<'_>> {
    let mut passages = Vec::new();
    let mut records = 0;
    let mut joined = false;
    let mut kept = false;
    for line in text.lines() {
        let words = line.split("$$").next().unwrap_or_default().trim();
        if !joined {
            let major = words.split('/').next().unwrap_or_default().trim().to_ascii_uppercase();
            kept = match major.as_str() {
                "GOTO" => {
                    moves(&mut passages, records);
                    records += 1;
                    false
                }
                "RAPID" | "FEDRAT" | "UNITS" => false,
                "" => records == 0,
                _ => true,
            };
        }
        joined = words.ends_with('$');
        if kept {
            match passages.last_mut() {
                Some(Passage::Words(lines)) => lines.push(line),
                _ => passages.push(Passage::Words(vec![line])),
            }
        }
    }
    passages
}

/// One location more.
fn moves(passages: &mut Vec<Passage<'_>>, record: usize) {
    match passages.last_mut() {
        Some(Passage::Moves(range)) => range.end = record + 1,
        _ => passages.push(Passage::Moves(record..record + 1)),
    }
}

/// State while reading.
struct Reader {
    file: ClFile,
    faults: Vec<Fault>,
    axis: UnitVector3<f64>,
    scale: f64,
    /// Speed \[mm/s\].
    feed: Option<f64>,
    rapid: bool,
    ended: bool,
}

impl Reader {
    fn new() -> Self {
        Self {
            file: ClFile::default(),
            faults: Vec::new(),
            axis: Vector3::z_axis(),
            scale: 1.0,
            feed: None,
            rapid: false,
            ended: false,
        }
    }

    /// One statement, its continuation lines joined.
    fn statement(&mut self, line: u32, text: &str) {
        let (major, minor) = text.split_once('/').unwrap_or((text, ""));
        let major = major.trim().to_ascii_uppercase();
        let word = major.split_whitespace().next().unwrap_or_default();
        match word {
            "" | "PARTNO" | "PPRINT" | "SPINDL" | "COOLNT" | "REMARK" | "TOLER" | "MULTAX" => {}
            "FINI" => self.ended = true,
            "RAPID" => self.rapid = true,
            "UNITS" => self.units(line, minor),
            "FEDRAT" => self.feed(line, minor),
            "CUTTER" => self.cutter(line, minor),
            "LOADTL" => self.tool(line, minor),
            "GOTO" => self.goto(line, minor),
            _ => {
                let message = format!("{word:?} is not understood");
                self.fault(line, message, "it may move the tool; leave it out or write GOTO");
            }
        }
    }

    fn fault(&mut self, line: u32, message: String, help: &str) {
        self.faults.push(Fault { line, column: 1, message, help: help.to_owned() });
    }

    fn units(&mut self, line: u32, minor: &str) {
        match minor.trim().to_ascii_uppercase().as_str() {
            "MM" => self.scale = 1.0,
            "INCH" | "INCHES" => self.scale = INCH,
            other => self.fault(line, format!("unit {other:?} is not known"), "write MM or INCH"),
        }
    }

    fn feed(&mut self, line: u32, minor: &str) {
        let mut speed = None;
        let mut scale = self.scale;
        for item in minor.split(',').map(|item| item.trim().to_ascii_uppercase()) {
            match item.as_str() {
                "MMPM" => scale = 1.0,
                "IPM" => scale = INCH,
                _ => speed = item.parse::<f64>().ok().filter(|f| *f > 0.0 && *f <= LARGEST),
            }
        }
        if let Some(speed) = speed {
            self.feed = Some(speed * scale / 60.0);
        } else {
            let message = format!("FEDRAT/{minor}: not a feed per minute above 0");
            self.fault(line, message, "write FEDRAT/800.0,MMPM");
        }
        self.rapid = false;
    }

    fn cutter(&mut self, line: u32, minor: &str) {
        let Some(values) = self.numbers(line, minor) else { return };
        if let Some(&diameter) = values.first() {
            let corner = values.get(1).copied().unwrap_or(0.0);
            self.file.cutter = Some([diameter * self.scale, corner * self.scale]);
        }
    }

    fn tool(&mut self, line: u32, minor: &str) {
        let first = minor.split(',').next().unwrap_or_default().trim();
        match first.parse() {
            Ok(number) => self.file.tool = Some(number),
            Err(_) => self.fault(line, format!("LOADTL/{minor}: not a tool number"), ""),
        }
    }

    fn goto(&mut self, line: u32, minor: &str) {
        let Some(values) = self.numbers(line, minor) else { return };
        let tip = match *values.as_slice() {
            [x, y, z] => Point3::new(x, y, z),
            [x, y, z, i, j, k] => {
                let Some(axis) = self.axis_of(line, Vector3::new(i, j, k)) else { return };
                self.axis = axis;
                Point3::new(x, y, z)
            }
            _ => {
                let message = format!("GOTO has {} numbers; 3 or 6 are needed", values.len());
                return self.fault(line, message, "");
            }
        };
        let motion = match (self.rapid, self.feed) {
            (true, _) => ClMotion::Rapid,
            (false, Some(feed)) => ClMotion::Feed(feed),
            (false, None) => {
                let message = "GOTO without a feed".to_owned();
                return self.fault(line, message, "write RAPID or FEDRAT before it");
            }
        };
        self.rapid = false;
        let pose = ToolPose { tip: tip * self.scale, axis: self.axis };
        self.file.records.push(ClRecord { line, pose, motion });
    }

    /// A tool axis of length 1, within what decimals leave.
    fn axis_of(&mut self, line: u32, vector: Vector3<f64>) -> Option<UnitVector3<f64>> {
        let length = vector.norm();
        if (length - 1.0).abs() > AXIS_SLACK {
            let message = format!("the tool axis has length {length:.6}, not 1");
            self.fault(line, message, "");
            return None;
        }
        Some(UnitVector3::new_normalize(vector))
    }

    /// Comma-separated numbers.
    fn numbers(&mut self, line: u32, minor: &str) -> Option<Vec<f64>> {
        let mut values = Vec::with_capacity(6);
        for item in minor.split(',').map(str::trim) {
            match item.parse::<f64>() {
                Ok(value) if value.abs() <= LARGEST => values.push(value),
                _ => {
                    let message = format!("{item:?} is not a number up to {LARGEST}");
                    self.fault(line, message, "");
                    return None;
                }
            }
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_modal_and_rapid_holds_once() {
        let text = "PARTNO DEMO\nUNITS/MM\nMULTAX/ON\nLOADTL/1\nCUTTER/10.0,5.0\nRAPID\n\
                    GOTO/1,2,3,0,$ joined\n0,1\n";
        assert!(cl(text, 10).is_err(), "text after a joining $ is no number");
        let text = "UNITS/MM\nRAPID\nGOTO/1,2,3,0,$\n0.6,0.8\nFEDRAT/MMPM,600.\nGOTO/2,2,3 $$ up\n\
                    FINI\n";
        let file = cl(text, 10).unwrap();
        let motions: Vec<_> = file.records.iter().map(|r| (r.line, r.motion)).collect();
        assert_eq!(motions, [(3, ClMotion::Rapid), (6, ClMotion::Feed(10.0))]);
        assert_eq!(file.records[0].pose.axis, file.records[1].pose.axis);
        assert!((file.records[1].pose.axis.y - 0.6).abs() < 1e-15);
    }

    #[test]
    fn what_moves_the_tool_is_told_from_what_does_not() {
        let text = "PARTNO A\nUNITS/INCH\n$$ why\nRAPID\nGOTO/1,2,$\n3\n$$ here\nFEDRAT/1,IPM\nGOTO/2,2,3\n\
                    COOLNT/$\nON\nGOTO/3,2,3\nFINI\n";
        let expected = [
            Passage::Words(vec!["PARTNO A", "$$ why"]),
            Passage::Moves(0..2),
            Passage::Words(vec!["COOLNT/$", "ON"]),
            Passage::Moves(2..3),
            Passage::Words(vec!["FINI"]),
        ];
        assert_eq!(passages(text), expected);
    }

    #[test]
    fn several_faults_are_reported_with_their_lines() {
        let faults = cl("GOTO/1,2,3\nCIRCLE/1\nRAPID\nGOTO/1,2,nan\nFINI\n", 10).unwrap_err();
        let lines: Vec<_> = faults.iter().map(|fault| fault.line).collect();
        assert_eq!(lines, [1, 2, 4]);
    }
}
