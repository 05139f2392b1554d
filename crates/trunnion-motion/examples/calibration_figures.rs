//! Calibration of random machines: 13 errors from 40 sphere centres with 1 um of noise, and a part that is made with the
//! wrong file, measured, and made anew.
//!
//! ```text
//! cargo run --release -p trunnion-motion --example calibration_figures [MACHINES]
//! ```
//!
//! No estimator without bias has a smaller variance than the inverse of the information in the readings (Cramer and Rao). The
//! example prints that bound beside the errors: where both agree, only other readings help. The tilt of the tool axis shows
//! as the difference between both probes alone, so it is known to no better than `2 noise / (difference sqrt(readings))`.

#![expect(clippy::print_stdout, reason = "the example prints its figures")]

use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use trunnion_motion::calibrate::{
    CHAIN_DEVIATIONS, CalibrationOptions, CalibrationReport, ChainDeviation, DeviationEstimate,
    DeviationKind, SphereReading, calibrate,
};
use trunnion_motion::inverse::Inverse;
use trunnion_motion::machine::{AxisSpec, Kinematics, Machine, MachineSpec, Setup};
use trunnion_motion::types::{AxisVector, ToolPose};

/// Standard deviation of every coordinate \[mm\].
const NOISE: f64 = 0.001;

/// Lengths of the two probes \[mm\]: the tilt of the tool axis shows by their difference.
const LENGTHS: [f64; 2] = [100.0, 350.0];

/// Errors of the built machines \[mm, rad\].
const BUILT: [f64; 2] = [0.1, 5e-4];

/// Readings of one calibration.
const READINGS: usize = 40;

/// Locations of the part that is made with the file, and anew.
const LOCATIONS: usize = 60;

/// Inclination of the tool over the part \[rad\]: a machine out of square does not reach the pole itself.
const INCLINED: [f64; 2] = [0.02, 1.0];

type Failure = Box<dyn std::error::Error>;

/// One random machine.
struct Trial {
    /// Largest error of the result \[mm, rad\].
    worst: [f64; 2],
    /// The result, its noise from the residuals.
    #[cfg_attr(not(test), expect(dead_code, reason = "the test looks at its uncertainties"))]
    report: CalibrationReport,
    /// Largest standard uncertainty by the bound \[mm, rad\].
    bound: [f64; 2],
    /// Sum of the squares of all errors over their uncertainties, and the number of errors.
    squares: f64,
    /// Worst error of the tip \[mm\] by the file, and by the calibrated file.
    tip: [f64; 2],
}

fn main() -> Result<(), Failure> {
    let machines: u64 = std::env::args().nth(1).map_or(Ok(1000), |word| word.parse())?;
    let trials: Result<Vec<Trial>, Failure> = (0..machines).map(trial).collect();
    let trials = trials?;
    println!("{machines} machines, {READINGS} sphere centres each, noise {} um", NOISE * 1e3);
    for (kind, unit) in [("offset", "um"), ("angle", "urad")].into_iter().enumerate() {
        let scale = if kind == 0 { 1e3 } else { 1e6 };
        print_spread(
            &format!("worst {} of a machine, {}", unit.0, unit.1),
            trials.iter().map(|one| one.worst[kind] * scale),
        );
        print_spread(
            "  its standard uncertainty by the bound",
            trials.iter().map(|one| one.bound[kind] * scale),
        );
    }
    let within = |offset: f64, angle: f64| {
        trials.iter().filter(|one| one.worst[0] <= offset && one.worst[1] <= angle).count()
    };
    println!(
        "machines with all errors within 3 um and 10 urad: {}, within 1 um and 3 urad: {}",
        within(0.003, 10e-6),
        within(0.001, 3e-6)
    );
    let errors = trials.len() * CHAIN_DEVIATIONS;
    let squares: f64 = trials.iter().map(|one| one.squares).sum();
    println!(
        "rms of the errors over their uncertainty by the bound: {:.3} (1: no estimator is better)",
        (squares / errors as f64).sqrt()
    );
    let [short, long] = LENGTHS;
    println!(
        "tilt of the tool axis, at best: {:.2} urad from a difference of {} mm",
        2e6 * NOISE / ((long - short) * (READINGS as f64).sqrt()),
        long - short
    );
    let factor = |one: &Trial| one.tip[0] / one.tip[1];
    print_spread("worst tip error with the file, um", trials.iter().map(|one| one.tip[0] * 1e3));
    print_spread("  with the calibrated file, um", trials.iter().map(|one| one.tip[1] * 1e3));
    print_spread("  times smaller", trials.iter().map(factor));
    println!(
        "  at least 50 times smaller: {} of {machines}",
        trials.iter().filter(|one| factor(one) >= 50.0).count()
    );
    Ok(())
}

fn print_spread(what: &str, values: impl Iterator<Item = f64>) {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    let share = |part: usize| {
        all.get((all.len() * part / 100).min(all.len() - 1)).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{what}: least {:.2}, median {:.2}, 95 % {:.2}, most {:.2}",
        share(0),
        share(50),
        share(95),
        share(100)
    );
}

/// Calibrates one random machine, and makes a part on it before and after.
fn trial(seed: u64) -> Result<Trial, Failure> {
    let mut dice = Dice(seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1));
    let ideal = machine(seed, &mut dice);
    let real = Machine::new(built(&ideal, &mut dice))?;
    let readings = readings(&real, &mut dice)?;
    let ideal = Machine::new(ideal)?;
    let report = calibrate(&ideal, &readings, CalibrationOptions::standard())?;
    let mut worst = [0.0_f64; 2];
    for (found, real) in report.machine.axes.iter().zip(&real.axes) {
        // An offset along the line of an axis is none.
        let apart = found.point - real.point;
        worst[0] = worst[0].max((apart - real.dir.scale(real.dir.dot(&apart))).amax());
        worst[1] = worst[1].max(found.dir.cross(&real.dir).amax());
    }
    worst[1] = worst[1].max(report.machine.tool_axis.cross(&real.tool_axis).amax());
    // The deviations that no noise at all would give: the readings are not needed for the real machine.
    let options = CalibrationOptions { noise: Some(NOISE), ..CalibrationOptions::standard() };
    let bounded = calibrate(&ideal, &readings, options)?;
    let exact = exact_deviations(&ideal, &real, &bounded);
    let mut bound = [0.0_f64; 2];
    let mut squares = 0.0;
    for (estimate, exact) in bounded.estimates.iter().zip(exact) {
        let sigma = estimate.uncertainty.ok_or("the readings leave a deviation open")?;
        let kind = usize::from(estimate.deviation.kind == DeviationKind::Tilt);
        bound[kind] = bound[kind].max(sigma);
        squares += ((estimate.value - exact) / sigma).powi(2);
    }
    let tip = tip_errors(&ideal, &real, &report.machine, &mut dice)?;
    Ok(Trial { worst, report, bound, squares, tip })
}

/// Returns the deviations of the real machine, in the order of the report.
fn exact_deviations(ideal: &Machine, real: &Machine, report: &CalibrationReport) -> Vec<f64> {
    let exact = |estimate: &DeviationEstimate| {
        let ChainDeviation { kind, axis, direction } = estimate.deviation;
        // The other direction of the same line.
        let same = |other: &&DeviationEstimate| {
            let other = other.deviation;
            other.kind == kind && other.axis == axis && other.direction != direction
        };
        let other = report.estimates.iter().find(same).map(|other| other.deviation.direction);
        let lines = [ideal, real].map(|machine| match axis.and_then(|at| machine.axes.get(at)) {
            Some(axis) => (axis.dir.into_inner(), axis.point),
            None => (machine.tool_axis.into_inner(), Point3::origin()),
        });
        let [(from, place), (to, there)] = lines;
        let one = direction.into_inner();
        let other = other.map_or_else(|| from.cross(&one), UnitVector3::into_inner);
        match kind {
            // `to` is along `from + a (one x from) + b (other x from)`.
            DeviationKind::Tilt => {
                let columns = [from, one.cross(&from), other.cross(&from)];
                let parts = Matrix3::from_columns(&columns).try_inverse().map(|parts| parts * to);
                parts.map_or(f64::NAN, |parts| parts.y / parts.x)
            }
            // The point of the line in the plane of both directions.
            DeviationKind::Offset => {
                let (apart, normal) = (there - place, one.cross(&other));
                (apart - to * (apart.dot(&normal) / to.dot(&normal))).dot(&one)
            }
        }
    };
    report.estimates.iter().map(exact).collect()
}

/// Returns the worst tip error on the real machine of a part for the ideal one, and for the calibrated one.
fn tip_errors(
    ideal: &Machine,
    real: &Machine,
    calibrated: &Machine,
    dice: &mut Dice,
) -> Result<[f64; 2], Failure> {
    let [.., c, _] = &ideal.axes;
    let setup = Setup::new(c.point.coords + Vector3::z() * 60.0, [0.0; 3], 120.0);
    let runs = Kinematics::new(real, &setup);
    let mut worst = [0.0_f64; 2];
    for (file, worst) in [ideal, calibrated].into_iter().zip(&mut worst) {
        let inverse = Inverse::new(&Kinematics::new(file, &setup))?;
        let mut dice = dice.clone();
        for _ in 0..LOCATIONS {
            let lean = INCLINED[0] + (INCLINED[1] - INCLINED[0]) * dice.share();
            let turn = TAU * dice.share();
            let axis = [lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos()];
            let tip = dice.point(100.0);
            let pose = ToolPose::new(tip.into(), axis).ok_or("a direction without length")?;
            let q = inverse.near(&pose, &file.home())?;
            *worst = worst.max((runs.forward(&q).tip.coords - tip).norm());
        }
    }
    Ok(worst)
}

/// Returns a machine as its maker means it: three arrangements, pivots anywhere.
fn machine(seed: u64, dice: &mut Dice) -> MachineSpec {
    let pivot = dice.point(300.0).into();
    // The pivot of a head stands above its nose.
    let above = if seed.is_multiple_of(3) { 0.0 } else { 250.0 };
    let other = (dice.point(if above > 0.0 { 50.0 } else { 300.0 }) + Vector3::z() * above).into();
    let (chain, second) = match seed % 3 {
        0 => (["w", "C", "B", "b", "X", "Y", "Z", "t"], [0.0, 1.0, 0.0]),
        1 => (["w", "C", "X", "b", "Y", "Z", "B", "t"], [0.0, 1.0, 0.0]),
        _ => (["w", "Y", "b", "X", "Z", "C", "B", "t"], [0.0, -1.0, 1.0]),
    };
    let mut axes: Vec<AxisSpec> =
        [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])]
            .into_iter()
            .map(|(name, dir)| AxisSpec::linear(name, dir))
            .collect();
    axes.push(AxisSpec::rotary("C", [0.0, 0.0, 1.0], pivot));
    axes.push(AxisSpec::rotary("B", second, other));
    MachineSpec::new("random", &chain, axes)
}

/// Returns the machine as it is built: X and the spindle nose define the frame, all else is off.
fn built(ideal: &MachineSpec, dice: &mut Dice) -> MachineSpec {
    let [offset, tilt] = BUILT;
    let mut real = ideal.clone();
    for axis in real.axes.iter_mut().skip(1) {
        let turn =
            if axis.name == "Y" { Vector3::z() * dice.within(tilt) } else { dice.point(tilt) };
        let dir = Vector3::from(axis.dir);
        axis.dir = (dir + turn.cross(&dir)).into();
        axis.point = axis.point.map(|point| (Vector3::from(point) + dice.point(offset)).into());
    }
    let tool = Vector3::from(real.tool_axis);
    real.tool_axis = (tool + dice.point(tilt).cross(&tool)).into();
    real
}

/// Returns forty noisy readings of two spheres with two probes.
fn readings(real: &Machine, dice: &mut Dice) -> Result<Vec<SphereReading>, Failure> {
    // Far from the line of C, where squareness shows, at two heights.
    let [.., c, _] = &real.axes;
    let mut sphere = |height: f64| {
        let turn = TAU * dice.share();
        c.point.coords + Vector3::new(240.0 * turn.cos(), 240.0 * turn.sin(), height)
    };
    let spheres = [sphere(50.0), sphere(250.0)];
    (0..READINGS)
        .map(|index: usize| {
            let length = LENGTHS[index % 2];
            let sphere = index / 2 % 2;
            let setup = Setup { tool_length: length, ..Setup::default() };
            let kinematics = Kinematics::new(real, &setup);
            let turn = TAU * index as f64 / READINGS as f64;
            // Every turn of C meets another tilt.
            let tilt = FRAC_PI_2 * ((index * 17 % 40) as f64 / 19.5 - 1.0);
            let mut q = AxisVector::from([0.0, 0.0, 0.0, turn, tilt]);
            let linear = Matrix3::from_columns(&kinematics.tip_levers(&q).linear);
            let way = spheres[sphere] - kinematics.forward(&q).tip.coords;
            let linear = linear.try_inverse().ok_or("linear axes in a plane")? * way;
            for axis in 0..3 {
                q[axis] = linear[axis] + NOISE * dice.normal();
            }
            Ok(SphereReading::center(q, length, sphere))
        })
        .collect()
}

/// Steele, Lea and Flood's splitmix64.
#[derive(Clone)]
struct Dice(u64);

impl Dice {
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, size: f64) -> f64 {
        size * (2.0 * self.share() - 1.0)
    }

    fn point(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(size))
    }

    /// Normal distribution, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.share()).ln()).sqrt();
        radius * (TAU * self.share()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The figures that are promised, uncertainties that describe the errors, and a part that is fifty times nearer.
    #[test]
    fn thirteen_errors_from_forty_spheres() {
        let (mut squares, mut errors) = (0.0, 0.0);
        for seed in 0..300 {
            let Trial { worst: [offset, angle], report, tip, squares: more, .. } =
                trial(seed).unwrap_or_else(|error| panic!("{seed}: {error}"));
            assert!(offset <= 0.003 && angle <= 10e-6, "{seed}: {offset} mm, {angle} rad");
            assert!((0.0006..0.0015).contains(&report.noise), "{seed}: {}", report.noise);
            for one in &report.estimates {
                let most = if one.deviation.kind == DeviationKind::Offset { 0.0015 } else { 5e-6 };
                assert!(one.uncertainty.is_some_and(|by| by > 0.0 && by < most), "{seed}: {one:?}");
            }
            assert!(tip[1] * 50.0 < tip[0], "{seed}: {tip:?}");
            squares += more;
            errors += CHAIN_DEVIATIONS as f64;
        }
        // 3900 errors: their mean square is within 0.05 of its expectation but for one in 10^5.
        let mean: f64 = squares / errors;
        assert!((mean - 1.0).abs() < 0.1, "{mean}");
    }
}
