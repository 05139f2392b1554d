//! Values of command-line options: numbers and short lists of them.

use trunnion::types::PoseTolerance;

/// Reads a finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a finite number is expected".into()),
    }
}

/// Reads a number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| {
        if value > 0.0 { Ok(value) } else { Err("a number above 0 is expected".into()) }
    })
}

/// Reads 0 or a number above it.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| {
        if value >= 0.0 { Ok(value) } else { Err("0 or a number above 0 is expected".into()) }
    })
}

/// Reads numbers separated by commas.
pub(crate) fn list(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(finite).collect()
}

/// Reads two numbers.
pub(crate) fn two(text: &str) -> Result<[f64; 2], String> {
    let expected = "two numbers separated by a comma are expected";
    list(text).ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| expected.to_owned())
}

/// Reads three numbers.
pub(crate) fn three(text: &str) -> Result<[f64; 3], String> {
    let expected = "three numbers separated by commas are expected";
    list(text)?.try_into().map_err(|_| expected.to_owned())
}

/// Reads three angles in degrees, as far as a job file takes them.
pub(crate) fn part_angles(text: &str) -> Result<[f64; 3], String> {
    let angles = three(text)?;
    match angles.iter().find(|angle| angle.abs() > 360.0) {
        Some(angle) => Err(format!("{angle} is not between -360 and 360 degrees")),
        None => Ok(angles),
    }
}

/// Reads the tolerances of tip \[mm\] and tool axis, in degrees; the angle is returned in rad.
pub(crate) fn pose_tolerance(text: &str) -> Result<PoseTolerance, String> {
    match text.split_once(',').map(|(tip, axis)| (positive(tip), positive(axis))) {
        Some((Ok(tip), Ok(axis))) => Ok(PoseTolerance::new(tip, axis.to_radians())),
        _ => Err("write two numbers above 0, mm and degrees, such as 0.005,0.02".to_owned()),
    }
}
