//! A batch of moves against the tiles of a family.

use super::carve::{Collision, CollisionKind};
use super::cut::{self, Line, Moving, Swept};
use super::near::{Frame, Part};
use super::rays::{Family, Held, Lattice, Spans, Square, Tile, unit};

/// Planes laid below the distance of a body from a span before it is looked at closely.
const PLANES: u32 = 6;

/// Rays along the side of the squares in which a tile is worked, so that what only comes near the rest of it is
/// left out.
const SIDE: usize = 4;
/// Bodies by which a square is cut before the rest is looked at again.
const DEEPEST: u32 = 2;

/// A batch against one family.
pub(super) struct Work<'a> {
    frame: Frame,
    parts: &'a [Part],
    tolerance: f64,
    /// What dips in by less than this is not cut \[mm\].
    touch: f64,
}

impl<'a> Work<'a> {
    pub(super) fn new(
        lattice: Lattice,
        family: &Family,
        parts: &'a [Part],
        tolerance: f64,
    ) -> Self {
        let frame = Frame { lattice, along: family.along, bins: family.bins };
        Self { frame, parts, tolerance, touch: cut::TOUCH * tolerance }
    }

    /// What comes near a tile's material, in the order of the program.
    fn near(&self, tile: &Tile, near: &[u32]) -> Vec<&'a Part> {
        let parts = near.iter().filter_map(|&number| self.parts.get(number as usize));
        parts.filter(|part| self.meets(tile, part)).collect()
    }

    fn meets(&self, tile: &Tile, part: &Part) -> bool {
        self.frame.meets((tile, tile.whole(), &tile.held), part, self.touch)
    }

    /// Cuts a tile.
    pub(super) fn cut(&self, tile: &mut Tile, near: &[u32]) -> Vec<Collision> {
        let mut near = self.near(tile, near);
        let mut hits = Vec::new();
        if near.iter().any(|part| part.harm.is_some()) {
            self.in_order(tile, &near, &mut hits);
            return hits;
        }
        // What is cut in the end does not depend on the order: what leaves the others little comes first.
        self.telling_first(tile, &mut near);
        let (first, rest) = near.split_at(near.len().min(2));
        self.in_order(tile, first, &mut hits);
        near = rest.iter().copied().filter(|part| self.meets(tile, part)).collect();
        if !near.is_empty() {
            for square in tile.squares(SIDE) {
                self.square(tile, square, &near);
            }
            tile.measure(self.frame.bins);
        }
        hits
    }

    /// Cuts a tile by one body after the other.
    fn in_order(&self, tile: &mut Tile, near: &[&Part], hits: &mut Vec<Collision>) {
        for part in near {
            if !self.meets(tile, part) {
                continue;
            }
            let mut changed = false;
            for index in 0..tile.rays.len() {
                changed |= self.ray(tile, index, part, hits);
            }
            if changed {
                tile.measure(self.frame.bins);
            }
        }
    }

    /// Cuts a square: first by what gets deepest into its middle ray, after that one ray after the other by what
    /// is left, deepest first.
    fn square(&self, tile: &mut Tile, square: Square, near: &[&Part]) {
        let mut held = self.held(tile, square);
        let mut near: Vec<&Part> = near.to_vec();
        for _ in 0..DEEPEST {
            near.retain(|part| self.frame.meets((tile, square, &held), part, self.touch));
            let Some(deepest) = self.deepest(tile, square, &near) else { return };
            let part = near.swap_remove(deepest);
            for index in square.rays() {
                self.ray(tile, index, part, &mut Vec::new());
            }
            held = self.held(tile, square);
        }
        near.retain(|part| self.frame.meets((tile, square, &held), part, self.touch));
        for index in square.rays() {
            for part in &near {
                self.ray(tile, index, part, &mut Vec::new());
            }
        }
    }

    fn held(&self, tile: &Tile, square: Square) -> Held {
        let mut held = Held::NONE;
        for spans in square.rays().filter_map(|index| tile.rays.get(index)) {
            held.add(spans, self.frame.bins);
        }
        held
    }

    /// Which of the bodies is deepest in an end of the middle ray of a square.
    fn deepest(&self, tile: &Tile, square: Square, near: &[&Part]) -> Option<usize> {
        let middle = square.middle();
        let line = self.line(tile, middle);
        let spans = tile.rays.get(middle);
        let ends = || spans.into_iter().flat_map(Spans::iter).flatten();
        let distance = |part: &Part| {
            let distances = ends().map(|end| part.support(&line.at(end)).0);
            distances.fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = near.iter().map(|part| distance(part)).collect();
        (0..near.len()).min_by(|&a, &b| {
            let at = |index: usize| distances.get(index).copied().unwrap_or(f64::INFINITY);
            at(a).total_cmp(&at(b))
        })
    }

    /// Cuts a ray by one body over one piece; whether anything was cut.
    fn ray(&self, tile: &mut Tile, index: usize, part: &Part, hits: &mut Vec<Collision>) -> bool {
        let line = self.line(tile, index);
        let Some(spans) = tile.rays.get_mut(index) else { return false };
        let mut changed = false;
        for at in (0..spans.len()).rev() {
            let Some(span) = spans.get(at).and_then(|span| self.meeting(part, &line, span)) else {
                continue;
            };
            let Swept { first, more } = self.moving(part).swept(&line, span);
            for cut in first.into_iter().chain(more) {
                if let Some(kind) = part.harm {
                    self.hit((part, kind), &line, cut, hits);
                }
                spans.take(cut);
                changed = true;
            }
        }
        changed
    }

    /// Puts first what gets nearest to the lower end of the middle ray, and to the upper; then the others,
    /// those in the middle of the program before those beside them.
    fn telling_first(&self, tile: &Tile, near: &mut Vec<&'a Part>) {
        if near.len() < 3 {
            return;
        }
        let middle = tile.rays.len() / 2;
        let Some(range) = tile.rays.get(middle).and_then(Spans::range) else { return };
        let line = self.line(tile, middle);
        let mut order: Vec<usize> = Vec::with_capacity(near.len() + 2);
        for s in range {
            let point = line.at(s);
            let distance = |at: &usize| near.get(*at).map_or(0.0, |part| part.support(&point).0);
            let least = (0..near.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            order.extend(least);
        }
        let bits = usize::BITS - near.len().leading_zeros();
        let halving = (0..1usize << bits).map(|at| at.reverse_bits() >> (usize::BITS - bits));
        order.extend(halving);
        let mut left: Vec<Option<&Part>> = near.iter().copied().map(Some).collect();
        near.clear();
        near.extend(order.into_iter().filter_map(|at| left.get_mut(at).and_then(Option::take)));
    }

    fn line(&self, tile: &Tile, index: usize) -> Line {
        Line { from: self.frame.ray(tile, index), way: unit(self.frame.along) }
    }

    /// Looks for what runs into a fixture.
    pub(super) fn look(&self, tile: &Tile, near: &[u32]) -> Vec<Collision> {
        let mut hits = Vec::new();
        for part in self.near(tile, near) {
            for (index, spans) in tile.rays.iter().enumerate() {
                let line = self.line(tile, index);
                for span in spans.iter().filter_map(|span| self.meeting(part, &line, span)) {
                    let Swept { first, more } = self.moving(part).swept(&line, span);
                    for cut in first.into_iter().chain(more) {
                        self.hit((part, CollisionKind::Fixture), &line, cut, &mut hits);
                    }
                }
            }
        }
        hits
    }

    /// The part of a span along which a body has anything, if it may meet it there. Most do not, which planes
    /// below the distance from both ends and from where these planes meet tell.
    #[inline]
    fn meeting(&self, part: &Part, line: &Line, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
        let along = self.frame.along;
        let [low, high] = part.extent(along);
        let span = [from.max(low), to.min(high)];
        if span[0] >= span[1] {
            return None;
        }
        // Place, height there, and slope.
        let plane = |s: f64| {
            let (height, gradient) = part.support(&line.at(s));
            (s, height + self.touch, gradient[along])
        };
        let mut upper = plane(span[1]);
        if upper.2 <= -part.shear {
            return (upper.1 <= 0.0).then_some(span);
        }
        let mut lower = plane(span[0]);
        if lower.2 >= part.shear {
            return (lower.1 <= 0.0).then_some(span);
        }
        for _ in 0..PLANES {
            if lower.1 <= 0.0 || upper.1 <= 0.0 {
                break;
            }
            // How fast they fall towards each other.
            let [rise, fall] = [part.shear - lower.2, part.shear + upper.2].map(|by| by.max(0.0));
            let width = upper.0 - lower.0;
            let at = (width * fall + lower.1 - upper.1) / (rise + fall);
            let height = lower.1 - rise * at.clamp(0.0, width);
            if height > 0.0 || rise + fall <= 0.0 {
                return None;
            }
            let next = plane(lower.0 + at.clamp(0.0, width));
            *(if next.2 > 0.0 { &mut upper } else { &mut lower }) = next;
        }
        Some(span)
    }

    fn moving<'b>(&self, part: &'b Part) -> Moving<'b> {
        Moving::new(&part.piece, part.body, self.tolerance)
    }

    /// Notes what a cut tells, if it is the deepest of its kind on its line.
    fn hit(
        &self,
        (part, kind): (&Part, CollisionKind),
        line: &Line,
        cut: [f64; 2],
        hits: &mut Vec<Collision>,
    ) {
        let number = part.piece.line;
        let same = hits.last_mut().filter(|hit| (hit.kind, hit.line) == (kind, number));
        let known = same.as_ref().map_or(self.tolerance, |hit| hit.depth);
        let Some(depth) = self.moving(part).depth(line, cut, known) else { return };
        let point = line.at(0.5 * (cut[0] + cut[1]));
        let found = Collision { kind, line: number, depth, point };
        match same {
            Some(hit) => *hit = found,
            None => hits.push(found),
        }
    }
}
