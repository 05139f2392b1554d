//! Random programs with arcs and helices, rapid moves and tool vectors, for random tools with shank and holder: the heights
//! that a check measures and the volume that is cut, against many poses by formulas of their own. A few by default;
//! `just torture` sets `TRUNNION_TORTURE=1` for thousands. `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the worst found says how near it is")]

use crate::dice;
use crate::many_poses;
use crate::random_cut;

use dice::{Random, full, seed};
use many_poses::Course;
use nalgebra::{Point3, Vector3};
use random_cut::{RAY_TOLERANCE, ROUNDING, any_cutter, any_face, off, with_holder};
use trunnion::cutter::Cutter;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions};
use trunnion::nc::write::work_offset;
use trunnion::surface::Face;
use trunnion::types::{AxisVector, Interval, Silent, ToolPose};
use trunnion::verify::{self, CheckInput, Solid, Stock, StockOptions, Tables};

/// What a program's words are, and how the tool turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Words {
    /// Axes less the work offset and tool length.
    Axes,
    /// The tip, and angles that are linear.
    Tip,
    /// The tip and a vector: on great circles.
    Circle,
    /// The tip and a vector: with angles that are linear.
    Angles,
}

/// Between two places of the machine.
#[derive(Debug, Clone, Copy)]
enum Leg {
    Straight,
    /// The words of a plane turn about a centre \[mm\] by an angle \[rad\].
    Arc {
        plane: [usize; 2],
        center: [f64; 2],
        sweep: f64,
    },
    /// Each axis at its own speed.
    Own,
}

/// A program, and the moves it comes to.
#[derive(Debug)]
struct Run {
    words: Words,
    machine: &'static str,
    kinematics: Kinematics,
    text: String,
    /// Axes at both ends, and how they get there.
    legs: Vec<([AxisVector; 2], Leg)>,
}

/// A built-in machine somewhere inside; it travels as far as it likes.
fn any_machine(random: &mut Random) -> (&'static str, Kinematics, AxisVector) {
    let (name, text) = BUILT_IN[random.below(BUILT_IN.len() as u64)];
    let mut machine = parse(text).unwrap().machine;
    let sizes = [100.0, 100.0, 100.0, 1.0, 1.0];
    let rotation = [0, 1, 2].map(|_| random.within(-0.5, 0.5));
    let setup = Setup::new(random.point(150.0), rotation, random.within(80.0, 150.0));
    machine.axes.iter_mut().for_each(|axis| axis.limits = Interval::new(-1e9, 1e9));
    loop {
        let q = AxisVector::from(sizes.map(|size| random.within(-size, size)));
        machine.axes.iter_mut().zip(q.iter()).for_each(|(axis, &q)| axis.home = q);
        let kinematics = Kinematics::new(&machine, &setup);
        // Away from where one rotary turns the tool as the other does.
        let axis = |by: [f64; 2]| {
            let q = q + AxisVector::from([0.0, 0.0, 0.0, by[0], by[1]]);
            kinematics.forward(&q).axis.into_inner()
        };
        let [here, first, second] = [axis([0.0; 2]), axis([1e-4, 0.0]), axis([0.0, 1e-4])];
        if (first - here).cross(&(second - here)).norm() > 0.3e-8 {
            return (name, kinematics, q);
        }
    }
}

impl Run {
    fn any(random: &mut Random) -> Self {
        let (machine, kinematics, mut q) = any_machine(random);
        let words = [Words::Axes, Words::Tip, Words::Circle, Words::Angles][random.below(4)];
        let text = match words {
            Words::Axes => "G21 G90 G17 G54 G93 G43 H1\n",
            Words::Tip => "G21 G90 G17 G54 G93 G43 H1\nM428\n",
            Words::Circle => "G90 G94 G54\nTRAORI\nORIWKS ORIVECT\n",
            Words::Angles => "G90 G94 G54\nTRAORI\nORIWKS ORIAXES\n",
        };
        let text = text.to_owned();
        let mut run = Self { words, machine, kinematics, text, legs: Vec::new() };
        // Where the machine is: arcs begin where the text says.
        run.write(&run.read(&q), Leg::Straight, false);
        run.legs.push(([q; 2], Leg::Straight));
        for _ in 0..=random.below(3) {
            q = run.go(q, random);
        }
        run.text += if run.is_vector() { "M30\n" } else { "M2\n" };
        run
    }

    fn is_vector(&self) -> bool {
        matches!(self.words, Words::Circle | Words::Angles)
    }

    /// A move from somewhere.
    fn go(&mut self, from: AxisVector, random: &mut Random) -> AxisVector {
        let angle = 10_f64.powf(random.within(-4.0, -0.7));
        let turn = [0, 1].map(|_| random.within(-angle, angle));
        let mut to = from + AxisVector::from([0.0, 0.0, 0.0, turn[0], turn[1]]);
        let mut words = self.read(&from);
        let kind = random.below(if self.is_vector() { 2 } else { 4 });
        let leg = if kind < 2 {
            (0..3).for_each(|axis| words[axis] += random.within(-3.0, 3.0));
            Leg::Straight
        } else {
            let plane = [[0, 1], [2, 0], [1, 2]][random.below(3)];
            let center = [0, 1]
                .map(|_| random.within(0.3, 4.0) * if random.below(2) == 0 { 1.0 } else { -1.0 });
            let sweep = random.within(0.3, 6.0) * if random.below(2) == 0 { 1.0 } else { -1.0 };
            let [u, v] = around(center, sweep);
            words[plane[0]] += u;
            words[plane[1]] += v;
            words[3 - plane[0] - plane[1]] += random.within(-1.0, 1.0);
            Leg::Arc { plane, center, sweep }
        };
        (words[3], words[4]) = (to[3], to[4]);
        to = self.axes(&words);
        self.legs.push(([from, to], leg));
        let rapid = kind == 0;
        if rapid {
            self.legs.push(([from, to], Leg::Own));
        }
        self.write(&words, leg, rapid);
        to
    }

    /// The words of a place.
    fn read(&self, q: &AxisVector) -> AxisVector {
        let mut words = *q;
        let linear = match self.words {
            Words::Axes => q.fixed_rows::<3>(0) - self.shift(),
            _ => (self.kinematics.setup().rotation * self.kinematics.forward(q).tip).coords,
        };
        words.fixed_rows_mut::<3>(0).copy_from(&linear);
        words
    }

    /// The place of words.
    fn axes(&self, words: &AxisVector) -> AxisVector {
        let mut q = *words;
        let linear = words.fixed_rows::<3>(0).into_owned();
        if self.words == Words::Axes {
            q.fixed_rows_mut::<3>(0).copy_from(&(linear + self.shift()));
        } else {
            let tip = self.kinematics.setup().rotation.inverse() * Point3::from(linear);
            let pose = ToolPose { tip, ..self.kinematics.forward(&q) };
            many_poses::follow(&self.kinematics, &mut q, &pose);
        }
        q
    }

    fn shift(&self) -> Vector3<f64> {
        let length = self.kinematics.setup().tool_length;
        work_offset(&self.kinematics).unwrap() + Vector3::z() * length
    }

    fn write(&mut self, words: &AxisVector, leg: Leg, rapid: bool) {
        use std::fmt::Write;
        let axes = AxisWords::of(self.kinematics.machine()).unwrap();
        let text = &mut self.text;
        let code = match leg {
            Leg::Arc { plane, sweep, .. } => {
                let plane = match plane {
                    [0, _] => "G17",
                    [2, _] => "G18",
                    _ => "G19",
                };
                format!("{plane} G{}", if sweep < 0.0 { 2 } else { 3 })
            }
            _ if rapid => "G0".to_owned(),
            _ => "G1".to_owned(),
        };
        write!(text, "{code} X{:.9} Y{:.9} Z{:.9}", words[0], words[1], words[2]).unwrap();
        if matches!(self.words, Words::Circle | Words::Angles) {
            let table = self.kinematics.setup().rotation * self.kinematics.forward(words).axis;
            write!(text, " A3={:.15} B3={:.15} C3={:.15}", table.x, table.y, table.z).unwrap();
        } else {
            for slot in [3, 4] {
                let word = axes.0[slot];
                write!(text, " {}{:.9}", word.letter, word.written(words[slot])).unwrap();
            }
        }
        if let Leg::Arc { plane, center, .. } = leg {
            for (axis, value) in plane.into_iter().zip(center) {
                write!(text, " {}{value:.9}", ["I", "J", "K"][axis]).unwrap();
            }
        }
        if !rapid {
            text.push_str(" F600");
        }
        text.push('\n');
    }

    fn input<T>(
        &self,
        faces: &[Face],
        cutter: &Cutter,
        work: impl FnOnce(&CheckInput<'_>) -> T,
    ) -> T {
        let words = AxisWords::of(self.kinematics.machine()).unwrap();
        let dialect = if self.is_vector() { Dialect::Siemens } else { Dialect::LinuxCnc };
        let program = read::read(&self.text, &ReadOptions::new(dialect, words, 5)).unwrap();
        let (believed, real, tables) = (&self.kinematics, &self.kinematics, Tables::NONE);
        work(
            &CheckInput::program(&program, believed, cutter)
                .machine(real)
                .faces(faces)
                .tables(tables),
        )
    }
}

/// From where an arc begins to its place after an angle.
fn around([u, v]: [f64; 2], angle: f64) -> [f64; 2] {
    let turned = nalgebra::Rotation2::new(angle) * nalgebra::Vector2::new(-u, -v);
    [u + turned.x, v + turned.y]
}

impl Course for Run {
    fn moves(&self) -> usize {
        self.legs.len()
    }

    fn pose(&self, index: usize, t: f64) -> ToolPose {
        let ([from, to], leg) = &self.legs[index];
        if let Leg::Own = leg {
            let speeds = self.kinematics.machine().vector(|axis| axis.rapid);
            let change = to - from;
            let time = t * change.abs().component_div(&speeds).amax();
            let run =
                |slot: usize| change[slot].signum() * (speeds[slot] * time).min(change[slot].abs());
            return self.kinematics.forward(&(from + AxisVector::from_fn(|slot, _| run(slot))));
        }
        let [begin, end] = [self.read(from), self.read(to)];
        let mut words = begin + (end - begin) * t;
        if let Leg::Arc { plane, center, sweep } = *leg {
            let by = around(center, t * sweep);
            plane.into_iter().zip(by).for_each(|(axis, by)| words[axis] = begin[axis] + by);
        }
        let pose = self.kinematics.forward(&self.axes(&words));
        if self.words != Words::Circle {
            return pose;
        }
        let ends = [from, to].map(|q| self.kinematics.forward(q).axis);
        ToolPose { axis: many_poses::on_circle([&ends[0], &ends[1]], t), ..pose }
    }
}

/// Some of the moves.
struct Moves<'a>(&'a Run, Vec<usize>);

impl Course for Moves<'_> {
    fn moves(&self) -> usize {
        self.1.len()
    }

    fn pose(&self, index: usize, t: f64) -> ToolPose {
        self.0.pose(self.1[index], t)
    }
}

/// The moves at feed, and rapids in both ways of running them.
fn both(run: &Run) -> [Moves<'_>; 2] {
    let own = |index: usize| matches!(run.legs.get(index), Some((_, Leg::Own)));
    let rapid = |index: &usize| own(*index) || own(index + 1);
    let (rapids, cuts) = (0..run.legs.len()).partition(rapid);
    [cuts, rapids].map(|moves| Moves(run, moves))
}

fn any_tool(random: &mut Random) -> Cutter {
    let cutter = any_cutter(random);
    if random.below(2) == 0 { cutter } else { with_holder(&cutter, random) }
}

/// No pose gets lower than the check says, and what it says is touched at some time.
#[test]
fn heights_of_programs_are_those_of_many_poses() {
    let (first, count) = (seed(), if full() { 3000 } else { 10 });
    let (mut points, mut reached, mut worst) = (0, 0, [f64::NEG_INFINITY; 2]);
    for case in 0..count {
        let seed = first.wrapping_add(case);
        let random = &mut Random(seed);
        let (cutter, run) = (any_tool(random), Run::any(random));
        let [way, own] = both(&run);
        let face = any_face(random, &run, &cutter);
        let options = random_cut::options(random.within(0.7, 1.5));
        let report = run.input(std::slice::from_ref(&face), &cutter, |input| {
            verify::check(input, &options, &Silent).unwrap()
        });
        assert_eq!(report.deviation.unmeasured, 0, "seed {seed}");
        points += report.deviation.points;
        reached += report.deviation.points - report.deviation.uncut;
        let off = off([&way, &own], &cutter, &face, &report);
        let kind = (cutter.kind(), run.words, run.machine, &run.text);
        // Chords of arcs are off by a tenth of the tolerance.
        let allowed = 1.1 * RAY_TOLERANCE + ROUNDING;
        assert!(off[0] <= allowed, "seed {seed} {kind:?}: missed by {:e}", off[0]);
        assert!(off[1] <= allowed, "seed {seed} {kind:?}: {:e} away", off[1]);
        worst = [0, 1].map(|k| worst[k].max(off[k]));
    }
    assert!(3 * reached > points, "{reached} of {points}");
    let [above, away] = worst;
    println!(
        "{count} programs, {reached} of {points} points reached: at most {above:e} mm above poses, {away:e} mm off the tool"
    );
}

/// The volume that is cut, on rapid moves by each axis at its own speed, too, is that of the poses.
#[test]
fn volumes_of_programs_are_those_of_many_poses() {
    let (first, count) = (seed(), if full() { 200 } else { 3 });
    let lines = if full() { 60 } else { 25 };
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for case in 0..count {
        let seed = first.wrapping_add(case);
        let random = &mut Random(seed);
        let (cutter, run) = (any_tool(random), Run::any(random));
        let half = Vector3::repeat(random.within(2.0, 5.0));
        let start = run.pose(0, 0.0);
        let up = start.axis.into_inner() * random.within(0.0, 20.0);
        let centre = start.tip + up + random.point(3.0);
        let [low, high]: [Point3<f64>; 2] = [centre - half, centre + half];
        let cell = half.x / 40.0;
        let mut stock = Stock::new(&Solid::Box { low, high }, cell, 10_000_000).unwrap();
        let removed = run.input(&[], &cutter, |input| {
            let cutting = StockOptions::within(1e-4);
            verify::simulate(input, &mut stock, &cutting, &Silent).unwrap().removed
        });
        let (along, poses) = (random.below(3), run.poses(0.6 * cell));
        let (seen, error) =
            many_poses::volume(&poses, &cutter, [low, high], (along, lines), random);
        // Each ray stands for a cell, of which it knows the edge to a part; walls are four sides of the block long.
        let size = 2.0 * half.x;
        let own = 0.1 * cell * cell * size * (4.0 * size / cell).sqrt();
        let z = (removed - seen) / error.hypot(own);
        let kind = (cutter.kind(), run.words, run.machine, &run.text);
        assert!(z.abs() < 5.0, "seed {seed} {kind:?}: {removed} mm3 cut, poses show {seen} ({z})");
        sum += z;
        worst = worst.max((removed - seen).abs() / size.powi(3));
    }
    let mean = sum / count as f64;
    println!(
        "{count} programs: mean {mean:.3} of the expected error, worst {worst:e} of the block"
    );
    assert!(mean.abs() < 5.0 / (count as f64).sqrt(), "{mean}");
}
