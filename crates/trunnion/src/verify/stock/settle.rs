//! A tile that nothing harmful comes near: what decides which rays.
//!
//! From a ray on which everything is tried, what decides it is followed over the tile: its surface on the next
//! ray is where its tangent plane lets expect it, and where one stretch of the motion ends the next goes on.
//! Everything else is held off by planes below its distance, for squares of rays and for single rays; what they
//! do not hold off is tried as on any ray.

use super::follow::{Expected, Trace};
use super::near::{Part, Stretch};
use super::nearest::{Guess, Line, Nearest};
use super::rays::{Spans, Square, Tile};
use super::work::Work;
use nalgebra::{Point3, Vector3};

/// Planes laid below the distance of a body from a span for one that tells where it is nearest.
const PLANES: u32 = 12;
/// Rays along the side of a square.
const SIDE: usize = 8;

/// A body by its number, and a plane below its distance.
#[derive(Clone, Copy)]
struct Plane {
    part: usize,
    at: Point3<f64>,
    height: f64,
    gradient: Vector3<f64>,
    shear: f64,
}

impl Plane {
    /// Least height over a box.
    #[inline]
    fn over(&self, low: &Point3<f64>, high: &Point3<f64>) -> f64 {
        let [low, high] = [low - self.at, high - self.at];
        let side = |k: usize| (self.gradient[k] * low[k]).min(self.gradient[k] * high[k]);
        let far = (-low).sup(&high);
        self.height + side(0) + side(1) + side(2) - self.shear * (far.x + far.y + far.z)
    }

    /// Least height over a span of a line.
    #[inline]
    fn along(&self, line: &Line, [low, high]: [f64; 2]) -> f64 {
        let at = |s: f64| {
            let by = line.at(s) - self.at;
            self.height + self.gradient.dot(&by)
                - self.shear * (by.x.abs() + by.y.abs() + by.z.abs())
        };
        at(low).min(at(high))
    }
}

/// All stretches of some bodies, one after the other: stretch `k` lasts from `2 k - 1` to `2 k + 1`.
struct Chain<'a> {
    parts: &'a [&'a Part],
    /// By body: the number of its first stretch.
    first: Vec<usize>,
    stretches: Vec<(&'a Part, &'a Stretch)>,
}

impl<'a> Chain<'a> {
    fn new(parts: &'a [&'a Part]) -> Self {
        let mut first = Vec::with_capacity(parts.len());
        let mut stretches = Vec::with_capacity(2 * parts.len());
        for part in parts {
            first.push(stretches.len());
            stretches.extend(part.straight.iter().map(|stretch| (*part, stretch)));
        }
        Self { parts, first, stretches }
    }

    /// The numbers of a body's stretches.
    fn of(&self, part: usize) -> std::ops::Range<usize> {
        let first = self.first.get(part).copied().unwrap_or(0);
        first..self.first.get(part + 1).copied().unwrap_or(self.stretches.len())
    }
}

/// Where a ray ends, by which stretch and when.
#[derive(Clone, Copy)]
struct End {
    number: usize,
    time: f64,
    s: f64,
}

impl End {
    /// Its time as a stretch has it, or the end of that stretch next to it.
    fn seen_from(&self, number: usize) -> f64 {
        (self.time - 2.0 * number as f64).clamp(-1.0, 1.0)
    }
}

/// Where a ray was followed to, by the number of what followed it.
type Ends = [Option<End>; 2];

/// What is followed from ray to ray.
struct Follower {
    trace: Trace,
    /// The ray of the trace, and when it is decided.
    ray: [usize; 2],
    time: f64,
    /// By both directions across: how far the surface was off the tangent plane, and how much later it was
    /// reached, one ray on.
    off: [f64; 2],
    later: [f64; 2],
}

impl Work<'_> {
    /// Cuts a tile by bodies in any order.
    pub(super) fn settle(&self, tile: &mut Tile, parts: &[&Part]) {
        let chain = Chain::new(parts);
        let all: Vec<usize> = (0..parts.len()).collect();
        let mut ends: Vec<Ends> = vec![[None; 2]; tile.rays.len()];
        let mut planes = Vec::new();
        for ray in tile.places() {
            let (below, followers) = self.decide(tile, ray, &chain, &all);
            if !below.is_empty() {
                planes = below;
            }
            if !followers.is_empty() {
                let whole = tile.whole();
                for (which, follower) in followers.into_iter().enumerate() {
                    self.walk(tile, whole, (&chain, follower), (which, &mut ends));
                }
                break;
            }
        }
        for square in tile.squares(SIDE) {
            self.square(tile, square, (&chain, &planes), &mut ends);
        }
    }

    /// Cuts a square by what the planes of the tile do not hold off.
    fn square(
        &self,
        tile: &mut Tile,
        square: Square,
        (chain, planes): (&Chain<'_>, &[Plane]),
        ends: &mut [Ends],
    ) {
        let boxes = self.boxes(tile, square);
        let off = |planes: &[Plane], [low, high]: &[Point3<f64>; 2]| {
            planes.iter().any(|plane| plane.over(low, high) > -self.touch)
        };
        let by_part = || planes.chunk_by(|a, b| a.part == b.part);
        let close = by_part().filter(|planes| !boxes.iter().all(|corners| off(planes, corners)));
        let close: Vec<usize> = close.filter_map(|planes| Some(planes.first()?.part)).collect();
        let holds = |ray: &usize| tile.rays.get(*ray).is_some_and(|spans| spans.len() > 0);
        let middle = Some(square.middle()).filter(holds).or_else(|| square.rays().find(holds));
        let Some(middle) = middle.filter(|_| !close.is_empty()) else { return };
        let (mut near, followers) = self.decide(tile, middle, chain, &close);
        if near.is_empty() {
            near = planes.iter().filter(|plane| close.contains(&plane.part)).copied().collect();
        }
        for (which, follower) in followers.into_iter().enumerate() {
            self.walk(tile, square, (chain, follower), (which, ends));
        }
        let near = halving(near.chunk_by(|a, b| a.part == b.part).collect());
        for index in square.rays() {
            let line = self.line(tile, index);
            let Some(spans) = tile.rays.get_mut(index) else { continue };
            let ends = ends.get(index).copied().unwrap_or_default();
            for planes in &near {
                self.try_on(chain, planes, ends, (&line, spans));
            }
        }
    }

    /// Boxes that hold all material of a square: first spans of all rays, second ones, and so on.
    fn boxes(&self, tile: &Tile, square: Square) -> Vec<[Point3<f64>; 2]> {
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        for spans in square.rays().filter_map(|ray| tile.rays.get(ray)) {
            for (number, span) in spans.iter().enumerate() {
                match ranges.get_mut(number) {
                    Some(range) => *range = [range[0].min(span[0]), range[1].max(span[1])],
                    None => ranges.push(span),
                }
            }
        }
        ranges.into_iter().map(|range| self.frame.corners(tile, square, range)).collect()
    }

    /// Cuts a ray by bodies, deepest first. Returns planes below the distance of all of them from where it ends
    /// then, and what decided its ends; planes of a ray that is gone are those before the last cut.
    fn decide(
        &self,
        tile: &mut Tile,
        ray: usize,
        chain: &Chain<'_>,
        parts: &[usize],
    ) -> (Vec<Plane>, Vec<Follower>) {
        let (line, place) = (self.line(tile, ray), tile.place(ray));
        let mut planes: Vec<Plane> = Vec::new();
        let mut cuts: Vec<(usize, [f64; 2])> = Vec::new();
        let mut open = parts.to_vec();
        let Some(spans) = tile.rays.get_mut(ray) else { return (planes, Vec::new()) };
        loop {
            if spans.len() > 0 {
                planes.clear();
                for &part in parts {
                    let Some(body) = chain.parts.get(part) else { continue };
                    planes.extend(spans.iter().map(|span| self.plane((part, body), &line, span)));
                }
            }
            let still = planes.iter().filter(|plane| open.contains(&plane.part));
            let deepest = still.min_by(|a, b| a.height.total_cmp(&b.height));
            let deepest = deepest.filter(|plane| plane.height <= -self.touch && spans.len() > 0);
            let Some(&Plane { part, .. }) = deepest else { break };
            open.retain(|other| *other != part);
            for number in chain.of(part) {
                let Some(&(part, stretch)) = chain.stretches.get(number) else { continue };
                self.cut_spans((part, stretch, 0.0), &line, spans, &mut |cut| {
                    cuts.push((number, cut));
                });
            }
        }
        let last = |end: f64| {
            let made =
                |(_, cut): &&(usize, [f64; 2])| cut.iter().any(|s| s.total_cmp(&end).is_eq());
            cuts.iter().rev().find(made).map(|(number, _)| (*number, end))
        };
        let ends: Vec<(usize, f64)> = spans.iter().flatten().filter_map(last).collect();
        let follower = |(number, s): (usize, f64)| {
            let &(part, stretch) = chain.stretches.get(number)?;
            let near = self.moving(part, stretch).nearest(&line, s, Guess::at(0.0));
            let (trace, time) = (Trace::new(&line, s, &near), 2.0 * number as f64 + near.u);
            Some(Follower { trace, ray: place, time, off: [0.0; 2], later: [0.0; 2] })
        };
        (planes, ends.into_iter().filter_map(follower).collect())
    }

    /// The plane below a body's distance from a span that tells most: from where the body is nearest to it.
    fn plane(&self, (number, part): (usize, &Part), line: &Line, [low, high]: [f64; 2]) -> Plane {
        let (along, shear) = (self.frame.along, part.whole.shear);
        let plane = |s: f64| {
            let at = line.at(s);
            let (height, gradient) = part.whole.support(part.body, &at);
            Plane { part: number, at, height, gradient, shear }
        };
        let mut upper = plane(high);
        // Farther down it only gets farther, then.
        if upper.gradient[along] <= -shear || upper.height <= -self.touch {
            return upper;
        }
        let mut lower = plane(low);
        if lower.gradient[along] >= shear || lower.height <= -self.touch {
            return lower;
        }
        for _ in 0..PLANES {
            let [rise, fall] = [-lower.gradient[along], upper.gradient[along]];
            let width = upper.at[along] - lower.at[along];
            let by = (width * fall + lower.height - upper.height) / (rise + fall);
            let by = if (0.0..=width).contains(&by) { by } else { 0.5 * width };
            let next = plane(lower.at[along] + by);
            let slope = next.gradient[along];
            if next.height <= -self.touch || slope.abs() * width <= 0.1 * next.height {
                return next;
            }
            *(if slope > 0.0 { &mut upper } else { &mut lower }) = next;
        }
        if lower.height < upper.height { lower } else { upper }
    }

    /// Cuts rays to and fro by what decides them, as far as it can be followed.
    fn walk(
        &self,
        tile: &mut Tile,
        square: Square,
        (chain, mut follower): (&Chain<'_>, Follower),
        (which, ends): (usize, &mut [Ends]),
    ) {
        for index in square.to_and_fro() {
            let (line, place) = (self.line(tile, index), tile.place(index));
            let Some(spans) = tile.rays.get_mut(index) else { continue };
            let end = self.step(chain, &mut follower, place, (&line, spans));
            let known = ends.get_mut(index).and_then(|ends| ends.get_mut(which));
            if let (Some(_), Some(known)) = (end, known) {
                *known = end;
            }
        }
    }

    /// Follows the surface to a ray.
    fn step(
        &self,
        chain: &Chain<'_>,
        follower: &mut Follower,
        ray: [usize; 2],
        (line, spans): (&Line, &mut Spans),
    ) -> Option<End> {
        let plain = follower.trace.on(line)?;
        let by = [0, 1].map(|k: usize| ray[k].cast_signed() - follower.ray[k].cast_signed());
        let (axis, way) = match by {
            [0, 1] => (1, 1.0),
            [0, -1] => (1, -1.0),
            [1, 0] => (0, 1.0),
            _ => (0, 0.0),
        };
        let s = plain.s + follower.off[axis] * f64::abs(way);
        let time = follower.time + follower.later[axis] * way;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let number = (0.5 * time).round().clamp(0.0, chain.stretches.len() as f64 - 1.0) as usize;
        let u = time - 2.0 * number as f64;
        let expected = Expected { s, guess: Guess { u, ..plain.guess }, ..plain };
        let (number, here) = self.seek(chain, number, line, &expected)?;
        let (s, near) = self.end(chain, number, (line, spans), (&expected, here))?;
        let time = 2.0 * number as f64 + near.u;
        if f64::abs(way) > 0.0 {
            follower.off[axis] = s - plain.s;
            follower.later[axis] = way * (time - follower.time);
        }
        (follower.time, follower.ray) = (time, ray);
        follower.trace = Trace::new(line, s, &near);
        Some(End { number, time, s })
    }

    /// The stretch during which the tool is nearest to where its surface is expected, from `number` on or back.
    fn seek(
        &self,
        chain: &Chain<'_>,
        mut number: usize,
        line: &Line,
        expected: &Expected,
    ) -> Option<(usize, Nearest)> {
        let mut guess = expected.guess;
        let mut way = 0.0;
        loop {
            let &(part, stretch) = chain.stretches.get(number)?;
            let here = self.moving(part, stretch).nearest(line, expected.s, guess);
            let ends = here.u.abs() >= 1.0 && way * here.u >= 0.0;
            let next = if here.u > 0.0 { number.checked_add(1) } else { number.checked_sub(1) };
            match next.filter(|next| ends && *next < chain.stretches.len()) {
                Some(next) => (number, guess.u, way) = (next, -here.u, here.u),
                None => return Some((number, here)),
            }
        }
    }

    /// Takes off a ray what one stretch sweeps up to where its surface is expected.
    fn end(
        &self,
        chain: &Chain<'_>,
        number: usize,
        (line, spans): (&Line, &mut Spans),
        (expected, here): (&Expected, Nearest),
    ) -> Option<(f64, Nearest)> {
        let &(part, stretch) = chain.stretches.get(number)?;
        let span = spans.iter().find(|span| span[0] < expected.s && expected.s < span[1])?;
        let (cut, s, near) = self.moving(part, stretch).follow(line, span, expected, here)?;
        spans.take(cut);
        Some((s, near))
    }

    /// Cuts a ray by a body unless its planes hold it off; `ends`: where it was followed to.
    fn try_on(
        &self,
        chain: &Chain<'_>,
        planes: &[Plane],
        ends: Ends,
        (line, spans): (&Line, &mut Spans),
    ) {
        let Some(which) = planes.first().map(|plane| plane.part) else { return };
        let off = |span| planes.iter().any(|plane| plane.along(line, span) > -self.touch);
        if spans.iter().all(off) {
            return;
        }
        let mut met = false;
        for number in chain.of(which) {
            let Some(&(part, stretch)) = chain.stretches.get(number) else { continue };
            if spans.iter().all(|span| self.passes((part, stretch), (ends, number), line, span)) {
                continue;
            }
            // None of its stretches meets what the whole does not meet.
            met = met
                || spans.iter().any(|span| {
                    !off(span) && self.meeting(part, &part.whole, line, span).is_some()
                });
            if !met {
                return;
            }
            let end = ends.iter().flatten().next();
            let guess = end.map_or(0.0, |end| end.seen_from(number));
            self.cut_spans((part, stretch, guess), line, spans, &mut |_| ());
        }
    }

    /// Whether a stretch keeps off a span for certain, as its nearest instant at an end that was followed tells: what
    /// is nearest when the ray is decided, or just before or after, may be so for longer.
    fn passes(
        &self,
        (part, stretch): (&Part, &Stretch),
        (ends, number): (Ends, usize),
        line: &Line,
        span: [f64; 2],
    ) -> bool {
        let followed = |end: &&End| span.iter().any(|s| s.total_cmp(&end.s).is_eq());
        let Some(end) = ends.iter().flatten().find(followed) else { return false };
        if end.number == number {
            return true;
        }
        let moving = self.moving(part, stretch);
        let guess = Guess::at(end.seen_from(number));
        let holds = |(s, way): (f64, f64)| {
            let near = moving.nearest(line, s, guess);
            near.bound > -self.touch && near.slope * way >= moving.shear
        };
        let [low, high] = [(span[0], 1.0), (span[1], -1.0)];
        let [first, other] = if end.s > span[0] { [high, low] } else { [low, high] };
        holds(first) || holds(other)
    }
}

/// In another order: the one in the middle first, then those in the middle of both halves, and so on. Of what
/// sweeps a ray lengthwise a few leave nothing to the others, then.
fn halving<T>(all: Vec<T>) -> Vec<T> {
    let bits = usize::BITS - all.len().leading_zeros();
    let order = (0..1usize << bits).map(|at| (at.reverse_bits() >> 1) >> (usize::BITS - 1 - bits));
    let mut left: Vec<Option<T>> = all.into_iter().map(Some).collect();
    order.filter_map(|at| left.get_mut(at).and_then(Option::take)).collect()
}
