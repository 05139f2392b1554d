//! G and M codes, and words without a value.

use super::line::{FrameEffect, FrameWord, ShiftMode, SiemensBlock, SiemensMotion};
use super::reader::SiemensReader;
use super::word::{SiemensCode, SiemensWord, WordName, WordTail};
use crate::read::arc::ArcSense;
use crate::read::control::{DistanceMode, FeedMode, FeedUnit};
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Smoothing, Turning};

/// Words without a target: modes, tools, calls.
const KEPT: [&str; 56] = [
    "MSG",
    "CYCLE832",
    "FFWON",
    "FFWOF",
    "SOFT",
    "BRISK",
    "DRIVE",
    "COMPCAD",
    "COMPCURV",
    "COMPON",
    "COMPOF",
    "COMPSURF",
    "FGREF",
    "FGROUP",
    "FIFOCTRL",
    "STOPFIFO",
    "STARTFIFO",
    "STOPRE",
    "UPATH",
    "SPATH",
    "CFC",
    "CFTCP",
    "CFIN",
    "FNORM",
    "DYNNORM",
    "DYNPOS",
    "DYNROUGH",
    "DYNSEMIFIN",
    "DYNFINISH",
    "DYNPREC",
    "WORKPIECE",
    "DIAMOF",
    "ORISON",
    "ORISOF",
    "ADIS",
    "ADISPOS",
    "CTOL",
    "OTOL",
    "WALIMOF",
    "GETD",
    "SETMS",
    "ACC",
    "CDOF",
    "CP",
    "CUT2D",
    "CUT2DF",
    "GROUP_BEGIN",
    "GROUP_END",
    "KONT",
    "LIMS",
    "NORM",
    "RTLIOF",
    "RTLION",
    "SPCOF",
    "SPCON",
    "VELOLIM",
];

impl SiemensReader {
    /// Applies a G or M code.
    pub(super) fn code(
        &mut self,
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        written: SiemensCode,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let SiemensCode { letter, tenths } = written;
        // G and M codes of Sinumerik are whole numbers.
        if tenths % 10 != 0 {
            return Err(not_understood(item, code));
        }
        let number = tenths / 10;
        if letter == b'M' {
            m_code(state, line, item, number, code);
            return Ok(());
        }
        match number {
            0 => self.moves(line, SiemensMotion::Rapid),
            1 => self.moves(line, SiemensMotion::Feed),
            2 => self.moves(line, SiemensMotion::Arc(ArcSense::Clockwise)),
            3 => self.moves(line, SiemensMotion::Arc(ArcSense::Counterclockwise)),
            4 => line.dwell = true,
            17..=19 => self.plane = usize::try_from(number - 17).unwrap_or_default(),
            110..=112 => line.pole = Some(number),
            // G70 and G71 concern the lengths of the workpiece, G700 and G710 feeds as well. F under
            // G70 and G71 is in the basic system of the machine, which is metric by default.
            70 | 71 | 700 | 710 => {
                state.control.inch = matches!(number, 70 | 700);
                self.feed_unit = if number == 700 { FeedUnit::Inch } else { FeedUnit::Millimetre };
            }
            90 => self.distance = DistanceMode::Absolute,
            91 => self.distance = DistanceMode::Incremental,
            93 => feed_mode(state, FeedMode::Inverse),
            94 => feed_mode(state, FeedMode::PerMinute),
            95 => feed_mode(state, FeedMode::PerRevolution),
            // G53 and G153 suppress all frames in their block, as SUPA does.
            53 | 153 => line.machine = true,
            // G54 to G57 are the first four offsets, G505 to G599 the ones behind.
            54..=57 => state.control.set_offset(u8::try_from(number - 54).unwrap_or(u8::MAX)),
            505..=599 => state.control.set_offset(u8::try_from(number - 501).unwrap_or(u8::MAX)),
            // Without a settable offset words are axis positions less the tool: no offset of ours.
            500 => state.control.set_offset(u8::MAX),
            // Exact stop and blending: the programmed path stays.
            9 | 60 | 64 | 601 | 602 | 603 | 641..=646 => {
                // G9 and G601 to G603 concern one block, or the end of an exact stop.
                match number {
                    60 => state.control.smooth(state.log.line, Smoothing::Exact),
                    64 | 641..=646 => state.control.smooth(state.log.line, Smoothing::OfMachine),
                    _ => {}
                }
                let text = code.get(item.at..item.end).unwrap_or_default();
                state.control.keep(state.log.line, text);
            }
            // Limits of the working area or of the spindle.
            25 | 26 => {
                state.control.keep(state.log.line, code.get(item.at..).unwrap_or_default());
                line.passive = true;
            }
            40 | 290 | 450 | 451 => {}
            _ => return Err(not_understood(item, code)),
        }
        Ok(())
    }

    fn moves(&mut self, line: &mut SiemensBlock, motion: SiemensMotion) {
        self.motion = Some(motion);
        line.motion = true;
    }

    /// Applies `M1=3`, an M code of the first spindle.
    pub(super) fn spindle_code(
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        number: u32,
        code: &str,
    ) {
        m_code(state, line, item, number, code);
    }

    /// Applies a word without a value, or a call.
    pub(super) fn keyword(
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        name: &str,
        code: &str,
    ) -> Result<(), ReadRemark> {
        match name {
            "TRAORI" => {
                // TRAORI(2) and offsets of its own select other machine data, which the reader does
                // not have.
                if !matches!(arguments(item), "" | "1") {
                    let message = "TRAORI with values of its own";
                    return Err(ReadRemark::new(
                        item.at,
                        message,
                        "set up the machine's first one",
                    ));
                }
                state.control.enable_tcp();
            }
            "TRAFOOF" => {
                state.control.disable_tcp();
                state.control.turning = None;
            }
            // Suppresses all frames: axis positions.
            "SUPA" => line.machine = true,
            // Large-circle interpolation of the tool axis, against linear rotary axes.
            "ORIVECT" | "ORIPLANE" => state.control.turning = Some(Turning::GreatCircle),
            "ORIAXES" => state.control.turning = Some(Turning::Rotary),
            // With rotary words ORIMKS and ORIWKS differ by the frames that are refused here.
            "ORIWKS" | "ORIMKS" => {}
            _ if frame_word(name).is_some() => {
                if let Some((kind, mode)) = frame_word(name) {
                    line.frame = Some(FrameWord::new(kind, mode, item.at));
                }
            }
            "RET" => line.ends = true,
            "MCALL" => line.calls_modally = true,
            _ if KEPT.contains(&name) => {
                let text = code.get(item.at..item.end).unwrap_or_default();
                state.control.keep(state.log.line, text);
            }
            _ => return Err(not_understood(item, code)),
        }
        Ok(())
    }
}

/// Returns kind and effect of a programmable frame.
fn frame_word(name: &str) -> Option<(FrameEffect, ShiftMode)> {
    Some(match name {
        "TRANS" => (FrameEffect::Shift, ShiftMode::Replacing),
        "ATRANS" => (FrameEffect::Shift, ShiftMode::Additive),
        "ROT" => (FrameEffect::Turn, ShiftMode::Replacing),
        "AROT" => (FrameEffect::Turn, ShiftMode::Additive),
        "MIRROR" => (FrameEffect::Mirror, ShiftMode::Replacing),
        "AMIRROR" => (FrameEffect::Mirror, ShiftMode::Additive),
        "SCALE" => (FrameEffect::Scale, ShiftMode::Replacing),
        "ASCALE" => (FrameEffect::Scale, ShiftMode::Additive),
        _ => return None,
    })
}

/// Returns the text between the brackets of a call.
pub(super) fn arguments<'a>(item: &SiemensWord<'a>) -> &'a str {
    match item.behind {
        WordTail::Arguments => {
            let text = item.line.get(item.value_at..item.end).unwrap_or_default().trim();
            text.strip_prefix('(').and_then(|text| text.strip_suffix(')')).unwrap_or(text).trim()
        }
        _ => "",
    }
}

fn m_code(
    state: &mut ReaderState,
    line: &mut SiemensBlock,
    item: &SiemensWord<'_>,
    number: u32,
    code: &str,
) {
    let text = code.get(item.at..item.end).unwrap_or_default();
    match number {
        2 | 17 | 30 => line.ends = true,
        3..=5 => {
            state.control.sense = i8::from(number == 3) - i8::from(number == 4);
            line.turns_spindle = true;
        }
        6 => line.changes_tool = true,
        0 | 1 | 7..=9 | 40..=45 => state.control.keep(state.log.line, text),
        _ => {
            let message = format!("{text} is not known: it is kept, and taken to move nothing");
            state.log.warn(item.line, ReadRemark::new(item.at, message, ""));
            state.control.keep(state.log.line, text);
        }
    }
}

fn feed_mode(state: &mut ReaderState, mode: FeedMode) {
    if state.control.feed_mode != mode {
        state.control.feed = None;
    }
    state.control.feed_mode = mode;
}

/// Help for programs that are called but not in the file.
const OTHER_FILES: &str = "programs of other files are not known; put their lines here";

/// Help for milling cycles.
const OTHER_CYCLES: &str = "cycles but those of drilling are the control's own; post their moves";

/// Returns the help for a G or M code that is not understood.
fn code_help(number: u32) -> &'static str {
    match number {
        41 | 42 => "the radius and the corners are the control's; post the path of the tool centre",
        33..=35 | 331 | 332 | 63 => "threads: use CYCLE84 or CYCLE840, or write the moves",
        74 | 75 => "where the machine goes is in its data; write SUPA and the positions",
        96 | 97 | 961 | 962 | 971 | 972 => "constant cutting speed is of lathes",
        147 | 148 | 247 | 248 | 347 | 348 => "soft approach: write the moves",
        58 | 59 | 507..=599 => "write TRANS, or one of G54 to G57",
        291 => "ISO dialect mode: read its lines as fanuc",
        _ => "is it the right dialect?",
    }
}

fn not_understood(item: &SiemensWord<'_>, code: &str) -> ReadRemark {
    let text = super::super::log::excerpt(code.get(item.at..item.end).unwrap_or_default());
    let name = item.text_name().to_ascii_uppercase();
    let help = match (item.name, name.as_str()) {
        (WordName::Code(SiemensCode { tenths, .. }), _) => code_help(tenths / 10),
        (_, "CALL" | "PCALL" | "EXTCALL" | "MCALL" | "CASE" | "EXTERN" | "L") => OTHER_FILES,
        (_, "TOROT" | "TOFRAME" | "ROTS" | "AROTS" | "CROTS") => {
            "frames out of the plane: swivel with CYCLE800, or post plain coordinates"
        }
        (_, "A2" | "B2" | "C2" | "LEAD" | "TILT" | "A4" | "A5" | "A6" | "A7") => {
            "write the tool axis as A3= B3= C3=, or rotary axes"
        }
        (_, "TRANSMIT" | "TRACYL" | "TRAANG" | "TRACON") => {
            "the machine data say how such coordinates become axes; post axis coordinates"
        }
        (_, "DIAMON" | "DIAM90" | "DIAMCYCOF") => "X in diameters is of lathes; write radii",
        (_, "RND" | "RNDM" | "CHF" | "CHR" | "FRC" | "FRCM") => {
            "write the rounding or chamfer as an arc or a line of its own"
        }
        (_, "CIP" | "CT" | "I1" | "J1" | "K1") => "write the arc with its centre or radius",
        (_, "SPOS" | "SPOSA" | "M19") => "the angle of the spindle moves no axis: leave it out",
        (_, "ID" | "IDS" | "WHEN" | "WHENEVER" | "EVERY" | "DO" | "FROM") => {
            "what a synchronized action does depends on the run; leave it out to read the program"
        }
        (_, "SETAL") => "the program raises an alarm here",
        (_, "ORICONCW" | "ORICONCCW" | "ORICONIO" | "ORICONTO" | "ORICURVE" | "ORIPATH") => {
            "write tool axes at shorter distances, and ORIVECT or ORIAXES"
        }
        (_, name) if name.starts_with("POCKET") || name.starts_with("SLOT") => OTHER_CYCLES,
        (_, name) if name.starts_with("CYCLE") || name.starts_with("LONGHOLE") => OTHER_CYCLES,
        // A bare name calls a subprogram.
        _ if name.len() > 1 && item.behind == WordTail::Nothing => OTHER_FILES,
        _ => "is it the right dialect?",
    };
    ReadRemark::new(item.at, format!("{text} is not understood as siemens"), help)
}
