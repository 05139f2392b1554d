//! A check of cutter locations against a plane: one plunge of 0.05 mm is found with its line.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::nalgebra::Point3;
use trunnion::nc::read::cl;
use trunnion::surface::{Face, NurbsSurface, Surface};
use trunnion::types::Silent;
use trunnion::verify::{CheckInput, CheckOptions, DeviationTolerance, Finding, Inspection};

const LOCATIONS: &str = "\
UNITS/MM
FEDRAT/1000,MMPM
GOTO/-5,5,0.01,0,0,1
GOTO/10,5,0.01,0,0,1
GOTO/10,5,-0.05,0,0,1
GOTO/25,5,0.01,0,0,1
FINI
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let points = [0.0, 20.0].map(|x| [0.0, 10.0].map(|y| Point3::new(x, y, 0.0)).to_vec()).to_vec();
    let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let plane = Surface::Nurbs(NurbsSurface::new([1, 1], knots, points, None)?);
    let faces = [Face::new(1, plane, Vec::new())?];
    let cutter = Cutter::new(CutterSpec { length: 50.0, ..CutterSpec::flat(12.0) })?;
    let file = cl(LOCATIONS, 20)?;

    let tolerance = DeviationTolerance { excess: 0.02, gouge: 0.002 };
    let input = CheckInput::locations(&file, &cutter).faces(&faces);
    let found = Inspection::new(input, CheckOptions::of_tolerance(tolerance, 0.5)).run(&Silent)?;
    for finding in &found.report.findings {
        println!("{finding}");
    }
    let gouge = found.report.findings.iter().any(|finding| matches!(finding, Finding::Gouge(_)));
    assert!(gouge, "the plunge is a gouge");
    Ok(())
}
