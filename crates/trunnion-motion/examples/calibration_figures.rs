//! Calibration of random machines: 13 errors from 40 sphere centres with 1 um of noise.
//!
//! ```text
//! cargo run --release -p trunnion-motion --example calibration_figures [MACHINES]
//! ```

#![expect(clippy::print_stdout, reason = "the example prints its figures")]

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use trunnion_motion::calibrate::{CalibrationOptions, CalibrationReport, SphereReading, calibrate};
use trunnion_motion::machine::{AxisSpec, Kinematics, Machine, MachineSpec, Setup};
use trunnion_motion::types::AxisVector;

/// Standard deviation of every coordinate \[mm\].
const NOISE: f64 = 0.001;

/// Lengths of the two probes \[mm\]: the tilt of the tool axis shows by their difference.
const LENGTHS: [f64; 2] = [100.0, 350.0];

/// Errors of the built machines \[mm, rad\].
const BUILT: [f64; 2] = [0.1, 5e-4];

/// Worst errors of one calibration \[mm, rad\].
type Worst = [f64; 2];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machines = std::env::args().nth(1).map_or(Ok(1000), |word| word.parse())?;
    let mut worst: Vec<Worst> = Vec::new();
    for seed in 0..machines {
        let (errors, _) = errors(seed)?;
        worst.push(errors);
    }
    println!("{machines} machines, 40 sphere centres each, noise {} um", NOISE * 1e3);
    for (kind, unit) in [("offset", "um"), ("angle", "urad")].into_iter().enumerate() {
        let scale = if kind == 0 { 1e3 } else { 1e6 };
        let mut all: Vec<f64> = worst.iter().map(|one| one[kind] * scale).collect();
        all.sort_by(f64::total_cmp);
        let share = |part: usize| {
            all.get((all.len() * part / 100).min(all.len() - 1)).copied().unwrap_or(f64::NAN)
        };
        println!(
            "worst {} of a machine: median {:.2} {}, 95 % {:.2}, most {:.2}",
            unit.0,
            share(50),
            unit.1,
            share(95),
            share(100)
        );
    }
    Ok(())
}

/// Calibrates one random machine; returns the largest error of the result, and the report.
fn errors(seed: u64) -> Result<(Worst, CalibrationReport), Box<dyn std::error::Error>> {
    let mut dice = Dice(seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1));
    let ideal = machine(seed, &mut dice);
    let real = Machine::new(built(&ideal, &mut dice))?;
    let readings = readings(&real, &mut dice)?;
    let report = calibrate(&Machine::new(ideal)?, &readings, CalibrationOptions::standard())?;
    let mut worst = [0.0_f64; 2];
    for (found, real) in report.machine.axes.iter().zip(&real.axes) {
        // An offset along the line of an axis is none.
        let apart = found.point - real.point;
        worst[0] = worst[0].max((apart - real.dir.scale(real.dir.dot(&apart))).amax());
        worst[1] = worst[1].max(found.dir.cross(&real.dir).amax());
    }
    worst[1] = worst[1].max(report.machine.tool_axis.cross(&real.tool_axis).amax());
    assert!(report.estimates.iter().all(|one| one.uncertainty.is_some()));
    Ok((worst, report))
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
fn readings(
    real: &Machine,
    dice: &mut Dice,
) -> Result<Vec<SphereReading>, Box<dyn std::error::Error>> {
    // Far from the line of C, where squareness shows, at two heights.
    let [.., c, _] = &real.axes;
    let mut sphere = |height: f64| {
        let turn = TAU * dice.share();
        c.point.coords + Vector3::new(240.0 * turn.cos(), 240.0 * turn.sin(), height)
    };
    let spheres = [sphere(50.0), sphere(250.0)];
    (0..40)
        .map(|index: usize| {
            let length = LENGTHS[index % 2];
            let sphere = index / 2 % 2;
            let setup = Setup { tool_length: length, ..Setup::default() };
            let kinematics = Kinematics::new(real, &setup);
            let turn = TAU * index as f64 / 40.0;
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
    use trunnion_motion::calibrate::DeviationKind;

    /// The figures that are promised, and uncertainties that describe the errors.
    #[test]
    fn thirteen_errors_from_forty_spheres() {
        for seed in 0..300 {
            let ([offset, angle], report) =
                errors(seed).unwrap_or_else(|error| panic!("{seed}: {error}"));
            assert!(offset <= 0.003 && angle <= 10e-6, "{seed}: {offset} mm, {angle} rad");
            assert!((0.0006..0.0015).contains(&report.noise), "{seed}: {}", report.noise);
            for one in &report.estimates {
                let most = if one.deviation.kind == DeviationKind::Offset { 0.0015 } else { 5e-6 };
                assert!(one.uncertainty.is_some_and(|by| by > 0.0 && by < most), "{seed}: {one:?}");
            }
        }
    }
}
