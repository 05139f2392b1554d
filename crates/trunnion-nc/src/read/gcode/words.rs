//! Words of a block beside its motion: counts, kept text, words that are left over.

use super::block::{BlockWord, CodeWord, GcodeBlock};
use crate::read::control::ControlState;
use crate::read::dialect::Dialect;
use crate::read::log::ReadRemark;
use crate::read::remedy::PASSIVE;
use crate::read::state::ReaderState;
/// Keeps a code with some of the words beside it.
pub(super) fn keep_with(
    state: &mut ReaderState,
    block: &mut GcodeBlock,
    text: &str,
    code: CodeWord,
    letters: &str,
) {
    let mut kept = text.get(code.at..code.end).unwrap_or_default().to_owned();
    // Words that belong to the code are kept with it, so that they are not left over.
    for letter in letters.chars() {
        if let Some(word) = block.take(letter) {
            kept.push(' ');
            kept.push_str(text.get(word.at..word.end).unwrap_or_default());
        }
    }
    state.control.keep(state.log.line, &kept);
}

/// Returns a word as a count.
pub(super) fn natural(word: BlockWord, letter: char) -> Result<u32, ReadRemark> {
    let whole = word.value.round();
    // Counts come from expressions, too: as exact as a parameter's number.
    if (whole - word.value).abs() > 1e-4 || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
        let message = format!("{letter}{} must be a whole number from 0", word.value);
        return Err(ReadRemark::new(word.at, message, ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = whole as u32;
    Ok(whole)
}

pub(super) fn not_understood(code: CodeWord, text: &str, dialect: Dialect) -> ReadRemark {
    let what = text.get(code.at..code.end).unwrap_or_default();
    let help = match (code.letter, code.tenths) {
        (b'G', 410..=429) => {
            "cutter compensation needs the whole contour; post the compensated path"
        }
        (b'G', 80 | 51 | 960) if dialect != Dialect::LinuxCnc => "of lathes",
        (b'G', 61 | 62 | 64) => "splines are the control's; post straight moves or arcs",
        (b'G', 50..=69) => "splines are not replayed; post straight moves or arcs",
        (b'G', 760 | 770 | 870 | 880) if dialect != Dialect::LinuxCnc => {
            "settings say which way the tool moves aside; use G85, G86 or G89, or write the moves"
        }
        (b'G', 330..=339 | 760) => "threading follows the spindle; read the program without it",
        (b'G', 380..=389 | 310) => "where a probe stops is not in the program",
        (b'G', 438 | 439) => {
            "the contact point depends on the cutter's corner; post the tip (G43.4)"
        }
        (b'G', 542 | 544) => "the control's measured setting errors are not in the program",
        (b'G', 121 | 71 | 1070) => {
            "coordinates on a turned face or cylinder: post axis coordinates"
        }
        (b'G', 700..=729) if dialect == Dialect::LinuxCnc => {
            "contour cycles of lathes: write the moves that the control makes of them"
        }
        (b'G', 120 | 130 | 470 | 700..=729 | 1500) => {
            "pockets, engraving and patterns: post the moves"
        }
        (b'G', 600) => "the overrun of one-sided positioning is a parameter; write G0",
        (b'G', 661) => "G66 calls behind moves alone",
        (b'G', 1410 | 1430) => "write TCP (G43.4, G234) and plain moves",
        (b'G', 160 | 510 | 511 | 680) => "polar, scaled or turned coordinates: post plain ones",
        (b'G', 650..=669) => "macro calls: write M98 at each place",
        (b'G', 70 | 80 | 960) => "of lathes",
        (b'G', 2540 | 2550) => "the control's own offsets are not in the program",
        (b'M', 1980) => "programs of other devices are not known; put their lines here (M98)",
        (b'M', 970) => "M97 is of Haas; write M98 and a program of its own",
        (b'M', _) => PASSIVE,
        _ => "is it the right dialect?",
    };
    ReadRemark::new(code.at, format!("{what} is not understood as {dialect}"), help)
}

/// Returns the fault of a word that no code of its line wants.
pub(super) fn left_over(letter: char, text: &str, at: usize, control: &ControlState) -> ReadRemark {
    match letter {
        'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' => control.no_axis(at, text),
        'P' => ReadRemark::new(
            at,
            "P word without G4 or G64 or another code that wants it",
            "leave it out",
        ),
        'Q' => ReadRemark::new(at, "Q word without G64 or a cycle", "leave it out"),
        'I' | 'J' | 'K' | 'R' => ReadRemark::new(
            at,
            format!("{text} without G2, G3 or a cycle that wants it"),
            "leave it out; an arc has I and J in the plane XY (G17), I and K in ZX (G18), J and K in YZ (G19)",
        ),
        _ => ReadRemark::new(at, format!("{text} is not understood"), "leave it out"),
    }
}
