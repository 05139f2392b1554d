//! The error along the cutting circle as a curve, and its picture.

use super::Band;
use super::PositioningError;
use super::check::Look;
use super::check::Setting;
use super::circle::Circle;
use super::placement::Ring;
use super::probe::Probe;
use super::probe::Reading;
use crate::types::ToolPose;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::fmt::Write;

/// Circle of a pose and the direction across the feed, to the strip's side.
pub(super) fn ring(
    setting: &Setting,
    pose: &ToolPose,
    look: &Look,
    middle: &Reading,
) -> Result<(Ring, UnitVector3<f64>), PositioningError> {
    let no_direction = || PositioningError::NoDirection { feed: [0.0; 2], uv: look.uv };
    let v = look.feed.cross(&middle.normal()) * look.strip.sign();
    let v = UnitVector3::try_new(v, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let center = pose.tip + pose.axis.scale(setting.cutter.minor());
    let radius = setting.cutter.major();
    // A ball has no circle; its point needs no direction.
    if radius <= 0.0 {
        let [f, e2] = [Vector3::zeros(); 2];
        return Ok((Ring { center, f, e2, radius }, v));
    }
    // Angle 0 towards the contact; the side of `e2` towards the strip.
    let out = look.contact - center;
    let f = out - pose.axis.scale(pose.axis.dot(&out));
    let f = UnitVector3::try_new(f, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let e2 = pose.axis.cross(&f);
    let e2 = if e2.dot(&v) < 0.0 { -e2 } else { e2 };
    Ok((Ring { center, f: f.into_inner(), e2, radius }, v))
}

/// Error round the cutting circle: `[angle, error]` \[rad, mm\], evenly spaced over `[-pi, pi]`,
/// `2 half + 1` of them. Angle 0 lies over `look.contact`, positive ones on the strip's side.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn error_curve(
    setting: &Setting,
    pose: &ToolPose,
    look: &Look,
    half: u32,
) -> Result<Vec<[f64; 2]>, PositioningError> {
    let mut probe = Probe::new(setting.face);
    let middle = probe.read(&look.contact, look.uv)?;
    let (ring, _) = ring(setting, pose, look, &middle)?;
    let circle = Circle { ring, minor: setting.cutter.minor() };
    let seed = circle.read(0.0, middle.foot.uv, &mut probe)?;
    let step = PI / f64::from(half.max(1));
    let angles = |sign: f64| (1..=half).map(move |k| sign * step * f64::from(k));
    let mut samples = circle.walk(angles(-1.0), &seed, &mut probe)?;
    samples.reverse();
    samples.push(seed);
    samples.extend(circle.walk(angles(1.0), &seed, &mut probe)?);
    Ok(samples.iter().map(|sample| [sample.psi, sample.error]).collect())
}

/// Size of the picture and of its margins \[px\].
const SIZE: [f64; 2] = [720.0, 360.0];
const MARGINS: [f64; 2] = [64.0, 40.0];

/// Draws an error curve with its band and the angles of the strip's ends as SVG. Errors are drawn up to
/// three bands above and one below; the rest is cut off.
pub fn error_picture(curve: &[[f64; 2]], band: Band, title: &str) -> String {
    let height = band.upper - band.lower;
    let [low, high] = [band.lower - height, band.upper + 3.0 * height];
    let x = |angle: f64| MARGINS[0] + (SIZE[0] - 2.0 * MARGINS[0]) * (0.5 + 0.5 * angle / PI);
    let y = |error: f64| {
        let share = (error.clamp(low, high) - low) / (high - low);
        SIZE[1] - MARGINS[1] - (SIZE[1] - 2.0 * MARGINS[1]) * share
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        SIZE[0], SIZE[1]
    );
    let [left, right] = [x(-PI), x(PI)];
    let [top, bottom] = [y(band.upper), y(band.lower)];
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    // Writing to a String does not fail.
    let _ = writeln!(svg, "<text x=\"{left:.1}\" y=\"20\">{title}</text>");
    let _ = writeln!(
        svg,
        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#cfe8cf\"/>",
        right - left,
        bottom - top
    );
    for (error, place) in [(band.upper, top), (band.lower, bottom), (high, y(high)), (low, y(low))]
    {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{error:.4}</text>",
            left - 6.0,
            place + 4.0
        );
    }
    for degrees in [-180.0_f64, -90.0, 0.0, 90.0, 180.0] {
        let place = x(degrees.to_radians());
        let _ = writeln!(
            svg,
            "<path d=\"M{place:.1} {:.1}V{:.1}\" stroke=\"#ccc\"/><text x=\"{place:.1}\" \
             y=\"{:.1}\" text-anchor=\"middle\">{degrees}</text>",
            y(high),
            y(low),
            SIZE[1] - MARGINS[1] + 16.0
        );
    }
    let points: Vec<String> =
        curve.iter().map(|[angle, error]| format!("{:.1},{:.1}", x(*angle), y(*error))).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#124\" stroke-width=\"1.5\"/>",
        points.join(" ")
    );
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">angle on the cutting circle, deg; error \
         in mm</text>\n</svg>",
        0.5 * (left + right),
        SIZE[1] - 8.0
    );
    svg
}
