//! From passes to a whole program of motions: leads and links.

use super::CoverError;
use super::chart::Chart;
use super::clear::Clearing;
use super::hop::{Hop, Hops};
use super::options::Along;
use super::sheet::Sheet;
use super::solid::Tool;
use super::sweep::Sweep;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::{Leg, Motion, Pass, PoseCurve, Progress, Stage, Station, ToolPose};
use nalgebra::{Unit, UnitVector3, Vector3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// How the tool comes down to a pass and leaves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeadKind {
    /// Straight along the tool axis.
    Axis,
    /// First along the pass, carried on straight by `length` \[mm\], then along the tool axis.
    Tangent {
        /// How far the pass is carried on \[mm\].
        length: f64,
    },
}

/// How passes are joined. No `Default`: the caller knows part, stock and tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkOptions {
    /// Way out of the part: square to the plane of the links.
    pub up: UnitVector3<f64>,
    /// Height along `up` of the plane that no part of the cutting end goes below during a link \[mm\]:
    /// the highest point of part and stock plus the clearance.
    pub plane: f64,
    /// Kind of lead.
    pub lead: LeadKind,
    /// Last stretch of a lead that is run at the cutting feed \[mm\]; what lies above counts as a link.
    /// Longer than the lead: all of it.
    pub approach: f64,
    /// Depth to which the cutter may go into a face during a lead \[mm\]: the gouge tolerance.
    pub gouge: f64,
}

/// A lead climbs at least this much per mm of its length: a flatter one would run over the part
/// for more than ten times the height it has to gain.
const LEAST_CLIMB: f64 = 0.1;

/// Share of the gouge tolerance that a lead may use up without it being told from none.
const PRECISION: f64 = 0.1;

/// Joins passes: down to the first, along it, over to the next, and up from the last. Passes are run in
/// the order and direction given.
///
/// From pass to pass the tool hops, where [`Hops`] say how and that is quicker; otherwise it goes up by a lead,
/// over at a height where it may turn, and down again. Each hop and each lead is proven to keep off all
/// `faces`, with the whole tool up to the gauge point; where the way of a lead along the tool axis is barred, one
/// leaning towards `up` is taken.
///
/// # Errors
///
/// [`CoverError::LeadGouges`] where every way gouges or does not lead up; [`CoverError::Cancelled`].
pub fn legs(
    passes: &[Pass],
    faces: &[FaceIndex],
    cutter: &Cutter,
    (options, hops): (&LinkOptions, Option<&Hops<'_>>),
    progress: &dyn Progress,
) -> Result<Vec<Leg>, CoverError> {
    let (tool, lever) = (Tool::new(cutter), super::lever(cutter));
    let chart = Chart::straight(Along::V);
    let sheets = faces.iter().map(|face| sheet(face, &chart, cutter)).collect();
    let leads = Leads { faces, sheets, chart, tool, lever, cutter, options };
    let done = AtomicU64::new(0);
    let total = passes.len() as u64;
    let ways: Vec<Vec<Leg>> = (0..=passes.len())
        .into_par_iter()
        .map(|next| {
            progress.step(Stage::Cover, done.fetch_add(1, Ordering::Relaxed), total)?;
            let before = next.checked_sub(1).and_then(|before| Some((before, passes.get(before)?)));
            leads.between(before, passes.get(next).map(|pass| (next, pass)), hops)
        })
        .collect::<Result<_, CoverError>>()?;
    let mut legs: Vec<Leg> = Vec::new();
    let cuts =
        passes.iter().map(|pass| Leg { motion: Motion::Cut, stations: pass.stations.clone() });
    let mut cuts = cuts.fuse();
    for way in ways {
        legs.extend(way);
        legs.extend(cuts.next());
    }
    Ok(legs)
}

/// Splits a way up where its last straight part, the climb, is `approach` long: what lies above, if
/// anything does, and what lies below.
fn split(mut up: Vec<Station>, approach: f64) -> (Option<Vec<Station>>, Vec<Station>) {
    let Some(&[foot, top]) = up.last_chunk::<2>() else { return (None, up) };
    let climb = top.pose.tip - foot.pose.tip;
    if climb.norm() <= approach {
        return (None, up);
    }
    let near = moved(&foot, &climb.scale(approach / climb.norm()));
    up.pop();
    up.push(near);
    (Some(vec![near, top]), up)
}

fn reversed(mut stations: Vec<Station>) -> Vec<Station> {
    stations.reverse();
    stations
}

struct Leads<'a> {
    faces: &'a [FaceIndex],
    sheets: Vec<Sheet>,
    chart: Chart,
    tool: Tool,
    lever: f64,
    cutter: &'a Cutter,
    options: &'a LinkOptions,
}

/// A pass with its index.
type Numbered<'a> = (usize, &'a Pass);

impl Leads<'_> {
    /// The way from one pass to the next; without one of them, from or to the height of the links.
    fn between(
        &self,
        before: Option<Numbered<'_>>,
        next: Option<Numbered<'_>>,
        hops: Option<&Hops<'_>>,
    ) -> Result<Vec<Leg>, CoverError> {
        if let (Some((_, before)), Some((_, next)), Some(hops)) = (before, next, hops)
            && let (Some(from), Some(to)) = (before.stations.last(), next.stations.first())
        {
            let over = [self.least(from), self.least(to)].map(|way| way.map(|s| s.pose));
            let hop = Hop { from, to, over, lever: self.lever };
            let margin = PRECISION * self.options.gouge;
            let free = |sweep: &Sweep, span, least: f64| {
                self.depth_in(sweep, span, least + margin) <= -least
            };
            if let Some(stations) = hop.find(hops, free, self.options.gouge) {
                return Ok(vec![Leg { motion: Motion::Hop, stations }]);
            }
        }
        let away = |(number, pass): Numbered<'_>, inwards: &mut dyn Iterator<Item = Station>| {
            let gouges = |depth| CoverError::LeadGouges { pass: number, face: pass.face, depth };
            self.away(inwards).map_err(gouges)
        };
        let out =
            before.map(|of| away(of, &mut of.1.stations.iter().rev().copied())).transpose()?;
        let down = next.map(|of| away(of, &mut of.1.stations.iter().copied())).transpose()?;
        let tops = [&out, &down].map(|way| way.as_ref().and_then(|way| way.last().copied()));
        let mut legs = Vec::new();
        if let Some(out) = out {
            let (high, low) = split(out, self.options.approach);
            legs.push(Leg { motion: Motion::LeadOut, stations: low });
            legs.extend(high.map(|stations| Leg { motion: Motion::Link, stations }));
        }
        if let [Some(from), Some(to)] = tops {
            legs.push(Leg { motion: Motion::Link, stations: vec![from, to] });
        }
        if let Some(down) = down {
            let (high, low) = split(down, self.options.approach);
            let link = high.map(|high| Leg { motion: Motion::Link, stations: reversed(high) });
            legs.extend(link);
            legs.push(Leg { motion: Motion::LeadIn, stations: reversed(low) });
        }
        Ok(legs)
    }

    /// The shortest way up there may be.
    fn least(&self, end: &Station) -> Option<Station> {
        let (direction, length) = self.ups(end).next()?;
        Some(moved(end, &direction.scale(length)))
    }

    /// Stations from the first of `inwards` (a pass seen from one end) up to the link height; the
    /// greatest depth of a gouge where there is no way.
    fn away(&self, inwards: &mut dyn Iterator<Item = Station>) -> Result<Vec<Station>, f64> {
        let (Some(end), Some(before)) = (inwards.next(), inwards.next()) else {
            return Ok(Vec::new());
        };
        let mut ways = Vec::new();
        if let LeadKind::Tangent { length } = self.options.lead
            && let Some(tangent) = Unit::try_new(end.pose.tip - before.pose.tip, 0.0)
        {
            ways.extend(self.ups(&end).map(|up| vec![(tangent, length), up]));
        }
        ways.extend(self.ups(&end).map(|up| vec![up]));
        let mut deepest = 0.0;
        for way in ways {
            match self.follow(end, &way) {
                Ok(stations) => return Ok(stations),
                Err(depth) => deepest = f64::max(deepest, depth),
            }
        }
        Err(deepest)
    }

    /// Directions up to the link height with the way to go: the tool axis, and more and more of straight up.
    fn ups(&self, end: &Station) -> impl Iterator<Item = (UnitVector3<f64>, f64)> {
        let axis = end.pose.axis.into_inner();
        let radius = self.cutter.radius();
        // With its tip a radius above the plane, the cutting end is above it however it is turned.
        let up = self.options.up;
        let height = self.options.plane + radius - end.pose.tip.coords.dot(&up);
        [0.0, 0.5, 1.0].into_iter().filter_map(move |share| {
            let direction = Unit::try_new(axis.lerp(&up, share), 0.0)?;
            let climb = direction.dot(&up);
            (climb >= LEAST_CLIMB).then(|| (direction, (height / climb).max(radius)))
        })
    }

    /// Stations at the corners of a way, or how deep it gouges.
    fn follow(&self, from: Station, way: &[(UnitVector3<f64>, f64)]) -> Result<Vec<Station>, f64> {
        let mut stations = vec![from];
        let mut here = from;
        for (direction, length) in way {
            let depth = self.depth(&here.pose, direction, *length);
            if depth > self.options.gouge {
                return Err(depth);
            }
            here = moved(&here, &(direction.scale(*length)));
            stations.push(here);
        }
        Ok(stations)
    }

    /// How deep the tool goes into a face on a straight way; at least so deep, where that is more than the
    /// gouge tolerance.
    fn depth(&self, from: &ToolPose, direction: &UnitVector3<f64>, length: f64) -> f64 {
        let start = Station { pose: *from, contact: from.tip };
        let end = moved(&start, &direction.scale(length));
        let sweep = Sweep::of(PoseCurve::through(&[start, end], self.lever), self.lever);
        let precision = PRECISION * self.options.gouge;
        self.depth_in(&sweep, 0, precision - self.options.gouge)
    }

    /// How deep the tool goes into a face during a span; at least so deep, where it does not keep `target`.
    fn depth_in(&self, sweep: &Sweep, span: usize, target: f64) -> f64 {
        let precision = PRECISION * self.options.gouge;
        let of = |(face, sheet): (&FaceIndex, &Sheet)| {
            let tool = &self.tool;
            let chart = &self.chart;
            let clearing = Clearing { face, chart, sheet, tool, target, precision };
            -clearing.least(sweep, span, 1)
        };
        self.faces.iter().zip(&self.sheets).map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A face as cells for looking at leads.
fn sheet(face: &FaceIndex, chart: &Chart, cutter: &Cutter) -> Sheet {
    let region = super::face::region(face, chart);
    Sheet::new(face, chart, &region, super::site::SHEET_SHARE * cutter.radius())
}

fn moved(station: &Station, by: &Vector3<f64>) -> Station {
    let pose = ToolPose { tip: station.pose.tip + by, axis: station.pose.axis };
    Station { pose, contact: station.contact + by }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn only_the_last_stretch_of_a_climb_is_run_at_the_feed() {
        let axis = Unit::new_normalize(Vector3::new(0.0, 0.6, 0.8));
        let at = |z: f64| {
            let tip = Point3::from(axis.scale(z));
            Station { pose: ToolPose { tip, axis }, contact: tip }
        };
        let (high, low) = split(vec![at(0.0), at(50.0)], 8.0);
        let (high, tip) = (high.unwrap(), |station: &Station| station.pose.tip.coords.norm());
        assert!((tip(&low[1]) - 8.0).abs() < 1e-12 && low.len() == 2);
        assert!((high[0].pose.tip - low[1].pose.tip).norm() < 1e-15);
        assert!((tip(&high[1]) - 50.0).abs() < 1e-12);
        assert!(split(vec![at(0.0), at(5.0)], 8.0).0.is_none());
    }
}
