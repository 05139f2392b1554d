//! The axes of a program, audited from its text.

#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::Point3;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::machine::Kinematics;
use trunnion::nc::read::{self, AxisWords, ReadOptions};
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::Silent;
use trunnion::verify::{self, CheckInput, CheckOptions, DeviationTolerance, Report};

/// A face that no tool comes near: only the axes are looked at.
fn face() -> Face {
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let point = |x: f64, y: f64| Point3::new(x, y, -9e3);
    let net = vec![vec![point(0.0, 0.0), point(0.0, 1.0)], vec![point(1.0, 0.0), point(1.0, 1.0)]];
    let surface = NurbsSurface::new([1, 1], [knots(), knots()], net, None).unwrap();
    Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
}

/// What is reported of the text: of its axes alone.
pub(crate) fn check(
    kinematics: &Kinematics,
    axes: AxisWords,
    (text, dialect): (&str, read::Dialect),
) -> Report {
    // The reference point is the machine's, not the part's.
    let text = text.replace("G91 G28 Z0.\nG90\n", "");
    let program = read::read(&text, &ReadOptions::new(dialect, axes, 5)).unwrap();
    let length = kinematics.setup().tool_length;
    let spec = CutterSpec { length, ..CutterSpec::of_radii(0.0, 3.0) };
    let (cutter, faces) = (Cutter::new(spec).unwrap(), [face()]);
    let input = CheckInput::program(&program, kinematics, &cutter).faces(&faces);
    let options = CheckOptions {
        reach: 1.0,
        ray_tolerance: 1e-3,
        most_points: 1000,
        bounds: None,
        ..CheckOptions::of_tolerance(DeviationTolerance { excess: 0.1, gouge: 0.1 }, 1.0)
    };
    verify::check(&input, &options, &Silent).unwrap()
}
