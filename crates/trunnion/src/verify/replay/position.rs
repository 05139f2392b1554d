//! Position of the machine, as far as the program states it.

use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math;
use crate::nc::control::{
    ControlKinematics, RotaryRequest, TipFrame, WordFrame, end_words, keeps_xy, read_words,
    tip_target,
};
use crate::nc::read::Move;
use crate::types::{AXES, AxisVector};
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::orient::Turned;

/// Position of the machine.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Known {
    /// All axes.
    Axes(AxisVector),
    /// After a tool change, the words stated since.
    Part(PartlyKnown),
}

/// Some of the axes, or what the tip reads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartlyKnown {
    axes: [Option<f64>; AXES],
    /// X, Y and Z of the tip \[mm\], and in what they count.
    tip: [Option<f64>; 3],
    frame: Option<TipFrame>,
}

impl Known {
    /// After a tool change: the rotaries stand as before, and X and Y where the tool is along Z.
    pub(crate) fn changed(&self, control: &Control) -> Self {
        let mut axes: [Option<f64>; AXES] = match self {
            Self::Axes(q) => (*q).map(Some).into(),
            Self::Part(part) => part.axes,
        };
        axes[2] = None;
        if !at_height(&axes, 0.0).is_some_and(|q| keeps_xy(control, &q)) {
            [axes[0], axes[1]] = [None; 2];
        }
        Self::Part(PartlyKnown { axes, tip: [None; 3], frame: None })
    }
}

impl PartlyKnown {
    /// Returns the position behind a straight block.
    pub(crate) fn after(
        &self,
        control: &Control,
        step: &Move,
        frame: &WordFrame,
    ) -> Result<(Known, Option<Turned>), VerifyError> {
        let turned = self.turned(control, step, frame)?;
        let known = match frame {
            WordFrame::Axes(shift) => {
                let mut part = Self { tip: [None; 3], ..*self };
                put(&mut part.axes, step, |slot| shift[slot]);
                part.turn(turned.as_ref());
                all(&part.axes).map_or(Known::Part(part), Known::Axes)
            }
            WordFrame::Tip(frame) => self.after_tip(control, step, frame, turned.as_ref())?,
        };
        Ok((known, turned))
    }

    /// With tool-centre-point control the slides follow the tip.
    fn after_tip(
        &self,
        control: &Control,
        step: &Move,
        frame: &TipFrame,
        turned: Option<&Turned>,
    ) -> Result<Known, VerifyError> {
        // Tip coordinates of another frame have no meaning in this one.
        let stood =
            if self.frame == Some(*frame) { self.tip } else { self.kept_tip(control, frame) };
        let ([x, y, z], [.., first, second]) = (stood, self.axes);
        let mut words = [x, y, z, first, second];
        put(&mut words, step, |_| 0.0);
        let [x, y, z, first, second] = words;
        let axes = [None, None, None, first, second];
        let mut part = Self { axes, tip: [x, y, z], frame: Some(*frame) };
        part.turn(turned);
        // The axes are known again once all of the tip and both rotaries are.
        let ([Some(x), Some(y), Some(z)], [.., Some(first), Some(second)]) = (part.tip, part.axes)
        else {
            return Ok(Known::Part(part));
        };
        let mut q = AxisVector::new(x, y, z, first, second);
        let linear = control.linear_axes(&tip_target(frame, &q), &q, step.line)?;
        q.fixed_rows_mut::<3>(0).copy_from(&linear);
        Ok(Known::Axes(q))
    }

    /// X and Y of the tip as far as the axes state them, while the height does not matter.
    fn kept_tip(&self, control: &Control, frame: &TipFrame) -> [Option<f64>; 3] {
        let turned =
            frame.table_from_words.is_some_and(|frame| math::angle_of(&frame.rotation) > 0.0);
        let known = at_height(&self.axes, 0.0).filter(|q| !turned && keeps_xy(control, q));
        let Some(q) = known else { return [None; 3] };
        let words = read_words(control, &q, &WordFrame::Tip(*frame));
        [Some(words[0]), Some(words[1]), None]
    }

    /// The rotaries that turn the tool along a vector.
    fn turned(
        &self,
        control: &Control,
        step: &Move,
        frame: &WordFrame,
    ) -> Result<Option<Turned>, VerifyError> {
        let Some(direction) = step.axis else { return Ok(None) };
        let mut near = control.real().machine().home();
        for slot in [FIRST_ROTARY, SECOND_ROTARY] {
            near[slot] = self.axes[slot].unwrap_or(near[slot]);
        }
        // X, Y and Z that are not stated yet are taken to stand at home.
        let tip = match frame {
            WordFrame::Axes(_) => None,
            WordFrame::Tip(tip) => {
                let words = read_words(control, &near, frame);
                Some(tip_target(tip, &end_words(words, step, &AxisVector::zeros())))
            }
        };
        let request = RotaryRequest { tip, ..RotaryRequest::new(step.line, direction, &near) };
        control.rotaries(&request).map(Some)
    }

    fn turn(&mut self, turned: Option<&Turned>) {
        if let Some(Turned { rotaries: [first, second], .. }) = turned {
            (self.axes[FIRST_ROTARY], self.axes[SECOND_ROTARY]) = (Some(*first), Some(*second));
        }
    }
}

/// Puts a block's words in; `shift` is what words are short of them.
fn put(values: &mut [Option<f64>; AXES], step: &Move, shift: impl Fn(usize) -> f64) {
    for (slot, (value, word)) in values.iter_mut().zip(step.words).enumerate() {
        *value = match word {
            Some(word) if step.incremental => value.map(|value| value + word),
            Some(word) => Some(word + shift(slot)),
            None => *value,
        };
    }
}

/// The axes with Z at a height \[mm\], if all others are known.
fn at_height(axes: &[Option<f64>; AXES], height: f64) -> Option<AxisVector> {
    let mut axes = *axes;
    axes[2] = Some(height);
    all(&axes)
}

/// All axes, if all are known.
fn all(axes: &[Option<f64>; AXES]) -> Option<AxisVector> {
    let known: Vec<f64> = axes.iter().copied().flatten().collect();
    (known.len() == AXES).then(|| AxisVector::from_column_slice(&known))
}
