//! There and back: forward of inverse is the pose, on every branch, for the machine files and for
//! random chains. A small count by default; `just torture` sets `TRUNNION_TORTURE=1` for 10^6 poses
//! a layout and 10^4 chains. The seed is printed; `TRUNNION_TORTURE_SEED` repeats a run.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]
#![expect(clippy::print_stdout, reason = "the worst found says how near it is")]

use crate::chains;
use crate::dice;

use chains::{axis, spec};
use dice::{Random, full, seed};
use nalgebra::{Point3, UnitVector3};
use std::f64::consts::PI;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::{Inverse, InverseError, InverseSolutions};
use trunnion::machine::{FIRST_ROTARY, Kinematics, Machine, Setup};
use trunnion::math::angle::angle_between;
use trunnion::types::{AxisVector, ToolPose};

/// What the round trip keeps \[mm, rad\].
const TIP: f64 = 1e-9;
const AXIS: f64 = 1e-12;

/// Worst error of forward of inverse at a pose, over its solutions \[mm, rad\], and how far the slides
/// went \[mm\]; `None` where the slides lie in one plane.
fn trip(inverse: &Inverse, there: &ToolPose) -> Option<([f64; 2], f64)> {
    let solutions = match inverse.solutions(there) {
        Ok(InverseSolutions::Regular(both)) => both.to_vec(),
        Ok(InverseSolutions::Singular(one)) => vec![one],
        Err(InverseError::FlatSlides { .. }) => return None,
        Err(error) => panic!("{error}"),
    };
    let mut worst = [0.0_f64; 2];
    let mut far = 0.0_f64;
    for q in &solutions {
        let again = inverse.kinematics().forward(q);
        let tip = (again.tip - there.tip).norm();
        let turn = angle_between(&again.axis, &there.axis);
        assert!(tip.is_finite() && turn.is_finite(), "{q}");
        worst = [worst[0].max(tip), worst[1].max(turn)];
        far = far.max(q.fixed_rows::<3>(0).norm());
    }
    Some((worst, far))
}

/// A tool direction within reach, every other one near a pole: 10^-1 to 10^-12 rad.
fn reachable(random: &mut Random, inverse: &Inverse) -> UnitVector3<f64> {
    let poles = inverse.singular_directions();
    if let (false, Some(pole)) = (random.below(2) == 0, poles.first()) {
        let tilt = 10.0_f64.powf(random.within(-12.0, -1.0));
        let side = random.direction();
        let across = side.into_inner() - pole.scale(pole.dot(&side));
        return UnitVector3::new_normalize(pole.into_inner() + across * tilt);
    }
    // By the rotaries: what they turn the tool to is within reach.
    let mut q = AxisVector::zeros();
    q[FIRST_ROTARY] = random.within(-PI, PI);
    q[FIRST_ROTARY + 1] = random.within(-PI, PI);
    inverse.kinematics().forward(&q).axis
}

#[test]
fn every_machine_file_there_and_back() {
    let mut random = Random(seed());
    let count = if full() { 1_000_000 } else { 3000 };
    for (name, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        let turn: [f64; 3] = random.point(PI).into();
        let setup = Setup::new(random.point(300.0), turn, random.within(0.0, 300.0));
        let inverse = Inverse::new(&Kinematics::new(&machine, &setup)).unwrap();
        let mut worst = [0.0_f64; 2];
        for _ in 0..count {
            let tip = Point3::from(random.point(500.0));
            let there = ToolPose { tip, axis: reachable(&mut random, &inverse) };
            let ([mm, rad], _) = trip(&inverse, &there).unwrap();
            assert!(mm <= TIP && rad <= AXIS, "{name}: off by {mm:e} mm, {rad:e} rad at {there:?}");
            worst = [worst[0].max(mm), worst[1].max(rad)];
        }
        println!("{name}: {count} poses, worst {:.1e} mm, {:.1e} rad", worst[0], worst[1]);
    }
}

/// Five axes and the bed in any order, in directions that are not degenerate.
fn chain(random: &mut Random) -> Kinematics {
    let mut order = ["b", "X", "Y", "Z", "P", "S"];
    for end in (1..order.len()).rev() {
        order.swap(end, random.below(end as u64 + 1));
    }
    let [x, y, z] = loop {
        let all = [0; 3].map(|_| random.direction().into_inner());
        if all[0].cross(&all[1]).dot(&all[2]).abs() > 0.2 {
            break all;
        }
    };
    let [p, s, tool] = loop {
        let all = [0; 3].map(|_| random.direction().into_inner());
        if [(0, 1), (1, 2), (0, 2)].iter().all(|&(i, j)| all[i].cross(&all[j]).norm() > 0.1) {
            break all;
        }
    };
    let rotary = |name, dir, point| axis(name, dir, Some(point));
    let mut axes = vec![axis("X", x, None), axis("Y", y, None), axis("Z", z, None)];
    axes.extend([rotary("P", p, random.point(500.0)), rotary("S", s, random.point(500.0))]);
    for axis in &mut axes {
        axis.sense = if random.below(2) == 0 { 1.0 } else { -1.0 };
    }
    let machine = Machine::new(spec(&order, axes, random.point(500.0), tool)).unwrap();
    let turn: [f64; 3] = random.point(PI).into();
    Kinematics::new(&machine, &Setup::new(random.point(500.0), turn, random.within(0.0, 300.0)))
}

#[test]
fn random_chains_there_and_back() {
    let mut random = Random(seed());
    let [chains, poses] = if full() { [10_000, 200] } else { [400, 10] };
    let mut worst = [0.0_f64; 2];
    let mut flat = 0;
    for _ in 0..chains {
        let inverse = Inverse::new(&chain(&mut random)).unwrap();
        for _ in 0..poses {
            let tip = Point3::from(random.point(500.0));
            let there = ToolPose { tip, axis: reachable(&mut random, &inverse) };
            let Some(([mm, rad], far)) = trip(&inverse, &there) else {
                flat += 1;
                continue;
            };
            // Slides on both sides of a rotary can nearly lie in one plane; they then travel far,
            // and rounding grows with how far: 1e-9 mm holds for a metre of travel.
            let mm = mm / (far / 1000.0).max(1.0);
            assert!(
                mm <= TIP && rad <= AXIS,
                "off by {mm:e} mm, {rad:e} rad: {inverse:?} {there:?}"
            );
            worst = [worst[0].max(mm), worst[1].max(rad)];
        }
    }
    println!(
        "{chains} chains of {poses} poses, {flat} with slides in one plane: worst {:.1e} mm, {:.1e} rad",
        worst[0], worst[1]
    );
    assert!(flat * 1000 < chains * poses, "{flat} poses were not tried");
}
