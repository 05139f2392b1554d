//! The reader of STEP files: faces one by one, in parallel.

use super::super::error::ImportError;
use super::super::format::{looks_like, without_mark};
use super::super::part::{Part, Reader, Warning};
use super::chart::SurfaceChart;
use super::model::FaceLoss;
use super::model::Read;
use super::model::StepModel;
use super::part21::StepExchange;
use super::shape::StepShape;
use super::topology::FaceOutline;
use super::topology::FaceTopology;
use super::trim::TrimExactness;
use super::{convert, known, topology, trim};
use crate::surface::Face;
use crate::surface::FaceIndex;
use crate::surface::Surface;
use crate::types::Progress;
use crate::types::Stage;
use rayon::prelude::*;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

/// Reads STEP files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReader {
    /// Largest distance \[mm\] of a chord of a trim loop from the edge it stands for.
    pub chord: f64,
    /// Distance \[mm\] up to which two points of the file count as one: ends of neighbouring edges,
    /// a collapsed side, an edge and the surface it lies on. Files state 1e-5 to 1e-2.
    pub same: f64,
}

/// Share of [`StepReader::same`] within which a control net has to be an elementary surface all
/// over to be read as one: far below what any cut is made to, far above the digits of a file.
const KNOWN: f64 = 1e-3;

impl Reader for StepReader {
    fn format(&self) -> &'static str {
        "STEP"
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        without_mark(bytes).trim_ascii_start().starts_with(b"ISO-10303-21")
    }

    fn read(&self, bytes: &[u8], progress: &dyn Progress) -> Result<Part, ImportError> {
        let exchange = self.exchange(bytes)?;
        let (outlines, losses) = topology::outlines(&exchange);
        let mut warnings: Vec<Warning> =
            losses.iter().map(|loss| warning(&exchange, None, loss)).collect();
        let total = outlines.len() as u64;
        let done = AtomicU64::new(0);
        // Faces do not depend on each other; the order of the file is kept, whatever finishes
        // first.
        let read: Result<Vec<_>, ImportError> = outlines
            .par_iter()
            .enumerate()
            .map(|(index, outline)| {
                let face = self.face(&exchange, index + 1, outline);
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                progress.step(Stage::Import, count, total)?;
                Ok(face)
            })
            .collect();
        let mut faces = Vec::new();
        for (index, face) in read?.into_iter().enumerate() {
            let number = Some(index + 1);
            match face {
                Ok((face, notes)) => {
                    faces.push(face);
                    warnings.extend(notes.iter().map(|note| warning(&exchange, number, note)));
                }
                Err(loss) => warnings.push(warning(&exchange, number, &loss)),
            }
        }
        if faces.is_empty() {
            return Err(ImportError::NoFaces { reason: reason(&exchange, &warnings) });
        }
        Ok(Part { faces, warnings })
    }
}

impl StepReader {
    /// Parses the records of a file.
    pub(super) fn exchange(&self, bytes: &[u8]) -> Result<StepExchange, ImportError> {
        let bytes = without_mark(bytes);
        if !self.recognises(bytes) {
            return Err(ImportError::WrongFormat { expected: "STEP", found: looks_like(bytes) });
        }
        for (name, value) in [("chord", self.chord), ("same", self.same)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ImportError::Tolerance { name, value });
            }
        }
        StepExchange::parse(bytes)
    }

    fn face(
        &self,
        exchange: &StepExchange,
        number: usize,
        outline: &FaceOutline,
    ) -> Read<(Face, Vec<FaceLoss>)> {
        let (skin, shape, surface) = self.geometry(exchange, outline)?;
        let chart =
            SurfaceChart::new(&shape, &surface, index(&shape, &surface, skin.surface)?, self.same);
        let exactness = TrimExactness { chord: self.chord, same: self.same };
        let mut loops = Vec::new();
        let mut notes = Vec::new();
        for boundary in &skin.boundaries {
            let Some((trim, off, edge)) = trim::trim_loop(&chart, boundary, exactness)? else {
                continue;
            };
            if off > self.same {
                let message = format!("the edge lies up to {off:.4} mm off its surface");
                notes.push(FaceLoss { entity: edge, message });
            }
            loops.push(trim);
        }
        let face = Face::new(number, surface, loops);
        let mut face =
            face.map_err(|fault| FaceLoss { entity: outline.id, message: fault.to_string() })?;
        // Normal of the face: that of the surface if `same_sense`, turned over by a reversed shell.
        face.flip = skin.same_sense == outline.reversed;
        // A face beyond the rim of its surface would be continued, not read.
        convert::inside_domain(&face, outline.id, self.same)?;
        Ok((face, notes))
    }
}

/// Topology of a face, and its surface as stated and as it is used.
pub(super) type FaceGeometry = (FaceTopology, StepShape, Surface);

impl StepReader {
    pub(super) fn geometry(
        &self,
        exchange: &StepExchange,
        outline: &FaceOutline,
    ) -> Read<FaceGeometry> {
        let model = StepModel { exchange, scale: outline.scale, place: outline.place };
        let mut skin = model.skin(outline.id, self.same)?;
        let mut shape = model.shape(skin.surface, outline.id)?;
        let mut surface = convert::surface(&shape, skin.surface)?;
        let swept = known::swept_net(&shape, &skin.boundaries);
        let net = if let Surface::Nurbs(net) = &surface { Some(net) } else { swept.as_ref() };
        if let Some(known) = net.and_then(|net| known::known(net, KNOWN * self.same)) {
            // Loops run about the normal of the surface: they turn with it.
            if known.opposed {
                skin.turn_over();
            }
            shape = known.shape;
            surface = convert::surface(&shape, skin.surface)?;
        }
        Ok((skin, shape, surface))
    }
}

/// Prepares closest-point queries for a surface whose parameters have no closed form.
pub(super) fn index(shape: &StepShape, surface: &Surface, id: u64) -> Read<Option<FaceIndex>> {
    let StepShape::Net(_) = shape else { return Ok(None) };
    let whole = Face::new(1, surface.clone(), Vec::new()).and_then(FaceIndex::new);
    whole.map(Some).map_err(|fault| FaceLoss { entity: id, message: fault.to_string() })
}

pub(super) fn warning(exchange: &StepExchange, face: Option<usize>, loss: &FaceLoss) -> Warning {
    let entity = (loss.entity != 0).then_some(loss.entity);
    let line = entity.map(|id| exchange.line(id)).filter(|&line| line != 0);
    Warning { face, entity, line, message: loss.message.clone() }
}

/// Returns the reason for which a file gives no face.
pub(super) fn reason(exchange: &StepExchange, warnings: &[Warning]) -> String {
    match warnings {
        [] if exchange.instances.is_empty() => "its data section is empty".to_owned(),
        [] => format!("none of its {} entities is a face", exchange.instances.len()),
        [first] => first.to_string(),
        [first, rest @ ..] => format!("{first} (and {} more)", rest.len()),
    }
}
