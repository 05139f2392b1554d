//! Bodies of the machine keep off each other, to within the tolerance.
//!
//! The oracle takes boxes as convex sets: it projects points from one to the other until they stay, at many instants of the
//! axes, and places the links by chains of plain rotations.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Vector3};
use shop::Layout;
use std::fmt::Write;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::machine::{BodyShape, Kinematics, Machine, MachineBody, Setup};
use trunnion::nc::read::{self, Dialect, ReadOptions};
use trunnion::nc::write::AxisWords;
use trunnion::types::{AxisVector, Silent};
use trunnion::verify::{
    BodyReport, CheckInput, CheckOptions, ClearanceOptions, DeviationTolerance, Inspection,
    MachineBodies, Solid, Stock, VerifyError,
};

const TOLERANCE: f64 = 0.01;

/// Deterministic numbers in -1..1.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let top = u32::try_from(self.0 >> 33).unwrap();
        f64::from(top) / f64::from(1_u32 << 30) - 1.0
    }

    pub(crate) fn point(&mut self, size: f64) -> [f64; 3] {
        [self.next(), self.next(), self.next()].map(|x| size * x)
    }
}

pub(crate) fn body(name: &str, link: &str, low: [f64; 3], high: [f64; 3]) -> MachineBody {
    MachineBody {
        name: name.to_owned(),
        link: link.to_owned(),
        shape: BodyShape::Box { min: low.into(), max: high.into() },
        touches: Vec::new(),
    }
}

fn with(layout: Layout, bodies: Vec<MachineBody>) -> Machine {
    let mut machine = shop::machine(layout);
    machine.bodies = bodies;
    machine
}

/// Checks a program of axis positions, without a part.
fn check(machine: &Machine, text: &str, clearance: f64) -> Result<BodyReport, VerifyError> {
    let bodies = MachineBodies::new(machine, TOLERANCE)?.unwrap();
    run(machine, &bodies, text, clearance)
}

pub(crate) fn run(
    machine: &Machine,
    bodies: &MachineBodies,
    text: &str,
    clearance: f64,
) -> Result<BodyReport, VerifyError> {
    let kinematics = Kinematics::new(machine, &shop::setup(Layout::TableTable));
    let options = ReadOptions::new(Dialect::LinuxCnc, AxisWords::of(machine).unwrap(), 20);
    let program = read::read(text, &options).unwrap();
    // A thin tool far above everything: the machine's own bodies are looked at.
    let cutter = Cutter::new(CutterSpec { length: 1.0, ..CutterSpec::flat(0.01) }).unwrap();
    let input = CheckInput::program(&program, &kinematics, &cutter);
    let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
    let options = CheckOptions::of_tolerance(tolerance, 0.5);
    let watch = ClearanceOptions { clearance, ..ClearanceOptions::within(TOLERANCE) };
    let found = Inspection::new(input, options).bodies(bodies, &watch).run(&Silent)?;
    Ok(found.bodies.unwrap())
}

/// A program of moves with all axes together, in machine coordinates.
pub(crate) fn program(machine: &Machine, positions: &[AxisVector]) -> String {
    let words = AxisWords::of(machine).unwrap();
    let mut text = String::from("G21 G90 G17 G54 G94 F3000\n");
    for q in positions {
        text += "G53 G1";
        for slot in 0..5 {
            let word = words.0[slot];
            let _ = write!(text, " {}{:.9}", word.letter, word.written(q[slot]));
        }
        text += "\n";
    }
    text + "M2\n"
}

/// Place of a link, from the workpiece's side on: plain rotations and translations.
pub(crate) fn place(machine: &Machine, link: &str, q: &AxisVector) -> Isometry3<f64> {
    let chain: Vec<&str> = machine.chain.iter().map(String::as_str).collect();
    let at = chain.iter().position(|word| *word == link).unwrap();
    let bed = chain.iter().position(|word| *word == "b").unwrap();
    // Axes between the workpiece and the body: of the workpiece's side those before it, of the tool's side itself too.
    let upto = if at > bed { at + 1 } else { at };
    let mut place = Isometry3::identity();
    for name in &chain[..upto] {
        let Some(index) = machine.axes.iter().position(|axis| axis.name == *name) else { continue };
        let axis = &machine.axes[index];
        let by = axis.sense * q[index];
        place *= if index < 3 {
            Isometry3::from(Translation3::from(axis.dir.into_inner() * by))
        } else {
            let turn = Rotation3::from_axis_angle(&axis.dir, by);
            let to = Translation3::from(axis.point.coords);
            to * Isometry3::from_parts(Translation3::identity(), turn.into()) * to.inverse()
        };
    }
    place
}

/// Distance of two boxes in places, by projecting a point from one to the other until it stays.
fn apart(boxes: [(&Isometry3<f64>, &BodyShape); 2]) -> f64 {
    let onto = |(place, shape): (&Isometry3<f64>, &BodyShape), p: &Point3<f64>| match shape {
        BodyShape::Box { min, max } => place * (place.inverse() * p).sup(min).inf(max),
        other => unreachable!("{other:?}"),
    };
    let mut p = onto(boxes[0], &Point3::origin());
    let mut distance = f64::INFINITY;
    for _ in 0..2_000 {
        let q = onto(boxes[1], &p);
        let next = onto(boxes[0], &q);
        let stays = (next - p).norm() < 1e-9;
        (p, distance) = (next, (next - q).norm());
        if stays {
            break;
        }
    }
    distance
}

/// Positions of a random program near the middle of the travels, starting at home.
fn positions(machine: &Machine, noise: &mut Noise, count: usize) -> Vec<AxisVector> {
    let mut all = vec![machine.home()];
    for _ in 0..count {
        let sizes = [60.0, 60.0, 40.0, 0.6, 0.4];
        let by = AxisVector::from_fn(|k, _| sizes[k] * noise.next());
        all.push(machine.home() + by);
    }
    all
}

/// Against many instants of boxes as convex sets: nothing is nearer than the report says, and it says no less than what is
/// there by more than the tolerance.
#[test]
fn the_least_distance_is_that_of_many_instants() {
    let mut noise = Noise(7);
    let mut near = 0;
    for layout in [Layout::TableTable, Layout::TableHead, Layout::HeadHead] {
        for _ in 0..6 {
            let bare = shop::machine(layout);
            let links: Vec<String> =
                bare.chain.iter().filter(|word| *word != "t" && *word != "w").cloned().collect();
            let mut bodies = Vec::new();
            for (number, link) in links.iter().enumerate() {
                let low = noise.point(120.0);
                let size = [0, 1, 2].map(|_| 30.0 + 20.0 * noise.next());
                let high = [0, 1, 2].map(|k| low[k] + size[k]);
                bodies.push(body(&format!("body {number}"), link, low, high));
            }
            let machine = with(layout, bodies.clone());
            let Ok(all) = MachineBodies::new(&machine, TOLERANCE) else { continue };
            let stops = positions(&machine, &mut noise, 3);
            let text = program(&machine, &stops);
            let report = run(&machine, &all.unwrap(), &text, 0.0).unwrap();
            // The tool is a body, too.
            bodies.push(body("tool", "t", [-0.005, -0.005, -1.0], [0.005, 0.005, 0.0]));
            let mut least = f64::INFINITY;
            for pair in stops.windows(2) {
                for step in 0..=60 {
                    let q = pair[0] + (pair[1] - pair[0]) * (f64::from(step) / 60.0);
                    let places: Vec<Isometry3<f64>> =
                        bodies.iter().map(|body| place(&machine, &body.link, &q)).collect();
                    for i in 0..bodies.len() {
                        for j in i + 1..bodies.len() {
                            // The last axis carries the tool.
                            if bodies[j].link == "t" && Some(&bodies[i].link) == links.last() {
                                continue;
                            }
                            let one = (&places[i], &bodies[i].shape);
                            let other = (&places[j], &bodies[j].shape);
                            least = least.min(apart([one, other]));
                        }
                    }
                }
            }
            let found = report.least.unwrap().distance;
            assert!(found <= least + 1e-6, "{layout:?}: {found} {least}");
            if least > 1.0 {
                // Between the instants the bodies come nearer by a part of a step: a few millimetres of 120 and 0.6 rad.
                assert!(found >= least - 4.0, "{layout:?}: {found} {least}");
                assert!(report.hits.is_none());
                near += 1;
            } else if least <= 0.0 {
                assert!(report.hits.is_some() && found < 0.0);
            }
        }
    }
    assert!(near >= 4, "{near}");
}

/// One body is planted so deep in the way of another, or as far beside it, on a random line.
#[test]
fn planted_collisions_are_found_at_their_line_and_none_beside_them() {
    const DEPTH: f64 = 0.05;
    let mut noise = Noise(11);
    for case in 0..200_u32 {
        let layout = [Layout::TableTable, Layout::TableHead, Layout::HeadHead][case as usize % 3];
        let bare = shop::machine(layout);
        let links: Vec<String> =
            bare.chain.iter().filter(|word| *word != "t" && *word != "w").cloned().collect();
        let pick = |x: f64| ((0.5 * (x + 1.0)) * 5.999).floor();
        let (mut one, mut other) = (pick(noise.next()), pick(noise.next()));
        if (one - other).abs() < 0.5 {
            (one, other) = (0.0, 5.0);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 5")]
        let [one, other] = [one.min(other), one.max(other)].map(|x| &links[x as usize]);
        // Every stop moves all axes; at the middle one a corner of the second body stands in or over the first.
        let stops = positions(&bare, &mut noise, 5);
        let at = &stops[3];
        let [first, second] = [one, other].map(|link| place(&bare, link, at));
        let size = 25.0 + 10.0 * noise.next();
        let low = [200.0, -15.0, 10.0];
        let plate = body("plate", one, low, [0, 1, 2].map(|k| low[k] + 60.0));
        // A pin whose middle is over the middle of the plate's top, along its normal.
        let top = first * Point3::new(230.0, 15.0, 70.0);
        let up = first.rotation * Vector3::z();
        let in_second = second.inverse() * top;
        let along = second.rotation.inverse() * up;
        for deep in [true, false] {
            let gap = if deep { -DEPTH } else { DEPTH };
            // A box in the frame of its link: its lowest corner along the normal is where the gap says.
            let reach: f64 = (0..3).map(|k| 0.5 * size * along[k].abs()).sum();
            let middle = in_second + along * (reach + gap);
            let low = [0, 1, 2].map(|k| middle[k] - 0.5 * size);
            let high = [0, 1, 2].map(|k| middle[k] + 0.5 * size);
            let machine = with(layout, vec![plate.clone(), body("pin", other, low, high)]);
            let text = program(&machine, &[*at, *at]);
            let bodies = match MachineBodies::new(&machine, TOLERANCE) {
                Ok(Some(bodies)) if bodies.pairs() > 0 => bodies,
                _ => continue,
            };
            let report = run(&machine, &bodies, &text, 0.0).unwrap();
            let found = report.least.as_ref().unwrap().distance;
            let direct = apart([(&first, &plate.shape), (&second, &machine.bodies[1].shape)]);
            if deep {
                assert!(report.hits.is_some() && found < 0.0, "{case}: {found}");
                assert!(report.near.iter().any(|near| near.bodies == ["plate", "pin"]));
            } else if report.hits.is_none() {
                assert!(
                    (found - direct).abs() <= TOLERANCE || found < direct,
                    "{case}: {found} {direct}"
                );
            } else {
                // The way from home to the place may lead through the plate: then many instants of it say so.
                let home = machine.home();
                let least = (0..=500).map(|step| {
                    let q = home + (at - home) * (f64::from(step) / 500.0);
                    let [one, two] = [one, other].map(|link| place(&machine, link, &q));
                    apart([(&one, &plate.shape), (&two, &machine.bodies[1].shape)])
                });
                assert!(least.fold(f64::INFINITY, f64::min) < 0.2, "{case}: {:?}", report.near);
            }
        }
    }
}

#[test]
fn pairs_that_always_touch_are_left_out_and_others_that_touch_at_home_are_refused() {
    let layout = Layout::HeadHead;
    let slide = |low: f64| {
        vec![
            body("bed", "b", [-2000.0, -2000.0, -500.0], [2000.0, 2000.0, -400.0]),
            body("slide", "X", [-50.0, -50.0, low], [50.0, 50.0, -300.0]),
        ]
    };
    let bodies = |bodies| MachineBodies::new(&with(layout, bodies), TOLERANCE);
    let found = bodies(slide(-400.0)).unwrap().unwrap();
    assert_eq!((found.pairs(), found.left_out().len()), (0, 1));
    let found = bodies(slide(-399.0)).unwrap().unwrap();
    assert_eq!((found.pairs(), found.left_out().len()), (1, 0));
    // A post beside the slide, in which it stands at home.
    let mut post = slide(-399.0);
    post.push(body("post", "b", [40.0, -10.0, -350.0], [60.0, 10.0, -250.0]));
    let refused = bodies(post.clone()).unwrap_err().to_string();
    assert!(
        refused.contains("slide") && refused.contains("post") && refused.contains("touches"),
        "{refused}"
    );
    post[2].touches = vec!["slide".to_owned()];
    assert_eq!(bodies(post).unwrap().unwrap().left_out().len(), 1);
}

#[test]
fn stock_and_fixtures_ride_on_the_table() {
    let layout = Layout::TableTable;
    let head = body("head", "Z", [-20.0, -20.0, 100.0], [20.0, 20.0, 200.0]);
    let machine = with(layout, vec![head]);
    let home = machine.home();
    let text = program(&machine, &[home]);
    let mut bodies = MachineBodies::new(&machine, TOLERANCE).unwrap().unwrap();
    assert!(run(&machine, &bodies, &text, 0.0).unwrap().near.is_empty());
    // In the frame of the workpiece, where the head is at home.
    let setup = shop::setup(layout);
    let to_workpiece =
        |p: Point3<f64>| Point3::from(setup.rotation.inverse() * (p.coords - setup.origin));
    let over = place(&machine, "Z", &home) * Point3::new(0.0, 0.0, 150.0);
    let under = place(&machine, "C", &home).inverse() * over;
    let middle = to_workpiece(under);
    let [low, high] = [-5.0, 5.0].map(|by| middle + Vector3::repeat(by));
    bodies.hold("clamp", &Solid::Box { low, high }, 0.0);
    let report = run(&machine, &bodies, &text, 0.0).unwrap();
    assert!(report.hits.is_some());
    assert_eq!(report.near[0].bodies, ["clamp", "head"]);
}

/// Checks moves of a tool of 20 mm through a block whose top is 40 mm below the tip at home, with a body on the spindle.
/// Depths count from the top. The block is cut, or counts with all of its material.
fn in_block(sensor: [[f64; 3]; 2], tips: &[[f64; 3]], is_cut: bool) -> Vec<u32> {
    const LENGTH: f64 = 60.0;
    const TOP: f64 = -100.0;
    let [low, high] = sensor.map(|[x, y, above_tip]| [x, y, above_tip - LENGTH]);
    let machine = with(Layout::TableTable, vec![body("sensor", "t", low, high)]);
    let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], LENGTH));
    let stops: Vec<AxisVector> = tips
        .iter()
        .map(|[x, y, depth]| AxisVector::from([*x, *y, TOP + LENGTH - depth, 0.0, 0.0]))
        .collect();
    let options = ReadOptions::new(Dialect::LinuxCnc, AxisWords::of(&machine).unwrap(), 20);
    let program = read::read(&program(&machine, &stops), &options).unwrap();
    let cutter = Cutter::new(CutterSpec { length: LENGTH, ..CutterSpec::flat(20.0) }).unwrap();
    let input = CheckInput::program(&program, &kinematics, &cutter);
    let block = Solid::Box {
        low: Point3::new(-30.0, -30.0, TOP - 50.0),
        high: Point3::new(30.0, 30.0, TOP),
    };
    let stock = Stock::new(&block, 0.5, 1_000_000).unwrap();
    let mut bodies = MachineBodies::new(&machine, TOLERANCE).unwrap().unwrap();
    bodies.hold_stock(&block);
    let options =
        CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 0.5);
    let watch = ClearanceOptions::within(TOLERANCE);
    let mut inspection = Inspection::new(input, options).bodies(&bodies, &watch);
    if is_cut {
        inspection = inspection.stock(&stock, 10);
    }
    let report = inspection.run(&Silent).unwrap().bodies.unwrap();
    assert!(report.near.iter().all(|near| near.bodies == ["stock", "sensor"]), "{report:?}");
    report.near.iter().map(|near| near.line).collect()
}

/// Lines of a program without its head.
const FIRST: u32 = 2;

#[test]
fn stock_is_as_it_is_cut_so_far() {
    // Down in two steps: beside the tool, 20 mm above its tip, the sensor follows into the hole that the first step cut.
    let tips = [[-10.0, 0.0, -5.0], [-10.0, 0.0, 18.0], [-10.0, 0.0, 36.0], [-10.0, 0.0, -5.0]];
    let sensor = |half: f64| [[-half, -half, 20.0], [half, half, 60.0]];
    let slim = sensor(6.0);
    assert_eq!(in_block(slim, &tips, true), [0; 0]);
    assert_eq!(in_block(slim, &tips, false), [FIRST + 2, FIRST + 3]);
    // Its corners are farther out than the hole is wide.
    assert_eq!(in_block(sensor(8.0), &tips, true), [FIRST + 2, FIRST + 3]);
    // In one step nothing is known of the stock in between: all of it counts.
    assert_eq!(in_block(slim, &[tips[0], tips[2], tips[3]], true), [FIRST + 1]);
}

/// A body that was let into a pocket is all inside of the uncut block: it still meets the wall.
#[test]
fn a_body_inside_a_pocket_meets_its_walls() {
    let sensor = [[-1.0, 12.0, 12.0], [1.0, 14.0, 14.0]];
    let to = |x: f64| {
        [
            [-10.0, 10.0, -5.0],
            [-10.0, 10.0, 11.0],
            [-10.0, 10.0, -5.0],
            [-10.0, 0.0, -5.0],
            [-10.0, 0.0, 11.0],
            [-10.0, 0.0, 18.0],
            [x, 0.0, 18.0],
        ]
    };
    assert_eq!(in_block(sensor, &to(-6.0), true), [0; 0]);
    assert_eq!(in_block(sensor, &to(10.0), true), [FIRST + 6]);
}

#[test]
fn a_check_without_a_box_in_the_way_is_clean() {
    let machine = with(Layout::TableHead, vec![body("far", "b", [5000.0; 3], [5100.0; 3])]);
    let report = check(&machine, &program(&machine, &[machine.home()]), 0.5).unwrap();
    assert!(report.near.is_empty() && report.least.is_some());
}
