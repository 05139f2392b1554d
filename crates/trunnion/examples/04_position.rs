//! The widest strip of a bull-nose cutter from one point of a free-form surface.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::import::{Reader, surface_json::SurfaceJson};
use trunnion::positioning::{ContactSide, LocationRequest, StripSide, ToleranceBand, widest_strip};
use trunnion::surface::FaceIndex;
use trunnion::types::Silent;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let patch = include_bytes!("../../../fixtures/bezier-patch/patch.json");
    let part = SurfaceJson.read(patch, &Silent)?;
    let face = FaceIndex::new(part.faces.into_iter().next().ok_or("the part has no face")?)?;
    let cutter = Cutter::new(CutterSpec::bull(10.0, 6.0))?;
    let location = widest_strip(&LocationRequest {
        face: &face,
        cutter: &cutter,
        band: ToleranceBand { lower: 0.0, upper: 0.01 },
        at: [0.4, 0.5],
        feed: [0.0, 1.0],
        strip: StripSide::Right,
        side: ContactSide::Ahead,
        offset_range: [-1.2, 1.2],
        axis_cone: None,
    })?;
    println!("strip {:.4} mm, tip {:.3?}", location.strip_width, location.pose.tip);
    assert!(location.strip_width > 5.0);
    Ok(())
}
