//! Forward map, inverse and jets, one pose a call, single core.
//!
//! Beside `LinuxCNC` 2.9, whose inverse maps are hand-written for one machine each and start from
//! given rotary angles (here they are found from the tool direction): `xyzab_tdr` 58 ns,
//! `5axiskins` 108 ns, `xyzac-trt` 257 ns, `xyzbc-trt` 268 ns.
//!
//! A control needs a fixed time. `spread` prints median, 99.9 % and worst of 10^6 calls one by one, with
//! the two clock reads of each, whose own figures are printed first: on a system that shares its
//! processor the worst is what others took. The line `arithmetic` is what the calls themselves need at
//! most: every pose is run 200 times between the others, its quickest run counts, and the worst is that
//! of the slowest pose. A control builder adds to that what his own system takes away.

#![expect(clippy::unwrap_used, reason = "a bench stops on surprise")]
#![expect(clippy::print_stdout, reason = "the figures are what it is for")]

#[path = "../../trunnion-motion/tests/it/chains/mod.rs"]
mod chains;

use chains::{V3, axis, slides, spec};
use divan::{Bencher, black_box};
use std::time::Instant;
use trunnion::inverse::{Branch, Inverse};
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::types::{AxisVector, PoseRates, ToolPose};

/// Poses a run goes through, so that no branch predictor learns one by heart.
const POSES: usize = 4096;
const MACHINES: [&str; 5] = [
    "C-A head",
    "A-C trunnion",
    "C table, 45 deg head",
    "skew, slides on both sides",
    "calibrated trunnion",
];

/// `LinuxCNC` 2.9, one inverse from given angles, on the machine of the first figures \[ns\].
const LINUXCNC: [(&str, f64); 4] =
    [("xyzab_tdr", 58.0), ("5axiskins", 108.0), ("xyzac-trt", 257.0), ("xyzbc-trt", 268.0)];

fn main() {
    spread();
    beside_linuxcnc();
    divan::main();
}

fn machine(name: &str) -> Kinematics {
    let z = V3::new(0.0, 0.0, -100.0);
    let (chain, first, second) = match name {
        "C-A head" => (["b", "X", "Y", "Z", "C", "A"], V3::z(), V3::x()),
        "A-C trunnion" => (["C", "A", "b", "X", "Y", "Z"], V3::z(), V3::x()),
        "C table, 45 deg head" => (["C", "b", "X", "Y", "Z", "A"], V3::z(), V3::new(0.0, 1.0, 1.0)),
        "calibrated trunnion" => {
            (["C", "A", "b", "X", "Y", "Z"], V3::new(1e-5, -2e-5, 1.0), V3::new(1.0, 3e-5, 1e-5))
        }
        _ => (["X", "C", "Y", "b", "A", "Z"], V3::new(0.1, 0.2, 1.0), V3::new(1.0, 0.2, -0.1)),
    };
    let mut axes = slides();
    axes.push(axis("C", first, Some(z)));
    axes.push(axis("A", second, Some(z * 2.0)));
    let machine = Machine::new(spec(&chain, axes, V3::zeros(), V3::z())).unwrap();
    Kinematics::new(&machine, &Setup::new(V3::new(1.0, 2.0, 3.0), [0.1, 0.2, 0.3], 120.0))
}

/// A path of the axes, away from poles and rims.
fn axes_at(index: usize) -> AxisVector {
    let t = index as f64 * 1e-2;
    AxisVector::from([100.0 * t.sin(), 80.0 * t.cos(), -50.0, t, 0.8 + 0.3 * (3.0 * t).sin()])
}

fn poses(kinematics: &Kinematics) -> Vec<(ToolPose, AxisVector)> {
    (0..POSES).map(|index| (kinematics.forward(&axes_at(index + 1)), axes_at(index))).collect()
}

/// A curved path through each pose.
fn rates(poses: &[(ToolPose, AxisVector)]) -> Vec<PoseRates> {
    poses
        .iter()
        .map(|(pose, _)| PoseRates {
            tip: [pose.tip.coords, V3::x(), V3::new(0.1, 0.0, 0.2), V3::y() * 0.01],
            axis: [*pose.axis, V3::y() * 0.02, V3::new(0.001, 0.0, 0.002), V3::y() * 1e-4],
            contact: [V3::zeros(); 4],
        })
        .collect()
}

#[divan::bench(args = MACHINES)]
fn forward(bencher: Bencher<'_, '_>, name: &str) {
    let kinematics = machine(name);
    let all: Vec<AxisVector> = (0..POSES).map(axes_at).collect();
    let mut at = 0;
    bencher.bench_local(|| {
        at = (at + 1) % POSES;
        kinematics.forward(black_box(&all[at]))
    });
}

/// Continuing a branch: from the position before.
#[divan::bench(args = MACHINES)]
fn inverse_near(bencher: Bencher<'_, '_>, name: &str) {
    let kinematics = machine(name);
    let inverse = Inverse::new(&kinematics).unwrap();
    let all = poses(&kinematics);
    let mut at = 0;
    bencher.bench_local(|| {
        at = (at + 1) % POSES;
        let (pose, near) = &all[at];
        inverse.near(black_box(pose), black_box(near)).unwrap()
    });
}

/// Value and three derivatives.
#[divan::bench(args = MACHINES)]
fn inverse_jets(bencher: Bencher<'_, '_>, name: &str) {
    let kinematics = machine(name);
    let inverse = Inverse::new(&kinematics).unwrap();
    let all = rates(&poses(&kinematics));
    let mut at = 0;
    bencher.bench_local(|| {
        at = (at + 1) % POSES;
        inverse.jets(black_box(&all[at]), Branch::Plus).unwrap()
    });
}

/// Nanoseconds a call: the median of 1000 batches of 1000, clock reads spread over a batch.
fn median_of(mut call: impl FnMut(usize)) -> f64 {
    const CALLS: usize = 1000;
    let mut times: Vec<f64> = (0..CALLS)
        .map(|batch| {
            let start = Instant::now();
            (0..CALLS).for_each(|index| call(batch * CALLS + index));
            start.elapsed().as_nanos() as f64 / CALLS as f64
        })
        .collect();
    times.sort_unstable_by(f64::total_cmp);
    times[CALLS / 2]
}

/// Every figure beside its goal, and the inverse as a ratio to each of `LinuxCNC`'s: above 1 is faster.
fn beside_linuxcnc() {
    for name in MACHINES {
        let kinematics = machine(name);
        let inverse = Inverse::new(&kinematics).unwrap();
        let all = poses(&kinematics);
        let paths = rates(&all);
        let forward = median_of(|index| {
            black_box(kinematics.forward(black_box(&all[index % POSES].1)));
        });
        let near = median_of(|index| {
            let (pose, near) = &all[index % POSES];
            black_box(inverse.near(black_box(pose), black_box(near)).ok());
        });
        let inside = median_of(|index| {
            let (pose, near) = &all[index % POSES];
            black_box(inverse.continued(black_box(pose), black_box(near)).ok());
        });
        let jets = median_of(|index| {
            black_box(inverse.jets(black_box(&paths[index % POSES]), Branch::Plus).ok());
        });
        let goal = if name.starts_with("skew") { 150 } else { 100 };
        println!(
            "{name}: forward {forward:.0} ns (goal 60), inverse {near:.0} ns (goal {goal}), inside travel {inside:.0} ns, 3-jet {jets:.0} ns (goal 600)"
        );
        let ratios = LINUXCNC.map(|(module, time)| format!("{module} {:.2}", time / near));
        println!("  LinuxCNC's inverse / this: {}", ratios.join(", "));
    }
}

/// Nanoseconds of 10^6 calls, one by one; half a million before them warm up.
fn clock(mut call: impl FnMut(usize)) -> Vec<u128> {
    const CALLS: usize = 1_000_000;
    (0..CALLS / 2).for_each(&mut call);
    let time = |index| {
        let start = Instant::now();
        call(index);
        start.elapsed().as_nanos()
    };
    (0..CALLS).map(time).collect()
}

/// What the arithmetic needs for each pose: the quickest of many runs, which are as far apart as there
/// are poses, less the quickest pair of clock reads \[ns\].
fn arithmetic(call: &mut dyn FnMut(usize)) {
    const RUNS: usize = 200;
    let once = |call: &mut dyn FnMut(usize), index: usize| {
        let start = Instant::now();
        call(index);
        start.elapsed().as_nanos()
    };
    let clock = (0..POSES * RUNS).map(|index| once(&mut |_| {}, index)).min().unwrap_or(0);
    let mut quickest = vec![u128::MAX; POSES];
    for _ in 0..RUNS {
        for (index, least) in quickest.iter_mut().enumerate() {
            *least = (*least).min(once(call, index));
        }
    }
    quickest.sort_unstable();
    let [median, most, worst] =
        [POSES / 2, POSES * 999 / 1000, POSES - 1].map(|at| quickest[at].saturating_sub(clock));
    println!(
        "    arithmetic, {POSES} poses: median {median} ns, 99.9 % {most} ns, worst {worst} ns"
    );
}

/// Median, 99.9 %, 99.99 % and worst.
fn print_times(name: &str, mut times: Vec<u128>) {
    times.sort_unstable();
    let at = |part: usize| times[(times.len() - 1) * part / 10_000];
    let [median, most, nearly, worst] = [5000, 9990, 9999, 10_000].map(at);
    println!(
        "  {name}: median {median} ns, 99.9 % {most} ns, 99.99 % {nearly} ns, worst {worst} ns"
    );
}

/// What a control has to allow for: every call on its own clock. The worst of a million is what the
/// operating system takes away in between; `clock alone` shows how much that is.
fn spread() {
    println!("one call at a time, clock reads included");
    print_times("clock alone", clock(|_| {}));
    for name in ["A-C trunnion", "skew, slides on both sides"] {
        println!("{name}");
        let kinematics = machine(name);
        let inverse = Inverse::new(&kinematics).unwrap();
        let all = poses(&kinematics);
        let paths = rates(&all);
        let one = |name: &str, call: &mut dyn FnMut(usize)| {
            print_times(name, clock(&mut *call));
            arithmetic(call);
        };
        one("forward", &mut |index| {
            black_box(kinematics.forward(black_box(&all[index % POSES].1)));
        });
        one("inverse, continuing a branch", &mut |index| {
            let (pose, near) = &all[index % POSES];
            black_box(inverse.near(black_box(pose), black_box(near)).ok());
        });
        one("inverse, inside travel", &mut |index| {
            let (pose, near) = &all[index % POSES];
            black_box(inverse.continued(black_box(pose), black_box(near)).ok());
        });
        one("3-jet", &mut |index| {
            black_box(inverse.jets(black_box(&paths[index % POSES]), Branch::Plus).ok());
        });
    }
    let others = LINUXCNC.map(|(module, time)| format!("{module} {time:.0} ns"));
    println!("LinuxCNC, inverse from given angles, mean: {}", others.join(", "));
}
