//! The widest strip of a bull-nose cutter from one point of a free-form surface.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::import::surface_json;
use trunnion::positioning::{LocationRequest, ToleranceBand, widest_strip};
use trunnion::surface::{Face, FaceIndex};
use trunnion::types::{Interval, Uv};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let patch = include_bytes!("../../../fixtures/bezier-patch/patch.json");
    let surface = surface_json::read(patch)?;
    let face = FaceIndex::new(Face::new(1, surface, Vec::new())?)?;
    let cutter = Cutter::new(CutterSpec::bull(10.0, 6.0))?;
    let request = LocationRequest {
        offset_range: Interval::new(-1.2, 1.2),
        ..LocationRequest::new(
            &face,
            &cutter,
            ToleranceBand { lower: 0.0, upper: 0.01 },
            Uv::new(0.4, 0.5),
            [0.0, 1.0],
        )
    };
    let location = widest_strip(&request, None)?;
    println!("strip {:.4} mm, tip {:.3?}", location.strip_width, location.pose.tip);
    assert!(location.strip_width > 5.0);
    Ok(())
}
