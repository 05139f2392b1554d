//! Passes of a ball over a plane of 20 mm.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::cover::{
    CoverOptions, CoverRequest, FeedDirection, FinishTolerance, PlacementMethod, cover,
};
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::nalgebra::Point3;
use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
use trunnion::types::Silent;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let points = [0.0, 20.0].map(|x| [0.0, 20.0].map(|y| Point3::new(x, y, 0.0)).to_vec()).to_vec();
    let knots = [vec![0.0, 0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let plane = Surface::Nurbs(NurbsSurface::new([1, 1], knots, points, None)?);
    let faces = [FaceIndex::new(Face::new(1, plane, Vec::new())?)?];

    let cutter = Cutter::new(CutterSpec { length: 60.0, ..CutterSpec::ball(10.0) })?;
    let options = CoverOptions {
        feed_direction: FeedDirection::U,
        method: PlacementMethod::Inclined,
        ..CoverOptions::finishing(&cutter, FinishTolerance { excess: 0.1, gouge: 0.01 })
    };
    let covering = cover(&CoverRequest::new(&faces, &cutter, &options), &Silent)?;
    println!(
        "{} passes, unfinished regions: {}",
        covering.passes.len(),
        covering.report.rest.len()
    );
    // A cusp of 0.1 mm between passes of a ball of radius 5 mm: strips of 2 mm.
    assert!((10..=13).contains(&covering.passes.len()));
    Ok(())
}
