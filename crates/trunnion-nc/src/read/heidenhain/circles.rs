//! Circles and polar coordinates about the pole.

use super::path_block::{PathBlock, PolarWord};
use super::reader::HeidenhainReader;
use crate::math;
use crate::read::arc::{self, ArcForm, ArcSense, GivenArc};
use crate::read::control::{DistanceMode, LARGEST};
use crate::read::log::ReadRemark;
use crate::read::state::ReaderState;
use crate::read::step::{Arc, Way};
use std::f64::consts::TAU;

impl HeidenhainReader {
    /// Returns the pole relative to the current position \[mm\].
    fn pole_from_here(&self, state: &ReaderState, at: usize) -> Result<[f64; 2], ReadRemark> {
        let from = |axis: usize| {
            // The pole is in words, as the current position is: shifts cancel.
            let pole = self.pole.get(axis).copied().flatten().ok_or_else(|| {
                ReadRemark::new(at, "a circle or polar word without its pole", "write CC before it")
            })?;
            let place = state.control.reading(state.control.xyz[axis]);
            Ok::<f64, ReadRemark>(pole - place.ok_or_else(|| arc::unknown_start(at))?)
        };
        Ok([from(self.plane[0])?, from(self.plane[1])?])
    }

    fn sense(&self, block: &PathBlock) -> Result<ArcSense, ReadRemark> {
        let written = block.sense.ok_or_else(|| {
            ReadRemark::new(block.target.at, "a circle without its sense", "write DR+ or DR-")
        })?;
        Ok(self.frame.sense(written))
    }

    /// Returns the arc of `C X Y DR+`: about the pole.
    pub(super) fn circle_about_pole(
        &self,
        state: &ReaderState,
        block: &PathBlock,
    ) -> Result<Way, ReadRemark> {
        let sense = self.sense(block)?;
        let form = ArcForm::Center(self.pole_from_here(state, block.target.at)?);
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        arc::way(
            &state.control,
            &block.target,
            &GivenArc { plane, form, sense, turns: 1, rounded: arc::ROUNDED },
        )
    }

    /// Returns the arc of `CR X Y R+20 DR+`.
    pub(super) fn circle_by_radius(
        &self,
        state: &ReaderState,
        block: &PathBlock,
    ) -> Result<Way, ReadRemark> {
        let at = block.target.at;
        let sense = self.sense(block)?;
        let radius = block.radius;
        let radius =
            radius.ok_or_else(|| ReadRemark::new(at, "CR without R", "write its radius"))?;
        let form = ArcForm::Radius(radius);
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        arc::way(
            &state.control,
            &block.target,
            &GivenArc { plane, form, sense, turns: 1, rounded: arc::ROUNDED },
        )
    }

    /// Returns the arc of `CP IPA+720 DR+ IZ-5`: about the pole, any number of turns.
    pub(super) fn polar_circle(
        &self,
        state: &ReaderState,
        block: &mut PathBlock,
    ) -> Result<Way, ReadRemark> {
        let at = block.target.at;
        let clockwise = self.sense(block)? == ArcSense::Clockwise;
        let center = self.pole_from_here(state, at)?;
        // Polar angle of the current position about the pole.
        let start = math::atan2(-center[1], -center[0]);
        let Some(PolarWord { value: angle, mode }) = block.polar[1] else {
            return Err(ReadRemark::new(at, "CP without its angle", "write PA or IPA"));
        };
        let angle = self.frame.angle(angle, mode);
        let sweep = if mode == DistanceMode::Incremental {
            angle
        } else {
            // PA is absolute: the sweep in [0, 2π), less a turn for DR-.
            let up = (angle - start).rem_euclid(TAU);
            if clockwise { up - TAU } else { up }
        };
        // The sign of IPA is the sense of rotation, which DR repeats.
        if (sweep < 0.0) != clockwise || sweep.abs() > LARGEST {
            let message = "the angle of CP runs against DR";
            return Err(ReadRemark::new(at, message, "their signs must agree"));
        }
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        let arc = Arc { plane, center, sweep };
        // The end follows from centre and sweep, as a distance from the start.
        for (slot, change) in plane.into_iter().zip(arc.at(1.0)) {
            block.target.set(slot, change, DistanceMode::Incremental);
        }
        Ok(Way::Arc(arc))
    }

    /// Sets the end of `LP PR+10 PA+30`.
    pub(super) fn polar_end(
        &self,
        state: &ReaderState,
        block: &mut PathBlock,
    ) -> Result<(), ReadRemark> {
        let at = block.target.at;
        let center = self.pole_from_here(state, at)?;
        let [from_radius, from_angle] =
            [math::hypot(center[0], center[1]), math::atan2(-center[1], -center[0])];
        let value = |given: Option<PolarWord>, from: f64| match given {
            Some(PolarWord { value, mode: DistanceMode::Incremental }) => from + value,
            Some(PolarWord { value, mode: DistanceMode::Absolute }) => value,
            None => from,
        };
        let radius = value(block.polar[0], from_radius);
        let turned = block.polar[1].map(|word| {
            let value = self.frame.angle(word.value, word.mode);
            PolarWord { value, ..word }
        });
        let angle = value(turned, from_angle);
        // Pole plus radius in the direction of the angle, relative to the current position.
        let end = [center[0] + radius * math::cos(angle), center[1] + radius * math::sin(angle)];
        let plane = self.plane.map(|axis| state.control.xyz[axis]);
        for (slot, change) in plane.into_iter().zip(end) {
            block.target.set(slot, change, DistanceMode::Incremental);
        }
        Ok(())
    }
}
