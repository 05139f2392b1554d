//! What a moving tool cuts, from nothing but many poses of it and its signed distance: slow and plain.

#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]
#![allow(dead_code, reason = "every test binary uses its own part of this module")]

use super::dice::Random;
use super::posted;
use nalgebra::{Point3, Unit, Vector3};
use trunnion::cutter::Cutter;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, ClFile, ClMotion, ClPath, ClRecord, Dialect, Program, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::types::{AxisVector, Block, Motion, ToolPose};

/// What is linear in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// All axes.
    Joints,
    /// Tip and rotary axes.
    Tip,
    /// The tip; the tool axis is on a great circle.
    Circle,
}

/// A tool that moves.
pub(crate) trait Course {
    /// Moves one after the other.
    fn moves(&self) -> usize;

    /// The tool at `t` in 0..=1 of a move.
    fn pose(&self, index: usize, t: f64) -> ToolPose;

    /// Poses no more than `step` \[mm\] apart at the tip and 60 mm above it, with move and time.
    fn poses(&self, step: f64) -> Vec<(usize, f64, f64, ToolPose)> {
        let of = |index: usize| {
            let far = |pose: &ToolPose| pose.tip + pose.axis.into_inner() * 60.0;
            let rough: Vec<_> = (0..=16).map(|k| self.pose(index, f64::from(k) / 16.0)).collect();
            let lengths = rough.windows(2).map(|pair| {
                let tips = (pair[1].tip - pair[0].tip).norm();
                tips.max((far(&pair[1]) - far(&pair[0])).norm())
            });
            let count = (lengths.sum::<f64>() / step).ceil().clamp(20.0, 1000.0);
            let times = (0..=1000).map(f64::from).take_while(move |k| *k <= count);
            times.map(move |k| (index, k / count, 1.0 / count, self.pose(index, k / count)))
        };
        (0..self.moves()).flat_map(of).collect()
    }
}

/// Moves one after the other.
#[derive(Debug)]
pub(crate) struct Way {
    pub(crate) mode: Mode,
    pub(crate) machine: &'static str,
    pub(crate) kinematics: Kinematics,
    stops: Vec<(AxisVector, ToolPose)>,
}

/// One to four moves of one of the built-in machines; straight, turning or both.
pub(crate) fn any_way(random: &mut Random) -> Way {
    let (name, text) = BUILT_IN[random.below(BUILT_IN.len() as u64)];
    let mut machine = parse(text).unwrap().machine;
    let vector = |random: &mut Random, mm: f64, angle: f64| {
        let sizes = [mm, mm, mm, angle, angle];
        AxisVector::from(sizes.map(|size| random.within(-size, size)))
    };
    let mut q = vector(random, 100.0, 1.0);
    // The program starts where the machine is.
    machine.axes.iter_mut().zip(q.iter()).for_each(|(axis, &q)| axis.home = q);
    let rotation = [0, 1, 2].map(|_| random.within(-0.5, 0.5));
    let setup = Setup::new(random.point(150.0), rotation, random.within(80.0, 150.0));
    let kinematics = Kinematics::new(&machine, &setup);
    let mode = [Mode::Joints, Mode::Tip, Mode::Circle][random.below(3)];
    let mut stops = vec![(q, kinematics.forward(&q))];
    for _ in 0..=random.below(4) {
        let kind = random.below(3);
        let [mm, angle] = [random.within(-2.0, 0.7), random.within(-4.0, -0.5)];
        let mm = if kind == 0 { 0.0 } else { 10_f64.powf(mm) };
        let angle = if kind == 1 { 0.0 } else { 10_f64.powf(angle) };
        q += vector(random, mm, if mode == Mode::Joints { 0.2 * angle } else { angle });
        stops.push((q, kinematics.forward(&q)));
    }
    if mode != Mode::Joints {
        // Where the rotaries turn the tip stays about where it was.
        let start = stops[0].1.tip;
        for (q, pose) in stops.iter_mut().skip(1) {
            let tip = start + random.point(2.0);
            *pose = ToolPose { tip, axis: pose.axis };
            follow(&kinematics, q, pose);
        }
    }
    Way { mode, machine: name, kinematics, stops }
}

/// Moves the slides until the tip is where it should be: tips are affine in them.
pub(crate) fn follow(kinematics: &Kinematics, q: &mut AxisVector, pose: &ToolPose) {
    let here = kinematics.forward(q).tip;
    let column = |axis: usize| {
        let mut moved = *q;
        moved[axis] += 1.0;
        kinematics.forward(&moved).tip - here
    };
    let matrix = nalgebra::Matrix3::from_columns(&[column(0), column(1), column(2)]);
    let by = matrix.try_inverse().unwrap() * (pose.tip - here);
    (0..3).for_each(|axis| q[axis] += by[axis]);
}

impl Course for Way {
    fn moves(&self) -> usize {
        self.stops.len() - 1
    }

    fn pose(&self, index: usize, t: f64) -> ToolPose {
        let [from, to] = [&self.stops[index], &self.stops[index + 1]];
        let tip = from.1.tip + (to.1.tip - from.1.tip) * t;
        let pose = self.kinematics.forward(&(from.0 + (to.0 - from.0) * t));
        match self.mode {
            Mode::Joints => pose,
            Mode::Tip => ToolPose { tip, ..pose },
            Mode::Circle => ToolPose { tip, axis: on_circle([&from.1.axis, &to.1.axis], t) },
        }
    }
}

impl Way {
    /// The way as a CL file.
    pub(crate) fn file(&self) -> ClFile {
        let record = |(line, (_, pose)): (u32, &(AxisVector, ToolPose))| ClRecord {
            line,
            pose: *pose,
            motion: ClMotion::Feed(10.0),
            way: ClPath::Straight,
        };
        ClFile { records: (1..).zip(&self.stops).map(record).collect(), ..ClFile::default() }
    }

    /// The way as a program in inverse time.
    pub(crate) fn program(&self) -> Program {
        let machine = self.kinematics.machine();
        let words = AxisWords::of(machine).unwrap().with_decimals(9, 9);
        let block = |&(q, pose): &(AxisVector, ToolPose)| Block {
            motion: Motion::Cut,
            q,
            pose,
            duration: 0.1,
        };
        let blocks: Vec<_> = self.stops.iter().map(block).collect();
        let text = posted::plain(&self.kinematics, &blocks, (words, self.mode == Mode::Tip));
        // The retreat is no part of the way.
        let lines = text.lines().filter(|line| !line.starts_with("G53"));
        let text = lines.collect::<Vec<_>>().join("\n");
        read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, words, 5)).unwrap()
    }
}

/// Slerp by sines.
pub(crate) fn on_circle([from, to]: [&Unit<Vector3<f64>>; 2], t: f64) -> Unit<Vector3<f64>> {
    let angle = from.cross(to).norm().atan2(from.dot(to));
    let share = |t: f64| if angle > 0.0 { (t * angle).sin() / angle.sin() } else { t };
    Unit::new_normalize(from.into_inner() * share(1.0 - t) + to.into_inner() * share(t))
}

/// A convex part of the tool.
#[derive(Debug, Clone, Copy)]
enum Solid {
    /// A core, a straight bar of radius R above height r, grown by r, and cut off above.
    Nose { major: f64, minor: f64, top: f64 },
    /// Between two heights, radii at both.
    Cone { heights: [f64; 2], radii: [f64; 2] },
}

/// Parts of the tool: the cutting part up to the shank, and the shank from entry to entry, the last to the end.
fn solids(cutter: &Cutter) -> Vec<Solid> {
    let mut profile = cutter.spec().shank.clone();
    let top = profile.first().map_or(cutter.length(), |first| first[0]);
    let mut solids = vec![Solid::Nose { major: cutter.major(), minor: cutter.minor(), top }];
    profile.extend(profile.last().map(|last| [cutter.length(), last[1]]));
    for pair in profile.windows(2) {
        let [[low, below], [high, above]] = [pair[0], pair[1]];
        if high > low {
            solids.push(Solid::Cone { heights: [low, high], radii: [below, above] });
        }
    }
    solids
}

/// Signed distance from a part of the tool: convex in the point; exact but near sharp rims, where it is less.
fn distance(solid: &Solid, pose: &ToolPose, p: &Point3<f64>) -> f64 {
    let from_tip = p - pose.tip;
    let height = from_tip.dot(&pose.axis);
    let rho = (from_tip - pose.axis.into_inner() * height).norm();
    match *solid {
        Solid::Nose { major, minor, top } => {
            let [out, down] = [rho - major, minor - height];
            let side = out.max(0.0).hypot(down.max(0.0)) + out.max(down).min(0.0) - minor;
            side.max(height - top)
        }
        Solid::Cone { heights: [low, high], radii: [below, above] } => {
            // Out of the line from rim to rim, by its normal.
            let along = [high - low, above - below];
            let out =
                ((rho - below) * along[0] - (height - low) * along[1]) / along[0].hypot(along[1]);
            out.max(height - high).max(low - height)
        }
    }
}

/// Distance between poses that heights are measured with \[mm\].
pub(crate) const SPACING: f64 = 0.05;

type Ray = (Point3<f64>, Vector3<f64>);
type Poses = [(usize, f64, f64, ToolPose)];

/// Where a convex function is no more than 0 between `low` and `high`, by golden sections; `None` if nowhere.
fn below(f: &impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> Option<f64> {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let [mut low, mut high] = [low, high];
    let inner = |low: f64, high: f64| [high - SECTION * (high - low), low + SECTION * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let [mut fa, mut fb] = [f(a), f(b)];
    for _ in 0..45 {
        if fa <= 0.0 {
            return Some(a);
        }
        if fb <= 0.0 {
            return Some(b);
        }
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = inner(low, high)[0];
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = inner(low, high)[1];
            fb = f(b);
        }
    }
    None
}

/// Between a place outside and one inside, the border, to `width`.
fn border(f: &impl Fn(f64) -> f64, mut outside: f64, mut inside: f64, width: f64) -> f64 {
    while (outside - inside).abs() > width {
        let middle = 0.5 * (outside + inside);
        if f(middle) <= 0.0 { inside = middle } else { outside = middle }
    }
    inside
}

/// Lowest place on a normal in the tool less `shrink`, of all poses, up to `reach` either way; poses that are on it only below the
/// surface gouge another side.
pub(crate) fn lowest(
    poses: &Poses,
    cutter: &Cutter,
    (p, n): Ray,
    reach: f64,
    shrink: f64,
) -> Option<f64> {
    let solids = solids(cutter);
    let of = |pose: &ToolPose, solid: &Solid| {
        let f = |s: f64| distance(solid, pose, &(p + n * s)) + shrink;
        let here = f(0.0);
        if here > reach {
            return None;
        }
        if here > 0.0 {
            return below(&f, [0.0, reach]).map(|inside| border(&f, 0.0, inside, 1e-10));
        }
        Some(if f(-reach) <= 0.0 { -reach } else { border(&f, -reach, 0.0, 1e-10) })
    };
    let all = poses.iter().flat_map(|(.., pose)| solids.iter().map(move |solid| (pose, solid)));
    all.filter_map(|(pose, solid)| of(pose, solid)).min_by(f64::total_cmp)
}

/// Least distance of the tool from the place at height `s` on a normal, and from the surface if that is above: times
/// about all poses, nearest first, that can be the nearest, until it is `enough`.
pub(crate) fn nearest(
    (way, poses): (&dyn Course, &Poses),
    cutter: &Cutter,
    (p, n): Ray,
    (s, enough): (f64, f64),
) -> f64 {
    let solids = solids(cutter);
    let from = |pose: &ToolPose| {
        let part = |solid: &Solid| {
            let there = distance(solid, pose, &(p + n * s));
            if s < 0.0 { there.max(distance(solid, pose, &p)) } else { there }
        };
        solids.iter().map(part).fold(f64::INFINITY, f64::min)
    };
    let mut best: Vec<_> =
        poses.iter().map(|(i, t, step, pose)| (from(pose), *i, *t, *step)).collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    let near = |value: f64| value <= best[0].0 + SPACING;
    let mut least = f64::INFINITY;
    for &(_, index, t, step) in best.iter().take_while(|one| near(one.0)) {
        least = least.min(dip(&|t| from(&way.pose(index, t)), [t - step, t + step]));
        if least <= enough {
            break;
        }
    }
    least
}

/// Least value between two times that a search by sections comes to.
fn dip(f: &impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    let [mut low, mut high] = [low.max(0.0), high.min(1.0)];
    let mut least = f64::INFINITY;
    for _ in 0..60 {
        let [a, b] = [low + 0.4 * (high - low), low + 0.6 * (high - low)];
        let [fa, fb] = [f(a), f(b)];
        least = least.min(fa).min(fb);
        if fa < fb { high = b } else { low = a }
    }
    least
}

/// Volume of a box that lies in a pose, and its standard error \[mm³\]: two rays at random in each of `lines` x `lines`
/// cells.
pub(crate) fn volume(
    poses: &Poses,
    cutter: &Cutter,
    [low, high]: [Point3<f64>; 2],
    (along, lines): (usize, u32),
    random: &mut Random,
) -> (f64, f64) {
    let (size, solids) = (high - low, solids(cutter));
    let [a, b] = [(along + 1) % 3, (along + 2) % 3];
    let [da, db] = [size[a], size[b]].map(|size| size / f64::from(lines));
    let (mut sum, mut variance) = (0.0, 0.0);
    for i in 0..lines {
        for j in 0..lines {
            let [one, other] = [0, 1].map(|_| {
                let mut p = low;
                p[a] += da * (f64::from(i) + random.within(0.0, 1.0));
                p[b] += db * (f64::from(j) + random.within(0.0, 1.0));
                covered(poses, &solids, (p, Vector3::ith(along, 1.0)), size[along])
            });
            sum += 0.5 * (one + other);
            variance += 0.25 * (one - other).powi(2);
        }
    }
    (sum * da * db, variance.sqrt() * da * db)
}

/// Length of a ray's part in any pose.
fn covered(poses: &Poses, solids: &[Solid], (p, n): Ray, length: f64) -> f64 {
    let inside = |pose: &ToolPose, solid: &Solid| {
        let f = |s: f64| distance(solid, pose, &(p + n * s));
        let middle = f(0.5 * length);
        if middle > 0.5 * length {
            return None;
        }
        let inner = if middle <= 0.0 { 0.5 * length } else { below(&f, [0.0, length])? };
        let end = |end: f64| if f(end) <= 0.0 { end } else { border(&f, end, inner, 1e-6) };
        Some([end(0.0), end(length)])
    };
    let all = poses.iter().flat_map(|(.., pose)| solids.iter().map(move |solid| (pose, solid)));
    let mut parts: Vec<_> = all.filter_map(|(pose, solid)| inside(pose, solid)).collect();
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut last) = (0.0, 0.0_f64);
    for [from, to] in parts {
        sum += (to - from.max(last)).max(0.0);
        last = last.max(to);
    }
    sum
}
