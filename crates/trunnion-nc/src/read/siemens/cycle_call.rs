//! Drilling cycles of Sinumerik and their parameters: `CYCLE83(RTP, RFP, SDIS, DP, ..)`.

use super::codes;
use super::cycle::{CycleDwell, CycleKind, CyclePecks, SiemensCycle};
use super::reader::SiemensReader;
use super::word::SiemensWord;
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::log::ReadRemark;
use crate::read::number::DecimalMark;
use crate::read::state::ReaderState;

/// Places of the arguments that all cycles have.
const RETRACT: usize = 0;
const REFERENCE: usize = 1;
const SAFETY: usize = 2;
const BOTTOM: usize = 3;
const DEPTH: usize = 4;
const DWELL: usize = 5;

/// Pitches \[mm\] of metric coarse threads (ISO 261) by their nominal diameters, for `MPIT`.
const COARSE: [(f64, f64); 15] = [
    (3.0, 0.5),
    (4.0, 0.7),
    (5.0, 0.8),
    (6.0, 1.0),
    (8.0, 1.25),
    (10.0, 1.5),
    (12.0, 1.75),
    (14.0, 2.0),
    (16.0, 2.0),
    (18.0, 2.5),
    (20.0, 2.5),
    (24.0, 3.0),
    (30.0, 3.5),
    (36.0, 4.0),
    (48.0, 5.0),
];

/// Arguments of a call.
pub(super) struct CallArguments<'a> {
    texts: Vec<&'a str>,
    reader: &'a SiemensReader,
    at: usize,
    value_at: usize,
}

impl<'a> CallArguments<'a> {
    pub(super) fn of(reader: &'a SiemensReader, item: &SiemensWord<'a>) -> Self {
        let text = codes::arguments(item);
        let (mut texts, mut depth, mut from) = (Vec::new(), 0_u32, 0);
        // Commas inside of brackets belong to functions.
        for (at, byte) in text.bytes().enumerate() {
            match byte {
                b'(' | b'[' => depth += 1,
                b')' | b']' => depth = depth.saturating_sub(1),
                b',' if depth == 0 => {
                    texts.push(text.get(from..at).unwrap_or_default());
                    from = at + 1;
                }
                _ => {}
            }
        }
        texts.push(text.get(from..).unwrap_or_default());
        Self { texts, reader, at: item.at, value_at: item.value_at }
    }

    /// Returns an argument; `None` where it is left out.
    pub(super) fn given(&self, place: usize) -> Result<Option<f64>, ReadRemark> {
        let text = self.texts.get(place).map_or("", |text| text.trim());
        // Names of technologies and the like are no numbers.
        if text.is_empty() || text.starts_with('"') {
            return Ok(None);
        }
        let written = FormulaText { text, from: 0, at: self.value_at, mark: DecimalMark::Point };
        arithmetic::value(&written, &self.reader.variables).map(Some)
    }

    /// Returns an argument, zero where it is left out.
    pub(super) fn number(&self, place: usize) -> Result<f64, ReadRemark> {
        Ok(self.given(place)?.unwrap_or(0.0))
    }

    /// Returns a decimal digit of an argument that is a code: 0 its ones.
    fn digit(&self, place: usize, of: i32) -> Result<f64, ReadRemark> {
        Ok((self.number(place)?.abs() / 10_f64.powi(of) + 1e-9).floor().rem_euclid(10.0))
    }

    fn refused<T>(&self, message: impl Into<String>, help: &str) -> Result<T, ReadRemark> {
        Err(ReadRemark::new(self.at, message, help))
    }
}

/// Returns the place of `_GMODE` of a cycle, behind which `_DMODE` and `_AMODE` stand.
fn mode_place(name: &str) -> Option<usize> {
    match name {
        "CYCLE81" | "CYCLE82" | "CYCLE87" | "CYCLE89" => Some(6),
        "CYCLE83" | "CYCLE840" => Some(17),
        "CYCLE84" => Some(21),
        "CYCLE85" => Some(8),
        "CYCLE86" => Some(11),
        "CYCLE88" => Some(7),
        _ => None,
    }
}

impl SiemensReader {
    /// Reads the call of a drilling cycle; `None`: it is another word.
    pub(super) fn drilling_cycle(
        &self,
        state: &mut ReaderState,
        item: &SiemensWord<'_>,
        name: &str,
    ) -> Result<Option<SiemensCycle>, ReadRemark> {
        let Some(modes) = mode_place(name) else { return Ok(None) };
        let arguments = CallArguments::of(self, item);
        self.check_modes(&arguments, modes)?;
        let scale = state.control.scale();
        let length = |place: usize| arguments.number(place).map(|value| scale * value);
        let [retract, reference] = [length(RETRACT)?, length(REFERENCE)?];
        let start = reference + length(SAFETY)?.abs();
        let bottom = bottom(state, &arguments, item, [reference, scale])?;
        if bottom >= start || retract < start {
            let message = format!(
                "{name}: retraction plane {retract} mm, start {start} mm, bottom {bottom} mm"
            );
            return arguments.refused(message, "they must lie above each other in this order");
        }
        let turns = arguments.digit(modes + 2, 1)? > 1.5;
        let dwell = |place: usize| {
            let value = arguments.number(place)?;
            // Negative values, and a 2 in the tens of _AMODE, are turns of the spindle.
            let of = if turns || value < 0.0 { CycleDwell::Turns } else { CycleDwell::Seconds };
            Ok::<_, ReadRemark>(of(value.abs()))
        };
        let no_dwell = matches!(name, "CYCLE81" | "CYCLE87");
        let dwell_of_cycle = if no_dwell { CycleDwell::Seconds(0.0) } else { dwell(DWELL)? };
        let kind = match name {
            "CYCLE83" => {
                let at_depth = dwell(8)?;
                let at_bottom =
                    if arguments.number(15)?.abs() > 0.0 { dwell(15)? } else { at_depth };
                let first = match (arguments.given(6)?, arguments.given(5)?) {
                    (Some(depth), _) if depth.abs() > 0.0 => scale * depth.abs(),
                    (_, Some(level)) => reference - scale * level,
                    _ => {
                        return arguments
                            .refused("CYCLE83 without FDEP or FDPR", "write the first depth");
                    }
                };
                if first <= 0.0 {
                    let message = "CYCLE83: the first depth is above the reference plane";
                    return arguments.refused(message, "look at FDEP and FDPR");
                }
                let variant = arguments.number(11)?;
                if !matches!(arguments.number(12)?.round(), 0.0 | 3.0)
                    || !(0.0..=1.0).contains(&variant)
                {
                    let message = "CYCLE83 along another axis, or other than VARI 0 and 1";
                    return arguments.refused(message, "write the moves");
                }
                let decrease = arguments.number(7)?;
                let factor = arguments.number(10)?;
                let back = length(14)?;
                CycleKind::Pecks(CyclePecks {
                    first,
                    decrease: if decrease > 0.0 { scale * decrease } else { decrease },
                    least: length(13)?.max(0.0),
                    at_depth,
                    at_start: dwell(9)?,
                    at_bottom,
                    first_feed: if factor > 0.0 { factor } else { 1.0 },
                    clears: variant > 0.5,
                    back: if back > 0.0 { back } else { 1.0 },
                    ahead: length(16)?.max(0.0),
                })
            }
            "CYCLE84" => {
                if arguments.number(15)?.abs() > 0.0 {
                    return arguments.refused("CYCLE84 in strokes (_VARI)", "tap in one stroke");
                }
                let pitch = pitch(&arguments, [7, 8, 13], scale)?;
                let Some(pitch) = pitch else {
                    return arguments.refused("CYCLE84 without a pitch", "write MPIT or PIT");
                };
                let speed = arguments.number(10)?.abs();
                let speed = if speed > 0.0 { speed } else { state.control.speed };
                let out = arguments.number(11)?.abs();
                let speeds = [speed, if out > 0.0 { out } else { speed }];
                CycleKind::Tap { pitch: Some(pitch), speeds, after: arguments.number(6)? }
            }
            "CYCLE840" => {
                let pitch = pitch(&arguments, [9, 10, 12], scale)?;
                let speeds = [state.control.speed; 2];
                CycleKind::Tap { pitch, speeds, after: arguments.number(7)? }
            }
            "CYCLE85" => CycleKind::Ream { feeds: [arguments.number(6)?, arguments.number(7)?] },
            "CYCLE86" => CycleKind::Bore {
                aside: [length(7)?, length(8)?, length(9)?],
                sense: arguments.number(6)?,
            },
            "CYCLE87" | "CYCLE88" => CycleKind::Stop,
            "CYCLE89" => CycleKind::FeedOut,
            _ => CycleKind::Drill,
        };
        let at = item.at;
        Ok(Some(SiemensCycle {
            kind,
            retract,
            reference,
            start,
            bottom,
            dwell: dwell_of_cycle,
            at,
        }))
    }

    /// Refuses modes under which a depth is not that of the tip, or that are of another plane.
    fn check_modes(&self, arguments: &CallArguments<'_>, modes: usize) -> Result<(), ReadRemark> {
        if arguments.digit(modes, 1)? > 0.0 {
            let message = "a depth by the diameter of the hole or the shank (_GMODE)";
            return arguments.refused(message, "give the depth of the tip");
        }
        let plane = arguments.digit(modes + 1, 0)?;
        let active = f64::from(u32::try_from(self.plane).unwrap_or_default() + 1);
        if plane > 0.0 && (plane - active).abs() > 0.5 {
            let message = "a cycle in another plane than the active one (_DMODE)";
            return arguments.refused(message, "write G17, G18 or G19 before it");
        }
        Ok(())
    }
}

/// Returns the bottom of a hole \[mm\]: `DP` is a coordinate, `DPR` counts from the reference plane.
fn bottom(
    state: &mut ReaderState,
    arguments: &CallArguments<'_>,
    item: &SiemensWord<'_>,
    [reference, scale]: [f64; 2],
) -> Result<f64, ReadRemark> {
    let level = arguments.given(BOTTOM)?.map(|value| scale * value);
    let depth = arguments.given(DEPTH)?.filter(|depth| depth.abs() > 0.0);
    let relative = depth.map(|depth| reference - scale * depth.abs());
    match (level, relative) {
        (Some(level), Some(relative)) => {
            // The manual: of two that differ the relative one counts.
            if (level - relative).abs() > 1e-6 {
                let message = "DP and DPR differ: the depth is taken from DPR";
                state.log.warn(item.line, ReadRemark::new(item.at, message, ""));
            }
            Ok(relative)
        }
        (Some(bottom), None) | (None, Some(bottom)) => Ok(bottom),
        (None, None) => arguments.refused("a cycle without a depth", "write DP or DPR"),
    }
}

/// Returns the pitch of a thread \[mm\], from the places of `MPIT`, `PIT` and its unit.
fn pitch(
    arguments: &CallArguments<'_>,
    [metric, value, unit]: [usize; 3],
    scale: f64,
) -> Result<Option<f64>, ReadRemark> {
    if arguments.number(unit)? > 1.5 {
        return arguments.refused("a pitch in inches or threads per inch", "write PIT in mm");
    }
    let pitch = arguments.number(value)?;
    if pitch.abs() > 0.0 {
        return Ok(Some(scale * pitch));
    }
    let size = arguments.number(metric)?;
    if size.abs() <= 0.0 {
        return Ok(None);
    }
    let found = COARSE.iter().find(|(of, _)| (of - size.abs()).abs() < 1e-6);
    match found {
        Some((_, pitch)) => Ok(Some(size.signum() * pitch)),
        None => arguments.refused(format!("MPIT={size} is no coarse thread"), "write PIT"),
    }
}
