//! Stock that follows a program forwards and backwards.

use super::brick::{BrickGrid, StockBrick, StockChanges};
use super::difference::Difference;
use super::keyframes::Keyframes;
use super::options::TimedStockOptions;
use crate::verify::error::VerifyError;
use crate::verify::input::CheckInput;
use crate::verify::replay::controls::Controls;
use crate::verify::replay::mover::Mover;
use crate::verify::replay::segment::Segment;
use crate::verify::stock::broad_phase::MovingPart;
use crate::verify::stock::carve::{self, BATCH};
use crate::verify::stock::material::Stock;
use crate::verify::stock::moving_tools::MovingTools;
use crate::verify::swept::bvh::BoundingBox;
use rayon::prelude::*;
use std::fmt;

/// Stock as a program has cut it up to a time, with what has changed of its surface.
///
/// All parts of the tools cut, in rapid moves as well. Time is that of [`timeline`](crate::verify::timeline). The moves are
/// kept, some hundred bytes each, and so are some states of the stock, from which going back begins.
///
/// # Example
///
/// ```
/// use nalgebra::Point3;
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::nc::read::ClText;
/// use trunnion::verify::{CheckInput, Solid, Stock, TimedStock, TimedStockOptions};
///
/// let cutter = Cutter::new(CutterSpec { length: 50.0, ..CutterSpec::flat(6.0) })?;
/// let text = "FEDRAT/600,MMPM\nGOTO/-5,0,-1,0,0,1\nGOTO/25,0,-1,0,0,1\nFINI\n";
/// let locations = ClText::new(text.to_owned(), 20)?;
/// let [low, high] = [Point3::new(0.0, -5.0, -4.0), Point3::new(20.0, 5.0, 0.0)];
/// let stock = Stock::new(&Solid::Box { low, high }, 0.5, 100_000)?;
///
/// let input = CheckInput::locations(&locations, &cutter);
/// let mut timed = TimedStock::new(&input, &stock, &TimedStockOptions::within(0.005))?;
/// assert_eq!(timed.end(), 3.0); // 30 mm at 10 mm/s
/// let all = timed.changes()?;
/// assert_eq!(timed.cut_towards(1.5, usize::MAX)?, 1.5);
/// assert!(timed.changes()?.bricks.len() <= all.bricks.len());
/// // Half of the slot: a block of 10 mm, and half of the cutter's circle.
/// assert!((800.0 - timed.volume() - (60.0 + 14.1)).abs() < 1.0);
/// assert_eq!(timed.cut_towards(0.0, usize::MAX)?, 0.0);
/// timed.changes()?;
/// assert!((timed.volume() - 800.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TimedStock {
    controls: Option<Controls>,
    tools: MovingTools,
    segments: Vec<Segment>,
    /// Time at the end of each move \[s\].
    ends: Vec<f64>,
    keyframes: Keyframes,
    /// After the first `done` moves.
    cut: Stock,
    done: usize,
    /// Time that it shows, at which the move after these is under way \[s\].
    time: f64,
    /// State of which the surface was returned last; `None` before the first.
    shown: Option<Stock>,
}

impl fmt::Debug for TimedStock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { segments, done, time, .. } = self;
        let mut shown = f.debug_struct("TimedStock");
        shown.field("moves", &segments.len()).field("done", done).field("time", time);
        shown.finish_non_exhaustive()
    }
}

impl TimedStock {
    /// Reads the moves of a program; nothing has cut yet.
    ///
    /// # Errors
    ///
    /// [`VerifyError`]; [`VerifyError::Option`] for a tolerance that is no length.
    pub fn new(
        input: &CheckInput<'_>,
        stock: &Stock,
        options: &TimedStockOptions,
    ) -> Result<Self, VerifyError> {
        let TimedStockOptions { tolerance, keyframe_memory } = *options;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let (name, must) = ("stock tolerance", "a length above 0");
            return Err(VerifyError::Option { name, value: tolerance, must });
        }
        let controls = input.controls()?;
        let run = input.run(controls.as_ref(), tolerance)?;
        let segments = run.segments().collect::<Result<Vec<_>, _>>()?;
        drop(run);
        let ends = segments.iter().scan(0.0, |now, segment| {
            *now += segment.duration;
            Some(*now)
        });
        let ends = ends.collect();
        // What was there before its first cut is no business of a picture.
        let cut = Stock { uncut: None, ..stock.clone() };
        let keyframes = Keyframes::new(cut.clone(), segments.len(), keyframe_memory);
        let tools = MovingTools::cutting(&input.cutters(), tolerance);
        let (done, time, shown) = (0, 0.0, None);
        Ok(Self { controls, tools, segments, ends, keyframes, cut, done, time, shown })
    }

    /// Returns the time at the end of the program \[s\].
    pub fn end(&self) -> f64 {
        self.ends.last().copied().unwrap_or_default()
    }

    /// Returns the volume of the stock whose surface was returned last \[mm³\].
    pub fn volume(&self) -> f64 {
        self.shown.as_ref().unwrap_or(&self.cut).volume()
    }

    /// Goes towards a time \[s\] by at most `moves` whole moves, and returns the time that it has come to \[s\].
    ///
    /// It begins at the keyframe before that time where this is the shorter way.
    ///
    /// # Errors
    ///
    /// [`VerifyError::TurnsTooFar`].
    pub fn cut_towards(&mut self, time: f64, moves: usize) -> Result<f64, VerifyError> {
        let time = time.max(0.0).min(self.end());
        let wanted = self.ends.partition_point(|end| *end <= time);
        if let Some((done, stock)) = self.keyframes.before(wanted)
            && (wanted < self.done || self.done < done)
        {
            (self.cut, self.done) = (stock.clone(), done);
        }
        let until = wanted.min(self.done.saturating_add(moves));
        while self.done < until {
            let most = BATCH.min(self.keyframes.distance(self.done));
            self.cut_moves(until.min(self.done + most))?;
            self.keyframes.offer(self.done, &self.cut);
        }
        self.time = if self.done == wanted { time } else { self.start() };
        Ok(self.time)
    }

    /// Returns the time at which the move after those that have cut begins \[s\].
    fn start(&self) -> f64 {
        let before = self.done.checked_sub(1).and_then(|last| self.ends.get(last));
        before.copied().unwrap_or_default()
    }

    /// Cuts with the moves up to a number of them.
    fn cut_moves(&mut self, until: usize) -> Result<(), VerifyError> {
        let segments = self.segments.get(self.done..until).unwrap_or_default();
        let parts = self.parts(segments)?;
        carve::clip_by(&mut self.cut, &parts, self.tools.tolerance);
        self.done = until;
        Ok(())
    }

    /// Returns the bodies of moves.
    fn parts(&self, segments: &[Segment]) -> Result<Vec<MovingPart>, VerifyError> {
        let mover = self.controls.as_ref().map_or(Mover::Locations, Mover::Machine);
        let mut parts = Vec::new();
        for segment in segments {
            self.tools.parts(&mover, segment, parts.len(), &mut parts)?;
        }
        Ok(parts)
    }

    /// Returns the bricks whose surface has changed since the last call, and all of them at the first one.
    ///
    /// # Errors
    ///
    /// [`VerifyError::TurnsTooFar`].
    pub fn changes(&mut self) -> Result<StockChanges, VerifyError> {
        let now = self.now()?;
        let Difference { bricks, bounds } = match &self.shown {
            Some(before) => Difference::of(before, &now),
            None => Difference::all(&now),
        };
        let (grid, tolerance) = (BrickGrid::of(&now), self.tools.tolerance);
        let brick = |number: usize| StockBrick {
            number,
            mesh: now.mesh_around(grid.nodes(number), tolerance),
        };
        let bricks = bricks.into_iter().collect::<Vec<_>>().into_par_iter().map(brick).collect();
        self.shown = Some(now);
        Ok(StockChanges { bricks, bounds: bounds.map(|BoundingBox { low, high }| [low, high]) })
    }

    /// Returns the stock at the time that it shows.
    fn now(&self) -> Result<Stock, VerifyError> {
        let mut now = self.cut.clone();
        let share = |segment: &Segment| (self.time - self.start()) / segment.duration;
        let begun = self.segments.get(self.done).filter(|segment| segment.duration > 0.0);
        if let Some((segment, share)) = begun.map(|of| (of, share(of))).filter(|of| of.1 > 0.0) {
            let parts = self.parts(&[segment.until(share.min(1.0))?])?;
            carve::clip_by(&mut now, &parts, self.tools.tolerance);
        }
        Ok(now)
    }
}

#[cfg(test)]
mod tests {
    use super::super::keyframes;
    use super::*;
    use crate::cutter::{Cutter, CutterSpec};
    use crate::nc::read::ClText;
    use crate::types::{Mesh, Silent};
    use crate::verify::replay::tables::Tool;
    use crate::verify::stock::build::solid::Solid;
    use crate::verify::stock::carve::{StockOptions, simulate};
    use crate::verify::stock::dexel::RaySpans;
    use crate::verify::stock::mesh::merge::NetQuad;
    use nalgebra::Point3;
    use std::collections::BTreeMap;

    const TOLERANCE: f64 = 0.005;

    /// Two tools: a slot at an incline, an approach that cuts at rapid speed, and short moves that turn. Times at 10 mm/s.
    const MOVES: &[&str] = &[
        "LOADTL/1\nFEDRAT/600,MMPM\nGOTO/-6,0,4,0.6,0,0.8",
        "GOTO/34,0,-3,0.6,0,0.8",
        "RAPID\nGOTO/34,12,-1,0.6,0,0.8",
        "GOTO/4,12,-1,0,0,1",
        "GOTO/8,10,-2,0,0.6,0.8",
        "GOTO/12,8,-4,0,0.28,0.96",
        "LOADTL/2\nGOTO/20,-30,-2,0,0,1",
        "GOTO/20,30,-2,0,0,1",
        "GOTO/24,30,-5,0,0,1",
        "GOTO/24,-30,-5,0,0,1",
    ];

    fn program(moves: &[&str]) -> ClText {
        ClText::new(format!("{}\nFINI\n", moves.join("\n")), 20).unwrap()
    }

    fn cutters() -> [Cutter; 2] {
        let with_length = |spec| Cutter::new(CutterSpec { length: 40.0, ..spec }).unwrap();
        [with_length(CutterSpec::ball(8.0)), with_length(CutterSpec::flat(6.0))]
    }

    fn block() -> Stock {
        let [low, high] = [Point3::new(0.0, -15.0, -20.0), Point3::new(30.0, 15.0, 0.0)];
        Stock::new(&Solid::Box { low, high }, 0.5, 100_000).unwrap()
    }

    fn timed(moves: &[&str], keyframe_memory: usize) -> TimedStock {
        with_input(moves, |input| {
            let options =
                TimedStockOptions { keyframe_memory, ..TimedStockOptions::within(TOLERANCE) };
            TimedStock::new(input, &block(), &options).unwrap()
        })
    }

    fn with_input<T>(moves: &[&str], work: impl FnOnce(&CheckInput<'_>) -> T) -> T {
        let (file, [one, two]) = (program(moves), cutters());
        let tools = [Tool { number: 1, cutter: &one }, Tool { number: 2, cutter: &two }];
        work(&CheckInput::locations(&file, &one).tools(&tools))
    }

    /// Stock that the check cuts with all of some moves.
    fn simulated(moves: &[&str]) -> Stock {
        let mut stock = block();
        with_input(moves, |input| {
            simulate(input, &mut stock, &StockOptions::within(TOLERANCE), &Silent).unwrap()
        });
        stock
    }

    /// Asserts that no stretch longer than both tolerances is material in one of two states alone.
    fn assert_same_material(one: &Stock, other: &Stock, words: &str) {
        let rays = |stock: &Stock| -> Vec<RaySpans> {
            let tiles = stock.families.iter().flat_map(|family| &family.tiles);
            tiles.flat_map(|tile| tile.rays.clone()).collect()
        };
        for (a, b) in rays(one).iter().zip(&rays(other)) {
            for (mine, yours) in [(a, b), (b, a)] {
                let mut rest = mine.clone();
                yours.iter().for_each(|span| rest.take(span));
                let longest = rest.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
                assert!(longest <= 2.0 * TOLERANCE, "{words}: {longest} mm of {a:?} and {b:?}");
            }
        }
    }

    /// Picture of a page that takes every change.
    #[derive(Default)]
    struct Picture(BTreeMap<usize, Mesh>);

    impl Picture {
        fn take(&mut self, changes: StockChanges) {
            for StockBrick { number, mesh } in changes.bricks {
                if mesh.triangles.is_empty() {
                    self.0.remove(&number)
                } else {
                    self.0.insert(number, mesh)
                };
            }
        }

        fn of(stock: &Stock) -> Self {
            let grid = BrickGrid::of(stock);
            let brick = |number| {
                let mesh = stock.mesh_around(grid.nodes(number), TOLERANCE);
                StockBrick { number, mesh }
            };
            let mut picture = Self::default();
            let bricks = grid.all().map(brick).collect();
            picture.take(StockChanges { bricks, bounds: None });
            picture
        }
    }

    /// Time at the end of the first moves, from the lengths of the ways \[s\].
    fn time_after(count: usize) -> f64 {
        *timed(&MOVES[..count], 0).ends.last().unwrap()
    }

    type NetCorners = BTreeMap<(usize, bool, [i64; 3]), [Point3<f64>; 4]>;

    /// Returns the corners of the quads of a net by their places.
    fn corners((quads, points): (Vec<NetQuad>, Vec<Point3<f64>>)) -> NetCorners {
        let place = |quad: &NetQuad| (quad.along, quad.up, quad.node());
        let at = |quad: &NetQuad| quad.corners.map(|corner| points[corner as usize]);
        quads.iter().map(|quad| (place(quad), at(quad))).collect()
    }

    /// Asserts that two states of a stock differ within a box only.
    fn assert_differ_within(before: &Stock, after: &Stock, bounds: Option<[Point3<f64>; 2]>) {
        let [before, after] = [before, after].map(|stock| corners(stock.net()));
        for (one, other) in [(&before, &after), (&after, &before)] {
            let differ = one.iter().filter(|(place, quad)| other.get(place) != Some(quad));
            for point in differ.flat_map(|(_, quad)| quad) {
                let [low, high] = bounds.unwrap();
                assert!(low <= *point && *point <= high, "{point} is not in {low} to {high}");
            }
        }
    }

    #[test]
    fn forwards_and_backwards_it_is_the_stock_that_a_check_cuts() {
        let mut stock = timed(MOVES, 3 * keyframes::size(&block()));
        let mut picture = Picture::default();
        picture.take(stock.changes().unwrap());
        for count in [3, 9, 10, 2, 6, 5, 8, 4, 10] {
            let time = time_after(count);
            assert!(stock.cut_towards(time, usize::MAX).unwrap() >= time);
            let before = stock.shown.clone().unwrap();
            let changes = stock.changes().unwrap();
            let shown = stock.shown.as_ref().unwrap();
            assert_differ_within(&before, shown, changes.bounds);
            picture.take(changes);
            assert_same_material(shown, &simulated(&MOVES[..count]), &format!("{count} moves"));
            assert_eq!(picture.0, Picture::of(shown).0, "after {count} moves");
        }
        stock.cut_towards(0.0, usize::MAX).unwrap();
        picture.take(stock.changes().unwrap());
        assert_eq!(picture.0, Picture::of(&block()).0);
    }

    #[test]
    fn a_move_under_way_has_cut_as_far_as_the_tool_is() {
        let mut stock = timed(MOVES, 0);
        stock.changes().unwrap();
        // A quarter of the slot of the second tool, 60 mm long, then three quarters, then a quarter again.
        for (share, way) in [
            (0.25, "GOTO/20,-15,-2,0,0,1"),
            (0.75, "GOTO/20,15,-2,0,0,1"),
            (0.25, "GOTO/20,-15,-2,0,0,1"),
        ] {
            let time = time_after(7) + share * 6.0;
            assert!(stock.cut_towards(time, usize::MAX).unwrap() >= time);
            stock.changes().unwrap();
            let moves = [&MOVES[..7], &[way]].concat();
            let shown = stock.shown.as_ref().unwrap();
            assert_same_material(shown, &simulated(&moves), &format!("{share} of the move"));
        }
    }

    #[test]
    fn few_moves_at_a_time_lead_there_as_well() {
        let mut stock = timed(MOVES, 0);
        let mut times = vec![0.0];
        while times.last() < Some(&stock.end()) {
            times.push(stock.cut_towards(f64::INFINITY, 2).unwrap());
            stock.changes().unwrap();
        }
        assert!(times.is_sorted() && times.len() > 4, "{times:?}");
        assert_same_material(stock.shown.as_ref().unwrap(), &simulated(MOVES), "the end");
    }

    #[test]
    fn bricks_together_have_the_surface_of_the_whole() {
        let stock = simulated(MOVES);
        let grid = BrickGrid::of(&stock);
        let all = grid.all().flat_map(|number| corners(stock.net_around(grid.nodes(number))));
        let mut count = 0;
        let all: BTreeMap<_, _> = all.inspect(|_| count += 1).collect();
        assert!(count > 10_000);
        assert_eq!(count, all.len(), "a quad is in two bricks");
        assert_eq!(all, corners(stock.net()));
    }

    #[test]
    fn keyframes_are_as_many_as_the_memory_holds() {
        let size = keyframes::size(&block());
        for (memory, most) in [(0, 1), (3 * size, 4), (5 * size - 1, 5), (usize::MAX, 17)] {
            let mut stock = timed(MOVES, memory);
            stock.cut_towards(stock.end(), usize::MAX).unwrap();
            let count = stock.keyframes.count();
            assert!(count <= most && 2 * count >= most.min(MOVES.len()), "{count} of {most}");
        }
    }
}
