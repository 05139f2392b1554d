//! The whole chain: a surface and a job become a checked program.
#![expect(clippy::print_stdout, reason = "an example prints its result")]

use trunnion::import::surface_json;
use trunnion::surface::Face;
use trunnion::types::Silent;
use trunnion::{files, pipeline};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let job = files::job::parse(include_str!("../../../fixtures/small-patch/job.toml"))?;
    let patch = include_bytes!("../../../fixtures/small-patch/patch.json");
    let surface = surface_json::read(patch)?;
    let machine =
        files::machine::parse(include_str!("../../../machines/bc-trunnion.toml"))?.machine;

    let faces = [Face { flip: job.part.flip, ..Face::new(1, surface, Vec::new())? }];
    let job = pipeline::Job::new(job, &faces, &machine)?;
    let outcome = pipeline::run(&job, &Silent)?;
    for program in &outcome.programs {
        println!("{}: {} blocks", program.file, program.blocks.len());
        if let Some(check) = &program.check {
            println!("  {} findings at {} points", check.findings.len(), check.deviation.points);
            assert!(check.findings.is_empty());
        }
    }
    println!("{}", outcome.programs[0].text.lines().take(12).collect::<Vec<_>>().join("\n"));
    Ok(())
}
