//! Values for a program's template: its starting position and its assumptions.

use super::error::WriteError;
use super::format::{OrientationWords, OutputFormat};
use super::note::comment;
use super::number::{NumberForm, list};
use super::position::WrittenPosition;
use super::program::ProgramWriter;
use super::sheet::HeadNote;
use super::template::{OffsetWords, StartWords, TemplateContext};
use crate::machine::{FIRST_ROTARY, RetractFrame};
use nalgebra::Vector3;

/// Decimals of tolerances.
const SETTING_DECIMALS: u8 = 6;

impl ProgramWriter {
    /// Returns the words of the starting position, from which the first block goes on.
    pub(super) fn first(&mut self, start: WrittenPosition<'_>) -> Result<StartWords, WriteError> {
        let words = self.rounded(start)?;
        let form = self.syntax.form;
        let text_of = |of: &[usize]| {
            let pairs = of
                .iter()
                .filter_map(|&axis| Some((self.style.axes.0.get(axis)?.letter, *words.get(axis)?)));
            let mut text = String::new();
            for (letter, value) in pairs {
                if !text.is_empty() {
                    text.push(' ');
                }
                text.push(letter);
                value.push(&mut text, form);
            }
            text
        };
        let (linear, rotaries) = self.order.split_at(3);
        let [mut tip, rotary] = [text_of(linear), text_of(rotaries)];
        let axes = tip.clone();
        let mut vector = String::new();
        // Templates may use either: rotary words, or the components of the tool vector.
        if let OrientationWords::Vector(names) = self.syntax.pointing {
            let now = self.components(start.pose)?;
            for (name, value) in names.iter().zip(now) {
                if !vector.is_empty() {
                    vector.push(' ');
                }
                vector.push_str(name);
                value.push(&mut vector, form);
            }
            if self.style.dialect == OutputFormat::Apt {
                (tip, vector) = (list(words.iter().take(3)), list(now.iter()));
            }
            self.vector = Some(now);
        }
        // The template moves to this position, so blocks omit words that equal it.
        self.last = words.map(Some);
        let above = self.above(start)?;
        Ok(StartWords { rotary, tip, axes, vector, above })
    }

    pub(super) fn context(
        &self,
        head: HeadNote<'_>,
        offset: Vector3<f64>,
        first: StartWords,
    ) -> Result<TemplateContext, WriteError> {
        let note = head.note;
        let dialect = &self.kinematics.machine().dialect;
        // Strings of the machine file are those of its own control.
        let own = OutputFormat::from_name(&dialect.name) == Some(self.style.dialect);
        let tool = note.tool.number;
        let text = |key: &str| {
            let text = dialect.strings.get(key).filter(|_| own)?;
            Some(text.replace("{h}", &tool.to_string()))
        };
        let facts = super::sheet::facts(&self.kinematics, head, self.style.axes);
        // Diameter and corner radius, as CUTTER in APT.
        let cutter = [2.0 * (note.tool.major + note.tool.minor), note.tool.minor];
        // Adding 0 takes the sign off a zero.
        let small = |value: f64| format!("{:.4}", value + 0.0);
        Ok(TemplateContext {
            name: comment(note.name),
            facts: facts.iter().map(|line| comment(line)).collect(),
            program: format!("{:04}", self.style.program),
            tool,
            spindle: (note.spindle > 0.0).then(|| format!("{:.0}", note.spindle)),
            coolant: self.style.dialect.coolant_words(note.coolant),
            cooled: self.coolant.is_on(),
            cutter: (cutter[0] > 0.0).then(|| format!("{:.4},{:.4}", cutter[0], cutter[1])),
            offset: OffsetWords { x: small(offset.x), y: small(offset.y), z: small(offset.z) },
            blend: self.style.blend.map(|blend| self.plain(blend.tip)).transpose()?,
            axis_tolerance: match self.style.blend {
                Some(blend) => self.plain(blend.axis.to_degrees())?,
                None => String::new(),
            },
            retract: self.retract()?,
            inverse_time: self.style.inverse_time,
            numbers: self.style.numbers,
            tcp_on: text("tcp_on"),
            tcp_off: text("tcp_off"),
            first,
        })
    }

    /// Writes the number of a setting.
    fn plain(&self, value: f64) -> Result<String, WriteError> {
        let mut text = String::new();
        self.fixed(value, SETTING_DECIMALS)?.push(&mut text, NumberForm::Plain);
        Ok(text)
    }

    /// Returns the word of the machine's retract, where it is an axis position.
    fn retract(&self) -> Result<Option<String>, WriteError> {
        let to = self.kinematics.machine().retract.to;
        self.retract_axis().map(|axis| self.machine_word(axis, to)).transpose()
    }

    /// Returns the words of the other linear axes at the start: the tool goes there before it comes down, since axes
    /// that run rapid moves each at its own speed would come down beside the way.
    fn above(&self, start: WrittenPosition<'_>) -> Result<Option<String>, WriteError> {
        let Some(retract) = self.retract_axis().filter(|axis| *axis < FIRST_ROTARY) else {
            return Ok(None);
        };
        let others = (0..FIRST_ROTARY).filter(|axis| *axis != retract);
        let words: Result<Vec<String>, WriteError> =
            others.map(|axis| self.machine_word(axis, start.q[axis])).collect();
        Ok(Some(words?.join(" ")))
    }

    /// Returns the axis of the machine's retract, where it goes to an axis position: only that can be written as G53 or
    /// M91.
    fn retract_axis(&self) -> Option<usize> {
        let machine = self.kinematics.machine();
        let is_position = machine.retract.frame == RetractFrame::Machine;
        machine.index_of(&machine.retract.axis).filter(|_| is_position)
    }

    /// Writes the position of an axis in machine coordinates.
    fn machine_word(&self, axis: usize, position: f64) -> Result<String, WriteError> {
        let Some(word) = self.style.axes.0.get(axis) else { return Ok(String::new()) };
        let mut text = word.letter.to_string();
        self.fixed(word.written(position), word.decimals)?.push(&mut text, self.syntax.form);
        Ok(text)
    }
}
