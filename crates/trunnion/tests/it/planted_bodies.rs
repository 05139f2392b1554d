//! Collisions planted between random links at random places: all found on their lines, none where there is none.
//!
//! A ball rides on one link, a box or a cylinder on another. The oracle knows the distance of a point from a box or a cylinder in
//! closed form, and places the links by plain rotations at many instants. The ball is set so that it is 0.05 mm deep in the other
//! body at its nearest approach of the whole program, or 0.05 mm beside it.
//!
//! 10 cases here; 200 of each kind with `TRUNNION_TORTURE=1`.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the long run prints its count")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "indices from numbers in 0..1"
)]

use crate::bodies::{Noise, body, place, program, run};
use crate::shop;

use nalgebra::{Isometry3, Point3, Vector3};
use shop::Layout;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use trunnion::machine::{BodyShape, Machine, MachineBody};
use trunnion::types::{AxisVector, Mesh};
use trunnion::verify::{BodyReport, MachineBodies};

const TOLERANCE: f64 = 0.01;

/// Depth of the planted collisions, and distance of the clean cases \[mm\].
const PLANTED: f64 = 0.05;

/// Distance by which a facet of the ball may be inside the ball \[mm\].
const FACETS: f64 = 0.005;

/// Moves of a program.
const MOVES: usize = 12;

/// Instants at which the oracle looks at a move.
const INSTANTS: usize = 200;

/// The body that stands still in its frame.
#[derive(Debug, Clone, Copy)]
enum Obstacle {
    Box { low: Point3<f64>, high: Point3<f64> },
    Cylinder { base: Point3<f64>, radius: f64, height: f64 },
}

impl Obstacle {
    fn random(noise: &mut Noise) -> Self {
        let low = Point3::from(noise.point(200.0));
        let sizes: [f64; 3] = noise.point(1.0).map(|x| 40.0 + 30.0 * x);
        if noise.next() > 0.0 {
            Self::Box { low, high: low + Vector3::from(sizes) }
        } else {
            Self::Cylinder { base: low, radius: 0.5 * sizes[0], height: sizes[2] }
        }
    }

    /// Distance of a point from the surface; negative inside.
    fn distance(&self, p: &Point3<f64>) -> f64 {
        let off: Vec<f64> = match self {
            Self::Box { low, high } => {
                let (middle, half) = (nalgebra::center(low, high), (high - low) * 0.5);
                (0..3).map(|k| (p[k] - middle[k]).abs() - half[k]).collect()
            }
            Self::Cylinder { base, radius, height } => {
                let from = p - base;
                let half = 0.5 * height;
                vec![from.x.hypot(from.y) - radius, (from.z - half).abs() - half]
            }
        };
        let outside = off.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
        outside + off.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
    }

    /// A point of the surface, and the direction outwards.
    fn surface(&self, noise: &mut Noise) -> (Point3<f64>, Vector3<f64>) {
        let share = noise.point(0.95);
        match self {
            Self::Box { low, high } => {
                let axis = [0, 1, 2][(noise.next().abs() * 2.999) as usize];
                let side = if noise.next() > 0.0 { 1.0 } else { -1.0 };
                let mut at = Vector3::from(share);
                at[axis] = side;
                let middle = nalgebra::center(low, high);
                let out = Vector3::ith(axis, side);
                (middle + at.component_mul(&((high - low) * 0.5)), out)
            }
            Self::Cylinder { base, radius, height } => {
                let (sin, cos) = (PI * share[0]).sin_cos();
                let out = Vector3::new(cos, sin, 0.0);
                let up = Vector3::z() * (0.5 * (1.0 + share[1]) * height);
                (base + out * *radius + up, out)
            }
        }
    }

    fn body(&self, link: &str) -> MachineBody {
        let shape = match *self {
            Self::Box { low, high } => return body("block", link, low.into(), high.into()),
            Self::Cylinder { base, radius, height } => {
                BodyShape::Cylinder { base, axis: [0.0, 0.0, 1.0], radius, height }
            }
        };
        let (name, link) = ("block".to_owned(), link.to_owned());
        MachineBody { name, link, shape, touches: Vec::new() }
    }
}

/// A ball as a mesh of 16128 triangles, its corners on the sphere. The middle of a facet is half a diagonal from its
/// corners, 0.035 rad: of a ball of 8 mm it is 0.0048 mm inside.
fn ball(link: &str, middle: Point3<f64>, radius: f64) -> MachineBody {
    const ROWS: u32 = 64;
    const TURNS: u32 = 128;
    let mut vertices = vec![middle - Vector3::z() * radius, middle + Vector3::z() * radius];
    for row in 1..ROWS {
        let (sin, cos) = (PI * f64::from(row) / f64::from(ROWS)).sin_cos();
        for turn in 0..TURNS {
            let (s, c) = (TAU * f64::from(turn) / f64::from(TURNS)).sin_cos();
            vertices.push(middle + Vector3::new(sin * c, sin * s, -cos) * radius);
        }
    }
    let at = |row: u32, turn: u32| 2 + (row - 1) * TURNS + turn % TURNS;
    let mut triangles = Vec::new();
    for turn in 0..TURNS {
        triangles.push([0, at(1, turn + 1), at(1, turn)]);
        triangles.push([1, at(ROWS - 1, turn), at(ROWS - 1, turn + 1)]);
        for row in 1..ROWS - 1 {
            let [a, b] = [at(row, turn), at(row, turn + 1)];
            let [c, d] = [at(row + 1, turn), at(row + 1, turn + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let mesh = Mesh { vertices, triangles };
    let shape = BodyShape::Mesh { mesh: mesh.into(), place: Isometry3::identity(), allowance: 0.0 };
    let (name, link) = ("ball".to_owned(), link.to_owned());
    MachineBody { name, link, shape, touches: Vec::new() }
}

/// Motion of one link in the frame of another, at instants of every move.
struct Relative {
    machine: Machine,
    links: [String; 2],
    stops: Vec<AxisVector>,
    places: Vec<Vec<Isometry3<f64>>>,
}

impl Relative {
    fn new(machine: &Machine, links: [String; 2], stops: Vec<AxisVector>) -> Self {
        let mut relative = Self { machine: machine.clone(), links, stops, places: Vec::new() };
        relative.places = (0..MOVES)
            .map(|index| {
                let share = |k: usize| k as f64 / INSTANTS as f64;
                (0..=INSTANTS).map(|k| relative.at(index, share(k))).collect()
            })
            .collect();
        relative
    }

    fn at(&self, index: usize, share: f64) -> Isometry3<f64> {
        let q = self.stops[index] + (self.stops[index + 1] - self.stops[index]) * share;
        let [first, second] = self.links.each_ref().map(|link| place(&self.machine, link, &q));
        first.inverse() * second
    }

    /// Nearest approach of a ball on one move.
    fn nearest(&self, index: usize, obstacle: &Obstacle, middle: &Point3<f64>) -> f64 {
        let rough = |k: usize| obstacle.distance(&(self.places[index][k] * middle));
        let near = |k: usize| {
            (k.saturating_sub(1)..=(k + 1).min(INSTANTS)).all(|other| rough(k) <= rough(other))
        };
        let exact = |share: f64| obstacle.distance(&(self.at(index, share) * middle));
        // Of every instant that is nearer than its neighbours the interval around it is divided.
        let refined = |k: usize| {
            let [mut low, mut high] =
                [k.saturating_sub(1), (k + 1).min(INSTANTS)].map(|k| k as f64 / INSTANTS as f64);
            for _ in 0..25 {
                let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                if exact(a) < exact(b) { high = b } else { low = a }
            }
            exact(0.5 * (low + high)).min(rough(k))
        };
        let least = (0..=INSTANTS).map(rough).fold(f64::INFINITY, f64::min);
        let candidates = (0..=INSTANTS).filter(|k| near(*k) && rough(*k) < least + 2.0);
        candidates.map(refined).fold(least, f64::min)
    }

    fn nearest_of_all(&self, obstacle: &Obstacle, middle: &Point3<f64>) -> f64 {
        (0..MOVES).map(|k| self.nearest(k, obstacle, middle)).fold(f64::INFINITY, f64::min)
    }
}

/// One random machine with a ball that can be set anywhere along a ray.
struct Case {
    relative: Relative,
    obstacle: Obstacle,
    radius: f64,
    from: Point3<f64>,
    along: Vector3<f64>,
}

impl Case {
    fn random(noise: &mut Noise, number: usize) -> Self {
        let layout = [Layout::TableTable, Layout::TableHead, Layout::HeadHead][number % 3];
        let bare = shop::machine(layout);
        let links: Vec<String> =
            bare.chain.iter().filter(|word| *word != "t" && *word != "w").cloned().collect();
        let one = (noise.next().abs() * 5.999) as usize;
        let other = (one + 1 + (noise.next().abs() * 4.999) as usize) % 6;
        let mut stops = vec![bare.home()];
        for _ in 0..MOVES {
            let sizes = [120.0, 120.0, 80.0, 1.2, 0.9];
            stops.push(bare.home() + AxisVector::from_fn(|k, _| sizes[k] * noise.next()));
        }
        let obstacle = Obstacle::random(noise);
        let links = [links[one].clone(), links[other].clone()];
        let relative = Relative::new(&bare, links, stops);
        // On a random move at a random instant the ball is inside the surface at a random point.
        let index = (noise.next().abs() * (MOVES as f64 - 0.001)) as usize;
        let there = relative.at(index, 0.5 * (1.0 + noise.next())).inverse();
        let radius = 6.0 + 2.0 * noise.next();
        let (point, out) = obstacle.surface(noise);
        let (from, along) = (there * point, there.rotation * out);
        Self { relative, obstacle, radius, from, along }
    }

    fn nearest(&self, share: f64) -> f64 {
        let middle = self.from + self.along * share;
        self.relative.nearest_of_all(&self.obstacle, &middle) - self.radius
    }

    /// Middle of the ball whose nearest approach of all is `distance`; `None` if no place on the ray has it.
    fn middle(&self, distance: f64) -> Option<Point3<f64>> {
        let [mut low, mut high] = [0.0, 500.0];
        if self.nearest(high) < distance {
            return None;
        }
        for _ in 0..32 {
            let middle = 0.5 * (low + high);
            if self.nearest(middle) < distance { low = middle } else { high = middle }
        }
        let found = self.from + self.along * high;
        let off = self.relative.nearest_of_all(&self.obstacle, &found) - self.radius - distance;
        (off.abs() < 1e-6).then_some(found)
    }

    /// Checks the program with a ball; `None` if a body is in the way of another one at home, or of the tool.
    fn report(&self, middle: Point3<f64>) -> Option<BodyReport> {
        let Relative { machine, links: [first, second], stops, .. } = &self.relative;
        let bodies = vec![self.obstacle.body(first), ball(second, middle, self.radius)];
        let mut machine = machine.clone();
        machine.bodies = bodies;
        let bodies = MachineBodies::new(&machine, TOLERANCE).ok()??;
        assert_eq!(bodies.pairs(), 1);
        let report = run(&machine, &bodies, &program(&machine, stops), 0.0).ok()?;
        let ours = |name: &String| name == "block" || name == "ball";
        report.near.iter().all(|near| near.bodies.iter().all(ours)).then_some(report)
    }

    /// Compares the lines that touch with those of the oracle, leaving out what is within the tolerance.
    fn compare(&self, number: usize, middle: Point3<f64>, report: &BodyReport) {
        // A line of the head of the program, and one for the start at home.
        let line = |index: usize| u32::try_from(index + 3).unwrap();
        let found: BTreeMap<u32, f64> =
            report.near.iter().map(|near| (near.line, near.distance)).collect();
        let mut deep = 0;
        for index in 0..MOVES {
            let distance = self.relative.nearest(index, &self.obstacle, &middle) - self.radius;
            let hit = found.get(&line(index));
            if distance < -FACETS - 1e-6 {
                let found = hit.is_some_and(|d| *d < 0.0);
                assert!(found, "{number}, move {index}: {distance} missed");
                deep += 1;
            } else if distance > TOLERANCE {
                assert!(hit.is_none(), "{number}, move {index}: {distance}, reported {hit:?}");
            }
        }
        // Nothing outside the moves.
        let moves = line(0)..=line(MOVES - 1);
        assert!(found.keys().all(|at| moves.contains(at)), "{number}: {found:?}");
        assert!(report.near.len() >= deep);
    }
}

#[test]
fn planted_collisions_are_found_on_their_lines_and_none_in_clean_programs() {
    let torture = std::env::var_os("TRUNNION_TORTURE").is_some();
    let wanted = if torture { 200 } else { 10 };
    let mut noise = Noise(2026);
    let (mut planted, mut clean, mut number) = (0, 0, 0);
    while planted < wanted || clean < wanted {
        number += 1;
        assert!(number < 20 * wanted, "{planted} planted, {clean} clean");
        let case = Case::random(&mut noise, number);
        if planted < wanted
            && let Some(middle) = case.middle(-PLANTED)
            && let Some(report) = case.report(middle)
        {
            assert!(report.hits.is_some(), "{number}: not found");
            case.compare(number, middle, &report);
            planted += 1;
        }
        if clean < wanted
            && let Some(middle) = case.middle(PLANTED)
            && let Some(report) = case.report(middle)
        {
            assert!(report.hits.is_none() && report.near.is_empty(), "{number}: {report:?}");
            let least = report.least.unwrap();
            if least.bodies.iter().all(|name| name == "block" || name == "ball") {
                let distance = least.distance;
                assert!(
                    distance > PLANTED - 2.0 * TOLERANCE && distance < PLANTED + FACETS + 1e-6,
                    "{number}: {distance}"
                );
            }
            clean += 1;
        }
    }
    if torture {
        println!("{planted} planted and {clean} clean, of {number} random machines");
    }
}
