//! A batch of moves against the tiles of a family.

use super::closest_approach::{Line, Moving};
use super::ray;
use super::ray::Swept;
use crate::verify::stock::between_rays::Close;
use crate::verify::stock::broad_phase::{Frame, Part, Stretch};
use crate::verify::stock::carve::{Collision, CollisionKind};
use crate::verify::stock::dexel::{Family, Lattice, Spans, Tile, unit};
use crate::verify::swept::bvh::Bounds;
use crate::verify::swept::quadratic::Tent;

/// Tents between the ends of a span before a body is looked at closely.
const TENTS: u32 = 6;

/// A batch against one family.
pub(crate) struct Work<'a> {
    pub(crate) frame: Frame,
    parts: &'a [Part],
    pub(crate) tolerance: f64,
    /// What dips in by less than this is not cut \[mm\].
    pub(crate) touch: f64,
    /// What must not touch material is close to it if it is no farther from a ray \[mm\].
    margin: f64,
}

/// What a batch tells of a tile.
#[derive(Debug, Default)]
pub(crate) struct Told {
    /// What runs into material on its rays.
    pub(crate) hits: Vec<Collision>,
    /// Where a body comes close to material.
    pub(crate) close: Vec<Close>,
}

/// Distances of rays within which a body is close to material: what is as thick as rays are apart, or pointed at no less
/// than some 30 degrees, has a ray so near to any of its places.
const CLOSE: f64 = 2.0;

impl<'a> Work<'a> {
    pub(crate) fn new(
        lattice: Lattice,
        family: &Family,
        parts: &'a [Part],
        tolerance: f64,
    ) -> Self {
        let frame = Frame { lattice, along: family.along, bins: family.bins };
        let margin = margin(&lattice);
        Self { frame, parts, tolerance, touch: ray::TOUCH * tolerance, margin }
    }

    /// What comes near a tile's material, in the order of the program.
    fn near(&self, tile: &Tile, near: &[u32]) -> Vec<&'a Part> {
        let parts = near.iter().filter_map(|&number| self.parts.get(number as usize));
        parts.filter(|part| self.meets(tile, part) || self.comes_close(tile, part)).collect()
    }

    fn comes_close(&self, tile: &Tile, part: &Part) -> bool {
        let whole = (tile, tile.whole(), &tile.held);
        part.harm.is_some() && self.frame.meets(whole, part, -self.margin)
    }

    fn meets(&self, tile: &Tile, part: &Part) -> bool {
        self.frame.meets((tile, tile.whole(), &tile.held), part, self.touch)
    }

    /// Cuts a tile.
    pub(crate) fn cut(&self, tile: &mut Tile, near: &[u32]) -> Told {
        let near = self.near(tile, near);
        let mut told = Told::default();
        if near.iter().any(|part| part.harm.is_some()) {
            self.in_order(tile, &near, &mut told);
        } else if !near.is_empty() {
            // What is cut in the end does not depend on the order.
            self.settle(tile, &near);
            tile.measure(self.frame.bins);
        }
        told
    }

    /// Cuts a tile by one body after the other.
    fn in_order(&self, tile: &mut Tile, near: &[&Part], told: &mut Told) {
        for part in near {
            told.close.extend(self.close(tile, part));
            if !self.meets(tile, part) {
                continue;
            }
            let mut changed = false;
            for index in 0..tile.rays.len() {
                changed |= self.ray(tile, index, part, &mut told.hits);
            }
            if changed {
                tile.measure(self.frame.bins);
            }
        }
    }

    /// A box around the material of a tile to which a body comes close that must not touch it.
    fn close(&self, tile: &Tile, part: &Part) -> Option<Close> {
        let kind = part.harm.filter(|_| self.comes_close(tile, part))?;
        let mut bounds = Bounds::empty();
        for (index, spans) in tile.rays.iter().enumerate() {
            let line = self.line(tile, index);
            for [low, high] in spans.iter().filter_map(|span| self.comes_to(part, &line, span)) {
                bounds = bounds.join(&Bounds { low: line.at(low), high: line.at(high) });
            }
        }
        let some = bounds.low.x <= bounds.high.x;
        let (bounds, line) = (bounds.grown(self.margin), part.whole.piece.line);
        let most = part.body.radius();
        some.then_some(Close {
            part: part.number,
            first: part.first,
            bounds,
            line,
            kind,
            most,
            known: 0.0,
        })
    }

    /// The part of a span that tents do not hold a body off by the margin.
    fn comes_to(&self, part: &Part, line: &Line, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let [low, high] = part.extent(self.frame.along);
        let mut span = [from.max(low), to.min(high)];
        let held = |s: f64| self.held(&part.whole.tent(part.body, &line.at(s)), s, -self.margin);
        for _ in 0..TENTS {
            if span[0] >= span[1] {
                return None;
            }
            let before = span[1] - span[0];
            if let Some([_, above]) = held(span[0]) {
                span[0] = above;
            }
            if let Some([below, _]) = held(span[1]) {
                span[1] = below;
            }
            if before - (span[1] - span[0]) < self.margin {
                break;
            }
        }
        (span[0] < span[1]).then_some(span)
    }

    /// Cuts a ray by one body over one piece; whether anything was cut.
    fn ray(&self, tile: &mut Tile, index: usize, part: &Part, hits: &mut Vec<Collision>) -> bool {
        let line = self.line(tile, index);
        let Some(spans) = tile.rays.get_mut(index) else { return false };
        let mut changed = false;
        for stretch in part.straight.iter() {
            changed |= self.cut_spans((part, stretch, 0.0), &line, spans, &mut |cut| {
                if let Some(kind) = part.harm {
                    self.hit((part, stretch, kind), &line, cut, hits);
                }
            });
        }
        changed
    }

    /// Cuts the spans of a ray by a body over a stretch; `guess`: when it is nearest. Whether anything was cut.
    pub(crate) fn cut_spans(
        &self,
        (part, stretch, guess): (&Part, &Stretch, f64),
        line: &Line,
        spans: &mut Spans,
        tell: &mut dyn FnMut([f64; 2]),
    ) -> bool {
        let mut changed = false;
        for at in (0..spans.len()).rev() {
            changed |= self.cut_span((part, stretch, guess), line, (spans, at), tell);
        }
        changed
    }

    /// Cuts one of a ray's spans; see [`Work::cut_spans`].
    pub(crate) fn cut_span(
        &self,
        (part, stretch, guess): (&Part, &Stretch, f64),
        line: &Line,
        (spans, at): (&mut Spans, usize),
        tell: &mut dyn FnMut([f64; 2]),
    ) -> bool {
        let met = |span| self.meeting(part, stretch, line, span);
        let Some(span) = spans.get(at).and_then(met) else { return false };
        let Swept { first, more } = self.moving(part, stretch).swept(line, span, guess);
        let mut changed = false;
        for cut in first.into_iter().chain(more) {
            tell(cut);
            spans.take(cut);
            changed = true;
        }
        changed
    }

    pub(crate) fn line(&self, tile: &Tile, index: usize) -> Line {
        Line { from: self.frame.ray(tile, index), way: unit(self.frame.along) }
    }

    /// The part of a span along which a body has anything, if it may meet it there. Most do not, which tents from
    /// both ends and from between where these reach tell.
    #[inline]
    pub(crate) fn meeting(
        &self,
        part: &Part,
        stretch: &Stretch,
        line: &Line,
        [from, to]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let [low, high] = part.extent(self.frame.along);
        let span = [from.max(low), to.min(high)];
        if span[0] >= span[1] {
            return None;
        }
        let held = |s: f64| self.held(&stretch.tent(part.body, &line.at(s)), s, self.touch);
        let Some([high, _]) = held(span[1]) else { return Some(span) };
        if high <= span[0] {
            return None;
        }
        let Some([_, low]) = held(span[0]) else { return Some(span) };
        let [mut low, mut high] = [low, high];
        for _ in 0..TENTS {
            if low >= high {
                return None;
            }
            match held(0.5 * (low + high)) {
                Some([from, to]) if from <= low => low = to,
                Some([from, to]) if to >= high => high = from,
                _ => break,
            }
        }
        Some(span)
    }

    /// From where to where along a ray a tent from `s` holds a body off but for `touch` \[mm\]; `None` if it does not
    /// even there.
    #[inline]
    fn held(&self, tent: &Tent, s: f64, touch: f64) -> Option<[f64; 2]> {
        let [mut low, mut high] = [f64::NEG_INFINITY, f64::INFINITY];
        for (height, gradient) in &tent.sides {
            let (height, slope) = (height + touch, gradient[self.frame.along]);
            if height <= 0.0 {
                return None;
            }
            let end = s - height / slope;
            if slope > 0.0 {
                low = low.max(end);
            } else if slope < 0.0 {
                high = high.min(end);
            }
        }
        Some([low, high])
    }

    pub(crate) fn moving<'b>(&self, part: &Part, stretch: &'b Stretch) -> Moving<'b> {
        Moving::new(stretch, part.body, self.tolerance)
    }

    /// Notes what a cut tells, if it is the deepest of its kind on its line.
    fn hit(
        &self,
        (part, stretch, kind): (&Part, &Stretch, CollisionKind),
        line: &Line,
        cut: [f64; 2],
        hits: &mut Vec<Collision>,
    ) {
        let number = stretch.piece.line;
        let same = hits.last_mut().filter(|hit| (hit.kind, hit.line) == (kind, number));
        let known = same.as_ref().map_or(self.tolerance, |hit| hit.depth);
        let Some(depth) = self.moving(part, stretch).depth(line, cut, known) else { return };
        let point = line.at(0.5 * (cut[0] + cut[1]));
        let found = Collision { kind, line: number, depth, point };
        match same {
            Some(hit) => *hit = found,
            None => hits.push(found),
        }
    }
}

/// How far from a ray is close \[mm\].
pub(crate) fn margin(lattice: &Lattice) -> f64 {
    CLOSE * lattice.cell.into_iter().fold(0.0, f64::max)
}
